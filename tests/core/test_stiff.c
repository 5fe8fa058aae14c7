/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_stiff.c - implicit steps: their order, their choice and their cost, against closed forms
 * and, for the stiff governor, equations written by hand and another integrator.
 */
#include <string.h>

#include "governor.h"
#include "lab_support.h"
#include "slopes.h"
#include "stein/batch.h"
#include "stein/sensitivity.h"

static stein_sim *sim_of(lab_model *model, stein_integrator integrator)
{
    stein_sim_def def = lab_def(model);
    stein_sim *sim = NULL;
    def.integrator = integrator;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    return sim;
}

static stein_step_counts counts_of(const stein_sim *sim)
{
    stein_step_counts n;
    stein_steps_taken(sim, &n);
    return n;
}

/* ---- order ---- */

/* double pendulum after 0.4 s with steps of dt, whatever their error */
static void swing(double dt, double out[4])
{
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_IMPLICIT, dt);
    ck_assert_stein(stein_set_tolerance(sim, 1e9, err));
    ck_assert_stein(stein_run(sim, 0.4, err));
    ck_assert_int_eq(counts_of(sim).implicit, counts_of(sim).taken);
    memcpy(out, stein_q(sim), 2 * sizeof *out);
    memcpy(out + 2, stein_qd(sim), 2 * sizeof *out);
    stein_sim_destroy(sim);
}

START_TEST(implicit_steps_have_order_five)
{
    double reference[4], coarse[4], fine[4], off[2] = {0.0, 0.0};
    swing(0.4 / 1280.0, reference);
    swing(0.4 / 80.0, coarse);
    swing(0.4 / 160.0, fine);
    for (int i = 0; i < 4; i++) {
        off[0] = fmax(off[0], fabs(coarse[i] - reference[i]));
        off[1] = fmax(off[1], fabs(fine[i] - reference[i]));
    }
    double order = log2(off[0] / off[1]);
    printf("observed order of Rodas5P: %.3f\n", order);
    ck_assert(order > 4.8 && order < 5.6);
}
END_TEST

/** States inside of a step, stored at first and then compared. */
typedef struct eye {
    double (*seen)[4], dt, off;
    int i, first;
} eye;

enum { LOOKS = 7 };

static double look_inside(void *ctx, stein_sim *sim)
{
    eye *e = ctx;
    double *seen = e->seen[e->i++];
    for (int j = 0; j < 4; j++) {
        double now = j < 2 ? stein_q(sim)[j] : stein_qd(sim)[j - 2];
        e->off = fmax(e->off, e->first ? 0.0 : fabs(now - seen[j]));
        seen[j] = e->first ? now : seen[j];
    }
    return e->i < LOOKS ? e->dt * (e->i + 1) / (LOOKS + 1) : INFINITY;
}

/* largest error inside of one step of dt, against many */
static double inside_of(double dt)
{
    double seen[LOOKS][4], most = 0.0;
    for (int k = 0; k < 2; k++) {
        stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_IMPLICIT, dt);
        ck_assert_stein(
            stein_set_state(sim, 0.0, (double[2]){0.731, -0.412}, (double[2]){1.27, -0.93}, err));
        eye at = {seen, dt, 0.0, 0, k == 0};
        stein_pace pace = {.tolerance = k == 0 ? 1e9 : 1e-13,
                           .longest = dt,
                           .h = k == 0 ? dt : dt / 64.0,
                           .next = dt / (LOOKS + 1),
                           .look = look_inside,
                           .ctx = &at};
        ck_assert_stein(stein_run_adaptive(sim, dt, &pace, err));
        ck_assert_int_eq(at.i, LOOKS);
        most = at.off;
        stein_sim_destroy(sim);
    }
    return most;
}

START_TEST(inside_of_implicit_steps_the_order_is_four)
{
    double order = log2(inside_of(0.02) / inside_of(0.01)); // of one step
    printf("observed order inside of a step of Rodas5P: %.3f\n", order - 1.0);
    ck_assert(order > 4.6 && order < 5.6);
}
END_TEST

/* ---- a joint in thick oil ---- */

