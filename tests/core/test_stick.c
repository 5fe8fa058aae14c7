/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_stick.c - friction that sticks: closed forms, places with the same constraint, rest to the
 * bit, allowed and refused combinations.
 */
#include <string.h>

#include "lab_support.h"
#include "stein/balance.h"
#include "stein/batch.h"
#include "stein/derivative.h"

Suite *stick_suite(void);

static const double g = 9.81, pi = 3.14159265358979323846;
static lab_model *model;

/* ---- a run and its events at places ---- */

enum { MOST = 1000 };
static stein_event seen[MOST];
static double seen_q[MOST];
static int nseen;

static void note(void *ctx, stein_sim *sim, const stein_event *event)
{
    (void)ctx;
    if (event->kind >= STEIN_EVENT_STICK) {
        ck_assert_int_lt(nseen, MOST);
        seen_q[nseen] = stein_q(sim)[0];
        seen[nseen++] = *event;
    }
}

static stein_sim *start(const char *text, stein_integrator integrator)
{
    stein_sim *sim = NULL;
    model = open_text(text, NULL, 0);
    stein_sim_def def = stein_sim_def_default(lab_equations(model));
    def.integrator = integrator;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    nseen = 0;
    stein_on_event(sim, note, NULL);
    return sim;
}

static void finish(stein_sim *sim)
{
    stein_sim_destroy(sim);
    lab_close(model);
}

static stein_held held(stein_sim *sim, int place)
{
    stein_held h;
    ck_assert_stein(stein_stick_read(sim, place, &h, err));
    return h;
}

static double value(stein_sim *sim, const char *channel)
{
    double x = 0.0;
    ck_assert_stein(stein_read_name(sim, channel, &x, err));
    return x;
}

/* the n coordinates keep their bits over `steps` steps */
static void assert_rests(stein_sim *sim, int n, long steps)
{
    double q[8];
    memcpy(q, stein_q(sim), sizeof *q * (size_t)n);
    for (long i = 0; i < steps; i++) {
        ck_assert_stein(stein_step(sim, err));
    }
    ck_assert_mem_eq(q, stein_q(sim), sizeof *q * (size_t)n);
}

static void linear(void *ctx, double t, double u[3])
{
    double rate = *(double *)ctx;
    u[0] = rate * t;
    u[1] = rate;
    u[2] = 0.0;
}

/* ---- closed forms of one place ---- */

static const char pulled[] =
    "mechanism: pulled\n"
    "bodies: {block: {joint: T x, mass: 1.3 kg, friction: {A: 2 N, B1: 0.7, B2: 0.4, stick: "
    "yes}}}\n"
    "inputs: {pull: {torque: block}}\n"
    "outputs: {x: {joint: block, read: position}}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";

/* x' = r s^2 / 2m, s = t - mu_s N / r, and what mu_s is above mu: (mu_s - mu) N s / m */
START_TEST(a_rising_force_breaks_it_loose_at_the_static_limit)
{
    stein_sim *sim = start(pulled, _i ? STEIN_CONTROLLED : STEIN_RK4);
    double rate = -3.7, law[] = {2.0, 0.05, 0.7, 0.4};
    double limit = 2.0 * (1.0 + 0.75 * 0.7 * pow(1.2, -0.25)), at = limit / -rate;
    ck_assert_close(stein_stick_limit(law), limit, 1e-15, 0.0);
    ck_assert_stein(stein_drive(sim, "pull", linear, &rate, err));
    ck_assert_stein(stein_run(sim, 0.9 * at, err));
    ck_assert(stein_q(sim)[0] == 0.0 && stein_qd(sim)[0] == 0.0);
    ck_assert_close(held(sim, 0).force, 0.9 * limit, 1e-12, 0.0);
    ck_assert_stein(stein_run(sim, at + 0.2, err));
    ck_assert_int_eq(nseen, 1);
    ck_assert_int_eq(seen[0].kind, STEIN_EVENT_SLIP);
    ck_assert_int_eq(seen[0].phase, -1);
    ck_assert_close(seen[0].time, at, 0.0, 1e-12);
    ck_assert_close(stein_qd(sim)[0], (0.5 * rate * 0.04 - (limit - 2.0) * 0.2) / 1.3, 1e-10, 0.0);
    ck_assert_str_eq(stein_event_at(lab_equations(model), &seen[0]), "block");
    finish(sim);
}
END_TEST

