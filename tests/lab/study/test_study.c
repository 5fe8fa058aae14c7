/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_study.c - the study beyond the published facts: equilibria, sensitivities, tolerances,
 * repetition, and what a part is written to.
 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "lab_support.h"
#include "stein/models.h"
#include "study.h"

Suite *study_suite(void);

static lab_model *model;
static stein_sim *sim;
static study s;

static void open_study(void)
{
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", NULL, err));
    s = (study){.model = model, .threads = 2, .dt = 20e-6, .seed = 1788, .samples = 12};
    ck_assert_stein(study_begin(&s, err));
    ck_assert_stein(study_sim(&s, &sim, err));
}

static void close_study(void)
{
    stein_sim_destroy(sim);
    lab_close(model);
}

static double given(const char *name)
{
    return lab_parameters(model)[stein_find_param(lab_equations(model), name)];
}

static void set(const char *name, double value)
{
    ck_assert_stein(stein_set(sim, name, value, err));
}

/* ---- equilibrium ---- */

static void hold(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(double *)ctx;
    u[1] = u[2] = 0.0;
}

START_TEST(a_settled_action_stays_where_it_is)
{
    double angle = 0.37 * s.key_down, before[4];
    ck_assert_stein(stein_drive(sim, "key_motion", hold, &angle, err));
    ck_assert_stein(stein_reset(sim, err));
    stein_load_lift(sim);
    ck_assert_stein(stein_settle(sim, err));
    memcpy(before, stein_q(sim), sizeof before);
    ck_assert(before[0] == angle);
    ck_assert(stein_notch_phase(sim, 0) > 0); // the beak carries
    ck_assert_stein(stein_run(sim, 0.02, err));
    for (int j = 0; j < 3; j++) {
        ck_assert_close(stein_q(sim)[j], before[j], 0.0, 1e-9);
    }
}
END_TEST

START_TEST(settling_under_the_load_is_where_the_stroke_comes_to_rest)
{
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_run(sim, 2.0, err));
    double key = stein_q(sim)[0];
    ck_assert_stein(stein_settle(sim, err));
    ck_assert_int_eq(stein_load_present(sim), 1);
    ck_assert_close(stein_q(sim)[0], key, 0.0, 2e-5);
    ck_assert(stein_qd(sim)[0] == 0.0 && stein_qd(sim)[3] == 0.0);
}
END_TEST

START_TEST(the_static_escapement_is_higher_than_the_dynamic_one_and_has_no_friction)
{
    study_static still, smooth;
    study_press_slowly(&s, sim, &still);
    ck_assert_int_eq(still.status, STEIN_OK);
    ck_assert(still.escaped && still.force > 0.05 && still.force < 1.0);
    ck_assert_msg(still.height > s.reference.escape_height, "static %g, dynamic %g", still.height,
                  s.reference.escape_height);
    set("notch.friction.A", 0.5 * given("notch.friction.A"));
    study_press_slowly(&s, sim, &smooth);
    ck_assert_close(smooth.height, still.height, 0.0, 1e-9);
    double less =
        study_height(&s, sim); // friction holds the pawl back: with less it lets off sooner
    ck_assert_msg(less > s.reference.escape_height + 1e-4, "%g", less);
    ck_assert_msg(less < still.height, "%g", less);
}
END_TEST

START_TEST(the_static_height_falls_as_the_stop_moves_right)
{
    double last = INFINITY;
    for (int k = -6; k <= 1; k++) {
        study_static still;
        set("pawl.stop_shift", 0.13e-3 * k);
        study_press_slowly(&s, sim, &still);
        ck_assert(still.escaped && still.height < last - 1e-3);
        last = still.height;
    }
    study_static forced; // the hammer is on the string before the beak gets out, if ever
    set("pawl.stop_shift", 1e-3);
    study_press_slowly(&s, sim, &forced);
    ck_assert(forced.escaped ? forced.height == 0.0 : isnan(forced.height));
}
END_TEST

/* ---- strokes ---- */

START_TEST(the_coarser_step_of_the_study_is_accurate_to_a_micrometre)
{
    study fine = s;
    stein_sim *exact = NULL;
    fine.dt = 2.5e-6;
    ck_assert_stein(study_sim(&fine, &exact, err));
    const double dx[] = {-1.1e-3, -0.43e-3, 0.0};
    for (int i = 0; i < 3; i++) {
        set("pawl.stop_shift", dx[i]);
        ck_assert_stein(stein_set(exact, "pawl.stop_shift", dx[i], err));
        ck_assert_close(study_height(&s, sim), study_height(&fine, exact), 0.0, 1e-6);
    }
    stein_sim_destroy(exact);
}
END_TEST

