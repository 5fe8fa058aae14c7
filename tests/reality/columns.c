/* SPDX-License-Identifier: GPL-3.0-or-later
 * columns.c - what every number but the effect does to the films (X of refit.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "refit.h"

void refit_change(const refit *r, const film *a, const film *b, double factor, double *out)
{
    for (int j = 0; j < r->camera.seen; j++) {
        double unit = factor / camera_noise(&r->camera, j);
        for (int i = 0; i < a->n; i++) {
            *out++ = unit * (b->y[i][j] - a->y[i][j]);
        }
    }
}

static double trigger_sd(const refit *r)
{
    double frame = 1.0 / r->camera.rate;
    return sqrt(frame * frame / 12.0 + r->d->jitter * r->d->jitter);
}

int refit_film(const refit *r, const block *b, const double *common, const double *own, film *f)
{
    size_t size = sizeof(double) * (size_t)r->w->m->nparam;
    double *p = malloc(size);
    setting s = b->at;
    if (p == NULL) {
        f->y = f->yd = NULL;
        return -1;
    }
    memcpy(p, r->w->p, size);
    for (int k = 0; k < r->ncommon; k++) {
        p[r->common[k]] += common[k] * r->w->m->params[r->common[k]].tolerance;
    }
    s.trigger += own[N_TRIGGER] * trigger_sd(r);
    s.drive += own[N_DRIVE] * r->d->drive_scatter;
    s.joint_friction += own[N_JOINTS] * r->d->joint_scatter;
    s.contact_friction += own[N_CONTACTS] * r->d->contact_scatter;
    int status = film_take(f, r->w, NULL, p, &s, &r->camera);
    free(p);
    return status;
}

/* one column by films 0.1 sd to both sides: one-sided ones lead a refit beside its end. Where the
 * refit is on its way (f: the film there) they do, and cost half. */
static int difference(const refit *r, const block *b, int k, const film *f)
{
    const double by = f != NULL ? 0.02 : 0.1;
    double common[MAX_COMMON], own[OWN];
    memcpy(common, r->at, sizeof common);
    memcpy(own, b->own, sizeof own);
    double *moved = k < r->ncommon ? &common[k] : &own[k - r->ncommon], here = *moved;
    film up, down = {0, NULL, NULL, 0.0};
    *moved = here + by;
    if (refit_film(r, b, common, own, &up) != 0) {
        return -1;
    }
    *moved = here - by;
    int status = f != NULL ? 0 : refit_film(r, b, common, own, &down);
    if (status == 0) {
        refit_change(r, f != NULL ? f : &down, &up, f != NULL ? 1.0 / by : 0.5 / by,
                     column(r, b, k));
    }
    film_free(&up);
    film_free(&down);
    return status;
}

/* columns that need no further film: time and offsets */
static void direct_columns(const refit *r, const block *b, const film *f)
{
    double sd = trigger_sd(r);
    double *time = column(r, b, r->ncommon + N_TRIGGER);
    for (int j = 0; j < r->camera.seen; j++) {
        double noise = camera_noise(&r->camera, j);
        double *offset = column(r, b, r->ncommon + N_OFFSET + j);
        for (int i = 0; i < f->n; i++) {
            time[j * f->n + i] = -sd * f->yd[i][j] / noise;
            offset[j * f->n + i] = r->d->marker / (j == 2 ? r->camera.arm : 1.0) / noise;
        }
    }
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

/* X and G of one stroke at r->at and b->own; `first`: where both are zero */
static int take_columns(const refit *r, block *b, int first)
{
    static const int moved[] = {N_DRIVE, N_JOINTS, N_CONTACTS};
    size_t n = (size_t)(r->ncommon + OWN);
    film f;
    b->X = calloc(n * (size_t)r->rows, sizeof *b->X);
    b->G = calloc(n * n, sizeof *b->G);
    int status = b->X != NULL && b->G != NULL ? refit_film(r, b, r->at, b->own, &f) : -1;
    int filmed = status == 0;
    if (status == 0) {
        direct_columns(r, b, &f);
    }
    for (int k = 0; status == 0 && k < r->ncommon; k++) {
        status = difference(r, b, k, first ? NULL : &f);
    }
    for (int k = 0; status == 0 && k < 3; k++) {
        status = difference(r, b, r->ncommon + moved[k], first ? NULL : &f);
    }
    if (status == 0) {
        products(r, b);
    }
    if (filmed) {
        film_free(&f);
    }
    return status;
}

static void back_to_first(block *b)
{
    if (b->X != b->X0) {
        free(b->X);
        free(b->G);
    }
    b->X = b->X0;
    b->G = b->G0;
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

int columns_create(refit *r)
{
    for (int i = 0; i < FIT; i++) {
        block *b = &r->block[i];
        const setting *s = &r->d->stroke[i];
        r->like[i] = first_like(r->d, i);
        if (r->like[i] < i) {
            continue;
        }
        b->at = (setting){.dx = s->dx,
                          .load = s->load,
                          .touch = s->touch,
                          .touch_size = s->touch_size,
                          .touch_time = s->touch_time};
        if (film_play(&b->play, r->w, NULL, r->w->p, &b->at, &r->camera) != 0 ||
            film_shoot(&b->base, &b->play, NULL, &b->at, &r->camera) != 0) {
            return -1;
        }
        r->rows = b->base.n * r->camera.seen;
        int status = take_columns(r, b, 1);
        b->X0 = b->X;
        b->G0 = b->G;
        if (status != 0) {
            return -1;
        }
    }
    return 0;
}

int columns_renew(refit *r)
{
    double *X[FIT], *G[FIT];
    int status = 0;
    for (int i = 0; i < FIT; i++) {
        X[i] = r->block[i].X;
        G[i] = r->block[i].G;
        if (r->like[i] == i && status == 0) {
            status = take_columns(r, &r->block[i], 0);
        }
    }
    for (int i = 0; i < FIT; i++) {
        block *b = &r->block[i], old = {.X = X[i], .G = G[i], .X0 = b->X0, .G0 = b->G0};
        if (status == 0) {
            back_to_first(&old);
        } else if (b->X != X[i]) {
            free(b->X);
            free(b->G);
            b->X = X[i];
            b->G = G[i];
        }
    }
    return status;
}

void columns_reset(refit *r)
{
    memset(r->at, 0, sizeof r->at);
    for (int i = 0; i < FIT; i++) {
        memset(r->block[i].own, 0, sizeof r->block[i].own);
        back_to_first(&r->block[i]);
    }
}

void columns_free(block *b)
{
    back_to_first(b);
    free(b->X0);
    free(b->G0);
    stroke_free(&b->play);
    film_free(&b->base);
    film_free(&b->shown);
}
