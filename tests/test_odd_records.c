/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_odd_records.c - swings of a pendulum of which one states a wrong angle, or that change after
 * one of them: which record it is, what would fit there, and nothing else is named.
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

/* a swing that says it began `off` degrees from where it did */
static const char *mistaken(int i, double off, unsigned long long seed)
{
    char begun[60], said[60], line[200], text[40000];
    size_t n = 0;
    snprintf(begun, sizeof begun, "# set rod.initial.position: %d deg\n", 12 + 6 * i);
    snprintf(said, sizeof said, "# set rod.initial.position: %g deg\n", 12 + 6 * i + off);
    const char *path = film_swing(i, pendulum, NULL, seed);
    FILE *f = fopen(path, "r");
    ck_assert_ptr_nonnull(f);
    while (fgets(line, sizeof line, f) != NULL) {
        n += (size_t)snprintf(text + n, sizeof text - n, "%s",
                              strcmp(line, begun) == 0 ? said : line);
    }
    fclose(f);
    ck_assert_ptr_nonnull(strstr(text, said));
    f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    ck_assert_int_eq(fclose(f), 0);
    return path;
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

START_TEST(one_record_with_a_wrong_setting_is_named_with_what_would_fit)
{
    const char *data[SWINGS + 1] = {NULL};
    for (int i = 0; i < SWINGS; i++) {
        data[i] = mistaken(i, i == 4 ? 3.0 : 0.0, 2100);
    }
    fitted f;
    lab_diagnosis *d = diagnosed(&f, data);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_WRONG_PARAMETER);
    ck_assert_int_eq(d->ncause, 1);
    const lab_suspect *s = &d->suspect[0];
    ck_assert_str_eq(s->candidate.effect->kind, "wrong_setting");
    ck_assert_str_eq(s->candidate.place, "rod.initial.position");
    ck_assert(s->candidate.from == 5 && s->candidate.until == 5);
    ck_assert_str_eq(s->file, f.data->stroke[4]->file);
    double truth = 36.0 * acos(-1.0) / 180.0;
    ck_assert_double_eq_tol(s->stated + s->amount, truth, 4.0 * s->number[0].sd);
    ck_assert_double_lt(s->number[0].sd, 1e-3);
    ck_assert_double_lt(d->chi2_dof_after, 1.1);
    ck_assert_ptr_nonnull(strstr(d->reason, "Stroke 5's rod.initial.position"));
    ck_assert_ptr_nonnull(strstr(d->reason, "39 deg in the file"));
    ck_assert(json_says(d, "\"wrong_setting\": {"));
    ck_assert(json_says(d, "\"stroke\": 5"));
    ck_assert(json_says(d, "\"changed_after\": null"));
    // it is no number of the mechanism
    ck_assert(!lab_diagnosis_extends(d));
    stein_err why;
    ck_assert_int_eq(lab_extend(in_folder("none.yaml"), pendulum, d, &why), STEIN_EINVAL);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* of the swings that are fitted - 1, 2, 4, 5, 7, 8 - the third one is the first with it; swing 3,
 * which only reports, tells that it had not begun there */
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
        snprintf(said, sizeof said, "The records change after stroke %d:", last);
        ck_assert_ptr_nonnull(strstr(d->reason, said));
        snprintf(said, sizeof said, "\"changed_after\": %d", last);
        ck_assert(json_says(d, said));
        ck_assert(json_says(d, "\"kind\": \"changed_after\""));
        ck_assert(json_says(d, "\"effect\": \"coulomb_friction\""));
        // the file is the pendulum from then on, and is compared with the swings from then on
        ck_assert(d->verified.done && d->verified.same);
        ck_assert(json_says(d, "\"verified\": true"));
        lab_diagnosis_destroy(d);
        drop(&f);
    }
}
END_TEST

START_TEST(what_acts_in_all_records_is_no_change)
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

Suite *odd_records_suite(void)
{
    Suite *suite = suite_create("odd_records");
    TCase *tc = tcase_create("odd_records");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, one_record_with_a_wrong_setting_is_named_with_what_would_fit);
    tcase_add_test(tc, a_change_half_way_is_named_with_the_record_behind_which_it_begins);
    tcase_add_test(tc, what_acts_in_all_records_is_no_change);
    suite_add_tcase(suite, tc);
    return suite;
}
