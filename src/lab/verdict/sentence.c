/* SPDX-License-Identifier: GPL-3.0-or-later
 * sentence.c - the verdict as a word and a reason, computed from what was measured.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "verdict.h"

enum { TOLD = 3 };

static void append(lab_diagnosis *o, const char *text)
{
    size_t n = strlen(o->reason);
    snprintf(o->reason + n, sizeof o->reason - n, "%s", text);
}

/* ---- numbers ---- */

/* a value as the files write it: g, mm, deg; its sd tells how many digits. @return text */
static const char *quantity(char *text, size_t size, double value, double sd, const char *unit)
{
    static const struct {
        const char *si, *shown;
        double factor, below; /* used below this magnitude [SI] */
    } scale[] = {{"kg", "mg", 1e6, 5e-4},   {"kg", "g", 1e3, 1.0},
                 {"m", "mm", 1e3, 1.0},     {"s", "ms", 1e3, 1.0},
                 {"N m", "mN m", 1e3, 1.0}, {"rad", "deg", 57.29577951308232, INFINITY}};
    double factor = 1.0;
    const char *shown = strcmp(unit, "1") == 0 ? "" : unit;
    for (size_t i = 0; i < sizeof scale / sizeof *scale; i++) {
        if (strcmp(unit, scale[i].si) == 0 && fabs(value) < scale[i].below) {
            factor = scale[i].factor;
            shown = scale[i].shown;
            break;
        }
    }
    if (sd > 0.0 && isfinite(sd)) {
        int decimals = 1 - (int)floor(log10(factor * sd));
        decimals = decimals < 0 ? 0 : decimals > 9 ? 9 : decimals;
        snprintf(text, size, "%.*f +- %.*f%s%s", decimals, factor * value, decimals, factor * sd,
                 *shown != '\0' ? " " : "", shown);
    } else {
        snprintf(text, size, "%.4g%s%s", factor * value, *shown != '\0' ? " " : "", shown);
    }
    return text;
}

/* ---- causes ---- */

static int acts_in_all(const lab_suspect *s)
{
    return s->candidate.from == 0;
}

static int is_setting(const lab_suspect *s)
{
    return s->candidate.until > 0;
}

static int is_change(const lab_suspect *s)
{
    return s->candidate.from > 0 && s->candidate.until == 0;
}

/* how many causes are of a kind */
static int count(const lab_diagnosis *o, int (*is)(const lab_suspect *s))
{
    int n = 0;
    for (int i = 0; i < o->ncause; i++) {
        n += is(&o->suspect[i]);
    }
    return n;
}

/* "viscous_friction at slide and mass at cart" of those of a kind, with amounts where asked for */
static void list_causes(lab_diagnosis *o, int (*is)(const lab_suspect *s), int amounts)
{
    int n = count(o, is), k = 0;
    for (int i = 0; i < o->ncause; i++) {
        const lab_suspect *s = &o->suspect[i];
        char one[2 * LAB_PLACE], size[60] = "";
        if (!is(s)) {
            continue;
        }
        if (amounts) {
            quantity(size, sizeof size, s->amount, s->number[0].sd, s->number[0].unit);
        }
        snprintf(one, sizeof one, "%s%s at %s%s%s",
                 k == 0      ? ""
                 : k + 1 < n ? ", "
                             : " and ",
                 s->candidate.effect->kind, s->candidate.place,
                 !amounts          ? ""
                 : s->amount > 0.0 ? " +"
                                   : " ",
                 size);
        append(o, one);
        k++;
    }
}

/* "Record 5: its load.mass does not fit its samples (f6_05.csv): 105 g in the file, 100.1 +- 0.2 g
 * would fit." */
