/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_energy.c - over random regulations of every mechanism: contacts, notch, felt and friction
 * between bodies never make energy, and nothing sinks in deeper than the energy that went in
 * allows.
 *
 * Work of contacts since the start, without their forces:
 *
 *      W(t) = kinetic + potential energy now - at the start - work of forces in the joints
 *
 * A contact returns at most its stored energy, U = integral of its force at rest over its depth, so
 *
 *      W(t2) <= W(t1) + U(t1)  for every t1 < t2,    U(t) <= U(0) - W(t).
 *
 * The same holds with friction and damping of joints counted among the contacts: then only
 * springs and preloads are work that is taken off. And at a state, whatever the others do, the
 * power of each friction by itself is at most 0:
 *
 *      qd . M (qdd with it alone - qdd with none)  <=  0
 *
 * The static surplus of friction, B1, is in no mechanism file: it is drawn here, to find a law with
 * a surplus that pushes. Less than 0 it is drawn nowhere: below some -tanh(u) (1 + B2 u^4) / u
 * friction does push, by its formula.
 *
 * Links, which let go, and tables are no laws of contacts: mechanisms with links are left out, none
 * has tables.
 */
#include <stdlib.h>
#include <string.h>

#include "stein/law.h"
#include "support.h"

enum { SLICES = 64, RUNS = 48, STEPS = 5000, LOOK = 5, ASK = 250, RUBS = 64, MODELS = 64 };
enum { SHORT = 500, MANY = 42 }; // in the long run short ones follow, many for each of SOAK

/* subtracted work: the work of laws since the start, and the rest */
typedef struct account {
    double *d;    /* [nd] */
    double power; /* of the laws at the last step [W] */
    double work;  /* [J] */
    double least; /* least W + U so far [J] */
} account;

typedef struct watch {
    stein_sim *sim;
    const stein_model *m;
    account joints, springs; /* all that acts in the joints; only elements that can give energy */
    double start, held;      /* energy then, U(0) [J] */
    double scale;            /* of energies, for the error of integration [J] */
    double deepest;          /* share of the allowed energy that one contact held */
    unsigned char *rubs;     /* [RUBS] which frictions were seen to brake */
} watch;

/* power of laws d in the joints now [W] */
static double joint_power(const watch *w, const double *d)
{
    double p = 0.0;
    for (int j = 0; j < w->m->nq; j++) {
        double q = stein_q(w->sim)[j], qd = stein_qd(w->sim)[j];
        p += qd * stein_joint_force(d + w->m->bodies[j].joint, q, qd);
    }
    return p;
}

static void add_work(const watch *w, account *a)
{
    double power = joint_power(w, a->d);
    a->work += 0.5 * stein_dt(w->sim) * (a->power + power);
    a->power = power;
}

static double energy(const watch *w)
{
    double kinetic, potential;
    stein_energy(w->sim, stein_q(w->sim), stein_qd(w->sim), &kinetic, &potential);
    return kinetic + potential;
}

/* integral of the force at rest from 0 to x */
static double stored(const double *law, double x)
{
    double sum = 0.0, h = x / SLICES;
    for (int i = 0; i < SLICES; i++) { // Simpson's rule, of a cubic exact
        double a = h * i;
        sum +=
            h / 6.0 *
            (stein_normal_force(law, a + 1e-3 * h, 0.0) +
             4.0 * stein_normal_force(law, a + 0.5 * h, 0.0) + stein_normal_force(law, a + h, 0.0));
    }
    return sum;
}

/* largest energy of contacts [J]; *one: least force of the place that holds most */
static double held(const watch *w, double *one)
{
    double sum = 0.0;
    *one = 0.0;
    for (int i = 0; i < w->m->ncontact + w->m->nnotch; i++) {
        int notch = i >= w->m->ncontact;
        const double *law = w->joints.d + (notch ? w->m->notches[i - w->m->ncontact].normal
                                                 : w->m->contacts[i].normal);
        double x = 0.0, xdot;
        if (stein_deformation(w->sim, i, &x, &xdot) && x > 0.0) {
            double u = stored(law, x);
            sum += u * (notch ? 2 : w->m->contacts[i].nspot);
            *one = fmax(*one, u);
        }
    }
    return sum;
}

static int ends_with(const char *name, const char *end)
{
    size_t n = strlen(name), k = strlen(end);
    return n >= k && strcmp(name + n - k, end) == 0;
}

