/* SPDX-License-Identifier: GPL-3.0-or-later
 * refit.c - the size of an effect: what of it remains in the films after everything else is
 * refitted.
 *
 * Films of the 12 strokes at the true parameters, without scatter and with the standard camera; r
 * is the change of all readings by the effect, each in units of one sample's noise. A refit that is
 * linear moves them by X u, where the columns of X are the changes per prior standard deviation of
 *
 *   common to all strokes   every parameter for which the file states a tolerance
 *   own to each stroke      time of the trigger, one offset a marker, drive, joint friction,
 *                           contact friction (with the scatter of the set as prior)
 *
 * X by differences of films, 0.1 sd to both sides: one-sided ones lead a refit beside its end. With
 * the priors the refit is
 *
 *   u = argmin |r - X u|^2 + |u|^2 = (X'X + 1)^-1 X' r ,     size = RMS(r - X u)
 *
 * taken over the channel where it is largest. An effect that looks like a parameter moves the films
 * by hundreds of noises before the refit and bends them, so one linear step leaves what a fit would
 * not: Gauss-Newton goes on from where the step led,
 *
 *   r = films(effect) - films(moved by u),   (X'X + 1) du = X' r - u
 *
 * with the same X, as long as the size falls. `Everything else`: the effect's own parameter, when
 * it has one, is not refitted - neither are the drive under a wrong load or input, the friction of
 * contacts under a wrong friction, a marker's offset under a wrong offset.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reality.h"

enum {
    MAX_COMMON = 40,
    N_TRIGGER = 0,
    N_OFFSET,
    N_DRIVE = N_OFFSET + SEEN,
    N_JOINTS,
    N_CONTACTS,
    OWN
};

typedef struct block {
    setting at; /* told settings, no scatter */
    film base;
    double *X; /* [ncommon + OWN][rows] columns in units of noise */
} block;

struct refit {
    const world *w;
    const design *d;
    camera camera;
    int ncommon, common[MAX_COMMON]; /* parameter indices */
    int rows;                        /* per stroke: frames times channels */
    block block[FIT];
    double *r; /* [FIT][rows] */
    double *u; /* [unknowns] where the refit stands */
};

enum { STEPS = 5 };
static const double settled = 0.03; /* a step that changes the size by less is the last one */

static double *column(const refit *r, const block *b, int k)
{
    return b->X + (size_t)k * (size_t)r->rows;
}

/* (b - a) times factor, in units of noise, channel after channel */
static void change(const refit *r, const film *a, const film *b, double factor, double *out)
{
    for (int j = 0; j < r->camera.seen; j++) {
        double unit = factor / camera_noise(&r->camera, j);
        for (int i = 0; i < a->n; i++) {
            *out++ = unit * (b->y[i][j] - a->y[i][j]);
        }
    }
}

/* one column by films at some standard deviations of whatever `move` moves, to both sides */
typedef void move_fn(const refit *r, int k, double by, double *p, setting *s);

static void move_common(const refit *r, int k, double by, double *p, setting *s)
{
    (void)s;
    p[r->common[k]] += by * r->w->m->params[r->common[k]].tolerance;
}

static void move_own(const refit *r, int k, double by, double *p, setting *s)
{
    (void)p;
    s->drive += k == N_DRIVE ? by * r->d->drive_scatter : 0.0;
    s->joint_friction += k == N_JOINTS ? by * r->d->joint_scatter : 0.0;
    s->contact_friction += k == N_CONTACTS ? by * r->d->contact_scatter : 0.0;
}

static int film_moved(const refit *r, const block *b, move_fn *move, int k, double by, film *f)
{
    size_t size = sizeof(double) * (size_t)r->w->m->nparam;
    double *p = malloc(size);
    setting s = b->at;
    if (p == NULL) {
        return -1;
    }
    memcpy(p, r->w->p, size);
    move(r, k, by, p, &s);
    int status = film_take(f, r->w, NULL, p, &s, &r->camera);
    free(p);
    return status;
}

static int difference(const refit *r, const block *b, move_fn *move, int k, double *out)
{
    const double by = 0.1;
    film up, down = {0, NULL, NULL, 0.0};
    if (film_moved(r, b, move, k, by, &up) != 0) {
        return -1;
    }
    int status = film_moved(r, b, move, k, -by, &down);
    if (status == 0) {
        change(r, &down, &up, 1.0 / (2.0 * by), out);
    }
    film_free(&up);
    film_free(&down);
    return status;
}

