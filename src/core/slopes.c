/* SPDX-License-Identifier: MIT
 * slopes.c - derivatives by every q and qd of the forces of what touches and rubs, all at once.
 *
 * In the plane a joint is a twist S = (w, u, v): a point P of what it carries moves by
 * (u - w P_z, v + w P_x) for each unit of its coordinate. A contact with unit normal n and tangent t
 * at P is a wrench W = f_n (P x n, n) + f_t (P x t, t), and acts on the joints between its two bodies
 * only: Q_k = s_k S_k . W, s = +1 on the way to the first body, -1 to the second. So
 *
 *      dQ_k/dq_j = s_k ( S_k . dW/dq_j + [S_j, S_k] . W )     [S_j, S_k] where j carries joint k
 *      dW/dq_j   = df_n N + df_t T + f_n dN + f_t dT          N, T the wrenches of unit forces
 *      depth     dx/dq_j = - s_j S_j . N                      both rates by S_j, V, [S_j, V - V_j]
 *
 * Joints below both bodies move all of it rigidly, and nothing changes. What the laws add are four
 * numbers for a contact, their own slopes (tangent.c).
 *
 * A sweep along every q and qd would give the same, and the tests compare the two; it takes 2 nq
 * evaluations of all forces, this one less than two.
 */
#include "slopes.h"

typedef stein__twist twist;

static inline vec2 moved(twist s, vec2 at)
{
    return (vec2){s.u - s.w * at.z, s.v + s.w * at.x};
}

/* [a, b]: how b changes when it is moved with a */
static inline twist bracket(twist a, twist b)
{
    return (twist){0.0, b.w * a.v - a.w * b.v, a.w * b.u - b.w * a.u};
}

static inline twist minus(twist a, twist b)
{
    return (twist){a.w - b.w, a.u - b.u, a.v - b.v};
}

static inline double power(wrench f, twist s)
{
    return f.m * s.w + f.x * s.u + f.z * s.v;
}

/* a unit force along n at a place, about the origin of the fixed frame */
static inline wrench unit(vec2 at, vec2 n)
{
    return (wrench){n.x, n.z, at.x * n.z - at.z * n.x};
}

/* how it changes with the place and the direction */
static inline wrench unit_moved(vec2 at, vec2 n, vec2 dat, vec2 dn)
{
    return (wrench){dn.x, dn.z, dat.x * n.z - dat.z * n.x + at.x * dn.z - at.z * dn.x};
}

static inline wrench sum_of(double a, wrench x, double b, wrench y)
{
    return (wrench){a * x.x + b * y.x, a * x.z + b * y.z, a * x.m + b * y.m};
}

/* ---- the joints ---- */

/* S and V of all bodies that have a pose */
static void find_twists(stein_derivative *s)
{
    const stein_model *model = s->model;
    for (int i = 0; i < model->nframe; i++) {
        const stein_pose *p = &s->sim->pose[i];
        int j = model->frames[i].body;
        const stein_body *body = &model->bodies[j];
        double sign = body->sign;
        s->V[j] = (twist){p->w, p->vx + p->w * p->z, p->vz - p->w * p->x};
        s->S[j] = body->type == 'R'   ? (twist){-sign, -sign * p->z, sign * p->x}
                  : body->axis == 'x' ? (twist){0.0, sign * p->c, sign * p->s}
                                      : (twist){0.0, -sign * p->s, sign * p->c};
    }
}

static int body_of(const stein_derivative *s, int frame)
{
    return frame < 0 ? -1 : s->model->frames[frame].body;
}

/* joints between the two bodies of a pair, and on which side: from the leaves on */
static int find_way(stein_derivative *s, const pair *p)
{
    int a = body_of(s, p->frame[0]), b = body_of(s, p->frame[1]), n = 0;
    while (a != b) {
        int first = a > b;
        s->way[n] = first ? a : b;
        s->side[n++] = first ? 1.0 : -1.0;
        *(first ? &a : &b) = s->parent[first ? a : b];
    }
    return n;
}