static const char contact_pulled[] =
    "mechanism: contact_pulled\n"
    "bodies:\n"
    "  x: {joint: T x, mass: 0}\n"
    "  block: {parent: x, joint: T z, mass: 1.3 kg, points: {c: [0, 0, 0]}, initial: {position: "
    "-1.2753 mm}}\n"
    "contacts: {floor: {between: [{point: block.c}, {line: {on: frame, at: [0, 0, 0], facing: 90 "
    "deg}}], normal: {c: 1e4 N/m, D: 1 s/m}, friction: {A: 0.4, stick: yes}}}\n"
    "inputs: {pull: {torque: x}}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";

START_TEST(a_block_breaks_loose_at_mu_times_its_weight)
{
    stein_sim *sim = start(contact_pulled, _i ? STEIN_CONTROLLED : STEIN_RK4);
    double rate = 3.7, at = 0.4 * 1.3 * g / rate;
    ck_assert_stein(stein_drive(sim, "pull", linear, &rate, err));
    ck_assert_stein(stein_run(sim, at + 0.1, err));
    ck_assert_int_eq(nseen, 1);
    ck_assert_close(seen[0].time, at, 0.0, 1e-9);
    ck_assert_close(stein_qd(sim)[0], 0.5 * rate * 0.01 / 1.3, 1e-8, 0.0);
    finish(sim);
}
END_TEST

static const char swinging[] =
    "mechanism: swinging\n"
    "bodies: {block: {joint: T x, mass: 0.8 kg, spring: {k: 50 N/m}, friction: {A: 0.3 N, vt: 1 "
    "mm/s, stick: yes}, initial: {position: 0.1 m}}}\n"
    "outputs: {x: {joint: block, read: position}}\n"
    "simulation: {dt: 1 ms, until: 5 s}\n";

/* (-1)^n (x0 - 2 n A / k), half a period apart, until it is within A / k */
START_TEST(turning_points_fall_by_two_dead_bands_and_it_stops_within_one)
{
    stein_sim *sim = start(swinging, _i ? STEIN_CONTROLLED : STEIN_RK4);
    double band = 0.3 / 50.0, half = pi / sqrt(50.0 / 0.8), x = 0.1;
    double tolerance = _i ? 1e-10 : 2e-9;
    ck_assert_stein(stein_run(sim, 5.0, err));
    ck_assert_int_eq(nseen, 8); // at 0.1 it let go between two samples
    for (int n = 0; n < nseen; n++) {
        x = -copysign(fabs(x) - 2.0 * band, x);
        ck_assert_close(seen[n].time, (n + 1) * half, 0.0, 1e-8);
        ck_assert_close(seen_q[n], x, 0.0, tolerance);
        ck_assert_int_eq(seen[n].kind, n < 7 ? STEIN_EVENT_SLIP : STEIN_EVENT_STICK);
        ck_assert_int_eq(seen[n].phase, n == 7 ? 0 : x > 0.0 ? -1 : 1);
    }
    ck_assert_double_lt(fabs(x), band);
    ck_assert_double_eq(stein_q(sim)[0], seen_q[7]);
    ck_assert_double_eq(stein_qd(sim)[0], 0.0);
    assert_rests(sim, 1, 100);
    finish(sim);
}
END_TEST

/* on a spring whose end moves with V: m y'' = -k y around the force of slip, from a = (F_s - F) / k
 * with y' = V, until y' = V again at -a: after 2 (pi - atan(a w / V)) / w; then it sticks for
 * 2 a / V */
static double stick_slip_period(double m, double k, double surplus, double V)
{
    double w = sqrt(k / m), a = surplus / k;
    return 2.0 * (pi - atan(a * w / V)) / w + 2.0 * a / V;
}

/* at the begins of slip, after the first one */
static double mean_period(void)
{
    double first = 0.0, last = 0.0;
    int n = 0;
    for (int i = 0; i < nseen; i++) {
        if (seen[i].kind == STEIN_EVENT_SLIP) {
            first = n == 1 ? seen[i].time : first;
            last = seen[i].time;
            n++;
        }
    }
    ck_assert_int_gt(n, 5);
    return (last - first) / (n - 2);
}