static const char oil[] =
    "mechanism: oil\nbodies:\n  flap: {joint: R y, mass: 1 g, inertia: {yy: 5.5e-6 kg m^2}, "
    "spring: "
    "{k: 50 N m/rad}, damping: 55 N m s/rad, initial: {position: 0.7 rad}}\noutputs: {q: {joint: "
    "flap, read: position}}\nsimulation: {dt: 20 ms, until: 1 s}\n";

/* J q'' + c q' + k q = 0 from rest at 0.7 */
static double flap(double t)
{
    double J = 5.5e-6, c = 55.0, k = 50.0, fast = -0.5 * (c + sqrt(c * c - 4.0 * J * k)) / J;
    double slow = k / J / fast;
    return 0.7 * (fast * exp(slow * t) - slow * exp(fast * t)) / (fast - slow);
}

START_TEST(an_overdamped_joint_costs_hundreds_of_steps_instead_of_millions)
{
    lab_model *model = open_text(oil, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_CONTROLLED), *plain = sim_of(model, STEIN_DP5);
    double worst = 0.0;
    for (int i = 1; i <= 10; i++) {
        ck_assert_stein(stein_run(sim, 0.1 * i, err));
        worst = fmax(worst, fabs(stein_q(sim)[0] - flap(0.1 * i)));
    }
    stein_step_counts n = counts_of(sim);
    stein_pace pace = {.tolerance = 1e-12, .longest = 0.02, .h = 1e-7, .next = INFINITY};
    ck_assert_stein(stein_run_adaptive(plain, 0.005, &pace, err)); // 0.5 % of it
    printf("overdamped joint, 1e7 1/s, 1 s: off by %.1e rad; %lld trials, %lld of %lld steps "
           "implicit; explicit: %lld trials for 0.005 s\n",
           worst, stein_trials(sim), n.implicit, n.taken, stein_trials(plain));
    ck_assert(worst <= 1e-9);
    ck_assert(n.implicit > 0 && n.changes == 1 && n.refused == NULL);
    ck_assert_close(n.rate, 1e7, 0.1, 0.0);
    ck_assert(n.first < 1e-4);
    ck_assert(100 * stein_trials(sim) < stein_trials(plain) * 200);
    ck_assert_int_eq(counts_of(plain).implicit, 0);
    stein_sim_destroy(sim);
    stein_sim_destroy(plain);
    lab_close(model);
}
END_TEST

