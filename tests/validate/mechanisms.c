/* SPDX-License-Identifier: GPL-3.0-or-later
 * mechanisms.c - mechanisms with solutions in closed form or by quadrature, and the published facts
 * of the action of 1788. Every mechanism is run as its file says, at default settings.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <gsl/gsl_sf_ellint.h>
#include <gsl/gsl_sf_elljac.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "stein/lab.h"
#include "stein/stein.h"
#include "validate.h"

static const double g = 9.81; /* of all files [m/s^2] */

/** A mechanism in its initial state. */
typedef struct bench {
    lab_model *model;
    stein_sim *sim;
} bench;

static void stop(const stein_err *err)
{
    fprintf(stderr, "validate: %s\n", err->msg);
    exit(EXIT_FAILURE);
}

static bench start(const char *file)
{
    bench b = {NULL, NULL};
    stein_err err;
    lab_options options = lab_options_default();
    if (lab_open(&b.model, file, &options, &err) != STEIN_OK ||
        lab_sim(b.model, NULL, &b.sim, &err) != STEIN_OK) {
        stop(&err);
    }
    return b;
}

static void end(bench *b)
{
    stein_sim_destroy(b->sim);
    lab_close(b->model);
}

static void run(const bench *b, double t)
{
    stein_err err;
    if (stein_run(b->sim, t, &err) != STEIN_OK) {
        stop(&err);
    }
}

static double read(const bench *b, const char *channel)
{
    double value = NAN;
    stein_err err;
    if (stein_read_name(b->sim, channel, &value, &err) != STEIN_OK) {
        stop(&err);
    }
    return value;
}

static double energy(const bench *b)
{
    double kinetic, potential;
    stein_energy(b->sim, stein_q(b->sim), stein_qd(b->sim), &kinetic, &potential);
    return kinetic + potential;
}

static double integral(double (*f)(double, void *), void *ctx, double from, double to)
{
    gsl_integration_workspace *room = gsl_integration_workspace_alloc(2000);
    gsl_function function = {f, ctx};
    double value, error;
    (void)gsl_integration_qags(&function, from, to, 0.0, 1e-12, 2000, room, &value, &error);
    gsl_integration_workspace_free(room);
    return value;
}

/* text of a number in a cell */
static const char *cell(char *text, const char *format, double value)
{
    snprintf(text, 64, format, value);
    return text;
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
    bench b = start("tests/validate/pendulum.yaml");
    double worst = 0.0, m = 0.5, sn, cn, dn;
    for (int i = 1; i <= 4000; i++) {
        double t = 0.5 * i;
        run(&b, t);
        jacobi(sqrt(g) * t, m, &sn, &cn, &dn);
        double half = asin(sqrt(m) * cn / dn);
        worst = fmax(worst, fabs(read(&b, "x") - sin(2.0 * half)));
        worst = fmax(worst, fabs(read(&b, "z") + cos(2.0 * half)));
    }
    char ours[64];
    validate_row("simple pendulum from 90 deg, 2000 s: position at 4000 times [m]",
                 "IFToMM benchmark A01", "Jacobi elliptic functions",
                 cell(ours, "off by %.1e", worst), worst, 1e-3);
    end(&b);
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
    bench b = start("tests/validate/cart.yaml");
    double at = 0.4, swings = 10.0;
    double quarter = integral(cart_time, NULL, 0.0, M_PI_2 - 1e-9);
    double down = quarter - integral(cart_time, NULL, 0.0, asin(at / start_angle));
    run(&b, swings * 4.0 * quarter + down);
    double q = read(&b, "q"), x = read(&b, "x");
    double right = (sin(start_angle) - sin(at)) / (1.0 + cart_mass);
    double error = fmax(fabs(q - at), fabs(x - right));
    char ours[64];
    validate_row("light cart-pole, M = 1e-6 kg, after 10 swings: angle and place [rad, m]",
                 "quadrature of the energy", "0.4 rad", cell(ours, "%.9f rad", q), error, 1e-5);
    end(&b);
}

