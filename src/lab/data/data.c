/* SPDX-License-Identifier: GPL-3.0-or-later
 * data.c - a record from a CSV file.
 *
 * One pass over the file. A problem does not end the reading, so that one run names all of them.
 * From the first problem on rows are checked but no longer kept, and the file gives no data: half a
 * record is not to be fitted. Repeated problems of one kind (a thousand empty cells of
 * the time) are one message with a count.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "data_internal.h"

lab_data_options lab_data_options_default(const stein_model *model)
{
    return (lab_data_options){.model = model, .min_samples = 4};
}

void lab_data_close(lab_data *data)
{
    if (data == NULL) {
        return;
    }
    data__file *out = (data__file *)(void *)data;
    for (int i = 0; out->column != NULL && i < data->ncolumn; i++) {
        free((void *)out->column[i].value);
        free((void *)out->column[i].present);
    }
    for (int i = 0; i < data->nnote; i++) {
        free((void *)out->note[i].name);
        free((void *)out->note[i].value);
    }
    free(out->time);
    free(out->column);
    free(out->set);
    free(out->note);
    free(out->file);
    free(out->source);
    free(out->text);
    free(out->passed_over);
    free(out);
}

/* ---- rows ---- */

static int grow(data__reader *r)
{
    size_t room = r->room == 0 ? 1024 : 2 * (size_t)r->room;
    double *time = realloc(r->out->time, sizeof *time * room);
    r->out->time = time != NULL ? time : r->out->time;
    int ok = time != NULL;
    for (int k = 0; ok && k < r->ntitle; k++) {
        data__title *t = &r->title[k];
        if (!t->known) {
            continue;
        }
        double *value = realloc(t->value, sizeof *value * room);
        t->value = value != NULL ? value : t->value;
        unsigned char *present = realloc(t->present, room);
        t->present = present != NULL ? present : t->present;
        ok = value != NULL && present != NULL;
    }
    r->problems.nomem |= !ok;
    r->room = ok ? (int)room : r->room;
    return ok;
}

/* number of a cell in SI; 0 when it is none, which is reported */
static int number(data__reader *r, const char *text, data__cell cell, int k, double *v)
{
    const data__title *t = &r->title[k];
    char shown[DATA_SHOWN];
    const char *wrong = data__number(cell, t->exp10, r->c, &r->point, v);
    if (wrong == NULL && isinf(*v * t->factor)) {
        wrong = "the number is too large";
    }
    if (wrong != NULL) {
        data__problem(&r->problems, DATA_BAD_CELL + DATA_KINDS * (k + 1), r->lines.line,
                      data__column(text, cell.at), "%s \"%s\": %s", t->name,
                      data__shown(shown, cell.s, cell.n), wrong);
        return 0;
    }
    *v *= t->factor;
    return 1;
}

/* one cell of times of events */
static int event(data__reader *r, const char *text, data__cell cell, int k, double v)
{
    data__title *t = &r->title[k];
    int there = cell.n > 0, good = data__take_event(r, k, data__column(text, cell.at), v);
    double digit = there ? t->factor * data__last_digit(cell, t->exp10, r->point) : INFINITY;
    t->digit = t->samples == 0 ? digit : fmin(t->digit, digit);
    return good;
}

static int read_time(data__reader *r, const char *text, data__cell cell, double *t)
{
    char now[LAB_NUMBER], before[LAB_NUMBER];
    int line = r->lines.line, column = data__column(text, cell.at);
    if (cell.n == 0) {
        data__problem(&r->problems, DATA_NO_TIME, line, column, "a row without time");
        return 0;
    }
    if (!number(r, text, cell, r->time_at, t)) {
        return 0;
    }
    if (*t == r->last) {
        data__problem(&r->problems, DATA_TIME_ORDER, line, column,
                      "the time %s s appears twice, expected rows in increasing time",
                      lab__number(now, *t));
        return 0;
    }
    if (*t < r->last) {
        data__problem(&r->problems, DATA_TIME_ORDER, line, column,
                      "the time goes back from %s s to %s s, expected rows in increasing time",
                      lab__number(before, r->last), lab__number(now, *t));
        r->last = *t;
        return 0;
    }
    r->last = *t;
    return 1;
}