START_TEST(steps_are_explicit_again_where_nothing_is_stiff)
{
    lab_model *model = open_text(oil, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_CONTROLLED);
    ck_assert_stein(stein_run(sim, 0.2, err));
    ck_assert(counts_of(sim).implicit > 0);
    ck_assert_stein(stein_set(sim, "flap.damping", 0.001, err)); // now it swings, at 3 kHz
    ck_assert_stein(stein_run(sim, 0.205, err));
    stein_step_counts then = counts_of(sim);
    ck_assert_stein(stein_run(sim, 0.21, err));
    ck_assert_int_eq(counts_of(sim).implicit, then.implicit);
    ck_assert(counts_of(sim).taken > then.taken);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(a_saved_state_continues_with_the_same_kind_of_steps_and_the_same_bits)
{
    lab_model *model = open_text(oil, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_CONTROLLED), *other = sim_of(model, STEIN_CONTROLLED);
    unsigned char block[4096], end[2][4096];
    ck_assert(stein_state_size(sim) <= sizeof block);
    for (int i = 1; i <= 3; i++) { // before the change, and behind it
        ck_assert_stein(stein_run(sim, i < 3 ? 2e-6 * i : 0.5, err));
        stein_save(sim, block);
        ck_assert_stein(stein_restore(other, block, err));
        ck_assert_stein(stein_run(sim, 0.1 + 0.25 * i, err));
        ck_assert_stein(stein_run(other, 0.1 + 0.25 * i, err));
        stein_save(sim, end[0]);
        stein_save(other, end[1]);
        ck_assert_mem_eq(end[0], end[1], stein_state_size(sim));
        ck_assert_stein(stein_restore(sim, block, err));
    }
    ck_assert(counts_of(other).changes == 2); // the third block contains it
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
    lab_close(model);
}
END_TEST

/* ---- a contact ---- */

static const char floor_of[] =
    "mechanism: hard_floor\nbodies:\n  ball: {joint: T z, mass: 0.1 kg, initial: {position: 10 "
    "mm}, "
    "points: {c: [0, 0, 0]}}\ncontacts:\n  floor: {between: [{point: ball.c}, {line: {on: frame, "
    "at: "
    "[0, 0, 0], facing: 90 deg}}], normal: {c: %s, D: %s}}\noutputs: {z: {joint: ball, read: "
    "position}}\nsimulation: {dt: 10 ms, until: 1 s}\n";

static void first_begin(void *ctx, stein_sim *sim, const stein_event *event)
{
    double *when = ctx;
    (void)sim;
    if (event->kind == STEIN_EVENT_CONTACT_BEGIN && isnan(*when)) {
        *when = event->time;
    }
}

/* stiff in flight and contact, stiff to its end, and a deformation of 1e-12 m below every
 * tolerance: only after too many steps */
START_TEST(contacts_of_extreme_stiffness_come_to_rest)
{
    static const char *const k[] = {"1e9 N/m", "1e11 N/m", "1e12 N/m"};
    static const char *const D[] = {"1e3 s/m", "1e5 s/m", "1e6 s/m"};
    static const double stiffness[] = {1e9, 1e11, 1e12};
    char *text = lab__text(floor_of, k[_i / 2], D[_i / 2]);
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = sim_of(model, _i % 2 ? STEIN_IMPLICIT : STEIN_CONTROLLED);
    double begin = NAN;
    stein_on_event(sim, first_begin, &begin);
    ck_assert_stein(stein_run(sim, 1.0, err));
    stein_step_counts n = counts_of(sim);
    printf("ball on %s: %lld trials, %lld of %lld steps implicit, depth %.6g m\n", k[_i / 2],
           stein_trials(sim), n.implicit, n.taken, -stein_q(sim)[0]);
    ck_assert_close(begin, sqrt(2.0 * 0.010 / 9.81), 0.0, 1e-12);
    ck_assert_close(-stein_q(sim)[0], 0.1 * 9.81 / stiffness[_i / 2], 1e-6, 0.0);
    ck_assert(fabs(stein_qd(sim)[0]) < 1e-12);
    ck_assert(n.implicit > 50 && n.refused == NULL);
    ck_assert(stein_trials(sim) < (_i == 4 ? 30000 : 1000));
    stein_sim_destroy(sim);
    lab_close(model);
    free(text);
}
END_TEST

/* ---- the stiff governor ---- */

START_TEST(the_stiff_governor_agrees_with_equations_by_hand)
{
    static const stein_integrator kind[] = {STEIN_CONTROLLED, STEIN_CONTROLLED, STEIN_IMPLICIT};
    static const double tolerance[] = {STEIN_TOLERANCE, 1e-7, 1e-8};
    double right[4];
    ck_assert_int_eq(governor_by_hand(right), GSL_SUCCESS);
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "tests/validate/governor.yaml", &options, err));
    for (int i = 0; i < 3; i++) {
        stein_sim *sim = sim_of(model, kind[i]);
        ck_assert_stein(stein_set_tolerance(sim, tolerance[i], err));
        ck_assert_stein(stein_run(sim, 10.0, err));
        const double *q = stein_q(sim);
        double off = fmax(fabs(q[1] - right[0]), fabs(q[2] - right[1]));
        off = fmax(off, fabs(q[3] + q[2] + 3.14159265358979323846));
        stein_step_counts n = counts_of(sim);
        printf("stiff governor, 10 s, tolerance %.0e: off by %.1e; %lld trials, %lld of %lld steps "
               "implicit\n",
               tolerance[i], off, stein_trials(sim), n.implicit, n.taken);
        ck_assert(off <= 1e-6);
        ck_assert(i == 0 ? n.implicit == 0 : n.implicit > n.taken / 2);
        stein_sim_destroy(sim);
    }
    lab_close(model);
}
END_TEST

