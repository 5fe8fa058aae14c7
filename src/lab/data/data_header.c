/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_header.c - the lines above the rows of a data file: "#" lines and the titles of columns.
 *
 * Every name is looked up in the model at once, and every unit is checked against the one the model
 * has for that name. A record in the wrong unit, or of another mechanism, is refused before a
 * single row is read. A title without a unit is taken as SI; records that do not move like the
 * model are then reported before any fit (data_suspicions.c).
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"
#include "reader.h"
#include "added_parts.h"

/* a new copy of n bytes, NUL at the end; NULL without memory, which the problems record */
static char *copy(data__reader *r, const char *s, size_t n)
{
    char *copy = n < SIZE_MAX ? malloc(n + 1) : NULL;
    if (copy == NULL) {
        r->problems.nomem = 1;
        return NULL;
    }
    memcpy(copy, s, n);
    copy[n] = '\0';
    return copy;
}

/* ---- "#" lines ---- */

/* a part of a line: from, to in bytes, without blanks around it */
typedef struct part {
    size_t from, to;
} part;

static part trimmed(const char *text, size_t from, size_t to)
{
    while (from < to && (text[from] == ' ' || text[from] == '\t')) {
        from++;
    }
    while (to > from && (text[to - 1] == ' ' || text[to - 1] == '\t')) {
        to--;
    }
    return (part){from, to};
}

/* does the part begin with this word, alone? then it is taken off */
static int take_word(const char *text, part *p, const char *word)
{
    size_t n = strlen(word), left = p->to - p->from;
    if (left < n || memcmp(text + p->from, word, n) != 0 ||
        (left > n && text[p->from + n] != ' ' && text[p->from + n] != '\t')) {
        return 0;
    }
    *p = trimmed(text, p->from + n, p->to);
    return 1;
}

static void keep_note(data__reader *r, char *name, char *value)
{
    lab_note *grown = realloc(r->out->note, sizeof *grown * ((size_t)r->out->data.nnote + 1));
    if (grown == NULL) {
        r->problems.nomem = 1;
        free(name);
        free(value);
        return;
    }
    r->out->note = grown;
    r->out->note[r->out->data.nnote++] = (lab_note){name, value, r->lines.line};
}

/* "# set key_wire.k: 0" of a model that has no wire: the stroke was made without it, which is
 * evidence about a supposed wire */
static void note_without(data__reader *r, const char *name, double value, int at_value)
{
    if (value != 0.0) {
        data__problem(&r->problems, 0, r->lines.line, at_value,
                      "set %s: \"%s\" has no such part, so it can only be 0: taken off", name,
                      r->model->name);
        return;
    }
    char *without = copy(r, LAB_NOTE_WITHOUT, strlen(LAB_NOTE_WITHOUT));
    char *n = copy(r, name, strlen(name));
    if (n == NULL || without == NULL) {
        free(n);
        free(without);
        return;
    }
    keep_note(r, without, n);
}

int data__has_last_word(const stein_model *m, const char *param)
{
    int instrument = strstr(param, ".sensor.") != NULL || strncmp(param, "clock.", 6) == 0;
    return instrument || lab__comes_off(m, param) != NULL;
}

/* one of the last digit that a number is written with: "0.1 mm" of "-0.3 mm" */
static double last_digit(const char *value, mech_dim dim)
{
    char text[DATA_SHOWN];
    stein_err err;
    double step = 0.0;
    size_t whole = strspn(value, "+-0123456789"), n = whole;
    size_t decimals = value[n] == '.' ? strspn(value + n + 1, "0123456789") : 0;
    n += value[n] == '.' ? 1 + decimals : 0;
    if (whole == 0 && decimals == 0) {
        return 0.0;
    }
    snprintf(text, sizeof text, "%s%.*s1%s", decimals > 0 ? "0." : "",
             decimals > 0 ? (int)decimals - 1 : 0, "00000000000000000000", value + n);
    return mech_parse_quantity(text, dim, &step, &err) == STEIN_OK ? step : 0.0;
}

