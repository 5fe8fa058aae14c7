/* SPDX-License-Identifier: GPL-3.0-or-later
 * touch.c - the laws of joints, contacts and links, as docs/mechanism-files.md and law.h state
 * them.
 */
#include <math.h>

#include "world.h"

static const double felt_unit = 1e-4, turn_speed = 0.01; /* [m], [m/s] */

double law_friction(double A, double vt, double B1, double B2, double v)
{
    double u = v / vt;
    return A * (tanh(u) + B1 * u / (1.0 + B2 * u * u * u * u));
}

/* what is in no table */
static double outside(const double *p, double q, double qd)
{
    double f = 0.0;
    if (fabs(p[J_BUMP]) > 0.0) {
        double u = (q - p[J_BUMP_AT]) / p[J_BUMP_WIDTH];
        f += p[J_BUMP] * exp(-u * u);
    }
    if (fabs(p[J_COG]) > 0.0) {
        f += p[J_COG] * sin(q / p[J_COG_WAVE]);
    }
    if (fabs(p[J_ROOT]) > 0.0) {
        double u = qd / p[J_ROOT_W];
        f -= p[J_ROOT] * u / sqrt(0.01 + fabs(u));
    }
    return f;
}

double law_joint(const double *p, double q, double qd)
{
    double x = q - p[J_Q0], grip = tanh(qd / p[J_W]), over = fabs(q) - p[J_GAP];
    double f = p[J_PRELOAD] - p[J_K] * x - p[J_K3] * x * x * x;
    f -= p[J_B] * (1.0 + p[J_ASYMMETRY] * grip) * qd + p[J_DRAG] * fabs(qd) * qd;
    f -= p[J_T] * (1.0 + p[J_T_ASYMMETRY] * grip) * grip;
    if (p[J_A] > 0.0) {
        f -= law_friction(p[J_A], p[J_VT], p[J_B1], p[J_B2], qd);
    }
    if (p[J_STOP] > 0.0 && over > 0.0) {
        f -= p[J_STOP] * (q > 0.0 ? over : -over);
    }
    return f + outside(p, q, qd);
}

double law_normal(const double *p, double x, double xdot)
{
    if (x <= 0.0) {
        double u = p[N_RANGE] > 0.0 ? -x / p[N_RANGE] : 1.0;
        return u < 1.0 ? -4.0 * p[N_F] * u * (1.0 - u) : 0.0;
    }
    double f = ((p[N_A] * x + p[N_B]) * x + p[N_C]) * x;
    if (fabs(p[N_P]) > 0.0) {
        f *= pow(x / felt_unit, p[N_P]);
    }
    f = (f + p[N_F0]) * (1.0 + p[N_D] * xdot) * (1.0 + p[N_H] * tanh(xdot / turn_speed));
    return f > 0.0 ? f : 0.0;
}

/* ---- where two sides meet ---- */

typedef struct meeting {
    double x[3], n[3], depth; /* place of the contact, normal on side 0, deformation */
    int body[2];
} meeting;

static void planar(const play *s, const int at[2], double r[3])
{
    int full[3] = {at[0], -1, at[1]};
    motion_place(s, full, r);
}

static void meet(const play *s, const contact *c, meeting *w)
{
    double r[3], v[3], a[3], b[3];
    const point *first = &s->m->point[c->point[0]];
    double radius = c->radius[0] < 0 ? 0.0 : s->p[c->radius[0]];
    double reach = radius - s->p[c->law + N_GAP];
    motion_place(s, first->at, r);
    motion_point(s, first->body, r, a, v);
    w->body[0] = first->body;
    if (c->point[1] >= 0) {
        const point *second = &s->m->point[c->point[1]];
        motion_place(s, second->at, r);
        motion_point(s, second->body, r, b, v);
        w->body[1] = second->body;
        reach += c->radius[1] < 0 ? 0.0 : s->p[c->radius[1]];
        double d = hypot(a[0] - b[0], a[2] - b[2]);
        w->n[0] = (a[0] - b[0]) / d, w->n[2] = (a[2] - b[2]) / d;
    } else {
        double angle = s->p[c->facing], tip[3], origin[3], zero[3] = {0.0, 0.0, 0.0};
        planar(s, c->line_at, r);
        motion_point(s, c->line_body, r, b, v);
        double n[3] = {cos(angle), 0.0, sin(angle)};
        motion_point(s, c->line_body, n, tip, v);
        motion_point(s, c->line_body, zero, origin, v);
        w->body[1] = c->line_body;
        w->n[0] = tip[0] - origin[0], w->n[2] = tip[2] - origin[2];
    }
    w->n[1] = 0.0;
    w->depth = reach - (a[0] - b[0]) * w->n[0] - (a[2] - b[2]) * w->n[2];
    for (int i = 0; i < 3; i++) {
        w->x[i] = a[i] - radius * w->n[i];
    }
}

