/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_plots.c - strokes over time with their residuals, and the missing forces.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosis_page.h"

enum { WIDTH = 360, SHOWN = 2, LAGS = 24, CHANNELS = 64, SMOOTH = 11, FORCES = 4 };
static const double left = 46.0, right = 14.0, lead = 3e-3; /* [px], before the first motion [s] */

static const char *base_name(const char *path)
{
    const char *slash = path != NULL ? strrchr(path, '/') : NULL;
    return slash != NULL ? slash + 1 : path;
}

static page__plot plot_at(FILE *f, double top, double height)
{
    return (page__plot){.f = f,
                        .left = left,
                        .top = top,
                        .width = WIDTH - left - right,
                        .height = height,
                        .caption = 13.0};
}

static double misfit(const lab_trace *t)
{
    double sum = 0.0, n = 0.0;
    for (int i = 0; i < t->n; i++) {
        double r = t->y[i] - t->before[i];
        sum += isfinite(r) ? r * r : 0.0;
        n += isfinite(r);
    }
    return n > 0.0 ? sqrt(sum / n) : 0.0;
}

/* traces of a channel that are drawn: held-out ones where there are any; worst, middle, best */
static int choose(const lab_diagnosis *d, const char *channel, const lab_trace *shown[SHOWN])
{
    int n = 0, held = 0;
    const lab_trace **list = malloc(sizeof(const lab_trace *) * (size_t)(d->ntrace + 1));
    for (int i = 0; i < d->ntrace; i++) {
        held |= d->trace[i].held_out && strcmp(d->trace[i].channel, channel) == 0;
    }
    for (int i = 0; list != NULL && i < d->ntrace; i++) {
        const lab_trace *t = &d->trace[i];
        if (strcmp(t->channel, channel) == 0 && t->n > 1 && (t->held_out || !held)) {
            int at = n++;
            for (; at > 0 && misfit(list[at - 1]) < misfit(t); at--) {
                list[at] = list[at - 1];
            }
            list[at] = t;
        }
    }
    int count = n < SHOWN ? n : SHOWN;
    for (int k = 0; k < count; k++) {
        shown[k] = list[count > 1 ? k * (n - 1) / (count - 1) : 0];
    }
    free(list);
    return count;
}

/* where the drawing begins and ends [s] */
static void time_range(const lab_trace *t, double *from, double *to)
{
    int i = 0;
    while (i + 1 < t->n && t->phase != NULL && t->phase[i] != NULL &&
           strcmp(t->phase[i], "rest") == 0) {
        i++;
    }
    i = i + 1 < t->n ? i : 0;
    *from = fmax(t->t[0], t->t[i] - lead);
    *to = t->t[t->n - 1];
}

/* from seconds to the unit of the time axis, and its name */
static double time_unit(double from, double to, const char **label)
{
    int slow = to - from > 1.5;
    *label = slow ? "time [s]" : "time [ms]";
    return slow ? 1.0 : 1e3;
}

static void note(const double *v, int n, double scale, double *lo, double *hi)
{
    for (int i = 0; i < n; i++) {
        if (isfinite(v[i])) {
            *lo = fmin(*lo, scale * v[i]);
            *hi = fmax(*hi, scale * v[i]);
        }
    }
}

static void axis_label(char *text, size_t size, const char *what, const page__unit *u)
{
    snprintf(text, size, u->name[0] != '\0' ? "%s [%s]" : "%s", what, u->name);
}

/* values at one sample of a record */
typedef struct reading {
    const lab_trace *t;
    page__unit u;
    double sx;
    int changed;
} reading;

static void read_out(FILE *f, const void *ctx, int i)
{
    const reading *r = ctx;
    const lab_trace *t = r->t;
    fprintf(f, "%.4g %s: measured ", r->sx * t->t[i], r->sx > 1.0 ? "ms" : "s");
    page__number(f, r->u.factor * t->y[i], 4);
    fputs(r->changed ? ", before " : ", model ", f);
    page__number(f, r->u.factor * t->before[i], 4);
    if (r->changed) {
        fputs(", after ", f);
        page__number(f, r->u.factor * t->after[i], 4);
    }
    fprintf(f, " %s", r->u.name);
}

/* the unit of the records where it is another one than of SI */
static page__unit unit_of(const lab_trace *t, double typical)
{
    page__unit u = {.factor = t->per_unit};
    if (t->written[0] == '\0') {
        return page__unit_for(t->unit, typical);
    }
    snprintf(u.name, sizeof u.name, "%s", t->written);
    return u;
}

