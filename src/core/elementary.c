/* SPDX-License-Identifier: MIT
 * elementary.c - elementary functions beyond their common ranges, and rarely used ones.
 *
 * The common ranges of sine, cosine, exp and log are inline (elementary.h). Here are their ends,
 * tangent and power; so nothing of libm that rounds in its own way is left in the core.
 *
 *   sincos  far out: x = m 2^e times as many bits of 2/pi as matter (Payne & Hanek 1983)
 *   tan     sine and cosine of the reduced angle with their tails, and the quotient corrected
 *   power   log x = n ln 2 + 2 (s + s^3/3 + s^5/5 ...) in pairs of doubles, s = f / (2 + f), so
 * that y log x keeps all digits that its exponential needs
 *
 * A pair is a sum high + low of doubles, low below half a unit of high; products are exact by
 * splitting factors in halves (Dekker 1971), without fused multiplication.
 */
#include "elementary.h"

typedef struct two {
    double high, low;
} two;

/* a + b where |a| >= |b| or a is 0 */
static two sum_of(double a, double b)
{
    double high = a + b;
    return (two){high, b - (high - a)};
}

/* the upper 26 bits of x */
static double upper(double x)
{
    return of_bits(bits_of(x) & 0xfffffffff8000000);
}

static two product_of(double a, double b)
{
    double a1 = upper(a), a2 = a - a1, b1 = upper(b), b2 = b - b1, high = a * b;
    return (two){high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2};
}

static two times(two a, two b)
{
    two p = product_of(a.high, b.high);
    return sum_of(p.high, p.low + (a.high * b.low + a.low * b.high));
}

/* a + b where |a| is larger, or not much smaller */
static two plus(two a, two b)
{
    two s = fabs(a.high) >= fabs(b.high) ? sum_of(a.high, b.high) : sum_of(b.high, a.high);
    return sum_of(s.high, s.low + (a.low + b.low));
}

/* a / b, from the remainder of the plain quotient */
static two quotient(two a, two b)
{
    double high = a.high / b.high;
    two p = product_of(high, b.high);
    return sum_of(high, ((a.high - p.high) - p.low + (a.low - high * b.low)) / b.high);
}

/* ---- sine and cosine far out ---- */

/* 2/pi in words of 32 bits: the first bit counts 1/2 */
static const uint32_t two_over_pi[] = {
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
    0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484,
    0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f,
    0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b,
    0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab};
enum { WORDS = sizeof two_over_pi / sizeof *two_over_pi, WINDOW = 6 };

/* the 32 bits of 2/pi from bit `at`, which may be negative */
static uint32_t bits_from(int at)
{
    int first = at >= 0 ? at / 32 : -((31 - at) / 32), shift = at - 32 * first;
    uint64_t high = first >= 0 && first < WORDS ? two_over_pi[first] : 0;
    uint64_t low = first + 1 >= 0 && first + 1 < WORDS ? two_over_pi[first + 1] : 0;
    return (uint32_t)((high << 32 | low) << shift >> 32);
}

/* m 2^e 2/pi modulo 4, in 192 bits, of which the first two are whole */
static void turns(uint64_t m, int e, uint32_t product[WINDOW])
{
    uint64_t m0 = m & 0xffffffff, m1 = m >> 32, carry = 0;
    for (int i = WINDOW - 1; i >= 0; i--) {
        uint64_t w = bits_from(e - 2 + 32 * i);
        uint64_t next = i + 1 < WINDOW ? bits_from(e - 2 + 32 * (i + 1)) : 0;
        uint64_t a = m0 * w, b = m1 * next;
        uint64_t lower = (a & 0xffffffff) + (b & 0xffffffff) + (carry & 0xffffffff);
        product[i] = (uint32_t)lower;
        carry = (a >> 32) + (b >> 32) + (carry >> 32) + (lower >> 32);
    }
}

/* the binary fraction 0.f of 32-bit words as a pair; f[0] counts 1/4 of a unit at its second bit */
static two fraction(const uint32_t f[WINDOW])
{
    two sum = {0.0, 0.0};
    double unit = 0x1p-30; /* of the last bit of a word: two bits of the first one are whole */
    for (int i = 0; i < WINDOW; i++, unit *= 0x1p-32) {
        double part = unit * (double)f[i];
        two s = sum_of(sum.high, part);
        sum = sum.high == 0.0 ? (two){part, 0.0} : sum_of(s.high, s.low + sum.low);
    }
    return sum;
}

/* |x| = (n + r) pi/2, |r| <= 1/2, at any size; r pi/2 as a pair */
static two reduce(double x, uint64_t *quadrant)
{
    static const two half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
    uint64_t pattern = bits_of(x) & 0x7fffffffffffffff;
    uint32_t f[WINDOW];
    turns((pattern & 0x000fffffffffffff) | 0x0010000000000000, (int)(pattern >> 52) - 1075, f);
    *quadrant = f[0] >> 30;
    f[0] &= 0x3fffffff;
    int more = f[0] >> 29 != 0; // beyond the half: from the next multiple, backwards
    for (int i = 0; more && i < WINDOW; i++) {
        f[i] = i == 0 ? ~f[i] & 0x3fffffff : ~f[i];
    }
    *quadrant += (uint64_t)more;
    two r = times(fraction(f), half_pi);
    return more ? (two){-r.high, -r.low} : r;
}

