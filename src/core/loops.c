/* SPDX-License-Identifier: MIT
 * loops.c - closed loops and couplings: h(q) = 0 beside the equations of the tree.
 *
 *      M qdd + c = Q + J^T lambda,    J qdd = -Jdot qd
 *
 * Coordinate partitioning (Wehage & Haug 1982) with pivots chosen anew in every evaluation:
 * Gauss-Jordan elimination of J with complete pivoting gives the dependent accelerations by the
 * independent ones, v = s - A u, and what is left is a small positive definite system,
 *
 *      T = [1; -A]      T^T M T u = T^T (Q - c - M [0; s])
 *
 * Rejected: the matrix of all qdd and lambda at once (KKT), or J M^-1 J^T. Both are larger - of a
 * four-bar 5 unknowns or the factors of M and a 2 x 2 matrix, here 1 - and the second one needs an
 * M that is regular without the loops, which bodies without mass in a loop do not give. All
 * coordinates are integrated, so there is no memory of which ones are independent: the choice does
 * not change qdd but by rounding, it depends on the state alone, and no step is cut at a change.
 *
 * Nothing drifts, because every step ends on h = 0 and J qd = 0: a Newton step or two in the metric
 * of M, min dq^T M dq, the same system with another right-hand side. For speeds that is an impulse
 * that does no work along the loop. Steps keep their order (Hairer, Lubich & Wanner 2006, IV.4).
 *
 * Redundant rows - of a Bricard mechanism, of two hinges in a plane loop in space - are found by
 * the rank of J where the loops are closed; within steps, where they are not quite, no more pivots
 * than that are taken, and the rest are the smallest. Where a pivot nearly vanishes in between, at
 * a singular position, its row is left out for that moment: the motion carries on.
 */
#include <math.h>
#include <string.h>

#include "core.h"

enum { MOST_NEWTON = 60, MOST_HALVINGS = 8, MOST_STARTS = 24, MOST_CORRECTIONS = 8 };
static const double closed = 1e-12;       /* gap of a loop that is closed [m or rad] */
static const double rank_pivot = 1e-8;    /* of a row of J with largest element 1: not 0 */
static const double passing_pivot = 1e-9; /* less: a singular position is passed */
static const double longest = 0.3;        /* step of Newton [rad or m] */

/* a joint is independent, follows the others by a row of J, or is given */
enum { FREE, GIVEN, DEPENDENT };

static double largest(const double *x, int n)
{
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        most = isfinite(x[i]) ? fmax(most, fabs(x[i])) : INFINITY;
    }
    return most;
}

/* h, J and Jdot qd at q */
static void close_at(stein_sim *sim, const double *q, const double *qd)
{
    stein_turn(sim->model, q, sim->sc);
    sim->model->closure(q, qd, sim->sc, sim->d, sim->loop.h, sim->loop.J, sim->loop.jdqd);
}

/* ---- elimination ---- */

/* the largest element that may be a pivot, in shares of the largest one of its row. @return it */
static double find_pivot(const stein_sim *sim, int *row, int *column)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double most = 0.0;
    for (int i = 0; i < m; i++) {
        for (int j = 0; !l->used[i] && l->scale[i] > 0.0 && j < n; j++) {
            double size = fabs(l->A[i * n + j]) / l->scale[i];
            if (l->role[j] == FREE && size > most) {
                most = size;
                *row = i;
                *column = j;
            }
        }
    }
    return most;
}

/* row i becomes that of the dependent joint j */
static void eliminate(stein_sim *sim, int i, int j)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *row = l->A + i * n, inverse = 1.0 / row[j];
    l->role[j] = DEPENDENT;
    l->used[i] = 1;
    l->row[l->rank_found] = i;
    l->column[l->rank_found++] = j;
    for (int k = 0; k < n; k++) {
        row[k] = l->role[k] == FREE ? row[k] * inverse : 0.0;
    }
    l->rhs[i] *= inverse;
    for (int a = 0; a < m; a++) {
        double *other = l->A + a * n, f = other[j];
        if (a == i || f == 0.0) {
            continue;
        }
        for (int k = 0; k < n; k++) {
            other[k] -= f * row[k];
        }
        other[j] = 0.0;
        l->rhs[a] -= f * l->rhs[i];
    }
}

/* J x = rhs by elimination, with at most `rank` pivots of at least `least`. Joints that are given
 * have the role and, in x, the value already.
 * @return the largest |rhs| of a row without a pivot, in shares of its largest element */
