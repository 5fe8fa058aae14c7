/* SPDX-License-Identifier: MIT
 * touch.c - the forces of all that touches and rubs: spots, notches, joints.
 *
 * The force on the first body of a pair is f_n n - mu(v) f_n t, t being n turned by -90 degrees,
 * the second body gets the opposite one at the same place; f_n from the depth and its rate, v the
 * speed of sliding along t.
 *
 * First everything finds out how fast it slides, then the tanh of all frictions are worked out in a
 * row, and the forces follow. One contact after the other would each wait for the divisions and the
 * polynomial of its tanh.
 */
#include "press.h"

INNER void stein__gather(stein_sim *sim)
{
    const stein_model *model = sim->model;
    const real *d = sim->d;
    for (int i = 0; i < model->nframe; i++) {
        const stein_frame *frame = &model->frames[i];
        const stein_body *body = &model->bodies[frame->body];
        sim->limb[i] = (limb){.joint = frame->body,
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

static void prepare_pair(pair *p)
{
    p->parts = stein__normal_parts(p->normal) | stein__friction_parts(p->friction);
    p->inverse_vt = stein__inverse_vt(p->friction);
}

INNER void stein__pairs_prepare(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nspot; i++) {
        site *s = &sim->site[i];
        prepare_pair(&s->pair);
        int r = s->pair.solid ? (int)STEIN_SOLID_R : (int)STEIN_SHAPE_R;
        s->round = any(differ(s->a[r], 0.0));
        s->reach = s->a[r] + s->b[r] - s->pair.normal[STEIN_NORMAL_GAP];
    }
    for (int i = 0; i < sim->model->nnotch; i++) {
        prepare_pair(&sim->catch[i]);
    }
}

static void push(stein_sim *sim, const touch *p, real mu)
{
#if STEIN_LANES == 1
    if (p->pair->solid) {
        stein__solid_push(sim, p, mu);
        return;
    }
#endif
    vec2 n = p->n, t = {n.z, -n.x};
    real normal = p->normal, tangent = sel(more(normal, 0.0), -normal * mu, same(0.0));
    vec2 force = {normal * n.x + tangent * t.x, normal * n.z + tangent * t.z};
    apply(sim, p->pair->frame[0], p->at, force);
    if (p->pair->frame[1] >= 0) {
        apply(sim, p->pair->frame[1], p->at, (vec2){-force.x, -force.z});
    }
    if (TELLS_FORCES) {
        p->sum->normal += normal;
        p->sum->tangent += tangent;
    }
}

INNER void stein__rub(stein_sim *sim)
{
    int n = sim->ntouch, nacting = sim->nacting;
    real *slip = sim->slip, *grip = sim->grip;
    for (int k = 0; k < nacting; k++) {
        int j = sim->acting[k];
        slip[n + k] = sim->xqd[j] * sim->inverse_vt[j];
    }
    for (int i = 0; i < n + nacting; i++) {
        grip[i] = stein__tanh(slip[i]);
    }
    for (int i = 0; i < n; i++) {
        const touch *p = &sim->touch[i];
#if STEIN_LANES == 1
        push(sim, p, stein__touch_mu(sim, i));
#else
        push(sim, p, stein__mu(p->pair->friction, p->pair->parts, slip[i], grip[i]));
#endif
    }
}
