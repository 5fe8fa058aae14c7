/* SPDX-License-Identifier: MIT
 * test_table.c - laws given by points: the curve, its places, refusals of the reader.
 */
#include <math.h>

#include "lab_support.h"
#include "mechanism_cases.h"
#include "stein/law.h"

Suite *table_suite(void);

static double curve(int n, const double *at, const double *value, double x)
{
    double slope[16];
    stein_table_slopes(n, at, value, slope);
    return stein_table_value(n, at, value, slope, x);
}

START_TEST(a_curve_goes_through_its_points_without_kinks_and_is_level_beyond)
{
    static const double at[] = {-0.31, -0.02, 0.13, 0.77, 1.19}, y[] = {1.7, -0.3, 0.4, 0.2, 2.9};
    for (int i = 0; i < 5; i++) {
        ck_assert_close(curve(5, at, y, at[i]), y[i], 1e-13, 1e-15);
    }
    for (int i = 1; i < 4; i++) {
        double before = (y[i] - curve(5, at, y, at[i] - 1e-6)) / 1e-6;
        double after = (curve(5, at, y, at[i] + 1e-6) - y[i]) / 1e-6;
        ck_assert_close(before, after, 1e-3, 1e-3);
    }
    ck_assert_close(curve(5, at, y, 2.19), 2.9, 1e-15, 0.0);
    ck_assert_close(curve(5, at, y, -1.31), 1.7, 1e-15, 0.0);
}
END_TEST

START_TEST(the_curve_of_a_sum_is_the_sum_of_the_curves)
{
    static const double at[] = {-0.31, -0.02, 0.13, 0.77}, a[] = {1.7, -0.3, 0.4, 0.2},
                        b[] = {0.3, 1.1, -2.3, 0.7};
    double sum[4];
    for (int i = 0; i < 4; i++) {
        sum[i] = 2.3 * a[i] + b[i];
    }
    for (double x = -0.5; x < 1.0; x += 0.037) {
        ck_assert_close(curve(4, at, sum, x), 2.3 * curve(4, at, a, x) + curve(4, at, b, x), 1e-12,
                        1e-13);
    }
}
END_TEST

START_TEST(points_that_do_not_increase_do_no_harm)
{
    static const double at[] = {0.3, 0.3, 0.1}, y[] = {1.0, 2.0, 3.0};
    for (double x = -1.0; x < 1.0; x += 0.1) {
        ck_assert(isfinite(curve(3, at, y, x)));
    }
}
END_TEST

/* a wheel on its axis; no gravity */
static const char wheel[] = "mechanism: wheel\n"
                            "gravity: [0, 0, 0]\n"
                            "bodies:\n"
                            "  rim:\n"
                            "    joint: R y\n"
                            "    inertia: {yy: 2.3e-3 kg m^2}\n"
                            "    initial: {position: 0.7 rad, speed: 1.3 rad/s}\n"
                            "%s"
                            "outputs: {angle: {joint: rim, read: position}}\n"
                            "simulation: {dt: 1 ms, until: 3 s}\n";

static double angle_after(const char *more, const char *const *set, int nset, double t)
{
    char *text = lab__text(wheel, more);
    lab_model *model = open_text(text, set, nset);
    stein_sim *sim = NULL;
    double angle;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_run(sim, t, err));
    ck_assert_stein(stein_read_name(sim, "angle", &angle, err));
    stein_sim_destroy(sim);
    lab_close(model);
    free(text);
    return angle;
}

START_TEST(a_spring_given_by_points_swings_by_the_formula)
{
    double w = sqrt(0.31 / 2.3e-3), t = 1.87;
    double is = angle_after("tables:\n  coil: {joint: rim, of: position, at: [-1, 0.2, 1.5 rad],"
                            " torque: [0.31, -0.062, -0.465 N m]}\n",
                            NULL, 0, t);
    ck_assert_close(is, 0.7 * cos(w * t) + 1.3 / w * sin(w * t), 1e-6, 1e-6);
}
END_TEST

START_TEST(a_brake_given_by_points_slows_by_the_formula)
{
    double k = 4.1e-3 / 2.3e-3, t = 0.93;
    double is = angle_after("tables:\n  brake: {joint: rim, of: speed, at: [-1, 0, 3 rad/s],"
                            " torque: [4.1e-3, 0, -12.3e-3 N m]}\n",
                            NULL, 0, t);
    ck_assert_close(is, 0.7 + 1.3 / k * (1.0 - exp(-k * t)), 1e-9, 0.0);
}
END_TEST

START_TEST(every_number_of_a_table_is_a_parameter)
{
    static const char table[] = "tables:\n  coil: {joint: rim, of: position, at: [-1 rad, 1 rad],"
                                " torque: [0 N m, 0 N m]}\n";
    static const char *const set[] = {"coil.torque.1=0.31 N m", "coil.torque.2=-0.31 N m"};
    double w = sqrt(0.31 / 2.3e-3);
    ck_assert_close(angle_after(table, NULL, 0, 1.87), 0.7 + 1.3 * 1.87, 1e-12, 0.0); // neutral
    ck_assert_close(angle_after(table, set, 2, 1.87), 0.7 * cos(w * 1.87) + 1.3 / w * sin(w * 1.87),
                    1e-6, 1e-6);
}
END_TEST

