/* SPDX-License-Identifier: GPL-3.0-or-later
 * checks.c - start values, and everything that an importer may do wrong: it is refused with a
 * reason, the instance is over, and a reset makes it as new.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "importer.h"

/* the first variable of a causality and variability ("": any) */
static const variable *first(const fmu *f, const char *causality, const char *variability)
{
    for (int i = 0; i < f->d.n; i++) {
        const variable *v = &f->d.v[i];
        if (strcmp(v->causality, causality) == 0 && !v->boolean &&
            (*variability == '\0' || strcmp(v->variability, variability) == 0)) {
            return v;
        }
    }
    return NULL;
}

/* a damping or a friction that can be turned */
static const variable *not_negative(const fmu *f)
{
    for (int i = 0; i < f->d.n; i++) {
        const variable *v = &f->d.v[i];
        size_t n = strlen(v->name);
        if (strcmp(v->variability, "tunable") == 0 &&
            ((n > 8 && strcmp(v->name + n - 8, ".damping") == 0) ||
             (n > 11 && strcmp(v->name + n - 11, ".friction.A") == 0))) {
            return v;
        }
    }
    return NULL;
}

void check_starts(const fmu *f)
{
    unit u;
    int bad = 0, n = 0;
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK, "an instance");
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < f->d.n; i++) {
            const variable *v = &f->d.v[i];
            double value = NAN;
            int flag = -1;
            int status = v->boolean     ? unit_get_flag(&u, v->reference, &flag)
                         : v->has_start ? unit_get(&u, v->reference, &value)
                                        : OK;
            int good =
                v->boolean ? flag == (v->start != 0.0) : !v->has_start || same(value, v->start);
            bad += status != OK || !good;
            n += v->has_start;
        }
        claim(bad == 0, "%d of %d start values are those of the description (round %d)", n - bad, n,
              round);
        const variable *p = first(f, "parameter", "fixed");
        claim(unit_set(&u, p->reference, 1.25 * p->start + 0.5) == OK, "a parameter is set");
        claim(unit_reset(&u) == OK, "a reset");
    }
    unit_free(&u);
    if (f->model == NULL) {
        return;
    }
    bad = 0;
    for (int i = 0; i < f->model->np; i++) {
        const variable *v = description_find(&f->d, f->model->params[i].name);
        bad += v == NULL || !same(v->start, f->model->params[i].value);
    }
    claim(bad == 0, "%d parameters have not the value of the mechanism", bad);
}

/* the last message has these words, as an error */
static void said(const unit *u, int status, const char *words)
{
    claim(status == FAILED, "%s: status %d, expected an error", words, status);
    claim(u->messages > 0 && u->status == FAILED && strcmp(u->category, "logStatusError") == 0 &&
              strstr(u->said, words) != NULL,
          "expected \"... %s ...\", was told \"%s\" (%s, %d)", words, u->said, u->category,
          u->status);
}

/* after an error nothing goes on but a reset */
static void over(unit *u)
{
    double reached;
    claim(unit_step(u, 0.0, 1e-3, &reached) == FAILED && strstr(u->said, "after an error") != NULL,
          "a step after an error is refused: \"%s\"", u->said);
    claim(unit_reset(u) == OK && unit_enter(u, 0.0, -1.0) == OK && unit_exit(u) == OK &&
              unit_step(u, 0.0, 1e-3, &reached) == OK,
          "after a reset it runs: \"%s\"", u->said);
}

