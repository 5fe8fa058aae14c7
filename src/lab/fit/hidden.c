/* SPDX-License-Identifier: GPL-3.0-or-later
 * hidden.c - coordinates of bodies that turn in all directions and that the beginning of a record
 * does not show. The height of a thrown cube determines neither its place nor its attitude. They
 * begin as the file or the record states. So does a chart, which is no coordinate of the motion.
 */
#include <math.h>
#include <string.h>

#include "fitting.h"

static const double nudge = 1e-3, least = 1e-9; /* of a coordinate; of what is shown */

/* does any channel of the stroke change with the coordinate? */
static int shows(const fit__stroke *s, stein_sim *sim, int joint, double *room)
{
    int nq = stein_sim_model(sim)->nq, any = 0;
    double *q = room, *qd = room + nq, *y = room + 2 * (size_t)nq;
    memcpy(q, stein_q(sim), sizeof *q * (size_t)nq);
    memcpy(qd, stein_qd(sim), sizeof *qd * (size_t)nq);
    for (int k = 0; k < 2; k++) {
        q[joint] += k * nudge;
        if (stein_set_state(sim, 0.0, q, qd, NULL) != STEIN_OK) {
            return 1;
        }
        for (int c = 0; c < s->nch; c++) {
            double now = stein_read(sim, s->channel[c]);
            any |= k == 1 && !(fabs(now - y[c]) < least);
            y[c] = now;
        }
    }
    return any;
}

int fit__is_hidden(const fit__problem *p, const fit__stroke *s, int joint)
{
    const mech_body *body = &lab__mechanism(p->model)->bodies[joint];
    if (!body->lead && !body->ball) {
        return 0;
    }
    stein_sim *sim = NULL;
    double *room =
        calloc(2 * (size_t)lab_equations(p->model)->nq + (size_t)s->nch + 1, sizeof *room);
    int hidden = body->ball == 1;
    if (!hidden && room != NULL && lab_sim(p->model, NULL, &sim, NULL) == STEIN_OK) {
        hidden = !shows(s, sim, joint, room);
    }
    stein_sim_destroy(sim);
    free(room);
    return hidden;
}
