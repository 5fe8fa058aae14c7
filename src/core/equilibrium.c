/* SPDX-License-Identifier: MIT
 * equilibrium.c - the initial state: static equilibrium, the load flush, contacts as geometry has
 * them.
 *
 * Equilibrium is a zero of F(q) = qdd(q, qd = 0), where friction vanishes. Newton alone fails from
 * afar because contacts that do not touch have no stiffness; so pseudo-transient continuation
 * (Kelley & Keyes 1998): implicit Euler steps of growing length tau on dq/ds = F(q),
 *
 *      (1/tau - dF/dq) delta = F
 *
 * which follow the motion downhill while tau is small and become Newton's as it grows. Integrating
 * the motion until it rests would creep for ever on the smooth friction law.
 *
 * With loops and couplings the unknowns are the independent joints of the partition of J there; the
 * others follow, dq = T dz, and Newton steps close what a step has opened.
 */
#include <math.h>
#include <string.h>

#include "loops.h"

enum { MAX_SETTLE_STEPS = 600 };
static const double longest_step = 0.02; /* rad or m in one iteration */
static const double settled = 1e-13;     /* last Newton correction [rad or m] */

/* The regions that the notches are in before the search, or none: a beak on the vertical face is
 * still beside it while the search tries positions around. Kept in sim->crossed, which only steps
 * use. */
static void remember_regions(stein_sim *sim, int keep)
{
    memcpy(sim->crossed, sim->mode, (size_t)sim->nguard);
    if (!keep) {
        memset(sim->crossed, 0, (size_t)sim->nguard);
    }
}

/* contact modes and notch regions as the positions in sim->q and the remembered regions have them
 */
static void modes_from_geometry(stein_sim *sim)
{
    const stein_model *model = sim->model;
    memset(sim->mode, 0, (size_t)sim->nguard);
    for (int i = 0; i < model->nnotch; i++) {
        int region = model->nspot + NOTCH_GUARDS * i + NOTCH_REGION;
        sim->mode[region] = sim->crossed[region];
    }
    stein__guards(sim, sim->q, sim->guard);
    int elsewhere = 0; // a beak is in another region than it was thought to be
    for (int i = 0; i < model->nnotch; i++) {
        int region = model->nspot + NOTCH_GUARDS * i + NOTCH_REGION;
        int thought = sim->mode[region];
        sim->mode[region] = sim->guard[region] > 0.0;
        elsewhere |= sim->mode[region] != thought;
    }
    if (elsewhere) {
        stein__guards(sim, sim->q, sim->guard);
    }
    for (int i = 0; i < sim->nguard; i++) {
        sim->mode[i] = sim->guard[i] > 0.0;
    }
    for (int i = 0; i < model->nnotch; i++) {
        sim->phase[i] = stein__notch_phase_after(sim->mode + model->nspot + NOTCH_GUARDS * i, 0);
        sim->engaged[i] = sim->phase[i] >= 1 && sim->phase[i] <= 3;
    }
    sim->fresh = STALE;
}

/* F(q) at rest; the residual in the metric of M, F.(Q - c), in *norm2 */
static stein_status residual(stein_sim *sim, double *F, double *norm2, stein_err *err)
{
    int nq = sim->model->nq;
    modes_from_geometry(sim);
    stein_status status = stein__evaluate(sim, 0.0, sim->q, sim->zero, F, err);
    *norm2 = 0.0;
    for (int j = 0; j < nq; j++) {
        if (!stein__is_driven(sim, j)) {
            *norm2 += fabs(F[j] * (sim->Q[j] - sim->c[j]));
        }
    }
    return status;
}

/* is joint j an unknown? With loops: by the last partition */
static int is_unknown(const stein_sim *sim, int j)
{
    return sim->model->nrow > 0 ? sim->loop.kept[j] : !stein__is_driven(sim, j);
}

/* with loops: parts the joints at sim->q into unknowns and what depends on them */
static void part(stein_sim *sim)
{
    stein__loops *l = &sim->loop;
    stein__loops_at(sim, sim->q, sim->zero);
    stein__give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)sim->model->nrow);
    (void)stein__partition(sim, l->x, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
    for (int j = 0; j < sim->model->nq; j++) {
        l->kept[j] = l->role[j] == FREE;
    }
}

/* with loops: what depends on the unknowns in dq follows them */
static void follow(const stein_sim *sim, double *dq)
{
    const stein__loops *l = &sim->loop;
    int nq = sim->model->nq;
    for (int i = 0; sim->model->nrow > 0 && i < l->rank_found; i++) {
        const double *row = l->A + l->row[i] * nq;
        double sum = 0.0;
        for (int j = 0; j < nq; j++) {
            sum -= l->kept[j] ? row[j] * dq[j] : 0.0;
        }
        dq[l->column[i]] = sum;
    }
}

