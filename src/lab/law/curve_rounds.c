/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_rounds.c - a curve and all other unknowns, by damped Gauss-Newton steps (rounds).
 *
 * A round takes derivatives, lets the data choose the curve's prior (curve_reduce.c) and steps:
 *
 *      (H + mu diag(H)) dx = -g      H, g: normal equations of strokes and priors, the curve's
 * added
 *
 * Escapements and bounces depend on the law, so the objective has a narrow, bent valley: a
 * shortened full step needs hundreds of rounds, a damped one (Marquardt 1963) follows the valley.
 * Each stroke's own numbers bend it most. After every step they are corrected alone, with the
 * residuals there and the present derivatives, as long as the objective falls (as in variable
 * projection, Golub & Pereyra 1973). That costs one simulation; derivatives cost one per unknown.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve_fitting.h"

enum { N = CURVE_POINTS, DAMPINGS = 8, CORRECTIONS = 3, CHORDS = 3 };
static const double wanted = 0.3; /* RMS change of differences [noise] */
static const double longer =
    30.0; /* most of a difference, in the difference of the previous round */
static const double of_size = 0.3; /* most of a difference, in what the curve's values are like */
static const double little = 0.5, on_its_way = 3.0; /* gain of a round: at its end, before */
static const double worth = 0.2; /* of a chord, in the gain of the round before */
static const double less = 0.2, more = 4.0, least = 1e-4; /* damping */

/* ---- room ---- */

stein_status diag__curve_room(const fit__problem *p, diag__curve *c, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke), np = (size_t)p->np;
    c->x = calloc(nu + rows + np + 1, sizeof *c->x);
    c->r = c->x != NULL ? c->x + nu : NULL;
    c->sd = c->x != NULL ? c->r + rows : NULL;
    return c->x != NULL ? STEIN_OK : lab__no_memory(err);
}

stein_status diag__fitting_begin(diag__fitting *t, diag__curves *w, diag__curve *c, stein_err *err)
{
    const fit__problem *p = &w->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    *t = (diag__fitting){.w = w, .c = c, .worth = little};
    t->J = malloc(sizeof *t->J * (fit__columns(p) + 1));
    t->try_x = malloc(sizeof *t->try_x * (3 * nu + 2 * rows + 1));
    stein_status status = fit__normal_make(&t->n, p, err);
    if (status == STEIN_OK && (t->J == NULL || t->try_x == NULL)) {
        status = lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        diag__fitting_end(t);
        return status;
    }
    t->was_x = t->try_x + nu;
    t->dx = t->was_x + nu;
    t->try_r = t->dx + nu;
    t->was_r = t->try_r + rows;
    diag__curve_free_only(w, c->site);
    return STEIN_OK;
}

stein_status diag__fitting_begin_at(diag__fitting *t, diag__curves *w, diag__curve *c,
                                    const double *x, stein_err *err)
{
    stein_status status = diag__curve_room(&w->p, c, err);
    status = status == STEIN_OK ? diag__fitting_begin(t, w, c, err) : status;
    if (status == STEIN_OK) {
        memcpy(c->x, x, sizeof *x * (size_t)w->p.nu);
    }
    return status;
}

void diag__fitting_end(diag__fitting *t)
{
    fit__normal_free(&t->n);
    free(t->J);
    free(t->try_x);
}

void diag__curve_free_only(diag__curves *w, const diag__site *s)
{
    for (int k = w->site[0].first; k < w->p.amount; k++) {
        w->p.unknown[k].idle = k < s->first + s->pinned || k >= s->first + s->n;
    }
}

/* ---- a step ---- */

static double objective_at(const diag__fitting *t, const double *x, const double *r)
{
    double f[N];
    for (int i = 0; i < t->q.n; i++) {
        f[i] = x[t->q.index[i]];
    }
    return (fit__chi2(&t->w->p, r) + fit__priors(&t->w->p, x)) / t->c->excess +
           diag__curve_penalty(&t->q, f);
}

/* differences of the curve's values: a third of the noise */
static void choose_steps(diag__fitting *t)
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
        double step = most > 0.0 ? fmin(wanted / most, longer * p->step[k]) : p->step[k];
        p->step[k] = t->q.tau > 0.0 ? fmin(step, of_size * t->q.tau) : step;
    }
}

