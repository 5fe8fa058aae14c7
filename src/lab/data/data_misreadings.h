/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_misreadings.h - other readings of records, and their misfit.
 * Included by: this folder.
 */
#ifndef DATA_MISREADINGS_H
#define DATA_MISREADINGS_H

#include "data_compare.h"

enum { DATA_UNITS = 4 };

/** Another way to read records: which column, exchanged with which, in which unit or sign. By name,
 *  because the columns of the records may stand in different orders. */
typedef struct data__guess {
    const char *a, *b, *unit; /* NULL: none */
    double factor, time;
    int tested, accepted, cured; /* records: tried; it fits the affected channels; all of them */
    int first;                   /* record that it was accepted in first, -1: none */
    double off, then, score;     /* sums over the records in which it was accepted */
    double travel, predicted;    /* of the first affected channel there */
    double also[DATA_UNITS];     /* factors of other units that fit about as well */
    int nalso;
} data__guess;

typedef struct data__suspects {
    const lab_model *model;
    const lab_dataset *data;
    data__match **plain; /* [n] of each record, as read */
    data__match *other;  /* room for one more */
    data__guess *guess;  /* [room] */
    int nguess;
    lab_doubts *out;
    stein_status status;
    stein_err *err;
} data__suspects;

/** The reading of a record. @return 0: the columns do not exist */
int data__reading_of(const data__guess *g, const lab_data *d, data__reading *reading);

/* ---- data_misreadings.c ---- */

/** @param or_column  another column that may have the wrong sign instead; NULL: none has
 *  @param alone      1: only this record is off */
void data__tell_guess(data__suspects *a, const data__guess *g, const char *or_column, int records,
                      int alone);
void data__tell_foreign(data__suspects *a, int record, double own, double median);
void data__tell_travel(data__suspects *a, int record, int column, double reach, double then);

#endif
