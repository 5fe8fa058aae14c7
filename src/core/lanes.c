/* SPDX-License-Identifier: MIT
 * lanes.c - trial steps of 2, 4 or 8 simulations side by side (STEIN_LANES).
 *
 * The files of the core that a derivative needs, compiled once more with vectors for numbers. What
 * is done in lanes is a trial step: all stages, the derivative and the guards at its end. A lane
 * that meets an event, or a number that is none, does not take the step; batch.c steps it alone,
 * where events are located.
 */
#include "lane.h"

#include "core.h"

#if STEIN_LANES > 1

#include "contact.c"
#include "forces.c"
#include "inputs.c"
#include "dense_output.c"
#include "layout.c"
#include "notch.c"
#include "table.c"
#include "contact_sites.c"
#include "trial.c"

INNER stein_status stein__evaluate(stein_sim *sim, real t, const real *q, const real *qd, real *qdd,
                                   stein_err *err)
{
    (void)q, (void)qd, (void)err; // the state is in xq and xqd
    if (sim->signals) {
        stein__drive(sim, t);
    }
    turn_joints(sim, sim->xq, sim->sc);
    stein__forces(sim);
    sim->bad |= unsolved(stein__accelerate(sim, qdd));
    return STEIN_OK;
}

static size_t size(const stein_model *model)
{
    return stein__layout(NULL, model) + sizeof(real);
}

static void *make(void *block, const stein_model *model, stein_integrator integrator)
{
    uintptr_t at = ((uintptr_t)block + sizeof(real) - 1) / sizeof(real) * sizeof(real);
    stein_sim *sim = (stein_sim *)at;
    memset(sim, 0, stein__layout(NULL, model));
    sim->model = model;
    sim->def.integrator = integrator;
    sim->lanes = model->lanes[STEIN_LANES == 2 ? 0 : STEIN_LANES == 4 ? 1 : 2];
    (void)stein__layout(sim, model);
    sim->pose[-1] = (stein_pose){.c = same(1.0)};
    stein__gather(sim);
    return sim;
}

static void put_numbers(real *to, int lane, const double *from, int n)
{
    for (int i = 0; i < n; i++) {
        to[i][lane] = from[i];
    }
}

static void put_signals(stein_sim *sim, int lane, const stein__rider *from)
{
    for (int i = 0; i < sim->model->ninput; i++) {
        sim->signal[STEIN_LANES * i + lane] = from->signal[i];
        sim->signal_ctx[STEIN_LANES * i + lane] = from->signal_ctx[i];
        put_flag(&sim->bound[i], lane, from->signal[i] != NULL);
        put_numbers(sim->ustate + 3 * i, lane, (const double[3]){0.0}, 3);
    }
}

static void put(void *wide, int lane, const stein__rider *from, int with_d)
{
    stein_sim *sim = wide;
    const stein_model *model = sim->model;
    put_numbers(sim->q, lane, from->q, model->nq);
    put_numbers(sim->qd, lane, from->qd, model->nq);
    put_numbers(sim->qdd, lane, from->qdd, model->nq);
    for (int i = 0; i < sim->nguard; i++) {
        put_flag(&sim->mode[i], lane, from->mode[i]);
    }
    put_flag(&sim->head->load_present, lane, from->load_present);
    if (model->load.body >= 0) {
        put_flag(&sim->held[model->load.body], lane, !from->load_present);
    }
    if (with_d) {
        put_numbers(sim->d, lane, from->d, model->nd);
        put_signals(sim, lane, from);
    }
}

static void ready(void *wide)
{
    stein_sim *sim = wide;
    stein__tables_prepare(sim);
    stein__pairs_prepare(sim);
    stein__joints_prepare(sim);
    stein__wire(sim);
}

/* lanes whose trial step ended with numbers */
static mask finite(const stein_sim *sim)
{
    mask good = no(sim->bad);
    for (int j = 0; j < sim->model->nq; j++) {
        good &= at_most(magnitude(sim->q1[j]), 0x1.fffffffffffffp1023) &
                at_most(magnitude(sim->qd1[j]), 0x1.fffffffffffffp1023) &
                at_most(magnitude(sim->qdd1[j]), 0x1.fffffffffffffp1023);
    }
    return good;
}

static real numbers(const double *from)
{
    real x;
    memcpy(&x, from, sizeof x);
    return x;
}

