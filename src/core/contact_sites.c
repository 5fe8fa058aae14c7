/* SPDX-License-Identifier: MIT
 * contact_sites.c - the pairs that touch and rub, spots and notches: where their numbers are, once
 * for a simulation, and what follows from its parameters.
 */
#include "core.h"

#if STEIN_WIDEST == 8
#include "lane.h"
#endif

static site site_of_spot(stein_sim *sim, int i)
{
    const real *d = sim->d;
    const stein_spot *spot = &sim->model->spots[i];
    const stein_contact *contact = &sim->model->contacts[spot->contact];
    const stein_shape *side = spot->side;
    return (site){.pair = {.index = spot->contact,
                           .solid = side[0].kind == STEIN_SPHERE,
                           .frame = {side[0].frame, side[1].frame},
                           .normal = d + contact->normal,
                           .friction = d + contact->friction,
                           .stick = -1},
                  .guard = i,
                  .line = side[1].kind == STEIN_LINE,
                  .a = d + side[0].d,
                  .b = d + side[1].d,
                  .sum = &sim->spot[i]};
}

/* i: of all places of all notches */
static site site_of_notch(stein_sim *sim, int i)
{
    int k = i / NOTCH_REGION, place = i % NOTCH_REGION;
    const stein_notch *notch = &sim->model->notches[k];
    int is_corner = place == NOTCH_CORNER; // that of the catcher, on a line of the beak
    return (site){.pair = {.index = sim->model->ncontact + k,
                           .frame = {is_corner ? notch->catcher : notch->beak,
                                     is_corner ? notch->beak : notch->catcher},
                           .normal = sim->d + notch->normal,
                           .friction = sim->d + notch->friction,
                           .stick = -1},
                  .guard = sim->model->nspot + NOTCH_GUARDS * k + place,
                  .line = 1,
                  .sum = &sim->beak[k]};
}

#if STEIN_LANES == 1
static stein__contact_kernel widest(void)
{
    stein__contact_kernel two = {2, stein__contact_forces2, stein__contact_forces2_recorded,
                                 stein__contact_depths2};
#if STEIN_WIDEST == 8
    stein__contact_kernel four = {4, stein__contact_forces4, stein__contact_forces4_recorded,
                                  stein__contact_depths4};
    return stein__processor_lanes() >= 4 ? four : two;
#else
    return two;
#endif
}
#endif

INNER void stein__gather(stein_sim *sim)
{
    const stein_model *model = sim->model;
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
        sim->site[i] = site_of_spot(sim, i);
    }
    for (int i = model->nspot; i < sim->nsite; i++) {
        sim->site[i] = site_of_notch(sim, i - model->nspot);
    }
#if STEIN_LANES == 1
    sim->kernel = widest();