/* full step to the solution of the round: curve, parameters, strokes' own */
static void step_of(diag__fitting *t, const diag__reduced *q, const diag__others *o)
{
    const fit__problem *p = &t->w->p;
    memset(t->dx, 0, sizeof *t->dx * (size_t)p->nu);
    for (int i = 0; i < q->n; i++) {
        t->dx[q->index[i]] = q->f[i] - t->c->x[q->index[i]];
    }
    for (int a = 0; a < o->n; a++) {
        double sum = -gsl_vector_get(o->g, (size_t)a);
        for (int i = 0; i < q->n; i++) {
            sum -= gsl_matrix_get(o->X, (size_t)a, (size_t)i) * t->dx[q->index[i]];
        }
        t->dx[o->index[a]] = sum;
    }
    gsl_vector_view dp = gsl_vector_view_array(t->n.product, (size_t)t->n.n);
    for (int i = 0; i < t->n.n; i++) {
        gsl_vector_set(&dp.vector, (size_t)i, t->dx[t->n.moving[i]]);
    }
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

/* Diagonals of the normal equations, larger by a factor: a step is short in directions that the
 * data hardly determine. */
static void damp(diag__fitting *t, double by)
{
    for (size_t i = 0; i < (size_t)t->n.n; i++) {
        *gsl_matrix_ptr(t->n.A, i, i) *= by;
    }
    for (int s = 0; s < t->n.nstroke; s++) {
        for (size_t i = 0; t->n.B[s] != NULL && i < t->n.B[s]->size1; i++) {
            *gsl_matrix_ptr(t->n.B[s], i, i) *= by;
        }
    }
}

/* each stroke's own numbers of try_x, by the residuals try_r there: dn = -B^-1 (J'r + n) */
static void correct_own(diag__fitting *t)
{
    const fit__problem *p = &t->w->p;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *o = &p->stroke[s];
        if (t->n.B[s] == NULL) {
            continue;
        }
        double *dn = t->dx + o->first, *n = t->try_x + o->first;
        const double *r = t->try_r + fit__offset(p, s);
        for (int k = 0; k < o->own; k++) {
            const double *column = t->J + fit__column(p, s, p->np + k);
            double prior = p->unknown[o->first + k].prior ? n[k] : 0.0;
            dn[k] = -lab__dot(column, r, (size_t)o->nch * (size_t)o->n) - prior;
        }
        gsl_vector_view v = gsl_vector_view_array(dn, (size_t)o->own);
        gsl_linalg_cholesky_svx(t->n.BL[s], &v.vector);
        for (int k = 0; k < o->own; k++) {
            n[k] += dn[k];
        }
    }
}

/* try_r and the objective at try_x; INFINITY: a stroke cannot be simulated there */
static double try_there(diag__fitting *t, stein_status *status, stein_err *err)
{
    int failed = 0;
    *status = fit__residuals(&t->w->p, t->try_x, t->try_r, &failed, err);
    return *status == STEIN_OK && failed == 0 ? objective_at(t, t->try_x, t->try_r)
                                              : (double)INFINITY;
}

static void copy_point(const diag__fitting *t, double *to_x, double *to_r, const double *x,
                       const double *r)
{
    const fit__problem *p = &t->w->p;
    memcpy(to_x, x, sizeof *x * (size_t)p->nu);
    memcpy(to_r, r, sizeof *r * fit__offset(p, p->nstroke));
}

/* try_x, try_r where strokes' own numbers follow the step. @return the objective there */
static double follow_own(diag__fitting *t, double there, stein_status *status, stein_err *err)
{
    double fell = (double)INFINITY;
    for (int k = 0; k < CORRECTIONS && isfinite(there) && fell > little; k++) {
        copy_point(t, t->was_x, t->was_r, t->try_x, t->try_r);
        correct_own(t);
        double now = try_there(t, status, err);
        fell = there - now;
        if (!(fell > 0.0)) {
            copy_point(t, t->try_x, t->try_r, t->was_x, t->was_r);
            break;
        }
        there = now;
    }
    return there;
}

/* the step, damped by mu. @return 1 when the objective falls */
static int go(diag__fitting *t, double mu, stein_status *status, stein_err *err)
{
    fit__problem *p = &t->w->p;
    diag__globals g = {.S = NULL};
    diag__others o = {.n = 0};
    diag__reduced q;
    double there = (double)INFINITY;
    damp(t, 1.0 + mu);
    *status = diag__globals_of(&t->n, p, &g, err);
    if (*status == STEIN_OK) {
        *status = diag__reduce(t->w, t->c->site, &g, t->c->x, &o, &q, err);
    }
    damp(t, 1.0 / (1.0 + mu));
    if (*status == STEIN_OK) {
        diag__temper(&q, t->c->excess);
        diag__curve_solve(&t->q, &q);
        step_of(t, &q, &o);
        for (int u = 0; u < p->nu; u++) {
            t->try_x[u] = t->c->x[u] + t->dx[u];
        }
        there = try_there(t, status, err);
    }
    there = *status == STEIN_OK ? follow_own(t, there, status, err) : there;
    diag__others_free(&o);
    diag__globals_free(&g);
    if (*status != STEIN_OK || !(there < t->objective)) {
        return 0;
    }
    t->objective = there;
    copy_point(t, t->c->x, t->c->r, t->try_x, t->try_r);
    return 1;
}

/* ---- results ---- */

/* sd of the parameters, in x: own part and contribution of the curve */
static void note_sd(diag__fitting *t, const diag__others *o)
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

