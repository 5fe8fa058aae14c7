/* SPDX-License-Identifier: MIT
 * rest.c - the rest of a fixed step that has more events than are located.
 *
 * Two Runge-Kutta steps at most, without any search: contacts that are met on the way are on from
 * the beginning, as their laws give no force before; everything else changes its mode at the end.
 *
 *      trial --nothing met--> taken      --met--> on, trial again --> taken
 *        '---- a contact ends that has just begun: it is shorter than the step --> implicit
 *
 * An explicit step over a contact that begins and ends within it makes energy: damping that grows
 * with depth (Hunt & Crossley) is stiff there. One linearly implicit step of Euler does not,
 *
 *      (M + h sum (B + h K) p p^T) dqd = h (Q - c + sum p e),   q1 = q + h (qd + dqd),
 *
 * p the generalised force of a unit force along the normal, K and B the derivatives of the normal
 * force by depth and rate, e what it grows by at the present speed. It is of order 1 and takes
 * energy out of springs: a contact whose spring alone is faster than the step, so that a bounce
 * would be lost, is refused.
 */
#include <math.h>
#include <string.h>

#include "core.h"

static const double begun = 1e-12;             /* [m] a contact as deep as that has just begun */
static const double little = 1e-9, slow = 1e-6; /* [m], [m/s] for derivatives of a law */
static const double fastest = 3.0;             /* of h sqrt(K/m): a bounce lasts pi */

static stein_status refuse(stein_sim *sim, double h, stein_err *err)
{
    stein_err why;
    stein__fail(&why, STEIN_ECHATTER, "a contact begins and ends more than once in one step");
    return stein__blame(sim, h, STEIN_ECHATTER, why.msg, err);
}

/* ---- the implicit step ---- */

/* A = L D L^T in place, A [n][n] symmetric and positive definite */
static int factor(int n, double *A)
{
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < j; k++) {
            A[j * n + j] -= A[j * n + k] * A[j * n + k] * A[k * n + k];
        }
        if (!(A[j * n + j] > 0.0)) {
            return -1;
        }
        for (int i = j + 1; i < n; i++) {
            for (int k = 0; k < j; k++) {
                A[i * n + j] -= A[i * n + k] * A[j * n + k] * A[k * n + k];
            }
            A[i * n + j] /= A[j * n + j];
        }
    }
    return 0;
}

static void substitute(int n, const double *A, double *b)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            b[i] -= A[i * n + k] * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        b[i] /= A[i * n + i];
        for (int k = i + 1; k < n; k++) {
            b[i] -= A[k * n + i] * b[k];
        }
    }
}

/* the normal force of what touches, linear about where it is or first presses */
typedef struct tangent {
    double K, B, e; /* e: what it has grown by after h at the present rate */
    double spring;  /* K of a contact at rest */
} tangent;

static tangent linear(const touch *t, double h)
{
    const double *law = t->pair->normal;
    int parts = t->pair->parts;
    double x = fmax(t->depth, little), f = stein__normal(law, parts, x, t->rate);
    double K = (stein__normal(law, parts, x + little, t->rate) - f) / little;
    double B = (stein__normal(law, parts, x, t->rate + slow) - f) / slow;
    double spring = (stein__normal(law, parts, x + little, 0.0) - stein__normal(law, parts, x, 0.0)) /
                    little;
    double missing = t->depth < little ? f + K * (t->depth - x) - t->normal : 0.0;
    return (tangent){K, B, missing + h * K * t->rate, spring};
}

/* The touch into A and b. free [n], p [n] and y [n] are room. @return 0, -1: its spring is too
 * fast. `M` is factored. */
static int add_touch(stein_sim *sim, const touch *t, double h, const double *M, double *A,
                     double *b)
{
    int n = sim->model->nq;
    double *p = sim->Q, *y = sim->e, per_mass = 0.0;
    tangent f = linear(t, h);
    if (!(t->depth + h * t->rate > 0.0) || (!(f.K > 0.0) && !(f.B > 0.0))) {
        return 0; // it does not press
    }
    memset(p, 0, sizeof *p * (size_t)n);
    stein__probe(sim, t, 0);
    for (int j = 0; j < n; j++) {
        p[j] = stein__driver_of(sim, j) == STEIN__FREE ? p[j] : 0.0;
        y[j] = p[j];
    }
    substitute(n, M, y);
    for (int j = 0; j < n; j++) {
        per_mass += p[j] * y[j];
    }
    if (h * sqrt(fmax(f.spring, 0.0) * per_mass) > fastest) {
        return -1;
    }
    double share = h * (fmax(f.B, 0.0) + h * fmax(f.K, 0.0));
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            A[i * n + j] += share * p[i] * p[j];
        }
        b[i] += p[i] * f.e;
    }
    return 0;
}

