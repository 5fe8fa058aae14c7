/* SPDX-License-Identifier: GPL-3.0-or-later
 * bench.c - what an evaluation, a step and a stroke cost.
 *
 *     build/bench [FILTER] [--csv FILE]
 *
 * Every case is timed as process CPU time over blocks of at least 2 ms; the minimum and the median
 * of 31 blocks are printed, in ns per operation. Cases run in turn within each round, so a machine
 * that changes its speed changes all of them alike: compare ratios within one run. The last column
 * is the ratio to the first case of the group. Inputs come from a ring of random states, so nothing
 * can be hoisted out of the loop.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "stein/lab.h"
#include "stein/stein.h"

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif

enum { STATES = 256, BLOCKS = 31, MAX_CASES = 64, MAX_NQ = 16 };

typedef struct bench_case {
    const char *group, *model, *what;
    stein_ops ops;
    int has_ops;
    long (*run)(struct bench_case *c, long n); /* n operations; returns how many were done */
    stein_sim *sim;
    stein_handover *handover;
    double q[STATES][MAX_NQ], qd[STATES][MAX_NQ];
    double best, block[BLOCKS];
    long count; /* operations in a block */
} bench_case;

static volatile double sink;

static double cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static long run_mass_bias(bench_case *c, long n)
{
    double M[MAX_NQ * MAX_NQ], bias[MAX_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_mass_bias(c->sim, c->q[i % STATES], c->qd[i % STATES], NULL, NULL, M, bias);
        sum += M[0] + bias[0];
    }
    sink = sum;
    return n;
}

static long run_inverse(bench_case *c, long n)
{
    double Q[MAX_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_inverse(c->sim, c->q[i % STATES], c->qd[i % STATES], c->qd[(i + 1) % STATES], NULL,
                      NULL, Q);
        sum += Q[0];
    }
    sink = sum;
    return n;
}

static long run_acceleration(bench_case *c, long n)
{
    double qdd[MAX_NQ], sum = 0.0;
    for (long i = 0; i < n; i++) {
        stein_acceleration(c->sim, 0.0, c->q[i % STATES], c->qd[i % STATES], qdd, NULL);
        sum += qdd[0];
    }
    sink = sum;
    return n;
}

/* steps of the stroke, started anew whenever it is over */
static long run_steps(bench_case *c, long n)
{
    for (long i = 0; i < n; i++) {
        if (stein_time(c->sim) > 0.12) {
            stein_reset(c->sim, NULL);
        }
        stein_step(c->sim, NULL);
    }
    sink = stein_q(c->sim)[0];
    return n;
}

static long run_stroke(bench_case *c, long n)
{
    for (long i = 0; i < n; i++) {
        stein_reset(c->sim, NULL);
        stein_run(c->sim, 0.12, NULL);
    }
    sink = stein_q(c->sim)[0];
    return n;
}

/* spans of time that a host waits for: 16 steps of 4 samples, 100 steps of 10 us */
static long run_blocks(bench_case *c, long n)
{
    int steps = stein_dt(c->sim) > 5e-5 ? 16 : 100;
    for (long i = 0; i < n; i++) {
        run_steps(c, steps);
    }
    return n;
}

static long run_take(bench_case *c, long n)
{
    static const double dx[] = {-0.3e-3, -0.1e-3};
    for (long i = 0; i < n; i++) {
        stein_handover_set(c->handover, "pawl.stop_shift", dx[i % 2], NULL);
        stein_handover_publish(c->handover);
        stein_handover_take(c->handover, c->sim);
    }
    return n;
}

static unsigned long long seed = 1788;

static double noise(void)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(seed >> 11) * 0x1p-52 - 1.0;
}

static bench_case *cases[MAX_CASES];
static int ncases;

static bench_case *add_with_step(const char *group, const stein_model *model, const char *what,
                                 long (*run)(bench_case *, long), stein_integrator integrator,
                                 double dt)
{
    bench_case *c = calloc(1, sizeof *c);
    stein_sim_def def = stein_sim_def_default(model);
    stein_err err;
    def.integrator = integrator;
    def.dt = dt;
    if (c == NULL || ncases == MAX_CASES || model->nq > MAX_NQ ||
        stein_sim_create(&c->sim, model, &def, &err) != STEIN_OK ||
        stein_handover_create(&c->handover, model, NULL, &err) != STEIN_OK) {
        fprintf(stderr, "bench: cannot set up %s of %s\n", what, model->name);
        exit(EXIT_FAILURE);
    }
    c->group = group;
    c->model = model->name;
    c->what = what;
    c->run = run;
    // states near the one of rest, with all contacts that are closed there
    for (int i = 0; i < STATES; i++) {
        for (int j = 0; j < model->nq; j++) {
            c->q[i][j] = stein_q(c->sim)[j] + 1e-4 * noise();
            c->qd[i][j] = noise();
        }
    }
    cases[ncases++] = c;
    return c;
}

static bench_case *add(const char *group, const stein_model *model, const char *what,
                       long (*run)(bench_case *, long), stein_integrator integrator)
{
    return add_with_step(group, model, what, run, integrator, model->dt);
}

