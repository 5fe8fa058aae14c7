/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_reaction.c - reactions of joints and loops: closed forms, Newton's law of single bodies, a
 * linkage solved by hand, and joints that are held instead, with their holding forces.
 */
#include <string.h>

#include "mechanism.h"
#include "simulation_support.h"

Suite *reaction_suite(void);

static const double g = 9.81;

static double reads(stein_sim *sim, const char *name)
{
    double value = NAN;
    ck_assert_stein(stein_read_name(sim, name, &value, err));
    return value;
}

/* ---- closed forms ---- */

/* A chain that hangs: each joint carries the bodies below it. */
START_TEST(a_hanging_chain_pulls_with_the_weight_below)
{
    stein_sim *sim =
        start("mechanism: chain\n"
              "bodies:\n"
              "  one: {joint: R -y, mass: 0.3 kg, centre: [0, 0, -0.1 m], "
              "points: {end: [0, 0, -0.2 m]}, initial: {position: 0.4 rad}, damping: 1e-3}\n"
              "  two: {parent: one, at: one.end, joint: R -y, mass: 0.5 kg, "
              "centre: [0, 0, -0.2 m], points: {end: [0, 0, -0.3 m]}, damping: 1e-3}\n"
              "  three: {parent: two, at: two.end, joint: ball, mass: 0.7 kg, "
              "centre: [0, 0, -0.1 m], inertia: {xx: 1e-3, yy: 1e-3, zz: 1e-3}}\n"
              "outputs:\n"
              "  one: {joint: one, read: reaction, component: fz}\n"
              "  two: {joint: two, read: reaction, component: fz, axes: two}\n"
              "  three: {joint: three, read: reaction}\n"
              "  across: {joint: two, read: reaction, component: fx}\n"
              "  down: {joint: one, read: reaction, component: fz, sign: -1}\n");
    double rest[6] = {0.0};
    ck_assert_stein(stein_set_state(sim, 0.0, rest, rest, err));
    ck_assert_close(reads(sim, "one"), 1.5 * g, 1e-14, 0.0);
    ck_assert_close(reads(sim, "two"), 1.2 * g, 1e-14, 0.0);
    ck_assert_close(reads(sim, "three"), 0.7 * g, 1e-14, 0.0);
    ck_assert_close(reads(sim, "down"), -1.5 * g, 1e-14, 0.0); // on the frame
    ck_assert_double_lt(fabs(reads(sim, "across")), 1e-14);
    finish(sim);
}
END_TEST

/* Along the rod m (l w^2 + g cos q), across it what turns: m l qdd + m g sin q = 0 for a point. At
 * the lowest place m (g + v^2/l). */
START_TEST(a_pendulum_pulls_with_its_weight_and_centripetal_force)
{
    stein_sim *sim = start("mechanism: pendulum\n"
                           "bodies:\n"
                           "  rod: {joint: R -y, mass: 0.5 kg, centre: [0, 0, -0.4 m], "
                           "initial: {position: 100 deg}}\n"
                           "outputs:\n"
                           "  along: {joint: rod, read: reaction, component: fz, axes: rod}\n"
                           "  across: {joint: rod, read: reaction, component: fx, axes: rod}\n"
                           "  size: {joint: rod, read: reaction, component: force}\n"
                           "  moment: {joint: rod, read: reaction, component: moment}\n");
    double q = 0.0, v = 3.1;
    ck_assert_stein(stein_set_state(sim, 0.0, &q, &v, err));
    ck_assert_close(reads(sim, "along"), 0.5 * (g + 0.4 * v * v), 1e-14, 0.0);
    ck_assert_stein(stein_reset(sim, err));
    for (int i = 1; i < 40; i++) {
        ck_assert_stein(stein_run(sim, 0.05 * i, err));
        double pull = 0.5 * (0.4 * pow(stein_qd(sim)[0], 2) + g * cos(stein_q(sim)[0]));
        ck_assert_close(reads(sim, "along"), pull, 1e-12, 1e-12);
        ck_assert_close(reads(sim, "size"), fabs(pull), 1e-12, 1e-12);
        ck_assert_double_lt(fabs(reads(sim, "across")), 1e-12);
        ck_assert_double_lt(reads(sim, "moment"), 1e-12);
    }
    finish(sim);
}
END_TEST

