/* SPDX-License-Identifier: MIT
 * determined.c - whether a reading is determined by the motion.
 *
 * Forces that do no work together can have any size. There are two kinds: forces of redundant
 * conditions of loops (reaction_loops.c), and friction that sticks at several places that hold the
 * same motion, so that their rows of G are linearly dependent (stick.c). A reading is determined if
 * it does not change with any of these forces.
 *
 * Rows of friction count as dependent up to STEIN__ALIKE, so parts of a reading that cancel out do
 * so up to some thousandths.
 */
#include <math.h>
#include <string.h>

#include "reaction.h"

static const double changed = 1e-7; /* of a slack: a reaction depends on it */
static const double cancels = 1e-2; /* of the largest part: the parts of a reading cancel out */
static const double rounded = 1e-9; /* of a reading: no part */

/* ---- redundant conditions of loops ---- */

static int loops_change(stein_sim *sim, const stein_reaction *r)
{
    double value[2] = {0.0, 0.0}, slack = 1.0;
    for (int with = 0; with < 2; with++) {
        if (stein__refresh(sim, NULL) != STEIN_OK) {
            return 1;
        }
        value[with] = stein__reaction_of(sim, r, with ? slack : 0.0);
        slack += fabs(value[0]);
    }
    return !(fabs(value[1] - value[0]) <= changed * slack); // NaN: unknown
}

/* ---- friction that sticks ---- */

/* Row `row` has 1 N or N m more: what another one has less, so that nothing moves otherwise. Of a
 * row that nothing can move, only it has more. */
static double shift_of(const stein_sim *sim, int row, int other)
{
    const stein__sticks *s = &sim->hold;
    double shift = other == row ? 1.0 : 0.0;
    for (int c = 0; c < s->rank && sim->stick[s->row[row]] == SHARES; c++) {
        shift -= s->order[c] == other ? s->share[row * s->nrow + c] : 0.0;
    }
    return shift;
}

/* Does a reaction change, if a row has more? */
static int row_changes(stein_sim *sim, const stein_reaction *r, int row, double more)
{
    stein__sticks *s = &sim->hold;
    double sum = 0.0, most = 0.0, value = stein__reaction_of(sim, r, 0.0);
    for (int other = 0; other < s->nrow; other++) {
        double shift = more * shift_of(sim, row, other);
        if (shift == 0.0) {
            continue;
        }
        if (stein__refresh(sim, NULL) != STEIN_OK) {
            return 1;
        }
        s->force[s->row[other]] += shift;
        double part = stein__reaction_of(sim, r, 0.0) - value;
        sum += part;
        most = fmax(most, fabs(part));
        sim->fresh = STALE; // the force is that of the state again
    }
    return most > rounded * (fabs(value) + rounded * more) && fabs(sum) > cancels * most;
}

static int friction_changes(stein_sim *sim, const stein_reaction *r)
{
    const stein__sticks *s = &sim->hold;
    double more = 0.0;
    if (stein__refresh(sim, NULL) != STEIN_OK) {
        return 1;
    }
    for (int row = 0; row < s->nrow; row++) {
        more += s->limit[s->row[row]];
    }
    for (int row = 0; row < s->nrow; row++) {
        if (stein__refresh(sim, NULL) != STEIN_OK ||
            (stein__stick_is_open(sim, row) && row_changes(sim, r, row, more))) {
            return 1;
        }
    }
    return 0;
}

/* ---- a reading ---- */

static int component_changes(stein_sim *sim, const stein_reaction *r)
{
    return (sim->model->nloop > 0 && loops_change(sim, r)) ||
           (sim->model->nstick > 0 && friction_changes(sim, r));
}

/* a size depends on all three components */
static int reaction_changes(stein_sim *sim, const stein_reaction *r)
{
    static const signed char first[] = {
        [STEIN_FORCE_SIZE] = STEIN_FORCE_X, [STEIN_MOMENT_SIZE] = STEIN_MOMENT_X};
    stein_reaction one = *r;
    int coupling = r->loop && sim->model->ties[r->index].kind == STEIN_TIE_COUPLING, found = 0;
    if (coupling || r->component < STEIN_FORCE_SIZE) {
        return component_changes(sim, r);
    }
    for (int i = 0; i < 3 && !found; i++) {
        one.component = (unsigned char)(first[r->component] + i);
        found = component_changes(sim, &one);
    }
    return found;
}

int stein_is_determined(stein_sim *sim, int channel)
{
    const stein_model *m = sim->model;
    int known = channel >= 0 && channel < m->nchannel, i = known ? m->channels[channel].index : 0;
    int read = known ? (int)m->channels[channel].read : STEIN_READ_TIME;
    if (read != STEIN_READ_REACTION && read != STEIN_READ_TANGENT) {
        return 1;
    }
    if (stein__refresh(sim, NULL) != STEIN_OK) {
        return 0;
    }
    return read == STEIN_READ_REACTION ? !reaction_changes(sim, &m->reactions[i])
                                       : m->nstick == 0 || !stein__stick_shares(sim, i);
}
