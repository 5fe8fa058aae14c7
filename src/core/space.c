/* SPDX-License-Identifier: MIT
 * space.c - contacts in space: a sphere (or a point) on a plane, or on another sphere.
 *
 *      x = r0 + r1 - (P0 - P1).n      sphere on plane:   n the plane's normal, r1 = 0
 *                                     sphere on sphere:  n from P1 to P0
 *
 * As in the plane (contact.c), less `gap`; the laws are the same. Friction acts against the
 * sliding, which is a vector here: on side 0 f_n n - mu(|v|) f_n v/|v|, v the speed of sliding in
 * the plane of contact; side 1 gets the opposite force at the same place. A box touches with its
 * corners.
 *
 * Forces are summed to a wrench a body, in fixed axes, which goes down the tree from joint to
 * joint.
 */
#include <math.h>
#include <string.h>

#include "pair_force.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void add_cross(double to[3], const double a[3], const double b[3])
{
    to[0] += a[1] * b[2] - a[2] * b[1];
    to[1] += a[2] * b[0] - a[0] * b[2];
    to[2] += a[0] * b[1] - a[1] * b[0];
}

/* a direction of a body in the fixed frame */
static void turn3(const stein_pose3 *p, const double u[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = p->R[3 * i] * u[0] + p->R[3 * i + 1] * u[1] + p->R[3 * i + 2] * u[2];
    }
}

void stein__place3(stein_sim *sim, const double *q, const double *qd)
{
    sim->model->pose3(q, qd, sim->sc, sim->d, sim->pose3);
    memset(sim->wrench3, 0, sizeof *sim->wrench3 * (size_t)sim->model->npose3);
}

/* ---- where and how deep ---- */

/* centre of side 0, unit normal on it, deformation x (< 0 apart) */
typedef struct meeting3 {
    double centre[3], n[3], depth;
} meeting3;

static void centre_of(const stein_sim *sim, const site *s, int side, double out[3])
{
    const stein_pose3 *p = &sim->pose3[s->pair.frame[side]];
    turn3(p, (side ? s->b : s->a) + STEIN_SOLID_X, out);
    for (int i = 0; i < 3; i++) {
        out[i] += p->o[i];
    }
}

static meeting3 meet(const stein_sim *sim, int spot)
{
    const site *s = &sim->site[spot];
    meeting3 m = {.depth = 0.0};
    double other[3], r[3];
    centre_of(sim, s, 0, m.centre);
    centre_of(sim, s, 1, other);
    for (int i = 0; i < 3; i++) {
        r[i] = m.centre[i] - other[i];
    }
    if (sim->model->spots[spot].side[1].kind == STEIN_PLANE) {
        turn3(&sim->pose3[s->pair.frame[1]], s->b + STEIN_SOLID_NX, m.n);
    } else {
        double distance = sqrt(dot(r, r));
        for (int i = 0; i < 3; i++) {
            m.n[i] = distance > 0.0 ? r[i] / distance : i == 2;
        }
    }
    m.depth = s->reach - dot(r, m.n);
    return m;
}

double stein__solid_gap(const stein_sim *sim, int spot)
{
    return -meet(sim, spot).depth;
}

double stein__solid_guard(const stein_sim *sim, int spot)
{
    return meet(sim, spot).depth + sim->site[spot].pair.normal[STEIN_NORMAL_RANGE];
}

/* ---- forces ---- */

/* what side 0 moves at the place of contact, against side 1 */
static void relative_velocity(const stein_sim *sim, const pair *p, const double at[3], double v[3])
{
    memset(v, 0, 3 * sizeof *v);
    for (int side = 0; side < 2; side++) {
        const stein_pose3 *pose = &sim->pose3[p->frame[side]];
        double arm[3], moves[3] = {pose->v[0], pose->v[1], pose->v[2]};
        for (int i = 0; i < 3; i++) {
            arm[i] = at[i] - pose->o[i];
        }
        add_cross(moves, pose->w, arm);
        for (int i = 0; i < 3; i++) {
            v[i] += side ? -moves[i] : moves[i];
        }
    }
}

/* a force on the first body at a place, the opposite one on the second */
static void apply3(stein_sim *sim, const pair *p, const double at[3], const double force[3])
{
    for (int side = 0; side < 2; side++) {
        wrench3 *w = &sim->wrench3[p->frame[side]];
        double arm[3], f[3];
        for (int i = 0; i < 3; i++) {
            f[i] = side ? -force[i] : force[i];
            arm[i] = at[i] - sim->pose3[p->frame[side]].o[i];
            w->f[i] += f[i];
        }
        add_cross(w->m, arm, f);
    }
}

