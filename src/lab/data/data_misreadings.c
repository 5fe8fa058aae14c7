/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_misreadings.c - suspicions in words, and as a list.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_misreadings.h"

/* ---- words ---- */

/* the units that a factor suggests: the numbers are in `is` under a title that states `stated`.
 * @return 0: it is none between two units */
static int find_units(const char *unit, double factor, const char **is, const char **stated)
{
    static const struct {
        const char *unit, *small;
        double factor;
    } known[] = {{"m", "mm", 1e-3},
                 {"m", "cm", 1e-2},
                 {"rad", "deg", 1.0 / 57.295779513082321},
                 {"rad", "mrad", 1e-3},
                 {"s", "ms", 1e-3},
                 {"N", "mN", 1e-3},
                 {"N m", "mN m", 1e-3},
                 {"m/s", "mm/s", 1e-3},
                 {"m/s", "cm/s", 1e-2},
                 {"rad/s", "deg/s", 1.0 / 57.295779513082321}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        double up = factor / known[i].factor, down = factor * known[i].factor;
        if (strcmp(known[i].unit, unit) == 0 && fabs(up - 1.0) < 1e-6) {
            *is = known[i].small;
            *stated = unit;
            return 1;
        }
        if (strcmp(known[i].unit, unit) == 0 && fabs(down - 1.0) < 1e-6) {
            *is = unit;
            *stated = known[i].small;
            return 1;
        }
    }
    return 0;
}

/* "deg", "deg or mrad": the units that the numbers may be in; "" where a factor is between no two
 */
static const char *possible_units(char to[DATA_SHOWN], const char *unit, const data__guess *g,
                                  const char **stated)
{
    const char *is, *other;
    *to = '\0';
    if (find_units(unit, g->factor, &is, stated)) {
        snprintf(to, DATA_SHOWN, "%s", is);
    }
    for (int i = 0; *to != '\0' && i < g->nalso; i++) {
        size_t n = strlen(to);
        if (find_units(unit, g->also[i], &is, &other) && strcmp(other, *stated) == 0) {
            snprintf(to + n, DATA_SHOWN - n, " or %s", is);
        }
    }
    return to;
}

static const char *units_of(char *to, const char *unit, double factor)
{
    const char *is, *stated;
    if (find_units(unit, factor, &is, &stated)) {
        snprintf(to, DATA_SHOWN, "as %s instead of %s", is, stated);
    } else {
        snprintf(to, DATA_SHOWN, "times %.4g", factor);
    }
    return to;
}

/* "as deg or mrad instead of rad"; `state` out: how a title states the first of them */
static void reading_of(char *to, char *state, const char *unit, const data__guess *g,
                       const char *column)
{
    char units[DATA_SHOWN];
    const char *stated;
    *state = '\0';
    if (*possible_units(units, unit, g, &stated) == '\0') {
        units_of(to, unit, g->factor);
        return;
    }
    snprintf(to, 2 * DATA_SHOWN, "as %s instead of %s", units, stated);
    snprintf(state, 2 * DATA_SHOWN, "; a title states its unit as in \"%s (%.*s)\"", column,
             (int)strcspn(units, " "), units);
}

static size_t add_units(char *to, size_t room, const char *what, const char *unit,
                        const data__guess *g)
{
    char units[DATA_SHOWN];
    const char *stated;
    int n = *possible_units(units, unit, g, &stated) != '\0'
                ? snprintf(to, room, "%.60s is in %s, not in %s", what, units, stated)
                : snprintf(to, room, "%.60s is %.4g times too large", what, 1.0 / g->factor);
    return (size_t)n;
}

/* names of the columns of one unit */
static void list_columns(char *to, size_t room, const lab_data *d, const char *unit)
{
    size_t n = 0;
    *to = '\0';
    for (int k = 0; k < d->ncolumn && n + 2 * DATA_SHOWN < room; k++) {
        if (strcmp(d->column[k].unit, unit) == 0) {
            n += (size_t)snprintf(to + n, room - n, "%s%s", n > 0 ? ", " : "", d->column[k].name);
        }
    }
}

/* the first column of a unit */
static int first_of(const lab_data *d, const char *unit)
{
    int k = 0;
    while (k + 1 < d->ncolumn && strcmp(d->column[k].unit, unit) != 0) {
        k++;
    }
    return k;
}

