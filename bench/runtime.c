/* SPDX-License-Identifier: GPL-3.0-or-later
 * runtime.c - evaluations, steps and strokes, alone and in lanes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

enum { STROKES = 16, SWEEPS = 5 };
static const double stroke_end = 0.12; /* [s] */

typedef struct probe {
    stein_sim *sim;
    stein_handover *handover; /* NULL: parameters stay */
    bench_states states;
} probe;

static double run_mass_bias(void *ctx, long n)
{
    probe *p = ctx;
    double M[BENCH_NQ * BENCH_NQ], bias[BENCH_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_mass_bias(p->sim, p->states.q[i % BENCH_STATES], p->states.qd[i % BENCH_STATES], NULL,
                        NULL, M, bias);
        sum += M[0] + bias[0];
    }
    return sum;
}

static double run_inverse(void *ctx, long n)
{
    probe *p = ctx;
    double Q[BENCH_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_inverse(p->sim, p->states.q[i % BENCH_STATES], p->states.qd[i % BENCH_STATES],
                      p->states.qd[(i + 1) % BENCH_STATES], NULL, NULL, Q);
        sum += Q[0];
    }
    return sum;
}

static double run_acceleration(void *ctx, long n)
{
    probe *p = ctx;
    double qdd[BENCH_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_acceleration(p->sim, 0.0, p->states.q[i % BENCH_STATES],
                           p->states.qd[i % BENCH_STATES], qdd, NULL);
        sum += qdd[0];
    }
    return sum;
}

/* steps of the stroke, started again whenever it is over */
static double run_steps(void *ctx, long n)
{
    probe *p = ctx;
    for (long i = 0; i < n; i++) {
        if (stein_time(p->sim) > stroke_end) {
            stein_reset(p->sim, NULL);
        }
        stein_step(p->sim, NULL);
    }
    return stein_q(p->sim)[0];
}

static double run_stroke(void *ctx, long n)
{
    probe *p = ctx;
    for (long i = 0; i < n; i++) {
        stein_reset(p->sim, NULL);
        stein_run(p->sim, stroke_end, NULL);
    }
    return stein_q(p->sim)[0];
}

/* spans of time that a host waits for: 16 steps of 4 samples, 100 steps of 10 us */
static double run_blocks(void *ctx, long n)
{
    probe *p = ctx;
    int steps = stein_dt(p->sim) > 5e-5 ? 16 : 100;
    for (long i = 0; i < n; i++) {
        run_steps(ctx, steps);
    }
    return stein_q(p->sim)[0];
}

static double run_take(void *ctx, long n)
{
    static const double dx[] = {-0.3e-3, -0.1e-3};
    probe *p = ctx;
    for (long i = 0; i < n; i++) {
        stein_handover_set(p->handover, "pawl.stop_shift", dx[i % 2], NULL);
        stein_handover_publish(p->handover);
        stein_handover_take(p->handover, p->sim);
    }
    return stein_q(p->sim)[0];
}

static probe *make_probe(const stein_model *model, stein_integrator integrator, double dt)
{
    probe *p = bench_alloc(sizeof *p);
    stein_sim_def def = stein_sim_def_default(model);
    stein_err err;
    def.integrator = integrator;
    def.dt = dt;
    bench_need(stein_sim_create(&p->sim, model, &def, &err), &err, model->name);
    bench_fill_states(&p->states, p->sim);
    return p;
}

static bench_case *add(const char *group, const stein_model *model, const char *what,
                       bench_run *run, stein_integrator integrator)
{
    return bench_add(group, model->name, what, run, make_probe(model, integrator, model->dt));
}

/* ---- a sweep of dx: strokes one after the other, and in lanes ---- */

typedef struct sweep {
    stein_sim *sim[STROKES];
    void *start[STROKES]; /* state of each at its beginning */
    stein_batch *batch;   /* NULL: one after the other */
} sweep;

