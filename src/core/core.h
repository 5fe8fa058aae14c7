/* SPDX-License-Identifier: MIT
 * core.h - what the files of the core share.
 *
 *   of a simulation alone
 *      sim.c             create, parameters               state.c        the state as a block
 *      equilibrium.c     static equilibrium, reset        failure.c      why a motion ended
 *      dynamics.c        (t, q, qd) -> qdd                channel.c      output channels
 *      step.c            fixed steps, located events      adapt.c        steps of controlled error
 *      step_remainder.c  what is left of fixed steps      implicit.c, stiff.c  stiff motions
 *      linalg.c          M x = b, and any A x = b         law.c          the laws for others
 *      loops.c           closed loops and couplings       partition.c    their linear system
 *      assemble.c        start positions closing them     chart.c        balls without gimbal lock
 *      stick.c           friction that sticks             stick_events.c when it begins and ends
 *      space.c           contacts in space                status.c       errors
 *      handover.c        parameters from a thread         elementary.c   far and rare functions
 *      identity.c        one hash of all that computes    reaction*.c    what joints transmit
 *      contact_lanes.c   sites in lanes of a register     determined.c   what the motion determines
 *
 *   with the types of real.h, compiled again for each number of lanes
 *      layout.c          memory                           contact.c      spots: where and how deep
 *      inputs.c          external signals                 notch.c        the notch and its memory
 *      forces.c          all other forces, qdd            contact_sites.c  sites and their laws
 *      trial.c           RK4, DP5                         table.c        laws given by points
 *      dense_output.c    within a trial step              laws.h, elementary.h, planar.h  inline
 *      simulation_state.h  a simulation in memory
 *
 *   of many, and of derivatives
 *      lanes.c           trial steps in lanes             tangent.c      derivatives of forces
 *      batch*.c          many simulations in lanes        slopes.c       the same of contacts
 *      processor.c       how many lanes there are         derivative.c   derivatives of qdd
 *      balance.c         energies of a motion             sensitivity.c  derivatives of a motion
 *      linear*.c         a mechanism linearised           points.c       points off the plane
 *
 * Guards. Every switch of the mechanism is a guard function g(q) and one byte of memory that says
 * on which side the motion is (mode 1: g > 0). Modes are constant within a Runge-Kutta step; a step
 * that ends on the other side is cut at the root of g and the mode flips there. Guards are stored
 * spots first, then four a notch (tip, corner, face, region). Behind them are the guards of places
 * that can stick, which depend on speeds and forces and stay >= 0 (stick.c).
 * Included by: this folder, src/fmi, src/load, src/page.
 */
#ifndef STEIN_CORE_H
#define STEIN_CORE_H

#include "simulation_state.h"

#ifdef __FAST_MATH__
#error \
    "libstein counts on IEEE arithmetic: without -ffast-math; for the same bits everywhere also \
-ffp-contract=off -fno-tree-slp-vectorize"
#endif

#if STEIN_LANES == 1
/* dry friction of a place that can stick, in units of its level, against the sliding */
static inline double stein__slips(const stein_sim *sim, int place)
{
    int is = sim->hold.off ? STUCK : sim->stick[place];
    return is_at_rest(is) ? 0.0 : is == FORWARDS ? 1.0 : -1.0;
}

/* mu of a touch; friction of the k-th acting joint [N m or N] */
static inline double stein__touch_mu(const stein_sim *sim, int i)
{
    const pair *p = sim->touch[i].pair;
    return p->stick >= 0 ? stein__slips(sim, p->stick) * p->friction[STEIN_FRICTION_A]
                         : stein__mu(p->friction, p->parts, sim->slip[i], sim->grip[i]);
}

static inline double stein__joint_mu(const stein_sim *sim, int k)
{
    const acting *a = &sim->acting[k];
    int at = sim->ntouch + k, place = sim->hold.joint[a->joint];
    const double *law = a->law + STEIN_JOINT_FRICTION;
    return place >= 0 ? stein__slips(sim, place) * law[STEIN_FRICTION_A]
                      : stein__mu(law, a->parts, sim->slip[at], sim->grip[at]);
}
#endif

/* layout.c: the size of a simulation's block and, where there is one already, its parts */
INNER size_t stein__layout(stein_sim *sim, const stein_model *model);