/* the same bits by every compiler: values of gcc 12; clang 14 gives the same */
START_TEST(implicit_steps_have_the_same_bits_everywhere)
{
    static const double right[4] = {0x1.36c49638dbfa2p+0, 0x1.5c7ca61514c15p-4,
                                    -0x1.b5fc5abd29112p-2, -0x1.5b6029ec9daeep+1};
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "tests/validate/governor.yaml", &options, err));
    stein_sim *sim = sim_of(model, STEIN_IMPLICIT);
    ck_assert_stein(stein_run(sim, 0.2, err));
    for (int i = 0; i < 4; i++) {
        ck_assert_msg(stein_q(sim)[i] == right[i], "%a", stein_q(sim)[i]);
    }
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* forces at points off the plane: implicit steps have their derivatives by q and qd */
START_TEST(links_off_the_plane_are_derived_exactly)
{
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "tests/validate/governor.yaml", &options, err));
    stein_sim *sim = sim_of(model, STEIN_RK4);
    stein_derivative *s = NULL;
    double q[4] = {0.3, 0.04, -0.6, -2.4}, qd[4] = {5.0, 0.31, -0.42, 0.17}, by_q[16], by_qd[16];
    ck_assert_stein(stein_derivative_create(&s, stein_sim_model(sim), NULL, err));
    ck_assert_stein(stein__derivative_at(s, sim, 0.0, q, qd, NULL, err));
    stein_derivative_by_state(s, by_q, by_qd);
    for (int k = 0; k < 8; k++) {
        double *moved = k < 4 ? &q[k] : &qd[k - 4], kept = *moved, h = 1e-4, side[4][4], slope[4];
        for (int i = 0; i < 4; i++) {
            *moved = kept + (i < 2 ? 1.0 : 2.0) * (i % 2 ? -h : h);
            ck_assert_stein(stein_acceleration(sim, 0.0, q, qd, side[i], err));
        }
        *moved = kept;
        for (int i = 0; i < 4; i++) { // order 4
            double near = side[0][i] - side[1][i], far = side[2][i] - side[3][i];
            slope[i] = (8.0 * near - far) / (12.0 * h);
            double given = (k < 4 ? by_q : by_qd)[i * 4 + k % 4];
            ck_assert_close(given, slope[i], 1e-8, 1e-3 * h);
        }
    }
    stein_derivative_destroy(s);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* ---- derivatives by differences ---- */

/* fixed steps that are short enough, against steps that become implicit. @return largest distance
 */
static double off_short_steps(const char *text, double until, double dt)
{
    lab_model *model = open_text(text, NULL, 0);
    stein_sim_def def = lab_def(model);
    stein_sim *own = sim_of(model, STEIN_CONTROLLED), *other = NULL;
    double off = 0.0;
    def.integrator = STEIN_RK4;
    def.dt = dt;
    ck_assert_stein(lab_sim(model, &def, &other, err));
    ck_assert_stein(stein_run(own, until, err));
    ck_assert_stein(stein_run(other, until, err));
    ck_assert_int_gt(counts_of(own).implicit, 0);
    for (int j = 0; j < stein_sim_model(own)->nq; j++) {
        off = fmax(off, fabs(stein_q(own)[j] - stein_q(other)[j]));
    }
    stein_sim_destroy(own);
    stein_sim_destroy(other);
    lab_close(model);
    return off;
}

/* A slider crank, and on its block a gram in oil: it moves with the block within 0.1 us. */
START_TEST(a_stiff_loop_moves_as_with_short_steps)
{
    static const char text[] =
        "mechanism: crank\nbodies:\n"
        "  crank: {joint: R -y, mass: 1 kg, inertia: {yy: 0.01 kg m^2}, points: {e: [0.1 m, 0, 0]},"
        " initial: {position: 1 rad, speed: 3 rad/s}}\n"
        "  rod: {parent: crank, at: crank.e, joint: R -y, mass: 0.5 kg, centre: [0.15 m, 0, 0], "
        "inertia: {yy: 0.004 kg m^2}, points: {e: [0.3 m, 0, 0]}, initial: {guess: -1.3 rad}}\n"
        "  block: {joint: T x, mass: 0.3 kg, points: {c: [0, 0, 0]}, initial: {guess: 0.35 m}}\n"
        "  tip: {parent: block, joint: T x, mass: 1 g, spring: {k: 1e5 N/m}, damping: 1e4 N s/m}\n"
        "loops: {pin: {between: [rod.e, block.c]}}\nsimulation: {dt: 10 ms, until: 1 s}\n";
    ck_assert_double_lt(off_short_steps(text, 0.02, 2e-7), 1e-11);
}
END_TEST

