/* SPDX-License-Identifier: GPL-3.0-or-later
 * reality.h - an independent source of measurements of the piano action, with or without an effect
 * that no model file mentions.
 *
 * Nothing here is shared with the library under test but the reader of mechanism files, which gives
 * the numbers by name: equations, contacts, integration and cameras are written independently.
 *
 *   parts.c    numbers of the mechanism file -> action      stroke.c   rest, events, one stroke
 *   touch.c    contacts and the notch                       kinds.c    hidden effects: the table
 *   motion.c   equations of motion                          effect.c   put into the action
 *   hidden.c   formulas of the hidden effects               refit.c    their size, after refitting
 *   outside.c  laws that are in no table of effects         next.c     a stroke somebody asked for
 *   observe.c  what noiseless instruments would show        design.c   strokes, truth, scatter
 *   camera.c   frames, pixels, noise, CSV                   scale.c    the amount for a size
 *   main.c     command line                                 answer.c   the sealed answer
 *
 * Planar: x right, z up, angles from +x towards +z, SI. All angles of segments are absolute.
 */
#ifndef REALITY_H
#define REALITY_H

#include <gsl/gsl_rng.h>
#include <stddef.h>
#include <stdio.h>

#include "mechanism.h"

typedef struct vec {
    double x, z;
} vec;

/* ---- the action's numbers ---- */

enum { JOINT_KEY, JOINT_HAMMER, JOINT_PAWL, JOINTS };
enum { REST, DIP, LOOPS, STRING, STOP, LOAD, NOTCH, CONTACTS };
/* places where two surfaces meet: the six contacts, then the notch's three */
enum { TIP = NOTCH, CORNER, FACE, SPOTS };

/** Friction: T or mu = A (tanh u + B1 u/(1 + B2 u^4)), u = v/vt. */
typedef struct rub {
    double A, vt, B1, B2;
} rub;

/** A joint's own torque on its coordinate q (key: front down; hammer, pawl: anticlockwise). */
typedef struct hinge {
    rub friction;
    double k, theta0; /* spring of the file */
    double viscous, coulomb, coulomb_w0, drag, preload, stiffness, hardening, slack_k, slack;
    double creep, creep_w0, creep_turn, creep_time; /* friction that heats up and fades */
    double bump, bump_at, bump_width;               /* torque around one angle */
} hinge;

/** Felt, leather: f = scale (a x^3 + b x^2 + c x) (x/0.1 mm)^p (1 + D xdot)(1 + h tanh(xdot/v_h)).
 */
typedef struct felt {
    double a, b, c, D;
    rub friction;
    double scale, power, hysteresis, pull, range, gap;
    double layer, layer_time; /* second layer that flows: stiffness [N/m], time [s] */
    double hump, hump_at;     /* a harder place: force [N], depth [m] */
    double ease, ease_time;   /* share of the force that relaxes, time [s] */
} felt;

/** A rigid piece: centre from the origin of its segment's axes. */
typedef struct piece {
    double m, I;
    vec c;
} piece;

/** Elastic split of a link: the outer piece turns about `at` against k and d. */
typedef struct split {
    int on;
    vec at;
    piece outer;
    double k, d;
} split;

typedef struct action {
    double g;
    piece body[JOINTS];
    vec kapsel, pawl_hinge;
    vec front, rear, below, loops_at, head, beak, shank, corner, back;
    vec rest_at, dip_at, stop_at, string_at;
    vec pad[NOTCH];                     /* normals of the pads, in their carriers' axes */
    vec roof, under, right, below_beak; /* notch: e_r, n_r, n_v (pawl's axes), -n_b (hammer's) */
    double load_mass;
    hinge joint[JOINTS];
    felt felt[CONTACTS];
    /* what may be hidden in it */
    split key_split, hammer_split;
    double pin_k, pin_d, pin_ratio; /* key's pin gives: stiffness, damper, lift/seat stiffness */
    double string_k, string_m, string_d; /* string on a spring; 0 none */
    double damper_force, damper_k, damper_at;
    double wire_k, wire_length;
    vec wire_from; /* on the frame; the other end is the key's front */
    double magnet; /* N m^2, pulls the head towards magnet_at */
    vec magnet_at;
    /* what moves it besides the load */
    int drive; /* 0 nothing, 1 finger force, 2 key motion */
    double drive_size,
        drive_time; /* top force [N] or angle [rad] of the touch, its rise time [s] */
    int drive_back; /* 1: and back in the same time */
    double drive_gain, drive_delay;
} action;

/* ---- one stroke ---- */