/* status.c: fill err (nullable) from a tiny printf: %s string, %d int, %g double. Returns code. */
stein_status stein__fail(stein_err *err, stein_status code, const char *format, ...);

/* sim.c: the definition to create something by, def or the defaults (NULL). Is it one, and the
 * model one for this library? @return OK, EINVAL, ESTALE */
stein_status stein__take_def(stein_sim_def *to, const stein_model *model, const stein_sim_def *def,
                             stein_err *err);
/** Can the parameter be that? @return OK, EINVAL (says what it can be) */
stein_status stein__check_param(const stein_param *param, double value, stein_err *err);
/* sim.c: d of the parameters in p, and which laws can act with them */
void stein__take_parameters(stein_sim *sim);

/* linalg.c: solve M x = b in place (b becomes x); M [nq*nq] symmetric positive definite with the
 * branches of the tree, overwritten; inverse [nq], of the pivots, is workspace. Returns -1, or the
 * index of a joint whose pivot vanishes. */
int stein__solve(int n, const int *parent, double *M, double *b, double *inverse);
/* the same in two parts, for several right-hand sides: M becomes its factors, inverse [nq] that of
 * the pivots; then B [nq*m] becomes X, m columns of its own each */
int stein__factor(int n, const int *parent, double *M, double *inverse);
void stein__substitute(int n, const int *parent, const double *M, const double *inverse, double *B,
                       int m);

/* A x = b by elimination with row pivoting, A [n*n] and b [n] overwritten, b becomes x, pivot [n]
 * is workspace; -1 when singular */
int stein__solve_general(int n, double *A, int *pivot, double *b);
/* the same in two parts, for several right-hand sides: A and pivot become its factors */
int stein__factor_general(int n, double *A, int *pivot);
void stein__substitute_general(int n, const double *A, const int *pivot, double *b);

/* state.c: the block without a state, but as that of this model */
void stein__state_clear(stein_sim *sim);

/* contact_sites.c: where the numbers of all pairs are, once for a simulation */
INNER void stein__gather(stein_sim *sim);
/* parameters have changed */
INNER void stein__pairs_prepare(stein_sim *sim);

/* contact.c; the guard of a contact that is gone with the load is -1 */
INNER real stein__spot_guard(const stein_sim *sim, int spot);
real stein__spot_gap(const stein_sim *sim, int spot);
#if STEIN_LANES == 1
/* how far a spot has slid, at the last poses [m]: its rate is the speed of sliding. 0 for two
 * circles, of which that is no function of q */
double stein__spot_slid(const stein_sim *sim, int spot);
/* rate of the speed of sliding of a touch of that spot with qdd = 0 [m/s^2] */
double stein__spot_bias(const stein_sim *sim, int spot, const touch *t);
#endif
INNER void stein__site_forces(stein_sim *sim);
#if STEIN_LANES == 1
/* which contacts are on, in the present modes */
void stein__find_active(stein_sim *sim);
#endif

/* a force on a frame's body at a place of the fixed frame */
static inline void apply(stein_sim *sim, int frame, vec2 at, vec2 force)
{
    push_at(&sim->wrench[frame], arm_to(&sim->pose[frame], at), force);
}

#if STEIN_LANES > 0
/* sc at q */
static inline void turn_joints(const stein_sim *sim, const real *q, real *sc)
{
    for (int k = 0; k < sim->nturning; k++) {
        int j = sim->turning[k];
        stein__sincos(q[j], &sc[2 * j], &sc[2 * j + 1]);
    }
}
#endif

/* by two: of a few numbers, a call of memcpy takes longer than they do */
static inline void copy(real *restrict to, const real *restrict from, int n)
{
    for (int j = 0; j + 1 < n; j += 2) {
        to[j] = from[j];
        to[j + 1] = from[j + 1];
    }
    if (n % 2 != 0) {
        to[n - 1] = from[n - 1];
    }
}

/* n numbers and up to three more behind them */
static inline void clear(real *x, int n)
{
    for (; n > 0; n -= 4, x += 4) {
        memset(x, 0, 4 * sizeof *x);
    }
}

/* notch.c */
INNER void stein__notch_guards(const stein_sim *sim, int notch, real *g, real *overlap);
/* at the end of a step the guards of all notches; their forces begin at 0 */
INNER void stein__notches_look(stein_sim *sim);
unsigned char stein__notch_phase_after(const unsigned char *mode, int previous);

