/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_odd_records.c - swings of a pendulum: one states a wrong angle, or the pendulum changes
 * after one of them, or all mirror the angle. The diagnosis names the record and its true value,
 * and no other effect.
 */
#include <math.h>
#include <string.h>

#include "fit_support.h"
#include "search.h"
#include "stein/diagnose.h"
#include "suites.h"
#include "swings.h"

/* a diagnosis of swings [SWINGS], each a file */
static lab_diagnosis *diagnosed(fitted *f, const char *const *data)
{
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.threads = 2;
    def.options = &options;
    lab_diagnosis *d = NULL;
    open_fit(f, pendulum, NULL, data);
    ck_assert_stein(lab_diagnose(&d, pendulum, f->model, f->data, &def, err));
    printf("odd records: %s, chi2/dof %.3f -> %.3f\n", d->reason, d->chi2_dof_before,
           d->chi2_dof_after);
    return d;
}

/* a swing states its start in degrees */
static void say(const char *path, const char *said)
{
    static const char setting[] = "# set rod.initial.position:";
    char line[200], text[40000];
    size_t n = 0;
    int found = 0;
    FILE *f = fopen(path, "r");
    ck_assert_ptr_nonnull(f);
    while (fgets(line, sizeof line, f) != NULL) {
        int here = strncmp(line, setting, sizeof setting - 1) == 0;
        n += here ? (size_t)snprintf(text + n, sizeof text - n, "%s %s deg\n", setting, said)
                  : (size_t)snprintf(text + n, sizeof text - n, "%s", line);
        found |= here;
    }
    fclose(f);
    ck_assert_int_eq(found, 1);
    f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    ck_assert_int_eq(fclose(f), 0);
}

/* is the text in diagnosis.json? */
static int json_says(const lab_diagnosis *d, const char *what)
{
    char *path = lab__text("%s", in_folder("diagnosis.json")), *text = NULL;
    size_t size = 0;
    ck_assert_stein(lab_diagnosis_json(path, d, err));
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    int found = strstr(text, what) != NULL;
    free(text);
    free(path);
    return found;
}

/* swing 5 is fitted, swing 6 only reports */
START_TEST(one_record_with_a_wrong_setting_is_named_with_the_fitting_value)
{
    for (int odd = 4; odd <= 5; odd++) {
        const char *data[SWINGS + 1] = {NULL};
        char text[100];
        for (int i = 0; i < SWINGS; i++) {
            data[i] = film_swing(i, pendulum, NULL, 2100);
        }
        snprintf(text, sizeof text, "%d", 15 + 6 * odd);
        say(data[odd], text);
        fitted f;
        lab_diagnosis *d = diagnosed(&f, data);
        ck_assert_int_eq(d->verdict, LAB_VERDICT_WRONG_PARAMETER);
        ck_assert_int_eq(d->ncause, 1);
        const lab_suspect *s = &d->suspect[0];
        ck_assert_str_eq(s->candidate.effect->kind, "wrong_setting");
        ck_assert_str_eq(s->candidate.place, "rod.initial.position");
        ck_assert(s->candidate.from == odd + 1 && s->candidate.until == odd + 1);
        ck_assert_str_eq(s->file, f.data->stroke[odd]->file);
        double truth = (12 + 6 * odd) * acos(-1.0) / 180.0;
        ck_assert_double_eq_tol(s->stated + s->amount, truth, 4.0 * s->number[0].sd);
        ck_assert_double_lt(s->number[0].sd, 1e-3);
        ck_assert_double_lt(d->chi2_dof_after, 1.1);
        snprintf(text, sizeof text, "Record %d: its rod.initial.position", odd + 1);
        ck_assert_ptr_nonnull(strstr(d->reason, text));
        snprintf(text, sizeof text, "%d deg in the file", 15 + 6 * odd);
        ck_assert_ptr_nonnull(strstr(d->reason, text));
        snprintf(text, sizeof text, "\"stroke\": %d", odd + 1);
        ck_assert(json_says(d, "\"wrong_setting\": {") && json_says(d, text));
        ck_assert(json_says(d, "\"changed_after\": null"));
        // it is no number of the mechanism
        ck_assert(!lab_diagnosis_extends(d));
        stein_err why;
        ck_assert_int_eq(lab_extend(in_folder("none.yaml"), pendulum, d, &why), STEIN_EINVAL);
        lab_diagnosis_destroy(d);
        drop(&f);
    }
}
END_TEST

