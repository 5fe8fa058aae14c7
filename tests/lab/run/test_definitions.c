/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_definitions.c - definitions of runs, sweeps, fits and plans at the ends of their ranges: the
 * field that is out of range is named, and nothing is returned.
 */
#include "pendulum_model.h"
#include "planning.h"
#include "stein/fit.h"

static void said(const stein_err *why, const char *words)
{
    ck_assert_msg(strstr(why->msg, words) != NULL, "%s, expected %s", why->msg, words);
}

START_TEST(a_sweep_has_a_duration_and_parts)
{
    const double inf = INFINITY;
    static const char *const vary[] = {"rod.mass=0.2:0.3:2kg"};
    const struct {
        double until, release;
        int shard, shards;
        const char *says;
    } bad[] = {
        {0.0, NAN, 0, 1, "a run of 0 s: expected a positive duration"},
        {NAN, NAN, 0, 1, "expected a positive duration"},
        {inf, NAN, 0, 1, "a run of inf s: expected a positive duration"},
        {0.1, -0.1, 0, 1, "release at -0.1 s: expected a time from 0 to the end at 0.1 s"},
        {0.1, 0.2, 0, 1, "release at 0.2 s: expected a time from 0 to the end at 0.1 s"},
        {0.1, NAN, 0, 0, "shard 0 of 0"},
        {0.1, NAN, -1, 2, "shard -1 of 2"},
        {0.1, NAN, 2, 2, "shard 2 of 2"},
    };
    lab_grid *grid = NULL;
    ck_assert_stein(lab_grid_create(&grid, lab_equations(model), vary, 1, err));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_vary_def def = lab_vary_def_default(model);
        lab_table *table = NULL;
        stein_err why = {STEIN_OK, ""};
        def.until = bad[i].until;
        def.release = bad[i].release;
        def.shard = bad[i].shard;
        def.shards = bad[i].shards;
        ck_assert_int_eq(lab_vary(&table, model, grid, &def, NULL, &why), STEIN_EINVAL);
        said(&why, bad[i].says);
        ck_assert_ptr_null(table);
    }
    lab_grid_destroy(grid);
}
END_TEST

START_TEST(a_sweep_of_another_mechanism_is_refused)
{
    static const char *const vary[] = {"pawl.stop_shift=-1:0:2mm"};
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    lab_vary_def def = lab_vary_def_default(model);
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(lab_grid_create(&grid, &stein_model_stein1788, vary, 1, err));
    ck_assert_int_eq(lab_vary(&table, model, grid, &def, NULL, &why), STEIN_ENAME);
    said(&why, "\"pendulum\" has no parameter pawl.stop_shift");
    ck_assert_ptr_null(table);
    lab_grid_destroy(grid);
}
END_TEST

START_TEST(a_fit_names_the_field_that_is_out_of_range)
{
    static const char *const free_one[] = {"rod.damping"};
    static const char *const field[] = {"nfree",   "prior",  "prior",  "offset",
                                        "trigger", "starts", "starts", "iterations",
                                        "threads", "lanes",  "lanes",  "lanes"};
    const char *file =
        write_file("s.csv", "time [s],angle [rad]\n0,0.1\n0.1,0.2\n0.2,0.3\n0.3,0.2\n0.4,0.1\n");
    lab_data_options o = lab_data_options_default(lab_equations(model));
    lab_dataset *set = NULL;
    ck_assert_stein(lab_dataset_open(&set, &file, 1, &o, err));
    for (int i = 0; i < (int)(sizeof field / sizeof *field); i++) {
        lab_fit_def d = lab_fit_def_default();
        lab_fit *fit = NULL;
        stein_err why = {STEIN_OK, ""};
        d.free = free_one;
        d.nfree = i == 0 ? 0 : 1;
        d.prior = i == 1 ? 0.0 : i == 2 ? (double)NAN : d.prior;
        d.offset = i == 3 ? -1e-3 : d.offset;
        d.trigger = i == 4 ? (double)NAN : d.trigger;
        d.starts = i == 5 ? 0 : i == 6 ? LAB_FIT_STARTS + 1 : d.starts;
        d.iterations = i == 7 ? 0 : d.iterations;
        d.threads = i == 8 ? 0 : d.threads;
        d.lanes = i == 9 ? -1 : i == 10 ? 3 : i == 11 ? 1024 : d.lanes;
        ck_assert_int_eq(lab_fit_run(&fit, model, set, &d, &why), STEIN_EINVAL);
        char *says = lab__text("lab_fit_def.%s is out of range", field[i]);
        said(&why, says);
        ck_assert_ptr_null(fit);
        free(says);
    }
    lab_fit_def d = lab_fit_def_default();
    lab_dataset none = {.n = 0};
    lab_fit *fit = NULL;
    stein_err why = {STEIN_OK, ""};
    d.free = free_one;
    d.nfree = 1;
    ck_assert_int_eq(lab_fit_run(&fit, model, &none, &d, &why), STEIN_EINVAL);
    said(&why, "no records to fit to");
    lab_dataset_close(set);
}
END_TEST

