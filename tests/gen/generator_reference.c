/* SPDX-License-Identifier: MIT
 * generator_reference.c - an independent route to the equations of motion.
 *
 * With R_k(q), r_k(q) from plain homogeneous transforms and the geometric Jacobians of every centre
 * of mass:  T = 1/2 qd' M qd,  M = sum m Jv'Jv + Jw' R I R' Jw,  V = -sum m g.r, and Lagrange
 * (armatures are added to the diagonal of M)
 *      c_i = sum_j (dM_ij/dt) qd_j - 1/2 d(qd' M qd)/dq_i + dV/dq_i - Q_i
 * where d/dt along qd and d/dq_i are derivatives by dual numbers (exact, no step), and Q_i is the
 * virtual power of the external forces and moments. Nothing is shared with the generator: no
 * recursion, no recombined parameters, no moved origins, and O(n^4) work.
 */
#include "generator_reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* ---- dual numbers --------------------------------------------------------------------------- */

typedef struct dual {
    double a, b; /* value, derivative */
} dual;
typedef struct dvec {
    dual x[3];
} dvec;

static dual num(double a)
{
    return (dual){a, 0.0};
}

static dual add(dual x, dual y)
{
    return (dual){x.a + y.a, x.b + y.b};
}

static dual mul(dual x, dual y)
{
    return (dual){x.a * y.a, x.a * y.b + x.b * y.a};
}

static dual scale(double k, dual x)
{
    return (dual){k * x.a, k * x.b};
}

static dvec vadd(dvec a, dvec b)
{
    return (dvec){{add(a.x[0], b.x[0]), add(a.x[1], b.x[1]), add(a.x[2], b.x[2])}};
}

static dvec vscale(dual k, dvec a)
{
    return (dvec){{mul(k, a.x[0]), mul(k, a.x[1]), mul(k, a.x[2])}};
}

static dual vdot(dvec a, dvec b)
{
    return add(add(mul(a.x[0], b.x[0]), mul(a.x[1], b.x[1])), mul(a.x[2], b.x[2]));
}

static dvec vcross(dvec a, dvec b)
{
    dvec r;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        r.x[i] = add(mul(a.x[j], b.x[k]), scale(-1.0, mul(a.x[k], b.x[j])));
    }
    return r;
}

static dvec constant(const double k[3])
{
    return (dvec){{num(k[0]), num(k[1]), num(k[2])}};
}

/* ---- transforms ----------------------------------------------------------------------------- */

typedef struct frame {
    dvec column[3]; /* axes of the body in the fixed frame */
    dvec o;         /* origin */
    dvec axis;      /* joint axis times sign */
} frame;

static dvec turn(const frame *f, dvec v)
{
    return vadd(vadd(vscale(v.x[0], f->column[0]), vscale(v.x[1], f->column[1])),
                vscale(v.x[2], f->column[2]));
}

static void numbers(const mechanism *m, const mech_scalar *s, int n, double *out)
{
    for (int i = 0; i < n; i++) {
        out[i] = s[i].kind == MECH_PARAM ? m->params[s[i].index].value : s[i].value;
    }
}

static dvec vector(const mechanism *m, const mech_scalar s[3])
{
    double k[3];
    numbers(m, s, 3, k);
    return constant(k);
}

/** All frames at q + eps dir. */
static void transforms(const mechanism *m, const double *q, const double *dir, frame *f)
{
    static const frame fixed = {.column = {{{{1, 0}, {0, 0}, {0, 0}}},
                                           {{{0, 0}, {1, 0}, {0, 0}}},
                                           {{{0, 0}, {0, 0}, {1, 0}}}}};
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        const frame *p = b->parent < 0 ? &fixed : &f[b->parent];
        dual angle = {b->sign * q[i], b->sign * dir[i]};
        int a = b->axis - 'x', k = (a + 1) % 3, l = (a + 2) % 3;
        f[i] = *p;
        f[i].o = vadd(p->o, turn(p, vector(m, b->at)));
        f[i].axis = vscale(num(b->sign), p->column[a]);
        if (b->type == 'T') {
            f[i].o = vadd(f[i].o, vscale(angle, p->column[a]));
        } else {
            dual c = {cos(angle.a), -sin(angle.a) * angle.b},
                 s = {sin(angle.a), cos(angle.a) * angle.b};
            f[i].column[k] = vadd(vscale(c, p->column[k]), vscale(s, p->column[l]));
            f[i].column[l] = vadd(vscale(c, p->column[l]), vscale(scale(-1.0, s), p->column[k]));
        }
    }
}