/* columns that need no further film: time and offsets */
static void direct_columns(const refit *r, const block *b)
{
    double frame = 1.0 / r->camera.rate;
    double sd = sqrt(frame * frame / 12.0 + r->d->jitter * r->d->jitter);
    double *time = column(r, b, r->ncommon + N_TRIGGER);
    for (int j = 0; j < r->camera.seen; j++) {
        double noise = camera_noise(&r->camera, j);
        double *offset = column(r, b, r->ncommon + N_OFFSET + j);
        for (int i = 0; i < b->base.n; i++) {
            time[j * b->base.n + i] = -sd * b->base.yd[i][j] / noise;
            offset[j * b->base.n + i] = r->d->marker / (j == 2 ? r->camera.arm : 1.0) / noise;
        }
    }
}

static int fill_block(refit *r, block *b, const setting *s)
{
    static const int moved[] = {N_DRIVE, N_JOINTS, N_CONTACTS};
    b->at = (setting){.dx = s->dx,
                      .load = s->load,
                      .touch = s->touch,
                      .touch_size = s->touch_size,
                      .touch_time = s->touch_time};
    if (film_take(&b->base, r->w, NULL, r->w->p, &b->at, &r->camera) != 0) {
        return -1;
    }
    r->rows = b->base.n * r->camera.seen;
    b->X = calloc((size_t)(r->ncommon + OWN) * (size_t)r->rows, sizeof *b->X);
    int status = b->X != NULL ? 0 : -1;
    for (int k = 0; status == 0 && k < r->ncommon; k++) {
        status = difference(r, b, move_common, k, column(r, b, k));
    }
    for (int k = 0; status == 0 && k < 3; k++) {
        status = difference(r, b, move_own, moved[k], column(r, b, r->ncommon + moved[k]));
    }
    if (status == 0) {
        direct_columns(r, b);
    }
    return status;
}

/* repeats share their columns: the same told settings give the same films */
static int same(const setting *a, const setting *b)
{
    return !(fabs(a->dx - b->dx) > 0.0 || fabs(a->load - b->load) > 0.0 ||
             fabs(a->touch_size - b->touch_size) > 0.0 || a->touch != b->touch);
}

static int copy_block(refit *r, block *b, const block *from)
{
    size_t size = (size_t)(r->ncommon + OWN) * (size_t)r->rows * sizeof *b->X;
    *b = *from;
    b->base.y = b->base.yd = NULL;
    b->X = malloc(size);
    if (b->X == NULL) {
        return -1;
    }
    memcpy(b->X, from->X, size);
    return 0;
}

static const block *first_like(const refit *r, int i)
{
    for (int k = 0; k < i; k++) {
        if (same(&r->d->stroke[k], &r->d->stroke[i])) {
            return &r->block[k];
        }
    }
    return NULL;
}

refit *refit_create(const world *w, const design *d)
{
    refit *r = calloc(1, sizeof *r);
    int status = r != NULL ? 0 : -1;
    if (status == 0) {
        r->w = w;
        r->d = d;
        r->camera = standard_camera;
        r->camera.seen = d->camera.seen;
    }
    for (int i = 0; status == 0 && i < w->m->nparam; i++) {
        if (w->m->params[i].tolerance > 0.0 && r->ncommon < MAX_COMMON) {
            r->common[r->ncommon++] = i;
        }
    }
    for (int i = 0; status == 0 && i < FIT; i++) {
        const block *like = first_like(r, i);
        status = like != NULL ? copy_block(r, &r->block[i], like)
                              : fill_block(r, &r->block[i], &d->stroke[i]);
    }
    if (status == 0) {
        r->r = calloc((size_t)FIT * (size_t)r->rows, sizeof *r->r);
        r->u = calloc((size_t)(r->ncommon + FIT * OWN), sizeof *r->u);
        status = r->r != NULL && r->u != NULL ? 0 : -1;
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
        film_free(&r->block[i].base);
        free(r->block[i].X);
    }
    free(r->r);
    free(r->u);
    free(r);
}

/* ---- projection ---- */