/* forces.c: all forces at xq, xqd */
INNER void stein__forces(stein_sim *sim);
/* the wrenches of all bodies into Q */
INNER void stein__wrenches_to_joints(stein_sim *sim);
/* parameters have changed */
INNER void stein__joints_prepare(stein_sim *sim);
#if STEIN_LANES > 0
/* qdd under them. @return what the generated solve() returns */
INNER stein_solved stein__accelerate(stein_sim *sim, real *qdd);
#endif
/* a named point at the last poses; of a body without one, where model->point() was last asked */
INNER void stein__point(const stein_sim *sim, int point, real x[3], real v[3]);
/* a force on a named point, into the wrench of its body; the fixed frame takes everything */
INNER void stein__pull(stein_sim *sim, int point, const real f[3]);

/* inputs.c: the forces of what drives the mechanism from outside */
INNER void stein__inputs(stein_sim *sim);
#if STEIN_LANES > 0
/* signals at t into ustate, prescribed coordinates into xq and xqd */
INNER void stein__drive(stein_sim *sim, real t);
/* signals have changed: what has to be asked about in an evaluation */
INNER void stein__wire(stein_sim *sim);
/* joints that follow what is given out of the unknowns of M x = b; mostly there are none */
INNER void stein__prescribe(stein_sim *sim, real *M, real *b);
static inline int stein__prescribes(const stein_sim *sim)
{
    int load = sim->model->load.body; // only the load is ever held
    return sim->motions || (load >= 0 && any(mask_of(sim->held[load])));
}
#endif
#if STEIN_LANES == 1
/* the input that a joint follows, if it is not STEIN__FREE or STEIN__HELD */
enum { STEIN__FREE = -1, STEIN__HELD = -2 };
int stein__driver_of(const stein_sim *sim, int joint);
int stein__is_driven(const stein_sim *sim, int joint);
/* stein__drive from a state {q, qd}; the simulation's own joints onto their signals, now */
static inline void stein__drive_from(stein_sim *sim, double t, const double *q, const double *qd)
{
    if (q != sim->xq) {
        copy(sim->xq, q, sim->model->nq);
        copy(sim->xqd, qd, sim->model->nq);
    }
    if (sim->signals) {
        stein__drive(sim, t);
    }
}
void stein__place_driven(stein_sim *sim);
#endif

/* dynamics.c */
#if STEIN_LANES > 0
INNER stein_status stein__evaluate(stein_sim *sim, real t, const real *q, const real *qd, real *qdd,
                                   stein_err *err);
#endif
#if STEIN_LANES == 1
/* M x = b with sim->M, which may be overwritten; b becomes x. @return -1, or a joint whose pivot
 * vanishes */
int stein__solved(stein_sim *sim, double *b);
#endif
stein_status stein__refresh(stein_sim *sim, stein_err *err);
/* behind a switch within a step: qdd, and what sticks or follows the motion asks for */
stein_status stein__restart(stein_sim *sim, stein_err *err);
/* xq, xqd and poses of the current state, without its forces */
void stein__place(stein_sim *sim);

/* loops.c, assemble.c: of a model with rows */
#if STEIN_LANES == 1
/* qdd at xq, xqd under Q and the loops. @return -1, or a joint whose pivot vanishes */
int stein__loops_accelerate(stein_sim *sim, double *qdd);
/* M x = b with J x = 0, or with what qdd has to obey; b becomes x. @return likewise */
int stein__loops_solve(stein_sim *sim, double *b, int moves);
/* of the forces that are missing in the joints [nq], take those of the loops away */
void stein__loops_take(stein_sim *sim, double *missing);
/* xq, xqd at t onto the loops. @return OK, ECLOSE */
stein_status stein__loops_project(stein_sim *sim, double t, stein_err *err);
/* singular.c: looks for a singular position along a step of h from the present state */
void stein__singular_look(stein_sim *sim, double h);
/* is it so near that a step of h has to mind it? */
int stein__singular_is_near(const stein_sim *sim, double h);
/* is a pivot nearly lost at t? */
int stein__singular_is_close(const stein_sim *sim, double t);
/* Near a singular position: puts xq, xqd of a stage onto the loops, then its derivative {qd, qdd}
 * into k. @param at_end  1: of the end of a step, which is on them already */
stein_status stein__singular_derive(stein_sim *sim, double t, int at_end, double *k,
                                    stein_err *err);
