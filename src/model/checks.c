/* SPDX-License-Identifier: MIT
 * checks.c - checks that need all numbers: inertias, mass matrix, extents.
 *
 * The mass matrix is built here from body Jacobians, M = sum m Jv^T Jv + Jw^T I Jw +
 * diag(armature), at a few fixed but arbitrary configurations. That is slower than the generator's
 * recursion and shares nothing with it. A joint whose pivot vanishes in all of them has nothing to
 * accelerate.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "reader.h"
#include "stein/model.h"

enum { N = MECH_BODIES, CONFIGURATIONS = 3 };

typedef struct vec {
    double x[3];
} vec;

typedef struct mat {
    double x[3][3];
} mat;

/** The tree at one configuration, in the fixed frame. */
typedef struct pose {
    mat R[N];    /* body to frame */
    vec p[N];    /* joint [m] */
    vec c[N];    /* centre of mass [m] */
    vec a[N];    /* joint axis */
    double size; /* largest distance from the frame's origin [m] */
} pose;

static vec rotate(const mat *R, vec v)
{
    vec r;

    for (int i = 0; i < 3; i++) {
        r.x[i] = R->x[i][0] * v.x[0] + R->x[i][1] * v.x[1] + R->x[i][2] * v.x[2];
    }
    return r;
}

static vec cross(vec a, vec b)
{
    vec r = {{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
              a.x[0] * b.x[1] - a.x[1] * b.x[0]}};

    return r;
}

static double dot(vec a, vec b)
{
    return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}

static vec sub(vec a, vec b)
{
    vec r = {{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};

    return r;
}

static vec values(const mech_scalar s[3])
{
    vec r = {{s[0].value, s[1].value, s[2].value}};

    return r;
}

/** Rotation by q about a coordinate axis after P. */
static mat turn(const mat *P, int axis, double q)
{
    int j = (axis + 1) % 3, k = (axis + 2) % 3;
    double c = cos(q), s = sin(q);
    mat R;

    for (int i = 0; i < 3; i++) {
        R.x[i][axis] = P->x[i][axis];
        R.x[i][j] = c * P->x[i][j] + s * P->x[i][k];
        R.x[i][k] = c * P->x[i][k] - s * P->x[i][j];
    }
    return R;
}

static void place(const mechanism *m, const double *q, pose *at)
{
    static const mat fixed = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

    at->size = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        const mat *P = b->parent < 0 ? &fixed : &at->R[b->parent];
        int axis = b->axis - 'x';
        vec joint = rotate(P, values(b->at)), centre;

        for (int k = 0; k < 3; k++) {
            at->a[i].x[k] = b->sign * P->x[k][axis];
            at->p[i].x[k] = joint.x[k] + (b->parent < 0 ? 0.0 : at->p[b->parent].x[k]);
        }
        at->R[i] = turn(P, axis, b->type == 'R' ? b->sign * q[i] : 0.0);
        for (int k = 0; k < 3 && b->type == 'T'; k++) {
            at->p[i].x[k] += q[i] * at->a[i].x[k];
        }
        centre = rotate(&at->R[i], values(b->centre));
        for (int k = 0; k < 3; k++) {
            at->c[i].x[k] = at->p[i].x[k] + centre.x[k];
        }
        at->size =
            fmax(at->size, fmax(sqrt(dot(at->p[i], at->p[i])), sqrt(dot(at->c[i], at->c[i]))));
    }
}

/** Moment I w of a body's inertia, all in the fixed frame. */
static vec inertia_times(const mech_body *b, const mat *R, vec w)
{
    const mech_scalar *I = b->inertia;
    double l[3];
    vec v;

    for (int i = 0; i < 3; i++) {
        l[i] = R->x[0][i] * w.x[0] + R->x[1][i] * w.x[1] + R->x[2][i] * w.x[2];
    }
    v.x[0] = I[0].value * l[0] + I[3].value * l[1] + I[4].value * l[2];
    v.x[1] = I[3].value * l[0] + I[1].value * l[1] + I[5].value * l[2];
    v.x[2] = I[4].value * l[0] + I[5].value * l[1] + I[2].value * l[2];
    return rotate(R, v);
}

