/* SPDX-License-Identifier: MIT
 * model.h - the descriptor of one mechanism, as the generator emits it.
 *
 * A generated file exports exactly one symbol, `const stein_model stein_model_<name>`. It is pure
 * constant data plus pure functions: any number of simulations on any number of threads share it.
 *
 *      p  [np]  parameters, set by name (SI)
 *        |
 *        | setup()            once per parameter set: formulas of the file, recombined inertias,
 *        v                    and the numbers of every contact, law, spring and initial value
 *      d  [nd]  derived constants, all that the equations and the runtime read
 *
 * Signs, frames and shapes, once for the whole library:
 *
 *      M(q) qdd + c(q, qd, frc, trq) = Q(q, qd)
 *
 *   - q, qd, qdd [nq]: one coordinate a joint [rad or m], in the order of the bodies
 *   - sc [2*nq]: sine and cosine of every turning joint's q, for all functions at that q; entries
 *     of sliding joints are not read
 *   - M [nq*nq]: row-major, full, symmetric
 *   - c [nq]: holds gravity, gyroscopic and applied terms
 *   - Q [nq]: generalised forces in the joints [N m or N]
 *   - frc, trq [3*nbody]: external force [N] and moment [N m] on each body at its centre of mass,
 *     components in that body's own axes
 *
 * Body axes are parallel to the fixed frame at q = 0. A joint about or along -y turns or slides
 * against y: its coordinate is counted the other way. Contacts are in the x-z plane (x to the
 * right, z up), or between spheres and planes in space. Plane angles count from +x towards +z
 * (anticlockwise as drawn), so a joint about +y turns clockwise as drawn.
 *
 * Lanes. The functions that a derivative evaluation needs are written in stein_real, which is a
 * double by default. With -DSTEIN_LANES=2, 4 or 8 it is a vector of that many doubles, one of each
 * of as many simulations. The file then exports `const stein_lanes stein__lanes4_<name>` in place
 * of the descriptor. Operations and their order are the same, so each lane has the same bits.
 * Elements of M, c and the poses that are always 0 are not written in lanes: the caller's memory
 * holds 0 there.
 */
#ifndef STEIN_MODEL_H
#define STEIN_MODEL_H

#include <stddef.h>

#include "stein/output.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Layout version of stein_model; equations compiled against another one are refused. */
#define STEIN_MODEL_ABI 12

#ifndef STEIN_LANES
#define STEIN_LANES 1
#endif
#if STEIN_LANES == 1
typedef double stein_real;
#elif STEIN_LANES == 0 /* a dual number: value and derivative, see src/core/tangent.c */
typedef double _Complex stein_real;
#else
typedef double stein_real __attribute__((vector_size(8 * STEIN_LANES)));
/** A condition in each lane: all its bits set, or none. Comparisons are cast to it. */
typedef long long stein_mask __attribute__((vector_size(8 * STEIN_LANES)));
#endif

/** The same number in all lanes. */
#if STEIN_LANES <= 1
#define STEIN_ALL(x) (x)
#else
#define STEIN_ALL(x) ((x) - (stein_real){0})
#endif

/** An output that is always 0. In lanes it is not written: it is 0 from the beginning. */
#if STEIN_LANES <= 1
#define STEIN_ZERO(x) ((x) = 0.0)
#else
#define STEIN_ZERO(x) ((void)&(x))
#endif

/** A part of a generated function that is too long for a compiler. It is not inlined. */
#define STEIN_PART __attribute__((noinline))
/** The same for a function that no step calls, and that a compiler would take minutes to
 * optimise. */
#ifdef __clang__
#define STEIN_SELDOM __attribute__((noinline, optnone))
#else
#define STEIN_SELDOM __attribute__((noinline, optimize("O0")))
#endif

/** Physical range of a parameter; each range lies within the one before it. */
typedef enum {
    STEIN_ANY,          /* any finite number */
    STEIN_NOT_NEGATIVE, /* 0 or more: masses, dampings, friction */
    STEIN_POSITIVE,     /* more than 0: speeds and lengths that are divided by */
    STEIN_WEDGE         /* an angle between 0 and pi, without its ends */
} stein_range;

