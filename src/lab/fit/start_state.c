/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_state.c - the state that the channels of a record show at its start.
 *
 * What the channels show (start_kinematics.c) is completed by priors: the state in which the stroke
 * would begin otherwise (initial values of the file, equilibrium). Their width is the file's
 * tolerance, or so large that they decide only about combinations of joints that no channel shows.
 *
 * A point's coordinate may be reached in several states (elbow up or down). All minima that are as
 * good as the best are simulated for the length of the start window, and the one that follows the
 * record is taken.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "start_state.h"

enum { PLACES = 24, BRANCHES = 8 };
static const double pi = 3.14159265358979323846;
static const double wide_angle = 1.0;  /* prior sd of a turning joint that nothing shows [rad] */
static const double least_rate = 10.0; /* prior sd of a speed over that of its position [1/s] */
static const double as_good = 9.0;     /* objective of a minimum above the best one's */

/* ---- channels ---- */

/* samples of a channel from the start on, without the missing ones. @return their number */
static int samples_of(const fit__stroke *s, int c, double *t, double *y)
{
    int n = 0;
    for (int k = 0; k < s->n; k++) {
        int i = s->waits ? s->n - 1 - k : k;
        if (isfinite(s->y[c * s->n + i]) && !(s->waits && s->data->time[i] > 0.0)) {
            t[n] = s->data->time[i];
            y[n++] = s->y[c * s->n + i];
        }
    }
    return n;
}

static stein_status read_starts(fit__beginning *w, stein_err *err)
{
    const fit__stroke *s = w->s;
    double *t = malloc(sizeof *t * (2 * (size_t)s->n + 1)), *y = t + (t != NULL ? s->n : 0);
    if (t == NULL) {
        return lab__no_memory(err);
    }
    for (int c = 0; c < s->nch; c++) {
        const stein_channel *ch = fit__channel_of(w, c);
        w->start[c].samples = 0;
        w->e->shown[c] = NAN;
        if (!fit__shows_place(ch) && !fit__shows_speed(ch)) {
            continue;
        }
        int n = samples_of(s, c, t, y);
        double late = s->delay[c] >= 0 ? w->b->p[s->delay[c]] : 0.0;
        if (!fit__start_of(t, y, n, s->noise[c], s->origin + late, &w->start[c])) {
            w->start[c].samples = 0;
            continue;
        }
        w->e->length = fmax(w->e->length, w->start[c].length);
        w->e->shown[c] = w->start[c].value;
    }
    free(t);
    return STEIN_OK;
}

/* ---- priors ---- */

/* largest length among the numbers of the mechanism [m] */
static double size_of(const stein_model *m, const double *p)
{
    double size = 0.0;
    for (int i = 0; i < m->np; i++) {
        size = strcmp(m->params[i].unit, "m") == 0 ? fmax(size, fabs(p[i])) : size;
    }
    return size > 0.0 ? size : 0.1;
}

/* Rate at which the channels move: half swings from the first to the last crossing of the middle,
 * with a dead band of a quarter of their range. A swing that decays stays within the band from some
 * time on, and goes on at the same rate. Fewer than four crossings are no swing: half swings in the
 * whole record then. [rad/s] */
static double rate_of(const fit__beginning *w)
{
    const fit__stroke *s = w->s;
    double rate = 0.0, length = s->data->time[s->n - 1] - s->data->time[0];
    for (int c = 0; c < s->nch; c++) {
        const double *y = s->y + c * s->n;
        double lo = INFINITY, hi = -INFINITY;
        int side = 0, crossings = 0;
        double first = 0.0, last = 0.0;
        for (int i = 0; i < s->n; i++) {
            lo = isfinite(y[i]) ? fmin(lo, y[i]) : lo;
            hi = isfinite(y[i]) ? fmax(hi, y[i]) : hi;
        }
        for (int i = 0; w->start[c].samples > 0 && i < s->n; i++) {
            double u = isfinite(y[i]) && hi > lo ? (y[i] - 0.5 * (lo + hi)) / (hi - lo) : 0.0;
            int now = u > 0.25 ? 1 : u < -0.25 ? -1 : 0;
            if (now != 0 && side != 0 && now != side) {
                double at = s->data->time[i] - s->data->time[0];
                first = crossings == 0 ? at : first;
                last = at;
                crossings++;
            }
            side = now != 0 ? now : side;
        }
        rate = fmax(rate, crossings > 3 ? pi * (crossings - 1) / (last - first)
                                        : pi * crossings / length);
    }
    return rate;
}

static double tolerance_of(const stein_model *m, int joint, const char *what)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.initial.%s", m->bodies[joint].name, what);
    int i = stein_find_param(m, name);
    return i >= 0 ? m->params[i].tolerance : 0.0;
}

