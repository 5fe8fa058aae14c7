/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_derivative_places.c - derivatives of qdd with contacts, laws, links, tables and inputs, at
 * places, against differences; by all at once against along one direction; refusals.
 */
#include <string.h>

#include "derivative_support.h"
#include "lab_support.h"

void derivative_places_cases(Suite *suite);

static double worst;

/* ---- qdd with contacts, by differences ------------------------------------------------------- */

/* qdd as a function of one number of the place */
typedef struct probe {
    stein_sim *sim;
    double t, q[MOST], qd[MOST], p[512];
    double *moved;
} probe;

static void qdd_of(void *ctx, double x, double *qdd)
{
    probe *k = ctx;
    double kept = *k->moved;
    *k->moved = x;
    ck_assert_stein(stein_try_all(k->sim, k->p, err));
    ck_assert_stein(stein_acceleration(k->sim, k->t, k->q, k->qd, qdd, err));
    *k->moved = kept;
}

static probe *probe_new(stein_sim *sim)
{
    const stein_model *model = stein_sim_model(sim);
    probe *k = calloc(1, sizeof *k);
    ck_assert(k != NULL && model->nq <= MOST && model->np <= 512);
    k->sim = sim;
    k->t = stein_time(sim);
    memcpy(k->q, stein_q(sim), sizeof *k->q * (size_t)model->nq);
    memcpy(k->qd, stein_qd(sim), sizeof *k->qd * (size_t)model->nq);
    for (int i = 0; i < model->np; i++) {
        ck_assert_stein(stein_get(sim, model->params[i].name, &k->p[i], err));
    }
    return k;
}

/* a step that leaves touches touching and stays far below what bends a law */
static double step_of(const stein_param *param, double value)
{
    double step = value != 0.0 ? 0.01 * fabs(value) : 1e-3;
    return strcmp(param->unit, "m") == 0 ? 4e-6 : strcmp(param->unit, "rad") == 0 ? 2e-5 : step;
}

/* differences are accurate to `rtol` of themselves and of the change of qdd in one step */
static void assert_slope(probe *k, const char *what, double *moved, double h, const double *slope,
                         double rtol)
{
    int n = stein_sim_model(k->sim)->nq;
    double expected[MOST], qdd[MOST], size = 0.0, change = 0.0;
    k->moved = moved;
    differences(qdd_of, k, *moved, h, n, expected);
    qdd_of(k, *moved, qdd);
    for (int i = 0; i < n; i++) {
        size = fmax(size, fabs(qdd[i]));
        change = fmax(change, fabs(expected[i]));
    }
    for (int i = 0; i < n; i++) {
        double off = fabs(slope[i] - expected[i]), bound = rtol * change + 1e-12 * size / h;
        ck_assert_msg(off <= bound, "qdd[%d] by %s: %.15g, by differences %.15g (bound %.3g)", i,
                      what, slope[i], expected[i], bound);
        worst = change > 0.0 ? fmax(worst, off / bound) : worst;
    }
}

static void column(const double *matrix, int n, int j, double *out)
{
    for (int i = 0; i < n; i++) {
        out[i] = matrix[i * n + j];
    }
}

/* the derivative along all is the sum of derivatives along each, to rounding */
static void check_along(stein_derivative *s, const double *by_q, const double *by_qd, int n)
{
    double size = 0.0;
    for (int i = 0; i < n * n; i++) {
        size = fmax(size, fmax(fabs(by_q[i]), fabs(by_qd[i])));
    }
    for (int j = 0; j < 2 * n; j++) {
        double way[2 * MOST] = {0.0}, dqdd[MOST];
        way[j] = 1.0;
        stein_derivative_along(s, way, way + n, NULL, dqdd);
        for (int i = 0; i < n; i++) {
            double is = (j < n ? by_q : by_qd)[i * n + j % n];
            ck_assert_close(is, dqdd[i], 1e-12, 1e-14 * size);
        }
    }
}

/* a parameter that derivatives leave out: the delay of an input's signal */
static int is_delay(const stein_model *model, int param)
{
    for (int i = 0; i < model->ninput; i++) {
        size_t n = strlen(model->inputs[i].name);
        if (strncmp(model->params[param].name, model->inputs[i].name, n) == 0 &&
            strcmp(model->params[param].name + n, ".delay") == 0) {
            return 1;
        }
    }
    return 0;
}

