/* SPDX-License-Identifier: GPL-3.0-or-later
 * mbs.h - what is taken from a ROBOTRAN project, between reading and writing.
 *
 *   xml.c        the file as a tree of elements     mbs.c        elements -> this
 *   mbs_write.c  this -> a mechanism file           import.c     lab_import_mbs
 * Included by: this folder.
 */
#ifndef MBS_H
#define MBS_H

#include "open.h"
#include "stein/import.h"
#include "xml.h"

/* of one file */
enum { MBS_BODIES = 64, MBS_JOINTS = 64, MBS_POINTS = 256, MBS_INERTIA = 6 };

/** A point of a body, or with body -1 of the base. */
typedef struct mbs_point {
    const char *label; /* its name in the file */
    char name[MECH_NAME];
    int body;
    double x[3]; /* [m], from the body's origin in its axes */
} mbs_point;

/** A joint; those of one body follow each other from the parent on. */
typedef struct mbs_joint {
    const char *label;
    char name[MECH_NAME];    /* unique among joints */
    char carries[MECH_NAME]; /* body of the mechanism file that hangs on it */
    int body;
    char type; /* 'R', 'T' */
    char axis; /* 'x', 'y', 'z' */
    int driven;
    double q, qd; /* initial [rad or m], [rad/s or m/s] */
} mbs_joint;

typedef struct mbs_body {
    const char *label;
    char name[MECH_NAME];
    int parent;                                   /* -1: the base */
    int anchor;                                   /* point of the parent, -1: its origin */
    double mass, centre[3], inertia[MBS_INERTIA]; /* xx yy zz xy xz yz */
    const xml_node *node;
} mbs_body;

typedef struct mbs_project {
    const char *file;
    char name[MECH_NAME];
    double gravity[3];
    mbs_body body[MBS_BODIES];
    mbs_joint joint[MBS_JOINTS];
    mbs_point point[MBS_POINTS];
    int nbody, njoint, npoint;
    char **note; /* what is left out or renamed */
    int nnote;
    lab_report_fn *report;
    void *ctx;
    stein_status status; /* of memory for notes */
    stein_err *err;
} mbs_project;

/** Fill the project from the file's elements, which have to live as long. @return OK, EPARSE,
 * ENOMEM */
stein_status mbs_take(mbs_project *p, const xml_node *root);
/** The mechanism file. @return OK, ENOMEM (the text is freed by the caller) */
stein_status mbs_text(const mbs_project *p, char **text, size_t *size, stein_err *err);

#endif
