/* SPDX-License-Identifier: GPL-3.0-or-later
 * modes.c - natural frequencies, damping and shapes of a linearised mechanism. They are eigenvalues
 * of A of its free coordinates, by QR (GSL), balanced first, since coordinates are in rad and in m.
 */
#include <gsl/gsl_complex_math.h>
#include <gsl/gsl_eigen.h>
#include <math.h>
#include <stdlib.h>

#include "io.h"

/* of the largest eigenvalue: a double eigenvalue 0 is found to the square root of rounding only */
static const double neutral = 1e-7;
static const double two_pi = 6.28318530717958647693;

typedef struct work {
    int n; /* free coordinates */
    gsl_matrix *A;
    gsl_vector_complex *value;
    gsl_matrix_complex *vector;
    gsl_eigen_nonsymmv_workspace *own;
} work;

static void release(work *w)
{
    gsl_matrix_free(w->A);
    gsl_vector_complex_free(w->value);
    gsl_matrix_complex_free(w->vector);
    if (w->own != NULL) {
        gsl_eigen_nonsymmv_free(w->own);
    }
}

static int allocate(work *w, int n)
{
    size_t size = 2 * (size_t)n;
    *w = (work){.n = n,
                .A = gsl_matrix_alloc(size, size),
                .value = gsl_vector_complex_alloc(size),
                .vector = gsl_matrix_complex_alloc(size, size),
                .own = gsl_eigen_nonsymmv_alloc(size)};
    if (w->A == NULL || w->value == NULL || w->vector == NULL || w->own == NULL) {
        release(w);
        return 0;
    }
    gsl_eigen_nonsymmv_params(1, w->own);
    return 1;
}

/* states of the free coordinates: z, then z' */
static int state_of(const stein_linear_system *s, int i)
{
    return i < s->nfree ? i : s->n + i - s->nfree;
}

static void copy_free(const stein_linear_system *s, gsl_matrix *A)
{
    for (int i = 0; i < 2 * s->nfree; i++) {
        for (int j = 0; j < 2 * s->nfree; j++) {
            gsl_matrix_set(A, (size_t)i, (size_t)j,
                           s->A[state_of(s, i) * 2 * s->n + state_of(s, j)]);
        }
    }
}

/* The coordinate with the largest share of the kinetic energy, Re(conj(v_i) (M v)_i) in the sum of
 * them: units do not matter. */
static void put_share(const stein_linear_system *s, const double *shape, lab_mode *mode)
{
    double sum = 0.0, largest = -INFINITY;
    for (int i = 0; i < s->nfree; i++) {
        double re = 0.0, im = 0.0;
        for (int j = 0; j < s->nfree; j++) {
            re += s->mass[i * s->n + j] * shape[2 * j];
            im += s->mass[i * s->n + j] * shape[2 * j + 1];
        }
        double own = shape[2 * i] * re + shape[2 * i + 1] * im;
        sum += own;
        if (own > largest) {
            largest = own;
            mode->coordinate = i;
        }
    }
    mode->share = sum > 0.0 ? largest / sum : 1.0;
}

/* eigenvector `column`, its largest element 1 */
static void put_shape(const work *w, size_t column, double *shape)
{
    gsl_complex largest = gsl_complex_rect(0.0, 0.0);
    for (int i = 0; i < w->n; i++) {
        gsl_complex x = gsl_matrix_complex_get(w->vector, (size_t)i, column);
        largest = gsl_complex_abs(x) > gsl_complex_abs(largest) ? x : largest;
    }
    for (int i = 0; i < w->n; i++) {
        gsl_complex x = gsl_matrix_complex_get(w->vector, (size_t)i, column);
        x = gsl_complex_abs(largest) > 0.0 ? gsl_complex_div(x, largest) : x;
        shape[2 * i] = GSL_REAL(x);
        shape[2 * i + 1] = GSL_IMAG(x);
    }
}

static lab_mode mode_of(gsl_complex value, double largest)
{
    double size = gsl_complex_abs(value), re = GSL_REAL(value), im = GSL_IMAG(value);
    lab_mode mode = {.re = re, .im = im, .count = im > 0.0 ? 2 : 1};
    mode.kind = size <= neutral * largest ? LAB_NEUTRAL
                : im > 0.0                ? LAB_OSCILLATES
                : re < 0.0                ? LAB_DECAYS
                                          : LAB_GROWS;
    mode.frequency = mode.kind == LAB_OSCILLATES ? size / two_pi : 0.0;
    mode.damping = size > 0.0 && mode.kind != LAB_NEUTRAL ? 0.0 - re / size : 0.0;
    return mode;
}

static void put_modes(const stein_linear_system *s, const work *w, lab_modes *modes)
{
    double largest = 0.0;
    for (size_t i = 0; i < w->value->size; i++) {
        largest = fmax(largest, gsl_complex_abs(gsl_vector_complex_get(w->value, i)));
    }
    for (size_t i = 0; i < w->value->size; i++) {
        gsl_complex value = gsl_vector_complex_get(w->value, i);
        if (GSL_IMAG(value) >= 0.0) { // one of a pair
            double *shape = modes->shape + (size_t)modes->n * 2 * (size_t)s->nfree;
            lab_mode *mode = &modes->mode[modes->n++];
            *mode = mode_of(value, largest);
            put_shape(w, i, shape);
            put_share(s, shape, mode);
        }
    }
}

stein_status lab_modes_create(lab_modes **out, const stein_linear_system *s, stein_err *err)
{
    work w;
    size_t n = (size_t)s->nfree;
    lab_modes *modes = calloc(1, sizeof *modes);
    if (modes == NULL || !allocate(&w, s->nfree)) {
        free(modes);
        return lab__no_memory(err);
    }
    modes->mode = calloc(2 * n, sizeof *modes->mode);
    modes->shape = calloc(4 * n * n, sizeof *modes->shape);
    stein_status status = STEIN_OK;
    if (modes->mode == NULL || modes->shape == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        copy_free(s, w.A);
        if (gsl_eigen_nonsymmv(w.A, w.value, w.vector, w.own) != 0 ||
            gsl_eigen_nonsymmv_sort(w.value, w.vector, GSL_EIGEN_SORT_ABS_ASC) != 0) {
            status = lab__fail(err, STEIN_ENONFINITE, "no eigenvalues: A is not finite");
        }
    }
    if (status == STEIN_OK) {
        put_modes(s, &w, modes);
        *out = modes;
    } else {
        lab_modes_destroy(modes);
    }
    release(&w);
    return status;
}

void lab_modes_destroy(lab_modes *modes)
{
    if (modes != NULL) {
        free(modes->mode);
        free(modes->shape);
        free(modes);
    }
}
