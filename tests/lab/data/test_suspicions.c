/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_suspicions.c - misread records are detected, correct ones are not. Strokes of the action
 * from rest, swings of a double pendulum from an unstated start, a slide on a spring, and published
 * measurements.
 */
#include <glob.h>

#include "data_support.h"
#include "suites.h"

enum { STROKES = 6, SWINGS = 4 };
static const double degree = 57.295779513082321;

/* what is done to the columns of a file; column 0 is the time */
typedef struct slip {
    int column, other; /* exchanged when other > 0; column -1: all, and the time is in ms */
    double factor;
} slip;

/* the same file with a slip */
static void copy_with(const char *from, const char *to, slip s)
{
    char line[400];
    FILE *f = fopen(from, "r"), *g = fopen(to, "w");
    ck_assert(f != NULL && g != NULL);
    for (int header = 1; fgets(line, sizeof line, f) != NULL;) {
        if (*line == '#' || header) {
            header &= *line == '#';
            if (strncmp(line, "# noise", 7) != 0) { // it has the unit of the column
                fputs(line, g);
            }
            continue;
        }
        char *cell[16] = {line};
        int n = 1;
        for (char *c = line; *c != '\0'; c++) {
            if (*c == ',' || *c == '\n') {
                *c = '\0';
                cell[n++] = c + 1;
            }
        }
        for (int k = 0; k < n - 1; k++) {
            int source = s.other == 0 ? k : k == s.column ? s.other : k == s.other ? s.column : k;
            const char *text = cell[source];
            int scaled = s.other == 0 && (k == s.column || s.column < 0);
            double factor = !scaled ? 1.0 : s.column < 0 && k == 0 ? 1e3 : s.factor;
            fprintf(g, *text == '\0' ? "%s" : "%s%.12g", k > 0 ? "," : "", factor * atof(text));
        }
        fputc('\n', g);
    }
    fclose(f);
    ck_assert_int_eq(fclose(g), 0);
}

/* records in a folder of the test: NAME_1.csv ..., those from `first` to `last` with a slip */
static lab_doubts *doubts_of(const lab_model *model, const char *source, int n, int first, int last,
                             slip s)
{
    char path[STROKES][200];
    const char *file[STROKES];
    lab_dataset *data = NULL;
    lab_doubts *doubts = NULL;
    lab_data_options o = lab_data_options_default(lab_equations(model));
    for (int i = 0; i < n; i++) {
        char from[200];
        snprintf(from, sizeof from, source, i + 1);
        snprintf(path[i], sizeof path[i], "%s/record_%d.csv", folder, i + 1);
        copy_with(from, path[i], i + 1 >= first && i + 1 <= last ? s : (slip){0, 0, 1.0});
        file[i] = path[i];
    }
    ck_assert_stein(lab_dataset_open(&data, file, n, &o, err));
    ck_assert_stein(lab_doubts_find(&doubts, model, data, err));
    lab_dataset_close(data);
    return doubts;
}

/* exactly one suspicion, with these words */
static void suspected(lab_doubts *d, lab_doubt_kind kind, const char *says)
{
    ck_assert_msg(d->n == 1, "%d suspicions, expected \"%s\"", d->n, says);
    ck_assert_msg(d->item[0].kind == kind && strstr(d->item[0].text, says) != NULL,
                  "\"%s\", expected \"%s\"", d->item[0].text, says);
    ck_assert_int_eq(d->grave, kind != LAB_DOUBT_ALIEN);
    lab_doubts_free(d);
}

static void nothing(lab_doubts *d)
{
    ck_assert_msg(d->n == 0, "%s", d->n > 0 ? d->item[0].text : "");
    lab_doubts_free(d);
}

/* ---- strokes from rest ---- */

static lab_model *model;

static void open_action(void)
{
    make_folder();
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", NULL, err));
}

static void close_model(void)
{
    lab_close(model);
    remove_folder();
}

#define OF_STROKES "models/strokes/stroke_%02d.csv"

