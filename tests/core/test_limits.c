/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_limits.c - stops of joints: the law, its usual stiffness, alone and in lanes, its
 * derivatives, refusals.
 */
#include <string.h>

#include "lab_support.h"
#include "refused.h"
#include "stein/batch.h"
#include "stein/derivative.h"

Suite *limits_suite(void);

/* a sled between two stops and a pendulum on it */
static const char file[] = "mechanism: stops\n"
                           "gravity: [0, 0, %s]\n"
                           "bodies:\n"
                           "  sled: {joint: T x, mass: 1.7 kg, limits: %s, initial: {speed: 0.5 "
                           "m/s}}\n"
                           "%s"
                           "simulation: {dt: 20 us, until: 1 s}\n";
static const char arm[] = "  arm: {parent: sled, joint: R -y, mass: 0.2 kg, centre: [0.02, 0, "
                          "-0.1], inertia: {yy: 5e-4}, limits: [-0.4 rad, 0.3 rad], initial: "
                          "{speed: 4 rad/s}}\n";
static const double pi = 3.14159265358979323846;

static stein_sim *start(lab_model **model, const char *g, const char *limits, const char *more)
{
    char text[1000];
    stein_sim *sim = NULL;
    snprintf(text, sizeof text, file, g, limits, more);
    *model = open_text(text, NULL, 0);
    ck_assert_stein(lab_sim(*model, NULL, &sim, err));
    return sim;
}

static void finish(stein_sim *sim, lab_model *model)
{
    stein_sim_destroy(sim);
    lab_close(model);
}

START_TEST(a_sled_between_stops_without_loss_is_back_after_two_flights_and_one_swing)
{
    lab_model *model;
    stein_sim *sim = start(&model, "0", "{range: [-10 mm, 20 mm], k: 9 kN/m}", "");
    double period = 2.0 * 0.03 / 0.5 + 2.0 * pi / sqrt(9e3 / 1.7);
    ck_assert_stein(stein_run(sim, 4.0 * period, err));
    ck_assert_close(stein_q(sim)[0], 0.0, 0.0, 1e-6);
    ck_assert_close(stein_qd(sim)[0], 0.5, 1e-6, 0.0);
    finish(sim, model);
}
END_TEST

START_TEST(a_stop_with_loss_slows_and_never_pulls)
{
    lab_model *model;
    stein_sim *sim = start(&model, "0", "{range: [-10 mm, 20 mm], k: 9 kN/m, D: 8 s/m}", "");
    double least = 0.5;
    for (int i = 0; i < 20000; i++) {
        ck_assert_stein(stein_step(sim, err));
        double q = stein_q(sim)[0], qd = stein_qd(sim)[0], force = 1.7 * stein_qdd(sim)[0];
        ck_assert(q > 0.02 ? force <= 0.0 : q < -0.01 ? force >= 0.0 : force == 0.0);
        if (q > -0.01 && q < 0.02) {
            ck_assert(fabs(qd) <= least + 1e-9);
            least = fmin(least, fabs(qd));
        }
    }
    ck_assert(least < 0.2);
    finish(sim, model);
}
END_TEST

/* by itself a body swings on it with 100 Hz: x = v / (2 pi 100 Hz) */
START_TEST(without_a_stiffness_a_stop_has_that_of_100_hertz)
{
    lab_model *model;
    stein_sim *sim = start(&model, "0", "[-1 m, 1 mm]",
                           "  arm: {joint: R z, mass: 0.2 kg, centre: [0.02, 0.3, -0.1], inertia: "
                           "{zz: 5e-4}, limits: [-3 rad, 1 mrad], initial: {speed: 2 rad/s}}\n");
    double most[2] = {0.0};
    for (int i = 0; i < 1000; i++) {
        ck_assert_stein(stein_step(sim, err));
        for (int j = 0; j < 2; j++) {
            most[j] = fmax(most[j], stein_q(sim)[j]);
        }
    }
    ck_assert_close(most[0] - 1e-3, 0.5 / (200.0 * pi), 1e-3, 0.0);
    ck_assert_close(most[1] - 1e-3, 2.0 / (200.0 * pi), 1e-3, 0.0);
    finish(sim, model);
}
END_TEST

