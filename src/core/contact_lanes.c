/* SPDX-License-Identifier: MIT
 * contact_lanes.c - places of one simulation side by side in a register. Depth, speeds, laws and
 * forces are those of contact.c and pair_force.h, operation by operation, so with the same bits.
 * Two of them on every processor. Where a library is for processors with AVX2 as well, this file is
 * compiled once more, for four.
 */
#ifndef STEIN_LANES
#define STEIN_LANES 2
#endif

#include "contact_lanes.h"

#include "laws.h"
#include "planar.h"

/* a register in memory that is aligned as two doubles are */
typedef double stored __attribute__((vector_size(8 * STEIN_LANES), aligned(16), may_alias));

static inline real number(const stein__each *from)
{
    return *(const stored *)from;
}

static inline void put(stein__each *to, real x)
{
    *(stored *)to = x;
}

/* two numbers that follow each other in a pose or wrench */
typedef double pair_of __attribute__((vector_size(16), aligned(8), may_alias));

/* numbers i and i + 1 of a pose of each place */
ALWAYS void gather(const stein__group *g, int body, int i, real *first, real *second)
{
    const double *a = g->pose[0][body] + i, *b = g->pose[1][body] + i;
#if STEIN_LANES == 2
    *first = (real){a[0], b[0]};
    *second = (real){a[1], b[1]};
#else
    const double *c = g->pose[2][body] + i, *d = g->pose[3][body] + i;
    __m256d even = _mm256_set_m128d(*(const pair_of *)c, *(const pair_of *)a);
    __m256d odd = _mm256_set_m128d(*(const pair_of *)d, *(const pair_of *)b);
    *first = (real)_mm256_unpacklo_pd(even, odd);
    *second = (real)_mm256_unpackhi_pd(even, odd);
#endif
}

ALWAYS stein_pose poses(const stein__group *g, int body)
{
    stein_pose p;
    real s; // known already
    gather(g, body, 0, &p.x, &p.z);
    gather(g, body, 2, &p.c, &p.s);
    gather(g, body, 4, &p.vx, &p.vz);
    gather(g, body, 5, &s, &p.w);
    return p;
}

/* x and z of place k */
ALWAYS pair_of of_place(int k, vec2 v)
{
#if STEIN_LANES == 2
    return (pair_of){v.x[k], v.z[k]};
#else
    __m256d both = k % 2 == 0 ? _mm256_unpacklo_pd((__m256d)v.x, (__m256d)v.z)
                              : _mm256_unpackhi_pd((__m256d)v.x, (__m256d)v.z);
    return (pair_of)(k < 2 ? _mm256_castpd256_pd128(both) : _mm256_extractf128_pd(both, 1));
#endif
}

/* a force at the ends of two arms into the wrenches of place k, of the second body the opposite */
ALWAYS void push(const stein__group *g, int k, vec2 force, real moment, real moment1)
{
    double *w = g->wrench[k][0], *w1 = g->wrench[k][1];
    pair_of f = of_place(k, force);
    *(pair_of *)w += f;
    w[2] += moment[k];
    if (w1 != NULL) {
        *(pair_of *)w1 -= f;
        w1[2] -= moment1[k];
    }
}

/* the normal force of a polynomial with damping */
static inline real plain_normal(const stein__each *of, real depth, real rate)
{
    real law[STEIN_NORMAL_SIZE];
    law[STEIN_NORMAL_A] = number(&of[STEIN_NORMAL_A]);
    law[STEIN_NORMAL_B] = number(&of[STEIN_NORMAL_B]);
    law[STEIN_NORMAL_C] = number(&of[STEIN_NORMAL_C]);
    law[STEIN_NORMAL_D] = number(&of[STEIN_NORMAL_D]);
    law[STEIN_NORMAL_PRELOAD] = number(&of[STEIN_NORMAL_PRELOAD]);
    return stein__normal(law, 0, depth, rate);
}

/* where the points are, the normals of the lines. @return depths */
ALWAYS real meet(const stein__group *g, const stein_pose *a, const stein_pose *b, vec2 *at, vec2 *n)
{
    *at = place(a, number(&g->at[0]), number(&g->at[1]));
    *n = turn(b, number(&g->line[0]), number(&g->line[1]));
    vec2 foot = place(b, number(&g->at[2]), number(&g->at[3]));
    return number(&g->reach) - ((at->x - foot.x) * n->x + (at->z - foot.z) * n->z);
}

ALWAYS void contact_forces(const stein__group *g, stein__contact_record *record)
{
    stein_pose a = poses(g, 0), b = poses(g, 1);
    vec2 at, n;
    real depth = meet(g, &a, &b, &at, &n);

    vec2 arm = arm_to(&a, at), arm1 = arm_to(&b, at);
    vec2 va = velocity_at(&a, arm), vb = velocity_at(&b, arm1), v = {va.x - vb.x, va.z - vb.z};
    real rate = -(v.x * n.x + v.z * n.z), speed = v.x * n.z - v.z * n.x;
    real slip = speed * number(&g->inverse_vt), grip = stein__tanh(slip);

    real normal = plain_normal(g->normal, depth, rate);
    real tangent = only(more(normal, 0.0), -normal * (number(&g->level) * grip));
    vec2 force = {normal * n.x + tangent * n.z, normal * n.z - tangent * n.x};
    real moment = arm.x * force.z - arm.z * force.x, moment1 = arm1.x * force.z - arm1.z * force.x;
    push(g, 0, force, moment, moment1);
    if (g->n > 1) {
        push(g, 1, force, moment, moment1);
    }
#if STEIN_LANES > 2
    if (g->n > 2) {
        push(g, 2, force, moment, moment1);
    }
    if (g->n > 3) {
        push(g, 3, force, moment, moment1);
    }
#endif
    if (record != NULL) {
        put(&record->at[0], at.x);
        put(&record->at[1], at.z);
        put(&record->n[0], n.x);
        put(&record->n[1], n.z);
        put(&record->depth, depth);
        put(&record->rate, rate);
        put(&record->speed, speed);
        put(&record->slip, slip);
        put(&record->grip, grip);
        put(&record->normal, normal);
        put(&record->tangent, tangent);
    }
}

#if STEIN_LANES == 2
#define CONTACT_FORCES          stein__contact_forces2
#define CONTACT_FORCES_RECORDED stein__contact_forces2_recorded
#define CONTACT_DEPTHS          stein__contact_depths2
#else
#define CONTACT_FORCES          stein__contact_forces4
#define CONTACT_FORCES_RECORDED stein__contact_forces4_recorded
#define CONTACT_DEPTHS          stein__contact_depths4
#endif

void CONTACT_FORCES(const stein__group *g)
{
    contact_forces(g, NULL);
}

void CONTACT_FORCES_RECORDED(const stein__group *g, stein__contact_record *record)
{
    contact_forces(g, record);
}

void CONTACT_DEPTHS(const stein__group *g, stein__each *depth)
{
    stein_pose a = poses(g, 0), b = poses(g, 1);
    vec2 at, n;
    put(depth, meet(g, &a, &b, &at, &n));
}
