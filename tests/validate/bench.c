/* SPDX-License-Identifier: GPL-3.0-or-later
 * bench.c - mechanism files run as a user would (bench.h).
 */
#include "bench.h"

#include <gsl/gsl_integration.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

void bench_stop(const stein_err *err)
{
    fprintf(stderr, "validate: %s\n", err->msg);
    exit(EXIT_FAILURE);
}

bench bench_start(const char *file)
{
    bench b = {NULL, NULL};
    stein_err err;
    lab_options options = lab_options_default();
    if (lab_open(&b.model, file, &options, &err) != STEIN_OK ||
        lab_sim(b.model, NULL, &b.sim, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    return b;
}

void bench_end(bench *b)
{
    stein_sim_destroy(b->sim);
    lab_close(b->model);
}

void bench_run(const bench *b, double t)
{
    stein_err err;
    if (stein_run(b->sim, t, &err) != STEIN_OK) {
        bench_stop(&err);
    }
}

double bench_read(const bench *b, const char *channel)
{
    double value = NAN;
    stein_err err;
    if (stein_read_name(b->sim, channel, &value, &err) != STEIN_OK) {
        bench_stop(&err);
    }
    return value;
}

double bench_energy(const bench *b)
{
    double kinetic, potential;
    stein_energy(b->sim, stein_q(b->sim), stein_qd(b->sim), &kinetic, &potential);
    return kinetic + potential;
}

double bench_integral(double (*f)(double, void *), void *ctx, double from, double to)
{
    gsl_integration_workspace *room = gsl_integration_workspace_alloc(2000);
    gsl_function function = {f, ctx};
    double value, error;
    (void)gsl_integration_qags(&function, from, to, 0.0, 1e-12, 2000, room, &value, &error);
    gsl_integration_workspace_free(room);
    return value;
}

const char *bench_cell(char *text, const char *format, double value)
{
    snprintf(text, 64, format, value);
    return text;
}
