/* SPDX-License-Identifier: MIT
 * derivative.c - derivatives of qdd (derivative.h).
 *
 * Along a direction {dq, dqd, dd}, with R = M qdd + c at the qdd of the place,
 *
 *      M dqdd = dQ - dR        free joints, M without the rows and columns of the others
 *      dqdd_j = its signal's   joints that follow one; 0 where held
 *
 * M is factored once for a place. Everything is read from the last evaluation of the simulation:
 * nothing is worked out twice.
 */
#include <math.h>
#include <string.h>

#include "slopes.h"

stein__constants stein__carve_constants(stein__arena *a, const stein_model *model)
{
    double *dd = stein__carve_doubles(a, model->nd);
    int *moved = stein__carve(a, sizeof *moved * (size_t)model->nd);
    return (stein__constants){dd, moved, 0};
}

static size_t layout(stein_derivative *s, const stein_model *m)
{
    stein_derivative measured = {.parent = NULL};
    stein__arena a = {(unsigned char *)s, 0};
    int n = m->nq;
    s = s != NULL ? s : &measured;
    stein__carve(&a, sizeof *s);
    s->parent = stein__carve(&a, sizeof *s->parent * (size_t)n);
    s->driver = stein__carve(&a, sizeof *s->driver * (size_t)n);
    double **const vector[] = {&s->qdd, &s->inverse, &s->dq,   &s->dqd,
                               &s->dQ,  &s->dR,      &s->dqdd, &s->c};
    double **const matrix[] = {&s->factor, &s->M, &s->Qq, &s->Qqd, &s->Rq, &s->Rqd};
    for (size_t i = 0; i < sizeof vector / sizeof *vector; i++) {
        *vector[i] = stein__carve_doubles(&a, n);
    }
    for (size_t i = 0; i < sizeof matrix / sizeof *matrix; i++) {
        *matrix[i] = stein__carve_doubles(&a, n * n);
    }
    s->way = stein__carve(&a, sizeof *s->way * (size_t)n);
    s->S = stein__carve(&a, sizeof *s->S * (size_t)n);
    s->V = stein__carve(&a, sizeof *s->V * (size_t)n);
    s->dp = stein__carve_doubles(&a, m->np);
    s->none = stein__carve_constants(&a, m);
    s->own = stein__carve_constants(&a, m);
    s->du = stein__carve_doubles(&a, 3 * m->ninput);
    s->dpose = stein__carve(&a, sizeof *s->dpose * (size_t)m->nframe);
    stein__points_carve(&s->points, &a, m);
    s->tangent = stein__carve(&a, stein__tangent_size(m));
    return a.used;
}

static int has_derivatives(const stein_model *model)
{
    return model->setup_along != NULL && model->inverse_along != NULL &&
           (model->nframe == 0 || model->pose_along != NULL);
}

size_t stein__derivative_size(const stein_model *model)
{
    return model->nstick == 0 && has_derivatives(model) ? layout(NULL, model) : 0;
}

stein_derivative *stein__derivative_make(void *block, const stein_model *model)
{
    stein_derivative *s = block;
    memset(s, 0, layout(NULL, model));
    (void)layout(s, model);
    s->model = model;
    s->tangent = stein__tangent_make(s->tangent, model);
    for (int j = 0; j < model->nq; j++) {
        s->parent[j] = model->bodies[j].parent;
    }
    return s;
}

stein_status stein_derivative_create(stein_derivative **out, const stein_model *model,
                                     const stein_sim_def *def, stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (model->nrow > 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "\"%s\" has loops or couplings, of which there are no derivatives yet",
                           model->name);
    }
    if (model->nstick > 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "\"%s\" has friction that sticks, of which there are no derivatives",
                           model->name);
    }
    if (stein__in_space(model)) {
        return stein__fail(err, STEIN_EINVAL,
                           "\"%s\" has bodies that turn in all directions or contacts in space, of "
                           "which there are no derivatives yet",
                           model->name);
    }
    if (!has_derivatives(model)) {
        return stein__fail(err, STEIN_EINVAL,
                           "the equations of \"%s\" came without derivatives: generate them again",
                           model->name);
    }
    size_t size = layout(NULL, model);
    stein_derivative *s = own.alloc(own.ctx, size);
    if (s == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory for derivatives of \"%s\"",
                           model->name);
    }
    *out = stein__derivative_make(s, model);
    (*out)->def = own;
    return STEIN_OK;
}

void stein_derivative_destroy(stein_derivative *s)
{
    if (s != NULL) {
        s->def.release(s->def.ctx, s);
    }
}

/* ---- the place ---- */

