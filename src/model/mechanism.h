/* SPDX-License-Identifier: MIT
 * mechanism.h - a mechanism file after reading: the one form shared by generator and runtime.
 *
 * Every number of the file becomes a `mech_scalar`: a structural zero, a parameter (named by its
 * path, "hammer.mass"), or a formula over parameters ("string.height + 2 mm"). Values are SI. All
 * references by name are resolved to indices; bodies are sorted so that a parent comes first.
 * The free load and contacts of two lines are already written out as ordinary bodies and spots.
 * Included by: this folder, gen, src/lab/open.
 */
#ifndef MECHANISM_H
#define MECHANISM_H

#include <stddef.h>

#include "stein/model.h"
#include "stein/status.h"

enum { MECH_NAME = 33, MECH_PATH = 100, MECH_UNIT = 24, MECH_STACK = 16 };

/** Most bodies of a mechanism. */
enum { MECH_BODIES = 220 };

/** Dimension of a quantity: exponents of kg, m, s, of the angle (for units only: an angle is a pure
 *  number in formulas) and of A. */
typedef struct mech_dim {
    signed char kg, m, s, rad, A;
} mech_dim;

typedef enum { MECH_ZERO, MECH_PARAM, MECH_FORMULA } mech_kind;

/** A number of the file. ZERO: a literal 0 where it vanishes structurally. */
typedef struct mech_scalar {
    mech_kind kind;
    int index;    /* PARAM: into params; FORMULA: into formulas */
    double value; /* at the file's own parameter values [SI] */
} mech_scalar;

/** A parameter. declared: from the `parameters` section (symbolic even at 0). */
typedef struct mech_param {
    char name[MECH_PATH];
    char unit[MECH_UNIT];    /* SI, "N/m^3", "1" for none */
    char written[MECH_UNIT]; /* its unit as the file writes it, "kg cm^2"; "" none, or a formula */
    mech_dim dim;
    double value, tolerance; /* [SI]; tolerance 0 when none was given */
    int declared, line, column;
    int stated;        /* the file or an override gives it; 0: left out, at its neutral value */
    int unused;        /* its place does not use it: the law of friction that sticks is another */
    stein_range range; /* the narrowest of what it stands for by itself */
} mech_param;

typedef enum {
    MECH_OP_CONST,
    MECH_OP_PARAM,
    MECH_OP_ADD,
    MECH_OP_SUB,
    MECH_OP_MUL,
    MECH_OP_DIV,
    MECH_OP_NEG,
    MECH_OP_SIN,
    MECH_OP_COS,
    MECH_OP_TAN,
    MECH_OP_SQRT
} mech_op;

/** One step of a formula in postfix order. */
typedef struct mech_step {
    mech_op op;
    int param;    /* OP_PARAM */
    double value; /* OP_CONST */
} mech_step;

/** A formula: steps in postfix order; needs at most MECH_STACK stack cells. */
typedef struct mech_formula {
    mech_step *steps;
    int nsteps;
    char name[MECH_PATH]; /* path of the quantity it defines */
    char text[MECH_PATH]; /* as written */
} mech_formula;

/** Laws, every entry present (neutral where the file states nothing), in the order of the blocks of
 *  stein/model.h. */
typedef struct mech_friction {
    mech_scalar v[STEIN_FRICTION_SIZE];
} mech_friction;

typedef struct mech_normal {
    mech_scalar v[STEIN_NORMAL_SIZE];
} mech_normal;

typedef struct mech_body {
    char name[MECH_NAME];
    int parent; /* -1 frame */
    int part;   /* 1: a piece of its parent, whose stated mass, centre, inertia include it */
    int lead; /* 1: no body of the file, but a joint of the ball or free one behind it (balls.c) */
    int ball; /* 1 the chart of a ball, 2 .. 4 its angles, the last one at the body; 0 else */
    int free; /* 1: a ball behind three sliding joints */
    char type, axis;
    int sign;
    mech_scalar at[3]; /* joint origin in the parent's axes, from the parent's origin [m] */
    mech_scalar mass, centre[3];
    mech_scalar inertia[6];              /* xx yy zz xy xz yz about the centre of mass [kg m^2] */
    mech_scalar joint[STEIN_JOINT_SIZE]; /* what acts in the joint itself */
    mech_scalar armature; /* of a rotor behind a gear, as the joint has it [kg m^2 or kg] */
    int has_motor;        /* its back-EMF is in the damping of `joint` */
    mech_scalar per_volt; /* force of the motor in the joint [N m/V or N/V] */
    mech_scalar q0, qd0;  /* initial state */
    int limited;          /* it has stops */
    mech_scalar limit[STEIN_LIMIT_SIZE];
    int sticks; /* its friction does */
    int line, column;
} mech_body;

