/* SPDX-License-Identifier: GPL-3.0-or-later
 * columns.c - what every candidate changes at a row, as a secant in its amount.
 *
 *      G_k = (r(x, a_k) - r(x)) / a_k          weighted residuals [limits]
 *
 * An effect may begin one-sided or with zero slope (a gap that is never reached), so a derivative
 * at a = 0 says little: a_k changes the records by a fifth of the noise (RMS). What is only read -
 * a time base, a lens - takes a hundredth: other numbers can do most of what it does, and a bent
 * secant would hide the rest. A part changes them by one noise, and has a second column of a
 * smaller amount: a link that bends a little follows slowly, one that bends more rings. A coupling
 * that lets go does nothing up to an amount; its amount is scanned.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "columns.h"
#include "functions.h"

enum { SIZINGS = 5, SCANNED = 16 };
static const double of_number = 0.2, of_part = 1.0, of_reading = 0.01; /* RMS change [noise] */
static const double smallest = 1e-6;                                   /* amount [limits] */
static const double smaller = 0.2;     /* second column of a part, in the amount of the first */
static const double least_side = -2.0; /* quarters of a range that begins two of them below */
static const char unseen[] = "it would not show in these records";

/* ---- simulating with a candidate ---- */

typedef struct trial {
    const fit__problem *p;
    const double *x, *r0;
    const lab_candidate *candidate; /* [all] of p's mechanism */
    diag__secant **column;
    int first, nrecord; /* records first .. first + nrecord - 1 */
    unsigned char *failed;
    double *square; /* [columns*records] sums of squares of the change */
} trial;

static stein_status ask(void *ctx, fit__bench *b, int job)
{
    const trial *t = ctx;
    const diag__secant *c = t->column[job / t->nrecord];
    int record = t->first + job % t->nrecord;
    fit__problem p = *t->p; // this simulation's: with the candidate in it
    fit__unknown *unknown = malloc(sizeof *unknown * (size_t)p.nu);
    stein_status status = STEIN_ENOMEM;
    if (unknown != NULL) {
        memcpy(unknown, p.unknown, sizeof *unknown * (size_t)p.nu);
        memcpy(b->x, t->x, sizeof *b->x * (size_t)p.nu);
        memset(b->x + p.amount, 0, sizeof *b->x * FIT__NUMBERS);
        p.unknown = unknown;
        fit__problem_try(&p, &t->candidate[c->cause]);
        b->x[p.amount] = c->step;
        b->x[p.amount + 1] = c->side;
        status = fit__begin(&p, b, record, b->x, c->G + fit__offset(t->p, record), NULL);
    }
    free(unknown);
    return status;
}

static void take(void *ctx, fit__bench *b, int job, int failed)
{
    trial *t = ctx;
    const diag__secant *c = t->column[job / t->nrecord];
    int record = t->first + job % t->nrecord;
    const fit__stroke *data = &t->p->stroke[record];
    size_t at = fit__offset(t->p, record), n = (size_t)data->nch * (size_t)data->n;
    (void)b;
    t->failed[job] = (unsigned char)failed;
    if (failed) {
        memset(c->G + at, 0, sizeof *c->G * n);
        return;
    }
    fit__weigh(data, c->G + at);
    t->square[job] = 0.0;
    for (size_t i = at; i < at + n; i++) {
        c->G[i] -= t->r0[i];
        t->square[job] += c->G[i] * c->G[i];
        c->G[i] /= c->step;
    }
}

/* simulates; change [n] out: RMS change of each column, INFINITY where a record failed */
static stein_status run_trial(trial *t, int n, double *change, stein_err *err)
{
    size_t jobs = (size_t)n * (size_t)t->nrecord;
    t->failed = calloc(jobs + 1, 1);
    t->square = calloc(jobs + 1, sizeof *t->square);
    stein_status status = t->failed != NULL && t->square != NULL
                              ? fit__many(t->p, (int)jobs, ask, take, t, err)
                              : lab__no_memory(err);
    double samples = 0.0;
    for (int k = 0; k < t->nrecord; k++) {
        samples += t->p->stroke[t->first + k].samples;
    }
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        double sum = 0.0;
        for (int k = 0; k < t->nrecord; k++) {
            int job = i * t->nrecord + k;
            sum += t->failed[job] ? (double)INFINITY : t->square[job];
        }
        change[i] = sqrt(sum / fmax(1.0, samples));
    }
    free(t->failed);
    free(t->square);
    return status;
}

