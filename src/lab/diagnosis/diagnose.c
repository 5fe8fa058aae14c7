/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.c - from a mechanism file and records to a verdict.
 *
 *   audit      noise, rests and slips of the records, before anything is fitted
 *   cut        records of chaotic motion, into windows (windows.c)
 *   split      records that are fitted, and those that report, read after the table is closed
 *   search     the table of hypotheses (search/)
 *   conclude   the closed table, to all that is reported (conclude.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosis.h"

lab_diagnose_def lab_diagnose_def_default(void)
{
    return (lab_diagnose_def){.threads = 1};
}

/* ---- records ---- */

int diag__reports(int record, int n)
{
    return n >= DIAG_HOLD_EVERY && record % DIAG_HOLD_EVERY == DIAG_HOLD_EVERY - 1;
}

static stein_status split(diagnosis *d, const lab_dataset *data, stein_err *err)
{
    size_t n = (size_t)data->n;
    lab_dataset *fit = &d->fitted, *report = &d->reporting;
    fit->stroke = calloc(n + 1, sizeof(lab_data *));
    report->stroke = calloc(n + 1, sizeof(lab_data *));
    if (fit->stroke == NULL || report->stroke == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < data->n; s++) {
        int record = d->cut ? d->record_of[s] : s;
        int held = d->blocks                  ? s % 2
                   : d->def->held_out != NULL ? d->def->held_out[record]
                                              : diag__reports(s, data->n);
        lab_dataset *to = held ? report : fit;
        to->stroke[to->n++] = data->stroke[s];
    }
    d->out->nfit = fit->n;
    d->out->nheld = report->n;
    return fit->n > 0 ? STEIN_OK
                      : lab__fail(err, STEIN_EINVAL,
                                  "%d records are held out and none is to fit to", report->n);
}

/* a line for the findings, which takes it over */
static stein_status add_finding(lab_diagnosis *o, char *line, int first, stein_err *err)
{
    char **more = realloc(o->finding, sizeof *more * (size_t)(o->nfinding + 1));
    o->finding = more != NULL ? more : o->finding;
    if (line == NULL || more == NULL) {
        free(line);
        return lab__no_memory(err);
    }
    if (first) {
        memmove(o->finding + 1, o->finding, sizeof *o->finding * (size_t)o->nfinding);
    }
    o->finding[first ? 0 : o->nfinding] = line;
    o->nfinding++;
    return STEIN_OK;
}

/* a line that is reported at once, and the first of the findings. Frees it. */
static stein_status tell(diagnosis *d, char *line, stein_err *err)
{
    if (line != NULL && d->def->report != NULL) {
        d->def->report(d->def->ctx, line);
    }
    return add_finding(d->out, line, 1, err);
}

/* of records, the first of which is given: "run_1.csv and 2 more: ..." */
static stein_status note_audit(diagnosis *d, lab_audit *const *list, int n, int record,
                               const char *text, stein_err *err)
{
    const char *file = list[record]->data->file;
    int more = lab_audit_repeats(list, n, record, text);
    if (more < 0) {
        return STEIN_OK; // told with an earlier one
    }
    return add_finding(d->out,
                       more > 0 ? lab__text("%s and %d more: %s", file, more, text)
                                : lab__text("%s: %s", file, text),
                       0, err);
}

static stein_status audit(diagnosis *d, const lab_dataset *data, stein_err *err)
{
    lab_audit **list = calloc((size_t)data->n + 1, sizeof(lab_audit *));
    stein_status status = list != NULL ? STEIN_OK : lab__no_memory(err);
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        status = lab_audit_create(&list[s], data->stroke[s], err);
    }
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        for (int i = 0; status == STEIN_OK && i < list[s]->nfinding; i++) {
            status = note_audit(d, list, data->n, s, list[s]->finding[i], err);
        }
    }
    for (int s = 0; list != NULL && s < data->n; s++) {
        lab_audit_destroy(list[s]);
    }
    free(list);
    return status;
}

/* Slips that the records show before anything is fitted: units, signs, columns, the clock. With a
 * grave one no verdict on the mechanism could be trusted, so none is given. */
