/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_linear_ways.c - exact derivatives and differences against each other on mechanisms drawn at
 * random, linkages against differences of closed positions, refusals, and unchanged simulations.
 */
#include "linear_support.h"

void linear_ways_cases(Suite *suite);

/* A hook that adds nothing: derivatives of hooks are not known, so the way is the other one. */
static void nothing(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q, (void)qd, (void)Q;
}

static void keep(double *to, const double *from, int n)
{
    memcpy(to, from, sizeof *to * (size_t)n);
}

enum { MOST = 16 }; /* coordinates, outputs */

/* A and C of both ways at the present state. @return the largest difference, each row in units of
 * its largest element */
static double ways_apart(linearised *x)
{
    double A[4 * MOST * MOST], C[2 * MOST * MOST], off = 0.0;
    linear_look(x);
    int n = 2 * x->s->n, ny = x->s->noutput;
    ck_assert(x->s->n <= MOST && ny <= MOST + 4);
    ck_assert_int_eq(x->s->exact, 1);
    ck_assert(x->s->error == 0.0 && x->s->why == NULL);
    keep(A, x->s->A, n * n);
    keep(C, x->s->C, ny * n);
    stein_on_force(x->sim, nothing, NULL);
    linear_look(x);
    ck_assert_int_eq(x->s->exact, 0);
    ck_assert_str_eq(x->s->why, "a hook adds forces");
    for (int i = 0; i < n + ny; i++) {
        const double *a = i < n ? A + i * n : C + (i - n) * n;
        const double *b = i < n ? x->s->A + i * n : x->s->C + (i - n) * n;
        double size = 1e-3; // outputs that hardly move
        for (int j = 0; j < n; j++) {
            size = fmax(size, fabs(a[j]));
        }
        for (int j = 0; j < n; j++) {
            off = fmax(off, fabs(a[j] - b[j]) / size);
        }
    }
    stein_on_force(x->sim, NULL, NULL);
    return off;
}

/* ---- mechanisms drawn at random ---- */

static double between(unsigned long long *seed, double from, double to)
{
    return from + 0.5 * (to - from) * (1.0 + noise(seed));
}

static void write_body(FILE *f, int i, int plane, unsigned long long *seed)
{
    char type = "RRT"[(int)between(seed, 0.0, 3.0)];
    char axis = plane ? "yxz"[type == 'T' ? 1 + (int)between(seed, 0.0, 2.0) : 0]
                      : "xyz"[(int)between(seed, 0.0, 3.0)];
    double inertia = between(seed, 1e-3, 4e-3);
    double c[3], p[3], at[3];
    for (int k = 0; k < 3; k++) {
        int out = plane && k == 1;
        c[k] = out ? 0.0 : between(seed, -0.1, 0.1);
        p[k] = out ? 0.0 : between(seed, -0.2, 0.2);
        at[k] = out ? 0.0 : between(seed, -0.2, 0.2);
    }
    fprintf(f, "  b%d:\n", i);
    if (i > 0) {
        fprintf(f, "    parent: b%d\n", (int)between(seed, 0.0, (double)i));
    }
    int back = noise(seed) > 0.0; // each draw by itself: arguments have no order
    double mass = between(seed, 0.1, 0.9), damping = between(seed, 0.01, 0.2);
    double k = between(seed, 20.0, 60.0), rest = between(seed, -0.2, 0.2);
    fprintf(f, "    joint: %c %s%c\n    at: [%g, %g, %g]\n    mass: %g\n", type, back ? "-" : "",
            axis, at[0], at[1], at[2], mass);
    fprintf(f, "    centre: [%g, %g, %g]\n    inertia: {xx: %g, yy: %g, zz: %g}\n", c[0], c[1],
            c[2], inertia, 1.2 * inertia, 0.9 * inertia);
    fprintf(f, "    points: {p: [%g, %g, %g]}\n    damping: %g\n", p[0], p[1], p[2], damping);
    fprintf(f, "    spring: {k: %g, %s: %g, k3: 3}\n", k, type == 'R' ? "theta0" : "x0", rest);
    fprintf(f, "    friction: {A: 0.01, vt: 0.3, B1: 0.4, B2: 0.1}\n");
}

