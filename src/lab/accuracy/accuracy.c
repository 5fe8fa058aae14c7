/* SPDX-License-Identifier: GPL-3.0-or-later
 * accuracy.c - how far the result of a run may be trusted (accuracy.h).
 */
#include "accuracy.h"

#include <math.h>
#include <stdlib.h>

static const double checkpoints = 1000.0; /* of a run */
static const double finer = 0.03;         /* tolerance relative to a controlled run */
static const double fine = 1e-12;         /* against steps of fixed length [rad or m] */
static const double finest = 1e-13;       /* rounding is near */
static const double longest_steps = 50.0; /* of the run */
static const double least_range = 1e-7;   /* of a motion, to compare an error with [rad or m] */
static const double least_energy = 1e-9;  /* the same, in parts of E */

/* a simulation beside the run */
typedef struct beside {
    stein_sim *sim;
    stein_pace pace;
    int failed;
} beside;

struct lab__accuracy {
    const stein_model *model;
    stein_balance *balance;
    beside whole, part;
    void *kept;                   /* the state of the run at the last checkpoint */
    double every, due, start, dt; /* [s] */
    int load, over;
    double *made, *deviation, *low, *high, *off; /* [nq] */
    lab__errors errors;
};

void lab__accuracy_destroy(lab__accuracy *t)
{
    if (t != NULL) {
        stein_balance_destroy(t->balance);
        stein_sim_destroy(t->whole.sim);
        stein_sim_destroy(t->part.sim);
        free(t->kept);
        free(t->made);
        free(t);
    }
}

static stein_status make_beside(beside *b, const lab_model *model, const stein_sim_def *def,
                                double tolerance, double longest, lab_drive *drive, stein_err *err)
{
    stein_sim_def own = *def;
    own.integrator = def->integrator == STEIN_IMPLICIT ? STEIN_IMPLICIT : STEIN_CONTROLLED;
    stein_status status = lab_sim(model, &own, &b->sim, err);
    if (status == STEIN_OK && drive != NULL) {
        status = lab_drive_bind(drive, b->sim, err);
        status = status == STEIN_OK ? stein_reset(b->sim, err) : status;
    }
    b->pace =
        (stein_pace){.tolerance = tolerance, .longest = longest, .h = def->dt, .next = INFINITY};
    return status;
}

stein_status lab__accuracy_create(lab__accuracy **out, const lab_model *model,
                                  const stein_sim_def *def, double tolerance, double until,
                                  lab_drive *drive, stein_err *err)
{
    lab__accuracy *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lab__no_memory(err);
    }
    t->model = lab_equations(model);
    t->dt = def->dt;
    t->every = fmax(until / checkpoints, def->dt);
    double own = lab__is_controlled(def->integrator) ? fmax(finer * tolerance, finest) : fine;
    double longest = fmin(t->every, longest_steps * def->dt);
    t->made = calloc(5 * (size_t)t->model->nq, sizeof *t->made);
    stein_status status = t->made != NULL ? STEIN_OK : lab__no_memory(err);
    status = status == STEIN_OK ? stein_balance_create(&t->balance, t->model, def, err) : status;
    if (status == STEIN_OK) {
        status = make_beside(&t->whole, model, def, own, longest, drive, err);
    }
    if (status == STEIN_OK) {
        status = make_beside(&t->part, model, def, own, longest, drive, err);
    }
    if (status == STEIN_OK) {
        t->kept = malloc(stein_state_size(t->whole.sim));
        status = t->kept != NULL ? STEIN_OK : lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        lab__accuracy_destroy(t);
        return status;
    }
    int nq = t->model->nq;
    t->deviation = t->made + nq;
    t->low = t->deviation + nq;
    t->high = t->low + nq;
    t->off = t->high + nq;
    *out = t;
    return STEIN_OK;
}

static void put_onto(lab__accuracy *t, beside *b, stein_sim *sim)
{
    stein_save(sim, t->kept);
    b->failed = b->failed || stein_restore(b->sim, t->kept, NULL) != STEIN_OK;
}

stein_status lab__accuracy_begin(lab__accuracy *t, stein_sim *sim, stein_err *err)
{
    const double *q = stein_q(sim);
    for (int j = 0; j < t->model->nq; j++) {
        t->low[j] = t->high[j] = q[j];
    }
    t->start = stein_time(sim);
    t->due = t->start + t->every;
    t->load = stein_load_present(sim);
    t->errors.lost = NAN;
    t->errors.gimbal = 1.0;
    put_onto(t, &t->whole, sim);
    put_onto(t, &t->part, sim);
    return stein_balance_attach(t->balance, sim, err);
}

/* ---- along the run ---- */

static int kind_of(const lab__accuracy *t, int joint)
{
    return t->model->bodies[joint].type == 'R' ? LAB_TURNS : LAB_SLIDES;
}

static void go_on(beside *b, double t)
{
    if (!b->failed && stein_time(b->sim) < t) {
        b->failed = stein_run_adaptive(b->sim, t, &b->pace, NULL) != STEIN_OK;
    }
}