/* A spring, a motor and a gear act in the joint: about its axis they are the reaction. */
START_TEST(forces_in_a_joint_are_part_of_its_reaction)
{
    stein_sim *sim =
        start("mechanism: acts\n"
              "bodies:\n"
              "  lever: {joint: R y, mass: 0.4 kg, centre: [0.2 m, 0, 0], inertia: {yy: 1e-3}, "
              "spring: {k: 3 N m/rad, theta0: 0.2 rad}, damping: 0.1, "
              "initial: {position: 0.5 rad, speed: 2 rad/s}}\n"
              "  wheel: {joint: R y, at: [1 m, 0, 0], mass: 0.1 kg, inertia: {yy: 2e-3}}\n"
              "couplings: {mesh: {joint: wheel, follows: lever, ratio: -3}}\n"
              "outputs:\n"
              "  lever: {joint: lever, read: reaction, component: my}\n"
              "  wheel: {joint: wheel, read: reaction, component: my}\n"
              "  mesh: {loop: mesh, read: reaction}\n");
    double qdd = stein_qdd(sim)[0], mesh = 2e-3 * -3.0 * qdd;
    ck_assert_close(reads(sim, "mesh"), mesh, 1e-12, 0.0);
    ck_assert_close(reads(sim, "wheel"), mesh, 1e-12, 0.0);
    ck_assert_close(reads(sim, "lever"), -3.0 * 0.3 - 0.2 + 3.0 * mesh, 1e-12, 0.0);
    finish(sim);
}
END_TEST

/* A plate that three joints leave free in the plane, held by a loop alone. */
static double held_plate(const char *loop, const char *component)
{
    char text[1200];
    snprintf(text, sizeof text,
             "mechanism: plate\n"
             "bodies:\n"
             "  x: {joint: T x}\n"
             "  z: {parent: x, joint: T z}\n"
             "  plate: {parent: z, joint: R -y, mass: 2 kg, centre: [0.3 m, 0, 0.1 m], "
             "inertia: {yy: 0.1}, points: {a: [0.1 m, 0, 0]}%s}\n"
             "points: {p: [0.1 m, 0, 0], up: [0.1 m, 0, 0.7 m]}\n"
             "loops: {hold: {between: [frame.%s}}\n"
             "outputs: {out: {loop: hold, read: reaction, component: %s}}\n",
             strncmp(loop, "up", 2) == 0 ? ", damping: 0.1" : "", loop, component);
    stein_sim *sim = start(text);
    double rest[3] = {0.0};
    ck_assert_stein(stein_set_state(sim, 0.0, rest, rest, err));
    double value = reads(sim, "out");
    finish(sim);
    return value;
}

START_TEST(loops_react_by_their_kind)
{
    // welded: weight, and its moment about -y at the point, 0.2 m beside the centre
    ck_assert_close(held_plate("p, plate.a], weld: yes", "fz"), 2.0 * g, 1e-12, 0.0);
    ck_assert_close(held_plate("p, plate.a], weld: yes", "my"), -2.0 * g * 0.2, 1e-12, 0.0);
    ck_assert_double_lt(fabs(held_plate("p, plate.a], weld: yes", "fx")), 1e-12);
    // at a pin it falls: M about the point I qdd = - m g d, f_z = m (g + a_z)
    double inertia = 0.1 + 2.0 * (0.2 * 0.2 + 0.1 * 0.1), qdd = -2.0 * g * 0.2 / inertia;
    ck_assert_close(held_plate("p, plate.a]", "fz"), 2.0 * (g + 0.2 * qdd), 1e-12, 0.0);
    ck_assert_close(held_plate("p, plate.a]", "fx"), 2.0 * -0.1 * qdd, 1e-12, 0.0);
    ck_assert_double_lt(fabs(held_plate("p, plate.a]", "my")), 1e-12);
    // a slot along z holds along x alone, and a rod along itself
    ck_assert_double_lt(fabs(held_plate("p, plate.a], slot: z", "fz")), 1e-12);
    double pull = held_plate("up, plate.a], rod: 0.7 m", "fz");
    ck_assert_close(held_plate("up, plate.a], rod: 0.7 m", "force"), pull, 1e-12, 0.0);
    // S up at the point: a_z of it 0 with a = S/m - g, about the centre I qdd = - 0.2 S
    ck_assert_close(pull, g / (1.0 / 2.0 + 0.2 * 0.2 / 0.1), 1e-12, 0.0);
}
END_TEST

/* ---- a linkage by hand ---- */

/* acceleration less g of a place at r from where it is a, on a body with spin w and dw about -y */
static void accelerated(const double a[2], const double r[2], double w, double dw, double to[2])
{
    to[0] = a[0] - dw * r[1] - w * w * r[0];
    to[1] = a[1] + dw * r[0] - w * w * r[1];
}

static void at_angle(double q, double x, double to[2])
{
    to[0] = x * cos(q);
    to[1] = x * sin(q);
}

static double cross(const double r[2], const double f[2])
{
    return r[0] * f[1] - r[1] * f[0];
}

/* Pins of the four-bar from Newton and Euler of coupler and rocker about their pins: with A on the
 * coupler at the crank and B on the rocker at the coupler,
 *      A - B = m a,  moments of the coupler about A's pin,  moments of the rocker about its pin */
