/* SPDX-License-Identifier: GPL-3.0-or-later
 * likelihood.c - the strokes of a problem as a mixed model, and what follows from it at the end of
 * a fit.
 *
 * Around any unknowns x the strokes are linear in all of them (mixed.h):
 *
 *      d_s = F_s beta + Z_s u_s + G_s alpha + e,     d = r - J x,  F = -dr/dp,  Z = -dr/du
 *
 * beta the parameters with their priors; u what differs from stroke to stroke: trigger and offsets
 * with theirs, friction and drive with variances D that are estimated; alpha the numbers of the
 * effect on trial, each with the prior N(0, 1).
 */
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { ROUNDS = 40, SLOTS = 64 };
static const double most_scatter = 6.25; /* variance, in those of the prior */
static const double nearly = 0.98;

/* ---- columns ---- */

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

/* is unknown k < np fitted, and no number of the effect on trial? */
static int is_free(const fit__problem *p, int k)
{
    return !p->unknown[k].idle && (k < p->amount || k >= p->amount + FIT__NUMBERS);
}

static int free_ones(const fit__problem *p, int *list)
{
    int n = 0;
    for (int k = 0; k < p->np; k++) {
        if (is_free(p, k)) {
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
    size_t n = (size_t)t->nch * (size_t)t->n, at = fit__offset(p, s);
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

int diag__scatters_most(const double *D)
{
    int most = 0;
    for (int i = 0; i < LAB_SCATTERS; i++) {
        most |= D[i] > nearly * most_scatter;
    }
    return most;
}

stein_status diag__mixed_at(lab__mixed *m, const fit__problem *p, const double *x, const double *J,
                            const double *r, const double *const *column, int nc, stein_err *err)
{
    slots l;
    int *beta = calloc((size_t)p->np + 1, sizeof *beta);
    lab__scatter scatter[DIAG_CLASSES];
    find_slots(&l, p);
    for (int i = 0; i < DIAG_CLASSES; i++) {
        scatter[i] = (lab__scatter){1.0, most_scatter};
    }
    int nf = beta != NULL ? free_ones(p, beta) : 0;
    *m = (lab__mixed){.nf = 0};
    stein_status status = beta != NULL ? lab__mixed_make(m, p->nstroke, nf, nc, l.n, l.class, NULL,
                                                         scatter, DIAG_CLASSES, err)
                                       : lab__no_memory(err); // NOLINT(clang-analyzer-unix.Malloc)
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
               sizeof *to * (size_t)t->nch * (size_t)t->n);
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

void diag__local_close(diag__local *l)
{
    for (int i = 0; i < l->n; i++) {
        free(l->column[i]);
    }
    free(l->free);
    free(l->beta);
    lab__mixed_free(&l->m);
}

stein_status diag__local_open(diag__local *l, const fit__problem *p, const double *x,
                              const double *J, const double *r, stein_err *err)
{
    *l = (diag__local){.n = 0, .free = malloc(sizeof *l->free * (size_t)(p->np + 1))};
    int memory = l->free != NULL;
    for (int i = 0; p->amount >= 0 && i < FIT__NUMBERS; i++) {
        if (!p->unknown[p->amount + i].idle) {
            l->with[l->n] = l->n;
            l->unknown[l->n] = p->amount + i;
            memory &= (l->column[l->n++] = diag__column(p, J, p->amount + i)) != NULL;
        }
    }
    if (!memory) {
        return lab__no_memory(err);
    }
    stein_status status =
        diag__mixed_at(&l->m, p, x, J, r, (const double *const *)l->column, l->n, err);
    l->nfree = free_ones(p, l->free);
    size_t n = (size_t)l->nfree + (size_t)l->n;
    l->beta = malloc(sizeof *l->beta * (n + n * n + 1));
    l->cov = l->beta != NULL ? l->beta + n : NULL;
    return l->beta == NULL ? lab__no_memory(err) : status;
}

int diag__unknown_of(const diag__local *l, int i)
{
    return i < l->nfree ? l->free[i] : l->unknown[i - l->nfree];
}

void diag__deviations(const diag__local *l, const fit__problem *p, double *sd)
{
    int n = l->nfree + l->n;
    memset(sd, 0, sizeof *sd * (size_t)p->np);
    for (int i = 0; i < n; i++) {
        sd[diag__unknown_of(l, i)] = sqrt(fmax(0.0, l->cov[i * n + i]));
    }
}

stein_status diag__likelihood(const fit__problem *p, const double *x, const double *J,
                              const double *r, double *D, double *sd, double *objective,
                              double *promised, stein_err *err)
{
    diag__local l;
    stein_status status = diag__local_open(&l, p, x, J, r, err);
    if (status == STEIN_OK) {
        double more = unkept(&l.m, p, x, r, l.with, l.n, l.beta);
        double found = more + lab__mixed_scatter(&l.m, l.with, l.n, ROUNDS, l.beta, l.cov);
        memcpy(D, l.m.D, sizeof l.m.D);
        if (objective != NULL) {
            *objective = found;
        }
        if (promised != NULL) {
            *promised = found - more;
        }
        diag__deviations(&l, p, sd);
    }
    diag__local_close(&l);
    return status;
}

void diag__linear_end(const fit__problem *p, const lab__mixed *m, const int *with, int nwith,
                      const double *beta, double *x)
{
    slots l;
    double u[SLOTS];
    int n = 0;
    for (int k = 0; k < p->np; k++) {
        if (is_free(p, k)) {
            x[k] = beta[n++];
        }
    }
    for (int i = 0; i < nwith; i++) {
        x[p->amount + i] = beta[n++];
    }
    find_slots(&l, p);
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        lab__mixed_effects(m, s, with, nwith, beta, u);
        for (int i = 0; i < t->own; i++) {
            int slot = slot_of(&l, t, &p->unknown[t->first + i]);
            x[t->first + i] = slot >= 0 ? u[slot] : 0.0;
        }
    }
}

double diag__squares(const diag__local *l, const fit__problem *p, const double *x, const double *r)
{
    slots all;
    double sum = fit__chi2(p, r);
    for (int i = 0; i < l->nfree + l->n; i++) {
        sum += x[diag__unknown_of(l, i)] * x[diag__unknown_of(l, i)];
    }
    find_slots(&all, p);
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int i = 0; i < t->own; i++) {
            int slot = slot_of(&all, t, &p->unknown[t->first + i]);
            int class = slot >= 0 ? all.class[slot] : -1;
            sum += x[t->first + i] * x[t->first + i] / (class < 0 ? 1.0 : l->m.D[class]);
        }
    }
    return sum;
}

