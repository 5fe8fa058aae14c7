/* SPDX-License-Identifier: GPL-3.0-or-later
 * errors.h - the errors of a run: a line, fields of the JSON object, warnings and
 * the exit code.
 * Included by: this folder.
 */
#ifndef CLI_ERRORS_H
#define CLI_ERRORS_H

#include "cli.h"
#include "accuracy.h"

/** A finished run, and its observations. */
typedef struct cli_errors {
    const stein_model *model;
    const lab__accuracy *trust;
    const lab_drive *drive; /* or NULL */
    stein_integrator integrator;
    double dt, tolerance, until;
    double stiffest, stiff_time; /* largest rate of a contact [1/s], [s] */
    int stiff_contact;
    stein_step_counts steps;
    long long passes;    /* of singular positions of loops */
    double passed;       /* the last one [s] */
    int begins, busiest; /* of the contact that began most often, and which */
} cli_errors;

/** "  error of positions 2e-8 m, energy unexplained 3e-7 of 1.2 J", behind what was stiff, if
 * anything was: "  158 of 983 steps implicit: ..." */
void cli_errors_line(FILE *f, const cli_errors *e);
/** "integration", "errors", "energy" and "trusted" of the object. */
void cli_errors_json(lab__json *out, const cli_errors *e);
/** Gimbal lock on the way, if there was one, on standard error. */
void cli_errors_gimbal(const cli_errors *e);
/** Causes and remedies on standard error. @return 1: the result is not to be trusted */
int cli_errors_warn(const cli_errors *e);

#endif
