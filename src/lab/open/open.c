/* SPDX-License-Identifier: GPL-3.0-or-later
 * open.c - a mechanism file becomes equations with values.
 *
 *   file --reader--> mechanism --same structure built in?--> use those equations
 *                        |      --else--> generator --> C text, hash --same hash built in?--> those
 *                        |                                           --else--> cache, compiler,
 *                        +--> values, by name                                  loader
 *
 * A changed number may change the structure (a zero that is none any more). Equal hashes, of all
 * that equations depend on or of their text, prove that equations and file belong together. The
 * descriptor handed out is a copy with the file's values as defaults, so that equations which were
 * first compiled for unfit values do not keep failing with those.
 */
#include <stdlib.h>
#include <string.h>

#include "open.h"
#include "stein/load.h"
#include "stein/models.h"

struct lab_model {
    stein_model equations; /* copy; params are the ones below */
    stein_param *params;   /* [np] */
    double *values;        /* [np] */
    mechanism *mech;       /* owns the texts of names and units in use */
    stein_library *library;
    char *text; /* it was opened from, NULL: its file */
    size_t size;
};

lab_options lab_options_default(void)
{
    return (lab_options){NULL, 0, NULL, NULL, NULL, NULL};
}

/* "NAME=VALUE" texts cut in two */
typedef struct overrides {
    mech_set *set;
    char **text; /* [n] the memory behind set */
    int n;
} overrides;

static void free_overrides(overrides *o)
{
    for (int i = 0; o->text != NULL && i < o->n; i++) {
        free(o->text[i]);
    }
    free(o->text);
    free(o->set);
}

static stein_status cut_overrides(overrides *o, const lab_options *options, stein_err *err)
{
    o->n = options->nset;
    o->set = calloc((size_t)o->n + 1, sizeof *o->set);
    o->text = calloc((size_t)o->n + 1, sizeof *o->text);
    int memory = o->set != NULL && o->text != NULL;
    for (int i = 0; memory && i < o->n; i++) {
        const char *sign = strchr(options->set[i], '=');
        if (sign == NULL || sign == options->set[i]) {
            return lab__fail(err, STEIN_EINVAL, "override \"%s\": expected NAME=VALUE",
                             options->set[i]);
        }
        o->text[i] = lab__text("%s", options->set[i]);
        memory = o->text[i] != NULL;
        if (memory) {
            char *cut = o->text[i] + (sign - options->set[i]);
            *cut = '\0';
            o->set[i] = (mech_set){o->text[i], cut + 1};
        }
    }
    return memory ? STEIN_OK : lab__no_memory(err);
}

static const stein_model *built_in(const mechanism *mech)
{
    char hash[17];
    gen_structure(mech, hash);
    for (const lab__structure *s = lab__structures; s->hash != NULL; s++) {
        if (strcmp(s->hash, hash) == 0) {
            return s->model;
        }
    }
    return NULL;
}

/* the same equations may come of other structures: of a formula that is written otherwise */
static const stein_model *built_in_text(const char *equations)
{
    for (int i = 0; stein_models[i] != NULL; i++) {
        if (strcmp(stein_models[i]->equations, equations) == 0) {
            return stein_models[i];
        }
    }
    return NULL;
}

static stein_status find_equations(lab_model *model, const stein_model **found,
                                   const lab_options *options, stein_err *err)
{
    gen_result generated;
    *found = built_in(model->mech);
    if (*found != NULL) {
        return STEIN_OK;
    }
    stein_status status = gen_equations(&generated, model->mech, err);
    if (status != STEIN_OK) {
        return status;
    }
    *found = built_in_text(generated.equations);
    if (*found == NULL) {
        status = lab__compiled(&model->library, found, model->mech, &generated, options, err);
    }
    gen_free(&generated);
    return status;
}

