/* SPDX-License-Identifier: MIT
 * real.h - numbers, conditions and choices of one simulation or of several side by side.
 *
 * What a derivative needs is written once, in these words, and compiled once for each number of
 * lanes (STEIN_LANES, see model.h). With one lane `real` is a double, `mask` an int and every
 * choice a branch that the compiler sees through. With more, conditions are masks, both sides of a
 * choice are worked out and each lane takes its own; any() and every() leave out what no lane
 * needs.
 *
 *      real f = stiff(x);
 *      if (any(is_worn)) {                  one lane: if (is_worn)
 *          f = sel(is_worn, f * worn(x), f);
 *      }
 *
 * Each lane does what a simulation alone does, operation by operation, so it has the same bits.
 *
 * With STEIN_LANES 0 a real is a number with its derivative, and conditions ask about the number
 * (tangent.h).
 * Included by: this folder.
 */
#ifndef STEIN_REAL_H
#define STEIN_REAL_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "stein/model.h"

#if STEIN_LANES > 1 && defined __SSE2__
#include <immintrin.h>
#endif

typedef stein_real real;

/* for functions whose arguments and results would go through memory, in lanes every one of them */
#define ALWAYS static inline __attribute__((always_inline))

#if STEIN_LANES <= 1

typedef int mask;
typedef unsigned char flag; /* a condition in memory */

static inline mask both(mask a, mask b)
{
    return a && b;
}

static inline mask either(mask a, mask b)
{
    return a || b;
}

static inline mask no(mask m)
{
    return !m;
}

static inline int any(mask m)
{
    return m;
}

static inline int every(mask m)
{
    return m;
}

static inline real sel(mask m, real yes, real no_)
{
    return m ? yes : no_;
}

static inline mask mask_of(flag f)
{
    return f;
}

/* x where it is wanted, else 0; with one lane it is always wanted */
static inline real only(mask wanted, real x)
{
    (void)wanted;
    return x;
}

#endif
#if STEIN_LANES == 1

typedef uint64_t word; /* the bits of a real */

#define INLINE
#define INNER /* a function of several files; in lanes they are one translation unit */

static inline real magnitude(real x)
{
    return fabs(x);
}

static inline real with_sign_of(real x, real sign)
{
    return copysign(x, sign);
}

static inline real over(real a, real b)
{
    return a / b;
}

static inline real root_of(real x)
{
    return sqrt(x);
}

/* f of each lane that is asked for, by the library */
static inline real alone(double (*f)(double), mask asked, real x)
{
    (void)asked;
    return f(x);
}

/* bit k of w, as a condition */
static inline mask has_bit(word w, int k)
{
    return (int)(w >> k & 1);
}

#elif STEIN_LANES > 1

typedef unsigned long long word __attribute__((vector_size(8 * STEIN_LANES)));
#if STEIN_LANES == 8 && defined __AVX512DQ__
#define MASK_OF_BITS 1
typedef unsigned char mask; /* a bit a lane: how these processors compare and choose */
#else
#define MASK_OF_BITS 0
typedef stein_mask mask;
#endif
typedef mask flag;

#define INNER  static inline
#define INLINE ALWAYS

static inline mask both(mask a, mask b)
{
    return a & b;
}

static inline mask either(mask a, mask b)
{
    return a | b;
}

static inline mask no(mask m)
{
    return ~m;
}

/* one bit a lane */
static inline unsigned lanes_of(mask m)
{
#if MASK_OF_BITS
    return m;
#elif defined __AVX2__ && STEIN_LANES == 4
    return (unsigned)_mm256_movemask_pd((__m256d)m);
#elif defined __SSE2__ && STEIN_LANES == 2
    return (unsigned)_mm_movemask_pd((__m128d)m);
#else
    unsigned bits = 0;
    for (int k = 0; k < STEIN_LANES; k++) {
        bits |= (unsigned)(m[k] & 1) << k;
    }
    return bits;
#endif
}

/* and back */
static inline mask mask_from(unsigned bits)
{
#if MASK_OF_BITS
    return (mask)bits;
#else
    mask m = {0};
    for (int k = 0; k < STEIN_LANES; k++) {
        m[k] = -(long long)(bits >> k & 1);
    }
    return m;
#endif
}

/* what holds in a lane becomes known */
static inline void put_flag(flag *f, int lane, int holds)
{
#if MASK_OF_BITS
    *f = (mask)((*f & ~(1u << lane)) | (unsigned)(holds != 0) << lane);
#else
    (*f)[lane] = -(holds != 0);
#endif
}

