/* SPDX-License-Identifier: GPL-3.0-or-later
 * runs.c - the numbers: the bits of `stein simulate` and of the C interface, in every order of
 * calls.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importer.h"

static const double tick = 1e-3; /* communication step [s] */

/* ---- a record ---- */

enum { COLUMNS = 64 };

/* names of the columns: "name [unit],..." */
static int read_head(char *line, const fmu *f, unsigned *reference)
{
    int n = 0;
    char *left = NULL;
    for (char *c = strtok_r(line, ",\n", &left); c != NULL && n < COLUMNS;
         c = strtok_r(NULL, ",\n", &left)) {
        c[strcspn(c, " ")] = '\0';
        const variable *v = description_find(&f->d, c);
        claim(v != NULL, "%s is a variable", c);
        reference[n++] = v != NULL ? v->reference : 0;
    }
    return n;
}

void check_record(const fmu *f, const char *csv)
{
    static char line[8192];
    unsigned reference[COLUMNS];
    FILE *file = fopen(csv, "r");
    unit u;
    double at = 0.0, reached;
    int n = 0, rows = 0, bad = 0;
    claim(file != NULL && unit_start(&u, f) == OK, "%s and an instance", csv);
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        if (line[0] == '#') {
            continue;
        }
        if (n == 0) {
            n = read_head(line, f, reference);
            continue;
        }
        char *c = line;
        double t = strtod(c, NULL), value;
        if (t > at) {
            claim(unit_step(&u, at, t - at, &reached) == OK && fabs(reached - t) < 1e-12,
                  "a step to %.17g: %s", t, u.said);
        }
        at = t;
        for (int i = 0; i < n; i++) {
            double expected = strtod(c, &c);
            c += *c == ',';
            int good = unit_get(&u, reference[i], &value) == OK && same(value, expected);
            if (!good && bad++ == 0) {
                printf("note: column %d at %.17g: %.17g, expected %.17g\n", i, t, value, expected);
            }
        }
        rows++;
    }
    claim(rows > 50 && bad == 0, "%d rows of %d columns: %d values have other bits", rows, n, bad);
    if (file != NULL) {
        fclose(file);
        unit_free(&u);
    }
}

/* ---- steps of any length ---- */

static int equal_outputs(unit *a, unit *b)
{
    double x[OUTPUTS], y[OUTPUTS];
    int n = unit_outputs(a, x);
    return unit_outputs(b, y) == n && n > 0 && memcmp(x, y, sizeof *x * (size_t)n) == 0;
}

void check_steps(const fmu *f)
{
    unit a, b, c;
    double ta = 0.0, tb = 0.0, tc = 10.0, reached;
    claim(unit_start(&a, f) == OK && unit_start(&b, f) == OK, "two instances");
    claim(unit_new(&c, f, "late", f->d.token, 1) == OK && unit_enter(&c, 10.0, 11.0) == OK &&
              unit_exit(&c) == OK,
          "one that starts at 10 s");
    long before = allocations();
    claim(unit_run(&a, &ta, tick, 60) == OK, "60 steps");
    claim(allocations() == before, "steps allocate nothing (%ld times)", allocations() - before);
    claim(unit_step(&b, tb, 0.06, &reached) == OK && same(reached, 0.06), "one step");
    claim(unit_run(&c, &tc, tick, 60) == OK, "60 later steps");
    claim(equal_outputs(&a, &b), "60 steps are one step");
    claim(equal_outputs(&a, &c), "and do not depend on the start time");
    claim(fabs(unit_value(&c, "time") - 10.06) < 1e-12, "time is the importer's");
    // times that are summed up
    double sum = 0.06, h = fmax(1e-4, description_find(&f->d, "simulation.dt")->start);
    int steps = (int)(0.02 / h + 0.5);
    for (int i = 0; i < steps; i++, sum += h) {
        claim(unit_step(&a, sum, h, &reached) == OK, "a step from %.17g: %s", sum, a.said);
    }
    claim(unit_step(&b, 0.06, 0.02, &reached) == OK, "the same at once");
    claim(equal_outputs(&a, &b), "rounded times do not matter");
    claim(unit_step(&b, 0.08, 1.2345e-4, &reached) == OK && same(reached, 0.08 + 1.2345e-4) &&
              fabs(unit_value(&b, "time") - reached) < 1e-15,
          "an end off the grid is reached exactly");
    unit_free(&a);
    unit_free(&b);
    unit_free(&c);

    // another step of the integrator
    claim(unit_new(&a, f, "fine", f->d.token, 1) == OK, "an instance");
    double dt = description_find(&f->d, "simulation.dt")->start;
    claim(unit_put(&a, "simulation.dt", 0.5 * dt) == OK && unit_enter(&a, 0.0, -1.0) == OK &&
              unit_exit(&a) == OK && unit_step(&a, 0.0, 0.02, &reached) == OK,
          "half of the step");
    if (f->model != NULL) {
        stein_sim_def def = stein_sim_def_default(f->model);
        stein_sim *sim;
        def.dt = 0.5 * dt;
        claim(stein_sim_create(&sim, f->model, &def, NULL) == STEIN_OK &&
                  stein_run(sim, 0.02, NULL) == STEIN_OK,
              "the same in C");
        for (int i = 1; i < f->model->nchannel; i++) {
            claim(same(unit_value(&a, f->model->channels[i].name), stein_read(sim, i)),
                  "%s with half of the step", f->model->channels[i].name);
        }
        stein_sim_destroy(sim);
    }
    unit_free(&a);
}