static stein_status check_slips(diagnosis *d, const lab_model *model, const lab_dataset *data,
                                stein_err *err)
{
    lab_doubts *doubts = NULL;
    stein_status status = lab_doubts_find(&doubts, model, data, err);
    for (int i = status == STEIN_OK ? doubts->n - 1 : -1; status == STEIN_OK && i >= 0; i--) {
        status = add_finding(d->out, lab__text("%s", doubts->item[i].text), 1, err);
    }
    if (status == STEIN_OK && doubts->grave) {
        d->out->verdict = LAB_VERDICT_UNUSABLE_MODEL;
        status = diag__name_sign_error(model, data, doubts, d->out, err);
        int which = 0;
        while (!doubts->item[which].grave) {
            which++;
        }
        const lab_doubt *grave = &doubts->item[which];
        int either = grave->kind == LAB_DOUBT_SIGN && grave->other >= 0;
        snprintf(d->out->slip, sizeof d->out->slip, "%s", grave->brief);
        snprintf(d->out->reason, sizeof d->out->reason,
                 "The records do not mean what they say: %s%s", grave->text,
                 d->out->ncause > 0 ? ". extended.yaml has the gain -1 that fits"
                 : either           ? ". These records cannot tell which of the two it is"
                                    : "");
    }
    lab_doubts_free(doubts);
    return status;
}

/* records that are too long to be followed, or too few: their windows take their places */
static stein_status cut(diagnosis *d, const lab_model *model, const lab_dataset *data,
                        stein_err *err)
{
    char *line = NULL;
    stein_err why;
    stein_status status = diag__cut(d, model, data, &line, &why);
    if (status != STEIN_OK || line == NULL) {
        return fit__forgive(status, err);
    }
    return tell(d, line, err);
}

static stein_status check_step(diagnosis *d, stein_err *err)
{
    char *line = NULL;
    stein_status status = diag__check_step(&d->q.null, &line, err);
    if (status != STEIN_OK || line == NULL) {
        return status;
    }
    return tell(d, line, err);
}

/* does a record state another band of an input? */
static int states_another(const lab_dataset *data, int input, double hz)
{
    int yes = 0;
    for (int s = 0; s < data->n; s++) {
        for (int i = 0; i < data->stroke[s]->ncolumn; i++) {
            const lab_column *c = &data->stroke[s]->column[i];
            yes |= c->role == LAB_INPUT && c->index == input && c->smooth > 0.0 && c->smooth != hz;
        }
    }
    return yes;
}

/* up to which frequency measured motions are taken as motion, where that is not as their noise has
 * it */
static stein_status tell_bands(diagnosis *d, stein_err *err)
{
    const stein_model *m = lab_equations(d->q.model);
    stein_status status = STEIN_OK;
    for (int i = 0; i < m->ninput && status == STEIN_OK; i++) {
        double hz = d->q.fit_def.smooth != NULL ? d->q.smooth[i] : (double)NAN;
        if (m->inputs[i].kind != STEIN_INPUT_MOTION || !isfinite(hz)) {
            continue;
        }
        int asked = d->def->smooth > 0.0, another = states_another(&d->fitted, i, hz);
        const char *where = !another ? ""
                            : asked  ? ", in place of what files state"
                                     : " where files state nothing";
        char *line =
            lab__text("%s: smoothed to half at %.3g Hz%s%s", m->inputs[i].name, hz, where,
                      asked ? "" : "; what is faster does not show in the measured forces");
        status = tell(d, line, err);
    }
    return status;
}

/* measured times of events for which the file's own numbers make no event */
static stein_status tell_lacking(diagnosis *d, stein_err *err)
{
    const fit__problem *p = &d->q.null;
    int *lacking = calloc((size_t)p->nstroke + 1, sizeof *lacking), records = 0, events = 0;
    double *x = calloc((size_t)p->nu + 1, sizeof *x);
    const char *first = NULL;
    stein_status status =
        lacking != NULL && x != NULL ? fit__lacking(p, x, lacking, err) : lab__no_memory(err);
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        first = first == NULL && lacking[s] > 0 ? p->stroke[s].data->file : first;
        records += lacking[s] > 0;
        events += lacking[s];
    }
    free(lacking);
    free(x);
    if (status != STEIN_OK || records == 0) {
        return status;
    }
    char *line = lab__text("%s%s: %d of the measured events do not happen with the file's own "
                           "numbers; each counts as far off as the last one is",
                           first, records > 1 ? " and others" : "", events);
    return tell(d, line, err);
}

/* Signs, zeros, units and planes with which the records' beginnings would follow. At another pace
 * they are a film in slow motion, or another mechanism's: no effect is searched for. */
