/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_elementary.c - the elementary functions of the core, against libm in long double.
 */
#include <errno.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "elementary.h"
#include "lane.h"
#include "lanes/functions_wide.h"
#include "support.h"

enum { TRIES = 200000 };

/* how far `got` is from `exact`, in units of the last place of the latter */
static double ulps(double got, long double exact)
{
    int exponent;
    (void)frexpl(exact, &exponent);
    return (double)(fabsl((long double)got - exact) / ldexpl(1.0L, exponent - 53));
}

/* numbers of both signs, as many small ones as large ones, up to `most` */
static double wide(unsigned long long *seed, double most)
{
    double size = most * exp2(-15.0 * (1.0 + noise(seed)));
    return noise(seed) < 0.0 ? -size : size;
}

/* long double has no error to speak of only where it is wider than double */
#define NEEDS_WIDE_LONG_DOUBLE \
    if (LDBL_MANT_DIG < 64)    \
    return

START_TEST(sine_and_cosine_are_right_to_one_ulp)
{
    NEEDS_WIDE_LONG_DOUBLE;
    static const double range[] = {0.7853981633974483, 10.0, 9.9e4, 1e12, 1e300};
    unsigned long long seed = 11;
    for (int i = 0; i < TRIES; i++) {
        double x = wide(&seed, range[i % 5]), s, c;
        stein__sincos(x, &s, &c);
        ck_assert_msg(ulps(s, sinl(x)) < 1.0, "sin(%.17g) = %.17g", x, s);
        ck_assert_msg(ulps(c, cosl(x)) < 1.0, "cos(%.17g) = %.17g", x, c);
    }
}
END_TEST

START_TEST(sine_and_cosine_are_right_beside_multiples_of_a_right_angle)
{
    NEEDS_WIDE_LONG_DOUBLE;
    for (int n = -50000; n <= 50000; n++) {
        for (int beside = -1; beside <= 1; beside++) {
            double x = n * 1.5707963267948966, s, c;
            x = beside ? nextafter(x, beside * HUGE_VAL) : x;
            stein__sincos(x, &s, &c);
            ck_assert_msg(fabsl(s - sinl(x)) <= 0x1p-53 * fabsl(s) + 1e-24, "sin(%.17g)", x);
            ck_assert_msg(fabsl(c - cosl(x)) <= 0x1p-53 * fabsl(c) + 1e-24, "cos(%.17g)", x);
        }
    }
}
END_TEST

/* where a double comes nearest to a multiple of pi/2: 6381956970095103 * 2^797 */
START_TEST(the_worst_angle_of_all_is_right)
{
    NEEDS_WIDE_LONG_DOUBLE;
    double x = ldexp(6381956970095103.0, 797), s, c;
    stein__sincos(x, &s, &c);
    ck_assert_msg(ulps(c, cosl(x)) < 1.0, "cos = %.17g, expected %.17g", c, (double)cosl(x));
    ck_assert(s == (double)sinl(x));
    ck_assert_msg(ulps(stein__tan(x), tanl(x)) < 1.0, "tan");
    stein__sincos(DBL_MAX, &s, &c);
    ck_assert(ulps(s, sinl(DBL_MAX)) < 1.0 && ulps(c, cosl(DBL_MAX)) < 1.0);
}
END_TEST

START_TEST(tangent_is_right_to_one_ulp)
{
    NEEDS_WIDE_LONG_DOUBLE;
    static const double range[] = {0.7853981633974483, 10.0, 9.9e4, 1e12, 1e300};
    unsigned long long seed = 23;
    double worst = 0.0;
    for (int i = 0; i < TRIES; i++) {
        double x = wide(&seed, range[i % 5]);
        worst = fmax(worst, ulps(stein__tan(x), tanl(x)));
    }
    ck_assert_msg(worst < 1.0, "off by %g ulp", worst);
    for (int n = -5000; n <= 5000; n++) {
        double x = n * 1.5707963267948966;
        ck_assert_msg(n == 0 || ulps(stein__tan(x), tanl(x)) < 1.0, "tan(%.17g)", x);
    }
}
END_TEST

START_TEST(powers_are_right_to_one_ulp)
{
    NEEDS_WIDE_LONG_DOUBLE;
    unsigned long long seed = 29;
    double worst = 0.0;
    for (int i = 0; i < TRIES; i++) {
        double x = exp(wide(&seed, i % 2 ? 700.0 : 5.0)), y = wide(&seed, i % 3 ? 3.0 : 700.0);
        long double exact = powl(x, y);
        if (exact > DBL_MIN && exact < DBL_MAX) {
            worst = fmax(worst, ulps(stein__power(x, y), exact));
        }
    }
    ck_assert_msg(worst < 1.0, "off by %g ulp", worst);
}
END_TEST

