/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_law.c - the force laws and the error texts.
 */
#include <string.h>

#include "support.h"

START_TEST(contact_force_is_the_damped_cubic)
{
    const double law[STEIN_NORMAL_SIZE] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    double x = 1.37e-4, v = 0.213;
    double fit = law[0] * x * x * x + law[1] * x * x + law[2] * x;
    ck_assert_close(stein_normal_force(law, x, v), fit * (1.0 + law[3] * v), 1e-14, 0.0);
}
END_TEST

START_TEST(contact_force_is_never_adhesive)
{
    const double law[STEIN_NORMAL_SIZE] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    ck_assert(stein_normal_force(law, 1e-4, -1.0 / 0.287 - 0.1) == 0.0);
    ck_assert(stein_normal_force(law, -1e-9, 5.0) == 0.0);
    ck_assert(stein_normal_force(law, 0.0, 5.0) == 0.0);
    ck_assert(stein_normal_force(law, NAN, 5.0) == 0.0);
}
END_TEST

START_TEST(exponent_hysteresis_and_preload_change_the_force_by_their_formulas)
{
    double law[STEIN_NORMAL_SIZE] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    double x = 1.37e-4, v = -0.0213, plain = stein_normal_force(law, x, v);
    law[STEIN_NORMAL_EXPONENT] = 0.37;
    ck_assert_close(stein_normal_force(law, x, v), plain * pow(1.37, 0.37), 1e-13, 0.0);
    law[STEIN_NORMAL_EXPONENT] = 0.0;
    law[STEIN_NORMAL_HYSTERESIS] = 0.23;
    ck_assert_close(stein_normal_force(law, x, v), plain * (1.0 + 0.23 * tanh(v / 0.01)), 1e-13,
                    0.0);
    law[STEIN_NORMAL_HYSTERESIS] = 0.0;
    law[STEIN_NORMAL_PRELOAD] = 1.7;
    ck_assert_close(stein_normal_force(law, x, v), plain + 1.7 * (1.0 + 0.287 * v), 1e-13, 0.0);
}
END_TEST

START_TEST(adhesion_pulls_within_its_range_and_nowhere_else)
{
    double law[STEIN_NORMAL_SIZE] = {6.91e11, 2.63e7, 1.47e4, 0.287};
    law[STEIN_NORMAL_ADHESION] = 0.31;
    law[STEIN_NORMAL_RANGE] = 7.3e-5;
    ck_assert_close(stein_normal_force(law, -0.5 * 7.3e-5, 0.4), -0.31, 1e-13,
                    0.0); // deepest in the middle
    ck_assert_close(stein_normal_force(law, -0.25 * 7.3e-5, 0.4), -0.75 * 0.31, 1e-13, 0.0);
    ck_assert(stein_normal_force(law, -7.4e-5, 0.4) == 0.0);
    ck_assert(stein_normal_force(law, 0.0, 0.4) == 0.0);
    ck_assert(stein_normal_force(law, 1e-5, 0.4) > 0.0);
}
END_TEST

START_TEST(a_joint_sums_its_forces)
{
    double law[STEIN_JOINT_SIZE] = {0};
    double q = 0.317, w = -0.83, q0 = -0.11;
    law[STEIN_JOINT_DRY_SPEED] = 0.07;
    law[STEIN_JOINT_FRICTION + STEIN_FRICTION_VT] = 0.05;
    ck_assert(stein_joint_force(law, q, w) == 0.0); // neutral
    law[STEIN_JOINT_K] = 0.041;
    law[STEIN_JOINT_Q0] = q0;
    law[STEIN_JOINT_K3] = 0.23;
    double sum = -0.041 * (q - q0) - 0.23 * pow(q - q0, 3.0);
    ck_assert_close(stein_joint_force(law, q, w), sum, 1e-13, 0.0);
    law[STEIN_JOINT_B] = 0.013;
    law[STEIN_JOINT_ASYMMETRY] = 0.19;
    sum -= 0.013 * (1.0 + 0.19 * tanh(w / 0.07)) * w;
    ck_assert_close(stein_joint_force(law, q, w), sum, 1e-13, 0.0);
    law[STEIN_JOINT_DRAG] = 0.0031;
    law[STEIN_JOINT_PRELOAD] = 0.0047;
    law[STEIN_JOINT_DRY] = 0.0071;
    sum += 0.0047 - 0.0031 * fabs(w) * w - 0.0071 * tanh(w / 0.07);
    ck_assert_close(stein_joint_force(law, q, w), sum, 1e-13, 0.0);
    law[STEIN_JOINT_DRY_ASYMMETRY] = -0.13;
    sum -= 0.0071 * -0.13 * tanh(w / 0.07) * tanh(w / 0.07);
    ck_assert_close(stein_joint_force(law, q, w), sum, 1e-13, 0.0);
    law[STEIN_JOINT_DRY_ASYMMETRY] = 0.0;
    sum += 0.0071 * -0.13 * tanh(w / 0.07) * tanh(w / 0.07);
    law[STEIN_JOINT_STOP_K] = 0.53;
    law[STEIN_JOINT_STOP_GAP] = 0.21;
    ck_assert_close(stein_joint_force(law, q, w), sum - 0.53 * (q - 0.21), 1e-13, 0.0);
    ck_assert_close(stein_joint_force(law, -q, w) - stein_joint_force(law, -0.21, w),
                    0.041 * (q - 0.21) + 0.23 * (pow(q + q0, 3.0) - pow(0.21 + q0, 3.0)) +
                        0.53 * (q - 0.21),
                    1e-12, 0.0);
}
END_TEST