static stein_status check_setup(diagnosis *d, stein_err *err)
{
    fit__finding *list = NULL;
    int n = 0;
    stein_err why;
    stein_status status = fit__setup(&d->q.null, &list, &n, &why);
    for (int i = n - 1; status == STEIN_OK && i >= 0; i--) {
        status = tell(d, lab__text("%s", list[i].text), err);
    }
    if (status == STEIN_OK && n > 0) {
        snprintf(d->suspicion, sizeof d->suspicion, "%s", list[0].text);
        if (fabs(log(list[0].pace)) > log(diag__other_pace)) {
            d->out->verdict = LAB_VERDICT_UNUSABLE_MODEL;
            snprintf(d->out->slip, sizeof d->out->slip,
                     "The records move at another pace than the mechanism");
            snprintf(d->out->reason, sizeof d->out->reason,
                     "The records are no motion of this mechanism: %s", list[0].text);
        }
    }
    fit__setup_free(list, n);
    return fit__forgive(status, err);
}

static stein_status search(diagnosis *d, const char *file, const lab_model *model, stein_err *err)
{
    stein_status status = diag__problem_open(&d->q, file, model, &d->fitted, d->def, err);
    if (status == STEIN_OK && d->def->trace != NULL) {
        d->q.trace = fopen(d->def->trace, "w");
        if (d->q.trace == NULL) {
            return lab__fail(err, STEIN_EIO, "%s: cannot be written", d->def->trace);
        }
    }
    d->out->samples = d->q.null.samples;
    status = status == STEIN_OK ? tell_bands(d, err) : status;
    status = status == STEIN_OK ? check_step(d, err) : status;
    status = status == STEIN_OK ? tell_lacking(d, err) : status;
    status = status == STEIN_OK ? check_setup(d, err) : status;
    diag__progress(d, 0.05, "search for causes");
    int usable = d->out->verdict != LAB_VERDICT_UNUSABLE_MODEL;
    status = status == STEIN_OK && usable ? diag__search(&d->q, &d->t, err) : status;
    if (d->q.trace != NULL && fclose(d->q.trace) != 0 && status == STEIN_OK) {
        status = lab__fail(err, STEIN_EIO, "%s: cannot be written", d->def->trace);
    }
    return status;
}

stein_status lab_diagnose(lab_diagnosis **out, const char *file, const lab_model *model,
                          const lab_dataset *data, const lab_diagnose_def *def, stein_err *err)
{
    lab_diagnose_def none = lab_diagnose_def_default();
    diagnosis d = {.def = def != NULL ? def : &none, .before.rmse = NAN, .after.rmse = NAN};
    double begin = diag__clock();
    d.out = calloc(1, sizeof *d.out);
    if (d.out == NULL) {
        return lab__no_memory(err);
    }
    d.out->remainder = d.out->share = d.out->p = NAN;
    d.out->chi2_dof_before = d.out->chi2_dof_after = NAN;
    d.out->gain.ratio = d.out->gain.rmse_before = d.out->gain.rmse_after = NAN;
    d.out->gain.lo = d.out->gain.hi = NAN;
    d.out->noise_floor = 1.0;
    d.out->nfile = data->n;
    diag__progress(&d, 0.0, "audit");
    stein_status status = audit(&d, data, err);
    status = status == STEIN_OK ? check_slips(&d, model, data, err) : status;
    int usable = d.out->verdict != LAB_VERDICT_UNUSABLE_MODEL;
    status = status == STEIN_OK && usable ? cut(&d, model, data, err) : status;
    if (status == STEIN_OK && usable) {
        d.out->in_pieces = d.cut;
        status = split(&d, d.cut ? d.windows : data, err);
        status = status == STEIN_OK ? search(&d, file, model, err) : status;
        usable = d.out->verdict != LAB_VERDICT_UNUSABLE_MODEL;
        status = status == STEIN_OK && usable ? diag__conclude(&d, err) : status;
    }
    d.out->seconds = diag__clock() - begin;
    d.out->fits = d.t.n;
    d.out->strokes_simulated = (int)d.q.strokes;
    diag__laws_free(&d.laws);
    diag__reported_free(&d.before);
    diag__reported_free(&d.after);
    diag__table_free(&d.t);
    diag__problem_close(&d.q);
    d.out->pieces = d.windows;
    free(d.record_of);
    free(d.fitted.stroke);
    free(d.reporting.stroke);
    if (status == STEIN_OK) {
        diag__progress(&d, 1.0, "done");
        *out = d.out;
    } else {
        lab_diagnosis_destroy(d.out);
    }
    return lab__stop_end(status, &(lab__stop){d.def->stop, d.def->ctx}, err);
}
