/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_events.c - columns that hold times of events, "# events CHANNEL: begin" or "end".
 *
 *      # events bounce: begin
 *      time [s],x [m],bounce [s]       the i-th row of bounce: when the contact that this output
 *      0,0.5,0.4515                    reads closed for the i-th time
 *      0.01,0.49,1.216
 *      0.02,0.48,
 *
 * Without samples the file needs no time; an index in front of the times is passed over. The rows
 * of such a file are the record's start, t = 0, and all its times.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"

static const char *const which[] = {"begin", "end"};

/* Contact of a channel that shows when a contact closes (force, tangent, gap), or notch (force,
 * phase, overlap); the other index is -1. @return 1; 0: it reads neither */
static int place_of(const stein_model *m, int channel, int *contact, int *notch)
{
    stein_read_kind read = m->channels[channel].read;
    int index = m->channels[channel].index;
    int touches = read == STEIN_READ_GAP || read == STEIN_READ_FORCE || read == STEIN_READ_TANGENT;
    int catches = read == STEIN_READ_NOTCH_FORCE || read == STEIN_READ_NOTCH_PHASE ||
                  read == STEIN_READ_NOTCH_OVERLAP;
    *contact = touches ? index : -1;
    *notch = catches ? index : -1;
    return touches || catches;
}

/* ---- declarations ---- */

const data__about *data__events_of(const data__reader *r, const char *name)
{
    for (int i = 0; i < r->nabout; i++) {
        if (r->about[i].word == DATA_EVENTS && strcmp(r->about[i].name, name) == 0) {
            return &r->about[i];
        }
    }
    return NULL;
}

static int word_of(const char *value)
{
    return strcmp(value, which[LAB_EVENTS_BEGIN]) == 0 ? LAB_EVENTS_BEGIN
           : strcmp(value, which[LAB_EVENTS_END]) == 0 ? LAB_EVENTS_END
                                                       : -1;
}

/* the outputs that read a contact or notch */
static char *places(char *to, size_t room, const stein_model *m)
{
    size_t n = 0;
    int contact, notch;
    *to = '\0';
    for (int i = 1; i < m->nchannel && n + MECH_PATH / 2 < room; i++) {
        if (place_of(m, i, &contact, &notch)) {
            n += (size_t)snprintf(to + n, room - n, "%s%s", n > 0 ? ", " : ": ",
                                  m->channels[i].name);
        }
    }
    return to;
}

/* @return 1 when an error of a declaration was reported */
static int is_wrong(data__reader *r, const data__about *a)
{
    const stein_model *m = r->model;
    const data__about *first = data__events_of(r, a->name);
    int channel = stein_find_channel(m, a->name), contact, notch;
    char hint[MECH_PATH + 32], shown[DATA_SHOWN], has[300];
    data__shown(shown, a->name, strlen(a->name));
    if (channel < 0) {
        data__problem(&r->problems, 0, a->line, a->name_column,
                      "events of \"%s\": no such output of the model%s", shown,
                      data__near_channel(hint, sizeof hint, m, a->name));
    } else if (!place_of(m, channel, &contact, &notch)) {
        data__problem(&r->problems, 0, a->line, a->name_column,
                      "events of \"%s\": it reads no contact or notch, expected an output that "
                      "does%s",
                      shown, places(has, sizeof has, m));
    } else if (word_of(a->value) < 0) {
        data__problem(&r->problems, 0, a->line, a->value_column,
                      "events of \"%s\": \"%s\", expected begin (it closes) or end (it opens)",
                      shown, data__shown(hint, a->value, strlen(a->value)));
    } else if (strcmp(first->value, a->value) != 0) {
        data__problem(&r->problems, 0, a->line, a->name_column,
                      "events of \"%s\": %s here and %s in line %d", shown, a->value, first->value,
                      first->line);
    } else {
        return 0;
    }
    return 1;
}

/* ---- titles ---- */

void data__add_events(data__reader *r, data__title *t, const data__about *about)
{
    int index = stein_find_channel(r->model, t->name), contact, notch;
    int wrong = t->has_unit > 0 ? data__unit(t->unit, "s", &t->exp10, &t->factor) : 0;
    if (t->has_unit < 0 || wrong != 0) {
        data__problem(&r->problems, 0, r->header_line, t->at,
                      "\"%s\" holds times of events in [%s], expected \"%s [s]\" or another unit "
                      "of time",
                      t->name, t->unit, t->name);
        return;
    }
    place_of(r->model, index, &contact, &notch);
    t->known = t->events = 1;
    t->last = -INFINITY;
    t->to = r->out->data.ncolumn++;
    r->out->column[t->to] = (lab_column){.name = r->model->channels[index].name,
                                         .unit = "s",
                                         .role = LAB_EVENT_TIMES,
                                         .events = (lab_events)word_of(about->value),
                                         .index = index,
                                         .contact = contact,
                                         .notch = notch,
                                         .noise = NAN,
                                         .line = r->header_line,
                                         .column = t->at,
                                         .unit_assumed = !t->has_unit};
}

