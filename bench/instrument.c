/* SPDX-License-Identifier: GPL-3.0-or-later
 * instrument.c - a whole instrument in real time: 61 actions at 48 kHz, in blocks of 64 frames.
 *
 * Strokes arrive at random, twelve a second; a key is held for 0.1 to 0.5 s and let go. Who plays:
 *
 *      alone    every action steps by itself, whether it moves or not
 *      lanes    all of them in lanes
 *      asleep   in lanes, those that have come to rest are left out until their next stroke
 *
 * All three play the same strokes; what moves has to have the same bits in the end. An action
 * asleep stays exactly where it came to rest, a stroke starts from the equilibrium in any case.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

enum { ACTIONS = 61, RATE = 48000, BLOCK = 64, BLOCKS = 150, REPEATS = 5 };
static const double strokes_a_second = 12.0;
static const double shortest_rest = 0.3, still = 2e-3; /* [s] after the key, [rad/s] */

typedef enum { ALONE, LANES, ASLEEP } manner;

typedef struct action {
    stein_sim *sim;
    void *start; /* a stroke's beginning */
    double held; /* time of its stroke at which the key is let go [s] */
    int moves;
    int place; /* in the batch, -1: none */
} action;

typedef struct instrument {
    manner manner;
    action action[ACTIONS];
    int at[ACTIONS]; /* who is in a place */
    int nplaced;
    stein_batch *batch;
    unsigned long long seed;
} instrument;

static double chance(instrument *m)
{
    m->seed = m->seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(m->seed >> 11) * 0x1p-53;
}

static void enter(instrument *m, int i)
{
    if (m->batch != NULL && m->action[i].place < 0) {
        m->action[i].place = m->nplaced;
        m->at[m->nplaced] = i;
        stein_batch_put(m->batch, m->nplaced++, m->action[i].sim, NULL);
    }
}

/* the last place moves up, so that lanes stay full */
static void leave(instrument *m, int i)
{
    int place = m->action[i].place, last = --m->nplaced, moved = m->at[last];
    stein_batch_put(m->batch, place, NULL, NULL);
    stein_batch_put(m->batch, last, NULL, NULL);
    m->action[i].place = -1;
    if (moved != i) {
        m->action[moved].place = place;
        m->at[place] = moved;
        stein_batch_put(m->batch, place, m->action[moved].sim, NULL);
    }
}

static instrument *build(manner how)
{
    const stein_model *model = &stein_model_stein1788;
    instrument *m = bench_alloc(sizeof *m);
    stein_sim_def def = stein_sim_def_default(model);
    stein_err err;
    def.integrator = STEIN_RK4;
    def.dt = 1.0 / RATE;
    m->manner = how;
    m->seed = 61;
    if (how != ALONE) {
        bench_need(stein_batch_create(&m->batch, model, &def, ACTIONS, 0, &err), &err, "batch");
    }
    for (int i = 0; i < ACTIONS; i++) {
        action *a = &m->action[i];
        bench_need(stein_sim_create(&a->sim, model, &def, &err), &err, model->name);
        // no two alike: regulation and hammers
        bench_need(stein_set(a->sim, "pawl.stop_shift", -9e-4 + 1.5e-5 * i, &err), &err, "dx");
        bench_need(stein_set(a->sim, "hammer.mass", 2.9e-3 - 1e-5 * i, &err), &err, "mass");
        bench_need(stein_reset(a->sim, &err), &err, "reset");
        a->start = bench_alloc(stein_state_size(a->sim));
        stein_save(a->sim, a->start);
        stein_load_lift(a->sim);
        a->place = -1;
        if (how == LANES) {
            enter(m, i);
        }
    }
    return m;
}

static stein_sim *sim_of(instrument *m, int i)
{
    action *a = &m->action[i];
    return a->place >= 0 ? stein_batch_sim(m->batch, a->place) : a->sim;
}

