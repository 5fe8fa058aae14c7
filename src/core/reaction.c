/* SPDX-License-Identifier: MIT
 * reaction.c - what joints and loops transmit.
 *
 * Newton and Euler for every body, in the fixed frame, at the accelerations of the present state,
 *
 *      F = m (a_c - g)      N = I alpha + omega x I omega      about the centre of mass c
 *
 * and from the leaves to the root (Featherstone 2008, section 5.3): the parent of joint j exerts on
 * its child
 *
 *      f_j = sum over all that j carries of F less the forces of contacts, links, inputs and loops
 *
 * and likewise the moments, here about the origin of the fixed frame. What acts in the joint itself
 * - springs, friction, motors, couplings, hooks - is part of f_j, along its axis.
 *
 * The forces of loops are what the joints that nothing moves still lack, by virtual power: with w_k
 * the wrench of unit force k of a loop on its second body, and against it on the first one, and s_j
 * the twist of joint j on all that it carries,
 *
 *      sum over k of (s_j . w_k) mu_k = (M qdd + c - Q)_j
 *
 * solved by orthogonal columns with pivots (modified Gram-Schmidt). Forces that no joint feels -
 * across the plane of a plane mechanism, redundant conditions - are no unknowns: they are 0. Those
 * of redundant conditions could be anything: a reaction that changes with them is not determined.
 */
#include <math.h>
#include <string.h>

#include "core.h"
#include "wrench.h"

enum { MOST_FORCES = 6 };           /* of a loop */
static const double unfelt = 1e-10; /* of the largest column */
static const double changed = 1e-7; /* of a slack: a reaction depends on it */

typedef struct body {
    double R[9], o[3];        /* axes and origin in the fixed frame */
    double w[3], dw[3], a[3]; /* angular velocity and acceleration, that of the origin less g */
    double axis[3];           /* of its joint, times the sign */
    /* of it alone, then of all that it carries: what its motion needs; what contacts, links and
     * inputs give, and what sticks; what joints transmit */
    wrench6 needs, given, stuck, held;
} body;

/* everything, in the memory of the simulation */
typedef struct work {
    const stein_sim *sim;
    body *body;
    wrench6 *unit;  /* [forces of all loops] on the second body */
    double *column; /* [forces][nq] s_j . w_k, then orthogonal */
    double *R;      /* [forces][forces] */
    double *mu;     /* [forces] */
    double *lack;   /* [nq] */
    int *first;     /* [nloop + 1] of the forces of a loop */
    int *order;     /* [forces] */
    double slack;   /* of forces that are free */
} work;

/* ---- memory ---- */

static int most_forces(const stein_model *m)
{
    return MOST_FORCES * m->nloop;
}

static size_t take(size_t *used, size_t size)
{
    size_t at = *used;
    *used += (size + 15u) / 16u * 16u;
    return at;
}

/* where the parts of a block begin. @return its size */
enum { PARTS = 8 };
static size_t measure(const stein_model *m, size_t at[PARTS])
{
    size_t used = 0, n = (size_t)m->nq, u = (size_t)most_forces(m);
    const size_t size[PARTS] = {n * sizeof(body),
                                u * sizeof(wrench6),
                                u * n * sizeof(double),
                                u * u * sizeof(double),
                                u * sizeof(double),
                                n * sizeof(double),
                                ((size_t)m->nloop + 1) * sizeof(int),
                                u * sizeof(int)};
    for (int i = 0; i < PARTS; i++) {
        at[i] = take(&used, size[i]);
    }
    return used;
}

static work work_of(stein_sim *sim)
{
    size_t at[PARTS];
    unsigned char *block = sim->reaction;
    (void)measure(sim->model, at);
    return (work){.sim = sim,
                  .body = (body *)(void *)(block + at[0]),
                  .unit = (wrench6 *)(void *)(block + at[1]),
                  .column = (double *)(void *)(block + at[2]),
                  .R = (double *)(void *)(block + at[3]),
                  .mu = (double *)(void *)(block + at[4]),
                  .lack = (double *)(void *)(block + at[5]),
                  .first = (int *)(void *)(block + at[6]),
                  .order = (int *)(void *)(block + at[7])};
}

size_t stein__reaction_size(const stein_model *model)
{
    size_t at[PARTS];
    return model->nreaction > 0 ? measure(model, at) : 0;
}

