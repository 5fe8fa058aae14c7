/* SPDX-License-Identifier: MIT
 * elementary.h - the elementary functions of the core: sine and cosine together, tanh, exp, log.
 *
 * Own ones, so that a motion is the same bits with any libm, and inline, without libm's tables,
 * flags and calls. Each is a reduction to a short interval and a polynomial, almost without
 * branches; what lies outside of a mechanism's range is in elementary.c. Nothing sets errno.
 *
 *   sincos  x = n pi/2 + r, pi/2 in three parts of 33 bits (Cody & Waite 1980), |r| <= pi/4
 *   exp     x = n ln 2 + r,  e^r = (R + r) / (R - r) with R even in r: |r| <= ln 2 / 2
 *   tanh    1 - 2 / (e^2u + 1), of small u u - u^3 / T with T even in u: what is taken away is less
 *           than half, so its few errors count little
 *   log     x = 2^n (1 + f),  log(1 + f) = f - f^2/2 + s (f^2/2 + L(s^2)),  s = f / (2 + f)
 *
 * The minimax coefficients are those of FDLIBM (Sun Microsystems 1993), those of tanh our own.
 * Errors, as the tests have them: below 1 ulp.
 * Included by: this folder.
 */
#ifndef STEIN_ELEMENTARY_H
#define STEIN_ELEMENTARY_H

#include <float.h>

#include "functions.h"
#include "real.h"

/* added and taken away again, it leaves the nearest integer, which its lowest bits hold meanwhile
 */
#define STEIN__ROUND 0x1.8p52

/* P and Q of sin r = r + z r (S + z P), cos r = 1 - z/2 + z^2 Q, z = r^2, |r| <= pi/4 */
static const double stein__sine_cubic = -1.66666666666666324348e-01;
static inline real stein__sine_rest(real z)
{
    return (8.33333333332248946124e-03 +
            z * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)) +
           z * (z * z) * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10);
}

static inline real stein__cosine_rest(real z)
{
    real w = z * z;
    return z * (4.16666666666666019037e-02 +
                z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05)) +
           w * w *
               (-2.75573143513906633035e-07 +
                z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11));
}

/* sine and cosine of quadrant pi/2 + r + tail */
static inline void stein__sincos_turned(real r, real tail, word quadrant, real *s, real *c)
{
    real z = r * r, v = z * r, half = 0.5 * z, one = 1.0 - half;
    real rest = z * (0.5 * tail - v * stein__sine_rest(z)) - tail;
    real sine = r - (rest - v * stein__sine_cubic);
    real cosine = one + (((1.0 - one) - half) + (z * stein__cosine_rest(z) - r * tail));
    mask odd = has_bit(quadrant, 0);
    real a = sel(odd, cosine, sine), b = sel(odd, sine, cosine);
    *s = sel(has_bit(quadrant, 1), -a, a);
    *c = sel(has_bit(quadrant + 1, 1), -b, b);
}

/* elementary.c: those of an angle where n pi/2 is no longer exact in its parts */
double stein__sine_huge(double x);
double stein__cosine_huge(double x);

/* sine and cosine of an angle outside of that interval */
static inline void stein__sincos_far(real x, real *s, real *c)
{
    mask huge = no(less(magnitude(x), 1e5));
    if (every(huge)) {
        *s = alone(stein__sine_huge, huge, x);
        *c = alone(stein__cosine_huge, huge, x);
        return;
    }
    real shifted = x * 6.36619772367581382433e-01 + STEIN__ROUND, n = shifted - STEIN__ROUND;
    real first = x - n * 1.57079632673412561417e+00, second = n * 6.07710050630396597660e-11;
    real near = first - second;
    real third = n * 2.02226624879595063154e-21 - ((first - near) - second);
    real r = near - third;
    stein__sincos_turned(r, (near - r) - third, bits_of(shifted), s, c);
    if (any(huge)) {
        *s = sel(huge, alone(stein__sine_huge, huge, x), *s);
        *c = sel(huge, alone(stein__cosine_huge, huge, x), *c);
    }
}

/** Sine and cosine of x. */
static inline void stein__sincos(real x, real *s, real *c)
{
    mask near = at_most(magnitude(x), 0.7853981633974483);
    if (!any(near)) {
        stein__sincos_far(x, s, c);
        return;
    }
    real z = x * x, half = 0.5 * z, one = 1.0 - half;
    *s = x + z * x * (stein__sine_cubic + z * stein__sine_rest(z));
    *c = one + (((1.0 - one) - half) + z * stein__cosine_rest(z));
    if (!every(near)) {
        real far_s, far_c;
        stein__sincos_far(x, &far_s, &far_c);
        *s = sel(near, *s, far_s);
        *c = sel(near, *c, far_c);
    }
}

/* x = n ln 2 + (high - low) with 2^n, and R - 2 at r = high - low */
typedef struct stein__exponent {
    real power, high, low, r, even;
} stein__exponent;

static inline stein__exponent stein__exp_parts(real x)
{
    real shifted = x * 1.44269504088896338700e+00 + STEIN__ROUND, n = shifted - STEIN__ROUND;
    real high = x - n * 6.93147180369123816490e-01, low = n * 1.90821492927058770002e-10;
    real r = high - low, z = r * r, w = z * z;
    real even = z * (1.66666666666666019037e-01 - z * 2.77777777770155933842e-03) +
                z * w *
                    (6.61375632143793436117e-05 - z * 1.65339022054652515390e-06 +
                     w * 4.13813679705723846039e-08);
    real power = of_bits((bits_of(shifted) + 1023) << 52);
    return (stein__exponent){power, high, low, r, even};
}

