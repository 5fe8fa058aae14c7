/* SPDX-License-Identifier: GPL-3.0-or-later
 * event_times.c - when the places of a stroke close or open, as its simulation has it.
 *
 * The i-th measured time is compared with the time of the i-th event of its kind since the record's
 * start, T -> t = (T + delay - shift)/(1 + error) on the clock of the data. The core locates events
 * and tells them as they happen, the same to the last bit in lanes and alone.
 *
 * A simulation may have fewer events than were measured. It then continues after the last measured
 * one, up to `beyond` times the length of the record, unless the place has come to rest. With
 * recorded inputs it ends where these end. What is missing until then counts as
 *
 *      T = T_end                              the place is open: the event is still to come
 *      T = max(since, T_end - 2 (d - D))      it has been closed for d = T_end - since > D
 *
 * with D the shortest interval between measured events. An event that moves across T_end changes
 * nothing abruptly, and a ball that bounces once more before it rests does so at the time at which
 * it came to rest before. So the residual of a missing event is how far the motion is from it.
 */
#include <math.h>
#include <string.h>

#include "stroke_reader.h"

static const double beyond = 2.5;  /* lengths of the record: chosen */
static const double margin = 0.1;  /* shortest intervals behind the last one: chosen */
static const double pieces = 8.0;  /* runs of a record without samples: each may be the last one */
static const double at_rest = 2.0; /* shortest intervals: a place that is closed for longer rests */

int fit__row_of(const fit__stroke *s, int k)
{
    const double *t = s->data->time;
    int lo = 0, hi = s->n;
    if (!s->event[k / s->n].is) {
        return k % s->n;
    }
    while (isfinite(s->y[k]) && hi - lo > 1) {
        int mid = lo + (hi - lo) / 2;
        lo = t[mid] <= s->y[k] ? mid : lo;
        hi = t[mid] <= s->y[k] ? hi : mid;
    }
    return lo;
}

const char *fit__name_of(const fit__problem *p, int channel)
{
    const char *name = NULL;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int c = t->nsampled; c < t->nch; c++) {
            int other = name != NULL && strcmp(name, t->event[c].name) != 0;
            name = t->channel[c] != channel ? name : other ? "times of events" : t->event[c].name;
            if (other && t->channel[c] == channel) {
                return name;
            }
        }
    }
    return name != NULL ? name : lab_equations(p->model)->channels[channel].name;
}

/* ---- clocks ---- */

static double to_simulation(const fit__reader *r, int c, double t)
{
    return (1.0 + r->error) * t + r->shift - r->delay[c];
}

static double to_data(const fit__reader *r, int c, double T)
{
    return (T + r->delay[c] - r->shift) / (1.0 + r->error);
}

/* ---- as they come ---- */

/* does an event close (1) or open (-1) the place of a channel? 0: neither */
static int changes(const fit__event *of, const fit__caught *now, const stein_event *e)
{
    if (of->contact >= 0 && e->index == of->contact) {
        return e->kind == STEIN_EVENT_CONTACT_BEGIN ? 1 : -(e->kind == STEIN_EVENT_CONTACT_END);
    }
    if (of->notch >= 0 && e->index == of->notch && e->kind == STEIN_EVENT_PHASE) {
        return (e->phase != 0) - now->closed;
    }
    return 0;
}

static void take(void *ctx, stein_sim *sim, const stein_event *e)
{
    fit__bench *b = ctx;
    fit__reader *r = b->reader;
    const fit__stroke *s = r->s;
    (void)sim;
    for (int c = s->nsampled; c < s->nch; c++) {
        fit__caught *now = &r->caught[c];
        int way = changes(&s->event[c], now, e);
        if (way == 0) {
            continue;
        }
        now->closed = way > 0;
        now->since = way > 0 ? e->time : now->since;
        if ((way < 0) == s->event[c].end && e->time >= r->from && now->found < now->most) {
            r->y[c * s->n + now->found++] = to_data(r, c, e->time);
        }
    }
}