/* ---- states ---- */

static void check_settings(const fmu *f, const char *force);

/* the last force among the inputs, or NULL */
static const char *force_of(const fmu *f)
{
    const char *force = NULL;
    for (int i = 0; f->model != NULL && i < f->model->ninput; i++) {
        if (f->model->inputs[i].kind != STEIN_INPUT_MOTION) {
            force = f->model->inputs[i].name;
        }
    }
    return force;
}

void check_states(const fmu *f)
{
    unit a, b;
    double t = 0.0, back, first[OUTPUTS], again[OUTPUTS], there[OUTPUTS];
    void *state = NULL, *copy = NULL, *start = NULL;
    size_t size = 0;
    claim(unit_new(&a, f, "one", f->d.token, 1) == OK && unit_enter(&a, 0.0, -1.0) == OK &&
              unit_keep(&a, &start) == OK && unit_exit(&a) == OK,
          "a state in Initialization Mode");
    claim(unit_run(&a, &t, tick, 45) == OK && unit_keep(&a, &state) == OK, "a state at 45 ms");
    back = t;
    claim(unit_run(&a, &t, tick, 40) == OK, "on to 85 ms");
    int n = unit_outputs(&a, first);
    claim(unit_take(&a, state) == OK && fabs(unit_value(&a, "time") - back) < 1e-15,
          "back to 45 ms");
    t = back;
    claim(unit_run(&a, &t, tick, 40) == OK && unit_outputs(&a, again) == n &&
              memcmp(first, again, sizeof *first * (size_t)n) == 0,
          "continued from a state: the same bits");
    long before = allocations();
    claim(unit_keep(&a, &state) == OK && unit_take(&a, state) == OK,
          "a state that is written over");
    claim(allocations() == before, "takes no memory");
    claim(unit_step(&a, t, tick, &back) == OK, "goes on");

    claim(unit_take(&a, start) == OK && unit_exit(&a) == OK, "back to Initialization Mode");
    t = 0.0;
    claim(unit_run(&a, &t, tick, 45) == OK && unit_keep(&a, &state) == OK, "again to 45 ms");
    claim(unit_size(&a, state, &size) == OK && size > 0, "a size");
    unsigned char *bytes = malloc(size + 1);
    claim(unit_pack(&a, state, bytes, size) == OK, "bytes");
    claim(unit_start(&b, f) == OK && unit_unpack(&b, bytes, size, &copy) == OK &&
              unit_take(&b, copy) == OK,
          "in another instance");
    t = 0.045;
    claim(unit_run(&b, &t, tick, 40) == OK && unit_outputs(&b, there) == n &&
              memcmp(first, there, sizeof *first * (size_t)n) == 0,
          "serialised: the same bits");
    int refused = 0;
    for (size_t i = 0; i < size; i += size / 97) {
        void *bad = NULL;
        bytes[i] ^= 0x10;
        refused += unit_unpack(&b, bytes, size, &bad) == FAILED && bad == NULL;
        refused -= i == 0 && strstr(b.said, "none of this version") == NULL;
        bytes[i] ^= 0x10;
    }
    claim(refused >= 97, "damaged bytes are refused (%d)", refused);
    claim(unit_unpack(&b, bytes, size - 1, &copy) == FAILED &&
              strstr(b.said, "another size") != NULL,
          "bytes that are cut off: %s", b.said);
    claim(unit_take(&b, copy) == OK, "a state helps after an error");
    claim(unit_pack(&b, copy, bytes, size - 1) == FAILED, "too little room");
    free(bytes);
    claim(unit_drop(&a, &state) == OK && state == NULL && unit_drop(&a, &start) == OK &&
              unit_drop(&b, &copy) == OK,
          "states are freed");
    unit_free(&a);
    unit_free(&b);
    if (force_of(f) != NULL) {
        check_settings(f, force_of(f));
    }
}

