/* SPDX-License-Identifier: GPL-3.0-or-later
 * precision.c - cost of a stroke at an accuracy: global error of the head against CPU time.
 *
 * One stroke of the 1788 action from its rest through escapement, impact and rebound, seen at
 * twelve times. The error of a method is the largest distance of the head from the reference. The
 * reference is the motion with steps of controlled error at their smallest tolerance; its error is
 * measured by fixed steps of a millionth of a second, which share only the forces with it. All
 * settings are run in turn, again and again, each from the same state.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "plot.h"
#include "run.h"
#include "peers.h"

enum { SEEN = 12, REPEATS = 9, MAX_SETTINGS = 160, MOST_LANES = 8 };
static const double apart = 5e-3;       /* [s] between two times */
static const double wanted = 1e-6;      /* error of the head [m] */
static const double regulation = -3e-4; /* dx [m] */

/* a method with one setting */
typedef struct setting {
    const peer *peer;
    double value; /* tolerance, or step [s] */
    stein_sim *sim[MOST_LANES];
    int lanes; /* simulations that it runs at once */
    double error, ms[REPEATS];
    long calls;
} setting;

static setting settings[MAX_SETTINGS];
static int nsettings, head;
static double at[SEEN], exact[SEEN];

/* ---- our own methods ---- */

typedef struct eye {
    double *q;
    int i;
} eye;

static double look(void *ctx, stein_sim *sim)
{
    eye *e = ctx;
    int nq = stein_sim_model(sim)->nq;
    memcpy(e->q + nq * e->i, stein_q(sim), sizeof *e->q * (size_t)nq);
    e->i++;
    return e->i < SEEN ? at[e->i] : INFINITY;
}

static stein_pace controlled_pace(double tolerance, eye *e)
{
    return (stein_pace){
        .tolerance = tolerance, .longest = 1e-3, .h = 1e-5, .next = at[0], .look = look, .ctx = e};
}

static int run_controlled(const void *method, stein_sim *sim, double tolerance, const double *times,
                          int n, double *q, long *calls)
{
    eye e = {q, 0};
    stein_pace pace = controlled_pace(tolerance, &e);
    (void)method;
    *calls = 0;
    return stein_run_adaptive(sim, times[n - 1], &pace, NULL) == STEIN_OK ? 0 : -1;
}

static int run_fixed(const void *method, stein_sim *sim, double dt, const double *times, int n,
                     double *q, long *calls)
{
    int nq = stein_sim_model(sim)->nq, status = 0;
    (void)method, (void)dt;
    *calls = 0;
    for (int i = 0; i < n && status == 0; i++) {
        status = stein_run(sim, times[i], NULL) == STEIN_OK ? 0 : -1;
        memcpy(q + nq * i, stein_q(sim), sizeof *q * (size_t)nq);
    }
    return status;
}

static const peer controlled = {"stein, controlled steps", run_controlled, NULL};
static const peer rk4 = {"stein, RK4", run_fixed, NULL};
static const peer dp5 = {"stein, DP5", run_fixed, NULL};
static const peer rk4_lanes = {"stein, RK4 in lanes", NULL, NULL};
static const peer controlled_lanes = {"stein, controlled steps in lanes", NULL, NULL};

/* ---- the stroke ---- */

static stein_sim *make_sim(stein_integrator integrator, double dt)
{
    stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
    stein_sim *sim = NULL;
    stein_err err;
    def.integrator = integrator;
    def.dt = dt;
    bench_need(stein_sim_create(&sim, &stein_model_stein1788, &def, &err), &err, "stein1788");
    bench_need(stein_set(sim, "pawl.stop_shift", regulation, &err), &err, "dx");
    bench_need(stein_reset(sim, &err), &err, "reset");
    return sim;
}

/* heights of the head [SEEN] at the coordinates seen */
static void find_heights(stein_sim *sim, const double *q, double *z)
{
    const stein_model *model = stein_sim_model(sim);
    double x[3 * 64], zero[BENCH_NQ] = {0.0};
    for (int i = 0; i < SEEN && model->npoint <= 64; i++) {
        stein_points(sim, q + i * model->nq, zero, x, NULL, NULL, NULL);
        z[i] = x[3 * head + 2];
    }
}

static double error_of(stein_sim *sim, const double *q)
{
    double z[SEEN], worst = 0.0;
    find_heights(sim, q, z);
    for (int i = 0; i < SEEN; i++) {
        worst = fmax(worst, isfinite(z[i]) ? fabs(z[i] - exact[i]) : INFINITY);
    }
    return worst;
}

