/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation.h - what the files of the type Simulation share.
 * Included by: this folder.
 */
#ifndef SIMULATION_H
#define SIMULATION_H

#include "module.h"

enum { PY_STEPS = 64 }; /* between two looks at the clock */

typedef struct py__simulation py__simulation;

/** What drives an input: a function of the time, or a number with two derivatives. */
typedef struct py__drive {
    py__simulation *of;
    PyObject *function;
    double u[3];
} py__drive;

struct py__simulation {
    PyObject_HEAD py__model *model;
    stein_sim *sim;
    PyThread_type_lock lock;
    unsigned long owner; /* thread that has the lock; 0: nobody */
    py__drive *input;    /* [ninput] */
    lab_drive *file;     /* signals of a data file; NULL: none */
    PyObject *force;     /* function that gives generalised forces; NULL: none */
    stein_event *event;  /* [nevent] of the last step or run */
    int nevent, room;
    int lost;   /* an event found no memory */
    int failed; /* a function has raised; the exception waits */
};

/** The simulation's lock, without the interpreter's while another thread has it.
 *  @return 0 with an exception */
int py__enter(py__simulation *s);
void py__leave(py__simulation *s);
/** Leave, and raise what failed: a function that was called, or the library. @return 1; 0 */
int py__leave_with(py__simulation *s, stein_status status, const stein_err *err);
/** The same. @return None, or NULL */
PyObject *py__none_after(py__simulation *s, stein_status status, const stein_err *err);

/** A stein_event_fn with the simulation as ctx, and what it has collected. */
void py__on_event(void *ctx, stein_sim *sim, const stein_event *event);
void py__forget_events(py__simulation *s);
PyObject *py__events(const py__simulation *s);

/** n numbers of a sequence. @return 0 with an exception */
int py__read_numbers(PyObject *from, double *to, int n, const char *what);
/** Positions, speeds, accelerations: three rows of nq numbers. One that is None or missing is the
 *  simulation's own, which the caller has entered, or 0. @return the memory, NULL with an exception
 */
double *py__read_state(py__simulation *s, PyObject *const given[3]);

/* methods */
PyObject *py__run(PyObject *self, PyObject *args);
PyObject *py__lift(PyObject *self, PyObject *none);
PyObject *py__drive_input(PyObject *self, PyObject *args);
PyObject *py__drive_file(PyObject *self, PyObject *args);
PyObject *py__on_force(PyObject *self, PyObject *function);
PyObject *py__mass_bias(PyObject *self, PyObject *args);
PyObject *py__inverse(PyObject *self, PyObject *args);
PyObject *py__acceleration(PyObject *self, PyObject *args);
PyObject *py__point(PyObject *self, PyObject *args);
PyObject *py__derivatives(PyObject *self, PyObject *args);
PyObject *py__linearise(PyObject *self, PyObject *none);

#endif