void diag__say_setting(lab_diagnosis *o, const lab_suspect *s)
{
    char text[3 * LAB_PLACE], in_file[60], fits[60];
    const char *base = s->file != NULL ? strrchr(s->file, '/') : NULL;
    snprintf(
        text, sizeof text,
        "Record %d: its %s does not fit its samples (%.80s): %s in the file, %s would fit.",
        s->candidate.from, s->candidate.place,
        base != NULL      ? base + 1
        : s->file != NULL ? s->file
                          : "-",
        quantity(in_file, sizeof in_file, s->stated, 0.0, s->candidate.unit),
        quantity(fits, sizeof fits, s->stated + s->amount, s->number[0].sd, s->candidate.unit));
    append(o, text);
}

/* "The records change after record 6: mass at hammer +100 +- 3 mg from record 7 on." */
static void say_change(lab_diagnosis *o)
{
    char text[80];
    const lab_suspect *first = NULL;
    for (int i = 0; i < o->ncause; i++) {
        first = first == NULL && is_change(&o->suspect[i]) ? &o->suspect[i] : first;
    }
    if (first == NULL) {
        return;
    }
    if (first->after < first->after_most) {
        snprintf(text, sizeof text, "The records change between records %d and %d: ", first->after,
                 first->after_most + 1);
    } else {
        snprintf(text, sizeof text, "The records change after record %d: ", first->after_most);
    }
    append(o, text);
    list_causes(o, is_change, 1);
    snprintf(text, sizeof text, " from record %d on.", first->candidate.from);
    append(o, text);
}

/* One cause of two names: an inertia and an armature that move alike, the gain of a channel and the
 * place of the point that it tracks. */
static void say_same(lab_diagnosis *o, const lab_candidate *c)
{
    int rotor = strcmp(c->effect->kind, "armature") == 0 || strstr(c->alias, ".armature") != NULL;
    int point = strcmp(c->effect->kind, "sensor_gain") == 0;
    if ((rotor || point) && c->alias[0] != '\0') {
        append(o, o->ncause > 1 ? " exactly like a change of " : ", the same as a change of ");
        append(o, c->alias);
    }
}

static void name_causes(lab_diagnosis *o)
{
    if (count(o, acts_in_all) > 0) {
        list_causes(o, acts_in_all, 0);
        append(o, o->ncause == 1 ? ": " : ".");
    }
    if (o->ncause == 1 && count(o, acts_in_all) == 1) {
        append(o, lab_candidate_equation(&o->suspect[0].candidate));
        say_same(o, &o->suspect[0].candidate);
        append(o, ".");
    }
    for (int i = 0; o->ncause > 1 && i < o->ncause; i++) {
        const lab_candidate *c = &o->suspect[i].candidate;
        if (acts_in_all(&o->suspect[i]) && strcmp(c->effect->kind, "sensor_gain") == 0 &&
            c->alias[0] != '\0') {
            append(o, " ");
            append(o, c->effect->kind);
            append(o, " at ");
            append(o, c->place);
            append(o, " acts");
            say_same(o, c);
            append(o, ".");
        }
    }
    for (int i = 0; i < o->ncause; i++) {
        if (is_setting(&o->suspect[i])) {
            append(o, o->reason[0] != '\0' ? " " : "");
            diag__say_setting(o, &o->suspect[i]);
        }
    }
    if (count(o, is_change) > 0) {
        append(o, o->reason[0] != '\0' ? " " : "");
        say_change(o);
    }
}

/* the gain on reporting records: "better" only if its interval is below 1 */
static void say_gain(lab_diagnosis *o)
{
    char text[160];
    const lab_gain *g = &o->gain;
    if (!isfinite(g->ratio) || count(o, is_setting) == o->ncause) {
        return; // one record's own says nothing of others
    }
    snprintf(
        text, sizeof text,
        " %s held out are predicted %s: an error of %.3g without and %.3g with %s, in standard "
        "deviations of the noise.",
        o->in_pieces ? "Pieces of the records" : "Records", g->hi < 1.0 ? "better" : "no better",
        g->rmse_before, g->rmse_after, o->ncause == 1 ? "it" : "them");
    append(o, text);
}