/** One parameter p[i]. */
typedef struct stein_param {
    const char *name; /* dotted path in the file, "hammer.mass" */
    const char *unit; /* SI unit, "kg"; "1" when dimensionless */
    double value;     /* default [unit] */
    double tolerance; /* standard deviation stated in the file (+-) [unit], 0 when none */
    int stated;       /* 1: the file gives it; 0: left at its neutral value */
    stein_range range;
} stein_param;

/** One body and the joint that carries it (one coordinate each; index = coordinate index). */
typedef struct stein_body {
    const char *name;
    int parent; /* body index, -1 = fixed frame; always smaller than the own index */
    char type;  /* 'R' revolute, 'T' prismatic */
    char axis;  /* 'x', 'y', 'z' */
    int sign;   /* +1, or -1 for a joint about or along the negative axis */
    int joint;  /* d index of a STEIN_JOINT block: forces in the joint itself */
} stein_body;

/** A named point of a body, or of the fixed frame (body -1). */
typedef struct stein_point {
    const char *name; /* "hammer.head" */
    int body;
    int frame; /* index into frames of its body, -1 = none */
    int at; /* d index of {x, y, z} [m]: x and z in the body's axes from its origin, y in the fixed
               frame, where it stays; -1 for a point whose body has no frame */
} stein_point;

/** A body with a planar pose, evaluated by pose(). It has a contact, the end of a link, the point
 * of a force in the plane, or carries another such body. In ascending order of bodies. */
typedef struct stein_frame {
    int body;
    int parent; /* frame of the body's parent, -1 = fixed frame; smaller than the own index */
} stein_frame;

/** One pose as pose() writes it; the array is [nframe] of these. */
typedef struct stein_pose {
    stein_real x, z;   /* origin of the body (its joint) in the fixed frame [m] */
    stein_real c, s;   /* cosine and sine of the plane angle, counted from +x towards +z */
    stein_real vx, vz; /* velocity of the origin [m/s] */
    stein_real w;      /* angular velocity, positive from +x towards +z [rad/s] */
} stein_pose;

/** One pose in space as pose3() writes it; the array is [npose3] of these. */
typedef struct stein_pose3 {
    double o[3]; /* origin of the body (its joint) in the fixed frame [m] */
    double R[9]; /* row-major: from body axes to axes of the fixed frame */
    double v[3]; /* velocity of the origin [m/s] */
    double w[3]; /* angular velocity, in the fixed frame [rad/s] */
} stein_pose3;

/** Blocks in d, by offset from their base index. Every block has every entry, at its neutral value
 *  where the file states nothing. So a physical effect can be switched on, fitted and tested
 *  without new equations. The laws are in law.h. */
/* clang-format off */
enum { STEIN_FRICTION_A, STEIN_FRICTION_VT, STEIN_FRICTION_B1, STEIN_FRICTION_B2, STEIN_FRICTION_SIZE };
enum {
    STEIN_NORMAL_A, STEIN_NORMAL_B, STEIN_NORMAL_C, STEIN_NORMAL_D,
    STEIN_NORMAL_EXPONENT,   /* p [-] */
    STEIN_NORMAL_HYSTERESIS, /* h [-] */
    STEIN_NORMAL_PRELOAD,    /* F0 [N] */
    STEIN_NORMAL_GAP,        /* wear: the surface lies deeper by this [m] */
    STEIN_NORMAL_ADHESION, STEIN_NORMAL_RANGE, /* pull-off force [N] over a range [m] */
    STEIN_NORMAL_SIZE
};
enum {
    STEIN_JOINT_K, STEIN_JOINT_Q0, STEIN_JOINT_K3,  /* spring and its hardening */
    STEIN_JOINT_B, STEIN_JOINT_ASYMMETRY,           /* viscous, and its dependence on direction */
    STEIN_JOINT_DRAG, STEIN_JOINT_PRELOAD,
    STEIN_JOINT_DRY, STEIN_JOINT_DRY_SPEED,         /* a second, plain Coulomb friction */
    STEIN_JOINT_DRY_ASYMMETRY,                      /* its dependence on direction */
    STEIN_JOINT_STOP_K, STEIN_JOINT_STOP_GAP,       /* backlash: a spring beyond a dead zone */
    STEIN_JOINT_FRICTION,                           /* a STEIN_FRICTION block */
    STEIN_JOINT_SIZE = STEIN_JOINT_FRICTION + STEIN_FRICTION_SIZE
};
/** Reading of an instrument for the true value y: y + (gain - 1) y + square (y - y at rest)^2
 *  + tilt (x - x at rest) + offset, x the marker's horizontal position; `delay` [s] is applied by
 *  the caller that samples. */
