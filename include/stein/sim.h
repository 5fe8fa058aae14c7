/* SPDX-License-Identifier: MIT
 * sim.h - a simulation: one mechanism, one parameter set, one state.
 *
 * A stein_sim owns one block of memory, allocated by stein_sim_create; nothing allocates after it.
 * Different simulations may run on different threads; one simulation belongs to one thread at a
 * time. All quantities are SI. Names come from the mechanism file.
 */
#ifndef STEIN_SIM_H
#define STEIN_SIM_H

#include <stddef.h>

#include "stein/model.h"
#include "stein/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_sim stein_sim;

/** How to simulate. Take stein_sim_def_default(model), change what you need. */
typedef struct stein_sim_def {
    stein_integrator integrator;             /* how a step is made */
    double dt;                               /* step [s], > 0 */
    void *(*alloc)(void *ctx, size_t size);  /* default malloc; size is never 0; the block begins at
                                                a multiple of 16 bytes */
    void (*release)(void *ctx, void *block); /* default free */
    void *ctx;                               /* passed to both */
} stein_sim_def;

/** The defaults of the mechanism file. */
stein_sim_def stein_sim_def_default(const stein_model *model);

/** Create a simulation with the model's default parameters, in its initial state (stein_reset).
 *  @param def  NULL for the defaults
 *  @return STEIN_OK; EINVAL (a field of def or a parameter out of range), ESTALE (the equations
 * were compiled for another version of libstein), ENOMEM, or what stein_reset returns */
stein_status stein_sim_create(stein_sim **sim, const stein_model *model, const stein_sim_def *def,
                              stein_err *err);
/** Release everything. NULL is fine. */
void stein_sim_destroy(stein_sim *sim);
const stein_model *stein_sim_model(const stein_sim *sim);

/* ---- names ---- */

/** Index of a parameter, channel, input or contact by name; -1 when there is none. */
int stein_find_param(const stein_model *model, const char *name);
int stein_find_channel(const stein_model *model, const char *name);
int stein_find_input(const stein_model *model, const char *name);
int stein_find_contact(const stein_model *model, const char *name);
int stein_find_body(const stein_model *model, const char *name);

/* ---- parameters ---- */

/** Set a parameter [SI]. Acts from the next step on; the state stays (call stein_reset to start
 * from the equilibrium of the new parameters). @return OK, ENAME, EINVAL (outside of the range in
 *  model->params, such as a negative mass, or not finite); then nothing has changed */
stein_status stein_set(stein_sim *sim, const char *name, double value, stein_err *err);
/** Set all parameters at once, p [np] in the order of model->params; all or none.
 *  @return OK, EINVAL */
stein_status stein_set_all(stein_sim *sim, const double *p, stein_err *err);
/** The same for searches: any finite values are accepted, also outside of their ranges. They need
 *  not be physical. @return OK, EINVAL */
stein_status stein_try_all(stein_sim *sim, const double *p, stein_err *err);
/** Value of a parameter [SI]. @return OK, ENAME */
stein_status stein_get(const stein_sim *sim, const char *name, double *value, stein_err *err);

/* ---- running ---- */

/** Back to t = 0: initial values of the file or, with `settle`, the static equilibrium without the
 *  load. The load lies flush on its contact, at rest. Modes of contacts and notch follow from
 *  geometry.
 *  @return OK, ESETTLE, ESINGULAR, ENONFINITE */
stein_status stein_reset(stein_sim *sim, stein_err *err);
/** Degrees of freedom: joints less those that are driven or held, less the rank of the conditions
 * of loops and couplings on the others. Of the last stein_reset; redundant rows count once.
 */
int stein_freedom(const stein_sim *sim);
/** The static equilibrium next to the present positions, at the present time. Speeds are zero;
 * prescribed joints are at their signals. A present load rests; a lifted one stays away. Modes of
 * contacts follow from geometry, modes of notches from memory. Friction, which vanishes at rest,
 * does not act. Repeated in small steps of a signal, this follows a quasi-static motion. With loops
 * and couplings the search goes along the free directions.
 *  @return OK, ESETTLE, ESINGULAR, ECLOSE, EINVAL (bodies that turn in all directions); after a
 * failure the positions are the last that were tried */
stein_status stein_settle(stein_sim *sim, stein_err *err);
/** One step of dt, split at located events. On ENONFINITE, ESINGULAR or ECHATTER the state is that
 *  before the failing sub-step, for inspection. Two events a step are located; the rest of the step
 *  is one sub-step of lower order. A step that is too long for the damping of a contact is
 *  implicit, also of lower order. A step that would miss a whole bounce is ECHATTER. */
stein_status stein_step(stein_sim *sim, stein_err *err);
/** Steps of dt up to exactly t_end [s]; the last one is shorter when t_end is off the grid.
 *  @return as stein_step; EINVAL when t_end is before the current time or not finite */