static void say_remainder(lab_diagnosis *o, const diag__judgement *j, const diag__setting *s)
{
    char text[160];
    if (o->chi2_dof_after > s->most_noise && o->remainder > 1.0 + diag__slack) {
        snprintf(text, sizeof text,
                 " %s %.0f %% of the misfit; what is left in the fitted records is %.2g standard "
                 "deviations of the noise, unexplained.",
                 o->ncause == 1 ? "It explains" : "They explain", 100.0 * j->share, o->remainder);
        append(o, text);
    }
}

/* "Settings are not what the records say: upper.initial.position by 0.3 deg (RMS)." */
static void say_settings(lab_diagnosis *o)
{
    char text[LAB_PLACE + 80], size[60];
    for (int i = 0; i < o->nsetting_off; i++) {
        const lab_setting_off *s = &o->setting_off[i];
        snprintf(text, sizeof text, "%s%s by %s",
                 i == 0 ? " Settings are not what records say: " : ", ", s->name,
                 quantity(size, sizeof size, s->rms, 0.0, s->unit));
        append(o, text);
    }
    append(o, o->nsetting_off > 0 ? " (RMS)." : "");
}

static void say_input_noise(lab_diagnosis *o, const diag__setting *s)
{
    char text[120];
    if (s->input > 1.0 + diag__slack) {
        snprintf(text, sizeof text,
                 " Noise of the measured forces alone moves the simulation by %.2g noises.",
                 s->input);
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

/* the candidate that is furthest from 0 beside the causes, though not named */
static void say_beside(lab_diagnosis *o)
{
    const lab_suspect *most = NULL;
    for (int i = o->ncause; i < o->nsuspect; i++) {
        const lab_suspect *s = &o->suspect[i];
        double z = fabs(s->power.amount) / s->power.sd;
        int more = most == NULL || z > fabs(most->power.amount) / most->power.sd;
        most = s->power.beside && more ? s : most;
    }
    if (most != NULL) {
        char text[2 * LAB_PLACE], size[60];
        snprintf(
            text, sizeof text,
            " %s at %s may act beside: %s, too little to be named; the intervals allow for it.",
            most->candidate.effect->kind, most->candidate.place,
            quantity(size, sizeof size, most->power.amount, most->power.sd, most->candidate.unit));
        append(o, text);
    }
}

void diag__say(lab_diagnosis *o, const diag__judgement *j, const diag__setting *s, const char *near,
               const char *suspicion)
{
    char text[400];
    o->reason[0] = '\0';
    switch (j->finding) {
    case DIAG_EXPLAINED:
        o->verdict = LAB_VERDICT_EXPLAINED;
        append(o,
               s->assumed > 0
                   ? "The model explains the records: noise, scatter from record to record and "
                     "what a ruler and a scale leave open where the file states no tolerance are "
                     "enough."
                   : "The model explains the records: noise, tolerances of the file and scatter "
                     "from record to record are enough.");
        say_settings(o);
        say_input_noise(o, s);
        break;
    case DIAG_NAMED:
        o->verdict = diag__verdict_of(&o->suspect[0]);
        name_causes(o);
        say_settings(o);
        say_remainder(o, j, s);
        say_input_noise(o, s);
        say_gain(o);
        say_beside(o);
        say_bodies(o, s);
        break;
    case DIAG_NO_CAUSE:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        append(o, "The residual is more than noise, and no candidate explains it");
        if (near[0] != '\0') {
            snprintf(text, sizeof text,
                     " beyond doubt; the nearest one, %.200s, explains %.0f %% of the misfit", near,
                     100.0 * j->near);
            append(o, text);
        }
        append(o, ".");
        break;
    case DIAG_NOT_SHOWN:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        append(o, "The residual is more than noise. What explains it best where it was fitted does "
                  "not show in the records that were held out, and is no cause.");
        break;
    case DIAG_NOT_HELD:
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        snprintf(text, sizeof text,
                 "The fitted records leave noise, those held out %.*f standard deviations of it. "
                 "They show something that the fitted ones do not: fit such records, too.",
                 o->gain.rmse_after < 10.0, o->gain.rmse_after);
        append(o, text);
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
