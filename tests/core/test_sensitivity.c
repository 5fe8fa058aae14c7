/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_sensitivity.c - sensitivities of motions against closed forms and against differences of
 * motions, through touch-down, lift-off and escapement.
 */
#include <string.h>

#include "derivative_support.h"
#include "stein/batch.h"

/* a motion as a function of one number: its state at the end, and when it switched last */
typedef struct stroke {
    const stein_model *model;
    stein_integrator integrator;
    double dt, end, q[MOST], qd[MOST], instant;
    int param;   /* -1: *moved is a number of q or qd */
    int settles; /* 1: from the equilibrium of the parameters */
    double *moved;
    stein_event_kind kind;
} stroke;

static void note(void *ctx, stein_sim *sim, const stein_event *event)
{
    stroke *k = ctx;
    (void)sim;
    if (event->kind == k->kind) {
        k->instant = event->time;
    }
}

/* a simulation at the beginning of the motion */
static stein_sim *begin(stroke *k)
{
    stein_sim *sim = make_sim(k->model, k->integrator, k->dt);
    k->instant = 0.0;
    stein_on_event(sim, note, k);
    ck_assert_stein(stein_set_state(sim, 0.0, k->q, k->qd, err));
    return sim;
}

static void end_of(void *ctx, double x, double *y)
{
    stroke *k = ctx;
    int n = k->model->nq;
    double kept = k->moved != NULL ? *k->moved : 0.0;
    if (k->moved != NULL) {
        *k->moved = x;
    }
    stein_sim *sim = begin(k);
    if (k->param >= 0) {
        ck_assert_stein(stein_set(sim, k->model->params[k->param].name, x, err));
        ck_assert_stein(k->settles ? stein_reset(sim, err)
                                   : stein_set_state(sim, 0.0, k->q, k->qd, err));
    }
    ck_assert_stein(stein_run(sim, k->end, err));
    memcpy(y, stein_q(sim), sizeof *y * (size_t)n);
    memcpy(y + n, stein_qd(sim), sizeof *y * (size_t)n);
    y[2 * n] = k->instant;
    stein_sim_destroy(sim);
    if (k->moved != NULL) {
        *k->moved = kept;
    }
}

/* the same by sensitivities: q, qd and the instant of the last switch */
static void sensitivity_of(stroke *k, double *y)
{
    int n = k->model->nq;
    double way[2 * MOST] = {0.0}, p[512] = {0.0};
    stein_sensitivity *s = NULL;
    stein_sim *sim = begin(k);
    ck_assert_stein(stein_sensitivity_create(&s, k->model, NULL, 2, err));
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    if (k->param >= 0) {
        p[k->param] = 1.0;
    } else {
        way[k->moved >= k->qd && k->moved < k->qd + n ? n + (k->moved - k->qd) : k->moved - k->q] =
            1.0;
    }
    if (k->settles) {
        ck_assert_stein(stein_reset(sim, err));
        ck_assert_stein(stein_sensitivity_start(s, 1, p, err));
    } else {
        stein_sensitivity_set(s, 1, way, way + n, k->param >= 0 ? p : NULL);
    }
    ck_assert_stein(stein_run(sim, k->end, err));
    ck_assert_stein(stein_sensitivity_check(s, err));
    memcpy(y, stein_sensitivity_q(s, 1), sizeof *y * (size_t)n);
    memcpy(y + n, stein_sensitivity_qd(s, 1), sizeof *y * (size_t)n);
    y[2 * n] = stein_sensitivity_switch(s, 1);
    for (int j = 0; j < n; j++) {
        ck_assert(stein_sensitivity_q(s, 0)[j] == 0.0); // the direction that is not used
    }
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
}

static double worst; /* of the size of all numbers of a motion */

static void check_stroke(stroke *k, const char *what, double at, double h, int numbers, double rtol)
{
    double is[2 * MOST + 1], expected[2 * MOST + 1], size = 0.0, rounding = 1e-13 / h;
    sensitivity_of(k, is);
    differences(end_of, k, at, h, numbers, expected);
    for (int i = 0; i < numbers; i++) {
        size = fmax(size, fabs(expected[i]));
    }
    for (int i = 0; i < numbers; i++) {
        double off = fabs(is[i] - expected[i]);
        double bound = rtol * fabs(expected[i]) + 0.01 * rtol * size + rounding;
        ck_assert_msg(off <= bound, "%s, %d: %.12g, by differences %.12g", what, i, is[i],
                      expected[i]);
        worst = size > 0.0 ? fmax(worst, (off - rounding) / size) : worst;
    }
}

