/* SPDX-License-Identifier: GPL-3.0-or-later
 * linear.c - what every candidate changes at a row, all else refitted linearly.
 *
 *      G_k = (r(x, a_k) - r(x)) / a_k          weighted residuals, secant in the amount [limits]
 *      I = G'PG,   s = G'Pr,                   P what numbers, records and scatter leave (mixed.h)
 *      gain(S) = s_S' (I_SS + 1)^-1 s_S - ln det(I_SS + 1)
 *
 * for a set S of columns whose amounts have the prior N(0, 1). The row's own causes are columns
 * like all others, so that what could stand in their place is a question to the same matrix.
 *
 * An effect may begin one-sided or with zero slope (a gap that is never reached), so a derivative
 * at a = 0 says little: a_k changes the records by a fifth of the noise (RMS). What is only read -
 * a time base, a lens - takes a hundredth: other numbers can do most of what it does, and a bent
 * secant would hide the rest. A part changes them by one noise, and has a second column of a
 * smaller amount: a link that bends a little follows slowly, one that bends more rings. A coupling
 * that lets go does nothing up to an amount; its amount is scanned.
 *
 * Rows near the end differ by less than a secant's own change. So columns of a free linear model
 * stay, and serve a row whose residuals differ from those there by no more than that (RMS): their
 * error is of the order of the secant's. Derivatives and residuals are always those of the row.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "search.h"

enum { SIZINGS = 5, SCANNED = 16, RENEWALS = 2, ROUNDS = 12, SET = DIAG_CAUSES + 1 };
static const double of_number = 0.2, of_part = 1.0, of_reading = 0.01; /* RMS change [noise] */
static const double visible = 0.01;  /* less than that at the limit shows in no record [noise] */
static const double smallest = 1e-6; /* amount [limits] */
static const double smaller = 0.2;   /* second column of a part, in the amount of the first */
static const double enough = 0.3;
static const double same_motion = 0.2; /* RMS of a difference of residuals [noise] */
static const char unseen[] = "it would not show in these strokes";

/* a column on its way */
typedef struct column {
    int cause, ready; /* 1: it is there already */
    double step;
    double *G;
    const char *why;
} column;

/* columns of the last free linear model */
struct diag__kept {
    const diag__mechanism *in;
    double scale;
    double *r; /* [rows] residuals where they were made */
    size_t rows;
    column *column;
    int n;
};

typedef struct work {
    diag__problem *q;
    const diag__row *row;
    fit__problem p; /* of the records that are used */
    lab_dataset records;
    double *x, *r, *J;
    column *column;
    int n;
} work;

/* ---- simulating with a candidate ---- */

typedef struct trial {
    const fit__problem *p;
    const double *x, *r0;
    const lab_candidate *candidate; /* [all] of p's mechanism */
    column **column;
    int first, nrecord; /* records first .. first + nrecord - 1 */
    unsigned char *failed;
    double *square; /* [columns*records] sums of squares of the change */
} trial;

static stein_status ask(void *ctx, fit__bench *b, int job)
{
    const trial *t = ctx;
    const column *c = t->column[job / t->nrecord];
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
        status = fit__begin(&p, b, record, b->x, c->G + fit__offset(t->p, record), NULL);
    }
    free(unknown);
    return status;
}

static void take(void *ctx, fit__bench *b, int job, int failed)
{
    trial *t = ctx;
    const column *c = t->column[job / t->nrecord];
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
static int resize(column *c, double aim, double change)
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
        c->why = change < visible ? unseen : NULL;
        return 1;
    }
    double factor = change > 0.0 ? aim / change : 20.0;
    c->step = fmin(1.0, c->step * fmin(fmax(factor, 1e-3), 20.0));
    return 0;
}

/* steps of these columns, from one record in the middle. @param list  in any order afterwards */
static stein_status size_steps(trial t, column **list, int n, stein_err *err)
{
    column **open = malloc(sizeof *open * (size_t)(n + 1));
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
static stein_status simulate(work *w, const fit__problem *p, const double *x,
                             const lab_candidate *candidate, column **list, int n, stein_err *err)
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
            list[i]->why = "not all strokes can be simulated with it";
        }
    }
    free(change);
    return status;
}

/* The number of the fit that a candidate moves as well, -1: none. Its column is what the fit knows
 * of it: a secant would differ by its curvature, and thousands of samples would take the difference
 * for knowledge. */
