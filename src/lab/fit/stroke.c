/* SPDX-License-Identifier: GPL-3.0-or-later
 * stroke.c - a record as the fit uses it: samples, noise, inputs as signals, times of events.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

static const double off_lattice = 0.1; /* of a step */
static const double locked = 0.4; /* noise in steps: step / sqrt(12) and as much of other noise */

static void tell(const fit__problem *p, const char *file, const char *what)
{
    if (p->def->report != NULL) {
        char *line = lab__text("%s: %s", file, what);
        if (line != NULL) {
            p->def->report(p->def->ctx, line);
        }
        free(line);
    }
}

/* noise of a channel; what is no noise at all still must not weigh infinitely */
static double noise_of(const lab_channel_audit *a)
{
    double range = a->high - a->low;
    double least = 1e-9 * fmax(fabs(a->high), fabs(a->low)) + 1e-7 * range;
    return isfinite(a->noise) && a->noise > least ? a->noise : fmax(least, 1e-30);
}

/* quantisation step of a channel whose noise is smaller than `locked` steps; 0: it is not */
static double locked_step(const lab_channel_audit *a)
{
    return a->noise < locked * a->step ? a->step : 0.0;
}

/* Samples around one that stay within a step of its reading y. */
typedef struct stay {
    double y;
    int from, end, readings; /* readings: how many different ones, 1 to 3 */
} stay;

static stay stay_of(const double *y, int n, int i, double step)
{
    stay s = {y[i], i, i + 1, 1};
    int above = 0, below = 0;
    while (s.from > 0 && fabs(y[s.from - 1] - y[i]) < 1.5 * step) {
        s.from--;
    }
    while (s.end < n && fabs(y[s.end] - y[i]) < 1.5 * step) {
        s.end++;
    }
    for (int k = s.from; k < s.end; k++) {
        above |= y[k] - y[i] > 0.5 * step;
        below |= y[i] - y[k] > 0.5 * step;
    }
    s.readings += above + below;
    return s;
}

/* A reading that an encoder repeats n times says one thing, that the value was within its step:
 * each counts as 1/n. Taken as n samples, the rounding of a slow motion, which is the same for all
 * of them, would be taken for an effect. How often a reading is repeated is counted over the time
 * that the motion takes for it and its neighbours, n = samples / readings. Where a value lies
 * between two readings they alternate, each is half a step off, and none is repeated. Counted
 * separately, these largest errors would weigh most, and a true model would leave more than noise.
 * @return sum of what they count as */
static double share_out(const double *y, int n, double step, double *share)
{
    enum { KEPT = 4 }; // of alternating readings
    stay kept[KEPT] = {{0}};
    double all = 0.0;
    for (int i = 0, oldest = 0; i < n; i++) {
        int k = 0;
        while (k < KEPT && step > 0.0 &&
               !(kept[k].from <= i && i < kept[k].end && fabs(kept[k].y - y[i]) < 0.5 * step)) {
            k++;
        }
        if (k == KEPT && step > 0.0 && isfinite(y[i])) {
            k = oldest++ % KEPT;
            kept[k] = stay_of(y, n, i, step);
        }
        double repeated =
            k < KEPT && step > 0.0 ? (double)(kept[k].end - kept[k].from) / kept[k].readings : 1.0;
        share[i] = isfinite(y[i]) ? 1.0 / sqrt(fmax(1.0, repeated)) : 0.0;
        all += share[i] * share[i];
    }
    return all;
}

/* Do all samples of a channel lie on one lattice, and count? */
static int lies_on(const fit__stroke *s, int c, double step)
{
    const double *y = s->y + c * s->n, *share = s->share + c * s->n;
    double first = NAN;
    int yes = 1;
    for (int i = 0; i < s->n; i++) {
        first = isnan(first) ? y[i] : first;
        double at = (y[i] - first) / step;
        yes &= !isfinite(y[i]) || (share[i] > 0.0 && fabs(at - round(at)) < off_lattice);
    }
    return yes;
}

/* the largest step that any record shows of an output */
static double step_of(const fit__problem *p, int channel)
{
    double step = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nsampled; c++) {
            const fit__stroke *t = &p->stroke[s];
            step = t->channel[c] == channel ? fmax(step, t->step[c]) : step;
        }
    }
    return step;
}

/* A record in which an encoder hardly turns shows neither its noise nor its step: those of the
 * other records are its own, too. */
void fit__share_steps(fit__problem *p)
{
    for (int s = 0; s < p->nstroke; s++) {
        fit__stroke *t = &p->stroke[s];
        for (int c = 0; c < t->nsampled; c++) {
            double step = step_of(p, t->channel[c]), noise = step / sqrt(12.0),
                   *y = t->y + c * t->n;
            if (t->given[c] || t->step[c] > 0.0 || !(t->noise[c] < noise) || !lies_on(t, c, step)) {
                continue;
            }
            t->noise[c] = t->audited[c] = noise;
            t->step[c] = step;
            double *share = t->share + c * t->n, was = lab__dot(share, share, (size_t)t->n);
            int more = (int)(lround(share_out(y, t->n, step, share)) - lround(was));
            t->samples += more;
            p->samples += more;
        }
    }
}

static int delay_of(const stein_model *m, const lab_column *c)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.sensor.delay", c->name);
    return stein_find_param(m, name);
}

