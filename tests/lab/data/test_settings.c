/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_settings.c - does the motion of a stroke agree with its `# set` lines? On the strokes of
 * models/strokes, in which an effect is hidden and the numbers of the file are wrong by their
 * tolerances.
 */
#include "data_support.h"
#include "suites.h"

enum { STROKES = 18 };

static lab_model *model;
static lab_dataset *data;
static said heard;

static void open_strokes(void)
{
    char path[STROKES][60];
    const char *file[STROKES];
    heard.n = 0;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", NULL, err));
    for (int i = 0; i < STROKES; i++) {
        snprintf(path[i], sizeof path[i], "models/strokes/stroke_%02d.csv", i + 1);
        file[i] = path[i];
    }
    lab_data_options options = lab_data_options_default(lab_equations(model));
    ck_assert_stein(lab_dataset_open(&data, file, STROKES, &options, err));
}

static void close_strokes(void)
{
    lab_dataset_close(data);
    lab_close(model);
}

/* the value of a setting of a stroke, to be changed */
static double *setting(int stroke, const char *name)
{
    const lab_data *d = data->stroke[stroke];
    for (int i = 0; i < d->nset; i++) {
        if (strcmp(d->set[i].name, name) == 0) {
            return (double *)(void *)&d->set[i].value;
        }
    }
    ck_abort_msg("no such setting");
    return NULL;
}

static void refused(const char *with)
{
    ck_assert_int_eq(lab_data_check_settings(data, model, hear, &heard, NULL), STEIN_EPARSE);
    ck_assert_int_eq(heard.n, 1);
    ck_assert_msg(was_said(&heard, with) == 1, "%s", heard.text[0]);
}

START_TEST(strokes_that_agree_with_their_settings_are_accepted)
{
    ck_assert_stein(lab_data_check_settings(data, model, hear, &heard, err));
    ck_assert_int_eq(heard.n, 0);
}
END_TEST

START_TEST(a_load_of_another_stroke_is_noticed)
{
    *setting(1, "load.mass") = 0.19; // it was 100 g
    refused("stroke_02.csv:2:7: the record contradicts its own \"# set load.mass: 0.19 kg\"");
}
END_TEST

/* off by 3 % of its travel, and its peers by 0.4 % */
START_TEST(a_load_that_only_the_peers_contradict_is_noticed)
{
    *setting(1, "load.mass") = 0.14;
    refused("with 0.1 kg it is off by");
}
END_TEST

START_TEST(kilograms_for_grams_are_noticed)
{
    *setting(2, "load.mass") = 140.0;
    refused("with 0.14 kg it is off by");
}
END_TEST

START_TEST(a_lost_sign_is_noticed)
{
    *setting(0, "pawl.stop_shift") = 0.7e-3;
    refused("with -700 um it is off by");
}
END_TEST

START_TEST(metres_for_millimetres_end_in_time)
{
    *setting(0, "pawl.stop_shift") = -0.7;
    refused("it cannot move with that");
}
END_TEST

/* errors that no slip of the pen explains are left to the diagnosis */
START_TEST(a_setting_that_is_a_little_off_is_accepted)
{
    *setting(1, "load.mass") = 0.103;
    ck_assert_stein(lab_data_check_settings(data, model, hear, &heard, err));
}
END_TEST

/* a drawing with another corner is no slip of twelve pens */
START_TEST(strokes_that_are_all_off_are_accepted)
{
    int corner = stein_find_param(lab_equations(model), "pawl.corner.x");
    char *text = lab__text("pawl.corner.x=%.9g", lab_parameters(model)[corner] - 1e-3);
    const char *set[] = {text};
    lab_options options = lab_options_default();
    lab_model *other;
    options.set = set;
    options.nset = 1;
    ck_assert_stein(lab_open(&other, "models/stein1788.yaml", &options, err));
    ck_assert_stein(lab_data_check_settings(data, other, hear, &heard, err));
    lab_close(other);
    free(text);
}
END_TEST

Suite *settings_suite(void)
{
    Suite *suite = suite_create("settings");
    TCase *tc = tcase_create("settings");
    tcase_add_checked_fixture(tc, open_strokes, close_strokes);
    tcase_set_timeout(tc, 900.0);
    tcase_add_test(tc, strokes_that_agree_with_their_settings_are_accepted);
    tcase_add_test(tc, a_load_of_another_stroke_is_noticed);
    tcase_add_test(tc, a_load_that_only_the_peers_contradict_is_noticed);
    tcase_add_test(tc, kilograms_for_grams_are_noticed);
    tcase_add_test(tc, a_lost_sign_is_noticed);
    tcase_add_test(tc, metres_for_millimetres_end_in_time);
    tcase_add_test(tc, a_setting_that_is_a_little_off_is_accepted);
    tcase_add_test(tc, strokes_that_are_all_off_are_accepted);
    suite_add_tcase(suite, tc);
    return suite;
}