/* the lines of a record without those that begin with a word */
static void take_out(const char *path, const char *word)
{
    char line[200], text[40000];
    size_t n = 0;
    FILE *f = fopen(path, "r");
    ck_assert_ptr_nonnull(f);
    while (fgets(line, sizeof line, f) != NULL) {
        int out = strncmp(line, word, strlen(word)) == 0;
        n += out ? 0 : (size_t)snprintf(text + n, sizeof text - n, "%s", line);
    }
    fclose(f);
    f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    ck_assert_int_eq(fclose(f), 0);
}

/* No record that reports can show the wrong setting of another one. Where the noise is not stated
 * either, it is named all the same. */
START_TEST(a_wrong_setting_is_named_although_no_reporting_record_shows_it)
{
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, pendulum, NULL, 2100);
        take_out(data[i], "# noise");
    }
    say(data[4], "39");
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_WRONG_PARAMETER);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "wrong_setting");
    ck_assert_int_eq(d->suspect[0].candidate.from, 5);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* of the swings that are fitted - 1, 2, 4, 5, 7, 8 - the third one is the first with it; swing 3,
 * which only reports, shows that it had not begun there */
START_TEST(a_change_half_way_is_named_with_the_record_behind_which_it_begins)
{
    static const char *const before[] = {"rod.coulomb.T=0 N m", NULL}, *const after[] = {
                                                                           "rod.coulomb.T=2 mN m",
                                                                           NULL};
    for (int last = 2; last <= 3; last++) {
        const char *data[SWINGS + 1] = {NULL};
        for (int i = 0; i < SWINGS; i++) {
            data[i] = film_swing(i, pendulum, i < last ? before : after, 2300);
        }
        fitted f;
        lab_diagnosis *d = diagnosed(&f, data);
        ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
        ck_assert_int_eq(d->ncause, 1);
        const lab_suspect *s = &d->suspect[0];
        ck_assert_str_eq(s->candidate.effect->kind, "coulomb_friction");
        ck_assert_int_eq(s->candidate.from, last + 1);
        ck_assert_int_eq(s->candidate.until, 0);
        ck_assert(s->after == last && s->after_most == last);
        ck_assert_double_eq_tol(s->amount, 2e-3, 4.0 * s->number[0].sd);
        ck_assert_double_lt(d->chi2_dof_after, 1.1);
        char said[60];
        snprintf(said, sizeof said, "The records change after record %d:", last);
        ck_assert_ptr_nonnull(strstr(d->reason, said));
        snprintf(said, sizeof said, "\"changed_after\": %d", last);
        ck_assert(json_says(d, said));
        ck_assert(json_says(d, "\"kind\": \"changed_after\""));
        ck_assert(json_says(d, "\"effect\": \"coulomb_friction\""));
        // stroke by stroke: it is there from then on, and leaves noise everywhere
        ck_assert_int_eq(d->nrecord, SWINGS);
        for (int i = 0; i < SWINGS; i++) {
            const lab_seen *one = &d->record[i];
            int with = i >= last, fitted_one = i % 3 != 2;
            ck_assert_int_eq(one->number, i + 1);
            ck_assert_int_eq(one->reporting, !fitted_one);
            ck_assert_double_lt(one->after, 1.2);
            ck_assert_int_eq(isfinite(one->amount), with && fitted_one);
            if (isfinite(one->amount)) {
                ck_assert_double_eq_tol(one->amount, 2e-3, 4.5 * one->sd);
            }
        }
        ck_assert(json_says(d, "\"role\": \"reporting\""));
        // the file is the pendulum from then on, and is compared with the swings from then on
        ck_assert(d->verified.done && d->verified.same);
        ck_assert(json_says(d, "\"verified\": true"));
        lab_diagnosis_destroy(d);
        drop(&f);
    }
}
END_TEST

