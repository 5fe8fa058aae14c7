/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation.c - the type Simulation: life, lock, parameters, steps, state.
 */
#include "simulation.h"

/* ---- the lock ---- */

int py__enter(py__simulation *s)
{
    unsigned long me = PyThread_get_thread_ident();
    PyLockStatus got = (PyLockStatus)PyThread_acquire_lock(s->lock, NOWAIT_LOCK);
    if (got != PY_LOCK_ACQUIRED && s->owner == me) {
        PyErr_SetString(PyExc_RuntimeError,
                        "the simulation is running: a function that it calls must not use it");
        return 0;
    }
    while (got != PY_LOCK_ACQUIRED) {
        PyThreadState *other = PyEval_SaveThread();
        got = PyThread_acquire_lock_timed(s->lock, -1, 1);
        PyEval_RestoreThread(other);
        if (got == PY_LOCK_INTR && PyErr_CheckSignals() != 0) {
            return 0;
        }
    }
    s->owner = me;
    s->failed = 0;
    return 1;
}

void py__leave(py__simulation *s)
{
    s->owner = 0;
    PyThread_release_lock(s->lock);
}

int py__leave_with(py__simulation *s, stein_status status, const stein_err *err)
{
    py__leave(s);
    if (PyErr_Occurred()) {
        return 0;
    }
    if (s->lost) {
        PyErr_NoMemory();
    } else if (status != STEIN_OK) {
        py__fail(s->model->st, status, err->msg, NULL);
    }
    return !s->lost && status == STEIN_OK;
}

PyObject *py__none_after(py__simulation *s, stein_status status, const stein_err *err)
{
    return py__leave_with(s, status, err) ? Py_NewRef(Py_None) : NULL;
}

/* ---- events ---- */

void py__on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    py__simulation *s = ctx;
    (void)sim;
    if (s->nevent == s->room) {
        int room = s->room > 0 ? 2 * s->room : 64;
        stein_event *more = realloc(s->event, sizeof *more * (size_t)room);
        s->lost |= more == NULL;
        if (more == NULL) {
            return;
        }
        s->event = more;
        s->room = room;
    }
    s->event[s->nevent++] = *event;
}

void py__forget_events(py__simulation *s)
{
    s->nevent = s->lost = 0;
    stein_on_event(s->sim, py__on_event, s);
}

static PyObject *event_of(const py__simulation *s, const stein_event *e)
{
    static const char *const kind[] = {"contact_begin", "contact_end", "impact", "escapement",
                                       "caught",        "phase",       "stick",  "slip"};
    int has_phase = e->kind == STEIN_EVENT_PHASE || e->kind == STEIN_EVENT_SLIP;
    return PyObject_CallFunction(s->model->st->event, "dssi", e->time, kind[e->kind],
                                 stein_event_at(py__equations(s->model), e),
                                 has_phase ? e->phase : 0);
}

