/* SPDX-License-Identifier: GPL-3.0-or-later
 * steinmodule.c - the module stein._stein: sweeps, fits, diagnoses and plans for mechanism files.
 *
 * Each does what the command of the same name does, with the same calls in the same order, and
 * leaves its results in files: stein/__init__.py reads them. Records come as two lists, names and
 * texts; a text that is None is in the file of that name.
 */
#include <gsl/gsl_errno.h>

#include "module.h"

/* ---- sweeps ---- */

/* sweep(model, vary, path, until, release, threads, journal, progress): writes the table as CSV.
 * @return (points computed now, found in the journal, damaged lines of it) */
static PyObject *sweep(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    py__model *m;
    py__texts vary = {NULL, 0};
    const char *path, *journal;
    PyObject *progress;
    py__call c;
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    lab_vary_report done = {0, 0, 0};
    lab_vary_def def = {.shards = 1};
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O!O&sddizO", st->model, &m, py__to_texts, &vary, &path, &def.until,
                          &def.release, &def.threads, &journal, &progress)) {
        return NULL;
    }
    def.until = isnan(def.until) ? lab_until(m->lab) : def.until;
    def.journal = journal;
    def.set = py__names_of(&m->set);
    def.nset = m->set.n;
    def.progress = py__on_count;
    def.stop = py__ask;
    def.ctx = &c;
    if (!py__begin_call(&c, st, progress, py__equations(m)->name)) {
        py__free_texts(&vary);
        return NULL;
    }
    lab_options options = py__options_of(m, &c);
    PyThreadState *other = PyEval_SaveThread();
    stein_status status =
        lab_grid_open(&grid, m->lab, py__names_of(&vary), vary.n, py__file(m), &options, &err);
    status = status == STEIN_OK ? lab_vary(&table, m->lab, grid, &def, &done, &err) : status;
    status = status == STEIN_OK ? lab_table_write(path, table, &err) : status;
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    py__free_texts(&vary);
    PyEval_RestoreThread(other);
    return py__end_call(&c, status, &err)
               ? Py_BuildValue("(iii)", done.computed, done.found, done.damaged)
               : NULL;
}

/* ---- records ---- */

/* all records, or none; problems go to the call */
static stein_status open_records(lab_dataset **data, const py__model *m, const py__texts *name,
                                 const py__texts *text, py__call *c, stein_err *err)
{
    lab_data_options options = lab_data_options_default(py__equations(m));
    options.text = py__names_of(text);
    options.report = py__on_report;
    options.progress = py__on_read;
    options.ctx = c;
    return lab_dataset_open(data, py__names_of(name), name->n, &options, err);
}

/* ---- fits ---- */

typedef struct fitting {
    const py__model *m;
    py__texts name, text, free, profile;
    const char *json, *output; /* output NULL: none */
    lab_fit_def def;
    lab_dataset *data;
    lab_fit *found;
    py__call call;
} fitting;

static stein_status fit_records(fitting *f, stein_err *err)
{
    const py__model *m = f->m;
    lab_options options = py__options_of(m, &f->call);
    stein_status status = open_records(&f->data, m, &f->name, &f->text, &f->call, err);
    if (status == STEIN_OK) {
        status = lab_fit_run(&f->found, m->lab, f->data, &f->def, err);
    }
    if (status == STEIN_OK) {
        status = lab_fit_json(f->json, py__equations(m)->name, f->found, err);
    }
    return status == STEIN_OK && f->output != NULL
               ? lab_fit_write(f->output, f->found, py__file(m), &options, err)
               : status;
}

