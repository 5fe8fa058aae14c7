/* SPDX-License-Identifier: GPL-3.0-or-later
 * pool.c - the study's simulations on threads, and the reference stroke they all start from.
 *
 * Strokes beyond the sweep run with RK4 at 20 us: half the cost of the file's 10 us. Measured over
 * dx = -1.25 .. 0 mm against 2.5 us: heights agree to 2e-9 m, impact times to 1e-8 s, peak forces
 * to 2e-3 N. (Dormand-Prince at 40 us costs the same and is off by 1e-6 m.)
 */
#include <math.h>
#include <string.h>

#include "study.h"

typedef struct pool_job {
    const study *s;
    const char *what;
    stein_sim_def def;
    study_job_fn *job;
    void *ctx;
} pool_job;

stein_sim_def study_def(const study *s)
{
    stein_sim_def def = lab_def(s->model);
    def.integrator = STEIN_RK4;
    def.dt = s->dt;
    return def;
}

stein_sim_def study_def_controlled(const study *s)
{
    stein_sim_def def = study_def(s);
    def.integrator = STEIN_DP5;
    return def;
}

stein_status study_sim(const study *s, stein_sim **sim, stein_err *err)
{
    const stein_sim_def def = study_def(s);
    return lab_sim(s->model, &def, sim, err);
}

static stein_status make_sim(void *ctx, void **sim, stein_err *err)
{
    const pool_job *c = ctx;
    stein_sim *made = NULL;
    stein_status status = lab_sim(c->s->model, &c->def, &made, err);
    *sim = made;
    return status;
}

static stein_status work(void *ctx, void *sim, int i, stein_err *err)
{
    const pool_job *c = ctx;
    stein_set_all(sim, lab_parameters(c->s->model), NULL); // finite: the reader saw to it
    return c->job(c->ctx, sim, i) == STEIN_ENOMEM ? lab__no_memory(err) : STEIN_OK;
}

static void drop_sim(void *sim)
{
    stein_sim_destroy(sim);
}

static void tell(void *ctx, int done, int total)
{
    const pool_job *c = ctx;
    if (c->s->progress != NULL) {
        c->s->progress(c->s->ctx, c->what, done, total);
    }
}

stein_status study_each_by(const study *s, const stein_sim_def *def, const char *what, int n,
                           study_job_fn *job, void *ctx, stein_err *err)
{
    pool_job c = {.s = s, .what = what, .def = *def, .job = job, .ctx = ctx};
    const lab__thread_pool on_threads = {.n = n,
                                         .threads = s->threads,
                                         .begin = make_sim,
                                         .work = work,
                                         .end = drop_sim,
                                         .progress = tell,
                                         .progress_ctx = &c,
                                         .ctx = &c};
    return lab__thread_pool_run(&on_threads, err);
}

stein_status study_each(const study *s, const char *what, int n, study_job_fn *job, void *ctx,
                        stein_err *err)
{
    const stein_sim_def def = study_def(s);
    return study_each_by(s, &def, what, n, job, ctx, err);
}

/* ---- the reference stroke ---- */

/* where the key is at rest and where the load leaves it; how far the load's place goes with it */
static stein_status find_key(study *s, stein_sim *sim, stein_err *err)
{
    const stein_model *m = lab_equations(s->model);
    int dip = stein_find_channel(m, "key_dip"), key = m->inputs[s->input].index;
    stein_status status = stein_reset(sim, err);
    if (status != STEIN_OK) {
        return status;
    }
    double dip_rest = stein_read(sim, dip);
    s->key_rest = stein_q(sim)[key];
    status = stein_run(sim, lab_until(s->model), err);
    s->key_down = stein_q(sim)[key];
    s->arm = (stein_read(sim, dip) - dip_rest) / (s->key_down - s->key_rest);
    if (status == STEIN_OK && !(fabs(s->arm) > 1e-4 && isfinite(s->arm))) {
        s->input = -1;
        snprintf(s->left_out, sizeof s->left_out, "the load does not move the key");
    }
    return status;
}

stein_status study_begin(study *s, stein_err *err)
{
    const stein_model *m = lab_equations(s->model);
    if (m->stroke.string < 0 || m->stroke.notch < 0 || m->load.body < 0) {
        return lab__fail(err, STEIN_EINVAL, "\"%s\" has no %s, which the study needs", m->name,
                         m->stroke.string < 0  ? "stroke (stroke: {string: ..., notch: ...})"
                         : m->stroke.notch < 0 ? "notch in its stroke"
                                               : "load");
    }
    s->input = -1;
    for (int i = 0; i < m->ninput; i++) {
        if (m->inputs[i].kind == STEIN_INPUT_MOTION &&
            strcmp(m->inputs[i].name, "key_motion") == 0) {
            s->input = i;
        }
    }
    s->left_out[0] = '\0';
    if (s->input < 0 || stein_find_channel(m, "key_dip") < 0) {
        snprintf(s->left_out, sizeof s->left_out, "the model has no %s",
                 s->input < 0 ? "input key_motion: {motion: ...}" : "output key_dip");
        s->input = -1;
    }
    stein_sim *sim = NULL;
    stein_status status = study_sim(s, &sim, err);
    if (status != STEIN_OK) {
        return status;
    }
    study_drive drive = study_drive_default();
    study_details details;
    study_strike(s, sim, &drive, NULL, &details);
    s->reference = details.stroke;
    if (details.status != STEIN_OK) {
        status = lab__fail(err, details.status, "the reference stroke of \"%s\" failed: %s",
                           m->name, stein_status_text(details.status));
    }
    if (status == STEIN_OK && s->input >= 0) {
        status = find_key(s, sim, err);
    }
    stein_sim_destroy(sim);
    return status;
}
