/* SPDX-License-Identifier: MIT
 * stick.c - dry friction that sticks: what holds the places that stick now (stick_events.c says
 * which).
 *
 * A place is a joint or a spot of a contact. While it slips, its friction is the level of its law
 * against the sliding, of which the direction is kept: no jump within a step. While it sticks, its
 * speed of sliding v = G qd is a constraint,
 *
 *      M qdd + c = Q + G^T f,    G qdd = -Gdot qd
 *
 * and with qdd_0 of the same motion without f, and S = G M^-1 G^T,
 *
 *      S f = -Gdot qd - G qdd_0,    qdd = qdd_0 + M^-1 G^T f.
 *
 * M^-1 is that of what is free: with prescribed joints and loops in place. Normal forces come from
 * the elastic law of the contact and do not depend on f.
 *
 * Both corners of a box slide alike. Their rows of G are the same up to the small angle by which it
 * dips into the floor. Both together would hold that angle, too, with huge forces. So S is factored
 * with pivots, and a row of which less than 1e-3 is new (STEIN__ALIKE) is not held by itself, from
 * one change of a place to the next. Such rows share the force by what each can hold: f = D C (C^T
 * D C)^-1 mu, the rows being C times the independent ones, mu their forces, D the limits over the
 * largest of |C| in the row.
 *
 * Guards, all >= 0 until a place changes: limit - |f| while it sticks, the speed in its direction
 * while it slips.
 *
 * A joint that sticks keeps its coordinate to the bit. A spot on a line returns at the end of
 * every step to where it has stuck, so that nothing creeps. Between two circles v is the rate of
 * no function of q, so only the speed is held.
 */
#include <math.h>
#include <string.h>

#include "core.h"

static const double none_left = 1e-12; /* of a diagonal of S: the row is not independent */
static const double same_size = 2e-3;  /* of the diagonals of S of rows that hold the same */
static const double locked = 1e-12;    /* a diagonal of S, in units of what the masses would give */
static const double moved = 1e-9;      /* [m/s^2 or rad/s^2] acceleration that nothing can hold */
static const double unheld = 1e30;     /* [N or N m] the force that it would take */
/* in shares of all limits: what a place without one counts, and a force that is 0 */
static const double no_limit = 1e-20, no_force = 1e-14;
static const double astray = 1e-13; /* [m] off the anchor that is corrected */

/* ---- places ---- */

static void note_places(stein_sim *sim)
{
    const stein_model *model = sim->model;
    stein__sticks *s = &sim->hold;
    for (int k = 0; k < model->nstick; k++) {
        int j = model->sticks[k].index, is_joint = model->sticks[k].kind == STEIN_STICK_JOINT;
        const double *law = sim->d + (is_joint ? model->bodies[j].joint + STEIN_JOINT_FRICTION : 0);
        s->touch[k] = is_joint ? 0 : -1;
        s->speed[k] = is_joint ? sim->xqd[j] : 0.0;
        s->limit[k] = is_joint ? stein__stick_limit(law) : 0.0;
        s->force[k] = 0.0;
    }
    for (int i = 0; i < sim->ntouch; i++) {
        const touch *t = &sim->touch[i];
        int k = t->pair->stick;
        if (k >= 0) {
            s->touch[k] = i;
            s->speed[k] = t->speed;
            s->limit[k] = fmax(t->normal, 0.0) * stein__stick_limit(t->pair->friction);
        }
    }
}

double stein__stick_slid(const stein_sim *sim, int place)
{
    const stein_stick *stick = &sim->model->sticks[place];
    return stick->kind == STEIN_STICK_JOINT ? sim->xq[stick->index]
                                            : stein__spot_slid(sim, stick->index);
}

/* ---- rows ---- */

