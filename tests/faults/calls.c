/* SPDX-License-Identifier: GPL-3.0-or-later
 * calls.c - calls of core, reader and generator.
 */
#include <stdlib.h>
#include <string.h>

#include "faults.h"
#include "stein/batch.h"
#include "stein/derivative.h"
#include "stein/handover.h"
#include "stein/identity.h"
#include "stein/models.h"
#include "stein/sensitivity.h"

/* ---- core ---- */

static stein_status call_create(uint64_t *result, stein_err *err)
{
    stein_sim *sim = NULL;
    stein_status status = stein_sim_create(&sim, &stein_model_stein1788, NULL, err);
    if (status == STEIN_OK) {
        *result = stein_hash_numbers(STEIN_HASH, stein_q(sim), 4);
    }
    if (status != STEIN_OK && sim != NULL) {
        *result = 0; // a simulation in spite of an error: told as a wrong result
        status = STEIN_OK;
    }
    stein_sim_destroy(status == STEIN_OK ? sim : NULL);
    return status;
}

/* derivatives of a place, and of a stroke */
static stein_status call_derivative(uint64_t *result, stein_err *err)
{
    stein_derivative *d = NULL;
    stein_sensitivity *s = NULL;
    stein_sim *sim = NULL;
    double by_p[8] = {0.0};
    const stein_model *m = &stein_model_pendulum;
    stein_status status = stein_sim_create(&sim, m, NULL, err);
    status = status == STEIN_OK ? stein_derivative_create(&d, m, NULL, err) : status;
    status = status == STEIN_OK
                 ? stein_derivative_at(d, sim, 0.0, stein_q(sim), stein_qd(sim), NULL, err)
                 : status;
    if (status == STEIN_OK) {
        stein_derivative_by_parameter(d, 0, by_p);
    }
    status = status == STEIN_OK ? stein_sensitivity_create(&s, m, NULL, 2, err) : status;
    status = status == STEIN_OK ? stein_sensitivity_attach(s, sim, err) : status;
    status = status == STEIN_OK ? stein_run(sim, 0.01, err) : status;
    *result = stein_hash_numbers(STEIN_HASH, by_p, 8);
    stein_sensitivity_destroy(s);
    stein_derivative_destroy(d);
    stein_sim_destroy(sim);
    return status;
}

/* simulations side by side, and parameters from another thread */
static stein_status call_batch(uint64_t *result, stein_err *err)
{
    enum { RIDERS = 3 };
    static const double until[RIDERS] = {0.004, 0.002, 0.003};
    stein_sim *sim[RIDERS] = {NULL};
    stein_batch *batch = NULL;
    stein_handover *from = NULL;
    const stein_model *m = &stein_model_stein1788;
    stein_status status = stein_batch_create(&batch, m, NULL, RIDERS, 0, err);
    status = status == STEIN_OK ? stein_handover_create(&from, m, NULL, err) : status;
    for (int i = 0; status == STEIN_OK && i < RIDERS; i++) {
        status = stein_sim_create(&sim[i], m, NULL, err);
        status = status == STEIN_OK ? stein_batch_put(batch, i, sim[i], err) : status;
    }
    status = status == STEIN_OK ? stein_batch_run(batch, until, NULL, err) : status;
    *result = STEIN_HASH;
    for (int i = 0; status == STEIN_OK && i < RIDERS; i++) {
        *result = stein_hash_numbers(*result, stein_q(stein_batch_sim(batch, i)), 4);
    }
    stein_handover_destroy(from);
    stein_batch_destroy(batch);
    for (int i = 0; i < RIDERS; i++) {
        stein_sim_destroy(sim[i]);
    }
    return status;
}

/* ---- reader, generator, equations ---- */

static stein_status call_read(uint64_t *result, stein_err *err)
{
    mechanism *m = NULL;
    mech_set set = {"load.mass", "90 g"};
    stein_status status = mech_read(&m, "models/stein1788.yaml", &set, 1, NULL, NULL, err);
    if (status == STEIN_OK) {
        *result = (uint64_t)m->nparam;
        mech_free(m);
    }
    return status;
}