/* ---- motion of the bodies ---- */

/* a -= g once at the root: then every body carries its weight */
static body fixed_frame(const stein_sim *sim)
{
    body b = {.R = {[0] = 1.0, [4] = 1.0, [8] = 1.0}};
    add(b.a, -1.0, sim->d + sim->model->gravity);
    return b;
}

/* the acceleration of a place at r from the origin of a body */
static void accelerate(const body *b, const double r[3], double to[3])
{
    double v[3] = {0.0, 0.0, 0.0};
    memcpy(to, b->a, 3 * sizeof *to);
    add_cross(to, b->dw, r);
    add_cross(v, b->w, r);
    add_cross(to, b->w, v);
}

static void move(const stein_sim *sim, const body *up, int j, body *b)
{
    const stein_body *joint = &sim->model->bodies[j];
    const double *made = sim->d + sim->model->made + STEIN_MADE_SIZE * j;
    double q = sim->xq[j], qd = sim->xqd[j], qdd = sim->qdd[j], r[3], spin[3] = {0.0, 0.0, 0.0};
    int axis = joint->axis - 'x', turns = joint->type == 'R';
    column_of(up->R, axis, b->axis);
    for (int i = 0; i < 3; i++) {
        b->axis[i] *= joint->sign;
    }
    turned(up->R, made + STEIN_MADE_AT, 0, r);
    add(r, turns ? 0.0 : q, b->axis);
    memcpy(b->o, up->o, sizeof b->o);
    add(b->o, 1.0, r);
    accelerate(up, r, b->a);
    memcpy(b->w, up->w, sizeof b->w);
    memcpy(b->dw, up->dw, sizeof b->dw);
    add_cross(spin, up->w, b->axis); // rate of the axis
    if (turns) {
        turn_axes(up->R, axis, joint->sign * sim->sc[2 * j], sim->sc[2 * j + 1], b->R);
        add(b->w, qd, b->axis);
        add(b->dw, qdd, b->axis);
        add(b->dw, qd, spin);
    } else {
        memcpy(b->R, up->R, sizeof b->R);
        add(b->a, qdd, b->axis);
        add(b->a, 2.0 * qd, spin);
    }
}

/* m (a_c - g) and what turns the body, as what its joint has to supply */
static void weigh(const stein_sim *sim, int j, body *b)
{
    const double *made = sim->d + sim->model->made + STEIN_MADE_SIZE * j;
    const double *I = made + STEIN_MADE_TENSOR;
    const double tensor[9] = {I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2]};
    double r[3], a[3], c[3], local[3], Iw[3], Idw[3], turn[3];
    turned(b->R, made + STEIN_MADE_CENTRE, 0, r);
    accelerate(b, r, a);
    for (int i = 0; i < 3; i++) {
        c[i] = b->o[i] + r[i];
    }
    push(&b->needs, made[STEIN_MADE_MASS], a, c);
    turned(b->R, b->w, 1, local);
    turned(tensor, local, 0, turn);
    turned(b->R, turn, 0, Iw);
    turned(b->R, b->dw, 1, local);
    turned(tensor, local, 0, turn);
    turned(b->R, turn, 0, Idw);
    add(b->needs.n, 1.0, Idw);
    add_cross(b->needs.n, b->w, Iw);
}

static void move_all(work *k)
{
    const stein_model *model = k->sim->model;
    body frame = fixed_frame(k->sim);
    memset(k->body, 0, sizeof *k->body * (size_t)model->nq);
    for (int j = 0; j < model->nq; j++) {
        int up = model->bodies[j].parent;
        move(k->sim, up >= 0 ? &k->body[up] : &frame, j, &k->body[j]);
        weigh(k->sim, j, &k->body[j]);
    }
}

/* ---- forces on the bodies ---- */

void stein__note_pull(stein_sim *sim, int point, const double f[3])
{
    work k = work_of(sim);
    push(&k.body[sim->model->points[point].body].given, 1.0, f, sim->px + 3 * point);
}