enum { STEIN_SENSOR_GAIN, STEIN_SENSOR_OFFSET, STEIN_SENSOR_SQUARE, STEIN_SENSOR_TILT,
       STEIN_SENSOR_DELAY, STEIN_SENSOR_SIZE };
/** True input = gain * signal(t - delay). */
enum { STEIN_SIGNAL_GAIN, STEIN_SIGNAL_DELAY, STEIN_SIGNAL_SIZE };
/* clang-format on */
/** Primitive: position [m] and, for a line, its unit normal towards the free side and the extent
 *  along the tangent (normal turned by -90 deg) from the position, both in the carrier's axes. */
enum {
    STEIN_SHAPE_X,
    STEIN_SHAPE_Z,
    STEIN_SHAPE_R,
    STEIN_SHAPE_NX,
    STEIN_SHAPE_NZ,
    STEIN_SHAPE_LO,
    STEIN_SHAPE_HI,
    STEIN_SHAPE_SIZE
};

/** The same in space: position, radius of a sphere, unit normal of a plane towards its free side,
 * in the carrier's axes. */
enum {
    STEIN_SOLID_X,
    STEIN_SOLID_Y,
    STEIN_SOLID_Z,
    STEIN_SOLID_R,
    STEIN_SOLID_NX,
    STEIN_SOLID_NY,
    STEIN_SOLID_NZ,
    STEIN_SOLID_SIZE
};

/** A point is a circle or a sphere of radius 0. */
typedef enum { STEIN_CIRCLE, STEIN_LINE, STEIN_SPHERE, STEIN_PLANE } stein_shape_kind;

/** One side of a spot. */
typedef struct stein_shape {
    int frame; /* index into frames, of a sphere or plane into frames3; -1 = fixed frame */
    stein_shape_kind kind;
    int d; /* base of a STEIN_SHAPE block, of a sphere or plane of a STEIN_SOLID block */
} stein_shape;

/** A spot: circle against line or circle against circle, or the same with sphere and plane. side[0]
 *  is always a circle or a sphere. */
typedef struct stein_spot {
    int contact; /* owner */
    stein_shape side[2];
} stein_spot;

/** A named contact: one or two spots (a line against a line touches at its two ends), or eight (the
 *  corners of a box). */
typedef struct stein_contact {
    const char *name;
    int first_spot, nspot;
    int normal;   /* d index of a STEIN_NORMAL block */
    int friction; /* d index of a STEIN_FRICTION block */
} stein_contact;

/** A notch: the beak of one body in the notched corner of another (src/core/notch.c). */
typedef struct stein_notch {
    const char *name;
    int catcher;          /* frame index of the body with the corner (pawl), -1 = fixed frame */
    int beak;             /* frame index of the body with the beak (hammer) */
    int d;                /* base of a STEIN_NOTCH block */
    int normal, friction; /* d indices as in stein_contact */
} stein_notch;
/** Corner position, unit vectors of roof and vertical face away from the corner, in the catcher's
 *  axes; beak end and the unit vector along the beak's upper face towards the body, in the beak's.
 */
enum {
    STEIN_NOTCH_CX,
    STEIN_NOTCH_CZ,
    STEIN_NOTCH_RX,
    STEIN_NOTCH_RZ,
    STEIN_NOTCH_VX,
    STEIN_NOTCH_VZ,
    STEIN_NOTCH_EX,
    STEIN_NOTCH_EZ,
    STEIN_NOTCH_BX,
    STEIN_NOTCH_BZ,
    STEIN_NOTCH_SIZE
};

