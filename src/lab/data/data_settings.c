/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_settings.c - does the motion of every stroke agree with its `# set` lines?
 *
 * A stroke with a wrong setting (files mixed up, grams read as kilograms, a sign) is no evidence of
 * missing physics. One of them among twelve is enough to find a false effect. How far a stroke is
 * off,
 *
 *      D(v) = min over tau and offsets of RMS (y - offset - h(t + tau; v)) / range of y,
 *
 * is computed with the numbers of the file and the settings v of the stroke. Wrong numbers and
 * missing physics of the size that a diagnosis is for leave D at one or two per cent, and alike in
 * all strokes. A stroke that is far off is reported when
 *
 *   - the same digits of a setting in another power of ten explain its record (as well as the
 *     others, if most of them are well explained), or
 *   - most strokes are well explained, and another value of a setting - one that another stroke
 *     has, the other sign - explains this one as well as the others, or
 *   - most strokes are well explained, this one is off by much of its travel, and nothing helps.
 *
 * Only values that a slip of the pen gives are searched. A free search would always find some
 * value that is better, and a wrong spring would be called a wrong setting. For the same reason the
 * second and the third need other strokes that fit. Where the model is far from all of them, a
 * stroke that just escapes and one that just does not differ much, with correct settings. A stroke
 * that slightly more or less friction explains is no contradiction.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"
#include "data_compare.h"
#include "fitting.h"

/* share of the travel from which on a stroke is suspicious, and largest share for most strokes;
 * factors */
static const double suspected = 0.04, far_off = 0.25, well = 0.012;
static const double seen = 0.01; /* less is within the scatter of strokes */
static const double worse = 5.0, much_worse = 10.0, explained = 4.0, usual = 2.0;
static const double largest_nudge = 3.0; /* of scatter, in its prior sd */
enum {
    SHIFTS = 41,       /* of the trigger, over +-3 of its prior sd */
    PATIENCE = 200000, /* evaluations of a stroke as stated; of many samples 100 each */
    A_SAMPLE = 100,
    NUDGES = 6,
    TIMES = 8 /* so many times the evaluations of a stroke: one with other settings */
};

typedef struct check {
    fit__problem *p;
    fit__bench bench;
    double *x, *y;  /* [nu] zeros; prediction of a stroke */
    double *misfit; /* [nstroke] */
    double median;
    lab_report_fn *report;
    void *ctx;
    data__patience run; /* of the present stroke */
    long most;          /* evaluations of any stroke so far */
    int told;
    stein_status failed;
} check;

/* ---- how far a stroke is off ---- */

static double range(const double *y, int n)
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < n; i++) {
        low = fmin(low, isnan(y[i]) ? low : y[i]);
        high = fmax(high, isnan(y[i]) ? high : y[i]);
    }
    return high - low;
}

/* prediction h [n] at the times t, read tau later */
static double shifted(const double *t, const double *h, int n, double at, int *k)
{
    while (*k + 2 < n && t[*k + 1] < at) {
        ++*k;
    }
    double u = (at - t[*k]) / (t[*k + 1] - t[*k]);
    u = fmin(fmax(u, 0.0), 1.0);
    return h[*k] + u * (h[*k + 1] - h[*k]);
}

/* sum of squares of one channel's error about its mean, as a share of its range */
static double off_by(const fit__stroke *s, int c, const double *predicted, double tau, int *count)
{
    size_t first = (size_t)c * (size_t)s->n;
    const double *y = s->y + first, *h = predicted + first, *t = s->data->time;
    double sum = 0.0, squares = 0.0, span = range(y, s->n);
    int n = 0, k = 0;
    for (int i = 0; span > 0.0 && i < s->n; i++) {
        double there = s->event[c].is ? h[i] - tau : shifted(t, h, s->n, t[i] + tau, &k);
        double r = (y[i] - there) / span;
        if (!isnan(r)) {
            sum += r;
            squares += r * r;
            n++;
        }
    }
    *count += n;
    return n > 0 ? squares - sum * sum / n : 0.0;
}

