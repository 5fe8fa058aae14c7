/* SPDX-License-Identifier: GPL-3.0-or-later
 * stroke.c - one stroke: rest, then GSL's rk8pd between events.
 *
 * Rest: the load lifted, all forces in balance. Newton with a step that starts short (the matrix
 * M/tau + K, tau growing) from the drawing's positions, K by differences. Then the load is set
 * flush on the key (gap 0) and let go at t = 0.
 *
 * Motion: Prince & Dormand's pair of order 8 in adaptive steps (local error below `tolerance`,
 * speeds in units of 300 rad/s). Modes are constant within a step. After an accepted step whose end
 * has a guard on the wrong side of its mode the step is repeated from its beginning with shorter
 * lengths until the first change is enclosed to 1e-13 s (regula falsi, bisection when that is
 * slow), the state just past it is taken, the modes are changed, and a new step starts. Steps also
 * end on the grid of the record, which is cubic (Hermite) in between.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reality.h"

static const double time_resolution = 1e-13, longest = 1e-4, shortest = 1e-12;
enum { MAX_EVENTS = 20000, MAX_SETTLE = 400, MAX_ROOT = 60 };

/* ---- rest ---- */

static void modes_now(motion *mo, const double *guard)
{
    for (int i = 0; i < GUARDS; i++) {
        int push = i >= G_PUSH && i < G_PUSH + SPOTS;
        mo->mode[i] = push ? 1 : guard[i] > 0.0;
    }
    if (!mo->loaded) {
        mo->mode[G_TOUCH + LOAD] = mo->mode[G_NEAR + LOAD] = 0;
    }
}

/* the beak's end leaves the roof at the corner; it is caught when it comes below the roof's plane
 */
static void notch_memory(motion *mo)
{
    if (mo->mode[MODE_BESIDE]) {
        mo->mode[MODE_BESIDE] = mo->mode[G_ABOVE];
    } else {
        mo->mode[MODE_BESIDE] = !mo->mode[G_OVER] && mo->mode[G_ABOVE];
    }
}

/* modes as geometry has them; the beak counts as beside when it is past the corner and above */
static void modes_from_geometry(motion *mo, const double *y, instant *now)
{
    double dydt[MAX_STATE];
    memset(mo->mode, 0, sizeof mo->mode);
    for (int pass = 0; pass < 2; pass++) {
        motion_rates(mo, 0.0, y, dydt, now);
        modes_now(mo, now->guard);
        notch_memory(mo);
    }
}

/* accelerations at rest; the load is held */
static int balance(motion *mo, const double *y, double *acc)
{
    double dydt[MAX_STATE];
    instant now;
    modes_from_geometry(mo, y, &now);
    if (motion_rates(mo, 0.0, y, dydt, &now) != 0) {
        return -1;
    }
    memcpy(acc, dydt + mo->n, sizeof *acc * (size_t)mo->n);
    acc[mo->index[D_LOAD]] = 0.0;
    return 0;
}

static double length(const double *x, int n)
{
    double s = 0.0;
    for (int i = 0; i < n; i++) {
        s = fmax(s, fabs(x[i]));
    }
    return s;
}

/* (1/tau - d acc/dq) step = acc */
static int newton(motion *mo, double *y, const double *acc, double tau, double *step)
{
    int n = mo->n, sign, status = 0;
    gsl_matrix *A = gsl_matrix_alloc((size_t)n, (size_t)n);
    gsl_permutation *p = gsl_permutation_alloc((size_t)n);
    for (int k = 0; k < n && status == 0; k++) {
        double up[DOFS], down[DOFS], q = y[k], d = 1e-7;
        y[k] = q + d;
        status = balance(mo, y, up);
        y[k] = q - d;
        status = status == 0 ? balance(mo, y, down) : status;
        y[k] = q;
        for (int i = 0; i < n; i++) {
            gsl_matrix_set(A, (size_t)i, (size_t)k,
                           (i == k ? 1.0 / tau : 0.0) - (up[i] - down[i]) / (2.0 * d));
        }
    }
    if (status == 0) {
        gsl_vector_const_view b = gsl_vector_const_view_array(acc, (size_t)n);
        gsl_vector_view x = gsl_vector_view_array(step, (size_t)n);
        gsl_linalg_LU_decomp(A, p, &sign);
        status = gsl_linalg_LU_solve(A, p, &b.vector, &x.vector);
    }
    gsl_permutation_free(p);
    gsl_matrix_free(A);
    return status;
}

