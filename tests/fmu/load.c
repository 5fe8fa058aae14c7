/* SPDX-License-Identifier: GPL-3.0-or-later
 * load.c - an FMU's shared object, and its functions as both standards name them.
 */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importer.h"

/* the function NAME of the standard, with its type from the declaration */
#define F3(name) ((__typeof__(&fmi3##name))fmu_function(u->f, "fmi3" #name))
#define F2(name) ((__typeof__(&fmi2##name))fmu_function(u->f, "fmi2" #name))
#define IS3      (u->f->version == 3)

void (*fmu_function(const fmu *f, const char *name))(void)
{
    void (*function)(void) = NULL;
    void *symbol = dlsym(f->library, name);
    if (symbol == NULL) {
        printf("FAILED: the FMU has no %s\n", name);
        exit(1);
    }
    memcpy(&function, &symbol, sizeof function);
    return function;
}

int fmu_open(fmu *f, int version, const char *library, const char *file)
{
    memset(f, 0, sizeof *f);
    f->version = version;
    f->library = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    if (f->library == NULL) {
        printf("%s\n", dlerror());
        return 0;
    }
    if (!description_read(&f->d, file)) {
        return 0;
    }
    for (int i = 0; stein_models[i] != NULL; i++) {
        if (strcmp(stein_models[i]->name, f->d.identifier) == 0) {
            f->model = stein_models[i];
        }
    }
    return 1;
}

/* ---- its messages ---- */

static void hear(unit *u, int status, const char *category, const char *message)
{
    u->messages++;
    u->events += strcmp(category, "logEvents") == 0;
    u->status = status;
    snprintf(u->said, sizeof u->said, "%s", message);
    snprintf(u->category, sizeof u->category, "%s", category);
}

static void hear3(void *environment, fmi3Status status, fmi3String category, fmi3String message)
{
    hear(environment, (int)status, category, message);
}

static void hear2(void *environment, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String format, ...)
{
    char message[512];
    va_list list;
    (void)name;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    hear(environment, (int)status, category, message);
}

/* ---- life ---- */

int unit_new(unit *u, const fmu *f, const char *name, const char *token, int logs)
{
    memset(u, 0, sizeof *u);
    u->f = f;
    if (IS3) {
        u->c = F3(InstantiateCoSimulation)(name, token, NULL, 0, logs != 0, 0, 0, NULL, 0, u, hear3,
                                           NULL);
    } else {
        fmi2CallbackFunctions functions = {hear2, calloc, free, NULL, u};
        u->c = F2(Instantiate)(name, fmi2CoSimulation, token, "", &functions, 0, logs != 0);
    }
    return u->c != NULL ? OK : NO_INSTANCE;
}

void unit_free(unit *u)
{
    if (IS3) {
        F3(FreeInstance)(u->c);
    } else {
        F2(FreeInstance)(u->c);
    }
    u->c = NULL;
}

int unit_log(unit *u, int on, size_t n, const char *const *categories)
{
    return IS3 ? (int)F3(SetDebugLogging)(u->c, on != 0, n, categories)
               : (int)F2(SetDebugLogging)(u->c, on, n, categories);
}

int unit_enter(unit *u, double start, double stop)
{
    if (IS3) {
        return (int)F3(EnterInitializationMode)(u->c, 0, 0.0, start, stop >= start, stop);
    }
    int status = (int)F2(SetupExperiment)(u->c, 0, 0.0, start, stop >= start, stop);
    return status == OK ? (int)F2(EnterInitializationMode)(u->c) : status;
}

int unit_exit(unit *u)
{
    return IS3 ? (int)F3(ExitInitializationMode)(u->c) : (int)F2(ExitInitializationMode)(u->c);
}

int unit_terminate(unit *u)
{
    return IS3 ? (int)F3(Terminate)(u->c) : (int)F2(Terminate)(u->c);
}

int unit_reset(unit *u)
{
    return IS3 ? (int)F3(Reset)(u->c) : (int)F2(Reset)(u->c);
}

/* ---- variables ---- */

int unit_get(unit *u, unsigned reference, double *value)
{
    return IS3 ? (int)F3(GetFloat64)(u->c, &reference, 1, value, 1)
               : (int)F2(GetReal)(u->c, &reference, 1, value);
}

int unit_set(unit *u, unsigned reference, double value)
{
    return IS3 ? (int)F3(SetFloat64)(u->c, &reference, 1, &value, 1)
               : (int)F2(SetReal)(u->c, &reference, 1, &value);
}