stein_status stein_run(stein_sim *sim, double t_end, stein_err *err);
/** Called by stein_run_adaptive with the simulation in the state of the time asked for: it may be
 * read and saved, not changed. @return the next time to be called at [s]; INFINITY: no more */
typedef double stein_look_fn(void *ctx, stein_sim *sim);
/** Step control of stein_run_adaptive, and the times of its look function. */
typedef struct stein_pace {
    double tolerance; /* of a step's error estimate, max over joints of |e_q| and h |e_qd|
                       * [rad or m], > 0 */
    double longest;   /* longest step [s], > 0 */
    double h;         /* first step [s], > 0; out: length of the next step */
    double next;      /* first time to look at [s], not before the present one; out: the next one */
    stein_look_fn *look; /* NULL: not called */
    void *ctx;
} stein_pace;
/** Run to exactly t_end [s] with steps of controlled error that end at events and at t_end:
 *  Dormand-Prince 5(4), or Rodas5P (stein_steps_taken). The times of `look` do not shorten steps:
 *  states inside of a step come from its dense output, to order 6 in q and 5 in qd, 4 in implicit
 *  steps. So the states depend smoothly on these times.
 *  @return OK; EINVAL (the integrator is RK4, a number of pace out of range, t_end before the
 * current time or not finite); ENONFINITE, ESINGULAR, ECHATTER: as stein_step, when no step is
 * short enough; ECHATTER also when the motion needs more than 20000 + 1000 (t_end - t)/longest
 * trial steps: it is too stiff */
stein_status stein_run_adaptive(stein_sim *sim, double t_end, stein_pace *pace, stein_err *err);
/** Trial steps of controlled error since the simulation was created, alone or in a batch:
 * accepted ones and rejected ones. A step that is repeated up to an event counts once.
 * It serves to bound the cost of a motion of many runs. */
long long stein_trials(const stein_sim *sim);
/** Steps of controlled error that a simulation has taken since it was created, and their kind. */
typedef struct stein_step_counts {
    long long taken;     /* all of them */
    long long implicit;  /* those by Rodas5P */
    long long changes;   /* how often they became implicit by themselves */
    double first;        /* when stability limited explicit steps for the first time [s] */
    double rate;         /* decay rate of the motion that limited them [1/s]; 0: none did */
    const char *refused; /* why steps were explicit though stability limited them or implicit ones
                            were requested; NULL: there was no such step */
} stein_step_counts;
/** A motion is stiff where stability, not accuracy, limits explicit steps: strong damping, stiff
 *  springs that have come to rest. The last two stages of Dormand-Prince estimate how near h rho is
 *  to the stability border (Hairer, Norsett & Wanner 1993, IV.2). After 15 steps at the border
 *  steps are implicit, by Rodas5P (Steinebach 2023, BIT 63:27; order 5(4), L-stable) with the exact
 *  derivatives by state. Equations without these (loops, couplings, friction that sticks, bodies
 *  that turn in all directions, contacts in space) use differences, 48 evaluations a joint and
 *  step. After 10 steps that explicit ones could have made, and near a singular position of loops,
 *  steps are explicit again. The kind of steps is part of the state. Events are located in both
 *  kinds alike. There are no implicit steps with a force hook, a signal or sensitivities. Runs of a
 *  batch have them with STEIN_IMPLICIT only.
 */
void stein_steps_taken(const stein_sim *sim, stein_step_counts *counts);
/** How often the motion has passed a singular position of its loops since the simulation was
 *  created, where more ways to move meet. It carries on along its own way, with the same speeds.
 *  Where it comes to rest or turns round there, no way is its own and round-off selects one.
 *  @param last  nullable; out: the time of the last one [s], NAN: there was none */
long long stein_singular_passes(const stein_sim *sim, double *last);
/** Tolerance of a step's error estimate with STEIN_CONTROLLED or STEIN_IMPLICIT, as in stein_pace
 * [rad or m]. Bodies that turn in all directions get a tenth of it, as the errors of every turn
 * add up; STEIN_TOLERANCE until it is set: an elastic ball that bounces 66 times on a contact
 * of 1 ms keeps its energy to 1e-7 with it. @return OK; EINVAL (not > 0 and finite) */
#define STEIN_TOLERANCE 1e-12
stein_status stein_set_tolerance(stein_sim *sim, double tolerance, stein_err *err);
double stein_time(const stein_sim *sim);
/** Length of a whole step [s], as the definition set it. */
double stein_dt(const stein_sim *sim);
/** Coordinates and speeds [nq], valid until the next call that changes the state. */
const double *stein_q(const stein_sim *sim);
const double *stein_qd(const stein_sim *sim);
const double *stein_qdd(stein_sim *sim);
/** Set the state: q, qd [nq] (modes of contacts follow from geometry; notches are armed when the
 *  beak is below the roof). @return OK, EINVAL (not finite), ESINGULAR */
