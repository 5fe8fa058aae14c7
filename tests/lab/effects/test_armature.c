/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_armature.c - the rotor behind a gear that a file has forgotten: its places, its aliases, and
 * its diagnosis. The records come from equations written here.
 */
#include <math.h>

#include "fit_support.h"

Suite *armature_suite(void);

/* joint 1 on the frame, joint 2 on the first link, as in `two` below; q2 against the first link */
static const double m1 = 0.5, c1 = 0.12, I1 = 3e-3, L = 0.25, m2 = 0.3, c2 = 0.1, I2 = 1.5e-3;
static const double b1 = 0.03, b2 = 0.01, g = 9.81;
static const char two[] =
    "mechanism: two\n"
    "bodies:\n"
    "  upper: {joint: R -y, mass: 0.5 kg +- 1 %, centre: [120 mm +- 1 mm, 0, 0],\n"
    "          inertia: {yy: 3e-3 kg m^2 +- 5 %}, damping: 0.03 N m s/rad +- 5 %,\n"
    "          points: {end: [250 mm, 0, 0]}}\n"
    "  fore: {parent: upper, at: upper.end, joint: R -y, mass: 0.3 kg +- 1 %,\n"
    "         centre: [100 mm +- 1 mm, 0, 0], inertia: {yy: 1.5e-3 kg m^2 +- 5 %},\n"
    "         damping: 0.01 N m s/rad +- 5 %}\n"
    "inputs: {torque1: {torque: upper}, torque2: {torque: fore}}\n"
    "outputs: {first: {joint: upper, read: position}, second: {body: fore, read: angle}}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";
static const char one[] =
    "mechanism: one\n"
    "bodies:\n"
    "  upper: {joint: R -y, mass: 0.5 kg +- 1 %, centre: [120 mm +- 1 mm, 0, 0],\n"
    "          inertia: {yy: 3e-3 kg m^2 +- 5 %}, damping: 0.03 N m s/rad +- 5 %}\n"
    "inputs: {torque1: {torque: upper}}\n"
    "outputs: {first: {joint: upper, read: position}}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";

/* one record: rotors of a1 and a2; links: 1 or 2 */
typedef struct truth {
    int links, k;
    double a1, a2;
} truth;

static void torques(const truth *r, double t, double tau[2])
{
    static const double pi = 3.14159265358979323846;
    tau[0] = (1.5 + 0.1 * r->k) * sin(2.0 * pi * (0.5 + 0.1 * r->k) * t);
    tau[1] = 0.4 * sin(2.0 * pi * (1.1 + 0.1 * r->k) * t + 0.5 * r->k);
}

/* y: q1 q2 w1 w2. Lagrange's equations of the double pendulum, level at q = 0 */
static void slope(const truth *r, double t, const double y[4], double to[4])
{
    double tau[2], s = m2 * L * c2 * sin(y[1]), cc = m2 * L * c2 * cos(y[1]);
    torques(r, t, tau);
    to[0] = y[2];
    to[1] = y[3];
    if (r->links == 1) {
        to[2] = (tau[0] - b1 * y[2] - m1 * g * c1 * cos(y[0])) / (I1 + m1 * c1 * c1 + r->a1);
        to[3] = 0.0;
        return;
    }
    double M22 = I2 + m2 * c2 * c2, M12 = M22 + cc;
    double M11 = I1 + m1 * c1 * c1 + m2 * L * L + M22 + 2.0 * cc + r->a1;
    double G2 = m2 * g * c2 * cos(y[0] + y[1]), G1 = (m1 * c1 + m2 * L) * g * cos(y[0]) + G2;
    double r1 = tau[0] - b1 * y[2] + s * (2.0 * y[2] * y[3] + y[3] * y[3]) - G1;
    double r2 = tau[1] - b2 * y[3] - s * y[2] * y[2] - G2;
    M22 += r->a2;
    double D = M11 * M22 - M12 * M12;
    to[2] = (M22 * r1 - M12 * r2) / D;
    to[3] = (M11 * r2 - M12 * r1) / D;
}

static void runge_kutta(const truth *r, double t, double h, double y[4])
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double k[4] = {0.0}, x[4], sum[4] = {0.0};
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < 4; i++) {
            x[i] = y[i] + at[stage] * h * k[i];
        }
        slope(r, t + at[stage] * h, x, k);
        for (int i = 0; i < 4; i++) {
            sum[i] += h / 6.0 * weight[stage] * k[i];
        }
    }
    for (int i = 0; i < 4; i++) {
        y[i] += sum[i];
    }
}

