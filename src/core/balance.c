/* SPDX-License-Identifier: MIT
 * balance.c - the energy of a motion (balance.h): powers of all forces, integrated over the steps
 * that were taken.
 *
 *      dE/dt = sum of Q_j qd_j + sum over driven joints of (M qdd + c - Q)_j qd_j
 *
 * holds for any state, so the left side less the integral of the right one is the error of the
 * steps. What is attributed to single laws divides the right side; it does not enter that error.
 */
#include <math.h>
#include <string.h>

#include "slopes.h"
#include "stein/balance.h"

struct stein_balance {
    const stein_model *model;
    stein_sim_def def;
    stein_sim *sim;
    double *q, *qd, *qdd; /* [nq] at a node */
    double *end;          /* [2*nq] q, qd at the end of the last step */
    double *work;         /* [nwork] by kind and index */
    double *power;        /* [nwork] at a node */
    int nwork;
    double begin, now;    /* E [J] */
    double kinetic;       /* its peak [J] */
    double total, stored; /* work of all forces and motions; against elastic forces [J] */
    double taken;         /* [J] */
    double turned[2];     /* integrals of |power|: inputs, dissipation [J] */
};

/* where the works of a kind begin */
static int first_of(const stein_model *m, stein_work_kind kind)
{
    int n[] = {m->ninput, m->nq, m->ncontact + m->nnotch, m->ncontact + m->nnotch, m->nlink},
        at = 0;
    for (int k = 0; k < (int)kind; k++) {
        at += n[k];
    }
    return at;
}

static int number_of(const stein_model *m)
{
    return first_of(m, STEIN_WORK_LINK) + m->nlink;
}

static size_t layout(stein_balance *b, const stein_model *m)
{
    stein_balance measured = {.def = {.dt = 0.0}};
    stein__arena a = {(unsigned char *)b, 0};
    b = b != NULL ? b : &measured;
    stein__carve(&a, sizeof *b);
    b->q = stein__carve_doubles(&a, m->nq);
    b->qd = stein__carve_doubles(&a, m->nq);
    b->qdd = stein__carve_doubles(&a, m->nq);
    b->end = stein__carve_doubles(&a, 2 * m->nq);
    b->work = stein__carve_doubles(&a, number_of(m));
    b->power = stein__carve_doubles(&a, number_of(m));
    return a.used;
}

stein_status stein_balance_create(stein_balance **out, const stein_model *model,
                                  const stein_sim_def *def, stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    size_t size = layout(NULL, model);
    stein_balance *b = own.alloc(own.ctx, size);
    if (b == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory for the energies of \"%s\"",
                           model->name);
    }
    memset(b, 0, size);
    b->model = model;
    b->def = own;
    b->nwork = number_of(model);
    (void)layout(b, model);
    *out = b;
    return STEIN_OK;
}

/* ---- powers at a node, where forces were evaluated last; each returns that of elastic forces ----
 */

static double power_of_touches(stein_balance *b, const stein_sim *sim)
{
    double *normal = b->power + first_of(b->model, STEIN_WORK_NORMAL);
    double *friction = b->power + first_of(b->model, STEIN_WORK_FRICTION), elastic = 0.0;
    for (int i = 0; i < sim->ntouch; i++) {
        const touch *t = &sim->touch[i];
        const pair *p = t->pair;
        double still = stein__normal(p->normal, p->parts, t->depth, 0.0);
        if (sim->ntable_on > 0) {
            still = stein__tables_normal(sim, p->index, still, t->depth, 0.0);
        }
        elastic -= still * t->rate;
        normal[p->index] -= (t->normal - still) * t->rate;
        if (p->inverse_vt > 0.0 && t->normal > 0.0) {
            friction[p->index] -=
                t->normal * stein__touch_mu(sim, i) * sim->slip[i] / p->inverse_vt;
        }
    }
    return elastic;
}