PyObject *py__events(const py__simulation *s)
{
    PyObject *list = PyList_New(s->nevent);
    for (int i = 0; list != NULL && i < s->nevent; i++) {
        PyObject *item = event_of(s, &s->event[i]);
        if (item == NULL || PyList_SetItem(list, i, item) != 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

static PyObject *sim_events(PyObject *self, void *none)
{
    py__simulation *s = (py__simulation *)self;
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    PyObject *list = py__events(s);
    py__leave(s);
    return list;
}

/* ---- coming and going ---- */

PyObject *py__start(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    PyTypeObject *type;
    py__model *m;
    double dt;
    int integrator;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "OO!di", &type, st->model, &m, &dt, &integrator)) {
        return NULL;
    }
    if (!PyType_Check(py__object(type)) || !PyType_IsSubtype(type, st->simulation)) {
        PyErr_SetString(PyExc_TypeError, "expected a class of simulations");
        return NULL;
    }
    py__simulation *s = py__allocate(type);
    if (s == NULL) {
        return NULL;
    }
    s->model = (py__model *)Py_NewRef(py__object(m));
    s->lock = PyThread_allocate_lock();
    s->input = calloc((size_t)py__equations(m)->ninput + 1, sizeof *s->input);
    if (s->lock == NULL || s->input == NULL) {
        Py_DECREF(py__object(s));
        return PyErr_NoMemory();
    }
    stein_sim_def def = lab_def(m->lab);
    def.dt = isnan(dt) ? def.dt : dt;
    def.integrator = integrator < 0 ? def.integrator : (stein_integrator)integrator;
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = lab_sim(m->lab, &def, &s->sim, &err);
    PyEval_RestoreThread(other);
    if (status != STEIN_OK) {
        Py_DECREF(py__object(s));
        return py__fail(st, status, err.msg, NULL);
    }
    py__forget_events(s);
    return (PyObject *)s;
}

static int sim_traverse(PyObject *self, visitproc visit, void *arg)
{
    py__simulation *s = (py__simulation *)self;
    Py_VISIT(py__object(Py_TYPE(self)));
    Py_VISIT(s->force);
    for (int i = 0; s->input != NULL && i < py__equations(s->model)->ninput; i++) {
        Py_VISIT(s->input[i].function);
    }
    return 0;
}

static int sim_clear(PyObject *self)
{
    py__simulation *s = (py__simulation *)self;
    for (int i = 0; s->input != NULL && i < py__equations(s->model)->ninput; i++) {
        if (s->input[i].function != NULL) {
            (void)stein_drive(s->sim, py__equations(s->model)->inputs[i].name, NULL, NULL, NULL);
        }
        Py_CLEAR(s->input[i].function);
    }
    if (s->force != NULL) {
        stein_on_force(s->sim, NULL, NULL);
    }
    Py_CLEAR(s->force);
    return 0;
}

static void sim_dealloc(PyObject *self)
{
    py__simulation *s = (py__simulation *)self;
    PyObject_GC_UnTrack(self);
    sim_clear(self);
    stein_sim_destroy(s->sim);
    lab_drive_close(s->file);
    if (s->lock != NULL) {
        PyThread_free_lock(s->lock);
    }
    free(s->input);
    free(s->event);
    Py_XDECREF(py__object(s->model));
    py__release(self);
}

/* ---- parameters: a mapping of names to numbers ---- */

/* name of a parameter. @return NULL with an exception */
static const stein_param *parameter(const py__simulation *s, PyObject *key)
{
    const stein_model *e = py__equations(s->model);
    if (!PyUnicode_Check(key)) {
        PyErr_Format(PyExc_TypeError, "expected the name of a parameter, not %R", key);
        return NULL;
    }
    const char *name = PyUnicode_AsUTF8AndSize(key, NULL);
    int i = name != NULL ? stein_find_param(e, name) : -1;
    if (name != NULL && i < 0) {
        PyObject *known = py__dict_of(e->np, &e->params->name, &e->params->unit, sizeof *e->params);
        py__fail_name(s->model->st, "parameter", name, known);
    }
    return i >= 0 ? &e->params[i] : NULL;
}

static int sim_contains(PyObject *self, PyObject *key)
{
    const char *name = PyUnicode_Check(key) ? PyUnicode_AsUTF8AndSize(key, NULL) : NULL;
    PyErr_Clear(); // what is no text is no name
    const py__simulation *s = (py__simulation *)self;
    return name != NULL && stein_find_param(py__equations(s->model), name) >= 0;
}

static Py_ssize_t sim_length(PyObject *self)
{
    return py__equations(((py__simulation *)self)->model)->np;
}

static PyObject *sim_get(PyObject *self, PyObject *key)
{
    py__simulation *s = (py__simulation *)self;
    const stein_param *p = parameter(s, key);
    double value = 0.0;
    stein_err err = {STEIN_OK, ""};
    if (p == NULL || !py__enter(s)) {
        return NULL;
    }
    stein_status status = stein_get(s->sim, p->name, &value, &err);
    return py__leave_with(s, status, &err) ? PyFloat_FromDouble(value) : NULL;
}

/* a number, or a text with a unit, for a parameter. @return 0 with an exception */
static int read_value(const py__simulation *s, const char *unit, PyObject *given, double *value)
{
    stein_err err;
    if (!PyUnicode_Check(given)) {
        *value = PyFloat_AsDouble(given);
        return !PyErr_Occurred();
    }
    const char *text = PyUnicode_AsUTF8AndSize(given, NULL);
    stein_status status = text != NULL ? lab_quantity(value, text, unit, &err) : STEIN_EINVAL;
    if (text != NULL && status != STEIN_OK) {
        py__fail(s->model->st, status, err.msg, NULL);
    }
    return status == STEIN_OK;
}

static int sim_set(PyObject *self, PyObject *key, PyObject *given)
{
    py__simulation *s = (py__simulation *)self;
    const stein_param *p = parameter(s, key);
    double value = 0.0;
    stein_err err = {STEIN_OK, ""};
    if (p != NULL && given == NULL) {
        PyErr_SetString(PyExc_TypeError, "a parameter cannot be deleted");
    }
    if (p == NULL || given == NULL || !read_value(s, p->unit, given, &value) || !py__enter(s)) {
        return -1;
    }
    stein_status status = stein_set(s->sim, p->name, value, &err);
    return py__leave_with(s, status, &err) ? 0 : -1;
}

/* ---- steps ---- */

static PyObject *sim_reset(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    stein_err err = {STEIN_OK, ""};
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    py__forget_events(s);
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = stein_reset(s->sim, &err);
    PyEval_RestoreThread(other);
    return py__none_after(s, status, &err);
}

static PyObject *sim_settle(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    stein_err err = {STEIN_OK, ""};
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = stein_settle(s->sim, &err);
    PyEval_RestoreThread(other);
    return py__none_after(s, status, &err);
}

/* @return 0 with an exception */
static int many_steps(py__simulation *s, long n)
{
    py__call c;
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (!py__begin_call(&c, s->model->st, Py_None, "steps")) {
        return 0;
    }
    PyThreadState *other = PyEval_SaveThread();
    for (long i = 1; status == STEIN_OK && i <= n; i++) {
        status = i % PY_STEPS == 0 && py__ask(&c) ? STEIN_ESTOPPED : stein_step(s->sim, &err);
    }
    PyEval_RestoreThread(other);
    return py__end_call(&c, status, &err);
}

/* step(n = 1): the time afterwards. A single step is shorter than handing the interpreter's lock to
 * another thread and back, so it keeps it */
static PyObject *sim_step(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    long n = 1;
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (!PyArg_ParseTuple(args, "|l", &n) || !py__enter(s)) {
        return NULL;
    }
    py__forget_events(s);
    if (n == 1) {
        status = stein_step(s->sim, &err);
    } else {
        (void)many_steps(s, n); // leave raises its exception
    }
    double t = stein_time(s->sim);
    return py__leave_with(s, status, &err) ? PyFloat_FromDouble(t) : NULL;
}

/* ---- the state ---- */

/* read(output) */
static PyObject *sim_read(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *e = py__equations(s->model);
    const char *name;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "s", &name)) {
        return NULL;
    }
    int i = stein_find_channel(e, name);
    if (i < 0) {
        return py__fail_name(s->model->st, "output", name, py__outputs(e));
    }
    if (!py__enter(s)) {
        return NULL;
    }
    double value = stein_read(s->sim, i);
    return py__leave_with(s, STEIN_OK, &err) ? PyFloat_FromDouble(value) : NULL;
}