/* a trial step of h in all lanes, from where they are; @return those wanted that ended with numbers
 */
static mask try_step(stein_sim *sim, real t, real h, mask wanted)
{
    sim->bad = (mask){0};
    sim->asked = wanted;
    (void)stein__trial(sim, t, h, NULL);
    return both(finite(sim), wanted);
}

static unsigned trial(void *wide, const double *t, const double *h, unsigned wanted)
{
    return lanes_of(try_step(wide, numbers(t), numbers(h), mask_from(wanted)));
}

static void outcome(const void *wide, int lane, double *q1, double *qd1, double *qdd1,
                    double *guard, double error[2])
{
    const stein_sim *sim = wide;
    for (int j = 0; j < sim->model->nq; j++) {
        q1[j] = sim->q1[j][lane];
        qd1[j] = sim->qd1[j][lane];
        qdd1[j] = sim->qdd1[j][lane];
    }
    for (int i = 0; i < sim->nguard; i++) {
        guard[i] = sim->guard[i][lane];
    }
    error[0] = sim->eq[lane];
    error[1] = sim->eqd[lane];
}

static void grade(const void *wide, const double *h, const double *tolerance,
                  const double *log_last, double *e, double *log_e, double *factor)
{
    stein__grade g = stein__graded(wide, numbers(h), numbers(tolerance), numbers(log_last));
    memcpy(e, &g.e, sizeof g.e);
    memcpy(log_e, &g.log_e, sizeof g.log_e);
    memcpy(factor, &g.factor, sizeof g.factor);
}

/* lanes where a guard, as evaluated last, is on the other side of its mode */
static mask crossed(const stein_sim *sim)
{
    mask any_of = {0};
    for (int i = 0; i < sim->nguard; i++) {
        any_of |= more(sim->guard[i], 0.0) ^ sim->mode[i];
    }
    return any_of;
}

static unsigned grazes(void *wide, const double *h)
{
    stein_sim *sim = wide;
    stein__interpolate(sim, numbers(h), 0.5, sim->xq, NULL);
    stein__guards(sim, sim->xq, sim->guard);
    return lanes_of(crossed(sim));
}

/* @return lanes that took it */
static mask step(stein_sim *sim, real t, real h, mask wanted)
{
    mask good = try_step(sim, t, h, wanted);
    good = both(good, no(either(crossed(sim), stein__abrupt(sim, h))));
    for (int j = 0; j < sim->model->nq; j++) {
        sim->q[j] = sel(good, sim->q1[j], sim->q[j]);
        sim->qd[j] = sel(good, sim->qd1[j], sim->qd[j]);
        sim->qdd[j] = sel(good, sim->qdd1[j], sim->qdd[j]);
    }
    sim->eq_taken = sel(good, sim->eq, sim->eq_taken);
    sim->eqd_taken = sel(good, sim->eqd, sim->eqd_taken);
    return good;
}

static unsigned steps(void *wide, const stein__grid *grid, double *t, unsigned wanted, long most,
                      long *tried)
{
    real now = numbers(t), t0 = now, taken = now, dt = now;
    for (int k = 0; k < STEIN_LANES; k++) {
        t0[k] = grid[k].t0;
        taken[k] = grid[k].taken;
        dt[k] = grid[k].dt;
    }
    unsigned good;
    *tried = 0;
    do {
        taken += 1.0;
        real end = t0 + taken * dt;
        mask took = step(wide, now, end - now, mask_from(wanted));
        now = sel(took, end, now);
        good = lanes_of(took);
        ++*tried;
    } while (good == wanted && *tried < most);
    memcpy(t, &now, sizeof now);
    return good;
}

static void take(const void *wide, int lane, double *q, double *qd, double *qdd, double error[2])
{
    const stein_sim *sim = wide;
    for (int j = 0; j < sim->model->nq; j++) {
        q[j] = sim->q[j][lane];
        qd[j] = sim->qd[j][lane];
        qdd[j] = sim->qdd[j][lane];
    }
    error[0] = sim->eq_taken[lane];
    error[1] = sim->eqd_taken[lane];
}

#define JOIN(a, b)  a##b
#define WIDTH_OF(n) JOIN(stein__width, n)

const stein__width WIDTH_OF(STEIN_LANES) = {STEIN_LANES, size,  make,    put,   ready, steps,
                                            take,        trial, outcome, grade, grazes};

#endif