/* hi + lo is x^n to some 100 bits, whatever long double is */
static void whole_power(double x, int n, double *hi, double *lo)
{
    *hi = 1.0;
    *lo = 0.0;
    for (int i = 0; i < n; i++) {
        double product = *hi * x, rest = fma(*hi, x, -product) + *lo * x;
        *hi = product + rest;
        *lo = rest - (*hi - product);
    }
}

static double power_ulps(double x, double y, double hi, double lo)
{
    int exponent;
    (void)frexp(hi, &exponent);
    return fabs((stein__power(x, y) - hi) - lo) / ldexp(1.0, exponent - 53);
}

START_TEST(whole_and_half_powers_are_right_to_one_ulp)
{
    unsigned long long seed = 37;
    for (int i = 0; i < TRIES / 4; i++) {
        double x = exp(wide(&seed, i % 2 ? 20.0 : 0.7)), hi, lo;
        int n = 1 + i % 23;
        whole_power(x, n, &hi, &lo);
        ck_assert_msg(power_ulps(x, n, hi, lo) < 1.0, "%.17g^%d", x, n);
        hi = sqrt(x);
        lo = fma(-hi, hi, x) / (2.0 * hi);
        ck_assert_msg(power_ulps(x, 0.5, hi, lo) < 1.0, "%.17g^0.5", x);
    }
}
END_TEST

START_TEST(powers_have_the_ends_of_double)
{
    ck_assert(stein__power(2.0, -1074.0) == 0x1p-1074 && stein__power(2.0, 1023.0) == 0x1p1023);
    ck_assert(isinf(stein__power(2.0, 1024.0)) && stein__power(0.0, 0.7) == 0.0);
    ck_assert(isnan(stein__power(-1.0, 0.5)) && stein__power(1.37, 0.0) == 1.0);
}
END_TEST

/* results that are no normal numbers are right to half of their last bit and a little */
START_TEST(exp_and_log_are_right_at_their_ends)
{
    NEEDS_WIDE_LONG_DOUBLE;
    unsigned long long seed = 31;
    for (int i = 0; i < TRIES / 4; i++) {
        double up = 700.0 + 9.78 * fabs(noise(&seed)), down = -700.0 - 45.0 * fabs(noise(&seed));
        ck_assert_msg(ulps(stein__exp(up), expl(up)) < 1.0, "exp(%.17g)", up);
        long double exact = expl(down), off = fabsl(stein__exp(down) - exact);
        ck_assert_msg(off <= 0x1p-1075L + 0x1p-52L * exact, "exp(%.17g)", down);
        double tiny = 1e-300 * exp2(-22.0 * (1.0 + noise(&seed))) * 0.7;
        double large = 1e300 * (1.0 + 1e8 * fabs(noise(&seed)));
        ck_assert_msg(ulps(stein__log(tiny), logl(tiny)) < 1.0, "log(%.17g)", tiny);
        ck_assert_msg(ulps(stein__log(large), logl(large)) < 1.0, "log(%.17g)", large);
    }
    ck_assert(stein__exp(709.782712893384) > 1.797e308 && isinf(stein__exp(709.7827128933841)));
    ck_assert(stein__log(0x1p-1074) == (double)logl(0x1p-1074L));
}
END_TEST

START_TEST(exp_and_log_are_right_to_one_ulp)
{
    NEEDS_WIDE_LONG_DOUBLE;
    unsigned long long seed = 13;
    for (int i = 0; i < TRIES; i++) {
        double x = wide(&seed, i % 2 ? 690.0 : 1.0), y = exp(x);
        ck_assert_msg(ulps(stein__exp(x), expl(x)) < 1.0, "exp(%.17g)", x);
        ck_assert_msg(ulps(stein__log(y), logl(y)) < 1.0, "log(%.17g)", y);
    }
}
END_TEST

