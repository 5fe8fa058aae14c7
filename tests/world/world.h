/* SPDX-License-Identifier: GPL-3.0-or-later
 * world.h - measurements of any mechanism, made by an independent program.
 *
 * Nothing here is linked with the library, the generator or the reader of mechanism files: the
 * equations of motion are projected Newton-Euler equations in the fixed frame, evaluated with
 * numbers; the integrator has adaptive steps; the random numbers are its own. What is shared is the
 * format of the files and the laws as docs/mechanism-files.md and include/stein/law.h state them.
 *
 * A draw is made in this order:
 *
 *   catalog.c   a mechanism with true numbers, and the motions that its records show
 *   design.c    sensors, records, scatter; what the file says of the numbers
 *   effect.c    what is hidden, a change of some true numbers
 *   size.c      how large it has to be for a level
 *   mistake.c   or a number of the file that is far off
 *   record.c    the records as the sensors show them
 *   write.c     model.yaml, fit_*.csv, held_*.csv; answer.c the sealed answer
 *
 * All numbers of a mechanism are in one array: what the file states, laws at their neutral values,
 * errors of instruments. An effect, an error of the file and a derivative are changes of that
 * array.
 */
#ifndef WORLD_H
#define WORLD_H

#include <stddef.h>

enum {
    BODIES = 6,
    NUMBERS = 400,
    CONTACTS = 6,
    LINKS = 2,
    INPUTS = 3,
    CHANNELS = 8,
    POINTS = 10,
    RECORDS = 18,
    TONES = 4,
    ALIKE = 40,
    NAME = 64,
    PATH = 1000
};

/* ---- random.c ---- */

typedef struct chance {
    unsigned long long s[4];
} chance;
void chance_seed(chance *c, unsigned long long seed);
double chance_uniform(chance *c, double lo, double hi);
double chance_normal(chance *c);
/** Uniform in the logarithm. */
double chance_log(chance *c, double lo, double hi);
/** 0 .. n - 1 */
int chance_pick(chance *c, int n);
/** 1 with probability p. */
int chance_coin(chance *c, double p);

/* ---- mech.c: a mechanism ---- */

/** One number. An index of -1 stands for a 0 that is no number of the file. */
typedef struct number {
    char name[NAME];   /* path in the file, "rod.mass" */
    const char *unit;  /* SI */
    const char *shown; /* unit in the file */
    double scale;      /* SI value of that unit */
    double value;      /* true [SI] */
    double file;       /* value in the file [SI] */
    double sd;         /* standard deviation of the file's value about the true one; 0: exact */
    int stated;        /* 1: written into the file */
    int tolerance;     /* 1: its standard deviation is written as well */
} number;

/** Offsets of a joint's law from body.law. */
enum {
    J_K,
    J_Q0,
    J_K3,
    J_B,
    J_ASYMMETRY,
    J_DRAG,
    J_PRELOAD,
    J_T,
    J_W,
    J_T_ASYMMETRY,
    J_STOP,
    J_GAP,
    J_A,
    J_VT,
    J_B1,
    J_B2,
    J_BUMP,
    J_BUMP_AT,
    J_BUMP_WIDTH, /* in no table: torque bump over the position */
    J_COG,
    J_COG_WAVE, /* in no table: ripple T sin(q/wave) */
    J_ROOT,
    J_ROOT_W, /* in no table: friction that grows with the root of speed */
    J_SIZE
};
/** Offsets of a contact's law from contact.law. */
enum { N_A, N_B, N_C, N_D, N_P, N_H, N_F0, N_GAP, N_F, N_RANGE, N_MU, N_VT, N_B1, N_B2, N_SIZE };
/** Of a link's. */
enum { L_K, L_LENGTH, L_B, L_SLACK, L_SIZE };
/** Of an instrument, and of an input. */
enum { S_GAIN, S_OFFSET, S_SQUARE, S_TILT, S_DELAY, S_SIZE };
enum { I_GAIN, I_DELAY, I_SIZE };