/* ---- the size of a secant ---- */

static double change_for(const lab_candidate *c)
{
    lab_site site = c->effect->site;
    int read = site == LAB_AT_CHANNEL || site == LAB_AT_MARKER || site == LAB_AT_CLOCK;
    return read ? of_reading : c->effect->needs != NULL ? of_part : of_number;
}

/* a new step for one that made this change. @return 1 when it will do as it is */
static int resize(diag__secant *c, double aim, double change)
{
    if (!isfinite(change)) {
        c->step *= 0.1;
        c->why = c->step < smallest ? "no amount of it can be simulated" : NULL;
        return c->why != NULL;
    }
    if (change > 0.15 * aim && change < 6.0 * aim) {
        return 1;
    }
    if (change < aim && c->step >= 1.0) {
        c->why = change < diag__visible ? unseen : NULL;
        return 1;
    }
    double factor = change > 0.0 ? aim / change : 20.0;
    c->step = fmin(1.0, c->step * fmin(fmax(factor, 1e-3), 20.0));
    return 0;
}

/* steps of these columns, from one record in the middle. @param list  in any order afterwards */
static stein_status size_steps(trial t, diag__secant **list, int n, stein_err *err)
{
    diag__secant **open = malloc(sizeof *open * (size_t)(n + 1));
    double *change = malloc(sizeof *change * (size_t)(n + 1));
    stein_status status = open != NULL && change != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) {
        memcpy(open, list, sizeof *open * (size_t)n);
    }
    t.first = t.p->nstroke / 2;
    t.nrecord = 1;
    t.column = open;
    for (int round = 0; status == STEIN_OK && n > 0 && round < SIZINGS; round++) {
        int left = 0;
        status = run_trial(&t, n, change, err);
        for (int i = 0; status == STEIN_OK && i < n; i++) {
            if (!resize(open[i], change_for(&t.candidate[open[i]->cause]), change[i])) {
                open[left++] = open[i];
            }
        }
        n = left;
    }
    free(open);
    free(change);
    return status;
}

/* ---- columns ---- */

/* columns of candidates that act in the mechanism of p */
static stein_status simulate(diag__work *w, const fit__problem *p, const double *x,
                             const lab_candidate *candidate, diag__secant **list, int n,
                             stein_err *err)
{
    trial t = {.p = p, .x = x, .r0 = w->r, .candidate = candidate, .nrecord = p->nstroke};
    double *change = malloc(sizeof *change * (size_t)(n + 1));
    stein_status status = change != NULL ? size_steps(t, list, n, err) : lab__no_memory(err);
    int left = 0;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        if (list[i]->why == NULL) {
            list[left++] = list[i];
        }
    }
    t.column = list;
    status = status == STEIN_OK ? run_trial(&t, left, change, err) : status;
    for (int i = 0; status == STEIN_OK && i < left; i++) {
        if (!isfinite(change[i])) {
            list[i]->why = "not all records can be simulated with it";
        }
    }
    free(change);
    return status;
}

/* The number of the fit that a candidate moves as well, -1: none. Its column is what the fit knows
 * of it: a secant would differ by its curvature, and thousands of samples would take the difference
 * for knowledge. */
static int number_of(const diag__work *w, const lab_candidate *c)
{
    int plain = c->move == LAB_MOVE_ADD || c->move == LAB_MOVE_SCALE;
    for (int k = 0; plain && c->effect->needs == NULL && c->nparam == 1 && k < w->q->nname; k++) {
        if (w->p.unknown[k].index == c->param[0] && w->p.unknown[k].prior) {
            return k;
        }
    }
    return -1;
}

