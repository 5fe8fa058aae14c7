/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_integrator.c - order, energy, error estimate and determinism of the steppers.
 */
#include <stdlib.h>
#include <string.h>

#include "support.h"

static const double start_q[2] = {0.731, -0.412}, start_qd[2] = {1.27, -0.93};

/* double pendulum after 1 s at step dt, as q0, q1, qd0, qd1 */
static void swing(stein_integrator integrator, double dt, double out[4])
{
    stein_sim *sim = make_sim(&stein_model_double_pendulum, integrator, dt);
    ck_assert_stein(stein_set_state(sim, 0.0, start_q, start_qd, err));
    ck_assert_stein(stein_run(sim, 1.0, err));
    memcpy(out, stein_q(sim), 2 * sizeof *out);
    memcpy(out + 2, stein_qd(sim), 2 * sizeof *out);
    stein_sim_destroy(sim);
}

static double distance(const double a[4], const double b[4])
{
    double m = 0.0;
    for (int i = 0; i < 4; i++) {
        m = fmax(m, fabs(a[i] - b[i]));
    }
    return m;
}

static double observed_order(stein_integrator integrator, double dt)
{
    double reference[4], coarse[4], fine[4];
    swing(integrator, dt / 16.0, reference);
    swing(integrator, dt, coarse);
    swing(integrator, dt / 2.0, fine);
    double order = log2(distance(coarse, reference) / distance(fine, reference));
    printf("observed order of %s: %.3f\n", integrator == STEIN_RK4 ? "RK4" : "DP5", order);
    return order;
}

START_TEST(rk4_has_order_four)
{
    ck_assert_close(observed_order(STEIN_RK4, 1.0 / 1024.0), 4.0, 0.0, 0.1);
}
END_TEST

START_TEST(dp5_has_order_five)
{
    ck_assert_close(observed_order(STEIN_DP5, 1.0 / 600.0), 5.0, 0.0, 0.1);
}
END_TEST

START_TEST(frictionless_motion_keeps_its_energy)
{
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_RK4, 1e-4);
    ck_assert_stein(stein_set_state(sim, 0.0, start_q, start_qd, err));
    double T, V, T0, V0, drift = 0.0;
    stein_energy(sim, start_q, start_qd, &T0, &V0);
    for (int i = 1; i <= 1000; i++) {
        ck_assert_stein(stein_run(sim, 0.1 * i, err));
        stein_energy(sim, stein_q(sim), stein_qd(sim), &T, &V);
        drift = fmax(drift, fabs(T + V - T0 - V0));
    }
    drift /= fabs(T0) + fabs(V0);
    printf("energy drift of the double pendulum, 100 s, RK4 1e-4 s: %.2e relative\n", drift);
    ck_assert(drift <= 1e-9);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(dp5_error_estimate_shrinks_with_the_fifth_power_and_rk4_has_none)
{
    double e[2], ed;
    for (int i = 0; i < 2; i++) {
        stein_sim *sim =
            make_sim(&stein_model_double_pendulum, STEIN_DP5, i == 0 ? 0.0025 : 0.00125);
        stein_err failure = {STEIN_OK, ""};
        ck_assert_int_eq(stein_step_error(sim, &e[i], &ed, &failure), STEIN_EINVAL); // no step yet
        ck_assert_stein(stein_set_state(sim, 0.0, start_q, start_qd, err));
        ck_assert_stein(stein_step(sim, err));
        ck_assert_stein(stein_step_error(sim, &e[i], &ed, err));
        ck_assert(ed > 0.0);
        stein_sim_destroy(sim);
    }
    ck_assert_close(log2(e[0] / e[1]), 5.0, 0.0, 0.1);
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_RK4, 0.01);
    ck_assert_stein(stein_step(sim, err));
    ck_assert_int_eq(stein_step_error(sim, &e[0], &ed, NULL), STEIN_EINVAL);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(dp5_error_estimate_is_larger_than_the_error)
{
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_DP5, 0.02);
    stein_sim *fine = make_sim(&stein_model_double_pendulum, STEIN_DP5, 0.0005);
    double eq, eqd;
    ck_assert_stein(stein_set_state(sim, 0.0, start_q, start_qd, err));
    ck_assert_stein(stein_set_state(fine, 0.0, start_q, start_qd, err));
    ck_assert_stein(stein_step(sim, err));
    ck_assert_stein(stein_run(fine, 0.02, err));
    ck_assert_stein(stein_step_error(sim, &eq, &eqd, err));
    for (int j = 0; j < 2; j++) {
        ck_assert(fabs(stein_q(sim)[j] - stein_q(fine)[j]) < eq);
        ck_assert(fabs(stein_qd(sim)[j] - stein_qd(fine)[j]) < eqd);
    }
    stein_sim_destroy(sim);
    stein_sim_destroy(fine);
}
END_TEST

