/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulate.c - what a model predicts for the samples of one stroke.
 *
 *      T = (1 + e) t + tau - origin      simulation time of the frame recorded at t
 *
 * with e the error of the recorder's time base (clock.error), which acts from the origin on where
 * nothing else has a time; a lagging instrument shows in it what
 * was at T - delay. Before T = 0 the mechanism waits in its initial state. Measured motions and
 * forces are no frames: they have the trigger's time, and a time base that is right.
 *
 * Steps. A fixed step of 10 us leaves an error of 0.2 um (RK4) or 0.5 um (DP5) in a stroke of the
 * piano action, 20-40 us leave 1 to 7 um: the rubbing notch is stiff for a few ms (mu f_n/(m v_t),
 * about 1e5 1/s) and nothing happens for the rest. So their error is controlled, and the samples
 * are read from their dense output. The steps do not depend on frames, trigger and clock, so
 * differences with respect to these are those of a smooth interpolant. Only the samples of a
 * recorded input, which bends there, end a step.
 *
 * With tol = 1e-11 a stroke is right to 1e-9 m, and what differences of strokes see of the steps'
 * choice is smaller. A sequence of steps kept from the unchanged parameters would be smoother
 * still, but not where a contact begins earlier than it did.
 *
 * A search tries numbers that no mechanism has. Real strokes take 400 to 2000 trial steps. One that
 * rattled on a table's slope took 8 million, longer than all others together. So more than a
 * hundred steps for each of the longest ones count as a failed simulation. A run has such a limit
 * of its own, but a stroke with a recorded input is hundreds of them.
 *
 * Times of events are no samples: event_times.c.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stroke_reader.h"

/* in steps of the file: the first step, any step */
static const double first = 0.1, longest = 30.0;
/* trial steps of a stroke: in all, and for each longest step or run */
static const double most_gain = 0.3; /* of a correction of several samples */
static const double fewest_trials = 2e4, trials_a_longest = 100.0;

static stein_pace pace_of(const fit__problem *p)
{
    double dt = lab_equations(p->model)->dt;
    if (p->plain) {
        return (stein_pace){.tolerance = INFINITY, .longest = dt, .h = dt, .next = INFINITY};
    }
    return (stein_pace){
        .tolerance = p->tolerance, .longest = longest * dt, .h = first * dt, .next = INFINITY};
}

/* ---- what a simulation needs ---- */

static fit__reader *reader_make(const fit__problem *p)
{
    size_t nch = 1, nsignal = 1, most = 1;
    for (int s = 0; s < p->nstroke; s++) {
        nch += (size_t)p->stroke[s].nch;
        nsignal += 2 * (size_t)p->stroke[s].nsignal;
        const fit__force_error *e = p->stroke[s].force;
        most = e != NULL && (size_t)e->knots > most ? (size_t)e->knots : most;
    }
    fit__reader *r =
        calloc(1, sizeof *r + sizeof *r->signal * nsignal + sizeof *r->force * most +
                      (2 * sizeof *r->delay + sizeof *r->caught + sizeof *r->next) * nch);
    if (r != NULL) {
        r->signal = (fit__clocked *)(r + 1);
        r->force = (double *)(r->signal + nsignal);
        r->delay = r->force + most;
        r->due = r->delay + nch;
        r->caught = (fit__caught *)(r->due + nch);
        r->next = (int *)(r->caught + nch);
    }
    return r;
}

stein_status fit__bench_make(fit__bench *b, const fit__problem *p, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    size_t np = (size_t)m->np, nq = (size_t)m->nq;
    stein_sim_def def = lab_def(p->model);
    *b = (fit__bench){.sim = NULL};
    def.integrator = STEIN_DP5;
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
    b->x = calloc((size_t)p->nu + 1, sizeof *b->x);
    b->y = calloc((size_t)p->rows + 1, sizeof *b->y);
    b->reader = reader_make(p);
    int memory = b->p && b->q && b->qd && b->shown && b->x && b->y && b->reader &&
                 (p->gain <= 0.0 || b->observer);
    return memory ? STEIN_OK : lab__no_memory(err);
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
    free(b->x);
    free(b->y);
    free(b->reader);
}

/* ---- one stroke ---- */

