/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_linkages.c - mechanisms with loops against published values and against motions that are
 * known otherwise: problems A02, A03 and A04 of the IFToMM library of computational benchmarks
 * (Gonzalez et al. 2006), cranks with sliders, singular positions that are passed. Energy is kept
 * in all of them.
 */
#include <string.h>

#include "lab_support.h"

Suite *linkages_suite(void);

static double energy(stein_sim *sim)
{
    double kinetic, potential;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
    return kinetic + potential;
}

/* runs to `until`, looks every `every`. @return largest change of the energy [J] */
static double drift(stein_sim *sim, double every, double until)
{
    double before = energy(sim), worst = 0.0;
    for (int i = 1; every * i <= until * (1.0 + 1e-12); i++) {
        ck_assert_stein(stein_run(sim, every * i, err));
        worst = fmax(worst, fabs(energy(sim) - before));
    }
    return worst;
}

static stein_sim *start(lab_model **model, const char *text)
{
    stein_sim *sim = NULL;
    *model = open_text(text, NULL, 0);
    ck_assert_stein(lab_sim(*model, NULL, &sim, err));
    return sim;
}

/* at 30 ms, from the Bari test set for initial value problem solvers (release 2.4, Andrews) */
START_TEST(andrews_mechanism_is_where_it_is_published)
{
    static const struct {
        const char *channel;
        double value;
    } at[] = {{"beta", 15.81077119629904},    {"Theta", -15.75637105984298},
              {"gamma", 0.04082224013073101}, {"Phi", -0.5347301163226948},
              {"delta", 0.5244099658805304},  {"Omega", 0.5347301163226948},
              {"epsilon", 1.048080741042263}};
    stein_sim *sim = make_sim(&stein_model_andrews, STEIN_DP5, 2e-5);
    double worst = 0.0, q, before = energy(sim);
    ck_assert_int_eq(stein_freedom(sim), 1);
    ck_assert_stein(stein_run(sim, 0.03, err));
    for (int i = 0; i < 7; i++) {
        ck_assert_stein(stein_read_name(sim, at[i].channel, &q, err));
        worst = fmax(worst, fabs(q / at[i].value - 1.0));
    }
    printf("Andrews' mechanism: off by %.2g of its published positions\n", worst);
    ck_assert(worst < 5e-9);

    /* the motor and the spring, which is at the end as long as its two points are apart */
    double d[3], c[3], length[2], turned[2];
    for (int k = 0; k < 2; k++) {
        double x[3 * 16];
        const stein_model *m = &stein_model_andrews;
        ck_assert(m->npoint <= 16);
        stein_points(sim, stein_q(sim), stein_qd(sim), x, NULL, NULL, NULL);
        for (int i = 0; i < m->npoint; i++) {
            if (i == m->links[0].point[0]) {
                memcpy(d, x + 3 * i, sizeof d);
            } else if (i == m->links[0].point[1]) {
                memcpy(c, x + 3 * i, sizeof c);
            }
        }
        length[k] = hypot(d[0] - c[0], d[2] - c[2]) - 0.07785;
        turned[k] = stein_q(sim)[0];
        if (k == 0) {
            q = energy(sim) + 0.5 * 4530.0 * length[0] * length[0] - 0.033 * turned[0];
            ck_assert_stein(stein_reset(sim, err));
        }
    }
    before += 0.5 * 4530.0 * length[1] * length[1] - 0.033 * turned[1];
    ck_assert_close(q, before, 0.0, 1e-7);
    stein_sim_destroy(sim);
}
END_TEST

/* N square loops in a row, all bars 1 m and 1 kg, upright at 1 rad/s. Fixed steps: where all bars
 * lie flat, steps of controlled error become so short that round-off chooses how it goes on. */
static char *bars(int n)
{
    size_t size = 2000 + 700 * (size_t)n;
    char *text = malloc(size), *at = text, *end = text + size;
    at += snprintf(at, (size_t)(end - at), "mechanism: bars%d\nbodies:\n", n);
    for (int i = 0; i <= n; i++) {
        at += snprintf(at, (size_t)(end - at),
                       "  c%d: {joint: R -y, at: [%d m, 0, 0], mass: 1 kg, centre: [0.5, 0, 0], "
                       "inertia: {yy: 0.083333333333333333}, points: {e: [1, 0, 0]}, initial: "
                       "{position: 90 deg%s}}\n",
                       i, i, i == 0 ? ", speed: -1 rad/s" : "");
    }
    for (int i = 0; i < n; i++) {
        at += snprintf(at, (size_t)(end - at),
                       "  k%d: {parent: c%d, at: c%d.e, joint: R -y, mass: 1 kg, centre: [0.5, 0, "
                       "0], inertia: {yy: 0.083333333333333333}, points: {e: [1, 0, 0]}, initial: "
                       "{position: -90 deg}}\n",
                       i, i, i);
    }
    at += snprintf(at, (size_t)(end - at), "loops:\n");
    for (int i = 0; i < n; i++) {
        at += snprintf(at, (size_t)(end - at), "  l%d: {between: [k%d.e, c%d.e]}\n", i, i, i + 1);
    }
    snprintf(at, (size_t)(end - at), "simulation: {dt: 1 ms, until: 10 s, integrator: rk4}\n");
    return text;
}