typedef struct body {
    char name[NAME];
    int parent; /* -1: frame */
    char type;  /* 'R' turns, 'T' slides */
    int axis;   /* 0, 1, 2 */
    int sign;
    int at[3], mass, centre[3], inertia[3], law;
} body;
typedef struct point {
    char name[NAME];
    int body, at[3];
} point;
/** A circle (a point: radius -1) against a line, or against a second circle. */
typedef struct contact {
    char name[NAME];
    int point[2];  /* of the circles; [1] = -1: a line */
    int radius[2]; /* numbers, -1: none */
    int line_body, line_at[2], facing;
    int law;
} contact;
typedef struct link {
    char name[NAME];
    int point[2], law;
} link;
/** A sum of tones; of a torque also a push that begins and ends smoothly. */
typedef struct signal {
    int n;
    double level, amplitude[TONES], rate[TONES], phase[TONES]; /* [SI, rad/s, rad] */
    double from, to, push; /* a raised cosine between two times [s], its height */
    int grid;              /* 1: straight lines between samples `interval` apart */
    double interval;
    double noise; /* of the samples of a grid, a draw of seed `draw` */
    unsigned long long draw;
} signal;
enum { INPUT_TORQUE, INPUT_MOTION, INPUT_FORCE };
typedef struct input {
    char name[NAME];
    int kind, body, point; /* a force acts along z at the point */
    int law;
    const char *unit;
} input;
enum { READ_POSITION, READ_SPEED, READ_X, READ_Z, READ_GAP, READ_EFFORT };
typedef struct channel {
    char name[NAME];
    int read, index; /* body, point, contact or input */
    int law;
    const char *unit;
} channel;

typedef struct mech {
    char name[NAME];
    const char *about;
    double gravity[3];
    int nbody, npoint, ncontact, nlink, ninput, nchannel, nnumber, clock;
    body body[BODIES];
    point point[POINTS];
    contact contact[CONTACTS];
    link link[LINKS];
    input input[INPUTS];
    channel channel[CHANNELS];
    number number[NUMBERS];
    int order[BODIES]; /* a body comes after its parent */
    int settle;
    double dt; /* step that the file names [s] */
    /* how it is set going, for the catalogue's records */
    double swing[BODIES], mean[BODIES]; /* range of the initial positions about their mean */
    double kick[BODIES];                /* range of the initial speeds */
    double duration[2];                 /* of a record [s] */
    double drive[INPUTS];               /* amplitude of the inputs */
    double drive_rate[2];               /* of their tones [Hz] */
    int pushes;                         /* 1: an input is one push, not tones */
} mech;

void mech_start(mech *m, const char *name, const char *about);
/** A joint and the body on it. Neutral laws are added. @return body */
int mech_body(mech *m, const char *name, int parent, char type, int axis, int sign);
/** A number of the file. sd is relative. @return its index */
int mech_number(mech *m, const char *owner, const char *what, const char *unit, const char *shown,
                double scale, double value, double sd);
int mech_length(mech *m, const char *owner, const char *what, double value);
void mech_mass(mech *m, int i, double mass, double x, double z);
void mech_inertia(mech *m, int i, double xx, double yy, double zz);
/** Place of the joint in the parent's axes. */
void mech_at(mech *m, int i, double x, double z);
int mech_point(mech *m, const char *name, int on, double x, double z);
/** State a number that is there at its neutral value. */
void mech_state(mech *m, int index, double value, double sd);
int mech_contact(mech *m, const char *name, int a, int b, double radius_a, double radius_b);
void mech_line(mech *m, int i, int on, double x, double z, double degrees);
int mech_link(mech *m, const char *name, int a, int b, double k, double length);
int mech_input(mech *m, const char *name, int type, int index);
int mech_channel(mech *m, const char *name, int read, int index);
/** Index of a number by its name, -1. */
int mech_find(const mech *m, const char *name);