/* every section that no file of models/ has beside others, formulas and a tolerance */
static stein_status call_sections(uint64_t *result, stein_err *err)
{
    static const char text[] =
        "mechanism: m\n"
        "parameters: {rod.shift: {value: 1.5 mm +- 0.1 mm, about: of the tip}}\n"
        "bodies:\n"
        "  rod:\n    joint: R -y\n    mass: 2 kg\n    centre: [0, 0, -100 mm - rod.shift]\n"
        "    pendulum: {frequency: 1.3 Hz, gravity: 9.8 m/s^2}\n    spring: {k: 1 N m/rad}\n"
        "    points: {tip: [0, 0, 2 * rod.shift - 0.3 m]}\n"
        "  bob:\n    part_of: rod\n    joint: R -y\n    mass: 90 g +- 1 %\n"
        "    centre: [1 mm, 0, -0.2 m]\n    inertia: {yy: 1e-5 kg m^2}\n"
        "  cart: {joint: T x, mass: 1 kg, friction: {A: 0.2 N, vt: 1 mm/s}}\n"
        "points: {wall: [1 m, 0, 0]}\n"
        "links: {tie: {from: frame.wall, to: rod.tip, k: 93 N/m, length: 0.1 m}}\n"
        "tables: {brake: {joint: cart, of: speed, at: [0, 1 mm/s], force: [0, -2 N]}}\n"
        "inputs: {push: {force: rod.tip, direction: [1, 0, 0]}}\n"
        "outputs: {x: {joint: cart, read: position}, e: {energy: kinetic}}\n"
        "regulation: {rod.shift: {from: 0 mm, to: 2 mm}}\n";
    mechanism *m = NULL;
    stein_status status = mech_read_text(&m, "m", text, sizeof text - 1, NULL, 0, NULL, NULL, err);
    if (status == STEIN_OK) {
        *result = (uint64_t)(m->nparam + 1000 * m->nformula);
        mech_free(m);
    }
    return status;
}

static void hear(void *ctx, const char *message)
{
    uint64_t *hash = ctx;
    *hash = lab__hash(*hash, message, strlen(message));
}

/* problems of a bad file; no memory may hide some of them, so the outcome is the code alone */
static stein_status call_problems(uint64_t *result, stein_err *err)
{
    static const char text[] = "mechanism: m\nbodies: {a: {joint: Q q, mass: 3 m, x: {y: [1]}}}\n";
    mechanism *m = NULL;
    uint64_t heard = STEIN_HASH;
    stein_status status =
        mech_read_text(&m, "m", text, sizeof text - 1, NULL, 0, hear, &heard, err);
    *result = heard;
    return status == STEIN_EPARSE ? STEIN_OK : status;
}

static stein_status call_generate(uint64_t *result, stein_err *err)
{
    gen_result r;
    stein_status status = gen_equations(&r, lab__mechanism(thing->pendulum), err);
    if (status == STEIN_OK) {
        *result = lab__hash(STEIN_HASH, r.source, r.size);
        gen_free(&r);
    }
    return status;
}

static stein_status call_open(uint64_t *result, stein_err *err)
{
    lab_model *model = NULL;
    stein_status status = lab_open(&model, "models/pendulum.yaml", NULL, err);
    if (status == STEIN_OK) {
        const stein_model *m = lab_equations(model);
        *result = stein_hash_numbers(STEIN_HASH, lab_parameters(model), m->np);
        lab_close(model);
    }
    return status;
}

/* equations that were compiled later */
static stein_status call_compiled(uint64_t *result, stein_err *err)
{
    lab_model *model = NULL;
    lab_options options = files_options();
    stein_status status = lab_open(&model, thing->rotor_yaml, &options, err);
    *result = status == STEIN_OK ? (uint64_t)lab_equations(model)->np : 0;
    lab_close(model);
    return status;
}

const call_entry calls_core[] = {{"create", call_create, 0},     {"derivative", call_derivative, 0},
                                 {"batch", call_batch, 0},       {"read", call_read, 0},
                                 {"problems", call_problems, 0}, {"sections", call_sections, 0},
                                 {"generate", call_generate, 1}, {"open", call_open, 0},
                                 {"compiled", call_compiled, 0}, {NULL, NULL, 0}};