static void sphere_force(stein_sim *sim, const site *s, const meeting3 *m, spot_force *f)
{
    const pair *p = &s->pair;
    touch3 *where = &sim->touch3[sim->ntouch];
    double v[3], speed = 0.0;
    for (int i = 0; i < 3; i++) {
        where->n[i] = m->n[i];
        where->at[i] = m->centre[i] - s->a[STEIN_SOLID_R] * m->n[i];
    }
    relative_velocity(sim, p, where->at, v);
    double rate = -dot(v, m->n);
    for (int i = 0; i < 3; i++) {
        v[i] += rate * m->n[i];
    }
    speed = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) {
        where->t[i] = speed > 0.0 ? v[i] / speed : 0.0;
    }
    double normal = stein__normal(p->normal, p->parts, m->depth, rate);
    if (sim->ntable_on > 0) {
        normal = stein__tables_normal(sim, p->index, normal, m->depth, rate);
    }
    double slip = speed * p->inverse_vt, grip = stein__tanh(slip);
    double rub = normal > 0.0 ? normal * stein__pair_mu(sim, p, slip, grip) : 0.0, force[3];
    for (int i = 0; i < 3; i++) {
        force[i] = normal * where->n[i] - rub * where->t[i];
    }
    apply3(sim, p, where->at, force);
    f->depth = m->depth;
    f->rate = rate;
    sim->touch[sim->ntouch] = (touch){
        .pair = p, .normal = normal, .depth = m->depth, .rate = rate, .speed = speed, .sum = f};
    stein__record_contact(sim, slip, grip, rub);
}

void stein__solid_forces(stein_sim *sim, int spot)
{
    spot_force *f = &sim->spot[spot];
    int on = sim->mode[spot];
    if (sim->inside != AT_END && !on) {
        return; // gap, guard and that there is no force are asked for at the end of the step
    }
    f->depth = f->normal = f->tangent = 0.0;
    meeting3 m = meet(sim, spot);
    if (sim->inside == AT_END) {
        f->gap = -m.depth;
        sim->guard[spot] = m.depth + sim->site[spot].pair.normal[STEIN_NORMAL_RANGE];
    }
    if (on) {
        sphere_force(sim, &sim->site[spot], &m, f);
    }
}

void stein__solid_probe(stein_sim *sim, const touch *t, int across)
{
    const touch3 *where = &sim->touch3[t - sim->touch];
    double direction[3] = {0.0}, axis[3] = {0.0};
    memcpy(direction, across ? where->t : where->n, sizeof direction);
    if (!(dot(direction, direction) > 0.0)) { // it does not slide: any direction across the normal
        axis[fabs(where->n[0]) < 0.7 ? 0 : 1] = 1.0;
        add_cross(direction, where->n, axis);
    }
    memset(sim->wrench3, 0, sizeof *sim->wrench3 * (size_t)sim->model->npose3);
    apply3(sim, t->pair, where->at, direction);
    stein__solids_to_joints(sim);
}

void stein__solids_to_joints(stein_sim *sim)
{
    const stein_model *model = sim->model;
    for (int i = model->npose3 - 1; i >= 0; i--) {
        const stein_body *body = &model->bodies[model->frames3[i].body];
        const stein_pose3 *p = &sim->pose3[i];
        const wrench3 *w = &sim->wrench3[i];
        int up = model->frames3[i].parent, a = body->axis - 'x';
        const double axis[3] = {p->R[a], p->R[3 + a], p->R[6 + a]};
        sim->Q[model->frames3[i].body] += body->sign * dot(axis, body->type == 'R' ? w->m : w->f);
        if (up >= 0) {
            double arm[3];
            for (int k = 0; k < 3; k++) {
                arm[k] = p->o[k] - sim->pose3[up].o[k];
                sim->wrench3[up].f[k] += w->f[k];
                sim->wrench3[up].m[k] += w->m[k];
            }
            add_cross(sim->wrench3[up].m, arm, w->f);
        }
    }
    for (int i = 0; i < model->nball; i++) {
        sim->Q[model->balls[i].joint] = 0.0; // the chart stays, whatever turns the body
    }
}

/* ---- attitudes ---- */

double stein__attitude(const stein_sim *sim, stein_read_kind read, int index)
{
    const double *R = sim->pose3[index].R, *w = sim->pose3[index].w;
    int k = (int)read - (int)STEIN_READ_WX;
    switch (read) {
    case STEIN_READ_ROLL: return stein__angle(R[7], R[8]);
    case STEIN_READ_PITCH: return stein__angle(-R[6], sqrt(R[0] * R[0] + R[3] * R[3]));
    case STEIN_READ_YAW: return stein__angle(R[3], R[0]);
    case STEIN_READ_WX:
    case STEIN_READ_WY:
    case STEIN_READ_WZ: return R[k] * w[0] + R[3 + k] * w[1] + R[6 + k] * w[2];
    default: return R[(int)read - (int)STEIN_READ_XX];
    }
}
