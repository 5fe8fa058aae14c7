/* SPDX-License-Identifier: MIT
 * singular.c - singular positions of loops, which a motion passes.
 *
 * There J loses rank: more ways to move meet, and each pivot of the elimination that is lost
 * passes through zero. A smooth motion carries on along its own way with the same speeds. With a
 * the distance to the position, steps that do not look for it meet three errors:
 *
 *   - the qdd of a stage that lies e beside h = 0 is off by e/a;
 *   - on h = 0, rounding is larger by 1/a in positions and by 1/a^2 in speeds;
 *   - A and B of an implicit step (implicit.c) contain rates 1/a that the motion has not.
 *
 * So near such a position stages are first put onto h = 0 and J qd = 0 along J^T, always in the
 * same metric: with that, f is a smooth field, which a Runge-Kutta method follows with its full
 * order. Steps are explicit there. A stage or an end within `apart`/2 of the position is evaluated
 * beside it, at six places q + s qd on both sides: q, qd and qdd on the loops are smooth in s, and
 * the sum of them with the weights of interpolation is the value at s = 0 to order 6. Rejected:
 * steps that end well before the position and lead well across it; ends that are given, of a run or
 * of a fixed step, may be anywhere.
 *
 * The position is found before each step along q + t qd + t^2/2 qdd, from the state alone. The
 * pivots are those of the elimination at its begin, in the same order: each depends smoothly
 * on time. A pivot may also vanish while J keeps its rank (other joints depend then); this costs a
 * shorter step, but is no singular position.
 */
#include <math.h>
#include <string.h>

#include "loops.h"

enum { MOST_BISECTIONS = 40, MOST_POLISHING = 6 };
static const double near_by = 10.0; /* steps: stages are put onto h = 0 */
static const double apart = 0.01;   /* places of a mean, as the fastest hinge turns [rad] */
static const double lost = 0.02;    /* of a pivot where a step begins: none is left */
static const double nearly = 0.3;   /* the same where it is only estimated */

/* ---- pivots along the way ---- */

/* where the motion leads in a time s, in xq */
static void look_ahead(stein_sim *sim, double s)
{
    for (int j = 0; j < sim->model->nq; j++) {
        sim->xq[j] = sim->q[j] + s * (sim->qd[j] + 0.5 * s * sim->qdd[j]);
    }
    stein__loops_at(sim, sim->xq, sim->qd);
}

/* pivots of the elimination in the order of row and column, there, into y */
static void pivots_at(stein_sim *sim, double s)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, r = l->rank_found;
    look_ahead(sim, s);
    memcpy(l->A, l->J, sizeof *l->A * (size_t)(sim->model->nrow * n));
    for (int k = 0; k < r; k++) {
        const double *row = l->A + l->row[k] * n;
        l->y[k] = row[l->column[k]];
        for (int i = k + 1; i < r; i++) {
            double *other = l->A + l->row[i] * n, f = other[l->column[k]] / l->y[k];
            for (int c = k; c < r && f != 0.0; c++) {
                other[l->column[c]] -= f * row[l->column[c]];
            }
        }
    }
}

/* the time at which pivot k vanishes, which has another sign at `end` than at 0 */
static double zero_of(stein_sim *sim, int k, double end)
{
    double lo = 0.0, hi = end, sign = sim->loop.x[k];
    for (int i = 0; i < MOST_BISECTIONS && hi - lo > 1e-9 * end; i++) {
        double s = 0.5 * (lo + hi);
        pivots_at(sim, s);
        *(sim->loop.y[k] * sign > 0.0 ? &lo : &hi) = s;
    }
    return 0.5 * (lo + hi);
}

/* What is left at s of the row of pivot k, in shares of that pivot where the step begins: 0 where J
 * loses rank, about 1 where another joint can take its place. */
