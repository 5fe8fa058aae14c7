/* SPDX-License-Identifier: GPL-3.0-or-later
 * verdict.c - from what the search has found to one of seven words.
 *
 *      gain = L(null) - L(best),   over max(1, chi2/dof) and the length of the residual's memory
 *                                  where nobody stated the noise
 *
 *      no gain to speak of, residual is noise                  explained
 *      no gain to speak of, residual is more                   unknown_effect, or not_converged
 *      a gain, but most of the misfit stays                    the same
 *      a gain, and held-out strokes are not predicted better   explained: it is not made
 *      a gain that pays                                        the class of the best candidate
 *
 * A gain is spoken of when the best of all candidates would reach it by chance in less than one
 * clean set in a hundred (with the strokes' scatter known from few strokes), and when it is more
 * than `least`: the laws of a real mechanism are never exactly those of the file, and what is
 * visible only because there are many frames is no cause. The chance is that of linear scores at
 * the null fit, and those say nothing where a bounce more or less lies between the null fit and the
 * truth: a large gain speaks for itself, when held-out strokes say the same.
 *
 * A cause that acts like what differs from stroke to stroke by itself - a gain of the drive, a
 * friction - has as many witnesses as there are strokes, whatever the number of frames: none of its
 * gains is large. There the mean of the differences is asked, by
 *
 *      t = amount/sd,   Student's with n - 1 degrees of freedom for n strokes
 *
 * A number of the file is fitted within its tolerance, and a fit that moves it as far as it will go
 * leaves little to gain for whom it is wrong: what is gained is the price of that way. So the way
 * itself is asked, z = amount/sd with the tolerance in sd, among all numbers with a tolerance.
 */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "searching.h"

const double diag__least_gain = 25.0, diag__must_explain = 0.7, diag__convincing = 9.2;
static const double forgiven = 50.0;       /* of -2 log likelihood: twice what is spoken of */
static const double by_chance_mean = 1e-3; /* for each of the few whose mean is asked */
static const double no_nearer = 0.9995;    /* ratio of held-out errors */
static const double far = 1.3;             /* chi2/dof that is more than noise, stated or not */
static const double by_chance = 0.01;
static const double sure = 150.0;   /* of gain: not by chance, whatever the linear scores say */
static const double slack = 0.05;   /* of chi2/dof */
static const double crumb = 0.3;    /* share of what is more than noise */
static const double by_noise = 3.0; /* standard deviations: what is left counts as more */
static const double twice = 2.0;    /* standard deviations of noise: more is no chance */

double diag__excess(const diag *d, const diag__suspect *s)
{
    if (fit__noise_given(&d->p)) {
        return 1.0;
    }
    const double *r = d->suspect[0].r;
    double memory = r != NULL ? fit__inflation(&d->p, r) : 1.0;
    return fmax(1.0, s->s.chi2_dof) * fmax(1.0, memory);
}

/* "viscous_friction at slide" */
static int say_place(char *to, size_t size, const lab_suspect *s)
{
    return snprintf(to, size, "%s at %s", s->candidate.effect->kind, s->candidate.place);
}

static void say_causes(diag *d, const diag__found *f)
{
    lab_diagnosis *o = d->out;
    size_t size = sizeof o->reason;
    int n = 0;
    for (int i = 0; i < f->n && n < (int)size; i++) {
        n += snprintf(o->reason + n, size - (size_t)n, "%s",
                      i == 0         ? ""
                      : i + 1 < f->n ? ", "
                                     : " and ");
        n += n < (int)size ? say_place(o->reason + n, size - (size_t)n, &f->cause[i]) : 0;
    }
    if (n < (int)size) {
        snprintf(o->reason + n, size - (size_t)n, "%s%s.%s", f->n == 1 ? ": " : "",
                 f->n == 1 ? f->cause[0].candidate.effect->equation : "",
                 !isfinite(o->gain.ratio)    ? ""
                 : o->gain.ratio < no_nearer ? " Strokes that were held out are predicted better."
                 : f->asked[0] == DIAG_TOLERANCE
                     ? " Without it the fit takes this number far out of its tolerance."
                     : " Strokes that were held out differ less by themselves with it.");
    }
}

/* has the null fit ended, or its best suspect near the data? */
static int ended(const diag *d)
{
    const diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    return d->ended || (best != NULL && best->ended && best->s.chi2_dof < 2.0);
}

