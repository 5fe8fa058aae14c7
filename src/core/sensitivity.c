/* SPDX-License-Identifier: MIT
 * sensitivity.c - directions that follow a simulation (sensitivity.h).
 *
 * A step is carried on after it was taken: the stages' derivatives k_i are still there, so the
 * stages are too,
 *
 *      y_i = y_0 + h sum of a_ij k_j      dy_i = dy_0 + h sum of a_ij dk_j
 *      dk_i = {dqd_i, A_q dq_i + A_qd dqd_i + A_p dp}
 *
 * with the derivatives A of qdd at y_i. That is the derivative of the step as it is computed.
 */
#include <math.h>
#include <string.h>

#include "slopes.h"
#include "stein/sensitivity.h"

enum { STAGES = 6 };

/** One direction. */
typedef struct direction {
    double *dy; /* [2*nq] {dq, dqd} */
    double *dp; /* [np] */
    stein__constants dd;
    double *stage;  /* [2*nq] dy_i */
    double *dk;     /* [STAGES][2*nq] */
    double instant; /* of the last switch */
} direction;

struct stein_sensitivity {
    const stein_model *model;
    stein_sim_def def;
    stein_sim *sim;
    stein_derivative *slopes;
    stein_err err;
    int n;
    unsigned taken;        /* as of when the directions' constants are */
    direction *way;        /* [n] */
    double *y;             /* [2*nq] */
    double *by_q, *by_qd;  /* [nq*nq] */
    double *by_p;          /* [nq] */
    double *before;        /* [nq] qdd before a switch */
    double *dguard, *rate; /* [nguard] along a direction, along the motion */
};

static size_t layout(stein_sensitivity *s, const stein_model *m, int n)
{
    stein_sensitivity measured = {.way = NULL};
    stein__arena a = {(unsigned char *)s, 0};
    int nq = m->nq, nguard = m->nspot + NOTCH_GUARDS * m->nnotch;
    s = s != NULL ? s : &measured;
    stein__carve(&a, sizeof *s);
    s->y = stein__carve_doubles(&a, 2 * nq);
    s->by_q = stein__carve_doubles(&a, nq * nq);
    s->by_qd = stein__carve_doubles(&a, nq * nq);
    s->by_p = stein__carve_doubles(&a, nq);
    s->before = stein__carve_doubles(&a, nq);
    s->dguard = stein__carve_doubles(&a, nguard);
    s->rate = stein__carve_doubles(&a, nguard);
    direction *way = s->way = stein__carve(&a, sizeof *way * (size_t)n);
    for (int k = 0; k < n; k++) {
        direction w = {.dy = stein__carve_doubles(&a, 2 * nq),
                       .dp = stein__carve_doubles(&a, m->np),
                       .dd = stein__carve_constants(&a, m),
                       .stage = stein__carve_doubles(&a, 2 * nq),
                       .dk = stein__carve_doubles(&a, STAGES * 2 * nq)};
        if (way != NULL) {
            way[k] = w;
        }
    }
    return a.used;
}

