/* SPDX-License-Identifier: MIT
 * law.h - the force laws of the runtime, as plain functions of plain numbers.
 *
 * Both laws are those of Hirschkorn's action model as used for the Stein action: Hunt & Crossley
 * (1975) with a cubic polynomial in place of the power, and Cull & Tucker's (1999) smooth Coulomb
 * friction. A law is a block of four doubles, in the order of the enums of model.h.
 */
#ifndef STEIN_LAW_H
#define STEIN_LAW_H

#ifdef __cplusplus
extern "C" {
#endif

/** Normal force f_n = (a x^3 + b x^2 + c x)(1 + D xdot), never adhesive (clamped at 0).
 *  @param law   a [N/m^3], b [N/m^2], c [N/m], D [s/m]
 *  @param x     deformation [m], > 0 in contact
 *  @param xdot  its rate [m/s], > 0 approaching
 *  @return force [N], >= 0; 0 for x <= 0 */
double stein_normal_force(const double law[4], double x, double xdot);

/** Friction coefficient mu(v) = A (tanh u + B1 u / (1 + B2 u^4)), u = v / vt; odd in v.
 *  The second term peaks at u = (1/(3 B2))^(1/4) with height 3/4 B1 u: the static surplus.
 *  The same shape is a joint's friction torque with A in N m (N) and vt in rad/s (m/s).
 *  @param law  A [-, N m or N], vt [m/s or rad/s, > 0], B1 [-], B2 [-]
 *  @param v    sliding speed [m/s or rad/s]
 *  @return mu with the sign of v; the force is -mu f_n */
double stein_friction(const double law[4], double v);

#ifdef __cplusplus
}
#endif
#endif
