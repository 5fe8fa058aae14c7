/* SPDX-License-Identifier: GPL-3.0-or-later
 * handover.c - one thread turns knobs, one steps a stroke; built with the thread sanitizer, which
 * ends it with an error when the two touch the same memory unordered. With `racy` the knobs go
 * straight into the simulation, which has to be found.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "stein/handover.h"

extern const stein_model stein_model_stein1788;

enum { SETS = 20000, STEPS = 5000 };

typedef struct shared {
    stein_sim *sim;
    stein_handover *handover;
    atomic_int published;
    int racy;
} shared;

static double shift(int i)
{
    return -1e-6 * (i % 1000);
}

static void *turn_knobs(void *ctx)
{
    shared *s = ctx;
    for (int i = 1; i <= SETS; i++) {
        if (s->racy) {
            stein_set(s->sim, "pawl.stop_shift", shift(i), NULL);
            continue;
        }
        stein_handover_set(s->handover, "pawl.stop_shift", shift(i), NULL);
        stein_handover_set(s->handover, "string.height", 0.05 + shift(i), NULL);
        stein_handover_publish(s->handover);
        atomic_store_explicit(&s->published, i, memory_order_relaxed);
    }
    return NULL;
}

/* 1 when both knobs are of one set */
static int whole(const stein_sim *sim)
{
    double dx = 0.0, height = 0.0;
    stein_get(sim, "pawl.stop_shift", &dx, NULL);
    stein_get(sim, "string.height", &height, NULL);
    return height == 0.05 + dx;
}

int main(int argc, char **argv)
{
    shared s = {.racy = argc > 1 && strcmp(argv[1], "racy") == 0};
    stein_err err = {STEIN_OK, ""};
    pthread_t thread;
    int taken = 0, torn = 0;
    if (stein_sim_create(&s.sim, &stein_model_stein1788, NULL, &err) != STEIN_OK ||
        stein_handover_create(&s.handover, &stein_model_stein1788, NULL, &err) != STEIN_OK ||
        pthread_create(&thread, NULL, turn_knobs, &s) != 0) {
        return fprintf(stderr, "%s\n", err.msg), 1;
    }
    stein_status status = STEIN_OK;
    for (int i = 0; i < STEPS && status == STEIN_OK; i++) {
        if (!s.racy && stein_handover_take(s.handover, s.sim)) {
            taken++;
            torn += !whole(s.sim);
        }
        status = stein_step(s.sim, &err);
    }
    pthread_join(thread, NULL);
    taken += stein_handover_take(s.handover, s.sim);
    printf("%d sets, %d taken, %d torn, %s\n", SETS, taken, torn, stein_status_text(status));
    int wrong = torn > 0 || (!s.racy && taken == 0);
    stein_handover_destroy(s.handover);
    stein_sim_destroy(s.sim);
    return wrong;
}
