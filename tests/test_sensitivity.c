/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_sensitivity.c - sensitivities of motions against closed forms and against differences of
 * motions, through touch-down, lift-off and escapement.
 */
#include <string.h>

#include "derivative_support.h"

/* a motion as a function of one number: its state at the end, and when it switched last */
typedef struct stroke {
    const stein_model *model;
    stein_integrator integrator;
    double dt, end, q[MOST], qd[MOST], instant;
    int param; /* -1: *moved is a number of q or qd */
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
        ck_assert_stein(stein_set_state(sim, 0.0, k->q, k->qd, err));
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
    stein_sensitivity_set(s, 1, way, way + n, k->param >= 0 ? p : NULL);
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

static void check_stroke(stroke *k, const char *what, double at, double h, int numbers, double rtol)
{
    double is[2 * MOST + 1], expected[2 * MOST + 1], size = 0.0;
    sensitivity_of(k, is);
    differences(end_of, k, at, h, numbers, expected);
    for (int i = 0; i < numbers; i++) {
        size = fmax(size, fabs(expected[i]));
    }
    for (int i = 0; i < numbers; i++) {
        printf("    %-24s %d: %.10g, by differences %.10g\n", what, i, is[i], expected[i]);
    }
    for (int i = 0; i < numbers; i++) {
        ck_assert_msg(fabs(is[i] - expected[i]) <= rtol * fabs(expected[i]) + 1e-3 * rtol * size,
                      "%s, %d: %.12g, by differences %.12g", what, i, is[i], expected[i]);
    }
}

static stroke stroke_of(const stein_model *model, stein_integrator integrator, double dt, double end)
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
    stroke k = stroke_of(model, STEIN_RK4, 1e-5, 0.6);
    k.kind = STEIN_EVENT_CONTACT_END;
    k.moved = &k.q[0];
    check_stroke(&k, "height", k.q[0], 1e-5, 2, 1e-5);
}
END_TEST

START_TEST(the_action_strikes)
{
    static const char *const by[] = {"pawl.stop_shift", "hammer.mass", "notch.friction.A",
                                     "string.normal.c", "pawl.spring.k", "hammer.centre.x"};
    const stein_model *model = &stein_model_stein1788;
    static const double end[] = {0.02, 0.035, 0.06};
    stroke k = stroke_of(model, STEIN_RK4, 0.0, end[_i]);
    k.kind = STEIN_EVENT_ESCAPEMENT;
    for (size_t i = 0; i < sizeof by / sizeof *by; i++) {
        double value = value_of(model, k.param = stein_find_param(model, by[i]));
        check_stroke(&k, by[i], value, value != 0.0 ? 1e-4 * fabs(value) : 1e-7, 8, 1e-3);
    }
}
END_TEST

Suite *sensitivity_suite(void)
{
    Suite *suite = suite_create("sensitivity");
    TCase *motions = tcase_create("motions");
    tcase_add_loop_test(motions, a_swing_is_derived_to_rounding, 0, 2);
    tcase_add_test(motions, a_ball_bounces);
    tcase_add_loop_test(motions, the_action_strikes, 0, 3);
    tcase_set_timeout(motions, 60);
    suite_add_tcase(suite, motions);
    return suite;
}
