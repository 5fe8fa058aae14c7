/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_driven.c - simulations with signals and tables, in lanes and alone: to the last bit.
 */
#include "lab_support.h"
#include "mechanism_cases.h"
#include "twins.h"

/* a finger, or a motion of the key, with its own context */
typedef struct hand {
    double rate; /* [rad/s] */
    int gone;    /* it may not be called any more */
} hand;

static hand hands[PLACES];

static void swing(void *ctx, double t, double u[3])
{
    const hand *h = ctx;
    ck_assert_int_eq(h->gone, 0);
    u[0] = 0.01 * sin(h->rate * t);
    u[1] = 0.01 * h->rate * cos(h->rate * t);
    u[2] = -0.01 * h->rate * h->rate * sin(h->rate * t);
}

static void push(void *ctx, double t, double u[3])
{
    const hand *h = ctx;
    ck_assert_int_eq(h->gone, 0);
    u[0] = 0.4 + 0.4 * sin(h->rate * t);
}

/* some are pushed, some are led, some both, all by a hand of their own, late and with a gain */
static void hand_to(stein_sim *sim, int i)
{
    hands[i] = (hand){.rate = 61.0 + 7.3 * i};
    regulate(sim, i);
    set(sim, "finger.gain", 1.0 + 0.03 * i);
    set(sim, "finger.delay", 1e-3 * i);
    set(sim, "key_motion.gain", 0.9 + 0.02 * i);
    if (i % 4 == 1 || i % 4 == 3) {
        ck_assert_stein(stein_drive(sim, "finger", push, &hands[i], err));
    }
    if (i % 4 >= 2) {
        ck_assert_stein(stein_drive(sim, "key_motion", swing, &hands[i], err));
    }
}

START_TEST(signals_drive_lanes_as_they_drive_one_alone)
{
    int width = widths[_i % 4];
    twins t;
    if (!has_width(&stein_model_stein1788, width)) {
        return;
    }
    make_twins(&t, &stein_model_stein1788, _i < 4 ? STEIN_RK4 : STEIN_DP5, width, hand_to);
    run_twins(&t, 0.012, 0.1e-3);
    // a removed signal is not called again; signals may be unbound and bound
    for (int i = 0; i < PLACES; i++) {
        stein_sim *rider = stein_batch_sim(t.batch, i);
        stein_signal_fn *fn = i % 2 ? NULL : push;
        ck_assert_stein(stein_drive(t.alone[i], "finger", fn, &hands[i], err));
        ck_assert_stein(stein_drive(rider, "finger", fn, &hands[i], err));
    }
    run_twins(&t, 0.009, 0.1e-3);
    ck_assert_stein(stein_batch_put(t.batch, 4, NULL, err));
    hands[4].gone = 1;
    ck_assert_stein(stein_batch_step(t.batch, NULL, err));
    for (int i = 0; i < PLACES; i++) {
        if (i != 4) {
            ck_assert_stein(stein_step(t.alone[i], err));
        }
    }
    hands[4].gone = 0;
    ck_assert_stein(stein_step(t.alone[4], err));
    ck_assert_stein(stein_batch_put(t.batch, 4, t.rider[4], err));
    ck_assert_stein(stein_step(stein_batch_sim(t.batch, 4), err));
    compare_twins(&t);
    drop_twins(&t);
}
END_TEST

/* the same with steps of controlled error, a run of many short ones: its ends are where a record
 * bends */
START_TEST(so_they_do_from_sample_to_sample)
{
    enum { SAMPLES = 60 };
    stein_pace alone[PLACES], rider[PLACES];
    double t_end[PLACES];
    twins t;
    if (!has_width(&stein_model_stein1788, widths[_i])) {
        return;
    }
    make_twins(&t, &stein_model_stein1788, STEIN_DP5, widths[_i], hand_to);
    for (int i = 0; i < PLACES; i++) {
        alone[i] = rider[i] =
            (stein_pace){.tolerance = 1e-9, .longest = 1e-3, .h = 1e-5, .next = INFINITY};
    }
    for (int k = 1; k <= SAMPLES; k++) {
        for (int i = 0; i < PLACES; i++) {
            t_end[i] = (0.25e-3 + 1e-6 * i) * k;
            ck_assert_stein(stein_run_adaptive(t.alone[i], t_end[i], &alone[i], err));
        }
        ck_assert_stein(stein_batch_run_adaptive(t.batch, t_end, rider, NULL, err));
    }
    compare_twins(&t);
    drop_twins(&t);
}
END_TEST

