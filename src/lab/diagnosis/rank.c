/* SPDX-License-Identifier: GPL-3.0-or-later
 * rank.c - which suspects the residual looks like.
 *
 * At the null fit the strokes are linear in all unknowns (mixed.h):
 *
 *      d_s = F_s beta + Z_s u_s + G_s alpha + e,     d = r - J x,  F = -dr/dp,  Z = -dr/du
 *
 * beta the parameters with their priors; u what differs from stroke to stroke: trigger and offsets
 * with theirs, friction and drive with variances D that are estimated, for every suspect anew. What
 * a suspect gains is the fall of -2 log marginal likelihood,
 *
 *      gain_k = L(null) - L(with k),    the prior of its amount: one limit
 *
 * which needs no further price for a parameter more. These gains are linear: good enough to choose
 * whom to fit in full, not to accuse.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { ROUNDS = 40 };
static const double promising = 0.05; /* share of the best score */
static const double beyond = 1.5;     /* amounts up to so many limits are thinkable */

/* ---- scores ---- */

static int by_score(const void *a, const void *b)
{
    const diag__suspect *x = a, *y = b;
    double sx = isfinite(x->s.score) ? x->s.score : -1e300;
    double sy = isfinite(y->s.score) ? y->s.score : -1e300;
    return sx > sy ? -1 : sx < sy;
}

static void note_amount(diag__suspect *s, double amount)
{
    const lab_effect *e = s->s.candidate.effect;
    s->s.amount = amount * s->s.candidate.limit;
    s->s.possible = fabs(amount) < beyond && (e->both_signs || amount > 0.0);
    if (!s->s.possible) {
        s->s.why = e->both_signs || amount > 0.0 ? "it would have to be larger than is thinkable"
                                                 : "it would have to be negative";
    }
}

/* column k of the mixed model is one of suspect s; of two the better one stays its G
 * @param null  objective without it */
static void score_one(diag *d, lab__mixed *m, diag__suspect *s, int k, const double *column,
                      double null, double *beta)
{
    memcpy(m->D, d->null_D, sizeof m->D);
    double score = null - lab__mixed_scatter(m, &k, 1, 12, beta, NULL);
    if (column == s->small && !(score > s->s.score)) {
        return;
    }
    if (column == s->small) {
        diag__swap_secants(s);
    }
    s->s.score = score;
    note_amount(s, beta[m->nf]);
}

/* the score that the best of all would reach by chance in one clean set of a hundred */
static double by_chance(const double *draws)
{
    double lo = 2.0, hi = 64.0;
    while (hi / lo > 1.03) {
        double middle = sqrt(lo * hi);
        double *end = lab__family_p(draws, middle) < 0.01 ? &hi : &lo;
        *end = middle;
    }
    return hi;
}

static stein_status scores(diag *d, lab__mixed *m, const int *index, const double *const *column,
                           int n, stein_err *err)
{
    size_t nc = (size_t)n;
    double *room = calloc((size_t)m->nf + 2 + 3 * nc + nc * nc, sizeof *room);
    unsigned char *use = calloc(nc + 1, 1);
    if (room == NULL || use == NULL) {
        free(room);
        free(use);
        return lab__no_memory(err);
    }
    double *beta = room, *score = beta + m->nf + 2, *epc = score + nc, *info = epc + nc,
           *corr = info + nc, best = 0.0;
    double null = lab__mixed_scatter(m, NULL, 0, ROUNDS, beta, NULL);
    memcpy(d->null_D, m->D, sizeof m->D);
    lab__mixed_weigh(m);
    lab__mixed_score(m, score, epc, info, corr);
    for (int i = 0; i < n; i++) {
        note_amount(&d->suspect[index[i]], epc[i]);
        use[i] = info[i] > 0.0;
        best = d->suspect[index[i]].s.possible ? fmax(best, fabs(score[i])) : best;
    }
    int nu = d->p.nstroke > 2 ? d->p.nstroke - 1 : 1;
    double *draws = lab__family_draws(corr, use, n, nu);
    d->p_value = lab__family_p(draws, best);
    d->z_by_chance = by_chance(draws);
    free(draws);
    for (int i = 0; i < n; i++) {
        d->suspect[index[i]].s.why = NULL;
        score_one(d, m, &d->suspect[index[i]], i, column[i], null, beta);
    }
    free(room);
    free(use);
    return STEIN_OK;
}

