/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_lines.c - bytes of a data file become lines, cells, numbers; problems are collected.
 *
 * A record may have millions of rows, so the file is streamed. A number with up to 15 digits and a
 * power of ten up to 22 is converted by one exact product or quotient (Clinger 1990). Instruments
 * write no others. Only other numbers go through strtod, in the "C" locale. The power of ten of the
 * unit is first added to the exponent of the number: 7.2 in a column of mm has the bits of 0.0072.
 */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"
#include "functions.h"

/* ---- problems ---- */

void data__problem(data__problems *p, int kind, int line, int column, const char *format, ...)
{
    for (int i = 0; kind != 0 && i < p->n; i++) {
        if (p->list[i].kind == kind) {
            p->list[i].again++;
            return;
        }
    }
    if (p->n == DATA_PROBLEMS) {
        p->more = 1;
        return;
    }
    char what[500];
    va_list list;
    va_start(list, format);
    vsnprintf(what, sizeof what, format, list);
    va_end(list);
    char *text = line > 0 ? lab__text("%s:%d:%d: %s", p->file, line, column, what)
                          : lab__text("%s: %s", p->file, what);
    if (text == NULL) {
        p->nomem = 1;
        return;
    }
    p->list[p->n].text = text;
    p->list[p->n].line = line;
    p->list[p->n].column = column;
    p->list[p->n].kind = kind;
    p->list[p->n++].again = 0;
}

static int by_place(const void *a, const void *b)
{
    const struct data__problem *p = a, *q = b;
    int order = (p->line > q->line) - (p->line < q->line);
    return order != 0 ? order : (p->column > q->column) - (p->column < q->column);
}

stein_status data__problems_flush(data__problems *p, lab_report_fn *report, void *ctx,
                                  stein_err *err)
{
    stein_status status = STEIN_OK;
    if (p->nomem) {
        status = lab__no_memory(err);
    } else if (p->n > 0) {
        qsort(p->list, (size_t)p->n, sizeof *p->list, by_place);
        status = lab__fail(err, STEIN_EPARSE, "%s", p->list[0].text);
    }
    for (int i = 0; i < p->n; i++) {
        char *more =
            report != NULL && p->list[i].again > 0
                ? lab__text("%s (and %d more like this)", p->list[i].text, p->list[i].again)
                : NULL;
        if (report != NULL) {
            report(ctx, more != NULL ? more : p->list[i].text);
        }
        free(more);
        free(p->list[i].text);
    }
    char *rest = p->more && report != NULL
                     ? lab__text("%s: more than %d problems, the rest is not shown", p->file,
                                 (int)DATA_PROBLEMS)
                     : NULL;
    if (rest != NULL) {
        report(ctx, rest);
    }
    free(rest);
    p->n = 0;
    return status;
}

char *data__shown(char *to, const char *text, size_t n)
{
    size_t cut = n < DATA_SHOWN ? n : DATA_SHOWN - 4;
    while (cut < n && cut > 0 && ((unsigned char)text[cut] & 0xC0) == 0x80) {
        cut--;
    }
    for (size_t i = 0; i < cut; i++) {
        unsigned char c = (unsigned char)text[i];
        to[i] = (char)(c < ' ' || c == 127 ? '?' : text[i]);
    }
    memcpy(to + cut, cut < n ? "..." : "", cut < n ? 4 : 1);
    return to;
}

/* ---- lines ---- */

stein_status data__lines_open(data__lines *l, const char *file, const char *text, stein_err *err)
{
    *l = (data__lines){.hash = STEIN_HASH};
    // opened to be read, so that what it points to is not written
    l->stream = text != NULL ? fmemopen((char *)text, strlen(text), "r") : fopen(file, "r");
    if (l->stream == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read: %s", file, strerror(errno));
    }
    l->buffer = malloc(DATA_LINE + 2);
    if (l->buffer == NULL) {
        data__lines_close(l);
        return lab__no_memory(err);
    }
    return STEIN_OK;
}

void data__lines_close(data__lines *l)
{
    if (l->stream != NULL) {
        fclose(l->stream);
    }
    free(l->buffer);
    l->stream = NULL;
    l->buffer = NULL;
}

/* move what is left to the front and fill up */
static void refill(data__lines *l)
{
    memmove(l->buffer, l->buffer + l->at, l->have - l->at);
    l->have -= l->at;
    l->at = 0;
    size_t n = fread(l->buffer + l->have, 1, DATA_LINE + 1 - l->have, l->stream);
    l->hash = lab__hash(l->hash, l->buffer + l->have, n);
    l->have += n;
    l->bytes += (double)n;
    l->ended = n == 0;
    if (l->progress != NULL && l->total > 0.0) {
        l->progress(l->ctx, fmin(1.0, l->bytes / l->total));
    }
}