/* is column k one that the refit may use against this effect */
static int allowed(const refit *r, const effect *e, int k)
{
    const char *kind = e->kind->name;
    if (k < r->ncommon) {
        return r->common[k] != effect_own_parameter(e, r->w->m);
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

/* place of column k of stroke i among all unknowns */
static size_t place(const refit *r, int i, int k)
{
    return (size_t)(k < r->ncommon ? k : k + i * OWN);
}

/* film of a stroke without the effect, moved by what the refit has found; offsets and the trigger
 * need no film: `take_away` */
static int film_refitted(const refit *r, int i, film *f)
{
    const block *b = &r->block[i];
    size_t size = sizeof(double) * (size_t)r->w->m->nparam;
    double *p = malloc(size);
    setting s = b->at;
    if (p == NULL) {
        return -1;
    }
    memcpy(p, r->w->p, size);
    for (int k = 0; k < r->ncommon; k++) {
        move_common(r, k, r->u[place(r, i, k)], p, &s);
    }
    for (int k = N_DRIVE; k < OWN; k++) {
        move_own(r, k, r->u[place(r, i, r->ncommon + k)], p, &s);
    }
    int status = film_take(f, r->w, NULL, p, &s, &r->camera);
    free(p);
    return status;
}

/* what trigger and offsets of the refit take away, in units of noise */
static void take_away(const refit *r, int i, double *out)
{
    for (int k = 0; k < N_DRIVE; k++) {
        double u = r->u[place(r, i, r->ncommon + k)];
        const double *c = column(r, &r->block[i], r->ncommon + k);
        for (int row = 0; row < r->rows; row++) {
            out[row] -= u * c[row];
        }
    }
}

/* films with the effect less films where the refit stands */
static int residual(refit *r, const effect *e)
{
    for (int i = 0; i < FIT; i++) {
        block *b = &r->block[i];
        double *out = r->r + (size_t)i * (size_t)r->rows;
        const block *like = first_like(r, i);
        film f, g;
        if (like != NULL) {
            memcpy(out, r->r + (size_t)(like - r->block) * (size_t)r->rows,
                   sizeof *out * (size_t)r->rows);
            continue;
        }
        if (film_take(&f, r->w, e, r->w->p, &b->at, &r->camera) != 0) {
            return -1;
        }
        int status = film_refitted(r, i, &g);
        if (status == 0) {
            change(r, &g, &f, 1.0, out);
            take_away(r, i, out);
            film_free(&g);
        }
        film_free(&f);
        if (status != 0) {
            return -1;
        }
    }
    return 0;
}

static double inner(const double *a, const double *b, int n)
{
    double s = 0.0;
    for (int i = 0; i < n; i++) {
        s += a[i] * b[i];
    }
    return s;
}

/* X'X + 1 and X'r of one stroke, added */
static void add_block(const refit *r, const effect *e, int i, gsl_matrix *A, gsl_vector *b)
{
    int n = r->ncommon + OWN;
    const double *y = r->r + (size_t)i * (size_t)r->rows;
    for (int j = 0; j < n; j++) {
        if (!allowed(r, e, j)) {
            continue;
        }
        const double *cj = column(r, &r->block[i], j);
        *gsl_vector_ptr(b, place(r, i, j)) += inner(cj, y, r->rows);
        for (int k = 0; k < n; k++) {
            if (allowed(r, e, k)) {
                *gsl_matrix_ptr(A, place(r, i, j), place(r, i, k)) +=
                    inner(cj, column(r, &r->block[i], k), r->rows);
            }
        }
    }
}

/* RMS of r - X u in the worst channel */
static double worst_channel(const refit *r, const effect *e, const gsl_vector *u)
{
    double sum[SEEN] = {0.0}, worst = 0.0;
    int frames = r->rows / r->camera.seen;
    for (int i = 0; i < FIT; i++) {
        for (int row = 0; row < r->rows; row++) {
            double x = r->r[(size_t)i * (size_t)r->rows + (size_t)row];
            for (int k = 0; k < r->ncommon + OWN; k++) {
                if (allowed(r, e, k)) {
                    x -= column(r, &r->block[i], k)[row] * gsl_vector_get(u, place(r, i, k));
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

/* one step from r->u: du out, and the size it predicts */
static int step(const refit *r, const effect *e, gsl_vector *du, double *size)
{
    gsl_matrix *A = gsl_matrix_alloc(unknowns(r), unknowns(r));
    gsl_matrix_set_identity(A);
    gsl_vector_set_zero(du);
    for (int i = 0; i < FIT; i++) {
        add_block(r, e, i, A, du);
    }
    for (size_t k = 0; k < unknowns(r); k++) {
        *gsl_vector_ptr(du, k) -= r->u[k];
    }
    int status = gsl_linalg_cholesky_decomp1(A);
    if (status == 0) {
        status = gsl_linalg_cholesky_svx(A, du);
        *size = worst_channel(r, e, du);
    }
    gsl_matrix_free(A);
    return status;
}

int refit_size(refit *r, const effect *e, double *size)
{
    memset(r->u, 0, sizeof *r->u * unknowns(r));
    if (residual(r, e) != 0) {
        return -1;
    }
    gsl_vector *du = gsl_vector_alloc(unknowns(r));
    double *before = malloc(sizeof *before * unknowns(r));
    int status = before != NULL ? step(r, e, du, size) : -1;
    for (int n = 0; status == 0 && n < STEPS; n++) {
        double next;
        memcpy(before, r->u, sizeof *before * unknowns(r));
        for (size_t k = 0; k < unknowns(r); k++) {
            r->u[k] += gsl_vector_get(du, k);
        }
        if (residual(r, e) != 0 || step(r, e, du, &next) != 0 || !(next < *size)) {
            memcpy(r->u, before, sizeof *before * unknowns(r)); // it led nowhere: as it was
            status = residual(r, e);
            break;
        }
        int last = next > (1.0 - settled) * *size;
        *size = next;
        if (last) {
            break;
        }
    }
    free(before);
    gsl_vector_free(du);
    return status;
}

/* the columns of one stroke into the dense matrix, its readings into y */
static void dense_block(const refit *r, const effect *e, int i, gsl_matrix *X, gsl_vector *y)
{
    for (int row = 0; row < r->rows; row++) {
        size_t at = (size_t)(i * r->rows + row);
        gsl_vector_set(y, at, r->r[at]);
        for (int k = 0; k < r->ncommon + OWN; k++) {
            double x = allowed(r, e, k) ? column(r, &r->block[i], k)[row] : 0.0;
            gsl_matrix_set(X, at, place(r, i, k), x);
        }
    }
}

int refit_size_dense(refit *r, const effect *e, double *size)
{
    size_t n = unknowns(r), rows = (size_t)(FIT * r->rows);
    if (refit_size(r, e, size) != 0) { // leaves the refit where its last step begins
        return -1;
    }
    gsl_matrix *X = gsl_matrix_calloc(rows + n, n), *cov = gsl_matrix_alloc(n, n);
    gsl_vector *y = gsl_vector_calloc(rows + n), *u = gsl_vector_alloc(n);
    gsl_multifit_linear_workspace *w = gsl_multifit_linear_alloc(rows + n, n);
    double chi2;
    for (int i = 0; i < FIT; i++) {
        dense_block(r, e, i, X, y);
    }
    for (size_t k = 0; k < n; k++) {
        gsl_matrix_set(X, rows + k, k, 1.0); // the priors as rows
        gsl_vector_set(y, rows + k, -r->u[k]);
    }
    int status = gsl_multifit_linear(X, y, u, cov, &chi2, w);
    *size = worst_channel(r, e, u);
    gsl_multifit_linear_free(w);
    gsl_matrix_free(X);
    gsl_matrix_free(cov);
    gsl_vector_free(y);
    gsl_vector_free(u);
    return status;
}

/* ---- scaling ---- */

static const double close_enough = 0.02;
enum { MAX_TRIES = 14 };

typedef struct bracket {
    double low, high; /* amounts known to be too small, too large; high 0: none yet */
    double a0, m0;    /* last try */
} bracket;

/* the next amount: secant in logarithms, kept inside what is known (halved there if it leaves) */
static double next_amount(const bracket *b, double a, double m, double target)
{
    double slope = 1.0;
    if (b->m0 > 0.0 && fabs(log(a / b->a0)) > 1e-6) {
        slope = log(m / b->m0) / log(a / b->a0);
        slope = slope > 0.3 && slope < 4.0 ? slope : 1.0;
    }
    double next = m > 0.0 ? a * fmin(fmax(pow(target / m, 1.0 / slope), 0.02), 20.0) : 20.0 * a;
    if (b->high > 0.0 && b->low > 0.0 && !(next > b->low && next < b->high)) {
        next = sqrt(b->low * b->high);
    }
    return next;
}

int refit_scale(refit *r, effect *e, double target, double *reached)
{
    double sign = e->amount < 0.0 ? -1.0 : 1.0, limit = 1.0, a = 0.05;
    bracket b = {0.0, 0.0, 0.0, 0.0};
    for (int n = 0; n < MAX_TRIES; n++) {
        double m;
        e->amount = sign * a;
        if (refit_size(r, e, &m) != 0) { // the action does not survive that much
            limit = 0.7 * a;
            a = 0.5 * limit;
            continue;
        }
        *reached = m;
        if (fabs(m / target - 1.0) < close_enough) {
            return 0;
        }
        if (m < target && a >= limit) {
            return 1;
        }
        b.low = m < target ? a : b.low;
        b.high = m > target ? a : b.high;
        double next = next_amount(&b, a, m, target);
        b.a0 = a;
        b.m0 = m;
        a = fmin(next, limit);
    }
    return 1;
}
