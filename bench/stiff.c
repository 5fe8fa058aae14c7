/* SPDX-License-Identifier: GPL-3.0-or-later
 * stiff.c - the stiff governor (IFToMM benchmark A05) at an accuracy: our steps, which go over to
 * implicit ones by themselves, against CVODE's backward differences on the same right-hand side.
 *
 * Ten seconds, seen at ten times; the error is the largest of all joints. The reference has the
 * smallest tolerance that rounding allows. Every method is run with tolerances from coarse to fine
 * until it is accurate enough, then timed in turn.
 */
#include <math.h>
#include <string.h>

#include "bench.h"

enum { SEEN = 10, REPEATS = 9, NQ = 4 };

static double exact[SEEN][NQ];

typedef struct eye {
    double (*q)[NQ];
    int i;
} eye;

static double look(void *ctx, stein_sim *sim)
{
    eye *e = ctx;
    memcpy(e->q[e->i++], stein_q(sim), sizeof *e->q);
    return e->i < SEEN ? 1.0 + e->i : INFINITY;
}

/* @return 0, or -1 */
static int run_ours(stein_sim *sim, double tolerance, double q[SEEN][NQ])
{
    eye e = {q, 0};
    stein_pace pace = {
        .tolerance = tolerance, .longest = 1.0, .h = 1e-4, .next = 1.0, .look = look, .ctx = &e};
    return stein_run_adaptive(sim, SEEN, &pace, NULL) == STEIN_OK ? 0 : -1;
}

#ifdef BENCH_CVODE
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

static const double wanted = 1e-6; /* error of any joint [rad or m] */

static int right_side(realtype t, N_Vector y, N_Vector f, void *ctx)
{
    const double *at = N_VGetArrayPointer(y);
    double *to = N_VGetArrayPointer(f);
    memcpy(to, at + NQ, sizeof *to * NQ);
    return stein_acceleration(ctx, t, at, at + NQ, to + NQ, NULL) == STEIN_OK ? 0 : -1;
}

/* its dense matrix by difference quotients, as it comes */
static int run_cvode(stein_sim *sim, double tolerance, double q[SEEN][NQ])
{
    double y0[2 * NQ], t = 0.0;
    SUNContext context;
    if (SUNContext_Create(NULL, &context) != 0) {
        return -1;
    }
    memcpy(y0, stein_q(sim), sizeof *y0 * NQ);
    memcpy(y0 + NQ, stein_qd(sim), sizeof *y0 * NQ);
    N_Vector y = N_VMake_Serial(2 * NQ, y0, context);
    SUNMatrix matrix = SUNDenseMatrix(2 * NQ, 2 * NQ, context);
    SUNLinearSolver linear = SUNLinSol_Dense(y, matrix, context);
    void *solver = CVodeCreate(CV_BDF, context);
    int status = CVodeInit(solver, right_side, 0.0, y);
    status = status == 0 ? CVodeSStolerances(solver, tolerance, tolerance) : status;
    status = status == 0 ? CVodeSetUserData(solver, sim) : status;
    status = status == 0 ? CVodeSetLinearSolver(solver, linear, matrix) : status;
    status = status == 0 ? CVodeSetMaxNumSteps(solver, 1000000) : status;
    for (int i = 0; status == 0 && i < SEEN; i++) {
        status = CVode(solver, 1.0 + i, y, &t, CV_NORMAL) >= 0 ? 0 : -1;
        memcpy(q[i], N_VGetArrayPointer(y), sizeof *q);
    }
    CVodeFree(&solver);
    SUNLinSolFree(linear);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    SUNContext_Free(&context);
    return status;
}

static double error_of(double q[SEEN][NQ])
{
    double most = 0.0;
    for (int i = 0; i < SEEN; i++) {
        for (int j = 0; j < NQ; j++) {
            most = fmax(most, fabs(q[i][j] - exact[i][j]));
        }
    }
    return most;
}

typedef int run_of(stein_sim *sim, double tolerance, double q[SEEN][NQ]);

/* the coarsest tolerance that is accurate enough, 0: none */
static double find_tolerance(const char *name, stein_sim *sim, run_of *run)
{
    for (double tolerance = 1e-3; tolerance > 1e-14; tolerance /= sqrt(10.0)) {
        double q[SEEN][NQ];
        stein_err err;
        bench_need(stein_reset(sim, &err), &err, "governor");
        if (run(sim, tolerance, q) == 0 && error_of(q) <= wanted) {
            printf("stiff governor, %s: tolerance %.1e, off by %.1e\n", name, tolerance,
                   error_of(q));
            return tolerance;
        }
    }
    printf("stiff governor, %s: no tolerance reached %g\n", name, wanted);
    return 0.0;
}

static double time_of(stein_sim *sim, run_of *run, double tolerance)
{
    double q[SEEN][NQ];
    stein_err err;
    bench_need(stein_reset(sim, &err), &err, "governor");
    double before = bench_clock();
    (void)run(sim, tolerance, q);
    return bench_clock() - before;
}

static void compare(stein_sim *sim)
{
    double ours = find_tolerance("controlled steps", sim, run_ours);
    double theirs = find_tolerance("CVODE, backward differences", sim, run_cvode);
    double ratio[REPEATS];
    stein_step_counts n;
    stein_steps_taken(sim, &n);
    bench_check("stiff governor: implicit steps, by themselves", n.implicit > 0 ? 0.0 : 1.0, 0.0);
    for (int k = 0; ours > 0.0 && theirs > 0.0 && k < REPEATS; k++) {
        double a = time_of(sim, run_ours, ours);
        ratio[k] = a / time_of(sim, run_cvode, theirs);
    }
    if (ours > 0.0 && theirs > 0.0) {
        bench_row("stiff governor at 1e-6, controlled steps : CVODE", ratio, REPEATS, 3.0, 0);
    }
}

#else

static void compare(stein_sim *sim)
{
    (void)sim;
    printf("CVODE was not there when this was compiled: apt-get install libsundials-dev\n");
}

#endif

void stiff_rows(void)
{
    lab_model *model = NULL;
    lab_options options = lab_options_default();
    stein_sim *sim = NULL;
    stein_err err;
    bench_need(lab_open(&model, "tests/validate/governor.yaml", &options, &err), &err, "governor");
    stein_sim_def def = lab_def(model);
    def.integrator = STEIN_CONTROLLED;
    bench_need(lab_sim(model, &def, &sim, &err), &err, "governor");
    bench_check("stiff governor: reference", run_ours(sim, 1e-13, exact), 0.0);
    compare(sim);
    stein_sim_destroy(sim);
    lab_close(model);
}
