/* SPDX-License-Identifier: MIT
 * simulation_state.h - what a simulation is in memory, and the types of its parts: places of
 * contacts, loops, friction that sticks, the state block.
 * Included by: this folder.
 */
#ifndef STEIN_SIMULATION_STATE_H
#define STEIN_SIMULATION_STATE_H

#include "contact_lanes.h"
#include "laws.h"
#include "planar.h"
#include "stein/sim.h"

enum { NOTCH_TIP, NOTCH_CORNER, NOTCH_FACE, NOTCH_REGION, NOTCH_GUARDS };

/* numbers that a register holds: alone two, in lanes one of each lane; four registers are a block
 */
#if STEIN_LANES == 1
typedef double some __attribute__((vector_size(16), aligned(8)));
#define SOME(x) ((some){x, x})
#else
typedef real some;
#define SOME(x) (x)
#endif
enum { STEIN__SUMS = 4 * sizeof(some) / sizeof(real) };

/* of the last evaluation nothing, qdd alone, qdd and touches, or all of it belongs to the current
 * state */
enum { STALE, KNOWN, TOLD, FRESH };

/* Where an evaluation is in a step. INSIDE: guards and gaps of places that are apart are left out.
 * IN_STAGE, a stage of a trial step: the forces of single places are left out, too. */
typedef enum place_in_step { AT_END, INSIDE, IN_STAGE } place_in_step;

/** Forces of one spot or of one notch, from the last evaluation. */
typedef struct spot_force {
    real gap;         /* [m], > 0 apart */
    real normal;      /* [N] >= 0 */
    real tangent;     /* [N], signed along the tangent */
    real depth, rate; /* of what touches deepest [m], [m/s]; depth <= 0: nothing touches */
} spot_force;

/** Two bodies that press on each other, and the laws of it: where they are in d and the poses. */
typedef struct pair {
    const stein_pose *pose[2]; /* in the plane; the second one may be fixed */
    wrench *wrench[2];
    const real *normal, *friction;
    int index;       /* of the contact; ncontact + that of the notch */
    int solid;       /* 1: in space, frames are those of pose3 */
    int frame[2];    /* the second one may be fixed, -1 */
    int parts;       /* of both laws */
    int plain;       /* 1: a polynomial, damping and tanh are all there is to them */
    int stick;       /* place where its friction sticks, -1: it does not */
    real inverse_vt; /* of its friction [s/m] */
} pair;

/** A place where a pair presses, in one evaluation. */
typedef struct touch {
    const pair *pair;
    vec2 at, n; /* n: unit normal on the first body */
    real normal;
    real depth, rate;
    real speed;      /* of sliding [m/s], as depth and rate of a simulation alone */
    spot_force *sum; /* where its forces are added */
} touch;

/** The same in space. */
typedef struct wrench3 {
    double f[3], m[3];
} wrench3;

/** Where a touch is in space: place, unit normal on the first body, direction in which that slides
 *  on the other one (zero where it does not). */
typedef struct touch3 {
    double at[3], n[3], t[3];
} touch3;

/** How the wrench of a frame acts on its joint, and goes on to the parent's frame (-1: the fixed
 * one).
 */
typedef struct limb {
    wrench *wrench, *onto; /* of the body and of its parent, NULL: the fixed frame */
    const stein_pose *pose, *parent_pose;
    int joint, parent;
    enum { LIMB_TURNS, LIMB_ALONG_X, LIMB_ALONG_Z } kind;
    double sign;
} limb;

/** The most usual places: a point on a line, both laws plain. */
typedef enum site_kind { ANY_SITE, ON_FIXED_LINE, ON_LINE } site_kind;

/** A joint with a law of its own: friction, damping, a spring, a limit. */
typedef struct acting {
    const real *law;
    int joint, parts;
    int plain;       /* 1: tanh, a spring and a preload are all there is to it */
    real inverse_vt; /* of its friction [s/rad or s/m] */
} acting;

