/* SPDX-License-Identifier: MIT
 * haptic.c - a key that is felt: 1000 times a second its measured angle in, the force on the finger
 * out.
 *
 *   haptic [--live] [motion.csv] > felt.csv
 *
 * motion.csv has the columns time [s] and key angle [rad], one row a millisecond; without it a
 * stroke is made up. With --live a tick is a real millisecond, as for a motor; without it
 * the loop runs as fast as it can. Times of the ticks go to standard error.
 *
 * A measured angle jumps from tick to tick, and a motion that is prescribed needs a speed and an
 * acceleration: the key follows each sample like a critically damped oscillator of 60 Hz; its
 * motion within a tick has a closed form.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <stein/stein.h>

enum { TICKS = 20000 };
static const double tick = 1e-3, follow = 2.0 * 3.14159265358979 * 60.0; /* [s], [rad/s] */

/* where the key is going to: at `t0` it was at y with speed v; the sample is x */
typedef struct follower {
    double t0, y, v, x;
} follower;

static void motion(void *ctx, double t, double u[3])
{
    const follower *f = ctx;
    double s = t - f->t0, e = exp(-follow * s), a = f->y - f->x, b = f->v + follow * a;
    u[0] = f->x + (a + b * s) * e;
    u[1] = (b - follow * (a + b * s)) * e;
    u[2] = (follow * follow * (a + b * s) - 2.0 * follow * b) * e;
}

/* the next sample: the follower starts from where it is now */
static void take(follower *f, double t, double x)
{
    double u[3];
    motion(f, t, u);
    *f = (follower){t, u[0], u[1], x};
}

/* ---- where samples come from ---- */

static int read_file(const char *file, double *angle)
{
    char line[256];
    double t;
    int n = 0;
    FILE *f = fopen(file, "r");
    while (f != NULL && n < TICKS && fgets(line, sizeof line, f) != NULL) {
        n += sscanf(line, "%lf,%lf", &t, &angle[n]) == 2; // comments and the header are no numbers
    }
    if (f != NULL) {
        fclose(f);
    }
    return n;
}

/* down in 50 ms, held, up in 80 ms: seen by an encoder of 16 bits a turn */
static int make_up(double *angle)
{
    const double deep = 0.038, pi = 3.14159265358979, step = 2.0 * pi / 65536.0;
    for (int i = 0; i < 500; i++) {
        double down = fmin(fmax((i - 20) / 50.0, 0.0), 1.0);
        double up = fmin(fmax((i - 250) / 80.0, 0.0), 1.0);
        double x = 0.5 * deep * (cos(pi * up) - cos(pi * down));
        angle[i] = step * round(x / step);
    }
    return 500;
}

/* ---- the loop ---- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void wait_until(double when)
{
    struct timespec t = {(time_t)when, (long)(1e9 * (when - floor(when)))};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) != 0) {
    }
}

/* one millisecond of the action; torque on the key [N m] */
static stein_status one_tick(stein_sim *sim, follower *f, double x, int channel, double *torque,
                             stein_err *err)
{
    take(f, stein_time(sim), x);
    stein_status status = stein_run(sim, stein_time(sim) + tick, err);
    *torque = stein_read(sim, channel);
    return status;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int loop(stein_sim *sim, follower *f, const double *angle, int n, int live, stein_err *err)
{
    static double took[TICKS], torque[TICKS];
    int channel = stein_find_channel(stein_sim_model(sim), "key_force"), missed = 0;
    double lever;
    stein_get(sim, "key.front.x", &lever, err);
    double start = now();
    for (int i = 0; i < n; i++) {
        double begin = now();
        if (one_tick(sim, f, angle[i], channel, &torque[i], err) != STEIN_OK) {
            return 0;
        }
        took[i] = now() - begin; // here the motor would get its current
        missed += took[i] > tick;
        if (live) {
            wait_until(start + (i + 1) * tick);
        }
    }
    printf("time [s],key_angle [rad],force [N]\n");
    for (int i = 0; i < n; i++) {
        printf("%.3f,%.6f,%.4f\n", i * tick, angle[i], torque[i] / lever);
    }
    qsort(took, (size_t)n, sizeof *took, by_size);
    fprintf(stderr, "%d ticks: median %.0f us, 99.9 %% below %.0f us, worst %.0f us, %d missed\n",
            n, 1e6 * took[n / 2], 1e6 * took[(n * 999) / 1000], 1e6 * took[n - 1], missed);
    return 1;
}

int main(int argc, char **argv)
{
    static double angle[TICKS];
    stein_sim *sim = NULL;
    stein_err err = {STEIN_OK, ""};
    int live = argc > 1 && strcmp(argv[1], "--live") == 0;
    const char *file = argc > 1 + live ? argv[1 + live] : NULL;
    int n = file != NULL ? read_file(file, angle) : make_up(angle);
    if (n == 0) {
        return fprintf(stderr, "haptic: %s has no rows \"time,angle\"\n", file), 1;
    }
    follower f = {0.0, angle[0], 0.0, angle[0]};
    int ok = stein_sim_create(&sim, &stein_model_stein1788, NULL, &err) == STEIN_OK &&
             stein_drive(sim, "key_motion", motion, &f, &err) == STEIN_OK;
    if (ok) {
        stein_load_lift(sim); // the finger takes the place of the load
        ok = loop(sim, &f, angle, n, live, &err);
    }
    if (!ok) {
        fprintf(stderr, "haptic: %s\n", err.msg);
    }
    stein_sim_destroy(sim);
    return !ok;
}
