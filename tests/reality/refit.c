/* SPDX-License-Identifier: GPL-3.0-or-later
 * refit.c - the size of an effect: what of it remains in the films after everything else is
 * refitted.
 *
 * Films of the 12 strokes at the true parameters, without scatter and with the standard camera; r
 * is the change of all readings by the effect, each in units of one sample's noise. A refit that is
 * linear moves them by X u, where the columns of X (columns.c) are the changes per prior standard
 * deviation of
 *
 *   common to all strokes   every parameter for which the file states a tolerance
 *   own to each stroke      time of the trigger, one offset a marker, drive, joint friction,
 *                           contact friction (with the scatter of the set as prior)
 *
 * With the priors the refit is
 *
 *   u = argmin |r|^2 + |u|^2 ,   r = films(effect) - films(moved by u) ,     size = RMS(r)
 *
 * taken over the channel where it is largest. An effect that resembles a parameter moves the films
 * by hundreds of noises before the refit, and not linearly. A stroke on the other side of an event
 * leads to impossible numbers. One linear step from the truth would be off by hundreds of standard
 * deviations, and the residual would count as a size. So the refit follows the effect as it grows
 * (scale.c). It begins where that of a smaller amount has ended, in proportion, and its steps are
 * as long as they lead down (Levenberg and Marquardt):
 *
 *   (X'X + 1 + lambda diag X'X) du = X' r - u
 *
 * with X taken anew where the numbers have moved by more than half a standard deviation.
 * A law that is in no table may equal one of the table in the range of the strokes: a contact that
 * has relaxed once and for all is a softer one. That one is refitted, too (known), so that what
 * remains is outside of the table.
 *
 * `Everything else`: The effect's own parameter is not refitted, if it has one. Nor are the drive
 * under a wrong load or input, the friction of contacts under a wrong friction, and a marker's
 * offset under a wrong offset.
 */
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "refit.h"

enum { STEPS = 24, RENEWALS = 3 };
/* films good to 10 nm: a thousandth of the noise */
static const double accurate_enough = 1e-8;
static const double settled = 0.02; /* a step that takes less off the objective is the last one */
static const double shortest = 1e4; /* lambda */
static const double strayed = 0.5;  /* prior sd from where the columns are */
static const double near = 0.25;    /* sizes from this share of the wanted one */
static const double lost = 3.0;     /* to so much are worth new columns */
static const double worth = 0.9;    /* new columns that leave more of the objective are the last */

refit *refit_create(const world *w, const design *d)
{
    refit *r = calloc(1, sizeof *r);
    int status = r != NULL ? 0 : -1;
    if (status == 0) {
        r->w = w;
        r->d = d;
        r->camera = standard_camera;
        r->camera.seen = d->camera.seen;
        r->camera.accuracy = accurate_enough;
    }
    for (int i = 0; status == 0 && i < w->m->nparam; i++) {
        if (w->m->params[i].tolerance > 0.0 && r->nparam < MAX_COMMON - 1) {
            r->common[r->nparam++] = i;
        }
    }
    if (status == 0) {
        r->ncommon = r->nparam + 1;
    }
    if (status == 0 && (status = columns_create(r)) == 0) {
        r->r = calloc((size_t)FIT * (size_t)r->rows, sizeof *r->r);
        r->before = calloc((size_t)FIT * (size_t)r->rows, sizeof *r->before);
        r->u = calloc((size_t)(r->ncommon + FIT * OWN), sizeof *r->u);
        r->low = calloc((size_t)(r->ncommon + FIT * OWN), sizeof *r->low);
        status = r->r && r->before && r->u && r->low ? 0 : -1;
    }
    if (status != 0) {
        refit_free(r);
        return NULL;
    }
    return r;
}

void refit_free(refit *r)
{
    if (r == NULL) {
        return;
    }
    for (int i = 0; i < FIT; i++) {
        columns_free(&r->block[i]);
    }
    free(r->r);
    free(r->before);
    free(r->u);
    free(r->low);
    free(r);
}

