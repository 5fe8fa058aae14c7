/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit_json.c - a fit, for programs. What cannot be known is null.
 */
#include "fitting.h"

static void json_value(lab__json *out, const lab_fit_value *v, int with_unit)
{
    lab__json_open(out, NULL, '{');
    lab__json_text(out, "name", v->name);
    lab__json_real(out, "value", v->value);
    if (with_unit) {
        lab__json_text(out, "unit", v->unit);
    }
    lab__json_real(out, "sd", v->sd);
    lab__json_real(out, "lo", v->lo);
    lab__json_real(out, "hi", v->hi);
    lab__json_real(out, "start", v->start);
    lab__json_real(out, "prior_sd", v->prior_sd);
    if (v->param >= 0) {
        lab__json_real(out, "data_sd", v->data_sd);
        lab__json_bool(out, "unseen", v->unseen);
        lab__json_bool(out, "logarithmic", v->logarithmic);
        if (v->profiled) {
            lab__json_open(out, "profile", '{');
            lab__json_real(out, "lo", v->profile_lo); // null: open
            lab__json_real(out, "hi", v->profile_hi);
            lab__json_close(out);
        }
    }
    lab__json_close(out);
}

static void json_strokes(lab__json *out, const lab_fit *fit)
{
    lab__json_open(out, "strokes", '[');
    for (int s = 0, i = 0; s < fit->nstroke; s++) {
        const lab_fit_stroke *t = &fit->stroke[s];
        char hash[20];
        snprintf(hash, sizeof hash, "%016llx", t->hash);
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "file", t->file);
        lab__json_text(out, "fnv1a64", hash);
        lab__json_int(out, "rows", t->rows);
        lab__json_int(out, "lacking_events", t->lacking);
        lab__json_real(out, "chi2", t->chi2);
        lab__json_open(out, "nuisances", '[');
        for (int k = 0; k < t->nvalue; k++) {
            json_value(out, &t->value[k], 1);
        }
        lab__json_close(out);
        lab__json_open(out, "channels", '[');
        for (; i < fit->nresidual && fit->residual[i].stroke == s; i++) {
            const lab_fit_residual *r = &fit->residual[i];
            lab__json_open(out, NULL, '{');
            lab__json_text(out, "channel", r->channel);
            lab__json_text(out, "unit", r->unit);
            lab__json_int(out, "samples", r->samples);
            lab__json_real(out, "noise", r->noise);
            lab__json_bool(out, "noise_given", r->noise_given);
            lab__json_real(out, "rms", r->rms);
            lab__json_real(out, "relative", r->relative);
            lab__json_int(out, "downweighted", r->downweighted);
            lab__json_close(out);
        }
        lab__json_close(out);
        lab__json_close(out);
    }
    lab__json_close(out);
}

static void json_collinear(lab__json *out, const lab_fit *fit)
{
    lab__json_open(out, "collinear", '[');
    for (int i = 0; i < fit->npair; i++) {
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "a", fit->value[fit->pair[i].a].name);
        lab__json_text(out, "b", fit->value[fit->pair[i].b].name);
        lab__json_real(out, "correlation", fit->pair[i].correlation);
        lab__json_close(out);
    }
    lab__json_close(out);
    lab__json_real(out, "condition", fit->condition);
    lab__json_open(out, "weakest", '{');
    lab__json_real(out, "sd", fit->weakest_sd);
    lab__json_open(out, "combination", '{');
    for (int k = 0; k < fit->nvalue; k++) {
        lab__json_real(out, fit->value[k].name, fit->weakest[k]);
    }
    lab__json_close(out);
    lab__json_close(out);
}

stein_status lab_fit_json(const char *path, const char *model, const lab_fit *fit, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__json out = {.stream = file.stream};
    lab__json_open(&out, NULL, '{');
    lab__json_text(&out, "model", model);
    lab__json_text(&out, "status", lab_fit_status_text(fit->status));
    lab__json_text(&out, "reason", fit->reason[0] != '\0' ? fit->reason : NULL);
    lab__json_open(&out, "parameters", '[');
    for (int k = 0; k < fit->nvalue; k++) {
        json_value(&out, &fit->value[k], 1);
    }
    lab__json_close(&out);
    lab__json_real(&out, "chi2", fit->chi2);
    lab__json_real(&out, "prior", fit->prior);
    lab__json_int(&out, "samples", fit->samples);
    lab__json_int(&out, "dof", fit->dof);
    lab__json_real(&out, "chi2_dof", fit->chi2_dof);
    lab__json_open(&out, "band", '[');
    lab__json_real(&out, NULL, fit->band_lo);
    lab__json_real(&out, NULL, fit->band_hi);
    lab__json_close(&out);
    lab__json_real(&out, "inflation", fit->inflation);
    lab__json_bool(&out, "noise_given", fit->noise_given);
    lab__json_real(&out, "gradient", fit->gradient);
    lab__json_real(&out, "sensitivity_error", fit->sensitivity_error);
    lab__json_open(&out, "starts", '[');
    for (int i = 0; i < fit->nstart; i++) {
        lab__json_open(&out, NULL, '{');
        lab__json_real(&out, "objective", fit->start[i].objective);
        lab__json_int(&out, "iterations", fit->start[i].iterations);
        lab__json_bool(&out, "ended", fit->start[i].ended);
        lab__json_bool(&out, "agrees", fit->start[i].agrees);
        lab__json_close(&out);
    }
    lab__json_close(&out);
    json_collinear(&out, fit);
    json_strokes(&out, fit);
    lab__json_close(&out);
    return lab__file_close(&file, 1, err);
}
