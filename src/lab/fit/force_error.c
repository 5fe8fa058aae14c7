/* SPDX-License-Identifier: GPL-3.0-or-later
 * force_error.c - the noise of measured forces, as unknowns of a record.
 *
 * A recorded force u = u_true + e drives the simulation. Its noise e is white, but the effect on a
 * motion is not. Integrated, it resembles a spring, an asymmetry or a shift of the force, and it
 * moves the events of contacts. So e is an unknown of the record. Along any orthonormal shapes over
 * the samples white noise has independent amplitudes of the same standard deviation s; of all
 * shapes few move the mechanism. With G = dr/da of the amplitudes a [s] of the n slowest cosines of
 * every force,
 *
 *      G'G = V L V',     share of shape i of chi2/dof: L_i / samples
 *
 * and the shapes sum_k V_ki cos_k with the largest L become unknowns with the prior N(0, 1), until
 * the others add less than `negligible`. A mass integrates twice, so few are enough. Noise that
 * adds less than `matters` in all is left out.
 *
 * The cosines reach up to twice the rate at which the channels swing: a resonance answers there. A
 * prescribed motion is smoothed as far as its noise allows (signal.c) and is left alone here.
 */
#include <gsl/gsl_eigen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "fitting.h"

enum { LEAST = 48, MOST = 128 };       /* cosines of a force: cost */
static const double matters = 0.05;    /* of chi2/dof */
static const double negligible = 0.01; /* of chi2/dof */
static const double pi = 3.14159265358979323846;

static int is_noisy(const fit__signal *s)
{
    return !s->motion && s->noise > 0.0 && s->n > 1;
}

static int knots_of(const fit__stroke *t)
{
    int n = 0;
    for (int k = 0; k < t->nsignal; k++) {
        n += t->signal[k].n;
    }
    return n;
}

/* slowest cosines of a force that may move the mechanism */
static int cosines_of(const fit__stroke *t, const fit__signal *s)
{
    double swings = t->half > 0.0 ? (s->t[s->n - 1] - s->t[0]) / t->half : 0.0;
    int most = s->n < MOST ? s->n : MOST;
    return (int)fmin(most, fmax(LEAST, ceil(2.0 * swings)));
}

const fit__force_error *fit__force_error_of(const fit__problem *p, const fit__stroke *t)
{
    const lab_force_errors *all = p->def->force_errors;
    for (int i = 0; all != NULL && i < all->n; i++) {
        const fit__force_error *e = all->record[i];
        if (e->number == t->data->number && e->knots == knots_of(t)) {
            return e;
        }
    }
    return NULL;
}

void fit__force_error_at(const fit__problem *p, const fit__stroke *t, const double *x,
                         double *error)
{
    int knots = t->force->knots;
    memset(error, 0, sizeof *error * (size_t)knots);
    for (int k = t->first; k < t->first + t->own; k++) {
        const fit__unknown *u = &p->unknown[k];
        if (u->kind == FIT__FORCE) {
            const double *shape = t->force->shape + (size_t)u->index * (size_t)knots;
            double amount = fit__value(u, x[k]);
            for (int i = 0; amount != 0.0 && i < knots; i++) {
                error[i] += amount * shape[i];
            }
        }
    }
}

void fit__force_errors_free(lab_force_errors *e)
{
    for (int i = 0; i < e->n; i++) {
        free(e->record[i]->shape);
        free(e->record[i]);
    }
    free(e->record);
    *e = (lab_force_errors){.n = 0};
}

/* ---- which shapes ---- */

/* the cosines of all noisy forces of a record, in their noise */
static stein_status take_cosines(const fit__stroke *t, fit__force_error *e, stein_err *err)
{
    *e = (fit__force_error){.number = t->data->number, .knots = knots_of(t)};
    for (int k = 0; k < t->nsignal; k++) {
        e->n += is_noisy(&t->signal[k]) ? cosines_of(t, &t->signal[k]) : 0;
    }
    e->shape = calloc((size_t)e->n * (size_t)e->knots + 1, sizeof *e->shape);
    if (e->shape == NULL) {
        return lab__no_memory(err);
    }
    double *to = e->shape;
    for (int k = 0, first = 0; k < t->nsignal; first += t->signal[k++].n) {
        const fit__signal *s = &t->signal[k];
        int cosines = is_noisy(s) ? cosines_of(t, s) : 0;
        for (int f = 0; f < cosines; f++, to += e->knots) {
            double size = s->noise * sqrt((f > 0 ? 2.0 : 1.0) / s->n);
            for (int i = 0; i < s->n; i++) {
                to[first + i] = size * stein__cos(pi * f * (i + 0.5) / s->n);
            }
        }
    }
    return STEIN_OK;
}

/* derivatives of a record's residuals by the amplitudes of its shapes, G [e->n] of them; `done` 0:
 * it cannot be simulated */
