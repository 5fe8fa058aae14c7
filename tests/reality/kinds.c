/* SPDX-License-Identifier: GPL-3.0-or-later
 * kinds.c - the table of hidden effects. Names of kinds and places are a contract with whoever has
 * to find them; formulas are in touch.c, hidden.c, effect.c and observe.c.
 *
 * `limit` is what is physically thinkable (by place where the bodies differ: key, hammer, pawl);
 * a size is an amount of at most 1 times the limit. Entries with drawn = 0 are made only when
 * asked for; the last three are in no table of effects.
 */
#include "reality.h"

#define BODIES "key hammer pawl"
#define PADS "rest dip loops string stop load notch"
#define MARKERS "string_distance key_dip"

// clang-format off: one entry a line or two
const effect_kind effect_kinds[] = {
    {"viscous_friction", "missing_effect", BODIES, 0, 1, "b", "N m s/rad", {2e-2, 1e-4, 1e-3},
     {{0}}, "torque -b qd"},
    {"coulomb_friction", "missing_effect", BODIES, 0, 1, "T", "N m", {3e-2, 7e-4, 3e-3},
     {{"w0", "rad/s", 0.02, 0.1}}, "torque -T tanh(qd/w0)"},
    {"stiction_peak", "missing_effect", BODIES, 0, 1, "B1", "1", {30.0, 8.0, 30.0},
     {{"B2", "1", 1e-4, 1.0}}, "joint friction A (tanh u + B1 u/(1 + B2 u^4)), u = qd/vt"},
    {"quadratic_drag", "missing_effect", BODIES, 0, 1, "k", "N m s^2/rad^2", {3e-2, 1e-5, 3e-4},
     {{0}}, "torque -k |qd| qd"},
    {"preload", "missing_effect", BODIES, 1, 1, "T", "N m", {2e-2, 5e-4, 3e-3},
     {{0}}, "torque T"},
    {"joint_stiffness", "missing_effect", BODIES, 0, 1, "k", "N m/rad", {0.6, 2e-3, 2e-2},
     {{0}}, "torque -k q, at rest as drawn"},
    {"hardening_spring", "missing_effect", BODIES, 1, 1, "k3", "N m/rad^3", {300.0, 1e-2, 6e-2},
     {{0}}, "torque -k3 (q - theta0)^3"},
    {"backlash", "missing_effect", BODIES, 0, 1, "k", "N m/rad", {2.0, 1e-2, 0.3},
     {{"gap", "", 0.2, 0.6}}, "torque -k (|q| - gap) sign(q) beyond +-gap"},
    {"mass", "wrong_parameter", BODIES, 1, 1, "mass", "kg", {0.1, 0.1, 0.2},
     {{0}}, "mass of the body"},
    {"centre", "wrong_parameter", BODIES, 1, 1, "x", "m", {5e-3, 3e-3, 2e-3},
     {{0}}, "centre of mass along the body"},
    {"inertia", "wrong_parameter", BODIES, 1, 1, "inertia", "kg m^2", {0.3, 0.3, 0.5},
     {{0}}, "moment of inertia about the centre"},
    {"elastic_hinge", "missing_effect", "key hammer", 0, 1, "compliance", "rad/(N m)",
     {1e-2, 1.0, 0.0}, {{"damping_ratio", "1", 0.02, 0.1}},
     "the link bends at one place: torque k dphi + d dphid, k = 1/compliance"},
    {"axis_translation", "missing_effect", "key", 0, 1, "compliance", "m/N", {5e-5, 0.0, 0.0},
     {{"damping_ratio", "1", 0.05, 0.2}, {"seat_to_lift", "1", 0.0, 1.0}},
     "the pin of the key rises by u: force -k u - d ud, k = 1/compliance"},
    {"contact_stiffness", "wrong_parameter", PADS, 1, 1, "log_scale", "1", {1.2, 0.0, 0.0},
     {{0}}, "normal force times scale = exp(log_scale)"},
    {"contact_exponent", "missing_effect", PADS, 1, 1, "p", "1", {0.7, 0.0, 0.0},
     {{0}}, "normal force times (x/0.1 mm)^p"},
    {"contact_damping", "wrong_parameter", PADS, 1, 1, "log_scale", "1", {1.5, 0.0, 0.0},
     {{0}}, "D times exp(log_scale)"},
    {"contact_hysteresis", "missing_effect", PADS, 0, 1, "h", "1", {0.8, 0.0, 0.0},
     {{0}}, "normal force times 1 + h tanh(xdot/0.01 m/s)"},
    {"contact_friction", "wrong_parameter", PADS, 1, 1, "log_scale", "1", {1.0, 0.0, 0.0},
     {{0}}, "mu times exp(log_scale)"},
    {"adhesion", "missing_effect", "rest dip loops string load notch", 0, 1, "F", "N",
     {0.5, 0.0, 0.0}, {{"range", "m", 3e-5, 2e-4}}, "pull 4 F u (1 - u), u = -x/range, 0 < u < 1"},
    {"contact_gap", "wrong_parameter", "rest dip loops string stop notch", 1, 1, "gap", "m",
     {3e-4, 0.0, 0.0}, {{0}}, "the surface lies deeper by gap"},
    {"compliant_partner", "missing_effect", "string", 0, 1, "compliance", "m/N",
     {5e-5, 0.0, 0.0}, {{"mass", "kg", 1e-4, 5e-4}, {"damping_ratio", "1", 0.02, 0.1}},
     "the string is a mass on a spring with damper, k = 1/compliance"},
    {"string_damper", "missing_effect", "key", 0, 1, "F0", "N", {1.0, 0.0, 0.0},
     {{"x0", "m", 1e-3, 4e-3}, {"k_to_F0", "1/m", 50.0, 400.0}},
     "from dip x0 on the front is pushed up by F0 + k (dip - x0), k = k_to_F0 F0"},
    {"wire", "missing_effect", "key", 0, 1, "k", "N/m", {60.0, 0.0, 0.0},
     {{"length", "m", 0.03, 0.08}, {"stretch", "1", 0.0, 0.05}},
     "spring from the front up to the frame, stretched by a share of its length at rest"},
    {"unknown_load", "input", "load", 1, 1, "error", "1", {0.2, 0.0, 0.0},
     {{0}}, "mass of the load is (1 + error) times what is told"},
    {"input_gain", "input", "finger key_motion", 1, 1, "error", "1", {0.2, 0.0, 0.0},
     {{0}}, "the true input is (1 + error) times the recorded one"},
    {"input_delay", "input", "finger key_motion", 0, 1, "delay", "s", {5e-3, 0.0, 0.0},
     {{0}}, "the true input comes later than recorded"},
    {"sensor_gain", "sensor", MARKERS, 1, 1, "error", "1", {0.05, 0.0, 0.0},
     {{0}}, "reading y (1 + error)"},
    {"sensor_offset", "sensor", MARKERS, 1, 0, "offset", "m", {1e-3, 0.0, 0.0},
     {{0}}, "reading y + offset (cannot be told from the marker offset)"},
    {"sensor_delay", "sensor", MARKERS, 0, 1, "delay", "s", {3e-3, 0.0, 0.0},
     {{0}}, "reading y(t - delay)"},
    {"time_base", "sensor", "clock", 1, 1, "error", "1", {0.03, 0.0, 0.0},
     {{0}}, "the frame at recorded time t was taken at (1 + error) t"},
    {"sensor_nonlinearity", "sensor", MARKERS, 1, 1, "k2", "1/m", {10.0, 0.0, 0.0},
     {{0}}, "reading y + k2 (y - y at rest)^2"},
    {"camera_tilt", "sensor", MARKERS, 1, 1, "tilt", "rad", {0.15, 0.0, 0.0},
     {{0}}, "reading y + tilt (x - x at rest), x horizontal position of the marker"},
    {"wrong_parameter", "wrong_parameter",
     "pawl.corner.x pawl.corner.z pawl.notch_angle pawl.spring.k pawl.spring.theta0 pawl.at.x "
     "string.height key.kapsel.x key.kapsel.z key.front.x hammer.head.x hammer.beak.x "
     "hammer.shank.x notch.beak.tilt dip.line.z loops.line.z dip.normal.c loops.normal.c "
     "string.normal.c notch.normal.c notch.friction.A hammer.friction.A key.friction.A",
     1, 1, "change", "", {1.0, 0.0, 0.0}, {{0}}, "a number of the file is another one"},
    /* laws that are in no table */
    {"magnetic_pull", "unknown_effect", "hammer", 0, 0, "C", "N m^2", {4e-5, 0.0, 0.0},
     {{"x", "m", -0.02, 0.01}, {"z", "m", 0.09, 0.12}},
     "the head is drawn to a point of the frame by C r/(r^2 + (5 mm)^2)^(3/2)"},
    {"two_stage_felt", "unknown_effect", "dip", 0, 0, "k2", "N/m", {2e4, 0.0, 0.0},
     {{"time", "s", 2e-3, 2e-2}}, "dip felt: + k2 (x - s), ds/dt = (x - s)/time"},
    {"warming_friction", "unknown_effect", "key", 0, 0, "T", "N m", {4e-2, 0.0, 0.0},
     {{"w0", "rad/s", 0.02, 0.1}, {"turn", "rad", 0.01, 0.04}, {"time", "s", 0.1, 1.0}},
     "torque -T tanh(qd/w0) exp(-H), dH/dt = |qd|/turn - H/time"},
    {NULL, NULL, NULL, 0, 0, NULL, NULL, {0.0, 0.0, 0.0}, {{0}}, NULL},
};
// clang-format on