/* byte order marks: UTF-8 is passed over, UTF-16 cannot be read */
static int pass_mark(data__lines *l, data__problems *p)
{
    const unsigned char *b = (const unsigned char *)l->buffer;
    if (l->have >= 3 && b[0] == 0xEF && b[1] == 0xBB && b[2] == 0xBF) {
        l->at = 3;
    } else if (l->have >= 2 && ((b[0] == 0xFF && b[1] == 0xFE) || (b[0] == 0xFE && b[1] == 0xFF))) {
        data__problem(p, 0, 1, 1, "the file is in UTF-16, expected UTF-8 or plain ASCII");
        return 0;
    }
    return 1;
}

int data__next_line(data__lines *l, data__problems *p, const char **text, size_t *size)
{
    if (l->line == 0) {
        refill(l);
        if (!pass_mark(l, p)) {
            return 0;
        }
    }
    char *start = l->buffer + l->at, *end = memchr(start, '\n', l->have - l->at);
    while (end == NULL && !l->ended && l->have - l->at <= DATA_LINE) {
        refill(l);
        start = l->buffer;
        end = memchr(start, '\n', l->have);
    }
    if (end == NULL && l->at == l->have) {
        return 0;
    }
    size_t n = end != NULL ? (size_t)(end - start) : l->have - l->at;
    l->line++;
    const char *nul = memchr(start, '\0', n);
    if (nul != NULL) {
        data__problem(p, 0, l->line, data__column(start, (int)(nul - start)),
                      "a zero byte: this is no text file");
        return 0;
    }
    if (n > DATA_LINE || l->line > DATA_LINES) {
        data__problem(p, 0, l->line, 1,
                      n > DATA_LINE ? "the line is longer than 64 KiB"
                                    : "more lines than can be read");
        return 0;
    }
    l->at += n + (end != NULL);
    while (n > 0 && (start[n - 1] == '\r' || start[n - 1] == ' ')) {
        n--;
    }
    *text = start;
    *size = n;
    return 1;
}

/* ---- cells ---- */

int data__column(const char *text, int at)
{
    int column = 1;
    for (int i = 0; i < at; i++) {
        column += ((unsigned char)text[i] & 0xC0) != 0x80;
    }
    return column;
}

static int is_blank(char c, char separator)
{
    return (c == ' ' || c == '\t' || c == '\r') && (c != separator || separator == ' ');
}

/* End of a cell that begins at byte `at` where blanks separate. Those in front of and inside of a
 * bracket belong to a unit: "time [s]  angle [mm / s]" are two cells, and so are "t / s  x / mm".
 */
static int before_blanks(const char *text, int size, int at)
{
    int open = 0, i = at;
    while (i < size) {
        int next = i;
        while (next < size && is_blank(text[next], ' ')) {
            next++;
        }
        if (next > i && next < size && i > at && open <= 0 && text[i - 1] != '/' &&
            text[next] != '[' && text[next] != '(' && text[next] != '/') {
            return i;
        }
        open += (text[i] == '[' || text[i] == '(') - (text[i] == ']' || text[i] == ')');
        i = next > i ? next : i + 1;
    }
    return size;
}

char data__separator(const char *text, size_t size)
{
    int quoted = 0, semicolon = 0, tab = 0;
    for (size_t i = 0; i < size; i++) {
        quoted ^= text[i] == '"';
        if (!quoted && text[i] == ',') {
            return ',';
        }
        semicolon |= !quoted && text[i] == ';';
        tab |= !quoted && text[i] == '\t';
    }
    if (semicolon || tab) {
        return (char)(semicolon ? ';' : '\t');
    }
    data__cell cell[DATA_COLUMNS + 1];
    return (char)(data__cells(text, size, ' ', cell) > 1 ? ' ' : ',');
}

/* cell at byte `at`, to its separator or the end; @return the byte after it, or -1 */
static int cell_at(const char *text, int size, int at, char separator, data__cell *cell)
{
    while (at < size && is_blank(text[at], separator)) {
        at++;
    }
    if (at < size && text[at] == '"') {
        const char *shut = memchr(text + at + 1, '"', (size_t)(size - at - 1));
        int end = shut == NULL ? size : (int)(shut - text) + 1;
        *cell = (data__cell){text + at + 1, (size_t)(end - at - 2), at};
        while (shut != NULL && separator != ' ' && end < size && is_blank(text[end], separator)) {
            end++;
        }
        return shut == NULL || (end < size && text[end] != separator) ? -1 : end;
    }
    int end = size;
    if (separator == ' ') {
        end = before_blanks(text, size, at);
    } else if (at < size) {
        const char *next = memchr(text + at, separator, (size_t)(size - at));
        end = next != NULL ? (int)(next - text) : size;
    }
    int n = end - at;
    while (n > 0 && is_blank(text[at + n - 1], separator)) {
        n--;
    }
    *cell = (data__cell){text + at, (size_t)n, at};
    return end;
}

int data__cells(const char *text, size_t size, char separator, data__cell cell[DATA_COLUMNS + 1])
{
    int at = 0;
    for (int n = 0; n <= DATA_COLUMNS; n++) {
        int end = cell_at(text, (int)size, at, separator, &cell[n]);
        if (end < 0) {
            return -1 - cell[n].at;
        }
        if (end == (int)size) {
            return n + 1;
        }
        at = end + 1;
    }
    return DATA_COLUMNS + 1;
}