/* the derived constants of p; among the springs nothing that rubs or damps */
static void derive(watch *w, const double *p)
{
    static const int losses[] = {STEIN_JOINT_B, STEIN_JOINT_DRAG, STEIN_JOINT_DRY,
                                 STEIN_JOINT_FRICTION + STEIN_FRICTION_A};
    stein_setup(w->m, p, w->joints.d);
    memcpy(w->springs.d, w->joints.d, sizeof *w->springs.d * (size_t)w->m->nd);
    for (int j = 0; j < w->m->nq; j++) {
        for (int i = 0; i < 4; i++) {
            w->springs.d[w->m->bodies[j].joint + losses[i]] = 0.0;
        }
    }
}

/* every number that is not 0 off by up to 3 %; every friction with a surplus of up to 3 */
static int draw_regulation(watch *w, unsigned long long *seed)
{
    double value, *p = malloc(sizeof *p * (size_t)(w->m->np + 1));
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < w->m->np; i++) {
        const char *name = w->m->params[i].name;
        ck_assert_stein(stein_get(w->sim, name, &value, err));
        p[i] = ends_with(name, ".friction.B1") ? 1.5 * (1.0 + noise(seed))
                                               : value * (1.0 + 0.03 * noise(seed));
    }
    ck_assert_stein(stein_set_all(w->sim, p, err));
    derive(w, p);
    free(p);
    return stein_reset(w->sim, NULL) == STEIN_OK;
}

/* @return work of contacts, and of everything that the account does not subtract, since the start
 * [J] */
static double check_account(watch *w, account *a, const char *who, double now, int step)
{
    double W = energy(w) - w->start - a->work;
    w->scale = fmax(w->scale, fabs(W) + fabs(a->work));
    ck_assert_msg(W <= a->least + 1e-5 * w->scale + 1e-12,
                  "%s: %s gave %.6g J up to step %d, they can have %.6g J", w->m->name, who, W,
                  step, a->least);
    a->least = fmin(a->least, W + now);
    return W;
}

static void look(watch *w, int step)
{
    double one, now = held(w, &one);
    check_account(w, &w->springs, "contacts and friction", now, step);
    double W = check_account(w, &w->joints, "contacts", now, step);
    double little = 1e-5 * w->scale + 1e-12;
    ck_assert_msg(one <= w->held - W + little, "%s: a contact holds %.6g J of %.6g J at step %d",
                  w->m->name, one, w->held - W, step);
    w->deepest = fmax(w->deepest, one > 1e-6 ? one / (w->held - W + little) : 0.0);
}

/* power of a friction: qd . M (qdd - that with none) [W]; *size: the sum of what cancels in it */
static double friction_power(const watch *w, const double *qdd, const double *none, const double *M,
                             double *size)
{
    int nq = w->m->nq;
    const double *qd = stein_qd(w->sim);
    double power = 0.0;
    *size = 0.0;
    for (int i = 0; i < nq; i++) {
        for (int j = 0; j < nq; j++) {
            power += qd[i] * M[i * nq + j] * (qdd[j] - none[j]);
            *size += fabs(qd[i] * M[i * nq + j]) * (fabs(qdd[j]) + fabs(none[j]));
        }
    }
    return power;
}

/* qdd at the present state with the k-th friction alone, -1: with none. @return how many there are
 */
static int with_friction(const watch *w, double *p, const double *all, int k, double *qdd)
{
    int n = 0;
    for (int i = 0; i < w->m->np; i++) {
        int rubs = ends_with(w->m->params[i].name, ".friction.A");
        p[i] = rubs && n != k ? 0.0 : all[i];
        n += rubs;
    }
    ck_assert_stein(stein_set_all(w->sim, p, err));
    ck_assert_stein(stein_acceleration(w->sim, stein_time(w->sim), stein_q(w->sim),
                                       stein_qd(w->sim), qdd, err));
    return n;
}

/* a surplus of 1e-3 to 1e5, a B2 of 0 to 2, for every friction */
static void draw_frictions(const watch *w, double *all, double *kept, unsigned long long *seed)
{
    for (int i = 0; i < w->m->np; i++) {
        const char *name = w->m->params[i].name;
        ck_assert_stein(stein_get(w->sim, name, &kept[i], err));
        all[i] = ends_with(name, ".friction.B1")   ? pow(10.0, 1.0 + 4.0 * noise(seed))
                 : ends_with(name, ".friction.B2") ? 1.0 + noise(seed)
                                                   : kept[i];
    }
}