START_TEST(the_pins_of_a_four_bar_are_those_of_its_free_bodies)
{
    static const char text[] =
        "mechanism: bars\n"
        "bodies:\n"
        "  crank: {joint: R -y, mass: 0.5 kg, centre: [50 mm, 0, 0], inertia: {yy: 5e-4}, "
        "initial: {position: 90 deg, speed: 12 rad/s}, points: {pin: [100 mm, 0, 0]}}\n"
        "  coupler: {parent: crank, at: crank.pin, joint: R -y, mass: 0.8 kg, "
        "centre: [150 mm, 0, 0], inertia: {yy: 6e-3}, points: {end: [300 mm, 0, 0]}}\n"
        "  rocker: {at: [300 mm, 0, 0], joint: R -y, mass: 0.6 kg, centre: [100 mm, 0, 0], "
        "inertia: {yy: 2e-3}, points: {end: [200 mm, 0, 0]}}\n"
        "loops: {pin: {between: [coupler.end, rocker.end]}}\n"
        "inputs: {motor: {torque: crank}}\n"
        "outputs:\n"
        "  Ax: {joint: coupler, read: reaction, component: fx}\n"
        "  Az: {joint: coupler, read: reaction, component: fz}\n"
        "  Bx: {loop: pin, read: reaction, component: fx}\n"
        "  Bz: {loop: pin, read: reaction, component: fz}\n"
        "  Cx: {joint: rocker, read: reaction, component: fx}\n"
        "  Cz: {joint: rocker, read: reaction, component: fz}\n"
        "  Ox: {joint: crank, read: reaction, component: fx}\n"
        "  Oz: {joint: crank, read: reaction, component: fz}\n"
        "  Om: {joint: crank, read: reaction, component: my}\n";
    stein_sim *sim = start(text);
    for (int i = 1; i <= 20; i++) {
        ck_assert_stein(stein_run(sim, 0.02 * i, err));
        const double *q = stein_q(sim), *qd = stein_qd(sim), *qdd = stein_qdd(sim);
        double frame[2] = {0.0, g}, r[2], a1[2], aA[2], a2[2], a3[2], end[2], half[2], B[2];
        double q2 = q[0] + q[1], w2 = qd[0] + qd[1], dw2 = qdd[0] + qdd[1];
        at_angle(q[0], 0.05, r);
        accelerated(frame, r, qd[0], qdd[0], a1);
        at_angle(q[0], 0.1, r);
        accelerated(frame, r, qd[0], qdd[0], aA);
        at_angle(q2, 0.15, half);
        accelerated(aA, half, w2, dw2, a2);
        at_angle(q[2], 0.1, r);
        accelerated(frame, r, qd[2], qdd[2], a3);
        // coupler about A: r_end x (-B) = I dw + half x m a2; rocker: r_end x B = I dw + r x m a3
        double force2[2] = {0.8 * a2[0], 0.8 * a2[1]}, force3[2] = {0.6 * a3[0], 0.6 * a3[1]};
        double one = -(6e-3 * dw2 + cross(half, force2)), two = 2e-3 * qdd[2] + cross(r, force3);
        at_angle(q2, 0.3, end);
        at_angle(q[2], 0.2, r);
        double det = -end[1] * r[0] + r[1] * end[0];
        B[0] = (one * r[0] - two * end[0]) / det;
        B[1] = (-end[1] * two + r[1] * one) / det;
        double A[2] = {force2[0] + B[0], force2[1] + B[1]}, scale = fabs(A[0]) + fabs(A[1]);
        ck_assert_close(reads(sim, "Bx"), B[0], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Bz"), B[1], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Ax"), A[0], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Az"), A[1], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Cx"), force3[0] - B[0], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Cz"), force3[1] - B[1], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Ox"), 0.5 * a1[0] + A[0], 0.0, 1e-9 * scale);
        ck_assert_close(reads(sim, "Oz"), 0.5 * a1[1] + A[1], 0.0, 1e-9 * scale);
        ck_assert_double_lt(fabs(reads(sim, "Om")), 1e-9 * scale); // nothing turns the crank
    }
    finish(sim);
}
END_TEST

/* ---- held joints ---- */

/* The same mechanism twice: `arm` on its joint with a reaction output, and on six more joints that
 * are held, with outputs of their holding forces (read: force of an input, by inverse dynamics).
 * Contacts, links, inputs and loops act on its children. */