/* coordinates; the last four exist only when something hidden needs them */
enum { D_KEY, D_HAMMER, D_PAWL, D_LOAD, D_REAR, D_HEAD, D_PIN, D_STRING, DOFS };
enum { FLOW, HEAT, MEMORIES }; /* FLOW: of the one contact that has a memory */
enum { MAX_STATE = 2 * DOFS + MEMORIES };
/* guards: a sign that is constant within a step. G_OVER: the beak's end under the roof (s > 0),
 * G_ABOVE: above its plane (h > 0). MODE_BESIDE is the notch's memory, no guard. */
enum {
    G_TOUCH = 0,
    G_NEAR = SPOTS,
    G_PUSH = 2 * SPOTS,
    G_OVER = 3 * SPOTS,
    G_ABOVE,
    G_DAMPER,
    GUARDS,
    MODE_BESIDE = GUARDS,
    MODES
};

/** What ideal instruments read, and its rate. */
enum { C_STRING, C_DIP, C_HAMMER, C_HEAD_X, C_FRONT_X, CHANNELS };

/** What was visited: positions of the joints as the file counts them, depths of the contacts. */
typedef struct visits {
    double low[JOINTS], high[JOINTS], deepest[CONTACTS];
} visits;

typedef struct stroke {
    double step;            /* interval of the grid [s] */
    int n;                  /* grid points from t = 0 */
    double (*y)[CHANNELS];  /* [n] */
    double (*yd)[CHANNELS]; /* [n] rates */
    double impact, rebound; /* begin and end of the first string contact [s], 0: none */
    double key_rest;        /* angle of the key (as the file counts it) at rest */
    double escape;          /* beak beside the corner for the first time [s], 0: never */
    visits seen;
    long evaluations;
} stroke;

/** Where everything is and what acts, at one instant. */
typedef struct instant instant;

/* parts.c */
int parts_fill(action *a, const mechanism *m, const double *p);
piece piece_rest(piece whole, piece part); /* what is left of a body */

/* touch.c, motion.c */
enum { MAX_CHAIN = 4 };
typedef struct segment {
    vec from;    /* the body's point that is the segment's origin */
    vec P, V, A; /* origin, its velocity, its acceleration when no coordinate accelerates */
    int nchain, chain[MAX_CHAIN]; /* the coordinates that move the origin */
    vec J[MAX_CHAIN];             /* dP/dq for each of them */
    double phi, w, c, s;
    int dof;  /* coordinate of phi */
    vec F;    /* sum of forces put on the segment */
    double M; /* their moment about P */
} segment;
enum { S_KEY, S_REAR, S_HAMMER, S_HEAD, S_PAWL, SEGMENTS };

struct instant {
    const action *a;
    double t;
    double q[DOFS], v[DOFS], memory[MEMORIES];
    segment seg[SEGMENTS];
    int rear, head; /* segments that carry the Kapsel and the head: split or not */
    double b[DOFS]; /* generalised forces */
    double guard[GUARDS];
    double depth[SPOTS], pressed[SPOTS]; /* pressed: depth where surfaces touch, else 0 */
    double memory_rate[MEMORIES];
};

static inline vec vec_minus(vec a, vec b)
{
    return (vec){a.x - b.x, a.z - b.z};
}

static inline double vec_dot(vec a, vec b)
{
    return a.x * b.x + a.z * b.z;
}

/** A vector from the segment's axes to the frame's. */
static inline vec seg_rotate(const segment *s, vec u)
{
    return (vec){s->c * u.x - s->s * u.z, s->s * u.x + s->c * u.z};
}

static inline vec seg_place(const segment *s, vec point)
{
    vec r = seg_rotate(s, vec_minus(point, s->from));
    return (vec){s->P.x + r.x, s->P.z + r.z};
}

static inline vec seg_velocity(const segment *s, vec at)
{
    return (vec){s->V.x - s->w * (at.z - s->P.z), s->V.z + s->w * (at.x - s->P.x)};
}

static inline void seg_push(segment *s, vec at, vec force)
{
    s->F.x += force.x;
    s->F.z += force.z;
    s->M += (at.x - s->P.x) * force.z - (at.z - s->P.z) * force.x;
}

void touch_all(instant *now, const unsigned char *mode);
double rub_law(const rub *r, double v);

typedef struct motion {
    const action *a;
    int n, index[DOFS], dof[DOFS]; /* active coordinates, packed */
    double key0, front0;           /* key's angle and height of its front at rest */
    unsigned char mode[MODES];
    int loaded; /* the load is there */
    long evaluations;
} motion;
void motion_init(motion *mo, const action *a);
void motion_look(motion *mo, double t, const double *y, instant *now);
/** Only where everything is and on which side the guards are. */
void motion_guards(motion *mo, double t, const double *y, instant *now);
int motion_rates(motion *mo, double t, const double *y, double *dydt, instant *now);
void motion_read(const motion *mo, const instant *now, double *y, double *yd);

