/* SPDX-License-Identifier: GPL-3.0-or-later
 * heldout.c - error on strokes that nothing was fitted to.
 *
 * What all strokes share stays as it was fitted; a stroke's own - trigger, offsets, and what
 * differs by itself, with the variances the fit has found - is fitted to it, as no model could know
 * it. Both models get the same help. The error is the RMS of what is left, in units of noise.
 *
 * That help can hide a cause that acts like what differs by itself: a gain of the drive is a drive
 * that differs to one side in every stroke. Whether a cause pays is therefore asked of the
 * likelihood, in which differences have their price.
 *
 * The gain is the ratio of two such errors. Its interval is a bootstrap over strokes: frames of
 * one stroke are no independent witnesses.
 */
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "searching.h"

enum { DRAWS = 2000 };
static const double aside = 1.5; /* of another start, in sd of the scatter */

/* the held-out strokes of a model, in which only their own unknowns move */
static stein_status make_problem(diag *d, const lab_model *model, const lab_dataset *data,
                                 const double *D, fit__problem *p, stein_err *err)
{
    stein_status status =
        fit__problem_make_with(p, model, data, &d->fit_def, d->accepted, d->naccepted, err);
    if (status != STEIN_OK) {
        return status;
    }
    p->tolerance = d->p.tolerance;
    for (int k = p->np; k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        u->sd *= u->kind == FIT__SCATTER ? sqrt(fmax(D[u->index - FIT__JOINTS], 1e-6)) : 1.0;
    }
    return STEIN_OK;
}

/* from where its own unknowns are at 0, but for the one that is at `first`
 * @param k  of the unknowns; 0: all are at 0 */
static stein_status follow_from(diag *d, fit__problem *p, const double *shared, int k, double first,
                                fit__end *e, stein_err *err)
{
    memcpy(e->x, shared, sizeof *shared * (size_t)p->np);
    memset(e->x + p->np, 0, sizeof *shared * (size_t)(p->nu - p->np));
    e->x[k] = k > 0 ? first : e->x[k];
    stein_status status = diag__follow(d, p, e, err);
    e->objective =
        status == STEIN_OK ? fit__chi2(p, e->r) + fit__priors(p, e->x) : (double)INFINITY;
    return status;
}

/* A stray is asked again, with more and with less of everything that differs from stroke to stroke:
 * which events it has depends on that, and no step leads across one. The best start is kept. */
static stein_status other_starts(diag *d, fit__problem *p, const double *shared, double middle,
                                 fit__end *e, stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    double *room = malloc(sizeof *room * (nu + rows + 1));
    fit__end t = {.x = room, .r = room != NULL ? room + nu : NULL, .J = e->J};
    stein_status status = room != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = p->np; status == STEIN_OK && k < p->nu; k++) {
        for (double first = -aside; p->unknown[k].kind == FIT__SCATTER && status == STEIN_OK &&
                                    first <= aside && diag__is_stray(p, e->r, 0, middle);
             first += 2.0 * aside) {
            stein_err why;
            t.fits = 0;
            status = follow_from(d, p, shared, k, first, &t, &why) == STEIN_ENOMEM
                         ? lab__no_memory(err)
                         : STEIN_OK;
            e->fits += t.fits;
            if (status == STEIN_OK && t.objective < e->objective) {
                memcpy(e->x, t.x, sizeof *t.x * nu);
                memcpy(e->r, t.r, sizeof *t.r * rows);
                e->objective = t.objective;
            }
        }
    }
    free(room);
    return status;
}

/* -2 log likelihood of a stroke at the end of its fit, its own unknowns marginalised (Laplace);
 * what differs by itself is Student's, as its variance is known from n strokes only
 * @return OK (INFINITY where it cannot be simulated next to that), ENOMEM */