static const char *separator_name(char separator)
{
    return separator == '\t' ? "tabs" : separator == ';' ? "\";\"" : "\",\"";
}

static void ragged(data__reader *r, const char *text, size_t size, const data__cell *cell, int n)
{
    char hint[80] = "";
    int at = n > r->ntitle ? cell[r->ntitle].at : (int)size;
    char other = data__separator(text, size);
    const char *foreign = other != r->separator ? memchr(text, other, size) : NULL;
    if (r->separator == ',' && r->ntitle > 1 && n == 2 * r->ntitle) {
        snprintf(hint, sizeof hint, ": are these decimal commas? expected decimal points");
    } else if (n == 1 && foreign != NULL) {
        at = (int)(foreign - text);
        snprintf(hint, sizeof hint, ": cells are separated by %s, expected %s as in the header",
                 separator_name(other), separator_name(r->separator));
    }
    data__problem(&r->problems, DATA_RAGGED, r->lines.line, data__column(text, at),
                  "%s%d cell%s where the header has %d%s", n > DATA_COLUMNS ? "more than " : "",
                  n > DATA_COLUMNS ? DATA_COLUMNS : n, n == 1 ? "" : "s", r->ntitle, hint);
}

/* the cells of one row into the columns, or only through the checks */
static void take_row(data__reader *r, const char *text, const data__cell *cell, double time)
{
    r->start = r->rows == 0 && !r->alone ? time : r->start;
    int keep = r->problems.n == 0 && !r->problems.nomem && (r->rows < r->room || grow(r));
    for (int k = 0; k < r->ntitle; k++) {
        data__title *t = &r->title[k];
        double v = NAN;
        int present = cell[k].n > 0;
        if (!t->known || (present && !number(r, text, cell[k], k, &v)) ||
            (t->events && !event(r, text, cell[k], k, v))) {
            t->refused++;
            continue;
        }
        if (present) {
            t->first = t->samples == 0 ? v : t->first;
            t->varies |= v != t->first;
            t->samples++;
        }
        if (keep) {
            t->value[r->rows] = v;
            t->present[r->rows] = (unsigned char)present;
        }
    }
    if (keep) {
        r->out->time[r->rows] = time;
    }
    r->rows++;
}

static int is_empty(const data__cell *cell, int n)
{
    int k = 0;
    while (k < n && cell[k].n == 0) {
        k++;
    }
    return k == n;
}

static void row_line(data__reader *r, const char *text, size_t size)
{
    data__cell cell[DATA_COLUMNS + 1];
    double time = NAN;
    int n = data__cells(text, size, r->separator, cell);
    if (text[0] == '#') {
        data__problem(&r->problems, DATA_NOTE_BELOW, r->lines.line, 1,
                      "a \"#\" line below the header, "
                      "expected above it");
        return;
    }
    if (n < 0) {
        data__problem(&r->problems, DATA_QUOTES, r->lines.line, data__column(text, -1 - n),
                      "quotes that do not close at a comma");
        return;
    }
    if (r->rows >= DATA_ROWS) {
        data__problem(&r->problems, 0, r->lines.line, 1, "more than %d rows", (int)DATA_ROWS);
        r->stop = 1;
        return;
    }
    if (n == r->ntitle - 1 && n > r->time_at && *r->title[n].name == '\0') {
        // the titles alone end with a separator
        cell[n++] = (data__cell){text + size, 0, (int)size};
    }
    if (n == r->ntitle && is_empty(cell, n)) { // added by a spreadsheet
        return;
    }
    if (r->rows == 0 && data__unit_line(r, cell, n)) {
        return;
    }
    if (n != r->ntitle) {
        ragged(r, text, size, cell, n);
    } else if (r->alone || read_time(r, text, cell[r->time_at], &time)) {
        take_row(r, text, cell, time);
        return;
    }
    r->rows++;
    r->refused++;
}

/* ---- the whole file ---- */

