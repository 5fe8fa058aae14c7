/* SPDX-License-Identifier: MIT
 * planar.h - directions, places, velocities and forces of bodies in the plane.
 * Included by: this folder.
 */
#ifndef STEIN_PLANAR_H
#define STEIN_PLANAR_H

#include "real.h"

typedef struct vec2 {
    real x, z;
} vec2;

/** Wrench on a frame about its body's origin: force [N] and plane moment [N m]. */
typedef struct wrench {
    real x, z, m;
} wrench;

/* a direction of a body, and a point of it, in the fixed frame */
static inline vec2 turn(const stein_pose *p, real x, real z)
{
    return (vec2){p->c * x - p->s * z, p->s * x + p->c * z};
}

static inline vec2 place(const stein_pose *p, real x, real z)
{
    return (vec2){p->x + p->c * x - p->s * z, p->z + p->s * x + p->c * z};
}

/* from a body's origin to a place of the fixed frame */
static inline vec2 arm_to(const stein_pose *p, vec2 at)
{
    return (vec2){at.x - p->x, at.z - p->z};
}

/* velocity of the body's material there */
static inline vec2 velocity_at(const stein_pose *p, vec2 arm)
{
    return (vec2){p->vx - p->w * arm.z, p->vz + p->w * arm.x};
}

/* at a place of the fixed frame */
static inline vec2 velocity(const stein_pose *p, vec2 at)
{
    return velocity_at(p, arm_to(p, at));
}

/* a force at the end of an arm into the wrench of a body about its origin */
static inline void push_at(wrench *w, vec2 arm, vec2 force)
{
    w->x += force.x;
    w->z += force.z;
    w->m += arm.x * force.z - arm.z * force.x;
}

#endif
