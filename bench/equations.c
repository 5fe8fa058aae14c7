/* SPDX-License-Identifier: GPL-3.0-or-later
 * equations.c - M and c of piano3 in lanes (STEIN_LANES), sines and cosines included.
 */
#include "equations.h"

#include "elementary.h"

enum { NQ = 3, MOST = 256 };

typedef stein_real wide __attribute__((may_alias)); /* reals among doubles */

extern const stein_lanes STEIN_LANES_NAME(STEIN_LANES, piano3);
static real constants[MOST];

static void prepare(const double *d, int nd)
{
    for (int i = 0; i < nd && i < MOST; i++) {
        constants[i] = same(d[i]);
    }
}

static inline void evaluate(const wide *q, const wide *qd, wide *M, wide *c)
{
    real sc[2 * NQ];
    for (int j = 0; j < NQ; j++) {
        stein__sincos(q[j], &sc[2 * j], &sc[2 * j + 1]);
    }
    STEIN_LANES_NAME(STEIN_LANES, piano3).unloaded(q, qd, sc, constants, M, c);
}

static void mass_bias(const double *q, const double *qd, double *M, double *c)
{
    evaluate((const wide *)q, (const wide *)qd, (wide *)M, (wide *)c);
}

static double sum(const double *q, const double *qd, int n)
{
    real of = same(0.0), M[NQ * NQ] = {same(0.0)}, c[NQ] = {same(0.0)};
    double all = 0.0;
    for (int i = 0; i < NQ * n; i += NQ * STEIN_LANES) {
        evaluate((const wide *)(q + i), (const wide *)(qd + i), M, c);
        of += M[0] + M[1] + M[8] + c[0] + c[1] + c[2];
    }
    for (int k = 0; k < STEIN_LANES; k++) {
        all += of[k];
    }
    return all;
}

#define JOIN(a, b)      a##b
#define EQUATIONS_OF(n) JOIN(equations, n)
const equations_in_lanes EQUATIONS_OF(STEIN_LANES) = {STEIN_LANES, prepare, mass_bias, sum};
