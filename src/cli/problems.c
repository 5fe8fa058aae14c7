/* SPDX-License-Identifier: GPL-3.0-or-later
 * problems.c - a problem of a mechanism file on standard error, with its line and a caret below.
 *
 *      my.yaml:7:11: unknown unit "mmm", expected a length
 *         7 | at: [0, 120 mmm, 0]
 *           |             ^
 */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli.h"

enum { SHOWN_BEFORE = 60, SHOWN = 90 }; /* characters of a line: before the caret, in all */

/* "FILE:LINE:COLUMN: ..." @return 1 and the place, 0 when the message has none */
static int place_of(const char *message, const char *file, long *line, long *column)
{
    size_t length = strlen(file);
    char *end;
    if (strncmp(message, file, length) != 0 || message[length] != ':') {
        return 0;
    }
    *line = strtol(message + length + 1, &end, 10);
    if (*end != ':') {
        return 0;
    }
    *column = strtol(end + 1, &end, 10);
    return *end == ':' && *line > 0 && *column > 0;
}

/* the text of a file that can be read twice, which a pipe cannot; NULL: it is none */
static char *text_of(const char *file)
{
    struct stat s;
    char *text = NULL;
    size_t size;
    stein_err err;
    return stat(file, &s) == 0 && S_ISREG(s.st_mode) &&
                   lab__read_file(file, &text, &size, &err) == STEIN_OK
               ? text
               : NULL;
}

static const char *find_line(const char *text, long line)
{
    for (long i = 1; i < line && text != NULL; i++) {
        text = strchr(text, '\n');
        text = text != NULL ? text + 1 : NULL;
    }
    return text;
}

/* n characters of UTF-8 further, at most to the end of the line */
static const char *further(const char *text, long n)
{
    for (; n > 0 && *text != '\0' && *text != '\n' && *text != '\r'; n--) {
        text++;
        while (((unsigned char)*text & 0xC0) == 0x80) {
            text++;
        }
    }
    return text;
}

static void put_cell(const char *from, const char *to, int blank)
{
    for (; from < to; from++) {
        unsigned char c = (unsigned char)*from;
        if (c == '\t') {
            fputc('\t', stderr); // as wide below as above
        } else if (!blank) {
            fputc(c < ' ' || c == 127 ? '?' : c, stderr);
        } else if ((c & 0xC0) != 0x80) {
            fputc(' ', stderr);
        }
    }
}

static void put_line(const char *text, long line, long column)
{
    long skipped = column - 1 > SHOWN_BEFORE ? column - 1 - SHOWN_BEFORE : 0;
    const char *start = further(text, skipped), *caret = further(text, column - 1);
    const char *dots = skipped > 0 ? "..." : "", *end = further(start, SHOWN);
    fprintf(stderr, "%6ld | %s", line, dots);
    put_cell(start, end, 0);
    fprintf(stderr, "%s\n       | %*s", *further(end, 1) != *end ? "..." : "", (int)strlen(dots),
            "");
    put_cell(start, caret, 1);
    fprintf(stderr, "^\n");
}

void cli_problem(void *file, const char *message)
{
    long line, column;
    fprintf(stderr, "%s\n", message);
    if (!place_of(message, file, &line, &column)) {
        return;
    }
    char *text = text_of(file);
    const char *at = text != NULL ? find_line(text, line) : NULL;
    if (at != NULL) {
        put_line(at, line, column);
    }
    free(text);
}