/** Straight spring with damper between two points, its tension along the line (law.h). */
typedef struct stein_link {
    const char *name;
    int point[2]; /* indices into points */
    int d;        /* base of a STEIN_LINK block */
} stein_link;
/** Law of a link: k [N/m], length [m], damping [N s/m]. slack [-] is the missing share of its pull.
 * Off [-] is the share of its force that vanishes when its first end is above z [m], over a range
 * [m]. */
enum {
    STEIN_LINK_K,
    STEIN_LINK_LENGTH,
    STEIN_LINK_B,
    STEIN_LINK_SLACK,
    STEIN_LINK_OFF,
    STEIN_LINK_OFF_Z,
    STEIN_LINK_OFF_RANGE,
    STEIN_LINK_SIZE
};

/** Argument of a table: coordinate or speed of a joint; depth of a contact or its rate. */
typedef enum {
    STEIN_TABLE_POSITION, /* force in the joint [N m or N] over q [rad or m] */
    STEIN_TABLE_SPEED,    /* the same over qd [rad/s or m/s] */
    STEIN_TABLE_DEPTH,    /* normal force [N] over x [m], where x > 0 */
    STEIN_TABLE_RATE /* normal force as a share of its value without the table, over xdot [m/s] */
} stein_table_kind;

/** A law as a curve through points (law.h), beside the laws of a joint or a contact. */
typedef struct stein_table {
    const char *name;
    stein_table_kind kind;
    int index; /* joint; contact; or ncontact + notch */
    int n;     /* points, at least 2 */
    int d;     /* base of at [n], increasing, and value [n] */
} stein_table;

/** Stops of a joint, beside its other laws. There is no force between `from` and `to`. Beyond an
 *  end by x they push back with k x (1 + D xdot); they never pull. */
typedef struct stein_limit {
    int joint; /* coordinate index */
    int d;     /* base of a STEIN_LIMIT block */
} stein_limit;
/** from, to [rad or m], k [N m/rad or N/m], D [s/rad or s/m] */
enum { STEIN_LIMIT_FROM, STEIN_LIMIT_TO, STEIN_LIMIT_K, STEIN_LIMIT_D, STEIN_LIMIT_SIZE };

/** A joint that turns in all directions, as four hinges about z, x, y and z. The first hinge, the
 *  chart, keeps its angle along a motion: its row is qdd = 0, and no force acts there. When the
 *  angle about y comes near 90 deg, the end of that step (or stein_set_state) gives all four angles
 *  new values for the same attitude and angular velocity. The initial speeds of a ball are its
 *  angular velocity about the axes x, y, z of the body. */
typedef struct stein_ball {
    int joint; /* coordinate of the chart; the other three follow, the last one is at the body */
} stein_ball;

/** A closed loop, or a joint that follows another one: rows of h(q) = 0, lengths first, behind the
 *  rows of earlier loops. */
typedef struct stein_loop {
    const char *name;
    int lengths, angles; /* how many of its rows are [m], how many [rad] or a share of 1 */
} stein_loop;

/** Dry friction that sticks: in a joint, or at one spot of a contact. Its law is stein_stick_limit
 *  in law.h. */
typedef enum { STEIN_STICK_JOINT, STEIN_STICK_SPOT } stein_stick_kind;
typedef struct stein_stick {
    stein_stick_kind kind;
    int index; /* JOINT: coordinate; SPOT: index into spots */
} stein_stick;

/** The free load: joint coordinate of its body and the contact it rests on. */
typedef struct stein_load {
    int body; /* -1 when the mechanism has no load */
    int contact;
} stein_load;

typedef enum {
    STEIN_INPUT_JOINT,
    STEIN_INPUT_POINT,
    STEIN_INPUT_MOTION,
    STEIN_INPUT_VOLTAGE
} stein_input_kind;

/** An input signal. JOINT: generalised force. POINT: force along a fixed direction. MOTION: q(t).
 *  VOLTAGE of a motor [V]: generalised force in proportion; the back-EMF is in the joint's damping.
 */
