/* SPDX-License-Identifier: MIT
 * dynamics.c - from (t, q, qd) to all forces and to qdd.
 *
 *      M(q) qdd + c(q, qd) = Q
 *
 * All forces act in Q. Those of contacts and notches and those at points of planar bodies (links,
 * inputs at a point) are summed to a wrench a body and go down the tree from joint to joint in
 * fixed axes: through frc and trq of c they would be turned into the axes of their body and back.
 * Forces at points that leave the plane go through the generated Jacobians. Joints with a
 * prescribed motion, or held, leave the unknowns: their row becomes qdd_i = given, their column
 * moves to the right-hand side.
 */
#include <math.h>
#include <string.h>

#include "core.h"

/* put prescribed coordinates in place; signals stay in sim->ustate */
static void drive(stein_sim *sim, double t, const double *q, const double *qd)
{
    const stein_model *model = sim->model;
    if (q != sim->xq) {
        copy(sim->xq, q, model->nq);
        copy(sim->xqd, qd, model->nq);
    }
    for (int i = 0; i < model->ninput; i++) {
        if (sim->signal[i] != NULL) {
            const double *law = sim->d + model->inputs[i].signal;
            double *u = sim->ustate + 3 * i, gain = law[STEIN_SIGNAL_GAIN];
            u[0] = u[1] = u[2] = 0.0;
            sim->signal[i](sim->signal_ctx[i], t - law[STEIN_SIGNAL_DELAY], u);
            u[0] *= gain;
            u[1] *= gain;
            u[2] *= gain;
            if (model->inputs[i].kind == STEIN_INPUT_MOTION) {
                sim->xq[model->inputs[i].index] = u[0];
                sim->xqd[model->inputs[i].index] = u[1];
            }
        }
    }
}

/* the state's prescribed joints onto their signals, now */
void stein__place_driven(stein_sim *sim)
{
    drive(sim, sim->head->t, sim->q, sim->qd);
    memcpy(sim->q, sim->xq, sizeof *sim->q * (size_t)sim->model->nq);
    memcpy(sim->qd, sim->xqd, sizeof *sim->qd * (size_t)sim->model->nq);
}

/* The wrenches of the bodies to the joints, from the leaves to the root, in fixed axes. A plane
 * moment counted from +x towards +z is a moment about -y. */
void stein__wrenches_to_joints(stein_sim *sim)
{
    const stein_model *model = sim->model;
    for (int i = model->nframe - 1; i >= 0; i--) {
        const stein_frame *frame = &model->frames[i];
        const stein_body *body = &model->bodies[frame->body];
        const stein_pose *p = &sim->pose[i];
        const wrench *w = &sim->wrench[i];
        double along = body->type == 'R'   ? -w->m
                       : body->axis == 'x' ? p->c * w->x + p->s * w->z
                                           : p->c * w->z - p->s * w->x;
        sim->Q[frame->body] += body->sign * along;
        if (frame->parent >= 0) {
            apply(sim, frame->parent, (vec2){p->x, p->z}, (vec2){w->x, w->z});
            sim->wrench[frame->parent].m += w->m;
        }
    }
}

void stein__point(const stein_sim *sim, int point, double x[3], double v[3])
{
    const stein_point *p = &sim->model->points[point];
    if (p->at < 0) {
        memcpy(x, sim->px + 3 * point, 3 * sizeof *x);
        memcpy(v, sim->pv + 3 * point, 3 * sizeof *v);
        return;
    }
    const stein_pose *pose = &sim->pose[p->frame];
    const double *at = sim->d + p->at;
    vec2 there = place(pose, at[0], at[2]), moves = velocity(pose, there);
    x[0] = there.x;
    x[1] = at[1];
    x[2] = there.z;
    v[0] = moves.x;
    v[1] = 0.0;
    v[2] = moves.z;
}

/* Q += J^T f for a force f [3] in fixed axes at a named point */
static void add_point_force(stein_sim *sim, int point, const double f[3])
{
    int nq = sim->model->nq;
    const double *J = sim->pJ + 3 * point * nq;
    for (int j = 0; j < nq; j++) {
        sim->Q[j] += J[j] * f[0] + J[nq + j] * f[1] + J[2 * nq + j] * f[2];
    }
}

