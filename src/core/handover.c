/* SPDX-License-Identifier: MIT
 * handover.c - parameters from another thread: a triple buffer and limited rates.
 *
 *      own copy --copy--> slot[back]   slot in `shared`   slot[front] --> simulation
 *                              \_______exchange___/  \___exchange____/
 *
 * Each side owns one slot, the third one lies in `shared` together with a bit that says whether it
 * is newer than what was taken. The exchange releases what was written into the slot and acquires
 * what the other side did with it before, so that plain loads and stores are enough inside.
 *
 * A value that was never set is no number in the slots, and is left alone.
 */
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "core.h"
#include "stein/handover.h"

enum { SLOTS = 3, SLOT = 3, NEW = 4 };

_Static_assert(ATOMIC_INT_LOCK_FREE == 2, "the exchange has to be free of locks");

struct stein_handover {
    const stein_model *model;
    void (*release)(void *ctx, void *block);
    void *ctx;
    double *own;         /* [2*np] wanted values, then paces, of the side that publishes */
    double *slot[SLOTS]; /* [2*np] the same */
    int back;            /* slot of the side that publishes */
    atomic_int shared;   /* slot between the sides, | NEW */
    int front;           /* slot of the side that takes */
    int moving;          /* parameters are on their way */
    double t;            /* simulated time of the last take [s]; no number: none yet */
};

stein_status stein_handover_create(stein_handover **out, const stein_model *model,
                                   const stein_sim_def *def, stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    size_t n = 2 * (size_t)model->np, head = (sizeof(stein_handover) + 15u) / 16u * 16u;
    unsigned char *block = own.alloc(own.ctx, head + (SLOTS + 1) * n * sizeof(double));
    if (block == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory for a hand-over of \"%s\"",
                           model->name);
    }
    stein_handover *h = (stein_handover *)(void *)block;
    double *numbers = (double *)(void *)(block + head);
    *h = (stein_handover){.model = model, .release = own.release, .ctx = own.ctx, .t = NAN};
    h->own = numbers;
    for (size_t i = 0; i < n; i++) {
        h->own[i] = i < n / 2 ? (double)NAN : (double)INFINITY;
    }
    for (int i = 0; i < SLOTS; i++) {
        h->slot[i] = numbers + (size_t)(i + 1) * n;
        memcpy(h->slot[i], h->own, n * sizeof(double));
    }
    h->back = 1;
    h->front = 2;
    atomic_init(&h->shared, 0);
    *out = h;
    return STEIN_OK;
}

void stein_handover_destroy(stein_handover *h)
{
    if (h != NULL) {
        h->release(h->ctx, h);
    }
}

/* ---- the side that publishes ---- */

static int find(const stein_handover *h, const char *name, stein_err *err)
{
    int i = stein_find_param(h->model, name);
    if (i < 0) {
        stein__fail(err, STEIN_ENAME, "no parameter \"%s\" in model \"%s\"", name, h->model->name);
    }
    return i;
}

stein_status stein_handover_set(stein_handover *h, const char *name, double value, stein_err *err)
{
    int i = find(h, name, err);
    if (i < 0) {
        return STEIN_ENAME;
    }
    stein_status status = stein__check_param(&h->model->params[i], value, err);
    if (status == STEIN_OK) {
        h->own[i] = value;
    }
    return status;
}

stein_status stein_handover_pace(stein_handover *h, const char *name, double rate, stein_err *err)
{
    int i = find(h, name, err);
    if (i < 0) {
        return STEIN_ENAME;
    }
    if (!(rate > 0.0)) {
        return stein__fail(err, STEIN_EINVAL,
                           "parameter \"%s\" cannot move by %g a second: expected a positive rate",
                           name, rate);
    }
    h->own[h->model->np + i] = rate;
    return STEIN_OK;
}

void stein_handover_publish(stein_handover *h)
{
    memcpy(h->slot[h->back], h->own, 2 * (size_t)h->model->np * sizeof(double));
    h->back = SLOT & atomic_exchange_explicit(&h->shared, h->back | NEW, memory_order_acq_rel);
}

/* ---- the side that steps ---- */

/* the parameter where it may be `elapsed` later */
static double towards(double from, double wanted, double rate, double elapsed)
{
    double most = rate * elapsed;
    if (!(fabs(wanted - from) > most)) { // also where the rate is without limit and no time passed
        return wanted;
    }
    return wanted > from ? from + most : from - most;
}

/* move all of them; 1 when one has moved */
static int move(stein_handover *h, stein_sim *sim, double elapsed)
{
    int np = h->model->np, moved = 0;
    const double *wanted = h->slot[h->front], *rate = wanted + np;
    h->moving = 0;
    for (int i = 0; i < np; i++) {
        if (isnan(wanted[i]) || wanted[i] == sim->p[i]) {
            continue;
        }
        double to = towards(sim->p[i], wanted[i], rate[i], elapsed);
        moved = moved || to != sim->p[i];
        sim->p[i] = to;
        h->moving = h->moving || to != wanted[i];
    }
    return moved;
}

int stein_handover_take(stein_handover *h, stein_sim *sim)
{
    double t = sim->head->t, elapsed = t > h->t ? t - h->t : 0.0;
    h->t = t;
    if (atomic_load_explicit(&h->shared, memory_order_relaxed) & NEW) {
        h->front = SLOT & atomic_exchange_explicit(&h->shared, h->front, memory_order_acq_rel);
        h->moving = 1;
    }
    if (!h->moving || !move(h, sim, elapsed)) {
        return 0;
    }
    stein__take_parameters(sim);
    return 1;
}
