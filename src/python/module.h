/* SPDX-License-Identifier: GPL-3.0-or-later
 * module.h - stein._stein: libstein for Python, in the limited API, so that one build serves every
 * CPython from 3.11 on.
 *
 *      stein/__init__.py    load, Simulation, fit, diagnose ...        what people use
 *           |  names, units, texts
 *      simulation*.c        Simulation (stein_sim)
 *      model.c              Model (lab_model), Record (lab_record)
 *      support.c            exceptions, Control-C, progress, Block (numbers in the buffer protocol)
 *      steinmodule.c        the module; sweep, fit, diagnose, plan
 *           |
 *      libsteinlab, libstein
 *
 * Numbers are not copied: a Block shows memory of the library, which numpy reads, and keeps alive
 * what the memory belongs to. While something is computed the interpreter's lock is free; a lock
 * for each simulation allows one thread at a time. A Model never changes, so it needs none. Long
 * work checks twenty times a second whether Control-C was pressed (py__ask).
 * Included by: this folder.
 */
#ifndef MODULE_H
#define MODULE_H

#define Py_LIMITED_API 0x030b0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "stein/plan.h"
#include "stein/stein.h"

/** What the types of one module have in common. */
typedef struct py__state {
    PyTypeObject *model, *simulation, *block, *record;
    PyObject *failure, *unknown, *view, *event; /* functions of stein._support */
} py__state;

/* ---- support.c ---- */

/** Raise what stein._support makes of a failure. @param problems  texts, or NULL  @return NULL */
PyObject *py__fail(const py__state *st, stein_status status, const char *message,
                   PyObject *problems);
/** Raise UnknownName. @param known  names as the keys of a dict, which is taken
 *  over; NULL: an exception is set  @return NULL */
PyObject *py__fail_name(const py__state *st, const char *what, const char *name, PyObject *known);
PyObject *py__text_of(const char *text);

/** Texts for the library. */
typedef struct py__texts {
    char **at; /* [n], NULL where the list has None */
    int n;
} py__texts;
/** For PyArg_Parse ("O&"): a sequence of str or None. */
int py__to_texts(PyObject *list, void *texts);
void py__free_texts(py__texts *t);
const char *const *py__names_of(const py__texts *t);

/** Long work. */
typedef struct py__call {
    const py__state *st;
    PyObject *progress; /* called with (fraction, step); NULL: nobody */
    PyObject *problems; /* texts that were reported */
    const char *what;
    unsigned long thread; /* that called: Python's signals are looked at there alone */
    double asked, shown;  /* [s] */
    double fraction;      /* that was told last */
    int stopped;          /* 1: an exception is set in that thread */
} py__call;
/** @param progress  a function or None  @return 0 with an exception */
int py__begin_call(py__call *c, const py__state *st, PyObject *progress, const char *what);
/** @return 1, or 0 with an exception: the library's, a callback's, or Control-C */
int py__end_call(py__call *c, stein_status status, const stein_err *err);
/** For the library, with the call as ctx: lab_stop_fn, lab_fit_progress_fn, lab_progress_fn,
 *  lab_read_progress_fn, lab_report_fn. */
int py__ask(void *ctx);
void py__on_progress(void *ctx, double fraction, const char *step);
void py__on_count(void *ctx, int done, int total);
void py__on_read(void *ctx, double fraction);
void py__on_report(void *ctx, const char *message);

/** Numbers in a row or a table. */
typedef struct py__block {
    PyObject_HEAD PyObject *base; /* that the memory belongs to; NULL: it is the block's own */
    double *data;
    int ndim;
    Py_ssize_t shape[2], strides[2];
} py__block;
/** n rows of m numbers, all 0; m < 0: one row of n. */
py__block *py__new_block(const py__state *st, Py_ssize_t n, Py_ssize_t m);
/** What a person gets for a block, which is taken over: an array of numpy or a memoryview. */
PyObject *py__shown(const py__state *st, py__block *b);
PyObject *py__row_of(const py__state *st, const double *x, int n);

/** Any of these objects as Python has it; the begin and the end of one. */
PyObject *py__object(const void *x);
void *py__allocate(PyTypeObject *type);
void py__release(void *self);

/* ---- model.c ---- */

/** A mechanism file with overrides, its equations. */
typedef struct py__model {
    PyObject_HEAD PyObject *module; /* whose state is below */
    const py__state *st;
    lab_model *lab;
    PyObject *file; /* bytes, as the system names it */
    py__texts set;  /* "NAME=VALUE" */
} py__model;
/** Samples of all outputs. */
typedef struct py__record {
    PyObject_HEAD py__model *model;
    lab_record *lab;
} py__record;

extern PyType_Spec py__model_spec, py__record_spec, py__block_spec, py__simulation_spec;
/** open(file, sets): a Model. */
PyObject *py__open(PyObject *module, PyObject *args);
const stein_model *py__equations(const py__model *m);
const char *py__file(const py__model *m);
/** Those that it was opened with; problems go to the call. */
lab_options py__options_of(const py__model *m, py__call *c);
/** Names of n things as the keys of a dict, with a text of each. Name and text i are `stride` bytes
 *  behind name and text i - 1. */
PyObject *py__dict_of(int n, const char *const *name, const char *const *text, size_t stride);
/** Outputs and inputs with their units. */
PyObject *py__outputs(const stein_model *e);
PyObject *py__inputs(const stein_model *e);

/* ---- simulation.c ---- */

/** start(class, model, dt, integrator): a simulation in its initial state; the class is a
 *  Simulation. dt nan, integrator -1: those of the file. */
PyObject *py__start(PyObject *module, PyObject *args);

#endif