/* the state onto the loops, from where it is; as_stated: what the file gives stays, if it can.
 * @return OK, ECLOSE */
stein_status stein__loops_assemble(stein_sim *sim, int as_stated, stein_err *err);
#endif

#if STEIN_LANES == 1
/* stick.c: qdd of what is free, with Q, becomes that with what sticks; guards of all places */
void stein__stick_hold(stein_sim *sim, double *qdd);
/* xq, xqd at t to where everything that sticks is, at rest. @return OK, ESINGULAR */
stein_status stein__stick_project(stein_sim *sim, double t, stein_err *err);
/* rows of what sticks and their system, at the last evaluation with M */
void stein__stick_rows(stein_sim *sim);
/* qd onto 0 in those rows */
void stein__stick_stop(stein_sim *sim, double *qd);
/* where a place has slid to, at the last poses */
double stein__stick_slid(const stein_sim *sim, int place);
/* evaluation at the state of the simulation for what it says of places */
stein_status stein__stick_look(stein_sim *sim);
/* acceleration of sliding of a place that touches, there */
double stein__stick_rate(stein_sim *sim, int place);
/* do two rows hold the same? 1, -1: against each other; 0: no */
int stein__stick_alike(const stein__sticks *s, int a, int b);
/* stick_events.c: can the force of a row be another one, with others that change with it or, where
 * nothing can move, by itself? */
int stein__stick_is_open(const stein_sim *sim, int row);
/* is the friction of a contact one of many that are possible: does it share with others, or sticks
 * where nothing can move? */
int stein__stick_shares(const stein_sim *sim, int contact);
/* stick_events.c: what every place does at the present speeds and forces */
void stein__stick_begin(stein_sim *sim);
/* after switches of other guards, in crossed[], and of its own */
void stein__stick_switch(stein_sim *sim);
#endif

/* space.c: of a model with poses in space */
#if STEIN_LANES == 1
/* poses at q, qd, whose sines and cosines are in sc; no wrenches then */
void stein__place3(stein_sim *sim, const double *q, const double *qd);
/* as those of contact.c: of a spot that is in space */
double stein__solid_gap(const stein_sim *sim, int spot);
double stein__solid_guard(const stein_sim *sim, int spot);
void stein__solid_forces(stein_sim *sim, int spot);
/* a unit force along its normal or across it instead */
void stein__solid_probe(stein_sim *sim, const touch *t, int across);
/* the wrenches into Q */
void stein__solids_to_joints(stein_sim *sim);
/* a channel of the attitude of a body, index that of its pose */
double stein__attitude(const stein_sim *sim, stein_read_kind read, int index);
#endif

/* chart.c: of a model with balls */
#if STEIN_LANES == 1
/* the charts that have to be left, left: the state is the same one in other coordinates.
 * @return has any been? Then the last evaluation belongs to no state. */
int stein__rechart(stein_sim *sim);
/* speeds of the angles where those of a ball are its turning speed about the body's axes */
void stein__spin_up(stein_sim *sim);
/* atan2 with the same bits everywhere */
double stein__angle(double y, double x);
#endif

/* trial.c: a trial step of h from the state {q, qd} at t, whose qdd is known, to q1, qd1, qdd1 and
 * the guards there; where it began stays in q0, qd0, qdd0. Alone where modes switch at its end
 * (switches_at_end) only to q1, qd1. */
#if STEIN_LANES > 0
INNER stein_status stein__trial(stein_sim *sim, real t, real h, stein_err *err);
#endif
#if STEIN_LANES > 0
/* may the trial step of h of a fixed step be unstable? */
INNER mask stein__abrupt(const stein_sim *sim, real h);
#endif
/* what a trial step of controlled error is worth */
typedef struct stein__grade {
    real e, log_e; /* its error in tolerances, INFINITY where that is no number; the logarithm */
    real factor;   /* the next step in lengths of this one */
    real h_rho;    /* how near it was to the border of stability (stiff.c), 0: not asked */
} stein__grade;
#define STEIN__SHORTEST     1e-12 /* a step that is no longer is taken, whatever its error [s] */
#define STEIN__MOST_GROWTH  4.0   /* from one step to the next */
#define STEIN__LEAST_GROWTH 0.1
#if STEIN_LANES > 0
/* @param log_last  log_e of the step taken before; it does not count where this one is too coarse
 */
