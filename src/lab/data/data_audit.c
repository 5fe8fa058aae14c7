/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_audit.c - quality of a record, before any fit.
 *
 * Every channel is audited separately, from its samples alone (data_noise.c, data_rest.c); then
 * the time base, and the rests that all channels share. The figures go into structs. Limits of a
 * fit, and contradictions to the record's statements, become sentences (data_findings.c). Nothing
 * here repairs or drops a sample.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"

enum { MOST_RESTS = 1000, SWITCHED = 8 };
static const double finest_time = 1e-5; /* noise of a time, at least [s]: sound at 44.1 kHz */
static const double of_step = 0.1;      /* relative sd of step/sqrt(12) as the noise: it may lock */

/* ---- time base ---- */

static void note_gap(lab_audit *a, double from, double to)
{
    if (a->gaps < LAB_SPANS) {
        a->gap[a->gaps] = (lab_span){from, to};
    }
    a->gaps++;
    a->dropped += (int)fmin(1e9, round((to - from) / a->interval) - 1.0);
    a->longest_gap = fmax(a->longest_gap, to - from);
}

static void audit_time(lab_audit *a, double *scratch)
{
    const double *t = a->data->time;
    int n = a->data->nrow - 1, regular = 0, off = 0;
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        scratch[i] = t[i + 1] - t[i];
    }
    a->interval = data__median(scratch, n);
    a->rate = 1.0 / a->interval;
    for (int i = 0; i < n; i++) {
        double d = t[i + 1] - t[i] - a->interval;
        off += fabs(d) > 0.5 * a->interval;
        if (d > 0.5 * a->interval) {
            note_gap(a, t[i], t[i + 1]);
            continue;
        }
        regular++;
        sum += d * d;
        a->jitter_max = fmax(a->jitter_max, fabs(d));
    }
    a->jitter_sd = regular > 0 ? sqrt(sum / regular) : NAN;
    a->uniform = off <= n / 5;
}

/* ---- one channel ---- */

static void take_series(data__series *s, const lab_data *data, const lab_column *c,
                        lab_channel_audit *a)
{
    int gone = 0;
    s->n = 0;
    for (int i = 0; i < data->nrow; i++) {
        if (!c->present[i]) {
            gone++;
            a->longest_missing = gone > a->longest_missing ? gone : a->longest_missing;
            continue;
        }
        gone = 0;
        s->t[s->n] = data->time[i];
        s->v[s->n++] = c->value[i];
        a->low = s->n == 1 ? c->value[i] : fmin(a->low, c->value[i]);
        a->high = s->n == 1 ? c->value[i] : fmax(a->high, c->value[i]);
    }
    s->range = a->high - a->low;
    a->samples = s->n;
    a->missing = 1.0 - (double)s->n / data->nrow;
}

/* noise level for the detection of rest and spikes: never 0, never below the resolution */
static double working_sigma(const data__series *s, double noise, double step)
{
    double sigma = fmax(isnan(noise) ? 0.0 : noise, fmax(step / sqrt(12.0), 1e-6 * s->range));
    return sigma > 0.0 ? sigma : 1.0;
}

static int find_rests(data__series *s, const lab_column *c, lab_channel_audit *a, int (*rest)[2])
{
    int samples = 0, still = 0;
    double error = NAN, still_error = NAN, noise = NAN;
    double moving = data__noise_in_windows(s, &samples, &error);
    double given = isnan(moving) ? c->noise : moving;
    int n = 0;
    s->sigma = working_sigma(s, given, a->step);
    for (int pass = 0; pass < 2; pass++) {
        n = data__rests(s, rest, MOST_RESTS);
        still = data__noise_at_rest(s, rest, n, &noise, &still_error, a->correlation);
        double finer = working_sigma(s, noise, a->step);
        if (still == 0 || finer > 0.7 * s->sigma) {
            break;
        }
        s->sigma = finer;
    }
    // a resting value may be locked to one level, where its noise does not show
    int locked = noise < 0.5 * a->step && moving < a->step;
    int rests_count = still > 0 && !(noise > 3.0 * moving) && !locked;
    a->noise_estimated = rests_count ? noise : moving;
    a->noise_samples = rests_count ? still : samples;
    a->noise_error = rests_count ? still_error : error;
    a->noise_from = rests_count     ? LAB_NOISE_REST
                    : isnan(moving) ? LAB_NOISE_UNKNOWN
                                    : LAB_NOISE_MOTION;
    s->sigma = working_sigma(s, isnan(a->noise_estimated) ? c->noise : a->noise_estimated, a->step);
    if (!rests_count) {
        data__correlation_in_windows(s, a->correlation);
    }
    if (a->noise_estimated < a->step / sqrt(12.0)) {
        a->noise_estimated = a->step / sqrt(12.0);
        a->noise_error = of_step;
        a->noise_from = LAB_NOISE_STEP;
    }
    return n;
}