START_TEST(a_run_lands_exactly_on_its_end)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 1e-3);
    double q = 0.41, qd = 0.0;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    ck_assert_stein(stein_run(sim, 0.0123456, err));
    ck_assert(stein_time(sim) == 0.0123456);
    ck_assert_stein(stein_run(sim, 0.0123456, err)); // nothing to do
    ck_assert(stein_dt(sim) == 1e-3);
    ck_assert_int_eq(stein_run(sim, 0.01, NULL), STEIN_EINVAL);
    ck_assert_int_eq(stein_run(sim, NAN, NULL), STEIN_EINVAL);
    ck_assert(stein_time(sim) == 0.0123456);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- controlled steps ---- */

/* the double pendulum at irregular times */
typedef struct seen {
    double last, q[3], qd[3]; /* at 0.25, 0.7 and 1 s */
    int n, looks;
} seen;

static double look(void *ctx, stein_sim *sim)
{
    static const double when[] = {0.25, 0.7, 1.0};
    seen *s = ctx;
    double t = stein_time(sim);
    ck_assert(t >= s->last);
    s->last = t;
    s->looks++;
    if (s->n < 3 && t == when[s->n]) {
        s->q[s->n] = stein_q(sim)[1];
        s->qd[s->n++] = stein_qd(sim)[1];
    }
    double next = t + 0.0123;
    return s->n < 3 && next > when[s->n] ? when[s->n] : next;
}

static stein_pace pace_of(double tolerance, stein_look_fn *fn, void *ctx)
{
    return (stein_pace){tolerance, 0.1, 1e-3, 0.0, fn, ctx};
}

START_TEST(looks_inside_of_controlled_steps_show_the_motion)
{
    static const double when[] = {0.25, 0.7, 1.0};
    seen s = {.last = 0.0};
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_DP5, 0.01);
    stein_sim *fine = make_sim(&stein_model_double_pendulum, STEIN_DP5, 2e-4);
    stein_pace pace = pace_of(1e-10, look, &s);
    ck_assert_stein(stein_set_state(sim, 0.0, start_q, start_qd, err));
    ck_assert_stein(stein_set_state(fine, 0.0, start_q, start_qd, err));
    ck_assert_stein(stein_run_adaptive(sim, 1.0, &pace, err));
    ck_assert(stein_time(sim) == 1.0);
    ck_assert_int_eq(s.n, 3);
    ck_assert(s.looks > 80);
    for (int i = 0; i < 3; i++) {
        ck_assert_stein(stein_run(fine, when[i], err));
        ck_assert_close(s.q[i], stein_q(fine)[1], 0.0, 2e-8);
        ck_assert_close(s.qd[i], stein_qd(fine)[1], 0.0, 2e-7);
    }
    stein_sim_destroy(sim);
    stein_sim_destroy(fine);
}
END_TEST

