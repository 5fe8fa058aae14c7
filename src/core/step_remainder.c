/* SPDX-License-Identifier: MIT
 * step_remainder.c - what is left of a fixed step with more events than are located.
 *
 * Two Runge-Kutta steps at most, without any search. Contacts that are met on the way are on from
 * the beginning, as their laws give no force before. Everything else changes its mode at the
 * end.
 *
 *      trial --nothing met--> taken      --met--> on, trial again --> taken
 *        '---- a contact ends that has just begun: it is shorter than the step --> implicit
 *
 * An explicit step that is too long for a contact makes energy: damping that grows with depth (Hunt
 * & Crossley) is stiff. One linearly implicit step of Euler does not,
 *
 *      (M + h sum (B + h K) p p^T) dqd = h (Q - c + sum p e),   q1 = q + h (qd + dqd),
 *
 * p the generalised force of a unit force along the normal, K and B the derivatives of the normal
 * force by depth and rate, e what it grows by at the present speed. It is of order 1. It takes the
 * place of a step whose stages differ by much (trial.c), where a contact has h (B + h K) > 3 m at
 * the depth that it reaches, and of the rest where a contact begins and ends.
 * It also takes energy out of springs: where a whole bounce would be lost, as the spring alone is
 * faster than the step, it is refused.
 */
#include <math.h>
#include <string.h>

#include "core.h"

static const double begun = 1e-12;              /* [m] a contact as deep as that has just begun */
static const double early = 0.01;               /* in a step: there it has been deeper */
static const double little = 1e-9, slow = 1e-6; /* [m], [m/s] for slopes of a law */
static const double bounce = 3.0;               /* of h sqrt(K/m): half a period is pi */
static const double too_long = 3.0;             /* of h (B + h K)/m: Runge-Kutta follows to 2.8 */

static stein_status refuse(stein_sim *sim, stein_err *err)
{
    return stein__explain_failure(sim, sim->def.dt, STEIN_ECHATTER,
                                  "a contact begins and ends within one step", err);
}

static int knows_implicit(const stein_sim *sim)
{
    const stein_model *m = sim->model;
    return m->nrow == 0 && m->nball == 0 && m->nstick == 0 && sim->follower == NULL;
}

/* ---- the implicit step ---- */

/* the normal force of what touches, linear about where it is or first presses */
typedef struct tangent {
    double K, B, e;  /* e: what it has grown by after h at the present rate */
    double spring;   /* K at rest */
    double per_mass; /* 1/m along the normal */
} tangent;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double normal_at(const touch *t, double x, double rate)
{
    return stein__normal(t->pair->normal, t->pair->parts, x, rate);
}

/* K and B at the depth x. By differences: pages and FMUs of explicit steps go without the exact
 * derivatives. */
static void slopes(const touch *t, double x, double *K, double *B)
{
    double f = normal_at(t, x, t->rate);
    *K = (normal_at(t, x + little, t->rate) - f) / little;
    *B = larger((normal_at(t, x, t->rate + slow) - f) / slow, 0.0);
}

static tangent linear(const touch *t, double h, double x)
{
    double K, B, missing = 0.0;
    slopes(t, x, &K, &B);
    if (t->depth < little) {
        missing = normal_at(t, x, t->rate) + K * (t->depth - x) - t->normal;
    }
    double spring = (normal_at(t, x + little, 0.0) - normal_at(t, x, 0.0)) / little;
    return (tangent){
        .K = larger(K, 0.0), .B = B, .e = missing + h * K * t->rate, .spring = larger(spring, 0.0)};
}

/* p [nq] into Q, 1/m along it; M = L^T D L is factored */
static double per_mass(stein_sim *sim, const touch *t, const double *M)
{
    int n = sim->model->nq, given = stein__prescribes(sim);
    double *p = sim->Q, *y = sim->e, sum = 0.0; // y = L^-T p
    clear(p, n);
    stein__probe(sim, t, 0);
    for (int j = 0; given && j < n; j++) {
        p[j] = stein__is_driven(sim, j) ? 0.0 : p[j];
    }
    copy(y, p, n);
    for (int k = n - 1; k >= 0; k--) {
        for (int i = sim->parent[k]; i >= 0; i = sim->parent[i]) {
            y[i] -= M[k * n + i] * y[k];
        }
        sum += y[k] * y[k] * sim->inverse[k];
    }
    return sum;
}

/* A = M and b = Q - c of the present state, `M` factored. @return 0, -1: M is singular */
static int assemble(stein_sim *sim, double *A, double *M, double *b)
{
    int n = sim->model->nq;
    sim->model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, A, sim->c);
    for (int j = 0; j < n; j++) {
        b[j] = sim->Q[j] - sim->c[j];
    }
    if (stein__prescribes(sim)) {
        stein__prescribe(sim, A, b);
    }
    memcpy(M, A, sizeof *M * (size_t)n * (size_t)n);
    return stein__factor(n, sim->parent, M, sim->inverse) < 0 ? 0 : -1;
}

/* Does a touch press by the end of a step of h? */
static int touches_within(const touch *t, double h)
{
    return t->depth > 0.0 || t->depth + h * t->rate > 0.0;
}

/* dqd [n] into b, of the state that was evaluated. @return 0, -1: M is singular, or a whole
 * bounce would be lost */