static double left_at(stein_sim *sim, int k, double begin, double s)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    look_ahead(sim, s);
    memcpy(l->A, l->J, sizeof *l->A * (size_t)(sim->model->nrow * n));
    for (int i = 0; i < k; i++) {
        const double *row = l->A + l->row[i] * n;
        for (int a = i + 1; a <= k; a++) {
            double *other = l->A + l->row[a] * n, f = other[l->column[i]] / row[l->column[i]];
            for (int j = 0; j < n; j++) {
                other[j] -= f * row[j];
            }
            other[l->column[i]] = 0.0;
        }
    }
    const double *row = l->A + l->row[k] * n;
    double most = 0.0;
    for (int j = 0; j < n; j++) {
        most = l->role[j] == GIVEN ? most : fmax(most, fabs(row[j]));
    }
    return most / fabs(begin);
}

int stein__singular_is_near(const stein_sim *sim, double h)
{
    const stein__loops *l = &sim->loop;
    return sim->model->nrow > 0 && fabs(l->singular) < fmax(near_by * h, l->spacing);
}

int stein__singular_is_close(const stein_sim *sim, double t)
{
    const stein__loops *l = &sim->loop;
    int close = 0;
    for (int i = 0; i < sim->model->nrow; i++) {
        close |= fabs(t - l->lost[i]) < 0.5 * l->spacing;
    }
    return close;
}

/* ---- stages on h = 0 ---- */

/* xq, xqd at t onto the loops down to rounding, in a metric that is the same everywhere */
static void put_on_loops(stein_sim *sim, double t)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow, rank = stein__most_pivots(sim);
    double gap = INFINITY;
    stein__drive(sim, t);
    stein__loops_at(sim, sim->xq, sim->xqd);
    for (int k = 0; k < MOST_POLISHING && stein__largest(l->h, m) < 0.5 * gap; k++) {
        gap = stein__largest(l->h, m);
        stein__loops_correct(sim, NULL, NULL, rank, STEIN__PASSING_PIVOT);
        for (int j = 0; j < n; j++) {
            sim->xq[j] += l->x[j];
        }
        stein__loops_at(sim, sim->xq, sim->xqd);
    }
    (void)stein__loops_speeds(sim, NULL, NULL, sim->xqd);
}

/* xq, xqd at t onto the loops, and qdd into mean[2 nq], as means of places around there */
static stein_status take_means(stein_sim *sim, double t, stein_err *err)
{
    static const double weight[] = {0.75, -0.3, 0.05}; // exact for polynomials up to order 5
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    const place_in_step inside = sim->inside;
    double *mean = l->mean, *about = mean + 3 * n, *qdd = mean + 5 * n;
    stein_status status = STEIN_OK;
    memset(mean, 0, sizeof *mean * 3 * (size_t)n);
    memcpy(about, sim->xq, sizeof *about * (size_t)n);
    memcpy(about + n, sim->xqd, sizeof *about * (size_t)n);
    sim->inside = INSIDE;
    for (int i = 0; i < 6 && status == STEIN_OK; i++) {
        int away = 1 + i / 2; // spacings, on either side
        double w = weight[away - 1], s = (i % 2 ? 1.0 : -1.0) * away * l->spacing;
        for (int j = 0; j < n; j++) {
            sim->xq[j] = about[j] + s * about[n + j];
            sim->xqd[j] = about[n + j];
        }
        put_on_loops(sim, t + s);
        status = stein__evaluate(sim, t + s, sim->xq, sim->xqd, qdd, err);
        for (int j = 0; j < n; j++) {
            mean[j] += w * sim->xq[j];
            mean[n + j] += w * sim->xqd[j];
            mean[2 * n + j] += w * qdd[j];
        }
    }
    sim->inside = inside;
    memcpy(sim->xq, mean, sizeof *mean * (size_t)n);
    memcpy(sim->xqd, mean + n, sizeof *mean * (size_t)n);
    return status;
}

