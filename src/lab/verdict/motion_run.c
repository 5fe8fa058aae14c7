/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion_run.c - a stroke under the motion of a joint as it was measured.
 *
 * A channel that depends on one coordinate alone determines it,
 *
 *      y_i = h(q_j(t_i)) + offset + noise,       q_j = h^-1(y - offset)
 *
 * with h the model's own geometry and instrument, tabulated at the parameters of the stroke. What
 * comes out is smoothed as any measured motion (signal.c) and drives the joint; its equation then
 * gives the force that the drive would have to add,
 *
 *      error = (M qdd + c - Q)_j
 *
 * in which Q has the load on its contact and the measured forces: with the right model it is 0.
 * What they contribute is what the drive would need without them, less that.
 *
 * Strokes that prescribe the motion themselves show the force in a channel: error = simulated less
 * measured.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_spline.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "motion.h"

enum { TABLE = 33, WIDENINGS = 5 };
static const double nudge = 1e-4;    /* of a coordinate [rad or m] */
static const double shift = 1e-2;    /* the other state at which dependences are tested */
static const double ends = 10.0;     /* lengths over which a motion was smoothed: e^-5 is left */
static const double most_ends = 0.1; /* of a record */
static const double silent = 1e-7;   /* share of a dependence that is none */

/* ---- is there a way? ---- */

static int slot_of(const fit__problem *p, int stroke, int channel)
{
    const fit__stroke *t = &p->stroke[stroke];
    for (int k = 0; k < t->nch; k++) {
        if (t->channel[k] == channel) {
            return k;
        }
    }
    return -1;
}

/* reading of a channel with coordinate k moved; q is as it was */
static double moved(stein_sim *sim, int channel, double *q, const double *rest, int k, double by)
{
    q[k] += by;
    int ok = stein_set_state(sim, 0.0, q, rest, NULL) == STEIN_OK;
    q[k] -= by;
    return ok ? stein_read(sim, channel) : (double)NAN;
}

/* does the channel depend on coordinate j and on no other one, next to q? */
static int depends_at(stein_sim *sim, int channel, int joint, double *q, const double *rest)
{
    int nq = stein_sim_model(sim)->nq;
    double slope =
        moved(sim, channel, q, rest, joint, nudge) - moved(sim, channel, q, rest, joint, -nudge);
    int alone = fabs(slope) > silent * nudge;
    for (int k = 0; alone && k < nq; k++) {
        double other =
            moved(sim, channel, q, rest, k, nudge) - moved(sim, channel, q, rest, k, -nudge);
        alone = k == joint || fabs(other) <= silent * fabs(slope);
    }
    return alone;
}

static int determines(const lab_model *model, int channel, int joint)
{
    const stein_model *m = lab_equations(model);
    size_t nq = (size_t)m->nq;
    stein_sim *sim = NULL;
    double *q = calloc(2 * nq + 1, sizeof *q);
    stein_sim_def def = lab_def(model);
    int does = q != NULL && stein_reads_place((int)m->channels[channel].read) &&
               lab_sim(model, &def, &sim, NULL) == STEIN_OK;
    if (does) {
        memcpy(q, stein_q(sim), sizeof *q * nq);
        does = depends_at(sim, channel, joint, q, q + nq);
        for (size_t k = 0; k < nq; k++) {
            q[k] += shift;
        }
        does = does && depends_at(sim, channel, joint, q, q + nq);
    }
    stein_sim_destroy(sim);
    free(q);
    return does;
}

/* strokes that prescribe a motion: is its force measured? */
static int recorded_way(const fit__problem *p, diag__way *way, char *why, size_t size)
{
    const stein_model *m = lab_equations(p->model);
    int found = 0;
    for (int k = 0; k < p->stroke[0].nsignal && !found; k++) {
        int input = p->stroke[0].signal[k].input;
        if (m->inputs[input].kind != STEIN_INPUT_MOTION) {
            continue;
        }
        int force = lab__channel_of(m, STEIN_READ_INPUT_FORCE, input);
        *way = (diag__way){.input = input,
                           .joint = m->inputs[input].index,
                           .force = force,
                           .channel = -1,
                           .slot = force >= 0 ? slot_of(p, 0, force) : -1};
        found = way->slot >= 0;
        if (!found) {
            snprintf(
                why, size,
                "the records prescribe the motion of %s, and no channel of theirs is the force "
                "that it needed",
                m->bodies[way->joint].name);
        }
    }
    return found;
}

