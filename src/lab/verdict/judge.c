/* SPDX-License-Identifier: GPL-3.0-or-later
 * judge.c - the verdict of a closed table: a pure function of fitted numbers.
 *
 *      gain = L(less) - L(more),  L = -2 ln p
 *
 *   1  A cause more is named when it gains 25. The laws of a real mechanism are never exactly those
 *      of the file, and what shows only because there are many samples is no cause.
 *   2  A number of the file beyond its tolerance gains little: the fit without the cause moves it
 *      there for the price of its prior. The test is z = amount/sd, against the probability that
 *      one of all numbers with a tolerance is that far off.
 *   3  A cause that acts like the scatter from record to record is observed once a record:
 *      t = amount/sd, Student's with n - 1 degrees of freedom.
 *   4  Of hypotheses with 0, 1, 2, 3 causes the first one is best from which on no cause more is
 *      named.
 *   5  Rivals have as many causes and come within odds of 1 to 100, or fit as well but for the
 *      priors of their amounts. If more than noise is left, a
 *      better fit may be one of what is missing in all of them: then within what a cause has to
 *      gain.
 *   6  No cause is named if its 95 % interval contains 0, or if the hypothesis leaves most of the
 *      misfit.
 *   7  A best hypothesis that is far from the records is no usable model, whatever it gains.
 *   8  Explained is what leaves noise.
 *   9  A cause that acts in one record alone is named only if Student's t with n - 2 degrees of
 *      freedom, over all n records, is beyond doubt.
 *  10  Of a clock and a number of the file without a tolerance that do as well, the number is
 * named.
 *
 * Reasons of the thresholds: docs/diagnosis-details.md.
 */
#include <gsl/gsl_cdf.h>
#include <math.h>

#include "verdict.h"

static double gain_of(const diag__evidence *more, const diag__evidence *less)
{
    return less->objective - more->objective;
}

/* the cause that only the first hypothesis contains, -1: none, or several */
static int added(const diag__evidence *more, const diag__evidence *less)
{
    int which = -1, n = 0;
    for (int i = 0; i < more->n; i++) {
        int has = 0;
        for (int k = 0; k < less->n; k++) {
            has |= less->cause[k] == more->cause[i];
        }
        which = has ? which : i;
        n += !has;
    }
    return n == 1 ? which : -1;
}

double diag__enough(void)
{
    return diag__least_gain;
}

int diag__gains(const diag__evidence *more, const diag__evidence *less, const diag__setting *s)
{
    double gain = gain_of(more, less);
    int i = added(more, less);
    if (gain > diag__least_gain * (more->n - less->n)) {
        return 1;
    }
    if (i < 0 || !(gain > 0.0)) {
        return 0;
    }
    double z = fabs(more->amount[i]) / fmax(more->sd[i], 1e-300);
    int beyond =
        more->tolerated[i] && s->tolerances * 2.0 * gsl_cdf_ugaussian_Q(z) <= diag__by_chance;
    int mean = more->scatters[i] && s->freedom > 0.0 &&
               2.0 * gsl_cdf_tdist_Q(z, s->freedom) < diag__by_chance_mean;
    return beyond || mean;
}

/* does a row have the causes of e but number i, and as good a fit is none of it? */
static int loses(const diag__evidence *e, int i, const diag__evidence *all, int rows)
{
    int asked = 0, lost = 1;
    for (int k = 0; k < rows; k++) {
        if (all[k].n == e->n - 1 && all[k].possible && added(e, &all[k]) == i) {
            asked = 1;
            lost &= gain_of(e, &all[k]) > diag__least_gain;
        }
    }
    return asked && lost;
}

/* The interval from derivatives, or the ratio of likelihoods with and without it: where numbers
 * beside an amount are hardly known, derivatives at the end say little of how far 0 is. */