/* dv/dqd of a place that touches: the joint forces of a unit force along v */
static void write_row(stein_sim *sim, int place, double *row)
{
    const stein_model *model = sim->model;
    const stein_stick *stick = &model->sticks[place];
    memset(row, 0, sizeof *row * (size_t)model->nq);
    if (stick->kind == STEIN_STICK_JOINT) {
        row[stick->index] = 1.0;
        return;
    }
    const touch *t = &sim->touch[sim->hold.touch[place]];
    vec2 along = {t->n.z, -t->n.x};
    double *Q = sim->Q;
    sim->Q = row;
    memset(sim->wrench, 0, sizeof *sim->wrench * (size_t)model->nframe);
    apply(sim, t->pair->frame[0], t->at, along);
    apply(sim, t->pair->frame[1], t->at, (vec2){-along.x, -along.z});
    stein__wrenches_to_joints(sim);
    sim->Q = Q;
}

/* M^-1 of a row, with M as the last evaluation has left it */
static void divide(stein_sim *sim, const double *row, double *x)
{
    const stein_model *model = sim->model;
    for (int j = 0; j < model->nq; j++) {
        x[j] = stein__is_driven(sim, j) ? 0.0 : row[j];
    }
    if (model->nrow > 0 || model->solve != NULL) {
        (void)stein__solved(sim, x);
    } else {
        stein__substitute(model->nq, sim->parent, sim->M, sim->inverse, x, 1);
    }
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int j = 0; j < n; j++) {
        sum += a[j] * b[j];
    }
    return sum;
}

/* Does a force at this row move nothing? S_rr is the acceleration that a unit force there causes.
 * It is compared with that of the same masses, each free by itself. A joint whose motion is
 * prescribed has the mass that M contains for it (1 without loops, inputs.c). What only rounding
 * moves is locked. */
static int is_locked(const stein_sim *sim, int r)
{
    int nq = sim->model->nq;
    const double *row = sim->hold.G + r * nq;
    double usual = 0.0;
    for (int j = 0; j < nq; j++) {
        double m = sim->M[j * nq + j];
        usual += m > 0.0 ? row[j] * row[j] / m : 0.0;
    }
    return !(sim->hold.S[r * sim->hold.nrow + r] > locked * usual);
}

/* How much of a row is new, in shares of its size; 0: nothing, or it is not to be independent. A
 * place that has held comes before others; one that has shared does so until it has parted. */
static double is_new(const stein_sim *sim, int r)
{
    const stein__sticks *s = &sim->hold;
    int k = s->row[r];
    double share = s->pivot[r] > 0.0 ? s->pivot[r] / s->S[r * s->nrow + r] : 0.0;
    if (!s->deciding) {
        return sim->stick[k] == STUCK && share > none_left ? share : 0.0;
    }
    double least = s->was[k] == SHARES ? STEIN__PARTED * STEIN__ALIKE : STEIN__ALIKE;
    return share > least ? (s->was[k] == STUCK ? 2.0 : 1.0) * share : 0.0;
}

/* S = L L^T over independent rows, in `order`; what is left of the others in `pivot`, -1: locked */
static void factor(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int n = s->nrow;
    memset(s->L, 0, sizeof *s->L * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        s->pivot[i] = is_locked(sim, i) ? -1.0 : s->S[i * n + i];
    }
    for (s->rank = 0; s->rank < n; s->rank++) {
        int best = -1, c = s->rank;
        double most = 0.0;
        for (int i = 0; i < n; i++) {
            double new = is_new(sim, i);
            best = new > most ? i : best;
            most = new > most ? new : most;
        }
        if (best < 0) {
            return;
        }
        s->order[c] = best;
        double root = sqrt(s->pivot[best]);
        for (int i = 0; i < n; i++) {
            double left = s->S[i * n + best] - product(s->L + i * n, s->L + best * n, c);
            if (s->pivot[i] > 0.0) {
                double l = i == best ? root : left / root;
                s->L[i * n + c] = l;
                s->pivot[i] = i == best ? 0.0 : fmax(s->pivot[i] - l * l, 0.0);
            }
        }
    }
}

