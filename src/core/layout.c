/* SPDX-License-Identifier: MIT
 * layout.c - the memory of a simulation, alone or in lanes.
 *
 * One block, carved twice by the same function - once with a NULL base to learn the size, once for
 * real - so that sizes and offsets cannot disagree.
 */
#include "core.h"

enum { GRAIN = sizeof(real) < 16 ? 16 : sizeof(real) };

typedef struct arena {
    unsigned char *base; /* NULL: only measure */
    size_t used;
} arena;

static void *carve(arena *a, size_t size)
{
    void *at = a->base == NULL ? NULL : a->base + a->used;
    a->used += (size + GRAIN - 1u) / GRAIN * GRAIN;
    return at;
}

static double *doubles(arena *a, int n)
{
    return carve(a, sizeof(double) * (size_t)n);
}

static real *reals(arena *a, int n)
{
    return carve(a, sizeof(real) * (size_t)n);
}

/* n + 1 elements, of which the first has the index -1 */
static void *behind_first(arena *a, size_t size, int n)
{
    unsigned char *at = carve(a, size * (size_t)(n + 1));
    return at == NULL ? NULL : at + size;
}

/* a part of what was carved */
static real *part(const arena *a, real *of, int at)
{
    return a->base == NULL ? NULL : of + at;
}

static void carve_state(stein_sim *s, arena *a, const stein_model *m)
{
    size_t start = a->used;
    s->state = carve(a, sizeof *s->head);
    s->head = (state_head *)(void *)s->state;
    s->q = reals(a, m->nq);
    s->qd = reals(a, m->nq);
    s->rest = doubles(a, 2 * m->nchannel);
    s->mode = carve(a, sizeof *s->mode * (size_t)s->nguard);
    s->phase = carve(a, (size_t)m->nnotch);
    s->engaged = carve(a, (size_t)m->nnotch);
    s->held = carve(a, sizeof *s->held * (size_t)m->nq);
    s->stick = carve(a, (size_t)m->nstick);
    s->anchor = doubles(a, m->nstick);
    s->state_size = a->used - start;
}

static void carve_loops(stein__loops *l, arena *a, const stein_model *m)
{
    int n = m->nq, rows = m->nrow;
    if (rows == 0) {
        return;
    }
    l->h = doubles(a, rows);
    l->J = doubles(a, rows * n);
    l->jdqd = doubles(a, rows);
    l->A = doubles(a, rows * n);
    l->rhs = doubles(a, rows);
    l->scale = doubles(a, rows);
    l->best = doubles(a, rows);
    l->lost = doubles(a, rows);
    l->mean = doubles(a, 6 * n);
    l->W = doubles(a, n * n);
    l->S = doubles(a, n * n);
    l->y = doubles(a, n);
    l->x = doubles(a, n);
    l->b = doubles(a, n);
    l->start = doubles(a, n);
    l->step = doubles(a, n);
    l->row = carve(a, sizeof *l->row * (size_t)n);
    l->column = carve(a, sizeof *l->column * (size_t)n);
    l->free = carve(a, sizeof *l->free * (size_t)n);
    l->best_column = carve(a, sizeof *l->best_column * (size_t)rows);
    l->role = carve(a, (size_t)n);
    l->used = carve(a, (size_t)rows);
    l->kept = carve(a, (size_t)n);
}

static void carve_sticks(stein__sticks *s, arena *a, const stein_model *m)
{
    int n = m->nstick;
    s->joint = carve(a, sizeof *s->joint * (size_t)m->nq);
    if (n == 0) {
        return;
    }
    double **const each[] = {&s->slack, &s->speed, &s->force, &s->limit,
                             &s->rhs,   &s->mu,    &s->y,     &s->pivot};
    double **const square[] = {&s->S, &s->L, &s->share, &s->H};
    for (size_t i = 0; i < sizeof each / sizeof *each; i++) {
        *each[i] = doubles(a, n);
    }
    for (size_t i = 0; i < sizeof square / sizeof *square; i++) {
        *square[i] = doubles(a, n * n);
    }
    s->G = doubles(a, n * m->nq);
    s->X = doubles(a, n * m->nq);
    s->qdd = doubles(a, m->nq);
    s->one = doubles(a, m->nq);
    s->touch = carve(a, sizeof *s->touch * (size_t)n);
    s->row = carve(a, sizeof *s->row * (size_t)n);
    s->order = carve(a, sizeof *s->order * (size_t)n);
    s->was = carve(a, (size_t)n);
    s->done = carve(a, (size_t)n);
}

#if STEIN_LANES == 1
static void carve_places(places *p, arena *a, int n)
{
    p->one = carve(a, sizeof *p->one * (size_t)n);
    p->group = carve(a, sizeof *p->group * (size_t)n);
}
#endif