/* the same where the point's body has a pose: into its wrench; the fixed frame takes everything */
static void pull(stein_sim *sim, int point, const double f[3])
{
    const stein_point *p = &sim->model->points[point];
    if (p->frame >= 0) {
        const stein_pose *pose = &sim->pose[p->frame];
        const double *at = sim->d + p->at;
        apply(sim, p->frame, place(pose, at[0], at[2]), (vec2){f[0], f[2]});
    } else if (p->body >= 0) {
        add_point_force(sim, point, f);
    }
}

static void link_forces(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nlink; i++) {
        const stein_link *link = &sim->model->links[i];
        const double *law = sim->d + link->d;
        double xa[3], xb[3], va[3], vb[3];
        stein__point(sim, link->point[0], xa, va);
        stein__point(sim, link->point[1], xb, vb);
        double r[3] = {xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]};
        double length = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
        if (!(length > 0.0)) {
            continue; // no direction, no force
        }
        double rate =
            ((vb[0] - va[0]) * r[0] + (vb[1] - va[1]) * r[1] + (vb[2] - va[2]) * r[2]) / length;
        double strength = (law[0] * (length - law[1]) + law[2] * rate) / length;
        double fa[3] = {strength * r[0], strength * r[1], strength * r[2]};
        double fb[3] = {-fa[0], -fa[1], -fa[2]};
        pull(sim, link->point[0], fa);
        pull(sim, link->point[1], fb);
    }
}

static void joint_forces(stein_sim *sim)
{
    const stein_model *model = sim->model;
    const double *slip = sim->slip + sim->ntouch, *grip = sim->grip + sim->ntouch;
    for (int k = 0; k < sim->nacting; k++) {
        int j = sim->acting[k];
        const double *law = sim->d + model->bodies[j].joint;
        double mu = stein__mu(law + STEIN_JOINT_FRICTION, slip[k], grip[k]);
        sim->Q[j] += stein__joint(law, sim->xq[j], sim->xqd[j], mu);
    }
    if (sim->ntable_on > 0) {
        stein__tables_joints(sim);
    }
}

static void input_forces(stein_sim *sim)
{
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        double u = sim->ustate[3 * i];
        if (input->kind == STEIN_INPUT_JOINT) {
            sim->Q[input->index] += u;
        } else if (input->kind == STEIN_INPUT_POINT && sim->signal[i] != NULL) {
            const double *direction = sim->d + input->direction;
            double f[3] = {u * direction[0], u * direction[1], u * direction[2]};
            pull(sim, input->index, f);
        }
    }
}

void stein__wire(stein_sim *sim)
{
    const stein_model *model = sim->model;
    sim->jacobians = sim->motions = 0;
    for (int i = 0; i < model->ninput; i++) {
        const stein_input *input = &model->inputs[i];
        int on = sim->signal[i] != NULL;
        sim->jacobians |=
            input->kind == STEIN_INPUT_POINT && on && model->points[input->index].at < 0;
        sim->motions |= input->kind == STEIN_INPUT_MOTION && (on || input->hold);
    }
    for (int i = 0; i < model->nlink; i++) {
        const stein_link *link = &model->links[i];
        sim->jacobians |=
            model->points[link->point[0]].at < 0 || model->points[link->point[1]].at < 0;
    }
}

/* all forces at the coordinates in xq, xqd */
static void forces(stein_sim *sim, double t)
{
    const stein_model *model = sim->model;
    size_t nq = (size_t)model->nq;
    memset(sim->Q, 0, sizeof *sim->Q * nq);
    if (model->nframe > 0) {
        memset(sim->wrench, 0, sizeof *sim->wrench * (size_t)model->nframe);
        model->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
    }
    sim->ntouch = 0;
    stein__spot_forces(sim);
    stein__notch_forces(sim);
    stein__rub(sim);
    if (sim->jacobians) {
        model->point(sim->xq, sim->xqd, sim->sc, sim->d, sim->px, sim->pv, sim->pJ, sim->pa);
    }
    link_forces(sim);
    input_forces(sim);
    joint_forces(sim);
    stein__wrenches_to_joints(sim);
    if (sim->on_force != NULL) {
        sim->on_force(sim->force_ctx, t, sim->xq, sim->xqd, sim->Q);
    }
}