static void check_calls(const fmu *f)
{
    unit u;
    double x, reached;
    int flag;
    const variable *output = first(f, "output", ""), *fixed = first(f, "parameter", "fixed");
    const variable *local = first(f, "local", ""), *tunable = first(f, "parameter", "tunable"),
                   *ranged = not_negative(f);
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK, "an instance");

    said(&u, unit_step(&u, 0.0, 1e-3, &reached), "DoStep is not allowed now");
    over(&u);
    unit_reset(&u);
    said(&u, unit_get(&u, output->reference, &x), "has no value before Initialization Mode");
    over(&u);
    unit_reset(&u);
    said(&u, unit_exit(&u), "ExitInitializationMode is not allowed now");
    over(&u);
    said(&u, unit_enter(&u, 0.0, -1.0), "is not allowed now: the instance is between two steps");
    over(&u);
    said(&u, unit_get(&u, 4000000000u, &x), "no variable has the value reference");
    over(&u);
    said(&u, unit_set(&u, 77777, 1.0), "no variable has the value reference 77777");
    over(&u);
    said(&u, unit_set(&u, output->reference, 1.0), "cannot be set: it is an output");
    over(&u);
    said(&u, unit_set(&u, local->reference, 1.0), "cannot be set: it is an output or a local");
    over(&u);
    said(&u, unit_set(&u, fixed->reference, fixed->start),
         "cannot be set: it is a fixed parameter");
    over(&u);
    said(&u, unit_set(&u, tunable->reference, (double)NAN), "expected a finite number");
    over(&u);
    if (ranged != NULL) {
        said(&u, unit_set(&u, ranged->reference, -1e-9), "at least 0");
        over(&u);
    }
    said(&u, unit_get_flag(&u, output->reference, &flag), "is no Boolean");
    over(&u);
    said(&u, unit_step(&u, 1e-3, -1e-3, &reached), "expected a positive length");
    over(&u);
    said(&u, unit_step(&u, 1e-3, (double)NAN, &reached), "expected a positive length");
    over(&u);
    said(&u, unit_step(&u, 0.5, 1e-3, &reached), "but the mechanism is at t = ");
    over(&u);
    said(&u, unit_step(&u, (double)NAN, 1e-3, &reached), "but the mechanism is at t = ");
    over(&u);
    said(&u, unit_log(&u, 1, 1, (const char *[]){"logAll"}), "no log category \"logAll\"");
    over(&u);
    claim(unit_terminate(&u) == OK, "it can be terminated");
    claim(unit_get(&u, output->reference, &x) == OK, "and read");
    said(&u, unit_step(&u, 1e-3, 1e-3, &reached), "the instance is terminated");
    over(&u);

    unit_reset(&u);
    claim(unit_set(&u, description_find(&f->d, "simulation.dt")->reference, 0.0) == FAILED,
          "a step of the integrator of nothing");
    over(&u);
    unit_reset(&u);
    said(&u, unit_enter(&u, (double)NAN, -1.0), "expected a start and a later stop");
    over(&u);
    unit_reset(&u);
    claim(unit_enter(&u, 0.0, 0.0105) == OK && unit_exit(&u) == OK, "with a stop time");
    x = 0.0;
    claim(unit_run(&u, &x, 1e-3, 10) == OK, "up to it");
    said(&u, unit_step(&u, 0.01, 1e-3, &reached), "beyond the stop time");
    over(&u);
    unit_free(&u);
}

