/* SPDX-License-Identifier: MIT
 * generator_reference.h - an independent route to everything the generator emits, and random trees.
 */
#ifndef GENERATOR_REFERENCE_H
#define GENERATOR_REFERENCE_H

#include "mechanism.h"
#include "stein/model.h"

/** Values at a state. All arrays in the layout of stein_model. */
typedef struct ref_out {
    double *M, *c;            /* [n*n], [n] */
    double *x, *v, *J, *jdqd; /* points */
    double *pose;             /* [7*nbody]: x z c s vx vz w of every body */
    double kinetic, potential;
} ref_out;

typedef struct ref_state {
    double *q, *qd, *qdd, *frc, *trq;
} ref_state;

/** Lagrange's equations on homogeneous transforms, in dual numbers, from the numbers of the file.
 */
void ref_evaluate(const mechanism *m, const ref_state *s, ref_out *out);

ref_out ref_out_new(int n, int npoint);
void ref_out_free(ref_out *r);
ref_state ref_state_random(int n, unsigned long long *seed);
void ref_state_free(ref_state *s);

/** A random tree: nbody joints R and T about and along all +-axes with random zeros; planar: R y,
 *  T x, T z and a contact on every body. Free with ref_tree_free. */
mechanism *ref_tree(const char *name, int nbody, int planar, unsigned long long *seed);
/** A serial arm of n revolute joints about the given axes, all numbers non-zero. */
mechanism *ref_arm(const char *name, const char *axes, unsigned long long *seed);
/** Rotors behind the gears of about two thirds of its joints. */
void ref_armatures(mechanism *m, unsigned long long *seed);
void ref_tree_free(mechanism *m);

#endif
