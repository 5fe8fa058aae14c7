/* SPDX-License-Identifier: GPL-3.0-or-later
 * initial.c - initial states from the records.
 *
 * The first samples of a record that begins in mid-motion give the mechanism's positions and speeds
 * (start_state.c).
 * One-sided slopes are uncertain: after the length of a window their error is ten noises. Within
 * three standard deviations the state is therefore improved by the model's own simulation of the
 * start window (start_follow.c); a model that is wrong cannot lead it further away.
 *
 * The estimate is where the unknowns of the initial state start: x = 0 means the estimated state.
 * Joints that a motion drives, that the stroke sets or that are a free parameter stay as they are.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "start_state.h"

enum { STEPS = 3 };
static const double pi = 3.14159265358979323846;
static const double observed = 0.3; /* share of the prior sd below which the data decide */
static const double slack = 3.0;    /* sd of the kinematics that the dynamics may use */
/* scale of the unknowns, and half-widths of their differences [rad or m; 1/s] */
static const double least_sd = 1e-6, least_step = 1e-6, most_step = 1e-3;

double fit__misfit(const fit__problem *p, fit__bench *b, int stroke, const double *x, double until)
{
    fit__problem to = *p;
    const fit__stroke *s = &p->stroke[stroke];
    double sum = 0.0;
    int n = 0;
    to.horizon = fmin(p->horizon, until);
    if (fit__simulate(&to, b, stroke, x, b->y, NULL) != STEIN_OK) {
        return INFINITY;
    }
    for (int i = 0; i < s->nch * s->n; i++) {
        if (isfinite(s->y[i]) && fit__time_of(s, i) - s->origin <= to.horizon) {
            double r = (s->y[i] - b->y[i]) / s->noise[i / s->n];
            sum += r * r;
            n++;
        }
    }
    return n > 0 ? sum / n : (double)INFINITY;
}

/* ---- strokes ---- */

int fit__waits(const fit__stroke *s, const lab_audit *a)
{
    return s->nsignal == 0 && s->data->time[0] < 0.0 && a->starts_at_rest && a->trigger_fits &&
           s->data->trigger != LAB_TRIGGER_UNSYNCHRONISED;
}

/* the offset of a channel that counts from the initial state: it is what it shows there */
static int is_zero_of_start(const fit__unknown *u)
{
    return u->kind == FIT__OFFSET && !u->prior;
}

static size_t room_of(const fit__problem *p, int stroke)
{
    return 6 * (size_t)lab_equations(p->model)->nq + (size_t)p->stroke[stroke].nch;
}

/* room_of doubles become an estimate */
static fit__estimate estimate_in(double *room, int nq)
{
    return (fit__estimate){.q = room,
                           .qd = room + nq,
                           .q_sd = room + 2 * nq,
                           .qd_sd = room + 3 * nq,
                           .q_prior = room + 4 * nq,
                           .qd_prior = room + 5 * nq,
                           .shown = room + 6 * nq};
}

int fit__initial_state(const fit__problem *p, fit__bench *b, int stroke, double *x)
{
    int nq = lab_equations(p->model)->nq;
    const fit__stroke *s = &p->stroke[stroke];
    double *room = calloc(room_of(p, stroke) + 1, sizeof *room);
    if (room == NULL) {
        b->no_memory = 1;
        return 0;
    }
    fit__estimate e = estimate_in(room, nq);
    int found = fit__estimate_state(p, b, stroke, &e);
    for (int k = s->first; found && k < s->first + s->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        double z = u->kind == FIT__POSITION ? e.q[u->index]
                   : u->kind == FIT__SPEED  ? e.qd[u->index]
                   : is_zero_of_start(u)    ? e.shown[u->index]
                                            : (double)NAN;
        x[k] = isfinite(z) ? (z - u->start) / u->sd : x[k];
    }
    free(room);
    return found;
}

/* the estimates of all strokes */
typedef struct all {
    const fit__problem *p;
    fit__estimate *estimate; /* [nstroke] */
    double *room;            // of all estimates
} all;