/* by every q, qd and parameter at the state of a simulation */
static void check_place(stein_sim *sim, double rtol)
{
    const stein_model *model = stein_sim_model(sim);
    int n = model->nq;
    stein_derivative *s = NULL;
    probe *k = probe_new(sim);
    double qdd[MOST], same[MOST], by_q[MOST * MOST], by_qd[MOST * MOST], one[MOST];
    ck_assert_stein(stein_derivative_create(&s, model, NULL, err));
    ck_assert_stein(stein_acceleration(sim, k->t, k->q, k->qd, qdd, err));
    ck_assert_stein(stein_derivative_at(s, sim, k->t, k->q, k->qd, same, err));
    ck_assert_mem_eq(qdd, same, sizeof *qdd * (size_t)n);
    stein_derivative_by_state(s, by_q, by_qd);
    check_along(s, by_q, by_qd, n);
    for (int j = 0; j < n; j++) {
        char what[64];
        column(by_q, n, j, one);
        snprintf(what, sizeof what, "q of %s", model->bodies[j].name);
        assert_slope(k, what, &k->q[j], 4e-6, one, rtol);
        column(by_qd, n, j, one);
        snprintf(what, sizeof what, "qd of %s", model->bodies[j].name);
        assert_slope(k, what, &k->qd[j], 1e-4, one, rtol);
    }
    for (int i = 0; i < model->np; i++) {
        if (is_delay(model, i)) {
            continue;
        }
        ck_assert_stein(stein_try_all(sim, k->p, err));
        ck_assert_stein(stein_derivative_at(s, sim, k->t, k->q, k->qd, NULL, err));
        stein_derivative_by_parameter(s, i, one);
        assert_slope(k, model->params[i].name, &k->p[i], step_of(&model->params[i], k->p[i]), one,
                     rtol);
    }
    ck_assert_stein(stein_try_all(sim, k->p, err));
    stein_derivative_destroy(s);
    free(k);
}

START_TEST(action_with_all_contacts_closed)
{
    stein_sim *sim = all_closed();
    for (int i = 0; i < stein_model_stein1788.ncontact; i++) {
        ck_assert_msg(stein_touches(sim, i), "%s", stein_model_stein1788.contacts[i].name);
    }
    ck_assert_int_eq(stein_notch_phase(sim, 0), 2);
    worst = 0.0;
    check_place(sim, 1e-8);
    printf("qdd with all contacts closed: %.2g of the bound\n", worst);
    stein_sim_destroy(sim);
}
END_TEST

/* every effect of every law is on */
START_TEST(action_with_every_effect_of_every_law)
{
    static const struct {
        const char *end;
        double value;
    } effects[] = {{"normal.p", 0.13},         {"normal.h", 0.17},   {".gap", 0.7e-6},
                   {"normal.F0", 0.043},       {"adhesion.F", 0.21}, {"adhesion.range", 1.3e-4},
                   {"friction.B1", 0.29},      {"spring.k3", 0.021}, {".preload", 1.7e-3},
                   {".drag", 2.3e-5},          {".damping", 1.1e-5}, {"coulomb.T", 3.1e-5},
                   {"coulomb.asymmetry", 0.2}, {".asymmetry", 0.31}, {"backlash.k", 0.07},
                   {"corner.lean", 0.01}};
    const stein_model *model = &stein_model_stein1788;
    stein_sim *sim = all_closed();
    for (int i = 0; i < model->np; i++) {
        const char *name = model->params[i].name;
        for (size_t k = 0; k < sizeof effects / sizeof *effects; k++) {
            size_t n = strlen(name), m = strlen(effects[k].end);
            if (n > m && strcmp(name + n - m, effects[k].end) == 0 &&
                model->params[i].value == 0.0 && strstr(name, "backlash.gap") == NULL) {
                ck_assert_stein(stein_set(sim, name, effects[k].value, err));
                break;
            }
        }
    }
    check_place(sim, 1e-7);
    stein_sim_destroy(sim);
}
END_TEST

/* closed contacts in a running stroke, and the load away or in the air */
START_TEST(mechanisms_on_their_way)
{
    for (int i = 0; stein_models[i] != NULL; i++) {
        const stein_model *model = stein_models[i];
        if (model->nstick > 0) {
            stein_derivative *s = NULL;
            stein_err err = {STEIN_OK, ""};
            ck_assert_int_eq(stein_derivative_create(&s, model, NULL, &err), STEIN_EINVAL);
            ck_assert_ptr_nonnull(strstr(err.msg, "friction that sticks"));
        }
        // loops and bodies in space are refused, see test_loops.c, test_space.c
        if (model->nrow > 0 || model->nstick > 0 || model->nball > 0) {
            continue;
        }
        stein_sim *sim = make_sim(model, STEIN_RK4, 0.0);
        for (int k = 1; k <= 3; k++) {
            ck_assert_stein(stein_run(sim, 0.0173 * k, err));
            check_place(sim, 1e-6);
        }
        stein_load_lift(sim);
        check_place(sim, 1e-6);
        stein_sim_destroy(sim);
    }
}
END_TEST

