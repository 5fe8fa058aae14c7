/* SPDX-License-Identifier: GPL-3.0-or-later
 * horizon.c - how far ahead a stroke can be predicted from its initial state.
 *
 * A small change of one initial position, and what becomes of it: growth(t) = |dy(t)| / |dy(0)|,
 * the norm taken over the channels that show places, each in units of its noise, and the largest of
 * all positions so far. In regular motion it grows with t, as the frequency depends on the
 * amplitude; in chaotic motion it grows with exp(lambda t), lambda the largest Lyapunov exponent
 * (Benettin et al., Meccanica 15 (1980) 9-20: the same from two neighbouring trajectories).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

static const double change = 1e-7; /* of an initial position [rad or m] */

typedef struct growing {
    const fit__problem *p;
    double by;
    fit__horizon *of;
} growing;

static int is_position(const fit__problem *p, const fit__unknown *u)
{
    const char *name =
        u->kind == FIT__SETTING ? lab_equations(p->model)->params[u->index].name : "";
    return u->kind == FIT__POSITION || strstr(name, ".initial.position") != NULL;
}

/* size of a change of all places at sample i, in noises */
static double size_of(const fit__problem *p, const fit__stroke *s, const double *a, const double *b,
                      int i)
{
    double sum = 0.0;
    for (int c = 0; c < s->nch; c++) {
        const stein_channel *channel = &lab_equations(p->model)->channels[s->channel[c]];
        double d = (a[c * s->n + i] - b[c * s->n + i]) / s->noise[c];
        sum += fit__shows_place(channel) && isfinite(s->y[c * s->n + i]) ? d * d : 0.0;
    }
    return sqrt(sum);
}

/* the growth of one change, from predictions with and without it */
static void follow(const growing *g, int stroke, const double *with, const double *without)
{
    const fit__stroke *s = &g->p->stroke[stroke];
    fit__horizon *h = &g->of[stroke];
    double first = 0.0;
    for (int i = 0; i < s->n; i++) {
        double size = size_of(g->p, s, with, without, i), t = s->data->time[i] - s->data->time[0];
        first = first > 0.0 ? first : size;
        h->growth = first > 0.0 ? fmax(h->growth, size / first) : h->growth;
        if (size > g->by * first && t < h->time) {
            h->time = t;
        }
    }
}

static int has_position(const fit__problem *p, const fit__stroke *s)
{
    int yes = 0;
    for (int k = s->first; k < s->first + s->own; k++) {
        yes |= is_position(p, &p->unknown[k]);
    }
    return yes;
}

static void measure(void *ctx, fit__bench *b, int stroke)
{
    const growing *g = ctx;
    const fit__stroke *s = &g->p->stroke[stroke];
    if (!has_position(g->p, s)) {
        return;
    }
    size_t rows = (size_t)s->nch * (size_t)s->n;
    double *without = malloc(sizeof *without * (rows + 1));
    b->no_memory |= without == NULL;
    memset(b->x, 0, sizeof *b->x * (size_t)g->p->nu);
    int ok = without != NULL && fit__simulate(g->p, b, stroke, b->x, without, NULL) == STEIN_OK;
    for (int k = s->first; ok && k < s->first + s->own; k++) {
        const fit__unknown *u = &g->p->unknown[k];
        if (!is_position(g->p, u)) {
            continue;
        }
        b->x[k] = change / u->sd;
        if (fit__simulate(g->p, b, stroke, b->x, b->y, NULL) == STEIN_OK) {
            follow(g, stroke, b->y, without);
        }
        b->x[k] = 0.0;
    }
    free(without);
}

stein_status fit__horizons(const fit__problem *p, double by, fit__horizon *of, stein_err *err)
{
    growing g = {p, by, of};
    for (int s = 0; s < p->nstroke; s++) {
        of[s] = (fit__horizon){.time = INFINITY};
    }
    return fit__parallel(p, p->nstroke, measure, &g, err);
}
