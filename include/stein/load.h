/* SPDX-License-Identifier: MIT
 * load.h - use equations that were compiled into a shared object after libstein was built:
 *
 *     steingen my.yaml -o my.c && cc -O2 -fPIC -shared my.c -o my.so
 */
#ifndef STEIN_LOAD_H
#define STEIN_LOAD_H

#include "stein/model.h"
#include "stein/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_library stein_library;

/** Load `stein_model_<name>` from a shared object.
 *  @param file       path with at least one '/', else the linker's search path applies
 *  @param equations  hash the equations must have (stein_model.equations), or NULL for any
 *  @param model      valid until stein_library_close; close after the last simulation of it
 *  @return OK, EINVAL, ELOAD, ESTALE, ENOMEM; out-parameters untouched on failure */
stein_status stein_library_open(stein_library **library, const char *file, const char *name,
                                const char *equations, const stein_model **model, stein_err *err);
/** NULL is fine. */
void stein_library_close(stein_library *library);

#ifdef __cplusplus
}
#endif
#endif