START_TEST(derivatives_include_the_stops)
{
    lab_model *model;
    stein_sim *sim = start(&model, "-9.81", "{range: [-10 mm, 20 mm], k: 9 kN/m, D: 0.7 s/m}", arm);
    static const double q[] = {0.0213, -0.413}, qd[] = {0.11, -0.7};
    double by_q[4], by_qd[4], plus[2], minus[2], at[2], step = 1e-6;
    stein_derivative *s = NULL;
    ck_assert_stein(stein_derivative_create(&s, lab_equations(model), NULL, err));
    ck_assert_stein(stein_derivative_at(s, sim, 0.0, q, qd, NULL, err));
    stein_derivative_by_state(s, by_q, by_qd);
    for (int k = 0; k < 4; k++) {
        for (int side = 0; side < 2; side++) {
            memcpy(at, k < 2 ? q : qd, sizeof at);
            at[k % 2] += side ? -step : step;
            ck_assert_stein(stein_acceleration(sim, 0.0, k < 2 ? at : q, k < 2 ? qd : at,
                                               side ? minus : plus, err));
        }
        for (int i = 0; i < 2; i++) {
            double slope = (plus[i] - minus[i]) / (2.0 * step);
            ck_assert_close((k < 2 ? by_q : by_qd)[2 * i + k % 2], slope, 1e-6, 1e-5);
        }
    }
    stein_derivative_destroy(s);
    finish(sim, model);
}
END_TEST

START_TEST(stops_have_the_same_bits_in_lanes)
{
    lab_model *model;
    stein_sim *alone =
        start(&model, "-9.81", "{range: [-10 mm, 20 mm], k: 9 kN/m, D: 0.7 s/m}", arm);
    int width = stein_batch_width(lab_equations(model));
    stein_batch *batch = NULL;
    stein_sim *lane[8] = {NULL};
    double end[8];
    ck_assert_stein(stein_batch_create(&batch, lab_equations(model), NULL, width, 0, err));
    for (int i = 0; i < width; i++) {
        ck_assert_stein(lab_sim(model, NULL, &lane[i], err));
        ck_assert_stein(stein_set(lane[i], "sled.limits.k", 9e3 + 500.0 * i, err));
        ck_assert_stein(stein_reset(lane[i], err));
        ck_assert_stein(stein_batch_put(batch, i, lane[i], err));
        end[i] = 0.4;
    }
    ck_assert_stein(stein_batch_run(batch, end, NULL, err));
    for (int i = 0; i < width; i++) {
        ck_assert_stein(stein_set(alone, "sled.limits.k", 9e3 + 500.0 * i, err));
        ck_assert_stein(stein_reset(alone, err));
        ck_assert_stein(stein_run(alone, 0.4, err));
        ck_assert_mem_eq(stein_q(stein_batch_sim(batch, i)), stein_q(alone), 2 * sizeof(double));
    }
    stein_batch_destroy(batch);
    for (int i = 0; i < width; i++) {
        stein_sim_destroy(lane[i]);
    }
    finish(alone, model);
}
END_TEST

START_TEST(limits_that_are_none_are_refused)
{
    static const struct {
        const char *limits, *words;
    } wrong[] = {
        {"[1 m, -1 m]", "the limits of sled end before they begin"},
        {"[-1 m]", "two positions, as in limits: [-1 m, 1 m]"},
        {"[-1 rad, 1 rad]", "the unit is rad, expected m"},
        {"{k: 3 N/m}", "lacks \"range\""},
        {"{range: [-1 m, 1 m], k: 0 N/m}", "greater than zero"},
        {"{range: [-1 m, 1 m], K: 1 N/m}", "did you mean \"k\""},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[1000];
        snprintf(text, sizeof text, file, "0", wrong[i].limits, "");
        ck_assert_refused(text, wrong[i].words);
    }
}
END_TEST

Suite *limits_suite(void)
{
    Suite *suite = suite_create("limits");
    TCase *all = tcase_create("all");
    tcase_set_timeout(all, 60);
    tcase_add_unchecked_fixture(all, make_folder, remove_folder);
    tcase_add_test(all, a_sled_between_stops_without_loss_is_back_after_two_flights_and_one_swing);
    tcase_add_test(all, a_stop_with_loss_slows_and_never_pulls);
    tcase_add_test(all, without_a_stiffness_a_stop_has_that_of_100_hertz);
    tcase_add_test(all, derivatives_include_the_stops);
    tcase_add_test(all, stops_have_the_same_bits_in_lanes);
    tcase_add_test(all, limits_that_are_none_are_refused);
    suite_add_tcase(suite, all);
    return suite;
}
