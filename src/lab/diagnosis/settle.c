/* SPDX-License-Identifier: GPL-3.0-or-later
 * settle.c - the numbers of a cause, from what of its strokes can be predicted.
 *
 * A bounce more or less, a pawl that catches just so: behind such an event a stroke answers to its
 * numbers more finely than anything is known about them. A fit goes through there by luck, chi2
 * around its end is ragged, no step leads on, and derivatives tell of knowledge that nobody has. So
 * the search ends somewhere near, which is good enough to tell one cause from another, and too far
 * for an interval.
 *
 *   1. draws from the linear posterior, a tenth of it, are simulated:
 *
 *          x' = x + eps (dbeta, du),    dbeta ~ N(0, cov),  du | dbeta ~ N(W Z'F dbeta, W)
 *
 *      A stroke ends where all of it that went another way than its derivatives say,
 *
 *          sum (r(x') - r(x) - J (x' - x))^2,
 *
 *      reaches `unpredicted`: curvature that an interval can bear is a thousandth of that. So it
 *      does where the error of the integration alone has grown to as much.
 *   2. least squares with what is left of the strokes, to their end (fit__descend)
 *   3. again from there, until no stroke ends earlier
 *   4. Gauss-Newton steps of the mixed model: the variances of what differs from stroke to stroke
 *      are those that the strokes show and the prior together. The prior is worth four strokes
 *      (with 1/variance as chi2/4 the deviation is 0.7 to 1.9 of the prior's in four of five
 *      cases): a dozen that happen to be alike would else have numbers that are too sure.
 *
 * A cause may show only where nothing can be predicted, a felt that is met after the escapement,
 * say. What comes before knows nothing of it, and would put it at 0. Then all numbers stay those of
 * the search, which describe the strokes, and it is told that their intervals may be too narrow.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { DRAWS = 8, ROUNDS = 6, RENEWALS = 3, STEPS = 4, HALVINGS = 3, SCATTER_ROUNDS = 40 };
static const double eps = 0.1;         /* of the posterior's width */
static const double unpredicted = 0.1; /* of a stroke's chi2 */
static const double coarser = 10.0;    /* tolerance of the steps, to see what they do */
static const double settled = 0.05;    /* of the sum of squares */
static const double worth = 4.0;       /* of the prior of the scatter, in strokes */
static const double unknown = 0.5; /* sd of an amount, in its prior's, of which nothing is known */
static const double known = 0.2;   /* and of one that was known before */

typedef struct settling {
    fit__problem *p;
    double *x, *to;  /* [nu] */
    double *r, *end; /* residuals at x and at `to` */
    double *J, *sd;  /* at x */
    double *weight;  /* of all samples, stroke behind stroke */
    int *until;      /* [nstroke] samples that can be predicted */
    diag__local l;
    gsl_rng *rng;
} settling;

/* the mixed model at x, solved; diag__local_close in any case */
static stein_status linearise(settling *g, stein_err *err)
{
    diag__local *l = &g->l;
    // NOLINTNEXTLINE(clang-analyzer-unix.Malloc): what is g's own, end() frees
    stein_status status = diag__local_open(l, g->p, g->x, g->J, g->r, err);
    l->m.worth = worth;
    if (status == STEIN_OK) {
        lab__mixed_scatter(&l->m, l->with, l->n, SCATTER_ROUNDS, l->beta, l->cov);
    }
    return status;
}

/* ---- what cannot be predicted ---- */

/* r(x') - r(x) - J (x' - x) of a sample; `to` is x' */
static double strange(const settling *g, int stroke, size_t i)
{
    const fit__problem *p = g->p;
    const fit__stroke *t = &p->stroke[stroke];
    size_t at = fit__offset(p, stroke) + i;
    double sum = g->end[at] - g->r[at];
    for (int k = 0; k < p->np + t->own; k++) {
        int u = k < p->np ? k : t->first + k - p->np;
        sum -= g->J[fit__column(p, stroke, k) + i] * (g->to[u] - g->x[u]);
    }
    return sum;
}

/* The stroke ends where too much of it went another way.
 * @param share  of the way that counts  @return does it end earlier than before? */
