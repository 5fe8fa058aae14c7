/* SPDX-License-Identifier: MIT
 * dynamics.c - from (t, q, qd) to qdd: what drives a mechanism from outside, and the order in which
 * an evaluation goes. (The forces of the mechanism itself are in forces.c.)
 */
#include <math.h>
#include <string.h>

#include "core.h"

/* put prescribed coordinates in place; signals stay in sim->ustate */
static void drive(stein_sim *sim, double t, const double *q, const double *qd)
{
    const stein_model *model = sim->model;
    if (q != sim->xq) {
        copy(sim->xq, q, model->nq);
        copy(sim->xqd, qd, model->nq);
    }
    for (int i = 0; i < model->ninput; i++) {
        if (sim->signal[i] != NULL) {
            const double *law = sim->d + model->inputs[i].signal;
            double *u = sim->ustate + 3 * i, gain = law[STEIN_SIGNAL_GAIN];
            u[0] = u[1] = u[2] = 0.0;
            sim->signal[i](sim->signal_ctx[i], t - law[STEIN_SIGNAL_DELAY], u);
            u[0] *= gain;
            u[1] *= gain;
            u[2] *= gain;
            if (model->inputs[i].kind == STEIN_INPUT_MOTION) {
                sim->xq[model->inputs[i].index] = u[0];
                sim->xqd[model->inputs[i].index] = u[1];
            }
        }
    }
}

/* the state's prescribed joints onto their signals, now */
void stein__place_driven(stein_sim *sim)
{
    drive(sim, sim->head->t, sim->q, sim->qd);
    memcpy(sim->q, sim->xq, sizeof *sim->q * (size_t)sim->model->nq);
    memcpy(sim->qd, sim->xqd, sizeof *sim->qd * (size_t)sim->model->nq);
}

void stein__wire(stein_sim *sim)
{
    const stein_model *model = sim->model;
    sim->jacobians = sim->motions = sim->signals = 0;
    for (int i = 0; i < model->ninput; i++) {
        const stein_input *input = &model->inputs[i];
        int on = sim->signal[i] != NULL;
        sim->signals |= on;
        sim->jacobians |=
            input->kind == STEIN_INPUT_POINT && on && model->points[input->index].at < 0;
        sim->motions |= input->kind == STEIN_INPUT_MOTION && (on || input->hold);
    }
    for (int i = 0; i < model->nlink; i++) {
        const stein_link *link = &model->links[i];
        sim->jacobians |=
            model->points[link->point[0]].at < 0 || model->points[link->point[1]].at < 0;
    }
}

/* the motion input that drives a joint with a signal or a hold */
int stein__driver_of(const stein_sim *sim, int joint)
{
    if (sim->held[joint]) {
        return STEIN__HELD;
    }
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        if (input->kind == STEIN_INPUT_MOTION && input->index == joint) {
            if (sim->signal[i] != NULL) {
                return i;
            }
            if (input->hold) {
                return STEIN__HELD;
            }
        }
    }
    return STEIN__FREE;
}

int stein__is_driven(const stein_sim *sim, int joint)
{
    return stein__driver_of(sim, joint) != STEIN__FREE;
}

int stein__driver(const stein_sim *sim, int joint, double *value)
{
    int by = stein__driver_of(sim, joint);
    *value = by >= 0 ? sim->ustate[3 * by + 2] : 0.0;
    return by != STEIN__FREE;
}

int stein__solved(stein_sim *sim, double *b)
{
    const stein_model *model = sim->model;
    return model->solve != NULL ? model->solve(sim->M, b)
                                : stein__solve(model->nq, sim->parent, sim->M, b, sim->inverse);
}

stein_status stein__evaluate(stein_sim *sim, double t, const double *q, const double *qd,
                             double *qdd, stein_err *err)
{
    const stein_model *model = sim->model;
    int nq = model->nq;
    drive(sim, t, q, qd);
    turn_joints(model, sim->xq, sim->sc);
    stein__forces(sim);
    if (sim->on_force != NULL) {
        sim->on_force(sim->force_ctx, t, sim->xq, sim->xqd, sim->Q);
    }
    int bad = stein__accelerate(sim, qdd);
    if (bad >= 0 && isfinite(sim->M[bad * nq + bad])) {
        return stein__fail(err, STEIN_ESINGULAR,
                           "the mass matrix is singular at joint \"%s\", t = %g s: what it carries "
                           "needs a mass or an inertia > 0",
                           model->bodies[bad].name, t);
    }
    return STEIN_OK;
}

/* poses of what rests at q */
static void pose_at(stein_sim *sim, const double *q)
{
    const stein_model *model = sim->model;
    if (model->nframe > 0) {
        turn_joints(model, q, sim->sc);
        model->pose(q, sim->zero, sim->sc, sim->d, sim->pose);
    }
}

void stein__guards(stein_sim *sim, const double *q, double *guard)
{
    const stein_model *model = sim->model;
    pose_at(sim, q);
    for (int i = 0; i < model->nspot; i++) {
        guard[i] = stein__spot_guard(sim, i);
    }
    for (int i = 0; i < model->nnotch; i++) {
        double overlap;
        stein__notch_guards(sim, i, guard + model->nspot + NOTCH_GUARDS * i, &overlap);
    }
}

double stein__guard(stein_sim *sim, const double *q, int i)
{
    int nspot = sim->model->nspot;
    pose_at(sim, q);
    if (i < nspot) {
        return stein__spot_guard(sim, i);
    }
    double guard[NOTCH_GUARDS], overlap;
    stein__notch_guards(sim, (i - nspot) / NOTCH_GUARDS, guard, &overlap);
    return guard[(i - nspot) % NOTCH_GUARDS];
}

void stein__place(stein_sim *sim)
{
    drive(sim, sim->head->t, sim->q, sim->qd);
    stein_turn(sim->model, sim->xq, sim->sc);
    if (sim->model->nframe > 0) {
        sim->model->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
    }
}

stein_status stein__refresh(stein_sim *sim, stein_err *err)
{
    if (sim->fresh != FRESH) {
        stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
        if (status != STEIN_OK) {
            return status;
        }
        sim->fresh = FRESH;
    }
    return STEIN_OK;
}
