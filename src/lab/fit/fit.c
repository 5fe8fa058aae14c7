/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit.c - parameters of a mechanism from measured strokes: the whole, and how far to trust it.
 *
 *      data --audit--> noise, findings      model --> unknowns, priors
 *               \                            /
 *                +--> clocks --> searches --> polish (--> robust weights) --> intervals, profiles
 *
 * Output-error fit: the model runs freely through each stroke and is compared with the samples.
 * Fitting accelerations instead (equation error) is linear and has no false minima, but
 * differentiates the noise: 8 um of it at a 0.1 mm contact are 0.6 N.
 *
 * `converged` needs three conditions: enough searches from different places ended in the same
 * minimum; the last step would gain less than 0.01 sd; and, where the noise is known, chi2/dof is
 * within 1 +- (0.1 + 3 sqrt(2/dof)). The 0.1 is for a noise that is itself only known to 5 %. A
 * minimum that all agree on and that still leaves more than noise is a misfit: the search did its
 * work, the model did not. Both are no verdict on physics: strokes that scatter by themselves
 * misfit, too.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { FLAGGED_PROFILES = 3 };
static const double clearly_better = 0.3; /* of the squares: a clock that does so is accepted */
static const double smallest_scale = 1e-9, largest_scale = 1e9; /* of a number that is 0 [SI] */
static const double band_slack = 0.1;

lab_fit_def lab_fit_def_default(void)
{
    return (lab_fit_def){.prior = 0.3,
                         .offset = 2e-4,
                         .trigger = 2e-3,
                         .initial = -1,
                         .starts = 3,
                         .scatter = -1,
                         .joint_scatter = 0.05,
                         .contact_scatter = 0.08,
                         .drive_scatter = 0.003,
                         .ladder = 1,
                         .iterations = 40,
                         .threads = 1};
}

/* ---- clocks ---- */

/* prediction of a channel at another time, straight between the samples */
static double shifted(const fit__stroke *s, const double *y, double t, int *from)
{
    const double *time = s->data->time;
    while (*from + 2 < s->n && time[*from + 1] < t) {
        ++*from;
    }
    double w = (t - time[*from]) / (time[*from + 1] - time[*from]);
    w = fmin(fmax(w, 0.0), 1.0);
    return (1.0 - w) * y[*from] + w * y[*from + 1];
}

/* squares of data less shifted prediction, the mean difference of every channel taken out */
static double shifted_misfit(const fit__stroke *s, const double *y, double tau)
{
    double total = 0.0;
    for (int c = 0; c < s->nch; c++) {
        double n = 0.0, sum = 0.0, squares = 0.0;
        int from = 0, event = s->event[c].is;
        for (int i = 0; i < s->n; i++) {
            double measured = s->y[c * s->n + i];
            if (isfinite(measured)) {
                double t = s->data->time[i] + tau;
                double there = event ? y[c * s->n + i] - tau : shifted(s, y + c * s->n, t, &from);
                double d = (measured - there) / s->noise[c];
                n += 1.0;
                sum += event ? 0.0 : d; // a shift of all times is what is looked for
                squares += d * d;
            }
        }
        total += n > 0.0 ? squares - sum * sum / n : 0.0;
    }
    return total;
}

typedef struct clocks {
    fit__problem *p;
    const double *x;
    double *tau; /* [nstroke] */
} clocks;

static stein_status ask_clock(void *ctx, fit__bench *b, int stroke)
{
    const clocks *c = ctx;
    const fit__stroke *s = &c->p->stroke[stroke];
    return s->tau >= 0 && s->nsignal == 0 && s->n > 2
               ? fit__begin(c->p, b, stroke, c->x, b->y, NULL)
               : STEIN_EINVAL;
}

/* a clock that is far off, by trying all shifts of the prediction up to half of the record */
static void set_clock(void *ctx, fit__bench *b, int stroke, int failed)
{
    clocks *c = ctx;
    fit__stroke *s = &c->p->stroke[stroke];
    const double *y = b->y;
    if (!failed) {
        double span = s->data->time[s->n - 1] - s->data->time[0], step = span / (s->n - 1);
        double least = clearly_better * shifted_misfit(s, y, 0.0);
        for (int i = -s->n / 2; i <= s->n / 2; i++) {
            double misfit = shifted_misfit(s, y, i * step);
            if (misfit < least) {
                least = misfit;
                c->tau[stroke] = i * step;
            }
        }
    }
}