START_TEST(a_plan_names_the_field_that_is_out_of_range)
{
    static const char *const field[] = {"threads", "wanted", "wanted", "rivals", "rivals"};
    lab_diagnosis d = {.ncause = 0};
    lab_plan *plan = NULL;
    stein_err why = {STEIN_OK, ""};
    for (int i = 0; i < 5; i++) {
        lab_plan_def def = lab_plan_def_default();
        def.threads = i == 0 ? 0 : def.threads;
        def.wanted = i == 1 ? 1.0 : i == 2 ? (double)NAN : def.wanted;
        def.rivals = i == 3 ? 0 : i == 4 ? LAB_PLAN_RIVALS + 1 : def.rivals;
        ck_assert_int_eq(lab_plan_make(&plan, "models/pendulum.yaml", model, &d, &def, &why),
                         STEIN_EINVAL);
        char *says = lab__text("lab_plan_def.%s is out of range", field[i]);
        said(&why, says);
        free(says);
    }
    ck_assert_ptr_null(plan);
    lab_suspect suspect = {.amount = 0.0};
    lab_experiment e = {.nset = 0};
    d.suspect = &suspect;
    d.nsuspect = 1;
    for (int i = -1; i < 2; i++) { // before, without a cause, behind
        ck_assert_int_eq(lab_plan_stroke(in_folder("no.csv"), &e, i, "models/pendulum.yaml", model,
                                         &d, NULL, &why),
                         STEIN_EINVAL);
        said(&why, "in the diagnosis");
    }
    ck_assert_int_ne(access(in_folder("no.csv"), F_OK), 0);
}
END_TEST

START_TEST(numbers_and_texts_of_any_kind_can_be_written)
{
    char text[LAB_NUMBER], line[] = "a\x01\x7f\tb\xc3\xa9";
    ck_assert_str_eq(lab__number(text, (double)NAN), "nan");
    ck_assert_str_eq(lab__number(text, (double)INFINITY), "inf");
    ck_assert_str_eq(lab__number(text, -(double)INFINITY), "-inf");
    ck_assert_str_eq(lab__number(text, 0.1), "0.1");
    ck_assert_str_eq(lab__number(text, 0.1 + 0.2), "0.30000000000000004");
    ck_assert_str_eq(lab__number(text, -1e-300), "-1e-300");
    ck_assert_str_eq(lab__one_line(line), "a???b\xc3\xa9");
}
END_TEST

START_TEST(a_stroke_has_a_duration_and_an_interval)
{
    const double inf = INFINITY;
    const struct {
        double until, every, release;
        const char *says;
    } bad[] = {
        {0.0, 0.0, NAN, "until"},     {inf, 0.0, NAN, "until"},   {NAN, 0.0, NAN, "until"},
        {0.1, -1e-3, NAN, "every"},   {0.1, inf, NAN, "every"},   {0.1, NAN, NAN, "every"},
        {0.1, 0.0, -1e-3, "release"}, {0.1, 0.0, 0.2, "release"},
    };
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_stroke_def def = lab_stroke_def_default(&stein_model_stein1788);
        lab_stroke stroke;
        stein_err why = {STEIN_OK, ""};
        def.until = bad[i].until;
        def.every = bad[i].every;
        def.release = bad[i].release;
        ck_assert_int_eq(lab_strike(sim, &def, &stroke, &why), STEIN_EINVAL);
        said(&why, bad[i].says);
        ck_assert(stein_time(sim) == 0.0);
    }
    stein_sim_destroy(sim);
}
END_TEST

Suite *definitions_suite(void)
{
    Suite *s = suite_create("definitions");
    TCase *tc = tcase_create("definitions");
    tcase_add_checked_fixture(tc, open_pendulum, close_pendulum);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_sweep_has_a_duration_and_parts);
    tcase_add_test(tc, a_sweep_of_another_mechanism_is_refused);
    tcase_add_test(tc, a_fit_names_the_field_that_is_out_of_range);
    tcase_add_test(tc, a_plan_names_the_field_that_is_out_of_range);
    tcase_add_test(tc, numbers_and_texts_of_any_kind_can_be_written);
    tcase_add_test(tc, a_stroke_has_a_duration_and_an_interval);
    suite_add_tcase(s, tc);
    return s;
}