/** Columns of the Jacobians of a point at x on body i. */
static void jacobian(const mechanism *m, const frame *f, int i, dvec x, dvec *jv, dvec *jw)
{
    memset(jv, 0, (size_t)m->nbody * sizeof *jv);
    memset(jw, 0, (size_t)m->nbody * sizeof *jw);
    for (int j = i; j >= 0; j = m->bodies[j].parent) {
        dvec arm = vadd(x, vscale(num(-1.0), f[j].o));
        int revolute = m->bodies[j].type == 'R';
        jv[j] = revolute ? vcross(f[j].axis, arm) : f[j].axis;
        jw[j] = revolute ? f[j].axis : (dvec){{{0, 0}, {0, 0}, {0, 0}}};
    }
}

/* ---- Lagrange ------------------------------------------------------------------------------- */

typedef struct energies {
    dual *M;
    dual V;
    double *Q;
} energies;

static void add_body(const mechanism *m, const frame *f, int i, const ref_state *s, energies *e,
                     dvec *jv, dvec *jw)
{
    const mech_body *b = &m->bodies[i];
    int n = m->nbody;
    double mass, I[6], gravity[3];
    numbers(m, &b->mass, 1, &mass);
    numbers(m, b->inertia, 6, I);
    numbers(m, m->gravity, 3, gravity);
    const double row[3][3] = {{I[0], I[3], I[4]}, {I[3], I[1], I[5]}, {I[4], I[5], I[2]}};
    dvec x = vadd(f[i].o, turn(&f[i], vector(m, b->centre)));
    dvec frc = turn(&f[i], constant(s->frc + 3 * i)), trq = turn(&f[i], constant(s->trq + 3 * i));
    jacobian(m, f, i, x, jv, jw);
    e->V = add(e->V, scale(-mass, vdot(constant(gravity), x)));
    for (int j = i; j >= 0; j = m->bodies[j].parent) {
        dvec local = {{vdot(f[i].column[0], jw[j]), vdot(f[i].column[1], jw[j]),
                       vdot(f[i].column[2], jw[j])}};
        dvec spin = {{vdot(constant(row[0]), local), vdot(constant(row[1]), local),
                      vdot(constant(row[2]), local)}};
        dvec momentum = turn(&f[i], spin);
        e->Q[j] += vdot(frc, jv[j]).a + vdot(trq, jw[j]).a;
        for (int k = i; k >= 0; k = m->bodies[k].parent) {
            dual t = add(scale(mass, vdot(jv[j], jv[k])), vdot(momentum, jw[k]));
            e->M[j * n + k] = add(e->M[j * n + k], t);
        }
    }
}

/** M, V with derivatives along dir, and Q. */
static void evaluate_along(const mechanism *m, const ref_state *s, const double *dir, energies *e)
{
    size_t n = (size_t)m->nbody;
    frame *f = calloc(n, sizeof *f);
    dvec *j = calloc(2 * n, sizeof *j);
    memset(e->M, 0, n * n * sizeof *e->M);
    memset(e->Q, 0, n * sizeof *e->Q);
    e->V = num(0.0);
    transforms(m, s->q, dir, f);
    for (int i = 0; i < m->nbody; i++) {
        double armature;
        numbers(m, &m->bodies[i].armature, 1, &armature);
        add_body(m, f, i, s, e, j, j + n);
        e->M[(size_t)i * n + (size_t)i].a += armature;
    }
    free(f);
    free(j);
}

static void lagrange(const mechanism *m, const ref_state *s, ref_out *out)
{
    int n = m->nbody;
    energies e = {.M = calloc((size_t)(n * n), sizeof(dual)),
                  .Q = calloc((size_t)n, sizeof(double))};
    double *dir = calloc((size_t)n, sizeof *dir);
    evaluate_along(m, s, s->qd, &e);
    out->kinetic = 0.0;
    out->potential = e.V.a;
    for (int i = 0; i < n; i++) {
        out->c[i] = -e.Q[i];
        for (int j = 0; j < n; j++) {
            out->M[i * n + j] = e.M[i * n + j].a;
            out->c[i] += e.M[i * n + j].b * s->qd[j];
            out->kinetic += 0.5 * s->qd[i] * e.M[i * n + j].a * s->qd[j];
        }
    }
    for (int i = 0; i < n; i++) {
        dir[i] = 1.0;
        evaluate_along(m, s, dir, &e);
        dir[i] = 0.0;
        out->c[i] += e.V.b;
        for (int j = 0; j < n * n; j++) {
            out->c[i] -= 0.5 * s->qd[j / n] * e.M[j].b * s->qd[j % n];
        }
    }
    free(e.M);
    free(e.Q);
    free(dir);
}