/* dqd [n] into b. @return 0, -1: the step is too long for a contact, or M is singular */
static int solve(stein_sim *sim, double h, double *b)
{
    int n = sim->model->nq;
    double *A = sim->M, *M = sim->work;
    sim->model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, A, sim->c);
    for (int j = 0; j < n; j++) {
        b[j] = sim->Q[j] - sim->c[j];
    }
    if (stein__prescribes(sim)) {
        stein__prescribe(sim, A, b);
    }
    memcpy(M, A, sizeof *M * (size_t)n * (size_t)n);
    if (factor(n, M) != 0) {
        return -1;
    }
    for (int i = 0; i < sim->ntouch; i++) {
        if (add_touch(sim, &sim->touch[i], h, M, A, b) != 0) {
            return -1;
        }
    }
    for (int j = 0; j < n; j++) {
        b[j] *= h;
    }
    if (factor(n, A) != 0) {
        return -1;
    }
    substitute(n, A, b);
    return 0;
}

/* The state at `target` by one implicit step, with the modes as they are. */
static stein_status step_implicitly(stein_sim *sim, double target, stein_err *err)
{
    int n = sim->model->nq;
    double h = target - sim->head->t, *dqd = sim->work + n * n;
    if (sim->model->nrow > 0 || sim->model->nball > 0 || sim->rider != NULL) {
        return refuse(sim, h, err); // what goes along knows explicit steps only
    }
    sim->fresh = STALE;
    stein_status status = stein__refresh(sim, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (solve(sim, h, dqd) != 0) {
        return refuse(sim, h, err);
    }
    for (int j = 0; j < n; j++) {
        sim->qd1[j] = sim->qd[j] + dqd[j];
        sim->q1[j] = sim->q[j] + h * sim->qd1[j];
        sim->qdd1[j] = dqd[j] / h;
    }
    status = stein__check_finite(sim, h, err);
    if (status == STEIN_OK) {
        stein__drive_from(sim, target, sim->q1, sim->qd1); // given joints exactly on track
        copy(sim->q1, sim->xq, n);
        copy(sim->qd1, sim->xqd, n);
        stein__accept(sim, target);
        sim->fresh = STALE;
        status = stein__refresh(sim, err);
    }
    return status;
}

/* ---- the rest ---- */

/* does a contact of the trial step end that has just begun? */
static int is_over(stein_sim *sim, double h)
{
    for (int i = 0; i < sim->nguard; i++) {
        if (sim->crossed[i] && sim->mode[i] && !stein__is_region(sim, i) &&
            stein__guard_at(sim, h, 0.0, i) <= begun) {
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
        sim->crossed[i] = i < sim->nguard && sim->crossed[i] && !sim->mode[i] &&
                          !stein__is_region(sim, i);
        any |= sim->crossed[i];
    }
    return any;
}

static void switch_over(stein_sim *sim)
{
    stein__mark_crossed(sim);
    stein__flip_crossed(sim);
}

stein_status stein__take_rest(stein_sim *sim, double target, stein_err *err)
{
    double h = target - sim->head->t;
    stein_status status = STEIN_OK;
    stein__mark_crossed(sim);
    int over = is_over(sim, h);
    if (!over && only_met(sim)) {
        stein__flip_crossed(sim);
        status = stein__refresh(sim, err);
        status = status == STEIN_OK ? stein__try(sim, h, 0, err) : status;
        if (status != STEIN_OK) {
            return status;
        }
        stein__mark_crossed(sim);
        over = is_over(sim, h);
    }
    if (over) {
        status = step_implicitly(sim, target, err);
    } else {
        stein__accept(sim, target);
    }
    if (status == STEIN_OK) {
        switch_over(sim);
    }
    return status;
}
