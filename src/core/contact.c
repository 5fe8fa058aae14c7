/* SPDX-License-Identifier: MIT
 * contact.c - contact spots: where two primitives meet, how deep, how fast, with what force.
 *
 * Every pair of points, circles and one-sided lines is one of two cases. A point is a circle of
 * radius 0. Two lines touch at the ends of the first one; the reader writes them as two spots.
 *
 *      x = r0 + r1 - (P0 - P1).n      circle on line:    n the line's normal, r1 = 0
 *                                     circle on circle:  n from P1 to P0
 *
 * less `gap` for worn surfaces. x is the deformation, n points from side 1 to side 0, t is n turned
 * by -90 degrees. The force on side 0 is f_n n - mu(v) f_n t, with xdot and v from the velocities
 * of the two material points at the place of contact. Side 1 gets the opposite force at the same
 * place. Closed forms only: an iterative closest-point search would buy nothing for these shapes
 * and cost determinism of time.
 */
#include "pair_force.h"

/* what is known of a spot where it is compiled, beside the rest of it */
typedef struct shape {
    int line, round;
    stein__known of;
} shape;

static inline shape shape_of(const site *s)
{
    return (shape){s->line, s->round, {s->pair.frame[1] < 0, 0, AT_END}};
}

/* unit normal on side 0, which is r away from side 1 */
ALWAYS vec2 facing(const site *s, vec2 r, shape is)
{
    if (is.line) {
        return is.of.fixed ? s->n : turn(s->pair.pose[1], s->n.x, s->n.z);
    }
    real distance = root_of(r.x * r.x + r.z * r.z);
    mask is_apart = more(distance, 0.0);
    return (vec2){sel(is_apart, over(r.x, distance), same(0.0)),
                  sel(is_apart, over(r.z, distance), same(1.0))};
}

/* how the two sides are to each other; a line has no radius */
typedef struct meeting {
    vec2 centre, r, n; /* centre of side 0, that from centre of side 1, unit normal on side 0 */
    real depth;        /* deformation x; < 0 apart */
} meeting;

ALWAYS meeting meet(const site *s, shape is)
{
    vec2 pa = place(s->pair.pose[0], s->at[0].x, s->at[0].z);
    vec2 pb = is.of.fixed ? s->at[1] : place(s->pair.pose[1], s->at[1].x, s->at[1].z);
    vec2 r = {pa.x - pb.x, pa.z - pb.z}, n = facing(s, r, is);
    return (meeting){pa, r, n, s->reach - (r.x * n.x + r.z * n.z)};
}

/* the guard of a spot, > 0 where forces may act: depth and adhesion's range, within the line's ends
 */
ALWAYS real guard_of(const site *s, const meeting *m, shape is)
{
    real guard = m->depth + s->pair.normal[STEIN_NORMAL_RANGE];
    if (is.line && !s->endless) {
        real along = m->r.x * m->n.z - m->r.z * m->n.x;
        guard = smaller(guard, smaller(along - s->b[STEIN_SHAPE_LO], s->b[STEIN_SHAPE_HI] - along));
    }
    return guard;
}

/* the contact of the free load is gone with it */
static inline mask is_lifted(const stein_sim *sim, int contact)
{
    return contact == sim->model->load.contact ? no(sim->head->load_present) : (mask){0};
}

ALWAYS void contact_force_at(stein_sim *sim, const site *s, mask on, const meeting *m, shape is)
{
    vec2 at = m->centre;
    if (is.round) {
        real radius = s->a[STEIN_SHAPE_R];
        at = (vec2){at.x - radius * m->n.x, at.z - radius * m->n.z};
    }
    stein__contact_force(sim, &s->pair, on, at, m->n, m->depth, s->sum, is.of);
}

#if STEIN_LANES == 1

/* gap and guard of a spot; its force is set to 0 */
static void note(stein_sim *sim, int i, double depth, double guard)
{
    sim->spot[i] = (spot_force){.gap = -depth};
    sim->guard[i] = is_lifted(sim, sim->site[i].pair.index) ? -1.0 : guard;
}

static void look(stein_sim *sim, int i)
{
    shape is = shape_of(&sim->site[i]);
    meeting m = meet(&sim->site[i], is);
    note(sim, i, m.depth, guard_of(&sim->site[i], &m, is));
}

/* gap and guard of a spot on a line without ends, which follow from its depth */
static void note_depth(stein_sim *sim, int i, double depth)
{
    note(sim, i, depth, depth + sim->site[i].pair.normal[STEIN_NORMAL_RANGE]);
}