static stein_status set_clocks(fit__problem *p, stein_err *err)
{
    double *x = calloc((size_t)(p->nu + p->nstroke) + 1, sizeof *x);
    if (x == NULL) {
        return lab__no_memory(err);
    }
    clocks c = {p, x, x + p->nu};
    p->tolerance = 1e-9;
    stein_status status = fit__many(p, p->nstroke, ask_clock, set_clock, &c, err);
    for (int s = 0; s < p->nstroke; s++) {
        if (p->stroke[s].tau >= 0) {
            p->unknown[p->stroke[s].tau].start = c.tau[s];
        }
    }
    free(x);
    return status;
}

/* ---- scales ---- */

static double rms_change(const fit__problem *p, fit__bench *b, int stroke, double *x, int k,
                         double step, const double *here, double *there)
{
    const fit__stroke *s = &p->stroke[stroke];
    x[k] = step;
    stein_status status = fit__simulate(p, b, stroke, x, there, NULL);
    x[k] = 0.0;
    double sum = 0.0;
    for (int i = 0; i < s->nch * s->n && status == STEIN_OK; i++) {
        double d = fit__weight(s, i) * (there[i] - here[i]) / s->noise[i / s->n];
        sum += d * d;
    }
    return status == STEIN_OK ? sqrt(sum / fmax(1.0, s->samples)) : (double)INFINITY;
}

typedef struct scales {
    const fit__problem *p;
    double *sd; /* [np], 0: stays */
} scales;

/* A number that is 0 and has no prior says nothing about its size: take the change that shows. */
static void set_scale(void *ctx, fit__bench *b, int k)
{
    const scales *to = ctx;
    const fit__problem *p = to->p;
    size_t rows = (size_t)p->rows;
    double *x = p->unknown[k].prior ? NULL : calloc((size_t)p->nu + 2 * rows + 1, sizeof *x);
    if (x == NULL) {
        return;
    }
    double *here = x + p->nu, *there = here + rows, best = INFINITY;
    for (int s = 0; s < p->nstroke; s++) {
        double step = smallest_scale;
        if (fit__simulate(p, b, s, x, here, NULL) != STEIN_OK) {
            continue;
        }
        while (step < best &&
               rms_change(p, b, s, x, k, step / p->unknown[k].sd, here, there) < 1.0) {
            step *= 4.0;
        }
        best = fmin(best, step);
    }
    to->sd[k] = fmin(best, largest_scale);
    free(x);
}