static const char dragged[] =
    "mechanism: dragged\n"
    "bodies:\n"
    "  hand: {joint: T x, mass: 1 kg, points: {p: [1 m, 0, 0]}}\n"
    "  block: {joint: T x, mass: 0.8 kg, points: {p: [0, 0, 0]}, friction: {A: 1.1 N, B1: 0.5, B2: "
    "0.3333333333333333, stick: yes}}\n"
    "links: {spring: {from: block.p, to: hand.p, k: 120 N/m, length: 1 m}}\n"
    "inputs: {drive: {motion: hand}}\n"
    "simulation: {dt: 1 ms, until: 4 s}\n";

START_TEST(a_mass_on_a_pulled_spring_sticks_and_slips_with_the_known_period)
{
    stein_sim *sim = start(dragged, _i ? STEIN_CONTROLLED : STEIN_RK4);
    double V = 0.05, period = stick_slip_period(0.8, 120.0, 1.1 * 0.375, V);
    ck_assert_stein(stein_drive(sim, "drive", linear, &V, err));
    ck_assert_stein(stein_run(sim, 4.0, err));
    ck_assert_close(mean_period(), period, 0.0, 1e-8);
    finish(sim);
}
END_TEST

static const char on_belt[] =
    "mechanism: on_belt\n"
    "bodies:\n"
    "  belt: {joint: T x, mass: 1 kg}\n"
    "  x: {joint: T x, mass: 0, spring: {k: 120 N/m}}\n"
    "  block: {parent: x, joint: T z, mass: 0.8 kg, points: {c: [0, 0, 0]}, initial: {position: "
    "-0.7848 mm}}\n"
    "contacts: {belt_top: {between: [{point: block.c}, {line: {on: belt, at: [0, 0, 0], facing: 90 "
    "deg}}], normal: {c: 1e4 N/m, D: 1 s/m}, friction: {A: 0.14, B1: 0.5, B2: 0.3333333333333333, "
    "stick: yes}}}\n"
    "inputs: {drive: {motion: belt}}\n"
    "simulation: {dt: 1 ms, until: 4 s}\n";

