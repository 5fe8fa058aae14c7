/* SPDX-License-Identifier: MIT
 * elementary.h - the elementary functions of the core: sine and cosine together, tanh, exp, log.
 *
 * Own ones, so that a motion is the same bits with any libm, and inline, without libm's tables,
 * flags and calls. Each is a reduction to a short interval and a polynomial, almost without
 * branches; what lies outside of a mechanism's range is in elementary.c. Nothing sets errno.
 *
 *   sincos  x = n pi/2 + r, pi/2 in three parts of 33 bits (Cody & Waite 1980), |r| <= pi/4
 *   exp     x = n ln 2 + r,  e^r = (R + r) / (R - r) with R even in r: |r| <= ln 2 / 2
 *   tanh    (e^2u - 1) / (e^2u + 1) with the same R, which needs one division and keeps all digits
 *           of small u
 *   log     x = 2^n (1 + f),  log(1 + f) = f - f^2/2 + s (f^2/2 + L(s^2)),  s = f / (2 + f)
 *
 * The minimax coefficients are those of FDLIBM (Sun Microsystems 1993). Errors, as the tests have
 * them: 1 ulp, tanh 3 ulp.
 */
#ifndef STEIN_ELEMENTARY_H
#define STEIN_ELEMENTARY_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* added and taken away again, it leaves the nearest integer, which its lowest bits hold meanwhile
 */
#define STEIN__ROUND 0x1.8p52

static inline uint64_t stein__bits(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double stein__of_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* P and Q of sin r = r + z r (S + z P), cos r = 1 - z/2 + z^2 Q, z = r^2, |r| <= pi/4 */
static const double stein__sine_cubic = -1.66666666666666324348e-01;
static inline double stein__sine_rest(double z)
{
    return (8.33333333332248946124e-03 +
            z * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)) +
           z * (z * z) * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10);
}

static inline double stein__cosine_rest(double z)
{
    double w = z * z;
    return z * (4.16666666666666019037e-02 +
                z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05)) +
           w * w *
               (-2.75573143513906633035e-07 +
                z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11));
}

/* sine and cosine of quadrant pi/2 + r + tail */
static inline void stein__sincos_turned(double r, double tail, uint64_t quadrant, double *s,
                                        double *c)
{
    double z = r * r, v = z * r, half = 0.5 * z, one = 1.0 - half;
    double rest = z * (0.5 * tail - v * stein__sine_rest(z)) - tail;
    double sine = r - (rest - v * stein__sine_cubic);
    double cosine = one + (((1.0 - one) - half) + (z * stein__cosine_rest(z) - r * tail));
    double a = quadrant & 1 ? cosine : sine, b = quadrant & 1 ? sine : cosine;
    *s = quadrant & 2 ? -a : a;
    *c = (quadrant + 1) & 2 ? -b : b;
}

/* elementary.c: where n pi/2 is no longer exact in its parts */
void stein__sincos_huge(double x, double *s, double *c);

/* sine and cosine of an angle outside of that interval */
static inline void stein__sincos_far(double x, double *s, double *c)
{
    if (!(fabs(x) < 1e5)) {
        stein__sincos_huge(x, s, c);
        return;
    }
    double shifted = x * 6.36619772367581382433e-01 + STEIN__ROUND, n = shifted - STEIN__ROUND;
    double first = x - n * 1.57079632673412561417e+00, second = n * 6.07710050630396597660e-11;
    double near = first - second;
    double third = n * 2.02226624879595063154e-21 - ((first - near) - second);
    double r = near - third, tail = (near - r) - third;
    stein__sincos_turned(r, tail, stein__bits(shifted), s, c);
}

/** Sine and cosine of x. */
static inline void stein__sincos(double x, double *s, double *c)
{
    if (!(fabs(x) <= 0.7853981633974483)) {
        stein__sincos_far(x, s, c);
        return;
    }
    double z = x * x, half = 0.5 * z, one = 1.0 - half;
    *s = x + z * x * (stein__sine_cubic + z * stein__sine_rest(z));
    *c = one + (((1.0 - one) - half) + z * stein__cosine_rest(z));
}

/* x = n ln 2 + (high - low) with 2^n, and R - 2 at r = high - low */
typedef struct stein__exponent {
    double power, high, low, r, even;
} stein__exponent;

static inline stein__exponent stein__exp_parts(double x)
{
    double shifted = x * 1.44269504088896338700e+00 + STEIN__ROUND, n = shifted - STEIN__ROUND;
    double high = x - n * 6.93147180369123816490e-01, low = n * 1.90821492927058770002e-10;
    double r = high - low, z = r * r, w = z * z;
    double even = z * (1.66666666666666019037e-01 - z * 2.77777777770155933842e-03) +
                  z * w *
                      (6.61375632143793436117e-05 - z * 1.65339022054652515390e-06 +
                       w * 4.13813679705723846039e-08);
    double power = stein__of_bits((stein__bits(shifted) + 1023) << 52);
    return (stein__exponent){power, high, low, r, even};
}

double stein__exp_end(double x); /* elementary.c: nearly nothing, nearly infinite */

/** e^x. */
static inline double stein__exp(double x)
{
    if (!(fabs(x) < 700.0)) {
        return stein__exp_end(x);
    }
    stein__exponent p = stein__exp_parts(x);
    double c = p.r - p.even; // e^r = 1 + r + r c / (2 - c)
    return p.power * (1.0 - ((p.low - p.r * c / (2.0 - c)) - p.high));
}

/** Hyperbolic tangent of u. */
static inline double stein__tanh(double u)
{
    double x = 2.0 * fabs(u);
    stein__exponent p = stein__exp_parts(x > 40.0 ? 40.0 : x);
    double less = p.power - 1.0, more = p.power + 1.0;
    double above = 2.0 * less + (less * p.even + more * p.r);
    double below = 2.0 * more + (more * p.even + less * p.r);
    return copysign(above / below, u);
}

/* log x + n ln 2 of a normal x */
static inline double stein__log_of(double x, double n)
{
    // 1 + f in sqrt(1/2)..sqrt(2)
    uint64_t bits = stein__bits(x) + 0x00095f6200000000;
    n += (double)((int64_t)(bits >> 52) - 1023);
    double f = stein__of_bits((bits & 0x000fffffffffffff) + 0x3fe6a09e00000000) - 1.0;
    double s = f / (2.0 + f), z = s * s, w = z * z, half = 0.5 * f * f;
    double even = w * (3.999999999940941908e-01 +
                       w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    double odd = z * (6.666666666666735130e-01 +
                      w * (2.857142874366239149e-01 +
                           w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    double low = n * 1.90821492927058770002e-10;
    return n * 6.93147180369123816490e-01 - ((half - (s * (half + (even + odd)) + low)) - f);
}

double stein__log_end(double x); /* elementary.c: nearly 0, nearly infinite, no number */

/** Natural logarithm of x. */
static inline double stein__log(double x)
{
    return x > 1e-300 && x < 1e300 ? stein__log_of(x, 0.0) : stein__log_end(x);
}

/** In elementary.c: x^y for x > 0; sine, cosine and tangent for who needs only one. */
double stein__power(double x, double y);
double stein__sin(double x);
double stein__cos(double x);
double stein__tan(double x);

#endif
