/* SPDX-License-Identifier: GPL-3.0-or-later
 * write_plan.c - plan.json, and the best experiment as a file that can be simulated and diagnosed.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "planning.h"

/* ---- strokes ---- */

static void write_head(FILE *f, const lab_experiment *e, const plan__reference *b,
                       const plan__model *side)
{
    char number[LAB_NUMBER];
    for (int i = 0; i < e->nset; i++) {
        fprintf(f, "# set %s: %s %s\n", e->set[i].name, lab__number(number, e->set[i].value),
                e->set[i].unit);
    }
    for (int c = 0; c < b->noutput; c++) {
        if (b->output[c].measured || strcmp(b->output[c].name, e->channel) == 0) {
            fprintf(f, "# noise %s: %s\n", b->output[c].name,
                    lab__number(number, b->output[c].noise));
        }
    }
    fprintf(f, "# prediction: ");
    for (int i = 0; i < side->n; i++) {
        fprintf(f, "%s%s at %s", i > 0 ? " and " : "", side->candidate[i].effect->kind,
                side->candidate[i].place);
    }
    fprintf(f, ", without noise\n# experiment: %s\n", e->name);
    fprintf(f, "time [s]");
    int input = stein_find_input(b->m, e->input);
    if (input >= 0) {
        fprintf(f, ",%s [%s]", e->input, b->m->inputs[input].unit);
    }
    for (int c = 0; c < b->noutput; c++) {
        if (b->output[c].measured || strcmp(b->output[c].name, e->channel) == 0) {
            const char *unit = b->m->channels[stein_find_channel(b->m, b->output[c].name)].unit;
            fprintf(f, ",%s [%s]", b->output[c].name, unit);
        }
    }
    fprintf(f, "\n");
}

static void write_rows(FILE *f, const lab_experiment *e, const plan__reference *b,
                       const plan__prediction *v)
{
    char number[LAB_NUMBER];
    for (int i = 0; i < v->rows; i++) {
        fprintf(f, "%s", lab__number(number, v->time[i]));
        if (e->input[0] != '\0') {
            double u = e->zero + e->size * lab_shape_at(e->shape, e->time, v->time[i]);
            fprintf(f, ",%s", lab__number(number, u));
        }
        for (int c = 0; c < b->noutput; c++) {
            if (b->output[c].measured || strcmp(b->output[c].name, e->channel) == 0) {
                fprintf(f, ",%.9g", v->y[c * v->rows + i] * b->output[c].noise);
            }
        }
        fprintf(f, "\n");
    }
}

stein_status lab_plan_stroke(const char *path, const lab_experiment *e, int suspect,
                             const char *file, const lab_model *model, const lab_diagnosis *d,
                             const lab_plan_def *def, stein_err *err)
{
    const lab_plan_def plain = lab_plan_def_default(), *used = def != NULL ? def : &plain;
    plan__model side[2] = {{.s = NULL}, {.s = NULL}}; // the cause, for the reference; the candidate
    plan__reference b = {.def = NULL};
    plan__prediction v = {.y = NULL};
    lab__file out;
    if (e->ncheck > 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%s\" is a check of an instrument: it has no record",
                         e->name);
    }
    if (suspect < 0 || suspect >= d->nsuspect || d->ncause < 1) {
        return lab__fail(err, STEIN_EINVAL, "no suspect %d in the diagnosis", suspect);
    }
    stein_status status =
        plan__model_open(&side[0], &d->suspect[0], file, model, used->options, err);
    if (status == STEIN_OK) {
        status = plan__model_open(&side[1], &d->suspect[suspect], file, model, used->options, err);
    }
    if (status == STEIN_OK) {
        status = plan__reference_make(&b, &side[0], d, lab_equations(model), used, err);
    }
    status = status == STEIN_OK ? plan__predict(&v, &b, &side[1], e, 1, err) : status;
    status = status == STEIN_OK ? lab__file_open(&out, path, err) : status;
    if (status == STEIN_OK) {
        write_head(out.stream, e, &b, &side[1]);
        write_rows(out.stream, e, &b, &v);
        status = lab__file_close(&out, 1, err);
    }
    plan__prediction_free(&v);
    plan__reference_free(&b);
    plan__model_close(&side[0]);
    plan__model_close(&side[1]);
    return status;
}

/* ---- plan.json ---- */

static void write_suspect(lab__json *j, const char *key, const lab_candidate *c)
{
    lab__json_open(j, key, '{');
    lab__json_text(j, "kind", c->effect->kind);
    lab__json_text(j, "place", c->place);
    lab__json_close(j);
}

/* a cause or rival, and what acts beside it */
static void write_hypothesis(lab__json *j, const char *key, const lab_suspect *s)
{
    lab__json_open(j, key, '{');
    lab__json_text(j, "kind", s->candidate.effect->kind);
    lab__json_text(j, "place", s->candidate.place);
    lab__json_open(j, "beside", '[');
    for (int i = 0; i < s->posterior.nbeside; i++) {
        write_suspect(j, NULL, &s->posterior.beside[i]);
    }
    lab__json_close(j);
    lab__json_close(j);
}

