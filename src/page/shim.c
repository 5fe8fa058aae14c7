/* SPDX-License-Identifier: MIT
 * shim.c - one mechanism and its simulation, as the script of a page calls them.
 *
 * Compiled to WebAssembly together with src/core and the equations of one mechanism. Numbers pass
 * through arrays of doubles in the module's memory, whose addresses the page_... functions return;
 * they stay where they are. All quantities are SI.
 *
 *   page_open -> values [np] -> page_start      page_advance  steps, with all that is below
 *   page_aim     a parameter turned             page_push     a force input
 *   page_load    the free load                  page_verify   a stroke of the file, hashed
 *
 * A parameter does not jump: it moves towards its aim by at most pace * dt a step. So a loaded
 * surface moves slowly, and the energy added to the mechanism is the work of a hand (force times
 * path), not a jump of stored energy.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"

#ifdef __wasm__
#define EXPORT(name) __attribute__((export_name(#name)))
#else
#define EXPORT(name)
#endif

#define JOIN(a, b)     a##b
#define MODEL_OF(name) JOIN(stein_model_, name)
extern const stein_model MODEL_OF(PAGE_MODEL);

enum { TRACE_ROWS = 4096, PULSE = 4096, STROKE_SIZE = 8 };
/* entries of a stroke; what did not happen is NAN */
enum { OPENED, ESCAPE_TIME, ESCAPE_HEIGHT, IMPACT_TIME, IMPACT_SPEED, IMPACTS, PEAK, TOUCHED };
enum { PULSE_IDLE, PULSE_ON, PULSE_READY };

static const double gap_rate_step = 1e-6; /* [s], as in the lab's strokes */
static const double pulse_tail = 2e-3;    /* the head is gone for so long [s] */

/* a number on its way */
typedef struct dial {
    double now, aim, pace; /* [SI], pace per second */
    int bound;             /* a push: the simulation calls it */
} dial;

/* one page holds one simulation */
static struct page {
    stein_model model; /* with the values of the file */
    stein_param *params;
    double *values; /* [np] */
    stein_sim *sim;
    dial *dial; /* [np] */
    int turning;
    dial *push;      /* [ninput] */
    double *present; /* [nchannel] */
    double *force;   /* [2*(ncontact + nnotch)] normal, tangent */
    double *trace;   /* [TRACE_ROWS*nchannel] the last samples, row n at n % TRACE_ROWS */
    long long rows;
    int every, since; /* steps a sample */
    double stroke[STROKE_SIZE];
    double *hit; /* q, qd at the first impact, room for a q [3*nq] */
    void *kept;  /* a saved state */
    int fresh_hit;
    int string, notch, gap_channel, force_channel;
    double pulse[PULSE]; /* string force, one value a step */
    int npulse, pulse_state, quiet;
    char hash[17];
    stein_err err;
} page;

static int channel_of(stein_read_kind read, int index)
{
    for (int i = 0; i < page.model.nchannel; i++) {
        const stein_channel *c = &page.model.channels[i];
        if (c->read == read && c->index == index && !c->from_rest) {
            return i;
        }
    }
    return -1;
}

/* a channel without the sign the file gives it */
static double plain(int channel)
{
    return page.model.channels[channel].sign * stein_read(page.sim, channel);
}

/** Parameters the simulation will start with [np], at the defaults of the equations; NULL without
 *  memory. The page may change them before page_start. */
EXPORT(page_open) double *page_open(void)
{
    const stein_model *equations = &MODEL_OF(PAGE_MODEL);
    size_t np = (size_t)equations->np;
    page.model = *equations;
    page.params = malloc(sizeof *page.params * (np + 1));
    page.values = malloc(sizeof *page.values * (np + 1));
    for (size_t i = 0; page.params != NULL && page.values != NULL && i < np; i++) {
        page.params[i] = equations->params[i];
        page.values[i] = equations->params[i].value;
    }
    return page.params != NULL ? page.values : NULL;
}

/* a force input; motions are not driven by a page */
static void push_signal(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = ((const dial *)ctx)->now;
    u[1] = u[2] = 0.0;
}

/* A force of nothing is not asked for in every evaluation. */
static void bind(int i)
{
    const stein_input *input = &page.model.inputs[i];
    dial *push = &page.push[i];
    int on = push->now != 0.0 || push->aim != 0.0;
    if (input->kind != STEIN_INPUT_MOTION && on != push->bound) {
        (void)stein_drive(page.sim, input->name, on ? push_signal : NULL, push, &page.err);
        push->bound = on;
    }
}

