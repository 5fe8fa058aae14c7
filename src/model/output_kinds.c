/* SPDX-License-Identifier: MIT
 * output_kinds.c - the kinds of outputs, one row each: element, word of `read:`, name in C, units
 * where its joint turns and where it slides, description, and what it follows from.
 *
 * The value itself is computed in src/core/channel.c.
 */
#include "mechanism.h"
#include "stein/model.h"

/* a loop has reactions, too; all else is of one kind of element */
static const mech_output_kind kinds[] = {
    [STEIN_READ_TIME] = {MECH_NO_THING, MECH_NO_THING, "time", "time", "s", "s", "time",
                         MECH_FROM_NOTHING},
    [STEIN_READ_POSITION] = {MECH_A_JOINT, MECH_NO_THING, "position", "position", "rad", "m",
                             "coordinate of joint ", MECH_FROM_PLACES},
    [STEIN_READ_SPEED] = {MECH_A_JOINT, MECH_NO_THING, "speed", "speed", "rad/s", "m/s",
                          "speed of joint ", MECH_FROM_SPEEDS},
    [STEIN_READ_ACCELERATION] = {MECH_A_JOINT, MECH_NO_THING, "acceleration", "acceleration",
                                 "rad/s^2", "m/s^2", "acceleration of joint ", MECH_FROM_FORCES},
    [STEIN_READ_X] = {MECH_A_POINT, MECH_NO_THING, "x", "x", "m", "m", "x of point ",
                      MECH_FROM_PLACES},
    [STEIN_READ_Y] = {MECH_A_POINT, MECH_NO_THING, "y", "y", "m", "m", "y of point ",
                      MECH_FROM_PLACES},
    [STEIN_READ_Z] = {MECH_A_POINT, MECH_NO_THING, "z", "z", "m", "m", "z of point ",
                      MECH_FROM_PLACES},
    [STEIN_READ_VX] = {MECH_A_POINT, MECH_NO_THING, "vx", "vx", "m/s", "m/s",
                       "velocity along x of point ", MECH_FROM_SPEEDS},
    [STEIN_READ_VY] = {MECH_A_POINT, MECH_NO_THING, "vy", "vy", "m/s", "m/s",
                       "velocity along y of point ", MECH_FROM_SPEEDS},
    [STEIN_READ_VZ] = {MECH_A_POINT, MECH_NO_THING, "vz", "vz", "m/s", "m/s",
                       "velocity along z of point ", MECH_FROM_SPEEDS},
    [STEIN_READ_GAP] = {MECH_A_CONTACT, MECH_NO_THING, "gap", "gap", "m", "m", "gap of contact ",
                        MECH_FROM_PLACES},
    [STEIN_READ_FORCE] = {MECH_A_CONTACT, MECH_NO_THING, "force", "force", "N", "N",
                          "normal force of contact ", MECH_FROM_SPEEDS},
    [STEIN_READ_TANGENT] = {MECH_A_CONTACT, MECH_NO_THING, "friction", "tangent", "N", "N",
                            "friction of contact ", MECH_FROM_SPEEDS},
    [STEIN_READ_NOTCH_FORCE] = {MECH_A_NOTCH, MECH_NO_THING, "force", "notch_force", "N", "N",
                                "normal force of notch ", MECH_FROM_SPEEDS},
    [STEIN_READ_NOTCH_PHASE] = {MECH_A_NOTCH, MECH_NO_THING, "phase", "notch_phase", "1", "1",
                                "phase of notch ", MECH_FROM_NOTHING},
    [STEIN_READ_NOTCH_OVERLAP] = {MECH_A_NOTCH, MECH_NO_THING, "overlap", "notch_overlap", "m", "m",
                                  "overlap of notch ", MECH_FROM_PLACES},
    [STEIN_READ_INPUT] = {MECH_AN_INPUT, MECH_NO_THING, "value", "input", "", "", "input ",
                          MECH_FROM_FORCES},
    [STEIN_READ_INPUT_FORCE] = {MECH_AN_INPUT, MECH_NO_THING, "force", "input_force", "N m", "N",
                                "force that goes with input ", MECH_FROM_FORCES},
    [STEIN_READ_KINETIC] = {MECH_AN_ENERGY, MECH_NO_THING, "kinetic", "kinetic", "J", "J",
                            "kinetic energy", MECH_FROM_SPEEDS},
    [STEIN_READ_POTENTIAL] = {MECH_AN_ENERGY, MECH_NO_THING, "potential", "potential", "J", "J",
                              "potential energy", MECH_FROM_PLACES},
    [STEIN_READ_ROLL] = {MECH_A_BODY, MECH_NO_THING, "roll", "roll", "rad", "rad", "roll of body ",
                         MECH_FROM_SPEEDS},
    [STEIN_READ_PITCH] = {MECH_A_BODY, MECH_NO_THING, "pitch", "pitch", "rad", "rad",
                          "pitch of body ", MECH_FROM_SPEEDS},
    [STEIN_READ_YAW] = {MECH_A_BODY, MECH_NO_THING, "yaw", "yaw", "rad", "rad", "yaw of body ",
                        MECH_FROM_SPEEDS},
    [STEIN_READ_XX] = {MECH_A_BODY, MECH_NO_THING, "xx", "xx", "1", "1", "attitude xx of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_XY] = {MECH_A_BODY, MECH_NO_THING, "xy", "xy", "1", "1", "attitude xy of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_XZ] = {MECH_A_BODY, MECH_NO_THING, "xz", "xz", "1", "1", "attitude xz of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_YX] = {MECH_A_BODY, MECH_NO_THING, "yx", "yx", "1", "1", "attitude yx of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_YY] = {MECH_A_BODY, MECH_NO_THING, "yy", "yy", "1", "1", "attitude yy of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_YZ] = {MECH_A_BODY, MECH_NO_THING, "yz", "yz", "1", "1", "attitude yz of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_ZX] = {MECH_A_BODY, MECH_NO_THING, "zx", "zx", "1", "1", "attitude zx of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_ZY] = {MECH_A_BODY, MECH_NO_THING, "zy", "zy", "1", "1", "attitude zy of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_ZZ] = {MECH_A_BODY, MECH_NO_THING, "zz", "zz", "1", "1", "attitude zz of body ",
                       MECH_FROM_SPEEDS},
    [STEIN_READ_WX] = {MECH_A_BODY, MECH_NO_THING, "wx", "wx", "rad/s", "rad/s",
                       "turning speed about x of body ", MECH_FROM_SPEEDS},
    [STEIN_READ_WY] = {MECH_A_BODY, MECH_NO_THING, "wy", "wy", "rad/s", "rad/s",
                       "turning speed about y of body ", MECH_FROM_SPEEDS},
    [STEIN_READ_WZ] = {MECH_A_BODY, MECH_NO_THING, "wz", "wz", "rad/s", "rad/s",
                       "turning speed about z of body ", MECH_FROM_SPEEDS},
    [STEIN_READ_ANGLE] = {MECH_A_BODY, MECH_NO_THING, "angle", "angle", "rad", "rad",
                          "angle against the frame of body ", MECH_FROM_PLACES},
    [STEIN_READ_REACTION] = {MECH_A_JOINT, MECH_A_LOOP, "reaction", "reaction", "", "",
                             "reaction of ", MECH_FROM_FORCES},
};
_Static_assert(sizeof kinds / sizeof *kinds == STEIN_READ_KINDS, "every kind of output has a row");

const mech_output_kind *mech_output_kind_of(int read)
{
    return &kinds[read];
}