/* do numbers begin here? */
static int is_row(const data__reader *r, const char *text, size_t size)
{
    data__cell cell[DATA_COLUMNS + 1];
    char point = '\0';
    double value;
    int n = data__cells(text, size, data__separator(text, size), cell);
    return n > 0 && data__number(cell[0], 0, r->c, &point, &value) == NULL;
}

/* "#" line with the titles, numpy.savetxt writes so: the time and others, or times of events */
static int is_note_header(const data__reader *r, const lab_note *note)
{
    size_t size = strlen(note->value);
    data__cell cell[DATA_COLUMNS + 1];
    char name[DATA_SHOWN], unit[DATA_SHOWN];
    int n = data__cells(note->value, size, data__separator(note->value, size), cell);
    if (*note->name != '\0' || n < 1 || !data__is_header(r, note->value, size)) {
        return 0;
    }
    data__cut_title(r->model, cell[0], name, unit);
    return n > 1 || !data__is_time(r->model, name);
}

static void keep_above(data__reader *r, const char *text, size_t size)
{
    free(r->above);
    r->above = lab__text("%.*s", (int)size, text);
    r->problems.nomem |= r->above == NULL;
    r->above_line = r->lines.line;
    r->nabove++;
}

static void drop_last_note(data__reader *r)
{
    lab_note *note = &r->out->note[--r->out->data.nnote];
    free((void *)note->name);
    free((void *)note->value);
}

/* Titles in the last "#" line, or in the one above it where the last one has their units.
 * @return 0: neither has titles */
static int note_header(data__reader *r)
{
    int n = r->out->data.nnote, units = 0;
    const lab_note *last = n > 0 ? &r->out->note[n - 1] : NULL, *titles = last;
    if (n > 1 && *last->name == '\0' && !is_note_header(r, last)) {
        titles = last - 1;
        units = 1;
    }
    if (titles == NULL || !is_note_header(r, titles)) {
        return 0;
    }
    data__header_line(r, titles->line, titles->value, strlen(titles->value));
    if (units && r->ntitle > 0 && !r->stop) {
        data__cell cell[DATA_COLUMNS + 1];
        int cells = data__cells(last->value, strlen(last->value), r->separator, cell);
        units = data__unit_line(r, cell, cells);
    }
    if (titles != last && !units) { // a remark, which stays
        lab_note kept = *last;
        r->out->note[n - 1] = *titles;
        r->out->note[n - 2] = kept;
    } else if (titles != last) {
        drop_last_note(r);
    }
    drop_last_note(r);
    return 1;
}

/* A row, and no header yet: it is in "#" lines, or what stands above the row was meant as one. */
static void late_header(data__reader *r, const char *text, size_t size)
{
    if (r->above != NULL) {
        data__header_line(r, r->above_line, r->above, strlen(r->above));
    } else if (!note_header(r)) {
        data__problem(&r->problems, 0, r->lines.line, 1,
                      "numbers where the titles of the columns should be, expected "
                      "\"time [s],...\" above the first row");
        r->stop = 1;
        return;
    }
    data__settle_columns(r);
    if (r->ntitle > 0 && !r->stop) {
        row_line(r, text, size);
    }
}

/* Lines above the titles that are neither titles nor numbers (names of a tracked point or an
 * instrument, a date) are passed over. */
static void header_line(data__reader *r, const char *text, size_t size)
{
    enum { MOST_ABOVE = 100 };
    if (is_row(r, text, size) || r->nabove == MOST_ABOVE) {
        late_header(r, text, size);
    } else if (data__is_header(r, text, size)) {
        data__header_line(r, r->lines.line, text, size);
        data__settle_columns(r);
    } else {
        keep_above(r, text, size);
    }
}

static int is_blank(const char *text, size_t size)
{
    size_t n = 0;
    while (n < size && (text[n] == ' ' || text[n] == '\t')) {
        n++;
    }
    return n == size;
}

