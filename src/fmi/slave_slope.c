/* SPDX-License-Identifier: MIT
 * slave_slope.c - partial derivatives of the outputs of an instance.
 *
 * Central differences (f(x + h) - f(x - h)) / 2h with h halved again and again, extrapolated to
 * h = 0 (Richardson 1911: the error is a series in h^2, so column k of the table removes h^2k). Of
 * all entries of the table that one is taken which differs least from its neighbours (Ridders
 * 1982): the differences detect the step at which rounding dominates. With the contacts and the
 * notch in their present modes (memory, not geometry) f is smooth. Linear terms, such as every
 * force, are exact to rounding.
 *
 * Accuracy, against solved equations and the laws themselves (tests/fmu/slopes.c, which holds
 * 1e-9): off by 2e-11 of its size at most, through the static equilibrium of a start by 1e-12. One
 * derivative costs 18 evaluations, at the start as many equilibria.
 *
 * Between two steps f is the output for another value of the known, with the same state; in
 * Initialization Mode it goes through the whole initial state. The instance is not changed.
 *
 * Derivatives of generated code would be exact, but the equations are only a small part of the path
 * from a parameter to an output: contacts, laws and the notch are handwritten.
 */
#include <math.h>
#include <string.h>

#include "slave.h"

enum { HALVINGS = 9 };
static const double first_step = 1.0 / 64.0; /* of the known's size */

/* a known that is moved */
typedef struct mover {
    slave *s;
    fmi_variable known;
    unsigned unknown;
    double at;
} mover;

/* its size, a power of 2 */
static double size_of(const mover *m)
{
    const stein_model *model = &m->s->model;
    double size = fabs(m->at);
    if (m->known.kind == FMI_PARAMETER) {
        const stein_param *p = &model->params[m->known.index];
        size = size > 0.0 ? size : p->tolerance > 0.0 ? 100.0 * p->tolerance : 1e-2;
    } else {
        const stein_input *input = &model->inputs[m->known.index];
        size = fmax(size, input->kind == STEIN_INPUT_MOTION ? 1e-2 : 1.0);
    }
    int exponent;
    (void)frexp(size, &exponent);
    return ldexp(1.0, exponent);
}

static void move_to(const mover *m, double value)
{
    slave *s = m->s;
    if (m->known.kind == FMI_PARAMETER) {
        s->p[m->known.index] = value;
        s->changed = 1;
    } else {
        s->input[m->known.index].u[m->known.order] = value;
        slave_bind(s, m->known.index);
        s->sim->fresh = STALE;
    }
    s->unsettled = 1;
}

/* f at a value of the known; NaN for an invalid state */
static double value_at(const mover *m, double value)
{
    slave_log_fn *listener = m->s->tell;
    slave_phase phase = m->s->phase;
    double f = NAN;
    move_to(m, value);
    m->s->tell = NULL;
    if (slave_get(m->s, m->unknown, &f) != SLAVE_OK) {
        f = NAN;
    }
    m->s->tell = listener;
    m->s->phase = phase;
    return f;
}

/* Richardson's table, row by row; the best entry */
static double extrapolate(const mover *m)
{
    double row[HALVINGS], last[HALVINGS], best = NAN, least = INFINITY, h = first_step * size_of(m);
    int rows = 0;
    for (int i = 0; i < HALVINGS; i++, h *= 0.5) {
        double high = m->at + h, low = m->at - h, factor = 4.0;
        row[0] = (value_at(m, high) - value_at(m, low)) / (high - low);
        if (!isfinite(row[0])) {
            rows = 0;
            continue;
        }
        best = isnan(best) ? row[0] : best;
        for (int k = 1; k <= rows; k++, factor *= 4.0) {
            row[k] = row[k - 1] + (row[k - 1] - last[k - 1]) / (factor - 1.0);
            double error = fmax(fabs(row[k] - row[k - 1]), fabs(row[k] - last[k - 1]));
            if (error < least) {
                least = error;
                best = row[k];
            }
        }
        memcpy(last, row, sizeof last);
        rows++;
    }
    return best;
}

/* an input as if it had just been set to its value. @return what is moved of it */
static double set_now(const mover *m)
{
    slave_input *in = &m->s->input[m->known.index];
    double now = m->s->phase == SLAVE_INITIALIZING ? 0.0 : m->s->sim->head->t;
    double x = isnan(in->since) ? 0.0 : now - in->since;
    in->u[0] += x * (in->u[1] + 0.5 * x * in->u[2]);
    in->u[1] += x * in->u[2];
    in->since = now;
    return in->u[m->known.order];
}

static int is_known(const slave *s, const fmi_variable *v)
{
    return v->kind == FMI_PARAMETER || (v->kind == FMI_INPUT && s->phase != SLAVE_INSTANTIATED);
}

slave_status slave_slope(slave *s, unsigned unknown, unsigned known, double *slope)
{
    mover m = {.s = s, .unknown = unknown};
    double f;
    if (!fmi_find(&s->model, known, &m.known) || !is_known(s, &m.known)) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "no derivative by value reference %d: expected an input "
                                           "or a parameter",
                                           (int)known));
    }
    if (slave_get(s, unknown, &f) != SLAVE_OK || slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    if (unknown == known || !isfinite(f)) {
        *slope = unknown == known ? 1.0 : 0.0;
        return SLAVE_OK;
    }
    m.at = m.known.kind == FMI_PARAMETER ? s->p[m.known.index] : 0.0;
    slave_input was = {.since = NAN};
    if (m.known.kind == FMI_INPUT) {
        was = s->input[m.known.index];
        m.at = set_now(&m);
    }
    double found = extrapolate(&m);
    move_to(&m, m.at);
    if (m.known.kind == FMI_INPUT) {
        was.bound = s->input[m.known.index].bound;
        s->input[m.known.index] = was;
        slave_bind(s, m.known.index);
    }
    int settled = slave_settle(s) == SLAVE_OK;
    s->sim->fresh = STALE;
    if (!settled || isnan(found)) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_ENONFINITE,
                                           "no derivative of value reference %d by %d: there are "
                                           "no values beside the present one",
                                           (int)unknown, (int)known));
    }
    *slope = found;
    return SLAVE_OK;
}
