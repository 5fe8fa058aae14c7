/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_fit.c - an unknown law and all other unknowns, by penalised least squares.
 *
 * The curve is a table of the extended mechanism, its values f are parameters, so a stroke with a
 * law in it is simulated as any other and the law acts through all contacts and events. With v all
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
 * and tau, length and kind are those of the largest marginal likelihood (Rasmussen & Williams 2006,
 * ch. 5). That prior knows no favourite shape: constant, straight, wavy as the data want, and it
 * prices a curve by what its freedom would have let it fit, so places and states of different units
 * compare. Each round linearises anew at the present curve (Gauss-Newton).
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { N = CURVE_POINTS, ROUNDS = 5, HALVINGS = 6 };
static const double wanted = 0.3; /* RMS change of differences [noise] */
static const double little = 0.5; /* gain of a round */

/* ---- eliminating everything else ---- */

/* normal equations without the strokes' own unknowns */
typedef struct globals {
    gsl_matrix *S;
    gsl_vector *g;
} globals;

static stein_status take_globals(fit__normal *n, const fit__problem *p, globals *o, stein_err *err)
{
    size_t np = (size_t)p->np;
    o->S = gsl_matrix_alloc(np, np);
    o->g = gsl_vector_alloc(np);
    if (o->S == NULL || o->g == NULL) {
        return lab__no_memory(err);
    }
    if (fit__normal_factor(n, p, 0.0) != 0) {
        gsl_matrix_set_identity(n->S); // the factors of the strokes are what is wanted
    }
    gsl_matrix_memcpy(o->S, n->A);
    for (size_t i = 0; i < np; i++) {
        gsl_vector_set(o->g, i, n->g[i]);
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

static void free_globals(globals *o)
{
    gsl_matrix_free(o->S);
    gsl_vector_free(o->g);
}

/* unknowns that are neither of the curve nor of another one */
static int is_other(const diag__curves *w, int k)
{
    return k < w->site[0].first || k >= w->p.amount;
}

/* the step of the parameters for a change of the curve, and what is known of them */
typedef struct others {
    int n, *index;
    gsl_matrix *F; /* Cholesky factor of S_pp */
    gsl_matrix *X; /* S_pp^-1 S_pf */
    gsl_vector *g; /* S_pp^-1 g_p */
} others;

static void free_others(others *o)
{
    free(o->index);
    gsl_matrix_free(o->F);
    gsl_matrix_free(o->X);
    gsl_vector_free(o->g);
}

/* M, c of a curve at f_now = x */
static stein_status reduce(const diag__curves *w, const diag__site *s, const globals *o,
                           const double *x, others *t, diag__reduced *q, stein_err *err)
{
    const fit__problem *p = &w->p;
    *t = (others){.index = malloc(sizeof(int) * (size_t)(p->np + 1))};
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
        size_t i = (size_t)t->index[a];
        for (size_t b = 0; b < m; b++) {
            gsl_matrix_set(t->F, a, b, gsl_matrix_get(o->S, i, (size_t)t->index[b]));
        }
        for (size_t b = 0; b < n; b++) {
            gsl_matrix_set(t->X, a, b, gsl_matrix_get(o->S, i, (size_t)q->index[b]));
        }
        *gsl_matrix_ptr(t->F, a, a) += 1e-12;
        gsl_vector_set(t->g, a, gsl_vector_get(o->g, i));
    }
    if (m == 0) {
        gsl_matrix_set(t->F, 0, 0, 1.0);
    }
    if (gsl_linalg_cholesky_decomp1(t->F) != 0) {
        return lab__fail(err, STEIN_ESINGULAR, "the data do not tell the free numbers apart");
    }
    for (size_t b = 0; b < n; b++) {
        gsl_vector_view column = gsl_matrix_column(t->X, b);
        gsl_linalg_cholesky_svx(t->F, &column.vector);
    }
    gsl_linalg_cholesky_svx(t->F, t->g);
    for (int a = 0; a < q->n; a++) {
        size_t i = (size_t)q->index[a];
        double c = -gsl_vector_get(o->g, i);
        for (int b = 0; b < q->n; b++) {
            double sum = gsl_matrix_get(o->S, i, (size_t)q->index[b]);
            for (size_t k = 0; k < m; k++) {
                sum -= gsl_matrix_get(o->S, i, (size_t)t->index[k]) *
                       gsl_matrix_get(t->X, k, (size_t)b);
            }
            q->M[a * q->n + b] = sum;
        }
        for (size_t k = 0; k < m; k++) {
            c += gsl_matrix_get(o->S, i, (size_t)t->index[k]) * gsl_vector_get(t->g, k);
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

/* ---- noise that nobody stated ---- */

static double excess_of(const fit__problem *p, const double *r)
{
    return fit__noise_given(p) ? 1.0
                               : fmax(1.0, fit__chi2_dof(p, r)) * fmax(1.0, fit__inflation(p, r));
}

static void temper(diag__reduced *q, double excess)
{
    for (int i = 0; i < q->n; i++) {
        q->c[i] /= excess;
        for (int j = 0; j < q->n; j++) {
            q->M[i * q->n + j] /= excess;
        }
    }
}

/* ---- to first order ---- */

stein_status diag__curve_scores(const diag__curves *w, diag__curve *c, stein_err *err)
{
    fit__normal n;
    globals o = {NULL, NULL};
    double excess = excess_of(&w->p, w->r);
    stein_status status = fit__normal_make(&n, &w->p, err);
    if (status == STEIN_OK) {
        fit__normal_fill(&n, &w->p, w->x, w->r, w->J, 1);
        status = take_globals(&n, &w->p, &o, err);
    }
    for (int i = 0; status == STEIN_OK && i < w->nsite; i++) {
        others t;
        diag__reduced q;
        c[i] = (diag__curve){.site = &w->site[i], .gain = -INFINITY, .held = NAN, .excess = excess};
        status = reduce(w, &w->site[i], &o, w->x, &t, &q, err);
        if (status == STEIN_OK) {
            temper(&q, excess);
            diag__curve_choose(&w->site[i], &q);
            c[i].gain = q.gained;
        }
        free_others(&t);
    }
    fit__normal_free(&n);
    free_globals(&o);
    return status;
}

/* ---- in rounds ---- */

/* everything of one fit */
typedef struct fitting {
    diag__curves *w;
    diag__curve *c;
    fit__normal n;
    diag__reduced q;
    double *J, *try_x, *try_r, *dx, objective;
} fitting;

static double objective_at(const fitting *t, const double *x, const double *r)
{
    double f[N];
    for (int i = 0; i < t->q.n; i++) {
        f[i] = x[t->q.index[i]];
    }
    return (fit__chi2(&t->w->p, r) + fit__priors(&t->w->p, x)) / t->c->excess +
           diag__curve_penalty(&t->q, f);
}

/* differences of the curve's values: a third of the noise */
static void choose_steps(fitting *t)
{
    fit__problem *p = &t->w->p;
    for (int i = 0; i < t->q.n; i++) {
        int k = t->q.index[i];
        double most = 0.0;
        for (int s = 0; s < p->nstroke; s++) {
            const fit__stroke *o = &p->stroke[s];
            const double *column = t->J + fit__column(p, s, k);
            double norm = cblas_dnrm2(o->nch * o->n, column, 1);
            most = fmax(most, norm / sqrt(fmax(1.0, o->samples)));
        }
        p->step[k] = most > 0.0 ? fmin(wanted / most, 30.0 * p->step[k]) : p->step[k];
    }
}

/* full step to the solution of the round: curve, parameters, strokes' own */
static void step_of(fitting *t, const others *o)
{
    const fit__problem *p = &t->w->p;
    memset(t->dx, 0, sizeof *t->dx * (size_t)p->nu);
    for (int i = 0; i < t->q.n; i++) {
        t->dx[t->q.index[i]] = t->q.f[i] - t->c->x[t->q.index[i]];
    }
    for (int a = 0; a < o->n; a++) {
        double sum = -gsl_vector_get(o->g, (size_t)a);
        for (int i = 0; i < t->q.n; i++) {
            sum -= gsl_matrix_get(o->X, (size_t)a, (size_t)i) * t->dx[t->q.index[i]];
        }
        t->dx[o->index[a]] = sum;
    }
    gsl_vector_const_view dp = gsl_vector_const_view_array(t->dx, (size_t)p->np);
    for (int s = 0; s < p->nstroke; s++) {
        if (t->n.B[s] != NULL) {
            int first = p->stroke[s].first;
            gsl_vector_view dn = gsl_vector_view_array(t->dx + first, (size_t)p->stroke[s].own);
            for (int k = 0; k < p->stroke[s].own; k++) {
                t->dx[first + k] = -t->n.g[first + k];
            }
            gsl_linalg_cholesky_svx(t->n.BL[s], &dn.vector);
            gsl_blas_dgemv(CblasNoTrans, -1.0, t->n.X[s], &dp.vector, 1.0, &dn.vector);
        }
    }
}

/* along the step as far as it is better. @return 1 when it is */
static int go(fitting *t, stein_status *status, stein_err *err)
{
    fit__problem *p = &t->w->p;
    double share = 1.0;
    for (int k = 0; k < HALVINGS; k++, share *= 0.5) {
        int failed = 0;
        for (int u = 0; u < p->nu; u++) {
            t->try_x[u] = t->c->x[u] + share * t->dx[u];
        }
        *status = fit__residuals(p, t->try_x, t->try_r, &failed, err);
        if (*status != STEIN_OK) {
            return 0;
        }
        double there = failed ? (double)INFINITY : objective_at(t, t->try_x, t->try_r);
        if (there < t->objective) {
            t->objective = there;
            memcpy(t->c->x, t->try_x, sizeof *t->c->x * (size_t)p->nu);
            memcpy(t->c->r, t->try_r, sizeof *t->c->r * fit__offset(p, p->nstroke));
            return 1;
        }
    }
    return 0;
}

/* sd of the parameters, in x: what they have by themselves and what the curve adds */
static void note_sd(fitting *t, const others *o)
{
    gsl_vector *e = gsl_vector_alloc((size_t)(o->n > 0 ? o->n : 1));
    for (int a = 0; e != NULL && a < o->n; a++) {
        double var, sum = 0.0;
        gsl_vector_set_basis(e, (size_t)a);
        gsl_linalg_cholesky_svx(o->F, e);
        var = gsl_vector_get(e, (size_t)a) * t->c->excess;
        for (int i = 0; i < t->q.n; i++) {
            for (int j = 0; j < t->q.n; j++) {
                sum += gsl_matrix_get(o->X, (size_t)a, (size_t)i) * t->q.cov[i * t->q.n + j] *
                       gsl_matrix_get(o->X, (size_t)a, (size_t)j);
            }
        }
        t->c->sd[o->index[a]] = sqrt(fmax(0.0, var + sum));
    }
    gsl_vector_free(e);
}

static void note_cov(fitting *t)
{
    int n = t->c->site->n, skip = t->c->site->pinned;
    memset(t->c->cov, 0, sizeof t->c->cov);
    for (int i = 0; i < t->q.n; i++) {
        for (int j = 0; j < t->q.n; j++) {
            t->c->cov[(i + skip) * n + j + skip] = t->q.cov[i * t->q.n + j];
        }
    }
}

/* one round. @param first  1: derivatives of the null fit serve. @return 1 when it went on */
static int one_round(fitting *t, int first, stein_status *status, stein_err *err)
{
    fit__problem *p = &t->w->p;
    globals g = {NULL, NULL};
    others o = {.n = 0};
    double before = t->objective;
    int better = 0;
    if (first) {
        memcpy(t->J, t->w->J, sizeof *t->J * fit__columns(p));
    } else {
        *status = fit__sensitivities(p, t->c->x, t->c->r, t->J, err);
    }
    if (*status == STEIN_OK) {
        fit__normal_fill(&t->n, p, t->c->x, t->c->r, t->J, 1);
        *status = take_globals(&t->n, p, &g, err);
    }
    if (*status == STEIN_OK) {
        *status = reduce(t->w, t->c->site, &g, t->c->x, &o, &t->q, err);
    }
    if (*status == STEIN_OK) {
        t->c->excess = excess_of(p, t->c->r);
        temper(&t->q, t->c->excess);
        diag__curve_choose(t->c->site, &t->q);
        choose_steps(t);
        step_of(t, &o);
        before = t->objective = objective_at(t, t->c->x, t->c->r);
        better = go(t, status, err);
        note_sd(t, &o);
        note_cov(t);
    }
    free_others(&o);
    free_globals(&g);
    return better && before - t->objective > little;
}

/* x of zeros: the file's own numbers */
static stein_status curve_room(const fit__problem *p, diag__curve *c, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke), np = (size_t)p->np;
    c->x = calloc(nu + rows + np + 1, sizeof *c->x);
    c->r = c->x != NULL ? c->x + nu : NULL;
    c->sd = c->x != NULL ? c->r + rows : NULL;
    return c->x != NULL ? STEIN_OK : lab__no_memory(err);
}

static stein_status make_room(fitting *t, stein_err *err)
{
    const fit__problem *p = &t->w->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    t->J = malloc(sizeof *t->J * (fit__columns(p) + 1));
    t->try_x = malloc(sizeof *t->try_x * (2 * nu + rows + 1));
    t->dx = t->try_x != NULL ? t->try_x + nu : NULL;
    t->try_r = t->try_x != NULL ? t->dx + nu : NULL;
    stein_status status = fit__normal_make(&t->n, p, err);
    if (status == STEIN_OK && (t->J == NULL || t->try_x == NULL)) {
        status = lab__no_memory(err);
    }
    return status;
}

static void weigh(fitting *t)
{
    diag__curve *c = t->c;
    double f[N];
    for (int i = 0; i < t->q.n; i++) {
        f[i] = c->x[t->q.index[i]];
    }
    c->price = c->fitted ? diag__curve_penalty(&t->q, f) + t->q.logdet : 0.0;
    c->gain =
        c->fitted ? t->w->objective / c->excess - t->objective - t->q.logdet : -(double)INFINITY;
}

/* rounds over the samples up to a horizon. @return how it ended */
static stein_status rounds_to(fitting *t, double horizon, int rounds, int known, stein_err *err)
{
    fit__problem *p = &t->w->p;
    stein_status status = STEIN_OK;
    int failed = 0;
    p->horizon = horizon;
    if (!known) {
        status = fit__residuals(p, t->c->x, t->c->r, &failed, err);
    }
    if (status == STEIN_OK && failed > 0) {
        status = lab__fail(err, STEIN_ENONFINITE, "%d strokes cannot be simulated", failed);
    }
    for (int k = 0; status == STEIN_OK && k < rounds; k++) {
        int first = known && k == 0;
        if (!one_round(t, first, &status, err) && !first) {
            break;
        }
    }
    p->horizon = INFINITY;
    return status;
}

/* only this curve moves */
static void free_only(diag__curves *w, const diag__site *s)
{
    for (int k = w->site[0].first; k < w->p.amount; k++) {
        w->p.unknown[k].idle = k < s->first + s->pinned || k >= s->first + s->n;
    }
}

/* from c->x on. @param anew  1: along the strokes, over growing horizons */
static stein_status fit(diag__curves *w, diag__curve *c, int anew, stein_err *err)
{
    static const double share[] = {0.25, 0.4, 0.65};
    fitting t = {.w = w, .c = c};
    stein_err why = {STEIN_OK, ""};
    stein_status status = make_room(&t, err), end = STEIN_OK;
    free_only(w, c->site);
    double T = diag__longest(&w->p);
    for (size_t k = 0; status == STEIN_OK && anew && k < sizeof share / sizeof *share; k++) {
        end = end == STEIN_OK ? rounds_to(&t, share[k] * T, 2, 0, &why) : end;
    }
    if (status == STEIN_OK && end == STEIN_OK) {
        end = rounds_to(&t, INFINITY, ROUNDS, !anew, &why);
    }
    c->fitted = status == STEIN_OK && end == STEIN_OK;
    weigh(&t);
    fit__normal_free(&t.n);
    free(t.J);
    free(t.try_x);
    return end == STEIN_ENOMEM ? lab__no_memory(err) : status;
}

stein_status diag__curve_fit(diag__curves *w, diag__curve *c, stein_err *err)
{
    stein_status status = curve_room(&w->p, c, err);
    if (status == STEIN_OK) {
        memcpy(c->x, w->x, sizeof *c->x * (size_t)w->p.nu);
        memcpy(c->r, w->r, sizeof *c->r * fit__offset(&w->p, w->p.nstroke));
        status = fit(w, c, 0, err);
    }
    return status;
}

stein_status diag__curve_anew(diag__curves *w, diag__curve *c, stein_err *err)
{
    diag__curve other = {.site = c->site, .held = NAN};
    if (!c->fitted) {
        return STEIN_OK;
    }
    stein_status status = curve_room(&w->p, &other, err);
    status = status == STEIN_OK ? fit(w, &other, 1, err) : status;
    if (status == STEIN_OK && other.gain > c->gain) {
        free(c->x);
        *c = other;
    } else {
        free(other.x);
    }
    return status;
}

/* rounds without the strays, for strays.c */
static stein_status others_fitted(void *ctx, fit__end *e, stein_err *err)
{
    fitting *t = ctx;
    (void)e; // its x and r are those of the curve
    return rounds_to(t, INFINITY, ROUNDS, 0, err);
}

/* the strays of a fit called back, if there are any, then all together */
static stein_status recall(diag *d, diag__curves *w, diag__curve *c, stein_err *err)
{
    int found = 0;
    fitting t = {.w = w, .c = c};
    diag in_tables = *d;
    in_tables.fit_def = w->def;
    fit__end e = {.x = c->x, .r = c->r};
    diag__fitter f = {.d = &in_tables, .p = &w->p, .D = d->null_D, .fit = others_fitted, .ctx = &t};
    stein_status status = make_room(&t, err);
    e.J = t.J;
    free_only(w, c->site);
    status = status == STEIN_OK ? diag__recall_by(&f, &e, 0, &found, err) : status;
    if (status == STEIN_OK) {
        status = rounds_to(&t, INFINITY, ROUNDS, 0, err);
        c->fitted = status == STEIN_OK;
        weigh(&t);
    }
    d->out->fits += e.fits;
    fit__normal_free(&t.n);
    free(t.J);
    free(t.try_x);
    return status;
}

stein_status diag__curve_recall(diag *d, diag__curves *w, diag__curve *c, int *better,
                                stein_err *err)
{
    const fit__problem *p = &w->p;
    size_t size = (size_t)p->nu + fit__offset(p, p->nstroke) + (size_t)p->np;
    diag__curve other = *c;
    stein_err why = {STEIN_OK, ""};
    stein_status status = curve_room(p, &other, err);
    *better = 0;
    if (status != STEIN_OK) {
        return status;
    }
    memcpy(other.x, c->x, sizeof *c->x * size);
    status = recall(d, w, &other, &why);
    *better = status == STEIN_OK && other.gain > c->gain + little;
    free(*better ? c->x : other.x);
    *c = *better ? other : *c;
    return fit__forgive(status, err);
}