static const char parts[] =
    "  arm: {parent: %s, joint: R z, mass: 0.7 kg, centre: [0.2 m, 0.05 m, 0.1 m], "
    "inertia: {xx: 3e-3, yy: 4e-3, zz: 5e-3, xy: 4e-4, xz: -3e-4, yz: 2e-4}, damping: 0.2, "
    "points: {end: [0.4 m, 0.1 m, -0.1 m]}, initial: {position: 0.4 rad, speed: 3 rad/s}}\n"
    "  slide: {parent: arm, at: arm.end, joint: T y, mass: 0.2 kg, centre: [0, 0.1 m, 0], "
    "inertia: {xx: 1e-3, yy: 1e-3, zz: 1e-3}, spring: {k: 30 N/m, x0: 0.2 m}, "
    "initial: {position: -0.1 m, speed: 1 m/s}}\n"
    "  tip: {parent: slide, joint: R -x, mass: 0.3 kg, centre: [0.1 m, 0, -0.1 m], "
    "inertia: {xx: 2e-3, yy: 1e-3, zz: 2e-3}, points: {p: [0.1 m, 0.1 m, -0.2 m]}, "
    "initial: {position: 0.3 rad, speed: -4 rad/s}}\n"
    "points: {post: [0.1 m, 0.6 m, 0.4 m]}\n"
    "%s\n"
    "contacts:\n"
    "  floor:\n"
    "    between: [{sphere: {at: tip.p, radius: 0.3 m}}, "
    "{plane: {on: frame, at: [0, 0, -0.2 m], normal: [0.1, 0, 1]}}]\n"
    "    normal: {c: 300 N/m, D: 0.3 s/m}\n"
    "    friction: {A: 0.4, vt: 0.1 m/s}\n";

static void five(void *ctx, double t, double u[3])
{
    (void)ctx, (void)t;
    u[0] = 5.0;
}

/* a rope, or a rod that closes a loop */
static const char *const tied[] = {
    "links: {rope: {from: frame.post, to: tip.p, k: 40 N/m, length: 0.2 m, damping: 1 N s/m}}",
    "loops: {rod: {between: [frame.post, tip.p], rod: 0.8 m}}"};

START_TEST(a_reaction_is_the_force_of_held_joints)
{
    static const char *const part[] = {"fx", "fy", "fz", "mx", "my", "mz"};
    static const char type[] = "TTTRRR";
    char *text = NULL, *own = lab__text(parts, "base", tied[_i]);
    char *held = lab__text(parts, "h5", tied[_i]);
    FILE *f = lab__text_open(&text);
    ck_assert(f != NULL && own != NULL && held != NULL);
    // a base that moves, then the arm
    fputs("mechanism: own\nbodies:\n  base: {joint: R y, mass: 0.5 kg, inertia: {yy: 0.02}, "
          "initial: {position: 0.2 rad, speed: 2 rad/s}}\n",
          f);
    fputs(own, f);
    fputs("inputs: {pull: {force: tip.p, direction: [0.3, -0.5, 0.2]}}\noutputs:\n", f);
    for (int i = 0; i < 6; i++) {
        fprintf(f, "  r%d: {joint: arm, read: reaction, component: %s, axes: base}\n", i, part[i]);
    }
    ck_assert_int_eq(lab__text_close(f, &text, NULL), STEIN_OK);
    stein_sim *sim = start(text);
    lab_model *first = model;
    free(text);
    f = lab__text_open(&text);
    ck_assert_ptr_nonnull(f);
    fputs("mechanism: held\nbodies:\n  base: {joint: R y, mass: 0.5 kg, inertia: {yy: 0.02}, "
          "initial: {position: 0.2 rad, speed: 2 rad/s}}\n",
          f);
    for (int i = 0; i < 6; i++) {
        char parent[8] = "base";
        if (i > 0) {
            snprintf(parent, sizeof parent, "h%d", i - 1);
        }
        fprintf(f, "  h%d: {parent: %s, joint: %c %c}\n", i, parent, type[i], "xyz"[i % 3]);
    }
    fputs(held, f);
    fputs("inputs:\n  pull: {force: tip.p, direction: [0.3, -0.5, 0.2]}\n", f);
    for (int i = 0; i < 6; i++) {
        fprintf(f, "  i%d: {motion: h%d, idle: hold}\n", i, i);
    }
    fputs("outputs:\n", f);
    for (int i = 0; i < 6; i++) {
        fprintf(f, "  r%d: {input: i%d, read: force}\n", i, i);
    }
    ck_assert_int_eq(lab__text_close(f, &text, NULL), STEIN_OK);
    stein_sim *other = start(text);
    ck_assert_stein(stein_drive(sim, "pull", five, NULL, err));
    ck_assert_stein(stein_drive(other, "pull", five, NULL, err));
    double q[10] = {0.0}, qd[10] = {0.0}; // of both in the same state
    for (int i = 0; i < 4; i++) {
        int to = i == 0 ? 0 : i + 6;
        q[to] = stein_q(sim)[i];
        qd[to] = stein_qd(sim)[i];
    }
    ck_assert_stein(stein_set_state(other, 0.0, q, qd, err));
    ck_assert_int_eq(stein_touches(sim, 0), 1);
    for (int i = 0; i < 6; i++) {
        char name[8];
        snprintf(name, sizeof name, "r%d", i);
        double expected = reads(other, name);
        ck_assert_double_gt(fabs(expected), 1e-3);
        ck_assert_close(reads(sim, name), expected, 1e-10, 1e-10);
    }
    finish(other);
    model = first;
    finish(sim);
    free(text);
    free(own);
    free(held);
}
END_TEST

