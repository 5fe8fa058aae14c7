/* SPDX-License-Identifier: MIT
 * failure.c - why a motion ended: which contact is too stiff for a step, what gave no number.
 *
 * A contact at the depth x presses with f_n(x, xdot) and rubs with mu(v) f_n on what it meets
 * there: an effective mass 1/m = J M^-1 J^T along its normal, and another one along its tangent. So
 * its own motion is as fast as
 *
 *      sqrt(df_n/dx / m_n),   df_n/dxdot / m_n,   dmu/dv f_n / m_t / 5          [1/s]
 *
 * and an explicit Runge-Kutta method of order 4 or 5 follows while h times that is below 1.
 * (Friction turns round in passing: the published stroke goes well at a rate of 5.) This is asked
 * after a failure, or on request; never in a step.
 *
 * Three hinges that carry one body have a configuration in which two of their axes are parallel
 * (gimbal lock): M is singular there, and near it speeds are without bound. It is found by the
 * smallest eigenvalue of D^-1/2 M D^-1/2, D the diagonal of M; its eigenvector has the joints.
 */
#include <math.h>
#include <string.h>

#include "core.h"

/* a unit force at what touches, along its normal or across it, into Q */
void stein__probe(stein_sim *sim, const touch *t, int across)
{
    if (t->pair->solid) {
        stein__solid_probe(sim, t, across);
        return;
    }
    vec2 direction = across ? (vec2){t->n.z, -t->n.x} : t->n;
    clear(&sim->wrench->x, 3 * sim->model->nframe);
    apply(sim, t->pair->frame[0], t->at, direction);
    apply(sim, t->pair->frame[1], t->at, (vec2){-direction.x, -direction.z});
    stein__wrenches_to_joints(sim);
}

/* 1/m of what touches in that direction; the state's poses and touches are there */
static double mobility(stein_sim *sim, const touch *t, int across)
{
    const stein_model *model = sim->model;
    size_t nq = (size_t)model->nq;
    double *a = sim->work, sum = 0.0;
    memset(sim->Q, 0, sizeof *sim->Q * nq);
    stein__probe(sim, t, across);
    model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
    memcpy(a, sim->Q, sizeof *a * nq);
    if (stein__solved(sim, a) >= 0) {
        return 0.0;
    }
    for (size_t j = 0; j < nq; j++) {
        sum += sim->Q[j] * a[j];
    }
    return sum;
}

/* rate of one place that touches [1/s] */
static double rate_of(stein_sim *sim, const touch *t)
{
    static const double little = 1e-9, slow = 1e-6; /* m, m/s */
    const double *law = t->pair->normal;
    int parts = t->pair->parts;
    double x = t->sum->depth, xdot = t->sum->rate, f = stein__normal(law, parts, x, xdot);
    double along = mobility(sim, t, 0), across = mobility(sim, t, 1);
    double k = (stein__normal(law, parts, x + little, xdot) - f) / little;
    double b = (stein__normal(law, parts, x, xdot + slow) - f) / slow;
    const double *friction = t->pair->friction;
    double u = sim->slip[t - sim->touch], du = 1e-3; // in units of its turning speed
    double slope = (stein__mu(friction, parts, u + du, stein__tanh(u + du)) -
                    stein__mu(friction, parts, u - du, stein__tanh(u - du))) /
                   (2.0 * du);
    double rub = t->pair->stick >= 0 ? 0.0 : fabs(t->normal * slope * t->pair->inverse_vt);
    return fmax(sqrt(fmax(k * along, 0.0)), fmax(fabs(b) * along, rub * across / 5.0));
}

/* the largest of what touches at a state; forces and M are worked with */
static double stiffest_at(stein_sim *sim, double t, const double *q, const double *qd, int *index)
{
    double most = 0.0;
    sim->fresh = STALE;
    if (stein__evaluate(sim, t, q, qd, sim->qdd, NULL) != STEIN_OK) {
        return 0.0;
    }
    for (int i = 0; i < sim->ntouch; i++) {
        double rate = rate_of(sim, &sim->touch[i]);
        if (rate > most) {
            most = rate;
            *index = sim->touch[i].pair->index;
        }
    }
    return most;
}

double stein_stiffest(stein_sim *sim, int *index)
{
    int nq = sim->model->nq, fresh = sim->fresh;
    double *kept = sim->work + nq * nq;
    copy(sim->e, sim->qdd, nq); // asking changes no bit of the motion, nor of what is read
    copy(kept, sim->Q, nq);
    copy(kept + nq, sim->c, nq);
    double rate = stiffest_at(sim, sim->head->t, sim->q, sim->qd, index);
    copy(sim->qdd, sim->e, nq);
    copy(sim->Q, kept, nq);
    copy(sim->c, kept + nq, nq);
    sim->fresh = fresh;
    return rate;
}

/* Now, or half a step ahead or behind at the present speeds: a contact that begins or ends is not
 * deep now, but would be on the way. */
static double stiffest_of_step(stein_sim *sim, double h, int *index)
{
    double most = stein_stiffest(sim, index);
    for (int side = -1; side <= 1 && most * h <= 1.0; side += 2) {
        int there = -1;
        for (int j = 0; j < sim->model->nq; j++) {
            sim->q1[j] = sim->q[j] + 0.5 * side * h * sim->qd[j];
        }
        double rate = stiffest_at(sim, sim->head->t, sim->q1, sim->qd, &there);
        if (rate > most) {
            most = rate;
            *index = there;
        }
    }
    sim->fresh = STALE;
    return most;
}

