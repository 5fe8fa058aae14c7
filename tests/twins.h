/* SPDX-License-Identifier: GPL-3.0-or-later
 * twins.h - the same simulations twice: some alone, the others in the lanes of a batch, which have
 * to agree to the last bit.
 */
#ifndef TWINS_H
#define TWINS_H

#include <stdlib.h>
#include <string.h>

#include "stein/batch.h"
#include "support.h"

enum { PLACES = 11, MAX_EVENTS = 2000, MAX_STATE = 4096 };

/* events of a subscriber, as numbers */
typedef struct heard {
    int n;
    stein_event event[MAX_EVENTS];
} heard;

/* the same simulation twice, one of them for a batch */
typedef struct twins {
    stein_sim *alone[PLACES], *rider[PLACES];
    heard *of_alone, *of_rider; /* [PLACES] */
    stein_batch *batch;
    int width;
} twins;

static const int widths[] = {1, 2, 4, 8};

static inline void hear(void *ctx, stein_sim *sim, const stein_event *event)
{
    heard *h = ctx;
    (void)sim;
    ck_assert_int_lt(h->n, MAX_EVENTS);
    h->event[h->n++] = *event;
}

static inline void set(stein_sim *sim, const char *name, double value)
{
    ck_assert_stein(stein_set(sim, name, value, err));
}

/* does this processor have so many lanes? */
static inline int has_width(const stein_model *model, int width)
{
    stein_batch *batch = NULL;
    if (stein_batch_create(&batch, model, NULL, 1, width, NULL) != STEIN_OK) {
        printf("no %d lanes on this processor: skipped\n", width);
        return 0;
    }
    stein_batch_destroy(batch);
    return 1;
}

static inline void make_twins(twins *t, const stein_model *model, stein_integrator integrator,
                              int width, void (*shape)(stein_sim *sim, int i))
{
    stein_sim_def def = stein_sim_def_default(model);
    def.integrator = integrator;
    *t = (twins){.of_alone = calloc(PLACES, sizeof(heard)),
                 .of_rider = calloc(PLACES, sizeof(heard)),
                 .width = width};
    ck_assert(t->of_alone != NULL && t->of_rider != NULL);
    ck_assert_stein(stein_batch_create(&t->batch, model, &def, PLACES, width, err));
    for (int i = 0; i < PLACES; i++) {
        double dt = model->dt * (1.0 + 0.137 * (i % 3));
        for (int k = 0; k < 2; k++) {
            stein_sim **sim = k ? &t->rider[i] : &t->alone[i];
            *sim = make_sim(model, integrator, dt);
            shape(*sim, i);
            stein_on_event(*sim, hear, k ? &t->of_rider[i] : &t->of_alone[i]);
        }
        ck_assert_stein(stein_batch_put(t->batch, i, t->rider[i], err));
    }
}

static inline void drop_twins(twins *t)
{
    stein_batch_destroy(t->batch);
    for (int i = 0; i < PLACES; i++) {
        stein_sim_destroy(t->alone[i]);
        stein_sim_destroy(t->rider[i]);
    }
    free(t->of_alone);
    free(t->of_rider);
}

/* everything that a simulation is and has told, bit for bit */
static inline void compare_twins(twins *t)
{
    static unsigned char a[MAX_STATE], b[MAX_STATE];
    for (int i = 0; i < PLACES; i++) {
        stein_sim *alone = t->alone[i], *rider = stein_batch_look(t->batch, i);
        const stein_model *model = stein_sim_model(alone);
        ck_assert_ptr_eq(rider, t->rider[i]);
        ck_assert_uint_le(stein_state_size(alone), sizeof a);
        stein_save(alone, a);
        stein_save(rider, b);
        ck_assert_msg(
            memcmp(a, b, stein_state_size(alone)) == 0,
            "%s, place %d of %d lanes: another state at t = %.17g s than alone at %.17g s",
            model->name, i, t->width, stein_time(rider), stein_time(alone));
        ck_assert_msg(
            memcmp(stein_qdd(alone), stein_qdd(rider), sizeof(double) * (size_t)model->nq) == 0,
            "%s, place %d: other accelerations", model->name, i);
        ck_assert_int_eq(t->of_alone[i].n, t->of_rider[i].n);
        for (int k = 0; k < t->of_alone[i].n; k++) { // between its members an event has any bits
            const stein_event *x = &t->of_alone[i].event[k], *y = &t->of_rider[i].event[k];
            ck_assert(x->kind == y->kind && x->index == y->index && x->phase == y->phase &&
                      memcmp(&x->time, &y->time, sizeof x->time) == 0);
        }
        for (int k = 0; k < model->nchannel; k++) {
            double x = stein_read(alone, k), y = stein_read(rider, k);
            ck_assert_msg(memcmp(&x, &y, sizeof x) == 0, "%s, place %d: %s", model->name, i,
                          model->channels[k].name);
        }
    }
}

/* both run to times of their own */
static inline void run_twins(twins *t, double until, double apart)
{
    double t_end[PLACES];
    for (int i = 0; i < PLACES; i++) {
        t_end[i] = stein_time(t->alone[i]) + until + apart * i;
        ck_assert_stein(stein_run(t->alone[i], t_end[i], err));
    }
    ck_assert_stein(stein_batch_run(t->batch, t_end, NULL, err));
    compare_twins(t);
}

/* strokes that differ from each other */
static inline void regulate(stein_sim *sim, int i)
{
    set(sim, "pawl.stop_shift", -1.3e-3 + 0.155e-3 * i);
    ck_assert_stein(stein_reset(sim, err));
}

#endif
