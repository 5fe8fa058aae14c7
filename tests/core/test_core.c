/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_core.c - the public interface of a simulation: names, errors, hooks, inputs, equations.
 */
#include <malloc.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "stein/identity.h"
#include "sanitized.h"
#include "support.h"

START_TEST(a_simulation_is_one_allocation_and_stepping_none)
{
    int live = 0;
    stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
    def.alloc = count_alloc;
    def.release = count_release;
    def.ctx = &live;
    stein_sim *sim;
    ck_assert_stein(stein_sim_create(&sim, &stein_model_stein1788, &def, err));
    ck_assert_int_eq(live, 1);
    size_t before = SANITIZED ? 0 : mallinfo2().uordblks; // a sanitizer has its own heap
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.137e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(live, 1);
    ck_assert(SANITIZED || mallinfo2().uordblks == before);
    stein_sim_destroy(sim);
    ck_assert_int_eq(live, 0);
    stein_sim_destroy(NULL);
}
END_TEST

START_TEST(creation_refuses_invalid_fields_by_name)
{
    static const struct {
        const char *field;
        double dt;
        int integrator;
    } bad[] = {{"dt", 0.0, 0},
               {"dt", -1e-5, 0},
               {"dt", NAN, 0},
               {"dt", INFINITY, 0},
               {"integrator", 1e-5, 7}};
    stein_sim *sim = NULL;
    stein_err failure;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        stein_sim_def def = stein_sim_def_default(&stein_model_pendulum);
        def.dt = bad[i].dt;
        def.integrator = (stein_integrator)bad[i].integrator;
        ck_assert_int_eq(stein_sim_create(&sim, &stein_model_pendulum, &def, &failure),
                         STEIN_EINVAL);
        ck_assert_int_eq(failure.code, STEIN_EINVAL);
        ck_assert_msg(strstr(failure.msg, bad[i].field) != NULL, "%s", failure.msg);
    }
    stein_sim_def def = stein_sim_def_default(&stein_model_pendulum);
    def.release = NULL;
    ck_assert_int_eq(stein_sim_create(&sim, &stein_model_pendulum, &def, &failure), STEIN_EINVAL);
    ck_assert(strstr(failure.msg, "release") != NULL);
    def = stein_sim_def_default(&stein_model_pendulum);
    def.alloc = no_memory;
    ck_assert_int_eq(stein_sim_create(&sim, &stein_model_pendulum, &def, &failure), STEIN_ENOMEM);
    stein_model old = stein_model_pendulum;
    old.abi = STEIN_MODEL_ABI + 1;
    ck_assert_int_eq(stein_sim_create(&sim, &old, NULL, &failure), STEIN_ESTALE);
    ck_assert(strstr(failure.msg, "regenerate") != NULL);
    ck_assert_ptr_null(sim);
}
END_TEST

START_TEST(headers_and_library_have_the_same_version)
{
    char parts[32];
    snprintf(parts, sizeof parts, "%d.%d.%d", STEIN_VERSION_MAJOR, STEIN_VERSION_MINOR,
             STEIN_VERSION_PATCH);
    ck_assert_str_eq(STEIN_VERSION, parts);
    ck_assert_str_eq(stein_version(), STEIN_VERSION);
}
END_TEST

