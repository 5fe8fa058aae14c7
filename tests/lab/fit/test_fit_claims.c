/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_fit_claims.c - derivatives, the method, results.
 */
#include <gsl/gsl_multifit_nlinear.h>

#include "fit_support.h"
#include "fitting.h"

/* ---- derivatives ---- */

static const char *const touched[] = {
    "string.height", "key.inertia.yy",   "hammer.mass",     "hammer.centre.x", "pawl.mass",
    "pawl.spring.k", "notch.friction.A", "string.normal.c", "dip.normal.c",    NULL};

static const char action[] = "models/stein1788.yaml";

/* one column by differences of order six */
static void reference(const fit__problem *p, fit__bench *b, int k, double h, double *x,
                      double *room, double *column)
{
    static const double weight[] = {-1.0 / 60.0, 9.0 / 60.0,  -45.0 / 60.0, 0.0,
                                    45.0 / 60.0, -9.0 / 60.0, 1.0 / 60.0};
    memset(column, 0, sizeof *column * (size_t)p->rows);
    for (int a = -3; a <= 3; a++) {
        x[k] = a * h;
        ck_assert_stein(fit__simulate(p, b, 0, x, room, err));
        fit__weigh(&p->stroke[0], room);
        for (int i = 0; i < p->rows; i++) {
            column[i] += weight[a + 3] * room[i] / h;
        }
    }
    x[k] = 0.0;
}