void fit__events_ready(fit__bench *b)
{
    fit__reader *r = b->reader;
    const fit__stroke *s = r->s;
    int any = s->nsampled < s->nch;
    stein_on_event(b->sim, any ? take : NULL, b);
    r->from = (1.0 + r->error) * s->data->time[0] + r->shift;
    r->last = -INFINITY;
    double shortest = INFINITY;
    for (int c = s->nsampled; c < s->nch; c++) {
        const fit__event *of = &s->event[c];
        fit__caught *now = &r->caught[c];
        *now = (fit__caught){.since = stein_time(b->sim)};
        now->closed = of->contact >= 0 ? stein_touches(b->sim, of->contact)
                                       : stein_notch_phase(b->sim, of->notch) > 0;
        shortest = fmin(shortest, of->shortest);
        while (now->most < of->n) {
            double T = to_simulation(r, c, s->y[c * s->n + now->most]);
            if (T > r->horizon) {
                break;
            }
            r->last = fmax(r->last, T);
            now->most++;
        }
    }
    double end = (1.0 + r->error) * s->data->time[s->n - 1] + r->shift;
    r->limit = s->nsignal == 0 || !isfinite(r->last) ? r->from + beyond * (r->last - r->from)
                                                     : fmax(end, r->last + margin * shortest);
}

/* is an event to come, at time T? */
static int awaits(const fit__reader *r, double T)
{
    const fit__stroke *s = r->s;
    for (int c = s->nsampled; c < s->nch; c++) {
        const fit__caught *now = &r->caught[c];
        int rests = T >= r->last && now->closed && T - now->since > at_rest * s->event[c].shortest;
        if (now->found < now->most && !rests) {
            return 1;
        }
    }
    return 0;
}

int fit__events_next(const fit__bench *b, double *t_end)
{
    const fit__reader *r = b->reader;
    double now = stein_time(b->sim), until = now < r->last ? r->last : r->limit;
    if (!awaits(r, now)) {
        return 0;
    }
    *t_end = fmin(now + (r->last - r->from) / pieces, until);
    return *t_end > now;
}

/* the time of an event that the simulation, which ended at T, lacks */
static double missing_time(const fit__event *of, const fit__caught *now, double T)
{
    double closed = T - now->since - of->shortest;
    return now->closed && closed > 0.0 ? fmax(now->since, T - at_rest * closed) : T;
}

void fit__events_finish(fit__bench *b)
{
    const fit__reader *r = b->reader;
    const fit__stroke *s = r->s;
    for (int c = s->nsampled; c < s->nch; c++) {
        const fit__caught *now = &r->caught[c];
        double T = missing_time(&s->event[c], now, stein_time(b->sim));
        for (int i = now->found; i < s->n; i++) {
            r->y[c * s->n + i] = i < now->most ? to_data(r, c, T) : s->y[c * s->n + i];
        }
    }
}

/* ---- those that a simulation lacks ---- */

typedef struct count {
    const fit__problem *p;
    const double *x;
    int *lacking;
} count;

static void count_one(void *ctx, fit__bench *b, int stroke)
{
    const count *c = ctx;
    const fit__stroke *s = &c->p->stroke[stroke];
    if (s->nsampled < s->nch && fit__simulate(c->p, b, stroke, c->x, b->y, NULL) == STEIN_OK) {
        for (int k = s->nsampled; k < s->nch; k++) {
            c->lacking[stroke] += b->reader->caught[k].most - b->reader->caught[k].found;
        }
    }
}

stein_status fit__lacking(const fit__problem *p, const double *x, int *lacking, stein_err *err)
{
    count c = {p, x, lacking};
    int any = 0;
    for (int s = 0; s < p->nstroke; s++) {
        lacking[s] = 0;
        any |= p->stroke[s].nsampled < p->stroke[s].nch;
    }
    return any ? fit__parallel(p, p->nstroke, count_one, &c, err) : STEIN_OK;
}
