/* SPDX-License-Identifier: MIT
 * touch.c - the pairs that touch and rub, spots and notches: where their numbers are, once for a
 * simulation, and what follows from its parameters.
 */
#include "core.h"

INNER void stein__gather(stein_sim *sim)
{
    const stein_model *model = sim->model;
    const real *d = sim->d;
    for (int i = 0; i < model->nframe; i++) {
        const stein_frame *frame = &model->frames[i];
        const stein_body *body = &model->bodies[frame->body];
        int is_carried = frame->parent >= 0;
        sim->limb[i] = (limb){.wrench = &sim->wrench[i],
                              .onto = is_carried ? &sim->wrench[frame->parent] : NULL,
                              .pose = &sim->pose[i],
                              .parent_pose = &sim->pose[frame->parent],
                              .joint = frame->body,
                              .parent = frame->parent,
                              .kind = body->type == 'R'   ? LIMB_TURNS
                                      : body->axis == 'x' ? LIMB_ALONG_X
                                                          : LIMB_ALONG_Z,
                              .sign = body->sign};
    }
    for (int i = 0; i < model->nspot; i++) {
        const stein_spot *spot = &model->spots[i];
        const stein_contact *contact = &model->contacts[spot->contact];
        const stein_shape *side = spot->side;
        sim->site[i] = (site){.pair = {.index = spot->contact,
                                       .solid = side[0].kind == STEIN_SPHERE,
                                       .frame = {side[0].frame, side[1].frame},
                                       .normal = d + contact->normal,
                                       .friction = d + contact->friction,
                                       .stick = -1},
                              .line = side[1].kind == STEIN_LINE,
                              .a = d + side[0].d,
                              .b = d + side[1].d};
    }
    for (int i = 0; i < model->nnotch; i++) {
        const stein_notch *notch = &model->notches[i];
        sim->catch[i] = (pair){.index = model->ncontact + i,
                               .frame = {notch->beak, notch->catcher},
                               .normal = d + notch->normal,
                               .friction = d + notch->friction,
                               .stick = -1};
    }
    for (int j = 0; j < model->nq; j++) {
        sim->hold.joint[j] = -1;
    }
    for (int k = 0; k < model->nstick; k++) {
        const stein_stick *stick = &model->sticks[k];
        if (stick->kind == STEIN_STICK_SPOT) {
            sim->site[stick->index].pair.stick = k;
        } else {
            sim->hold.joint[stick->index] = k;
        }
    }
}

static void prepare_pair(stein_sim *sim, pair *p)
{
    p->parts = stein__normal_parts(p->normal) | stein__friction_parts(p->friction);
    p->inverse_vt = stein__inverse_vt(p->friction);
    p->plain =
        (p->parts & ~STEIN__RUBBING) == 0 && p->stick < 0 && !p->solid && sim->ntable_on == 0;
    for (int side = 0; side < 2 && !p->solid; side++) {
        p->pose[side] = &sim->pose[p->frame[side]];
        p->wrench[side] = &sim->wrench[p->frame[side]];
    }
}

INNER void stein__pairs_prepare(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nspot; i++) {
        site *s = &sim->site[i];
        prepare_pair(sim, &s->pair);
        int r = s->pair.solid ? (int)STEIN_SOLID_R : (int)STEIN_SHAPE_R;
        s->round = any(differ(s->a[r], 0.0));
        s->kind = !s->pair.plain || !s->line || s->round ? ANY_SPOT
                  : s->pair.frame[1] < 0                 ? ON_FIXED_LINE
                                                         : ON_LINE;
        s->reach = s->a[r] + s->b[r] - s->pair.normal[STEIN_NORMAL_GAP];
    }
    for (int i = 0; i < sim->model->nnotch; i++) {
        prepare_pair(sim, &sim->catch[i]);
    }
}
