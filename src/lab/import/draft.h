/* SPDX-License-Identifier: GPL-3.0-or-later
 * draft.h - a mechanism between a file of another program and a mechanism file.
 *
 *   xml.c    the file as a tree of elements   mbs.c, urdf.c, mjcf.c  elements -> a draft
 *   draft.c  names, notes, parts              write.c  a draft -> a mechanism file
 *   frames.c axes turned against each other   import.c lab_import
 * Included by: this folder.
 */
#ifndef DRAFT_H
#define DRAFT_H

#include "open.h"
#include "stein/import.h"
#include "xml.h"

/* of one file; what a mechanism file takes */
enum {
    DRAFT_POINTS = 256,
    DRAFT_THINGS = 128, /* loops, couplings, links, inputs, outputs: of each */
    DRAFT_LINKS = 512,  /* of a robot; those that are fixed are no bodies of their own */
    DRAFT_INERTIA = 6
};

/** Speed below which dry friction falls to 0 [rad/s or m/s]. */
#define DRAFT_SMOOTH 0.05

/** Meaning of an initial position: nothing, that it stays, or where loops begin to be closed. */
typedef enum { DRAFT_UNSAID, DRAFT_STATED, DRAFT_GUESSED } draft_start;

/** A body and the joint that carries it. */
typedef struct draft_body {
    char name[MECH_NAME];
    int parent;   /* -1: the frame */
    int anchor;   /* point of the parent where the joint is, -1: `at` */
    double at[3]; /* [m], in the parent's axes */
    char joint;   /* 'R', 'T', 'B' ball, 'W' free */
    char axis;    /* 'x', 'y', 'z' */
    int sign;     /* 1, -1 */
    double mass, centre[3], inertia[DRAFT_INERTIA]; /* xx yy zz xy xz yz, about the centre */
    draft_start start;
    double q, qd;            /* initial [rad or m], [rad/s or m/s] */
    int limited;             /* `range` is there */
    double range[2];         /* [rad or m] */
    double stiffness, rest;  /* of a spring [N m/rad or N/m], [rad or m] */
    double damping, coulomb; /* [N m s/rad or N s/m], [N m or N] */
    double armature;         /* [kg m^2 or kg] */
} draft_body;

typedef struct draft_point {
    const char *label; /* its name in the file that is read */
    char name[MECH_NAME];
    int body; /* -1: the frame */
    double x[3];
} draft_point;

/** Two points that are held together. */
typedef struct draft_loop {
    char name[MECH_NAME];
    int point[2];
    enum { DRAFT_MEET, DRAFT_ROD, DRAFT_WELD, DRAFT_LINK } kind; /* LINK: a spring without force */
    double length;                                               /* ROD, LINK [m] */
} draft_loop;

/** q of `joint` = ratio q of `follows` + offset. */
typedef struct draft_coupling {
    char name[MECH_NAME];
    int joint, follows;
    double ratio, offset;
} draft_coupling;

typedef enum { DRAFT_FORCE, DRAFT_TORQUE, DRAFT_MOTION } draft_drive;

typedef struct draft_input {
    char name[MECH_NAME];
    draft_drive kind;
    int index; /* FORCE: point; else body */
    int axis;  /* FORCE: 0 x .. 2 z of the fixed frame */
} draft_input;

typedef struct draft_output {
    char name[MECH_NAME];
    int point; /* its place along `axis`; -1: position of the joint of `body` */
    int axis;
    int body;
} draft_output;

typedef struct draft {
    const char *file;    /* that is read */
    const char *program; /* "ROBOTRAN's project" */
    lab_inertia inertia;
    char name[MECH_NAME];
    double gravity[3];
    draft_body body[MECH_BODIES];
    draft_point point[DRAFT_POINTS];
    draft_loop loop[DRAFT_THINGS];
    draft_coupling coupling[DRAFT_THINGS];
    draft_input input[DRAFT_THINGS];
    draft_output output[DRAFT_THINGS];
    int nbody, npoint, nloop, ncoupling, ninput, noutput;
    int bodies, joints; /* of the file that is read */
    char **note;        /* what is left out or changed */
    int nnote;
    lab_report_fn *report;
    void *ctx;
    stein_status status; /* the first error: it stops what follows */
    stein_err *err;
} draft;