static void double_pendulum(void)
{
    bench b = start("models/double_pendulum.yaml");
    double e = energy(&b), worst = 0.0, most = 0.0, kinetic, potential;
    for (int i = 1; i <= 1000; i++) {
        run(&b, 0.1 * i);
        stein_energy(b.sim, stein_q(b.sim), stein_qd(b.sim), &kinetic, &potential);
        worst = fmax(worst, fabs(kinetic + potential - e));
        most = fmax(most, kinetic);
    }
    char ours[64];
    validate_row("double pendulum, 100 s: energy", "conservation", "constant",
                 cell(ours, "drift %.1e of the kinetic energy", worst / most), worst / most, 1e-9);
    end(&b);
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
    bench b = start("tests/validate/ball.yaml");
    cubic k = {3e10, 2e7, 4e4, 0.35, sqrt(2.0 * g * 0.42), 0.0};
    double low = 0.0, high = 0.01;
    for (int i = 0; i < 200; i++) {
        k.deepest = 0.5 * (low + high);
        *(speed2(&k, k.deepest) > 0.0 ? &low : &high) = k.deepest;
    }
    k.deepest = low;
    int bounces = 30;
    double fall = k.speed / g, contact = 2.0 * integral(contact_time, &k, 0.0, M_PI_2 - 1e-7);
    double rise = 0.3 * fall; // in the flight behind the last bounce
    run(&b, fall + bounces * contact + (bounces - 1) * 2.0 * fall + rise);
    double right = k.speed * rise - 0.5 * g * rise * rise, z = read(&b, "z");
    char reference[64], ours[64];
    validate_row("elastic ball on a cubic contact, height after 30 bounces [m]",
                 "quadrature of the contact", cell(reference, "%.9f m", right),
                 cell(ours, "%.9f m", z), fabs(z - right), 1e-5);
    end(&b);
}

/* Hunt & Crossley 1975, without other forces: v/D - ln(1 + D v)/D^2 is the same before and after,
 * with the sign of v. */
static void hunt_crossley(void)
{
    bench b = start("tests/validate/hunt_crossley.yaml");
    double D = 0.47, in = 1.3, low = 0.0, high = in;
    double same = in / D - log1p(D * in) / (D * D);
    for (int i = 0; i < 200; i++) {
        double out = 0.5 * (low + high), there = -out / D - log1p(-D * out) / (D * D);
        *(there < same ? &low : &high) = out;
    }
    run(&b, 0.1);
    double v = read(&b, "v");
    char reference[64], ours[64];
    validate_row("Hunt-Crossley contact, speed of rebound [m/s]",
                 "Hunt & Crossley 1975, closed form", cell(reference, "%.12f m/s", low),
                 cell(ours, "%.12f m/s", v), fabs(v - low), 1e-9);
    end(&b);
}

/* ---- in space ---- */

/* Euler's equations (Landau & Lifshitz, Mechanics, 37): I1 < I2 < I3, L^2 > 2 E I2, w2 = 0 at 0 */
static void free_body(void)
{
    bench b = start("tests/validate/body.yaml");
    const double I1 = 0.010, I2 = 0.020, I3 = 0.025, w1 = 3.0, w3 = 7.0;
    double E2 = I1 * w1 * w1 + I3 * w3 * w3, L2 = I1 * I1 * w1 * w1 + I3 * I3 * w3 * w3;
    double rate = sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3));
    double m = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1)), worst = 0.0;
    for (int i = 1; i <= 400; i++) {
        double t = 0.05 * i, sn, cn, dn;
        run(&b, t);
        jacobi(rate * t, m, &sn, &cn, &dn);
        double w[3] = {read(&b, "wx"), read(&b, "wy"), read(&b, "wz")};
        double right[3] = {w1 * cn, sqrt((E2 * I3 - L2) / (I2 * (I3 - I2))) * sn, w3 * dn};
        worst = fmax(worst, fabs(w[0] - right[0]));
        worst = fmax(worst, fabs(w[1] - right[1]));
        worst = fmax(worst, fabs(w[2] - right[2]));
    }
    char ours[64];
    validate_row("free rigid body, 20 s: angular velocity [rad/s]", "Euler's equations",
                 "Jacobi elliptic functions", cell(ours, "off by %.1e", worst), worst, 1e-6);
    end(&b);
}

/* of body.yaml, in the fixed frame, from points at its axes */
static void angular_momentum(const bench *b, double L[3])
{
    static const double I[3] = {0.010, 0.020, 0.025};
    double x[12], w[3] = {read(b, "wx"), read(b, "wy"), read(b, "wz")};
    stein_points(b->sim, stein_q(b->sim), stein_qd(b->sim), x, NULL, NULL, NULL);
    for (int i = 0; i < 3; i++) {
        L[i] = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            L[i] += (x[3 + 3 * axis + i] - x[i]) * I[axis] * w[axis];
        }
    }
}

