/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_wrong.c - numbers that go wrong: every run that cannot be right ends with a code, a time, a
 * place and a hint, in the state before. And over random regulations nothing that is not finite
 * comes out without an error, contacts and friction never make energy.
 */
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"

static void said(const stein_err *why, const char *what)
{
    ck_assert_msg(strstr(why->msg, what) != NULL, "%s\n  lacks %s", why->msg, what);
}

/* run to the failure; the state is the saved one */
static void fails(stein_sim *sim, double until, stein_status code, stein_err *why)
{
    ck_assert_int_eq(stein_run(sim, until, why), code);
    ck_assert(stein_time(sim) < until);
    for (int j = 0; j < stein_sim_model(sim)->nq; j++) {
        ck_assert(isfinite(stein_q(sim)[j]) && isfinite(stein_qd(sim)[j]));
    }
}

START_TEST(a_contact_too_stiff_for_the_step_is_named_with_the_step_it_needs)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 0.01);
    stein_err why;
    fails(sim, 1.0, STEIN_ECHATTER, &why);
    said(&why, "t = 0.2257");
    said(&why, "contact \"floor\" is too stiff for steps of 0.01 s, it needs 0.000");
    double needed = strtod(strstr(why.msg, "needs ") + 6, NULL);
    stein_sim_destroy(sim);
    sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, needed);
    ck_assert_stein(stein_run(sim, 1.0, err));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_step_far_too_large_ends_with_time_place_and_hint)
{
    static const double dt[] = {0.3e-3, 1e-3, 5e-3, 0.05};
    for (int i = 0; i < 8; i++) {
        stein_sim *sim = make_sim(&stein_model_stein1788, i < 4 ? STEIN_RK4 : STEIN_DP5, dt[i % 4]);
        stein_err why;
        stein_status status = stein_run(sim, 0.25, &why);
        ck_assert(status == STEIN_ECHATTER || status == STEIN_ENONFINITE);
        said(&why, "t = ");
        ck_assert_msg(strstr(why.msg, "too stiff") != NULL || strstr(why.msg, "shorter") != NULL,
                      "%s", why.msg);
        stein_sim_destroy(sim);
    }
}
END_TEST

START_TEST(the_rate_of_a_linear_contact_is_that_of_its_spring)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 1e-5);
    int index = -1;
    ck_assert(stein_stiffest(sim, &index) == 0.0 && index == -1); // in the air
    double q = 0.0213 - 0.3e-3, qd = 0.0, k, b;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    double c = 52e3, m = 46.1e-3, D = 0.14;
    k = sqrt(c / m);
    b = c * 0.3e-3 * D / m;
    ck_assert_close(stein_stiffest(sim, &index), fmax(k, b), 1e-4, 0.0);
    ck_assert_int_eq(index, stein_find_contact(&stein_model_bouncing_ball, "floor"));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(the_stiffest_contact_is_found_without_changes)
{
    stein_sim *asked = make_sim(&stein_model_stein1788, STEIN_RK4, 1e-5);
    stein_sim *left = make_sim(&stein_model_stein1788, STEIN_RK4, 1e-5);
    for (int k = 0; k < 7000; k++) {
        int index;
        ck_assert_stein(stein_step(asked, err));
        ck_assert_stein(stein_step(left, err));
        (void)stein_stiffest(asked, &index);
        ck_assert(stein_read(asked, k % 10) == stein_read(left, k % 10));
    }
    ck_assert(memcmp(stein_q(asked), stein_q(left), sizeof(double) * 4) == 0);
    stein_sim_destroy(asked);
    stein_sim_destroy(left);
}
END_TEST

static void push_nan(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)q;
    (void)qd;
    Q[*(int *)ctx] += t > 0.0123 ? (double)NAN : 1.0;
}

START_TEST(a_hook_without_a_number_is_named_by_the_joint)
{
    int joint = 1;
    for (int i = 0; i < 2; i++) {
        stein_sim *sim = make_sim(&stein_model_double_pendulum, i ? STEIN_DP5 : STEIN_RK4, 1e-3);
        stein_err why;
        stein_on_force(sim, push_nan, &joint);
        fails(sim, 0.1, STEIN_ENONFINITE, &why);
        said(&why, "t = 0.012 s");
        said(&why, "the force hook gives joint \"");
        said(&why, stein_model_double_pendulum.bodies[1].name);
        stein_sim_destroy(sim);
    }
}
END_TEST

static void signal_inf(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = t > 0.0217 ? (double)INFINITY : 0.1;
}

