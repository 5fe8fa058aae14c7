/* SPDX-License-Identifier: MIT
 * abreast.c - two places of one simulation in the two halves of a register: depth, speeds, laws and
 * forces as contact.c and pair_force.h have them, operation by operation, so with the same bits.
 * Every processor has such registers; most of a stage are such places.
 */
#define STEIN_LANES 2

#include "abreast.h"

#include "laws.h"
#include "plane.h"

static inline const real *numbers(const stein__both *from)
{
    return (const real *)(const void *)from;
}

static inline real number(const stein__both *from)
{
    return *numbers(from);
}

/* poses of one body of each place */
static inline stein_pose poses(const double *a, const double *b)
{
    return (stein_pose){{a[0], b[0]}, {a[1], b[1]}, {a[2], b[2]}, {a[3], b[3]},
                        {a[4], b[4]}, {a[5], b[5]}, {a[6], b[6]}};
}

/* a force at the ends of two arms into the wrenches of place k, of the second body the opposite */
ALWAYS void push(const stein__duo *duo, int k, vec2 force, real moment, real moment1)
{
    double *w = duo->wrench[k][0], *w1 = duo->wrench[k][1];
    w[0] += force.x[k];
    w[1] += force.z[k];
    w[2] += moment[k];
    if (w1 != NULL) {
        w1[0] -= force.x[k];
        w1[1] -= force.z[k];
        w1[2] -= moment1[k];
    }
}

static inline void put(stein__both *to, real x)
{
    memcpy(to, &x, sizeof x);
}

ALWAYS void press(const stein__duo *duo, stein__deed *deed)
{
    stein_pose a = poses(duo->pose[0][0], duo->pose[1][0]),
               b = poses(duo->pose[0][1], duo->pose[1][1]);
    vec2 at = place(&a, number(&duo->at[0]), number(&duo->at[1]));
    vec2 foot = place(&b, number(&duo->at[2]), number(&duo->at[3]));
    vec2 n = turn(&b, number(&duo->n[0]), number(&duo->n[1]));
    real depth = number(&duo->reach) - ((at.x - foot.x) * n.x + (at.z - foot.z) * n.z);

    vec2 arm = arm_to(&a, at), arm1 = arm_to(&b, at);
    vec2 va = velocity_at(&a, arm), vb = velocity_at(&b, arm1), v = {va.x - vb.x, va.z - vb.z};
    real rate = -(v.x * n.x + v.z * n.z), speed = v.x * n.z - v.z * n.x;
    real slip = speed * number(&duo->inverse_vt), grip = stein__tanh(slip);

    real normal = stein__normal(numbers(duo->normal), 0, depth, rate);
    real mu = number(&duo->level) * grip;
    real tangent = only(more(normal, 0.0), -normal * mu);
    vec2 force = {normal * n.x + tangent * n.z, normal * n.z - tangent * n.x};
    real moment = arm.x * force.z - arm.z * force.x, moment1 = arm1.x * force.z - arm1.z * force.x;
    push(duo, 0, force, moment, moment1);
    push(duo, 1, force, moment, moment1);
    if (deed != NULL) {
        put(&deed->at[0], at.x);
        put(&deed->at[1], at.z);
        put(&deed->n[0], n.x);
        put(&deed->n[1], n.z);
        put(&deed->depth, depth);
        put(&deed->rate, rate);
        put(&deed->speed, speed);
        put(&deed->slip, slip);
        put(&deed->grip, grip);
        put(&deed->normal, normal);
        put(&deed->tangent, tangent);
    }
}

void stein__press_abreast(const stein__duo *duo)
{
    press(duo, NULL);
}

void stein__press_abreast_told(const stein__duo *duo, stein__deed *deed)
{
    press(duo, deed);
}