/* copy of the descriptor with the file's values for the equations' parameters, matched by name */
static stein_status take_values(lab_model *model, const stein_model *found, stein_err *err)
{
    const mechanism *mech = model->mech;
    size_t np = (size_t)found->np;
    model->params = malloc(sizeof *model->params * (np + 1));
    model->values = malloc(sizeof *model->values * (np + 1));
    if (model->params == NULL || model->values == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < found->np; i++) {
        int k = mech_find_param(mech, found->params[i].name, NULL);
        if (k < 0) {
            return lab__fail(err, STEIN_ESTALE,
                             "the equations of \"%s\" have a parameter \"%s\" that %s has not",
                             found->name, found->params[i].name, mech->file);
        }
        model->params[i] = found->params[i];
        model->params[i].value = model->values[i] = mech->params[k].value;
        model->params[i].tolerance = mech->params[k].tolerance;
        model->params[i].stated = mech->params[k].stated;
    }
    model->equations = *found;
    model->equations.name = mech->name;
    model->equations.params = model->params;
    model->equations.dt = mech->dt;
    model->equations.until = mech->until;
    model->equations.integrator = mech->integrator;
    model->equations.settle = mech->settle;
    return STEIN_OK;
}

static stein_status copy_text(const char *text, size_t size, char **to, size_t *nto, stein_err *err)
{
    *to = malloc(size + 1);
    if (*to == NULL) {
        return lab__no_memory(err);
    }
    memcpy(*to, text, size);
    (*to)[size] = '\0';
    *nto = size;
    return STEIN_OK;
}

/* text NULL: the file's */
static stein_status open_model(lab_model **out, const char *file, const char *text, size_t size,
                               const lab_options *options, stein_err *err)
{
    lab_options defaults = lab_options_default();
    options = options != NULL ? options : &defaults;
    lab_model *model = calloc(1, sizeof *model);
    if (model == NULL) {
        return lab__no_memory(err);
    }
    const stein_model *found = NULL;
    overrides given = {NULL, NULL, 0};
    stein_status status = cut_overrides(&given, options, err);
    if (status == STEIN_OK && text == NULL) {
        status =
            mech_read(&model->mech, file, given.set, given.n, options->report, options->ctx, err);
    } else if (status == STEIN_OK) {
        status = mech_read_text(&model->mech, file, text, size, given.set, given.n, options->report,
                                options->ctx, err);
    }
    if (status == STEIN_OK && text != NULL) {
        status = copy_text(text, size, &model->text, &model->size, err);
    }
    if (status == STEIN_OK) {
        status = find_equations(model, &found, options, err);
    }
    if (status == STEIN_OK) {
        status = take_values(model, found, err);
    }
    free_overrides(&given);
    if (status != STEIN_OK) {
        lab_close(model);
        return status;
    }
    *out = model;
    return STEIN_OK;
}

stein_status lab_open(lab_model **out, const char *file, const lab_options *options, stein_err *err)
{
    return open_model(out, file, NULL, 0, options, err);
}

stein_status lab__open_text(lab_model **out, const char *name, const char *text, size_t size,
                            const lab_options *options, stein_err *err)
{
    return open_model(out, name, text, size, options, err);
}

stein_status lab__model_text(const lab_model *model, const char *file, char **text, size_t *size,
                             stein_err *err)
{
    return model->text != NULL ? copy_text(model->text, model->size, text, size, err)
                               : lab__read_file(file, text, size, err);
}

const mechanism *lab__mechanism(const lab_model *model)
{
    return model->mech;
}

void lab_close(lab_model *model)
{
    if (model != NULL) {
        stein_library_close(model->library);
        if (model->mech != NULL) {
            mech_free(model->mech);
        }
        free(model->params);
        free(model->values);
        free(model->text);
        free(model);
    }
}

const stein_model *lab_equations(const lab_model *model)
{
    return &model->equations;
}

const double *lab_parameters(const lab_model *model)
{
    return model->values;
}

stein_status lab_sim(const lab_model *model, const stein_sim_def *def, stein_sim **sim,
                     stein_err *err)
{
    return stein_sim_create(sim, &model->equations, def, err);
}

stein_status lab_quantity(double *value, const char *text, const char *unit, stein_err *err)
{
    mech_dim dim;
    stein_err why;
    if (mech_parse_unit(unit, &dim, NULL) != 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%s\" is no unit", unit);
    }
    return mech_parse_quantity(text, dim, value, &why) == STEIN_OK
               ? STEIN_OK
               : lab__fail(err, STEIN_EINVAL, "%s", why.msg);
}

stein_sim_def lab_def(const lab_model *model)
{
    return stein_sim_def_default(&model->equations);
}

double lab_until(const lab_model *model)
{
    return model->equations.until;
}

stein_status lab_expressions(char **text, const lab_model *model, const char *what, stein_err *err)
{
    return gen_expressions(text, model->mech, what, err);
}