START_TEST(parameters_are_set_and_read_by_name)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_ptr_eq(stein_sim_model(sim), &stein_model_stein1788);
    static const char *const names[] = {"pawl.stop_shift",    "pawl.notch_angle", "pawl.spring.k",
                                        "pawl.spring.theta0", "load.mass",        "hammer.mass",
                                        "key.mass",           "string.height"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        double value, back;
        ck_assert_stein(stein_get(sim, names[i], &value, err));
        ck_assert_stein(stein_set(sim, names[i], 1.0137 * value + 1e-6, err));
        ck_assert_stein(stein_get(sim, names[i], &back, err));
        ck_assert(back == 1.0137 * value + 1e-6);
    }
    stein_err failure;
    double untouched = 0.125;
    ck_assert_int_eq(stein_set(sim, "pawl.stop_shfit", 0.0, &failure), STEIN_ENAME);
    ck_assert(strstr(failure.msg, "pawl.stop_shfit") != NULL);
    ck_assert_int_eq(stein_get(sim, "nothing", &untouched, &failure), STEIN_ENAME);
    ck_assert(untouched == 0.125);
    ck_assert_int_eq(stein_set(sim, "load.mass", NAN, &failure), STEIN_EINVAL);

    int np = stein_model_stein1788.np;
    double *p = malloc(sizeof *p * (size_t)np);
    for (int i = 0; i < np; i++) {
        p[i] = stein_model_stein1788.params[i].value;
    }
    ck_assert_stein(stein_set_all(sim, p, err));
    p[np - 1] = INFINITY;
    ck_assert_int_eq(stein_set_all(sim, p, &failure), STEIN_EINVAL);
    ck_assert(strstr(failure.msg, stein_model_stein1788.params[np - 1].name) != NULL);
    free(p);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(names_are_found_or_minus_one)
{
    const stein_model *m = &stein_model_stein1788;
    ck_assert_int_ge(stein_find_param(m, "hammer.mass"), 0);
    ck_assert_int_eq(stein_find_param(m, "hammer.maas"), -1);
    ck_assert_int_eq(stein_find_channel(m, "time"), 0);
    ck_assert_int_eq(stein_find_channel(m, "tide"), -1);
    ck_assert_int_ge(stein_find_contact(m, "string"), 0);
    ck_assert_int_eq(stein_find_contact(m, ""), -1);
    ck_assert_int_ge(stein_find_body(m, "pawl"), 0);
    ck_assert_int_eq(stein_find_body(m, "frame"), -1);
    ck_assert_int_ge(stein_find_input(m, "key_motion"), 0);
    ck_assert_int_eq(stein_find_input(m, "key"), -1);
}
END_TEST

START_TEST(every_channel_of_every_model_reads_a_number)
{
    for (int k = 0; stein_models[k] != NULL; k++) {
        stein_sim *sim = make_sim(stein_models[k], STEIN_RK4, 0.0);
        for (int i = 0; i < stein_models[k]->nchannel; i++) {
            const stein_channel *channel = &stein_models[k]->channels[i];
            double value;
            ck_assert_msg(isfinite(stein_read(sim, i)), "%s: %s", stein_models[k]->name,
                          channel->name);
            ck_assert_stein(stein_read_name(sim, channel->name, &value, err));
            if (channel->from_rest) {
                ck_assert(value == 0.0);
            }
        }
        ck_assert(isnan(stein_read(sim, -1)) && isnan(stein_read(sim, stein_models[k]->nchannel)));
        ck_assert_int_eq(stein_read_name(sim, "no_such", NULL, NULL), STEIN_ENAME);
        stein_sim_destroy(sim);
    }
}
END_TEST

static void push(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t;
    (void)q;
    (void)qd;
    Q[0] += *(double *)ctx;
}

START_TEST(the_force_hook_adds_to_Q)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    double q = 0.317, qd = 0.0, free_qdd, qdd, M, c, torque = 0.0237;
    ck_assert_stein(stein_acceleration(sim, 0.0, &q, &qd, &free_qdd, err));
    stein_on_force(sim, push, &torque);
    ck_assert_stein(stein_acceleration(sim, 0.0, &q, &qd, &qdd, err));
    stein_mass_bias(sim, &q, &qd, NULL, NULL, &M, &c);
    ck_assert_close(qdd - free_qdd, torque / M, 1e-12, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_state_that_leaves_the_numbers_stops_with_time_and_joint)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    double bad = NAN;
    double t = stein_time(sim), q = stein_q(sim)[0];
    stein_err failure = {STEIN_OK, ""};
    stein_on_force(sim, push, &bad);
    ck_assert_int_eq(stein_step(sim, &failure), STEIN_ENONFINITE);
    ck_assert(strstr(failure.msg, stein_model_pendulum.bodies[0].name) != NULL);
    ck_assert(strstr(failure.msg, "t = ") != NULL);
    ck_assert(stein_time(sim) == t && stein_q(sim)[0] == q); // kept for inspection
    ck_assert_int_eq(stein_set_state(sim, 0.0, &bad, &q, &failure), STEIN_EINVAL);
    ck_assert_int_eq(stein_reset(sim, &failure), STEIN_ENONFINITE);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_singular_mass_matrix_is_named_not_divided_by)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "ball.mass", 0.0, err));
    stein_err failure = {STEIN_OK, ""};
    ck_assert_int_eq(stein_step(sim, &failure), STEIN_ESINGULAR);
    ck_assert(strstr(failure.msg, "ball") != NULL);
    double q = 1.0, qd = 0.0, qdd;
    ck_assert_int_eq(stein_acceleration(sim, 0.0, &q, &qd, &qdd, &failure), STEIN_ESINGULAR);
    ck_assert_ptr_null(stein_qdd(sim));
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(no_equilibrium_is_an_error_not_a_guess)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "gravity.z", 9.81, err)); // everything falls up: the key leaves
    ck_assert_stein(stein_set(sim, "pawl.spring.k", -0.5, err)); // and a spring that runs away
    stein_err failure = {STEIN_OK, ""};
    stein_status status = stein_reset(sim, &failure);
    ck_assert_msg(status == STEIN_ESETTLE, "%d %s", (int)status, failure.msg);
    ck_assert(strstr(failure.msg, "equilibrium") != NULL);
    stein_sim_destroy(sim);
}
END_TEST

