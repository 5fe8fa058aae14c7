/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_contact.c - contacts against closed forms: free fall, Hunt-Crossley impact, Coulomb friction
 * on a slope, two balls.
 */
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <gsl/gsl_roots.h>

#include "contact_lanes.h"
#include "functions.h"
#include "lane.h"
#include "lab_support.h"
#include "stein/law.h"

typedef struct log {
    int n;
    stein_event event[32];
    double qd[32];
} log_t;

static void record(void *ctx, stein_sim *sim, const stein_event *event)
{
    log_t *log = ctx;
    if (log->n < 32) {
        log->event[log->n] = *event;
        log->qd[log->n] = stein_qd(sim)[0];
        log->n++;
    }
}

static double parameter(stein_sim *sim, const char *name)
{
    double value = NAN;
    ck_assert_stein(stein_get(sim, name, &value, err));
    return value;
}

/* the ball at height gap over the floor (its coordinate where the floor's gap is 0, plus gap) */
static stein_sim *ball_over_floor(double gap, double speed, log_t *log)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_DP5, 1e-5);
    double q = 0.0, qd = speed, at_zero;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    ck_assert_stein(stein_read_name(sim, "floor_gap", &at_zero, err));
    q = gap - at_zero;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    stein_on_event(sim, record, log);
    return sim;
}