START_TEST(a_scale_a_sign_and_an_exchange_are_noticed_in_strokes)
{
    static const struct {
        slip s;
        lab_doubt_kind kind;
        const char *says;
    } list[] = {
        {{1, 0, 1e3},
         LAB_DOUBT_SCALE,
         "string_distance: 38.98 m of travel, the model moves 39.22 mm"},
        {{1, 0, 1e3}, LAB_DOUBT_SCALE, "read as mm instead of m it fits"},
        {{2, 0, 1e-3}, LAB_DOUBT_SCALE, "read as m instead of mm it fits"},
        {{2, 0, 100.0}, LAB_DOUBT_SCALE, "key_dip: 708 mm of travel"},
        {{2, 0, -1.0}, LAB_DOUBT_SIGN, "key_dip: moves against the model; with the opposite sign"},
        {{1, 2, 1.0}, LAB_DOUBT_SWAPPED, "string_distance and key_dip: each fits"},
        {{0, 0, 1e3}, LAB_DOUBT_TIME, "time: the record lasts 1"},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        lab_doubts *d = doubts_of(model, OF_STROKES, STROKES, 1, STROKES, list[i].s);
        ck_assert_int_eq(d->n, 1);
        ck_assert_int_eq(d->item[0].records, STROKES);
        ck_assert_ptr_nonnull(strstr(d->item[0].text, "record_1.csv: "));
        suspected(d, list[i].kind, list[i].says);
    }
}
END_TEST

START_TEST(one_record_with_a_slip_is_named)
{
    static const slip list[] = {{1, 0, 1e3}, {2, 0, -1.0}, {1, 2, 1.0}, {0, 0, 1e3}};
    static const lab_doubt_kind kind[] = {LAB_DOUBT_SCALE, LAB_DOUBT_SIGN, LAB_DOUBT_SWAPPED,
                                          LAB_DOUBT_TIME};
    for (int i = 0; i < 4; i++) {
        lab_doubts *d = doubts_of(model, OF_STROKES, STROKES, 3, 3, list[i]);
        ck_assert_int_eq(d->n, 1);
        ck_assert_int_eq(d->item[0].stroke, 2);
        ck_assert_int_eq(d->item[0].records, 1);
        ck_assert_ptr_nonnull(strstr(d->item[0].text, "record_3.csv: "));
        suspected(d, kind[i], "this record alone");
    }
}
END_TEST

START_TEST(a_record_of_another_mechanism_is_named)
{
    const char *file[STROKES];
    char path[STROKES][60];
    FILE *f = fopen(in_folder("other.csv"), "w");
    fprintf(f, "time [s],string_distance [m],key_dip [m]\n");
    for (int i = 0; i < 400; i++) {
        double t = 0.25e-3 * i;
        fprintf(f, "%.5f,%.6f,%.6f\n", t, 0.02 + 0.011 * sin(291.0 * t), 0.004 * cos(173.0 * t));
    }
    fclose(f);
    for (int i = 0; i < STROKES; i++) {
        snprintf(path[i], sizeof path[i], OF_STROKES, i + 1);
        file[i] = i == 4 ? in_folder("other.csv") : path[i];
    }
    lab_dataset *data = NULL;
    lab_doubts *d = NULL;
    lab_data_options o = lab_data_options_default(lab_equations(model));
    ck_assert_stein(lab_dataset_open(&data, file, STROKES, &o, err));
    ck_assert_stein(lab_doubts_find(&d, model, data, err));
    suspected(d, LAB_DOUBT_ALIEN, "other.csv: all columns: the motion cannot be reproduced");
    lab_dataset_close(data);
}
END_TEST

START_TEST(strokes_as_they_are_are_not_suspected)
{
    nothing(doubts_of(model, OF_STROKES, STROKES, 0, 0, (slip){0, 0, 1.0}));
    nothing(doubts_of(model, OF_STROKES, 1, 0, 0, (slip){0, 0, 1.0}));
}
END_TEST

/* key_dip has a quarter of the other channel's rate, in separate rows */
START_TEST(channels_of_different_rates_are_compared)
{
    char line[200], time[40], distance[40], dip[40];
    FILE *f = fopen("models/strokes/stroke_06.csv", "r"), *g = fopen(in_folder("rates.csv"), "w");
    for (int row = 0; fgets(line, sizeof line, f) != NULL;) {
        if (sscanf(line, "%30[-0-9.],%30[-0-9.],%30[-0-9.e]", time, distance, dip) == 3) {
            fprintf(g, row % 4 == 3 ? "%s,,%.9g\n" : "%s,%.9g,\n", time,
                    row % 4 == 3 ? -atof(dip) : atof(distance));
            row++;
        } else if (row == 0) {
            fputs(line, g);
        }
    }
    fclose(f);
    fclose(g);
    char path[200];
    snprintf(path, sizeof path, "%s", in_folder("rates.csv"));
    suspected(doubts_of(model, path, 1, 0, 0, (slip){0, 0, 1.0}), LAB_DOUBT_SIGN,
              "key_dip: moves against the model");
}
END_TEST

