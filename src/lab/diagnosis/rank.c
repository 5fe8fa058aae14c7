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

enum { ROUNDS = 40, SLOTS = 64 };
static const double most_scatter = 6.25; /* variance, in those of the prior */
static const double promising = 0.05;    /* share of the best score */
static const double beyond = 1.5;        /* amounts up to so many limits are thinkable */

/* ---- the mixed model of a problem ---- */

/* what differs from stroke to stroke: kind and index of each column of Z */
typedef struct slots {
    int n;
    fit__kind kind[SLOTS];
    int index[SLOTS], class[SLOTS];
} slots;

static int index_of(const fit__stroke *t, const fit__unknown *u)
{
    return u->kind == FIT__OFFSET ? t->channel[u->index] : u->index;
}

static int slot_of(const slots *l, const fit__stroke *t, const fit__unknown *u)
{
    for (int i = 0; i < l->n; i++) {
        if (l->kind[i] == u->kind && l->index[i] == index_of(t, u)) {
            return i;
        }
    }
    return -1;
}

static void find_slots(slots *l, const fit__problem *p)
{
    l->n = 0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int k = 0; k < t->own; k++) {
            const fit__unknown *u = &p->unknown[t->first + k];
            if (slot_of(l, t, u) < 0 && l->n < SLOTS) {
                l->kind[l->n] = u->kind;
                l->index[l->n] = index_of(t, u);
                l->class[l->n++] = u->kind == FIT__SCATTER ? u->index - FIT__JOINTS : -1;
            }
        }
    }
}

/* what is fitted, the effect on trial excepted */
static int free_ones(const fit__problem *p, int *list)
{
    int n = 0;
    for (int k = 0; k < p->np; k++) {
        if (!p->unknown[k].idle && (k < p->amount || k >= p->amount + FIT__NUMBERS)) {
            list[n++] = k;
        }
    }
    return n;
}

static void negative(double *to, const double *from, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = -from[i];
    }
}

/* columns of a stroke: F, the suspects, d, Z */
static void fill(lab__mixed *m, const fit__problem *p, const slots *l, int s, const double *x,
                 const double *J, const double *r, const int *beta, const double *const *column,
                 double *C)
{
    const fit__stroke *t = &p->stroke[s];
    size_t n = (size_t)(t->nch * t->n), at = fit__offset(p, s);
    double *d = C + (size_t)(m->nf + m->nc) * n, *Z = d + n;
    memset(C, 0, sizeof *C * n * (size_t)(m->ncol + m->nz));
    memcpy(d, r + at, sizeof *d * n);
    for (int k = 0; k < p->np + t->own; k++) {
        int u = k < p->np ? k : t->first + k - p->np;
        const double *j = J + fit__column(p, s, k);
        for (size_t i = 0; x[u] != 0.0 && i < n; i++) {
            d[i] -= j[i] * x[u];
        }
        int slot = k < p->np ? -1 : slot_of(l, t, &p->unknown[u]);
        if (slot >= 0) {
            negative(Z + (size_t)slot * n, j, n);
        }
    }
    for (int k = 0; k < m->nf; k++) {
        negative(C + (size_t)k * n, J + fit__column(p, s, beta[k]), n);
    }
    for (int k = 0; k < m->nc; k++) {
        negative(C + (size_t)(m->nf + k) * n, column[k] + at, n);
    }
    lab__mixed_stroke(m, s, (int)n, C);
}

stein_status diag__mixed_at(lab__mixed *m, const fit__problem *p, const double *x, const double *J,
                            const double *r, const double *const *column, int nc, stein_err *err)
{
    slots l;
    int *beta = malloc(sizeof *beta * (size_t)(p->np + 1));
    lab__scatter scatter[DIAG_CLASSES];
    find_slots(&l, p);
    for (int i = 0; i < DIAG_CLASSES; i++) {
        scatter[i] = (lab__scatter){1.0, most_scatter};
    }
    int nf = beta != NULL ? free_ones(p, beta) : 0;
    *m = (lab__mixed){.nf = 0};
    stein_status status = beta != NULL ? lab__mixed_make(m, p->nstroke, nf, nc, l.n, l.class, NULL,
                                                         scatter, DIAG_CLASSES, err)
                                       : lab__no_memory(err);
    double *C = malloc(sizeof *C * ((size_t)p->rows * (size_t)(nf + nc + 1 + l.n) + 1));
    if (status == STEIN_OK && C == NULL) {
        status = lab__no_memory(err);
    }
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        fill(m, p, &l, s, x, J, r, beta, column, C);
    }
    free(C);
    free(beta);
    if (status != STEIN_OK) {
        lab__mixed_free(m);
        *m = (lab__mixed){.nf = 0};
    }
    return status;
}