START_TEST(free_fall_meets_the_floor_at_the_time_of_the_formula)
{
    log_t log = {0};
    stein_sim *sim = ball_over_floor(0.3071, 0.0, &log);
    double g = -parameter(sim, "gravity.z");
    double t = sqrt(2.0 * 0.3071 / g);
    ck_assert_stein(stein_run(sim, t + 1e-4, err));
    ck_assert_int_eq(log.n, 1);
    ck_assert_int_eq(log.event[0].kind, STEIN_EVENT_CONTACT_BEGIN);
    ck_assert_int_eq(log.event[0].index, stein_find_contact(&stein_model_bouncing_ball, "floor"));
    ck_assert_close(log.event[0].time, t, 1e-12, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

/* Without gravity m v dv = -f(x)(1 + D v) dx separates: the work of the elastic force over the
 * compression equals the integral of m v / (1 + D v), by quadrature, on the way in and out. */
typedef struct balance {
    double D, v_in, target;
} balance;

static double momentum_density(double v, void *ctx)
{
    return v / (1.0 + ((balance *)ctx)->D * v);
}

static double quadrature(double D, double from, double to)
{
    balance b = {D, 0.0, 0.0};
    gsl_function f = {momentum_density, &b};
    double result, error;
    size_t evaluations;
    gsl_integration_qng(&f, from, to, 0.0, 1e-12, &result, &error, &evaluations);
    return result;
}

static double mismatch(double v_out, void *ctx)
{
    balance *b = ctx;
    return quadrature(b->D, -v_out, 0.0) + b->target;
}

static double exit_speed(double D, double v_in)
{
    balance b = {D, v_in, quadrature(D, 0.0, v_in)};
    gsl_function f = {mismatch, &b};
    gsl_root_fsolver *solver = gsl_root_fsolver_alloc(gsl_root_fsolver_brent);
    gsl_root_fsolver_set(solver, &f, 1e-9, fmin(v_in, 0.9999 / D));
    for (int i = 0; i < 100; i++) {
        gsl_root_fsolver_iterate(solver);
    }
    double v = gsl_root_fsolver_root(solver);
    gsl_root_fsolver_free(solver);
    return v;
}

START_TEST(a_deformation_is_the_depth_and_its_rate)
{
    log_t log = {0};
    stein_sim *sim = ball_over_floor(0.0107, 0.0, &log);
    int floor = stein_find_contact(&stein_model_bouncing_ball, "floor");
    double x = 7.0, xdot = 8.0, gap;
    ck_assert_int_eq(stein_deformation(sim, floor, &x, &xdot), 0); // apart: nothing is touched
    ck_assert_int_eq(stein_deformation(sim, -1, &x, &xdot), 0);
    ck_assert_int_eq(stein_deformation(sim, 99, &x, &xdot), 0);
    ck_assert(x == 7.0 && xdot == 8.0);
    ck_assert_stein(stein_run(sim, sqrt(2.0 * 0.0107 / 9.81) + 2e-4, err));
    ck_assert_int_eq(log.n, 1);
    ck_assert_stein(stein_read_name(sim, "floor_gap", &gap, err));
    ck_assert_int_eq(stein_deformation(sim, floor, &x, &xdot), 1);
    ck_assert(gap < 0.0);
    ck_assert_close(x, -gap, 1e-14, 0.0);
    ck_assert_close(xdot, -stein_qd(sim)[0], 1e-14, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

/* of several points that touch the deepest counts: the beak under the roof, at rest */
START_TEST(a_notch_gives_its_deepest_point)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim *sim = make_sim(model, STEIN_RK4, 1e-5);
    double deepest = 0.0, x, xdot, force;
    int told = 0;
    for (int i = 0; i < 400; i++) {
        ck_assert_stein(stein_run(sim, 1e-4 * (i + 1), err));
        ck_assert_stein(stein_read_name(sim, "notch_force", &force, err));
        int touches = stein_deformation(sim, model->ncontact, &x, &xdot);
        ck_assert_int_eq(touches, force > 0.0);
        deepest = touches ? fmax(deepest, x) : deepest;
        told += touches;
    }
    ck_assert(told > 50 && deepest > 1e-6 && deepest < 1e-3);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(restitution_follows_the_energy_balance_at_every_impact_speed)
{
    double worst = 0.0;
    gsl_set_error_handler_off();
    for (double v_in = 0.13; v_in < 5.0; v_in *= 1.73) {
        log_t log = {0};
        stein_sim *sim = ball_over_floor(1e-3, -v_in, &log);
        ck_assert_stein(stein_set(sim, "gravity.z", 0.0, err));
        ck_assert_stein(stein_run(sim, 1e-3 / v_in + 0.05, err));
        ck_assert_int_eq(log.n, 2);
        ck_assert_int_eq(log.event[1].kind, STEIN_EVENT_CONTACT_END);
        double expected = exit_speed(parameter(sim, "floor.normal.D"), v_in);
        double error = fabs(log.qd[1] / expected - 1.0);
        worst = fmax(worst, error);
        ck_assert_close(log.qd[1], expected, 1e-3, 0.0);
        ck_assert(log.qd[1] < v_in); // energy is lost, and more of it at speed
        stein_sim_destroy(sim);
    }
    printf("Hunt-Crossley restitution against quadrature: worst %.2e relative\n", worst);
}
END_TEST

START_TEST(deepest_compression_follows_the_energy_balance)
{
    log_t log = {0};
    double v_in = 0.917, gap, deepest = 0.0, force_work;
    stein_sim *sim = ball_over_floor(1e-4, -v_in, &log);
    ck_assert_stein(stein_set(sim, "gravity.z", 0.0, err));
    do {
        ck_assert_stein(stein_step(sim, err));
        ck_assert_stein(stein_read_name(sim, "floor_gap", &gap, err));
        deepest = fmax(deepest, -gap);
    } while (log.n < 2);
    double a = parameter(sim, "floor.normal.a"), b = parameter(sim, "floor.normal.b");
    double c = parameter(sim, "floor.normal.c"), m = parameter(sim, "ball.mass");
    double x2 = deepest * deepest;
    force_work = a * x2 * x2 / 4.0 + b * x2 * deepest / 3.0 + c * x2 / 2.0;
    double expected = m * quadrature(parameter(sim, "floor.normal.D"), 0.0, v_in);
    ck_assert_close(force_work, expected, 1e-3, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_step_too_coarse_for_a_hard_contact_is_refused_as_chatter)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 0.1);
    static const char *const gone[] = {"floor.normal.a", "floor.normal.b", "floor.normal.D"};
    for (int i = 0; i < 3; i++) {
        ck_assert_stein(stein_set(sim, gone[i], 0.0, err));
    }
    ck_assert_stein(stein_set(sim, "floor.normal.c", 1e6, err)); // elastic, 1 ms a bounce and less
    double q = 0.026, qd = 0.0;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &qd, err));
    stein_err failure = {STEIN_OK, ""};
    ck_assert_int_eq(stein_step(sim, &failure), STEIN_ECHATTER);
    ck_assert_msg(strstr(failure.msg, "a contact begins and ends within one step after t = ") !=
                      NULL,
                  "%s", failure.msg);
    ck_assert(stein_time(sim) > 0.0 && stein_time(sim) < 0.1); // stopped where it began
    stein_sim_destroy(sim);
}
END_TEST

/* speed and acceleration of the block along the slope [m/s, m/s^2], positive downhill */
static void slide(double A, double seconds, double *speed, double *acceleration, double *angle)
{
    stein_sim *sim = make_sim(&stein_model_block_on_slope, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "slope.friction.A", A, err));
    ck_assert_stein(stein_reset(sim, err));
    double facing = parameter(sim, "slope.line2.facing"), x[3], a[3];
    *angle = 0.5 * M_PI - facing;
    ck_assert_stein(stein_run(sim, seconds, err));
    static const char *const axis[2] = {"x", "z"};
    for (int i = 0; i < 2; i++) {
        char name[32];
        snprintf(name, sizeof name, "speed_%s", axis[i]);
        ck_assert_stein(stein_read_name(sim, name, &x[i], err));
        snprintf(name, sizeof name, "acceleration_%s", axis[i]);
        ck_assert_stein(stein_read_name(sim, name, &a[i], err));
    }
    // downhill: the normal turned by -90 degrees
    double tx = sin(facing), tz = -cos(facing);
    *speed = x[0] * tx + x[1] * tz;
    *acceleration = a[0] * tx + a[1] * tz;
    stein_sim_destroy(sim);
}