static void sincos_huge(double x, double *s, double *c)
{
    if (!isfinite(x)) {
        *s = *c = x - x;
        return;
    }
    uint64_t quadrant;
    two r = reduce(x, &quadrant);
    stein__sincos_turned(r.high, r.low, quadrant, s, c);
    *s = x < 0.0 ? -*s : *s;
}

double stein__sine_huge(double x)
{
    double s, c;
    sincos_huge(x, &s, &c);
    return s;
}

double stein__cosine_huge(double x)
{
    double s, c;
    sincos_huge(x, &s, &c);
    return c;
}

/* ---- sine, cosine, tangent by themselves ---- */

double stein__sin(double x)
{
    double s, c;
    stein__sincos(x, &s, &c);
    return s;
}

double stein__cos(double x)
{
    double s, c;
    stein__sincos(x, &s, &c);
    return c;
}

double stein__tan(double x)
{
    if (!isfinite(x)) {
        return x - x;
    }
    uint64_t quadrant = 0;
    two r = {fabs(x), 0.0};
    if (r.high > 0.7853981633974483) {
        r = reduce(x, &quadrant);
    }
    double y = r.high;
    two z = times(r, r);
    two sine = sum_of(y, y * z.high * (stein__sine_cubic + z.high * stein__sine_rest(z.high)) +
                             r.low * (1.0 - 0.5 * z.high));
    two cosine = sum_of(1.0, -0.5 * z.high);
    cosine = sum_of(cosine.high, cosine.low + (z.high * stein__cosine_rest(z.high) - 0.5 * z.low));
    two t = quadrant & 1 ? quotient(cosine, sine) : quotient(sine, cosine);
    double tangent = quadrant & 1 ? -t.high : t.high;
    return x < 0.0 ? -tangent : x == 0.0 ? x : tangent;
}

/* ---- the ends of exp and log ---- */

/* e^(x + little), |x| <= 750, by a power of 2 that may be no double: in two halves */
static double exp_of(double x, double little)
{
    stein__exponent p = stein__exp_parts(x);
    double c = p.r - p.even, curved = p.r * c / (2.0 - c);
    double y = 1.0 - ((p.low - curved) - p.high);
    y = 1.0 - ((p.low - little * y - curved) - p.high);
    int n = (int)(bits_of(p.power) >> 52) - 1023; // 12 bits of it
    n -= n > 1100 ? 4096 : 0;
    int half = n / 2;
    y *= of_bits((uint64_t)(half + 1023) << 52);
    return y * of_bits((uint64_t)(n - half + 1023) << 52);
}

double stein__exp_end(double x)
{
    return isnan(x) ? x : x > 750.0 ? (double)INFINITY : x < -750.0 ? 0.0 : exp_of(x, 0.0);
}

double stein__log_end(double x)
{
    if (!(x > 0.0)) {
        return x == 0.0 ? -(double)INFINITY : (double)NAN;
    }
    if (!isfinite(x)) {
        return x;
    }
    return x < 1.0 ? stein__log_shifted(x * 0x1p200, -200.0) : stein__log_shifted(x, 0.0);
}

double stein__exp_of(double x)
{
    return stein__exp(x);
}

double stein__tanh_of(double x)
{
    return stein__tanh(x);
}

double stein__log_of(double x)
{
    return stein__log(x);
}

/* ---- power ---- */

/* log x of a finite x > 0, to some 2^-65 of it */
static two log_of(double x)
{
    double n = 0.0;
    if (x < 1e-300) {
        x *= 0x1p200;
        n = -200.0;
    }
    uint64_t pattern = bits_of(x) + 0x00095f6200000000;
    n += (double)((int64_t)(pattern >> 52) - 1023);
    double f = of_bits((pattern & 0x000fffffffffffff) + 0x3fe6a09e00000000) - 1.0;
    two s = quotient((two){f, 0.0}, sum_of(2.0, f)), z = times(s, s);
    double tail = 0.0;
    for (int k = 27; k >= 5; k -= 2) {
        tail = tail * z.high + 2.0 / k;
    }
    static const two two_thirds = {0x1.5555555555555p-1, 0x1.5555555555555p-55};
    two cubic = times(z, plus(two_thirds, sum_of(z.high * tail, z.low * 0.4)));
    two log_m = times(s, plus((two){2.0, 0.0}, cubic));
    two whole = sum_of(n * 6.93147180369123816490e-01, n * 1.90821492927058770002e-10);
    return plus(whole, log_m);
}

double stein__power(double x, double y)
{
    if (!(x > 0.0) || !isfinite(x) || !isfinite(y)) {
        return stein__exp(y * stein__log(x));
    }
    two e = log_of(x), p = product_of(y, e.high);
    p = sum_of(p.high, p.low + y * e.low);
    if (!(fabs(p.high) < 750.0)) {
        return stein__exp(p.high);
    }
    return exp_of(p.high, p.low);
}