/* the spots that are apart, at the end of a step */
static void look_apart(stein_sim *sim)
{
    const stein__group *g = sim->apart.group;
    for (int k = 0; k < sim->apart.n; k++) {
        int i = sim->apart.one[k];
        if (i < 0) {
            stein__each depth;
            sim->kernel.depths(g, &depth);
            for (int lane = 0; lane < g->n; lane++) {
                note_depth(sim, g->site[lane], depth.of[lane]);
            }
            g++;
        } else if (sim->site[i].pair.solid) {
            stein__solid_forces(sim, i);
        } else {
            look(sim, i);
        }
    }
}

/* what is told of a spot that is on begins at 0 */
static void begin_spot(stein_sim *sim, int i)
{
    if (sim->inside == AT_END) {
        look(sim, i);
    } else if (stein__records_contacts(sim, sim->inside)) {
        sim->spot[i] = (spot_force){.gap = sim->spot[i].gap};
    }
}

/* a place that is on and not plain */
static void site_force(stein_sim *sim, int i)
{
    const site *s = &sim->site[i];
    if (s->pair.solid) {
        stein__solid_forces(sim, i);
        return;
    }
    if (i < sim->model->nspot) {
        begin_spot(sim, i);
    }
    shape is = shape_of(s);
    meeting m = meet(s, is);
    is.of.inside = sim->inside;
    contact_force_at(sim, s, 1, &m, is);
}

/* plain ones, and what they did */
static void recorded_forces(stein_sim *sim, const stein__group *g)
{
    stein__contact_record did;
    sim->kernel.forces_recorded(g, &did);
    for (int k = 0; k < g->n; k++) {
        int i = g->site[k];
        const site *s = &sim->site[i];
        if (sim->inside == AT_END && s->endless) {
            note_depth(sim, i, did.depth.of[k]);
        } else if (i < sim->model->nspot) {
            begin_spot(sim, i);
        }
        sim->touch[sim->ntouch] = (touch){.pair = &s->pair,
                                          .at = {did.at[0].of[k], did.at[1].of[k]},
                                          .n = {did.n[0].of[k], did.n[1].of[k]},
                                          .normal = did.normal.of[k],
                                          .depth = did.depth.of[k],
                                          .rate = did.rate.of[k],
                                          .speed = did.speed.of[k],
                                          .sum = s->sum};
        stein__record_contact(sim, did.slip.of[k], did.grip.of[k], did.tangent.of[k]);
    }
}

void stein__site_forces(stein_sim *sim)
{
    const stein__group *g = sim->active.group;
    if (sim->inside != IN_STAGE) {
        stein__find_active(sim);
    }
    if (sim->inside == AT_END) {
        look_apart(sim);
    }
    for (int k = 0; k < sim->active.n; k++) {
        int i = sim->active.one[k];
        if (i >= 0) {
            site_force(sim, i);
        } else if (sim->inside == IN_STAGE) {
            sim->kernel.forces(g++);
        } else {
            recorded_forces(sim, g++);
        }
    }
}

#else

/* the most usual places, where all is known of them but the numbers */
static const shape fixed_line = {1, 0, {1, 1, IN_STAGE}}, moving_line = {1, 0, {0, 1, IN_STAGE}};

/* the forces of a place, without a note of them; at the end of a step also the guard of a spot */
ALWAYS void force_where_on(stein_sim *sim, int i, mask on, shape is)
{
    const site *s = &sim->site[i];
    meeting m = meet(s, is);
    if (sim->inside == AT_END && i < sim->model->nspot) {
        sim->guard[i] = sel(is_lifted(sim, s->pair.index), same(-1.0), guard_of(s, &m, is));
    }
    if (any(on)) {
        contact_force_at(sim, s, on, &m, is);
    }
}

INNER void stein__site_forces(stein_sim *sim)
{
    for (int i = 0; i < sim->nsite; i++) {
        const site *s = &sim->site[i];
        mask on = mask_of(sim->mode[s->guard]);
        if (!any(on) && (sim->inside == IN_STAGE || i >= sim->model->nspot)) {
            continue;
        }
        switch (s->kind) {
        case ON_FIXED_LINE: force_where_on(sim, i, on, fixed_line); break;
        case ON_LINE: force_where_on(sim, i, on, moving_line); break;
        case ANY_SITE: force_where_on(sim, i, on, shape_of(s)); break;
        }
    }
}

#endif

INNER real stein__spot_guard(const stein_sim *sim, int i)
{
    const site *s = &sim->site[i];
#if STEIN_LANES == 1
    if (s->pair.solid) {
        return stein__solid_guard(sim, i);
    }
#endif
    meeting m = meet(s, shape_of(s));
    return sel(is_lifted(sim, s->pair.index), same(-1.0), guard_of(s, &m, shape_of(s)));
}

#if STEIN_LANES == 1

