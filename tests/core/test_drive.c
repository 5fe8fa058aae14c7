/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_drive.c - drives of a joint through a gear: the inertia of a rotor (armature), and a motor
 * at a voltage; and the angle of a body against the frame.
 */
#include <string.h>

#include "lab_support.h"
#include "refused.h"
#include "stein/balance.h"
#include "stein/sensitivity.h"
#include "twins.h"

Suite *drive_suite(void);

/* a motion of 2 s of one file after the other, compared at 40 instants */
static void same_motion(const char *text, const char *other, int joints, double atol)
{
    lab_model *model[2] = {open_text(text, NULL, 0), open_text(other, NULL, 0)};
    stein_sim *sim[2] = {NULL, NULL};
    double way = 0.0;
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(lab_sim(model[k], NULL, &sim[k], err));
    }
    double start = stein_q(sim[0])[0];
    for (int i = 1; i <= 40; i++) {
        for (int k = 0; k < 2; k++) {
            ck_assert_stein(stein_run(sim[k], 0.05 * i, err));
        }
        for (int j = 0; j < joints; j++) {
            ck_assert_close(stein_q(sim[0])[j], stein_q(sim[1])[j], 0.0, atol);
        }
        way = fmax(way, fabs(stein_q(sim[0])[0] - start));
    }
    ck_assert(way > 0.1);
    for (int k = 0; k < 2; k++) {
        stein_sim_destroy(sim[k]);
        lab_close(model[k]);
    }
}

/* an arm on the frame, and a rotor of 2e-6 kg m^2 that a gear turns 30 times as fast */
START_TEST(a_rotor_behind_a_gear_counts_with_the_square_of_the_ratio)
{
    same_motion("mechanism: armature\n"
                "bodies:\n"
                "  arm: {joint: R y, mass: 0.3 kg, centre: [80 mm, 0, 0], inertia: {yy: 1e-3},\n"
                "        armature: 30 * 30 * 2e-6 kg m^2}\n"
                "simulation: {dt: 1 ms, until: 2 s}\n",
                "mechanism: geared\n"
                "bodies:\n"
                "  arm: {joint: R y, mass: 0.3 kg, centre: [80 mm, 0, 0], inertia: {yy: 1e-3}}\n"
                "  rotor: {joint: R y, mass: 40 g, inertia: {yy: 2e-6 kg m^2}}\n"
                "couplings: {gear: {joint: rotor, follows: arm, ratio: -30}}\n"
                "simulation: {dt: 1 ms, until: 2 s}\n",
                1, 1e-10);
}
END_TEST

/* a carriage on a slope, whose screw turns by 400 rad/m */
START_TEST(a_sliding_joint_has_an_armature_in_kilograms)
{
    same_motion("mechanism: armature\n"
                "gravity: [-1 m/s^2, 0, -9 m/s^2]\n"
                "bodies: {cart: {joint: T x, mass: 2 kg, armature: 1.6 kg}}\n"
                "simulation: {dt: 1 ms, until: 2 s}\n",
                "mechanism: screw\n"
                "gravity: [-1 m/s^2, 0, -9 m/s^2]\n"
                "bodies:\n"
                "  cart: {joint: T x, mass: 2 kg}\n"
                "  screw: {joint: R x, mass: 1 kg, inertia: {xx: 1e-5, yy: 1e-5, zz: 1e-5}}\n"
                "couplings: {nut: {joint: screw, follows: cart, ratio: 400 rad/m}}\n"
                "simulation: {dt: 1 ms, until: 2 s}\n",
                1, 1e-10);
}
END_TEST