/* at a tenth of the speed: a thousand turns */
static void free_body_for_long(void)
{
    bench b = start("tests/validate/body.yaml");
    stein_err err;
    if (stein_set(b.sim, "b.initial.spin.x", 0.3, &err) != STEIN_OK ||
        stein_set(b.sim, "b.initial.spin.z", 0.7, &err) != STEIN_OK ||
        stein_reset(b.sim, &err) != STEIN_OK) {
        stop(&err);
    }
    double before[3], L[3], E = energy(&b), worst[2] = {0.0};
    angular_momentum(&b, before);
    double size = sqrt(before[0] * before[0] + before[1] * before[1] + before[2] * before[2]);
    for (int i = 1; i <= 1000; i++) {
        run(&b, 10.0 * i);
        angular_momentum(&b, L);
        double d[3] = {L[0] - before[0], L[1] - before[1], L[2] - before[2]};
        worst[0] = fmax(worst[0], sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / size);
        worst[1] = fmax(worst[1], fabs(energy(&b) / E - 1.0));
    }
    char ours[64];
    validate_row("free rigid body, 1e4 s through all attitudes: angular momentum", "conservation",
                 "constant", cell(ours, "drift %.1e of it", worst[0]), worst[0], 1e-9);
    validate_row("the same: energy", "conservation", "constant",
                 cell(ours, "drift %.1e of it", worst[1]), worst[1], 1e-9);
    end(&b);
}

/* v0 is 5/7 v0 when it has stopped sliding, in the same direction */
static void rolling_sphere(void)
{
    bench b = start("tests/validate/sphere.yaml");
    run(&b, 3.0);
    double vx = read(&b, "vx"), vy = read(&b, "vy"), error = fmax(fabs(vx - 4.0), fabs(vy + 3.0));
    char ours[64];
    validate_row("ball that slides, then rolls: its velocity [m/s]", "closed form, 5/7 v0",
                 "4, -3 m/s", cell(ours, "off by %.1e", error), error, 1e-3);
    end(&b);
}

/* Steady precession: I cos(nutation) p^2 - I3 w3 p + m g l = 0, I about the fixed point */
static void heavy_top(void)
{
    bench b = start("tests/validate/top.yaml");
    const double m = 0.8, l = 0.06, I3 = 1.9e-3, I = 1.1e-3 + m * l * l, w3 = 160.0, nutation = 0.5;
    double c = cos(nutation), square = I3 * w3 * I3 * w3 - 4.0 * I * c * m * g * l;
    double p = 2.0 * m * g * l / (I3 * w3 + sqrt(square)), t = 20.0;
    const double q[3] = {0.0, nutation, 0.0}, qd[3] = {p, 0.0, w3 - p * c};
    stein_err err;
    if (stein_set_state(b.sim, 0.0, q, qd, &err) != STEIN_OK) {
        stop(&err);
    }
    run(&b, t);
    const double *now = stein_q(b.sim);
    double error = fmax(fabs(now[0] - p * t), fabs(now[1] - nutation));
    char reference[64], ours[64];
    validate_row("heavy top in steady precession, 20 s: angle [rad]", "closed form",
                 cell(reference, "%.9f rad", p * t), cell(ours, "%.9f rad", now[0]), error, 1e-6);
    end(&b);
}

/* z = -(m/c) ln cosh(t sqrt(g c / m)) */
static void drag(void)
{
    bench b = start("tests/validate/drag.yaml");
    double m = 0.145, c = 1.7e-3, t = 12.0, right = -m / c * log(cosh(t * sqrt(g * c / m)));
    run(&b, t);
    double z = read(&b, "z");
    char reference[64], ours[64];
    validate_row("fall with quadratic drag, 12 s [m]", "closed form",
                 cell(reference, "%.9f m", right), cell(ours, "%.9f m", z), fabs(z - right), 1e-9);
    end(&b);
}

/* ---- the action ---- */

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
        stop(&err);
    }
    int facts = lab_facts(fact, point, n);
    for (int i = 0; i < facts; i++) {
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
    free_body();
    free_body_for_long();
    rolling_sphere();
    heavy_top();
    drag();
    action();
    return validate_failed() > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