/* A ball joint that carries a flap in oil. */
START_TEST(a_stiff_body_in_space_moves_as_with_short_steps)
{
    static const char text[] =
        "mechanism: ball\nbodies:\n"
        "  post: {joint: R y, mass: 1 kg, inertia: {yy: 0.01 kg m^2}, initial: {speed: 2 rad/s}, "
        "points: {e: [0.2 m, 0, 0]}}\n"
        "  bob: {parent: post, at: post.e, joint: ball, mass: 1 kg, centre: [0, 0, -0.1 m], "
        "inertia: {xx: 0.003 kg m^2, yy: 0.002 kg m^2, zz: 0.002 kg m^2}, "
        "initial: {spin: [1 rad/s, 2 rad/s, 3 rad/s]}}\n"
        "  flap: {parent: bob, joint: R x, mass: 1 g, inertia: {xx: 1e-6 kg m^2, yy: 1e-6 kg m^2, "
        "zz: 1e-6 kg m^2}, damping: 10 N m s/rad, spring: {k: 3 N m/rad}, "
        "initial: {position: 0.5 rad}}\nsimulation: {dt: 10 ms, until: 1 s}\n";
    ck_assert_double_lt(off_short_steps(text, 0.02, 2e-7), 1e-11);
}
END_TEST

/* The block of dry friction stops where the closed form says, whatever else is in oil. */
START_TEST(what_sticks_may_be_stiff_as_well)
{
    static const char text[] =
        "mechanism: block\nbodies:\n"
        "  block: {joint: T x, mass: 1 kg, spring: {k: 100 N/m}, friction: {A: 2 N, stick: yes}, "
        "initial: {position: 0.35 m}}\n"
        "  flap: {joint: R y, mass: 1 g, inertia: {yy: 5.5e-6 kg m^2}, spring: {k: 50 N m/rad}, "
        "damping: 55 N m s/rad, initial: {position: 0.7 rad}}\nsimulation: {dt: 10 ms, until: 4 "
        "s}\n";
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_CONTROLLED);
    ck_assert_stein(stein_run(sim, 4.0, err));
    ck_assert_int_gt(2 * counts_of(sim).implicit, counts_of(sim).taken);
    ck_assert_close(stein_q(sim)[0], 0.01, 0.0, 1e-9);
    ck_assert_close(stein_q(sim)[1], flap(4.0), 0.0, 1e-9);
    ck_assert_double_eq(stein_qd(sim)[0], 0.0);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* Bars of a four-bar that are all flat: f has no slopes there. */
