/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_linear.c - linearised mechanisms against closed forms: pendulums, a cart with a pole,
 * springs with transfer functions, contacts, linkages, steady motions. Refusals and messages, and
 * both methods for A against each other: test_linear_ways.c.
 */
#include "linear_support.h"

Suite *linear_suite(void);
void linear_ways_cases(Suite *suite);

static const double g = 9.81;

#define ck_assert_complex(a, b, rtol)                                                         \
    do {                                                                                      \
        double complex complex_a = (a), complex_b = (b);                                      \
        ck_assert_msg(cabs(complex_a - complex_b) <= (rtol)*cabs(complex_b),                  \
                      "%s = %.15g + %.15g i, expected %.15g + %.15g i", #a, creal(complex_a), \
                      cimag(complex_a), creal(complex_b), cimag(complex_b));                  \
    } while (0)

/* ---- trees ---- */

/* A rotor on a motor: (I + J) qdd = r k/R u - (r k)^2/R qd, seen as the angle of its body. */
START_TEST(a_voltage_acts_through_gear_and_back_emf)
{
    linearised x = linear_begin("mechanism: motor\n"
                                "gravity: [0, 0, 0]\n"
                                "bodies:\n"
                                "  arm: {joint: R -y, mass: 1 kg, inertia: {yy: 0.02 kg m^2}, "
                                "armature: 0.03 kg m^2, motor: {torque_constant: 0.04 N m/A, "
                                "resistance: 2 ohm, gear: 30}}\n"
                                "inputs:\n"
                                "  u: {voltage: arm}\n"
                                "outputs:\n"
                                "  seen: {body: arm, read: angle}\n");
    double zero = 0.0, rk = 30.0 * 0.04, ohm = 2.0, inertia = 0.05;
    linear_put(&x, &zero, NULL);
    ck_assert_int_eq(x.s->ninput, 1);
    ck_assert_close(x.s->B[1], rk / ohm / inertia, 1e-13, 0.0);
    ck_assert_close(linear_A(&x, 1, 1), -rk * rk / ohm / inertia, 1e-13, 0.0);
    int seen = stein_find_channel(stein_sim_model(x.sim), "seen");
    ck_assert_int_ge(seen, 0);
    ck_assert(x.s->C[2 * seen] == 1.0 && x.s->C[2 * seen + 1] == 0.0);
    linear_end(&x);
}
END_TEST

/* I q'' + b q' + m g d q = u; the file states I by 1.03 Hz */
START_TEST(a_pendulum_has_the_poles_of_its_equation)
{
    linearised x = linear_built_in(&stein_model_pendulum);
    double m = 0.213, d = 0.174, b = 1.5e-4, w = 2.0 * 3.14159265358979323846 * 1.03;
    double inertia = m * g * d / (w * w), zero = 0.0;
    linear_put(&x, &zero, NULL);
    ck_assert_int_eq(x.s->exact, 1);
    ck_assert_int_eq(x.s->n, 1);
    ck_assert(linear_A(&x, 0, 0) == 0.0 && linear_A(&x, 0, 1) == 1.0);
    ck_assert_close(linear_A(&x, 1, 0), -w * w, 1e-14, 0.0);
    ck_assert_close(linear_A(&x, 1, 1), -b / inertia, 1e-14, 0.0);
    ck_assert_close(x.s->B[1], 1.0 / inertia, 1e-14, 0.0);
    ck_assert_close(x.modes->mode[0].frequency, 1.03, 1e-13, 0.0);
    ck_assert_close(x.modes->mode[0].damping, b / (2.0 * inertia * w), 1e-12, 0.0);
    ck_assert_close(x.modes->mode[0].im, sqrt(w * w - pow(b / (2.0 * inertia), 2)), 1e-13, 0.0);
    double top = 3.14159265358979323846;
    linear_put(&x, &top, NULL); // the same with the sign of gravity turned round
    ck_assert_close(linear_A(&x, 1, 0), w * w, 1e-13, 0.0);
    ck_assert_int_eq(x.modes->n, 2);
    ck_assert_int_eq(x.modes->mode[0].kind, LAB_GROWS);
    ck_assert_int_eq(x.modes->mode[1].kind, LAB_DECAYS);
    linear_end(&x);
}
END_TEST