static stein_status deviance(const fit__problem *p, const fit__end *e, int n, double *value,
                             stein_err *err)
{
    double nu = fmax(1.0, n - 1.0);
    stein_err why = {STEIN_OK, ""};
    stein_status status = fit__sensitivities(p, e->x, e->r, e->J, &why);
    *value = INFINITY;
    if (status == STEIN_OK) {
        lab__mixed m = {.nf = 0};
        status = diag__mixed_at(&m, p, e->x, e->J, e->r, NULL, 0, &why);
        if (status == STEIN_OK) {
            lab__mixed_weigh(&m);
            *value = fit__chi2(p, e->r) + fit__priors(p, e->x) + m.logdet;
            for (int k = p->np; k < p->nu; k++) {
                double square = e->x[k] * e->x[k];
                *value += p->unknown[k].kind == FIT__SCATTER
                              ? (nu + 1.0) * stein__log_of(1.0 + square / nu) - square
                              : 0.0;
            }
        }
        lab__mixed_free(&m);
    }
    return fit__forgive(status, err);
}

/* strokes that are fitted one by one: in one fit they would wait for the slowest, and one that has
 * far to go stops all */
typedef struct singles {
    diag *d;
    const double *D;       /* variances of scatter in those of the prior */
    const fit__problem *p; /* of all strokes; x and r are of all of them, in and out */
    double *x, *r;
    double middle;      /* chi2 per sample of others: strays among them are begun anew */
    double *deviance;   /* [nstroke] out; NULL: not wanted */
    int *stroke, *fits; /* [n] which they are, and how many fits each took */
} singles;

static stein_status fit_one(void *ctx, int i, fit__pool *pool, stein_err *err)
{
    const singles *one_by_one = ctx;
    diag *d = one_by_one->d;
    const fit__problem *p = one_by_one->p;
    double *x = one_by_one->x, *r = one_by_one->r;
    int stroke = one_by_one->stroke[i];
    const fit__stroke *t = &p->stroke[stroke];
    lab_dataset one = {1, &p->data->stroke[stroke]};
    fit__problem own;
    stein_status status = make_problem(d, p->model, &one, one_by_one->D, &own, err);
    double *room =
        status == STEIN_OK ? calloc((size_t)own.nu + fit__columns(&own) + 1, sizeof *room) : NULL;
    if (status == STEIN_OK && room == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        fit__end e = {.x = room, .J = room + own.nu, .r = r + fit__offset(p, stroke)};
        fit__problem_try(&own, p->effect);
        for (int k = 0; k < own.np; k++) {
            own.unknown[k].idle = 1;
        }
        own.horizon = p->horizon;
        own.pool = pool;
        status = follow_from(d, &own, x, 0, 0.0, &e, err);
        status =
            status == STEIN_OK ? other_starts(d, &own, x, one_by_one->middle, &e, err) : status;
        memcpy(x + t->first, room + own.np, sizeof *x * (size_t)t->own);
        if (status == STEIN_OK && one_by_one->deviance != NULL) {
            status = deviance(&own, &e, d->p.nstroke, &one_by_one->deviance[stroke], err);
        }
        one_by_one->fits[i] = e.fits;
    }
    free(room);
    fit__problem_free(&own);
    return status;
}

/* those that are marked, side by side. @param fits  counts them */
static stein_status fit_singles(singles *s, const unsigned char *marked, int *fits, stein_err *err)
{
    size_t most = (size_t)s->p->nstroke;
    int n = 0, *room = calloc(2 * most + 1, sizeof *room);
    if (room == NULL) {
        return lab__no_memory(err);
    }
    s->stroke = room;
    s->fits = room + most;
    for (int i = 0; i < s->p->nstroke; i++) {
        if (marked[i]) {
            s->stroke[n++] = i;
        }
    }
    stein_status status = n > 0 ? fit__together(s->p, n, fit_one, s, err) : STEIN_OK;
    for (int i = 0; i < n; i++) {
        *fits += s->fits[i];
    }
    free(room);
    return status;
}