static stein_status check(const stein_derivative *s, const stein_sim *sim, stein_err *err)
{
    if (sim->model != s->model) {
        return stein__fail(err, STEIN_EINVAL,
                           "derivatives of \"%s\" were asked for in a simulation of other "
                           "equations (\"%s\")",
                           s->model->name, sim->model->name);
    }
    if (sim->on_force != NULL) {
        return stein__fail(err, STEIN_EINVAL,
                           "\"%s\": a force hook has no derivative: unbind it (stein_on_force)",
                           s->model->name);
    }
    if (sim->jacobians) {
        return stein__fail(
            err, STEIN_EINVAL,
            "\"%s\": no derivative of the force of a link or an input at a point off "
            "the plane: expected bodies that move in the x-z plane",
            s->model->name);
    }
    return STEIN_OK;
}

/* M of the free joints in its factors, which a large tree's solution left in its place; articulated
 * bodies have not made it */
static void factor(stein_derivative *s)
{
    const stein_model *model = s->model;
    const stein_sim *sim = s->sim;
    int n = model->nq;
    if (model->articulated != NULL) {
        model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, s->factor, s->c);
    } else {
        memcpy(s->factor, sim->M, sizeof *s->factor * (size_t)(n * n));
    }
    if (model->articulated != NULL || model->solve != NULL) {
        (void)stein__factor(n, s->parent, s->factor, s->inverse);
    } else {
        memcpy(s->inverse, sim->inverse, sizeof *s->inverse * (size_t)n);
    }
}

stein_status stein_derivative_at(stein_derivative *s, stein_sim *sim, double t, const double *q,
                                 const double *qd, double *qdd, stein_err *err)
{
    s->sim = NULL;
    stein_status status = check(s, sim, err);
    return status == STEIN_OK ? stein__derivative_at(s, sim, t, q, qd, qdd, err) : status;
}

stein_status stein__derivative_at(stein_derivative *s, stein_sim *sim, double t, const double *q,
                                  const double *qd, double *qdd, stein_err *err)
{
    stein_status status;
    s->sim = NULL;
    sim->fresh = STALE;
    sim->inside = INSIDE; // guards are not asked for
    status = stein__evaluate(sim, t, q, qd, s->qdd, err);
    sim->inside = AT_END;
    if (status != STEIN_OK) {
        return status;
    }
    s->sim = sim;
    s->placed = s->driven = 0;
    for (int j = 0; j < s->model->nq; j++) {
        s->driver[j] =
            sim->motions || sim->model->load.body == j ? stein__driver_of(sim, j) : STEIN__FREE;
        s->driven |= s->driver[j] != STEIN__FREE;
    }
    factor(s);
    if (qdd != NULL) {
        copy(qdd, s->qdd, s->model->nq);
    }
    return STEIN_OK;
}

/* ---- along a direction ---- */

static void place_tangent(stein_derivative *s)
{
    const stein_sim *sim = s->sim;
    stein__at at = {.d = sim->d,
                    .q = sim->xq,
                    .qd = sim->xqd,
                    .pose = (const double *)(const void *)sim->pose,
                    .u = sim->ustate,
                    .signal = sim->signal,
                    .mode = sim->mode,
                    .load_present = sim->head->load_present,
                    .signals = sim->signals};
    if (!s->placed && sim->jacobians) {
        stein__points_place(s);
        at.px = s->points.x;
        at.pv = s->points.v;
        at.pJ = s->points.J;
    }
    if (!s->placed) {
        stein__tangent_place(s->tangent, &at, s->known != sim || s->taken != sim->taken);
        s->placed = 1;
        s->known = sim;
        s->taken = sim->taken;
    }
}

/* signals along a direction of their gains; how the joints that follow them move, and how their
 * accelerations: in dqdd, 0 for the others */
static void follow(stein_derivative *s, const double *dd)
{
    const stein_model *model = s->model;
    memset(s->du, 0, sizeof *s->du * (size_t)(3 * model->ninput));
    memset(s->dqdd, 0, sizeof *s->dqdd * (size_t)model->nq);
    for (int i = 0; i < model->ninput; i++) {
        int at = model->inputs[i].signal + STEIN_SIGNAL_GAIN;
        double gain = s->sim->d[at], dgain = dd[at];
        for (int k = 0; s->sim->signal[i] != NULL && dgain != 0.0 && k < 3; k++) {
            s->du[3 * i + k] = dgain * s->sim->ustate[3 * i + k] / gain;
        }
    }
    for (int j = 0; s->driven && j < model->nq; j++) {
        if (s->driver[j] >= 0) {
            s->dq[j] = s->du[3 * s->driver[j]];
            s->dqd[j] = s->du[3 * s->driver[j] + 1];
            s->dqdd[j] = s->du[3 * s->driver[j] + 2];
        }
    }
}

