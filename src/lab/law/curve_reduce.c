/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_reduce.c - an unknown law with all other unknowns eliminated.
 *
 * The curve is a table of the extended mechanism and its values f are parameters. So a stroke with
 * a law is simulated like any other, and the law acts through all contacts and events. With v all
 * other unknowns (parameters, each stroke's own),
 *
 *      r(v, f) = r + J dv + G df,   e ~ N(0, 1),   v under its priors,   f ~ N(0, tau^2 K),
 *      K_ij = k(|x_i - x_j| / length),   k(d) = exp(-d^2/2)                              (smooth)
 *                                             (1 + u + u^2/3) exp(-u), u = sqrt(5) d     (Matern)
 *                                             (1 + w) exp(-w),         w = sqrt(3) d     (rough)
 *
 * v is eliminated exactly (S: what is left of J'J when strokes' own unknowns are out),
 *
 *      M = S_ff - S_fp S_pp^-1 S_pf,     c = -(g_f - S_fp S_pp^-1 g_p) + M f_now
 *      f | r = L (1 + L'ML)^-1 L'c,      cov = L (1 + L'ML)^-1 L',      tau^2 K = L L'
 *      -2 ln p(r | tau, length) = const - c'L (1 + L'ML)^-1 L'c + ln |1 + L'ML|
 *
 * and tau, length and kind maximise the marginal likelihood (Rasmussen & Williams 2006, ch. 5). The
 * prior prefers no shape: constant, straight or wavy. The determinant is the price of the curve's
 * freedom, so that places and states of different units compare.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>

#include "curve_fitting.h"
#include "functions.h"

/* ---- eliminating everything else ---- */

stein_status diag__globals_of(fit__normal *n, const fit__problem *p, diag__globals *o,
                              stein_err *err)
{
    *o = (diag__globals){.row = n->row,
                         .S = gsl_matrix_alloc((size_t)n->n, (size_t)n->n),
                         .g = gsl_vector_alloc((size_t)n->n)};
    if (o->S == NULL || o->g == NULL) {
        return lab__no_memory(err);
    }
    fit__normal_factor(n, p, 0.0, NULL); // S may be singular; the factors of the strokes are needed
    gsl_matrix_memcpy(o->S, n->A);
    for (size_t i = 0; i < o->g->size; i++) {
        gsl_vector_set(o->g, i, n->g[n->moving[i]]);
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] != NULL) {
            gsl_vector_const_view g =
                gsl_vector_const_view_array(n->g + p->stroke[s].first, (size_t)p->stroke[s].own);
            gsl_blas_dgemm(CblasTrans, CblasNoTrans, -1.0, n->C[s], n->X[s], 1.0, o->S);
            gsl_blas_dgemv(CblasTrans, -1.0, n->X[s], &g.vector, 1.0, o->g);
        }
    }
    return STEIN_OK;
}

void diag__globals_free(diag__globals *o)
{
    gsl_matrix_free(o->S);
    gsl_vector_free(o->g);
}

/* unknowns that are neither of the curve nor of another one */
static int is_other(const diag__curves *w, int k)
{
    return k < w->site[0].first || k >= w->p.amount;
}

void diag__others_free(diag__others *o)
{
    free(o->index);
    gsl_matrix_free(o->F);
    gsl_matrix_free(o->X);
    gsl_vector_free(o->g);
}

static double between(const diag__globals *o, int u, int v)
{
    return gsl_matrix_get(o->S, (size_t)o->row[u], (size_t)o->row[v]);
}

static double gradient(const diag__globals *o, int u)
{
    return gsl_vector_get(o->g, (size_t)o->row[u]);
}

stein_status diag__reduce(const diag__curves *w, const diag__site *s, const diag__globals *o,
                          const double *x, diag__others *t, diag__reduced *q, stein_err *err)
{
    const fit__problem *p = &w->p;
    *t = (diag__others){.index = malloc(sizeof(int) * (size_t)(p->np + 1))};
    *q = (diag__reduced){.n = 0};
    for (int k = 0; t->index != NULL && k < p->np; k++) {
        if (is_other(w, k) && !p->unknown[k].idle) {
            t->index[t->n++] = k;
        }
    }
    for (int k = s->pinned; k < s->n; k++) {
        q->index[q->n++] = s->first + k;
    }
    size_t n = (size_t)q->n, m = (size_t)t->n, room = m > 0 ? m : 1;
    t->F = gsl_matrix_calloc(room, room);
    t->X = gsl_matrix_calloc(room, n);
    t->g = gsl_vector_calloc(room);
    if (t->index == NULL || t->F == NULL || t->X == NULL || t->g == NULL) {
        return lab__no_memory(err);
    }
    for (size_t a = 0; a < m; a++) {
        for (size_t b = 0; b < m; b++) {
            gsl_matrix_set(t->F, a, b, between(o, t->index[a], t->index[b]));
        }
        for (size_t b = 0; b < n; b++) {
            gsl_matrix_set(t->X, a, b, between(o, t->index[a], q->index[b]));
        }
        *gsl_matrix_ptr(t->F, a, a) += 1e-12;
        gsl_vector_set(t->g, a, gradient(o, t->index[a]));
    }
    if (m == 0) {
        gsl_matrix_set(t->F, 0, 0, 1.0);
    }
    if (gsl_linalg_cholesky_decomp1(t->F) != 0) {
        return lab__fail(err, STEIN_ESINGULAR, "the data do not separate the free numbers");
    }
    for (size_t b = 0; b < n; b++) {
        gsl_vector_view column = gsl_matrix_column(t->X, b);
        gsl_linalg_cholesky_svx(t->F, &column.vector);
    }
    gsl_linalg_cholesky_svx(t->F, t->g);
    for (int a = 0; a < q->n; a++) {
        double c = -gradient(o, q->index[a]);
        for (int b = 0; b < q->n; b++) {
            double sum = between(o, q->index[a], q->index[b]);
            for (size_t k = 0; k < m; k++) {
                sum -= between(o, q->index[a], t->index[k]) * gsl_matrix_get(t->X, k, (size_t)b);
            }
            q->M[a * q->n + b] = sum;
        }
        for (size_t k = 0; k < m; k++) {
            c += between(o, q->index[a], t->index[k]) * gsl_vector_get(t->g, k);
        }
        q->c[a] = c;
    }
    for (int a = 0; a < q->n; a++) {
        for (int b = 0; b < a; b++) {
            double v = 0.5 * (q->M[a * q->n + b] + q->M[b * q->n + a]);
            q->M[a * q->n + b] = q->M[b * q->n + a] = v;
        }
        for (int b = 0; b < q->n; b++) {
            q->c[a] += q->M[a * q->n + b] * x[q->index[b]];
        }
    }
    return STEIN_OK;
}

