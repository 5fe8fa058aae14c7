/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_linear.c - a mechanism linearised about the present state of a simulation.
 */
#include "simulation.h"

/* what is built, one after the other; a failure ends with an exception */
typedef struct linear {
    const py__simulation *of;
    const stein_model *model;
    const stein_linear_system *system;
    const lab_modes *modes;
} linear;

/* into the dict, which may be NULL, the value is taken over. @return is it there? */
static int put(PyObject *dict, const char *key, PyObject *value)
{
    int failed = dict == NULL || value == NULL || PyDict_SetItemString(dict, key, value) != 0;
    Py_XDECREF(value);
    return !failed;
}

static PyObject *matrix(const linear *l, const double *x, int rows, int columns)
{
    py__block *b = py__new_block(l->of->model->st, rows, columns);
    if (b != NULL) {
        memcpy(b->data, x, sizeof *x * (size_t)rows * (size_t)columns);
    }
    return py__shown(l->of->model->st, b);
}

/* a list of n things, each made by item(); NULL with an exception */
static PyObject *list_of(const linear *l, int n, PyObject *item(const linear *l, int i))
{
    PyObject *list = PyList_New(n);
    for (int i = 0; list != NULL && i < n; i++) {
        PyObject *one = item(l, i);
        if (one == NULL || PyList_SetItem(list, i, one) != 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

static PyObject *joint(const linear *l, int i)
{
    return py__text_of(l->model->bodies[l->system->joint[i]].name);
}

static PyObject *input(const linear *l, int i)
{
    return Py_BuildValue("ss", l->model->inputs[l->system->input[i]].name,
                         lab_linear_input_unit(l->model, l->system, i));
}

static PyObject *state(const linear *l, int i)
{
    int n = l->system->n;
    const char *name = l->model->bodies[l->system->joint[i % n]].name;
    PyObject *text = PyUnicode_FromFormat("%s.%s", i < n ? "q" : "qd", name);
    return Py_BuildValue("Ns", text, lab_linear_unit(l->model, l->system, i, 0));
}

static PyObject *output(const linear *l, int i)
{
    return Py_BuildValue("ssi", l->model->channels[i].name, l->model->channels[i].unit,
                         !l->system->differences[i]);
}

static PyObject *edge(const linear *l, int i)
{
    static const char *const kind[] = {"contact", "notch", "limit", "backlash"};
    const stein_edge *e = &l->system->edge[i];
    const char *name = e->kind == STEIN_EDGE_CONTACT ? l->model->contacts[e->index].name
                       : e->kind == STEIN_EDGE_NOTCH ? l->model->notches[e->index].name
                                                     : l->model->bodies[e->index].name;
    return Py_BuildValue("ssd", kind[e->kind], name, e->apart);
}

static PyObject *mode(const linear *l, int i)
{
    static const char *const kind[] = {"oscillates", "decays", "grows", "neutral"};
    const lab_mode *m = &l->modes->mode[i];
    int n = l->system->nfree;
    PyObject *shape = PyList_New(n);
    for (int k = 0; shape != NULL && k < n; k++) {
        const double *at = l->modes->shape + 2 * ((size_t)i * (size_t)n + (size_t)k);
        PyObject *x = PyComplex_FromDoubles(at[0], at[1]);
        if (x == NULL || PyList_SetItem(shape, k, x) != 0) {
            Py_CLEAR(shape);
        }
    }
    PyObject *value = PyComplex_FromDoubles(m->re, m->im);
    return Py_BuildValue("sNddsdN", kind[m->kind], value, m->frequency, m->damping,
                         l->model->bodies[l->system->joint[m->coordinate]].name, m->share, shape);
}

static PyObject *all_of(const linear *l)
{
    const stein_linear_system *s = l->system;
    PyObject *all = PyDict_New();
    int states = 2 * s->n;
    int done = put(all, "A", matrix(l, s->A, states, states)) &&
               put(all, "B", matrix(l, s->B, states, s->ninput)) &&
               put(all, "C", matrix(l, s->C, s->noutput, states)) &&
               put(all, "D", matrix(l, s->D, s->noutput, s->ninput)) &&
               put(all, "T", matrix(l, s->T, l->model->nq, s->n)) &&
               put(all, "mass", matrix(l, s->mass, s->n, s->n)) &&
               put(all, "coordinates", list_of(l, s->n, joint)) &&
               put(all, "free", PyLong_FromLong(s->nfree)) &&
               put(all, "states", list_of(l, states, state)) &&
               put(all, "inputs", list_of(l, s->ninput, input)) &&
               put(all, "outputs", list_of(l, s->noutput, output)) &&
               put(all, "modes", list_of(l, l->modes->n, mode)) &&
               put(all, "edges", list_of(l, s->nedge, edge)) &&
               put(all, "exact", PyBool_FromLong(s->exact)) &&
               put(all, "why", Py_BuildValue("z", s->why)) &&
               put(all, "error", PyFloat_FromDouble(s->error)) &&
               put(all, "residual", PyFloat_FromDouble(s->residual));
    if (!done) {
        Py_CLEAR(all);
    }
    return all;
}

/* linearise(): A, B, C, D and modes about the present state, in a dict */
PyObject *py__linearise(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    linear l = {.of = s, .model = py__equations(s->model)};
    stein_linear *at = NULL;
    lab_modes *modes = NULL;
    PyObject *all = NULL;
    stein_err err = {STEIN_OK, ""};
    (void)none;
    stein_status status = stein_linear_create(&at, l.model, NULL, &err);
    if (status != STEIN_OK) {
        py__fail(s->model->st, status, err.msg, NULL);
    } else if (py__enter(s)) {
        status = stein_linear_at(at, s->sim, &l.system, &err);
        status = status == STEIN_OK ? lab_modes_create(&modes, l.system, &err) : status;
        l.modes = modes;
        all = status == STEIN_OK ? all_of(&l) : NULL;
        if (!py__leave_with(s, status, &err)) {
            Py_CLEAR(all);
        }
    }
    lab_modes_destroy(modes);
    stein_linear_destroy(at);
    return all;
}