typedef struct mech_point {
    char name[2 * MECH_NAME]; /* "hammer.head" */
    int body;
    mech_scalar at[3];
} mech_point;

typedef enum { MECH_FLAT, MECH_SPHERE, MECH_PLANE } mech_solid;
enum { MECH_SPOTS = 8 };

/** One side of a spot: circle (radius 0 for a point) or one-sided line; in space sphere or plane.
 */
typedef struct mech_shape {
    int body;              /* -1 frame */
    int solid;             /* mech_solid */
    mech_scalar normal[3]; /* PLANE, where it is no line that stands across its plane */
    int corner;            /* SPHERE: 1 .. 8 corner of a box around `at`, 0 none */
    mech_scalar size[3];   /* of that box [m] */
    int across;            /* PLANE from a line: the axis along which it stands, 0 x .. 2 z */
    int is_line;
    mech_scalar at[3], radius;
    mech_scalar facing;    /* line: plane angle of the normal towards the free side [rad] */
    int has_extent;        /* line: without one it is infinite */
    mech_scalar extent[2]; /* along the tangent (the normal turned by -90 deg) from `at` [m] */
    int end; /* 0; or -1/+1: not the whole line but its lower/upper end touches (is_line
                stays 1): `at` moved by extent[0] or extent[1] along the tangent */
} mech_shape;

typedef struct mech_spot {
    mech_shape side[2]; /* side[0] is never a line, except end != 0 (an end of a line) */
} mech_spot;

typedef struct mech_contact {
    char name[MECH_NAME];
    mech_spot spot[MECH_SPOTS];
    int nspot;
    mech_normal normal;
    mech_friction friction;
    int sticks; /* its friction does */
} mech_contact;

typedef struct mech_notch {
    char name[MECH_NAME];
    int catcher, beak; /* bodies */
    mech_scalar corner[3], lean,
        angle;                /* lean: plane angle of the vertical face from +z towards -x */
    mech_scalar end[3], tilt; /* beak end; plane angle of its upper face */
    mech_normal normal;
    mech_friction friction;
} mech_notch;

/** A law given by points: at [n], then value [n]. */
typedef struct mech_table {
    char name[MECH_NAME];
    int kind;  /* stein_table_kind */
    int index; /* as in stein_table */
    int n;
    mech_scalar *v; /* [2*n] */
} mech_table;

typedef struct mech_link {
    char name[MECH_NAME];
    int point[2];
    mech_scalar law[STEIN_LINK_SIZE];
} mech_link;

typedef enum { MECH_MEET, MECH_ROD, MECH_SLOT, MECH_WELD, MECH_COUPLING } mech_loop_kind;

/** Conditions between coordinates: a loop that is closed at two points, or a joint that follows
 *  another one. */
typedef struct mech_loop {
    char name[MECH_NAME];
    int kind;                  /* mech_loop_kind */
    int index[2];              /* points; COUPLING: the joint that follows, the one it follows */
    int axis;                  /* of the first point's body, 0 x .. 2 z: SLOT along it; WELD turns
                                  about it, -1 not at all */
    mech_scalar length;        /* ROD [m] */
    mech_scalar ratio, offset; /* COUPLING: q = ratio q_followed + offset */
} mech_loop;

typedef struct mech_input {
    char name[MECH_NAME];
    char unit[MECH_UNIT];
    int kind;                 /* stein_input_kind */
    int index;                /* body or point */
    mech_scalar direction[3]; /* of a force at a point; VOLTAGE: [0] is the joint's per_volt */
    mech_scalar signal[STEIN_SIGNAL_SIZE];
    int hold;
} mech_input;

typedef struct mech_channel {
    char name[MECH_NAME];
    char unit[MECH_UNIT];
    int read; /* stein_read_kind */
    int index, sign, from_rest;
    int loop, component, axes; /* of a reaction, as in stein_reaction */
    mech_scalar sensor[STEIN_SENSOR_SIZE];
} mech_channel;

/** A parameter that a hand may turn while the mechanism runs, and how far. */
typedef struct mech_dial {
    int param;
    double from, to; /* [SI], from < to */
    char label[2 * MECH_NAME];
} mech_dial;

/** Text of the file about an entry of a section; of the file: both names empty. */
typedef struct mech_about {
    char section[MECH_NAME], entry[MECH_PATH];
    char *text;
} mech_about;

