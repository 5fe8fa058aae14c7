/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_facts.c - the published facts of the regulation (one parameter set, models/stein1788.yaml).
 *
 * Source: the study of the Stein action, section 5: everything with the 100 g load, dx the shift of
 * the pawl's stop, positive to the right. Bounds are those the project promises.
 */
#include <string.h>

#include <gsl/gsl_fit.h>

#include "stein/lab.h"
#include "support.h"

enum { FIRST = -30, LAST = 6, N = LAST - FIRST + 1 }; /* dx in steps of 0.05 mm */

static lab_stroke table[N];

static const lab_stroke *at(int step)
{
    return &table[step - FIRST];
}

/* one stroke of 0.25 s with the load on, then 0.5 s without it */
static void sweep(void)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    for (int k = FIRST; k <= LAST; k++) {
        lab_stroke_def def = {.until = 0.75, .release = 0.25};
        if (k >= 6) {
            def = (lab_stroke_def){.until = 0.5, .release = NAN}; // no escape must stay no escape
        }
        ck_assert_stein(stein_set(sim, "pawl.stop_shift", 0.05e-3 * k, err));
        ck_assert_stein(stein_reset(sim, err));
        ck_assert_stein(lab_strike(sim, &def, &table[k - FIRST], err));
    }
    stein_sim_destroy(sim);
}

/* straight line through the strokes of dx = -1.2 .. 0 mm in 0.1 mm steps */
static void fit(double (*value)(const lab_stroke *), double *slope, double *r2, double *residual)
{
    double x[13], y[13], c0, c1, cov[3], sumsq, mean = 0.0, total = 0.0;
    for (int i = 0; i < 13; i++) {
        x[i] = 1e-3 * (-1.2 + 0.1 * i);
        y[i] = value(at(-24 + 2 * i));
        mean += y[i] / 13.0;
    }
    gsl_fit_linear(x, 1, y, 1, 13, &c0, &c1, &cov[0], &cov[1], &cov[2], &sumsq);
    *residual = 0.0;
    for (int i = 0; i < 13; i++) {
        total += (y[i] - mean) * (y[i] - mean);
        *residual = fmax(*residual, fabs(y[i] - c0 - c1 * x[i]));
    }
    *slope = c1;
    *r2 = 1.0 - sumsq / total;
}

static double height(const lab_stroke *s)
{
    return s->escape_height;
}

static double force(const lab_stroke *s)
{
    return s->peak_string_force;
}

START_TEST(the_hammer_escapes_2_2_mm_below_the_string)
{
    printf("escapement height at dx = 0: %.3f mm (paper 2.2)\n", 1e3 * height(at(0)));
    ck_assert_close(height(at(0)), 2.2e-3, 0.0, 0.1e-3);
}
END_TEST

START_TEST(escapement_height_falls_20_mm_per_mm)
{
    double slope, r2, residual;
    fit(height, &slope, &r2, &residual);
    printf("slope of the escapement height: %.2f mm/mm, residuals up to %.2f mm (paper -20)\n",
           slope, 1e3 * residual);
    ck_assert_close(slope, -20.0, 0.0, 1.5);
    ck_assert(residual < 1e-3);
}
END_TEST

START_TEST(too_far_left_the_notch_misses_the_beak)
{
    for (int k = FIRST; k <= -27; k++) {
        ck_assert_msg(at(k)->outcome == LAB_MISSED_NOTCH, "dx = %.2f mm: %s", 0.05 * k,
                      lab_outcome_text(at(k)->outcome));
    }
    for (int k = -25; k <= -24; k++) {
        ck_assert_msg(at(k)->outcome == LAB_STRUCK && at(k)->escaped, "dx = %.2f mm: %s", 0.05 * k,
                      lab_outcome_text(at(k)->outcome));
    }
}
END_TEST

START_TEST(near_0_2_mm_escapement_is_forced_after_the_impact)
{
    for (int k = 3; k <= 4; k++) {
        ck_assert_msg(at(k)->escaped && at(k)->forced_escapement &&
                          at(k)->escape_time > at(k)->impact_time,
                      "dx = %.2f mm: escaped %d at %g s, impact at %g s", 0.05 * k, at(k)->escaped,
                      at(k)->escape_time, at(k)->impact_time);
        ck_assert(at(k)->free_flight == 0.0);
    }
    ck_assert(!at(0)->forced_escapement && at(0)->free_flight > 0.0);
}
END_TEST