/* Swings with angles stated in whole degrees: 12 deg is between 11.5 and 12.5.
 * @param more  another number of the true pendulum, NULL: none
 * @return the RMS of what the fitted ones are off by [rad] */
static double film_rounded(const char *data[SWINGS + 1], const char *more)
{
    static const double off[SWINGS] = {0.31, -0.24, 0.4, -0.35, 0.12, -0.3, 0.28, 0.05, -0.41};
    static char path[SWINGS][200];
    double square = 0.0;
    int fitted_ones = 0;
    for (int i = 0; i < SWINGS; i++) {
        char begun[60], digits[10], name[60];
        snprintf(begun, sizeof begun, "rod.initial.position=%g deg", 12 + 6 * i + off[i]);
        snprintf(digits, sizeof digits, "%d", 12 + 6 * i);
        const char *const told[] = {begun, NULL}, *const truth[] = {more, NULL};
        film m = {.model = pendulum,
                  .truth = truth,
                  .told = told,
                  .channels = "angle",
                  .rate = 100.0,
                  .until = 4.0,
                  .noise = 1e-3,
                  .seed = 2700 + (unsigned long long)i};
        snprintf(name, sizeof name, "swing%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
        data[i] = path[i];
        say(path[i], digits);
        square += i % 3 != 2 ? off[i] * off[i] : 0.0;
        fitted_ones += i % 3 != 2;
    }
    return sqrt(square / fitted_ones) * acos(-1.0) / 180.0;
}

START_TEST(settings_that_are_off_within_their_last_digit_are_no_physics)
{
    const char *data[SWINGS + 1] = {NULL};
    double rms = film_rounded(data, NULL);
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    ck_assert_int_eq(d->nsetting_off, 1);
    ck_assert_str_eq(d->setting_off[0].name, "rod.initial.position");
    ck_assert_double_eq_tol(d->setting_off[0].rms, rms, 0.02 * rms);
    ck_assert_ptr_nonnull(strstr(d->reason, "rod.initial.position by 0."));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* and no effect imitates them beside the missing one */
START_TEST(beside_settings_that_are_off_a_cause_is_named_alone)
{
    const char *data[SWINGS + 1] = {NULL};
    double rms = film_rounded(data, "rod.coulomb.T=2 mN m");
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "coulomb_friction");
    ck_assert_double_eq_tol(d->suspect[0].amount, 2e-3, 4.0 * d->suspect[0].number[0].sd);
    ck_assert_int_eq(d->nsetting_off, 1);
    ck_assert_double_eq_tol(d->setting_off[0].rms, rms, 0.1 * rms);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(an_effect_in_all_records_is_no_change)
{
    static const char *const truth[] = {"rod.coulomb.T=2 mN m", NULL};
    fitted f;
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, pendulum, truth, 2500);
    }
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_int_eq(d->suspect[0].candidate.from, 0);
    ck_assert(json_says(d, "\"changed_after\": null"));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* A spring that acts beyond 34 deg: small swings are fitted, and every third one is large. */
START_TEST(a_model_that_explains_the_fitted_records_alone_is_not_called_right)
{
    static const char *const truth[] = {"rod.backlash.k=0.02 N m/rad", "rod.backlash.gap=0.6 rad",
                                        NULL};
    static const int order[] = {0, 1, 8, 2, 3, 7};
    enum { FILMS = sizeof order / sizeof *order };
    const char *data[FILMS + 1] = {NULL};
    fitted f;
    for (int i = 0; i < FILMS; i++) {
        data[i] = film_swing(order[i], pendulum, truth, 2700);
    }
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    ck_assert_double_gt(d->gain.rmse_after, 5.0);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_UNKNOWN_EFFECT);
    ck_assert_ptr_nonnull(strstr(d->reason, "those held out"));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* The records are of another pendulum, and state no start. The diagnosis searches for no effect. */
START_TEST(records_at_a_fifth_of_the_pace_are_no_motion_of_the_mechanism)
{
    static const char *const truth[] = {"rod.pendulum.frequency=0.2 Hz",
                                        "rod.initial.position=40 deg", NULL};
    static const film slow = {.model = pendulum,
                              .truth = truth,
                              .channels = "angle",
                              .rate = 100.0,
                              .until = 8.0,
                              .noise = 1e-3,
                              .seed = 2800};
    const char *const data[] = {take("slow.csv", &slow), NULL};
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_UNUSABLE_MODEL);
    ck_assert_ptr_nonnull(strstr(d->reason, "times as slowly"));
    ck_assert_int_eq(d->fits, 0);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* no verdict on the mechanism, but the fitting sign is named and written; with it nothing is
 * left */
START_TEST(a_channel_that_all_records_mirror_has_the_gain_that_fits_in_the_extended_file)
{
    static const char *const truth[] = {"angle.sensor.gain=-1", NULL};
    const char *data[SWINGS + 1] = {NULL};
    char mirrored[200];
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, pendulum, truth, 2900);
    }
    fitted f, again;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_UNUSABLE_MODEL);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "sensor_gain");
    ck_assert_str_eq(d->suspect[0].candidate.place, "angle");
    ck_assert_double_eq_tol(d->suspect[0].amount, -2.0, 1e-12);
    ck_assert(json_says(d, "\"verified\": null")); // nothing was fitted
    snprintf(mirrored, sizeof mirrored, "%s", in_folder("mirrored.yaml"));
    ck_assert_stein(lab_extend(mirrored, pendulum, d, err));
    open_fit(&again, mirrored, NULL, data);
    lab_doubts *doubts = NULL;
    ck_assert_stein(lab_doubts_find(&doubts, again.model, again.data, err));
    ck_assert_int_eq(doubts->grave, 0);
    lab_doubts_free(doubts);
    lab_diagnosis_destroy(d);
    drop(&f);
    drop(&again);
}
END_TEST

