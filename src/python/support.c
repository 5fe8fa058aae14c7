/* SPDX-License-Identifier: GPL-3.0-or-later
 * support.c - failures as exceptions, texts, long work that Control-C ends, numbers in the buffer
 * protocol.
 */
#include "module.h"

#include <time.h>

static const double ask_every = 0.05; /* [s] */

/* ---- failures ---- */

static const char *const status_name[] = {
#define NAME(code, text) #code,
    STEIN_STATUS_LIST(NAME)
#undef NAME
};

PyObject *py__text_of(const char *text)
{
    return PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
}

/* raise an exception, which is taken over; NULL: one is set already. @return NULL */
static PyObject *raise_this(PyObject *why)
{
    if (why != NULL) {
        PyErr_SetObject(py__object(Py_TYPE(why)), why);
    }
    Py_XDECREF(why);
    return NULL;
}

PyObject *py__fail(const py__state *st, stein_status status, const char *message,
                   PyObject *problems)
{
    PyObject *told = py__text_of(message), *why = NULL;
    if (told != NULL) {
        why = PyObject_CallFunction(st->failure, "sOO", status_name[status], told,
                                    problems != NULL ? problems : Py_None);
    }
    Py_XDECREF(told);
    return raise_this(why);
}

PyObject *py__fail_name(const py__state *st, const char *what, const char *name, PyObject *known)
{
    PyObject *why =
        known != NULL ? PyObject_CallFunction(st->unknown, "ssO", what, name, known) : NULL;
    Py_XDECREF(known);
    return raise_this(why);
}

/* ---- lists of texts for the library ---- */

void py__free_texts(py__texts *t)
{
    for (int i = 0; i < t->n; i++) {
        free(t->at[i]);
    }
    free(t->at);
    *t = (py__texts){NULL, 0};
}

static int copy_text(PyObject *item, char **to)
{
    const char *text = item == Py_None ? "" : PyUnicode_AsUTF8AndSize(item, NULL);
    *to = text != NULL && item != Py_None ? strdup(text) : NULL;
    if (text != NULL && item != Py_None && *to == NULL) {
        PyErr_NoMemory();
    }
    return item == Py_None || *to != NULL;
}

int py__to_texts(PyObject *list, void *out)
{
    py__texts *t = out;
    if (list == NULL) { // a later argument is wrong
        py__free_texts(t);
        return 1;
    }
    Py_ssize_t n = PySequence_Size(list);
    t->n = 0;
    t->at = n >= 0 && n < 1 << 20 ? calloc((size_t)n + 1, sizeof *t->at) : NULL;
    int good = t->at != NULL;
    if (!good && !PyErr_Occurred()) {
        PyErr_NoMemory();
    }
    for (Py_ssize_t i = 0; good && i < n; i++) {
        PyObject *item = PySequence_GetItem(list, i);
        good = item != NULL && copy_text(item, &t->at[t->n]);
        t->n += good;
        Py_XDECREF(item);
    }
    if (!good) {
        py__free_texts(t);
    }
    return good ? Py_CLEANUP_SUPPORTED : 0;
}

const char *const *py__names_of(const py__texts *t)
{
    return (const char *const *)t->at;
}

/* ---- long work: Control-C, progress, problems ---- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int is_stopped(const py__call *c)
{
    return __atomic_load_n(&c->stopped, __ATOMIC_RELAXED);
}

static void stop(py__call *c)
{
    __atomic_store_n(&c->stopped, 1, __ATOMIC_RELAXED);
}

int py__begin_call(py__call *c, const py__state *st, PyObject *progress, const char *what)
{
    *c = (py__call){.st = st,
                    .progress = progress != Py_None ? progress : NULL,
                    .problems = PyList_New(0),
                    .what = what,
                    .thread = PyThread_get_thread_ident(),
                    .asked = now()};
    return c->problems != NULL;
}

/* a lab_stop_fn */
int py__ask(void *ctx)
{
    py__call *c = ctx;
    if (is_stopped(c) || PyThread_get_thread_ident() != c->thread || now() - c->asked < ask_every) {
        return is_stopped(c);
    }
    PyGILState_STATE gil = PyGILState_Ensure();
    if (PyErr_CheckSignals() != 0) {
        stop(c);
    }
    PyGILState_Release(gil);
    c->asked = now();
    return is_stopped(c);
}

/* a lab_fit_progress_fn; this thread reports the work of other threads */
void py__on_progress(void *ctx, double fraction, const char *step)
{
    py__call *c = ctx;
    if (c->progress == NULL || is_stopped(c) || PyThread_get_thread_ident() != c->thread ||
        (now() - c->shown < ask_every && fraction < 1.0)) {
        return;
    }
    PyGILState_STATE gil = PyGILState_Ensure();
    PyObject *none = PyObject_CallFunction(c->progress, "ds", fraction, step);
    if (none == NULL) {
        stop(c);
    }
    Py_XDECREF(none);
    PyGILState_Release(gil);
    c->shown = now();
    c->fraction = fraction;
}

void py__on_count(void *ctx, int done, int total)
{
    py__call *c = ctx;
    py__on_progress(ctx, total > 0 ? (double)done / total : 1.0, c->what);
}

void py__on_read(void *ctx, double fraction)
{
    py__on_progress(ctx, fraction, "reading");
}