static void unexplained(diag *d, const char *what, int ended)
{
    lab_diagnosis *o = d->out;
    o->verdict = ended ? LAB_VERDICT_UNKNOWN_EFFECT : LAB_VERDICT_NOT_CONVERGED;
    snprintf(o->reason, sizeof o->reason, "%s%s", what,
             ended ? "" : " The fits have not converged: this says nothing about physics yet.");
}

/* the audit sees noise that is quick; where nobody stated it, the slow rest may be noise, too */
static void say_nothing_found(lab_diagnosis *o)
{
    if (o->chi2_dof_before > 2.0) {
        snprintf(o->reason, sizeof o->reason,
                 "No candidate explains what is left, so it counts as noise: nobody stated that, "
                 "and the records alone show %.2g times less.",
                 sqrt(o->chi2_dof_before));
    } else {
        snprintf(o->reason, sizeof o->reason,
                 "What the strokes show, the model explains: noise, tolerances of the file and "
                 "differences from stroke to stroke are enough.");
    }
}

double diag__noise_sd(const diag *d)
{
    return sqrt(2.0 / fmax(1.0, d->p.samples - d->p.nu));
}

int diag__is_off(const diag *d, double chi2_dof)
{
    return chi2_dof > (fit__noise_given(&d->p) ? fmin(1.0 + 2.0 * diag__noise_sd(d), far) : far);
}

double diag__most_noise(const diag *d)
{
    return fit__noise_given(&d->p) ? 1.0 + slack + 5.0 * diag__noise_sd(d) : INFINITY;
}

/* Where more than noise is left that no number of the model takes away - the noise of a recorded
 * force, say - something of it looks like this and something like that. A cause takes a good part.
 */
static int is_crumb(const diag *d, const diag__suspect *best)
{
    double before = fit__chi2_dof(&d->p, d->r), excess = before - 1.0 - twice * diag__noise_sd(d);
    return fit__noise_given(&d->p) && excess > 0.0 && before - best->s.chi2_dof < crumb * excess;
}

/* does the file state a tolerance of number k of the fit? */
static int is_stated(const diag *d, int k)
{
    return lab_equations(d->model)->params[d->p.unknown[k].index].tolerance > 0.0;
}

/* would one of the numbers with a tolerance be z of these off by chance? */
static int is_off_by_chance(const diag *d, double z)
{
    int n = 0;
    for (int k = 0; k < d->nname; k++) {
        n += is_stated(d, k);
    }
    return n * 2.0 * gsl_cdf_ugaussian_Q(z) > by_chance;
}

/* the number of a fit that is farthest off, in its tolerances */
static double farthest(const diag *d)
{
    double most = 0.0;
    for (int k = 0; k < d->nname; k++) {
        most = is_stated(d, k) ? fmax(most, fabs(d->x[k])) : most;
    }
    return most;
}

int diag__is_strained(const diag *d)
{
    return !is_off_by_chance(d, farthest(d));
}

int diag__is_seen(const diag *d)
{
    return d->p_value < by_chance || diag__is_strained(d);
}

int diag__is_beyond(const diag *d, const diag__suspect *s)
{
    int k = diag__number_of(d, s);
    if (k < 0 || !is_stated(d, k) || !s->s.refitted || !isfinite(s->objective)) {
        return 0;
    }
    double sd = s->sd[d->p.amount], z = fabs(s->x[d->p.amount]) / fmax(sd, 1e-300);
    return s->s.gain > 0.0 && !is_off_by_chance(d, z);
}

/* does the number that a suspect moves differ from stroke to stroke by itself? */
static int differs(const diag *d, const diag__suspect *s)
{
    const lab_candidate *c = &s->s.candidate;
    return d->fit_def.scatter && c->nparam > 0 && s->model == NULL &&
           d->p.group[c->param[0]] != FIT__CALM;
}

int diag__is_mean(const diag *d, const diag__suspect *s)
{
    if (!differs(d, s) || d->p.nstroke < 2 || !s->s.refitted) {
        return 0;
    }
    double sd = s->sd[d->p.amount], t = fabs(s->x[d->p.amount]) / fmax(sd, 1e-300);
    return s->s.gain > 0.0 && 2.0 * gsl_cdf_tdist_Q(t, d->p.nstroke - 1) < by_chance_mean;
}

/* Where a fit would end if its strokes kept what their derivatives promise: a valley that no step
 * follows (a backlash closes in one stroke more) is no evidence, if it is not deep. */
static double promise(const diag__suspect *s, double excess)
{
    return s->objective - fmin(s->objective - s->promised, forgiven * excess);
}