START_TEST(one_mirrored_record_is_no_gain_of_the_instrument)
{
    static const char *const truth[] = {"angle.sensor.gain=-1", NULL};
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = film_swing(i, pendulum, i == 3 ? truth : NULL, 2900);
    }
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_UNUSABLE_MODEL);
    ck_assert_int_eq(d->ncause, 0);
    ck_assert(!lab_diagnosis_extends(d));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

Suite *odd_records_suite(void)
{
    Suite *suite = suite_create("odd_records");
    TCase *tc = tcase_create("odd_records");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, one_record_with_a_wrong_setting_is_named_with_the_fitting_value);
    tcase_add_test(tc, a_wrong_setting_is_named_although_no_reporting_record_shows_it);
    tcase_add_test(tc, a_change_half_way_is_named_with_the_record_behind_which_it_begins);
    tcase_add_test(tc, settings_that_are_off_within_their_last_digit_are_no_physics);
    tcase_add_test(tc, beside_settings_that_are_off_a_cause_is_named_alone);
    tcase_add_test(tc, an_effect_in_all_records_is_no_change);
    tcase_add_test(tc, a_model_that_explains_the_fitted_records_alone_is_not_called_right);
    tcase_add_test(tc, records_at_a_fifth_of_the_pace_are_no_motion_of_the_mechanism);
    tcase_add_test(tc,
                   a_channel_that_all_records_mirror_has_the_gain_that_fits_in_the_extended_file);
    tcase_add_test(tc, one_mirrored_record_is_no_gain_of_the_instrument);
    suite_add_tcase(suite, tc);
    return suite;
}
