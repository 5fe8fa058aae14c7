/* SPDX-License-Identifier: GPL-3.0-or-later
 * mechanisms.c - mechanisms with solutions in closed form or by quadrature, and the published facts
 * of the action of 1788. Every mechanism is run as its file says, at default settings.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_ellint.h>
#include <gsl/gsl_sf_elljac.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "../core/governor.h"
#include "validate.h"

static const double g = 9.81; /* of all files [m/s^2] */

/* runs, with a channel over time as the picture of the next row */
static void run_and_draw(const bench *b, double until, const char *channel)
{
    for (int i = 0; i <= 500; i++) {
        double t = until * i / 500.0;
        bench_run(b, t);
        validate_point(VALIDATE_LINE, t, bench_read(b, channel));
    }
}

/* sn, cn, dn of a large argument */
static void jacobi(double u, double m, double *sn, double *cn, double *dn)
{
    double period = 4.0 * gsl_sf_ellint_Kcomp(sqrt(m), GSL_PREC_DOUBLE);
    (void)gsl_sf_elljac_e(fmod(u, period), m, sn, cn, dn);
}

/* x = sin q, z = -cos q with sin(q/2) = k cd(w t): at rest at 90 deg */
static void point_pendulum(void)
{
    bench b = bench_start("tests/validate/pendulum.yaml");
    double worst = 0.0, m = 0.5, sn, cn, dn;
    for (int i = 1; i <= 4000; i++) {
        double t = 0.5 * i;
        bench_run(&b, t);
        jacobi(sqrt(g) * t, m, &sn, &cn, &dn);
        double half = asin(sqrt(m) * cn / dn);
        double off = fmax(fabs(bench_read(&b, "x") - sin(2.0 * half)),
                          fabs(bench_read(&b, "z") + cos(2.0 * half)));
        worst = fmax(worst, off);
        validate_point(VALIDATE_LINE, t, 1e6 * off);
    }
    validate_axes("t [s]", "off by [um]");
    char ours[64];
    validate_row("simple pendulum from 90 deg, 2000 s: position at 4000 times [m]",
                 "IFToMM benchmark A01", "Jacobi elliptic functions",
                 bench_cell(ours, "off by %.1e", worst), worst, 1e-3);
    bench_end(&b);
}

/* Momentum along x is 0, so the cart follows the pole: (1/2) I(q) qd^2 = m g l (cos q - cos q0),
 * I = m l^2 (1 - m / (M + m) cos^2 q). With q = q0 sin(u) the integrand of t is finite. */
static const double start_angle = 1.0, cart_mass = 1e-6;

static double cart_time(double u, void *ctx)
{
    (void)ctx;
    double q = start_angle * sin(u), share = 1.0 / (1.0 + cart_mass);
    // cos q - cos q0 without cancellation
    double fall =
        2.0 * sin(0.5 * (start_angle + q)) * sin(start_angle * pow(sin(0.5 * (M_PI_2 - u)), 2.0));
    double inertia = 1.0 - share + share * sin(q) * sin(q);
    return sqrt(inertia / (2.0 * g * fall)) * start_angle * cos(u);
}

static void light_cart(void)
{
    bench b = bench_start("tests/validate/cart.yaml");
    double at = 0.4, swings = 10.0;
    double quarter = bench_integral(cart_time, NULL, 0.0, M_PI_2 - 1e-9);
    double down = quarter - bench_integral(cart_time, NULL, 0.0, asin(at / start_angle));
    run_and_draw(&b, swings * 4.0 * quarter + down, "q");
    validate_axes("t [s]", "angle [rad]");
    double q = bench_read(&b, "q"), x = bench_read(&b, "x");
    double right = (sin(start_angle) - sin(at)) / (1.0 + cart_mass);
    double error = fmax(fabs(q - at), fabs(x - right));
    char ours[64];
    validate_row("light cart-pole, M = 1e-6 kg, after 10 swings: angle and place [rad, m]",
                 "quadrature of the energy", "0.4 rad", bench_cell(ours, "%.9f rad", q), error,
                 1e-5);
    bench_end(&b);
}

