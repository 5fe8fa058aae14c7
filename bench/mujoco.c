/* SPDX-License-Identifier: GPL-3.0-or-later
 * mujoco.c - M and c and forward dynamics of piano3 by MuJoCo, a numeric library without code for
 * the mechanism.
 *
 * M by its composite bodies, made dense as ours is, c by its recursive Newton-Euler pass; forward
 * dynamics adds the sparse factors of M. Only the needed functions of the pipeline are called:
 * positions, inertias, velocities. Properties out of the plane have no effect; the model compiler
 * needs inertias that a body can have, so all three equal the one about y.
 */
#include "mujoco.h"

#ifdef BENCH_MUJOCO

#include <math.h>
#include <mujoco/mujoco.h>
#include <stdlib.h>
#include <unistd.h>

enum { NQ = 3 };

static struct {
    mjModel *m;
    mjData *d;
    const double (*q)[NQ], (*qd)[NQ];
    int n;
} tree;
static bench_case *of_mass_bias, *of_forward;

static double number(stein_sim *sim, const char *body, const char *what)
{
    char name[64];
    double value = 0.0;
    stein_err err;
    snprintf(name, sizeof name, "%s.%s", body, what);
    bench_need(stein_get(sim, name, &value, &err), &err, name);
    return value;
}

/* a body that turns about -y, with what its joint carries: open until "</body>" */
static void print_body(FILE *f, stein_sim *sim, const char *body, double x, double z)
{
    double yy = number(sim, body, "inertia.yy");
    fprintf(f,
            "<body name='%s' pos='%.17g 0 %.17g'><joint axis='0 -1 0'/>"
            "<inertial pos='%.17g 0 0' mass='%.17g' diaginertia='%.17g %.17g %.17g'/>\n",
            body, x, z, number(sim, body, "centre.x"), number(sim, body, "mass"), yy, yy, yy);
}

/* @return 0 when MuJoCo could not read it */
static int load(stein_sim *sim)
{
    char path[] = "/tmp/stein_bench_XXXXXX", why[256] = "";
    int handle = mkstemp(path);
    FILE *f = handle >= 0 ? fdopen(handle, "w") : NULL;
    if (f == NULL) {
        return 0;
    }
    fprintf(f, "<mujoco><compiler angle='radian'/><option gravity='0 0 %.17g'/><worldbody>\n",
            number(sim, "gravity", "z"));
    print_body(f, sim, "key", 0.0, 0.0);
    print_body(f, sim, "hammer", number(sim, "hammer", "at.x"), 0.0);
    fprintf(f, "</body></body>\n");
    print_body(f, sim, "pawl", number(sim, "pawl", "at.x"), number(sim, "pawl", "at.z"));
    fprintf(f, "</body></worldbody></mujoco>\n");
    if (fclose(f) == 0) {
        tree.m = mj_loadXML(path, NULL, why, (int)sizeof why);
    }
    unlink(path);
    tree.d = tree.m != NULL ? mj_makeData(tree.m) : NULL;
    if (tree.d == NULL) {
        fprintf(stderr, "bench: MuJoCo: %s\n", why);
    }
    return tree.d != NULL;
}

static void put(int i)
{
    for (int j = 0; j < NQ; j++) {
        tree.d->qpos[j] = tree.q[i][j];
        tree.d->qvel[j] = tree.qd[i][j];
    }
}

/* M as its sparse entries, c */
static void equations(double *c)
{
    mj_kinematics(tree.m, tree.d);
    mj_comPos(tree.m, tree.d);
    mj_crb(tree.m, tree.d);
    mj_comVel(tree.m, tree.d);
    mj_rne(tree.m, tree.d, 0, c);
}

static double run_mass_bias(void *ctx, long n)
{
    double M[NQ * NQ], c[NQ], sum = 0.0;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        put((int)(i % tree.n));
        equations(c);
        mj_fullM(tree.m, M, tree.d->qM);
        sum += M[0] + M[1] + M[8] + c[0] + c[1] + c[2];
    }
    return sum;
}

static void accelerate(double *qdd)
{
    double c[NQ];
    equations(c);
    mj_factorM(tree.m, tree.d);
    for (int j = 0; j < NQ; j++) {
        qdd[j] = -c[j];
    }
    mj_solveM(tree.m, tree.d, qdd, qdd, 1);
}

static double run_forward(void *ctx, long n)
{
    double qdd[NQ], sum = 0.0;
    (void)ctx;
    for (long i = 0; i < n; i++) {
        put((int)(i % tree.n));
        accelerate(qdd);
        sum += qdd[0] + qdd[1] + qdd[2];
    }
    return sum;
}

/* largest difference in M, c of one state, each by its largest entry */
static double difference(const double *a, const double *b, int n)
{
    double worst = 0.0, size = 0.0;
    for (int k = 0; k < n; k++) {
        worst = fmax(worst, fabs(a[k] - b[k]));
        size = fmax(size, fabs(b[k]));
    }
    return worst / size;
}

static void check(stein_sim *sim)
{
    double worst = 0.0, error = 0.0;
    for (int i = 0; i < tree.n; i++) {
        double M[NQ * NQ], c[NQ], M1[NQ * NQ], c1[NQ], f[NQ], residual[NQ];
        stein_mass_bias(sim, tree.q[i], tree.qd[i], NULL, NULL, M, c);
        put(i);
        equations(c1);
        mj_fullM(tree.m, M1, tree.d->qM);
        worst = fmax(worst, fmax(difference(M1, M, NQ * NQ), difference(c1, c, NQ)));
        accelerate(f);
        for (int j = 0; j < NQ; j++) {
            residual[j] = -(M[NQ * j] * f[0] + M[NQ * j + 1] * f[1] + M[NQ * j + 2] * f[2]);
        }
        error = fmax(error, difference(residual, c, NQ));
    }
    bench_check("M and c by MuJoCo", worst, 1e-12);
    bench_check("forward dynamics by MuJoCo", error, 1e-12);
}

void mujoco_add(stein_sim *sim, const double (*q)[3], const double (*qd)[3], int n)
{
    if (!load(sim)) {
        bench_check("piano3 in MuJoCo", 1.0, 0.0);
        return;
    }
    tree.q = q;
    tree.qd = qd;
    tree.n = n;
    check(sim);
    of_mass_bias = bench_add("closed", "piano3", "M and c, MuJoCo", run_mass_bias, NULL);
    of_forward = bench_add("closed", "piano3", "forward dynamics, MuJoCo", run_forward, NULL);
}

void mujoco_rows(const bench_case *mass_bias, const bench_case *forward)
{
    bench_ratio("M+c of the simple tree, MuJoCo : generated", of_mass_bias, mass_bias, 1.0, 0.0, 0);
    bench_ratio("forward dynamics of the simple tree, MuJoCo : generated", of_forward, forward, 1.0,
                0.0, 0);
}

#else

void mujoco_add(stein_sim *sim, const double (*q)[3], const double (*qd)[3], int n)
{
    (void)sim, (void)q, (void)qd, (void)n;
}

void mujoco_rows(const bench_case *mass_bias, const bench_case *forward)
{
    (void)mass_bias, (void)forward;
}

#endif
