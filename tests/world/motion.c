/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion.c - equations of motion: Newton-Euler in the fixed frame, projected on the joints.
 *
 * With the linear and angular velocities of body i written as v_i = sum_j Jv_ij qd_j and
 * w_i = sum_j Jw_ij qd_j, and its accelerations at qdd = 0 as a_i, alpha_i,
 *
 *      M_jk = sum_i m_i Jv_ij . Jv_ik + Jw_ij . I_i Jw_ik
 *      h_j  = sum_i m_i Jv_ij . (a_i - g) + Jw_ij . (I_i alpha_i + w_i x I_i w_i)
 *      M qdd + h = Q
 *
 * The columns of a turning joint between the frame and the body are Jw = e, Jv = e x (c - o), of a
 * sliding one Jw = 0, Jv = e; e is the joint's axis, o its place, c the body's centre.
 */
#include <math.h>
#include <string.h>

#include "world.h"

static void cross(const double a[3], const double b[3], double c[3])
{
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
    c[0] = x, c[1] = y;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void turned(const double R[9], const double a[3], double b[3])
{
    double r[3] = {dot(R, a), dot(R + 3, a), dot(R + 6, a)};
    memcpy(b, r, sizeof r);
}

void motion_place(const play *s, const int at[3], double r[3])
{
    for (int i = 0; i < 3; i++) {
        r[i] = at[i] < 0 ? 0.0 : s->p[at[i]];
    }
}

/* rotation about axis k by an angle: R times it */
static void spin(const double R[9], int k, double angle, double out[9])
{
    int i = (k + 1) % 3, j = (k + 2) % 3;
    double c = cos(angle), n = sin(angle);
    for (int row = 0; row < 3; row++) {
        const double *r = R + 3 * row;
        out[3 * row + k] = r[k];
        out[3 * row + i] = c * r[i] + n * r[j];
        out[3 * row + j] = c * r[j] - n * r[i];
    }
}

static const pose still = {.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};

/* velocity and acceleration of a place r away from the origin of a pose, moving with it */
static void carried(const pose *P, const double r[3], double v[3], double a[3])
{
    double wr[3], wwr[3], ar[3];
    cross(P->w, r, wr);
    cross(P->w, wr, wwr);
    cross(P->alpha, r, ar);
    for (int i = 0; i < 3; i++) {
        v[i] = P->v[i] + wr[i];
        a[i] = P->a[i] + ar[i] + wwr[i];
    }
}

void motion_poses(play *s, const double *q, const double *qd)
{
    for (int i = 0; i < s->m->nbody; i++) {
        int b = s->m->order[i];
        const body *B = &s->m->body[b];
        const pose *P = B->parent < 0 ? &still : &s->pose[B->parent];
        pose *N = &s->pose[b];
        double e[3] = {0.0, 0.0, 0.0}, r[3], rate[3], wx[3];
        e[B->axis] = B->sign;
        motion_place(s, B->at, r);
        if (B->type == 'T') {
            r[B->axis] += B->sign * q[b];
        }
        turned(P->R, e, s->axis[b]);
        turned(P->R, r, r);
        carried(P, r, N->v, N->a);
        for (int k = 0; k < 3; k++) {
            N->o[k] = P->o[k] + r[k];
            rate[k] = s->axis[b][k] * qd[b];
        }
        cross(P->w, rate, wx);
        memcpy(N->w, P->w, sizeof N->w);
        memcpy(N->alpha, P->alpha, sizeof N->alpha);
        memcpy(N->R, P->R, sizeof N->R);
        if (B->type == 'R') {
            spin(P->R, B->axis, B->sign * q[b], N->R);
        }
        for (int k = 0; k < 3; k++) {
            if (B->type == 'R') {
                N->w[k] += rate[k];
                N->alpha[k] += wx[k];
            } else {
                N->v[k] += rate[k];
                N->a[k] += 2.0 * wx[k];
            }
        }
    }
}

void motion_point(const play *s, int b, const double r[3], double x[3], double v[3])
{
    const pose *P = b < 0 ? &still : &s->pose[b];
    double a[3], arm[3];
    turned(P->R, r, arm);
    carried(P, arm, v, a);
    for (int i = 0; i < 3; i++) {
        x[i] = P->o[i] + arm[i];
    }
}

void motion_force(play *s, int b, const double x[3], const double f[3])
{
    for (; b >= 0; b = s->m->body[b].parent) {
        double arm[3], moment[3];
        for (int i = 0; i < 3; i++) {
            arm[i] = x[i] - s->pose[b].o[i];
        }
        cross(arm, f, moment);
        s->Q[b] += dot(s->axis[b], s->m->body[b].type == 'R' ? moment : f);
    }
}

/* inertia about the centre, in the fixed frame, times a vector */
static void inertia(const play *s, int b, const double a[3], double out[3])
{
    const pose *P = &s->pose[b];
    double I[3], own[3];
    motion_place(s, s->m->body[b].inertia, I);
    for (int i = 0; i < 3; i++) {
        own[i] = I[i] * (P->R[i] * a[0] + P->R[3 + i] * a[1] + P->R[6 + i] * a[2]);
    }
    turned(P->R, own, out);
}

static void add_body(play *s, int b)
{
    const body *B = &s->m->body[b];
    const pose *P = &s->pose[b];
    int n = s->m->nbody, chain[BODIES], k = 0;
    double r[3], v[3], a[3], Jv[BODIES][3], Jw[BODIES][3], Iw[3], wIw[3], Ia[3];
    double mass = B->mass < 0 ? 0.0 : s->p[B->mass];
    motion_place(s, B->centre, r);
    turned(P->R, r, r);
    carried(P, r, v, a);
    for (int j = b; j >= 0; j = s->m->body[j].parent) {
        double arm[3];
        for (int i = 0; i < 3; i++) {
            arm[i] = P->o[i] + r[i] - s->pose[j].o[i];
            Jw[k][i] = s->m->body[j].type == 'R' ? s->axis[j][i] : 0.0;
            Jv[k][i] = s->axis[j][i];
        }
        if (s->m->body[j].type == 'R') {
            cross(s->axis[j], arm, Jv[k]);
        }
        chain[k++] = j;
    }
    inertia(s, b, P->w, Iw);
    cross(P->w, Iw, wIw);
    inertia(s, b, P->alpha, Ia);
    for (int i = 0; i < 3; i++) {
        a[i] = mass * (a[i] - s->m->gravity[i]);
        Ia[i] += wIw[i];
    }
    for (int i = 0; i < k; i++) {
        double IJ[3];
        inertia(s, b, Jw[i], IJ);
        s->h[chain[i]] += dot(Jv[i], a) + dot(Jw[i], Ia);
        for (int j = 0; j < k; j++) {
            s->M[chain[i] * n + chain[j]] += mass * dot(Jv[i], Jv[j]) + dot(Jw[j], IJ);
        }
    }
}

/* ---- what drives ---- */

static double smooth(const signal *s, double t)
{
    double y = s->level;
    for (int i = 0; i < s->n; i++) {
        y += s->amplitude[i] * sin(s->rate[i] * t + s->phase[i]);
    }
    if (t > s->from && t < s->to) {
        y += s->push * 0.5 * (1.0 - cos(6.283185307179586 * (t - s->from) / (s->to - s->from)));
    }
    return y;
}

/* sample k of a grid */
static double sampled(const signal *s, double k)
{
    chance c;
    double y = smooth(s, k * s->interval);
    if (s->noise > 0.0) {
        chance_seed(&c, s->draw + (unsigned long long)(long long)k);
        y += s->noise * chance_normal(&c);
    }
    return y;
}

double signal_value(const signal *s, double t)
{
    if (!s->grid) {
        return smooth(s, t);
    }
    double k = floor(t / s->interval), u = t / s->interval - k;
    return (1.0 - u) * sampled(s, k) + u * sampled(s, k + 1.0);
}

static void motion_of(const signal *s, double t, double y[3])
{
    y[0] = smooth(s, t), y[1] = y[2] = 0.0;
    for (int i = 0; i < s->n; i++) {
        double w = s->rate[i], x = w * t + s->phase[i];
        y[1] += s->amplitude[i] * w * cos(x);
        y[2] -= s->amplitude[i] * w * w * sin(x);
    }
}

/* prescribed joints: given[j], their acceleration in qdd */
static void prescribe(const play *s, double t, double *q, double *qd, double *qdd, int *given)
{
    for (int i = 0; i < s->m->ninput && s->drive != NULL; i++) {
        const input *in = &s->m->input[i];
        double y[3], gain = s->p[in->law + I_GAIN];
        if (in->kind == INPUT_MOTION) {
            motion_of(&s->drive[i], t - s->p[in->law + I_DELAY], y);
            q[in->body] = gain * y[0], qd[in->body] = gain * y[1], qdd[in->body] = gain * y[2];
            given[in->body] = 1;
        }
    }
}

static void push(play *s, double t)
{
    for (int i = 0; i < s->m->ninput && s->drive != NULL; i++) {
        const input *in = &s->m->input[i];
        double u = s->p[in->law + I_GAIN] * signal_value(&s->drive[i], t - s->p[in->law + I_DELAY]);
        if (in->kind == INPUT_TORQUE) {
            s->Q[in->body] += u;
        } else if (in->kind == INPUT_FORCE) {
            double r[3], x[3], v[3], f[3] = {0.0, 0.0, -u};
            motion_place(s, s->m->point[in->point].at, r);
            motion_point(s, in->body, r, x, v);
            motion_force(s, in->body, x, f);
        }
    }
}

/* A x = b of n <= BODIES by Gauss with pivots. @return 0, -1: singular */
static int solve(int n, double *A, double *b)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++) {
            best = fabs(A[i * n + k]) > fabs(A[best * n + k]) ? i : best;
        }
        if (!(fabs(A[best * n + k]) > 0.0)) {
            return -1;
        }
        for (int j = 0; j < n && best != k; j++) {
            double other = A[k * n + j];
            A[k * n + j] = A[best * n + j], A[best * n + j] = other;
        }
        double other = b[k];
        b[k] = b[best], b[best] = other;
        for (int i = k + 1; i < n; i++) {
            double f = A[i * n + k] / A[k * n + k];
            for (int j = k; j < n; j++) {
                A[i * n + j] -= f * A[k * n + j];
            }
            b[i] -= f * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            b[i] -= A[i * n + j] * b[j];
        }
        b[i] /= A[i * n + i];
    }
    return 0;
}

