/* SPDX-License-Identifier: MIT
 * core.h - what the files of the core share. Not installed.
 *
 *   sim.c       create, parameters                       settle.c   static equilibrium, reset
 *   state.c     the state as a block                     blame.c    why a motion ended
 *   dynamics.c  (t, q, qd) -> qdd and all forces         step.c     RK4, DP5, located events
 *   contact.c   spots: where and how deep                adapt.c    steps of controlled error
 *   touch.c     forces of all that touches and rubs
 *   notch.c     the notch and its memory                 channel.c  output channels
 *   table.c     laws given by points                     law.c, linalg.c, status.c
 *   handover.c  parameters from another thread
 *   laws.h      the laws, inline                         elementary.h  sine, cosine, tanh, exp
 *
 * Guards. Every switch of the mechanism is a guard function g(q) and one byte of memory that says
 * on which side the motion is (mode 1: g > 0). Modes are constant within a Runge-Kutta step; a step
 * that ends on the other side is cut at the root of g and the mode flips there. Guards are stored
 * spots first, then four a notch (tip, corner, face, region).
 */
#ifndef STEIN_CORE_H
#define STEIN_CORE_H

#include "laws.h"
#include "stein/sim.h"

#ifdef __FAST_MATH__
#error \
    "libstein counts on IEEE arithmetic: without -ffast-math; for the same bits everywhere also \
-ffp-contract=off -fno-tree-slp-vectorize"
#endif

enum { NOTCH_TIP, NOTCH_CORNER, NOTCH_FACE, NOTCH_REGION, NOTCH_GUARDS };

typedef struct vec2 {
    double x, z;
} vec2;

/* of the last evaluation nothing, qdd alone, or all of it belongs to the current state */
enum { STALE, KNOWN, FRESH };

/** Forces of one spot or of one notch, from the last evaluation. */
typedef struct spot_force {
    double gap;         /* [m], > 0 apart */
    double normal;      /* [N] >= 0 */
    double tangent;     /* [N], signed along the tangent */
    double depth, rate; /* of what touches deepest [m], [m/s]; depth <= 0: nothing touches */
} spot_force;

/** Wrench on a frame about its body's origin: force [N] and plane moment [N m]. */
typedef struct wrench {
    double x, z, m;
} wrench;

/** Two bodies that press on each other, and the laws of it: where they are in d and the poses. */
typedef struct pair {
    int index;    /* of the contact; ncontact + that of the notch */
    int frame[2]; /* the second one may be fixed, -1 */
    const double *normal, *friction;
    double inverse_vt; /* of its friction [s/m] */
} pair;

/** A place where a pair presses, in one evaluation. */
typedef struct touch {
    const pair *pair;
    vec2 at, n; /* n: unit normal on the first body */
    double normal;
    spot_force *sum; /* where its forces are added */
} touch;

/** A spot with its numbers. */
typedef struct site {
    pair pair;
    int line;            /* 1: the second side is a line, 0: a circle */
    const double *a, *b; /* both sides */
} site;

/** Fixed part of the state block; q, qd, rest, mode, phase, engaged and held follow. */
typedef struct state_head {
    char format[8];
    char equations[16]; /* whose state it is */
    uint64_t size;      /* of the whole block [bytes] */
    uint64_t sum;       /* of the rest of it; only in what stein_save writes */
    double t;           /* [s] */
    double t0;          /* origin of the step grid: step k ends at t0 + k dt */
    long long step;     /* steps since t0 */
    int load_present;
    int reserved;
} state_head;

struct stein_sim {
    const stein_model *model;
    stein_sim_def def;

    /* the state block: everything stein_save copies */
    unsigned char *state;
    size_t state_size;
    state_head *head;
    double *q, *qd;         /* [nq] */
    double *rest;           /* [2*nchannel] value and marker's x of each in the initial state */
    unsigned char *mode;    /* [nguard] */
    unsigned char *phase;   /* [nnotch] configuration of each notch, 0..4 */
    unsigned char *engaged; /* [nnotch] beak has touched under the roof since it was last caught */
    unsigned char *held;    /* [nq] joint locked where it is (the lifted load) */
    int nguard;

