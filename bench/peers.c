/* SPDX-License-Identifier: GPL-3.0-or-later
 * peers.c - steppers of GSL and CVODE on the right-hand side of a simulation.
 *
 * y = {q, qd}. A stepper without events calls a right-hand side that determines the contacts by
 * itself: the guards at the same poses decide about the modes, then the forces follow as in any
 * evaluation of ours. The notch's region is memory: the one of the last accepted step is kept while
 * it is valid. Nothing locates switches; the step control has to get over them.
 *
 * Tolerances are absolute; a speed may be wrong by 100 times as much a second as a coordinate,
 * which served all of them best (1 and 1000 were tried).
 */
#include "peers.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <string.h>

#include "core.h"

enum { MAX_NQ = 16, MAX_STEPS = 200000 };
static const double speed_scale = 100.0; /* [1/s] */

typedef struct side {
    stein_sim *sim;
    unsigned char beside; /* region of the notch, as of the last accepted step */
    long calls;
} side;

/* the modes that the poses of an evaluation give; @return the notch's region */
static unsigned char find_modes(side *s)
{
    stein_sim *sim = s->sim;
    const stein_model *model = sim->model;
    double overlap, guard[NOTCH_GUARDS];
    for (int i = 0; i < model->nspot; i++) {
        sim->mode[i] = stein__spot_guard(sim, i) > 0.0;
    }
    if (model->nnotch == 0) {
        return 0;
    }
    flag *mode = sim->mode + model->nspot;
    mode[NOTCH_REGION] = s->beside;
    stein__notch_guards(sim, 0, guard, &overlap);
    if ((guard[NOTCH_REGION] > 0.0) != s->beside) {
        mode[NOTCH_REGION] = !s->beside;
        stein__notch_guards(sim, 0, guard, &overlap);
    }
    for (int k = 0; k < NOTCH_REGION; k++) {
        mode[k] = guard[k] > 0.0;
    }
    return mode[NOTCH_REGION];
}

static void place_at(stein_sim *sim, const double *y)
{
    int nq = sim->model->nq;
    copy(sim->xq, y, nq);
    copy(sim->xqd, y + nq, nq);
    stein_turn(sim->model, sim->xq, sim->sc);
    sim->model->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
}

static int derivative(double t, const double *y, double *f, void *ctx)
{
    side *s = ctx;
    int nq = s->sim->model->nq;
    (void)t;
    s->calls++;
    place_at(s->sim, y);
    (void)find_modes(s);
    stein__forces(s->sim);
    copy(f, s->sim->xqd, nq);
    return stein__accelerate(s->sim, f + nq) < 0 ? 0 : -1;
}

/* a step was accepted: present memory of the notch */
static void accept(side *s, const double *y)
{
    place_at(s->sim, y);
    s->beside = find_modes(s);
}

static side begin(stein_sim *sim, double *y)
{
    int nq = sim->model->nq;
    copy(y, sim->q, nq);
    copy(y + nq, sim->qd, nq);
    sim->inside = 1; // no guards beside those that are asked for
    return (side){sim, sim->model->nnotch > 0 && sim->mode[sim->model->nspot + NOTCH_REGION], 0};
}

static int end(side *s, int status, long *calls)
{
    s->sim->inside = 0;
    s->sim->fresh = STALE;
    *calls = s->calls;
    return status;
}