/* is column k one that the refit may use against this effect */
static int allowed(const refit *r, const effect *e, int k)
{
    const char *kind = e->kind->name;
    if (k < r->ncommon) {
        return k < r->nparam ? r->common[k] != effect_own_parameter(e, r->w->m)
                             : r->known.kind != NULL;
    }
    switch (k - r->ncommon) {
    case N_TRIGGER: return 1;
    case N_DRIVE: return strcmp(e->kind->verdict, "input") != 0;
    case N_JOINTS:
        return strcmp(e->place, "key.friction.A") != 0 &&
               strcmp(e->place, "hammer.friction.A") != 0;
    case N_CONTACTS:
        return strcmp(kind, "contact_friction") != 0 && strcmp(e->place, "notch.friction.A") != 0;
    default: {
        int marker = k - r->ncommon - N_OFFSET;
        return marker < r->camera.seen &&
               !(strcmp(kind, "sensor_offset") == 0 && strcmp(e->place, seen_name[marker]) == 0);
    }
    }
}

static size_t unknowns(const refit *r)
{
    return (size_t)(r->ncommon + FIT * OWN);
}

/* film of a stroke without the effect, moved by what the refit has found */
static int film_refitted(const refit *r, int i, film *f)
{
    return refit_film(r, &r->block[i], r->u, r->u + place(r, i, r->ncommon), f);
}

/* what the offsets of the refit take away, in units of noise */
static void take_away(const refit *r, int i, double *out)
{
    for (int k = N_OFFSET; k < N_DRIVE; k++) {
        double u = r->u[place(r, i, r->ncommon + k)];
        const double *c = column(r, columns_of(&r->block[i]), r->ncommon + k);
        for (int row = 0; row < r->rows; row++) {
            out[row] -= u * c[row];
        }
    }
}

/* films with the effect; an instrument's errors need no new stroke */
static int show(refit *r, const effect *e)
{
    int status = 0;
    for (int i = 0; i < FIT && status == 0; i++) {
        block *b = &r->block[i];
        film_free(&b->shown);
        if (r->like[i] == i) {
            status = effect_is_instrument(e)
                         ? film_shoot(&b->shown, &b->play, e, &b->at, &r->camera)
                         : film_take(&b->shown, r->w, e, r->w->p, &b->at, &r->camera);
        }
    }
    return status;
}

static int is_moved(const refit *r)
{
    int moved = 0;
    for (size_t k = 0; k < unknowns(r); k++) {
        moved = moved || fabs(r->u[k]) > 0.0;
    }
    return moved;
}

/* films with the effect less films where the refit stands */
static int residual(refit *r)
{
    int moved = is_moved(r);
    for (int i = 0; i < FIT; i++) {
        const block *b = &r->block[i];
        double *out = r->r + (size_t)i * (size_t)r->rows;
        film g = {0, NULL, NULL, 0.0};
        if (r->like[i] < i) {
            memcpy(out, r->r + (size_t)r->like[i] * (size_t)r->rows, sizeof *out * (size_t)r->rows);
            continue;
        }
        if (moved && film_refitted(r, i, &g) != 0) {
            return -1;
        }
        refit_change(r, moved ? &g : &b->base, &b->shown, 1.0, out);
        take_away(r, i, out);
        film_free(&g);
    }
    return 0;
}

/* X'X + 1 (lower half) and X'r of one stroke, added */
static void add_block(const refit *r, int i, gsl_matrix *A, gsl_vector *b)
{
    int n = r->ncommon + OWN;
    const columns *c = columns_of(&r->block[r->like[i]]);
    const double *y = r->r + (size_t)i * (size_t)r->rows;
    for (int j = 0; j < n; j++) {
        if (!r->use[j]) {
            continue;
        }
        *gsl_vector_ptr(b, place(r, i, j)) += inner(column(r, c, j), y, r->rows);
        for (int k = 0; k <= j; k++) {
            if (r->use[k]) {
                *gsl_matrix_ptr(A, place(r, i, j), place(r, i, k)) += c->G[j * n + k];
            }
        }
    }
}

