/* SPDX-License-Identifier: MIT
 * stick_events.c - when friction that sticks lets go, reverses, and sticks again (stick.c says what
 * it holds).
 *
 *                 |f| > limit: against f
 *        STUCK ----------------------------> FORWARDS, BACKWARDS
 *              <----------------------------  speed 0, if |f| <= limit; else against f again
 *
 * Both are located like touch-down. A spot that begins to touch slips as it moves, or sticks if it
 * does not move along the surface. After every change the forces are worked out again, and the
 * place that is worst_overload above its limit lets go, until none is.
 *
 * Places with the same row of G (stick.c), as both corners of a box have, move alike: they let go
 * together and stick together, whatever little is left of a speed.
 */
#include <math.h>

#include "core.h"

static const double still = 1e-12; /* [m/s or rad/s] is at rest */
static const double above = 1e-12; /* of a limit: by rounding */
static const double little = 1e-6; /* [m/s^2 or rad/s^2] against a direction: by rounding */
/* [m/s or rad/s] that places of one row may move against their new direction, as their rows are the
 * same to 1e-3 only */
static const double together = 1e-9;
static const double no_share = 1e-6; /* of an independent row in another one */

enum { KEEP, LET_GO, TOGETHER, HELD_AGAIN }; /* what has been done with a place */

/* What is left of a speed against the new direction, by rounding or beside a place that sticks, is
 * no reversal; nor is `more`. */
static void begin_slip(stein_sim *sim, int k, double more)
{
    double f = sim->hold.force[k], v = sim->hold.speed[k];
    int back = f != 0.0 ? f > 0.0 : v < 0.0;
    sim->stick[k] = back ? BACKWARDS : FORWARDS;
    sim->hold.slack[k] = more + fmax(back ? v : -v, 0.0);
    int again = sim->hold.done[k] == HELD_AGAIN;
    sim->hold.done[k] = again ? HELD_AGAIN : more > 0.0 ? TOGETHER : LET_GO;
}

/* the row of a place that sticks, -1: it has none */
static int find_row(const stein__sticks *s, int place)
{
    for (int r = 0; r < s->nrow; r++) {
        if (s->row[r] == place) {
            return r;
        }
    }
    return -1;
}

/* does a place that sticks hold the same as another one that does? */
static int holds_the_same(const stein__sticks *s, int place)
{
    int row = find_row(s, place), found = 0;
    for (int r = 0; row >= 0 && r < s->nrow; r++) {
        found |= r != row && stein__stick_alike(s, r, row) != 0;
    }
    return found;
}

/* a place that sticks, and those that hold the same */
static void release(stein_sim *sim, int place)
{
    const stein__sticks *s = &sim->hold;
    int row = find_row(s, place);
    begin_slip(sim, place, holds_the_same(s, place) ? together : 0.0);
    for (int r = 0; row >= 0 && r < s->nrow; r++) {
        if (r != row && stein__stick_alike(s, r, row) != 0) {
            begin_slip(sim, s->row[r], together);
        }
    }
}

static void set_by_speed(stein_sim *sim, int k)
{
    double v = sim->hold.speed[k];
    sim->stick[k] = fabs(v) <= still ? STUCK : v > 0.0 ? FORWARDS : BACKWARDS;
    sim->hold.slack[k] = 0.0;
}

/* places that slip beside one that sticks and holds the same */
static void stick_together(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    for (int k = 0; k < sim->model->nstick; k++) {
        unsigned char slips = sim->stick[k];
        if (is_at_rest(slips) || s->touch[k] < 0 || s->done[k] != KEEP) {
            continue;
        }
        sim->stick[k] = STUCK;
        if (stein__stick_look(sim) != STEIN_OK || !holds_the_same(s, k)) {
            sim->stick[k] = slips;
        }
    }
}

/* the place that is worst_overload above its limit, -1: none is */
static int worst_overload(const stein_sim *sim)
{
    const stein__sticks *s = &sim->hold;
    double most = 1.0 + above;
    int worst = -1;
    for (int r = 0; r < s->nrow; r++) {
        int k = s->row[r];
        double f = fabs(s->force[k]), share = f > 0.0 ? f / s->limit[k] : 0.0;
        if (share > most) {
            most = share;
            worst = k;
        }
    }
    return worst;
}

/* the place that has let go and moves the other way most, -1: none does; at most once each */
static int worst_reversal(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    double most = 0.0;
    int worst = -1;
    for (int k = 0; k < sim->model->nstick; k++) {
        if (s->done[k] == LET_GO && !is_at_rest(sim->stick[k])) {
            double rate = stein__stick_rate(sim, k);
            double back = sim->stick[k] == FORWARDS ? -rate : rate;
            if (back > most) {
                most = back;
                worst = k;
            }
        }
    }
    return most > little ? worst : -1;
}

/* One change towards forces within their limits and directions that are those of the motion.
 * @return 0: there is none to make */
static int improve(stein_sim *sim)
{
    if (stein__stick_look(sim) != STEIN_OK) {
        return 0;
    }
    int above_limit = worst_overload(sim);
    if (above_limit >= 0) {
        release(sim, above_limit);
        return 1;
    }
    int back = worst_reversal(sim);
    if (back >= 0) {
        sim->stick[back] = STUCK;
        sim->hold.done[back] = HELD_AGAIN;
    }
    return back >= 0;
}

