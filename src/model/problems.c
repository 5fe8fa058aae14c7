/* SPDX-License-Identifier: MIT
 * problems.c - collects all problems of a file, for one report.
 *
 * Problems are found in the order of the reader's passes and handed over in the order of the file.
 * Messages hold user text only after it was made printable and short.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

enum { SHOWN = 60, WORD = 64 };

void mech__one_line(char *text)
{
    for (; text && *text; text++) {
        if ((unsigned char)*text < ' ' || *text == 127) {
            *text = '?';
        }
    }
}

const char *mech__shown(mech__reader *rd, const char *text)
{
    size_t n = strlen(text), cut = n;

    if (n > SHOWN) {
        for (cut = SHOWN; cut > 0 && ((unsigned char)text[cut] & 0xC0) == 0x80; cut--) {
        }
    }
    char *copy = mech__alloc(rd, cut + 4);

    if (!copy) {
        return "";
    }
    for (size_t i = 0; i < cut; i++) {
        copy[i] = text[i];
        if ((unsigned char)copy[i] < ' ' || copy[i] == 127) {
            copy[i] = '?';
        }
    }
    memcpy(copy + cut, cut < n ? "..." : "", cut < n ? 4 : 1);
    return copy;
}

/** "file:line:column: what", in the arena; NULL without memory. */
static char *placed(mech__reader *rd, int line, int column, const char *format, va_list args)
{
    char what[600], *text = NULL;

    vsnprintf(what, sizeof what, format, args);
    if (line > 0) {
        text = mech__print(rd, "%s:%d:%d: %s", rd->file, line, column, what);
    } else {
        text = mech__print(rd, "%s: %s", rd->file, what);
    }
    mech__one_line(text); // with names, units and the file's own name
    return text;
}

static void add_problem(mech__reader *rd, int line, int column, const char *format, va_list args)
{
    if (rd->nproblem >= MECH__MAX_PROBLEMS) {
        rd->nproblem = MECH__MAX_PROBLEMS + 1;
        return;
    }
    char *text = placed(rd, line, column, format, args);

    if (text) {
        rd->problems[rd->nproblem].line = line;
        rd->problems[rd->nproblem].column = column;
        rd->problems[rd->nproblem].text = text;
        rd->nproblem++;
    }
}

void mech__problem_in(mech__reader *rd, const mech__node *node, size_t skip, const char *format,
                      ...)
{
    va_list args;
    int column = node ? node->column : 0;

    if (node && node->kind == MECH__SCALAR && node->plain) {
        for (size_t i = 0; i < skip && node->text[i]; i++) {
            column += ((unsigned char)node->text[i] & 0xC0) != 0x80;
        }
    }
    va_start(args, format);
    add_problem(rd, node ? node->line : 0, column, format, args);
    va_end(args);
}

void mech__problem_at(mech__reader *rd, const mech__node *node, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    add_problem(rd, node ? node->line : 0, node ? node->column : 0, format, args);
    va_end(args);
}

void mech__warn_at(mech__reader *rd, const mech__node *node, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    char *text = placed(rd, node->line, node->column, format, args);
    va_end(args);
    if (text && rd->nwarning < MECH_BODIES) {
        rd->warnings[rd->nwarning++] = text;
    }
}

/** Stable insertion sort by place: there are at most 50. */
static void sort_problems(mech__reader *rd, int n)
{
    for (int i = 1; i < n; i++) {
        mech__problem p = rd->problems[i];
        int k = i;

        for (; k > 0; k--) {
            const mech__problem *before = &rd->problems[k - 1];

            if (before->line < p.line || (before->line == p.line && before->column <= p.column)) {
                break;
            }
            rd->problems[k] = *before;
        }
        rd->problems[k] = p;
    }
}

void mech__problems_flush(mech__reader *rd, mech_report *report, void *ctx, stein_err *err)
{
    int more = rd->nproblem > MECH__MAX_PROBLEMS;
    int n = more ? MECH__MAX_PROBLEMS : rd->nproblem;

    sort_problems(rd, n);
    if (err && n > 0) {
        err->code = STEIN_EPARSE;
        snprintf(err->msg, sizeof err->msg, "%s", rd->problems[0].text);
    }
    for (int i = 0; report && i < n; i++) {
        report(ctx, rd->problems[i].text);
    }
    if (report && more) {
        char text[600];

        snprintf(text, sizeof text, "%.500s: more than %d problems, the rest is not shown",
                 rd->file, MECH__MAX_PROBLEMS);
        report(ctx, text);
    }
}