/* @param known  1: it was measured by itself */
static void add_setting(data__reader *r, const char *name, const char *value, int known,
                        int at_name, int at_value)
{
    data__file *out = r->out;
    stein_err err = {STEIN_OK, ""};
    char hint[MECH_PATH + 32], shown[DATA_SHOWN];
    mech_dim dim = {.kg = 0};
    double v = NAN;
    int line = r->lines.line, k = stein_find_param(r->model, name);
    const char *unit = k >= 0 ? r->model->params[k].unit : lab__comes_off(r->model, name);
    if (unit == NULL) {
        int load = strncmp(name, "load.", 5) == 0 && r->model->load.body < 0;
        data__problem(&r->problems, 0, line, at_name, "\"%s\" sets no parameter of \"%s\"%s",
                      data__shown(shown, name, strlen(name)), r->model->name,
                      load ? ", which has no load"
                           : data__near_param(hint, sizeof hint, r->model, name));
        return;
    }
    mech_parse_unit(unit, &dim, NULL);
    if (mech_parse_quantity(value, dim, &v, &err) != STEIN_OK) {
        data__problem(&r->problems, 0, line, at_value, "set %s: %s", name, err.msg);
        return;
    }
    if (k < 0) {
        note_without(r, name, v, at_value);
        return;
    }
    for (int i = 0; i < out->data.nset; i++) {
        const lab_setting *other = &out->set[i];
        if (other->param == k && other->value != v) {
            char a[LAB_NUMBER], b[LAB_NUMBER];
            data__problem(&r->problems, 0, line, at_name,
                          "%s is set to %s %s here and to %s %s in "
                          "line %d: one record has one value",
                          name, lab__number(a, v), unit, lab__number(b, other->value), unit,
                          other->line);
            return;
        }
        if (other->param == k) {
            out->set[i].last_word |= known;
            return;
        }
    }
    lab_setting *grown = realloc(out->set, sizeof *grown * ((size_t)out->data.nset + 1));
    if (grown == NULL) {
        r->problems.nomem = 1;
        return;
    }
    out->set = grown;
    out->set[out->data.nset++] = (lab_setting){
        r->model->params[k].name, k, v, line, at_name, known || data__has_last_word(r->model, name),
        last_digit(value, dim)};
}

static void set_trigger(data__reader *r, const char *value, int at)
{
    static const char *const words[] = {"synchronised", "synchronized", "unsynchronised",
                                        "unsynchronized"};
    char shown[DATA_SHOWN];
    lab_trigger found = LAB_TRIGGER_UNSTATED;
    for (int i = 0; i < 4; i++) {
        if (strcmp(value, words[i]) == 0) {
            found = i < 2 ? LAB_TRIGGER_SYNCHRONISED : LAB_TRIGGER_UNSYNCHRONISED;
        }
    }
    if (found == LAB_TRIGGER_UNSTATED) {
        data__problem(&r->problems, 0, r->lines.line, at,
                      "trigger \"%s\": expected synchronised or "
                      "unsynchronised",
                      data__shown(shown, value, strlen(value)));
    } else if (r->trigger_line > 0 && r->out->data.trigger != found) {
        data__problem(&r->problems, 0, r->lines.line, at,
                      "the trigger is %s here and something "
                      "else in line %d",
                      value, r->trigger_line);
    } else {
        r->out->data.trigger = found;
        r->trigger_line = r->lines.line;
    }
}

static void keep_about(data__reader *r, data__about about)
{
    data__about *grown = realloc(r->about, sizeof *grown * ((size_t)r->nabout + 1));
    if (grown == NULL) {
        r->problems.nomem = 1;
        free(about.name);
        free(about.value);
        return;
    }
    r->about = grown;
    r->about[r->nabout++] = about;
}

/* the word that begins a line about a column. @return -1: none of them */
static int about_word(const char *text, part *word)
{
    int i = 0;
    while (i < DATA_ABOUTS && !take_word(text, word, data__about_word[i])) {
        i++;
    }
    return i < DATA_ABOUTS ? i : -1;
}