/* ---- draft.c ---- */

/** Report that something is left out or changed. */
void draft_note(draft *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Fail with "file:line:column: ..."; the first failure stays. @return EPARSE */
stein_status draft_wrong(draft *d, const xml_node *at, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/** Children that are not in `known` (" a b ") are reported. @param where  of what they are */
void draft_note_others(draft *d, const xml_node *node, const char *known, const char *where);

/** Names in use. */
typedef enum { DRAFT_PART, DRAFT_OUTPUT, DRAFT_POINT } draft_names;
/** A name that a mechanism file takes, like the label: letters, digits and _, no word of C, unique.
 *  @param what   "body"; a change is reported with it. NULL: it is not
 *  @param owner  DRAFT_POINT: the body */
void draft_name(draft *d, char name[MECH_NAME], const char *label, const char *what,
                draft_names names, int owner);

/** New parts, or NULL with an error at `at` when there is no more room. All members but the names
 *  are 0; a body hangs on the frame, at no point. */
draft_body *draft_add_body(draft *d, const xml_node *at);
draft_point *draft_add_point(draft *d, const xml_node *at, int body, const char *label);
draft_loop *draft_add_loop(draft *d, const xml_node *at, const char *label);
draft_coupling *draft_add_coupling(draft *d, const xml_node *at, const char *label);
/** @return index of a point of this place, a new one where there is none; -1: no more room */
int draft_point_at(draft *d, const xml_node *at, int body, const double x[3], const char *label);
/** Inputs and outputs. When there is no more room, that is reported. */
void draft_add_input(draft *d, const char *label, draft_drive kind, int index, int axis);
void draft_add_output(draft *d, const char *label, int body, int point, int axis);

/** Text of a child that has to be there; "" and an error when it is not. */
const char *draft_need(draft *d, const xml_node *node, const char *child);
/** A number [SI] of a text that belongs to an element; 0 and an error when it is none. */
double draft_number(draft *d, const xml_node *at, const char *text);

/** Numbers with blanks between them. @return how many there are; beyond `most` they are not stored
 */
int draft_numbers(draft *d, const xml_node *at, double *x, int most);

/* ---- frames.c: rotations are row-major, from the axes of a frame to the axes of its parent ----
 */

void frame_multiply(const double A[9], const double B[9], double C[9]);
void frame_turn(const double A[9], const double x[3], double y[3]);
void frame_transpose(const double A[9], double B[9]);
/** Rz(yaw) Ry(pitch) Rx(roll); multiples of 90 deg are exact. */
void frame_rotation(const double rpy[3], double R[9]);
/** Inertia xx yy zz xy xz yz in axes that T turns to the body's. */
void frame_mass(draft_body *b, const double T[9], const double inertia[6]);
/** Inertia of a point mass about the origin, added to xx yy zz xy xz yz. */
void frame_point(double inertia[6], double mass, const double x[3]);
/** A part, in axes and from the origin of the body, becomes one body with it. */
void frame_join(draft_body *to, const draft_body *part);
/** The axis of a joint along `direction`, in axes that C turns to the body's; `joint->at` is
 *  known. Where it is askew, `parent` becomes the last of the hinges that are held before it, and
 *  `at` and C are those behind them. */
void frame_axis(draft *d, const xml_node *at, const char *label, const double direction[3],
                double C[9], draft_body *joint, int *parent);

/* ---- write.c ---- */

/** The mechanism file. @return OK, ENOMEM (the text is freed by the caller) */
stein_status draft_text(const draft *d, char **text, size_t *size, stein_err *err);

/* ---- mbs.c, urdf.c, mjcf.c: the elements have to live as long as the draft ---- */

/** ROBOTRAN's project, <mbsDescR7>. @return OK, EPARSE, ENOMEM */
stein_status mbs_take(draft *d, const xml_node *root);
/** The robot of ROS, <robot>. @return OK, EPARSE, ENOMEM */
stein_status urdf_take(draft *d, const xml_node *root);
/** MuJoCo's model, <mujoco>. @return OK, EPARSE, ENOMEM */
stein_status mjcf_take(draft *d, const xml_node *root);

#endif
