/* SPDX-License-Identifier: GPL-3.0-or-later
 * derivative.c - qdd and its derivatives with all contacts closed, against M and c alone.
 *
 * The 1788 action is regulated so that everything touches at once, the notch at tip and corner:
 * more than any stroke has closed. Derivatives are compared with differences before they are timed.
 */
#include <math.h>
#include <string.h>

#include "bench.h"

enum { NQ = 4, HALVINGS = 5 };

static stein_sim *sim;
static stein_derivative *slopes;
static bench_states states;

static double parameter(const char *name)
{
    double value = 0.0;
    stein_err err;
    bench_need(stein_get(sim, name, &value, &err), &err, name);
    return value;
}

static void set(const char *name, double value)
{
    stein_err err;
    bench_need(stein_set(sim, name, value, &err), &err, name);
}

/* height of a named point */
static double height(const double *x, const char *name)
{
    const stein_model *model = stein_sim_model(sim);
    for (int i = 0; i < model->npoint; i++) {
        if (strcmp(model->points[i].name, name) == 0) {
            return x[3 * i + 2];
        }
    }
    return NAN;
}

/* everything touches, and all of it slides */
static void close_all(void)
{
    static const double qd[NQ] = {0.013, -0.21, 0.17, -0.004};
    const stein_model *model = &stein_model_stein1788;
    double q[NQ], x[3 * 32];
    stein_err err;
    bench_need(stein_sim_create(&sim, model, NULL, &err), &err, model->name);
    bench_need(stein_derivative_create(&slopes, model, NULL, &err), &err, model->name);
    if (model->nq != NQ || model->npoint > 32) {
        bench_check("room for stein1788", 1.0, 0.0);
        return;
    }
    memcpy(q, stein_q(sim), sizeof q);
    stein_points(sim, q, qd, x, NULL, NULL, NULL);
    q[NQ - 1] -= 0.03e-3; // the load
    set("pawl.corner.z", parameter("pawl.corner.z") - 0.30e-3);
    set("dip.line.z", height(x, "key.below") + 0.05e-3);
    set("string.height", height(x, "hammer.head") - 0.04e-3);
    bench_need(stein_set_state(sim, 0.0, q, qd, &err), &err, "state");
    int open = stein_notch_phase(sim, 0) != 2;
    for (int i = 0; i < model->ncontact; i++) {
        open += !stein_touches(sim, i);
    }
    bench_check("contacts that are to be closed (open ones)", open, 0.0);
    for (int i = 0; i < BENCH_STATES; i++) {
        for (int j = 0; j < NQ; j++) {
            states.q[i][j] = q[j] + 1e-6 * bench_noise();
            states.qd[i][j] = qd[j] * (1.0 + 0.2 * bench_noise());
        }
    }
}

/* qdd by one number of a state, by central differences extrapolated to a step of 0 */
static void difference(double *q, double *qd, double *moved, double h, double *slope)
{
    double row[HALVINGS][NQ], last[HALVINGS][NQ], y[2][NQ], at = *moved;
    for (int i = 0; i < HALVINGS; i++, h *= 0.5) {
        for (int side = 0; side < 2; side++) {
            *moved = side == 0 ? at - h : at + h;
            stein_acceleration(sim, 0.0, q, qd, y[side], NULL);
        }
        *moved = at;
        for (int j = 0; j < NQ; j++) {
            double factor = 4.0;
            row[0][j] = (y[1][j] - y[0][j]) / (2.0 * h);
            for (int k = 1; k <= i; k++, factor *= 4.0) {
                row[k][j] = row[k - 1][j] + (row[k - 1][j] - last[k - 1][j]) / (factor - 1.0);
            }
            slope[j] = row[i][j];
        }
        memcpy(last, row, sizeof last);
    }
}

