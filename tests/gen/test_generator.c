/* SPDX-License-Identifier: MIT
 * test_generator.c - the generator: equations against an independent route (generator_reference.c),
 * as graphs and compiled. Expressions and texts are in test_generator_graph.c, _text.c.
 */
#include <dirent.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "generator_reference.h"
#include "gen_internal.h"
#include "support.h"

/* 1 to 12 bodies, every third tree in the plane, with and without armatures: that repeats after 24
 * trees; `make soak` draws each case twice */
enum { TREES = 48, MODELS_MAX = 40 };

static int trees(void)
{
    return soaks() > 0 ? TREES : TREES / 2;
}

static const char strict_flags[] =
    "-std=c11 -O0 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wstrict-prototypes "
    "-Wmissing-prototypes -Wundef -Wvla -Werror";

static double *numbers_new(size_t n)
{
    double *x = calloc(n + 1, sizeof *x);
    ck_assert_ptr_nonnull(x);
    return x;
}

static double worst; /* relative error seen in this test */

static void assert_same(const char *what, const double *a, const double *b, int n, double rtol)
{
    worst = fmax(worst, assert_near(what, a, b, n, rtol));
}

/* ---- expression graphs ---------------------------------------------------------------------- */

/* ---- equations by the graph evaluator ------------------------------------------------------- */

/** Evaluate one function's graph at the parameter values of m. */
static void evaluate_under(const tree *t, builder *build, int nout, const ref_state *s,
                           const double *tau, double *result)
{
    func f = {.out = NULL};
    ck_assert_int_eq(func_search(&f, t, build, nout), 0);
    double *p = numbers_new((size_t)t->m->nparam), *k = numbers_new((size_t)t->setup->n);
    double *v = numbers_new((size_t)f.g.n);
    for (int i = 0; i < t->m->nparam; i++) {
        p[i] = t->m->params[i].value;
    }
    const double *const pvar[EX_NVAR] = {[EX_P] = p};
    const double *const var[EX_NVAR] = {[EX_Q] = s->q,     [EX_QD] = s->qd,   [EX_QDD] = s->qdd,
                                        [EX_FRC] = s->frc, [EX_TRQ] = s->trq, [EX_TAU] = tau};
    ex_eval(t->setup, pvar, NULL, k);
    ex_eval(&f.g, var, k, v);
    for (int i = 0; i < nout; i++) {
        result[i] = v[f.out[i]];
    }
    func_free(&f);
    free(p);
    free(k);
    free(v);
}

static void evaluate(const tree *t, builder *build, int nout, const ref_state *s, double *result)
{
    evaluate_under(t, build, nout, s, NULL, result);
}

/** M qdd + c of a reference. */
static void inverse_of(const ref_out *r, const ref_state *s, int n, double *Q)
{
    for (int i = 0; i < n; i++) {
        Q[i] = r->c[i];
        for (int j = 0; j < n; j++) {
            Q[i] += r->M[i * n + j] * s->qdd[j];
        }
    }
}

/* no forces and moments on bodies */
static void unload(ref_state *s, int n)
{
    memset(s->frc, 0, sizeof *s->frc * 3 * (size_t)n);
    memset(s->trq, 0, sizeof *s->trq * 3 * (size_t)n);
}

static void check_by_graph(const mechanism *m, unsigned long long *seed)
{
    int n = m->nbody, np = m->npoint;
    ref_out r = ref_out_new(n, np);
    ref_state s = ref_state_random(n, seed);
    double *Q = numbers_new((size_t)n),
           *y = numbers_new((size_t)(n * n + 10 * n + 9 * np + 3 * np * n));
    ex_graph setup;
    tree t;
    ck_assert(ex_graph_init(&setup, NULL) == 0 && tree_build(&t, m, &setup) == 0);
    ref_evaluate(m, &s, &r);
    inverse_of(&r, &s, n, Q);
    evaluate(&t, dyn_mass_bias, n * n + n, &s, y);
    assert_same("M", y, r.M, n * n, 1e-12);
    assert_same("c", y + n * n, r.c, n, 1e-12);
    evaluate(&t, dyn_inverse, n, &s, y);
    assert_same("Q", y, Q, n, 1e-12);
    evaluate(&t, kin_point, 9 * np + 3 * np * n, &s, y);
    assert_same("x", y, r.x, 3 * np, 1e-12);
    assert_same("v", y + 3 * np, r.v, 3 * np, 1e-12);
    assert_same("J", y + 6 * np, r.J, 3 * np * n, 1e-12);
    assert_same("jdqd", y + 6 * np + 3 * np * n, r.jdqd, 3 * np, 1e-12);
    evaluate(&t, kin_energy, 2, &s, y);
    ck_assert_close(y[0], r.kinetic, 1e-12, 0.0);
    ck_assert_close(y[1], r.potential, 1e-12, 1e-12);
    evaluate(&t, kin_pose, 7 * t.ncarrier, &s, y);
    for (int k = 0; k < t.ncarrier; k++) {
        assert_same("pose", y + 7 * k, r.pose + 7 * t.carrier[k], 7, 1e-12);
    }
    tree_free(&t);
    ex_graph_free(&setup);
    ref_out_free(&r);
    ref_state_free(&s);
    free(Q);
    free(y);
}