static void note_cov(diag__fitting *t)
{
    int n = t->c->site->n, skip = t->c->site->pinned;
    memset(t->c->cov, 0, sizeof t->c->cov);
    for (int i = 0; i < t->q.n; i++) {
        for (int j = 0; j < t->q.n; j++) {
            t->c->cov[(i + skip) * n + j + skip] = t->q.cov[i * t->q.n + j];
        }
    }
}

/* ---- rounds ---- */

/* where the curve stands */
static stein_status derive(diag__fitting *t, stein_err *err)
{
    const diag__site *s = t->c->site;
    return diag__curve_derive(&t->w->p, s->first, s->first + s->n, t->c->x, t->c->r, t->J, err);
}

/* the derivatives of a round: its own; those of the null fit; those of the round before, as chords
 * in the place of tangents: they reach less far and cost a few strokes */
typedef enum { OWN, OF_NULL, OF_LAST } derivatives;

/* one round. @return its gain, 0 when it did not go on */
static double one_round(diag__fitting *t, derivatives by, stein_status *status, stein_err *err)
{
    fit__problem *p = &t->w->p;
    diag__globals g = {.S = NULL};
    diag__others o = {.n = 0};
    double before = t->objective;
    int better = 0;
    if (by == OF_NULL) {
        memcpy(t->J, t->w->J, sizeof *t->J * fit__columns(p));
    } else if (by == OWN) {
        *status = derive(t, err);
    }
    if (*status == STEIN_OK && by != OF_LAST) {
        *status = diag__same_as_curve(t->w, t->c->site, t->c->x, t->J, err);
    }
    if (*status == STEIN_OK) {
        fit__normal_fill(&t->n, p, t->c->x, t->c->r, t->J, 1);
        *status = diag__globals_of(&t->n, p, &g, err);
    }
    if (*status == STEIN_OK) {
        *status = diag__reduce(t->w, t->c->site, &g, t->c->x, &o, &t->q, err);
    }
    if (*status == STEIN_OK) {
        t->c->excess = diag__curve_choose_noise(t->w, t->c->site, t->c->x, t->c->r, &t->q);
        if (!p->central && by != OF_LAST) { // central ones are long already
            choose_steps(t);
        }
        before = t->objective = objective_at(t, t->c->x, t->c->r);
        double damping = t->damping;
        for (int k = 0; k < (by == OF_LAST ? 1 : DAMPINGS) && *status == STEIN_OK && !better; k++) {
            better = go(t, t->damping, status, err);
            t->damping =
                better ? (k == 0 ? less : 1.0) * t->damping : more * fmax(t->damping, least);
        }
        t->damping = by == OF_LAST ? damping : t->damping; // of tangents
        if (!(p->gain > 0.0)) {
            diag__curve_spread(t->c->site, &t->q);
            note_sd(t, &o);
            note_cov(t);
        }
    }
    diag__others_free(&o);
    diag__globals_free(&g);
    return better ? before - t->objective : 0.0;
}

stein_status diag__rounds(diag__fitting *t, double gain_of_observer, int rounds, int known,
                          stein_err *err)
{
    fit__problem *p = &t->w->p;
    stein_status status = STEIN_OK;
    int failed = 0;
    double least_gain = gain_of_observer > 0.0 ? on_its_way : t->worth;
    p->gain = gain_of_observer;
    if (!known) {
        status = fit__residuals(p, t->c->x, t->c->r, &failed, err);
    }
    if (status == STEIN_OK && failed > 0) {
        status = lab__fail(err, STEIN_ENONFINITE, "%d records cannot be simulated", failed);
    }
    for (int k = 0; status == STEIN_OK && k < rounds; k++) {
        int first = known && k == 0;
        double gain = one_round(t, first ? OF_NULL : OWN, &status, err);
        if (k > 0 && status != STEIN_OK) { // x is from the last round
            status = fit__forgive(status, err);
            break;
        }
        if (!(gain > least_gain) && !first) {
            break;
        }
        for (int i = 0; i < CHORDS && status == STEIN_OK && gain > least_gain && k + 1 < rounds;
             i++) {
            double last = gain;
            gain = one_round(t, OF_LAST, &status, err);
            gain = gain > worth * last ? gain : 0.0;
        }
    }
    p->gain = 0.0;
    return status;
}

void diag__fitting_weigh(diag__fitting *t, stein_status end)
{
    diag__curve *c = t->c;
    double f[N];
    c->fitted = end == STEIN_OK;
    c->gain = -(double)INFINITY;
    c->price = 0.0;
    if (c->fitted) {
        for (int i = 0; i < t->q.n; i++) {
            f[i] = c->x[t->q.index[i]];
        }
        t->objective = objective_at(t, c->x, c->r);
        c->price = diag__curve_penalty(&t->q, f) + t->q.logdet;
        c->gain = t->w->objective / c->excess - t->objective - t->q.logdet;
    }
}
