/* SPDX-License-Identifier: GPL-3.0-or-later
 * evaluate.c - one hypothesis, fitted from one start; the only writer of rows.
 *
 *      start     the parent row's end, new causes at the proposed amounts
 *      fit       ways down from there, and records that a fit has lost (descend.c)
 *      evidence  -2 ln p(records | hypothesis) by Laplace, scatter estimated (likelihood.c)
 *
 * Noise. Where it is not stated, or the best hypothesis leaves more or less than was stated, it is
 * an unknown of every fit: with v = chi2/dof in the noise of file or audit and residuals that are
 * alike over m samples
 *
 *      L = ((N - k)/m + k) ln v + rest,     data weigh 1/(v m) of what they did, priors what they
 * always do
 *
 * so what is left counts as noise of a model that is never exactly right, and hypotheses compare by
 * the ratio of what they leave.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "search.h"

enum { RENEWALS = 5, REFINEMENTS = 8, NOISES = 6 };
static const double refined = 0.1;    /* fall of the objective below which a reported fit ends */
static const double same_noise = 0.1; /* relative change of noise that is none */
static const double finer = 0.1;      /* steps where numbers are reported, in those of a search */
static const double least_scatter = 0.01; /* sd of a refined fit [of the prior] */

static stein_status open_row(diag__problem *q, diag__row *row, stein_err *err)
{
    for (int i = 0; i < row->h.n; i++) {
        row->cause[i] = diag__bound(q, row->in, row->h.cause[i]);
        row->price += diag__price(q, row->h.cause[i]);
    }
    stein_status status =
        fit__problem_make_with(&row->p, row->in->model, row->in->fitted,
                               row->rough ? &q->rough_def : &q->fit_def, row->cause, row->h.n, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__problem *p = &row->p;
    p->tolerance = q->null.tolerance;
    p->stride = q->null.stride;
    p->simulated = &q->strokes;
    if (isfinite(q->null.horizon)) {
        fit__limit(p, q->null.horizon);
    }
    row->x = calloc((size_t)p->nu + (size_t)p->np + fit__offset(p, p->nstroke) + 1, sizeof *row->x);
    row->J = malloc(sizeof *row->J * (fit__columns(p) + 1));
    if (row->x == NULL || row->J == NULL) {
        return lab__no_memory(err);
    }
    row->sd = row->x + p->nu;
    row->r = row->sd + p->np;
    return STEIN_OK;
}

void diag__scale_noise(fit__problem *p, double factor)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            p->stroke[s].noise[c] *= factor;
        }
    }
}

/* Samples that the residual is alike over. However smooth it is, a record counts as several
 * samples: one law may take all of a misfit away, and that is more than one coincidence. */
static double memory_of(const fit__problem *p, const double *r)
{
    double most = p->samples / (DIAG_COUNTED * fmax(1.0, p->nstroke));
    return fmax(1.0, fmin(fit__memory(p, r), most));
}

/* the noise becomes what the fit leaves. @return the factor that it has changed by */
static double take_noise(const diag__problem *q, diag__row *row, const double *r)
{
    fit__problem *p = &row->p;
    double v = fit__chi2_dof(p, r) * row->scale * row->scale,
           to = sqrt(fmax(q->least_noise, v) * memory_of(p, r)), factor = to / row->scale;
    row->scale = to;
    diag__scale_noise(p, factor);
    return factor;
}

/* residuals and derivatives where noise has changed by a factor */
static void reweigh(diag__row *row, double factor)
{
    const fit__problem *p = &row->p;
    size_t rows = fit__offset(p, p->nstroke), columns = fit__columns(p);
    for (size_t i = 0; i < rows; i++) {
        row->r[i] /= factor;
    }
    for (size_t i = 0; i < columns; i++) {
        row->J[i] /= factor;
    }
}

/* The fit once more with what it leaves as its noise, until that stays. Where it leaves far more
 * than another hypothesis, it only gets that noise. */
