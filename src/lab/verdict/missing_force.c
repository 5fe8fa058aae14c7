/* SPDX-License-Identifier: GPL-3.0-or-later
 * missing_force.c - the force that the model lacks, on every joint, over time.
 *
 * The equations of the mechanism and its measured channels, weighted by their noise, are
 *
 *      M qdd + c(q, qd) = Q(q, qd) + F(t),        y = h(q) + e
 *
 * Inverse dynamics would differentiate y twice and read off F. Inside a contact that is hopeless:
 * 8 um of noise at a leather of 0.1 mm make 0.6 N. Here the unknown is F itself, as in a filter for
 * a latent force (Alvarez, Luengo & Lawrence 2009), and the equations are solved forwards:
 *
 *      F_j(t) = sum_k f_jk hat((t - t_k)/width)
 *      r(x + v, f) = r + J v + G f,     J = dr/dx,  G = dr/df      (force_response.c: whole
 * strokes)
 *
 * with the noise e ~ N(0, 1), the parameters and each stroke's own unknowns v under their priors,
 * and f ~ N(0, tau_j^2 K) smooth over time. v is eliminated exactly,
 *
 *      P = 1 - J (J'J + prior)^-1 J',    f | r ~ N((G'PG + Q)^-1 (-G'P r), (G'PG + Q)^-1)
 *
 * and tau is what the marginal likelihood makes of it (evidence.c). This is the smoother of inverse
 * dynamics. With full and exact measurements of q it returns M qdd + c - Q. With fewer it returns
 * their projection, and a standard deviation for the rest, also for the part of a force that other
 * parameters would imitate. All is to first order at the fit: a large force moves contacts, and
 * what refitted parameters have absorbed is visible only as far as their priors allow.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosing.h"

enum { SHOWN = 3, MOST_KNOTS = 24, FEWEST_KNOTS = 4, BETWEEN = 4 };
static const double hat_width = 8e-3; /* [s] */
static const double alike = 0.5;      /* correlation of neighbouring hats */

const char *diag__force_unit(const diag__plan *l, int joint)
{
    return l->m->bodies[joint].type == 'T' ? "N" : "N m";
}

size_t diag__size(const fit__problem *p, int stroke)
{
    return (size_t)p->stroke[stroke].nch * (size_t)p->stroke[stroke].n;
}

/* strokes that are shown, their hats, and the normal equations of everything */
typedef struct series {
    int nstroke, stroke[SHOWN], knots[SHOWN];
    double width[SHOWN];
    int n, *group; /* forces: stroke by joint by knot */
    unsigned char *tie;
    double *scale, *same;
    diag__push *push; /* [n] */
    double *memory;
} series;

/* when the string is reached, or the record ends: how fast the stroke is */
static double pace(const diag__plan *l, int stroke)
{
    size_t row = diag__frame(l->p, stroke);
    int n = l->p->stroke[stroke].n, i = 0;
    while (i + 1 < n && l->phase[row + (size_t)i] != diag__phase[diag__phase_index("string")]) {
        i++;
    }
    return l->time[row + (size_t)i];
}

static double end_of(const diag__plan *l, int stroke)
{
    size_t row = diag__frame(l->p, stroke);
    double end = 0.0;
    for (int i = 0; i < l->p->stroke[stroke].n; i++) {
        double T = l->time[row + (size_t)i];
        end = isfinite(T) ? fmax(end, T) : end;
    }
    return end;
}

/* the fastest, the slowest and the one in the middle, of those that were simulated at all */
static void choose_strokes(series *e, const diag__plan *l)
{
    int ns = l->p->nstroke, count = ns < SHOWN ? ns : SHOWN;
    for (int k = 0; k < count; k++) {
        int rank = count > 1 ? k * (ns - 1) / (count - 1) : 0;
        for (int s = 0; s < ns; s++) {
            int before = 0;
            for (int o = 0; o < ns; o++) {
                double a = pace(l, o), b = pace(l, s);
                before += a < b || (!(a > b) && o < s);
            }
            if (before == rank && end_of(l, s) > 0.0) {
                e->stroke[e->nstroke++] = s;
            }
        }
    }
}