/* F at `share` of a direction from where the joints are */
static stein_status look(stein_sim *sim, const double *dq, double share, double *F, stein_err *err)
{
    int nq = sim->model->nq;
    double norm2;
    for (int j = 0; j < nq; j++) {
        sim->q[j] += share * dq[j];
    }
    return residual(sim, F, &norm2, err);
}

/* column k of 1/tau - dF/dq, by central differences; a joint that is no unknown changes nothing */
static stein_status column(stein_sim *sim, int k, double tau, double *A, stein_err *err)
{
    int nq = sim->model->nq, moves = is_unknown(sim, k);
    double *Fp = sim->work + nq * nq, *Fm = Fp + nq, *q = sim->q0, *dq = sim->qd0, step = 1e-7;
    stein_status status = STEIN_OK;
    if (moves) {
        memcpy(q, sim->q, sizeof *q * (size_t)nq);
        memset(dq, 0, sizeof *dq * (size_t)nq);
        dq[k] = 1.0;
        if (sim->model->nrow > 0) {
            part(sim);
            follow(sim, dq);
        }
        status = look(sim, dq, step, Fp, err);
        memcpy(sim->q, q, sizeof *q * (size_t)nq);
        status = status == STEIN_OK ? look(sim, dq, -step, Fm, err) : status;
        memcpy(sim->q, q, sizeof *q * (size_t)nq);
    }
    for (int i = 0; status == STEIN_OK && i < nq; i++) {
        int given = !moves || !is_unknown(sim, i);
        double slope = given ? 0.0 : (Fp[i] - Fm[i]) / (2.0 * step);
        A[i * nq + k] = (i == k ? 1.0 / tau : 0.0) - slope;
    }
    return status;
}