START_TEST(a_link_may_push_only_and_let_go_above_a_height)
{
    double law[STEIN_LINK_SIZE] = {
        [STEIN_LINK_K] = 917.0, [STEIN_LINK_LENGTH] = 0.0613, [STEIN_LINK_B] = 0.71};
    law[STEIN_LINK_OFF_RANGE] = 3.1e-4;
    double pull = 917.0 * (0.0621 - 0.0613) + 0.71 * 0.13, push = 917.0 * (0.0609 - 0.0613);
    ck_assert_close(stein_link_force(law, 0.0621, 0.13, 0.02), pull, 1e-12, 0.0);
    ck_assert_close(stein_link_force(law, 0.0609, 0.0, 0.02), push, 1e-12, 0.0);
    law[STEIN_LINK_SLACK] = 0.37;
    ck_assert_close(stein_link_force(law, 0.0621, 0.13, 0.02), 0.63 * pull, 1e-12, 0.0);
    ck_assert_close(stein_link_force(law, 0.0609, 0.0, 0.02), push, 1e-12, 0.0);
    law[STEIN_LINK_SLACK] = 1.0;
    ck_assert(stein_link_force(law, 0.0621, 0.13, 0.02) == 0.0);
    law[STEIN_LINK_OFF] = 0.83;
    law[STEIN_LINK_OFF_Z] = 0.0204;
    double past = 0.5 * (1.0 + tanh((0.0202 - 0.0204) / 3.1e-4));
    ck_assert_close(stein_link_force(law, 0.0609, 0.0, 0.0202), push * (1.0 - 0.83 * past), 1e-12,
                    0.0);
    law[STEIN_LINK_OFF] = 1.0;
    ck_assert_close(stein_link_force(law, 0.0609, 0.0, 0.0304), 0.0, 0.0, 1e-15);
}
END_TEST

START_TEST(friction_is_odd_and_saturates_at_A)
{
    const double law[STEIN_FRICTION_SIZE] = {0.31, 0.0123, 0.61, 0.13};
    ck_assert_close(stein_friction(law, -0.017), -stein_friction(law, 0.017), 0.0, 0.0);
    ck_assert_close(stein_friction(law, 40.0), 0.31, 1e-9, 0.0);
    ck_assert(stein_friction(law, 0.0) == 0.0);
}
END_TEST

START_TEST(static_surplus_peaks_at_the_place_of_the_formula)
{
    // A = 1 and the tanh taken off leaves the second term alone
    const double law[STEIN_FRICTION_SIZE] = {1.0, 0.0123, 0.61, 0.13};
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
            ck_assert_str_ne(stein_status_text((stein_status)i),
                             stein_status_text((stein_status)k));
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
    tcase_add_test(tc, exponent_hysteresis_and_preload_change_the_force_by_their_formulas);
    tcase_add_test(tc, adhesion_pulls_within_its_range_and_nowhere_else);
    tcase_add_test(tc, a_joint_sums_its_forces);
    tcase_add_test(tc, a_link_may_push_only_and_let_go_above_a_height);
    tcase_add_test(tc, friction_is_odd_and_saturates_at_A);
    tcase_add_test(tc, static_surplus_peaks_at_the_place_of_the_formula);
    tcase_add_test(tc, every_status_has_a_text_of_its_own);
    suite_add_tcase(suite, tc);
    return suite;
}
