/* SPDX-License-Identifier: GPL-3.0-or-later
 * slopes.c - directional and adjoint derivatives, against exact ones of the mechanism.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "importer.h"

static double worst, worst_at_start;

/* d unknown / d known, with a seed that is not 1 */
static double slope_of(unit *u, const char *unknown, const char *known)
{
    const double seed = -2.385;
    double slope = NAN;
    const variable *y = description_find(&u->f->d, unknown), *x = description_find(&u->f->d, known);
    if (y == NULL || x == NULL) {
        claim(0, "no %s or %s", unknown, known);
        return NAN;
    }
    int status = unit_slope(u, y->reference, x->reference, seed, &slope);
    claim(status == OK, "d %s / d %s: %s", unknown, known, u->said);
    return slope / seed;
}

static void expect(unit *u, const char *unknown, const char *known, double expected, double rtol)
{
    double slope = slope_of(u, unknown, known);
    double error = expected != 0.0 ? fabs(slope / expected - 1.0) : fabs(slope);
    double *most = u->starting ? &worst_at_start : &worst;
    *most = fmax(*most, error);
    claim(error <= rtol, "d %s / d %s = %.15g, expected %.15g (off by %.2g)", unknown, known, slope,
          expected, error);
}

/* between two steps, and in Initialization Mode with a parameter that decides about the start */
static void check_pendulum(unit *u)
{
    double m = unit_value(u, "rod.mass"), f = unit_value(u, "rod.pendulum.frequency");
    double g = -unit_value(u, "gravity.z");
    double q = unit_value(u, "rod.q"), w = unit_value(u, "rod.qd");
    double kinetic = unit_value(u, "kinetic"), potential = unit_value(u, "potential");
    claim(fabs(w) > 0.1 && kinetic > 0.0, "it swings");
    expect(u, "kinetic", "rod.pendulum.frequency", -2.0 * kinetic / f, 1e-9);
    expect(u, "kinetic", "rod.mass", kinetic / m, 1e-9);
    expect(u, "potential", "rod.mass", potential / m, 1e-9);
    expect(u, "potential", "gravity.z", -potential / g, 1e-9);
    expect(u, "potential", "rod.centre.z", m * g * cos(q), 1e-9);
    expect(u, "tip_height", "rod.tip.z", cos(q), 1e-9);
    expect(u, "angle", "rod.mass", 0.0, 0.0);
    expect(u, "angle", "push", 0.0, 0.0);
    expect(u, "angle", "angle.sensor.gain", q, 1e-9);
}

/* a driven axis: force = m a + T tanh(v/w) + ... */
static void check_axis(unit *u)
{
    expect(u, "slide_force", "slide_motion.acceleration", unit_value(u, "slide.mass"), 1e-9);
    expect(u, "slide_force", "slide.mass", unit_value(u, "slide_motion.acceleration"), 1e-9);
    expect(u, "slide_position", "slide_motion.position", 1.0, 1e-9);
    expect(u, "slide_speed", "slide_motion.speed", 1.0, 1e-9);
    double v = unit_value(u, "slide_speed"), w = unit_value(u, "slide.coulomb.w");
    expect(u, "slide_force", "slide.coulomb.T", tanh(v / w), 1e-9);
    expect(u, "slide_force", "slide.damping", v, 1e-9);
}

/* contacts: f_n = ((a x^3 + b x^2 + c x) (1 + D x')), and the load on its felt */
static void check_action(unit *u)
{
    stein_sim *sim;
    double x = NAN, rate = NAN, unit_force = unit_value(u, "dip_force");
    claim(stein_sim_create(&sim, u->f->model, NULL, NULL) == STEIN_OK, "the action in C");
    for (int i = 0; i < 9000; i++) {
        stein_step(sim, NULL);
    }
    int dip = stein_find_contact(u->f->model, "dip");
    claim(stein_read(sim, 12) == unit_force, "the same force in C");
    claim(stein_deformation(sim, dip, &x, &rate) == 1, "the key is down");
    double factor = 1.0 + unit_value(u, "dip.normal.D") * rate;
    expect(u, "dip_force", "dip.normal.c", x * factor, 1e-9);
    expect(u, "dip_force", "dip.normal.b", x * x * factor, 1e-9);
    expect(u, "dip_force", "dip.normal.D", rate * unit_force / factor, 1e-9);
    expect(u, "string_distance", "string.height", 1.0, 1e-9);
    expect(u, "string_distance", "finger", 0.0, 0.0);
    expect(u, "key_force", "finger", slope_of(u, "key_force", "finger"), 1e-9);
    stein_sim_destroy(sim);
}