static void forget_stroke(void)
{
    for (int i = 0; i < STROKE_SIZE; i++) {
        page.stroke[i] = NAN;
    }
    page.stroke[IMPACTS] = page.stroke[PEAK] = page.stroke[TOUCHED] = 0.0;
    page.stroke[OPENED] = stein_time(page.sim);
    page.pulse_state = PULSE_IDLE;
    page.fresh_hit = 0;
}

/* all that a stroke is known by comes from located events, as in the lab */
static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    size_t nq = (size_t)page.model.nq;
    (void)ctx;
    if (event->kind == STEIN_EVENT_IMPACT && event->index == page.string) {
        if (page.stroke[IMPACTS] == 0.0) {
            page.stroke[IMPACT_TIME] = event->time;
            memcpy(page.hit, stein_q(sim), sizeof *page.hit * nq);
            memcpy(page.hit + nq, stein_qd(sim), sizeof *page.hit * nq);
            page.fresh_hit = 1;
            page.pulse_state = PULSE_ON;
            page.npulse = page.quiet = 0;
        }
        page.stroke[IMPACTS] += 1.0;
    } else if (event->kind == STEIN_EVENT_ESCAPEMENT && event->index == page.notch) {
        if (isnan(page.stroke[ESCAPE_TIME])) {
            page.stroke[ESCAPE_TIME] = event->time;
            page.stroke[ESCAPE_HEIGHT] =
                page.gap_channel < 0 ? NAN : fmax(0.0, plain(page.gap_channel));
        }
    } else if (event->kind == STEIN_EVENT_PHASE && event->index == page.notch) {
        page.stroke[TOUCHED] = event->phase >= 1 && event->phase <= 3 ? 1.0 : page.stroke[TOUCHED];
    }
}

/* memory of a simulation that is there. @return 0 without memory */
static int furnish(void)
{
    const stein_model *m = &page.model;
    size_t np = (size_t)m->np, ninput = (size_t)m->ninput, nchannel = (size_t)m->nchannel;
    page.dial = calloc(np + 1, sizeof *page.dial);
    page.push = calloc(ninput + 1, sizeof *page.push);
    page.present = calloc(nchannel, sizeof *page.present);
    page.force = calloc(2 * (size_t)(m->ncontact + m->nnotch) + 1, sizeof *page.force);
    page.trace = calloc(TRACE_ROWS * nchannel, sizeof *page.trace);
    page.hit = calloc(3 * (size_t)m->nq, sizeof *page.hit);
    page.kept = malloc(stein_state_size(page.sim));
    return page.dial != NULL && page.push != NULL && page.present != NULL && page.force != NULL &&
           page.trace != NULL && page.hit != NULL && page.kept != NULL;
}

static void wire(void)
{
    stein_on_event(page.sim, on_event, NULL);
    page.string = page.model.stroke.string;
    page.notch = page.model.stroke.notch;
    page.gap_channel = page.string < 0 ? -1 : channel_of(STEIN_READ_GAP, page.string);
    page.force_channel = page.string < 0 ? -1 : channel_of(STEIN_READ_FORCE, page.string);
}

/** Create the simulation with the values of page_open, at rest, load in place.
 *  @param every  steps a sample of the trace  @return a stein_status; the text is page_message */
EXPORT(page_start) stein_status page_start(double dt, int integrator, int settle, int every)
{
    stein_sim_def def = stein_sim_def_default(&page.model);
    for (int i = 0; i < page.model.np; i++) {
        page.params[i].value = page.values[i];
    }
    page.model.params = page.params;
    page.model.settle = settle;
    def.dt = dt;
    def.integrator = (stein_integrator)integrator;
    stein_status status = stein_sim_create(&page.sim, &page.model, &def, &page.err);
    if (status != STEIN_OK) {
        return status;
    }
    if (!furnish()) {
        return stein__fail(&page.err, STEIN_ENOMEM, "out of memory");
    }
    for (int i = 0; i < page.model.np; i++) {
        page.dial[i].now = page.dial[i].aim = page.values[i];
    }
    page.every = every > 0 ? every : 1;
    wire();
    forget_stroke();
    return STEIN_OK;
}

/** The last failure. */
EXPORT(page_message) const char *page_message(void)
{
    return page.err.msg;
}

/** Back to the initial state, with the parameters at their aims. @return a stein_status */
EXPORT(page_reset) stein_status page_reset(void)
{
    for (int i = 0; i < page.model.np; i++) {
        page.dial[i].now = page.values[i] = page.dial[i].aim;
    }
    page.turning = 0;
    for (int i = 0; i < page.model.ninput; i++) {
        page.push[i].now = page.push[i].aim = 0.0;
        bind(i);
    }
    stein_status status = stein_set_all(page.sim, page.values, &page.err);
    status = status == STEIN_OK ? stein_reset(page.sim, &page.err) : status;
    forget_stroke();
    page.rows = 0;
    return status;
}