START_TEST(a_block_sticks_on_a_slope_below_the_angle_of_friction)
{
    // smooth Coulomb friction creeps at the speed where mu(v) = tan(angle), and no faster
    double speed, acceleration, angle;
    slide(0.62, 0.5, &speed, &acceleration, &angle);
    stein_sim *sim = make_sim(&stein_model_block_on_slope, STEIN_RK4, 0.0);
    double vt = parameter(sim, "slope.friction.vt");
    stein_sim_destroy(sim);
    ck_assert(tan(angle) < 0.62);
    double creep = vt * atanh(tan(angle) / 0.62);
    printf("creep of a sticking block: %.3e m/s, expected %.3e m/s\n", speed, creep);
    ck_assert_close(speed, creep, 1e-3, 0.0);
    ck_assert_close(acceleration, 0.0, 0.0, 1e-6);
}
END_TEST

START_TEST(a_block_slides_with_the_acceleration_of_coulomb)
{
    double speed, acceleration, angle, A = 0.0713;
    slide(A, 0.5, &speed, &acceleration, &angle);
    double expected = 9.81 * (sin(angle) - A * cos(angle));
    ck_assert(tan(angle) > A);
    ck_assert_close(acceleration, expected, 1e-3, 0.0);
}
END_TEST

START_TEST(two_equal_balls_exchange_their_speeds)
{
    stein_sim *sim = make_sim(&stein_model_newtons_cradle, STEIN_RK4, 0.0);
    log_t log = {0};
    stein_on_event(sim, record, &log);
    double T0, V0, T, V;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &T0, &V0);
    while (log.n < 2) {
        ck_assert_stein(stein_step(sim, err));
        ck_assert(stein_time(sim) < 1.0);
    }
    ck_assert_int_eq(log.event[0].kind, STEIN_EVENT_CONTACT_BEGIN);
    ck_assert_int_eq(log.event[1].kind, STEIN_EVENT_CONTACT_END);
    stein_energy(sim, stein_q(sim), stein_qd(sim), &T, &V);
    ck_assert_close(T + V, T0 + V0, 1e-9, 0.0); // undamped contact
    ck_assert_close(stein_qd(sim)[1], log.qd[0], 1e-3, 0.0);
    ck_assert(fabs(stein_qd(sim)[0]) < 1e-3 * log.qd[0]);
    stein_sim_destroy(sim);
}
END_TEST