static int settle(motion *mo, double *y)
{
    double acc[DOFS], next[DOFS], step[DOFS], trial[MAX_STATE], tau = 1e-6;
    int n = mo->n;
    memset(y, 0, sizeof(double[MAX_STATE]));
    mo->loaded = 0;
    if (balance(mo, y, acc) != 0) {
        return -1;
    }
    for (int i = 0; i < MAX_SETTLE; i++) {
        if (newton(mo, y, acc, tau, step) != 0) {
            return -1;
        }
        double size = length(step, n), shorten = fmin(1.0, 0.01 / size);
        if (size < 1e-13 && tau > 1.0) {
            return 0;
        }
        memcpy(trial, y, sizeof trial);
        for (int k = 0; k < n; k++) {
            trial[k] += shorten * step[k];
        }
        if (balance(mo, trial, next) == 0 &&
            (length(next, n) < 3.0 * length(acc, n) || size < 1e-11)) {
            memcpy(y, trial, sizeof trial);
            memcpy(acc, next, sizeof acc);
            tau = fmin(3.0 * tau, 1e12);
        } else {
            tau *= 0.1;
        }
    }
    return -1;
}

static int begin(motion *mo, double *y, instant *now)
{
    if (settle(mo, y) != 0) {
        return -1;
    }
    motion_look(mo, 0.0, y, now);
    vec front = seg_place(&now->seg[S_KEY], mo->a->front);
    y[mo->index[D_LOAD]] = front.z;
    mo->front0 = front.z;
    mo->key0 = now->q[D_KEY];
    mo->loaded = 1;
    modes_from_geometry(mo, y, now);
    return 0;
}

/* ---- integration ---- */

typedef struct engine {
    motion mo;
    instant now;
    gsl_odeiv2_step *step;
    gsl_odeiv2_control *control;
    gsl_odeiv2_system system;
    size_t dim;
    double t, h;
    double y[MAX_STATE], dydt[MAX_STATE];
    double y1[MAX_STATE], dydt1[MAX_STATE], error[MAX_STATE];
} engine;

static int rates(double t, const double y[], double dydt[], void *ctx)
{
    engine *e = ctx;
    return motion_rates(&e->mo, t, y, dydt, &e->now);
}

/* y1, dydt1 and the guards there after one step of h: the stepper asks for the rates at its end last
 */
static int try_step(engine *e, double h)
{
    memcpy(e->y1, e->y, sizeof e->y);
    return gsl_odeiv2_step_apply(e->step, e->t, h, e->y1, e->error, e->dydt, e->dydt1, &e->system);
}

static int wrong(const engine *e, int i)
{
    return (e->now.guard[i] > 0.0) != e->mo.mode[i];
}

static int first_wrong(const engine *e)
{
    for (int i = 0; i < GUARDS; i++) {
        if (wrong(e, i)) {
            return i;
        }
    }
    return -1;
}

