/* SPDX-License-Identifier: GPL-3.0-or-later
 * power.c - could it have been seen? One of four answers for every candidate.
 *
 * At the accepted model - the file with the causes in it, or as it is where nothing was found - the
 * strokes are linear in an amount a more [limits of the candidate],
 *
 *      r = F beta + C gamma + G a + Z u + e
 *
 * F the parameters and C the causes' own amounts, both with their priors; Z u the strokes'
 * nuisances and scatter with the variances D found there (mixed.h). With F, C and Z projected out,
 *
 *      P = V^-1 - V^-1 [F C] ([F C]' V^-1 [F C] + 1)^-1 [F C]' V^-1
 *      I = G' P G,   a = G' P r / I,   sd = sqrt(w / I),   z = a / sd
 *
 * without a prior of the amount itself: what these data alone say. w = 1, or chi2/dof and memory of
 * the residual where it is more than stated noise. The verdict names nothing below a gain of 25 -
 * z^2 less the price of an amount that could have been anything up to its limit - and nothing that
 * the best of all candidates reaches by chance in one clean set of a hundred, its z_1 (few strokes
 * tell little of their scatter, so it may be far out). So
 *
 *      named      = max(sqrt(25 + ln(1 + I) / w), z_1)   the z that is named
 *      detectable = (named + 1.645) sd                 an amount that would have been, with 95 %
 *      upper      = max(a, 0) + 1.645 sd               95 % upper limit (|a| where both signs are
 *                                                      possible)
 *
 *   not_testable  there is no column (the part never moves, nobody measured it, it cannot be
 *                 simulated), or 1.645 sd >= limit: other numbers, the causes or the strokes' own
 *                 say the same, and even the largest plausible amount could be 0
 *   present       it is a cause
 *   weak          plausible but weak: it cannot be told from a cause; or z >= 2 in a possible
 *                 direction; or detectable > limit, so a plausible amount may hide
 *   absent        the rest: it would have been named at its limit, and nothing points to it
 *
 * One in twenty absent ones has z >= 2 by chance (one in forty where only one sign is possible).
 * Where no fit has converged nobody is judged. This is Saris and Satorra's use of score, expected
 * amount and power (1987). No simulations: the columns are those of the last ranking.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_linalg.h>

#include "searching.h"

enum { OWN = FIT__NUMBERS };
static const double sure = 1.645, points_to = 2.0;
static const double visible = 0.01; /* RMS change at the limit [noise] */

const char *lab_presence_text(lab_presence presence)
{
    static const char *const text[] = {NULL, "present", "weak", "absent", "not_testable"};
    return text[presence];
}

static void cannot(diag__suspect *s, const char *because)
{
    s->s.power = (lab_power){LAB_NOT_TESTABLE, NAN, NAN, NAN, NAN, because};
}

/* candidates with a column; the reason of the others. @return their number */
static int columns(const diag *d, const double **column, int *index, int led)
{
    int n = 0;
    size_t rows = fit__offset(&d->p, d->p.nstroke);
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        double sum = 0.0;
        // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): there are n of them
        for (size_t k = 0; s->G != NULL && k < rows; k++) {
            sum += s->G[k] * s->G[k];
        }
        if (i < led) {
            continue;
        }
        if (s->never != NULL || s->unseen != NULL || s->G == NULL) {
            cannot(s, s->never != NULL    ? s->never
                      : s->unseen != NULL ? s->unseen
                                          : "it was not simulated");
        } else if (!(sqrt(sum / fmax(1.0, d->p.samples)) > visible)) {
            cannot(s, "it would not show in these strokes");
        } else {
            column[n] = s->G;
            index[n++] = i;
        }
    }
    return n;
}

/* I and G'Pr of candidate k, the first ne columns projected out. @param L  their factor */
static void project(const lab__mixed *m, const gsl_matrix *L, int ne, int k, double *info,
                    double *score)
{
    int n = m->ncol, r = n - 1;
    gsl_vector *t = gsl_vector_alloc((size_t)ne + 1);
    *info = m->A[k * n + k];
    *score = m->A[k * n + r];
    if (t == NULL || ne == 0) {
        gsl_vector_free(t);
        return;
    }
    gsl_vector_view v = gsl_vector_subvector(t, 0, (size_t)ne);
    for (int i = 0; i < ne; i++) {
        gsl_vector_set(&v.vector, (size_t)i, m->A[i * n + k]);
    }
    gsl_linalg_cholesky_svx(L, &v.vector);
    for (int i = 0; i < ne; i++) {
        *info -= gsl_vector_get(&v.vector, (size_t)i) * m->A[i * n + k];
        *score -= gsl_vector_get(&v.vector, (size_t)i) * m->A[i * n + r];
    }
    gsl_vector_free(t);
}

/* the z from which on it is named, of an amount with that sd [limits] */
static double named_from(const diag *d, double sd, double wide)
{
    return fmax(d->z_by_chance, sqrt(diag__least_gain + log1p(wide / (sd * sd)) / wide));
}