/* @return 0 with an exception */
static int read_fit(fitting *f, const py__state *st, PyObject *args, PyObject **progress)
{
    double prior, offset, trigger;
    lab_fit_def *d = &f->def;
    if (!PyArg_ParseTuple(args, "O!O&O&O&O&sz(ipiii)(ddd)zO", st->model, &f->m, py__to_texts,
                          &f->name, py__to_texts, &f->text, py__to_texts, &f->free, py__to_texts,
                          &f->profile, &f->json, &f->output, &d->starts, &d->robust, &d->initial,
                          &d->scatter, &d->threads, &prior, &offset, &trigger, &d->journal,
                          progress)) {
        return 0;
    }
    d->free = py__names_of(&f->free);
    d->nfree = f->free.n;
    d->profile = py__names_of(&f->profile);
    d->nprofile = f->profile.n;
    d->prior = isnan(prior) ? d->prior : prior;
    d->offset = isnan(offset) ? d->offset : offset;
    d->trigger = isnan(trigger) ? d->trigger : trigger;
    d->progress = py__on_progress;
    d->report = py__on_report;
    d->stop = py__ask;
    d->ctx = &f->call;
    return 1;
}

/* fit(model, names, texts, free, profile, json, output, (starts, robust, initial, scatter,
 * threads), (prior, offset, trigger), journal, progress); a number nan: the default.
 * @return doubts about the setup */
static PyObject *fit(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    fitting f = {.def = lab_fit_def_default()};
    PyObject *progress, *doubts = NULL;
    stein_err err = {STEIN_OK, ""};
    if (!read_fit(&f, st, args, &progress)) {
        return NULL;
    }
    if (py__begin_call(&f.call, st, progress, "fit")) {
        doubts = Py_NewRef(f.call.problems);
        PyThreadState *other = PyEval_SaveThread();
        stein_status status = fit_records(&f, &err);
        PyEval_RestoreThread(other);
        if (!py__end_call(&f.call, status, &err)) {
            Py_CLEAR(doubts);
        }
    }
    lab_fit_destroy(f.found);
    lab_dataset_close(f.data);
    py__free_texts(&f.name);
    py__free_texts(&f.text);
    py__free_texts(&f.free);
    py__free_texts(&f.profile);
    return doubts;
}

/* ---- diagnoses ---- */

typedef struct diagnosis {
    const py__model *m;
    py__texts name, text, free, without;
    const char *folder;
    int trust;
    lab_diagnose_def def;
    lab_dataset *data;
    lab_diagnosis *found;
    py__call call;
} diagnosis;

static stein_status write_file(const diagnosis *d, const char *name, stein_err *err)
{
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s", d->folder, name) >= (int)sizeof path) {
        snprintf(err->msg, sizeof err->msg, "the path %.200s is too long", d->folder);
        return STEIN_EIO;
    }
    if (strcmp(name, "diagnosis.json") == 0) {
        return lab_diagnosis_json(path, d->found, err);
    }
    if (strcmp(name, "report.html") == 0) {
        return lab_diagnosis_page(path, d->found, err);
    }
    return lab_extend(path, py__file(d->m), d->found, err);
}

/* the work of stein diagnose, with the same calls in the same order */
static stein_status diagnose_records(diagnosis *d, stein_err *err)
{
    stein_status status = open_records(&d->data, d->m, &d->name, &d->text, &d->call, err);
    if (status == STEIN_OK && !d->trust) {
        status = lab_data_check_settings(d->data, d->m->lab, py__on_report, &d->call, err);
    }
    if (status == STEIN_OK) {
        status = lab_diagnose(&d->found, py__file(d->m), d->m->lab, d->data, &d->def, err);
    }
    status = status == STEIN_OK ? write_file(d, "diagnosis.json", err) : status;
    status = status == STEIN_OK ? write_file(d, "report.html", err) : status;
    if (status == STEIN_OK &&
        (d->found->ncause > 0 || (d->found->nlaw > 0 && d->found->law[0].pays))) {
        status = write_file(d, "extended.yaml", err);
    }
    return status;
}

/* diagnose(model, names, texts, held, free, without, folder, strokes, seconds, threads, trust,
 * explain, trace, progress): the files of stein diagnose in the folder. @return the explanation */
