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
 * Rows near the end differ by less than a secant's own change. So columns of a free linear model
 * are kept for a row whose residuals differ from those there by no more than that (RMS). Their
 * error is of the order of the secant's. Derivatives and residuals are always those of the row.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "columns.h"
#include "functions.h"
#include "scope_columns.h"

enum { RENEWALS = 2, ROUNDS = 12, SET = DIAG_CAUSES + 1 };
static const double same_motion = 0.2; /* RMS of a difference of residuals [noise] */

/* columns of the last free linear model */
struct diag__kept {
    const diag__mechanism *in;
    double scale;
    double *r; /* [rows] residuals where they were made */
    size_t rows;
    diag__secant *column;
    int n;
};

/* ---- where it is linear ---- */

/* at most so many records, evenly over their order */
static stein_status choose_records(diag__work *w, int most, stein_err *err)
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

static void copy_unknowns(diag__work *w)
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
static void copy_derivatives(diag__work *w)
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
static stein_status stand(diag__work *w, double gain, int most, stein_err *err)
{
    stein_status status = choose_records(w, most, err);
    status = status == STEIN_OK
                 ? fit__problem_make_with(&w->p, w->row->in->model, &w->records, w->row->p.def,
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
        status = fit__descend(&w->p, &e, 0, diag__fit_ends, RENEWALS, err);
    } else {
        status = fit__residuals(&w->p, w->x, w->r, &failed, err);
    }
    if (status == STEIN_OK && failed > 0) {
        return lab__fail(err, STEIN_ENONFINITE, "%d records cannot be simulated", failed);
    }
    if (status == STEIN_OK && gain <= 0.0 && w->row->J != NULL) {
        copy_derivatives(w);
        return STEIN_OK;
    }
    return status == STEIN_OK ? fit__sensitivities(&w->p, w->x, w->r, w->J, err) : status;
}

/* ---- the matrix ---- */

/* the records with n columns, the row's own ones first, at the variances of the row */
static stein_status weigh(diag__work *w, const double **G, int n, int own, lab__mixed *m,
                          stein_err *err)
{
    *m = (lab__mixed){.nf = 0};
    for (int i = 0; i < own; i++) { // a column, no longer a number of all
        w->p.unknown[w->p.first_accepted + FIT__NUMBERS * i].idle = 1;
    }
    stein_status status = diag__mixed_at(m, &w->p, w->x, w->J, w->r, G, n, err);
    double *beta = malloc(sizeof *beta * (size_t)(m->nf + own + 1));
    int with[DIAG_CAUSES] = {0, 1, 2};
    if (status == STEIN_OK && beta == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK && w->q->most_scatter) {
        for (int k = 0; k < m->nclass; k++) {
            m->D[k] = m->limit[k].most;
        }
    } else if (status == STEIN_OK) {
        lab__mixed_scatter(m, with, own, ROUNDS, beta, NULL);
    }
    if (status == STEIN_OK) {
        lab__mixed_weigh(m);
    }
    free(beta);
    return status;
}

static stein_status reduce(diag__work *w, const double **G, diag__linear *l, stein_err *err)
{
    lab__mixed m;
    stein_status status = weigh(w, G, l->n, l->own, &m, err);
    if (status == STEIN_OK && !lab__mixed_project(&m, l->I, l->s, &l->square)) {
        status = lab__fail(err, STEIN_ENONFINITE, "what is refitted has no finite derivatives");
    }
    lab__mixed_free(&m);
    return status;
}

/* a column in the records where a cause acts, freed by the caller; NULL: no memory */
static double *part_of(const diag__work *w, const double *G, const lab_candidate *c)
{
    double *to = calloc(fit__offset(&w->p, w->p.nstroke) + 1, sizeof *to);
    for (int s = 0; to != NULL && s < w->p.nstroke; s++) {
        size_t at = fit__offset(&w->p, s), n = fit__offset(&w->p, s + 1) - at;
        if (lab_candidate_acts(c, w->p.stroke[s].data->number)) {
            memcpy(to + at, G + at, sizeof *to * n);
        }
    }
    return to;
}

/* columns of causes in a part of the records, made of those of the candidates, behind all others
 */