static void double_pendulum(void)
{
    bench b = bench_start("models/double_pendulum.yaml");
    double e = bench_energy(&b), worst = 0.0, most = 0.0, kinetic, potential;
    for (int i = 1; i <= 1000; i++) {
        bench_run(&b, 0.1 * i);
        stein_energy(b.sim, stein_q(b.sim), stein_qd(b.sim), &kinetic, &potential);
        worst = fmax(worst, fabs(kinetic + potential - e));
        most = fmax(most, kinetic);
        validate_point(VALIDATE_LINE, 0.1 * i, 1e9 * (kinetic + potential - e) / e);
    }
    validate_axes("t [s]", "energy, 1e-9 of it");
    char ours[64];
    validate_row("double pendulum, 100 s: energy", "conservation", "constant",
                 bench_cell(ours, "drift %.1e of the kinetic energy", worst / most), worst / most,
                 1e-9);
    bench_end(&b);
}

/* ---- contacts ---- */

typedef struct cubic {
    double a, b, c, mass, speed; /* when it touches */
    double deepest;
} cubic;

/* v^2 of the ball at the depth x */
static double speed2(const cubic *k, double x)
{
    double stored = x * x * (k->c / 2.0 + x * (k->b / 3.0 + x * k->a / 4.0));
    return k->speed * k->speed + 2.0 * g * x - 2.0 * stored / k->mass;
}

static double contact_time(double u, void *ctx)
{
    const cubic *k = ctx;
    return k->deepest * cos(u) / sqrt(speed2(k, k->deepest * sin(u)));
}

static void elastic_ball(void)
{
    bench b = bench_start("tests/validate/ball.yaml");
    cubic k = {3e10, 2e7, 4e4, 0.35, sqrt(2.0 * g * 0.42), 0.0};
    double low = 0.0, high = 0.01;
    for (int i = 0; i < 200; i++) {
        k.deepest = 0.5 * (low + high);
        *(speed2(&k, k.deepest) > 0.0 ? &low : &high) = k.deepest;
    }
    k.deepest = low;
    int bounces = 30;
    double fall = k.speed / g, contact = 2.0 * bench_integral(contact_time, &k, 0.0, M_PI_2 - 1e-7);
    double rise = 0.3 * fall; // in the flight behind the last bounce
    run_and_draw(&b, fall + bounces * contact + (bounces - 1) * 2.0 * fall + rise, "z");
    validate_axes("t [s]", "height [m]");
    double right = k.speed * rise - 0.5 * g * rise * rise, z = bench_read(&b, "z");
    char reference[64], ours[64];
    validate_row("elastic ball on a cubic contact, height after 30 bounces [m]",
                 "quadrature of the contact", bench_cell(reference, "%.9f m", right),
                 bench_cell(ours, "%.9f m", z), fabs(z - right), 1e-5);
    bench_end(&b);
}

/* Hunt & Crossley 1975, without other forces: v/D - ln(1 + D v)/D^2 is the same before and after,
 * with the sign of v. */
static void hunt_crossley(void)
{
    bench b = bench_start("tests/validate/hunt_crossley.yaml");
    double D = 0.47, in = 1.3, low = 0.0, high = in;
    double same = in / D - log1p(D * in) / (D * D);
    for (int i = 0; i < 200; i++) {
        double out = 0.5 * (low + high), there = -out / D - log1p(-D * out) / (D * D);
        *(there < same ? &low : &high) = out;
    }
    run_and_draw(&b, 0.1, "v");
    validate_axes("t [s]", "speed [m/s]");
    double v = bench_read(&b, "v");
    char reference[64], ours[64];
    validate_row("Hunt-Crossley contact, speed of rebound [m/s]",
                 "Hunt & Crossley 1975, closed form", bench_cell(reference, "%.12f m/s", low),
                 bench_cell(ours, "%.12f m/s", v), fabs(v - low), 1e-9);
    bench_end(&b);
}

static void constant_speed(void *ctx, double t, double u[3])
{
    u[0] = *(double *)ctx * t;
    u[1] = *(double *)ctx;
    u[2] = 0.0;
}

typedef struct slips {
    int n;
    double first, last; /* begins after the one at the start [s] */
} slips;

static void count_slips(void *ctx, stein_sim *sim, const stein_event *event)
{
    slips *s = ctx;
    (void)sim;
    if (event->kind == STEIN_EVENT_SLIP) {
        s->first = s->n == 1 ? event->time : s->first;
        s->last = event->time;
        s->n++;
    }
}

/* Slip from a = (mu_s - mu) m g / k beyond the force of slip to -a, with the speed of the belt at
 * both ends; then it sticks until the spring is as long as before. */