/* a wrong number of the model is the fit's to find */
START_TEST(a_wrong_number_of_the_model_is_no_slip)
{
    static const char *const set[] = {"hammer.mass=2.2g", "key.mass=300g", "pawl.spring.k=2"};
    for (int i = 0; i < 2; i++) {
        lab_options options = lab_options_default();
        lab_model *other = NULL;
        options.set = &set[i];
        options.nset = 1;
        ck_assert_stein(lab_open(&other, "models/stein1788.yaml", &options, err));
        nothing(doubts_of(other, OF_STROKES, STROKES, 0, 0, (slip){0, 0, 1.0}));
        lab_close(other);
    }
}
END_TEST

START_TEST(the_texts_alone_are_handed_out)
{
    copy_with("models/strokes/stroke_01.csv", in_folder("a.csv"), (slip){2, 0, -1.0});
    copy_with("models/strokes/stroke_01.csv", in_folder("b.csv"), (slip){0, 0, 1.0});
    for (int i = 0; i < 2; i++) {
        const char *file = in_folder(i == 0 ? "a.csv" : "b.csv");
        lab_dataset *data = NULL;
        lab_data_options o = lab_data_options_default(lab_equations(model));
        char **finding = NULL;
        int n = -1;
        ck_assert_stein(lab_dataset_open(&data, &file, 1, &o, err));
        ck_assert_stein(lab_suspicions(&finding, &n, model, data, err));
        ck_assert_int_eq(n, i == 0);
        ck_assert(n == 0 || strstr(finding[0], "a.csv: key_dip: moves against") != NULL);
        lab_suspicions_free(finding, n);
        lab_dataset_close(data);
    }
    lab_doubts_free(NULL);
    lab_suspicions_free(NULL, 0);
}
END_TEST

/* ---- swings from an unstated start ---- */

/* swings of the double pendulum, filmed with some noise in mid-motion */
static void film_swings(void)
{
    static const double start[SWINGS][4] = {{0.71, 0.33, 0.0, 0.0},
                                            {-1.12, 0.4, 1.3, -0.7},
                                            {0.42, -0.63, -2.1, 1.9},
                                            {1.47, -0.29, 0.6, 2.3}};
    for (int i = 0; i < SWINGS; i++) {
        char name[40];
        stein_sim *sim = NULL;
        unsigned long long seed = 71 + (unsigned long long)i;
        ck_assert_stein(lab_sim(model, NULL, &sim, err));
        ck_assert_stein(stein_set_state(sim, 0.0, start[i], start[i] + 2, err));
        snprintf(name, sizeof name, "swing_%d.csv", i + 1);
        FILE *f = fopen(in_folder(name), "w");
        fprintf(f, "time [s],upper_angle [rad],lower_angle [rad]\n");
        for (int k = 0; k < 300; k++) {
            ck_assert_stein(stein_run(sim, 0.01 * k, err));
            fprintf(f, "%.4f,%.6f,%.6f\n", 12.3 + 0.01 * k,
                    stein_read(sim, 1) + 3e-3 * gaussian(&seed),
                    stein_read(sim, 2) + 3e-3 * gaussian(&seed));
        }
        fclose(f);
        stein_sim_destroy(sim);
    }
}

static void open_swings(void)
{
    make_folder();
    ck_assert_stein(lab_open(&model, "models/double_pendulum.yaml", NULL, err));
    film_swings();
}

static lab_doubts *swings_with(int first, int last, slip s)
{
    char source[220];
    snprintf(source, sizeof source, "%s/swing_%%d.csv", folder);
    return doubts_of(model, source, SWINGS, first, last, s);
}

START_TEST(slips_are_noticed_where_the_start_is_unknown)
{
    suspected(swings_with(1, SWINGS, (slip){1, 0, degree}), LAB_DOUBT_SCALE, "rad of travel");
    suspected(swings_with(1, SWINGS, (slip){2, 0, degree}), LAB_DOUBT_SCALE,
              "read as deg instead of rad it fits");
    suspected(swings_with(1, SWINGS, (slip){1, 2, 1.0}), LAB_DOUBT_SWAPPED,
              "upper_angle and lower_angle");
    suspected(swings_with(1, SWINGS, (slip){0, 0, 1e3}), LAB_DOUBT_TIME,
              "read as ms instead of s it fits");
    if (soaks() > 0) {
        suspected(swings_with(1, SWINGS, (slip){-1, 0, degree}), LAB_DOUBT_TIME,
                  "with time read as ms instead of s, and upper_angle, lower_angle as deg instead "
                  "of rad, it fits");
    }
    suspected(swings_with(2, 2, (slip){2, 0, degree}), LAB_DOUBT_SCALE,
              "record_2.csv: lower_angle");
}
END_TEST

