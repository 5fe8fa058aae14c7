/* SPDX-License-Identifier: MIT
 * sim.c - creation, names, parameters, reset, hooks, equations.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "elementary.h"

enum { ALIGNED = 16 }; /* bytes, of what is worked out side by side (contact_lanes.h) */

static void *default_alloc(void *ctx, size_t size)
{
    (void)ctx;
    return malloc(size);
}

static void default_release(void *ctx, void *block)
{
    (void)ctx;
    free(block);
}

stein_sim_def stein_sim_def_default(const stein_model *model)
{
    return (stein_sim_def){.integrator = (stein_integrator)model->integrator,
                           .dt = model->dt,
                           .alloc = default_alloc,
                           .release = default_release,
                           .ctx = NULL};
}

static stein_status check_def(const stein_model *model, const stein_sim_def *def, stein_err *err)
{
    if (model->abi != STEIN_MODEL_ABI) {
        return stein__fail(err, STEIN_ESTALE,
                           "model \"%s\" was generated for layout %d, this library reads %d: "
                           "regenerate it",
                           model->name, model->abi, STEIN_MODEL_ABI);
    }
    if (def->integrator != STEIN_RK4 && def->integrator != STEIN_DP5 &&
        !stein__is_controlled(def->integrator)) {
        return stein__fail(err, STEIN_EINVAL,
                           "stein_sim_def.integrator is %d: expected STEIN_RK4, STEIN_DP5, "
                           "STEIN_CONTROLLED or STEIN_IMPLICIT",
                           (int)def->integrator);
    }
    if (!(def->dt > 0.0) || !isfinite(def->dt)) {
        return stein__fail(err, STEIN_EINVAL, "stein_sim_def.dt is %g s: expected a positive step",
                           def->dt);
    }
    if (def->alloc == NULL || def->release == NULL) {
        return stein__fail(err, STEIN_EINVAL,
                           "stein_sim_def.%s is NULL: start from "
                           "stein_sim_def_default()",
                           def->alloc == NULL ? "alloc" : "release");
    }
    return STEIN_OK;
}

stein_status stein__take_def(stein_sim_def *to, const stein_model *model, const stein_sim_def *def,
                             stein_err *err)
{
    *to = def != NULL ? *def : stein_sim_def_default(model);
    return check_def(model, to, err);
}

void stein__take_parameters(stein_sim *sim)
{
    const stein_model *model = sim->model;
    stein_setup(model, sim->p, sim->d);
    stein__tables_prepare(sim);
    stein__pairs_prepare(sim);
    stein__joints_prepare(sim);
    sim->fresh = STALE;
    sim->taken++;
}