static void stick_slip(void)
{
    bench b = bench_start("models/stick_slip.yaml");
    stein_err err;
    slips s = {0, 0.0, 0.0};
    double m = 0.8, k = 120.0, V = 0.05, w = sqrt(k / m), a = 0.75 * 0.5 * 0.14 * m * g / k;
    double right = 2.0 * (M_PI - atan(a * w / V)) / w + 2.0 * a / V;
    if (stein_drive(b.sim, "drive", constant_speed, &V, &err) != STEIN_OK ||
        stein_reset(b.sim, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    stein_on_event(b.sim, count_slips, &s);
    bench_run(&b, 20.0);
    double period = s.n > 2 ? (s.last - s.first) / (s.n - 2) : NAN;
    char reference[64], ours[64];
    validate_row("stick-slip of a block on a belt, period [s]", "closed form",
                 bench_cell(reference, "%.9f s", right), bench_cell(ours, "%.9f s", period),
                 s.n > 20 ? fabs(period - right) : INFINITY, 1e-9);
    bench_end(&b);
}

/* ---- in space ---- */

/* Euler's equations (Landau & Lifshitz, Mechanics, 37): I1 < I2 < I3, L^2 > 2 E I2, w2 = 0 at 0 */
static void free_body(void)
{
    bench b = bench_start("tests/validate/body.yaml");
    const double I1 = 0.010, I2 = 0.020, I3 = 0.025, w1 = 3.0, w3 = 7.0;
    double E2 = I1 * w1 * w1 + I3 * w3 * w3, L2 = I1 * I1 * w1 * w1 + I3 * I3 * w3 * w3;
    double rate = sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3));
    double m = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1)), worst = 0.0;
    for (int i = 1; i <= 400; i++) {
        double t = 0.05 * i, sn, cn, dn;
        bench_run(&b, t);
        jacobi(rate * t, m, &sn, &cn, &dn);
        double w[3] = {bench_read(&b, "wx"), bench_read(&b, "wy"), bench_read(&b, "wz")};
        double right[3] = {w1 * cn, sqrt((E2 * I3 - L2) / (I2 * (I3 - I2))) * sn, w3 * dn};
        worst = fmax(worst, fabs(w[0] - right[0]));
        worst = fmax(worst, fabs(w[1] - right[1]));
        worst = fmax(worst, fabs(w[2] - right[2]));
        for (int k = 0; k < 3; k++) {
            validate_point(VALIDATE_LINE + k, t, w[k]);
        }
    }
    validate_axes("t [s]", "angular velocity [rad/s]");
    char ours[64];
    validate_row("free rigid body, 20 s: angular velocity [rad/s]", "Euler's equations",
                 "Jacobi elliptic functions", bench_cell(ours, "off by %.1e", worst), worst, 1e-6);
    bench_end(&b);
}

/* of body.yaml, in the fixed frame, from points at its axes */
static void angular_momentum(const bench *b, double L[3])
{
    static const double I[3] = {0.010, 0.020, 0.025};
    double x[12], w[3] = {bench_read(b, "wx"), bench_read(b, "wy"), bench_read(b, "wz")};
    stein_points(b->sim, stein_q(b->sim), stein_qd(b->sim), x, NULL, NULL, NULL);
    for (int i = 0; i < 3; i++) {
        L[i] = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            L[i] += (x[3 + 3 * axis + i] - x[i]) * I[axis] * w[axis];
        }
    }
}

