/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_balance.c - energies of a motion (balance.h), and steps of controlled error.
 */
#include <string.h>

#include "stein/balance.h"
#include "support.h"

static stein_sim *sim;
static stein_balance *balance;

static void start(const stein_model *model, stein_integrator integrator, double dt)
{
    sim = make_sim(model, integrator, dt);
    ck_assert_stein(stein_balance_create(&balance, model, NULL, err));
    ck_assert_stein(stein_balance_attach(balance, sim, err));
}

static void stop(void)
{
    stein_balance_destroy(balance);
    stein_sim_destroy(sim);
    balance = NULL;
    sim = NULL;
}

static stein_energy_total total(void)
{
    stein_energy_total sum;
    stein_balance_total(balance, &sum);
    return sum;
}

static const stein_integrator kinds[] = {STEIN_RK4, STEIN_DP5, STEIN_CONTROLLED};

START_TEST(a_motion_keeps_its_bits)
{
    const stein_model *model = &stein_model_stein1788;
    start(model, kinds[_i], 0.0);
    stein_sim *alone = make_sim(model, kinds[_i], 0.0);
    for (int i = 0; i < 60; i++) {
        ck_assert_stein(stein_run(sim, 1e-3 * (i + 1), err));
        ck_assert_stein(stein_run(alone, 1e-3 * (i + 1), err));
        for (int k = 0; i % 7 == 3 && k < model->nchannel; k++) {
            double a = stein_read(sim, k), b = stein_read(alone, k);
            ck_assert_mem_eq(&a, &b, sizeof a);
        }
    }
    size_t size = sizeof(double) * (size_t)model->nq;
    ck_assert_mem_eq(stein_q(sim), stein_q(alone), size);
    ck_assert_mem_eq(stein_qd(sim), stein_qd(alone), size);
    stein_sim_destroy(alone);
    stop();
}
END_TEST

START_TEST(what_is_read_is_at_the_end_of_the_last_step)
{
    const stein_model *model = &stein_model_double_pendulum;
    int angle = stein_find_channel(model, "upper_angle");
    start(model, STEIN_CONTROLLED, 0.01);
    ck_assert_int_ge(angle, 0);
    for (int i = 1; i <= 100; i++) {
        ck_assert_stein(stein_run(sim, 0.01 * i, err));
        ck_assert_double_eq(stein_read(sim, angle), stein_q(sim)[0]);
    }
    stop();
}
END_TEST

/* The action until the hammer has fallen back: every law takes part. RK4 errs by 4e-7 of what is
 * dissipated at 10 us, by 2e-7 at 5 us: friction turns within a step. */
START_TEST(all_energy_of_a_stroke_is_explained)
{
    double share[2];
    for (int i = 0; i < 2; i++) {
        start(&stein_model_stein1788, STEIN_RK4, i ? 5e-6 : 1e-5);
        ck_assert_stein(stein_run(sim, 0.12, err));
        stein_load_lift(sim);
        ck_assert_stein(stein_run(sim, 0.2, err));
        stein_energy_total sum = total();
        double parts = sum.begin + sum.inputs - sum.dissipated - sum.stored + sum.other -
                       sum.taken + sum.unexplained;
        ck_assert_close(sum.now, parts, 1e-12, 1e-16);
        ck_assert_double_gt(sum.dissipated, 3e-3);
        ck_assert_close(sum.other, 0.0, 0.0, 1e-15);
        share[i] = fabs(sum.unexplained) / sum.scale;
        stop();
    }
    printf("energy of a stroke unexplained: %.1e of it at 10 us, %.1e at 5 us\n", share[0],
           share[1]);
    ck_assert_double_lt(share[0], 1e-5);
    ck_assert_double_lt(share[1], 0.7 * share[0]);
}
END_TEST

/* work of each law, against the power of its force at every step */
START_TEST(a_block_dissipates_by_its_friction)
{
    const stein_model *model = &stein_model_block_on_slope;
    start(model, STEIN_RK4, 1e-5);
    ck_assert_stein(stein_run(sim, 0.3, err));
    stein_energy_total sum = total();
    double work = 0.0;
    for (int i = 0; i < model->ncontact; i++) {
        work += stein_balance_work(balance, STEIN_WORK_FRICTION, i) +
                stein_balance_work(balance, STEIN_WORK_NORMAL, i);
    }
    ck_assert_close(work, -sum.dissipated, 1e-12, 1e-15);
    ck_assert_close(sum.begin - sum.now, sum.dissipated + sum.stored, 1e-9, 1e-12);
    ck_assert(isnan(stein_balance_work(balance, STEIN_WORK_FRICTION, model->ncontact)));
    ck_assert(isnan(stein_balance_work(balance, STEIN_WORK_JOINT, -1)));
    ck_assert(isnan(stein_balance_work(balance, (stein_work_kind)7, 0)));
    stop();
}
END_TEST