/* ---- motion.c, touch.c: what a state does ---- */

typedef struct pose {
    double R[9], o[3], w[3], v[3], alpha[3], a[3]; /* last two: accelerations with qdd = 0 */
} pose;
/** A mechanism with one set of numbers, and what drives it. */
typedef struct play {
    const mech *m;
    const double *p;
    const signal *drive; /* [ninput], NULL: none */
    double calm;         /* damping rate while it settles [1/s] */
    pose pose[BODIES];
    double axis[BODIES][3];
    double M[BODIES * BODIES], h[BODIES], Q[BODIES];
    double effort[BODIES]; /* of a prescribed joint, after motion_rates */
} play;
/** qdd from q, qd at t; prescribed joints have q and qd replaced. @return 0, -1: singular */
int motion_rates(play *s, double t, double *q, double *qd, double *qdd);
void motion_poses(play *s, const double *q, const double *qd);
void motion_point(const play *s, int b, const double r[3], double x[3], double v[3]);
void motion_force(play *s, int b, const double x[3], const double f[3]);
void motion_place(const play *s, const int at[3], double r[3]);
double signal_value(const signal *s, double t);
/** Contacts and links into Q. */
void touch_all(play *s);
double touch_gap(play *s, int i);
double law_joint(const double *law, double q, double qd);
double law_normal(const double *law, double x, double xdot);
double law_friction(double A, double vt, double B1, double B2, double v);

/* ---- run.c: motion in time ---- */

typedef struct state {
    double t, q[BODIES], qd[BODIES], h;
} state;
/** Integrate to `until`. @return 0, -1: no step is small enough, or it is not finite */
int run_to(play *s, state *x, double until, double tolerance);
/** Let it come to rest. */
int run_settle(play *s, state *x);

/* ---- design.c, record.c: records ---- */

/** One record: how it is made, what is not told about it. */
typedef struct setup {
    double q[BODIES], qd[BODIES]; /* at the release */
    double said[BODIES];          /* initial position as told, NAN: not told */
    double before;                /* time from the release to the first sample [s] */
    double joint_scatter[BODIES], contact_scatter[CONTACTS]; /* factors of friction */
    int n;                                                   /* samples */
    signal drive[INPUTS];
} setup;
typedef struct sensor {
    double noise, step, sd; /* of the tracking, quantisation, both together [SI] */
} sensor;
typedef struct design {
    int nfit, nheld, tolerances, noise_told, moving, told, one_long;
    double rate, joint_sd, contact_sd, drift;
    sensor sensor[CHANNELS], input[INPUTS];
    setup record[RECORDS];
} design;
/** Samples of a record without noise, y [n * nchannel].
 *  @param p  numbers, true or changed @return 0, -1 */
int record_film(const mech *m, const double *p, const design *d, const setup *s, int stride,
                double tolerance, double *y);
double record_noisy(const sensor *s, double y, chance *c);

/** @param quiet  1: exact instruments, no scatter, a correct file */
void design_draw(design *d, mech *m, chance *c, int quiet);

/* ---- catalog.c ---- */

typedef struct entry {
    const char *name;
    void (*build)(mech *m, chance *c);
} entry;
extern const entry catalog[];
int catalog_count(void);

/* ---- effect.c ---- */

typedef struct kind {
    const char *name, *cls, *size;
    char site; /* 'j' joint, 'b' body, 'c' contact, 's' channel, 'i' input, 't' clock, 'p' number,
                  'l' link, 'x' a body more */
    int offset, side; /* in the law */
    int both;         /* of either sign */
    int outside;      /* in no table */
} kind;
typedef struct effect {
    const kind *kind; /* NULL: nothing */
    int index;        /* joint, body, contact ...; the number of 'b' and 'p' */
    double size, side, width, limit;
    char place[NAME];
    const char *unit;
} effect;
/** Typical sizes of a motion, from its records. */
typedef struct extent {
    double q[BODIES], mid[BODIES], qd[BODIES],
        torque[BODIES]; /* half range, middle, RMS, mean size */
    double y[CHANNELS], depth[CONTACTS];
} extent;
extern const kind kinds[];
/** All that can be hidden in a mechanism. @return how many */
int effect_list(const mech *m, const extent *x, effect *out, int most, int outside);
/** Draw what is beside the size, and the sign. */
void effect_sides(effect *e, const mech *m, const extent *x, chance *c);
/** The numbers with so much of an effect in them. */
void effect_apply(const effect *e, const mech *m, double size, double *p);

