/* SPDX-License-Identifier: GPL-3.0-or-later
 * page.h - shared by the files of this folder.
 *
 *   page.c      the page put together       wasm.c  core and equations -> WebAssembly
 *   describe.c  the mechanism for the script of the page, as JSON
 *
 * The page's own files are in src/page; make puts them, and the sources of the core, into the
 * program as text.
 * Included by: this folder.
 */
#ifndef LAB_PAGE_H
#define LAB_PAGE_H

#include "embedded.h"
#include "open.h"

/** The module of a mechanism, from the cache or compiled into it.
 *  @param bytes  out, freed by the caller
 *  @return OK, EIO, ENOMEM, ECOMPILE (with what is missing on this machine) */
stein_status page__module(char **bytes, size_t *size, const lab_model *model,
                          const lab_options *options, stein_err *err);

/** Write the description of a mechanism for the script.
 *  @param hash  of the state at the end of the file's own run, as text */
void page__describe(FILE *stream, const lab_model *model, const char *hash);

#endif