/* The bars stay parallel, also through the singular positions where all of them lie flat: a
 * pendulum with q'' = -w cos q, w = g (n + (n + 1)/2) / (n + (n + 1)/3). */
static void swing(int n, double t, double y[2])
{
    enum { STEPS = 20 };
    double w = 9.81 * (n + 0.5 * (n + 1)) / (n + (n + 1) / 3.0), h = t / STEPS;
    for (int i = 0; i < STEPS; i++) { // Kutta's method, with far finer steps than the tested method
        double k1 = -w * cos(y[0]), k2 = -w * cos(y[0] + 0.5 * h * y[1]);
        double k3 = -w * cos(y[0] + 0.5 * h * y[1] + 0.25 * h * h * k1);
        double k4 = -w * cos(y[0] + h * y[1] + 0.5 * h * h * k2);
        y[0] += h * y[1] + h * h / 6.0 * (k1 + k2 + k3);
        y[1] += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
}

START_TEST(rows_of_four_bars_pass_their_singular_positions)
{
    static const int count[] = {1, 2, 10};
    int n = count[_i];
    lab_model *model;
    char *text = bars(n);
    stein_sim *sim = start(&model, text);
    double y[2] = {acos(-1.0) / 2.0, -1.0}, before = energy(sim), off = 0.0, change = 0.0;
    ck_assert_int_eq(stein_freedom(sim), 1);
    for (int i = 1; i <= 500; i++) {
        ck_assert_stein(stein_run(sim, 0.02 * i, err));
        swing(n, 0.02, y);
        off = fmax(off, fabs(stein_q(sim)[0] - y[0]));
        change = fmax(change, fabs(energy(sim) - before));
    }
    printf("%d four-bars: off by %.2g rad in 10 s, energy by %.2g of it\n", n, off,
           change / before);
    ck_assert(off < 1e-6 && change < 1e-6 * before);
    stein_sim_destroy(sim);
    lab_close(model);
    free(text);
}
END_TEST

#define BAR "mass: 1 kg, "
#define YZ  "inertia: {yy: 0.0833333333333333, zz: 0.0833333333333333}, "
#define XY  "inertia: {xx: 0.0833333333333333, yy: 0.0833333333333333}, "
#define XZ  "inertia: {xx: 0.0833333333333333, zz: 0.0833333333333333}, "
/* six bars along the edges of a cube, each hinge square to both of its bars */
#define BRICARD(closed_by)                                                          \
    "mechanism: bricard\n"                                                          \
    "gravity: [0, -9.81 m/s^2, 0]\n"                                                \
    "bodies:\n"                                                                     \
    "  a: {joint: R z, " BAR "centre: [0.5, 0, 0], " YZ "points: {e: [1, 0, 0]}}\n" \
    "  b: {parent: a, at: a.e, joint: R y, " BAR "centre: [0, 0, 0.5], " XY         \
    "points: {e: [0, 0, 1]}}\n"                                                     \
    "  c: {parent: b, at: b.e, joint: R x, " BAR "centre: [0, 0.5, 0], " XZ         \
    "points: {e: [0, 1, 0]}}\n"                                                     \
    "  d: {parent: c, at: c.e, joint: R z, " BAR "centre: [-0.5, 0, 0], " YZ        \
    "points: {e: [-1, 0, 0]}}\n"                                                    \
    "  e: {parent: d, at: d.e, joint: R y, " BAR "centre: [0, 0, -0.5], " XY        \
    "points: {e: [0, 0, -1]}}\n"                                                    \
    "points: {f: [0, 1, 0]}\n"                                                      \
    "loops: {close: {between: [frame.f, e.e], " closed_by "}}\n"                    \
    "simulation: {dt: 1 ms, until: 10 s}\n"

START_TEST(bricards_mechanism_moves_though_one_of_its_conditions_is_redundant)
{
    lab_model *model;
    stein_sim *sim = start(&model, BRICARD("hinge: x"));
    double change;
    ck_assert_int_eq(lab_equations(model)->nrow, 5);
    ck_assert_int_eq(stein_freedom(sim), 1);
    change = drift(sim, 0.01, 10.0) / 24.525;
    printf("Bricard's mechanism: energy off by %.2g\n", change);
    ck_assert(change < 1e-6);
    ck_assert(fabs(stein_q(sim)[0]) > 0.1);
    stein_sim_destroy(sim);
    lab_close(model);

    sim = start(&model, BRICARD("weld: yes"));
    ck_assert_int_eq(stein_freedom(sim), 0);
    ck_assert_stein(stein_run(sim, 1.0, err));
    ck_assert_close(stein_q(sim)[0], 0.0, 0.0, 1e-13);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* the crank turns in another plane than the one the slider runs in; its rod has no mass */
START_TEST(a_crank_drives_a_slider_in_space)
{
    lab_model *model;
    stein_sim *sim = start(
        &model, "mechanism: space_crank\n"
                "bodies:\n"
                "  crank: {at: [0, 0.1, 0.12], joint: R x, mass: 0.12 kg, centre: [0, 0, 0.04],\n"
                "    inertia: {xx: 1e-4, yy: 1e-4, zz: 1e-5}, points: {p: [0, 0, 0.08]},\n"
                "    initial: {speed: 6 rad/s}}\n"
                "  slider: {joint: T x, mass: 2 kg, points: {p: [0, 0, 0]}, initial: {position: "
                "0.2 m}}\n"
                "loops: {rod: {between: [crank.p, slider.p], rod: 0.3 m}}\n"
                "simulation: {dt: 0.2 ms, until: 10 s}\n");
    ck_assert_int_eq(stein_freedom(sim), 1);
    ck_assert_close(stein_q(sim)[1], 0.2, 1e-14, 0.0); // 0.09 = 0.2^2 + 0.1^2 + 0.2^2
    ck_assert(drift(sim, 0.01, 10.0) < 1e-6 * energy(sim));
    double a = stein_q(sim)[0], y = 0.1 - 0.08 * sin(a), z = 0.12 + 0.08 * cos(a);
    ck_assert_close(stein_q(sim)[1], sqrt(0.09 - y * y - z * z), 1e-12, 0.0);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(a_pin_in_a_slot_moves_a_yoke_by_the_cosine)
{
    lab_model *model;
    stein_sim *sim =
        start(&model, "mechanism: yoke\n"
                      "bodies:\n"
                      "  crank: {joint: R -y, mass: 0.5 kg, centre: [50 mm, 0, 0], inertia: {yy: "
                      "5e-4}, points: {p: [100 mm, 0, 0]}, initial: {position: 60 deg}}\n"
                      "  yoke: {joint: T x, mass: 0.6 kg, points: {e: [0, 0, 0]}}\n"
                      "loops: {pin: {between: [yoke.e, crank.p], slot: z}}\n"
                      "simulation: {dt: 0.5 ms, until: 10 s}\n");
    ck_assert_int_eq(lab_equations(model)->nrow, 1);
    ck_assert(drift(sim, 0.01, 10.0) < 1e-6 * energy(sim));
    ck_assert_close(stein_q(sim)[1], 0.1 * cos(stein_q(sim)[0]), 0.0, 1e-13);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* a body that is carried by slides and a hinge, welded to the end of an arm, is part of the arm */
START_TEST(welded_bodies_move_as_one_body)
{
    lab_model *model, *one;
    stein_sim *sim =
        start(&model, "mechanism: welded\n"
                      "bodies:\n"
                      "  arm: {joint: R -y, mass: 1 kg, centre: [0.05, 0, 0], inertia: {yy: 5e-4}, "
                      "points: {p: [0.1, 0, 0]}, initial: {position: 60 deg}}\n"
                      "  x: {joint: T x, mass: 0 kg}\n"
                      "  z: {parent: x, joint: T z, mass: 0 kg}\n"
                      "  tip: {parent: z, joint: R y, mass: 0.6 kg, inertia: {yy: 1e-3}, points: "
                      "{p: [-20 mm, 0, 0]}}\n"
                      "loops: {w: {between: [arm.p, tip.p], weld: yes}}\n"
                      "simulation: {dt: 0.5 ms, until: 5 s}\n");
    stein_sim *alone = start(&one, "mechanism: whole\n"
                                   "bodies:\n"
                                   "  arm: {joint: R -y, mass: 1.6 kg, centre: [0.07625, 0, 0], "
                                   "inertia: {yy: 0.0033375}, initial: {position: 60 deg}}\n"
                                   "simulation: {dt: 0.5 ms, until: 5 s}\n");
    for (int i = 1; i <= 50; i++) {
        ck_assert_stein(stein_run(sim, 0.1 * i, err));
        ck_assert_stein(stein_run(alone, 0.1 * i, err));
        ck_assert_close(stein_q(sim)[0], stein_q(alone)[0], 0.0, 1e-9);
    }
    stein_sim_destroy(sim);
    stein_sim_destroy(alone);
    lab_close(model);
    lab_close(one);
}
END_TEST

/* ---- singular positions that are passed ---- */

#define CRANK(start)                                                                             \
    "  crank: {joint: R -y, mass: 1 kg, centre: [0.05, 0, 0], inertia: {yy: 1e-3}, points: {p: " \
    "[0.1, 0, 0]}, initial: {position: " start "}}\n"
#define SLIDER \
    "  slider: {joint: T x, mass: 0.4 kg, points: {p: [0, 0, 0]}, initial: {guess: 0.17}}\n"

/* A crank as long as its rod, three ways: at 90 deg the slider stands at the crank's axis, where
 * crank and rod might go on as one. A four-bar whose bars all lie flat. */
static const char *const passing[] = {
    "mechanism: even_crank\n"
    "bodies:\n" CRANK("30 deg, speed: 10 rad/s") "  rod: {parent: crank, at: crank.p, joint: R -y, "
                                                 "mass: 0.5 kg, centre: [0.05, 0, 0], inertia: "
                                                 "{yy: 6e-4}, points: {e: [0.1, 0, 0]}, initial: "
                                                 "{guess: -60 deg}}\n" SLIDER
                                                 "loops: {g: {between: [rod.e, slider.p]}}\n"
                                                 "simulation: {dt: 1 ms}\n",
    "mechanism: even_crank_from_slider\n"
    "bodies:\n" CRANK("30 deg, speed: 10 rad/s") SLIDER
    "  rod: {parent: slider, joint: R -y, mass: 0.5 kg, centre: [-0.05, 0, 0], inertia: {yy: "
    "6e-4}, points: {e: [-0.1, 0, 0]}, initial: {guess: -30 deg}}\n"
    "loops: {g: {between: [rod.e, crank.p]}}\n"
    "simulation: {dt: 1 ms}\n",
    "mechanism: even_crank_with_rod\n"
    "bodies:\n" CRANK("30 deg, speed: 10 rad/s") SLIDER
    "loops: {g: {between: [slider.p, crank.p], rod: 0.1 m}}\n"
    "simulation: {dt: 1 ms}\n",
    "mechanism: flat_four_bar\n"
    "bodies:\n" CRANK(
        "60 deg, speed: -20 rad/s") "  coupler: {parent: crank, at: crank.p, joint: R -y, mass: "
                                    "0.5 kg, centre: [0.1, 0, 0], "
                                    "inertia: {yy: 3e-3}, points: {e: [0.2, 0, 0]}, initial: "
                                    "{guess: -60 deg}}\n"
                                    "  rocker: {at: [0.3, 0, 0], joint: R -y, mass: 0.4 kg, "
                                    "centre: [0.1, 0, 0], inertia: {yy: "
                                    "2e-3}, points: {p: [0.2, 0, 0]}, initial: {guess: 100 deg}}\n"
                                    "loops: {g: {between: [coupler.e, rocker.p]}}\n"
                                    "simulation: {dt: 1 ms}\n"};
enum { PASSING = sizeof passing / sizeof *passing };

static stein_sim *start_with(const lab_model *model, stein_integrator integrator)
{
    stein_sim_def def = lab_def(model);
    stein_sim *sim = NULL;
    def.integrator = integrator;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    return sim;
}

static double apart(const stein_sim *a, const stein_sim *b, int n)
{
    double worst = 0.0;
    for (int j = 0; j < n; j++) {
        worst = fmax(worst, fabs(stein_q(a)[j] - stein_q(b)[j]));
    }
    return worst;
}

/* is it still on the branch that it began on? */
static void check_branch(int which, const double *q)
{
    if (which == 0) {
        ck_assert_close(q[1], -2.0 * q[0], 0.0, 1e-8);
    } else if (which == 1) {
        ck_assert_close(q[2], -q[0], 0.0, 1e-8);
    } else if (which == 2) {
        ck_assert_close(q[1], 0.2 * cos(q[0]), 0.0, 1e-9);
    }
}

START_TEST(singular_positions_are_passed_with_every_kind_of_step)
{
    static const struct {
        stein_integrator integrator;
        double energy, position;
    } kind[] = {{STEIN_CONTROLLED, 1e-9, 1e-8},
                {STEIN_IMPLICIT, 1e-9, 1e-8},
                {STEIN_DP5, 1e-7, 1e-5},
                {STEIN_RK4, 1e-5, 1e-4}};
    lab_model *model = open_text(passing[_i], NULL, 0);
    int n = lab_equations(model)->nq;
    stein_sim *reference = start_with(model, STEIN_CONTROLLED);
    ck_assert_stein(stein_run(reference, 2.0, err));
    for (int k = 0; k < 4; k++) {
        stein_sim *sim = start_with(model, kind[k].integrator);
        double most = fabs(energy(sim)), off = drift(sim, 0.00731, 2.0), last;
        ck_assert_stein(stein_run(sim, 2.0, err));
        ck_assert(stein_singular_passes(sim, &last) >= 5 && last > 1.0 && last < 2.0);
        ck_assert_msg(off < kind[k].energy * most, "mechanism %d, kind %d: energy off by %g", _i, k,
                      off / most);
        check_branch(_i, stein_q(sim));
        ck_assert_msg(apart(sim, reference, n) < kind[k].position,
                      "mechanism %d, kind %d: off by %g", _i, k, apart(sim, reference, n));
        stein_sim_destroy(sim);
    }
    stein_sim_destroy(reference);
    lab_close(model);
}
END_TEST

START_TEST(a_run_may_end_and_go_on_at_any_distance_from_a_singular_position)
{
    lab_model *model = open_text(passing[_i], NULL, 0);
    int n = lab_equations(model)->nq;
    stein_sim *reference = start_with(model, STEIN_CONTROLLED);
    double at = 0.0, worst = 0.0;
    while (stein_singular_passes(reference, &at) == 0) {
        ck_assert_stein(stein_step(reference, err));
    }
    ck_assert_stein(stein_run(reference, 0.5, err));
    for (double distance = 1e-9; distance < 2e-2; distance *= 7.3) {
        for (int side = -1; side <= 1; side += 2) {
            stein_sim *sim = start_with(model, STEIN_CONTROLLED);
            stein_pace pace = {.tolerance = 1e-12, .longest = 0.01, .h = 1e-3, .next = INFINITY};
            ck_assert_stein(stein_run_adaptive(sim, at + side * distance, &pace, err));
            ck_assert_stein(stein_run_adaptive(sim, 0.5, &pace, err));
            worst = fmax(worst, apart(sim, reference, n));
            stein_sim_destroy(sim);
        }
    }
    ck_assert_msg(worst < 1e-8, "mechanism %d: off by %g", _i, worst);
    stein_sim_destroy(reference);
    lab_close(model);
}
END_TEST

START_TEST(the_models_keep_their_energy)
{
    stein_sim *sim = make_sim(&stein_model_four_bar, STEIN_RK4, 0.0);
    double kinetic = energy(sim);
    ck_assert(drift(sim, 0.05, 10.0) < 1e-6 * kinetic);
    stein_sim_destroy(sim);
    sim = make_sim(&stein_model_slider_crank, STEIN_RK4, 0.0);
    kinetic = energy(sim);
    ck_assert(drift(sim, 0.05, 10.0) < 1e-6 * kinetic);
    stein_sim_destroy(sim);
}
END_TEST

Suite *linkages_suite(void)
{
    Suite *suite = suite_create("linkages");
    TCase *all = tcase_create("all");
    tcase_set_timeout(all, 60);
    tcase_add_unchecked_fixture(all, make_folder, remove_folder);
    tcase_add_test(all, andrews_mechanism_is_where_it_is_published);
    tcase_add_loop_test(all, rows_of_four_bars_pass_their_singular_positions, 0, 3);
    tcase_add_test(all, bricards_mechanism_moves_though_one_of_its_conditions_is_redundant);
    tcase_add_test(all, a_crank_drives_a_slider_in_space);
    tcase_add_test(all, a_pin_in_a_slot_moves_a_yoke_by_the_cosine);
    tcase_add_test(all, welded_bodies_move_as_one_body);
    tcase_add_loop_test(all, singular_positions_are_passed_with_every_kind_of_step, 0, PASSING);
    tcase_add_loop_test(all, a_run_may_end_and_go_on_at_any_distance_from_a_singular_position, 0,
                        PASSING);
    tcase_add_test(all, the_models_keep_their_energy);
    suite_add_tcase(suite, all);
    return suite;
}