/* four points on lines between two poses each, and what they press into */
typedef struct four {
    stein__group group;
    double pose[4][2][7], wrench[4][2][3];
    stein__contact_record did;
} four;

static double between(uint64_t *seed, double from, double to)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return from + (to - from) * (double)(*seed >> 11) * 0x1p-53;
}

enum {
    NUMBERS = offsetof(stein__group, pose) / sizeof(stein__each),
    RECORDED = sizeof(stein__contact_record) / sizeof(stein__each)
};

/* the numbers of a group or a deed, which are all of one type */
static stein__each *all(void *numbers)
{
    return numbers;
}

static void draw(four *f, uint64_t *seed)
{
    memset(f, 0, sizeof *f);
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < NUMBERS; i++) {
            all(&f->group)[i].of[k] = between(seed, -1.0, 1.0);
        }
        f->group.inverse_vt.of[k] = between(seed, 0.0, 30.0); // near and far of tanh
        f->group.reach.of[k] = between(seed, -0.5, 3.0);
        for (int side = 0; side < 2; side++) {
            for (int i = 0; i < 7; i++) {
                f->pose[k][side][i] = between(seed, -1.0, 1.0);
            }
        }
    }
}

static const stein__contact_kernel by_two = {
    2, stein__contact_forces2, stein__contact_forces2_recorded, stein__contact_depths2};

/* a group of `n` of them, from the one `first` on */
static void press(const stein__contact_kernel *by, four *f, int first, int n)
{
    stein__group g = f->group;
    stein__contact_record did;
    stein__each depth;
    for (int k = 0; k < 4; k++) {
        int from = first + (k < n ? k : n - 1);
        for (int i = 0; i < NUMBERS; i++) {
            all(&g)[i].of[k] = all(&f->group)[i].of[from];
        }
        for (int side = 0; side < 2; side++) {
            g.pose[k][side] = f->pose[from][side];
            g.wrench[k][side] = f->wrench[from][side];
        }
    }
    g.n = n;
    by->forces_recorded(&g, &did);
    by->depths(&g, &depth);
    ck_assert_mem_eq(depth.of, did.depth.of, sizeof *depth.of * (size_t)n);
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < RECORDED; i++) {
            all(&f->did)[i].of[first + k] = all(&did)[i].of[k];
        }
    }
}

START_TEST(places_side_by_side_have_the_bits_of_each_alone)
{
    uint64_t seed = 1788;
    int pressing = 0;
    for (int n = 0; n < 500; n++) {
        four alone, two, wide;
        draw(&alone, &seed);
        two = wide = alone;
        for (int k = 0; k < 4; k++) {
            double law[STEIN_NORMAL_SIZE] = {0.0};
            press(&by_two, &alone, k, 1);
            for (int i = STEIN_NORMAL_A; i <= STEIN_NORMAL_D; i++) {
                law[i] = alone.group.normal[i].of[k];
            }
            law[STEIN_NORMAL_PRELOAD] = alone.group.normal[STEIN_NORMAL_PRELOAD].of[k];
            double depth = alone.did.depth.of[k], rate = alone.did.rate.of[k];
            ck_assert(alone.did.normal.of[k] == stein_normal_force(law, depth, rate));
            ck_assert(alone.did.grip.of[k] == stein__tanh_of(alone.did.slip.of[k]));
            pressing += alone.did.normal.of[k] > 0.0;
        }
        press(&by_two, &two, 0, 2);
        press(&by_two, &two, 2, 2);
        ck_assert_mem_eq(two.wrench, alone.wrench, sizeof alone.wrench);
        ck_assert_mem_eq(&two.did, &alone.did, sizeof alone.did);
#if STEIN_WIDEST == 8
        if (stein__processor_lanes() >= 4) {
            stein__contact_kernel by_four = {
                4, stein__contact_forces4, stein__contact_forces4_recorded, stein__contact_depths4};
            press(&by_four, &wide, 0, 4);
            ck_assert_mem_eq(wide.wrench, alone.wrench, sizeof alone.wrench);
            ck_assert_mem_eq(&wide.did, &alone.did, sizeof alone.did);
        }
#endif
    }
    ck_assert_int_gt(pressing, 500); // of 2000
}
END_TEST