/* ---- bodies at rest, refusals ---- */

/* An arm that sticks on a wall: pin, wall and weight are in equilibrium. */
START_TEST(sticking_friction_is_a_force_as_well)
{
    stein_sim *sim =
        start("mechanism: leans\n"
              "bodies:\n"
              "  cart: {joint: T x, mass: 0.3 kg, spring: {k: 400 N/m, x0: 0.05 m}, damping: 20}\n"
              "  arm: {parent: cart, joint: T z, mass: 0.5 kg, points: {p: [0, 0, 0]}}\n"
              "contacts:\n"
              "  wall:\n"
              "    between: [{point: arm.p}, {line: {on: frame, at: [0, 0, 0], facing: 180 deg}}]\n"
              "    normal: {c: 1e4 N/m, D: 1 s/m}\n"
              "    friction: {A: 0.7, stick: yes}\n"
              "outputs:\n"
              "  fx: {joint: arm, read: reaction, component: fx}\n"
              "  fz: {joint: arm, read: reaction, component: fz}\n"
              "  normal: {contact: wall, read: force}\n"
              "  rub: {contact: wall, read: friction}\n"
              "simulation: {dt: 0.1 ms}\n");
    ck_assert_stein(stein_run(sim, 2.0, err));
    double normal = reads(sim, "normal"), rub = reads(sim, "rub");
    ck_assert_close(fabs(rub), 0.5 * g, 1e-9, 0.0); // the wall alone carries it
    ck_assert_close(reads(sim, "fx"), normal, 1e-9, 0.0);
    ck_assert_double_lt(fabs(reads(sim, "fz")), 1e-9);
    ck_assert_close(reads(sim, "rub"), rub, 0.0, 0.0); // as before
    finish(sim);
}
END_TEST

/* Reading does not disturb: the same bits with and without it. */
START_TEST(reading_a_reaction_changes_no_bit_of_the_motion)
{
    static const char text[] =
        "mechanism: twice\n"
        "bodies:\n"
        "  one: {joint: R -y, mass: 0.7 kg, centre: [0, 0, -0.4 m], points: {end: [0, 0, -0.4 m]}, "
        "initial: {position: 2 rad}, friction: {A: 0.2, stick: yes}}\n"
        "  two: {parent: one, at: one.end, joint: R -y, mass: 0.7 kg, centre: [0, 0, -0.4 m]}\n"
        "outputs: {f: {joint: two, read: reaction}}\n"
        "simulation: {dt: 1 ms}\n";
    stein_sim *sim = start(text), *other = NULL;
    ck_assert_stein(lab_sim(model, NULL, &other, err));
    for (int i = 0; i < 1000; i++) {
        ck_assert_stein(stein_step(sim, err));
        ck_assert_stein(stein_step(other, err));
        ck_assert(reads(other, "f") > 0.0);
    }
    ck_assert_mem_eq(stein_q(sim), stein_q(other), 2 * sizeof(double));
    ck_assert_mem_eq(stein_qd(sim), stein_qd(other), 2 * sizeof(double));
    stein_sim_destroy(other);
    finish(sim);
}
END_TEST