/* the motion input that drives a joint with a signal or a hold; -1 for a free joint, -2 for held */
static int driver(const stein_sim *sim, int joint)
{
    if (sim->held[joint]) {
        return -2;
    }
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        if (input->kind == STEIN_INPUT_MOTION && input->index == joint) {
            if (sim->signal[i] != NULL) {
                return i;
            }
            if (input->hold) {
                return -2;
            }
        }
    }
    return -1;
}

int stein__is_driven(const stein_sim *sim, int joint)
{
    return driver(sim, joint) != -1;
}

/* is there a joint that driver() has to be asked about? Mostly not; only the load is ever held. */
static int any_driven(const stein_sim *sim)
{
    int load = sim->model->load.body;
    return sim->motions || (load >= 0 && sim->held[load]);
}

/* take joint j out of the unknowns of M x = b: x_j = value */
static void prescribe(int n, double *M, double *b, int j, double value)
{
    for (int i = 0; i < n; i++) {
        b[i] -= M[i * n + j] * value;
        M[i * n + j] = M[j * n + i] = 0.0;
    }
    M[j * n + j] = 1.0;
    b[j] = value;
}

int stein__solved(stein_sim *sim, double *b)
{
    const stein_model *model = sim->model;
    return model->solve != NULL ? model->solve(sim->M, b)
                                : stein__solve(model->nq, sim->parent, sim->M, b, sim->inverse);
}

stein_status stein__evaluate(stein_sim *sim, double t, const double *q, const double *qd,
                             double *qdd, stein_err *err)
{
    const stein_model *model = sim->model;
    int nq = model->nq;
    drive(sim, t, q, qd);
    turn_joints(model, sim->xq, sim->sc);
    forces(sim, t);
    model->mass_bias(sim->xq, sim->xqd, sim->sc, sim->d, sim->zero, sim->zero, sim->M, sim->c);
    for (int j = 0; j < nq; j++) {
        qdd[j] = sim->Q[j] - sim->c[j];
    }
    for (int j = 0, any = any_driven(sim); any && j < nq; j++) {
        int by = driver(sim, j);
        if (by != -1) {
            prescribe(nq, sim->M, qdd, j, by >= 0 ? sim->ustate[3 * by + 2] : 0.0);
        }
    }
    int bad = stein__solved(sim, qdd);
    if (bad >= 0 && isfinite(sim->M[bad * nq + bad])) {
        return stein__fail(err, STEIN_ESINGULAR,
                           "the mass matrix is singular at joint \"%s\", t = %g s: what it carries "
                           "needs a mass or an inertia > 0",
                           model->bodies[bad].name, t);
    }
    return STEIN_OK;
}

/* poses of what rests at q */
static void pose_at(stein_sim *sim, const double *q)
{
    const stein_model *model = sim->model;
    if (model->nframe > 0) {
        turn_joints(model, q, sim->sc);
        model->pose(q, sim->zero, sim->sc, sim->d, sim->pose);
    }
}

void stein__guards(stein_sim *sim, const double *q, double *guard)
{
    const stein_model *model = sim->model;
    pose_at(sim, q);
    for (int i = 0; i < model->nspot; i++) {
        guard[i] = stein__spot_guard(sim, i);
    }
    for (int i = 0; i < model->nnotch; i++) {
        double overlap;
        stein__notch_guards(sim, i, guard + model->nspot + NOTCH_GUARDS * i, &overlap);
    }
}

double stein__guard(stein_sim *sim, const double *q, int i)
{
    int nspot = sim->model->nspot;
    pose_at(sim, q);
    if (i < nspot) {
        return stein__spot_guard(sim, i);
    }
    double guard[NOTCH_GUARDS], overlap;
    stein__notch_guards(sim, (i - nspot) / NOTCH_GUARDS, guard, &overlap);
    return guard[(i - nspot) % NOTCH_GUARDS];
}

void stein__place(stein_sim *sim)
{
    drive(sim, sim->head->t, sim->q, sim->qd);
    stein_turn(sim->model, sim->xq, sim->sc);
    if (sim->model->nframe > 0) {
        sim->model->pose(sim->xq, sim->xqd, sim->sc, sim->d, sim->pose);
    }
}

stein_status stein__refresh(stein_sim *sim, stein_err *err)
{
    if (sim->fresh != FRESH) {
        stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
        if (status != STEIN_OK) {
            return status;
        }
        sim->fresh = FRESH;
    }
    return STEIN_OK;
}
