/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_mistakes.c - one number of a file is off by a factor: the number is named, alone, and its
 * right value is in the interval. The records begin at their own states, and no noise is stated.
 */
#include <math.h>
#include <string.h>

#include "fit_support.h"
#include "stein/diagnose.h"
#include "suites.h"

enum { RECORDS = 4 };

static const char rod[] = "mechanism: pendulum\n"
                          "bodies:\n"
                          "  rod:\n"
                          "    joint: R -y\n"
                          "    mass: 300 g\n"
                          "    centre: [0, 0, -400 mm]\n"
                          "    inertia: {yy: 4e-3 kg m^2}\n"
                          "    damping: 1.5e-3 N m s/rad\n"
                          "outputs:\n"
                          "  angle: {joint: rod, read: position}\n"
                          "simulation: {dt: 1 ms, until: 12 s}\n";
static const char sled[] = "mechanism: oscillator\n"
                           "bodies:\n"
                           "  sled:\n"
                           "    joint: T x\n"
                           "    mass: 800 g\n"
                           "    spring: {k: 120 N/m}\n"
                           "    damping: 0.4 N s/m\n"
                           "    coulomb: {T: 0.05 N, w: 3 mm/s}\n"
                           "outputs:\n"
                           "  x: {joint: sled, read: position}\n"
                           "simulation: {dt: 1 ms, until: 5 s}\n";
static const char cart[] = "mechanism: cart\n"
                           "bodies:\n"
                           "  cart:\n"
                           "    joint: T x\n"
                           "    mass: 500 g\n"
                           "    spring: {k: 40 N/m}\n"
                           "    damping: 0.3 N s/m\n"
                           "  rod:\n"
                           "    parent: cart\n"
                           "    joint: R -y\n"
                           "    mass: 200 g\n"
                           "    centre: [0, 0, -200 mm]\n"
                           "    inertia: {yy: 1e-3 kg m^2}\n"
                           "    damping: 2e-4 N m s/rad\n"
                           "outputs:\n"
                           "  x: {joint: cart, read: position}\n"
                           "  angle: {joint: rod, read: position}\n"
                           "simulation: {dt: 1 ms, until: 8 s}\n";
static const char arms[] = "mechanism: arms\n"
                           "bodies:\n"
                           "  upper:\n"
                           "    joint: R -y\n"
                           "    mass: 400 g\n"
                           "    centre: [0, 0, -150 mm]\n"
                           "    inertia: {yy: 3e-3 kg m^2}\n"
                           "    damping: 1e-3 N m s/rad\n"
                           "    points: {end: [0, 0, -300 mm]}\n"
                           "  lower:\n"
                           "    parent: upper\n"
                           "    at: upper.end\n"
                           "    joint: R -y\n"
                           "    mass: 200 g\n"
                           "    centre: [0, 0, -120 mm]\n"
                           "    inertia: {yy: 1e-3 kg m^2}\n"
                           "    damping: 5e-4 N m s/rad\n"
                           "outputs:\n"
                           "  a: {joint: upper, read: position}\n"
                           "  b: {joint: lower, read: position}\n"
                           "simulation: {dt: 1 ms, until: 6 s}\n";