START_TEST(near_a_singular_position_steps_are_explicit)
{
    lab_model *model = NULL;
    lab_options options = cache_here(NULL);
    ck_assert_stein(lab_open(&model, "tests/validate/four_bars.yaml", &options, err));
    stein_sim *sim = sim_of(model, STEIN_IMPLICIT);
    ck_assert_stein(stein_run(sim, 0.7, err));
    ck_assert_int_eq(counts_of(sim).implicit, counts_of(sim).taken);
    ck_assert_stein(stein_run(sim, 0.72, err));
    ck_assert_int_lt(counts_of(sim).implicit, counts_of(sim).taken);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* The crank, with its slide at 45 deg, a hundred times as small: the elements of J of the hinges
 * are their arms in metres, that of the slide is 1. */
START_TEST(arms_of_millimetres_beside_a_slide_are_not_near_a_singular_position)
{
    static const char text[] =
        "mechanism: crank\ngravity: [0, 0, -0.0981 m/s^2]\nbodies:\n"
        "  ramp: {joint: R -y, initial: {position: 45 deg}}\n"
        "  crank: {joint: R -y, mass: 1 kg, inertia: {yy: 1e-6 kg m^2}, points: {e: [1 mm, 0, 0]},"
        " initial: {position: 2 rad, speed: 3 rad/s}}\n"
        "  rod: {parent: crank, at: crank.e, joint: R -y, mass: 0.5 kg, centre: [1.5 mm, 0, 0], "
        "inertia: {yy: 4e-7 kg m^2}, points: {e: [3 mm, 0, 0]}, initial: {guess: -1.3 rad}}\n"
        "  block: {parent: ramp, joint: T x, mass: 0.3 kg, points: {c: [0, 0, 0]}, "
        "initial: {guess: 3.5 mm}}\n"
        "  tip: {parent: block, joint: T x, mass: 1 g, spring: {k: 1e5 N/m}, damping: 1e4 N s/m}\n"
        "inputs: {hold: {motion: ramp, idle: hold}}\n"
        "loops: {pin: {between: [rod.e, block.c]}}\nsimulation: {dt: 10 ms, until: 1 s}\n";
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_IMPLICIT);
    ck_assert_stein(stein_run(sim, 1.0, err));
    ck_assert_int_eq(counts_of(sim).implicit, counts_of(sim).taken);
    ck_assert(counts_of(sim).refused == NULL);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* ---- mechanisms without implicit steps ---- */

static void hook(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q;
    Q[0] -= 3.0 * qd[0];
}

static void gentle(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.1 * t;
}

/* the same bits as a run without the query, and the reason */
static void check_refused(lab_model *model, int what, const char *why)
{
    stein_sim *sim[2];
    static const stein_integrator kind[] = {STEIN_IMPLICIT, STEIN_CONTROLLED};
    stein_sensitivity *s = NULL;
    double dp[512] = {1.0};
    for (int i = 0; i < 2; i++) {
        sim[i] = sim_of(model, kind[i]);
        if (what == 1) {
            stein_on_force(sim[i], hook, NULL);
        } else if (what == 2) {
            ck_assert_stein(stein_drive(sim[i], "push", gentle, NULL, err));
        } else if (what == 3 && i == 0) {
            ck_assert_stein(stein_sensitivity_create(&s, stein_sim_model(sim[i]), NULL, 1, err));
            ck_assert_stein(stein_sensitivity_attach(s, sim[i], err));
            stein_sensitivity_set(s, 0, NULL, NULL, dp);
        }
        ck_assert_stein(stein_run(sim[i], 0.05, err));
        ck_assert_int_eq(counts_of(sim[i]).implicit, 0);
    }
    const char *told = counts_of(sim[0]).refused;
    ck_assert_msg(told != NULL && strstr(told, why) != NULL, "%s: %s", why, told);
    ck_assert(counts_of(sim[1]).refused == NULL);
    ck_assert_mem_eq(stein_q(sim[0]), stein_q(sim[1]),
                     sizeof(double) * (size_t)stein_sim_model(sim[0])->nq);
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim[0]);
    stein_sim_destroy(sim[1]);
}

START_TEST(mechanisms_without_implicit_steps_stay_explicit_with_a_reason)
{
    static const char pushed[] =
        "mechanism: pushed\nbodies: {rod: {joint: R -y, mass: 1 kg, centre: [0, 0, -0.3 m], "
        "damping: 0.1 N m s/rad, initial: {position: 1 rad}}}\ninputs: {push: {torque: rod}}\n"
        "outputs: {q: {joint: rod, read: position}}\nsimulation: {dt: 1 ms}\n";
    lab_model *rod = open_text(pushed, NULL, 0);
    check_refused(rod, 1, "hook");
    check_refused(rod, 2, "signal");
    check_refused(rod, 3, "sensitivities");
    lab_close(rod);
}
END_TEST