START_TEST(exp_and_log_go_on_to_the_ends_of_double_and_leave_errno_alone)
{
    unsigned long long seed = 14;
    errno = 0;
    for (int i = 0; i < 2000; i++) {
        double x = 704.5 + 5.0 * noise(&seed); // libm writes errno behind 709.78
        double big = stein__exp(x), small = stein__exp(-x);
        ck_assert_close(big * exp(-700.0), exp(x - 700.0), 1e-12, 0.0);
        ck_assert_close(small * 0x1p300, exp(-x + 300.0 * log(2.0)), 1e-12, 0.0);
        ck_assert_close(stein__log(big), x, 1e-15, 0.0);
        ck_assert_close(stein__log(small * 0x1p-30), -x - 30.0 * log(2.0), 1e-6, 0.0);
    }
    double s, c, ends[] = {(double)INFINITY, -(double)INFINITY, (double)NAN, 1e308, -0.0, 5e-324};
    for (int i = 0; i < 6; i++) {
        stein__sincos(ends[i], &s, &c);
        s += stein__exp(ends[i]) + stein__log(ends[i]) + stein__tanh(ends[i]) + c;
    }
    ck_assert_int_eq(errno, 0);
    ck_assert_close(stein__log(5e-324), log(5e-324), 1e-15, 0.0);
    ck_assert(stein__exp(-(double)INFINITY) == 0.0 && stein__exp((double)INFINITY) > DBL_MAX);
}
END_TEST

START_TEST(tanh_is_right_to_one_ulp)
{
    NEEDS_WIDE_LONG_DOUBLE;
    // where it is worst, beside the joints of its pieces, and everywhere
    static const double from[] = {0.45, 0.54, 0.55, 0.8, 0.0}, to[] = {0.55, 0.56, 0.7, 0.95, 2.0};
    unsigned long long seed = 17;
    double worst = 0.0;
    for (int i = 0; i < TRIES; i++) {
        double x = wide(&seed, i % 2 ? 25.0 : 1.0), share = 0.5 * (1.0 + noise(&seed));
        worst = fmax(worst, ulps(stein__tanh(x), tanhl(x)));
        x = from[i % 5] + share * (to[i % 5] - from[i % 5]);
        worst = fmax(worst, ulps(stein__tanh(x), tanhl(x)));
    }
    ck_assert_msg(worst < 0.9, "off by %g ulp", worst); // the worst that 1e8 numbers showed: 0.82
}
END_TEST

START_TEST(tanh_does_not_fall_where_its_pieces_meet)
{
    static const double joint[] = {0.55, 20.0};
    for (int k = 0; k < 2; k++) {
        double x = joint[k] * (1.0 - 3e-13), before = stein__tanh(x);
        for (int i = 0; i < 4000; i++) {
            x = nextafter(x, 1e3);
            double y = stein__tanh(x);
            ck_assert_msg(y >= before && y <= 1.0, "tanh(%.17g) = %.17g", x, y);
            before = y;
        }
    }
}
END_TEST

/* ---- lanes ---- */

enum { MANY = 80000 };

static int same_bits(double a, double b)
{
    return isnan(a) ? isnan(b) : memcmp(&a, &b, sizeof a) == 0;
}

/* numbers in no order, so that lanes differ in what they need; ends of double among them */
static void lane_inputs(double *x, double *y)
{
    static const double range[] = {0.7, 2.0, 30.0, 690.0, 760.0, 1e5, 1e13, 1e300};
    static const double end[] = {0.0,  -0.0, 5e-324, 1e-310,   -1e308,
                                 0.55, 20.0, NAN,    HUGE_VAL, -HUGE_VAL};
    unsigned long long seed = 41;
    for (int i = 0; i < MANY; i++) {
        int which = (int)(4.0 * (1.0 + noise(&seed)));
        x[i] = wide(&seed, range[which]);
        y[i] = wide(&seed, i % 3 ? 3.0 : 700.0);
        if (i % 97 == 0) {
            x[i] = end[i / 97 % 10];
        }
    }
}

static void expected_of(const double *x, const double *y, int i, double f[LANE_FUNCTIONS])
{
    stein__sincos(x[i], &f[LANE_SIN], &f[LANE_COS]);
    f[LANE_TANH] = stein__tanh(x[i]);
    f[LANE_EXP] = stein__exp(x[i]);
    f[LANE_LOG] = stein__log(x[i]);
    f[LANE_POWER] = stein__power(fabs(x[i]), y[i]);
}

