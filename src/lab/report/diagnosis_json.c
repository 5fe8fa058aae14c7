/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_json.c - diagnosis.json: the result for programs.
 *
 * The keys that a reader may rely on: verdict, causes, indistinguishable, next_experiment, gain,
 * noise_floor, audit, motion_check. Unknown values are null. RMSE and noise floor count in
 * units of the noise of one sample, everything else is SI.
 */
#include <math.h>
#include <string.h>

#include "curve.h"
#include "motion.h"
#include "planning.h"
#include "verdict.h"

static void write_number(lab__json *j, const char *name, const char *unit, double value, double lo,
                         double hi)
{
    lab__json_open(j, name, '{');
    lab__json_real(j, "value", value);
    lab__json_real(j, "lo", lo);
    lab__json_real(j, "hi", hi);
    lab__json_text(j, "unit", unit);
    lab__json_close(j);
}

/* fitted numbers; of one that was not refitted the predicted amount */
static void write_parameters(lab__json *j, const lab_suspect *s)
{
    lab__json_open(j, "parameters", '{');
    for (int i = 0; i < s->nnumber; i++) {
        const lab_cause_number *n = &s->number[i];
        write_number(j, n->name, n->unit, n->value, n->lo, n->hi);
    }
    if (s->nnumber == 0 && s->candidate.effect != NULL) {
        write_number(j, lab_candidate_size(&s->candidate), s->candidate.unit, s->amount, NAN, NAN);
    }
    lab__json_close(j);
}