static mechanism *tree_number(int k, unsigned long long *seed)
{
    char name[24];
    *seed = 1788u + 977u * (unsigned)k;
    snprintf(name, sizeof name, "tree%d", k);
    return ref_tree(name, 1 + k % 12, k % 3 == 0, seed);
}

/* a fifth of those that are compiled further down */
START_TEST(graphs_agree_with_lagrange_on_random_trees)
{
    for (int k = 0; k < trees(); k += 5) {
        unsigned long long seed;
        mechanism *m = tree_number(k, &seed);
        check_by_graph(m, &seed);
        ref_armatures(m, &seed);
        check_by_graph(m, &seed);
        ref_tree_free(m);
    }
}
END_TEST

/* charts of balls, anywhere in a tree: joints that keep their angle */
START_TEST(graphs_agree_with_lagrange_where_joints_keep_their_angle)
{
    for (int k = 1; k < trees(); k += 7) {
        unsigned long long seed;
        mechanism *m = tree_number(k, &seed);
        ref_armatures(m, &seed);
        for (int i = k % 2; i < m->nbody; i += 3) {
            m->bodies[i].ball = m->bodies[i].type == 'R';
        }
        check_by_graph(m, &seed);
        ref_tree_free(m);
    }
}
END_TEST

START_TEST(graphs_agree_with_lagrange_on_a_six_axis_arm)
{
    unsigned long long seed = 90;
    mechanism *m = ref_arm("arm6", "zyyxyx", &seed);
    check_by_graph(m, &seed);
    ref_tree_free(m);
}
END_TEST

/* trees of which every joint turns, in space and in the plane, with branches and parallel joints */
START_TEST(articulated_bodies_agree_with_lagrange)
{
    for (int k = 0; k < trees(); k += 3) {
        unsigned long long seed;
        mechanism *m = tree_number(k + _i, &seed);
        int n = m->nbody, planar = (k + _i) % 3 == 0;
        for (int i = 0; i < n; i++) {
            m->bodies[i].type = 'R';
            m->bodies[i].axis = planar ? 'y' : m->bodies[i].axis;
            for (int l = 0; l < 3; l++) { // a sliding body needs no inertia
                mech_scalar *own = &m->bodies[i].inertia[l];
                if (own->kind == MECH_ZERO) {
                    *own = (mech_scalar){MECH_PARAM, m->nparam, 0.7};
                    m->params[m->nparam++].value = 0.7;
                }
            }
        }
        if (k / 3 % 2 == 1) {
            ref_armatures(m, &seed);
        }
        ref_out r = ref_out_new(n, m->npoint);
        ref_state s = ref_state_random(n, &seed);
        double *Q = numbers_new((size_t)n), *y = numbers_new(2 * (size_t)n);
        ex_graph setup;
        tree t;
        ck_assert(ex_graph_init(&setup, NULL) == 0 && tree_build(&t, m, &setup) == 0);
        unload(&s, n);
        ref_evaluate(m, &s, &r);
        inverse_of(&r, &s, n, Q);
        ck_assert(dyn_articulates(&t));
        evaluate_under(&t, dyn_articulated, 2 * n, &s, Q, y);
        assert_same("qdd", y, s.qdd, n, 1e-9);
        for (int i = 0; i < n; i++) {
            ck_assert(y[n + i] > 0.0);
        }
        tree_free(&t);
        ex_graph_free(&setup);
        ref_out_free(&r);
        ref_state_free(&s);
        ref_tree_free(m);
        free(Q);
        free(y);
    }
    printf("qdd by articulated bodies: worst %.1e relative\n", worst);
}
END_TEST