static int number_of(const work *w, const lab_candidate *c)
{
    int plain =
        c->move == LAB_MOVE_ADD || c->move == LAB_MOVE_RELATIVE || c->move == LAB_MOVE_SCALE;
    for (int k = 0; plain && c->effect->needs == NULL && c->nparam == 1 && k < w->q->nname; k++) {
        if (w->p.unknown[k].index == c->param[0] && w->p.unknown[k].prior) {
            return k;
        }
    }
    return -1;
}

static void take_derivative(const work *w, column *c, const lab_candidate *of, int k)
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
    c->why = sqrt(square / fmax(1.0, p->samples)) < visible ? unseen : NULL;
}

static stein_status numbers(work *w, stein_err *err)
{
    column **list = malloc(sizeof *list * (size_t)(w->n + 1));
    const lab_candidate *all = w->row->in->candidate;
    int n = 0;
    if (list == NULL) {
        return lab__no_memory(err);
    }
    for (int i = w->row->h.n; i < w->n; i++) {
        column *c = &w->column[i];
        const lab_candidate *of = &all[c->cause];
        int k = c->why == NULL && of->effect->needs == NULL ? number_of(w, of) : -1;
        if (k >= 0) {
            take_derivative(w, c, of, k);
        } else if (!c->ready && c->why == NULL && of->effect->needs == NULL) {
            list[n++] = c;
        }
    }
    stein_status status = simulate(w, &w->p, w->x, all, list, n, err);
    free(list);
    return status;
}

/* the unknowns of one problem as those of another one: x of a mechanism with a part more */
static void translate(const fit__problem *from, const double *x, const fit__problem *to, double *y)
{
    memset(y, 0, sizeof *y * (size_t)to->nu);
    memcpy(y, x, sizeof *y * (size_t)from->amount);
    for (int s = 0; s < from->nstroke; s++) {
        const fit__stroke *t = &from->stroke[s];
        for (int k = t->first; k < t->first + t->own; k++) {
            const fit__unknown *v = &from->unknown[k];
            int at = diag__counterpart(to, from, s, v);
            if (at >= 0) {
                const fit__unknown *z = &to->unknown[at];
                y[at] = (v->start + v->sd * x[k] - z->start) / z->sd;
            }
        }
    }
}

