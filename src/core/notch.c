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
 *   UNDER  -> BESIDE   when s < 0 and h > 0: escapement, if the beak had been in contact since
 *                      it was caught (at speed it flies the last tenths of a mm)
 *
 *   BESIDE -> UNDER    when h < 0: caught, ready for the next stroke
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
#include "core.h"

static inline real dot(vec2 a, vec2 b)
{
    return a.x * b.x + a.z * b.z;
}

static inline vec2 corner_of(const stein_sim *sim, const stein_notch *notch)
{
    const real *d = sim->d + notch->d;
    return place(&sim->pose[notch->catcher], d[STEIN_NOTCH_CX], d[STEIN_NOTCH_CZ]);
}

static inline vec2 end_of(const stein_sim *sim, const stein_notch *notch)
{
    const real *d = sim->d + notch->d;
    return place(&sim->pose[notch->beak], d[STEIN_NOTCH_EX], d[STEIN_NOTCH_EZ]);
}

/* outward normals: the roof looks down (r turned by +90), the face looks right (v turned by -90) */
static inline vec2 roof_of(const stein_sim *sim, const stein_notch *notch)
{
    const real *d = sim->d + notch->d;
    return turn(&sim->pose[notch->catcher], -d[STEIN_NOTCH_RZ], d[STEIN_NOTCH_RX]);
}

static inline vec2 face_of(const stein_sim *sim, const stein_notch *notch)
{
    const real *d = sim->d + notch->d;
    return turn(&sim->pose[notch->catcher], d[STEIN_NOTCH_VZ], -d[STEIN_NOTCH_VX]);
}

/* the inward one of the beak's upper face */
static inline vec2 down_of(const stein_sim *sim, const stein_notch *notch)
{
    const real *d = sim->d + notch->d;
    return turn(&sim->pose[notch->beak], d[STEIN_NOTCH_BZ], -d[STEIN_NOTCH_BX]);
}

static const flag *modes_of(const stein_sim *sim, int notch)
{
    return sim->mode + sim->model->nspot + NOTCH_GUARDS * notch;
}

INNER void stein__notch_guards(const stein_sim *sim, int i, real *guard, real *overlap)
{
    const stein_notch *notch = &sim->model->notches[i];
    const real *law = sim->d + notch->normal;
    vec2 e = end_of(sim, notch), c = corner_of(sim, notch), roof = roof_of(sim, notch);
    vec2 r = {e.x - c.x, e.z - c.z};
    real s = dot(r, (vec2){roof.z, -roof.x}), h = -dot(r, roof);
    real reach = law[STEIN_NORMAL_RANGE] - law[STEIN_NORMAL_GAP];
    mask beside = mask_of(modes_of(sim, i)[NOTCH_REGION]);
    real tip = same(-1.0), corner = same(-1.0), face = same(-1.0), region = h;
    if (any(beside)) {
        face = sel(beside, smaller(reach - dot(r, face_of(sim, notch)), h), face);
    }
    if (!every(beside)) {
        tip = sel(beside, tip, smaller(reach + h, s));
        corner = sel(beside, corner, smaller(reach - dot(r, down_of(sim, notch)), s));
        region = sel(beside, region, smaller(-s, h));
    }
    guard[NOTCH_TIP] = tip;
    guard[NOTCH_CORNER] = corner;
    guard[NOTCH_FACE] = face;
    guard[NOTCH_REGION] = region;
    *overlap = s;
}

INNER void stein__notches_look(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nnotch; i++) {
        spot_force *f = &sim->beak[i];
        if (sim->inside == AT_END) {
            real *guard = sim->guard + sim->model->nspot + NOTCH_GUARDS * i;
            stein__notch_guards(sim, i, guard, &f->gap);
        }
#if STEIN_LANES == 1
        f->depth = f->normal = f->tangent = 0.0;
#endif
    }
}

#if STEIN_LANES == 1

/* The configuration that the modes allow, the previous one first. The tip grazes the roof's plane
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

#endif