/* every operation of a formula: the reference takes the numbers that the reader worked out */
START_TEST(formulas_agree_with_the_reader)
{
    static const char file[] =
        "mechanism: formulas\n"
        "parameters: {g.arm: 0.31 m, g.lean: 23 deg, g.deep: 0.07 m}\n"
        "bodies:\n"
        "  one:\n"
        "    joint: R y\n"
        "    mass: 2 kg\n"
        "    inertia: {yy: 0.3}\n"
        "    centre: [g.arm * tan(g.lean), 0, -g.deep]\n"
        "  two:\n"
        "    parent: one\n"
        "    joint: R y\n"
        "    mass: 1 kg\n"
        "    at: [sqrt(g.arm * g.arm + g.deep * g.deep), 0, g.arm * sin(g.lean) - g.deep / 3]\n"
        "    centre: [g.deep * cos(g.lean), 0, 0.01 m]\n";
    mechanism *m = NULL;
    unsigned long long seed = 5;
    ck_assert_stein(
        mech_read_text(&m, "test.yaml", file, sizeof file - 1, NULL, 0, NULL, NULL, err));
    check_by_graph(m, &seed);
    mech_free(m);
}
END_TEST

/* ---- the compiled text ---------------------------------------------------------------------- */

typedef struct workshop {
    char dir[64];
    void *library;
} workshop;

static workshop workshop_open(void)
{
    workshop w = {.dir = "/tmp/stein-generator-XXXXXX"};
    ck_assert_ptr_nonnull(mkdtemp(w.dir));
    return w;
}

static void workshop_add(const workshop *w, const mechanism *m)
{
    gen_result r;
    char path[160];
    ck_assert_stein(gen_equations(&r, m, err));
    snprintf(path, sizeof path, "%s/%s.c", w->dir, m->name);
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    ck_assert_uint_eq(fwrite(r.source, 1, r.size, f), r.size);
    ck_assert_int_eq(fclose(f), 0);
    gen_free(&r);
}

/* plain: without derivatives, in half the time */
static void workshop_build(workshop *w, int plain)
{
    char command[512];
    const char *cc = getenv("CC");
    snprintf(command, sizeof command, "%s %s%s -fPIC -shared -Iinclude -o %s/all.so %s/*.c -lm",
             cc && *cc ? cc : "cc", strict_flags, plain ? " -DSTEIN_PLAIN" : "", w->dir, w->dir);
    ck_assert_msg(system(command) == 0, "%s", command);
    snprintf(command, sizeof command, "%s/all.so", w->dir);
    w->library = dlopen(command, RTLD_NOW | RTLD_LOCAL);
    ck_assert_msg(w->library != NULL, "%s", dlerror());
}

static void workshop_close(workshop *w)
{
    char command[128];
    if (w->library) {
        dlclose(w->library);
    }
    snprintf(command, sizeof command, "rm -rf %s", w->dir);
    ck_assert_int_eq(system(command), 0);
}

static const stein_model *workshop_model(const workshop *w, const char *name)
{
    char symbol[80];
    snprintf(symbol, sizeof symbol, "stein_model_%s", name);
    const stein_model *model = dlsym(w->library, symbol);
    ck_assert_msg(model != NULL, "%s", symbol);
    return model;
}

/* M x = b for a positive definite M with the branches of the tree */
static void check_solved(const stein_model *model, unsigned long long *seed)
{
    int n = model->nq;
    // with loops it is another system, with balls there are no lanes, beyond 16 joints a loop
    ck_assert((model->solve != NULL) == (n <= 16 && model->nrow == 0 && model->nball == 0));
    if (model->solve == NULL) {
        return;
    }
    double *M = numbers_new((size_t)n * (size_t)n), *b = numbers_new((size_t)n);
    double *x = numbers_new((size_t)n), *back = numbers_new((size_t)n);
    for (int i = 0; i < n; i++) {
        M[i * n + i] = n + 0.5 * noise(seed);
        b[i] = x[i] = noise(seed);
        for (int j = model->bodies[i].parent; j >= 0; j = model->bodies[j].parent) {
            M[i * n + j] = M[j * n + i] = noise(seed);
        }
    }
    ck_assert(model->solve(M, x) == -1);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            back[i] += M[i * n + j] * x[j];
        }
    }
    assert_same("M x", back, b, n, 1e-12);
    M[0] = -1.0; // no mass
    ck_assert_int_eq(model->solve(M, x), 0);
    free(M);
    free(b);
    free(x);
    free(back);
}

