/* SPDX-License-Identifier: GPL-3.0-or-later
 * minimise.c - Levenberg-Marquardt on normal equations whose nuisances are eliminated.
 *
 * With x = (p, n_1 ... n_S), free parameters and each stroke's own, J'J is an arrow:
 *
 *      | A   C_1' ... C_S' | dp  |       |g_p|     S = A - sum C_s' B_s^-1 C_s       (Schur)
 *      | C_1 B_1           | dn_1|  = -  |g_1|     S dp = -g_p + sum C_s' B_s^-1 g_s
 *      | C_S          B_S  | dn_S|       |g_S|     dn_s = -B_s^-1 (g_s + C_s dp)
 *
 * with the priors' 1 on the diagonal (x counts prior standard deviations) and mu diag(J'J) for the
 * damping (Marquardt 1963), mu by Nielsen's rule (Madsen, Nielsen & Tingleff 2004, 3.2).
 *
 * Why not GSL's multifit_nlinear: its dense J holds a column for every nuisance of every stroke
 * (100 strokes x 4 nuisances x 10^5 rows); a stroke that cannot be simulated has no residual to
 * return, where here the step is simply refused; and its state is hidden, so that an interrupted
 * search could not go on bit for bit. The method is the same, a test compares the two. Normal
 * equations square the condition number; in prior units it is bounded by the ratio of prior to data
 * sd, 10^4 at the worst seen, and 10^8 is still harmless here.
 *
 * It ends when the decrement g' (J'J)^-1 g, what one more step would gain, is below a figure: 1e-4
 * is a hundredth of a standard deviation in the direction that is furthest off. With one-sided
 * differences it also ends when a step has gained less than ten times the figure.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { AT_BOUND = 2, MAX_REFUSED = 12, CHORDS = 5, DAMPINGS = 4 };
static const double far_off = 30.0;          /* objective, from where no chord leads back */
static const double least_compliance = 3e-4; /* limits */
static const double longest_step = 3.0;      /* of an unknown with a prior, in its sd */

/* ---- the arrow ---- */

stein_status fit__normal_make(fit__normal *n, const fit__problem *p, stein_err *err)
{
    size_t np = (size_t)p->np, ns = (size_t)p->nstroke;
    *n = (fit__normal){.np = p->np, .nu = p->nu, .nstroke = p->nstroke};
    n->A = gsl_matrix_alloc(np, np);
    n->S = gsl_matrix_alloc(np, np);
    n->g = calloc((size_t)p->nu + 1, sizeof *n->g);
    n->product = calloc((size_t)p->nu + 1, sizeof *n->product);
    n->moving = calloc(2 * np + 1, sizeof *n->moving);
    n->row = n->moving + (n->moving != NULL ? np : 0);
    n->B = calloc(4 * ns + 1, sizeof *n->B);
    int memory = n->A && n->S && n->g && n->product && n->moving && n->B;
    n->C = n->B + (memory ? ns : 0);
    n->BL = n->C + (memory ? ns : 0);
    n->X = n->BL + (memory ? ns : 0);
    for (size_t s = 0; memory && s < ns; s++) {
        size_t own = (size_t)p->stroke[s].own;
        if (own > 0) {
            n->B[s] = gsl_matrix_alloc(own, own);
            n->BL[s] = gsl_matrix_alloc(own, own);
            n->C[s] = gsl_matrix_alloc(own, np);
            n->X[s] = gsl_matrix_alloc(own, np);
            memory = n->B[s] && n->BL[s] && n->C[s] && n->X[s];
        }
    }
    return memory ? STEIN_OK : lab__no_memory(err);
}

void fit__normal_free(fit__normal *n)
{
    gsl_matrix_free(n->A);
    gsl_matrix_free(n->S);
    for (int i = 0; n->B != NULL && i < 4 * n->nstroke; i++) {
        gsl_matrix_free(n->B[i]);
    }
    free(n->B);
    free(n->g);
    free(n->product);
    free(n->moving);
}

/* a matrix whose block has room for more */
static void shape(gsl_matrix *m, size_t rows, size_t columns)
{
    m->size1 = rows;
    m->size2 = m->tda = columns;
}

