/* SPDX-License-Identifier: GPL-3.0-or-later
 * exchange.c - model exchange: an integrator of our own, Runge-Kutta 4 with events by bisection,
 * against the same mechanism in co-simulation; refusals; states that are kept.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importer.h"

#define F3(name) ((__typeof__(&fmi3##name))fmu_function(u->f, "fmi3" #name))
#define F2(name) ((__typeof__(&fmi2##name))fmu_function(u->f, "fmi2" #name))
#define IS3      (u->f->version == 3)

enum { MOST = 64 };              /* states, indicators */
static const double finer = 5.0; /* steps than the file's, so that their error is negligible */

/* ---- the functions of both versions ---- */

static void hear3(void *environment, fmi3Status status, fmi3String category, fmi3String message)
{
    unit *u = environment;
    u->messages++;
    u->events += strcmp(category, "logEvents") == 0;
    u->status = (int)status;
    snprintf(u->said, sizeof u->said, "%s", message);
    snprintf(u->category, sizeof u->category, "%s", category);
}

static void hear2(void *environment, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String format, ...)
{
    va_list list;
    char message[sizeof((unit *)environment)->said];
    (void)name;
    va_start(list, format);
    vsnprintf(message, sizeof message, format, list);
    va_end(list);
    hear3(environment, (fmi3Status)status, category, message);
}

static void begin(unit *u, const fmu *f)
{
    *u = (unit){.f = f};
    if (IS3) {
        u->c = F3(InstantiateModelExchange)("one", f->d.token, NULL, 0, 1, u, hear3);
    } else {
        fmi2CallbackFunctions functions = {hear2, calloc, free, NULL, u};
        u->c = F2(Instantiate)("one", fmi2ModelExchange, f->d.token, "", &functions, 0, 1);
    }
    claim(u->c != NULL, "an instance for model exchange");
}

static int get_states(unit *u, double *x, size_t n)
{
    return IS3 ? (int)F3(GetContinuousStates)(u->c, x, n)
               : (int)F2(GetContinuousStates)(u->c, x, n);
}

static int set_states(unit *u, const double *x, size_t n)
{
    return IS3 ? (int)F3(SetContinuousStates)(u->c, x, n)
               : (int)F2(SetContinuousStates)(u->c, x, n);
}

static int get_rates(unit *u, double *x, size_t n)
{
    return IS3 ? (int)F3(GetContinuousStateDerivatives)(u->c, x, n)
               : (int)F2(GetDerivatives)(u->c, x, n);
}

static int get_indicators(unit *u, double *z, size_t n)
{
    return IS3 ? (int)F3(GetEventIndicators)(u->c, z, n) : (int)F2(GetEventIndicators)(u->c, z, n);
}

static int set_time(unit *u, double t)
{
    return IS3 ? (int)F3(SetTime)(u->c, t) : (int)F2(SetTime)(u->c, t);
}

static int complete(unit *u, int *event)
{
    bool event3 = false, over3 = true;
    int over = 1;
    int status = IS3 ? (int)F3(CompletedIntegratorStep)(u->c, true, &event3, &over3)
                     : (int)F2(CompletedIntegratorStep)(u->c, 1, event, &over);
    *event = IS3 ? event3 : *event;
    return status == OK && (IS3 ? over3 : over) ? FAILED : status;
}

static int enter_events(unit *u)
{
    return IS3 ? (int)F3(EnterEventMode)(u->c) : (int)F2(EnterEventMode)(u->c);
}

static int go_on(unit *u)
{
    return IS3 ? (int)F3(EnterContinuousTimeMode)(u->c) : (int)F2(EnterContinuousTimeMode)(u->c);
}

/* @param moved  out: have states jumped? */
static int update(unit *u, int *moved)
{
    bool again = true, over = true, nominals = true, values = true, timed = true;
    double next;
    if (IS3) {
        int status =
            (int)F3(UpdateDiscreteStates)(u->c, &again, &over, &nominals, &values, &timed, &next);
        *moved = values;
        return status == OK && (again || over || nominals || timed) ? FAILED : status;
    }
    fmi2EventInfo info;
    memset(&info, 1, sizeof info);
    int status = (int)F2(NewDiscreteStates)(u->c, &info);
    *moved = info.valuesOfContinuousStatesChanged;
    return status == OK && (info.newDiscreteStatesNeeded || info.terminateSimulation ||
                            info.nominalsOfContinuousStatesChanged || info.nextEventTimeDefined)
               ? FAILED
               : status;
}

/* ---- an integrator ---- */

typedef struct motion {
    unit *u;
    size_t nx, nz;
    double t, h, x[MOST], z[MOST];
    int switches;
    int sticks; /* then states may jump to rest at an event */
} motion;

static void rates_at(const motion *m, double t, const double *x, double *rate)
{
    int status = set_time(m->u, t);
    status = status == OK ? set_states(m->u, x, m->nx) : status;
    status = status == OK ? get_rates(m->u, rate, m->nx) : status;
    if (status != OK) {
        claim(0, "rates at t = %g s: %s", t, m->u->said);
    }
}

