/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_lab_results.c - the laboratory: records, driven inputs, sweeps, the paper's facts.
 */
#include "lab_support.h"

void lab_results_cases(Suite *suite);

/* ---- records ---- */

START_TEST(a_csv_reads_back_exactly)
{
    lab_model *model = open_text(falling, NULL, 0);
    stein_sim *sim = NULL;
    lab_record *record = NULL;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    const char *notes[] = {"model: falling", "set hammer.mass: 3.1 g", NULL};
    ck_assert_stein(lab_record_create(&record, lab_equations(model), 0.7e-3, err));
    def.sample = lab_record_sample;
    def.ctx = record;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert_stein(lab_record_finish(record, sim));
    ck_assert_stein(lab_record_finish(record, sim));
    ck_assert_int_eq(lab__record_rows(record), 173); // 0, 0.7, ..., 119.7 ms and the end
    ck_assert_stein(lab_write_csv(in_folder("run.csv"), record, notes, err));

    char line[400];
    FILE *f = fopen(in_folder("run.csv"), "r");
    ck_assert_str_eq(fgets(line, sizeof line, f), "# model: falling\n");
    ck_assert_str_eq(fgets(line, sizeof line, f), "# set hammer.mass: 3.1 g\n");
    ck_assert_str_eq(fgets(line, sizeof line, f), "time [s],gap [m],force [N],height [m]\n");
    for (int row = 0; row < 173; row++) {
        char *at = fgets(line, sizeof line, f);
        for (int i = 0; i < 4; i++) {
            ck_assert(strtod(at, &at) == lab__record_at(record, row, i));
            at++;
        }
    }
    ck_assert_ptr_null(fgets(line, sizeof line, f));
    fclose(f);
    lab_record_destroy(record);
    lab_record_destroy(NULL);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(numbers_are_the_shortest_that_read_back)
{
    char text[LAB_NUMBER];
    ck_assert_str_eq(lab__number(text, 0.1), "0.1");
    ck_assert_str_eq(lab__number(text, -3e-4), "-0.0003");
    ck_assert_str_eq(lab__number(text, 0.1 + 0.2), "0.30000000000000004");
    ck_assert_str_eq(lab__number(text, 1e300), "1e+300");
    unsigned long long seed = 71;
    for (int i = 0; i < 2000; i++) {
        double x = ldexp(noise(&seed), (int)(60.0 * noise(&seed)));
        ck_assert(strtod(lab__number(text, x), NULL) == x);
    }
}
END_TEST

/* bits of all kinds: every exponent, also of numbers too small to be normal */
START_TEST(every_number_that_is_printed_is_read_back_to_its_bits)
{
    unsigned long long seed = 1788;
    char text[LAB_NUMBER], again[2 * LAB_NUMBER];
    for (int i = 0; i < 100000; i++) {
        (void)noise(&seed);
        unsigned long long bits = seed * 0x9e3779b97f4a7c15ull;
        double x, y, z;
        memcpy(&x, &bits, sizeof x);
        if (!isfinite(x)) {
            continue;
        }
        x = i % 4 == 0 ? (double)(float)x : i % 4 == 1 ? round(1e3 * noise(&seed)) / 1e3 : x;
        x = isfinite(x) ? x : 0.0;
        lab__number(text, x);
        ck_assert_stein(mech_parse_quantity(text, (mech_dim){.m = 1}, &y, err));
        ck_assert_msg(memcmp(&x, &y, sizeof x) == 0 || x == 0.0, "%a as %s is %a", x, text, y);
        snprintf(again, sizeof again, "%s m", text);
        ck_assert_stein(mech_parse_quantity(again, (mech_dim){.m = 1}, &z, err));
        ck_assert_msg(y == z, "%s", again);
    }
}
END_TEST

START_TEST(results_that_cannot_be_written_leave_nothing_behind)
{
    stein_err err = {STEIN_OK, ""};
    lab_record *record = NULL;
    ck_assert_int_eq(lab_record_create(&record, &stein_model_pendulum, NAN, &err), STEIN_EINVAL);
    ck_assert_int_eq(lab_record_create(&record, &stein_model_pendulum, 0.0, &err), STEIN_OK);
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    for (int i = 0; i < 1000; i++) {
        ck_assert_int_eq(lab_record_sample(record, sim), STEIN_OK);
    }
    ck_assert_int_eq(lab_write_csv("/dev/full", record, NULL, &err), STEIN_EIO);
    ck_assert_msg(strstr(err.msg, "/dev/full") != NULL, "%s", err.msg);
    ck_assert_int_eq(lab_write_csv(in_folder("absent/run.csv"), record, NULL, &err), STEIN_EIO);
    ck_assert_int_eq(lab_write_csv(folder, record, NULL, &err), STEIN_EIO);
    ck_assert_int_eq(lab_plot(in_folder("run.pdf"), record, &stein_model_pendulum, NULL, &err),
                     STEIN_EINVAL);
    setenv("PATH", folder, 1); // no gnuplot here
    ck_assert_int_eq(lab_plot(in_folder("run.svg"), record, &stein_model_pendulum, NULL, &err),
                     STEIN_EIO);
    ck_assert_msg(strstr(err.msg, "apt-get install gnuplot-nox") != NULL, "%s", err.msg);
    ck_assert_int_ne(access(in_folder("run.svg"), F_OK), 0);
    ck_assert_int_eq(rmdir(folder), 0); // still empty
    stein_sim_destroy(sim);
    lab_record_destroy(record);
}
END_TEST

/* ---- driving ---- */

START_TEST(a_measured_motion_drives_its_joint)
{
    lab_model *model = open_text(falling, NULL, 0);
    const stein_model *m = lab_equations(model);
    FILE *f = fopen(in_folder("motion.csv"), "w");
    fprintf(f, "# a sine of 20 mm, upwards, as of 5 ms\ntime [ms],unknown [V],lift [mm]\n");
    for (int i = 0; i <= 115; i++) {
        fprintf(f, "%d,1,%s\n", 5 + i, "");
        fprintf(f, "%g,,%.15g\n", 5.5 + i, 40.0 + 20.0 * sin(0.03 * (0.5 + i)));
    }
    fclose(f);
    lab_drive *drive = NULL;
    stein_sim *sim = NULL;
    ck_assert_stein(lab_drive_open(&drive, in_folder("motion.csv"), m, err));
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(lab_drive_bind(drive, sim, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_close(stein_q(sim)[0], 40e-3 + 20e-3 * sin(0.015), 1e-12, 0.0); // holds before
    ck_assert_stein(stein_run(sim, 0.0617, err));
    ck_assert_close(stein_q(sim)[0], 40e-3 + 20e-3 * sin(0.03 * 56.7), 0.0, 1e-9);
    ck_assert_close(stein_qd(sim)[0], 20e-3 * 30.0 * cos(0.03 * 56.7), 0.0, 1e-6);
    ck_assert_close(stein_qdd(sim)[0], -20e-3 * 900.0 * sin(0.03 * 56.7), 2e-3, 0.0);
    stein_sim_destroy(sim);
    lab_drive_close(drive);
    lab_drive_close(NULL);
    lab_close(model);
}
END_TEST

START_TEST(data_that_cannot_drive_are_refused_by_line)
{
    static const struct {
        const char *text;
        stein_status status;
        const char *says;
    } bad[] = {{"time [s],push [N]\n0,1\n1,2\n0.5,3\n", STEIN_EPARSE, ":4:1: "},
               {"time [s],push [N]\n0,1\n1,2,3\n", STEIN_EPARSE, ":3:5: "},
               {"# x: 1\ntime [s],push [N]\n0,abc\n", STEIN_EPARSE, ":3:3: "},
               {"time [s],push [kg]\n0,1\n", STEIN_EPARSE, "expected [N]"},
               {"push [N],later [s]\n0,1\n", STEIN_EPARSE, "expected time"},
               {"time [s],push [N]\n,1\n", STEIN_EPARSE, "without time"},
               {"time [s],push [N]\n0,1\n", STEIN_EPARSE, "at least 2"},
               {"time [s],lift [m]\n0,1\n1,1\n", STEIN_EPARSE, "at least 3"},
               {"time [s],pull [N]\n0,1\n", STEIN_EINVAL, "named like an input"},
               {"# nothing\n", STEIN_EPARSE, "no header"}};
    lab_model *model = open_text(falling, NULL, 0);
    lab_drive *drive = NULL;
    stein_err err = {STEIN_OK, ""};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const char *file = write_file("bad.csv", bad[i].text);
        ck_assert_int_eq(lab_drive_open(&drive, file, lab_equations(model), &err), bad[i].status);
        ck_assert_msg(strstr(err.msg, bad[i].says) != NULL, "%s", err.msg);
    }
    ck_assert_int_eq(lab_drive_open(&drive, in_folder("absent.csv"), lab_equations(model), &err),
                     STEIN_EIO);
    ck_assert_ptr_null(drive);
    lab_close(model);
}
END_TEST

/* ---- study ---- */

static void count_done(void *ctx, int done, int total)
{
    ck_assert_int_eq(done, ++*(int *)ctx);
    ck_assert_int_eq(total, 5);
}

START_TEST(a_sweep_is_the_same_on_any_number_of_threads)
{
    lab_model *model = NULL;
    const char *set[] = {"load.mass=103.7 g"};
    lab_options options = cache_here("no-compiler-needed");
    options.set = set;
    options.nset = 1;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    lab_point one[5], three[5];
    for (int i = 0; i < 5; i++) {
        memset(&one[i], 0, sizeof one[i]);
        memset(&three[i], 0, sizeof three[i]);
        one[i].dx = three[i].dx = -0.731e-3 + 0.213e-3 * i;
    }
    int done = 0;
    ck_assert_stein(lab_sweep(model, one, 5, 1, count_done, &done, err));
    ck_assert_int_eq(done, 5);
    ck_assert_stein(lab_sweep(model, three, 5, 3, NULL, NULL, err));
    for (int i = 0; i < 5; i++) {
        ck_assert_int_eq(one[i].status, STEIN_OK);
        ck_assert(one[i].stroke.impact_time == three[i].stroke.impact_time);
        ck_assert(one[i].stroke.impact_speed == three[i].stroke.impact_speed);
        ck_assert(one[i].stroke.escape_height == three[i].stroke.escape_height);
        ck_assert(one[i].stroke.peak_string_force == three[i].stroke.peak_string_force);
    }
    lab_close(model);
}
END_TEST

START_TEST(a_sweep_needs_the_stop_and_a_stroke)
{
    lab_point point[1] = {{.dx = 0.0}};
    stein_err err = {STEIN_OK, ""};
    lab_model *model = open_text(falling, NULL, 0);
    ck_assert_int_eq(lab_sweep(model, point, 1, 1, NULL, NULL, &err), STEIN_ENAME);
    ck_assert_msg(strstr(err.msg, "pawl.stop_shift") != NULL, "%s", err.msg);
    lab_close(model);
}
END_TEST

/* strokes that obey the paper to the letter */
static int invent(lab_point *point)
{
    int n = lab_study_grid(NULL, 0);
    lab_study_grid(point, n);
    for (int i = 0; i < n; i++) {
        double dx = point[i].dx;
        lab_stroke *s = &point[i].stroke;
        s->outcome = dx < -1.26e-3  ? LAB_MISSED_NOTCH
                     : dx > 0.21e-3 ? LAB_NO_ESCAPEMENT
                                    : LAB_STRUCK;
        s->escaped = s->outcome == LAB_STRUCK;
        s->escape_height = fmax(0.0, 2.2e-3 - 20.0 * dx);
        s->escape_time = 60e-3 + 10.0 * dx;
        s->impact_time = 60.5e-3 + 3e-3 * exp(-2e3 * dx) / exp(2.4);
        s->forced_escapement = dx > 0.11e-3;
        s->impacts = 1;
        s->free_flight = dx > 0.11e-3 ? 0.0 : fmax(0.0, s->impact_time - s->escape_time);
        s->peak_string_force = dx < 0.0 ? 8.0 + 5e3 * dx : 8.0;
        s->impact_speed = 1.2;
        s->blow = 40e-3;
        s->rearmed = 1;
    }
    return n;
}

static int count_off(const lab_fact *fact, int n)
{
    int off = 0;
    for (int i = 0; i < n; i++) {
        off += !fact[i].ok;
    }
    return off;
}

static const lab_fact *find_fact(const lab_fact *fact, int n, const char *part)
{
    for (int i = 0; i < n; i++) {
        if (strstr(fact[i].fact, part) != NULL) {
            return &fact[i];
        }
    }
    ck_abort_msg("no fact about \"%s\"", part);
}

START_TEST(strokes_that_obey_the_paper_have_all_facts_right)
{
    lab_point point[64];
    lab_fact fact[LAB_FACTS_MAX];
    int n = invent(point), facts = lab_facts(fact, point, n);
    ck_assert_int_eq(n, 37);
    for (int i = 0; i < facts; i++) {
        ck_assert_msg(fact[i].ok, "%s: paper %s, simulated %s", fact[i].fact, fact[i].paper,
                      fact[i].simulated);
    }
    ck_assert_str_eq(find_fact(fact, facts, "escapement height at")->simulated, "2.20 mm");
    ck_assert_str_eq(find_fact(fact, facts, "slope of escapement")->simulated, "-20.0 mm/mm");
    ck_assert_str_eq(find_fact(fact, facts, "leftmost")->simulated, "-1.25 mm");
    ck_assert_str_eq(find_fact(fact, facts, "rightmost")->simulated, "+0.20 mm");
    ck_assert_str_eq(find_fact(fact, facts, "slope of peak force")->simulated, "5.00 N/mm");
    ck_assert_str_eq(find_fact(fact, facts, "re-arms")->simulated, "30 of 30 dx");
}
END_TEST

START_TEST(each_departure_from_the_paper_turns_its_fact_off)
{
    lab_point point[64];
    lab_fact fact[LAB_FACTS_MAX];
    int n = invent(point), at0 = 30;
    point[at0].stroke.rearmed = 0;
    int facts = lab_facts(fact, point, n);
    ck_assert(!find_fact(fact, facts, "re-arms")->ok);
    ck_assert_int_eq(count_off(fact, facts), 1);

    invent(point);
    point[n - 1].stroke.outcome = LAB_STRUCK;
    lab_facts(fact, point, n);
    ck_assert(!find_fact(fact, facts, "at dx = +0.3 mm")->ok);

    invent(point);
    for (int i = 0; i < n; i++) {
        point[i].stroke.escape_height += 0.2e-3;
    }
    lab_facts(fact, point, n);
    ck_assert(!find_fact(fact, facts, "escapement height at")->ok);
    ck_assert_int_eq(count_off(fact, facts), 1);

    invent(point);
    point[12].status = STEIN_ENONFINITE; // -0.9 mm, on both lines
    lab_facts(fact, point, n);
    ck_assert(!find_fact(fact, facts, "slope of escapement")->ok);
    ck_assert(!find_fact(fact, facts, "slope of peak force")->ok);
    ck_assert(!find_fact(fact, facts, "grows with dx")->ok);

    ck_assert_int_eq(count_off(fact, lab_facts(fact, point, 0)), facts); // no strokes at all
}
END_TEST

void lab_results_cases(Suite *suite)
{
    TCase *tc = tcase_create("lab results");
    tcase_set_timeout(tc, 120.0);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, every_number_that_is_printed_is_read_back_to_its_bits);
    tcase_add_test(tc, a_csv_reads_back_exactly);
    tcase_add_test(tc, numbers_are_the_shortest_that_read_back);
    tcase_add_test(tc, results_that_cannot_be_written_leave_nothing_behind);
    tcase_add_test(tc, a_measured_motion_drives_its_joint);
    tcase_add_test(tc, data_that_cannot_drive_are_refused_by_line);
    tcase_add_test(tc, a_sweep_is_the_same_on_any_number_of_threads);
    tcase_add_test(tc, a_sweep_needs_the_stop_and_a_stroke);
    tcase_add_test(tc, strokes_that_obey_the_paper_have_all_facts_right);
    tcase_add_test(tc, each_departure_from_the_paper_turns_its_fact_off);
    suite_add_tcase(suite, tc);
}
