/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_energy.c - over random regulations of every mechanism: contacts, notch, felt and friction
 * between bodies never make energy, and nothing sinks in deeper than the energy that went in
 * allows.
 *
 * What contacts did since the start, without knowing their forces:
 *
 *      W(t) = kinetic + potential energy now - at the start - work of what acts in the joints
 *
 * A contact gives back at most what it holds, U = integral of its force at rest over its depth, so
 *
 *      W(t2) <= W(t1) + U(t1)  for every t1 < t2,    U(t) <= U(0) - W(t).
 *
 * Links, which let go, and tables are no laws of contacts: mechanisms with links are left out, none
 * has tables.
 */
#include <stdlib.h>

#include "stein/law.h"
#include "support.h"

enum { JOINTS = 16, SLICES = 64, RUNS = 48, STEPS = 5000, LOOK = 5 };

typedef struct watch {
    stein_sim *sim;
    const stein_model *m;
    double *d;            /* [nd] */
    double start, joints; /* energy then; work of the joints since */
    double power;         /* of the joints at the last step */
    double held, least;   /* U(0); least W + U so far */
    double scale;         /* of energies, for the error of integration */
    double deepest;       /* share of the allowed energy that one contact held */
} watch;

static int soak(int quick)
{
    const char *times = getenv("SOAK");
    return times != NULL ? quick * (int)strtol(times, NULL, 10) : quick;
}

/* what the joints do now [W] */
static double joint_power(const watch *w)
{
    double p = 0.0;
    for (int j = 0; j < w->m->nq; j++) {
        double q = stein_q(w->sim)[j], qd = stein_qd(w->sim)[j];
        p += qd * stein_joint_force(w->d + w->m->bodies[j].joint, q, qd);
    }
    return p;
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

/* what contacts hold at most [J]; *one: what the one that holds most holds at least */
static double held(const watch *w, double *one)
{
    double sum = 0.0;
    *one = 0.0;
    for (int i = 0; i < w->m->ncontact + w->m->nnotch; i++) {
        int notch = i >= w->m->ncontact;
        const double *law =
            w->d + (notch ? w->m->notches[i - w->m->ncontact].normal : w->m->contacts[i].normal);
        double x = 0.0, xdot;
        if (stein_deformation(w->sim, i, &x, &xdot) && x > 0.0) {
            double u = stored(law, x);
            sum += u * (notch ? 2 : w->m->contacts[i].nspot);
            *one = fmax(*one, u);
        }
    }
    return sum;
}

/* every number that is not 0 off by up to 3 % */
static int draw_regulation(watch *w, unsigned long long *seed)
{
    double value, *p = malloc(sizeof *p * (size_t)(w->m->np + 1));
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < w->m->np; i++) {
        ck_assert_stein(stein_get(w->sim, w->m->params[i].name, &value, err));
        p[i] = value * (1.0 + 0.03 * noise(seed));
    }
    ck_assert_stein(stein_set_all(w->sim, p, err));
    stein_setup(w->m, p, w->d);
    free(p);
    return stein_reset(w->sim, NULL) == STEIN_OK;
}

static void look(watch *w, int step)
{
    double W = energy(w) - w->start - w->joints, one, now = held(w, &one);
    w->scale = fmax(w->scale, fabs(W) + fabs(w->joints));
    double little = 1e-5 * w->scale + 1e-12;
    ck_assert_msg(W <= w->least + little,
                  "%s: contacts gave %.6g J up to step %d, they can have %.6g J", w->m->name, W,
                  step, w->least);
    ck_assert_msg(one <= w->held - W + little, "%s: a contact holds %.6g J of %.6g J at step %d",
                  w->m->name, one, w->held - W, step);
    w->least = fmin(w->least, W + now);
    w->deepest = fmax(w->deepest, one > 1e-6 ? one / (w->held - W + little) : 0.0);
}

/* @return steps that were taken */
static int run(watch *w, unsigned long long *seed)
{
    double one;
    if (!draw_regulation(w, seed)) {
        return 0;
    }
    w->start = energy(w);
    w->power = joint_power(w);
    (void)stein_qdd(w->sim); // the forces of the start
    w->held = w->least = held(w, &one);
    double dt = stein_dt(w->sim);
    for (int k = 1; k <= STEPS; k++) {
        if (stein_step(w->sim, NULL) != STEIN_OK) {
            return k;
        }
        double power = joint_power(w);
        w->joints += 0.5 * dt * (w->power + power);
        w->power = power;
        if (k % LOOK == 0) {
            (void)stein_qdd(w->sim);
            look(w, k);
        }
    }
    return STEPS;
}

START_TEST(contacts_never_make_energy_in_any_mechanism)
{
    unsigned long long seed = 1788;
    int n = soak(RUNS), models = 0, whole = 0;
    double deepest = 0.0;
    while (stein_models[models] != NULL) {
        models++;
    }
    for (int i = 0; i < n; i++) {
        const stein_model *m = stein_models[i % models];
        if (m->nlink > 0 || m->ncontact + m->nnotch == 0) {
            continue;
        }
        watch w = {.m = m, .d = malloc(sizeof *w.d * (size_t)m->nd)};
        ck_assert_ptr_nonnull(w.d);
        w.sim = make_sim(m, i / models % 2 ? STEIN_DP5 : STEIN_RK4, 0.0);
        whole += run(&w, &seed) == STEPS;
        deepest = fmax(deepest, w.deepest);
        stein_sim_destroy(w.sim);
        free(w.d);
    }
    printf("energy: %d runs of %d steps to their end, a contact held up to %.3f of what it could\n",
           whole, STEPS, deepest);
    ck_assert_int_gt(whole, n / 8);
    ck_assert(deepest > 0.1);
}
END_TEST

Suite *energy_suite(void)
{
    Suite *suite = suite_create("energy");
    TCase *tc = tcase_create("energy");
    tcase_set_timeout(tc, getenv("SOAK") != NULL ? 36000.0 : 60.0);
    tcase_add_test(tc, contacts_never_make_energy_in_any_mechanism);
    suite_add_tcase(suite, tc);
    return suite;
}
