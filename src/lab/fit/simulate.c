/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulate.c - what a model predicts for the samples of one stroke.
 *
 *      T = (1 + e) t + tau - origin      simulation time of the frame recorded at t
 *
 * with e the error of the recorder's time base (clock.error); a lagging instrument shows in it what
 * was at T - delay. The run ends exactly at every T, so no grid moves when tau or e change. Before
 * T = 0 the mechanism waits in its initial state. Measured motions and forces are no frames: they
 * have the trigger's time, and a time base that is right.
 *
 * Steps. A fixed step of 10 us leaves an error of 0.2 um (RK4) or 0.5 um (DP5) in a stroke of the
 * piano action, 20-40 us leave 1 to 7 um: the rubbing notch is stiff for a few ms (mu f_n/(m v_t),
 * about 1e5 1/s) and nothing happens for the rest. So Dormand-Prince's own error estimate controls
 * the step from outside of the core, which still cuts it at every event:
 *
 *      h <- 0.9 h (tol/e)^(1/5),    e = max over joints (|e_q|, h |e_qd|)
 *
 * The estimate is that of the last piece of a step that was cut. So a step with an event in it is
 * taken back, the next ones end just before the event, and a tenth of the file's step leads across.
 * Without that an escapement was found with the states of an unchecked long step, and strokes came
 * out microns apart for no reason.
 *
 * With tol = 1e-11 a stroke is right to 1e-10 m in a quarter of the evaluations, and what
 * differences of strokes see of the steps' choice is as small. A sequence of steps kept from the
 * unchanged parameters would be smoother still, but not where a contact begins earlier than it did.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

/* in steps of the file: a step that holds an event; any step */
static const double across = 0.1, longest = 20.0;
static const double shortest = 1e-12; /* [s] */

/* when the first event of the last step was */
typedef struct watch {
    double first;
} watch;

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    watch *w = ctx;
    (void)sim;
    w->first = fmin(w->first, event->time);
}

/* one step, tried. @return its error in tolerances; INFINITY when it failed */
static double try_step(stein_sim *sim, double target, double tolerance, watch *w, void *kept,
                       stein_status *status, stein_err *err)
{
    double eq = 0.0, eqd = 0.0, step = target - stein_time(sim);
    stein_save(sim, kept);
    w->first = INFINITY;
    *status = stein_run(sim, target, err);
    return *status == STEIN_OK && stein_step_error(sim, &eq, &eqd, NULL) == STEIN_OK
               ? fmax(eq, step * eqd) / tolerance
               : (double)INFINITY;
}

stein_status fit__advance(stein_sim *sim, double t_end, double tolerance, double *h, void *kept,
                          stein_err *err)
{
    watch w;
    double dt = stein_sim_model(sim)->dt, crossing = across * dt;
    double event = INFINITY; // that the steps have to end just before
    stein_status status = STEIN_OK;
    stein_on_event(sim, on_event, &w);
    for (double t = stein_time(sim); status == STEIN_OK && t < t_end; t = stein_time(sim)) {
        double left = t_end - t, step = fmin(*h, longest * dt);
        double before = event - 0.5 * crossing - t;
        int leads_across = before <= 1e-3 * crossing, bounded = leads_across || before <= step;
        step = leads_across ? fmin(step, crossing) : fmin(step, before);
        int last = step >= left * (1.0 - 1e-9);
        step = last ? left : step > 0.5 * left && !bounded ? 0.5 * left : step;
        double e = try_step(sim, last ? t_end : t + step, tolerance, &w, kept, &status, err);
        int cut = w.first <= t + step && step > crossing * (1.0 + 1e-6);
        // a signal that jumps has no step that is short enough: its speed times `shortest` is left
        int jump = step < shortest && isfinite(e);
        if ((e <= 1.0 && !cut) || jump) {
            double grown = step * fmin(4.0, fmax(0.3, 0.9 * pow(fmax(e, 1e-12), -0.2)));
            int rest = last || (bounded && !leads_across); // the rest of a step tells little
            *h = rest && grown < *h && e < 0.5 ? *h : grown;
            event = leads_across ? INFINITY : event;
            continue;
        }
        if (step < shortest) {
            status = status != STEIN_OK ? status
                                        : lab__fail(err, STEIN_ENONFINITE,
                                                    "no step is short enough at t = %g s", t);
            break;
        }
        status = stein_restore(sim, kept, err);
        if (cut && e < INFINITY) { // its error is that of what came behind the event
            event = w.first;
        } else {
            *h = step * fmax(0.2, isfinite(e) ? 0.9 * pow(e, -0.2) : 0.2);
        }
    }
    stein_on_event(sim, NULL, NULL);
    return status;
}