typedef struct stein_input {
    const char *name, *unit;
    stein_input_kind kind;
    int index;     /* JOINT, MOTION, VOLTAGE: coordinate; POINT: point index */
    int direction; /* POINT: d index of the direction {x, y, z} in the fixed frame; VOLTAGE: of the
                      force per volt [N m/V or N/V] */
    int signal;    /* d index of a STEIN_SIGNAL block */
    int hold; /* MOTION: 1 = without a signal the joint is held at its initial value, 0 = free */
} stein_input;

/** Elements of a stroke: the string's contact and the notch (index, or -1). */
typedef struct stein_stroke {
    int string, notch;
} stein_stroke;

/** Operations of one generated function, ROBOTRAN's convention (a sine or cosine counts 1). */
typedef struct stein_ops {
    int add, mul, neg, div, trig;
} stein_ops;

/** The elementary functions that equations need: the library's, for the same bits with any libm. */
typedef struct stein_functions {
    double (*sin)(double), (*cos)(double), (*tan)(double);
} stein_functions;
#if STEIN_LANES <= 1
typedef struct stein_lanes stein_lanes;
/* action and result of a generated solve() where a pivot vanishes */
typedef int stein_solved;
#define STEIN_PIVOTS
#define STEIN_PIVOT(is_good, joint) \
    if (!(is_good)) {               \
        return joint;               \
    }
#define STEIN_SOLVED -1
#else
typedef stein_mask stein_solved; /* the lanes in which one vanished */
#define STEIN_PIVOTS                stein_mask bad = {0};
#define STEIN_PIVOT(is_good, joint) bad |= ~(stein_mask)(is_good);
#define STEIN_SOLVED                bad
/** The functions of a model that an evaluation calls, in lanes. */
typedef struct stein_lanes {
    void (*unloaded)(const stein_real *q, const stein_real *qd, const stein_real *sc,
                     const stein_real *d, stein_real *M, stein_real *c);
    stein_solved (*solve)(const stein_real *M, stein_real *b);
    void (*articulated)(const stein_real *q, const stein_real *qd, const stein_real *sc,
                        const stein_real *d, const stein_real *Q, stein_real *qdd,
                        stein_real *pivot);
    void (*pose)(const stein_real *q, const stein_real *qd, const stein_real *sc,
                 const stein_real *d, stein_pose *pose);
} stein_lanes;
#endif

/* with STEIN_PLAIN a file is compiled without its derivatives, which are half of its text */
#ifdef STEIN_PLAIN
#define STEIN_DERIVED(function) NULL
#else
#define STEIN_DERIVED(function) function
#endif

/* the lanes of a model that are compiled beside it: STEIN_WIDEST 8 (with 2 and 4), 2 or, for none,
 * 0; or a single number of them, STEIN_ONLY */
#ifndef STEIN_WIDEST
#define STEIN_WIDEST 0
#endif
#ifndef STEIN_ONLY
#define STEIN_ONLY 0
#endif
/* hidden: a program may export other equations of the same name */
#define STEIN_LANES_EXTERN            extern __attribute__((visibility("hidden"))) const stein_lanes
#define STEIN_LANES_JOIN(width, name) stein__lanes##width##_##name
#define STEIN_LANES_NAME(width, name) STEIN_LANES_JOIN(width, name)
#if STEIN_WIDEST == 8
#define STEIN_LANES_DECLARE(name) \
    STEIN_LANES_EXTERN stein__lanes2_##name, stein__lanes4_##name, stein__lanes8_##name;
#define STEIN_LANES_OF(name)                                                \
    {                                                                       \
        &stein__lanes2_##name, &stein__lanes4_##name, &stein__lanes8_##name \
    }
#elif STEIN_WIDEST == 2
#define STEIN_LANES_DECLARE(name) STEIN_LANES_EXTERN stein__lanes2_##name;
#define STEIN_LANES_OF(name)              \
    {                                     \
        &stein__lanes2_##name, NULL, NULL \
    }