static sweep *make_sweep(stein_integrator integrator, int width)
{
    const stein_model *model = &stein_model_stein1788;
    sweep *s = bench_alloc(sizeof *s);
    stein_sim_def def = stein_sim_def_default(model);
    stein_err err;
    def.integrator = integrator;
    if (width > 1) {
        bench_need(stein_batch_create(&s->batch, model, &def, STROKES, width, &err), &err, "batch");
    }
    for (int i = 0; i < STROKES; i++) {
        bench_need(stein_sim_create(&s->sim[i], model, &def, &err), &err, model->name);
        double dx = -1.25e-3 + 1.45e-3 * i / (STROKES - 1);
        bench_need(stein_set(s->sim[i], "pawl.stop_shift", dx, &err), &err, "dx");
        bench_need(stein_reset(s->sim[i], &err), &err, "reset");
        s->start[i] = bench_alloc(stein_state_size(s->sim[i]));
        stein_save(s->sim[i], s->start[i]);
    }
    return s;
}

static double run_sweep(void *ctx, long n)
{
    sweep *s = ctx;
    double end[STROKES], sum = 0.0;
    for (long k = 0; k < n; k += STROKES) {
        for (int i = 0; i < STROKES; i++) {
            end[i] = stroke_end;
            stein_restore(s->sim[i], s->start[i], NULL);
            if (s->batch != NULL) {
                stein_batch_put(s->batch, i, s->sim[i], NULL);
            } else {
                stein_run(s->sim[i], stroke_end, NULL);
            }
        }
        if (s->batch != NULL) {
            stein_batch_run(s->batch, end, NULL, NULL);
        }
        for (int i = 0; i < STROKES; i++) {
            (void)(s->batch != NULL ? stein_batch_look(s->batch, i) : NULL);
            sum += stein_q(s->sim[i])[0];
        }
    }
    return sum;
}

/* the last states of both, to the last bit */
static void check_sweep(sweep *alone, sweep *lanes, const char *what)
{
    int wrong = 0;
    run_sweep(alone, STROKES);
    run_sweep(lanes, STROKES);
    size_t size = stein_state_size(alone->sim[0]);
    void *a = bench_alloc(size), *b = bench_alloc(size);
    for (int i = 0; i < STROKES; i++) {
        stein_save(alone->sim[i], a);
        stein_save(lanes->sim[i], b);
        wrong += memcmp(a, b, size) != 0;
    }
    free(a);
    free(b);
    bench_check(what, wrong, 0.0);
}

static bench_case *audio, *haptic;
static bench_case *rk4_alone, *rk4_lanes, *dp5_alone, *dp5_lanes;

static bench_case *add_sweep(const char *what, sweep *s)
{
    bench_case *c = bench_add("batch", stein_model_stein1788.name, what, run_sweep, s);
    if (c != NULL) {
        c->least = STROKES;
    }
    return c;
}

static void add_sweeps(void)
{
    int width = stein_batch_width(&stein_model_stein1788);
    sweep *s = make_sweep(STEIN_RK4, 1), *l = make_sweep(STEIN_RK4, width);
    check_sweep(s, l, "a sweep with RK4 in lanes (strokes with other bits)");
    rk4_alone = add_sweep("stroke of a sweep of dx, RK4", s);
    rk4_lanes = add_sweep("stroke of a sweep of dx, RK4 in lanes", l);
    s = make_sweep(STEIN_DP5, 1);
    l = make_sweep(STEIN_DP5, width);
    check_sweep(s, l, "a sweep with DP5 in lanes (strokes with other bits)");
    dp5_alone = add_sweep("stroke of a sweep of dx, DP5", s);
    dp5_lanes = add_sweep("stroke of a sweep of dx, DP5 in lanes", l);
}

static void add_realtime(const stein_model *stein)
{
    audio = bench_add("realtime", stein->name, "audio block, 64 at 48 kHz, one key", run_blocks,
                      make_probe(stein, STEIN_RK4, 4.0 / 48000.0));
    haptic = add("realtime", stein, "haptic tick of 1 ms", run_blocks, STEIN_RK4);
    probe *p = make_probe(stein, STEIN_RK4, stein->dt);
    stein_err err;
    bench_need(stein_handover_create(&p->handover, stein, NULL, &err), &err, "handover");
    bench_add("realtime", stein->name, "a parameter handed over", run_take, p);
}

