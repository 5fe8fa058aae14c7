/* SPDX-License-Identifier: MIT
 * reaction_loops.c - the forces of loops in reactions.
 *
 * The forces of loops are what the joints that are not prescribed still lack, by virtual power.
 * With w_k the wrench of unit force k of a loop on its second body, and the opposite one on the
 * first, and with s_j the twist of joint j on all that it carries,
 *
 *      sum over k of (s_j . w_k) mu_k = (M qdd + c - Q)_j
 *
 * solved by orthogonal columns with pivots (modified Gram-Schmidt). Forces that no joint feels -
 * across the plane of a plane mechanism, redundant conditions - are no unknowns: they are 0. Those
 * of redundant conditions could be anything: a reaction that changes with them is not determined.
 */
#include <math.h>
#include <string.h>

#include "reaction.h"

static const double unfelt = 1e-10;  /* of the largest column */
static const double rounded = 1e-9;  /* of the largest of its kind, or of a unit force: 0 */
static const double parallel = 1e-6; /* sine of an angle: none */

/* power of a wrench on what joint j carries, by a unit of its speed */
static double power(const stein_sim *sim, const body *b, int j, const wrench6 *w)
{
    double n[3] = {w->n[0], w->n[1], w->n[2]}, arm[3] = {-b->o[0], -b->o[1], -b->o[2]};
    if (sim->model->bodies[j].type == 'T') {
        return dot(b->axis, w->f);
    }
    add_cross(n, arm, w->f);
    return dot(b->axis, n);
}

/* ---- loops ---- */

static int body_at(const stein_sim *sim, const stein_tie *tie, int side)
{
    return sim->model->points[tie->index[side]].body;
}