void data__note_line(data__reader *r, const char *text, size_t size)
{
    part all = trimmed(text, 1, size);
    const char *colon = memchr(text + all.from, ':', all.to - all.from);
    part name = trimmed(text, all.from, colon != NULL ? (size_t)(colon - text) : all.from);
    part value = trimmed(text, colon != NULL ? (size_t)(colon - text) + 1 : all.from, all.to);
    part word = colon != NULL ? name : all;
    int plain = r->options->inputs_only; // signals alone: no statement about a stroke
    int known = !plain && take_word(text, &word, "known");
    int set = known || (!plain && take_word(text, &word, "set"));
    int about = plain || set ? -1 : about_word(text, &word);
    int at_name = data__column(text, (int)word.from),
        at_value = data__column(text, (int)value.from);
    if ((set || about >= 0) && (colon == NULL || word.from == word.to)) {
        data__problem(&r->problems, 0, r->lines.line, at_name, "expected \"# %s NAME: VALUE\"",
                      known ? "known"
                      : set ? "set"
                            : data__about_word[about]);
        r->stop |= about == DATA_EVENTS; // the contents of its column are unknown
        return;
    }
    if (++r->notes > DATA_NOTES) {
        data__problem(&r->problems, 1, r->lines.line, 1, "more than %d lines above the header",
                      (int)DATA_NOTES);
        r->stop = 1;
        return;
    }
    part called = set || about >= 0 ? word : name;
    char *n = copy(r, text + called.from, called.to - called.from);
    char *v = copy(r, text + value.from, value.to - value.from);
    if (n == NULL || v == NULL || set || (!plain && strcmp(n, "trigger") == 0)) {
        if (n != NULL && v != NULL && set) {
            add_setting(r, n, v, known, at_name, at_value);
        } else if (n != NULL && v != NULL) {
            set_trigger(r, v, at_value);
        }
        free(n);
        free(v);
    } else if (about >= 0) {
        keep_about(r, (data__about){about, n, v, r->lines.line, at_name, at_value});
    } else {
        keep_note(r, n, v);
    }
}

/* ---- titles ---- */

/* unit of a title against the model's; without one it is SI, and the audit reports it.
 * @return 1 when it fits */
static int fit_unit(data__reader *r, data__title *t, const char *wanted)
{
    int line = r->header_line;
    if (t->has_unit < 0) {
        data__problem(&r->problems, 0, line, t->at,
                      "\"%s\": the unit is not closed, expected \"%s "
                      "[%s]\"",
                      t->name, t->name, wanted);
        return 0;
    }
    int wrong = t->has_unit ? data__unit(t->unit, wanted, &t->exp10, &t->factor) : 0;
    if (wrong != 0) {
        char hint[MECH_PATH + 32] = "";
        if (wrong == 2) {
            data__near_unit(hint, sizeof hint, t->unit, wanted);
        }
        data__problem(
            &r->problems, 0, line, t->at, "\"%s\" is in [%s], expected [%s]%s%s", t->name, t->unit,
            wanted, wrong == 2 ? ": this is no known unit" : " or another unit of this kind", hint);
    }
    return wrong == 0;
}

int data__is_repeated(data__reader *r, const data__title *t)
{
    for (const data__title *other = r->title; other < t; other++) {
        if (strcmp(other->name, t->name) == 0 && *t->name != '\0') {
            data__problem(&r->problems, 0, r->header_line, t->at,
                          "a second column \"%s\", the "
                          "first one is at column %d",
                          t->name, other->at);
            return 1;
        }
    }
    return 0;
}

/* Is it a time under another name, "Zeit [s]" or "temps_ms": its unit says so, and the model has no
 * such name. */
static int is_some_time(const data__reader *r, data__title *t)
{
    return data__wanted_unit(r->model, t->name) == NULL &&
           data__cut_time(t->name, t->unit, &t->has_unit);
}

static void add_time(data__reader *r, data__title *t)
{
    if (!data__is_time(r->model, t->name) && !is_some_time(r, t)) {
        data__problem(&r->problems, 0, r->header_line, t->at,
                      "the first column is \"%s%s%s%s\": "
                      "expected time [s], or any name with a unit of time",
                      t->name, t->has_unit ? " [" : "", t->unit, t->has_unit ? "]" : "");
        r->stop = 1; // rows without time have no order
        return;
    }
    snprintf(t->name, sizeof t->name, "time");
    r->out->data.time_unit_assumed = !t->has_unit;
    fit_unit(r, t, "s");
}

/* a column that is no output or input of the model: other contents of a log. A name that looks like
 * one of the model's which no column has is a slip instead. */