/** A place where two bodies may press, with its numbers: a spot, or one of three of a notch. */
typedef struct site {
    pair pair;
    site_kind kind;
    int guard;         /* that switches it */
    int line;          /* 1: the second side is a line, 0: a circle */
    int round;         /* 1: the first side has a radius */
    int endless;       /* 1: a line without ends */
    const real *a, *b; /* both sides of a spot */
    vec2 at[2], n;     /* a point of each body; normal of a line on the second one */
    real reach;        /* where the deformation begins: both radii less the gap [m] */
    spot_force *sum;   /* where its forces are told */
} site;

/** Fixed part of the state block; q, qd, rest, mode, phase, engaged, held, stick, anchor follow. */
typedef struct state_head {
    char format[8];
    char equations[16]; /* name of the equations that the state belongs to */
    uint64_t size;      /* of the whole block [bytes] */
    uint64_t sum;       /* of the rest of it; only in what stein_save writes */
    double t;           /* [s] */
    double t0;          /* origin of the step grid: step k ends at t0 + k dt */
    long long step;     /* steps since t0 */
    mask load_present;
    unsigned char implicit; /* 1: steps are implicit (stiff.c), because explicit ones were stiff */
    unsigned char stiff,
        calm; /* how often the last ones were at the border of that, and were not */
    unsigned char reserved;
} state_head;

/** Work of loops.c, partition.c, assemble.c. */
typedef struct stein__loops {
    double *h, *J, *jdqd;         /* [nrow], [nrow*nq], [nrow] where they were asked for last */
    double *A, *rhs, *scale;      /* J while it is eliminated, its right-hand side, its rows */
    double *best;                 /* [nrow] largest element that may be a pivot */
    double *W, *S, *y;            /* [nq*nq], [nq*nq], [nq] system of the independent joints */
    double *x, *b, *start, *step; /* [nq] */
    int *row, *column, *free;     /* [nq] of each pivot; the independent joints */
    int *best_column;             /* [nrow] where that is */
    unsigned char *role, *used, *kept; /* [nq] of a joint; [nrow] has a pivot; [nq] stays */
    int rank_found, nfree;
    int rank;         /* of J where the loops are closed, -1: not known yet */
    double singular;  /* time to a singular position from the present state [s], < 0 since one;
                       * INFINITY: none is known */
    double pass;      /* the first one ahead where J loses rank, INFINITY: none in this step */
    long long passed; /* how often it has, and when the last time [s] */
    double last;
    int near;       /* 1: stages of the step are put onto h = 0 (singular.c) */
    double *lost;   /* [nrow] time at which each row loses its pivot [s] */
    double spacing; /* of places along the motion [s] */
    double *mean;   /* [6*nq] q, qd, qdd as means of places; what they are about, one qdd */
} stein__loops;

#define STEIN__PARTED 4.0  /* times that: they no longer do */
#define STEIN__ALIKE  1e-6 /* sin^2 of the angle between rows that hold the same, metric of M^-1 */
/* what a place that can stick does; SHARES: it sticks and holds nothing by itself */
enum { STUCK, FORWARDS, BACKWARDS, SHARES };

static inline int is_at_rest(int place_does)
{
    return place_does == STUCK || place_does == SHARES;
}