/* a stiff motion that may not be implicit reports it as well */
START_TEST(a_stiff_motion_that_stays_explicit_has_a_reason)
{
    lab_model *model = open_text(oil, NULL, 0);
    stein_sim *sim = sim_of(model, STEIN_CONTROLLED);
    stein_on_force(sim, hook, NULL);
    ck_assert_stein(stein_run(sim, 1e-4, err));
    stein_step_counts n = counts_of(sim);
    ck_assert(n.implicit == 0 && n.rate > 8e6 && n.refused != NULL);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(a_batch_takes_explicit_steps_unless_implicit_ones_are_requested)
{
    static const stein_integrator kind[] = {STEIN_CONTROLLED, STEIN_IMPLICIT};
    lab_model *model = open_text(oil, NULL, 0);
    for (int k = 0; k < 2; k++) {
        double end = k == 0 ? 1e-4 : 0.4, ends[2] = {end, end};
        stein_sim *in[2], *alone = sim_of(model, kind[k]);
        stein_sim_def def = lab_def(model);
        stein_batch *batch = NULL;
        stein_status ended[2];
        stein_pace pace[3];
        def.integrator = kind[k];
        ck_assert_stein(stein_batch_create(&batch, stein_sim_model(alone), &def, 2, 0, err));
        for (int i = 0; i < 3; i++) {
            pace[i] =
                (stein_pace){.tolerance = 1e-10, .longest = 0.02, .h = 1e-6, .next = INFINITY};
        }
        for (int i = 0; i < 2; i++) {
            in[i] = sim_of(model, kind[k]);
            ck_assert_stein(stein_batch_put(batch, i, in[i], err));
        }
        ck_assert_stein(stein_batch_run_adaptive(batch, ends, pace, ended, err));
        ck_assert_stein(stein_run_adaptive(alone, end, &pace[2], err));
        for (int i = 0; i < 2; i++) {
            const stein_sim *sim = stein_batch_look(batch, i);
            ck_assert((counts_of(sim).implicit > 0) == (k == 1));
            ck_assert_close(stein_q(sim)[0], stein_q(alone)[0], 0.0, k == 1 ? 0.0 : 1e-9);
        }
        ck_assert(counts_of(alone).implicit > 0);
        stein_batch_destroy(batch);
        stein_sim_destroy(in[0]);
        stein_sim_destroy(in[1]);
        stein_sim_destroy(alone);
    }
    lab_close(model);
}
END_TEST

START_TEST(implicit_steps_are_made_in_the_block_of_the_simulation)
{
    lab_model *model = open_text(oil, NULL, 0);
    stein_sim *sim = NULL;
    int blocks = 0;
    stein_sim_def def = lab_def(model);
    def.alloc = count_alloc;
    def.release = count_release;
    def.ctx = &blocks;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    int after = blocks;
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert(counts_of(sim).implicit > 0);
    ck_assert_int_eq(blocks, after);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

Suite *stiff_suite(void)
{
    Suite *suite = suite_create("stiff");
    TCase *core = tcase_create("core");
    tcase_add_checked_fixture(core, make_folder, remove_folder);
    tcase_add_test(core, implicit_steps_have_order_five);
    tcase_add_test(core, inside_of_implicit_steps_the_order_is_four);
    tcase_add_test(core, an_overdamped_joint_costs_hundreds_of_steps_instead_of_millions);
    tcase_add_test(core, steps_are_explicit_again_where_nothing_is_stiff);
    tcase_add_test(core, a_saved_state_continues_with_the_same_kind_of_steps_and_the_same_bits);
    tcase_add_loop_test(core, contacts_of_extreme_stiffness_come_to_rest, 0, 6);
    tcase_add_test(core, the_stiff_governor_agrees_with_equations_by_hand);
    tcase_add_test(core, implicit_steps_have_the_same_bits_everywhere);
    tcase_add_test(core, links_off_the_plane_are_derived_exactly);
    tcase_add_test(core, a_stiff_loop_moves_as_with_short_steps);
    tcase_add_test(core, a_stiff_body_in_space_moves_as_with_short_steps);
    tcase_add_test(core, what_sticks_may_be_stiff_as_well);
    tcase_add_test(core, near_a_singular_position_steps_are_explicit);
    tcase_add_test(core, arms_of_millimetres_beside_a_slide_are_not_near_a_singular_position);
    tcase_add_test(core, mechanisms_without_implicit_steps_stay_explicit_with_a_reason);
    tcase_add_test(core, a_stiff_motion_that_stays_explicit_has_a_reason);
    tcase_add_test(core, a_batch_takes_explicit_steps_unless_implicit_ones_are_requested);
    tcase_add_test(core, implicit_steps_are_made_in_the_block_of_the_simulation);
    tcase_set_timeout(core, 60);
    suite_add_tcase(suite, core);
    return suite;
}
