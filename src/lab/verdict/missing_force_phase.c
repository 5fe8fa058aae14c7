/* SPDX-License-Identifier: GPL-3.0-or-later
 * missing_force_phase.c - the force that the model lacks, joint by phase, over all strokes.
 *
 * As in missing_force.c, with f constant in one phase of all strokes. Each stroke has its own
 * unknowns and its own deviation of every one of these forces, with variances from the strokes
 * themselves (mixed.h),
 *
 *      r_s = J_s v + G_s (f + f_s) + Z_s u_s + e,      f_s ~ N(0, D),  u_s under its priors
 *
 * so that one odd stroke is no force. Significance is that of Student's t with one degree of
 * freedom less than strokes, as a normal deviate.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosing.h"
#include "mixed.h"

enum { FEWEST_FRAMES = 3, ROUNDS = 12, MOST_RANDOM = 512 };
static const double flat_scale = 1e3; /* of unknowns without prior, in their sd */
static const double wide = 30.0;      /* prior of a force before tau is known [sd of the data] */
static const double largest_z = 37.0;

/* joint by phase, and what each stroke's pushes do */
typedef struct table {
    int n;
    int *joint, *phase; /* [n] joint: index into plan */
    diag__push *push;   /* [nstroke*n] */
    double *scale;      /* [n] force that changes the data by one sd */
    double *memory;
} table;

static int frames_in(const diag__plan *l, int stroke, int phase)
{
    size_t row = diag__frame(l->p, stroke);
    int n = 0;
    for (int i = 0; i < l->p->stroke[stroke].n; i++) {
        n += l->phase[row + (size_t)i] == diag__phase[phase] && l->time[row + (size_t)i] > 0.0 &&
             isfinite(l->time[row + (size_t)i]);
    }
    return n;
}

static void free_table(table *t)
{
    free(t->joint);
    free(t->phase);
    free(t->push);
    free(t->scale);
    free(t->memory);
}

static stein_status make_table(table *t, const diag__plan *l, stein_err *err)
{
    size_t most = (size_t)l->njoint * DIAG_PHASES, ns = (size_t)l->p->nstroke;
    *t = (table){.joint = calloc(most + 1, sizeof *t->joint),
                 .phase = calloc(most + 1, sizeof *t->phase),
                 .push = calloc(most * ns + 1, sizeof *t->push),
                 .scale = calloc(most + 1, sizeof *t->scale)};
    if (!t->joint || !t->phase || !t->push || !t->scale) {
        return lab__no_memory(err);
    }
    for (int j = 0; j < l->njoint; j++) {
        for (int f = 0; f < DIAG_PHASES; f++) {
            int frames = 0;
            for (int s = 0; s < l->p->nstroke; s++) {
                frames += frames_in(l, s, f);
            }
            if (frames >= FEWEST_FRAMES * l->p->nstroke) {
                t->joint[t->n] = j;
                t->phase[t->n++] = f;
            }
        }
    }
    t->memory = calloc((size_t)t->n * fit__offset(l->p, l->p->nstroke) + 1, sizeof *t->memory);
    return t->memory != NULL ? STEIN_OK : lab__no_memory(err);
}

/* all pushes; one stroke finds the amplitudes */
static stein_status push_table(table *t, const diag__plan *l, stein_err *err)
{
    int ns = l->p->nstroke, first = ns / 2;
    double *at = t->memory;
    for (int s = 0; s < ns; s++) {
        for (int k = 0; k < t->n; k++) {
            t->push[s * t->n + k] = (diag__push){.stroke = s,
                                                 .joint = l->joint[t->joint[k]],
                                                 .phase = t->phase[k],
                                                 .limit = l->limit[t->joint[k]],
                                                 .column = at};
            at += diag__size(l->p, s);
        }
    }
    stein_status status =
        diag__force_columns(l->p, l->x, l->r, l->phase, l->time, t->push + first * t->n, t->n, err);
    for (int s = 0; s < ns; s++) {
        for (int k = 0; k < t->n; k++) {
            t->push[s * t->n + k].amplitude = t->push[first * t->n + k].amplitude;
        }
    }
    // the strokes before and behind it
    if (status == STEIN_OK && first > 0) {
        status =
            diag__force_columns(l->p, l->x, l->r, l->phase, l->time, t->push, first * t->n, err);
    }
    if (status == STEIN_OK && first + 1 < ns) {
        status = diag__force_columns(l->p, l->x, l->r, l->phase, l->time,
                                     t->push + (first + 1) * t->n, (ns - first - 1) * t->n, err);
    }
    for (int k = 0; k < t->n; k++) {
        double sum = 0.0;
        for (int s = 0; s < ns; s++) {
            double norm = cblas_dnrm2((int)diag__size(l->p, s), t->push[s * t->n + k].column, 1);
            sum += norm * norm;
        }
        t->scale[k] = sum > 0.0 ? 1.0 / sqrt(sum) : 0.0;
    }
    return status;
}

