/* SPDX-License-Identifier: GPL-3.0-or-later
 * stroke.c - one stroke: rest, then GSL's rk8pd between events.
 *
 * Rest: the load lifted, all forces in balance. Newton with a step that starts short (the matrix
 * M/tau + K, tau growing) from the drawing's positions, K by differences. Then the load is set
 * flush on the key (gap 0) and let go at t = 0.
 *
 * Motion: Prince & Dormand's pair of order 8 in adaptive steps (local error below `tolerance`,
 * speeds in units of 300 rad/s). Modes are constant within a step. If a guard is on the wrong side
 * of its mode at the end of an accepted step, the step is repeated from its beginning with shorter
 * lengths, until its end is at most 1e-13 s past the first change (Newton from where the step's own
 * curve has it; regula falsi and bisection where that fails), the modes are changed, and a new step
 * starts. The record is an even grid, taken from the quintic through positions, speeds and
 * accelerations of a step's ends, and cubic (Hermite) between its points.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reality.h"

static const double time_resolution = 1e-13, longest = 3e-4, shortest = 1e-12;
enum { MAX_STEPS = 30000, MAX_SETTLE = 400, MAX_ROOT = 60, MAX_FORESEEN = 12, MAX_APPROACH = 6 };

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
    y[2 * mo->n + FLOW] = outside_memory_at_rest(mo->a);
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
    instant now, then; /* at the end of a step; at a point of the record */
    int next;          /* of the record */
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

/* y1, dydt1 and the guards there after one step of h: the stepper evaluates the rates at its end
 * last
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

static int first_wrong(const engine *e, int other_than)
{
    for (int i = 0; i < GUARDS; i++) {
        if (i != other_than && wrong(e, i)) {
            return i;
        }
    }
    return -1;
}

/* ---- within a step ---- */

/* A step that was made: both ends, h apart. */
typedef struct arc {
    double h, y0[MAX_STATE], dydt0[MAX_STATE], y1[MAX_STATE], dydt1[MAX_STATE];
} arc;

static void keep(const engine *e, double h, arc *c)
{
    c->h = h;
    memcpy(c->y0, e->y, sizeof c->y0);
    memcpy(c->dydt0, e->dydt, sizeof c->dydt0);
    memcpy(c->y1, e->y1, sizeof c->y1);
    memcpy(c->dydt1, e->dydt1, sizeof c->dydt1);
}

/* the state s after the beginning: positions by the quintic that has speeds and accelerations of
 * both ends, speeds as its derivative, memories by the cubic */
static void between(const engine *e, const arc *c, double s, double *y)
{
    int n = e->mo.n;
    double h = c->h, u = s / h, v = 1.0 - u;
    for (int i = 0; i < n; i++) {
        double d = c->y1[i] - c->y0[i], v0 = h * c->y0[n + i], v1 = h * c->y1[n + i];
        double a0 = 0.5 * h * h * c->dydt0[n + i], a1 = 0.5 * h * h * c->dydt1[n + i];
        double c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1;
        double c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1;
        double c5 = 6.0 * d - 3.0 * (v0 + v1) - a0 + a1;
        y[i] = c->y0[i] + u * (v0 + u * (a0 + u * (c3 + u * (c4 + u * c5))));
        y[n + i] = (v0 + u * (2.0 * a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h;
    }
    for (int i = 2 * n; i < 2 * n + MEMORIES; i++) {
        y[i] = v * v * (1.0 + 2.0 * u) * c->y0[i] + u * u * (1.0 + 2.0 * v) * c->y1[i] +
               u * v * h * (v * c->dydt0[i] - u * c->dydt1[i]);
    }
}

static double guard_between(engine *e, const arc *c, int i, double s)
{
    double y[MAX_STATE];
    between(e, c, s, y);
    motion_guards(&e->mo, e->t + s, y, &e->now);
    return e->now.guard[i];
}

/* where guard i changes on the arc (regula falsi, each end halved when it stays), and its slope */
static double foreseen(engine *e, const arc *c, int i, double g0, double *slope)
{
    double lo = 0.0, hi = c->h, glo = g0, ghi = e->now.guard[i], s = 0.0, d = 1e-4 * c->h;
    for (int n = 0, side = 0; n < MAX_FORESEEN; n++) {
        double last = s;
        s = (lo * ghi - hi * glo) / (ghi - glo);
        if (fabs(s - last) < 1e-7 * c->h) {
            break;
        }
        double g = guard_between(e, c, i, s);
        if ((g > 0.0) == (g0 > 0.0)) {
            lo = s;
            glo = g;
            ghi *= side == -1 ? 0.5 : 1.0;
            side = -1;
        } else {
            hi = s;
            ghi = g;
            glo *= side == 1 ? 0.5 : 1.0;
            side = 1;
        }
    }
    *slope = (guard_between(e, c, i, s + d) - guard_between(e, c, i, s - d)) / (2.0 * d);
    return s;
}

/* Newton with whole steps from where the change was foreseen to just past it: 1, or 0 when that
 * does not get there */
static int approach(engine *e, int i, double g0, double *hi)
{
    arc c;
    double slope;
    keep(e, *hi, &c);
    double h = foreseen(e, &c, i, g0, &slope);
    for (int n = 0; n < MAX_APPROACH && h > 0.0 && h < c.h; n++) {
        if (try_step(e, h) != 0) {
            return 0;
        }
        double off = e->now.guard[i] / slope;
        if (wrong(e, i) && fabs(off) <= time_resolution) {
            *hi = h;
            return 1;
        }
        h += 0.5 * time_resolution - off;
    }
    return 0;
}

/* the same by regula falsi and bisection with whole steps */
static int enclose(engine *e, int i, double g0, double ghi, double *hi)
{
    double lo = 0.0, glo = g0;
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
        }
    }
    return try_step(e, *hi);
}

