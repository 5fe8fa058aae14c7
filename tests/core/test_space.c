/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_space.c - bodies that turn in all directions, and contacts in space: conserved quantities,
 * motions in closed form, the same motions by another route.
 */
#include <string.h>

#include "draw.h"
#include "fit_support.h"
#include "refused.h"
#include "stein/balance.h"

Suite *space_suite(void);

typedef struct bench {
    lab_model *model;
    stein_sim *sim;
} bench;

static bench start_with(const char *text, const char *const *set, int nset)
{
    bench b = {open_text(text, set, nset), NULL};
    ck_assert_stein(lab_sim(b.model, NULL, &b.sim, err));
    return b;
}

static bench start(const char *text)
{
    return start_with(text, NULL, 0);
}

static void finish(bench *b)
{
    stein_sim_destroy(b->sim);
    lab_close(b->model);
}

static double see(stein_sim *sim, const char *channel)
{
    double value = NAN;
    ck_assert_stein(stein_read_name(sim, channel, &value, err));
    return value;
}

static void see_all(stein_sim *sim, const char *const *channel, int n, double *x)
{
    for (int i = 0; i < n; i++) {
        x[i] = see(sim, channel[i]);
    }
}

static double energy(stein_sim *sim)
{
    double kinetic, potential;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
    return kinetic + potential;
}

static double length3(const double *x)
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

