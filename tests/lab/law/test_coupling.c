/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_coupling.c - a rigid coupling that is none. From the motions of key and hammer alone a
 * diagnosis distinguishes a coupling that lets go from one that only pushes. It names nothing for a
 * rigid one.
 */
#include <string.h>

#include "fit_support.h"
#include "stein/diagnose.h"

enum { STROKES = 6, HELD = 2 };
static const char mechanism_file[] = "models/grand_action.yaml";
static const double arm = 0.2;         // of the key's sensor [m]
static const double film_noise = 1e-4; // of the hammer's sensor [m]

/* a key that is pressed so far [m], in this time [s] */
typedef struct touch {
    double depth, T;
} touch;

/* without a jerk */
static void press(void *ctx, double t, double u[3])
{
    const touch *k = ctx;
    double T = k->T, travel = k->depth / arm, s = fmin(fmax(t / T, 0.0), 1.0);
    u[0] = travel * s * s * s * (10.0 + s * (6.0 * s - 15.0));
    u[1] = travel / T * 30.0 * s * s * (1.0 - s) * (1.0 - s);
    u[2] = travel / (T * T) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
}

/* the stroke of a mechanism with these numbers in it */
static void film_of(const char *path, const char *const *truth, int n, touch k, int seed)
{
    lab_options options = cache_here(NULL);
    options.set = truth;
    options.nset = n;
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    unsigned long long random = 71ULL + (unsigned long long)seed;
    ck_assert_stein(lab_open(&model, mechanism_file, &options, err));
    stein_sim_def def = lab_def(model);
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    ck_assert_stein(stein_drive(sim, "key_motion", press, &k, err));
    ck_assert_stein(stein_reset(sim, err));
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# noise hammer_travel: %g m\n# trigger: unsynchronised\n", film_noise);
    fprintf(f, "time [s],key_motion [rad],hammer_travel [m]\n");
    for (int i = 0; i <= (k.T + 0.015) * 2000.0; i++) {
        double y, u[3], t = i / 2000.0;
        press(&k, t, u);
        if (i > 0) {
            ck_assert_stein(stein_run(sim, t, err));
        }
        ck_assert_stein(stein_read_name(sim, "hammer_travel", &y, err));
        fprintf(f, "%.5f,%.9f,%.7f\n", t, u[0], y + film_noise * gauss(&random));
    }
    ck_assert_int_eq(fclose(f), 0);
    stein_sim_destroy(sim);
    lab_close(model);
}

/* the rigid mechanism against strokes of another one */
static lab_diagnosis *diagnosed(const char *const *truth, int n, double depth)
{
    static const double T[STROKES] = {0.31, 0.087, 0.061, 0.044, 0.052, 0.071};
    static const unsigned char held[STROKES] = {[STROKES - HELD] = 1, [STROKES - 1] = 1};
    char path[STROKES][100];
    const char *data[STROKES + 1] = {NULL};
    fitted f;
    for (int s = 0; s < STROKES; s++) {
        char name[20];
        snprintf(name, sizeof name, "s%d.csv", s);
        snprintf(path[s], sizeof path[s], "%s", in_folder(name));
        film_of(path[s], truth, n, (touch){depth, T[s]}, s);
        data[s] = path[s];
    }
    open_fit(&f, mechanism_file, NULL, data);
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.threads = 2;
    def.options = &options;
    def.held_out = held;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, mechanism_file, f.model, f.data, &def, err));
    printf("coupling: %s, %s; chi2/dof %.2f -> %.2f\n", lab_verdict_text(d->verdict),
           d->ncause > 0 ? d->suspect[0].candidate.effect->kind : "-", d->chi2_dof_before,
           d->chi2_dof_after);
    drop(&f);
    return d;
}

START_TEST(a_rigid_coupling_is_left_alone)
{
    lab_diagnosis *d = diagnosed(NULL, 0, 12e-3);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
    ck_assert_int_eq(d->ncause, 0);
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_coupling_that_lets_go_is_found_with_its_height)
{
    static const char *const truth[] = {"jack.let_off.share=1", "jack.let_off.z=5.37 mm"};
    lab_diagnosis *d = diagnosed(truth, 2, 12e-3);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_msg(d->ncause == 1, "%s", d->reason);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "let_off");
    const lab_cause_number *n = &d->suspect[0].number[0]; // below the 8 mm of the file
    printf("coupling: lets go at %.3f mm (95 %%: %.3f .. %.3f), truly 5.370\n",
           8.0 - 1e3 * n->value, 8.0 - 1e3 * n->hi, 8.0 - 1e3 * n->lo);
    ck_assert(n->lo < 2.63e-3 && n->hi > 2.63e-3);
    ck_assert_close(n->value, 2.63e-3, 0.05, 0.0);
    ck_assert(d->gain.hi < 0.6);
    lab_diagnosis_destroy(d);
}
END_TEST

/* a key that is stopped before the hammer has met the string: it flies on */
START_TEST(a_coupling_that_only_pushes_is_called_one_sided)
{
    static const char *const truth[] = {"jack.slack=1"};
    lab_diagnosis *d = diagnosed(truth, 1, 8.7e-3);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_str_eq(d->suspect[0].candidate.effect->kind, "one_sided_link");
    const lab_cause_number *n = &d->suspect[0].number[0];
    printf("coupling: slack %.2f (95 %%: %.2f .. %.2f), truly 1; held-out error %.3f (.. %.3f)\n",
           n->value, n->lo, n->hi, d->gain.ratio, d->gain.hi);
    ck_assert_close(n->value, 1.0, 0.4, 0.0);
    ck_assert(n->lo < 1.0 && n->hi > 1.0);
    ck_assert(d->gain.hi < 0.9);
    lab_diagnosis_destroy(d);
}
END_TEST

Suite *coupling_suite(void)
{
    Suite *suite = suite_create("coupling");
    TCase *all = tcase_create("coupling");
    tcase_add_checked_fixture(all, make_folder, remove_folder);
    tcase_set_timeout(all, 900);
    tcase_add_test(all, a_rigid_coupling_is_left_alone);
    tcase_add_test(all, a_coupling_that_lets_go_is_found_with_its_height);
    tcase_add_test(all, a_coupling_that_only_pushes_is_called_one_sided);
    suite_add_tcase(suite, all);
    return suite;
}