stein_status diag__fit_strokes(diag *d, const fit__problem *p, const unsigned char *marked,
                               double middle, fit__end *e, stein_err *err)
{
    static const double as_stated[DIAG_CLASSES] = {1.0, 1.0, 1.0};
    singles s = {.d = d, .D = as_stated, .p = p, .x = e->x, .r = e->r, .middle = middle};
    return fit_singles(&s, marked, &e->fits, err);
}

/* every stroke by itself, and those that are strays among the others with more care */
static stein_status fit_each(diag *d, const double *D, diag__held *to, stein_err *err)
{
    const fit__problem *p = &to->p;
    size_t n = (size_t)p->nstroke;
    double *room = malloc(sizeof *room * (2 * n + 1));
    unsigned char *marked = malloc(n + 1);
    if (room == NULL || marked == NULL) {
        free(room);
        free(marked);
        return lab__no_memory(err);
    }
    singles s = {.d = d, .D = D, .p = p, .x = to->x, .r = to->r};
    s.deviance = room + n;
    s.middle = INFINITY;
    memset(marked, 1, n);
    stein_status status = fit_singles(&s, marked, &d->out->fits, err);
    if (status == STEIN_OK) {
        s.middle = diag__middle(p, to->r, room);
        for (int i = 0; i < p->nstroke; i++) {
            marked[i] = diag__is_stray(p, to->r, i, s.middle) != 0;
        }
        status = fit_singles(&s, marked, &d->out->fits, err);
    }
    to->deviance = 0.0;
    for (int i = 0; status == STEIN_OK && i < p->nstroke; i++) {
        to->deviance += s.deviance[i];
    }
    free(room);
    free(marked);
    return status;
}