    double *p, *d;           /* [np], [nd] */
    double *slope;           /* of the points of all tables, behind each other */
    unsigned char *table_on; /* [ntable] 1: not 0 everywhere */
    int ntable_on;
    int *parent; /* [nq] joint that the body of a joint hangs on, -1: none */
    int *acting; /* [nacting] joints whose law is not 0 */
    int nacting;
    double *inverse_vt; /* [nq] of the friction in a joint [s/rad or s/m] */
    site *site;         /* [nspot] */
    pair *catch;        /* [nnotch] beak and catcher */

    /* result of the last evaluation (stein__evaluate) */
    double *qdd;      /* [nq] */
    double *guard;    /* [nguard] */
    spot_force *spot; /* [nspot] */
    spot_force *beak; /* [nnotch] resultant; gap holds the overlap s [m] */
    double *Q;        /* [nq] */
    int fresh;        /* what of the above belongs to the current state: STALE, KNOWN, FRESH */
    int inside; /* 1: inside of a step, where guards and gaps of what is apart are not asked */

    /* workspace */
    stein_pose *pose; /* [nframe], and at -1 that of the fixed frame */
    touch *touch;     /* [ntouch], up to nspot + 3*nnotch */
    int ntouch;
    double *slip, *grip;            /* u = v / vt of touches, then of acting joints, and its tanh */
    wrench *wrench;                 /* [nframe], and at -1 what nobody asks about */
    double *M, *c, *inverse;        /* [nq*nq], [nq], [nq] */
    double *x, *xq, *xqd;           /* [width] {q, qd} as evaluated: prescribed ones in place */
    double *sc;                     /* [2*nq] sines and cosines of xq */
    double *sc_asked;               /* [2*nq] the same of what somebody asks about */
    double *ustate;                 /* [3*ninput] signals at the last evaluation */
    double *px, *pv, *pJ, *pa;      /* points */
    int width;                      /* 2*nq rounded up: a state {q, qd} in blocks of four */
    double *y0, *y1;                /* [width] trial step: where it began, its end */
    double *k;                      /* [7*width] its derivatives {qd, qdd}: stages, end */
    double *q1, *qd1, *qdd0, *qdd1; /* [nq] parts of them: end, derivatives at both ends */
    double *q0, *qd0;               /* [nq] where it began */
    double *e;                      /* [width] its error */
    double *zero;                   /* [3*nq+4] */
    double *work;                   /* [nq*nq + 2*nq] */
    double *root;                   /* [nguard] */
    unsigned char *crossed;         /* [nguard] guards that switch at the located root */

    int jacobians; /* 1: a force acts at a point of a body without a pose */
    int motions;   /* 1: a joint follows a signal, or is held without it */

    double eq, eqd; /* embedded error estimate; negative: none */

    stein_signal_fn **signal; /* [ninput] */
    void **signal_ctx;
    stein_event_fn *on_event;
    void *event_ctx;
    stein_force_fn *on_force;
    void *force_ctx;
};

/* status.c: fill err (nullable) from a tiny printf: %s string, %d int, %g double. Returns code. */
stein_status stein__fail(stein_err *err, stein_status code, const char *format, ...);

/* sim.c: d of the parameters in p, and which laws can act with them */
void stein__take_parameters(stein_sim *sim);

/* linalg.c: solve M x = b in place (b becomes x); M [nq*nq] symmetric positive definite with the
 * branches of the tree, overwritten; inverse [nq], of the pivots, is workspace. Returns -1, or the
 * index of a joint whose pivot vanishes. */
int stein__solve(int n, const int *parent, double *M, double *b, double *inverse);

/* state.c: the block without a state, but as that of this model */
void stein__state_clear(stein_sim *sim);

/* touch.c: where the numbers of all pairs are, once for a simulation */
void stein__gather(stein_sim *sim);
/* parameters have changed */
void stein__pairs_prepare(stein_sim *sim);
/* a pair is `depth` deep at a place, n the normal on the first one: its normal force now, that of
 * its friction with all others, both added to f */
void stein__press(stein_sim *sim, const pair *p, vec2 at, vec2 n, double depth, spot_force *f);
/* friction of all touches and joints, forces of the touches into the wrenches */
void stein__rub(stein_sim *sim);

/* contact.c; the guard of a contact that is gone with the load is -1 */
double stein__spot_guard(const stein_sim *sim, int spot);
double stein__spot_gap(const stein_sim *sim, int spot);
void stein__spot_forces(stein_sim *sim);

/* a direction of a body, and a point of it, in the fixed frame */
static inline vec2 turn(const stein_pose *p, double x, double z)
{
    return (vec2){p->c * x - p->s * z, p->s * x + p->c * z};
}