/* a missing part of a state: instance, state, bytes, or the place for them */
static void check_no_state(const fmu *f)
{
    unit u = {.f = f}, none = {.f = f};
    void *state = NULL;
    unsigned char bytes[8] = {0};
    size_t size;
    claim(unit_start(&u, f) == OK && unit_keep(&u, &state) == OK, "a state");
    claim(unit_keep(&none, &state) == FAILED && unit_take(&none, state) == FAILED &&
              unit_size(&none, state, &size) == FAILED &&
              unit_pack(&none, state, bytes, sizeof bytes) == FAILED &&
              unit_unpack(&none, bytes, sizeof bytes, &state) == FAILED &&
              unit_drop(&none, &state) == FAILED && state != NULL,
          "there are no states without an instance");
    const char *get = f->version == 3 ? "fmi3GetFMUState: no place" : "fmi2GetFMUstate: no place";
    said(&u, unit_keep(&u, NULL), get);
    over(&u);
    said(&u, unit_take(&u, NULL), "SetFMU");
    over(&u);
    said(&u, unit_size(&u, NULL, &size), "Size: there is no state");
    over(&u);
    said(&u, unit_size(&u, state, NULL), "no place for its size");
    over(&u);
    said(&u, unit_pack(&u, NULL, bytes, sizeof bytes), "SerializeFMU");
    over(&u);
    said(&u, unit_pack(&u, state, NULL, sizeof bytes), "no state or no room");
    over(&u);
    said(&u, unit_unpack(&u, NULL, sizeof bytes, &state), "erializeFMU");
    over(&u);
    said(&u, unit_unpack(&u, bytes, sizeof bytes, NULL), "no bytes or no room");
    over(&u);
    claim(unit_drop(&u, NULL) == OK && unit_drop(&u, &state) == OK && state == NULL,
          "a state is given back");
    unit_free(&u);
}

void check_refusals(const fmu *f)
{
    unit u;
    claim(unit_new(&u, f, "one", "{wrong}", 1) == NO_INSTANCE &&
              strstr(u.said, "do not belong together") != NULL,
          "a wrong token: \"%s\"", u.said);
    claim(unit_new(&u, f, " \t", f->d.token, 1) == NO_INSTANCE &&
              strstr(u.said, "needs a name") != NULL,
          "a blank name: \"%s\"", u.said);
    claim(unit_new(&u, f, "one", NULL, 1) == NO_INSTANCE, "no token");
    u.f = f;
    u.c = NULL;
    unit_free(&u); // nothing happens
    claim(unit_reset(&u) == FAILED && unit_terminate(&u) == FAILED, "no instance");
    check_calls(f);
    check_no_state(f);

    double reached;
    claim(unit_new(&u, f, "quiet", f->d.token, 0) == OK, "an instance that does not log");
    said(&u, unit_step(&u, 0.0, 1e-3, &reached), "DoStep is not allowed now");
    claim(u.messages == 1 && unit_reset(&u) == OK && unit_log(&u, 0, 0, NULL) == OK,
          "refuses, and says so once (%d messages)", u.messages);
    said(&u, unit_step(&u, 0.0, 1e-3, &reached), "DoStep is not allowed now");
    unit_free(&u);
}

/* ---- functions that a simple slave does not have ---- */

typedef void plain(void);

static void check_rest3(const fmu *f)
{
    static const char *const modes[] = {"fmi3EnterEventMode",          "fmi3EnterStepMode",
                                        "fmi3EnterContinuousTimeMode", "fmi3EvaluateDiscreteStates",
                                        "fmi3EnterConfigurationMode",  "fmi3ExitConfigurationMode"};
    unit u;
    unsigned reference = 1;
    int32_t whole = 0;
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        claim(unit_start(&u, f) == OK, "an instance");
        fmi3Status (*mode)(fmi3Instance) = (fmi3Status(*)(fmi3Instance))fmu_function(f, modes[i]);
        said(&u, (int)mode(u.c), modes[i]);
        over(&u);
        unit_free(&u);
    }
    claim(unit_start(&u, f) == OK, "an instance");
    __typeof__(&fmi3GetInt32) get = (__typeof__(&fmi3GetInt32))fmu_function(f, "fmi3GetInt32");
    claim(get(u.c, NULL, 0, NULL, 0) == fmi3OK, "no variables are read without an error");
    said(&u, (int)get(u.c, &reference, 1, &whole, 1), "has no variables of Int32");
    over(&u);
    __typeof__(&fmi3SetTime) set_time = (__typeof__(&fmi3SetTime))fmu_function(f, "fmi3SetTime");
    said(&u, (int)set_time(u.c, 1.0), "fmi3SetTime is not allowed now");
    over(&u);
    double value, values[2];
    __typeof__(&fmi3GetFloat64) real =
        (__typeof__(&fmi3GetFloat64))fmu_function(f, "fmi3GetFloat64");
    said(&u, (int)real(u.c, &reference, 1, values, 2), "one value each");
    over(&u);
    (void)value;
    unit_free(&u);
    u.messages = 0;
    __typeof__(&fmi3InstantiateCoSimulation) create =
        (__typeof__(&fmi3InstantiateCoSimulation))fmu_function(f, "fmi3InstantiateCoSimulation");
    claim(create("one", f->d.token, NULL, 0, 0, 1, 0, NULL, 0, NULL, NULL, NULL) == NULL,
          "there is no event mode");
    claim(create("one", f->d.token, NULL, 0, 0, 0, 0, &reference, 1, NULL, NULL, NULL) == NULL,
          "nor intermediate variables");
    __typeof__(&fmi3InstantiateScheduledExecution) schedule =
        (__typeof__(schedule))fmu_function(f, "fmi3InstantiateScheduledExecution");
    claim(schedule("one", f->d.token, NULL, 0, 1, NULL, NULL, NULL, NULL, NULL) == NULL,
          "nor scheduled execution");
    claim(strcmp(((const char *(*)(void))fmu_function(f, "fmi3GetVersion"))(), "3.0") == 0,
          "its version");
}