/* what holds places on contacts that stick, along the tangent on the first side */
static void add_sticking(work *k)
{
    const stein_sim *sim = k->sim;
    for (int i = 0; i < sim->model->nstick; i++) {
        if (sim->model->sticks[i].kind != STEIN_STICK_SPOT || sim->hold.touch[i] < 0) {
            continue;
        }
        const touch *t = &sim->touch[sim->hold.touch[i]];
        double f = sim->hold.force[i];
        for (int side = 0; side < 2; side++) {
            int frame = t->pair->frame[side];
            int on = frame >= 0 ? sim->model->frames[frame].body : -1;
            double along[3] = {f * t->n.z, 0.0, -f * t->n.x};
            double at[3] = {t->at.x, on >= 0 ? k->body[on].o[1] : 0.0, t->at.z};
            if (on >= 0) {
                push(&k->body[on].stuck, side == 0 ? 1.0 : -1.0, along, at);
            }
        }
    }
}

/* Wrenches of frames are those of all that a body carries: what the frames on it have is taken off
 * again. In the plane forces act at y of the origin. */
static void add_frames(work *k)
{
    const stein_sim *sim = k->sim;
    for (int i = 0; i < sim->model->nframe; i++) {
        int j = sim->model->frames[i].body, up = sim->model->frames[i].parent;
        const wrench *w = &sim->wrench[i];
        const double f[3] = {w->x, 0.0, w->z};
        wrench6 x = {.n = {0.0, -w->m, 0.0}};
        push(&x, 1.0, f, k->body[j].o);
        join(&k->body[j].given, 1.0, &x);
        if (up >= 0) {
            join(&k->body[sim->model->frames[up].body].given, -1.0, &x);
        }
    }
    for (int i = 0; i < sim->model->npose3; i++) {
        int j = sim->model->frames3[i].body, up = sim->model->frames3[i].parent;
        wrench6 x = {.n = {0.0}};
        memcpy(x.n, sim->wrench3[i].m, sizeof x.n);
        push(&x, 1.0, sim->wrench3[i].f, k->body[j].o);
        join(&k->body[j].given, 1.0, &x);
        if (up >= 0) {
            join(&k->body[sim->model->frames3[up].body].given, -1.0, &x);
        }
    }
}

/* All forces once more, as those of the last evaluation have gone on to Q; Q is what they give. */
static void add_forces(work *k, stein_sim *sim)
{
    sim->notes_pulls = 1;
    stein__forces(sim);
    sim->notes_pulls = 0;
    if (sim->on_force != NULL) {
        sim->on_force(sim->force_ctx, sim->head->t, sim->xq, sim->xqd, sim->Q);
    }
    add_frames(k);
    add_sticking(k);
}

/* from the leaves to the root */
static void carry(work *k)
{
    const stein_model *model = k->sim->model;
    for (int j = model->nq - 1; j >= 0; j--) {
        body *b = &k->body[j];
        int up = model->bodies[j].parent;
        if (up >= 0) {
            join(&k->body[up].needs, 1.0, &b->needs);
            join(&k->body[up].given, 1.0, &b->given);
            join(&k->body[up].stuck, 1.0, &b->stuck);
        }
        b->held = b->needs;
        join(&b->held, -1.0, &b->given);
        join(&b->held, -1.0, &b->stuck);
    }
}

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