/* distance of two columns over the length of the second one */
static double distance(const double *a, const double *b, int rows)
{
    double sum = 0.0, off = 0.0;
    for (int i = 0; i < rows; i++) {
        sum += b[i] * b[i];
        off += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return sqrt(off / sum);
}

/* the derivatives that intervals are made of, at the steps the end of a fit has */
static void final_derivatives(fit__problem *p, const double *x, double *J)
{
    double *r = calloc((size_t)p->rows, sizeof *r), error;
    int failed;
    p->central = 1;
    p->tolerance = 1e-11;
    ck_assert_stein(fit__residuals(p, x, r, &failed, err));
    for (int pass = 0; pass < 3; pass++) {
        ck_assert_stein(fit__sensitivities(p, x, r, J, err));
        fit__choose_steps(p, J);
    }
    ck_assert_stein(fit__fine_sensitivities(p, x, r, J, &error, err));
    ck_assert(error < 1e-3);
    free(r);
}

START_TEST(derivatives_of_a_stroke_are_right_to_1e5_across_its_events)
{
    film m = {.model = action,
              .channels = "string_distance key_dip",
              .rate = 4000.0,
              .from = -0.005,
              .until = 0.12,
              .noise = 12e-6,
              .unsynchronised = 1,
              .seed = 1};
    const char *data[] = {take("stroke.csv", &m), NULL};
    fitted f;
    fit__problem p;
    fit__bench bench;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(touched);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    size_t rows = (size_t)p.rows;
    double *x = calloc((size_t)p.nu + 2 * rows, sizeof *x), *room = x + p.nu, *column = room + rows;
    double *J = calloc(fit__columns(&p), sizeof *J), worst = 0.0;
    final_derivatives(&p, x, J);
    p.tolerance = 1e-14;
    ck_assert_stein(fit__bench_make(&bench, &p, err));
    for (int k = 0; k < p.np + 1; k++) { // and the trigger
        reference(&p, &bench, k, 1.3 * p.step[k], x, room, column);
        double off = distance(J + fit__column(&p, 0, k), column, p.rows);
        ck_assert_msg(off <= 1e-5, "%s: %.2g", k < p.np ? touched[k] : "trigger", off);
        worst = fmax(worst, off);
    }
    printf("derivatives: %d of a stroke within %.1e of differences of order six\n", p.np + 1,
           worst);
    fit__bench_free(&bench);
    fit__problem_free(&p);
    free(x);
    free(J);
    drop(&f);
}
END_TEST

START_TEST(derivatives_that_are_known_stay_and_those_of_an_end_are_current)
{
    static const char *const names[] = {"pawl.spring.k", "hammer.friction.A", NULL};
    film m = {.model = action,
              .channels = "string_distance key_dip",
              .rate = 4000.0,
              .until = 0.12,
              .noise = 12e-6,
              .seed = 1};
    const char *data[] = {take("stroke.csv", &m), NULL};
    fitted f;
    fit__problem p;
    int failed;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    size_t rows = (size_t)p.rows, columns = fit__columns(&p);
    double *x = calloc((size_t)p.nu + rows + 2 * columns, sizeof *x), *r = x + p.nu, *J = r + rows,
           *again = J + columns;
    unsigned char *known = calloc((size_t)p.nu, 1);
    fit__end e = {.x = x, .r = r, .J = J};
    p.tolerance = 1e-10;
    x[0] = 0.5;
    ck_assert_stein(fit__descend(&p, &e, 0, 0.3, 6, err));
    ck_assert(e.ended && e.current);
    ck_assert_stein(fit__residuals(&p, x, r, &failed, err));
    ck_assert_stein(fit__sensitivities(&p, x, r, again, err));
    for (int k = 0; k < p.np; k++) {
        size_t at = fit__column(&p, 0, k);
        double off = distance(J + at, again + at, p.rows);
        printf("%s: derivative at the end of a fit off by %.1e\n", names[k], off);
        ck_assert_double_lt(off, 0.05);
    }
    memcpy(J, again, sizeof *J * columns);
    for (size_t i = 0; i < 2 * rows; i++) {
        again[i] = 7.0; // two columns, of which one is known
    }
    known[0] = 1;
    ck_assert_stein(fit__more_sensitivities(&p, x, r, known, again, err));
    for (size_t i = 0; i < rows; i++) {
        ck_assert(!(fabs(again[i] - 7.0) > 0.0));
    }
    ck_assert_mem_eq(again + rows, J + rows, sizeof *J * (columns - rows));
    fit__problem_free(&p);
    free(known);
    free(x);
    drop(&f);
}
END_TEST

START_TEST(controlled_steps_agree_with_short_fixed_ones)
{
    film m = {.model = action,
              .channels = "string_distance",
              .rate = 4000.0,
              .until = 0.12,
              .noise = 1e-5,
              .seed = 1};
    const char *data[] = {take("stroke.csv", &m), NULL};
    static const char *const names[] = {"hammer.mass", NULL};
    fitted f;
    fit__problem p;
    fit__bench bench;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    ck_assert_stein(fit__bench_make(&bench, &p, err));
    stein_sim_def fixed = lab_def(f.model);
    fixed.integrator = STEIN_DP5;
    fixed.dt = 1e-6;
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(f.model, &fixed, &sim, err));
    double x[16] = {0.0}, worst = 0.0, *y = calloc((size_t)p.rows, sizeof *y);
    ck_assert_stein(fit__simulate(&p, &bench, 0, x, y, err));
    for (int i = 0; i < p.stroke[0].n; i++) {
        double there = 0.0;
        ck_assert_stein(stein_run(sim, p.stroke[0].data->time[i], err));
        ck_assert_stein(stein_read_name(sim, "string_distance", &there, err));
        worst = fmax(worst, fabs(there - y[i]));
    }
    printf("controlled steps: %.1e m from fixed ones of 1 us\n", worst);
    ck_assert(worst < 1e-9);
    free(y);
    stein_sim_destroy(sim);
    fit__bench_free(&bench);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* ---- the method ---- */

typedef struct rival {
    fit__problem *p;
    double *r;
} rival;

static int rival_f(const gsl_vector *x, void *params, gsl_vector *f)
{
    rival *v = params;
    int failed, n = v->p->nu;
    size_t rows = fit__offset(v->p, v->p->nstroke);
    ck_assert_stein(fit__residuals(v->p, x->data, v->r, &failed, err));
    for (size_t i = 0; i < rows; i++) {
        gsl_vector_set(f, i, v->r[i]);
    }
    for (int k = 0; k < n; k++) {
        gsl_vector_set(f, rows + (size_t)k,
                       v->p->unknown[k].prior ? gsl_vector_get(x, (size_t)k) : 0.0);
    }
    return GSL_SUCCESS;
}

START_TEST(the_minimum_is_that_of_gsl)
{
    static const char *const names[] = {"rod.pendulum.frequency", "rod.damping", "rod.mass", NULL};
    static const char *const truth[] = {"rod.damping=1.9e-4 N m s/rad",
                                        "rod.initial.position=0.5 rad", NULL};
    film m = {.model = "models/pendulum.yaml",
              .truth = truth,
              .channels = "angle tip_x",
              .rate = 23.0,
              .until = 6.0,
              .noise = 1e-3,
              .seed = 12};
    const char *data[] = {take("swing.csv", &m), NULL};
    fitted f;
    fit__problem p;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    p.tolerance = 1e-12;
    size_t rows = fit__offset(&p, p.nstroke), n = rows + (size_t)p.nu;
    rival v = {&p, calloc(rows, sizeof *v.r)};
    gsl_multifit_nlinear_fdf fdf = {.f = rival_f, .n = n, .p = (size_t)p.nu, .params = &v};
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    how.fdtype = GSL_MULTIFIT_NLINEAR_CTRDIFF;
    how.h_df = 1e-4;
    gsl_multifit_nlinear_workspace *w =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &how, n, (size_t)p.nu);
    gsl_vector *x = gsl_vector_alloc((size_t)p.nu);
    int info;
    gsl_vector_set_all(x, 1e-3);
    gsl_multifit_nlinear_init(x, &fdf, w);
    gsl_multifit_nlinear_driver(200, 1e-12, 1e-12, 0.0, NULL, NULL, &info, w);
    for (int k = 0; k < p.np; k++) {
        double theirs = fit__value(&p.unknown[k], gsl_vector_get(w->x, (size_t)k));
        ck_assert_close(f.fit->value[k].value, theirs, 0.0, 0.02 * f.fit->value[k].sd);
    }
    gsl_multifit_nlinear_free(w);
    gsl_vector_free(x);
    free(v.r);
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

/* A carriage driven along a sine: 1379 N at the most, 1229 N at the first sample. 20 nm of noise
 * are 4.3 N, unsmoothed. The true motion is `gain` times the recorded one. */
static const char *drive(const char *name, double gain, unsigned long long seed)
{
    const char *path = in_folder(name);
    FILE *to = fopen(path, "w");
    ck_assert_ptr_nonnull(to);
    fprintf(to, "# noise slide_force: 1\n# noise slide_motion: 20e-9\n"
                "time [s],slide_motion [m],slide_force [N]\n");
    for (int i = 0; i <= 1000; i++) {
        double t = 1e-3 * i, w = 4.0 * acos(-1.0), x = 0.1 * sin(w * t + 1.1);
        double force = -87.3 * gain * w * w * x;
        fprintf(to, "%.17g,%.17g,%.17g\n", 0.5 + t, x + 20e-9 * gauss(&seed),
                force + 0.3 * gauss(&seed));
    }
    ck_assert_int_eq(fclose(to), 0);
    return path;
}

static const char *const slide_mass[] = {"slide.mass", NULL};

START_TEST(a_joint_that_is_driven_from_the_first_sample_on_may_be_moving)
{
    char path[200];
    fitted f;
    snprintf(path, sizeof path, "%s", drive("moving.csv", 1.0, 7));
    const char *data[] = {path, NULL};
    open_fit(&f, "models/emps.yaml", NULL, data);
    lab_fit_def def = free_these(slide_mass);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_close(f.fit->value[0].value, 87.3, 3e-4, 0.0);
    printf("driven joint: %.2g N of 1379 N are left\n", f.fit->residual[0].rms);
    ck_assert(f.fit->residual[0].rms < 2.0);
    drop(&f);
}
END_TEST

START_TEST(motions_that_scatter_are_no_misfit)
{
    static const double gain[] = {1.004, 0.997, 0.998, 1.002};
    char path[4][200], name[32];
    fitted f;
    for (int i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "drive%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", drive(name, gain[i], 20 + (unsigned long long)i));
    }
    const char *data[] = {path[0], path[1], path[2], path[3], NULL};
    open_fit(&f, "models/emps.yaml", NULL, data);
    lab_fit_def def = free_these(slide_mass);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_msg(f.fit->chi2_dof < 2.0, "%g", f.fit->chi2_dof); // 8 if they did not
    ck_assert_found(f.fit, "slide.mass", 87.3, 3.0);
    drop(&f);
}
END_TEST

