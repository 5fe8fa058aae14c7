/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_stop.c - long work that its caller stops ends soon with ESTOPPED and leaves nothing behind.
 */
#include <limits.h>

#include "swings.h"

static const char *const truth[] = {"rod.damping=3e-4 N m s/rad", NULL};
static const char *const free_damping[] = {"rod.damping", NULL};

/* asked from any thread; from the question `at` on the answer is yes */
typedef struct asked {
    long at, questions;
} asked;

static int answer(void *ctx)
{
    asked *a = ctx;
    return __atomic_add_fetch(&a->questions, 1, __ATOMIC_RELAXED) > a->at;
}

START_TEST(a_sweep_stops_and_its_journal_goes_on)
{
    static const char *const vary[] = {"rod.initial.position=1:60:200 deg"};
    lab_model *model = NULL;
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    lab_vary_report report;
    asked a = {.at = 10}; // of the questions between packs of runs, of up to eight
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(lab_open(&model, pendulum, NULL, err));
    ck_assert_stein(lab_grid_create(&grid, lab_equations(model), vary, 1, err));
    lab_vary_def def = lab_vary_def_default(model);
    def.until = 0.1;
    def.threads = 2;
    def.journal = in_folder("journal");
    def.stop = answer;
    def.ctx = &a;
    ck_assert_int_eq(lab_vary(&table, model, grid, &def, NULL, &why), STEIN_ESTOPPED);
    ck_assert_int_eq(why.code, STEIN_ESTOPPED);
    ck_assert_ptr_null(table);
    def.stop = NULL;
    ck_assert_stein(lab_vary(&table, model, grid, &def, &report, err));
    ck_assert_int_eq(report.found + report.computed, 200);
    ck_assert_int_gt(report.found, 10);
    ck_assert_int_gt(report.computed, 10);
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    lab_close(model);
}
END_TEST

START_TEST(a_fit_stops_at_any_question)
{
    fitted f;
    open_swings(&f, pendulum, truth, 5);
    lab_fit_def def = free_these(free_damping);
    asked all = {.at = LONG_MAX};
    def.stop = answer;
    def.ctx = &all;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_int_gt(all.questions, 100);
    for (long share = 0; share < 10; share++) {
        lab_fit *none = NULL;
        asked a = {.at = share * all.questions / 11};
        stein_err why;
        def.ctx = &a;
        ck_assert_int_eq(lab_fit_run(&none, f.model, f.data, &def, &why), STEIN_ESTOPPED);
        ck_assert_ptr_null(none);
    }
    drop(&f);
}
END_TEST

START_TEST(a_diagnosis_stops_at_any_question)
{
    fitted f;
    lab_diagnosis *d = NULL;
    open_swings(&f, pendulum, truth, 6);
    lab_diagnose_def def = lab_diagnose_def_default();
    asked all = {.at = LONG_MAX};
    def.threads = 2;
    def.most_strokes = 400;
    def.stop = answer;
    def.ctx = &all;
    ck_assert_stein(lab_diagnose(&d, pendulum, f.model, f.data, &def, err));
    lab_diagnosis_destroy(d);
    for (long share = 0; share < 12; share++) {
        asked a = {.at = share * all.questions / 13};
        stein_err why;
        d = NULL;
        def.ctx = &a;
        ck_assert_int_eq(lab_diagnose(&d, pendulum, f.model, f.data, &def, &why), STEIN_ESTOPPED);
        ck_assert_ptr_null(d);
    }
    drop(&f);
}
END_TEST

Suite *stop_suite(void)
{
    Suite *suite = suite_create("stop");
    TCase *tc = tcase_create("stop");
    tcase_set_timeout(tc, 60.0);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_sweep_stops_and_its_journal_goes_on);
    tcase_add_test(tc, a_fit_stops_at_any_question);
    tcase_add_test(tc, a_diagnosis_stops_at_any_question);
    suite_add_tcase(suite, tc);
    return suite;
}