static int channel_way(const fit__problem *p, diag__way *way, char *why, size_t size)
{
    const stein_model *m = lab_equations(p->model);
    snprintf(why, size, "the file has no input that prescribes a motion, which this check needs");
    for (int i = 0; i < m->ninput; i++) {
        if (m->inputs[i].kind != STEIN_INPUT_MOTION) {
            continue;
        }
        int joint = m->inputs[i].index, force = lab__channel_of(m, STEIN_READ_INPUT_FORCE, i);
        if (force < 0) {
            snprintf(why, size,
                     "no output is the force that %s needs (outputs: NAME: {input: %s, "
                     "read: force})",
                     m->inputs[i].name, m->inputs[i].name);
            continue;
        }
        for (int k = 0; k < p->stroke[0].nch; k++) {
            if (determines(p->model, p->stroke[0].channel[k], joint)) {
                *way = (diag__way){i, joint, force, p->stroke[0].channel[k], k};
                return 1;
            }
        }
        snprintf(why, size, "no measured channel shows the motion of %s alone",
                 m->bodies[joint].name);
    }
    return 0;
}

int diag__motion_way(const diag__side *side, diag__way *way, char *why, size_t size)
{
    why[0] = '\0';
    const fit__problem *p = side->p;
    int found =
        recorded_way(p, way, why, size) || (why[0] == '\0' && channel_way(p, way, why, size));
    int measured = found && way->channel >= 0 ? way->channel : found ? way->force : -1;
    for (int s = 0; found && s < p->nstroke; s++) {
        if (slot_of(p, s, measured) != way->slot) {
            snprintf(why, size, "the records do not all have the channel %s in the same place",
                     lab_equations(p->model)->channels[measured].name);
            found = 0;
        }
    }
    return found;
}

int diag__motion_same(const diag__way *way, const fit__problem *from, const fit__problem *to,
                      diag__way *same)
{
    const stein_model *a = lab_equations(from->model), *b = lab_equations(to->model);
    *same = *way;
    same->input = stein_find_input(b, a->inputs[way->input].name);
    same->force = stein_find_channel(b, a->channels[way->force].name);
    same->joint = same->input >= 0 ? b->inputs[same->input].index : -1;
    if (way->channel >= 0) {
        same->channel = stein_find_channel(b, a->channels[way->channel].name);
        same->slot = same->channel >= 0 ? slot_of(to, 0, same->channel) : -1;
    }
    return same->input >= 0 && same->force >= 0 && same->slot == way->slot;
}

/* ---- strokes with a signal more ---- */

stein_status diag__motion_open(const fit__problem *p, fit__problem *with, stein_err *err)
{
    size_t signals = 0, n = (size_t)p->nstroke;
    for (int s = 0; s < p->nstroke; s++) {
        signals += (size_t)p->stroke[s].nsignal + 1;
    }
    fit__signal *at = calloc(signals + 1, sizeof *at);
    *with = *p;
    with->stroke = malloc(sizeof *with->stroke * (n + 1));
    if (at == NULL || with->stroke == NULL) {
        free(at);
        free(with->stroke);
        *with = (fit__problem){.stroke = NULL};
        return lab__no_memory(err);
    }
    memcpy(with->stroke, p->stroke, sizeof *with->stroke * n);
    for (int s = 0; s < p->nstroke; s++) {
        fit__stroke *t = &with->stroke[s];
        memcpy(at, t->signal, sizeof *at * (size_t)t->nsignal);
        t->signal = at;
        at += ++t->nsignal;
    }
    return STEIN_OK; // NOLINT(clang-analyzer-unix.Malloc): the first stroke's signals own them all
}