int motion_rates(play *s, double t, double *q, double *qd, double *qdd)
{
    int n = s->m->nbody, given[BODIES] = {0};
    double A[BODIES * BODIES], b[BODIES];
    prescribe(s, t, q, qd, qdd, given);
    memset(s->M, 0, sizeof s->M);
    memset(s->h, 0, sizeof s->h);
    memset(s->Q, 0, sizeof s->Q);
    motion_poses(s, q, qd);
    for (int i = 0; i < n; i++) {
        add_body(s, i);
        s->Q[i] += law_joint(s->p + s->m->body[i].law, q[i], qd[i]);
    }
    touch_all(s);
    push(s, t);
    for (int i = 0; i < n; i++) {
        b[i] = given[i] ? qdd[i] : s->Q[i] - s->h[i] - s->calm * s->M[i * n + i] * qd[i];
        for (int j = 0; j < n; j++) {
            A[i * n + j] = given[i] ? (double)(i == j) : s->M[i * n + j];
        }
    }
    if (solve(n, A, b) != 0) {
        return -1;
    }
    for (int i = 0; i < n; i++) {
        s->effort[i] = s->h[i] - s->Q[i];
        qdd[i] = b[i];
        for (int j = 0; j < n; j++) {
            s->effort[i] += s->M[i * n + j] * b[j];
        }
    }
    return 0;
}