/* ---- one contact ---- */

/* which body carries the normal; between two circles it turns with the line of their centres */
typedef enum { OF_FIRST, OF_SECOND, BETWEEN } carrier;

/* one touch with the slopes of its laws */
typedef struct contact {
    vec2 at, n, t, centre; /* centre: of the circle, or the point on the line */
    double radius, distance;
    carrier carrier;
    twist V; /* of the first body less that of the second */
    wrench N, T, W;
    double fn, ft, mu;
    double by_depth, by_rate; /* of fn */
    double by_speed;          /* of mu, by v_t */
} contact;

/* how place and normal move with a joint */
static inline void move(const contact *c, twist S, double side, vec2 *dat, vec2 *dn)
{
    int first = side > 0.0;
    vec2 dcentre = {0.0, 0.0};
    *dn = dcentre;
    if (c->carrier == BETWEEN) {
        vec2 other = {c->centre.x - c->distance * c->n.x, c->centre.z - c->distance * c->n.z};
        vec2 by = moved(S, first ? c->centre : other);
        double turned =
            c->distance > 0.0 ? side * (c->t.x * by.x + c->t.z * by.z) / c->distance : 0.0;
        *dn = (vec2){turned * c->t.x, turned * c->t.z};
        dcentre = first ? by : dcentre;
    } else if (first == (c->carrier == OF_FIRST)) {
        *dn = (vec2){-S.w * c->n.z, S.w * c->n.x};
    } else {
        dcentre = moved(S, c->centre);
    }
    *dat = (vec2){dcentre.x - c->radius * dn->x, dcentre.z - c->radius * dn->z};
}

/* how the whole wrench moves with joint j of the way */
static inline wrench wrench_by_q(const stein_derivative *s, const contact *c, const pair *p, int j)
{
    int joint = s->way[j];
    double side = s->side[j];
    twist S = s->S[joint];
    twist V = minus(s->V[body_of(s, p->frame[side < 0.0])], s->V[joint]), dV = bracket(S, V);
    vec2 dat, dn;
    move(c, S, side, &dat, &dn);
    wrench dN = unit_moved(c->at, c->n, dat, dn);
    wrench dT = unit_moved(c->at, c->t, dat, (vec2){dn.z, -dn.x});
    double drate = -(power(dN, c->V) + side * power(c->N, dV));
    double dspeed = power(dT, c->V) + side * power(c->T, dV);
    double dfn = c->by_rate * drate - c->by_depth * s->along_n[j];
    double dft = c->fn > 0.0 ? -(dfn * c->mu + c->fn * c->by_speed * dspeed) : 0.0;
    wrench forces = sum_of(dfn, c->N, dft, c->T), places = sum_of(c->fn, dN, c->ft, dT);
    return sum_of(1.0, forces, 1.0, places);
}

static void add_contact(stein_derivative *s, const contact *c, const pair *p, double *Qq,
                        double *Qqd)
{
    int nq = s->model->nq, n = find_way(s, p);
    for (int k = 0; k < n; k++) {
        s->along_n[k] = s->side[k] * power(c->N, s->S[s->way[k]]);
        s->along_t[k] = s->side[k] * power(c->T, s->S[s->way[k]]);
    }
    for (int j = 0; j < n; j++) {
        int joint = s->way[j];
        wrench dW = wrench_by_q(s, c, p, j);
        double dfn = -c->by_rate * s->along_n[j];
        double dft =
            c->fn > 0.0 ? -(dfn * c->mu + c->fn * c->by_speed * s->along_t[j]) : 0.0;
        for (int k = 0; k < n; k++) {
            int row = s->way[k];
            double change = power(dW, s->S[row]);
            if (joint < row && s->side[j] == s->side[k]) { // it carries that joint
                change += power(c->W, bracket(s->S[joint], s->S[row]));
            }
            Qq[row * nq + joint] += s->side[k] * change;
            Qqd[row * nq + joint] += dfn * s->along_n[k] + dft * s->along_t[k];
        }
    }
}