static stroke stroke_of(const stein_model *model, stein_integrator integrator, double dt,
                        double end)
{
    stroke k = {.model = model, .integrator = integrator, .dt = dt, .end = end, .param = -1};
    stein_sim *sim = make_sim(model, integrator, dt);
    ck_assert(model->nq <= MOST / 2 && model->np <= 512);
    memcpy(k.q, stein_q(sim), sizeof *k.q * (size_t)model->nq);
    memcpy(k.qd, stein_qd(sim), sizeof *k.qd * (size_t)model->nq);
    stein_sim_destroy(sim);
    return k;
}

static double value_of(const stein_model *model, int param)
{
    return model->params[param].value;
}

/* no switch: to rounding, for both methods, by state and parameters */
START_TEST(a_swing_is_derived_to_rounding)
{
    const stein_model *model = &stein_model_double_pendulum;
    stroke k = stroke_of(model, _i == 0 ? STEIN_RK4 : STEIN_DP5, 1e-3, 0.3);
    k.q[0] = 0.7;
    k.qd[1] = -1.1;
    for (int j = 0; j < 2; j++) {
        k.moved = &k.q[j];
        check_stroke(&k, "q", k.q[j], 1e-3, 4, 1e-8);
        k.moved = &k.qd[j];
        check_stroke(&k, "qd", k.qd[j], 1e-3, 4, 1e-8);
    }
    k.moved = NULL;
    for (int i = 0; i < model->np; i++) {
        if (model->params[i].stated && model->params[i].value != 0.0) {
            k.param = i;
            check_stroke(&k, model->params[i].name, value_of(model, i),
                         1e-3 * fabs(value_of(model, i)), 4, 1e-7);
        }
    }
}
END_TEST