static stein_status set_scales(fit__problem *p, stein_err *err)
{
    scales to = {p, calloc((size_t)p->np + 1, sizeof *to.sd)};
    if (to.sd == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = fit__parallel(p, p->np, set_scale, &to, err);
    for (int k = 0; k < p->np; k++) {
        p->unknown[k].sd = to.sd[k] > 0.0 ? to.sd[k] : p->unknown[k].sd;
    }
    free(to.sd);
    return status;
}

/* ---- the end of the search ---- */

static void judge(const fit__problem *p, lab_fit *fit, int polished)
{
    int agree = 0, needed = p->def->starts / 2 + 1;
    for (int i = 0; i < fit->nstart; i++) {
        agree += fit->start[i].agrees;
    }
    fit->status = LAB_FIT_CONVERGED;
    if (!polished) {
        fit->status = LAB_FIT_NOT_CONVERGED;
        snprintf(fit->reason, sizeof fit->reason,
                 "the last step would still have changed the objective by %.2g", fit->gradient);
    } else if (agree < needed) {
        fit->status = LAB_FIT_NOT_CONVERGED;
        snprintf(fit->reason, sizeof fit->reason,
                 "only %d of %d searches ended in this minimum, expected %d", agree, fit->nstart,
                 needed);
    } else if (fit->noise_given && fit->chi2_dof > fit->band_hi) {
        fit->status = LAB_FIT_MISFIT;
        snprintf(fit->reason, sizeof fit->reason,
                 "chi2/dof is %.3g, more than the noise explains (up to %.3g): the model lacks "
                 "something, or the records scatter",
                 fit->chi2_dof, fit->band_hi);
    } else if (fit->noise_given && fit->chi2_dof < fit->band_lo) {
        snprintf(fit->reason, sizeof fit->reason,
                 "chi2/dof is %.3g, less than %.3g: the noise is overstated", fit->chi2_dof,
                 fit->band_lo);
    }
}

static stein_status profiles(fit__problem *p, lab_fit *fit, const double *x, stein_err *err)
{
    stein_status status = STEIN_OK;
    int flagged = 0;
    for (int k = 0; status == STEIN_OK && k < p->np; k++) {
        int wanted = 0, doubtful = 0;
        for (int i = 0; i < p->def->nprofile; i++) {
            wanted |= strcmp(p->def->profile[i], fit->value[k].name) == 0;
        }
        for (int i = 0; i < fit->npair; i++) {
            doubtful |= fit->pair[i].a == k || fit->pair[i].b == k;
        }
        if (!wanted && doubtful && p->def->profile_flagged && flagged < FLAGGED_PROFILES) {
            flagged++;
            wanted = 1;
        }
        status = wanted ? fit__profile(p, fit, k, x, fit->chi2 + fit->prior, err) : status;
    }
    return status;
}

/* everything that is known at the minimum */
static stein_status conclude(fit__problem *p, lab_fit *fit, const fit__search *s, stein_err *err)
{
    int failed = 0;
    const double *x = s->state.x;
    double *r = malloc(sizeof *r * (fit__offset(p, p->nstroke) + 1));
    double *J = malloc(sizeof *J * (fit__columns(p) + 1));
    stein_status status = r != NULL && J != NULL ? STEIN_OK : lab__no_memory(err);
    p->central = 1;
    p->tolerance = 1e-11;
    memcpy(p->step, s->state.step, sizeof *p->step * (size_t)p->nu);
    status = status == STEIN_OK ? fit__residuals(p, x, r, &failed, err) : status;
    if (status == STEIN_OK && failed > 0) {
        status = lab__fail(err, STEIN_ENONFINITE, "%d records cannot be simulated", failed);
    }
    status = status == STEIN_OK ? fit__describe(p, fit, x, r, err) : status;
    if (status == STEIN_OK) {
        fit->dof = p->samples - p->nu;
        fit->chi2_dof = fit->chi2 / fit->dof;
        fit->inflation = fit__inflation(p, r);
        fit->band_hi = 1.0 + band_slack + 3.0 * sqrt(2.0 / fit->dof);
        fit->band_lo = fmax(0.0, 1.0 - band_slack - 3.0 * sqrt(2.0 / fit->dof));
        status = fit__fine_sensitivities(p, x, r, J, &fit->sensitivity_error, err);
    }
    status = status == STEIN_OK ? fit__intervals(p, fit, x, r, J, err) : status;
    if (status == STEIN_OK) {
        fit->nstart = s->nstart;
        memcpy(fit->start, s->start, sizeof fit->start);
        judge(p, fit, s->state.ended || fit->gradient < 1e-2);
        status = profiles(p, fit, x, err);
    }
    free(r);
    free(J);
    return status;
}

static stein_status check_profiles(const lab_fit_def *def, stein_err *err)
{
    for (int i = 0; i < def->nprofile; i++) {
        int known = 0;
        for (int k = 0; k < def->nfree; k++) {
            known |= strcmp(def->profile[i], def->free[k]) == 0;
        }
        if (!known) {
            return lab__fail(err, STEIN_EINVAL, "profile of \"%s\": it is not free",
                             def->profile[i]);
        }
    }
    return STEIN_OK;
}

/* what keeps the records from beginning as the model moves */
static stein_status doubt_setup(fit__problem *p, stein_err *err)
{
    fit__finding *list = NULL;
    int n = 0;
    stein_status status = p->def->report != NULL ? fit__setup(p, &list, &n, err) : STEIN_OK;
    for (int i = 0; i < n; i++) {
        p->def->report(p->def->ctx, list[i].text);
    }
    fit__setup_free(list, n);
    return status;
}

static stein_status run(fit__problem *p, lab_fit *fit, stein_err *err)
{
    fit__search s;
    stein_status status = doubt_setup(p, err);
    status = status == STEIN_OK ? set_clocks(p, err) : status;
    status = status == STEIN_OK ? set_scales(p, err) : status;
    status = status == STEIN_OK ? fit__search_make(&s, p, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    status = fit__search_run(p, &s, fit__key(p), &fit->resumed, err);
    status = status == STEIN_OK ? conclude(p, fit, &s, err) : status;
    fit__search_free(&s);
    return status;
}

stein_status lab_fit_run(lab_fit **out, const lab_model *model, const lab_dataset *data,
                         const lab_fit_def *def, stein_err *err)
{
    fit__problem p;
    stein_status status = check_profiles(def, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab_fit *fit = calloc(1, sizeof *fit);
    if (fit == NULL) {
        return lab__no_memory(err);
    }
    status = fit__problem_make(&p, model, data, def, err);
    status = status == STEIN_OK ? run(&p, fit, err) : status;
    fit__problem_free(&p);
    if (status != STEIN_OK) {
        lab_fit_destroy(fit);
        return lab__stop_end(status, &(lab__stop){def->stop, def->ctx}, err);
    }
    *out = fit;
    return STEIN_OK;
}
