/* SPDX-License-Identifier: MIT
 * linear.c - a mechanism linearised about a state (linear.h): memory, and whether the state is one
 * to linearise about.
 */
#include <math.h>
#include <string.h>

#include "functions.h"
#include "linear.h"

/* ---- memory ---- */

static size_t layout(stein_linear *l, const stein_model *m)
{
    stein_linear measured = {.model = m};
    stein__arena a = {(unsigned char *)l, 0};
    int n = m->nq, ny = m->nchannel, nu = m->ninput, size = n + ny;
    int longest = 2 * n > m->nrow ? 2 * n : m->nrow;
    l = l != NULL ? l : &measured;
    stein__carve(&a, sizeof *l);
    const struct {
        double **at;
        int n;
    } numbers[] = {{&l->A, 4 * n * n},
                   {&l->B, 2 * n * nu},
                   {&l->C, ny * 2 * n},
                   {&l->D, ny * nu},
                   {&l->T, n * n},
                   {&l->mass, n * n},
                   {&l->W, n * n},
                   {&l->M, n * n},
                   {&l->c, n},
                   {&l->factor, n * n},
                   {&l->q, n},
                   {&l->qd, n},
                   {&l->kept, 2 * n},
                   {&l->force, n},
                   {&l->product, n * n},
                   {&l->K, n * n},
                   {&l->slope, size},
                   {&l->off, size},
                   {&l->by_q, n * n},
                   {&l->by_qd, n * n},
                   {&l->row, longest},
                   {&l->points, m->npoint * (9 + 3 * n)},
                   {&l->table, stein__linear_levels() * size}};
    int **const whole[] = {&l->joint, &l->motion, &l->pivot};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        *numbers[i].at = stein__carve_doubles(&a, numbers[i].n);
    }
    for (size_t i = 0; i < sizeof whole / sizeof *whole; i++) {
        *whole[i] = stein__carve(&a, sizeof **whole * (size_t)n);
    }
    l->input = stein__carve(&a, sizeof *l->input * (size_t)nu);
    l->signal = stein__carve(&a, sizeof *l->signal * (size_t)nu);
    l->still = stein__carve(&a, (size_t)n);
    l->differences = stein__carve(&a, (size_t)ny);
    int edges = m->ncontact + m->nnotch + m->nlimit + n;
    l->edge = stein__carve(&a, sizeof *l->edge * (size_t)edges);
    l->slopes = stein__carve(&a, stein__derivative_size(m));
    return a.used;
}

stein_status stein_linear_create(stein_linear **out, const stein_model *model,
                                 const stein_sim_def *def, stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    size_t size = layout(NULL, model);
    stein_linear *l = own.alloc(own.ctx, size);
    if (l == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory to linearise \"%s\"", model->name);
    }
    memset(l, 0, size);
    (void)layout(l, model);
    l->model = model;
    l->def = own;
    l->slopes = stein__derivative_size(model) > 0 ? stein__derivative_make(l->slopes, model) : NULL;
    *out = l;
    return STEIN_OK;
}

void stein_linear_destroy(stein_linear *l)
{
    if (l != NULL) {
        l->def.release(l->def.ctx, l);
    }
}

/* ---- the state ---- */

static const char *unit_of(const stein_model *model, int j)
{
    return model->bodies[j].type == 'R' ? "rad/s^2" : "m/s^2";
}

static void find_residual(stein_linear *l)
{
    const double *qdd = l->sim->qdd;
    l->system.residual = 0.0;
    l->system.worst = l->joint[0];
    for (int j = 0; j < l->model->nq; j++) {
        if (!(fabs(qdd[j]) <= l->system.residual)) {
            l->system.residual = fabs(qdd[j]);
            l->system.worst = j;
        }
    }
}

/* An acceleration may be what a small displacement makes of it, and so may its rate. A of dependent
 * joints is that of what they depend on. */