/* share of the resting samples on the most frequent level of the lattice */
static double locking(const data__series *s, int (*rest)[2], int n, double step)
{
    int all = 0, most = 0, run = 1;
    for (int i = 0; i < n; i++) {
        for (int k = rest[i][0]; k <= rest[i][1]; k++) {
            s->scratch[all++] = s->v[k];
        }
    }
    if (step == 0.0 || all < 20) {
        return 0.0;
    }
    gsl_sort(s->scratch, 1, (size_t)all);
    for (int i = 1; i < all; i++) {
        run = s->scratch[i] - s->scratch[i - 1] < 0.3 * step ? run + 1 : 1;
        most = run > most ? run : most;
    }
    return (double)most / all;
}

/* Times of events: how well they are known, by their digits and by the frames that they were seen
 * in, if there are any. */
static void audit_events(const lab_audit *audit, const lab_column *c, lab_channel_audit *a)
{
    double frame = audit->data->events_alone ? 0.0 : audit->interval;
    double step = fmax(fmax(c->digit, frame), sqrt(12.0) * finest_time);
    *a = (lab_channel_audit){.samples = c->samples,
                             .low = c->value[0],
                             .high = c->value[c->samples > 0 ? c->samples - 1 : 0],
                             .noise_estimated = step / sqrt(12.0),
                             .noise_error = NAN,
                             .noise_from = LAB_NOISE_STEP,
                             .step = c->digit,
                             .motion = NAN,
                             .motion_error = NAN};
    for (int i = 0; i < LAB_LAGS; i++) {
        a->correlation[i] = NAN;
    }
    a->noise = isnan(c->noise) ? a->noise_estimated : c->noise;
}

/* A command that is switched between few values, as that of a relay or a step: these are no steps
 * of an instrument, and nothing is cut off. */
static int is_switched(const data__series *s)
{
    double value[SWITCHED];
    int n = 0;
    for (int i = 0; i < s->n && n <= SWITCHED; i++) {
        int k = 0;
        while (k < n && value[k] != s->v[i]) {
            k++;
        }
        if (k == n && n < SWITCHED) {
            value[n] = s->v[i];
        }
        n += k == n;
    }
    return n <= SWITCHED;
}

static void audit_channel(data__series *s, const lab_data *data, const lab_column *c,
                          lab_channel_audit *a, int (*rest)[2])
{
    stein_read_kind read =
        c->role == LAB_OUTPUT ? data->model->channels[c->index].read : STEIN_READ_INPUT;
    int pulses = read == STEIN_READ_FORCE || read == STEIN_READ_TANGENT ||
                 read == STEIN_READ_NOTCH_FORCE || read == STEIN_READ_NOTCH_PHASE ||
                 read == STEIN_READ_INPUT_FORCE;
    a->motion = a->motion_error = NAN;
    for (int i = 0; i < LAB_LAGS; i++) {
        a->correlation[i] = NAN;
    }
    take_series(s, data, c, a);
    int switched = c->role == LAB_INPUT &&
                   data->model->inputs[c->index].kind != STEIN_INPUT_MOTION && is_switched(s);
    a->step = switched ? 0.0 : data__step(s);
    int n = find_rests(s, c, a, rest);
    a->noise = isnan(c->noise) ? a->noise_estimated : c->noise;
    a->locking = locking(s, rest, n, a->step);
    a->nrest = n;
    for (int i = 0; i < n && i < LAB_SPANS; i++) {
        a->rest[i] = (lab_span){s->t[rest[i][0]], s->t[rest[i][1]]};
    }
    a->starts_at_rest = n > 0 && rest[0][0] <= 8;
    if (a->starts_at_rest) {
        data__first_motion(s, rest[0], a);
    }
    if (!pulses &&
        !switched) { // a contact force may be there for one sample, and is nothing before and after
        data__spikes(s, a);
        data__saturation(s, a);
    }
}

