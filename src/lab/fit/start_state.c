/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_state.c - the state that the channels of a record show at its start.
 *
 * Value y_c and slope of every channel at the first sample (start_window.c) are measurements of the
 * state through the channel's own kinematics h_c,
 *
 *      positions   y_c = h_c(q)                 Gauss-Newton, damped, from several q
 *      speeds      dy_c/dt = (dh_c/dq) qd       linear, at the q found
 *                  y_c = h_c(q, qd)             channels that read a speed
 *
 * each with its standard deviation, and priors on what they leave open: the state that the stroke
 * would begin in otherwise (initial values of the file, equilibrium), with the file's tolerance or
 * else so wide that it decides only about combinations of joints that no channel shows. Forces and
 * accelerations are not read: they depend on the laws that are to be found.
 *
 * A point's coordinate may be reached in several states (elbow up or down). All minima that are as
 * good as the best are simulated for the length of the start window, and the one that follows the
 * record is taken.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "start_state.h"

enum { PLACES = 24, ITERATIONS = 60, BRANCHES = 8 };
static const double pi = 3.14159265358979323846;
static const double nudge = 1e-6;      /* half-width of differences by q [rad or m] */
static const double wide_angle = 1.0;  /* prior sd of a turning joint that nothing shows [rad] */
static const double least_rate = 10.0; /* prior sd of a speed over that of its position [1/s] */
static const double as_good = 9.0;     /* objective of a minimum above the best one's */

/* room for one stroke at work */
typedef struct work {
    const fit__problem *p;
    fit__bench *b;
    const fit__stroke *s;
    int nq, nfree, *joint;      /* [nfree] joints that are estimated */
    double *q0, *qd0;           /* [nq] reset state */
    double *q, *qd, *to, *grad; /* [nq] */
    double *H, *A, *base;       /* [nch*nq], [nq*nq], [nch] */
    fit__start *start;          /* [nch]; samples 0: the channel says nothing */
    double *offset;             /* [nch] sd of its marker */
    fit__estimate *e;
} work;

static int shows_place(const stein_channel *c)
{
    return c->read == STEIN_READ_POSITION || c->read == STEIN_READ_X || c->read == STEIN_READ_Y ||
           c->read == STEIN_READ_Z || c->read == STEIN_READ_GAP;
}

static int shows_speed(const stein_channel *c)
{
    return c->read == STEIN_READ_SPEED || c->read == STEIN_READ_VX || c->read == STEIN_READ_VY ||
           c->read == STEIN_READ_VZ;
}

static const stein_channel *channel_of(const work *w, int c)
{
    return &lab_equations(w->p->model)->channels[w->s->channel[c]];
}

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

