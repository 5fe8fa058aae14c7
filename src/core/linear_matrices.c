/* SPDX-License-Identifier: MIT
 * linear_matrices.c - the coordinates of a linearised mechanism, its masses, A and B.
 *
 * The independent coordinates are those that the partition of J leaves at the state, then joints
 * with a prescribed motion. A direction of z moves the joints by T dz, and as J qd = 0 stays true
 * their speeds change with it by W dz,
 *
 *      J W_k = - b(T_k, qd),    b_i(u, v) = sum of u_j v_k d2h_i/dq_j dq_k
 *
 * b is in the generated Jdot qd, which is the quadratic form of it in qd:
 *
 *      2 b(u, v) = (Jdot qd)(u + v) - (Jdot qd)(u) - (Jdot qd)(v)
 */
#include <math.h>
#include <string.h>

#include "linear.h"
#include "loops.h"

/* ---- coordinates ---- */

/* the motion in force that moves joint j, -1: it is free or held */
static int motion_of(const stein_sim *sim, int j)
{
    for (int i = 0; i < sim->model->ninput && !sim->held[j]; i++) {
        const stein_input *input = &sim->model->inputs[i];
        if (input->kind == STEIN_INPUT_MOTION && input->index == j &&
            (sim->signal[i] != NULL || input->hold)) {
            return i;
        }
    }
    return -1;
}

stein_status stein__linear_joints(stein_linear *l, stein_err *err)
{
    const stein_model *model = l->model;
    const stein_sim *sim = l->sim;
    for (int j = 0; j < model->nq; j++) {
        l->motion[j] = motion_of(sim, j);
        l->still[j] = sim->held[j];
    }
    for (int i = 0; i < model->nball; i++) {
        l->still[model->balls[i].joint] = 1;
    }
    for (int k = 0; k < model->nstick; k++) {
        const stein_stick *stick = &model->sticks[k];
        if (sim->hold.touch[k] < 0 || !is_at_rest(sim->stick[k])) {
            continue;
        }
        if (stick->kind == STEIN_STICK_SPOT) {
            return stein__fail(err, STEIN_EINVAL,
                               "contact \"%s\" sticks: what holds it is no function of the state; "
                               "linearise without \"stick: yes\"",
                               model->contacts[model->spots[stick->index].contact].name);
        }
        l->still[stick->index] = 1;
    }
    return STEIN_OK;
}

/* dependent joints by the last partition, of a direction in which `joint` moves by 1 (-1: none) */
static void take_column(const stein_linear *l, double *to, int k, int joint)
{
    const stein__loops *loop = &l->sim->loop;
    int n = l->system.n, nq = l->model->nq;
    for (int i = 0; l->model->nrow > 0 && i < loop->rank_found; i++) {
        double moved = joint >= 0 ? loop->A[loop->row[i] * nq + joint] : 0.0;
        to[loop->column[i] * n + k] = loop->rhs[loop->row[i]] - moved;
    }
}

/* joints x that are given, the right-hand side is there */
static void part(stein_linear *l, const double *x)
{
    stein__loops *loop = &l->sim->loop;
    memset(loop->x, 0, sizeof *loop->x * (size_t)l->model->nq);
    stein__give(l->sim, l->still, loop->x);
    for (int j = 0; x != NULL && j < l->model->nq; j++) {
        loop->x[j] = x[j];
    }
    (void)stein__partition(l->sim, loop->x, stein__most_pivots(l->sim), STEIN__PASSING_PIVOT);
}

/* joint and its column of T: the first ones are free, then those with a motion */
void stein__linear_coordinates(stein_linear *l)
{
    const stein__loops *loop = &l->sim->loop;
    int nq = l->model->nq;
    l->system.n = 0;
    if (l->model->nrow > 0) {
        stein__loops_at(l->sim, l->q, l->qd);
        memset(loop->rhs, 0, sizeof *loop->rhs * (size_t)l->model->nrow);
        part(l, NULL);
    }
    for (int moved = 0; moved <= 1; moved++) {
        for (int j = 0; j < nq; j++) {
            int depends = l->model->nrow > 0 && loop->role[j] == DEPENDENT;
            if (!l->still[j] && !depends && (l->motion[j] >= 0) == moved) {
                l->joint[l->system.n++] = j;
            }
        }
        l->system.nfree = moved ? l->system.nfree : l->system.n;
    }
}

