/* SPDX-License-Identifier: MIT
 * armature.c - rotors behind gears.
 *
 * A rotor of inertia J behind a gear of ratio r turns r times as fast as its joint, so its kinetic
 * energy is (J r^2) qd^2 / 2. The armature a = J r^2 is added to M_jj, and a qdd_j to Q_j. It has
 * no weight. Terms of the moving axis, J r (e . om) qd and J om^2, are neglected: r^2 outweighs
 * them (Featherstone 2008, section 9.6, and the armature of MuJoCo's joints).
 */
#include "tree.h"

void armature_masses(walk *w, ex *M)
{
    int n = w->t->n;
    w->g->pass = PASS_MASS;
    for (int i = 0; i < n; i++) {
        ex *own = &M[i * n + i];
        w->g->body = i;
        *own = ex_add(w->g, *own, ex_const(w->g, w->t->body[i].armature));
    }
}

void armature_forces(walk *w, ex_var_kind rate, ex *Q)
{
    w->g->pass = PASS_BACKWARD;
    for (int i = 0; i < w->t->n; i++) {
        const rbody *b = &w->t->body[i];
        if (b->armature != 0 && !b->still) {
            ex a = ex_const(w->g, b->armature);
            w->g->body = i;
            Q[i] = ex_add(w->g, Q[i], ex_mul(w->g, a, ex_var(w->g, rate, i)));
        }
    }
}