START_TEST(so_does_a_block_on_a_belt_and_no_energy_is_lost_on_the_way)
{
    stein_sim *sim = start(on_belt, STEIN_CONTROLLED);
    stein_balance *balance = NULL;
    stein_energy_total total;
    double N = 0.8 * g, V = 0.05, period = stick_slip_period(0.8, 120.0, 0.14 * N * 0.375, V);
    ck_assert_stein(stein_balance_create(&balance, lab_equations(model), NULL, err));
    ck_assert_stein(stein_drive(sim, "drive", linear, &V, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_balance_attach(balance, sim, err));
    ck_assert_stein(stein_run(sim, 4.0, err));
    ck_assert_close(mean_period(), period, 0.0, 1e-8);
    stein_balance_total(balance, &total);
    ck_assert_double_gt(total.dissipated, 0.01);
    ck_assert_close(total.unexplained, 0.0, 0.0, 1e-9 * total.scale);
    ck_assert_close(total.other, 0.0, 0.0, 1e-9 * total.scale);
    ck_assert_close(-stein_balance_work(balance, STEIN_WORK_FRICTION, 0), total.dissipated, 1e-6,
                    0.0);
    stein_balance_destroy(balance);
    finish(sim);
}
END_TEST

static const char tilted[] =
    "mechanism: tilted\n"
    "bodies: {rod: {joint: R -y, mass: 0.5 kg, centre: [0, 0, -0.2 m], inertia: {yy: 2e-3}, "
    "friction: {A: 0.2 N m, stick: yes}, initial: {position: 1.1 rad}}}\n"
    "outputs: {angle: {joint: rod, read: position}}\n"
    "simulation: {dt: 1 ms, until: 5 s}\n";

START_TEST(a_pendulum_comes_to_rest_tilted_where_friction_holds_it)
{
    stein_sim *sim = start(tilted, _i ? STEIN_CONTROLLED : STEIN_RK4);
    ck_assert_stein(stein_run(sim, 5.0, err));
    double q = stein_q(sim)[0], needs = 0.5 * g * 0.2 * sin(q);
    ck_assert_double_gt(fabs(q), 0.02);
    ck_assert_double_le(fabs(needs), 0.2);
    ck_assert_int_eq(held(sim, 0).slips, 0);
    ck_assert_close(held(sim, 0).force, needs, 1e-12, 0.0);
    ck_assert_double_eq(stein_qd(sim)[0], 0.0);
    assert_rests(sim, 1, 1000);
    finish(sim);
}
END_TEST

/* ---- contacts ---- */

/* tan 5 deg is far below mu */
static const char slope[] =
    "mechanism: slope_stick\n"
    "bodies:\n"
    "  sx: {joint: T x, mass: 0}\n"
    "  block: {parent: sx, joint: T z, mass: 10 kg, points: {c: [0, 0, 0]}}\n"
    "contacts: {floor: {between: [{point: block.c}, {line: {on: frame, at: [0, 0, 0], facing: 85 "
    "deg}}], normal: {c: 1e4 N/m, D: 2 s/m}, friction: {A: 0.7, vt: 0.01 m/s, stick: yes}}}\n"
    "outputs: {f: {contact: floor, read: friction}, n: {contact: floor, read: force}}\n"
    "simulation: {dt: 20 ms, until: 1 s}\n";

START_TEST(a_block_below_the_friction_angle_does_not_move_for_an_hour)
{
    stein_sim *sim = start(slope, STEIN_RK4);
    ck_assert_stein(stein_run(sim, 10.0, err)); // it has dropped into the elastic floor
    ck_assert_close(value(sim, "f"), -10.0 * g * sin(pi / 36.0), 1e-12, 0.0);
    ck_assert_close(value(sim, "n"), 10.0 * g * cos(pi / 36.0), 1e-12, 0.0);
    int before = nseen;
    assert_rests(sim, 2, 180000);
    ck_assert_int_eq(nseen, before);
    finish(sim);
}
END_TEST

static const char box[] =
    "mechanism: box_stick\n"
    "bodies:\n"
    "  x: {joint: T x, initial: {speed: %s}}\n"
    "  z: {parent: x, joint: T z, initial: {position: %s}}\n"
    "  b: {parent: z, joint: R y, mass: 1 kg, centre: [50 mm, 0, 0], inertia: {yy: 0.0417}, "
    "initial: {position: %s}}\n"
    "contacts: {f: {between: [{line: {on: b, at: [0, 0, -0.25 m], facing: -90 deg, extent: [-0.25 "
    "m, 0.25 m]}}, {line: {on: frame, at: [0, 0, -0.25 m], facing: %s}}], normal: {c: 1e5 N/m, D: "
    "1 s/m}, friction: {A: 0.5, vt: 1 mm/s, stick: yes}}}\n"
    "outputs: {f: {contact: f, read: friction}, n: {contact: f, read: force}}\n"
    "simulation: {dt: 0.5 ms, until: 1 s}\n";

static stein_sim *start_box(const char *speed, const char *z, const char *tilt, const char *facing,
                            stein_integrator integrator)
{
    char text[1500];
    snprintf(text, sizeof text, box, speed, z, tilt, facing);
    return start(text, integrator);
}

START_TEST(two_corners_of_a_box_hold_the_same_and_share_it_by_their_loads)
{
    stein_sim *sim = start_box("0", "4 mm", "10 deg", "80 deg", _i ? STEIN_CONTROLLED : STEIN_RK4);
    ck_assert_stein(stein_run(sim, 8.0, err));
    stein_held h[] = {held(sim, 0), held(sim, 1)};
    ck_assert(h[0].slips == 0 && h[1].slips == 0);
    ck_assert_int_eq(h[0].shared + h[1].shared, 1);
    ck_assert_close(h[0].force + h[1].force, -g * sin(pi / 18.0), 1e-9, 0.0);
    ck_assert_close(h[0].force / h[1].force, h[0].limit / h[1].limit, 1e-9, 0.0);
    ck_assert_double_gt(fabs(h[0].limit - h[1].limit), 0.5);
    ck_assert_close(value(sim, "f"), h[0].force + h[1].force, 1e-12, 0.0);
    double q = stein_q(sim)[0];
    ck_assert_stein(stein_run(sim, 30.0, err));
    ck_assert_close(stein_q(sim)[0], q, 0.0, 1e-13);
    finish(sim);
}
END_TEST

/* it drops on a corner, hops and rocks until it lies */
START_TEST(a_tumbling_box_dissipates_by_friction_and_damping_alone)
{
    stein_sim *sim =
        start_box("0.1 m/s", "0", "0.02 rad", "90 deg", _i ? STEIN_CONTROLLED : STEIN_RK4);
    stein_balance *balance = NULL;
    stein_energy_total total;
    ck_assert_stein(stein_balance_create(&balance, lab_equations(model), NULL, err));
    ck_assert_stein(stein_balance_attach(balance, sim, err));
    for (int i = 1; i <= 20; i++) {
        ck_assert_stein(stein_run(sim, 0.2 * i, err));
        stein_balance_total(balance, &total);
        ck_assert_close(total.unexplained, 0.0, 0.0, (_i ? 1e-7 : 2e-3) * total.scale);
        ck_assert_double_lt(total.now + total.dissipated, total.begin + 2.0);
    }
    ck_assert_int_gt(nseen, 20);
    ck_assert(held(sim, 0).slips == 0 && held(sim, 1).slips == 0);
    stein_balance_destroy(balance);
    finish(sim);
}
END_TEST

/* v^2 = 2 mu g s */
START_TEST(a_box_slides_flat_and_stops_with_both_corners)
{
    stein_sim *sim = start_box("0.3 m/s", "-0.04905 mm", "0", "90 deg", STEIN_CONTROLLED);
    ck_assert_stein(stein_run(sim, 8.0, err));
    ck_assert_close(stein_q(sim)[0], 0.09 / (2.0 * 0.5 * g), 0.02, 0.0); // friction makes it nod
    ck_assert(held(sim, 0).slips == 0 && held(sim, 1).slips == 0);
    double q = stein_q(sim)[0];
    ck_assert_stein(stein_run(sim, 9.0, err));
    ck_assert_close(stein_q(sim)[0], q, 0.0, 1e-15); // it still nods by rounding
    finish(sim);
}
END_TEST

START_TEST(a_steeper_slope_than_the_friction_angle_lets_it_slide)
{
    stein_sim *sim = start_box("0", "39 mm", "30 deg", "60 deg", STEIN_CONTROLLED);
    ck_assert_stein(stein_run(sim, 3.0, err));
    double v = stein_qd(sim)[0];
    ck_assert_stein(stein_run(sim, 4.0, err));
    double a = g * (sin(pi / 6.0) - 0.5 * cos(pi / 6.0));
    ck_assert_close(stein_qd(sim)[0] - v, a * cos(pi / 6.0), 0.02, 0.0); // it rattles
    finish(sim);
}
END_TEST

/* a = g sin s / (1 + I / m r^2): the place on the rim that touches is at rest */
static const char wheel[] =
    "mechanism: rolling_wheel\n"
    "bodies:\n"
    "  x: {joint: T x}\n"
    "  z: {parent: x, joint: T z, initial: {position: 49.9 mm}}\n"
    "  w: {parent: z, joint: R y, mass: 2 kg, inertia: {yy: 3e-3}, points: {c: [0, 0, 0]}}\n"
    "contacts: {road: {between: [{circle: {at: w.c, radius: 50 mm}}, {line: {on: frame, at: [0, 0, "
    "0], facing: 75 deg}}], normal: {c: 1e5 N/m, D: 3 s/m}, friction: {A: 0.6, stick: yes}}}\n"
    "simulation: {dt: 0.2 ms, until: 1 s}\n";

START_TEST(a_wheel_rolls_down_without_sliding)
{
    stein_sim *sim = start(wheel, _i ? STEIN_CONTROLLED : STEIN_RK4);
    ck_assert_stein(stein_run(sim, 0.6, err));
    double w = stein_qd(sim)[2], s = pi / 12.0, x = stein_q(sim)[0], z = stein_q(sim)[1];
    double along = x * cos(s) - z * sin(s), turned = 0.05 * stein_q(sim)[2] - along;
    ck_assert_stein(stein_run(sim, 1.6, err));
    ck_assert_close((stein_qd(sim)[2] - w) * 0.05, g * sin(s) / (1.0 + 3e-3 / (2.0 * 0.0025)), 1e-6,
                    0.0);
    along = stein_q(sim)[0] * cos(s) - stein_q(sim)[1] * sin(s);
    ck_assert_close(0.05 * stein_q(sim)[2] - along, turned, 0.0, 1e-12); // nothing creeps
    finish(sim);
}
END_TEST

/* two bodies that move in any way, and a contact of each kind that is deep enough to press */
static const char moving[] =
    "mechanism: two_moving\n"
    "gravity: [0, 0, 0]\n"
    "bodies:\n"
    "  ax: {joint: T x, mass: 0.3 kg}\n"
    "  az: {parent: ax, joint: T z, mass: 0.2 kg}\n"
    "  a: {parent: az, joint: R y, mass: 1 kg, inertia: {yy: 0.01}, points: {c: [20 mm, 0, 10 "
    "mm]}}\n"
    "  arm: {joint: R -y, at: [-0.2, 0, 0], mass: 0.4 kg, inertia: {yy: 0.02}}\n"
    "  b: {parent: arm, joint: T x, at: [0.1, 0, 0], mass: 0.5 kg, inertia: {yy: 0.02}, points: "
    "{c: [50 mm, 0, -60 mm]}}\n"
    "contacts: {touch: {between: [{circle: {at: a.c, radius: 40 mm}}, %s], normal: {c: 1e3 N/m}, "
    "friction: {A: 1e3, stick: yes}}}\n"
    "simulation: {dt: 0.1 ms, until: 1 s}\n";
static const char *const second_side[] = {
    "{circle: {at: b.c, radius: 50 mm}}",
    "{line: {on: b, at: [50 mm, 0, -20 mm], facing: 80 deg}}",
};

/* the speed of sliding stays 0 along qd, qdd of the present state, to first order */
START_TEST(sticking_places_have_no_sliding_acceleration_in_any_motion)
{
    char text[1500];
    double q[5] = {-0.07, 0.02, 0.3, 0.2, 0.03}, qd[5] = {0.4, -0.3, 5.0, 2.0, 0.7}, speed[2];
    snprintf(text, sizeof text, moving, second_side[_i]);
    stein_sim *sim = start(text, STEIN_RK4);
    for (int i = 0; i < 2; i++) { // onto v = 0, which is linear in qd
        qd[2] = i;
        ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
        ck_assert_int_eq(held(sim, 0).touches, 1);
        speed[i] = held(sim, 0).speed;
    }
    qd[2] = -speed[0] / (speed[1] - speed[0]);
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    ck_assert_int_eq(held(sim, 0).slips, 0);
    ck_assert_double_gt(fabs(held(sim, 0).force), 0.1);
    double qdd[5], dt = 1e-6;
    memcpy(qdd, stein_qdd(sim), sizeof qdd);
    memcpy(qd, stein_qd(sim), sizeof qd);
    for (int i = 0; i < 2; i++) {
        double q1[5], qd1[5], h = i ? dt : -dt;
        for (int j = 0; j < 5; j++) {
            q1[j] = q[j] + h * qd[j];
            qd1[j] = qd[j] + h * qdd[j];
        }
        ck_assert_stein(stein_set_state(sim, 0.0, q1, qd1, err));
        speed[i] = held(sim, 0).speed;
    }
    ck_assert_close((speed[1] - speed[0]) / (2.0 * dt), 0.0, 0.0, 1e-6);
    finish(sim);
}
END_TEST

/* ---- together with other things ---- */

static const char linkage[] =
    "mechanism: stiff_linkage\n"
    "bodies:\n"
    "  crank: {joint: R -y, mass: 0.5 kg, centre: [50 mm, 0, 0], inertia: {yy: 5e-4}, points: "
    "{pin: [100 mm, 0, 0]}, friction: {A: 0.15 N m, stick: yes}, initial: {position: 90 deg, "
    "speed: 12 rad/s}}\n"
    "  coupler: {parent: crank, at: crank.pin, joint: R -y, mass: 0.8 kg, centre: [150 mm, 0, 0], "
    "inertia: {yy: 6e-3}, points: {end: [300 mm, 0, 0]}, friction: {A: 0.1 N m, stick: yes}}\n"
    "  rocker: {at: [300 mm, 0, 0], joint: R -y, mass: 0.6 kg, centre: [100 mm, 0, 0], inertia: "
    "{yy: 2e-3}, points: {end: [200 mm, 0, 0]}}\n"
    "loops: {pin: {between: [coupler.end, rocker.end]}}\n"
    "simulation: {dt: 1 ms, until: 5 s}\n";

START_TEST(a_linkage_with_two_rough_joints_and_one_way_to_move_comes_to_rest)
{
    stein_sim *sim = start(linkage, STEIN_CONTROLLED);
    ck_assert_stein(stein_run(sim, 5.0, err));
    stein_held h[] = {held(sim, 0), held(sim, 1)};
    ck_assert(h[0].slips == 0 && h[1].slips == 0);
    ck_assert_int_eq(h[0].shared + h[1].shared, 1);
    ck_assert_close(fabs(h[0].force) / h[0].limit, fabs(h[1].force) / h[1].limit, 1e-6, 0.0);
    ck_assert_double_gt(fabs(h[0].force), 1e-3);
    assert_rests(sim, 2, 500);
    finish(sim);
}
END_TEST

START_TEST(a_saved_state_continues_with_the_same_bits)
{
    stein_sim *sim = start(dragged, STEIN_CONTROLLED), *other = NULL;
    double V = 0.05;
    ck_assert_stein(lab_sim(model, NULL, &other, err));
    ck_assert_stein(stein_drive(sim, "drive", linear, &V, err));
    ck_assert_stein(stein_drive(other, "drive", linear, &V, err));
    void *block = malloc(stein_state_size(sim));
    ck_assert_ptr_nonnull(block);
    for (int i = 0; i < 10; i++) { // somewhere of both
        ck_assert_stein(stein_run(sim, 0.0371 * (i + 1), err));
        stein_save(sim, block);
        ck_assert_stein(stein_restore(other, block, err));
        ck_assert_int_eq(held(sim, 0).slips, held(other, 0).slips);
    }
    ck_assert_stein(stein_run(sim, 1.0, err));
    ck_assert_stein(stein_run(other, 1.0, err));
    ck_assert_mem_eq(stein_q(sim), stein_q(other), 2 * sizeof(double));
    free(block);
    finish(other);
    stein_sim_destroy(sim);
}
END_TEST

/* an equilibrium has no friction, and a body at rest then stays there */
START_TEST(a_mechanism_settles_without_its_friction_and_sticks_there)
{
    stein_sim *sim = NULL;
    char text[700];
    snprintf(text, sizeof text, "%.*s, settle: yes}\n", (int)(strrchr(tilted, '}') - tilted),
             tilted);
    sim = start(text, STEIN_CONTROLLED);
    ck_assert_close(stein_q(sim)[0], 0.0, 0.0, 1e-9);
    ck_assert_int_eq(held(sim, 0).slips, 0);
    assert_rests(sim, 1, 100);
    finish(sim);
}
END_TEST

START_TEST(lanes_leave_it_to_one_after_the_other_and_derivatives_refuse)
{
    stein_sim *sim = start(swinging, STEIN_CONTROLLED);
    stein_derivative *derivative = NULL;
    stein_err why;
    stein_held h;
    ck_assert_int_eq(stein_batch_width(lab_equations(model)), 1);
    ck_assert_int_eq(stein_derivative_create(&derivative, lab_equations(model), NULL, &why),
                     STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "has friction that sticks"));
    ck_assert_int_eq(stein_stick_read(sim, 1, &h, &why), STEIN_EINVAL);
    finish(sim);
}
END_TEST

