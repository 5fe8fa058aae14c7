/* SPDX-License-Identifier: MIT
 * assemble.c - start positions and speeds that close the loops of a mechanism.
 *
 * Newton's steps of least length from where the joints are, shortened until the gaps shrink; first
 * with what the file states kept as it is, then with all joints free. Where that ends at an open
 * loop - one that lies flat has no direction to move in - it begins again around there, ever
 * farther off, always at the same places. The rank of J is taken where the loops are closed, and
 * once more beside it: where there are more pivots there, the start is singular.
 */
#include <math.h>
#include <string.h>

#include "loops.h"

enum { MOST_NEWTON = 60, MOST_HALVINGS = 8, MOST_STARTS = 24 };
static const double longest = 0.3; /* step of Newton [rad or m] */

int stein__loops_close(stein_sim *sim, const unsigned char *kept, double *q)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *start = l->start, *step = l->step;
    stein__loops_at(sim, q, sim->zero);
    double gap = stein__largest(l->h, m);
    for (int k = 0; gap > 1e-15 && k < MOST_NEWTON; k++) {
        stein__loops_correct(sim, NULL, kept, m, STEIN__RANK_PIVOT);
        memcpy(start, q, sizeof *q * (size_t)n);
        memcpy(step, l->x, sizeof *q * (size_t)n);
        double share = fmin(1.0, longest / stein__largest(step, n)), now = gap;
        for (int half = 0; half < MOST_HALVINGS && !(now < gap && half > 0); half++) {
            for (int j = 0; j < n; j++) {
                q[j] = start[j] + share * step[j];
            }
            stein__loops_at(sim, q, sim->zero);
            now = stein__largest(l->h, m);
            share *= 0.5;
        }
        if (!(now < gap)) {
            memcpy(q, start, sizeof *q * (size_t)n);
            stein__loops_at(sim, q, sim->zero);
            break;
        }
        gap = now;
    }
    return gap <= STEIN__CLOSED;
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
        if (stein__loops_close(sim, kept, q)) {
            return 1;
        }
        double gap = stein__largest(sim->loop.h, sim->model->nrow);
        if (gap < least) {
            least = gap;
            memcpy(best, q, sizeof *q * (size_t)n);
        }
    }
    memcpy(q, kept != NULL ? given : best, sizeof *q * (size_t)n);
    stein__loops_at(sim, q, sim->zero);
    return 0;
}

/* the rank of J at q, where the loops are closed */
static int rank_at(stein_sim *sim, const double *q)
{
    stein__loops *l = &sim->loop;
    stein__loops_at(sim, q, sim->zero);
    stein__give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)sim->model->nrow);
    (void)stein__partition(sim, l->x, sim->model->nrow, STEIN__RANK_PIVOT);
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
    (void)stein__partitioned(sim, NULL, l->b, l->x);
    double size = stein__largest(l->x, n);
    for (int j = 0; j < n; j++) {
        q[j] = sim->q[j] + (size > 0.0 ? 1e-2 / size * l->x[j] : 0.0);
    }
    return stein__loops_close(sim, NULL, q) ? rank_at(sim, q) : 0;
}

/* what stands behind the beginning of a text, NULL: it begins otherwise */
static const char *behind(const char *text, const char *beginning)
{
    while (*beginning != '\0' && *beginning == *text) {
        beginning++;
        text++;
    }
    return *beginning == '\0' ? text : NULL;
}

/* is it the name of what belongs to this body? */
static int is_path(const char *name, const char *body, const char *what)
{
    const char *rest = behind(name, body);
    rest = rest != NULL ? behind(rest, what) : NULL;
    return rest != NULL && *rest == '\0';
}

/* Joints of which the file states the position or speed. One that is not 0 is stated as well,
 * unless the file gives a guess: where the search for a closed position begins. */
static void mark_stated(stein_sim *sim, const char *what, const double *value)
{
    const stein_model *model = sim->model;
    unsigned char *kept = sim->loop.kept;
    for (int j = 0; j < model->nq; j++) {
        const char *body = model->bodies[j].name;
        int stated = 0, guessed = 0;
        for (int i = 0; i < model->np; i++) {
            const stein_param *p = &model->params[i];
            stated |= p->stated && is_path(p->name, body, what);
            guessed |= is_path(p->name, body, ".initial.guess");
        }
        kept[j] = (unsigned char)(stated || (value[j] != 0.0 && !guessed));
    }
}

static stein_status assemble_positions(stein_sim *sim, const unsigned char *kept, stein_err *err)
{
    stein__loops *l = &sim->loop;
    stein__loops_at(sim, sim->q, sim->zero);
    int done = stein__largest(l->h, sim->model->nrow) <= STEIN__CLOSED;
    done = done || (kept != NULL && close_from_around(sim, kept, sim->q));
    done = done || close_from_around(sim, NULL, sim->q);
    if (!done) {
        int is_length;
        double gap;
        const char *name = stein__worst_loop(sim, &gap, &is_length);
        return stein__fail(err, STEIN_ECLOSE,
                           "\"%s\" cannot be closed: nearest to the initial positions it is off by "
                           "%g %s; check lengths and places, or begin nearer",
                           name, gap, is_length ? "m" : "rad");
    }
    l->rank = rank_at(sim, sim->q);
    l->pass = INFINITY;
    if (rank_beside(sim) > l->rank) {
        return stein__fail(err, STEIN_ECLOSE,
                           "the initial position is singular: its loops leave %d ways to move, and "
                           "fewer beside it; begin a little beside it",
                           sim->model->nq - l->rank);
    }
    return STEIN_OK;
}

/* Is J qd = 0 up to rounding? Where J is nearly singular speeds are a mean over places around, and
 * its terms may vanish: then up to rounding of the largest speed. */
static int are_closed(const stein_sim *sim, const double *qd)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq, closed = 1;
    double fastest = stein__largest(qd, n);
    for (int i = 0; i < sim->model->nrow; i++) {
        double rate = 0.0, size = 0.0;
        for (int j = 0; j < n; j++) {
            rate += l->J[i * n + j] * qd[j];
            size += fabs(l->J[i * n + j] * qd[j]);
        }
        closed &= fabs(rate) <= 1e-14 * size || fabs(rate) <= 1e-13 * fastest;
    }
    return closed;
}

static stein_status assemble_speeds(stein_sim *sim, const unsigned char *kept, stein_err *err)
{
    static const double rounding = 1e-9;
    int n = sim->model->nq;
    double *qd = sim->qd1, size = rounding * stein__largest(sim->qd, n);
    memcpy(qd, sim->qd, sizeof *qd * (size_t)n);
    stein__loops_at(sim, sim->q, qd);
    if (are_closed(sim, qd)) { // to the bit as they are
        return STEIN_OK;
    }
    sim->model->unloaded(sim->q, qd, sim->sc, sim->d, sim->M, sim->c);
    if (stein__loops_speeds(sim, sim->M, kept, qd) > size) {
        memcpy(qd, sim->qd, sizeof *qd * (size_t)n);
        if (stein__loops_speeds(sim, sim->M, NULL, qd) > size) {
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
        mark_stated(sim, ".initial.position", sim->q);
    }
    stein_status status = assemble_positions(sim, kept, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (as_stated) {
        mark_stated(sim, ".initial.speed", sim->qd);
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
    return n - sim->model->nball; // charts stay
}