enum { POSITIONS, SPEEDS, ACCELERATIONS };

/* q, qd, qdd: a copy, which stays what it is */
static PyObject *sim_coordinates(PyObject *self, void *which)
{
    py__simulation *s = (py__simulation *)self;
    if (!py__enter(s)) {
        return NULL;
    }
    const double *x = (size_t)which == POSITIONS ? stein_q(s->sim)
                      : (size_t)which == SPEEDS  ? stein_qd(s->sim)
                                                 : stein_qdd(s->sim);
    PyObject *row = py__row_of(s->model->st, x, py__equations(s->model)->nq);
    py__leave(s);
    if (PyErr_Occurred()) { // a signal has raised
        Py_CLEAR(row);
    }
    return row;
}

static PyObject *sim_dt(PyObject *self, void *none)
{
    (void)none;
    return PyFloat_FromDouble(stein_dt(((py__simulation *)self)->sim));
}

static PyObject *sim_time(PyObject *self, void *none)
{
    py__simulation *s = (py__simulation *)self;
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    double t = stein_time(s->sim);
    py__leave(s);
    return PyFloat_FromDouble(t);
}

static PyObject *sim_model(PyObject *self, void *none)
{
    (void)none;
    return Py_NewRef(py__object(((py__simulation *)self)->model));
}