START_TEST(mistakes_are_reported_at_their_place)
{
    static const struct {
        const char *output, *words;
    } wrong[] = {
        {"{joint: rod, read: reaction, component: fw}", "expected one of fx fy fz"},
        {"{joint: rod, read: reaction, component: fx, axes: bar}", "there is no body \"bar\""},
        {"{joint: rod, read: reaction, component: force, axes: rod}", "a size has no axes"},
        {"{joint: rod, read: position, axes: rod}", "belongs to read: reaction"},
        {"{joint: plate, read: reaction}", "plate is fixed"},
        {"{loop: rod, read: reaction}", "there is no loop \"rod\""},
        {"{loop: mesh, read: reaction, component: fx}", "neither component nor axes"},
        {"{loop: mesh, read: force}", "expected one of reaction"},
        {"{point: rod.p, read: reaction}", "expected one of x y z"},
        {"{point: rod.p, read: x, component: fx}", "component"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        mechanism *m = NULL;
        stein_err why = {STEIN_OK, ""};
        char text[800];
        snprintf(text, sizeof text,
                 "mechanism: wrong\nbodies:\n"
                 "  rod: {joint: R y, mass: 1 kg, inertia: {yy: 1}, points: {p: [0, 0, 1 m]}}\n"
                 "  wheel: {joint: R y, mass: 1 kg, inertia: {yy: 1}}\n"
                 "  plate: {parent: rod, joint: fixed, mass: 1 kg, inertia: {yy: 1}}\n"
                 "couplings: {mesh: {joint: wheel, follows: rod, ratio: 2}}\n"
                 "outputs: {out: %s}\n",
                 wrong[i].output);
        stein_status status =
            mech_read_text(&m, "wrong.yaml", text, strlen(text), NULL, 0, NULL, NULL, &why);
        ck_assert_msg(status == STEIN_EPARSE, "%s", wrong[i].output);
        ck_assert_msg(strstr(why.msg, wrong[i].words) != NULL, "%s: %s", wrong[i].output, why.msg);
    }
}
END_TEST

/* ---- what is not determined ---- */

static int is_determined(stein_sim *sim, const char *name)
{
    int channel = stein_find_channel(stein_sim_model(sim), name);
    ck_assert_int_ge(channel, 0);
    return stein_is_determined(sim, channel);
}

/* One hinge holds the plate; the second one along the same axis takes what it likes of the forces
 * across that axis. */
START_TEST(a_second_hinge_leaves_the_forces_of_both_open)
{
    stein_sim *sim =
        start("mechanism: door\n"
              "bodies:\n"
              "  plate: {joint: R z, mass: 2 kg, centre: [0.2 m, 0, 0.1 m], "
              "inertia: {xx: 0.02, yy: 0.02, zz: 0.02}, points: {top: [0, 0, 0.3 m]}, "
              "initial: {speed: 2 rad/s}}\n"
              "  bob: {parent: plate, joint: R y, mass: 0.1 kg, centre: [0, 0, -0.1 m]}\n"
              "points: {top: [0, 0, 0.3 m]}\n"
              "loops: {upper: {between: [frame.top, plate.top], hinge: z}}\n"
              "outputs:\n"
              "  upper: {loop: upper, read: reaction, component: fx}\n"
              "  lower: {joint: plate, read: reaction, component: fx}\n"
              "  size: {joint: plate, read: reaction}\n"
              "  weight: {loop: upper, read: reaction, component: fz}\n"
              "  about: {joint: plate, read: reaction, component: mz}\n"
              "  bob: {joint: bob, read: reaction}\n"
              "  q: {joint: plate, read: position}\n");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "upper"), 0);
    ck_assert_int_eq(is_determined(sim, "lower"), 0);
    ck_assert_int_eq(is_determined(sim, "size"), 0);
    ck_assert_int_eq(is_determined(sim, "weight"), 0); // either hinge can carry it
    ck_assert_int_eq(is_determined(sim, "about"), 1);  // about the axis nothing holds
    ck_assert_int_eq(is_determined(sim, "bob"), 1);
    ck_assert_int_eq(is_determined(sim, "q"), 1);
    ck_assert_int_eq(stein_is_determined(sim, 99), 1);
    finish(sim);
}
END_TEST

START_TEST(forces_of_a_four_bar_are_determined)
{
    stein_sim *sim =
        start("mechanism: bars\n"
              "bodies:\n"
              "  crank: {joint: R y, mass: 1 kg, points: {e: [0, 0, 0.2 m]}, "
              "initial: {position: 0.3 rad, speed: 1 rad/s}}\n"
              "  rod: {parent: crank, at: crank.e, joint: R y, mass: 1 kg, inertia: {yy: 0.01}, "
              "points: {e: [0.5 m, 0, 0]}}\n"
              "  rocker: {joint: R y, at: [0.5 m, 0, 0], mass: 1 kg, inertia: {yy: 0.02}, "
              "points: {e: [0, 0, 0.3 m]}}\n"
              "loops: {pin: {between: [rod.e, rocker.e]}}\n"
              "outputs: {pin: {loop: pin, read: reaction}, at: {joint: rocker, read: reaction}}\n");
    ck_assert_int_eq(is_determined(sim, "pin"), 1);
    ck_assert_int_eq(is_determined(sim, "at"), 1);
    finish(sim);
}
END_TEST

