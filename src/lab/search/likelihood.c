/* SPDX-License-Identifier: GPL-3.0-or-later
 * likelihood.c - the strokes of a problem as a mixed model, and what follows from it at the end of
 * a fit.
 *
 * Around any unknowns x the strokes are linear in all of them (mixed.h):
 *
 *      d_s = F_s beta + Z_s u_s + G_s alpha + e,     d = r - J x,  F = -dr/dp,  Z = -dr/du
 *
 * beta the parameters with their priors; u what differs from stroke to stroke: trigger and offsets
 * with theirs, friction and drive with variances D that are estimated; alpha amounts of
 * candidates, each with the prior N(0, 1).
 *
 * What has no prior (initial states that the data decide) is profiled, not marginalised: its
 * determinant ln det(1 + Z'Z), nearly the same for every hypothesis, is left out.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "search.h"

enum { ROUNDS = 40, SLOTS = 64 };
static const double nearly = 0.98;
static const double flat = 1e3; /* sd of what has no prior, in its unit */

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

/* A kind of setting has a variance of its own; where there are more kinds than room, the last ones
 * share one. */
int diag__class_of(const fit__problem *p, const fit__unknown *u)
{
    if (u->kind == FIT__SCATTER) {
        return fit__class(u->index) - FIT__JOINTS;
    }
    if (u->kind == FIT__FORCE) {
        return DIAG_FORCES;
    }
    int class = DIAG_CLASSES, last = -1;
    for (int more = u->kind == FIT__SETTING; more && class < DIAG_FORCES - 1;) {
        int next = u->index;
        for (int k = p->np; k < p->nu; k++) {
            const fit__unknown *v = &p->unknown[k];
            next = v->kind == FIT__SETTING && v->index > last && v->index < next ? v->index : next;
        }
        more = next < u->index;
        class += more;
        last = next;
    }
    return u->kind == FIT__SETTING ? class : -1;
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
                l->class[l->n++] = diag__class_of(p, u);
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

static void negative(double *to, const double *from, size_t n, double times)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = -times * from[i];
    }
}

/* Is d the residual where this unknown is 0? One that is fitted counts from where it is, of which
 * the mixed model knows (at); one without a prior from anywhere. */
static int counts_from_zero(const fit__problem *p, int u)
{
    return u < p->np ? !is_free(p, u) : p->unknown[u].prior || p->unknown[u].idle;
}

/* columns of a stroke: F, the candidates, d, Z */
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
        for (size_t i = 0; counts_from_zero(p, u) && x[u] != 0.0 && i < n; i++) {
            d[i] -= j[i] * x[u];
        }
        int slot = k < p->np ? -1 : slot_of(l, t, &p->unknown[u]);
        if (slot >= 0) {
            negative(Z + (size_t)slot * n, j, n, p->unknown[u].prior ? 1.0 : flat);
        }
    }
    for (int k = 0; k < m->nf; k++) {
        negative(C + (size_t)k * n, J + fit__column(p, s, beta[k]), n, 1.0);
    }
    for (int k = 0; column != NULL && k < m->nc; k++) {
        negative(C + (size_t)(m->nf + k) * n, column[k] + at, n, 1.0);
    }
    lab__mixed_stroke(m, s, (int)n, C);
}

double diag__scatter_worth(int records)
{
    return fmax(0.0, DIAG_FEW_RECORDS - records);
}

int diag__scatters_most(const double *D)
{
    int most = 0;
    for (int i = 0; i < LAB_SCATTERS; i++) {
        most |= D[i] > nearly * diag__most_scatter;
    }
    return most;
}

