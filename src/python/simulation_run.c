/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_run.c - runs and strokes that are recorded, and how they change with parameters.
 */
#include "simulation.h"
#include "stein/sensitivity.h"

/* ---- runs ---- */

enum { ROWS = 3000 }; /* as stein simulate: where no interval is asked for */

/** How a run changes with parameters: directions that follow it. */
typedef struct slopes {
    py__texts by;
    stein_sensitivity *ride; /* NULL: nobody asks */
    double *at;              /* [room][by.n][2][nq] of every sample of the record: dq, dqd */
    int rows, room;
} slopes;

typedef struct run {
    py__simulation *s;
    slopes slopes;
    py__call call;
    lab_stroke_def def;
    lab_stroke stroke;
    lab_record *record;
    long samples;
    stein_err err;               /* of a sample */
    double stiffest, stiff_time; /* of all contacts on the way [1/s], [s] */
    int stiff;                   /* which contact, or ncontact + which notch */
} run;

/* ---- how it changes with parameters ---- */

/* as many directions as parameters, from the initial state on */
static stein_status begin_slopes(slopes *l, stein_sim *sim, stein_err *err)
{
    const stein_model *m = stein_sim_model(sim);
    double *dp = calloc((size_t)m->np + 1, sizeof *dp);
    stein_status status = dp != NULL ? STEIN_OK : STEIN_ENOMEM;
    if (status == STEIN_OK) {
        status = stein_sensitivity_create(&l->ride, m, NULL, l->by.n, err);
    }
    if (status == STEIN_OK) {
        status = stein_sensitivity_attach(l->ride, sim, err);
    }
    for (int k = 0; status == STEIN_OK && k < l->by.n; k++) {
        int i = stein_find_param(m, l->by.at[k]);
        dp[i] = 1.0;
        status = stein_sensitivity_start(l->ride, k, dp, err);
        dp[i] = 0.0;
    }
    free(dp);
    return status;
}

/* the values of the record's last sample, if it has just been taken */
static stein_status keep_slopes(slopes *l, const lab_record *record, const stein_model *m,
                                stein_err *err)
{
    int rows;
    size_t nq = (size_t)m->nq, one = 2 * nq * (size_t)l->by.n;
    (void)lab_record_numbers(record, &rows);
    if (rows == l->rows) {
        return STEIN_OK;
    }
    if (rows > l->room) {
        int room = 2 * rows + 64;
        double *more = realloc(l->at, sizeof *more * one * (size_t)room);
        if (more == NULL) {
            return STEIN_ENOMEM;
        }
        l->at = more;
        l->room = room;
    }
    double *to = l->at + one * (size_t)l->rows;
    for (int k = 0; k < l->by.n; k++, to += 2 * nq) {
        memcpy(to, stein_sensitivity_q(l->ride, k), sizeof *to * nq);
        memcpy(to + nq, stein_sensitivity_qd(l->ride, k), sizeof *to * nq);
    }
    l->rows = rows;
    return stein_sensitivity_check(l->ride, err);
}

/* [dq by each parameter, dqd by each]: tables of a row a sample */
static PyObject *slopes_of(const slopes *l, const py__simulation *s)
{
    size_t nq = (size_t)py__equations(s->model)->nq, one = 2 * nq * (size_t)l->by.n;
    PyObject *list = PyList_New(2 * (Py_ssize_t)l->by.n);
    for (int i = 0; list != NULL && i < 2 * l->by.n; i++) {
        size_t first = nq * (size_t)(2 * (i % l->by.n) + i / l->by.n);
        py__block *b = py__new_block(s->model->st, l->rows, (Py_ssize_t)nq);
        for (int row = 0; b != NULL && row < l->rows; row++) {
            memcpy(b->data + nq * (size_t)row, l->at + one * (size_t)row + first,
                   sizeof *b->data * nq);
        }
        PyObject *table = py__shown(s->model->st, b);
        if (table == NULL || PyList_SetItem(list, i, table) != 0) {
            Py_CLEAR(list);
        }
    }
    return list;
}

/* ---- the run ---- */

static stein_status take_sample(run *r, stein_sim *sim, stein_status (*take)(void *, stein_sim *))
{
    stein_status status = take(r->record, sim);
    return status == STEIN_OK && r->slopes.ride != NULL
               ? keep_slopes(&r->slopes, r->record, stein_sim_model(sim), &r->err)
               : status;
}

static stein_status finish_record(void *record, stein_sim *sim)
{
    return lab_record_finish(record, sim);
}

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
    return take_sample(r, sim, lab_record_sample);
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
    if (status == STEIN_OK && r->slopes.by.n > 0) {
        status = begin_slopes(&r->slopes, s->sim, err);
    }
    r->def.event = on_run_event;
    r->def.sample = on_sample;
    r->def.ctx = r;
    if (status == STEIN_OK) {
        status = as_stroke ? lab_strike(s->sim, &r->def, &r->stroke, err)
                           : lab_simulate(s->sim, &r->def, err);
    }
    status = status == STEIN_OK ? take_sample(r, s->sim, finish_record) : status;
    if (status != STEIN_OK && r->err.msg[0] != '\0') {
        *err = r->err;
    }
    return status;
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

/* (record, events, stroke or None, warning or None, slopes); takes the record over */
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
    PyObject *by = slopes_of(&r->slopes, r->s);
    if (events == NULL || warning == NULL || stroke == NULL || by == NULL) {
        Py_XDECREF(by);
        Py_XDECREF(events);
        Py_XDECREF(warning);
        Py_XDECREF(stroke);
        Py_DECREF(py__object(record));
        return NULL;
    }
    return Py_BuildValue("(NNNNN)", record, events, stroke, warning, by);
}

static void free_run(run *r)
{
    stein_sensitivity_destroy(r->slopes.ride);
    free(r->slopes.at);
    py__free_texts(&r->slopes.by);
    lab_record_destroy(r->record);
}

/* run(until, every, release, restart, as_stroke, progress, by); until and every nan: as stein
 * simulate has them without options; by: names of parameters */
PyObject *py__run(PyObject *self, PyObject *args)
{
    py__simulation *s = (py__simulation *)self;
    const stein_model *m = py__equations(s->model);
    int restart, as_stroke;
    double every;
    PyObject *progress, *result = NULL;
    run r = {.s = s, .def = lab_stroke_def_default(m), .stiff = -1};
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "dddppOO&", &r.def.until, &every, &r.def.release, &restart,
                          &as_stroke, &progress, py__to_texts, &r.slopes.by)) {
        return NULL;
    }
    r.def.until = isnan(r.def.until) ? m->until : r.def.until;
    every = isnan(every) ? r.def.until / ROWS : every;
    if (!py__enter(s)) {
        free_run(&r);
        return NULL;
    }
    py__forget_events(s);
    if (!py__begin_call(&r.call, s->model->st, progress, m->name)) {
        free_run(&r);
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
    free_run(&r);
    py__leave(s);
    if (result != NULL && s->lost) {
        Py_CLEAR(result);
        PyErr_NoMemory();
    }
    return result;
}

/* lift(): the free load is taken away */
PyObject *py__lift(PyObject *self, PyObject *none)
{
    py__simulation *s = (py__simulation *)self;
    const stein_err err = {STEIN_OK, ""};
    (void)none;
    if (!py__enter(s)) {
        return NULL;
    }
    stein_load_lift(s->sim);
    return py__none_after(s, STEIN_OK, &err);
}
