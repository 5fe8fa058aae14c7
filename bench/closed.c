/* SPDX-License-Identifier: GPL-3.0-or-later
 * closed.c - the simple piano tree (piano3.yaml) by hand, against the generated equations: one
 * state after the other, and in lanes.
 *
 *      t = e cos q1,  h = e sin q1,  e = L m1 s1
 *      M00 = A + 2t,  M01 = C + t,  M11 = C,  M22 = B
 *      g = k1 cos(q0 + q1)
 *      c0 = k0 cos q0 + g - h v1 (2 v0 + v1)
 *      c1 = g + h v0^2
 *      c2 = k2 cos q2
 *
 * with the hinge at L on the key and all centres at s on the axes.
 *
 * 20 operations and 5 sines and cosines: nothing is left to simplify. M is written in full, as the
 * generated function does. None of them has external forces.
 */
#include <math.h>
#include <string.h>

#include "bench.h"
#include "elementary.h"
#include "equations.h"
#include "mujoco.h"

extern const stein_model stein_model_piano3;

/* the constants of the comment above */
typedef struct tree {
    double A, B, C, e, k0, k1, k2;
} tree;

static tree by_hand;
static stein_sim *sim;
static double q[BENCH_STATES][3], qd[BENCH_STATES][3];
static double d[256];

static double get(const char *name)
{
    double value = 0.0;
    stein_err err;
    bench_need(stein_get(sim, name, &value, &err), &err, name);
    return value;
}

static void find_constants(void)
{
    double L = get("hammer.at.x"), m0 = get("key.mass"), m1 = get("hammer.mass");
    double s0 = get("key.centre.x"), s1 = get("hammer.centre.x");
    double m2 = get("pawl.mass"), s2 = get("pawl.centre.x"), g = 9.81;
    by_hand = (tree){.C = get("hammer.inertia.yy") + m1 * s1 * s1,
                     .B = get("pawl.inertia.yy") + m2 * s2 * s2,
                     .e = L * m1 * s1,
                     .k0 = g * (m0 * s0 + m1 * L),
                     .k1 = g * m1 * s1,
                     .k2 = g * m2 * s2};
    by_hand.A = get("key.inertia.yy") + m0 * s0 * s0 + m1 * L * L + by_hand.C;
}

static inline void finish(const tree *p, const double *v, double s0, double c0, double s1,
                          double c1, double c2, double *M, double *c)
{
    double t = p->e * c1, h = p->e * s1, g = p->k1 * (c0 * c1 - s0 * s1);
    M[0] = p->A + 2.0 * t;
    M[1] = M[3] = p->C + t;
    M[4] = p->C;
    M[8] = p->B;
    M[2] = M[5] = M[6] = M[7] = 0.0;
    c[0] = p->k0 * c0 + g - h * v[1] * (2.0 * v[0] + v[1]);
    c[1] = g + h * v[0] * v[0];
    c[2] = p->k2 * c2;
}

/* functions behind a pointer, as the generated ones are */
typedef void mass_bias(const tree *p, const double *x, const double *v, double *M, double *c);

static void with_libm(const tree *p, const double *x, const double *v, double *M, double *c)
{
    double s0 = sin(x[0]), c0 = cos(x[0]), s1 = sin(x[1]), c1 = cos(x[1]);
    finish(p, v, s0, c0, s1, c1, cos(x[2]), M, c);
}

static void with_ours(const tree *p, const double *x, const double *v, double *M, double *c)
{
    double s0, c0, s1, c1, s2, c2;
    stein__sincos(x[0], &s0, &c0);
    stein__sincos(x[1], &s1, &c1);
    stein__sincos(x[2], &s2, &c2);
    finish(p, v, s0, c0, s1, c1, c2, M, c);
}

static mass_bias *volatile hand[] = {with_libm, with_ours};

static double sum_of(const double *M, const double *c)
{
    return M[0] + M[1] + M[8] + c[0] + c[1] + c[2];
}

static double run_hand(void *ctx, long n)
{
    mass_bias *f = hand[*(const int *)ctx];
    double M[9], c[3], sum = 0.0;
    for (long i = 0; i < n; i++) {
        f(&by_hand, q[i % BENCH_STATES], qd[i % BENCH_STATES], M, c);
        sum += sum_of(M, c);
    }
    return sum;
}

static double run_generated(void *ctx, long n)
{
    const stein_model *model = ctx;
    double sc[6], M[9], c[3], sum = 0.0;
    for (long i = 0; i < n; i++) {
        const double *x = q[i % BENCH_STATES], *v = qd[i % BENCH_STATES];
        stein_turn(model, x, sc);
        model->unloaded(x, v, sc, d, M, c);
        sum += sum_of(M, c);
    }
    return sum;
}

/* the forward dynamics of the generated equations without forces: qdd = -M^-1 c */
static double run_forward(void *ctx, long n)
{
    const stein_model *model = ctx;
    double sc[6], M[9], c[3], sum = 0.0;
    for (long i = 0; i < n; i++) {
        const double *x = q[i % BENCH_STATES], *v = qd[i % BENCH_STATES];
        stein_turn(model, x, sc);
        model->unloaded(x, v, sc, d, M, c);
        model->solve(M, c);
        sum += c[0] + c[1] + c[2];
    }
    return sum;
}

/* ---- in lanes ---- */

enum { WIDEST = 8 };
static double lane_q[BENCH_STATES * 3] __attribute__((aligned(64)));
static double lane_qd[BENCH_STATES * 3] __attribute__((aligned(64)));

static double run_lanes(void *ctx, long n)
{
    const equations_in_lanes *e = ctx;
    double sum = 0.0;
    for (long i = 0; i < n; i += BENCH_STATES) {
        sum += e->sum(lane_q, lane_qd, BENCH_STATES);
    }
    return sum;
}

