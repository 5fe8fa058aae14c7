/* SPDX-License-Identifier: MIT
 * laws.h - the laws of law.h where every evaluation needs them: inline, for any number of lanes.
 * What a law leaves at its neutral value is not worked out: its parts say what there is.
 * Included by: this folder.
 */
#ifndef STEIN_LAWS_H
#define STEIN_LAWS_H

#include "functions.h"
#include "real.h"
#if STEIN_LANES > 0
#include "elementary.h"
#endif
#include "stein/law.h"
#include "stein/model.h"

#if STEIN_LANES == 0
static inline real stein__tanh(real u)
{
    double t = stein__tanh_of(__real__ u);
    return with_rate(t, (1.0 - t * t) * __imag__ u);
}

/* x^y for x > 0 */
static inline real stein__raised(real x, real y)
{
    double a = __real__ x, b = __real__ y, power = stein__power(a, b);
    return with_rate(power, power * (__imag__ y * stein__log_of(a) + b * __imag__ x / a));
}

/* The depth of a contact that is on, where it begins or ends by rounding only. A step to that place
 * is derived on the side of the contact, where the force has a slope. */
static inline real stein__within(const real *law, real x)
{
    double range = __real__ law[STEIN_NORMAL_RANGE], past = -range - __real__ x;
    if (past >= 0.0 && past < 1e-9) {
        return with_rate(range > 0.0 ? -range * (1.0 - 1e-12) : 0x1p-600, __imag__ x);
    }
    return x;
}
#endif

static const double stein__felt_unit = 1e-4;  /* m, where the exponent is neutral */
static const double stein__turn_speed = 0.01; /* m/s, loading turns into unloading within it */

/* Parts of a law beyond the usual ones, as it has them in any lane: asked once for a set of
 * parameters (stein__normal_parts and so on), not in every evaluation. */
enum {
    STEIN__ADHESIVE = 1,
    STEIN__POWERED = 2,
    STEIN__LOSSY = 4,
    STEIN__RUBBING = 8,
    STEIN__BUMPED = 16,
    STEIN__PRELOADED = 32,
    STEIN__SPRUNG = 64,
    STEIN__DAMPED = 128,
    STEIN__LOPSIDED = 256,
    STEIN__DRY = 512,
    STEIN__STOPPED = 1024
};

static inline int stein__part(int part, real number)
{
    return any(differ(number, 0.0)) ? part : 0;
}

static inline int stein__normal_parts(const real *law)
{
    return stein__part(STEIN__ADHESIVE, law[STEIN_NORMAL_RANGE]) |
           stein__part(STEIN__POWERED, law[STEIN_NORMAL_EXPONENT]) |
           stein__part(STEIN__LOSSY, law[STEIN_NORMAL_HYSTERESIS]);
}

static inline int stein__friction_parts(const real *law)
{
    return stein__part(STEIN__RUBBING, law[STEIN_FRICTION_A]) |
           stein__part(STEIN__BUMPED, law[STEIN_FRICTION_B1]);
}

static inline int stein__joint_parts(const real *law)
{
    return stein__part(STEIN__PRELOADED, law[STEIN_JOINT_PRELOAD]) |
           stein__part(STEIN__SPRUNG, law[STEIN_JOINT_K]) |
           stein__part(STEIN__SPRUNG, law[STEIN_JOINT_K3]) |
           stein__part(STEIN__DAMPED, law[STEIN_JOINT_B]) |
           stein__part(STEIN__DAMPED, law[STEIN_JOINT_DRAG]) |
           stein__part(STEIN__LOPSIDED, law[STEIN_JOINT_ASYMMETRY]) |
           stein__part(STEIN__DRY, law[STEIN_JOINT_DRY]) |
           stein__part(STEIN__STOPPED, law[STEIN_JOINT_STOP_K]) |
           stein__friction_parts(law + STEIN_JOINT_FRICTION);
}

/* what pulls at a depth x <= 0 */
static inline real stein__adhesion(const real *law, real x)
{
    real u = sel(more(law[STEIN_NORMAL_RANGE], 0.0), over(-x, law[STEIN_NORMAL_RANGE]), same(1.0));
    return sel(less(u, 1.0), -4.0 * law[STEIN_NORMAL_ADHESION] * u * (1.0 - u), same(0.0));
}

static inline real stein__normal(const real *law, int parts, real x, real xdot)
{
    mask deep = more(x, 0.0);
    real apart = same(0.0);
    if (parts & STEIN__ADHESIVE && !every(deep)) {
        apart = stein__adhesion(law, x);
    }
    if (!any(deep)) {
        return apart;
    }
    real f = ((law[STEIN_NORMAL_A] * x + law[STEIN_NORMAL_B]) * x + law[STEIN_NORMAL_C]) * x;
    if (parts & STEIN__POWERED) {
        real units = sel(deep, x, same(stein__felt_unit)) / stein__felt_unit;
        real power = stein__raised(units, law[STEIN_NORMAL_EXPONENT]);
        f = sel(differ(law[STEIN_NORMAL_EXPONENT], 0.0), f * power, f);
    }
    f = (f + law[STEIN_NORMAL_PRELOAD]) * (1.0 + law[STEIN_NORMAL_D] * xdot);
    if (parts & STEIN__LOSSY) {
        real loss = 1.0 + law[STEIN_NORMAL_HYSTERESIS] * stein__tanh(xdot / stein__turn_speed);
        f = sel(differ(law[STEIN_NORMAL_HYSTERESIS], 0.0), f * loss, f);
    }
    return sel(deep, sel(more(f, 0.0), f, same(0.0)), apart);
}

