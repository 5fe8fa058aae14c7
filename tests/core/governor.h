/* SPDX-License-Identifier: GPL-3.0-or-later
 * governor.h - the stiff governor of tests/validate/governor.yaml (IFToMM benchmark A05) by
 * equations written by hand and an integrator of GSL.
 */
#ifndef GOVERNOR_H
#define GOVERNOR_H

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>

static const double governor_start = -3.14159265358979323846 / 6.0; /* of the arms [rad] */

/** Both arms alike. */
typedef struct governor {
    double m, c, axial, across, hub; /* arm: mass, centre, inertias; shaft and slider about z */
    double L;                        /* angular momentum about z */
} governor;

/* inertia about z with the arms at the angle a above the horizontal */
static inline double governor_about_z(const governor *k, double a)
{
    double r = 0.05 + k->c * cos(a);
    return k->hub + 2.0 * (k->m * r * r + k->axial * sin(a) * sin(a) + k->across * cos(a) * cos(a));
}

/* Lagrange's equations of y = {z, a, vz, va}, z of the slider */
static inline int governor_rates(double t, const double y[], double f[], void *ctx)
{
    const governor *k = ctx;
    (void)t;
    double ca = cos(y[1]), sa = sin(y[1]), r = 0.05 + k->c * ca;
    double w = k->L / governor_about_z(k, y[1]);
    double half_slope = 2.0 * (-k->m * r * k->c * sa + (k->axial - k->across) * sa * ca);
    double dx = 0.5 * ca, dz = 0.5 + 0.5 * sa - y[0], length = hypot(dx, dz);
    double rate = (dx * -0.5 * sa * y[3] + dz * (0.5 * ca * y[3] - y[2])) / length;
    double F = (8e5 * (length - 0.5) + 4e4 * rate) / length;
    f[0] = y[2];
    f[1] = y[3];
    f[2] = 2.0 * F * dz / 3.0 - 9.81;
    f[3] = (-F * (dx * -0.5 * sa + dz * 0.5 * ca) - k->m * 9.81 * k->c * ca +
            0.5 * half_slope * w * w) /
           (k->m * k->c * k->c + k->across);
    return GSL_SUCCESS;
}

/** y {z, a, vz, va} after 10 s by Prince & Dormand's order 8 with a tolerance of 1e-13.
 *  @return GSL_SUCCESS, or GSL's code */
static inline int governor_by_hand(double y[4])
{
    const double bar = 0.3, bob = 5.0, m = bar + bob, c = (0.5 * bar + bob) / m;
    governor k = {.m = m,
                  .c = c,
                  .axial = bar * 2e-4 / 12.0,
                  .across = bar * (1.0 + 1e-4) / 12.0 + bar * (c - 0.5) * (c - 0.5) +
                            bob * (1.0 - c) * (1.0 - c),
                  .hub = bar * 2e-4 / 12.0 + 3.0 * 0.02 / 12.0};
    double t = 0.0;
    k.L = governor_about_z(&k, governor_start) * 2.0 * 3.14159265358979323846;
    gsl_odeiv2_system system = {governor_rates, NULL, 4, &k};
    gsl_odeiv2_driver *driver =
        gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, 1e-5, 1e-13, 1e-13);
    y[0] = y[2] = y[3] = 0.0;
    y[1] = governor_start;
    int status = gsl_odeiv2_driver_apply(driver, &t, 10.0, y);
    gsl_odeiv2_driver_free(driver);
    return status;
}

#endif
