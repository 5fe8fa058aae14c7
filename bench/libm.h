/* SPDX-License-Identifier: GPL-3.0-or-later
 * libm.h - in place of src/core/elementary.h: the same functions by the platform's libm, so that
 * `make bench-libm` can tell what own ones cost.
 */
#ifndef STEIN_ELEMENTARY_H
#define STEIN_ELEMENTARY_H

#define _GNU_SOURCE /* sincos */
#include <math.h>
#include <stdint.h>
#include <string.h>

static inline uint64_t stein__bits(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline void stein__sincos(double x, double *s, double *c)
{
    sincos(x, s, c);
}

#define LIBM(name, call)                         \
    static inline double stein__##name(double x) \
    {                                            \
        return call(x);                          \
    }
LIBM(sin, sin)
LIBM(cos, cos)
LIBM(tan, tan)
LIBM(tanh, tanh)
LIBM(exp, exp)
LIBM(log, log)
#undef LIBM

static inline double stein__power(double x, double y)
{
    return pow(x, y);
}

#endif
