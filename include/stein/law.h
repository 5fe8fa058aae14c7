/* SPDX-License-Identifier: MIT
 * law.h - the force laws of the runtime, as plain functions of plain numbers.
 *
 * Both laws come from Hirschkorn's action model as used for the Stein action: Hunt & Crossley
 * (1975) with a cubic polynomial in place of the power, and the smooth Coulomb friction of Cull &
 * Tucker (1999). A law is a block of doubles, in the order of its enum in model.h.
 */
#ifndef STEIN_LAW_H
#define STEIN_LAW_H

#ifdef __cplusplus
extern "C" {
#endif

/** Normal force of a contact,
 *
 *      f_n = [ (a x^3 + b x^2 + c x) (x / 0.1 mm)^p + F0 ] (1 + D xdot) (1 + h tanh(xdot / 1 cm/s))
 *
 *  clamped at 0: never adhesive by itself. Neutral values p = h = F0 = 0 leave the cubic with
 *  damping. With a pull-off force F over a range r, -4 F u (1 - u) where u = -x/r is in 0..1.
 *  @param law   a STEIN_NORMAL block: a [N/m^3], b [N/m^2], c [N/m], D [s/m], p, h, F0 [N], gap
 * (not used here: it belongs to the geometry), F [N], r [m]
 *  @param x     deformation [m], > 0 in contact
 *  @param xdot  its rate [m/s], > 0 approaching
 *  @return force [N], > 0 pushing apart */
double stein_normal_force(const double *law, double x, double xdot);

/** Friction coefficient mu(v) = A (tanh u + B1 u / (1 + B2 u^4)), u = v / vt; odd in v.
 *  The second term peaks at u = (1/(3 B2))^(1/4) with height 3/4 B1 u: the static surplus.
 *  The same shape is a joint's friction torque with A in N m (N) and vt in rad/s (m/s).
 *  @param law  a STEIN_FRICTION block: A [-, N m or N], vt [m/s or rad/s, > 0], B1 [-], B2 [-]
 *  @param v    sliding speed [m/s or rad/s]
 *  @return mu with the sign of v; the force is -mu f_n */
double stein_friction(const double *law, double v);

/** Friction that sticks (`stick: yes`) has no tanh. A sliding place has mu = A against the sliding,
 * at any speed. A place at rest holds up to
 *
 *      mu_s = A [ 1 + 3/4 B1 (3 B2)^(-1/4) ],
 *
 *  the peak of the smooth law above. vt is not used; without B2 there is no
 * surplus.
 *  @param law  as of stein_friction  @return mu_s, in units of A */
double stein_stick_limit(const double *law);

/** Force or torque in a joint at q, qd, all that acts there by itself:
 *
 *      - k (q - q0) - k3 (q - q0)^3                  spring, hardening
 *      - b (1 + s tanh(qd/w)) qd - k2 |qd| qd        viscous (s: by direction), drag
 *      + T - A_mu(qd)                                preload, friction
 *      - T_c (1 + s_c tanh(qd/w)) tanh(qd/w)         plain Coulomb friction (s_c: by direction)
 *      - k_b (|q| - g) sign q  beyond |q| > g        backlash
 *
 *  @param law  a STEIN_JOINT block; units as in SI for the joint's coordinate [rad or m]
 *  @return [N m or N] along the coordinate */
double stein_joint_force(const double *law, double q, double qd);

/** Tension of a link, > 0 pulling its ends together:
 *
 *      f = [ k (l - length) + b ldot ] (1 - slack where that pulls)
 *                                      (1 - off (1 + tanh((z - z_off)/range)) / 2)
 *
 *  With slack 1 it only pushes. With off 1 its force vanishes when its first end has risen past
 * z_off, as a jack's does at its button.
 *  @param law     a STEIN_LINK block
 *  @param length  l [m]   @param rate  ldot [m/s]   @param z  of the first end [m]
 *  @return [N] */
double stein_link_force(const double *law, double length, double rate, double z);

/** Slopes of the curve through the points of a table. At an inner point: the slope of the parabola
 * through the point and its neighbours. At both ends: the slope of the straight line to the next
 * point.
 *
 *      s_i = (h_i d_(i-1) + h_(i-1) d_i) / (h_(i-1) + h_i),     h_i = x_(i+1) - x_i,
 *                                                               d_i = (y_(i+1) - y_i) / h_i
 *
 *  The slopes are linear in y, and so is the curve: the table of a sum is the sum of the tables.
 *  @param n      points, at least 2
 *  @param at     x [n], increasing; where they do not increase the curve is level
 *  @param value  y [n]
 *  @param slope  s [n] out */
void stein_table_slopes(int n, const double *at, const double *value, double *slope);

/** The curve: between two points the cubic with their values and slopes, so there are no kinks.
 *  Beyond the first and the last point it is level.  @param x  any number  @return y at x */
double stein_table_value(int n, const double *at, const double *value, const double *slope,
                         double x);

#ifdef __cplusplus
}
#endif
#endif
