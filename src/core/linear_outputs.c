/* SPDX-License-Identifier: MIT
 * linear_outputs.c - outputs of a linearised mechanism, and where it is at the edge of a force.
 *
 * By differences are those outputs alone of which nothing here knows the derivative: gaps and
 * forces of contacts and notches, energies, attitudes, reactions, and speeds of points of what
 * moves.
 */
#include <math.h>
#include <string.h>

#include "linear.h"

/* ---- C and D ---- */

/* a row of C, [2*n], and one of D, [ninput], before the instrument; 1: both are exact */
typedef struct rows {
    double *c, *d;
} rows;

static int coordinate_of(const stein_linear *l, int joint)
{
    int k = l->system.n - 1;
    while (k >= 0 && l->joint[k] != joint) {
        k--;
    }
    return k;
}

static int moves(const stein_linear *l)
{
    int any = 0;
    for (int j = 0; j < l->model->nq; j++) {
        any |= l->qd[j] != 0.0;
    }
    return any;
}

/* sum of by_joint [nq] (1 apart) times a matrix [nq*n] */
static void times(const stein_linear *l, const double *by_joint, const double *matrix, double *to)
{
    int n = l->system.n;
    for (int k = 0; k < n; k++) {
        to[k] = 0.0;
        for (int j = 0; j < l->model->nq; j++) {
            to[k] += by_joint[j] * matrix[j * n + k];
        }
    }
}

static int joint_rows(stein_linear *l, int joint, stein_read_kind read, rows to)
{
    int n = l->system.n, nu = l->system.ninput;
    const double *T = l->T + joint * n, *W = l->W + joint * n;
    switch (read) {
    case STEIN_READ_POSITION: memcpy(to.c, T, sizeof *T * (size_t)n); return 1;
    case STEIN_READ_SPEED:
        memcpy(to.c, W, sizeof *W * (size_t)n);
        memcpy(to.c + n, T, sizeof *T * (size_t)n);
        return 1;
    default: break;
    }
    for (int k = 0; k < n; k++) { // an acceleration
        for (int i = 0; i < nu; i++) {
            to.d[i] += T[k] * l->B[(n + k) * nu + i];
        }
        for (int i = 0; i < 2 * n; i++) {
            to.c[i] += T[k] * l->A[(n + k) * 2 * n + i];
        }
    }
    return l->model->nrow == 0;
}

static int point_rows(stein_linear *l, int point, stein_read_kind read, rows to)
{
    int nq = l->model->nq, speed = read >= STEIN_READ_VX;
    int axis = (int)read - (int)(speed ? STEIN_READ_VX : STEIN_READ_X);
    const double *J = l->points + 9 * l->model->npoint + (3 * point + axis) * nq;
    times(l, J, l->T, to.c + (speed ? l->system.n : 0));
    return !speed || !moves(l);
}

/* what the prescribed motion of input i needs, P^T (M qdd + c - Q) for its column P of T */
static int force_rows(stein_linear *l, int i, rows to)
{
    const stein_model *model = l->model;
    int n = l->system.n, nu = l->system.ninput, p = coordinate_of(l, model->inputs[i].index);
    for (int u = 0; u < nu; u++) {
        for (int k = 0; p >= 0 && k < n; k++) {
            to.d[u] += l->mass[p * n + k] * l->B[(n + k) * nu + u];
        }
        stein__linear_force(l, l->input[u], l->force);
        for (int j = 0; p >= 0 && j < model->nq; j++) {
            to.d[u] -= l->T[j * n + p] * l->force[j];
        }
    }
    return 0;
}

/* what input i of the model is */
static int value_rows(stein_linear *l, int i, rows to)
{
    const stein_input *input = &l->model->inputs[i];
    int p = input->kind == STEIN_INPUT_MOTION ? coordinate_of(l, input->index) : -1;
    if (p >= l->system.nfree && l->sim->signal[i] != NULL) {
        to.c[p] = 1.0;
    }
    for (int u = 0; u < l->system.ninput && input->kind != STEIN_INPUT_MOTION; u++) {
        to.d[u] = l->input[u] == i ? l->sim->d[input->signal + STEIN_SIGNAL_GAIN] : 0.0;
    }
    return 1;
}

/* of channel i; 1: c is exact, 0: it is that by differences, d is exact */
static int channel_rows(stein_linear *l, int i, rows to)
{
    const stein_channel *channel = &l->model->channels[i];
    switch (channel->read) {
    case STEIN_READ_TIME:
    case STEIN_READ_NOTCH_PHASE: return 1;
    case STEIN_READ_POSITION:
    case STEIN_READ_SPEED:
    case STEIN_READ_ACCELERATION: return joint_rows(l, channel->index, channel->read, to);
    case STEIN_READ_X:
    case STEIN_READ_Y:
    case STEIN_READ_Z:
    case STEIN_READ_VX:
    case STEIN_READ_VY:
    case STEIN_READ_VZ: return point_rows(l, channel->index, channel->read, to);
    case STEIN_READ_INPUT: return value_rows(l, channel->index, to);
    case STEIN_READ_INPUT_FORCE:
        return l->model->inputs[channel->index].kind == STEIN_INPUT_MOTION
                   ? force_rows(l, channel->index, to)
                   : value_rows(l, channel->index, to);
    default: return 0;
    }
}

/* ---- forces by inputs ---- */

