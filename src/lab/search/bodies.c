/* SPDX-License-Identifier: GPL-3.0-or-later
 * bodies.c - masses, centres and inertias whose tolerances are not stated.
 *
 * A file without any tolerance of its bodies holds what was weighed, guessed or taken from a
 * drawing. Three wrong numbers at once are more than a hypothesis has causes, and no effect of the
 * table is found beside them. So where no hypothesis leaves noise, the best ones are fitted once
 * more with all of these numbers free. Their priors are as wide as those of any number without a
 * tolerance (30 %, fit/problem.c). The search goes on from there if that pays:
 *
 *      L(as stated) - L(bodies free) > 25      or, with k causes less,      > -25 k
 *
 * as any cause has to gain 25 to be named.
 * Lengths, gravity and the clock stay as they are stated: with masses free, what falls or swings
 * tells of them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"
#include "search.h"

static const char refitted[] = "it is refitted anyhow";

static int is_of_body(const stein_model *m, const char *name)
{
    static const char *const of[] = {".mass", ".centre.", ".inertia."};
    for (int i = 0; i < m->nq; i++) {
        size_t n = strlen(m->bodies[i].name);
        int own = strncmp(name, m->bodies[i].name, n) == 0 && i != m->load.body;
        for (size_t k = 0; own && k < sizeof of / sizeof *of; k++) {
            if (strncmp(name + n, of[k], strlen(of[k])) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

/* Is parameter i a number of a body that can be set free? A tolerance that was assumed is none. */
static int is_rough(const diag__problem *q, int i)
{
    const stein_model *m = lab_equations(q->model);
    int k = diag__name_of(q, m->params[i].name);
    return is_of_body(m, m->params[i].name) && !fit__always_set(q->fitted, i) &&
           (k < 0 || q->name_sd[k] > 0.0);
}

/* numbers of bodies to be set free. @return 0 where the file states how well any is known */
static int count(const diag__problem *q)
{
    const stein_model *m = lab_equations(q->model);
    int n = 0;
    for (int i = 0; i < m->np; i++) {
        if (is_of_body(m, m->params[i].name) && m->params[i].tolerance > 0.0) {
            return 0;
        }
        n += is_rough(q, i);
    }
    return n;
}

/* candidates that move what is free, or fixed again */
static void mark(diag__problem *q, const char *from, const char *to)
{
    const stein_model *m = lab_equations(q->model);
    for (int k = 0; k < q->n; k++) {
        const lab_candidate *c = &q->candidate[k];
        int one = c->effect->needs == NULL && c->nparam == 1 && q->untestable[k] == from;
        int at = one ? diag__name_of(q, m->params[c->param[0]].name) : -1;
        if (at >= 0 && !isnan(q->body_sd[at])) {
            q->untestable[k] = to;
        }
    }
}

static stein_status release(diag__problem *q, stein_err *err)
{
    const stein_model *m = lab_equations(q->model);
    int before = q->nname;
    for (int k = 0; k < before; k++) {
        q->body_sd[k] = NAN;
    }
    for (int i = 0; i < m->np; i++) {
        if (is_rough(q, i)) {
            int k = diag__name_of(q, m->params[i].name);
            if (k < 0) {
                k = q->nname++;
                q->name[k] = m->params[i].name;
                q->name_sd[k] = 0.0;
            }
            q->body_sd[k] = q->name_sd[k];
            q->name_sd[k] = 0.0;
            q->nbody++;
        }
    }
    mark(q, NULL, refitted);
    return diag__problem_null(q, err);
}

static stein_status restore(diag__problem *q, stein_err *err)
{
    int kept = 0;
    mark(q, refitted, NULL);
    for (int k = 0; k < q->nname; k++) { // those that were added are the last ones
        int added = !isnan(q->body_sd[k]) && !(q->body_sd[k] > 0.0);
        q->name_sd[k] = isnan(q->body_sd[k]) ? q->name_sd[k] : q->body_sd[k];
        kept += !added;
    }
    q->nname = kept;
    q->nbody = 0;
    return diag__problem_null(q, err);
}

stein_status diag__bodies_begin(diag__problem *q, diag__table *t, diag__bodies *b, stein_err *err)
{
    const diag__row *best = diag__incumbent(q, t);
    *b = (diag__bodies){.free = 0};
    stein_status status = diag__note_standing(t, &b->kept, err);
    if (status != STEIN_OK || count(q) == 0) {
        return status;
    }
    status = release(q, err);
    status = status == STEIN_OK ? diag__fit_again(q, t, &diag__step_bodies, err) : status;
    const diag__row *now = status == STEIN_OK ? diag__incumbent(q, t) : NULL;
    if (now != NULL) {
        double gain = diag__weighed(q, best) - now->objective;
        int open = now->h.n > 0 || !diag__leaves_noise(q, now);
        int less = open && now->h.n < best->h.n ? best->h.n - now->h.n : -1;
        b->free = gain > -diag__least_gain * less;
    }
    return status == STEIN_OK && !b->free ? diag__bodies_end(q, t, b, 1, err) : status;
}

stein_status diag__bodies_end(diag__problem *q, diag__table *t, diag__bodies *b, int back,
                              stein_err *err)
{
    stein_status status = STEIN_OK;
    if (back && q->nbody > 0) {
        b->free = 0;
        status = restore(q, err);
        diag__take_back(q, t, &b->kept);
    }
    free(b->kept.superseded);
    b->kept.superseded = NULL;
    return status;
}

/* ---- what no body can have ---- */

/* the mechanism's parameters at the end of a row, causes of all its records included */
static void parameters_of(const diag__row *row, double *to)
{
    const fit__problem *p = &row->p;
    memcpy(to, lab_parameters(p->model), sizeof *to * (size_t)lab_equations(p->model)->np);
    for (int k = 0; k < p->np; k++) {
        if (p->unknown[k].kind == FIT__PARAM) {
            to[p->unknown[k].index] = fit__value(&p->unknown[k], row->x[k]);
        }
    }
    for (int i = 0; i < row->h.n; i++) {
        fit__apply(p, &row->cause[i], diag__unknown_at(row, i), row->x, to);
    }
}

/* Principal moments of a body that obey A <= B + C, unless those of the file do not. A formula
 * is what a part leaves of the whole, and is left alone. */
static int has_possible_inertia(const mech_body *body, const double *p)
{
    mech_scalar I[6];
    for (int i = 0; i < 6; i++) {
        I[i] = body->inertia[i];
        if (I[i].kind == MECH_FORMULA) {
            return 1;
        }
        I[i].value = I[i].kind == MECH_PARAM ? p[I[i].index] : I[i].value;
    }
    return mech__violates_triangle(body->inertia) || !mech__violates_triangle(I);
}

stein_status diag__bodies_exist(diag__row *row, stein_err *err)
{
    const mechanism *m = lab__mechanism(row->p.model);
    double *p = malloc(sizeof *p * ((size_t)lab_equations(row->p.model)->np + 1));
    if (p == NULL) {
        return lab__no_memory(err);
    }
    parameters_of(row, p);
    for (int i = 0; i < m->nbody; i++) {
        row->impossible |= !has_possible_inertia(&m->bodies[i], p);
    }
    free(p);
    return STEIN_OK;
}
