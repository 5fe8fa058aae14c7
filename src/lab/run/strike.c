/* SPDX-License-Identifier: GPL-3.0-or-later
 * strike.c - one stroke and its results: escapement, impact, outcome.
 *
 * Everything with a time comes from the core's located events, not from samples, so it does not
 * depend on the sampling. At an event only positions are read. What needs another state (the
 * closing speed) is computed after the step, from the coordinates kept at the event, by a central
 * difference of the gap along the motion
 *
 *      dgap/dt = (gap(t + e, q + e qd) - gap(t - e, q - e qd)) / 2e,     e = 1 us
 *
 * with an error of order e^2 relative to the time scale of the stroke (1e-8). A channel for the
 * gap's rate would have to exist in every mechanism file. The peak force is the vertex of the
 * parabola through the highest step and its neighbours.
 *
 * A run never steps by itself: it returns the next operation of the simulation (lab__runner_next),
 * so that many runs can go side by side in lanes (batch.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run.h"

static const double gap_rate_step = 1e-6; /* [s] */
static const double hammer_at_rest = 0.5; /* [rad/s] */
/* of controlled steps: the first one, in steps of the file; between two looks at the string's force
 * [s] */
static const double first_step = 0.1, force_every = 10e-6;
/* The motion after the load is lifted, on the side: so long, or until nothing moves [s, rad/s or
 * m/s]. That is asked at every look, and has to be so at several: an action passes through rest. */
static const double rearm_time = 0.5, still = 1e-3, look_every = 5e-3;
enum { LOOKS_AT_REST = 4 };

typedef struct sample3 {
    double t, f;
} sample3;

typedef struct lab__runner {
    stein_sim *sim;
    const lab_stroke_def *def;
    lab_stroke stroke;
    int as_stroke; /* 0: a motion without a verdict */
    int lifted;    /* the load is gone, or will not be lifted */
    enum { PLAYING, REARMING, OVER } phase;
    double rearmed;    /* end of the motion on the side [s] */
    double look;       /* time of the next look [s] */
    int at_rest;       /* looks in a row at which nothing moved */
    double start;      /* [s] */
    double dt;         /* of the simulation [s] */
    double due;        /* time of the next sample [s] */
    int string, notch; /* contact and notch */
    int gap, force;    /* channels */
    int over;          /* the load was lifted: the following motion is no part of the stroke */
    int touched;       /* beak was in contact under the roof */
    double *hit;       /* q, qd at the first impact, room for a q [3*nq] */
    void *kept;        /* saved state */
    stein_pace pace;   /* of controlled steps; tolerance 0: they are fixed */
    sample3 last[3];   /* string force at the last three steps */
    int nlast;
} run;

const char *lab_outcome_text(lab_outcome outcome)
{
    static const char *const text[] = {"struck", "missed_notch", "no_escapement", "no_impact"};
    return text[outcome];
}

lab_stroke_def lab_stroke_def_default(const stein_model *model)
{
    return (lab_stroke_def){.until = model->until, .release = NAN, .every = 0.0};
}

int lab__channel_of(const stein_model *model, stein_read_kind read, int index)
{
    for (int i = 0; i < model->nchannel; i++) {
        const stein_channel *c = &model->channels[i];
        if (c->read == read && c->index == index && !c->from_rest) {
            return i;
        }
    }
    return -1;
}

/* a channel without the sign the file gives it */
static double read_plain(stein_sim *sim, int channel)
{
    return stein_sim_model(sim)->channels[channel].sign * stein_read(sim, channel);
}

/* ---- events ---- */

static void on_escapement(run *r, double t)
{
    if (!r->stroke.escaped) {
        r->stroke.escaped = 1;
        r->stroke.escape_time = t;
        r->stroke.escape_height = fmax(0.0, read_plain(r->sim, r->gap));
        r->stroke.forced_escapement = r->stroke.impacts > 0;
    }
}

static int is_controlled(const run *r)
{
    return r->pace.tolerance > 0.0;
}