/* numbers of the file that it changes; "change" has them in words, null: there are none */
static void write_changes(lab__json *j, const lab_suspect *s)
{
    char text[LAB_CHANGE_TEXT];
    lab__json_text(j, "change", *lab_change_text(s, text) != '\0' ? text : NULL);
    lab__json_open(j, "changes", '[');
    for (int i = 0; i < s->nchange; i++) {
        const lab_change *c = &s->change[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", c->name);
        lab__json_text(j, "written_in", c->unit);
        lab__json_real(j, "from", c->from);
        lab__json_real(j, "to", c->to);
        lab__json_real(j, "lo", c->lo);
        lab__json_real(j, "hi", c->hi);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static int is_change(const lab_suspect *s)
{
    return s->candidate.effect != NULL && s->candidate.from > 0 && s->candidate.until == 0;
}

/* the record of a wrong setting, the records behind one of which a change begins */
static void write_scope(lab__json *j, const lab_suspect *s)
{
    if (is_change(s)) {
        lab__json_text(j, "effect", s->candidate.effect->kind);
        lab__json_int(j, "after", s->after_most);
        lab__json_int(j, "after_at_least", s->after);
    } else if (s->candidate.from > 0) {
        lab__json_int(j, "stroke", s->candidate.from);
        lab__json_text(j, "file", s->file);
        lab__json_real(j, "stated", s->stated);
        lab__json_real(j, "fits", s->stated + s->amount);
    }
}

/* kind, place, what belongs to them */
static void write_name(lab__json *j, const lab_suspect *s)
{
    const lab_effect *e = s->candidate.effect;
    lab__json_text(j, "kind", is_change(s) ? "changed_after" : e != NULL ? e->kind : NULL);
    lab__json_text(j, "place", s->candidate.place);
    lab__json_text(j, "class", e != NULL ? e->cls : NULL);
    write_scope(j, s);
}

/* findings about the records: one with a wrong setting, one behind which they change */
static void write_odd_records(lab__json *j, const lab_diagnosis *d)
{
    const lab_suspect *change = NULL, *setting = NULL;
    for (int i = 0; i < d->ncause; i++) {
        const lab_suspect *s = &d->suspect[i];
        change = change == NULL && is_change(s) ? s : change;
        setting = setting == NULL && s->file != NULL ? s : setting;
    }
    if (change != NULL) {
        lab__json_int(j, "changed_after", change->after_most);
    } else {
        lab__json_null(j, "changed_after");
    }
    if (setting != NULL) {
        lab__json_open(j, "wrong_setting", '{');
        lab__json_text(j, "name", setting->candidate.place);
        lab__json_text(j, "unit", setting->candidate.unit);
        write_scope(j, setting);
        lab__json_real(j, "sd", setting->nnumber > 0 ? setting->number[0].sd : (double)NAN);
        lab__json_close(j);
    } else {
        lab__json_null(j, "wrong_setting");
    }
}

/* all numbers of its fit with their joint uncertainty; sd and correlation of the logarithm where
 * one was fitted */
static void write_posterior(lab__json *j, const lab_posterior *p)
{
    lab__json_open(j, "beside", '[');
    for (int i = 0; i < p->nbeside; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "kind", p->beside[i].effect->kind);
        lab__json_text(j, "place", p->beside[i].place);
        lab__json_real(j, "limit", p->beside[i].limit);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "posterior", '[');
    for (int i = 0; i < p->n; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", p->number[i].name);
        lab__json_bool(j, "logarithmic", p->number[i].logarithmic);
        lab__json_real(j, "value", p->number[i].value);
        lab__json_real(j, "sd", p->number[i].sd);
        lab__json_reals(j, "correlation", p->correlation + i * p->n, i);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void write_cause(lab__json *j, const lab_diagnosis *d, const lab_suspect *s)
{
    lab__json_open(j, NULL, '{');
    write_name(j, s);
    lab__json_text(j, "phase", d->phase);
    lab__json_text(j, "equation",
                   s->candidate.effect != NULL ? lab_candidate_equation(&s->candidate) : NULL);
    lab__json_text(j, "also_called", s->candidate.alias);
    write_parameters(j, s);
    write_changes(j, s);
    lab__json_open(j, "evidence", '{');
    lab__json_real(j, "gain", s->refitted ? s->gain : (double)NAN);
    lab__json_real(j, "predicted_gain", s->score);
    lab__json_real(j, "p", d->p);
    lab__json_real(j, "likeness", s->likeness);
    lab__json_real(j, "chi2_dof", s->chi2_dof);
    lab__json_real(j, "held_out", s->held_out);
    lab__json_open(j, "own", '{');
    lab__json_real(j, "ratio", s->own_ratio);
    lab__json_real(j, "lo", s->own_lo);
    lab__json_real(j, "hi", s->own_hi);
    lab__json_close(j);
    lab__json_close(j);
    lab__json_real(j, "limit", s->candidate.limit);
    write_posterior(j, &s->posterior);
    lab__json_close(j);
}

static void write_causes(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "causes", '[');
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        write_cause(j, d, &d->suspect[i]);
    }
    lab__json_close(j);
    lab__json_open(j, "indistinguishable", '[');
    for (int i = d->ncause; i < d->ncause + d->nrival && i < d->nsuspect; i++) {
        write_cause(j, d, &d->suspect[i]);
    }
    lab__json_close(j);
    if (d->next != NULL) {
        plan__experiment_json(j, "next_experiment", d->next, d);
    } else {
        lab__json_null(j, "next_experiment");
    }
}

static void write_used(lab__json *j, const char *key, const lab_used *u, int n, int noise)
{
    lab__json_open(j, key, '[');
    for (int i = 0; i < n; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", u[i].name);
        lab__json_text(j, "unit", u[i].unit);
        lab__json_real(j, "lo", u[i].lo);
        lab__json_real(j, "hi", u[i].hi);
        if (noise) {
            lab__json_real(j, "noise", u[i].noise);
        }
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* conditions of the strokes */
static void write_conditions(lab__json *j, const lab_conditions *c)
{
    lab__json_open(j, "conditions", '{');
    lab__json_real(j, "from", c->from);
    lab__json_real(j, "until", c->until);
    lab__json_real(j, "interval", c->interval);
    lab__json_bool(j, "unsynchronised", c->unsynchronised);
    write_used(j, "channels", c->channel, c->nchannel, 1);
    write_used(j, "inputs", c->input, c->ninput, 0);
    write_used(j, "settings", c->setting, c->nsetting, 0);
    lab__json_close(j);
}

static void write_errors(lab__json *j, const lab_gain *g)
{
    lab__json_real(j, "rmse_before", g->rmse_before);
    lab__json_real(j, "rmse_after", g->rmse_after);
    lab__json_real(j, "ratio", g->ratio);
    lab__json_real(j, "lo", g->lo);
    lab__json_real(j, "hi", g->hi);
}

static void write_gain(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "gain", '{');
    write_errors(j, &d->gain);
    lab__json_int(j, "held_out", d->nheld);
    lab__json_int(j, "samples", d->gain.samples);
    lab__json_close(j);
    lab__json_real(j, "noise_floor", d->noise_floor);
    lab__json_open(j, "gains", '[');
    for (int i = 0; i < d->ngain; i++) {
        const lab_gain *g = &d->gains[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "channel", g->channel);
        lab__json_text(j, "unit", g->unit);
        lab__json_text(j, "phase", g->phase);
        lab__json_int(j, "samples", g->samples);
        write_errors(j, g);
        lab__json_real(j, "noise", g->noise);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void write_audit(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "audit", '[');
    for (int i = 0; i < d->nfinding; i++) {
        lab__json_text(j, NULL, d->finding[i]);
    }
    lab__json_close(j);
}

/* detectability: amounts in the unit of its parameter, shares of its plausible limit */
static void write_power(lab__json *j, const lab_suspect *s)
{
    const lab_power *p = &s->power;
    int judged = p->presence != LAB_NOT_JUDGED;
    lab__json_text(j, "presence", lab_presence_text(p->presence));
    lab__json_text(j, "because", p->because);
    lab__json_real(j, "limit", s->candidate.limit);
    lab__json_text(j, "unit", s->candidate.unit);
    lab__json_real(j, "estimate", judged ? p->amount : (double)NAN);
    lab__json_real(j, "estimate_sd", judged ? p->sd : (double)NAN);
    lab__json_real(j, "detectable", judged ? p->detectable : (double)NAN);
    lab__json_real(j, "upper_limit", judged ? p->upper : (double)NAN);
    lab__json_real(j, "upper_share", judged ? p->upper / s->candidate.limit : (double)NAN);
}

static void write_suspects(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "suspects", '[');
    for (int i = 0; i < d->nsuspect; i++) {
        const lab_suspect *s = &d->suspect[i];
        lab__json_open(j, NULL, '{');
        write_name(j, s);
        lab__json_real(j, "predicted_gain", s->score);
        lab__json_real(j, "gain", s->refitted ? s->gain : (double)NAN);
        lab__json_bool(j, "refitted", s->refitted);
        lab__json_bool(j, "possible", s->possible);
        lab__json_real(j, "likeness", s->likeness);
        lab__json_real(j, "chi2_dof", s->chi2_dof);
        lab__json_real(j, "held_out", s->held_out);
        write_parameters(j, s);
        lab__json_text(j, "why", s->why);
        write_power(j, s);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void write_departures(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "departures", '[');
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *r = &d->departure[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, r->is_force ? "joint" : "channel", r->place);
        lab__json_text(j, "unit", r->unit);
        lab__json_text(j, "phase", r->phase);
        lab__json_int(j, "samples", r->samples);
        lab__json_real(j, r->is_force ? "force" : "rms", r->size);
        lab__json_real(j, r->is_force ? "sd" : "noise", r->sd);
        lab__json_real(j, "z", r->z);
        if (!r->is_force) {
            lab__json_real(j, "lag1", r->lag1);
        }
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void write_forces(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "missing_forces", '[');
    for (int i = 0; i < d->nlatent; i++) {
        const lab_latent *l = &d->latent[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "joint", l->joint);
        lab__json_text(j, "unit", l->unit);
        lab__json_text(j, "file", l->file);
        lab__json_reals(j, "time", l->t, l->n);
        lab__json_reals(j, "force", l->force, l->n);
        lab__json_reals(j, "sd", l->sd, l->n);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void write_fit(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "fit", '{');
    lab__json_int(j, "strokes", d->nfit);
    lab__json_int(j, "samples", d->samples);
    lab__json_real(j, "chi2_dof_before", d->chi2_dof_before);
    lab__json_real(j, "chi2_dof_after", d->chi2_dof_after);
    lab__json_open(j, "parameters", '[');
    for (int i = 0; i < d->nvalue; i++) {
        const lab_fit_value *v = &d->value[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", v->name);
        lab__json_real(j, "start", v->start);
        lab__json_real(j, "value", v->value);
        lab__json_real(j, "lo", v->lo);
        lab__json_real(j, "hi", v->hi);
        lab__json_text(j, "unit", v->unit);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_int(j, "fits", d->fits);
    lab__json_int(j, "strokes_simulated", d->strokes_simulated);
    lab__json_real(j, "seconds", d->seconds);
    lab__json_close(j);
    lab__json_open(j, "scatter", '{'); // sd of the logarithm, from stroke to stroke
    lab__json_real(j, "joint_friction", d->scatter[0]);
    lab__json_real(j, "contact_friction", d->scatter[1]);
    lab__json_real(j, "drive", d->scatter[2]);
    lab__json_close(j);
}

/* settings that differ from the records' statements */
static void write_settings_off(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "settings_off", '[');
    for (int i = 0; i < d->nsetting_off; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", d->setting_off[i].name);
        lab__json_text(j, "unit", d->setting_off[i].unit);
        lab__json_real(j, "rms", d->setting_off[i].rms);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* stroke by stroke: residual [noise], the amount of the first cause in it alone */
static void write_each(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "each", '[');
    for (int i = 0; i < d->nrecord; i++) {
        const lab_seen *s = &d->record[i];
        lab__json_open(j, NULL, '{');
        lab__json_int(j, "stroke", s->number);
        lab__json_text(j, "file", s->file);
        lab__json_text(j, "role", s->reporting ? "reporting" : "fitted");
        lab__json_real(j, "before", s->before);
        lab__json_real(j, "after", s->after);
        lab__json_real(j, "amount", s->amount);
        lab__json_real(j, "sd", s->sd);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* residual, fitted numbers, strokes */
static void write_remainder(lab__json *j, const lab_diagnosis *d)
{
    lab__json_open(j, "remainder", '{');
    lab__json_real(j, "noises", d->remainder);
    lab__json_real(j, "share", d->share);
    lab__json_close(j);
    lab__json_open(j, "families", '[');
    for (int i = 0; i < d->ncause + d->nrival && i < d->nsuspect; i++) {
        const char *family = lab_effect_family(d->suspect[i].candidate.effect);
        int known = 0;
        for (int k = 0; k < i; k++) {
            known |= strcmp(family, lab_effect_family(d->suspect[k].candidate.effect)) == 0;
        }
        if (!known) {
            lab__json_text(j, NULL, family);
        }
    }
    lab__json_close(j);
    lab__json_open(j, "refitted", '[');
    for (int i = 0; i < d->nvalue; i++) {
        const lab_fit_value *v = &d->value[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", v->name);
        lab__json_real(j, "value", v->value);
        lab__json_real(j, "lo", v->lo);
        lab__json_real(j, "hi", v->hi);
        lab__json_text(j, "unit", v->unit);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "strokes", '{');
    lab__json_int(j, "fitted", d->nfit);
    lab__json_int(j, "choosing", 0);
    lab__json_int(j, "reporting", d->nheld);
    write_each(j, d);
    lab__json_close(j);
    if (d->verified.done) {
        lab__json_bool(j, "verified", d->verified.same);
        lab__json_open(j, "verification", '{');
        lab__json_real(j, "rms_table", d->verified.table);
        lab__json_real(j, "rms_file", d->verified.file);
        lab__json_real(j, "difference", d->verified.file / d->verified.table - 1.0);
        lab__json_close(j);
    } else {
        lab__json_null(j, "verified");
    }
    if (d->explanation != NULL) {
        lab__json_text(j, "explanation", d->explanation);
    }
}

stein_status lab_diagnosis_json(const char *path, const lab_diagnosis *d, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__json j = {.stream = file.stream};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "verdict", lab_verdict_text(d->verdict));
    lab__json_text(&j, "reason", d->reason);
    lab__json_text(&j, "phase", d->phase);
    write_odd_records(&j, d);
    write_settings_off(&j, d);
    write_remainder(&j, d);
    write_causes(&j, d);
    diag__law_json(&j, d);
    diag__motion_json(&j, &d->motion);
    write_gain(&j, d);
    write_audit(&j, d);
    write_conditions(&j, &d->conditions);
    write_fit(&j, d);
    write_suspects(&j, d);
    write_departures(&j, d);
    write_forces(&j, d);
    lab__json_close(&j);
    return lab__file_close(&file, 1, err);
}