static double misfit(check *c, int stroke)
{
    const fit__stroke *s = &c->p->stroke[stroke];
    double best = INFINITY, reach = s->tau >= 0 ? 3.0 * c->p->def->trigger : 0.0;
    c->run.used = 0;
    stein_status status = fit__simulate(c->p, &c->bench, stroke, c->x, c->y, NULL);
    if (status != STEIN_OK) {
        c->failed = status == STEIN_ENOMEM ? status : c->failed;
        return INFINITY; // with these settings it does not move at all
    }
    c->most = c->run.used > c->most ? c->run.used : c->most;
    for (int i = 0; s->n > 1 && i < (reach > 0.0 ? SHIFTS : 1); i++) {
        double sum = 0.0, tau = reach * (2.0 * i / (SHIFTS - 1) - 1.0);
        int n = 0;
        for (int k = 0; k < s->nch; k++) {
            sum += off_by(s, k, c->y, reach > 0.0 ? tau : 0.0, &n);
        }
        best = n > 0 ? fmin(best, sqrt(sum / n)) : best;
    }
    return best;
}

/* the same with another value of setting k, or with one setting more: k = nset */
static double misfit_with(check *c, int stroke, int k, int param, double value)
{
    fit__stroke *s = &c->p->stroke[stroke];
    const lab_data *own = s->data;
    lab_data other = *own;
    lab_setting *set = malloc(sizeof *set * ((size_t)own->nset + 1));
    if (set == NULL) {
        c->failed = STEIN_ENOMEM;
        return INFINITY;
    }
    memcpy(set, own->set, sizeof *set * (size_t)own->nset);
    set[k].param = param;
    set[k].value = value;
    other.set = set;
    other.nset = k < own->nset ? own->nset : own->nset + 1;
    s->data = &other;
    double off = misfit(c, stroke);
    s->data = own;
    free(set);
    return off;
}

/* ---- another value ---- */

typedef struct guess {
    int set, decimal; /* decimal: the same digits */
    double value, misfit;
} guess;

static void try_value(check *c, int stroke, int k, double value, int decimal, guess *best)
{
    const lab_setting *set = &c->p->stroke[stroke].data->set[k];
    if (fabs(value - set->value) <= 0.05 * fabs(set->value)) {
        return;
    }
    double off = misfit_with(c, stroke, k, set->param, value);
    // of two explanations a value with the same digits is the likelier slip
    if (off < best->misfit * (decimal ? 1.0 : best->decimal ? 0.5 : 1.0)) {
        *best = (guess){k, decimal, value, off};
    }
}

/* is there a setting of this parameter with this value in an earlier stroke? */
static int was_tried(const fit__problem *p, int before, int param, double value)
{
    for (int o = 0; o < before; o++) {
        const lab_data *d = p->stroke[o].data;
        for (int i = 0; i < d->nset; i++) {
            if (d->set[i].param == param && !(fabs(d->set[i].value - value) > 0.0)) {
                return 1;
            }
        }
    }
    return 0;
}

static guess look_further(check *c, int stroke)
{
    const lab_data *d = c->p->stroke[stroke].data;
    guess best = {-1, 0, NAN, INFINITY};
    for (int k = 0; k < d->nset; k++) {
        int param = d->set[k].param;
        for (int exponent = -4; exponent <= 4; exponent++) {
            try_value(c, stroke, k, d->set[k].value * pow(10.0, exponent), 1, &best);
        }
        try_value(c, stroke, k, -d->set[k].value, 0, &best);
        for (int o = 0; o < c->p->nstroke; o++) {
            const lab_data *other = c->p->stroke[o].data;
            for (int i = 0; i < other->nset; i++) {
                if (other->set[i].param == param &&
                    !was_tried(c->p, o, param, other->set[i].value)) {
                    try_value(c, stroke, k, other->set[i].value, 0, &best);
                }
            }
        }
    }
    return best;
}