void stein__stick_rows(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    int nq = sim->model->nq;
    s->nrow = 0;
    for (int k = 0; k < sim->model->nstick; k++) {
        if (is_at_rest(sim->stick[k]) && s->touch[k] >= 0) {
            s->row[s->nrow++] = k;
        }
    }
    for (int r = 0; r < s->nrow; r++) {
        write_row(sim, s->row[r], s->G + r * nq);
        divide(sim, s->G + r * nq, s->X + r * nq);
    }
    for (int i = 0; i < s->nrow; i++) {
        for (int k = 0; k < s->nrow; k++) {
            s->S[i * s->nrow + k] = product(s->G + i * nq, s->X + k * nq, nq);
        }
    }
    factor(sim);
}

/* S mu = rhs over the independent rows, mu in their order */
static void solve(stein__sticks *s)
{
    int n = s->nrow;
    for (int a = 0; a < s->rank; a++) {
        const double *row = s->L + s->order[a] * n;
        s->mu[a] = (s->rhs[s->order[a]] - product(row, s->mu, a)) / row[a];
    }
    for (int a = s->rank - 1; a >= 0; a--) {
        for (int c = a + 1; c < s->rank; c++) {
            s->mu[a] -= s->L[s->order[c] * n + a] * s->mu[c];
        }
        s->mu[a] /= s->L[s->order[a] * n + a];
    }
}

/* to += sum of mu times the independent rows of R [nrow*nq] */
static void add_rows(const stein_sim *sim, const double *R, double *to)
{
    const stein__sticks *s = &sim->hold;
    int nq = sim->model->nq;
    for (int a = 0; a < s->rank; a++) {
        for (int j = 0; j < nq; j++) {
            to[j] += s->mu[a] * R[s->order[a] * nq + j];
        }
    }
}

/* coordinate of a row of a joint that can be held, -1: it is none */
static int joint_held(const stein_sim *sim, int r)
{
    const stein_stick *stick = &sim->model->sticks[sim->hold.row[r]];
    const stein__sticks *s = &sim->hold;
    int is_held = s->pivot[r] >= 0.0 && s->pivot[r] <= none_left * s->S[r * s->nrow + r];
    return stick->kind == STEIN_STICK_JOINT && is_held ? stick->index : -1;
}

/* v += M^-1 G^T mu, and exactly 0 where a joint sticks */
static void add_held(const stein_sim *sim, double *v)
{
    add_rows(sim, sim->hold.X, v);
    for (int r = 0; r < sim->hold.nrow; r++) {
        int j = joint_held(sim, r);
        if (j >= 0) {
            v[j] = 0.0;
        }
    }
}

int stein__stick_alike(const stein__sticks *s, int a, int b)
{
    int n = s->nrow;
    double ab = s->S[a * n + b], aa = s->S[a * n + a], bb = s->S[b * n + b];
    if (s->pivot[a] < 0.0 || s->pivot[b] < 0.0 || !(ab * ab > (1.0 - STEIN__ALIKE) * aa * bb)) {
        return 0;
    }
    return ab > 0.0 ? 1 : -1;
}

/* ---- forces ---- */

/* a row that is one of the independent ones, or the same in other units */
static int share_of_one(stein__sticks *s, int i)
{
    int n = s->nrow;
    for (int c = 0; c < s->rank; c++) {
        int alike = stein__stick_alike(s, i, s->order[c]);
        if (alike != 0) {
            double scale = s->S[i * n + i] / s->S[s->order[c] * n + s->order[c]];
            memset(s->share + i * n, 0, sizeof *s->share * (size_t)n);
            s->share[i * n + c] = fabs(scale - 1.0) < same_size ? alike : alike * sqrt(scale);
            return 1;
        }
    }
    return 0;
}

/* every row by the independent ones, from the right to the left of L */
static void find_shares(stein__sticks *s)
{
    int n = s->nrow;
    for (int i = 0; i < n; i++) {
        double *share = s->share + i * n;
        if (share_of_one(s, i)) {
            continue;
        }
        for (int c = s->rank - 1; c >= 0; c--) {
            share[c] = s->L[i * n + c];
            for (int e = c + 1; e < s->rank; e++) {
                share[c] -= share[e] * s->L[s->order[e] * n + c];
            }
            share[c] /= s->L[s->order[c] * n + c];
        }
    }
}