/* Q as a function of the way s along a direction */
static void inverse_along(const stein_model *model, const ref_state *s, const double *const way[3],
                          double at, double *Q)
{
    int n = model->nq;
    double *x = numbers_new(4 * (size_t)n), *p = numbers_new((size_t)model->np);
    double *d = numbers_new((size_t)model->nd), *zero = numbers_new(3 * (size_t)n);
    for (int i = 0; i < n; i++) {
        x[i] = s->q[i] + at * way[0][i];
        x[n + i] = s->qd[i] + at * way[1][i];
    }
    for (int i = 0; i < model->np; i++) {
        p[i] = model->params[i].value + at * way[2][i];
    }
    stein_setup(model, p, d);
    stein_turn(model, x, x + 2 * n);
    model->inverse(x, x + n, s->qdd, x + 2 * n, d, zero, zero, Q);
    free(x);
    free(p);
    free(d);
    free(zero);
}

/* along a random direction against differences, all at once against along each */
static void check_derived(const stein_model *model, const ref_state *s, unsigned long long *seed)
{
    static const stein_functions functions = {sin, cos, tan};
    static const double weight[3] = {1.5, -0.6, 0.1}, h = 4e-3; // error h^6
    size_t n = (size_t)model->nq;
    double *way[3] = {numbers_new(n), numbers_new(n), numbers_new((size_t)model->np)};
    double *p = numbers_new((size_t)model->np), *d = numbers_new((size_t)model->nd);
    double *dd = numbers_new((size_t)model->nd), *sc = numbers_new(2 * n), *dQ = numbers_new(n);
    double *expected = numbers_new(n), *high = numbers_new(n), *low = numbers_new(n);
    double *by = numbers_new(2 * n * n);
    for (size_t i = 0; i < n; i++) {
        way[0][i] = noise(seed);
        way[1][i] = noise(seed);
    }
    for (int i = 0; i < model->np; i++) {
        p[i] = model->params[i].value;
        way[2][i] = 0.3 * noise(seed);
    }
    for (int k = 1; k <= 3; k++) {
        inverse_along(model, s, (const double *const *)way, k * h, high);
        inverse_along(model, s, (const double *const *)way, -k * h, low);
        for (size_t i = 0; i < n; i++) {
            expected[i] += weight[k - 1] * (high[i] - low[i]) / (2 * k * h);
        }
    }
    stein_setup(model, p, d);
    stein_turn(model, s->q, sc);
    model->setup_along(p, way[2], dd, &functions);
    model->inverse_along(s->q, s->qd, s->qdd, sc, d, way[0], way[1], dd, dQ);
    assert_same("Q along", dQ, expected, (int)n, 1e-9);
    memset(dd, 0, sizeof *dd * (size_t)model->nd);
    model->inverse_along(s->q, s->qd, s->qdd, sc, d, way[0], way[1], dd, dQ);
    if (model->inverse_slopes != NULL) {
        model->inverse_slopes(s->q, s->qd, s->qdd, sc, d, by, by + n * n);
        for (size_t i = 0; i < n; i++) {
            high[i] = 0.0;
            for (size_t j = 0; j < n; j++) {
                high[i] += by[i * n + j] * way[0][j] + by[n * n + i * n + j] * way[1][j];
            }
        }
        assert_same("Q by q and qd", high, dQ, (int)n, 1e-12);
    }
    double *const all[] = {way[0], way[1], way[2], p, d, dd, sc, dQ, expected, high, low, by};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
}