START_TEST(a_signal_without_a_number_is_named_by_its_input)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 1e-3);
    stein_err why;
    ck_assert_stein(stein_drive(sim, "push", signal_inf, NULL, err));
    fails(sim, 0.1, STEIN_ENONFINITE, &why);
    said(&why, "t = 0.021 s");
    said(&why, "the signal of input \"push\" is not finite");
    ck_assert_stein(stein_drive(sim, "push", NULL, NULL, err)); // and it can go on
    ck_assert_stein(stein_run(sim, 0.1, err));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_singular_mass_matrix_is_reported_with_its_joint_and_cause)
{
    stein_sim *sim = make_sim(&stein_model_falling_ball, STEIN_RK4, 1e-3);
    stein_err why;
    const char *name = stein_model_falling_ball.bodies[0].name;
    char mass[80];
    snprintf(mass, sizeof mass, "%s.mass", name);
    ck_assert_stein(stein_set(sim, mass, 0.0, err));
    ck_assert_int_eq(stein_run(sim, 0.1, &why), STEIN_ESINGULAR);
    said(&why, "singular at joint");
    said(&why, name);
    said(&why, "t = 0 s");
    said(&why, "needs a mass or an inertia");
    stein_sim_destroy(sim);
}
END_TEST

/* ---- random regulations of the mechanisms that there are ---- */

/* all numbers of a mechanism off by up to 3 %
 */
static void draw_regulation(stein_sim *sim, unsigned long long *seed)
{
    const stein_model *m = stein_sim_model(sim);
    for (int i = 0; i < m->np; i++) {
        double value;
        ck_assert_stein(stein_get(sim, m->params[i].name, &value, err));
        double change = noise(seed);
        if (value != 0.0) {
            ck_assert_stein(stein_set(sim, m->params[i].name, value * (1.0 + 0.03 * change), err));
        }
    }
}

/* how many of the runs ended with an error; the others are finite all the way */
static int run_regulations(int n, unsigned long long seed, int steps)
{
    int failed = 0;
    for (int i = 0; i < n; i++) {
        const stein_model *m = stein_models[i % 12];
        stein_sim *sim = make_sim(m, i / 12 % 2 ? STEIN_DP5 : STEIN_RK4, 0.0);
        stein_err why = {STEIN_OK, ""};
        draw_regulation(sim, &seed);
        stein_status status = stein_reset(sim, &why);
        for (int k = 0; status == STEIN_OK && k < steps; k++) {
            status = stein_step(sim, &why);
        }
        for (int c = 0; c < m->nchannel && status == STEIN_OK; c++) {
            ck_assert_msg(isfinite(stein_read(sim, c)), "%s: %s", m->name, m->channels[c].name);
        }
        for (int c = 0; c < m->ncontact && status == STEIN_OK; c++) {
            double x = 0.0, xdot = 0.0;
            if (stein_deformation(sim, c, &x, &xdot)) {
                ck_assert_msg(x >= 0.0 && x < 0.02, "%s: %s is %g m deep", m->name,
                              m->contacts[c].name, x);
            }
        }
        if (status != STEIN_OK) {
            ck_assert_msg(status == STEIN_ENONFINITE || status == STEIN_ESINGULAR ||
                              status == STEIN_ECHATTER || status == STEIN_ESETTLE,
                          "%s: %s", m->name, why.msg);
            ck_assert(why.msg[0] != '\0');
            failed++;
        }
        stein_sim_destroy(sim);
    }
    return failed;
}

START_TEST(random_regulations_end_in_numbers_or_in_an_error)
{
    int n = soak(600), failed = run_regulations(n, 20260101, 300);
    printf("regulations: %d runs, %d ended with an error\n", n, failed);
    ck_assert(failed < n / 4);
}
END_TEST

/* ---- random mechanisms ---- */

/* a tree of up to four bodies about and along any axis, with springs, dampers and friction */
static int write_tree(char *text, size_t room, unsigned long long *seed)
{
    int n = 1 + (int)(2.0 * (1.0 + noise(seed)));
    size_t at = (size_t)snprintf(text, room, "mechanism: m\nbodies:\n");
    for (int i = 0; i < n; i++) {
        int parent = (int)(0.5 * (1.0 + noise(seed)) * (i + 1)) - 1,
            axis = (int)(1.5 * (1.0 + noise(seed)));
        int turns = noise(seed) < 0.5;
        at += (size_t)snprintf(text + at, room - at, "  b%d: {joint: %c %s%c, mass: %.6g, ", i,
                               turns ? 'R' : 'T', noise(seed) < 0.0 ? "-" : "", "xyz"[axis],
                               0.01 + fabs(noise(seed)));
        if (parent >= 0 && parent < i) {
            at += (size_t)snprintf(text + at, room - at, "parent: b%d, ", parent);
        }
        at += (size_t)snprintf(text + at, room - at,
                               "at: [%.4g, %.4g, %.4g], centre: [%.4g, %.4g, %.4g], "
                               "inertia: {xx: %.4g, yy: %.4g, zz: %.4g}, damping: %.4g, "
                               "initial: {position: %.4g, speed: %.4g}}\n",
                               0.2 * noise(seed), 0.2 * noise(seed), 0.2 * noise(seed),
                               0.1 * noise(seed), 0.1 * noise(seed), 0.1 * noise(seed), 1e-2,
                               1.1e-2, 0.9e-2, noise(seed) < 0.0 ? 0.0 : 0.01 * (1.0 + noise(seed)),
                               noise(seed), 2.0 * noise(seed));
    }
    at += (size_t)snprintf(text + at, room - at,
                           "outputs: {kinetic: {energy: kinetic}, potential: {energy: potential}}\n"
                           "simulation: {dt: 0.5 ms, until: 50 ms}\n");
    return at < room ? n : 0;
}