START_TEST(a_ball_bounces)
{
    const stein_model *model = &stein_model_bouncing_ball;
    stroke k = stroke_of(model, STEIN_RK4, 4e-6, 0.3);
    k.kind = STEIN_EVENT_CONTACT_END;
    k.moved = &k.q[0];
    check_stroke(&k, "height", k.q[0], 1e-5, 3, 1e-6);
    k.kind = STEIN_EVENT_CONTACT_BEGIN;
    k.end = 0.227; // while it touches
    check_stroke(&k, "height", k.q[0], 1e-5, 3, 1e-6);
    k.moved = &k.qd[0];
    check_stroke(&k, "speed", k.qd[0], 1e-5, 3, 1e-6);
    stein_sim *sim = begin(&k);
    double g = 0.0, gap;
    ck_assert_stein(stein_get(sim, "gravity.z", &g, err));
    ck_assert_stein(stein_read_name(sim, "floor_gap", &gap, err));
    double is[3], v = sqrt(-2.0 * g * gap);
    k.moved = &k.q[0];
    sensitivity_of(&k, is);
    ck_assert_close(is[2], 1.0 / v, 1e-9, 0.0); // of the time of touch-down by the height
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(the_action_strikes)
{
    static const char *const by[] = {"pawl.stop_shift", "hammer.mass",   "notch.friction.A",
                                     "loops.normal.c",  "pawl.spring.k", "hammer.centre.x",
                                     "rest.line.z",     "key.front.z"};
    const stein_model *model = &stein_model_stein1788;
    static const double end[] = {0.02, 0.035, 0.06};
    stroke k = stroke_of(model, STEIN_RK4, 0.0, end[_i]);
    k.kind = STEIN_EVENT_ESCAPEMENT;
    k.settles = _i > 0;
    // without settling the load, which lies flush, would be lifted off or pressed on by the last
    // one
    for (size_t i = 0; i < sizeof by / sizeof *by - (k.settles ? 0 : 1); i++) {
        double value = value_of(model, k.param = stein_find_param(model, by[i]));
        check_stroke(&k, by[i], value, value != 0.0 ? 1e-4 * fabs(value) : 1e-7, 8, 1e-5);
    }
    printf("sensitivities of a stroke of %g s: off differences by %.1g of their size at most\n",
           end[_i], worst);
}
END_TEST

static double nobody(void *ctx, stein_sim *sim)
{
    (void)sim;
    return *(double *)ctx += 1.3e-3;
}

/* steps of controlled error, with looks inside: the state at the end of the same steps */
START_TEST(they_ride_with_steps_of_controlled_error)
{
    const stein_model *model = &stein_model_stein1788;
    const int param = stein_find_param(model, "hammer.mass");
    double y[2][8], p[512] = {0.0};
    p[param] = 1.0;
    for (int i = 0; i < 2; i++) {
        stein_sim *sim = make_sim(model, STEIN_DP5, 0.0);
        stein_sensitivity *s = NULL;
        double look = 0.0;
        ck_assert_stein(stein_sensitivity_create(&s, model, NULL, 1, err));
        ck_assert_stein(stein_sensitivity_attach(s, sim, err));
        stein_sensitivity_set(s, 0, NULL, NULL, p);
        if (i == 0) {
            ck_assert_stein(stein_run(sim, 0.03, err));
        } else {
            stein_pace pace = {.tolerance = 1e-10,
                               .longest = 2e-3,
                               .h = 1e-5,
                               .next = 0.0,
                               .look = nobody,
                               .ctx = &look};
            ck_assert_stein(stein_run_adaptive(sim, 0.03, &pace, err));
        }
        ck_assert_stein(stein_sensitivity_check(s, err));
        memcpy(y[i], stein_sensitivity_q(s, 0), 4 * sizeof(double));
        memcpy(y[i] + 4, stein_sensitivity_qd(s, 0), 4 * sizeof(double));
        stein_sensitivity_destroy(s);
        stein_sim_destroy(sim);
    }
    for (int j = 0; j < 8; j++) {
        ck_assert_close(y[1][j], y[0][j], 1e-4, 1e-4 * fabs(y[0][j / 4 * 4 + 1]));
    }
}
END_TEST

/* a number that is turned while it moves: from then on directions belong to the new one; a motion
 * that begins there with the same direction is the reference */
START_TEST(parameters_may_change_on_the_way)
{
    const stein_model *model = &stein_model_double_pendulum;
    const int param = stein_find_param(model, "rod.length");
    double p[512] = {0.0}, value = 0.0, way[4], is[4], q[2] = {0.9, -0.4}, qd[2] = {0.3, 1.1};
    stein_sim *sim = make_sim(model, STEIN_RK4, 1e-3), *fresh = make_sim(model, STEIN_RK4, 1e-3);
    stein_sensitivity *s = NULL;
    p[param] = 1.0;
    ck_assert_stein(stein_sensitivity_create(&s, model, NULL, 1, err));
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    stein_sensitivity_set(s, 0, NULL, NULL, p);
    ck_assert_stein(stein_run(sim, 0.1, err));
    memcpy(way, stein_sensitivity_q(s, 0), 2 * sizeof *way);
    memcpy(way + 2, stein_sensitivity_qd(s, 0), 2 * sizeof *way);
    ck_assert_stein(stein_get(sim, model->params[param].name, &value, err));
    ck_assert_stein(stein_set(sim, model->params[param].name, 1.7 * value, err));
    ck_assert_stein(stein_set(fresh, model->params[param].name, 1.7 * value, err));
    ck_assert_stein(stein_set_state(fresh, 0.1, stein_q(sim), stein_qd(sim), err));
    ck_assert_stein(stein_run(sim, 0.2, err));
    memcpy(is, stein_sensitivity_q(s, 0), 2 * sizeof *is);
    memcpy(is + 2, stein_sensitivity_qd(s, 0), 2 * sizeof *is);
    ck_assert_stein(stein_sensitivity_attach(s, fresh, err));
    stein_sensitivity_set(s, 0, way, way + 2, p);
    ck_assert_stein(stein_run(fresh, 0.2, err));
    for (int j = 0; j < 2; j++) {
        ck_assert_close(stein_sensitivity_q(s, 0)[j], is[j], 1e-12, 1e-14);
        ck_assert_close(stein_sensitivity_qd(s, 0)[j], is[2 + j], 1e-12, 1e-14);
    }
    ck_assert(fabs(is[0]) + fabs(is[1]) > 0.0);
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
    stein_sim_destroy(fresh);
}
END_TEST

/* the motion and its outputs have the same bits as without sensitivity */
START_TEST(a_simulation_does_not_notice)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim *alone = make_sim(model, STEIN_RK4, 0.0), *ridden = make_sim(model, STEIN_RK4, 0.0);
    stein_sensitivity *s = NULL;
    int blocks = 0;
    stein_sim_def def = stein_sim_def_default(model);
    def.alloc = count_alloc;
    def.release = count_release;
    def.ctx = &blocks;
    ck_assert_stein(stein_sensitivity_create(&s, model, &def, 3, err));
    ck_assert_int_eq(blocks, 2);
    ck_assert_stein(stein_sensitivity_attach(s, ridden, err));
    for (double t = 0.005; t < 0.06; t += 0.005) {
        ck_assert_stein(stein_run(alone, t, err));
        ck_assert_stein(stein_run(ridden, t, err));
        ck_assert_mem_eq(stein_q(alone), stein_q(ridden), sizeof(double) * (size_t)model->nq);
        ck_assert_mem_eq(stein_qd(alone), stein_qd(ridden), sizeof(double) * (size_t)model->nq);
        for (int c = 0; c < model->nchannel; c++) {
            ck_assert(stein_read(alone, c) == stein_read(ridden, c));
        }
    }
    stein_sensitivity_destroy(s);
    ck_assert_int_eq(blocks, 0);
    ck_assert_stein(stein_run(ridden, 0.07, err)); // goes on alone
    stein_sim_destroy(alone);
    stein_sim_destroy(ridden);
}
END_TEST

