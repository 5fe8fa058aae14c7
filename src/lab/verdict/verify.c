/* SPDX-License-Identifier: GPL-3.0-or-later
 * verify.c - does extended.yaml reproduce the fit? It is read again, as a file like any
 * other, and the records are simulated with its numbers.
 *
 *      table   RMS residual of the hypothesis (or law) of the verdict, in noise
 *      file    the same of extended.yaml, without any candidate in it
 *
 * What is a record's own - start, trigger, offsets, scatter - is as it was fitted; the numbers of
 * all records are the file's. A difference is an error of this program.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "motion.h"
#include "added_parts.h"
#include "verdict.h"

static const double same = 0.01; /* relative difference of two RMS that is none */

/* does the file describe this record? A change half-way is written as it is from then on. */
static int is_described(const lab_diagnosis *o, const lab_data *data)
{
    int yes = 1;
    for (int i = 0; i < o->ncause; i++) {
        const lab_candidate *c = &o->suspect[i].candidate;
        yes &= c->until > 0 ? !lab_candidate_acts(c, data->number)
                            : lab_candidate_acts(c, data->number);
    }
    return yes;
}

/* sum of squares and samples of the records that the file describes */
static double sum_of(const lab_diagnosis *o, const fit__problem *p, const double *r, double *n)
{
    double sum = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        const double *v = r + fit__offset(p, s);
        if (is_described(o, t->data)) {
            sum += lab__dot(v, v, (size_t)t->nch * (size_t)t->n);
            *n += t->samples;
        }
    }
    return sum;
}

/* the records of one side, simulated with the numbers of the file; their squares are added */
static stein_status simulate(const lab_model *model, const diag__side *as, const lab_diagnosis *o,
                             double *square, stein_err *err)
{
    lab_dataset *own = NULL;
    fit__problem p = {.nstroke = 0};
    double *x = NULL, n = 0.0;
    int failed = 0;
    lab_fit_def def = *as->p->def;
    def.nfree = 0; // what all records share is the file's
    stein_status status = diag__read_again(as->p->data, model, &own, err);
    status =
        status == STEIN_OK ? fit__problem_make_with(&p, model, own, &def, NULL, 0, err) : status;
    if (status == STEIN_OK) {
        x = calloc((size_t)p.nu + fit__offset(&p, p.nstroke) + 1, sizeof *x);
        status = x != NULL ? STEIN_OK : lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        p.tolerance = as->p->tolerance;
        p.simulated = as->p->simulated;
        diag__own_unknowns(as->p, as->x, &p, x);
        for (int s = 0; s < p.nstroke; s++) { // as the row has it, where noise was estimated
            memcpy(p.stroke[s].noise, as->p->stroke[s].noise,
                   sizeof *p.stroke[s].noise * (size_t)p.stroke[s].nch);
        }
        status = fit__residuals(&p, x, x + p.nu, &failed, err);
    }
    if (status == STEIN_OK) {
        *square += failed > 0 ? (double)INFINITY : sum_of(o, &p, x + p.nu, &n);
    }
    free(x);
    fit__problem_free(&p);
    lab_dataset_close(own);
    return status;
}

static void compare(lab_diagnosis *o, double table, double file, double n)
{
    lab_verified *v = &o->verified;
    v->table = sqrt(table / n);
    v->file = sqrt(file / n);
    v->done = 1;
    v->same = fabs(v->file - v->table) <= same * v->table;
}

stein_status diag__verify(const diag__problem *q, const diag__side *side, int nside,
                          lab_diagnosis *o, stein_err *err)
{
    char *text = NULL;
    lab_model *model = NULL;
    lab_options options = q->def->options != NULL ? *q->def->options : lab_options_default();
    double table = 0.0, file = 0.0, n = 0.0;
    options.nset = 0;
    stein_status status = lab__extended_text(&text, q->file, o, err);
    status = status == STEIN_OK ? lab__open_text(&model, q->file, text, strlen(text), &options, err)
                                : status;
    for (int i = 0; status == STEIN_OK && i < nside; i++) {
        table += sum_of(o, side[i].p, side[i].r, &n);
        status = simulate(model, &side[i], o, &file, err);
    }
    if (status == STEIN_OK && n > 0.0) {
        compare(o, table, file, n);
    }
    lab_close(model);
    free(text);
    return status;
}