START_TEST(the_short_run_for_a_height_finds_that_of_the_stroke)
{
    ck_assert(study_height(&s, sim) == s.reference.escape_height);
    set("pawl.stop_shift", 1e-3);
    ck_assert(isnan(study_height(&s, sim)));
}
END_TEST

START_TEST(friction_in_the_notch_takes_energy_and_only_friction_does)
{
    study_drive play = study_drive_default();
    study_details shot;
    for (int k = -8; k <= 2; k += 2) {
        set("pawl.stop_shift", 0.1e-3 * k);
        study_strike(&s, sim, &play, NULL, &shot);
        ck_assert_int_eq(shot.status, STEIN_OK);
        ck_assert_msg(shot.slip_work > 0.0 && shot.slip_work < 5e-3, "%g J", shot.slip_work);
        ck_assert(shot.slip_time > 0.0 && shot.slip_start > 0.0);
        ck_assert_close(shot.slip_start + shot.slip_time, shot.stroke.escape_time, 1e-12, 0.0);
    }
    set("pawl.stop_shift", 0.0);
    set("notch.friction.A", 0.0);
    study_strike(&s, sim, &play, NULL, &shot);
    ck_assert(shot.slip_work == 0.0);
}
END_TEST

START_TEST(a_released_key_re_arms_with_the_overlap_of_rest)
{
    study_drive play = study_drive_default();
    study_details shot;
    double rest = 0.0;
    play.until = 0.6;
    play.release = 0.2;
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_read_name(sim, "notch_overlap", &rest, err));
    study_strike(&s, sim, &play, NULL, &shot);
    ck_assert(shot.stroke.rearmed && shot.rearm_time > 0.0 && shot.rearm_time < 0.2);
    ck_assert_close(shot.rearm_margin, rest, 0.0, 0.02e-3);
    play.until = 0.201; // not back yet
    study_strike(&s, sim, &play, NULL, &shot);
    ck_assert(isnan(shot.rearm_time) && isnan(shot.rearm_margin));
}
END_TEST

START_TEST(prescribed_motions_have_the_derivatives_they_claim)
{
    for (int touch = STUDY_PRESSED; touch <= STUDY_STEADY; touch++) {
        double end[3];
        study_motion((study_touch)touch, 1.0, end);
        ck_assert(end[0] == 1.0);
        for (double u = 0.0371; u < 1.0; u += 0.0713) {
            double a[3], b[3], at[3], h = 1e-5;
            study_motion((study_touch)touch, u - h, a);
            study_motion((study_touch)touch, u + h, b);
            study_motion((study_touch)touch, u, at);
            ck_assert_close((b[0] - a[0]) / (2.0 * h), at[1], 1e-6, 1e-8);
            ck_assert_close((b[1] - a[1]) / (2.0 * h), at[2], 1e-6, 1e-6);
        }
    }
}
END_TEST

START_TEST(a_key_pressed_faster_throws_the_hammer_faster)
{
    double last = 0.0;
    for (int k = 0; k < 5; k++) {
        study_drive play = {STUDY_PRESSED, 0.08 / (1 << k) + 1e-3, 1.0, 0.2, NAN};
        study_details shot;
        study_strike(&s, sim, &play, NULL, &shot);
        ck_assert_int_eq(shot.stroke.outcome, LAB_STRUCK);
        ck_assert(shot.stroke.impact_speed > last);
        last = shot.stroke.impact_speed;
    }
    ck_assert(last > 3.0);
}
END_TEST

START_TEST(regulating_arrives_at_the_height)
{
    const double height = 3.217e-3;
    double value = NAN;
    ck_assert(study_level(&s, sim, "pawl.stop_shift", -0.5e-3, 0.05e-3, height, &value));
    set("pawl.stop_shift", value);
    ck_assert_close(study_height(&s, sim), height, 0.0, 2e-6);
    ck_assert(!study_level(&s, sim, "pawl.stop_shift", -0.5e-3, -0.4e-3, height, &value));
    ck_assert(!study_level(&s, sim, "no.such", -0.5e-3, 0.05e-3, height, &value));
}
END_TEST

/* ---- sensitivity and tolerance ---- */

static const study_slope *slope_of(const study_slope *slope, int n, const char *name)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(lab_equations(model)->params[slope[i].param].name, name) == 0) {
            return &slope[i];
        }
    }
    ck_abort_msg("no slope of %s", name);
    return NULL;
}