/* inputs and parameters are part of it */
static void check_settings(const fmu *f, const char *force)
{
    unit a, b;
    double t = 0.0, s, first[OUTPUTS], again[OUTPUTS];
    void *state = NULL, *copy = NULL;
    unsigned char bytes[8192];
    size_t size = 0;
    const variable *tunable = NULL;
    for (int i = 0; i < f->d.n && tunable == NULL; i++) {
        const variable *v = &f->d.v[i];
        tunable = strcmp(v->variability, "tunable") == 0 && v->start != 0.0 ? v : NULL;
    }
    claim(unit_start(&a, f) == OK && unit_run(&a, &t, tick, 10) == OK &&
              unit_put(&a, force, 0.37) == OK &&
              unit_set(&a, tunable->reference, 0.93 * tunable->start) == OK &&
              unit_run(&a, &t, tick, 20) == OK && unit_keep(&a, &state) == OK,
          "a state under a force, with %s turned", tunable->name);
    s = t;
    claim(unit_run(&a, &t, tick, 20) == OK, "goes on");
    int n = unit_outputs(&a, first);
    claim(unit_put(&a, force, -2.0) == OK &&
              unit_set(&a, tunable->reference, tunable->start) == OK &&
              unit_run(&a, &t, tick, 5) == OK && unit_take(&a, state) == OK,
          "is left and taken again");
    claim(same(unit_value(&a, force), 0.37) &&
              same(unit_value(&a, tunable->name), 0.93 * tunable->start),
          "input and parameter are those of the state");
    t = s;
    claim(unit_run(&a, &t, tick, 20) == OK && unit_outputs(&a, again) == n &&
              memcmp(first, again, sizeof *first * (size_t)n) == 0,
          "and act");
    claim(unit_size(&a, state, &size) == OK && size <= sizeof bytes &&
              unit_pack(&a, state, bytes, size) == OK && unit_start(&b, f) == OK &&
              unit_unpack(&b, bytes, size, &copy) == OK && unit_take(&b, copy) == OK,
          "in another instance");
    t = s;
    claim(unit_run(&b, &t, tick, 20) == OK && unit_outputs(&b, again) == n &&
              memcmp(first, again, sizeof *first * (size_t)n) == 0,
          "too");
    unit_drop(&a, &state);
    unit_drop(&b, &copy);
    unit_free(&a);
    unit_free(&b);
}

/* ---- parameters while it runs ---- */

static void compare(unit *u, stein_sim *sim, const char *when)
{
    const stein_model *m = stein_sim_model(sim);
    for (int i = 0; i < m->nchannel; i++) {
        double value = unit_value(u, m->channels[i].name);
        claim(same(value, stein_read(sim, i)), "%s %s: %.17g, in C %.17g", m->channels[i].name,
              when, value, stein_read(sim, i));
    }
}

/* on the grid of the simulation's own steps, as `stein simulate` goes */
static stein_status go(stein_sim *sim, int steps)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < steps; i++) {
        status = stein_step(sim, NULL);
    }
    return status;
}

