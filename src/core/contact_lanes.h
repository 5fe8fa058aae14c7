/* SPDX-License-Identifier: MIT
 * contact_lanes.h - contact forces of several places of one simulation at once, one place in each
 * lane of a register. The types here are arrays of doubles: code for one lane calls code for two or
 * four.
 * Included by: this folder.
 */
#ifndef STEIN_CONTACT_LANES_H
#define STEIN_CONTACT_LANES_H

#include "stein/model.h"

enum { STEIN__MOST_TOGETHER = 4 };

/** A number of each place. */
typedef struct stein__each {
    double of[STEIN__MOST_TOGETHER];
} __attribute__((aligned(16))) stein__each;

/** Up to STEIN__MOST_TOGETHER contacts of a point with a line: parameters, and pointers to the
 * poses and wrenches of their bodies. Laws are polynomials with damping, friction a tanh. Unused
 * lanes repeat the last place. */
typedef struct stein__group {
    stein__each at[4];                     /* x, z of a point of each body: the point, the line */
    stein__each line[2];                   /* normal of the line, on the second body */
    stein__each reach;                     /* see site */
    stein__each normal[STEIN_NORMAL_SIZE]; /* law */
    stein__each level, inverse_vt;         /* of the friction */
    const double *pose[STEIN__MOST_TOGETHER][2]; /* [place][body], in the order of stein_pose */
    double *wrench[STEIN__MOST_TOGETHER][2];     /* x, z, m; NULL: not asked for */
    int site[STEIN__MOST_TOGETHER];
    int n; /* of places */
} stein__group;

/** Results at each place, in the words of touch (core.h). */
typedef struct stein__contact_record {
    stein__each at[2], n[2]; /* x, z */
    stein__each depth, rate, speed, slip, grip, normal, tangent;
} stein__contact_record;

/** Code for so many places. */
typedef struct stein__contact_kernel {
    int most;
    void (*forces)(const stein__group *g);
    void (*forces_recorded)(const stein__group *g, stein__contact_record *record);
    void (*depths)(const stein__group *g, stein__each *depth);
} stein__contact_kernel;

/** The forces of two, four places into their wrenches, in order; and what they did; depths only. */
void stein__contact_forces2(const stein__group *g);
void stein__contact_forces2_recorded(const stein__group *g, stein__contact_record *record);
void stein__contact_depths2(const stein__group *g, stein__each *depth);
void stein__contact_forces4(const stein__group *g);
void stein__contact_forces4_recorded(const stein__group *g, stein__contact_record *record);
void stein__contact_depths4(const stein__group *g, stein__each *depth);

#endif