/* D of a row: rows that hold the same are all at their limit at once, whatever their units */
static double weight(const stein__sticks *s, int i, double total)
{
    double most = 0.0;
    for (int c = 0; c < s->rank; c++) {
        most = fmax(most, fabs(s->share[i * s->nrow + c]));
    }
    double can = s->limit[s->row[i]] + no_limit * total;
    return most > 0.0 ? can / most : can;
}

/* what each row holds of mu, by its limit; pivot [rank] */
static void share_out(stein__sticks *s, int *pivot)
{
    int n = s->nrow, m = s->rank;
    double total = 1e-300;
    find_shares(s);
    for (int i = 0; i < n; i++) {
        total += s->limit[s->row[i]];
    }
    memset(s->H, 0, sizeof *s->H * (size_t)(m * m));
    memcpy(s->y, s->mu, sizeof *s->y * (size_t)m);
    for (int i = 0; i < n; i++) {
        double can = weight(s, i, total);
        for (int k = 0; k < m * m; k++) {
            s->H[k] += can * s->share[i * n + k / m] * s->share[i * n + k % m];
        }
    }
    (void)stein__solve_general(m, s->H, pivot, s->y);
    for (int i = 0; i < n; i++) {
        double f = weight(s, i, total) * product(s->share + i * n, s->y, m);
        s->force[s->row[i]] = fabs(f) > no_force * total ? f : 0.0;
    }
}

/* the forces of all rows: of the independent ones by themselves, or of all together */
static void find_forces(stein__sticks *s, int *room)
{
    if (s->rank == s->nrow) {
        for (int a = 0; a < s->rank; a++) {
            s->force[s->row[s->order[a]]] = s->mu[a];
        }
        return;
    }
    if (s->rank > 0) {
        share_out(s, room);
    }
    for (int r = 0; r < s->nrow; r++) {
        if (s->pivot[r] < 0.0) {
            s->force[s->row[r]] = fabs(s->rhs[r]) > moved ? copysign(unheld, s->rhs[r]) : 0.0;
        }
    }
}

static void write_guards(stein_sim *sim)
{
    const stein__sticks *s = &sim->hold;
    for (int k = 0; k < sim->model->nstick; k++) {
        double *guard = &sim->guard[sim->nguard + k];
        if (s->off || s->touch[k] < 0) {
            *guard = 1.0;
        } else if (is_at_rest(sim->stick[k])) {
            *guard = s->limit[k] - fabs(s->force[k]);
        } else {
            *guard = sim->anchor[k] + (sim->stick[k] == FORWARDS ? s->speed[k] : -s->speed[k]);
        }
    }
}

/* the rows of places that share have to stay nearly dependent */
static void guard_shares(stein_sim *sim)
{
    const stein__sticks *s = &sim->hold;
    for (int r = 0; r < s->nrow; r++) {
        if (sim->stick[s->row[r]] == SHARES && s->pivot[r] >= 0.0) {
            double *guard = &sim->guard[sim->nguard + s->row[r]];
            double own = s->pivot[r] / (STEIN__ALIKE * s->S[r * s->nrow + r]);
            *guard = fmin(*guard, STEIN__PARTED - own);
        }
    }
}

/* rate of the speed of a place with qdd = 0 */
static double bias_of(const stein_sim *sim, int place)
{
    const stein_stick *stick = &sim->model->sticks[place];
    return stick->kind == STEIN_STICK_JOINT
               ? 0.0
               : stein__spot_bias(sim, stick->index, &sim->touch[sim->hold.touch[place]]);
}

double stein__stick_rate(stein_sim *sim, int place)
{
    write_row(sim, place, sim->hold.one);
    return bias_of(sim, place) + product(sim->hold.one, sim->hold.qdd, sim->model->nq);
}