/* ---- results ---- */

START_TEST(a_fit_goes_into_the_parameters_and_nothing_else_does)
{
    static const char *const names[] = {"rod.damping", "rod.mass", NULL};
    static const char *const truth[] = {"rod.damping=2.3e-4 N m s/rad", NULL};
    film m = {.model = "models/pendulum.yaml",
              .truth = truth,
              .channels = "angle",
              .rate = 20.0,
              .until = 4.0,
              .noise = 1e-3,
              .seed = 3};
    const char *data[] = {take("swing.csv", &m), NULL};
    fitted f;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    def.starts = 1;
    def.initial = 0;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    const stein_model *equations = lab_equations(f.model);
    double *p = calloc((size_t)equations->np, sizeof *p);
    memcpy(p, lab_parameters(f.model), sizeof *p * (size_t)equations->np);
    lab_fit_apply(f.fit, p);
    for (int i = 0; i < equations->np; i++) {
        double expected = lab_parameters(f.model)[i];
        for (int k = 0; k < f.fit->nvalue; k++) {
            expected = f.fit->value[k].param == i ? f.fit->value[k].value : expected;
        }
        ck_assert_msg(p[i] == expected, "%s: %g", equations->params[i].name, p[i]);
    }
    ck_assert(p[stein_find_param(equations, "rod.damping")] > 1.5e-4);
    free(p);
    drop(&f);
}
END_TEST