static void hold(void *ctx, double t, double u[3])
{
    (void)ctx, (void)t;
    u[0] = 0.1;
}

static void hook(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q, (void)qd;
    Q[0] += 0.1;
}

START_TEST(simulations_that_cannot_be_followed_are_refused)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim *sim = make_sim(model, STEIN_RK4, 0.0);
    stein_sim *other = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_sensitivity *s = NULL;
    stein_sim_def def = stein_sim_def_default(model);
    stein_err e = {STEIN_OK, ""};
    def.alloc = no_memory;
    ck_assert_int_eq(stein_sensitivity_create(&s, model, NULL, 0, &e), STEIN_EINVAL);
    ck_assert_int_eq(stein_sensitivity_create(&s, model, &def, 1, &e), STEIN_ENOMEM);
    ck_assert_stein(stein_sensitivity_create(&s, model, NULL, 1, err));
    ck_assert_int_eq(stein_sensitivity_start(s, 0, &def.dt, &e), STEIN_EINVAL);
    ck_assert_int_eq(stein_sensitivity_attach(s, other, &e), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(e.msg, "other equations"));
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    ck_assert(stein_sensitivity_q(s, 1) == NULL && stein_sensitivity_qd(s, -1) == NULL);
    ck_assert(stein_sensitivity_switch(s, 7) == 0.0);
    stein_sensitivity_set(s, 1, NULL, NULL, NULL);
    stein_on_force(sim, hook, NULL);
    ck_assert_stein(stein_step(sim, err));
    ck_assert_int_eq(stein_sensitivity_check(s, &e), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(e.msg, "hook"));
    stein_on_force(sim, NULL, NULL);
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    ck_assert_stein(stein_sensitivity_check(s, err));
    ck_assert_stein(stein_drive(sim, "finger", hold, NULL, err));
    ck_assert_stein(stein_step(sim, err));
    ck_assert_int_eq(stein_sensitivity_check(s, &e), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(e.msg, "signal"));
    stein_sensitivity_destroy(s);
    stein_sensitivity_destroy(NULL);
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
}
END_TEST

/* a sensitivity detects the end of its simulation and its replacement; a model with more joints is
 * refused before its state is read */