static double power_of_joints(stein_balance *b, const stein_sim *sim)
{
    double *lost = b->power + first_of(b->model, STEIN_WORK_JOINT), elastic = 0.0;
    for (int k = 0; k < sim->nacting; k++) {
        int j = sim->acting[k].joint, parts = sim->acting[k].parts;
        const double *law = sim->acting[k].law;
        double mu = stein__joint_mu(sim, k);
        double still = stein__joint(law, parts, sim->xq[j], 0.0, 0.0);
        double whole = stein__joint(law, parts, sim->xq[j], sim->xqd[j], mu);
        elastic += still * sim->xqd[j];
        lost[j] += (whole - still) * sim->xqd[j];
    }
    const double *slope = sim->slope;
    for (int i = 0; i < b->model->ntable; i++) {
        const stein_table *t = &b->model->tables[i];
        if (t->kind <= STEIN_TABLE_SPEED) {
            double *x = t->kind == STEIN_TABLE_POSITION ? sim->xq : sim->xqd;
            const double *at = sim->d + t->d;
            double power =
                stein_table_value(t->n, at, at + t->n, slope, x[t->index]) * sim->xqd[t->index];
            elastic += t->kind == STEIN_TABLE_POSITION ? power : 0.0;
            lost[t->index] += t->kind == STEIN_TABLE_SPEED ? power : 0.0;
        }
        slope += t->n;
    }
    return elastic;
}

static double power_of_links(stein_balance *b, const stein_sim *sim)
{
    double *lost = b->power + first_of(b->model, STEIN_WORK_LINK), elastic = 0.0;
    for (int i = 0; i < b->model->nlink; i++) {
        const stein_link *link = &b->model->links[i];
        const double *law = sim->d + link->d;
        double xa[3], xb[3], va[3], vb[3], length = 0.0, rate = 0.0;
        stein__point(sim, link->point[0], xa, va);
        stein__point(sim, link->point[1], xb, vb);
        for (int k = 0; k < 3; k++) {
            length += (xb[k] - xa[k]) * (xb[k] - xa[k]);
            rate += (xb[k] - xa[k]) * (vb[k] - va[k]);
        }
        length = sqrt(length);
        if (length > 0.0) {
            rate /= length;
            double still = stein__tension(law, length, 0.0, xa[2]);
            elastic -= still * rate;
            lost[i] -= (stein__tension(law, length, rate, xa[2]) - still) * rate;
        }
    }
    return elastic;
}

/* @return what motions bring, which is not in Q */
static double power_of_inputs(stein_balance *b, stein_sim *sim)
{
    const stein_model *m = b->model;
    double *brought = b->power + first_of(m, STEIN_WORK_INPUT), motions = 0.0;
    if (sim->motions) {
        m->inverse(sim->xq, sim->xqd, b->qdd, sim->sc, sim->d, sim->zero, sim->zero, sim->c);
    }
    for (int i = 0; i < m->ninput; i++) {
        const stein_input *input = &m->inputs[i];
        int j = input->index;
        double u = sim->ustate[3 * i];
        if (sim->signal[i] == NULL) {
            continue;
        }
        if (input->kind == STEIN_INPUT_JOINT) {
            brought[i] = u * sim->xqd[j];
        } else if (input->kind == STEIN_INPUT_VOLTAGE) {
            brought[i] = u * sim->d[input->direction] * sim->xqd[j];
        } else if (input->kind == STEIN_INPUT_POINT) {
            const double *n = sim->d + input->direction;
            double x[3], v[3];
            stein__point(sim, j, x, v);
            brought[i] = u * (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]);
        } else if (stein__driver_of(sim, j) == i) {
            brought[i] = (sim->c[j] - sim->Q[j]) * sim->xqd[j];
            motions += brought[i];
        }
    }
    return motions;
}

/* the works of a node with its weight [s] */
static void add_node(stein_balance *b, stein_sim *sim, double weight)
{
    const stein_model *m = b->model;
    double elastic, power = 0.0, brought = 0.0, lost = 0.0;
    memset(b->power, 0, sizeof *b->power * (size_t)b->nwork);
    elastic = power_of_touches(b, sim) + power_of_joints(b, sim) + power_of_links(b, sim);
    power = power_of_inputs(b, sim);
    for (int j = 0; j < m->nq; j++) {
        power += sim->Q[j] * sim->xqd[j];
    }
    for (int i = 0; i < b->nwork; i++) {
        b->work[i] += weight * b->power[i];
        brought += i < m->ninput ? fabs(b->power[i]) : 0.0;
        lost += i < m->ninput ? 0.0 : fabs(b->power[i]);
    }
    b->total += weight * power;
    b->stored -= weight * elastic;
    b->turned[0] += weight * brought;
    b->turned[1] += weight * lost;
}

/* ---- along a motion ---- */

static double energy_of(stein_balance *b, stein_sim *sim, const double *q, const double *qd)
{
    double kinetic, potential;
    stein_energy(sim, q, qd, &kinetic, &potential);
    b->kinetic = fmax(b->kinetic, kinetic);
    return kinetic + potential;
}