/* two arms swing alike to both sides: one of the signs is wrong, but which? */
START_TEST(signs_that_cannot_be_separated_are_both_named)
{
    lab_doubts *d = swings_with(1, SWINGS, (slip){2, 0, -1.0});
    ck_assert_int_eq(d->n, 1);
    ck_assert_msg(strstr(d->item[0].text, "upper_angle or lower_angle: moves against") != NULL ||
                      strstr(d->item[0].text, "lower_angle or upper_angle: moves against") != NULL,
                  "%s", d->item[0].text);
    lab_doubts_free(d);
}
END_TEST

START_TEST(swings_as_they_are_are_not_suspected)
{
    nothing(swings_with(0, 0, (slip){0, 0, 1.0}));
    nothing(swings_with(1, SWINGS, (slip){1, 0, 1.03})); // a gain is the diagnosis' to find
}
END_TEST

/* ---- a linear model ---- */

START_TEST(the_travel_determines_the_unit_where_the_motion_does_not)
{
    static const char *const text = "mechanism: slide\n"
                                    "bodies:\n"
                                    "  slide:\n"
                                    "    joint: T x\n"
                                    "    mass: 1.3 kg\n"
                                    "    spring: {k: 52 N/m}\n"
                                    "    initial: {position: 41 mm}\n"
                                    "outputs:\n"
                                    "  x: {joint: slide, read: position}\n"
                                    "simulation: {dt: 1 ms, until: 2 s}\n";
    cache_in_build();
    ck_assert_stein(lab_open(&model, write_file("slide.yaml", text), NULL, err));
    for (int i = 0; i < 2; i++) {
        double size = i == 0 ? 1.0 : 1e3;
        FILE *f = fopen(in_folder("slide.csv"), "w");
        fprintf(f, "time,x\n");
        for (int k = 0; k < 200; k++) {
            fprintf(f, "%.3f,%.6g\n", 0.01 * k, size * 0.0331 * cos(6.3245553 * 0.01 * k + 0.3));
        }
        fclose(f);
        char source[200];
        snprintf(source, sizeof source, "%s", in_folder("slide.csv"));
        lab_doubts *d = doubts_of(model, source, 1, 0, 0, (slip){0, 0, 1.0});
        if (i == 0) {
            nothing(d);
        } else {
            suspected(d, LAB_DOUBT_SCALE,
                      "of travel, the largest length of the model is 41 mm; read as mm");
        }
    }
    lab_close(model);
}
END_TEST

/* ---- a pendulum: small swings have one shape at any scale ---- */

static lab_model *pendulum(const char *name, double centre)
{
    char text[600];
    lab_model *m = NULL;
    snprintf(text, sizeof text,
             "mechanism: bob\n"
             "bodies:\n"
             "  rod:\n"
             "    joint: R -y\n"
             "    mass: 300 g\n"
             "    centre: [0, 0, %g mm]\n"
             "    inertia: {yy: 0.004 kg m^2}\n"
             "    damping: 1.5e-3 N m s/rad\n"
             "    initial: {position: 15 deg}\n"
             "outputs:\n"
             "  angle: {joint: rod, read: position}\n"
             "simulation: {dt: 1 ms, until: 20 s}\n",
             centre);
    ck_assert_stein(lab_open(&m, write_file(name, text), NULL, err));
    return m;
}

START_TEST(units_that_are_both_possible_are_both_named_degrees_first)
{
    cache_in_build();
    lab_model *is = pendulum("is.yaml", -400.0), *wrong = pendulum("wrong.yaml", -420.0);
    stein_sim *sim = NULL;
    char source[200];
    ck_assert_stein(lab_sim(is, NULL, &sim, err));
    snprintf(source, sizeof source, "%s", in_folder("degrees.csv"));
    FILE *f = fopen(source, "w");
    fprintf(f, "t,angle\n");
    for (int k = 0; k < 500; k++) {
        ck_assert_stein(stein_run(sim, 0.02 * k, err));
        fprintf(f, "%.3f,%.4f\n", 0.02 * k, degree * stein_read(sim, 1));
    }
    fclose(f);
    stein_sim_destroy(sim);
    lab_doubts *d = doubts_of(wrong, source, 1, 0, 0, (slip){0, 0, 1.0});
    ck_assert_int_eq(d->n, 1);
    ck_assert_str_eq(d->item[0].brief, "angle is in deg or mrad, not in rad");
    suspected(d, LAB_DOUBT_SCALE, "read as deg or mrad instead of rad it fits");
    d = doubts_of(wrong, source, 1, 0, 0, (slip){0, 0, 1.0});
    suspected(d, LAB_DOUBT_SCALE, "a title states its unit as in \"angle (deg)\"");
    lab_close(is);
    lab_close(wrong);
}
END_TEST