/* set_state(q, qd, t) */
static PyObject *sim_set_state(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    PyObject *given[3] = {NULL, NULL, NULL};
    double t;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "OOd", &given[0], &given[1], &t) || !py__enter(s)) {
        return NULL;
    }
    double *x = py__read_state(s, given);
    stein_status status = STEIN_OK;
    if (x != NULL) {
        status = stein_set_state(s->sim, t, x, x + py__equations(s->model)->nq, &err);
    }
    free(x);
    return py__none_after(s, status, &err);
}

/* the state as bytes, and back */
static PyObject *sim_save(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    PyObject *block = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)stein_state_size(s->sim));
    if (block != NULL) {
        stein_save(s->sim, PyBytes_AsString(block));
    }
    py__leave(s);
    return block;
}

static PyObject *sim_restore(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const char *block;
    Py_ssize_t size;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "y#", &block, &size) || !py__enter(s)) {
        return NULL;
    }
    return py__none_after(s, stein_restore_from(s->sim, block, (size_t)size, &err), &err);
}

/* all parameters, in the order of Model.parameters; and back */
static PyObject *sim_values(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *e = py__equations(s->model);
    (void)none;
    py__block *b = py__new_block(s->model->st, e->np, -1);
    if (b == NULL || !py__enter(s)) {
        Py_XDECREF(py__object(b));
        return NULL;
    }
    for (int i = 0; i < e->np; i++) {
        (void)stein_get(s->sim, e->params[i].name, &b->data[i], NULL);
    }
    py__leave(s);
    return py__shown(s->model->st, b);
}

static PyObject *sim_set_values(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    int np = py__equations(s->model)->np;
    PyObject *given;
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (!PyArg_ParseTuple(args, "O", &given)) {
        return NULL;
    }
    double *p = calloc((size_t)np + 1, sizeof *p);
    if (p == NULL) {
        return PyErr_NoMemory();
    }
    if (!py__read_numbers(given, p, np, "parameters") || !py__enter(s)) {
        free(p);
        return NULL;
    }
    status = stein_set_all(s->sim, p, &err);
    free(p);
    return py__none_after(s, status, &err);
}

/* touches(contact): is it on? */
static PyObject *sim_touches(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *e = py__equations(s->model);
    const char *name;
    if (!PyArg_ParseTuple(args, "s", &name)) {
        return NULL;
    }
    int i = stein_find_contact(e, name);
    if (i < 0) {
        static const stein_contact none = {.name = ""};
        const stein_contact *c = e->ncontact > 0 ? e->contacts : &none;
        return py__fail_name(s->model->st, "contact", name,
                             py__dict_of(e->ncontact, &c->name, &c->name, sizeof *c));
    }
    if (!py__enter(s)) {
        return NULL;
    }
    int yes = stein_touches(s->sim, i);
    py__leave(s);
    return PyBool_FromLong(yes);
}

/* (kinetic, potential) of the tree [J] */
static PyObject *sim_energy(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    double kinetic = 0.0, potential = 0.0;
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    stein_energy(s->sim, stein_q(s->sim), stein_qd(s->sim), &kinetic, &potential);
    py__leave(s);
    return Py_BuildValue("(dd)", kinetic, potential);
}