double touch_gap(play *s, int i)
{
    meeting w;
    meet(s, &s->m->contact[i], &w);
    return -w.depth;
}

/* velocity of the material point of a body that is at x now */
static void material(const play *s, int b, const double x[3], double v[3])
{
    v[0] = v[1] = v[2] = 0.0;
    if (b >= 0) {
        const pose *P = &s->pose[b];
        double r[3] = {x[0] - P->o[0], x[1] - P->o[1], x[2] - P->o[2]};
        v[0] = P->v[0] + P->w[1] * r[2] - P->w[2] * r[1];
        v[1] = P->v[1] + P->w[2] * r[0] - P->w[0] * r[2];
        v[2] = P->v[2] + P->w[0] * r[1] - P->w[1] * r[0];
    }
}

static void press(play *s, const contact *c)
{
    const double *p = s->p + c->law;
    meeting w;
    double v0[3], v1[3], f[3], back[3];
    meet(s, c, &w);
    if (w.depth <= -p[N_RANGE]) {
        return;
    }
    material(s, w.body[0], w.x, v0);
    material(s, w.body[1], w.x, v1);
    double tx = w.n[2], tz = -w.n[0], dx = v0[0] - v1[0], dz = v0[2] - v1[2];
    double rate = -(dx * w.n[0] + dz * w.n[2]), slide = dx * tx + dz * tz;
    double fn = law_normal(p, w.depth, rate), ft = 0.0;
    if (p[N_MU] > 0.0 && fn > 0.0) {
        ft = -fn * law_friction(p[N_MU], p[N_VT], p[N_B1], p[N_B2], slide);
    }
    f[0] = fn * w.n[0] + ft * tx, f[1] = 0.0, f[2] = fn * w.n[2] + ft * tz;
    for (int i = 0; i < 3; i++) {
        back[i] = -f[i];
    }
    motion_force(s, w.body[0], w.x, f);
    motion_force(s, w.body[1], w.x, back);
}

static void stretch(play *s, const link *l)
{
    const double *p = s->p + l->law;
    double x[2][3], v[2][3], r[3], e[3], length = 0.0, rate = 0.0;
    for (int k = 0; k < 2; k++) {
        const point *P = &s->m->point[l->point[k]];
        motion_place(s, P->at, r);
        motion_point(s, P->body, r, x[k], v[k]);
    }
    for (int i = 0; i < 3; i++) {
        e[i] = x[1][i] - x[0][i];
        length += e[i] * e[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++) {
        e[i] /= length;
        rate += e[i] * (v[1][i] - v[0][i]);
    }
    double f = p[L_K] * (length - p[L_LENGTH]) + p[L_B] * rate, pull[3], back[3];
    f *= f > 0.0 ? 1.0 - p[L_SLACK] : 1.0;
    for (int i = 0; i < 3; i++) {
        pull[i] = f * e[i];
        back[i] = -pull[i];
    }
    motion_force(s, s->m->point[l->point[0]].body, x[0], pull);
    motion_force(s, s->m->point[l->point[1]].body, x[1], back);
}

void touch_all(play *s)
{
    for (int i = 0; i < s->m->ncontact; i++) {
        press(s, &s->m->contact[i]);
    }
    for (int i = 0; i < s->m->nlink; i++) {
        stretch(s, &s->m->link[i]);
    }
}
