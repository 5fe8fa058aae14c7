/* SPDX-License-Identifier: GPL-3.0-or-later
 * worst.c - the longest of a million steps of the 1788 action, in medians: a finger of random force
 * presses and lifts, the load comes and goes, and the regulation is turned in the middle of it.
 *
 * The motion is made three times, and the shortest time of each step counts: interrupts of the
 * machine are in none of them twice.
 */
#include <math.h>
#include <stdlib.h>

#include "bench.h"
#include "stein/models.h"

enum { TIMES = 3, STEPS = 1000000 };

typedef struct run {
    double *ns; /* [STEPS] */
    int failed;
} run;

static double random_share(unsigned long long *seed)
{
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*seed >> 11) * 0x1p-53;
}

static void press(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(const double *)ctx;
}

/* the hand of a technician, within the ranges of the file */
static void turn(stein_sim *sim, unsigned long long *seed)
{
    static const struct {
        const char *name;
        double from, to;
    } hand[] = {{"pawl.stop_shift", -1.4e-3, 0.4e-3},
                {"pawl.spring.k", 0.01, 0.1},
                {"notch.friction.A", 0.05, 0.6},
                {"pawl.notch_angle", 1.22, 2.09}};
    for (int i = 0; i < 4; i++) {
        double value = hand[i].from + random_share(seed) * (hand[i].to - hand[i].from);
        if (random_share(seed) < 0.3) {
            stein_set(sim, hand[i].name, value, NULL);
        }
    }
}

static void play(run *r, double rate)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    unsigned long long seed = 1788;
    double finger = 0.0;
    stein_sim *sim = NULL;
    stein_err err;
    def.dt = 1.0 / rate;
    bench_need(stein_sim_create(&sim, model, &def, &err), &err, model->name);
    bench_need(stein_drive(sim, "finger", press, &finger, &err), &err, "finger");
    r->failed = 0;
    for (int i = 0, next = 0; i < STEPS; i++) {
        if (i == next) {
            finger = fmax(0.0, 20.0 * random_share(&seed) - 8.0);
            next += (int)(rate * (0.01 + 0.1 * random_share(&seed)));
            turn(sim, &seed);
            if (random_share(&seed) < 0.5) {
                stein_load_lift(sim);
            } else {
                stein_load_place(sim, NULL);
            }
        }
        double begin = bench_clock();
        stein_status status = stein_step(sim, NULL);
        r->ns[i] = fmin(r->ns[i], bench_clock() - begin);
        if (status != STEIN_OK) {
            r->failed++;
            stein_reset(sim, NULL);
        }
    }
    stein_sim_destroy(sim);
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void row(double rate, double bar)
{
    run r = {.ns = bench_alloc(sizeof *r.ns * STEPS)};
    char what[96];
    for (int i = 0; i < STEPS; i++) {
        r.ns[i] = INFINITY;
    }
    for (int k = 0; k < TIMES; k++) {
        play(&r, rate);
    }
    qsort(r.ns, STEPS, sizeof *r.ns, by_size);
    double median = r.ns[STEPS / 2], most = r.ns[STEPS - 1] / median;
    printf(
        "steps of RK4 at %g Hz: median %.0f ns; 99.9 %% below %.1f, 99.99 %% below %.1f medians\n",
        rate, median, r.ns[STEPS - STEPS / 1000] / median, r.ns[STEPS - STEPS / 10000] / median);
    snprintf(what, sizeof what, "longest of %d steps at %g Hz : median", (int)STEPS, rate);
    bench_row(what, &most, 1, bar, 0);
    bench_check("random strokes and regulations: steps that failed", r.failed, 0.0);
    free(r.ns);
}

void worst_rows(void)
{
    row(48000.0, 6.0);
    row(12000.0, 10.0);
}
