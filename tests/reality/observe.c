/* SPDX-License-Identifier: GPL-3.0-or-later
 * observe.c - the stroke as instruments without noise would film it.
 *
 * The frame recorded at time t was taken at T = (1 + clock) t - trigger after the release; marker c
 * shows the channel at T - delay_c, with the instrument's own errors:
 *
 *   y + gain y + square (y - y at rest)^2 + tilt (x - x at rest) + offset
 */
#include <stdlib.h>
#include <string.h>

#include "reality.h"

static const double grid = 1e-4;
static const effect nothing = {.kind = NULL};

int film_frames(const camera *c)
{
    return (int)((c->until + c->before) * c->rate + 1.5);
}

void film_free(film *f)
{
    free(f->y);
    free(f->yd);
    f->y = f->yd = NULL;
}

/* the action of one stroke: told settings, scatter, effect */
static int make_action(action *a, const world *w, const effect *e, const double *p,
                       const setting *s)
{
    double *own = malloc(sizeof *own * (size_t)w->m->nparam);
    int dx = mech_find_param(w->m, "pawl.stop_shift", NULL);
    int load = mech_find_param(w->m, "load.mass", NULL);
    if (own == NULL || dx < 0 || load < 0) {
        free(own);
        return -1;
    }
    memcpy(own, p, sizeof *own * (size_t)w->m->nparam);
    own[dx] = s->dx;
    own[load] = s->load;
    for (int i = 0; i < s->nset; i++) {
        own[s->set[i].param] = s->set[i].value;
    }
    for (const effect *one = e; one != NULL; one = one->also) {
        effect_on_parameters(one, w->m, own);
    }
    int status = parts_fill(a, w->m, own);
    free(own);
    for (int i = 0; i < JOINTS; i++) {
        a->joint[i].friction.A *= 1.0 + s->joint_friction;
    }
    for (int i = 0; i < CONTACTS; i++) {
        a->felt[i].friction.A *= 1.0 + s->contact_friction;
    }
    a->drive = s->touch;
    a->drive_size = s->touch_size;
    a->drive_time = s->touch > 0 ? s->touch_time : 1.0;
    a->drive_back = s->touch_back;
    if (s->touch > 0) {
        a->drive_gain *= 1.0 + s->drive;
    } else {
        a->load_mass *= 1.0 + s->drive;
    }
    for (const effect *one = e; one != NULL; one = one->also) {
        effect_on_action(one, a);
    }
    a->wire_k = s->off[OFF_WIRE] ? 0.0 : a->wire_k;
    if (s->off[OFF_DAMPER]) {
        a->damper_force = a->damper_k = 0.0;
    }
    return status;
}

static void look(film *f, const stroke *k, const setting *s, const camera *c, const sensor *ideal,
                 double clock)
{
    static const int channel[SEEN] = {C_STRING, C_DIP, C_HAMMER};
    static const int sideways[SEEN] = {C_HEAD_X, C_FRONT_X, C_HEAD_X};
    for (int i = 0; i < f->n; i++) {
        double t = (1.0 + clock) * (i / c->rate - c->before) - s->trigger;
        for (int j = 0; j < SEEN; j++) {
            double T = t - ideal[j].delay, slope, x_slope;
            double y = stroke_at(k, channel[j], T, &slope);
            double x = stroke_at(k, sideways[j], T, &x_slope) - k->y[0][sideways[j]];
            double way = y - k->y[0][channel[j]];
            f->y[i][j] = y * (1.0 + ideal[j].gain) + ideal[j].square * way * way +
                         ideal[j].tilt * x + ideal[j].offset + s->offset[j];
            f->yd[i][j] = slope * (1.0 + ideal[j].gain) + ideal[j].tilt * x_slope;
        }
    }
}

int film_play(stroke *k, const world *w, const effect *e, const double *p, const setting *s,
              const camera *c)
{
    action a;
    return make_action(&a, w, e != NULL ? e : &nothing, p, s) != 0
               ? -1
               : stroke_run(k, &a, 1.05 * c->until + 0.002, grid, c->accuracy);
}

int film_shoot(film *f, const stroke *k, const effect *e, const setting *s, const camera *c)
{
    sensor ideal[SEEN];
    double clock;
    f->n = film_frames(c);
    f->y = calloc((size_t)f->n, sizeof *f->y);
    f->yd = calloc((size_t)f->n, sizeof *f->yd);
    if (f->y == NULL || f->yd == NULL) {
        film_free(f);
        return -1;
    }
    effect_on_sensors(e != NULL ? e : &nothing, ideal, &clock);
    look(f, k, s, c, ideal, clock);
    f->key_rest = k->key_rest;
    return 0;
}

int film_take(film *f, const world *w, const effect *e, const double *p, const setting *s,
              const camera *c)
{
    stroke k;
    if (film_play(&k, w, e, p, s, c) != 0) {
        f->y = f->yd = NULL;
        return -1;
    }
    int status = film_shoot(f, &k, e, s, c);
    stroke_free(&k);
    return status;
}