START_TEST(random_mechanism_files_are_read_and_give_equations)
{
    unsigned long long seed = 4711;
    int n = soak(40);
    for (int i = 0; i < n; i++) {
        char text[4000];
        mechanism *m = NULL;
        stein_err why = {STEIN_OK, ""};
        ck_assert(write_tree(text, sizeof text, &seed) > 0);
        stein_status status =
            mech_read_text(&m, "m.yaml", text, strlen(text), NULL, 0, NULL, NULL, &why);
        ck_assert_msg(status == STEIN_OK, "%s\n%s", why.msg, text);
        gen_result r; // test_generator.c tests the messages
        ck_assert_stein(gen_equations(&r, m, err));
        ck_assert(strstr(r.source, "nan") == NULL);
        gen_free(&r);
        mech_free(m);
    }
}
END_TEST

/* ---- energy ---- */

static double energy_of(stein_sim *sim)
{
    double kinetic, potential;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
    return kinetic + potential;
}

/* a ball on a floor of any felt and any damping never comes up higher than it fell */
START_TEST(contacts_never_make_energy)
{
    unsigned long long seed = 99;
    for (int i = 0; i < soak(40); i++) {
        stein_sim *sim = make_sim(&stein_model_bouncing_ball, i % 2 ? STEIN_DP5 : STEIN_RK4, 2e-5);
        double c = 5e3 * exp(2.0 * noise(&seed)), a = 1e9 * fabs(noise(&seed));
        ck_assert_stein(stein_set(sim, "floor.normal.c", c, err));
        ck_assert_stein(stein_set(sim, "floor.normal.a", a, err));
        ck_assert_stein(stein_set(sim, "floor.normal.D", 0.3 * (1.0 + noise(&seed)), err));
        ck_assert_stein(stein_set(sim, "floor.normal.h", 0.2 * fabs(noise(&seed)), err));
        ck_assert_stein(stein_reset(sim, err));
        double before = energy_of(sim), highest = 0.0;
        for (int k = 0; k < 25000; k++) {
            ck_assert_stein(stein_step(sim, err));
            double x, xdot;
            if (!stein_deformation(sim, 0, &x, &xdot)) {
                highest = fmax(highest, energy_of(sim));
                ck_assert_msg(energy_of(sim) <= before * (1.0 + 1e-6),
                              "regulation %d: %.9g J of %.9g", i, energy_of(sim), before);
            }
        }
        ck_assert(highest > 0.0);
        stein_sim_destroy(sim);
    }
}
END_TEST

/* friction and damping of joints take energy in every step */
START_TEST(friction_never_makes_energy)
{
    unsigned long long seed = 7;
    for (int i = 0; i < soak(20); i++) {
        stein_sim *sim =
            make_sim(&stein_model_double_pendulum, i % 2 ? STEIN_DP5 : STEIN_RK4, 1e-4);
        const stein_model *m = &stein_model_double_pendulum;
        for (int j = 0; j < m->nq; j++) {
            static const char *const law[] = {"damping", "drag", "friction.A", "coulomb.T"};
            for (int k = 0; k < 4; k++) {
                char name[80];
                snprintf(name, sizeof name, "%s.%s", m->bodies[j].name, law[k]);
                ck_assert_stein(stein_set(sim, name, 1e-3 * fabs(noise(&seed)), err));
            }
        }
        ck_assert_stein(stein_reset(sim, err));
        double last = energy_of(sim), scale = fabs(last) + 0.1;
        for (int k = 0; k < 3000; k++) {
            ck_assert_stein(stein_step(sim, err));
            double now = energy_of(sim);
            ck_assert_msg(now <= last + 1e-9 * scale, "step %d of %d: %.12g J after %.12g", k, i,
                          now, last);
            last = now;
        }
        stein_sim_destroy(sim);
    }
}
END_TEST

Suite *wrong_suite(void)
{
    Suite *suite = suite_create("wrong");
    TCase *tc = tcase_create("wrong");
    tcase_set_timeout(tc, soaks() > 0 ? 36000.0 : 120.0);
    tcase_add_test(tc, a_contact_too_stiff_for_the_step_is_named_with_the_step_it_needs);
    tcase_add_test(tc, a_step_far_too_large_ends_with_time_place_and_hint);
    tcase_add_test(tc, the_rate_of_a_linear_contact_is_that_of_its_spring);
    tcase_add_test(tc, the_stiffest_contact_is_found_without_changes);
    tcase_add_test(tc, a_hook_without_a_number_is_named_by_the_joint);
    tcase_add_test(tc, a_signal_without_a_number_is_named_by_its_input);
    tcase_add_test(tc, a_singular_mass_matrix_is_reported_with_its_joint_and_cause);
    tcase_add_test(tc, random_regulations_end_in_numbers_or_in_an_error);
    tcase_add_test(tc, random_mechanism_files_are_read_and_give_equations);
    tcase_add_test(tc, contacts_never_make_energy);
    tcase_add_test(tc, friction_never_makes_energy);
    suite_add_tcase(suite, tc);
    return suite;
}