static void estimate_one(void *ctx, fit__bench *b, int stroke)
{
    const all *a = ctx;
    a->estimate[stroke].known = fit__estimate_state(a->p, b, stroke, &a->estimate[stroke]);
}

/* what the data decide has no prior; what they leave open keeps the one that it was estimated with
 */
static void settle(fit__unknown *u, double *step, double value, double sd, double prior)
{
    u->start = value;
    u->prior = !(sd < observed * prior);
    u->sd = u->prior ? prior : fmax(sd, least_sd);
    *step = fmin(fmax(1e-2 * u->sd, least_step), most_step) / u->sd;
}

static stein_status make_estimates(all *a, stein_err *err)
{
    size_t size = 0;
    int nq = lab_equations(a->p->model)->nq;
    size_t n = (size_t)a->p->nstroke;
    for (int s = 0; s < a->p->nstroke; s++) {
        size += room_of(a->p, s);
    }
    a->estimate = calloc(n, sizeof *a->estimate);
    a->room = calloc(size + 1, sizeof *a->room);
    if (a->estimate == NULL || a->room == NULL) {
        return lab__no_memory(err);
    }
    size_t at = 0;
    for (int s = 0; s < a->p->nstroke; s++) {
        a->estimate[s] = estimate_in(a->room + at, nq);
        at += room_of(a->p, s);
    }
    return STEIN_OK;
}

static void free_estimates(all *a)
{
    free(a->room);
    free(a->estimate);
}

static int has_initial(const fit__problem *p)
{
    for (int k = p->np; k < p->nu; k++) {
        if (fit__is_initial(&p->unknown[k])) {
            return 1;
        }
    }
    return 0;
}

/* within what the kinematics leave open, the state from which the model follows the start window */
static void refine_one(void *ctx, fit__bench *b, int stroke)
{
    const all *a = ctx;
    const fit__stroke *s = &a->p->stroke[stroke];
    fit__estimate *e = &a->estimate[stroke];
    fit__follow how = {.sd = s->noise, .until = e->length, .most = slack, .steps = STEPS};
    memset(b->x, 0, sizeof *b->x * (size_t)a->p->nu);
    if (!e->known || !isfinite(fit__follow_start(a->p, b, stroke, &how, b->x))) {
        return;
    }
    for (int k = s->first; k < s->first + s->own; k++) {
        const fit__unknown *u = &a->p->unknown[k];
        if (fit__is_initial(u)) {
            (u->kind == FIT__POSITION ? e->q : e->qd)[u->index] = fit__value(u, b->x[k]);
        }
    }
}

stein_status fit__initial_states(fit__problem *p, stein_err *err)
{
    all a = {.p = p};
    if (!has_initial(p)) {
        return STEIN_OK;
    }
    stein_status status = make_estimates(&a, err);
    status = status == STEIN_OK ? fit__parallel(p, p->nstroke, estimate_one, &a, err) : status;
    for (int k = p->np; status == STEIN_OK && k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        const fit__estimate *e = &a.estimate[u->stroke];
        int j = u->index;
        if (e->known && is_zero_of_start(u) && isfinite(e->shown[j])) {
            u->start = e->shown[j];
        }
        if (!fit__is_initial(u) || !e->known) {
            continue;
        }
        p->stroke[u->stroke].window = e->length;
        p->stroke[u->stroke].half = e->rate > 0.0 ? pi / e->rate : 0.0;
        if (u->kind == FIT__POSITION) {
            settle(u, &p->step[k], e->q[j], e->q_sd[j], e->q_prior[j]);
        } else {
            settle(u, &p->step[k], e->qd[j], e->qd_sd[j], e->qd_prior[j]);
        }
    }
    status = status == STEIN_OK ? fit__parallel(p, p->nstroke, refine_one, &a, err) : status;
    for (int k = p->np; status == STEIN_OK && k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        const fit__estimate *e = &a.estimate[u->stroke];
        if (fit__is_initial(u) && e->known) {
            u->start = (u->kind == FIT__POSITION ? e->q : e->qd)[u->index];
        }
    }
    free_estimates(&a);
    return status;
}