/** Turn parameter i towards a value, by at most `pace` a second of the mechanism's time; a pace of
 *  0 jumps. */
EXPORT(page_aim) void page_aim(int i, double value, double pace)
{
    page.dial[i].aim = value;
    page.dial[i].pace = pace > 0.0 ? pace : INFINITY;
    page.turning = 1;
}

/** Where parameter i is on its way. */
EXPORT(page_value) double page_value(int i)
{
    return page.dial[i].now;
}

/** Let force input i rise or fall towards a value, by at most `pace` a second. */
EXPORT(page_push) void page_push(int i, double value, double pace)
{
    page.push[i].aim = value;
    page.push[i].pace = pace;
    bind(i);
}

/** Put the free load on (1) or take it away (0). @return a stein_status */
EXPORT(page_load) stein_status page_load(int on)
{
    if (on) {
        return stein_load_place(page.sim, &page.err);
    }
    stein_load_lift(page.sim);
    return STEIN_OK;
}

/** Forget the last stroke; the next one is new. */
EXPORT(page_stroke_begin) void page_stroke_begin(void)
{
    forget_stroke();
}

/** Move one number; 1 when it is not yet there. */
static int move(dial *d, double dt)
{
    double way = d->aim - d->now, most = d->pace * dt;
    d->now = fabs(way) <= most ? d->aim : d->now + (way > 0.0 ? most : -most);
    return d->now != d->aim;
}

static stein_status turn_dials(double dt)
{
    page.turning = 0;
    for (int i = 0; i < page.model.np; i++) {
        page.turning |= move(&page.dial[i], dt);
        page.values[i] = page.dial[i].now;
    }
    return stein_set_all(page.sim, page.values, &page.err);
}

static double gap_beside(double e)
{
    int nq = page.model.nq;
    double *q = page.hit + 2 * nq, *qd = page.hit + nq;
    for (int j = 0; j < nq; j++) {
        q[j] = page.hit[j] + e * qd[j];
    }
    stein_status status = stein_set_state(page.sim, page.stroke[IMPACT_TIME] + e, q, qd, &page.err);
    return status == STEIN_OK ? plain(page.gap_channel) : NAN;
}

/* closing speed at the impact, as in the lab: a central difference of the gap along the motion */
static stein_status find_impact_speed(void)
{
    page.fresh_hit = 0;
    if (page.gap_channel < 0) {
        return STEIN_OK;
    }
    stein_save(page.sim, page.kept);
    double before = gap_beside(-gap_rate_step), after = gap_beside(gap_rate_step);
    page.stroke[IMPACT_SPEED] = (before - after) / (2.0 * gap_rate_step);
    return stein_restore(page.sim, page.kept, &page.err);
}

static void note_pulse(double force)
{
    page.pulse[page.npulse++] = force;
    page.quiet = force > 0.0 ? 0 : page.quiet + 1;
    if (page.quiet * stein_dt(page.sim) > pulse_tail || page.npulse == PULSE) {
        page.pulse_state = PULSE_READY;
    }
}

static stein_status watch(void)
{
    stein_status status = page.fresh_hit ? find_impact_speed() : STEIN_OK;
    if (page.force_channel >= 0) {
        double force = stein_touches(page.sim, page.string) ? plain(page.force_channel) : 0.0;
        page.stroke[PEAK] = fmax(page.stroke[PEAK], force);
        if (page.pulse_state == PULSE_ON) {
            note_pulse(force);
        }
    }
    return status;
}

static void sample(void)
{
    int n = page.model.nchannel;
    double *row = page.trace + (size_t)(page.rows++ % TRACE_ROWS) * (size_t)n;
    for (int i = 0; i < n; i++) {
        row[i] = stein_read(page.sim, i);
    }
}

/** So many steps, with parameters and pushes on their way. @return a stein_status */
EXPORT(page_advance) stein_status page_advance(int steps)
{
    double dt = stein_dt(page.sim);
    stein_status status = STEIN_OK;
    for (int n = 0; status == STEIN_OK && n < steps; n++) {
        status = page.turning ? turn_dials(dt) : STEIN_OK;
        for (int i = 0; i < page.model.ninput; i++) {
            if (page.push[i].bound && !move(&page.push[i], dt)) {
                bind(i);
            }
        }
        status = status == STEIN_OK ? stein_step(page.sim, &page.err) : status;
        status = status == STEIN_OK ? watch() : status;
        if (status == STEIN_OK && ++page.since >= page.every) {
            page.since = 0;
            sample();
        }
    }
    return status;
}