static stein_status read_lines(data__reader *r, stein_err *err)
{
    const char *text;
    size_t size;
    while (!r->stop && !r->problems.more && !r->problems.nomem &&
           data__next_line(&r->lines, &r->problems, &text, &size)) {
        if (is_blank(text, size)) {
            continue;
        }
        if (r->header_line == 0 && text[0] == '#') {
            data__note_line(r, text, size);
        } else if (r->header_line == 0) {
            header_line(r, text, size);
        } else {
            row_line(r, text, size);
        }
    }
    r->stop |= !r->lines.ended; // remaining lines may give more problems
    if (ferror(r->lines.stream)) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read: %s", r->out->file, strerror(errno));
    }
    return STEIN_OK;
}

/* an output that never changes measures nothing; a force that is always 0 is information */
static int may_be_constant(const data__reader *r, const lab_column *c, double value)
{
    if (c->role == LAB_INPUT) {
        return 1;
    }
    stein_read_kind read = r->model->channels[c->index].read;
    return read == STEIN_READ_NOTCH_PHASE || read == STEIN_READ_INPUT ||
           (value == 0.0 && (read == STEIN_READ_FORCE || read == STEIN_READ_TANGENT ||
                             read == STEIN_READ_NOTCH_FORCE || read == STEIN_READ_INPUT_FORCE));
}

/* checks at the end of the file */
static void check_columns(data__reader *r)
{
    int least = r->options->min_samples;
    char value[LAB_NUMBER];
    if (r->header_line == 0) {
        data__problem(&r->problems, 0, 0, 0, "no header line, expected \"time [s],...\"");
        return;
    }
    if (r->rows == 0) {
        data__problem(&r->problems, 0, r->header_line, 1, "no rows below the header");
        return;
    }
    if (r->out->data.ncolumn == 0 && r->problems.n == 0 && !r->options->inputs_only) {
        data__problem(&r->problems, 0, r->header_line, 1, "no columns beside the time");
    }
    if (r->rows < least && !r->alone) {
        data__problem(&r->problems, 0, r->header_line, 1, "%d sample%s, expected at least %d",
                      r->rows, r->rows == 1 ? "" : "s", least);
        return;
    }
    for (int k = 0; k < r->ntitle; k++) {
        const data__title *t = &r->title[k];
        if (t->events && t->samples + t->refused == 0) {
            data__problem(&r->problems, 0, r->header_line, t->at, "\"%s\": no time of an event",
                          t->name);
        } else if (t->events) {
            continue;
        } else if (t->known && t->samples + t->refused + r->refused < least) {
            data__problem(&r->problems, 0, r->header_line, t->at,
                          "%d sample%s of \"%s\", expected "
                          "at least %d",
                          t->samples, t->samples == 1 ? "" : "s", t->name, least);
        } else if (t->known && t->samples >= least && !t->varies &&
                   !may_be_constant(r, &r->out->column[t->to], t->first)) {
            data__problem(&r->problems, 0, r->header_line, t->at,
                          "\"%s\" is %s %s in all %d "
                          "samples: it measures nothing",
                          t->name, lab__number(value, t->first), r->out->column[t->to].unit,
                          t->samples);
        }
    }
}

void data__hand_over(data__file *out)
{
    out->data.time = out->time;
    out->data.column = out->column;
    out->data.set = out->set;
    out->data.note = out->note;
    out->data.file = out->file;
    out->data.source = out->source;
    out->data.text = out->text;
    out->data.passed_over = out->passed_over;
}

/* cut the columns to their length and hand them to the public part */
static void hand_over(data__reader *r)
{
    data__file *out = r->out;
    data__hand_over(out);
    out->data.events_alone = r->alone;
    out->data.nrow = out->data.file_rows = r->rows;
    out->data.hash = r->lines.hash;
    for (int k = 0; k < r->ntitle; k++) {
        const data__title *t = &r->title[k];
        if (t->known) {
            lab_column *c = &out->column[t->to];
            c->samples = t->samples;
            c->digit = t->events ? t->digit : 0.0;
            c->wraps = data__unwrap(r->model, c, t->value, r->rows);
        }
    }
}