START_TEST(every_number_of_lanes_has_the_same_bits)
{
    static const struct {
        int lanes;
        lane_functions *all;
    } width[] = {
        {2, lane_functions_2},
#if STEIN_WIDEST >= 8
        {4, lane_functions_4},
        {8, lane_functions_8}
#endif
    };
    double *x = malloc(MANY * sizeof *x), *y = malloc(MANY * sizeof *y);
    double *out = malloc(LANE_FUNCTIONS * MANY * sizeof *out), f[LANE_FUNCTIONS];
    ck_assert(x != NULL && y != NULL && out != NULL);
    lane_inputs(x, y);
    for (int k = 0; k < (int)(sizeof width / sizeof *width); k++) {
        if (stein__processor_lanes() < width[k].lanes) {
            printf("no %d lanes on this processor: skipped\n", width[k].lanes);
            continue;
        }
        width[k].all(x, y, MANY, out);
        for (int i = 0; i < MANY; i++) {
            expected_of(x, y, i, f);
            for (int n = 0; n < LANE_FUNCTIONS; n++) {
                double got = out[(size_t)n * MANY + (size_t)i];
                ck_assert_msg(same_bits(got, f[n]), "%d lanes: function %d of %.17g: %.17g, %.17g",
                              width[k].lanes, n, x[i], got, f[n]);
            }
        }
    }
    free(x);
    free(y);
    free(out);
}
END_TEST

START_TEST(odd_functions_are_odd_and_even_ones_even)
{
    unsigned long long seed = 19;
    for (int i = 0; i < 1000; i++) {
        double x = wide(&seed, 30.0), s, c, s1, c1;
        stein__sincos(x, &s, &c);
        stein__sincos(-x, &s1, &c1);
        ck_assert(s1 == -s && c1 == c);
        ck_assert(stein__tanh(-x) == -stein__tanh(x));
    }
}
END_TEST

START_TEST(nan_stays_nan_and_ends_agree_with_libm)
{
    double s, c;
    stein__sincos(NAN, &s, &c);
    ck_assert(isnan(s) && isnan(c));
    stein__sincos((double)INFINITY, &s, &c);
    ck_assert(isnan(s) && isnan(c));
    stein__sincos(0.0, &s, &c);
    ck_assert(s == 0.0 && c == 1.0);
    ck_assert(isnan(stein__tanh(NAN)) && isnan(stein__exp(NAN)) && isnan(stein__log(NAN)));
    ck_assert(stein__tanh(0.0) == 0.0 && stein__tanh(1e300) == 1.0 && stein__tanh(-1e300) == -1.0);
    ck_assert(stein__exp(0.0) == 1.0 && stein__exp(-1e4) == 0.0 && isinf(stein__exp(1e4)));
    ck_assert(stein__log(1.0) == 0.0 && isinf(stein__log(0.0)) && isnan(stein__log(-1.0)));
    ck_assert(isnan(stein__tan(NAN)) && isnan(stein__tan((double)INFINITY)));
    ck_assert(stein__tan(0.0) == 0.0 && signbit(stein__tan(-0.0)));
    ck_assert(isinf(stein__log((double)INFINITY)) && isinf(stein__exp((double)INFINITY)));
    ck_assert(stein__exp(-(double)INFINITY) == 0.0 && isnan(stein__power(NAN, 2.0)));
}
END_TEST

Suite *elementary_suite(void)
{
    Suite *s = suite_create("elementary");
    TCase *t = tcase_create("functions");
    tcase_set_timeout(t, 60);
    tcase_add_test(t, sine_and_cosine_are_right_to_one_ulp);
    tcase_add_test(t, sine_and_cosine_are_right_beside_multiples_of_a_right_angle);
    tcase_add_test(t, the_worst_angle_of_all_is_right);
    tcase_add_test(t, tangent_is_right_to_one_ulp);
    tcase_add_test(t, powers_are_right_to_one_ulp);
    tcase_add_test(t, whole_and_half_powers_are_right_to_one_ulp);
    tcase_add_test(t, powers_have_the_ends_of_double);
    tcase_add_test(t, exp_and_log_are_right_to_one_ulp);
    tcase_add_test(t, exp_and_log_are_right_at_their_ends);
    tcase_add_test(t, exp_and_log_go_on_to_the_ends_of_double_and_leave_errno_alone);
    tcase_add_test(t, tanh_is_right_to_one_ulp);
    tcase_add_test(t, tanh_does_not_fall_where_its_pieces_meet);
    tcase_add_test(t, every_number_of_lanes_has_the_same_bits);
    tcase_add_test(t, odd_functions_are_odd_and_even_ones_even);
    tcase_add_test(t, nan_stays_nan_and_ends_agree_with_libm);
    suite_add_tcase(s, t);
    return s;
}
