/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_sweep.c - sweeps: the meaning of --vary; a journal never drops or invents a result; threads,
 * shards and interruptions do not change the table.
 */
#include "lab_support.h"
#include "suites.h"

static const char *const stein = "models/stein1788.yaml";

/* ---- grids ---- */

static lab_grid *one_axis(const char *unit, const char *values)
{
    lab_grid *grid = NULL;
    ck_assert_stein(lab__grid_new(&grid, err));
    ck_assert_stein(lab__grid_add(grid, "a.b", unit, values, err));
    return grid;
}

static void assert_typed(const char *unit, const char *values, int n, const char *format,
                         double first, double step, mech_dim dim)
{
    lab_grid *grid = one_axis(unit, values);
    ck_assert_int_eq(lab_grid_points(grid), n);
    for (int i = 0; i < n; i++) {
        char text[64];
        double typed;
        snprintf(text, sizeof text, format, first + step * i);
        ck_assert_stein(mech_parse_quantity(text, dim, &typed, err));
        ck_assert_msg(lab_grid_value(grid, i, 0) == typed, "%s: point %d is %.17g, typed %s",
                      values, i, lab_grid_value(grid, i, 0), text);
    }
    lab_grid_destroy(grid);
}

START_TEST(a_grid_hits_the_numbers_a_person_types)
{
    const mech_dim length = {.m = 1}, angle = {.rad = 1}, none = {.m = 0};
    assert_typed("m", "-1.2mm:0mm:13", 13, "%.1f mm", -1.2, 0.1, length);
    assert_typed("m", "0.3:-1.5:37 mm", 37, "%.2f mm", 0.3, -0.05, length);
    assert_typed("rad", "75:90:151deg", 151, "%.1f deg", 75.0, 0.1, angle);
    assert_typed("1", "0:1:1001", 1001, "%.3f", 0.0, 0.001, none);
    assert_typed("m", "-3um:3um:61", 61, "%.1f um", -3.0, 0.1, length);
    assert_typed("kg", "1e-9:1e-7:100", 100, "%.0fe-9", 1.0, 1.0, (mech_dim){.kg = 1});
}
END_TEST

START_TEST(a_unit_given_once_holds_for_all_numbers)
{
    static const char *const spelling[] = {"-1.2:0:4mm",         " -1.2mm : 0 : 4",  "-1.2:0mm:4",
                                           "-1.2:0:4 mm",        "-1.20 mm:0 mm:04", "-1.2mm:0:4mm",
                                           "\t-1.2\t:\t0\tmm:4", "-1.2E0:0.0e+0:4mm"};
    for (int i = 0; i < 8; i++) {
        lab_grid *grid = one_axis("m", spelling[i]);
        ck_assert_str_eq(grid->axis[0].text, "-1.2:0:4 mm");
        ck_assert(lab_grid_value(grid, 0, 0) == -0.0012 && lab_grid_value(grid, 1, 0) == -0.0008);
        lab_grid_destroy(grid);
    }
    lab_grid *grid = one_axis("m", "1,2 mm,-3e0");
    ck_assert_str_eq(grid->axis[0].text, "1,2,-3 mm");
    ck_assert(lab_grid_value(grid, 2, 0) == -0.003);
    lab_grid_destroy(grid);
    grid = one_axis("m", "1mm,20um,0"); // several units: all SI
    ck_assert_str_eq(grid->axis[0].text, "0.001,2e-05,0");
    lab_grid_destroy(grid);
    grid = one_axis("m", "0.5");
    ck_assert(lab_grid_points(grid) == 1 && lab_grid_value(grid, 0, 0) == 0.5);
    lab_grid_destroy(grid);
}
END_TEST

