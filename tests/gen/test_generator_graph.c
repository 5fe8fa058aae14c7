/* SPDX-License-Identifier: MIT
 * test_generator_graph.c - expressions: sharing, signs, terms moved to the setup, counts, values.
 */
#include <stdlib.h>

#include "expr.h"
#include "support.h"

void generator_graph_cases(Suite *suite);

typedef struct graphs {
    ex_graph setup, g;
    ex a, b, c, x, y, z; /* a, b, c parameters as seen from g; x, y, z coordinates */
} graphs;

static graphs *graphs_new(void)
{
    graphs *s = calloc(1, sizeof *s);
    ck_assert(s && ex_graph_init(&s->setup, NULL) == 0 && ex_graph_init(&s->g, &s->setup) == 0);
    s->a = ex_const(&s->g, ex_var(&s->setup, EX_P, 0));
    s->b = ex_const(&s->g, ex_var(&s->setup, EX_P, 1));
    s->c = ex_const(&s->g, ex_var(&s->setup, EX_P, 2));
    s->x = ex_var(&s->g, EX_Q, 0);
    s->y = ex_var(&s->g, EX_Q, 1);
    s->z = ex_var(&s->g, EX_Q, 2);
    return s;
}

static void graphs_free(graphs *s)
{
    ex_graph_free(&s->g);
    ex_graph_free(&s->setup);
    free(s);
}

START_TEST(equal_expressions_are_one_node)
{
    graphs *s = graphs_new();
    ex_graph *g = &s->g;
    ck_assert_int_eq(ex_mul(g, s->x, s->y), ex_mul(g, s->y, s->x));
    ck_assert_int_eq(ex_add(g, s->x, s->y), ex_add(g, s->y, s->x));
    ck_assert_int_eq(ex_sub(g, s->x, s->y), ex_neg(g, ex_sub(g, s->y, s->x)));
    ck_assert_int_eq(ex_mul(g, s->a, ex_mul(g, s->b, s->x)),
                     ex_mul(g, ex_mul(g, s->a, s->b), s->x));
    ck_assert_int_ne(ex_mul(g, s->x, s->x), ex_mul(g, s->x, s->y));
    graphs_free(s);
}
END_TEST

START_TEST(zeros_ones_and_signs_vanish)
{
    graphs *s = graphs_new();
    ex_graph *g = &s->g;
    ex one = ex_num(g, 1.0), minus = ex_num(g, -1.0), nx = ex_neg(g, s->x), ny = ex_neg(g, s->y);
    ck_assert_int_eq(ex_mul(g, 0, s->x), 0);
    ck_assert_int_eq(ex_add(g, s->x, 0), s->x);
    ck_assert_int_eq(ex_sub(g, s->x, s->x), 0);
    ck_assert_int_eq(ex_mul(g, one, s->x), s->x);
    ck_assert_int_eq(ex_mul(g, minus, s->x), nx);
    ck_assert_int_eq(ex_mul(g, nx, ny), ex_mul(g, s->x, s->y));
    ck_assert_int_eq(ex_add(g, s->x, ny), ex_sub(g, s->x, s->y));
    ex ratio = ex_div(g, s->x, s->y);
    ck_assert_int_eq(ex_div(g, nx, s->y), ex_neg(g, ratio));
    ck_assert_int_eq(ex_div(g, s->x, ny), ex_neg(g, ratio));
    ck_assert_int_eq(ex_div(g, nx, ny), ratio);
    ck_assert_int_eq(ex_div(g, s->x, one), s->x);
    ck_assert_int_eq(ex_div(g, 0, s->x), 0);
    ck_assert_int_eq(ex_fun(g, EX_COS, nx), ex_fun(g, EX_COS, s->x));
    ck_assert_int_eq(ex_fun(g, EX_SIN, nx), ex_neg(g, ex_fun(g, EX_SIN, s->x)));
    ck_assert_int_eq(ex_fun(g, EX_COS, 0), one);
    ck_assert_int_eq(ex_num(g, -2.5), ex_neg(g, ex_num(g, 2.5)));
    ck_assert_int_eq(ex_mul(g, s->a, minus), ex_neg(g, s->a));
    graphs_free(s);
}
END_TEST