static void check_compiled(const stein_model *model, const mechanism *m, unsigned long long *seed)
{
    int n = m->nbody, np = m->npoint;
    ref_out r = ref_out_new(n, np), y = ref_out_new(n, np);
    ref_state s = ref_state_random(n, seed);
    double *Q = numbers_new((size_t)n), *p = numbers_new((size_t)m->nparam), e[2];
    double *d = numbers_new((size_t)model->nd), *q_out = numbers_new((size_t)n);
    double *sc = numbers_new(2 * (size_t)n);
    stein_pose *pose = calloc((size_t)n, sizeof *pose);
    ck_assert_int_eq(model->abi, STEIN_MODEL_ABI);
    ck_assert_int_eq(model->nq, n);
    ck_assert_int_eq(model->np, m->nparam);
    for (int i = 0; i < m->nparam; i++) {
        p[i] = model->params[i].value;
        ck_assert_double_eq(p[i], m->params[i].value);
    }
    ref_evaluate(m, &s, &r);
    inverse_of(&r, &s, n, Q);
    stein_setup(model, p, d);
    stein_turn(model, s.q, sc);
    model->mass_bias(s.q, s.qd, sc, d, s.frc, s.trq, y.M, y.c);
    assert_same("M", y.M, r.M, n * n, 1e-12);
    assert_same("c", y.c, r.c, n, 1e-12);
    check_solved(model, seed);
    model->inverse(s.q, s.qd, s.qdd, sc, d, s.frc, s.trq, q_out);
    assert_same("Q", q_out, Q, n, 1e-12);
    model->energy(s.q, s.qd, sc, d, e);
    ck_assert_close(e[0], r.kinetic, 1e-12, 0.0);
    ck_assert_close(e[1], r.potential, 1e-12, 1e-12);
    if (np) {
        model->point(s.q, s.qd, sc, d, y.x, y.v, y.J, y.jdqd);
        assert_same("x", y.x, r.x, 3 * np, 1e-12);
        assert_same("v", y.v, r.v, 3 * np, 1e-12);
        assert_same("J", y.J, r.J, 3 * np * n, 1e-12);
        assert_same("jdqd", y.jdqd, r.jdqd, 3 * np, 1e-12);
    }
    if (model->nframe) {
        model->pose(s.q, s.qd, sc, d, pose);
    }
    for (int k = 0; k < model->nframe; k++) {
        const double got[7] = {pose[k].x,  pose[k].z,  pose[k].c, pose[k].s,
                               pose[k].vx, pose[k].vz, pose[k].w};
        assert_same("pose", got, r.pose + 7 * model->frames[k].body, 7, 1e-12);
    }
    for (int i = 0; i < n; i++) {
        ck_assert_double_eq(d[model->initial + 2 * i], m->bodies[i].q0.value);
    }
    if (model->inverse_along != NULL) {
        double seen = worst;
        check_derived(model, &s, seed);
        worst = seen;
    }
    unload(&s, n);
    ref_evaluate(m, &s, &r);
    model->unloaded(s.q, s.qd, sc, d, y.M, y.c);
    assert_same("M unloaded", y.M, r.M, n * n, 1e-12);
    inverse_of(&r, &s, n, Q);
    inverse_of(&y, &s, n, q_out); // c may be nothing but rounding
    assert_same("Q unloaded", q_out, Q, n, 1e-12);
    ref_out_free(&r);
    ref_out_free(&y);
    ref_state_free(&s);
    free(Q);
    free(sc);
    free(p);
    free(d);
    free(q_out);
    free(pose);
}

START_TEST(compiled_trees_agree_with_lagrange)
{
    workshop w = workshop_open();
    mechanism *m[TREES];
    unsigned long long seed[TREES];
    for (int k = _i; k < trees(); k += 4) {
        m[k] = tree_number(k, &seed[k]);
        if (k / 4 % 2 == 1) {
            ref_armatures(m[k], &seed[k]);
        }
        workshop_add(&w, m[k]);
    }
    workshop_build(&w, _i > 0);
    for (int k = _i; k < trees(); k += 4) {
        check_compiled(workshop_model(&w, m[k]->name), m[k], &seed[k]);
        ref_tree_free(m[k]);
    }
    printf("%d random trees, compiled, against Lagrange: worst %.1e relative\n", trees() / 4,
           worst);
    workshop_close(&w);
}
END_TEST

/* qdd without M, alone and in a simulation */
static void check_articulated(const stein_model *model, const mechanism *m,
                              unsigned long long *seed)
{
    int n = m->nbody;
    ref_out r = ref_out_new(n, m->npoint);
    ref_state s = ref_state_random(n, seed);
    double *d = numbers_new((size_t)model->nd), *sc = numbers_new(2 * (size_t)n);
    double *p = numbers_new((size_t)m->nparam), *Q = numbers_new((size_t)n);
    double *qdd = numbers_new((size_t)n), *pivot = numbers_new((size_t)n);
    stein_sim *sim;
    stein_err why;
    for (int i = 0; i < m->nparam; i++) {
        p[i] = model->params[i].value;
    }
    unload(&s, n);
    ref_evaluate(m, &s, &r);
    inverse_of(&r, &s, n, Q);
    stein_setup(model, p, d);
    stein_turn(model, s.q, sc);
    ck_assert(model->articulated != NULL);
    model->articulated(s.q, s.qd, sc, d, Q, qdd, pivot);
    assert_same("qdd", qdd, s.qdd, n, 1e-9);
    ck_assert_stein(stein_sim_create(&sim, model, NULL, err));
    ck_assert_stein(stein_acceleration(sim, 0.0, s.q, s.qd, qdd, err));
    model->inverse(s.q, s.qd, qdd, sc, d, s.frc, s.trq, Q);
    for (int i = 0; i < n; i++) {
        ck_assert_double_eq_tol(Q[i], 0.0, 1e-9);
    }
    const mech_body *leaf = &m->bodies[n - 1];
    p[leaf->mass.index] = 0.0;
    for (int k = 0; k < 6; k++) {
        p[leaf->inertia[k].index] = 0.0;
    }
    if (leaf->armature.kind == MECH_PARAM) {
        p[leaf->armature.index] = 0.0;
    }
    ck_assert_stein(stein_try_all(sim, p, err));
    ck_assert_int_eq(stein_acceleration(sim, 0.0, s.q, s.qd, qdd, &why), STEIN_ESINGULAR);
    ck_assert_msg(strstr(why.msg, model->bodies[n - 1].name) != NULL, "%s", why.msg);
    stein_sim_destroy(sim);
    ref_out_free(&r);
    ref_state_free(&s);
    double *const all[] = {d, sc, p, Q, qdd, pivot};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
}