static const char linkage[] =
    "mechanism: linkage\n"
    "bodies:\n"
    "  crank: {joint: R y, mass: 0.2 kg, centre: [20 mm, 0, 0], inertia: {yy: %s}, %s\n"
    "          initial: {position: 0.4 rad, speed: 9 rad/s}, points: {pin: [50 mm, 0, 0]}}\n"
    "  rod: {parent: crank, at: crank.pin, joint: R y, mass: 0.1 kg, centre: [70 mm, 0, 0],\n"
    "        inertia: {yy: 1e-4}, initial: {guess: -0.5 rad}, points: {end: [150 mm, 0, 0]}}\n"
    "  rocker: {at: [130 mm, 0, -30 mm], joint: R y, mass: 0.1 kg, inertia: {yy: 2e-4},\n"
    "           initial: {guess: -1.2 rad}, points: {end: [90 mm, 0, 0]}}\n"
    "loops: {pin: {between: [rod.end, rocker.end]}}\n"
    "simulation: {dt: 1 ms, until: 2 s}\n";

/* of a joint on the frame it is the same as an inertia of its body */
START_TEST(a_loop_feels_an_armature_of_its_crank_as_a_flywheel)
{
    char with[1200], without[1200];
    snprintf(with, sizeof with, linkage, "1e-4 kg m^2", "armature: 5e-4 kg m^2,");
    snprintf(without, sizeof without, linkage, "6e-4 kg m^2", "");
    same_motion(with, without, 3, 1e-9);
}
END_TEST

/* two links in space; gears without loss */
static const char chain[] =
    "mechanism: chain\n"
    "bodies:\n"
    "  upper: {joint: R z, mass: 1 kg, centre: [0.1, 0, 0], inertia: {xx: 1e-3, yy: 3e-3, zz: "
    "3e-3},\n"
    "          armature: 0.02 kg m^2, initial: {speed: 2 rad/s}}\n"
    "  lower: {parent: upper, at: [0.3, 0, 0], joint: R -y, mass: 0.6 kg, centre: [0.15, 0, 0],\n"
    "          inertia: {xx: 1e-3, yy: 4e-3, zz: 4e-3}, armature: %s}\n"
    "outputs: {kinetic: {energy: kinetic}, potential: {energy: potential}}\n"
    "simulation: {dt: 1 ms, until: 3 s}\n";

START_TEST(energy_has_the_share_of_the_rotors_and_is_kept)
{
    char text[800];
    snprintf(text, sizeof text, chain, "0.01 kg m^2");
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    // at the start: 1/2 2^2 (0.02 + 3e-3 + 0.01 + 4e-3 + 0.6 0.45^2)
    double start = 2.0 * (0.02 + 3e-3 + 0.01 + 4e-3 + 0.6 * 0.45 * 0.45);
    ck_assert_close(stein_read(sim, 1), start, 1e-13, 0.0);
    start += stein_read(sim, 2);
    for (int i = 1; i <= 30; i++) {
        ck_assert_stein(stein_run(sim, 0.1 * i, err));
        ck_assert_close(stein_read(sim, 1) + stein_read(sim, 2), start, 0.0, 1e-9);
    }
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

static stein_sim *chain_after(lab_model *model, double armature)
{
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_set(sim, "lower.armature", armature, err));
    ck_assert_stein(stein_reset(sim, err));
    return sim;
}