static double partition(stein_sim *sim, const double *x, int rank, double least)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow, row = 0, column = 0;
    double left = 0.0;
    memcpy(l->A, l->J, sizeof *l->A * (size_t)(m * n));
    for (int i = 0; i < m; i++) {
        l->used[i] = 0;
        l->scale[i] = largest(l->J + i * n, n);
        for (int j = 0; j < n; j++) {
            if (l->role[j] == GIVEN) {
                l->rhs[i] -= l->A[i * n + j] * x[j];
                l->A[i * n + j] = 0.0;
            }
        }
    }
    l->rank_found = 0;
    while (l->rank_found < rank && find_pivot(sim, &row, &column) >= least) {
        eliminate(sim, row, column);
    }
    for (int i = 0; i < m; i++) {
        if (!l->used[i]) {
            left = fmax(left, fabs(l->rhs[i]) / (l->scale[i] > 0.0 ? l->scale[i] : 1.0));
        }
    }
    return left;
}

/* ---- the system of the independent joints ---- */

static double mass(const double *M, int n, int i, int j)
{
    return M != NULL ? M[i * n + j] : i == j ? 1.0 : 0.0;
}

/* b less M times what is known of x: joints that are given, and s of the dependent ones */
static void move_known(const stein_sim *sim, const double *M, const double *x, double *b)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            if (l->role[j] == GIVEN) {
                b[i] -= mass(M, n, i, j) * x[j];
            }
        }
        for (int k = 0; k < l->rank_found; k++) {
            b[i] -= mass(M, n, i, l->column[k]) * l->rhs[l->row[k]];
        }
    }
}

/* S = T^T M T over the independent joints, and T^T b in y */
static void reduce(stein_sim *sim, const double *M, const double *b)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, r = l->rank_found, nu = l->nfree;
    for (int k = 0; k < r; k++) {
        for (int c = 0; c < nu; c++) {
            double sum = mass(M, n, l->column[k], l->free[c]);
            for (int i = 0; i < r; i++) {
                sum -= mass(M, n, l->column[k], l->column[i]) * l->A[l->row[i] * n + l->free[c]];
            }
            l->W[k * nu + c] = sum;
        }
    }
    for (int a = 0; a < nu; a++) {
        l->y[a] = b[l->free[a]];
        for (int k = 0; k < r; k++) {
            l->y[a] -= l->A[l->row[k] * n + l->free[a]] * b[l->column[k]];
        }
        for (int c = 0; c <= a; c++) {
            double sum = mass(M, n, l->free[a], l->free[c]);
            for (int k = 0; k < r; k++) {
                sum -= mass(M, n, l->free[a], l->column[k]) * l->A[l->row[k] * n + l->free[c]];
                sum -= l->A[l->row[k] * n + l->free[a]] * l->W[k * nu + c];
            }
            l->S[a * nu + c] = sum;
        }
    }
}

/* S y = y by L D L^T. @return -1, or the joint whose pivot vanishes */
static int solve_reduced(stein__loops *l)
{
    int n = l->nfree;
    for (int i = 0; i < n; i++) {
        double *row = l->S + i * n, diagonal = row[i];
        for (int j = 0; j < i; j++) {
            const double *above = l->S + j * n;
            for (int k = 0; k < j; k++) {
                row[j] -= row[k] * above[k];
            }
        }
        for (int j = 0; j < i; j++) { // row[j] is L_ij D_j so far
            double f = row[j] / l->S[j * n + j];
            row[i] -= f * row[j];
            l->y[i] -= f * l->y[j];
            row[j] = f;
        }
        if (!(row[i] > 1e-13 * diagonal)) {
            return l->free[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        l->y[i] /= l->S[i * n + i];
        for (int k = i + 1; k < n; k++) {
            l->y[i] -= l->S[k * n + i] * l->y[k];
        }
    }
    return -1;
}

/* min 1/2 x^T M x - b^T x over J x = rhs, after partition(); M NULL: 1. x has the values of what is
 * given; b is worked with. @return -1, or the joint whose pivot vanishes */
static int solve(stein_sim *sim, const double *M, double *b, double *x)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    l->nfree = 0;
    for (int j = 0; j < n; j++) {
        if (l->role[j] == FREE) {
            l->free[l->nfree++] = j;
        }
    }
    move_known(sim, M, x, b);
    reduce(sim, M, b);
    int bad = solve_reduced(l);
    for (int a = 0; a < l->nfree; a++) {
        x[l->free[a]] = l->y[a];
    }
    for (int k = 0; k < l->rank_found; k++) {
        double sum = l->rhs[l->row[k]];
        for (int a = 0; a < l->nfree; a++) {
            sum -= l->A[l->row[k] * n + l->free[a]] * l->y[a];
        }
        x[l->column[k]] = sum;
    }
    return bad;
}

/* ---- accelerations ---- */

static int most_pivots(const stein_sim *sim)
{
    return sim->loop.rank >= 0 ? sim->loop.rank : sim->model->nrow;
}

/* joints that follow a signal or are held, and those marked in `kept` (nullable): given, as 0 */
static void give(stein_sim *sim, const unsigned char *kept, double *x)
{
    for (int j = 0; j < sim->model->nq; j++) {
        int given = stein__is_driven(sim, j) || (kept != NULL && kept[j]);
        sim->loop.role[j] = given ? GIVEN : FREE;
        x[j] = 0.0;
    }
}

int stein__loops_solve(stein_sim *sim, double *b, int moves)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *x = l->x;
    give(sim, NULL, x);
    for (int j = 0; moves && j < n; j++) {
        int i = l->role[j] == GIVEN ? stein__driver_of(sim, j) : STEIN__FREE;
        x[j] = i >= 0 ? sim->ustate[3 * i + 2] : 0.0;
    }
    for (int i = 0; i < m; i++) {
        l->rhs[i] = moves ? -l->jdqd[i] : 0.0;
    }
    (void)partition(sim, x, most_pivots(sim), passing_pivot);
    int bad = solve(sim, sim->M, b, x);
    memcpy(b, x, sizeof *x * (size_t)n);
    return bad;
}