/* G of all that have one, and the small ones of parts behind their own */
static int columns_of(const diag *d, const double **column, int *index)
{
    int n = 0;
    for (int i = 0; i < d->n; i++) {
        const diag__suspect *s = &d->suspect[i];
        if (s->s.why == NULL && s->G != NULL &&
            (d->p.given == NULL || (s->promising && s->model == NULL))) {
            column[n] = s->G;
            index[n++] = i;
            if (s->small != NULL) {
                column[n] = s->small;
                index[n++] = i;
            }
        }
    }
    return n;
}

stein_status diag__rank(diag *d, stein_err *err)
{
    const double **column = malloc(sizeof *column * (size_t)(2 * d->n + 1));
    int *index = malloc(sizeof *index * (size_t)(2 * d->n + 1));
    int n = column != NULL && index != NULL ? columns_of(d, column, index) : 0;
    lab__mixed m = {.nf = 0};
    stein_status status = column != NULL && index != NULL
                              ? diag__mixed_at(&m, &d->p, d->x, d->J, d->r, column, n, err)
                              : lab__no_memory(err);
    status = status == STEIN_OK ? scores(d, &m, index, column, n, err) : status;
    lab__mixed_free(&m);
    free(column);
    free(index);
    if (status == STEIN_OK) {
        status = diag__likelihood(&d->p, d->x, d->J, d->r, d->null_D, d->sd, &d->null_objective,
                                  NULL, err);
    }
    qsort(d->suspect, (size_t)d->n, sizeof *d->suspect, by_score);
    for (int i = 0; i < d->n; i++) {
        d->suspect[i].promising = d->suspect[i].s.score > promising * d->suspect[0].s.score;
    }
    return status;
}

/* ---- in the leader's place ---- */

/* unknowns where candidate k stands in the leader's place */
static stein_status start_of(diag *d, diag__suspect *s, lab__mixed *m, int k, const double *beta,
                             stein_err *err)
{
    if (s->start == NULL) {
        s->start = malloc(sizeof *s->start * (size_t)d->p.nu);
    }
    if (s->start == NULL) {
        return lab__no_memory(err);
    }
    memset(s->start, 0, sizeof *s->start * (size_t)d->p.nu);
    diag__linear_end(&d->p, m, &k, 1, beta, s->start);
    return STEIN_OK;
}

stein_status diag__in_place(diag *d, diag__suspect *leader, stein_err *err)
{
    const fit__problem *p = diag__problem(d, leader);
    const double **column = malloc(sizeof *column * (size_t)(2 * d->n + 2));
    int *index = malloc(sizeof *index * (size_t)(2 * d->n + 2));
    double *own = diag__column(p, leader->J, p->amount), *beta = NULL;
    int memory = column != NULL && index != NULL && own != NULL;
    int n = memory ? columns_of(d, column, index) : 0, at = (int)(leader - d->suspect);
    lab__mixed m = {.nf = 0};
    if (memory) {
        column[n] = own; // d is free of the leader's effect only when its column is among these
    }
    stein_status status =
        memory ? diag__mixed_at(&m, p, leader->x, leader->J, leader->r, column, n + 1, err)
               : lab__no_memory(err);
    beta = malloc(sizeof *beta * (size_t)(m.nf + 2));
    if (status == STEIN_OK && beta == NULL) {
        status = lab__no_memory(err);
    }
    for (int k = 0; status == STEIN_OK && k < n; k++) {
        diag__suspect *s = &d->suspect[index[k]];
        if (index[k] == at) {
            s->swap = INFINITY;
            continue;
        }
        memcpy(m.D, leader->D, sizeof m.D);
        double swap = lab__mixed_scatter(&m, &k, 1, 12, beta, NULL);
        int small = column[k] == s->small;
        if (small && !(swap < s->swap)) {
            continue;
        }
        if (small) {
            diag__swap_secants(s);
        }
        note_amount(s, beta[m.nf]);
        s->swap = s->near = s->s.possible ? swap : (double)INFINITY;
        status = isfinite(s->swap) ? start_of(d, s, &m, k, beta, err) : status;
    }
    lab__mixed_free(&m);
    free(column);
    free(index);
    free(own);
    free(beta);
    return status;
}
