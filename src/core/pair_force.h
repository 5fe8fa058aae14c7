/* SPDX-License-Identifier: MIT
 * pair_force.h - the forces of a place where a pair presses and rubs, for spots and notches.
 *
 * The force on the first body of a pair is f_n n - mu(v) f_n t, t being n turned by -90 degrees.
 * The second body gets the opposite one at the same place. f_n follows from the depth and its
 * rate; v is the speed of sliding along t.
 * Included by: this folder.
 */
#ifndef STEIN_PAIR_FORCE_H
#define STEIN_PAIR_FORCE_H

#include "core.h"

#if STEIN_LANES == 1
/* the place touch[ntouch] is kept for queries, and its forces are added to what is told */
ALWAYS void stein__record_contact(stein_sim *sim, double slip, double grip, double tangent)
{
    const touch *t = &sim->touch[sim->ntouch];
    spot_force *f = t->sum;
    if (t->depth > f->depth) {
        f->depth = t->depth;
        f->rate = t->rate;
    }
    f->normal += t->normal;
    f->tangent += tangent;
    sim->slip[sim->ntouch] = slip;
    sim->grip[sim->ntouch] = grip;
    sim->ntouch++;
}
#endif

/* Are the forces of a place kept? In a stage only friction that sticks needs them, and in a lane
 * nothing does. */
ALWAYS int stein__records_contacts(const stein_sim *sim, place_in_step inside)
{
    return STEIN_LANES == 1 && (inside != IN_STAGE || sim->model->nstick > 0);
}

/* mu at a speed of sliding in units of vt, whose tanh is known */
ALWAYS real stein__pair_mu(const stein_sim *sim, const pair *p, real slip, real grip)
{
#if STEIN_LANES == 1
    if (p->stick >= 0) {
        return stein__slips(sim, p->stick) * p->friction[STEIN_FRICTION_A];
    }
#endif
    (void)sim;
    return stein__mu(p->friction, p->parts, slip, grip);
}

/* the normal force of a pair */
ALWAYS real stein__pair_normal(const stein_sim *sim, const pair *p, real depth, real rate)
{
    real normal = stein__normal(p->normal, p->parts, depth, rate);
    return sim->ntable_on > 0 ? stein__tables_normal(sim, p->index, normal, depth, rate) : normal;
}

/* what is known of a place where it is compiled: a second side that is fixed; plain laws in a
 * stage, where nothing is told */
typedef struct stein__known {
    int fixed, plain;
    place_in_step inside;
} stein__known;

/* A pair that is on is `depth` deep at a place, n the normal on the first one: its forces into the
 * wrenches of both. */
ALWAYS void stein__contact_force(stein_sim *sim, const pair *p, mask on, vec2 at, vec2 n,
                                 real depth, spot_force *f, stein__known known)
{
    // rates of approach and of sliding, from the two materials at the place of contact
    vec2 arm = arm_to(p->pose[0], at), arm1 = arm_to(p->pose[1], at);
    vec2 v = velocity_at(p->pose[0], arm);
    if (!known.fixed) {
        vec2 v1 = velocity_at(p->pose[1], arm1);
        v = (vec2){v.x - v1.x, v.z - v1.z};
    }
#if STEIN_LANES == 0
    depth = stein__within(p->normal, depth);
#endif
    real rate = -(v.x * n.x + v.z * n.z), speed = v.x * n.z - v.z * n.x;
    real slip = speed * p->inverse_vt, grip = stein__tanh(slip);
    real normal = known.plain ? stein__normal(p->normal, STEIN__RUBBING, depth, rate)
                              : stein__pair_normal(sim, p, depth, rate);
    real mu = known.plain ? stein__mu(p->friction, STEIN__RUBBING, slip, grip)
                          : stein__pair_mu(sim, p, slip, grip);
    normal = only(on, normal);
    real tangent = sel(more(normal, 0.0), -normal * mu, same(0.0));
    vec2 t = {n.z, -n.x};
    vec2 force = {normal * n.x + tangent * t.x, normal * n.z + tangent * t.z};
    push_at(p->wrench[0], arm, force);
    if (!known.fixed) {
        push_at(p->wrench[1], arm1, (vec2){-force.x, -force.z});
    }
#if STEIN_LANES == 1
    if (!known.plain && stein__records_contacts(sim, known.inside)) {
        sim->touch[sim->ntouch] = (touch){p, at, n, normal, depth, rate, speed, f};
        stein__record_contact(sim, slip, grip, tangent);
    }
#else
    (void)f;
#endif
}

#endif