/* ---- from channel to coordinate ---- */

typedef struct inverse {
    gsl_spline *spline; /* q over reading */
    gsl_interp_accel *accel;
    double slope; /* mean |dy/dq| */
} inverse;

static void inverse_free(inverse *v)
{
    gsl_spline_free(v->spline);
    gsl_interp_accel_free(v->accel);
}

void diag__motion_include(const double *y, int n, double *lo, double *hi)
{
    for (int i = 0; i < n; i++) {
        *lo = isfinite(y[i]) ? fmin(*lo, y[i]) : *lo;
        *hi = isfinite(y[i]) ? fmax(*hi, y[i]) : *hi;
    }
}

/* readings over coordinates from a to b, in increasing order. @return 1: increasing and finite */
static int tabulate(stein_sim *sim, int channel, double *q, const double *rest, int joint, double a,
                    double b, double *at, double *y)
{
    int good = 1;
    for (int i = 0; i < TABLE; i++) {
        double by = a + (b - a) * i / (TABLE - 1);
        at[i] = q[joint] + by;
        y[i] = moved(sim, channel, q, rest, joint, by);
        good &= isfinite(y[i]) && (i == 0 || y[i] > y[i - 1]);
    }
    return good;
}

/* The simulation stands in its initial state, with the parameters of the stroke.
 * @param shown  what is added to its readings. @return 1, 0: the motion is not that of the joint */
static int invert(stein_sim *sim, const diag__way *way, double shown, double lo, double hi,
                  inverse *v)
{
    int nq = stein_sim_model(sim)->nq, good = 0;
    double *q = calloc(2 * (size_t)nq + 2 * TABLE, sizeof *q), *rest = q + nq, at[TABLE], y[TABLE];
    *v = (inverse){.slope = NAN};
    if (q == NULL || !(hi > lo)) {
        free(q);
        return 0;
    }
    memcpy(q, stein_q(sim), sizeof *q * (size_t)nq);
    double first = stein_read(sim, way->channel);
    double slope = (moved(sim, way->channel, q, rest, way->joint, nudge) - first) / nudge;
    double a = (lo - shown - first) / slope, b = (hi - shown - first) / slope;
    for (int i = 0; !good && i < WIDENINGS; i++) { // geometry bends: a little more than the tangent
        double more = 0.05 * (i + 1) * (b - a);
        good = tabulate(sim, way->channel, q, rest, way->joint, a - more, b + more, at, y) &&
               y[0] <= lo - shown && y[TABLE - 1] >= hi - shown;
    }
    free(q);
    if (good) {
        v->spline = gsl_spline_alloc(gsl_interp_cspline, TABLE);
        v->accel = gsl_interp_accel_alloc();
        good = v->spline != NULL && v->accel != NULL &&
               gsl_spline_init(v->spline, y, at, TABLE) == GSL_SUCCESS;
        v->slope = (y[TABLE - 1] - y[0]) / fabs(at[TABLE - 1] - at[0]);
    }
    return good;
}

/* the motion of a stroke as a signal; b stands at its beginning with its parameters */
static int signal_from_channel(const diag__side *side, const diag__way *way, fit__bench *b,
                               int stroke, const diag__told *told, fit__signal *to)
{
    const fit__stroke *t = &side->p->stroke[stroke];
    int n = t->n, delay = t->delay[way->slot];
    double lo = INFINITY, hi = -INFINITY, *time = malloc(sizeof *time * 2 * (size_t)(n + 1)),
           *q = time + n;
    double error = side->p->clock >= 0 ? b->p[side->p->clock] : 0.0;
    inverse v = {.spline = NULL};
    diag__motion_include(told->motion, n, &lo, &hi);
    int good = time != NULL && invert(b->sim, way, b->shown[way->slot], lo, hi, &v);
    for (int i = 0; good && i < n; i++) {
        time[i] = (1.0 + error) * t->data->time[i] - (delay >= 0 ? b->p[delay] : 0.0);
        q[i] = isfinite(told->motion[i])
                   ? gsl_spline_eval(v.spline, told->motion[i] - b->shown[way->slot], v.accel)
                   : (double)NAN;
    }
    good = good && fit__signal_through(to, way->input, time, q, n, told->noise / v.slope,
                                       told->decades, NULL) == STEIN_OK;
    inverse_free(&v);
    free(time);
    return good;
}

