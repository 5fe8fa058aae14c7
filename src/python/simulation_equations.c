/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_equations.c - what the equations give at a state: M, c, Q, qdd, points.
 */
#include "simulation.h"

/* ---- numbers from a person ---- */

int py__read_numbers(PyObject *from, double *to, int n, const char *what)
{
    Py_ssize_t size = PySequence_Size(from);
    if (size != n) {
        if (size >= 0) {
            PyErr_Format(PyExc_ValueError, "%s: expected %d numbers, not %zd", what, n, size);
        }
        return 0;
    }
    for (int i = 0; i < n; i++) {
        PyObject *item = PySequence_GetItem(from, i);
        to[i] = item != NULL ? PyFloat_AsDouble(item) : NAN;
        Py_XDECREF(item);
        if (PyErr_Occurred()) {
            return 0;
        }
    }
    return 1;
}

double *py__read_state(py__simulation *s, PyObject *const given[3])
{
    int nq = py__equations(s->model)->nq;
    const char *const what[3] = {"q", "qd", "qdd"};
    double *x = calloc(3 * (size_t)nq + 1, sizeof *x);
    if (x == NULL) {
        PyErr_NoMemory();
        return NULL;
    }
    for (int k = 0; k < 3; k++) {
        const double *own = k == 0 ? stein_q(s->sim) : k == 1 ? stein_qd(s->sim) : NULL;
        if (given[k] != NULL && given[k] != Py_None) {
            if (!py__read_numbers(given[k], x + k * nq, nq, what[k])) {
                free(x);
                return NULL;
            }
        } else if (own != NULL) {
            memcpy(x + k * nq, own, sizeof *x * (size_t)nq);
        }
    }
    return x;
}

/* ---- equations ---- */

/* (M, c) at q, qd */
PyObject *py__mass_bias(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    int nq = py__equations(s->model)->nq;
    PyObject *given[3] = {NULL, NULL, NULL};
    if (!PyArg_ParseTuple(args, "OO", &given[0], &given[1])) {
        return NULL;
    }
    py__block *M = py__new_block(s->model->st, nq, nq), *c = py__new_block(s->model->st, nq, -1);
    if (M == NULL || c == NULL || !py__enter(s)) {
        Py_XDECREF(py__object(M));
        Py_XDECREF(py__object(c));
        return NULL;
    }
    double *x = py__read_state(s, given);
    if (x != NULL) {
        stein_mass_bias(s->sim, x, x + nq, NULL, NULL, M->data, c->data);
    }
    free(x);
    py__leave(s);
    if (x == NULL) {
        Py_DECREF(py__object(M));
        Py_DECREF(py__object(c));
        return NULL;
    }
    PyObject *both = PyTuple_New(2), *first = py__shown(s->model->st, M),
             *second = py__shown(s->model->st, c);
    if (both == NULL || first == NULL || second == NULL) {
        Py_XDECREF(both);
        Py_XDECREF(first);
        Py_XDECREF(second);
        return NULL;
    }
    (void)PyTuple_SetItem(both, 0, first);
    (void)PyTuple_SetItem(both, 1, second);
    return both;
}

/* inverse(q, qd, qdd): Q = M qdd + c; acceleration(q, qd): qdd with all contacts and laws */
static PyObject *dynamics(PyObject *self, PyObject *args, int inverse)
{
    py__simulation *s = (py__simulation *)self;
    int nq = py__equations(s->model)->nq;
    PyObject *given[3] = {NULL, NULL, NULL};
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (!PyArg_ParseTuple(args, inverse ? "OOO" : "OO", &given[0], &given[1], &given[2])) {
        return NULL;
    }
    py__block *b = py__new_block(s->model->st, nq, -1);
    if (b == NULL || !py__enter(s)) {
        Py_XDECREF(py__object(b));
        return NULL;
    }
    double *x = py__read_state(s, given);
    if (x != NULL && inverse) {
        stein_inverse(s->sim, x, x + nq, x + 2 * nq, NULL, NULL, b->data);
    } else if (x != NULL) {
        status = stein_acceleration(s->sim, stein_time(s->sim), x, x + nq, b->data, &err);
    }
    free(x);
    if (!py__leave_with(s, status, &err)) {
        Py_DECREF(py__object(b));
        return NULL;
    }
    return py__shown(s->model->st, b);
}

PyObject *py__inverse(PyObject *self, PyObject *args)
{
    return dynamics(self, args, 1);
}

PyObject *py__acceleration(PyObject *self, PyObject *args)
{
    return dynamics(self, args, 0);
}

static int find_point(const stein_model *m, const char *name)
{
    int i = m->npoint - 1;
    while (i >= 0 && strcmp(m->points[i].name, name) != 0) {
        i--;
    }
    return i;
}