static char *read_text(const char *path)
{
    FILE *f = fopen(path, "r");
    char *text = calloc(1, 40000);
    ck_assert_ptr_nonnull(f);
    ck_assert(fread(text, 1, 39999, f) > 0);
    fclose(f);
    return text;
}

static const char annotated[] = "# a swing\xC3\xA9, weighed twice\n"
                                "mechanism: swing\n"
                                "bodies:\n"
                                "  rod:                # the rod\n"
                                "    joint: R -y\n"
                                "    mass: 213 g +- 1 g # kitchen scale \xC2\xB1 1 g\n"
                                "    centre: [0, 0, -174 mm]\n"
                                "    inertia: {yy: '3.1e3 g mm^2'} # quoted\n"
                                "    initial: {position: 0.5 rad}\n"
                                "outputs: {angle: {joint: rod, read: position}} # one\n"
                                "simulation: {dt: 1 ms, until: 6 s}\n";

START_TEST(the_file_stays_but_for_its_numbers)
{
    static const char *const names[] = {"rod.inertia.yy", "rod.damping", "rod.coulomb.T",
                                        "angle.sensor.gain", NULL};
    static const char *const set[] = {"rod.mass=214 g", "rod.coulomb.w=0.02 rad/s", NULL};
    static const char *const truth[] = {"rod.mass=214 g", "rod.damping=2e-3 N m s/rad", NULL};
    static const char *const lines[] = {"\n# a swing\xC3\xA9, weighed twice\nmechanism: swing\n",
                                        "  rod:                # the rod\n    damping: 0.00",
                                        "    joint: R -y\n    mass: 214 g +- 1 g",
                                        " # kitchen scale \xC2\xB1 1 g\n",
                                        "inertia: {yy: '2",
                                        " g mm^2'} # quoted\n",
                                        "    coulomb: {T: ",
                                        ", w: 0.02 rad/s, asymmetry: 0}\n",
                                        "{angle: {sensor: {gain: ",
                                        "}, joint: rod, read: position}} # one\n",
                                        "# Fitted by stein fit"};
    char file[200], out[200];
    snprintf(file, sizeof file, "%s", write_file("swing.yaml", annotated));
    snprintf(out, sizeof out, "%s", in_folder("fitted.yaml"));
    film m = {.model = file,
              .truth = truth,
              .channels = "angle",
              .rate = 40.0,
              .until = 5.0,
              .noise = 1e-3,
              .seed = 6};
    const char *data[] = {take("swing.csv", &m), NULL};
    fitted f;
    open_fit(&f, file, set, data);
    lab_fit_def def = free_these(names);
    def.starts = 1;
    def.initial = 0;
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    lab_options options = cache_here(NULL);
    options.set = set;
    options.nset = 2;
    ck_assert_stein(lab_fit_write(out, f.fit, file, &options, err));
    char *text = read_text(out);
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        ck_assert_msg(strstr(text, lines[i]) != NULL, "no \"%s\" in\n%s", lines[i], text);
    }
    lab_model *again = NULL;
    options.nset = 0;
    ck_assert_stein(lab_open(&again, out, &options, err));
    for (int k = 0; k < f.fit->nvalue; k++) {
        int i = stein_find_param(lab_equations(again), names[k]);
        ck_assert_close(lab_parameters(again)[i], f.fit->value[k].value, 1e-9, 0.0);
        ck_assert_close(lab_equations(again)->params[i].tolerance, f.fit->value[k].sd, 0.01, 0.0);
    }
    ck_assert_str_eq(lab_equations(again)->equations, lab_equations(f.model)->equations);
    free(text);
    lab_close(again);
    drop(&f);
}
END_TEST