/* what moves, and matrices of that size, of zeros */
static void begin_fill(fit__normal *n, const fit__problem *p)
{
    n->n = 0;
    for (int u = 0; u < p->np; u++) {
        int moves = u != p->fixed && !p->unknown[u].idle;
        n->row[u] = moves ? n->n : -1;
        n->moving[n->n] = moves ? u : n->moving[n->n];
        n->n += moves;
    }
    size_t m = (size_t)n->n;
    shape(n->A, m, m);
    shape(n->S, m, m);
    gsl_matrix_set_zero(n->A);
    for (int s = 0; s < p->nstroke; s++) {
        if (n->B[s] != NULL) {
            shape(n->C[s], (size_t)p->stroke[s].own, m);
            shape(n->X[s], (size_t)p->stroke[s].own, m);
            gsl_matrix_set_zero(n->B[s]);
            gsl_matrix_set_zero(n->C[s]);
        }
    }
    memset(n->g, 0, sizeof *n->g * (size_t)p->nu);
}

/* column a of a stroke's derivatives with those before it, and itself, into its place: globals come
 * first, then its own */
static void fill_row(fit__normal *n, int s, int a, const double *product)
{
    size_t i = (size_t)(a < n->n ? a : a - n->n);
    for (int b = 0; b <= a; b++) {
        size_t k = (size_t)(b < n->n ? b : b - n->n);
        gsl_matrix *m = a < n->n ? n->A : b < n->n ? n->C[s] : n->B[s];
        gsl_matrix_set(m, i, k, gsl_matrix_get(m, i, k) + product[b]);
        if (m != n->C[s] && i != k) {
            gsl_matrix_set(m, k, i, gsl_matrix_get(m, i, k));
        }
    }
}

/* where column a is in the derivatives of a stroke */
static int column_of(const fit__normal *n, int a)
{
    return a < n->n ? n->moving[a] : n->np + a - n->n;
}

static void fill_stroke(fit__normal *n, const fit__problem *p, int s, const double *r,
                        const double *J)
{
    const fit__stroke *t = &p->stroke[s];
    const double *first = J + fit__column(p, s, 0);
    size_t size = (size_t)(t->nch * t->n);
    r += fit__offset(p, s);
    for (int a = 0; a < n->n + t->own; a++) {
        const double *column = first + size * (size_t)column_of(n, a);
        n->g[a < n->n ? n->moving[a] : t->first + a - n->n] += lab__dot(column, r, size);
        for (int b = 0, run; b <= a; b += run) { // columns beside each other at once
            run = 1;
            while (b + run <= a && column_of(n, b + run) == column_of(n, b) + run) {
                run++;
            }
            lab__dots(column, first + size * (size_t)column_of(n, b), size, run, n->product + b);
        }
        fill_row(n, s, a, n->product);
    }
}

/* NULL: it stays */
static double *diagonal(const fit__normal *n, const fit__problem *p, int u)
{
    if (u < p->np) {
        size_t row = (size_t)n->row[u];
        return n->row[u] >= 0 ? gsl_matrix_ptr(n->A, row, row) : NULL;
    }
    int s = p->unknown[u].stroke;
    size_t i = (size_t)(u - p->stroke[s].first);
    return gsl_matrix_ptr(n->B[s], i, i);
}

void fit__normal_fill(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                      const double *J, int prior)
{
    begin_fill(n, p);
    for (int s = 0; s < p->nstroke; s++) {
        fill_stroke(n, p, s, r, J);
    }
    for (int u = 0; u < p->nu; u++) {
        // own priors always count: without them the data would be asked what a marker's offset is
        double *d = diagonal(n, p, u);
        if (d != NULL && p->unknown[u].prior && u != p->flat && (prior || u >= p->np)) {
            *d += 1.0;
            n->g[u] += x[u];
        }
    }
}

/* Cholesky factor of (m with mu added to its diagonal) in f; -1 when it is not positive */
static int factor(gsl_matrix *f, const gsl_matrix *m, double mu)
{
    gsl_matrix_memcpy(f, m);
    for (size_t i = 0; i < m->size1; i++) {
        double d = gsl_matrix_get(m, i, i);
        gsl_matrix_set(f, i, i, d + mu * d + 1e-12);
    }
    return gsl_linalg_cholesky_decomp1(f) == 0 ? 0 : -1;
}