/* hidden.c */
double hidden_torque(const hinge *h, double q, double qd, double heat);
void hidden_forces(instant *now, const unsigned char *mode);
void hidden_touch(double t, const action *a, double u[3]);

/* stroke.c */
int stroke_run(stroke *s, const action *a, double until, double step, double tolerance);
void stroke_free(stroke *s);
/** Value (and rate, may be NULL) of a channel at any time; at rest before t = 0. */
double stroke_at(const stroke *s, int channel, double t, double *rate);

/* ---- hidden effects ---- */

/** One parameter of an effect: name, unit, range of a draw. */
typedef struct effect_parameter {
    const char *name, *unit;
    double lo, hi;
} effect_parameter;

enum { SIDES = 3 };

/** One kind: the first parameter is its size, `limit` times an amount of at most 1. */
typedef struct effect_kind {
    const char *name, *verdict; /* verdict: class of the answer */
    const char *places;         /* separated by blanks */
    int both_signs, drawn;      /* drawn = 0: only when asked for by name */
    const char *size, *unit;
    double limit[3]; /* by place: key, hammer, pawl, else the first */
    effect_parameter side[SIDES];
    const char *law;
} effect_kind;

/** Where and how large. amount 0: nothing. */
typedef struct effect {
    const effect_kind *kind; /* NULL: nothing hidden */
    char place[MECH_PATH];
    int where; /* joint, contact, channel or parameter index, by kind */
    double amount, side[SIDES];
    const struct effect *also; /* a second one, NULL: none */
} effect;

/** An instrument's errors. */
typedef struct sensor {
    double gain, offset, delay, square, tilt;
} sensor;
enum { SEEN = 3 }; /* string_distance, key_dip, hammer_angle */
extern const char *const seen_name[SEEN], *const seen_unit[SEEN];

/** All that is true of one laboratory. */
typedef struct world {
    const mechanism *m;
    double *p;             /* [nparam] true values, without the effect */
    effect hidden, second; /* hidden.also is the second, or NULL */
} world;

extern const effect_kind effect_kinds[], outside_kinds[];
/** In either table. */
const effect_kind *effect_find(const char *name);
/** The n-th place of a kind. @return 0 when there are fewer */
int effect_nth_place(const effect_kind *kind, int n, char place[MECH_PATH]);
int effect_has_place(const effect_kind *kind, const char *place);
/** Place (NULL: drawn) and further parameters. @return 0, or -1 for an impossible place */
int effect_draw(effect *e, const effect_kind *kind, const char *place, const mechanism *m,
                gsl_rng *rng);
double effect_size(const effect *e); /* in its unit */
/** What the effect sets in the end, for the answer: e.g. the new value of a parameter. */
double effect_value(const effect *e, const world *w);
/** Parameter of the file that the effect changes, -1 when it is none. */
int effect_own_parameter(const effect *e, const mechanism *m);
void effect_on_parameters(const effect *e, const mechanism *m, double *p);
void effect_on_action(const effect *e, action *a);
void effect_on_sensors(const effect *e, sensor s[SEEN], double *clock);
/** Is it a kind that another one is easily taken for. */
int effect_has_twins(const effect_kind *kind);
/** Does it leave the action alone, errors of an instrument only. */
int effect_is_instrument(const effect *e);
int effect_touch(const effect *e); /* kind of stroke it needs: 0 load, 1 finger, 2 key motion */

/* ---- outside.c ---- */

enum { LAW_POINTS = 121 };
/** A law over the visited range of its variable, n 0: it is no function of a state. */
typedef struct known_law {
    const char *site, *of, *at_unit, *unit; /* of: "position", "depth", "history" */
    int n;
    double at[LAW_POINTS], value[LAW_POINTS];
} known_law;
int effect_is_outside(const effect *e);
/** The kind in the table that an effect outside of it is at one end of its range, NULL: none. */
const char *outside_limit(const effect *e);
void outside_sides(effect *e);
double outside_unit(const effect *e);
void outside_on_action(const effect *e, action *a, double size);
double outside_torque(const hinge *h, double q);
double outside_push(const felt *f, double N, double x, double memory);
double outside_memory_rate(const felt *f, int touching, double memory);
double outside_memory_at_rest(const action *a);
void visits_add(visits *v, const visits *more);
void outside_law(const effect *e, const visits *v, known_law *law);

/* ---- a set of strokes ---- */

enum { FIT = 12, HELD = 6, STROKES = FIT + HELD };

/** One more number of the file that a stroke sets. */
typedef struct override {
    int param;
    double value;
} override;
enum { OVERRIDES = 8 };

/** What may hang on the key and can be taken off, with the amount that is 0 then. */
enum { OFF_WIRE, OFF_DAMPER, OFF };
extern const char *const off_name[OFF];