void check_parameters(const fmu *f)
{
    unit u;
    stein_sim *sim;
    double t = 0.0;
    if (f->model == NULL || stein_sim_create(&sim, f->model, NULL, NULL) != STEIN_OK) {
        return;
    }
    int ticks = (int)(tick / stein_dt(sim) + 0.5), changed = 0;
    claim(unit_start(&u, f) == OK && unit_run(&u, &t, tick, 30) == OK, "to 30 ms");
    claim(go(sim, 30 * ticks) == STEIN_OK, "in C");
    for (int i = 0; i < f->d.n; i++) {
        const variable *v = &f->d.v[i];
        if (strcmp(v->variability, "tunable") == 0) {
            int at = stein_find_param(f->model, v->name);
            double little = at >= 0 && f->model->params[at].range != STEIN_ANY ? 2e-4 : -2e-4;
            double value = v->start == 0.0 ? little : 0.97 * v->start;
            claim(unit_set(&u, v->reference, value) == OK &&
                      stein_set(sim, v->name, value, NULL) == STEIN_OK,
                  "%s while it runs: %s", v->name, u.said);
            changed++;
        }
    }
    claim(changed > 0, "%d parameters are tunable", changed);
    compare(&u, sim, "when they are turned");
    claim(unit_run(&u, &t, tick, 35) == OK && go(sim, 35 * ticks) == STEIN_OK, "on to 65 ms");
    compare(&u, sim, "after it");
    stein_sim_destroy(sim);
    unit_free(&u);

    // a fixed one before the start
    const char *name = f->model->params[f->model->np / 2].name;
    double value = 1.5 * f->model->params[f->model->np / 2].value;
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK && unit_put(&u, name, value) == OK &&
              unit_enter(&u, 0.0, -1.0) == OK && unit_exit(&u) == OK,
          "%s before the start", name);
    claim(stein_sim_create(&sim, f->model, NULL, NULL) == STEIN_OK &&
              stein_set(sim, name, value, NULL) == STEIN_OK && stein_reset(sim, NULL) == STEIN_OK,
          "and in C");
    t = 0.0;
    claim(unit_run(&u, &t, tick, 40) == OK && go(sim, 40 * ticks) == STEIN_OK, "to 40 ms");
    compare(&u, sim, "from other numbers");
    stein_sim_destroy(sim);
    unit_free(&u);
}

/* ---- inputs ---- */

typedef struct polynomial {
    double u[3], since;
} polynomial;

static void polynomial_signal(void *ctx, double t, double u[3])
{
    const polynomial *p = ctx;
    double x = t - p->since;
    u[0] = p->u[0] + x * (p->u[1] + 0.5 * x * p->u[2]);
    u[1] = p->u[1] + x * p->u[2];
    u[2] = p->u[2];
}

static void check_force(const fmu *f, const char *name, double size)
{
    unit u;
    stein_sim *sim;
    stein_sim_create(&sim, f->model, NULL, NULL);
    int ticks = (int)(tick / stein_dt(sim) + 0.5);
    double t = 0.0;
    polynomial force = {.u = {0.0}};
    claim(unit_start(&u, f) == OK &&
              stein_drive(sim, name, polynomial_signal, &force, NULL) == STEIN_OK,
          "force %s", name);
    const variable *v = description_find(&f->d, name);
    for (int i = 0; i < 40; i++) {
        force = (polynomial){{size * (i % 7) / 3.0, 0.0, 0.0}, t};
        claim(unit_put(&u, name, force.u[0]) == OK, "a force");
        if (f->version == 2 && i % 2 == 0) { // in between with slopes
            __typeof__(&fmi2SetRealInputDerivatives) slopes =
                (__typeof__(slopes))fmu_function(f, "fmi2SetRealInputDerivatives");
            int order[] = {1, 2};
            unsigned reference[] = {v->reference, v->reference};
            double slope[] = {20.0 * size, -3000.0 * size};
            claim(slopes(u.c, reference, 2, order, slope) == fmi2OK, "its slopes: %s", u.said);
            force.u[1] = slope[0];
            force.u[2] = slope[1];
        }
        force.since = stein_time(sim);
        stein_drive(sim, name, polynomial_signal, &force, NULL); // it has jumped
        claim(unit_run(&u, &t, tick, 1) == OK && go(sim, ticks) == STEIN_OK, "a step under it");
    }
    compare(&u, sim, "under a force");
    stein_sim_destroy(sim);
    unit_free(&u);
}