stein_status stein_sim_create(stein_sim **out, const stein_model *model, const stein_sim_def *def,
                              stein_err *err)
{
    stein_sim_def own;
    stein_status status = stein__take_def(&own, model, def, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (int i = 0; i < model->np; i++) {
        status = stein__check_param(&model->params[i], model->params[i].value, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    size_t alone = stein__layout(NULL, model), more = stein__implicit_size(model, own.integrator);
    size_t size = alone + more;
    stein_sim *sim = own.alloc(own.ctx, size);
    if (sim == NULL) {
        return stein__fail(err, STEIN_ENOMEM, "out of memory for a simulation of \"%s\"",
                           model->name);
    }
    if ((uintptr_t)sim % ALIGNED != 0) {
        own.release(own.ctx, sim);
        return stein__fail(err, STEIN_EINVAL,
                           "alloc returned a block that does not begin at a multiple of %d bytes",
                           ALIGNED);
    }
    memset(sim, 0, size);
    sim->model = model;
    sim->def = own;
    sim->tolerance = STEIN_TOLERANCE;
    (void)stein__layout(sim, model);
    if (more > 0) {
        stein__implicit_make(sim, (unsigned char *)sim + alone);
    }
    for (int i = 0; i < model->np; i++) {
        sim->p[i] = model->params[i].value;
    }
    sim->pose[-1] = (stein_pose){.c = 1.0};
    sim->pose3[-1] = (stein_pose3){.R = {[0] = 1.0, [4] = 1.0, [8] = 1.0}};
    for (int j = 0; j < model->nq; j++) {
        sim->parent[j] = model->bodies[j].parent;
    }
    stein__gather(sim);
    stein__take_parameters(sim);
    stein__wire(sim);
    status = stein_reset(sim, err);
    if (status != STEIN_OK) {
        stein_sim_destroy(sim);
        return status;
    }
    *out = sim;
    return STEIN_OK;
}

void stein_sim_destroy(stein_sim *sim)
{
    if (sim != NULL) {
        if (sim->follower != NULL) {
            sim->on_end(sim->follower);
        }
        sim->def.release(sim->def.ctx, sim);
    }
}

const stein_model *stein_sim_model(const stein_sim *sim)
{
    return sim->model;
}

/* ---- names ---- */

#define FIND(function, table, count)                         \
    int function(const stein_model *model, const char *name) \
    {                                                        \
        for (int i = 0; i < model->count; i++) {             \
            if (strcmp(model->table[i].name, name) == 0) {   \
                return i;                                    \
            }                                                \
        }                                                    \
        return -1;                                           \
    }

FIND(stein_find_param, params, np)
FIND(stein_find_channel, channels, nchannel)
FIND(stein_find_input, inputs, ninput)
FIND(stein_find_contact, contacts, ncontact)
FIND(stein_find_body, bodies, nq)
#undef FIND

/* ---- parameters ---- */

static int in_range(stein_range range, double x)
{
    switch (range) {
    case STEIN_NOT_NEGATIVE: return x >= 0.0;
    case STEIN_POSITIVE: return x > 0.0;
    case STEIN_WEDGE: return x > 0.0 && x < 3.14159265358979323846;
    default: return 1;
    }
}

stein_status stein__check_param(const stein_param *param, double value, stein_err *err)
{
    static const char *const expected[] = {"a finite number", "a finite number, at least 0",
                                           "a finite number, more than 0",
                                           "more than 0 and less than 3.14159 (180 deg)"};
    if (isfinite(value) && in_range(param->range, value)) {
        return STEIN_OK;
    }
    int pure = strcmp(param->unit, "1") == 0;
    return stein__fail(err, STEIN_EINVAL, "parameter \"%s\" cannot be %g%s%s: expected %s",
                       param->name, value, pure ? "" : " ", pure ? "" : param->unit,
                       expected[param->range]);
}

stein_status stein_set(stein_sim *sim, const char *name, double value, stein_err *err)
{
    int i = stein_find_param(sim->model, name);
    if (i < 0) {
        return stein__fail(err, STEIN_ENAME,
                           "no parameter \"%s\" in model \"%s\" (a zero that shaped "
                           "the equations is none: regenerate them)",
                           name, sim->model->name);
    }
    stein_status status = stein__check_param(&sim->model->params[i], value, err);
    if (status != STEIN_OK) {
        return status;
    }
    sim->p[i] = value;
    stein__take_parameters(sim);
    return STEIN_OK;
}

stein_status stein_set_all(stein_sim *sim, const double *p, stein_err *err)
{
    for (int i = 0; i < sim->model->np; i++) {
        stein_status status = stein__check_param(&sim->model->params[i], p[i], err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    return stein_try_all(sim, p, err);
}

stein_status stein_try_all(stein_sim *sim, const double *p, stein_err *err)
{
    for (int i = 0; i < sim->model->np; i++) {
        stein_param param = sim->model->params[i];
        param.range = STEIN_ANY;
        stein_status status = stein__check_param(&param, p[i], err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    memcpy(sim->p, p, sizeof *p * (size_t)sim->model->np);
    stein__take_parameters(sim);
    return STEIN_OK;
}

stein_status stein_get(const stein_sim *sim, const char *name, double *value, stein_err *err)
{
    int i = stein_find_param(sim->model, name);
    if (i < 0) {
        return stein__fail(err, STEIN_ENAME, "no parameter \"%s\" in model \"%s\"", name,
                           sim->model->name);
    }
    *value = sim->p[i];
    return STEIN_OK;
}

/* ---- state ---- */

stein_status stein_reset(stein_sim *sim, stein_err *err)
{
    const stein_model *model = sim->model;
    stein__state_clear(sim);
    sim->head->load_present = 1;
    sim->eq = sim->eqd = -1.0;
    sim->fresh = STALE;
    for (int j = 0; j < model->nq; j++) {
        sim->q[j] = sim->d[model->initial + 2 * j];
        sim->qd[j] = sim->d[model->initial + 2 * j + 1];
    }
    stein__spin_up(sim);
    stein__place_driven(sim);
    stein_status status = model->nrow > 0 ? stein__loops_assemble(sim, 1, err) : STEIN_OK;
    if (status == STEIN_OK) {
        status = stein__settle(sim, err);
    }
    if (status == STEIN_OK) {
        stein__stick_begin(sim);
        status = stein__refresh(sim, err);
    }
    for (int j = 0; status == STEIN_OK && j < model->nq; j++) {
        if (!isfinite(sim->q[j]) || !isfinite(sim->qdd[j])) {
            status = stein__fail(err, STEIN_ENONFINITE,
                                 "the initial state of joint \"%s\" is not "
                                 "finite",
                                 model->bodies[j].name);
        }
    }
    if (status == STEIN_OK) {
        stein__note_rest(sim);
    }
    return status;
}

double stein_time(const stein_sim *sim)
{
    return sim->head->t;
}

double stein_dt(const stein_sim *sim)
{
    return sim->def.dt;
}

const double *stein_q(const stein_sim *sim)
{
    return sim->q;
}

const double *stein_qd(const stein_sim *sim)
{
    return sim->qd;
}

const double *stein_qdd(stein_sim *sim)
{
    return stein__refresh(sim, NULL) == STEIN_OK ? sim->qdd : NULL;
}

void stein_load_lift(stein_sim *sim)
{
    const stein_load *load = &sim->model->load;
    if (load->body < 0) {
        return;
    }
    const stein_contact *contact = &sim->model->contacts[load->contact];
    sim->head->load_present = 0;
    sim->held[load->body] = 1;
    sim->qd[load->body] = 0.0;
    memset(sim->mode + contact->first_spot, 0, (size_t)contact->nspot);
    sim->fresh = STALE;
}

int stein_load_present(const stein_sim *sim)
{
    return sim->model->load.body >= 0 && sim->head->load_present;
}

/* ---- hooks ---- */

void stein_on_event(stein_sim *sim, stein_event_fn *fn, void *ctx)
{
    sim->on_event = fn;
    sim->event_ctx = ctx;
}

void stein_on_force(stein_sim *sim, stein_force_fn *fn, void *ctx)
{
    sim->on_force = fn;
    sim->force_ctx = ctx;
    sim->fresh = STALE;
}

stein_status stein_drive(stein_sim *sim, const char *input, stein_signal_fn *fn, void *ctx,
                         stein_err *err)
{
    int i = stein_find_input(sim->model, input);
    if (i < 0) {
        return stein__fail(err, STEIN_ENAME, "no input \"%s\" in model \"%s\"", input,
                           sim->model->name);
    }
    sim->signal[i] = fn;
    sim->signal_ctx[i] = ctx;
    sim->ustate[3 * i] = sim->ustate[3 * i + 1] = sim->ustate[3 * i + 2] = 0.0;
    stein__wire(sim);
    sim->fresh = STALE;
    return STEIN_OK;
}

/* ---- equations ---- */

void stein_setup(const stein_model *model, const double *p, double *d)
{
    static const stein_functions functions = {stein__sin, stein__cos, stein__tan};
    model->setup(p, d, &functions);
}

void stein_turn(const stein_model *model, const double *q, double *sc)
{
    for (int j = 0; j < model->nq; j++) {
        if (model->bodies[j].type == 'R') {
            stein__sincos(q[j], &sc[2 * j], &sc[2 * j + 1]);
        }
    }
}

/* sines and cosines of q, beside those of the state */
static const double *turned(stein_sim *sim, const double *q)
{
    stein_turn(sim->model, q, sim->sc_asked);
    return sim->sc_asked;
}

void stein_mass_bias(stein_sim *sim, const double *q, const double *qd, const double *frc,
                     const double *trq, double *M, double *c)
{
    const double *sc = turned(sim, q);
    if (frc == NULL && trq == NULL) {
        sim->model->unloaded(q, qd, sc, sim->d, M, c);
    } else {
        sim->model->mass_bias(q, qd, sc, sim->d, frc != NULL ? frc : sim->zero,
                              trq != NULL ? trq : sim->zero, M, c);
    }
}

void stein_inverse(stein_sim *sim, const double *q, const double *qd, const double *qdd,
                   const double *frc, const double *trq, double *Q)
{
    sim->model->inverse(q, qd, qdd, turned(sim, q), sim->d, frc != NULL ? frc : sim->zero,
                        trq != NULL ? trq : sim->zero, Q);
}

static void copy_out(double *out, const double *from, int n)
{
    if (out != NULL) {
        memcpy(out, from, sizeof *from * (size_t)n);
    }
}

void stein_points(stein_sim *sim, const double *q, const double *qd, double *x, double *v,
                  double *J, double *jdqd)
{
    const stein_model *model = sim->model;
    if (model->npoint == 0) {
        return;
    }
    model->point(q, qd, turned(sim, q), sim->d, sim->px, sim->pv, sim->pJ, sim->pa);
    copy_out(x, sim->px, 3 * model->npoint);
    copy_out(v, sim->pv, 3 * model->npoint);
    copy_out(J, sim->pJ, 3 * model->npoint * model->nq);
    copy_out(jdqd, sim->pa, 3 * model->npoint);
    sim->fresh = STALE;
}

void stein_energy(stein_sim *sim, const double *q, const double *qd, double *kinetic,
                  double *potential)
{
    double e[2];
    sim->model->energy(q, qd, turned(sim, q), sim->d, e);
    *kinetic = e[0];
    *potential = e[1];
}

stein_status stein_acceleration(stein_sim *sim, double t, const double *q, const double *qd,
                                double *qdd, stein_err *err)
{
    sim->fresh = STALE;
    return stein__evaluate(sim, t, q, qd, qdd, err);
}