static void check_slopes(void)
{
    double worst = 0.0;
    for (int i = 0; i < 8; i++) {
        double by[2][NQ * NQ], *q = states.q[i], *qd = states.qd[i];
        stein_err err;
        bench_need(stein_derivative_at(slopes, sim, 0.0, q, qd, NULL, &err), &err, "derivative");
        stein_derivative_by_state(slopes, by[0], by[1]);
        for (int j = 0; j < 2 * NQ; j++) {
            double expected[NQ], off = 0.0, size = 0.0;
            difference(q, qd, j < NQ ? &q[j] : &qd[j - NQ], j < NQ ? 4e-6 : 1e-4, expected);
            for (int k = 0; k < NQ; k++) {
                off = fmax(off, fabs(by[j / NQ][k * NQ + j % NQ] - expected[k]));
                size = fmax(size, fabs(expected[k]));
            }
            worst = fmax(worst, off / size);
        }
    }
    bench_check("derivatives with all contacts closed, of their size", worst, 1e-8);
    printf("derivatives with all contacts closed: %.1g of their size off differences\n\n", worst);
}

static double run_mass_bias(void *ctx, long n)
{
    double M[NQ * NQ], c[NQ], sum = 0.0;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        stein_mass_bias(sim, states.q[i % BENCH_STATES], states.qd[i % BENCH_STATES], NULL, NULL, M,
                        c);
        sum += M[0] + c[0];
    }
    return sum;
}

static double run_acceleration(void *ctx, long n)
{
    double qdd[NQ], sum = 0.0;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        stein_acceleration(sim, 0.0, states.q[i % BENCH_STATES], states.qd[i % BENCH_STATES], qdd,
                           NULL);
        sum += qdd[0];
    }
    return sum;
}

static double run_slopes(void *ctx, long n)
{
    double qdd[NQ], by_q[NQ * NQ], by_qd[NQ * NQ], sum = 0.0;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        stein_derivative_at(slopes, sim, 0.0, states.q[i % BENCH_STATES],
                            states.qd[i % BENCH_STATES], qdd, NULL);
        stein_derivative_by_state(slopes, by_q, by_qd);
        sum += by_q[0] + by_qd[1];
    }
    return sum;
}

/* parameters of contacts, bodies and the rest in turn, at one place */
static double run_parameters(void *ctx, long n)
{
    double by_p[NQ], sum = 0.0;
    (void)ctx;
    stein_derivative_at(slopes, sim, 0.0, states.q[0], states.qd[0], NULL, NULL);
    for (long i = 0; i < n; i++) {
        stein_derivative_by_parameter(slopes, (int)(i % stein_model_stein1788.np), by_p);
        sum += by_p[0];
    }
    return sum;
}

/* the derivatives of M qdd + c alone, as generated */
static double run_equations(void *ctx, long n)
{
    const stein_model *model = ctx;
    double p[512], sc[2 * NQ], by_q[NQ * NQ], by_qd[NQ * NQ], sum = 0.0;
    static double d[1024];
    if (d[0] == 0.0 && model->np <= 512 && model->nd <= 1024) {
        for (int i = 0; i < model->np; i++) {
            p[i] = model->params[i].value;
        }
        stein_setup(model, p, d);
    }
    for (long i = 0; i < n; i++) {
        const double *q = states.q[i % BENCH_STATES], *qd = states.qd[i % BENCH_STATES];
        stein_turn(model, q, sc);
        model->inverse_slopes(q, qd, states.qd[(i + 1) % BENCH_STATES], sc, d, by_q, by_qd);
        sum += by_q[0] + by_qd[1];
    }
    return sum;
}

/* a stroke from rest, alone and with directions of parameters that ride with it */
enum { RIDERS = 6 };
static const char *const ridden[RIDERS] = {"pawl.stop_shift", "hammer.mass",   "notch.friction.A",
                                           "loops.normal.c",  "pawl.spring.k", "hammer.centre.x"};
static const double stroke_end = 0.06; /* [s], past the string */
static stein_sim *striking;
static stein_sensitivity *riders;

static double run_stroke(void *ctx, long n)
{
    (void)ctx;
    for (long i = 0; i < n; i++) {
        stein_reset(striking, NULL);
        stein_run(striking, stroke_end, NULL);
    }
    return stein_q(striking)[0];
}