int unit_get_flag(unit *u, unsigned reference, int *value)
{
    bool flag = false;
    if (!IS3) {
        return (int)F2(GetBoolean)(u->c, &reference, 1, value);
    }
    int status = (int)F3(GetBoolean)(u->c, &reference, 1, &flag, 1);
    *value = flag;
    return status;
}

int unit_set_flag(unit *u, unsigned reference, int value)
{
    bool flag = value != 0;
    return IS3 ? (int)F3(SetBoolean)(u->c, &reference, 1, &flag, 1)
               : (int)F2(SetBoolean)(u->c, &reference, 1, &value);
}

/* ---- steps, states, derivatives ---- */

int unit_step(unit *u, double at, double h, double *reached)
{
    bool event = true, over = true, early = true;
    int status;
    if (IS3) {
        status = (int)F3(DoStep)(u->c, at, h, true, &event, &over, &early, reached);
        return status == OK && (event || over || early) ? FAILED : status;
    }
    status = (int)F2(DoStep)(u->c, at, h, 1);
    int known = (int)F2(GetRealStatus)(u->c, fmi2LastSuccessfulTime, reached);
    return known == OK ? status : known;
}

int unit_keep(unit *u, void **state)
{
    return IS3 ? (int)F3(GetFMUState)(u->c, state) : (int)F2(GetFMUstate)(u->c, state);
}

int unit_take(unit *u, void *state)
{
    return IS3 ? (int)F3(SetFMUState)(u->c, state) : (int)F2(SetFMUstate)(u->c, state);
}

int unit_drop(unit *u, void **state)
{
    return IS3 ? (int)F3(FreeFMUState)(u->c, state) : (int)F2(FreeFMUstate)(u->c, state);
}

int unit_size(unit *u, void *state, size_t *size)
{
    return IS3 ? (int)F3(SerializedFMUStateSize)(u->c, state, size)
               : (int)F2(SerializedFMUstateSize)(u->c, state, size);
}

int unit_pack(unit *u, void *state, unsigned char *bytes, size_t size)
{
    return IS3 ? (int)F3(SerializeFMUState)(u->c, state, bytes, size)
               : (int)F2(SerializeFMUstate)(u->c, state, (char *)bytes, size);
}

int unit_unpack(unit *u, const unsigned char *bytes, size_t size, void **state)
{
    return IS3 ? (int)F3(DeserializeFMUState)(u->c, bytes, size, state)
               : (int)F2(DeSerializeFMUstate)(u->c, (const char *)bytes, size, state);
}

int unit_slope(unit *u, unsigned unknown, unsigned known, double seed, double *slope)
{
    return IS3 ? (int)F3(GetDirectionalDerivative)(u->c, &unknown, 1, &known, 1, &seed, 1, slope, 1)
               : (int)F2(GetDirectionalDerivative)(u->c, &unknown, 1, &known, 1, &seed, slope);
}

/* ---- shorter ---- */

int unit_start(unit *u, const fmu *f)
{
    int status = unit_new(u, f, "one", f->d.token, 1);
    status = status == OK ? unit_log(u, 0, 1, (const char *[]){"logEvents"}) : status;
    status = status == OK ? unit_enter(u, 0.0, -1.0) : status;
    return status == OK ? unit_exit(u) : status;
}

static const variable *named(const unit *u, const char *name)
{
    const variable *v = description_find(&u->f->d, name);
    if (v == NULL) {
        printf("FAILED: no variable %s\n", name);
        exit(1);
    }
    return v;
}

double unit_value(unit *u, const char *name)
{
    double value = -12345.678;
    (void)unit_get(u, named(u, name)->reference, &value);
    return value;
}

int unit_value_flag(unit *u, const char *name)
{
    int value = -1;
    (void)unit_get_flag(u, named(u, name)->reference, &value);
    return value;
}

int unit_put(unit *u, const char *name, double value)
{
    const variable *v = named(u, name);
    return v->boolean ? unit_set_flag(u, v->reference, value != 0.0)
                      : unit_set(u, v->reference, value);
}

int unit_run(unit *u, double *at, double h, int steps)
{
    double begin = *at, reached;
    int status = OK;
    for (int i = 0; status == OK && i < steps; i++) {
        double t = begin + i * h;
        status = unit_step(u, t, h, &reached);
        *at = begin + (i + 1) * h;
    }
    return status;
}

int unit_outputs(unit *u, double *y)
{
    int n = 0;
    for (int i = 0; i < u->f->d.n && n < OUTPUTS; i++) {
        const variable *v = &u->f->d.v[i];
        if (strcmp(v->causality, "output") == 0 || strcmp(v->causality, "local") == 0) {
            (void)unit_get(u, v->reference, &y[n++]);
        }
    }
    return n;
}