static stein_status settle_noise(const diag__problem *q, diag__row *row, int loses, fit__end *e,
                                 stein_err *err)
{
    for (int k = 0; k < NOISES; k++) {
        double factor = take_noise(q, row, e->r);
        if (loses || fabs(factor - 1.0) < same_noise) {
            reweigh(row, factor);
            return STEIN_OK;
        }
        stein_status status = fit__descend(&row->p, e, 0, diag__fit_ends, RENEWALS, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    return STEIN_OK;
}

/* does another hypothesis leave noise, and a fit so far much more than that? */
static int is_beaten(const diag__problem *q, const diag__table *t, const diag__row *row)
{
    const diag__row *best = diag__incumbent(q, t);
    double left = fit__chi2_dof(&row->p, row->r) * row->scale * row->scale;
    return best != NULL && diag__leaves_noise(q, best) && left > diag__guessed * best->chi2_dof;
}

/* The parent's causes but some: to first order, what the others have to become when those end.
 *
 *      r' = r - sum J_a x_a,    dx = -(J'J + 1)^-1 (J'r' + x)       without the columns J_a
 *
 * An amount of one standard deviation costs 1 in chi2 with this step. Without it the fit begins
 * where the records may have another order of events, and does not come back.
 * @param x  out: x + dx, as it is where there is no such step  @return OK, ENOMEM */
static stein_status without_causes(const diag__row *row, const diag__row *parent, double *x,
                                   stein_err *err)
{
    const fit__problem *p = &row->p, *of = &parent->p;
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    fit__normal normal;
    double *r = malloc(sizeof *r * (rows + nu + 1)), *dx = r + (r != NULL ? rows : 0);
    stein_status status = fit__normal_make(&normal, p, err);
    status = status == STEIN_OK && r == NULL ? lab__no_memory(err) : status;
    memcpy(x, row->x, sizeof *x * nu);
    for (int s = 0; s < p->nstroke && status == STEIN_OK; s++) {
        size_t size = (size_t)p->stroke[s].nch * (size_t)p->stroke[s].n;
        double *at = r + fit__offset(p, s);
        memcpy(at, parent->r + fit__offset(of, s), sizeof *at * size);
        for (int i = 0; i < parent->h.n; i++) {
            int a = diag__unknown_at(parent, i);
            const double *J = parent->J + fit__column(of, s, a);
            for (size_t k = 0; !diag__has(&row->h, parent->h.cause[i]) && k < size; k++) {
                at[k] -= J[k] * parent->x[a];
            }
        }
    }
    if (status == STEIN_OK) {
        fit__normal_fill(&normal, p, row->x, r, row->J, 1);
        if (fit__normal_factor(&normal, p, 0.0, NULL) == 0) {
            fit__normal_step(&normal, p, dx);
            for (size_t k = 0; k < nu; k++) {
                x[k] += dx[k];
            }
        }
    }
    fit__normal_free(&normal);
    free(r);
    return status;
}

/* begins without some of the parent's causes where that is nearer. @param r  residuals at row->x */
static stein_status begin_without(diag__row *row, const diag__row *parent, double *r,
                                  stein_err *err)
{
    fit__problem *p = &row->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *x = malloc(sizeof *x * (nu + rows + 1));
    int failed = 0;
    if (x == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = without_causes(row, parent, x, err);
    status = status == STEIN_OK ? fit__residuals(p, x, x + nu, &failed, err) : status;
    if (status == STEIN_OK && failed == 0 &&
        fit__chi2(p, x + nu) + fit__priors(p, x) < fit__chi2(p, r) + fit__priors(p, row->x)) {
        memcpy(row->x, x, sizeof *x * nu);
        memcpy(r, x + nu, sizeof *x * rows);
    }
    free(x);
    return fit__forgive(status, err);
}

/* derivatives to begin with, those of the parent and those of new causes. @return are they there?
 */
static int begin_known(diag__row *row, const diag__row *parent, stein_status *status,
                       stein_err *err)
{
    fit__problem *p = &row->p;
    unsigned char *known = calloc((size_t)p->nu + 1, 1);
    int failed = 0, fewer = row->h.n < parent->h.n && diag__contains(&parent->h, &row->h);
    if (known == NULL) {
        *status = lab__no_memory(err);
        return 0;
    }
    diag__inherit(row, parent, known);
    *status = fit__residuals(p, row->x, row->r, &failed, err);
    if (*status == STEIN_OK && failed == 0 && fewer) {
        *status = begin_without(row, parent, row->r, err);
    }
    if (*status == STEIN_OK && failed == 0) {
        *status = fit__more_sensitivities(p, row->x, row->r, known, row->J, err);
    }
    free(known);
    return *status == STEIN_OK && failed == 0;
}

static stein_status fit_row(const diag__problem *q, const diag__table *t, diag__row *row,
                            const diag__row *parent, diag__start from, stein_err *err)
{
    fit__problem *p = &row->p;
    fit__end e = {.x = row->x, .J = row->J, .r = row->r};
    stein_status status = STEIN_OK;
    if (from == DIAG_FREE && parent != NULL && parent->J != NULL &&
        begin_known(row, parent, &status, err)) {
        from = DIAG_KNOWN;
    }
    status = status == STEIN_ENOMEM ? status : diag__descend(p, &e, from, err);
    int loses = status == STEIN_OK && row->h.n > 0 && is_beaten(q, t, row);
    status = status == STEIN_OK && !loses ? diag__recover(p, &e, row->scale, err) : status;
    status = status == STEIN_OK && q->scale_free ? settle_noise(q, row, loses, &e, err) : status;
    row->converged = e.ended;
    return status == STEIN_OK && !e.current ? fit__sensitivities(p, row->x, row->r, row->J, err)
                                            : status;
}

/* what a row tells, from its derivatives */
static stein_status note(diag__row *row, stein_err *err)
{
    fit__problem *p = &row->p;
    double square = row->scale * row->scale;
    stein_status status =
        diag__likelihood(p, row->x, row->J, row->r, row->D, row->sd, &row->objective, err);
    row->objective += row->price;
    for (int i = 0; i < row->h.n; i++) {
        double sd;
        row->objective += diag__mistake(&row->cause[i], diag__amount(row, i, &sd));
    }
    row->rest = row->objective - fit__chi2(p, row->r);
    row->chi2_dof = fit__chi2_dof(p, row->r) * square;
    row->memory = memory_of(p, row->r);
    row->relative = diag__relative(p, row->r);
    return status;
}

/* Derivatives stay with the row that stands for the verdict and with the one that proposals come
 * from: of all rows together they would be most of the memory. */
static void forget_derivatives(const diag__problem *q, const diag__table *t, int parent)
{
    const diag__row *best = diag__incumbent(q, t);
    for (int i = 0; i < t->n; i++) {
        if (i != parent && t->row[i] != best) {
            free(t->row[i]->J);
            t->row[i]->J = NULL;
        }
    }
}

stein_status diag__evaluate(diag__problem *q, diag__table *t, const diag__proposal *from,
                            diag__row **out, stein_err *err)
{
    diag__row *row = calloc(1, sizeof *row);
    long before = q->strokes;
    double begin = diag__clock();
    *out = NULL;
    if (row == NULL) {
        return lab__no_memory(err);
    }
    row->h = from->h;
    row->by = from->by;
    row->parent = from->parent;
    row->rough = from->rough || (from->parent >= 0 && t->row[from->parent]->rough);
    row->objective = row->chi2_dof = row->relative = INFINITY;
    row->scale = row->memory = 1.0;
    row->within = INFINITY;
    row->in = diag__mechanism_of(q, &row->h, err);
    if (row->in == NULL) {
        free(row);
        return STEIN_ENOMEM;
    }
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (row->in->why == NULL) {
        status = open_row(q, row, &why);
        if (status == STEIN_OK) {
            const diag__row *parent = from->parent >= 0 ? t->row[from->parent] : NULL;
            diag__start_row(row, parent, from);
            row->scale = q->scale_free && parent != NULL ? parent->scale : 1.0;
            diag__scale_noise(&row->p, row->scale);
            diag__start how = from->parent < 0 ? DIAG_IF_FAR : from->held ? DIAG_HELD : DIAG_FREE;
            status = fit_row(q, t, row, parent, how, &why);
            status = status == STEIN_OK ? note(row, &why) : status;
            status = status == STEIN_OK ? diag__bodies_exist(row, &why) : status;
        }
    }
    if (status == STEIN_ENOMEM) {
        diag__row_free(row);
        return lab__no_memory(err);
    }
    if (row->in->why != NULL || status != STEIN_OK || !isfinite(row->objective)) {
        const char *said = row->in->why != NULL ? row->in->why : why.msg;
        row->failed = lab__text("%s", *said != '\0' ? said : "its likelihood is not finite");
        row->objective = row->chi2_dof = INFINITY;
        free(row->J);
        row->J = NULL;
    }
    row->strokes = q->strokes - before;
    row->seconds = diag__clock() - begin;
    *out = row;
    status = diag__table_add(t, row, err);
    diag__weigh(q, t);
    forget_derivatives(q, t, from->parent);
    return status;
}

/* a hypothesis at the start of its fit, in no table. @return NULL: it cannot be simulated, or there
 * is no memory (*status) */
static diag__row *at_start(diag__problem *q, const diag__proposal *from, stein_status *status)
{
    diag__row *row = calloc(1, sizeof *row);
    stein_err why = {STEIN_OK, ""};
    *status = row != NULL ? STEIN_OK : STEIN_ENOMEM;
    if (row != NULL) {
        row->h = from->h;
        row->in = diag__mechanism_of(q, &row->h, &why);
        *status = row->in == NULL ? STEIN_ENOMEM : STEIN_OK;
    }
    int can = *status == STEIN_OK && row->in->why == NULL;
    *status = can ? open_row(q, row, &why) : *status;
    if (!can || *status != STEIN_OK) {
        diag__row_free(row);
        return NULL;
    }
    diag__start_row(row, NULL, from);
    return row;
}

stein_status diag__reach(diag__problem *q, const diag__proposal *from, double *until,
                         stein_err *err)
{
    stein_status status;
    stein_err why = {STEIN_OK, ""};
    diag__row *row = at_start(q, from, &status);
    *until = 0.0;
    if (row != NULL) {
        fit__end e = {.x = row->x, .J = row->J, .r = row->r};
        status = diag__follows(&row->p, &e, until, &why);
        diag__row_free(row);
    }
    return status == STEIN_ENOMEM ? lab__no_memory(err) : STEIN_OK;
}

stein_status diag__misfit(diag__problem *q, const diag__proposal *from, double *chi2,
                          stein_err *err)
{
    stein_status status;
    stein_err why = {STEIN_OK, ""};
    diag__row *row = at_start(q, from, &status);
    int failed = 0;
    *chi2 = INFINITY;
    if (row != NULL) {
        status = fit__residuals(&row->p, row->x, row->r, &failed, &why);
        *chi2 = status == STEIN_OK && failed == 0 ? fit__chi2(&row->p, row->r) : (double)INFINITY;
        diag__row_free(row);
    }
    return status == STEIN_ENOMEM ? lab__no_memory(err) : STEIN_OK;
}

/* Scatter in units of another standard deviation, by factors f of each class. */
static void scale_scatter(diag__row *row, const double *f)
{
    fit__problem *p = &row->p;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int k = t->first; k < t->first + t->own; k++) {
            fit__unknown *u = &p->unknown[k];
            int class = diag__class_of(p, u);
            double by = class >= 0 ? f[class] : 1.0;
            double *J = row->J + fit__column(p, s, p->np + k - t->first);
            u->sd *= by;
            row->x[k] /= by;
            p->step[k] /= by;
            for (int i = 0; i < t->nch * t->n; i++) {
                J[i] *= by;
            }
        }
    }
}

/* One-sided differences and coarse steps serve a search. Two unknowns may change the records nearly
 * alike, such as friction and the speed at which it begins. Then the errors of their columns look
 * like information that separates them, and the fit ends at a wrong place. On strokes of the action
 * an amount was 1.5 % off with a standard deviation of 0.3 %. With central differences and steps
 * ten times finer it is 1.2 % off with one of 1.1 %. So what is reported is fitted to its end with
 * those. The scatter is the estimated one instead of that of the prior. Otherwise the records' own
 * friction would take part of an effect where records do not differ, and the interval would not
 * contain that. A fit that need not come nearer its minimum than by what a search takes for nothing
 * goes on as in the search. */
static stein_status refine(diag__row *row, double within, stein_err *err)
{
    fit__problem *p = &row->p;
    double coarse = p->tolerance, to[LAB_SCATTERS], back[LAB_SCATTERS];
    for (int i = 0; i < LAB_SCATTERS; i++) {
        to[i] = fmax(sqrt(row->D[i]), least_scatter);
        back[i] = 1.0 / to[i];
    }
    fit__end e = {.x = row->x, .J = row->J, .r = row->r};
    scale_scatter(row, to);
    p->central = within < diag__fit_ends;
    p->tolerance = within < diag__fit_ends ? finer * coarse : coarse;
    stein_status status = fit__descend(p, &e, 0, within, REFINEMENTS, err);
    row->converged |= e.ended;
    if (status == STEIN_OK && !e.current) {
        status = fit__sensitivities(p, row->x, row->r, row->J, err);
    }
    p->central = 0;
    p->tolerance = coarse;
    status = status == STEIN_OK ? note(row, err) : status;
    scale_scatter(row, back);
    for (int i = 0; status == STEIN_OK && i < LAB_SCATTERS; i++) {
        row->D[i] *= to[i] * to[i];
    }
    return status;
}

stein_status diag__refine_row(diag__row *row, double within, stein_err *err)
{
    const fit__problem *p = &row->p;
    size_t n = (size_t)p->nu + (size_t)p->np + fit__offset(p, p->nstroke), nJ = fit__columns(p);
    diag__row was = *row;
    stein_err why = {STEIN_OK, ""};
    if (row->within <= within && row->J != NULL) {
        return STEIN_OK;
    }
    if (row->J == NULL) {
        row->J = calloc(nJ + 1, sizeof *row->J);
    }
    double *room = malloc(sizeof *room * (n + nJ + 1));
    if (row->J == NULL || room == NULL) {
        free(room);
        return lab__no_memory(err);
    }
    memcpy(room, row->x, sizeof *room * n);
    memcpy(room + n, row->J, sizeof *room * nJ);
    stein_status status = refine(row, fmax(refined, within), &why);
    if (status != STEIN_OK || !isfinite(row->objective)) { // no finite derivatives: as it was
        memcpy(row->x, room, sizeof *room * n);
        memcpy(row->J, room + n, sizeof *room * nJ);
        was.J = row->J;
        was.p = row->p;
        *row = was;
    }
    row->within = within;
    free(room);
    return fit__forgive(status, err);
}

void diag__row_free(diag__row *row)
{
    if (row != NULL) {
        fit__problem_free(&row->p);
        free(row->x);
        free(row->J);
        free(row->failed);
        free(row);
    }
}