/** Work of stick.c, stick_events.c; rows are those of the places that stick now. */
typedef struct stein__sticks {
    int *joint;            /* [nq] place of the friction in a joint, -1: it does not stick */
    int *touch;            /* [nstick] where it touches, -1: nowhere; joints: always 0 */
    double *slack;         /* [nstick] anchor of what slips, while places change */
    double *speed;         /* [nstick] of sliding [m/s or rad/s] */
    double *force, *limit; /* [nstick] what holds, and how much can [N or N m] */
    double *G, *X;         /* [nstick*nq] dv/dqd of each row, M^-1 of that */
    double *S, *L;         /* [nstick*nstick] G M^-1 G^T; factors */
    double *share;         /* [nstick*nstick] of the independent rows in each row */
    double *H;             /* [nstick*nstick] */
    double *rhs, *mu, *y;  /* [nstick] */
    double *pivot;         /* [nstick] what is left of the diagonal of S */
    double *qdd;           /* [nq] of stein__stick_look */
    double *one;           /* [nq] a row */
    int *row, *order;      /* [nstick] place of a row; independent rows */
    int nrow, rank;
    unsigned char *was, *done; /* [nstick] before a change; in it */
    int deciding;              /* 1: rows of all that stick may be independent (stick_events.c) */
    int off;                   /* 1: nothing sticks or rubs where it could stick (equilibrium.c) */
} stein__sticks;

/** Sites in order, plain ones that follow each other in groups. */
typedef struct places {
    int *one; /* [n] a site, or -1: the next group */
    int n;
    stein__group *group;
} places;

/** How implicit steps are made (implicit.c). */
typedef struct stein__implicit {
    stein_status (*trial)(stein_sim *sim, double h, stein_err *err); /* as stein__trial */
    double (*h_rho)(const stein_sim *sim, double h); /* of the last trial, see stiff.c */
    int placed;    /* 1: the derivatives of where the step begins are there */
    double *dense; /* [3][2*nq] dense output of the last trial beside its ends */
    int inside;    /* 1: that was the last trial, 0: an explicit one */
} stein__implicit;

struct stein_sim {
    const stein_model *model;
    stein_sim_def def;

    /* the state block: everything stein_save copies */
    unsigned char *state;
    size_t state_size;
    state_head *head;
    real *q, *qd;           /* [nq] */
    double *rest;           /* [2*nchannel] value and marker's x of each in the initial state */
    flag *mode;             /* [nguard] */
    unsigned char *phase;   /* [nnotch] configuration of each notch, 0..4 */
    unsigned char *engaged; /* [nnotch] beak has touched under the roof since it was last caught */
    flag *held;             /* [nq] joint locked where it is (the lifted load) */
    unsigned char *stick;   /* [nstick] STUCK, FORWARDS, BACKWARDS, SHARES */
    double *anchor;         /* [nstick] STUCK: where, see stein__spot_slid [rad or m]; else the
                             * speed against its direction that is no reversal [rad/s or m/s] */
    int nguard, nswitch;    /* nswitch: with those of places that can stick */

    double *p;      /* [np] */
    real *d;        /* [nd] */
    real *slope;    /* of the points of all tables, behind each other */
    flag *table_on; /* [ntable] 1: not 0 everywhere */
    int ntable_on;
    int *parent;  /* [nq] joint that the body of a joint hangs on, -1: none */
    int *turning; /* [nturning] joints that turn */
    int nturning;
    acting *acting; /* [nacting] joints with a law (spring, friction) that can give a force */
    int nacting;
    limb *limb; /* [nframe] */
    site *site; /* [nsite] spots, then three a notch: tip, corner, face */
    int nsite;
    stein__contact_kernel kernel; /* forces of plain sites */
    places active;                /* contacts that are on; n is -1: not known */
    places apart;                 /* spots that are not */
    unsigned char *as_of;         /* [nguard] the modes that this belongs to */

    /* result of the last evaluation (stein__evaluate) */
    real *qdd;                 /* [nq] */
    real *guard;               /* [nswitch] */
    spot_force *spot;          /* [nspot] */
    spot_force *beak;          /* [nnotch] resultant; gap holds the overlap s [m] */
    real *Q;                   /* [nq] */
    int fresh;                 /* what of the above belongs to the current state: STALE .. FRESH */
    long long trials;          /* of steps of controlled error, since it was created */
    stein_step_counts counts;  /* those that were taken */
    stein__implicit *implicit; /* NULL: none */
    place_in_step inside;
    int switches_at_end; /* 1: modes switch at the end of the trial step: no qdd and guards there */

