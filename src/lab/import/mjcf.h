/* SPDX-License-Identifier: GPL-3.0-or-later
 * mjcf.h - shared by the files that read a model of MuJoCo.
 *
 *   mjcf.c  attributes, joints, bodies    mjcf_geoms.c  mass and inertia
 *   mjcf_equalities.c  equalities, actuators, what is left out
 * Included by: this folder.
 */
#ifndef MJCF_H
#define MJCF_H

#include "draft.h"

/** A body of the model, 0: the world. */
typedef struct mjcf_body {
    const char *label;
    const xml_node *node;
    int body;    /* of the draft that carries it; -1: the frame */
    double o[3]; /* [m] its origin, in the axes of that from its origin */
    double C[9]; /* from its axes to the parent's */
    double X[3]; /* [m] its origin while all joints are at their reference, in the world */
    double W[9]; /* from its axes to the world's, likewise */
} mjcf_body;

typedef struct mjcf {
    draft *d;
    const xml_node *root;
    double angle;     /* unit of angles [rad] */
    char eulerseq[4]; /* order of turns */
    mjcf_body body[DRAFT_LINKS];
    int nbody;
    const char *joint[MECH_BODIES]; /* name of the joint of each body of the draft, or NULL */
} mjcf;

/** An attribute of an element or of its class; NULL: none. */
const xml_node *mjcf_attribute(const mjcf *m, const xml_node *node, const char *name);
/** Its text, "" when there is none. */
const char *mjcf_text(const mjcf *m, const xml_node *node, const char *name);
/** Its numbers, an error when there are fewer than `least` or more than `most`.
 *  @return how many, 0: no such attribute */
int mjcf_numbers(const mjcf *m, const xml_node *node, const char *name, double *x, int least,
                 int most);
double mjcf_number(const mjcf *m, const xml_node *node, const char *name, double otherwise);
/** From the axes of an element to its parent's. */
void mjcf_orientation(const mjcf *m, const xml_node *node, double R[9]);

/** Mass, centre and inertia of a body by <inertial> or by its geoms, in its parent's axes and from
 *  its parent's origin. @param to  has them then */
void mjcf_mass(mjcf *m, const xml_node *node, const mjcf_body *b, draft_body *to);
/** Equalities, actuators, and notes of other elements. */
void mjcf_equalities(mjcf *m);

#endif