/* all of a setting's simulations at once, which do the same; the first one is looked at */
static int run_lanes(setting *s, double *q)
{
    const stein_model *model = stein_sim_model(s->sim[0]);
    stein_sim_def def = stein_sim_def_default(model);
    stein_batch *batch = NULL;
    stein_pace pace[MOST_LANES];
    eye e[MOST_LANES];
    double end[MOST_LANES], unseen[MOST_LANES][SEEN * BENCH_NQ];
    int steps = s->peer == &rk4_lanes;
    def.integrator = steps ? STEIN_RK4 : STEIN_DP5;
    int status = stein_batch_create(&batch, model, &def, s->lanes, s->lanes, NULL) == 0 ? 0 : -1;
    for (int k = 0; status == 0 && k < s->lanes; k++) {
        status = stein_batch_put(batch, k, s->sim[k], NULL) == STEIN_OK ? 0 : -1;
        e[k] = (eye){k > 0 ? unseen[k] : q, 0};
        pace[k] = controlled_pace(s->value, &e[k]);
        end[k] = at[SEEN - 1];
    }
    if (status == 0 && !steps) {
        status = stein_batch_run_adaptive(batch, end, pace, NULL, NULL) == STEIN_OK ? 0 : -1;
    }
    for (int i = 0; i < SEEN && steps && status == 0; i++) {
        for (int k = 0; k < s->lanes; k++) {
            end[k] = at[i];
        }
        status = stein_batch_run(batch, end, NULL, NULL) == STEIN_OK ? 0 : -1;
        memcpy(q + i * model->nq, stein_q(stein_batch_look(batch, 0)),
               sizeof *q * (size_t)model->nq);
    }
    stein_batch_destroy(batch);
    return status;
}

/* one run from the beginning; its error and its time [ms] a stroke */
static void run_once(setting *s, double *error, double *ms)
{
    double q[SEEN * BENCH_NQ];
    stein_err err;
    for (int k = 0; k < s->lanes; k++) {
        bench_need(stein_reset(s->sim[k], &err), &err, "reset");
    }
    double start = bench_clock();
    int status = s->peer->run == NULL
                     ? run_lanes(s, q)
                     : s->peer->run(s->peer->method, s->sim[0], s->value, at, SEEN, q, &s->calls);
    *ms = 1e-6 * (bench_clock() - start) / s->lanes;
    *error = status == 0 ? error_of(s->sim[0], q) : INFINITY;
}

static void add(const peer *p, double value, stein_integrator integrator, double dt, int lanes)
{
    if (nsettings == MAX_SETTINGS) {
        bench_check("room for the settings", 1.0, 0.0);
        return;
    }
    setting *s = &settings[nsettings++];
    *s = (setting){.peer = p, .value = value, .lanes = lanes};
    for (int k = 0; k < lanes; k++) {
        s->sim[k] = make_sim(integrator, dt);
    }
}

static void find_reference(void)
{
    double q[SEEN * BENCH_NQ], error;
    long calls;
    stein_sim *sim = make_sim(STEIN_DP5, 1e-6);
    head = 0;
    for (int i = 0; i < stein_model_stein1788.npoint; i++) {
        head = strcmp(stein_model_stein1788.points[i].name, "hammer.head") == 0 ? i : head;
    }
    for (int i = 0; i < SEEN; i++) {
        at[i] = apart * (i + 1);
    }
    int failed = run_controlled(NULL, sim, 1e-13, at, SEEN, q, &calls);
    find_heights(sim, q, exact);
    stein_reset(sim, NULL);
    failed |= run_fixed(NULL, sim, 1e-6, at, SEEN, q, &calls);
    error = failed ? INFINITY : error_of(sim, q);
    printf("\nstroke to %g s, error of the head against CPU time\n"
           "reference: two of our methods differ by %.1e m\n",
           at[SEEN - 1], error);
    bench_check("the reference of the stroke [m]", error, 0.01 * wanted);
    stein_sim_destroy(sim);
}

static void add_settings(void)
{
    static const double step[] = {1e-4, 5e-5, 4e-5, 1.0 / 48000, 1e-5, 5e-6, 2.5e-6};
    const peer *peers;
    int n = peers_all(&peers), width = stein_batch_width(&stein_model_stein1788);
    for (double tolerance = 1e-6; tolerance > 5e-12; tolerance *= 0.1) {
        add(&controlled, tolerance, STEIN_DP5, 1e-5, 1);
        add(&controlled, 0.3 * tolerance, STEIN_DP5, 1e-5, 1);
        if (width > 1) {
            add(&controlled_lanes, tolerance, STEIN_DP5, 1e-5, width);
            add(&controlled_lanes, 0.3 * tolerance, STEIN_DP5, 1e-5, width);
        }
    }
    for (int i = 0; i < (int)(sizeof step / sizeof *step); i++) {
        add(&rk4, step[i], STEIN_RK4, step[i], 1);
        add(&dp5, step[i], STEIN_DP5, step[i], 1);
        if (width > 1) {
            add(&rk4_lanes, step[i], STEIN_RK4, step[i], width);
        }
    }
    for (int k = 0; k < n; k++) {
        for (double tolerance = 1e-4; tolerance > 5e-12; tolerance *= 0.1) {
            add(&peers[k], tolerance, STEIN_DP5, 1e-5, 1);
            add(&peers[k], 0.3 * tolerance, STEIN_DP5, 1e-5, 1);
        }
    }
}

/* the cheapest setting of a method with at most this error */
static const setting *cheapest(const peer *p, double error)
{
    const setting *best = NULL;
    for (int i = 0; i < nsettings; i++) {
        const setting *s = &settings[i];
        if (s->peer == p && s->error <= error &&
            (best == NULL ||
             bench_quantile(s->ms, REPEATS, 0.5) < bench_quantile(best->ms, REPEATS, 0.5))) {
            best = s;
        }
    }
    return best;
}