/* to one side and the other in turn, farther each time */
static double nudge(int i)
{
    int level = i / 2 + 1, levels = NUDGES / 2;
    return (i % 2 == 0 ? 1.0 : -1.0) * largest_nudge * level / levels;
}

/* does a slight change of scattering quantities (friction, drive) explain the stroke, too? */
static int is_moved_by_scatter(check *c, int stroke)
{
    const fit__stroke *s = &c->p->stroke[stroke];
    for (int k = s->first; k < s->first + s->own; k++) {
        for (int i = 0; c->p->unknown[k].kind == FIT__SCATTER && i < NUDGES; i++) {
            c->x[k] = nudge(i);
            double off = misfit(c, stroke);
            c->x[k] = 0.0;
            if (off < c->misfit[stroke] / explained) {
                return 1;
            }
        }
    }
    return 0;
}

/* or a number of the file that is wrong by a few of its tolerances? */
static int is_moved_by_tolerance(check *c, int stroke)
{
    const lab_data *d = c->p->stroke[stroke].data;
    for (int i = 0; i < d->model->np; i++) {
        const stein_param *q = &d->model->params[i];
        for (int k = 0; q->tolerance > 0.0 && !fit__is_set(d, i) && k < NUDGES; k++) {
            double by = nudge(k);
            double off = misfit_with(c, stroke, d->nset, i, q->value + by * q->tolerance);
            if (off < c->misfit[stroke] / explained) {
                return 1;
            }
        }
    }
    return 0;
}

/* Then it stands at an edge: it just escapes, or bounces once more, and with the file's numbers it
 * just does not: no error. */
static int stands_at_edge(check *c, int stroke)
{
    return is_moved_by_scatter(c, stroke) || is_moved_by_tolerance(c, stroke);
}

/* ---- telling ---- */

static void tell(check *c, const lab_data *d, const lab_setting *set, const guess *g, double own)
{
    const stein_param *q = &d->model->params[set->param];
    char said[DATA_SHOWN], fits[DATA_SHOWN], off[40] = "it cannot move with that", rest[60] = "";
    data__quantity(said, set->value, q->unit);
    if (isfinite(own)) {
        snprintf(off, sizeof off, "off by %.2g %% of its travel", 100.0 * own);
    }
    if (c->p->nstroke > 2 && isfinite(c->median)) {
        snprintf(rest, sizeof rest, ", most records %.2g %%", 100.0 * c->median);
    }
    char *text = g != NULL
                     ? lab__text("%s:%d:%d: the record contradicts its own \"# set %s: %s\": %s%s; "
                                 "with %s it is off by %.2g %%",
                                 d->file, set->line, set->column, set->name, said, off, rest,
                                 data__quantity(fits, g->value, q->unit), 100.0 * g->misfit)
                     : lab__text("%s:%d:%d: the record contradicts its own settings: %s%s", d->file,
                                 set->line, set->column, off, rest);
    if (text != NULL && c->report != NULL) {
        c->report(c->ctx, text);
    }
    free(text);
    c->told++;
}

/* where a stroke begins is not known: unknown before a fit */
static int begins_anywhere(const check *c, int stroke)
{
    const fit__stroke *s = &c->p->stroke[stroke];
    for (int k = s->first; k < s->first + s->own; k++) {
        fit__kind kind = c->p->unknown[k].kind;
        if (kind == FIT__POSITION || kind == FIT__SPEED) {
            return 1;
        }
    }
    return 0;
}

