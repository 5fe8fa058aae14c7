/* SPDX-License-Identifier: MIT
 * forces.c - all forces of a mechanism at its coordinates, and qdd under them.
 *
 *      M(q) qdd + c(q, qd) = Q
 *
 * All forces act in Q. Forces of contacts, of notches and at points of planar bodies (links,
 * inputs at a point) are summed to a wrench a body. Wrenches go down the tree from joint to
 * joint in fixed axes. Through frc and trq of c they would be turned into the axes of their body
 * and back.
 * Forces at points that leave the plane go through the generated Jacobians.
 */
#include "pair_force.h"

/* The wrenches of the bodies to the joints, from the leaves to the root, in fixed axes. A plane
 * moment counted from +x towards +z is a moment about -y. */
INNER void stein__wrenches_to_joints(stein_sim *sim)
{
    real *Q = sim->Q;
    for (const limb *first = sim->limb, *l = first + sim->model->nframe; l-- > first;) {
        const wrench *w = l->wrench;
        const stein_pose *p = l->pose;
        real along = l->kind == LIMB_TURNS     ? -w->m
                     : l->kind == LIMB_ALONG_X ? p->c * w->x + p->s * w->z
                                               : p->c * w->z - p->s * w->x;
        Q[l->joint] += l->sign * along;
        if (l->onto != NULL) {
            push_at(l->onto, arm_to(l->parent_pose, (vec2){p->x, p->z}), (vec2){w->x, w->z});
            l->onto->m += w->m;
        }
    }
}

INNER void stein__point(const stein_sim *sim, int point, real x[3], real v[3])
{
    const stein_point *p = &sim->model->points[point];
    if (p->at < 0) {
        memcpy(x, sim->px + 3 * point, 3 * sizeof *x);
        memcpy(v, sim->pv + 3 * point, 3 * sizeof *v);
        return;
    }
    const stein_pose *pose = &sim->pose[p->frame];
    const real *at = sim->d + p->at;
    vec2 there = place(pose, at[0], at[2]), moves = velocity(pose, there);
    x[0] = there.x;
    x[1] = at[1];
    x[2] = there.z;
    v[0] = moves.x;
    v[1] = same(0.0);
    v[2] = moves.z;
}

/* Q += J^T f for a force f [3] in fixed axes at a named point */
static void add_point_force(stein_sim *sim, int point, const real f[3])
{
    int nq = sim->model->nq;
    const real *J = sim->pJ + 3 * point * nq;
    for (int j = 0; j < nq; j++) {
        sim->Q[j] += J[j] * f[0] + J[nq + j] * f[1] + J[2 * nq + j] * f[2];
    }
}

/* the same where the point's body has a pose: into its wrench; the fixed frame takes everything */
INNER void stein__pull(stein_sim *sim, int point, const real f[3])
{
    const stein_point *p = &sim->model->points[point];
    if (p->frame >= 0) {
        const stein_pose *pose = &sim->pose[p->frame];
        const real *at = sim->d + p->at;
        apply(sim, p->frame, place(pose, at[0], at[2]), (vec2){f[0], f[2]});
    } else if (p->body >= 0) {
        add_point_force(sim, point, f);
#if STEIN_LANES == 1
        if (sim->notes_pulls) {
            stein__note_pull(sim, point, f);
        }
#endif
    }
}

static void link_forces(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nlink; i++) {
        const stein_link *link = &sim->model->links[i];
        const real *law = sim->d + link->d;
        real xa[3], xb[3], va[3], vb[3];
        stein__point(sim, link->point[0], xa, va);
        stein__point(sim, link->point[1], xb, vb);
        real r[3] = {xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]};
        real length = root_of(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
        mask has_direction = more(length, 0.0);
        if (!any(has_direction)) {
            continue; // no direction, no force
        }
        real rate =
            over((vb[0] - va[0]) * r[0] + (vb[1] - va[1]) * r[1] + (vb[2] - va[2]) * r[2], length);
        real strength = over(stein__tension(law, length, rate, xa[2]), length);
        strength = only(has_direction, strength);
        real fa[3] = {strength * r[0], strength * r[1], strength * r[2]};
        real fb[3] = {-fa[0], -fa[1], -fa[2]};
        stein__pull(sim, link->point[0], fa);
        stein__pull(sim, link->point[1], fb);
    }
}

enum { plain_parts = STEIN__RUBBING | STEIN__SPRUNG | STEIN__PRELOADED };

