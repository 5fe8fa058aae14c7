/* SPDX-License-Identifier: GPL-3.0-or-later
 * wrong_factor.c - numbers of the file that are far off: mistyped, a diameter for a radius, an
 * inertia about another point, another unit.
 *
 * A swing with a wrong rate leaves its records within a period, whatever else is right. From there
 * neither a linear model nor a fit finds the way back. So each number of the file is tried at some
 * factors of itself, over the first swings where there are many, without a fit. The best ones are
 * fitted from there.
 */
#include <math.h>

#include "proposals.h"

const diag__proposer diag__step_factor = {.letter = 'G', .name = "a number times a factor"};

/* neighbours are near enough to begin a fit over one and a half periods */
static const double factor[] = {0.1, 0.15, 0.2, 0.3, 0.45, 0.67, 1.5, 2.2, 3.3, 5.0, 7.0, 10.0};
enum { FACTORS = sizeof factor / sizeof *factor };

/* value of the number of the file that a candidate changes, 0: it changes none */
static double number_of(const diag__problem *q, const lab_candidate *c)
{
    int adds = c->move == LAB_MOVE_ADD || c->move == LAB_MOVE_SPRING;
    return c->number > 0.0 && adds ? lab_parameters(q->model)[c->param[0]] : 0.0;
}

/* the factor of candidate k that leaves least, into a proposal. @param step  every step-th is tried
 * @param least  chi2 out */
static stein_status best_factor(diag__problem *q, int k, double value, int step,
                                diag__proposal *best, double *least, stein_err *err)
{
    const lab_candidate *c = &q->candidate[k];
    stein_status status = STEIN_OK;
    *least = INFINITY;
    for (int i = 0; i < FACTORS && status == STEIN_OK && !diag__is_spent(q); i += step) {
        diag__proposal p = {.h = {.n = 1, .cause = {k}}, .parent = -1, .by = &diag__step_factor};
        double chi2;
        p.amount[0] = (factor[i] - 1.0) * value / c->limit;
        p.side[0] = NAN;
        if (!diag__is_thinkable(q, &p)) {
            continue;
        }
        status = diag__misfit(q, &p, &chi2, err);
        if (chi2 < *least) {
            *least = chi2;
            *best = p;
        }
    }
    return status;
}

stein_status diag__try_factors(diag__problem *q, diag__table *t, int step, stein_err *err)
{
    const diag__row *null = diag__best(q, t, 0);
    diag__ranked list[DIAG_COLUMNS];
    diag__proposal best[DIAG_COLUMNS];
    stein_status status = STEIN_OK;
    int n = 0, far = null != NULL && null->chi2_dof > diag__seven_noises;
    for (int k = 0; far && k < q->n && n < DIAG_COLUMNS && status == STEIN_OK; k++) {
        double value = q->untestable[k] == NULL ? number_of(q, &q->candidate[k]) : 0.0, least;
        if (fabs(value) > 0.0) {
            status = best_factor(q, k, value, step, &best[n], &least, err);
            list[n] = (diag__ranked){n, -1, least};
            n += isfinite(least);
        }
    }
    diag__rank(list, n);
    for (int i = 0; i < n && i < DIAG_FEW_FITS && status == STEIN_OK; i++) {
        diag__row *one = NULL;
        status = diag__is_spent(q) ? STEIN_OK : diag__try(q, t, &best[list[i].a], &one, err);
    }
    return status;
}