/* RMS of r - X u in the worst channel; u NULL: of r */
static double worst_channel(const refit *r, const gsl_vector *u)
{
    double sum[SEEN] = {0.0}, worst = 0.0;
    int frames = r->rows / r->camera.seen;
    for (int i = 0; i < FIT; i++) {
        const columns *c = columns_of(&r->block[r->like[i]]);
        for (int row = 0; row < r->rows; row++) {
            double x = r->r[(size_t)i * (size_t)r->rows + (size_t)row];
            for (int k = 0; u != NULL && k < r->ncommon + OWN; k++) {
                if (r->use[k]) {
                    x -= column(r, c, k)[row] * gsl_vector_get(u, place(r, i, k));
                }
            }
            sum[row / frames] += x * x;
        }
    }
    for (int j = 0; j < r->camera.seen; j++) {
        worst = fmax(worst, sqrt(sum[j] / (FIT * frames)));
    }
    return worst;
}

/* |r|^2 + |u|^2 */
static double objective(const refit *r)
{
    int readings = FIT * r->rows;
    return inner(r->r, r->r, readings) + inner(r->u, r->u, (int)unknowns(r));
}

/* one step from r->u, the shorter the larger lambda is */
static int step(const refit *r, double lambda, gsl_vector *du)
{
    gsl_matrix *A = gsl_matrix_calloc(unknowns(r), unknowns(r));
    gsl_vector_set_zero(du);
    for (int i = 0; i < FIT; i++) {
        add_block(r, i, A, du);
    }
    for (size_t k = 0; k < unknowns(r); k++) {
        double *diagonal = gsl_matrix_ptr(A, k, k);
        *diagonal = 1.0 + (1.0 + lambda) * *diagonal;
        *gsl_vector_ptr(du, k) -= r->u[k];
    }
    int status = gsl_linalg_cholesky_decomp1(A);
    status = status == 0 ? gsl_linalg_cholesky_svx(A, du) : status;
    gsl_matrix_free(A);
    return status;
}

/* r->u moved by du; @return the objective there, infinite where an action cannot be simulated */
static double go(refit *r, const gsl_vector *du)
{
    for (size_t k = 0; k < unknowns(r); k++) {
        r->u[k] += gsl_vector_get(du, k);
    }
    return residual(r) == 0 ? objective(r) : (double)INFINITY;
}

/* Levenberg and Marquardt from r->u, where the objective is `here` */
static int descend(refit *r, double *objective_here)
{
    size_t readings = (size_t)FIT * (size_t)r->rows;
    gsl_vector *du = gsl_vector_alloc(unknowns(r));
    double *u = malloc(sizeof *u * unknowns(r)), lambda = 0.0, here = *objective_here;
    int status = u != NULL ? 0 : -1, last = 0;
    for (int n = 0; status == 0 && !last && n < STEPS && lambda < shortest; n++) {
        memcpy(u, r->u, sizeof *u * unknowns(r));
        memcpy(r->before, r->r, sizeof *r->r * readings);
        double there = step(r, lambda, du) == 0 ? go(r, du) : (double)INFINITY;
        if (there < here) {
            last = there > (1.0 - settled) * here && lambda < 1.0;
            lambda = lambda > 1e-2 ? 0.1 * lambda : 0.0;
            here = there;
        } else { // it led nowhere: unchanged
            memcpy(r->u, u, sizeof *u * unknowns(r));
            memcpy(r->r, r->before, sizeof *r->r * readings);
            lambda = fmax(10.0 * lambda, 1e-2);
        }
    }
    *objective_here = here;
    free(u);
    gsl_vector_free(du);
    return status;
}

/* the refit begins at the end of the refit of the next smaller amount, in proportion, or with
 * nothing moved if that is nearer; @return the objective there, infinite if neither can be
 * simulated */
static double begin(refit *r, double amount)
{
    size_t readings = (size_t)FIT * (size_t)r->rows;
    memset(r->u, 0, sizeof *r->u * unknowns(r));
    double unmoved = residual(r) == 0 ? objective(r) : (double)INFINITY;
    if (!(fabs(r->amount) > 0.0)) {
        return unmoved;
    }
    memcpy(r->before, r->r, sizeof *r->r * readings);
    for (size_t k = 0; k < unknowns(r); k++) {
        r->u[k] = r->low[k] * amount / r->amount;
    }
    double moved = residual(r) == 0 ? objective(r) : (double)INFINITY;
    if (!(moved < unmoved)) {
        memset(r->u, 0, sizeof *r->u * unknowns(r));
        memcpy(r->r, r->before, sizeof *r->r * readings);
    }
    return fmin(moved, unmoved);
}

