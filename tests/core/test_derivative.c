/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_derivative.c - generated derivatives against complex steps through the graph they are of.
 * Derivatives of qdd with contacts are in test_derivative_places.c.
 */
#include <complex.h>
#include <string.h>

#include "gen_internal.h"
#include "generator_reference.h"
#include "support.h"

enum { TREES = 60 };

void derivative_places_cases(Suite *suite);

static double *numbers(size_t n)
{
    double *x = calloc(n + 1, sizeof *x);
    ck_assert_ptr_nonnull(x);
    return x;
}

static double worst;

static void assert_same(const char *what, const double *a, const double *b, int n, double rtol)
{
    worst = fmax(worst, assert_near(what, a, b, n, rtol));
}

/* ---- graphs, by complex steps ---------------------------------------------------------------- */

static const double tiny = 1e-200;

/* the values of all nodes, as ex_eval has them, with numbers that carry a derivative */
static void evaluate(const ex_graph *g, const double complex *const var[EX_NVAR],
                     const double complex *constants, double complex *v)
{
    for (int i = 0; i < g->n; i++) {
        const ex_node *nd = &g->node[i];
        double complex a = nd->op > EX_CONST ? v[nd->a] : 0.0;
        double complex b = nd->op >= EX_ADD && nd->op <= EX_DIV ? v[nd->b] : 0.0;
        switch (nd->op) {
        case EX_NUM: v[i] = nd->value; break;
        case EX_VAR: v[i] = var[nd->a] ? var[nd->a][nd->b] : 0.0; break;
        case EX_CONST: v[i] = constants[nd->a]; break;
        case EX_ADD: v[i] = a + b; break;
        case EX_SUB: v[i] = a - b; break;
        case EX_MUL: v[i] = a * b; break;
        case EX_DIV: v[i] = a / b; break;
        case EX_NEG: v[i] = -a; break;
        case EX_SIN: v[i] = csin(a); break;
        case EX_COS: v[i] = ccos(a); break;
        case EX_TAN: v[i] = ctan(a); break;
        case EX_SQRT: v[i] = csqrt(a); break;
        }
    }
}

/* one mechanism at one state: leaves with a direction, and the setup graph at them */
typedef struct place {
    tree t;
    ex_graph setup;
    double complex *p, *q, *qd, *constants;
    double *dp, *dq, *dqd, *dd;
    const ref_state *s;
} place;

static void place_open(place *k, const mechanism *m, const ref_state *s)
{
    size_t n = (size_t)m->nbody;
    ck_assert(ex_graph_init(&k->setup, NULL) == 0 && tree_build(&k->t, m, &k->setup) == 0);
    k->p = calloc((size_t)m->nparam + 1, sizeof *k->p);
    k->q = calloc(n, sizeof *k->q);
    k->qd = calloc(n, sizeof *k->qd);
    ck_assert(k->p && k->q && k->qd);
    k->dp = numbers((size_t)m->nparam);
    k->dq = numbers(n);
    k->dqd = numbers(n);
    k->constants = NULL;
    k->dd = NULL;
    k->s = s;
}

static void place_close(place *k)
{
    free(k->p);
    free(k->q);
    free(k->qd);
    free(k->constants);
    free(k->dp);
    free(k->dq);
    free(k->dqd);
    free(k->dd);
    tree_free(&k->t);
    ex_graph_free(&k->setup);
}

/* leaves and constants along the direction in dp, dq, dqd */
static void place_turn(place *k)
{
    const mechanism *m = k->t.m;
    for (int i = 0; i < m->nparam; i++) {
        k->p[i] = m->params[i].value + I * tiny * k->dp[i];
    }
    for (int i = 0; i < m->nbody; i++) {
        k->q[i] = k->s->q[i] + I * tiny * k->dq[i];
        k->qd[i] = k->s->qd[i] + I * tiny * k->dqd[i];
    }
    free(k->constants);
    free(k->dd);
    k->constants = calloc((size_t)k->setup.n + 1, sizeof *k->constants);
    k->dd = numbers((size_t)k->setup.n);
    ck_assert_ptr_nonnull(k->constants);
    const double complex *const var[EX_NVAR] = {[EX_P] = k->p};
    evaluate(&k->setup, var, NULL, k->constants);
    for (int i = 0; i < k->setup.n; i++) {
        k->dd[i] = cimag(k->constants[i]) / tiny;
    }
}