/* from the end of a step of *hi back to just past the change of guard i, g0 at the beginning */
static int shorten(engine *e, int i, double g0, double *hi)
{
    double ghi = e->now.guard[i];
    if ((g0 > 0.0) != (ghi > 0.0)) {
        return approach(e, i, g0, hi) ? 0 : enclose(e, i, g0, ghi, hi);
    }
    // it was so from the beginning
    double h = fmin(*hi, time_resolution);
    if (try_step(e, h) == 0 && wrong(e, i)) {
        *hi = h;
        return 0;
    }
    return enclose(e, i, g0, ghi, hi);
}

/* the state past the first change in a step of h; the guards' values at its beginning are g0 */
static int to_first_change(engine *e, double h, const double *g0)
{
    int i = first_wrong(e, -1);
    for (int n = 0; n < GUARDS && i >= 0; n++) {
        double before = h;
        if (shorten(e, i, g0[i], &h) != 0) {
            return -1;
        }
        if (h <= time_resolution || (n > 0 && before - h < 10.0 * time_resolution)) {
            break;
        }
        i = first_wrong(e, i); // another guard that changed before
    }
    e->h = h;
    return 0;
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

static void visit(const engine *e, visits *v)
{
    const double *q = e->now.q;
    const segment *seg = e->now.seg;
    visits here = {.low = {-q[D_KEY], seg[S_HAMMER].phi - seg[e->now.rear].phi, q[D_PAWL]}};
    memcpy(here.high, here.low, sizeof here.high);
    for (int i = 0; i < SPOTS; i++) {
        int contact = i < NOTCH ? i : NOTCH;
        here.deepest[contact] = fmax(here.deepest[contact], e->now.pressed[i]);
    }
    visits_add(v, &here);
}

/* readings at the points of the grid up to t1, and on to there */
static void accept(engine *e, double h, double t1, stroke *s)
{
    arc c;
    double y[MAX_STATE];
    keep(e, h, &c);
    for (; e->next < s->n && e->next * s->step <= t1; e->next++) {
        double t = e->next * s->step;
        between(e, &c, t - e->t, y);
        motion_look(&e->mo, t, y, &e->then);
        motion_read(&e->mo, &e->then, s->y[e->next], s->yd[e->next]);
    }
    e->t = t1;
    memcpy(e->y, e->y1, sizeof e->y);
    memcpy(e->dydt, e->dydt1, sizeof e->dydt);
    visit(e, &s->seen);
}

/* is a guard on the wrong side in the middle of a step */
static int changed_midway(engine *e, double h)
{
    arc c;
    double end[GUARDS];
    keep(e, h, &c);
    memcpy(end, e->now.guard, sizeof end);
    guard_between(e, &c, 0, 0.5 * h);
    int found = first_wrong(e, -1) >= 0;
    memcpy(e->now.guard, end, sizeof end);
    return found;
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
                if (first_wrong(e, -1) >= 0 || h < 1e-7 || !changed_midway(e, h)) {
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
    if (first_wrong(e, -1) < 0) {
        accept(e, h, h < left ? e->t + h : target, s);
        return 0;
    }
    double usual = e->h;
    if (to_first_change(e, h, g0) != 0) {
        return -1;
    }
    accept(e, e->h, e->t + e->h, s);
    e->h = fmax(0.2 * usual, 1e-7);
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
    if (status == 0) {
        motion_read(&e.mo, &e.now, s->y[0], s->yd[0]);
        for (int i = 0; i < JOINTS; i++) {
            s->seen.low[i] = 1e9;
            s->seen.high[i] = -1e9;
        }
        visit(&e, &s->seen);
        e.next = 1;
    }
    for (int n = 0; status == 0 && e.next < s->n; n++) {
        status = n < MAX_STEPS ? advance(&e, (s->n - 1) * step, s) : -1;
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