typedef struct mechanism {
    char name[MECH_NAME];
    char *file;             /* as given to the reader */
    char input_hash[17];    /* fnv1a64 of the file's bytes, hexadecimal */
    mech_scalar gravity[3]; /* of the fixed frame [m/s^2] */
    mech_param *params;
    int nparam;
    mech_formula *formulas;
    int nformula;
    mech_body *bodies;
    int nbody;
    mech_point *points;
    int npoint;
    mech_contact *contacts;
    int ncontact;
    mech_notch *notches;
    int nnotch;
    mech_link *links;
    int nlink;
    mech_table *tables;
    int ntable;
    mech_loop *loops;
    int nloop;
    mech_input *inputs;
    int ninput;
    mech_channel *channels; /* without "time", which every model has */
    int nchannel;
    int load_body, load_contact;     /* -1 when there is no load */
    int stroke_string, stroke_notch; /* contact and notch index, -1 when absent */
    mech_dial *dials;
    int ndial;
    mech_about *abouts;
    int nabout;
    mech_scalar clock_error;
    int settle;
    int integrator;   /* a stein_integrator */
    double dt, until; /* [s] */
    int tolerated;    /* output with an error statement, -1: none */
    double tolerance; /* that steps of controlled error may leave in it [SI], 0: none is told */
} mechanism;

/** One override of a number of the file, as `--set NAME=VALUE[unit]` gives it. */
typedef struct mech_set {
    const char *name, *value;
} mech_set;

/** Receives every problem found, in order: "file:line:column: what, expected, did you mean ...", or
 *  of a file without problems implausible numbers, "file:line:column: warning: ...". */
typedef void mech_report(void *ctx, const char *message);

/** Read a mechanism file, with nset overrides applied before structure is decided (so that setting
 *  a structural zero changes the equations). All problems of the file are reported in one run.
 *  @param report  may be NULL; err then still holds the first problem
 *  @return STEIN_OK, STEIN_EIO, STEIN_ENOMEM, STEIN_EPARSE; *out untouched on failure */
stein_status mech_read(mechanism **out, const char *file, const mech_set *set, int nset,
                       mech_report *report, void *ctx, stein_err *err);

/** The same from memory; `name` stands for the file in messages. */
stein_status mech_read_text(mechanism **out, const char *name, const char *text, size_t size,
                            const mech_set *set, int nset, mech_report *report, void *ctx,
                            stein_err *err);

void mech_free(mechanism *m);

/** Strict number with optional unit, as in the file ("7.2 mm", "0.0072"), for dimension `dim`.
 *  Locale-free. @return STEIN_OK or STEIN_EPARSE with a message that states what was expected. */
stein_status mech_parse_quantity(const char *text, mech_dim dim, double *value, stein_err *err);

/** Dimension of a unit text ("N/m^3"); 0 on success, -1 when it is none. */
int mech_parse_unit(const char *text, mech_dim *dim, double *factor);

/** Name of a stein_integrator in files and on the command line. */
const char *mech_integrator(int integrator);

/** Parameter index by name, -1 when absent; *suggestion (nullable) gets the nearest name or NULL.
 */
int mech_find_param(const mechanism *m, const char *name, const char **suggestion);

/** Kinds of elements that an output can read. */
typedef enum {
    MECH_A_JOINT,
    MECH_A_POINT,
    MECH_A_CONTACT,
    MECH_A_NOTCH,
    MECH_AN_INPUT,
    MECH_A_BODY,
    MECH_A_LOOP,
    MECH_AN_ENERGY,
    MECH_NO_THING
} mech_thing;

/** What an output follows from: of the state, and from MECH_FROM_FORCES on also of the inputs. */
typedef enum {
    MECH_FROM_NOTHING = -1,
    MECH_FROM_PLACES,
    MECH_FROM_SPEEDS,
    MECH_FROM_FORCES
} mech_origin;

/** A kind of output. */
typedef struct mech_output_kind {
    mech_thing of, also; /* elements that have it */
    const char *word;    /* of `read:` or `energy:` */
    const char *name;    /* "tangent": STEIN_READ_TANGENT */
    /* where its joint turns, where it slides; "": the unit of the element itself */
    const char *turning, *sliding;
    const char *about; /* of a description, before the name of the element */
    mech_origin from;
} mech_output_kind;

/** @param read  a stein_read_kind */
const mech_output_kind *mech_output_kind_of(int read);

/** What an output reads of: name of its joint, point, contact, notch or input; "" for energies. */
const char *mech_target(const mechanism *m, const mech_channel *c);

/** Value of a scalar for other parameter values p [nparam]. */
double mech_value(const mechanism *m, mech_scalar s, const double *p);

#endif
