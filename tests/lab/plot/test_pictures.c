/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_pictures.c - pictures of sweeps and records: the scripts that gnuplot is given, read in
 * its place.
 */
#include "lab_support.h"

static char *path_before;

/* a gnuplot that keeps its script as `script` and draws a line, or executes `instead` */
static void put_gnuplot(const char *instead)
{
    char *text =
        lab__text("#!/bin/sh\n%s\ncp \"$1\" %s/script\n"
                  "sed -n \"s/^set output '\\(.*\\)'$/\\1/p\" \"$1\" | while read -r to; do "
                  "echo drawn >\"$to\"; done\n",
                  instead, folder);
    write_program("gnuplot", text);
    free(text);
}

static void set_up(void)
{
    make_folder();
    const char *was = getenv("PATH");
    path_before = lab__text("%s", was != NULL ? was : "/usr/bin:/bin");
    char *with = lab__text("%s:%s", folder, path_before);
    ck_assert_int_eq(setenv("PATH", with, 1), 0);
    free(with);
    put_gnuplot("");
}

static void tear_down(void)
{
    setenv("PATH", path_before, 1);
    free(path_before);
    remove_folder();
}

/* the script of the last picture has all of these */
static void script_has(const char *const *has, size_t n)
{
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab__read_file(in_folder("script"), &text, &size, err));
    text_has(text, has, n);
    free(text);
}
#define HAS(...)                                   \
    script_has((const char *const[]){__VA_ARGS__}, \
               sizeof((const char *const[]){__VA_ARGS__}) / sizeof(char *))

static void script_lacks(const char *what)
{
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab__read_file(in_folder("script"), &text, &size, err));
    ck_assert_msg(strstr(text, what) == NULL, "\"%s\" in %s", what, text);
    free(text);
}

/* ---- tables ---- */

/* a table of rows, closed by NULL */
static lab_table *table_of(const char *head, const char *const *row)
{
    lab_table *t = NULL;
    ck_assert_stein(lab__table_new(&t, head, err));
    for (; *row != NULL; row++) {
        ck_assert_stein(lab__table_take(t, *row, strlen(*row), err));
    }
    return t;
}

static void drawn(const char *head, const char *const *row)
{
    lab_table *t = table_of(head, row);
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab_table_plot(in_folder("p.svg"), t, err));
    ck_assert_stein(lab__read_file(in_folder("p.svg"), &text, &size, err));
    ck_assert_str_eq(text, "drawn\n");
    free(text);
    lab_table_destroy(t);
}

START_TEST(outputs_of_one_unit_share_a_panel)
{
    static const char head[] =
        "# model: it's\n# vary a.b [m]: 3,1,2 mm\n"
        "point,a.b [m],status,t [s],u_1 [rad],far [m],v [rad],count,dip [m],w [rad]\n";
    static const char *const row[] = {"0,0.003,ok,1,0.1,2.5,0.4,7,0.5,nan",
                                      "1,0.001,ok,1,0.2,nan,0.5,8,0.25,nan",
                                      "2,0.002,ok,1,0.3,4.5,0.6,9,0.125,nan", NULL};
    drawn(head, row);
    HAS("'it''s over a.b, 3 points'", "set ylabel 'final [rad]'", "'final [m]'", "'count [1]'",
        "title 'u 1'", "set xlabel 'a.b [mm]'", "set xrange [0.96:3.04]", "$c4 using", "$c6 using",
        "ps 0.45", "svg size");
    script_lacks("$c9 using"); // has no value
}
END_TEST

START_TEST(lengths_below_a_metre_are_drawn_in_millimetres)
{
    static const char head[] =
        "# vary a.b [m]: 1 mm\npoint,a.b [m],status,t [s],dip [m],rise [m]\n";
    static const char *const row[] = {"0,0.001,ok,1,-0.002,inf", NULL};
    drawn(head, row);
    HAS("' over a.b, 1 points'", "'final [mm]'", "1 -2\n", "set xrange [0:2]");
}
END_TEST

START_TEST(a_panel_of_one_output_has_its_name)
{
    static const char head[] = "# vary a.b [m]: 1,2 mm\npoint,a.b [m],status,t [s],dip [m]\n";
    static const char *const row[] = {"0,0.001,ok,1,-0.002", "1,0.002,ok,1,nan", NULL};
    drawn(head, row);
    HAS("'dip [mm]'", "unset key");
}
END_TEST

START_TEST(an_event_that_never_happened_is_noted_in_its_panel)
{
    static const char head[] = "# vary a.b [m]: 1,2 mm\npoint,a.b [m],status,escapement_height [m],"
                               "escapement_time [s],impact_time [s],peak_string_force [N]\n";
    static const char *const row[] = {"0,0.001,ok,,,0.05,3", "1,0.002,ok,,,0.06,4", NULL};
    drawn(head, row);
    HAS("no event", "'escapement height [mm]'", "'time [ms]'", "title 'impact time'",
        "'peak string force [N]'");
    script_lacks("title 'escapement time'");
}
END_TEST

