/* SPDX-License-Identifier: GPL-3.0-or-later
 * timing.c - cases, rounds, medians and ratios.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"
#include "gen.h"

enum { MAX_CASES = 96, MAX_ROWS = 64 };

typedef struct row {
    char what[96];
    double low, median, high, bar;
    int at_least;
} row;

static bench_case cases[MAX_CASES];
static int ncases;
static row rows[MAX_ROWS];
static int nrows, failures;
static const char *filter;
static volatile double sink;

double bench_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

double bench_noise(void)
{
    static unsigned long long seed = 1788;
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(seed >> 11) * 0x1p-52 - 1.0;
}

void *bench_alloc(size_t size)
{
    void *block = calloc(1, size);
    if (block == NULL) {
        fprintf(stderr, "bench: out of memory\n");
        exit(EXIT_FAILURE);
    }
    return block;
}

void bench_need(stein_status status, const stein_err *err, const char *what)
{
    if (status != STEIN_OK) {
        fprintf(stderr, "bench: %s: %s\n", what, err->msg);
        exit(EXIT_FAILURE);
    }
}

void bench_check(const char *what, double error, double bound)
{
    if (!(error <= bound)) {
        fprintf(stderr, "bench: %s is wrong by %g, more than %g\n", what, error, bound);
        failures++;
    }
}

int bench_failures(void)
{
    return failures;
}

void bench_filter(const char *part)
{
    filter = part;
}

bench_case *bench_add(const char *group, const char *subject, const char *what, bench_run *run,
                      void *ctx)
{
    if (filter != NULL && strstr(group, filter) == NULL && strstr(subject, filter) == NULL &&
        strstr(what, filter) == NULL) {
        return NULL;
    }
    if (ncases == MAX_CASES) {
        fprintf(stderr, "bench: more than %d cases\n", (int)MAX_CASES);
        exit(EXIT_FAILURE);
    }
    bench_case *c = &cases[ncases++];
    *c = (bench_case){.group = group, .subject = subject, .what = what, .run = run, .ctx = ctx};
    return c;
}

/* operations in a block: doubled until it takes 2 ms */
static void calibrate(bench_case *c)
{
    for (c->count = c->least > 0 ? c->least : 1;; c->count *= 2) {
        double start = bench_clock();
        sink = c->run(c->ctx, c->count);
        if (bench_clock() - start > 2e6) {
            return;
        }
    }
}

void bench_measure(void)
{
    for (int i = 0; i < ncases; i++) {
        calibrate(&cases[i]);
    }
    for (int k = 0; k < BENCH_ROUNDS; k++) {
        for (int i = 0; i < ncases; i++) {
            bench_case *c = &cases[i];
            double start = bench_clock();
            sink = c->run(c->ctx, c->count);
            c->ns[k] = (bench_clock() - start) / (double)c->count;
        }
    }
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_quantile(const double *x, int n, double share)
{
    double sorted[BENCH_ROUNDS];
    n = n < BENCH_ROUNDS ? n : BENCH_ROUNDS;
    memcpy(sorted, x, sizeof *x * (size_t)n);
    qsort(sorted, (size_t)n, sizeof *sorted, compare);
    return sorted[(int)(share * (n - 1) + 0.5)];
}

double bench_median(const bench_case *c)
{
    return bench_quantile(c->ns, BENCH_ROUNDS, 0.5);
}

void bench_print_cases(FILE *csv)
{
    if (ncases > 0) {
        printf("%-16s %-44s %12s %12s   %s\n", "model", "case", "min ns", "median ns",
               "operations (add mul neg div trig = total)");
    }
    for (int i = 0; i < ncases; i++) {
        const bench_case *c = &cases[i];
        double best = bench_quantile(c->ns, BENCH_ROUNDS, 0.0), median = bench_median(c);
        int total = 0;
        printf("%-16s %-44s %12.1f %12.1f", c->subject, c->what, best, median);
        if (c->ops != NULL) {
            const stein_ops *o = c->ops;
            total = gen_total(*o);
            printf("   %d %d %d %d %d = %d", o->add, o->mul, o->neg, o->div, o->trig, total);
        }
        printf("\n");
        fprintf(csv, "case,%s,%s,%s,%.3f,%.3f,,,%d\n", c->group, c->subject, c->what, best, median,
                total);
    }
}

void bench_row(const char *what, const double *figure, int n, double bar, int at_least)
{
    if (nrows == MAX_ROWS) {
        fprintf(stderr, "bench: more than %d rows\n", (int)MAX_ROWS);
        exit(EXIT_FAILURE);
    }
    row *r = &rows[nrows++];
    snprintf(r->what, sizeof r->what, "%s", what);
    r->low = bench_quantile(figure, n, 0.25);
    r->median = bench_quantile(figure, n, 0.5);
    r->high = bench_quantile(figure, n, 0.75);
    r->bar = bar;
    r->at_least = at_least;
}

void bench_ratio(const char *what, const bench_case *a, const bench_case *b, double scale,
                 double bar, int at_least)
{
    double ratio[BENCH_ROUNDS];
    if (a == NULL || b == NULL) {
        return;
    }
    for (int k = 0; k < BENCH_ROUNDS; k++) {
        ratio[k] = scale * a->ns[k] / b->ns[k];
    }
    bench_row(what, ratio, BENCH_ROUNDS, bar, at_least);
}

void bench_print_ratios(FILE *csv)
{
    if (nrows > 0) {
        printf("\n%-72s %8s  %-17s %8s\n", "ratios", "median", "quartiles", "bar");
    }
    for (int i = 0; i < nrows; i++) {
        const row *r = &rows[i];
        int met = r->at_least ? r->median >= r->bar : r->median <= r->bar;
        printf("%-72s %8.3f  %7.3f .. %-6.3f", r->what, r->median, r->low, r->high);
        if (r->bar > 0.0) {
            printf(" %s%6.3f  %s", r->at_least ? ">=" : "<=", r->bar, met ? "met" : "NOT MET");
        }
        printf("\n");
        fprintf(csv, "ratio,,,\"%s\",,%.4f,%.4f,%.4f,%s%g\n", r->what, r->median, r->low, r->high,
                r->bar > 0.0 ? (r->at_least ? ">=" : "<=") : "", r->bar);
    }
}

void bench_fill_states(bench_states *s, const stein_sim *sim)
{
    int nq = stein_sim_model(sim)->nq;
    for (int i = 0; i < BENCH_STATES; i++) {
        for (int j = 0; j < nq; j++) {
            s->q[i][j] = stein_q(sim)[j] + 1e-4 * bench_noise();
            s->qd[i][j] = bench_noise();
        }
    }
}