/* ---- all channels ---- */

static void share_rests(lab_audit *a)
{
    int n = 0, first = 1;
    for (int k = 0; k < a->data->ncolumn; k++) {
        const lab_channel_audit *c = &a->channel[k];
        lab_span both[LAB_SPANS];
        int m = 0, nc = c->nrest < LAB_SPANS ? c->nrest : LAB_SPANS;
        if (a->data->column[k].role == LAB_EVENT_TIMES) {
            continue;
        }
        for (int i = 0; !first && i < n; i++) {
            for (int j = 0; j < nc && m < LAB_SPANS; j++) {
                lab_span common = {fmax(a->rest[i].from, c->rest[j].from),
                                   fmin(a->rest[i].to, c->rest[j].to)};
                if (common.to - common.from >= 8.0 * a->interval) {
                    both[m++] = common;
                }
            }
        }
        n = first ? nc : m;
        memcpy(a->rest, first ? c->rest : both, sizeof *both * (size_t)n);
        first = 0;
    }
    a->nrest = n;
}

/* does this column show where something is? A force may begin long after the motion. */
static int is_place(const lab_data *d, const lab_column *c)
{
    if (c->role == LAB_INPUT) {
        return d->model->inputs[c->index].kind == STEIN_INPUT_MOTION;
    }
    if (c->role == LAB_EVENT_TIMES) {
        return 0;
    }
    return stein_reads_place((int)d->model->channels[c->index].read);
}

/* the earliest of the channels, when all of them begin at rest */
static void find_motion(lab_audit *a)
{
    a->motion = a->motion_error = NAN;
    a->starts_at_rest = 1;
    for (int k = 0; k < a->data->ncolumn; k++) {
        if (is_place(a->data, &a->data->column[k]) && !a->channel[k].starts_at_rest) {
            a->starts_at_rest = 0;
        }
    }
    for (int k = 0; k < a->data->ncolumn && a->starts_at_rest; k++) {
        const lab_channel_audit *c = &a->channel[k];
        if (is_place(a->data, &a->data->column[k]) && !isnan(c->motion) &&
            !(a->motion <= c->motion)) {
            a->motion = c->motion;
            a->motion_error = c->motion_error;
        }
    }
}

void lab_audit_destroy(lab_audit *a)
{
    if (a != NULL) {
        for (int i = 0; i < a->nfinding; i++) {
            free(a->finding[i]);
        }
        free(a->finding);
        free(a->channel);
        free(a);
    }
}

static int finds(const lab_audit *a, const char *text)
{
    int k = 0;
    while (k < a->nfinding && strcmp(a->finding[k], text) != 0) {
        k++;
    }
    return k < a->nfinding;
}

int lab_audit_repeats(lab_audit *const *audit, int n, int record, const char *finding)
{
    int more = 0;
    for (int i = 0; i < n && more >= 0; i++) {
        int same = i != record && finds(audit[i], finding);
        more = same && i < record ? -1 : more + same;
    }
    return more;
}