int stein__loops_accelerate(stein_sim *sim, double *qdd)
{
    const stein_model *model = sim->model;
    model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
    model->closure(sim->xq, sim->xqd, sim->sc, sim->d, sim->loop.h, sim->loop.J, sim->loop.jdqd);
    for (int j = 0; j < model->nq; j++) {
        qdd[j] = sim->Q[j] - sim->c[j];
    }
    return stein__loops_solve(sim, qdd, 1);
}

/* The dependent joints have no force but those of the loops: J_v^T lambda = what is missing there.
 */
void stein__loops_take(stein_sim *sim, double *missing)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, r;
    close_at(sim, sim->xq, sim->xqd);
    give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)sim->model->nrow);
    (void)partition(sim, l->x, most_pivots(sim), passing_pivot);
    r = l->rank_found;
    for (int k = 0; k < r; k++) {
        l->y[k] = missing[l->column[k]];
        for (int i = 0; i < r; i++) {
            l->S[k * r + i] = l->J[l->row[i] * n + l->column[k]];
        }
    }
    if (stein__solve_general(r, l->S, l->y) != 0) {
        return;
    }
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < r; k++) {
            missing[j] -= l->J[l->row[k] * n + j] * l->y[k];
        }
    }
}

/* ---- on h = 0 ---- */

/* the loop of a row */
static const char *name_of_row(const stein_model *model, int row, int *is_length)
{
    int i = 0;
    while (row >= model->loops[i].lengths + model->loops[i].angles) {
        row -= model->loops[i].lengths + model->loops[i].angles;
        i++;
    }
    *is_length = row < model->loops[i].lengths;
    return model->loops[i].name;
}

static int worst_row(const stein_sim *sim)
{
    int worst = 0;
    for (int i = 1; i < sim->model->nrow; i++) {
        worst = fabs(sim->loop.h[i]) > fabs(sim->loop.h[worst]) ? i : worst;
    }
    return worst;
}

static stein_status fail_open(const stein_sim *sim, double t, stein_err *err)
{
    int is_length, row = worst_row(sim);
    const char *name = name_of_row(sim->model, row, &is_length);
    return stein__fail(err, STEIN_ECLOSE,
                       "\"%s\" does not stay closed at t = %g s: off by %g %s (a prescribed motion "
                       "beyond its reach, or a step that is too long)",
                       name, t, fabs(sim->loop.h[row]), is_length ? "m" : "rad");
}

/* dq with J dq = -h in the metric M into l->x; `kept` joints stay */
static void correct(stein_sim *sim, const double *M, const unsigned char *kept, int rank,
                    double least)
{
    stein__loops *l = &sim->loop;
    give(sim, kept, l->x);
    for (int i = 0; i < sim->model->nrow; i++) {
        l->rhs[i] = -l->h[i];
    }
    (void)partition(sim, l->x, rank, least);
    memset(l->b, 0, sizeof *l->b * (size_t)sim->model->nq);
    if (solve(sim, M, l->b, l->x) >= 0) { // no mass there: each joint counts alike
        memset(l->b, 0, sizeof *l->b * (size_t)sim->model->nq);
        (void)solve(sim, NULL, l->b, l->x);
    }
}