static PyObject *diagnose(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    diagnosis d = {.def = lab_diagnose_def_default()};
    const char *held;
    Py_ssize_t nheld;
    PyObject *progress, *result = NULL;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O!O&O&y#O&O&sldipzzO", st->model, &d.m, py__to_texts, &d.name,
                          py__to_texts, &d.text, &held, &nheld, py__to_texts, &d.free, py__to_texts,
                          &d.without, &d.folder, &d.def.most_strokes, &d.def.most_seconds,
                          &d.def.threads, &d.trust, &d.def.explain, &d.def.trace, &progress)) {
        return NULL;
    }
    d.def.held_out = nheld == d.name.n ? (const unsigned char *)held : NULL;
    d.def.free = py__names_of(&d.free);
    d.def.nfree = d.free.n;
    d.def.without = py__names_of(&d.without);
    d.def.nwithout = d.without.n;
    d.def.progress = py__on_progress;
    d.def.report = py__on_report;
    d.def.stop = py__ask;
    d.def.ctx = &d.call;
    if (py__begin_call(&d.call, st, progress, "diagnosis")) {
        lab_options options = py__options_of(d.m, &d.call);
        d.def.options = &options;
        PyThreadState *other = PyEval_SaveThread();
        stein_status status = diagnose_records(&d, &err);
        PyEval_RestoreThread(other);
        if (py__end_call(&d.call, status, &err)) {
            result = Py_BuildValue("z", d.found->explanation);
        }
    }
    lab_diagnosis_destroy(d.found);
    lab_dataset_close(d.data);
    py__free_texts(&d.name);
    py__free_texts(&d.text);
    py__free_texts(&d.free);
    py__free_texts(&d.without);
    return result;
}

/* ---- plans ---- */

typedef struct planning {
    const py__model *m;
    const char *diagnosis, *folder; /* diagnosis.json; where the files go */
    lab_plan_def def;
    py__texts instrument;
    lab_diagnosis *read;
    lab_plan *plan;
    char *path[LAB_PLAN_FILES];
    py__call call;
} planning;

static stein_status plan_experiments(planning *p, stein_err *err)
{
    const py__model *m = p->m;
    stein_status status = lab_diagnosis_read(&p->read, p->diagnosis, m->lab, err);
    if (status == STEIN_OK) {
        status = lab_plan_make(&p->plan, py__file(m), m->lab, p->read, &p->def, err);
    }
    return status == STEIN_OK ? lab_plan_files(p->folder, p->plan, py__file(m), m->lab, p->read,
                                               &p->def, p->path, err)
                              : status;
}

static void free_plan(planning *p)
{
    for (int i = 0; i < LAB_PLAN_FILES; i++) {
        free(p->path[i]);
    }
    lab_plan_destroy(p->plan);
    lab_diagnosis_destroy(p->read);
    py__free_texts(&p->instrument);
}

/* plan(model, diagnosis.json, folder, odds, all instruments?, instruments, threads, progress): the
 * files of stein plan in the folder */
static PyObject *plan(PyObject *module, PyObject *args)
{
    const py__state *st = PyModule_GetState(module);
    planning p = {.def = lab_plan_def_default()};
    PyObject *progress, *result = NULL;
    double odds;
    int all;
    stein_err err = {STEIN_OK, ""};
    if (!PyArg_ParseTuple(args, "O!ssdpO&iO", st->model, &p.m, &p.diagnosis, &p.folder, &odds, &all,
                          py__to_texts, &p.instrument, &p.def.threads, &progress)) {
        return NULL;
    }
    p.def.wanted = isnan(odds) ? p.def.wanted : odds;
    p.def.instrument = all ? NULL : py__names_of(&p.instrument);
    p.def.ninstrument = p.instrument.n;
    p.def.progress = py__on_progress;
    p.def.stop = py__ask;
    p.def.ctx = &p.call;
    if (py__begin_call(&p.call, st, progress, "experiments")) {
        lab_options options = py__options_of(p.m, &p.call);
        p.def.options = &options;
        PyThreadState *other = PyEval_SaveThread();
        stein_status status = plan_experiments(&p, &err);
        PyEval_RestoreThread(other);
        result = py__end_call(&p.call, status, &err) ? Py_NewRef(Py_None) : NULL;
    }
    free_plan(&p);
    return result;
}