double *diag__column(const fit__problem *p, const double *J, int k)
{
    double *to = malloc(sizeof *to * (fit__offset(p, p->nstroke) + 1));
    for (int s = 0; to != NULL && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        memcpy(to + fit__offset(p, s), J + fit__column(p, s, k),
               sizeof *to * (size_t)(t->nch * t->n));
    }
    return to;
}

/* What the linear model promises and the strokes do not keep: sum of squares at x less its minimum,
 * at the variances of the priors. Nothing where a fit has ended; much where an event of a stroke
 * turns its derivative within a step, and no step leads where the derivatives point. (Unknowns
 * without a prior have one in the linear model only: that can but hide some of it.) */
static double unkept(lab__mixed *m, const fit__problem *p, const double *x, const double *r,
                     const int *with, int nwith, double *beta)
{
    double here = fit__chi2(p, r);
    for (int k = 0; k < p->nu; k++) {
        here += p->unknown[k].prior && !p->unknown[k].idle ? x[k] * x[k] : 0.0;
    }
    return fmax(0.0, here - lab__mixed_least(m, with, nwith, beta));
}

stein_status diag__likelihood(const fit__problem *p, const double *x, const double *J,
                              const double *r, double *D, double *sd, double *objective,
                              double *promised, stein_err *err)
{
    lab__mixed m = {.nf = 0};
    int nwith = 0, with[FIT__NUMBERS], k[FIT__NUMBERS], memory = 1;
    double *column[FIT__NUMBERS] = {NULL};
    for (int i = 0; p->amount >= 0 && i < FIT__NUMBERS; i++) {
        if (!p->unknown[p->amount + i].idle) {
            with[nwith] = nwith;
            k[nwith] = p->amount + i;
            memory &= (column[nwith++] = diag__column(p, J, p->amount + i)) != NULL;
        }
    }
    memory = memory &&
             diag__mixed_at(&m, p, x, J, r, (const double *const *)column, nwith, NULL) == STEIN_OK;
    int n = m.nf + nwith;
    double *beta = memory ? malloc(sizeof *beta * (size_t)(n + n * n + 1)) : NULL;
    int *list = memory ? malloc(sizeof *list * (size_t)(p->np + 1)) : NULL;
    memory = beta != NULL && list != NULL;
    if (memory) {
        const double *all = beta + n;
        double more = unkept(&m, p, x, r, with, nwith, beta);
        double found = more + lab__mixed_scatter(&m, with, nwith, ROUNDS, beta, beta + n);
        memcpy(D, m.D, sizeof m.D);
        if (objective != NULL) {
            *objective = found;
        }
        if (promised != NULL) {
            *promised = found - more;
        }
        int nf = free_ones(p, list);
        memset(sd, 0, sizeof *sd * (size_t)p->np);
        for (int i = 0; i < nf + nwith; i++) {
            sd[i < nf ? list[i] : k[i - nf]] = sqrt(fmax(0.0, all[i * n + i]));
        }
    }
    free(list);
    free(beta);
    lab__mixed_free(&m);
    for (int i = 0; i < nwith; i++) {
        free(column[i]);
    }
    return memory ? STEIN_OK : lab__no_memory(err);
}

/* unknowns x [nu] at the linear minimum beta, with a candidate whose amount is the last of it or
 * without. @return 0: out of memory */
static int linear_end(const fit__problem *p, lab__mixed *m, const int *with, int nwith,
                      const double *beta, double *x)
{
    slots l;
    double u[SLOTS];
    int *list = malloc(sizeof *list * (size_t)(p->np + 1));
    if (list == NULL) {
        return 0;
    }
    memset(x, 0, sizeof *x * (size_t)p->nu);
    int nf = free_ones(p, list);
    for (int i = 0; i < nf; i++) {
        x[list[i]] = beta[i];
    }
    if (nwith > 0) {
        x[p->amount] = beta[nf];
    }
    find_slots(&l, p);
    for (int a = 0; a < p->nstroke; a++) {
        const fit__stroke *t = &p->stroke[a];
        lab__mixed_effects(m, a, with, nwith, beta, u);
        for (int i = 0; i < t->own; i++) {
            int slot = slot_of(&l, t, &p->unknown[t->first + i]);
            x[t->first + i] = slot >= 0 ? u[slot] : 0.0;
        }
    }
    free(list);
    return 1;
}

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
    int found = s->start != NULL && linear_end(&d->p, m, &k, 1, beta, s->start);
    return found ? STEIN_OK : lab__no_memory(err);
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
