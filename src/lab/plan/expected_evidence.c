/* SPDX-License-Identifier: GPL-3.0-or-later
 * expected_evidence.c - the evidence that a record is expected to give for one model over another.
 *
 * Near its fit each of two models M predicts the channels of a stroke, in units of noise, as
 *
 *      y = y_M + P_M w + Z_M u + e,    w, u, e ~ N(0, 1)
 *
 * P the effects of its uncertain numbers (one column a standard deviation of their joint
 * posterior), Z those of the stroke's own unknowns: trigger, offsets, scatter of friction and
 * drive. n repeats share w and have u and e of their own. With S = 1 + Z Z', the odds after them
 * are
 *
 *      2 ln odds(A : B) = q_B - q_A + ln|V_B| - ln|V_A|
 *      q_M = sum v'S^-1 v - h'(1 + n H)^-1 h,   v = y - y_M,  h = sum P'S^-1 v,  H = P'S^-1 P
 *      ln|V_M| = n ln|S| + ln|1 + n H|
 *
 * Both models use the mean of their Z, and of the columns of file numbers that are uncertain in
 * both: a trigger or a mass moves a stroke by hundreds of noises. A difference of its derivatives,
 * a small part of that, is rounding and curvature, no evidence. P differs by the posteriors of
 * these numbers, and by the numbers of the effects.
 *
 * So whatever a refit of numbers and nuisances can imitate counts for nothing (Box and Hill 1967,
 * Buzzi-Ferraris and Forzatti 1984). Two models that were fitted to the same strokes may differ by
 * many standard deviations in shared numbers. The curvature between them is no evidence, either:
 * if A is true, y_B is B's prediction fitted to A's prediction, with its numbers moved back along
 * P_B (y_B|A). Strokes are drawn from either model: the mean and the worst tenth of 2 ln odds, the
 * lesser one of both truths. Of k rivals each has to go in all but a k-th of that tenth, so that
 * all of them are gone in nine of ten. A draw needs no vector as long as a stroke: with X = [y_A -
 * y_B|A, y_A|B - y_B, P_A, Z, P_B, Z] and K = X'X, X'v follows from w, u and X'e ~ N(0, K).
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "planning.h"
#include "verdict.h"

enum { DIFFERENCES = 2 }; /* columns of a pair: of either truth */
enum { DRAWS = 400, DRAWS_MANY = 200, MANY = 8 };
static const double jitter = 1e-10;

/* ---- Gram matrices ---- */

/* the one of b that is number k of a; -1: a number of the effect, or b has none */
static int same_number(const plan__prediction *a, int k, const plan__prediction *b)
{
    int place, index;
    for (int i = 0; !diag__find_number(a->name[k], &place, &index) && i < b->np; i++) {
        if (strcmp(a->name[k], b->name[i]) == 0) {
            return i;
        }
    }
    return -1;
}

void plan__spread(double *to, const plan__prediction *a, const plan__prediction *b)
{
    size_t n = (size_t)a->rows * (size_t)a->noutput, np = (size_t)a->np;
    if (a->D == NULL || b->D == NULL) {
        memcpy(to, a->P, sizeof *to * n * np);
        return;
    }
    for (size_t k = 0; k < np; k++) {
        int other = same_number(a, (int)k, b);
        const double *mine = a->D + k * n, *its = other < 0 ? mine : b->D + (size_t)other * n;
        for (size_t c = 0; c <= k; c++) { // L is lower
            double by = 0.5 * a->L[c * np + k];
            for (size_t i = 0; i < n; i++) {
                to[c * n + i] += by * (mine[i] + its[i]);
            }
        }
    }
}