    /* workspace */
    stein_pose *pose; /* [nframe], and at -1 that of the fixed frame */
    touch *touch;     /* [ntouch], up to nsite */
    int ntouch;
    touch *begin; /* [nbegin] where a fixed step began; nbegin is -1: not known */
    int nbegin;
    real *slip, *grip;            /* u = v / vt of touches, then of acting joints, and its tanh */
    wrench *wrench;               /* [nframe], and at -1 what is not asked for */
    stein_pose3 *pose3;           /* [npose3], and at -1 that of the fixed frame */
    wrench3 *wrench3;             /* [npose3], likewise */
    touch3 *touch3;               /* [ntouch], of those in space */
    real *M, *c, *inverse;        /* [nq*nq], [nq], [nq] */
    real *x, *xq, *xqd;           /* [width] {q, qd} as evaluated: prescribed ones in place */
    real *sc;                     /* [2*nq] sines and cosines of xq */
    double *sc_asked;             /* [2*nq] the same at a state that is asked for */
    real *ustate;                 /* [3*ninput] signals at the last evaluation */
    real *px, *pv, *pJ, *pa;      /* points */
    int width;                    /* 2*nq rounded up: a state {q, qd} in blocks of STEIN__SUMS */
    int stride;                   /* of rows {q, qd, qdd}, nq + width */
    real *y0;                     /* [7*stride] trial step: where it began, stages, its end */
    real *k;                      /* the derivatives {qd, qdd} in these rows */
    real *q1, *qd1, *qdd0, *qdd1; /* [nq] parts of them: end, derivatives at both ends */
    real *q0, *qd0;               /* [nq] where it began */
    real *e;                      /* [width] its error */
    real *zero;                   /* [3*nq+STEIN__SUMS] */
    double *work;                 /* [nq*nq + 2*nq] */
    double *root;                 /* [nswitch] */
    double *from, *to, *behind;   /* [nswitch] guards at both ends of a search, behind a root */
    int *pivot;                   /* [nq] */
    unsigned char *crossed;       /* [nswitch] guards that switch at the located root */
    stein__loops loop;
    stein__sticks hold;

    unsigned char *reaction; /* work of reaction.c, where a reaction is read */
    int notes_pulls;         /* 1: forces at points go to it as well (stein__note_pull) */

    int jacobians; /* 1: a force acts at a point of a body without a pose */
    int signals;   /* 1: an input has a signal */
    int motions;   /* 1: a joint follows a signal, or is held without it */

    real eq, eqd; /* embedded error estimate; negative: none */

    stein_signal_fn **signal; /* [ninput][lanes] */
    void **signal_ctx;
    stein_event_fn *on_event;
    void *event_ctx;
    stein_force_fn *on_force;
    void *force_ctx;
    double span;      /* of the last trial step [s] */
    double tolerance; /* of a step of controlled error [rad or m] */
    unsigned taken;   /* how often parameters have been */
    void *follower;   /* what follows the motion (sensitivity.c, balance.c), told of every step
                       * taken, of every switch, before and after, and when it is to get off; NULL:
                       * nothing */
    void (*on_accept)(void *follower, stein_sim *sim, double h);
    void (*on_switch)(void *follower, stein_sim *sim, int flipped);
    void (*on_end)(void *follower);
    int follower_is_explicit; /* 1: the follower knows explicit steps only */
#if STEIN_LANES > 1
    const stein_lanes *lanes;
    mask *bound;              /* [ninput] lanes with a signal there */
    mask asked;               /* those whose signals are asked in this trial */
    mask bad;                 /* lanes with an evaluation that failed since this was cleared */
    real eq_taken, eqd_taken; /* of the last step that each lane took */
#endif
};

#if STEIN_LANES > 1
#define EQUATIONS(sim) ((sim)->lanes)
#else
#define EQUATIONS(sim) ((sim)->model)
#endif

#endif