static void nudged(void *ctx, double t, double u[3])
{
    const stein__nudge *n = ctx;
    if (n->signal != NULL) {
        n->signal(n->ctx, t, u);
    } else {
        u[0] = n->rest[0];
        u[1] = n->rest[1];
    }
    u[n->which] += n->more;
}

/* a signal in place of another one, without a new look at the loops */
static void bind(stein_sim *sim, int i, stein_signal_fn *fn, void *ctx)
{
    int rank = sim->loop.rank;
    sim->signal[i] = fn;
    sim->signal_ctx[i] = ctx;
    sim->ustate[3 * i] = sim->ustate[3 * i + 1] = sim->ustate[3 * i + 2] = 0.0;
    stein__wire(sim);
    sim->loop.rank = rank;
    sim->fresh = STALE;
}

/* D of reactions by input u: they depend on forces themselves */
static stein_status reactions_by(stein_linear *l, int u, stein_err *err)
{
    const stein_model *model = l->model;
    stein_sim *sim = l->sim;
    int i = l->input[u], moves = model->inputs[i].kind == STEIN_INPUT_MOTION;
    double gain = sim->d[model->inputs[i].signal + STEIN_SIGNAL_GAIN];
    stein__nudge nudge = {.signal = sim->signal[i], .ctx = sim->signal_ctx[i], .which = 2 * moves};
    if (gain == 0.0) {
        return STEIN_OK;
    }
    if (moves) {
        nudge.rest[0] = l->q[model->inputs[i].index] / gain;
        nudge.rest[1] = l->qd[model->inputs[i].index] / gain;
    }
    bind(sim, i, nudged, &nudge);
    stein_status status = stein__linear_differences(l, NULL, NULL, &nudge, err);
    bind(sim, i, nudge.signal, nudge.ctx);
    stein__linear_restore(l);
    for (int k = 0; k < model->nchannel && status == STEIN_OK; k++) {
        if (model->channels[k].read == STEIN_READ_REACTION) {
            l->D[k * l->system.ninput + u] = l->slope[model->nq + k];
        }
    }
    return status;
}

static stein_status find_reactions(stein_linear *l, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int u = 0; l->model->nreaction > 0 && u < l->system.ninput && status == STEIN_OK; u++) {
        status = reactions_by(l, u, err);
    }
    return status;
}

stein_status stein__linear_outputs(stein_linear *l, stein_err *err)
{
    int n = l->system.n, nu = l->system.ninput;
    for (int i = 0; i < l->model->nchannel; i++) {
        const stein_channel *channel = &l->model->channels[i];
        rows to = {.c = l->row, .d = l->D + i * nu};
        memset(to.c, 0, sizeof *to.c * (size_t)(2 * n));
        memset(to.d, 0, sizeof *to.d * (size_t)nu);
        int tilts = l->sim->d[channel->sensor + STEIN_SENSOR_TILT] != 0.0;
        int exact = channel_rows(l, i, to) && !tilts;
        double slope = stein__channel_slope(l->sim, i);
        for (int u = 0; u < nu; u++) {
            to.d[u] *= slope;
        }
        for (int k = 0; exact && k < 2 * n; k++) {
            l->C[i * 2 * n + k] = slope * to.c[k];
        }
        l->differences[i] =
            !exact || (channel->read == STEIN_READ_ACCELERATION && !l->system.exact);
    }
    return find_reactions(l, err);
}

/* ---- edges ---- */

static void add_edge(stein_linear *l, stein_edge_kind kind, int index, double apart)
{
    if (apart <= STEIN_EDGE_OPEN && apart >= -STEIN_EDGE_PRESSED) {
        l->edge[l->system.nedge++] = (stein_edge){kind, index, apart};
    }
}

/* the guard nearest to 0 of n, which is > 0 where it is pressed in */
static double nearest(const double *guard, int n)
{
    double g = guard[0];
    for (int i = 1; i < n; i++) {
        g = fabs(guard[i]) < fabs(g) ? guard[i] : g;
    }
    return -g;
}

void stein__linear_edges(stein_linear *l)
{
    const stein_model *model = l->model;
    const stein_sim *sim = l->sim;
    l->system.nedge = 0;
    for (int i = 0; i < model->ncontact; i++) {
        const stein_contact *c = &model->contacts[i];
        add_edge(l, STEIN_EDGE_CONTACT, i, nearest(sim->guard + c->first_spot, c->nspot));
    }
    for (int i = 0; i < model->nnotch; i++) {
        const double *guard = sim->guard + model->nspot + NOTCH_GUARDS * i;
        add_edge(l, STEIN_EDGE_NOTCH, i, nearest(guard, NOTCH_REGION));
    }
    for (int i = 0; i < model->nlimit; i++) {
        const double *law = sim->d + model->limits[i].d;
        double q = l->q[model->limits[i].joint];
        double room = fmin(law[STEIN_LIMIT_TO] - q, q - law[STEIN_LIMIT_FROM]);
        if (law[STEIN_LIMIT_K] > 0.0) {
            add_edge(l, STEIN_EDGE_LIMIT, model->limits[i].joint, room);
        }
    }
    for (int j = 0; j < model->nq; j++) {
        const double *law = sim->d + model->bodies[j].joint;
        if (law[STEIN_JOINT_STOP_K] > 0.0) {
            add_edge(l, STEIN_EDGE_BACKLASH, j, law[STEIN_JOINT_STOP_GAP] - fabs(l->q[j]));
        }
    }
}
