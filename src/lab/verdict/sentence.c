/* SPDX-License-Identifier: GPL-3.0-or-later
 * sentence.c - the verdict as a word and a reason, computed from what was measured.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "verdict.h"

enum { TOLD = 3 };
static const double noise_left = 1.05; /* remainder [noises] that is not mentioned */

static void append(lab_diagnosis *o, const char *text)
{
    size_t n = strlen(o->reason);
    snprintf(o->reason + n, sizeof o->reason - n, "%s", text);
}

/* "viscous_friction at slide and mass at cart" */
static void name_causes(lab_diagnosis *o)
{
    for (int i = 0; i < o->ncause; i++) {
        char one[2 * LAB_PLACE];
        snprintf(one, sizeof one, "%s%s at %s",
                 i == 0              ? ""
                 : i + 1 < o->ncause ? ", "
                                     : " and ",
                 o->suspect[i].candidate.effect->kind, o->suspect[i].candidate.place);
        append(o, one);
    }
    if (o->ncause == 1) {
        append(o, ": ");
        append(o, o->suspect[0].candidate.effect->equation);
    }
    append(o, ".");
}

/* the gain on reporting records: "better" only if its interval is below 1 */
static void say_gain(lab_diagnosis *o)
{
    char text[160];
    const lab_gain *g = &o->gain;
    if (!isfinite(g->ratio)) {
        return;
    }
    snprintf(text, sizeof text,
             g->hi < 1.0 ? " Held-out strokes are predicted better: %.3g -> %.3g noise."
                         : " Held-out strokes do not show it: %.3g -> %.3g noise.",
             g->rmse_before, g->rmse_after);
    append(o, text);
}

static void say_remainder(lab_diagnosis *o, const diag__judgement *j, const diag__setting *s)
{
    char text[160];
    if (o->chi2_dof_after > s->most_noise && o->remainder > noise_left) {
        snprintf(text, sizeof text,
                 " It explains %.0f %% of the misfit; %.2g noises remain, unexplained.",
                 100.0 * j->share, o->remainder);
        append(o, text);
    }
}

/* the number of a body, refitted since nothing fits otherwise, that moved furthest and was not
 * told; -1: none is left */
static int furthest(const lab_diagnosis *o, const diag__setting *s, const int *told, int n)
{
    int most = -1;
    double moved = 0.0;
    for (int i = 0; s->body != NULL && i < s->names && i < o->nvalue; i++) {
        const lab_fit_value *v = &o->value[i];
        double by = fabs(v->value - v->start) / v->prior_sd;
        int open = !isnan(s->body[i]);
        for (int k = 0; k < n; k++) {
            open = open && told[k] != i;
        }
        if (open && (most < 0 || by > moved)) {
            most = i;
            moved = by;
        }
    }
    return most;
}

static void say_bodies(lab_diagnosis *o, const diag__setting *s)
{
    int told[TOLD];
    for (int k = 0; k < TOLD && (told[k] = furthest(o, s, told, k)) >= 0; k++) {
        char text[240];
        const lab_fit_value *v = &o->value[told[k]];
        snprintf(text, sizeof text, "%s %s %.3g %s for %.3g",
                 k == 0
                     ? " The file states no tolerance of its bodies, and as they are nothing fits."
                       " Refitted:"
                     : ",",
                 v->name, v->value, v->unit, v->start);
        append(o, text);
    }
    if (s->body != NULL) {
        append(o, ".");
    }
}

static lab_verdict class_of(const lab_diagnosis *o)
{
    const char *class = o->suspect[0].candidate.effect->cls;
    for (int v = LAB_VERDICT_WRONG_PARAMETER; v <= LAB_VERDICT_MISSING_EFFECT; v++) {
        if (strcmp(class, lab_verdict_text((lab_verdict)v)) == 0) {
            return (lab_verdict)v;
        }
    }
    return LAB_VERDICT_MISSING_EFFECT;
}

void diag__say(lab_diagnosis *o, const diag__judgement *j, const diag__setting *s,
               const char *suspicion)
{
    char text[200];
    o->reason[0] = '\0';
    switch (j->finding) {
    case DIAG_EXPLAINED:
        o->verdict = LAB_VERDICT_EXPLAINED;
        append(o, s->assumed > 0
                      ? "The model explains the strokes: noise, scatter from stroke to stroke and "
                        "what a ruler and a scale leave open (the file states no tolerances) are "
                        "enough."
                      : "The model explains the strokes: noise, tolerances of the file and scatter "
                        "from stroke to stroke are enough.");
        break;
    case DIAG_NAMED:
        o->verdict = class_of(o);
        name_causes(o);
        say_remainder(o, j, s);
        say_gain(o);
        say_bodies(o, s);
        break;
    case DIAG_NO_CAUSE:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        append(o, "The residual is more than noise, and no candidate explains it.");
        break;
    case DIAG_MOST_LEFT:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        snprintf(text, sizeof text,
                 "The best candidate leaves most of the misfit: it explains %.0f %% of it.",
                 100.0 * fmax(0.0, j->share));
        append(o, text);
        break;
    case DIAG_UNDECIDED:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        append(o, "The residual is more than noise, and the best candidate's size may be 0.");
        break;
    case DIAG_FAR_OFF:
        o->verdict = LAB_VERDICT_UNUSABLE_MODEL;
        snprintf(text, sizeof text,
                 "The best of all hypotheses is %.2g noises from the records. Check %s first.",
                 o->remainder,
                 suspicion[0] != '\0' ? "this"
                                      : "signs of channels and joints, planes, units, the "
                                        "start and the clock");
        append(o, text);
        if (suspicion[0] != '\0') {
            append(o, " ");
            append(o, suspicion);
        }
        break;
    case DIAG_NOT_CONVERGED:
        o->verdict = LAB_VERDICT_NOT_CONVERGED;
        append(o, "The fits have not converged: this says nothing about physics yet.");
        break;
    }
}