static int cut(settling *g, int stroke, double share)
{
    const fit__stroke *t = &g->p->stroke[stroke];
    double *weight = g->weight + fit__offset(g->p, stroke), sum = 0.0;
    int n = 0, before = g->until[stroke];
    for (; n < before && sum < unpredicted; n++) {
        for (int c = 0; c < t->nch; c++) {
            double e = share * strange(g, stroke, (size_t)c * (size_t)t->n + (size_t)n);
            sum += e * e;
        }
    }
    g->until[stroke] = n;
    for (int i = n; i < before; i++) {
        for (int c = 0; c < t->nch; c++) {
            weight[c * t->n + i] = 0.0;
        }
    }
    return n < before;
}

/* the strokes at `to`. @return how many end earlier than before */
static int compare(settling *g, double share, stein_status *status, stein_err *err)
{
    int failed = 0, earlier = 0;
    *status = fit__residuals(g->p, g->to, g->end, &failed, err);
    for (int s = 0; *status == STEIN_OK && failed == 0 && s < g->p->nstroke; s++) {
        earlier += cut(g, s, share);
    }
    return earlier;
}

/* @return how many strokes end earlier than before */
static int foresee(settling *g, stein_status *status, stein_err *err)
{
    fit__problem *p = g->p;
    double tolerance = p->tolerance;
    memcpy(g->to, g->x, sizeof *g->to * (size_t)p->nu);
    p->tolerance = coarser * tolerance;
    int earlier = compare(g, 1.0 / (coarser - 1.0), status, err);
    p->tolerance = tolerance;
    if (*status != STEIN_OK) {
        return 0;
    }
    *status = linearise(g, err);
    for (int n = 0; *status == STEIN_OK && n < DRAWS; n++) {
        *status = diag__draw(&g->l, p, eps, g->rng, g->x, g->to, err);
        earlier += *status == STEIN_OK ? compare(g, 1.0, status, err) : 0;
    }
    diag__local_close(&g->l);
    return earlier;
}

/* ---- least squares ---- */

/* r and J without what cannot be predicted */
static void blank(settling *g)
{
    const fit__problem *p = g->p;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        size_t left = sizeof *g->r * (size_t)(t->n - g->until[s]);
        for (int c = 0; c < t->nch; c++) {
            size_t from = (size_t)c * (size_t)t->n + (size_t)g->until[s];
            memset(g->r + fit__offset(p, s) + from, 0, left);
            for (int k = 0; k < p->np + t->own; k++) {
                memset(g->J + fit__column(p, s, k) + from, 0, left);
            }
        }
    }
}

/* to the least squares of what is left of the strokes, and central derivatives there */
static stein_status descend(settling *g, stein_err *err)
{
    fit__problem *p = g->p;
    fit__end e = {.x = g->x, .J = g->J, .r = g->r};
    p->central = 0;
    stein_status status = fit__descend(p, &e, 1, settled, RENEWALS, err);
    p->central = 1;
    return status == STEIN_OK ? fit__sensitivities(p, g->x, g->r, g->J, err) : status;
}

/* ---- with the scatter that the strokes show ---- */

static int is_thinkable(const fit__problem *p, const double *x)
{
    return p->effect == NULL || p->effect->effect->both_signs || x[p->amount] > 0.0;
}

/* a step from x to where l has its minimum, or part of it. @return 1: it was one */
static int step(settling *g, stein_status *status, stein_err *err)
{
    fit__problem *p = g->p;
    const diag__local *l = &g->l;
    double here = diag__squares(l, p, g->x, g->r);
    memcpy(g->to, g->x, sizeof *g->to * (size_t)p->nu);
    diag__linear_end(p, &l->m, l->with, l->n, l->beta, g->to);
    for (int k = 0; k < HALVINGS; k++) {
        int failed = !is_thinkable(p, g->to);
        *status = failed ? STEIN_OK : fit__residuals(p, g->to, g->end, &failed, err);
        if (*status != STEIN_OK) {
            return 0;
        }
        if (!failed && diag__squares(l, p, g->to, g->end) < here - settled) {
            memcpy(g->x, g->to, sizeof *g->x * (size_t)p->nu);
            memcpy(g->r, g->end, sizeof *g->r * fit__offset(p, p->nstroke));
            return 1;
        }
        for (int i = 0; i < p->nu; i++) {
            g->to[i] = 0.5 * (g->to[i] + g->x[i]);
        }
    }
    return 0;
}