/* ---- a run goes on with the acceleration of where the last one ended, unless it jumps ---- */

enum { BEND = 5 }; /* ms */

/* accelerated from then on */
typedef struct start {
    double t, a;
} start;

static void start_off(void *ctx, double t, double u[3])
{
    const start *s = ctx;
    double later = t - s->t;
    u[0] = 0.5 * s->a * later * later;
    u[1] = s->a * later;
    u[2] = s->a;
}

/* positions of key and hammer after 2 BEND, in runs that end at every ms */
static void drive_key(double a, double tolerance, double longest, double q[2])
{
    stein_sim *sim = NULL;
    start s = {0.0, 0.0};
    stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
    stein_pace pace = {.tolerance = tolerance, .longest = longest, .h = 1e-5, .next = INFINITY};
    def.integrator = STEIN_DP5;
    ck_assert_stein(stein_sim_create(&sim, &stein_model_stein1788, &def, err));
    ck_assert_stein(stein_drive(sim, "key_motion", start_off, &s, err));
    ck_assert_stein(stein_reset(sim, err));
    for (int k = 1; k <= 2 * BEND; k++) {
        ck_assert_stein(stein_run_adaptive(sim, 1e-3 * k, &pace, err));
        s = k == BEND ? (start){1e-3 * BEND, a} : s;
    }
    int key = stein_find_body(&stein_model_stein1788, "key"),
        hammer = stein_find_body(&stein_model_stein1788, "hammer");
    q[0] = stein_q(sim)[key];
    q[1] = stein_q(sim)[hammer];
    stein_sim_destroy(sim);
}

START_TEST(an_acceleration_that_jumps_where_a_run_ends_is_seen)
{
    double coarse[2], fine[2];
    drive_key(20.0, 1e-7, 1e-3, coarse);
    drive_key(20.0, 1e-12, 1e-5, fine);
    ck_assert_double_eq_tol(fine[0], 0.5 * 20.0 * 25e-6, 1e-9);
    ck_assert_double_eq_tol(coarse[0], fine[0], 1e-9);
    printf("hammer off by %.2g rad\n", coarse[1] - fine[1]);
    ck_assert_double_eq_tol(coarse[1], fine[1], 1e-8);
}
END_TEST

/* ---- laws given by points, and a joint that is held without a signal ---- */

static const char *const pointed[] = {"coil.torque.1", "coil.torque.3", "brake.torque.3",
                                      "felt.force.2",  "felt.force.3",  "tired.factor.1",
                                      "worn.factor.2"};

static void bend(stein_sim *sim, int i)
{
    static const double size[] = {2e-3, -1e-3, -3e-4, 0.11, 0.5, 0.2, -0.1};
    const stein_model *model = stein_sim_model(sim);
    double q[8], qd[8];
    ck_assert_int_le(model->nq, 8);
    hands[i] = (hand){.rate = 61.0 + 7.3 * i};
    for (int k = 0; k < 7; k++) {
        if (i > 0 && (k + i) % 3 != 0) { // where all are 0 there is no table
            set(sim, pointed[k], size[k] * (1.0 + 0.02 * i));
        }
    }
    if (i % 3 == 1) {
        ck_assert_stein(stein_drive(sim, "drive", swing, &hands[i], err));
    }
    if (i % 5 > 2) {
        ck_assert_stein(stein_drive(sim, "finger", push, &hands[i], err));
    }
    for (int j = 0; j < model->nq; j++) { // all on their way, hammers further and further up
        int hammer = strcmp(model->bodies[j].name, "hammer") == 0;
        q[j] = stein_q(sim)[j] + (hammer ? 0.02 * i : 0.0);
        qd[j] = hammer ? 0.7 : strcmp(model->bodies[j].name, "pawl") == 0 ? -0.9 : 0.0;
    }
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
}

