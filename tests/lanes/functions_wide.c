/* SPDX-License-Identifier: GPL-3.0-or-later
 * functions_wide.c - the elementary functions of STEIN_LANES lanes, for arrays.
 */
#include "lanes/functions_wide.h"

#include "elementary.h"

#define NAMED(lanes)  CALLED(lanes)
#define CALLED(lanes) lane_functions_##lanes

static void put(double *out, int n, int function, int at, real x)
{
    memcpy(out + (size_t)function * (size_t)n + at, &x, sizeof x);
}

lane_functions NAMED(STEIN_LANES);
void NAMED(STEIN_LANES)(const double *x, const double *y, int n, double *out)
{
    for (int i = 0; i + STEIN_LANES <= n; i += STEIN_LANES) {
        real u, v, s, c;
        memcpy(&u, x + i, sizeof u);
        memcpy(&v, y + i, sizeof v);
        stein__sincos(u, &s, &c);
        put(out, n, LANE_SIN, i, s);
        put(out, n, LANE_COS, i, c);
        put(out, n, LANE_TANH, i, stein__tanh(u));
        put(out, n, LANE_EXP, i, stein__exp(u));
        put(out, n, LANE_LOG, i, stein__log(u));
        put(out, n, LANE_POWER, i, stein__raised(magnitude(u), v));
    }
}