/* Two equal points on massless rods of equal length: w^2 = (2 -+ sqrt 2) g/l, the second one moves
 * by sqrt 2 times the first in space, together or against it. */
START_TEST(a_double_pendulum_has_its_two_modes)
{
    linearised x = linear_begin("mechanism: twice\n"
                                "bodies:\n"
                                "  one: {joint: R -y, mass: 0.7 kg, centre: [0, 0, -0.4 m], "
                                "points: {end: [0, 0, -0.4 m]}}\n"
                                "  two: {parent: one, at: one.end, joint: R -y, mass: 0.7 kg, "
                                "centre: [0, 0, -0.4 m]}\n");
    ck_assert_stein(stein_settle(x.sim, err));
    linear_look(&x);
    ck_assert_int_eq(x.modes->n, 2);
    for (int i = 0; i < 2; i++) {
        double sign = i == 0 ? 1.0 : -1.0;
        ck_assert_close(x.modes->mode[i].im, sqrt((2.0 - sign * sqrt(2.0)) * g / 0.4), 1e-13, 0.0);
        ck_assert_double_lt(fabs(x.modes->mode[i].re), 1e-13);
        const double *shape = x.modes->shape + 4 * i; // relative angles, the largest 1
        ck_assert_close(shape[2] / shape[0], sign * sqrt(2.0) - 1.0, 1e-12, 0.0);
    }
    linear_end(&x);
}
END_TEST

/* Point m on a massless pole of length l, upright on a cart M: s^2 = (M + m) g/(M l); a force on
 * the cart: x'' = F/M, theta'' = -+F/(M l). */
START_TEST(a_pole_on_a_cart_has_its_unstable_pole)
{
    linearised x = linear_begin("mechanism: cart_pole\n"
                                "bodies:\n"
                                "  cart: {joint: T x, mass: 1.7 kg}\n"
                                "  pole: {parent: cart, joint: R y, mass: 0.3 kg, "
                                "centre: [0, 0, 0.6 m]}\n"
                                "inputs: {push: {torque: cart}}\n"
                                "outputs: {lean: {joint: pole, read: position}}\n");
    double upright[2] = {0.0, 0.0}, s = sqrt(2.0 * g / (1.7 * 0.6));
    linear_put(&x, upright, NULL);
    ck_assert_int_eq(x.modes->n, 4);
    ck_assert_int_eq(x.modes->mode[0].kind, LAB_NEUTRAL);
    ck_assert_int_eq(x.modes->mode[1].kind, LAB_NEUTRAL);
    ck_assert_close(fmax(x.modes->mode[2].re, x.modes->mode[3].re), s, 1e-13, 0.0);
    ck_assert_close(fmin(x.modes->mode[2].re, x.modes->mode[3].re), -s, 1e-13, 0.0);
    ck_assert_close(x.s->B[2], 1.0 / 1.7, 1e-14, 0.0);
    ck_assert_close(x.s->B[3], -1.0 / (1.7 * 0.6), 1e-14, 0.0);
    ck_assert_complex(linear_transfer(&x, "lean", "push", 2.385),
                      -1.0 / (1.7 * 0.6) / (-2.385 * 2.385 - s * s), 1e-12);
    linear_end(&x);
}
END_TEST

static const char block[] = "mechanism: block\n"
                            "bodies:\n"
                            "  base: {joint: T x, mass: 0.4 kg, points: {p: [0, 0, 0]}}\n"
                            "  mass: {parent: base, joint: T x, mass: 1.3 kg, "
                            "spring: {k: 870 N/m}, damping: 5.1 N s/m, points: {p: [0, 0, 0]}}\n"
                            "inputs:\n"
                            "  shake: {motion: base, idle: hold, gain: 0.5}\n"
                            "  push: {torque: mass}\n"
                            "  pull: {force: mass.p, direction: [-0.6, 0, 0.8], gain: 2}\n"
                            "outputs:\n"
                            "  at: {point: mass.p, read: x}\n"
                            "  speed: {point: mass.p, read: vx}\n"
                            "  relative: {joint: mass, read: position, sign: -1}\n"
                            "  relative_a: {joint: mass, read: acceleration}\n"
                            "  pushed: {input: push, read: value}\n"
                            "  effort: {input: shake, read: force}\n"
                            "  measured: {joint: mass, read: position, "
                            "sensor: {gain: 3, offset: 1 mm, square: 7 1/m}}\n";

