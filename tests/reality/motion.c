/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion.c - the equations of motion, by Newton, Euler and d'Alembert, for every segment by hand.
 *
 * Coordinates are absolute: phi_K, phi_H, phi_P the plane angles of key, hammer, pawl and z_L the
 * height of the load. (The file counts q_key = -phi_K, q_hammer = phi_H - phi_K, q_pawl = phi_P.)
 * With R(phi) a the rotated vector and a' = a turned by +90 degrees:
 *
 *   Kapsel            K = R(phi_K) k              Kdd = phi_K" R k' - phi_K'^2 R k
 *   hammer's centre   G = K + R(phi_H) c          Gdd = Kdd + phi_H" R c' - phi_H'^2 R c
 *
 *   hammer, Newton    m_H Gdd = X + F + m_H g           X: force of the Kapsel, F: contacts
 *   hammer, Euler     I_H phi_H" = M_G + (K - G) x X + tau
 *   key about its pin (I_K + m_K c_K^2) phi_K" = M_O + (R c_K) x m_K g - K x X - tau
 *   pawl about its hinge, the same with one angle;   load  m_L z_L" = N - m_L g
 *
 * Eliminating X gives two equations for phi_K", phi_H". D'Alembert's form does that at sight and
 * for any number of segments: a hinge force does no work in velocities the hinges allow, so for
 * every coordinate q_j, with G_i,j = dG_i/dq_j the velocity of centre i when q_j' = 1,
 *
 *   sum_i  G_i,j . (m_i Gdd_i - m_i g - F_i)  +  [phi_i is q_j] (I_i phi_i" - M_i)  = 0
 *
 *   =>  sum_k ( sum_i m_i G_i,j . G_i,k + I_i [j = k = phi_i] ) q_k"
 *          = sum_i G_i,j . (m_i g - m_i A_i) + P_i,j . F_i + [phi_i is q_j] M_i
 *
 * A_i: acceleration of centre i when no coordinate accelerates (the -phi'^2 terms); contact forces
 * are kept as F_i at the segment's origin P_i with moment M_i about it. Along a chain
 * P_child,j = P_parent,j + [phi_parent is q_j] R a',  A_child = A_parent - phi_parent'^2 R a.
 *
 * Hidden freedom enters as more segments and coordinates: the key's rear part, the hammer's head
 * part, the rise u of the key's pin (P_key = (0, u)), the string's height.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <string.h>

#include "reality.h"

static vec perp(vec a)
{
    return (vec){-a.z, a.x};
}

static void segment_at(segment *s, int dof, const instant *now)
{
    static const vec none = {0.0, 0.0};
    s->from = s->P = s->V = s->A = s->F = none;
    s->M = 0.0;
    s->nchain = 0;
    s->dof = dof;
    s->phi = now->q[dof];
    s->w = now->v[dof];
    s->c = cos(s->phi);
    s->s = sin(s->phi);
}

static void segment_on(segment *s, const segment *parent, vec at, int dof, const instant *now)
{
    vec r = seg_rotate(parent, vec_minus(at, parent->from));
    vec turned = perp(r);
    double w = parent->w;
    segment_at(s, dof, now);
    s->P = (vec){parent->P.x + r.x, parent->P.z + r.z};
    s->V = (vec){parent->V.x + w * turned.x, parent->V.z + w * turned.z};
    s->A = (vec){parent->A.x - w * w * r.x, parent->A.z - w * w * r.z};
    for (int i = 0; i < parent->nchain; i++) {
        s->chain[i] = parent->chain[i];
        s->J[i] = parent->J[i];
    }
    s->chain[parent->nchain] = parent->dof;
    s->J[parent->nchain] = turned;
    s->nchain = parent->nchain + 1;
}

static void place_segments(instant *now)
{
    const action *a = now->a;
    segment *seg = now->seg;
    segment_at(&seg[S_KEY], D_KEY, now);
    seg[S_KEY].P.z = now->q[D_PIN];
    seg[S_KEY].V.z = now->v[D_PIN];
    if (a->pin_k > 0.0) {
        seg[S_KEY].nchain = 1;
        seg[S_KEY].chain[0] = D_PIN;
        seg[S_KEY].J[0] = (vec){0.0, 1.0};
    }
    now->rear = a->key_split.on ? S_REAR : S_KEY;
    if (a->key_split.on) {
        segment_on(&seg[S_REAR], &seg[S_KEY], a->key_split.at, D_REAR, now);
        seg[S_REAR].from = a->key_split.at;
    }
    segment_on(&seg[S_HAMMER], &seg[now->rear], a->kapsel, D_HAMMER, now);
    now->head = a->hammer_split.on ? S_HEAD : S_HAMMER;
    if (a->hammer_split.on) {
        segment_on(&seg[S_HEAD], &seg[S_HAMMER], a->hammer_split.at, D_HEAD, now);
        seg[S_HEAD].from = a->hammer_split.at;
    }
    segment_at(&seg[S_PAWL], D_PAWL, now);
    seg[S_PAWL].P = a->pawl_hinge;
}

/* state vector -> coordinates, absent ones riding with what carries them; segments in place */
void motion_look(motion *mo, double t, const double *y, instant *now)
{
    now->a = mo->a;
    now->t = t;
    memset(now->q, 0, sizeof now->q);
    memset(now->v, 0, sizeof now->v);
    memset(now->b, 0, sizeof now->b);
    for (int i = 0; i < mo->n; i++) {
        now->q[mo->dof[i]] = y[i];
        now->v[mo->dof[i]] = y[mo->n + i];
    }
    memcpy(now->memory, y + 2 * mo->n, sizeof now->memory);
    if (mo->a->drive == 2 && mo->loaded) {
        double u[3];
        hidden_touch(t - mo->a->drive_delay, mo->a, u);
        now->q[D_KEY] = mo->key0 - mo->a->drive_gain * u[0];
        now->v[D_KEY] = -mo->a->drive_gain * u[1];
    }
    place_segments(now);
}

static void joint_torques(instant *now)
{
    const action *a = now->a;
    segment *key = &now->seg[S_KEY], *rear = &now->seg[now->rear];
    segment *hammer = &now->seg[S_HAMMER], *pawl = &now->seg[S_PAWL];
    double q[JOINTS] = {-key->phi, hammer->phi - rear->phi, pawl->phi};
    double w[JOINTS] = {-key->w, hammer->w - rear->w, pawl->w};
    double torque[JOINTS];
    for (int i = 0; i < JOINTS; i++) {
        const hinge *h = &a->joint[i];
        torque[i] = -h->k * (q[i] - h->theta0) - rub_law(&h->friction, w[i]) +
                    hidden_torque(h, q[i], w[i], i == JOINT_KEY ? now->memory[HEAT] : 0.0);
    }
    key->M -= torque[JOINT_KEY];
    hammer->M += torque[JOINT_HAMMER];
    rear->M -= torque[JOINT_HAMMER];
    pawl->M += torque[JOINT_PAWL];
}

/* one rigid piece into M (lower half, packed) and b: only the coordinates that move it */
static void add_piece(const motion *mo, instant *now, int i, const piece *part,
                      double M[DOFS][DOFS])
{
    segment *s = &now->seg[i];
    vec r = seg_rotate(s, vec_minus(part->c, s->from)), J[MAX_CHAIN + 1];
    int n = s->nchain, dof[MAX_CHAIN + 1];
    for (int j = 0; j < n; j++) {
        dof[j] = s->chain[j];
        J[j] = s->J[j];
    }
    dof[n] = s->dof;
    J[n] = perp(r);
    vec f = {-part->m * (s->A.x - s->w * s->w * r.x),
             -part->m * (s->A.z - s->w * s->w * r.z) - part->m * now->a->g};
    for (int j = 0; j <= n; j++) {
        int row = mo->index[dof[j]];
        now->b[dof[j]] += vec_dot(J[j], f);
        for (int k = 0; k <= j; k++) {
            int col = mo->index[dof[k]];
            double *to = row >= col ? &M[row][col] : &M[col][row];
            *to += part->m * vec_dot(J[j], J[k]);
        }
    }
    M[mo->index[s->dof]][mo->index[s->dof]] += part->I;
}

static void add_body(const motion *mo, instant *now, int inner, int outer, const split *s,
                     double M[DOFS][DOFS])
{
    const piece *whole = &now->a->body[inner == S_KEY ? JOINT_KEY : JOINT_HAMMER];
    if (!s->on) {
        add_piece(mo, now, inner, whole, M);
        return;
    }
    piece rest = piece_rest(*whole, s->outer);
    add_piece(mo, now, inner, &rest, M);
    add_piece(mo, now, outer, &s->outer, M);
}

/* M (lower half) and b of the coordinates that are there, packed */
static void gather(const motion *mo, instant *now, double M[DOFS][DOFS], double *x)
{
    const action *a = now->a;
    int load = mo->index[D_LOAD], string = mo->index[D_STRING];
    memset(M, 0, sizeof(double[DOFS]) * (size_t)mo->n);
    add_body(mo, now, S_KEY, S_REAR, &a->key_split, M);
    add_body(mo, now, S_HAMMER, S_HEAD, &a->hammer_split, M);
    add_piece(mo, now, S_PAWL, &a->body[JOINT_PAWL], M);
    M[load][load] = a->load_mass;
    now->b[D_LOAD] -= a->load_mass * a->g;
    if (string >= 0) {
        M[string][string] = a->string_m;
    }
    for (int i = 0; i < SEGMENTS; i++) {
        const segment *s = &now->seg[i];
        if ((i == S_REAR && !a->key_split.on) || (i == S_HEAD && !a->hammer_split.on)) {
            continue;
        }
        for (int j = 0; j < s->nchain; j++) {
            now->b[s->chain[j]] += vec_dot(s->J[j], s->F);
        }
        now->b[s->dof] += s->M;
    }
    for (int i = 0; i < mo->n; i++) {
        x[i] = now->b[mo->dof[i]];
    }
}

/* x = M^-1 b by L D L' in place, n at most 8; most parts do not move each other: zeros are skipped
 */
static int solve(int n, double M[DOFS][DOFS], double *b)
{
    double inverse[DOFS];
    for (int k = 0; k < n; k++) {
        if (!(M[k][k] > 0.0)) {
            return -1;
        }
        inverse[k] = 1.0 / M[k][k];
        for (int i = n - 1; i > k; i--) {
            if (!(fabs(M[i][k]) > 0.0)) {
                continue;
            }
            double l = M[i][k] * inverse[k];
            for (int j = k + 1; j <= i; j++) {
                M[i][j] -= l * M[j][k];
            }
            M[i][k] = l;
            b[i] -= l * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        b[i] *= inverse[i];
        for (int j = i + 1; j < n; j++) {
            b[i] -= M[j][i] * b[j];
        }
    }
    return 0;
}

/* the prescribed key leaves the unknowns: its row becomes acc = given */
static void prescribe(const motion *mo, int n, double P[DOFS][DOFS], double *x, double t)
{
    double u[3];
    int key = mo->index[D_KEY];
    hidden_touch(t - mo->a->drive_delay, mo->a, u);
    double given = -mo->a->drive_gain * u[2];
    for (int i = 0; i < n; i++) {
        double *to = i > key ? &P[i][key] : &P[key][i];
        if (i != key) {
            x[i] -= *to * given;
            *to = 0.0;
        }
    }
    P[key][key] = 1.0;
    x[key] = given;
}

void motion_guards(motion *mo, double t, const double *y, instant *now)
{
    motion_look(mo, t, y, now);
    touch_all(now, mo->mode);
    hidden_forces(now, mo->mode);
}

int motion_rates(motion *mo, double t, const double *y, double *dydt, instant *now)
{
    double M[DOFS][DOFS], x[DOFS];
    int n = mo->n;
    mo->evaluations++;
    motion_guards(mo, t, y, now);
    joint_torques(now);
    if (mo->a->drive == 1) {
        double u[3];
        hidden_touch(t - mo->a->drive_delay, mo->a, u);
        vec down = {0.0, -mo->a->drive_gain * u[0]};
        seg_push(&now->seg[S_KEY], seg_place(&now->seg[S_KEY], mo->a->front), down);
    }
    gather(mo, now, M, x);
    if (mo->a->drive == 2 && mo->loaded) {
        prescribe(mo, n, M, x, t);
    }
    if (solve(n, M, x) != 0) {
        return GSL_EBADFUNC;
    }
    for (int i = 0; i < n; i++) {
        dydt[i] = now->v[mo->dof[i]];
        dydt[n + i] = x[i];
        if (!isfinite(x[i])) {
            return GSL_EBADFUNC;
        }
    }
    memcpy(dydt + 2 * n, now->memory_rate, sizeof now->memory_rate);
    return GSL_SUCCESS;
}

void motion_init(motion *mo, const action *a)
{
    int there[DOFS] = {
        1, 1, 1, 1, a->key_split.on, a->hammer_split.on, a->pin_k > 0.0, a->string_k > 0.0};
    memset(mo, 0, sizeof *mo);
    mo->a = a;
    for (int i = 0; i < DOFS; i++) {
        mo->index[i] = -1;
        if (there[i]) {
            mo->index[i] = mo->n;
            mo->dof[mo->n++] = i;
        }
    }
}

/* what ideal instruments read, and the rates */
void motion_read(const motion *mo, const instant *now, double *y, double *yd)
{
    const action *a = mo->a;
    const segment *key = &now->seg[S_KEY], *head = &now->seg[now->head];
    vec front = seg_place(key, a->front), top = seg_place(head, a->head);
    vec vf = seg_velocity(key, front), vh = seg_velocity(head, top);
    y[C_STRING] = a->string_at.z + now->q[D_STRING] - top.z;
    yd[C_STRING] = now->v[D_STRING] - vh.z;
    y[C_DIP] = mo->front0 - front.z;
    yd[C_DIP] = -vf.z;
    y[C_HAMMER] = now->seg[S_HAMMER].phi - now->seg[now->rear].phi;
    yd[C_HAMMER] = now->seg[S_HAMMER].w - now->seg[now->rear].w;
    y[C_HEAD_X] = top.x;
    yd[C_HEAD_X] = vh.x;
    y[C_FRONT_X] = front.x;
    yd[C_FRONT_X] = vf.x;
}