static double apart(const double *x, const double *y)
{
    double d[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
    return length3(d);
}

/* ---- a free rigid body ---- */

static const double moments[3] = {0.01, 0.02, 0.025};
static const char free_body[] =
    "mechanism: freebody\n"
    "gravity: [0, 0, 0]\n"
    "bodies:\n"
    "  b:\n"
    "    joint: free\n"
    "    mass: 1 kg\n"
    "    inertia: {xx: 0.01, yy: 0.02, zz: 0.025}\n"
    "    points: {o: [0, 0, 0], x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1]}\n"
    "    initial: {velocity: [0.3, -0.2, 0.1], spin: [0.1, 1.0, 0.2], attitude: [0, 1.0, 0]}\n"
    "outputs:\n"
    "  wx: {body: b, read: wx}\n  wy: {body: b, read: wy}\n  wz: {body: b, read: wz}\n"
    "  xx: {body: b, read: xx}\n  xy: {body: b, read: xy}\n  xz: {body: b, read: xz}\n"
    "  yx: {body: b, read: yx}\n  yy: {body: b, read: yy}\n  yz: {body: b, read: yz}\n"
    "  zx: {body: b, read: zx}\n  zy: {body: b, read: zy}\n  zz: {body: b, read: zz}\n"
    "  roll: {body: b, read: roll}\n  pitch: {body: b, read: pitch}\n  yaw: {body: b, read: yaw}\n"
    "simulation: {dt: 50 ms, until: 20 s}\n";
static const char *const spin[] = {"wx", "wy", "wz"};
static const char *const axes[] = {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"};

/* R v */
static void turn(const double *R, const double *v, double *out)
{
    for (int i = 0; i < 3; i++) {
        out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
    }
}

static void angular_momentum(stein_sim *sim, double *L)
{
    double R[9], w[3];
    see_all(sim, axes, 9, R);
    see_all(sim, spin, 3, w);
    for (int i = 0; i < 3; i++) {
        w[i] *= moments[i];
    }
    turn(R, w, L);
}

/* 1e4 s are in docs/validation.md */
START_TEST(a_free_body_keeps_its_momenta_and_energy_through_all_attitudes)
{
    static const char *const locked[] = {"b.initial.attitude.y=90deg"}; // of hinges about x, y, z
    bench b = start_with(free_body, locked, _i);
    double before[3], L[3], e = energy(b.sim), off = 0.0, change = 0.0, least = 1.0, most = 0.0;
    double chart = stein_q(b.sim)[3];
    int charts = 0;
    ck_assert_int_eq(stein_freedom(b.sim), 6);
    angular_momentum(b.sim, before);
    for (int i = 1; i <= 100; i++) {
        ck_assert_stein(stein_run(b.sim, i, err));
        angular_momentum(b.sim, L);
        off = fmax(off, apart(L, before) / length3(before));
        change = fmax(change, fabs(energy(b.sim) / e - 1.0));
        least = fmin(least, fabs(cos(stein_q(b.sim)[5])));
        most = fmax(most, fabs(see(b.sim, "xz")));
        charts += stein_q(b.sim)[3] != chart;
        chart = stein_q(b.sim)[3];
    }
    printf("free body, 100 s: angular momentum off by %.2g, energy by %.2g of it; %d charts\n", off,
           change, charts);
    ck_assert(off < 1e-11 && change < 1e-11);
    ck_assert(charts > 10 && least > 0.55 && most > 0.97); // z along x: there three hinges lock
    ck_assert_close(stein_q(b.sim)[0], 30.0, 0.0, 1e-12);
    ck_assert_close(stein_q(b.sim)[1], -20.0, 0.0, 1e-12);
    finish(&b);
}
END_TEST

/* Euler's equations and R' = R w~, by Kutta's method with steps that are short enough */
static void euler(double w[3], double R[9], double t)
{
    enum { STEPS = 20000, N = 12 };
    double y[N], k[4][N], z[N], h = t / STEPS;
    memcpy(y, w, 3 * sizeof *w);
    memcpy(y + 3, R, 9 * sizeof *R);
    for (int step = 0; step < STEPS; step++) {
        for (int s = 0; s < 4; s++) {
            double c = s == 0 ? 0.0 : s == 3 ? h : 0.5 * h;
            for (int i = 0; i < N; i++) {
                z[i] = y[i] + (s > 0 ? c * k[s - 1][i] : 0.0);
            }
            for (int i = 0; i < 3; i++) {
                int a = (i + 1) % 3, d = (i + 2) % 3;
                k[s][i] = (moments[a] - moments[d]) * z[a] * z[d] / moments[i];
                for (int row = 0; row < 3; row++) {
                    k[s][3 + 3 * row + i] = z[3 + 3 * row + a] * z[d] - z[3 + 3 * row + d] * z[a];
                }
            }
        }
        for (int i = 0; i < N; i++) {
            y[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
        }
    }
    memcpy(w, y, 3 * sizeof *w);
    memcpy(R, y + 3, 9 * sizeof *R);
}

START_TEST(a_free_body_turns_by_eulers_equations)
{
    bench b = start(free_body);
    double w[3], R[9], seen[9];
    see_all(b.sim, spin, 3, w);
    ck_assert(fabs(w[0] - 0.1) < 1e-15 && fabs(w[1] - 1.0) < 1e-15 && fabs(w[2] - 0.2) < 1e-15);
    see_all(b.sim, axes, 9, R);
    ck_assert_close(R[2], sin(1.0), 1e-15, 0.0);
    euler(w, R, 20.0);
    ck_assert_stein(stein_run(b.sim, 20.0, err));
    see_all(b.sim, spin, 3, seen);
    (void)assert_near("angular velocity", seen, w, 3, 1e-9);
    see_all(b.sim, axes, 9, seen);
    (void)assert_near("attitude", seen, R, 9, 1e-9);
    finish(&b);
}
END_TEST

START_TEST(attitudes_are_where_points_are)
{
    bench b = start(free_body);
    double R[9], x[3 * 4], v[3 * 4], w[3], expected[3], spun[3];
    ck_assert_stein(stein_run(b.sim, 3.7, err));
    see_all(b.sim, axes, 9, R);
    see_all(b.sim, spin, 3, w);
    stein_points(b.sim, stein_q(b.sim), stein_qd(b.sim), x, v, NULL, NULL);
    for (int axis = 0; axis < 3; axis++) {
        double e[3] = {axis == 0, axis == 1, axis == 2};
        int a = (axis + 1) % 3, d = (axis + 2) % 3;
        spun[axis] = 0.0; // w x e
        spun[a] = w[d];
        spun[d] = -w[a];
        turn(R, spun, expected);
        for (int i = 0; i < 3; i++) {
            ck_assert_close(x[3 * (axis + 1) + i] - x[i], R[3 * i + axis], 0.0, 1e-13);
            ck_assert_close(v[3 * (axis + 1) + i] - v[i], expected[i], 0.0, 1e-13);
        }
        ck_assert_close(length3(e), 1.0, 0.0, 0.0);
    }
    double roll = see(b.sim, "roll"), pitch = see(b.sim, "pitch"), yaw = see(b.sim, "yaw");
    ck_assert_close(R[0], cos(yaw) * cos(pitch), 0.0, 1e-13);
    ck_assert_close(R[3], sin(yaw) * cos(pitch), 0.0, 1e-13);
    ck_assert_close(R[6], -sin(pitch), 0.0, 1e-13);
    ck_assert_close(R[7], sin(roll) * cos(pitch), 0.0, 1e-13);
    ck_assert_close(R[8], cos(roll) * cos(pitch), 0.0, 1e-13);
    finish(&b);
}
END_TEST

START_TEST(a_saved_state_goes_on_with_the_same_bits_in_another_chart)
{
    bench b = start(free_body);
    void *kept = malloc(stein_state_size(b.sim));
    ck_assert_stein(stein_run(b.sim, 2.0, err));
    stein_save(b.sim, kept);
    double chart = stein_q(b.sim)[3], q[7];
    ck_assert_stein(stein_run(b.sim, 12.0, err));
    memcpy(q, stein_q(b.sim), sizeof q);
    ck_assert(q[3] != chart);
    ck_assert_stein(stein_restore(b.sim, kept, err));
    ck_assert_stein(stein_run(b.sim, 12.0, err));
    ck_assert_mem_eq(stein_q(b.sim), q, sizeof q);
    free(kept);
    finish(&b);
}
END_TEST

/* steady precession W at a tilt a: m g l = W (C w3 - A W cos a), A about the point that stays */
START_TEST(a_gyroscope_precesses_steadily)
{
    stein_sim *sim = make_sim(&stein_model_gyroscope, STEIN_CONTROLLED, 0.0);
    double a = acos(-1.0) / 3.0, off = 0.0;
    for (int i = 1; i <= 20; i++) {
        double t = 0.25 * i, axis = 2.0 * t - acos(0.0);
        ck_assert_stein(stein_run(sim, t, err));
        off = fmax(off, fabs(see(sim, "axis_x") - sin(a) * cos(axis)));
        off = fmax(off, fabs(see(sim, "axis_y") - sin(a) * sin(axis)));
        off = fmax(off, fabs(see(sim, "height") / 0.1 - cos(a)));
    }
    printf("gyroscope: its axis is off by %.2g of what is known\n", off);
    ck_assert(off < 1e-10);
    ck_assert_int_eq(stein_freedom(sim), 3);
    stein_sim_destroy(sim);
}
END_TEST

/* two tops whose tips a rod holds apart */
START_TEST(balls_close_loops)
{
    static const char text[] =
        "mechanism: tops\n"
        "bodies:\n"
        "  a: {joint: ball, mass: 1 kg, centre: [0, 0, 0.1], inertia: {xx: 2e-3, yy: 3e-3, zz: "
        "4e-3}, points: {tip: [0, 0, 0.2]}, initial: {attitude: [0.4, 0.3, 0], spin: [1, 2, 9]}}\n"
        "  b: {joint: ball, at: [0.3, 0, 0], mass: 1 kg, centre: [0, 0, -0.1], inertia: {xx: 2e-3, "
        "yy: 2e-3, zz: 1e-3}, points: {tip: [0, 0, 0.2]}}\n"
        "loops: {rod: {between: [a.tip, b.tip], rod: 0.25 m}}\n"
        "simulation: {dt: 5 ms, until: 3 s}\n";
    bench b = start(text);
    double e = energy(b.sim), change = 0.0, x[6], gap = 0.0, chart = stein_q(b.sim)[0];
    int charts = 0;
    ck_assert_int_eq(stein_freedom(b.sim), 5);
    for (int i = 1; i <= 300; i++) {
        ck_assert_stein(stein_run(b.sim, 0.01 * i, err));
        stein_points(b.sim, stein_q(b.sim), stein_qd(b.sim), x, NULL, NULL, NULL);
        gap = fmax(gap, fabs(apart(x, x + 3) - 0.25));
        change = fmax(change, fabs(energy(b.sim) - e));
        charts += stein_q(b.sim)[0] != chart;
        chart = stein_q(b.sim)[0];
    }
    printf("two tops and a rod: open by %.2g m, energy by %.2g J, %d charts\n", gap, change,
           charts);
    ck_assert(gap < 1e-12 && change < 1e-9 && charts > 3);
    finish(&b);
}
END_TEST

/* ---- contacts ---- */

static const char sphere_on_plane[] =
    "mechanism: sphere\n"
    "parameters: {ground.nx: '0', ground.ny: '0', ground.nz: '1'}\n"
    "bodies:\n"
    "  s: {joint: free, mass: 2 kg, inertia: {xx: 0.008, yy: 0.008, zz: 0.008}, points: {c: [0, 0, "
    "0]}}\n"
    "contacts:\n"
    "  floor:\n"
    "    between: [{plane: {on: frame, at: [0, 0, 0], normal: [ground.nx, ground.ny, ground.nz]}}, "
    "{sphere: {at: s.c, radius: 0.1}}]\n"
    "    normal: {c: 1e6 N/m, D: 1 s/m}\n"
    "    friction: {A: 0.3, vt: 0.1 mm/s}\n"
    "outputs:\n"
    "  vx: {point: s.c, read: vx}\n  vy: {point: s.c, read: vy}\n  vz: {point: s.c, read: vz}\n"
    "  wx: {body: s, read: wx}\n  wy: {body: s, read: wy}\n  wz: {body: s, read: wz}\n"
    "  force: {contact: floor, read: force}\n  gap: {contact: floor, read: gap}\n"
    "  friction: {contact: floor, read: friction}\n"
    "simulation: {dt: 10 ms, until: 2 s}\n";
static const char *const velocity[] = {"vx", "vy", "vz"};

/* v0 until the friction has made it roll: 5/7 v0 */
START_TEST(a_sphere_that_slides_rolls_in_the_end)
{
    static const char *const set[] = {"s.initial.position.z=0.1 m - 2*9.81/1e6*1 m",
                                      "s.initial.velocity.x=2.8", "s.initial.velocity.y=-2.1",
                                      "s.initial.spin.z=3"};
    bench b = start_with(sphere_on_plane, set, 4);
    double v[3], mu = 0.3, until = 2.0 / 7.0 * 3.5 / (mu * 9.81);
    stein_balance *balance;
    ck_assert_stein(stein_balance_create(&balance, lab_equations(b.model), NULL, err));
    ck_assert_stein(stein_balance_attach(balance, b.sim, err));
    ck_assert_stein(stein_run(b.sim, 0.5 * until, err));
    see_all(b.sim, velocity, 3, v);
    ck_assert_close(hypot(v[0], v[1]), 3.5 - mu * 9.81 * 0.5 * until, 2e-4, 0.0);
    ck_assert_close(see(b.sim, "friction"), mu * see(b.sim, "force"), 1e-9, 0.0);
    ck_assert_stein(stein_run(b.sim, 2.0, err));
    see_all(b.sim, velocity, 3, v);
    ck_assert_close(v[0], 2.0, 1e-4, 0.0);
    ck_assert_close(v[1], -1.5, 1e-4, 0.0);
    ck_assert_close(see(b.sim, "force"), 2.0 * 9.81, 1e-6, 0.0);
    // it rolls about the axis across its way, and goes on spinning about the vertical
    double w[3];
    see_all(b.sim, spin, 3, w);
    ck_assert_close(length3(w), hypot(25.0, 3.0), 1e-4, 0.0);
    // friction takes 2/7 of the kinetic energy
    ck_assert_close(stein_balance_work(balance, STEIN_WORK_FRICTION, 0), -2.0 / 7.0 * 3.5 * 3.5,
                    1e-4, 0.0);
    stein_balance_destroy(balance);
    finish(&b);
}
END_TEST

/* 5/7 g sin down the slope, whichever way that is */
START_TEST(a_sphere_rolls_down_an_incline)
{
    static const char *const set[] = {"ground.nx=0.24",
                                      "ground.ny=-0.32",
                                      "ground.nz=1.2",
                                      "s.initial.position.x=0.1 m*0.24/1.265",
                                      "s.initial.position.y=-0.1 m*0.32/1.265",
                                      "s.initial.position.z=0.1 m*1.2/1.265"};
    bench b = start_with(sphere_on_plane, set, 6);
    double v[2][3], slope = 0.4 / sqrt(0.16 + 1.44), a;
    for (int k = 0; k < 2; k++) {
        ck_assert_stein(stein_run(b.sim, 0.5 + 0.5 * k, err));
        see_all(b.sim, velocity, 3, v[k]);
    }
    a = apart(v[1], v[0]) / 0.5;
    ck_assert_close(a, 5.0 / 7.0 * 9.81 * slope, 1e-6, 0.0);
    ck_assert_close((v[1][0] - v[0][0]) / (v[1][1] - v[0][1]), -0.75, 1e-6, 0.0);
    finish(&b);
}
END_TEST

static void note_time(void *ctx, stein_sim *sim, const stein_event *event)
{
    double *when = ctx;
    (void)sim;
    int k = event->kind == STEIN_EVENT_CONTACT_BEGIN ? 0 : 1;
    when[k] = isnan(when[k]) ? event->time : when[k];
}

static const char box_on_plane[] =
    "mechanism: box\n"
    "bodies:\n"
    "  b: {joint: free, mass: 2 kg, inertia: {xx: 0.01, yy: 0.02, zz: 0.015}, points: {c: [0, 0, "
    "0]}, initial: {position: [0, 0, 0.15], velocity: [0, 0, 0]}}\n"
    "contacts:\n"
    "  floor:\n"
    "    between: [{box: {on: b, at: [0, 0, 0], size: [0.2, 0.3, 0.1]}}, {plane: {on: frame, at: "
    "[0, 0, 0], normal: [0, 0, 2]}}]\n"
    "    normal: {c: 5e3 N/m}\n"
    "    friction: {A: 0.4, vt: 1 mm/s}\n"
    "outputs:\n"
    "  z: {point: b.c, read: z}\n  x: {point: b.c, read: x}\n  roll: {body: b, read: roll}\n"
    "  pitch: {body: b, read: pitch}\n  force: {contact: floor, read: force}\n"
    "simulation: {dt: 1 ms, until: 1 s}\n";

/* four corners are one spring of 4 c: it is on it for 2 (pi - atan(v w / g)) / w and rises again */
START_TEST(a_box_dropped_flat_bounces_as_a_mass_on_a_spring)
{
    bench b = start(box_on_plane);
    double when[2] = {NAN, NAN}, g = 9.81, h = 0.1, w = sqrt(4.0 * 5e3 / 2.0);
    double fall = sqrt(2.0 * h / g), v = g * fall, on = 2.0 * (acos(-1.0) - atan(v * w / g)) / w;
    stein_on_event(b.sim, note_time, when);
    ck_assert_stein(stein_run(b.sim, 2.0 * fall + on, err));
    ck_assert_close(when[0], fall, 0.0, 1e-10);
    ck_assert_close(when[1], fall + on, 0.0, 1e-9);
    ck_assert_close(see(b.sim, "z"), 0.15, 0.0, 1e-9);
    ck_assert_close(see(b.sim, "roll"), 0.0, 0.0, 1e-12);
    ck_assert_close(see(b.sim, "x"), 0.0, 0.0, 1e-12);
    finish(&b);
}
END_TEST

/* in the air its centre falls and its angular momentum stays; in the end it lies on a side */
START_TEST(a_thrown_cube_comes_to_rest_on_a_side)
{
    stein_sim *sim = make_sim(&stein_model_cube, STEIN_CONTROLLED, 0.0);
    double x[6], v[6];
    ck_assert_stein(stein_run(sim, 0.15, err));
    ck_assert_close(see(sim, "x"), 0.8 * 0.15, 0.0, 1e-12);
    ck_assert_close(see(sim, "height"), 0.2 + 0.5 * 0.15 - 0.5 * 9.81 * 0.15 * 0.15, 0.0, 1e-12);
    ck_assert_close(see(sim, "spin"), 5.0, 0.0, 1e-10); // all its moments are equal
    ck_assert_stein(stein_run(sim, 6.0, err));
    ck_assert_close(see(sim, "force"), 0.37 * 9.81, 1e-3, 0.0);
    // four corners carry it
    ck_assert_close(see(sim, "height"), 0.05 - 0.37 * 9.81 / (4.0 * 20e3), 0.0, 1e-7);
    stein_points(sim, stein_q(sim), stein_qd(sim), x, v, NULL, NULL);
    ck_assert(length3(v) < 1e-5 && apart(v, v + 3) < 1e-5);
    stein_sim_destroy(sim);
}
END_TEST

/* both move; what friction takes from the one the other gets, and about any point */
START_TEST(spheres_that_collide_keep_all_momenta)
{
    static const char text[] =
        "mechanism: spheres\n"
        "gravity: [0, 0, 0]\n"
        "bodies:\n"
        "  a: {joint: free, mass: 2 kg, inertia: {xx: 0.01, yy: 0.01, zz: 0.01}, points: {c: [0, "
        "0, "
        "0]}, initial: {velocity: [3, 0.2, -0.1], spin: [5, -3, 8]}}\n"
        "  b: {joint: free, mass: 1 kg, inertia: {xx: 0.004, yy: 0.004, zz: 0.004}, points: {c: "
        "[0, "
        "0, 0]}, initial: {position: [0.5, 0.03, 0.05], attitude: [1, 2, 3]}}\n"
        "contacts:\n"
        "  hit: {between: [{sphere: {at: a.c, radius: 0.1}}, {sphere: {at: b.c, radius: 0.08}}], "
        "normal: {c: 1e5 N/m}, friction: {A: 0.3, vt: 5 mm/s}}\n"
        "outputs:\n"
        "  axx: {body: a, read: xx}\n  axy: {body: a, read: xy}\n  axz: {body: a, read: xz}\n"
        "  ayx: {body: a, read: yx}\n  ayy: {body: a, read: yy}\n  ayz: {body: a, read: yz}\n"
        "  azx: {body: a, read: zx}\n  azy: {body: a, read: zy}\n  azz: {body: a, read: zz}\n"
        "  awx: {body: a, read: wx}\n  awy: {body: a, read: wy}\n  awz: {body: a, read: wz}\n"
        "  bxx: {body: b, read: xx}\n  bxy: {body: b, read: xy}\n  bxz: {body: b, read: xz}\n"
        "  byx: {body: b, read: yx}\n  byy: {body: b, read: yy}\n  byz: {body: b, read: yz}\n"
        "  bzx: {body: b, read: zx}\n  bzy: {body: b, read: zy}\n  bzz: {body: b, read: zz}\n"
        "  bwx: {body: b, read: wx}\n  bwy: {body: b, read: wy}\n  bwz: {body: b, read: wz}\n"
        "simulation: {dt: 1 ms, until: 0.3 s}\n";
    static const double mass[2] = {2.0, 1.0}, inertia[2] = {0.01, 0.004};
    bench b = start(text);
    double P[2][3] = {{0.0}}, L[2][3] = {{0.0}}, e[2];
    for (int k = 0; k < 2; k++) {
        double x[6], v[6];
        ck_assert_stein(stein_run(b.sim, 0.3 * k, err));
        stein_points(b.sim, stein_q(b.sim), stein_qd(b.sim), x, v, NULL, NULL);
        e[k] = energy(b.sim);
        for (int body = 0; body < 2; body++) {
            double R[9], w[3], moment[3];
            for (int i = 0; i < 9; i++) {
                R[i] = stein_read(b.sim, 1 + 12 * body + i);
            }
            for (int i = 0; i < 3; i++) {
                w[i] = inertia[body] * stein_read(b.sim, 10 + 12 * body + i);
            }
            turn(R, w, moment);
            for (int i = 0; i < 3; i++) {
                int a = (i + 1) % 3, d = (i + 2) % 3;
                P[k][i] += mass[body] * v[3 * body + i];
                L[k][i] += moment[i] + mass[body] * (x[3 * body + a] * v[3 * body + d] -
                                                     x[3 * body + d] * v[3 * body + a]);
            }
        }
    }
    ck_assert(apart(P[0], P[1]) < 1e-10 && apart(L[0], L[1]) < 1e-10);
    ck_assert(e[1] < 0.99 * e[0]); // it did rub
    finish(&b);
}
END_TEST

/* down a tree of turning and sliding joints to one that turns as well: no energy is lost */
START_TEST(forces_go_down_the_tree)
{
    static const char text[] =
        "mechanism: arm\n"
        "bodies:\n"
        "  post: {joint: R z, mass: 1 kg, inertia: {xx: 0.1, yy: 0.1, zz: 0.1}, initial: {speed: "
        "0.5 rad/s}}\n"
        "  arm: {parent: post, joint: R -x, at: [0.1, 0, 0.5], mass: 1 kg, centre: [0, 0.2, 0], "
        "inertia: {xx: 0.02, yy: 0.01, zz: 0.02}, initial: {position: 0.2 rad}}\n"
        "  sled: {parent: arm, joint: T -y, at: [0, 0.5, 0.05], mass: 0.5 kg, spring: {k: 200 "
        "N/m}}\n"
        "  head: {parent: sled, joint: ball, mass: 0.3 kg, centre: [0.05, 0, 0], inertia: {xx: "
        "1e-3, "
        "yy: 2e-3, zz: 2e-3}, points: {p: [0.12, 0.02, 0]}, initial: {spin: [1, 2, 3]}}\n"
        "  table: {joint: R y, mass: 3 kg, inertia: {yy: 0.5}, spring: {k: 50 N m/rad}}\n"
        "contacts:\n"
        "  hit: {between: [{point: head.p}, {plane: {on: table, at: [0, 0, 0.1], normal: [0.1, "
        "0.2, "
        "1]}}], normal: {c: 2e4 N/m}}\n"
        "outputs:\n"
        "  gap: {contact: hit, read: gap}\n  sled: {joint: sled, read: position}\n"
        "  table: {joint: table, read: position}\n"
        "simulation: {dt: 1 ms, until: 2 s}\n";
    bench b = start(text);
    double whole = NAN, change = 0.0, least = 0.0;
    for (int i = 0; i <= 400; i++) {
        ck_assert_stein(stein_run(b.sim, 0.005 * i, err));
        double gap = see(b.sim, "gap"), x = gap < 0.0 ? -gap : 0.0, s = see(b.sim, "sled"),
               t = see(b.sim, "table");
        double e = energy(b.sim) + 1e4 * x * x + 100.0 * s * s + 25.0 * t * t;
        whole = i == 0 ? e : whole;
        change = fmax(change, fabs(e - whole));
        least = fmin(least, gap);
    }
    printf("arm on a table: energy off by %.2g J of %.3g J, %.2g m deep\n", change, whole, -least);
    ck_assert(change < 1e-8 && least < -1e-3);
    finish(&b);
}
END_TEST

/* a disc that bounces and rubs: in the x-z plane by planar contacts, by those in space, and the
 * same in the x-y plane */
START_TEST(planes_and_space_agree)
{
    static const char text[] =
        "mechanism: %s\n"
        "gravity: [0, %s]\n"
        "bodies:\n"
        "  x: {joint: T x, initial: {speed: 0.7 m/s}}\n"
        "  z: {parent: x, joint: T %c, initial: {position: 0.3 m}}\n"
        "  disc: {parent: z, joint: R %s, mass: 1 kg, inertia: {%s: 2e-3}, points: {c: %s}, "
        "initial: "
        "{speed: 9 rad/s}}\n"
        "contacts:\n"
        "  floor: {between: [{%s: {at: disc.c, radius: 0.1}}, {%s}], normal: {c: 1e4 N/m, D: 0.5 "
        "s/m}, friction: {A: 0.3, vt: 1 cm/s, B1: 0.6, B2: 0.1}}\n"
        "outputs:\n"
        "  x: {joint: x, read: position}\n  z: {joint: z, read: position}\n"
        "  turn: {joint: disc, read: position}\n"
        "simulation: {dt: 1 ms, until: 1 s}\n";
    static const char *const seen[] = {"x", "z", "turn"};
    static const char *const line = "line: {on: frame, at: [0, 0, 0], facing: 80 deg}";
    static const char *const plane =
        "plane: {on: frame, at: [0, 0, 0], normal: [cos(80 deg), 0, sin(80 deg)]}";
    double at[3][3];
    for (int k = 0; k < 3; k++) {
        int across = k == 2;
        char file[1500];
        snprintf(file, sizeof file, text,
                 k == 0   ? "flat"
                 : k == 1 ? "solid"
                          : "other",
                 across ? "-9.81, 0" : "0, -9.81", across ? 'y' : 'z', across ? "z" : "-y",
                 across ? "zz" : "yy", across ? "[0.01, 0.02, 0]" : "[0.01, 0, 0.02]",
                 k == 1 ? "sphere" : "circle", k == 1 ? plane : line);
        bench b = start(file);
        ck_assert_stein(stein_run(b.sim, 1.0, err));
        see_all(b.sim, seen, 3, at[k]);
        finish(&b);
    }
    (void)assert_near("in space", at[1], at[0], 3, 1e-9);
    (void)assert_near("in x-y", at[2], at[0], 3, 1e-9);
}
END_TEST

/* ---- records ---- */

/* 13 heights of a cube in the air have two unknowns of their own, not fourteen */
START_TEST(heights_of_a_thrown_cube_give_gravity)
{
    static const char *const truth[] = {"gravity.z=-9.7 m/s^2", "cube.initial.position.z=0.25 m",
                                        "cube.initial.velocity.z=0.7 m/s", NULL};
    static const char *const names[] = {"gravity.z", NULL};
    film m = {.model = "models/cube.yaml",
              .truth = truth,
              .channels = "height",
              .rate = 60.0,
              .until = 0.2,
              .noise = 1e-5,
              .seed = 12};
    const char *data[] = {take("thrown.csv", &m), NULL};
    fitted f;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    ck_assert_stein(lab_fit_run(&f.fit, f.model, f.data, &def, err));
    ck_assert_status(f.fit, LAB_FIT_CONVERGED);
    ck_assert_found(f.fit, "gravity.z", -9.7, 3.0);
    ck_assert(value_of(f.fit, "gravity.z")->sd < 0.02);
    drop(&f);
}
END_TEST

/* ---- refusals ---- */

START_TEST(functions_without_space_refuse_it)
{
    stein_err why = {STEIN_OK, ""};
    stein_derivative *s = NULL;
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    stein_sim *sim = make_sim(&stein_model_cube, STEIN_CONTROLLED, 0.0);
    ck_assert_int_eq(stein_settle(sim, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "turns in all directions"));
    ck_assert_int_eq(stein_derivative_create(&s, &stein_model_cube, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "no derivatives yet"));
    ck_assert_int_eq(stein_batch_width(&stein_model_cube), 1); // each for itself
    stein_sim_destroy(sim);
    ck_assert_stein(lab_open(&model, "models/cube.yaml", &options, err));
    ck_assert_int_eq(lab_page(in_folder("c.html"), model, NULL, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "moves in space"));
    ck_assert_int_eq(lab__draw(in_folder("c.svg"), model, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "moves in space"));
    ck_assert_int_eq(lab_fmu(in_folder("c.fmu"), model, 3, NULL, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "turns in all directions"));
    lab_close(model);
}
END_TEST

START_TEST(mistakes_are_reported)
{
    static const struct {
        const char *from, *to, *words;
    } wrong[] = {
        {"joint: free,", "joint: free, damping: 1,", "unknown key \"damping\" in a free body"},
        {"joint: free,", "joint: ball,", "unknown key \"position\" in initial"},
        {"position: [0, 0, 0.15]", "position: 0.15", "must be a list of three numbers"},
        {"b: {joint", "a_name_that_is_too_long_for_it: {joint", "at most 26 signs"},
        {"{point: b.c, read: z}", "{joint: b, read: position}", "turns in all directions"},
        {"{body: b, read: roll}", "{body: b, read: rol}", "did you mean \"roll\""},
        {"vt: 1 mm/s", "stick: yes", "the friction of a contact in space cannot stick"},
        {"{box: {on: b, at: [0, 0, 0], size: [0.2, 0.3, 0.1]}}", "{circle: {at: b.c, radius: 1}}",
         "circles and lines touch in a plane"},
        {"{plane: {on: frame, at: [0, 0, 0], normal: [0, 0, 2]}}",
         "{sphere: {on: frame, at: [0, 0, 0], radius: 1}}", "a box touches a plane only"},
        {"{box: {on: b, at: [0, 0, 0], size: [0.2, 0.3, 0.1]}}",
         "{plane: {on: b, at: [0, 0, 0], normal: [0, 0, 2]}}", "a plane cannot touch a plane"},
        {"normal: [0, 0, 2]", "normal: [0, 0, 0]", "has no length"},
        {"normal: [0, 0, 2]", "facing: 2", "lacks \"normal\""},
        {"until: 1 s", "settle: yes", "expected settle: no"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[2000];
        const char *at = strstr(box_on_plane, wrong[i].from);
        ck_assert_ptr_nonnull(at);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - box_on_plane), box_on_plane, wrong[i].to,
                 at + strlen(wrong[i].from));
        ck_assert_refused(text, wrong[i].words);
    }
}
END_TEST

Suite *space_suite(void)
{
    Suite *suite = suite_create("space");
    TCase *all = tcase_create("all");
    tcase_set_timeout(all, 60);
    tcase_add_unchecked_fixture(all, make_folder, remove_folder);
    tcase_add_loop_test(all, a_free_body_keeps_its_momenta_and_energy_through_all_attitudes, 0, 2);
    tcase_add_test(all, a_free_body_turns_by_eulers_equations);
    tcase_add_test(all, attitudes_are_where_points_are);
    tcase_add_test(all, a_saved_state_goes_on_with_the_same_bits_in_another_chart);
    tcase_add_test(all, a_gyroscope_precesses_steadily);
    tcase_add_test(all, balls_close_loops);
    tcase_add_test(all, a_sphere_that_slides_rolls_in_the_end);
    tcase_add_test(all, a_sphere_rolls_down_an_incline);
    tcase_add_test(all, a_box_dropped_flat_bounces_as_a_mass_on_a_spring);
    tcase_add_test(all, a_thrown_cube_comes_to_rest_on_a_side);
    tcase_add_test(all, spheres_that_collide_keep_all_momenta);
    tcase_add_test(all, forces_go_down_the_tree);
    tcase_add_test(all, planes_and_space_agree);
    tcase_add_test(all, heights_of_a_thrown_cube_give_gravity);
    tcase_add_test(all, functions_without_space_refuse_it);
    tcase_add_test(all, mistakes_are_reported);
    suite_add_tcase(suite, all);
    return suite;
}