START_TEST(sensitivities_predict_the_effect_of_a_changed_parameter)
{
    study_slope *slope = calloc((size_t)lab_equations(model)->np + 1, sizeof *slope);
    int n = 0, agree = 0;
    ck_assert_stein(study_slopes(&s, slope, &n, err));
    for (int i = 0; i < n; i++) {
        agree += slope[i].agrees;
    }
    ck_assert_msg(n > 90 && agree >= n - n / 20, "%d of %d", agree, n);

    // until it escapes the hammer does not depend on the string
    const study_slope *string = slope_of(slope, n, "string.height");
    ck_assert_close(string->slope[0], string->unit, 1e-6, 0.0);

    const char *const name[] = {"pawl.stop_shift", "hammer.beak.x", "key.kapsel.x", "stop.normal.c",
                                "hammer.mass"};
    const study_slope *k[5];
    study_bend bend[6] = {{.param = string->param}}; // the last five are bent
    double x = 0.07;
    for (int i = 0; i < 5; i++) {
        k[i] = slope_of(slope, n, name[i]);
        bend[i + 1] = (study_bend){.param = k[i]->param, .by = x * k[i]->unit};
    }
    ck_assert_stein(study_bends(&s, bend, 6, err));
    for (int i = 0; i < 5; i++) {
        ck_assert(bend[0].struck && bend[i + 1].struck);
        ck_assert_close(bend[i + 1].y[0] - bend[0].y[0], x * k[i]->slope[0], 0.06, 1e-6);
        ck_assert_close(bend[i + 1].y[1] - bend[0].y[1], x * k[i]->slope[1], 0.06, 1e-4);
    }
    ck_assert(bend[0].y[0] == s.reference.escape_height); // in lanes as alone
    ck_assert(bend[0].y[1] == s.reference.impact_speed);
    ck_assert(bend[0].y[2] == s.reference.peak_string_force);
    free(slope);
}
END_TEST

START_TEST(monte_carlo_depends_on_the_seed_and_not_on_the_threads)
{
    double two[12], one[12], other[12];
    ck_assert_stein(study_monte_carlo(&s, 0.1, two, err));
    s.threads = 1;
    ck_assert_stein(study_monte_carlo(&s, 0.1, one, err));
    ck_assert(memcmp(one, two, sizeof one) == 0);
    s.seed = 1789;
    ck_assert_stein(study_monte_carlo(&s, 0.1, other, err));
    ck_assert(memcmp(one, other, sizeof one) != 0);
    double reference = study_height(&s, sim);
    ck_assert_stein(study_monte_carlo(&s, 0.0, other, err));
    for (int i = 0; i < 12; i++) {
        ck_assert(other[i] == reference); // no tolerance, no spread
    }
}
END_TEST

/* ---- repetition ---- */

static stein_sim *make_controlled(void)
{
    const stein_sim_def def = study_def_controlled(&s);
    stein_sim *by_error = NULL;
    ck_assert_stein(lab_sim(model, &def, &by_error, err));
    return by_error;
}

START_TEST(the_limit_of_repetition_is_bracketed)
{
    const study_rhythm push = {0.06, 1.0, 1}, force = {0.06, 1.0, 0};
    stein_sim *long_one = make_controlled();
    double push_fails, force_fails;
    double pushed = study_repetition_limit(&s, long_one, &push, &push_fails);
    double forced = study_repetition_limit(&s, long_one, &force, &force_fails);
    ck_assert(study_repeats(&s, long_one, pushed, &push) &&
              !study_repeats(&s, long_one, push_fails, &push));
    ck_assert(study_repeats(&s, long_one, forced, &force) &&
              !study_repeats(&s, long_one, force_fails, &force));
    stein_sim_destroy(long_one);
    ck_assert(push_fails < pushed && push_fails > 0.99 * pushed);
    ck_assert(forced <= pushed); // a pulled key comes up sooner
}
END_TEST

START_TEST(the_key_must_come_back_far_enough)
{
    stein_sim *long_one = make_controlled();
    double fails = NAN, needed = study_return_needed(&s, long_one, 0.3, 0.06, &fails);
    study_rhythm how = {0.06, needed, 0};
    ck_assert(needed > 0.5 && needed <= 1.0 && fails < needed && needed - fails < 0.01);
    ck_assert(study_repeats(&s, long_one, 0.3, &how));
    how.depth = fails;
    ck_assert(!study_repeats(&s, long_one, 0.3, &how));
    stein_sim_destroy(long_one);
}
END_TEST

/* ---- parts and their files ---- */