START_TEST(the_text_of_an_axis_reads_back)
{
    static const char *const values[] = {"-1.2:0.1:14mm", "75:90:7 deg", "1mm:2um:5", "3,1.7,2 mm",
                                         "0.1:0.3:9"};
    for (int i = 0; i < 5; i++) {
        lab_grid *a = one_axis(i == 1 ? "rad" : "m", values[i]);
        lab_grid *b = one_axis(i == 1 ? "rad" : "m", a->axis[0].text);
        ck_assert_str_eq(a->axis[0].text, b->axis[0].text);
        ck_assert_int_eq(a->n, b->n);
        ck_assert_mem_eq(a->axis[0].value, b->axis[0].value, sizeof(double) * (size_t)a->n);
        lab_grid_destroy(a);
        lab_grid_destroy(b);
    }
}
END_TEST

START_TEST(the_last_axis_runs_fastest)
{
    lab_grid *grid = one_axis("m", "1,2");
    ck_assert_stein(lab__grid_add(grid, "c", "1", "10:30:3", err));
    ck_assert_stein(lab__grid_add(grid, "d", "1", "5,6", err));
    ck_assert_int_eq(lab_grid_points(grid), 12);
    int point = 0;
    for (int i = 1; i <= 2; i++) {
        for (int k = 10; k <= 30; k += 10) {
            for (int l = 5; l <= 6; l++, point++) {
                ck_assert(lab_grid_value(grid, point, 0) == i);
                ck_assert(lab_grid_value(grid, point, 1) == k);
                ck_assert(lab_grid_value(grid, point, 2) == l);
            }
        }
    }
    lab_grid_destroy(grid);
}
END_TEST

static const struct {
    const char *vary, *message;
} bad_axes[] = {
    {"pawl.stop_shift=1:2:0", "COUNT is 0"},
    {"pawl.stop_shift=1:2:-3", "expected a whole number"},
    {"pawl.stop_shift=1:2:2.5", "expected a whole number"},
    {"pawl.stop_shift=1:2:", "expected a whole number"},
    {"pawl.stop_shift=1:2:1000001", "expected 1 to 1000000"},
    {"pawl.stop_shift=1:2:18446744073709551617", "expected 1 to 1000000"},
    {"pawl.stop_shift=1:2", "expected FROM:TO:COUNT"},
    {"pawl.stop_shift=1,2:3:4", "expected FROM:TO:COUNT"},
    {"pawl.stop_shift=a:2:3", "\"a\" is not a number"},
    {"pawl.stop_shift=1:nan:3", "\"nan\" is not a number"},
    {"pawl.stop_shift=1,,2", "\"\" is not a number"},
    {"pawl.stop_shift=1e999:2:3", "too large"},
    {"pawl.stop_shift=1kg:2kg:3", "the unit is kg, expected m"},
    {"pawl.stop_shift=1:2:3 parsec", "unknown unit"},
    {"pawl.stop_shift=1mm:1mm:3", "to the same end"},
    {"pawl.stop_shift=1mm:2mm:1", "both ends"},
    {"pawl.stop_shift=1mm,2um,3", "3 has no unit"},
    {"pawl.stop_shift=1:1.00000000000001:1000", "do not fit"},
    {"pawl.stop_shift", "expected NAME="},
    {"=1,2", "expected NAME="},
    {"pawl.stop_shift=1,2 a_unit_of_many_letters_and_no_sense", "is too long"},
    {"pawl.stop_shift=1,0.0000000000000000000000000000000000000000000000000000000000000000"
     "00000000000000000000000000000000000000000000000000000000000000001",
     "is too long for a number"},
    {"pawl.stop_shift=0:1:3 a_unit_of_many_letters_and_no_sense", "is no unit"},
    {"pawl.stop_shift=0:1e:3mm", "unknown unit \"e\""},
    {"pawl.stop_shft=1,2", "did you mean \"pawl.stop_shift\"?"},
    {"key.mass=-1g,60g", "-0.001 kg: must not be negative"},
    {"key.at.x=0:1:3mm", "structural zero"}};