START_TEST(long_chains_have_articulated_bodies)
{
    static const char *const axes[] = {"zyxzyxzyxzyxzyxzyx", "yyyyyyyyyyyyyyyyyyyyyyyy",
                                       "zyxzyyxzyxzxyxzyxz"};
    static const char *const name[] = {"winding", "hanging", "geared"};
    workshop w = workshop_open();
    mechanism *m[3];
    unsigned long long seed = 1983;
    for (int k = 0; k < 3; k++) {
        m[k] = ref_arm(name[k], axes[k], &seed);
        if (k == 2) {
            ref_armatures(m[k], &seed);
        }
        workshop_add(&w, m[k]);
    }
    workshop_build(&w, 0);
    for (int k = 0; k < 3; k++) {
        check_articulated(workshop_model(&w, m[k]->name), m[k], &seed);
        ref_tree_free(m[k]);
    }
    workshop_close(&w);
}
END_TEST

/* M by its columns, c by inverse dynamics, points by their joints: text that grows with n */
START_TEST(long_trees_have_loops_and_agree_with_lagrange)
{
    workshop w = workshop_open();
    unsigned long long seed = 4040;
    gen_result r;
    mechanism *m = ref_arm("endless", "zyxyzyxxzyxyzyxxzyxyzyxxzyxyzyxxzyxyzyxxzy", &seed);
    ref_armatures(m, &seed);
    ck_assert_stein(gen_equations(&r, m, err));
    ck_assert_ptr_nonnull(strstr(r.source, "static void momenta("));
    ck_assert_uint_lt(r.size, 3500000);
    gen_free(&r);
    workshop_add(&w, m);
    workshop_build(&w, 0);
    check_compiled(workshop_model(&w, "endless"), m, &seed);
    check_articulated(workshop_model(&w, "endless"), m, &seed);
    ref_tree_free(m);
    workshop_close(&w);
}
END_TEST

START_TEST(long_functions_go_into_parts)
{
    workshop w = workshop_open();
    unsigned long long seed = 1788;
    gen_result r;
    mechanism *m = ref_arm("winding", "zyxzyxzyxzyxzyx", &seed);
    ck_assert_stein(gen_equations(&r, m, err));
    ck_assert_ptr_nonnull(strstr(r.source, "static STEIN_PART void mass_bias_2("));
    ck_assert_ptr_nonnull(strstr(r.source, "static STEIN_SELDOM void inverse_along_2("));
    gen_free(&r);
    workshop_add(&w, m);
    workshop_build(&w, 0);
    check_compiled(workshop_model(&w, "winding"), m, &seed);
    ref_tree_free(m);
    workshop_close(&w);
}
END_TEST

/** Names of the model files in `dir`, in file order. */
static int model_files(const char *dir, char (*path)[300], int n)
{
    DIR *d = opendir(dir);
    ck_assert_ptr_nonnull(d);
    for (struct dirent *e; (e = readdir(d)) != NULL && n < MODELS_MAX;) {
        const char *end = strrchr(e->d_name, '.');
        if (end && strcmp(end, ".yaml") == 0) {
            snprintf(path[n++], 300, "%s/%s", dir, e->d_name);
        }
    }
    closedir(d);
    return n;
}