static void hold(stein_sim *sim, double *qdd)
{
    const stein_model *model = sim->model;
    stein__sticks *s = &sim->hold;
    for (int r = 0; r < s->nrow; r++) {
        s->rhs[r] = -bias_of(sim, s->row[r]) - product(s->G + r * model->nq, qdd, model->nq);
    }
    solve(s);
    add_held(sim, qdd);
    add_rows(sim, s->G, sim->Q);
    find_forces(s, sim->pivot);
    for (int r = 0; r < s->nrow; r++) {
        int k = s->row[r];
        if (model->sticks[k].kind == STEIN_STICK_SPOT && s->pivot[r] >= 0.0) {
            sim->touch[s->touch[k]].sum->tangent += s->force[k];
        }
    }
}

void stein__stick_hold(stein_sim *sim, double *qdd)
{
    note_places(sim);
    sim->hold.nrow = 0;
    if (!sim->hold.off) {
        stein__stick_rows(sim);
        if (sim->hold.nrow > 0) {
            hold(sim, qdd);
        }
    }
    if (sim->inside == AT_END) {
        write_guards(sim);
        guard_shares(sim);
    }
}

/* ---- at rest, where it has stuck ---- */

void stein__stick_stop(stein_sim *sim, double *qd)
{
    stein__sticks *s = &sim->hold;
    for (int r = 0; r < s->nrow; r++) {
        s->rhs[r] = -product(s->G + r * sim->model->nq, qd, sim->model->nq);
    }
    solve(s);
    add_held(sim, qd);
}

static void return_to_anchors(stein_sim *sim)
{
    stein__sticks *s = &sim->hold;
    double off = 0.0;
    for (int r = 0; r < s->nrow; r++) {
        s->rhs[r] = sim->anchor[s->row[r]] - stein__stick_slid(sim, s->row[r]);
    }
    for (int a = 0; a < s->rank; a++) {
        off = fmax(off, fabs(s->rhs[s->order[a]]));
    }
    if (off > astray) {
        solve(s);
        add_rows(sim, s->X, sim->xq);
    }
    for (int r = 0; r < s->nrow; r++) {
        int j = joint_held(sim, r);
        if (j >= 0) {
            sim->xq[j] = sim->anchor[s->row[r]];
        }
    }
}

stein_status stein__stick_project(stein_sim *sim, double t, stein_err *err)
{
    int any = 0;
    for (int k = 0; k < sim->model->nstick; k++) {
        any |= is_at_rest(sim->stick[k]);
    }
    if (!any) {
        return STEIN_OK;
    }
    sim->inside = INSIDE;
    stein_status status = stein__evaluate(sim, t, sim->xq, sim->xqd, sim->hold.qdd, err);
    sim->inside = AT_END;
    if (status == STEIN_OK && sim->hold.nrow > 0) {
        return_to_anchors(sim);
        stein__stick_stop(sim, sim->xqd);
    }
    return status;
}

stein_status stein__stick_look(stein_sim *sim)
{
    sim->fresh = STALE;
    return stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->hold.qdd, NULL);
}

stein_status stein_stick_read(stein_sim *sim, int place, stein_held *held, stein_err *err)
{
    const stein__sticks *s = &sim->hold;
    if (place < 0 || place >= sim->model->nstick) {
        return stein__fail(err, STEIN_EINVAL, "place %d of friction that sticks: \"%s\" has %d",
                           place, sim->model->name, sim->model->nstick);
    }
    stein_status status = stein__refresh(sim, err);
    *held = (stein_held){.touches = status == STEIN_OK && s->touch[place] >= 0};
    if (held->touches) {
        held->slips = (int)stein__slips(sim, place);
        held->speed = s->speed[place];
        held->force = s->force[place];
        held->limit = s->limit[place];
        held->shared = held->slips == 0;
    }
    for (int a = 0; held->shared && a < s->rank; a++) {
        held->shared = s->row[s->order[a]] != place;
    }
    return status;
}
