/* SPDX-License-Identifier: MIT
 * batch.c - which simulation is in which lane, and which is alone.
 *
 *      place 0 1 2 3 | 4 5 6 7 | ...      groups of as many as there are lanes
 *
 * While a simulation is in a lane, its q, qd, qdd are there; time, step counter and contact modes
 * stay in the simulation, where they are cheap to keep. A lane that does not take a step hands its
 * simulation back, it steps alone, and the lane takes it in again.
 */
#include <string.h>

#include "batch_inner.h"

/* ---- what there is ---- */

static const stein__width *width_of(const stein_model *model, int most)
{
    int has = stein__processor_lanes(), lanes = has < most ? has : most;
    if (model->solve == NULL || model->nstick > 0 || lanes < 2) {
        return NULL;
    }
#if STEIN_WIDEST == 8
    if (lanes >= 8 && model->lanes[2] != NULL) {
        return &stein__width8;
    }
    if (lanes >= 4 && model->lanes[1] != NULL) {
        return &stein__width4;
    }
#endif
#if STEIN_WIDEST >= 2
    if (model->lanes[0] != NULL) {
        return &stein__width2;
    }
#endif
    return NULL;
}

int stein_batch_width(const stein_model *model)
{
    const stein__width *w = width_of(model, MAX_LANES);
    return w != NULL ? w->lanes : 1;
}

/* ---- memory ---- */

/* a batch and its arrays in one block, at the offsets that are written into `b` */
static size_t layout(stein_batch *b, unsigned char *base)
{
    size_t used = 0, n = (size_t)b->n;
    const size_t size[] = {sizeof *b,
                           n * sizeof *b->place,
                           (size_t)b->ngroup * sizeof *b->wide,
                           n * sizeof *b->state,
                           n * sizeof *b->pace,
                           n * sizeof *b->pacer,
                           n * sizeof *b->why};
    enum { PARTS = sizeof size / sizeof *size };
    size_t at[PARTS];
    for (int i = 0; i < PARTS; i++) {
        at[i] = used;
        used += (size[i] + 15u) / 16u * 16u;
    }
    if (base != NULL) {
        b->place = (berth *)(void *)(base + at[1]);
        b->wide = (void **)(void *)(base + at[2]);
        b->state = (stein_status *)(void *)(base + at[3]);
        b->pace = (stein_pace **)(void *)(base + at[4]);
        b->pacer = (stein__pacer *)(void *)(base + at[5]);
        b->why = (stein_err *)(void *)(base + at[6]);
    }
    if (b->width != NULL) {
        size_t group = (b->width->size(b->model) + 63u) / 64u * 64u;
        for (int g = 0; g < b->ngroup && base != NULL; g++) {
            b->wide[g] =
                b->width->make(base + used + (size_t)g * group, b->model, b->def.integrator);
        }
        used += (size_t)b->ngroup * group;
    }
    return used;
}

stein_status stein_batch_create(stein_batch **out, const stein_model *model,
                                const stein_sim_def *def, int n, int width, stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    stein_batch plan = {.model = model, .def = own, .n = n};
    plan.width = width_of(model, width == 0 ? MAX_LANES : width);
    plan.lanes = plan.width != NULL ? plan.width->lanes : 1;
    plan.ngroup = (n + plan.lanes - 1) / plan.lanes;
    if (n < 1 || (width != 0 && width != plan.lanes)) {
        return stein__fail(err, STEIN_EINVAL,
                           "a batch of %d places and %d lanes: expected at least 1 place, and 1 or "
                           "up to %d lanes",
                           n, width, stein_batch_width(model));
    }
    size_t size = layout(&plan, NULL);
    stein_batch *batch = own.alloc(own.ctx, size);
    if (batch == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory for a batch of \"%s\"", model->name);
    }
    memset(batch, 0, size);
    *batch = plan;
    (void)layout(batch, (unsigned char *)batch);
    *out = batch;
    return STEIN_OK;
}

void stein_batch_destroy(stein_batch *batch)
{
    if (batch != NULL) {
        batch->def.release(batch->def.ctx, batch);
    }
}

/* ---- in and out of lanes ---- */