/* straight from knot to knot, as the force itself */
static double error_at(const fit__clocked *c, double t)
{
    const fit__signal *s = c->signal;
    if (t <= s->t[0] || t >= s->t[s->n - 1]) {
        return c->error[t <= s->t[0] ? 0 : s->n - 1];
    }
    int i = c->at;
    double share = (t - s->t[i]) / (s->t[i + 1] - s->t[i]);
    return c->error[i] + share * (c->error[i + 1] - c->error[i]);
}

static void signal_at(void *ctx, double t, double u[3])
{
    fit__clocked *c = ctx;
    fit__signal_at(c->signal, t + c->shift, &c->at, u);
    u[0] += c->error != NULL ? error_at(c, t + c->shift) : 0.0;
}

/* @param error  of the knots of all signals, NULL: none */
static stein_status bind(stein_sim *sim, const stein_model *m, const fit__stroke *s,
                         fit__clocked *c, const double *error, double shift, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < m->ninput; i++) {
        status = stein_drive(sim, m->inputs[i].name, NULL, NULL, err);
    }
    for (int k = 0; status == STEIN_OK && k < s->nsignal; k++) {
        const fit__signal *signal = &s->signal[k];
        c[k] = (fit__clocked){.signal = signal, .shift = shift};
        c[k].error = error != NULL && !signal->motion ? error + signal->first : NULL;
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

/* what the stroke was set to, other than it says */
static void set_off(const fit__problem *p, fit__bench *b, const fit__stroke *s, const double *x)
{
    for (int k = s->first; k < s->first + s->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        if (u->kind == FIT__SETTING) {
            b->p[u->index] += fit__value(u, x[k]);
        }
    }
}

void fit__apply(const fit__problem *p, const lab_candidate *effect, int amount, const double *x,
                double *to)
{
    const fit__unknown *u = &p->unknown[amount];
    lab_candidate c = *effect;
    for (int k = 0; k < LAB_SIDES; k++) {
        c.side[k].value = c.side[k].param >= 0 ? fit__value(u + 1 + k, x[amount + 1 + k]) : 0.0;
    }
    lab_candidate_apply(&c, fit__value(u, x[amount]), to);
}

/* the same in the records where it acts */
static void apply(const fit__problem *p, const lab_data *data, const lab_candidate *effect,
                  int amount, const double *x, double *to)
{
    if (lab_candidate_acts(effect, data->number)) {
        fit__apply(p, effect, amount, x, to);
    }
}

/* A stroke may state numbers: of an instrument that was corrected for it, of a part that was
 * removed, of a length that was measured. These values are used, whatever a candidate assumes of
 * them. A load or a spring that a stroke sets is what somebody meant to set; effects act on top of
 * it. */
static void put_right(const lab_data *data, double *p)
{
    for (int i = 0; i < data->nset; i++) {
        if (data->set[i].last_word) {
            p[data->set[i].param] = data->set[i].value;
        }
    }
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
    set_off(p, b, s, x);
    for (int i = 0; i < p->naccepted; i++) {
        apply(p, s->data, p->accepted[i], p->first_accepted + FIT__NUMBERS * i, x, b->p);
    }
    if (p->given != NULL) {
        lab_candidate_apply(p->given, p->given_amount, b->p);
    }
    if (p->effect != NULL) {
        apply(p, s->data, p->effect, p->amount, x, b->p);
    }
    put_right(s->data, b->p);
    scatter(p, b, s, x);
    stein_status status = stein_try_all(sim, b->p, err);
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

/* ---- its samples ---- */

/* simulation time of what channel c shows as sample i; INFINITY behind its last one that counts */
static double sample_time(const fit__reader *r, int c, int i)
{
    double T = i < r->s->n ? (1.0 + r->error) * r->s->data->time[i] + r->shift - r->delay[c]
                           : (double)INFINITY;
    return T <= r->horizon ? T : (double)INFINITY;
}

/* sample i of channel c is its next one */
static void expect(fit__reader *r, int c, int i)
{
    r->next[c] = i;
    r->due[c] = sample_time(r, c, i);
}

static double next_time(const fit__reader *r)
{
    double T = INFINITY;
    for (int c = 0; c < r->s->nsampled; c++) {
        T = fmin(T, r->due[c]);
    }
    return T;
}

static void read_sample(fit__bench *b, int c, int i)
{
    fit__reader *r = b->reader;
    const fit__stroke *s = r->s;
    double value = stein_read(b->sim, s->channel[c]) + b->shown[c];
    if (!isfinite(value) && r->status == STEIN_OK) {
        r->status =
            lab__fail(r->err, STEIN_ENONFINITE, "no reading at t = %g s", stein_time(b->sim));
    }
    r->y[c * s->n + i] = value;
    if (c == 0 && b->watch != NULL) {
        b->watch(b->watch_ctx, b->sim, i);
    }
}

/* the samples of the present time. @return the time of the next ones */
static double look(void *ctx, stein_sim *sim)
{
    fit__bench *b = ctx;
    fit__reader *r = b->reader;
    double T = next_time(r);
    (void)sim;
    for (int c = 0; c < r->s->nsampled; c++) {
        if (r->due[c] <= T) {
            read_sample(b, c, r->next[c]);
            expect(r, c, r->next[c] + 1);
        }
    }
    return r->status == STEIN_OK ? next_time(r) : (double)INFINITY;
}

static double last_time(const fit__reader *r)
{
    double T = 0.0;
    for (int c = 0; c < r->s->nsampled; c++) {
        T = fmax(T, sample_time(r, c, r->s->n - 1));
    }
    return fmin(T, r->horizon);
}

/* A recorded input bends at its samples, a force of the bench's at the frames: there the steps end.
 */
static int is_bent(const fit__bench *b)
{
    return b->reader->s->nsignal > 0 || b->force != NULL;
}

/* where the next run ends. @return 0: there is none */
static int next_end(const fit__bench *b, double *t_end)
{
    fit__reader *r = b->reader;
    while (is_bent(b) && r->bend < r->s->n) {
        *t_end = r->s->data->time[r->bend++] + r->shift;
        if (*t_end > stein_time(b->sim) && *t_end < r->t_end) {
            return 1;
        }
    }
    if (!r->over) {
        *t_end = r->t_end;
        r->over = 1;
        return 1;
    }
    return fit__events_next(b, t_end);
}

/* a stroke that takes more trial steps than any real one cannot be simulated */
static void bound_trials(const fit__bench *b)
{
    fit__reader *r = b->reader;
    if (r->status == STEIN_OK && stein_trials(b->sim) > r->most) {
        r->status = lab__fail(r->err, STEIN_ECHATTER,
                              "the simulation is too stiff: steps of %g s at t = %g s", r->pace.h,
                              stein_time(b->sim));
    }
}

int fit__next_run(fit__bench *b, double *t_end, stein_pace **pace)
{
    fit__reader *r = b->reader;
    bound_trials(b);
    *pace = &r->pace;
    r->pace.next = next_time(r);
    return r->status == STEIN_OK && next_end(b, t_end);
}

static stein_status run(fit__bench *b)
{
    stein_status status = STEIN_OK;
    stein_pace *pace;
    double t_end;
    while (status == STEIN_OK && fit__next_run(b, &t_end, &pace)) {
        status = stein_run_adaptive(b->sim, t_end, pace, b->reader->err);
    }
    return status;
}

/* down the ladder: from sample i to sample `next`, at T */
static stein_status pulled(fit__bench *b, int i, int next, double T)
{
    fit__reader *r = b->reader;
    double t = stein_time(b->sim);
    stein_status status = t > 0.0 ? fit__observe(b, r->s, i, next, r->y + i, r->err) : STEIN_OK;
    for (int second = 0; status == STEIN_OK && second < 2; second++) {
        fit__observer_half(b->observer, r->gain, second);
        stein_on_force(b->sim, fit__observer_force, b->observer); // it has changed: evaluate again
        r->pace.next = next_time(r);
        status = stein_run_adaptive(b->sim, second ? T : 0.5 * (t + T), &r->pace, r->err);
    }
    bound_trials(b);
    return status == STEIN_OK ? r->status : status;
}

/* held near the data: instruments do not lag */
static stein_status run_pulled(fit__bench *b)
{
    fit__reader *r = b->reader;
    stein_status status = STEIN_OK;
    int last = -1; // sample that the simulation stands at
    for (int c = 0; c < r->s->nsampled; c++) {
        r->delay[c] = 0.0;
        expect(r, c, 0);
    }
    for (int i = 0; status == STEIN_OK && isfinite(sample_time(r, 0, i)); i++) {
        double T = sample_time(r, 0, i);
        if (i - last < r->stride && isfinite(sample_time(r, 0, i + 1))) {
            continue; // read on the way
        }
        if (T > 0.0) {
            r->pace.next = next_time(r);
            status =
                last >= 0 ? pulled(b, last, i, T) : stein_run_adaptive(b->sim, T, &r->pace, r->err);
        }
        while (status == STEIN_OK && next_time(r) <= T) { // those before the simulation begins
            look(b, b->sim);
            status = r->status;
        }
        last = i;
    }
    return status;
}

/* from its first sample that was not read on the prediction of a channel is the data: no residual
 */
static void fill_beyond(const fit__reader *r)
{
    for (int c = 0; c < r->s->nsampled; c++) {
        size_t at = (size_t)c * (size_t)r->s->n + (size_t)r->next[c];
        memcpy(r->y + at, r->s->y + at, sizeof *r->y * (size_t)(r->s->n - r->next[c]));
    }
}

/* ---- the whole ---- */

/* what is read, when the parameters are known */
static void ready(const fit__problem *p, fit__bench *b, double tau, double *y)
{
    fit__reader *r = b->reader;
    const fit__stroke *s = r->s;
    r->horizon = p->horizon * (1.0 + b->faster); // in the time of the frames
    r->stride = p->stride > 1 ? p->stride : 1;
    r->gain = fmin(p->gain * r->stride, fmax(p->gain, most_gain));
    r->error = (1.0 + (p->clock >= 0 ? b->p[p->clock] : 0.0)) * (1.0 + b->faster) - 1.0;
    r->shift = tau - (s->nsignal > 0 ? 1.0 : 1.0 + r->error) * s->origin;
    r->y = y;
    r->status = STEIN_OK;
    for (int c = 0; c < s->nch; c++) {
        r->delay[c] = s->delay[c] >= 0 ? b->p[s->delay[c]] : 0.0;
    }
    for (int c = 0; c < s->nsampled; c++) {
        expect(r, c, 0);
    }
    fit__events_ready(b);
    r->pace = pace_of(p);
    r->pace.look = look;
    r->pace.ctx = b;
    r->pace.next = next_time(r);
    r->t_end = last_time(r);
    r->t_end = s->nsignal > 0 ? fmax(r->t_end, r->limit) : r->t_end; // on along the inputs
    r->bend = r->over = 0;
    double whole = fmax(r->t_end, r->limit) / r->pace.longest + s->n; // as many runs as frames
    r->most = stein_trials(b->sim) + (long long)(fewest_trials + trials_a_longest * whole);
}

stein_status fit__begin(const fit__problem *p, fit__bench *b, int stroke, const double *x,
                        double *y, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[stroke];
    fit__clocked *c = b->reader->signal;
    double tau = s->tau >= 0 ? fit__value(&p->unknown[s->tau], x[s->tau]) : 0.0;
    b->reader->s = s;
    b->reader->err = err;
    stein_on_force(b->sim, b->force, b->force_ctx);
    double *error = s->force != NULL && s->force->n > 0 ? b->reader->force : NULL;
    if (error != NULL) {
        fit__force_error_at(p, s, x, error);
    }
    stein_status status = bind(b->sim, m, s, c, error, s->origin - tau, err);
    status = status == STEIN_OK ? start(p, b, s, x, b->sim, err) : status;
    if (status == STEIN_OK && p->gain > 0.0) {
        status = bind(b->probe, m, s, c + s->nsignal, error, s->origin - tau, err);
        status = status == STEIN_OK ? start(p, b, s, x, b->probe, err) : status;
        fit__observer_rest(b->observer);
        stein_on_force(b->sim, fit__observer_force, b->observer);
    }
    if (status == STEIN_OK) {
        ready(p, b, tau, y);
    }
    return status;
}

int fit__can_ride(const fit__bench *b)
{
    return !(b->reader->gain > 0.0) && b->force == NULL;
}

stein_status fit__alone(fit__bench *b)
{
    return b->reader->gain > 0.0 && b->reader->s->nsampled > 0 ? run_pulled(b) : run(b);
}

stein_status fit__finish(fit__bench *b, stein_status status)
{
    const fit__reader *r = b->reader;
    status = status == STEIN_OK ? r->status : status;
    if (status == STEIN_OK) {
        fill_beyond(r);
        fit__events_finish(b);
    }
    b->no_memory |= status == STEIN_ENOMEM;
    return status;
}

stein_status fit__simulate(const fit__problem *p, fit__bench *b, int stroke, const double *x,
                           double *y, stein_err *err)
{
    stein_status status = fit__begin(p, b, stroke, x, y, err);
    b->no_memory |= status == STEIN_ENOMEM;
    return status == STEIN_OK ? fit__finish(b, fit__alone(b)) : status;
}
