/* SPDX-License-Identifier: MIT
 * dynamics.c - from (t, q, qd) to qdd: the order in which an evaluation goes. (What drives a
 * mechanism from outside is in inputs.c, the forces of the mechanism itself are in forces.c.)
 */
#include <math.h>
#include <string.h>

#include "core.h"

int stein__solved(stein_sim *sim, double *b)
{
    const stein_model *model = sim->model;
    if (model->nrow > 0) {
        return stein__loops_solve(sim, b, 0);
    }
    return model->solve != NULL ? model->solve(sim->M, b)
                                : stein__solve(model->nq, sim->parent, sim->M, b, sim->inverse);
}

stein_status stein__evaluate(stein_sim *sim, double t, const double *q, const double *qd,
                             double *qdd, stein_err *err)
{
    const stein_model *model = sim->model;
    int nq = model->nq;
    stein__drive_from(sim, t, q, qd);
    turn_joints(sim, sim->xq, sim->sc);
    stein__forces(sim);
    if (sim->on_force != NULL) {
        sim->on_force(sim->force_ctx, t, sim->xq, sim->xqd, sim->Q);
    }
    for (int i = 0; i < model->nball; i++) {
        sim->Q[model->balls[i].joint] = 0.0;
    }
    int bad = stein__accelerate(sim, qdd);
    if (bad >= 0 && isfinite(sim->M[bad * nq + bad])) {
        return stein__fail(err, STEIN_ESINGULAR,
                           "the mass matrix is singular at joint \"%s\", t = %g s: what it carries "
                           "needs a mass or an inertia > 0",
                           model->bodies[bad].name, t);
    }
    if (model->nstick > 0 && bad < 0) {
        stein__stick_hold(sim, qdd);
    }
    return STEIN_OK;
}

void stein__place(stein_sim *sim)
{
    stein__drive_from(sim, sim->head->t, sim->q, sim->qd);
    stein_turn(sim->model, sim->xq, sim->sc);
    if (sim->model->nframe > 0) {
        sim->model->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
    }
    if (sim->model->npose3 > 0) {
        stein__place3(sim, sim->xq, sim->xqd);
    }
}

stein_status stein__refresh(stein_sim *sim, stein_err *err)
{
    if (sim->model->nrow > 0 && sim->loop.rank < 0) {
        stein__place_driven(sim);
        stein_status status = stein__loops_assemble(sim, 0, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    if (sim->fresh != FRESH) {
        stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
        if (status != STEIN_OK) {
            return status;
        }
        sim->fresh = FRESH;
    }
    return STEIN_OK;
}

stein_status stein__restart(stein_sim *sim, stein_err *err)
{
    const stein_model *model = sim->model;
    if (model->nrow > 0 || model->nstick > 0 || sim->follower != NULL) {
        return stein__refresh(sim, err);
    }
    stein__find_active(sim);
    sim->inside = IN_STAGE;
    stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
    sim->inside = AT_END;
    sim->fresh = status == STEIN_OK ? KNOWN : STALE;
    return status;
}
