/* SPDX-License-Identifier: GPL-3.0-or-later
 * creep.h - contacts that creep until the end of a run.
 * Included by: this folder.
 */
#ifndef CLI_CREEP_H
#define CLI_CREEP_H

#include "cli.h"

typedef struct cli_creep cli_creep;

/** @return NULL: no memory; free() releases it */
cli_creep *cli_creep_begin(const stein_model *model, double until);
/** At a row of the run. */
void cli_creep_look(cli_creep *c, stein_sim *sim);
/** Contacts that have crept steadily over the last rows, by lengths that count beside the largest
 * motion of a slide [m], on standard error. */
void cli_creep_warn(const cli_creep *c, double range);

#endif
