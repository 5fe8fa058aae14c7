/* SPDX-License-Identifier: GPL-3.0-or-later
 * libm.h - in place of src/core/elementary.h: the same functions by the platform's libm, for `make
 * bench-libm`, which compares the costs.
 */
#ifndef STEIN_ELEMENTARY_H
#define STEIN_ELEMENTARY_H

#define _GNU_SOURCE /* sincos */
#include <math.h>

#include "functions.h"
#include "real.h"

static inline void stein__sincos(double x, double *s, double *c)
{
    sincos(x, s, c);
}

#define LIBM(name)                               \
    static inline double stein__##name(double x) \
    {                                            \
        return name(x);                          \
    }
LIBM(tanh)
LIBM(exp)
LIBM(log)
#undef LIBM

static inline double stein__raised(double x, double y)
{
    return pow(x, y);
}

#endif
