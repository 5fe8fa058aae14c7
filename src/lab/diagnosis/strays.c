/* SPDX-License-Identifier: GPL-3.0-or-later
 * strays.c - single strokes that a fit has lost.
 *
 * A stroke has numbers of its own: when it began, how much friction it had that day. With wrong
 * ones it may escape a moment too late and bounce in another way ever after; its misfit then pulls
 * at what all strokes share, and no small step leads it back, while the others are fitted to their
 * noise. One stroke of twelve left at three noises is no physics, nor is one whose trigger came ten
 * standard deviations too late. So it is left out for a while:
 *
 *      others fitted without it --> its own numbers anew, along its course --> all together
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { STROKES_MOST = 3, RENEWALS = 2 }; /* strays are a third of the strokes at most */
static const double settled = 1.3;       /* chi2 per sample of the stroke in the middle */
static const double by_chance = 4.0;     /* sd of a stroke's chi2 */
static const double far_lost = 3.0;      /* of a stray, in that of the middle, when not settled */
static const double bent = 6.0;          /* an own number, in its prior sd */
static const double enough = 0.3;        /* of the objective */

static double squares(const fit__problem *p, const double *r, int s)
{
    const fit__stroke *t = &p->stroke[s];
    double sum = 0.0;
    for (int i = 0; i < t->nch * t->n; i++) {
        double v = r[fit__offset(p, s) + (size_t)i];
        sum += v * v;
    }
    return sum;
}

static double misfit(const fit__problem *p, const double *r, int s)
{
    return squares(p, r, s) / fmax(1.0, p->stroke[s].samples);
}

double diag__middle(const fit__problem *p, const double *r, double *room)
{
    for (int s = 0; s < p->nstroke; s++) {
        room[s] = misfit(p, r, s);
    }
    gsl_sort(room, 1, (size_t)p->nstroke);
    return room[(p->nstroke - 1) / 2];
}

int diag__is_far(double middle)
{
    return !(middle < settled);
}

int diag__is_stray(const fit__problem *p, const double *r, int stroke, double middle)
{
    double own = misfit(p, r, stroke), n = fmax(1.0, p->stroke[stroke].samples);
    return !diag__is_far(middle) ? own - middle > by_chance * sqrt(2.0 / n)
                                 : own > far_lost * middle;
}

static int is_bent(const fit__problem *p, const double *x, int stroke)
{
    const fit__stroke *t = &p->stroke[stroke];
    double most = 0.0;
    for (int k = t->first; k < t->first + t->own; k++) {
        most = p->unknown[k].prior && !p->unknown[k].idle ? fmax(most, fabs(x[k])) : most;
    }
    return most > bent;
}

int diag__has_bent(const fit__problem *p, const double *x)
{
    int found = 0;
    for (int s = 0; s < p->nstroke; s++) {
        found += is_bent(p, x, s);
    }
    return found > 0 && found <= p->nstroke / STROKES_MOST;
}

double diag__come_back(const fit__problem *p, const double *r, double *room)
{
    int others = p->nstroke - p->nstroke / STROKES_MOST;
    double sum = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        room[s] = squares(p, r, s);
    }
    gsl_sort(room, 1, (size_t)p->nstroke);
    for (int s = 0; s < others; s++) {
        sum += room[s];
    }
    return sum * p->nstroke / others;
}

/* marks strays. @return their number; 0 where too many are */
static int find(const fit__problem *p, const fit__end *e, double middle, int bent_too,
                unsigned char *stray)
{
    int found = 0;
    for (int s = 0; s < p->nstroke; s++) {
        stray[s] = diag__is_stray(p, e->r, s, middle) || (bent_too && is_bent(p, e->x, s));
        found += stray[s];
    }
    return found <= p->nstroke / STROKES_MOST ? found : 0;
}

/* every stray changes its weights for those at hand, which takes its own */
static void exchange(fit__problem *p, const unsigned char *stray, double **weight)
{
    for (int s = 0; s < p->nstroke; s++) {
        if (stray[s]) {
            double *own = p->stroke[s].weight;
            p->stroke[s].weight = weight[s];
            weight[s] = own;
        }
    }
}

/* a fit of the others, and of each stray's own numbers to that; derivatives are not those of the
 * end */
static stein_status recall(const diag__fitter *f, fit__end *e, double middle,
                           const unsigned char *stray, double **none, stein_err *err)
{
    static const double as_stated[DIAG_CLASSES] = {1.0, 1.0, 1.0};
    fit__problem *p = f->p;
    exchange(p, stray, none);
    stein_status status =
        f->fit != NULL ? f->fit(f->ctx, e, err) : fit__descend(p, e, 0, enough, RENEWALS, err);
    exchange(p, stray, none);
    diag__singles s = {.d = f->d,
                       .p = p,
                       .D = f->D != NULL ? f->D : as_stated,
                       .x = e->x,
                       .r = e->r,
                       .middle = middle};
    status = status == STEIN_OK ? diag__fit_singles(&s, stray, err) : status;
    e->fits += s.fits;
    return status;
}

stein_status diag__recall_by(const diag__fitter *f, fit__end *e, int bent_too, int *found,
                             stein_err *err)
{
    const fit__problem *p = f->p;
    size_t n = (size_t)p->nstroke;
    unsigned char *stray = calloc(n + 1, 1);
    double *room = calloc(n + (size_t)p->rows + 1, sizeof *room);
    double **none = malloc(sizeof *none * (n + 1));
    stein_status status =
        stray != NULL && room != NULL && none != NULL ? STEIN_OK : lab__no_memory(err);
    double middle = status == STEIN_OK ? diag__middle(p, e->r, room) : 0.0;
    *found = status == STEIN_OK ? find(p, e, middle, bent_too, stray) : 0;
    for (size_t i = 0; *found > 0 && i < n; i++) {
        none[i] = room + n; // weights 0, of any stroke
    }
    status = *found > 0 ? recall(f, e, middle, stray, none, err) : status;
    free(stray);
    free(room);
    free(none);
    return status;
}

stein_status diag__recall_strays(diag *d, fit__problem *p, fit__end *e, int bent_too, int *found,
                                 stein_err *err)
{
    return diag__recall_by(&(diag__fitter){.d = d, .p = p}, e, bent_too, found, err);
}