START_TEST(a_bad_axis_is_refused_with_a_reason)
{
    lab_model *model = NULL;
    lab_grid *grid = NULL;
    lab_options options = lab_options_default();
    ck_assert_stein(lab_open(&model, stein, NULL, err));
    for (size_t i = 0; i < sizeof bad_axes / sizeof *bad_axes; i++) {
        stein_err e = {STEIN_OK, ""};
        const char *vary[] = {"key.mass=60,70g", bad_axes[i].vary};
        const char *const *given = strncmp(vary[1], "key.mass", 8) == 0 ? vary + 1 : vary;
        stein_status status =
            lab_grid_open(&grid, model, given, given == vary ? 2 : 1, stein, &options, &e);
        ck_assert_msg(status == STEIN_EINVAL, "%s: %s", vary[1], stein_status_text(status));
        ck_assert_msg(strstr(e.msg, bad_axes[i].message) != NULL, "%s: \"%s\"", vary[1], e.msg);
        ck_assert_ptr_null(grid);
    }
    const char *many[] = {"pawl.stop_shift=0:1:1000mm", "key.mass=60:70:1001g"};
    ck_assert_int_eq(lab_grid_create(&grid, lab_equations(model), many, 2, NULL), STEIN_EINVAL);
    const char *twice[] = {"key.mass=60,70g", "key.mass=60,70g"};
    ck_assert_int_eq(lab_grid_create(&grid, lab_equations(model), twice, 2, NULL), STEIN_EINVAL);
    lab_close(model);
}
END_TEST

/* ---- sweeps ---- */

static const char *const axes[] = {"pawl.stop_shift=-1:0.2:4mm", "string.height=-60,70,74 mm"};
enum { POINTS = 12 };

typedef struct setting {
    lab_model *model;
    lab_grid *grid;
    lab_vary_def def;
} setting;

static void set_up(setting *s)
{
    ck_assert_stein(lab_open(&s->model, stein, NULL, err));
    ck_assert_stein(lab_grid_create(&s->grid, lab_equations(s->model), axes, 2, err));
    s->def = lab_vary_def_default(s->model);
    s->def.until = 2e-3;
    s->def.release = 1e-3;
}

static void tear_down(setting *s)
{
    lab_grid_destroy(s->grid);
    lab_close(s->model);
}

static void sweep_to(const setting *s, const char *path, lab_vary_report *report)
{
    lab_table *table = NULL;
    ck_assert_stein(lab_vary(&table, s->model, s->grid, &s->def, report, err));
    ck_assert_stein(lab_table_write(path, table, err));
    lab_table_destroy(table);
}

static size_t read_bytes(const char *path, char *text, size_t room)
{
    FILE *f = fopen(path, "rb");
    ck_assert_ptr_nonnull(f);
    size_t size = fread(text, 1, room - 1, f);
    fclose(f);
    text[size] = '\0';
    return size;
}

static void assert_same_files(const char *a, const char *b)
{
    static char x[20000], y[20000];
    ck_assert_uint_eq(read_bytes(a, x, sizeof x), read_bytes(b, y, sizeof y));
    ck_assert_str_eq(x, y);
}

START_TEST(threads_shards_and_journals_leave_no_trace)
{
    setting s;
    lab_vary_report report;
    const char *serial = in_folder("serial.csv"), *other = in_folder("other.csv");
    set_up(&s);
    sweep_to(&s, serial, &report);
    ck_assert_int_eq(report.computed, POINTS);
    s.def.threads = 5;
    sweep_to(&s, other, NULL);
    assert_same_files(serial, other);

    const char *journal[3];
    char path[3][220];
    for (int i = 0; i < 3; i++) {
        snprintf(path[i], sizeof path[i], "%s/part%d", folder, i);
        s.def.journal = journal[2 - i] = path[i]; // merged in another order
        s.def.shard = i;
        s.def.shards = 3;
        sweep_to(&s, other, &report);
        ck_assert_int_eq(report.computed, POINTS / 3);
        sweep_to(&s, other, &report);
        ck_assert(report.computed == 0 && report.found == POINTS / 3);
    }
    lab_table *table = NULL;
    ck_assert_stein(lab_merge(&table, journal, 3, NULL, err));
    ck_assert_stein(lab_table_write(other, table, err));
    assert_same_files(serial, other);
    lab_table_destroy(table);
    tear_down(&s);
}
END_TEST