static int excludes_zero(const diag__evidence *e, const diag__evidence *all, int rows)
{
    int yes = 1;
    for (int i = 0; i < e->n; i++) {
        yes &= fabs(e->amount[i]) > diag__interval * e->sd[i] || loses(e, i, all, rows);
    }
    return yes;
}

/* is every cause of one record alone beyond doubt? */
static int is_certain(const diag__evidence *e, const diag__setting *s)
{
    int yes = 1;
    for (int i = 0; i < e->n; i++) {
        double z = fabs(e->amount[i]) / fmax(e->sd[i], 1e-300);
        yes &= !e->single[i] ||
               (s->records > 2 &&
                2.0 * s->records * gsl_cdf_tdist_Q(z, s->records - 2) < diag__beyond_doubt);
    }
    return yes;
}

/* does a have the causes of b, but for b's clock another instrument's gain, or a number of the file
 * without a tolerance? */
static int spares_clock(const diag__evidence *a, const diag__evidence *b)
{
    int in_a = added(a, b), in_b = added(b, a);
    return a->n == b->n && in_a >= 0 && in_b >= 0 && b->clock[in_b] &&
           (a->gain[in_a] || (!a->named[in_a] && !a->tolerated[in_a]));
}

/* may it be named: with n causes, none of several of an amount that may be 0? */
static int is_eligible(const diag__evidence *e, int n, const diag__evidence *all, int rows,
                       const diag__setting *s)
{
    return e->n == n && e->possible && is_certain(e, s) && (n < 2 || excludes_zero(e, all, rows));
}

/* the least objective with n causes of what may be named; of two that fit equally
 * well, an effect of the table before a number of the same element, and a gain or a number that
 * nobody has said to be exact before a clock, which is seldom wrong. @return -1: there is none */
static int best_of(const diag__evidence *e, int rows, int n, const diag__setting *s)
{
    int best = -1;
    for (int i = 0; i < rows; i++) {
        if (is_eligible(&e[i], n, e, rows, s) && (best < 0 || e[i].objective < e[best].objective)) {
            best = i;
        }
    }
    for (int i = 0, from = best; i < rows && from >= 0; i++) {
        int better = e[i].n == n && e[i].possible && n == 1 && e[i].named[0] && !e[from].named[0] &&
                     e[i].place[0] == e[from].place[0] &&
                     e[i].objective < e[from].objective + diag__same_fit;
        best = better && (best == from || e[i].objective < e[best].objective) ? i : best;
    }
    for (int i = 0, from = best; i < rows && from >= 0; i++) {
        int better = e[i].objective < e[from].objective + diag__convincing &&
                     spares_clock(&e[i], &e[from]) && is_eligible(&e[i], n, e, rows, s);
        best = better && (best == from || e[i].objective < e[best].objective) ? i : best;
    }
    return best;
}

static int same_causes(const diag__evidence *a, const diag__evidence *b)
{
    for (int i = 0; i < a->n; i++) {
        if (a->cause[i] != b->cause[i]) {
            return 0;
        }
    }
    return a->n == b->n;
}

/* is what a hypothesis leaves noise? */
static int is_noise(const diag__evidence *e, const diag__setting *s)
{
    return !e->scatters_most &&
           (e->chi2_dof <= s->most_noise || (!s->stated && e->memory < DIAG_WHITE));
}

/* hypotheses with as many causes and nearly the same evidence as the best one, each once */
static void find_rivals(const diag__evidence *e, int n, diag__judgement *j, const diag__setting *s)
{
    const diag__evidence *best = &e[j->best];
    int sure = is_noise(best, s) && (s->stated || best->chi2_dof <= diag__near_noise);
    double within_odds = sure ? diag__convincing : diag__least_gain;
    for (int i = 0; i < n && j->nrival < DIAG_RIVALS; i++) {
        int alike = best->n == 1 && e[i].likelihood < best->likelihood + diag__same_fit;
        int near = e[i].possible && e[i].n == best->n && best->n > 0 &&
                   (alike || e[i].objective < best->objective + within_odds);
        for (int k = 0; near && k < n; k++) { // a better fit of the same hypothesis stands for it
            near = k == i || !e[k].possible || !same_causes(&e[k], &e[i]) ||
                   e[k].objective > e[i].objective || (!(e[k].objective < e[i].objective) && k > i);
        }
        if (near && !same_causes(&e[i], best) && excludes_zero(&e[i], e, n)) {
            int at = j->nrival++;
            for (; at > 0 && e[j->rival[at - 1]].objective > e[i].objective; at--) {
                j->rival[at] = j->rival[at - 1];
            }
            j->rival[at] = i;
        }
    }
}

