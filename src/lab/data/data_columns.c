/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_columns.c - "#" lines about a column: its noise, the band of a measured motion, events.
 *
 *      # noise NAME: 0.1 mm      standard deviation of one sample
 *      # smooth NAME: 12 Hz      a prescribed motion is taken as motion up to this frequency
 *      # events NAME: begin      it holds times of events (data_events.c)
 */
#include <math.h>
#include <string.h>

#include "data_internal.h"

const char *const data__about_word[DATA_ABOUTS] = {"noise", "smooth", "events"};

static lab_column *column_named(data__reader *r, const char *name)
{
    for (int i = 0; i < r->out->data.ncolumn; i++) {
        if (strcmp(r->out->column[i].name, name) == 0) {
            return &r->out->column[i];
        }
    }
    return NULL;
}

/* is there such a title, of a column that was refused? that has been told */
static int is_refused(const data__reader *r, const char *name)
{
    for (int k = 0; k < r->ntitle; k++) {
        if (k != r->time_at && !r->title[k].known && strcmp(r->title[k].name, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static void no_column(data__reader *r, const data__about *a)
{
    char hint[MECH_PATH + 32], shown[DATA_SHOWN];
    int known =
        stein_find_channel(r->model, a->name) >= 0 || stein_find_input(r->model, a->name) >= 0;
    data__problem(&r->problems, 0, a->line, a->name_column, "%s of \"%s\": %s%s",
                  data__about_word[a->word], data__shown(shown, a->name, strlen(a->name)),
                  known ? "no such column in this file" : "no such output or input of the model",
                  known ? "" : data__near_channel(hint, sizeof hint, r->model, a->name));
}

/* Is it a column that can be smoothed? */
static int is_motion(data__reader *r, const data__about *a, const lab_column *c)
{
    int motion = c->role == LAB_INPUT && r->model->inputs[c->index].kind == STEIN_INPUT_MOTION;
    if (!motion) {
        data__problem(&r->problems, 0, a->line, a->name_column,
                      "smooth of \"%s\": it is %s, expected a prescribed motion", c->name,
                      c->role == LAB_INPUT ? "a force or another input" : "an output");
    }
    return motion;
}

/* a number that is given once, greater than zero. @param to  NAN or 0: not given so far */
static void settle(data__reader *r, const data__about *a, const lab_column *c, mech_dim dim,
                   double *to)
{
    const char *word = data__about_word[a->word];
    stein_err err = {STEIN_OK, ""};
    double v = NAN;
    if (mech_parse_quantity(a->value, dim, &v, &err) != STEIN_OK) {
        data__problem(&r->problems, 0, a->line, a->value_column, "%s of \"%s\": %s", word, c->name,
                      err.msg);
    } else if (!(v > 0.0)) {
        data__problem(&r->problems, 0, a->line, a->value_column,
                      "%s of \"%s\": a %s is greater than zero", word, c->name,
                      a->word == DATA_NOISE ? "standard deviation" : "frequency");
    } else if (*to > 0.0 && *to != v) {
        data__problem(&r->problems, 0, a->line, a->name_column,
                      "the %s of \"%s\" is given twice, with different values", word, c->name);
    } else {
        *to = v;
    }
}

void data__settle_columns(data__reader *r)
{
    for (int i = 0; i < r->nabout && !r->options->inputs_only && !r->stop; i++) {
        const data__about *a = &r->about[i];
        lab_column *c = column_named(r, a->name);
        mech_dim dim = {.s = -1};
        if (c == NULL && is_refused(r, a->name)) {
            continue;
        }
        if (c == NULL) {
            no_column(r, a);
        } else if (a->word == DATA_NOISE) {
            mech_parse_unit(c->unit, &dim, NULL);
            settle(r, a, c, dim, &c->noise);
        } else if (a->word == DATA_SMOOTH && is_motion(r, a, c)) {
            settle(r, a, c, dim, &c->smooth);
        }
    }
}