/* point(name, q, qd): (x, v, J) of it, components in the fixed frame */
PyObject *py__point(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *m = py__equations(s->model);
    const py__state *st = s->model->st;
    const char *name;
    PyObject *given[3] = {NULL, NULL, NULL};
    if (!PyArg_ParseTuple(args, "sOO", &name, &given[0], &given[1])) {
        return NULL;
    }
    int i = find_point(m, name);
    if (i < 0) {
        static const stein_point none = {.name = ""};
        const stein_point *p = m->npoint > 0 ? m->points : &none;
        return py__fail_name(st, "point", name,
                             py__dict_of(m->npoint, &p->name, &p->name, sizeof *p));
    }
    size_t n = 3 * (size_t)m->npoint, nq = (size_t)m->nq;
    double *at = calloc(n * (2 + nq) + 1, sizeof *at);
    py__block *J = py__new_block(st, 3, m->nq);
    double *x = NULL;
    if (at == NULL) {
        PyErr_NoMemory();
    } else if (J != NULL && py__enter(s)) {
        x = py__read_state(s, given);
        if (x != NULL) {
            stein_points(s->sim, x, x + nq, at, at + n, at + 2 * n, NULL);
        }
        py__leave(s);
    }
    PyObject *result = NULL;
    if (x != NULL) {
        memcpy(J->data, at + 2 * n + 3 * (size_t)i * nq, sizeof *at * 3 * nq);
        PyObject *where = py__row_of(st, at + 3 * i, 3), *speed = py__row_of(st, at + n + 3 * i, 3);
        PyObject *by_q = py__shown(st, (py__block *)Py_NewRef(py__object(J)));
        result = where != NULL && speed != NULL && by_q != NULL
                     ? PyTuple_Pack(3, where, speed, by_q)
                     : NULL;
        Py_XDECREF(where);
        Py_XDECREF(speed);
        Py_XDECREF(by_q);
    }
    Py_XDECREF(py__object(J));
    free(x);
    free(at);
    return result;
}

/* ---- derivatives ---- */

/* qdd by parameters, as a list; the place is set */
static PyObject *by_parameters(const py__simulation *s, stein_derivative *at, const py__texts *name)
{
    const stein_model *m = py__equations(s->model);
    PyObject *list = PyList_New(name->n);
    for (int i = 0; list != NULL && i < name->n; i++) {
        py__block *b = py__new_block(s->model->st, m->nq, -1);
        if (b != NULL) {
            stein_derivative_by_parameter(at, stein_find_param(m, name->at[i]), b->data);
        }
        PyObject *row = py__shown(s->model->st, b);
        if (row == NULL || PyList_SetItem(list, i, row) != 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

/* (qdd by q, by qd, [by each parameter]) at the present state; the place is set */
static PyObject *derivatives_at(const py__simulation *s, stein_derivative *at,
                                const py__texts *name)
{
    const py__state *st = s->model->st;
    int nq = py__equations(s->model)->nq;
    py__block *q = py__new_block(st, nq, nq), *qd = py__new_block(st, nq, nq);
    if (q != NULL && qd != NULL) {
        stein_derivative_by_state(at, q->data, qd->data);
    }
    PyObject *by_q = py__shown(st, q), *by_qd = py__shown(st, qd), *all = NULL;
    PyObject *by_p = by_q != NULL && by_qd != NULL ? by_parameters(s, at, name) : NULL;
    if (by_p != NULL) {
        all = PyTuple_Pack(3, by_q, by_qd, by_p);
    }
    Py_XDECREF(by_q);
    Py_XDECREF(by_qd);
    Py_XDECREF(by_p);
    return all;
}

PyObject *py__derivatives(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *m = py__equations(s->model);
    PyObject *const present[3] = {NULL, NULL, NULL}, *all = NULL;
    py__texts name = {NULL, 0};
    stein_derivative *at = NULL;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O&", py__to_texts, &name)) {
        return NULL;
    }
    stein_status status = stein_derivative_create(&at, m, NULL, &err);
    if (status != STEIN_OK) {
        py__fail(s->model->st, status, err.msg, NULL);
    } else if (py__enter(s)) {
        double *x = py__read_state(s, present);
        if (x != NULL) {
            status = stein_derivative_at(at, s->sim, stein_time(s->sim), x, x + m->nq, NULL, &err);
            all = status == STEIN_OK ? derivatives_at(s, at, &name) : NULL;
        }
        free(x);
        if (!py__leave_with(s, status, &err)) {
            Py_CLEAR(all);
        }
    }
    stein_derivative_destroy(at);
    py__free_texts(&name);
    return all;
}
