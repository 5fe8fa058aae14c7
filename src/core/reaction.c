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
 * Forces of loops: reaction_loops.c.
 */
#include <math.h>
#include <string.h>

#include "reaction.h"

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
enum { PARTS = 9 };
static size_t measure(const stein_model *m, size_t at[PARTS])
{
    size_t used = 0, n = (size_t)m->nq, u = (size_t)most_forces(m);
    const size_t size[PARTS] = {n * sizeof(body),       u * sizeof(wrench6),
                                u * n * sizeof(double), u * u * sizeof(double),
                                u * sizeof(double),     u * sizeof(double),
                                n * sizeof(double),     ((size_t)m->nloop + 1) * sizeof(int),
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
                  .null = (double *)(void *)(block + at[5]),
                  .lack = (double *)(void *)(block + at[6]),
                  .first = (int *)(void *)(block + at[7]),
                  .order = (int *)(void *)(block + at[8])};
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
        stein__loop_forces(k);
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

double stein__reaction_of(stein_sim *sim, const stein_reaction *r, double slack)
{
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
    return stein__reaction_of(sim, &sim->model->reactions[i], 0.0);
}