static void check_rest2(const fmu *f)
{
    unit u;
    unsigned reference = 1;
    int whole = 0, order = 1;
    double value = 0.0;
    claim(unit_start(&u, f) == OK, "an instance");
    __typeof__(&fmi2GetInteger) get =
        (__typeof__(&fmi2GetInteger))fmu_function(f, "fmi2GetInteger");
    claim(get(u.c, NULL, 0, NULL) == fmi2OK, "no variables are read without an error");
    said(&u, (int)get(u.c, &reference, 1, &whole), "has no variables of Integer");
    over(&u);
    __typeof__(&fmi2GetRealOutputDerivatives) slopes =
        (__typeof__(slopes))fmu_function(f, "fmi2GetRealOutputDerivatives");
    said(&u, (int)slopes(u.c, &reference, 1, &order, &value), "has no derivatives of outputs");
    over(&u);
    __typeof__(&fmi2CancelStep) cancel = (__typeof__(cancel))fmu_function(f, "fmi2CancelStep");
    said(&u, (int)cancel(u.c), "no step is under way");
    over(&u);
    __typeof__(&fmi2GetStatus) status = (__typeof__(status))fmu_function(f, "fmi2GetStatus");
    fmi2Status pending;
    claim(status(u.c, fmi2PendingStatus, &pending) == fmi2Discard, "no step is pending");
    __typeof__(&fmi2GetBooleanStatus) ended =
        (__typeof__(ended))fmu_function(f, "fmi2GetBooleanStatus");
    claim(ended(u.c, fmi2Terminated, &whole) == fmi2OK && !whole, "it does not end by itself");
    unit_free(&u);
    claim(strcmp(((const char *(*)(void))fmu_function(f, "fmi2GetVersion"))(), "2.0") == 0 &&
              strcmp(((const char *(*)(void))fmu_function(f, "fmi2GetTypesPlatform"))(),
                     "default") == 0,
          "version and platform");
    __typeof__(&fmi2Instantiate) create =
        (__typeof__(&fmi2Instantiate))fmu_function(f, "fmi2Instantiate");
    fmi2CallbackFunctions none = {NULL, NULL, NULL, NULL, NULL};
    claim(create("one", fmi2ModelExchange, "{wrong}", "", &none, 0, 1) == NULL,
          "a wrong token for model exchange");
    claim(create("one", fmi2CoSimulation, f->d.token, "", NULL, 0, 1) == NULL,
          "there is no instance without functions");
}

void check_rest(const fmu *f)
{
    if (f->version == 3) {
        check_rest3(f);
    } else {
        check_rest2(f);
    }
}
