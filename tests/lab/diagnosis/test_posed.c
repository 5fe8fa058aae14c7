/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_posed.c - records as people have them: an encoder's motion under measured torques; a film
 * with a wrong clock, of a mechanism with guessed masses; a stated noise that is too large.
 *
 * The joint of the encoder has its torque in closed form; the films are made by fit_support.h.
 */
#include <math.h>
#include <string.h>

#include "fit_support.h"
#include "fitting.h"
#include "stein/diagnose.h"
#include "suites.h"

static const double turn = 6.283185307179586;

static void ck_assert_said(const char *text, const char *word)
{
    ck_assert_msg(strstr(text, word) != NULL, "no \"%s\" in: %s", word, text);
}

static int says(const lab_diagnosis *d, const char *word)
{
    int yes = 0;
    for (int i = 0; i < d->nfinding; i++) {
        yes |= strstr(d->finding[i], word) != NULL;
    }
    return yes;
}

/* is it a cause, or does it fit as well? */
static const lab_suspect *in_set(const lab_diagnosis *d, const char *kind, const char *place)
{
    for (int i = 0; i < d->ncause + d->nrival; i++) {
        const lab_candidate *c = &d->suspect[i].candidate;
        if (strcmp(c->effect->kind, kind) == 0 && strcmp(c->place, place) == 0) {
            return &d->suspect[i];
        }
    }
    ck_abort_msg("%s at %s is neither a cause nor a rival: %s", kind, place, d->reason);
    return NULL;
}

static void ck_assert_number(const lab_suspect *s, double truth, double relative)
{
    const lab_cause_number *n = &s->number[0];
    printf("  %s at %s: %.4g (%.4g .. %.4g), true %.4g\n", s->candidate.effect->kind,
           s->candidate.place, n->value, n->lo, n->hi, truth);
    ck_assert_close(n->value, truth, relative, 0.0);
}

/* the diagnosis of what is open
 * @param smooth  of measured motions [Hz], 0: best values
 * @param held    [records] which ones report, NULL: as the program chooses */
static lab_diagnosis *diagnosed(const fitted *f, const char *model, double smooth,
                                const unsigned char *held)
{
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    def.smooth = smooth;
    def.held_out = held;
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, model, f->model, f->data, &def, err));
    return d;
}

/* ---- an encoder's motion, and the torque that it needed ---- */

static const char geared[] = "mechanism: geared\n"
                             "bodies:\n"
                             "  arm:\n"
                             "    joint: R -y\n"
                             "    mass: 0.6 kg\n"
                             "    centre: [0, 0, -0.25 m]\n"
                             "    inertia: {yy: 8e-3 kg m^2}\n"
                             "inputs:\n"
                             "  turned: {motion: arm, idle: hold}\n"
                             "outputs:\n"
                             "  torque: {input: turned, read: force}\n"
                             "simulation: {dt: 1 ms, until: 6 s}\n";

typedef struct encoder {
    double step, tremble; /* its steps; what it shows beside the motion, at 18 Hz [rad] */
    double viscous;       /* friction that is hidden, too [N m s/rad] */
} encoder;

static const double dry = 0.2; /* hidden [N m] */