/* the causes of the row where there is a part more; a copy of them stays in `own` */
static stein_status open_part(work *w, const diag__mechanism *in, lab_dataset *records,
                              lab_candidate *own, fit__problem *p, stein_err *err)
{
    for (int i = 0; i < w->row->h.n; i++) {
        own[i] = in->candidate[w->row->h.cause[i]];
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
        fit__problem_make_with(p, in->model, records, &w->q->fit_def, own, w->row->h.n, err);
    p->tolerance = w->p.tolerance;
    p->gain = w->p.gain;
    p->stride = w->p.stride;
    p->simulated = &w->q->strokes;
    diag__scale_noise(p, w->row->scale);
    return status;
}

/* both columns of a part */
static stein_status part(work *w, column *c, stein_err *err)
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
        column *one = &c[0];
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
            c[1].why = isfinite(change) ? NULL : "not all strokes can be simulated with it";
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
static stein_status scan(work *w, column *c, stein_err *err)
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

static stein_status fill_columns(work *w, stein_err *err)
{
    const lab_candidate *all = w->row->in->candidate;
    stein_status status = numbers(w, err);
    for (int i = w->row->h.n; status == STEIN_OK && i < w->n; i++) {
        column *c = &w->column[i];
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

/* ---- where it is linear ---- */

/* at most so many records, evenly over their order */
static stein_status choose_records(work *w, int most, stein_err *err)
{
    const lab_dataset *all = w->row->in->fitted;
    int n = all->n < most ? all->n : most;
    w->records.stroke = malloc(sizeof(lab_data *) * (size_t)(n + 1));
    if (w->records.stroke == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < n; k++) {
        w->records.stroke[k] = all->stroke[(2 * k + 1) * all->n / (2 * n)];
    }
    w->records.n = n;
    return STEIN_OK;
}

static void copy_unknowns(work *w)
{
    const fit__problem *from = &w->row->p;
    memcpy(w->x, w->row->x, sizeof *w->x * (size_t)w->p.np);
    memcpy(w->p.step, from->step, sizeof *w->p.step * (size_t)w->p.np);
    for (int s = 0, k = 0; s < from->nstroke && k < w->p.nstroke; s++) {
        if (from->stroke[s].data == w->p.stroke[k].data) {
            size_t n = (size_t)w->p.stroke[k].own;
            memcpy(w->x + w->p.stroke[k].first, w->row->x + from->stroke[s].first,
                   sizeof *w->x * n);
            memcpy(w->p.step + w->p.stroke[k].first, from->step + from->stroke[s].first,
                   sizeof *w->x * n);
            k++;
        }
    }
}

/* the row's derivatives, of the records that are used */
static void copy_derivatives(work *w)
{
    const fit__problem *from = &w->row->p;
    for (int s = 0, k = 0; s < from->nstroke && k < w->p.nstroke; s++) {
        if (from->stroke[s].data == w->p.stroke[k].data) {
            const fit__stroke *t = &from->stroke[s];
            size_t n = (size_t)(t->nch * t->n) * (size_t)(from->np + t->own);
            memcpy(w->J + fit__column(&w->p, k, 0), w->row->J + fit__column(from, s, 0),
                   sizeof *w->J * n);
            k++;
        }
    }
}

/* residuals and derivatives at the row's end, or where the observer that holds it leads */
static stein_status stand(work *w, double gain, int most, stein_err *err)
{
    stein_status status = choose_records(w, most, err);
    status = status == STEIN_OK
                 ? fit__problem_make_with(&w->p, w->row->in->model, &w->records, &w->q->fit_def,
                                          w->row->cause, w->row->h.n, err)
                 : status;
    if (status != STEIN_OK) {
        return status;
    }
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    w->p.tolerance = w->q->null.tolerance;
    w->p.stride = w->q->null.stride;
    w->p.simulated = &w->q->strokes;
    w->x = calloc((size_t)w->p.nu + rows + fit__columns(&w->p) + 1, sizeof *w->x);
    if (w->x == NULL) {
        return lab__no_memory(err);
    }
    w->r = w->x + w->p.nu;
    w->J = w->r + rows;
    copy_unknowns(w);
    diag__scale_noise(&w->p, w->row->scale);
    w->p.gain = gain;
    diag__hold_scatter(&w->p, gain > 0.0);
    int failed = 0;
    if (gain > 0.0) {
        fit__end e = {.x = w->x, .J = w->J, .r = w->r};
        status = fit__descend(&w->p, &e, 0, enough, RENEWALS, err);
    } else {
        status = fit__residuals(&w->p, w->x, w->r, &failed, err);
    }
    if (status == STEIN_OK && failed > 0) {
        return lab__fail(err, STEIN_ENONFINITE, "%d strokes cannot be simulated", failed);
    }
    if (status == STEIN_OK && gain <= 0.0 && w->row->J != NULL) {
        copy_derivatives(w);
        return STEIN_OK;
    }
    return status == STEIN_OK ? fit__sensitivities(&w->p, w->x, w->r, w->J, err) : status;
}

/* ---- the matrix ---- */

static stein_status reduce(work *w, const double **G, diag__linear *l, stein_err *err)
{
    lab__mixed m = {.nf = 0};
    for (int i = 0; i < l->own; i++) { // a column, no longer a number of all
        w->p.unknown[w->p.first_accepted + FIT__NUMBERS * i].idle = 1;
    }
    stein_status status = diag__mixed_at(&m, &w->p, w->x, w->J, w->r, G, l->n, err);
    double *beta = malloc(sizeof *beta * (size_t)(m.nf + l->own + 1));
    int with[DIAG_CAUSES] = {0, 1, 2};
    if (status == STEIN_OK && beta == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        lab__mixed_scatter(&m, with, l->own, ROUNDS, beta, NULL);
        lab__mixed_weigh(&m);
        status = lab__mixed_project(&m, l->I, l->s, &l->square) ? STEIN_OK : lab__no_memory(err);
    }
    free(beta);
    lab__mixed_free(&m);
    return status;
}

/* columns that can be asked for: two of a part. @return their number */
static int list_columns(const work *w, diag__linear *l, column *list)
{
    int n = 0;
    for (int i = 0; i < w->row->h.n; i++) {
        list[n++] = (column){.cause = w->row->h.cause[i], .step = 1.0};
    }
    for (int k = 0; k < w->q->n; k++) {
        const lab_candidate *c = &w->q->candidate[k];
        l->unseen[k] = w->q->untestable[k];
        if (l->unseen[k] != NULL || diag__has(&w->row->h, k)) {
            continue;
        }
        int two = c->effect->needs != NULL;
        if (two && l->own == DIAG_CAUSES) {
            l->unseen[k] = "as many causes are there as can act together";
            continue;
        }
        for (int i = 0; i < 1 + two; i++) {
            list[n++] =
                (column){.cause = k, .step = w->q->step[k] > 0.0 ? w->q->step[k] : c->start};
        }
    }
    return n;
}

/* ---- columns that are kept ---- */

void diag__kept_free(struct diag__kept *k)
{
    if (k != NULL) {
        for (int i = 0; i < k->n; i++) {
            free(k->column[i].G);
        }
        free(k->column);
        free(k->r);
        free(k);
    }
}

/* do they serve where this one is linear? */
static int serves(const struct diag__kept *k, const work *w)
{
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    double sum = 0.0;
    // the scale of the noise is that of residuals and columns
    if (k == NULL || w->p.gain > 0.0 || k->in != w->row->in || k->rows != rows ||
        fabs(k->scale - w->row->scale) > 0.0) {
        return 0;
    }
    for (size_t i = 0; i < rows; i++) {
        sum += (k->r[i] - w->r[i]) * (k->r[i] - w->r[i]);
    }
    return sqrt(sum / fmax(1.0, w->p.samples)) <= same_motion;
}

/* columns that are there already; of a part both come one after the other in either list */
static void take_kept(work *w)
{
    struct diag__kept *kept = w->q->kept;
    int at = 0;
    for (int i = w->row->h.n; serves(kept, w) && i < w->n; i++) {
        column *c = &w->column[i];
        while (at < kept->n && kept->column[at].cause < c->cause) {
            at++;
        }
        if (at < kept->n && kept->column[at].cause == c->cause) {
            *c = kept->column[at];
            c->ready = 1;
            kept->column[at++].G = NULL;
        }
    }
}

/* Those of a free linear model stay. Where some were there already, all count as made where those
 * were, so that differences cannot add up from row to row. */
static stein_status keep(work *w, stein_err *err)
{
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    struct diag__kept *k = calloc(1, sizeof *k), *old = w->q->kept;
    if (k == NULL || (k->r = malloc(sizeof *k->r * (rows + 1))) == NULL) {
        free(k);
        return lab__no_memory(err);
    }
    int reused = serves(old, w);
    memcpy(k->r, reused ? old->r : w->r, sizeof *k->r * rows);
    k->in = w->row->in;
    k->scale = w->row->scale;
    k->rows = rows;
    for (int i = 0; i < w->row->h.n; i++) {
        free(w->column[i].G);
    }
    k->n = w->n - w->row->h.n;
    memmove(w->column, w->column + w->row->h.n, sizeof *w->column * (size_t)k->n);
    k->column = w->column;
    w->column = NULL;
    w->n = 0;
    diag__kept_free(old);
    w->q->kept = k;
    return STEIN_OK;
}

static stein_status make_room(work *w, stein_err *err)
{
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    stein_status status = STEIN_OK;
    take_kept(w);
    for (int i = 0; status == STEIN_OK && i < w->n; i++) {
        column *c = &w->column[i];
        if (c->ready) {
            continue;
        }
        c->G = i < w->row->h.n ? diag__column(&w->p, w->J, w->p.first_accepted + FIT__NUMBERS * i)
                               : calloc(rows + 1, sizeof *c->G);
        status = c->G != NULL ? STEIN_OK : lab__no_memory(err);
    }
    return status;
}

/* what can be seen goes to the matrix */
static stein_status keep_columns(work *w, diag__linear *l, stein_err *err)
{
    const double **G = malloc(sizeof *G * (size_t)(w->n + 1));
    size_t n = (size_t)w->n + 1;
    l->cause = calloc(n, sizeof *l->cause);
    l->step = malloc(sizeof *l->step * n);
    l->I = malloc(sizeof *l->I * n * n);
    l->s = malloc(sizeof *l->s * n);
    stein_status status = G && l->cause && l->step && l->I && l->s ? STEIN_OK : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < w->n; i++) {
        const column *c = &w->column[i];
        if (c->why == NULL) {
            int first = i == 0 || w->column[i - 1].cause != c->cause;
            w->q->step[c->cause] = first && i >= l->own ? c->step : w->q->step[c->cause];
            G[l->n] = c->G;
            l->step[l->n] = c->step;
            l->cause[l->n++] = c->cause;
            l->unseen[c->cause] = NULL;
        } else if (l->unseen[c->cause] == NULL) {
            l->unseen[c->cause] = c->why;
        }
    }
    for (int i = 0; status == STEIN_OK && i < l->n; i++) {
        l->unseen[l->cause[i]] = NULL;
    }
    status = status == STEIN_OK ? reduce(w, G, l, err) : status;
    free(G);
    return status;
}

stein_status diag__linearise(diag__problem *q, const diag__row *row, double gain, int most,
                             diag__linear *l, stein_err *err)
{
    work w = {.q = q, .row = row, .p = {.nstroke = 0}};
    *l = (diag__linear){.row = row, .gain = gain, .own = row->h.n};
    l->unseen = calloc((size_t)q->n + 1, sizeof *l->unseen);
    w.column = malloc(sizeof *w.column * (size_t)(2 * q->n + DIAG_CAUSES + 1));
    stein_status status =
        l->unseen != NULL && w.column != NULL ? stand(&w, gain, most, err) : lab__no_memory(err);
    w.n = status == STEIN_OK ? list_columns(&w, l, w.column) : 0;
    status = status == STEIN_OK ? make_room(&w, err) : status;
    status = status == STEIN_OK ? fill_columns(&w, err) : status;
    status = status == STEIN_OK ? keep_columns(&w, l, err) : status;
    status = status == STEIN_OK && gain <= 0.0 ? keep(&w, err) : status;
    if (status != STEIN_OK) { // some of them are here
        diag__kept_free(q->kept);
        q->kept = NULL;
    }
    l->samples = w.p.samples;
    for (int i = 0; i < w.n; i++) {
        free(w.column[i].G);
    }
    free(w.column);
    free(w.x);
    free(w.records.stroke);
    fit__problem_free(&w.p);
    return status;
}

void diag__linear_free(diag__linear *l)
{
    free(l->cause);
    free(l->step);
    free(l->I);
    free(l->s);
    free(l->unseen);
    *l = (diag__linear){.n = 0};
}

double diag__linear_gain(const diag__linear *l, const int *set, int n, double *amount)
{
    double a[SET * SET], gain = 0.0;
    gsl_matrix_view A = gsl_matrix_view_array(a, (size_t)(n > 0 ? n : 1), (size_t)(n > 0 ? n : 1));
    if (n <= 0 || n > SET) {
        return 0.0;
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): set has n numbers
            a[i * n + k] = l->I[(size_t)set[i] * (size_t)l->n + (size_t)set[k]] + (i == k);
        }
        amount[i] = l->s[set[i]];
    }
    gsl_vector_view v = gsl_vector_view_array(amount, (size_t)n);
    if (gsl_linalg_cholesky_decomp1(&A.matrix) != 0) {
        return -INFINITY;
    }
    gsl_linalg_cholesky_svx(&A.matrix, &v.vector);
    for (int i = 0; i < n; i++) {
        gain += l->s[set[i]] * amount[i] - 2.0 * stein__log_of(a[i * n + i]);
    }
    return gain;
}

double diag__likeness(const diag__linear *l, int a, int b)
{
    size_t n = (size_t)l->n, i = (size_t)a, k = (size_t)b;
    double size = sqrt(l->I[i * n + i] * l->I[k * n + k]);
    return size > 0.0 ? fabs(l->I[i * n + k]) / size : 0.0;
}

double diag__expected(const diag__linear *l, double gain)
{
    int own[DIAG_CAUSES] = {0, 1, 2};
    double amount[SET], has = diag__linear_gain(l, own, l->own, amount);
    const diag__row *row = l->row;
    if (l->gain == 0.0) {
        double all = row->p.samples / fmax(1.0, l->samples); // records that were not used
        return row->objective - all * (gain - has);
    }
    double excess = fmax(0.0, fit__chi2(&row->p, row->r) - row->p.samples);
    double left = fmax(l->square - has - l->samples, 1.0);
    return row->objective - excess * fmin(1.0, (gain - has) / left);
}