/* b becomes the free joints' dqdd; those of the others are in dqdd */
static void solve(stein_derivative *s, double *b)
{
    stein_sim *sim = s->sim;
    int n = s->model->nq, moved = 0;
    for (int j = 0; s->driven && j < n; j++) {
        moved |= s->driver[j] != STEIN__FREE && s->dqdd[j] != 0.0;
    }
    if (moved) { // the columns of M that have been taken out of it
        s->model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, s->M, s->c);
        for (int j = 0; j < n; j++) {
            for (int i = 0; s->driver[j] != STEIN__FREE && i < n; i++) {
                b[i] -= s->M[i * n + j] * s->dqdd[j];
            }
        }
    }
    for (int j = 0; s->driven && j < n; j++) {
        b[j] = s->driver[j] != STEIN__FREE ? s->dqdd[j] : b[j];
    }
    stein__substitute(n, s->parent, s->factor, s->inverse, b, 1);
}

/* {dq, dqd} of s and dd, signals followed, with the poses along it */
static stein__direction direction_of(stein_derivative *s, const stein__constants *dd)
{
    const stein_model *model = s->model;
    const stein_sim *sim = s->sim;
    place_tangent(s);
    if (model->nframe > 0) {
        model->pose_along(sim->xq, sim->xqd, sim->sc, sim->d, s->dq, s->dqd, dd->dd, s->dpose);
    }
    if (sim->jacobians) {
        stein__points_along(s);
    }
    return (stein__direction){.dq = s->dq,
                              .dqd = s->dqd,
                              .dpx = sim->jacobians ? s->points.dx : NULL,
                              .dpv = s->points.dv,
                              .dpJ = s->points.dJ,
                              .dpose = (const double *)(const void *)s->dpose,
                              .du = s->du,
                              .dd = dd->dd,
                              .moved = dd->moved,
                              .nmoved = dd->n};
}

/* dQ along it */
static void forces_along(stein_derivative *s, const stein__constants *dd)
{
    stein__direction way = direction_of(s, dd);
    stein__tangent_forces(s->tangent, &way, s->dQ);
}

void stein__constants_along(stein_derivative *s, const double *dp, stein__constants *to)
{
    static const stein_functions functions = {stein__sin, stein__cos, stein__tan};
    s->model->setup_along(s->sim->p, dp, to->dd, &functions);
    to->n = 0;
    for (int i = 0; i < s->model->nd; i++) {
        if (to->dd[i] != 0.0) {
            to->moved[to->n++] = i;
        }
    }
}

void stein__along(stein_derivative *s, const double *dq, const double *dqd,
                  const stein__constants *dd, double *dqdd)
{
    const stein_model *model = s->model;
    const stein_sim *sim = s->sim;
    int n = model->nq;
    stein__vector_to(s->dq, dq, n);
    stein__vector_to(s->dqd, dqd, n);
    follow(s, dd->dd);
    forces_along(s, dd);
    model->inverse_along(sim->xq, sim->xqd, s->qdd, sim->sc, sim->d, s->dq, s->dqd, dd->dd, s->dR);
    for (int j = 0; j < n; j++) {
        dqdd[j] = s->dQ[j] - s->dR[j];
    }
    solve(s, dqdd);
}

/* is there a place whose derivatives can be told? Else there are no numbers */
static int has_place(const stein_derivative *s, double *to, int n)
{
    for (int i = 0; s->sim == NULL && i < n; i++) {
        to[i] = NAN;
    }
    return s->sim != NULL;
}

void stein_derivative_along(stein_derivative *s, const double *dq, const double *dqd,
                            const double *dp, double *dqdd)
{
    if (!has_place(s, dqdd, s->model->nq)) {
        return;
    }
    if (dp != NULL) {
        stein__constants_along(s, dp, &s->own);
    }
    stein__along(s, dq, dqd, dp != NULL ? &s->own : &s->none, dqdd);
}

void stein_derivative_by_parameter(stein_derivative *s, int param, double *by_p)
{
    memset(by_p, 0, sizeof *by_p * (size_t)s->model->nq);
    if (param >= 0 && param < s->model->np) {
        memset(s->dp, 0, sizeof *s->dp * (size_t)s->model->np);
        s->dp[param] = 1.0;
        stein_derivative_along(s, NULL, NULL, s->dp, by_p);
    }
}

