/* SPDX-License-Identifier: GPL-3.0-or-later
 * embedded.h - files of the project that the program carries as text (written by make).
 * Included by: src/lab, src/cli.
 */
#ifndef LAB_EMBEDDED_H
#define LAB_EMBEDDED_H

#include <string.h>

/** One file, line by line; a list of files is closed by a NULL name. */
typedef struct lab__source {
    const char *name; /* "src/core/sim.c" */
    const char *const *lines;
} lab__source;
/** Is it compiled by itself? */
static inline int lab__is_c(const char *name)
{
    size_t n = strlen(name);
    return n > 2 && strcmp(name + n - 2, ".c") == 0;
}
/** Sources that are compiled beside equations, files of a page, sources of an FMU; the
 *  mechanism file to begin with. */
extern const lab__source lab__core_files[], lab__page_files[], lab__fmu_files[],
    lab__starter_files[];

#endif