START_TEST(two_parameters_make_a_map)
{
    static const char head[] = "# model: m\n# vary a.b [m]: 2,1 mm\n# vary c [1]: 5\n"
                               "# vary d.e [kg]: 1:3:3 kg\n"
                               "point,a.b [m],c [1],d.e [kg],status,t [s],dip [m],rise [m]\n";
    static const char *const row[] = {"0,0.002,5,1,ok,1,0.2,1", "1,0.002,5,2,ok,1,0.3,1",
                                      "2,0.002,5,3,ok,1,0.4,1", "3,0.001,5,1,ok,1,0.5,1",
                                      "4,0.001,5,2,ok,1,0.6,1", NULL}; // one has no value
    drawn(head, row);
    HAS("'m: dip over a.b and d.e, 6 points'", "set xlabel 'a.b [mm]'", "set ylabel 'd.e [kg]'",
        "1 3", "title 'no value'", "$cells using", "set xrange [0.5:2.5]", "set yrange [0.5:3.5]",
        "set cblabel 'dip [mm]'");
    static const char *const all[] = {"0,0.002,5,1,ok,1,0.2,1",
                                      "1,0.002,5,2,ok,1,0.3,1",
                                      "2,0.002,5,3,ok,1,0.4,1",
                                      "3,0.001,5,1,ok,1,0.5,1",
                                      "4,0.001,5,2,ok,1,0.6,1",
                                      "5,0.001,5,3,ok,1,0.6,1",
                                      NULL};
    drawn(head, all);
    script_lacks("$none using");
    static const char *const none[] = {NULL};
    drawn(head, none);
    script_lacks("$cells using");

    static const char stroke[] = "# vary a.b [m]: 1,2 mm\n# vary d.e [kg]: 1,2 kg\n"
                                 "point,a.b [m],d.e [kg],status,escapement_height [m]\n";
    static const char *const some[] = {"0,0.001,1,ok,0.002", "1,0.001,2,ok,", NULL};
    drawn(stroke, some);
    HAS("'no escapement'", "'escapement height [mm]'");
}
END_TEST