static void carve_all(stein_sim *s, arena *a, const stein_model *m)
{
    int nq = m->nq;
    carve_state(s, a, m);
    s->p = doubles(a, m->np);
    s->d = reals(a, m->nd);
    s->slope = reals(a, stein__table_points(m));
    s->table_on = carve(a, sizeof *s->table_on * (size_t)m->ntable);
    s->parent = carve(a, sizeof *s->parent * (size_t)nq);
    s->turning = carve(a, sizeof *s->turning * (size_t)nq);
    s->acting = carve(a, sizeof *s->acting * (size_t)nq);
    s->limb = carve(a, sizeof *s->limb * (size_t)m->nframe);
    s->nsite = m->nspot + NOTCH_REGION * m->nnotch;
    s->site = carve(a, sizeof *s->site * (size_t)s->nsite);
#if STEIN_LANES == 1
    carve_places(&s->active, a, s->nsite);
    carve_places(&s->apart, a, m->nspot);
    s->as_of = carve(a, (size_t)s->nguard);
#endif
    s->qdd = reals(a, nq);
    s->guard = reals(a, s->nswitch);
    s->spot = carve(a, sizeof *s->spot * (size_t)m->nspot);
    s->beak = carve(a, sizeof *s->beak * (size_t)m->nnotch);
    s->Q = reals(a, nq + 3); // as clear() needs it
    s->pose = behind_first(a, sizeof *s->pose, m->nframe);
    s->touch = carve(a, sizeof *s->touch * (size_t)s->nsite);
    s->begin = carve(a, sizeof *s->begin * (size_t)s->nsite);
    s->slip = reals(a, s->nsite + nq);
    s->grip = reals(a, s->nsite + nq);
    s->wrench = behind_first(a, sizeof *s->wrench, m->nframe + 1); // likewise
    s->pose3 = behind_first(a, sizeof *s->pose3, m->npose3);
    s->wrench3 = behind_first(a, sizeof *s->wrench3, m->npose3);
    s->touch3 = carve(a, sizeof *s->touch3 * (size_t)(m->npose3 > 0 ? m->nspot : 0));
    s->M = reals(a, nq * nq);
    s->c = reals(a, nq);
    s->inverse = reals(a, nq);
    s->sc = reals(a, 2 * nq);
    s->sc_asked = doubles(a, 2 * nq);
    s->ustate = reals(a, 3 * m->ninput);
    s->px = reals(a, 3 * m->npoint);
    s->pv = reals(a, 3 * m->npoint);
    s->pJ = reals(a, 3 * m->npoint * nq);
    s->pa = reals(a, 3 * m->npoint);
    s->width = (2 * nq + STEIN__SUMS - 1) / STEIN__SUMS * STEIN__SUMS;
    s->x = reals(a, s->width);
    s->xq = part(a, s->x, 0);
    s->xqd = part(a, s->x, nq);
    s->stride = nq + s->width;
    s->y0 = reals(a, 7 * s->stride);
    s->k = part(a, s->y0, nq);
    s->q0 = part(a, s->y0, 0);
    s->qd0 = part(a, s->y0, nq);
    s->qdd0 = part(a, s->y0, 2 * nq);
    s->q1 = part(a, s->y0, 6 * s->stride);
    s->qd1 = part(a, s->q1, nq);
    s->qdd1 = part(a, s->q1, 2 * nq);
    s->e = reals(a, s->width);
    s->zero = reals(a, 3 * nq + STEIN__SUMS);
    s->work = doubles(a, nq * nq + 2 * nq);
    s->root = doubles(a, s->nswitch);
    s->from = doubles(a, s->nswitch);
    s->to = doubles(a, s->nswitch);
    s->behind = doubles(a, s->nswitch);
    s->pivot = carve(a, sizeof *s->pivot * (size_t)nq);
    s->crossed = carve(a, (size_t)s->nswitch);
    carve_loops(&s->loop, a, m);
    carve_sticks(&s->hold, a, m);
#if STEIN_LANES == 1
    s->reaction = carve(a, stein__reaction_size(m));
#endif
    size_t signals = (size_t)m->ninput * (sizeof(real) / sizeof(double));
    s->signal = carve(a, sizeof *s->signal * signals);
    s->signal_ctx = carve(a, sizeof *s->signal_ctx * signals);
#if STEIN_LANES > 1
    s->bound = carve(a, sizeof *s->bound * (size_t)m->ninput);
#endif
}

INNER size_t stein__layout(stein_sim *sim, const stein_model *model)
{
    stein_sim measured = {.model = model};
    stein_sim *s = sim != NULL ? sim : &measured;
    arena a = {(unsigned char *)sim, 0};
    s->nguard = model->nspot + NOTCH_GUARDS * model->nnotch;
    s->nswitch = s->nguard + model->nstick;
    carve(&a, sizeof *s);
    carve_all(s, &a, model);
    return a.used;
}