static void on_impact(run *r, double t)
{
    size_t nq = (size_t)stein_sim_model(r->sim)->nq;
    if (r->stroke.impacts++ == 0) {
        r->stroke.impact_time = t;
        memcpy(r->hit, stein_q(r->sim), sizeof *r->hit * nq);
        memcpy(r->hit + nq, stein_qd(r->sim), sizeof *r->hit * nq);
    }
}

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    run *r = ctx;
    double t = event->time - r->start;
    if (r->def->event != NULL) {
        r->def->event(r->def->ctx, sim, event);
    }
    if (r->over) {
        return;
    }
    if (event->kind == STEIN_EVENT_IMPACT && event->index == r->string) {
        on_impact(r, t);
        r->pace.next = event->time;
    } else if (event->kind == STEIN_EVENT_ESCAPEMENT && event->index == r->notch) {
        on_escapement(r, t);
    } else if (event->kind == STEIN_EVENT_PHASE && event->index == r->notch) {
        r->touched |= event->phase >= 1 && event->phase <= 3;
    }
}

/* ---- figures ---- */

static stein_status gap_beside(run *r, double e, double *gap, stein_err *err)
{
    int nq = stein_sim_model(r->sim)->nq;
    double *q = r->hit + 2 * nq, *qd = r->hit + nq;
    for (int j = 0; j < nq; j++) {
        q[j] = r->hit[j] + e * qd[j];
    }
    stein_status status = stein_set_state(r->sim, r->start + r->stroke.impact_time + e, q, qd, err);
    *gap = status == STEIN_OK ? read_plain(r->sim, r->gap) : NAN;
    return status;
}

/* closing speed at the first impact; the simulation comes back to its state */
static stein_status find_impact_speed(run *r, stein_err *err)
{
    double before = NAN, after = NAN;
    stein_save(r->sim, r->kept);
    stein_status status = gap_beside(r, -gap_rate_step, &before, err);
    if (status == STEIN_OK) {
        status = gap_beside(r, gap_rate_step, &after, err);
    }
    stein_status back = stein_restore(r->sim, r->kept, err);
    r->stroke.impact_speed = (before - after) / (2.0 * gap_rate_step);
    return status == STEIN_OK ? back : status;
}

/* height of the parabola through three samples where the middle one is highest */
static double vertex(const sample3 s[3])
{
    double u = s[0].t - s[1].t, v = s[2].t - s[1].t;
    double fu = s[0].f - s[1].f, fv = s[2].f - s[1].f;
    double det = u * v * (v - u);
    double slope = (fu * v * v - fv * u * u) / det, curve = (fv * u - fu * v) / det;
    return curve < 0.0 ? s[1].f - 0.25 * slope * slope / curve : s[1].f;
}

static void note_force(run *r)
{
    sample3 now = {stein_time(r->sim), read_plain(r->sim, r->force)};
    r->stroke.peak_string_force = fmax(r->stroke.peak_string_force, now.f);
    if (r->nlast > 0 && r->last[r->nlast - 1].f == 0.0) {
        r->last[r->nlast - 1].t = now.t - r->dt; // without a force not every step is inspected
    }
    if (r->nlast == 3) {
        memmove(r->last, r->last + 1, 2 * sizeof *r->last);
        r->nlast = 2;
    }
    r->last[r->nlast++] = now;
    const sample3 *s = r->last;
    if (r->nlast == 3 && s[1].f > 0.0 && s[1].f >= s[0].f && s[1].f >= s[2].f && s[0].t < s[1].t &&
        s[1].t < s[2].t) {
        r->stroke.peak_string_force = fmax(r->stroke.peak_string_force, vertex(s));
    }
}

/* the string's force, seen between steps of controlled error while it is touched */
static double look_at_force(void *ctx, stein_sim *sim)
{
    run *r = ctx;
    if (r->over) {
        return INFINITY;
    }
    note_force(r);
    if (stein_touches(sim, r->string)) {
        return stein_time(sim) + force_every;
    }
    r->nlast = 0;
    return INFINITY;
}

/* ---- running ---- */