int fit__normal_factor(fit__normal *n, double mu)
{
    gsl_matrix_memcpy(n->S, n->A);
    for (size_t i = 0; i < (size_t)n->n; i++) {
        double *d = gsl_matrix_ptr(n->S, i, i);
        *d += mu * *d + 1e-12;
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] == NULL) {
            continue;
        }
        if (factor(n->BL[s], n->B[s], mu) != 0) {
            return -1;
        }
        if (n->n == 0) {
            continue;
        }
        gsl_matrix_memcpy(n->X[s], n->C[s]);
        for (size_t k = 0; k < (size_t)n->n; k++) {
            gsl_vector_view column = gsl_matrix_column(n->X[s], k);
            gsl_linalg_cholesky_svx(n->BL[s], &column.vector);
        }
        gsl_blas_dgemm(CblasTrans, CblasNoTrans, -1.0, n->C[s], n->X[s], 1.0, n->S);
    }
    return n->n == 0 || gsl_linalg_cholesky_decomp1(n->S) == 0 ? 0 : -1;
}

/* of the globals, in n->product */
static gsl_vector_view step_of_globals(const fit__normal *n, const fit__problem *p)
{
    gsl_vector_view dp = gsl_vector_view_array(n->product, (size_t)n->n);
    for (int i = 0; i < n->n; i++) {
        n->product[i] = -n->g[n->moving[i]];
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] != NULL) {
            gsl_vector_const_view g =
                gsl_vector_const_view_array(n->g + p->stroke[s].first, (size_t)p->stroke[s].own);
            gsl_blas_dgemv(CblasTrans, 1.0, n->X[s], &g.vector, 1.0, &dp.vector);
        }
    }
    gsl_linalg_cholesky_svx(n->S, &dp.vector);
    return dp;
}

void fit__normal_step(const fit__normal *n, const fit__problem *p, double *dx)
{
    gsl_vector_view dp;
    for (int u = 0; u < p->nu; u++) {
        dx[u] = u < p->np ? 0.0 : -n->g[u];
    }
    if (n->n > 0) {
        dp = step_of_globals(n, p);
    }
    for (int i = 0; i < n->n; i++) {
        dx[n->moving[i]] = gsl_vector_get(&dp.vector, (size_t)i);
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] != NULL) {
            gsl_vector_view dn =
                gsl_vector_view_array(dx + p->stroke[s].first, (size_t)p->stroke[s].own);
            gsl_linalg_cholesky_svx(n->BL[s], &dn.vector); // -B^-1 g
            if (n->n > 0) {
                gsl_blas_dgemv(CblasNoTrans, -1.0, n->X[s], &dp.vector, 1.0, &dn.vector);
            }
        }
    }
}

/* ---- the search ---- */

typedef struct room {
    fit__normal normal;
    double *r, *try_r, *J, *dx, *try_x;
    double prior; /* weight of the priors in a step of fit__descend */
} room;

static stein_status room_make(room *m, const fit__problem *p, stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    m->r = malloc(sizeof *m->r * (2 * rows + 2 * nu + 1));
    m->J = malloc(sizeof *m->J * (fit__columns(p) + 1));
    stein_status status = fit__normal_make(&m->normal, p, err);
    if (status == STEIN_OK && (m->r == NULL || m->J == NULL)) {
        status = lab__no_memory(err);
    }
    m->try_r = m->r + (m->r != NULL ? rows : 0);
    m->dx = m->try_r + (m->r != NULL ? rows : 0);
    m->try_x = m->dx + (m->r != NULL ? nu : 0);
    return status;
}

static void room_free(room *m)
{
    fit__normal_free(&m->normal);
    free(m->r);
    free(m->J);
}

/* what a full step without damping would gain */
static double decrement(room *m, const fit__problem *p)
{
    if (fit__normal_factor(&m->normal, 0.0) != 0) {
        return INFINITY;
    }
    fit__normal_step(&m->normal, p, m->dx);
    return -lab__dot(m->dx, m->normal.g, (size_t)p->nu);
}

