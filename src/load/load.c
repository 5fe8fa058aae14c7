/* SPDX-License-Identifier: MIT
 * load.c - equations compiled later, as a shared object.
 *
 * Not part of the embedded core: it needs a dynamic linker and allocates. What it loads is checked
 * for layout and identity before anyone calls into it: stale equations are an error, never a
 * silently wrong result.
 */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "stein/load.h"

struct stein_library {
    void *handle;
};

stein_status stein_library_open(stein_library **out, const char *file, const char *name,
                                const char *equations, const stein_model **model, stein_err *err)
{
    static const char prefix[] = "stein_model_";
    char symbol[sizeof prefix + 64];
    if (strlen(name) > 64) {
        return stein__fail(err, STEIN_EINVAL, "model name \"%s\" is longer than 64 characters",
                           name);
    }
    strcpy(symbol, prefix);
    strcat(symbol, name);

    void *handle = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (handle == NULL) {
        return stein__fail(err, STEIN_ELOAD, "%s", dlerror());
    }
    const stein_model *found = dlsym(handle, symbol);
    stein_status status = STEIN_OK;
    if (found == NULL) {
        status = stein__fail(err, STEIN_ELOAD, "%s has no symbol \"%s\"", file, symbol);
    } else if (found->abi != STEIN_MODEL_ABI ||
               (equations != NULL && strcmp(found->equations, equations) != 0)) {
        status = stein__fail(err, STEIN_ESTALE,
                             "%s holds equations %s of layout %d, expected %s of "
                             "layout %d: remove it and try again",
                             file, found->equations, found->abi,
                             equations != NULL ? equations : "any", STEIN_MODEL_ABI);
    }
    stein_library *library = status == STEIN_OK ? malloc(sizeof *library) : NULL;
    if (library == NULL) {
        dlclose(handle);
        return status != STEIN_OK
                   ? status
                   : stein__fail(err, STEIN_ENOMEM, "out of memory while loading %s", file);
    }
    library->handle = handle;
    *out = library;
    *model = found;
    return STEIN_OK;
}

void stein_library_close(stein_library *library)
{
    if (library != NULL) {
        dlclose(library->handle);
        free(library);
    }
}