START_TEST(compiled_models_agree_with_lagrange)
{
    static char path[MODELS_MAX][300];
    mechanism *m[MODELS_MAX];
    unsigned long long seed = 4711;
    workshop w = workshop_open();
    int n = model_files("models/robotran", path, model_files("models", path, 0));
    ck_assert_int_ge(n, 8);
    for (int k = 0; k < n; k++) {
        ck_assert_stein(mech_read(&m[k], path[k], NULL, 0, NULL, NULL, err));
        workshop_add(&w, m[k]);
    }
    workshop_build(&w, 0);
    for (int k = 0; k < n; k++) {
        check_compiled(workshop_model(&w, m[k]->name), m[k], &seed);
        mech_free(m[k]);
    }
    printf("all %d models, compiled, against Lagrange: worst %.1e relative\n", n, worst);
    workshop_close(&w);
}
END_TEST

/* ---- the descriptor ------------------------------------------------------------------------- */

static const char parts[] =
    "mechanism: parts\n"
    "bodies:\n"
    "  lever:\n"
    "    joint: R -y\n"
    "    at: [0.11, 0, 0.05]\n"
    "    mass: 0.2\n"
    "    centre: [0.03, 0, 0.01]\n"
    "    inertia: {yy: 1e-4}\n"
    "    spring: {k: 0.7, theta0: 0.2}\n"
    "    damping: 0.03\n"
    "    friction: {A: 0.1, vt: 0.2, B1: 0.5, B2: 0.3}\n"
    "    initial: {position: 0.4, speed: -0.6}\n"
    "    points: {corner: [0.01, 0, 0.07], tip: [0.2, 0, 0.02]}\n"
    "  sled: {joint: T x, mass: 0.3, points: {end: [0.04, 0, 0.01]}}\n"
    "points: {anchor: [0.5, 0.1, 0.2]}\n"
    "links: {tie: {from: frame.anchor, to: sled.end, k: 90, length: 0.3, damping: 2}}\n"
    "contacts:\n"
    "  flat:\n"
    "    between:\n"
    "      - {line: {on: lever, at: [0.1, 0, 0.03], facing: 0.3, extent: [-0.02, 0.05]}}\n"
    "      - {line: {on: frame, at: [0, 0, 0.2], facing: -90 deg}}\n"
    "    normal: {a: 3, b: 2, c: 1, D: 0.5}\n"
    "notches:\n"
    "  notch:\n"
    "    corner: {at: lever.corner, angle: 1.3, lean: 0.1}\n"
    "    beak: {at: sled.end, tilt: 0.2}\n"
    "    normal: {c: 50}\n"
    "inputs:\n"
    "  push: {force: lever.tip, direction: [0.6, 0, -0.8]}\n"
    "  drive: {motion: sled, idle: hold}\n"
    "outputs: {gap: {contact: flat, read: gap}, rise: {point: lever.tip, read: z, sign: -1, zero: "
    "rest}}\n"
    "simulation: {dt: 20 us, until: 2, integrator: dp5, settle: yes}\n";