static stein_status read_starts(work *w, stein_err *err)
{
    const fit__stroke *s = w->s;
    double *t = malloc(sizeof *t * (2 * (size_t)s->n + 1)), *y = t + (t != NULL ? s->n : 0);
    if (t == NULL) {
        return lab__no_memory(err);
    }
    for (int c = 0; c < s->nch; c++) {
        const stein_channel *ch = channel_of(w, c);
        w->start[c].samples = 0;
        w->e->shown[c] = NAN;
        if (!shows_place(ch) && !shows_speed(ch)) {
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

/* rate at which the channels move: zero crossings about their mean, with a dead band of a quarter
 * of their range [rad/s] */
static double rate_of(const work *w)
{
    const fit__stroke *s = w->s;
    double rate = 0.0, length = s->data->time[s->n - 1] - s->data->time[0];
    for (int c = 0; c < s->nch; c++) {
        const double *y = s->y + c * s->n;
        double lo = INFINITY, hi = -INFINITY;
        int side = 0, crossings = 0;
        for (int i = 0; i < s->n; i++) {
            lo = isfinite(y[i]) ? fmin(lo, y[i]) : lo;
            hi = isfinite(y[i]) ? fmax(hi, y[i]) : hi;
        }
        for (int i = 0; w->start[c].samples > 0 && i < s->n; i++) {
            double u = isfinite(y[i]) && hi > lo ? (y[i] - 0.5 * (lo + hi)) / (hi - lo) : 0.0;
            int now = u > 0.25 ? 1 : u < -0.25 ? -1 : 0;
            crossings += now != 0 && side != 0 && now != side;
            side = now != 0 ? now : side;
        }
        rate = fmax(rate, pi * crossings / length);
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

static void take_priors(work *w)
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

/* ---- kinematics ---- */

static stein_status stand(work *w, const double *q, const double *qd, stein_err *err)
{
    return stein_set_state(w->b->sim, 0.0, q, qd, err);
}

static double shown(work *w, int c)
{
    return stein_read(w->b->sim, w->s->channel[c]) + w->b->shown[c];
}

/* does the value of a channel say where it is? One that counts from the initial state does not */
static int says_place(const work *w, int c)
{
    return w->start[c].samples > 0 && shows_place(channel_of(w, c)) && !channel_of(w, c)->from_rest;
}

static double value_sd(const work *w, int c)
{
    return fmax(hypot(w->start[c].value_sd, w->offset[c]), 1e-12);
}

/* H = dh/dq of the channels that show a place, at q */
static stein_status find_H(work *w, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int k = 0; k < w->nq && status == STEIN_OK; k++) {
        double q = w->q[k];
        for (int side = -1; side <= 1 && status == STEIN_OK; side += 2) {
            w->q[k] = q + side * nudge;
            status = stand(w, w->q, w->qd0, err);
            for (int c = 0; c < w->s->nch && status == STEIN_OK; c++) {
                double h = shows_place(channel_of(w, c)) ? shown(w, c) : 0.0;
                double *to = &w->H[c * w->nq + k];
                *to = side < 0 ? h : (h - *to) / (2.0 * nudge);
            }
        }
        w->q[k] = q;
    }
    return status;
}

/* sum of squares of the values and of the priors at q; INFINITY where it cannot be read */
static double objective(work *w, const double *q)
{
    double sum = 0.0;
    if (stand(w, q, w->qd0, NULL) != STEIN_OK) {
        return INFINITY;
    }
    for (int c = 0; c < w->s->nch; c++) {
        if (says_place(w, c)) {
            w->base[c] = w->start[c].value - shown(w, c);
            double r = w->base[c] / value_sd(w, c);
            sum += r * r;
        }
    }
    for (int k = 0; k < w->nfree; k++) {
        int j = w->joint[k];
        double r = (q[j] - w->q0[j]) / w->e->q_prior[j];
        sum += r * r;
    }
    return isfinite(sum) ? sum : (double)INFINITY;
}

/* normal equations of the positions: A, grad from the residuals in base */
static void fill_positions(work *w)
{
    int n = w->nfree;
    memset(w->A, 0, sizeof *w->A * (size_t)(n * n));
    memset(w->grad, 0, sizeof *w->grad * (size_t)n);
    for (int c = 0; c < w->s->nch; c++) {
        double sd = says_place(w, c) ? value_sd(w, c) : (double)INFINITY;
        for (int a = 0; a < n && isfinite(sd); a++) {
            double h = w->H[c * w->nq + w->joint[a]] / sd;
            w->grad[a] += h * w->base[c] / sd;
            for (int b = 0; b < n; b++) {
                w->A[a * n + b] += h * w->H[c * w->nq + w->joint[b]] / sd;
            }
        }
    }
    for (int a = 0; a < n; a++) {
        int j = w->joint[a];
        double weight = 1.0 / (w->e->q_prior[j] * w->e->q_prior[j]);
        w->A[a * n + a] += weight;
        w->grad[a] -= weight * (w->q[j] - w->q0[j]);
    }
}

/* solve A x = b in place, A becomes its Cholesky factor. @return 0, -1 */
static int solve(double *A, double *b, int n)
{
    gsl_matrix_view M = gsl_matrix_view_array(A, (size_t)n, (size_t)n);
    gsl_vector_view v = gsl_vector_view_array(b, (size_t)n);
    return gsl_linalg_cholesky_decomp1(&M.matrix) == 0 &&
                   gsl_linalg_cholesky_svx(&M.matrix, &v.vector) == 0
               ? 0
               : -1;
}

/* standard deviations of the estimated joints from the factor in A */
static void spread(work *w, double *sd)
{
    int n = w->nfree;
    for (int a = 0; a < n; a++) {
        memset(w->grad, 0, sizeof *w->grad * (size_t)n);
        w->grad[a] = 1.0;
        gsl_matrix_view M = gsl_matrix_view_array(w->A, (size_t)n, (size_t)n);
        gsl_vector_view v = gsl_vector_view_array(w->grad, (size_t)n);
        gsl_linalg_cholesky_svx(&M.matrix, &v.vector);
        sd[w->joint[a]] = sqrt(fmax(w->grad[a], 0.0));
    }
}

/* Levenberg-Marquardt from w->q. @return objective at the minimum, which is w->q */
static double descend(work *w)
{
    double here = objective(w, w->q), mu = 1e-3;
    int n = w->nfree;
    for (int i = 0; i < ITERATIONS && isfinite(here); i++) {
        if (find_H(w, NULL) != STEIN_OK) {
            return INFINITY;
        }
        double there = INFINITY, step = 0.0;
        while (mu < 1e12) {
            (void)objective(w, w->q); // the residuals
            fill_positions(w);
            for (int a = 0; a < n; a++) {
                w->A[a * n + a] *= 1.0 + mu;
            }
            if (solve(w->A, w->grad, n) == 0) {
                memcpy(w->to, w->q, sizeof *w->to * (size_t)w->nq);
                step = 0.0;
                for (int a = 0; a < n; a++) {
                    double d = fmin(fmax(w->grad[a], -1.0), 1.0);
                    w->to[w->joint[a]] += d;
                    step = fmax(step, fabs(d));
                }
                there = objective(w, w->to);
            }
            if (there <= here) {
                break;
            }
            mu *= 8.0;
        }
        if (!(there <= here)) {
            break;
        }
        double gain = here - there;
        memcpy(w->q, w->to, sizeof *w->q * (size_t)w->nq);
        here = there;
        mu = fmax(0.1 * mu, 1e-15);
        if (gain < 1e-9 * (1.0 + here) && step < 1e-9) {
            break;
        }
    }
    return here;
}

/* speeds at w->q, from slopes and channels that read a speed. @return 0, -1 */
static int find_speeds(work *w, double *sd)
{
    int n = w->nfree, nq = w->nq;
    if (find_H(w, NULL) != STEIN_OK || stand(w, w->q, w->qd0, NULL) != STEIN_OK) {
        return -1;
    }
    for (int c = 0; c < w->s->nch; c++) {
        const stein_channel *ch = channel_of(w, c);
        w->base[c] = shows_speed(ch) ? w->start[c].value - shown(w, c) : w->start[c].slope;
        for (int j = 0; shows_place(ch) && j < nq; j++) {
            w->base[c] -= w->H[c * nq + j] * w->qd0[j];
        }
    }
    memcpy(w->qd, w->qd0, sizeof *w->qd * (size_t)nq);
    for (int j = 0; j < nq; j++) {
        w->qd[j] = w->qd0[j] + 1.0;
        if (stand(w, w->q, w->qd, NULL) != STEIN_OK) {
            return -1;
        }
        for (int c = 0; c < w->s->nch; c++) {
            if (shows_speed(channel_of(w, c))) {
                w->H[c * nq + j] = shown(w, c); // less the reading at qd0, below
            }
        }
        w->qd[j] = w->qd0[j];
    }
    (void)stand(w, w->q, w->qd0, NULL);
    memset(w->A, 0, sizeof *w->A * (size_t)(n * n));
    memset(w->grad, 0, sizeof *w->grad * (size_t)n);
    for (int c = 0; c < w->s->nch; c++) {
        int speed = shows_speed(channel_of(w, c));
        double at = speed ? shown(w, c) : 0.0;
        double weight = fmax(speed ? w->start[c].value_sd : w->start[c].slope_sd, 1e-12);
        for (int j = 0; speed && j < nq; j++) {
            w->H[c * nq + j] -= at;
        }
        for (int a = 0; a < n && w->start[c].samples > 0; a++) {
            double h = w->H[c * nq + w->joint[a]] / weight;
            w->grad[a] += h * w->base[c] / weight;
            for (int b = 0; b < n; b++) {
                w->A[a * n + b] += h * w->H[c * nq + w->joint[b]] / weight;
            }
        }
    }
    for (int a = 0; a < n; a++) {
        w->A[a * n + a] += 1.0 / (w->e->qd_prior[w->joint[a]] * w->e->qd_prior[w->joint[a]]);
    }
    if (solve(w->A, w->grad, n) != 0) {
        return -1;
    }
    for (int a = 0; a < n; a++) {
        w->qd[w->joint[a]] += w->grad[a];
    }
    if (sd != NULL) {
        spread(w, sd);
    }
    return 0;
}

/* ---- one state out of several ---- */

/* the channels that say something are joints' own positions: one minimum */
static int is_linear(const work *w)
{
    for (int c = 0; c < w->s->nch; c++) {
        if (says_place(w, c) && channel_of(w, c)->read != STEIN_READ_POSITION) {
            return 0;
        }
    }
    return 1;
}

/* another place to begin at: turning joints anywhere, sliding ones within their prior */
static void place(work *w, int i)
{
    const stein_model *m = lab_equations(w->p->model);
    memcpy(w->q, w->q0, sizeof *w->q * (size_t)w->nq);
    for (int k = 0; i > 0 && k < w->nfree; k++) {
        // multiples of square roots of primes, modulo 1: as even as a quasi-random sequence
        static const double root[] = {0.414213562, 0.732050808, 0.236067977,
                                      0.645751311, 0.316624790, 0.605551275};
        double u = fmod(i * root[k % 6] * (1.0 + k / 6), 1.0) - 0.5;
        int j = w->joint[k];
        w->q[j] += m->bodies[j].type == 'R' ? 2.0 * pi * u : 2.0 * w->e->q_prior[j] * u;
    }
}

/* x of the stroke's initial state at q, qd */
static void begin_at(const work *w, const double *q, const double *qd, double *x)
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
static double follow(work *w, const double *q, const double *qd)
{
    memset(w->b->x, 0, sizeof *w->b->x * (size_t)w->p->nu);
    begin_at(w, q, qd, w->b->x);
    return fit__misfit(w->p, w->b, (int)(w->s - w->p->stroke), w->b->x, w->e->length);
}

typedef struct branch {
    double *q, *qd, objective;
} branch;

/* minima that differ, kept in order of the starts. @return their number */
static int find_branches(work *w, branch *list)
{
    const size_t size = sizeof *w->q * (size_t)w->nq;
    int n = 0, places = is_linear(w) ? 1 : PLACES;
    for (int i = 0; i < places && n < BRANCHES; i++) {
        place(w, i);
        double here = descend(w);
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
static int choose_branch(work *w, branch *list, int n)
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
            if (find_speeds(w, NULL) != 0) {
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

static int find_state(work *w)
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
    if (chosen < 0 || find_H(w, NULL) != STEIN_OK) {
        return -1;
    }
    (void)objective(w, w->q);
    fill_positions(w);
    if (solve(w->A, w->grad, w->nfree) != 0) {
        return -1;
    }
    spread(w, w->e->q_sd);
    if (find_speeds(w, w->e->qd_sd) != 0) {
        return -1;
    }
    for (int j = 0; j < w->nq; j++) {
        w->e->q[j] = w->q[j] - w->q0[j];
        w->e->qd[j] = w->qd[j] - w->qd0[j];
    }
    return 0;
}

/* ---- strokes ---- */

static void note_unknowns(work *w)
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

static int make_work(work *w, const fit__problem *p, fit__bench *b, int stroke, fit__estimate *e)
{
    size_t nq = (size_t)lab_equations(p->model)->nq, nch = (size_t)p->stroke[stroke].nch;
    *w = (work){.p = p, .b = b, .s = &p->stroke[stroke], .nq = (int)nq, .e = e};
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

static void free_work(work *w)
{
    free(w->q0);
    free(w->joint);
    free(w->start);
}

/* @return 1 when the record says something of the state. The estimate counts from the reset state
 */
int fit__estimate_state(const fit__problem *p, fit__bench *b, int stroke, fit__estimate *e)
{
    work w;
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