START_TEST(a_motion_has_its_sensitivity_to_an_armature)
{
    static const double at = 0.01, h = 1e-5;
    char text[800];
    double high[2], low[2];
    snprintf(text, sizeof text, chain, "0.01 kg m^2");
    lab_model *model = open_text(text, NULL, 0);
    const stein_model *m = lab_equations(model);
    double dp[128] = {0.0};
    ck_assert_int_lt(m->np, 128);
    dp[stein_find_param(m, "lower.armature")] = 1.0;
    for (int k = 0; k < 2; k++) {
        stein_sim *sim = chain_after(model, k == 0 ? at + h : at - h);
        ck_assert_stein(stein_run(sim, 0.7, err));
        memcpy(k == 0 ? high : low, stein_q(sim), sizeof high);
        stein_sim_destroy(sim);
    }
    stein_sim *sim = chain_after(model, at);
    stein_sensitivity *s = NULL;
    ck_assert_stein(stein_sensitivity_create(&s, m, NULL, 1, err));
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    stein_sensitivity_set(s, 0, NULL, NULL, dp);
    ck_assert_stein(stein_run(sim, 0.7, err));
    ck_assert_stein(stein_sensitivity_check(s, err));
    for (int j = 0; j < 2; j++) {
        double slope = (high[j] - low[j]) / (2.0 * h);
        ck_assert(fabs(slope) > 0.1);
        ck_assert_close(stein_sensitivity_q(s, 0)[j], slope, 1e-5, 0.0);
    }
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* a file without one gets it by an override, with new equations */
START_TEST(an_armature_may_be_set_from_outside)
{
    static const char *const set[] = {"upper.armature=0.05"};
    static const char plain[] = "mechanism: plain\n"
                                "bodies: {upper: {joint: R y, mass: 1 kg, centre: [0.1, 0, 0]}}\n"
                                "simulation: {dt: 1 ms, until: 1 s}\n";
    lab_model *model[2] = {open_text(plain, NULL, 0), open_text(plain, set, 1)};
    ck_assert_int_eq(stein_find_param(lab_equations(model[0]), "upper.armature"), -1);
    ck_assert_int_ge(stein_find_param(lab_equations(model[1]), "upper.armature"), 0);
    for (int k = 0; k < 2; k++) {
        stein_sim *sim = NULL;
        ck_assert_stein(lab_sim(model[k], NULL, &sim, err));
        ck_assert_close(stein_qdd(sim)[0], 9.81 * 0.1 / (0.01 + 0.05 * k), 1e-14, 0.0);
        stein_sim_destroy(sim);
        lab_close(model[k]);
    }
}
END_TEST

START_TEST(a_joint_may_have_an_armature_alone)
{
    lab_model *model = open_text("mechanism: alone\n"
                                 "bodies:\n"
                                 "  hub: {joint: R y, armature: 0.3 kg m^2, limits: [-1, 1]}\n"
                                 "inputs: {drive: {torque: hub}}\n",
                                 NULL, 0);
    const stein_model *m = lab_equations(model);
    stein_sim *sim = NULL;
    double q[1] = {1.1}, qd[1] = {0.0};
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    // its stops swing with 100 Hz
    ck_assert_close(stein_qdd(sim)[0], -0.1 * 394784.17604357434, 1e-13, 0.0);
    ck_assert_int_eq(m->nq, 1);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* ---- motors ---- */

/* a wheel on a motor of 0.05 N m/A and 2 ohm behind a gear of 30; %s: more of the wheel */
static const char wheel[] =
    "mechanism: wheel\n"
    "gravity: [0, 0, 0]\n"
    "bodies:\n"
    "  wheel: {joint: R y, mass: 1 kg, inertia: {yy: 0.02}, armature: 0.07 kg m^2, damping: 0.3,\n"
    "          motor: {torque_constant: 0.05 V s/rad, resistance: 2 ohm, gear: 30}%s}\n"
    "inputs: {u: {voltage: wheel, gain: 2}}\n"
    "outputs: {volt: {input: u, read: value}, speed: {joint: wheel, read: speed}}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";

static stein_sim *wheel_with(lab_model **model, const char *more)
{
    char text[800];
    stein_sim *sim = NULL;
    snprintf(text, sizeof text, wheel, more);
    *model = open_text(text, NULL, 0);
    ck_assert_stein(lab_sim(*model, NULL, &sim, err));
    return sim;
}

static void finish(stein_sim *sim, lab_model *model)
{
    stein_sim_destroy(sim);
    lab_close(model);
}

static void constant(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(const double *)ctx;
}

/* qd = w (1 - exp(-t/T)) with w = (r k/R) u / (b + (r k)^2/R), T = J / (b + (r k)^2/R) */
START_TEST(a_motor_at_a_voltage_reaches_its_speed_as_in_closed_form)
{
    static double half = 6.0; // the gain of the input is 2
    const double rk = 30.0 * 0.05, viscous = 0.3 + rk * rk / 2.0;
    lab_model *model = NULL;
    stein_sim *sim = wheel_with(&model, "");
    ck_assert_stein(stein_drive(sim, "u", constant, &half, err));
    ck_assert_stein(stein_reset(sim, err));
    for (int i = 1; i <= 10; i++) {
        ck_assert_stein(stein_run(sim, 0.05 * i, err));
        double w = rk / 2.0 * 12.0 / viscous * (1.0 - exp(-0.05 * i * viscous / 0.09));
        ck_assert_close(stein_qd(sim)[0], w, 1e-9, 0.0);
    }
    ck_assert_double_eq(stein_read(sim, 1), 12.0);
    ck_assert_str_eq(lab_equations(model)->channels[1].unit, "V");
    ck_assert_str_eq(lab_equations(model)->inputs[0].unit, "V");
    finish(sim, model);
}
END_TEST

START_TEST(without_a_signal_the_terminals_are_closed_and_the_motor_brakes)
{
    lab_model *model = NULL;
    stein_sim *sim = wheel_with(&model, ", initial: {speed: 3 rad/s}");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_close(stein_qd(sim)[0], 3.0 * exp(-0.1 * (0.3 + 1.125) / 0.09), 1e-9, 0.0);
    finish(sim, model);
}
END_TEST

/* the damping depends on the direction, the back-EMF does not */
START_TEST(an_asymmetry_of_the_damping_leaves_the_motor_alone)
{
    for (int way = -1; way <= 1; way += 2) {
        char more[80];
        lab_model *model = NULL;
        snprintf(more, sizeof more, ", asymmetry: 0.4, initial: {speed: %d rad/s}", 3 * way);
        stein_sim *sim = wheel_with(&model, more);
        double viscous = 0.3 * (1.0 + 0.4 * way) + 1.125;
        ck_assert_close(stein_qdd(sim)[0], -3.0 * way * viscous / 0.09, 1e-13, 0.0);
        ck_assert_stein(stein_set(sim, "wheel.damping", 0.0, err));
        ck_assert_stein(stein_reset(sim, err));
        ck_assert_close(stein_qdd(sim)[0], -3.0 * way * 1.125 / 0.09, 1e-13, 0.0);
        finish(sim, model);
    }
}
END_TEST

/* torque per volt and back-EMF follow the numbers of the motor at run time */
START_TEST(the_numbers_of_a_motor_are_parameters)
{
    static double volt = 1.0;
    static const struct {
        const char *name;
        double value, k, R, r;
    } change[] = {{"wheel.motor.torque_constant", 0.07, 0.07, 2.0, 30.0},
                  {"wheel.motor.resistance", 0.5, 0.05, 0.5, 30.0},
                  {"wheel.motor.gear", 11.0, 0.05, 2.0, 11.0}};
    for (int i = 0; i < 3; i++) {
        lab_model *model = NULL;
        stein_sim *sim = wheel_with(&model, ", initial: {speed: 1 rad/s}");
        double rk = change[i].r * change[i].k;
        ck_assert_stein(stein_drive(sim, "u", constant, &volt, err));
        ck_assert_stein(stein_set(sim, change[i].name, change[i].value, err));
        ck_assert_stein(stein_reset(sim, err));
        double torque = (2.0 * rk - rk * rk) / change[i].R - 0.3;
        ck_assert_close(stein_qdd(sim)[0], torque / 0.09, 1e-13, 0.0);
        finish(sim, model);
    }
}
END_TEST

/* of a spindle the gear is in rad/m, and the force k r i */
START_TEST(a_motor_drives_a_slide_by_a_screw)
{
    static double volt = 24.0;
    lab_model *model = open_text(
        "mechanism: spindle\n"
        "gravity: [0, 0, 0]\n"
        "bodies:\n"
        "  cart: {joint: T x, mass: 8 kg, armature: 1.2 kg,\n"
        "         motor: {torque_constant: 0.1 N m/A, resistance: 3 ohm, gear: 400 rad/m}}\n"
        "inputs: {u: {voltage: cart}}\n"
        "simulation: {dt: 1 ms, until: 1 s}\n",
        NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_drive(sim, "u", constant, &volt, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_close(stein_qdd(sim)[0], 40.0 / 3.0 * 24.0 / 9.2, 1e-13, 0.0);
    ck_assert_stein(stein_run(sim, 1.0, err)); // no load: u = k r qd
    ck_assert_close(stein_qd(sim)[0], 0.6, 1e-9, 0.0);
    finish(sim, model);
}
END_TEST

static double phase[PLACES];

static void sway(void *ctx, double t, double u[3])
{
    u[0] = 12.0 * sin(7.0 * t + *(const double *)ctx);
}

static void drive_arm(stein_sim *sim, int i)
{
    phase[i] = 0.4 * i;
    ck_assert_stein(stein_drive(sim, "shoulder_voltage", sway, &phase[i], err));
    if (i % 2) {
        ck_assert_stein(stein_drive(sim, "elbow_voltage", sway, &phase[i], err));
    }
    set(sim, "upper.motor.resistance", 0.5 + 0.1 * i);
    set(sim, "motor.rotor", 1e-6 * i);
    ck_assert_stein(stein_reset(sim, err));
}

static lab_model *geared_arm(void)
{
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "models/drive/geared_arm.yaml", &options, err));
    return model;
}

START_TEST(motors_drive_lanes_as_they_drive_one_alone)
{
    lab_model *model = geared_arm();
    const stein_model *m = lab_equations(model);
    twins t;
    make_twins(&t, m, STEIN_DP5, stein_batch_width(m), drive_arm);
    run_twins(&t, 0.2, 1e-3);
    drop_twins(&t);
    lab_close(model);
}
END_TEST

START_TEST(the_work_of_a_voltage_and_the_loss_of_its_back_emf_are_counted)
{
    lab_model *model = geared_arm();
    stein_sim *sim = NULL;
    stein_balance *b = NULL;
    stein_energy_total total;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    drive_arm(sim, 1);
    ck_assert_stein(stein_balance_create(&b, lab_equations(model), NULL, err));
    ck_assert_stein(stein_balance_attach(b, sim, err));
    ck_assert_stein(stein_run(sim, 1.0, err));
    stein_balance_total(b, &total);
    ck_assert(stein_balance_work(b, STEIN_WORK_INPUT, 0) > 1.0);
    ck_assert(total.dissipated > 1.0);
    ck_assert(fabs(total.unexplained) < 1e-9 * total.scale);
    ck_assert_close(total.inputs,
                    stein_balance_work(b, STEIN_WORK_INPUT, 0) +
                        stein_balance_work(b, STEIN_WORK_INPUT, 1),
                    1e-12, 0.0);
    stein_balance_destroy(b);
    finish(sim, model);
}
END_TEST

START_TEST(motors_that_are_none_are_refused_by_place)
{
    static const char head[] =
        "mechanism: wrong\nbodies:\n  arm: {mass: 1 kg, inertia: {xx: 1, yy: "
        "1, zz: 1}, ";
    static const struct {
        const char *rest, *words;
    } wrong[] = {
        {"joint: R y}\ninputs: {u: {voltage: arm}}", "wrong.yaml:4:23: the joint arm has no motor, "
                                                     "expected motor: {torque_constant: .., "},
        {"joint: R y, motor: {resistance: 1 ohm}}", "motor lacks \"torque_constant\""},
        {"joint: R y, motor: {torque_constant: 1 N m/A}}", "motor lacks \"resistance\""},
        {"joint: T x, motor: {torque_constant: 1 N m/A, resistance: 1 ohm}}",
         "the motor of a sliding joint lacks \"gear\""},
        {"joint: R y, motor: {torque_constant: 1 N m/A, resistance: 0 ohm}}",
         "arm.motor.resistance = \"0 ohm\": must be greater than zero"},
        {"joint: R y, motor: {torque_constant: 1 N m, resistance: 1 ohm}}",
         "the unit is N m, expected N m/A"},
        {"joint: R y, motor: {torque_constant: 1 N m/A, resistance: 1 ohm, gear: 9 rad/m}}",
         "expected a pure number"},
        {"joint: R y, motor: {torque_constant: 1 N m/A, resistance: 1 ohm, gears: 3}}",
         "did you mean \"gear\""},
        {"joint: ball, motor: {torque_constant: 1 N m/A, resistance: 1 ohm}}",
         "unknown key \"motor\""},
        {"joint: ball, armature: 1}", "unknown key \"armature\""},
        {"joint: ball}\ninputs: {u: {voltage: arm}}", "arm turns in all directions"},
        {"joint: R y, armature: 1 kg}", "the unit is kg, expected kg m^2"},
        {"joint: R y, armature: -1 kg m^2}", "must not be negative"},
        {"joint: R y}\ninputs: {u: {voltage: arm, torque: arm}}",
         "exactly one of force, torque, motion, voltage"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[600];
        snprintf(text, sizeof text, "%s%s\n", head, wrong[i].rest);
        ck_assert_refused(text, wrong[i].words);
    }
}
END_TEST

/* ---- angles of bodies ---- */

/* %c: the axis of the hinges; beside it the angles of the plane, from the first towards the
 * second */
static const char fan[] = "mechanism: fan\n"
                          "bodies:\n"
                          "  cart: {joint: T %c, mass: 1 kg}\n"
                          "  hub: {parent: cart, joint: R -%c, mass: 1 kg, %s}\n"
                          "  slide: {parent: hub, joint: T %c, mass: 1 kg, %s}\n"
                          "  blade: {parent: slide, joint: R %c, mass: 1 kg, %s,\n"
                          "          points: {root: [0, 0, 0], tip: [%s]}}\n"
                          "  edge: {parent: blade, joint: fixed, at: [0.1, 0, 0], mass: 0.1 kg}\n"
                          "outputs:\n"
                          "  hub: {body: hub, read: angle}\n"
                          "  blade: {body: blade, read: angle}\n"
                          "  slide: {body: slide, read: angle}\n"
                          "  edge: {body: edge, read: angle}\n"
                          "  back: {body: blade, read: angle, sign: -1, zero: rest}\n"
                          "simulation: {dt: 1 ms, until: 1 s, tolerance: {blade: 1 mrad}}\n";

static lab_model *fan_about(int axis)
{
    static const char across[3][3] = {"yz", "xy", "xz"}; // x: y to z; z: x to y; y: x to z
    static const char names[] = "xzy";
    static const char *const tip[] = {"0, 0.2, 0", "0.2, 0, 0", "0.2, 0, 0"};
    static const char whole[] = "inertia: {xx: 0.01, yy: 0.01, zz: 0.01}";
    char text[1600];
    snprintf(text, sizeof text, fan, across[axis][0], names[axis], whole, across[axis][1], whole,
             names[axis], whole, tip[axis]);
    return open_text(text, NULL, 0);
}

/* as drawn, whatever plane that is: the direction from a body's origin to its tip */
START_TEST(the_angle_of_a_body_is_that_of_its_drawing_and_goes_on_without_end)
{
    static const int first[] = {1, 0, 0}, second[] = {2, 1, 2};
    lab_model *model = fan_about(_i);
    const stein_model *m = lab_equations(model);
    stein_sim *sim = NULL;
    double qd[4] = {0.0}, x[6], v[6], J[6 * 4], jdqd[6];
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    double was[2] = {stein_read(sim, stein_find_channel(m, "hub")),
                     stein_read(sim, stein_find_channel(m, "blade"))};
    ck_assert(was[0] == 0.0 && was[1] == 0.0);
    for (int i = 1; i < 200; i++) { // the hub turns forwards, the blade on it slower backwards
        const double q[4] = {0.1, 0.2 * i, 0.3, 0.09 * i};
        ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
        double hub = stein_read(sim, stein_find_channel(m, "hub"));
        double blade = stein_read(sim, stein_find_channel(m, "blade"));
        int drawn = _i == 2 ? 1 : -1; // -y turns from +x towards +z, -x and -z the other way
        ck_assert_close(hub, drawn * 0.2 * i, 1e-14, 0.0);
        ck_assert_close(blade, drawn * 0.11 * i, 1e-12, 0.0);
        ck_assert_double_eq(stein_read(sim, stein_find_channel(m, "slide")), hub);
        ck_assert_double_eq(stein_read(sim, stein_find_channel(m, "edge")), blade);
        ck_assert_close(stein_read(sim, stein_find_channel(m, "back")), -blade, 1e-14, 0.0);
        stein_points(sim, q, qd, x, v, J, jdqd);
        double seen = atan2(x[3 + second[_i]] - x[second[_i]], x[3 + first[_i]] - x[first[_i]]);
        ck_assert_double_eq_tol(remainder(blade - seen, 6.283185307179586), 0.0, 1e-12);
    }
    finish(sim, model);
}
END_TEST

START_TEST(a_body_that_has_no_angle_in_a_plane_is_refused)
{
    static const struct {
        const char *bodies, *words;
    } wrong[] = {
        {"  a: {joint: R y, mass: 1 kg, inertia: {xx: 1, yy: 1, zz: 1}}\n"
         "  b: {parent: a, joint: R z, mass: 1 kg, inertia: {xx: 1, yy: 1, zz: 1}}\n",
         "wrong.yaml:5:25: b turns in space, about y and z, and has no angle in a plane, expected "
         "roll, pitch"},
        {"  a: {joint: ball, mass: 1 kg, inertia: {xx: 1, yy: 1, zz: 1}}\n"
         "  b: {parent: a, joint: R z, mass: 1 kg, inertia: {xx: 1, yy: 1, zz: 1}}\n",
         "b turns in space"},
        {"  a: {joint: T x, mass: 1 kg}\n  b: {parent: a, joint: T z, mass: 1 kg}\n",
         "b does not turn, expected a body with a joint R on its way to the frame"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[600];
        snprintf(text, sizeof text,
                 "mechanism: wrong\nbodies:\n%soutputs: {angle: {body: b, read: angle}}\n",
                 wrong[i].bodies);
        ck_assert_refused(text, wrong[i].words);
    }
}
END_TEST

Suite *drive_suite(void)
{
    Suite *suite = suite_create("drive");
    TCase *armature = tcase_create("armature");
    tcase_add_checked_fixture(armature, make_folder, remove_folder);
    tcase_add_test(armature, a_rotor_behind_a_gear_counts_with_the_square_of_the_ratio);
    tcase_add_test(armature, a_sliding_joint_has_an_armature_in_kilograms);
    tcase_add_test(armature, a_loop_feels_an_armature_of_its_crank_as_a_flywheel);
    tcase_add_test(armature, energy_has_the_share_of_the_rotors_and_is_kept);
    tcase_add_test(armature, a_motion_has_its_sensitivity_to_an_armature);
    tcase_add_test(armature, an_armature_may_be_set_from_outside);
    tcase_add_test(armature, a_joint_may_have_an_armature_alone);
    tcase_set_timeout(armature, 60);
    suite_add_tcase(suite, armature);
    TCase *motor = tcase_create("motor");
    tcase_add_checked_fixture(motor, make_folder, remove_folder);
    tcase_add_test(motor, a_motor_at_a_voltage_reaches_its_speed_as_in_closed_form);
    tcase_add_test(motor, without_a_signal_the_terminals_are_closed_and_the_motor_brakes);
    tcase_add_test(motor, an_asymmetry_of_the_damping_leaves_the_motor_alone);
    tcase_add_test(motor, the_numbers_of_a_motor_are_parameters);
    tcase_add_test(motor, a_motor_drives_a_slide_by_a_screw);
    tcase_add_test(motor, motors_drive_lanes_as_they_drive_one_alone);
    tcase_add_test(motor, the_work_of_a_voltage_and_the_loss_of_its_back_emf_are_counted);
    tcase_add_test(motor, motors_that_are_none_are_refused_by_place);
    tcase_set_timeout(motor, 60);
    suite_add_tcase(suite, motor);
    TCase *angle = tcase_create("angle");
    tcase_add_checked_fixture(angle, make_folder, remove_folder);
    tcase_add_loop_test(angle, the_angle_of_a_body_is_that_of_its_drawing_and_goes_on_without_end,
                        0, 3);
    tcase_add_test(angle, a_body_that_has_no_angle_in_a_plane_is_refused);
    tcase_set_timeout(angle, 60);
    suite_add_tcase(suite, angle);
    return suite;
}