double stein__spot_gap(const stein_sim *sim, int i)
{
    return sim->site[i].pair.solid ? stein__solid_gap(sim, i)
                                   : -meet(&sim->site[i], shape_of(&sim->site[i])).depth;
}

/* plane angle through which a frame has turned */
static double angle_of(const stein_sim *sim, int frame)
{
    double angle = 0.0;
    for (; frame >= 0; frame = sim->limb[frame].parent) {
        const limb *l = &sim->limb[frame];
        angle -= l->kind == LIMB_TURNS ? l->sign * sim->xq[l->joint] : 0.0;
    }
    return angle;
}

/* On a line the place of side 0 along it, and what a radius rolls. */
double stein__spot_slid(const stein_sim *sim, int i)
{
    const site *s = &sim->site[i];
    if (!s->line) {
        return 0.0;
    }
    meeting m = meet(s, shape_of(s));
    double turned = angle_of(sim, s->pair.frame[0]) - angle_of(sim, s->pair.frame[1]);
    return m.r.x * m.n.z - m.r.z * m.n.x + s->a[STEIN_SHAPE_R] * turned;
}

static vec2 cross(double w, vec2 r)
{
    return (vec2){-w * r.z, w * r.x};
}

/* Acceleration of a frame's origin with qdd = 0. No frame then has an angular acceleration, and its
 * joint moves in its parent with the velocity that is not that of the parent's material there. */
static vec2 origin_bias(const stein_sim *sim, int frame)
{
    vec2 a = {0.0, 0.0};
    for (; frame >= 0; frame = sim->limb[frame].parent) {
        const stein_pose *p = &sim->pose[frame], *up = &sim->pose[sim->limb[frame].parent];
        vec2 r = {p->x - up->x, p->z - up->z}, carried = velocity(up, (vec2){p->x, p->z});
        vec2 twice = cross(2.0 * up->w, (vec2){p->vx - carried.x, p->vz - carried.z});
        a.x += twice.x - up->w * up->w * r.x;
        a.z += twice.z - up->w * up->w * r.z;
    }
    return a;
}

/* of the material of a frame at a place that moves with the velocity `moves` */
static vec2 material_bias(const stein_sim *sim, int frame, vec2 moves)
{
    const stein_pose *p = &sim->pose[frame];
    vec2 a = origin_bias(sim, frame),
         turning = cross(p->w, (vec2){moves.x - p->vx, moves.z - p->vz});
    return (vec2){a.x + turning.x, a.z + turning.z};
}

double stein__spot_bias(const stein_sim *sim, int i, const touch *t)
{
    const site *s = &sim->site[i];
    const stein_pose *a = &sim->pose[s->pair.frame[0]], *b = &sim->pose[s->pair.frame[1]];
    meeting m = meet(s, shape_of(s));
    vec2 n = m.n, centre = velocity(a, m.centre), turns; // turns: rate of n
    if (s->line) {
        turns = cross(b->w, n);
    } else {
        vec2 other = velocity(b, (vec2){m.centre.x - m.r.x, m.centre.z - m.r.z});
        vec2 rate = {centre.x - other.x, centre.z - other.z};
        double along = rate.x * n.x + rate.z * n.z, distance = m.r.x * n.x + m.r.z * n.z;
        turns = (vec2){(rate.x - along * n.x) / distance, (rate.z - along * n.z) / distance};
    }
    double radius = s->a[STEIN_SHAPE_R];
    vec2 moves = {centre.x - radius * turns.x, centre.z - radius * turns.z};
    vec2 va = velocity(a, t->at), vb = velocity(b, t->at);
    vec2 aa = material_bias(sim, s->pair.frame[0], moves);
    vec2 ab = material_bias(sim, s->pair.frame[1], moves);
    return (aa.x - ab.x) * n.z - (aa.z - ab.z) * n.x + (va.x - vb.x) * turns.z -
           (va.z - vb.z) * turns.x;
}

int stein_deformation(const stein_sim *sim, int index, double *x, double *xdot)
{
    const stein_model *model = sim->model;
    const spot_force *f = NULL;
    if (index >= model->ncontact && index < model->ncontact + model->nnotch) {
        f = &sim->beak[index - model->ncontact];
    } else if (index >= 0 && index < model->ncontact) {
        const stein_contact *contact = &model->contacts[index];
        for (int i = contact->first_spot; i < contact->first_spot + contact->nspot; i++) {
            f = f == NULL || sim->spot[i].depth > f->depth ? &sim->spot[i] : f;
        }
    }
    if (f == NULL || !(f->depth > 0.0)) {
        return 0;
    }
    *x = f->depth;
    *xdot = f->rate;
    return 1;
}

#endif
