/* SPDX-License-Identifier: GPL-3.0-or-later
 * linear_support.h - a mechanism that is linearised, for the suites of linear.h.
 */
#ifndef LINEAR_SUPPORT_H
#define LINEAR_SUPPORT_H

#include <complex.h>

#include "lab_support.h"

/** A mechanism from a text or a built-in model, its simulation, the result of stein_linear_at. */
typedef struct linearised {
    lab_model *model; /* NULL: built in */
    stein_sim *sim;
    stein_linear *l;
    const stein_linear_system *s;
    lab_modes *modes;
} linearised;

static inline linearised linear_begin(const char *text)
{
    linearised x = {.model = open_text(text, NULL, 0)};
    ck_assert_stein(lab_sim(x.model, NULL, &x.sim, err));
    ck_assert_stein(stein_linear_create(&x.l, stein_sim_model(x.sim), NULL, err));
    return x;
}

static inline linearised linear_built_in(const stein_model *model)
{
    linearised x = {.sim = make_sim(model, STEIN_RK4, 0.0)};
    ck_assert_stein(stein_linear_create(&x.l, model, NULL, err));
    return x;
}

/** At the present state. */
static inline void linear_look(linearised *x)
{
    ck_assert_stein(stein_linear_at(x->l, x->sim, &x->s, err));
    lab_modes_destroy(x->modes);
    x->modes = NULL;
    ck_assert_stein(lab_modes_create(&x->modes, x->s, err));
}

static inline void linear_end(linearised *x)
{
    lab_modes_destroy(x->modes);
    stein_linear_destroy(x->l);
    stein_sim_destroy(x->sim);
    lab_close(x->model);
}

/** At rest in a given state: positions of all joints, and speeds or NULL. */
static inline void linear_put(linearised *x, const double *q, const double *qd)
{
    double zero[64] = {0.0};
    ck_assert_stein(stein_set_state(x->sim, 0.0, q, qd != NULL ? qd : zero, err));
    linear_look(x);
}

static inline double linear_A(const linearised *x, int i, int j)
{
    return x->s->A[i * 2 * x->s->n + j];
}

/** y/u at a frequency [rad/s], C (i w - A)^-1 B + D, by elimination; channel and input by name. */
static inline double complex linear_transfer(const linearised *x, const char *channel,
                                             const char *input, double omega)
{
    const stein_model *m = stein_sim_model(x->sim);
    int n = 2 * x->s->n, y = stein_find_channel(m, channel), u = x->s->ninput - 1;
    double complex a[64 * 65], sum = 0.0;
    ck_assert(n <= 64 && y >= 0);
    while (u >= 0 && strcmp(m->inputs[x->s->input[u]].name, input) != 0) {
        u--;
    }
    ck_assert_int_ge(u, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            a[i * (n + 1) + j] = (i == j ? omega * I : 0.0) - x->s->A[i * n + j];
        }
        a[i * (n + 1) + n] = x->s->B[i * x->s->ninput + u];
    }
    for (int k = 0; k < n; k++) {
        int p = k;
        for (int i = k; i < n; i++) {
            p = cabs(a[i * (n + 1) + k]) > cabs(a[p * (n + 1) + k]) ? i : p;
        }
        for (int j = 0; j <= n; j++) {
            double complex kept = a[k * (n + 1) + j];
            a[k * (n + 1) + j] = a[p * (n + 1) + j];
            a[p * (n + 1) + j] = kept;
        }
        for (int i = 0; i < n; i++) {
            double complex f = a[i * (n + 1) + k] / a[k * (n + 1) + k];
            for (int j = 0; i != k && j <= n; j++) {
                a[i * (n + 1) + j] -= f * a[k * (n + 1) + j];
            }
        }
    }
    for (int k = 0; k < n; k++) {
        sum += x->s->C[y * n + k] * a[k * (n + 1) + n] / a[k * (n + 1) + k];
    }
    return sum + x->s->D[y * x->s->ninput + u];
}

#endif
