/* SPDX-License-Identifier: GPL-3.0-or-later
 * validate.h - rows of `make validate`: a problem, where it comes from, what is right, what comes
 * out.
 */
#ifndef VALIDATE_H
#define VALIDATE_H

/** One row, on standard output, its cells divided by tabs: for table.sh.
 *  @param bar  the row is passed when error <= bar; NAN: when error is 0, which is then no number
 *  worth telling (a fact) */
void validate_row(const char *problem, const char *source, const char *reference, const char *ours,
                  double error, double bar);
/** How many rows were not passed. */
int validate_failed(void);

#endif