/* ---- noise that is not stated ----
 *
 * Then the noise is an unknown, too: variances are larger than the records show by a factor e = v
 * i, i for what is alike from sample to sample, and with N = samples / i of them that count
 *
 *      -2 ln p = chi2 / e + N ln v - gained
 *
 * has a minimum where the law is worth nothing (v: what is left now) and another where it explains
 * most (v: what it would leave). The lower one is taken. Where a fall of 47 m misses the air by a
 * hundred times the noise, no curve is worth anything as long as that counts as noise.
 */

void diag__temper(diag__reduced *q, double excess)
{
    for (int i = 0; i < q->n; i++) {
        q->c[i] /= excess;
        for (int j = 0; j < q->n; j++) {
            q->M[i * q->n + j] /= excess;
        }
    }
}

/* chi2 that the law of q would leave, of what is left at x; M and c of q without an excess */
static double predicted(const diag__reduced *q, const double *f, const double *x, double chi2)
{
    for (int i = 0; i < q->n; i++) {
        double Md = 0.0, Mx = 0.0;
        for (int j = 0; j < q->n; j++) {
            Md += q->M[i * q->n + j] * (f[j] - x[q->index[j]]);
            Mx += q->M[i * q->n + j] * x[q->index[j]];
        }
        chi2 -= (f[i] - x[q->index[i]]) * (2.0 * (q->c[i] - Mx) - Md);
    }
    return fmax(0.0, chi2);
}

/* the law at a factor on variances */
static diag__reduced at_noise(const diag__site *s, const diag__reduced *q, double excess)
{
    diag__reduced tempered = *q;
    diag__temper(&tempered, excess);
    diag__curve_choose(s, &tempered);
    return tempered;
}

double diag__curve_choose_noise(const diag__curves *w, const diag__site *s, const double *x,
                                const double *r, diag__reduced *q)
{
    const fit__problem *p = &w->p;
    if (fit__noise_given(p)) {
        diag__curve_choose(s, q);
        return 1.0;
    }
    int values = p->amount - w->site[0].first; // of all curves, of which one moves
    double dof = fmax(1.0, p->samples - (p->nu - values)), chi2 = fit__chi2(p, r);
    double alike = fmax(1.0, fit__inflation(p, r)), now = fmax(1.0, chi2 / dof);
    diag__reduced all = at_noise(s, q, alike);
    double then = fmin(now, fmax(1.0, predicted(q, all.f, x, chi2) / dof));
    diag__reduced little = at_noise(s, q, now * alike), much = at_noise(s, q, then * alike);
    double of_little = (chi2 / now + dof * stein__log_of(now)) / alike - little.gained;
    double of_much = (chi2 / then + dof * stein__log_of(then)) / alike - much.gained;
    *q = of_much < of_little ? much : little;
    return (of_much < of_little ? then : now) * alike;
}

/* ---- to first order ---- */

stein_status diag__curve_scores(diag__curves *w, diag__curve *c, stein_err *err)
{
    fit__normal n;
    diag__globals o = {.S = NULL};
    diag__curve_hold(w, 1);
    stein_status status = fit__normal_make(&n, &w->p, err);
    if (status == STEIN_OK) {
        fit__normal_fill(&n, &w->p, w->x, w->r, w->J, 1);
        status = diag__globals_of(&n, &w->p, &o, err);
    }
    for (int i = 0; status == STEIN_OK && i < w->nsite; i++) {
        const diag__site *s = &w->site[i];
        diag__others t;
        diag__reduced q;
        c[i] = (diag__curve){.site = s, .gain = -INFINITY};
        status = diag__reduce(w, s, &o, w->x, &t, &q, err);
        if (status == STEIN_OK) {
            c[i].excess = diag__curve_choose_noise(w, s, w->x, w->r, &q);
            c[i].gain = q.gained;
        }
        diag__others_free(&t);
    }
    fit__normal_free(&n);
    diag__globals_free(&o);
    return status;
}
