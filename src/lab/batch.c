/* SPDX-License-Identifier: GPL-3.0-or-later
 * batch.c - many simulations of one model, on the threads of a crew.
 *
 * Each point gets a simulation made from a descriptor whose defaults are the point's parameters -
 * as if the file had said so. Nothing of one point reaches another one, so any number of threads
 * gives the same bits, and a parameter set without equilibrium fails alone. Creating a simulation
 * costs one allocation, nothing beside a stroke.
 */
#include <stdlib.h>
#include <string.h>

#include "inner.h"

/* what a thread has of its own */
typedef struct bench {
    stein_model model; /* params are the ones below */
    stein_param *params;
    double *p;
} bench;

static void put_away(void *bench_)
{
    bench *t = bench_;
    if (t != NULL) {
        free(t->params);
        free(t->p);
        free(t);
    }
}

static stein_status set_up(void *ctx, void **bench_, stein_err *err)
{
    const lab__batch *b = ctx;
    bench *t = calloc(1, sizeof *t);
    *bench_ = t;
    if (t != NULL) {
        t->model = *lab_equations(b->model);
        size_t np = (size_t)t->model.np;
        t->params = malloc(sizeof *t->params * (np + 1));
        t->p = malloc(sizeof *t->p * (np + 1));
    }
    if (t == NULL || t->params == NULL || t->p == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    memcpy(t->params, t->model.params, sizeof *t->params * (size_t)t->model.np);
    t->model.params = t->params;
    return STEIN_OK;
}

static stein_status work_on(void *ctx, void *bench_, int point, stein_err *err)
{
    const lab__batch *b = ctx;
    bench *t = bench_;
    stein_sim *sim = NULL;
    memcpy(t->p, lab_parameters(b->model), sizeof *t->p * (size_t)t->model.np);
    b->set(b->ctx, point, t->p);
    for (int i = 0; i < t->model.np; i++) {
        t->params[i].value = t->p[i];
    }
    stein_status status = stein_sim_create(&sim, &t->model, NULL, err);
    if (status == STEIN_ENOMEM) {
        return status;
    }
    status = b->run(b->ctx, point, sim, status, err);
    stein_sim_destroy(sim);
    return status;
}

stein_status lab__batch_run(const lab__batch *batch, stein_err *err)
{
    lab__batch b = *batch;
    const lab__crew crew = {.n = b.n,
                            .threads = b.threads,
                            .skip = b.skip,
                            .begin = set_up,
                            .work = work_on,
                            .end = put_away,
                            .progress = b.progress,
                            .progress_ctx = b.progress_ctx,
                            .ctx = &b};
    return lab__crew_run(&crew, err);
}
