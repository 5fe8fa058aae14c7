/* SPDX-License-Identifier: MIT
 * batch_run.c - steps and runs of a batch: what is done in lanes, what alone.
 */
#include <string.h>

#include "batch_inner.h"

/* a step that is to be tried */
typedef struct aim {
    double target; /* [s] */
    int whole;     /* it ends on the grid */
} aim;

/* a failure of place i; the first one is told */
static void fail_place(stein_batch *b, int i, stein_status status, const stein_err *why,
                       stein_err *err)
{
    int first = 1;
    for (int k = 0; k < b->n; k++) {
        first = first && b->state[k] == STEIN_OK;
    }
    b->state[i] = status;
    if (first && err != NULL) {
        *err = *why;
    }
}

static void step_alone(stein_batch *b, int i, const aim *to, stein_err *err)
{
    berth *p = &b->place[i];
    stein_err why;
    stein__batch_fetch(b, i);
    p->seat = p->seat == SEEN ? MOVED : p->seat;
    stein_status status = stein__advance(p->sim, to->target, &why);
    if (status == STEIN_OK) {
        p->sim->head->step += to->whole;
    } else {
        fail_place(b, i, status, &why, err);
    }
}

static int count(unsigned bits)
{
    int n = 0;
    for (; bits != 0; bits &= bits - 1) {
        n++;
    }
    return n;
}

/* the places of group g that are wanted (one bit each), each to its aim */
static void step_group(stein_batch *b, int g, const aim *to, unsigned wanted, stein_err *err)
{
    int first = g * b->lanes;
    unsigned done = 0, riders = b->width != NULL ? stein__batch_board(b, g) & wanted : 0;
    if (count(riders) > 1) {
        double h[MAX_LANES] = {0.0};
        for (int k = 0; k < b->lanes; k++) {
            h[k] = riders >> k & 1 ? to[k].target - b->place[first + k].sim->head->t : 0.0;
        }
        done = b->width->step(b->wide[g], h, riders);
    }
    for (int k = 0; k < b->lanes; k++) {
        if (done >> k & 1) {
            berth *p = &b->place[first + k];
            p->sim->head->t = to[k].target;
            p->sim->head->step += to[k].whole;
            p->sim->fresh = STALE;
            p->seat = AWAY;
        } else if (wanted >> k & 1) {
            step_alone(b, first + k, &to[k], err);
        }
    }
}

static stein_status finish(const stein_batch *b, stein_status *status)
{
    stein_status first = STEIN_OK;
    for (int i = 0; i < b->n; i++) {
        first = first == STEIN_OK ? b->state[i] : first;
        if (status != NULL) {
            status[i] = b->state[i];
        }
    }
    return first;
}

stein_status stein_batch_step(stein_batch *b, stein_status *status, stein_err *err)
{
    memset(b->state, 0, sizeof *b->state * (size_t)b->n);
    for (int g = 0; g < b->ngroup; g++) {
        aim to[MAX_LANES];
        unsigned wanted = 0;
        for (int k = 0, i = g * b->lanes; k < b->lanes && i < b->n; k++, i++) {
            const stein_sim *sim = b->place[i].sim;
            if (sim != NULL) {
                to[k] = (aim){stein__next_on_grid(sim), 1};
                wanted |= 1u << k;
            }
        }
        step_group(b, g, to, wanted, err);
    }
    return finish(b, status);
}

/* the next step of a run to t_end, as stein_run takes it; 0 when there is none */
static int next_aim(const stein_sim *sim, double t_end, aim *to)
{
    to->whole = stein__next_end(sim, t_end, &to->target);
    return sim->head->t < to->target;
}

static void run_group(stein_batch *b, int g, const double *t_end, stein_err *err)
{
    int first = g * b->lanes;
    unsigned wanted;
    do {
        aim to[MAX_LANES];
        wanted = 0;
        for (int k = 0, i = first; k < b->lanes && i < b->n; k++, i++) {
            const stein_sim *sim = b->place[i].sim;
            if (sim != NULL && b->state[i] == STEIN_OK && next_aim(sim, t_end[i], &to[k])) {
                wanted |= 1u << k;
            }
        }
        if (wanted != 0) {
            step_group(b, g, to, wanted, err);
        }
    } while (wanted != 0);
    for (int i = first; i < first + b->lanes && i < b->n; i++) {
        if (b->place[i].sim != NULL && b->state[i] == STEIN_OK) {
            stein__end_run(b->place[i].sim, t_end[i]);
        }
    }
}

stein_status stein_batch_run(stein_batch *b, const double *t_end, stein_status *status,
                             stein_err *err)
{
    memset(b->state, 0, sizeof *b->state * (size_t)b->n);
    for (int i = 0; i < b->n; i++) {
        const stein_sim *sim = b->place[i].sim;
        stein_err why;
        stein_status begun = sim != NULL ? stein__check_end(sim, t_end[i], &why) : STEIN_OK;
        if (begun != STEIN_OK) {
            fail_place(b, i, begun, &why, err);
        }
    }
    for (int g = 0; g < b->ngroup; g++) {
        run_group(b, g, t_end, err);
    }
    return finish(b, status);
}