static void draw_channel(FILE *f, const lab_trace *t, double from, double to, int changed)
{
    double lo = INFINITY, hi = -INFINITY;
    char label[LAB_PLACE + PAGE_UNIT];
    const char *unused;
    double sx = time_unit(from, to, &unused);
    note(t->y, t->n, 1.0, &lo, &hi);
    note(t->before, t->n, 1.0, &lo, &hi);
    page__unit u = unit_of(t, fmax(fabs(lo), fabs(hi)));
    page__plot p = plot_at(f, 36.0, 118.0);
    p.caption = 20.0;
    p.x0 = sx * from;
    p.x1 = sx * to;
    p.y0 = u.factor * lo;
    p.y1 = u.factor * hi;
    page__range(&p.x0, &p.x1, 0.0);
    page__range(&p.y0, &p.y1, 0.07);
    if (t->phase != NULL) {
        page__phases(&p, t->t, t->phase, t->n, sx);
    }
    axis_label(label, sizeof label, t->channel, &u);
    page__axes(&p, NULL, label);
    page__dots(&p, "measured", t->t, t->y, t->n, sx, u.factor);
    page__curve(&p, changed ? "before" : "after", t->t, t->before, t->n, sx, u.factor);
    if (changed) {
        page__curve(&p, "after", t->t, t->after, t->n, sx, u.factor);
    }
    reading r = {t, u, sx, changed};
    page__tips(&p, t->t, t->y, t->n, sx, read_out, &r);
}

/* running mean, m [n] */
static void smooth(const double *r, double *m, int n)
{
    for (int i = 0; i < n; i++) {
        double sum = 0.0, count = 0.0;
        for (int k = i - SMOOTH / 2; k <= i + SMOOTH / 2; k++) {
            int seen = k >= 0 && k < n && isfinite(r[k]);
            sum += seen ? r[k] : 0.0;
            count += seen;
        }
        m[i] = isfinite(r[i]) && count > 0.0 ? sum / count : (double)NAN;
    }
}

static void draw_residual(FILE *f, const lab_trace *t, double from, double to, int changed)
{
    double *r = malloc(sizeof *r * 3 * (size_t)t->n), *mean = r + (size_t)2 * (size_t)t->n;
    double most = 3.0 * t->noise;
    const char *time;
    double sx = time_unit(from, to, &time);
    char label[LAB_PLACE + PAGE_UNIT];
    if (r == NULL) {
        return;
    }
    for (int i = 0; i < t->n; i++) {
        r[i] = t->y[i] - t->before[i];
        r[t->n + i] = t->y[i] - t->after[i];
        most = isfinite(r[i]) ? fmax(most, fabs(r[i])) : most;
    }
    page__unit u = unit_of(t, most);
    page__plot p = plot_at(f, 182.0, 92.0);
    p.x0 = sx * from;
    p.x1 = sx * to;
    p.y1 = u.factor * most;
    p.y0 = -p.y1;
    page__range(&p.x0, &p.x1, 0.0);
    page__range(&p.y0, &p.y1, 0.04);
    page__rect(&p, "noise", p.x0, p.x1, -2.0 * u.factor * t->noise, 2.0 * u.factor * t->noise);
    axis_label(label, sizeof label, "measured \xe2\x88\x92 predicted", &u);
    page__axes(&p, time, label);
    for (int k = 0; k <= changed; k++) {
        const char *cls = changed && k == 0 ? "before" : "after";
        const double *own = r + (size_t)k * (size_t)t->n;
        char thin[16];
        snprintf(thin, sizeof thin, "%s thin", cls);
        page__curve(&p, thin, t->t, own, t->n, sx, u.factor);
        smooth(own, mean, t->n);
        page__curve(&p, cls, t->t, mean, t->n, sx, u.factor);
    }
    free(r);
}

/* ---- autocorrelation ---- */