stein_status diag__held_out(diag *d, const diag__suspect *s, diag__held *to, stein_err *err)
{
    const double *D = s != NULL ? s->D : d->null_D;
    const lab_model *model = s != NULL && s->model != NULL ? s->model : d->model;
    *to = (diag__held){.rmse = NAN, .deviance = NAN};
    const lab_dataset *data = model != d->model ? s->held_data : d->held_data;
    stein_status status = make_problem(d, model, data, D, &to->p, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__problem *p = &to->p;
    size_t rows = fit__offset(p, p->nstroke);
    to->x = calloc((size_t)p->nu + rows + 1, sizeof *to->x);
    if (to->x == NULL) {
        return lab__no_memory(err);
    }
    to->r = to->x + p->nu;
    memcpy(to->x, s != NULL ? s->x : d->x, sizeof *to->x * (size_t)p->np);
    if (s != NULL) {
        fit__problem_try(p, &s->s.candidate);
    }
    for (int k = 0; k < p->np; k++) {
        p->unknown[k].idle = 1;
    }
    status = fit_each(d, D, to, err);
    if (status == STEIN_OK) {
        to->rmse = sqrt(fit__chi2(p, to->r) / fmax(1.0, p->samples));
    }
    return status;
}

void diag__held_free(diag__held *h)
{
    fit__problem_free(&h->p);
    free(h->x);
}

/* ---- gain ---- */

/* squares and samples of a channel (-1: all) and phase (NULL: all) of a stroke */
static void sums(const fit__problem *p, const double *r, const char *const *phase, int s,
                 int channel, const char *want, double *square, double *n)
{
    const fit__stroke *t = &p->stroke[s];
    *square = *n = 0.0;
    for (int i = 0; i < t->nch * t->n; i++) {
        int c = i / t->n, at = (int)diag__row(p, s) + i % t->n;
        double unit = channel < 0 ? 1.0 : t->noise[c];
        if (isfinite(t->y[i]) && (channel < 0 || t->channel[c] == channel) &&
            (want == NULL || phase[at] == want)) {
            double v = unit * r[fit__offset(p, s) + (size_t)i];
            *square += v * v;
            *n += 1.0;
        }
    }
}

static stein_status interval(const double *before, const double *after, int n, lab_gain *g)
{
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double *ratio = malloc(sizeof *ratio * DRAWS);
    if (rng != NULL && ratio != NULL) {
        gsl_rng_set(rng, 1788);
        for (int d = 0; d < DRAWS; d++) {
            double b = 0.0, a = 0.0;
            for (int i = 0; i < n; i++) {
                unsigned long k = gsl_rng_uniform_int(rng, (unsigned long)n);
                b += before[k];
                a += after[k];
            }
            ratio[d] = b > 0.0 ? sqrt(a / b) : 1.0;
        }
        gsl_sort(ratio, 1, DRAWS);
        g->lo = ratio[(int)(0.025 * DRAWS)];
        g->hi = ratio[(int)(0.975 * DRAWS)];
    }
    stein_status status = rng != NULL && ratio != NULL ? STEIN_OK : STEIN_ENOMEM;
    if (rng != NULL) {
        gsl_rng_free(rng);
    }
    free(ratio);
    return status;
}

/* @return samples */
static int measure(const diag__held *before, const diag__held *after, const char *const *phase,
                   int channel, const char *want, lab_gain *g, stein_err *err, stein_status *status)
{
    const fit__problem *p = &before->p;
    double *b = malloc(sizeof *b * (size_t)(2 * p->nstroke + 1));
    double *a = b + (b != NULL ? p->nstroke : 0), sb = 0.0, sa = 0.0, all = 0.0;
    if (b == NULL) {
        *status = lab__no_memory(err);
        return 0;
    }
    for (int s = 0; s < p->nstroke; s++) {
        double n = 0.0;
        sums(p, before->r, phase, s, channel, want, &b[s], &n);
        sums(&after->p, after->r, phase, s, channel, want, &a[s], &n);
        sb += b[s];
        sa += a[s];
        all += n;
    }
    g->samples = (int)all;
    g->rmse_before = all > 0.0 ? sqrt(sb / all) : NAN;
    g->rmse_after = all > 0.0 ? sqrt(sa / all) : NAN;
    g->ratio = sb > 0.0 ? sqrt(sa / sb) : NAN;
    g->lo = g->hi = NAN;
    if (all > 0.0 && interval(b, a, p->nstroke, g) != STEIN_OK) {
        *status = lab__no_memory(err);
    }
    free(b);
    return g->samples;
}

stein_status diag__ratio(const diag__held *without, const diag__held *with, lab_suspect *cause,
                         stein_err *err)
{
    lab_gain g = {.ratio = NAN, .lo = NAN, .hi = NAN};
    stein_status status = STEIN_OK;
    if (isfinite(without->rmse) && isfinite(with->rmse)) {
        measure(without, with, NULL, -1, NULL, &g, err, &status);
    }
    cause->own_ratio = g.ratio;
    cause->own_lo = g.lo;
    cause->own_hi = g.hi;
    return status;
}

stein_status diag__gain(lab_diagnosis *out, const diag__held *before, const diag__held *after,
                        const char *const *phase, stein_err *err)
{
    const fit__problem *p = &before->p;
    const stein_model *m = lab_equations(p->model);
    stein_status status = STEIN_OK;
    out->gain.noise = 1.0;
    measure(before, after, phase, -1, NULL, &out->gain, err, &status);
    out->gains = calloc((size_t)m->nchannel * (DIAG_PHASES + 1) + 1, sizeof *out->gains);
    if (out->gains == NULL) {
        return lab__no_memory(err);
    }
    for (int c = 0; status == STEIN_OK && c < m->nchannel; c++) {
        double noise = NAN;
        for (int k = 0; k < p->stroke[0].nch; k++) {
            noise = p->stroke[0].channel[k] == c ? p->stroke[0].noise[k] : noise;
        }
        for (int f = -1; isfinite(noise) && f < DIAG_PHASES; f++) {
            lab_gain *g = &out->gains[out->ngain];
            *g = (lab_gain){.channel = m->channels[c].name,
                            .unit = m->channels[c].unit,
                            .phase = f < 0 ? NULL : diag__phase[f],
                            .noise = noise};
            out->ngain += measure(before, after, phase, c, g->phase, g, err, &status) > 0;
        }
    }
    return status;
}
