/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_law.c - the force laws and the error texts.
 */
#include <string.h>

#include "support.h"

START_TEST(contact_force_is_the_damped_cubic)
{
    const double law[4] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    double x = 1.37e-4, v = 0.213;
    double fit = law[0] * x * x * x + law[1] * x * x + law[2] * x;
    ck_assert_close(stein_normal_force(law, x, v), fit * (1.0 + law[3] * v), 1e-14, 0.0);
}
END_TEST

START_TEST(contact_force_is_never_adhesive)
{
    const double law[4] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    ck_assert(stein_normal_force(law, 1e-4, -1.0 / 0.287 - 0.1) == 0.0);
    ck_assert(stein_normal_force(law, -1e-9, 5.0) == 0.0);
    ck_assert(stein_normal_force(law, 0.0, 5.0) == 0.0);
    ck_assert(stein_normal_force(law, NAN, 5.0) == 0.0);
}
END_TEST

START_TEST(friction_is_odd_and_saturates_at_A)
{
    const double law[4] = {0.31, 0.0123, 0.61, 0.13};
    ck_assert_close(stein_friction(law, -0.017), -stein_friction(law, 0.017), 0.0, 0.0);
    ck_assert_close(stein_friction(law, 40.0), 0.31, 1e-9, 0.0);
    ck_assert(stein_friction(law, 0.0) == 0.0);
}
END_TEST

START_TEST(static_surplus_peaks_where_the_formula_says)
{
    // A = 1 and the tanh taken off leaves the second term alone
    const double law[4] = {1.0, 0.0123, 0.61, 0.13};
    double u = pow(1.0 / (3.0 * 0.13), 0.25);
    double at = stein_friction(law, u * 0.0123) - tanh(u);
    ck_assert_close(at, 0.75 * 0.61 * u, 1e-13, 0.0);
    ck_assert(at > stein_friction(law, 1.001 * u * 0.0123) - tanh(1.001 * u));
    ck_assert(at > stein_friction(law, 0.999 * u * 0.0123) - tanh(0.999 * u));
}
END_TEST

START_TEST(every_status_has_a_text_of_its_own)
{
    for (int i = 0; i < STEIN_STATUS_COUNT; i++) {
        ck_assert(strlen(stein_status_text((stein_status)i)) > 3);
        for (int k = 0; k < i; k++) {
            ck_assert_str_ne(stein_status_text((stein_status)i), stein_status_text((stein_status)k));
        }
    }
    ck_assert_str_eq(stein_status_text(STEIN_STATUS_COUNT), "unknown status");
    ck_assert_str_eq(stein_status_text((stein_status)-1), "unknown status");
}
END_TEST

Suite *law_suite(void)
{
    Suite *suite = suite_create("law");
    TCase *tc = tcase_create("law");
    tcase_add_test(tc, contact_force_is_the_damped_cubic);
    tcase_add_test(tc, contact_force_is_never_adhesive);
    tcase_add_test(tc, friction_is_odd_and_saturates_at_A);
    tcase_add_test(tc, static_surplus_peaks_where_the_formula_says);
    tcase_add_test(tc, every_status_has_a_text_of_its_own);
    suite_add_tcase(suite, tc);
    return suite;
}