static void find_directions(stein_linear *l)
{
    const stein__loops *loop = &l->sim->loop;
    int n = l->system.n, nq = l->model->nq;
    memset(l->T, 0, sizeof *l->T * (size_t)(nq * n));
    for (int k = 0; k < n; k++) {
        int j = l->joint[k];
        l->T[j * n + k] = 1.0;
        if (l->model->nrow > 0 && k >= l->system.nfree) {
            memset(l->force, 0, sizeof *l->force * (size_t)nq);
            l->force[j] = 1.0;
            memset(loop->rhs, 0, sizeof *loop->rhs * (size_t)l->model->nrow);
            part(l, l->force);
            take_column(l, l->T, k, -1);
        } else {
            take_column(l, l->T, k, j);
        }
    }
}

/* Jdot qd for speeds u + v, into jdqd; v may be NULL. J and h are those of the state. */
static void bend(stein_linear *l, const double *u, int stride, const double *v)
{
    for (int j = 0; j < l->model->nq; j++) {
        l->force[j] = u[j * stride] + (v != NULL ? v[j] : 0.0);
    }
    stein__loops_at(l->sim, l->q, l->force);
}

/* W, of a motion with loops */
static void find_turning(stein_linear *l)
{
    const stein__loops *loop = &l->sim->loop;
    int n = l->system.n, nq = l->model->nq, rows = l->model->nrow;
    memset(l->W, 0, sizeof *l->W * (size_t)(nq * n));
    for (int k = 0; rows > 0 && stein__largest(l->qd, nq) > 0.0 && k < n; k++) {
        bend(l, l->T + k, n, NULL);
        memcpy(l->row, loop->jdqd, sizeof *l->row * (size_t)rows);
        bend(l, l->qd, 1, NULL);
        for (int i = 0; i < rows; i++) {
            l->row[i] += loop->jdqd[i];
        }
        bend(l, l->T + k, n, l->qd);
        for (int i = 0; i < rows; i++) {
            loop->rhs[i] = 0.5 * (l->row[i] - loop->jdqd[i]);
        }
        part(l, NULL);
        take_column(l, l->W, k, -1);
    }
}

/* ---- masses ---- */

/* X [nq*nq] times T, then T^T times that */
static void reduce(stein_linear *l, const double *X, double *to)
{
    int n = l->system.n, nq = l->model->nq;
    for (int i = 0; i < nq; i++) {
        for (int k = 0; k < n; k++) {
            double sum = 0.0;
            for (int j = 0; j < nq; j++) {
                sum += X[i * nq + j] * l->T[j * n + k];
            }
            l->product[i * n + k] = sum;
        }
    }
    for (int k = 0; k < n; k++) {
        for (int m = 0; m < n; m++) {
            double sum = 0.0;
            for (int i = 0; i < nq; i++) {
                sum += l->T[i * n + k] * l->product[i * n + m];
            }
            to[k * n + m] = sum;
        }
    }
}

static stein_status find_masses(stein_linear *l, stein_err *err)
{
    const stein_sim *sim = l->sim;
    int n = l->system.n, nfree = l->system.nfree;
    l->model->unloaded(l->q, l->qd, sim->sc, sim->d, l->M, l->c);
    reduce(l, l->M, l->mass);
    for (int i = 0; i < nfree; i++) {
        for (int j = 0; j < nfree; j++) {
            l->factor[i * nfree + j] = l->mass[i * n + j];
        }
    }
    if (stein__factor_general(nfree, l->factor, l->pivot) != 0) {
        return stein__fail(err, STEIN_ESINGULAR,
                           "the mass matrix of \"%s\" is singular in this state", l->model->name);
    }
    return STEIN_OK;
}

/* ---- A ---- */