/* ---- files ---- */

START_TEST(files_state_yes_or_no_where_friction_can_stick)
{
    static const char head[] = "mechanism: bad_stick\n"
                               "bodies: {b: {joint: T z, mass: 1 kg, points: {c: [0, 0, 0]}, ";
    static const struct {
        const char *rest, *says;
    } bad[] = {
        {"friction: {A: 1 N, vt: 1 m/s, stick: maybe}}}\n", "maybe"},
        {"friction: {A: 1 N, stick: no}}}\n", "lacks \"vt\""},
        {"friction: {A: 1 N, vt: 1 m/s, sticks: yes}}}\n", "sticks"},
        {"}}\nload: {mass: 1 kg, on: b.c, normal: {c: 1 N/m}, friction: {A: 1, stick: yes}}\n",
         "the friction of the load cannot stick"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[600];
        mechanism *m = NULL;
        stein_err why;
        int n = snprintf(text, sizeof text, "%s%s", head, bad[i].rest);
        ck_assert_int_eq(mech_read_text(&m, "bad.yaml", text, (size_t)n, NULL, 0, NULL, NULL, &why),
                         STEIN_EPARSE);
        ck_assert_msg(strstr(why.msg, bad[i].says) != NULL, "%s", why.msg);
    }
}
END_TEST

/* the speed vt may be stated, so that `stick` alone changes the law; it is no candidate there */
START_TEST(a_number_that_friction_does_not_use_where_it_sticks_is_marked)
{
    static const char text[] =
        "mechanism: marked\n"
        "bodies:\n"
        "  a: {joint: T x, mass: 1 kg, friction: {A: 1 N, vt: 1 m/s, B1: 0.3, stick: yes}}\n"
        "  b: {joint: T x, mass: 1 kg, friction: {A: 1 N, vt: 1 m/s, B1: 0.3}}\n";
    static const struct {
        const char *name;
        int unused;
    } of[] = {{"a.friction.A", 0}, {"a.friction.vt", 1}, {"a.friction.B1", 0}, {"a.friction.B2", 0},
              {"b.friction.A", 0}, {"b.friction.vt", 0}, {"b.friction.B1", 0}, {"a.damping", 0}};
    mechanism *m = NULL;
    ck_assert_stein(
        mech_read_text(&m, "marked.yaml", text, sizeof text - 1, NULL, 0, NULL, NULL, err));
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        int k = mech_find_param(m, of[i].name, NULL);
        ck_assert_msg(k >= 0 && m->params[k].unused == of[i].unused, "%s", of[i].name);
    }
    mech_free(m);
}
END_TEST

