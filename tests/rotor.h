/* SPDX-License-Identifier: GPL-3.0-or-later
 * rotor.h - a wheel on a spiral spring, let go from an angle, for tests of the diagnosis: strokes
 * take milliseconds, and at one angle its drags look alike.
 */
#ifndef ROTOR_H
#define ROTOR_H

static const char rotor_text[] = "mechanism: rotor\n"
                                 "bodies:\n"
                                 "  wheel:\n"
                                 "    joint: R y\n"
                                 "    mass: 0.4 kg\n"
                                 "    inertia: {yy: 2.1e-3 kg m^2 +- 1 %}\n"
                                 "    spring: {k: 0.83 N m/rad +- 1 %}\n"
                                 "    initial: {position: 0.2 rad}\n"
                                 "outputs:\n"
                                 "  angle: {joint: wheel, read: position}\n"
                                 "simulation: {dt: 0.2 ms, until: 0.7 s}\n";

#endif
