/* SPDX-License-Identifier: GPL-3.0-or-later
 * before_information.c - detectability and separability of causes from a matrix of information,
 * before any measurement.
 *
 * With amounts a [limits] and everything that is refitted projected out (search/linear.c), the
 * records have the information I = G'PG. A cause alone is named from
 *
 *      (sqrt(25 + ln(1 + I_ii)) + 1.645) / sqrt(I_ii)
 *
 * on, with 95 % (verdict/detectability.c). If i acts and j is fitted in its place, the remaining
 * chi2 is a_i^2 times
 *
 *      I_ii - I_ij^2 / I_jj = I_ii (1 - rho^2)
 *
 * and j is no rival if that exceeds 9.2 (rule 5 of the judge), with 95 % from
 * (sqrt(9.2) + 1.645) / sqrt(I_ii (1 - rho^2)) on. Of a cause with several columns - one for each
 * value of its second number - the column with most information acts, and any of the other cause's
 * columns may be fitted.
 */
#include <math.h>

#include "planning.h"
#include "verdict.h"

static const double nothing = 1e-9; /* of a column: rounding of the projection */

/* its column of most information, -1: none */
static int best_of(const double *I, int n, const int *cause, int k)
{
    int best = -1;
    for (int i = 0; i < n; i++) {
        double info = I[(size_t)i * (size_t)n + (size_t)i];
        if (cause[i] == k && info > 0.0 &&
            (best < 0 || info > I[(size_t)best * (size_t)n + (size_t)best])) {
            best = i;
        }
    }
    return best;
}

/* information of column a that column b does not imitate */
static double left_of(const double *I, int n, int a, int b)
{
    size_t N = (size_t)n, i = (size_t)a, k = (size_t)b;
    double all = I[i * N + i], other = I[k * N + k], both = I[i * N + k];
    double left = other > 0.0 ? all - both * both / other : all;
    return left > nothing * all ? left : 0.0;
}

void plan__tell(const double *I, int n, const int *cause, int ncause, double *nameable,
                double *apart)
{
    for (int i = 0; i < ncause; i++) {
        int a = best_of(I, n, cause, i);
        nameable[i] =
            a >= 0 ? diag__detectable(I[(size_t)a * (size_t)n + (size_t)a]) : (double)INFINITY;
        for (int j = 0; j < ncause; j++) {
            double least = a >= 0 ? I[(size_t)a * (size_t)n + (size_t)a] : 0.0;
            for (int b = 0; a >= 0 && b < n; b++) {
                least = cause[b] == j ? fmin(least, left_of(I, n, a, b)) : least;
            }
            apart[(size_t)i * (size_t)ncause + (size_t)j] = i == j        ? 0.0
                                                            : least > 0.0 ? diag__excludes(least)
                                                                          : (double)INFINITY;
        }
    }
}