START_TEST(so_do_tables_and_held_joints)
{
    char *text =
        changed("inputs:\n", "tables:\n"
                             "  coil: {joint: hammer, of: position, at: [-1, 0.1, 1 rad],"
                             " torque: [0, 0, 0 N m]}\n"
                             "  brake: {joint: pawl, of: speed, at: [-5, 0, 5 rad/s],"
                             " torque: [0, 0, 0 N m]}\n"
                             "  felt: {contact: stop, of: depth, at: [0, 1e-4, 1e-3 m],"
                             " force: [0, 0, 0 N]}\n"
                             "  tired: {contact: stop, of: rate, at: [-1, 1 m/s], factor: [0, 0]}\n"
                             "  worn: {notch: notch, of: rate, at: [-1, 1 m/s], factor: [0, 0]}\n"
                             "inputs:\n");
    lab_model *model = open_text(text, NULL, 0);
    const stein_model *m = lab_equations(model);
    for (int w = 0; w < 4; w++) {
        twins t;
        if (has_width(m, widths[w])) {
            make_twins(&t, m, w % 2 ? STEIN_RK4 : STEIN_DP5, widths[w], bend);
            run_twins(&t, 0.031, 0.3e-3);
            run_twins(&t, 0.007, 0.1e-3);
            drop_twins(&t);
        }
    }
    lab_close(model);
    free(text);
}
END_TEST

/* ---- a chain, which finds qdd by articulated bodies ---- */

enum { LINKS = 13 };

static char *chain_text(void)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    fprintf(f, "mechanism: rope\nbodies:\n");
    for (int i = 0; i < LINKS; i++) {
        fprintf(f, "  l%d:\n    joint: R %sy\n", i, i % 3 ? "-" : "");
        if (i > 0) {
            fprintf(f, "    parent: l%d\n    at: [0, 0, -0.1]\n", i - 1);
        }
        fprintf(f,
                "    mass: 0.02\n    centre: [0.003, 0, -0.05]\n    inertia: {yy: 2e-5}\n"
                "    initial: {position: %g}\n",
                0.3 - 0.05 * i);
    }
    fprintf(f, "inputs:\n  push: {torque: l4}\n"
               "outputs:\n  kinetic: {energy: kinetic}\n  potential: {energy: potential}\n");
    ck_assert_int_eq(fclose(f), 0);
    return text;
}

static void hang(stein_sim *sim, int i)
{
    double q[LINKS], qd[LINKS];
    hands[i] = (hand){.rate = 41.0 + 3.7 * i};
    for (int j = 0; j < LINKS; j++) {
        q[j] = stein_q(sim)[j] * (1.0 + 0.1 * i);
        qd[j] = 0.3 * (j % 4) - 0.1 * i;
    }
    set(sim, "l3.mass", 0.02 + 0.003 * i);
    if (i % 2) {
        ck_assert_stein(stein_drive(sim, "push", push, &hands[i], err));
    }
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
}

START_TEST(so_do_chains_that_have_no_mass_matrix)
{
    char *text = chain_text();
    lab_model *model = open_text(text, NULL, 0);
    const stein_model *m = lab_equations(model);
    ck_assert(m->articulated != NULL);
    for (int w = 0; w < 4; w++) {
        twins t;
        if (has_width(m, widths[w])) {
            make_twins(&t, m, w % 2 ? STEIN_RK4 : STEIN_DP5, widths[w], hang);
            run_twins(&t, 0.031, 0.3e-3);
            drop_twins(&t);
        }
    }
    stein_sim *sim = make_sim(m, STEIN_DP5, 1e-3);
    double before[2], after[2], swung = 0.0;
    for (int k = 0; k < 500; k++) {
        for (int e = 0; e < 2; e++) {
            ck_assert_stein(stein_read_name(sim, e ? "potential" : "kinetic", &after[e], err));
            before[e] = k == 0 ? after[e] : before[e];
        }
        swung = fmax(swung, after[0]);
        ck_assert_double_eq_tol(after[0] + after[1], before[0] + before[1], 3e-8); // J
        ck_assert_stein(stein_step(sim, err));
    }
    ck_assert(swung > 1e-3);
    stein_sim_destroy(sim);
    lab_close(model);
    free(text);
}
END_TEST

Suite *driven_suite(void)
{
    Suite *s = suite_create("driven");
    TCase *tc = tcase_create("driven");
    tcase_set_timeout(tc, 120.0);
    tcase_add_loop_test(tc, signals_drive_lanes_as_they_drive_one_alone, 0, 8);
    tcase_add_loop_test(tc, so_they_do_from_sample_to_sample, 0, 4);
    tcase_add_test(tc, an_acceleration_that_jumps_where_a_run_ends_is_seen);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, so_do_tables_and_held_joints);
    suite_add_tcase(s, tc);
    tc = tcase_create("compiled here"); // with writes that the memory sanitizer does not track
    tcase_set_tags(tc, "compiled");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 120.0);
    tcase_add_test(tc, so_do_chains_that_have_no_mass_matrix);
    suite_add_tcase(s, tc);
    return s;
}
