/* SPDX-License-Identifier: GPL-3.0-or-later
 * bind.c - a candidate in a model: its parameters there, the model that has its part, its amount.
 *
 * Candidates are named by kind and place, parameters by index. So a candidate is bound to every
 * model in which it shall act, and its part, if it needs one, is written into the mechanism first.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "added_parts.h"

/* the part is there: its numbers by name */
static stein_status bind_part(lab_candidate *c, const lab_model *model, stein_err *err)
{
    const stein_model *m = lab_equations(model);
    char name[LAB_NUMBERS][LAB_PLACE];
    lab__structure_names(c, name);
    int at[LAB_NUMBERS];
    for (int i = 0; i < LAB_NUMBERS; i++) {
        at[i] = name[i][0] != '\0' ? stein_find_param(m, name[i]) : -1;
        if (name[i][0] != '\0' && at[i] < 0) {
            return lab__fail(err, STEIN_ENAME,
                             "%s has no number %s: the part of %s at %s is absent", m->name,
                             name[i], c->effect->kind, c->place);
        }
    }
    c->nparam = 1;
    c->param[0] = at[0];
    for (int k = 0; k < LAB_SIDES; k++) {
        c->side[k].param = at[1 + k];
    }
    for (int j = 0; j < m->nq; j++) {
        c->joint = strcmp(m->bodies[j].name, c->place) == 0 ? j : c->joint;
    }
    return STEIN_OK;
}

stein_status lab_candidate_bind(lab_candidate *c, const lab_model *model, stein_err *err)
{
    return c->effect->needs != NULL ? bind_part(c, model, err)
                                    : lab__bind_parameters(c, model, err);
}

stein_status lab__candidate_open_in(lab_candidate *c, lab_model **out, const lab_model *in,
                                    const char *file, const lab_options *options, stein_err *err)
{
    lab_model *model = NULL;
    char *text = NULL, *extended = NULL;
    size_t size = 0, more = 0;
    int rotor = strcmp(c->effect->kind, "armature") == 0; // of 0 there would be no number
    double amount = rotor || lab_effect_is_compliance(c->effect) ? c->start * c->limit : 0.0;
    stein_status status = lab__model_text(in, file, &text, &size, err);
    status = status == STEIN_OK ? lab__structure_text(c, amount, lab__mechanism(in), text, size,
                                                      &extended, &more, err)
                                : status;
    status =
        status == STEIN_OK ? lab__open_text(&model, file, extended, more, options, err) : status;
    status = status == STEIN_OK ? lab_candidate_bind(c, model, err) : status;
    free(text);
    free(extended);
    if (status != STEIN_OK) {
        lab_close(model);
        return status;
    }
    *out = model;
    return STEIN_OK;
}

stein_status lab__open_with(lab_model **out, const char *file, const lab_candidate *list, int n,
                            const lab_options *options, stein_err *err)
{
    lab_model *model = NULL;
    stein_status status = lab_open(&model, file, options, err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        lab_candidate c = list[i];
        lab_model *next = NULL;
        if (c.effect->needs != NULL) {
            status = lab__candidate_open_in(&c, &next, model, file, options, err);
            lab_close(model);
            model = next;
        }
    }
    *out = status == STEIN_OK ? model : NULL;
    return status;
}

stein_status lab_candidate_open(lab_candidate *c, lab_model **out, const char *file,
                                const lab_options *options, stein_err *err)
{
    lab_model *model = NULL;
    stein_status status = lab__open_with(&model, file, c, 1, options, err);
    status = status == STEIN_OK ? lab_candidate_bind(c, model, err) : status;
    if (status != STEIN_OK) {
        lab_close(model);
        return status;
    }
    *out = model;
    return STEIN_OK;
}

stein_status lab_candidates(lab_candidate **list, int *n, const lab_model *model, stein_err *err)
{
    return lab__candidates_at(list, n, model, lab_parameters(model), NULL, err);
}

int lab__is_share_of_nothing(const stein_model *m, const lab_effect *e, const char *place,
                             const double *p)
{
    char name[2 * LAB_PLACE];
    const char *share = lab_effect_share(e);
    if (share == NULL) {
        return 0;
    }
    snprintf(name, sizeof name, "%.99s.%.90s", place, share);
    int i = stein_find_param(m, name);
    return i < 0 || !(p[i] > 0.0);
}

int lab__is_in_table(const stein_model *m, const char *name)
{
    for (int i = 0; i < m->ntable; i++) {
        size_t n = strlen(m->tables[i].name);
        if (strncmp(name, m->tables[i].name, n) == 0 && name[n] == '.') {
            return 1;
        }
    }
    return 0;
}

void lab__size_link(lab_candidate *c, const stein_model *m, const double *p)
{
    char name[2 * LAB_PLACE];
    c->limit = 1.0;
    if (c->effect->side == NULL) {
        return;
    }
    // lower than the file states, and then of all its force
    c->move = LAB_MOVE_LOWER;
    c->limit = p[c->param[0]];
    c->start = 0.25;
    snprintf(name, sizeof name, "%s.%s", c->place, c->effect->side);
    c->side[0] = (lab_side){.name = c->effect->side,
                            .unit = "1",
                            .param = stein_find_param(m, name),
                            .value = 1.0,
                            .lo = 1.0,
                            .hi = 1.0};
}

int lab_candidate_acts(const lab_candidate *c, int number)
{
    return c->from == 0 || (number >= c->from && (c->until == 0 || number <= c->until));
}

const char *lab_candidate_scope(const lab_candidate *c, char text[LAB_PLACE])
{
    text[0] = '\0';
    if (c->from > 0) {
        snprintf(text, LAB_PLACE, c->until > 0 ? " of stroke %d" : " from stroke %d on", c->from);
    }
    return text;
}

void lab_candidate_apply(const lab_candidate *c, double amount, double *p)
{
    if (amount == 0.0) {
        return;
    }
    for (int i = 0; i < c->nparam; i++) {
        double v = p[c->param[i]];
        if (c->move == LAB_MOVE_SPRING) {
            double k = p[c->param[0]];
            p[c->param[1]] *= c->nparam > 1 && k + amount != 0.0 ? k / (k + amount) : 1.0;
            p[c->param[0]] = k + amount;
            break;
        }
        p[c->param[i]] = c->move == LAB_MOVE_ADD     ? v + amount
                         : c->move == LAB_MOVE_LOWER ? v - amount
                         : c->move == LAB_MOVE_VALUE ? amount
                                                     : v * stein__exp_of(amount);
    }
    for (int k = 0; k < LAB_SIDES; k++) {
        if (c->side[k].param >= 0) {
            p[c->side[k].param] = c->side[k].value;
        }
    }
}
