/* SPDX-License-Identifier: GPL-3.0-or-later
 * row.c - strokes side by side, in the lanes of one thread.
 *
 * A row has a seat for each lane, with a simulation of its own:
 *
 *      job -> a free seat: ask (parameters, start) ... steps, side by side ... take (what came out)
 *
 * A seat whose job is over is free at once, so no lane waits. A job has the same bits whatever
 * runs beside it. A stroke with a recorded input is a run from each of its
 * samples to the next. Strokes with a force of the bench's, or down the ladder, have the thread for
 * themselves.
 */
#include "row.h"

#include <stdlib.h>

stein_status fit__row_make(fit__row *r, const fit__problem *p, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    stein_sim_def def = lab_def(p->model);
    def.integrator = STEIN_DP5;
    *r = (fit__row){.p = p, .n = p->lanes > 0 ? p->lanes : stein_batch_width(m)};
    r->seat = calloc((size_t)r->n, sizeof *r->seat);
    return r->seat == NULL ? lab__no_memory(err)
                           : stein_batch_create(&r->batch, m, &def, r->n, p->lanes, err);
}

void fit__row_free(fit__row *r)
{
    stein_batch_destroy(r->batch);
    for (int i = 0; r->seat != NULL && i < r->n; i++) {
        if (r->seat[i].made) {
            fit__bench_free(&r->seat[i].bench);
        }
    }
    free(r->seat);
}

/* the job in a seat is over */
static stein_status get_up(fit__row *r, int i, int failed, stein_err *err)
{
    fit__seat *s = &r->seat[i];
    (void)stein_batch_put(r->batch, i, NULL, NULL);
    r->taken -= s->taken;
    s->taken = 0;
    r->over = s->jobs;
    s->jobs->take(s->jobs->ctx, &s->bench, s->job, failed);
    return s->bench.no_memory ? lab__no_memory(err) : STEIN_OK;
}

/* the next run of a job begins, or the job is over */
static stein_status next_run(fit__row *r, int i, stein_status status, stein_err *err)
{
    fit__seat *s = &r->seat[i];
    stein_pace *pace;
    double t_end;
    if (status == STEIN_OK && fit__next_run(&s->bench, &t_end, &pace)) {
        status = stein_batch_begin(r->batch, i, t_end, pace, NULL);
        if (status == STEIN_OK) {
            return STEIN_OK;
        }
    }
    return get_up(r, i, fit__finish(&s->bench, status) != STEIN_OK, err);
}

stein_status fit__row_go(fit__row *r, stein_err *err)
{
    stein_status status;
    int i = stein_batch_go(r->batch, &status, NULL);
    r->over = NULL;
    return next_run(r, i, status, err);
}

stein_status fit__row_begin(fit__row *r, fit__jobs *jobs, int job, stein_err *err)
{
    int i = 0;
    while (r->seat[i].taken) {
        i++;
    }
    fit__seat *s = &r->seat[i];
    r->over = NULL;
    if (!s->made) {
        stein_status made = fit__bench_make(&s->bench, r->p, err);
        if (made != STEIN_OK) {
            fit__bench_free(&s->bench);
            return made;
        }
        s->made = 1;
    }
    s->jobs = jobs;
    s->job = job;
    stein_status status = jobs->ask(jobs->ctx, &s->bench, job);
    if (status == STEIN_OK && fit__can_ride(&s->bench)) {
        s->taken = 1;
        r->taken++;
        status = stein_batch_put(r->batch, i, s->bench.sim, NULL);
        return next_run(r, i, status, err);
    }
    if (status == STEIN_OK) {
        status = fit__finish(&s->bench, fit__alone(&s->bench));
    }
    s->bench.no_memory |= status == STEIN_ENOMEM;
    return get_up(r, i, status != STEIN_OK, err);
}
