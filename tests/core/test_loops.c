/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_loops.c - closed loops and couplings: generated functions, qdd, closing, refusals.
 */
#include <string.h>

#include "mechanism_cases.h"
#include "simulation_support.h"
#include "stein/batch.h"
#include "stein/derivative.h"

Suite *loops_suite(void);

enum { MOST = 32 }; /* joints, rows */

typedef struct constants {
    const stein_model *m;
    double d[2000], sc[2 * MOST];
} constants;

/* of the model's own numbers */
static constants constants_of(const stein_model *m)
{
    constants k = {.m = m};
    double p[2000];
    ck_assert(m->np <= 2000 && m->nd <= 2000 && m->nq <= MOST && m->nrow <= MOST);
    for (int i = 0; i < m->np; i++) {
        p[i] = m->params[i].value;
    }
    stein_setup(m, p, k.d);
    return k;
}

static void closure(constants *k, const double *q, const double *qd, double *h, double *J,
                    double *bias)
{
    stein_turn(k->m, q, k->sc);
    k->m->closure(q, qd, k->sc, k->d, h, J, bias);
}

static double gap_at(constants *k, const stein_sim *sim)
{
    double h[MOST], J[MOST * MOST], bias[MOST], gap = 0.0;
    closure(k, stein_q(sim), stein_qd(sim), h, J, bias);
    for (int i = 0; i < k->m->nrow; i++) {
        gap = fmax(gap, fabs(h[i]));
    }
    return gap;
}

static double widest_gap(const stein_sim *sim)
{
    constants k = constants_of(stein_sim_model(sim));
    return gap_at(&k, sim);
}

static double energy(stein_sim *sim)
{
    double kinetic, potential;
    stein_energy(sim, stein_q(sim), stein_qd(sim), &kinetic, &potential);
    return kinetic + potential;
}

/* ---- generated functions ---- */

/* two branches on body a and a separate one; a point is moved along each axis of c and f */
static const char every_kind[] =
    "mechanism: every_kind\n"
    "bodies:\n"
    "  a: {joint: R y, at: [0.1, 0.2, 0.3], mass: 1 kg, inertia: {yy: 1}, points: {p: [0.3, -0.1, "
    "0.2]}}\n"
    "  b: {parent: a, joint: R z, at: [0.2, 0.1, -0.3], mass: 1 kg}\n"
    "  c: {parent: b, joint: T -x, at: [0.4, 0.3, 0.1], mass: 1 kg, points: {p: [0.1, 0.2, 0.3],\n"
    "      o: [0, 0, 0], x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1]}}\n"
    "  d: {parent: a, joint: R -x, at: [-0.2, 0.3, 0.1], mass: 1 kg}\n"
    "  e: {parent: d, joint: T y, at: [0.1, 0.4, 0.2], mass: 1 kg, points: {p: [0.3, 0.1, -0.2]}}\n"
    "  f: {joint: R z, at: [0.2, 0.3, 0.5], mass: 1 kg, points: {p: [0.2, -0.3, 0.1],\n"
    "      o: [0, 0, 0], x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1]}}\n"
    "loops:\n"
    "  meet: {between: [c.p, e.p]}\n"
    "  rod: {between: [c.p, f.p], rod: 0.37 m}\n"
    "  slot: {between: [c.p, f.p], slot: y}\n"
    "  weld: {between: [c.p, f.p], weld: yes}\n"
    "  hinge: {between: [c.p, f.p], hinge: z}\n"
    "  arm: {between: [a.p, e.p]}\n"
    "couplings:\n"
    "  screw: {joint: c, follows: f, ratio: 13 mm/rad, offset: 7 mm}\n";

/* first row of each loop */
enum { MEET, ROD = 3, SLOT, WELD = 6, HINGE = 12, ARM = 17, SCREW = 20, ROWS };