/* links, tables, two circles, a force at a point, a joint that follows a signal */
static const char parts[] = "mechanism: allparts\n"
                            "bodies:\n"
                            "  lever:\n"
                            "    joint: R -y\n"
                            "    mass: 0.31 kg\n"
                            "    centre: [0.07, 0, 0.02]\n"
                            "    inertia: {yy: 2.3e-3}\n"
                            "    initial: {position: 0.21, speed: -0.6}\n"
                            "    friction: {A: 0.03, vt: 0.2, B1: 0.5, B2: 0.3}\n"
                            "    points: {tip: [0.2, 0, 0.02]}\n"
                            "  sled:\n"
                            "    joint: T x\n"
                            "    at: [0.11, 0, 0.05]\n"
                            "    mass: 0.3\n"
                            "    initial: {position: 0.013, speed: 0.2}\n"
                            "  rise:\n"
                            "    parent: sled\n"
                            "    joint: R y\n"
                            "    mass: 0.12\n"
                            "    centre: [0.03, 0, 0.01]\n"
                            "    inertia: {yy: 1e-4}\n"
                            "    initial: {position: 0.3, speed: 0.4}\n"
                            "  piston:\n"
                            "    parent: rise\n"
                            "    joint: T -z\n"
                            "    at: [0.02, 0, 0]\n"
                            "    mass: 0.2\n"
                            "    initial: {position: -0.01, speed: 0.1}\n"
                            "    points: {end: [0.04, 0, 0.01]}\n"
                            "points: {anchor: [0.5, 0, 0.2]}\n"
                            "contacts:\n"
                            "  balls:\n"
                            "    between:\n"
                            "      - {circle: {on: lever, at: [0.1, 0, 0.03], radius: 0.04}}\n"
                            "      - {circle: {on: piston, at: [0, 0, 0.01], radius: 0.06}}\n"
                            "    normal: {a: 3e4, b: 2e3, c: 1e2, D: 0.5}\n"
                            "    friction: {A: 0.3, vt: 0.05}\n"
                            "  plank:\n"
                            "    between:\n"
                            "      - {circle: {on: lever, at: [0.1, 0, 0.03], radius: 0.09}}\n"
                            "      - {line: {on: piston, at: [0, 0, 0.01], facing: 170 deg}}\n"
                            "    normal: {b: 2e3, c: 1e2, D: 0.5}\n"
                            "    friction: {A: 0.2, vt: 0.05}\n"
                            "%s"
                            "inputs:\n"
                            "  finger: {force: lever.tip, direction: [0.6, 0, -0.8]}\n"
                            "  twist: {torque: rise}\n"
                            "  pull: {motion: sled}\n"
                            "outputs: {angle: {joint: lever, read: position}}\n"
                            "simulation: {dt: 0.1 ms, until: 0.1 s}\n";

static const char links_and_tables[] =
    "links:\n"
    "  tie: {from: frame.anchor, to: piston.end, k: 90, length: 0.3, damping: 2, slack: 0.2,"
    " let_off: {share: 0.4, z: 0.19, range: 0.02}}\n"
    "tables:\n"
    "  coil: {joint: lever, of: position, at: [-1, 0.1, 0.5], torque: [0.3, -0.06, -0.4]}\n"
    "  brake: {joint: lever, of: speed, at: [-1, 0, 3], torque: [4e-3, 0, -1.2e-2]}\n"
    "  felt: {contact: balls, of: depth, at: [0, 0.01, 0.05, 0.2], force: [0, 2.6, 3, 9]}\n"
    "  skin: {contact: balls, of: rate, at: [-1, 1], factor: [-0.1, 0.2]}\n";

static void press(void *ctx, double t, double u[3])
{
    u[0] = *(double *)ctx * (1.0 + t);
}

static void wave(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.01 * sin(9.0 * t + 0.3);
    u[1] = 0.09 * cos(9.0 * t + 0.3);
    u[2] = -0.81 * sin(9.0 * t + 0.3);
}

START_TEST(parts_that_no_file_has_together)
{
    double force = 1.3, torque = 0.02;
    const char *more = _i == 0 ? "" : links_and_tables; // by all at once, or along each
    char *text = lab__text(parts, more);
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert(stein_touches(sim, 0) && stein_touches(sim, 1));
    check_place(sim, 1e-7);
    ck_assert_stein(stein_drive(sim, "finger", press, &force, err));
    ck_assert_stein(stein_drive(sim, "twist", press, &torque, err));
    check_place(sim, 1e-7);
    ck_assert_stein(stein_drive(sim, "pull", wave, NULL, err));
    check_place(sim, 1e-7);
    stein_sim_destroy(sim);
    lab_close(model);
    free(text);
}
END_TEST

