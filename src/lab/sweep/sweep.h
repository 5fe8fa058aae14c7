/* SPDX-License-Identifier: GPL-3.0-or-later
 * sweep.h - a sweep over a grid of parameters.
 *
 *   sweep.c      points without result are computed
 *   grid.c       points from --vary
 *   grid_file.c  does the mechanism file accept them?
 *   table.c      results, keyed by point
 *   journal.c    the same, safe from kill -9
 *
 * Included by: src/lab/plot, src/lab/study, src/lab/identity, src/cli.
 */
#ifndef LAB_SWEEP_H
#define LAB_SWEEP_H

#include "run.h"

/* ---- grid.c ---- */

/** One varied parameter. */
typedef struct lab__axis {
    char *name, *text;     /* "-1.2:0:13 mm": written always the same way */
    char unit[MECH_UNIT];  /* SI */
    char shown[MECH_UNIT]; /* the unit its values were given in */
    double factor;         /* of that unit [SI] */
    double *value;         /* [n], SI */
    int n;
} lab__axis;
struct lab_grid {
    lab__axis *axis; /* [naxis] */
    int naxis, n;
};
/** An empty grid, and one axis more. @return OK, EINVAL (what was expected), ENOMEM */
stein_status lab__grid_new(lab_grid **grid, stein_err *err);
stein_status lab__grid_add(lab_grid *grid, const char *name, const char *unit, const char *values,
                           stein_err *err);

/* ---- sweep.c ---- */

/** Find an error common to all points, by a run of one step: a stroke if the model names
 * one.
 *  @return OK (also when the file's own parameters fail numerically), EINVAL, ENOMEM */
stein_status lab__check_points(const lab_model *model, double until, double release,
                               stein_err *err);

/* ---- table.c ---- */

/** Results of a sweep as rows of CSV, keyed by point. The head states everything that determines
 *  the rows, so two tables with equal heads belong to the same sweep. */
struct lab_table {
    char *head;     /* "# name: value" lines and the line of columns, each with its newline */
    lab_grid *grid; /* read back from the head */
    int ncolumn;
    char **row; /* [n] without newline; NULL: not there */
    int n;
};
/** A table without rows from its head. @return OK, EPARSE (no head of a sweep), ENOMEM */
stein_status lab__table_new(lab_table **table, const char *head, stein_err *err);
/** Take a row with its index in the first cell.
 *  @return OK, EPARSE (no row of this table), EINVAL (another result is there), ENOMEM */
stein_status lab__table_take(lab_table *table, const char *row, size_t length, stein_err *err);
/** Column by its name without unit, -1 when absent. */
int lab__table_column(const lab_table *table, const char *name);
/** Text of a cell (not terminated). @return its length, 0 when it is empty or the row is absent */
size_t lab__table_cell(const lab_table *table, int point, int column, const char **text);
/** Number in a cell, NAN when there is none. */
double lab__table_number(const lab_table *table, int point, int column);
/** Status of a point is "ok". */
int lab__table_ok(const lab_table *table, int point);

/* ---- journal.c ---- */

typedef struct lab__journal {
    int fd;
    char *path;
} lab__journal;
/** Open or begin the journal of a sweep; finished points go into the table.
 *  @param damaged  out, may be NULL: lines that could not be read and count as not there
 *  @return OK, EIO (cannot be read, written or locked), ESTALE (of another sweep), EPARSE (no
 *          journal), ENOMEM */
stein_status lab__journal_open(lab__journal *journal, const char *path, lab_table *table,
                               int *damaged, stein_err *err);
/** Add a row: one write of one line. From any thread. @return OK, EIO */
stein_status lab__journal_add(const lab__journal *journal, const char *row, stein_err *err);
void lab__journal_close(lab__journal *journal);
/** Read a journal into a table, which is made when *table is NULL. @return as lab__journal_open */
stein_status lab__journal_read(lab_table **table, const char *path, int *damaged, stein_err *err);

#endif