START_TEST(tables_write_numbers_and_leave_absent_ones_empty)
{
    static const char *const head[] = {"a [m]", "b [N]", NULL};
    char path[] = "/tmp/stein-study-XXXXXX", text[200] = "";
    study_part part = {.id = "x"};
    study_table *t = study_table_new(&part, "x", 2, head);
    study_row(t, 0)[0] = 0.1;
    study_row(t, 1)[1] = -2.5;
    int fd = mkstemp(path);
    ck_assert_int_ge(fd, 0);
    close(fd);
    ck_assert_stein(study_write_csv(&s, t, path, err));
    FILE *f = fopen(path, "r");
    ck_assert_uint_gt(fread(text, 1, sizeof text - 1, f), 0);
    fclose(f);
    unlink(path);
    ck_assert_str_eq(text, "# model: stein1788\na [m],b [N]\n0.1,\n,-2.5\n");
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(study_write_csv(&s, t, "/dev/full", &err), STEIN_EIO);
    ck_assert_msg(strstr(err.msg, "/dev/full") != NULL, "%s", err.msg);
    study_part_free(&part);
}
END_TEST

START_TEST(sentences_belong_to_the_picture_before_them)
{
    study_part part = {.id = "x"};
    study_say(&part, "ahead %d", 1);
    study_say(&part, "and more");
    study_chart *c = study_chart_new(&part, "p", 100, 100, 1);
    study_say(&part, "under");
    ck_assert_str_eq(part.text, "ahead 1 and more");
    ck_assert_str_eq(c->text, "under");
    study_part_free(&part);
}
END_TEST

START_TEST(a_picture_of_nothing_is_still_a_picture)
{
    static const char *const head[] = {"a [m]", "b [N]", NULL};
    char path[40];
    study_part part = {.id = "x"};
    study_table *t = study_table_new(&part, "x", 3, head);
    study_chart *c = study_chart_new(&part, "x", 400, 300, 1);
    study_panel *p = study_panel_new(c, "it's 100 %", "b");
    p->logx = p->legend = 1;
    study_curve_add(p, t, 0, 1.0, 1, 1.0, STUDY_BOTH, 0, "100 % of nothing");
    snprintf(path, sizeof path, "/tmp/stein-study-%ld.svg", (long)getpid());
    ck_assert_stein(study_draw(c, path, err));
    ck_assert_int_eq(unlink(path), 0);
    study_part_free(&part);
}
END_TEST

START_TEST(a_report_needs_a_folder_it_can_write)
{
    study_report none = {.npart = 0};
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(study_write(&s, &none, "/dev/null/x", &err), STEIN_EIO);
    ck_assert_msg(strstr(err.msg, "/dev/null/x") != NULL, "%s", err.msg);
}
END_TEST

START_TEST(models_without_a_stroke_are_refused_by_name)
{
    lab_model *pendulum = NULL;
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(lab_open(&pendulum, "models/pendulum.yaml", NULL, &err), STEIN_OK);
    study none = {.model = pendulum, .threads = 1, .dt = 20e-6};
    ck_assert_int_eq(study_begin(&none, &err), STEIN_EINVAL);
    ck_assert_msg(strstr(err.msg, "pendulum") && strstr(err.msg, "stroke"), "%s", err.msg);
    lab_close(pendulum);
}
END_TEST

/* ---- actions with other names ---- */

/* the action with words of its file replaced, all of them */
static lab_model *open_renamed(const char *const (*word)[2], int n)
{
    char *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab__read_file("models/stein1788.yaml", &text, &size, err));
    for (int i = 0; i < n; i++) {
        char *at = strstr(text, word[i][0]);
        ck_assert_msg(at != NULL, "the file has no %s", word[i][0]);
        for (size_t done = 0; at != NULL; at = strstr(text + done, word[i][0])) {
            char *more =
                lab__text("%.*s%s%s", (int)(at - text), text, word[i][1], at + strlen(word[i][0]));
            done = (size_t)(at - text) + strlen(word[i][1]);
            free(text);
            text = more;
        }
    }
    lab_model *renamed = open_text(text, NULL, 0);
    free(text);
    return renamed;
}

/* a part of the study of a model, and the one sentence it must be left with */
static void left_out(study_part_fn *run, const study *of, const char *says)
{
    study_part part = {.id = ""};
    ck_assert_stein(run(of, &part, err));
    ck_assert_str_eq(part.text, says);
    ck_assert(part.ntable == 0 && part.nchart == 0);
    study_part_free(&part);
}

