/* SPDX-License-Identifier: GPL-3.0-or-later
 * odd_setting.c - a reporting record of which a setting is another one than it states.
 *
 * No fit has read these records, so the numbers that all records share, and the variances D of what
 * scatters, are known without them. Around each record's own fit
 *
 *      d = r - Z u,   V = 1 + Z D Z',   z = G'V^-1 d / sqrt(G'V^-1 G)
 *
 * with G what the setting changes. The record of the largest |z| is fitted once more with that
 * setting free, and judged as a fitted record is: Student's t, beyond doubt.
 */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"
#include "verdict.h"

static const double secant = 1e-3;        /* amount of a column [limits] */
static const double least_scatter = 1e-6; /* variance */

typedef struct tried {
    const diag__problem *q;
    const diag__row *row;
    fit__problem p; /* the reporting records, what all share idle */
    double *x, *r;
    double *J, *G; /* derivatives; a column for each setting, behind each other */
    size_t rows;
} tried;

/* what a setting changes, in all records at once */
static stein_status column(tried *o, const lab_candidate *c, double *G, stein_err *err)
{
    int failed = 0;
    fit__problem_try(&o->p, c);
    o->x[o->p.amount] = secant;
    stein_status status = fit__residuals(&o->p, o->x, G, &failed, err);
    o->x[o->p.amount] = 0.0;
    fit__problem_try(&o->p, NULL);
    for (size_t i = 0; i < o->rows; i++) {
        G[i] = failed > 0 ? 0.0 : (G[i] - o->r[i]) / secant;
    }
    return status;
}

/* information and score of n columns in each record: h, to be freed in any case */
static stein_status weigh(const tried *o, const double *x, const double *r, const double **G, int n,
                          lab__shares *h, stein_err *err)
{
    lab__mixed m = {.nf = 0};
    *h = (lab__shares){.n = 0};
    stein_status status = diag__mixed_at(&m, &o->p, x, o->J, r, G, n, err);
    if (status == STEIN_OK) {
        for (int c = 0; c < LAB_SCATTERS; c++) {
            m.D[c] = fmax(o->row->D[c], least_scatter);
        }
        lab__mixed_weigh(&m);
        status = lab__shares_make(h, &m, NULL, 0, err);
    }
    lab__mixed_free(&m);
    return status;
}

/* the largest |z|: which setting of which record */
static stein_status largest(tried *o, diag__odd_setting *to, stein_err *err)
{
    lab__shares h = {.n = 0};
    const double **G = malloc(sizeof *G * (size_t)(o->q->nsetting + 1));
    stein_status status = G != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; status == STEIN_OK && k < o->q->nsetting; k++) {
        const lab_candidate c = diag__bound(o->q, o->row->in, o->q->n + k);
        double *to_k = o->G + (size_t)k * o->rows;
        status = column(o, &c, to_k, err);
        G[k] = to_k;
    }
    status = status == STEIN_OK ? weigh(o, o->x, o->r, G, o->q->nsetting, &h, err) : status;
    int n = o->p.nstroke;
    for (int i = 0; status == STEIN_OK && i < o->q->nsetting * n; i++) {
        double z = h.info[i] > 0.0 ? h.score[i] / sqrt(h.info[i]) : 0.0;
        const lab_data *data = o->p.stroke[i % n].data;
        if (fabs(z) > fabs(to->z) && fit__is_set(data, o->q->candidate[o->q->n + i / n].param[0])) {
            *to = (diag__odd_setting){.setting = i / n,
                                      .record = i % n,
                                      .data = data,
                                      .z = z,
                                      .amount = h.score[i] / h.info[i]};
        }
    }
    lab__shares_free(&h);
    free(G);
    return status;
}

/* the record alone with its setting free: shared numbers as fitted, scatter with its variance */
static stein_status open_one(const tried *o, const diag__odd_setting *to, lab_candidate *cause,
                             fit__problem *one, stein_err *err)
{
    const diag__row *row = o->row;
    lab_dataset data = {1, &o->p.data->stroke[to->record]};
    memcpy(cause, row->cause, sizeof *cause * (size_t)row->h.n);
    cause[row->h.n] =
        diag__bound(o->q, row->in, diag__in_record(o->q, o->q->n + to->setting, to->data->number));
    stein_status status =
        fit__problem_make_with(one, row->in->model, &data, o->p.def, cause, row->h.n + 1, err);
    one->tolerance = o->p.tolerance;
    one->stride = row->p.stride;
    one->simulated = o->p.simulated;
    for (int k = 0; status == STEIN_OK && k < one->nu; k++) {
        fit__unknown *u = &one->unknown[k];
        int class = k < one->np ? -1 : diag__class_of(one, u);
        u->sd *= class >= 0 ? sqrt(fmax(row->D[class], least_scatter)) : 1.0;
    }
    return status;
}

/* sd of its amount where the fit has ended: shared numbers are as uncertain as the fitted records
 * leave them */
static stein_status deviation(const tried *o, fit__problem *one, int amount, fit__end *e,
                              diag__odd_setting *to, stein_err *err)
{
    lab__mixed m = {.nf = 0};
    double I, s, square;
    for (int k = 0; k < one->first_accepted + FIT__NUMBERS * o->row->h.n; k++) {
        fit__unknown *u = &one->unknown[k];
        u->idle = !(o->row->sd[k] > 0.0);
        u->start += u->sd * e->x[k];
        u->sd *= fmin(1.0, o->row->sd[k]);
        e->x[k] = 0.0;
    }
    stein_status status = fit__sensitivities(one, e->x, e->r, e->J, err);
    double *G = status == STEIN_OK ? diag__column(one, e->J, amount) : NULL;
    const double *column[] = {G};
    if (status == STEIN_OK && G == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        one->unknown[amount].idle = 1;
        status = diag__mixed_at(&m, one, e->x, e->J, e->r, column, 1, err);
    }
    if (status == STEIN_OK) { // variances are in the unit of the unknowns
        lab__mixed_weigh(&m);
        int known = lab__mixed_project(&m, &I, &s, &square) && I > 0.0;
        to->sd = known ? o->row->scale / sqrt(I) : (double)INFINITY; // noise as it was estimated
        to->z = to->amount / to->sd;
    }
    lab__mixed_free(&m);
    free(G);
    return status;
}