/* G = 1/(k - m w^2 + i c w) of the relative motion; of a moved base the transmissibility
 * (k + i c w) G, its input being the acceleration 0.5 u'' */
START_TEST(a_driven_spring_has_its_transfer_functions)
{
    linearised x = linear_begin(block);
    ck_assert_stein(stein_settle(x.sim, err));
    linear_look(&x);
    ck_assert_int_eq(x.s->n, 2);
    ck_assert_int_eq(x.s->nfree, 1);
    ck_assert_int_eq(x.modes->n, 1);
    ck_assert_close(x.modes->mode[0].frequency, sqrt(870.0 / 1.3) / 6.283185307179586, 1e-13, 0.0);
    for (double w = 0.7; w < 300.0; w *= 2.385) {
        double complex k = 870.0 + 5.1 * w * I, G = 1.0 / (k - 1.3 * w * w);
        double complex base = 0.5 / (-w * w); // position of the base by u''
        ck_assert_complex(linear_transfer(&x, "at", "push", w), G, 1e-12);
        ck_assert_complex(linear_transfer(&x, "at", "pull", w), -1.2 * G, 1e-12);
        ck_assert_complex(linear_transfer(&x, "speed", "push", w), I * w * G, 1e-12);
        ck_assert_complex(linear_transfer(&x, "relative", "push", w), -G, 1e-12);
        ck_assert_complex(linear_transfer(&x, "relative_a", "push", w), -w * w * G, 1e-11);
        ck_assert_complex(linear_transfer(&x, "measured", "push", w), 3.0 * G, 1e-12);
        ck_assert_complex(linear_transfer(&x, "pushed", "push", w), 1.0, 1e-12);
        ck_assert_complex(linear_transfer(&x, "at", "shake", w), base * k * G, 1e-12);
        // the base accelerates itself and, through spring and damper, the mass
        double complex force = -w * w * base * (0.4 + 1.3 * k * G);
        ck_assert_complex(linear_transfer(&x, "effort", "shake", w), force, 1e-9);
        // the push is between base and mass: the rest accelerates the mass
        ck_assert_complex(linear_transfer(&x, "effort", "push", w), -1.3 * w * w * G, 1e-9);
    }
    linear_end(&x);
}
END_TEST

/* An instrument that bends: y = 3 x + 7 (x - x0)^2 + 1 mm, seen from another place than rest. */
START_TEST(a_curved_instrument_has_its_slope_there)
{
    linearised x = linear_begin(block);
    ck_assert_stein(stein_drive(x.sim, "push", NULL, NULL, err));
    ck_assert_stein(stein_set(x.sim, "mass.spring.x0", 0.04, err));
    ck_assert_stein(stein_settle(x.sim, err)); // rest is where it was created
    linear_look(&x);
    int y = stein_find_channel(stein_sim_model(x.sim), "measured");
    int k = x.s->joint[0] == 1 ? 0 : 1;
    ck_assert_close(x.s->C[y * 4 + k], 3.0 + 2.0 * 7.0 * 0.04, 1e-9, 0.0);
    linear_end(&x);
}
END_TEST

/* A point on a rod under a torque and a moved pin: f_x = u/l - by the torque, and by the pin's
 * acceleration nothing, as the point stays where it is; f_z = m g, and the size is that. By the
 * angle f_x = - m g q, as the weight turns it back. */
