/* SPDX-License-Identifier: MIT
 * contact.c - contact spots: where two primitives meet, how deep, how fast, with what force.
 *
 * Every pair of points, circles and one-sided lines is one of two cases (a point is a circle of
 * radius 0; two lines touch at the ends of the first, written out as two spots by the reader):
 *
 *      circle on line      x = r - (P0 - P1).n        n: the line's normal
 *      circle on circle    x = r0 + r1 - |P0 - P1|    n: from P1 to P0
 *
 * less `gap` for worn surfaces. x is the deformation, n points from side 1 to side 0, t is n turned
 * by -90 degrees. The force on side 0 is f_n n - mu(v) f_n t with xdot and v from the velocities of
 * the two material points at the place of contact; side 1 gets the opposite force at the same
 * place. Closed forms only: an iterative closest-point search would buy nothing for these shapes
 * and cost determinism of time.
 */
#include <math.h>

#include "core.h"

typedef struct spot_geometry {
    double depth; /* deformation x [m]; < 0 apart */
    double guard; /* > 0 where forces may act: depth and adhesion's range, within the line's ends */
    vec2 n;       /* unit normal on side 0 */
    vec2 at;      /* place of contact */
} spot_geometry;

void stein__spot_site(stein_sim *sim, int i)
{
    const stein_spot *spot = &sim->model->spots[i];
    const stein_contact *contact = &sim->model->contacts[spot->contact];
    sim->site[i] = (site){.contact = spot->contact,
                          .frame = {spot->side[0].frame, spot->side[1].frame},
                          .line = spot->side[1].kind == STEIN_LINE,
                          .a = sim->d + spot->side[0].d,
                          .b = sim->d + spot->side[1].d,
                          .normal = sim->d + contact->normal,
                          .friction = sim->d + contact->friction};
}

static inline spot_geometry meet(const site *s, const stein_pose *pose0, const stein_pose *pose1)
{
    const double *a = s->a, *b = s->b;
    double radius = a[STEIN_SHAPE_R], reach = s->normal[STEIN_NORMAL_RANGE];
    vec2 pa = place(pose0, a[STEIN_SHAPE_X], a[STEIN_SHAPE_Z]);
    vec2 pb = place(pose1, b[STEIN_SHAPE_X], b[STEIN_SHAPE_Z]);
    vec2 r = {pa.x - pb.x, pa.z - pb.z};
    spot_geometry g;
    if (s->line) {
        double nx = b[STEIN_SHAPE_NX], nz = b[STEIN_SHAPE_NZ];
        g.n = (vec2){pose1->c * nx - pose1->s * nz, pose1->s * nx + pose1->c * nz};
        g.depth = radius - s->normal[STEIN_NORMAL_GAP] - (r.x * g.n.x + r.z * g.n.z);
        double along = r.x * g.n.z - r.z * g.n.x;
        double inside = smaller(along - b[STEIN_SHAPE_LO], b[STEIN_SHAPE_HI] - along);
        g.guard = smaller(g.depth + reach, inside);
    } else {
        double distance = sqrt(r.x * r.x + r.z * r.z);
        g.n = distance > 0.0 ? (vec2){r.x / distance, r.z / distance} : (vec2){0.0, 1.0};
        g.depth = radius + b[STEIN_SHAPE_R] - s->normal[STEIN_NORMAL_GAP] - distance;
        g.guard = g.depth + reach;
    }
    g.at = (vec2){pa.x - radius * g.n.x, pa.z - radius * g.n.z};
    return g;
}

static spot_geometry meet_now(const stein_sim *sim, int i)
{
    const site *s = &sim->site[i];
    return meet(s, &sim->pose[s->frame[0]], &sim->pose[s->frame[1]]);
}

double stein__spot_guard(const stein_sim *sim, int i)
{
    return meet_now(sim, i).guard;
}

double stein__spot_gap(const stein_sim *sim, int i)
{
    return -meet_now(sim, i).depth;
}

/* the contact of the free load is gone with it */
static int is_lifted(const stein_sim *sim, int contact)
{
    return !sim->head->load_present && contact == sim->model->load.contact;
}

/* the forces of a spot that is on, into the wrenches of both sides */
static inline spot_force press(stein_sim *sim, const site *s, const stein_pose *pose0,
                               const stein_pose *pose1, spot_geometry g)
{
    // rates of approach and of sliding, from the two materials at the place of contact
    vec2 v0 = velocity(pose0, g.at), v1 = velocity(pose1, g.at);
    vec2 v = {v0.x - v1.x, v0.z - v1.z};
    vec2 t = {g.n.z, -g.n.x};
    double rate = -(v.x * g.n.x + v.z * g.n.z), tangent = 0.0;
    double normal = normal_force(sim, s->contact, s->normal, g.depth, rate);
    if (normal > 0.0) {
        tangent = -normal * stein__mu(s->friction, v.x * t.x + v.z * t.z);
    }
    vec2 force = {normal * g.n.x + tangent * t.x, normal * g.n.z + tangent * t.z};
    apply(sim, s->frame[0], pose0, g.at, force);
    apply(sim, s->frame[1], pose1, g.at, (vec2){-force.x, -force.z});
    return (spot_force){-g.depth, normal, tangent, g.depth, rate};
}

void stein__spot_forces(stein_sim *sim)
{
    int n = sim->model->nspot;
    for (int i = 0; i < n; i++) {
        const site *s = &sim->site[i];
        if (sim->inside && !sim->mode[i]) {
            sim->spot[i].depth = 0.0;
            continue; // its gap and guard are asked for at the end of the step
        }
        const stein_pose *pose0 = &sim->pose[s->frame[0]], *pose1 = &sim->pose[s->frame[1]];
        spot_geometry g = meet(s, pose0, pose1);
        sim->guard[i] = is_lifted(sim, s->contact) ? -1.0 : g.guard;
        if (sim->mode[i]) {
            sim->spot[i] = press(sim, s, pose0, pose1, g);
        } else {
            sim->spot[i] = (spot_force){.gap = -g.depth};
        }
    }
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