/* the evaluator that the equations are compared with */
START_TEST(every_operation_is_evaluated)
{
    graphs *s = graphs_new();
    ex_graph *g = &s->g;
    const double q[] = {0.73, 1.31, -0.2}, p[] = {1.7, -2.3, 0.9};
    const double *const pvar[EX_NVAR] = {[EX_P] = p}, *const var[EX_NVAR] = {[EX_Q] = q};
    const ex of[] = {ex_add(g, s->x, s->y),   ex_sub(g, s->x, s->y),   ex_mul(g, s->x, s->y),
                     ex_div(g, s->x, s->y),   ex_neg(g, s->x),         ex_fun(g, EX_SIN, s->x),
                     ex_fun(g, EX_COS, s->x), ex_fun(g, EX_TAN, s->x), ex_fun(g, EX_SQRT, s->x),
                     ex_mul(g, s->a, s->z),   ex_num(g, -2.5),         ex_div(g, s->a, s->b)};
    const double is[] = {0.73 + 1.31, 0.73 - 1.31, 0.73 * 1.31, 0.73 / 1.31, -0.73, sin(0.73),
                         cos(0.73),   tan(0.73),   sqrt(0.73),  1.7 * -0.2,  -2.5,  1.7 / -2.3};
    double k[64], v[64];
    ck_assert(s->setup.n <= 64 && g->n <= 64);
    ex_eval(&s->setup, pvar, NULL, k);
    ex_eval(g, var, k, v);
    for (size_t i = 0; i < sizeof is / sizeof *is; i++) {
        ck_assert_close(v[of[i]], is[i], 4e-16, 0.0);
    }
    graphs_free(s);
}
END_TEST

START_TEST(parameter_arithmetic_moves_to_setup)
{
    graphs *s = graphs_new();
    ex_graph *g = &s->g;
    ex ab = ex_add(g, ex_mul(g, s->a, s->b), s->c);
    ck_assert_int_eq(g->node[ab].op, EX_CONST);
    ex ax = ex_mul(g, s->a, s->x), twice = ex_add(g, ax, ax); /* one addition, no other parameter */
    ck_assert(g->node[twice].op == EX_ADD && g->node[twice].a == ax && g->node[twice].b == ax);
    ex sum = ex_add(g, ex_mul(g, s->a, s->x), ex_mul(g, s->b, s->x)); /* (a + b) x */
    stein_ops o;
    ck_assert_int_eq(ex_count(g, &sum, 1, &o), 0);
    ck_assert_int_eq(o.mul, 1);
    ck_assert_int_eq(o.add, 0);
    graphs_free(s);
}
END_TEST

START_TEST(counts_follow_robotrans_convention)
{
    graphs *s = graphs_new();
    ex_graph *g = &s->g;
    ex xy = ex_mul(g, s->x, s->y), sine = ex_fun(g, EX_SIN, s->z);
    (void)ex_mul(g, s->z, s->z); /* dead code is not counted */
    const ex out[3] = {ex_neg(g, ex_add(g, xy, sine)), ex_sub(g, xy, ex_div(g, s->x, s->z)), xy};
    stein_ops o;
    ck_assert_int_eq(ex_count(g, out, 3, &o),
                     0); /* x y and sin z once, the sign of an output free */
    ck_assert_int_eq(o.add, 2);
    ck_assert_int_eq(o.mul, 1);
    ck_assert_int_eq(o.div, 1);
    ck_assert_int_eq(o.trig, 1);
    ck_assert_int_eq(o.neg, 0);
    graphs_free(s);
}
END_TEST

void generator_graph_cases(Suite *suite)
{
    TCase *t = tcase_create("graph");
    tcase_add_test(t, equal_expressions_are_one_node);
    tcase_add_test(t, zeros_ones_and_signs_vanish);
    tcase_add_test(t, every_operation_is_evaluated);
    tcase_add_test(t, parameter_arithmetic_moves_to_setup);
    tcase_add_test(t, counts_follow_robotrans_convention);
    suite_add_tcase(suite, t);
}