/* Which side of a contact is fixed does not matter: a table that falls on a peg, a catcher on a
 * beak rest in statics. */
START_TEST(what_falls_may_fall_on_a_fixed_point)
{
    static const char *const text[] = {
        "mechanism: peg\n"
        "bodies:\n"
        "  table: {joint: T z, mass: 1 kg, initial: {position: 0.1 mm}}\n"
        "contacts:\n"
        "  floor:\n"
        "    between:\n"
        "      - {circle: {on: frame, at: [0, 0, 0], radius: 0 mm}}\n"
        "      - {line: {on: table, at: [0, 0, 0], facing: -90 deg}}\n"
        "    normal: {c: 52 kN/m, D: 20 s/m}\n"
        "outputs:\n"
        "  force: {contact: floor, read: force}\n"
        "simulation: {dt: 10 us, until: 1 s, integrator: rk4}\n",
        "mechanism: beak\n"
        "bodies:\n"
        "  carrier: {joint: T z, mass: 1 kg, initial: {position: 3.1 mm}}\n"
        "notches:\n"
        "  catch:\n"
        "    corner: {on: carrier, at: [3 mm, 0, 0], angle: 90 deg}\n"
        "    beak: {on: frame, at: [0, 0, 0], tilt: 0 rad}\n"
        "    normal: {c: 2e5 N/m, D: 50 s/m}\n"
        "outputs:\n"
        "  force: {notch: catch, read: force}\n"
        "simulation: {dt: 10 us, until: 1 s, integrator: rk4}\n"};
    for (int i = 0; i < 2; i++) {
        lab_model *opened = open_text(text[i], NULL, 0);
        stein_sim *sim = NULL;
        double force = 0.0;
        ck_assert_stein(lab_sim(opened, NULL, &sim, err));
        ck_assert_stein(stein_run(sim, 1.0, err));
        ck_assert_stein(stein_read_name(sim, "force", &force, err));
        ck_assert_msg(fabs(force - 9.81) < 1e-3, "%.9g N", force);
        stein_sim_destroy(sim);
        lab_close(opened);
    }
}
END_TEST

Suite *contact_suite(void)
{
    Suite *suite = suite_create("contact");
    TCase *tc = tcase_create("contact");
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_deformation_is_the_depth_and_its_rate);
    tcase_add_test(tc, a_notch_gives_its_deepest_point);
    tcase_add_test(tc, free_fall_meets_the_floor_at_the_time_of_the_formula);
    tcase_add_test(tc, restitution_follows_the_energy_balance_at_every_impact_speed);
    tcase_add_test(tc, deepest_compression_follows_the_energy_balance);
    tcase_add_test(tc, a_step_too_coarse_for_a_hard_contact_is_refused_as_chatter);
    tcase_add_test(tc, a_block_sticks_on_a_slope_below_the_angle_of_friction);
    tcase_add_test(tc, a_block_slides_with_the_acceleration_of_coulomb);
    tcase_add_test(tc, two_equal_balls_exchange_their_speeds);
    tcase_add_test(tc, places_side_by_side_have_the_bits_of_each_alone);
    suite_add_tcase(suite, tc);
    TCase *files = tcase_create("files");
    tcase_add_checked_fixture(files, make_folder, remove_folder);
    tcase_add_test(files, what_falls_may_fall_on_a_fixed_point);
    suite_add_tcase(suite, files);
    return suite;
}
