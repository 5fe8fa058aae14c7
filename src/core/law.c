/* SPDX-License-Identifier: MIT
 * law.c - normal and friction laws. The equations stand in law.h.
 */
#include <math.h>

#include "stein/law.h"
#include "stein/model.h"

double stein_normal_force(const double law[4], double x, double xdot)
{
    if (!(x > 0.0)) {
        return 0.0;
    }
    double fit = ((law[STEIN_NORMAL_A] * x + law[STEIN_NORMAL_B]) * x + law[STEIN_NORMAL_C]) * x;
    double f = fit * (1.0 + law[STEIN_NORMAL_D] * xdot);
    return f > 0.0 ? f : 0.0;
}

double stein_friction(const double law[4], double v)
{
    double u = v / law[STEIN_FRICTION_VT];
    double u2 = u * u;
    double surplus = law[STEIN_FRICTION_B1] * u / (1.0 + law[STEIN_FRICTION_B2] * u2 * u2);
    return law[STEIN_FRICTION_A] * (tanh(u) + surplus);
}
