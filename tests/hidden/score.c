/* SPDX-License-Identifier: GPL-3.0-or-later
 * score.c - results as files of "name value" lines, which appear whole or not at all.
 */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

typedef struct field {
    const char *name;
    char type; /* s text, i int, d double */
    size_t at;
} field;

#define FIELD(name, type)                  \
    {                                      \
#name, type, offsetof(score, name) \
    }
static const field fields[] = {
    FIELD(level, 's'),      FIELD(build, 's'),       FIELD(draw, 'i'),
    FIELD(met, 'i'),        FIELD(rough, 'i'),       FIELD(seed, 'd'),
    FIELD(reached, 'd'),    FIELD(kind, 's'),        FIELD(place, 's'),
    FIELD(cls, 's'),        FIELD(exit_code, 'i'),   FIELD(verdict, 's'),
    FIELD(first_kind, 's'), FIELD(first_place, 's'), FIELD(causes, 'i'),
    FIELD(rivals, 'i'),     FIELD(rank, 'i'),        FIELD(first, 'i'),
    FIELD(set, 'i'),        FIELD(all, 'i'),         FIELD(first_alike, 'i'),
    FIELD(set_alike, 'i'),  FIELD(right_class, 'i'), FIELD(class_alike, 'i'),
    FIELD(numbered, 'i'),   FIELD(covered, 'i'),     FIELD(found, 'd'),
    FIELD(lo, 'd'),         FIELD(hi, 'd'),          FIELD(truth, 'd'),
    FIELD(error, 'd'),      FIELD(before, 'd'),      FIELD(after, 'd'),
    FIELD(floor, 'd'),      FIELD(cpu, 'd'),         FIELD(wall, 'd'),
    FIELD(outside, 'i'),    FIELD(law_here, 'i'),    FIELD(law_right, 'i'),
    FIELD(compared, 'i'),   FIELD(law_place, 's'),   FIELD(law_of, 's'),
    FIELD(law_error, 'd'),  FIELD(law_cover, 'd'),   FIELD(experiment, 's'),
    FIELD(film, 's'),       FIELD(after_kind, 's'),  FIELD(after_place, 's'),
    FIELD(repeats, 'i'),    FIELD(separated, 'i'),   FIELD(cpu_after, 'd'),
    FIELD(threads, 'i'),    FIELD(all_alike, 'i'),   FIELD(mechanism, 's'),
    FIELD(offered, 'i'),    FIELD(tied, 'i'),        FIELD(first_tied, 'i'),
    FIELD(set_tied, 'i'),   FIELD(lost, 's')};
enum { FIELDS = sizeof fields / sizeof *fields };

static void print_value(FILE *f, const score *s, int i)
{
    const char *at = (const char *)s + fields[i].at;
    if (fields[i].type == 's') {
        fprintf(f, "%s", *at != '\0' ? at : "-");
    } else if (fields[i].type == 'i') {
        int value;
        memcpy(&value, at, sizeof value);
        fprintf(f, "%d", value);
    } else {
        double value;
        memcpy(&value, at, sizeof value);
        fprintf(f, "%.10g", value);
    }
}

void score_print(FILE *f, const score *s)
{
    for (int i = 0; i < FIELDS; i++) {
        fprintf(f, "%s ", fields[i].name);
        print_value(f, s, i);
        fputc('\n', f);
    }
}

int score_write(const char *path, const score *s)
{
    char part[PATH + 8];
    snprintf(part, sizeof part, "%s.part", path);
    FILE *f = fopen(part, "w");
    if (f == NULL) {
        perror(part);
        return -1;
    }
    score_print(f, s);
    if (fclose(f) != 0 || rename(part, path) != 0) {
        perror(path);
        return -1;
    }
    return 0;
}

static void take(score *s, const char *name, const char *value)
{
    for (int i = 0; i < FIELDS; i++) {
        char *at = (char *)s + fields[i].at;
        if (strcmp(fields[i].name, name) != 0) {
            continue;
        }
        if (fields[i].type == 's') {
            snprintf(at, NAME, "%s", value);
        } else if (fields[i].type == 'i') {
            int number = (int)strtol(value, NULL, 10);
            memcpy(at, &number, sizeof number);
        } else {
            double number = strtod(value, NULL);
            memcpy(at, &number, sizeof number);
        }
    }
}

int score_read(const char *path, score *s)
{
    char name[NAME], value[NAME];
    FILE *f = fopen(path, "r");
    if (f == NULL) {
        return -1;
    }
    memset(s, 0, sizeof *s);
    while (fscanf(f, "%99s %99s", name, value) == 2) {
        take(s, name, value);
    }
    fclose(f);
    return 0;
}

/* ---- as rows of a table ---- */

void score_head(FILE *f)
{
    for (int i = 0; i < FIELDS; i++) {
        fprintf(f, "%s%s", i > 0 ? "," : "", fields[i].name);
    }
    fputc('\n', f);
}

void score_row(FILE *f, const score *s)
{
    for (int i = 0; i < FIELDS; i++) {
        fputs(i > 0 ? "," : "", f);
        print_value(f, s, i);
    }
    fputc('\n', f);
}

int score_of_row(const char *head, const char *row, score *s)
{
    memset(s, 0, sizeof *s);
    while (*head != '\0' && *row != '\0') {
        char name[NAME], value[NAME];
        size_t n = strcspn(head, ",\n"), m = strcspn(row, ",\n");
        snprintf(name, sizeof name, "%.*s", (int)n, head);
        snprintf(value, sizeof value, "%.*s", (int)m, row);
        take(s, name, value);
        head += n + (head[n] != '\0');
        row += m + (row[m] != '\0');
    }
    return *head == *row && s->draw > 0 && s->seed > 0.0 ? 0 : -1;
}