static const struct {
    const char *model, *channels, *start; /* the joint whose start differs */
    double unit, until, noise;            /* of the start [SI] */
    const char *number, *wrong;           /* in the file */
    const char *kind, *place;
    double right, file;
} mistake[] = {
    {rod, "angle", "rod", 0.1, 8.0, 2e-3, "mass: 300 g", "mass: 3 kg", "mass", "rod", 0.3, 3.0},
    {rod, "angle", "rod", 0.1, 8.0, 2e-3, "yy: 4e-3", "yy: 52e-3", "inertia", "rod", 4e-3, 52e-3},
    {rod, "angle", "rod", 0.1, 8.0, 2e-3, "damping: 1.5e-3", "damping: 15e-3", "viscous_friction",
     "rod", 1.5e-3, 15e-3},
    {sled, "x", "sled", 0.01, 5.0, 3e-4, "k: 120", "k: 480", "joint_stiffness", "sled", 120.0,
     480.0},
    {sled, "x", "sled", 0.01, 5.0, 3e-4, "mass: 800 g", "mass: 80 g", "mass", "sled", 0.8, 0.08},
    {cart, "x angle", "rod", 0.08, 6.0, 5e-4, "-200 mm", "-100 mm", "centre", "rod", -0.2, -0.1},
    {arms, "a b", "upper", 0.1, 5.0, 2e-3, "-300 mm", "-150 mm", "wrong_parameter", "upper.end.z",
     -0.3, -0.15},
};
enum { MISTAKES = sizeof mistake / sizeof *mistake };

/* the text of a file with one number replaced. @return its path */
static const char *mistyped(const char *name, const char *text, const char *number,
                            const char *wrong)
{
    char changed[2000];
    const char *at = strstr(text, number);
    snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, wrong,
             at + strlen(number));
    return write_file(name, changed);
}

START_TEST(a_number_that_is_off_by_a_factor_is_named_with_its_right_value)
{
    char path[RECORDS][200], model[200], truth[200];
    const char *file[RECORDS + 1] = {NULL};
    snprintf(truth, sizeof truth, "%s", write_file("true.yaml", mistake[_i].model));
    for (int i = 0; i < RECORDS; i++) {
        char name[40], start[80];
        snprintf(name, sizeof name, "record%d.csv", i);
        snprintf(start, sizeof start, "%s.initial.position=%g", mistake[_i].start,
                 mistake[_i].unit * (i % 2 ? -1.0 : 1.0) * (2.0 + i));
        const char *const set[] = {start, NULL};
        film m = {.model = truth,
                  .truth = set,
                  .channels = mistake[_i].channels,
                  .rate = 100.0,
                  .until = mistake[_i].until,
                  .noise = mistake[_i].noise,
                  .silent = 1,
                  .seed = 700u + 10u * (unsigned)_i + (unsigned)i};
        snprintf(path[i], sizeof path[i], "%s", take(name, &m));
        file[i] = path[i];
    }
    snprintf(model, sizeof model, "%s",
             mistyped("file.yaml", mistake[_i].model, mistake[_i].number, mistake[_i].wrong));
    fitted f;
    lab_diagnosis *d = NULL;
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    def.threads = 2;
    open_fit(&f, model, NULL, file);
    ck_assert_stein(lab_diagnose(&d, model, f.model, f.data, &def, err));
    printf("%s for %s: %s\n", mistake[_i].wrong, mistake[_i].number, d->reason);
    ck_assert_int_eq(d->verdict, LAB_VERDICT_WRONG_PARAMETER);
    ck_assert_int_eq(d->ncause, 1);
    const lab_suspect *s = &d->suspect[0];
    ck_assert_str_eq(s->candidate.effect->kind, mistake[_i].kind);
    ck_assert_str_eq(s->candidate.place, mistake[_i].place);
    double change = mistake[_i].right - mistake[_i].file;
    const lab_cause_number *n = &s->number[0];
    printf("  %.4g (%.4g .. %.4g), true %.4g\n", n->value, n->lo, n->hi, change);
    ck_assert(fabs(n->value - change) < fmax(3.0 * n->sd, 0.02 * fabs(change)));
    lab_diagnosis_destroy(d);
    drop(&f);
}
END_TEST

Suite *mistakes_suite(void)
{
    Suite *suite = suite_create("mistakes");
    TCase *all = tcase_create("mistakes");
    tcase_add_unchecked_fixture(all, make_folder, remove_folder);
    tcase_set_timeout(all, 120);
    tcase_add_loop_test(all, a_number_that_is_off_by_a_factor_is_named_with_its_right_value, 0,
                        MISTAKES);
    suite_add_tcase(suite, all);
    return suite;
}