START_TEST(a_table_that_cannot_be_drawn_is_reported)
{
    static const char *const none[] = {NULL};
    static const struct {
        const char *head, *says;
    } bad[] = {
        {"# vary a [m]: 1,2 mm\n# vary b [m]: 1,2 mm\n# vary c [m]: 1,2 mm\n"
         "point,a [m],b [m],c [m],status,t [s],dip [m]\n",
         "p.svg: 3 parameters vary, a picture shows one or two"},
        {"# model: m\npoint,status,t [s],dip [m]\n", "p.svg: 0 parameters vary, a picture shows"},
        {"# vary a [m]: 1,2 mm\npoint,a [m],status,t [s]\n", "p.svg: there is no output to draw"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_table *t = table_of(bad[i].head, none);
        stein_err why = {STEIN_OK, ""};
        ck_assert_int_eq(lab_table_plot(in_folder("p.svg"), t, &why), STEIN_EINVAL);
        ck_assert_msg(strstr(why.msg, bad[i].says) != NULL, "%s", why.msg);
        lab_table_destroy(t);
    }
    ck_assert_int_ne(access(in_folder("script"), F_OK), 0);
}
END_TEST

/* a journal may come from anywhere */
START_TEST(a_name_of_any_length_is_cut)
{
    static const char *const none[] = {NULL};
    char name[5000], *head, *cut;
    memset(name, 'n', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    head = lab__text(
        "# model: %s\n# vary a.b [m]: 1:70:70 mm\npoint,a.b [m],status,t [s],dip [m]\n", name);
    cut = lab__text("'%.100s", name);
    drawn(head, none);
    HAS(cut, "n over a.b, 70 points'");
    free(cut);
    free(head);
}
END_TEST

/* ---- gnuplot itself ---- */

START_TEST(a_gnuplot_that_fails_is_reported_with_its_last_words)
{
    static const struct {
        const char *does, *says;
    } bad[] = {
        {"echo out of ink; echo; echo 'warning: paper'; exit 3",
         "gnuplot failed (exit code 3): out of ink"},
        {"exit 1", "gnuplot failed (exit code 1): "},
        {"exit 0", "gnuplot drew nothing for "},
        {"exit 127", "no gnuplot to draw with: run apt-get install gnuplot-nox"},
    };
    static const char *const none[] = {NULL};
    lab_table *t = table_of("# vary a [m]: 1,2 mm\npoint,a [m],status,t [s],dip [m]\n", none);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        stein_err why = {STEIN_OK, ""};
        put_gnuplot(bad[i].does);
        ck_assert_int_eq(lab_table_plot(in_folder("q.png"), t, &why), STEIN_EIO);
        ck_assert_msg(strncmp(why.msg, bad[i].says, strlen(bad[i].says)) == 0, "%s", why.msg);
        ck_assert_int_ne(access(in_folder("q.png"), F_OK), 0);
    }
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_eq(lab_table_plot(in_folder("q.gif"), t, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "expected a name that ends in .svg or .png"));
    ck_assert_int_eq(setenv("TMPDIR", in_folder("none"), 1), 0);
    ck_assert_int_eq(lab_table_plot(in_folder("q.png"), t, &why), STEIN_EIO);
    unsetenv("TMPDIR");
    ck_assert_ptr_nonnull(strstr(why.msg, "no folder for temporary files"));
    put_gnuplot("");
    ck_assert_stein(lab_table_plot(in_folder("q.png"), t, err));
    HAS("pngcairo size 1350,1200");
    lab_table_destroy(t);
}
END_TEST

/* ---- records ---- */

static lab_record *record_of(const stein_model *m, double until, double every)
{
    stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
    lab_record *r = NULL;
    ck_assert_stein(lab_record_create(&r, m, every, err));
    for (double t = 0.0; t <= until; t += every) {
        ck_assert_stein(stein_run(sim, t, err));
        ck_assert_stein(lab_record_sample(r, sim));
    }
    stein_sim_destroy(sim);
    return r;
}

START_TEST(a_record_is_drawn_by_units_over_its_time)
{
    lab_record *r = record_of(&stein_model_pendulum, 0.4, 0.1);
    ck_assert_stein(lab_plot(in_folder("r.svg"), r, &stein_model_pendulum, NULL, err));
    HAS("set xlabel 'time [ms]'", "'angle [rad]'", "'[mm]'", "'tip_x'", "'tip_height'", "'[J]'",
        "'pendulum'");
    lab_record_destroy(r);
    r = record_of(&stein_model_pendulum, 2.5, 0.5);
    ck_assert_stein(lab_plot(in_folder("r.svg"), r, &stein_model_pendulum, NULL, err));
    HAS("set xlabel 'time [s]'");
    lab_record_destroy(r);
}
END_TEST

START_TEST(a_stroke_is_drawn_with_its_events)
{
    const stein_model *m = &stein_model_stein1788;
    lab_record *r = record_of(m, 0.06, 0.005);
    lab_stroke s = {.outcome = LAB_STRUCK,
                    .escaped = 1,
                    .escape_time = 0.041,
                    .impact_time = 0.047,
                    .escape_height = 2.3e-3,
                    .impact_speed = 1.1,
                    .peak_string_force = 12.5};
    ck_assert_stein(lab_plot(in_folder("s.svg"), r, m, &s, err));
    HAS("escapement 2.30 mm below the string, impact at 1.10 m/s, peak force 12.50 N",
        "set label 'escapement 41.00 ms' at 41.000000, graph 1.06 right",
        "set label 'impact 47.00 ms' at 47.000000, graph 1.06 left", "set xrange [33:59]",
        "'load on key'", "('–' 0, 'i' 1");
    s.escaped = 0; // never let off: one view less, and words for it
    s.outcome = LAB_NO_ESCAPEMENT;
    s.escape_time = s.impact_time = (double)NAN;
    ck_assert_stein(lab_plot(in_folder("s.svg"), r, m, &s, err));
    HAS("'stein1788: no escapement'");
    script_lacks("set arrow from");
    lab_record_destroy(r);
}
END_TEST

START_TEST(a_record_without_anything_to_draw_is_reported)
{
    lab_record *r = record_of(&stein_model_pendulum, 0.0, 0.1);
    stein_model mute = stein_model_pendulum;
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_eq(lab_plot(in_folder("r.svg"), r, &stein_model_pendulum, NULL, &why),
                     STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "r.svg: nothing to draw, 1 samples"));
    lab_record_destroy(r);
    r = record_of(&stein_model_pendulum, 0.4, 0.1);
    mute.nchannel = 1;
    ck_assert_int_eq(lab_plot(in_folder("r.svg"), r, &mute, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "r.svg: \"pendulum\" has no output to draw"));
    lab_record_destroy(r);
}
END_TEST

Suite *pictures_suite(void)
{
    Suite *s = suite_create("pictures");
    TCase *tc = tcase_create("pictures");
    tcase_add_checked_fixture(tc, set_up, tear_down);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, outputs_of_one_unit_share_a_panel);
    tcase_add_test(tc, lengths_below_a_metre_are_drawn_in_millimetres);
    tcase_add_test(tc, a_panel_of_one_output_has_its_name);
    tcase_add_test(tc, an_event_that_never_happened_is_noted_in_its_panel);
    tcase_add_test(tc, two_parameters_make_a_map);
    tcase_add_test(tc, a_table_that_cannot_be_drawn_is_reported);
    tcase_add_test(tc, a_name_of_any_length_is_cut);
    tcase_add_test(tc, a_gnuplot_that_fails_is_reported_with_its_last_words);
    tcase_add_test(tc, a_record_is_drawn_by_units_over_its_time);
    tcase_add_test(tc, a_stroke_is_drawn_with_its_events);
    tcase_add_test(tc, a_record_without_anything_to_draw_is_reported);
    suite_add_tcase(s, tc);
    return s;
}
