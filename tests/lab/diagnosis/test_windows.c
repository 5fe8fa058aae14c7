/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_windows.c - one long record: chaotic motion is cut into windows, of regular motion blocks
 * are held out.
 *
 * Two levers in a chain, by Lagrange's equations in absolute angles and steps of RK4; nothing of
 * generator or core.
 */
#include <math.h>
#include <string.h>

#include "data_cut.h"
#include "fit_support.h"
#include "search.h"
#include "stein/diagnose.h"
#include "suites.h"

static const char levers[] = "mechanism: levers\n"
                             "bodies:\n"
                             "  upper:\n"
                             "    joint: R -y\n"
                             "    mass: 100 g\n"
                             "    centre: [0, 0, -46 mm]\n"
                             "    inertia: {yy: 7.0e-5 kg m^2}\n"
                             "    points: {elbow: [0, 0, -92 mm]}\n"
                             "  lower:\n"
                             "    parent: upper\n"
                             "    joint: R -y\n"
                             "    at: upper.elbow\n"
                             "    mass: 75 g\n"
                             "    centre: [0, 0, -35 mm]\n"
                             "    inertia: {yy: 3.0e-5 kg m^2}\n"
                             "outputs:\n"
                             "  phi1: {joint: upper, read: position}\n"
                             "  phi2: {joint: lower, read: position}\n"
                             "simulation: {dt: 0.2 ms, until: 2 s, integrator: dp5}\n";

/* d/dt of the absolute angles a, b and their speeds, with viscous friction at the elbow */
static void derive(const double y[4], double viscous, double to[4])
{
    static const double g = 9.81, m1 = 0.1, c1 = 0.046, l = 0.092, I1 = 7e-5, m2 = 0.075,
                        c2 = 0.035, I2 = 3e-5;
    double s = sin(y[0] - y[1]), c = cos(y[0] - y[1]), h = m2 * l * c2;
    double a = I1 + m1 * c1 * c1 + m2 * l * l, b = h * c, d = I2 + m2 * c2 * c2;
    double torque = -viscous * (y[3] - y[2]);
    double u = -(m1 * c1 + m2 * l) * g * sin(y[0]) - h * s * y[3] * y[3] - torque;
    double v = -m2 * c2 * g * sin(y[1]) + h * s * y[2] * y[2] + torque;
    double det = a * d - b * b;
    to[0] = y[2];
    to[1] = y[3];
    to[2] = (d * u - b * v) / det;
    to[3] = (a * v - b * u) / det;
}

