/* SPDX-License-Identifier: GPL-3.0-or-later
 * validate.h - rows of `make validate`: a problem, where it comes from, what is right, what comes
 * out, how long that took, and a picture of it.
 */
#ifndef VALIDATE_H
#define VALIDATE_H

/** Curves of a picture: lines, and dots. */
enum { VALIDATE_LINE, VALIDATE_SECOND, VALIDATE_THIRD, VALIDATE_DOTS, VALIDATE_CURVES };
/** A point of the next row's picture; what is not finite interrupts a line. Points beyond 20000 are
 *  left out. */
void validate_point(int curve, double x, double y);
/** What the axes of that picture are. */
void validate_axes(const char *x, const char *y);

/** One row, on standard output, its cells divided by tabs: for table.sh. Its time is that of the
 *  processor since the row before it.
 *  @param bar  the row is passed when error <= bar; NAN: when error is 0, which is then no number
 *  worth telling (a fact) */
void validate_row(const char *problem, const char *source, const char *reference, const char *ours,
                  double error, double bar);
/** How many rows were not passed. */
int validate_failed(void);

#endif