/* of the residual of a channel over all its strokes, c [LAGS+1]. @return samples */
static double correlate(const lab_diagnosis *d, const char *channel, int after, double *c)
{
    double samples = 0.0;
    memset(c, 0, sizeof *c * (LAGS + 1));
    for (int k = 0; k < d->ntrace; k++) {
        const lab_trace *t = &d->trace[k];
        const double *h = after ? t->after : t->before;
        for (int i = 0; strcmp(t->channel, channel) == 0 && i < t->n; i++) {
            double r = t->y[i] - h[i];
            samples += isfinite(r);
            for (int lag = 0; isfinite(r) && lag <= LAGS && lag <= i; lag++) {
                double other = t->y[i - lag] - h[i - lag];
                c[lag] += isfinite(other) ? r * other : 0.0;
            }
        }
    }
    for (int lag = LAGS; lag >= 0; lag--) {
        c[lag] = c[0] > 0.0 ? c[lag] / c[0] : 0.0;
    }
    return samples;
}

static void draw_correlation(FILE *f, const lab_diagnosis *d, const char *channel, int changed)
{
    double before[LAGS + 1], after[LAGS + 1], lag[LAGS + 1], lo = -0.2;
    double n = correlate(d, channel, 0, before);
    correlate(d, channel, 1, after);
    for (int i = 0; i <= LAGS; i++) {
        lag[i] = i;
        lo = fmin(lo, fmin(before[i], after[i]));
    }
    page__plot p = plot_at(f, 26.0, 248.0);
    p.x0 = 0.5;
    p.x1 = LAGS + 0.5;
    p.y0 = lo - 0.05;
    p.y1 = 1.0;
    double band = n > 0.0 ? 2.0 / sqrt(n) : 0.0;
    page__rect(&p, "noise", p.x0, p.x1, -band, band);
    page__axes(&p, "lag [samples]", "autocorrelation of the residual, all records");
    page__curve(&p, changed ? "before" : "after", lag + 1, before + 1, LAGS, 1.0, 1.0);
    if (changed) {
        page__curve(&p, "after", lag + 1, after + 1, LAGS, 1.0, 1.0);
    }
}

/* ---- strokes ---- */

static void legend(FILE *f, int changed)
{
    fputs("<p class=\"legend\"><span class=\"key dot\"></span>measured", f);
    if (changed) {
        fputs("<span class=\"key rust\"></span>model before<span class=\"key blue\"></span>model "
              "after",
              f);
    } else {
        fputs("<span class=\"key blue\"></span>model", f);
    }
    fputs("<span class=\"key area\"></span>twice the noise</p>\n<p class=\"quiet\">Differences: "
          "every sample pale, the mean of "
          "11 samples strong. For each channel: the record predicted worst and the record "
          "predicted best.</p>\n",
          f);
}

static int is_changed(const lab_diagnosis *d)
{
    for (int k = 0; k < d->ntrace; k++) {
        if (memcmp(d->trace[k].before, d->trace[k].after, sizeof(double) * (size_t)d->trace[k].n) !=
            0) {
            return 1;
        }
    }
    return 0;
}

static void one_channel(FILE *f, const lab_diagnosis *d, const char *channel, int changed)
{
    const lab_trace *shown[SHOWN];
    int n = choose(d, channel, shown);
    fputs("<h3>", f);
    page__words(f, channel);
    fputs("</h3>\n<div class=\"plots\">\n", f);
    for (int k = 0; k < n; k++) {
        const lab_trace *t = shown[k];
        double from, to;
        time_range(t, &from, &to);
        fputs("<figure>", f);
        page__svg_open(f, WIDTH, 308, "a record as measured and as predicted, and the difference");
        draw_channel(f, t, from, to, changed);
        draw_residual(f, t, from, to, changed);
        page__svg_close(f);
        fputs("<figcaption>", f);
        page__text(f, base_name(t->file));
        fputs(t->held_out ? ", held out" : "", f);
        fputs("</figcaption></figure>\n", f);
    }
    fputs("</div>\n", f);
    if (n > 0) {
        fputs("<details><summary>autocorrelation of what is left</summary>\n<div "
              "class=\"plots\"><figure>",
              f);
        page__svg_open(f, WIDTH, 308, "autocorrelation of the residual");
        draw_correlation(f, d, channel, changed);
        page__svg_close(f);
        fputs(
            "<figcaption>noise alone has no correlation from sample to sample</figcaption></figure>"
            "</div></details>\n",
            f);
    }
}

