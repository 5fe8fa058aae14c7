/* SPDX-License-Identifier: MIT
 * slopes.c - derivatives by every q and qd of the forces of what touches and rubs, all at once.
 *
 * In the plane a joint is a twist. For each unit of its coordinate, what it carries turns by w. At
 * the place of a contact it moves by a along the contact's normal n and by b along its tangent t
 * (n turned by -90 degrees). A contact with forces f_n and f_t acts on the joints between its two
 * bodies only, s = +1 on the way to the first body, -1 to the second:
 *
 *      Q_k = s_k (f_n a_k + f_t b_k)      depth: dx/dq_k = - s_k a_k      dv_t/dqd_k = s_k b_k
 *
 * When q_j changes, the place moves by (p_n, p_t), n turns by th, and joint k, if j carries it, is
 * moved with it, [S_j, S_k]. Then in those axes
 *
 *      dQ_k/dq_j = s_k ( w_k (f_n p_t - f_t p_n) + a_k (df_n + f_t th) + b_k (df_t - f_n th)
 *                        + f_n [S_j, S_k]_n + f_t [S_j, S_k]_t )
 *      [S_j, S_k]_n = w_j b_k - w_k b_j      [S_j, S_k]_t = w_k a_j - w_j a_k
 *
 * Joints below both bodies move all of it rigidly, and nothing changes. What the laws add are three
 * numbers for a contact, their own slopes (tangent.c).
 *
 * A sweep along every q and qd gives the same, and the tests compare the two; it takes 2 nq
 * evaluations of all forces with their derivatives.
 */
#include "slopes.h"

typedef stein__twist twist;

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

static inline int body_of(const stein_derivative *s, int frame)
{
    return frame < 0 ? -1 : s->model->frames[frame].body;
}

/* ---- one contact ---- */

/* which body carries the normal; between two circles it turns with the line of their centres */
typedef enum { OF_SECOND, BETWEEN } carrier;

/* one touch with the slopes of its laws */
typedef struct contact {
    vec2 at, n;
    double at_n, at_t;       /* moments of unit forces along n and t about the frame's origin */
    double radius, distance; /* of the first circle; between the centres */
    carrier carrier;
    stein__local V; /* of the first body less that of the second */
    double fn, ft, mu;
    double by_depth, by_rate; /* of fn */
    double by_speed;          /* of mu, by v_t */
} contact;

/* a twist at the place, in the axes of the contact */
static inline stein__local local(const contact *c, twist s)
{
    return (stein__local){s.w, s.u * c->n.x + s.v * c->n.z + s.w * c->at_n,
                          s.u * c->n.z - s.v * c->n.x + s.w * c->at_t};
}

/* a body less another one, of which -1 is fixed */
static inline stein__local relative(const stein_derivative *s, const contact *c, int a, int b)
{
    const twist fixed = {0.0, 0.0, 0.0};
    twist x = a < 0 ? fixed : s->V[a], y = b < 0 ? fixed : s->V[b];
    return local(c, (twist){x.w - y.w, x.u - y.u, x.v - y.v});
}

/* joints between the two bodies of a pair, from the leaves on */
static int find_way(stein_derivative *s, const contact *c, int a, int b)
{
    int n = 0;
    for (; a != b; n++) {
        int first = a > b, joint = first ? a : b;
        s->way[n] = (stein__step){.joint = joint, .first = first, .at = local(c, s->S[joint])};
        a = first ? s->parent[a] : a;
        b = first ? b : s->parent[b];
    }
    return n;
}

/* how place and normal move with a joint */
static inline void move(const contact *c, const stein__step *j, double *pn, double *pt, double *th)
{
    double w = j->at.w, r = c->radius;
    *pn = *pt = *th = 0.0;
    if (c->carrier == BETWEEN) {
        double across = j->first ? r * w - j->at.b : (c->distance - r) * w + j->at.b;
        *th = c->distance > 0.0 ? across / c->distance : 0.0;
        *pn = j->first ? j->at.a : 0.0;
        *pt = (j->first ? -across : 0.0) + r * *th;
    } else if (!j->first) {
        *th = w;
        *pt = r * w;
    } else {
        *pn = j->at.a;
        *pt = j->at.b - r * w;
    }
}