#endif
    for (int j = 0; j < model->nq; j++) {
        sim->hold.joint[j] = -1;
        if (model->bodies[j].type == 'R') {
            sim->turning[sim->nturning++] = j;
        }
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

static void prepare_spot(site *s)
{
    const real *a = s->a, *b = s->b;
    int r = s->pair.solid ? (int)STEIN_SOLID_R : (int)STEIN_SHAPE_R;
    s->round = any(differ(a[r], 0.0));
    s->reach = a[r] + b[r] - s->pair.normal[STEIN_NORMAL_GAP];
    if (!s->pair.solid) {
        s->at[0] = (vec2){a[STEIN_SHAPE_X], a[STEIN_SHAPE_Z]};
        s->at[1] = (vec2){b[STEIN_SHAPE_X], b[STEIN_SHAPE_Z]};
        s->n = (vec2){b[STEIN_SHAPE_NX], b[STEIN_SHAPE_NZ]};
        s->endless = s->line && !any(differ(b[STEIN_SHAPE_LO], -HUGE_VAL)) &&
                     !any(differ(b[STEIN_SHAPE_HI], HUGE_VAL));
    }
}

/* Outward normals of the second body: the roof looks down (r turned by +90), the face looks right
 * (v turned by -90). The corner is on the upper face of the beak. */
static void prepare_notch(site *s, const real *d, int place)
{
    vec2 beak = {d[STEIN_NOTCH_EX], d[STEIN_NOTCH_EZ]};
    vec2 corner = {d[STEIN_NOTCH_CX], d[STEIN_NOTCH_CZ]};
    vec2 roof = {-d[STEIN_NOTCH_RZ], d[STEIN_NOTCH_RX]};
    vec2 face = {d[STEIN_NOTCH_VZ], -d[STEIN_NOTCH_VX]};
    vec2 up = {-d[STEIN_NOTCH_BZ], d[STEIN_NOTCH_BX]};
    s->reach = -s->pair.normal[STEIN_NORMAL_GAP];
    s->at[0] = place == NOTCH_CORNER ? corner : beak;
    s->at[1] = place == NOTCH_CORNER ? beak : corner;
    s->n = place == NOTCH_TIP ? roof : place == NOTCH_CORNER ? up : face;
}

INNER void stein__pairs_prepare(stein_sim *sim)
{
    int nspot = sim->model->nspot;
    sim->active.n = -1;
    for (int i = 0; i < sim->nsite; i++) {
        site *s = &sim->site[i];
        prepare_pair(sim, &s->pair);
        if (i < nspot) {
            prepare_spot(s);
        } else {
            const stein_notch *notch = &sim->model->notches[(i - nspot) / NOTCH_REGION];
            prepare_notch(s, sim->d + notch->d, (i - nspot) % NOTCH_REGION);
        }
        s->kind = !s->pair.plain || !s->line || s->round ? ANY_SITE
                  : s->pair.frame[1] < 0                 ? ON_FIXED_LINE
                                                         : ON_LINE;
    }
}

#if STEIN_LANES == 1

/* a site as place k of a group */
static void put_in_lane(stein__group *g, int k, const site *s)
{
    const pair *p = &s->pair;
    for (int side = 0; side < 2; side++) {
        g->at[2 * side].of[k] = s->at[side].x;
        g->at[2 * side + 1].of[k] = s->at[side].z;
        g->pose[k][side] = &p->pose[side]->x;
        g->wrench[k][side] =
            side == 1 && p->frame[side] < 0 ? NULL : &p->wrench[side]->x; // at -1 the frame's
    }
    g->line[0].of[k] = s->n.x;
    g->line[1].of[k] = s->n.z;
    g->reach.of[k] = s->reach;
    for (int i = 0; i < STEIN_NORMAL_SIZE; i++) {
        g->normal[i].of[k] = p->normal[i];
    }
    g->level.of[k] = p->friction[STEIN_FRICTION_A];
    g->inverse_vt.of[k] = p->inverse_vt;
}

/* The unused lanes of a group repeat its last place. */
static void put_in_group(stein_sim *sim, stein__group *g, int i)
{
    for (int k = g->n; k < sim->kernel.most; k++) {
        put_in_lane(g, k, &sim->site[i]);
    }
    g->site[g->n++] = i;
}

/* The sites of the first n that are on, or that are not. Plain sites that follow each other are a
 * group: forces are summed in the order of sites. */
static void list(stein_sim *sim, places *p, int n, int on)
{
    stein__group *g = NULL, *next = p->group;
    p->n = 0;
    for (int i = 0; i < n; i++) {
        const site *s = &sim->site[i];
        if (sim->mode[s->guard] != on) {
            continue;
        }
        if (s->kind == ANY_SITE || !(on || s->endless)) {
            p->one[p->n++] = i;
            g = NULL;
            continue;
        }
        if (g == NULL || g->n == sim->kernel.most) {
            p->one[p->n++] = -1;
            g = next++;
            g->n = 0;
        }
        put_in_group(sim, g, i);
    }
}

/* By words: behind both there is room, which a copy has filled alike. (For a dozen bytes a call of
 * memcmp takes longer.) */
static int differs(const unsigned char *a, const unsigned char *b, int n)
{
    for (int i = 0; i < n; i += 8) {
        uint64_t x, y;
        memcpy(&x, a + i, sizeof x);
        memcpy(&y, b + i, sizeof y);
        if (x != y) {
            return 1;
        }
    }
    return 0;
}

void stein__find_active(stein_sim *sim)
{
    int n = sim->nguard;
    if (sim->active.n < 0 || differs(sim->as_of, sim->mode, n)) {
        memcpy(sim->as_of, sim->mode, (size_t)(n + 7) / 8 * 8);
        list(sim, &sim->active, sim->nsite, 1);
        list(sim, &sim->apart, sim->model->nspot, 0);
    }
}

#endif
