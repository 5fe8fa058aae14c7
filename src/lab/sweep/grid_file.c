/* SPDX-License-Identifier: GPL-3.0-or-later
 * grid_file.c - a grid for a mechanism file: would the file accept these values?
 *
 * The equations contain names and units. They contain neither the valid values (a negative mass
 * runs) nor the reason why a name is missing (unknown, a structural zero, given by a formula). The
 * reader of mechanism files has both, so it is called: it reads the file with each end of each axis
 * set, as --set would do it.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sweep.h"

/* the overrides of `options`, cut in two, with room for one more; text [nset] owns the memory */
static stein_status cut_sets(mech_set *set, char **text, const lab_options *options, stein_err *err)
{
    for (int i = 0; i < options->nset; i++) {
        size_t length = strcspn(options->set[i], "=");
        text[i] = lab__text("%s", options->set[i]);
        if (text[i] == NULL) {
            return lab__no_memory(err);
        }
        char *value = text[i] + length + (text[i][length] == '=');
        text[i][length] = '\0';
        set[i] = (mech_set){text[i], value};
    }
    return STEIN_OK;
}

/* read the file with name = value on top of the overrides; one of the same name gives way */
static stein_status read_with(const char *file, const lab_options *options, const char *name,
                              const char *value, stein_err *err)
{
    int n = options->nset, at = 0;
    char **text = calloc((size_t)n + 1, sizeof *text);
    mech_set *set = calloc((size_t)n + 1, sizeof *set);
    mechanism *m = NULL;
    stein_status status =
        text != NULL && set != NULL ? cut_sets(set, text, options, err) : lab__no_memory(err);
    if (status == STEIN_OK) {
        while (at < n && strcmp(set[at].name, name) != 0) {
            at++;
        }
        set[at] = (mech_set){name, value};
        status = mech_read(&m, file, set, at < n ? n : n + 1, NULL, NULL, err);
    }
    if (status == STEIN_OK) {
        mech_free(m);
    }
    for (int i = 0; text != NULL && i < n; i++) {
        free(text[i]);
    }
    free(text);
    free(set);
    return status;
}

/* problems of the reader with `set NAME = "VALUE": ` */
static const char *reason(const char *message)
{
    const char *at = strstr(message, "\": ");
    return at != NULL ? at + 3 : message;
}

/* why the equations have no parameter of this name */
static stein_status check_name(const char *name, const char *file, const lab_options *options,
                               stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    stein_status status = read_with(file, options, name, "1", &why);
    if (status == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        return lab__fail(err, STEIN_EINVAL, "vary %s: %s", name, reason(why.msg));
    }
    return lab__fail(err, STEIN_EINVAL,
                     "vary %s: it is a structural zero, which is not in the equations; --set "
                     "%s=VALUE adds it, then it can be varied",
                     name, name);
}

static stein_status check_axis(const lab__axis *a, const char *file, const lab_options *options,
                               stein_err *err)
{
    double low = a->value[0], high = a->value[0];
    for (int i = 1; i < a->n; i++) {
        low = fmin(low, a->value[i]);
        high = fmax(high, a->value[i]);
    }
    const double end[2] = {low, high};
    for (int i = 0; i < 2; i++) {
        char text[LAB_NUMBER];
        stein_err why = {STEIN_OK, ""};
        stein_status status = read_with(file, options, a->name, lab__number(text, end[i]), &why);
        if (status == STEIN_ENOMEM) {
            return lab__no_memory(err);
        }
        if (status != STEIN_OK) {
            return lab__fail(err, STEIN_EINVAL, "vary %s=%.60s: %s %s: %s", a->name, a->text, text,
                             a->unit, reason(why.msg));
        }
    }
    return STEIN_OK;
}

stein_status lab_grid_open(lab_grid **out, const lab_model *model, const char *const *vary,
                           int nvary, const char *file, const lab_options *options, stein_err *err)
{
    const stein_model *equations = lab_equations(model);
    lab_grid *grid = NULL;
    stein_status status = lab_grid_create(&grid, equations, vary, nvary, err);
    for (int i = 0; status == STEIN_ENAME && i < nvary; i++) {
        char name[MECH_PATH];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(vary[i], "="), vary[i]);
        if (stein_find_param(equations, name) < 0) {
            return check_name(name, file, options, err);
        }
    }
    for (int i = 0; status == STEIN_OK && i < grid->naxis; i++) {
        status = check_axis(&grid->axis[i], file, options, err);
    }
    if (status != STEIN_OK) {
        lab_grid_destroy(grid);
        return status;
    }
    *out = grid;
    return STEIN_OK;
}