static PyMethodDef sim_methods[] = {
    {"reset", sim_reset, METH_NOARGS,
     "reset()\n\nBack to t = 0: the initial values of the file, or static equilibrium."},
    {"lift", py__lift, METH_NOARGS, "lift()\n\nTake the free load away."},
    {"settle", sim_settle, METH_NOARGS,
     "settle()\n\nThe static equilibrium next to the present positions."},
    {"step", sim_step, METH_VARARGS,
     "step(n=1)\n\nn steps of dt; the time afterwards [s]. `events` has what happened."},
    {"read", sim_read, METH_VARARGS, "read(output)\n\nAn output in the present state."},
    {"drive", py__drive_input, METH_VARARGS,
     "drive(input, signal)\n\nDrive an input from now on: by a number that is held, by (value, "
     "rate,\n"
     "acceleration), by a function of the time that returns one of these (slow: it is called at\n"
     "every evaluation), or None, by nothing."},
    {"on_force", py__on_force, METH_O,
     "on_force(function)\n\nForces of one's own [N m or N]: function(t, q, qd) gives one for every "
     "coordinate\n(slow: it is called at every evaluation). None: no more."},
    {"touches", sim_touches, METH_VARARGS, "touches(contact)\n\nIs a contact on?"},
    {"inverse", py__inverse, METH_VARARGS,
     "inverse(q, qd, qdd)\n\nInverse dynamics: the forces M qdd + c [N m or N]. None: the present "
     "q, qd;\nqdd = 0."},
    {"acceleration", py__acceleration, METH_VARARGS,
     "acceleration(q, qd)\n\nqdd with all contacts, laws and inputs. None: the present ones."},
    {"energy", sim_energy, METH_NOARGS, "energy()\n\n(kinetic, potential) energy of the tree [J]."},
    {"_run", py__run, METH_VARARGS, NULL},
    {"_drive_file", py__drive_file, METH_VARARGS, NULL},
    {"_mass_bias", py__mass_bias, METH_VARARGS, NULL},
    {"_point", py__point, METH_VARARGS, NULL},
    {"_derivatives", py__derivatives, METH_VARARGS, NULL},
    {"_linearise", py__linearise, METH_NOARGS, NULL},
    {"_set_state", sim_set_state, METH_VARARGS, NULL},
    {"_save", sim_save, METH_NOARGS, NULL},
    {"_restore", sim_restore, METH_VARARGS, NULL},
    {"_values", sim_values, METH_NOARGS, NULL},
    {"_set_values", sim_set_values, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL}};
static PyGetSetDef sim_members[] = {
    {"time", sim_time, NULL, "Present time [s].", NULL},
    {"dt", sim_dt, NULL, "Step [s].", NULL},
    {"q", sim_coordinates, NULL, "Positions of the joints [rad or m], a copy.", (void *)POSITIONS},
    {"qd", sim_coordinates, NULL, "Speeds of the joints, a copy.", (void *)SPEEDS},
    {"qdd", sim_coordinates, NULL, "Accelerations of the joints, a copy.", (void *)ACCELERATIONS},
    {"events", sim_events, NULL, "Events of the last step or run.", NULL},
    {"_model", sim_model, NULL, NULL, NULL},
    {NULL, NULL, NULL, NULL, NULL}};
static PyType_Slot sim_slots[] = {
    {Py_tp_doc, "A simulation of a mechanism; stein.Simulation is what people use."},
    {Py_tp_dealloc, (void *)sim_dealloc},
    {Py_tp_traverse, (void *)sim_traverse},
    {Py_tp_clear, (void *)sim_clear},
    {Py_tp_methods, sim_methods},
    {Py_tp_getset, sim_members},
    {Py_mp_subscript, (void *)sim_get},
    {Py_mp_ass_subscript, (void *)sim_set},
    {Py_mp_length, (void *)sim_length},
    {Py_sq_contains, (void *)sim_contains},
    {0, NULL}};
PyType_Spec py__simulation_spec = {"stein._stein.Simulation", sizeof(py__simulation), 0,
                                   Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE | Py_TPFLAGS_HAVE_GC |
                                       Py_TPFLAGS_DISALLOW_INSTANTIATION,
                                   sim_slots};