static void take_priors(fit__beginning *w)
{
    const stein_model *m = lab_equations(w->p->model);
    w->e->rate = rate_of(w);
    double rate = fmax(least_rate, w->e->rate), size = size_of(m, w->b->p);
    for (int k = 0; k < w->nfree; k++) {
        int j = w->joint[k];
        double q = tolerance_of(m, j, "position"), qd = tolerance_of(m, j, "speed");
        double wide = m->bodies[j].type == 'R' ? wide_angle : size;
        w->e->q_prior[j] = q > 0.0 ? q : wide;
        w->e->qd_prior[j] = qd > 0.0 ? qd : wide * rate;
    }
}

/* ---- one state out of several ---- */

/* all channels of places read positions of joints or sums of them: there is one minimum */
static int is_linear(const fit__beginning *w)
{
    for (int c = 0; c < w->s->nch; c++) {
        int read = (int)fit__channel_of(w, c)->read;
        if (fit__measures_place(w, c) && read != STEIN_READ_POSITION && read != STEIN_READ_ANGLE) {
            return 0;
        }
    }
    return 1;
}

/* another place to begin at: turning joints anywhere, sliding ones within their prior */
static void place(fit__beginning *w, int i)
{
    const stein_model *m = lab_equations(w->p->model);
    memcpy(w->q, w->q0, sizeof *w->q * (size_t)w->nq);
    for (int k = 0; i > 0 && k < w->nfree; k++) {
        // multiples of square roots of primes, modulo 1: as even as a quasi-random sequence
        static const double root[] = {0.414213562, 0.732050808, 0.236067977,
                                      0.645751311, 0.316624790, 0.605551275};
        int around = 1 + k / 6;
        double u = fmod(i * root[k % 6] * around, 1.0) - 0.5;
        int j = w->joint[k];
        w->q[j] += m->bodies[j].type == 'R' ? 2.0 * pi * u : 2.0 * w->e->q_prior[j] * u;
    }
}

/* x of the stroke's initial state at q, qd */
static void begin_at(const fit__beginning *w, const double *q, const double *qd, double *x)
{
    for (int k = w->s->first; k < w->s->first + w->s->own; k++) {
        const fit__unknown *u = &w->p->unknown[k];
        if (fit__is_initial(u)) {
            int j = u->index;
            double z = u->kind == FIT__POSITION ? q[j] - w->q0[j] : qd[j] - w->qd0[j];
            x[k] = (z - u->start) / u->sd;
        }
    }
}

/* sum of squares over the start window of a stroke that begins at q, qd, per sample */
static double follow(fit__beginning *w, const double *q, const double *qd)
{
    memset(w->b->x, 0, sizeof *w->b->x * (size_t)w->p->nu);
    begin_at(w, q, qd, w->b->x);
    return fit__misfit(w->p, w->b, (int)(w->s - w->p->stroke), w->b->x, w->e->length);
}

typedef struct branch {
    double *q, *qd, objective;
} branch;

/* minima that differ, kept in order of the starts. @return their number */
static int find_branches(fit__beginning *w, branch *list)
{
    const size_t size = sizeof *w->q * (size_t)w->nq;
    int n = 0, places = is_linear(w) ? 1 : PLACES;
    for (int i = 0; i < places && n < BRANCHES; i++) {
        place(w, i);
        double here = fit__find_positions(w);
        int same = !isfinite(here);
        for (int k = 0; k < n && !same; k++) {
            double apart = 0.0;
            for (int j = 0; j < w->nq; j++) {
                double d = w->q[j] - list[k].q[j];
                d = lab_equations(w->p->model)->bodies[j].type == 'R'
                        ? d - 2.0 * pi * round(d / (2.0 * pi))
                        : d;
                apart = fmax(apart, fabs(d));
            }
            if (apart < 1e-3) {
                same = 1;
                if (here < list[k].objective) { // the same place, without whole turns
                    memcpy(list[k].q, w->q, size);
                    list[k].objective = here;
                }
            }
        }
        if (!same) {
            memcpy(list[n].q, w->q, size);
            list[n++].objective = here;
        }
    }
    return n;
}