/* ---- the picture ---- */

static void write_plot(FILE *f, const void *ctx)
{
    static const char *const colour[] = {"#7f8c8d", "#16a085", "#2980b9", "#8e44ad",
                                         "#d4ac0d", "#6e2c00", "#e67e22", "#c0392b",
                                         "#ff69b4", "#000000", "#27ae60"};
    const peer *last = NULL;
    int n = 0;
    (void)ctx;
    fprintf(f, "set logscale xy\nset format xy '10^{%%L}'\nset key outside right\nset grid\n"
               "set termoption enhanced\n"
               "set xlabel 'CPU time of a stroke [ms]'\nset ylabel 'error of the head [m]'\n");
    for (int i = 0; i < nsettings; i++) {
        const setting *s = &settings[i];
        if (s->peer != last) {
            fprintf(f, "%s$m%d << EOD\n", last != NULL ? "EOD\n" : "", n++);
            last = s->peer;
        }
        if (isfinite(s->error)) {
            fprintf(f, "%.9g %.9g\n", bench_quantile(s->ms, REPEATS, 0.5), s->error);
        }
    }
    fprintf(f, "EOD\nplot ");
    last = NULL;
    n = 0;
    for (int i = 0; i < nsettings; i++) {
        if (settings[i].peer != last) {
            last = settings[i].peer;
            int ours = strncmp(last->name, "stein", 5) == 0;
            fprintf(f, "%s$m%d using 1:2 with linespoints pt 7 ps 0.5 lc rgb '%s' %s title ",
                    n > 0 ? ", " : "", n, colour[n % 11], ours ? "lw 2.5" : "lw 1 dt 2");
            lab__quoted(f, last->name);
            n++;
        }
    }
    fprintf(f, "\n");
}

/* settings of one method side by side: lanes and steps were added in turn */
static int by_method(const void *a, const void *b)
{
    const setting *x = a, *y = b;
    int c = strcmp(x->peer->name, y->peer->name);
    return c != 0 ? c : (x->value < y->value) - (x->value > y->value);
}

static void print_settings(FILE *csv)
{
    printf("%-34s %-10s %12s %10s %10s\n", "method", "setting", "error [m]", "median ms", "calls");
    for (int i = 0; i < nsettings; i++) {
        const setting *s = &settings[i];
        printf("%-34s %-10.2g %12.2e %10.3f %10ld\n", s->peer->name, s->value, s->error,
               bench_quantile(s->ms, REPEATS, 0.5), s->calls);
        fprintf(csv, "precision,%s,stein1788,%g,,%.6f,,,%.6e\n", s->peer->name, s->value,
                1e6 * bench_quantile(s->ms, REPEATS, 0.5), s->error);
    }
}

/* every method at an error against our controlled steps at the same; `text` names the error */
static void rows_at(double error, const char *text, double bar)
{
    const setting *ours = cheapest(&controlled, error);
    const peer *peers;
    int n = peers_all(&peers);
    bench_check("controlled steps [m]", ours != NULL ? ours->error : INFINITY, error);
    if (ours == NULL) {
        return;
    }
    for (int k = -3; k < n; k++) {
        const peer *p = k == -3   ? &rk4
                        : k == -2 ? &rk4_lanes
                        : k == -1 ? &controlled_lanes
                                  : &peers[k];
        const setting *s = cheapest(p, error);
        char what[96];
        double ratio[REPEATS];
        if (s == NULL) {
            printf("%s: no setting reached %s\n", p->name, text);
            continue;
        }
        for (int r = 0; r < REPEATS; r++) {
            ratio[r] = s->ms[r] / ours->ms[r];
        }
        snprintf(what, sizeof what, "stroke at %s, %s : controlled steps", text, p->name);
        bench_row(what, ratio, REPEATS, k >= 0 ? bar : 0.0, 1);
    }
}

void precision_rows(const char *picture, FILE *csv)
{
    stein_err err = {STEIN_OK, ""};
    find_reference();
    add_settings();
    qsort(settings, (size_t)nsettings, sizeof *settings, by_method);
    for (int r = 0; r < REPEATS; r++) {
        for (int i = 0; i < nsettings; i++) {
            run_once(&settings[i], &settings[i].error, &settings[i].ms[r]);
        }
    }
    print_settings(csv);
#ifndef BENCH_CVODE
    printf("CVODE was not there when this was compiled: apt-get install libsundials-dev\n");
#endif
    rows_at(wanted, "1 um", 1.0);
    rows_at(1e-3 * wanted, "1 nm", 0.0);
    if (picture != NULL && lab__gnuplot(picture, 900, 560, write_plot, NULL, &err) != STEIN_OK) {
        fprintf(stderr, "bench: no picture: %s\n", err.msg);
    }
    for (int i = 0; i < nsettings; i++) {
        for (int k = 0; k < settings[i].lanes; k++) {
            stein_sim_destroy(settings[i].sim[k]);
        }
    }
    nsettings = 0;
}
