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
    setting at;  /* told settings, no scatter */
    stroke play; /* without effect at the true parameters */
    film base;   /* what is seen of it */
    film shown;  /* the same with the effect in question */
    double *X;   /* [ncommon + OWN][rows] columns in units of noise */
    double *G;   /* [ncommon + OWN][ncommon + OWN] X'X, lower half */
} block;

struct refit {
    const world *w;
    const design *d;
    camera camera;
    int ncommon, common[MAX_COMMON]; /* parameter indices */
    int rows;                        /* per stroke: frames times channels */
    int like[FIT];                   /* repeats share films and columns: the first such stroke */
    block block[FIT];                /* of the first ones */
    int use[MAX_COMMON + OWN];       /* columns that may be used against the effect */
    double *r, *kept;                /* [FIT][rows] residuals, and those before a step */
    double *u;                       /* [unknowns] where the refit stands */
};

enum { STEPS = 5 };
/* films good to 10 nm: a thousandth of the noise */
static const double accurate_enough = 1e-8;
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

static double inner(const double *a, const double *b, int n)
{
    double s = 0.0;
    for (int i = 0; i < n; i++) {
        s += a[i] * b[i];
    }
    return s;
}

static void products(const refit *r, block *b)
{
    int n = r->ncommon + OWN;
    for (int j = 0; j < n; j++) {
        for (int k = 0; k <= j; k++) {
            b->G[j * n + k] = inner(column(r, b, j), column(r, b, k), r->rows);
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
    size_t n = (size_t)(r->ncommon + OWN);
    if (film_play(&b->play, r->w, NULL, r->w->p, &b->at, &r->camera) != 0 ||
        film_shoot(&b->base, &b->play, NULL, &b->at, &r->camera) != 0) {
        return -1;
    }
    r->rows = b->base.n * r->camera.seen;
    b->X = calloc(n * (size_t)r->rows, sizeof *b->X);
    b->G = calloc(n * n, sizeof *b->G);
    int status = b->X != NULL && b->G != NULL ? 0 : -1;
    for (int k = 0; status == 0 && k < r->ncommon; k++) {
        status = difference(r, b, move_common, k, column(r, b, k));
    }
    for (int k = 0; status == 0 && k < 3; k++) {
        status = difference(r, b, move_own, moved[k], column(r, b, r->ncommon + moved[k]));
    }
    if (status == 0) {
        direct_columns(r, b);
        products(r, b);
    }
    return status;
}

/* repeats share their columns: the same told settings give the same films */
static int same(const setting *a, const setting *b)
{
    return !(fabs(a->dx - b->dx) > 0.0 || fabs(a->load - b->load) > 0.0 ||
             fabs(a->touch_size - b->touch_size) > 0.0 || a->touch != b->touch);
}

static int first_like(const design *d, int i)
{
    for (int k = 0; k < i; k++) {
        if (same(&d->stroke[k], &d->stroke[i])) {
            return k;
        }
    }
    return i;
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
        r->camera.accuracy = accurate_enough;
    }
    for (int i = 0; status == 0 && i < w->m->nparam; i++) {
        if (w->m->params[i].tolerance > 0.0 && r->ncommon < MAX_COMMON) {
            r->common[r->ncommon++] = i;
        }
    }
    for (int i = 0; status == 0 && i < FIT; i++) {
        r->like[i] = first_like(d, i);
        status = r->like[i] < i ? 0 : fill_block(r, &r->block[i], &d->stroke[i]);
    }
    if (status == 0) {
        r->r = calloc((size_t)FIT * (size_t)r->rows, sizeof *r->r);
        r->kept = calloc((size_t)FIT * (size_t)r->rows, sizeof *r->kept);
        r->u = calloc((size_t)(r->ncommon + FIT * OWN), sizeof *r->u);
        status = r->r != NULL && r->kept != NULL && r->u != NULL ? 0 : -1;
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
        stroke_free(&r->block[i].play);
        film_free(&r->block[i].base);
        film_free(&r->block[i].shown);
        free(r->block[i].X);
        free(r->block[i].G);
    }
    free(r->r);
    free(r->kept);
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
        change(r, moved ? &g : &b->base, &b->shown, 1.0, out);
        take_away(r, i, out);
        film_free(&g);
    }
    return 0;
}