static stein_status take_column(fit__problem *p, fit__stroke *s, const lab_audit *audit, int column,
                                stein_err *err)
{
    const lab_column *c = &s->data->column[column];
    const stein_model *m = lab_equations(p->model);
    if (c->role == LAB_INPUT) {
        int motion = m->inputs[c->index].kind == STEIN_INPUT_MOTION;
        double noise = audit->channel[column].noise;
        double hz = fit__band_of(p, s->data, c->index);
        return fit__signal_make(&s->signal[s->nsignal++], c->index, motion, s->data, c,
                                isfinite(noise) ? noise : 0.0, hz, err);
    }
    if (c->role == LAB_EVENT_TIMES || m->channels[c->index].read == STEIN_READ_TIME) {
        return STEIN_OK;
    }
    int k = s->nch++;
    s->channel[k] = c->index;
    s->delay[k] = delay_of(m, c);
    s->given[k] = isfinite(c->noise);
    s->noise[k] = s->audited[k] = noise_of(&audit->channel[column]);
    s->step[k] = audit->channel[column].step;
    if (fit__widen_noise(p, s, k, err) != STEIN_OK) {
        return STEIN_ENOMEM;
    }
    for (int i = 0; i < s->n; i++) {
        s->y[k * s->n + i] = c->present[i] ? c->value[i] : NAN;
    }
    s->samples += (int)lround(share_out(s->y + k * s->n, s->n, locked_step(&audit->channel[column]),
                                        s->share + k * s->n));
    const stein_channel *channel = &m->channels[c->index];
    if (stein_reads_place((int)channel->read) && strcmp(channel->unit, "rad") == 0) {
        fit__unwrap(s->y + k * s->n, s->n);
    }
    return STEIN_OK;
}

/* Times of events come behind the channels with samples, as readings of the time: nothing that
 * looks for places, speeds or forces finds them. */
static void take_events(fit__problem *p, fit__stroke *s, const lab_audit *audit, int column)
{
    const lab_column *c = &s->data->column[column];
    const stein_model *m = lab_equations(p->model);
    int k = s->nch, channel = 0;
    if (c->role != LAB_EVENT_TIMES || c->samples == 0) {
        return;
    }
    while (m->channels[channel].read != STEIN_READ_TIME) {
        channel++;
    }
    fit__event *e = &s->event[k];
    *e = (fit__event){.is = 1,
                      .end = c->events == LAB_EVENTS_END,
                      .contact = c->contact,
                      .notch = c->notch,
                      .name = c->name,
                      .n = c->samples,
                      .shortest = INFINITY};
    s->channel[k] = channel;
    s->delay[k] = delay_of(m, c);
    s->given[k] = isfinite(c->noise);
    s->noise[k] = s->audited[k] = audit->channel[column].noise;
    double before = s->data->time[0];
    for (int i = 0; i < s->n; i++) {
        s->y[k * s->n + i] = i < e->n ? c->value[i] : (double)NAN;
        s->share[k * s->n + i] = i < e->n;
        if (i < e->n && c->value[i] > before) {
            e->shortest = fmin(e->shortest, c->value[i] - before);
            before = c->value[i];
        }
    }
    s->samples += e->n;
    s->nch++;
}

stein_status fit__take_stroke(fit__problem *p, int stroke, const lab_data *data, stein_err *err)
{
    fit__stroke *s = &p->stroke[stroke];
    size_t nc = (size_t)data->ncolumn, n = (size_t)data->nrow;
    *s = (fit__stroke){.data = data, .n = data->nrow, .tau = -1};
    s->channel = calloc(nc + 1, sizeof *s->channel);
    s->event = calloc(nc + 1, sizeof *s->event);
    s->given = calloc(nc + 1, sizeof *s->given);
    s->delay = calloc(nc + 1, sizeof *s->delay);
    s->noise = calloc(4 * nc + 4, sizeof *s->noise);
    s->audited = s->noise + (s->noise != NULL ? nc + 1 : 0);
    s->residual = s->audited + (s->noise != NULL ? nc + 1 : 0);
    s->step = s->residual + (s->noise != NULL ? nc + 1 : 0);
    s->y = calloc(2 * nc * n + 1, sizeof *s->y);
    s->share = s->y + (s->y != NULL ? nc * n : 0);
    s->signal = calloc(nc + 1, sizeof *s->signal);
    if (!s->channel || !s->event || !s->given || !s->delay || !s->noise || !s->y || !s->signal) {
        return lab__no_memory(err);
    }
    lab_audit *audit = NULL;
    stein_status status = lab_audit_create(&audit, data, err);
    for (int i = 0; status == STEIN_OK && i < audit->nfinding; i++) {
        tell(p, data->file, audit->finding[i]);
    }
    for (int c = 0; status == STEIN_OK && c < data->ncolumn; c++) {
        status = take_column(p, s, audit, c, err);
    }
    s->nsampled = s->nch;
    for (int c = 0; status == STEIN_OK && c < data->ncolumn; c++) {
        take_events(p, s, audit, c);
    }
    s->waits = status == STEIN_OK && fit__waits(s, audit);
    lab_audit_destroy(audit);
    if (status == STEIN_OK && s->nch == 0) {
        return lab__fail(err, STEIN_EINVAL, "%s has no output channel of the model: nothing to fit",
                         data->file);
    }
    // without a load the inputs alone decide when it starts
    s->origin = s->nsignal > 0 && lab_equations(p->model)->load.body < 0 ? data->time[0] : 0.0;
    fit__mute_ends(p, s);
    p->samples += s->samples;
    p->rows = s->nch * s->n > p->rows ? s->nch * s->n : p->rows;
    return status;
}
