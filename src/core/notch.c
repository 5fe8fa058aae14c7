/* SPDX-License-Identifier: MIT
 * notch.c - the beak in the notch: a contact that needs memory.
 *
 *            v ^     | the catcher's (pawl's) material is to the left of the vertical face
 *    pawl      |     | and above the roof; C is the corner where they meet.
 *              |     E' .... beak's end after escapement (phase iv, on the vertical face)
 *   r <--------C
 *      roof   /E------------ beak, its upper face from the end E towards the hammer's hinge
 *
 * From positions alone the contact is ambiguous: a beak's end inside the material may have come
 * through the roof or through the vertical face. The memory is one region per notch, UNDER the roof
 * or BESIDE the vertical face; the previous region is kept while it is valid (the paper's rule):
 *
 *   s = (E - C).r   overlap, > 0 while the end is under the roof
 *   h = (E - C) . (inward normal of the roof), > 0 while the end is above the roof's plane
 *
 *   UNDER  -> BESIDE   when s < 0 and h > 0   (escapement, if the beak had been in contact since it
 * was caught: at speed it flies the last tenths of a mm) BESIDE -> UNDER    when h < 0 (caught:
 * ready for the next stroke)
 *
 * UNDER, the areal contact of beak and roof is carried by the two ends of the overlap, each a point
 * on a line with the same law:
 *
 *   tip     E on the roof            depth h            alone: phase i
 *   corner  C on the beak's face     depth (E - C).n_b  alone: phase iii, both: phase ii
 *
 * so the equivalent point of contact moves from E to C without a jump as the beak turns. A single
 * equivalent point at the centroid of the overlap was tried on paper and rejected: its force is not
 * the gradient of any stored energy. BESIDE, E lies on the vertical face (phase iv), depth
 * -(E - C).n_v. At escapement the corner loses the beak at once, and the force drops to zero: the
 * step is cut exactly there.
 */
#include <math.h>

#include "core.h"

typedef struct notch_geometry {
    vec2 end, corner;     /* E, C in the fixed frame */
    vec2 roof, face, top; /* outward normals of roof, vertical face and beak's upper face */
    double s, h;          /* overlap, height above the roof's plane [m] */
    double depth[3];      /* tip, corner, face */
} notch_geometry;

static vec2 turn(const stein_pose *p, double x, double z)
{
    return (vec2){p->c * x - p->s * z, p->s * x + p->c * z};
}

static double dot(vec2 a, vec2 b)
{
    return a.x * b.x + a.z * b.z;
}

static inline notch_geometry look(const stein_sim *sim, const stein_notch *notch,
                                  const stein_pose *catcher, const stein_pose *beak)
{
    const double *d = sim->d + notch->d;
    double gap = sim->d[notch->normal + STEIN_NORMAL_GAP];
    notch_geometry g;
    g.corner = place(catcher, d[STEIN_NOTCH_CX], d[STEIN_NOTCH_CZ]);
    g.end = place(beak, d[STEIN_NOTCH_EX], d[STEIN_NOTCH_EZ]);
    vec2 along = turn(catcher, d[STEIN_NOTCH_RX], d[STEIN_NOTCH_RZ]);
    vec2 up = turn(catcher, d[STEIN_NOTCH_VX], d[STEIN_NOTCH_VZ]);
    vec2 beak_along = turn(beak, d[STEIN_NOTCH_BX], d[STEIN_NOTCH_BZ]);

    // outward: roof looks down (r turned by +90), face looks right (v turned by -90)
    g.roof = (vec2){-along.z, along.x};
    g.face = (vec2){up.z, -up.x};
    g.top = (vec2){-beak_along.z, beak_along.x};

    vec2 r = {g.end.x - g.corner.x, g.end.z - g.corner.z};
    g.s = dot(r, along);
    g.h = -dot(r, g.roof);
    g.depth[NOTCH_TIP] = g.h - gap;
    g.depth[NOTCH_CORNER] = dot(r, g.top) - gap;
    g.depth[NOTCH_FACE] = -dot(r, g.face) - gap;
    return g;
}

