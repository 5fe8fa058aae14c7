/* SPDX-License-Identifier: GPL-3.0-or-later
 * profile.c - profile likelihood: how far one parameter can go when all others are fitted again.
 *
 *      D(z) = min over the others of chi2 + other priors  -  its minimum over z too  =  3.84 v
 *
 * with v as for the linear intervals, and without the parameter's own prior: information of the
 * data alone (Raue et al. 2009). sqrt(D) is nearly straight in z. So the crossing is found by
 * stretching the distance by sqrt(3.84 v / D), in four or five refits a side, each from the end of
 * the last one. A side that is not reached within ten prior standard deviations or a factor of 20
 * is open.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "fitting.h"

enum { MAX_REFITS = 8, REFIT_ITERATIONS = 12 };
static const double level = 3.841458820694124; /* chi2, one degree of freedom, 95 % */

typedef struct room {
    fit__state s;
    double *best; /* minimum without the prior */
    double lowest;
} room;

/* all others again, from where they are */
static stein_status refit(fit__problem *p, room *m, stein_err *err)
{
    memset(m->s.scale, 0, sizeof *m->s.scale * (size_t)p->nu);
    m->s.mu = 1e-6;
    m->s.nu = 2.0;
    m->s.iteration = 0;
    return fit__minimise(p, &m->s, 1e-3, 0.0, REFIT_ITERATIONS, NULL, NULL, err);
}

/* one side: sign -1 or 1; *end = +-INFINITY when it is open */
static stein_status find_end(fit__problem *p, room *m, int k, int sign, double guess, double v,
                             double *end, stein_err *err)
{
    const fit__unknown *u = &p->unknown[k];
    double x0 = m->best[k], far = fmax(10.0, u->log ? stein__log_of(20.0) / u->sd : 10.0),
           at = guess;
    memcpy(m->s.x, m->best, sizeof *m->s.x * (size_t)p->nu);
    p->fixed = k;
    *end = sign > 0 ? (double)INFINITY : -(double)INFINITY;
    for (int i = 0; i < MAX_REFITS && at <= far; i++) {
        m->s.x[k] = x0 + sign * at;
        stein_status status = refit(p, m, err);
        if (status != STEIN_OK && status != STEIN_ENOMEM) {
            at *= 0.7; // beyond what can be simulated
            memcpy(m->s.x, m->best, sizeof *m->s.x * (size_t)p->nu);
            continue;
        }
        if (status != STEIN_OK) {
            return status;
        }
        double d = m->s.objective - m->lowest, ratio = sqrt(level * v / fmax(d, 1e-6 * level));
        if (fabs(ratio - 1.0) < 0.02 || (i == MAX_REFITS - 1 && ratio < 2.0)) {
            *end = fit__value(u, x0 + sign * at);
            break;
        }
        at *= fmin(fmax(ratio, 0.3), 5.0);
    }
    p->fixed = -1;
    return STEIN_OK;
}

static stein_status both_ends(fit__problem *p, lab_fit *fit, room *m, int k, stein_err *err)
{
    lab_fit_value *value = &fit->value[k];
    const fit__unknown *u = &p->unknown[k];
    stein_status status = refit(p, m, err);
    if (status != STEIN_OK) {
        return status;
    }
    memcpy(m->best, m->s.x, sizeof *m->best * (size_t)p->nu);
    m->lowest = m->s.objective;
    double v = fmax(1.0, fit->chi2_dof) * fit->inflation;
    double sd =
        isfinite(value->data_sd) ? value->sd / (u->sd * fabs(fit__slope(u, m->best[k]))) : 1.0;
    double guess = 1.96 * sd, lo, hi;
    status = find_end(p, m, k, -1, guess, v, &lo, err);
    status = status == STEIN_OK ? find_end(p, m, k, 1, guess, v, &hi, err) : status;
    if (status == STEIN_OK) {
        value->profiled = 1;
        value->profile_lo = lo;
        value->profile_hi = hi;
    }
    return status;
}

stein_status fit__profile(fit__problem *p, lab_fit *fit, int k, const double *x, double objective,
                          stein_err *err)
{
    size_t nu = (size_t)p->nu;
    room m = {.lowest = objective};
    if (fit->value[k].unseen) {
        fit->value[k].profiled = 1;
        fit->value[k].profile_lo = -INFINITY;
        fit->value[k].profile_hi = INFINITY;
        return STEIN_OK;
    }
    double *memory = malloc(sizeof *memory * (4 * nu + 1));
    if (memory == NULL) {
        return lab__no_memory(err);
    }
    m.s.x = memory;
    m.s.step = memory + nu;
    m.best = memory + 2 * nu;
    m.s.scale = memory + 3 * nu;
    memcpy(m.s.x, x, sizeof *x * nu);
    memcpy(m.s.step, p->step, sizeof *x * nu);
    p->flat = k;
    p->central = 0;
    stein_status status = both_ends(p, fit, &m, k, err);
    p->flat = p->fixed = -1;
    p->central = 1;
    free(memory);
    return status;
}