stein_status plan__pair_make(plan__pair *pair, plan__reference *reference, plan__prediction *a,
                             plan__prediction *b, stein_err *err)
{
    int n = DIFFERENCES + a->np + a->nz + b->np + b->nz;
    size_t rows = (size_t)a->rows, all = rows * (size_t)a->noutput, size = (size_t)n * (size_t)n;
    size_t until = (size_t)(a->until < b->until ? a->until : b->until);
    *pair = (plan__pair){.np = {a->np, b->np}, .nz = {a->nz, b->nz}, .n = n, .noutput = a->noutput};
    pair->K = calloc(size * (size_t)a->noutput + 1, sizeof *pair->K);
    double *X = calloc((size_t)n * rows + 1, sizeof *X); // unpredictable samples stay 0
    size_t nz = (size_t)a->nz, np_a = (size_t)a->np, np_b = (size_t)b->np;
    double *room = calloc((2 + nz + np_a + np_b) * all + 1, sizeof *room), *Z = room + 2 * all;
    double *P[] = {Z + nz * all, Z + (nz + np_a) * all};
    if (pair->K == NULL || X == NULL || room == NULL || a->nz != b->nz) {
        free(X);
        free(room);
        return a->nz != b->nz ? lab__fail(err, STEIN_EINVAL, "the records have other unknowns")
                              : lab__no_memory(err);
    }
    for (size_t i = 0; i < nz * all; i++) {
        Z[i] = 0.5 * (a->Z[i] + b->Z[i]);
    }
    plan__spread(P[0], a, b);
    plan__spread(P[1], b, a);
    double *of_b = room, *of_a = room + all; // y_B|A and y_A|B
    stein_status status = plan__refit(of_b, b, reference, a, P[1], Z, err);
    status = status == STEIN_OK ? plan__refit(of_a, a, reference, b, P[0], Z, err) : status;
    for (int c = 0; status == STEIN_OK && c < a->noutput; c++) {
        size_t at = rows * (size_t)c, k = DIFFERENCES;
        for (size_t i = 0; i < until; i++) {
            X[i] = a->y[at + i] - of_b[at + i];
            X[rows + i] = of_a[at + i] - b->y[at + i];
        }
        const double *block[] = {P[0], Z, P[1], Z};
        const int count[] = {a->np, a->nz, b->np, b->nz};
        for (int part = 0; part < 4; part++) {
            for (int i = 0; i < count[part]; i++, k++) {
                memcpy(X + k * rows, block[part] + (size_t)i * all + at, sizeof *X * until);
            }
        }
        gsl_matrix_const_view x = gsl_matrix_const_view_array(X, (size_t)n, rows);
        gsl_matrix_view K = gsl_matrix_view_array(pair->K + size * (size_t)c, (size_t)n, (size_t)n);
        gsl_blas_dgemm(CblasNoTrans, CblasTrans, 1.0, &x.matrix, &x.matrix, 0.0, &K.matrix);
    }
    free(X);
    free(room);
    return status;
}

void plan__pair_free(plan__pair *pair)
{
    free(pair->K);
    pair->K = NULL;
}

/* ---- one model of the two ---- */

typedef struct model {
    int p, np, z, nz;        /* where its columns begin, how many */
    gsl_matrix *W, *H, *PZW; /* (1 + Z'Z)^-1; P'S^-1 P; P'Z W */
    gsl_matrix *L;           /* Cholesky factor of 1 + n H */
    gsl_vector *h, *t;
    double lnS, lnH;
} model;

/* never empty: GSL has no matrices of size 0 */
static gsl_matrix *matrix(int rows, int columns)
{
    return gsl_matrix_calloc((size_t)(rows > 0 ? rows : 1), (size_t)(columns > 0 ? columns : 1));
}

static int model_make(model *m, const double *K, int n, int p, int np, int nz)
{
    *m = (model){.p = p, .np = np, .z = p + np, .nz = nz};
    int most = np > nz ? np : nz;
    m->W = matrix(nz, nz);
    m->H = matrix(np, np);
    m->PZW = matrix(np, nz);
    m->L = matrix(np, np);
    m->h = gsl_vector_calloc((size_t)most + 1);
    m->t = gsl_vector_calloc((size_t)most + 1);
    if (!m->W || !m->H || !m->PZW || !m->L || !m->h || !m->t) {
        return -1;
    }
    gsl_matrix_set_identity(m->W);
    for (int i = 0; i < nz; i++) {
        for (int k = 0; k < nz; k++) {
            double one = i == k ? 1.0 : 0.0;
            gsl_matrix_set(m->W, (size_t)i, (size_t)k, one + K[(m->z + i) * n + m->z + k]);
        }
    }
    if (gsl_linalg_cholesky_decomp1(m->W) != 0) {
        return 0;
    }
    for (int i = 0; i < nz; i++) {
        m->lnS += 2.0 * stein__log_of(gsl_matrix_get(m->W, (size_t)i, (size_t)i));
    }
    gsl_linalg_cholesky_invert(m->W);
    for (int i = 0; i < np; i++) {
        for (int k = 0; k < nz; k++) {
            double sum = 0.0;
            for (int j = 0; j < nz; j++) {
                sum += K[(m->p + i) * n + m->z + j] * gsl_matrix_get(m->W, (size_t)j, (size_t)k);
            }
            gsl_matrix_set(m->PZW, (size_t)i, (size_t)k, sum);
        }
        for (int k = 0; k < np; k++) {
            double sum = K[(m->p + i) * n + m->p + k];
            for (int j = 0; j < nz; j++) {
                sum -= gsl_matrix_get(m->PZW, (size_t)i, (size_t)j) * K[(m->z + j) * n + m->p + k];
            }
            gsl_matrix_set(m->H, (size_t)i, (size_t)k, sum);
        }
    }
    return 1;
}