/* the end of a step that holds no change of guard i; *hi is just past it, g its values there */
static int enclose(engine *e, int i, double g0, double *hi)
{
    double lo = 0.0, glo = g0, ghi = e->now.guard[i];
    for (int n = 0, side = 0; n<MAX_ROOT && * hi - lo> time_resolution; n++) {
        double h = n % 6 == 5 || !(glo * ghi < 0.0) ? 0.5 * (lo + *hi)
                                                    : (lo * ghi - *hi * glo) / (ghi - glo);
        if (!(h > lo && h < *hi)) {
            h = 0.5 * (lo + *hi);
        }
        if (try_step(e, h) != 0) {
            return -1;
        }
        double g = e->now.guard[i];
        if (wrong(e, i)) {
            *hi = h;
            ghi = g;
            glo *= side == 1 ? 0.5 : 1.0;
            side = 1;
        } else {
            lo = h;
            glo = g;
            ghi *= side == -1 ? 0.5 : 1.0;
            side = -1;
            // close in from below: the next try is a little past the root
            if (fabs(g) < 1e-15) {
                lo = h;
                glo = g;
            }
        }
    }
    return 0;
}

/* the state past the first change in a step of h; the guards' values at its beginning are g0 */
static int to_first_change(engine *e, double h, const double *g0)
{
    double hi = h;
    for (int n = 0; n < GUARDS; n++) {
        int i = first_wrong(e), status = try_step(e, hi);
        if (status != 0) {
            return status;
        }
        i = first_wrong(e);
        if (i < 0 || enclose(e, i, g0[i], &hi) != 0) {
            return -1;
        }
        if (try_step(e, hi) != 0) {
            return -1;
        }
        int others = 0;
        for (int k = 0; k < GUARDS; k++) {
            others += k != i && wrong(e, k);
        }
        if (others == 0 || hi <= time_resolution) {
            break;
        }
        // another guard changed before: look for that one in what is left
        int earlier = -1;
        for (int k = 0; k < GUARDS && earlier < 0; k++) {
            earlier = k != i && wrong(e, k) ? k : -1;
        }
        double before = hi;
        if (enclose(e, earlier, g0[earlier], &hi) != 0) {
            return -1;
        }
        if (before - hi < 10.0 * time_resolution) {
            break;
        }
    }
    e->h = hi;
    return try_step(e, hi);
}

static void change_modes(engine *e, stroke *s)
{
    motion *mo = &e->mo;
    int string = mo->mode[G_TOUCH + STRING];
    for (int i = 0; i < GUARDS; i++) {
        mo->mode[i] = e->now.guard[i] > 0.0;
    }
    notch_memory(mo);
    if (mo->mode[MODE_BESIDE] && !(s->escape > 0.0)) {
        s->escape = e->t;
    }
    if (!string && mo->mode[G_TOUCH + STRING] && !(s->impact > 0.0)) {
        s->impact = e->t;
    }
    if (string && !mo->mode[G_TOUCH + STRING] && !(s->rebound > 0.0)) {
        s->rebound = e->t;
    }
}

static void accept(engine *e, double h)
{
    e->t += h;
    memcpy(e->y, e->y1, sizeof e->y);
    memcpy(e->dydt, e->dydt1, sizeof e->dydt);
}

/* is a guard on the wrong side in the middle of a step (cubic through both ends) */
static int changed_midway(engine *e, double h)
{
    double y[MAX_STATE], dydt[MAX_STATE];
    instant end = e->now;
    for (size_t i = 0; i < e->dim; i++) {
        y[i] = 0.5 * (e->y[i] + e->y1[i]) + 0.125 * h * (e->dydt[i] - e->dydt1[i]);
    }
    int status = rates(e->t + 0.5 * h, y, dydt, e), found = first_wrong(e) >= 0;
    e->now = end;
    return status == 0 && found;
}