/* delta of one continuation step from F at sim->q */
static stein_status correction(stein_sim *sim, const double *F, double tau, double *delta,
                               stein_err *err)
{
    int nq = sim->model->nq;
    double *A = sim->work;
    if (sim->model->nrow > 0) {
        part(sim);
    }
    for (int k = 0; k < nq; k++) {
        stein_status status = column(sim, k, tau, A, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    for (int i = 0; i < nq; i++) {
        delta[i] = is_unknown(sim, i) ? F[i] : 0.0;
    }
    if (stein__solve_general(nq, A, sim->pivot, delta) != 0) {
        memset(delta, 0, sizeof *delta * (size_t)nq);
    }
    if (sim->model->nrow > 0) {
        part(sim);
        follow(sim, delta);
    }
    return STEIN_OK;
}

/* the joints by a share of delta, loops closed behind it. @return are they? */
static int move(stein_sim *sim, const double *delta, double share)
{
    for (int j = 0; j < sim->model->nq; j++) {
        sim->q[j] += share * delta[j];
    }
    return sim->model->nrow == 0 || stein__loops_close(sim, NULL, sim->q);
}

static double largest(const double *x, int n)
{
    double m = 0.0;
    for (int i = 0; i < n; i++) {
        m = fmax(m, isfinite(x[i]) ? fabs(x[i]) : INFINITY);
    }
    return m;
}

static stein_status find_equilibrium(stein_sim *sim, stein_err *err)
{
    int nq = sim->model->nq;
    if (sim->model->nball > 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "no equilibrium is looked for in \"%s\": it has a body that turns in "
                           "all directions",
                           sim->model->name);
    }
    size_t bytes = sizeof *sim->q * (size_t)nq;
    double *F = sim->qdd0, *trial = sim->qdd1, *delta = sim->q1, *start = sim->qd1;
    double tau = 1e-6, norm2, new_norm2;
    stein_status status = residual(sim, F, &norm2, err);
    for (int n = 0; status == STEIN_OK && n < MAX_SETTLE_STEPS; n++) {
        status = correction(sim, F, tau, delta, err);
        double size = largest(delta, nq);
        if (status != STEIN_OK || (size < settled && tau > 1.0) || norm2 == 0.0) {
            return status;
        }
        memcpy(start, sim->q, bytes);
        double shorten = fmin(1.0, longest_step / size);
        int closed = move(sim, delta, shorten);
        status = residual(sim, trial, &new_norm2, err);
        if (closed && (new_norm2 <= 2.0 * norm2 || size < 1e-11)) {
            memcpy(F, trial, bytes);
            norm2 = new_norm2;
            tau = fmin(tau * (shorten < 1.0 ? 1.0 : 4.0), 1e12);
        } else {
            memcpy(sim->q, start, bytes);
            tau *= 0.125;
        }
    }
    if (status == STEIN_OK) {
        status = stein__fail(err, STEIN_ESETTLE,
                             "no static equilibrium found near the initial "
                             "positions (residual %g after %d iterations): begin nearer to one",
                             sqrt(norm2), (int)MAX_SETTLE_STEPS);
    }
    return status;
}

/* the load's coordinate at which its contact has gap 0: the guard is linear in it */
static void place_load_flush(stein_sim *sim)
{
    int joint = sim->model->load.body;
    int spot = sim->model->contacts[sim->model->load.contact].first_spot;
    sim->q[joint] = 0.0;
    int law = sim->model->contacts[sim->model->load.contact].normal;
    stein__guards(sim, sim->q, sim->guard);
    double g0 = sim->guard[spot];
    sim->q[joint] = 1.0;
    stein__guards(sim, sim->q, sim->guard);
    sim->q[joint] = (sim->d[law + STEIN_NORMAL_RANGE] - g0) / (sim->guard[spot] - g0);
}

stein_status stein__settle(stein_sim *sim, stein_err *err)
{
    const stein_model *model = sim->model;
    int load = model->load.body;
    remember_regions(sim, 0);
    if (model->settle) {
        sim->hold.off = 1; // friction vanishes at rest
        sim->head->load_present = load < 0;
        if (load >= 0) {
            sim->held[load] = 1;
        }
        stein_status status = find_equilibrium(sim, err);
        if (load >= 0) {
            sim->held[load] = 0;
        }
        sim->head->load_present = 1;
        sim->hold.off = 0;
        if (status == STEIN_OK && model->nrow > 0) { // initial speeds as the loops allow them there
            status = stein__loops_assemble(sim, 0, err);
        }
        if (status != STEIN_OK) {
            return status;
        }
    }
    if (load >= 0) {
        place_load_flush(sim);
    }
    modes_from_geometry(sim);
    return STEIN_OK;
}

stein_status stein_load_place(stein_sim *sim, stein_err *err)
{
    const stein_load *load = &sim->model->load;
    if (load->body < 0) {
        return STEIN_OK;
    }
    const stein_contact *contact = &sim->model->contacts[load->contact];
    sim->head->load_present = 1;
    sim->held[load->body] = 0;
    sim->qd[load->body] = 0.0;
    place_load_flush(sim);
    stein__guards(sim, sim->q, sim->guard);
    for (int i = contact->first_spot; i < contact->first_spot + contact->nspot; i++) {
        sim->mode[i] = sim->guard[i] > 0.0;
    }
    sim->fresh = STALE;
    return stein__refresh(sim, err);
}

stein_status stein_settle(stein_sim *sim, stein_err *err)
{
    remember_regions(sim, 1);
    stein__place_driven(sim);
    memset(sim->qd, 0, sizeof *sim->qd * (size_t)sim->model->nq);
    sim->fresh = STALE;
    sim->hold.off = 1;
    stein_status status = sim->model->nrow > 0 ? stein__loops_assemble(sim, 0, err) : STEIN_OK;
    status = status == STEIN_OK ? find_equilibrium(sim, err) : status;
    sim->hold.off = 0;
    modes_from_geometry(sim);
    stein__stick_begin(sim);
    return status == STEIN_OK ? stein__refresh(sim, err) : status;
}

stein_status stein_set_state(stein_sim *sim, double t, const double *q, const double *qd,
                             stein_err *err)
{
    int nq = sim->model->nq;
    for (int j = 0; j < nq; j++) {
        if (!isfinite(t) || !isfinite(q[j]) || !isfinite(qd[j])) {
            return stein__fail(err, STEIN_EINVAL, "the state given for joint \"%s\" is not finite",
                               sim->model->bodies[j].name);
        }
    }
    memmove(sim->q, q, sizeof *q * (size_t)nq);
    memmove(sim->qd, qd, sizeof *qd * (size_t)nq);
    for (int i = 0; i < sim->model->nball; i++) {
        sim->qd[sim->model->balls[i].joint] = 0.0;
    }
    (void)stein__rechart(sim);
    sim->head->t = sim->head->t0 = t;
    sim->head->step = 0;
    if (sim->model->nrow > 0) {
        stein__place_driven(sim);
        stein_status status = stein__loops_assemble(sim, 0, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    remember_regions(sim, 0);
    modes_from_geometry(sim);
    stein__stick_begin(sim);
    return stein__refresh(sim, err);
}
