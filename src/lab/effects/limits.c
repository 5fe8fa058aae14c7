/* SPDX-License-Identifier: GPL-3.0-or-later
 * limits.c - the largest plausible size of an effect at a place, from the mechanism itself.
 *
 *      T = max(sqrt(M_jj m) g, |k theta0|)      weight and spring of a joint, m the carried mass
 *      E = M_jj w^2 / (2 Q)                     mean torque that gave it its speed w over Q
 *      length = sqrt(M_jj / m)                  its radius of gyration
 *
 * M is the mass matrix at the initial state, w and Q the largest speed and travel of one run.
 * For the piano action these agree with a maker's judgement within a factor of a few.
 * They only scale the first secant and the weak prior of an amount.
 *
 * A kind that is not listed here has no size: NAN, which lab__candidates_at refuses. (Sizes of
 * parts, links and the load are in candidates.c and bind.c, with the numbers beside them.)
 */
#include <math.h>
#include <string.h>

#include "added_parts.h"

static int is(const char *kind, const char *name)
{
    return strcmp(kind, name) == 0;
}

double lab__joint_limit(const char *kind, const lab__scales *s, int j)
{
    double T = s->weight[j], E = s->energy[j], w = s->speed[j], Q = s->travel[j];
    // a fall without air is faster than one that drag balances: up to 3 times
    return is(kind, "viscous_friction")                          ? 1.5 * E / w
           : is(kind, "quadratic_drag")                          ? 5.0 * E / (w * w)
           : is(kind, "coulomb_friction") || is(kind, "preload") ? 0.3 * T
           : is(kind, "stiction_peak")                           ? 30.0
           : is(kind, "viscous_asymmetry")                       ? 0.8
           : is(kind, "coulomb_asymmetry")                       ? 0.8
           : is(kind, "hardening_spring")                        ? T / (Q * Q * Q)
           : is(kind, "joint_stiffness") || is(kind, "backlash") ? T / Q
                                                                 : NAN;
}

double lab__body_limit(const char *kind, const lab__scales *s, int j, double value)
{
    return is(kind, "centre")    ? 0.05 * s->length[j]
           : is(kind, "inertia") ? 0.5 * value
           : is(kind, "mass")    ? 0.15 * value
                                 : NAN;
}

double lab__contact_limit(const char *kind, const lab__scales *s, double value)
{
    return is(kind, "contact_exponent")     ? 0.7
           : is(kind, "contact_hysteresis") ? 0.8
           : is(kind, "contact_stiffness")  ? 1.2
           : is(kind, "contact_damping")    ? (value > 0.0 ? 1.2 : 0.5)
           : is(kind, "contact_friction")   ? (value > 0.0 ? 1.2 : 0.5)
           : is(kind, "adhesion")           ? 0.3 * s->heaviness
           : is(kind, "contact_gap")        ? 3e-4
                                            : NAN;
}

double lab__channel_limit(const char *kind, const lab__scales *s, int channel)
{
    double range = s->range[channel];
    return is(kind, "sensor_gain")           ? 0.1
           : is(kind, "sensor_offset")       ? 0.05 * range
           : is(kind, "sensor_nonlinearity") ? 0.2 / range
           : is(kind, "camera_tilt")         ? 0.15
           : is(kind, "sensor_delay")        ? 3e-3
                                             : NAN;
}

double lab__input_limit(const char *kind)
{
    return is(kind, "input_gain") ? 0.2 : is(kind, "input_delay") ? 5e-3 : NAN;
}