static char *describe(const data__suspects *a, const data__guess *g, const char *or_column,
                      const char *records)
{
    const lab_data *d = a->data->stroke[g->first];
    const lab_column *c = g->a != NULL ? lab_data_column(d, g->a) : NULL;
    char unit[2 * DATA_SHOWN], state[2 * DATA_SHOWN], x[DATA_SHOWN], y[DATA_SHOWN], names[400],
        misfit[80];
    snprintf(misfit, sizeof misfit, "misfit %.2f, then %.2g%s", g->off / g->accepted,
             g->then / g->accepted, records);
    if (g->time != 1.0 && g->unit != NULL) {
        list_columns(names, sizeof names, d, g->unit);
        return lab__text("%s: time and %s: the record lasts %s, the model moves on another time "
                         "scale; with time read %s, and %s %s, it fits (%s)",
                         d->file, names, data__quantity(x, d->time[d->nrow - 1] - d->time[0], "s"),
                         units_of(unit, "s", g->time), names, units_of(y, g->unit, g->factor),
                         misfit);
    }
    if (g->time != 1.0) {
        return lab__text("%s: time: the record lasts %s, the model moves on another time scale; "
                         "read %s it fits (%s)",
                         d->file, data__quantity(x, d->time[d->nrow - 1] - d->time[0], "s"),
                         units_of(unit, "s", g->time), misfit);
    }
    if (g->b != NULL) {
        return lab__text("%s: %s and %s: each fits the prediction of the other; exchanged they fit "
                         "(%s)",
                         d->file, g->a, g->b, misfit);
    }
    if (g->factor < 0.0) {
        return lab__text(
            "%s: %s%s%s: moves against the model; with the opposite sign it fits: check "
            "the sign of the sensor and the sense of the joint (%s)",
            d->file, g->a, or_column != NULL ? " or " : "", or_column != NULL ? or_column : "",
            misfit);
    }
    const char *si = g->unit != NULL ? g->unit : c != NULL ? c->unit : "";
    list_columns(names, sizeof names, d, si);
    reading_of(unit, state, si, g, g->a != NULL ? g->a : d->column[first_of(d, si)].name);
    if (g->unit == NULL && c != NULL && c->role == LAB_INPUT) {
        return lab__text("%s: %s: with this input the model moves far from the record; read %s it "
                         "fits (%s)%s",
                         d->file, g->a, unit, misfit, state);
    }
    return lab__text("%s: %s: %s of travel, the model moves %s; read %s it fits (%s)%s", d->file,
                     g->unit != NULL ? names : g->a, data__quantity(x, g->travel, si),
                     data__quantity(y, g->predicted, si), unit, misfit, state);
}

/* the same as a headline */
static void briefly(char *to, size_t room, const lab_data *d, const data__guess *g,
                    const char *or_column)
{
    const lab_column *c = g->a != NULL ? lab_data_column(d, g->a) : NULL;
    const char *unit = g->unit != NULL ? g->unit : c != NULL ? c->unit : "";
    char names[400];
    size_t n = 0;
    list_columns(names, sizeof names, d, unit);
    if (g->time != 1.0) {
        n += add_units(to, room, "the time", "s", &(data__guess){.factor = g->time});
    }
    if (g->b != NULL) {
        snprintf(to, room, "%.60s and %.60s are exchanged", g->a, g->b);
    } else if (g->factor < 0.0) {
        snprintf(to, room, "%.60s%s%.60s has the opposite sign", g->a,
                 or_column != NULL ? " or " : "", or_column != NULL ? or_column : "");
    } else if (g->factor != 1.0 && n < room) {
        n += (size_t)snprintf(to + n, room - n, "%s", n > 0 ? "; " : "");
        (void)add_units(to + n, room - n, g->unit != NULL ? names : g->a, unit, g);
    }
}

/* ---- the list ---- */

static void add(data__suspects *a, lab_doubt doubt)
{
    lab_doubt *grown = realloc(a->out->item, sizeof *grown * ((size_t)a->out->n + 1));
    if (grown != NULL) {
        a->out->item = grown;
    }
    if (grown == NULL || doubt.text == NULL) {
        free(doubt.text);
        a->status = lab__no_memory(a->err);
        return;
    }
    grown[a->out->n++] = doubt;
    a->out->grave |= doubt.grave;
}