typedef struct sine {
    double a, w;
} sine;

static void sine_signal(void *ctx, double t, double u[3])
{
    const sine *s = ctx;
    u[0] = s->a * sin(s->w * t);
    u[1] = s->a * s->w * cos(s->w * t);
    u[2] = -s->a * s->w * s->w * sin(s->w * t);
}

START_TEST(a_prescribed_joint_follows_its_signal_and_gives_the_force)
{
    // drive the key of the action downwards and compare the force with inverse dynamics of the tree
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    sine s = {0.011, 23.0};
    stein_load_lift(sim);
    ck_assert_stein(stein_drive(sim, "key_motion", sine_signal, &s, err));
    int key = stein_find_body(&stein_model_stein1788, "key");
    ck_assert_stein(stein_run(sim, 0.0217, err));
    double u[3];
    sine_signal(&s, stein_time(sim), u);
    ck_assert(stein_q(sim)[key] == u[0]);
    ck_assert(stein_qd(sim)[key] == u[1]);
    ck_assert_close(stein_qdd(sim)[key], u[2], 1e-12, 0.0);

    // the same motion without prescription, the needed force applied by the hook: same acceleration
    double needed, qdd[8];
    ck_assert_stein(stein_read_name(sim, "key_force", &needed, err));
    memcpy(qdd, stein_qdd(sim), sizeof *qdd * (size_t)stein_model_stein1788.nq);
    ck_assert_stein(stein_drive(sim, "key_motion", NULL, NULL, err));
    ck_assert_int_eq(key, 0);
    stein_on_force(sim, push, &needed);
    for (int j = 0; j < stein_model_stein1788.nq; j++) {
        ck_assert_close(stein_qdd(sim)[j], qdd[j], 1e-9, 1e-6);
    }
    ck_assert_int_eq(stein_drive(sim, "no_input", sine_signal, &s, NULL), STEIN_ENAME);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(an_instrument_distorts_by_its_formula_and_not_by_default)
{
    const stein_model *m = &stein_model_stein1788;
    stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
    double y, rest, x, x0, measured;
    ck_assert_stein(stein_read_name(sim, "string_distance", &rest, err));
    double q[8], points[3 * 64];
    int head = -1;
    for (int i = 0; i < m->npoint; i++) {
        head = strcmp(m->points[i].name, "hammer.head") == 0 ? i : head;
    }
    memcpy(q, stein_q(sim), sizeof *q * (size_t)m->nq);
    stein_points(sim, q, stein_qd(sim), points, NULL, NULL, NULL);
    x0 = points[3 * head];
    ck_assert_stein(stein_run(sim, 0.031, err));
    ck_assert_stein(stein_read_name(sim, "string_distance", &y, err));
    stein_points(sim, stein_q(sim), stein_qd(sim), points, NULL, NULL, NULL);
    x = points[3 * head];
    ck_assert_stein(stein_set(sim, "string_distance.sensor.gain", 1.031, err));
    ck_assert_stein(stein_set(sim, "string_distance.sensor.offset", 0.73e-3, err));
    ck_assert_stein(stein_set(sim, "string_distance.sensor.square", 2.9, err));
    ck_assert_stein(stein_set(sim, "string_distance.sensor.tilt", 0.017, err));
    ck_assert_stein(stein_read_name(sim, "string_distance", &measured, err));
    ck_assert_close(measured,
                    1.031 * y + 0.73e-3 + 2.9 * (y - rest) * (y - rest) + 0.017 * (x - x0), 1e-12,
                    0.0);
    ck_assert(fabs(x - x0) > 1e-3);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(an_input_has_a_gain_and_a_delay)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    sine s = {0.011, 23.0};
    int key = stein_find_body(&stein_model_stein1788, "key");
    double u[3], gain = 1.07, delay = 0.0031;
    stein_load_lift(sim);
    ck_assert_stein(stein_set(sim, "key_motion.gain", gain, err));
    ck_assert_stein(stein_set(sim, "key_motion.delay", delay, err));
    ck_assert_stein(stein_drive(sim, "key_motion", sine_signal, &s, err));
    ck_assert_stein(stein_run(sim, 0.0173, err));
    sine_signal(&s, 0.0173 - delay, u);
    ck_assert(stein_q(sim)[key] == gain * u[0]);
    ck_assert(stein_qd(sim)[key] == gain * u[1]);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_worn_contact_begins_later_by_its_gap)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    double before, after;
    ck_assert_stein(stein_read_name(sim, "string_distance", &before, err));
    ck_assert_stein(stein_set(sim, "string.gap", 0.37e-3, err));
    ck_assert_stein(stein_read_name(sim, "string_distance", &after, err));
    ck_assert_close(after, before + 0.37e-3, 1e-12, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(equations_agree_with_each_other_through_the_interface)
{
    unsigned long long seed = 20240607;
    for (int k = 0; stein_models[k] != NULL; k++) {
        const stein_model *m = stein_models[k];
        stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
        double q[64], qd[64], qdd[64], frc[192], trq[192], M[64 * 64], c[64], Q[64];
        for (int j = 0; j < m->nq; j++) {
            q[j] = noise(&seed);
            qd[j] = noise(&seed);
            qdd[j] = noise(&seed);
        }
        for (int j = 0; j < 3 * m->nq; j++) {
            frc[j] = noise(&seed);
            trq[j] = noise(&seed);
        }
        stein_mass_bias(sim, q, qd, frc, trq, M, c);
        stein_inverse(sim, q, qd, qdd, frc, trq, Q);
        for (int i = 0; i < m->nq; i++) {
            double sum = c[i], scale = fabs(c[i]);
            for (int j = 0; j < m->nq; j++) {
                sum += M[i * m->nq + j] * qdd[j];
                scale = fmax(scale, fabs(M[i * m->nq + j]));
                ck_assert(M[i * m->nq + j] == M[j * m->nq + i]);
            }
            ck_assert_close(Q[i], sum, 1e-12, 1e-12 * scale);
        }
        stein_sim_destroy(sim);
    }
}
END_TEST

START_TEST(points_move_by_their_jacobian)
{
    const stein_model *m = &stein_model_stein1788;
    stein_sim *sim = make_sim(m, STEIN_RK4, 0.0);
    unsigned long long seed = 77;
    double q[8], qd[8], qp[8], qm[8], h = 1e-6;
    for (int j = 0; j < m->nq; j++) {
        q[j] = 0.3 * noise(&seed);
        qd[j] = noise(&seed);
        qp[j] = q[j] + h * qd[j];
        qm[j] = q[j] - h * qd[j];
    }
    int n = 3 * m->npoint;
    double *x = malloc(sizeof *x * (size_t)(n * (6 + m->nq)));
    double *v = x + n, *a = v + n, *xp = a + n, *xm = xp + n, *J = xm + n;
    stein_points(sim, q, qd, x, v, J, a);
    stein_points(sim, qp, qd, xp, NULL, NULL, NULL);
    stein_points(sim, qm, qd, xm, NULL, NULL, NULL);
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int j = 0; j < m->nq; j++) {
            sum += J[i * m->nq + j] * qd[j];
        }
        ck_assert_close(v[i], sum, 1e-12, 1e-15);
        ck_assert_close(v[i], (xp[i] - xm[i]) / (2.0 * h), 1e-8, 1e-9);
        ck_assert_close(a[i], (xp[i] - 2.0 * x[i] + xm[i]) / (h * h), 1e-3, 1e-3);
    }
    free(x);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_large_tree_is_solved_along_its_branches)
{
    enum { N = 30 };
    double M[N * N] = {0}, kept[N * N], x[N], b[N], inverse[N];
    int parent[N];
    unsigned long long seed = 30;
    for (int i = 0; i < N; i++) {
        parent[i] = i % 3 == 0 ? i - 1 : i - 2; // a trunk and twigs
        M[i * N + i] = N + noise(&seed);
        x[i] = b[i] = noise(&seed);
        for (int j = parent[i]; j >= 0; j = parent[j]) {
            M[i * N + j] = M[j * N + i] = noise(&seed);
        }
    }
    memcpy(kept, M, sizeof kept);
    ck_assert_int_eq(stein__solve(N, parent, M, x, inverse), -1);
    for (int i = 0; i < N; i++) {
        double sum = 0.0;
        for (int j = 0; j < N; j++) {
            sum += kept[i * N + j] * x[j];
        }
        ck_assert_close(sum, b[i], 0.0, 1e-14);
    }
    kept[7 * N + 7] = 0.0;
    ck_assert_int_eq(stein__solve(N, parent, kept, x, inverse), 7);
}
END_TEST