stein_status stein_sensitivity_create(stein_sensitivity **out, const stein_model *model,
                                      const stein_sim_def *def, int n, stein_err *err)
{
    stein_sim_def own;
    stein_derivative *slopes = NULL;
    if (n < 1) {
        return stein__fail(err, STEIN_EINVAL, "%d directions: expected at least one", n);
    }
    stein_status status = stein__take_def(&own, model, def, err);
    status = status == STEIN_OK ? stein_derivative_create(&slopes, model, &own, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    size_t size = layout(NULL, model, n);
    stein_sensitivity *s = own.alloc(own.ctx, size);
    if (s == NULL) {
        stein_derivative_destroy(slopes);
        return stein__fail(err, STEIN_ENOMEM, "out of memory for sensitivities of \"%s\"",
                           model->name);
    }
    memset(s, 0, size);
    (void)layout(s, model, n);
    s->model = model;
    s->def = own;
    s->slopes = slopes;
    s->n = n;
    *out = s;
    return STEIN_OK;
}

/* ---- a step ---- */

static int is_well(const stein_sensitivity *s)
{
    return s->err.code == STEIN_OK;
}

/* the first trouble stays */
static void trouble(stein_sensitivity *s, const stein_err *err)
{
    s->err = is_well(s) ? *err : s->err;
}

/* derivatives at a state of the simulation, whose memory is that of the step */
static int derive_at(stein_sensitivity *s, double t, const double *q, const double *qd, double *qdd)
{
    stein_err err = {STEIN_OK, ""};
    if (s->sim->signals) {
        stein__fail(&err, STEIN_EINVAL,
                    "\"%s\": no sensitivity of a motion with a signal at an input", s->model->name);
    } else if (stein_derivative_at(s->slopes, s->sim, t, q, qd, qdd, &err) == STEIN_OK) {
        return 1;
    }
    trouble(s, &err);
    return 0;
}

/* y = y0 + h sum of w_j k_j, n terms that lie `apart` from each other */
static void combine(int size, double *y, const double *y0, double h, const double *w, int n,
                    const double *k, int apart)
{
    for (int i = 0; i < size; i++) {
        double sum = 0.0;
        for (int j = 0; j < n; j++) {
            sum += w[j] * k[j * apart + i];
        }
        y[i] = y0[i] + h * sum;
    }
}

/* dk = {dqd, dqdd} of a direction whose state is dy */
static void rate_of(const stein_sensitivity *s, const direction *way, const double *dy, double *dk)
{
    int n = s->model->nq, all = way->dd.n == 0;
    memset(dk + n, 0, sizeof *dk * (size_t)n);
    if (!all) { // in one go with the state
        stein__along(s->slopes, dy, dy + n, &way->dd, dk + n);
    }
    for (int i = 0; i < n; i++) {
        dk[i] = dy[n + i];
        for (int j = 0; all && j < n; j++) {
            dk[n + i] += s->by_q[i * n + j] * dy[j] + s->by_qd[i * n + j] * dy[n + j];
        }
    }
}

/* is there a direction without parameters? */
static int has_state(const stein_sensitivity *s)
{
    int found = 0;
    for (int k = 0; k < s->n; k++) {
        found |= s->way[k].dd.n == 0;
    }
    return found;
}

/* parameters have changed on the way: what they make of directions has, too */
static void renew(stein_sensitivity *s)
{
    for (int k = 0; s->taken != s->sim->taken && k < s->n; k++) {
        stein__constants_along(s->slopes, s->way[k].dp, &s->way[k].dd);
    }
    s->taken = s->sim->taken;
}

/* after a step of h has been accepted */
static void carry(void *ctx, stein_sim *sim, double h)
{
    stein_sensitivity *s = ctx;
    int size = 2 * s->model->nq, stages = stein__stages(sim->def.integrator);
    for (int i = 0; is_well(s) && i < stages; i++) {
        const double *a = stein__weights(sim->def.integrator, i);
        combine(size, s->y, sim->y0, h, a, i, sim->k, sim->stride);
        if (!derive_at(s, sim->head->t, s->y, s->y + s->model->nq, NULL)) {
            return;
        }
        renew(s);
        if (has_state(s)) {
            stein_derivative_by_state(s->slopes, s->by_q, s->by_qd);
        }
        for (int k = 0; k < s->n; k++) {
            direction *way = &s->way[k];
            combine(size, way->stage, way->dy, h, a, i, way->dk, size);
            rate_of(s, way, way->stage, way->dk + i * size);
        }
    }
    const double *b = stein__weights(sim->def.integrator, stages);
    for (int k = 0; is_well(s) && k < s->n; k++) {
        direction *way = &s->way[k];
        combine(size, way->dy, way->dy, h, b, stages, way->dk, size);
    }
    // what is read of the simulation is of its state again
    (void)stein__evaluate(sim, sim->head->t, sim->q, sim->qd, s->by_p, NULL);
    sim->fresh = FRESH;
}

/* ---- a switch ---- */

/* the guard that switches here, the one that is passed fastest; -1: none */
static int switching(const stein_sensitivity *s)
{
    int found = -1;
    for (int i = 0; i < s->sim->nguard; i++) {
        if (s->sim->crossed[i] && (found < 0 || fabs(s->rate[i]) > fabs(s->rate[found]))) {
            found = i;
        }
    }
    return found;
}

/* how the instant moves with all directions, while the guards are as they were */
static void find_instants(stein_sensitivity *s)
{
    int nq = s->model->nq;
    memcpy(s->y, s->sim->q, sizeof *s->y * (size_t)nq);
    memcpy(s->y + nq, s->sim->qd, sizeof *s->y * (size_t)nq);
    if (!derive_at(s, s->sim->head->t, s->y, s->y + nq, s->before)) {
        return;
    }
    renew(s);
    stein__guards_along(s->slopes, s->y + nq, &s->slopes->none, s->rate);
    int i = switching(s);
    for (int k = 0; i >= 0 && k < s->n; k++) {
        direction *way = &s->way[k];
        stein__guards_along(s->slopes, way->dy, &way->dd, s->dguard);
        way->instant = s->dguard[i] != 0.0 ? -s->dguard[i] / s->rate[i] : 0.0;
        if (!isfinite(way->instant)) {
            stein_err err;
            stein__fail(&err, STEIN_ENONFINITE,
                        "\"%s\": no sensitivity beyond t = %g s, where a contact or a notch "
                        "switches without being passed",
                        s->model->name, s->sim->head->t);
            trouble(s, &err);
        }
    }
}

static void pass(void *ctx, stein_sim *sim, int flipped)
{
    stein_sensitivity *s = ctx;
    int nq = s->model->nq;
    if (!is_well(s)) {
        return;
    }
    if (!flipped) {
        find_instants(s);
    } else if (derive_at(s, sim->head->t, s->y, s->y + nq, s->by_p)) {
        for (int k = 0; k < s->n; k++) {
            for (int j = 0; j < nq; j++) {
                s->way[k].dy[nq + j] += (s->before[j] - s->by_p[j]) * s->way[k].instant;
            }
        }
    }
}

/* ---- outside ---- */

/* the simulation ends, or another one follows it */
static void get_off(void *ctx)
{
    stein_sensitivity *s = ctx;
    s->sim->follower = NULL;
    s->sim->follower_is_explicit = 0;
    s->sim = NULL;
    stein__fail(&s->err, STEIN_EINVAL,
                "\"%s\": no sensitivity beyond where its simulation was destroyed, or given to "
                "another one",
                s->model->name);
}

stein_status stein_sensitivity_attach(stein_sensitivity *s, stein_sim *sim, stein_err *err)
{
    if (s->sim != NULL) {
        get_off(s);
    }
    s->err = (stein_err){STEIN_OK, ""};
    for (int k = 0; k < s->n; k++) {
        stein_sensitivity_set(s, k, NULL, NULL, NULL);
    }
    if (sim == NULL) {
        return STEIN_OK;
    }
    s->sim = sim;
    if (!derive_at(s, sim->head->t, sim->q, sim->qd, NULL)) {
        s->sim = NULL;
        if (err != NULL) {
            *err = s->err;
        }
        return s->err.code;
    }
    if (sim->follower != NULL) {
        sim->on_end(sim->follower);
    }
    sim->follower = s;
    sim->follower_is_explicit = 1;
    sim->on_accept = carry;
    sim->on_switch = pass;
    sim->on_end = get_off;
    return STEIN_OK;
}

void stein_sensitivity_destroy(stein_sensitivity *s)
{
    if (s != NULL) {
        (void)stein_sensitivity_attach(s, NULL, NULL);
        stein_derivative_destroy(s->slopes);
        s->def.release(s->def.ctx, s);
    }
}

void stein_sensitivity_set(stein_sensitivity *s, int k, const double *dq, const double *dqd,
                           const double *dp)
{
    if (k >= 0 && k < s->n) {
        direction *way = &s->way[k];
        stein__vector_to(way->dy, dq, s->model->nq);
        stein__vector_to(way->dy + s->model->nq, dqd, s->model->nq);
        stein__vector_to(way->dp, dp, s->model->np);
        way->dd.n = 0;
        memset(way->dd.dd, 0, sizeof *way->dd.dd * (size_t)s->model->nd);
        s->taken = s->sim != NULL ? s->sim->taken - 1 : 0; // to be worked out
        way->instant = 0.0;
    }
}

/* ---- the start ---- */

/* the load away, or back with the modes that its contact had */
static void lift(stein_sim *sim, int away, mask *present, flag *modes)
{
    const stein_load *load = &sim->model->load;
    if (load->body >= 0) {
        const stein_contact *contact = &sim->model->contacts[load->contact];
        flag *mode = sim->mode + contact->first_spot;
        *present = away ? sim->head->load_present : *present;
        sim->head->load_present = away ? 0 : *present;
        sim->held[load->body] = (flag)(away || !*present);
        for (int i = 0; i < contact->nspot && i < 2; i++) {
            modes[i] = away ? mode[i] : modes[i];
            mode[i] = away ? 0 : modes[i];
        }
    }
}

/* dq of an equilibrium: A_q dq = - A_p dp in the joints that are free, the others as in dq */
static int move_equilibrium(stein_sensitivity *s, const stein__constants *dd, double *dq)
{
    int n = s->model->nq;
    stein_derivative_by_state(s->slopes, s->by_q, s->by_qd);
    stein__along(s->slopes, NULL, NULL, dd, s->by_p);
    for (int i = 0; i < n; i++) {
        if (stein__is_driven(s->sim, i)) {
            for (int j = 0; j < n; j++) {
                s->by_q[i * n + j] = i == j ? 1.0 : 0.0;
            }
        } else {
            dq[i] = -s->by_p[i];
        }
    }
    return stein__solve_general(n, s->by_q, s->sim->pivot, dq);
}

/* dq of the load that stays flush: its depth is 0 */
static void move_load(stein_sensitivity *s, const stein__constants *dd, double *dq)
{
    const stein_model *model = s->model;
    int joint = model->load.body, spot = model->contacts[model->load.contact].first_spot;
    int range = model->contacts[model->load.contact].normal + STEIN_NORMAL_RANGE;
    double *unit = s->before;
    memset(unit, 0, sizeof *unit * (size_t)model->nq);
    unit[joint] = 1.0;
    dq[joint] = 0.0;
    stein__guards_along(s->slopes, unit, &s->slopes->none, s->rate);
    stein__guards_along(s->slopes, dq, dd, s->dguard);
    dq[joint] = -(s->dguard[spot] - dd->dd[range]) / s->rate[spot];
}

stein_status stein_sensitivity_start(stein_sensitivity *s, int k, const double *dp, stein_err *err)
{
    if (s->sim == NULL || dp == NULL || k < 0 || k >= s->n) {
        return stein__fail(err, STEIN_EINVAL,
                           "no start along direction %d: expected one of %d, a direction of "
                           "parameters and a simulation that is ridden with",
                           k, s->n);
    }
    const stein_model *model = s->model;
    stein_sim *sim = s->sim;
    int n = model->nq, singular = 0;
    mask present = 0;
    flag modes[2] = {0, 0};
    stein_sensitivity_set(s, k, NULL, NULL, dp);
    double *dq = s->way[k].dy, *dqd = dq + n;
    memcpy(s->y, sim->q, sizeof *s->y * (size_t)n);
    memset(s->y + n, 0, sizeof *s->y * (size_t)n);
    lift(sim, 1, &present, modes);
    if (derive_at(s, sim->head->t, s->y, s->y + s->model->nq, NULL)) {
        renew(s);
        const stein__constants *dd = &s->way[k].dd;
        for (int j = 0; j < n; j++) {
            dq[j] = dd->dd[model->initial + 2 * j];
            dqd[j] = dd->dd[model->initial + 2 * j + 1];
        }
        singular = model->settle && move_equilibrium(s, dd, dq) != 0;
        if (model->load.body >= 0) {
            move_load(s, dd, dq);
        }
    }
    lift(sim, 0, &present, modes);
    sim->fresh = STALE;
    if (singular) {
        return stein__fail(err, STEIN_ESINGULAR, "\"%s\": the equilibrium is indifferent",
                           model->name);
    }
    return stein_sensitivity_check(s, err);
}

const double *stein_sensitivity_q(const stein_sensitivity *s, int k)
{
    return k >= 0 && k < s->n ? s->way[k].dy : NULL;
}

const double *stein_sensitivity_qd(const stein_sensitivity *s, int k)
{
    return k >= 0 && k < s->n ? s->way[k].dy + s->model->nq : NULL;
}

double stein_sensitivity_switch(const stein_sensitivity *s, int k)
{
    return k >= 0 && k < s->n ? s->way[k].instant : 0.0;
}

stein_status stein_sensitivity_check(const stein_sensitivity *s, stein_err *err)
{
    if (!is_well(s) && err != NULL) {
        *err = s->err;
    }
    return s->err.code;
}