/* outputs of a function at the place; slope: their derivatives along the direction instead */
static void outputs(const place *k, const func *f, int slope, double *y)
{
    int n = k->t.n;
    double complex *v = calloc((size_t)f->g.n, sizeof *v), *qdd = calloc((size_t)n, sizeof *qdd);
    double complex *dq = calloc((size_t)n, sizeof *dq), *dqd = calloc((size_t)n, sizeof *dqd);
    double complex *dd = calloc((size_t)k->setup.n, sizeof *dd);
    ck_assert(v && qdd && dq && dqd && dd);
    for (int i = 0; i < n; i++) {
        qdd[i] = k->s->qdd[i];
        dq[i] = k->dq[i];
        dqd[i] = k->dqd[i];
    }
    for (int i = 0; i < k->setup.n; i++) {
        dd[i] = k->dd[i];
    }
    const double complex *const var[EX_NVAR] = {
        [EX_Q] = k->q, [EX_QD] = k->qd, [EX_QDD] = qdd, [EX_DQ] = dq, [EX_DQD] = dqd, [EX_DD] = dd};
    evaluate(&f->g, var, k->constants, v);
    for (int i = 0; i < f->nout; i++) {
        y[i] = slope ? cimag(v[f->out[i]]) / tiny : creal(v[f->out[i]]);
    }
    free(v);
    free(qdd);
    free(dq);
    free(dqd);
    free(dd);
}

typedef struct functions {
    func inverse, pose, slopes, along, pose_along;
} functions;

/* by every q and qd */
static void check_slopes(place *k, const functions *f)
{
    int n = k->t.n;
    double *y = numbers(2 * (size_t)n * (size_t)n), *column = numbers((size_t)n);
    double *expected = numbers(2 * (size_t)n * (size_t)n);
    memset(k->dp, 0, sizeof *k->dp * (size_t)k->t.m->nparam);
    for (int j = 0; j < 2 * n; j++) {
        for (int i = 0; i < n; i++) {
            k->dq[i] = j == i;
            k->dqd[i] = j == n + i;
        }
        place_turn(k);
        outputs(k, &f->inverse, 1, column);
        for (int i = 0; i < n; i++) {
            expected[j / n * n * n + i * n + j % n] = column[i];
        }
    }
    outputs(k, &f->slopes, 0, y);
    assert_same("Q by q", y, expected, n * n, 1e-12);
    assert_same("Q by qd", y + n * n, expected + n * n, n * n, 1e-12);
    free(y);
    free(expected);
    free(column);
}

/* along a random direction of everything */
static void check_along(place *k, const functions *f, unsigned long long *seed)
{
    int n = k->t.n, npose = 7 * k->t.ncarrier;
    double *y = numbers((size_t)n), *expected = numbers((size_t)n);
    double *pose = numbers((size_t)npose), *dpose = numbers((size_t)npose);
    for (int i = 0; i < n; i++) {
        k->dq[i] = noise(seed);
        k->dqd[i] = noise(seed);
    }
    for (int i = 0; i < k->t.m->nparam; i++) {
        k->dp[i] = noise(seed);
    }
    place_turn(k);
    outputs(k, &f->inverse, 1, expected);
    outputs(k, &f->along, 0, y);
    assert_same("Q along", y, expected, n, 1e-12);
    outputs(k, &f->pose, 1, pose);
    outputs(k, &f->pose_along, 0, dpose);
    assert_same("poses along", dpose, pose, npose, 1e-12);
    free(y);
    free(expected);
    free(pose);
    free(dpose);
}