stein_status stein_set_state(stein_sim *sim, double t, const double *q, const double *qd,
                             stein_err *err);
/** Largest component of Dormand-Prince's embedded error estimate of the last (sub-)step, over q
 *  [rad or m] and over qd [rad/s or m/s]. @return OK, EINVAL (integrator is RK4, or no step yet) */
stein_status stein_step_error(const stein_sim *sim, double *eq, double *eqd, stein_err *err);
/** Rate of the fastest contact in the current state, from its stiffness, damping or friction and
 *  the masses behind it [1/s]. Steps have to be shorter than 1/rate to follow it. Changes nothing;
 *  costs some evaluations.
 *  @param index  out: the contact, or ncontact + the index of a notch; untouched when nothing
 *  touches  @return rate; 0 when nothing touches */
double stein_stiffest(stein_sim *sim, int *index);
/** Gimbal lock: are the axes of two hinges on the way to one body nearly parallel in the current
 *  state, so that the mass matrix is nearly singular? Near it speeds are without bound.
 *  @param first, last  out: their joints; -1: there are none such
 *  @return smallest eigenvalue of the mass matrix scaled to a diagonal of 1, about the square of
 * the angle between the axes; 1 where there are none. Changes nothing of the motion. */
double stein_gimbal(stein_sim *sim, int *first, int *last);
/** Take the free load away at once; is it present? Models without load: no effect. */
void stein_load_lift(stein_sim *sim);
int stein_load_present(const stein_sim *sim);
/** Put the free load back where the mechanism is now, at rest and flush on its contact, and let it
 * go. The rest of the state does not change. Models without load: no effect. @return OK,
 * ESINGULAR */
stein_status stein_load_place(stein_sim *sim, stein_err *err);

/* ---- reading ---- */

/** Value of output channel [0, nchannel) in the current state, in the channel's unit. */
double stein_read(stein_sim *sim, int channel);
/** Channel by name. @return OK, ENAME */
stein_status stein_read_name(stein_sim *sim, const char *name, double *value, stein_err *err);
/** Is a reading determined by the motion in the present state? Not if it is a reaction in which
 *  forces of redundant conditions of loops and couplings have a part. Not if it is the friction of
 *  a contact that sticks where other contacts or a prescribed motion hold the same, or a reaction
 *  through which that friction goes. Then it is one of many that are possible.
 *  @return 1: yes, or no such channel; 0: no, or the state has no accelerations */
int stein_is_determined(stein_sim *sim, int channel);

/* ---- state as a flat block ---- */

/** Bytes that stein_save writes: time, coordinates, speeds, contact and notch memory, load. */
size_t stein_state_size(const stein_sim *sim);
void stein_save(const stein_sim *sim, void *block);
/** Continue from a saved state, bit for bit, in any simulation of the same model (parameters,
 *  inputs and hooks are not part of it). The block carries its format, model, size and a checksum.
 *  @return OK; EINVAL with the state unchanged: block of another format, model or size, damaged, or
 *  no state */
stein_status stein_restore(stein_sim *sim, const void *block, stein_err *err);
/** The same for a block from outside, of which only `size` bytes are there. */
stein_status stein_restore_from(stein_sim *sim, const void *block, size_t size, stein_err *err);

/* ---- events ---- */

typedef enum {
    STEIN_EVENT_CONTACT_BEGIN, /* index: contact */
    STEIN_EVENT_CONTACT_END,   /* index: contact */
    STEIN_EVENT_IMPACT,     /* index: contact; the stroke's string is touched (follows its begin) */
    STEIN_EVENT_ESCAPEMENT, /* index: notch; the beak's end passes the corner after contact */
    STEIN_EVENT_CAUGHT,     /* index: notch; the beak's end is back below the roof */
    STEIN_EVENT_PHASE,      /* index: notch; `phase` is the new one */
    STEIN_EVENT_STICK,      /* index: place of friction that sticks, in stein_model.sticks */
    STEIN_EVENT_SLIP        /* index: such a place; `phase`: direction, 1 or -1 */
} stein_event_kind;

typedef struct stein_event {
    stein_event_kind kind;
    int index;
    int phase;   /* PHASE: 0 none, 1..4 as in the paper's fig. 7; SLIP: 1 forwards, -1 backwards */
    double time; /* located [s] */
} stein_event;

/** Name of the contact, notch or joint at which an event is. */
const char *stein_event_at(const stein_model *model, const stein_event *event);

/** Called at every located event, with the simulation in the state of that instant: it may be read
 *  and saved, not changed. */