static int is_passed_over(const data__reader *r, const data__title *t)
{
    const stein_model *m = r->model;
    mech__nearest near = {t->name, NULL, 0};
    int known = 0;
    for (int i = 1; i < m->nchannel + m->ninput; i++) { // 0 is the time
        mech__offer(&near, i < m->nchannel ? m->channels[i].name : m->inputs[i - m->nchannel].name);
    }
    for (int k = 0; k < r->ntitle; k++) {
        const char *name = r->title[k].name;
        known += k != r->time_at && data__wanted_unit(m, name) != NULL;
        near.best = near.best != NULL && strcmp(near.best, name) == 0 ? NULL : near.best;
    }
    return known > 0 && near.best == NULL;
}

int data__pass_over(data__reader *r, const data__title *t)
{
    int passed = is_passed_over(r, t);
    if (!passed || *t->name == '\0') {
        return passed;
    }
    char *list = r->out->passed_over == NULL ? lab__text("%s", t->name)
                                             : lab__text("%s, %s", r->out->passed_over, t->name);
    free(r->out->passed_over);
    r->out->passed_over = list;
    r->problems.nomem |= list == NULL;
    return 1;
}

/* degrees are told as degrees again */
static void note_written(lab_column *c, const data__title *t)
{
    if (t->factor != 1.0) {
        snprintf(c->written, sizeof c->written, "%.23s", t->unit);
        c->factor = t->factor * pow(10.0, t->exp10);
    }
}

static void add_channel(data__reader *r, data__title *t)
{
    const stein_model *m = r->model;
    int input = stein_find_input(m, t->name);
    int channel = input < 0 ? stein_find_channel(m, t->name) : -1;
    char hint[MECH_PATH + 32], has[DATA_OUTPUTS];
    if (input < 0 && channel < 0 && data__pass_over(r, t)) {
        return;
    }
    if (input < 0 && channel < 0) {
        int near = *data__near_channel(hint, sizeof hint, m, t->name) != '\0';
        data__problem(
            &r->problems, 0, r->header_line, t->at, "\"%s\" is no output or input of \"%s\"%s%s",
            t->name, m->name,
            near ? hint : "; its outputs: ", near ? "" : data__list_outputs(has, sizeof has, m));
        return;
    }
    const char *wanted = input >= 0 ? m->inputs[input].unit : m->channels[channel].unit;
    if (!fit_unit(r, t, wanted)) {
        return;
    }
    t->known = 1;
    t->to = r->out->data.ncolumn++;
    r->out->column[t->to] =
        (lab_column){.name = input >= 0 ? m->inputs[input].name : m->channels[channel].name,
                     .unit = wanted,
                     .role = input >= 0 ? LAB_INPUT : LAB_OUTPUT,
                     .index = input >= 0 ? input : channel,
                     .noise = NAN,
                     .line = r->header_line,
                     .column = t->at,
                     .unit_assumed = !t->has_unit && strcmp(wanted, "1") != 0};
    note_written(&r->out->column[t->to], t);
}

/* Is none of the columns the model's? One message then, with the expected titles. */
static int is_foreign(data__reader *r)
{
    const stein_model *m = r->model;
    char has[DATA_OUTPUTS];
    int known = 0, named = 0;
    int first = r->time_at == 0;
    for (int k = 0; k < r->ntitle; k++) {
        known += k != r->time_at && data__wanted_unit(m, r->title[k].name) != NULL;
        named += k != r->time_at && *r->title[k].name != '\0';
    }
    if (known > 0 || named < 2 || r->options->inputs_only ||
        !data__is_time(m, r->title[r->time_at].name)) {
        return 0;
    }
    data__problem(&r->problems, 0, r->header_line, r->title[first].at,
                  "none of the %d columns from \"%s\" on is an output or input of \"%s\": a record "
                  "of another mechanism? expected some of %s",
                  named, r->title[first].name, m->name, data__list_outputs(has, sizeof has, m));
    return 1;
}