static stein_status add_scoped(diag__work *w, const double **G, const int *base, int nbase, int own,
                               stein_err *err)
{
    int cause[DIAG_SCOPED], n = 0;
    lab__mixed m;
    stein_status status = weigh(w, G, nbase, own, &m, err);
    if (status == STEIN_OK) {
        status = diag__choose_scopes(w->q, w->row, &w->p, &m, base, nbase, cause, &n, err);
    }
    lab__mixed_free(&m);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        const lab_candidate c = diag__candidate(w->q, cause[i]);
        int k = own;
        while (diag__base(w->q, base[k]) != diag__base(w->q, cause[i])) {
            k++;
        }
        diag__secant *to = &w->column[w->n++];
        *to = (diag__secant){.cause = cause[i], .step = 1.0, .G = part_of(w, G[k], &c)};
        status = to->G != NULL ? STEIN_OK : lab__no_memory(err);
    }
    return status;
}

/* columns that can be asked for: two of a part. @return their number */
static int list_columns(const diag__work *w, diag__linear *l, diag__secant *list)
{
    int n = 0;
    for (int i = 0; i < w->row->h.n; i++) {
        list[n++] = (diag__secant){.cause = w->row->h.cause[i], .step = 1.0};
    }
    for (int k = 0; k < w->q->n + w->q->nsetting; k++) {
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
                (diag__secant){.cause = k, .step = w->q->step[k] > 0.0 ? w->q->step[k] : c->start};
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
static int serves(const struct diag__kept *k, const diag__work *w)
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
static void take_kept(diag__work *w)
{
    struct diag__kept *kept = w->q->kept;
    int at = 0;
    for (int i = w->row->h.n; serves(kept, w) && i < w->n; i++) {
        diag__secant *c = &w->column[i];
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
static stein_status keep(diag__work *w, stein_err *err)
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

static stein_status make_room(diag__work *w, stein_err *err)
{
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    stein_status status = STEIN_OK;
    take_kept(w);
    for (int i = 0; status == STEIN_OK && i < w->n; i++) {
        diag__secant *c = &w->column[i];
        if (c->ready) {
            continue;
        }
        c->G = i < w->row->h.n ? diag__column(&w->p, w->J, w->p.first_accepted + FIT__NUMBERS * i)
                               : calloc(rows + 1, sizeof *c->G);
        status = c->G != NULL ? STEIN_OK : lab__no_memory(err);
    }
    return status;
}

/* columns that can be seen: G and cause of each [w->n], how many there are */
static int list_visible(const diag__work *w, const double **G, int *cause)
{
    int n = 0;
    for (int i = 0; i < w->n; i++) {
        if (w->column[i].why == NULL) {
            G[n] = w->column[i].G;
            cause[n++] = w->column[i].cause;
        }
    }
    return n;
}

/* why a candidate has no column, if it has none; with which step it was made */
static void note_unseen(const diag__work *w, diag__linear *l)
{
    for (int i = l->own; i < w->n; i++) {
        const diag__secant *c = &w->column[i];
        int first = i == 0 || w->column[i - 1].cause != c->cause;
        if (c->why != NULL && l->unseen[c->cause] == NULL) {
            l->unseen[c->cause] = c->why;
        } else if (c->why == NULL && first) {
            w->q->step[c->cause] = c->step;
        }
    }
    for (int i = l->own; i < w->n; i++) {
        if (w->column[i].why == NULL) {
            l->unseen[w->column[i].cause] = NULL;
        }
    }
}

/* what can be seen goes to the matrix; a setting in one record alone */
static stein_status keep_columns(diag__work *w, diag__linear *l, stein_err *err)
{
    size_t n = (size_t)w->n + DIAG_SCOPED + 1;
    const double **G = malloc(sizeof *G * n);
    l->cause = calloc(n, sizeof *l->cause);
    l->step = malloc(sizeof *l->step * n);
    l->side = calloc(n, sizeof *l->side);
    l->price = malloc(sizeof *l->price * n);
    l->I = malloc(sizeof *l->I * n * n);
    l->s = malloc(sizeof *l->s * n);
    stein_status status = G && l->cause && l->step && l->side && l->price && l->I && l->s
                              ? STEIN_OK
                              : lab__no_memory(err);
    if (status == STEIN_OK) {
        note_unseen(w, l);
        int nbase = list_visible(w, G, l->cause);
        status = add_scoped(w, G, l->cause, nbase, l->own, err);
    }
    for (int i = 0; status == STEIN_OK && i < w->n; i++) {
        const diag__secant *c = &w->column[i];
        int base_only = c->cause >= w->q->n && !diag__is_scoped(w->q, c->cause);
        if (c->why == NULL && !base_only) {
            G[l->n] = c->G;
            l->step[l->n] = c->step;
            l->side[l->n] = c->side < 0.0 ? c->side : NAN;
            l->price[l->n] = diag__price(w->q, c->cause);
            l->cause[l->n++] = c->cause;
        }
    }
    status = status == STEIN_OK ? reduce(w, G, l, err) : status;
    free(G);
    return status;
}

stein_status diag__linearise(diag__problem *q, const diag__row *row, double gain, int most,
                             diag__linear *l, stein_err *err)
{
    diag__work w = {.q = q, .row = row, .p = {.nstroke = 0}};
    *l = (diag__linear){.row = row, .gain = gain, .own = row->h.n};
    int all = q->n + q->nsetting;
    l->unseen = calloc((size_t)all + 1, sizeof *l->unseen);
    w.column = malloc(sizeof *w.column * (size_t)(2 * all + DIAG_CAUSES + DIAG_SCOPED + 1));
    stein_status status =
        l->unseen != NULL && w.column != NULL ? stand(&w, gain, most, err) : lab__no_memory(err);
    w.n = status == STEIN_OK ? list_columns(&w, l, w.column) : 0;
    status = status == STEIN_OK ? make_room(&w, err) : status;
    status = status == STEIN_OK ? diag__fill_columns(&w, err) : status;
    status = status == STEIN_OK ? keep_columns(&w, l, err) : status;
    status = status == STEIN_OK && gain <= 0.0 ? keep(&w, err) : status;
    if (status != STEIN_OK) { // some of them are here
        diag__kept_free(q->kept);
        q->kept = NULL;
        l->n = l->own = 0;
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
    free(l->side);
    free(l->price);
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
        gain -= l->price != NULL ? l->price[set[i]] : 0.0;
    }
    return gain;
}

double diag__likeness(const diag__linear *l, int a, int b)
{
    size_t n = (size_t)l->n, i = (size_t)a, k = (size_t)b;
    double size = sqrt(l->I[i * n + i] * l->I[k * n + k]);
    return size > 0.0 ? fabs(l->I[i * n + k]) / size : 0.0;
}

double diag__excess(const diag__row *row)
{
    double samples = row->p.samples;
    return row->scale > 1.0 ? samples / row->memory * log(fmax(1.0, row->chi2_dof))
                            : fmax(0.0, fit__chi2(&row->p, row->r) - samples);
}

/* what of r'Pr columns explain with these amounts */
static double explained_by(const diag__linear *l, const int *set, int n, const double *amount)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        sum += l->s[set[i]] * amount[i];
    }
    return sum;
}

/* Free: the records that were not used gain as much. Held: of what the row leaves beyond noise it
 * takes the share that it has of what is left there. Where noise is estimated, -2 ln L falls as the
 * logarithm of what is left, of `memory` samples one counted, and what the freedom of an amount
 * costs is beside that. */
double diag__expected(const diag__linear *l, const int *set, int n, const double *amount,
                      double gain)
{
    int own[DIAG_CAUSES] = {0, 1, 2}, is_held = l->gain > 0.0,
        nown = l->own < DIAG_CAUSES ? l->own : DIAG_CAUSES;
    double has_amount[SET] = {0.0}, has = diag__linear_gain(l, own, nown, has_amount);
    const diag__row *row = l->row;
    double samples = row->p.samples;
    if (row->scale > 1.0) {
        double of = explained_by(l, set, n, amount), had = explained_by(l, own, nown, has_amount),
               v = row->chi2_dof, noise = is_held ? l->samples / (row->scale * row->scale) : 0.0,
               left = fmax(l->square - had - noise, 1e-9), share = fmin(1.0, (of - had) / left),
               least = fmin(is_held ? 1.0 : 1e-6, v) / v, cost = (gain - of) - (has - had),
               fall = share > 0.0 ? -log(1.0 - share * (1.0 - least)) : share;
        return row->objective - samples / row->memory * fall - cost;
    }
    if (!is_held) {
        return row->objective - samples / fmax(1.0, l->samples) * (gain - has);
    }
    double left = fmax(l->square - has - l->samples, 1.0);
    return row->objective - diag__excess(row) * fmin(1.0, (gain - has) / left);
}