/* how the forces change with q_j: along n and t of before, and the moment at the place of before */
static inline void change_by_q(const stein_derivative *s, const contact *c, const stein__step *j,
                               int body, double change[3])
{
    double pn, pt, th, side = j->first ? 1.0 : -1.0;
    move(c, j, &pn, &pt, &th);
    double vn = pt * c->V.w - th * c->V.b, vt = th * c->V.a - pn * c->V.w;
    if (body != j->joint) { // what lies between them turns
        stein__local U = relative(s, c, body, j->joint);
        vn += side * (j->at.w * U.b - U.w * j->at.b);
        vt += side * (U.w * j->at.a - j->at.w * U.a);
    }
    double dfn = -(c->by_rate * vn + c->by_depth * side * j->at.a);
    double dft = c->fn >= 0.0 ? -(dfn * c->mu + c->fn * c->by_speed * vt) : 0.0;
    change[0] = dfn + c->ft * th;
    change[1] = dft - c->fn * th;
    change[2] = c->fn * pt - c->ft * pn;
}

static void add_contact(stein_derivative *s, const contact *c, int a, int b, double *Qq,
                        double *Qqd)
{
    int nq = s->model->nq, n = find_way(s, c, a, b);
    for (int i = 0; i < n; i++) {
        const stein__step *j = &s->way[i];
        double side = j->first ? 1.0 : -1.0, by_q[3];
        change_by_q(s, c, j, j->first ? a : b, by_q);
        double dfn = -c->by_rate * side * j->at.a;
        double dft = c->fn >= 0.0 ? -(dfn * c->mu + c->fn * c->by_speed * side * j->at.b) : 0.0;
        for (int l = 0; l < n; l++) {
            const stein__step *k = &s->way[l];
            double q = k->at.a * by_q[0] + k->at.b * by_q[1] + k->at.w * by_q[2];
            double qd = k->at.a * dfn + k->at.b * dft;
            if (l < i && j->first == k->first) { // j carries joint k
                q += c->fn * (j->at.w * k->at.b - k->at.w * j->at.b) +
                     c->ft * (k->at.w * j->at.a - j->at.w * k->at.a);
            }
            Qq[k->joint * nq + j->joint] += k->first ? q : -q;
            Qqd[k->joint * nq + j->joint] += k->first ? qd : -qd;
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
    int a = body_of(s, p->frame[0]), b = body_of(s, p->frame[1]);
    contact c = {.at = k->at,
                 .n = k->n,
                 .at_n = k->at.x * k->n.z - k->at.z * k->n.x,
                 .at_t = -k->at.x * k->n.x - k->at.z * k->n.z,
                 .radius = radius,
                 .distance = distance,
                 .carrier = by,
                 .fn = k->normal};
    c.V = relative(s, &c, a, b);
    stein__normal_slopes(p->normal, k->depth, k->rate, &c.by_depth, &c.by_rate);
    if (p->inverse_vt != 0.0) {
        c.mu = stein__mu(p->friction, p->parts, sim->slip[i], sim->grip[i]);
        c.by_speed = p->inverse_vt * stein__mu_slope(p->friction, sim->slip[i], sim->grip[i]);
    }
    c.ft = c.fn > 0.0 ? -c.fn * c.mu : 0.0;
    add_contact(s, &c, a, b, Qq, Qqd);
}

/* ---- all of them ---- */

static void add_sites(stein_derivative *s, double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    int i = 0;
    for (int k = 0; k < sim->nsite; k++) {
        const site *at = &sim->site[k];
        if (sim->mode[at->guard]) {
            double radius = at->round ? at->a[STEIN_SHAPE_R] : 0.0;
            double distance = at->line ? 0.0 : at->reach - sim->touch[i].depth;
            add_touch(s, i++, at->line ? OF_SECOND : BETWEEN, radius, distance, Qq, Qqd);
        }
    }
}

static void add_joints(stein_derivative *s, double *Qq, double *Qqd)
{
    const stein_sim *sim = s->sim;
    int nq = s->model->nq;
    for (int k = 0; k < sim->nacting; k++) {
        int j = sim->acting[k].joint, at = sim->ntouch + k;
        const double *law = sim->acting[k].law;
        double by_q, by_qd, grips = sim->acting[k].inverse_vt;
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
    if (s->model->nlink > 0 || s->model->nlimit > 0 || sim->ntable_on > 0 || sim->signals) {
        return 0;
    }
    memset(Qq, 0, sizeof *Qq * (size_t)(n * n));
    memset(Qqd, 0, sizeof *Qqd * (size_t)(n * n));
    find_twists(s);
    add_sites(s, Qq, Qqd);
    add_joints(s, Qq, Qqd);
    return 1;
}