/* ---- the run ---- */

typedef struct eye {
    const diag__way *way;
    diag__course *c;
    stein_sim *bare; /* the same without load and forces; NULL: not needed */
    void *state;
} eye;

static void look(void *ctx, stein_sim *sim, int i)
{
    eye *e = ctx;
    double missing = stein_read(sim, e->way->force);
    e->c->time[i] = stein_time(sim);
    e->c->error[i] = missing;
    if (e->bare != NULL) {
        stein_save(sim, e->state);
        int ok = stein_restore(e->bare, e->state, NULL) == STEIN_OK;
        stein_load_lift(e->bare);
        e->c->present[i] = ok ? stein_read(e->bare, e->way->force) - missing : (double)NAN;
    }
}

/* a signal with the clock it is on */
typedef struct clocked {
    const fit__signal *signal;
    double shift;
    int at;
} clocked;

static void signal_at(void *ctx, double t, double u[3])
{
    clocked *c = ctx;
    fit__signal_at(c->signal, t + c->shift, &c->at, u);
}

/* a simulation with nothing but the motion. @return 1, 0 */
static int undress(const fit__problem *p, const diag__way *way, fit__bench *b, clocked *c)
{
    const stein_model *m = lab_equations(p->model);
    stein_sim_def def = lab_def(p->model);
    def.integrator = STEIN_DP5;
    if (b->probe == NULL && lab_sim(p->model, &def, &b->probe, NULL) != STEIN_OK) {
        return 0;
    }
    return stein_try_all(b->probe, b->p, NULL) == STEIN_OK &&
           stein_drive(b->probe, m->inputs[way->input].name, signal_at, c, NULL) == STEIN_OK;
}

/* How far from its ends a smoothed motion bends less than the true one. Strokes that a model makes
 * of the smoothed motion do not show that. */
static double end_of(const fit__signal *s)
{
    double all = s->t[s->n - 1] - s->t[0], interval = all / fmax(1.0, s->n - 1.0);
    return fmin(ends * interval * stein__power(10.0, s->decades / 6.0), most_ends * all);
}

/* measured less simulated, of the channels that are free; the force, where it is one of them */
static void compare(const fit__stroke *t, const diag__way *way, const diag__told *told,
                    const fit__signal *signal, const double *y, diag__course *c)
{
    double end = way->channel < 0 ? end_of(signal) : 0.0;
    double from = signal->t[0] + end, to = signal->t[signal->n - 1] - end;
    for (int k = 0; k < t->nch; k++) {
        for (int i = 0; i < t->n; i++) {
            int at = k * t->n + i;
            c->y[at] = k == way->slot ? (double)NAN : told->y[at] - y[at];
        }
    }
    for (int i = 0; way->channel < 0 && i < t->n; i++) {
        int at = way->slot * t->n + i, inside = t->data->time[i] > from && t->data->time[i] < to;
        c->error[i] = inside ? y[at] - told->y[at] : (double)NAN;
        if (c->present != NULL) {
            c->present[i] = told->y[at];
        }
    }
}