static char lower(char c)
{
    return (char)(c >= 'A' && c <= 'Z' ? c + 32 : c);
}

/** Optimal string alignment distance without regard to case, cut to `WORD` characters.
 *  @return it, or any larger number than `most` when it exceeds that */
static int distance(const char *a, const char *b, int most)
{
    int row[3][WORD + 1], least_before = 0;
    int na = (int)strlen(a), nb = (int)strlen(b);

    if (na > WORD || nb > WORD) {
        return WORD;
    }
    for (int k = 0; k <= nb; k++) {
        row[0][k] = k;
        row[2][k] = 0;
    }
    for (int i = 1; i <= na; i++) {
        int *now = row[i % 3];
        const int *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];

        int least = i;

        now[0] = i;
        for (int k = 1; k <= nb; k++) {
            int same = lower(a[i - 1]) == lower(b[k - 1]);
            int best = last[k - 1] + !same;

            best = last[k] + 1 < best ? last[k] + 1 : best;
            best = now[k - 1] + 1 < best ? now[k - 1] + 1 : best;
            if (i > 1 && k > 1 && lower(a[i - 1]) == lower(b[k - 2]) &&
                lower(a[i - 2]) == lower(b[k - 1]) && before[k - 2] + 1 < best) {
                best = before[k - 2] + 1;
            }
            now[k] = best;
            least = best < least ? best : least;
        }
        if (least > most && least_before > most) { // a swap reaches two rows back
            return WORD + 1;
        }
        least_before = least;
    }
    return row[na % 3][nb];
}

void mech__offer(mech__nearest *n, const char *candidate)
{
    int length = (int)strlen(n->word);
    int allowed = length < 2 ? 0 : 1 + length / 5;

    if (n->best && n->distance <= allowed) {
        allowed = n->distance - 1; // of equally near ones the first
    }
    if (abs(length - (int)strlen(candidate)) > allowed) {
        return;
    }
    int d = distance(n->word, candidate, allowed);

    if (d <= allowed) {
        n->best = candidate;
        n->distance = d;
    }
}

const char *mech__hint(mech__reader *rd, const mech__nearest *n, const char *otherwise)
{
    if (!n->best) {
        return otherwise ? otherwise : "";
    }
    const char *text = mech__print(rd, ", did you mean \"%s\"?", n->best);

    return text ? text : "";
}

/** Words that cannot name anything in the generated C. */
static int is_keyword(const char *name)
{
    static const char *const words[] = {
        "auto",    "break",  "case",     "char",   "const",    "continue", "default",
        "do",      "double", "else",     "enum",   "extern",   "float",    "for",
        "goto",    "if",     "inline",   "int",    "long",     "register", "restrict",
        "return",  "short",  "signed",   "sizeof", "static",   "struct",   "switch",
        "typedef", "union",  "unsigned", "void",   "volatile", "while",
    };

    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(words[i], name) == 0) {
            return 1;
        }
    }
    return 0;
}

int mech__name_check(mech__reader *rd, const mech__node *node, const char *what)
{
    const char *s = node->text;
    size_t n = 0;

    if ((lower(s[0]) >= 'a' && lower(s[0]) <= 'z')) {
        while ((lower(s[n]) >= 'a' && lower(s[n]) <= 'z') || (s[n] >= '0' && s[n] <= '9') ||
               s[n] == '_') {
            n++;
        }
    }
    if (n == 0 || s[n] != '\0' || n >= MECH_NAME) {
        mech__problem_at(rd, node,
                         "\"%s\" cannot name %s, expected a letter and then at most %d "
                         "letters, digits or _",
                         mech__shown(rd, s), what, MECH_NAME - 2);
        return 0;
    }
    if (is_keyword(s)) {
        mech__problem_at(rd, node, "\"%s\" cannot name %s: it is a word of the language C", s,
                         what);
        return 0;
    }
    return 1;
}

void mech__name_copy(char *to, size_t room, const char *from)
{
    size_t n = strlen(from);

    n = n < room ? n : room - 1;
    memcpy(to, from, n);
    to[n] = '\0';
}