/* offer a sample when it is due, by whole steps */
static stein_status offer(run *r, int last)
{
    const lab_stroke_def *def = r->def;
    double t = stein_time(r->sim);
    if (def->sample == NULL || (!last && t < r->due - 1e-6 * r->dt)) {
        return STEIN_OK;
    }
    while (def->every > 0.0 && r->due - 1e-6 * r->dt <= t) {
        r->due += def->every;
    }
    return def->sample(def->ctx, r->sim);
}

static double lift_time(const run *r)
{
    return r->start + r->def->release;
}

/* where the present part of the run ends [s] */
static double stop_of(const run *r)
{
    return r->phase == REARMING ? r->rearmed : r->lifted ? r->start + r->def->until : lift_time(r);
}

/* between two steps; *last: the motion is at its end */
static stein_status pause_at(run *r, int *last, stein_err *err)
{
    *last = stein_time(r->sim) >= r->start + r->def->until;
    if (!r->lifted && stein_time(r->sim) >= lift_time(r)) {
        stein_load_lift(r->sim);
        r->lifted = r->over = 1;
    }
    if (r->as_stroke && !r->over && !is_controlled(r)) {
        note_force(r);
    }
    stein_status status = offer(r, *last);
    return status == STEIN_OK ? STEIN_OK
                              : lab__fail(err, status, "the recording stopped the run: %s",
                                          stein_status_text(status));
}

static stein_status check(const stein_sim *sim, const lab_stroke_def *def, stein_err *err)
{
    if (!(def->until > 0.0) || !isfinite(def->until)) {
        return lab__fail(err, STEIN_EINVAL,
                         "lab_stroke_def.until is %g s: expected a positive duration", def->until);
    }
    if (!(def->every >= 0.0) || !isfinite(def->every)) {
        return lab__fail(err, STEIN_EINVAL, "lab_stroke_def.every is %g s: expected an interval",
                         def->every);
    }
    if (!isnan(def->release) && !(def->release >= 0.0 && def->release <= def->until)) {
        return lab__fail(err, STEIN_EINVAL,
                         "lab_stroke_def.release is %g s: expected a time from 0 "
                         "to the end at %g s",
                         def->release, def->until);
    }
    if (!isnan(def->release) && stein_sim_model(sim)->load.body < 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%s\" has no load to release",
                         stein_sim_model(sim)->name);
    }
    return STEIN_OK;
}