/* row block of the speeds: -M_zz^-1 of the first nfree rows of X [n*n], into columns from `first`
 */
static void put_block(stein_linear *l, const double *X, int first)
{
    int n = l->system.n, nfree = l->system.nfree;
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < nfree; i++) {
            l->force[i] = -X[i * n + k];
        }
        stein__substitute_general(nfree, l->factor, l->pivot, l->force);
        for (int i = 0; i < nfree; i++) {
            l->A[(n + i) * 2 * n + first + k] = l->force[i] + 0.0; // no -0
        }
    }
}

/* by the derivatives of M qdd + c - Q */
static stein_status derive(stein_linear *l, stein_err *err)
{
    int n = l->system.n;
    stein_derivative *s = l->slopes;
    stein_status status = stein__derivative_at(s, l->sim, l->sim->head->t, l->q, l->qd, NULL, err);
    if (status == STEIN_OK) {
        stein__derivative_residual(s, l->by_q, l->by_qd);
        reduce(l, l->by_q, l->K);
        put_block(l, l->K, 0);
        reduce(l, l->by_qd, l->K);
        put_block(l, l->K, n);
    }
    return status;
}

/* column k of T or W, or 0, to a vector [nq] */
static void direction(const stein_linear *l, const double *from, int k, double *to)
{
    for (int j = 0; j < l->model->nq; j++) {
        to[j] = from != NULL ? from[j * l->system.n + k] : 0.0;
    }
}

/* along state k: accelerations to A where it is not exact, outputs to C */
static stein_status difference(stein_linear *l, int k, stein_err *err)
{
    int n = l->system.n, ny = l->model->nchannel;
    double *dq = l->by_q, *dqd = l->by_qd; // not needed any more
    direction(l, k < n ? l->T : NULL, k % n, dq);
    direction(l, k < n ? l->W : l->T, k % n, dqd);
    stein_status status = stein__linear_differences(l, dq, dqd, NULL, err);
    for (int i = 0; status == STEIN_OK && !l->system.exact && i < l->system.nfree; i++) {
        int j = l->joint[i];
        l->A[(n + i) * 2 * n + k] = l->slope[j];
        l->row[i] = fmax(l->row[i], l->off[j]);
    }
    for (int i = 0; status == STEIN_OK && i < ny; i++) {
        l->C[i * 2 * n + k] = l->slope[l->model->nq + i];
    }
    return status;
}

/* largest of the estimates, each in units of the largest element of its row */
static double error_of(const stein_linear *l)
{
    int n = l->system.n;
    double worst = 0.0;
    for (int i = 0; !l->system.exact && i < l->system.nfree; i++) {
        double largest = stein__largest(l->A + (n + i) * 2 * n, 2 * n);
        worst = fmax(worst, largest > 0.0 ? l->row[i] / largest : l->row[i]);
    }
    return worst;
}

/* While directions move them, joints with a signal are held instead. */
static void let_go(stein_linear *l)
{
    stein_sim *sim = l->sim;
    memcpy(l->signal, sim->signal, sizeof *l->signal * (size_t)l->model->ninput);
    for (int k = l->system.nfree; k < l->system.n; k++) {
        sim->signal[l->motion[l->joint[k]]] = NULL;
        sim->held[l->joint[k]] = 1;
    }
}

static void take_back(stein_linear *l)
{
    stein_sim *sim = l->sim;
    memcpy(sim->signal, l->signal, sizeof *l->signal * (size_t)l->model->ninput);
    for (int k = l->system.nfree; k < l->system.n; k++) {
        sim->held[l->joint[k]] = 0;
    }
    stein__linear_restore(l);
}

void stein__linear_restore(stein_linear *l)
{
    stein_sim *sim = l->sim;
    int nq = l->model->nq;
    memcpy(sim->q, l->kept, sizeof *l->kept * (size_t)nq);
    memcpy(sim->qd, l->kept + nq, sizeof *l->kept * (size_t)nq);
    sim->fresh = STALE;
}