START_TEST(a_reaction_has_its_slopes_by_states_and_inputs)
{
    linearised x = linear_begin(
        "mechanism: pin\n"
        "bodies:\n"
        "  cart: {joint: T x, mass: 0.2 kg}\n"
        "  rod: {parent: cart, joint: R -y, mass: 0.5 kg, centre: [0, 0, -0.4 m]}\n"
        "inputs: {motor: {torque: rod, gain: 2}, shake: {motion: cart, idle: hold, gain: 3}}\n"
        "outputs:\n"
        "  fx: {joint: rod, read: reaction, component: fx}\n"
        "  size: {joint: rod, read: reaction, sign: -1}\n"
        "  cart: {joint: cart, read: reaction, component: fx}\n");
    ck_assert_stein(stein_settle(x.sim, err));
    linear_look(&x);
    const double *C = x.s->C, *D = x.s->D;
    ck_assert_int_eq(x.s->joint[0], 1);
    ck_assert_close(C[4], -0.5 * g, 1e-9, 0.0); // fx by the angle
    ck_assert_close(D[2], 2.0 / 0.4, 1e-9, 0.0);
    ck_assert_double_lt(fabs(D[3]), 1e-9);
    ck_assert_double_lt(fabs(C[8]) + fabs(D[4]) + fabs(D[5]), 1e-8); // the size
    ck_assert_close(D[6], 2.0 / 0.4, 1e-9, 0.0); // the cart needs its own force and the rod's
    ck_assert_close(D[7], 3.0 * 0.2, 1e-9, 0.0);
    ck_assert_double_lt(fabs(stein_qdd(x.sim)[1]), 1e-12); // neither acts any more
    linear_end(&x);
}
END_TEST

/* ---- contacts ---- */

/* m g = c x + b x^2; slopes (c + 2 b x)/m and D m g/m. A weight that lies on it presses harder. */
START_TEST(a_closed_contact_acts_with_its_slope)
{
    linearised x = linear_begin("mechanism: lies\n"
                                "bodies:\n"
                                "  ball: {joint: T z, mass: 0.31 kg, points: {p: [0, 0, 0]}}\n"
                                "contacts:\n"
                                "  floor:\n"
                                "    between: [{point: ball.p}, {line: {on: frame, at: [0, 0, 0], "
                                "facing: 90 deg}}]\n"
                                "    normal: {c: 1.1e3 N/m, b: 3.7e6 N/m^2, D: 0.83 s/m}\n"
                                "outputs:\n"
                                "  force: {contact: floor, read: force}\n"
                                "  gap: {contact: floor, read: gap}\n");
    double W = 0.31 * g, c = 1.1e3, b = 3.7e6;
    double depth = (-c + sqrt(c * c + 4.0 * b * W)) / (2.0 * b), slope = c + 2.0 * b * depth;
    ck_assert_stein(stein_settle(x.sim, err));
    linear_look(&x);
    ck_assert_int_eq(x.s->exact, 1);
    ck_assert_int_eq(x.s->nedge, 0);
    ck_assert_close(linear_A(&x, 1, 0), -slope / 0.31, 1e-10, 0.0);
    ck_assert_close(linear_A(&x, 1, 1), -0.83 * g, 1e-10, 0.0);
    ck_assert_close(x.s->C[2], -slope, 1e-9, 0.0); // force, by differences
    ck_assert_close(x.s->C[3], -0.83 * W, 1e-9, 0.0);
    ck_assert_close(x.s->C[4], 1.0, 1e-9, 0.0); // gap
    ck_assert(x.s->differences[1] && x.s->differences[2]);
    linear_end(&x);
}
END_TEST