int diag__rivals(const diag *d)
{
    const diag__suspect *best = d->n > 0 ? &d->suspect[0] : NULL;
    double excess = best != NULL && best->s.refitted ? diag__excess(d, best) : NAN;
    // where the mean is asked, what leaves it to the differences is no rival
    int asked = best != NULL && best->s.gain <= diag__least_gain && diag__is_mean(d, best);
    int n = 0;
    for (int i = 1; best != NULL && i < d->n && isfinite(excess); i++) {
        const diag__suspect *s = &d->suspect[i];
        if (!s->s.refitted || !s->s.possible || (asked && !diag__is_mean(d, s))) {
            break;
        }
        double behind = fmin(s->objective - best->objective,
                             promise(s, excess) - promise(best, excess)); // by like measures
        n = behind < diag__convincing * excess ? i : n;
    }
    return n;
}

int diag__spoken(const diag *d)
{
    const diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    if (best == NULL || !isfinite(best->objective) || !best->s.possible) {
        return 0;
    }
    double excess = diag__excess(d, best);
    int gains = best->s.gain > diag__least_gain * excess &&
                (diag__is_seen(d) || best->s.gain > sure * excess);
    return (gains || diag__is_mean(d, best) || diag__is_beyond(d, best)) && !is_crumb(d, best);
}

double diag__by_more(const diag *d, double chi2_dof)
{
    return chi2_dof - 1.0 - by_noise * diag__noise_sd(d);
}

int diag__is_more(const diag *d, double chi2_dof)
{
    return !fit__noise_given(&d->p) || diag__by_more(d, chi2_dof) > 0.0;
}

int diag__is_on(const diag *d, double chi2_dof)
{
    int one_of_several = d->naccepted > 0 && fit__noise_given(&d->p);
    return one_of_several ? diag__is_more(d, chi2_dof) : diag__is_off(d, chi2_dof);
}

double diag__share(const diag *d, double chi2_dof)
{
    double before = d->out->chi2_dof_before;
    return (before - chi2_dof) / fmax(before - 1.0, 1e-9);
}

/* @return does the diagnosis end without a cause? */
static int is_unexplained(diag *d, double chi2_dof)
{
    const char *what =
        chi2_dof > diag__most_noise(d) && diag__share(d, chi2_dof) < diag__must_explain
            ? "The best candidate leaves most of the misfit."
        : chi2_dof > 2.0 && fit__noise_given(&d->p) ? "The best candidate leaves more than noise."
                                                    : NULL;
    if (what != NULL) {
        unexplained(d, what, ended(d));
    }
    return what != NULL;
}

void diag__verdict(diag *d, diag__found *f)
{
    lab_diagnosis *o = d->out;
    const diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    int spoken = f->n > 0 || diag__spoken(d); // of two, the first one may be no gain alone
    o->chi2_dof_before = fit__chi2_dof(&d->p, d->r);
    o->chi2_dof_after = f->n > 0       ? f->chi2_dof
                        : best != NULL ? best->s.chi2_dof
                                       : o->chi2_dof_before;
    if (!spoken && o->chi2_dof_before <= diag__most_noise(d)) {
        o->verdict = LAB_VERDICT_EXPLAINED;
        say_nothing_found(o);
    } else if (!spoken) {
        unexplained(d, "The residual is more than noise, and no candidate explains it.", ended(d));
    } else if (is_unexplained(d, o->chi2_dof_after)) {
        f->n = 0;
    } else if (f->n > 1 && o->chi2_dof_after > diag__most_noise(d)) {
        int ended = f->leader != NULL ? f->leader->ended : f->end->ended;
        unexplained(d, "Several causes together leave more than noise.", d->ended || ended);
        f->n = 0;
    } else if (f->n < 1 && o->chi2_dof_before > diag__most_noise(d)) {
        unexplained(d,
                    "The residual is more than noise, and the best candidate does not predict "
                    "the held-out strokes better.",
                    ended(d));
    } else if (f->n < 1) {
        o->verdict = LAB_VERDICT_EXPLAINED;
        snprintf(o->reason, sizeof o->reason,
                 "The best candidate (%s at %s) fits better but does not predict the held-out "
                 "strokes better: no extension is made.",
                 best->s.candidate.effect->kind, best->s.candidate.place);
    } else {
        const char *class = f->cause[0].candidate.effect->cls;
        for (int v = LAB_VERDICT_WRONG_PARAMETER; v <= LAB_VERDICT_MISSING_EFFECT; v++) {
            if (strcmp(class, lab_verdict_text((lab_verdict)v)) == 0) {
                o->verdict = (lab_verdict)v;
            }
        }
        say_causes(d, f);
    }
}