/** Add one body's share to M; scale collects what a joint could move at most. */
static void add_body(const mechanism *m, const pose *at, int body, double M[N][N], double *scale)
{
    const mech_body *b = &m->bodies[body];
    double mass = b->mass.value;
    double inertia = b->inertia[0].value + b->inertia[1].value + b->inertia[2].value;

    M[body][body] += b->armature.value;
    scale[body] += b->armature.value;
    for (int i = body; i >= 0; i = m->bodies[i].parent) {
        int turns_i = m->bodies[i].type == 'R';
        vec arm = sub(at->c[body], at->p[i]);
        vec vi = turns_i ? cross(at->a[i], arm) : at->a[i];
        vec moment = turns_i ? inertia_times(b, &at->R[body], at->a[i]) : (vec){{0.0, 0.0, 0.0}};

        scale[i] += turns_i ? mass * (dot(arm, arm) + at->size * at->size) + inertia : mass;
        for (int k = i; k >= 0; k = m->bodies[k].parent) {
            int turns_k = m->bodies[k].type == 'R';
            vec vk = turns_k ? cross(at->a[k], sub(at->c[body], at->p[k])) : at->a[k];
            double share = mass * dot(vi, vk) + (turns_k ? dot(moment, at->a[k]) : 0.0);

            M[i][k] += share;
            M[k][i] = M[i][k];
        }
    }
}

/** Cholesky with diagonal pivoting of M scaled to a unit diagonal, over the free joints.
 *  @return index of a joint without a pivot, -1 when M is regular */
static int lost_pivot(double M[N][N], const double *scale, const char *held, int n)
{
    char done[N];
    double root[N];

    for (int i = 0; i < n; i++) {
        done[i] = held[i];
        if (!held[i] && !(M[i][i] > 1e-22 * scale[i])) {
            return i;
        }
        root[i] = held[i] ? 1.0 : sqrt(M[i][i]);
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            M[i][k] /= root[i] * root[k];
        }
    }
    for (;;) {
        int pivot = -1;

        for (int i = 0; i < n; i++) {
            if (!done[i] && (pivot < 0 || M[i][i] > M[pivot][pivot])) {
                pivot = i;
            }
        }
        if (pivot < 0) {
            return -1;
        }
        if (!(M[pivot][pivot] > 1e-12)) {
            return pivot;
        }
        done[pivot] = 1;
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < n && !done[i]; k++) {
                if (!done[k]) {
                    M[i][k] -= M[i][pivot] * M[pivot][k] / M[pivot][pivot];
                }
            }
        }
    }
}

static void check_mass_matrix(mech__reader *rd)
{
    const mechanism *m = rd->m;
    struct {
        pose at;
        double M[N][N], scale[N], q[N];
        char held[N];
    } *w = mech__alloc(rd, sizeof *w);
    uint32_t seed = 2463534242u;
    int joint = -1;

    if (!w) {
        return;
    }
    for (int i = 0; i < m->ninput; i++) {
        if (m->inputs[i].kind == STEIN_INPUT_MOTION && m->inputs[i].hold) {
            w->held[m->inputs[i].index] = 1;
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].ball == 1) {
            w->held[i] = 1;
        }
    }
    for (int t = 0; t < CONFIGURATIONS; t++) {
        memset(w->M, 0, sizeof w->M);
        memset(w->scale, 0, sizeof w->scale);
        for (int i = 0; i < m->nbody; i++) {
            seed = seed * 1664525u + 1013904223u;
            w->q[i] = ((double)seed / 4294967296.0 - 0.5) * (m->bodies[i].type == 'R' ? 5.0 : 0.7);
        }
        place(m, w->q, &w->at);
        for (int i = 0; i < m->nbody; i++) {
            add_body(m, &w->at, i, w->M, w->scale);
        }
        joint = lost_pivot(w->M, w->scale, w->held, m->nbody);
        if (joint < 0) {
            return;
        }
    }
    mech__problem_at(rd, rd->body_node[joint]->key,
                     "the joint %s has no inertia to move (the mass "
                     "matrix is singular), expected a mass or inertia on it or beyond it, or "
                     "joint: fixed",
                     m->bodies[joint].name);
}