/* @param text  of the file; NULL: it is on a disk */
static stein_status read_file(data__reader *r, const char *text, const lab_data_options *o,
                              stein_err *err)
{
    stein_status status = data__lines_open(&r->lines, r->out->file, text, err);
    r->lines.bytes = r->before;
    r->lines.total = r->total;
    r->lines.progress = o->progress;
    r->lines.ctx = o->ctx;
    if (status == STEIN_OK) {
        status = read_lines(r, err);
    }
    data__lines_close(&r->lines);
    if (status == STEIN_OK && !r->stop && !r->problems.more) {
        check_columns(r);
    }
    if (status == STEIN_OK && r->alone && r->problems.n == 0 && !data__event_rows(r)) {
        r->problems.nomem = 1;
    }
    for (int k = 0; k < r->ntitle; k++) { // owned by the columns from here on
        if (r->title[k].known) {
            r->out->column[r->title[k].to].value = r->title[k].value;
            r->out->column[r->title[k].to].present = r->title[k].present;
        }
    }
    stein_status found =
        data__problems_flush(&r->problems, o->report, o->ctx, status == STEIN_OK ? err : NULL);
    status = status == STEIN_OK ? found : status;
    if (status == STEIN_OK && o->inputs_only && r->out->data.ncolumn == 0) {
        return lab__fail(err, STEIN_EINVAL, "%s:%d: no column is named like an input of \"%s\"",
                         r->out->file, r->header_line, r->model->name);
    }
    return status;
}

double data__bytes(const char *file, const char *text)
{
    struct stat st;
    return text != NULL                                  ? (double)strlen(text)
           : stat(file, &st) == 0 && S_ISREG(st.st_mode) ? (double)st.st_size
                                                         : 0.0;
}

stein_status data__open(lab_data **data, const char *file, const char *text,
                        const lab_data_options *options, double before, double total,
                        stein_err *err)
{
    data__reader r = {.options = options, .model = options->model, .last = -INFINITY};
    r.before = before;
    r.total = total;
    r.out = calloc(1, sizeof *r.out);
    r.c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (r.out != NULL) {
        r.out->file = lab__text("%s", file);
        r.out->source = lab__text("%s", file);
        r.out->text = text != NULL ? lab__text("%s", text) : NULL;
        r.out->data.model = options->model;
    }
    stein_status status = STEIN_OK;
    if (r.out == NULL || r.out->file == NULL || r.out->source == NULL ||
        (text != NULL && r.out->text == NULL) || r.c == (locale_t)0) {
        status = lab__no_memory(err);
    } else {
        r.problems.file = r.out->file;
        status = read_file(&r, text, options, err);
    }
    for (int i = 0; i < r.nabout; i++) {
        free(r.about[i].name);
        free(r.about[i].value);
    }
    free(r.about);
    if (status == STEIN_OK && r.out != NULL) {
        hand_over(&r);
        *data = &r.out->data;
    } else if (r.out != NULL) {
        lab_data_close(&r.out->data);
    }
    free(r.title);
    free(r.above);
    if (r.c != (locale_t)0) {
        freelocale(r.c);
    }
    return status;
}

stein_status lab_data_open(lab_data **data, const char *file, const lab_data_options *options,
                           stein_err *err)
{
    const char *text = options->text != NULL ? options->text[0] : NULL;
    return data__open(data, file, text, options, 0.0, data__bytes(file, text), err);
}

/* ---- access ---- */

const lab_column *lab_data_column(const lab_data *data, const char *name)
{
    for (int i = 0; i < data->ncolumn; i++) {
        if (strcmp(data->column[i].name, name) == 0) {
            return &data->column[i];
        }
    }
    return NULL;
}

int lab_data_without(const lab_data *data, const char *amount)
{
    for (int i = 0; i < data->nnote; i++) {
        if (strcmp(data->note[i].name, LAB_NOTE_WITHOUT) == 0 &&
            strcmp(data->note[i].value, amount) == 0) {
            return 1;
        }
    }
    return 0;
}

void lab_data_apply(const lab_data *data, double *p)
{
    for (int i = 0; i < data->nset; i++) {
        p[data->set[i].param] = data->set[i].value;
    }
}