/* a hook is work of others */
static void pull(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t, (void)q, (void)qd;
    Q[0] += *(double *)ctx;
}

START_TEST(a_hook_has_its_own_sum)
{
    double torque = 0.0385;
    start(&stein_model_pendulum, STEIN_DP5, 1e-3);
    stein_on_force(sim, pull, &torque);
    double q0 = stein_q(sim)[0];
    ck_assert_stein(stein_run(sim, 0.9, err));
    ck_assert_close(total().other, torque * (stein_q(sim)[0] - q0), 1e-10, 1e-14);
    ck_assert_close(total().unexplained, 0.0, 0.0, 1e-10);
    stop();
}
END_TEST

static void swing(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.01 * sin(31.7 * t) * t;
    u[1] = 0.01 * (sin(31.7 * t) + 31.7 * t * cos(31.7 * t));
    u[2] = 0.01 * (2.0 * 31.7 * cos(31.7 * t) - 31.7 * 31.7 * t * sin(31.7 * t));
}

START_TEST(a_prescribed_motion_does_the_work_of_its_force)
{
    const stein_model *model = &stein_model_stein1788;
    int input = -1;
    for (int i = 0; i < model->ninput; i++) {
        input = model->inputs[i].kind == STEIN_INPUT_MOTION ? i : input;
    }
    ck_assert_int_ge(input, 0);
    start(model, STEIN_CONTROLLED, 1e-4);
    ck_assert_stein(stein_drive(sim, model->inputs[input].name, swing, NULL, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_balance_attach(balance, sim, err));
    ck_assert_stein(stein_run(sim, 0.05, err));
    stein_energy_total sum = total();
    ck_assert_double_gt(fabs(stein_balance_work(balance, STEIN_WORK_INPUT, input)), 1e-5);
    ck_assert_close(sum.unexplained, 0.0, 0.0, 1e-6 * sum.scale);
    stop();
}
END_TEST

START_TEST(a_load_that_is_lifted_takes_its_energy_away)
{
    start(&stein_model_stein1788, STEIN_RK4, 1e-5);
    int load = stein_model_stein1788.load.body;
    ck_assert_stein(stein_run(sim, 0.03, err));
    double kinetic, potential, after, same;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
    ck_assert_double_gt(fabs(stein_qd(sim)[load]), 1e-3);
    stein_load_lift(sim);
    stein_energy(sim, stein_q(sim), stein_qd(sim), &after, &same);
    ck_assert_stein(stein_run(sim, 0.031, err));
    ck_assert_close(total().taken, kinetic - after, 1e-12, 0.0);
    stop();
}
END_TEST

/* One balance or sensitivity rides at a time; another mechanism is refused. */
START_TEST(sensitivities_and_balances_follow_one_at_a_time)
{
    stein_balance *other = NULL;
    stein_sim *pendulum = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_err why;
    start(&stein_model_bouncing_ball, STEIN_RK4, 1e-4);
    ck_assert_int_eq(stein_balance_attach(balance, pendulum, &why), STEIN_EINVAL);
    ck_assert_stein(stein_balance_create(&other, &stein_model_bouncing_ball, NULL, err));
    ck_assert_stein(stein_run(sim, 0.05, err));
    double before = total().now;
    ck_assert_stein(stein_balance_attach(other, sim, err)); // the first one gets off
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_double_eq(total().now, before);
    stein_sim_destroy(sim); // before its rider
    sim = NULL;
    stein_balance_destroy(other);
    stein_sim_destroy(pendulum);
    stop();
}
END_TEST

/* ---- steps of controlled error ---- */

START_TEST(controlled_steps_follow_a_stiff_contact)
{
    stein_sim *fine = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 2e-6);
    sim = make_sim(&stein_model_bouncing_ball, STEIN_CONTROLLED, 0.05); // 60 times the contact
    ck_assert_stein(stein_run(fine, 1.5, err));
    ck_assert_stein(stein_run(sim, 1.5, err));
    ck_assert_close(stein_q(sim)[0], stein_q(fine)[0], 0.0, 1e-8);
    stein_sim_destroy(fine);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(controlled_steps_depend_on_the_state_alone)
{
    const stein_model *model = &stein_model_stein1788;
    size_t size = sizeof(double) * (size_t)model->nq;
    stein_sim *other = make_sim(model, STEIN_CONTROLLED, 1e-4);
    sim = make_sim(model, STEIN_CONTROLLED, 1e-4);
    void *block = malloc(stein_state_size(sim));
    for (int i = 0; i < 300; i++) {
        ck_assert_stein(stein_step(sim, err));
    }
    stein_save(sim, block);
    ck_assert_stein(stein_restore(other, block, err));
    for (int i = 0; i < 300; i++) {
        ck_assert_stein(stein_step(sim, err));
        ck_assert_stein(stein_step(other, err));
    }
    ck_assert_mem_eq(stein_q(sim), stein_q(other), size);
    ck_assert_mem_eq(stein_qd(sim), stein_qd(other), size);
    free(block);
    stein_sim_destroy(other);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_batch_takes_them_as_well)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    stein_batch *batch = NULL;
    stein_sim *in[4], *alone[4];
    double end[4];
    def.integrator = STEIN_CONTROLLED;
    def.dt = 1e-4;
    ck_assert_stein(stein_batch_create(&batch, model, &def, 4, 0, err));
    for (int i = 0; i < 4; i++) {
        in[i] = make_sim(model, STEIN_CONTROLLED, 1e-4);
        alone[i] = make_sim(model, STEIN_CONTROLLED, 1e-4);
        end[i] = 0.05 + 1e-3 * i;
        ck_assert_stein(stein_batch_put(batch, i, in[i], err));
    }
    ck_assert_stein(stein_batch_run(batch, end, NULL, err));
    for (int i = 0; i < 4; i++) {
        ck_assert_stein(stein_batch_put(batch, i, NULL, err));
        ck_assert_stein(stein_run(alone[i], end[i], err));
        ck_assert_mem_eq(stein_q(in[i]), stein_q(alone[i]), sizeof(double) * (size_t)model->nq);
        stein_sim_destroy(in[i]);
        stein_sim_destroy(alone[i]);
    }
    stein_batch_destroy(batch);
}
END_TEST