void mech__check_inertia(mech__reader *rd, int body)
{
    const mech_body *b = &rd->m->bodies[body];
    const mech__node *node = mech__get(rd->body_node[body], "inertia");
    double v[3];

    if (mech__get(rd->body_node[body], "pendulum")) {
        node = mech__get(rd->body_node[body], "pendulum");
        if (b->inertia[1].kind == MECH_FORMULA && b->centre[0].value == 0.0 &&
            b->centre[2].value == 0.0) {
            mech__problem_at(rd, node,
                             "a pendulum test gives no inertia for a body with its centre on its "
                             "joint, expected inertia");
            return;
        }
    }
    mech__principal(b->inertia, v);
    double largest = fmax(v[0], fmax(v[1], v[2]));
    double smallest = fmin(v[0], fmin(v[1], v[2]));
    const mech__node *place = node ? node : rd->body_node[body];

    if (smallest < -1e-9 * fabs(largest)) {
        mech__problem_at(rd, place,
                         "the inertia of %s is not possible: a principal moment is "
                         "negative",
                         b->name);
    } else if (mech__violates_triangle(b->inertia)) {
        static const char *const told = "a principal moment exceeds the sum of the other two";

        if (rd->inertia == MECH__REFUSE) {
            mech__problem_at(rd, place,
                             "the inertia of %s is not possible: %s, expected another one, or "
                             "inertia: accept or balance for all bodies",
                             b->name, told);
        } else {
            mech__warn_at(rd, place, "the inertia of %s is accepted, though %s", b->name, told);
        }
    }
}

/** Lines need room between their ends, directions a length. */
static void check_extents(mech__reader *rd)
{
    const mechanism *m = rd->m;
    const mech__node *contacts = mech__get(rd->root, "contacts");
    const mech__node *inputs = mech__get(rd->root, "inputs");

    for (int i = 0; i < m->ncontact; i++) {
        const mech__node *place = mech__get(contacts, m->contacts[i].name);

        for (int k = 0; k < 2; k++) {
            const mech_shape *s = &m->contacts[i].spot[0].side[k];
            vec n = values(s->normal);

            if (s->solid == MECH_PLANE && s->normal[0].kind != MECH_ZERO && dot(n, n) == 0.0 &&
                !mech__failed(rd, m->contacts[i].name)) {
                mech__problem_at(rd, place ? place->key : NULL,
                                 "the normal of the plane of %s has no length",
                                 m->contacts[i].name);
            }
            if (s->has_extent && !mech__failed(rd, m->contacts[i].name) &&
                !(s->extent[0].value < s->extent[1].value)) {
                mech__problem_at(rd, place ? place->key : NULL,
                                 "an extent of the contact %s ends "
                                 "before it begins, expected [from, to] with from < to",
                                 m->contacts[i].name);
            }
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];

        if (b->limited && !mech__failed(rd, b->name) &&
            !(b->limit[STEIN_LIMIT_FROM].value < b->limit[STEIN_LIMIT_TO].value)) {
            mech__problem_at(rd, mech__get(rd->body_node[i], "limits"),
                             "the limits of %s end before they begin, expected [from, to] with "
                             "from < to",
                             b->name);
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        vec d = values(m->inputs[i].direction);
        const mech__node *place = mech__get(inputs, m->inputs[i].name);

        if (m->inputs[i].kind == STEIN_INPUT_POINT && dot(d, d) == 0.0 &&
            mech__get(place, "direction") && !mech__failed(rd, m->inputs[i].name)) {
            mech__problem_at(rd, place ? place->key : NULL, "the direction of %s has no length",
                             m->inputs[i].name);
        }
    }
}

void mech__checks(mech__reader *rd)
{
    if (rd->m->nbody == 0) {
        const mech__node *bodies = mech__get(rd->root, "bodies");

        if (bodies && bodies->kind == MECH__MAP && rd->nproblem == 0) {
            mech__problem_at(rd, bodies->key, "a mechanism needs at least one body");
        }
        return;
    }

    /* where a number is wrong already these would only repeat it */
    for (int i = 0; i < rd->m->nbody; i++) {
        if (!mech__failed(rd, rd->m->bodies[i].name)) {
            mech__check_inertia(rd, i);
        }
    }
    check_extents(rd);
    if (rd->nproblem == 0 && rd->m->nloop == 0) { /* loops may carry massless bodies */
        check_mass_matrix(rd);
    }
}