static void check_action_start(unit *u)
{
    expect(u, "string_distance", "string.height", 1.0, 1e-9);
    // against differences of whole equilibria, four points of them
    stein_sim *sim;
    double y[4], h = 1e-5;
    static const double at[] = {-2.0, -1.0, 1.0, 2.0};
    int channel = stein_find_channel(u->f->model, "pawl_angle");
    claim(stein_sim_create(&sim, u->f->model, NULL, NULL) == STEIN_OK, "the action in C");
    for (int i = 0; i < 4; i++) {
        stein_set(sim, "pawl.stop_shift", at[i] * h, NULL);
        claim(stein_reset(sim, NULL) == STEIN_OK, "an equilibrium");
        y[i] = stein_read(sim, channel);
    }
    stein_sim_destroy(sim);
    double expected = (y[0] - 8.0 * y[1] + 8.0 * y[2] - y[3]) / (12.0 * h);
    claim(fabs(expected) > 1.0, "the pawl follows its stop");
    expect(u, "pawl_angle", "pawl.stop_shift", expected, 1e-9);
}

/* rows of the Jacobian are what columns are */
static void check_adjoint(unit *u)
{
    unsigned unknown[3], known[3];
    double seed[3] = {0.7, -1.3, 2.1}, row[3], expected[3] = {0.0, 0.0, 0.0};
    int ny = 0, nx = 0;
    for (int i = 0; i < u->f->d.n; i++) {
        const variable *v = &u->f->d.v[i];
        if (ny < 3 && strcmp(v->causality, "output") == 0) {
            unknown[ny++] = v->reference;
        } else if (nx < 3 && strcmp(v->variability, "tunable") == 0) {
            known[nx++] = v->reference;
        }
    }
    for (int k = 0; k < nx; k++) {
        for (int i = 0; i < ny; i++) {
            double slope;
            claim(unit_slope(u, unknown[i], known[k], 1.0, &slope) == OK, "a slope");
            expected[k] += slope * seed[i];
        }
    }
    __typeof__(&fmi3GetAdjointDerivative) adjoint =
        (__typeof__(adjoint))fmu_function(u->f, "fmi3GetAdjointDerivative");
    claim(adjoint(u->c, unknown, (size_t)ny, known, (size_t)nx, seed, (size_t)ny, row,
                  (size_t)nx) == fmi3OK,
          "adjoint derivatives");
    for (int k = 0; k < nx; k++) {
        claim(fabs(row[k] - expected[k]) <= 1e-12 * fabs(expected[k]), "are the same numbers");
    }
}

void check_slopes(const fmu *f)
{
    unit u, still;
    double t = 0.0, y[OUTPUTS], again[OUTPUTS], slope;
    int pendulum = strcmp(f->d.identifier, "pendulum") == 0;
    int axis = strcmp(f->d.identifier, "emps") == 0;
    int action = strcmp(f->d.identifier, "stein1788") == 0;
    if (f->model == NULL || (!pendulum && !axis && !action)) {
        return;
    }
    claim(unit_new(&u, f, "one", f->d.token, 1) == OK && unit_enter(&u, 0.0, -1.0) == OK,
          "an instance");
    u.starting = 1;
    if (pendulum) {
        expect(&u, "angle", "rod.initial.position", 1.0, 1e-9);
    } else if (action) {
        check_action_start(&u);
    } else {
        unit_put(&u, "slide.damping", 3.0);
        unit_put(&u, "slide.coulomb.T", 2.0);
        unit_put(&u, "slide.coulomb.w", 0.1);
        unit_put(&u, "slide_motion.speed", 0.05);
        unit_put(&u, "slide_motion.acceleration", 0.7);
    }
    u.starting = 0;
    claim(unit_exit(&u) == OK && unit_run(&u, &t, 1e-3, 90) == OK, "to 90 ms");
    int n = unit_outputs(&u, y);
    if (pendulum) {
        check_pendulum(&u);
    } else if (axis) {
        check_axis(&u);
    } else {
        check_action(&u);
    }
    if (f->version == 3) {
        check_adjoint(&u);
    }
    claim(unit_outputs(&u, again) == n && memcmp(y, again, sizeof *y * (size_t)n) == 0,
          "derivatives change nothing");
    if (!axis) {
        double s = 0.0;
        claim(unit_start(&still, f) == OK && unit_run(&still, &s, 1e-3, 100) == OK &&
                  unit_run(&u, &t, 1e-3, 10) == OK,
              "on to 100 ms");
        unit_outputs(&u, y);
        unit_outputs(&still, again);
        claim(memcmp(y, again, sizeof *y * (size_t)n) == 0, "nor what comes after");
        unit_free(&still);
    }
    claim(unit_slope(&u, 1, 1, 1.0, &slope) == FAILED &&
              strstr(u.said, "expected an input") != NULL,
          "an output is no known: %s", u.said);
    unit_free(&u);
    printf("note: derivatives off by %.1e at most, through the start by %.1e\n", worst,
           worst_at_start);
}