static inline vec2 place(const stein_pose *p, double x, double z)
{
    return (vec2){p->x + p->c * x - p->s * z, p->z + p->s * x + p->c * z};
}

/* velocity of the body's material at a place of the fixed frame */
static inline vec2 velocity(const stein_pose *p, vec2 at)
{
    return (vec2){p->vx - p->w * (at.z - p->z), p->vz + p->w * (at.x - p->x)};
}

/* a force on a frame's body at a place of the fixed frame, into its wrench about the origin */
static inline void apply(stein_sim *sim, int frame, vec2 at, vec2 force)
{
    const stein_pose *p = &sim->pose[frame];
    wrench *w = &sim->wrench[frame];
    w->x += force.x;
    w->z += force.z;
    w->m += (at.x - p->x) * force.z - (at.z - p->z) * force.x;
}

/* sc at q */
static inline void turn_joints(const stein_model *model, const double *q, double *sc)
{
    for (int j = 0; j < model->nq; j++) {
        if (model->bodies[j].type == 'R') {
            stein__sincos(q[j], &sc[2 * j], &sc[2 * j + 1]);
        }
    }
}

static inline void copy(double *restrict to, const double *restrict from, int n)
{
    for (int j = 0; j < n; j++) {
        to[j] = from[j];
    }
}

static inline double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* notch.c */
void stein__notch_guards(const stein_sim *sim, int notch, double *g, double *overlap);
void stein__notch_forces(stein_sim *sim);
unsigned char stein__notch_phase_after(const unsigned char *mode, int previous);

/* dynamics.c */
stein_status stein__evaluate(stein_sim *sim, double t, const double *q, const double *qd,
                             double *qdd, stein_err *err);
/* the wrenches of all bodies into Q */
void stein__wrenches_to_joints(stein_sim *sim);
/* M x = b with sim->M, which may be overwritten; b becomes x. @return -1, or a joint whose pivot
 * vanishes */
int stein__solved(stein_sim *sim, double *b);
void stein__guards(stein_sim *sim, const double *q, double *guard);
double stein__guard(stein_sim *sim, const double *q, int i); /* one of them */
stein_status stein__refresh(stein_sim *sim, stein_err *err);
/* xq, xqd and poses of the current state, without its forces */
void stein__place(stein_sim *sim);
/* signals have changed: what has to be asked about in an evaluation */
void stein__wire(stein_sim *sim);
/* a named point at the last poses; of a body without one, where model->point() was last asked */
void stein__point(const stein_sim *sim, int point, double x[3], double v[3]);
int stein__is_driven(const stein_sim *sim, int joint);
void stein__place_driven(stein_sim *sim);

/* step.c: a trial step of h from the current state, whose qdd must be in qdd0, to q1, qd1, qdd1 and
 * the guards there; checked for numbers that are none */
stein_status stein__try(stein_sim *sim, double h, stein_err *err);
/* dense output of the trial step: quintic Hermite at theta in 0..1 of h; qd may be NULL */
void stein__interpolate(const stein_sim *sim, double h, double theta, double *q, double *qd);
/* is a guard, as evaluated last, on the other side of its mode? */
int stein__any_crossed(const stein_sim *sim);
/* theta of the first root in begin..end of those that are at `end`, where they were evaluated;
 * crossed[] marks what switches there */
double stein__first_root(stein_sim *sim, double h, double begin, double end);
/* the trial step becomes the state at t1; its end derivative is the next first stage */
void stein__accept(stein_sim *sim, double t1);
/* switch what crossed[] marks, and tell */
void stein__flip_crossed(stein_sim *sim);

/* blame.c: what happened in a step of h from the current state, and why, into err (nullable): a
 * signal or hook without a number, a contact that is too stiff, and what it needs. Returns code. */
stein_status stein__blame(stein_sim *sim, double h, stein_status code, const char *what,
                          stein_err *err);

/* channel.c */
void stein__note_rest(stein_sim *sim);

/* table.c: parameters have changed; forces of tables in joints, into Q; the normal force of contact
 * `index` (a notch: ncontact + its index) with what its tables say */
int stein__table_points(const stein_model *model);
void stein__tables_prepare(stein_sim *sim);
void stein__tables_joints(stein_sim *sim);
double stein__tables_normal(const stein_sim *sim, int index, double force, double x, double xdot);

/* settle.c */
stein_status stein__settle(stein_sim *sim, stein_err *err);

#endif