START_TEST(a_contact_is_as_hard_as_its_points)
{
    static const char *const plain[] = {"string.normal.c=14.3 kN/m"};
    char *tabled = lab__text("%stables:\n  felt: {contact: string, of: depth, at: [0, 1 mm],"
                             " force: [0 N, 2.6 N]}\n",
                             falling);
    char *harder = lab__text("%stables:\n  felt: {contact: string, of: rate, at: [-1, 1 m/s],"
                             " factor: [%.17g, %.17g]}\n",
                             falling, 2.6 / 11.7, 2.6 / 11.7);
    double height[3];
    lab_model *model[3] = {open_text(falling, plain, 1), open_text(tabled, NULL, 0),
                           open_text(harder, NULL, 0)};
    for (int i = 0; i < 3; i++) {
        stein_sim *sim = NULL;
        ck_assert_stein(lab_sim(model[i], NULL, &sim, err));
        ck_assert_stein(stein_run(sim, 0.0874, err));
        ck_assert_stein(stein_read_name(sim, "height", &height[i], err));
        stein_sim_destroy(sim);
        lab_close(model[i]);
    }
    ck_assert_close(height[1], height[0], 1e-9, 1e-12);
    ck_assert_close(height[2], height[0], 1e-9, 1e-12);
    free(tabled);
    free(harder);
}
END_TEST

START_TEST(invalid_tables_are_refused_with_their_place)
{
#define BEFORE "inputs:\n"
    static const refusal table[] = {
        {BEFORE, "tables: {t: {joint: key, of: depth, at: [0, 1], torque: [0, 1]}}\ninputs:\n",
         "depth, at", "position speed"},
        {BEFORE, "tables: {t: {joint: kye, of: speed, at: [0, 1], torque: [0, 1]}}\ninputs:\n",
         "kye", "kye|key"},
        {BEFORE, "tables: {t: {contact: strng, of: rate, at: [0, 1], factor: [0, 1]}}\ninputs:\n",
         "strng", "strng|string"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: [0, 1], force: [0, 1]}}\ninputs:\n",
         "force: [0, 1]", "torque|force"},
        {BEFORE,
         "tables: {t: {joint: key, of: speed, at: [0, 1, 1], torque: [0, 1, 2]}}\ninputs:\n",
         "1], torque", "t.at.3|t.at.2"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: [0, 1], torque: [0, 1, 2]}}\ninputs:\n",
         "[0, 1, 2]", "3 values|2 points"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: [7], torque: [0]}}\ninputs:\n", "[7]",
         "1 points|2 to 64"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: [0, 1 mm], torque: [0, 1]}}\ninputs:\n",
         "1 mm], torque", "rad/s"},
        {BEFORE, "tables: {t: {of: speed, at: [0, 1], torque: [0, 1]}}\ninputs:\n", "t: {of",
         "joint, contact and notch"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: 7, torque: [0, 1]}}\ninputs:\n",
         "7, torque", "list"},
        {BEFORE, "tables: {t: {joint: key, of: speed, at: [0, 1], torque: 7}}\ninputs:\n", "7}}",
         "torque must be a list of numbers"},
        {BEFORE,
         "tables: {t: {joint: key, of: speed, on: key, at: [0, 1], torque: [0, 1]}}\ninputs:\n",
         "on: key, at: [0, 1]", "unknown key \"on\" in a table"},
        {BEFORE, "tables: {t: {notch: nut, of: depth, at: [0, 1], force: [0, 1]}}\ninputs:\n",
         "nut,", "nut"},
    };
    REFUSE_ALL(table);
}
END_TEST

START_TEST(a_notch_and_the_load_take_tables)
{
    char *text = changed(BEFORE, "tables:\n"
                                 "  a: {notch: notch, of: depth, at: [0, 1 mm], force: [0, 1 N]}\n"
                                 "  b: {contact: load, of: rate, at: [0, 1 m/s], factor: [0, 1]}\n"
                                 "inputs:\n");
    mechanism *m = read_ok(text, NULL, 0);
    ck_assert_int_eq(m->ntable, 2);
    ck_assert_int_eq(m->tables[0].index, m->ncontact);
    ck_assert_int_eq(m->tables[1].index, m->load_contact);
    mech_free(m);
    free(text);
}
END_TEST

Suite *table_suite(void)
{
    Suite *s = suite_create("table");
    TCase *tc = tcase_create("table");
    tcase_set_timeout(tc, 60);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_curve_goes_through_its_points_without_kinks_and_is_level_beyond);
    tcase_add_test(tc, the_curve_of_a_sum_is_the_sum_of_the_curves);
    tcase_add_test(tc, points_that_do_not_increase_do_no_harm);
    tcase_add_test(tc, a_spring_given_by_points_swings_by_the_formula);
    tcase_add_test(tc, a_brake_given_by_points_slows_by_the_formula);
    tcase_add_test(tc, every_number_of_a_table_is_a_parameter);
    tcase_add_test(tc, a_contact_is_as_hard_as_its_points);
    tcase_add_test(tc, invalid_tables_are_refused_with_their_place);
    tcase_add_test(tc, a_notch_and_the_load_take_tables);
    suite_add_tcase(s, tc);
    return s;
}