/* ---- steps of controlled error ---- */

/* a trial of place i, alone: its error in tolerances */
static stein_status try_alone(stein_batch *b, int i, const stein_pace *pace, double *e,
                              stein_err *why)
{
    stein_sim *sim = b->place[i].sim;
    stein__batch_fetch(b, i);
    return stein__pace_try(sim, pace, b->pacer[i].h, e, why);
}

/* what lane k of group g has tried, as if the simulation had done it itself */
static double take_trial(const stein_batch *b, int g, int k, const stein_pace *pace)
{
    int i = g * b->lanes + k, nq = b->model->nq;
    stein_sim *sim = b->place[i].sim;
    double error[2];
    copy(sim->q0, sim->q, nq);
    copy(sim->qd0, sim->qd, nq);
    copy(sim->qdd0, sim->qdd, nq);
    b->width->outcome(b->wide[g], k, sim->q1, sim->qd1, sim->qdd1, sim->guard, error);
    sim->eq = error[0];
    sim->eqd = error[1];
    sim->fresh = STALE; // forces and gaps are not those of its end
    return stein__pace_error(sim, pace, b->pacer[i].h);
}

/* one trial of every place of group g that is wanted, and what follows from it */
static void try_group(stein_batch *b, int g, unsigned wanted, stein_pace *pace, stein_err *err)
{
    int first = g * b->lanes;
    unsigned done = 0, riders = b->width != NULL ? stein__batch_board(b, g) & wanted : 0;
    if (count(riders) > 1) {
        double h[MAX_LANES] = {0.0};
        for (int k = 0; k < b->lanes; k++) {
            h[k] = riders >> k & 1 ? b->pacer[first + k].h : 0.0;
        }
        done = b->width->trial(b->wide[g], h) & riders;
    }
    for (int k = 0; k < b->lanes; k++) {
        if (wanted >> k & 1) {
            int i = first + k;
            berth *p = &b->place[i];
            stein_err why;
            double e;
            stein_status status = STEIN_OK;
            if (done >> k & 1) {
                e = take_trial(b, g, k, &pace[i]);
            } else {
                status = try_alone(b, i, &pace[i], &e, &why);
            }
            status = stein__pace_judge(p->sim, &pace[i], &b->pacer[i], e, status, &why);
            p->seat = p->seat == SEEN ? MOVED : p->seat;
            p->sim->fresh = p->sim->fresh == STALE ? KNOWN : p->sim->fresh; // qdd is known
            if (status != STEIN_OK) {
                p->sim->fresh = STALE;
                fail_place(b, i, status, &why, err);
            }
        }
    }
}

/* is a trial of place i next? What is at its end, or fails, needs none */
static int wants_trial(stein_batch *b, int i, stein_pace *pace, unsigned char *over, stein_err *err)
{
    stein_sim *sim = b->place[i].sim;
    stein__pacer *p = &b->pacer[i];
    stein_err why;
    if (sim == NULL || *over || b->state[i] != STEIN_OK) {
        return 0;
    }
    stein_status status = stein__pace_next(sim, &pace[i], p, &why);
    if (status != STEIN_OK) {
        sim->fresh = STALE;
        fail_place(b, i, status, &why, err);
        return 0;
    }
    if (!(p->h > 0.0)) {
        stein__pace_end(sim, &pace[i], p->t_end);
        *over = 1;
    }
    return !*over;
}

static void pace_group(stein_batch *b, int g, stein_pace *pace, stein_err *err)
{
    int first = g * b->lanes;
    unsigned char over[MAX_LANES] = {0};
    unsigned wanted;
    do {
        wanted = 0;
        for (int k = 0; k < b->lanes && first + k < b->n; k++) {
            wanted |= (unsigned)wants_trial(b, first + k, pace, &over[k], err) << k;
        }
        if (wanted != 0) {
            try_group(b, g, wanted, pace, err);
        }
    } while (wanted != 0);
}

stein_status stein_batch_run_adaptive(stein_batch *b, const double *t_end, stein_pace *pace,
                                      stein_status *status, stein_err *err)
{
    memset(b->state, 0, sizeof *b->state * (size_t)b->n);
    for (int i = 0; i < b->n; i++) {
        stein_sim *sim = b->place[i].sim;
        stein_err why;
        if (sim != NULL) {
            stein__batch_fetch(b, i);
            stein_status begun = stein__pace_begin(sim, t_end[i], &pace[i], &b->pacer[i], &why);
            if (begun != STEIN_OK) {
                sim->fresh = STALE;
                fail_place(b, i, begun, &why, err);
            }
        }
    }
    for (int g = 0; g < b->ngroup; g++) {
        pace_group(b, g, pace, err);
    }
    return finish(b, status);
}