/* Noise makes the best damping of a pendulum without any negative: a trace of it stays. A length
 * may become negative. */
START_TEST(what_a_cause_takes_from_a_damping_leaves_it_positive)
{
    static const char *const truth[] = {"rod.damping=0", NULL};
    film m = {.model = "models/pendulum.yaml",
              .truth = truth,
              .channels = "angle",
              .rate = 40.0,
              .until = 5.0,
              .noise = 5e-3,
              .seed = 2};
    const char *data[] = {take("swing.csv", &m), NULL};
    fitted f;
    fit__problem p;
    int failed;
    open_fit(&f, m.model, NULL, data);
    const lab_candidate c[2] = {candidate(f.model, "viscous_friction", "rod"),
                                candidate(f.model, "centre", "rod")};
    const double damping = lab_parameters(f.model)[c[0].param[0]];
    lab_fit_def def = lab_fit_def_default();
    ck_assert_stein(fit__problem_make_with(&p, f.model, f.data, &def, c, 1, err));
    double *x = calloc((size_t)p.nu + (size_t)p.rows + fit__columns(&p), sizeof *x);
    fit__end e = {.x = x, .r = x + p.nu, .J = x + p.nu + p.rows};
    ck_assert_stein(fit__residuals(&p, x, e.r, &failed, err));
    ck_assert_stein(fit__descend(&p, &e, 0, 1e-3, 10, err));
    double left = damping + c[0].limit * x[p.first_accepted];
    ck_assert(e.ended);
    ck_assert_msg(left > 0.0 && left < 2e-6 * damping, "%g of %g are left", left, damping);
    fit__problem_free(&p);
    free(x);
    ck_assert_stein(fit__problem_make_with(&p, f.model, f.data, &def, c + 1, 1, err));
    ck_assert(isinf(p.unknown[p.first_accepted].least));
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

Suite *fit_claims_suite(void)
{
    Suite *suite = suite_create("fit_claims");
    TCase *all = tcase_create("claims");
    tcase_add_checked_fixture(all, make_folder, remove_folder);
    tcase_set_timeout(all, 900);
    tcase_add_test(all, derivatives_of_a_stroke_are_right_to_1e5_across_its_events);
    tcase_add_test(all, derivatives_that_are_known_stay_and_those_of_an_end_are_current);
    tcase_add_test(all, controlled_steps_agree_with_short_fixed_ones);
    tcase_add_test(all, the_minimum_is_that_of_gsl);
    tcase_add_test(all, a_joint_that_is_driven_from_the_first_sample_on_may_be_moving);
    tcase_add_test(all, motions_that_scatter_are_no_misfit);
    tcase_add_test(all, a_fit_goes_into_the_parameters_and_nothing_else_does);
    tcase_add_test(all, the_file_stays_but_for_its_numbers);
    tcase_add_test(all, what_a_cause_takes_from_a_damping_leaves_it_positive);
    suite_add_tcase(suite, all);
    return suite;
}
