/* SPDX-License-Identifier: GPL-3.0-or-later
 * detectability.c - detectability: one of four results for every candidate that is no cause.
 *
 * At the best row the records are linear in an amount a [limits] beside the causes (linear.c), with
 * information I and score s once everything else, the causes' amounts among it, is projected out:
 *
 *      a = s/I,   sd = I^-1/2,   z = a/sd
 *      named      = sqrt(25 + ln(1 + I))         the z from which on the judge names it
 *      detectable = (named + 1.645) sd               an amount that would have been, with 95 %
 *      upper      = max(a, 0) + 1.645 sd             95 % upper limit (|a| where both signs may be)
 *
 *   not_testable  no column, or 1.645 sd >= limit: even the largest plausible amount could be 0
 *   weak          z >= 1.96 in a possible direction, or detectable > limit: a plausible amount may
 *                 stay undetected
 *   absent        the rest: it would have been named at its limit, and nothing points to it
 *
 * Where noise is left, what is weak with z >= 3 may act beside the causes. Their amounts would then
 * be others, and their intervals contain those, too (results.c).
 *
 * (Saris & Satorra 1987.) The linear model is valid where the best row leaves noise; elsewhere
 * no candidate is called absent.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>

#include "verdict.h"

enum { OWN = DIAG_CAUSES };

const char *lab_presence_text(lab_presence presence)
{
    static const char *const text[] = {NULL, "present", "weak", "absent", "not_testable"};
    return text[presence];
}

/* information and score of column k with the row's own causes projected out */
static void project(const diag__linear *l, int k, double *info, double *score)
{
    size_t n = (size_t)l->n, m = (size_t)l->own, c = (size_t)k;
    double a[OWN * OWN], b[OWN];
    *info = l->I[c * n + c];
    *score = l->s[c];
    if (m == 0) {
        return;
    }
    for (size_t i = 0; i < m; i++) {
        for (size_t j = 0; j < m; j++) {
            a[i * m + j] = l->I[i * n + j] + (i == j);
        }
        b[i] = l->I[i * n + c];
    }
    gsl_matrix_view A = gsl_matrix_view_array(a, m, m);
    gsl_vector_view v = gsl_vector_view_array(b, m);
    if (gsl_linalg_cholesky_decomp1(&A.matrix) != 0) {
        return;
    }
    gsl_linalg_cholesky_svx(&A.matrix, &v.vector);
    for (size_t i = 0; i < m; i++) {
        *info -= b[i] * l->I[i * n + c];
        *score -= b[i] * l->s[i];
    }
}

double diag__detectable(double info)
{
    return (sqrt(diag__least_gain + log1p(info)) + diag__one_sided) / sqrt(info);
}

double diag__excludes(double info)
{
    return (sqrt(diag__convincing) + diag__one_sided) / sqrt(info);
}

lab_power diag__power(const diag__problem *q, const diag__linear *l, int k)
{
    const lab_candidate *c = &q->candidate[l->cause[k]];
    double info, score, raw = l->I[(size_t)k * (size_t)l->n + (size_t)k];
    project(l, k, &info, &score);
    double sd = info > 1e-9 * raw ? 1.0 / sqrt(info) : INFINITY;
    if (!(diag__one_sided * sd < 1.0)) {
        return (lab_power){.presence = LAB_NOT_TESTABLE,
                           .amount = NAN,
                           .sd = NAN,
                           .detectable = NAN,
                           .upper = NAN,
                           .because =
                               diag__one_sided / sqrt(raw) < 1.0
                                   ? "other numbers of the file, the causes or what is unknown "
                                     "of each record can act in the same way"
                                   : "too little of it shows in these records"};
    }
    double detectable = diag__detectable(info), a = score / info,
           toward = lab_candidate_is_signed(c) ? fabs(a) : a;
    int hides = detectable > 1.0, points = toward >= diag__interval * sd,
        noise = diag__leaves_noise(q, l->row),
        beside = noise && l->own > 0 && toward >= diag__beyond_chance * sd;
    return (lab_power){.presence = points || hides || !noise ? LAB_WEAK : LAB_ABSENT,
                       .amount = a * c->limit,
                       .sd = sd * c->limit,
                       .detectable = detectable * c->limit,
                       .upper = (fmax(toward, 0.0) + diag__one_sided * sd) * c->limit,
                       .beside = beside,
                       .because = beside   ? "it may act beside the causes"
                                  : points ? "something points to it"
                                  : hides  ? "a plausible amount of it may hide"
                                  : !noise ? "more than noise is left, which may hide it"
                                           : "one as large as is plausible would have been named"};
}