/* memory and start of a run */
static stein_status prepare(run *r, stein_sim *sim, const lab_stroke_def *def, stein_err *err)
{
    const stein_model *model = stein_sim_model(sim);
    *r = (run){.sim = sim, .def = def, .start = stein_time(sim), .string = -1, .notch = -1};
    stein_status status = check(sim, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    r->dt = stein_dt(sim);
    r->due = r->start;
    r->lifted = !(lift_time(r) <= r->start + def->until);
    r->hit = malloc(sizeof *r->hit * 3 * (size_t)model->nq);
    r->kept = malloc(stein_state_size(sim));
    return r->hit != NULL && r->kept != NULL ? STEIN_OK : lab__no_memory(err);
}

/* ---- strokes ---- */

static int is_ready(run *r)
{
    const stein_model *model = stein_sim_model(r->sim);
    int beak = r->notch < 0 ? -1 : model->notches[r->notch].beak;
    int hammer = beak < 0 ? -1 : model->frames[beak].body;
    return hammer >= 0 && !stein_load_present(r->sim) && stein_notch_armed(r->sim, r->notch) &&
           fabs(stein_qd(r->sim)[hammer]) < hammer_at_rest;
}

/* would it re-arm when the load is lifted now? A motion on the side follows */
static void begin_rearming(run *r)
{
    if (!stein_load_present(r->sim) || r->notch < 0) {
        r->stroke.rearmed = is_ready(r);
        r->phase = OVER;
        return;
    }
    stein_save(r->sim, r->kept);
    stein_load_lift(r->sim);
    r->phase = REARMING;
    r->rearmed = stein_time(r->sim) + rearm_time;
    r->look = stein_time(r->sim) + look_every;
}

static int is_still(const run *r)
{
    const double *qd = stein_qd(r->sim);
    int moves = 0;
    for (int j = 0; j < stein_sim_model(r->sim)->nq; j++) {
        moves |= !(fabs(qd[j]) < still);
    }
    return !moves;
}

/* the motion on the side, at its next time; @return is it over? */
static int watch_rearming(run *r)
{
    double t = stein_time(r->sim);
    if (t >= r->look) {
        r->at_rest = is_still(r) ? r->at_rest + 1 : 0;
        r->look += look_every;
    }
    return t >= r->rearmed || r->at_rest >= LOOKS_AT_REST;
}

static stein_status end_rearming(run *r, stein_status status, stein_err *err)
{
    r->stroke.rearmed = status == STEIN_OK && is_ready(r);
    r->phase = OVER;
    stein_status back = stein_restore(r->sim, r->kept, err);
    return status == STEIN_OK ? back : status;
}

static lab_outcome judge(const run *r)
{
    if (r->notch >= 0 && !r->touched) {
        return LAB_MISSED_NOTCH;
    }
    if (r->notch >= 0 && !r->stroke.escaped) {
        return LAB_NO_ESCAPEMENT;
    }
    return r->stroke.impacts > 0 ? LAB_STRUCK : LAB_NO_IMPACT;
}

/* required names of the mechanism file for a stroke */
static stein_status find_channels(run *r, stein_err *err)
{
    const stein_model *model = stein_sim_model(r->sim);
    r->string = model->stroke.string;
    r->notch = model->stroke.notch;
    if (r->string < 0) {
        return lab__fail(err, STEIN_EINVAL,
                         "\"%s\" names no stroke (stroke: {string: ..., notch: ...})", model->name);
    }
    r->gap = lab__channel_of(model, STEIN_READ_GAP, r->string);
    r->force = lab__channel_of(model, STEIN_READ_FORCE, r->string);
    if (r->gap < 0 || r->force < 0) {
        return lab__fail(err, STEIN_EINVAL,
                         "a stroke of \"%s\" needs an output {contact: %s, read: %s}", model->name,
                         model->contacts[r->string].name, r->gap < 0 ? "gap" : "force");
    }
    return STEIN_OK;
}

/* ready to watch a stroke */
static stein_status begin_stroke(run *r, stein_err *err)
{
    stein_status status = find_channels(r, err);
    if (status != STEIN_OK) {
        return status;
    }
    int phase = stein_notch_phase(r->sim, r->notch);
    r->as_stroke = 1;
    r->touched = phase >= 1 && phase <= 3;
    r->stroke = (lab_stroke){.escape_time = NAN,
                             .escape_height = NAN,
                             .impact_time = NAN,
                             .impact_speed = NAN,
                             .blow = read_plain(r->sim, r->gap)};
    stein_on_event(r->sim, on_event, r);
    if (is_controlled(r)) {
        r->pace.look = look_at_force;
        r->pace.next = stein_touches(r->sim, r->string) ? r->start : (double)INFINITY;
    }
    return STEIN_OK;
}

/* the motion is at its end, or failed: remaining results */
static stein_status end_motion(run *r, stein_status status, stein_err *err)
{
    stein_on_event(r->sim, NULL, NULL);
    if (!r->as_stroke || status != STEIN_OK) {
        r->phase = OVER;
        return status;
    }
    if (r->stroke.impacts > 0) {
        status = find_impact_speed(r, err);
    }
    if (status == STEIN_OK) {
        begin_rearming(r);
    }
    return status;
}

stein_status lab__runner_new(lab__runner **out, stein_sim *sim, const lab_stroke_def *def,
                             const lab__steps *steps, int as_stroke, stein_err *err)
{
    run *r = malloc(sizeof *r);
    if (r == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = prepare(r, sim, def, err);
    if (status == STEIN_OK && steps != NULL) {
        r->pace = (stein_pace){.tolerance = steps->tolerance,
                               .longest = steps->longest,
                               .h = first_step * r->dt,
                               .next = INFINITY,
                               .ctx = r};
    }
    if (status == STEIN_OK && as_stroke) {
        status = begin_stroke(r, err);
    }
    if (status == STEIN_OK && !as_stroke) {
        stein_on_event(sim, def->event != NULL ? on_event : NULL, r);
    }
    if (status != STEIN_OK) {
        lab__runner_drop(r);
        return status;
    }
    *out = r;
    return STEIN_OK;
}

void lab__runner_drop(lab__runner *r)
{
    if (r != NULL) {
        free(r->hit);
        free(r->kept);
        free(r);
    }
}

/* the next time at which something is asked [s] */
static double next_look(const lab__runner *r)
{
    return r->phase == REARMING ? fmin(r->look, r->rearmed) : stop_of(r);
}

long lab__runner_steps(const lab__runner *r)
{
    double n = (next_look(r) - stein_time(r->sim)) / r->dt - 1.0; // rounding may hide the last one
    return lab__runner_needs(r) == LAB_NOTHING ? (long)fmin(fmax(n, 1.0), 1e6) : 1;
}

static int whole_step_left(const lab__runner *r)
{
    return stop_of(r) - stein_time(r->sim) > r->dt * (1.0 + 1e-6);
}

lab__need lab__runner_needs(const lab__runner *r)
{
    if (!whole_step_left(r) || r->def->sample != NULL) {
        return LAB_TO_CHANGE;
    }
    if (r->phase == REARMING) {
        return stein_time(r->sim) < r->look     ? LAB_NOTHING
               : r->at_rest + 1 < LOOKS_AT_REST ? LAB_TO_LOOK
                                                : LAB_TO_CHANGE; // it may be over
    }
    return r->as_stroke && stein_touches(r->sim, r->string) ? LAB_TO_LOOK : LAB_NOTHING;
}

stein_status lab__runner_next(lab__runner *r, stein_status status, double *stop, stein_err *err)
{
    int last = 0;
    if (r->phase == PLAYING && status == STEIN_OK) {
        status = pause_at(r, &last, err);
    }
    if (r->phase == PLAYING && (status != STEIN_OK || last)) {
        status = end_motion(r, status, err);
    } else if (r->phase == REARMING && (status != STEIN_OK || watch_rearming(r))) {
        status = end_rearming(r, status, err);
    }
    if (status != STEIN_OK) {
        r->phase = OVER;
    }
    // one step, or the rest if that is shorter
    *stop = r->phase == OVER     ? NAN
            : is_controlled(r)   ? next_look(r)
            : whole_step_left(r) ? INFINITY
                                 : stop_of(r);
    return status;
}

stein_pace *lab__runner_pace(lab__runner *r)
{
    return &r->pace;
}

void lab__runner_stroke(lab__runner *r, lab_stroke *stroke)
{
    if (r->stroke.escaped && r->stroke.impacts > 0 && !r->stroke.forced_escapement) {
        r->stroke.free_flight = r->stroke.impact_time - r->stroke.escape_time;
    }
    r->stroke.outcome = judge(r);
    *stroke = r->stroke;
}

/* a run alone; stroke NULL: a motion */
static stein_status play(stein_sim *sim, const lab_stroke_def *def, lab_stroke *stroke,
                         stein_err *err)
{
    run *r = NULL;
    double stop = INFINITY;
    stein_status status = lab__runner_new(&r, sim, def, NULL, stroke != NULL, err);
    if (status != STEIN_OK) {
        return status;
    }
    status = lab__runner_next(r, status, &stop, err);
    while (!isnan(stop)) {
        status = isinf(stop) ? stein_step(sim, err) : stein_run(sim, stop, err);
        status = lab__runner_next(r, status, &stop, err);
    }
    if (status == STEIN_OK && stroke != NULL) {
        lab__runner_stroke(r, stroke);
    }
    lab__runner_drop(r);
    return status;
}

stein_status lab_simulate(stein_sim *sim, const lab_stroke_def *def, stein_err *err)
{
    return play(sim, def, NULL, err);
}

stein_status lab_strike(stein_sim *sim, const lab_stroke_def *def, lab_stroke *stroke,
                        stein_err *err)
{
    return play(sim, def, stroke, err);
}
