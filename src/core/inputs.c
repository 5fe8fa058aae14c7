/* SPDX-License-Identifier: MIT
 * inputs.c - what drives a mechanism from outside: signals, which are forces or prescribed motions,
 * for a simulation alone or in lanes.
 *
 * A joint with a prescribed motion, or held, leaves the unknowns of M qdd = Q - c: its row becomes
 * qdd_j = given, its column moves to the right-hand side.
 */
#include "core.h"

/* is there a signal at input i? */
static inline mask has_signal(const stein_sim *sim, int i)
{
#if STEIN_LANES > 1
    return sim->bound[i];
#else
    return sim->signal[i] != NULL;
#endif
}

INNER void stein__inputs(stein_sim *sim)
{
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        real u = sim->ustate[3 * i]; // 0 without a signal
        if (input->kind == STEIN_INPUT_JOINT) {
            sim->Q[input->index] += u;
        } else if (input->kind == STEIN_INPUT_VOLTAGE) {
            sim->Q[input->index] += u * sim->d[input->direction];
        } else if (input->kind == STEIN_INPUT_POINT && any(has_signal(sim, i))) {
            const real *direction = sim->d + input->direction;
            real f[3] = {u * direction[0], u * direction[1], u * direction[2]};
            stein__pull(sim, input->index, f);
        }
    }
}

#if STEIN_LANES > 0

/* what the signal of input i is at t, of those that are asked; 0 of others. @return which they are
 */
static inline mask ask(const stein_sim *sim, int i, real t, real u[3])
{
#if STEIN_LANES == 1
    u[0] = u[1] = u[2] = 0.0;
    sim->signal[i](sim->signal_ctx[i], t, u);
    return 1;
#else
    mask asked = both(sim->asked, sim->bound[i]);
    u[0] = u[1] = u[2] = same(0.0);
    for (int k = 0; k < STEIN_LANES; k++) {
        if (lanes_of(asked) >> k & 1) {
            double alone[3] = {0.0};
            sim->signal[STEIN_LANES * i + k](sim->signal_ctx[STEIN_LANES * i + k], t[k], alone);
            for (int n = 0; n < 3; n++) {
                u[n][k] = alone[n];
            }
        }
    }
    return asked;
#endif
}

INNER void stein__drive(stein_sim *sim, real t)
{
    const stein_model *model = sim->model;
    for (int i = 0; i < model->ninput; i++) {
        mask on = has_signal(sim, i);
        if (!any(on)) {
            continue;
        }
        const real *law = sim->d + model->inputs[i].signal;
        real *u = sim->ustate + 3 * i, now[3];
        mask asked = ask(sim, i, t - law[STEIN_SIGNAL_DELAY], now);
        for (int n = 0; n < 3; n++) {
            u[n] = sel(asked, now[n] * law[STEIN_SIGNAL_GAIN], u[n]);
        }
        if (model->inputs[i].kind == STEIN_INPUT_MOTION) {
            int j = model->inputs[i].index;
            sim->xq[j] = sel(on, u[0], sim->xq[j]);
            sim->xqd[j] = sel(on, u[1], sim->xqd[j]);
        }
    }
}

INNER void stein__wire(stein_sim *sim)
{
    const stein_model *model = sim->model;
    sim->jacobians = sim->motions = sim->signals = 0;
    sim->loop.rank = -1;
    for (int i = 0; i < model->ninput; i++) {
        const stein_input *input = &model->inputs[i];
        int on = any(has_signal(sim, i));
        sim->signals |= on;
        sim->jacobians |=
            input->kind == STEIN_INPUT_POINT && on && model->points[input->index].at < 0;
        sim->motions |= input->kind == STEIN_INPUT_MOTION && (on || input->hold);
    }
    for (int i = 0; i < model->nlink; i++) {
        const stein_link *link = &model->links[i];
        sim->jacobians |=
            model->points[link->point[0]].at < 0 || model->points[link->point[1]].at < 0;
    }
}

/* does joint j follow what is given? Then its acceleration is in *value. The first input that
 * drives it counts. */
static inline mask is_given(const stein_sim *sim, int j, real *value)
{
    mask given = mask_of(sim->held[j]);
    *value = same(0.0);
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        if (input->kind == STEIN_INPUT_MOTION && input->index == j) {
            mask on = has_signal(sim, i);
            *value = sel(both(on, no(given)), sim->ustate[3 * i + 2], *value);
            given = input->hold ? no((mask){0}) : either(given, on);
        }
    }
    return given;
}

/* take joint j out of the unknowns of M x = b, where it is on: x_j = value */
static inline void prescribe(int n, real *M, real *b, int j, mask on, real value)
{
    for (int i = 0; i < n; i++) {
        b[i] = sel(on, b[i] - M[i * n + j] * value, b[i]);
        M[i * n + j] = M[j * n + i] = sel(on, same(0.0), M[i * n + j]);
    }
    M[j * n + j] = sel(on, same(1.0), M[j * n + j]);
    b[j] = sel(on, value, b[j]);
}

INNER void stein__prescribe(stein_sim *sim, real *M, real *b)
{
    int nq = sim->model->nq;
    for (int j = 0; j < nq; j++) {
        real value = same(0.0);
        mask on = sim->motions ? is_given(sim, j, &value) : mask_of(sim->held[j]);
        if (any(on)) {
            prescribe(nq, M, b, j, on, value);
        }
    }
}

#endif
#if STEIN_LANES == 1

int stein__driver_of(const stein_sim *sim, int joint)
{
    if (sim->held[joint]) {
        return STEIN__HELD;
    }
    for (int i = 0; i < sim->model->ninput; i++) {
        const stein_input *input = &sim->model->inputs[i];
        if (input->kind == STEIN_INPUT_MOTION && input->index == joint) {
            if (sim->signal[i] != NULL) {
                return i;
            }
            if (input->hold) {
                return STEIN__HELD;
            }
        }
    }
    return STEIN__FREE;
}

int stein__is_driven(const stein_sim *sim, int joint)
{
    return stein__driver_of(sim, joint) != STEIN__FREE;
}

void stein__place_driven(stein_sim *sim)
{
    size_t size = sizeof *sim->q * (size_t)sim->model->nq;
    stein__drive_from(sim, sim->head->t, sim->q, sim->qd);
    memcpy(sim->q, sim->xq, size);
    memcpy(sim->qd, sim->xqd, size);
}

#endif