static stein_status make_series(series *e, const diag__plan *l, stein_err *err)
{
    size_t doubles = 0;
    *e = (series){.nstroke = 0};
    choose_strokes(e, l);
    for (int k = 0; k < e->nstroke; k++) {
        double end = end_of(l, e->stroke[k]);
        double width = fmax(hat_width, end / (MOST_KNOTS - 1));
        width = fmin(width, end / (FEWEST_KNOTS - 1));
        e->knots[k] = (int)floor(end / width * (1.0 + 1e-9)) + 1;
        e->width[k] = width;
        e->n += e->knots[k] * l->njoint;
        doubles += (size_t)(e->knots[k] * l->njoint) * diag__size(l->p, e->stroke[k]);
    }
    size_t n = (size_t)e->n;
    e->group = calloc(n + 1, sizeof *e->group);
    e->tie = calloc(n + 1, 1);
    e->scale = calloc(2 * n + 1, sizeof *e->scale);
    e->same = e->scale + (e->scale != NULL ? n : 0);
    e->push = calloc(n + 1, sizeof *e->push);
    e->memory = calloc(doubles + 1, sizeof *e->memory);
    return e->group && e->tie && e->scale && e->push && e->memory ? STEIN_OK : lab__no_memory(err);
}

static void free_series(series *e)
{
    free(e->group);
    free(e->tie);
    free(e->scale);
    free(e->push);
    free(e->memory);
}

/* where the hats of a joint in a shown stroke begin */
static int first_hat(const series *e, const diag__plan *l, int k, int joint)
{
    int at = joint * e->knots[k];
    for (int b = 0; b < k; b++) {
        at += l->njoint * e->knots[b];
    }
    return at;
}

static stein_status push_series(series *e, const diag__plan *l, stein_err *err)
{
    double *at = e->memory;
    diag__push *trial = calloc((size_t)l->njoint + 1, sizeof *trial);
    if (trial == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < e->nstroke; k++) {
        for (int j = 0; j < l->njoint; j++) {
            for (int i = 0; i < e->knots[k]; i++) {
                int h = first_hat(e, l, k, j) + i;
                e->push[h] = (diag__push){.stroke = e->stroke[k],
                                          .joint = l->joint[j],
                                          .phase = -1,
                                          .limit = l->limit[j],
                                          .knot = i * e->width[k],
                                          .width = e->width[k],
                                          .column = at};
                e->group[h] = j;
                e->tie[h] = i > 0;
                at += diag__size(l->p, e->stroke[k]);
            }
        }
    }
    for (int j = 0; j < l->njoint; j++) { // an early hat finds the amplitude of its joint
        trial[j] = e->push[first_hat(e, l, 0, j) + e->knots[0] / 5];
    }
    stein_status status =
        diag__force_columns(l->p, l->x, l->r, l->phase, l->time, trial, l->njoint, err);
    for (int h = 0; h < e->n; h++) {
        e->push[h].amplitude = trial[e->group[h]].amplitude;
    }
    free(trial);
    return status == STEIN_OK
               ? diag__force_columns(l->p, l->x, l->r, l->phase, l->time, e->push, e->n, err)
               : status;
}

/* index of a nuisance of the shown strokes among all of them; k: as in fit__column */
static size_t nuisance(const series *e, const diag__plan *l, int shown, int k)
{
    size_t at = (size_t)k;
    for (int b = 0; k >= l->p->np && b < shown; b++) {
        at += (size_t)l->p->stroke[e->stroke[b]].own;
    }
    return at;
}

static int unknown_at(const series *e, const diag__plan *l, int shown, int k)
{
    return k < l->p->np ? k : l->p->stroke[e->stroke[shown]].first + k - l->p->np;
}

/* normal equations of nuisances B, d and of forces M, c, and what ties them C, of one stroke */
static void add_normal(const series *e, const diag__plan *l, int shown, gsl_matrix *B,
                       gsl_vector *d, gsl_matrix *C, diag__gauss *g)
{
    const fit__problem *p = l->p;
    int stroke = e->stroke[shown], nv = p->np + p->stroke[stroke].own;
    int size = (int)diag__size(p, stroke), from = first_hat(e, l, shown, 0);
    int to = from + l->njoint * e->knots[shown];
    const double *r = l->r + fit__offset(p, stroke);
    for (int a = 0; a < nv; a++) {
        const double *ja = l->J + fit__column(p, stroke, a);
        size_t ia = nuisance(e, l, shown, a);
        *gsl_vector_ptr(d, ia) += cblas_ddot(size, ja, 1, r, 1);
        for (int b = 0; b < nv; b++) {
            *gsl_matrix_ptr(B, ia, nuisance(e, l, shown, b)) +=
                cblas_ddot(size, ja, 1, l->J + fit__column(p, stroke, b), 1);
        }
        for (int h = from; h < to; h++) {
            *gsl_matrix_ptr(C, ia, (size_t)h) += cblas_ddot(size, ja, 1, e->push[h].column, 1);
        }
    }
    for (int h = from; h < to; h++) {
        g->c[h] -= cblas_ddot(size, e->push[h].column, 1, r, 1);
        for (int o = from; o <= h; o++) {
            double sum = cblas_ddot(size, e->push[h].column, 1, e->push[o].column, 1);
            g->M[h * e->n + o] = g->M[o * e->n + h] = sum;
        }
    }
}