static int solve(stein_sim *sim, double h, double *b)
{
    int n = sim->model->nq;
    double *A = sim->M, *M = sim->work, *p = sim->Q;
    if (assemble(sim, A, M, b) != 0) {
        return -1;
    }
    for (int k = 0; k < sim->ntouch; k++) {
        const touch *t = &sim->touch[k];
        if (!touches_within(t, h)) {
            continue;
        }
        tangent f = linear(t, h, larger(t->depth, little));
        f.per_mass = per_mass(sim, t, M);
        if (h * sqrt(f.spring * f.per_mass) > bounce) {
            return -1;
        }
        double share = h * (f.B + h * f.K);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                A[i * n + j] += share * p[i] * p[j];
            }
            b[i] += p[i] * f.e;
        }
    }
    for (int j = 0; j < n; j++) {
        b[j] *= h;
    }
    return stein__solve_general(n, A, sim->pivot, b);
}

/* the state at `target` by one implicit step, and what has switched by then; the present state has
 * been evaluated */
static stein_status step_implicitly(stein_sim *sim, double target, stein_err *err)
{
    int n = sim->model->nq;
    double h = target - sim->head->t, *dqd = sim->work + n * n;
    if (solve(sim, h, dqd) != 0) {
        return refuse(sim, err);
    }
    for (int j = 0; j < n; j++) {
        sim->qd1[j] = sim->qd[j] + dqd[j];
        sim->q1[j] = sim->q[j] + h * sim->qd1[j];
        sim->qdd1[j] = dqd[j] / h;
    }
    stein_status status = stein__check_finite(sim, h, err);
    if (status == STEIN_OK) {
        stein__drive_from(sim, target, sim->q1, sim->qd1); // given joints exactly on track
        copy(sim->q1, sim->xq, n);
        copy(sim->qd1, sim->xqd, n);
        stein__accept(sim, target);
        sim->fresh = STALE;
        status = stein__refresh(sim, err);
    }
    if (status == STEIN_OK) {
        stein__mark_crossed(sim);
        stein__flip_crossed(sim);
    }
    return status;
}

/* what touches where the step begins; the guards stay those of its end */
static stein_status evaluate(stein_sim *sim, stein_err *err)
{
    sim->inside = INSIDE;
    stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
    sim->inside = AT_END;
    return status;
}

/* ---- abrupt steps ---- */

/* is a step of h too long for a contact, at the depth that it reaches after `share` of the step? */
static int is_too_long(stein_sim *sim, double h, double share)
{
    int n = sim->model->nq;
    if (assemble(sim, sim->M, sim->work, sim->work + n * n) != 0) {
        return 0;
    }
    for (int k = 0; k < sim->ntouch; k++) {
        const touch *t = &sim->touch[k];
        if (touches_within(t, h)) {
            double K, B, depth = larger(t->depth, t->depth + share * h * t->rate);
            slopes(t, larger(depth, little), &K, &B);
            if (h * (B + h * larger(K, 0.0)) * per_mass(sim, t, sim->work) > too_long) {
                return 1;
            }
        }
    }
    return 0;
}

static void swap_touches(stein_sim *sim)
{
    touch *begin = sim->touch;
    int nbegin = sim->ntouch;
    sim->touch = sim->begin;
    sim->ntouch = sim->nbegin;
    sim->begin = begin;
    sim->nbegin = nbegin;
}

/* In space there is more to a touch. */
void stein__keep_touches(stein_sim *sim)
{
    if (sim->fresh >= TOLD && sim->model->npose3 == 0) {
        swap_touches(sim);
    } else {
        sim->nbegin = -1;
    }
}

stein_status stein__take_abrupt(stein_sim *sim, double target, int lost, int *taken, stein_err *err)
{
    double h = target - sim->head->t;
    if (!knows_implicit(sim)) {
        return STEIN_OK;
    }
    stein_status status = STEIN_OK;
    swap_touches(sim);
    if (sim->ntouch >= 0) {
        stein__place(sim);
    } else {
        status = evaluate(sim, err);
    }
    *taken = status == STEIN_OK && is_too_long(sim, h, lost ? 1.0 : 0.5);
    swap_touches(sim);
    status = *taken ? evaluate(sim, err) : status;
    return status == STEIN_OK && *taken ? step_implicitly(sim, target, err) : status;
}

/* ---- the rest ---- */

/* does a contact of the trial step end that has just begun? */
static int is_over(stein_sim *sim, double h)
{
    for (int i = 0; i < sim->nguard; i++) {
        if (sim->crossed[i] && sim->mode[i] && !stein__is_region(sim, i) &&
            stein__guard_at(sim, h, 0.0, i) <= begun && stein__guard_at(sim, h, early, i) > begun) {
            return 1;
        }
    }
    return 0;
}

/* keep in crossed[] what begins. @return is there any? */
static int only_met(stein_sim *sim)
{
    int any = 0;
    for (int i = 0; i < sim->nswitch; i++) {
        sim->crossed[i] =
            i < sim->nguard && sim->crossed[i] && !sim->mode[i] && !stein__is_region(sim, i);
        any |= sim->crossed[i];
    }
    return any;
}

stein_status stein__take_rest(stein_sim *sim, double target, stein_err *err)
{
    double h = target - sim->head->t;
    stein_status status = STEIN_OK;
    stein__mark_crossed(sim);
    int over = is_over(sim, h);
    if (!over && only_met(sim)) {
        stein__flip_crossed(sim);
        status = stein__restart(sim, err);
        status = status == STEIN_OK ? stein__try(sim, h, 0, err) : status;
        if (status != STEIN_OK) {
            return status;
        }
        stein__mark_crossed(sim);
        over = is_over(sim, h);
    }
    if (!over) {
        stein__mark_crossed(sim); // before others look at the step
        stein__accept(sim, target);
        stein__flip_crossed(sim);
        return STEIN_OK;
    }
    if (!knows_implicit(sim)) {
        return refuse(sim, err);
    }
    status = evaluate(sim, err);
    return status == STEIN_OK ? step_implicitly(sim, target, err) : status;
}