START_TEST(a_tolerance_is_a_positive_number)
{
    stein_err why;
    double q[2];
    const double tolerance[] = {1e-6, 1e-11};
    for (int i = 0; i < 2; i++) {
        sim = make_sim(&stein_model_double_pendulum, STEIN_CONTROLLED, 0.5);
        ck_assert_int_eq(stein_set_tolerance(sim, 0.0, &why), STEIN_EINVAL);
        ck_assert_int_eq(stein_set_tolerance(sim, NAN, &why), STEIN_EINVAL);
        ck_assert_int_eq(stein_set_tolerance(sim, INFINITY, &why), STEIN_EINVAL);
        ck_assert_stein(stein_set_tolerance(sim, tolerance[i], err));
        ck_assert_stein(stein_run(sim, 1.0, err));
        q[i] = stein_q(sim)[1];
        stein_sim_destroy(sim);
    }
    ck_assert_double_gt(fabs(q[0] - q[1]), 1e-9);
    ck_assert_double_lt(fabs(q[0] - q[1]), 1e-3);
}
END_TEST

Suite *balance_suite(void)
{
    Suite *suite = suite_create("balance");
    TCase *energies = tcase_create("energies"), *steps = tcase_create("controlled steps");
    tcase_add_loop_test(energies, a_motion_keeps_its_bits, 0, 3);
    tcase_add_test(energies, what_is_read_is_at_the_end_of_the_last_step);
    tcase_add_test(energies, all_energy_of_a_stroke_is_explained);
    tcase_add_test(energies, a_block_dissipates_by_its_friction);
    tcase_add_test(energies, a_hook_has_its_own_sum);
    tcase_add_test(energies, a_prescribed_motion_does_the_work_of_its_force);
    tcase_add_test(energies, a_load_that_is_lifted_takes_its_energy_away);
    tcase_add_test(energies, sensitivities_and_balances_follow_one_at_a_time);
    tcase_add_test(steps, controlled_steps_follow_a_stiff_contact);
    tcase_add_test(steps, controlled_steps_depend_on_the_state_alone);
    tcase_add_test(steps, a_batch_takes_them_as_well);
    tcase_add_test(steps, a_tolerance_is_a_positive_number);
    suite_add_tcase(suite, energies);
    suite_add_tcase(suite, steps);
    return suite;
}