stein_status stein__singular_derive(stein_sim *sim, double t, int at_end, double *k, stein_err *err)
{
    int n = sim->model->nq, close = stein__singular_is_close(sim, t);
    stein_status status = close ? take_means(sim, t, err) : STEIN_OK;
    if (!close && !at_end) {
        put_on_loops(sim, t);
    }
    memmove(k, sim->xqd, sizeof *k * (size_t)n); // it may be there already
    if (status == STEIN_OK) {
        status = stein__evaluate(sim, t, sim->xq, sim->xqd, k + n, err);
    }
    if (close) {
        memcpy(k + n, sim->loop.mean + 2 * n, sizeof *k * (size_t)n);
    }
    return status;
}

/* qdd of the present state, where a step begins */
static void begin_close(stein_sim *sim)
{
    int n = sim->model->nq;
    memcpy(sim->xq, sim->q, sizeof *sim->q * (size_t)n);
    memcpy(sim->xqd, sim->qd, sizeof *sim->q * (size_t)n);
    if (take_means(sim, sim->head->t, NULL) == STEIN_OK) {
        memcpy(sim->qdd, sim->loop.mean + 2 * n, sizeof *sim->qdd * (size_t)n);
    }
    sim->fresh = KNOWN;
}

/* ---- what a step leads across ---- */

/* Places along the motion are so far apart in time. 0 where speeds change by more than themselves
 * on the way: there it turns round. */
static double spacing_of(const stein_sim *sim)
{
    double fastest = 0.0, change = 0.0;
    for (int j = 0; j < sim->model->nq; j++) {
        int turns = sim->model->bodies[j].type == 'R';
        fastest = turns ? fmax(fastest, fabs(sim->qd[j])) : fastest;
        change = turns ? fmax(change, fabs(sim->qdd[j])) : change;
    }
    return apart * change < fastest * fastest ? apart / fastest : 0.0;
}

/* time of the zero of pivot k, of which J loses rank there, as if it changed evenly or, in the next
 * step, exactly; INFINITY: none that is near. Pivots at the begin are in x, at h in b. */
static double lost_at(stein_sim *sim, int k, double h)
{
    stein__loops *l = &sim->loop;
    double begin = l->x[k], s = begin / (begin - l->b[k]) * h;
    if (!(fabs(s) < fmax(near_by * h, l->spacing)) || !(left_at(sim, k, begin, s) < nearly)) {
        return INFINITY;
    }
    return l->b[k] * begin < 0.0 ? zero_of(sim, k, h) : s;
}

void stein__singular_look(stein_sim *sim, double h)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    l->singular = INFINITY;
    l->pass = INFINITY;
    l->spacing = 0.0;
    if (m == 0 || !(h > 0.0)) {
        return;
    }
    l->spacing = spacing_of(sim);
    stein__loops_at(sim, sim->q, sim->qd);
    stein__give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)m);
    (void)stein__partition(sim, l->x, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
    for (int i = 0; i < m; i++) {
        l->lost[i] = INFINITY;
    }
    pivots_at(sim, 0.0);
    memcpy(l->x, l->y, sizeof *l->x * (size_t)n);
    pivots_at(sim, h);
    memcpy(l->b, l->y, sizeof *l->b * (size_t)n);
    for (int k = 0; k < l->rank_found; k++) {
        double s = lost_at(sim, k, h);
        l->lost[l->row[k]] = sim->head->t + s;
        l->singular = fabs(s) < fabs(l->singular) ? s : l->singular;
        if (s > 0.0 && s <= h && s < l->pass && left_at(sim, k, l->x[k], s) < lost) {
            l->pass = s;
        }
    }
    if (stein__singular_is_close(sim, sim->head->t)) {
        begin_close(sim);
    }
}

long long stein_singular_passes(const stein_sim *sim, double *last)
{
    long long n = sim->loop.passed;
    if (last != NULL) {
        *last = n > 0 ? sim->loop.last : (double)NAN;
    }
    return n;
}