/* ---- points and poses ----------------------------------------------------------------------- */

static void points(const mechanism *m, const ref_state *s, const frame *f, ref_out *out)
{
    size_t n = (size_t)m->nbody;
    dvec *j = calloc(2 * n, sizeof *j);
    for (int k = 0; k < m->npoint; k++) {
        int i = m->points[k].body;
        dvec at = vector(m, m->points[k].at), x = at;
        if (i >= 0) {
            x = vadd(f[i].o, turn(&f[i], at));
        }
        jacobian(m, f, i, x, j, j + n);
        for (int c = 0; c < 3; c++) {
            out->x[3 * k + c] = x.x[c].a;
            out->v[3 * k + c] = x.x[c].b; /* derivative of the position along qd */
            out->jdqd[3 * k + c] = 0.0;
            for (size_t l = 0; l < n; l++) {
                out->J[(size_t)(3 * k + c) * n + l] = j[l].x[c].a;
                out->jdqd[3 * k + c] += j[l].x[c].b * s->qd[l];
            }
        }
    }
    free(j);
}

static void poses(const mechanism *m, const frame *f, double *pose)
{
    for (int i = 0; i < m->nbody; i++, pose += 7) {
        dvec x = f[i].column[0]; /* the body's x axis as drawn: (cos, sin) of the plane angle */
        pose[0] = f[i].o.x[0].a;
        pose[1] = f[i].o.x[2].a;
        pose[2] = x.x[0].a;
        pose[3] = x.x[2].a;
        pose[4] = f[i].o.x[0].b;
        pose[5] = f[i].o.x[2].b;
        pose[6] = x.x[0].a * x.x[2].b - x.x[2].a * x.x[0].b; /* rate of the plane angle */
    }
}

/** Charts of balls: their row is qdd = 0, and no force acts there. */
static void hold_charts(const mechanism *m, ref_out *out)
{
    int n = m->nbody;
    for (int i = 0; i < n; i++) {
        if (m->bodies[i].ball != 1) {
            continue;
        }
        for (int j = 0; j < n; j++) {
            out->M[i * n + j] = out->M[j * n + i] = 0.0;
        }
        out->M[i * n + i] = 1.0;
        out->c[i] = 0.0;
        for (int k = 0; k < 3 * m->npoint; k++) {
            out->J[k * n + i] = 0.0;
        }
    }
}

void ref_evaluate(const mechanism *m, const ref_state *s, ref_out *out)
{
    frame *f = calloc((size_t)m->nbody, sizeof *f);
    for (int i = 0; i < m->nbody; i++) {
        s->qd[i] = m->bodies[i].ball == 1 ? 0.0 : s->qd[i];
    }
    lagrange(m, s, out);
    transforms(m, s->q, s->qd, f);
    points(m, s, f, out);
    poses(m, f, out->pose);
    hold_charts(m, out);
    free(f);
}

/* ---- storage -------------------------------------------------------------------------------- */

ref_out ref_out_new(int n, int npoint)
{
    size_t np = 3 * (size_t)npoint + 1, nn = (size_t)n;
    return (ref_out){.M = calloc(nn * nn, sizeof(double)),
                     .c = calloc(nn, sizeof(double)),
                     .x = calloc(np, sizeof(double)),
                     .v = calloc(np, sizeof(double)),
                     .J = calloc(np * nn, sizeof(double)),
                     .jdqd = calloc(np, sizeof(double)),
                     .pose = calloc(7 * nn, sizeof(double))};
}

void ref_out_free(ref_out *r)
{
    free(r->M);
    free(r->c);
    free(r->x);
    free(r->v);
    free(r->J);
    free(r->jdqd);
    free(r->pose);
}

ref_state ref_state_random(int n, unsigned long long *seed)
{
    ref_state s = {.q = calloc((size_t)(9 * n), sizeof(double))};
    s.qd = s.q + n;
    s.qdd = s.qd + n;
    s.frc = s.qdd + n;
    s.trq = s.frc + 3 * n;
    for (int i = 0; i < 9 * n; i++) {
        s.q[i] = 2.0 * noise(seed);
    }
    return s;
}

void ref_state_free(ref_state *s)
{
    free(s->q);
}

/* ---- random trees --------------------------------------------------------------------------- */