/* ratios of errors to the ranges */
static void compare(lab__accuracy *t)
{
    lab__errors *e = &t->errors;
    for (int k = 0; k < LAB_KINDS; k++) {
        e->made[k] = e->deviation[k] = e->range[k] = 0.0;
    }
    for (int j = 0; j < t->model->nq; j++) {
        int k = kind_of(t, j);
        e->made[k] = fmax(e->made[k], t->made[j]);
        e->deviation[k] = fmax(e->deviation[k], t->deviation[j]);
        e->range[k] = fmax(e->range[k], t->high[j] - t->low[j]);
    }
    e->made_share = e->deviation_share = 0.0;
    for (int k = 0; k < LAB_KINDS; k++) {
        double range = fmax(e->range[k], least_range);
        e->made_share = fmax(e->made_share, e->made[k] / range);
        e->deviation_share = fmax(e->deviation_share, e->deviation[k] / range);
    }
}

static void look_for_gimbal_lock(lab__accuracy *t)
{
    lab__errors *e = &t->errors;
    int first, last;
    double value = stein_gimbal(t->whole.sim, &first, &last);
    if (value < e->gimbal) {
        e->gimbal = value;
        e->gimbal_time = stein_time(t->whole.sim);
        e->hinge[0] = first;
        e->hinge[1] = last;
    }
}

/* half of the turn of Rz(q0) Rx(q1) Ry(q2) Rz(q3) as a quaternion: scalar, x, y, z */
static void half_turn(const double *q, double out[4])
{
    double s[3], c[3], sum = 0.5 * (q[0] + q[3]), less = 0.5 * (q[0] - q[3]);
    for (int i = 1; i < 3; i++) {
        s[i] = sin(0.5 * q[i]);
        c[i] = cos(0.5 * q[i]);
    }
    out[0] = c[1] * c[2] * cos(sum) - s[1] * s[2] * sin(sum);
    out[1] = s[1] * c[2] * cos(less) - c[1] * s[2] * sin(less);
    out[2] = c[1] * s[2] * cos(less) + s[1] * c[2] * sin(less);
    out[3] = c[1] * c[2] * sin(sum) + s[1] * s[2] * cos(sum);
}

/* the angle between two attitudes of a ball, whose charts may differ [rad] */
static double angle_between(const double *q, const double *other)
{
    double a[4], b[4], x, y, z;
    half_turn(q, a);
    half_turn(other, b);
    x = a[0] * b[1] - a[1] * b[0] + a[3] * b[2] - a[2] * b[3];
    y = a[0] * b[2] - a[2] * b[0] + a[1] * b[3] - a[3] * b[1];
    z = a[0] * b[3] - a[3] * b[0] + a[2] * b[1] - a[1] * b[2];
    return 2.0 * asin(fmin(1.0, sqrt(x * x + y * y + z * z)));
}

/* |q - other| [nq]; of a ball as one angle, in its first coordinate */
static void differences(const lab__accuracy *t, const double *q, const double *other, double *out)
{
    for (int j = 0; j < t->model->nq; j++) {
        out[j] = fabs(q[j] - other[j]);
    }
    for (int i = 0; i < t->model->nball; i++) {
        int j = t->model->balls[i].joint;
        out[j] = angle_between(q + j, other + j);
        out[j + 1] = out[j + 2] = out[j + 3] = 0.0;
    }
}

static void check(lab__accuracy *t, stein_sim *sim)
{
    double now = stein_time(sim);
    const double *q = stein_q(sim);
    go_on(&t->whole, now);
    go_on(&t->part, now);
    differences(t, q, stein_q(t->part.sim), t->off);
    for (int j = 0; j < t->model->nq; j++) {
        t->made[j] += t->off[j];
    }
    differences(t, q, stein_q(t->whole.sim), t->off);
    for (int j = 0; j < t->model->nq; j++) {
        t->deviation[j] = fmax(t->deviation[j], t->off[j]);
    }
    compare(t);
    if (isnan(t->errors.lost) && t->errors.deviation_share > LAB_DOUBTFUL) {
        t->errors.lost = now;
    }
    put_onto(t, &t->part, sim);
    look_for_gimbal_lock(t);
}

void lab__accuracy_fail(lab__accuracy *t, const stein_sim *sim)
{
    go_on(&t->whole, stein_time(sim));
    look_for_gimbal_lock(t);
}

void lab__accuracy_step(lab__accuracy *t, stein_sim *sim)
{
    const double *q = stein_q(sim);
    if (t->over) {
        return;
    }
    for (int j = 0; j < t->model->nq; j++) {
        t->low[j] = fmin(t->low[j], q[j]);
        t->high[j] = fmax(t->high[j], q[j]);
    }
    int lifted = t->load && !stein_load_present(sim),
        due = stein_time(sim) >= t->due - 1e-6 * t->dt;
    if (lifted || due) {
        check(t, sim);
    }
    while (t->due - 1e-6 * t->dt <= stein_time(sim)) {
        t->due += t->every;
    }
    if (lifted) {
        t->load = 0;
        stein_load_lift(t->whole.sim);
    }
}

void lab__accuracy_end(lab__accuracy *t, stein_sim *sim)
{
    lab__errors *e = &t->errors;
    if (t->over) {
        return;
    }
    check(t, sim);
    (void)stein_balance_attach(t->balance, NULL, NULL);
    stein_balance_total(t->balance, &e->energy);
    e->energy_share = fabs(e->energy.unexplained) /
                      fmax(e->energy.scale, least_energy * fabs(e->energy.begin) + 1e-300);
    e->known = !t->whole.failed && !t->part.failed;
    t->over = 1;
}

const lab__errors *lab__accuracy_errors(const lab__accuracy *t)
{
    return &t->errors;
}

double lab__accuracy_work(const lab__accuracy *t, stein_work_kind kind, int index)
{
    return stein_balance_work(t->balance, kind, index);
}
