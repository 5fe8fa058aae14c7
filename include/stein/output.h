/* SPDX-License-Identifier: MIT
 * output.h - outputs of a mechanism: readings of channels, reactions of joints and loops.
 *
 * A part of the descriptor, included by model.h; conventions are there.
 */
#ifndef STEIN_OUTPUT_H
#define STEIN_OUTPUT_H

#ifdef __cplusplus
extern "C" {
#endif

/* Kinds of outputs. Their names, units and elements are a table, src/model/output_kinds.c. Kinds
 * that share a line stay together in this order; a new one goes to the end. */
/* clang-format off */
typedef enum {
    STEIN_READ_TIME,
    STEIN_READ_POSITION, STEIN_READ_SPEED, STEIN_READ_ACCELERATION, /* joint index */
    STEIN_READ_X, STEIN_READ_Y, STEIN_READ_Z,                       /* point index, position [m] */
    STEIN_READ_VX, STEIN_READ_VY, STEIN_READ_VZ,                    /* point index, velocity [m/s] */
    STEIN_READ_GAP, STEIN_READ_FORCE, STEIN_READ_TANGENT,           /* contact index */
    STEIN_READ_NOTCH_FORCE, STEIN_READ_NOTCH_PHASE, STEIN_READ_NOTCH_OVERLAP, /* notch index */
    STEIN_READ_INPUT, STEIN_READ_INPUT_FORCE,                       /* input index */
    STEIN_READ_KINETIC, STEIN_READ_POTENTIAL,                       /* whole tree [J] */
    /* index into frames3. R = Rz(yaw) Ry(pitch) Rx(roll), -pi .. pi, pitch -pi/2 .. pi/2 [rad];
       XY is the component along x of the fixed frame of the body's axis y; angular velocity about the
       body's axes [rad/s] */
    STEIN_READ_ROLL, STEIN_READ_PITCH, STEIN_READ_YAW,
    STEIN_READ_XX, STEIN_READ_XY, STEIN_READ_XZ, STEIN_READ_YX, STEIN_READ_YY, STEIN_READ_YZ,
    STEIN_READ_ZX, STEIN_READ_ZY, STEIN_READ_ZZ,
    STEIN_READ_WX, STEIN_READ_WY, STEIN_READ_WZ,
    /* body index: angle in the plane, against the fixed frame [rad]. The body and its ancestors
     * turn about one axis only; the angle is the sum of their joint angles, counted from +x towards
     * +z (axis y), from +x towards +y (z) or from +y towards +z (x) */
    STEIN_READ_ANGLE,
    STEIN_READ_REACTION /* index into reactions */
} stein_read_kind;
/* clang-format on */
enum { STEIN_READ_KINDS = STEIN_READ_REACTION + 1 };

/** Reaction of a joint or a loop. Joint: the force of the parent on the child at the child's
 *  origin, and the moment about that origin. Loop: the force of the first point's body on the
 *  second point's body at the second point, and the moment about it. Forces in the joint itself are
 *  included (springs, motors, gears). X .. Z are components along axes of the fixed frame or of a
 *  body; SIZE is the length of the vector. Coupling: FORCE_X is the generalised force on the joint
 *  that follows [N m or N]; there is nothing more. */
typedef enum {
    STEIN_FORCE_X,
    STEIN_FORCE_Y,
    STEIN_FORCE_Z,
    STEIN_MOMENT_X,
    STEIN_MOMENT_Y,
    STEIN_MOMENT_Z,
    STEIN_FORCE_SIZE,
    STEIN_MOMENT_SIZE
} stein_component;
typedef struct stein_reaction {
    int loop;  /* 1: of a loop or coupling, 0: of a joint */
    int index; /* which one */
    stein_component component;
    int axes; /* components are along the axes of this body; -1: of the fixed frame */
} stein_reaction;

/** Mass properties of a body, for reactions: consecutive blocks of d. AT is the place of its joint
 *  from the parent's origin, in the parent's axes [m]. All else is in the body's axes; the tensor
 *  is about the centre of mass [kg m^2]. */
enum {
    STEIN_MADE_AT,         /* x y z */
    STEIN_MADE_MASS = 3,   /* [kg] */
    STEIN_MADE_CENTRE = 4, /* x y z */
    STEIN_MADE_TENSOR = 7, /* xx yy zz xy xz yz */
    STEIN_MADE_SIZE = 13
};

/** Constraint of a loop, for reactions. index[0] and index[1] are points of the model (COUPLING:
 *  joints); `axis` is an axis of the first point's body. */
typedef enum {
    STEIN_TIE_MEET, /* the points meet */
    STEIN_TIE_ROD,  /* their distance is constant */
    STEIN_TIE_SLOT, /* the second point is on a line through the first one along `axis` */
    STEIN_TIE_WELD, /* the points meet and the bodies turn as one; with axis >= 0 a turn about it is
                     * free
                     */
    STEIN_TIE_COUPLING /* joint index 0 follows joint index 1, `ratio` times */
} stein_tie_kind;
typedef struct stein_tie {
    stein_tie_kind kind;
    int index[2];
    int axis;  /* 0 x, 1 y, 2 z, -1 none */
    int ratio; /* d index, -1: no coupling */
} stein_tie;

/** Is it a reading of the attitude of a body? */
static inline int stein_reads_attitude(int read)
{
    return read >= STEIN_READ_ROLL && read <= STEIN_READ_WZ;
}

/** Is it a reading of a place: of a joint, a body in its plane, a point, a gap? */
static inline int stein_reads_place(int read)
{
    return read == STEIN_READ_POSITION || (read >= STEIN_READ_X && read <= STEIN_READ_Z) ||
           read == STEIN_READ_GAP || read == STEIN_READ_ANGLE;
}

/** An output channel: sign * (reading - reading in the initial state if from_rest). */
typedef struct stein_channel {
    const char *name, *unit;
    stein_read_kind read;
    int index;
    int sign;      /* +1 or -1 */
    int from_rest; /* 1 = counted from the value in the initial state */
    int sensor;    /* d index of a STEIN_SENSOR block */
} stein_channel;

#ifdef __cplusplus
}
#endif
#endif