/* n joints with springs, a link, a force at a point, in a plane also a contact */
static char *draw(int n, int plane, unsigned long long seed)
{
    char *text = NULL;
    FILE *f = lab__text_open(&text);
    ck_assert_ptr_nonnull(f);
    fprintf(f, "mechanism: drawn\nbodies:\n");
    for (int i = 0; i < n; i++) {
        write_body(f, i, plane, &seed);
    }
    fprintf(f,
            "points: {post: [0.3, 0, -0.4]}\n"
            "links: {tie: {from: frame.post, to: b%d.p, k: 30, length: 0.1, damping: 0.3}}\n",
            n - 1);
    if (plane) {
        fprintf(f,
                "contacts:\n  floor:\n    between: [{circle: {at: b%d.p, radius: 0.9}}, "
                "{line: {on: frame, at: [0, 0, -0.5], facing: 80 deg}}]\n"
                "    normal: {c: 90, b: 20, D: 0.5}\n    friction: {A: 0.3, vt: 0.1}\n",
                n / 2);
    }
    fprintf(f,
            "inputs:\n  push: {torque: b0}\n  pull: {force: b%d.p, direction: [0.6, 0, 0.8]}\n"
            "outputs:\n  x: {point: b%d.p, read: x}\n  v: {point: b%d.p, read: vz}\n"
            "  a: {joint: b0, read: acceleration}\n  energy: {energy: potential}\n",
            n - 1, n - 1, n - 1);
    ck_assert_int_eq(lab__text_close(f, &text, NULL), STEIN_OK);
    return text;
}

static void pull(void *ctx, double t, double u[3])
{
    (void)ctx, (void)t;
    u[0] = 1.7;
}

START_TEST(both_ways_agree_on_mechanisms_drawn_at_random)
{
    double worst = 0.0;
    for (int i = 0; i < 6; i++) {
        char *text = draw(2 + i, i % 2, 2385u + (unsigned)i);
        linearised x = linear_begin(text);
        ck_assert_stein(stein_drive(x.sim, "pull", pull, NULL, err)); // turns with the mechanism
        ck_assert_stein(stein_settle(x.sim, err));
        worst = fmax(worst, ways_apart(&x));
        if (i % 2 != 0) { // the contact takes part
            ck_assert_int_eq(stein_touches(x.sim, 0), 1);
        }
        linear_end(&x);
        free(text);
    }
    printf("linear: both ways differ by %.1g at most\n", worst);
    ck_assert_double_lt(worst, 1e-11);
}
END_TEST

START_TEST(both_ways_agree_on_piano_actions_with_their_felts)
{
    const stein_model *const model[] = {&stein_model_stein1788, &stein_model_grand_action};
    for (int i = 0; i < 2; i++) {
        linearised x = linear_built_in(model[i]);
        stein_load_lift(x.sim);
        ck_assert_stein(stein_settle(x.sim, err));
        linear_look(&x);
        ck_assert_int_gt(x.s->n, 1);
        ck_assert_double_lt(ways_apart(&x), 1e-7);
        linear_end(&x);
    }
}
END_TEST

/* k in a spring by a hook */
static void spring(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t, (void)qd;
    Q[0] -= *(const double *)ctx * q[0];
}

START_TEST(a_force_of_ones_own_acts_with_its_slope)
{
    linearised x = linear_built_in(&stein_model_pendulum);
    double zero = 0.0, k = 0.7;
    linear_put(&x, &zero, NULL);
    double expected = linear_A(&x, 1, 0) - k * x.s->B[1]; // B is 1/I
    stein_on_force(x.sim, spring, &k);
    linear_put(&x, &zero, NULL);
    ck_assert_close(linear_A(&x, 1, 0), expected, 1e-11, 0.0);
    linear_end(&x);
}
END_TEST