/* lanes in which equations could not be solved, as generated text says it */
static inline mask unsolved(stein_solved bad)
{
#if MASK_OF_BITS
    return (mask)_mm512_movepi64_mask((__m512i)bad);
#else
    return bad;
#endif
}

static inline int any(mask m)
{
    return lanes_of(m) != 0;
}

static inline int every(mask m)
{
    return lanes_of(m) == (1u << STEIN_LANES) - 1;
}

static inline real sel(mask m, real yes, real no_)
{
#if MASK_OF_BITS
    return (real)_mm512_mask_blend_pd(m, (__m512d)no_, (__m512d)yes);
#elif defined __AVX2__ && STEIN_LANES == 4
    return (real)_mm256_blendv_pd((__m256d)no_, (__m256d)yes, (__m256d)m);
#elif defined __SSE2__ && STEIN_LANES == 2
    return (real)_mm_or_pd(_mm_and_pd((__m128d)m, (__m128d)yes),
                           _mm_andnot_pd((__m128d)m, (__m128d)no_));
#else
    return (real)((m & (mask)yes) | (~m & (mask)no_));
#endif
}

static inline mask mask_of(flag f)
{
    return f;
}

static inline real magnitude(real x)
{
    return (real)((word)x & 0x7fffffffffffffff);
}

static inline real with_sign_of(real x, real sign)
{
    return (real)(((word)x & 0x7fffffffffffffff) | ((word)sign & 0x8000000000000000));
}

static inline real over(real a, real b)
{
    return a / b;
}

static inline real root_of(real x)
{
#if MASK_OF_BITS
    return (real)_mm512_sqrt_pd((__m512d)x);
#elif defined __AVX2__ && STEIN_LANES == 4
    return (real)_mm256_sqrt_pd((__m256d)x);
#elif defined __SSE2__ && STEIN_LANES == 2
    return (real)_mm_sqrt_pd((__m128d)x);
#else
    for (int k = 0; k < STEIN_LANES; k++) {
        x[k] = sqrt(x[k]);
    }
    return x;
#endif
}

static inline real alone(double (*f)(double), mask asked, real x)
{
    for (int k = 0; k < STEIN_LANES; k++) {
        x[k] = lanes_of(asked) >> k & 1 ? f(x[k]) : x[k];
    }
    return x;
}

static inline real only(mask wanted, real x)
{
#if MASK_OF_BITS
    return (real)_mm512_maskz_mov_pd(wanted, (__m512d)x);
#elif defined __SSE2__ && STEIN_LANES == 2
    return (real)_mm_and_pd((__m128d)wanted, (__m128d)x);
#else
    return (real)(wanted & (mask)x);
#endif
}

static inline mask has_bit(word w, int k)
{
#if MASK_OF_BITS
    return (mask)_mm512_test_epi64_mask((__m512i)w, _mm512_set1_epi64(1LL << k));
#else
    return (mask)((w >> k & 1) != 0);
#endif
}

#endif

/* comparisons; a side may be a plain number, hence no functions */
#if STEIN_LANES == 0
#include "tangent.h"
#elif STEIN_LANES > 1 && MASK_OF_BITS
#define COMPARED(a, b, how) \
    ((mask)_mm512_cmp_pd_mask((__m512d)STEIN_ALL(a), (__m512d)STEIN_ALL(b), how))
#define less(a, b)    COMPARED(a, b, _CMP_LT_OQ)
#define more(a, b)    COMPARED(a, b, _CMP_GT_OQ)
#define at_most(a, b) COMPARED(a, b, _CMP_LE_OQ)
#define differ(a, b)  COMPARED(a, b, _CMP_NEQ_UQ)
#else
#define less(a, b)    ((mask)((a) < (b)))
#define more(a, b)    ((mask)((a) > (b)))
#define at_most(a, b) ((mask)((a) <= (b)))
#define differ(a, b)  ((mask)((a) != (b)))
#endif

/* the same number in all lanes */
static inline real same(double x)
{
    return STEIN_ALL(x);
}

static inline real smaller(real a, real b)
{
    return sel(less(a, b), a, b);
}

#if STEIN_LANES > 0
static inline word bits_of(real x)
{
    word bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline real of_bits(word bits)
{
    real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
#endif

#endif