static int run_gsl(const void *method, stein_sim *sim, double tolerance, const double *at, int n,
                   double *q, long *calls)
{
    int nq = sim->model->nq, status = GSL_SUCCESS;
    double y[2 * MAX_NQ], scale[2 * MAX_NQ], t = stein_time(sim);
    side s = begin(sim, y);
    for (int j = 0; j < 2 * nq; j++) {
        scale[j] = j < nq ? 1.0 : speed_scale;
    }
    gsl_odeiv2_system system = {derivative, NULL, (size_t)(2 * nq), &s};
    gsl_odeiv2_driver *d =
        gsl_odeiv2_driver_alloc_scaled_new(&system, *(const gsl_odeiv2_step_type *const *)method,
                                           1e-6, tolerance, 0.0, 1.0, 0.0, scale);
    int steps = 0;
    for (int i = 0; d != NULL && status == GSL_SUCCESS && i < n; i++) {
        while (status == GSL_SUCCESS && t < at[i]) {
            status = gsl_odeiv2_evolve_apply(d->e, d->c, d->s, &system, &t, at[i], &d->h, y);
            accept(&s, y);
            status = ++steps > MAX_STEPS ? GSL_FAILURE : status;
        }
        memcpy(q + i * nq, y, sizeof *q * (size_t)nq);
    }
    int gone = d != NULL && status == GSL_SUCCESS ? 0 : -1;
    gsl_odeiv2_driver_free(d);
    return end(&s, gone, calls);
}

#ifdef BENCH_CVODE

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

static int cvode_derivative(realtype t, N_Vector y, N_Vector f, void *ctx)
{
    return derivative(t, N_VGetArrayPointer(y), N_VGetArrayPointer(f), ctx);
}

/* Adams' formulas with fixed-point iteration: settings for a system that is not stiff */
static int run_cvode(const void *method, stein_sim *sim, double tolerance, const double *at, int n,
                     double *q, long *calls)
{
    int nq = sim->model->nq, status = -1;
    double y0[2 * MAX_NQ];
    side s = begin(sim, y0);
    SUNContext context;
    (void)method;
    if (SUNContext_Create(NULL, &context) != 0) {
        return end(&s, -1, calls);
    }
    N_Vector y = N_VMake_Serial(2 * nq, y0, context), seen = N_VNew_Serial(2 * nq, context);
    N_Vector scale = N_VNew_Serial(2 * nq, context);
    void *solver = CVodeCreate(CV_ADAMS, context);
    SUNNonlinearSolver fixed = SUNNonlinSol_FixedPoint(y, 0, context);
    for (int j = 0; j < 2 * nq; j++) {
        NV_Ith_S(scale, j) = tolerance * (j < nq ? 1.0 : speed_scale);
    }
    double t = stein_time(sim);
    status = CVodeInit(solver, cvode_derivative, t, y);
    status = status == 0 ? CVodeSVtolerances(solver, 1e-15, scale) : status;
    status = status == 0 ? CVodeSetUserData(solver, &s) : status;
    status = status == 0 ? CVodeSetNonlinearSolver(solver, fixed) : status;
    status = status == 0 ? CVodeSetErrFile(solver, NULL) : status;
    int steps = 0;
    for (int i = 0; status == 0 && i < n;) {
        status = CVode(solver, at[n - 1], y, &t, CV_ONE_STEP);
        accept(&s, N_VGetArrayPointer(y));
        status = status == 0 && ++steps > MAX_STEPS ? -1 : status;
        for (; status == 0 && i < n && at[i] <= t; i++) { // what lies behind, by interpolation
            status = CVodeGetDky(solver, at[i], 0, seen);
            memcpy(q + i * nq, N_VGetArrayPointer(seen), sizeof *q * (size_t)nq);
        }
    }
    CVodeFree(&solver);
    SUNNonlinSolFree(fixed);
    N_VDestroy(y);
    N_VDestroy(seen);
    N_VDestroy(scale);
    SUNContext_Free(&context);
    return end(&s, status == 0 ? 0 : -1, calls);
}

#endif

int peers_all(const peer **list)
{
    static const peer all[] = {
        {"GSL rk8pd", run_gsl, &gsl_odeiv2_step_rk8pd},
        {"GSL rkf45", run_gsl, &gsl_odeiv2_step_rkf45},
        {"GSL rkck", run_gsl, &gsl_odeiv2_step_rkck},
        {"GSL rk4 (step doubling)", run_gsl, &gsl_odeiv2_step_rk4},
        {"GSL msadams", run_gsl, &gsl_odeiv2_step_msadams},
#ifdef BENCH_CVODE
        {"CVODE Adams", run_cvode, NULL},
#endif
    };
    gsl_set_error_handler_off();
    *list = all;
    return (int)(sizeof all / sizeof *all);
}
