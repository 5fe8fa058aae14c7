/* SPDX-License-Identifier: GPL-3.0-or-later
 * compare.c - two tables with the same rows: how far their columns are apart.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

enum { LINE = 4096, COLUMNS = 32 };

typedef struct table {
    char name[COLUMNS][NAME];
    int n, rows;
    double *value; /* [rows * n] */
} table;

static void take_names(table *t, char *line)
{
    for (char *word = strtok(line, ",\n"); word != NULL && t->n < COLUMNS;
         word = strtok(NULL, ",\n")) {
        snprintf(t->name[t->n++], NAME, "%.*s", (int)strcspn(word, " "), word);
    }
}

static int read_table(const char *path, table *t)
{
    static char line[LINE];
    size_t room = 0;
    memset(t, 0, sizeof *t);
    FILE *f = fopen(path, "r");
    if (f == NULL) {
        perror(path);
        return -1;
    }
    while (fgets(line, LINE, f) != NULL) {
        if (line[0] == '#') {
            continue;
        }
        if (t->n == 0) {
            take_names(t, line);
            continue;
        }
        size_t need = (size_t)(t->rows + 1) * (size_t)t->n;
        if (need > room) {
            room = 2 * need + 1000;
            double *more = realloc(t->value, sizeof(double) * room);
            if (more == NULL) {
                break;
            }
            t->value = more;
        }
        char *at = line;
        for (int i = 0; i < t->n; i++) {
            t->value[t->rows * t->n + i] = strtod(at, &at);
            at += *at == ',';
        }
        t->rows++;
    }
    fclose(f);
    return t->rows > 0 ? 0 : -1;
}

/* difference of column i of a and column j of b, over the largest value; `skip` rows at both ends
 * are left out, where a spline through samples of a motion is bent */
static double apart(const table *a, int i, const table *b, int j, int skip)
{
    double most = 0.0, largest = 0.0;
    for (int k = skip; k < a->rows - skip && k < b->rows - skip; k++) {
        double x = a->value[k * a->n + i], y = b->value[k * b->n + j];
        most = fmax(most, fabs(x));
        largest = isnan(x - y) ? INFINITY : fmax(largest, fabs(x - y));
    }
    return most > 0.0 ? largest / most : largest;
}

int compare_files(const char *first, const char *second, int skip)
{
    table a, b;
    int status = read_table(first, &a) == 0 && read_table(second, &b) == 0 ? 0 : -1;
    for (int i = 0; status == 0 && i < a.n; i++) {
        for (int j = 0; j < b.n; j++) {
            if (strcmp(a.name[i], b.name[j]) == 0) {
                printf("%s %.3g\n", a.name[i], apart(&a, i, &b, j, skip));
            }
        }
    }
    free(a.value);
    free(b.value);
    return status;
}
