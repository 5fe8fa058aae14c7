/* SPDX-License-Identifier: MIT
 * press.h - a place where a pair presses, for spots and notches.
 * Included by: this folder.
 */
#ifndef STEIN_PRESS_H
#define STEIN_PRESS_H

#include "core.h"

/* A pair that is on is `depth` deep at a place, n the normal on the first one: its normal force
 * now, that of its friction with all others (touch.c), both added to f. Inline, as all of it stays
 * in registers then. */
ALWAYS void stein__press(stein_sim *sim, const pair *p, mask on, vec2 at, vec2 n, real depth,
                         spot_force *f)
{
    // rates of approach and of sliding, from the two materials at the place of contact
    vec2 v = velocity(&sim->pose[p->frame[0]], at);
    if (p->frame[1] >= 0) {
        vec2 v1 = velocity(&sim->pose[p->frame[1]], at);
        v = (vec2){v.x - v1.x, v.z - v1.z};
    }
#if STEIN_LANES == 0
    depth = stein__within(p->normal, depth);
#endif
    real rate = -(v.x * n.x + v.z * n.z);
    real normal = stein__normal(p->normal, p->parts, depth, rate);
    if (sim->ntable_on > 0) {
        normal = stein__tables_normal(sim, p->index, normal, depth, rate);
    }
#if STEIN_LANES == 1
    if (depth > f->depth) {
        f->depth = depth;
        f->rate = rate;
    }
#endif
    touch *t = &sim->touch[sim->ntouch];
    t->pair = p;
    t->at = at;
    t->n = n;
    t->normal = only(on, normal);
    if (TELLS_FORCES) {
        t->depth = depth;
        t->rate = rate;
        t->sum = f;
    }
    real speed = v.x * n.z - v.z * n.x;
    if (TELLS_FORCES) {
        t->speed = speed;
    }
    sim->slip[sim->ntouch++] = speed * p->inverse_vt;
}

#endif