static const double locked = 1e-2;    /* eigenvalue: axes within 6 degrees or so */
static const double takes_part = 0.3; /* component of a joint in the unit eigenvector */

/* v [nq], the eigenvector of the smallest eigenvalue of M scaled to a diagonal of 1, by inverse
 * iteration. @return the eigenvalue; 0 where M is singular */
static double softest(stein_sim *sim, double *v)
{
    const stein_model *model = sim->model;
    int n = model->nq;
    double value = 1.0, *scale = sim->e;
    sim->fresh = STALE;
    stein__drive_from(sim, sim->head->t, sim->q, sim->qd);
    stein_turn(model, sim->xq, sim->sc);
    model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
    for (int j = 0; j < n; j++) {
        scale[j] = sqrt(sim->M[j * n + j]);
        v[j] = 1.0 + 0.1 * j; // no symmetry
    }
    for (int i = 0; i < n * n; i++) {
        sim->M[i] /= scale[i / n] * scale[i % n];
    }
    if (stein__factor(n, sim->parent, sim->M, sim->inverse) >= 0) {
        return 0.0;
    }
    for (int k = 0; k < 8; k++) {
        double size = 0.0;
        for (int j = 0; j < n; j++) {
            size += v[j] * v[j];
        }
        for (int j = 0; j < n; j++) {
            v[j] /= sqrt(size);
        }
        value = 1.0 / sqrt(size);
        stein__substitute(n, sim->parent, sim->M, sim->inverse, v, 1);
    }
    double size = 0.0;
    for (int j = 0; j < n; j++) {
        size += v[j] * v[j];
    }
    for (int j = 0; j < n; j++) {
        v[j] /= sqrt(size);
    }
    return isfinite(size) ? value : 0.0;
}

double stein_gimbal(stein_sim *sim, int *first, int *last)
{
    const stein_model *model = sim->model;
    double *v = sim->work, value = model->nq < 3 ? 1.0 : softest(sim, v);
    int hinges = 0;
    *first = *last = -1;
    for (int j = 0; value < locked && j < model->nq; j++) {
        if (fabs(v[j]) > takes_part) {
            *first = hinges == 0 ? j : *first;
            *last = j;
            hinges += model->bodies[j].type == 'R' ? 1 : 3;
        }
    }
    if (hinges != 2) {
        *first = *last = -1;
        return 1.0;
    }
    return value;
}

/* the input whose signal was no number in the last evaluation, or NULL */
static const char *bad_signal(const stein_sim *sim)
{
    for (int i = 0; i < sim->model->ninput; i++) {
        const double *u = sim->ustate + 3 * i;
        if (sim->signal[i] != NULL && !(isfinite(u[0]) && isfinite(u[1]) && isfinite(u[2]))) {
            return sim->model->inputs[i].name;
        }
    }
    return NULL;
}

/* the joint for which the hook of forces gives no number in the present state, or NULL */
static const char *bad_hook(stein_sim *sim, double t)
{
    int nq = sim->model->nq;
    memset(sim->e, 0, sizeof *sim->e * (size_t)nq);
    if (sim->on_force != NULL) {
        sim->on_force(sim->force_ctx, t, sim->q, sim->qd, sim->e);
    }
    for (int j = 0; j < nq; j++) {
        if (!isfinite(sim->e[j])) {
            return sim->model->bodies[j].name;
        }
    }
    return NULL;
}

stein_status stein__explain_failure(stein_sim *sim, double h, stein_status code, const char *what,
                                    stein_err *err)
{
    const stein_model *model = sim->model;
    double t = sim->head->t;
    if (err == NULL) {
        return code;
    }
    const char *input = bad_signal(sim), *joint = bad_hook(sim, t);
    joint = joint != NULL ? joint : bad_hook(sim, t + h);
    if (input != NULL) {
        return stein__fail(err, code,
                           "%s after t = %g s: the signal of input \"%s\" is not finite there",
                           what, t, input);
    }
    if (joint != NULL) {
        return stein__fail(err, code,
                           "%s after t = %g s: the force hook gives joint \"%s\" no finite force",
                           what, t, joint);
    }
    int first, last;
    if (stein_gimbal(sim, &first, &last) < 1.0) {
        return stein__fail(err, code,
                           "%s after t = %g s: the axes of hinges \"%s\" and \"%s\" are nearly "
                           "parallel there (gimbal lock): another order of axes carries it through",
                           what, t, model->bodies[first].name, model->bodies[last].name);
    }
    // where it fails may be a part of a fixed step
    h = stein__is_controlled(sim->def.integrator) ? h : fmax(h, sim->def.dt);
    int index = -1;
    double rate = stiffest_of_step(sim, h, &index);
    if (stein__is_controlled(sim->def.integrator) && !(rate * h > 1.0)) {
        return stein__fail(err, code, "%s after t = %g s, in a step of %g s", what, t, h);
    }
    if (!(rate * h > 1.0)) {
        return stein__fail(err, code, "%s after t = %g s, in a step of %g s: try shorter ones",
                           what, t, h);
    }
    const char *name = index < model->ncontact ? model->contacts[index].name
                                               : model->notches[index - model->ncontact].name;
    if (rate * h > 1e4) { // a state that has left all bounds says nothing about a good step
        return stein__fail(err, code,
                           "%s after t = %g s: contact \"%s\" is too stiff for steps of %g s", what,
                           t, name, h);
    }
    return stein__fail(err, code,
                       "%s after t = %g s: contact \"%s\" is too stiff for steps of %g s, it needs "
                       "%g s or less",
                       what, t, name, h, 1.0 / rate);
}