stein_status diag__mixed_at(lab__mixed *m, const fit__problem *p, const double *x, const double *J,
                            const double *r, const double *const *column, int nc, stein_err *err)
{
    slots l;
    int *beta = calloc((size_t)p->np + 1, sizeof *beta);
    lab__scatter scatter[LAB_SCATTERS];
    find_slots(&l, p);
    for (int i = 0; i < LAB_SCATTERS; i++) {
        scatter[i] = (lab__scatter){1.0, i < DIAG_CLASSES   ? diag__most_scatter
                                         : i == DIAG_FORCES ? diag__guessed
                                                            : 1.0};
    }
    int nf = beta != NULL ? free_ones(p, beta) : 0;
    *m = (lab__mixed){.nf = 0};
    stein_status status = beta != NULL ? lab__mixed_make(m, p->nstroke, nf, nc, l.n, l.class, NULL,
                                                         scatter, LAB_SCATTERS, err)
                                       : lab__no_memory(err); // NOLINT(clang-analyzer-unix.Malloc)
    for (int k = 0; status == STEIN_OK && k < nf; k++) {
        m->at[k] = x[beta[k]];
    }
    m->worth = diag__scatter_worth(p->nstroke);
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
                     double *beta)
{
    double here = fit__chi2(p, r);
    for (int k = 0; k < p->nu; k++) {
        here += p->unknown[k].prior && !p->unknown[k].idle ? x[k] * x[k] : 0.0;
    }
    return fmax(0.0, here - lab__mixed_least(m, NULL, 0, beta));
}

void diag__local_close(diag__local *l)
{
    free(l->free);
    free(l->beta);
    lab__mixed_free(&l->m);
}

stein_status diag__local_open(diag__local *l, const fit__problem *p, const double *x,
                              const double *J, const double *r, stein_err *err)
{
    *l = (diag__local){.free = malloc(sizeof *l->free * (size_t)(p->np + 1))};
    if (l->free == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = diag__mixed_at(&l->m, p, x, J, r, NULL, 0, err);
    l->nfree = free_ones(p, l->free);
    size_t n = (size_t)l->nfree;
    l->beta = malloc(sizeof *l->beta * (n + n * n + 1));
    l->cov = l->beta != NULL ? l->beta + n : NULL;
    return l->beta == NULL ? lab__no_memory(err) : status;
}

/* ln det(1 + Z'Z) of a stroke's unknowns without a prior; 0: it has none, or they have no finite
 * derivatives */
static double free_determinant(const fit__problem *p, int s, const double *J)
{
    const fit__stroke *t = &p->stroke[s];
    const size_t n = (size_t)t->nch * (size_t)t->n;
    const double *z[SLOTS];
    double A[SLOTS * SLOTS], det = 0.0;
    int m = 0;
    for (int k = 0; k < t->own && m < SLOTS; k++) {
        const fit__unknown *u = &p->unknown[t->first + k];
        if (!u->prior && !u->idle) {
            z[m++] = J + fit__column(p, s, p->np + k);
        }
    }
    for (int i = 0; i < m; i++) {
        for (int k = 0; k <= i; k++) {
            double a = flat * flat * lab__dot(z[i], z[k], n) + (i == k);
            A[i * m + k] = A[k * m + i] = a;
        }
    }
    if (m == 0) {
        return 0.0;
    }
    gsl_matrix_view view = gsl_matrix_view_array(A, (size_t)m, (size_t)m);
    if (gsl_linalg_cholesky_decomp1(&view.matrix) != 0) {
        return 0.0;
    }
    for (int i = 0; i < m; i++) {
        det += 2.0 * stein__log_of(A[i * m + i]);
    }
    return det;
}

stein_status diag__likelihood(const fit__problem *p, const double *x, const double *J,
                              const double *r, double *D, double *sd, double *objective,
                              stein_err *err)
{
    diag__local l;
    stein_status status = diag__local_open(&l, p, x, J, r, err);
    if (status == STEIN_OK) {
        double more = unkept(&l.m, p, x, r, l.beta);
        double found = more + lab__mixed_scatter(&l.m, NULL, 0, ROUNDS, l.beta, l.cov);
        memcpy(D, l.m.D, sizeof l.m.D);
        for (int s = 0; s < p->nstroke; s++) {
            found -= free_determinant(p, s, J);
        }
        *objective = found;
        memset(sd, 0, sizeof *sd * (size_t)p->np);
        for (int i = 0; i < l.nfree; i++) {
            sd[l.free[i]] = sqrt(fmax(0.0, l.cov[i * l.nfree + i]));
        }
    }
    diag__local_close(&l);
    return status;
}