void data__tell_guess(data__suspects *a, const data__guess *g, const char *or_column, int records,
                      int alone)
{
    const lab_data *d = a->data->stroke[g->first];
    char many[80] = "";
    if (alone) {
        snprintf(many, sizeof many, "; this record alone");
    } else if (a->data->n > 1) {
        snprintf(many, sizeof many, "; so in %d of %d records that were tried", g->accepted,
                 g->tested);
    }
    data__reading reading;
    data__reading_of(g, d, &reading);
    const lab_column *either = or_column != NULL ? lab_data_column(d, or_column) : NULL;
    lab_doubt doubt = {.kind = g->time != 1.0    ? LAB_DOUBT_TIME
                               : g->b != NULL    ? LAB_DOUBT_SWAPPED
                               : g->factor < 0.0 ? LAB_DOUBT_SIGN
                                                 : LAB_DOUBT_SCALE,
                       .grave = 1,
                       .stroke = g->first,
                       .records = records,
                       .column = reading.column,
                       .other = either != NULL ? (int)(either - d->column) : reading.other,
                       .factor = g->time != 1.0 ? g->time : g->factor,
                       .off = g->off / g->accepted,
                       .then = g->then / g->accepted,
                       .text = describe(a, g, or_column, many)};
    briefly(doubt.brief, sizeof doubt.brief, d, g, or_column);
    add(a, doubt);
}

void data__tell_foreign(data__suspects *a, int record, double own, double median)
{
    const lab_data *d = a->data->stroke[record];
    add(a, (lab_doubt){.kind = LAB_DOUBT_ALIEN,
                       .stroke = record,
                       .records = 1,
                       .column = -1,
                       .other = -1,
                       .factor = 1.0,
                       .off = own,
                       .then = NAN,
                       .text = lab__text("%s: all columns: the motion cannot be reproduced (misfit "
                                         "%.2f, the median of all records %.2g); a record of "
                                         "another mechanism, or of other settings than it states, "
                                         "would look so",
                                         d->file, own, median)});
}

void data__tell_travel(data__suspects *a, int record, int column, double reach, double then)
{
    const lab_data *d = a->data->stroke[record];
    const data__match *m = &a->plain[record][column];
    char x[DATA_SHOWN], y[DATA_SHOWN];
    lab_doubt doubt = {.kind = LAB_DOUBT_SCALE,
                       .grave = 1,
                       .stroke = record,
                       .records = a->data->n,
                       .column = column,
                       .other = -1,
                       .factor = 1e-3,
                       .off = m->off,
                       .then = then,
                       .text = lab__text("%s: %s: %s of travel, the largest length of the model is "
                                         "%s; read as mm instead of m it would suit",
                                         d->file, d->column[column].name,
                                         data__quantity(x, m->travel, "m"),
                                         data__quantity(y, reach, "m"))};
    (void)add_units(doubt.brief, sizeof doubt.brief, d->column[column].name, "m",
                    &(data__guess){.factor = 1e-3});
    add(a, doubt);
}

void lab_doubts_free(lab_doubts *doubts)
{
    for (int i = 0; doubts != NULL && i < doubts->n; i++) {
        free(doubts->item[i].text);
    }
    if (doubts != NULL) {
        free(doubts->item);
        free(doubts);
    }
}

stein_status lab_suspicions(char ***finding, int *n, const lab_model *model,
                            const lab_dataset *data, stein_err *err)
{
    lab_doubts *doubts = NULL;
    stein_status status = lab_doubts_find(&doubts, model, data, err);
    if (status != STEIN_OK) {
        return status;
    }
    char **text = doubts->n > 0 ? calloc((size_t)doubts->n, sizeof *text) : NULL;
    if (doubts->n > 0 && text == NULL) {
        lab_doubts_free(doubts);
        return lab__no_memory(err);
    }
    *n = doubts->n;
    for (int i = 0; i < *n; i++) { // handed over
        text[i] = doubts->item[i].text;
        doubts->item[i].text = NULL;
    }
    *finding = text;
    lab_doubts_free(doubts);
    return STEIN_OK;
}

void lab_suspicions_free(char **finding, int n)
{
    for (int i = 0; i < n; i++) {
        free(finding[i]);
    }
    free(finding);
}