/* its amount by a fit of the record alone */
static stein_status refine(const tried *o, diag__odd_setting *to, stein_err *err)
{
    lab_candidate cause[DIAG_CAUSES];
    fit__problem one = {.nstroke = 0};
    double *x = NULL;
    if (o->row->h.n == DIAG_CAUSES) { // as many as can act together
        to->setting = -1;
        return STEIN_OK;
    }
    stein_status status = open_one(o, to, cause, &one, err);
    int amount = one.first_accepted + FIT__NUMBERS * o->row->h.n;
    if (status == STEIN_OK) {
        x = calloc((size_t)one.nu + fit__columns(&one) + fit__offset(&one, 1) + 1, sizeof *x);
        status = x != NULL ? STEIN_OK : lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        fit__end e = {.x = x, .J = x + one.nu, .r = x + one.nu + fit__columns(&one)};
        memcpy(x, o->row->x, sizeof *x * (size_t)amount);
        for (int k = 0; k < one.np; k++) {
            one.unknown[k].idle = k != amount;
        }
        x[amount] = to->amount;
        status = diag__descend(&one, &e, DIAG_IF_FAR, err);
        to->amount = x[amount];
        to->left = fit__chi2(&one, e.r) / fmax(1.0, one.samples);
        status = status == STEIN_OK ? deviation(o, &one, amount, &e, to, err) : status;
    }
    free(x);
    fit__problem_free(&one);
    return status;
}

stein_status diag__find_odd_setting(const diag__problem *q, const diag__row *row,
                                    const diag__reported *in, diag__odd_setting *to, stein_err *err)
{
    tried o = {.q = q, .row = row, .p = in->p};
    *to = (diag__odd_setting){.setting = -1};
    if (q->nsetting == 0 || !isfinite(in->rmse)) {
        return STEIN_OK;
    }
    size_t nu = (size_t)o.p.nu;
    o.rows = fit__offset(&o.p, o.p.nstroke);
    fit__unknown *unknown = malloc(sizeof *unknown * nu);
    o.x = malloc(sizeof *o.x * (nu + o.rows * (size_t)(1 + q->nsetting) + fit__columns(&o.p) + 1));
    stein_status status = unknown != NULL && o.x != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) {
        o.r = o.x + nu;
        o.G = o.r + o.rows;
        o.J = o.G + o.rows * (size_t)q->nsetting;
        memcpy(o.x, in->x, sizeof *o.x * nu);
        memcpy(o.r, in->r, sizeof *o.r * o.rows);
        memcpy(unknown, in->p.unknown, sizeof *unknown * nu);
        o.p.unknown = unknown;
        for (int k = 0; k < o.p.np; k++) {
            unknown[k].idle = 1;
        }
        status = fit__sensitivities(&o.p, o.x, o.r, o.J, err);
    }
    status = status == STEIN_OK ? largest(&o, to, err) : status;
    status = status == STEIN_OK && to->setting >= 0 ? refine(&o, to, err) : status;
    free(o.x);
    free(unknown);
    return status;
}

int diag__is_odd(const diag__odd_setting *o, const diag__row *row, int fitted, int tested)
{
    return o->setting >= 0 && fitted > 2 && o->left < diag__near_noise * fmax(1.0, row->chi2_dof) &&
           2.0 * tested * gsl_cdf_tdist_Q(fabs(o->z), fitted - 2) < diag__beyond_doubt;
}

stein_status diag__take_odd_setting(const diag__problem *q, const diag__odd_setting *odd,
                                    lab_diagnosis *o, stein_err *err)
{
    lab_suspect *more = realloc(o->suspect, sizeof *more * (size_t)(o->nsuspect + 1));
    if (more == NULL) {
        return lab__no_memory(err);
    }
    o->suspect = more;
    memmove(more + o->ncause + 1, more + o->ncause,
            sizeof *more * (size_t)(o->nsuspect - o->ncause));
    const lab_candidate c =
        diag__candidate(q, diag__in_record(q, q->n + odd->setting, odd->data->number));
    lab_suspect *s = &more[o->ncause];
    *s = diag__suspect(&c);
    s->possible = s->nnumber = 1;
    s->amount = odd->amount * c.limit;
    s->gain = odd->z * odd->z;
    s->file = odd->data->file;
    s->power.presence = LAB_PRESENT;
    for (int i = 0; i < odd->data->nset; i++) {
        s->stated = odd->data->set[i].param == c.param[0] ? odd->data->set[i].value : s->stated;
    }
    s->number[0] = (lab_cause_number){.unit = c.unit,
                                      .value = s->amount,
                                      .sd = odd->sd * c.limit,
                                      .lo = s->amount - diag__interval * odd->sd * c.limit,
                                      .hi = s->amount + diag__interval * odd->sd * c.limit};
    snprintf(s->number[0].name, sizeof s->number[0].name, "%s", c.effect->size);
    lab__note_changes(s, &c, q->model, NULL, 0);
    o->ncause++;
    o->nsuspect++;
    return STEIN_OK;
}