/* ---- the module ---- */

static PyMethodDef functions[] = {{"open", py__open, METH_VARARGS, NULL},
                                  {"start", py__start, METH_VARARGS, NULL},
                                  {"sweep", sweep, METH_VARARGS, NULL},
                                  {"fit", fit, METH_VARARGS, NULL},
                                  {"diagnose", diagnose, METH_VARARGS, NULL},
                                  {"plan", plan, METH_VARARGS, NULL},
                                  {NULL, NULL, 0, NULL}};

static PyTypeObject *add_type(PyObject *module, PyType_Spec *spec)
{
    PyTypeObject *type = (PyTypeObject *)PyType_FromModuleAndSpec(module, spec, NULL);
    if (type != NULL && PyModule_AddType(module, type) != 0) {
        Py_CLEAR(type);
    }
    return type;
}

static int begin_module(PyObject *module)
{
    py__state *st = PyModule_GetState(module);
    gsl_set_error_handler_off(); // as in the program: a singular matrix is an answer, no abort
    PyObject *support = PyImport_ImportModule("stein._support");
    if (support != NULL) {
        st->failure = PyObject_GetAttrString(support, "failure");
        st->unknown = PyObject_GetAttrString(support, "unknown");
        st->view = PyObject_GetAttrString(support, "view");
        st->event = PyObject_GetAttrString(support, "Event");
        Py_DECREF(support);
    }
    st->model = add_type(module, &py__model_spec);
    st->simulation = st->model != NULL ? add_type(module, &py__simulation_spec) : NULL;
    st->block = st->simulation != NULL ? add_type(module, &py__block_spec) : NULL;
    st->record = st->block != NULL ? add_type(module, &py__record_spec) : NULL;
    int good = st->failure != NULL && st->unknown != NULL && st->view != NULL &&
               st->event != NULL && st->record != NULL;
    return good && PyModule_AddStringConstant(module, "version", stein_version()) == 0 ? 0 : -1;
}

static int traverse_module(PyObject *module, visitproc visit, void *arg)
{
    const py__state *st = PyModule_GetState(module);
    Py_VISIT(py__object(st->model));
    Py_VISIT(py__object(st->simulation));
    Py_VISIT(py__object(st->block));
    Py_VISIT(py__object(st->record));
    Py_VISIT(st->failure);
    Py_VISIT(st->unknown);
    Py_VISIT(st->view);
    Py_VISIT(st->event);
    return 0;
}

static int clear_module(PyObject *module)
{
    py__state *st = PyModule_GetState(module);
    Py_CLEAR(st->model);
    Py_CLEAR(st->simulation);
    Py_CLEAR(st->block);
    Py_CLEAR(st->record);
    Py_CLEAR(st->failure);
    Py_CLEAR(st->unknown);
    Py_CLEAR(st->view);
    Py_CLEAR(st->event);
    return 0;
}

static PyModuleDef_Slot module_slots[] = {{Py_mod_exec, (void *)begin_module}, {0, NULL}};
static PyModuleDef definition = {PyModuleDef_HEAD_INIT,       .m_name = "stein._stein",
                                 .m_size = sizeof(py__state), .m_methods = functions,
                                 .m_slots = module_slots,     .m_traverse = traverse_module,
                                 .m_clear = clear_module};

PyMODINIT_FUNC PyInit__stein(void);
PyMODINIT_FUNC PyInit__stein(void)
{
    return PyModuleDef_Init(&definition);
}