/* result of a step of h */
static void try_step(const motion *m, double h, double *to)
{
    static const double c[4] = {0.0, 0.5, 0.5, 1.0}, b[4] = {1.0, 2.0, 2.0, 1.0};
    double x[MOST], k[4][MOST];
    for (int i = 0; i < 4; i++) {
        for (size_t j = 0; j < m->nx; j++) {
            x[j] = m->x[j] + (i > 0 ? h * c[i] * k[i - 1][j] : 0.0);
        }
        rates_at(m, m->t + c[i] * h, x, k[i]);
    }
    for (size_t j = 0; j < m->nx; j++) {
        to[j] = m->x[j];
        for (int i = 0; i < 4; i++) {
            to[j] += h * b[i] / 6.0 * k[i][j];
        }
    }
}

/* has an indicator another sign there? */
static int differs(const motion *m, double h, const double *x)
{
    double z[MOST] = {0.0};
    int yes = 0, status = set_time(m->u, m->t + h);
    status = status == OK ? set_states(m->u, x, m->nx) : status;
    status = status == OK ? get_indicators(m->u, z, m->nz) : status;
    if (status != OK) {
        claim(0, "indicators at t = %g s: %s", m->t + h, m->u->said);
    }
    for (size_t i = 0; i < m->nz; i++) {
        yes |= (z[i] > 0.0) != (m->z[i] > 0.0);
    }
    return yes;
}

static void switch_now(motion *m)
{
    int moved = 1;
    claim(enter_events(m->u) == OK && update(m->u, &moved) == OK && moved == m->sticks &&
              go_on(m->u) == OK,
          "an event at t = %g s: %s", m->t, m->u->said);
    claim(get_states(m->u, m->x, m->nx) == OK, "states after it");
    claim(get_indicators(m->u, m->z, m->nz) == OK, "indicators after it");
    m->switches++;
}

/* one step of the length h, or up to the first event in it */
static void step(motion *m, double h)
{
    double to[MOST], begin = 0.0, end = h;
    int event = -1;
    try_step(m, h, to);
    int crossed = differs(m, h, to);
    for (int i = 0; crossed && i < 50; i++) {
        double middle = 0.5 * (begin + end), there[MOST];
        try_step(m, middle, there);
        if (differs(m, middle, there)) {
            end = middle;
            memcpy(to, there, sizeof to);
        } else {
            begin = middle;
        }
    }
    (void)differs(m, end, to); // be there
    if (complete(m->u, &event) != OK || event != crossed) {
        claim(0, "a step at t = %g s: %d events, not %d", m->t, event, crossed);
    }
    memcpy(m->x, to, sizeof m->x);
    m->t += end;
    if (crossed) {
        switch_now(m);
    }
}

static void start(motion *m, unit *u, const fmu *f)
{
    size_t nx = 2 * (size_t)f->model->nq, nz = 0;
    int moved = 1;
    *m = (motion){.u = u, .nx = nx};
    if (IS3) {
        claim(F3(GetNumberOfContinuousStates)(u->c, &m->nx) == fmi3OK && m->nx == nx &&
                  F3(GetNumberOfEventIndicators)(u->c, &nz) == fmi3OK,
              "numbers of states and indicators");
    }
    m->nz = (size_t)f->model->nspot + 4 * (size_t)f->model->nnotch + (size_t)f->model->nstick;
    m->sticks = f->model->nstick > 0;
    claim(!IS3 || nz == m->nz, "%d indicators", (int)nz);
    claim(unit_enter(u, 0.0, -1.0) == OK && unit_exit(u) == OK && update(u, &moved) == OK &&
              !moved && go_on(u) == OK,
          "it starts: %s", u->said);
    m->h = unit_value(u, "simulation.dt") / finer;
    claim(get_states(u, m->x, m->nx) == OK && get_indicators(u, m->z, m->nz) == OK, "its state");
}

/* ---- claims ---- */

/* the outputs of a co-simulation at t */
static int outputs_of(const fmu *f, const char *input, double value, double t, double *y)
{
    unit u;
    double at = 0.0;
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK &&
              unit_put(&u, "simulation.dt", f->model->dt / finer) == OK &&
              unit_enter(&u, 0.0, -1.0) == OK && unit_exit(&u) == OK,
          "a co-simulation");
    if (input != NULL) {
        (void)unit_put(&u, input, value);
    }
    claim(unit_run(&u, &at, t / 10.0, 10) == OK, "it runs");
    int n = unit_outputs(&u, y);
    unit_free(&u);
    return n;
}

