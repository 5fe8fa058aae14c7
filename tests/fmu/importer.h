/* SPDX-License-Identifier: GPL-3.0-or-later
 * importer.h - a small importer of FMUs, for their tests: both versions behind one face.
 *
 *   load.c          dlopen and the two standards   checks.c   what an importer may do wrong
 *   description.c   modelDescription.xml           runs.c     numbers: states, threads, inputs
 *   main.c          which FMU is tested            slopes.c   derivatives
 *   box.c           steps without system calls
 */
#ifndef IMPORTER_H
#define IMPORTER_H

#include <stddef.h>

#include "fmi2.h"
#include "fmi3.h"
#include "stein/stein.h"

/* ---- description.c ---- */

typedef struct variable {
    char name[128], causality[16], variability[16];
    unsigned reference;
    int boolean, has_start;
    double start;
} variable;

typedef struct description {
    char token[64], identifier[64];
    variable *v;
    int n;
} description;

/** @return 0 after a message */
int description_read(description *d, const char *file);
const variable *description_find(const description *d, const char *name);

/* ---- load.c ---- */

typedef struct fmu {
    int version;
    void *library;
    description d;
    const stein_model *model; /* the same mechanism in libstein.a, or NULL */
} fmu;

/** The functions of a standard that this importer needs, by name; fails the test without
 *  it. */
void (*fmu_function(const fmu *f, const char *name))(void);
int fmu_open(fmu *f, int version, const char *library, const char *file);

/* statuses of both versions */
enum { OK = 0, DISCARD = 2, FAILED = 3, NO_INSTANCE = 4 };

/** An instance and its messages. */
typedef struct unit {
    const fmu *f;
    void *c;
    int messages, events;
    char said[512], category[32]; /* the last one */
    int status;                   /* that came with it */
    int starting;                 /* for slopes.c: in Initialization Mode */
} unit;

int unit_new(unit *u, const fmu *f, const char *name, const char *token, int logs);
void unit_free(unit *u);
int unit_log(unit *u, int on, size_t n, const char *const *categories);
/** stop < start: none */
int unit_enter(unit *u, double start, double stop);
int unit_exit(unit *u);
int unit_terminate(unit *u);
int unit_reset(unit *u);
int unit_get(unit *u, unsigned reference, double *value);
int unit_set(unit *u, unsigned reference, double value);
int unit_get_flag(unit *u, unsigned reference, int *value);
int unit_set_flag(unit *u, unsigned reference, int value);
int unit_step(unit *u, double at, double h, double *reached);
int unit_keep(unit *u, void **state);
int unit_take(unit *u, void *state);
int unit_drop(unit *u, void **state);
int unit_size(unit *u, void *state, size_t *size);
int unit_pack(unit *u, void *state, unsigned char *bytes, size_t size);
int unit_unpack(unit *u, const unsigned char *bytes, size_t size, void **state);
int unit_slope(unit *u, unsigned unknown, unsigned known, double seed, double *slope);
/** From new to between two steps, with the values of the file. */
int unit_start(unit *u, const fmu *f);
/** By name; the variable has to be there. */
double unit_value(unit *u, const char *name);
int unit_value_flag(unit *u, const char *name);
int unit_put(unit *u, const char *name, double value);
/** Steps of h from `at` on; at is where they end. */
int unit_run(unit *u, double *at, double h, int steps);
/** All outputs, in the order of the description. @return their number */
int unit_outputs(unit *u, double *y);
enum { OUTPUTS = 64 };

/* ---- main.c ---- */

/** Count a claim; tell when it fails. */
void claim(int holds, const char *format, ...);
int same(double a, double b);
/** Allocations that the program has made so far; -1: not counted. */
long allocations(void);
/** Let the n-th allocation from here on fail; 0: none. */
void fail_allocation(long n);

void check_refusals(const fmu *f);
void check_rest(const fmu *f);
void check_starts(const fmu *f);
void check_record(const fmu *f, const char *csv);
void check_states(const fmu *f);
void check_steps(const fmu *f);
void check_threads(const fmu *f);
void check_parameters(const fmu *f);
void check_inputs(const fmu *f);
void check_discard(const fmu *f);
void check_memory(const fmu *f);
void check_box(const fmu *f);
void check_slopes(const fmu *f);
void check_exchange(const fmu *f);

#endif