static void model_free(model *m)
{
    gsl_matrix_free(m->W);
    gsl_matrix_free(m->H);
    gsl_matrix_free(m->PZW);
    gsl_matrix_free(m->L);
    gsl_vector_free(m->h);
    gsl_vector_free(m->t);
}

/* for so many repeats */
static int model_repeat(model *m, int repeats)
{
    gsl_matrix_memcpy(m->L, m->H);
    gsl_matrix_scale(m->L, repeats);
    m->lnH = 0.0;
    for (size_t i = 0; i < m->L->size1; i++) {
        gsl_matrix_set(m->L, i, i, gsl_matrix_get(m->L, i, i) + 1.0);
    }
    if (gsl_linalg_cholesky_decomp1(m->L) != 0) {
        return 0;
    }
    for (size_t i = 0; i < m->L->size1; i++) {
        m->lnH += 2.0 * stein__log_of(gsl_matrix_get(m->L, i, i));
    }
    gsl_vector_set_zero(m->h);
    return 1;
}

/* one stroke more, g = X'v: adds to h. @return -(Z'v)'W(Z'v), the part of q beside v'v */
static double model_take(model *m, const double *g)
{
    double q = 0.0;
    for (int i = 0; i < m->nz; i++) {
        for (int k = 0; k < m->nz; k++) {
            q -= g[m->z + i] * gsl_matrix_get(m->W, (size_t)i, (size_t)k) * g[m->z + k];
        }
    }
    for (int i = 0; i < m->np; i++) {
        double sum = g[m->p + i];
        for (int k = 0; k < m->nz; k++) {
            sum -= gsl_matrix_get(m->PZW, (size_t)i, (size_t)k) * g[m->z + k];
        }
        *gsl_vector_ptr(m->h, (size_t)i) += sum;
    }
    return q;
}

/* h'(1 + n H)^-1 h */
static double model_learnt(model *m)
{
    double sum = 0.0;
    if (m->np == 0) {
        return 0.0;
    }
    gsl_vector_view t = gsl_vector_subvector(m->t, 0, (size_t)m->np);
    gsl_vector_const_view h = gsl_vector_const_subvector(m->h, 0, (size_t)m->np);
    gsl_vector_memcpy(&t.vector, &h.vector);
    gsl_blas_dtrsv(CblasLower, CblasNoTrans, CblasNonUnit, m->L, &t.vector);
    gsl_blas_ddot(&t.vector, &t.vector, &sum);
    return sum;
}

/* ---- draws ---- */

typedef struct draw {
    const plan__pair *pair;
    const double *K;
    gsl_matrix *E; /* Cholesky factor of K, the covariance of noise */
    model side[2];
    double *g, *other, *xi, *w; /* [n] */
    gsl_rng *rng;
} draw;

static void add_column(const draw *d, double *g, int column, double by)
{
    int n = d->pair->n;
    for (int i = 0; i < n; i++) {
        g[i] += by * d->K[column * n + i]; // symmetric
    }
}

/* 2 ln odds for the truth after so many repeats */
static double one_draw(draw *d, int truth, int repeats)
{
    model *a = &d->side[truth], *b = &d->side[1 - truth];
    int n = d->pair->n;
    double sum = repeats * (b->lnS - a->lnS) + b->lnH - a->lnH, sign = truth == 0 ? 1.0 : -1.0;
    gsl_vector_set_zero(a->h);
    gsl_vector_set_zero(b->h);
    for (int i = 0; i < a->np; i++) {
        d->w[i] = gsl_ran_ugaussian(d->rng);
    }
    for (int s = 0; s < repeats; s++) {
        for (int i = 0; i < n; i++) {
            d->xi[i] = gsl_ran_ugaussian(d->rng);
        }
        gsl_vector_view g = gsl_vector_view_array(d->g, (size_t)n);
        memcpy(d->g, d->xi, sizeof *d->g * (size_t)n);
        gsl_blas_dtrmv(CblasLower, CblasNoTrans, CblasNonUnit, d->E, &g.vector);
        for (int i = 0; i < a->np; i++) {
            add_column(d, d->g, a->p + i, d->w[i]);
        }
        for (int i = 0; i < a->nz; i++) {
            add_column(d, d->g, a->z + i, gsl_ran_ugaussian(d->rng));
        }
        memcpy(d->other, d->g, sizeof *d->g * (size_t)n);
        add_column(d, d->other, truth, sign);
        sum += 2.0 * sign * d->g[truth] + d->K[truth * n + truth];
        sum += model_take(b, d->other) - model_take(a, d->g);
    }
    return sum - model_learnt(b) + model_learnt(a);
}