/* columns of one stroke for the mixed model: F, G, r0, Z */
static void fill_columns(const table *t, const diag__plan *l, int stroke, int nz, double *C)
{
    const fit__problem *p = l->p;
    const fit__stroke *s = &p->stroke[stroke];
    size_t n = diag__size(p, stroke), np = (size_t)p->np, nc = (size_t)t->n;
    double *r = C + (np + nc) * n, *Z = r + n;
    memset(C, 0, sizeof *C * (np + nc + 1 + (size_t)nz) * n);
    memcpy(r, l->r + fit__offset(p, stroke), sizeof *r * n);
    for (int k = 0; k < p->np + s->own; k++) {
        const double *column = l->J + fit__column(p, stroke, k);
        int u = k < p->np ? k : s->first + k - p->np;
        double *to = k < p->np ? C + (size_t)k * n : Z + (size_t)(k - p->np) * n;
        double scale = p->unknown[u].prior ? 1.0 : flat_scale;
        for (size_t i = 0; i < n; i++) {
            to[i] = scale * column[i];
            r[i] -= p->unknown[u].prior ? column[i] * l->x[u] : 0.0;
        }
    }
    for (int k = 0; k < t->n; k++) {
        const double *column = t->push[stroke * t->n + k].column;
        double *fixed = C + (np + (size_t)k) * n, *own = Z + (size_t)(nz - t->n + k) * n;
        for (size_t i = 0; i < n; i++) {
            fixed[i] = own[i] = -wide * t->scale[k] * column[i];
        }
    }
}

static stein_status fill_mixed(lab__mixed *m, const table *t, const diag__plan *l, stein_err *err)
{
    const fit__problem *p = l->p;
    int own = 0, zclass[MOST_RANDOM], with = t->n;
    lab__scatter scatter[LAB_SCATTERS];
    for (int s = 0; s < p->nstroke; s++) {
        own = p->stroke[s].own > own ? p->stroke[s].own : own;
    }
    int nclass = l->njoint < LAB_SCATTERS ? l->njoint : LAB_SCATTERS, nz = own + with;
    if (nz > MOST_RANDOM) {
        return lab__fail(err, STEIN_EINVAL, "too many joints");
    }
    for (int k = 0; k < nz; k++) {
        zclass[k] = k < own ? -1 : t->joint[k - own] % nclass;
    }
    for (int c = 0; c < nclass; c++) {
        scatter[c] = (lab__scatter){1e-4, 10.0};
    }
    stein_status status =
        lab__mixed_make(m, p->nstroke, p->np, with, nz, zclass, NULL, scatter, nclass, err);
    double *C = malloc(sizeof *C * (size_t)(p->np + with + 1 + nz) * (size_t)p->rows + 1);
    if (status == STEIN_OK && C == NULL) {
        status = lab__no_memory(err);
    }
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        fill_columns(t, l, s, nz, C);
        lab__mixed_stroke(m, s, (int)diag__size(p, s), C);
    }
    free(C);
    return status;
}

/* M, c of the forces from A = C'V^-1 C, the free parameters eliminated; units of wide * scale */
static stein_status eliminate(const lab__mixed *m, double *M, double *c, stein_err *err)
{
    size_t nf = (size_t)m->nf, nc = (size_t)m->nc, n = (size_t)m->ncol;
    gsl_matrix *S = gsl_matrix_alloc(nf, nf), *T = gsl_matrix_alloc(nf, nc + 1);
    stein_status status = S != NULL && T != NULL ? STEIN_OK : lab__no_memory(err);
    gsl_matrix_const_view A = gsl_matrix_const_view_array(m->A, n, n);
    if (status == STEIN_OK) {
        gsl_matrix_const_view F = gsl_matrix_const_submatrix(&A.matrix, 0, 0, nf, nf);
        gsl_matrix_const_view G = gsl_matrix_const_submatrix(&A.matrix, 0, nf, nf, nc + 1);
        gsl_matrix_memcpy(S, &F.matrix);
        gsl_matrix_memcpy(T, &G.matrix);
        for (size_t i = 0; i < nf; i++) {
            *gsl_matrix_ptr(S, i, i) += 1.0;
        }
        gsl_linalg_cholesky_decomp1(S);
        gsl_blas_dtrsm(CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, 1.0, S, T);
        for (size_t a = 0; a < nc; a++) {
            for (size_t b = 0; b <= nc; b++) {
                double sum = gsl_matrix_get(&A.matrix, nf + a, nf + b);
                for (size_t i = 0; i < nf; i++) {
                    sum -= gsl_matrix_get(T, i, a) * gsl_matrix_get(T, i, b);
                }
                *(b < nc ? &M[a * nc + b] : &c[a]) = sum;
            }
        }
    }
    gsl_matrix_free(S);
    gsl_matrix_free(T);
    return status;
}

