/* SPDX-License-Identifier: MIT
 * tangent.c - derivatives of all forces along a direction: contacts, notches, links, joints, tables
 * and inputs.
 *
 * The sources of these forces are included below and so compiled a second time, with numbers that
 * carry their derivative (STEIN_LANES 0, tangent.h). So no force is written twice.
 *
 * A direction is a change of q, qd, of the derived constants d and, with them, of the poses of the
 * bodies, which generated code computes. The modes of contacts and notches are held, so that the
 * forces are smooth.
 */
#define STEIN_LANES 0

#include "direction.h"

#include "core.h"

#include "contact.c"
#include "forces.c"
#include "inputs.c"
#include "layout.c"
#include "notch.c"
#include "table.c"
#include "contact_sites.c"

size_t stein__tangent_size(const stein_model *model)
{
    return stein__layout(NULL, model);
}

void *stein__tangent_make(void *block, const stein_model *model)
{
    stein_sim *sim = block;
    memset(sim, 0, stein__layout(NULL, model));
    sim->model = model;
    (void)stein__layout(sim, model);
    sim->pose[-1] = (stein_pose){.c = same(1.0)};
    stein__gather(sim);
    return sim;
}

static void prepare(stein_sim *sim)
{
    stein__tables_prepare(sim);
    stein__pairs_prepare(sim);
    stein__joints_prepare(sim);
}

/* values to [n], without a derivative */
static void put(real *to, const double *from, int n)
{
    for (int i = 0; i < n; i++) {
        to[i] = same(from[i]);
    }
}

/* their derivatives, or none */
static void slope(real *to, const double *from, int n)
{
    for (int i = 0; i < n; i++) {
        to[i] = with_slope(__real__ to[i], from != NULL ? from[i] : 0.0);
    }
}

static real *numbers_of(stein_pose *pose)
{
    return (real *)(void *)pose;
}

static void slope_poses(stein_sim *sim, const double *dpose)
{
    for (int i = 0; i < sim->model->nframe; i++) {
        slope(numbers_of(&sim->pose[i]), dpose != NULL ? dpose + STEIN__POSE * i : NULL,
              STEIN__POSE);
    }
}

void stein__tangent_place(void *tangent, const stein__at *at, int with_d)
{
    stein_sim *sim = tangent;
    const stein_model *model = sim->model;
    if (with_d) {
        put(sim->d, at->d, model->nd);
        sim->fresh = STALE;
    }
    put(sim->xq, at->q, model->nq);
    put(sim->xqd, at->qd, model->nq);
    put(sim->ustate, at->u, 3 * model->ninput);
    for (int i = 0; i < model->nframe; i++) {
        put(numbers_of(&sim->pose[i]), at->pose + STEIN__POSE * i, STEIN__POSE);
    }
    if (at->px != NULL) {
        put(sim->px, at->px, 3 * model->npoint);
        put(sim->pv, at->pv, 3 * model->npoint);
        put(sim->pJ, at->pJ, 3 * model->npoint * model->nq);
    }
    for (int i = 0; i < model->ninput; i++) {
        sim->signal[i] = at->signal[i];
    }
    memcpy(sim->mode, at->mode, (size_t)sim->nguard);
    sim->head->load_present = at->load_present;
    sim->signals = at->signals;
}

/* the numbers of a direction in place; d stays without where it does */
static void turn_to(stein_sim *sim, const stein__direction *way)
{
    const stein_model *model = sim->model;
    slope(sim->xq, way->dq, model->nq);
    slope(sim->xqd, way->dqd, model->nq);
    slope(sim->ustate, way->du, 3 * model->ninput);
    slope_poses(sim, way->dpose);
    if (way->dpx != NULL) {
        slope(sim->px, way->dpx, 3 * model->npoint);
        slope(sim->pv, way->dpv, 3 * model->npoint);
        slope(sim->pJ, way->dpJ, 3 * model->npoint * model->nq);
    }
    for (int i = 0; i < way->nmoved; i++) {
        slope(&sim->d[way->moved[i]], &way->dd[way->moved[i]], 1);
    }
    if (way->nmoved > 0 || sim->fresh == STALE) {
        prepare(sim);
        sim->fresh = FRESH; // what is prepared belongs to d
    }
}

static void turn_back(stein_sim *sim, const stein__direction *way)
{
    for (int i = 0; i < way->nmoved; i++) {
        slope(&sim->d[way->moved[i]], NULL, 1);
        sim->fresh = STALE;
    }
}

static void slopes_to(const real *from, int n, double *to)
{
    for (int i = 0; i < n; i++) {
        to[i] = slope_of(from[i]);
    }
}

void stein__tangent_forces(void *tangent, const stein__direction *way, double *dQ)
{
    stein_sim *sim = tangent;
    turn_to(sim, way);
    sim->inside = IN_STAGE; // guards are not asked for
    stein__forces(sim);
    slopes_to(sim->Q, sim->model->nq, dQ);
    turn_back(sim, way);
}

void stein__tangent_guards(void *tangent, const stein__direction *way, double *dguard)
{
    stein_sim *sim = tangent;
    turn_to(sim, way);
    for (int i = 0; i < sim->model->nspot; i++) {
        meeting m = meet(&sim->site[i], shape_of(&sim->site[i]));
        sim->guard[i] = guard_of(&sim->site[i], &m, shape_of(&sim->site[i]));
    }
    for (int i = 0; i < sim->model->nnotch; i++) {
        real overlap;
        stein__notch_guards(sim, i, sim->guard + sim->model->nspot + NOTCH_GUARDS * i, &overlap);
    }
    slopes_to(sim->guard, sim->nguard, dguard);
    turn_back(sim, way);
}

/* ---- laws ---- */

/* a block of a law in registers, so that the compiler sees which derivatives are 0 */
#define BLOCK(name, law, size)         \
    real name[size];                   \
    for (int i = 0; i < (size); i++) { \
        (name)[i] = same((law)[i]);    \
    }

void stein__normal_slopes(const double *law, double x, double xdot, double *by_x, double *by_xdot)
{
    BLOCK(block, law, STEIN_NORMAL_SIZE)
    x = __real__ stein__within(block, same(x));
    int parts = stein__normal_parts(block);
    *by_x = slope_of(stein__normal(block, parts, with_slope(x, 1.0), same(xdot)));
    *by_xdot = slope_of(stein__normal(block, parts, same(x), with_slope(xdot, 1.0)));
}

double stein__mu_slope(const double *law, double u, double tanh_u)
{
    BLOCK(block, law, STEIN_FRICTION_SIZE)
    real grip = with_slope(tanh_u, 1.0 - tanh_u * tanh_u);
    return slope_of(stein__mu(block, stein__friction_parts(block), with_slope(u, 1.0), grip));
}

void stein__joint_slopes(const double *law, double q, double qd, double friction, double *by_q,
                         double *by_qd)
{
    BLOCK(block, law, STEIN_JOINT_SIZE)
    int parts = stein__joint_parts(block);
    *by_q = slope_of(stein__joint(block, parts, with_slope(q, 1.0), same(qd), same(0.0)));
    *by_qd = slope_of(
        stein__joint(block, parts, same(q), with_slope(qd, 1.0), with_slope(0.0, friction)));
}
