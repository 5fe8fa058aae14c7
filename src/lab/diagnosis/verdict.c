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
 * visible only because there are many frames is no cause.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "searching.h"

static const double least = 25.0; /* gain */
static const double by_chance = 0.01;
static const double slack = 0.05;       /* of chi2/dof */
static const double must_explain = 0.7; /* share of the misfit */
static const double rival = 9.2;        /* -2 ln of odds of 1 to 100 */

static int noise_given(const fit__problem *p)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            if (!p->stroke[s].given[c]) {
                return 0;
            }
        }
    }
    return 1;
}

double diag__excess(const diag *d, const diag__suspect *s)
{
    if (noise_given(&d->p)) {
        return 1.0;
    }
    const double *r = d->suspect[0].r;
    double memory = r != NULL ? fit__inflation(&d->p, r) : 1.0;
    return fmax(1.0, s->s.chi2_dof) * fmax(1.0, memory);
}

static void say_cause(diag *d, const diag__suspect *best)
{
    lab_diagnosis *o = d->out;
    const lab_effect *e = best->s.candidate.effect;
    snprintf(o->reason, sizeof o->reason,
             "%s at %s: %s. %s%d other candidate%s cannot be told from it.", e->kind,
             best->s.candidate.place, e->equation,
             isfinite(o->gain.ratio) ? "Strokes that were held out are predicted better. " : "",
             o->nrival, o->nrival == 1 ? "" : "s");
}

static void count_rivals(diag *d)
{
    lab_diagnosis *o = d->out;
    double near = d->suspect[0].objective + rival * diag__excess(d, &d->suspect[0]);
    o->ncause = 1;
    for (int i = 1; i < d->n; i++) {
        const diag__suspect *s = &d->suspect[i];
        if (!s->s.refitted || !s->s.possible || !(s->objective < near)) {
            break;
        }
        o->nrival++;
    }
}

static void unexplained(diag *d, const char *what)
{
    lab_diagnosis *o = d->out;
    const diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    int ended = d->ended || (best != NULL && best->ended && best->s.chi2_dof < 2.0);
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

void diag__verdict(diag *d, double before, double after)
{
    lab_diagnosis *o = d->out;
    const fit__problem *p = &d->p;
    const diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    double dof = fmax(1.0, p->samples - p->nu), gain = best != NULL ? best->s.gain : 0.0;
    int given = noise_given(p);
    double noise = given ? 1.0 + slack + 5.0 * sqrt(2.0 / dof) : INFINITY;
    gain /= best != NULL ? diag__excess(d, best) : 1.0;
    o->chi2_dof_before = fit__chi2(p, d->r) / dof;
    o->chi2_dof_after = best != NULL ? best->s.chi2_dof : o->chi2_dof_before;
    int spoken = best != NULL && isfinite(best->objective) && best->s.possible && gain > least &&
                 d->p_value < by_chance;
    if (!spoken && o->chi2_dof_before <= noise) {
        o->verdict = LAB_VERDICT_EXPLAINED;
        say_nothing_found(o);
        return;
    }
    if (!spoken) {
        unexplained(d, "The residual is more than noise, and no candidate explains it.");
        return;
    }
    double share = (o->chi2_dof_before - best->s.chi2_dof) / fmax(o->chi2_dof_before - 1.0, 1e-9);
    if (best->s.chi2_dof > noise && share < must_explain) {
        unexplained(d, "The best candidate leaves most of the misfit.");
        return;
    }
    if (best->s.chi2_dof > 2.0 && given) {
        unexplained(d, "The best candidate leaves more than noise.");
        return;
    }
    if (isfinite(before) && !(after < before)) {
        o->verdict = LAB_VERDICT_EXPLAINED;
        snprintf(o->reason, sizeof o->reason,
                 "The best candidate (%s at %s) fits better but does not predict the held-out "
                 "strokes better: no extension is made.",
                 best->s.candidate.effect->kind, best->s.candidate.place);
        return;
    }
    const char *class = best->s.candidate.effect->cls;
    for (int v = LAB_VERDICT_WRONG_PARAMETER; v <= LAB_VERDICT_MISSING_EFFECT; v++) {
        if (strcmp(class, lab_verdict_text((lab_verdict)v)) == 0) {
            o->verdict = (lab_verdict)v;
        }
    }
    count_rivals(d);
    say_cause(d, best);
}