START_TEST(contacts_at_their_edge_are_listed)
{
    linearised x = linear_begin(
        "mechanism: edges\n"
        "gravity: [0, 0, 0]\n"
        "bodies:\n"
        "  slider: {joint: T x, mass: 1 kg, spring: {k: 10 N/m}, points: {p: [0, 0, 0]}}\n"
        "  flap: {joint: R y, mass: 1 kg, inertia: {yy: 1 kg m^2}, spring: {k: 1 N m/rad}, "
        "limits: {range: [0 rad, 2 rad], k: 50 N m/rad}, points: {p: [0, 0, 0]}}\n"
        "  key: {joint: R y, mass: 1 kg, inertia: {yy: 1 kg m^2}, "
        "spring: {k: 1 N m/rad, theta0: 0.1 rad}, backlash: {k: 9 N m/rad, gap: 0.1 rad}}\n"
        "contacts:\n"
        "  wall:\n"
        "    between: [{point: slider.p}, {line: {on: frame, at: [0.2 um, 0, 0], facing: 180 "
        "deg}}]\n"
        "    normal: {c: 1e3 N/m}\n"
        "  far:\n"
        "    between: [{point: slider.p}, {line: {on: frame, at: [2 um, 0, 0], facing: 180 deg}}]\n"
        "    normal: {c: 1e3 N/m}\n");
    double q[3] = {0.0, 0.0, 0.1};
    linear_put(&x, q, NULL);
    ck_assert_int_eq(x.s->nedge, 3);
    ck_assert_int_eq(x.s->edge[0].kind, STEIN_EDGE_CONTACT);
    ck_assert_int_eq(x.s->edge[0].index, 0);
    ck_assert_close(x.s->edge[0].apart, 0.2e-6, 1e-9, 0.0);
    ck_assert_int_eq(x.s->edge[1].kind, STEIN_EDGE_LIMIT);
    ck_assert_int_eq(x.s->edge[1].index, 1);
    ck_assert_int_eq(x.s->edge[2].kind, STEIN_EDGE_BACKLASH);
    ck_assert_int_eq(x.s->edge[2].index, 2);
    ck_assert_close(linear_A(&x, 3, 0), -10.0, 1e-14, 0.0); // open contacts do not act
    linear_end(&x);
}
END_TEST

/* ---- loops ---- */

/* A swing on two parallel bars moves without turning: a pendulum with
 * w^2 = g (m l + 2 mb d)/(m l^2 + 2 (Ib + mb d^2)) */
START_TEST(a_parallel_linkage_is_a_pendulum)
{
    linearised x = linear_begin(
        "mechanism: swing\n"
        "bodies:\n"
        "  left: {joint: R -y, mass: 0.2 kg, centre: [0, 0, -0.15 m], "
        "inertia: {yy: 2e-3 kg m^2}, points: {end: [0, 0, -0.5 m]}, initial: {position: 0.3 rad}}\n"
        "  right: {joint: R -y, at: [0.8 m, 0, 0], mass: 0.2 kg, centre: [0, 0, -0.15 m], "
        "inertia: {yy: 2e-3 kg m^2}, points: {end: [0, 0, -0.5 m]}, initial: {guess: 0.3 rad}}\n"
        "  seat: {parent: left, at: left.end, joint: R -y, mass: 1.9 kg, centre: [0.4 m, 0, 0], "
        "inertia: {yy: 0.3 kg m^2}, points: {far: [0.8 m, 0, 0]}, initial: {guess: -0.3 rad}}\n"
        "loops: {pin: {between: [seat.far, right.end]}}\n"
        "inputs: {wind: {force: seat.far, direction: [1, 0, 0]}}\n"
        "outputs: {height: {point: seat.far, read: z}, sway: {point: seat.far, read: x}, "
        "turns: {joint: seat, read: position}, angle: {joint: right, read: position}}\n");
    ck_assert_stein(stein_settle(x.sim, err));
    linear_look(&x);
    double inertia = 1.9 * 0.25 + 2.0 * (2e-3 + 0.2 * 0.0225);
    double w2 = g * (1.9 * 0.5 + 2.0 * 0.2 * 0.15) / inertia;
    ck_assert_int_eq(x.s->exact, 0);
    ck_assert_int_eq(x.s->n, 1);
    ck_assert_double_lt(x.s->error, 1e-11);
    ck_assert_close(x.modes->mode[0].im, sqrt(w2), 1e-10, 0.0);
    ck_assert_complex(linear_transfer(&x, "sway", "wind", 2.385),
                      0.25 / (inertia * (w2 - 2.385 * 2.385)), 1e-11);
    ck_assert_double_lt(cabs(linear_transfer(&x, "height", "wind", 2.385)), 1e-11);
    ck_assert_complex(linear_transfer(&x, "turns", "wind", 2.385),
                      -linear_transfer(&x, "angle", "wind", 2.385), 1e-11);
    linear_end(&x);
}
END_TEST

