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

const stein_pose stein__fixed_frame = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0};

typedef struct spot_geometry {
    double depth; /* deformation x [m]; < 0 apart */
    double guard; /* > 0 where forces may act: depth and adhesion's range, within the line's ends */
    vec2 n;       /* unit normal on side 0 */
    vec2 at;      /* place of contact */
} spot_geometry;

static spot_geometry meet(const stein_sim *sim, const stein_spot *spot, const stein_pose *pose0,
                          const stein_pose *pose1)
{
    const double *a = sim->d + spot->side[0].d;
    const double *b = sim->d + spot->side[1].d;
    vec2 pa = place(pose0, a[STEIN_SHAPE_X], a[STEIN_SHAPE_Z]);
    vec2 pb = place(pose1, b[STEIN_SHAPE_X], b[STEIN_SHAPE_Z]);
    vec2 r = {pa.x - pb.x, pa.z - pb.z};
    const double *law = sim->d + sim->model->contacts[spot->contact].normal;
    double gap = law[STEIN_NORMAL_GAP], reach = law[STEIN_NORMAL_RANGE];
    spot_geometry g;
    if (spot->side[1].kind == STEIN_LINE) {
        double nx = b[STEIN_SHAPE_NX], nz = b[STEIN_SHAPE_NZ];
        g.n = (vec2){pose1->c * nx - pose1->s * nz, pose1->s * nx + pose1->c * nz};
        g.depth = a[STEIN_SHAPE_R] - gap - (r.x * g.n.x + r.z * g.n.z);
        double along = r.x * g.n.z - r.z * g.n.x;
        double inside = smaller(along - b[STEIN_SHAPE_LO], b[STEIN_SHAPE_HI] - along);
        g.guard = smaller(g.depth + reach, inside);
    } else {
        double distance = sqrt(r.x * r.x + r.z * r.z);
        g.n = distance > 0.0 ? (vec2){r.x / distance, r.z / distance} : (vec2){0.0, 1.0};
        g.depth = a[STEIN_SHAPE_R] + b[STEIN_SHAPE_R] - gap - distance;
        g.guard = g.depth + reach;
    }
    g.at = (vec2){pa.x - a[STEIN_SHAPE_R] * g.n.x, pa.z - a[STEIN_SHAPE_R] * g.n.z};
    return g;
}

double stein__spot_guard(const stein_sim *sim, const stein_pose *pose, int i)
{
    const stein_spot *spot = &sim->model->spots[i];
    return meet(sim, spot, pose_of(pose, spot->side[0].frame), pose_of(pose, spot->side[1].frame))
        .guard;
}

double stein__spot_gap(const stein_sim *sim, const stein_pose *pose, int i)
{
    const stein_spot *spot = &sim->model->spots[i];
    return -meet(sim, spot, pose_of(pose, spot->side[0].frame), pose_of(pose, spot->side[1].frame))
                .depth;
}

/* the contact of the free load is gone with it */
static int is_lifted(const stein_sim *sim, int contact)
{
    return !sim->head->load_present && contact == sim->model->load.contact;
}

void stein__spot_forces(stein_sim *sim)
{
    const stein_model *model = sim->model;
    for (int i = 0; i < model->nspot; i++) {
        const stein_spot *spot = &model->spots[i];
        if (sim->inside && !sim->mode[i]) {
            sim->spot[i].depth = 0.0;
            continue; // its gap and guard are asked for at the end of the step
        }
        const stein_contact *contact = &model->contacts[spot->contact];
        const stein_pose *pose0 = pose_of(sim->pose, spot->side[0].frame);
        const stein_pose *pose1 = pose_of(sim->pose, spot->side[1].frame);
        spot_geometry g = meet(sim, spot, pose0, pose1);
        spot_force *f = &sim->spot[i];
        *f = (spot_force){.gap = -g.depth};
        sim->guard[i] = is_lifted(sim, spot->contact) ? -1.0 : g.guard;
        if (!sim->mode[i]) {
            continue;
        }

        // rates of approach and of sliding, from the two materials at the place of contact
        vec2 v0 = velocity(pose0, g.at), v1 = velocity(pose1, g.at);
        vec2 v = {v0.x - v1.x, v0.z - v1.z};
        vec2 t = {g.n.z, -g.n.x};
        double rate = -(v.x * g.n.x + v.z * g.n.z);
        f->depth = g.depth;
        f->rate = rate;
        f->normal = stein_normal_force(sim->d + contact->normal, g.depth, rate);
        f->normal = stein__tables_normal(sim, spot->contact, f->normal, g.depth, rate);
        if (f->normal > 0.0) {
            f->tangent =
                -f->normal * stein_friction(sim->d + contact->friction, v.x * t.x + v.z * t.z);
        }

        vec2 force = {f->normal * g.n.x + f->tangent * t.x, f->normal * g.n.z + f->tangent * t.z};
        apply(sim, spot->side[0].frame, pose0, g.at, force);
        apply(sim, spot->side[1].frame, pose1, g.at, (vec2){-force.x, -force.z});
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