START_TEST(without_a_motion_of_the_key_only_loads_press_it)
{
    static const char *const word[][2] = {{"key_motion", "key_path"}};
    lab_model *renamed = open_renamed(word, 1);
    study other = {.model = renamed, .threads = 2, .dt = 20e-6};
    ck_assert_stein(study_begin(&other, err));
    ck_assert(other.reference.escape_height == s.reference.escape_height);
    left_out(study_repetition, &other,
             "Left out: the model has no input key_motion: {motion: ...}.");
    study_part part = {.id = ""};
    ck_assert_stein(study_touches(&other, &part, err));
    ck_assert(part.ntable == 1 && part.nchart == 1);
    ck_assert_int_eq(part.chart[0].panel[1].ncurve, 1);
    static const char *const has[] = {
        "Under falling loads from 40 to 400 g, ",
        "Prescribed key motions are left out: the model has no input key_motion: {motion: ...}."};
    text_has(part.chart[0].text, has, 2);
    ck_assert_ptr_null(strstr(part.chart[0].text, "pressed"));
    study_part_free(&part);
    lab_close(renamed);
}
END_TEST

START_TEST(parts_without_their_parameter_name_it)
{
    static const char *const word[][2] = {
        {"pawl", "jack"}, {"jack.stop_shift", "pawl.stop_shift"}, {"key_dip", "dip_of_key"}};
    lab_model *renamed = open_renamed(word, 3);
    study other = {.model = renamed, .threads = 2, .dt = 20e-6};
    ck_assert_stein(study_begin(&other, err));
    ck_assert_int_lt(other.input, 0);
    left_out(study_regulation, &other, "Left out: the model has no parameter pawl.spring.k.");
    left_out(study_angle, &other, "Left out: the model has no parameter pawl.notch_angle.");
    left_out(study_repetition, &other, "Left out: the model has no output key_dip.");
    lab_close(renamed);
}
END_TEST

START_TEST(a_stroke_without_a_notch_is_refused)
{
    static const char *const word[][2] = {{", notch: notch}", "}"}};
    lab_model *renamed = open_renamed(word, 1);
    study other = {.model = renamed, .threads = 1, .dt = 20e-6};
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_eq(study_begin(&other, &why), STEIN_EINVAL);
    ck_assert_str_eq(why.msg, "\"stein1788\" has no notch in its stroke, which the study needs");
    lab_close(renamed);
}
END_TEST

Suite *study_suite(void)
{
    Suite *suite = suite_create("study");
    TCase *tc = tcase_create("study");
    tcase_set_timeout(tc, 120.0);
    tcase_add_checked_fixture(tc, open_study, close_study);
    tcase_add_test(tc, a_settled_action_stays_where_it_is);
    tcase_add_test(tc, settling_under_the_load_is_where_the_stroke_comes_to_rest);
    tcase_add_test(tc, the_static_escapement_is_higher_than_the_dynamic_one_and_has_no_friction);
    tcase_add_test(tc, the_static_height_falls_as_the_stop_moves_right);
    tcase_add_test(tc, the_coarser_step_of_the_study_is_accurate_to_a_micrometre);
    tcase_add_test(tc, the_short_run_for_a_height_finds_that_of_the_stroke);
    tcase_add_test(tc, friction_in_the_notch_takes_energy_and_only_friction_does);
    tcase_add_test(tc, a_released_key_re_arms_with_the_overlap_of_rest);
    tcase_add_test(tc, prescribed_motions_have_the_derivatives_they_claim);
    tcase_add_test(tc, a_key_pressed_faster_throws_the_hammer_faster);
    tcase_add_test(tc, regulating_arrives_at_the_height);
    tcase_add_test(tc, sensitivities_predict_the_effect_of_a_changed_parameter);
    tcase_add_test(tc, monte_carlo_depends_on_the_seed_and_not_on_the_threads);
    tcase_add_test(tc, the_limit_of_repetition_is_bracketed);
    tcase_add_test(tc, the_key_must_come_back_far_enough);
    tcase_add_test(tc, tables_write_numbers_and_leave_absent_ones_empty);
    tcase_add_test(tc, sentences_belong_to_the_picture_before_them);
    tcase_add_test(tc, a_picture_of_nothing_is_still_a_picture);
    tcase_add_test(tc, a_report_needs_a_folder_it_can_write);
    tcase_add_test(tc, models_without_a_stroke_are_refused_by_name);
    suite_add_tcase(suite, tc);

    TCase *names = tcase_create("names");
    tcase_set_timeout(names, 120.0);
    tcase_add_checked_fixture(names, make_folder, remove_folder);
    tcase_add_checked_fixture(names, open_study, close_study);
    tcase_add_test(names, without_a_motion_of_the_key_only_loads_press_it);
    tcase_add_test(names, parts_without_their_parameter_name_it);
    tcase_add_test(names, a_stroke_without_a_notch_is_refused);
    suite_add_tcase(suite, names);
    return suite;
}