static stein_status balance(settling *g, double *D, stein_err *err)
{
    stein_status status = STEIN_OK;
    int moved = 1;
    for (int n = 0; moved && status == STEIN_OK && n < STEPS; n++) {
        status = linearise(g, err);
        moved = 0;
        if (status == STEIN_OK) {
            memcpy(D, g->l.m.D, sizeof g->l.m.D);
            diag__deviations(&g->l, g->p, g->sd);
            moved = step(g, &status, err);
        }
        diag__local_close(&g->l);
    }
    return status;
}

/* ---- the whole ---- */

/* residuals and derivatives with the steps of reported numbers, where the search had coarser ones
 */
static stein_status look_closely(settling *g, stein_err *err)
{
    fit__problem *p = g->p;
    int failed = 0;
    if (!(p->tolerance > diag__tolerance)) {
        return STEIN_OK;
    }
    p->tolerance = diag__tolerance;
    stein_status status = fit__residuals(p, g->x, g->r, &failed, err);
    if (status == STEIN_OK && failed > 0) {
        return lab__fail(err, STEIN_ENONFINITE, "%d strokes cannot be simulated", failed);
    }
    return status == STEIN_OK ? fit__sensitivities(p, g->x, g->r, g->J, err) : status;
}

static stein_status settle(settling *g, double *D, stein_err *err)
{
    stein_status status = look_closely(g, err);
    int earlier = 1;
    for (int n = 0; earlier > 0 && status == STEIN_OK && n < ROUNDS; n++) {
        earlier = foresee(g, &status, err);
        if (status == STEIN_OK && earlier > 0) {
            blank(g);
            status = descend(g, err);
        }
    }
    return status == STEIN_OK ? balance(g, D, err) : status;
}

/* the weights of the strokes, those of the settling for theirs */
static void swap_weights(settling *g, double **other)
{
    for (int s = 0; s < g->p->nstroke; s++) {
        double *mine = g->p->stroke[s].weight;
        g->p->stroke[s].weight = other[s];
        other[s] = mine;
    }
}

static void end(settling *g, double **weight, double *steps)
{
    free(weight);
    free(steps);
    free(g->until);
    free(g->x);
    free(g->J);
    if (g->rng != NULL) {
        gsl_rng_free(g->rng);
    }
}

static int make(settling *g, fit__problem *p, const diag__suspect *s, double **weight)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    g->p = p;
    g->x = calloc(2 * nu + 3 * rows + (size_t)p->np + 1, sizeof *g->x);
    g->J = malloc(sizeof *g->J * (fit__columns(p) + 1));
    g->until = calloc((size_t)p->nstroke + 1, sizeof *g->until);
    g->rng = gsl_rng_alloc(gsl_rng_mt19937);
    if (g->x == NULL || g->J == NULL || g->until == NULL || g->rng == NULL) {
        return 0;
    }
    g->to = g->x + nu;
    g->r = g->to + nu;
    g->end = g->r + rows;
    g->weight = g->end + rows;
    g->sd = g->weight + rows;
    memcpy(g->x, s->x, sizeof *g->x * nu);
    memcpy(g->r, s->r, sizeof *g->r * rows);
    memcpy(g->J, s->J, sizeof *g->J * fit__columns(p));
    gsl_rng_set(g->rng, 1788);
    for (int a = 0; a < p->nstroke; a++) {
        const fit__stroke *t = &p->stroke[a];
        weight[a] = g->weight + fit__offset(p, a);
        g->until[a] = t->n;
        for (int i = 0; i < t->nch * t->n; i++) {
            weight[a][i] = t->weight != NULL ? t->weight[i] : 1.0;
        }
    }
    return 1;
}

