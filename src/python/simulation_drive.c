/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_drive.c - what drives a simulation: numbers, functions, data files; forces of one's
 * own.
 *
 * A function of Python is called at every evaluation, several times a step. One that raises makes
 * the step fail, by numbers that are none; its exception is raised when the simulation is left.
 */
#include "simulation.h"

/* ---- inputs ---- */

static void held(void *ctx, double t, double u[3])
{
    const py__drive *d = ctx;
    (void)t;
    memcpy(u, d->u, sizeof d->u);
}

/* a number, or up to three: value, rate, acceleration. @return 0 with an exception */
static int read_drive(PyObject *given, double u[3])
{
    Py_ssize_t n = PyNumber_Check(given) && !PySequence_Check(given) ? 0 : PySequence_Size(given);
    u[0] = u[1] = u[2] = 0.0;
    if (PyUnicode_Check(given)) {
        PyErr_SetString(PyExc_TypeError, "a signal is a number or a function, not a text");
        return 0;
    }
    if (n == 0) {
        u[0] = PyFloat_AsDouble(given);
        return !PyErr_Occurred();
    }
    if (n > 3) {
        PyErr_Format(PyExc_ValueError, "a signal has a value and two derivatives, not %zd numbers",
                     n);
    }
    return n > 0 && n <= 3 && py__read_numbers(given, u, (int)n, "a signal");
}

static void asked(void *ctx, double t, double u[3])
{
    py__drive *d = ctx;
    u[0] = u[1] = u[2] = NAN;
    if (d->of->failed) {
        return;
    }
    PyGILState_STATE gil = PyGILState_Ensure();
    PyObject *value = PyObject_CallFunction(d->function, "d", t);
    if (value == NULL || !read_drive(value, u)) {
        d->of->failed = 1;
        u[0] = NAN; // which ends the step; the exception waits until then
    }
    Py_XDECREF(value);
    PyGILState_Release(gil);
}

/* drive(input, signal): a number, up to three of them, a function of the time, or None */
PyObject *py__drive_input(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const char *name;
    PyObject *given;
    py__drive d = {.of = s};
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "sO", &name, &given)) {
        return NULL;
    }
    const stein_model *e = py__equations(s->model);
    int i = stein_find_input(e, name), function = PyCallable_Check(given);
    if (i < 0) {
        return py__fail_name(s->model->st, "input", name, py__inputs(e));
    }
    if (given != Py_None && !function && !read_drive(given, d.u)) {
        return NULL;
    }
    if (!py__enter(s)) {
        return NULL;
    }
    stein_signal_fn *fn = given == Py_None ? NULL : function ? asked : held;
    stein_status status = stein_drive(s->sim, name, fn, &s->input[i], &err);
    if (status == STEIN_OK) {
        // what was bound before may go only now
        d.function = function ? Py_NewRef(given) : NULL;
        PyObject *old = s->input[i].function;
        s->input[i] = d;
        Py_XDECREF(old);
    }
    return py__none_after(s, status, &err);
}

/* drive_file(path): every column that is named like an input drives it */
PyObject *py__drive_file(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    PyObject *path = NULL;
    lab_drive *file = NULL;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O&", PyUnicode_FSConverter, &path) || !py__enter(s)) {
        Py_XDECREF(path);
        return NULL;
    }
    stein_status status =
        lab_drive_open(&file, PyBytes_AsString(path), py__equations(s->model), &err);
    if (status == STEIN_OK) {
        status = lab_drive_bind(file, s->sim, &err);
        lab_drive_close(s->file);
        s->file = file;
    }
    Py_DECREF(path);
    return py__none_after(s, status, &err);
}

/* ---- forces ---- */

/* a stein_force_fn: what the function gives for t, q, qd is added */
static void push(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    py__simulation *s = ctx;
    int nq = py__equations(s->model)->nq;
    if (s->failed) {
        Q[0] = NAN;
        return;
    }
    PyGILState_STATE gil = PyGILState_Ensure();
    PyObject *at = py__row_of(s->model->st, q, nq), *rate = py__row_of(s->model->st, qd, nq);
    PyObject *given =
        at != NULL && rate != NULL ? PyObject_CallFunction(s->force, "dOO", t, at, rate) : NULL;
    double *more = given != NULL ? calloc((size_t)nq, sizeof *more) : NULL;
    if (more != NULL && py__read_numbers(given, more, nq, "forces")) {
        for (int i = 0; i < nq; i++) {
            Q[i] += more[i];
        }
    } else {
        s->failed = 1;
        Q[0] = NAN; // which ends the step; the exception waits until then
        if (!PyErr_Occurred()) {
            PyErr_NoMemory();
        }
    }
    free(more);
    Py_XDECREF(given);
    Py_XDECREF(at);
    Py_XDECREF(rate);
    PyGILState_Release(gil);
}

/* on_force(function or None) */
PyObject *py__on_force(PyObject *self, PyObject *function)
{
    py__simulation *s = (py__simulation *)self;
    if (function != Py_None && !PyCallable_Check(function)) {
        PyErr_SetString(PyExc_TypeError, "expected a function of t, q, qd or None");
        return NULL;
    }
    if (!py__enter(s)) {
        return NULL;
    }
    PyObject *old = s->force;
    s->force = function != Py_None ? Py_NewRef(function) : NULL;
    stein_on_force(s->sim, s->force != NULL ? push : NULL, s);
    py__leave(s);
    Py_XDECREF(old);
    return Py_NewRef(Py_None);
}
