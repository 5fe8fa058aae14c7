/* SPDX-License-Identifier: GPL-3.0-or-later
 * open.h - a mechanism file becomes equations with values.
 *
 *   open.c     mechanism file -> equations
 *   compile.c  equations -> shared object
 *
 * Included by: src/lab, src/cli.
 */
#ifndef LAB_OPEN_H
#define LAB_OPEN_H

#include "gen.h"
#include "io.h"
#include "mechanism.h"
#include "stein/load.h"

/* ---- equations that are built in, by the structure of their mechanisms (written by make) ---- */

typedef struct lab__structure {
    const char *hash; /* gen_structure() */
    const stein_model *model;
} lab__structure;
extern const lab__structure lab__structures[]; /* closed by a NULL hash */

/* ---- open.c ---- */

/** lab_open of a text in memory; `name` stands for the file. */
stein_status lab__open_text(lab_model **out, const char *name, const char *text, size_t size,
                            const lab_options *options, stein_err *err);
/** The text that a model was opened from, freed by the caller.
 *  @param file  where it is when that was no text in memory
 *  @return OK, EIO, ENOMEM */
stein_status lab__model_text(const lab_model *model, const char *file, char **text, size_t *size,
                             stein_err *err);
/** The file behind a model. */
const mechanism *lab__mechanism(const lab_model *model);

/* ---- compile.c ---- */

/** Folder of the cache for this version of the library, not yet made; freed by the caller.
 *  @return OK, EIO (the environment names none), ENOMEM */
stein_status lab__cache(char **folder, const lab_options *options, stein_err *err);
/** Equations of a mechanism from the cache, compiled into it when they are absent or stale. */
stein_status lab__compiled(stein_library **library, const stein_model **model, const mechanism *m,
                           const gen_result *equations, const lab_options *options, stein_err *err);

#endif