static void write_checks(lab__json *j, const lab_experiment *e)
{
    lab__json_open(j, "check", '[');
    for (int i = 0; i < e->ncheck; i++) {
        const lab_check *c = &e->check[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "instrument", c->of[0] != '\0' ? c->of : "clock");
        lab__json_text(j, "beside", plan__check_by(c));
        lab__json_open(j, "numbers", '[');
        for (int k = 0; k < c->n; k++) {
            lab__json_text(j, NULL, c->number[k].name);
        }
        lab__json_close(j);
        lab__json_open(j, "file", '[');
        for (int k = 0; k < c->n; k++) {
            lab__json_real(j, NULL, c->number[k].file);
        }
        lab__json_close(j);
        lab__json_real(j, "noise", c->noise);
        lab__json_real(j, "reach", c->reach);
        lab__json_close(j);
    }
    lab__json_close(j);
}

void plan__experiment_json(lab__json *j, const char *key, const lab_experiment *e,
                           const lab_diagnosis *d)
{
    static const char *const shape[] = {NULL, "rise", "there_and_back", "swing"};
    lab__json_open(j, key, '{');
    lab__json_text(j, "experiment", e->name);
    lab__json_text(j, "why", e->why);
    lab__json_bool(j, "feasible", e->feasible);
    lab__json_real(j, "odds", e->odds);
    lab__json_real(j, "odds_worst", e->odds_worst);
    if (e->feasible && e->repeats > 0) {
        lab__json_int(j, "repeats", e->repeats);
    } else {
        lab__json_null(j, "repeats");
    }
    lab__json_bool(j, "all_pairs", e->all);
    if (e->feasible) {
        write_suspect(j, "against", &d->suspect[e->against].candidate);
    } else {
        lab__json_null(j, "against");
    }
    write_checks(j, e);
    lab__json_open(j, "set", '{');
    for (int i = 0; i < e->nset; i++) {
        lab__json_real(j, e->set[i].name, e->set[i].value);
    }
    lab__json_close(j);
    if (e->input[0] != '\0') {
        lab__json_open(j, "drive", '{');
        lab__json_text(j, "input", e->input);
        lab__json_text(j, "shape", shape[e->shape]);
        lab__json_real(j, "from", e->zero);
        lab__json_real(j, "to", e->zero + e->size);
        lab__json_real(j, "time", e->time);
        lab__json_close(j);
    } else {
        lab__json_null(j, "drive");
    }
    lab__json_text(j, "channel", e->channel[0] != '\0' ? e->channel : NULL);
    lab__json_int(j, "frames_for_one", e->faster);
    lab__json_real(j, "beyond", e->beyond);
    lab__json_close(j);
}

stein_status lab_plan_json(const char *path, const lab_plan *p, const lab_diagnosis *d,
                           char *const *stroke, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__json j = {.stream = file.stream};
    lab__json_open(&j, NULL, '{');
    if (d->ncause > 0) {
        write_hypothesis(&j, "cause", &d->suspect[0]);
    } else {
        lab__json_null(&j, "cause");
    }
    lab__json_open(&j, "rivals", '[');
    for (int i = d->ncause, n = 0; n < p->nrival && i < d->ncause + d->nrival; i++) {
        if (d->suspect[i].posterior.n > 0) {
            write_hypothesis(&j, NULL, &d->suspect[i]);
            n++;
        }
    }
    lab__json_close(&j);
    lab__json_int(&j, "left_out", p->left_out);
    lab__json_real(&j, "odds_wanted", p->wanted);
    lab__json_int(&j, "most_repeats", p->most);
    lab__json_open(&j, "experiments", '[');
    for (int i = 0; i < p->n; i++) {
        plan__experiment_json(&j, NULL, &p->experiment[i], d);
    }
    lab__json_close(&j);
    lab__json_text(&j, "stroke", stroke != NULL ? stroke[0] : NULL);
    lab__json_text(&j, "stroke_of_rival", stroke != NULL ? stroke[1] : NULL);
    lab__json_int(&j, "strokes_simulated", p->strokes);
    lab__json_real(&j, "seconds", p->seconds);
    lab__json_close(&j);
    return lab__file_close(&file, 1, err);
}

/* ---- all files ---- */

/* the best experiment that is a stroke; NULL: there is none */
static const lab_experiment *best_stroke(const lab_plan *p)
{
    int i = 0;
    while (i < p->n && p->experiment[i].ncheck > 0) {
        i++;
    }
    return i < p->n && p->experiment[i].feasible ? &p->experiment[i] : NULL;
}

stein_status lab_plan_files(const char *folder, const lab_plan *plan, const char *file,
                            const lab_model *model, const lab_diagnosis *diagnosis,
                            const lab_plan_def *def, char **path, stein_err *err)
{
    static const char *const name[] = {"plan.json", "next_stroke.csv", "next_rival.csv"};
    const lab_experiment *best = best_stroke(plan);
    stein_status status = lab__folder(folder, err);
    for (int i = 0; i < LAB_PLAN_FILES; i++) {
        int wanted = i == LAB_PLAN_JSON || best != NULL;
        path[i] = status == STEIN_OK && wanted ? lab__text("%s/%s", folder, name[i]) : NULL;
        status = status == STEIN_OK && wanted && path[i] == NULL ? lab__no_memory(err) : status;
    }
    for (int i = LAB_PLAN_STROKE; status == STEIN_OK && best != NULL && i <= LAB_PLAN_RIVAL; i++) {
        status = lab_plan_stroke(path[i], best, i == LAB_PLAN_STROKE ? 0 : best->against, file,
                                 model, diagnosis, def, err);
    }
    return status == STEIN_OK ? lab_plan_json(path[LAB_PLAN_JSON], plan, diagnosis,
                                              best != NULL ? &path[LAB_PLAN_STROKE] : NULL, err)
                              : status;
}