static void guards(const notch_geometry *g, double reach, int beside, double *guard)
{
    double s = g->s, h = g->h;
    guard[NOTCH_TIP] = beside ? -1.0 : smaller(g->depth[NOTCH_TIP] + reach, s);
    guard[NOTCH_CORNER] = beside ? -1.0 : smaller(g->depth[NOTCH_CORNER] + reach, s);
    guard[NOTCH_FACE] = beside ? smaller(g->depth[NOTCH_FACE] + reach, h) : -1.0;
    guard[NOTCH_REGION] = beside ? h : smaller(-s, h);
}

static const unsigned char *modes_of(const stein_sim *sim, int notch)
{
    return sim->mode + sim->model->nspot + NOTCH_GUARDS * notch;
}

void stein__notch_guards(const stein_sim *sim, int i, double *guard, double *overlap)
{
    const stein_notch *notch = &sim->model->notches[i];
    notch_geometry g = look(sim, notch, &sim->pose[notch->catcher], &sim->pose[notch->beak]);
    guards(&g, sim->d[notch->normal + STEIN_NORMAL_RANGE], modes_of(sim, i)[NOTCH_REGION], guard);
    *overlap = g.s;
}

/* one point-on-line contact of the notch: force on the beak along n at a place */
static inline void press(stein_sim *sim, const stein_notch *notch, const stein_pose *catcher,
                         const stein_pose *beak, vec2 at, vec2 n, double depth, spot_force *sum)
{
    vec2 vb = velocity(beak, at), vc = velocity(catcher, at);
    vec2 v = {vb.x - vc.x, vb.z - vc.z};
    vec2 t = {n.z, -n.x};
    double rate = -dot(v, n);
    int index = sim->model->ncontact + (int)(notch - sim->model->notches);
    double normal = normal_force(sim, index, sim->d + notch->normal, depth, rate);
    double tangent = 0.0;
    if (normal > 0.0) {
        tangent = -normal * stein__mu(sim->d + notch->friction, dot(v, t));
    }
    vec2 force = {normal * n.x + tangent * t.x, normal * n.z + tangent * t.z};
    apply(sim, notch->beak, beak, at, force);
    apply(sim, notch->catcher, catcher, at, (vec2){-force.x, -force.z});
    if (depth > sum->depth) {
        sum->depth = depth;
        sum->rate = rate;
    }
    sum->normal += normal;
    sum->tangent += tangent;
}

void stein__notch_forces(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nnotch; i++) {
        const stein_notch *notch = &sim->model->notches[i];
        const unsigned char *mode = modes_of(sim, i);
        if (sim->inside && !mode[NOTCH_TIP] && !mode[NOTCH_CORNER] && !mode[NOTCH_FACE]) {
            sim->beak[i].depth = 0.0;
            continue;
        }
        const stein_pose *catcher = &sim->pose[notch->catcher];
        const stein_pose *beak = &sim->pose[notch->beak];
        notch_geometry g = look(sim, notch, catcher, beak);
        guards(&g, sim->d[notch->normal + STEIN_NORMAL_RANGE], mode[NOTCH_REGION],
               sim->guard + sim->model->nspot + NOTCH_GUARDS * i);

        spot_force *sum = &sim->beak[i];
        *sum = (spot_force){.gap = g.s};
        if (mode[NOTCH_TIP]) {
            press(sim, notch, catcher, beak, g.end, g.roof, g.depth[NOTCH_TIP], sum);
        }
        if (mode[NOTCH_CORNER]) {
            vec2 down = {-g.top.x, -g.top.z};
            press(sim, notch, catcher, beak, g.corner, down, g.depth[NOTCH_CORNER], sum);
        }
        if (mode[NOTCH_FACE]) {
            press(sim, notch, catcher, beak, g.end, g.face, g.depth[NOTCH_FACE], sum);
        }
    }
}

/* The configuration that the modes allow, the previous one first: the tip grazes the roof's plane
 * for a microsecond when the corner is about to lose the beak, and that is still phase iii. */
unsigned char stein__notch_phase_after(const unsigned char *mode, int previous)
{
    if (mode[NOTCH_REGION]) {
        return mode[NOTCH_FACE] ? 4 : 0;
    }
    if (mode[NOTCH_CORNER]) {
        return mode[NOTCH_TIP] && previous != 3 ? 2 : 3;
    }
    return mode[NOTCH_TIP] ? 1 : 0;
}

int stein_notch_phase(const stein_sim *sim, int notch)
{
    return notch < 0 || notch >= sim->model->nnotch ? -1 : sim->phase[notch];
}