/** A parameter of random value, or with probability `zeros` a structural zero. */
static mech_scalar random_scalar(mechanism *m, double zeros, double lo, double hi,
                                 unsigned long long *seed)
{
    if (0.5 * (1.0 + noise(seed)) < zeros) {
        return (mech_scalar){MECH_ZERO, 0, 0.0};
    }
    mech_param *p = &m->params[m->nparam];
    p->value = lo + (hi - lo) * 0.5 * (1.0 + noise(seed));
    snprintf(p->name, sizeof p->name, "n.p%d", m->nparam);
    snprintf(p->unit, sizeof p->unit, "1");
    return (mech_scalar){MECH_PARAM, m->nparam++, p->value};
}

static void random_body(mechanism *m, int i, double zeros, unsigned long long *seed)
{
    mech_body *b = &m->bodies[i];
    snprintf(b->name, sizeof b->name, "b%d", i);
    for (int k = 0; k < 3; k++) {
        b->at[k] = random_scalar(m, zeros, -1.0, 1.0, seed);
        b->centre[k] = random_scalar(m, zeros, -0.7, 0.7, seed);
    }
    b->mass = random_scalar(m, 0.3 * zeros, 0.3, 2.0, seed);
    for (int k = 0; k < 6; k++) {
        b->inertia[k] = random_scalar(m, zeros, k < 3 ? 0.5 : -0.1, k < 3 ? 1.0 : 0.1, seed);
    }
    b->q0 = random_scalar(m, zeros, -1.0, 1.0, seed);
    b->qd0 = random_scalar(m, zeros, -1.0, 1.0, seed);
    mech_point *p = &m->points[m->npoint++];
    snprintf(p->name, sizeof p->name, "b%d.p", i);
    p->body = i;
    for (int k = 0; k < 3; k++) {
        p->at[k] = random_scalar(m, zeros, -1.0, 1.0, seed);
    }
}

static mechanism *empty_tree(const char *name, int nbody)
{
    mechanism *m = calloc(1, sizeof *m);
    size_t n = (size_t)nbody;
    snprintf(m->name, sizeof m->name, "%s", name);
    m->params = calloc(41 * n + 10, sizeof *m->params);
    m->bodies = calloc(n, sizeof *m->bodies);
    m->points = calloc(n + 1, sizeof *m->points);
    m->contacts = calloc(n, sizeof *m->contacts);
    m->nbody = nbody;
    m->load_body = m->load_contact = m->stroke_string = m->stroke_notch = -1;
    m->dt = 1e-4;
    m->until = 1.0;
    return m;
}

mechanism *ref_tree(const char *name, int nbody, int planar, unsigned long long *seed)
{
    mechanism *m = empty_tree(name, nbody);
    for (int k = 0; k < 3; k++) {
        m->gravity[k] = random_scalar(m, 0.5, -10.0, 10.0, seed);
    }
    for (int i = 0; i < nbody; i++) {
        mech_body *b = &m->bodies[i];
        b->parent = (int)floor(0.5 * (1.0 + noise(seed)) * (i + 1)) - 1;
        if (noise(seed) < 0.2) {
            b->parent = i - 1; /* more chains than an even choice gives */
        }
        b->type = noise(seed) < 0.3 ? 'R' : 'T';
        b->axis = (char)('x' + (int)floor(1.5 * (1.0 + noise(seed))));
        if (planar) {
            b->axis = b->type == 'R' ? 'y' : b->axis == 'y' ? 'z' : b->axis;
            mech_contact *c = &m->contacts[m->ncontact++];
            snprintf(c->name, sizeof c->name, "c%d", i);
            c->nspot = 1;
            c->spot[0].side[0].body = i;
            c->spot[0].side[1] = (mech_shape){.body = -1, .is_line = 1};
        }
        b->sign = noise(seed) < 0.0 ? -1 : 1;
        random_body(m, i, i % 3 ? 0.4 : 0.1, seed);
    }
    return m;
}

void ref_armatures(mechanism *m, unsigned long long *seed)
{
    for (int i = 0; i < m->nbody; i++) {
        m->bodies[i].armature = random_scalar(m, 0.3, 0.05, 3.0, seed);
    }
}

mechanism *ref_arm(const char *name, const char *axes, unsigned long long *seed)
{
    int n = (int)strlen(axes);
    mechanism *m = empty_tree(name, n);
    m->gravity[2] = random_scalar(m, 0.0, -9.9, -9.7, seed);
    for (int i = 0; i < n; i++) {
        m->bodies[i].parent = i - 1;
        m->bodies[i].type = 'R';
        m->bodies[i].axis = axes[i];
        m->bodies[i].sign = 1;
        random_body(m, i, 0.0, seed);
    }
    return m;
}

void ref_tree_free(mechanism *m)
{
    free(m->params);
    free(m->bodies);
    free(m->points);
    free(m->contacts);
    free(m);
}
