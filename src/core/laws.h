/* SPDX-License-Identifier: MIT
 * laws.h - the laws of law.h where every evaluation needs them: inline. What a law leaves at its
 * neutral value is not worked out.
 */
#ifndef STEIN_LAWS_H
#define STEIN_LAWS_H

#include "elementary.h"
#include "stein/law.h"
#include "stein/model.h"

static const double stein__felt_unit = 1e-4;  /* m, where the exponent is neutral */
static const double stein__turn_speed = 0.01; /* m/s, loading turns into unloading within it */

static inline double stein__normal(const double *law, double x, double xdot)
{
    if (!(x > 0.0)) {
        double u = law[STEIN_NORMAL_RANGE] > 0.0 ? -x / law[STEIN_NORMAL_RANGE] : 1.0;
        return u < 1.0 ? -4.0 * law[STEIN_NORMAL_ADHESION] * u * (1.0 - u) : 0.0;
    }
    double f = ((law[STEIN_NORMAL_A] * x + law[STEIN_NORMAL_B]) * x + law[STEIN_NORMAL_C]) * x;
    if (law[STEIN_NORMAL_EXPONENT] != 0.0) {
        f *= stein__power(x / stein__felt_unit, law[STEIN_NORMAL_EXPONENT]);
    }
    f = (f + law[STEIN_NORMAL_PRELOAD]) * (1.0 + law[STEIN_NORMAL_D] * xdot);
    if (law[STEIN_NORMAL_HYSTERESIS] != 0.0) {
        f *= 1.0 + law[STEIN_NORMAL_HYSTERESIS] * stein__tanh(xdot / stein__turn_speed);
    }
    return f > 0.0 ? f : 0.0;
}

/* 1 / vt, 0 where there is no friction */
static inline double stein__inverse_vt(const double *law)
{
    return law[STEIN_FRICTION_A] != 0.0 ? 1.0 / law[STEIN_FRICTION_VT] : 0.0;
}

/* mu at u = v / vt, whose tanh is known */
static inline double stein__mu(const double *law, double u, double tanh_u)
{
    double mu = tanh_u;
    if (law[STEIN_FRICTION_B1] != 0.0) {
        double u2 = u * u;
        mu += law[STEIN_FRICTION_B1] * u / (1.0 + law[STEIN_FRICTION_B2] * u2 * u2);
    }
    return law[STEIN_FRICTION_A] * mu;
}

/* friction: mu(qd) of the friction in the joint */
static inline double stein__joint(const double *law, double q, double qd, double friction)
{
    double x = q - law[STEIN_JOINT_Q0];
    double b = law[STEIN_JOINT_B], gap = law[STEIN_JOINT_STOP_GAP];
    double f = law[STEIN_JOINT_PRELOAD] - (law[STEIN_JOINT_K] + law[STEIN_JOINT_K3] * x * x) * x;
    if (law[STEIN_JOINT_ASYMMETRY] != 0.0) {
        b *= 1.0 + law[STEIN_JOINT_ASYMMETRY] * stein__tanh(qd / law[STEIN_JOINT_DRY_SPEED]);
    }
    f -= (b + law[STEIN_JOINT_DRAG] * fabs(qd)) * qd;
    if (law[STEIN_JOINT_DRY] != 0.0) {
        f -= law[STEIN_JOINT_DRY] * stein__tanh(qd / law[STEIN_JOINT_DRY_SPEED]);
    }
    f -= friction;
    if (law[STEIN_JOINT_STOP_K] != 0.0 && fabs(q) > gap) {
        f -= law[STEIN_JOINT_STOP_K] * (fabs(q) - gap) * (q > 0.0 ? 1.0 : -1.0);
    }
    return f;
}

/* can the joint's law be anything but 0? */
static inline int stein__joint_acts(const double *law)
{
    return law[STEIN_JOINT_PRELOAD] != 0.0 || law[STEIN_JOINT_K] != 0.0 ||
           law[STEIN_JOINT_K3] != 0.0 || law[STEIN_JOINT_B] != 0.0 ||
           law[STEIN_JOINT_DRAG] != 0.0 || law[STEIN_JOINT_DRY] != 0.0 ||
           law[STEIN_JOINT_STOP_K] != 0.0 || law[STEIN_JOINT_FRICTION + STEIN_FRICTION_A] != 0.0;
}

#endif