/* the best minimum goes to w->q; among those that are as good, the one that follows the record */
static int choose_branch(fit__beginning *w, branch *list, int n)
{
    const size_t size = sizeof *w->q * (size_t)w->nq;
    double best = INFINITY, nearest = INFINITY;
    int chosen = -1, rivals = 0;
    for (int k = 0; k < n; k++) {
        best = fmin(best, list[k].objective);
    }
    for (int k = 0; k < n; k++) {
        rivals += list[k].objective <= best + as_good;
    }
    for (int k = 0; k < n; k++) {
        if (list[k].objective > best + as_good) {
            continue;
        }
        double misfit = list[k].objective;
        if (rivals > 1) {
            memcpy(w->q, list[k].q, size);
            if (fit__find_speeds(w, NULL) != 0) {
                continue;
            }
            memcpy(list[k].qd, w->qd, size);
            misfit = follow(w, list[k].q, list[k].qd);
        }
        if (chosen < 0 || misfit < nearest) {
            nearest = misfit;
            chosen = k;
        }
    }
    if (chosen >= 0) {
        memcpy(w->q, list[chosen].q, size);
    }
    return chosen;
}

static int find_state(fit__beginning *w)
{
    branch list[BRANCHES];
    size_t nq = (size_t)w->nq;
    double *room = malloc(sizeof *room * (2 * BRANCHES * nq + 1));
    if (room == NULL) {
        w->b->no_memory = 1;
        return -1;
    }
    for (size_t k = 0; k < BRANCHES; k++) {
        list[k] = (branch){room + 2 * k * nq, room + (2 * k + 1) * nq, INFINITY};
    }
    int chosen = choose_branch(w, list, find_branches(w, list));
    free(room);
    if (chosen < 0 || fit__position_sd(w, w->e->q_sd) != 0 ||
        fit__find_speeds(w, w->e->qd_sd) != 0) {
        return -1;
    }
    for (int j = 0; j < w->nq; j++) {
        w->e->q[j] = w->q[j] - w->q0[j];
        w->e->qd[j] = w->qd[j] - w->qd0[j];
    }
    return 0;
}

/* ---- strokes ---- */

static void note_unknowns(fit__beginning *w)
{
    const fit__stroke *s = w->s;
    for (int c = 0; c < s->nch; c++) {
        w->offset[c] = 0.0;
    }
    for (int k = s->first; k < s->first + s->own; k++) {
        const fit__unknown *u = &w->p->unknown[k];
        if (u->kind == FIT__POSITION) {
            w->joint[w->nfree++] = u->index;
        } else if (u->kind == FIT__OFFSET) {
            w->offset[u->index] = u->sd;
        }
    }
}

static int make_work(fit__beginning *w, const fit__problem *p, fit__bench *b, int stroke,
                     fit__estimate *e)
{
    size_t nq = (size_t)lab_equations(p->model)->nq, nch = (size_t)p->stroke[stroke].nch;
    *w = (fit__beginning){.p = p, .b = b, .s = &p->stroke[stroke], .nq = (int)nq, .e = e};
    w->q0 = calloc(6 * nq + nch * nq + nq * nq + 2 * nch + 1, sizeof *w->q0);
    w->joint = calloc(nq + 1, sizeof *w->joint);
    w->start = calloc(nch + 1, sizeof *w->start);
    if (w->q0 == NULL || w->joint == NULL || w->start == NULL) {
        return -1;
    }
    w->qd0 = w->q0 + nq;
    w->q = w->qd0 + nq;
    w->qd = w->q + nq;
    w->to = w->qd + nq;
    w->grad = w->to + nq;
    w->H = w->grad + nq;
    w->A = w->H + nch * nq;
    w->base = w->A + nq * nq;
    w->offset = w->base + nch;
    return 0;
}

static void free_work(fit__beginning *w)
{
    free(w->q0);
    free(w->joint);
    free(w->start);
}

/* @return 1 when there is an estimate. The estimate counts from the reset state
 */
int fit__estimate_state(const fit__problem *p, fit__bench *b, int stroke, fit__estimate *e)
{
    fit__beginning w;
    int found = 0;
    if (make_work(&w, p, b, stroke, e) != 0) {
        b->no_memory = 1;
        free_work(&w);
        return 0;
    }
    memset(b->x, 0, sizeof *b->x * (size_t)p->nu);
    note_unknowns(&w);
    begin_at(&w, w.q0, w.qd0, b->x); // the reset state
    int any = w.nfree > 0 && !w.s->data->planned;
    stein_status status = any ? fit__begin(p, b, stroke, b->x, b->y, NULL) : STEIN_EINVAL;
    if (status == STEIN_OK) {
        memcpy(w.q0, b->q, sizeof *w.q0 * (size_t)w.nq);
        memcpy(w.qd0, b->qd, sizeof *w.qd0 * (size_t)w.nq);
        status = read_starts(&w, NULL);
    }
    if (status == STEIN_OK) {
        take_priors(&w);
        found = e->length > 0.0 && find_state(&w) == 0;
    }
    b->no_memory |= status == STEIN_ENOMEM;
    free_work(&w);
    return found;
}
