/* SPDX-License-Identifier: GPL-3.0-or-later
 * row_start.c - where a fit begins: at the end of its parent's, new causes at the proposed amounts.
 *
 * Both fits may be of different mechanisms, and in different units: unknowns are found by what they
 * are, and numbers are translated.
 */
#include <math.h>
#include <string.h>

#include "search.h"

static const double least_start = 1e-3; /* of a compliance, which has no 0 */
static const double beyond = 0.92;      /* of a bound: a tenth of a number is left */

int diag__counterpart(const fit__problem *to, const fit__problem *from, int stroke,
                      const fit__unknown *u)
{
    const stein_model *a = lab_equations(from->model), *b = lab_equations(to->model);
    const fit__stroke *t = &to->stroke[stroke];
    int joint = u->kind == FIT__POSITION || u->kind == FIT__SPEED;
    for (int k = t->first; k < t->first + t->own; k++) {
        const fit__unknown *v = &to->unknown[k];
        if (v->kind != u->kind) { // its index may be of something else
            continue;
        }
        int same = joint ? strcmp(a->bodies[u->index].name, b->bodies[v->index].name) == 0
                   : u->kind == FIT__SCATTER ? fit__same_group(from, u->index, to, v->index)
                   : u->kind == FIT__SETTING
                       ? strcmp(a->params[u->index].name, b->params[v->index].name) == 0
                       : u->index == v->index;
        if (same) {
            return k;
        }
    }
    return -1;
}

void diag__own_unknowns(const fit__problem *from, const double *x, const fit__problem *to,
                        double *y)
{
    for (int s = 0; s < to->nstroke; s++) {
        const fit__stroke *t = &from->stroke[s];
        for (int k = t->first; k < t->first + t->own; k++) {
            int at = diag__counterpart(to, from, s, &from->unknown[k]);
            if (at >= 0) {
                const fit__unknown *u = &from->unknown[k], *v = &to->unknown[at];
                y[at] = (u->start + u->sd * x[k] - v->start) / v->sd;
                to->step[at] = from->step[k];
            }
        }
    }
}

static void carry_over(diag__row *row, const diag__row *parent)
{
    const fit__problem *from = &parent->p;
    fit__problem *to = &row->p;
    int n = from->first_accepted < to->first_accepted ? from->first_accepted : to->first_accepted;
    for (int k = 0; k < n; k++) { // in another unit where a prior has changed
        const fit__unknown *u = &from->unknown[k], *v = &to->unknown[k];
        row->x[k] = (u->start + u->sd * parent->x[k] - v->start) / v->sd;
        to->step[k] = from->step[k] * u->sd / v->sd;
    }
    for (int i = 0; i < row->h.n; i++) {
        for (int k = 0; k < parent->h.n; k++) {
            if (row->h.cause[i] == parent->h.cause[k]) {
                int a = diag__unknown_at(row, i), b = diag__unknown_at(parent, k);
                memcpy(row->x + a, parent->x + b, sizeof *row->x * FIT__NUMBERS);
                memcpy(to->step + a, from->step + b, sizeof *to->step * FIT__NUMBERS);
            }
        }
    }
    diag__own_unknowns(from, parent->x, to, row->x);
}

/* column k of a stroke of the parent into that of an unknown in the row, whose unit is another one
 */
static void take_column(diag__row *row, int to, const diag__row *parent, int from, int stroke,
                        unsigned char *known)
{
    const fit__problem *p = &row->p, *q = &parent->p;
    const fit__stroke *t = &p->stroke[stroke], *s = &q->stroke[stroke];
    int at = to < p->np ? to : to - t->first + p->np,
        of = from < q->np ? from : from - s->first + q->np;
    double unit = p->unknown[to].sd / q->unknown[from].sd;
    const double *G = parent->J + fit__column(q, stroke, of);
    double *J = row->J + fit__column(p, stroke, at);
    known[to] = !p->unknown[to].idle && !q->unknown[from].idle;
    for (int i = 0; known[to] && i < t->nch * t->n; i++) {
        J[i] = unit * G[i];
    }
}

void diag__inherit(diag__row *row, const diag__row *parent, unsigned char *known)
{
    for (int s = 0; s < row->p.nstroke; s++) {
        const fit__stroke *t = &parent->p.stroke[s];
        for (int k = 0; k < row->p.first_accepted; k++) {
            take_column(row, k, parent, k, s, known);
        }
        for (int i = 0; i < row->h.n; i++) {
            for (int k = 0; k < parent->h.n; k++) {
                int to = diag__unknown_at(row, i), from = diag__unknown_at(parent, k);
                for (int b = 0; row->h.cause[i] == parent->h.cause[k] && b < FIT__NUMBERS; b++) {
                    take_column(row, to + b, parent, from + b, s, known);
                }
            }
        }
        for (int k = t->first; k < t->first + t->own; k++) {
            int at = diag__counterpart(&row->p, &parent->p, s, &parent->p.unknown[k]);
            if (at >= 0) {
                take_column(row, at, parent, k, s, known);
            }
        }
    }
}

void diag__start_row(diag__row *row, const diag__row *parent, const diag__proposal *from)
{
    if (parent != NULL) {
        carry_over(row, parent);
    }
    for (int i = 0; i < row->h.n; i++) {
        int at = diag__unknown_at(row, i);
        double amount = isfinite(from->amount[i]) ? from->amount[i] : row->x[at];
        double most =
            fmax(diag__most_amount(&row->cause[i]), fabs(row->x[at])); // a fit has been there
        amount = fmin(fmax(amount, -most), most);
        double least = row->p.unknown[at].least;
        if (least > 0.0) {
            amount = fmax(amount, least_start);
        } else if (isfinite(from->amount[i]) &&
                   amount < beyond * least) { // a linear model does not know of the bound
            amount = 0.5 * least;
        }
        row->x[at] = amount;
        row->x[at + 1] = isfinite(from->side[i]) ? from->side[i] : row->x[at + 1];
    }
}
