/* SPDX-License-Identifier: MIT
 * law.c - normal and friction laws for other programs. The equations stand in law.h.
 */
#include "laws.h"

double stein_normal_force(const double *law, double x, double xdot)
{
    return stein__normal(law, stein__normal_parts(law), x, xdot);
}

double stein_friction(const double *law, double v)
{
    if (law[STEIN_FRICTION_A] == 0.0) {
        return 0.0;
    }
    double u = v / law[STEIN_FRICTION_VT];
    return stein__mu(law, stein__friction_parts(law), u, stein__tanh(u));
}

double stein_stick_limit(const double *law)
{
    return stein__stick_limit(law);
}

double stein_joint_force(const double *law, double q, double qd)
{
    double friction = stein_friction(law + STEIN_JOINT_FRICTION, qd);
    return stein__joint(law, stein__joint_parts(law), q, qd, friction);
}

double stein_link_force(const double *law, double length, double rate, double z)
{
    return stein__tension(law, length, rate, z);
}