static stein_status answer(fit__problem *p, double *G, int *done, stein_err *err)
{
    const fit__stroke *t = &p->stroke[0];
    size_t rows = (size_t)t->nch * (size_t)t->n;
    double *x = calloc((size_t)p->nu + rows + fit__columns(p) + 1, sizeof *x);
    unsigned char *known = malloc((size_t)p->nu + 1);
    double *r = x + (x != NULL ? p->nu : 0), *J = r + (x != NULL ? rows : 0);
    int failed = 0;
    stein_err why;
    stein_status status = x != NULL && known != NULL ? STEIN_OK : STEIN_ENOMEM;
    for (int k = 0; status == STEIN_OK && k < p->nu; k++) {
        known[k] = p->unknown[k].kind != FIT__FORCE;
        p->step[k] = 0.1;
    }
    status = status == STEIN_OK ? fit__residuals(p, x, r, &failed, &why) : status;
    if (status == STEIN_OK && failed == 0) {
        status = fit__more_sensitivities(p, x, r, known, J, &why);
    }
    *done = status == STEIN_OK && failed == 0;
    for (int k = 0, g = 0; *done && k < t->own; k++) {
        if (!known[t->first + k]) {
            memcpy(G + rows * (size_t)g++, J + fit__column(p, 0, p->np + k), sizeof *G * rows);
        }
    }
    free(known);
    free(x);
    return fit__forgive(status, err);
}

/* the shapes that matter, from all and their answers */
static stein_status choose(const fit__force_error *all, const double *G, size_t rows,
                           double samples, fit__force_error *e, stein_err *err)
{
    size_t n = (size_t)all->n, knots = (size_t)all->knots;
    gsl_matrix *A = gsl_matrix_alloc(n, n), *V = gsl_matrix_alloc(n, n);
    gsl_vector *L = gsl_vector_alloc(n);
    gsl_eigen_symmv_workspace *work = gsl_eigen_symmv_alloc(n);
    double all_of_it = 0.0;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k <= i; k++) {
            double a = lab__dot(G + i * rows, G + k * rows, rows) / samples;
            gsl_matrix_set(A, i, k, a);
            gsl_matrix_set(A, k, i, a);
            all_of_it += i == k ? a : 0.0;
        }
    }
    gsl_eigen_symmv(A, L, V, work);
    gsl_eigen_symmv_sort(L, V, GSL_EIGEN_SORT_VAL_DESC);
    e->share = e->left = all_of_it;
    for (; e->share > matters && e->left > negligible && e->n < FIT__FORCES && e->n < all->n;
         e->n++) {
        e->left -= gsl_vector_get(L, (size_t)e->n);
    }
    e->left = fmax(0.0, e->left);
    e->shape = calloc((size_t)e->n * knots + 1, sizeof *e->shape);
    for (size_t i = 0; e->shape != NULL && i < (size_t)e->n; i++) {
        for (size_t k = 0; k < n; k++) {
            double v = gsl_matrix_get(V, k, i);
            for (size_t j = 0; j < knots; j++) {
                e->shape[i * knots + j] += v * all->shape[k * knots + j];
            }
        }
    }
    gsl_eigen_symmv_free(work);
    gsl_vector_free(L);
    gsl_matrix_free(V);
    gsl_matrix_free(A);
    return e->shape != NULL ? STEIN_OK : lab__no_memory(err);
}

/* of one record, as the problem has it */
static stein_status find(const fit__problem *from, int s, fit__force_error *e, stein_err *err)
{
    lab_dataset one = {1, &from->data->stroke[s]};
    lab_fit_def def = *from->def;
    fit__force_error all, *only = &all;
    lab_force_errors cosines = {.n = 1, .record = &only};
    fit__problem p = {.nstroke = 0};
    double *G = NULL;
    int done = 0;
    def.force_errors = &cosines;
    *e = (fit__force_error){.number = one.stroke[0]->number, .knots = knots_of(&from->stroke[s])};
    stein_status status = take_cosines(&from->stroke[s], &all, err);
    if (status == STEIN_OK && all.n > 0) {
        status = fit__problem_make_with(&p, from->model, &one, &def, NULL, 0, err);
        size_t rows = status == STEIN_OK ? (size_t)p.rows : 0;
        p.tolerance = from->tolerance;
        p.simulated = from->simulated;
        G = malloc(sizeof *G * (rows * (size_t)all.n + 1));
        status = status == STEIN_OK && G == NULL ? lab__no_memory(err) : status;
        status = status == STEIN_OK ? answer(&p, G, &done, err) : status;
        if (status == STEIN_OK && done) {
            status = choose(&all, G, rows, fmax(1.0, p.stroke[0].samples), e, err);
        }
    }
    free(G);
    fit__problem_free(&p);
    free(all.shape);
    return status;
}

stein_status fit__force_errors_add(lab_force_errors *to, const fit__problem *p, stein_err *err)
{
    fit__force_error **more = realloc(to->record, sizeof *more * (size_t)(to->n + p->nstroke + 1));
    if (more == NULL) {
        return lab__no_memory(err);
    }
    to->record = more;
    stein_status status = STEIN_OK;
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        int noisy = 0;
        for (int k = 0; k < t->nsignal; k++) {
            noisy |= is_noisy(&t->signal[k]);
        }
        if (noisy && t->force == NULL) { // it is not known yet
            fit__force_error *e = calloc(1, sizeof *e);
            to->record[to->n] = e;
            to->n += e != NULL;
            status = e != NULL ? find(p, s, e, err) : lab__no_memory(err);
        }
    }
    return status;
}

void fit__force_errors_share(const lab_force_errors *e, double *share, double *left)
{
    *share = *left = 0.0;
    for (int i = 0; i < e->n; i++) {
        *share += e->record[i]->share / e->n;
        *left += e->record[i]->left / e->n;
    }
}