static void axes_of(const work *k, int of, double R[9])
{
    static const double unit[9] = {[0] = 1.0, [4] = 1.0, [8] = 1.0};
    memcpy(R, of >= 0 ? k->body[of].R : unit, sizeof unit);
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

/* Is unit u one of a condition of its loop, so that its force is free where no joint feels it?
 * Across the plane of a plane loop, which hinges tell, there is none. */
static int is_condition(const work *k, int u)
{
    const stein_sim *sim = k->sim;
    const wrench6 *unit = &k->unit[u];
    int i = 0, along = 0;
    while (u >= k->first[i + 1]) {
        i++;
    }
    const stein_loop *loop = &sim->model->loops[i];
    const stein_tie *tie = &sim->model->ties[i];
    for (int j = 0; tie->kind != STEIN_TIE_COUPLING && j < sim->model->nq; j++) {
        if (sim->model->bodies[j].type == 'R' &&
            (carries(sim, j, body_at(sim, tie, 0)) || carries(sim, j, body_at(sim, tie, 1)))) {
            int is_force = dot(unit->f, unit->f) > 0.0;
            double part = dot(is_force ? unit->f : unit->n, k->body[j].axis);
            along = is_force == (fabs(part) < 0.5);
        }
    }
    return along || k->first[i + 1] - k->first[i] == loop->lengths + loop->angles;
}

/* what others than the first `rank` get, which might have any force */
static void give_slack(work *k, int rank, int n, double longest)
{
    for (int i = rank; i < n; i++) {
        double felt = 0.0;
        for (int r = 0; r < rank; r++) {
            felt = fmax(felt, fabs(k->R[k->order[r] * n + k->order[i]]));
        }
        int is_free = felt > unfelt * longest || is_condition(k, k->order[i]);
        k->mu[k->order[i]] = is_free ? k->slack / (1.0 + 0.3 * k->order[i]) : 0.0;
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
    give_slack(k, rank, n, longest);
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

/* ---- a reading ---- */

static void find_all(work *k, stein_sim *sim)
{
    const stein_model *model = sim->model;
    if (model->npoint > 0) {
        model->point(sim->xq, sim->xqd, sim->sc, sim->d, sim->px, sim->pv, sim->pJ, sim->pa);
    }
    move_all(k);
    add_forces(k, sim);
    carry(k);
    if (model->nloop > 0) {
        find_lack(k);
        solve(k, find_columns(k));
        add_loops(k);
    }
    if (model->nstick > 0) {
        sim->fresh = STALE; // forces that hold are not in what was evaluated here
    }
}

static wrench6 wrench_of(const work *k, const stein_reaction *r, double at[3])
{
    const stein_sim *sim = k->sim;
    wrench6 w = {.f = {0.0}};
    if (!r->loop) {
        memcpy(at, k->body[r->index].o, 3 * sizeof *at);
        return k->body[r->index].held;
    }
    const stein_tie *tie = &sim->model->ties[r->index];
    memcpy(at, sim->px + 3 * tie->index[1], 3 * sizeof *at);
    for (int u = k->first[r->index]; u < k->first[r->index + 1]; u++) {
        join(&w, k->mu[u], &k->unit[u]);
    }
    return w;
}

static double reaction(stein_sim *sim, int i, double slack)
{
    const stein_reaction *r = &sim->model->reactions[i];
    work k = work_of(sim);
    k.slack = slack;
    find_all(&k, sim);
    if (r->loop && sim->model->ties[r->index].kind == STEIN_TIE_COUPLING) {
        return k.mu[k.first[r->index]];
    }
    double at[3], R[9], v[3], local[3];
    wrench6 w = wrench_of(&k, r, at);
    double back[3] = {-at[0], -at[1], -at[2]};
    add_cross(w.n, back, w.f);
    int moment = r->component == STEIN_MOMENT_SIZE ||
                 (r->component >= STEIN_MOMENT_X && r->component <= STEIN_MOMENT_Z);
    memcpy(v, moment ? w.n : w.f, sizeof v);
    if (r->component >= STEIN_FORCE_SIZE) {
        return sqrt(dot(v, v));
    }
    axes_of(&k, r->axes, R);
    turned(R, v, 1, local);
    return local[(int)r->component % 3];
}

double stein__reaction(stein_sim *sim, int i)
{
    return reaction(sim, i, 0.0);
}

int stein_is_determined(stein_sim *sim, int channel)
{
    const stein_model *m = sim->model;
    int known = channel >= 0 && channel < m->nchannel, i = known ? m->channels[channel].index : 0;
    int read = known ? (int)m->channels[channel].read : STEIN_READ_TIME;
    int is_reaction = read == STEIN_READ_REACTION,
        asked = is_reaction || read == STEIN_READ_TANGENT;
    double value[2] = {0.0, 0.0}, slack = 1.0;
    if (asked && stein__refresh(sim, NULL) != STEIN_OK) {
        return 0;
    }
    if (asked && m->nstick > 0 && stein__stick_shares(sim, is_reaction ? -1 : i)) {
        return 0;
    }
    for (int with = 0; is_reaction && m->nloop > 0 && with < 2; with++) {
        if (stein__refresh(sim, NULL) != STEIN_OK) {
            return 0;
        }
        value[with] = reaction(sim, i, with ? slack : 0.0);
        slack += fabs(value[0]);
    }
    return fabs(value[1] - value[0]) <= changed * slack;
}