START_TEST(looking_does_not_change_a_controlled_step)
{
    double end[2][2];
    seen s = {.last = 0.0};
    for (int i = 0; i < 2; i++) {
        stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_DP5, 1e-5);
        stein_pace pace = {1e-9, 3e-4, 1e-6, 0.0, i == 0 ? NULL : look, &s};
        ck_assert_stein(stein_run_adaptive(sim, 0.08, &pace, err));
        memcpy(end[i], stein_q(sim), sizeof end[i]);
        stein_sim_destroy(sim);
    }
    ck_assert(s.looks > 5);
    ck_assert_mem_eq(end[0], end[1], sizeof end[0]);
}
END_TEST

/* the force of the string every 3 us */
static double feel(void *ctx, stein_sim *sim)
{
    double *last = ctx;
    *last = stein_read(sim, stein_find_channel(&stein_model_stein1788, "string_force"));
    return stein_time(sim) + 3e-6;
}

START_TEST(forces_read_after_looks_are_those_of_the_end)
{
    static const double until = 0.0535; // while the hammer is on the string
    double force[2], last = 0.0;
    for (int i = 0; i < 2; i++) {
        stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_DP5, 1e-5);
        stein_pace pace = {1e-9, 3e-4, 1e-6, 0.0, i == 0 ? NULL : feel, &last};
        ck_assert_stein(stein_run_adaptive(sim, until, &pace, err));
        force[i] = stein_read(sim, stein_find_channel(&stein_model_stein1788, "string_force"));
        stein_sim_destroy(sim);
    }
    ck_assert_double_gt(force[0], 1.0);
    ck_assert(fabs(last - force[0]) > 1e-9); // the last look was before the end
    ck_assert_close(force[1], force[0], 1e-12, 0.0);
}
END_TEST

START_TEST(controlled_steps_give_up_on_a_motion_that_is_too_stiff)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_DP5, 1e-3);
    stein_pace pace = {.tolerance = 1e-10, .longest = 1e-2, .h = 1e-4, .next = INFINITY};
    const double q = 0.4, qd = 1.0;
    stein_err why;
    ck_assert_stein(stein_set(sim, "rod.damping", 1e9, err));
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    ck_assert_int_eq(stein_run_adaptive(sim, 10.0, &pace, &why), STEIN_ECHATTER);
    ck_assert_ptr_nonnull(strstr(why.msg, "too stiff"));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(controlled_steps_refuse_invalid_settings)
{
    stein_sim *rk4 = make_sim(&stein_model_pendulum, STEIN_RK4, 1e-3);
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_DP5, 1e-3);
    stein_pace pace = pace_of(1e-9, NULL, NULL);
    ck_assert_int_eq(stein_run_adaptive(rk4, 0.1, &pace, NULL), STEIN_EINVAL);
    ck_assert_int_eq(stein_run_adaptive(sim, NAN, &pace, NULL), STEIN_EINVAL);
    ck_assert_int_eq(stein_trials(sim), 0);
    ck_assert_stein(stein_run_adaptive(sim, 0.1, &pace, err));
    ck_assert_int_gt(stein_trials(sim), 0);
    ck_assert_int_eq(stein_run_adaptive(sim, 0.05, &pace, NULL), STEIN_EINVAL);
    pace.tolerance = 0.0;
    ck_assert_int_eq(stein_run_adaptive(sim, 0.2, &pace, NULL), STEIN_EINVAL);
    ck_assert(stein_time(sim) == 0.1);
    stein_sim_destroy(rk4);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(the_same_run_gives_the_same_bits)
{
    double a[4], b[4];
    swing(STEIN_DP5, 0.003, a);
    swing(STEIN_DP5, 0.003, b);
    ck_assert_int_eq(memcmp(a, b, sizeof a), 0);
}
END_TEST