/* ---- structure.c ---- */

enum { STRUCTURE_HINGE, STRUCTURE_AXIS, STRUCTURE_PARTNER };
/** Can a body (of a partner: a contact) have it? */
int structure_can(const mech *m, int which, int place);
/** The mechanism with so much of any effect in it, and its numbers q [NUMBERS].
 *  @param room  where it is put when it has a body more  @return m or room */
const mech *structure_with(mech *room, const mech *m, const effect *e, double size, const double *p,
                           double *q);

/* ---- size.c ---- */

int size_extent(const mech *m, const double *p, const design *d, extent *x);
/** What everything else can do to the records of a design. */
typedef struct sizer sizer;
/** @param p  numbers to begin with; must outlive it  @return NULL: a record cannot be filmed */
sizer *size_begin(const mech *m, const double *p, const design *d);
void size_drop(sizer *z);
/** RMS, in noises, of what is left of the change to other numbers, of a mechanism with the same
 *  channels. @return NAN: it cannot be filmed */
double size_of(sizer *z, const mech *m, const double *p);
/** The size at which an effect leaves `target` noises. @return 1: reached, 0: not within its limit
 */
int size_find(sizer *z, effect *e, double target, double *reached);
/** Which effects of a list would do the same to these records, to first order: with the best size
 * of theirs less than 3 standard deviations are left. They come first in the list. @return how many
 */
int size_alike(sizer *z, const effect *e, effect *list, int n);

/** RMS, in noises, of the change to other numbers [NUMBERS], nothing refitted. @return NAN: it
 *  cannot be filmed */
double size_change(sizer *z, const double *p);

/* ---- mistake.c ---- */

/** One number of the file, far off. @param e  out: what would put the file right, its size beyond
 *  the file's number  @param reached  noises  @return 0: none shows */
int mistake_draw(mech *told, const double *p, sizer *z, const extent *x, effect *e, double *reached,
                 chance *c);

/* ---- wrong.c ---- */

/** Make a set wrong: changes the file's mechanism or how records are written. */
typedef struct wrong {
    char name[NAME], place[NAME];
    double unit[CHANNELS], time; /* factors of the columns */
    int swap[2];                 /* columns, -1 */
    int other;                   /* 1: the records belong to another mechanism */
} wrong;
void wrong_none(wrong *w);
/** @param told  the mechanism that the file describes; changed by some @return 1: wrong enough */
int wrong_draw(wrong *w, mech *told, const mech *m, const double *p, const design *d, chance *c);

/** Could records of m be taken for records of `told`? */
int wrong_fits(const mech *m, const mech *told);

/* ---- compare.c ---- */

/** Print how far the columns of two tables are apart.
 *  @param skip  rows at both ends that do not count  @return 0, -1 */
int compare_files(const char *first, const char *second, int skip);

/* ---- write.c ---- */

typedef struct answer {
    unsigned long seed;
    const char *level;
    double target, reached;
    int met;
    const mech *m, *told;
    const design *d;
    const double *p;
    effect e[2], alike[ALIKE];
    int nalike;
    wrong w;
    extent x;
} answer;
int write_model(const char *folder, const mech *told, const design *d, int exact);
int write_record(const char *path, const mech *m, const mech *told, const double *p,
                 const design *d, const setup *s, const wrong *w, chance *c, int exact);
int write_answer(const char *path, const answer *a);

#endif
