/* SPDX-License-Identifier: MIT
 * tangent.h - the words of real.h for a number with its derivative (STEIN_LANES 0).
 *
 * C has operators for one kind of pair, the complex numbers. x + i h x' with a tiny h follows the
 * rules of a derivative in every sum, product and quotient, because what is of the order of h^2
 * vanishes beside the rest (Squire & Trapp 1998). With h = 2^-400 that is so in the last bit. So
 * contacts, laws and the notch are differentiated as they are written, without a second text.
 *
 * Conditions ask about the number, as the side on which a motion is does not depend on a
 * derivative. Only "differs from its neutral value" is also true of a law that is just being
 * switched on.
 * Included by: this folder.
 */
#ifndef STEIN_TANGENT_H
#define STEIN_TANGENT_H

#define STEIN__TINY 0x1p-400

#define INNER  static inline
#define INLINE static inline

#define less(a, b)    ((mask)(__real__(a) < __real__(b)))
#define more(a, b)    ((mask)(__real__(a) > __real__(b)))
#define at_most(a, b) ((mask)(__real__(a) <= __real__(b)))
#define differ(a, b)  ((mask)(__real__(a) != __real__(b) || __imag__(a) != __imag__(b)))

/* a number with a derivative that is already in units of the scale */
static inline real with_rate(double value, double rate)
{
    real x;
    __real__ x = value;
    __imag__ x = rate;
    return x;
}

static inline real with_slope(double value, double slope)
{
    return with_rate(value, STEIN__TINY * slope);
}

static inline double slope_of(real x)
{
    return __imag__ x / STEIN__TINY;
}

static inline real magnitude(real x)
{
    return __real__ x < 0.0 ? -x : x;
}

/* a quotient whose bits are those of one of doubles, and the same by every compiler */
static inline real over(real a, real b)
{
    double value = __real__ a / __real__ b;
    return with_rate(value, (__imag__ a - value * __imag__ b) / __real__ b);
}

static inline real root_of(real x)
{
    double root = sqrt(__real__ x);
    return with_rate(root, __imag__ x / (2.0 * root));
}

#endif