START_TEST(a_detached_sensitivity_reports_it)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_sensitivity *first = NULL, *second = NULL, *small = NULL;
    stein_err e = {STEIN_OK, ""};
    ck_assert_stein(stein_sensitivity_create(&first, &stein_model_stein1788, NULL, 1, err));
    ck_assert_stein(stein_sensitivity_create(&second, &stein_model_stein1788, NULL, 1, err));
    ck_assert_stein(stein_sensitivity_create(&small, &stein_model_pendulum, NULL, 1, err));
    ck_assert_stein(stein_sensitivity_attach(first, sim, err));
    ck_assert_int_eq(stein_sensitivity_attach(small, sim, &e), STEIN_EINVAL);
    ck_assert_stein(stein_sensitivity_check(first, err)); // rides on
    ck_assert_stein(stein_sensitivity_attach(second, sim, err));
    ck_assert_int_eq(stein_sensitivity_check(first, &e), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(e.msg, "another one"));
    ck_assert_stein(stein_step(sim, err));
    ck_assert_stein(stein_sensitivity_check(second, err));
    stein_sensitivity_destroy(first); // nothing to do with the simulation any more
    ck_assert_stein(stein_step(sim, err));
    stein_sim_destroy(sim);
    ck_assert_int_eq(stein_sensitivity_check(second, &e), STEIN_EINVAL);
    ck_assert_int_eq(stein_sensitivity_start(second, 0, &(double){0.0}, &e), STEIN_EINVAL);
    stein_sensitivity_destroy(second);
    stein_sensitivity_destroy(small);
}
END_TEST

/* in a batch it is carried on as without: its simulation goes alone */
START_TEST(a_simulation_in_a_batch_is_ridden_with)
{
    const stein_model *model = &stein_model_stein1788;
    double p[512] = {0.0}, dq[2][3];
    p[stein_find_param(model, "hammer.mass")] = 1.0;
    for (int in_batch = 0; in_batch < 2; in_batch++) {
        stein_sim *sim[4];
        stein_batch *batch = NULL;
        stein_sensitivity *s = NULL;
        ck_assert_stein(stein_batch_create(&batch, model, NULL, 4, 0, err));
        for (int i = 0; i < 4; i++) {
            sim[i] = make_sim(model, STEIN_RK4, 0.0);
            ck_assert_stein(stein_batch_put(batch, i, sim[i], err));
        }
        ck_assert_stein(stein_sensitivity_create(&s, model, NULL, 1, err));
        ck_assert_stein(stein_sensitivity_attach(s, sim[2], err));
        stein_sensitivity_set(s, 0, NULL, NULL, p);
        const double t_end[4] = {0.01, 0.01, 0.01, 0.01};
        ck_assert_stein(in_batch ? stein_batch_run(batch, t_end, NULL, err)
                                 : stein_run(sim[2], 0.01, err));
        ck_assert_stein(stein_sensitivity_check(s, err));
        memcpy(dq[in_batch], stein_sensitivity_q(s, 0), sizeof dq[0]);
        ck_assert(dq[in_batch][1] != 0.0);
        stein_batch_destroy(batch);
        for (int i = 0; i < 4; i++) {
            stein_sim_destroy(sim[i]);
        }
        stein_sensitivity_destroy(s);
    }
    ck_assert(memcmp(dq[0], dq[1], sizeof dq[0]) == 0);
}
END_TEST

Suite *sensitivity_suite(void)
{
    Suite *suite = suite_create("sensitivity");
    TCase *motions = tcase_create("motions");
    tcase_add_loop_test(motions, a_swing_is_derived_to_rounding, 0, 2);
    tcase_add_test(motions, a_ball_bounces);
    tcase_add_loop_test(motions, the_action_strikes, 0, 3);
    tcase_add_test(motions, they_ride_with_steps_of_controlled_error);
    tcase_add_test(motions, parameters_may_change_on_the_way);
    tcase_add_test(motions, a_simulation_does_not_notice);
    tcase_add_test(motions, simulations_that_cannot_be_followed_are_refused);
    tcase_add_test(motions, a_detached_sensitivity_reports_it);
    tcase_add_test(motions, a_simulation_in_a_batch_is_ridden_with);
    tcase_set_timeout(motions, 60);
    suite_add_tcase(suite, motions);
    return suite;
}
