/* SPDX-License-Identifier: GPL-3.0-or-later
 * columns.c - what every number but the effect does to the films (X of refit.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "refit.h"

static const double known_sd = 0.5; /* of the known law, in its limit */

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
    effect known = r->known;
    if (p == NULL) {
        f->y = f->yd = NULL;
        return -1;
    }
    memcpy(p, r->w->p, size);
    for (int k = 0; k < r->nparam; k++) {
        p[r->common[k]] += common[k] * r->w->m->params[r->common[k]].tolerance;
    }
    known.amount = known_sd * common[r->nparam];
    s.trigger += own[N_TRIGGER] * trigger_sd(r);
    s.drive += own[N_DRIVE] * r->d->drive_scatter;
    s.joint_friction += own[N_JOINTS] * r->d->joint_scatter;
    s.contact_friction += own[N_CONTACTS] * r->d->contact_scatter;
    int status = film_take(f, r->w, known.kind != NULL ? &known : NULL, p, &s, &r->camera);
    free(p);
    return status;
}

/* numbers of one stroke, in prior sd */
typedef struct numbers {
    double common[MAX_COMMON], own[OWN];
} numbers;

/* one column by films 0.1 sd to both sides: with one-sided ones a refit ends beside its minimum.
 * Where the refit is on its way (f: the film there) they do, and cost half. */
static int difference(const refit *r, const block *b, numbers at, int k, const film *f, double *out)
{
    const double by = f != NULL ? 0.02 : 0.1;
    double *moved = k < r->ncommon ? &at.common[k] : &at.own[k - r->ncommon], here = *moved;
    film up, down = {0, NULL, NULL, 0.0};
    *moved = here + by;
    if (refit_film(r, b, at.common, at.own, &up) != 0) {
        return -1;
    }
    *moved = here - by;
    int status = f != NULL ? 0 : refit_film(r, b, at.common, at.own, &down);
    if (status == 0) {
        refit_change(r, f != NULL ? f : &down, &up, f != NULL ? 1.0 / by : 0.5 / by, out);
    }
    film_free(&up);
    film_free(&down);
    return status;
}

/* columns that need no further film: time and offsets */
static void direct_columns(const refit *r, const film *f, columns *c)
{
    double sd = trigger_sd(r);
    double *time = column(r, c, r->ncommon + N_TRIGGER);
    for (int j = 0; j < r->camera.seen; j++) {
        double noise = camera_noise(&r->camera, j);
        double *offset = column(r, c, r->ncommon + N_OFFSET + j);
        for (int i = 0; i < f->n; i++) {
            time[j * f->n + i] = -sd * f->yd[i][j] / noise;
            offset[j * f->n + i] = r->d->marker / (j == 2 ? r->camera.arm : 1.0) / noise;
        }
    }
}

static void products(const refit *r, columns *c)
{
    int n = r->ncommon + OWN;
    for (int j = 0; j < n; j++) {
        for (int k = 0; k <= j; k++) {
            c->G[j * n + k] = inner(column(r, c, j), column(r, c, k), r->rows);
        }
    }
}

static void drop(columns *c)
{
    free(c->X);
    free(c->G);
    *c = (columns){NULL, NULL};
}

/* X and G of one stroke; `is_first`: where all numbers are zero. @return 0, -1: there are none */
static int take(const refit *r, const block *b, const numbers *at, int is_first, columns *c)
{
    static const int moved[] = {N_DRIVE, N_JOINTS, N_CONTACTS};
    size_t n = (size_t)(r->ncommon + OWN);
    film f = {0, NULL, NULL, 0.0};
    c->X = calloc(n * (size_t)r->rows, sizeof *c->X);
    c->G = calloc(n * n, sizeof *c->G);
    int status = c->X != NULL && c->G != NULL ? refit_film(r, b, at->common, at->own, &f) : -1;
    if (status == 0) {
        direct_columns(r, &f, c);
    }
    int common = r->nparam + (r->known.kind != NULL);
    for (int i = 0; status == 0 && i < common + 3; i++) {
        int k = i < common ? i : r->ncommon + moved[i - common];
        status = difference(r, b, *at, k, is_first ? NULL : &f, column(r, c, k));
    }
    if (status == 0) {
        products(r, c);
    } else {
        drop(c);
    }
    film_free(&f);
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
        if (take(r, b, &(numbers){{0.0}, {0.0}}, 1, &b->first) != 0) {
            return -1;
        }
    }
    return 0;
}

int columns_known(refit *r)
{
    const numbers none = {{0.0}, {0.0}};
    int status = 0;
    for (int i = 0; status == 0 && i < FIT; i++) {
        block *b = &r->block[i];
        if (r->like[i] == i) {
            status = difference(r, b, none, r->nparam, NULL, column(r, &b->first, r->nparam));
            products(r, &b->first);
        }
    }
    return status;
}

int columns_renew(refit *r)
{
    columns fresh[FIT] = {{NULL, NULL}};
    numbers at[FIT];
    int status = 0;
    for (int i = 0; i < FIT && status == 0; i++) {
        memcpy(at[i].common, r->u, sizeof *r->u * (size_t)r->ncommon);
        memcpy(at[i].own, r->u + place(r, i, r->ncommon), sizeof at[i].own);
        status = r->like[i] == i ? take(r, &r->block[i], &at[i], 0, &fresh[i]) : 0;
    }
    for (int i = 0; i < FIT; i++) {
        block *b = &r->block[i];
        if (status == 0) {
            drop(&b->renewed);
            b->renewed = fresh[i];
            memcpy(b->own, at[i].own, sizeof b->own);
        } else {
            drop(&fresh[i]);
        }
    }
    if (status == 0) {
        memcpy(r->at, r->u, sizeof *r->at * (size_t)r->ncommon);
    }
    return status;
}

void columns_reset(refit *r)
{
    memset(r->at, 0, sizeof r->at);
    for (int i = 0; i < FIT; i++) {
        memset(r->block[i].own, 0, sizeof r->block[i].own);
        drop(&r->block[i].renewed);
    }
}

void columns_free(block *b)
{
    drop(&b->renewed);
    drop(&b->first);
    stroke_free(&b->play);
    film_free(&b->base);
    film_free(&b->shown);
}