static void take_derivative(const diag__work *w, diag__secant *c, const lab_candidate *of, int k)
{
    const fit__problem *p = &w->p;
    const fit__unknown *u = &p->unknown[k];
    double per_x = u->sd * fit__slope(u, w->x[k]);
    double per_amount = of->limit * (of->move == LAB_MOVE_ADD ? 1.0 : fit__value(u, w->x[k]));
    double square = 0.0;
    c->step = 1.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        const double *j = w->J + fit__column(p, s, k);
        double *G = c->G + fit__offset(p, s);
        for (int i = 0; i < t->nch * t->n; i++) {
            G[i] = j[i] * per_amount / per_x;
            square += G[i] * G[i];
        }
    }
    c->why = sqrt(square / fmax(1.0, p->samples)) < diag__visible ? unseen : NULL;
}

/* A gap as wide as the motion shows in no record, a smaller one may: columns that show nothing once
 * more, with the number beside the amount at the low end of its range.
 * @param list  [n] room; its contents are lost */
static stein_status from_less(diag__work *w, diag__secant **list, int n, stein_err *err)
{
    const lab_candidate *all = w->row->in->candidate;
    int left = 0;
    for (int i = 0; i < w->n; i++) {
        diag__secant *c = &w->column[i];
        const lab_side *side = &all[c->cause].side[0];
        if (i >= w->row->h.n && c->why == unseen && all[c->cause].effect->needs == NULL &&
            side->param >= 0 && side->lo < side->value && left < n) {
            c->side = least_side;
            c->step = all[c->cause].start;
            c->why = NULL;
            list[left++] = c;
        }
    }
    return left > 0 ? simulate(w, &w->p, w->x, all, list, left, err) : STEIN_OK;
}

static stein_status numbers(diag__work *w, stein_err *err)
{
    diag__secant **list = malloc(sizeof *list * (size_t)(w->n + 1));
    const lab_candidate *all = w->row->in->candidate;
    int n = 0;
    if (list == NULL) {
        return lab__no_memory(err);
    }
    for (int i = w->row->h.n; i < w->n; i++) {
        diag__secant *c = &w->column[i];
        const lab_candidate *of = &all[c->cause];
        int k = c->why == NULL && of->effect->needs == NULL ? number_of(w, of) : -1;
        if (k >= 0) {
            take_derivative(w, c, of, k);
        } else if (!c->ready && c->why == NULL && of->effect->needs == NULL) {
            list[n++] = c;
        }
    }
    stein_status status = simulate(w, &w->p, w->x, all, list, n, err);
    status = status == STEIN_OK ? from_less(w, list, n, err) : status;
    free(list);
    return status;
}

/* the unknowns of one problem as those of another one: x of a mechanism with a part more */
static void translate(const fit__problem *from, const double *x, const fit__problem *to, double *y)
{
    memset(y, 0, sizeof *y * (size_t)to->nu);
    memcpy(y, x, sizeof *y * (size_t)from->amount);
    diag__own_unknowns(from, x, to, y);
}

/* the causes of the row where there is a part more; a copy of them stays in `own` */
static stein_status open_part(diag__work *w, const diag__mechanism *in, lab_dataset *records,
                              lab_candidate *own, fit__problem *p, stein_err *err)
{
    for (int i = 0; i < w->row->h.n; i++) {
        own[i] = diag__bound(w->q, in, w->row->h.cause[i]);
    }
    // the same records as those of the work, in the other mechanism
    int n = 0;
    for (int s = 0; s < w->row->in->fitted->n && n < w->records.n; s++) {
        if (w->row->in->fitted->stroke[s] == w->records.stroke[n]) {
            records->stroke[n++] = in->fitted->stroke[s];
        }
    }
    records->n = n;
    stein_status status =
        fit__problem_make_with(p, in->model, records, w->row->p.def, own, w->row->h.n, err);
    p->tolerance = w->p.tolerance;
    p->gain = w->p.gain;
    p->stride = w->p.stride;
    p->simulated = &w->q->strokes;
    diag__scale_noise(p, w->row->scale);
    return status;
}