/* ---- loops ---- */

/* acceleration of the coordinate with the joints moved by `share` of T and closed again, and where
 * the coordinate is then */
static double beside(linearised *x, const double *q, double share, double *z)
{
    double at[MOST], qd[MOST] = {0.0}, qdd[MOST];
    int nq = stein_sim_model(x->sim)->nq, j = x->s->joint[0];
    for (int k = 0; k < nq; k++) {
        at[k] = q[k] + share * x->s->T[k];
    }
    ck_assert_stein(stein_set_state(x->sim, 0.0, at, qd, err));
    ck_assert_stein(stein_acceleration(x->sim, 0.0, stein_q(x->sim), qd, qdd, err));
    *z = stein_q(x->sim)[j];
    return qdd[j];
}

START_TEST(linkages_are_as_differences_of_closed_positions)
{
    const stein_model *const model[] = {&stein_model_four_bar, &stein_model_andrews,
                                        &stein_model_slider_crank};
    for (int i = 0; i < 3; i++) {
        linearised x = linear_built_in(model[i]);
        double q[MOST], slope[2];
        ck_assert_stein(stein_settle(x.sim, err));
        linear_look(&x);
        ck_assert_int_eq(x.s->n, 1);
        keep(q, stein_q(x.sim), model[i]->nq);
        for (int k = 0; k < 2; k++) {
            double h = 2e-4 * (k + 1), z[2];
            double right = beside(&x, q, h, &z[0]), left = beside(&x, q, -h, &z[1]);
            slope[k] = (right - left) / (z[0] - z[1]);
        }
        ck_assert_close((4.0 * slope[0] - slope[1]) / 3.0, linear_A(&x, 1, 0), 1e-6, 0.0);
        linear_end(&x);
    }
}
END_TEST

/* ---- unchanged simulations, omissions, refusals ---- */

START_TEST(nothing_of_the_simulation_changes)
{
    const stein_model *const model[] = {&stein_model_stein1788, &stein_model_four_bar,
                                        &stein_model_grand_action};
    for (int i = 0; i < 3; i++) {
        linearised x = linear_built_in(model[i]);
        stein_load_lift(x.sim);
        ck_assert_stein(stein_settle(x.sim, err));
        size_t size = stein_state_size(x.sim);
        unsigned char *before = malloc(size), *after = malloc(size);
        ck_assert(before != NULL && after != NULL);
        stein_save(x.sim, before);
        linear_look(&x);
        stein_save(x.sim, after);
        ck_assert_mem_eq(before, after, size);
        ck_assert_stein(stein_run(x.sim, 0.01, err));
        stein_save(x.sim, after);
        stein_sim *other = make_sim(model[i], STEIN_RK4, 0.0);
        stein_load_lift(other);
        ck_assert_stein(stein_restore(other, before, err));
        ck_assert_stein(stein_run(other, 0.01, err));
        stein_save(other, before);
        ck_assert_mem_eq(before, after, size);
        stein_sim_destroy(other);
        free(before);
        free(after);
        linear_end(&x);
    }
}
END_TEST

START_TEST(a_joint_that_sticks_does_not_move)
{
    linearised x = linear_begin(
        "mechanism: held\n"
        "bodies:\n"
        "  arm: {joint: R -y, mass: 1 kg, centre: [0.3 m, 0, 0], "
        "friction: {A: 9 N m, stick: yes}, points: {end: [0.6 m, 0, 0]}}\n"
        "  bob: {parent: arm, at: arm.end, joint: R -y, mass: 0.2 kg, centre: [0, 0, -0.1 m]}\n");
    linear_look(&x);
    ck_assert_int_eq(x.s->n, 1);
    ck_assert_int_eq(x.s->joint[0], 1);
    ck_assert_str_eq(x.s->why, "it has friction that sticks");
    ck_assert_close(x.modes->mode[0].im, sqrt(9.81 / 0.1), 1e-11, 0.0);
    linear_end(&x);
}
END_TEST