void runtime_add(void)
{
    for (int i = 0; stein_models[i] != NULL; i++) {
        const stein_model *model = stein_models[i];
        bench_case *c = add("equations", model, "M and c", run_mass_bias, STEIN_RK4);
        if (c != NULL) {
            c->ops = &model->ops_unloaded;
        }
        c = add("equations", model, "inverse dynamics", run_inverse, STEIN_RK4);
        if (c != NULL) {
            c->ops = &model->ops_inverse;
        }
    }
    const stein_model *stein = &stein_model_stein1788;
    add("runtime", stein, "qdd, all contacts evaluated", run_acceleration, STEIN_RK4);
    add("runtime", stein, "step of RK4 (mean over a stroke)", run_steps, STEIN_RK4);
    add("runtime", stein, "step of DP5 (mean over a stroke)", run_steps, STEIN_DP5);
    add("runtime", stein, "stroke of 0.12 s, RK4", run_stroke, STEIN_RK4);
    add("runtime", stein, "stroke of 0.12 s, DP5", run_stroke, STEIN_DP5);
    add_realtime(stein);
    add_sweeps();
}

/* ---- a whole sweep as the lab does it, judged and re-armed ---- */

static double sweep_alone(lab_model *model, lab_point *point)
{
    stein_err err;
    double start = bench_clock();
    for (int i = 0; i < STROKES; i++) {
        stein_sim *sim = NULL;
        lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
        bench_need(lab_sim(model, NULL, &sim, &err), &err, "simulation");
        bench_need(stein_set(sim, "pawl.stop_shift", point[i].dx, &err), &err, "dx");
        bench_need(stein_reset(sim, &err), &err, "reset");
        bench_need(lab_strike(sim, &def, &point[i].stroke, &err), &err, "stroke");
        stein_sim_destroy(sim);
    }
    return bench_clock() - start;
}

static double sweep_in_lanes(lab_model *model, lab_point *point)
{
    stein_err err;
    double start = bench_clock();
    bench_need(lab_sweep(model, point, STROKES, 1, NULL, NULL, &err), &err, "sweep");
    return bench_clock() - start;
}

static void sweep_row(void)
{
    lab_model *model = NULL;
    stein_err err;
    lab_point alone[STROKES], lanes[STROKES];
    double ratio[SWEEPS];
    int wrong = 0;
    bench_need(lab_open(&model, "models/stein1788.yaml", NULL, &err), &err, "stein1788");
    memset(alone, 0, sizeof alone);
    for (int i = 0; i < STROKES; i++) {
        alone[i].dx = -1.25e-3 + 1.45e-3 * i / (STROKES - 1);
    }
    memcpy(lanes, alone, sizeof lanes);
    for (int k = 0; k < SWEEPS; k++) {
        double ns = sweep_alone(model, alone);
        ratio[k] = ns / sweep_in_lanes(model, lanes);
    }
    for (int i = 0; i < STROKES; i++) {
        const lab_stroke *a = &alone[i].stroke, *b = &lanes[i].stroke;
        wrong += a->outcome != b->outcome || a->escape_time != b->escape_time ||
                 a->impact_speed != b->impact_speed || a->rearmed != b->rearmed ||
                 a->peak_string_force != b->peak_string_force;
    }
    bench_check("a sweep of the lab in lanes (strokes with other figures)", wrong, 0.0);
    bench_row("strokes per second of a sweep of dx by the lab, lanes : alone", ratio, SWEEPS, 5.0,
              1);
    lab_close(model);
}

void runtime_rows(void)
{
    char what[96];
    int width = stein_batch_width(&stein_model_stein1788);
    if (audio != NULL && haptic != NULL) {
        printf("\none key: an audio block takes %.1f %% of its time, a haptic tick %.1f %%\n",
               1e-7 * bench_median(audio) / (64.0 / 48000.0), 1e-7 * bench_median(haptic) / 1e-3);
    }
    snprintf(what, sizeof what, "strokes per second, RK4, %d lanes : alone", width);
    bench_ratio(what, rk4_alone, rk4_lanes, 1.0, 5.0, 1);
    snprintf(what, sizeof what, "strokes per second, DP5, %d lanes : alone", width);
    bench_ratio(what, dp5_alone, dp5_lanes, 1.0, 5.0, 1);
    if (rk4_alone != NULL && rk4_lanes != NULL) {
        printf("\nstrokes of %g s a second, RK4: %.0f alone, %.0f in %d lanes\n", stroke_end,
               1e9 / bench_median(rk4_alone), 1e9 / bench_median(rk4_lanes), width);
        sweep_row();
    }
}