/* potential and, at a speed, inertia of a linkage with the joints moved by `share` of T and closed
 * again, and where its coordinate is then: energies of the tree, nothing of accelerations */
static double potential_at(linearised *x, const double *q, double share, double *z, double *inertia)
{
    double at[8], qd[8], kinetic, potential;
    int nq = stein_sim_model(x->sim)->nq, j = x->s->joint[0];
    for (int k = 0; k < nq; k++) {
        at[k] = q[k] + share * x->s->T[k];
        qd[k] = x->s->T[k];
    }
    ck_assert_stein(stein_set_state(x->sim, 0.0, at, qd, err));
    stein_energy(x->sim, stein_q(x->sim), stein_qd(x->sim), &kinetic, &potential);
    *z = stein_q(x->sim)[j] - q[j];
    *inertia = 2.0 * kinetic / (stein_qd(x->sim)[j] * stein_qd(x->sim)[j]);
    return potential;
}

/* With one degree of freedom w^2 = V''/J of potential and inertia over the coordinate, V' = 0: by
 * the polynomial through five places (divided differences). */
START_TEST(a_four_bar_settles_and_swings_by_its_energies)
{
    linearised x = linear_built_in(&stein_model_four_bar);
    double q[3], z[5], c[5], J[5];
    ck_assert_stein(stein_settle(x.sim, err));
    memcpy(q, stein_q(x.sim), sizeof q);
    linear_look(&x);
    for (int k = 0; k < 5; k++) {
        double share = 0.02 * (k % 2 == 0 ? -0.5 : 0.5) * (k + k % 2);
        c[k] = potential_at(&x, q, share, &z[k], &J[k]);
    }
    for (int i = 1; i < 5; i++) {
        for (int k = 4; k >= i; k--) {
            c[k] = (c[k] - c[k - 1]) / (z[k] - z[k - i]);
        }
    }
    // at z[0] = 0, of c0 + c1 z + c2 z (z - z1) + c3 z (z - z1) (z - z2) + ..
    double first = c[1] - c[2] * z[1] + c[3] * z[1] * z[2] - c[4] * z[1] * z[2] * z[3];
    double second =
        2.0 * (c[2] - c[3] * (z[1] + z[2]) + c[4] * (z[1] * z[2] + z[1] * z[3] + z[2] * z[3]));
    ck_assert_double_lt(fabs(first), 1e-6 * second);
    ck_assert_close(x.s->mass[0], J[0], 1e-11, 0.0);
    ck_assert_close(x.modes->mode[0].im, sqrt(second / J[0]), 1e-6, 0.0);
    linear_end(&x);
}
END_TEST

/* Two weights on a rope over a pulley, one on a spring: k x = (m2/2 - m1) g,
 * (m1 + m2/4) x'' + c/4 x' + k x = 0. */
START_TEST(a_coupling_moves_its_follower)
{
    linearised x = linear_begin("mechanism: weights\n"
                                "bodies:\n"
                                "  light: {joint: T z, mass: 0.3 kg, spring: {k: 40 N/m}}\n"
                                "  heavy: {joint: T z, mass: 1.1 kg, damping: 0.2 N s/m}\n"
                                "couplings: {rope: {joint: heavy, follows: light, ratio: -0.5}}\n"
                                "inputs: {drag: {torque: heavy}}\n"
                                "outputs: {light: {joint: light, read: position}}\n"
                                "simulation: {dt: 1 ms, settle: yes}\n");
    double at = (0.5 * 1.1 - 0.3) * g / 40.0, m = 0.3 + 0.25 * 1.1;
    ck_assert_close(stein_q(x.sim)[0], at, 1e-12, 0.0); // the file starts at rest
    ck_assert_close(stein_q(x.sim)[1], -0.5 * at, 1e-12, 0.0);
    linear_look(&x);
    double complex own = 1.0 / (40.0 - m * 5.69 + 0.05 * sqrt(5.69) * I);
    ck_assert_complex(linear_transfer(&x, "light", "drag", sqrt(5.69)), -0.5 * own, 1e-11);
    ck_assert_stein(stein_run(x.sim, 1.0, err));
    ck_assert_close(stein_q(x.sim)[0], at, 1e-10, 0.0);
    linear_end(&x);
}
END_TEST