static void refused(linearised *x, stein_status code, const char *words)
{
    stein_err why = {STEIN_OK, ""};
    const stein_linear_system *s = NULL;
    ck_assert_int_eq(stein_linear_at(x->l, x->sim, &s, &why), code);
    ck_assert_msg(strstr(why.msg, words) != NULL, "%s", why.msg);
    ck_assert_ptr_null(s);
}

START_TEST(a_state_that_is_no_equilibrium_is_refused_with_its_acceleration)
{
    linearised x = linear_built_in(&stein_model_pendulum);
    double quarter = 1.5707963267948966, down = 0.0, speed = 2.0;
    ck_assert_stein(stein_set_state(x.sim, 0.0, &quarter, &down, err));
    refused(&x, STEIN_ESETTLE, "\"rod\" accelerates with -41.8");
    ck_assert_stein(stein_set_state(x.sim, 0.0, &down, &speed, err));
    refused(&x, STEIN_ESETTLE, "moves unsteadily: the acceleration of \"rod\" changes by -83.7");
    ck_assert_stein(stein_set_state(x.sim, 0.0, &down, &down, err));
    linear_look(&x); // and works after that
    linear_end(&x);
}
END_TEST

START_TEST(refused_linearisations_state_the_reason)
{
    linearised x = linear_begin(
        "mechanism: rests\n"
        "bodies:\n"
        "  slide: {joint: T x}\n"
        "  block: {parent: slide, joint: T z, mass: 0.4 kg, points: {p: [0, 0, 0]}}\n"
        "contacts:\n"
        "  slope:\n"
        "    between: [{point: block.p}, {line: {on: frame, at: [0, 0, 0], facing: 85 deg}}]\n"
        "    normal: {c: 1e4 N/m, D: 1 s/m}\n"
        "    friction: {A: 0.3, stick: yes}\n"
        "simulation: {settle: no}\n");
    stein_linear *none = NULL;
    stein_err why = {STEIN_OK, ""};
    stein_sim_def def = stein_sim_def_default(&stein_model_pendulum);
    ck_assert_stein(stein_run(x.sim, 3.0, err));
    refused(&x, STEIN_EINVAL, "contact \"slope\" sticks");
    stein_sim *other = x.sim;
    x.sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    refused(&x, STEIN_EINVAL, "other equations");
    stein_sim_destroy(other);
    linear_end(&x);
    x = linear_begin("mechanism: fixed\nbodies: {sled: {joint: T x, mass: 1 kg}}\n"
                     "inputs: {move: {motion: sled, idle: hold}}\n");
    refused(&x, STEIN_EINVAL, "nothing can move");
    linear_end(&x);
    def.alloc = no_memory;
    ck_assert_int_eq(stein_linear_create(&none, &stein_model_pendulum, &def, &why), STEIN_ENOMEM);
    ck_assert_ptr_null(none);
    stein_linear_destroy(NULL);
}
END_TEST

void linear_ways_cases(Suite *suite)
{
    TCase *tc = tcase_create("both ways");
    tcase_set_timeout(tc, 120);
    tcase_add_unchecked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, both_ways_agree_on_mechanisms_drawn_at_random);
    tcase_add_test(tc, both_ways_agree_on_piano_actions_with_their_felts);
    tcase_add_test(tc, a_force_of_ones_own_acts_with_its_slope);
    tcase_add_test(tc, linkages_are_as_differences_of_closed_positions);
    tcase_add_test(tc, nothing_of_the_simulation_changes);
    tcase_add_test(tc, a_joint_that_sticks_does_not_move);
    tcase_add_test(tc, a_state_that_is_no_equilibrium_is_refused_with_its_acceleration);
    tcase_add_test(tc, refused_linearisations_state_the_reason);
    suite_add_tcase(suite, tc);
}