INNER stein__grade stein__graded(const stein_sim *sim, real h, real tolerance, real log_last);
#endif
#if STEIN_LANES == 1
/* h rho of an explicit trial step of Dormand & Prince (stiff.c) */
double stein__explicit_stiffness(const stein_sim *sim, double h);
#endif
/* are steps of dt divided as their error asks? */
static inline int stein__is_controlled(stein_integrator integrator)
{
    return integrator == STEIN_CONTROLLED || integrator == STEIN_IMPLICIT;
}
/* how many stages a method has; the weights of the derivatives in its stage i, then in its end */
int stein__stages(stein_integrator integrator);
const double *stein__weights(stein_integrator integrator, int i);

#if STEIN_LANES == 1
/* where the next step of fixed length ends [s] */
static inline double stein__next_on_grid(const stein_sim *sim)
{
    return sim->head->t0 + (double)(sim->head->step + 1) * sim->def.dt;
}

/* where the next step of a run to t_end ends [s]: on the grid, or at t_end, which a point of the
 * grid this close to it is. @return does it end on the grid? */
static inline int stein__next_end(const stein_sim *sim, double t_end, double *end)
{
    double slack = 1e-9 * sim->def.dt;
    *end = stein__next_on_grid(sim);
    int whole = *end <= t_end - slack;
    *end = whole ? *end : t_end;
    return whole;
}

/* a run is at its end: the grid begins again there */
static inline void stein__end_run(stein_sim *sim, double t_end)
{
    sim->head->t0 = t_end;
    sim->head->step = 0;
}
#endif

#if STEIN_LANES > 0
/* dense_output.c: dense output of the trial step at theta in 0..1 of h, a quintic Hermite if it was
 * explicit; qd may be
 * NULL */
INNER void stein__interpolate(const stein_sim *sim, real h, double theta, real *q, real *qd);
/* the poses of q, at rest */
INNER void stein__pose_at(stein_sim *sim, const real *q);
/* them, and all guards there */
INNER void stein__guards(stein_sim *sim, const real *q, real *guard);
#endif
double stein__guard(const stein_sim *sim, int i); /* one of them, at the last poses */

/* step.c: can a run from where the simulation is end at t_end? @return OK, EINVAL */
stein_status stein__check_end(const stein_sim *sim, double t_end, stein_err *err);
/* a trial step from the current state, explicit or not, checked for numbers that are none; explicit
 * in any case near a singular position of loops, where f has no slopes */
stein_status stein__try(stein_sim *sim, double h, int implicit, stein_err *err);
/* is a guard, as evaluated last, on the other side of its mode? */
int stein__any_crossed(const stein_sim *sim);
/* those into crossed[] */
void stein__mark_crossed(stein_sim *sim);
/* all guards at theta of the trial step */
void stein__guards_inside(stein_sim *sim, double h, double theta);
/* guard i at theta of the trial step */
double stein__guard_at(stein_sim *sim, double h, double theta, int i);
/* is guard i that of the region of a notch? */
static inline int stein__is_region(const stein_sim *sim, int i)
{
    return i >= sim->model->nspot && (i - sim->model->nspot) % NOTCH_GUARDS == NOTCH_REGION;
}
/* theta of the first root in begin..end of those that are at `end`, where they were evaluated;
 * crossed[] marks what switches there */
double stein__first_root(stein_sim *sim, double h, double begin, double end);
/* from the current time to `target`, cut at every event on the way */
stein_status stein__advance(stein_sim *sim, double target, stein_err *err);
/* the trial step becomes the state at t1; its end derivative is the next first stage */
void stein__accept(stein_sim *sim, double t1);
/* switch what crossed[] marks, and tell */
void stein__flip_crossed(stein_sim *sim);

#if STEIN_LANES == 1
/* implicit.c: room for implicit steps behind a simulation, 0: there are none; in it, sim->implicit.
 * (Pages and FMUs have none: src/page/explicit.c.) */
size_t stein__implicit_size(const stein_model *model, stein_integrator integrator);
void stein__implicit_make(stein_sim *sim, void *block);
/* stiff.c: the next step begins elsewhere than the last trial */
void stein__implicit_leave(stein_sim *sim);
/* is the next step an implicit one? */
int stein__is_implicit(stein_sim *sim);
/* a step of h of either kind was taken, which the error control has limited: which kind is next */
void stein__note_explicit(stein_sim *sim, double h, double stiffness);
void stein__note_implicit(stein_sim *sim, double h);
/* a run has taken too many explicit steps, now of h. @return are the following ones implicit? */
int stein__begin_implicit(stein_sim *sim, double h);
#endif