INNER void stein__joints_prepare(stein_sim *sim)
{
    sim->nacting = 0;
    for (int j = 0; j < sim->model->nq; j++) {
        const real *law = sim->d + sim->model->bodies[j].joint;
        int parts = stein__joint_parts(law);
        if (stein__joint_acts(parts)) {
            real inverse_vt = stein__inverse_vt(law + STEIN_JOINT_FRICTION);
            int plain = (parts & ~plain_parts) == 0 && sim->hold.joint[j] < 0;
            sim->acting[sim->nacting++] = (acting){law, j, parts, plain, inverse_vt};
        }
    }
}

/* of the k-th acting joint */
ALWAYS real joint_friction(const stein_sim *sim, int k, real slip, real grip)
{
#if STEIN_LANES == 1
    (void)slip, (void)grip;
    return stein__joint_mu(sim, k);
#else
    const acting *a = &sim->acting[k];
    return stein__mu(a->law + STEIN_JOINT_FRICTION, a->parts, slip, grip);
#endif
}

static void joint_forces(stein_sim *sim)
{
    const stein_model *model = sim->model;
    const acting *a = sim->acting, *end = a + sim->nacting;
    real *slip = sim->slip + sim->ntouch, *grip = sim->grip + sim->ntouch;
    for (int k = 0; a < end; k++, a++) {
        real q = sim->xq[a->joint], qd = sim->xqd[a->joint], *Q = &sim->Q[a->joint];
        slip[k] = qd * a->inverse_vt;
        grip[k] = stein__tanh(slip[k]);
        if (a->plain) {
            real friction = a->law[STEIN_JOINT_FRICTION + STEIN_FRICTION_A] * grip[k];
            *Q += stein__joint(a->law, a->parts & plain_parts, q, qd, friction);
        } else {
            *Q += stein__joint(a->law, a->parts, q, qd, joint_friction(sim, k, slip[k], grip[k]));
        }
    }
    for (int i = 0; i < model->nlimit; i++) {
        int j = model->limits[i].joint;
        sim->Q[j] += stein__limit(sim->d + model->limits[i].d, sim->xq[j], sim->xqd[j]);
    }
    if (sim->ntable_on > 0) {
        stein__tables_joints(sim);
    }
}

INNER void stein__forces(stein_sim *sim)
{
    const stein_model *model = sim->model;
    clear(sim->Q, model->nq);
    if (model->nframe > 0) {
        clear(&sim->wrench->x, 3 * model->nframe);
#if STEIN_LANES > 0 // else they are in place
        EQUATIONS(sim)->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
#endif
    }
#if STEIN_LANES == 1
    if (model->npose3 > 0) {
        stein__place3(sim, sim->xq, sim->xqd);
    }
#endif
    sim->ntouch = 0;
    if (sim->inside != IN_STAGE) {
        stein__notches_look(sim);
    }
    stein__site_forces(sim);
#if STEIN_LANES == 1
    if (sim->jacobians) {
        model->point(sim->xq, sim->xqd, sim->sc, sim->d, sim->px, sim->pv, sim->pJ, sim->pa);
    }
#endif
    link_forces(sim);
    if (sim->signals) {
        stein__inputs(sim);
    }
    joint_forces(sim);
    stein__wrenches_to_joints(sim);
#if STEIN_LANES == 1
    if (model->npose3 > 0 || model->nball > 0) {
        stein__solids_to_joints(sim);
    }
#endif
}

#if STEIN_LANES > 0

/* qdd without M. Its diagonal has the pivots, as after a solution. */
static stein_solved articulate(stein_sim *sim, real *qdd)
{
    int nq = sim->model->nq;
    real *pivot = sim->c;
    STEIN_PIVOTS
    EQUATIONS(sim)->articulated(sim->xq, sim->xqd, sim->sc, sim->d, sim->Q, qdd, pivot);
    for (int j = nq - 1; j >= 0; j--) {
        sim->M[j * nq + j] = pivot[j];
        STEIN_PIVOT(pivot[j] > 0.0, j)
    }
    return STEIN_SOLVED;
}

INNER stein_solved stein__accelerate(stein_sim *sim, real *qdd)
{
    int nq = sim->model->nq;
#if STEIN_LANES == 1
    if (sim->model->nrow > 0) {
        return stein__loops_accelerate(sim, qdd);
    }
#endif
    if (EQUATIONS(sim)->articulated != NULL) {
        return articulate(sim, qdd);
    }
    EQUATIONS(sim)->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
    const real *Q = sim->Q, *c = sim->c;
    for (int j = 0; j < nq; j++) {
        qdd[j] = Q[j] - c[j];
    }
    if (stein__prescribes(sim)) {
        stein__prescribe(sim, sim->M, qdd);
    }
#if STEIN_LANES == 1
    return sim->model->solve != NULL ? sim->model->solve(sim->M, qdd) : stein__solved(sim, qdd);
#else
    return EQUATIONS(sim)->solve(sim->M, qdd);
#endif
}

#endif