/* Nothing loads this door along its axis, and no joint can. */
START_TEST(along_an_axis_without_load_two_hinges_are_determined)
{
    stein_sim *sim =
        start("mechanism: door\n"
              "gravity: [0, -9.81 m/s^2, 0]\n"
              "bodies:\n"
              "  plate: {joint: R z, mass: 2 kg, centre: [0.2 m, 0, 0], "
              "inertia: {xx: 0.02, yy: 0.02, zz: 0.02}, points: {top: [0, 0, 0.3 m]}}\n"
              "points: {top: [0, 0, 0.3 m]}\n"
              "loops: {upper: {between: [frame.top, plate.top]}}\n"
              "outputs:\n"
              "  across: {loop: upper, read: reaction, component: fy}\n"
              "  along: {loop: upper, read: reaction, component: fz}\n");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "across"), 0);
    ck_assert_int_eq(is_determined(sim, "along"), 1);
    finish(sim);
}
END_TEST

/* The outer ring of a universal joint turns about z, the inner one about y; its centre is held once
 * more. Whichever of the hinges comes last, all three forces are open. */
START_TEST(hinges_that_are_not_parallel_leave_no_direction_out)
{
    stein_sim *sim =
        start("mechanism: cross\n"
              "gravity: [0, 0, 0]\n"
              "bodies:\n"
              "  outer: {joint: R z, mass: 2 kg, inertia: {xx: 0.02, yy: 0.02, zz: 0.02}}\n"
              "  inner: {parent: outer, joint: R y, mass: 1 kg, "
              "inertia: {xx: 0.01, yy: 0.01, zz: 0.01}, points: {o: [0, 0, 0]}, "
              "initial: {speed: 2 rad/s}}\n"
              "points: {o: [0, 0, 0]}\n"
              "loops: {pin: {between: [frame.o, inner.o]}}\n"
              "outputs:\n"
              "  x: {loop: pin, read: reaction, component: fx}\n"
              "  y: {loop: pin, read: reaction, component: fy}\n"
              "  z: {loop: pin, read: reaction, component: fz}\n");
    ck_assert_int_eq(is_determined(sim, "x"), 0);
    ck_assert_int_eq(is_determined(sim, "y"), 0);
    ck_assert_int_eq(is_determined(sim, "z"), 0);
    finish(sim);
}
END_TEST

/* Two feet hold a table that is pushed: their friction is known in sum. One foot alone holds all.
 */
static stein_sim *start_table(const char *right)
{
    char text[2000];
    snprintf(
        text, sizeof text,
        "mechanism: table\n"
        "gravity: [0.5 m/s^2, 0, -9.81 m/s^2]\n"
        "bodies:\n"
        "  x: {joint: T x}\n"
        "  z: {parent: x, joint: T z, initial: {position: -0.0981 mm}}\n"
        "  top: {parent: z, joint: R y, mass: 2 kg, inertia: {yy: 0.1}, "
        "points: {a: [-0.4 m, 0, 0], b: [0.4 m, 0, 0]}}\n"
        "contacts:\n"
        "  left: {between: [{point: top.a}, {line: {on: frame, at: [0, 0, 0], "
        "facing: 90 deg}}], normal: {c: 1e5, D: 5}, friction: {A: 0.5, stick: yes}}\n"
        "  right: {between: [{point: top.b}, {line: {on: frame, at: [0, 0, 0], "
        "facing: 90 deg}}], normal: {c: 1e5, D: 5}%s}\n"
        "outputs: {left: {contact: left, read: friction}, press: {contact: left, read: force}, "
        "pushed: {joint: x, read: reaction}, turned: {joint: top, read: reaction, component: my}}"
        "\n",
        right);
    return start(text);
}

START_TEST(friction_that_two_feet_share_is_not_determined)
{
    stein_sim *sim = start_table(", friction: {A: 0.5, stick: yes}");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "left"), 0);
    ck_assert_int_eq(is_determined(sim, "press"), 1);
    ck_assert_int_eq(is_determined(sim, "pushed"), 1); // only the sum counts there
    ck_assert_int_eq(is_determined(sim, "turned"), 1);
    finish(sim);
    sim = start_table("");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "left"), 1);
    ck_assert_close(fabs(reads(sim, "left")), 1.0, 1e-6, 0.0);
    finish(sim);
}
END_TEST

/* The same table on legs, whose hinges are held: what a foot has of the friction goes through its
 * leg. */