/* adapt.c: a run with steps of controlled error, trial by trial - begin, then { next where p->h is
 * 0, a trial of p->h, judge } until p->h stays 0, then end */
typedef struct stein__pacer {
    double t_end;
    double log_last, growth, left_over; /* of the control; trials that may still be made */
    int spot;                           /* events without a step between them */
    double t, wanted, h, to;            /* of the trial that is next: begin, length, end */
    int repeated;                       /* it is one that passed, up to its first event */
    double whole;                       /* its length before */
    stein__grade grade;                 /* of the trial */
    int middle;                         /* an event may hide in its middle */
    int explicit_only, implicit;        /* of all trials; this one */
    int prolonged;                      /* more trials were granted, to implicit steps */
} stein__pacer;
stein_status stein__pace_begin(stein_sim *sim, double t_end, const stein_pace *pace,
                               stein__pacer *p, stein_err *err);
stein_status stein__pace_next(stein_sim *sim, const stein_pace *pace, stein__pacer *p,
                              stein_err *err);
/* a trial of p->h, judged as well. (A trial made in a lane is judged by stein__pace_judge.) */
stein_status stein__pace_try(stein_sim *sim, const stein_pace *pace, stein__pacer *p,
                             stein_err *err);
stein_status stein__pace_judge(stein_sim *sim, stein_pace *pace, stein__pacer *p,
                               stein_status status, stein_err *err);
/* stein_run_adaptive without its end: the grid of fixed steps stays */
stein_status stein__run_controlled(stein_sim *sim, double t_end, stein_pace *pace, stein_err *err);
void stein__pace_end(stein_sim *sim, stein_pace *pace, double t_end);
/* ENONFINITE where the end of the trial step of h is no number */
stein_status stein__check_finite(stein_sim *sim, double h, stein_err *err);
/* step_remainder.c: what touches where a step begins, out of the way of its evaluations */
void stein__keep_touches(stein_sim *sim);
/* step_remainder.c: an abrupt trial step to `target`, if it is too long for a contact: *taken,
 * implicitly. Else it stays as it is, and the forces are not those of its end (TOLD). lost: its
 * end is no number.
 * @return as stein__take_rest */
stein_status stein__take_abrupt(stein_sim *sim, double target, int lost, int *taken,
                                stein_err *err);
/* step_remainder.c: from a trial step to `target` that has events to `target`, whose events are not
 * located.
 * @return OK, ECHATTER (a contact is too short for it), ENONFINITE, ESINGULAR */
stein_status stein__take_rest(stein_sim *sim, double target, stein_err *err);
/* failure.c: a unit force at what touches, along its normal or across it, into Q, which is zero */
void stein__probe(stein_sim *sim, const touch *t, int across);
/* failure.c: what happened in a step of h from the current state, and why, into err (nullable): a
 * signal or hook without a number, a contact that is too stiff, and what it needs. Returns code. */
stein_status stein__explain_failure(stein_sim *sim, double h, stein_status code, const char *what,
                                    stein_err *err);

/* channel.c */
void stein__note_rest(stein_sim *sim);
/* what the instrument of a channel makes of a change of its reading, in the current state */
double stein__channel_slope(stein_sim *sim, int channel);

/* reaction.c: the reading of stein_model.reactions[i] at the last evaluation, which is made STALE
 * where something sticks; its work in a simulation's block [bytes]; a force at a point of a body
 * without a pose, where px is that of all points */
#if STEIN_LANES == 1
double stein__reaction(stein_sim *sim, int i);
void stein__note_pull(stein_sim *sim, int point, const double f[3]);
#endif
size_t stein__reaction_size(const stein_model *model);

/* table.c: parameters have changed; forces of tables in joints, into Q; the normal force of contact
 * `index` (a notch: ncontact + its index) with what its tables say */
int stein__table_points(const stein_model *model);
INNER void stein__tables_prepare(stein_sim *sim);
INNER void stein__tables_joints(stein_sim *sim);
INNER real stein__tables_normal(const stein_sim *sim, int index, real force, real x, real xdot);

/* equilibrium.c */
stein_status stein__settle(stein_sim *sim, stein_err *err);

#endif