static const char *record_of(const truth *r, char path[100])
{
    enum { ROWS = 400, STEPS = 5 };
    char name[20];
    double y[4] = {-1.4 + 0.1 * r->k, 0.3 - 0.1 * r->k, 0.0, 0.0}, tau[2];
    unsigned long long seed = 77u + (unsigned)r->k;
    snprintf(name, sizeof name, "r%d.csv", r->k);
    snprintf(path, 100, "%s", in_folder(name));
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, r->links == 2 ? "# noise first: 0.5 mrad\n# noise second: 0.5 mrad\n"
                               "time [s],torque1 [N m],first [rad],torque2 [N m],second [rad]\n"
                             : "# noise first: 0.5 mrad\ntime [s],torque1 [N m],first [rad]\n");
    for (int i = 0; i <= ROWS; i++) {
        torques(r, 1e-3 * i, tau);
        fprintf(f, "%.17g,%.17g,%.17g", 1e-3 * i, tau[0], y[0] + 5e-4 * gauss(&seed));
        if (r->links == 2) {
            fprintf(f, ",%.17g,%.17g", tau[1], y[0] + y[1] + 5e-4 * gauss(&seed));
        }
        fprintf(f, "\n");
        for (int n = 0; n < STEPS; n++) {
            runge_kutta(r, 1e-3 * i + 2e-4 * n, 2e-4, y);
        }
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

/* a diagnosis of six records */
static void find_out(const char *text, truth r, lab_model **model, lab_dataset **data,
                     lab_diagnosis **d)
{
    char path[6][100], file[300];
    const char *list[6];
    for (r.k = 0; r.k < 6; r.k++) {
        list[r.k] = record_of(&r, path[r.k]);
    }
    lab_options options = cache_here(NULL);
    snprintf(file, sizeof file, "%s", write_file("arm.yaml", text));
    ck_assert_stein(lab_open(model, file, &options, err));
    examine(file, *model, list, 6, data, d);
}

static void let_go(lab_model *model, lab_dataset *data, lab_diagnosis *d)
{
    lab_diagnosis_destroy(d);
    lab_dataset_close(data);
    lab_close(model);
}

/* the rotor alone is named, with its size */
static const lab_suspect *named(const lab_diagnosis *d, const char *place, double size)
{
    ck_assert_msg(d->ncause == 1, "%d causes: %s", d->ncause, d->reason);
    const lab_suspect *s = &d->suspect[0];
    ck_assert_str_eq(s->candidate.effect->kind, "armature");
    ck_assert_str_eq(s->candidate.place, place);
    ck_assert_msg(fabs(s->amount - size) < 0.06 * size, "%.6g for %.6g", s->amount, size);
    return s;
}

START_TEST(the_rotor_of_a_geared_arm_is_found_with_the_inertia_as_its_alias)
{
    lab_model *model = NULL;
    lab_dataset *data = NULL;
    lab_diagnosis *d = NULL;
    find_out(one, (truth){.links = 1, .a1 = 0.008}, &model, &data, &d);
    const lab_suspect *s = named(d, "upper", 0.008);
    ck_assert_str_eq(s->candidate.alias, "upper.inertia.yy");
    ck_assert_msg(strstr(d->reason, "the same as a change of upper.inertia.yy") != NULL, "%s",
                  d->reason);
    let_go(model, data, d);
}
END_TEST

/* an inertia of the second link would turn with the first one */
START_TEST(the_rotor_of_the_second_joint_is_separated_from_the_inertia_of_its_link)
{
    lab_model *model = NULL;
    lab_dataset *data = NULL;
    lab_diagnosis *d = NULL;
    find_out(two, (truth){.links = 2, .a2 = 0.004}, &model, &data, &d);
    const lab_suspect *s = named(d, "fore", 0.004);
    ck_assert_str_eq(s->candidate.alias, "");
    ck_assert_int_eq(d->nrival, 0);
    let_go(model, data, d);
}
END_TEST

/* open with a rotor: the parameter is there, and 0 is the mechanism without it */
START_TEST(a_mechanism_gets_a_rotor_where_an_input_drives_a_joint)
{
    lab_options options = cache_here(NULL);
    lab_model *model = open_text(two, NULL, 0), *with = NULL;
    lab_candidate c = candidate(model, "armature", "upper");
    ck_assert_str_eq(c.alias, "upper.inertia.yy");
    ck_assert_ptr_nonnull(strstr(candidate(model, "inertia", "upper").alias, "upper.armature"));
    c = candidate(model, "armature", "fore");
    ck_assert_str_eq(c.unit, "kg m^2");
    ck_assert_close(c.limit, I2 + m2 * c2 * c2, 1e-9, 0.0); // M_22
    ck_assert_int_eq(lab_candidate_is_signed(&c), 0);
    ck_assert_stein(lab_candidate_open(&c, &with, in_folder("model.yaml"), &options, err));
    ck_assert_int_eq(c.nparam, 1);
    ck_assert_str_eq(lab_equations(with)->params[c.param[0]].name, "fore.armature");
    lab_close(with);
    lab_close(model);
}
END_TEST

START_TEST(there_is_no_rotor_without_a_drive_and_none_beside_the_files_own)
{
    static const char *const text[] = {
        "mechanism: free\nbodies: {a: {joint: R y, mass: 1 kg, centre: [0.1, 0, 0]}}\n"
        "outputs: {q: {joint: a, read: position}}\n",
        "mechanism: own\nbodies: {a: {joint: R y, mass: 1 kg, centre: [0.1, 0, 0], armature: "
        "0.1}}\ninputs: {u: {torque: a}}\noutputs: {q: {joint: a, read: position}}\n"};
    for (int i = 0; i < 2; i++) {
        lab_model *model = open_text(text[i], NULL, 0);
        lab_candidate *list = NULL;
        int n = 0, rotors = 0, numbers = 0;
        ck_assert_stein(lab_candidates(&list, &n, model, err));
        for (int k = 0; k < n; k++) {
            rotors += strcmp(list[k].effect->kind, "armature") == 0;
            numbers += strcmp(list[k].place, "a.armature") == 0;
        }
        ck_assert_int_eq(rotors, 0);
        ck_assert_int_eq(numbers, i); // the file's own is a number that may be wrong, both ways
        free(list);
        lab_close(model);
    }
}
END_TEST

Suite *armature_suite(void)
{
    Suite *s = suite_create("armature");
    TCase *t = tcase_create("armature");
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, a_mechanism_gets_a_rotor_where_an_input_drives_a_joint);
    tcase_add_test(t, there_is_no_rotor_without_a_drive_and_none_beside_the_files_own);
    tcase_add_test(t, the_rotor_of_a_geared_arm_is_found_with_the_inertia_as_its_alias);
    tcase_add_test(t, the_rotor_of_the_second_joint_is_separated_from_the_inertia_of_its_link);
    tcase_set_timeout(t, 120);
    suite_add_tcase(s, t);
    return s;
}