diag__finding diag__not_shown(const diag__evidence *null, const diag__setting *s)
{
    return is_noise(null, s) ? DIAG_EXPLAINED : DIAG_NOT_SHOWN;
}

static diag__finding find(const diag__evidence *e, int n, const diag__judgement *j,
                          const diag__setting *s)
{
    const diag__evidence *null = &e[j->null], *best = &e[j->best];
    int noise = is_noise(best, s);
    if (best->chi2_dof > diag__seven_noises && best->relative > diag__no_model) {
        return DIAG_FAR_OFF;
    }
    if (best->n == 0) {
        return noise ? DIAG_EXPLAINED : null->converged ? DIAG_NO_CAUSE : DIAG_NOT_CONVERGED;
    }
    if (!noise && j->share < diag__most_of) {
        return best->converged ? DIAG_MOST_LEFT : DIAG_NOT_CONVERGED;
    }
    return excludes_zero(best, e, n)                                 ? DIAG_NAMED
           : null->chi2_dof <= s->most_noise && !null->scatters_most ? DIAG_EXPLAINED
                                                                     : DIAG_UNDECIDED;
}

/* The best row without a cause that takes settings as the other row does; what a cause explains is
 * told against that one. @return -1: there is none */
static int null_beside(const diag__evidence *e, int rows, const diag__evidence *row)
{
    int best = -1;
    for (int i = 0; i < rows; i++) {
        int eligible = e[i].n == 0 && e[i].possible && e[i].rough == row->rough;
        best = eligible && (best < 0 || e[i].objective < e[best].objective) ? i : best;
    }
    return best;
}

/* What explains most of a misfit, though not beyond doubt: records that count as few independent
 * samples prove little. */
static void find_nearest(const diag__evidence *e, int n, diag__judgement *j, const diag__setting *s)
{
    const diag__evidence *null = &e[j->null];
    int one = j->finding == DIAG_NO_CAUSE ? best_of(e, n, 1, s) : -1;
    j->near =
        one >= 0 ? (null->chi2_dof - e[one].chi2_dof) / fmax(null->chi2_dof - 1.0, 1e-9) : 0.0;
    int much = one >= 0 && e[one].objective < null->objective - diag__convincing;
    j->nearest = much && j->near > diag__most_of ? one : -1;
}

diag__judgement diag__judge(const diag__evidence *e, int n, const diag__setting *s)
{
    diag__judgement j = {.finding = DIAG_NOT_CONVERGED, .nearest = -1, .null = best_of(e, n, 0, s)};
    j.best = j.null;
    for (int k = 1; k <= DIAG_CAUSES && j.null >= 0; k++) {
        int more = best_of(e, n, k, s);
        j.best = more >= 0 && diag__gains(&e[more], &e[j.best], s) ? more : j.best;
    }
    if (j.null < 0) {
        return j;
    }
    j.least = j.null;
    int beside = null_beside(e, n, &e[j.best]);
    j.null = beside >= 0 ? beside : j.null;
    const diag__evidence *null = &e[j.null], *best = &e[j.best];
    j.gain = gain_of(best, null);
    j.share = (null->chi2_dof - best->chi2_dof) / fmax(null->chi2_dof - 1.0, 1e-9);
    j.finding = find(e, n, &j, s);
    find_rivals(e, n, &j, s);
    find_nearest(e, n, &j, s);
    return j;
}