static void check_motion(const fmu *f, const char *name, double size)
{
    unit u;
    char part[64];
    stein_sim *sim;
    stein_sim_create(&sim, f->model, NULL, NULL);
    int ticks = (int)(tick / stein_dt(sim) + 0.5);
    double t = 0.0;
    snprintf(part, sizeof part, "%s.position", name);
    double q = description_find(&f->d, part)->start;
    polynomial motion = {{q, 0.0, 0.0}, 0.0};
    claim(stein_drive(sim, name, polynomial_signal, &motion, NULL) == STEIN_OK &&
              stein_reset(sim, NULL) == STEIN_OK,
          "motion %s in C", name);
    snprintf(part, sizeof part, "%s.follow", name);
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK && unit_put(&u, part, 1.0) == OK &&
              unit_enter(&u, 0.0, -1.0) == OK && unit_exit(&u) == OK,
          "motion %s: %s", name, u.said);
    for (int i = 0; i < 40; i++) {
        // a quarter of a swing, in parabolas that fit on to each other
        double acceleration = (i < 20 ? 1.0 : -1.0) * size, x = stein_time(sim) - motion.since;
        motion = (polynomial){{motion.u[0] + x * (motion.u[1] + 0.5 * x * motion.u[2]),
                               motion.u[1] + x * motion.u[2], acceleration},
                              stein_time(sim)};
        stein_drive(sim, name, polynomial_signal, &motion, NULL);
        static const char *const parts[] = {"position", "speed", "acceleration"};
        for (int k = 0; k < 3; k++) {
            snprintf(part, sizeof part, "%s.%s", name, parts[k]);
            claim(unit_put(&u, part, motion.u[k]) == OK, "%s: %s", part, u.said);
        }
        claim(unit_run(&u, &t, tick, 1) == OK && go(sim, ticks) == STEIN_OK, "a step: %s", u.said);
    }
    compare(&u, sim, "on a given motion");
    stein_sim_destroy(sim);
    unit_free(&u);
}

/* the load is lifted at 70 ms and put back at 110 ms, or is never there */
static void check_load(const fmu *f)
{
    unit u;
    stein_sim *sim;
    char name[64];
    snprintf(name, sizeof name, "%s.present", f->model->bodies[f->model->load.body].name);
    stein_sim_create(&sim, f->model, NULL, NULL);
    int ticks = (int)(tick / stein_dt(sim) + 0.5);
    double t = 0.0;
    claim(unit_start(&u, f) == OK && unit_value_flag(&u, name) == 1, "the load is there");
    for (int part = 0; part < 3; part++) {
        claim(unit_run(&u, &t, tick, 40 + 30 * (part == 0)) == OK &&
                  go(sim, (40 + 30 * (part == 0)) * ticks) == STEIN_OK,
              "part %d", part);
        compare(&u, sim, "with and without the load");
        claim(unit_put(&u, name, part % 2) == OK, "%s: %s", name, u.said);
        if (part % 2) {
            stein_load_place(sim, NULL);
        } else {
            stein_load_lift(sim);
        }
        compare(&u, sim, "when the load comes or goes");
    }
    unit_free(&u);
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK && unit_put(&u, name, 0.0) == OK &&
              unit_enter(&u, 0.0, -1.0) == OK && unit_exit(&u) == OK,
          "no load: %s", u.said);
    stein_reset(sim, NULL);
    stein_load_lift(sim);
    t = 0.0;
    claim(unit_run(&u, &t, tick, 40) == OK && go(sim, 40 * ticks) == STEIN_OK, "a rest");
    compare(&u, sim, "without a load");
    stein_sim_destroy(sim);
    unit_free(&u);
}

void check_inputs(const fmu *f)
{
    if (f->model != NULL && f->model->load.body >= 0) {
        check_load(f);
    }
    for (int i = 0; f->model != NULL && i < f->model->ninput; i++) {
        const stein_input *in = &f->model->inputs[i];
        if (in->kind == STEIN_INPUT_MOTION) {
            check_motion(f, in->name, 30.0);
        } else {
            check_force(f, in->name, in->kind == STEIN_INPUT_POINT ? 2.0 : 0.1);
        }
    }
}

/* ---- steps that fail ---- */

