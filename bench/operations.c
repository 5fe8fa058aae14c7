/* SPDX-License-Identifier: GPL-3.0-or-later
 * operations.c - operations of generated equations, here and in other programs: no times.
 *
 * The counts of others: ROBOTRAN's examples as it writes them; RX90 from OpenSYMORO's generated
 * text; Pinocchio's algorithms as CasADi writes them out. ROBOTRAN's and ours keep a force and a
 * moment on every body, the others do not. Additions, products, signs, divisions, and each sine or
 * cosine count 1; of OpenSYMORO products and sums are compared one by one, its signs are left out.
 */
#include <stdlib.h>

#include "bench.h"
#include "gen.h"
#include "gen_internal.h"
#include "mechanism.h"

typedef struct counts {
    stein_ops mass_bias, inverse, mass;
    int qdd; /* all operations of the cheaper way to it */
} counts;

/* M without c */
static void mass_alone(walk *ps, ex *out)
{
    int n = ps->t->n, nM = n * n;
    ex *all = bench_alloc(sizeof *all * (size_t)(nM + n));
    for (int i = 0; i < nM + n; i++) {
        all[i] = 0;
    }
    dyn_mass_bias(ps, all);
    for (int i = 0; i < nM; i++) {
        out[i] = all[i];
    }
    free(all);
}

static stein_ops mass_of(const mechanism *m)
{
    ex_graph setup;
    tree t = {0};
    func f = {.out = NULL};
    int bad = ex_graph_init(&setup, NULL) || tree_build(&t, m, &setup) ||
              func_search(&f, &t, mass_alone, t.n * t.n);
    bench_check("the mass matrix alone (1: not generated)", bad, 0.0);
    stein_ops ops = f.ops;
    func_free(&f);
    tree_free(&t);
    ex_graph_free(&setup);
    return ops;
}

static counts count(const char *file, int mass_too)
{
    mechanism *m = NULL;
    gen_result r;
    stein_err err;
    counts c = {.qdd = 0};
    bench_need(mech_read(&m, file, NULL, 0, NULL, NULL, &err), &err, file);
    bench_need(gen_equations(&r, m, &err), &err, file);
    c.mass_bias = r.mass_bias;
    c.inverse = r.inverse;
    c.qdd = gen_total(r.articulated);
    c.qdd = c.qdd > 0 ? c.qdd : gen_total(r.unloaded) + gen_total(r.solve);
    if (mass_too) {
        c.mass = mass_of(m);
    }
    gen_free(&r);
    mech_free(m);
    return c;
}

static void compare(const char *what, const char *whose, int here, int there, double bar)
{
    char line[96];
    double share = (double)here / there;
    snprintf(line, sizeof line, "%s, operations: %d : %s %d", what, here, whose, there);
    bench_row(line, &share, 1, bar, 0);
}

void operations_rows(void)
{
    static const struct {
        const char *name;
        int mass_bias, inverse;
    } robotran[] = {{"piano_tree", 144, 123},
                    {"suspension_a", 95, 77},
                    {"suspension_b", 172, 114},
                    {"piston", 125, 83}};
    char what[64];
    for (size_t i = 0; i < sizeof robotran / sizeof *robotran; i++) {
        char file[64];
        snprintf(file, sizeof file, "models/robotran/%s.yaml", robotran[i].name);
        counts c = count(file, 0);
        snprintf(what, sizeof what, "M and c of %s", robotran[i].name);
        compare(what, "ROBOTRAN", gen_total(c.mass_bias), robotran[i].mass_bias, 0.75);
        snprintf(what, sizeof what, "inverse dynamics of %s", robotran[i].name);
        compare(what, "ROBOTRAN", gen_total(c.inverse), robotran[i].inverse, 0.75);
    }
    counts rx90 = count("bench/rx90.yaml", 1);
    compare("inverse dynamics of RX90, products", "OpenSYMORO", rx90.inverse.mul, 378, 1.0);
    compare("inverse dynamics of RX90, sums", "OpenSYMORO", rx90.inverse.add, 329, 1.0);
    compare("M of RX90, products", "OpenSYMORO", rx90.mass.mul, 305, 1.0);
    compare("M of RX90, sums", "OpenSYMORO", rx90.mass.add, 243, 1.0);
    counts arm = count("bench/arm6.yaml", 0), chain = count("bench/chain30.yaml", 0);
    compare("M and c of 6 joints", "CasADi", gen_total(arm.mass_bias), 1408 + 10, 1.0);
    compare("qdd of 6 joints", "CasADi", arm.qdd, 1815 + 10, 1.0);
    compare("M and c of 30 joints", "CasADi", gen_total(chain.mass_bias), 15257 + 58, 1.0);
    compare("qdd of 30 joints", "CasADi", chain.qdd, 12283 + 58, 1.0);
}
