/* SPDX-License-Identifier: GPL-3.0-or-later
 * contact_poses.c - relative pose of two bodies at their contact, in one run of the file.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"
#include "added_parts.h"

typedef struct watch {
    const stein_model *m;
    double *d, *sc; /* [nd]; sines and cosines */
    stein_pose *pose;
    lab__touching *to;
} watch;

static stein_pose pose_of(const watch *w, int frame)
{
    return frame < 0 ? (stein_pose){.c = 1.0} : w->pose[frame];
}

static stein_status look(void *ctx, stein_sim *sim)
{
    watch *w = ctx;
    stein_turn(w->m, stein_q(sim), w->sc);
    w->m->pose(stein_q(sim), stein_qd(sim), w->sc, w->d, w->pose);
    for (int i = 0; i < w->m->ncontact; i++) {
        lab__touching *t = &w->to[i];
        const stein_spot *spot = &w->m->spots[w->m->contacts[i].first_spot];
        double depth = 0.0, speed;
        if (!stein_deformation(sim, i, &depth, &speed)) {
            continue;
        }
        if (spot->side[0].kind == STEIN_SPHERE) { // no plane angle: it may have turned anyhow
            *t = (lab__touching){.touch = 1, .c = 1.0, .turns = 1.0};
            continue;
        }
        stein_pose a = pose_of(w, spot->side[0].frame), b = pose_of(w, spot->side[1].frame);
        double c = a.c * b.c + a.s * b.s, s = a.s * b.c - a.c * b.s;
        if (!t->touch) {
            *t = (lab__touching){.touch = 1, .c = c, .s = s};
        }
        // behind a right angle a sine would get smaller again
        double turned = c * t->c + s * t->s > 0.0 ? fabs(s * t->c - c * t->s) : 1.0;
        t->turns = fmax(t->turns, turned);
        t->depth = fmax(t->depth, depth);
    }
    for (int i = w->m->ncontact; i < w->m->ncontact + w->m->nnotch; i++) {
        double depth = 0.0, speed;
        w->to[i].touch |= stein_deformation(sim, i, &depth, &speed);
        w->to[i].depth = fmax(w->to[i].depth, depth);
    }
    return STEIN_OK;
}

stein_status lab__touchings(lab__touching *to, const lab_model *model, stein_err *err)
{
    const stein_model *m = lab_equations(model);
    watch w = {.m = m, .to = to};
    stein_sim *sim = NULL;
    memset(to, 0, sizeof *to * (size_t)(m->ncontact + m->nnotch));
    if (m->ncontact + m->nnotch == 0 || m->nframe == 0) {
        return STEIN_OK;
    }
    w.d = malloc(sizeof *w.d * ((size_t)m->nd + 2 * (size_t)m->nq));
    w.pose = malloc(sizeof *w.pose * (size_t)m->nframe);
    stein_status status =
        w.d != NULL && w.pose != NULL ? lab_sim(model, NULL, &sim, err) : lab__no_memory(err);
    if (status == STEIN_OK) {
        stein_err why;
        lab_stroke_def def = lab_stroke_def_default(m);
        w.sc = w.d + m->nd;
        stein_setup(m, lab_parameters(model), w.d);
        def.sample = look;
        def.ctx = &w;
        status = lab_simulate(sim, &def, &why);
        if (status != STEIN_OK) { // it may touch other surfaces later
            memset(to, 0, sizeof *to * (size_t)(m->ncontact + m->nnotch));
        }
        status = fit__forgive(status, err);
    }
    stein_sim_destroy(sim);
    free(w.d);
    free(w.pose);
    return status;
}