static void step(double y[4], double viscous, double h)
{
    static const double at[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    double k[4] = {0.0}, sum[4] = {0.0};
    for (int i = 0; i < 4; i++) {
        double z[4];
        for (int j = 0; j < 4; j++) {
            z[j] = y[j] + at[i] * h * k[j];
        }
        derive(z, viscous, k);
        for (int j = 0; j < 4; j++) {
            sum[j] += weight[i] * k[j];
        }
    }
    for (int j = 0; j < 4; j++) {
        y[j] += h / 6.0 * sum[j];
    }
}

enum { A_SECOND = 100, STEPS = 20 };

/* a film of both angles from rest, noise of 3 mrad that the file does not state */
static const char *filmed(const char *name, double a, double b, double viscous, double seconds,
                          unsigned long long seed)
{
    const char *path = in_folder(name);
    double y[4] = {a, b, 0.0, 0.0};
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "time [s],phi1 [rad],phi2 [rad]\n");
    for (int i = 0; i <= seconds * A_SECOND; i++) {
        double phi1 = y[0] + 3e-3 * gauss(&seed), phi2 = y[1] - y[0] + 3e-3 * gauss(&seed);
        fprintf(f, "%.2f,%.5f,%.5f\n", i / (double)A_SECOND, phi1, phi2);
        for (int k = 0; k < STEPS; k++) {
            step(y, viscous, 1.0 / (A_SECOND * STEPS));
        }
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

static int says(const lab_diagnosis *d, const char *word)
{
    int yes = 0;
    for (int i = 0; i < d->nfinding; i++) {
        yes |= strstr(d->finding[i], word) != NULL;
    }
    return yes;
}

static lab_diagnosis *diagnosed(const char *record, fitted *f)
{
    const char *data[] = {record, NULL};
    char model[200];
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    lab_diagnosis *d = NULL;
    def.options = &options;
    snprintf(model, sizeof model, "%s", write_file("levers.yaml", levers));
    open_fit(f, model, NULL, data);
    ck_assert_stein(lab_diagnose(&d, model, f->model, f->data, &def, err));
    printf("%d fitted, %d held out: %s\n", d->nfit, d->nheld, d->reason);
    return d;
}

static void ck_assert_viscous(const lab_diagnosis *d, double truth)
{
    ck_assert_int_eq(d->ncause, 1);
    const lab_suspect *s = &d->suspect[0];
    ck_assert_str_eq(s->candidate.effect->kind, "viscous_friction");
    ck_assert_str_eq(s->candidate.place, "lower");
    printf("  %.4g (%.4g .. %.4g), true %.4g\n", s->number[0].value, s->number[0].lo,
           s->number[0].hi, truth);
    ck_assert(s->number[0].lo < truth && truth < s->number[0].hi);
}

/* ---- chaotic motion ---- */

START_TEST(a_chaotic_record_gives_its_friction_in_windows)
{
    fitted f;
    lab_diagnosis *d = diagnosed(filmed("long.csv", 2.2, 1.7, 1.5e-5, 8.0, 5), &f);
    ck_assert(says(d, "chaotic"));
    ck_assert_int_ge(d->nfit, 8);
    ck_assert_viscous(d, 1.5e-5);
    ck_assert_double_lt(d->gain.rmse_after, 1.3);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(a_chaotic_record_without_friction_is_explained)
{
    fitted f;
    lab_diagnosis *d = diagnosed(filmed("long.csv", 2.4, 2.9, 0.0, 6.0, 6), &f);
    ck_assert(says(d, "chaotic"));
    ck_assert_int_eq(d->verdict, LAB_VERDICT_EXPLAINED);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- regular motion ---- */

START_TEST(blocks_of_one_regular_record_report_on_its_other_blocks)
{
    fitted f;
    lab_diagnosis *d = diagnosed(filmed("one.csv", 0.3, 0.25, 1.5e-5, 8.0, 7), &f);
    ck_assert(says(d, "held out is what lies from"));
    ck_assert(!says(d, "chaotic"));
    ck_assert_int_eq(d->nfit, 1);
    ck_assert_int_eq(d->nheld, 1);
    ck_assert_viscous(d, 1.5e-5);
    ck_assert_double_lt(d->gain.ratio, 0.9);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- the windows themselves ---- */

static lab_dataset *opened(const lab_model *model, const char *record)
{
    lab_data_options how = lab_data_options_default(lab_equations(model));
    lab_dataset *data = NULL;
    ck_assert_stein(lab_dataset_open(&data, &record, 1, &how, err));
    return data;
}

static const char settled[] = "# set upper.initial.position: 0.1 rad\n# set upper.mass: 90 g\n"
                              "time [s],phi1 [rad],phi2 [rad]\n"
                              "0,0.10,0.0\n0.1,0.11,0.1\n0.2,0.12,\n0.3,0.13,0.3\n"
                              "0.4,0.14,0.4\n0.5,0.15,0.5\n0.6,0.16,0.6\n0.7,0.17,0.7\n"
                              "0.8,0.18,0.8\n0.9,0.19,0.9\n1.0,0.20,1.0\n1.1,0.21,1.1\n";

START_TEST(a_window_has_its_rows_and_no_initial_state_of_its_record)
{
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, write_file("levers.yaml", levers), &options, err));
    lab_dataset *whole = opened(model, write_file("short.csv", settled)), *cut = NULL;
    const double length[] = {0.4};
    int *of = NULL;
    ck_assert_stein(data__cut_all(&cut, whole, length, 4, &of, err));
    ck_assert_int_eq(cut->n, 3);
    const lab_data *first = cut->stroke[0], *second = cut->stroke[1];
    ck_assert_int_eq(first->nset, 2);
    ck_assert_int_eq(second->nset, 1);
    ck_assert_str_eq(second->set[0].name, "upper.mass");
    ck_assert_int_eq(second->nrow, 4);
    ck_assert_double_eq_tol(second->time[0], 0.4, 1e-12);
    ck_assert_double_eq_tol(second->column[1].value[0], 0.4, 1e-12);
    ck_assert_int_eq(first->column[1].samples, 3);
    ck_assert_int_eq(second->number, 2);
    ck_assert_ptr_nonnull(strstr(second->file, "short.csv, 0.4 s to 0.7 s"));
    free(of);
    lab_dataset_close(cut);
    lab_dataset_close(whole);
    lab_close(model);
}
END_TEST

START_TEST(every_sample_is_either_fitted_or_held_out)
{
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, write_file("levers.yaml", levers), &options, err));
    lab_dataset *whole = opened(model, write_file("short.csv", settled)), *cut = NULL, *again;
    int *of = NULL, times[12] = {0};
    ck_assert_stein(data__hold_blocks(&cut, whole, &of, err));
    ck_assert_int_eq(cut->n, 2);
    ck_assert_stein(diag__read_again(cut, model, &again, err));
    for (int w = 0; w < 2; w++) {
        const lab_data *d = cut->stroke[w], *same = again->stroke[w];
        ck_assert_int_eq(d->nrow, same->nrow);
        ck_assert_str_eq(d->file, same->file);
        for (int i = 0; i < d->nrow; i++) {
            times[d->first_row + i] += d->column[0].present[i];
            ck_assert_int_eq(d->column[0].present[i], same->column[0].present[i]);
        }
    }
    for (int i = 0; i < 12; i++) {
        ck_assert_int_eq(times[i], 1);
    }
    free(of);
    lab_dataset_close(again);
    lab_dataset_close(cut);
    lab_dataset_close(whole);
    lab_close(model);
}
END_TEST

Suite *windows_suite(void)
{
    Suite *s = suite_create("windows");
    TCase *t = tcase_create("one long record");
    tcase_set_timeout(t, 600);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, a_chaotic_record_gives_its_friction_in_windows);
    tcase_add_test(t, a_chaotic_record_without_friction_is_explained);
    tcase_add_test(t, blocks_of_one_regular_record_report_on_its_other_blocks);
    tcase_add_test(t, a_window_has_its_rows_and_no_initial_state_of_its_record);
    tcase_add_test(t, every_sample_is_either_fitted_or_held_out);
    suite_add_tcase(s, t);
    return s;
}
