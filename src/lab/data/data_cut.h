/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_cut.h - a record cut into windows, each a record of its own.
 * Included by: this folder, src/lab/search, src/lab/diagnosis.
 */
#ifndef DATA_CUT_H
#define DATA_CUT_H

#include "stein/data.h"

/** Is it part of its file only? */
int data__is_window(const lab_data *data);
/** Rows [from, to) of a record as a record of its own, with its settings and notes; what it states
 *  of its initial state is kept by a window that begins with the record. Nothing refers to `whole`.
 *  @return OK, ENOMEM */
stein_status data__cut(lab_data **window, const lab_data *whole, int from, int to, stein_err *err);
/** Records cut into windows of equal numbers of rows; number counts the windows.
 *  @param length [whole->n] how long a window of each record may last [s]; INFINITY: it stays whole
 *  @param least  rows of a window, at least
 *  @param of     [out->n] out, for free(): which record a window is part of
 *  @return OK, ENOMEM */
stein_status data__cut_all(lab_dataset **out, const lab_dataset *whole, const double *length,
                           int least, int **of, stein_err *err);

#endif
