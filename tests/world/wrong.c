/* SPDX-License-Identifier: GPL-3.0-or-later
 * wrong.c - set-ups that are wrong: the mechanism file and the records cannot both be right, and no
 * effect of any table makes them so. Whatever a diagnosis names then is wrong.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world.h"

static const double enough = 30.0; /* noises that have to be left */

enum { SENSE, PLANE, UNIT, SWAP, OTHER, WAYS };

void wrong_none(wrong *w)
{
    memset(w, 0, sizeof *w);
    w->time = 1.0;
    w->swap[0] = w->swap[1] = -1;
    for (int i = 0; i < CHANNELS; i++) {
        w->unit[i] = 1.0;
    }
}

static void name_it(wrong *w, const char *name, const char *place)
{
    snprintf(w->name, NAME, "%s", name);
    snprintf(w->place, NAME, "%.*s", NAME - 1, place);
}

/* a joint counts the other way; or gravity pulls along another axis */
static int turned(wrong *w, int way, mech *told, const mech *m, sizer *z, const double *p,
                  chance *c)
{
    *told = *m;
    if (way == SENSE) {
        int b = chance_pick(c, m->nbody);
        told->body[b].sign = -m->body[b].sign;
        name_it(w, "flipped_sense", m->body[b].name);
    } else {
        int axis = chance_pick(c, 2);
        told->gravity[2] = 0.0;
        told->gravity[axis] = m->gravity[2];
        name_it(w, "wrong_plane", "gravity");
    }
    double left = size_of(z, told, p);
    return !isfinite(left) || left > enough;
}

/* a column is in another unit than its title states */
static int misread(wrong *w, const mech *m, chance *c)
{
    int k = chance_pick(c, m->nchannel), turns = strncmp(m->channel[k].unit, "rad", 3) == 0;
    if (chance_coin(c, 0.25)) {
        w->time = 1e3;
        name_it(w, "wrong_unit", "time");
        return 1;
    }
    for (int i = 0; i < m->nchannel; i++) {
        w->unit[i] = strcmp(m->channel[i].unit, m->channel[k].unit) != 0 ? 1.0
                     : turns                                             ? 180.0 / 3.14159265358979
                                                                         : 1e3;
    }
    name_it(w, "wrong_unit", m->channel[k].name);
    return 1;
}

static int swapped(wrong *w, const mech *m, chance *c)
{
    int a = chance_pick(c, m->nchannel), b = chance_pick(c, m->nchannel);
    if (a == b || strcmp(m->channel[a].unit, m->channel[b].unit) != 0) {
        return 0;
    }
    w->swap[0] = a, w->swap[1] = b;
    name_it(w, "swapped_columns", m->channel[a].name);
    return 1;
}

int wrong_fits(const mech *m, const mech *told)
{
    // two levers, or two sleds on springs, may be one another with other numbers
    int alone = m->nbody == 1 && told->nbody == 1 && m->ncontact == told->ncontact;
    int fits = m->ninput == 0 && told->ninput == 0 && m->nchannel >= told->nchannel && !alone &&
               strcmp(m->name, told->name) != 0;
    for (int i = 0; fits && i < told->nchannel; i++) {
        fits = strcmp(m->channel[i].unit, told->channel[i].unit) == 0;
    }
    return fits;
}

int wrong_draw(wrong *w, mech *told, const mech *m, const double *p, const design *d, chance *c)
{
    enum { TRIES = 30 };
    sizer *z = size_begin(m, p, d);
    int done = 0;
    for (int i = 0; i < TRIES && z != NULL && !done; i++) {
        int way = chance_pick(c, WAYS);
        wrong_none(w);
        *told = *m;
        switch (way) {
        case SENSE:
        case PLANE: done = turned(w, way, told, m, z, p, c); break;
        case UNIT: done = misread(w, m, c); break;
        case SWAP: done = swapped(w, m, c); break;
        default: // the mechanism of the file is looked for by the caller
            w->other = done = m->ninput == 0;
            name_it(w, "other_mechanism", m->name);
        }
    }
    size_drop(z);
    return done;
}