typedef struct setting {
    double dx, load; /* as told */
    int nset;
    override set[OVERRIDES];
    int touch; /* 0 load only, 1 finger force, 2 key motion */
    double touch_size, touch_time;
    int touch_back; /* 1: there and back */
    int off[OFF];   /* 1: taken off, if it was there */
    /* scatter, not told: relative changes, time of the trigger, marker offsets */
    double joint_friction, contact_friction, drive, trigger, offset[SEEN];
} setting;

typedef struct camera {
    double rate, pixel, arm; /* arm: of the marker that shows the hammer's angle [m] */
    double before, until;    /* first and last frame [s] */
    int seen;                /* channels filmed: 2 or 3 */
    double accuracy;         /* of the strokes that it films: local error of a step */
} camera;

typedef struct design {
    setting stroke[STROKES];
    camera camera;
    double joint_scatter, contact_scatter, drive_scatter, jitter, marker;
    int touch, scatter, wrong_start;
} design;

extern const camera standard_camera;
double camera_noise(const camera *c, int channel);
void design_strokes(design *d, int touch);
/** All strokes as the n-th one was told, before scatter. */
void design_alike(design *d, int like);
/** How one stroke differs by itself, markers aside; then how all do. */
void design_differ(const design *d, setting *s, gsl_rng *rng);
void design_scatter(design *d, gsl_rng *rng);
void design_truth(const design *d, world *w, gsl_rng *rng);

/* observe.c: the stroke as instruments without noise would film it */
typedef struct film {
    int n;
    double (*y)[SEEN], (*yd)[SEEN]; /* [n] values, rates */
    double key_rest;                /* key's angle (of the file) at rest */
} film;
/** The stroke itself, up to the camera's end. */
int film_play(stroke *k, const world *w, const effect *e, const double *p, const setting *s,
              const camera *c);
/** A film of it; of the effect only what it does to the instruments. */
int film_shoot(film *f, const stroke *k, const effect *e, const setting *s, const camera *c);
int film_take(film *f, const world *w, const effect *e, const double *p, const setting *s,
              const camera *c);
void film_free(film *f);
int film_frames(const camera *c);

/* refit.c */
typedef struct refit refit;
refit *refit_create(const world *w, const design *d);
void refit_free(refit *r);
/** The law of the table that an effect outside of it may be is refitted beside it.
 *  @return 0, -1: it cannot be simulated */
int refit_beside(refit *r, const effect *e);
/** RMS change [noise of a sample] of the channel that shows the effect most, after refitting. The
 *  refit begins at the end of the stored one, in proportion. Sizes from a quarter to three
 * times `target` are good, others show only that they are less or more. @return 0, -1: not
 * simulated */
int refit_size(refit *r, const effect *e, double target, double *size);
/** The same before refitting. */
int refit_raw(refit *r, const effect *e, double *size);
/** Is a size so far beyond the wanted one that its value has no further information? */
int refit_is_lost(double size, double target);
/** The last refit, of effect e, is where others begin. */
void refit_keep(refit *r, const effect *e);
/** The next effect is another one: nothing is kept, columns of the true parameters. */
void refit_forget(refit *r);
/** The size of the last refit after one more step by a dense least-squares problem (gsl_multifit),
 *  without own algebra: slow, for checking. */
int refit_size_dense(const refit *r, double *size);

/* scale.c */
/** Amount at which the size is `target`. @return NULL, or why there is none, for the answer */
const char *refit_scale(refit *r, effect *e, double target, double *reached);

/* camera.c */
/** @param seen  what the stroke visits is added to it; may be NULL */
int camera_write(const char *path, const world *w, const design *d, const setting *s, gsl_rng *rng,
                 visits *seen);

/* next.c */
/** A requested stroke, by the words of the command line. */
typedef struct asked {
    const char *set[OVERRIDES + 2]; /* NAME=VALUE in SI */
    int nset;
    const char *drive; /* INPUT,SHAPE,SIZE,TIME; NULL: none */
    int repeats;
} asked;
/** DIR/next_01.csv ... @return 0, -1 after a message, 3: cannot be filmed, after a message */
int next_write(const char *folder, const asked *q, const world *w, design *d, gsl_rng *scene,
               gsl_rng *noise);

/* answer.c */
enum { MAX_REDRAWN = 60 };
typedef struct answer {
    const world *w;
    const design *d;
    const char *level;
    double target, reached, dense; /* dense < 0: not checked */
    visits seen;
    int met;
    unsigned long seed;
    int nredrawn;
    struct {
        const char *kind, *why;
        char place[MECH_PATH];
        double reached;
    } redrawn[MAX_REDRAWN];
} answer;
int answer_write(const char *path, const answer *a);

#endif