/* ---- numbers ---- */

static int is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* why a cell that is no number is none */
static const char *no_number(data__cell cell, char point)
{
    static const char *const missing[] = {"nan",  "inf",  "infinity", "na", "n/a",
                                          "null", "none", "-",        "--"};
    const char *s = cell.s;
    size_t n = cell.n;
    if (memchr(s, ';', n) != NULL) {
        return "cells are separated by \";\", expected \",\"";
    }
    if (point == ',' && memchr(s, '.', n) != NULL) {
        return "a decimal point, but numbers before it have a decimal comma";
    }
    if (point == '.' && memchr(s, ',', n) != NULL) {
        return "a decimal comma, expected a decimal point";
    }
    for (size_t i = 0; i < sizeof missing / sizeof *missing; i++) {
        size_t k = strlen(missing[i]), same = 0, sign = 0;
        sign = n == k + 1 && k > 2 && (s[0] == '-' || s[0] == '+') ? 1 : 0;
        while (same < k && n == k + sign && (s[same + sign] | 0x20) == (missing[i][same] | 0x20)) {
            same++;
        }
        if (same == k) {
            return "not a finite number; a missing sample is an empty cell";
        }
    }
    return "expected a number";
}

/* power of ten after "e"; -1 when it is none, else bytes used */
static int exponent_at(const char *s, size_t n, int *exponent)
{
    size_t k = n > 1 && (s[1] == '+' || s[1] == '-') ? 2 : 1;
    int e = 0;
    if (k >= n || !is_digit(s[k])) {
        return -1;
    }
    for (; k < n && is_digit(s[k]); k++) {
        e = e < 100000 ? 10 * e + (s[k] - '0') : e;
    }
    *exponent = n > 1 && s[1] == '-' ? -e : e;
    return (int)k;
}

/* the text of a number, taken apart */
typedef struct decimal {
    char digit[DATA_CELL]; /* without leading zeros */
    int n, exp10, minus;
} decimal;

static int take_apart(data__cell cell, char sign, decimal *d)
{
    const char *s = cell.s;
    size_t i = 0, n = cell.n;
    int any = 0, point = 0;
    d->n = d->exp10 = 0;
    d->minus = n > 0 && s[0] == '-';
    i += n > 0 && (s[0] == '-' || s[0] == '+');
    for (; i < n && (is_digit(s[i]) || (s[i] == sign && !point)); i++) {
        if (s[i] == sign) {
            point = 1;
            continue;
        }
        any = 1;
        d->exp10 -= point;
        if (d->n > 0 || s[i] != '0') {
            d->digit[d->n++] = s[i];
        }
    }
    if (any && i < n && (s[i] == 'e' || s[i] == 'E')) {
        int e = 0, used = exponent_at(s + i, n - i, &e);
        i += used > 0 ? (size_t)used : 0;
        d->exp10 += e;
    }
    return any && i == n ? 0 : -1;
}

static double by_strtod(const decimal *d, locale_t c)
{
    char text[DATA_CELL + 16];
    locale_t before = uselocale(c);
    snprintf(text, sizeof text, "%.*se%d", d->n, d->digit, d->exp10);
    int saved = errno;
    double v = strtod(text, NULL);
    errno = saved;
    uselocale(before);
    return v;
}

/* the first decimal sign of a file decides for all of it */
static char decided(data__cell cell, char point)
{
    if (point != '\0') {
        return point;
    }
    if (memchr(cell.s, ',', cell.n) != NULL) {
        return ',';
    }
    return (char)(memchr(cell.s, '.', cell.n) != NULL ? '.' : '\0');
}

double data__last_digit(data__cell cell, int exp10, char point)
{
    decimal d;
    return cell.n < DATA_CELL && take_apart(cell, decided(cell, point), &d) == 0
               ? stein__power(10.0, d.exp10 + exp10)
               : 0.0;
}

const char *data__number(data__cell cell, int exp10, locale_t c, char *point, double *value)
{
    static const double ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                 1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    decimal d;
    if (cell.n >= DATA_CELL) {
        return "a number of more than 200 characters";
    }
    char sign = decided(cell, *point);
    if (take_apart(cell, sign, &d) != 0) {
        return no_number(cell, sign);
    }
    *point = sign;
    d.exp10 += exp10;
    double v = 0.0;
    if (d.n > 0 && d.n <= 15 && abs(d.exp10) <= 22 && FLT_EVAL_METHOD == 0) {
        long long m = 0;
        for (int i = 0; i < d.n; i++) {
            m = 10 * m + (d.digit[i] - '0');
        }
        v = d.exp10 < 0 ? (double)m / ten[-d.exp10] : (double)m * ten[d.exp10];
    } else if (d.n > 0) {
        v = by_strtod(&d, c);
    }
    if (isinf(v)) {
        return "the number is too large";
    }
    *value = d.minus ? -v : v;
    return NULL;
}
