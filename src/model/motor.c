/* SPDX-License-Identifier: MIT
 * motor.c - a joint that a direct-current motor drives through a gear.
 *
 * With torque constant k [N m/A = V s/rad], resistance R [ohm] and gear ratio r, the motor turns by
 * r qd and the joint feels r times its torque k i:
 *
 *      R i + L di/dt = u - k r qd      Q = r k i
 *
 * (Spong, Hutchinson & Vidyasagar 2006, chapter 6, actuator dynamics). L is left out: the current
 * settles within L/R, a few ms at most, which is short against the motion of a joint. Then
 *
 *      Q = r k/R u - (r k)^2/R qd
 *
 * The first term is the force of a voltage input. The second one, the back-EMF, is viscous, also
 * where u is 0 (closed terminals). It joins the damping b of the joint in the block of its laws:
 * e = (r k)^2/R, b' = b + e. The back-EMF is the same in both directions, so the asymmetry a of the
 * damping becomes a' = a b/b'.
 */
#include "reader.h"

/** A number of the reader's own, given by a formula. */
static void derived(mech__reader *rd, mech_scalar *to, const mech__node *node, const char *unit,
                    const char *name, const char *what, const char *label, const char *text)
{
    mech__slot *s = text ? mech__number(rd, to, unit, 0, NULL, 0.0, "%s.motor.%s", name, what) : 0;

    if (s) {
        s->node = node;
        s->label = label;
        s->text = text;
    }
}

void mech__motor(mech__reader *rd, mech_body *b, const mech__node *node, const mech_scalar *law)
{
    int slides = b->type == 'T';
    const char *n = b->name;
    const mech__node *gear = mech__get(node, "gear");
    mech_scalar *own = mech__alloc(rd, 3 * sizeof *own);

    if (!own || !mech__keys(rd, node, "motor", "torque_constant resistance gear")) {
        return;
    }
    if (slides && !gear) {
        mech__need(rd, node, "gear", "the motor of a sliding joint");
    }
    b->has_motor = 1;
    mech__slot *k = mech__number(rd, &own[0], "N m/A", MECH__POSITIVE,
                                 mech__need(rd, node, "torque_constant", "motor"), 1.0,
                                 "%s.motor.torque_constant", n);
    if (k) {
        k->dim.rad = -1; // V s/rad is as good
    }
    mech__number(rd, &own[1], "ohm", MECH__POSITIVE, mech__need(rd, node, "resistance", "motor"),
                 1.0, "%s.motor.resistance", n);
    mech__number(rd, &own[2], slides ? "rad/m" : "1", MECH__POSITIVE, gear, 1.0, "%s.motor.gear",
                 n);
    derived(
        rd, &b->per_volt, node, slides ? "N/V" : "N m/V", n, "per_volt",
        "gear torque_constant / resistance",
        mech__print(rd, "%s.motor.gear * %s.motor.torque_constant / %s.motor.resistance", n, n, n));
    derived(rd, &b->joint[STEIN_JOINT_B], node, slides ? "N s/m" : "N m s/rad", n, "damping",
            "damping + (gear torque_constant)^2 / resistance",
            mech__print(rd,
                        "%s.damping + %s.motor.per_volt * %s.motor.gear * "
                        "%s.motor.torque_constant",
                        n, n, n, n));
    derived(rd, &b->joint[STEIN_JOINT_ASYMMETRY], node, "1", n, "asymmetry",
            "asymmetry damping / (damping + (gear torque_constant)^2 / resistance)",
            mech__print(rd, "%s.asymmetry * %s.damping / %s.motor.damping", n, n, n));
    for (int i = 0; i < STEIN_JOINT_SIZE; i++) {
        if (i != STEIN_JOINT_B && i != STEIN_JOINT_ASYMMETRY) {
            mech__repeat(rd, &b->joint[i], &law[i]);
        }
    }
}