/* ---- in space, and what moves ---- */

/* A body on a ball: two pendulums, and a turn about its own length that nothing holds. */
START_TEST(a_ball_joint_has_three_coordinates)
{
    linearised x =
        linear_begin("mechanism: bob\n"
                     "bodies:\n"
                     "  bob: {joint: ball, mass: 0.5 kg, centre: [0, 0, -0.2 m], inertia: "
                     "{xx: 3e-3 kg m^2, yy: 7e-3 kg m^2, zz: 5e-3 kg m^2}}\n"
                     "outputs: {roll: {body: bob, read: roll}}\n");
    linear_look(&x);
    ck_assert_int_eq(x.s->n, 3);
    ck_assert_int_eq(x.modes->n, 4);
    ck_assert_int_eq(x.modes->mode[0].kind, LAB_NEUTRAL);
    ck_assert_close(x.modes->mode[2].im, sqrt(0.5 * g * 0.2 / (7e-3 + 0.02)), 1e-11, 0.0);
    ck_assert_close(x.modes->mode[3].im, sqrt(0.5 * g * 0.2 / (3e-3 + 0.02)), 1e-11, 0.0);
    linear_end(&x);
}
END_TEST

/* A point on a massless arm that turns steadily with a free vertical shaft: cos a = g/(W^2 l); it
 * nods with w^2 = W^2 (1 + 3 cos^2 a), as turning speeds up when the arm falls. Driven evenly:
 * W^2 sin^2 a. */
START_TEST(a_conical_pendulum_nods_about_its_steady_turn)
{
    static const char text[] = "mechanism: cone\n"
                               "bodies:\n"
                               "  shaft: {joint: R z}\n"
                               "  arm: {parent: shaft, joint: R -y, mass: 0.6 kg, "
                               "centre: [0, 0, -0.3 m], initial: {position: 0.5 rad}}\n"
                               "inputs: {turn: {motion: shaft%s}}\n";
    double W = 9.0, c = g / (W * W * 0.3), angle[2] = {0.4, acos(c)}, speed[2] = {W, 0.0};
    for (int driven = 0; driven < 2; driven++) {
        char *whole = lab__text(text, driven ? ", idle: hold" : "");
        linearised x = linear_begin(whole);
        linear_put(&x, angle, speed);
        const lab_mode *last = &x.modes->mode[x.modes->n - 1];
        ck_assert_close(last->im, W * sqrt(driven ? 1.0 - c * c : 1.0 + 3.0 * c * c), 1e-11, 0.0);
        ck_assert_int_eq(x.s->nfree, 2 - driven);
        linear_end(&x);
        free(whole);
    }
}
END_TEST

Suite *linear_suite(void)
{
    Suite *suite = suite_create("linear");
    TCase *tc = tcase_create("closed forms");
    tcase_set_timeout(tc, 60);
    tcase_add_unchecked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_voltage_acts_through_gear_and_back_emf);
    tcase_add_test(tc, a_pendulum_has_the_poles_of_its_equation);
    tcase_add_test(tc, a_double_pendulum_has_its_two_modes);
    tcase_add_test(tc, a_pole_on_a_cart_has_its_unstable_pole);
    tcase_add_test(tc, a_driven_spring_has_its_transfer_functions);
    tcase_add_test(tc, a_curved_instrument_has_its_slope_there);
    tcase_add_test(tc, a_reaction_has_its_slopes_by_states_and_inputs);
    tcase_add_test(tc, a_closed_contact_acts_with_its_slope);
    tcase_add_test(tc, contacts_at_their_edge_are_listed);
    tcase_add_test(tc, a_parallel_linkage_is_a_pendulum);
    tcase_add_test(tc, a_four_bar_settles_and_swings_by_its_energies);
    tcase_add_test(tc, a_coupling_moves_its_follower);
    tcase_add_test(tc, a_ball_joint_has_three_coordinates);
    tcase_add_test(tc, a_conical_pendulum_nods_about_its_steady_turn);
    suite_add_tcase(suite, tc);
    linear_ways_cases(suite);
    return suite;
}