static stein_status check_rest(const stein_linear *l, stein_err *err)
{
    const stein_model *model = l->model;
    int n = l->system.n, worst = l->system.worst;
    double stiff = 0.0, speed = 0.0;
    for (int j = 0; j < n; j++) {
        speed = fmax(speed, fabs(l->qd[l->joint[j]]));
    }
    for (int i = 0; i < n; i++) {
        double sum = 0.0, rate = 0.0;
        for (int j = 0; j < n; j++) {
            double a = l->A[(n + i) * 2 * n + j];
            sum += fabs(a);
            rate += a * l->qd[l->joint[j]];
        }
        stiff = fmax(stiff, sum);
        if (fabs(rate) > STEIN_LINEAR_STEADY * speed * (1.0 + sum)) {
            return stein__fail(err, STEIN_ESETTLE,
                               "\"%s\" moves unsteadily: the acceleration of \"%s\" changes by %g "
                               "%s a second; expected a state at rest or a steady motion",
                               model->name, model->bodies[l->joint[i]].name, rate,
                               unit_of(model, l->joint[i]));
        }
    }
    double most = STEIN_LINEAR_ACCELERATION + STEIN_LINEAR_SHIFT * stiff;
    if (!(l->system.residual <= most)) {
        return stein__fail(err, STEIN_ESETTLE,
                           "\"%s\" is not in equilibrium: \"%s\" accelerates with %g %s in this "
                           "state, expected %g at most",
                           model->name, model->bodies[worst].name, l->sim->qdd[worst],
                           unit_of(model, worst), most);
    }
    return STEIN_OK;
}

static const char *why_not(const stein_linear *l)
{
    const stein_model *model = l->model;
    return model->nrow > 0          ? "it has loops or couplings"
           : stein__in_space(model) ? "it has bodies that turn in all directions, or contacts in "
                                      "space"
           : model->nstick > 0      ? "it has friction that sticks"
           : l->sim->on_force       ? "a hook adds forces"
           : l->slopes == NULL      ? "its equations came without derivatives"
                                    : NULL;
}

static stein_status begin(stein_linear *l, stein_err *err)
{
    stein_sim *sim = l->sim;
    size_t bytes = sizeof *l->q * (size_t)l->model->nq;
    stein_status status = stein__refresh(sim, err);
    if (status != STEIN_OK) {
        return status;
    }
    memcpy(l->kept, sim->q, bytes);
    memcpy(l->kept + l->model->nq, sim->qd, bytes);
    memcpy(l->q, sim->xq, bytes);
    memcpy(l->qd, sim->xqd, bytes);
    stein__linear_edges(l);
    status = stein__linear_joints(l, err);
    if (status == STEIN_OK) {
        stein__linear_coordinates(l);
    }
    if (status == STEIN_OK && l->system.nfree == 0) {
        status = stein__fail(err, STEIN_EINVAL, "\"%s\": nothing can move in this state",
                             l->model->name);
    }
    return status;
}

static void show(stein_linear *l)
{
    stein_linear_system *to = &l->system;
    to->noutput = l->model->nchannel;
    to->joint = l->joint;
    to->input = l->input;
    to->A = l->A;
    to->B = l->B;
    to->C = l->C;
    to->D = l->D;
    to->T = l->T;
    to->mass = l->mass;
    to->differences = l->differences;
    to->edge = l->edge;
}

stein_status stein_linear_at(stein_linear *l, stein_sim *sim, const stein_linear_system **system,
                             stein_err *err)
{
    if (sim->model != l->model) {
        return stein__fail(err, STEIN_EINVAL,
                           "\"%s\" was to be linearised in a simulation of other equations "
                           "(\"%s\")",
                           l->model->name, sim->model->name);
    }
    l->sim = sim;
    stein_status status = begin(l, err);
    if (status != STEIN_OK) {
        return status;
    }
    find_residual(l);
    l->system.why = why_not(l);
    l->system.exact = l->system.why == NULL;
    status = stein__linear_matrices(l, err);
    status = status == STEIN_OK ? check_rest(l, err) : status;
    status = status == STEIN_OK ? stein__linear_outputs(l, err) : status;
    if (status == STEIN_OK) {
        show(l);
        *system = &l->system;
    }
    return status;
}