/* unit forces of a loop on its second body. @return how many */
static int unit_forces(const work *k, const stein_tie *tie, wrench6 *unit)
{
    const stein_sim *sim = k->sim;
    const double *a = sim->px + 3 * tie->index[0], *b = sim->px + 3 * tie->index[1];
    double R[9], along[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    if (tie->kind == STEIN_TIE_COUPLING) {
        unit[0] = (wrench6){.f = {0.0}};
        return 1;
    }
    axes_of(k, body_at(sim, tie, 0), R);
    if (tie->kind == STEIN_TIE_ROD) {
        double length = sqrt(dot(along, along));
        unit[0] = (wrench6){.f = {0.0}};
        push(&unit[0], length > 0.0 ? 1.0 / length : 0.0, along, b);
        return 1;
    }
    int n = put_axes(unit, R, tie->kind == STEIN_TIE_SLOT ? tie->axis : -1, b);
    if (tie->kind == STEIN_TIE_WELD) {
        n += put_axes(unit + n, R, tie->axis, NULL);
    }
    return n;
}

/* 1: joint j carries the body */
static int carries(const stein_sim *sim, int j, int of)
{
    while (of > j) {
        of = sim->model->bodies[of].parent;
    }
    return of == j;
}

static int is_free(const stein_sim *sim, int j)
{
    int free = !stein__is_driven(sim, j);
    for (int i = 0; i < sim->model->nball; i++) {
        free &= sim->model->balls[i].joint != j;
    }
    return free;
}

static double felt_by(const work *k, const stein_tie *tie, const wrench6 *unit, int j)
{
    const stein_sim *sim = k->sim;
    if (tie->kind == STEIN_TIE_COUPLING) {
        return (j == tie->index[0] ? 1.0 : 0.0) - (j == tie->index[1] ? sim->d[tie->ratio] : 0.0);
    }
    int sides = carries(sim, j, body_at(sim, tie, 1)) - carries(sim, j, body_at(sim, tie, 0));
    return sides != 0 ? sides * power(sim, &k->body[j], j, unit) : 0.0;
}

/* what the joints that nothing moves lack of the forces that the motion needs */
static void find_lack(work *k)
{
    const stein_sim *sim = k->sim;
    for (int j = 0; j < sim->model->nq; j++) {
        const body *b = &k->body[j];
        int place = sim->model->nstick > 0 ? sim->hold.joint[j] : -1;
        double sticks = place >= 0 ? sim->hold.force[place] : 0.0;
        k->lack[j] = power(sim, b, j, &b->needs) - power(sim, b, j, &b->stuck) - sticks - sim->Q[j];
        k->lack[j] = is_free(sim, j) ? k->lack[j] : 0.0;
    }
}

/* units and columns of all loops. @return how many */
static int find_columns(work *k)
{
    const stein_model *model = k->sim->model;
    int n = 0;
    for (int i = 0; i < model->nloop; i++) {
        k->first[i] = n;
        n += unit_forces(k, &model->ties[i], k->unit + n);
        for (int u = k->first[i]; u < n; u++) {
            for (int j = 0; j < model->nq; j++) {
                k->column[u * model->nq + j] =
                    is_free(k->sim, j) ? felt_by(k, &model->ties[i], &k->unit[u], j) : 0.0;
            }
        }
    }
    k->first[model->nloop] = n;
    return n;
}

/* the column that is longest of those from r on in front of the others. @return its length */
static double put_longest(work *k, int r, int n)
{
    int nq = k->sim->model->nq, best = r;
    double most = -1.0;
    for (int i = r; i < n; i++) {
        const double *c = k->column + k->order[i] * nq;
        double size = product(c, c, nq);
        if (size > most) {
            most = size;
            best = i;
        }
    }
    int chosen = k->order[best];
    k->order[best] = k->order[r];
    k->order[r] = chosen;
    return sqrt(fmax(most, 0.0));
}

/* Force i of those without a pivot, with 1, and what the others have with it so that no joint feels
 * them: into null. @return its largest element */
static double find_null(work *k, int rank, int n, int i)
{
    double most = 1.0;
    memset(k->null, 0, sizeof *k->null * (size_t)n);
    k->null[k->order[i]] = 1.0;
    for (int r = rank - 1; r >= 0; r--) {
        int own = k->order[r];
        double sum = k->R[own * n + k->order[i]];
        for (int c = r + 1; c < rank; c++) {
            sum += k->R[own * n + k->order[c]] * k->null[k->order[c]];
        }
        k->null[own] = -sum / k->R[own * n + own];
        most = fmax(most, fabs(k->null[own]));
    }
    return most;
}

/* Does joint j do work on a wrench of its loop, in this or another position? What is left of a
 * force or moment by rounding is none. */
static int turns_or_slides(const work *k, const wrench6 *w, int j)
{
    const double *axis = k->body[j].axis;
    double across[3] = {0.0, 0.0, 0.0}, f = sqrt(dot(w->f, w->f)), n = sqrt(dot(w->n, w->n));
    if (k->sim->model->bodies[j].type == 'T') {
        return f > rounded && fabs(dot(w->f, axis)) > parallel * f;
    }
    add_cross(across, w->f, axis);
    return (f > rounded && sqrt(dot(across, across)) > parallel * f) ||
           (n > rounded && fabs(dot(w->n, axis)) > parallel * n);
}

/* largest force and moment of joints, for what is rounding beside them */
static void largest_of(const work *k, double *force, double *moment)
{
    *force = *moment = 0.0;
    for (int j = 0; j < k->sim->model->nq; j++) {
        const body *b = &k->body[j];
        double f = sqrt(dot(b->held.f, b->held.f)), n = sqrt(dot(b->held.n, b->held.n));
        *force = fmax(*force, f);
        *moment = fmax(*moment, n + f * sqrt(dot(b->o, b->o)));
    }
}

/* does joint j already transmit something in the direction of a wrench? */
static int transmits(const work *k, const wrench6 *w, int j)
{
    const body *b = &k->body[j];
    wrench6 here = *w, held = b->held;
    const double back[3] = {-b->o[0], -b->o[1], -b->o[2]};
    double force, moment;
    add_cross(here.n, back, here.f);
    add_cross(held.n, back, held.f);
    largest_of(k, &force, &moment);
    return fabs(dot(here.f, held.f)) > rounded * force * sqrt(dot(here.f, here.f)) ||
           fabs(dot(here.n, held.n)) > rounded * moment * sqrt(dot(here.n, here.n));
}

/* The wrench of loop i in the set of forces k->null, which do no work; it is divided by `most`, the
 * largest of them. @return 0: the loop has no part in them */
static int wrench_of_null(const work *k, int i, double most, wrench6 *w)
{
    int any = 0;
    *w = (wrench6){.f = {0.0}};
    for (int u = k->first[i]; u < k->first[i + 1]; u++) {
        if (fabs(k->null[u]) > rounded * most) {
            join(w, k->null[u] / most, &k->unit[u]);
            any = 1;
        }
    }
    return any;
}

/* The forces k->null do no work, so the equations of motion leave their size open. They are set to
 * 0 and count as determined if two things hold. The hinges of the loop have parallel axes in every
 * position, and the forces act across the plane of those hinges. No joint of the loop transmits a
 * load in the direction of the forces. */
static int is_open(const work *k, double most)
{
    const stein_sim *sim = k->sim;
    for (int i = 0; i < sim->model->nloop; i++) {
        const stein_tie *tie = &sim->model->ties[i];
        wrench6 w, there;
        if (!wrench_of_null(k, i, most, &w)) {
            continue;
        }
        if (tie->kind == STEIN_TIE_COUPLING) {
            return 1;
        }
        const double *at = sim->px + 3 * tie->index[1];
        const double back[3] = {-at[0], -at[1], -at[2]};
        there = w;
        add_cross(there.n, back, there.f);
        for (int j = 0; j < sim->model->nq; j++) {
            int moves =
                carries(sim, j, body_at(sim, tie, 1)) != carries(sim, j, body_at(sim, tie, 0));
            if (moves && (turns_or_slides(k, &there, j) || transmits(k, &w, j))) {
                return 1;
            }
        }
    }
    return 0;
}

/* what others than the first `rank` get, which might have any force */
static void give_slack(work *k, int rank, int n)
{
    for (int i = rank; i < n; i++) {
        double most = k->slack > 0.0 ? find_null(k, rank, n, i) : 1.0;
        int open = k->slack > 0.0 && is_open(k, most);
        k->mu[k->order[i]] = open ? k->slack / (most * (1.0 + 0.3 * k->order[i])) : 0.0;
    }
}

/* mu [n]; what no joint feels is 0, or the slack */
static void solve(work *k, int n)
{
    int nq = k->sim->model->nq, rank = 0;
    double longest = 0.0;
    memset(k->R, 0, sizeof *k->R * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        k->order[i] = i;
        k->mu[i] = 0.0;
    }
    for (; rank < n; rank++) {
        double length = put_longest(k, rank, n);
        longest = rank == 0 ? length : longest;
        if (!(length > unfelt * longest)) {
            break;
        }
        int own = k->order[rank];
        double *unit = k->column + own * nq;
        k->R[own * n + own] = length;
        for (int j = 0; j < nq; j++) {
            unit[j] /= length;
        }
        for (int i = rank + 1; i < n; i++) {
            double *other = k->column + k->order[i] * nq;
            for (int twice = 0; twice < 2; twice++) { // what rounding has left
                k->R[own * n + k->order[i]] += take_part(other, unit, nq);
            }
        }
        k->mu[own] = take_part(k->lack, unit, nq);
    }
    give_slack(k, rank, n);
    for (int r = rank - 1; r >= 0; r--) {
        int own = k->order[r];
        for (int i = r + 1; i < n; i++) {
            k->mu[own] -= k->R[own * n + k->order[i]] * k->mu[k->order[i]];
        }
        k->mu[own] /= k->R[own * n + own];
    }
}

/* loops push what they hold: joints transmit the rest */
static void add_loops(work *k)
{
    const stein_sim *sim = k->sim;
    const stein_model *model = sim->model;
    for (int i = 0; i < model->nloop; i++) {
        const stein_tie *tie = &model->ties[i];
        for (int j = 0; tie->kind != STEIN_TIE_COUPLING && j < model->nq; j++) {
            int sides =
                carries(sim, j, body_at(sim, tie, 1)) - carries(sim, j, body_at(sim, tie, 0));
            for (int u = k->first[i]; sides != 0 && u < k->first[i + 1]; u++) {
                join(&k->body[j].held, -sides * k->mu[u], &k->unit[u]);
            }
        }
    }
}

void stein__loop_forces(work *k)
{
    find_lack(k);
    solve(k, find_columns(k));
    add_loops(k);
}