/* Is this column, without a time, to be left out: the first one as an index, one that the model
 * lacks? */
static int is_left_out(data__reader *r, const data__title *t)
{
    int index = t == r->title && r->ntitle > 1;
    return data__wanted_unit(r->model, t->name) == NULL && (index || data__pass_over(r, t));
}

static void add_alone(data__reader *r)
{
    r->alone = 1;
    r->time_at = -1;
    for (int k = 0; k < r->ntitle; k++) {
        data__title *t = &r->title[k];
        const data__about *about = data__events_of(r, t->name);
        if (data__is_repeated(r, t)) {
            continue;
        }
        if (about != NULL) {
            data__add_events(r, t, about);
        } else if (!is_left_out(r, t)) {
            data__problem(
                &r->problems, 0, r->header_line, t->at,
                "\"%s\" holds no times of events (# events), and without a time there are "
                "no samples: expected a column \"time [s]\"",
                t->name);
        }
    }
}

int data__event_titles(data__reader *r)
{
    int wrong = 0, any = 0, time = 0;
    for (int i = 0; i < r->nabout; i++) {
        int events = r->about[i].word == DATA_EVENTS;
        wrong |= events && is_wrong(r, &r->about[i]);
    }
    if (wrong) {
        r->stop = 1;
        return 1;
    }
    for (int k = 0; k < r->ntitle; k++) {
        any |= data__events_of(r, r->title[k].name) != NULL;
        time |= data__is_time(r->model, r->title[k].name);
    }
    if (any && !time) {
        add_alone(r);
    }
    return any && !time;
}

/* ---- cells ---- */

int data__take_event(data__reader *r, int k, int column, double v)
{
    data__title *t = &r->title[k];
    char a[LAB_NUMBER], b[LAB_NUMBER];
    int line = r->lines.line, first = k + 1;
    if (isnan(v)) {
        t->ended = 1;
        return 1;
    }
    if (t->ended) {
        data__problem(
            &r->problems, DATA_EVENT_GAP + DATA_KINDS * first, line, column,
            "%s: a time of an event below an empty cell, expected one in each row from the "
            "first one on",
            t->name);
    } else if (v < r->start || (r->alone && v == 0.0)) {
        data__problem(&r->problems, DATA_EVENT_EARLY + DATA_KINDS * first, line, column,
                      "%s: an event at %s s, expected times after the start of the record, %s s",
                      t->name, lab__number(a, v), lab__number(b, r->start));
    } else if (!(v > t->last)) {
        data__problem(&r->problems, DATA_EVENT_ORDER + DATA_KINDS * first, line, column,
                      "%s: the time of an event %s from %s s to %s s, expected increasing times",
                      t->name, v < t->last ? "goes back" : "stands still,", lab__number(a, t->last),
                      lab__number(b, v));
    } else {
        t->last = v;
        return 1;
    }
    return 0;
}

/* ---- rows ---- */

/* the cells of a column for n rows. @return 1; 0: no memory */
static int resize(data__title *t, size_t n, int rows)
{
    double *value = realloc(t->value, sizeof *value * (n + 1));
    t->value = value != NULL ? value : t->value;
    unsigned char *present = realloc(t->present, n + 1);
    t->present = present != NULL ? present : t->present;
    for (size_t i = (size_t)rows; value != NULL && present != NULL && i < n; i++) {
        value[i] = NAN;
        present[i] = 0;
    }
    return value != NULL && present != NULL;
}

int data__event_rows(data__reader *r)
{
    size_t most = 1, n = 0;
    for (int k = 0; k < r->ntitle; k++) {
        most += r->title[k].known ? (size_t)r->title[k].samples : 0;
    }
    double *time = malloc(sizeof *time * most);
    if (time == NULL) {
        return 0;
    }
    time[0] = 0.0;
    for (int k = 0, at = 1; k < r->ntitle; k++) {
        const data__title *t = &r->title[k];
        for (int i = 0; t->known && i < t->samples; i++) {
            time[at++] = t->value[i];
        }
    }
    gsl_sort(time, 1, most);
    for (size_t i = 0; i < most; i++) {
        if (n == 0 || time[i] > time[n - 1]) {
            time[n++] = time[i];
        }
    }
    free(r->out->time);
    r->out->time = time;
    int ok = 1;
    for (int k = 0; k < r->ntitle; k++) {
        ok &= !r->title[k].known || resize(&r->title[k], n, r->rows);
    }
    r->rows = (int)n;
    return ok;
}