static void keep_end(stein_balance *b, const double *q, const double *qd)
{
    size_t n = (size_t)b->model->nq;
    memcpy(b->end, q, sizeof *q * n);
    memcpy(b->end + n, qd, sizeof *qd * n);
}

/* A step of h was taken. Forces are then those of a node, and are evaluated when they are asked
 * for. */
static void carry(void *ctx, stein_sim *sim, double h)
{
    static const double node[] = {0.11270166537925831, 0.5, 0.88729833462074169};
    static const double weight[] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    stein_balance *b = ctx;
    size_t size = sizeof *b->end * (size_t)b->model->nq;
    if (memcmp(b->end, sim->q0, size) != 0 || memcmp(b->end + b->model->nq, sim->qd0, size) != 0) {
        double there = energy_of(b, sim, sim->q0, sim->qd0);
        b->taken += b->now - there;
    }
    sim->inside = INSIDE;
    for (int i = 0; i < 3; i++) {
        double t = sim->head->t - (1.0 - node[i]) * h;
        stein__interpolate(sim, h, node[i], b->q, b->qd);
        if (stein__evaluate(sim, t, b->q, b->qd, b->qdd, NULL) == STEIN_OK) {
            add_node(b, sim, weight[i] * h);
        }
    }
    sim->inside = AT_END;
    b->now = energy_of(b, sim, sim->q1, sim->qd1);
    keep_end(b, sim->q1, sim->qd1);
    sim->fresh = KNOWN;
}

static void pass(void *ctx, stein_sim *sim, int flipped)
{
    (void)ctx, (void)sim,
        (void)flipped; // positions and speeds do not jump where a contact switches
}

static void get_off(void *ctx)
{
    stein_balance *b = ctx;
    b->sim->follower = NULL;
    b->sim = NULL;
}

stein_status stein_balance_attach(stein_balance *b, stein_sim *sim, stein_err *err)
{
    if (sim != NULL &&
        memcmp(sim->model->equations, b->model->equations, sizeof sim->head->equations) != 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "the energies of \"%s\" cannot be counted for a simulation of \"%s\"",
                           b->model->name, sim->model->name);
    }
    if (b->sim != NULL) {
        get_off(b);
    }
    if (sim == NULL) {
        return STEIN_OK;
    }
    if (sim->follower != NULL) {
        sim->on_end(sim->follower);
    }
    memset(b->work, 0, sizeof *b->work * (size_t)b->nwork);
    b->total = b->stored = b->taken = b->kinetic = b->turned[0] = b->turned[1] = 0.0;
    b->begin = b->now = energy_of(b, sim, sim->q, sim->qd);
    keep_end(b, sim->q, sim->qd);
    b->sim = sim;
    sim->follower = b;
    sim->on_accept = carry;
    sim->on_switch = pass;
    sim->on_end = get_off;
    return STEIN_OK;
}

void stein_balance_destroy(stein_balance *b)
{
    if (b != NULL) {
        (void)stein_balance_attach(b, NULL, NULL);
        b->def.release(b->def.ctx, b);
    }
}

/* ---- sums ---- */

void stein_balance_total(const stein_balance *b, stein_energy_total *total)
{
    double inputs = 0.0, lost = 0.0;
    for (int i = 0; i < b->nwork; i++) {
        inputs += i < b->model->ninput ? b->work[i] : 0.0;
        lost -= i < b->model->ninput ? 0.0 : b->work[i];
    }
    *total = (stein_energy_total){
        .begin = b->begin,
        .now = b->now,
        .inputs = inputs,
        .dissipated = lost,
        .stored = b->stored,
        .other = b->total - inputs + lost + b->stored,
        .taken = b->taken,
        .unexplained = b->now - b->begin - b->total + b->taken,
        .scale = fmax(b->kinetic, fmax(b->turned[0], b->turned[1])),
    };
}

double stein_balance_work(const stein_balance *b, stein_work_kind kind, int index)
{
    const stein_model *m = b->model;
    int known = kind >= STEIN_WORK_INPUT && kind <= STEIN_WORK_LINK;
    int first = known ? first_of(m, kind) : 0;
    int end = !known ? 0 : kind == STEIN_WORK_LINK ? b->nwork : first_of(m, kind + 1);
    return index >= 0 && index < end - first ? b->work[first + index] : NAN;
}
