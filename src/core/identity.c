/* SPDX-License-Identifier: MIT
 * identity.c - one hash of standard motions (identity.h).
 *
 * It has to notice whatever may differ between two builds: a product fused with a sum, a sum in
 * another order, a function of another libm, a table read from the wrong end. So it goes through
 * every function of the core that computes, with numbers that use all bits of a double. What a run
 * fails with, and when, is part of the hash as well.
 */
#include <math.h>
#include <string.h>

#include "core.h"
#include "stein/identity.h"

enum { FUNCTIONS = 20000, POSES = 20, STEPS = 400, PER_READING = 8, BODIES = 64 };

unsigned long long stein_hash_numbers(unsigned long long hash, const double *x, int n)
{
    for (int i = 0; i < n; i++) {
        uint64_t bits = 0x7ff8000000000000u;
        if (!isnan(x[i])) {
            memcpy(&bits, &x[i], sizeof bits);
        }
        for (int byte = 0; byte < 8; byte++, bits >>= 8) {
            hash = (hash ^ (bits & 0xff)) * 1099511628211ull;
        }
    }
    return hash;
}

typedef struct hasher {
    unsigned long long hash, seed;
} hasher;

static void add(hasher *h, double x)
{
    h->hash = stein_hash_numbers(h->hash, &x, 1);
}

static void add_all(hasher *h, const double *x, int n)
{
    h->hash = stein_hash_numbers(h->hash, x, n);
}

/* numbers in [-1, 1) (splitmix64) */
static double draw(hasher *h)
{
    unsigned long long z = (h->seed += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-52 - 1.0;
}

static void hash_functions(hasher *h)
{
    for (int i = 0; i < FUNCTIONS; i++) {
        static const double range[] = {1.0, 30.0, 1e5, 1e12, 1e300};
        double x = range[i % 5] * draw(h), positive = stein__exp(i % 2 ? 700.0 * x : 3.0 * x), s, c;
        stein__sincos(x, &s, &c);
        add(h, s);
        add(h, c);
        add(h, stein__tan(x));
        add(h, stein__tanh(x));
        add(h, positive);
        add(h, stein__log(positive));
        add(h, stein__power(positive, draw(h)));
    }
}

/* the equations at places of their own; the block of joints fits every mechanism that is here */
static void hash_equations(hasher *h, stein_sim *sim)
{
    const stein_model *m = sim->model;
    int n = m->nq;
    double q[BODIES], qd[BODIES], qdd[BODIES], Q[BODIES], outer[2][3 * BODIES], energy[2];
    for (int k = 0; n <= BODIES && k < POSES; k++) {
        for (int j = 0; j < n; j++) {
            q[j] = 3.0 * draw(h);
            qd[j] = 10.0 * draw(h);
            qdd[j] = 100.0 * draw(h);
        }
        for (int j = 0; j < 3 * n; j++) {
            outer[0][j] = draw(h);
            outer[1][j] = draw(h);
        }
        stein_mass_bias(sim, q, qd, outer[0], outer[1], sim->M, sim->c);
        add_all(h, sim->M, n * n);
        add_all(h, sim->c, n);
        stein_inverse(sim, q, qd, qdd, outer[0], outer[1], Q);
        add_all(h, Q, n);
        stein_energy(sim, q, qd, &energy[0], &energy[1]);
        add_all(h, energy, 2);
        stein_points(sim, q, qd, NULL, NULL, NULL, NULL);
        add_all(h, sim->px, 3 * m->npoint);
        add_all(h, sim->pv, 3 * m->npoint);
        add_all(h, sim->pJ, 3 * m->npoint * n);
        add_all(h, sim->pa, 3 * m->npoint);
    }
}

static void hash_state(hasher *h, stein_sim *sim)
{
    add(h, stein_time(sim));
    add_all(h, sim->q, sim->model->nq);
    add_all(h, sim->qd, sim->model->nq);
}

static void hash_readings(hasher *h, stein_sim *sim)
{
    for (int i = 0; i < sim->model->nchannel; i++) {
        add(h, stein_read(sim, i));
    }
}

static void hash_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    hasher *h = ctx;
    add(h, event->time);
    add(h, (double)((int)event->kind + 16 * event->index + 4096 * event->phase));
    hash_state(h, sim);
}

static double look(void *ctx, stein_sim *sim)
{
    hash_state(ctx, sim);
    hash_readings(ctx, sim);
    return stein_time(sim) + 0.37e-3;
}

/* a stroke in full, of anything else the first steps; then the rest with controlled ones */
static void hash_run(hasher *h, stein_sim *sim)
{
    stein_status status = stein_reset(sim, NULL);
    double until = 0.1;
    hash_state(h, sim);
    stein_on_event(sim, hash_event, h);
    int steps = sim->model->stroke.string >= 0 ? (int)(until / sim->def.dt) : STEPS;
    for (int k = 0; status == STEIN_OK && k < steps; k++) {
        status = stein_step(sim, NULL);
        hash_state(h, sim);
        if (k % PER_READING == 0) {
            hash_readings(h, sim);
        }
    }
    if (status == STEIN_OK && sim->def.integrator == STEIN_DP5) {
        stein_pace pace = {.tolerance = 1e-8,
                           .longest = 2e-3,
                           .h = 1e-4,
                           .next = stein_time(sim),
                           .look = look,
                           .ctx = h};
        status = stein_run_adaptive(sim, stein_time(sim) + until, &pace, NULL);
        add(h, pace.h);
    }
    stein_on_event(sim, NULL, NULL);
    add(h, (double)status);
    hash_state(h, sim);
}

/* every number a little off, none of them neutral, in or out of its range */
static void disturb(hasher *h, stein_sim *sim)
{
    const stein_model *m = sim->model;
    for (int i = 0; i < m->np; i++) {
        double value = sim->p[i], change = draw(h);
        sim->p[i] = value != 0.0 ? value * (1.0 + 1e-3 * change) : 1e-5 * change;
    }
    stein__take_parameters(sim);
}

static stein_status hash_model(hasher *h, const stein_model *model, stein_err *err)
{
    static const stein_integrator integrator[] = {STEIN_RK4, STEIN_DP5};
    for (int i = 0; i < 2; i++) {
        stein_sim_def def = stein_sim_def_default(model);
        stein_sim *sim;
        def.integrator = integrator[i];
        stein_status status = stein_sim_create(&sim, model, &def, err);
        if (status != STEIN_OK) {
            return status;
        }
        hash_equations(h, sim);
        hash_run(h, sim);
        disturb(h, sim);
        hash_equations(h, sim);
        hash_run(h, sim);
        stein_sim_destroy(sim);
    }
    return STEIN_OK;
}

stein_status stein_identity(const stein_model *const *models, unsigned long long *hash,
                            stein_err *err)
{
    hasher h = {STEIN_HASH, 1788};
    stein_status status = STEIN_OK;
    hash_functions(&h);
    for (int i = 0; status == STEIN_OK && models[i] != NULL; i++) {
        status = hash_model(&h, models[i], err);
    }
    if (status == STEIN_OK) {
        *hash = h.hash;
    }
    return status;
}