/* both columns of a part */
static stein_status part(diag__work *w, diag__secant *c, stein_err *err)
{
    diag__hypothesis h = diag__with(w->row->h, c->cause);
    const diag__mechanism *in = diag__mechanism_of(w->q, &h, err);
    if (in == NULL) {
        return STEIN_ENOMEM;
    }
    if (in->why != NULL) {
        c[0].why = c[1].why = "its part cannot be added";
        return STEIN_OK;
    }
    lab_candidate own[DIAG_CAUSES];
    lab_dataset records = {0, malloc(sizeof(lab_data *) * (size_t)(w->records.n + 1))};
    fit__problem p = {.nstroke = 0};
    double *x = NULL;
    stein_err why = {STEIN_OK, ""};
    stein_status status =
        records.stroke != NULL ? open_part(w, in, &records, own, &p, &why) : lab__no_memory(err);
    if (status == STEIN_OK && (x = malloc(sizeof *x * (size_t)(p.nu + 1))) == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        diag__secant *one = &c[0];
        translate(&w->p, w->x, &p, x);
        status = simulate(w, &p, x, in->candidate, &one, 1, &why);
        c[1].step = smaller * c[0].step;
        c[1].why = c[0].why;
        one = &c[1];
        double change = 0.0;
        trial t = {.p = &p,
                   .x = x,
                   .r0 = w->r,
                   .candidate = in->candidate,
                   .column = &one,
                   .nrecord = p.nstroke};
        if (status == STEIN_OK && c[1].why == NULL) {
            status = run_trial(&t, 1, &change, &why);
            c[1].why = isfinite(change) ? NULL : "not all records can be simulated with it";
        }
    }
    free(x);
    free(records.stroke);
    fit__problem_free(&p);
    if (status != STEIN_OK && status != STEIN_ENOMEM) {
        c[0].why = c[1].why = "its part cannot be simulated";
        return STEIN_OK;
    }
    return status == STEIN_ENOMEM ? lab__no_memory(err) : STEIN_OK;
}

/* What is there or not does nothing up to an amount and much beyond it: of many amounts the one
 * that explains most of the residual by itself. */
static stein_status scan(diag__work *w, diag__secant *c, stein_err *err)
{
    trial t = {.p = &w->p,
               .x = w->x,
               .r0 = w->r,
               .candidate = w->row->in->candidate,
               .column = &c,
               .nrecord = w->p.nstroke};
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    double best = 0.0, change, at = c->step;
    stein_status status = STEIN_OK;
    for (int k = 0; status == STEIN_OK && k < SCANNED; k++) {
        c->step = (k + 1.0) / SCANNED;
        status = run_trial(&t, 1, &change, err);
        double along = -lab__dot(c->G, w->r, rows), size = lab__dot(c->G, c->G, rows);
        double gain = size > 0.0 && along > 0.0 ? along * along / size : 0.0;
        double wish = size > 0.0 ? along / size / c->step : 0.0; // of this amount
        if (isfinite(change) && gain > best && wish > 0.6 && wish < 1.6) {
            best = gain;
            at = c->step;
        }
    }
    c->step = at;
    c->why = NULL;
    return status == STEIN_OK ? run_trial(&t, 1, &change, err) : status;
}

stein_status diag__fill_columns(diag__work *w, stein_err *err)
{
    const lab_candidate *all = w->row->in->candidate;
    stein_status status = numbers(w, err);
    for (int i = w->row->h.n; status == STEIN_OK && i < w->n; i++) {
        diag__secant *c = &w->column[i];
        if (c->ready) {
            continue;
        }
        if (c->why == NULL && all[c->cause].effect->needs != NULL) {
            status = part(w, c, err);
            i++; // its second column
        } else if (all[c->cause].effect->site == LAB_AT_LINK) {
            status = scan(w, c, err);
        }
    }
    return status;
}