START_TEST(a_restored_state_continues_bit_for_bit)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 2e-5);
    stein_sim *other = make_sim(&stein_model_stein1788, STEIN_RK4, 2e-5);
    size_t size = stein_state_size(sim);
    void *saved = malloc(size), *end = malloc(size), *again = malloc(size);
    ck_assert_stein(stein_run(sim, 0.0475, err)); // in the middle of the drive
    stein_save(sim, saved);
    ck_assert_stein(stein_run(sim, 0.0901, err));
    stein_save(sim, end);
    ck_assert_stein(stein_restore(other, saved, err));
    ck_assert_stein(stein_run(other, 0.0901, err));
    stein_save(other, again);
    ck_assert_int_eq(memcmp(end, again, size), 0);

    stein_sim *pendulum = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_err failure;
    ck_assert_int_eq(stein_restore(pendulum, saved, &failure), STEIN_EINVAL);
    ck_assert(strstr(failure.msg, "pendulum") != NULL);
    stein_sim_destroy(pendulum);
    free(saved);
    free(end);
    free(again);
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
}
END_TEST

/* a block, changed at one place, is refused, and the simulation is not changed */
static void refuse_block(stein_sim *sim, const void *block, size_t size, const char *why)
{
    stein_err failure = {STEIN_OK, ""};
    size_t whole = stein_state_size(sim);
    void *before = malloc(whole), *after = malloc(whole);
    stein_save(sim, before);
    ck_assert_int_eq(stein_restore_from(sim, block, size, &failure), STEIN_EINVAL);
    ck_assert_msg(strstr(failure.msg, why) != NULL, "%s, expected %s", failure.msg, why);
    stein_save(sim, after);
    ck_assert_int_eq(memcmp(before, after, whole), 0);
    free(before);
    free(after);
}

START_TEST(blocks_that_are_cut_damaged_or_foreign_are_refused)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 2e-5);
    size_t size = stein_state_size(sim);
    unsigned char *saved = malloc(size);
    ck_assert_stein(stein_run(sim, 0.0475, err));
    stein_save(sim, saved);
    ck_assert_stein(stein_reset(sim, err));
    for (size_t n = 0; n < size; n++) {
        unsigned char *cut =
            malloc(n + 1); // a separate block, so that a sanitizer detects reads beyond it
        memcpy(cut, saved, n);
        refuse_block(sim, cut, n, n < 64 ? "cut off" : "bytes, expected");
        free(cut);
    }
    for (size_t bit = 0; bit < 8 * size; bit++) {
        saved[bit / 8] ^= (unsigned char)(1u << bit % 8);
        refuse_block(sim, saved, size, bit < 64 ? "no saved state" : "the saved state");
        saved[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    refuse_block(sim, saved, size + 16, "bytes, expected");
    ck_assert_stein(stein_restore_from(sim, saved, size, err));
    ck_assert(stein_time(sim) == 0.0475);
    free(saved);
    stein_sim_destroy(sim);
}
END_TEST

Suite *integrator_suite(void)
{
    Suite *suite = suite_create("integrator");
    TCase *tc = tcase_create("integrator");
    tcase_set_timeout(tc, 120.0);
    tcase_add_test(tc, rk4_has_order_four);
    tcase_add_test(tc, dp5_has_order_five);
    tcase_add_test(tc, frictionless_motion_keeps_its_energy);
    tcase_add_test(tc, dp5_error_estimate_shrinks_with_the_fifth_power_and_rk4_has_none);
    tcase_add_test(tc, dp5_error_estimate_is_larger_than_the_error);
    tcase_add_test(tc, a_run_lands_exactly_on_its_end);
    tcase_add_test(tc, looks_inside_of_controlled_steps_show_the_motion);
    tcase_add_test(tc, looking_does_not_change_a_controlled_step);
    tcase_add_test(tc, forces_read_after_looks_are_those_of_the_end);
    tcase_add_test(tc, controlled_steps_refuse_invalid_settings);
    tcase_add_test(tc, controlled_steps_give_up_on_a_motion_that_is_too_stiff);
    tcase_add_test(tc, the_same_run_gives_the_same_bits);
    tcase_add_test(tc, a_restored_state_continues_bit_for_bit);
    tcase_add_test(tc, blocks_that_are_cut_damaged_or_foreign_are_refused);
    suite_add_tcase(suite, tc);
    return suite;
}
