/* SPDX-License-Identifier: GPL-3.0-or-later
 * creep.c - contacts that still creep at the end of a run: their friction is a smooth law, which
 * gives a force only while the contact slides. Dry friction would hold them.
 */
#include "creep.h"

#include <math.h>
#include <stdlib.h>

struct cli_creep {
    const stein_model *model;
    double until;
    int rows; /* that were looked at */
    struct seen {
        int rows;           /* in which it crept */
        double least, most; /* speeds [m/s] */
    } seen[];
};

static const double last = 0.8;     /* of a run: from there on */
static const double creeping = 0.5; /* of the turning speed: tanh is not near 1 */
static const double steady = 0.9;   /* least over largest speed */
static const double far = 0.01; /* of the largest motion of a slide: what creeps in a run counts */
static const double least_range = 1e-4; /* of a slide [m]: what moves less does not creep */
enum { FEWEST = 10 };                   /* rows */

cli_creep *cli_creep_begin(const stein_model *model, double until)
{
    size_t size = sizeof(cli_creep) + (size_t)model->ncontact * sizeof(struct seen);
    cli_creep *c = calloc(1, size);
    if (c != NULL) {
        c->model = model;
        c->until = until;
    }
    return c;
}

void cli_creep_look(cli_creep *c, stein_sim *sim)
{
    if (stein_time(sim) < last * c->until) {
        return;
    }
    for (int i = 0; i < c->model->ncontact; i++) {
        struct seen *s = &c->seen[i];
        double speed, slip;
        if (stein_slides(sim, i, &speed, &slip) && slip < creeping) {
            s->least = s->rows == 0 ? speed : fmin(s->least, speed);
            s->most = fmax(s->most, speed);
            s->rows++;
        }
    }
    c->rows++;
}

void cli_creep_warn(const cli_creep *c, double range)
{
    for (int i = 0; c->rows >= FEWEST && i < c->model->ncontact; i++) {
        const struct seen *s = &c->seen[i];
        double most = far * fmax(range, least_range);
        if (s->rows == c->rows && s->least > steady * s->most && s->most * c->until > most) {
            fprintf(
                stderr,
                "stein: contact \"%s\" creeps at %.2g m/s below its limit of friction, as smooth "
                "friction does; friction: {stick: yes} holds it\n",
                c->model->contacts[i].name, s->most);
        }
    }
}
