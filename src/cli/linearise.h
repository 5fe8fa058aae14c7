/* SPDX-License-Identifier: GPL-3.0-or-later
 * linearise.h - shared by the two files of stein linearise.
 * Included by: this folder.
 */
#ifndef LINEARISE_H
#define LINEARISE_H

#include "cli.h"

/** A linearised mechanism, and where. */
typedef struct cli_linear {
    const cli_args *args;
    const stein_model *model;
    const double *q, *qd; /* [nq] of the state */
    const char *at;       /* the state in words */
    const stein_linear_system *system;
    const lab_modes *modes;
} cli_linear;

void cli_linear_text(const cli_linear *l);
void cli_linear_json(const cli_linear *l);
/** As CSV. @return OK, EIO, ENOMEM */
stein_status cli_linear_csv(const cli_linear *l, const char *path, stein_err *err);

#endif