#elif STEIN_ONLY > 0
#define STEIN_LANES_DECLARE(name) STEIN_LANES_EXTERN STEIN_LANES_NAME(STEIN_ONLY, name);
#define STEIN_LANES_OF(name)                                              \
    {                                                                     \
        STEIN_ONLY == 2 ? &STEIN_LANES_NAME(STEIN_ONLY, name) : NULL,     \
            STEIN_ONLY == 4 ? &STEIN_LANES_NAME(STEIN_ONLY, name) : NULL, \
            STEIN_ONLY == 8 ? &STEIN_LANES_NAME(STEIN_ONLY, name) : NULL  \
    }
#else
#define STEIN_LANES_DECLARE(name)
#define STEIN_LANES_OF(name) \
    {                        \
        NULL, NULL, NULL     \
    }
#endif

/** RK4, DP5: Runge-Kutta 4 and Dormand-Prince 5(4) with steps of dt, split at events only.
 *  CONTROLLED: Dormand-Prince 5(4); every step of dt is divided so that each error estimate is
 *  within the tolerance of stein_set_tolerance. A step depends on the state alone, so a saved state
 *  continues with the same bits. Where stability limits these steps, not accuracy, implicit steps
 *  by Rodas5P follow until explicit ones serve as well (stein_steps_taken). IMPLICIT: the same with
 *  Rodas5P from the beginning. */
typedef enum { STEIN_RK4, STEIN_DP5, STEIN_CONTROLLED, STEIN_IMPLICIT } stein_integrator;