/* @param raw  information before anything is projected out; amounts count in limits */
static void judge(const diag *d, diag__suspect *s, int rival, double info, double score, double raw,
                  double wide)
{
    const lab_candidate *c = &s->s.candidate;
    double sd = info > 1e-9 * raw ? sqrt(wide / info) : INFINITY;
    if (!(sure * sd < 1.0)) {
        cannot(s, sure * sqrt(wide / raw) < 1.0
                      ? "what it changes, other numbers, the causes or the strokes' own change too"
                      : "too little of it shows in these strokes");
        s->s.power.presence = rival ? LAB_WEAK : LAB_NOT_TESTABLE;
        s->s.power.because = rival ? "it could stand in the cause's place" : s->s.power.because;
        return;
    }
    double z = named_from(d, sd, wide), a = score / info,
           toward = c->effect->both_signs ? fabs(a) : a;
    lab_power *p = &s->s.power;
    *p = (lab_power){.presence = LAB_ABSENT,
                     .amount = a * c->limit,
                     .sd = sd * c->limit,
                     .detectable = (z + sure) * sd * c->limit,
                     .upper = (fmax(toward, 0.0) + sure * sd) * c->limit,
                     .because = "it would have been named at its limit"};
    if (rival || toward >= points_to * sd || (z + sure) * sd > 1.0) {
        p->presence = LAB_WEAK;
        p->because = rival                      ? "it could stand in the cause's place"
                     : toward >= points_to * sd ? "something points to it"
                                                : "a plausible amount of it may hide";
    }
}

void diag__present(const diag *d, lab_suspect *s, double sd, double wide)
{
    s->power = (lab_power){.presence = LAB_PRESENT,
                           .amount = s->amount,
                           .sd = sd,
                           .detectable = (named_from(d, sd / s->candidate.limit, wide) + sure) * sd,
                           .upper = fabs(s->amount) + sure * sd,
                           .because = "it is a cause"};
}

/* the leader's own columns, to be projected out: those of earlier causes are among the parameters.
 * @return their number, -1: out of memory */
static int own_columns(diag *d, diag__suspect *s, double **own)
{
    int n = 0;
    if (s == NULL || s->J == NULL) {
        return 0;
    }
    const fit__problem *p = diag__problem(d, s);
    for (int a = 0; a < OWN; a++) {
        if (a == 0 || s->s.candidate.side[a - 1].param >= 0) {
            own[n] = diag__column(p, s->J, p->amount + a);
            if (own[n++] == NULL) {
                return -1;
            }
        }
    }
    return n;
}

static stein_status judge_all(diag *d, const lab__mixed *m, int nown, const int *index, int n,
                              double wide, stein_err *err)
{
    int ne = m->nf + nown;
    gsl_matrix *L = gsl_matrix_alloc((size_t)ne + 1, (size_t)ne + 1);
    if (L == NULL) {
        return lab__no_memory(err);
    }
    gsl_matrix_view v =
        gsl_matrix_submatrix(L, 0, 0, (size_t)(ne > 0 ? ne : 1), (size_t)(ne > 0 ? ne : 1));
    for (int i = 0; i < ne; i++) {
        for (int k = 0; k < ne; k++) {
            gsl_matrix_set(&v.matrix, (size_t)i, (size_t)k,
                           m->A[i * m->ncol + k] + (i == k ? 1.0 : 0.0));
        }
    }
    int nrival = diag__rivals(d);
    int ok = ne == 0 || gsl_linalg_cholesky_decomp1(&v.matrix) == 0;
    for (int i = 0; ok && i < n; i++) {
        int k = ne + i, rival = index[i] > 0 && index[i] <= nrival;
        double info, score;
        project(m, &v.matrix, ne, k, &info, &score);
        judge(d, &d->suspect[index[i]], rival, info, score, m->A[k * m->ncol + k], wide);
    }
    gsl_matrix_free(L);
    return STEIN_OK;
}

/* at the end of the leader's fit, or of the null fit */
static stein_status at_the_end(diag *d, diag__suspect *lead, const double **column, int *index,
                               stein_err *err)
{
    const fit__problem *p = lead != NULL ? diag__problem(d, lead) : &d->p;
    const double *r = lead != NULL ? lead->r : d->r;
    double *own[OWN] = {NULL};
    int nown = own_columns(d, lead, own);
    lab__mixed m = {.nf = 0};
    stein_status status = nown >= 0 ? STEIN_OK : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < nown; i++) {
        column[i] = own[i];
    }
    int n = status == STEIN_OK ? columns(d, column + nown, index, lead != NULL) : 0;
    if (status == STEIN_OK) {
        status = diag__mixed_at(&m, p, lead != NULL ? lead->x : d->x, lead != NULL ? lead->J : d->J,
                                r, column, nown + n, err);
    }
    if (status == STEIN_OK) {
        double wide = lead != NULL ? diag__excess(d, lead) : fmax(1.0, fit__chi2_dof(p, r));
        memcpy(m.D, lead != NULL ? lead->D : d->null_D, sizeof m.D);
        lab__mixed_weigh(&m);
        status = judge_all(d, &m, nown, index, n, wide, err);
    }
    lab__mixed_free(&m);
    for (int i = 0; i < OWN; i++) {
        free(own[i]);
    }
    return status;
}

stein_status diag__power(diag *d, int led, stein_err *err)
{
    if (d->out->verdict == LAB_VERDICT_NOT_CONVERGED) {
        return STEIN_OK;
    }
    const double **column = malloc(sizeof *column * (size_t)(d->n + OWN + 1));
    int *index = malloc(sizeof *index * (size_t)(d->n + 1));
    stein_status status = column != NULL && index != NULL
                              ? at_the_end(d, led ? &d->suspect[0] : NULL, column, index, err)
                              : lab__no_memory(err);
    free(column);
    free(index);
    return status;
}