/* ---- what a thread keeps ---- */

stein_status fit__bench_make(fit__bench *b, const fit__problem *p, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    size_t np = (size_t)m->np, nq = (size_t)m->nq;
    stein_sim_def def = lab_def(p->model);
    *b = (fit__bench){.sim = NULL};
    def.integrator = STEIN_DP5;
    def.dt = 1e6; // steps end where fit__advance says
    stein_status status = lab_sim(p->model, &def, &b->sim, err);
    if (status == STEIN_OK && p->gain > 0.0) {
        status = lab_sim(p->model, &def, &b->probe, err);
        b->observer = fit__observer_make(m);
    }
    if (status != STEIN_OK) {
        return status;
    }
    b->p = calloc(np + 1, sizeof *b->p);
    b->q = calloc(nq + 1, sizeof *b->q);
    b->qd = calloc(nq + 1, sizeof *b->qd);
    b->shown = calloc((size_t)m->nchannel + (size_t)m->ninput + 1, sizeof *b->shown);
    b->kept = malloc(stein_state_size(b->sim));
    int memory = b->p && b->q && b->qd && b->shown && b->kept && (p->gain <= 0.0 || b->observer);
    return memory ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
}

void fit__bench_free(fit__bench *b)
{
    stein_sim_destroy(b->sim);
    stein_sim_destroy(b->probe);
    fit__observer_free(b->observer);
    free(b->p);
    free(b->q);
    free(b->qd);
    free(b->shown);
    free(b->kept);
}

/* ---- one stroke ---- */

/* a signal with the clock it is on */
typedef struct clocked {
    const fit__signal *signal;
    double shift;
} clocked;

static void signal_at(void *ctx, double t, double u[3])
{
    const clocked *c = ctx;
    fit__signal_at(c->signal, t + c->shift, u);
}

static stein_status bind(stein_sim *sim, const stein_model *m, const fit__stroke *s, clocked *c,
                         double shift, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < m->ninput; i++) {
        status = stein_drive(sim, m->inputs[i].name, NULL, NULL, err);
    }
    for (int k = 0; status == STEIN_OK && k < s->nsignal; k++) {
        c[k] = (clocked){&s->signal[k], shift};
        status = stein_drive(sim, m->inputs[s->signal[k].input].name, signal_at, &c[k], err);
    }
    return status;
}

/* What is added to every reading: readings that count from the initial state count from the one the
 * stroke really has, which is known when the reset state was `moved`; markers have their offsets.
 */
static void note_shown(const fit__problem *p, fit__bench *b, stein_sim *sim, const fit__stroke *s,
                       const double *x, int moved)
{
    const stein_model *m = lab_equations(p->model);
    for (int c = 0; c < s->nch; c++) {
        double at_start =
            m->channels[s->channel[c]].from_rest ? stein_read(sim, s->channel[c]) : 0.0;
        b->shown[c] = moved ? b->shown[c] - at_start : at_start;
    }
    for (int k = s->first; moved && k < s->first + s->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        if (u->kind == FIT__OFFSET) {
            b->shown[u->index] += fit__value(u, x[k]);
        }
    }
}

/* what differs from stroke to stroke by itself */
static void scatter(const fit__problem *p, fit__bench *b, const fit__stroke *s, const double *x)
{
    const stein_model *m = lab_equations(p->model);
    for (int k = s->first; k < s->first + s->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        double factor = u->kind == FIT__SCATTER ? fit__value(u, x[k]) : 1.0;
        for (int i = 0; factor != 1.0 && i < m->np; i++) {
            b->p[i] *= p->group[i] == u->index ? factor : 1.0;
        }
    }
}

