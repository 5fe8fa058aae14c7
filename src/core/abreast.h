/* SPDX-License-Identifier: MIT
 * abreast.h - two places of one simulation, pressed side by side: plain numbers only, so that files
 * whose reals are doubles can meet here the one whose reals are two of them.
 * Included by: this folder.
 */
#ifndef STEIN_ABREAST_H
#define STEIN_ABREAST_H

#include "stein/model.h"

/** A number of both places. */
typedef struct stein__both {
    double of[2];
} __attribute__((aligned(16))) stein__both;

/** Two points on lines whose laws are plain, and what follows from parameters alone. */
typedef struct stein__duo {
    stein__both at[4];                     /* x, z of a point of each body: the point, the line */
    stein__both n[2];                      /* normal of the line on the second body */
    stein__both reach;                     /* see site */
    stein__both normal[STEIN_NORMAL_SIZE]; /* law */
    stein__both level, inverse_vt;         /* of the friction */
    const double *pose[2][2];              /* [place][body], in the order of stein_pose */
    double *wrench[2][2];                  /* x, z, m; NULL: not asked for */
    int site[2];                           /* whose numbers these are */
} stein__duo;

/** What both places did, as a touch has it. */
typedef struct stein__deed {
    stein__both at[2], n[2]; /* x, z */
    stein__both depth, rate, speed, slip, grip, normal, tangent;
} stein__deed;

/** Their forces into the wrenches, of the first place first; and what they did. */
void stein__press_abreast(const stein__duo *duo);
void stein__press_abreast_told(const stein__duo *duo, stein__deed *deed);

#endif