static int point(const stein_model *m, const char *name)
{
    int i = 0;
    while (strcmp(m->points[i].name, name) != 0) {
        i++;
    }
    return i;
}

/* to - from, in the fixed frame */
static void between(const constants *k, const double *x, const char *from, const char *to,
                    double v[3])
{
    const double *a = x + 3 * point(k->m, from), *b = x + 3 * point(k->m, to);
    for (int i = 0; i < 3; i++) {
        v[i] = b[i] - a[i];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* h from the points alone, which have generated functions of their own */
static void check_gaps(constants *k, const double *q, const double *h)
{
    static const char *const axis_c[] = {"c.x", "c.y", "c.z"}, *const axis_f[] = {"f.x", "f.y",
                                                                                  "f.z"};
    double x[3 * MOST], v[3 * MOST], J[3 * MOST * MOST], a[3 * MOST], zero[MOST] = {0.0};
    double d[3], e[3][3], f[3][3];
    k->m->point(q, zero, k->sc, k->d, x, v, J, a);
    between(k, x, "c.p", "e.p", d);
    ck_assert_close(dot(h + MEET, h + MEET), dot(d, d), 1e-13, 0.0); // in other axes
    between(k, x, "a.p", "e.p", d);
    ck_assert_close(dot(h + ARM, h + ARM), dot(d, d), 1e-13, 0.0);
    between(k, x, "c.p", "f.p", d);
    for (int i = 0; i < 3; i++) {
        between(k, x, "c.o", axis_c[i], e[i]);
        between(k, x, "f.o", axis_f[i], f[i]);
        ck_assert_close(h[WELD + i], d[i], 1e-13, 1e-15);
        ck_assert_close(h[HINGE + i], d[i], 1e-13, 1e-15);
    }
    ck_assert_close(h[ROD], (dot(d, d) - 0.37 * 0.37) / (2.0 * 0.37), 1e-13, 1e-15);
    ck_assert_close(h[SLOT], dot(e[0], d), 1e-13, 1e-15);
    ck_assert_close(h[SLOT + 1], dot(e[2], d), 1e-13, 1e-15);
    for (int i = 0; i < 3; i++) {
        ck_assert_close(h[WELD + 3 + i], dot(e[(i + 1) % 3], f[(i + 2) % 3]), 1e-13, 1e-15);
    }
    ck_assert_close(h[HINGE + 3], dot(e[2], f[0]), 1e-13, 1e-15);
    ck_assert_close(h[HINGE + 4], dot(e[2], f[1]), 1e-13, 1e-15);
    ck_assert_close(h[SCREW], q[2] - 0.013 * q[5] - 0.007, 1e-14, 1e-16);
}

START_TEST(rows_agree_with_points_and_their_derivatives_with_differences)
{
    model = open_text(every_kind, NULL, 0);
    constants k = constants_of(lab_equations(model));
    unsigned long long seed = 11;
    const double step = 1e-5;
    ck_assert_int_eq(k.m->nrow, ROWS);
    for (int n = 0; n < 20; n++) {
        double q[6], qd[6], h[ROWS], J[ROWS * 6], bias[ROWS], plus[ROWS], minus[ROWS], Jp[ROWS * 6],
            Jm[ROWS * 6], none[ROWS], qp[6], qm[6];
        for (int j = 0; j < 6; j++) {
            q[j] = 2.0 * noise(&seed);
            qd[j] = 3.0 * noise(&seed);
        }
        for (int j = 0; j < 6; j++) {
            memcpy(qp, q, sizeof q);
            memcpy(qm, q, sizeof q);
            qp[j] += step;
            qm[j] -= step;
            closure(&k, qp, qd, plus, Jp, none);
            closure(&k, qm, qd, minus, Jm, none);
            closure(&k, q, qd, h, J, bias);
            for (int i = 0; i < ROWS; i++) {
                ck_assert_close(J[i * 6 + j], (plus[i] - minus[i]) / (2.0 * step), 1e-8, 1e-8);
            }
        }
        for (int j = 0; j < 6; j++) {
            qp[j] = q[j] + step * qd[j];
            qm[j] = q[j] - step * qd[j];
        }
        closure(&k, qp, qd, plus, Jp, none);
        closure(&k, qm, qd, minus, Jm, none);
        closure(&k, q, qd, h, J, bias);
        for (int i = 0; i < ROWS; i++) {
            double rate = 0.0;
            for (int j = 0; j < 6; j++) {
                rate += (Jp[i * 6 + j] - Jm[i * 6 + j]) / (2.0 * step) * qd[j];
            }
            ck_assert_close(bias[i], rate, 1e-7, 1e-7);
        }
        check_gaps(&k, q, h);
        for (int i = MEET; i < ROD; i++) { // the common parent of both branches does not move them
            ck_assert(J[i * 6] == 0.0);
        }
    }
    lab_close(model);
}
END_TEST

/* ---- accelerations ---- */

/* A x = b by elimination with complete pivoting, n at most MOST */
static void eliminate(int n, double A[MOST][MOST], double *b, double *x)
{
    int column[MOST];
    for (int k = 0; k < n; k++) {
        column[k] = k;
    }
    for (int k = 0; k < n; k++) {
        int row = k, best = k;
        for (int i = k; i < n; i++) {
            for (int j = k; j < n; j++) {
                if (fabs(A[i][j]) > fabs(A[row][best])) {
                    row = i;
                    best = j;
                }
            }
        }
        for (int j = 0; j < n; j++) {
            double swap = A[k][j];
            A[k][j] = A[row][j];
            A[row][j] = swap;
        }
        for (int i = 0; i < n; i++) {
            double swap = A[i][k];
            A[i][k] = A[i][best];
            A[i][best] = swap;
        }
        double swap = b[k];
        b[k] = b[row];
        b[row] = swap;
        int old = column[k];
        column[k] = column[best];
        column[best] = old;
        for (int i = k + 1; i < n; i++) {
            double f = A[i][k] / A[k][k];
            for (int j = k; j < n; j++) {
                A[i][j] -= f * A[k][j];
            }
            b[i] -= f * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            b[i] -= A[i][j] * x[column[j]];
        }
        x[column[i]] = b[i] / A[i][i];
    }
}

/* M qdd + c = Q + J^T lambda and J qdd = -Jdot qd, all unknowns at once; Q is the springs' */
static void check_acceleration(stein_sim *sim, const double *Q)
{
    const stein_model *m = stein_sim_model(sim);
    constants k = constants_of(m);
    int n = m->nq, size = n + m->nrow;
    double M[MOST * MOST], c[MOST], h[MOST], J[MOST * MOST], bias[MOST], b[MOST], x[MOST];
    double A[MOST][MOST] = {{0.0}};
    stein_mass_bias(sim, stein_q(sim), stein_qd(sim), NULL, NULL, M, c);
    closure(&k, stein_q(sim), stein_qd(sim), h, J, bias);
    for (int i = 0; i < n; i++) {
        b[i] = Q[i] - c[i];
        for (int j = 0; j < n; j++) {
            A[i][j] = M[i * n + j];
        }
        for (int r = 0; r < m->nrow; r++) {
            A[i][n + r] = A[n + r][i] = J[r * n + i];
        }
    }
    for (int r = 0; r < m->nrow; r++) {
        b[n + r] = -bias[r];
    }
    eliminate(size, A, b, x);
    assert_near("qdd", stein_qdd(sim), x, n, 1e-9);
}

START_TEST(qdd_is_that_of_all_unknowns_at_once)
{
    static const stein_model *const models[] = {&stein_model_four_bar, &stein_model_slider_crank};
    unsigned long long seed = 3;
    for (int k = 0; k < 2; k++) {
        stein_sim *sim = make_sim(models[k], STEIN_RK4, 0.0);
        double qd[MOST], none[MOST] = {0.0};
        for (int n = 0; n < 30; n++) {
            ck_assert_stein(stein_run(sim, stein_time(sim) + 0.0137, err));
            for (int j = 0; j < models[k]->nq; j++) {
                qd[j] = 20.0 * noise(&seed); // none that the loop allows
            }
            ck_assert_stein(stein_set_state(sim, stein_time(sim), stein_q(sim), qd, err));
            check_acceleration(sim, none);
        }
        stein_sim_destroy(sim);
    }
}
END_TEST

/* a wheel with a weight, and one that turns -2 times as fast */
static const char gear[] =
    "mechanism: gear\n"
    "bodies:\n"
    "  a: {joint: R y, mass: 1 kg, centre: [0.1, 0, 0], inertia: {yy: 0.01}, initial: {position: "
    "0.3 rad}}\n"
    "  b: {at: [0.2, 0, 0], joint: R y, mass: 1 kg, inertia: {yy: 0.01}, mimic: {joint: a, ratio: "
    "-2, offset: 0.1 rad}}\n"
    "  s: {joint: T x, mass: 2 kg}\n"
    "couplings:\n"
    "  rack: {joint: s, follows: b, ratio: 30 mm/rad}\n"
    "simulation: {dt: 1 ms, until: 10 s}\n";
static const char wheel[] =
    "mechanism: wheel\n"
    "bodies:\n"
    "  a: {joint: R y, mass: 1 kg, centre: [0.1, 0, 0], inertia: {yy: 0.0572}, initial: {position: "
    "0.3 rad}}\n"
    "simulation: {dt: 1 ms, until: 10 s}\n";

START_TEST(coupled_joints_move_as_one_with_the_inertia_of_all)
{
    stein_sim *sim = start(gear), *alone = NULL;
    lab_model *one = open_text(wheel, NULL, 0);
    ck_assert_stein(lab_sim(one, NULL, &alone, err));
    ck_assert_int_eq(stein_freedom(sim), 1);
    ck_assert_int_eq(stein_freedom(alone), 1);
    for (int k = 1; k <= 100; k++) { // 0.0572 = 0.01 + 4 (0.01 + 2 0.03^2)
        ck_assert_stein(stein_run(sim, 0.1 * k, err));
        ck_assert_stein(stein_run(alone, 0.1 * k, err));
        const double *q = stein_q(sim);
        ck_assert_close(q[0], stein_q(alone)[0], 0.0, 1e-11);
        ck_assert_close(q[1], -2.0 * q[0] + 0.1, 0.0, 1e-14);
        ck_assert_close(q[2], 0.03 * q[1], 0.0, 1e-15);
    }
    lab_close(one);
    stein_sim_destroy(alone);
    finish(sim);
}
END_TEST

/* the crank turns at constant speed, with a swing */
static void turn(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 0.5 + 30.0 * t + 0.3 * sin(20.0 * t);
    u[1] = 30.0 + 6.0 * cos(20.0 * t);
    u[2] = -120.0 * sin(20.0 * t);
}

START_TEST(the_force_of_a_prescribed_motion_gives_its_energy)
{
    stein_sim *sim = make_sim(&stein_model_slider_crank, STEIN_RK4, 1e-4);
    double before, torque, u[3], work = 0.0;
    ck_assert_stein(stein_drive(sim, "drive", turn, NULL, err));
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_int_eq(stein_freedom(sim), 0);
    before = energy(sim);
    for (int i = 0; i <= 2000; i++) { // Simpson's rule
        double weight = i == 0 || i == 2000 ? 1.0 : i % 2 ? 4.0 : 2.0, t = 1e-4 * i;
        ck_assert_stein(stein_run(sim, t, err));
        ck_assert_stein(stein_read_name(sim, "torque", &torque, err));
        turn(NULL, t, u);
        work += weight / 3.0 * 1e-4 * torque * u[1];
        ck_assert_close(stein_q(sim)[3], -0.5 * u[0], 1e-14, 0.0);
    }
    ck_assert_close(work, energy(sim) - before, 1e-7, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

/* Two routes to the torque at the crank. One is the loops' forces, by which the core takes what is
 * missing at the dependent joints to the driven one. The other is the power of M qdd + c, of which
 * those have none.
 */
START_TEST(the_force_of_a_prescribed_motion_has_the_power_of_inverse_dynamics)
{
    stein_sim *sim = make_sim(&stein_model_slider_crank, STEIN_RK4, 1e-4);
    int n = stein_model_slider_crank.nq;
    ck_assert_stein(stein_drive(sim, "drive", turn, NULL, err));
    ck_assert_stein(stein_reset(sim, err));
    for (int i = 1; i <= 50; i++) {
        double torque, Q[MOST], power = 0.0, size = 0.0;
        ck_assert_stein(stein_run(sim, 0.00413 * i, err));
        ck_assert_stein(stein_read_name(sim, "torque", &torque, err));
        stein_inverse(sim, stein_q(sim), stein_qd(sim), stein_qdd(sim), NULL, NULL, Q);
        for (int j = 0; j < n; j++) {
            power += stein_qd(sim)[j] * Q[j];
            size += fabs(stein_qd(sim)[j] * Q[j]);
        }
        ck_assert_close(torque * stein_qd(sim)[0], power, 0.0, 1e-12 * size);
    }
    stein_sim_destroy(sim);
}
END_TEST

/* ---- closed ---- */

START_TEST(loops_stay_closed_with_both_methods_and_whatever_the_step)
{
    static const stein_model *const models[] = {&stein_model_four_bar, &stein_model_slider_crank,
                                                &stein_model_andrews};
    static const double dt[] = {5e-3, 1e-3, 1e-4};
    double worst = 0.0;
    for (int k = 0; k < 6; k++) {
        stein_sim *sim = make_sim(models[k / 2], k % 2 ? STEIN_DP5 : STEIN_RK4, dt[k / 2]);
        constants of = constants_of(models[k / 2]);
        for (int i = 0; i < 2000; i++) {
            ck_assert_stein(stein_step(sim, err));
            worst = fmax(worst, gap_at(&of, sim));
        }
        stein_sim_destroy(sim);
    }
    printf("loops: open by %.2g at most\n", worst);
    ck_assert(worst <= 1e-12);
}
END_TEST

START_TEST(nothing_drifts_in_many_steps)
{
    stein_sim *sim = make_sim(&stein_model_four_bar, STEIN_RK4, 2e-4);
    double before = energy(sim);
    ck_assert_stein(stein_run(sim, 20.0, err)); // 1e5 steps
    ck_assert(widest_gap(sim) <= 1e-12);
    ck_assert_close(energy(sim), before, 1e-7, 0.0);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_run_of_controlled_error_ends_closed_where_short_steps_do)
{
    stein_sim *fixed = make_sim(&stein_model_four_bar, STEIN_DP5, 2e-5);
    stein_sim *sim = make_sim(&stein_model_four_bar, STEIN_DP5, 0.0);
    stein_pace pace = {.tolerance = 1e-10, .longest = 0.05, .h = 1e-4, .next = INFINITY};
    ck_assert_stein(stein_run_adaptive(sim, 1.3, &pace, err));
    ck_assert_stein(stein_run(fixed, 1.3, err));
    ck_assert(widest_gap(sim) <= 1e-12);
    assert_near("q", stein_q(sim), stein_q(fixed), 3, 1e-8);
    stein_sim_destroy(sim);
    stein_sim_destroy(fixed);
}
END_TEST

START_TEST(one_block_holds_all_and_a_saved_state_goes_on_with_the_same_bits)
{
    int blocks = 0;
    stein_sim_def def = stein_sim_def_default(&stein_model_andrews);
    stein_sim *sim = NULL;
    double q[7];
    def.alloc = count_alloc;
    def.release = count_release;
    def.ctx = &blocks;
    ck_assert_stein(stein_sim_create(&sim, &stein_model_andrews, &def, err));
    ck_assert_stein(stein_run(sim, 0.005, err));
    void *state = malloc(stein_state_size(sim));
    stein_save(sim, state);
    ck_assert_stein(stein_run(sim, 0.01, err));
    memcpy(q, stein_q(sim), sizeof q);
    ck_assert_stein(stein_restore(sim, state, err));
    ck_assert_stein(stein_run(sim, 0.01, err));
    ck_assert_mem_eq(q, stein_q(sim), sizeof q);
    ck_assert_int_eq(blocks, 1);
    free(state);
    stein_sim_destroy(sim);
    ck_assert_int_eq(blocks, 0);
}
END_TEST

/* ---- closing ---- */

#define FOUR_BAR(crank, close)                                                                  \
    "mechanism: bar\n"                                                                          \
    "bodies:\n"                                                                                 \
    "  crank: {joint: R -y, mass: 0.5 kg, inertia: {yy: 5e-4}, points: {p: [0.1, 0, 0]}" crank  \
    "}\n"                                                                                       \
    "  coupler: {parent: crank, at: crank.p, joint: R -y, mass: 0.8 kg, inertia: {yy: 6e-3},\n" \
    "    points: {e: [0.3, 0, 0]}}\n"                                                           \
    "  rocker: {at: [0.3, 0, 0], joint: R -y, mass: 0.6 kg, inertia: {yy: 2e-3},\n"             \
    "    points: {e: [0.2, 0, 0]}}\n"                                                           \
    "points: {far: [2 m, 0, 0], beside: [0.3, 10 mm, 0]}\n"                                     \
    "loops:\n"                                                                                  \
    "  close: " close "\n"

START_TEST(stated_positions_stay_and_the_others_close_the_loop)
{
    stein_sim *sim = start(FOUR_BAR(", initial: {position: 1.1 rad, speed: 3 rad/s}",
                                    "{between: [coupler.e, rocker.e]}"));
    const double *q = stein_q(sim), *qd = stein_qd(sim);
    ck_assert(q[0] == 1.1 && qd[0] == 3.0 && q[1] != 0.0 && qd[1] != 0.0);
    ck_assert(widest_gap(sim) <= 1e-12);
    ck_assert_int_eq(stein_freedom(sim), 1);
    finish(sim);
}
END_TEST

/* the crank stays, the coupler goes to the one or the other side of it; a position would stay */
START_TEST(a_guess_chooses_the_branch_and_does_not_stay)
{
#define GUESSED(coupler, rocker)                                                                \
    "mechanism: bar\n"                                                                          \
    "bodies:\n"                                                                                 \
    "  crank: {joint: R -y, mass: 0.5 kg, inertia: {yy: 5e-4}, points: {p: [0.1, 0, 0]},\n"     \
    "    initial: {position: 1.1 rad}}\n"                                                       \
    "  coupler: {parent: crank, at: crank.p, joint: R -y, mass: 0.8 kg, inertia: {yy: 6e-3},\n" \
    "    points: {e: [0.3, 0, 0]}, initial: {guess: " coupler "}}\n"                            \
    "  rocker: {at: [0.3, 0, 0], joint: R -y, mass: 0.6 kg, inertia: {yy: 2e-3},\n"             \
    "    points: {e: [0.2, 0, 0]}, initial: {guess: " rocker "}}\n"                             \
    "loops: {close: {between: [coupler.e, rocker.e]}}\n"
    static const char *const text[] = {GUESSED("-0.9 rad", "0.9 rad"),
                                       GUESSED("-2.3 rad", "-2 rad")};
    double side[2];
    for (int k = 0; k < 2; k++) {
        stein_sim *sim = start(text[k]);
        ck_assert(stein_q(sim)[0] == 1.1 && widest_gap(sim) <= 1e-12);
        side[k] = stein_q(sim)[2];
        finish(sim);
    }
    ck_assert(side[0] > 0.0 && side[1] < 0.0);
}
END_TEST

START_TEST(a_loop_that_lies_flat_and_open_is_closed)
{
    stein_sim *sim = start(FOUR_BAR("", "{from: coupler.e, to: rocker.e}"));
    ck_assert(widest_gap(sim) <= 1e-12);
    finish(sim);
}
END_TEST

static void check_refused(const char *text, const char *words)
{
    stein_sim *sim = NULL;
    stein_err why = {STEIN_OK, ""};
    model = open_text(text, NULL, 0);
    ck_assert_int_eq(lab_sim(model, NULL, &sim, &why), STEIN_ECLOSE);
    ck_assert_msg(strstr(why.msg, words) != NULL, "%s", why.msg);
    ck_assert_ptr_null(sim);
    lab_close(model);
}

START_TEST(a_loop_that_cannot_be_closed_is_named_with_its_gap)
{
    check_refused(FOUR_BAR("", "{between: [coupler.e, frame.far]}"),
                  "\"close\" cannot be closed: nearest to the initial positions it is off by 1.6");
    check_refused(FOUR_BAR("", "{between: [coupler.e, frame.beside]}"), "off by 0.01 m");
}
END_TEST

START_TEST(a_singular_start_is_reported)
{
    check_refused("mechanism: flat\n"
                  "bodies:\n"
                  "  a: {joint: R -y, mass: 1 kg, inertia: {yy: 0.08}, points: {e: [1, 0, 0]}}\n"
                  "  b: {parent: a, at: a.e, joint: R -y, mass: 1 kg, inertia: {yy: 0.08}, points: "
                  "{e: [1, 0, 0]}}\n"
                  "  c: {at: [1, 0, 0], joint: R -y, mass: 1 kg, inertia: {yy: 0.08}, points: {e: "
                  "[1, 0, 0]}}\n"
                  "loops: {close: {between: [b.e, c.e]}}\n",
                  "singular");
}
END_TEST

START_TEST(a_motion_beyond_reach_ends_with_the_name_of_the_loop)
{
    stein_err why = {STEIN_OK, ""};
    stein_sim *sim = start("mechanism: tied\n"
                           "bodies:\n"
                           "  sled: {joint: T x, mass: 1 kg, points: {p: [0, 0, 0]}}\n"
                           "  arm: {joint: R -y, mass: 1 kg, inertia: {yy: 0.01}, points: {e: "
                           "[0.3, 0, 0]}, initial: {position: 1 rad}}\n"
                           "loops: {tie: {between: [sled.p, arm.e], rod: 0.4 m}}\n"
                           "inputs: {pull: {motion: sled}}\n"
                           "simulation: {dt: 1 ms}\n");
    ck_assert_stein(stein_drive(sim, "pull", turn, NULL, err)); // 30 m/s
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_int_eq(stein_run(sim, 1.0, &why), STEIN_ECLOSE);
    ck_assert_msg(strstr(why.msg, "\"tie\" does not stay closed at t = 0.00") != NULL, "%s",
                  why.msg);
    finish(sim);
}
END_TEST

/* ---- refusals ---- */

START_TEST(functions_without_loops_refuse_them)
{
    stein_err why = {STEIN_OK, ""};
    stein_derivative *s = NULL;
    stein_sim *sim = make_sim(&stein_model_four_bar, STEIN_RK4, 0.0);
    ck_assert_int_eq(stein_derivative_create(&s, &stein_model_four_bar, NULL, &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "loops or couplings"));
    ck_assert_int_eq(stein_batch_width(&stein_model_four_bar), 1); // each for itself
    stein_sim_destroy(sim);
}
END_TEST

/* in place of the good file's links and couplings that it has not */
START_TEST(mistakes_are_reported_at_their_place)
{
    static const struct {
        const char *section, *words;
    } wrong[] = {
        {"loops: {c: {between: [key.kapsel, key.front]}}\n", "on one body"},
        {"loops: {c: {between: [key.kapsel]}}\n", "expected two points"},
        {"loops: {c: {from: key.kapsel}}\n", "needs two points"},
        {"loops: {c: {between: [key.kapsel, hammer.haed]}}\n", "hammer.head"},
        {"loops: {c: {between: [key.front, hammer.head], rod: 0 m}}\n", "greater than zero"},
        {"loops: {c: {between: [key.front, hammer.head], slot: w}}\n", "is no axis"},
        {"loops: {c: {between: [key.front, hammer.head], weld: no}}\n", "expected one of yes"},
        {"loops: {c: {between: [key.front, hammer.head], rod: 1 m, slot: x}}\n", "exclude"},
        {"couplings: {c: {joint: key, ratio: 2}}\n", "lacks \"follows\""},
        {"couplings: {c: {joint: key, follows: key}}\n", "cannot follow itself"},
        {"couplings: {c: {joint: key, follows: pawl, ratio: 2 mm}}\n", "the unit is"},
        {"couplings: {c: {joint: key, follows: pwal}}\n", "did you mean \"pawl\""},
        {"couplings: {c: {joint: key, follows: load}}\n", "lacks \"ratio\""},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        mechanism *m = NULL;
        stein_err why = {STEIN_OK, ""};
        char to[400];
        snprintf(to, sizeof to, "%sinputs:\n", wrong[i].section);
        char *text = changed("inputs:\n", to);
        stein_status status =
            mech_read_text(&m, "demo.yaml", text, strlen(text), NULL, 0, NULL, NULL, &why);
        ck_assert_msg(status == STEIN_EPARSE, "%s", wrong[i].section);
        ck_assert_msg(strstr(why.msg, wrong[i].words) != NULL, "%s: %s", wrong[i].section, why.msg);
        free(text);
    }
}
END_TEST

Suite *loops_suite(void)
{
    Suite *suite = suite_create("loops");
    TCase *all = tcase_create("all");
    tcase_set_timeout(all, 60);
    tcase_add_unchecked_fixture(all, make_folder, remove_folder);
    tcase_add_test(all, rows_agree_with_points_and_their_derivatives_with_differences);
    tcase_add_test(all, qdd_is_that_of_all_unknowns_at_once);
    tcase_add_test(all, coupled_joints_move_as_one_with_the_inertia_of_all);
    tcase_add_test(all, the_force_of_a_prescribed_motion_gives_its_energy);
    tcase_add_test(all, the_force_of_a_prescribed_motion_has_the_power_of_inverse_dynamics);
    tcase_add_test(all, loops_stay_closed_with_both_methods_and_whatever_the_step);
    tcase_add_test(all, nothing_drifts_in_many_steps);
    tcase_add_test(all, a_run_of_controlled_error_ends_closed_where_short_steps_do);
    tcase_add_test(all, one_block_holds_all_and_a_saved_state_goes_on_with_the_same_bits);
    tcase_add_test(all, stated_positions_stay_and_the_others_close_the_loop);
    tcase_add_test(all, a_guess_chooses_the_branch_and_does_not_stay);
    tcase_add_test(all, a_loop_that_lies_flat_and_open_is_closed);
    tcase_add_test(all, a_loop_that_cannot_be_closed_is_named_with_its_gap);
    tcase_add_test(all, a_singular_start_is_reported);
    tcase_add_test(all, a_motion_beyond_reach_ends_with_the_name_of_the_loop);
    tcase_add_test(all, functions_without_loops_refuse_them);
    tcase_add_test(all, mistakes_are_reported_at_their_place);
    suite_add_tcase(suite, all);
    return suite;
}