START_TEST(too_far_right_there_is_no_escapement)
{
    ck_assert_msg(at(6)->outcome == LAB_NO_ESCAPEMENT, "%s", lab_outcome_text(at(6)->outcome));
}
END_TEST

START_TEST(peak_force_falls_one_newton_per_0_2_mm_and_is_flat_to_the_right)
{
    double slope, r2, residual, change = 0.0;
    fit(force, &slope, &r2, &residual);
    for (int k = 1; k <= 3; k++) {
        change = fmax(change, fabs(force(at(k)) / force(at(0)) - 1.0));
    }
    printf(
        "peak force at dx = 0: %.2f N, slope %.2f N/mm, R2 %.4f, change on 0..+0.15 mm %.1f %%\n",
        force(at(0)), 1e-3 * slope, r2, 100.0 * change);
    ck_assert_close(1e-3 * slope, 5.0, 0.0, 1.0);
    ck_assert(r2 >= 0.97);
    ck_assert(change < 0.10);
    ck_assert(force(at(0)) > 6.25);
}
END_TEST

START_TEST(escapement_comes_later_and_impact_earlier_to_the_right)
{
    for (int k = -23; k <= 4; k++) {
        ck_assert_msg(at(k)->escape_time > at(k - 1)->escape_time, "dx = %.2f mm", 0.05 * k);
    }
    for (int k = -23; k <= 0; k++) {
        ck_assert_msg(at(k)->impact_time < at(k - 1)->impact_time, "dx = %.2f mm", 0.05 * k);
    }
    double left = at(-24)->impact_time - at(-12)->impact_time;
    double right = at(-12)->impact_time - at(0)->impact_time;
    ck_assert_msg(right < 0.5 * left, "towards an asymptote: %g then %g s", left, right);
    for (int k = 1; k <= 4; k++) {
        ck_assert_msg(at(k)->free_flight < 1.5e-3, "dx = %.2f mm: %g s", 0.05 * k,
                      at(k)->free_flight);
    }
}
END_TEST

START_TEST(the_action_rearms_over_the_whole_working_range)
{
    for (int k = -25; k <= 4; k++) {
        ck_assert_msg(at(k)->rearmed, "dx = %.2f mm", 0.05 * k);
    }
}
END_TEST

START_TEST(the_stroke_has_the_size_of_a_real_one)
{
    const lab_stroke *s = at(0);
    printf("impact at %.1f ms with %.3f m/s, %d impact(s)\n", 1e3 * s->impact_time, s->impact_speed,
           s->impacts);
    ck_assert(s->impact_time > 45e-3 && s->impact_time < 70e-3);
    ck_assert(s->impact_speed > 0.9 && s->impact_speed < 1.4);
    ck_assert_int_eq(s->impacts, 1);
}
END_TEST

Suite *facts_suite(void)
{
    Suite *suite = suite_create("facts");
    TCase *tc = tcase_create("facts");
    tcase_set_timeout(tc, 120.0);
    tcase_add_unchecked_fixture(tc, sweep, NULL);
    tcase_add_test(tc, the_hammer_escapes_2_2_mm_below_the_string);
    tcase_add_test(tc, escapement_height_falls_20_mm_per_mm);
    tcase_add_test(tc, too_far_left_the_notch_misses_the_beak);
    tcase_add_test(tc, near_0_2_mm_escapement_is_forced_after_the_impact);
    tcase_add_test(tc, too_far_right_there_is_no_escapement);
    tcase_add_test(tc, peak_force_falls_one_newton_per_0_2_mm_and_is_flat_to_the_right);
    tcase_add_test(tc, escapement_comes_later_and_impact_earlier_to_the_right);
    tcase_add_test(tc, the_action_rearms_over_the_whole_working_range);
    tcase_add_test(tc, the_stroke_has_the_size_of_a_real_one);
    suite_add_tcase(suite, tc);
    return suite;
}