/** The mechanism. */
typedef struct stein_model {
    int abi; /* STEIN_MODEL_ABI */
    const char *name;
    const char *equations; /* hash of everything but parameter values: identifies the equations */
    int nq, np, nd, npoint, nframe, ncontact, nspot, nnotch, nlink, ninput, nchannel;
    const stein_param *params;     /* [np] */
    const stein_body *bodies;      /* [nq] */
    const stein_point *points;     /* [npoint] */
    const stein_frame *frames;     /* [nframe] */
    const stein_contact *contacts; /* [ncontact] */
    const stein_spot *spots;       /* [nspot] */
    const stein_notch *notches;    /* [nnotch] */
    const stein_link *links;       /* [nlink] */
    const stein_input *inputs;     /* [ninput] */
    const stein_channel *channels; /* [nchannel], channel 0 is "time" */
    stein_load load;
    stein_stroke stroke;
    int initial; /* d index of {q0, qd0} pairs, 2*nq values */
    int clock;   /* d index of the recorder's clock error e: recorded t was (1 + e) t */
    int ntable;
    const stein_table *tables; /* [ntable] */
    int settle;                /* 1 = start from static equilibrium near q0 */
    int integrator;            /* a stein_integrator: 0 RK4, 1 DP5, 2 CONTROLLED, 3 IMPLICIT */
    double dt, until;          /* default step and duration [s] */
    stein_ops ops_setup, ops_mass_bias, ops_unloaded, ops_inverse, ops_pose, ops_point, ops_energy,
        ops_slopes, ops_along;
    const struct stein_lanes
        *lanes[3]; /* the same in 2, 4 and 8 lanes, NULL where there are none */

    /** Derived constants from parameters, p [np] in, d [nd] out (stein_setup). */
    void (*setup)(const double *p, double *d, const stein_functions *f);
    /** Mass matrix and nonlinear vector. */
    void (*mass_bias)(const double *q, const double *qd, const double *sc, const double *d,
                      const double *frc, const double *trq, double *M, double *c);
    /** The same with frc = trq = 0, which costs less. Simulations use it, since all their forces
     *  act in Q. */
    void (*unloaded)(const double *q, const double *qd, const double *sc, const double *d,
                     double *M, double *c);
    /** Solution of M x = b along the branches of the tree; b [nq] becomes x. @return -1, or the
     * joint whose pivot vanishes. NULL for a tree of more than 16 joints, and for a mechanism with
     * loops, balls or contacts in space. */
    int (*solve)(const double *M, double *b);
    /** qdd [nq] of M qdd + c = Q by articulated bodies, without M and external forces; pivot [nq],
     * one of them not > 0 where M is singular. NULL where M and its solution are less work, as in
     * all but long chains, and where a joint slides or can be given a motion. */
    void (*articulated)(const double *q, const double *qd, const double *sc, const double *d,
                        const double *Q, double *qdd, double *pivot);
    /** Q = M qdd + c without forming M. */
    void (*inverse)(const double *q, const double *qd, const double *qdd, const double *sc,
                    const double *d, const double *frc, const double *trq, double *Q);
    /** Planar poses of the bodies that have a frame, [nframe]. NULL when nframe = 0. */
    void (*pose)(const double *q, const double *qd, const double *sc, const double *d,
                 stein_pose *pose);
    /** All named points in the fixed frame: x, v [3*npoint], J [3*npoint*nq] row-major with
     *  v = J qd, jdqd [3*npoint] = Jdot qd. NULL when npoint = 0. */
    void (*point)(const double *q, const double *qd, const double *sc, const double *d, double *x,
                  double *v, double *J, double *jdqd);
    /** e[0] kinetic, e[1] potential energy of gravity [J] (zero where all origins are at z = 0). */
    void (*energy)(const double *q, const double *qd, const double *sc, const double *d, double *e);

    /* Derivatives, exact to rounding. A direction is dq, dqd [nq] and dd [nd]; zeros are not
     * cheaper. There are no external forces and moments. Equations of other origin, or compiled
     * with STEIN_PLAIN, leave all four NULL; stein_derivative_create then fails. */

    /** dd [nd] along dp [np]: d d/dp dp. */
    void (*setup_along)(const double *p, const double *dp, double *dd, const stein_functions *f);
    /** Q = M qdd + c by q and by qd, [nq*nq] each, row i of Q_i, with qdd kept. The derivative of
     *  column j of M is the result with qdd = e_j less the result with qdd = 0. NULL for a large
     *  tree. */
    void (*inverse_slopes)(const double *q, const double *qd, const double *qdd, const double *sc,
                           const double *d, double *by_q, double *by_qd);
    /** dQ [nq] along a direction, with qdd kept. */
    void (*inverse_along)(const double *q, const double *qd, const double *qdd, const double *sc,
                          const double *d, const double *dq, const double *dqd, const double *dd,
                          double *dQ);
    /** The poses along a direction, [nframe]. NULL when nframe = 0. */
    void (*pose_along)(const double *q, const double *qd, const double *sc, const double *d,
                       const double *dq, const double *dqd, const double *dd, stein_pose *dpose);

    /* Loops. Then M qdd + c = Q + J^T lambda with h(q) = 0, and the equations have no solve, no
     * lanes and no derivatives. */

    int nloop, nrow;         /* nrow: rows of h, of all loops */
    const stein_loop *loops; /* [nloop] */
    stein_ops ops_closure;
    /** h [nrow], J = dh/dq [nrow*nq] row-major, jdqd [nrow] = Jdot qd. NULL when nrow = 0. */
    void (*closure)(const double *q, const double *qd, const double *sc, const double *d, double *h,
                    double *J, double *jdqd);

    int nlimit;
    const stein_limit *limits; /* [nlimit] */

    int nstick;
    const stein_stick *sticks; /* [nstick] places of friction that sticks: joints, then spots */

    /* Balls, and contacts in space. With either there are no derivatives, no solve and no lanes. */

    int nball, npose3;
    const stein_ball *balls;    /* [nball] */
    const stein_frame *frames3; /* [npose3] bodies that have a contact in space or an output of
                                   attitude, and the bodies that carry them; ascending */
    /** Their poses. NULL when npose3 = 0. */
    void (*pose3)(const double *q, const double *qd, const double *sc, const double *d,
                  stein_pose3 *pose);

    /* Reactions that outputs read. With nreaction = 0 the other fields are empty. */

    int nreaction;
    const stein_reaction *reactions; /* [nreaction] */
    const stein_tie *ties;           /* [nloop] */
    int made;                        /* d index of nq STEIN_MADE blocks */
    int gravity;                     /* d index of x, y, z in the fixed frame [m/s^2] */
} stein_model;

#ifdef __cplusplus
}
#endif
#endif