/* a step that is not absurd, tried. @return 1 when it is better */
static int try_step(fit__problem *p, fit__state *s, room *m, double *gain_ratio,
                    stein_status *status, stein_err *err)
{
    double longest = 0.0, scale = 1.0, predicted = 0.0;
    if (fit__normal_factor(&m->normal, s->mu) != 0) {
        return 0;
    }
    fit__normal_step(&m->normal, p, m->dx);
    for (int u = 0; u < p->nu; u++) {
        longest = p->unknown[u].prior ? fmax(longest, fabs(m->dx[u])) : longest;
    }
    scale = longest > longest_step ? longest_step / longest : 1.0;
    for (int u = 0; u < p->nu; u++) {
        const double *d = diagonal(&m->normal, p, u);
        m->try_x[u] = s->x[u] + scale * m->dx[u];
        predicted += d != NULL ? m->dx[u] * (s->mu * *d * m->dx[u] - m->normal.g[u]) : 0.0;
    }
    int failed = 0;
    *status = fit__residuals(p, m->try_x, m->try_r, &failed, err);
    if (*status != STEIN_OK || failed > 0) {
        return 0;
    }
    double there = fit__chi2(p, m->try_r) + fit__priors(p, m->try_x);
    *gain_ratio = (s->objective - there) / fmax(predicted, 1e-300);
    if (!(there < s->objective)) {
        return 0;
    }
    s->objective = there;
    memcpy(s->x, m->try_x, sizeof *s->x * (size_t)p->nu);
    memcpy(m->r, m->try_r, sizeof *m->r * fit__offset(p, p->nstroke));
    return 1;
}

/* one Jacobian, and steps until one is better. @return 0 when none is */
static int iterate(fit__problem *p, fit__state *s, room *m, stein_status *status, stein_err *err)
{
    for (int refused = 0; refused < MAX_REFUSED; refused++) {
        double ratio = 0.0;
        int better = try_step(p, s, m, &ratio, status, err);
        if (*status != STEIN_OK) {
            return 0;
        }
        if (better) {
            double f = 2.0 * ratio - 1.0;
            s->mu = fmax(1e-12, s->mu * fmax(1.0 / 10.0, 1.0 - f * f * f));
            s->nu = 2.0;
            return 1;
        }
        s->mu *= s->nu;
        s->nu *= 2.0;
    }
    return 0;
}

/* residuals and objective where the search begins */
static stein_status begin(const fit__problem *p, fit__state *s, room *m, stein_err *err)
{
    int failed = 0;
    stein_status status = fit__residuals(p, s->x, m->r, &failed, err);
    if (status == STEIN_OK && failed > 0) {
        return lab__fail(err, STEIN_ENONFINITE, "%d of %d strokes cannot be simulated", failed,
                         p->nstroke);
    }
    s->objective = fit__chi2(p, m->r) + fit__priors(p, s->x);
    return status;
}

/* the gradient at another point, with the same derivatives and weight of the priors */
static void new_gradient(room *m, const fit__problem *p, const double *x, const double *r)
{
    fit__normal *n = &m->normal;
    const double *J = m->J;
    memset(n->g, 0, sizeof *n->g * (size_t)p->nu);
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int a = 0; a < n->n + t->own; a++) {
            n->g[a < n->n ? n->moving[a] : t->first + a - n->n] +=
                lab__dot(J + fit__column(p, s, column_of(n, a)), r + fit__offset(p, s),
                         (size_t)(t->nch * t->n));
        }
    }
    for (int u = 0; u < p->nu; u++) {
        int moves = u >= p->np || n->row[u] >= 0;
        n->g[u] += moves && p->unknown[u].prior && u != p->flat ? m->prior * x[u] : 0.0;
    }
}

/* numbers of the mechanism and those beside an effect's amount stay within some prior sd */
static int is_bounded(const fit__unknown *u)
{
    return u->prior && (u->kind == FIT__PARAM || u->kind == FIT__SIDE);
}

/* objective at x + dx, which may be shortened; INFINITY when it cannot be simulated */
static double go(fit__problem *p, room *m, const double *x, stein_status *status, stein_err *err)
{
    double longest = 0.0;
    int failed = 0;
    for (int u = 0; u < p->nu; u++) {
        longest = p->unknown[u].prior ? fmax(longest, fabs(m->dx[u])) : longest;
    }
    double scale = longest > longest_step ? longest_step / longest : 1.0;
    for (int u = 0; u < p->nu; u++) {
        double to = x[u] + scale * m->dx[u], most = p->limit;
        int bound = is_bounded(&p->unknown[u]);
        m->try_x[u] = bound                      ? fmin(fmax(to, -most), most)
                      : p->unknown[u].compliance ? fmax(to, least_compliance)
                                                 : to;
    }
    *status = fit__residuals(p, m->try_x, m->try_r, &failed, err);
    return *status == STEIN_OK && failed == 0 ? fit__chi2(p, m->try_r) + fit__priors(p, m->try_x)
                                              : (double)INFINITY;
}

