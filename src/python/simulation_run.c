/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_run.c - runs and strokes that are recorded, and what drives a simulation.
 */
#include "simulation.h"

/* ---- runs ---- */

enum { ROWS = 3000 }; /* as stein simulate: where no interval is asked for */

typedef struct run {
    py__simulation *s;
    py__call call;
    lab_stroke_def def;
    lab_stroke stroke;
    lab_record *record;
    long samples;
    double stiffest, stiff_time; /* of all contacts on the way [1/s], [s] */
    int stiff;                   /* which contact, or ncontact + which notch */
} run;

static stein_status on_sample(void *ctx, stein_sim *sim)
{
    run *r = ctx;
    int which = -1;
    double rate = stein_stiffest(sim, &which), t = stein_time(sim);
    if (rate > r->stiffest) {
        r->stiffest = rate;
        r->stiff = which;
        r->stiff_time = t;
    }
    if (++r->samples % PY_STEPS == 0) {
        py__on_progress(&r->call, t / r->def.until, r->call.what);
        if (py__ask(&r->call)) {
            return STEIN_ESTOPPED;
        }
    }
    return lab_record_sample(r->record, sim);
}

static void on_run_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    run *r = ctx;
    py__on_event(r->s, sim, event);
}

static stein_status play(run *r, double every, int restart, int as_stroke, stein_err *err)
{
    py__simulation *s = r->s;
    stein_status status = restart ? stein_reset(s->sim, err) : STEIN_OK;
    if (status == STEIN_OK) {
        status = lab_record_create(&r->record, py__equations(s->model), every, err);
    }
    r->def.event = on_run_event;
    r->def.sample = on_sample;
    r->def.ctx = r;
    if (status == STEIN_OK) {
        status = as_stroke ? lab_strike(s->sim, &r->def, &r->stroke, err)
                           : lab_simulate(s->sim, &r->def, err);
    }
    return status == STEIN_OK ? lab_record_finish(r->record, s->sim) : status;
}

/* as stein simulate has it; None where the step follows the contacts */
static PyObject *stiffness_of(const run *r)
{
    const stein_model *m = py__equations(r->s->model);
    double dt = stein_dt(r->s->sim);
    char text[300];
    if (!(r->stiffest * dt > 1.0)) {
        return Py_NewRef(Py_None);
    }
    snprintf(text, sizeof text,
             "the step of %g s is too long: at %g s contact \"%s\" needs %.2g s or less; do not "
             "trust the result",
             dt, r->stiff_time,
             r->stiff < m->ncontact ? m->contacts[r->stiff].name
                                    : m->notches[r->stiff - m->ncontact].name,
             1.0 / r->stiffest);
    return py__text_of(text);
}

static PyObject *stroke_of(const lab_stroke *k)
{
    return Py_BuildValue("(sddddidOddO)", lab_outcome_text(k->outcome), k->escape_time,
                         k->escape_height, k->impact_time, k->impact_speed, k->impacts,
                         k->free_flight, k->forced_escapement ? Py_True : Py_False,
                         k->peak_string_force, k->blow, k->rearmed ? Py_True : Py_False);
}

/* (record, events, stroke or None, warning or None); takes the record over */
static PyObject *results_of(run *r, int as_stroke)
{
    const py__state *st = r->s->model->st;
    py__record *record = py__allocate(st->record);
    if (record == NULL) {
        return NULL;
    }
    record->model = (py__model *)Py_NewRef(py__object(r->s->model));
    record->lab = r->record;
    r->record = NULL;
    PyObject *events = py__events(r->s), *warning = stiffness_of(r);
    PyObject *stroke = as_stroke ? stroke_of(&r->stroke) : Py_NewRef(Py_None);
    if (events == NULL || warning == NULL || stroke == NULL) {
        Py_XDECREF(events);
        Py_XDECREF(warning);
        Py_XDECREF(stroke);
        Py_DECREF(py__object(record));
        return NULL;
    }
    return Py_BuildValue("(NNNN)", record, events, stroke, warning);
}

/* run(until, every, release, restart, as_stroke, progress); until and every nan: as stein simulate
 * has them without options */
PyObject *py__run(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *m = py__equations(s->model);
    int restart, as_stroke;
    double every;
    PyObject *progress, *result = NULL;
    run r = {.s = s, .def = lab_stroke_def_default(m), .stiff = -1};
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "dddppO", &r.def.until, &every, &r.def.release, &restart,
                          &as_stroke, &progress)) {
        return NULL;
    }
    r.def.until = isnan(r.def.until) ? m->until : r.def.until;
    every = isnan(every) ? r.def.until / ROWS : every;
    if (!py__enter(s)) {
        return NULL;
    }
    py__forget_events(s);
    if (!py__begin_call(&r.call, s->model->st, progress, m->name)) {
        py__leave(s);
        return NULL;
    }
    PyThreadState *other = PyEval_SaveThread();
    stein_status status = play(&r, every, restart, as_stroke, &err);
    PyEval_RestoreThread(other);
    if (err.msg[0] == '\0') {
        snprintf(err.msg, sizeof err.msg, "%s", stein_status_text(status));
    }
    if (py__end_call(&r.call, status, &err)) {
        result = results_of(&r, as_stroke);
    }
    lab_record_destroy(r.record);
    py__leave(s);
    if (result != NULL && s->lost) {
        Py_CLEAR(result);
        PyErr_NoMemory();
    }
    return result;
}

/* ---- drives ---- */

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
