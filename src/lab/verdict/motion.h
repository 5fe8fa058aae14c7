/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion.h - what the files of the motion-driven check share.
 *
 *   motion_check.c   is it possible, the runs, their result
 *   motion_run.c     a stroke under its measured motion
 *   motion_judge.c   errors in blocks, in units of their uncertainty
 *   motion_show.c    diagnosis.json, report.html
 * Included by: this folder, src/lab/diagnosis, src/lab/report.
 */
#ifndef MOTION_H
#define MOTION_H

#include "verdict.h"

/** A model with its unknowns for some strokes. */
typedef struct diag__side {
    const fit__problem *p;
    const double *x, *r; /* r: weighted residuals at x, driven as the strokes were */
} diag__side;

/* ---- verify.c ---- */

/** o->verified: extended.yaml, read again, against what the verdict's fit leaves in the same
 *  records. @param side  [nside] fitted records, reporting ones  @return OK, ENOMEM, why the file
 *  cannot be read or simulated */
stein_status diag__verify(const diag__problem *q, const diag__side *side, int nside,
                          lab_diagnosis *o, stein_err *err);

/** How the motion of a joint is known; indices of one model. */
typedef struct diag__way {
    int input, joint, force; /* motion input, its joint, channel of the force that it needs */
    int channel;             /* that shows the motion; -1: recorded as input */
    int slot;                /* of that channel in the strokes, or of the force */
} diag__way;

/** A stroke under a motion. */
typedef struct diag__course {
    int ended;
    double *time;    /* [n] of the simulation [s]; not after 0: nothing moves yet */
    double *error;   /* [n] force needed less force that is there; NAN: unknown */
    double *present; /* [n] the latter; NULL: not needed */
    double *y;       /* [nch*n] free channels: measured less simulated; NAN: none */
} diag__course;

/** The motion that is prescribed, and what is compared. */
typedef struct diag__told {
    const double *motion;  /* [n] of the channel, or of the knots of the recorded input [unit] */
    const double *y;       /* [nch*n] */
    double noise, decades; /* of the motion, and how it is smoothed (fit__signal_through) */
    const double *force_noise; /* [signals of the stroke] of recorded forces; NULL: as recorded */
    unsigned long seed;        /* of that noise */
} diag__told;

/* ---- motion_run.c ---- */

/** Is there a way, and which one? @param why  [size] out, when there is none  @return 1, 0 */
int diag__motion_way(const diag__side *side, diag__way *way, char *why, size_t size);
/** The same way in a model with parts. @return 1, 0 */
int diag__motion_same(const diag__way *way, const fit__problem *from, const fit__problem *to,
                      diag__way *same);
/** A problem whose strokes have room for a signal more; free(p->stroke[0].signal), free(p->stroke).
 *  @return OK, ENOMEM */
stein_status diag__motion_open(const fit__problem *p, fit__problem *with, stein_err *err);
/** @param b     a bench of `with`
 *  @param c     out; ended 0: it cannot be simulated */
void diag__motion_run(const diag__side *side, const fit__problem *with, const diag__way *way,
                      fit__bench *b, int stroke, const diag__told *told, diag__course *c);

/** lo .. hi wide enough for y [n] as well, gaps aside. */
void diag__motion_include(const double *y, int n, double *lo, double *hi);

/* ---- motion_judge.c ---- */

/** All runs of all strokes: run r of stroke s is course[r*nstroke + s]. */
enum { MOTION_BEFORE, MOTION_AFTER, MOTION_DRAWS };
/** Behind those three for each draw of noise: strokes made by the model before, run in it; made by
 *  the model after, run in that; and these in the model before. */
enum { MOTION_00, MOTION_11, MOTION_10, MOTION_KINDS };
typedef struct diag__runs {
    const fit__problem *p; /* of the side before */
    const diag__way *way;
    const char *const *phase;
    int draws, extended;
    double wide; /* factor on variances: what was fitted to few strokes is not known exactly */
    diag__course *course;
} diag__runs;
int diag__motion_run_of(int draw, int kind);
/** Rows, parts and the stroke that is shown. @return OK, ENOMEM */
stein_status diag__motion_judge(const diag__runs *runs, lab_motion *out, stein_err *err);

/* ---- motion_check.c ---- */

/** The check of some strokes.
 *  @param after  NULL: nothing was added
 *  @param phase  of all frames of the strokes
 *  @param nfit   strokes that both models were fitted to; 0: these ones
 *  @return OK (not done: out->why), ENOMEM */
stein_status diag__motion_check(const diag__side *before, const diag__side *after,
                                const char *const *phase, lab_verdict verdict, int nfit,
                                lab_motion *out, stein_err *err);
void diag__motion_free(lab_motion *m);

/* ---- motion_show.c ---- */

void diag__motion_json(lab__json *j, const lab_motion *m);

#endif