START_TEST(a_row_equals_a_single_stroke)
{
    setting s;
    lab_table *table = NULL;
    set_up(&s);
    s.def.until = 0.1;
    s.def.release = 0.09;
    s.def.fixed = 1;
    lab_grid_destroy(s.grid);
    const char *vary[] = {"pawl.stop_shift=-0.3,-0.2 mm"};
    ck_assert_stein(lab_grid_create(&s.grid, lab_equations(s.model), vary, 1, err));
    ck_assert_stein(lab_vary(&table, s.model, s.grid, &s.def, NULL, err));

    lab_model *one = NULL;
    stein_sim *sim = NULL;
    lab_stroke stroke;
    const char *set[] = {"pawl.stop_shift=-0.2mm"};
    lab_options options = lab_options_default();
    options.set = set;
    options.nset = 1;
    ck_assert_stein(lab_open(&one, stein, &options, err));
    ck_assert_stein(lab_sim(one, NULL, &sim, err));
    lab_stroke_def def = {.until = 0.1, .release = 0.09};
    ck_assert_stein(lab_strike(sim, &def, &stroke, err));
    const double expected[] = {stroke.escape_time,  stroke.escape_height,     stroke.impact_time,
                               stroke.impact_speed, stroke.peak_string_force, stroke.blow};
    static const char *const name[] = {"escapement_time", "escapement_height", "impact_time",
                                       "impact_speed",    "peak_string_force", "blow"};
    for (int i = 0; i < 6; i++) {
        double cell = lab__table_number(table, 1, lab__table_column(table, name[i]));
        ck_assert_msg(cell == expected[i], "%s: %.17g, stroke %.17g", name[i], cell, expected[i]);
    }
    stein_sim_destroy(sim);
    lab_close(one);
    lab_table_destroy(table);
    tear_down(&s);
}
END_TEST

/* The same strokes, one long and four that differ in what the hammer does, with fixed steps of 5 us
 * and the better method: to 1e-8 m by their own halves. */
static lab_table *fine_strokes(setting *s)
{
    static const char *const set[] = {"pawl.stop_shift=0"};
    lab_options options = lab_options_default();
    size_t size = 0;
    char *text = NULL, *at;
    lab_table *table = NULL;
    lab_model *fine = NULL;
    options.set = set;
    options.nset = 1;
    ck_assert_stein(lab__read_file(stein, &text, &size, err));
    at = strstr(text, "dt: 10 us, until: 0.25 s, integrator: rk4");
    ck_assert_ptr_nonnull(at);
    memcpy(at, "dt:  5 us, until: 0.25 s, integrator: dp5",
           strlen("dt: 10 us, until: 0.25 s, "
                  "integrator: dp5"));
    ck_assert_stein(lab__open_text(&fine, "fine.yaml", text, size, &options, err));
    lab_vary_def def = s->def;
    def.fixed = 1;
    def.tolerance = NULL;
    ck_assert_stein(lab_vary(&table, fine, s->grid, &def, NULL, err));
    lab_close(fine);
    free(text);
    return table;
}