/* each friction by itself, at the present state and its modes of contact */
static void ask_frictions(watch *w, unsigned long long *seed)
{
    size_t nq = (size_t)w->m->nq, np = (size_t)w->m->np;
    double *all = malloc(sizeof *all * (3 * np + nq * nq + 3 * nq + 1)), size;
    ck_assert_ptr_nonnull(all);
    double *p = all + np, *kept = p + np, *M = kept + np, *c = M + nq * nq, *none = c + nq;
    double *qdd = none + nq;
    draw_frictions(w, all, kept, seed);
    stein_mass_bias(w->sim, stein_q(w->sim), stein_qd(w->sim), NULL, NULL, M, c);
    int n = with_friction(w, p, all, -1, none);
    ck_assert_int_le(n, RUBS);
    for (int k = 0; k < n; k++) {
        with_friction(w, p, all, k, qdd);
        double power = friction_power(w, qdd, none, M, &size);
        ck_assert_msg(power <= 1e-12 * size, "%s: friction %d pushes with %.6g W at t = %g s",
                      w->m->name, k, power, stein_time(w->sim));
        w->rubs[k] |= power < -1e-9 * size;
    }
    ck_assert_stein(stein_set_all(w->sim, kept, err));
    free(all);
}

/* @return were all steps taken? 0, too, where there is nothing to run */
static int run(watch *w, int steps, unsigned long long *seed)
{
    double one;
    if (!draw_regulation(w, seed)) {
        return 0;
    }
    w->start = energy(w);
    w->joints.power = joint_power(w, w->joints.d);
    w->springs.power = joint_power(w, w->springs.d);
    (void)stein_qdd(w->sim); // the forces of the start
    w->held = w->joints.least = w->springs.least = held(w, &one);
    for (int k = 1; k <= steps; k++) {
        if (stein_step(w->sim, NULL) != STEIN_OK) {
            return 0;
        }
        add_work(w, &w->joints);
        add_work(w, &w->springs);
        if (k % LOOK == 0) {
            (void)stein_qdd(w->sim);
            look(w, k);
        }
        if (k % ASK == 0) {
            ask_frictions(w, seed);
        }
    }
    return 1;
}

START_TEST(contacts_and_friction_never_make_energy_in_any_mechanism)
{
    static unsigned char rubs[MODELS][RUBS];
    unsigned long long seed = 1788;
    int n = soaks() > 0 ? MANY * soak(RUNS) : RUNS, models = 0, whole = 0, braking = 0;
    double deepest = 0.0;
    while (stein_models[models] != NULL) {
        models++;
    }
    ck_assert_int_le(models, MODELS);
    for (int i = 0; i < n; i++) {
        const stein_model *m = stein_models[i % models];
        if (m->nlink > 0 || m->ncontact + m->nnotch == 0) {
            continue;
        }
        size_t size = sizeof(double) * (size_t)m->nd;
        watch w = {
            .m = m, .joints.d = malloc(size), .springs.d = malloc(size), .rubs = rubs[i % models]};
        ck_assert(w.joints.d != NULL && w.springs.d != NULL);
        w.sim = make_sim(m, i / models % 2 ? STEIN_DP5 : STEIN_RK4, 0.0);
        whole += run(&w, i < RUNS ? STEPS : SHORT, &seed);
        deepest = fmax(deepest, w.deepest);
        stein_sim_destroy(w.sim);
        free(w.joints.d);
        free(w.springs.d);
    }
    for (int i = 0; i < models * RUBS; i++) {
        braking += rubs[i / RUBS][i % RUBS];
    }
    printf("energy: %d runs to their end, a contact held up to %.3f of what it could, %d frictions "
           "braked\n",
           whole, deepest, braking);
    ck_assert_int_gt(whole, n / 8);
    ck_assert(deepest > 0.1);
    ck_assert_int_ge(braking, 10); // of 11 in the files
}
END_TEST

Suite *energy_suite(void)
{
    Suite *suite = suite_create("energy");
    TCase *tc = tcase_create("energy");
    tcase_set_timeout(tc, soaks() > 0 ? 36000.0 : 60.0);
    tcase_add_test(tc, contacts_and_friction_never_make_energy_in_any_mechanism);
    suite_add_tcase(suite, tc);
    return suite;
}
