/* SPDX-License-Identifier: GPL-3.0-or-later
 * linkages.c - mechanisms with closed loops: benchmarks of IFToMM (Gonzalez et al. 2006) and
 * problems of the Bari test set for initial value problem solvers (release 2.4). Not among them is
 * its wheelset, which rolls on curved surfaces.
 */
#include <gsl/gsl_math.h>
#include <math.h>
#include <stddef.h>

#include "bench.h"
#include "validate.h"

static const double g = 9.81; /* of all files [m/s^2] */

/** A published value at the end. */
typedef struct value {
    const char *channel;
    double right;
} value;

static double worst_of(const bench *b, const value *v, int n)
{
    double worst = 0.0;
    for (int i = 0; i < n; i++) {
        worst = fmax(worst, fabs(bench_read(b, v[i].channel) / v[i].right - 1.0));
    }
    return worst;
}

static void andrews(void)
{
    static const value at[] = {
        {"beta", 15.81077119629904},    {"Theta", -15.75637105984298},
        {"gamma", 0.04082224013073101}, {"Phi", -0.5347301163226948},
        {"delta", 0.5244099658805304},  {"Omega", 0.5347301163226948},
        {"epsilon", 1.048080741042263},
    };
    bench b = bench_start("models/andrews.yaml");
    validate_axes("t [ms]", "three of its angles [rad]");
    for (int i = 0; i <= 300; i++) {
        bench_run(&b, 1e-4 * i);
        validate_point(VALIDATE_LINE, 0.1 * i, fmod(bench_read(&b, "beta"), 2.0 * M_PI));
        validate_point(VALIDATE_SECOND, 0.1 * i, bench_read(&b, "gamma"));
        validate_point(VALIDATE_THIRD, 0.1 * i, bench_read(&b, "epsilon"));
    }
    double worst = worst_of(&b, at, 7);
    char ours[64];
    validate_row("Andrews' squeezing mechanism, 30 ms: seven angles, relative",
                 "IFToMM A03, Bari test set", "published to 16 digits",
                 bench_cell(ours, "off by %.1e", worst), worst, 1e-8);
    bench_end(&b);
}

/* phi with sin phi = 0.1 sin 10 t */
static void wave(void *ctx, double t, double u[3])
{
    double s = 0.1 * sin(10.0 * t), v = cos(10.0 * t), a = -10.0 * sin(10.0 * t);
    double c = sqrt(1.0 - s * s);
    (void)ctx;
    u[0] = asin(s);
    u[1] = v / c;
    u[2] = a / c + s * v * v / (c * c * c);
}