/* B = L L'; C <- L^-1 C, d <- L^-1 d; M <- M - C'C, c <- c + C'd. @return what nuisances explain */
static double project(const series *e, gsl_matrix *B, gsl_vector *d, gsl_matrix *C, diag__gauss *g)
{
    size_t n = (size_t)e->n;
    double explained = 0.0;
    gsl_matrix_view M = gsl_matrix_view_array(g->M, n, n);
    gsl_vector_view c = gsl_vector_view_array(g->c, n);
    gsl_linalg_cholesky_decomp1(B);
    gsl_blas_dtrsm(CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, 1.0, B, C);
    gsl_blas_dtrsv(CblasLower, CblasNoTrans, CblasNonUnit, B, d);
    gsl_blas_dgemm(CblasTrans, CblasNoTrans, -1.0, C, C, 1.0, &M.matrix);
    gsl_blas_dgemv(CblasTrans, 1.0, C, d, 1.0, &c.vector);
    gsl_blas_ddot(d, d, &explained);
    return explained;
}

/* M, c of all hats with the nuisances of the shown strokes eliminated. @param squares  what is left
 * of the sum of squares and priors */
static stein_status prepare(const series *e, const diag__plan *l, diag__gauss *g, double *squares,
                            stein_err *err)
{
    const fit__problem *p = l->p;
    int last = e->nstroke - 1;
    size_t nv = nuisance(e, l, last, p->np + p->stroke[e->stroke[last]].own);
    gsl_matrix *B = gsl_matrix_calloc(nv, nv), *C = gsl_matrix_calloc(nv, (size_t)e->n);
    gsl_vector *d = gsl_vector_calloc(nv);
    stein_status status = B && C && d ? STEIN_OK : lab__no_memory(err);
    *squares = 0.0;
    for (int k = 0; status == STEIN_OK && k < e->nstroke; k++) {
        const double *r = l->r + fit__offset(p, e->stroke[k]);
        add_normal(e, l, k, B, d, C, g);
        int size = (int)diag__size(p, e->stroke[k]);
        *squares += cblas_ddot(size, r, 1, r, 1);
        for (int a = k == 0 ? 0 : p->np; a < p->np + p->stroke[e->stroke[k]].own; a++) {
            int u = unknown_at(e, l, k, a), prior = p->unknown[u].prior;
            size_t i = nuisance(e, l, k, a);
            *gsl_matrix_ptr(B, i, i) += prior ? 1.0 : 1e-9;
            *gsl_vector_ptr(d, i) += prior ? l->x[u] : 0.0;
            *squares += prior ? l->x[u] * l->x[u] : 0.0;
        }
    }
    if (status == STEIN_OK) {
        *squares -= project(e, B, d, C, g);
    }
    gsl_matrix_free(B);
    gsl_matrix_free(C);
    gsl_vector_free(d);
    return status;
}

/* the force of one joint in one stroke and its sd, four times as fine as the knots */
static stein_status draw(const series *e, const diag__plan *l, const diag__gauss *g, int shown,
                         int joint, double inflation, lab_latent *out, stein_err *err)
{
    int knots = e->knots[shown], n = BETWEEN * (knots - 1) + 1, at = first_hat(e, l, shown, joint);
    const fit__stroke *s = &l->p->stroke[e->stroke[shown]];
    double shift = s->data->time[0] - l->time[diag__frame(l->p, e->stroke[shown])];
    *out = (lab_latent){.joint = l->m->bodies[l->joint[joint]].name,
                        .unit = diag__force_unit(l, l->joint[joint]),
                        .file = s->data->file,
                        .n = n,
                        .t = malloc(sizeof(double) * (size_t)n),
                        .force = malloc(sizeof(double) * (size_t)n),
                        .sd = malloc(sizeof(double) * (size_t)n)};
    if (!out->t || !out->force || !out->sd) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < n; i++) {
        int a = at + i / BETWEEN, b = i + 1 < n ? a + 1 : a;
        double v = (double)(i % BETWEEN) / BETWEEN, u = 1.0 - v;
        double var = u * u * g->cov[a * g->n + a] + v * v * g->cov[b * g->n + b] +
                     2.0 * u * v * g->cov[a * g->n + b];
        out->t[i] = e->width[shown] * i / BETWEEN + (isfinite(shift) ? shift : 0.0);
        out->force[i] = u * g->mean[a] + v * g->mean[b];
        out->sd[i] = sqrt(fmax(0.0, var) * inflation);
    }
    return STEIN_OK;
}

