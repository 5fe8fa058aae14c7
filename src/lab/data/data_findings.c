/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_findings.c - an audit in words: limits of a fit, and the audit as lines of text.
 *
 * A finding is a sentence with its figures, so that the reader can disagree. The trigger is judged
 * only where t = 0 means something: the file states that it is synchronised, or states nothing and
 * the mechanism has a stroke.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"

static const double contradicts = 2.0; /* ratio of stated and estimated noise */
static const double rounding = 1e-15;  /* steps of sums that should be 0 [SI] */

void data__finding(lab_audit *a, int *nomem, const char *format, ...)
{
    char text[400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    char **grown = realloc(a->finding, sizeof *grown * ((size_t)a->nfinding + 1));
    if (grown == NULL || (grown[a->nfinding] = lab__text("%s", text)) == NULL) {
        a->finding = grown != NULL ? grown : a->finding;
        *nomem = 1;
        return;
    }
    a->finding = grown;
    a->nfinding++;
}

char *data__quantity(char *text, double value, const char *unit)
{
    static const struct {
        double factor;
        const char *name;
    } prefix[] = {{1e3, "k"}, {1.0, ""}, {1e-3, "m"}, {1e-6, "u"}, {1e-9, "n"}};
    static const char *const scaled[] = {"s", "m", "N", "Hz", "rad", "J"};
    int scales = 0, k = 1;
    for (size_t i = 0; i < sizeof scaled / sizeof *scaled; i++) {
        scales |= strcmp(unit, scaled[i]) == 0;
    }
    if (scales && value != 0.0 && isfinite(value)) {
        int least = strcmp(unit, "rad") == 0 || *unit == 'N' || *unit == 'J' ? 2 : 4;
        k = strcmp(unit, "s") == 0 || strcmp(unit, "m") == 0 ? 1 : 0;
        while (k < least && fabs(value) < 0.9995 * prefix[k].factor) {
            k++;
        }
    }
    snprintf(text, DATA_SHOWN, "%.4g %s%s", value / prefix[k].factor + 0.0, // never "-0"
             scales ? prefix[k].name : "", strcmp(unit, "1") == 0 ? "" : unit);
    size_t n = strlen(text);
    text[n - (n > 0 && text[n - 1] == ' ')] = '\0';
    return text;
}

/* ---- the time ---- */

/* does t = 0 mean the start of the motion? */
static int has_origin(const lab_data *d)
{
    return d->trigger == LAB_TRIGGER_SYNCHRONISED ||
           (d->trigger == LAB_TRIGGER_UNSTATED && d->model->stroke.string >= 0);
}

static void judge_trigger(lab_audit *a, int *nomem)
{
    const lab_data *d = a->data;
    double start = d->time[0], dt = a->interval, length = d->time[d->nrow - 1] - start;
    double late = fmax(3.0 * dt, 0.02 * length);
    char t[DATA_SHOWN];
    a->trigger_fits = 1;
    if (!has_origin(d)) {
        return;
    }
    const char *said = d->trigger == LAB_TRIGGER_SYNCHRONISED
                           ? "though the trigger is called synchronised"
                           : "though no \"# trigger: unsynchronised\" is given";
    int before = a->nfinding;
    if (isnan(a->motion)) {
        if (!a->starts_at_rest && start < -2.0 * dt) {
            data__finding(a, nomem, "it moves from the first sample on, at %s, %s",
                          data__quantity(t, start, "s"), said);
        } else if (!a->starts_at_rest && start > late) {
            data__finding(a, nomem,
                          "the record begins at %s, in motion: the start of the motion is "
                          "missing",
                          data__quantity(t, start, "s"));
        }
    } else if (a->motion < -fmax(2.0 * dt, 2.0 * a->motion_error)) {
        data__finding(a, nomem, "the first motion is at %s, before the trigger, %s",
                      data__quantity(t, a->motion, "s"), said);
    } else if (a->motion > fmax(late, 3.0 * a->motion_error)) {
        data__finding(a, nomem, "nothing moves until %s, %s", data__quantity(t, a->motion, "s"),
                      said);
    }
    a->trigger_fits = a->nfinding == before;
}

static void judge_rows(lab_audit *a, int *nomem)
{
    char t[DATA_SHOWN], u[DATA_SHOWN];
    if (!a->uniform) {
        data__finding(a, nomem, "the sampling rate varies: intervals about %s, the longest %s",
                      data__quantity(t, a->interval, "s"),
                      data__quantity(u, fmax(a->longest_gap, a->interval), "s"));
    } else if (a->gaps > 0) {
        data__finding(a, nomem, "%d gap%s, %d frame%s dropped, the longest %s at %s", a->gaps,
                      a->gaps == 1 ? "" : "s", a->dropped, a->dropped == 1 ? "" : "s",
                      data__quantity(t, a->longest_gap, "s"),
                      data__quantity(u, a->gap[0].from, "s"));
    }
    if (a->uniform && a->jitter_sd > 0.1 * a->interval) {
        data__finding(a, nomem, "the intervals jitter by %s about %s",
                      data__quantity(t, a->jitter_sd, "s"), data__quantity(u, a->interval, "s"));
    }
}

static void judge_time(lab_audit *a, int *nomem)
{
    const lab_data *d = a->data;
    double length = d->time[d->nrow - 1] - d->time[0], until = d->model->until;
    char t[DATA_SHOWN], u[DATA_SHOWN];
    if (!d->events_alone) {
        judge_rows(a, nomem);
    }
    if (length > 50.0 * until || length < until / 500.0) {
        data__finding(a, nomem,
                      "the record lasts %s, a run of the model %s: is the unit of the time "
                      "right?",
                      data__quantity(t, length, "s"), data__quantity(u, until, "s"));
    }
    judge_trigger(a, nomem);
}

/* ---- channels ---- */

static void judge_noise(lab_audit *a, const lab_column *c, const lab_channel_audit *ch, int *nomem)
{
    char x[DATA_SHOWN], y[DATA_SHOWN];
    double ratio = c->noise / ch->noise_estimated;
    double sure = contradicts * (1.0 + (isfinite(ch->noise_error) ? 2.0 * ch->noise_error : 0.0));
    if (ratio > sure || ratio < 1.0 / sure) {
        data__finding(a, nomem, "%s: the noise is given as %s, the record shows %s", c->name,
                      data__quantity(x, c->noise, c->unit),
                      data__quantity(y, ch->noise_estimated, c->unit));
    }
    if (ch->noise_from == LAB_NOISE_UNKNOWN) {
        data__finding(a, nomem, "%s: %d samples are too few to estimate the noise", c->name,
                      ch->samples);
    }
    if (ch->step > rounding && (ch->step > 2.5 * ch->noise_estimated || ch->locking > 0.8)) {
        data__finding(a, nomem, "%s: rounded to steps of %s, more than its noise: %s", c->name,
                      data__quantity(x, ch->step, c->unit),
                      isnan(c->noise)
                          ? "they count as noise of a step / sqrt 12, nothing is to be done"
                          : "the noise that is given counts");
    }
    if (ch->correlation[0] > 0.3 && ch->noise_from == LAB_NOISE_REST &&
        ch->noise_estimated > 1e-5 * (ch->high - ch->low)) {
        data__finding(a, nomem,
                      "%s: the noise of neighbouring samples is correlated by %.2f: there "
                      "are fewer independent samples than rows",
                      c->name, ch->correlation[0]);
    }
}

/* how many times of events there are, and how well they are known */
static void tell_events(lab_audit *a, const lab_column *c, const lab_channel_audit *ch, int *nomem)
{
    char x[DATA_SHOWN], y[DATA_SHOWN];
    if (!isnan(c->noise)) {
        return;
    }
    const char *why = !a->data->events_alone && a->interval > c->digit ? "a frame / sqrt 12"
                      : ch->noise > 0.5 * c->digit                     ? "the least that is assumed"
                                                                       : "last digit / sqrt 12";
    data__finding(
        a, nomem, "%s: %d time%s at which it %s, the last one %s; noise of a time %s (%s)", c->name,
        c->samples, c->samples == 1 ? "" : "s", c->events == LAB_EVENTS_BEGIN ? "closes" : "opens",
        data__quantity(x, ch->high, "s"), data__quantity(y, ch->noise, "s"), why);
}

static void judge_channel(lab_audit *a, int k, int *nomem)
{
    const lab_column *c = &a->data->column[k];
    const lab_channel_audit *ch = &a->channel[k];
    char x[DATA_SHOWN];
    if (c->role == LAB_EVENT_TIMES) {
        tell_events(a, c, ch, nomem);
        return;
    }
    judge_noise(a, c, ch, nomem);
    if (c->wraps > 0) {
        data__finding(a, nomem, "%s: the angle wraps %d time%s: unwrapped", c->name, c->wraps,
                      c->wraps == 1 ? "" : "s");
    }
    if (c->smooth > 0.0) {
        data__finding(a, nomem, "%s: smoothed to half at %s, as the file states", c->name,
                      data__quantity(x, c->smooth, "Hz"));
    }
    if (ch->low == ch->high) {
        data__finding(a, nomem, "%s: %s throughout", c->name, data__quantity(x, ch->low, c->unit));
    }
    if (ch->missing > 0.0) {
        data__finding(a, nomem, "%s: %.2g %% of the rows have no sample, at most %d in a row",
                      c->name, 100.0 * ch->missing, ch->longest_missing);
    }
    if (ch->saturated_low > 0) {
        data__finding(a, nomem, "%s: cut off at its lowest value %s, %d samples", c->name,
                      data__quantity(x, ch->low, c->unit), ch->saturated_low);
    }
    if (ch->saturated_high > 0) {
        data__finding(a, nomem, "%s: cut off at its highest value %s, %d samples", c->name,
                      data__quantity(x, ch->high, c->unit), ch->saturated_high);
    }
    if (ch->spikes > 0) {
        data__finding(a, nomem, "%s: %d single sample%s far off, the first at %s", c->name,
                      ch->spikes, ch->spikes == 1 ? "" : "s", data__quantity(x, ch->spike[0], "s"));
    }
}

/* titles without a unit, in one sentence */
static void tell_assumed(lab_audit *a, int *nomem)
{
    const lab_data *d = a->data;
    char list[300] = "";
    size_t n = 0;
    if (d->time_unit_assumed) {
        n = (size_t)snprintf(list, sizeof list, "time [s]");
    }
    for (int k = 0; k < d->ncolumn && n + 2 * DATA_SHOWN < sizeof list; k++) {
        if (d->column[k].unit_assumed) {
            n += (size_t)snprintf(list + n, sizeof list - n, "%s%s [%s]", n > 0 ? ", " : "",
                                  d->column[k].name, d->column[k].unit);
        }
    }
    if (n > 0) {
        data__finding(a, nomem, "titles without a unit, read as %s", list);
    }
}

void data__findings(lab_audit *a, int *nomem)
{
    tell_assumed(a, nomem);
    if (a->data->passed_over != NULL) {
        data__finding(a, nomem, "columns that are no output or input of \"%s\", passed over: %s",
                      a->data->model->name, a->data->passed_over);
    }
    judge_time(a, nomem);
    for (int k = 0; k < a->data->ncolumn; k++) {
        judge_channel(a, k, nomem);
    }
}

/* ---- text ---- */

/* lines go out one by one; a missing one is remembered */
typedef struct out {
    lab_report_fn *line;
    void *ctx;
    int nomem;
} out;

static void put(out *o, char *text)
{
    if (text != NULL) {
        o->line(o->ctx, text);
    } else {
        o->nomem = 1;
    }
    free(text);
}

/* a value of a column, in degrees where the file has them */
static const char *in_file(char text[DATA_SHOWN], const lab_column *c, double value)
{
    if (c->written[0] == '\0') {
        return data__quantity(text, value, c->unit);
    }
    snprintf(text, DATA_SHOWN, "%.4g %s", value / c->factor, c->written);
    return text;
}

static void put_channel(out *o, const lab_column *c, const lab_channel_audit *ch)
{
    static const char *const from[] = {"at rest", "in motion", "from the step", "unknown"};
    char low[DATA_SHOWN], high[DATA_SHOWN], noise[DATA_SHOWN], step[DATA_SHOWN], lag[48] = "";
    if (c->role == LAB_EVENT_TIMES) {
        put(o, lab__text("  %s: %d times of %s, %s .. %s, noise %s (%s)", c->name, c->samples,
                         c->events == LAB_EVENTS_BEGIN ? "begin" : "end",
                         data__quantity(low, ch->low, "s"), data__quantity(high, ch->high, "s"),
                         data__quantity(noise, ch->noise, "s"),
                         isnan(c->noise) ? from[ch->noise_from] : "given"));
        return;
    }
    if (!isnan(ch->correlation[0])) {
        snprintf(lag, sizeof lag, ", correlation of neighbours %.2f", ch->correlation[0]);
    }
    put(o, lab__text("  %s: %d samples, %s .. %s, noise %s (%s%s), step %s", c->name, ch->samples,
                     in_file(low, c, ch->low), in_file(high, c, ch->high),
                     in_file(noise, c, ch->noise), isnan(c->noise) ? from[ch->noise_from] : "given",
                     lag, ch->step > 0.0 ? in_file(step, c, ch->step) : "none"));
}

static void put_rows(out *o, const lab_audit *a)
{
    const lab_data *d = a->data;
    char x[DATA_SHOWN], y[DATA_SHOWN], z[DATA_SHOWN], w[DATA_SHOWN];
    data__quantity(x, d->time[0], "s");
    data__quantity(y, d->time[d->nrow - 1], "s");
    if (d->events_alone) {
        put(o, lab__text("%s: times of events, %s .. %s", d->file, x, y));
        return;
    }
    int even = a->jitter_sd < 1e-9 * a->interval; // round-off of written times
    put(o, lab__text("%s: %d rows, %s .. %s, %s, %s%s, %d gap%s", d->file, d->nrow, x, y,
                     data__quantity(z, a->rate, "Hz"), even ? "no jitter" : "jitter ",
                     even ? "" : data__quantity(w, a->jitter_sd, "s"), a->gaps,
                     a->gaps == 1 ? "" : "s"));
}

stein_status lab_audit_text(const lab_audit *a, lab_report_fn *line, void *ctx, stein_err *err)
{
    const lab_data *d = a->data;
    out o = {line, ctx, 0};
    char x[DATA_SHOWN], y[DATA_SHOWN];
    put_rows(&o, a);
    for (int k = 0; k < d->ncolumn; k++) {
        put_channel(&o, &d->column[k], &a->channel[k]);
    }
    for (int i = 0; i < a->nrest && i < LAB_SPANS; i++) {
        put(&o, lab__text("  at rest %s .. %s", data__quantity(x, a->rest[i].from, "s"),
                          data__quantity(y, a->rest[i].to, "s")));
    }
    if (!isnan(a->motion)) {
        put(&o, lab__text("  first motion at %s +- %s", data__quantity(x, a->motion, "s"),
                          data__quantity(y, a->motion_error, "s")));
    }
    for (int i = 0; i < a->nfinding; i++) {
        put(&o, lab__text("  ! %s", a->finding[i]));
    }
    return o.nomem ? lab__no_memory(err) : STEIN_OK;
}