/* 6 s at 300 Hz of a motion of two sines, and its torque with Coulomb friction and noise */
static const char *record_torque(const char *name, int which, const encoder *e)
{
    static const double m = 0.6, c = 0.25, I = 8e-3, g = 9.81, h = 1.0 / 300.0;
    const char *path = in_folder(name);
    unsigned long long seed = 77u + (unsigned)which;
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "# trigger: synchronised\ntime [s],turned [rad],torque [N m]\n");
    for (int i = 0; i < 1800; i++) {
        double t = i * h, w1 = turn * (0.4 + 0.05 * which), w2 = turn * 1.1, a1 = 0.9, a2 = 0.25;
        double q = a1 * sin(w1 * t) + a2 * sin(w2 * t),
               qd = a1 * w1 * cos(w1 * t) + a2 * w2 * cos(w2 * t),
               qdd = -a1 * w1 * w1 * sin(w1 * t) - a2 * w2 * w2 * sin(w2 * t);
        double torque =
            (I + m * c * c) * qdd + m * g * c * sin(q) + dry * tanh(qd / 0.05) + e->viscous * qd;
        double shown = q + e->tremble * sin(turn * 18.0 * t + which) + 2e-5 * gauss(&seed);
        shown = e->step > 0.0 ? e->step * round(shown / e->step) : shown;
        fprintf(f, "%.6f,%.8f,%.5f\n", t, shown, torque + 0.02 * gauss(&seed));
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

enum { TORQUES = 4 };

/* @param n  records, at most TORQUES */
static lab_diagnosis *diagnose_torque(const encoder *e, int n, double smooth, fitted *f)
{
    char path[TORQUES][200];
    const char *data[TORQUES + 1] = {NULL};
    static const unsigned char last[TORQUES] = {0, 1}; // of two
    for (int i = 0; i < n; i++) {
        char name[40];
        snprintf(name, sizeof name, "torque%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", record_torque(name, i, e));
        data[i] = path[i];
    }
    char model[200];
    snprintf(model, sizeof model, "%s", write_file("geared.yaml", geared));
    open_fit(f, model, NULL, data);
    lab_diagnosis *d = diagnosed(f, model, smooth, n == 2 ? last : NULL);
    printf("encoder with steps of %g mrad, %g mrad at 18 Hz: %s\n", 1e3 * e->step, 1e3 * e->tremble,
           d->reason);
    return d;
}

START_TEST(torques_under_an_encoders_motion_show_dry_friction)
{
    static const encoder coarse = {4e-4, 4e-4, 0.0};
    static const double bands[] = {0.0, 8.0};
    for (size_t i = 0; i < sizeof bands / sizeof *bands; i++) {
        fitted f;
        lab_diagnosis *d = diagnose_torque(&coarse, TORQUES, bands[i], &f);
        ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
        ck_assert_int_eq(d->ncause, 1);
        ck_assert_number(in_set(d, "coulomb_friction", "arm"), dry, 0.05);
        ck_assert(says(d, "turned: smoothed to half at"));
        ck_assert(d->gain.hi < 0.9);
        lab_diagnosis_destroy(d);
        drop(&f);
    }
}
END_TEST

/* bands of two records of one motion, of which the first states 8 Hz */
static void bands_of(const fitted *f, const double *smooth, int all, double band[2])
{
    lab_fit_def def = lab_fit_def_default();
    double hz[2] = {NAN, NAN};
    fit__problem p;
    def.smooth = smooth;
    def.smooth_all = all;
    ck_assert_stein(fit__problem_make_open(&p, f->model, f->data, &def, err));
    if (smooth == NULL) {
        ck_assert_stein(fit__choose_bands(&p, hz, err));
    }
    for (int i = 0; i < 2; i++) {
        band[i] = fit__signal_band(&p.stroke[i].signal[0]);
    }
    fit__problem_free(&p);
}

START_TEST(a_record_states_the_band_of_its_motion)
{
    static const encoder coarse = {4e-4, 4e-4, 0.0};
    static const double told = 5.0;
    char model[200], first[200], text[200000] = "# smooth turned: 8 Hz\n";
    snprintf(model, sizeof model, "%s", write_file("geared.yaml", geared));
    size_t n = strlen(text);
    FILE *in = fopen(record_torque("first.csv", 0, &coarse), "r");
    n += fread(text + n, 1, sizeof text - n - 1, in);
    text[n] = '\0';
    fclose(in);
    snprintf(first, sizeof first, "%s", write_file("first.csv", text));
    const char *data[] = {first, record_torque("second.csv", 1, &coarse), NULL};
    fitted f;
    double band[2];
    open_fit(&f, model, NULL, data);
    ck_assert(f.data->stroke[0]->column[0].smooth == 8.0);
    bands_of(&f, NULL, 0, band); // chosen for the other
    printf("  bands: %.4g Hz stated, %.4g Hz chosen\n", band[0], band[1]);
    ck_assert_close(band[0], 8.0, 1e-9, 0.0);
    ck_assert(fabs(band[1] - 8.0) > 0.1);
    bands_of(&f, &told, 0, band);
    ck_assert_close(band[0], 8.0, 1e-9, 0.0);
    ck_assert_close(band[1], told, 1e-9, 0.0);
    bands_of(&f, &told, 1, band);
    ck_assert_close(band[0], told, 1e-9, 0.0);
    ck_assert_close(band[1], told, 1e-9, 0.0);
    drop(&f);
}
END_TEST

START_TEST(white_noise_of_a_motion_is_smoothed_as_it_allows)
{
    static const encoder fine = {0.0, 0.0, 0.0};
    fitted f;
    lab_diagnosis *d = diagnose_torque(&fine, TORQUES, 0.0, &f);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_number(in_set(d, "coulomb_friction", "arm"), dry, 0.05);
    ck_assert(!says(d, "smoothed to half at"));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(one_long_record_shows_two_frictions)
{
    static const encoder coarse = {4e-4, 4e-4, 0.12};
    fitted f;
    lab_diagnosis *d = diagnose_torque(&coarse, 2, 0.0, &f);
    ck_assert_int_eq(d->nfit, 1);
    ck_assert_int_eq(d->ncause, 2);
    ck_assert_number(in_set(d, "coulomb_friction", "arm"), dry, 0.05);
    ck_assert_number(in_set(d, "viscous_friction", "arm"), coarse.viscous, 0.1);
    ck_assert(d->gain.lo < d->gain.ratio && d->gain.ratio < d->gain.hi); // of blocks
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- acceleration alone ---- */

/* A phone falls. Its accelerometer reads 0.12 m/s^2 too little, which no file states. Height and
 * speed are not measured. If they may be anything at the start, a spring explains the records, too.
 */
START_TEST(an_accelerometer_that_falls_shows_the_drag_of_the_air)
{
    static const char phone[] = "mechanism: phone\n"
                                "bodies:\n  phone: {joint: T z, mass: 175 g}\n"
                                "outputs:\n  az: {joint: phone, read: acceleration}\n"
                                "simulation: {dt: 1 ms, until: 0.8 s}\n";
    enum { FALLS = 6 };
    static char model[300], path[FALLS][300];
    const char *data[FALLS + 1] = {NULL};
    snprintf(model, sizeof model, "%s", write_file("phone.yaml", phone));
    for (int i = 0; i < FALLS; i++) {
        char speed[60], name[40];
        snprintf(speed, sizeof speed, "phone.initial.speed=-%g m/s", 0.1 * i);
        const char *const truth[] = {"phone.drag=8.4e-3 N s^2/m^2", "az.sensor.offset=-0.12 m/s^2",
                                     speed, NULL};
        film f = {.model = model,
                  .truth = truth,
                  .channels = "az",
                  .rate = 200.0,
                  .until = 0.8,
                  .noise = 0.02,
                  .silent = 1,
                  .seed = 71u + (unsigned)i};
        snprintf(name, sizeof name, "fall%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", take(name, &f));
        data[i] = path[i];
    }
    fitted f;
    lab_diagnosis *d = NULL;
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    open_fit(&f, model, NULL, data);
    ck_assert_stein(lab_diagnose(&d, model, f.model, f.data, &def, err));
    printf("posed: %s\n", d->reason);
    ck_assert_int_eq(d->ncause, 1);
    ck_assert_number(in_set(d, "quadratic_drag", "phone"), 8.4e-3, 0.1);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- a band in Hz ---- */

START_TEST(a_band_keeps_half_of_an_oscillation_of_its_frequency)
{
    enum { N = 4001 };
    static const double hz[] = {5.0, 12.0, 40.0};
    static double t[N], u[N];
    for (size_t k = 0; k < sizeof hz / sizeof *hz; k++) {
        fit__signal s;
        double most = 0.0;
        for (int i = 0; i < N; i++) {
            t[i] = i / 1000.0;
            u[i] = sin(turn * hz[k] * t[i]);
        }
        double decades = -6.0 * log10(turn * hz[k] / 1000.0);
        ck_assert_stein(fit__signal_through(&s, 0, t, u, N, 0.0, decades, err));
        for (int i = N / 4; i < 3 * N / 4; i++) {
            most = fmax(most, fabs(s.g[i]));
        }
        ck_assert_close(most, 0.5, 0.01, 0.0);
        ck_assert_close(fit__signal_band(&s), hz[k], 1e-9, 0.0);
        fit__signal_free(&s);
    }
}
END_TEST

/* ---- guessed masses ---- */

/* the arms of a small double pendulum; the file's values are far off */
static const char guessed[] = "mechanism: filmed\n"
                              "bodies:\n"
                              "  upper:\n"
                              "    joint: R -y\n"
                              "    mass: 100 g\n"
                              "    centre: [0, 0, -46 mm]\n"
                              "    inertia: {yy: 7e-5 kg m^2}\n"
                              "    damping: 0 N m s/rad\n"
                              "    initial: {position: 0 rad, speed: 0 rad/s}\n"
                              "    points: {elbow: [0, 0, -91.7 mm]}\n"
                              "  lower:\n"
                              "    parent: upper\n"
                              "    joint: R -y\n"
                              "    at: upper.elbow\n"
                              "    mass: 75 g\n"
                              "    centre: [0, 0, -35 mm]\n"
                              "    inertia: {yy: 3e-5 kg m^2}\n"
                              "    damping: 0 N m s/rad\n"
                              "    initial: {position: 0 rad, speed: 0 rad/s}\n"
                              "outputs:\n"
                              "  phi1: {joint: upper, read: position}\n"
                              "  phi2: {joint: lower, read: position}\n"
                              "simulation: {dt: 1 ms, until: 1 s, integrator: dp5}\n";

enum { FILMS = 6 };

/* @param base  error of the camera's time base; true time is (1 + base) t */
static lab_diagnosis *diagnose_film(double base, fitted *f)
{
    char path[FILMS][200], model[200];
    const char *data[FILMS + 1] = {NULL};
    snprintf(model, sizeof model, "%s", write_file("guessed.yaml", guessed));
    for (int i = 0; i < FILMS; i++) {
        char name[40], start[2][60];
        snprintf(name, sizeof name, "film%d.csv", i);
        snprintf(start[0], sizeof start[0], "upper.initial.position=%g rad", 0.5 + 0.15 * i);
        snprintf(start[1], sizeof start[1], "lower.initial.position=%g rad", 1.2 - 0.3 * i);
        const char *const truth[] = {"upper.inertia.yy=1.5e-4 kg m^2",
                                     "lower.inertia.yy=7e-5 kg m^2",
                                     "lower.centre.z=-25 mm",
                                     "lower.damping=2e-5 N m s/rad",
                                     start[0],
                                     start[1],
                                     NULL};
        film m = {.model = model,
                  .truth = truth,
                  .channels = "phi1 phi2",
                  .rate = 300.0,
                  .until = 0.5,
                  .noise = 1.5e-3,
                  .base = base,
                  .silent = 1,
                  .seed = 900u + (unsigned)i};
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
        data[i] = path[i];
    }
    open_fit(f, model, NULL, data);
    lab_diagnosis *d = diagnosed(f, model, 0.0, NULL);
    printf("film, time base %g: %s\n", base, d->reason);
    return d;
}

START_TEST(friction_is_found_beside_masses_that_are_guesses)
{
    fitted f;
    lab_diagnosis *d = diagnose_film(0.0, &f);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_MISSING_EFFECT);
    ck_assert_number(in_set(d, "viscous_friction", "lower"), 2e-5, 0.25);
    ck_assert_said(d->reason, "Refitted");
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

START_TEST(a_camera_that_is_a_fifth_too_slow_is_found)
{
    fitted f;
    lab_diagnosis *d = diagnose_film(-0.2, &f);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_SENSOR);
    ck_assert_number(in_set(d, "time_base", "clock"), -0.2, 0.03);
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

/* ---- a noise that is stated ---- */

static const char thrown[] = "mechanism: thrown\n"
                             "bodies:\n"
                             "  cube:\n"
                             "    joint: T z\n"
                             "    mass: 0.37 kg\n"
                             "    initial: {position: 0.3 m, speed: 0 m/s}\n"
                             "outputs:\n"
                             "  height: {joint: cube, read: position}\n"
                             "simulation: {dt: 1 ms, until: 1 s}\n";

enum { THROWS = 9 };

/* heights in mm that are read 1.8 % too small, with noise of 0.03 mm; the head states another one
 */
static lab_diagnosis *diagnose_throws(double stated, fitted *f)
{
    char path[THROWS][200], model[200];
    const char *data[THROWS + 1] = {NULL};
    unsigned long long seed = 4711;
    snprintf(model, sizeof model, "%s", write_file("thrown.yaml", thrown));
    for (int i = 0; i < THROWS; i++) {
        char name[40];
        snprintf(name, sizeof name, "throw%d.csv", i);
        snprintf(path[i], sizeof path[i], "%s", in_folder(name));
        FILE *to = fopen(path[i], "w");
        ck_assert_ptr_nonnull(to);
        fprintf(to, "# noise height: %g mm\n# trigger: synchronised\ntime [s],height [mm]\n",
                stated);
        for (int k = 0; k < 16; k++) {
            double t = k / 148.0, v = 0.8 - 0.25 * i,
                   z = 0.982 * (0.3 + v * t - 0.5 * 9.81 * t * t);
            fprintf(to, "%.6f,%.4f\n", t, 1e3 * z + 0.03 * gauss(&seed));
        }
        ck_assert_int_eq(fclose(to), 0);
        data[i] = path[i];
    }
    open_fit(f, model, NULL, data);
    lab_diagnosis *d = diagnosed(f, model, 0.0, NULL);
    printf("noise stated as %g mm for 0.03: %s\n", stated, d->reason);
    return d;
}

START_TEST(a_verdict_does_not_hang_on_the_noise_that_is_stated)
{
    static const double stated[] = {0.02, 0.03, 0.1, 0.3};
    for (size_t i = 0; i < sizeof stated / sizeof *stated; i++) {
        fitted f;
        lab_diagnosis *d = diagnose_throws(stated[i], &f);
        ck_assert_int_eq(d->ncause, 1);
        ck_assert_number(in_set(d, "sensor_gain", "height"), -0.018, 0.1);
        ck_assert_number(in_set(d, "time_base", "clock"), -0.009, 0.1);
        in_set(d, "preload", "cube"); // gravity
        lab_diagnosis_destroy(d);
        drop(&f);
    }
}
END_TEST

/* ---- instruments and commands ---- */

static const char rod[] = "models/pendulum.yaml";

/* 4 s at 100 Hz of an encoder with steps of 3 mrad, and of a torque that a relay switches
 * @param swing  its size [rad]; 0: it turns by one step */
static const char *record_steps(const char *name, double swing)
{
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "time [s],angle [rad],push [N m]\n");
    for (int i = 0; i < 400; i++) {
        double t = i / 100.0,
               q = 3e-3 * (swing > 0.0 ? round(swing * cos(6.4 * t) / 3e-3) : i > 200);
        fprintf(f, "%.2f,%.6f,%g\n", t, q, i / 70 % 2 ? 0.02 : -0.02);
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

START_TEST(an_encoder_that_stands_still_has_the_noise_of_its_steps)
{
    char path[2][200];
    const char *const data[] = {path[0], path[1], NULL}, *const names[] = {"rod.damping", NULL};
    snprintf(path[0], sizeof path[0], "%s", record_steps("turns.csv", 0.5));
    snprintf(path[1], sizeof path[1], "%s", record_steps("stands.csv", 0.0));
    fitted f;
    open_fit(&f, rod, NULL, data);
    fit__problem p;
    lab_fit_def def = free_these(names);
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    for (int s = 0; s < 2; s++) {
        ck_assert_close(p.stroke[s].noise[0], 3e-3 / sqrt(12.0), 0.2, 0.0);
    }
    ck_assert_int_eq(p.stroke[1].samples, 2); // two readings, 200 times
    fit__problem_free(&p);
    drop(&f);
}
END_TEST

START_TEST(a_switched_command_has_no_steps_and_is_not_cut_off)
{
    const char *const data[] = {record_steps("turns.csv", 0.5), NULL};
    fitted f;
    open_fit(&f, rod, NULL, data);
    lab_audit *a = NULL;
    ck_assert_stein(lab_audit_create(&a, f.data->stroke[0], err));
    int k = strcmp(f.data->stroke[0]->column[0].name, "push") != 0;
    ck_assert_str_eq(f.data->stroke[0]->column[k].name, "push");
    ck_assert_close(a->channel[!k].step, 3e-3, 0.02, 0.0);
    ck_assert_double_eq(a->channel[k].step, 0.0);
    ck_assert_double_lt(a->channel[k].noise, 1e-6);
    ck_assert_int_eq(a->channel[k].saturated_low + a->channel[k].saturated_high, 0);
    lab_audit_destroy(a);
    drop(&f);
}
END_TEST

Suite *posed_suite(void)
{
    Suite *s = suite_create("posed");
    TCase *t = tcase_create("records as people have them");
    tcase_set_timeout(t, 900);
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, torques_under_an_encoders_motion_show_dry_friction);
    tcase_add_test(t, a_record_states_the_band_of_its_motion);
    tcase_add_test(t, white_noise_of_a_motion_is_smoothed_as_it_allows);
    tcase_add_test(t, one_long_record_shows_two_frictions);
    tcase_add_test(t, an_accelerometer_that_falls_shows_the_drag_of_the_air);
    tcase_add_test(t, a_band_keeps_half_of_an_oscillation_of_its_frequency);
    tcase_add_test(t, friction_is_found_beside_masses_that_are_guesses);
    tcase_add_test(t, a_camera_that_is_a_fifth_too_slow_is_found);
    tcase_add_test(t, a_verdict_does_not_hang_on_the_noise_that_is_stated);
    tcase_add_test(t, an_encoder_that_stands_still_has_the_noise_of_its_steps);
    tcase_add_test(t, a_switched_command_has_no_steps_and_is_not_cut_off);
    suite_add_tcase(s, t);
    return s;
}