void page__strokes(FILE *f, const lab_diagnosis *d)
{
    const char *done[CHANNELS];
    int n = 0, changed = is_changed(d);
    if (d->ntrace == 0) {
        return;
    }
    fputs("<section id=\"strokes\"><h2>Measured and predicted</h2>\n", f);
    legend(f, changed);
    for (int k = 0; k < d->ntrace; k++) {
        int known = n == CHANNELS;
        for (int i = 0; i < n; i++) {
            known |= strcmp(done[i], d->trace[k].channel) == 0;
        }
        if (!known) {
            done[n++] = d->trace[k].channel;
            one_channel(f, d, d->trace[k].channel, changed);
        }
    }
    fputs("</section>\n", f);
}

/* ---- forces ---- */

/* the largest force and band of a joint */
static double force_range(const lab_diagnosis *d, const char *joint)
{
    double most = 0.0;
    for (int k = 0; k < d->nlatent; k++) {
        const lab_latent *l = &d->latent[k];
        for (int i = 0; strcmp(l->joint, joint) == 0 && i < l->n; i++) {
            double reach = fabs(l->force[i]) + 2.0 * l->sd[i];
            most = isfinite(reach) ? fmax(most, reach) : most;
        }
    }
    return most;
}

static void one_force(FILE *f, const lab_diagnosis *d, const lab_latent *l)
{
    double most = force_range(d, l->joint), *lo = malloc(sizeof *lo * 2 * (size_t)(l->n + 1));
    char label[2 * LAB_PLACE];
    if (lo == NULL || l->n < 2) {
        free(lo);
        return;
    }
    for (int i = 0; i < l->n; i++) {
        lo[i] = l->force[i] - 2.0 * l->sd[i];
        lo[l->n + i] = l->force[i] + 2.0 * l->sd[i];
    }
    page__unit u = page__unit_for(l->unit, most);
    page__plot p = plot_at(f, 26.0, 116.0);
    const char *time;
    double sx = time_unit(l->t[0], l->t[l->n - 1], &time);
    p.x0 = sx * l->t[0];
    p.x1 = sx * l->t[l->n - 1];
    p.y1 = u.factor * most;
    p.y0 = -p.y1;
    page__range(&p.x0, &p.x1, 0.0);
    page__range(&p.y0, &p.y1, 0.05);
    fputs("<figure>", f);
    page__svg_open(f, WIDTH, 176,
                   "the force that the model lacks at a joint, with its uncertainty");
    axis_label(label, sizeof label, l->joint, &u);
    page__band(&p, "noise", l->t, lo, lo + l->n, l->n, sx, u.factor);
    page__axes(&p, time, label);
    fprintf(f, "<path class=\"zero\" d=\"M%.1f %.1fh%.1f\"/>\n", p.left, page__y(&p, 0.0), p.width);
    page__curve(&p, "before", l->t, l->force, l->n, sx, u.factor);
    page__svg_close(f);
    fputs("<figcaption>", f);
    page__text(f, base_name(l->file));
    fputs("</figcaption></figure>\n", f);
    free(lo);
}

/* does the missing force differ from zero anywhere, as the map has it? */
static int force_shows(const lab_diagnosis *d)
{
    int yes = 0;
    for (int i = 0; i < d->ndeparture; i++) {
        yes |= d->departure[i].is_force && d->departure[i].z >= page__least_z;
    }
    return yes;
}

void page__forces(FILE *f, const lab_diagnosis *d)
{
    if (d->nlatent == 0) {
        return;
    }
    fputs("<section id=\"forces\"><h2>The force that the model lacks</h2>\n", f);
    if (!force_shows(d)) {
        fprintf(f,
                "<p>At no joint and in no phase is the mean of the missing force %.0f standard "
                "deviations from zero, so its course over time is not drawn: it would show noise. "
                "The fits above use whole records and find effects that are far smaller.</p>\n"
                "</section>\n",
                page__least_z);
        return;
    }
    fputs("<p>On every joint, from the model before anything was added: the force that would make "
          "it agree with the measurement, with twice its standard deviation. Where the band holds "
          "zero, the force there is smaller than these channels show sample by sample.</p>\n"
          "<div class=\"plots\">\n",
          f);
    for (int k = 0; k < d->nlatent; k++) {
        if (k == FORCES) {
            fprintf(f, "</div>\n<details><summary>%d more</summary>\n<div class=\"plots\">\n",
                    d->nlatent - FORCES);
        }
        one_force(f, d, &d->latent[k]);
    }
    fputs(d->nlatent > FORCES ? "</div></details>\n</section>\n" : "</div>\n</section>\n", f);
}
