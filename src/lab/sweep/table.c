/* SPDX-License-Identifier: GPL-3.0-or-later
 * table.c - results of a sweep: rows of CSV, keyed by the point in their first cell.
 *
 *   # stein: 0.1.0                                 the head: everything that decides about the rows
 *   # vary pawl.stop_shift [m]: -1.2:0:13 mm
 *   point,pawl.stop_shift [m],status,outcome,...
 *   0,-0.0012,ok,struck,...                        a row
 *
 * The text of a row is its result, not a picture of it: the journal stores it, a merge copies it,
 * the drawing reads it back. So a table cannot depend on the way it was put together. Grid and
 * columns are read back from the head, which makes a journal complete without the mechanism file.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sweep.h"

/* ---- the head ---- */

/* "# vary NAME [UNIT]: VALUES\n" */
static stein_status read_axis(lab_table *t, const char *line, size_t length, stein_err *err)
{
    char *text = lab__text("%.*s", (int)length, line);
    if (text == NULL) {
        return lab__no_memory(err);
    }
    char *name = text + strlen("# vary "), *unit = strstr(name, " ["),
         *values = strstr(name, "]: ");
    stein_status status = STEIN_EPARSE;
    if (unit != NULL && values != NULL && unit < values) {
        *unit = *values = '\0';
        status = lab__grid_add(t->grid, name, unit + 2, values + 3, err);
    }
    free(text);
    return status;
}

static int count_cells(const char *row, size_t length)
{
    int n = 1;
    for (size_t i = 0; i < length; i++) {
        n += row[i] == ',';
    }
    return n;
}

static stein_status read_head(lab_table *t, stein_err *err)
{
    stein_status status = lab__grid_new(&t->grid, err);
    const char *line = t->head;
    while (status == STEIN_OK && *line == '#') {
        size_t length = strcspn(line, "\n");
        if (strncmp(line, "# vary ", 7) == 0) {
            status = read_axis(t, line, length, err);
        }
        line += length + (line[length] == '\n');
    }
    if (status == STEIN_OK && strncmp(line, "point,", 6) == 0) {
        t->ncolumn = count_cells(line, strlen(line));
        t->n = t->grid->n;
        return STEIN_OK;
    }
    return status == STEIN_ENOMEM ? status
                                  : lab__fail(err, STEIN_EPARSE, "this is no head of a sweep");
}

stein_status lab__table_new(lab_table **out, const char *head, stein_err *err)
{
    lab_table *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lab__no_memory(err);
    }
    t->head = lab__text("%s", head);
    stein_status status = t->head != NULL ? read_head(t, err) : lab__no_memory(err);
    if (status == STEIN_OK) {
        t->row = calloc((size_t)t->n + 1, sizeof *t->row);
        status = t->row != NULL ? STEIN_OK : lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        lab_table_destroy(t);
        return status;
    }
    *out = t;
    return STEIN_OK;
}

void lab_table_destroy(lab_table *t)
{
    if (t != NULL) {
        for (int i = 0; t->row != NULL && i < t->n; i++) {
            free(t->row[i]);
        }
        lab_grid_destroy(t->grid);
        free(t->row);
        free(t->head);
        free(t);
    }
}

int lab_table_points(const lab_table *t)
{
    return t->n;
}

int lab_table_has(const lab_table *t, int point)
{
    return point >= 0 && point < t->n && t->row[point] != NULL;
}

/* ---- rows ---- */

/* index in the first cell, -1 when there is none of this table */
static int point_of(const lab_table *t, const char *row, size_t length)
{
    long point = 0;
    size_t i = 0;
    for (; i < length && i < 9 && row[i] >= '0' && row[i] <= '9'; i++) {
        point = 10 * point + (row[i] - '0');
    }
    int fits = i > 0 && i < length && row[i] == ',' && point < t->n &&
               memchr(row, '\0', length) == NULL && count_cells(row, length) == t->ncolumn;
    return fits ? (int)point : -1;
}

stein_status lab__table_take(lab_table *t, const char *row, size_t length, stein_err *err)
{
    int point = point_of(t, row, length);
    if (point < 0) {
        return lab__fail(err, STEIN_EPARSE, "this is no row of the sweep");
    }
    if (t->row[point] != NULL) {
        int same = strlen(t->row[point]) == length && memcmp(t->row[point], row, length) == 0;
        return same ? STEIN_OK
                    : lab__fail(err, STEIN_EINVAL, "point %d has two different results", point);
    }
    char *copy = malloc(length + 1);
    if (copy == NULL) {
        return lab__no_memory(err);
    }
    memcpy(copy, row, length);
    copy[length] = '\0';
    t->row[point] = copy;
    return STEIN_OK;
}

/* ---- cells ---- */

/* cell k of a line without newline */
static size_t cell_of(const char *line, int k, const char **text)
{
    for (; k > 0; k--) {
        line += strcspn(line, ",\n");
        line += *line == ',';
    }
    *text = line;
    return strcspn(line, ",\n");
}

int lab__table_column(const lab_table *t, const char *name)
{
    const char *line = strstr(t->head, "point,"), *cell;
    while (line > t->head && line[-1] != '\n') {
        line = strstr(line + 1, "point,");
    }
    for (int i = 0; i < t->ncolumn; i++) {
        size_t length = cell_of(line, i, &cell), n = strlen(name);
        if (length >= n && strncmp(cell, name, n) == 0 &&
            (length == n || strncmp(cell + n, " [", 2) == 0)) {
            return i;
        }
    }
    return -1;
}

size_t lab__table_cell(const lab_table *t, int point, int column, const char **text)
{
    *text = "";
    return lab_table_has(t, point) && column >= 0 ? cell_of(t->row[point], column, text) : 0;
}

double lab__table_number(const lab_table *t, int point, int column)
{
    const char *text;
    char cell[LAB_NUMBER];
    double value;
    size_t length = lab__table_cell(t, point, column, &text);
    if (length == 0 || length >= sizeof cell) {
        return NAN;
    }
    memcpy(cell, text, length);
    cell[length] = '\0';
    return mech_parse_quantity(cell, (mech_dim){.m = 0}, &value, NULL) == STEIN_OK ? value : NAN;
}

int lab__table_ok(const lab_table *t, int point)
{
    const char *text;
    size_t length = lab__table_cell(t, point, lab__table_column(t, "status"), &text);
    return length == 2 && strncmp(text, "ok", 2) == 0;
}

/* ---- output ---- */

stein_status lab_table_write(const char *path, const lab_table *t, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    fputs(t->head, file.stream);
    for (int i = 0; i < t->n; i++) {
        if (t->row[i] != NULL) {
            fprintf(file.stream, "%s\n", t->row[i]);
        }
    }
    return lab__file_close(&file, 1, err);
}

stein_status lab_merge(lab_table **out, const char *const *journal, int n, int *damaged,
                       stein_err *err)
{
    lab_table *t = NULL;
    stein_status status = n > 0 ? STEIN_OK : lab__fail(err, STEIN_EINVAL, "no journal to merge");
    if (damaged != NULL) {
        *damaged = 0;
    }
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        int bad = 0;
        status = lab__journal_read(&t, journal[i], &bad, err);
        if (damaged != NULL) {
            *damaged += bad;
        }
    }
    if (status != STEIN_OK) {
        lab_table_destroy(t);
        return status;
    }
    *out = t;
    return STEIN_OK;
}