START_TEST(compiled_later_equations_are_checked_before_use)
{
    stein_library *library = NULL;
    const stein_model *model = NULL;
    stein_err failure;
    ck_assert_int_eq(stein_library_open(&library, "/no/such.so", "x", NULL, &model, &failure),
                     STEIN_ELOAD);
    ck_assert(strstr(failure.msg, "/no/such.so") != NULL);
    char long_name[80];
    memset(long_name, 'a', 79);
    long_name[79] = '\0';
    ck_assert_int_eq(stein_library_open(&library, "/no/such.so", long_name, NULL, &model, &failure),
                     STEIN_EINVAL);
    ck_assert_ptr_null(library);
    stein_library_close(NULL);
}
END_TEST

/* `make golden` accepts other bits, once it is known why they are others */
START_TEST(the_bits_are_those_that_were_accepted)
{
    char accepted[40] = "", now[40];
    unsigned long long hash;
    FILE *f = fopen("tests/golden/hash", "r");
    ck_assert(f != NULL && fgets(accepted, sizeof accepted, f) != NULL);
    fclose(f);
    ck_assert_stein(stein_identity(stein_models, &hash, err));
    snprintf(now, sizeof now, "core  %016llx\n", hash);
    ck_assert_str_eq(now, accepted);
}
END_TEST