/* mean and worst, of the truth that fares worse */
static void draws(draw *d, int repeats, int rivals, double *mean, double *worst)
{
    double value[DRAWS];
    int n = repeats > MANY ? DRAWS_MANY : DRAWS;
    *mean = *worst = INFINITY;
    gsl_rng_set(d->rng, 1788);
    for (int truth = 0; truth < 2; truth++) {
        double sum = 0.0;
        if (!model_repeat(&d->side[0], repeats) || !model_repeat(&d->side[1], repeats)) {
            *mean = *worst = 0.0;
            return;
        }
        for (int k = 0; k < n; k++) {
            value[k] = one_draw(d, truth, repeats);
            sum += value[k];
        }
        gsl_sort(value, 1, (size_t)n);
        *mean = fmin(*mean, sum / n);
        *worst = fmin(*worst, value[n / (10 * rivals)]);
    }
}

/* the factor of K, whose columns may depend on each other */
static int noise_factor(draw *d)
{
    int n = d->pair->n, ok;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            double scale = sqrt(d->K[i * n + i] * d->K[k * n + k]);
            double c = scale > 0.0 ? d->K[i * n + k] / scale : 0.0;
            gsl_matrix_set(d->E, (size_t)i, (size_t)k, i == k ? 1.0 + jitter : c);
        }
    }
    ok = gsl_linalg_cholesky_decomp1(d->E) == 0;
    for (int i = 0; ok && i < n; i++) {
        for (int k = 0; k <= i; k++) {
            *gsl_matrix_ptr(d->E, (size_t)i, (size_t)k) *= sqrt(d->K[i * n + i]);
        }
    }
    return ok;
}

static void draw_free(draw *d)
{
    gsl_matrix_free(d->E);
    model_free(&d->side[0]);
    model_free(&d->side[1]);
    gsl_rng_free(d->rng);
}

stein_status plan__odds(const plan__pair *pair, const unsigned char *use, double wanted, int most,
                        int rivals, lab_experiment *e, stein_err *err)
{
    static const int repeats[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64};
    size_t n = (size_t)pair->n;
    double *room = calloc(n * n + 4 * n, sizeof *room), *K = room;
    draw d = {.pair = pair, .K = K, .rng = gsl_rng_alloc(gsl_rng_mt19937)};
    d.E = gsl_matrix_alloc(n, n);
    if (room == NULL || d.E == NULL || d.rng == NULL) {
        free(room);
        draw_free(&d);
        return lab__no_memory(err);
    }
    d.g = room + n * n;
    d.other = d.g + n;
    d.xi = d.other + n;
    d.w = d.xi + n;
    for (int c = 0; c < pair->noutput; c++) {
        for (size_t i = 0; use[c] && i < n * n; i++) {
            K[i] += pair->K[(size_t)c * n * n + i];
        }
    }
    int first = DIFFERENCES, second = first + pair->np[0] + pair->nz[0];
    int a = model_make(&d.side[0], K, pair->n, first, pair->np[0], pair->nz[0]);
    int b = model_make(&d.side[1], K, pair->n, second, pair->np[1], pair->nz[1]);
    e->odds = e->odds_worst = 0.0;
    e->repeats = 0;
    if (a > 0 && b > 0 && noise_factor(&d)) {
        draws(&d, 1, rivals, &e->odds, &e->odds_worst);
        double mean = e->odds, worst = e->odds_worst;
        for (size_t i = 0; i < sizeof repeats / sizeof *repeats && repeats[i] <= most; i++) {
            if (repeats[i] > 1) {
                draws(&d, repeats[i], rivals, &mean, &worst);
            }
            if (worst >= wanted) {
                e->repeats = repeats[i];
                break;
            }
            if (mean * most / repeats[i] < 0.2 * wanted) {
                break; // hopeless
            }
        }
    }
    draw_free(&d);
    free(room);
    return a >= 0 && b >= 0 ? STEIN_OK : lab__no_memory(err);
}