/* Student's t as a normal deviate */
static double deviate(double t, int nu)
{
    double p = gsl_cdf_tdist_Q(fabs(t), nu > 0 ? nu : 1);
    double z = p > 0.0 ? fmin(largest_z, gsl_cdf_ugaussian_Qinv(p)) : largest_z;
    return fmax(0.0, z);
}

static stein_status add_rows(const table *t, const diag__plan *l, const diag__gauss *g,
                             lab_departure **list, int *n, stein_err *err)
{
    lab_departure *more = realloc(*list, sizeof *more * (size_t)(*n + t->n + 1));
    if (more == NULL) {
        return lab__no_memory(err);
    }
    *list = more;
    for (int k = 0; k < t->n; k++) {
        int samples = 0, joint = l->joint[t->joint[k]];
        for (int s = 0; s < l->p->nstroke; s++) {
            samples += frames_in(l, s, t->phase[k]);
        }
        double unit = wide * t->scale[k], sd = sqrt(g->cov[k * t->n + k]);
        int known = t->scale[k] > 0.0 && sd > 0.0;
        more[(*n)++] =
            (lab_departure){.place = l->m->bodies[joint].name,
                            .unit = diag__force_unit(l, joint),
                            .is_force = 1,
                            .phase = diag__phase[t->phase[k]],
                            .samples = samples,
                            .size = known ? unit * g->mean[k] : (double)NAN,
                            .sd = known ? unit * sd : (double)NAN,
                            .z = known ? deviate(g->mean[k] / sd, l->p->nstroke - 1) : (double)NAN,
                            .lag1 = NAN};
    }
    return STEIN_OK;
}

/* scatter of the strokes, then forces */
static stein_status solve_table(const table *t, const diag__plan *l, lab__mixed *m, diag__gauss *g,
                                stein_err *err)
{
    size_t k = (size_t)t->n;
    double *beta = calloc(k + (size_t)l->p->np + 2 * k + 1, sizeof *beta);
    int *with = calloc(k + 1, sizeof *with);
    unsigned char *tie = calloc(k + 1, 1);
    stein_status status =
        beta != NULL && with != NULL && tie != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) {
        double *scale = beta + k + l->p->np, *same = scale + k;
        for (int i = 0; i < t->n; i++) {
            with[i] = i;
            scale[i] = 1.0 / wide;
            same[i] = t->scale[i] > 0.0 ? 1.0 / (wide * t->scale[i]) : 0.0;
        }
        g->group = t->joint;
        g->scale = scale;
        g->same = same;
        g->wide = l->limit;
        g->tie = tie;
        lab__mixed_scatter(m, with, t->n, ROUNDS, beta, NULL);
        status = eliminate(m, g->M, g->c, err);
        status = status == STEIN_OK ? diag__gauss_solve(g, err) : status;
        g->scale = g->same = NULL;
        g->tie = NULL;
    }
    free(beta);
    free(with);
    free(tie);
    return status;
}

stein_status diag__force_by_phase(const diag__plan *l, lab_departure **list, int *n, stein_err *err)
{
    table t;
    lab__mixed m = {.nf = 0};
    diag__gauss g = {.n = 0};
    stein_status status = make_table(&t, l, err);
    if (status == STEIN_OK && t.n > 0) {
        status = push_table(&t, l, err);
        status = status == STEIN_OK ? fill_mixed(&m, &t, l, err) : status;
        status = status == STEIN_OK ? diag__gauss_make(&g, t.n, l->njoint, err) : status;
        status = status == STEIN_OK ? solve_table(&t, l, &m, &g, err) : status;
        status = status == STEIN_OK ? add_rows(&t, l, &g, list, n, err) : status;
    }
    free(g.M);
    lab__mixed_free(&m);
    free_table(&t);
    return status;
}