/* the cause that shows only where strokes cannot be predicted, NULL: there is none */
static const lab_candidate *lost(const settling *g, const diag__suspect *s)
{
    const fit__problem *p = g->p;
    for (int i = 0; i <= p->naccepted; i++) {
        int k = i < p->naccepted ? p->first_accepted + FIT__NUMBERS * i : p->amount;
        if (g->sd[k] > unknown && s->sd[k] < known) {
            return i < p->naccepted ? p->accepted[i] : &s->s.candidate;
        }
    }
    return NULL;
}

/* how many strokes end earlier than they were filmed, and which is the first
 * @param only  the cause that shows only behind that; NULL: all were settled */
static stein_status tell(diag *d, const settling *g, const lab_candidate *only, stein_err *err)
{
    const fit__problem *p = g->p;
    double earliest = INFINITY;
    int n = 0, which = 0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        double last = g->until[s] < t->n ? t->data->time[g->until[s]] : (double)INFINITY;
        n += isfinite(last);
        which = last < earliest ? s : which;
        earliest = fmin(earliest, last);
    }
    if (n == 0) {
        return STEIN_OK;
    }
    const char *file = p->stroke[which].data->file;
    char *line =
        only == NULL
            ? lab__text("%d of %d strokes cannot be predicted to their end, %s from %.3g ms on: "
                        "what was found has its numbers from what comes before",
                        n, p->nstroke, file, 1e3 * earliest)
            : lab__text(
                  "%d of %d strokes cannot be predicted to their end, %s from %.3g ms on, and "
                  "%s at %s shows only behind that: intervals may be too narrow",
                  n, p->nstroke, file, 1e3 * earliest, only->effect->kind, only->place);
    return diag__tell(d, line, err);
}

/* x, sd and J where it has settled become those of the suspect */
static stein_status keep(const settling *g, diag__suspect *s, const double *D, stein_err *err)
{
    size_t nu = (size_t)g->p->nu, np = (size_t)g->p->np, nJ = fit__columns(g->p);
    s->settled = malloc(sizeof *s->settled * (nu + np + nJ));
    if (s->settled == NULL) {
        return lab__no_memory(err);
    }
    memcpy(s->settled, g->x, sizeof *g->x * nu);
    memcpy(s->settled + nu, g->sd, sizeof *g->sd * np);
    memcpy(s->settled + nu + np, g->J, sizeof *g->J * nJ);
    memcpy(s->settled_D, D, sizeof s->settled_D);
    return STEIN_OK;
}

stein_status diag__settle(diag *d, diag__suspect *s, stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    settling g = {.x = NULL};
    double D[LAB_SCATTERS] = {0};
    stein_err why = {STEIN_OK, ""};
    double tolerance = p->tolerance;
    double **weight = calloc((size_t)p->nstroke + 1, sizeof *weight);
    double *steps = malloc(sizeof *steps * (size_t)(p->nu + 1));
    if (weight == NULL || steps == NULL || !make(&g, p, s, weight)) {
        end(&g, weight, steps);
        return lab__no_memory(err);
    }
    memcpy(steps, p->step, sizeof *steps * (size_t)p->nu);
    p->central = 1;
    fit__problem_try(p, &s->s.candidate);
    fit__choose_steps(p, s->J);
    swap_weights(&g, weight);
    stein_status status = settle(&g, D, &why);
    swap_weights(&g, weight);
    fit__problem_try(p, NULL);
    p->central = 0;
    p->tolerance = tolerance;
    memcpy(p->step, steps, sizeof *steps * (size_t)p->nu);
    if (status != STEIN_OK) {
        end(&g, weight, steps);
        return fit__forgive(status, err);
    }
    const lab_candidate *only = lost(&g, s);
    status = only == NULL ? keep(&g, s, D, err) : STEIN_OK;
    status = status == STEIN_OK ? tell(d, &g, only, err) : status;
    end(&g, weight, steps);
    return status;
}

diag__numbers diag__numbers_of(const diag *d, const diag__suspect *s)
{
    const fit__problem *p = s->fit != NULL ? s->fit : &d->p;
    const double *x = s->settled;
    if (x == NULL) {
        return (diag__numbers){s->x, s->sd, s->J, s->D};
    }
    return (diag__numbers){x, x + p->nu, x + p->nu + p->np, s->settled_D};
}
