/* SPDX-License-Identifier: GPL-3.0-or-later
 * contacts.c - bodies that slide, stick, bounce and hang, with solutions in closed form.
 */
#include <gsl/gsl_math.h>
#include <math.h>
#include <stdio.h>

#include "bench.h"
#include "validate.h"

static const double g = 9.81; /* of all files [m/s^2] */

/* Jellett's integral: L . (R z - a e) is constant whatever the friction is, e being the axis and a
 * how far below the middle the centre of mass lies. Upside down the top spins about z alone. */
static double jellett(const bench *b)
{
    const double I = 2.994285714285714e-6, I3 = 3.2e-6, R = 0.02, a = 0.006;
    double axial = I3 * bench_read(b, "wz");
    double across =
        I * (bench_read(b, "wx") * bench_read(b, "zx") + bench_read(b, "wy") * bench_read(b, "zy"));
    return R * (across + axial * bench_read(b, "zz")) - a * axial;
}

static void tippe_top(void)
{
    bench b = bench_start("tests/validate/tippe_top.yaml");
    double before = jellett(&b), worst = 0.0;
    for (int i = 0; i <= 800; i++) {
        double t = 0.01 * i;
        bench_run(&b, t);
        worst = fmax(worst, fabs(jellett(&b) / before - 1.0));
        validate_point(VALIDATE_LINE, t, 180.0 / M_PI * acos(bench_read(&b, "zz")));
    }
    validate_axes("t [s]", "tilt [deg]");
    char ours[64];
    int over = bench_read(&b, "zz") < -0.99;
    validate_row(
        "tippe top turns over in 8 s: Jellett's integral, relative", "conservation",
        "constant, upside down",
        bench_cell(ours, over ? "drift %.1e, upside down" : "drift %.1e, not turned", worst),
        over ? worst : INFINITY, 1e-9);
    bench_end(&b);
}

/* While it slides, friction takes mu times the normal impulse; where it grips, the contact rests
 * and nothing acts any more. The normal impulse of a bounce with v is m (2 v + g T), T its time. */
static void spinning_ball(void)
{
    bench b = bench_start("tests/validate/spinning_ball.yaml");
    const double m = 0.05, k = 1e6, R = 0.02, mu = 0.2, down = 2.0, w = sqrt(k / m);
    double T = 2.0 / w * (M_PI - atan(down * w / g)), flight = 2.0 * down / g;
    double v = 5.0, spin = 0.0, error = 0.0; // spin: of the surface, forwards
    for (int bounce = 0; bounce < 2; bounce++) {
        double most = mu * (2.0 * down + g * T), grips = (v - spin) / 3.5;
        double change = fmin(most, grips), start = bounce * (T + flight);
        v -= change;
        spin += 2.5 * change;
        for (int i = 0; i <= 300; i++) {
            bench_run(&b, start + (T + 0.5 * flight) * i / 300.0);
            validate_point(VALIDATE_LINE, bench_read(&b, "x"), bench_read(&b, "z"));
        }
        error = fmax(error, fabs(bench_read(&b, "v") - v));
        error = fmax(error, fabs(R * bench_read(&b, "w") - spin));
    }
    validate_axes("x [m]", "z [m]");
    error = fmax(error, fabs(bench_read(&b, "z") - R - 0.5 * down * down / g));
    char reference[64], ours[64];
    validate_row("spinning ball slides in one bounce, grips in the next: speeds [m/s]",
                 "closed form", bench_cell(reference, "%.9f m/s", v),
                 bench_cell(ours, "%.9f m/s", bench_read(&b, "v")), error, 1e-8);
    bench_end(&b);
}

/* Turning points are 2 F/k nearer each time; it stays at the first one within F/k. */
static void dry_block(void)
{
    bench b = bench_start("tests/validate/dry_block.yaml");
    const double F = 2.0, k = 100.0, m = 1.0;
    double right = 0.35, last = 0.0;
    while (fabs(right) > F / k) {
        right = right > 0.0 ? 2.0 * F / k - right : -2.0 * F / k - right;
        last += M_PI * sqrt(m / k);
    }
    for (int i = 0; i <= 500; i++) {
        bench_run(&b, 4.0 * i / 500.0);
        validate_point(VALIDATE_LINE, 4.0 * i / 500.0, 1e3 * bench_read(&b, "x"));
    }
    validate_axes("t [s]", "x [mm]");
    char reference[64], ours[64];
    double x = bench_read(&b, "x");
    validate_row("block on a spring with dry friction: where it stays [m]", "closed form",
                 bench_cell(reference, "%.9f m", right), bench_cell(ours, "%.9f m", x),
                 last < 4.0 ? fabs(x - right) : INFINITY, 1e-9);
    bench_end(&b);
}

/* Of links of weight w, V(k) the vertical force above the k-th one, tan = (V(k) + V(k+1)) / 2H. */
static void hanging_chain(void)
{
    enum { LINKS = 8 };
    bench b = bench_start("tests/validate/chain.yaml");
    const double w = 0.05 * g, length = 0.1, span = 0.5;
    double low = 1e-3, high = 1e3, worst = 0.0, sum = 0.0;
    for (int i = 0; i < 200; i++) {
        double H = sqrt(low * high), reach = 0.0;
        for (int k = 0; k < LINKS; k++) {
            reach += length * cos(atan((0.5 * LINKS - k - 0.5) * w / H));
        }
        *(reach < span ? &low : &high) = H;
    }
    double x = 0.0, z = 0.0;
    validate_point(VALIDATE_LINE, x, z);
    for (int k = 0; k < LINKS; k++) {
        char name[8];
        snprintf(name, sizeof name, "q%d", k + 1);
        sum += bench_read(&b, name); // from the one before, downwards
        worst = fmax(worst, fabs(sum - atan((0.5 * LINKS - k - 0.5) * w / low)));
        x += length * cos(sum);
        z -= length * sin(sum);
        validate_point(VALIDATE_LINE, x, z);
    }
    validate_axes("x [m]", "z [m]");
    char reference[64], ours[64];
    double pull = fabs(bench_read(&b, "pull"));
    validate_row("chain of eight links at rest: its slopes [rad]", "statics", "closed form",
                 bench_cell(ours, "off by %.1e", worst), worst, 1e-9);
    validate_row("the same: horizontal force at its end [N]", "statics",
                 bench_cell(reference, "%.9f N", low), bench_cell(ours, "%.9f N", pull),
                 fabs(pull - low), 1e-8);
    bench_end(&b);
}

/* Of a rod that tips over about its lower end, the moment at s is m g L/4 sin q (s/L) (1 - s/L)^2,
 * largest at a third of the length. */
static void chimney(void)
{
    bench b = bench_start("tests/validate/chimney.yaml");
    const double m = 3000.0, L = 30.0;
    double worst = 0.0;
    for (int i = 0; i <= 100; i++) {
        bench_run(&b, 0.05 * i);
        double right = m * g * L / 27.0 * sin(bench_read(&b, "q"));
        worst = fmax(worst, fabs(fabs(bench_read(&b, "bending")) / right - 1.0));
        validate_point(VALIDATE_LINE, 0.05 * i, 1e-3 * right);
    }
    validate_axes("t [s]", "bending moment [kN m]");
    char ours[64];
    validate_row("falling chimney, 5 s: bending moment at a third of its height, relative",
                 "closed form, m g L sin q / 27", "m g L sin q / 27",
                 bench_cell(ours, "off by %.1e", worst), worst, 1e-9);
    bench_end(&b);
}

void validate_contacts(void)
{
    tippe_top();
    spinning_ball();
    dry_block();
    hanging_chain();
    chimney();
}