/* a lab_report_fn */
void py__on_report(void *ctx, const char *message)
{
    py__call *c = ctx;
    if (is_stopped(c)) {
        return;
    }
    PyGILState_STATE gil = PyGILState_Ensure();
    PyObject *text = py__text_of(message);
    if (text == NULL || PyList_Append(c->problems, text) != 0) {
        PyErr_Clear(); // the failure itself is raised all the same
    }
    Py_XDECREF(text);
    PyGILState_Release(gil);
}

/* @return 1, or 0 with an exception: the library's, a callback's, or Control-C, which a compiler
 * that was called dies of as well */
int py__end_call(py__call *c, stein_status status, const stein_err *err)
{
    if (status == STEIN_OK && c->shown > 0.0 && c->fraction < 1.0) {
        py__on_progress(c, 1.0, c->what);
    }
    int told = is_stopped(c) || PyErr_Occurred() != NULL;
    if (!told && status != STEIN_OK && PyErr_CheckSignals() == 0) {
        py__fail(c->st, status, err->msg, c->problems);
    }
    Py_CLEAR(c->problems);
    return !told && status == STEIN_OK;
}

/* ---- Block: numbers in a row or a table, in the buffer protocol ---- */

PyObject *py__object(const void *x)
{
    return (PyObject *)x;
}

/* the end of an object of a heap type */
void py__release(void *self)
{
    PyTypeObject *type = Py_TYPE(py__object(self));
    ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
    Py_DECREF(py__object(type));
}

void *py__allocate(PyTypeObject *type)
{
    return PyType_GenericAlloc(type, 0);
}

/* a block of n rows of m numbers (m < 0: one row), without them yet */
py__block *py__new_block(const py__state *st, Py_ssize_t n, Py_ssize_t m)
{
    py__block *b = py__allocate(st->block);
    size_t size = (size_t)n * (size_t)(m < 0 ? 1 : m);
    if (b == NULL) {
        return NULL;
    }
    b->ndim = m < 0 ? 1 : 2;
    b->shape[0] = n;
    b->shape[1] = m;
    b->strides[1] = sizeof(double);
    b->strides[0] = (m < 0 ? 1 : m) * (Py_ssize_t)sizeof(double);
    b->data = calloc(size + 1, sizeof *b->data);
    if (b->data == NULL) {
        Py_DECREF(py__object(b));
        PyErr_NoMemory();
        return NULL;
    }
    return b;
}

static void block_dealloc(PyObject *self)
{
    py__block *b = (py__block *)self;
    if (b->base == NULL) {
        free(b->data);
    }
    Py_XDECREF(b->base);
    py__release(self);
}

static int is_dense(const py__block *b)
{
    Py_ssize_t row = (b->ndim == 2 ? b->shape[1] : 1) * (Py_ssize_t)sizeof(double);
    return b->strides[0] == row || b->shape[0] < 2;
}

static int block_buffer(PyObject *self, Py_buffer *view, int flags)
{
    py__block *b = (py__block *)self;
    int strided = (flags & PyBUF_STRIDES) == PyBUF_STRIDES;
    int dense = !strided || (flags & PyBUF_C_CONTIGUOUS) == PyBUF_C_CONTIGUOUS ||
                (flags & PyBUF_F_CONTIGUOUS) == PyBUF_F_CONTIGUOUS ||
                (flags & PyBUF_ANY_CONTIGUOUS) == PyBUF_ANY_CONTIGUOUS;
    view->obj = NULL;
    if ((flags & PyBUF_WRITABLE) == PyBUF_WRITABLE && b->base != NULL) {
        PyErr_SetString(PyExc_BufferError, "results are only to be read: take a copy");
        return -1;
    }
    if ((dense && !is_dense(b)) ||
        ((flags & PyBUF_F_CONTIGUOUS) == PyBUF_F_CONTIGUOUS && b->ndim == 2)) {
        PyErr_SetString(PyExc_BufferError, "the numbers do not lie side by side: take a copy");
        return -1;
    }
    view->obj = Py_NewRef(self);
    view->buf = b->data;
    view->itemsize = sizeof(double);
    view->len = view->itemsize * b->shape[0] * (b->ndim == 2 ? b->shape[1] : 1);
    view->readonly = b->base != NULL;
    view->format = (flags & PyBUF_FORMAT) == PyBUF_FORMAT ? "d" : NULL;
    view->ndim = b->ndim;
    view->shape = (flags & PyBUF_ND) == PyBUF_ND ? b->shape : NULL;
    view->strides = strided ? b->strides : NULL;
    view->suboffsets = NULL;
    view->internal = NULL;
    return 0;
}

/* what a person gets for a block: an array of numpy or a memoryview; takes the block over */
PyObject *py__shown(const py__state *st, py__block *b)
{
    PyObject *view = b != NULL ? PyObject_CallFunctionObjArgs(st->view, b, NULL) : NULL;
    Py_XDECREF(py__object(b));
    return view;
}

PyObject *py__row_of(const py__state *st, const double *x, int n)
{
    py__block *b = py__new_block(st, n, -1);
    if (b != NULL) {
        memcpy(b->data, x, sizeof *x * (size_t)n);
    }
    return py__shown(st, b);
}

static PyType_Slot block_slots[] = {
    {Py_tp_doc, "Numbers of the library, for memoryview and numpy.asarray."},
    {Py_tp_dealloc, (void *)block_dealloc},
    {Py_bf_getbuffer, (void *)block_buffer},
    {0, NULL}};
PyType_Spec py__block_spec = {"stein._stein.Block", sizeof(py__block), 0,
                              Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, block_slots};