Suite *stick_suite(void)
{
    Suite *s = suite_create("stick");
    TCase *tc = tcase_create("stick");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_unchecked_fixture(tc, cache_in_build, NULL);
    tcase_set_timeout(tc, 60);
    tcase_add_loop_test(tc, a_rising_force_breaks_it_loose_at_the_static_limit, 0, 2);
    tcase_add_loop_test(tc, a_block_breaks_loose_at_mu_times_its_weight, 0, 2);
    tcase_add_loop_test(tc, turning_points_fall_by_two_dead_bands_and_it_stops_within_one, 0, 2);
    tcase_add_loop_test(tc, a_mass_on_a_pulled_spring_sticks_and_slips_with_the_known_period, 0, 2);
    tcase_add_test(tc, so_does_a_block_on_a_belt_and_no_energy_is_lost_on_the_way);
    tcase_add_loop_test(tc, a_pendulum_comes_to_rest_tilted_where_friction_holds_it, 0, 2);
    tcase_add_test(tc, a_block_below_the_friction_angle_does_not_move_for_an_hour);
    tcase_add_loop_test(tc, two_corners_of_a_box_hold_the_same_and_share_it_by_their_loads, 0, 2);
    tcase_add_loop_test(tc, a_tumbling_box_dissipates_by_friction_and_damping_alone, 0, 2);
    tcase_add_test(tc, a_box_slides_flat_and_stops_with_both_corners);
    tcase_add_test(tc, a_steeper_slope_than_the_friction_angle_lets_it_slide);
    tcase_add_loop_test(tc, a_wheel_rolls_down_without_sliding, 0, 2);
    tcase_add_loop_test(tc, sticking_places_have_no_sliding_acceleration_in_any_motion, 0, 2);
    tcase_add_test(tc, a_linkage_with_two_rough_joints_and_one_way_to_move_comes_to_rest);
    tcase_add_test(tc, a_saved_state_continues_with_the_same_bits);
    tcase_add_test(tc, a_mechanism_settles_without_its_friction_and_sticks_there);
    tcase_add_test(tc, lanes_leave_it_to_one_after_the_other_and_derivatives_refuse);
    tcase_add_test(tc, files_state_yes_or_no_where_friction_can_stick);
    tcase_add_test(tc, a_number_that_friction_does_not_use_where_it_sticks_is_marked);
    suite_add_tcase(s, tc);
    return s;
}