/* an effect with its unknowns, `amount` and the next one */
static void apply(const fit__problem *p, const lab_candidate *effect, int amount, const double *x,
                  double *to)
{
    const fit__unknown *u = &p->unknown[amount];
    lab_candidate c = *effect;
    c.side_value = c.side >= 0 ? fit__value(u + 1, x[amount + 1]) : 0.0;
    lab_candidate_apply(&c, fit__value(u, x[amount]), to);
}

/* parameters of the stroke, its start, and the changes of its initial state */
static stein_status start(const fit__problem *p, fit__bench *b, const fit__stroke *s,
                          const double *x, stein_sim *sim, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    size_t nq = (size_t)m->nq;
    memcpy(b->p, lab_parameters(p->model), sizeof *b->p * (size_t)m->np);
    for (int k = 0; k < p->np; k++) {
        if (p->unknown[k].kind == FIT__PARAM) {
            b->p[p->unknown[k].index] = fit__value(&p->unknown[k], x[k]);
        }
    }
    lab_data_apply(s->data, b->p);
    for (int i = 0; i < p->naccepted; i++) {
        apply(p, p->accepted[i], p->first_accepted + 2 * i, x, b->p);
    }
    if (p->given != NULL) {
        lab_candidate_apply(p->given, p->given_amount, b->p);
    }
    if (p->effect != NULL) {
        apply(p, p->effect, p->amount, x, b->p);
    }
    scatter(p, b, s, x);
    stein_status status = stein_set_all(sim, b->p, err);
    status = status == STEIN_OK ? stein_reset(sim, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    note_shown(p, b, sim, s, x, 0);
    int moved = 0;
    memcpy(b->q, stein_q(sim), sizeof *b->q * nq);
    memcpy(b->qd, stein_qd(sim), sizeof *b->qd * nq);
    for (int k = s->first; k < s->first + s->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        double *to = u->kind == FIT__POSITION ? b->q : u->kind == FIT__SPEED ? b->qd : NULL;
        if (to != NULL) {
            to[u->index] += fit__value(u, x[k]);
            moved = 1;
        }
    }
    status = moved ? stein_set_state(sim, 0.0, b->q, b->qd, err) : STEIN_OK;
    note_shown(p, b, sim, s, x, 1);
    return status;
}

static stein_status read_sample(fit__bench *b, const fit__stroke *s, int c, int i, double *y,
                                stein_err *err)
{
    double value = stein_read(b->sim, s->channel[c]) + b->shown[c];
    if (!isfinite(value)) {
        return lab__fail(err, STEIN_ENONFINITE, "no reading at t = %g s", stein_time(b->sim));
    }
    y[c * s->n + i] = value;
    if (c == 0 && b->watch != NULL) {
        b->watch(b->watch_ctx, b->sim, i);
    }
    return STEIN_OK;
}

/* down the ladder: from sample i to the next one, at T */
static stein_status pulled(const fit__problem *p, fit__bench *b, const fit__stroke *s, int i,
                           const double *y, double T, double *h, stein_err *err)
{
    double t = stein_time(b->sim);
    stein_status status = t > 0.0 ? fit__observe(b, s, i, y + i, err) : STEIN_OK;
    for (int second = 0; status == STEIN_OK && second < 2; second++) {
        fit__observer_half(b->observer, p->gain, second);
        stein_on_force(b->sim, fit__observer_force, b->observer); // it has changed: evaluate anew
        status = fit__advance(b->sim, second ? T : 0.5 * (t + T), p->tolerance, h, b->kept, err);
    }
    return status;
}

/* delay of the instrument behind a channel [s]; the core leaves it to who samples */
static double delay_of(const fit__bench *b, const fit__stroke *s, int c)
{
    return s->delay[c] >= 0 ? b->p[s->delay[c]] : 0.0;
}

/* simulation time of the frame recorded as sample i */
static double frame_time(const fit__problem *p, const fit__bench *b, const fit__stroke *s,
                         double tau, int i)
{
    double error = p->clock >= 0 ? b->p[p->clock] : 0.0;
    return (1.0 + error) * s->data->time[i] + tau - s->origin;
}

/* from sample i on the prediction of a channel is the data: no residual */
static void beyond(const fit__stroke *s, int c, int i, double *y)
{
    size_t at = (size_t)c * (size_t)s->n + (size_t)i;
    memcpy(y + at, s->y + at, sizeof *y * (size_t)(s->n - i));
}

static stein_status run(const fit__problem *p, fit__bench *b, const fit__stroke *s, double tau,
                        double *y, stein_err *err)
{
    double h = 0.1 * lab_equations(p->model)->dt;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < s->n; i++) {
        double T = frame_time(p, b, s, tau, i);
        if (T > p->horizon) {
            for (int c = 0; c < s->nch; c++) {
                beyond(s, c, i, y);
            }
            break;
        }
        if (T > 0.0) {
            status = p->gain > 0.0 && i > 0
                         ? pulled(p, b, s, i - 1, y, T, &h, err)
                         : fit__advance(b->sim, T, p->tolerance, &h, b->kept, err);
        }
        for (int c = 0; status == STEIN_OK && c < s->nch; c++) {
            status = read_sample(b, s, c, i, y, err);
        }
    }
    return status;
}