START_TEST(friction_that_is_shared_leaves_open_what_lies_between)
{
    stein_sim *sim =
        start("mechanism: table\n"
              "gravity: [0.5 m/s^2, 0, -9.81 m/s^2]\n"
              "bodies:\n"
              "  x: {joint: T x}\n"
              "  z: {parent: x, joint: T z, initial: {position: -0.0981 mm}}\n"
              "  top: {parent: z, joint: R y, mass: 2 kg, inertia: {yy: 0.1}, "
              "points: {a: [-0.4 m, 0, 0], b: [0.4 m, 0, 0]}}\n"
              "  lamp: {parent: top, joint: R y, mass: 0.1 kg, centre: [0, 0, 0.1 m]}\n"
              "  one: {parent: top, at: top.a, joint: R y, mass: 0.1 kg, inertia: {yy: 1e-4}, "
              "points: {foot: [0, 0, -0.3 m]}}\n"
              "  two: {parent: top, at: top.b, joint: R y, mass: 0.1 kg, inertia: {yy: 1e-4}, "
              "points: {foot: [0, 0, -0.3 m]}}\n"
              "inputs: {hold: {motion: one, idle: hold}, keep: {motion: two, idle: hold}}\n"
              "contacts:\n"
              "  left: {between: [{point: one.foot}, {line: {on: frame, at: [0, 0, -0.3 m], "
              "facing: 90 deg}}], normal: {c: 1e5, D: 5}, friction: {A: 0.5, stick: yes}}\n"
              "  right: {between: [{point: two.foot}, {line: {on: frame, at: [0, 0, -0.3 m], "
              "facing: 90 deg}}], normal: {c: 1e5, D: 5}, friction: {A: 0.5, stick: yes}}\n"
              "outputs: {left: {contact: left, read: friction}, leg: {joint: one, read: reaction}, "
              "held: {joint: two, read: reaction, component: my}, "
              "up: {joint: two, read: reaction, component: fz}, "
              "pushed: {joint: x, read: reaction}, lamp: {joint: lamp, read: reaction}}\n");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "left"), 0);
    ck_assert_int_eq(is_determined(sim, "leg"), 0);
    ck_assert_int_eq(is_determined(sim, "held"), 0);
    ck_assert_int_eq(is_determined(sim, "up"), 1);
    ck_assert_int_eq(is_determined(sim, "pushed"), 1);
    ck_assert_int_eq(is_determined(sim, "lamp"), 1);
    finish(sim);
}
END_TEST

/* A slide that is held presses a foot onto a rough floor: friction moves nothing, and has any size.
 */
START_TEST(friction_where_nothing_can_move_is_not_determined)
{
    stein_sim *sim =
        start("mechanism: press\n"
              "bodies:\n"
              "  x: {joint: T x}\n"
              "  z: {parent: x, joint: T z, mass: 2 kg, points: {c: [0, 0, 0]}, "
              "initial: {position: -0.0981 mm}}\n"
              "inputs: {hold: {motion: x, idle: hold}}\n"
              "contacts: {floor: {between: [{point: z.c}, {line: {on: frame, at: [0, 0, 0], "
              "facing: 90 deg}}], normal: {c: 2e5, D: 5}, friction: {A: 0.5, stick: yes}}}\n"
              "outputs: {floor: {contact: floor, read: friction}, "
              "side: {joint: x, read: reaction, component: fx}, "
              "press: {contact: floor, read: force}}\n");
    ck_assert_stein(stein_run(sim, 0.1, err));
    ck_assert_int_eq(is_determined(sim, "floor"), 0);
    ck_assert_int_eq(is_determined(sim, "side"), 0);
    ck_assert_int_eq(is_determined(sim, "press"), 1);
    finish(sim);
}
END_TEST

Suite *reaction_suite(void)
{
    Suite *suite = suite_create("reaction");
    TCase *tc = tcase_create("all");
    tcase_set_timeout(tc, 60);
    tcase_add_unchecked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, a_hanging_chain_pulls_with_the_weight_below);
    tcase_add_test(tc, a_pendulum_pulls_with_its_weight_and_centripetal_force);
    tcase_add_test(tc, forces_in_a_joint_are_part_of_its_reaction);
    tcase_add_test(tc, loops_react_by_their_kind);
    tcase_add_test(tc, the_pins_of_a_four_bar_are_those_of_its_free_bodies);
    tcase_add_loop_test(tc, a_reaction_is_the_force_of_held_joints, 0, 2);
    tcase_add_test(tc, sticking_friction_is_a_force_as_well);
    tcase_add_test(tc, reading_a_reaction_changes_no_bit_of_the_motion);
    tcase_add_test(tc, mistakes_are_reported_at_their_place);
    tcase_add_test(tc, a_second_hinge_leaves_the_forces_of_both_open);
    tcase_add_test(tc, forces_of_a_four_bar_are_determined);
    tcase_add_test(tc, along_an_axis_without_load_two_hinges_are_determined);
    tcase_add_test(tc, hinges_that_are_not_parallel_leave_no_direction_out);
    tcase_add_test(tc, friction_that_two_feet_share_is_not_determined);
    tcase_add_test(tc, friction_that_is_shared_leaves_open_what_lies_between);
    tcase_add_test(tc, friction_where_nothing_can_move_is_not_determined);
    suite_add_tcase(suite, tc);
    return suite;
}