static void check_motion(const fmu *f, const char *input, double value, double until)
{
    unit u;
    motion m;
    double y[OUTPUTS], there[OUTPUTS], worst = 0.0, rates[MOST];
    begin(&u, f);
    start(&m, &u, f);
    if (input != NULL) {
        claim(unit_put(&u, input, value) == OK, "an input is set in Continuous-Time Mode");
        claim(get_states(&u, m.x, m.nx) == OK, "which may be a motion that states follow");
    }
    claim(get_rates(&u, rates, m.nx) == OK, "rates");
    for (size_t i = 0; i < m.nx; i += 2) {
        claim(same(rates[i], m.x[i + 1]), "the rate of a place is a speed");
    }
    while (m.t < until - 1e-9) {
        step(&m, fmin(m.h, until - m.t));
    }
    int n = unit_outputs(&u, y);
    claim(n == outputs_of(f, input, value, until, there), "as many outputs");
    for (int i = 0; i < n; i++) {
        worst = fmax(worst, fabs(y[i] - there[i]) / (1.0 + fabs(there[i])));
    }
    printf("note: model exchange and co-simulation differ by %.1e after %g s, %d switches\n", worst,
           until, m.switches);
    claim(worst < 1e-7, "model exchange is off by %g", worst);
    claim((m.switches > 0) == (m.nz > 0) && (u.events > 0) == (m.nz > 0),
          "%d switches, %d events told", m.switches, u.events);
    claim(unit_terminate(&u) == OK, "it ends");
    unit_free(&u);
}

static void said(const unit *u, int status, const char *words)
{
    claim(status == FAILED && u->status == FAILED && strstr(u->said, words) != NULL,
          "expected \"... %s ...\", was told \"%s\" (%d)", words, u->said, status);
}

static void check_exchange_refusals(const fmu *f)
{
    unit u, slave;
    motion m;
    double reached, none[MOST] = {0.0};
    void *state = NULL, *other = NULL;
    begin(&u, f);
    start(&m, &u, f);
    said(&u, unit_step(&u, 0.0, 1e-3, &reached),
         "DoStep is not allowed now: the instance is in Continuous-Time Mode");
    unit_reset(&u);
    start(&m, &u, f);
    said(&u, set_states(&u, none, m.nx - 1), "numbers, expected");
    unit_reset(&u);
    start(&m, &u, f);
    none[1] = (double)NAN;
    said(&u, set_states(&u, none, m.nx), "expected finite numbers");
    unit_reset(&u);
    start(&m, &u, f);
    said(&u, set_time(&u, (double)INFINITY), "expected a finite one");
    unit_reset(&u);
    start(&m, &u, f);
    claim(unit_start(&slave, f) == OK && unit_keep(&slave, &other) == OK &&
              unit_keep(&u, &state) == OK,
          "two states");
    said(&u, unit_take(&u, other), "of an instance for another use");
    said(&slave, set_time(&slave, 0.0),
         "SetTime is not allowed now: the instance is between two steps");
    unit_drop(&slave, &other);
    unit_drop(&u, &state);
    unit_free(&slave);
    unit_free(&u);
}

/* kept in the middle, and once more from there */
static void check_exchange_state(const fmu *f)
{
    unit u;
    motion m, back;
    void *state = NULL;
    begin(&u, f);
    start(&m, &u, f);
    for (int i = 0; i < 20; i++) {
        step(&m, 250.0 * m.h);
    }
    claim(unit_keep(&u, &state) == OK, "a state is kept");
    back = m;
    for (int i = 0; i < 20; i++) {
        step(&m, 250.0 * m.h);
    }
    claim(unit_take(&u, state) == OK, "and taken");
    for (int i = 0; i < 20; i++) {
        step(&back, 250.0 * back.h);
    }
    claim(memcmp(m.x, back.x, sizeof *m.x * m.nx) == 0 && same(m.t, back.t), "the same bits again");
    unit_drop(&u, &state);
    unit_free(&u);
}

/* a load that is lifted in Event Mode: its speed has jumped, and it stays */
static void check_exchange_load(const fmu *f)
{
    unit u;
    motion m;
    int moved = 0;
    begin(&u, f);
    start(&m, &u, f);
    step(&m, m.h);
    claim(unit_set_flag(&u, description_find(&f->d, "load.present")->reference, 0) == FAILED,
          "it is not lifted in Continuous-Time Mode");
    unit_reset(&u);
    start(&m, &u, f);
    step(&m, m.h);
    claim(enter_events(&u) == OK && unit_put(&u, "load.present", 0.0) == OK &&
              update(&u, &moved) == OK && moved && go_on(&u) == OK &&
              get_states(&u, m.x, m.nx) == OK && get_indicators(&u, m.z, m.nz) == OK,
          "it is lifted in Event Mode: %s", u.said);
    double before = unit_value(&u, "load.q");
    step(&m, m.h);
    claim(same(unit_value(&u, "load.q"), before), "and stays where it is");
    unit_free(&u);
}

void check_exchange(const fmu *f)
{
    if (f->model == NULL) {
        return;
    }
    static const struct {
        const char *input;
        double value;
    } inputs[] = {{"push", 0.02}, {"slide_motion.speed", 0.1}};
    int is_action = description_find(&f->d, "load.present") != NULL, k = 0;
    while (k < 2 && description_find(&f->d, inputs[k].input) == NULL) {
        k++;
    }
    check_motion(f, k < 2 ? inputs[k].input : NULL, k < 2 ? inputs[k].value : 0.0,
                 is_action ? 0.06 : 0.5);
    check_exchange_refusals(f);
    check_exchange_state(f);
    if (is_action) {
        check_exchange_load(f);
    }
}