/* the same with instruments that lag: the samples of all channels in the order of their true times
 */
static stein_status run_delayed(const fit__problem *p, fit__bench *b, const fit__stroke *s,
                                double tau, const double *delay, double *y, stein_err *err)
{
    double h = 0.1 * lab_equations(p->model)->dt;
    stein_status status = STEIN_OK;
    int *next = calloc((size_t)s->nch + 1, sizeof *next);
    if (next == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int k = 0; status == STEIN_OK && k < s->nch * s->n; k++) {
        int c = -1;
        double T = INFINITY;
        for (int a = 0; a < s->nch; a++) {
            double t = next[a] < s->n ? frame_time(p, b, s, tau, next[a]) - delay[a] : INFINITY;
            c = t < T ? a : c;
            T = fmin(t, T);
        }
        if (T > p->horizon) {
            for (int a = 0; a < s->nch; a++) {
                beyond(s, a, next[a], y);
            }
            break;
        }
        if (T > stein_time(b->sim)) {
            status = fit__advance(b->sim, T, p->tolerance, &h, b->kept, err);
        }
        status = status == STEIN_OK ? read_sample(b, s, c, next[c]++, y, err) : status;
    }
    free(next);
    return status;
}

static stein_status run_either(const fit__problem *p, fit__bench *b, const fit__stroke *s,
                               double tau, double *y, stein_err *err)
{
    double *delay = calloc((size_t)s->nch + 1, sizeof *delay);
    int any = 0;
    if (delay == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int c = 0; c < s->nch; c++) {
        delay[c] = delay_of(b, s, c);
        any |= delay[c] != 0.0;
    }
    stein_status status = any && p->gain <= 0.0 ? run_delayed(p, b, s, tau, delay, y, err)
                                                : run(p, b, s, tau, y, err);
    free(delay);
    return status;
}

stein_status fit__simulate(const fit__problem *p, fit__bench *b, int stroke, const double *x,
                           double *y, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[stroke];
    clocked *c = malloc(sizeof *c * (size_t)(2 * s->nsignal + 1));
    if (c == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    double tau = s->tau >= 0 ? fit__value(&p->unknown[s->tau], x[s->tau]) : 0.0;
    stein_on_force(b->sim, b->force, b->force_ctx);
    stein_status status = bind(b->sim, m, s, c, s->origin - tau, err);
    status = status == STEIN_OK ? start(p, b, s, x, b->sim, err) : status;
    if (status == STEIN_OK && p->gain > 0.0) {
        status = bind(b->probe, m, s, c + s->nsignal, s->origin - tau, err);
        status = status == STEIN_OK ? start(p, b, s, x, b->probe, err) : status;
        fit__observer_rest(b->observer);
        stein_on_force(b->sim, fit__observer_force, b->observer);
    }
    status = status == STEIN_OK ? run_either(p, b, s, tau, y, err) : status;
    free(c); // the next stroke binds its own
    return status;
}