/* X'X + 1 (lower half) and X'r of one stroke, added */
static void add_block(const refit *r, int i, gsl_matrix *A, gsl_vector *b)
{
    int n = r->ncommon + OWN;
    const block *like = &r->block[r->like[i]];
    const double *y = r->r + (size_t)i * (size_t)r->rows;
    for (int j = 0; j < n; j++) {
        if (!r->use[j]) {
            continue;
        }
        *gsl_vector_ptr(b, place(r, i, j)) += inner(column(r, like, j), y, r->rows);
        for (int k = 0; k <= j; k++) {
            if (r->use[k]) {
                *gsl_matrix_ptr(A, place(r, i, j), place(r, i, k)) += like->G[j * n + k];
            }
        }
    }
}

/* RMS of r - X u in the worst channel */
static double worst_channel(const refit *r, const gsl_vector *u)
{
    double sum[SEEN] = {0.0}, worst = 0.0;
    int frames = r->rows / r->camera.seen;
    for (int i = 0; i < FIT; i++) {
        for (int row = 0; row < r->rows; row++) {
            double x = r->r[(size_t)i * (size_t)r->rows + (size_t)row];
            for (int k = 0; k < r->ncommon + OWN; k++) {
                if (r->use[k]) {
                    x -= column(r, &r->block[r->like[i]], k)[row] *
                         gsl_vector_get(u, place(r, i, k));
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
static int step(const refit *r, gsl_vector *du, double *size)
{
    gsl_matrix *A = gsl_matrix_alloc(unknowns(r), unknowns(r));
    gsl_matrix_set_identity(A);
    gsl_vector_set_zero(du);
    for (int i = 0; i < FIT; i++) {
        add_block(r, i, A, du);
    }
    for (size_t k = 0; k < unknowns(r); k++) {
        *gsl_vector_ptr(du, k) -= r->u[k];
    }
    int status = gsl_linalg_cholesky_decomp1(A);
    if (status == 0) {
        status = gsl_linalg_cholesky_svx(A, du);
        *size = worst_channel(r, du);
    }
    gsl_matrix_free(A);
    return status;
}

int refit_size(refit *r, const effect *e, double *size)
{
    size_t readings = (size_t)FIT * (size_t)r->rows;
    memset(r->u, 0, sizeof *r->u * unknowns(r));
    for (int k = 0; k < r->ncommon + OWN; k++) {
        r->use[k] = allowed(r, e, k);
    }
    if (show(r, e) != 0 || residual(r) != 0) {
        return -1;
    }
    gsl_vector *du = gsl_vector_alloc(unknowns(r));
    double *before = malloc(sizeof *before * unknowns(r));
    int status = before != NULL ? step(r, du, size) : -1;
    for (int n = 0; status == 0 && n < STEPS; n++) {
        double next;
        memcpy(before, r->u, sizeof *before * unknowns(r));
        memcpy(r->kept, r->r, sizeof *r->r * readings);
        for (size_t k = 0; k < unknowns(r); k++) {
            r->u[k] += gsl_vector_get(du, k);
        }
        if (residual(r) != 0 || step(r, du, &next) != 0 || !(next < *size)) {
            memcpy(r->u, before, sizeof *before * unknowns(r)); // it led nowhere: as it was
            memcpy(r->r, r->kept, sizeof *r->r * readings);
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
static void dense_block(const refit *r, int i, gsl_matrix *X, gsl_vector *y)
{
    for (int row = 0; row < r->rows; row++) {
        size_t at = (size_t)(i * r->rows + row);
        gsl_vector_set(y, at, r->r[at]);
        for (int k = 0; k < r->ncommon + OWN; k++) {
            double x = r->use[k] ? column(r, &r->block[r->like[i]], k)[row] : 0.0;
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