static void add_title(data__reader *r, int k)
{
    data__title *t = &r->title[k];
    int used = !r->options->inputs_only || stein_find_input(r->model, t->name) >= 0;
    if (k == r->time_at) {
        add_time(r, t);
    } else if (*t->name == '\0' && (!used || k < r->time_at || data__pass_over(r, t))) {
        return; // an index, or what a spreadsheet adds at the end
    } else if (*t->name == '\0') {
        data__problem(&r->problems, 0, r->header_line, t->at, "column %d has no name", k + 1);
    } else if (used && !data__is_repeated(r, t)) {
        const data__about *events = data__events_of(r, t->name);
        if (events != NULL) {
            data__add_events(r, t, events);
        } else {
            add_channel(r, t);
        }
    }
}

static void add_titles(data__reader *r, const char *text, const data__cell *cell, int n)
{
    int at = n;
    for (r->ntitle = 0; r->ntitle < n; r->ntitle++) {
        data__title *t = &r->title[r->ntitle];
        t->has_unit = data__cut_title(r->model, cell[r->ntitle], t->name, t->unit);
        t->at = data__column(text, cell[r->ntitle].at);
        t->factor = 1.0;
        at = at == n && data__is_time(r->model, t->name) ? r->ntitle : at;
    }
    if (data__event_titles(r)) {
        return;
    }
    r->time_at = at < n ? at : 0;
    if (is_foreign(r)) {
        r->stop = 1;
        return;
    }
    for (int k = 0; k < n; k++) {
        add_title(r, k);
    }
}

int data__is_header(const data__reader *r, const char *text, size_t size)
{
    data__cell cell[DATA_COLUMNS + 1];
    char name[DATA_SHOWN], unit[DATA_SHOWN];
    int n = data__cells(text, size, data__separator(text, size), cell), k = 0;
    while (k < n && k < DATA_COLUMNS &&
           (data__cut_title(r->model, cell[k], name, unit) < 0 ||
            (!data__is_time(r->model, name) && data__events_of(r, name) == NULL))) {
        k++;
    }
    return k < n && k < DATA_COLUMNS;
}

/* the column with a unit of time in a row of units: the column of the time, or the first one with
 * times of events; -1: it states its unit */
static int timed_column(const data__reader *r)
{
    int k = r->alone ? 0 : r->time_at;
    while (r->alone && k < r->ntitle && !r->title[k].known) {
        k++;
    }
    return k < r->ntitle && r->title[k].has_unit == 0 ? k : -1;
}

/* Is it a row of units below the titles? They are then used for titles that state none. */
int data__unit_line(data__reader *r, const data__cell *cell, int n)
{
    char unit[DATA_SHOWN];
    int exp10, timed = timed_column(r);
    double factor;
    if (n != r->ntitle || timed < 0) {
        return 0;
    }
    data__cut_unit(cell[timed], unit);
    if (data__unit(unit, "s", &exp10, &factor) != 0) {
        return 0;
    }
    for (int k = 0; k < n; k++) {
        data__title *t = &r->title[k];
        lab_column *c = t->known ? &r->out->column[t->to] : NULL;
        if ((c == NULL && k != r->time_at) || t->has_unit != 0 || cell[k].n == 0) {
            continue;
        }
        data__cut_unit(cell[k], t->unit);
        t->has_unit = 1;
        fit_unit(r, t, c != NULL ? c->unit : "s");
        if (c != NULL) {
            note_written(c, t);
            c->unit_assumed = 0;
        } else {
            r->out->data.time_unit_assumed = 0;
        }
    }
    return 1;
}

void data__header_line(data__reader *r, int line, const char *text, size_t size)
{
    data__cell cell[DATA_COLUMNS + 1];
    r->header_line = line;
    r->separator = data__separator(text, size);
    r->point = r->separator == ',' ? '.' : '\0';
    int n = data__cells(text, size, r->separator, cell);
    if (n < 0 || n > DATA_COLUMNS) {
        data__problem(&r->problems, 0, r->header_line, n < 0 ? data__column(text, -1 - n) : 1,
                      n < 0 ? "a quoted title that does not end at a comma"
                            : "more than 256 columns");
        r->stop = 1;
        return;
    }
    r->title = calloc((size_t)n, sizeof *r->title);
    r->out->column = calloc((size_t)n, sizeof *r->out->column);
    if (r->title == NULL || r->out->column == NULL) {
        r->problems.nomem = 1;
        return;
    }
    add_titles(r, text, cell, n);
}
