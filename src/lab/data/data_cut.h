/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_cut.h - a record cut into windows, each a separate record.
 * Included by: this folder, src/lab/search, src/lab/diagnosis.
 */
#ifndef DATA_CUT_H
#define DATA_CUT_H

#include "stein/data.h"

/** Rows [from, to) of a file; in rows [gap_from, gap_to) of them outputs do not count. */
typedef struct data__window {
    int from, to, gap_from, gap_to;
} data__window;

/** Can it be cut? A record with times of events cannot: measured events can be assigned to a
 *  window, but not events of a simulation that begins there. */
int data__can_cut(const lab_data *data);
/** Is it part of its file only? */
int data__is_window(const lab_data *data);
/** Which part. */
data__window data__window_of(const lab_data *data);
/** A window of a whole record as a separate record, with its settings and notes; a window that
 *  begins with the record keeps its stated initial state. Nothing refers to `whole`.
 *  @return OK, ENOMEM */
stein_status data__cut(lab_data **out, const lab_data *whole, data__window window, stein_err *err);
/** Records cut into windows of equal numbers of rows; number counts the windows. Those that cannot
 *  be cut stay whole.
 *  @param length [whole->n] how long a window of each record may last [s]; INFINITY: it stays whole
 *  @param least  rows of a window, at least
 *  @param of     [out->n] out, for free(): which record a window is part of
 *  @return OK, ENOMEM */
stein_status data__cut_all(lab_dataset **out, const lab_dataset *whole, const double *length,
                           int least, int **of, stein_err *err);
/** Every record as two windows, of six blocks numbered from 0: the first five without the block 2,
 *  and from block 2 on without 3 and 4. So each fitted sample is in one of them and each held out
 *  one in the other, and both keep the phase of a motion over nearly the whole record.
 *  @param of  [2 whole->n] out, for free()  @return OK, ENOMEM */
stein_status data__hold_blocks(lab_dataset **out, const lab_dataset *whole, int **of,
                               stein_err *err);

#endif