/* state i, in lane i % n, with the same bits as alone. @return numbers that differ */
static int other_bits(int i, int n, const double *lane_M, const double *lane_c)
{
    double sc[6], M[9], c[3];
    int wrong = 0;
    stein_turn(&stein_model_piano3, q[i], sc);
    stein_model_piano3.unloaded(q[i], qd[i], sc, d, M, c);
    for (int k = 0; k < 9; k++) {
        wrong += memcmp(&M[k], &lane_M[k * n + i % n], sizeof *M) != 0;
    }
    for (int k = 0; k < 3; k++) {
        wrong += memcmp(&c[k], &lane_c[k * n + i % n], sizeof *c) != 0;
    }
    return wrong;
}

static void check_lanes(const equations_in_lanes *e)
{
    double M[9 * WIDEST] __attribute__((aligned(64))) = {0.0};
    double c[3 * WIDEST] __attribute__((aligned(64))) = {0.0};
    int n = e->lanes, wrong = 0;
    for (int i = 0; i < BENCH_STATES; i++) {
        for (int j = 0; j < 3; j++) {
            lane_q[(i / n * 3 + j) * n + i % n] = q[i][j];
            lane_qd[(i / n * 3 + j) * n + i % n] = qd[i][j];
        }
    }
    e->prepare(d, stein_model_piano3.nd);
    for (int i = 0; i < BENCH_STATES; i++) {
        if (i % n == 0) {
            e->mass_bias(lane_q + (size_t)i * 3, lane_qd + (size_t)i * 3, M, c);
        }
        wrong += other_bits(i, n, M, c);
    }
    bench_check("M and c of piano3 in lanes (numbers with other bits)", wrong, 0.0);
}

static void check_hand(mass_bias *f, const char *what)
{
    double worst = 0.0;
    for (int i = 0; i < BENCH_STATES; i++) {
        double M[9], c[3], M1[9], c1[3];
        f(&by_hand, q[i], qd[i], M, c);
        stein_mass_bias(sim, q[i], qd[i], NULL, NULL, M1, c1);
        for (int k = 0; k < 9; k++) {
            worst = fmax(worst, fabs(M[k] - M1[k]) / by_hand.A);
        }
        for (int k = 0; k < 3; k++) {
            worst = fmax(worst, fabs(c[k] - c1[k]) / by_hand.k0);
        }
    }
    bench_check(what, worst, 1e-14);
}

const equations_in_lanes *equations_of_width(int lanes)
{
    (void)lanes;
#if STEIN_WIDEST == 8
    if (lanes == 8) {
        return &equations8;
    }
    if (lanes == 4) {
        return &equations4;
    }
#endif
#if STEIN_WIDEST >= 2
    if (lanes == 2) {
        return &equations2;
    }
#endif
    return NULL;
}

static bench_case *of_libm, *of_ours, *of_generated, *of_forward, *of_lanes;

void closed_add(void)
{
    static const int which[] = {0, 1};
    static const char name[] = "piano3";
    const stein_model *model = &stein_model_piano3;
    double p[128];
    stein_err err;
    bench_need(stein_sim_create(&sim, model, NULL, &err), &err, name);
    find_constants();
    for (int i = 0; i < BENCH_STATES; i++) {
        for (int j = 0; j < 3; j++) {
            q[i][j] = 0.7 * bench_noise();
            qd[i][j] = 2.0 * bench_noise();
        }
    }
    if (model->np > (int)(sizeof p / sizeof *p) || model->nd > (int)(sizeof d / sizeof *d)) {
        bench_check("room for the numbers of piano3", 1.0, 0.0);
        return;
    }
    for (int i = 0; i < model->np; i++) {
        p[i] = model->params[i].value;
    }
    stein_setup(model, p, d);
    check_hand(with_libm, "M and c by hand, sines of libm");
    check_hand(with_ours, "M and c by hand, our sines");
    of_libm = bench_add("closed", name, "M and c by hand, sines of libm", run_hand,
                        (void *)(size_t)&which[0]);
    of_ours = bench_add("closed", name, "M and c by hand, our sines", run_hand,
                        (void *)(size_t)&which[1]);
    of_generated =
        bench_add("closed", name, "M and c, generated", run_generated, (void *)(size_t)model);
    if (of_generated != NULL) {
        of_generated->ops = &model->ops_unloaded;
    }
    of_forward = bench_add("closed", name, "forward dynamics, generated", run_forward,
                           (void *)(size_t)model);
    mujoco_add(sim, (const double(*)[3])q, (const double(*)[3])qd, BENCH_STATES);
    const equations_in_lanes *e = equations_of_width(stein_batch_width(&stein_model_stein1788));
    if (e != NULL) {
        check_lanes(e);
        of_lanes =
            bench_add("closed", name, "M and c in lanes, a state", run_lanes, (void *)(size_t)e);
        if (of_lanes != NULL) {
            of_lanes->least = BENCH_STATES;
        }
    }
}

void closed_rows(void)
{
    char what[96];
    bench_ratio("M+c of the simple tree, generated : by hand with the same sines", of_generated,
                of_ours, 1.0, 1.05, 0);
    bench_ratio("M+c of the simple tree, generated : by hand with sines of libm", of_generated,
                of_libm, 1.0, 1.05, 0);
    mujoco_rows(of_generated, of_forward);
    const equations_in_lanes *e = equations_of_width(stein_batch_width(&stein_model_stein1788));
    if (e != NULL) {
        snprintf(what, sizeof what, "M+c of the simple tree, a state in %d lanes : alone",
                 e->lanes);
        bench_ratio(what, of_lanes, of_generated, 1.0, e->lanes == 8 ? 1.0 / 6.0 : 0.0, 0);
    }
}