void stein__guards_along(stein_derivative *s, const double *dq, const stein__constants *dd,
                         double *dguard)
{
    const stein_model *model = s->model;
    stein__vector_to(s->dq, dq, model->nq);
    stein__vector_to(s->dqd, NULL, model->nq);
    follow(s, dd->dd);
    stein__direction way = direction_of(s, dd);
    stein__tangent_guards(s->tangent, &way, dguard);
}

/* ---- by every q and qd ---- */

/* does the joint stay where its signal has it? */
static int follows(const stein_derivative *s, int j)
{
    return s->driven && s->driver[j] >= 0;
}

/* unit direction k of {q, qd} */
static void unit_direction(stein_derivative *s, int k)
{
    int n = s->model->nq;
    memset(s->dq, 0, sizeof *s->dq * (size_t)n);
    memset(s->dqd, 0, sizeof *s->dqd * (size_t)n);
    *(k < n ? &s->dq[k] : &s->dqd[k - n]) = follows(s, k % n) ? 0.0 : 1.0;
}

static void column_to(double *matrix, int n, int j, const double *column)
{
    for (int i = 0; i < n; i++) {
        matrix[i * n + j] = column[i];
    }
}

/* along every q and qd */
static void sweep_forces(stein_derivative *s, double *by_q, double *by_qd)
{
    int n = s->model->nq;
    follow(s, s->none.dd);
    for (int k = 0; k < 2 * n; k++) {
        unit_direction(s, k);
        forces_along(s, &s->none);
        column_to(k < n ? by_q : by_qd, n, k % n, s->dQ);
    }
}

/* the same of two matrices */
static int has_place_for(const stein_derivative *s, double *by_q, double *by_qd)
{
    int n = s->model->nq;
    return has_place(s, by_q, n * n) & has_place(s, by_qd, n * n);
}

void stein_derivative_forces(stein_derivative *s, double *by_q, double *by_qd)
{
    int n = s->model->nq;
    if (!has_place_for(s, by_q, by_qd)) {
        return;
    }
    if (!stein__touch_slopes(s, by_q, by_qd)) {
        sweep_forces(s, by_q, by_qd);
    }
    for (int j = 0; s->driven && j < n; j++) {
        for (int i = 0; follows(s, j) && i < n; i++) {
            by_q[i * n + j] = by_qd[i * n + j] = 0.0;
        }
    }
}

/* M qdd + c by q and qd, to Rq and Rqd */
static void equations_by_state(stein_derivative *s)
{
    const stein_model *model = s->model;
    const stein_sim *sim = s->sim;
    int n = model->nq;
    if (model->inverse_slopes != NULL) {
        model->inverse_slopes(sim->xq, sim->xqd, s->qdd, sim->sc, sim->d, s->Rq, s->Rqd);
        return;
    }
    for (int k = 0; k < 2 * n; k++) {
        unit_direction(s, k);
        model->inverse_along(sim->xq, sim->xqd, s->qdd, sim->sc, sim->d, s->dq, s->dqd, s->none.dd,
                             s->dR);
        column_to(k < n ? s->Rq : s->Rqd, n, k % n, s->dR);
    }
}

/* M X = Q - R. Joints that are not free do not accelerate, and those that follow do not move */
static void solve_columns(stein_derivative *s, const double *Q, const double *R, double *X)
{
    int n = s->model->nq;
    for (int i = 0; i < n * n; i++) {
        X[i] = Q[i] - R[i];
    }
    for (int j = 0; s->driven && j < n; j++) {
        for (int i = 0; i < n; i++) {
            X[i * n + j] = follows(s, j) ? 0.0 : X[i * n + j];
            X[j * n + i] = s->driver[j] != STEIN__FREE ? 0.0 : X[j * n + i];
        }
    }
    stein__substitute(n, s->parent, s->factor, s->inverse, X, n);
}

void stein_derivative_by_state(stein_derivative *s, double *by_q, double *by_qd)
{
    if (!has_place_for(s, by_q, by_qd)) {
        return;
    }
    equations_by_state(s);
    stein_derivative_forces(s, s->Qq, s->Qqd);
    solve_columns(s, s->Qq, s->Rq, by_q);
    solve_columns(s, s->Qqd, s->Rqd, by_qd);
}

void stein__derivative_residual(stein_derivative *s, double *by_q, double *by_qd)
{
    int n = s->model->nq;
    s->driven = 0; // all joints move
    equations_by_state(s);
    stein_derivative_forces(s, s->Qq, s->Qqd);
    for (int i = 0; i < n * n; i++) {
        by_q[i] = s->Rq[i] - s->Qq[i];
        by_qd[i] = s->Rqd[i] - s->Qqd[i];
    }
}