void check_discard(const fmu *f)
{
    unit a, b;
    double t = 0.0, s = 0.0, reached;
    void *state = NULL;
    const char *force = force_of(f);
    if (force == NULL) {
        return;
    }
    claim(unit_start(&a, f) == OK && unit_start(&b, f) == OK, "two instances");
    claim(unit_run(&a, &t, tick, 20) == OK && unit_run(&b, &s, tick, 20) == OK, "to 20 ms");
    claim(unit_put(&a, force, 0.0) == OK && unit_keep(&a, &state) == OK, "a state");
    // where there are contacts one that lets 38 steps of the integrator succeed before it
    claim(unit_put(&a, force, f->model->ncontact > 0 ? 1e5 : 1.7e308) == OK,
          "a force without measure");
    claim(unit_step(&a, t, tick, &reached) == DISCARD, "its step is discarded");
    claim(a.status == DISCARD && strcmp(a.category, "logStatusDiscard") == 0 &&
              strstr(a.said, f->model->ncontact > 0 ? "too stiff for steps of" : "finite") != NULL,
          "and says why: \"%s\" (%s)", a.said, a.category);
    claim(fabs(unit_value(&a, "time") - 0.02) < 1e-15 && fabs(reached - 0.02) < 1e-15,
          "the time is as before");
    if (f->version == 2) {
        claim(unit_step(&a, t, tick, &reached) == FAILED &&
                  strstr(a.said, "after a step that was discarded") != NULL,
              "FMI 2 waits for a state: %s", a.said);
        claim(unit_take(&a, state) == OK, "which it gets");
    } else {
        claim(unit_put(&a, force, 0.0) == OK, "without the force");
    }
    claim(equal_outputs(&a, &b), "nothing else has changed");
    claim(unit_run(&a, &t, tick, 20) == OK && unit_run(&b, &s, tick, 20) == OK &&
              equal_outputs(&a, &b),
          "it goes on as if nothing had been");
    claim(unit_drop(&a, &state) == OK, "the state is freed");
    unit_free(&a);
    unit_free(&b);

    // events are logged on request
    claim(unit_start(&a, f) == OK && unit_log(&a, 1, 1, (const char *[]){"logEvents"}) == OK,
          "events");
    t = 0.0;
    claim(unit_run(&a, &t, tick, 90) == OK, "a run");
    claim((a.events > 0) == (f->model->ncontact > 0), "%d events were told", a.events);
    int told = a.events;
    claim(unit_log(&a, 0, 0, NULL) == OK && unit_run(&a, &t, tick, 90) == OK && a.events == told,
          "and no more when they are not");
    unit_free(&a);
}

/* ---- memory that ends ---- */

void check_memory(const fmu *f)
{
    unit u;
    int status = NO_INSTANCE, n = 0;
    void *state = NULL;
    while (allocations() >= 0 && status != OK && n < 100) {
        fail_allocation(++n);
        status = unit_new(&u, f, "one", f->d.token, 1);
        fail_allocation(0);
        claim(status == OK || n == 1 || strstr(u.said, "out of memory") != NULL,
              "an instance without memory (%d): \"%s\"", n, u.said);
    }
    if (status == OK) {
        claim(n > 5, "%d allocations have failed", n - 1);
        fail_allocation(1);
        claim(unit_keep(&u, &state) == FAILED && state == NULL &&
                  strstr(u.said, "out of memory for a state") != NULL,
              "a state without memory: \"%s\"", u.said);
        fail_allocation(0);
        claim(unit_reset(&u) == OK && unit_keep(&u, &state) == OK, "and then with it");
        unit_drop(&u, &state);
        unit_free(&u);
    }
}

/* ---- threads ---- */

typedef struct runner {
    const fmu *f;
    double factor, y[OUTPUTS];
    int n, status;
} runner;

static void *run_one(void *ctx)
{
    runner *r = ctx;
    unit u;
    double t = 0.0;
    r->status = unit_new(&u, r->f, "thread", r->f->d.token, 1);
    for (int i = 0; r->status == OK && i < r->f->d.n; i++) {
        const variable *v = &r->f->d.v[i];
        if (strcmp(v->variability, "tunable") == 0) {
            r->status = unit_set(&u, v->reference, r->factor * v->start);
        }
    }
    r->status = r->status == OK ? unit_enter(&u, 0.0, -1.0) : r->status;
    r->status = r->status == OK ? unit_exit(&u) : r->status;
    r->status = r->status == OK ? unit_run(&u, &t, tick, 80) : r->status;
    r->n = unit_outputs(&u, r->y);
    unit_free(&u);
    return NULL;
}

void check_threads(const fmu *f)
{
    runner alone[2] = {{.f = f, .factor = 0.98}, {.f = f, .factor = 1.01}};
    runner side[2] = {alone[0], alone[1]};
    pthread_t thread[2];
    for (int i = 0; i < 2; i++) {
        run_one(&alone[i]);
    }
    for (int i = 0; i < 2; i++) {
        claim(pthread_create(&thread[i], NULL, run_one, &side[i]) == 0, "a thread");
    }
    for (int i = 0; i < 2; i++) {
        pthread_join(thread[i], NULL);
        claim(alone[i].status == OK && side[i].status == OK && alone[i].n == side[i].n &&
                  memcmp(alone[i].y, side[i].y, sizeof *alone[i].y * (size_t)alone[i].n) == 0,
              "side by side as alone");
    }
    claim(f->d.n == 0 || f->model == NULL || f->model->ninput == 0 || f->model->inputs[0].hold ||
              memcmp(alone[0].y, alone[1].y, sizeof *alone[0].y * (size_t)alone[0].n) != 0,
          "and they are different ones");
}
