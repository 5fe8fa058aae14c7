/* SPDX-License-Identifier: GPL-3.0-or-later
 * equations.c - M and c of piano3 in lanes (STEIN_LANES), sines and cosines included.
 */
#include "equations.h"

#include "elementary.h"

enum { NQ = 3, MOST = 256 };

/* a real among doubles; memcpy would go in halves, which to load as a whole means to wait */
typedef stein_real loose __attribute__((aligned(8), may_alias));

extern const stein_lanes STEIN_LANES_NAME(STEIN_LANES, piano3);
static real constants[MOST], zero[3 * NQ];

static void prepare(const double *d, int nd)
{
    for (int i = 0; i < nd && i < MOST; i++) {
        constants[i] = same(d[i]);
    }
}

static void mass_bias(const double *q, const double *qd, int n, double *M, double *c)
{
    const stein_lanes *e = &STEIN_LANES_NAME(STEIN_LANES, piano3);
    for (int g = 0; g < n / STEIN_LANES; g++) {
        real x[NQ], v[NQ], sc[2 * NQ], m[NQ * NQ], b[NQ];
        for (int j = 0; j < NQ; j++) {
            x[j] = *(const loose *)(q + (g * NQ + j) * STEIN_LANES);
            v[j] = *(const loose *)(qd + (g * NQ + j) * STEIN_LANES);
            stein__sincos(x[j], &sc[2 * j], &sc[2 * j + 1]);
        }
        e->mass_bias(x, v, sc, constants, zero, zero, m, b);
        for (int k = 0; k < NQ * NQ; k++) {
            *(loose *)(M + (g * NQ * NQ + k) * STEIN_LANES) = m[k];
        }
        for (int k = 0; k < NQ; k++) {
            *(loose *)(c + (g * NQ + k) * STEIN_LANES) = b[k];
        }
    }
}

#define JOIN(a, b)      a##b
#define EQUATIONS_OF(n) JOIN(equations, n)
const equations_in_lanes EQUATIONS_OF(STEIN_LANES) = {STEIN_LANES, prepare, mass_bias};