static void check_parts(const stein_model *k, const double *d)
{
    const stein_body *lever = &k->bodies[0];
    const double *joint = d + lever->joint, *plain = d + k->bodies[1].joint;
    assert_same("spring", joint + STEIN_JOINT_K, (const double[]){0.7, 0.2}, 2, 0.0);
    ck_assert_double_eq(joint[STEIN_JOINT_B], 0.03);
    assert_same("friction", joint + STEIN_JOINT_FRICTION, (const double[]){0.1, 0.2, 0.5, 0.3}, 4,
                0.0);
    ck_assert_double_eq(stein_joint_force(plain, 0.3, -0.7), 0.0); // nothing stated, nothing acts
    ck_assert_int_eq(lever->sign, -1);
    assert_same("initial", d + k->initial, (const double[]){0.4, -0.6, 0, 0}, 4, 0.0);
    ck_assert_int_eq(k->nframe, 2);
    ck_assert_int_eq(k->frames[0].parent, -1);
    ck_assert_int_eq(k->ncontact, 1);
    ck_assert_int_eq(k->contacts[0].nspot, 2);
    ck_assert_double_eq(stein_friction(d + k->contacts[0].friction, 0.3), 0.0);
    assert_same("normal", d + k->contacts[0].normal, (const double[]){3, 2, 1, 0.5}, 4, 0.0);
    for (int i = 0; i < 2; i++) { /* ends of the lever's face: at + extent (nz, -nx) */
        const stein_shape *end = &k->spots[i].side[0], *face = &k->spots[i].side[1];
        double e = i ? 0.05 : -0.02;
        const double circle[7] = {0.1 + e * sin(0.3), 0.03 - e * cos(0.3), 0, 0, 0, 0, 0};
        ck_assert_int_eq(end->kind, STEIN_CIRCLE);
        ck_assert_int_eq(face->kind, STEIN_LINE);
        ck_assert_int_eq(end->frame, 0);
        ck_assert_int_eq(face->frame, -1);
        assert_same("end", d + end->d, circle, 7, 1e-15);
        assert_same("face", d + face->d, (const double[]){0, 0.2, 0, 0, -1}, 5, 1e-15);
        ck_assert(d[face->d + STEIN_SHAPE_LO] == -HUGE_VAL);
        ck_assert(d[face->d + STEIN_SHAPE_HI] == HUGE_VAL);
    }
    const double notch[STEIN_NOTCH_SIZE] = {0.01,     0.07, -sin(1.4), cos(1.4), -sin(0.1),
                                            cos(0.1), 0.04, 0.01,      cos(0.2), sin(0.2)};
    assert_same("notch", d + k->notches[0].d, notch, STEIN_NOTCH_SIZE, 1e-15);
    ck_assert_int_eq(k->notches[0].catcher, 0);
    ck_assert_int_eq(k->notches[0].beak, 1);
    assert_same("link", d + k->links[0].d, (const double[]){90, 0.3, 2}, 3, 0.0);
    ck_assert_str_eq(k->points[k->links[0].point[0]].name, "frame.anchor");
    assert_same("direction", d + k->inputs[0].direction, (const double[]){0.6, 0, -0.8}, 3, 1e-15);
    ck_assert_int_eq(k->inputs[1].kind, STEIN_INPUT_MOTION);
    ck_assert_int_eq(k->inputs[1].hold, 1);
    ck_assert_str_eq(k->channels[0].name, "time");
    ck_assert_int_eq(k->nchannel, 3);
    ck_assert_int_eq(k->channels[2].sign, -1);
    ck_assert_int_eq(k->channels[2].from_rest, 1);
    ck_assert_int_eq(k->settle, 1);
    ck_assert_int_eq(k->integrator, 1);
    ck_assert_double_eq(k->dt, 20e-6);
}

START_TEST(descriptor_holds_every_part_of_the_file)
{
    mechanism *m;
    unsigned long long seed = 8;
    workshop w = workshop_open();
    ck_assert_stein(
        mech_read_text(&m, "parts.yaml", parts, strlen(parts), NULL, 0, NULL, NULL, err));
    workshop_add(&w, m);
    workshop_build(&w, 1);
    const stein_model *k = workshop_model(&w, "parts");
    double *d = numbers_new((size_t)k->nd), *p = numbers_new((size_t)k->np);
    for (int i = 0; i < k->np; i++) {
        p[i] = k->params[i].value;
    }
    stein_setup(k, p, d);
    check_parts(k, d);
    check_compiled(k, m, &seed);
    free(d);
    free(p);
    mech_free(m);
    workshop_close(&w);
}
END_TEST

void generator_graph_cases(Suite *suite);
void generator_text_cases(Suite *suite);

Suite *generator_suite(void)
{
    Suite *s = suite_create("generator");
    TCase *arm = tcase_create("arm"), *models = tcase_create("models"),
          *trees = tcase_create("trees"), *compiled = tcase_create("compiled");
    generator_graph_cases(s);
    tcase_add_test(arm, graphs_agree_with_lagrange_on_a_six_axis_arm);
    tcase_add_loop_test(arm, articulated_bodies_agree_with_lagrange, 0, 3);
    tcase_add_test(arm, formulas_agree_with_the_reader);
    suite_add_tcase(s, arm);
    tcase_set_timeout(models, 300);
    tcase_add_test(models, compiled_models_agree_with_lagrange);
    tcase_add_test(models, long_chains_have_articulated_bodies);
    tcase_add_test(models, long_trees_have_loops_and_agree_with_lagrange);
    tcase_add_test(models, long_functions_go_into_parts);
    tcase_add_test(models, descriptor_holds_every_part_of_the_file);
    suite_add_tcase(s, models);
    tcase_set_timeout(trees, 300);
    tcase_add_test(trees, graphs_agree_with_lagrange_on_random_trees);
    tcase_add_test(trees, graphs_agree_with_lagrange_where_joints_keep_their_angle);
    suite_add_tcase(s, trees);
    tcase_set_timeout(compiled, 300);
    tcase_add_loop_test(compiled, compiled_trees_agree_with_lagrange, 0, 4);
    suite_add_tcase(s, compiled);
    generator_text_cases(s);
    return s;
}