double stein__exp_end(double x); /* elementary.c: nearly nothing, nearly infinite */

/** e^x. */
static inline real stein__exp(real x)
{
    mask far = no(less(magnitude(x), 700.0));
    if (every(far)) {
        return alone(stein__exp_end, far, x);
    }
    stein__exponent p = stein__exp_parts(x);
    real c = p.r - p.even; // e^r = 1 + r + r c / (2 - c)
    real y = p.power * (1.0 - ((p.low - p.r * c / (2.0 - c)) - p.high));
    return any(far) ? sel(far, alone(stein__exp_end, far, x), y) : y;
}

/* e^x + 1 = high + low for 1 <= x <= 40: e^r by even and odd powers, and no division */
static inline void stein__exp_plus_1(real x, real *high, real *low)
{
    real shifted = x * 1.44269504088896338700e+00 + STEIN__ROUND, n = shifted - STEIN__ROUND;
    real first = x - n * 6.93147180369123816490e-01, second = n * 1.90821492927058770002e-10;
    real r = first - second, z = r * r, w = z * z;
    real even = z * (5.00000000000001296930e-01 + z * 4.16666666665137944079e-02) +
                z * w *
                    (1.38888889474031092467e-03 + z * 2.48014895649047227928e-05 +
                     w * 2.76314096520554204053e-07);
    real odd = z * (1.66666666666666839155e-01 + z * 8.33333333331668412833e-03) +
               z * w *
                   (1.98412698971995530990e-04 + z * 2.75572340985501577435e-06 +
                    w * 2.51122886567063901322e-08);
    real power = of_bits((bits_of(shifted) + 1023) << 52);
    real curved = (even + r * odd) - second; // e^r = 1 + first + curved
    real grown = first + curved, whole = power + 1.0;
    *high = whole + power * grown;
    *low = ((whole - *high) + power * grown) + power * ((first - grown) + curved);
}

/* y^3 / (y - tanh y) at z = y^2, y < 0.55 */
static inline real stein__tanh_near(real z)
{
    real w = z * z;
    return 3.0 + (z * (1.19999999999997397637e+00 - z * 5.71428571310153392282e-03) +
                  z * w *
                      ((2.53968233968104146157e-04 - z * 1.22035035975169132386e-05) +
                       w * (5.98041397324742544457e-07 - z * 2.79526780122397440355e-08)));
}

/** Hyperbolic tangent of u. */
ALWAYS real stein__tanh(real u)
{
    real y = magnitude(u), from = same(1.0), top = same(2.0), bottom, low;
    mask near = less(y, 0.55), full = more(y, 20.0);
    if (every(near)) {
        return with_sign_of(y - y * (y * y) / stein__tanh_near(y * y), u);
    }
    if (every(full)) {
        return with_sign_of(from, u);
    }
    stein__exp_plus_1(sel(full, same(40.0), 2.0 * y), &bottom, &low);
    if (any(near)) {
        from = sel(near, y, from);
        top = sel(near, y * (y * y), top);
        bottom = sel(near, stein__tanh_near(y * y), bottom);
        low = sel(near, same(0.0), low);
    }
    real part = top / bottom, t = from - part;
    // what the subtraction lost, and what the quotient did not know of its divisor
    t += ((from - t) - part) + 0.5 * part * part * low;
    return with_sign_of(t, u);
}

/* ln (2^shift x) of a normal x; shift is whole */
static inline real stein__log_shifted(real x, double shift)
{
    // 1 + f in sqrt(1/2)..sqrt(2); the exponent becomes a number where 1 is the last bit of it
    word bits = bits_of(x) + 0x00095f6200000000;
    real n = of_bits((bits >> 52) | 0x4330000000000000) - (0x1p52 + 1023.0 - shift);
    real f = of_bits((bits & 0x000fffffffffffff) + 0x3fe6a09e00000000) - 1.0;
    real s = f / (2.0 + f), z = s * s, w = z * z, half = 0.5 * f * f;
    real even = w * (3.999999999940941908e-01 +
                     w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    real odd = z * (6.666666666666735130e-01 +
                    w * (2.857142874366239149e-01 +
                         w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    real low = n * 1.90821492927058770002e-10;
    return n * 6.93147180369123816490e-01 - ((half - (s * (half + (even + odd)) + low)) - f);
}

double stein__log_end(double x); /* elementary.c: nearly 0, nearly infinite, no number */

/** Natural logarithm of x. */
static inline real stein__log(real x)
{
    mask far = no(both(more(x, 1e-300), less(x, 1e300)));
    if (every(far)) {
        return alone(stein__log_end, far, x);
    }
    real y = stein__log_shifted(x, 0.0);
    return any(far) ? sel(far, alone(stein__log_end, far, x), y) : y;
}

/** x^y for x > 0, in every lane. */
static inline real stein__raised(real x, real y)
{
#if STEIN_LANES == 1
    return stein__power(x, y);
#else
    for (int k = 0; k < STEIN_LANES; k++) {
        x[k] = stein__power(x[k], y[k]);
    }
    return x;
#endif
}

#endif