/* strokes that begin, keys that are let go, actions that have come to rest */
static void play(instrument *m)
{
    if (chance(m) < strokes_a_second * BLOCK / RATE) {
        int i = (int)(ACTIONS * chance(m));
        double held = 0.1 + 0.4 * chance(m);
        action *a = &m->action[i];
        if (!a->moves) {
            stein_restore(sim_of(m, i), a->start, NULL);
            a->held = held;
            a->moves = 1;
            enter(m, i);
        }
    }
    for (int i = 0; i < ACTIONS; i++) {
        action *a = &m->action[i];
        double t = stein_time(a->sim);
        if (a->moves && stein_load_present(a->sim) && t >= a->held) {
            stein_load_lift(sim_of(m, i));
        } else if (a->moves && !stein_load_present(a->sim) && t >= a->held + shortest_rest) {
            const stein_sim *sim = a->place >= 0 ? stein_batch_look(m->batch, a->place) : a->sim;
            const double *qd = stein_qd(sim);
            a->moves = fabs(qd[0]) + fabs(qd[1]) + fabs(qd[2]) > still;
            if (!a->moves && m->manner == ASLEEP) {
                leave(m, i);
            }
        }
    }
}

static void block(instrument *m)
{
    double end[ACTIONS] = {0.0};
    stein_err err;
    play(m);
    for (int i = 0; i < ACTIONS; i++) {
        action *a = &m->action[i];
        double to = stein_time(a->sim) + (double)BLOCK / RATE;
        if (a->place >= 0) {
            end[a->place] = to;
        } else if (m->manner == ALONE) {
            bench_need(stein_run(a->sim, to, &err), &err, "block");
        }
    }
    if (m->batch != NULL) {
        bench_need(stein_batch_run(m->batch, end, NULL, &err), &err, "block in lanes");
    }
}

/* seconds of music a second of CPU, over `blocks` */
static double speed(instrument *m, int blocks)
{
    double start = bench_clock();
    for (int k = 0; k < blocks; k++) {
        block(m);
    }
    return 1e9 * blocks * BLOCK / RATE / (bench_clock() - start);
}

/* the moving actions of two instruments that played the same */
static int count_different(instrument *a, instrument *b)
{
    size_t size = stein_state_size(a->action[0].sim);
    void *x = bench_alloc(size), *y = bench_alloc(size);
    int different = 0;
    for (int i = 0; i < ACTIONS; i++) {
        if (a->action[i].moves != b->action[i].moves) {
            different++;
        } else if (a->action[i].moves) {
            stein_save(sim_of(a, i), x);
            stein_save(sim_of(b, i), y);
            different += memcmp(x, y, size) != 0;
        }
    }
    free(x);
    free(y);
    return different;
}

static void demolish(instrument *m)
{
    stein_batch_destroy(m->batch);
    for (int i = 0; i < ACTIONS; i++) {
        stein_sim_destroy(m->action[i].sim);
        free(m->action[i].start);
    }
    free(m);
}

void instrument_rows(void)
{
    instrument *m[3];
    double figure[3][REPEATS];
    int moving = 0;
    for (int k = 0; k < 3; k++) {
        m[k] = build((manner)k);
        (void)speed(m[k], 300); // the first keys are down
    }
    for (int r = 0; r < REPEATS; r++) {
        for (int k = 0; k < 3; k++) {
            figure[k][r] = speed(m[k], BLOCKS);
        }
        for (int i = 0; i < ACTIONS; i++) {
            moving += m[ALONE]->action[i].moves;
        }
        bench_check("the instrument in lanes (actions with other bits)",
                    count_different(m[ALONE], m[LANES]), 0.0);
        bench_check("the instrument with actions asleep (actions with other bits)",
                    count_different(m[ALONE], m[ASLEEP]), 0.0);
    }
    printf("\n61 actions at 48 kHz, RK4, blocks of 64 frames: %.1f of them move at a time\n",
           (double)moving / REPEATS);
    bench_row("61 actions, all stepped, alone: times real time", figure[ALONE], REPEATS, 1.0, 1);
    bench_row("61 actions, all stepped, in lanes: times real time", figure[LANES], REPEATS, 1.0, 1);
    bench_row("61 actions in lanes, those at rest asleep: times real time", figure[ASLEEP], REPEATS,
              4.0, 1);
    for (int k = 0; k < 3; k++) {
        demolish(m[k]);
    }
}