int refit_beside(refit *r, const effect *e)
{
    const char *known = outside_limit(e);
    r->known = *e; // its place
    r->known.kind = known != NULL ? effect_find(known) : NULL;
    return known != NULL ? columns_known(r) : 0;
}

void refit_forget(refit *r)
{
    memset(r->low, 0, sizeof *r->low * unknowns(r));
    r->amount = 0.0;
    columns_reset(r);
}

void refit_keep(refit *r, const effect *e)
{
    memcpy(r->low, r->u, sizeof *r->u * unknowns(r));
    r->amount = e->amount;
}

/* does the refit stand far from where its columns were taken; offsets are the same everywhere */
static int is_far(const refit *r)
{
    double far = 0.0;
    for (int i = 0; i < FIT; i++) {
        for (int k = 0; k < r->ncommon + OWN && r->like[i] == i; k++) {
            double from = k < r->ncommon ? r->at[k] : r->block[i].own[k - r->ncommon];
            int is_offset = k >= r->ncommon + N_OFFSET && k < r->ncommon + N_DRIVE;
            far = is_offset ? far : fmax(far, fabs(r->u[place(r, i, k)] - from));
        }
    }
    return far > strayed;
}

int refit_raw(refit *r, const effect *e, double *size)
{
    memset(r->u, 0, sizeof *r->u * unknowns(r));
    int status = show(r, e) == 0 ? residual(r) : -1;
    *size = status == 0 ? worst_channel(r, NULL) : 0.0;
    return status;
}

int refit_is_lost(double size, double target)
{
    return size > lost * target;
}

static int is_in_question(double size, double target)
{
    return size > near * target && !refit_is_lost(size, target);
}

int refit_size(refit *r, const effect *e, double target, double *size)
{
    for (int k = 0; k < r->ncommon + OWN; k++) {
        r->use[k] = allowed(r, e, k);
    }
    double here = show(r, e) == 0 ? begin(r, e->amount) : (double)INFINITY;
    if (!(here < (double)INFINITY) || descend(r, &here) != 0) {
        return -1;
    }
    *size = worst_channel(r, NULL);
    for (int n = 0;
         n < RENEWALS && is_in_question(*size, target) && is_far(r) && columns_renew(r) == 0; n++) {
        double before = here;
        if (residual(r) != 0 || descend(r, &here) != 0) {
            return -1;
        }
        *size = worst_channel(r, NULL);
        if (here > worth * before) {
            break;
        }
    }
    return 0;
}

/* the columns of one stroke into the dense matrix, its readings into y */
static void dense_block(const refit *r, int i, gsl_matrix *X, gsl_vector *y)
{
    const columns *c = columns_of(&r->block[r->like[i]]);
    for (int row = 0; row < r->rows; row++) {
        size_t at = (size_t)(i * r->rows + row);
        gsl_vector_set(y, at, r->r[at]);
        for (int k = 0; k < r->ncommon + OWN; k++) {
            double x = r->use[k] ? column(r, c, k)[row] : 0.0;
            gsl_matrix_set(X, at, place(r, i, k), x);
        }
    }
}

int refit_size_dense(const refit *r, double *size)
{
    size_t n = unknowns(r), rows = (size_t)(FIT * r->rows);
    gsl_matrix *X = gsl_matrix_calloc(rows + n, n), *cov = gsl_matrix_alloc(n, n);
    gsl_vector *y = gsl_vector_calloc(rows + n), *u = gsl_vector_alloc(n);
    gsl_multifit_linear_workspace *w = gsl_multifit_linear_alloc(rows + n, n);
    double chi2;
    for (int i = 0; i < FIT; i++) {
        dense_block(r, i, X, y);
    }
    for (size_t k = 0; k < n; k++) {
        gsl_matrix_set(X, rows + k, k, 1.0); // the priors as rows
        gsl_vector_set(y, rows + k, -r->u[k]);
    }
    int status = gsl_multifit_linear(X, y, u, cov, &chi2, w);
    *size = worst_channel(r, u);
    gsl_multifit_linear_free(w);
    gsl_matrix_free(X);
    gsl_matrix_free(cov);
    gsl_vector_free(y);
    gsl_vector_free(u);
    return status;
}