static void emit_events(stein_sim *sim)
{
    for (int k = 0; sim->on_event != NULL && k < sim->model->nstick; k++) {
        int now = sim->stick[k], rests = is_at_rest(now), rested = is_at_rest(sim->hold.was[k]);
        if (sim->hold.touch[k] >= 0 && now != sim->hold.was[k] && !(rests && rested)) {
            stein_event event = {rests ? STEIN_EVENT_STICK : STEIN_EVENT_SLIP, k,
                                 (int)stein__slips(sim, k), sim->head->t};
            sim->on_event(sim->event_ctx, sim, &event);
        }
    }
}

/* Rows that are independent hold, the others share, until the next change, where they are now or,
 * those that have done so before, where they were. @return has one begun to hold? */
static int assign_shares(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int begun = 0;
    for (int k = 0; k < sim->model->nstick; k++) {
        if (!is_at_rest(sim->stick[k])) {
            sim->anchor[k] = s->slack[k];
        }
    }
    for (int r = 0; r < s->nrow; r++) {
        int k = s->row[r], is_independent = s->pivot[r] < 0.0;
        for (int a = 0; a < s->rank; a++) {
            is_independent |= s->order[a] == r;
        }
        sim->stick[k] = is_independent ? STUCK : SHARES;
        if (s->was[k] != sim->stick[k]) {
            sim->anchor[k] = stein__stick_slid(sim, k);
            begun |= is_independent;
        }
    }
    return begun;
}

/* until no force is above its limit */
static void resolve_limits(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int most = 3 * sim->model->nstick + 1;
    s->deciding = 1;
    stick_together(sim);
    while (most > 0 && improve(sim)) {
        most--;
    }
    if (assign_shares(sim)) {
        stein__stick_stop(sim, sim->qd);
    }
    s->deciding = 0;
    sim->fresh = STALE;
}

void stein__stick_begin(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int n = sim->model->nstick;
    for (int k = 0; k < n; k++) {
        sim->stick[k] = s->was[k] = FORWARDS;
        s->done[k] = KEEP;
        s->slack[k] = 0.0;
    }
    if (n == 0 || stein__stick_look(sim) != STEIN_OK) {
        return;
    }
    for (int k = 0; k < n; k++) {
        if (s->touch[k] >= 0) {
            set_by_speed(sim, k);
        }
    }
    resolve_limits(sim);
}

/* a spot that has begun to touch: where it stuck before is over */
static int begins_to_touch(const stein_sim *sim, int k)
{
    const stein_stick *stick = &sim->model->sticks[k];
    return stick->kind == STEIN_STICK_SPOT && sim->crossed[stick->index] && sim->mode[stick->index];
}

/* a place that shares no longer holds what others do */
static int no_longer_shares(const stein_sim *sim, int k)
{
    const stein__sticks *s = &sim->hold;
    int row = sim->stick[k] == SHARES ? find_row(s, k) : -1;
    return row >= 0 &&
           s->pivot[row] > 0.99 * STEIN__PARTED * STEIN__ALIKE * s->S[row * s->nrow + row];
}

void stein__stick_switch(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int n = sim->model->nstick;
    for (int k = 0; k < n; k++) {
        sim->stick[k] = begins_to_touch(sim, k) ? FORWARDS : sim->stick[k];
        s->was[k] = sim->stick[k];
        s->done[k] = KEEP;
        s->slack[k] = sim->anchor[k];
    }
    if (stein__stick_look(sim) != STEIN_OK) {
        return;
    }
    for (int k = 0; k < n; k++) {
        if (s->touch[k] < 0) {
            continue;
        }
        if (begins_to_touch(sim, k)) {
            set_by_speed(sim, k);
        } else if (sim->crossed[sim->nguard + k]) {
            if (no_longer_shares(sim, k)) {
                set_by_speed(sim, k);
            } else if (is_at_rest(sim->stick[k])) {
                release(sim, k);
            } else if (s->done[k] == KEEP) {
                sim->stick[k] = STUCK;
            }
        }
    }
    resolve_limits(sim);
    emit_events(sim);
}

/* the contact of a place, or its joint after all contacts */
static int thing_of(const stein_sim *sim, int place)
{
    const stein_stick *stick = &sim->model->sticks[place];
    return stick->kind == STEIN_STICK_JOINT ? sim->model->ncontact + stick->index
                                            : sim->model->spots[stick->index].contact;
}

int stein__stick_is_open(const stein_sim *sim, int row)
{
    const stein__sticks *s = &sim->hold;
    int place = s->row[row];
    return sim->stick[place] == SHARES || (s->pivot[row] < 0.0 && s->limit[place] > 0.0);
}

int stein__stick_shares(const stein_sim *sim, int contact)
{
    const stein__sticks *s = &sim->hold;
    int found = 0;
    for (int r = 0; r < s->nrow; r++) {
        int one = thing_of(sim, s->row[r]), shares = sim->stick[s->row[r]] == SHARES;
        found |= one == contact && !shares && stein__stick_is_open(sim, r);
        for (int c = 0; shares && c < s->rank; c++) {
            int other = thing_of(sim, s->row[s->order[c]]);
            int here = one == contact || other == contact;
            found |= here && one != other && fabs(s->share[r * s->nrow + c]) > no_share;
        }
    }
    return found;
}