/* Steps with one set of derivatives. The valley of parameters that the data hardly tell apart is
 * bent: a full step along it leaves the floor, and is refused although it leads the right way. The
 * steps after it, with the same derivatives, go back down across the valley, where derivatives
 * hardly change; only where all of them have led is judged. A step costs one residual, derivatives
 * cost one for every unknown. @return 1 when the objective fell */
static int chord(fit__problem *p, fit__state *s, room *m, double *x, stein_status *status,
                 stein_err *err)
{
    double start = s->objective, last = INFINITY;
    size_t size = sizeof *x * (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    memcpy(x, s->x, size);
    for (int k = 0; k < CHORDS; k++) {
        double there = go(p, m, x, status, err);
        if (*status != STEIN_OK || !(there < far_off * start + 1e4) || (k > 1 && there > last)) {
            break;
        }
        memcpy(x, m->try_x, size);
        if (there < s->objective) {
            memcpy(s->x, x, size);
            memcpy(m->r, m->try_r, sizeof *m->r * rows);
            s->objective = there;
        }
        if (last - there < 0.05 * fabs(start - there) || fabs(start - there) < 1.0) {
            break;
        }
        last = there;
        new_gradient(m, p, x, m->try_r);
        fit__normal_step(&m->normal, p, m->dx);
    }
    return s->objective < start;
}

/* is a parameter at its bound, with a step that leads across? */
static int leaves(const fit__problem *p, int u, double x, double dx)
{
    return is_bounded(&p->unknown[u]) && !p->unknown[u].idle &&
           fabs(x) >= p->limit * (1.0 - 1e-9) && x * dx > 0.0;
}

/* The data are believed no further than they are met: with chi2 per degree of freedom far above 1
 * the residual is no noise, derivatives are off by shares of it, and what they say of numbers that
 * the data hardly tell is made up. So the priors weigh chi2/dof times as much, until there is
 * nothing but noise left. */
static void temper(const fit__problem *p, const fit__state *s, room *m)
{
    m->prior = fmax(1.0, fit__chi2_dof(p, m->r));
    for (int u = 0; u < p->nu; u++) {
        double *d = diagonal(&m->normal, p, u);
        if (d != NULL && p->unknown[u].prior && u != p->flat) {
            *d += m->prior - 1.0;
            m->normal.g[u] += (m->prior - 1.0) * s->x[u];
        }
    }
}

/* dx with damping mu in units of the priors: what the data hardly tell moves slowly, what they tell
 * well goes all the way at once. (Marquardt's scaling does the opposite, and creeps.) */
static int solve_damped(const fit__problem *p, const fit__state *s, room *m)
{
    fit__normal_fill(&m->normal, p, s->x, m->r, m->J, 1);
    temper(p, s, m);
    for (size_t i = 0; i < (size_t)m->normal.n; i++) {
        *gsl_matrix_ptr(m->normal.A, i, i) += s->mu;
    }
    if (fit__normal_factor(&m->normal, 0.0) != 0) {
        return -1;
    }
    fit__normal_step(&m->normal, p, m->dx);
    return 0;
}

/* Shares of a step, one after the other while none is better. Damping in units of the priors leaves
 * the steep directions alone, and there a stroke's events may turn the derivative within a step. */
static const double share[DAMPINGS] = {1.0, 1.0, 0.25, 0.06};

/* A damped step and its chords. Parameters at a bound that the step would cross stay there, and the
 * others are solved for without them. */
static int damped_step(fit__problem *p, fit__state *s, room *m, double *x, double part,
                       stein_status *status, stein_err *err)
{
    int held = 1, better = 0, solved = solve_damped(p, s, m);
    while (solved == 0 && held > 0) {
        held = 0;
        for (int u = 0; u < p->np; u++) {
            if (leaves(p, u, s->x[u], m->dx[u])) {
                p->unknown[u].idle = AT_BOUND;
                held++;
            }
        }
        solved = held > 0 ? solve_damped(p, s, m) : 0;
    }
    if (solved == 0) {
        for (int u = 0; u < p->nu; u++) {
            m->dx[u] *= part;
        }
        better = chord(p, s, m, x, status, err);
    }
    for (int u = 0; u < p->np; u++) {
        p->unknown[u].idle = p->unknown[u].idle == AT_BOUND ? 0 : p->unknown[u].idle;
    }
    return better;
}

/* new derivatives where the search stands, and steps for the next ones */
static stein_status renew(fit__problem *p, const fit__state *s, room *m, stein_err *err)
{
    stein_status status = fit__sensitivities(p, s->x, m->r, m->J, err);
    if (status == STEIN_OK) {
        fit__choose_steps(p, m->J);
    }
    return status;
}

/* the search of fit__descend. @param fresh  J is that of s->x */
static stein_status descend(fit__problem *p, fit__state *s, room *m, double *x, int fresh,
                            double enough, int renewals, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (; status == STEIN_OK; fresh = 1) {
        fit__normal_fill(&m->normal, p, s->x, m->r, m->J, 1);
        s->decrement = decrement(m, p);
        s->ended = s->decrement < enough;
        if (s->ended && (fresh || renewals <= 0)) {
            break;
        }
        double before = s->objective;
        int better = 0;
        for (int k = 0; !better && status == STEIN_OK && k < (renewals > 0 ? DAMPINGS : 2); k++) {
            better = damped_step(p, s, m, x, share[k], &status, err);
            s->mu = better ? 0.1 * s->mu : 30.0 * fmax(s->mu, 0.03);
        }
        s->iteration++;
        double fell = before - s->objective;
        // derivatives from elsewhere have no right to say that this is the end
        s->ended = (fresh || renewals <= 0) && (!better || fell < enough + 1e-4 * s->objective);
        if (s->ended || renewals-- <= 0) {
            s->ended = s->ended && s->decrement < 100.0 * enough + 1e-3 * s->objective;
            break;
        }
        s->mu = better ? s->mu : 0.0;
        status = status == STEIN_OK ? renew(p, s, m, err) : status;
    }
    return status;
}

stein_status fit__descend(fit__problem *p, fit__end *e, int known, double enough, int renewals,
                          stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    fit__state s = {.x = e->x};
    room m = {.r = e->r, .J = e->J, .try_r = malloc(sizeof *m.try_r * (rows + 3 * nu + 1))};
    m.dx = m.try_r + (m.try_r != NULL ? rows : 0);
    m.try_x = m.dx + (m.try_r != NULL ? nu : 0);
    stein_status status = fit__normal_make(&m.normal, p, err);
    if (status == STEIN_OK && m.try_r == NULL) {
        status = lab__no_memory(err);
    }
    status = status == STEIN_OK ? begin(p, &s, &m, err) : status;
    if (status == STEIN_OK && known) {
        fit__choose_steps(p, m.J);
    } else if (status == STEIN_OK) {
        status = renew(p, &s, &m, err);
    }
    status = status == STEIN_OK ? descend(p, &s, &m, m.try_x + nu, !known, enough, renewals, err)
                                : status;
    e->objective = s.objective;
    e->ended = s.ended;
    fit__normal_free(&m.normal);
    free(m.try_r);
    return status;
}

stein_status fit__minimise(fit__problem *p, fit__state *s, double enough, double relative,
                           int iterations, fit__checkpoint *checkpoint, void *ctx, stein_err *err)
{
    room m = {.r = NULL};
    memcpy(p->step, s->step, sizeof *p->step * (size_t)p->nu);
    stein_status status = room_make(&m, p, err);
    status = status == STEIN_OK ? begin(p, s, &m, err) : status;
    s->ended = 0;
    while (status == STEIN_OK && !s->ended) {
        status = fit__sensitivities(p, s->x, m.r, m.J, err);
        if (status != STEIN_OK) {
            break;
        }
        fit__normal_fill(&m.normal, p, s->x, m.r, m.J, 1);
        s->decrement = decrement(&m, p);
        if (s->decrement < enough * (1.0 + relative * s->objective)) {
            s->ended = 1;
            break;
        }
        double before = s->objective;
        if (s->iteration >= iterations || !iterate(p, s, &m, &status, err)) {
            break;
        }
        s->iteration++;
        // a step that brought nothing: the decrement is rounding, or the coarseness of one-sided
        // differences
        s->ended = before - s->objective <
                   (p->central ? 1.0 : 10.0) * enough * (1.0 + relative * s->objective);
        fit__choose_steps(p, m.J);
        memcpy(s->step, p->step, sizeof *s->step * (size_t)p->nu);
        if (status == STEIN_OK && checkpoint != NULL) {
            status = checkpoint(ctx, s, err);
        }
    }
    room_free(&m);
    return status;
}