/* ---- measurements made by others ---- */

static void not_suspected(const char *yaml, const char *pattern)
{
    glob_t found;
    if (access(yaml, R_OK) != 0 || glob(pattern, 0, NULL, &found) != 0) {
        printf("skipped: no %s\n", pattern);
        return;
    }
    lab_model *m = NULL;
    lab_dataset *data = NULL;
    lab_doubts *d = NULL;
    cache_in_build();
    ck_assert_stein(lab_open(&m, yaml, NULL, err));
    lab_data_options o = lab_data_options_default(lab_equations(m));
    ck_assert_stein(
        lab_dataset_open(&data, (const char *const *)found.gl_pathv, (int)found.gl_pathc, &o, err));
    ck_assert_stein(lab_doubts_find(&d, m, data, err));
    nothing(d);
    lab_dataset_close(data);
    lab_close(m);
    globfree(&found);
}

START_TEST(honest_measurements_are_not_suspected)
{
    static const char *const name[][2] = {{"single_arm", "single"},
                                          {"double_arm", "double"},
                                          {"geared_arm_forward", "a0"},
                                          {"geared_arm_inverse", "a0inv"},
                                          {"cube_fall", "cube"},
                                          {"video_pendulum_400", "pendulum"},
                                          {"video_pendulum_500", "pendulum"}};
    static const char *const hidden[] = {"a_none2", "d_stick", "g_two", "i_meta", "h_stuckL"};
    for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
        char *yaml = lab__text("../shared/cases/real/%s/%s.yaml", name[i][0], name[i][1]);
        char *csv = lab__text("../shared/cases/real/%s/*.csv", name[i][0]);
        not_suspected(yaml, csv);
        free(yaml);
        free(csv);
    }
    for (size_t i = 0; i < sizeof hidden / sizeof *hidden; i++) {
        char *csv = lab__text("../shared/cases/action/%s/*.csv", hidden[i]);
        not_suspected("models/stein1788.yaml", csv);
        free(csv);
    }
    not_suspected("models/double_pendulum.yaml", "../shared/cases/action/dp_jit/*.csv");
    not_suspected("models/stein1788.yaml", "models/strokes/*.csv");
}
END_TEST

Suite *suspicions_suite(void)
{
    Suite *suite = suite_create("suspicions");
    TCase *strokes = tcase_create("strokes"), *swings = tcase_create("swings");
    TCase *others = tcase_create("others");
    tcase_add_checked_fixture(strokes, open_action, close_model);
    tcase_add_checked_fixture(swings, open_swings, close_model);
    tcase_add_checked_fixture(others, make_folder, remove_folder);
    tcase_set_timeout(strokes, 120.0);
    tcase_set_timeout(swings, 120.0);
    tcase_set_timeout(others, 120.0);
    tcase_add_test(strokes, a_scale_a_sign_and_an_exchange_are_noticed_in_strokes);
    tcase_add_test(strokes, one_record_with_a_slip_is_named);
    tcase_add_test(strokes, a_record_of_another_mechanism_is_named);
    tcase_add_test(strokes, strokes_as_they_are_are_not_suspected);
    tcase_add_test(strokes, channels_of_different_rates_are_compared);
    tcase_add_test(strokes, a_wrong_number_of_the_model_is_no_slip);
    tcase_add_test(strokes, the_texts_alone_are_handed_out);
    tcase_add_test(swings, slips_are_noticed_where_the_start_is_unknown);
    tcase_add_test(swings, signs_that_cannot_be_separated_are_both_named);
    tcase_add_test(swings, swings_as_they_are_are_not_suspected);
    tcase_add_test(others, units_that_are_both_possible_are_both_named_degrees_first);
    tcase_add_test(others, the_travel_determines_the_unit_where_the_motion_does_not);
    tcase_add_test(others, honest_measurements_are_not_suspected);
    suite_add_tcase(suite, strokes);
    suite_add_tcase(suite, swings);
    suite_add_tcase(suite, others);
    return suite;
}
