/* SPDX-License-Identifier: GPL-3.0-or-later
 * mistake.c - a number of the file that is off by a factor: mistyped, a diameter for a radius, an
 * inertia about another point, a length from the wrong end.
 *
 * The records are those of the true numbers. The file states one of them 1.6 to 10 times too large
 * or too small, a length or a centre up to 3 times. It is a mistake only where the records show it.
 */
#include <math.h>
#include <string.h>

#include "world.h"

enum { MOST = 200, REDRAWS = 25 };
static const double shows = 20.0; /* noises */

/* numbers of joints' laws that the file states, by the effect that changes them */
static int add_laws(const mech *m, effect *out, int *at, int most)
{
    int n = 0;
    for (const kind *k = kinds; k->name != NULL; k++) {
        int simple = k->site == 'j' && (k->offset == J_K || k->offset == J_B || k->offset == J_T ||
                                        k->offset == J_DRAG);
        for (int b = 0; simple && b < m->nbody && n < most; b++) {
            int i = m->body[b].law + k->offset;
            if (m->number[i].stated && m->number[i].file > 0.0) {
                out[n] = (effect){.kind = k, .index = b, .unit = m->number[i].unit};
                memcpy(out[n].place, m->body[b].name, NAME);
                at[n++] = i;
            }
        }
    }
    return n;
}

/* all numbers that can be mistaken. @param at  which numbers */
static int written(const mech *m, const extent *x, effect *out, int *at)
{
    int all = effect_list(m, x, out, MOST, 0), n = 0;
    for (int i = 0; i < all; i++) {
        if (strchr("bp", out[i].kind->site) != NULL && m->number[out[i].index].stated) {
            at[n] = out[i].index;
            out[n++] = out[i];
        }
    }
    return n + add_laws(m, out + n, at + n, MOST - n);
}

int mistake_draw(mech *told, const double *p, sizer *z, const extent *x, effect *e, double *reached,
                 chance *c)
{
    static effect list[MOST];
    int at[MOST], n = written(told, x, list, at);
    double q[NUMBERS];
    for (int i = 0; i < REDRAWS && n > 0; i++) {
        int k = chance_pick(c, n);
        number *N = &told->number[at[k]];
        double most = strcmp(N->unit, "m") == 0 ? 3.0 : 10.0,
               factor = chance_log(c, most > 3.0 ? 1.6 : 1.3, most);
        factor = chance_coin(c, 0.5) ? factor : 1.0 / factor;
        memcpy(q, p, sizeof q);
        q[at[k]] *= factor;
        *reached = size_change(z, q);
        if (*reached > shows) {
            N->file = q[at[k]];
            *e = list[k];
            e->size = p[at[k]] - N->file;
            return 1;
        }
    }
    return 0;
}