/* qd at q, whose J is there, onto J qd = 0. @return what is left, in m/s or rad/s by size 1 */
static double project_speeds(stein_sim *sim, const double *M, const unsigned char *kept, double *qd)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    give(sim, kept, l->x);
    for (int i = 0; i < sim->model->nrow; i++) {
        l->rhs[i] = 0.0;
        for (int j = 0; j < n; j++) {
            l->rhs[i] -= l->J[i * n + j] * qd[j];
        }
    }
    double left = partition(sim, l->x, most_pivots(sim), passing_pivot);
    memset(l->b, 0, sizeof *l->b * (size_t)n);
    if (solve(sim, M, l->b, l->x) < 0) {
        for (int j = 0; j < n; j++) {
            qd[j] += l->x[j];
        }
    }
    return left;
}

stein_status stein__loops_project(stein_sim *sim, double t, stein_err *err)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    stein__drive(sim, t);
    close_at(sim, sim->xq, sim->xqd);
    for (int k = 0; largest(l->h, sim->model->nrow) > 0.01 * closed && k < MOST_CORRECTIONS; k++) {
        correct(sim, sim->M, NULL, most_pivots(sim), passing_pivot);
        for (int j = 0; j < n; j++) {
            sim->xq[j] += l->x[j];
        }
        close_at(sim, sim->xq, sim->xqd);
    }
    if (!(largest(l->h, sim->model->nrow) <= closed)) {
        return isfinite(largest(sim->xq, n)) ? fail_open(sim, t, err) : STEIN_OK;
    }
    (void)project_speeds(sim, sim->M, NULL, sim->xqd);
    return STEIN_OK;
}

/* ---- assembly ---- */

/* Newton from q, steps of least length, shortened until the gaps shrink. @return is it closed? */
static int close_positions(stein_sim *sim, const unsigned char *kept, double *q)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *start = l->start, *step = l->step;
    close_at(sim, q, sim->zero);
    double gap = largest(l->h, m);
    for (int k = 0; gap > 1e-15 && k < MOST_NEWTON; k++) {
        correct(sim, NULL, kept, m, rank_pivot);
        memcpy(start, q, sizeof *q * (size_t)n);
        memcpy(step, l->x, sizeof *q * (size_t)n);
        double share = fmin(1.0, longest / largest(step, n)), now = gap;
        for (int half = 0; half < MOST_HALVINGS && !(now < gap && half > 0); half++) {
            for (int j = 0; j < n; j++) {
                q[j] = start[j] + share * step[j];
            }
            close_at(sim, q, sim->zero);
            now = largest(l->h, m);
            share *= 0.5;
        }
        if (!(now < gap)) {
            memcpy(q, start, sizeof *q * (size_t)n);
            close_at(sim, q, sim->zero);
            break;
        }
        gap = now;
    }
    return gap <= closed;
}

/* numbers in [-1, 1), the same ones every time (splitmix64) */
static double draw(uint64_t *seed)
{
    uint64_t z = (*seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-52 - 1.0;
}

/* from q itself, then from places around it, ever farther off. @return is it closed? If not, q is
 * where the gap is least. */
static int close_from_around(stein_sim *sim, const unsigned char *kept, double *q)
{
    int n = sim->model->nq;
    double *given = sim->q0, *best = sim->q1, least = INFINITY;
    uint64_t seed = 1;
    memcpy(given, q, sizeof *q * (size_t)n);
    for (int k = 0; k <= MOST_STARTS; k++) {
        double reach = 1.5 * (double)k / MOST_STARTS;
        for (int j = 0; j < n; j++) {
            double off = reach * draw(&seed) * (sim->model->bodies[j].type == 'R' ? 1.0 : 0.1);
            int stays = stein__is_driven(sim, j) || (kept != NULL && kept[j]);
            q[j] = given[j] + (stays ? 0.0 : off);
        }
        if (close_positions(sim, kept, q)) {
            return 1;
        }
        double gap = largest(sim->loop.h, sim->model->nrow);
        if (gap < least) {
            least = gap;
            memcpy(best, q, sizeof *q * (size_t)n);
        }
    }
    memcpy(q, kept != NULL ? given : best, sizeof *q * (size_t)n);
    close_at(sim, q, sim->zero);
    return 0;
}

/* the rank of J at q, where the loops are closed */
static int rank_at(stein_sim *sim, const double *q)
{
    stein__loops *l = &sim->loop;
    close_at(sim, q, sim->zero);
    give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)sim->model->nrow);
    (void)partition(sim, l->x, sim->model->nrow, rank_pivot);
    return l->rank_found;
}