/* 1 / vt, 0 where there is no friction */
static inline real stein__inverse_vt(const real *law)
{
    return sel(differ(law[STEIN_FRICTION_A], 0.0), over(same(1.0), law[STEIN_FRICTION_VT]),
               same(0.0));
}

/* mu at u = v / vt, whose tanh is known */
static inline real stein__mu(const real *law, int parts, real u, real tanh_u)
{
    real mu = tanh_u;
    if (parts & STEIN__BUMPED) {
        real u2 = u * u;
        real bump = over(law[STEIN_FRICTION_B1] * u, 1.0 + law[STEIN_FRICTION_B2] * u2 * u2);
        mu = sel(differ(law[STEIN_FRICTION_B1], 0.0), mu + bump, mu);
    }
    return law[STEIN_FRICTION_A] * mu;
}

#if STEIN_LANES == 1
/* the largest mu with which friction that sticks holds */
static inline double stein__stick_limit(const double *law)
{
    double b1 = law[STEIN_FRICTION_B1], b2 = law[STEIN_FRICTION_B2];
    double surplus = b1 > 0.0 && b2 > 0.0 ? 0.75 * b1 / sqrt(sqrt(3.0 * b2)) : 0.0;
    return law[STEIN_FRICTION_A] * (1.0 + surplus);
}
#endif

/* friction: mu(qd) of the friction in the joint */
static inline real stein__joint(const real *law, int parts, real q, real qd, real friction)
{
    real f = law[STEIN_JOINT_PRELOAD];
    if (parts & STEIN__SPRUNG) {
        real x = q - law[STEIN_JOINT_Q0];
        f -= (law[STEIN_JOINT_K] + law[STEIN_JOINT_K3] * x * x) * x;
    }
    if (parts & STEIN__DAMPED) {
        real b = law[STEIN_JOINT_B];
        if (parts & STEIN__LOPSIDED) {
            real grip = stein__tanh(over(qd, law[STEIN_JOINT_DRY_SPEED]));
            mask lopsided = differ(law[STEIN_JOINT_ASYMMETRY], 0.0);
            b = sel(lopsided, b * (1.0 + law[STEIN_JOINT_ASYMMETRY] * grip), b);
        }
        f -= (b + law[STEIN_JOINT_DRAG] * magnitude(qd)) * qd;
    }
    if (parts & STEIN__DRY) {
        real grip = stein__tanh(over(qd, law[STEIN_JOINT_DRY_SPEED]));
        real level = law[STEIN_JOINT_DRY] * (1.0 + law[STEIN_JOINT_DRY_ASYMMETRY] * grip);
        f = sel(differ(law[STEIN_JOINT_DRY], 0.0), f - level * grip, f);
    }
    f -= friction;
    if (parts & STEIN__STOPPED) {
        real gap = law[STEIN_JOINT_STOP_GAP];
        mask stopped = both(differ(law[STEIN_JOINT_STOP_K], 0.0), more(magnitude(q), gap));
        real side = sel(more(q, 0.0), same(1.0), same(-1.0));
        f = sel(stopped, f - law[STEIN_JOINT_STOP_K] * (magnitude(q) - gap) * side, f);
    }
    return f;
}

/* stops of a joint */
static inline real stein__limit(const real *law, real q, real qd)
{
    real above = q - law[STEIN_LIMIT_TO], below = law[STEIN_LIMIT_FROM] - q;
    mask up = more(above, 0.0);
    real x = sel(up, above, below), rate = sel(up, qd, -qd);
    real f = law[STEIN_LIMIT_K] * x * (1.0 + law[STEIN_LIMIT_D] * rate);
    f = sel(both(more(x, 0.0), more(f, 0.0)), f, same(0.0));
    return sel(up, -f, f);
}

/* tension of a link of a length, which grows at a rate; z of its first end */
static inline real stein__tension(const real *law, real length, real rate, real z)
{
    real f = law[STEIN_LINK_K] * (length - law[STEIN_LINK_LENGTH]) + law[STEIN_LINK_B] * rate;
    mask slack = both(differ(law[STEIN_LINK_SLACK], 0.0), more(f, 0.0));
    if (any(slack)) {
        f = sel(slack, f * (1.0 - law[STEIN_LINK_SLACK]), f);
    }
    mask trips = differ(law[STEIN_LINK_OFF], 0.0);
    if (any(trips)) {
        real past = 1.0 + stein__tanh(over(z - law[STEIN_LINK_OFF_Z], law[STEIN_LINK_OFF_RANGE]));
        f = sel(trips, f * (1.0 - 0.5 * law[STEIN_LINK_OFF] * past), f);
    }
    return f;
}

/* can the law of a joint with these parts be anything but 0? */
static inline int stein__joint_acts(int parts)
{
    return (parts & ~(STEIN__BUMPED | STEIN__LOPSIDED)) != 0; // which only shape others
}

#endif