/* ---- draws ---- */

/* to += eps L z, with L L' = a positive matrix [n*n], which is lost. @return 0 when it is not one
 */
static int add_draw(double *a, int n, double eps, gsl_rng *rng, double *to)
{
    if (n == 0) {
        return 1;
    }
    gsl_matrix_view m = gsl_matrix_view_array(a, (size_t)n, (size_t)n);
    if (gsl_linalg_cholesky_decomp1(&m.matrix) != 0) {
        return 0;
    }
    for (int k = 0; k < n; k++) {
        double z = eps * gsl_ran_ugaussian(rng);
        for (int i = k; i < n; i++) {
            to[i] += a[i * n + k] * z;
        }
    }
    return 1;
}

stein_status diag__draw(const diag__local *l, const fit__problem *p, double eps, gsl_rng *rng,
                        const double *x, double *to, stein_err *err)
{
    slots all;
    int n = l->nfree + l->n, nz = l->m.nz, ok = 1;
    size_t size = (size_t)(n > nz ? n * n : nz * nz);
    double *a = malloc(sizeof *a * (size + (size_t)n + 1)), *beta = a + size;
    if (a == NULL) {
        return lab__no_memory(err);
    }
    memcpy(a, l->cov, sizeof *a * (size_t)(n * n));
    memcpy(beta, l->beta, sizeof *beta * (size_t)n);
    ok = add_draw(a, n, eps, rng, beta);
    memcpy(to, x, sizeof *to * (size_t)p->nu);
    for (int i = 0; i < n; i++) {
        to[diag__unknown_of(l, i)] += beta[i] - l->beta[i];
    }
    find_slots(&all, p);
    for (int s = 0; ok && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        double u[SLOTS], here[SLOTS];
        lab__mixed_effects(&l->m, s, l->with, l->n, l->beta, here);
        lab__mixed_effects(&l->m, s, l->with, l->n, beta, u);
        memcpy(a, l->m.W + (size_t)s * (size_t)(nz * nz), sizeof *a * (size_t)(nz * nz));
        ok = add_draw(a, nz, eps, rng, u);
        for (int i = 0; ok && i < t->own; i++) {
            int slot = slot_of(&all, t, &p->unknown[t->first + i]);
            to[t->first + i] += slot >= 0 ? u[slot] - here[slot] : 0.0;
        }
    }
    free(a);
    return ok ? STEIN_OK : lab__fail(err, STEIN_EINVAL, "the likelihood has no maximum here");
}