/* one accepted step towards `target`, shortened by accuracy and by events */
static int advance(engine *e, double target, stroke *s)
{
    double g0[GUARDS], left = target - e->t, h;
    memcpy(g0, e->now.guard, sizeof g0);
    for (;;) {
        h = fmin(fmin(e->h, longest), left);
        double proposed = h;
        int status = try_step(e, h);
        if (status != 0) {
            e->h = 0.1 * h;
        } else {
            int change = gsl_odeiv2_control_hadjust(e->control, e->step, e->y1, e->error, e->dydt1,
                                                    &proposed);
            if (change != GSL_ODEIV_HADJ_DEC) {
                e->h = h < left || proposed > e->h ? proposed : e->h;
                if (first_wrong(e) >= 0 || h < 1e-7 || !changed_midway(e, h)) {
                    break;
                }
                proposed = 0.5 * h; // something touched and left again
            }
            e->h = proposed;
        }
        if (!(e->h > shortest)) {
            return -1;
        }
    }
    if (first_wrong(e) < 0) {
        accept(e, h);
        e->t = h < left ? e->t : target;
        return 0;
    }
    double keep = e->h;
    if (to_first_change(e, h, g0) != 0) {
        return -1;
    }
    accept(e, e->h);
    e->h = fmax(0.2 * keep, 1e-7);
    change_modes(e, s);
    gsl_odeiv2_step_reset(e->step);
    return rates(e->t, e->y, e->dydt, e);
}

static int open_engine(engine *e, const action *a, double tolerance)
{
    double scale[MAX_STATE];
    motion_init(&e->mo, a);
    e->dim = (size_t)(2 * e->mo.n + MEMORIES);
    for (size_t i = 0; i < e->dim; i++) {
        scale[i] = i >= (size_t)e->mo.n && i < 2 * (size_t)e->mo.n ? 300.0 : 1.0;
    }
    e->system = (gsl_odeiv2_system){rates, NULL, e->dim, e};
    e->step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, e->dim);
    e->control = gsl_odeiv2_control_scaled_new(tolerance, 0.0, 1.0, 0.0, scale, e->dim);
    e->t = 0.0;
    e->h = 1e-6;
    if (begin(&e->mo, e->y, &e->now) != 0) {
        return -1;
    }
    return rates(0.0, e->y, e->dydt, e);
}

int stroke_run(stroke *s, const action *a, double until, double step, double tolerance)
{
    engine e;
    memset(&e, 0, sizeof e);
    memset(s, 0, sizeof *s);
    s->step = step;
    s->n = (int)ceil(until / step) + 1;
    s->y = calloc((size_t)s->n, sizeof *s->y);
    s->yd = calloc((size_t)s->n, sizeof *s->yd);
    int status = s->y != NULL && s->yd != NULL ? open_engine(&e, a, tolerance) : -1;
    for (int i = 0; status == 0 && i < s->n; i++) {
        for (int n = 0; status == 0 && e.t < i * step; n++) {
            status = n < MAX_EVENTS ? advance(&e, i * step, s) : -1;
        }
        motion_read(&e.mo, &e.now, s->y[i], s->yd[i]);
    }
    s->key_rest = -e.mo.key0;
    s->evaluations = e.mo.evaluations;
    gsl_odeiv2_step_free(e.step);
    gsl_odeiv2_control_free(e.control);
    if (status != 0) {
        stroke_free(s);
    }
    return status;
}

void stroke_free(stroke *s)
{
    free(s->y);
    free(s->yd);
    s->y = s->yd = NULL;
}

double stroke_at(const stroke *s, int channel, double t, double *rate)
{
    double x = t / s->step;
    if (x <= 0.0 || x >= s->n - 1) {
        int end = x <= 0.0 ? 0 : s->n - 1;
        if (rate != NULL) {
            *rate = 0.0;
        }
        return s->y[end][channel];
    }
    int i = (int)x;
    double u = x - i, v = 1.0 - u, h = s->step;
    double y0 = s->y[i][channel], y1 = s->y[i + 1][channel];
    double d0 = h * s->yd[i][channel], d1 = h * s->yd[i + 1][channel];
    if (rate != NULL) {
        *rate = (6.0 * u * v * (y1 - y0) + v * (v - 2.0 * u) * d0 + u * (u - 2.0 * v) * d1) / h;
    }
    return v * v * (1.0 + 2.0 * u) * y0 + u * u * (1.0 + 2.0 * v) * y1 + u * v * (v * d0 - u * d1);
}