EXPORT(page_time) double page_time(void)
{
    return stein_time(page.sim);
}

/** Largest speed of a joint [rad/s or m/s], INFINITY while a hand is at work. */
EXPORT(page_stir) double page_stir(void)
{
    const double *qd = stein_qd(page.sim);
    double most = page.turning ? INFINITY : 0.0;
    for (int j = 0; j < page.model.nq; j++) {
        most = fmax(most, fabs(qd[j]));
    }
    for (int i = 0; i < page.model.ninput; i++) {
        most = page.push[i].now != page.push[i].aim ? INFINITY : most;
    }
    return most;
}

/** Coordinates [nq]. */
EXPORT(page_q) const double *page_q(void)
{
    return stein_q(page.sim);
}

/** Output channels now [nchannel]. */
EXPORT(page_channels) const double *page_channels(void)
{
    for (int i = 0; i < page.model.nchannel; i++) {
        page.present[i] = stein_read(page.sim, i);
    }
    return page.present;
}

/** Normal and tangential force of every contact, then of every notch [N], two numbers each. */
EXPORT(page_forces) const double *page_forces(void)
{
    const stein_model *m = &page.model;
    (void)stein__refresh(page.sim, &page.err);
    memset(page.force, 0, sizeof *page.force * 2 * (size_t)(m->ncontact + m->nnotch));
    for (int i = 0; i < m->nspot; i++) {
        double *f = page.force + 2 * m->spots[i].contact;
        f[0] += page.sim->spot[i].normal;
        f[1] += page.sim->spot[i].tangent;
    }
    for (int i = 0; i < m->nnotch; i++) {
        double *f = page.force + 2 * (m->ncontact + i);
        f[0] = page.sim->beak[i].normal;
        f[1] = page.sim->beak[i].tangent;
    }
    return page.force;
}

EXPORT(page_load_present) int page_load_present(void)
{
    return stein_load_present(page.sim);
}

/** Phase of the stroke's notch, 0 without one; 1 when its beak is under the roof. */
EXPORT(page_phase) int page_phase(void)
{
    return page.notch < 0 ? 0 : stein_notch_phase(page.sim, page.notch);
}
EXPORT(page_armed) int page_armed(void)
{
    return page.notch < 0 ? 1 : stein_notch_armed(page.sim, page.notch);
}

/** The stroke so far: opened, escapement's time and height, impact's time and speed, impacts, peak
 *  force, touched. */
EXPORT(page_stroke) const double *page_stroke(void)
{
    return page.stroke;
}

/** The last samples [TRACE_ROWS][nchannel], and how many there were in all. */
EXPORT(page_trace) const double *page_trace(void)
{
    return page.trace;
}
EXPORT(page_trace_rows) double page_trace_rows(void)
{
    return (double)page.rows;
}

/** The force on the string since the impact, one value a step; its length when it is complete, else
 *  0. It is reported once. */
EXPORT(page_pulse) const double *page_pulse(void)
{
    return page.pulse;
}
EXPORT(page_pulse_length) int page_pulse_length(void)
{
    int ready = page.pulse_state == PULSE_READY;
    page.pulse_state = ready ? PULSE_IDLE : page.pulse_state;
    return ready ? page.npulse : 0;
}

/** FNV-1a of 64 bits, as 16 hexadecimal digits. */
static const char *hash_of(const unsigned char *bytes, size_t n)
{
    unsigned long long h = 0xcbf29ce484222325u;
    for (size_t i = 0; i < n; i++) {
        h = (h ^ bytes[i]) * 0x100000001b3u;
    }
    for (int i = 15; i >= 0; i--, h >>= 4) {
        page.hash[i] = "0123456789abcdef"[h & 15u];
    }
    return page.hash;
}

/** The mechanism with its file's numbers, run from its initial state to `until` beside the shown
 *  simulation: hash of the state there, "" after a failure. */
EXPORT(page_verify) const char *page_verify(double until)
{
    stein_sim *sim = NULL;
    stein_sim_def def = page.sim->def;
    page.hash[0] = '\0';
    stein_status status = stein_sim_create(&sim, &page.model, &def, &page.err);
    status = status == STEIN_OK ? stein_run(sim, until, &page.err) : status;
    unsigned char *state = status == STEIN_OK ? malloc(stein_state_size(sim)) : NULL;
    if (state != NULL) {
        stein_save(sim, state);
        (void)hash_of(state, stein_state_size(sim));
    }
    free(state);
    stein_sim_destroy(sim);
    return page.hash;
}