/* ten links in space: qdd by articulated bodies, which leave no M behind */
START_TEST(chains_without_a_mass_matrix)
{
    char text[4096] = "mechanism: chain\nbodies:\n";
    for (int i = 0; i < 10; i++) {
        char parent[64] = "";
        if (i > 0) {
            snprintf(parent, sizeof parent, "parent: l%d, at: [0, 0, 0.1 m], ", i - 1);
        }
        snprintf(
            text + strlen(text), sizeof text - strlen(text),
            "  l%d: {%sjoint: R %c, mass: 0.3 kg, centre: [10 mm, 20 mm, 50 mm], inertia: {xx: "
            "1e-3 kg m^2, yy: 2e-3 kg m^2, zz: 1.5e-3 kg m^2}, initial: {position: 0.%d rad, "
            "speed: 0.%d rad/s}}\n",
            i, parent, "zyx"[i % 3], i + 1, 9 - i);
    }
    lab_model *model = open_text(text, NULL, 0);
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert(stein_sim_model(sim)->articulated != NULL);
    check_place(sim, 1e-7);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* ---- refusals -------------------------------------------------------------------------------- */

static void hook(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q, (void)qd;
    Q[0] += 1.0;
}

#define ck_assert_refused(call, code, words)                                  \
    do {                                                                      \
        stein_err refused = {STEIN_OK, ""}, *err = &refused;                  \
        ck_assert_int_eq(call, code);                                         \
        ck_assert_msg(strstr(refused.msg, words) != NULL, "%s", refused.msg); \
    } while (0)

START_TEST(missing_derivatives_are_refused)
{
    int blocks = 0;
    stein_model bare = stein_model_pendulum;
    stein_derivative *s = NULL;
    stein_sim_def def = stein_sim_def_default(&bare);
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_sim *other = make_sim(&stein_model_double_pendulum, STEIN_RK4, 0.0);
    bare.inverse_along = NULL;
    ck_assert_refused(stein_derivative_create(&s, &bare, NULL, err), STEIN_EINVAL,
                      "without derivatives");
    bare.abi++;
    ck_assert_refused(stein_derivative_create(&s, &bare, NULL, err), STEIN_ESTALE, "regenerate");
    def.alloc = no_memory;
    ck_assert_refused(stein_derivative_create(&s, &stein_model_pendulum, &def, err), STEIN_ENOMEM,
                      "out of memory");
    def.alloc = count_alloc;
    def.release = count_release;
    def.ctx = &blocks;
    ck_assert_stein(stein_derivative_create(&s, &stein_model_pendulum, &def, err));
    ck_assert_int_eq(blocks, 1);
    double q = 0.1, qd = 0.2, out[2];
    ck_assert_refused(stein_derivative_at(s, other, 0.0, &q, &qd, NULL, err), STEIN_EINVAL,
                      "other equations");
    stein_on_force(sim, hook, NULL);
    ck_assert_refused(stein_derivative_at(s, sim, 0.0, &q, &qd, NULL, err), STEIN_EINVAL, "hook");
    stein_on_force(sim, NULL, NULL);
    for (int k = 0; k < 4; k++) { // no result without a place
        out[0] = out[1] = 0.0;
        k == 0   ? stein_derivative_by_state(s, &out[0], &out[1])
        : k == 1 ? stein_derivative_forces(s, &out[0], &out[1])
        : k == 2 ? stein_derivative_by_parameter(s, 0, out)
                 : stein_derivative_along(s, &q, &qd, NULL, out);
        ck_assert(isnan(out[0]) && (k > 1 || isnan(out[1])));
    }
    ck_assert_stein(stein_derivative_at(s, sim, 0.0, &q, &qd, NULL, err));
    stein_derivative_by_parameter(s, bare.np, out);
    ck_assert(out[0] == 0.0);
    stein_derivative_by_parameter(s, -1, out);
    ck_assert(out[0] == 0.0);
    stein_derivative_destroy(s);
    stein_derivative_destroy(NULL);
    ck_assert_int_eq(blocks, 0);
    stein_sim_destroy(sim);
    stein_sim_destroy(other);
}
END_TEST

void derivative_places_cases(Suite *suite)
{
    TCase *places = tcase_create("places");
    tcase_add_checked_fixture(places, make_folder, remove_folder);
    tcase_add_test(places, action_with_all_contacts_closed);
    tcase_add_test(places, action_with_every_effect_of_every_law);
    tcase_add_test(places, mechanisms_on_their_way);
    tcase_add_loop_test(places, parts_that_no_file_has_together, 0, 2);
    tcase_add_test(places, chains_without_a_mass_matrix);
    tcase_add_test(places, missing_derivatives_are_refused);
    tcase_set_timeout(places, 60);
    suite_add_tcase(suite, places);
}
