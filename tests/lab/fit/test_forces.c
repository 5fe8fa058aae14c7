/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_forces.c - records that a measured force drives: what its noise does to a motion, and
 * readings of an encoder.
 *
 * A sled on a guide, m x'' = u - b x', the force u straight between its samples: each interval in
 * closed form without friction, in small steps with. Nothing of the core is in the data.
 */
#include "fit_support.h"
#include "fitting.h"
#include "stein/diagnose.h"
#include "suites.h"

enum { RUNS = 6, SAMPLES = 300 };
static const char sled[] = "mechanism: sled\n"
                           "bodies:\n"
                           "  sled: {joint: T x, mass: 500 g +- 1 g}\n"
                           "inputs: {push: {torque: sled}}\n"
                           "outputs: {x: {joint: sled, read: position}}\n"
                           "simulation: {dt: 1 ms, until: 3 s, integrator: dp5}\n";
static const double mass = 0.5, rate = 100.0;

typedef struct run {
    double b, force_noise, noise, step; /* [N s/m], [N], [m], of the encoder [m] */
    double push, fast;                  /* amplitude of the force [N]; speed it begins with [m/s] */
} run;

static double force(const run *w, int i, int k)
{
    double t = k / rate;
    return w->push * (sin((3.0 + i) * t + i) + 0.5 * cos((7.0 - 0.5 * i) * t));
}

/* on by one sample: Euler's midpoint in a thousand steps */
static void move(const run *w, int i, int k, double *x, double *v)
{
    enum { STEPS = 1000 };
    double h = 1.0 / rate / STEPS, u = force(w, i, k), du = (force(w, i, k + 1) - u) / STEPS;
    for (int j = 0; j < STEPS; j++) {
        double a = (u + (j + 0.5) * du - w->b * *v) / mass;
        *x += h * (*v + 0.5 * h * a);
        *v += h * a;
    }
}

static const char *film_run(const run *w, int i)
{
    static char kept[RUNS][200];
    char name[40];
    unsigned long long seed = 4100 + (unsigned long long)i;
    snprintf(name, sizeof name, "run%d.csv", i);
    snprintf(kept[i], sizeof kept[i], "%s", in_folder(name));
    FILE *f = fopen(kept[i], "w");
    ck_assert_ptr_nonnull(f);
    double all = hypot(w->noise, w->step / sqrt(12.0)), x = 0.0, v = w->fast * (i - 2.5);
    fprintf(f, "# noise x: %.6g m\n# trigger: synchronised\ntime [s],push [N],x [m]\n", all);
    for (int k = 0; k < SAMPLES; k++) {
        double seen = x + w->noise * gauss(&seed);
        seen = w->step > 0.0 ? w->step * round(seen / w->step) : seen;
        fprintf(f, "%.6g,%.9g,%.9g\n", k / rate, force(w, i, k) + w->force_noise * gauss(&seed),
                seen);
        move(w, i, k, &x, &v);
    }
    ck_assert_int_eq(fclose(f), 0);
    return kept[i];
}

typedef struct found {
    lab_model *model;
    lab_dataset *data;
    lab_diagnosis *d;
} found;

static found diagnosed(const run *w)
{
    found f;
    const char *path[RUNS];
    for (int i = 0; i < RUNS; i++) {
        path[i] = film_run(w, i);
    }
    f.model = open_text(sled, NULL, 0);
    examine(write_file("sled.yaml", sled), f.model, path, RUNS, &f.data, &f.d);
    printf("%s chi2/dof %.3f -> %.3f\n", f.d->reason, f.d->chi2_dof_before, f.d->chi2_dof_after);
    return f;
}

static void let_go(found *f)
{
    lab_diagnosis_destroy(f->d);
    lab_dataset_close(f->data);
    lab_close(f->model);
}

/* twice integrated it moves the sled by tens of noises of the sensor */
START_TEST(noise_of_a_measured_force_is_no_effect)
{
    run w = {.force_noise = 4e-3, .noise = 1e-4, .push = 1.0, .fast = 0.05};
    found f = diagnosed(&w);
    ck_assert_int_eq(f.d->verdict, LAB_VERDICT_EXPLAINED);
    ck_assert_double_lt(f.d->chi2_dof_before, 1.15);
    ck_assert_ptr_nonnull(strstr(f.d->reason, "Noise of the measured forces alone moves"));
    // nor are records that no fit has read off by it
    ck_assert_double_lt(f.d->gain.rmse_before, 1.2);
    let_go(&f);
}
END_TEST

START_TEST(an_effect_is_named_beside_noise_of_the_force)
{
    run w = {.b = 0.15, .force_noise = 4e-3, .noise = 1e-4, .push = 1.0, .fast = 0.05};
    found f = diagnosed(&w);
    ck_assert_int_eq(f.d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_str_eq(f.d->suspect[0].candidate.effect->kind, "viscous_friction");
    const lab_cause_number *n = &f.d->suspect[0].number[0];
    ck_assert_double_lt(f.d->chi2_dof_after, 1.15);
    printf("viscous friction %.4g (%.4g .. %.4g)\n", n->value, n->lo, n->hi);
    ck_assert(fabs(n->value - w.b) < 4.0 * n->sd && n->sd < 0.1 * w.b);
    let_go(&f);
}
END_TEST

/* Where a value lies between two readings an encoder shows one and the other, each half a step off.
 * These samples weigh no more than others: the sum of squares of the true motion is that of noise.
 */
START_TEST(readings_that_alternate_weigh_like_others)
{
    run w = {.noise = 2e-4, .step = 1e-3, .push = 2e-3, .fast = 1e-2};
    const char *path[RUNS + 1] = {NULL};
    for (int i = 0; i < RUNS; i++) {
        path[i] = film_run(&w, i);
    }
    fitted f;
    open_fit(&f, write_file("sled.yaml", sled), NULL, path);
    double sum = 0.0, n = 0.0;
    for (int i = 0; i < RUNS; i++) {
        fit__problem p = {.nstroke = 0};
        const char *const names[] = {"sled.mass", NULL};
        lab_fit_def def = free_these(names);
        lab_dataset one = {1, &f.data->stroke[i]};
        ck_assert_stein(fit__problem_make(&p, f.model, &one, &def, err));
        const fit__stroke *t = &p.stroke[0];
        double x = 0.0, v = w.fast * (i - 2.5);
        for (int k = 0; k < SAMPLES; k++) {
            double off = t->share[k] * (t->y[k] - x) / t->noise[0];
            sum += off * off;
            n += t->share[k] * t->share[k];
            move(&w, i, k, &x, &v);
        }
        ck_assert_int_lt(t->samples, SAMPLES); // slow motions repeat
        fit__problem_free(&p);
    }
    printf("%.0f of %d samples count, mean square %.3f\n", n, RUNS * SAMPLES, sum / n);
    ck_assert_double_eq_tol(sum / n, 1.0, 0.15);
    drop(&f);
}
END_TEST

Suite *forces_suite(void)
{
    Suite *s = suite_create("forces");
    TCase *tc = tcase_create("forces");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, noise_of_a_measured_force_is_no_effect);
    tcase_add_test(tc, an_effect_is_named_beside_noise_of_the_force);
    tcase_add_test(tc, readings_that_alternate_weigh_like_others);
    suite_add_tcase(s, tc);
    return s;
}