/* the same a little farther on the way that the loops leave */
static int rank_beside(stein_sim *sim)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    double *q = sim->q1;
    uint64_t seed = 2;
    (void)rank_at(sim, sim->q);
    for (int j = 0; j < n; j++) {
        l->b[j] = draw(&seed);
    }
    (void)solve(sim, NULL, l->b, l->x);
    double size = largest(l->x, n);
    for (int j = 0; j < n; j++) {
        q[j] = sim->q[j] + (size > 0.0 ? 1e-2 / size * l->x[j] : 0.0);
    }
    return close_positions(sim, NULL, q) ? rank_at(sim, q) : 0;
}

static void mark_stated(stein_sim *sim, const char *what, const double *value, unsigned char *kept)
{
    const stein_model *model = sim->model;
    for (int j = 0; j < model->nq; j++) {
        char path[128];
        size_t n = strlen(model->bodies[j].name);
        kept[j] = value[j] != 0.0;
        if (n + strlen(what) < sizeof path) {
            memcpy(path, model->bodies[j].name, n);
            memcpy(path + n, what, strlen(what) + 1);
            int i = stein_find_param(model, path);
            kept[j] |= (unsigned char)(i >= 0 && model->params[i].stated);
        }
    }
}

static stein_status assemble_positions(stein_sim *sim, const unsigned char *kept, stein_err *err)
{
    stein__loops *l = &sim->loop;
    close_at(sim, sim->q, sim->zero);
    int done = largest(l->h, sim->model->nrow) <= closed;
    done = done || (kept != NULL && close_from_around(sim, kept, sim->q));
    done = done || close_from_around(sim, NULL, sim->q);
    if (!done) {
        int is_length, row = worst_row(sim);
        const char *name = name_of_row(sim->model, row, &is_length);
        return stein__fail(err, STEIN_ECLOSE,
                           "\"%s\" cannot be closed: nearest to the initial positions it is off by "
                           "%g %s; check lengths and places, or begin nearer",
                           name, fabs(l->h[row]), is_length ? "m" : "rad");
    }
    l->rank = rank_at(sim, sim->q);
    if (rank_beside(sim) > l->rank) {
        return stein__fail(err, STEIN_ECLOSE,
                           "the initial position is singular: its loops leave %d ways to move, and "
                           "fewer beside it; begin a little beside it",
                           sim->model->nq - l->rank);
    }
    return STEIN_OK;
}

static stein_status assemble_speeds(stein_sim *sim, const unsigned char *kept, stein_err *err)
{
    static const double rounding = 1e-9;
    int n = sim->model->nq;
    double *qd = sim->qd1, size = rounding * largest(sim->qd, n);
    memcpy(qd, sim->qd, sizeof *qd * (size_t)n);
    close_at(sim, sim->q, qd);
    sim->model->unloaded(sim->q, qd, sim->sc, sim->d, sim->M, sim->c);
    if (project_speeds(sim, sim->M, kept, qd) > size) {
        memcpy(qd, sim->qd, sizeof *qd * (size_t)n);
        if (project_speeds(sim, sim->M, NULL, qd) > size) {
            return stein__fail(err, STEIN_ECLOSE,
                               "the prescribed motions contradict each other: the loops do not "
                               "allow their speeds at t = %g s",
                               sim->head->t);
        }
    }
    memcpy(sim->qd, qd, sizeof *qd * (size_t)n);
    return STEIN_OK;
}

stein_status stein__loops_assemble(stein_sim *sim, int as_stated, stein_err *err)
{
    unsigned char *kept = as_stated ? sim->loop.kept : NULL;
    if (as_stated) {
        mark_stated(sim, ".initial.position", sim->q, kept);
    }
    stein_status status = assemble_positions(sim, kept, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (as_stated) {
        mark_stated(sim, ".initial.speed", sim->qd, kept);
    }
    sim->fresh = STALE;
    return assemble_speeds(sim, kept, err);
}

int stein_freedom(const stein_sim *sim)
{
    int n = sim->model->nq - (sim->model->nrow > 0 && sim->loop.rank > 0 ? sim->loop.rank : 0);
    for (int j = 0; j < sim->model->nq; j++) {
        n -= stein__is_driven(sim, j);
    }
    return n;
}