START_TEST(controlled_steps_keep_the_stated_tolerance)
{
    static const struct {
        const char *told;
        double height, time, force; /* they may be off by [m], [s], [N] */
    } row[] = {{"string_distance=10 um", 1e-5, 1e-5, 2e-2},
               {"string_distance=1um", 1e-6, 1e-6, 2e-3},
               {NULL, 1e-7, 1e-7, 1e-3}, // the file's tolerance
               {"string_distance=0.03um", 3e-8, 3e-8, 3e-4}};
    setting s;
    set_up(&s);
    s.def.until = 0.07;
    s.def.release = NAN;
    lab_grid_destroy(s.grid);
    const char *vary[] = {"pawl.stop_shift=-1.2,-0.6,-0.2,0,0.15 mm"};
    ck_assert_stein(lab_grid_create(&s.grid, lab_equations(s.model), vary, 1, err));
    lab_table *fine = fine_strokes(&s);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        lab_table *table = NULL;
        s.def.tolerance = row[i].told;
        ck_assert_stein(lab_vary(&table, s.model, s.grid, &s.def, NULL, err));
        static const char *const name[] = {"escapement_height", "impact_time", "peak_string_force"};
        const double most[] = {row[i].height, row[i].time, row[i].force};
        for (int k = 0; k < 3; k++) {
            int column = lab__table_column(table, name[k]);
            for (int point = 0; point < 5; point++) {
                double here = lab__table_number(table, point, column);
                double there = lab__table_number(fine, point, column);
                int none = isnan(there) && isnan(here); // no impact yet
                ck_assert_msg(none || fabs(here - there) < most[k],
                              "%s of %d, %s: %.12g, fine %.12g", name[k], point, row[i].told, here,
                              there);
            }
        }
        lab_table_destroy(table);
    }
    lab_table_destroy(fine);
    tear_down(&s);
}
END_TEST

START_TEST(controlled_steps_cost_a_sixth_of_fixed_ones)
{
    // what a stroke costs is evaluations; a trial step has six, a fixed step of RK4 four
    lab_model *model = NULL;
    lab__steps steps;
    stein_sim *sim = NULL;
    ck_assert_stein(lab_open(&model, stein, NULL, err));
    ck_assert_stein(lab__steps_of(&steps, model, NULL, 0, err));
    ck_assert(steps.tolerance > 0.0);
    stein_sim_def def = lab_def(model);
    def.integrator = STEIN_DP5;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    stein_pace pace = {
        .tolerance = steps.tolerance, .longest = steps.longest, .h = 1e-6, .next = INFINITY};
    ck_assert_stein(stein_run_adaptive(sim, lab_until(model), &pace, err));
    ck_assert_int_lt(6 * stein_trials(sim) * 6, (long long)(4 * lab_until(model) / def.dt));
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(a_tolerance_that_means_nothing_is_refused)
{
    static const struct {
        const char *told, *message;
        int fixed;
    } bad[] = {{"1um", "expected CHANNEL=VALUE[unit]", 0},
               {"=1um", "expected CHANNEL=VALUE[unit]", 0},
               {"string_distanse=1um", "no output string_distanse", 0},
               {"string_distance=1 N", "tolerance string_distance=1 N", 0},
               {"string_distance=0 um", "expected a positive one", 0},
               {"string_distance=-1 um", "expected a positive one", 0},
               {"string_force=1 N", "reads a position, x, y, z or gap", 0},
               {"string_distance=1um", "fixed steps have none", 1}};
    setting s;
    set_up(&s);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_table *table = NULL;
        stein_err e = {STEIN_OK, ""};
        s.def.tolerance = bad[i].told;
        s.def.fixed = bad[i].fixed;
        stein_status status = lab_vary(&table, s.model, s.grid, &s.def, NULL, &e);
        ck_assert_msg(status == STEIN_EINVAL || status == STEIN_ENAME, "%s", bad[i].told);
        ck_assert_msg(strstr(e.msg, bad[i].message) != NULL, "%s: \"%s\"", bad[i].told, e.msg);
        ck_assert_ptr_null(table);
    }
    tear_down(&s);
}
END_TEST

START_TEST(a_failing_point_is_a_row_with_its_status)
{
    setting s;
    lab_table *table = NULL;
    const char *text;
    set_up(&s);
    ck_assert_stein(lab_vary(&table, s.model, s.grid, &s.def, NULL, err));
    for (int i = 0; i < POINTS; i++) {
        int buried = i % 3 == 0; // the string 134 mm too low
        ck_assert(lab_table_has(table, i));
        ck_assert_int_eq(lab__table_ok(table, i), !buried);
        size_t length = lab__table_cell(table, i, lab__table_column(table, "outcome"), &text);
        ck_assert_int_eq(length == 0, buried);
    }
    lab_table_destroy(table);
    tear_down(&s);
}
END_TEST