/* the setup's own derivative: all of its nodes */
static void check_setup(place *k)
{
    int n = k->setup.n;
    ex *out = calloc(2 * (size_t)n, sizeof *out), *slope = out + n;
    double *y = numbers((size_t)n), *expected = numbers((size_t)n);
    for (int i = 0; i < n; i++) {
        out[i] = i;
        expected[i] = k->dd[i];
    }
    derive_along(&k->setup, out, n, slope);
    double complex *v = calloc((size_t)k->setup.n, sizeof *v);
    double complex *dp = calloc((size_t)k->t.m->nparam + 1, sizeof *dp);
    ck_assert(out && v && dp);
    for (int i = 0; i < k->t.m->nparam; i++) {
        dp[i] = k->dp[i];
    }
    const double complex *const var[EX_NVAR] = {[EX_P] = k->p, [EX_DP] = dp};
    evaluate(&k->setup, var, NULL, v);
    for (int i = 0; i < n; i++) {
        y[i] = creal(v[slope[i]]);
        ck_assert_close(y[i], expected[i], 1e-12, 1e-12);
    }
    free(out);
    free(v);
    free(dp);
    free(y);
    free(expected);
}

static void check_graphs(const mechanism *m, unsigned long long *seed)
{
    int n = m->nbody;
    place k;
    functions f = {.inverse = {.out = NULL}};
    ref_state s = ref_state_random(n, seed);
    place_open(&k, m, &s);
    ck_assert(func_search(&f.inverse, &k.t, dyn_inverse, n) == 0 &&
              func_search(&f.pose, &k.t, kin_pose, 7 * k.t.ncarrier) == 0 &&
              func_like(&f.slopes, &k.t, &f.inverse, slope_inverse, 2 * n * n) == 0 &&
              func_like(&f.along, &k.t, &f.inverse, along_inverse, n) == 0 &&
              func_like(&f.pose_along, &k.t, &f.pose, along_pose, 7 * k.t.ncarrier) == 0);
    check_slopes(&k, &f);
    check_along(&k, &f, seed);
    check_setup(&k);
    func_free(&f.inverse);
    func_free(&f.pose);
    func_free(&f.slopes);
    func_free(&f.along);
    func_free(&f.pose_along);
    place_close(&k);
    ref_state_free(&s);
}

START_TEST(graphs_agree_with_complex_steps_on_random_trees)
{
    for (int k = 0; k < TREES; k++) {
        char name[24];
        unsigned long long seed = 4711u + 977u * (unsigned)k;
        snprintf(name, sizeof name, "tree%d", k);
        mechanism *m = ref_tree(name, 1 + k % 9, k % 3 == 0, &seed);
        if (k % 4 == 1) {
            ref_armatures(m, &seed);
        }
        check_graphs(m, &seed);
        ref_tree_free(m);
    }
    printf("derivatives of random trees: off by %.2g of their size at most\n", worst);
}
END_TEST

START_TEST(graphs_agree_with_complex_steps_on_the_mechanisms)
{
    static const char *const folder[] = {"models", "models/robotran"};
    worst = 0.0;
    for (int i = 0; stein_models[i] != NULL; i++) {
        mechanism *m = NULL;
        for (int k = 0; m == NULL && k < 2; k++) {
            char path[160];
            stein_err err;
            snprintf(path, sizeof path, "%s/%s.yaml", folder[k], stein_models[i]->name);
            (void)mech_read(&m, path, NULL, 0, NULL, NULL, &err);
        }
        ck_assert_msg(m != NULL, "%s", stein_models[i]->name);
        unsigned long long seed = 31u + (unsigned)i;
        check_graphs(m, &seed);
        mech_free(m);
    }
    printf("derivatives of the mechanisms: off by %.2g of their size at most\n", worst);
}
END_TEST

Suite *derivative_suite(void)
{
    Suite *suite = suite_create("derivative");
    TCase *graphs = tcase_create("graphs");
    tcase_add_test(graphs, graphs_agree_with_complex_steps_on_random_trees);
    tcase_add_test(graphs, graphs_agree_with_complex_steps_on_the_mechanisms);
    tcase_set_timeout(graphs, 60);
    suite_add_tcase(suite, graphs);
    derivative_places_cases(suite);
    return suite;
}
