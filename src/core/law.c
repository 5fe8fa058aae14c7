/* SPDX-License-Identifier: MIT
 * law.c - normal and friction laws for whoever is outside. The equations stand in law.h.
 */
#include "laws.h"

double stein_normal_force(const double *law, double x, double xdot)
{
    return stein__normal(law, x, xdot);
}

double stein_friction(const double law[4], double v)
{
    return stein__mu(law, 1.0 / law[STEIN_FRICTION_VT], v);
}

double stein_joint_force(const double *law, double q, double qd)
{
    return stein__joint(law, 1.0 / law[STEIN_JOINT_FRICTION + STEIN_FRICTION_VT], q, qd);
}