/* scales, solution and curves */
static stein_status solve_series(series *e, const diag__plan *l, diag__gauss *g,
                                 lab_latent **latent, int *n, stein_err *err)
{
    double squares = 0.0;
    int samples = 0;
    stein_status status = prepare(e, l, g, &squares, err);
    for (int j = 0; status == STEIN_OK && j < l->njoint; j++) {
        double sum = 0.0, count = 0.0;
        for (int h = 0; h < e->n; h++) {
            sum += e->group[h] == j ? fmax(0.0, g->M[h * e->n + h]) : 0.0;
            count += e->group[h] == j;
        }
        for (int h = 0; h < e->n; h++) {
            double scale = sum > 0.0 ? sqrt(count / sum) : 1.0;
            e->scale[h] = e->group[h] == j ? scale : e->scale[h];
            e->same[h] = 1.0;
        }
    }
    g->group = e->group;
    g->tie = e->tie;
    g->rho = alike;
    g->scale = e->scale;
    g->same = e->same;
    g->wide = l->limit;
    status = status == STEIN_OK ? diag__gauss_solve(g, err) : status;
    lab_latent *list = status == STEIN_OK
                           ? realloc(*latent, sizeof *list * (size_t)(*n + e->nstroke * l->njoint))
                           : NULL;
    if (list == NULL) {
        return status == STEIN_OK ? lab__no_memory(err) : status;
    }
    *latent = list;
    for (int k = 0; k < e->nstroke; k++) {
        samples += l->p->stroke[e->stroke[k]].samples;
    }
    double inflation = fmax(1.0, (squares - g->explained) / fmax(1.0, samples));
    for (int j = 0; status == STEIN_OK && j < l->njoint; j++) {
        for (int k = 0; status == STEIN_OK && k < e->nstroke; k++) {
            status = draw(e, l, g, k, j, inflation, &list[(*n)++], err);
        }
    }
    return status;
}

static stein_status over_time(const diag__plan *l, lab_latent **latent, int *n, stein_err *err)
{
    series e;
    diag__gauss g = {.n = 0};
    stein_status status = make_series(&e, l, err);
    status = status == STEIN_OK && e.n > 0 ? push_series(&e, l, err) : status;
    status = status == STEIN_OK && e.n > 0 ? diag__gauss_make(&g, e.n, l->njoint, err) : status;
    status = status == STEIN_OK && e.n > 0 ? solve_series(&e, l, &g, latent, n, err) : status;
    free(g.M);
    free_series(&e);
    return status;
}

/* a preload as large as one may be at a joint */
static stein_status find_limits(diag__plan *l, stein_err *err)
{
    lab_candidate *list = NULL;
    int n = 0;
    stein_status status = lab_candidates(&list, &n, l->p->model, err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        for (int j = 0; j < l->njoint; j++) {
            int here = list[i].joint == l->joint[j] && strcmp(list[i].effect->kind, "preload") == 0;
            l->limit[j] = here ? list[i].limit : l->limit[j];
        }
    }
    free(list);
    return status;
}

stein_status diag__missing_force(const fit__problem *p, const double *x, const double *r,
                                 const double *J, const char *const *phase, const double *time,
                                 lab_departure **list, int *n, lab_latent **latent, int *nlatent,
                                 stein_err *err)
{
    diag__plan l = {
        .p = p, .m = lab_equations(p->model), .x = x, .r = r, .J = J, .time = time, .phase = phase};
    l.joint = calloc((size_t)l.m->nq + 1, sizeof *l.joint);
    l.limit = calloc((size_t)l.m->nq + 1, sizeof *l.limit);
    stein_status status = l.joint != NULL && l.limit != NULL ? STEIN_OK : lab__no_memory(err);
    for (int j = 0; status == STEIN_OK && j < l.m->nq; j++) {
        if (j != l.m->load.body) {
            l.limit[l.njoint] = 1.0;
            l.joint[l.njoint++] = j;
        }
    }
    status = status == STEIN_OK ? find_limits(&l, err) : status;
    if (status == STEIN_OK && l.njoint > 0) {
        status = diag__force_by_phase(&l, list, n, err);
        status = status == STEIN_OK ? over_time(&l, latent, nlatent, err) : status;
    }
    free(l.joint);
    free(l.limit);
    return status;
}