Suite *core_suite(void)
{
    Suite *suite = suite_create("core");
    TCase *tc = tcase_create("core");
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_simulation_is_one_allocation_and_stepping_none);
    tcase_add_test(tc, the_bits_are_those_that_were_accepted);
    tcase_add_test(tc, creation_refuses_invalid_fields_by_name);
    tcase_add_test(tc, headers_and_library_have_the_same_version);
    tcase_add_test(tc, parameters_are_set_and_read_by_name);
    tcase_add_test(tc, names_are_found_or_minus_one);
    tcase_add_test(tc, every_channel_of_every_model_reads_a_number);
    tcase_add_test(tc, the_force_hook_adds_to_Q);
    tcase_add_test(tc, a_state_that_leaves_the_numbers_stops_with_time_and_joint);
    tcase_add_test(tc, a_singular_mass_matrix_is_named_not_divided_by);
    tcase_add_test(tc, no_equilibrium_is_an_error_not_a_guess);
    tcase_add_test(tc, a_prescribed_joint_follows_its_signal_and_gives_the_force);
    tcase_add_test(tc, an_instrument_distorts_by_its_formula_and_not_by_default);
    tcase_add_test(tc, an_input_has_a_gain_and_a_delay);
    tcase_add_test(tc, a_worn_contact_begins_later_by_its_gap);
    tcase_add_test(tc, equations_agree_with_each_other_through_the_interface);
    tcase_add_test(tc, points_move_by_their_jacobian);
    tcase_add_test(tc, a_large_tree_is_solved_along_its_branches);
    tcase_add_test(tc, compiled_later_equations_are_checked_before_use);
    suite_add_tcase(suite, tc);
    return suite;
}