static int can_ride(const stein_batch *b, const stein_sim *sim)
{
    int load = b->model->load.body;
    return b->width != NULL && b->def.integrator != STEIN_IMPLICIT && sim->on_force == NULL &&
           sim->follower == NULL && !sim->jacobians &&
           (load < 0 || sim->held[load] == !sim->head->load_present);
}

void stein__batch_fetch(stein_batch *b, int i)
{
    berth *p = &b->place[i];
    if (p->seat == AWAY && b->width != NULL) {
        stein_sim *sim = p->sim;
        double error[2];
        b->width->take(b->wide[i / b->lanes], i % b->lanes, sim->q, sim->qd, sim->qdd, error);
        sim->eq = error[0];
        sim->eqd = error[1];
        sim->fresh = KNOWN;
        p->seat = SEEN;
    }
}

static void put_in_lane(stein_batch *b, int g, int lane, const stein_sim *sim, int with_d)
{
    const stein__rider rider = {.d = sim->d,
                                .q = sim->q,
                                .qd = sim->qd,
                                .qdd = sim->qdd,
                                .mode = sim->mode,
                                .load_present = sim->head->load_present,
                                .signal = sim->signal,
                                .signal_ctx = sim->signal_ctx};
    b->width->put(b->wide[g], lane, &rider, with_d);
}

/* Empty lanes get the numbers of another one, since NaN and denormals would be slow. The first lane
 * in use may be empty for now, but then its numbers are there from before. */
static void fill_rest(stein_batch *b, int g, unsigned riders)
{
    int first = 0;
    while (riders != 0 && !(riders >> first & 1)) {
        first++;
    }
    for (int k = 0; riders != 0 && k < b->lanes; k++) {
        if (!(riders >> k & 1)) {
            put_in_lane(b, g, k, b->place[g * b->lanes + first].sim, 1);
        }
    }
}

unsigned stein__batch_board(stein_batch *b, int g)
{
    unsigned riders = 0;
    int fresh = 0, first = g * b->lanes;
    for (int i = first; i < first + b->lanes && i < b->n; i++) {
        berth *p = &b->place[i];
        stein_sim *sim = p->sim;
        if (sim == NULL || p->seat == ALONE) {
            continue;
        }
        if (p->seat == CHANGED && !can_ride(b, sim)) {
            p->seat = ALONE;
            continue;
        }
        if (p->seat == CHANGED || p->seat == MOVED) {
            if (sim->fresh == STALE && stein__refresh(sim, NULL) != STEIN_OK) {
                continue; // it fails alone, and says why
            }
            put_in_lane(b, g, i - first, sim, p->seat == CHANGED);
            fresh |= p->seat == CHANGED;
            p->seat = SEEN;
        }
        riders |= 1u << (i - first);
    }
    if (fresh) {
        fill_rest(b, g, riders);
        b->width->ready(b->wide[g]);
    }
    return riders;
}

stein_status stein_batch_put(stein_batch *b, int i, stein_sim *sim, stein_err *err)
{
    if (i < 0 || i >= b->n) {
        return stein__fail(err, STEIN_EINVAL, "a batch of %d places has none with the number %d",
                           b->n, i);
    }
    if (sim != NULL &&
        (memcmp(sim->model->equations, b->model->equations, sizeof sim->head->equations) != 0 ||
         sim->def.integrator != b->def.integrator)) {
        return stein__fail(err, STEIN_EINVAL,
                           "a simulation of \"%s\" cannot go into a batch of \"%s\": equations and "
                           "integrator have to be the same",
                           sim->model->name, b->model->name);
    }
    stein__batch_fetch(b, i);
    b->place[i] = (berth){sim, CHANGED};
    b->pace[i] = NULL;
    return STEIN_OK;
}

stein_sim *stein_batch_look(stein_batch *b, int i)
{
    if (i < 0 || i >= b->n) {
        return NULL;
    }
    stein__batch_fetch(b, i);
    return b->place[i].sim;
}

stein_sim *stein_batch_sim(stein_batch *b, int i)
{
    stein_sim *sim = stein_batch_look(b, i);
    if (sim != NULL) {
        b->place[i].seat = CHANGED;
    }
    return sim;
}
