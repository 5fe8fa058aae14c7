/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis.c - a diagnosis: its words, its contents, its release.
 */
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "motion.h"

const char *lab_verdict_text(lab_verdict verdict)
{
    static const char *const text[] = {"explained",     "wrong_parameter", "sensor",
                                       "input",         "missing_effect",  "unknown_effect",
                                       "not_converged", "unusable_model"};
    return text[verdict];
}

lab_verdict diag__verdict_of(const lab_suspect *s)
{
    const lab_effect *effect = s->candidate.effect;
    if (effect && !effect->both_signs && s->amount < 0.0) {
        return LAB_VERDICT_WRONG_PARAMETER; // it is there, but smaller than the file has it
    }
    for (int v = LAB_VERDICT_WRONG_PARAMETER; effect && v <= LAB_VERDICT_MISSING_EFFECT; v++) {
        if (strcmp(effect->cls, lab_verdict_text((lab_verdict)v)) == 0) {
            return (lab_verdict)v;
        }
    }
    return LAB_VERDICT_MISSING_EFFECT;
}

const char *diag__verdict_words(lab_verdict verdict)
{
    static const char *const words[] = {"nothing to find", "a wrong number",   "an instrument",
                                        "the input",       "a missing effect", "an unknown effect",
                                        "no fit to trust", "no usable model"};
    return words[verdict];
}

const char *diag__record_word(const lab_diagnosis *d)
{
    return d->in_pieces ? "piece" : "record";
}

const char *diag__counts(char to[DIAG_COUNTS], const lab_diagnosis *d)
{
    const char *s = d->nfit == 1 ? "" : "s";
    if (d->slip[0] != '\0') {
        snprintf(to, DIAG_COUNTS, "nothing was fitted");
    } else if (d->in_pieces) {
        snprintf(to, DIAG_COUNTS, "%d piece%s of %d record%s fitted, %d held out", d->nfit, s,
                 d->nfile, d->nfile == 1 ? "" : "s", d->nheld);
    } else {
        snprintf(to, DIAG_COUNTS, "%d record%s fitted, %d held out", d->nfit, s, d->nheld);
    }
    return to;
}

stein_status diag__show(lab_diagnosis *d, const fit__problem *p, const double *x, const double *r,
                        const double *J, const char *const *phase, const double *time,
                        stein_err *err)
{
    double *own = NULL;
    stein_status status = diag__departures(p, r, phase, &d->departure, &d->ndeparture, err);
    if (status == STEIN_OK && J == NULL) {
        own = malloc(sizeof *own * (fit__columns(p) + 1));
        status = own != NULL ? fit__sensitivities(p, x, r, own, err) : lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        status = diag__missing_force(p, x, r, J != NULL ? J : own, phase, time, &d->departure,
                                     &d->ndeparture, &d->latent, &d->nlatent, err);
    }
    free(own);
    return status;
}

static void free_trace(lab_trace *t)
{
    free(t->t);
    free(t->y);
    free(t->before);
    free(t->after);
    free(t->phase);
}

void lab_diagnosis_destroy(lab_diagnosis *d)
{
    if (d == NULL) {
        return;
    }
    for (int i = 0; d->finding != NULL && i < d->nfinding; i++) {
        free(d->finding[i]);
    }
    for (int i = 0; d->trace != NULL && i < d->ntrace; i++) {
        free_trace(&d->trace[i]);
    }
    for (int i = 0; d->latent != NULL && i < d->nlatent; i++) {
        free(d->latent[i].t);
        free(d->latent[i].force);
        free(d->latent[i].sd);
    }
    diag__posteriors_free(d);
    diag__laws_drop(d);
    diag__motion_free(&d->motion);
    free(d->explanation);
    free(d->suspect);
    free(d->record);
    free(d->gains);
    free(d->value);
    free(d->finding);
    free(d->trace);
    free(d->departure);
    free(d->latent);
    for (int i = 0; i < d->nkept; i++) {
        lab_close(d->kept[i]);
    }
    free(d->kept);
    lab_dataset_close(d->pieces);
    free(d);
}