static double run_ridden(void *ctx, long n)
{
    double p[512] = {0.0}, last = 0.0;
    stein_err err;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        stein_reset(striking, NULL);
        bench_need(stein_sensitivity_attach(riders, striking, &err), &err, "sensitivities");
        for (int k = 0; k < RIDERS; k++) {
            int param = stein_find_param(&stein_model_stein1788, ridden[k]);
            p[param] = 1.0;
            bench_need(stein_sensitivity_start(riders, k, p, &err), &err, "sensitivities");
            p[param] = 0.0;
        }
        stein_run(striking, stroke_end, NULL);
        bench_need(stein_sensitivity_check(riders, &err), &err, "sensitivities");
        last = stein_sensitivity_q(riders, 1)[1];
        (void)stein_sensitivity_attach(riders, NULL, NULL);
    }
    return last;
}

/* the hammer's angle at the end by its mass, against central differences of strokes */
static void check_ridden(void)
{
    const char *name = ridden[1];
    stein_err err;
    bench_need(stein_sim_create(&striking, &stein_model_stein1788, NULL, &err), &err, "stroke");
    bench_need(stein_sensitivity_create(&riders, &stein_model_stein1788, NULL, RIDERS, &err), &err,
               "sensitivities");
    double mass = 0.0, y[2];
    bench_need(stein_get(striking, name, &mass, &err), &err, name);
    for (int i = 0; i < 2; i++) {
        bench_need(stein_set(striking, name, mass * (i == 0 ? 1.0 - 2e-6 : 1.0 + 2e-6), &err), &err,
                   name);
        run_stroke(NULL, 1);
        y[i] = stein_q(striking)[1];
    }
    bench_need(stein_set(striking, name, mass, &err), &err, name);
    stein_reset(striking, NULL);
    double expected = (y[1] - y[0]) / (4e-6 * mass), is = run_ridden(NULL, 1);
    bench_check("sensitivity of a stroke to the hammer's mass, of its size",
                fabs(is / expected - 1.0), 1e-4);
}

static bench_case *of_stroke, *of_ridden;
static bench_case *of_equations, *of_qdd, *of_slopes, *of_equation_slopes;

void derivative_add(void)
{
    const stein_model *model = &stein_model_stein1788;
    close_all();
    check_slopes();
    of_equations =
        bench_add("derivative", model->name, "M and c where all is closed", run_mass_bias, NULL);
    of_equation_slopes = bench_add("derivative", model->name, "M qdd + c by q and qd",
                                   run_equations, (void *)(size_t)model);
    if (of_equation_slopes != NULL) {
        of_equation_slopes->ops = &model->ops_slopes;
    }
    of_qdd =
        bench_add("derivative", model->name, "qdd, all contacts closed", run_acceleration, NULL);
    of_slopes = bench_add("derivative", model->name, "qdd by q and qd, all contacts closed",
                          run_slopes, NULL);
    bench_add("derivative", model->name, "qdd by one parameter, all contacts closed",
              run_parameters, NULL);
    check_ridden();
    of_stroke =
        bench_add("derivative", model->name, "stroke of 0.06 s from rest", run_stroke, NULL);
    of_ridden = bench_add("derivative", model->name, "the same with sensitivities to 6 parameters",
                          run_ridden, NULL);
}

void derivative_rows(void)
{
    bench_ratio("derivative of the state (qdd), all contacts closed : M+c alone", of_qdd,
                of_equations, 1.0, 4.0, 0);
    bench_ratio("qdd and its derivatives by q, qd, all contacts closed : M+c alone", of_slopes,
                of_equations, 1.0, 4.0, 0);
    bench_ratio("qdd and its derivatives by q, qd, all contacts closed : qdd", of_slopes, of_qdd,
                1.0, 0.0, 0);
    bench_ratio("a stroke with sensitivities to 6 parameters : the 13 of central differences",
                of_ridden, of_stroke, 1.0 / 13.0, 0.0, 0);
    bench_ratio("derivatives of M qdd + c by q, qd, generated : M+c alone", of_equation_slopes,
                of_equations, 1.0, 0.0, 0);
}
