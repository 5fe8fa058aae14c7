/* SPDX-License-Identifier: MIT
 * batch_run.c - steps and runs of a batch: what is done in lanes, what alone.
 */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "batch_inner.h"

/* steps that are to be tried */
typedef struct aim {
    stein__grid grid;
    long most; /* so many of them for sure */
    int whole; /* they are on the grid of the simulation */
} aim;

static double end_of(const aim *to, long i)
{
    return to->grid.t0 + (to->grid.taken + (double)i) * to->grid.dt;
}

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

/* step `nth` of the aim */
static void step_alone(stein_batch *b, int i, const aim *to, long nth, stein_err *err)
{
    berth *p = &b->place[i];
    stein_err why;
    stein__batch_fetch(b, i);
    p->seat = p->seat == SEEN ? MOVED : p->seat;
    stein_status status = stein__advance(p->sim, end_of(to, nth), &why);
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

/* steps that a lane took are the simulation's; the rest of its state comes when it is asked for */
static void step_away(berth *p, const aim *to, long n, double t)
{
    if (n > 0) {
        p->sim->head->t = t;
        p->sim->head->step += n * to->whole;
        p->sim->fresh = STALE;
        p->seat = AWAY;
    }
}

/* The same number of steps for all places of group g that are wanted (one bit each), each to its
 * aims: as many as all of them are sure of, or up to the first one that a simulation took alone,
 * which is where events are. @return that number */
static long step_group(stein_batch *b, int g, const aim *to, unsigned wanted, stein_err *err)
{
    int first = g * b->lanes;
    long n = 1, most = LONG_MAX;
    int in_lanes = b->width != NULL && !stein__is_controlled(b->def.integrator);
    unsigned done = 0, riders = in_lanes ? stein__batch_board(b, g) & wanted : 0;
    riders = count(riders) > 1 ? riders : 0;
    if (riders != 0) {
        double t[MAX_LANES] = {0.0};
        stein__grid grid[MAX_LANES] = {{0.0, 0.0, 0.0}};
        for (int k = 0; k < b->lanes; k++) {
            if (riders >> k & 1) {
                t[k] = b->place[first + k].sim->head->t;
                grid[k] = to[k].grid;
                most = to[k].most < most ? to[k].most : most;
            }
        }
        most = riders == wanted ? most : 1;
        done = b->width->steps(b->wide[g], grid, t, riders, most, &n);
        for (int k = 0; k < b->lanes; k++) {
            if (riders >> k & 1) {
                step_away(&b->place[first + k], &to[k], n - !(done >> k & 1), t[k]);
            }
        }
    }
    for (int k = 0; k < b->lanes; k++) {
        if ((wanted & ~done) >> k & 1) {
            step_alone(b, first + k, &to[k], n, err);
        }
    }
    return n;
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

static stein__grid grid_of(const stein_sim *sim)
{
    return (stein__grid){sim->head->t0, (double)sim->head->step, sim->def.dt};
}

stein_status stein_batch_steps(stein_batch *b, long most, long *taken, stein_status *status,
                               stein_err *err)
{
    memset(b->state, 0, sizeof *b->state * (size_t)b->n);
    for (int g = 0; g < b->ngroup; g++) {
        aim to[MAX_LANES] = {{.whole = 0}};
        unsigned wanted = 0;
        for (int k = 0, i = g * b->lanes; k < b->lanes && i < b->n; k++, i++) {
            const stein_sim *sim = b->place[i].sim;
            if (sim != NULL) {
                // groups go on together: several of them step by step
                to[k] = (aim){grid_of(sim), b->ngroup == 1 ? most : 1, 1};
                wanted |= 1u << k;
            }
        }
        *taken = step_group(b, g, to, wanted, err);
    }
    return finish(b, status);
}

stein_status stein_batch_step(stein_batch *b, stein_status *status, stein_err *err)
{
    long taken;
    return stein_batch_steps(b, 1, &taken, status, err);
}

/* Steps of the grid that end before t_end for sure, as stein_run takes them: rounding may hide the
 * last one. */
static long surely_whole(const stein_sim *sim, double t_end)
{
    double n = (t_end - sim->head->t0) / sim->def.dt - (double)sim->head->step - 2.0;
    return (long)fmin(fmax(n, 1.0), 1e6);
}

/* the next steps of a run to t_end, as stein_run takes them; 0 when there is none */
static int next_aim(const stein_sim *sim, double t_end, aim *to)
{
    double target;
    to->whole = stein__next_end(sim, t_end, &target);
    to->grid = to->whole ? grid_of(sim) : (stein__grid){target, 0.0, 0.0};
    to->most = to->whole ? surely_whole(sim, t_end) : 1;
    return sim->head->t < target;
}

static void run_group(stein_batch *b, int g, const double *t_end, stein_err *err)
{
    int first = g * b->lanes;
    unsigned wanted;
    do {
        aim to[MAX_LANES] = {{.whole = 0}};
        wanted = 0;
        for (int k = 0, i = first; k < b->lanes && i < b->n; k++, i++) {
            const stein_sim *sim = b->place[i].sim;
            if (sim != NULL && b->state[i] == STEIN_OK && next_aim(sim, t_end[i], &to[k])) {
                wanted |= 1u << k;
            }
        }
        if (wanted != 0) {
            (void)step_group(b, g, to, wanted, err);
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

/* what lane k of group g has tried, as if the simulation had done it itself */
static void take_trial(const stein_batch *b, int g, int k)
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
}

/* The trials of the riders of group g, each as if it had been made alone: taken over, graded, and
 * long ones asked in the middle. @return those that ended with numbers */
static unsigned try_riders(stein_batch *b, int g, unsigned riders)
{
    int first = g * b->lanes;
    unsigned long_ones = 0;
    double t[MAX_LANES] = {0.0}, h[MAX_LANES] = {0.0};
    double tolerance[MAX_LANES] = {0.0}, log_last[MAX_LANES] = {0.0};
    double e[MAX_LANES], log_e[MAX_LANES], factor[MAX_LANES];
    for (int k = 0; k < b->lanes; k++) {
        if (riders >> k & 1) {
            const stein__pacer *p = &b->pacer[first + k];
            t[k] = p->t;
            h[k] = p->h;
            tolerance[k] = b->pace[first + k]->tolerance;
            log_last[k] = p->log_last;
        }
    }
    unsigned done = b->width->trial(b->wide[g], t, h, riders);
    b->width->grade(b->wide[g], h, tolerance, log_last, e, log_e, factor);
    for (int k = 0; k < b->lanes; k++) {
        if (done >> k & 1) {
            stein__pacer *p = &b->pacer[first + k];
            take_trial(b, g, k);
            if (!p->repeated) {
                p->grade = (stein__grade){e[k], log_e[k], factor[k], 0.0};
                long_ones |= (unsigned)(p->middle && !(e[k] > 1.0)) << k;
            }
        }
    }
    unsigned grazing = long_ones != 0 ? b->width->grazes(b->wide[g], h) : 0;
    for (int k = 0; k < b->lanes; k++) {
        if (long_ones >> k & 1) {
            b->pacer[first + k].middle = (int)(grazing >> k & 1);
        }
    }
    return done;
}

/* one trial of every place of group g that is wanted, and what follows from it */
static void try_group(stein_batch *b, int g, unsigned wanted)
{
    int first = g * b->lanes;
    unsigned riders = b->width != NULL ? stein__batch_board(b, g) & wanted : 0;
    unsigned done = count(riders) > 1 ? try_riders(b, g, riders) : 0;
    for (int k = 0; k < b->lanes; k++) {
        if (wanted >> k & 1) {
            int i = first + k;
            berth *p = &b->place[i];
            stein_status status = STEIN_OK;
            if (!(done >> k & 1)) {
                stein__batch_fetch(b, i);
                status = stein__pace_try(p->sim, b->pace[i], &b->pacer[i], &b->why[i]);
            }
            b->state[i] = stein__pace_judge(p->sim, b->pace[i], &b->pacer[i], status, &b->why[i]);
            p->seat = p->seat == SEEN ? MOVED : p->seat;
            // qdd is known. NOLINTNEXTLINE(clang-analyzer-core.NullDereference): it is there
            p->sim->fresh = p->sim->fresh == STALE ? KNOWN : p->sim->fresh;
        }
    }
}

/* is a trial of place i next? What is at its end, or fails, needs none, and is *over */
static int wants_trial(stein_batch *b, int i, int *over)
{
    stein_sim *sim = b->place[i].sim;
    stein__pacer *p = &b->pacer[i];
    if (b->pace[i] == NULL) {
        return 0;
    }
    if (b->state[i] == STEIN_OK && !(p->h > 0.0)) { // else it waits for the others of its group
        b->state[i] = stein__pace_next(sim, b->pace[i], p, &b->why[i]);
    }
    if (b->state[i] != STEIN_OK) {
        sim->fresh = STALE; // NOLINT(clang-analyzer-core.NullDereference): a pace is a simulation's
    } else if (p->h > 0.0) {
        return 1;
    } else {
        stein__pace_end(sim, b->pace[i], p->t_end);
    }
    b->pace[i] = NULL;
    *over = i;
    return 0;
}

/* trials of group g until one of its runs is over. @return its place, -1: none is under way */
static int pace_group(stein_batch *b, int g)
{
    int over = -1, end = (g + 1) * b->lanes;
    unsigned wanted = 1;
    while (over < 0 && wanted != 0) {
        wanted = 0;
        for (int i = g * b->lanes; over < 0 && i < end && i < b->n; i++) {
            wanted |= (unsigned)wants_trial(b, i, &over) << (i - g * b->lanes);
        }
        if (over < 0 && wanted != 0) {
            try_group(b, g, wanted);
        }
    }
    return over;
}

stein_status stein_batch_begin(stein_batch *b, int i, double t_end, stein_pace *pace,
                               stein_err *err)
{
    if (i < 0 || i >= b->n || b->place[i].sim == NULL) {
        return stein__fail(err, STEIN_EINVAL, "place %d of a batch of %d has no simulation to run",
                           i, b->n);
    }
    stein__batch_fetch(b, i);
    stein_status status = stein__pace_begin(b->place[i].sim, t_end, pace, &b->pacer[i], err);
    b->pacer[i].explicit_only = b->def.integrator != STEIN_IMPLICIT; // as in lanes
    b->state[i] = status;
    b->pace[i] = status == STEIN_OK ? pace : NULL;
    b->place[i].sim->fresh = status == STEIN_OK ? b->place[i].sim->fresh : STALE;
    return status;
}

int stein_batch_go(stein_batch *b, stein_status *status, stein_err *err)
{
    int over = -1;
    for (int g = 0; over < 0 && g < b->ngroup; g++) {
        over = pace_group(b, g);
    }
    *status = over >= 0 ? b->state[over] : STEIN_OK;
    if (*status != STEIN_OK && err != NULL) {
        *err = b->why[over];
    }
    return over;
}

stein_status stein_batch_run_adaptive(stein_batch *b, const double *t_end, stein_pace *pace,
                                      stein_status *status, stein_err *err)
{
    stein_status ended;
    stein_err why, *to = err;
    int i;
    memset(b->state, 0, sizeof *b->state * (size_t)b->n);
    for (i = 0; i < b->n; i++) {
        if (b->place[i].sim != NULL &&
            stein_batch_begin(b, i, t_end[i], &pace[i], to) != STEIN_OK) {
            to = NULL; // the first one is told
        }
    }
    while (stein_batch_go(b, &ended, &why) >= 0) {
        if (ended != STEIN_OK && to != NULL) {
            *to = why;
            to = NULL;
        }
    }
    return finish(b, status);
}