/* a body without forces, `fast` times the speed of the file */
static void free_body_for_long(const char *what, double fast, double until, double bar)
{
    bench b = bench_start("tests/validate/body.yaml");
    stein_err err;
    if (stein_set(b.sim, "b.initial.spin.x", 3.0 * fast, &err) != STEIN_OK ||
        stein_set(b.sim, "b.initial.spin.z", 7.0 * fast, &err) != STEIN_OK ||
        stein_reset(b.sim, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    double before[3], L[3], E = bench_energy(&b), worst[2] = {0.0};
    angular_momentum(&b, before);
    double size = sqrt(before[0] * before[0] + before[1] * before[1] + before[2] * before[2]);
    for (int i = 1; i <= 1000; i++) {
        bench_run(&b, 1e-3 * until * i);
        angular_momentum(&b, L);
        double d[3] = {L[0] - before[0], L[1] - before[1], L[2] - before[2]};
        worst[0] = fmax(worst[0], sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / size);
        worst[1] = fmax(worst[1], fabs(bench_energy(&b) / E - 1.0));
    }
    char ours[64];
    validate_row(what, "conservation", "constant", bench_cell(ours, "drift %.1e of it", worst[0]),
                 worst[0], bar);
    validate_row("the same: energy", "conservation", "constant",
                 bench_cell(ours, "drift %.1e of it", worst[1]), worst[1], bar);
    bench_end(&b);
}

/* v0 is 5/7 v0 when it has stopped sliding, in the same direction */
static void rolling_sphere(void)
{
    bench b = bench_start("tests/validate/sphere.yaml");
    bench_run(&b, 3.0);
    double vx = bench_read(&b, "vx"), vy = bench_read(&b, "vy"),
           error = fmax(fabs(vx - 4.0), fabs(vy + 3.0));
    char ours[64];
    validate_row("ball that slides, then rolls: its velocity [m/s]", "closed form, 5/7 v0",
                 "4, -3 m/s", bench_cell(ours, "off by %.1e", error), error, 1e-3);
    bench_end(&b);
}

/* Steady precession: I cos(nutation) p^2 - I3 w3 p + m g l = 0, I about the fixed point */
static void heavy_top(void)
{
    bench b = bench_start("tests/validate/top.yaml");
    const double m = 0.8, l = 0.06, I3 = 1.9e-3, I = 1.1e-3 + m * l * l, w3 = 160.0, nutation = 0.5;
    double c = cos(nutation), square = I3 * w3 * I3 * w3 - 4.0 * I * c * m * g * l;
    double p = 2.0 * m * g * l / (I3 * w3 + sqrt(square)), t = 20.0;
    const double q[3] = {0.0, nutation, 0.0}, qd[3] = {p, 0.0, w3 - p * c};
    stein_err err;
    if (stein_set_state(b.sim, 0.0, q, qd, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    for (int i = 0; i <= 400; i++) {
        bench_run(&b, t * i / 400.0);
        const double *at = stein_q(b.sim);
        validate_point(VALIDATE_LINE, l * sin(at[0]) * sin(at[1]), -l * cos(at[0]) * sin(at[1]));
    }
    validate_axes("x [m]", "y [m] of the centre");
    const double *now = stein_q(b.sim);
    double error = fmax(fabs(now[0] - p * t), fabs(now[1] - nutation));
    char reference[64], ours[64];
    validate_row("heavy top in steady precession, 20 s: angle [rad]", "closed form",
                 bench_cell(reference, "%.9f rad", p * t), bench_cell(ours, "%.9f rad", now[0]),
                 error, 1e-6);
    bench_end(&b);
}

/* z = -(m/c) ln cosh(t sqrt(g c / m)) */
static void drag(void)
{
    bench b = bench_start("tests/validate/drag.yaml");
    double m = 0.145, c = 1.7e-3, t = 12.0, right = -m / c * log(cosh(t * sqrt(g * c / m)));
    run_and_draw(&b, t, "z");
    validate_axes("t [s]", "height [m]");
    double z = bench_read(&b, "z");
    char reference[64], ours[64];
    validate_row("fall with quadratic drag, 12 s [m]", "closed form",
                 bench_cell(reference, "%.9f m", right), bench_cell(ours, "%.9f m", z),
                 fabs(z - right), 1e-9);
    bench_end(&b);
}

/* ---- stiff ---- */

static void stiff_governor(void)
{
    bench b = bench_start("tests/validate/governor.yaml");
    double right[4];
    if (governor_by_hand(right) != GSL_SUCCESS) {
        exit(EXIT_FAILURE);
    }
    bench_run(&b, 10.0);
    const double *q = stein_q(b.sim);
    double error = fmax(fabs(q[1] - right[0]), fabs(q[2] - right[1]));
    char reference[64], ours[64];
    validate_row(
        "stiff governor, 10 s: slider and arm [m, rad]", "IFToMM benchmark A05, equations by hand",
        bench_cell(reference, "%.12f m", right[0]), bench_cell(ours, "%.12f m", q[1]), error, 1e-6);
    bench_end(&b);
}

/* J q'' + c q' + k q = 0 from rest; explicit steps would be 0.3 us */
static void overdamped_joint(void)
{
    bench b = bench_start("tests/validate/oil.yaml");
    double J = 5.5e-6, c = 55.0, k = 50.0, t = 1.0;
    double fast = -0.5 * (c + sqrt(c * c - 4.0 * J * k)) / J, slow = k / J / fast;
    double right = 0.7 * (fast * exp(slow * t) - slow * exp(fast * t)) / (fast - slow);
    bench_run(&b, t);
    double q = bench_read(&b, "q");
    char reference[64], ours[64];
    validate_row("joint in thick oil, 1e7 1/s, after 1 s [rad]", "closed form",
                 bench_cell(reference, "%.12f rad", right), bench_cell(ours, "%.12f rad", q),
                 fabs(q - right), 1e-9);
    bench_end(&b);
}

static void hard_floor(void)
{
    bench b = bench_start("tests/validate/floor.yaml");
    double right = 0.1 * g / 1e11;
    bench_run(&b, 1.0);
    double depth = -bench_read(&b, "z");
    char reference[64], ours[64];
    validate_row("ball at rest on a floor of 1e11 N/m, depth, relative", "statics",
                 bench_cell(reference, "%.9e m", right), bench_cell(ours, "%.9e m", depth),
                 fabs(depth / right - 1.0), 1e-6);
    bench_end(&b);
}

/* ---- the action ---- */

/* What a fact is a share of: escapement height, times, peak force over dx; -1: of no curve */
static int picture_of(const char *fact)
{
    static const struct {
        const char *word;
        int kind;
    } words[] = {{"escapement height", 0}, {"time", 1}, {"flight", 1},
                 {"to impact", 1},         {"peak", 2}, {"head speed", 3}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strstr(fact, words[i].word) != NULL) {
            return words[i].kind;
        }
    }
    return -1;
}

static void draw_strokes(const lab_point *point, int n, int kind)
{
    static const char *const axis[] = {"escapement height [mm]", "escapement, impact [ms]",
                                       "peak force [N]", "speed at impact [m/s]"};
    for (int i = 0; i < n; i++) {
        const lab_stroke *s = &point[i].stroke;
        double y[] = {1e3 * s->escape_height, 1e3 * s->escape_time, s->peak_string_force,
                      s->impact_speed};
        if (point[i].status == STEIN_OK && (kind == 0 || s->impacts > 0)) {
            validate_point(VALIDATE_DOTS, 1e3 * point[i].dx, y[kind]);
        }
        if (point[i].status == STEIN_OK && kind == 1) {
            validate_point(VALIDATE_LINE, 1e3 * point[i].dx, 1e3 * s->impact_time);
        }
    }
    validate_axes("dx [mm]", axis[kind]);
}

static void action(void)
{
    lab_model *model = NULL;
    lab_options options = lab_options_default();
    stein_err err;
    lab_fact fact[LAB_FACTS_MAX];
    int n = lab_study_grid(NULL, 0);
    lab_point *point = calloc((size_t)n, sizeof *point);
    if (point == NULL) {
        exit(EXIT_FAILURE);
    }
    lab_study_grid(point, n);
    if (lab_open(&model, "models/stein1788.yaml", &options, &err) != STEIN_OK ||
        lab_sweep(model, point, n, 2, NULL, NULL, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    int facts = lab_facts(fact, point, n), drawn = -1;
    for (int i = 0; i < facts; i++) {
        int kind = picture_of(fact[i].fact);
        if (kind > drawn) { // facts are in the order of the curves
            draw_strokes(point, n, drawn = kind);
        }
        validate_row(fact[i].fact, "paper on the action of 1788", fact[i].paper, fact[i].simulated,
                     !fact[i].ok, NAN);
    }
    free(point);
    lab_close(model);
}

int main(void)
{
    (void)gsl_set_error_handler_off();
    point_pendulum();
    light_cart();
    double_pendulum();
    elastic_ball();
    hunt_crossley();
    stick_slip();
    free_body();
    // turns: 1300 and 130; errors grow in proportion to them
    free_body_for_long("free rigid body, 1e4 s through all attitudes: angular momentum", 0.1, 1e4,
                       1e-9);
    free_body_for_long("free rigid body, ten times as fast, 100 s: angular momentum", 1.0, 1e2,
                       1e-10);
    rolling_sphere();
    heavy_top();
    drag();
    stiff_governor();
    overdamped_joint();
    hard_floor();
    validate_linkages();
    validate_contacts();
    action();
    return validate_failed() > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
