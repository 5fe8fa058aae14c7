/* SPDX-License-Identifier: GPL-3.0-or-later
 * json.c - JSON (RFC 8259) as the lab writes it: UTF-8, two spaces a level, shortest numbers.
 */
#include <math.h>
#include <string.h>

#include "io.h"

static void quoted(FILE *stream, const char *text)
{
    putc('"', stream);
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') {
            putc('\\', stream);
            putc(*c, stream);
        } else if (*c < 0x20) {
            fprintf(stream, "\\u%04x", *c);
        } else {
            putc(*c, stream);
        }
    }
    putc('"', stream);
}

/* comma, line and key in front of an entry */
static void lead(lab__json *j, const char *key)
{
    if (j->depth > 0) {
        fprintf(j->stream, "%s\n%*s", j->filled[j->depth] ? "," : "", 2 * j->depth, "");
        j->filled[j->depth] = 1;
    }
    if (key != NULL) {
        quoted(j->stream, key);
        fputs(": ", j->stream);
    }
}

void lab__json_open(lab__json *j, const char *key, char bracket)
{
    lead(j, key);
    putc(bracket, j->stream);
    if (j->depth + 1 < LAB_JSON_DEPTH) {
        j->depth++;
    }
    j->filled[j->depth] = 0;
    j->closing[j->depth] = bracket == '{' ? '}' : ']';
}

void lab__json_close(lab__json *j)
{
    char closing = j->closing[j->depth];
    int filled = j->filled[j->depth];
    j->depth--;
    if (filled) {
        fprintf(j->stream, "\n%*s", 2 * j->depth, "");
    }
    putc(closing, j->stream);
    if (j->depth == 0) {
        putc('\n', j->stream);
    }
}

void lab__json_text(lab__json *j, const char *key, const char *value)
{
    lead(j, key);
    if (value != NULL) {
        quoted(j->stream, value);
    } else {
        fputs("null", j->stream);
    }
}

void lab__json_real(lab__json *j, const char *key, double value)
{
    char text[LAB_NUMBER];
    lead(j, key);
    fputs(isfinite(value) ? lab__number(text, value) : "null", j->stream);
}

void lab__json_reals(lab__json *j, const char *key, const double *v, int n)
{
    lab__json_open(j, key, '[');
    for (int i = 0; i < n; i++) {
        lab__json_real(j, NULL, v[i]);
    }
    lab__json_close(j);
}

void lab__json_int(lab__json *j, const char *key, int value)
{
    lead(j, key);
    fprintf(j->stream, "%d", value);
}

void lab__json_bool(lab__json *j, const char *key, int value)
{
    lead(j, key);
    fputs(value ? "true" : "false", j->stream);
}

void lab__json_null(lab__json *j, const char *key)
{
    lab__json_text(j, key, NULL);
}
