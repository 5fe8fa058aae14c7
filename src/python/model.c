/* SPDX-License-Identifier: GPL-3.0-or-later
 * model.c - a mechanism file with overrides, and samples of a run of it.
 */
#include "module.h"

/* ---- Model: a mechanism file with overrides, its equations ---- */

static void model_dealloc(PyObject *self)
{
    py__model *m = (py__model *)self;
    lab_close(m->lab);
    py__free_texts(&m->set);
    Py_XDECREF(m->file);
    Py_XDECREF(m->module);
    py__release(self);
}

const stein_model *py__equations(const py__model *m)
{
    return lab_equations(m->lab);
}

const char *py__file(const py__model *m)
{
    return PyBytes_AsString(m->file);
}

lab_options py__options_of(const py__model *m, py__call *c)
{
    lab_options o = lab_options_default();
    o.set = py__names_of(&m->set);
    o.nset = m->set.n;
    o.report = py__on_report;
    o.ctx = c;
    return o;
}

PyObject *py__open(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    PyObject *file = NULL;
    py__texts set = {NULL, 0};
    py__call c;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O&O&", PyUnicode_FSConverter, &file, py__to_texts, &set)) {
        return NULL;
    }
    py__model *m = py__allocate(st->model);
    if (m == NULL || !py__begin_call(&c, st, Py_None, "")) {
        Py_XDECREF(py__object(m));
        Py_DECREF(file);
        py__free_texts(&set);
        return NULL;
    }
    m->module = Py_NewRef(module);
    m->st = st;
    m->file = file;
    m->set = set;
    lab_options options = py__options_of(m, &c);
    const char *path = py__file(m);
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = lab_open(&m->lab, path, &options, &err);
    PyEval_RestoreThread(other);
    if (!py__end_call(&c, status, &err)) {
        Py_DECREF(py__object(m));
        return NULL;
    }
    return (PyObject *)m;
}

/* what the equations name: (name, unit, value, tolerance) of each parameter */
static PyObject *model_parameters(PyObject *self, PyObject *none)
{
    const stein_model *e = py__equations((py__model *)self);
    PyObject *list = PyList_New(e->np);
    (void)none;
    for (int i = 0; list != NULL && i < e->np; i++) {
        const stein_param *p = &e->params[i];
        PyObject *item = Py_BuildValue("(ssdd)", p->name, p->unit, p->value, p->tolerance);
        if (item == NULL || PyList_SetItem(list, i, item) != 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

PyObject *py__dict_of(int n, const char *const *name, const char *const *text, size_t stride)
{
    PyObject *dict = PyDict_New();
    for (int i = 0; dict != NULL && i < n; i++) {
        size_t at = stride * (size_t)i;
        PyObject *value = py__text_of(*(const char *const *)((const char *)text + at));
        if (value == NULL ||
            PyDict_SetItemString(dict, *(const char *const *)((const char *)name + at), value) !=
                0) {
            Py_CLEAR(dict);
        }
        Py_XDECREF(value);
    }
    return dict;
}

PyObject *py__outputs(const stein_model *e)
{
    return py__dict_of(e->nchannel, &e->channels->name, &e->channels->unit, sizeof *e->channels);
}

PyObject *py__inputs(const stein_model *e)
{
    static const stein_input none = {.name = ""};
    const stein_input *i = e->ninput > 0 ? e->inputs : &none;
    return py__dict_of(e->ninput, &i->name, &i->unit, sizeof *i);
}

static PyObject *model_outputs(PyObject *self, PyObject *none)
{
    (void)none;
    return py__outputs(py__equations((py__model *)self));
}

static PyObject *model_inputs(PyObject *self, PyObject *none)
{
    (void)none;
    return py__inputs(py__equations((py__model *)self));
}

/* bodies in the order of q */
static PyObject *model_bodies(PyObject *self, PyObject *none)
{
    const stein_model *e = py__equations((py__model *)self);
    (void)none;
    return py__dict_of(e->nq, &e->bodies->name, &e->bodies->name, sizeof *e->bodies);
}

/* (name, hash of the equations, duration, is it a stroke) */
static PyObject *model_facts(PyObject *self, PyObject *none)
{
    const stein_model *e = py__equations((py__model *)self);
    (void)none;
    return Py_BuildValue("(ssdN)", e->name, e->equations, e->until,
                         PyBool_FromLong(e->stroke.string >= 0));
}

/* expressions(what): text that SymPy reads */
static PyObject *model_expressions(PyObject *self, PyObject *args)
{
    const py__model *m = (py__model *)self;
    const char *what;
    char *text = NULL;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "s", &what)) {
        return NULL;
    }
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = lab_expressions(&text, m->lab, what, &err);
    PyEval_RestoreThread(other);
    PyObject *told =
        status == STEIN_OK ? py__text_of(text) : py__fail(m->st, status, err.msg, NULL);
    free(text);
    return told;
}

static PyMethodDef model_methods[] = {{"parameters", model_parameters, METH_NOARGS, NULL},
                                      {"outputs", model_outputs, METH_NOARGS, NULL},
                                      {"inputs", model_inputs, METH_NOARGS, NULL},
                                      {"bodies", model_bodies, METH_NOARGS, NULL},
                                      {"facts", model_facts, METH_NOARGS, NULL},
                                      {"expressions", model_expressions, METH_VARARGS, NULL},
                                      {NULL, NULL, 0, NULL}};
static PyType_Slot model_slots[] = {{Py_tp_doc, "A mechanism file with its equations."},
                                    {Py_tp_dealloc, (void *)model_dealloc},
                                    {Py_tp_methods, model_methods},
                                    {0, NULL}};
PyType_Spec py__model_spec = {"stein._stein.Model", sizeof(py__model), 0,
                              Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, model_slots};

/* ---- Record: samples of all outputs ---- */

static void record_dealloc(PyObject *self)
{
    py__record *r = (py__record *)self;
    lab_record_destroy(r->lab);
    Py_XDECREF(py__object(r->model));
    py__release(self);
}

/* column(i): the numbers of output i, over the record's own memory */
static PyObject *record_column(PyObject *self, PyObject *args)
{
    const py__record *r = (py__record *)self;
    int rows, i, n = py__equations(r->model)->nchannel;
    const double *x = lab_record_numbers(r->lab, &rows);
    if (!PyArg_ParseTuple(args, "i", &i)) {
        return NULL;
    }
    if (i < 0 || i >= n) {
        PyErr_Format(PyExc_IndexError, "output %d of %d", i, n);
        return NULL;
    }
    py__block *b = py__allocate(r->model->st->block);
    if (b == NULL) {
        return NULL;
    }
    b->base = Py_NewRef(self);
    b->data = (double *)x + i; // only read: block_buffer
    b->ndim = 1;
    b->shape[0] = rows;
    b->strides[0] = n * (Py_ssize_t)sizeof *x;
    return py__shown(r->model->st, b);
}

static PyMethodDef record_methods[] = {{"column", record_column, METH_VARARGS, NULL},
                                       {NULL, NULL, 0, NULL}};
static PyType_Slot record_slots[] = {{Py_tp_doc, "Samples of all outputs of a run."},
                                     {Py_tp_dealloc, (void *)record_dealloc},
                                     {Py_tp_methods, record_methods},
                                     {0, NULL}};
PyType_Spec py__record_spec = {"stein._stein.Record", sizeof(py__record), 0,
                               Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION,
                               record_slots};