stein_status lab_audit_create(lab_audit **audit, const lab_data *data, stein_err *err)
{
    size_t n = (size_t)data->nrow + 1;
    lab_audit *a = calloc(1, sizeof *a);
    double *room = malloc(sizeof *room * (4 * n + DATA_DIFFERENCES));
    int(*rest)[2] = malloc(sizeof *rest * MOST_RESTS), nomem = 0;
    if (a != NULL) {
        a->channel = calloc((size_t)data->ncolumn + 1, sizeof *a->channel);
    }
    if (a == NULL || a->channel == NULL || room == NULL || rest == NULL) {
        nomem = 1;
    } else {
        data__series s = {.t = room,
                          .v = room + n,
                          .scratch = room + 2 * n,
                          .residual = room + 3 * n,
                          .difference = room + 4 * n};
        a->data = data;
        audit_time(a, s.scratch);
        for (int k = 0; k < data->ncolumn; k++) {
            const lab_column *c = &data->column[k];
            if (c->role == LAB_EVENT_TIMES) {
                audit_events(a, c, &a->channel[k]);
            } else {
                audit_channel(&s, data, c, &a->channel[k], rest);
            }
        }
        share_rests(a);
        find_motion(a);
        data__findings(a, &nomem);
    }
    free(room);
    free(rest);
    if (nomem) {
        lab_audit_destroy(a);
        return lab__no_memory(err);
    }
    *audit = a;
    return STEIN_OK;
}

/* ---- rest values ---- */

stein_status lab_data_rest(const lab_data *data, const lab_model *model, double *value,
                           stein_err *err)
{
    const stein_model *m = lab_equations(model);
    stein_sim *sim = NULL;
    double *p = malloc(sizeof *p * ((size_t)m->np + 1));
    if (p == NULL) {
        return lab__no_memory(err);
    }
    memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
    lab_data_apply(data, p);
    stein_status status = lab_sim(model, NULL, &sim, err);
    status = status == STEIN_OK ? stein_try_all(sim, p, err) : status;
    status = status == STEIN_OK ? stein_reset(sim, err) : status;
    for (int i = 0; status == STEIN_OK && i < data->ncolumn; i++) {
        const lab_column *c = &data->column[i];
        value[i] = c->role == LAB_OUTPUT ? stein_read(sim, c->index) : NAN;
    }
    stein_sim_destroy(sim);
    free(p);
    return status;
}

/* value of a column at the start; NAN when the record does not show it */
static double at_start(const lab_audit *a, int k)
{
    const lab_data *d = a->data;
    const lab_column *c = &d->column[k];
    const lab_channel_audit *ch = &a->channel[k];
    if (!ch->starts_at_rest) {
        int trigger = d->trigger != LAB_TRIGGER_UNSYNCHRONISED && fabs(d->time[0]) <= a->interval &&
                      c->present[0];
        return trigger ? c->value[0] : NAN;
    }
    double sum = 0.0, end = isnan(ch->motion) ? ch->rest[0].to : fmin(ch->motion, ch->rest[0].to);
    int n = 0;
    for (int i = 0; i < d->nrow && (d->time[i] <= end || n == 0); i++) {
        if (c->present[i]) {
            sum += c->value[i];
            n++;
        }
    }
    return sum / n;
}

stein_status lab_data_check_rest(const lab_audit *a, const double *expected,
                                 const double *tolerance, lab_report_fn *report, void *ctx,
                                 stein_err *err)
{
    const lab_data *d = a->data;
    data__problems problems = {.file = d->file};
    char found[DATA_SHOWN], model[DATA_SHOWN], by[DATA_SHOWN];
    for (int k = 0; k < d->ncolumn; k++) {
        const lab_column *c = &d->column[k];
        double value = at_start(a, k);
        if (isnan(value) || isnan(expected[k]) || fabs(value - expected[k]) <= tolerance[k]) {
            continue;
        }
        // the setting is under suspicion when there is one, else the channel's zero
        const lab_setting *s = d->nset > 0 ? &d->set[0] : NULL;
        data__problem(
            &problems, 0, s != NULL ? s->line : c->line, s != NULL ? s->column : c->column,
            "\"%s\" rests at %s, the model%s at %s: "
            "more than %s apart",
            c->name, data__quantity(found, value, c->unit), s != NULL ? " with these settings" : "",
            data__quantity(model, expected[k], c->unit), data__quantity(by, tolerance[k], c->unit));
    }
    return data__problems_flush(&problems, report, ctx, err);
}