static void car_axis(void)
{
    static const value at[] = {{"xl", 0.0493455784275402809122},
                               {"yl", 0.496989460230171153861},
                               {"xr", 1.04174252488542151681},
                               {"yr", 0.373911027265361256927}};
    bench b = bench_start("tests/validate/car_axis.yaml");
    stein_err err;
    if (stein_drive(b.sim, "wave", wave, NULL, &err) != STEIN_OK ||
        stein_reset(b.sim, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    validate_axes("t [s]", "heights [m]");
    for (int i = 0; i <= 300; i++) {
        bench_run(&b, 0.01 * i);
        validate_point(VALIDATE_LINE, 0.01 * i, bench_read(&b, "yl"));
        validate_point(VALIDATE_SECOND, 0.01 * i, bench_read(&b, "yr"));
    }
    double worst = worst_of(&b, at, 4);
    char ours[64];
    validate_row("car axis, 3 s: positions of its ends, relative", "Bari test set",
                 "published to 19 digits", bench_cell(ours, "off by %.1e", worst), worst, 1e-8);
    bench_end(&b);
}

/* Bars of N four-bars stay parallel: qd^2 = 1 + 2 w (1 - cos a), a from upright,
 * w = g (N + (N + 1)/2) / (N + (N + 1)/3). */
static double inverse_speed(double a, void *ctx)
{
    (void)ctx;
    return 1.0 / sqrt(1.0 + 2.0 * g * 3.5 / 3.0 * (1.0 - cos(a)));
}

static void four_bars(void)
{
    bench b = bench_start("tests/validate/four_bars.yaml");
    double turn = 2.0 * bench_integral(inverse_speed, NULL, 0.0, M_PI);
    int turns = (int)(10.0 / turn);
    validate_axes("t [s]", "angle of the first bar [rad]");
    for (int i = 0; i <= 400; i++) {
        double t = turns * turn * i / 400.0;
        bench_run(&b, t);
        validate_point(VALIDATE_LINE, t, bench_read(&b, "angle"));
    }
    double right = M_PI_2 - 2.0 * M_PI * turns, angle = bench_read(&b, "angle");
    char reference[64], ours[64];
    validate_row("two four-bars, 10 s through their singular positions: angle [rad]", "IFToMM A02",
                 bench_cell(reference, "%.9f rad, a pendulum", right),
                 bench_cell(ours, "%.9f rad", angle), fabs(angle - right), 1e-6);
    bench_end(&b);
}

static void bricard(void)
{
    bench b = bench_start("tests/validate/bricard.yaml");
    double e = bench_energy(&b), worst = 0.0, most = 0.0, kinetic, potential;
    validate_axes("x [m]", "y [m] of a corner");
    for (int i = 0; i <= 500; i++) {
        bench_run(&b, 0.02 * i);
        stein_energy(b.sim, stein_q(b.sim), stein_qd(b.sim), &kinetic, &potential);
        worst = fmax(worst, fabs(kinetic + potential - e));
        most = fmax(most, kinetic);
        validate_point(VALIDATE_LINE, bench_read(&b, "x"), bench_read(&b, "y"));
    }
    char ours[64];
    validate_row("Bricard's mechanism, 10 s, one condition too many: energy", "IFToMM A04",
                 "constant", bench_cell(ours, "drift %.1e of the kinetic energy", worst / most),
                 worst / most, 1e-6);
    bench_end(&b);
}

/* 150 rad/s */
static void crank_turns(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 150.0 * t;
    u[1] = 150.0;
    u[2] = 0.0;
}

/* what the slides of crank.yaml move per unit of the published shapes */
static double parameter(const bench *b, const char *name)
{
    double number = NAN;
    stein_err err;
    if (stein_get(b->sim, name, &number, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    return number;
}

/* phi2, x3 and q1 .. q4 of the problem at 0.1 s */
static void flexible_crank(void)
{
    static const double phi2 = -3.311734987910881e-01, x3 = 1.697373326718410e-01,
                        q[] = {1.893192460247178e-04, 2.375751865617931e-05, -5.323907988763734e-06,
                               -8.363283141616840e-06};
    bench b = bench_start("tests/validate/crank.yaml");
    stein_err err;
    if (stein_drive(b.sim, "turn", crank_turns, NULL, &err) != STEIN_OK ||
        stein_reset(b.sim, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    double bow = parameter(&b, "n.bow"), in = parameter(&b, "n.in_bow");
    validate_axes("t [ms]", "bending [um]");
    for (int i = 0; i <= 500; i++) {
        bench_run(&b, 2e-4 * i);
        validate_point(VALIDATE_LINE, 0.2 * i, 1e6 * bench_read(&b, "bow") / bow);
        validate_point(VALIDATE_SECOND, 0.2 * i, 1e6 * bench_read(&b, "in") / in);
    }
    double q4 = bench_read(&b, "q4");
    double ours[] = {bench_read(&b, "bow") / bow, bench_read(&b, "in") / in,
                     bench_read(&b, "bubble") / parameter(&b, "n.bubble") + 0.5 * q4, q4};
    double rigid = fmax(fabs(bench_read(&b, "phi2") / phi2 - 1.0),
                        fabs(bench_read(&b, "x3") / x3 - 1.0)),
           elastic = 0.0;
    for (int i = 0; i < 4; i++) {
        elastic = fmax(elastic, fabs(ours[i] / q[i] - 1.0));
    }
    char cell[64];
    validate_row("slider crank with an elastic rod, 0.1 s: rod's angle and block, relative",
                 "Bari test set", "published to 16 digits", bench_cell(cell, "off by %.1e", rigid),
                 rigid, 1e-8);
    validate_row("the same: the rod's four elastic coordinates, relative", "Bari test set",
                 "published to 16 digits", bench_cell(cell, "off by %.1e", elastic), elastic, 1e-4);
    bench_end(&b);
}

void validate_linkages(void)
{
    andrews();
    car_axis();
    flexible_crank();
    four_bars();
    bricard();
}