START_TEST(a_mechanism_without_stroke_gives_its_outputs)
{
    lab_model *model = NULL;
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    const char *vary[] = {"drop.height=0.1,0.2"};
    ck_assert_stein(lab_open(&model, "models/bouncing_ball.yaml", NULL, err));
    ck_assert_stein(lab_grid_create(&grid, lab_equations(model), vary, 1, err));
    lab_vary_def def = lab_vary_def_default(model);
    def.until = 0.05;
    ck_assert_stein(lab_vary(&table, model, grid, &def, NULL, err));
    for (int i = 0; i < 2; i++) {
        double fallen = lab_grid_value(grid, i, 0) - 0.5 * 9.81 * 0.05 * 0.05;
        ck_assert_close(lab__table_number(table, i, lab__table_column(table, "floor_gap")), fallen,
                        1e-9, 0.0);
    }
    def.release = 0.01;
    ck_assert_int_eq(lab_vary(&table, model, grid, &def, NULL, NULL), STEIN_EINVAL); // no load
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    lab_close(model);
}
END_TEST

static stein_status stop_at_five(void *ctx, int point, stein_sim *sim, const lab_stroke *stroke,
                                 stein_status status, stein_err *err)
{
    int *seen = ctx;
    (void)sim, (void)stroke;
    seen[point]++;
    return point == 5 && status == STEIN_OK ? lab__fail(err, STEIN_EIO, "full") : status;
}

static void leave(void *ctx, int point, double *p)
{
    (void)ctx;
    (void)point;
    (void)p;
}

START_TEST(a_batch_ends_when_a_result_cannot_be_kept)
{
    enum { N = 4000 };
    static int seen[N];
    static unsigned char skip[N];
    lab_model *model = NULL;
    stein_err e = {STEIN_OK, ""};
    ck_assert_stein(lab_open(&model, "models/pendulum.yaml", NULL, err));
    skip[3] = 1;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    def.until = 10.0 * lab_equations(model)->dt;
    lab__batch batch = {.model = model,
                        .def = &def,
                        .n = N,
                        .threads = 2,
                        .skip = skip,
                        .set = leave,
                        .run = stop_at_five,
                        .ctx = seen};
    ck_assert_int_eq(lab__batch_run(&batch, &e), STEIN_EIO);
    ck_assert_str_eq(e.msg, "full");
    int done = 0;
    for (int i = 0; i < N; i++) {
        ck_assert_int_le(seen[i], 1);
        done += seen[i];
    }
    ck_assert_int_lt(done, N - 1);
    ck_assert_int_eq(seen[3], 0);
    lab_close(model);
}
END_TEST

Suite *sweep_suite(void)
{
    Suite *suite = suite_create("sweep");
    TCase *grid = tcase_create("grid"), *sweep = tcase_create("sweep");
    tcase_add_test(grid, a_grid_hits_the_numbers_a_person_types);
    tcase_add_test(grid, a_unit_given_once_holds_for_all_numbers);
    tcase_add_test(grid, the_text_of_an_axis_reads_back);
    tcase_add_test(grid, the_last_axis_runs_fastest);
    tcase_add_test(grid, a_bad_axis_is_refused_with_a_reason);
    tcase_add_checked_fixture(sweep, make_folder, remove_folder);
    tcase_set_timeout(sweep, 60.0);
    tcase_add_test(sweep, threads_shards_and_journals_leave_no_trace);
    tcase_add_test(sweep, a_row_equals_a_single_stroke);
    tcase_add_test(sweep, controlled_steps_keep_the_stated_tolerance);
    tcase_add_test(sweep, controlled_steps_cost_a_sixth_of_fixed_ones);
    tcase_add_test(sweep, a_tolerance_that_means_nothing_is_refused);
    tcase_add_test(sweep, a_failing_point_is_a_row_with_its_status);
    tcase_add_test(sweep, a_mechanism_without_stroke_gives_its_outputs);
    tcase_add_test(sweep, a_batch_ends_when_a_result_cannot_be_kept);
    suite_add_tcase(suite, grid);
    suite_add_tcase(suite, sweep);
    return suite;
}
