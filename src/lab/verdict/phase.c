/* SPDX-License-Identifier: GPL-3.0-or-later
 * phase.c - the phase of a stroke at every frame, read off the simulation.
 *
 *      rest         nothing has moved yet, or everything has stopped
 *      drive i      the key moves, from the first motion on; the beak's end is on the roof
 *      drive ii     the beak's face is on the roof              (phases 1-3 of the notch; between
 *      drive iii    the beak's face is on the corner             contacts the last one holds)
 *      free flight  the beak has escaped, the head approaches the string
 *      string       the head touches the string
 *      fall         the head goes away from the string
 *      re-arm       the beak is back at the pawl: on its face, or below the roof again
 *
 * A measured channel does not distinguish a beak on the roof from a beak on the corner. The model
 * at its best parameters does, to the accuracy of its fit, also where no channel shows the hammer.
 * Where the model is wrong, the limits of the phases are wrong by as much, a fraction of a ms.
 *
 * Mechanisms that name no stroke are at "rest" or in "motion": a joint faster than a thousandth of
 * its largest speed moves.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosing.h"

enum { REST, DRIVE, FLIGHT = 4, STRING, FALL, REARM, MOTION };
static const double still = 1e-3;    /* of the largest speed of a joint */
static const double receding = 1e-7; /* [m] from frame to frame */

const char *const diag__phase[DIAG_PHASES] = {"rest",      "drive i",     "drive ii",
                                              "drive iii", "free flight", "string",
                                              "fall",      "re-arm",      "motion"};

int diag__phase_index(const char *name)
{
    for (int i = 0; name != NULL && i < DIAG_PHASES; i++) {
        if (strcmp(name, diag__phase[i]) == 0) {
            return i;
        }
    }
    return -1;
}

size_t diag__frame(const fit__problem *p, int stroke)
{
    size_t at = 0;
    for (int s = 0; s < stroke; s++) {
        at += (size_t)p->stroke[s].n;
    }
    return at;
}

/* what a frame shows */
typedef struct frame {
    double T, gap;
    int notch, armed, touching;
} frame;

typedef struct view {
    int nq, notch, gap, force; /* channels of the string; -1: none */
    int n;                     /* frames read */
    frame *frame;
    double *speed; /* [n*nq] */
} view;

static void look(void *ctx, stein_sim *sim, int i)
{
    view *v = ctx;
    const stein_model *m = stein_sim_model(sim);
    const double *qd = stein_qd(sim);
    frame *f = &v->frame[i];
    *f = (frame){.T = stein_time(sim), .notch = stein_notch_phase(sim, v->notch)};
    f->armed = v->notch >= 0 && stein_notch_armed(sim, v->notch);
    f->gap = v->gap >= 0 ? m->channels[v->gap].sign * stein_read(sim, v->gap) : NAN;
    double force = v->force >= 0 ? m->channels[v->force].sign * stein_read(sim, v->force) : NAN;
    f->touching = isnan(force) ? f->gap <= 0.0 : force > 0.0;
    for (int j = 0; j < v->nq; j++) {
        v->speed[i * v->nq + j] = fabs(qd[j]);
    }
    v->n = i + 1;
}

static int is_fast(const view *v, const double *most, int i)
{
    for (int j = 0; j < v->nq; j++) {
        if (v->speed[i * v->nq + j] > still * most[j]) {
            return v->frame[i].T > 0.0;
        }
    }
    return 0;
}

/* does anything move in this frame? A turn is no rest: the frames beside it move. */
static int moves(const view *v, const double *most, int i)
{
    int turn = i > 0 && i + 1 < v->n && is_fast(v, most, i - 1) && is_fast(v, most, i + 1);
    return turn || is_fast(v, most, i);
}