typedef void stein_event_fn(void *ctx, stein_sim *sim, const stein_event *event);
/** Subscribe (one subscriber; NULL unsubscribes). */
void stein_on_event(stein_sim *sim, stein_event_fn *fn, void *ctx);
/** 1 while a contact is on: it touches, or is as near as its adhesion reaches; else 0. */
int stein_touches(const stein_sim *sim, int contact);
/** Sliding of a contact in the present state, where its friction is smooth: of its places the
 * largest speed [m/s], and that over the turning speed vt of its law. Well below 1 friction is less
 * than its level, so dry friction would hold what here creeps.
 *  @return 1; 0: no place of it presses with friction that is smooth, or no force across could
 * change its sliding since what meets there follows signals, or there is no such contact; both are
 * 0 */
int stein_slides(stein_sim *sim, int contact, double *speed, double *slip);
/** Phase of a notch now: 0 none, 1 beak's end on the roof, 2 face on the roof, 3 face on the
 * corner, 4 beak's end on the vertical face. -1 for an index out of range. */
int stein_notch_phase(const stein_sim *sim, int notch);
/** 1 when the beak's end is below the roof and overlaps it (ready to strike), else 0. */
int stein_notch_armed(stein_sim *sim, int notch);

/* ---- friction that sticks ---- */

/** A place of friction that sticks. */
typedef struct stein_held {
    int touches; /* 1; 0: a spot that is apart, and all else is 0 */
    int slips;   /* 0: it sticks; 1, -1: it slips along the coordinate or the tangent, or against */
    double speed; /* of sliding [m/s or rad/s] */
    double force; /* holding force along the coordinate or, on the first side, along the tangent [N
                     or N m]; 0 while it slips */
    double limit; /* largest holding force [N or N m] */
    int shared;   /* 1: its constraint is redundant: it shares the force of others */
} stein_held;
/** The place [0, nstick) of the model in the current state. @return OK; EINVAL (no such place);
 *  ESINGULAR */
stein_status stein_stick_read(stein_sim *sim, int place, stein_held *held, stein_err *err);

/* ---- inputs and forces of the user ---- */

/** A signal: u[0] value, u[1] first, u[2] second time derivative at t (only a prescribed motion
 *  needs the derivatives). Called at every derivative evaluation. */
typedef void stein_signal_fn(void *ctx, double t, double u[3]);
/** Bind a signal to an input (NULL unbinds). @return OK, ENAME */
stein_status stein_drive(stein_sim *sim, const char *input, stein_signal_fn *fn, void *ctx,
                         stein_err *err);
/** Generalised forces of the user: add to Q [nq] (N m or N). Called at every derivative evaluation
 *  with t, q, qd [nq]; must not call back into the simulation. NULL unbinds. */
typedef void stein_force_fn(void *ctx, double t, const double *q, const double *qd, double *Q);
void stein_on_force(stein_sim *sim, stein_force_fn *fn, void *ctx);
/** Deformation of a contact, or with ncontact + its index of a notch, at the last evaluation of the
 *  forces; a force hook may call it.
 *  @param x, xdot  out: depth [m] and its rate [m/s] where it is deepest; untouched when nothing
 *  touches.  @return 1 when it touches, else 0 */
int stein_deformation(const stein_sim *sim, int index, double *x, double *xdot);

/* ---- equations ---- */

/** Derived constants d [nd] of parameters p [np]. */
void stein_setup(const stein_model *model, const double *p, double *d);
/** sc [2*nq], as the generated functions of a model read it (model.h), at q. */
void stein_turn(const stein_model *model, const double *q, double *sc);
/** M [nq*nq], c [nq] at q, qd; frc, trq [3*nq] per body in body axes at the centre of mass, or NULL
 *  for none. Contacts, springs and friction are not in c. */
void stein_mass_bias(stein_sim *sim, const double *q, const double *qd, const double *frc,
                     const double *trq, double *M, double *c);
/** Inverse dynamics Q = M qdd + c [nq]. */
void stein_inverse(stein_sim *sim, const double *q, const double *qd, const double *qdd,
                   const double *frc, const double *trq, double *Q);
/** All named points: x, v [3*npoint], J [3*npoint*nq], jdqd [3*npoint]; any of them may be NULL.
 *  No effect for a model without points. */
void stein_points(stein_sim *sim, const double *q, const double *qd, double *x, double *v,
                  double *J, double *jdqd);
/** Kinetic and potential (gravity) energy of the tree [J]. */
void stein_energy(stein_sim *sim, const double *q, const double *qd, double *kinetic,
                  double *potential);
/** qdd [nq] at (t, q, qd) with all contacts, laws, inputs and hooks; contact and notch memory as in
 *  the current state. @return OK, ESINGULAR */
stein_status stein_acceleration(stein_sim *sim, double t, const double *q, const double *qd,
                                double *qdd, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