static void judge(check *c, int stroke)
{
    const lab_data *d = c->p->stroke[stroke].data;
    double own = c->misfit[stroke];
    int others_fit = c->p->nstroke > 3 && c->median < well;
    int stands_out = others_fit && own > worse * c->median && own > seen;
    if (d->nset == 0 || !(own > suspected || stands_out) || begins_anywhere(c, stroke)) {
        return;
    }
    guess g = look_further(c, stroke);
    int better = g.set >= 0 && g.misfit < own / explained;
    double as_good = others_fit ? usual * c->median : well;
    int by_digits = g.decimal && g.misfit < own / (2.0 * explained) && g.misfit < as_good;
    int like_others = others_fit && own > worse * c->median && g.misfit < usual * c->median;
    if (better && (by_digits || like_others)) {
        if (stands_at_edge(c, stroke)) {
            return;
        }
        tell(c, d, &d->set[g.set], &g, own);
    } else if (!isfinite(own) || (others_fit && own > far_off && own > much_worse * c->median)) {
        tell(c, d, &d->set[0], NULL, own);
    }
}

/* ---- all strokes ---- */

static stein_status judge_all(check *c, stein_err *err)
{
    int n = c->p->nstroke;
    c->x = calloc((size_t)c->p->nu + 1, sizeof *c->x);
    c->y = calloc((size_t)c->p->rows + 1, sizeof *c->y);
    c->misfit = calloc(2 * (size_t)n + 1, sizeof *c->misfit);
    if (c->x == NULL || c->y == NULL || c->misfit == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = fit__bench_make(&c->bench, c->p, err);
    c->bench.force = data__lose_patience;
    c->bench.force_ctx = &c->run;
    for (int s = 0; status == STEIN_OK && s < n; s++) {
        long many = (long)A_SAMPLE * c->p->stroke[s].n;
        c->run.most = many > PATIENCE ? many : PATIENCE;
        c->misfit[s] = c->misfit[n + s] = misfit(c, s);
    }
    c->run.most = TIMES * (c->most > 0 ? c->most : PATIENCE);
    gsl_sort(c->misfit + n, 1, (size_t)n);
    c->median = c->misfit[n + (n - 1) / 2];

    for (int s = 0; status == STEIN_OK && s < n; s++) {
        judge(c, s);
    }
    fit__bench_free(&c->bench);
    if (status == STEIN_OK && c->failed != STEIN_OK) {
        return lab__no_memory(err);
    }
    return status == STEIN_OK && c->told > 0
               ? lab__fail(err, STEIN_EPARSE, "%d record%s its own settings", c->told,
                           c->told == 1 ? " contradicts" : "s contradict")
               : status;
}

/* a parameter that no record sets: the fit needs one that is free */
static int find_free(const lab_dataset *data)
{
    const stein_model *m = data->stroke[0]->model;
    for (int i = 0; i < m->np; i++) {
        int set = !(m->params[i].value > 0.0);
        for (int s = 0; !set && s < data->n; s++) {
            for (int k = 0; k < data->stroke[s]->nset; k++) {
                set |= data->stroke[s]->set[k].param == i;
            }
        }
        if (!set) {
            return i;
        }
    }
    return -1;
}

stein_status lab_data_check_settings(const lab_dataset *data, const lab_model *model,
                                     lab_report_fn *report, void *ctx, stein_err *err)
{
    fit__problem p;
    int any = 0, free_one = data->n > 0 ? find_free(data) : -1;
    for (int s = 0; s < data->n; s++) {
        any |= data->stroke[s]->nset > 0;
    }
    if (!any || free_one < 0) {
        return STEIN_OK;
    }
    const char *name = lab_equations(model)->params[free_one].name;
    lab_fit_def def = lab_fit_def_default();
    def.free = &name;
    def.nfree = 1;
    stein_status status = fit__problem_make(&p, model, data, &def, err);
    if (status == STEIN_OK) {
        p.tolerance = 1e-8;
        check c = {.p = &p, .report = report, .ctx = ctx};
        status = judge_all(&c, err);
        free(c.x);
        free(c.y);
        free(c.misfit);
    } else if (status == STEIN_EINVAL) {
        status = STEIN_OK; // too little to compare with
    }
    fit__problem_free(&p);
    return status;
}