static void add_equations(const stein_model *model)
{
    bench_case *c = add("equations", model, "M and c", run_mass_bias, STEIN_RK4);
    c->ops = model->ops_mass_bias;
    c->has_ops = 1;
    c = add("equations", model, "inverse dynamics", run_inverse, STEIN_RK4);
    c->ops = model->ops_inverse;
    c->has_ops = 1;
}

static void add_all(void)
{
    for (int i = 0; stein_models[i] != NULL; i++) {
        // only mechanisms whose M is regular can be simulated, but all have equations
        add_equations(stein_models[i]);
    }
    const stein_model *stein = &stein_model_stein1788;
    add("runtime", stein, "qdd, all contacts evaluated", run_acceleration, STEIN_RK4);
    add("runtime", stein, "step of RK4 (mean over a stroke)", run_steps, STEIN_RK4);
    add("runtime", stein, "step of DP5 (mean over a stroke)", run_steps, STEIN_DP5);
    add("runtime", stein, "stroke of 0.12 s, RK4", run_stroke, STEIN_RK4);
    add("runtime", stein, "stroke of 0.12 s, DP5", run_stroke, STEIN_DP5);
    add_with_step("realtime", stein, "audio block, 64 at 48 kHz, one key", run_blocks, STEIN_RK4,
                  4.0 / 48000.0);
    add("realtime", stein, "haptic tick of 1 ms", run_blocks, STEIN_RK4);
    add("realtime", stein, "a parameter handed over", run_take, STEIN_RK4);
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* operations in a block: doubled until it takes 2 ms */
static void calibrate(bench_case *c)
{
    for (c->count = 1;; c->count *= 2) {
        double start = cpu_ns();
        c->run(c, c->count);
        if (cpu_ns() - start > 2e6) {
            return;
        }
    }
}

static void measure(void)
{
    for (int i = 0; i < ncases; i++) {
        calibrate(cases[i]);
    }
    for (int k = 0; k < BLOCKS; k++) {
        for (int i = 0; i < ncases; i++) {
            double start = cpu_ns();
            cases[i]->run(cases[i], cases[i]->count);
            cases[i]->block[k] = (cpu_ns() - start) / (double)cases[i]->count;
        }
    }
    for (int i = 0; i < ncases; i++) {
        qsort(cases[i]->block, BLOCKS, sizeof(double), compare);
    }
}

static void print(FILE *csv)
{
    printf("%s\n", BENCH_FLAGS);
#ifdef __VERSION__
    printf("compiler %s\n", __VERSION__);
#endif
    printf("default step of stein1788: %g s\n\n", stein_model_stein1788.dt);
    printf("%-15s %-34s %11s %11s %7s   %s\n", "model", "case", "min ns", "median ns", "ratio",
           "operations (add mul neg div trig = total)");
    const bench_case *first = NULL;
    for (int i = 0; i < ncases; i++) {
        const bench_case *c = cases[i];
        double median = c->block[BLOCKS / 2];
        if (first == NULL || strcmp(first->group, c->group) != 0) {
            first = c;
        }
        printf("%-15s %-34s %11.1f %11.1f %7.2f", c->model, c->what, c->block[0], median,
               median / first->block[BLOCKS / 2]);
        const stein_ops *o = &c->ops;
        int total = o->add + o->mul + o->neg + o->div + o->trig;
        if (c->has_ops) {
            printf("   %d %d %d %d %d = %d", o->add, o->mul, o->neg, o->div, o->trig, total);
        }
        if (c->run == run_stroke) {
            printf("   %.0f strokes/s", 1e9 / median);
        }
        if (c->run == run_blocks) {
            double span = stein_dt(c->sim) > 5e-5 ? 64.0 / 48000.0 : 1e-3;
            printf("   %.1f %% of real time", 1e-7 * median / span);
        }
        printf("\n");
        if (csv != NULL) {
            fprintf(csv, "%s,%s,%s,%.3f,%.3f,%d\n", c->group, c->model, c->what, c->block[0],
                    median, total);
        }
    }
}

static void destroy(bench_case *c)
{
    stein_handover_destroy(c->handover);
    stein_sim_destroy(c->sim);
    free(c);
}

int main(int argc, char **argv)
{
    const char *filter = NULL;
    FILE *csv = NULL;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--csv") == 0 && i + 1 < argc) {
            csv = fopen(argv[++i], "w");
            if (csv == NULL) {
                perror(argv[i]);
                return EXIT_FAILURE;
            }
            fprintf(csv, "group,model,case,min_ns,median_ns,operations\n");
        } else {
            filter = argv[i];
        }
    }
    add_all();
    int kept = 0;
    for (int i = 0; i < ncases; i++) {
        bench_case *c = cases[i];
        if (filter == NULL || strstr(c->model, filter) != NULL || strstr(c->what, filter) != NULL) {
            cases[kept++] = c;
        } else {
            destroy(c);
        }
    }
    ncases = kept;
    if (ncases == 0) {
        fprintf(stderr, "bench: no case matches \"%s\"\n", filter);
        return EXIT_FAILURE;
    }
    measure();
    print(csv);
    for (int i = 0; i < ncases; i++) {
        destroy(cases[i]);
    }
    return csv != NULL && fclose(csv) != 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