/* touch i of the last evaluation */
static void add_touch(stein_derivative *s, int i, carrier by, double radius, double distance,
                      double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    const touch *k = &sim->touch[i];
    const pair *p = k->pair;
    const twist fixed = {0.0, 0.0, 0.0};
    contact c = {.at = k->at,
                 .n = k->n,
                 .t = {k->n.z, -k->n.x},
                 .radius = radius,
                 .distance = distance,
                 .carrier = by,
                 .fn = k->normal};
    int a = body_of(s, p->frame[0]), b = body_of(s, p->frame[1]);
    c.centre = (vec2){c.at.x + radius * c.n.x, c.at.z + radius * c.n.z};
    c.V = minus(a < 0 ? fixed : s->V[a], b < 0 ? fixed : s->V[b]);
    c.N = unit(c.at, c.n);
    c.T = unit(c.at, c.t);
    stein__normal_slopes(p->normal, k->depth, k->rate, &c.by_depth, &c.by_rate);
    c.mu = stein__mu(p->friction, sim->slip[i], sim->grip[i]);
    c.by_speed = p->inverse_vt * stein__mu_slope(p->friction, sim->slip[i], sim->grip[i]);
    c.ft = c.fn > 0.0 ? -c.fn * c.mu : 0.0;
    c.W = sum_of(c.fn, c.N, c.ft, c.T);
    add_contact(s, &c, p, Qq, Qqd);
}

/* ---- all of them ---- */

static int add_spots(stein_derivative *s, double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    int i = 0;
    for (int k = 0; k < s->model->nspot; k++) {
        const site *at = &sim->site[k];
        if (sim->mode[k]) {
            double reach = at->a[STEIN_SHAPE_R] + at->b[STEIN_SHAPE_R];
            double distance = reach - at->pair.normal[STEIN_NORMAL_GAP] - sim->touch[i].depth;
            add_touch(s, i++, at->line ? OF_SECOND : BETWEEN, at->a[STEIN_SHAPE_R], distance, Qq,
                      Qqd);
        }
    }
    return i;
}

/* tip and face are lines of the catcher, at the corner it is the beak's */
static void add_notches(stein_derivative *s, int i, double *Qq, double *Qqd)
{
    static const carrier by[NOTCH_REGION] = {
        [NOTCH_TIP] = OF_SECOND, [NOTCH_CORNER] = OF_FIRST, [NOTCH_FACE] = OF_SECOND};
    const unsigned char *mode = s->sim->mode + s->model->nspot;
    for (int k = 0; k < s->model->nnotch; k++, mode += NOTCH_GUARDS) {
        for (int place = 0; place < NOTCH_REGION; place++) {
            if (mode[place]) {
                add_touch(s, i++, by[place], 0.0, 0.0, Qq, Qqd);
            }
        }
    }
}

static void add_joints(stein_derivative *s, double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    int nq = s->model->nq;
    for (int k = 0; k < sim->nacting; k++) {
        int j = sim->acting[k], at = sim->ntouch + k;
        const double *law = sim->d + s->model->bodies[j].joint;
        double by_q, by_qd, grips = sim->inverse_vt[j];
        if (grips != 0.0) {
            grips *= stein__mu_slope(law + STEIN_JOINT_FRICTION, sim->slip[at], sim->grip[at]);
        }
        stein__joint_slopes(law, sim->xq[j], sim->xqd[j], grips, &by_q, &by_qd);
        Qq[j * nq + j] += by_q;
        Qqd[j * nq + j] += by_qd;
    }
}

int stein__touch_slopes(stein_derivative *s, double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    int n = s->model->nq;
    if (s->model->nlink > 0 || sim->ntable_on > 0 || sim->signals) {
        return 0;
    }
    memset(Qq, 0, sizeof *Qq * (size_t)(n * n));
    memset(Qqd, 0, sizeof *Qqd * (size_t)(n * n));
    find_twists(s);
    add_notches(s, add_spots(s, Qq, Qqd), Qq, Qqd);
    add_joints(s, Qq, Qqd);
    return 1;
}