static void run(const diag__side *side, const fit__problem *own, const diag__way *way,
                fit__bench *b, int stroke, const fit__signal *signal, const diag__told *told,
                diag__course *c)
{
    const fit__problem *p = side->p;
    const fit__stroke *t = &p->stroke[stroke];
    double tau = t->tau >= 0 ? fit__value(&p->unknown[t->tau], side->x[t->tau]) : 0.0;
    clocked clock = {signal, t->origin - tau, 0};
    eye e = {.way = way, .c = c};
    int asked = c->present != NULL && way->channel >= 0;
    double *y = malloc(sizeof *y * ((size_t)(t->nch * t->n) + 1));
    if (asked) {
        e.state = malloc(stein_state_size(b->sim));
        e.bare = e.state != NULL && undress(p, way, b, &clock) ? b->probe : NULL;
    }
    b->watch = look;
    b->watch_ctx = &e;
    if (y != NULL && fit__simulate(own, b, stroke, side->x, y, NULL) == STEIN_OK) {
        compare(t, way, told, signal, y, c);
        c->ended = 1;
    }
    b->watch = NULL;
    if (e.bare != NULL) { // its signal ends here
        (void)stein_drive(e.bare, lab_equations(p->model)->inputs[way->input].name, NULL, NULL,
                          NULL);
    }
    free(e.state);
    free(y);
}

/* recorded forces with noise on them, in signals of one's own; values is their memory */
static int shake(fit__signal *signal, int n, const diag__told *told, fit__cubic **values)
{
    size_t all = 0;
    for (int k = 0; k < n; k++) {
        all += (size_t)signal[k].n;
    }
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    fit__cubic *piece = *values = malloc((sizeof *piece + sizeof(double)) * (all + 1));
    int good = rng != NULL && piece != NULL;
    double *at = good ? (double *)(piece + all + 1) : NULL;
    for (int k = 0; good && k < n; k++) {
        fit__signal *s = &signal[k];
        gsl_rng_set(rng, told->seed + (unsigned long)k);
        for (int i = 0; !s->motion && i < s->n; i++) {
            at[i] = s->g[i] + gsl_ran_gaussian(rng, told->force_noise[k]);
        }
        if (!s->motion) {
            s->g = at;
            s->piece = piece;
            fit__signal_pieces(s, NULL);
        }
        at += s->n;
        piece += s->n;
    }
    gsl_rng_free(rng);
    return good;
}

void diag__motion_run(const diag__side *side, const fit__problem *with, const diag__way *way,
                      fit__bench *b, int stroke, const diag__told *told, diag__course *c)
{
    const fit__stroke *t = &with->stroke[stroke];
    size_t n = (size_t)with->nstroke, signals = (size_t)t->nsignal;
    fit__problem own = *with;
    own.stroke = malloc(sizeof *own.stroke * n + sizeof(fit__signal) * signals);
    double *y = malloc(sizeof *y * ((size_t)(t->nch * t->n) + 1));
    c->ended = 0;
    if (own.stroke == NULL || y == NULL) {
        b->no_memory = 1;
        free(own.stroke);
        free(y);
        return;
    }
    fit__signal *signal = (fit__signal *)(own.stroke + n), made = {.t = NULL};
    fit__cubic *forces = NULL;
    memcpy(own.stroke, with->stroke, sizeof *own.stroke * n);
    memcpy(signal, t->signal, sizeof *signal * signals);
    fit__stroke *mine = &own.stroke[stroke];
    mine->signal = signal;
    int at = t->nsignal - 1, good;
    if (way->channel >= 0) {
        good = fit__begin(side->p, b, stroke, side->x, y, NULL) == STEIN_OK &&
               signal_from_channel(side, way, b, stroke, told, &made);
    } else {
        mine->nsignal--; // it is one of them
        for (at = 0; signal[at].input != way->input;) {
            at++;
        }
        good = told->motion == NULL ||
               fit__signal_through(&made, way->input, signal[at].t, told->motion, signal[at].n,
                                   told->noise, told->decades, NULL) == STEIN_OK;
    }
    if (good && told->force_noise != NULL) {
        good = shake(signal, side->p->stroke[stroke].nsignal, told, &forces);
    }
    if (good) {
        signal[at] = made.t != NULL ? made : signal[at];
        run(side, &own, way, b, stroke, &signal[at], told, c);
    }
    fit__signal_free(&made);
    free(forces);
    free(own.stroke);
    free(y);
}