static int next_phase(const view *v, int now, int i)
{
    const frame *f = &v->frame[i];
    int away = i > 0 && f->gap > v->frame[i - 1].gap + receding;
    int driven = v->notch >= 0 && f->notch >= 1 && f->notch <= 3 && f->armed;
    if (f->touching) {
        return STRING;
    }
    switch (now) {
    case REST: return driven ? DRIVE + f->notch - 1 : v->notch >= 0 ? DRIVE : FLIGHT;
    case STRING: return driven ? DRIVE + f->notch - 1 : FALL; // driven: a forced escapement
    case FLIGHT: return away ? FALL : FLIGHT;
    case FALL: return v->notch >= 0 && (f->notch > 0 || f->armed) ? REARM : FALL;
    case REARM: return REARM;
    default: break;
    }
    // driven so far
    return driven ? DRIVE + f->notch - 1 : f->armed ? now : FLIGHT;
}

static void name_phases(const view *v, int stroke, double *most, const char **phase, int n)
{
    int now = REST;
    for (int i = 0; i < v->n; i++) {
        for (int j = 0; j < v->nq; j++) {
            most[j] = fmax(most[j], v->speed[i * v->nq + j]);
        }
    }
    for (int i = 0; i < n; i++) {
        int moving = i < v->n && moves(v, most, i);
        int quiet = now == REST || i >= v->n;
        for (int k = i; moving == 0 && !quiet && k < v->n; k++) {
            moving = moves(v, most, k); // a stop that is no end is no rest
        }
        if (!stroke || i >= v->n) {
            phase[i] = diag__phase[i < v->n && !moves(v, most, i) ? REST : MOTION];
        } else {
            now = moving ? next_phase(v, now, i) : now;
            phase[i] = diag__phase[moving ? now : REST];
        }
    }
}

/* ---- all strokes ---- */

typedef struct job {
    const fit__problem *p;
    const double *x;
    const char **phase;
    double *time;
    int *failed;
} job;

static void one_stroke(void *ctx, fit__bench *b, int stroke)
{
    job *j = ctx;
    const fit__problem *p = j->p;
    const fit__stroke *s = &p->stroke[stroke];
    const stein_model *m = lab_equations(p->model);
    size_t n = (size_t)s->n, nq = (size_t)m->nq, row = diag__frame(p, stroke);
    int string = m->stroke.string;
    view v = {.nq = m->nq, .notch = string >= 0 ? m->stroke.notch : -1};
    v.gap = string >= 0 ? lab__channel_of(m, STEIN_READ_GAP, string) : -1;
    v.force = string >= 0 ? lab__channel_of(m, STEIN_READ_FORCE, string) : -1;
    v.frame = calloc(n + 1, sizeof *v.frame);
    v.speed = calloc((n + 1) * nq + 1, sizeof *v.speed);
    double *y = malloc(sizeof *y * (n * (size_t)s->nch + nq + 1));
    j->failed[stroke] = v.frame == NULL || v.speed == NULL || y == NULL;
    if (!j->failed[stroke]) {
        double *most = y + n * (size_t)s->nch;
        memset(most, 0, sizeof *most * nq);
        b->watch = look;
        b->watch_ctx = &v;
        fit__simulate(p, b, stroke, j->x, y, NULL); // as far as it goes
        b->watch = NULL;
        name_phases(&v, string >= 0 && v.gap >= 0, most, j->phase + row, s->n);
        for (int i = 0; j->time != NULL && i < s->n; i++) {
            double T = s->nsampled == 0 ? s->data->time[i] - s->origin : INFINITY;
            j->time[row + (size_t)i] = i < v.n ? v.frame[i].T : T;
        }
    }
    free(v.frame);
    free(v.speed);
    free(y);
}

stein_status diag__phases(const fit__problem *p, const double *x, const char **phase, double *time,
                          stein_err *err)
{
    job j = {p, x, phase, time, calloc((size_t)p->nstroke + 1, sizeof *j.failed)};
    if (j.failed == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = fit__parallel(p, p->nstroke, one_stroke, &j, err);
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        status = j.failed[s] ? lab__no_memory(err) : status;
    }
    free(j.failed);
    return status;
}