static stein_status find_A(stein_linear *l, stein_err *err)
{
    int n = l->system.n;
    stein_status status = STEIN_OK;
    memset(l->A, 0, sizeof *l->A * (size_t)(4 * n * n));
    memset(l->row, 0, sizeof *l->row * (size_t)n);
    for (int i = 0; i < n; i++) {
        l->A[i * 2 * n + n + i] = 1.0;
    }
    if (l->system.exact) {
        status = derive(l, err);
    }
    let_go(l);
    for (int k = 0; k < 2 * n && status == STEIN_OK; k++) {
        status = difference(l, k, err);
    }
    take_back(l);
    l->system.error = error_of(l);
    return status;
}

/* ---- B ---- */

static void find_points(stein_linear *l)
{
    const stein_model *model = l->model;
    double *x = l->points, *J = x + 9 * model->npoint;
    if (model->npoint > 0) {
        model->point(l->q, l->qd, l->sim->sc, l->sim->d, x, x + 3 * model->npoint, J,
                     x + 6 * model->npoint);
    }
}

void stein__linear_force(const stein_linear *l, int i, double *force)
{
    const stein_model *model = l->model;
    const stein_input *input = &model->inputs[i];
    const double *d = l->sim->d;
    double gain = d[input->signal + STEIN_SIGNAL_GAIN];
    int nq = model->nq;
    memset(force, 0, sizeof *force * (size_t)nq);
    if (input->kind == STEIN_INPUT_JOINT) {
        force[input->index] = gain;
    } else if (input->kind == STEIN_INPUT_VOLTAGE) {
        force[input->index] = gain * d[input->direction];
    } else if (input->kind == STEIN_INPUT_POINT) {
        const double *J = l->points + 9 * model->npoint + 3 * input->index * nq;
        for (int j = 0; j < 3 * nq; j++) {
            force[j % nq] += gain * d[input->direction + j / nq] * J[j];
        }
    }
    for (int k = 0; k < model->nball; k++) {
        force[model->balls[k].joint] = 0.0;
    }
}

/* accelerations by input i of the model, to column `at` of B */
static void put_column(stein_linear *l, int i, int at)
{
    int n = l->system.n, nfree = l->system.nfree, nu = l->system.ninput, nq = l->model->nq;
    double *force = l->force, *b = l->row;
    int moved = -1;
    for (int k = nfree; k < n; k++) {
        moved = l->motion[l->joint[k]] == i ? k : moved;
    }
    stein__linear_force(l, i, force);
    double gain = l->sim->d[l->model->inputs[i].signal + STEIN_SIGNAL_GAIN];
    for (int k = 0; k < nfree; k++) {
        b[k] = moved >= 0 ? -gain * l->mass[k * n + moved] : 0.0;
        for (int j = 0; j < nq; j++) {
            b[k] += l->T[j * n + k] * force[j];
        }
    }
    stein__substitute_general(nfree, l->factor, l->pivot, b);
    for (int k = 0; k < nfree; k++) {
        l->B[(n + k) * nu + at] = b[k];
    }
    if (moved >= 0) {
        l->B[(n + moved) * nu + at] = gain;
    }
}

static void find_B(stein_linear *l)
{
    const stein_model *model = l->model;
    int n = l->system.n, nu = 0;
    for (int i = 0; i < model->ninput; i++) {
        const stein_input *input = &model->inputs[i];
        if (input->kind != STEIN_INPUT_MOTION || l->motion[input->index] == i) {
            l->input[nu++] = i;
        }
    }
    l->system.ninput = nu;
    memset(l->B, 0, sizeof *l->B * (size_t)(2 * n * nu));
    for (int at = 0; at < nu; at++) {
        put_column(l, l->input[at], at);
    }
}

stein_status stein__linear_matrices(stein_linear *l, stein_err *err)
{
    find_directions(l);
    find_turning(l);
    stein_status status = find_masses(l, err);
    status = status == STEIN_OK ? find_A(l, err) : status;
    status = status == STEIN_OK ? stein__refresh(l->sim, err) : status;
    if (status == STEIN_OK) {
        find_points(l);
        find_B(l);
    }
    return status;
}
