/* SPDX-License-Identifier: MIT
 * slave.c - an instance: its life, its variables, its steps.
 *
 * Steps. The mechanism is integrated in steps of fixed length dt, on a grid that begins at the end
 * of the last communication step. Where communication steps are multiples of dt these are the steps
 * that `stein simulate` makes, with the same bits. An importer computes times by its own sums and
 * products, so a grid point within dt/10^6 of the end is the end. Otherwise the last step is
 * shorter and a new grid begins.
 *
 * Inputs hold their value. A motion goes on with the speed and acceleration that are given beside
 * it, u + u' s + u'' s^2/2 with s counted from when it was set; a force with slopes does likewise.
 *
 * Set values are only stored. It reaches the simulation before the next step or reading: in
 * Initialization Mode by working out the initial state again.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "slave.h"

_Static_assert((int)FMI_NOTCH_GUARDS == (int)NOTCH_GUARDS, "value references count the guards");

const char *const slave_category_name[SLAVE_CATEGORIES] = {"logEvents", "logStatusDiscard",
                                                           "logStatusError"};
static const double grid_slack = 1e-6; /* of dt: this close to a grid point is on it */
static const double time_slack = 1e-3; /* of dt: this close to the own time is the own time */

/* ---- log ---- */

static void tell(slave *s, slave_status status, int category, const char *message)
{
    if (s->tell != NULL && (s->log >> category & 1u)) {
        s->tell(s->ctx, status, category, message);
    }
}

slave_status slave_refuse(slave *s, stein_status why)
{
    (void)why;
    s->phase = SLAVE_BROKEN;
    tell(s, SLAVE_ERROR, 2, s->err.msg);
    return SLAVE_ERROR;
}

void slave_tell_discarded(slave *s)
{
    tell(s, SLAVE_DISCARD, 1, s->err.msg);
}

static const char *phase_name(slave_phase phase)
{
    switch (phase) {
    case SLAVE_INSTANTIATED: return "before Initialization Mode";
    case SLAVE_INITIALIZING: return "in Initialization Mode";
    case SLAVE_STEPPING: return "between two steps";
    case SLAVE_FAILED: return "after a step that was discarded";
    case SLAVE_TERMINATED: return "terminated";
    case SLAVE_EVENTS: return "in Event Mode";
    case SLAVE_CONTINUOUS: return "in Continuous-Time Mode";
    default: return "after an error";
    }
}

slave_status slave_allow(slave *s, const char *function, unsigned phases)
{
    if ((unsigned)s->phase & phases) {
        return SLAVE_OK;
    }
    return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                       "%s is not allowed now: the instance is %s", function,
                                       phase_name(s->phase)));
}

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    static const char *const text[] = {
        "contact %s begins at t = %g s",   "contact %s ends at t = %g s",
        "string %s is struck at t = %g s", "notch %s lets go at t = %g s",
        "notch %s has caught at t = %g s", "notch %s is in phase %d from t = %g s",
        "%s sticks from t = %g s",         "%s slips (%d) from t = %g s"};
    slave *s = ctx;
    stein_err line;
    double t = s->start + event->time;
    const char *at = stein_event_at(stein_sim_model(sim), event);
    if (event->kind == STEIN_EVENT_PHASE || event->kind == STEIN_EVENT_SLIP) {
        stein__fail(&line, STEIN_OK, text[event->kind], at, event->phase, t);
    } else {
        stein__fail(&line, STEIN_OK, text[event->kind], at, t);
    }
    tell(s, SLAVE_OK, 0, line.msg);
}

/* events that are not logged have no subscriber */
static void listen(slave *s)
{
    stein_on_event(s->sim, s->log & SLAVE_LOG_EVENTS ? on_event : NULL, s);
}

slave_status slave_set_log(slave *s, int on, size_t n, const char *const *names)
{
    unsigned bits = n == 0 ? (1u << SLAVE_CATEGORIES) - 1u : 0u;
    for (size_t i = 0; i < n; i++) {
        int k = 0;
        while (k < SLAVE_CATEGORIES &&
               (names[i] == NULL || strcmp(names[i], slave_category_name[k]) != 0)) {
            k++;
        }
        if (k == SLAVE_CATEGORIES) {
            return slave_refuse(s, stein__fail(&s->err, STEIN_ENAME,
                                               "no log category \"%s\": expected logEvents, "
                                               "logStatusDiscard or logStatusError",
                                               names[i] != NULL ? names[i] : "NULL"));
        }
        bits |= 1u << k;
    }
    s->log = on ? s->log | bits : s->log & ~bits;
    listen(s);
    return SLAVE_OK;
}

/* ---- life ---- */

static void to_start(slave *s)
{
    const stein_model *m = &s->model;
    memcpy(s->p, slave_the_model.values, sizeof *s->p * (size_t)m->np);
    (void)stein_try_all(s->sim, s->p, NULL);
    for (int i = 0; i < m->ninput; i++) {
        const stein_input *input = &m->inputs[i];
        int motion = input->kind == STEIN_INPUT_MOTION;
        s->input[i] = (slave_input){.since = NAN, .follow = motion && input->hold};
        s->input[i].u[0] = motion ? s->sim->d[m->initial + 2 * input->index] : 0.0;
        (void)stein_drive(s->sim, input->name, NULL, NULL, NULL);
    }
    s->load = m->load.body >= 0;
    s->dt = slave_the_model.dt;
    s->start = s->reached = 0.0;
    s->stop = INFINITY;
    s->phase = SLAVE_INSTANTIATED;
    s->changed = s->unsettled = 1;
    s->jumped = 0;
}

static int is_blank(const char *text)
{
    return text == NULL || text[strspn(text, " \t\r\n")] == '\0';
}

/* memory and simulation */
static stein_status furnish(slave *s)
{
    size_t np = (size_t)s->model.np, ninput = (size_t)s->model.ninput;
    s->params = malloc(sizeof *s->params * (np + 1));
    s->p = malloc(sizeof *s->p * (np + 1));
    s->input = calloc(ninput + 1, sizeof *s->input);
    if (s->params == NULL || s->p == NULL || s->input == NULL) {
        return stein__fail(&s->err, STEIN_ENOMEM, "out of memory");
    }
    for (size_t i = 0; i < np; i++) {
        s->params[i] = s->model.params[i];
        s->params[i].value = slave_the_model.values[i];
    }
    s->model.params = s->params;
    s->model.dt = slave_the_model.dt;
    s->model.integrator = slave_the_model.integrator;
    s->model.settle = slave_the_model.settle;
    stein_status status = stein_sim_create(&s->sim, &s->model, NULL, &s->err);
    if (status != STEIN_OK) {
        return status;
    }
    s->kept = malloc(s->sim->state_size);
    return s->kept != NULL ? STEIN_OK : stein__fail(&s->err, STEIN_ENOMEM, "out of memory");
}

slave *slave_create(const char *name, const char *token, int exchange, slave_log_fn *log_fn,
                    void *ctx, unsigned log)
{
    slave first = {.exchange = exchange, .log = log, .tell = log_fn, .ctx = ctx};
    if (is_blank(name)) {
        tell(&first, SLAVE_ERROR, 2, "an instance needs a name");
        return NULL;
    }
    if (token == NULL || strcmp(token, slave_the_model.token) != 0) {
        stein__fail(&first.err, STEIN_ESTALE,
                    "modelDescription.xml and binary do not belong together: token \"%s\", "
                    "expected \"%s\"",
                    token != NULL ? token : "NULL", slave_the_model.token);
        tell(&first, SLAVE_ERROR, 2, first.err.msg);
        return NULL;
    }
    slave *s = malloc(sizeof *s);
    if (s == NULL) {
        tell(&first, SLAVE_ERROR, 2, "out of memory");
        return NULL;
    }
    *s = first;
    s->model = *slave_the_model.equations;
    if (furnish(s) != STEIN_OK) {
        tell(s, SLAVE_ERROR, 2, s->err.msg);
        slave_destroy(s);
        return NULL;
    }
    to_start(s);
    listen(s);
    return s;
}

void slave_destroy(slave *s)
{
    if (s != NULL) {
        stein_sim_destroy(s->sim);
        free(s->params);
        free(s->p);
        free(s->input);
        free(s->kept);
        free(s);
    }
}

slave_status slave_reset(slave *s)
{
    to_start(s);
    return SLAVE_OK;
}

slave_status slave_set_time(slave *s, double start, double stop)
{
    if (!isfinite(start) || isnan(stop) || stop < start) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "a simulation from t = %g s to t = %g s: expected a "
                                           "start and a later stop",
                                           start, stop));
    }
    s->start = s->reached = start;
    s->stop = stop;
    return SLAVE_OK;
}

slave_status slave_enter_initialization(slave *s)
{
    s->phase = SLAVE_INITIALIZING;
    s->unsettled = 1;
    return SLAVE_OK;
}

slave_status slave_exit_initialization(slave *s)
{
    if (slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    s->phase = s->exchange ? SLAVE_EVENTS : SLAVE_STEPPING;
    s->reached = s->start;
    return SLAVE_OK;
}

/* ---- inputs ---- */

static void input_signal(void *ctx, double t, double u[3])
{
    const slave_input *in = ctx;
    double x = isnan(in->since) ? 0.0 : t - in->since;
    u[0] = in->u[0] + x * (in->u[1] + 0.5 * x * in->u[2]);
    u[1] = in->u[1] + x * in->u[2];
    u[2] = in->u[2];
}

/* a force of nothing is not asked for in every evaluation, a motion only where it is followed */
void slave_bind(slave *s, int i)
{
    const stein_input *input = &s->model.inputs[i];
    slave_input *in = &s->input[i];
    int on = input->kind == STEIN_INPUT_MOTION
                 ? in->follow
                 : in->u[0] != 0.0 || in->u[1] != 0.0 || in->u[2] != 0.0;
    if (on || on != in->bound) {
        (void)stein_drive(s->sim, input->name, on ? input_signal : NULL, in, NULL);
    }
    in->bound = on;
}

static void set_input(slave *s, int i, int order, double value)
{
    slave_input *in = &s->input[i];
    double now = s->phase & SLAVE_RUNNING ? s->sim->head->t : 0.0;
    if (in->since != now && s->model.inputs[i].kind != STEIN_INPUT_MOTION) {
        in->u[1] = in->u[2] = 0.0; // slopes of an earlier step
    }
    in->since = now;
    in->u[order] = value;
    slave_bind(s, i);
    s->unsettled = 1;
}

slave_status slave_set_slope(slave *s, unsigned reference, int order, double value)
{
    fmi_variable v;
    if (!fmi_find(&s->model, reference, &v) || v.kind != FMI_INPUT || v.order != 0 || order < 1 ||
        order > 2 || s->model.inputs[v.index].kind == STEIN_INPUT_MOTION || !isfinite(value)) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "value reference %d has no derivative of order %d: "
                                           "expected a force input, order 1 or 2, a finite value",
                                           (int)reference, order));
    }
    double now = s->phase & SLAVE_RUNNING ? s->sim->head->t : 0.0;
    s->input[v.index].since = now; // its value, too, counts from here
    s->input[v.index].u[order] = value;
    slave_bind(s, v.index);
    s->unsettled = 1;
    return SLAVE_OK;
}

/* ---- variables ---- */

static slave_status find(slave *s, unsigned reference, int boolean, fmi_variable *v)
{
    if (!fmi_find(&s->model, reference, v)) {
        return slave_refuse(s,
                            stein__fail(&s->err, STEIN_ENAME,
                                        "no variable has the value reference %d", (int)reference));
    }
    if (fmi_is_boolean(v->kind) != boolean) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "the variable of value reference %d is %s Boolean",
                                           (int)reference, boolean ? "no" : "a"));
    }
    return SLAVE_OK;
}

/* the initial state with the set values */
static slave_status find_start(slave *s)
{
    s->sim->def.dt = s->dt;
    for (int i = 0; i < s->model.ninput; i++) {
        slave_bind(s, i);
    }
    stein_status status = stein_try_all(s->sim, s->p, &s->err);
    status = status == STEIN_OK ? stein_reset(s->sim, &s->err) : status;
    s->changed = s->unsettled = 0;
    if (status == STEIN_OK && !s->load) {
        stein_load_lift(s->sim);
    }
    return status == STEIN_OK ? SLAVE_OK : slave_refuse(s, status);
}

/* the load taken away, or put back where the mechanism is now */
static stein_status move_load(slave *s)
{
    s->jumped = 1;
    if (s->load) {
        return stein_load_place(s->sim, &s->err);
    }
    stein_load_lift(s->sim);
    return STEIN_OK;
}

slave_status slave_settle(slave *s)
{
    if (s->phase == SLAVE_INITIALIZING && s->unsettled) {
        return find_start(s);
    }
    stein_status status = STEIN_OK;
    if (s->phase & SLAVE_RUNNING && s->changed) {
        s->changed = 0;
        status = stein_try_all(s->sim, s->p, &s->err);
    }
    if (s->phase & SLAVE_RUNNING && status == STEIN_OK && s->load != stein_load_present(s->sim)) {
        status = move_load(s);
    }
    return status == STEIN_OK ? SLAVE_OK : slave_refuse(s, status);
}

/* the state of the simulation */
static slave_status read(slave *s, const fmi_variable *v, double *value)
{
    if (s->phase == SLAVE_INSTANTIATED) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "value reference %d has no value before "
                                           "Initialization Mode",
                                           (int)fmi_reference(&s->model, *v)));
    }
    if (slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    stein_status status = stein__refresh(s->sim, &s->err);
    if (status != STEIN_OK) {
        return slave_refuse(s, status);
    }
    if (v->kind == FMI_COORDINATE) {
        const double *const x[] = {s->sim->xq, s->sim->xqd, s->sim->qdd};
        *value = x[v->order][v->index];
    } else if (v->kind == FMI_GUARD) {
        *value = s->sim->guard[v->index];
    } else {
        *value = stein_read(s->sim, v->index);
    }
    return SLAVE_OK;
}

slave_status slave_get(slave *s, unsigned reference, double *value)
{
    fmi_variable v;
    if (find(s, reference, 0, &v) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    switch (v.kind) {
    case FMI_PARAMETER: *value = s->p[v.index]; return SLAVE_OK;
    case FMI_STEP: *value = s->dt; return SLAVE_OK;
    case FMI_INPUT: *value = s->input[v.index].u[v.order]; return SLAVE_OK;
    case FMI_CHANNEL:
        if (v.index == 0) { // the time, also before the start
            int runs = s->phase != SLAVE_INSTANTIATED && s->phase != SLAVE_INITIALIZING;
            *value = s->start + (runs ? s->sim->head->t : 0.0);
            return SLAVE_OK;
        }
        return read(s, &v, value);
    default: return read(s, &v, value);
    }
}

/* may a variable be set now? */
static slave_status may_set(slave *s, const fmi_variable *v)
{
    unsigned phases = SLAVE_INSTANTIATED | SLAVE_INITIALIZING;
    const char *what = "a fixed parameter";
    if (v->kind == FMI_CHANNEL || v->kind == FMI_COORDINATE || v->kind == FMI_GUARD) {
        phases = 0;
        what = "an output or a local variable";
    } else if (v->kind == FMI_INPUT) {
        phases |= SLAVE_RUNNING;
        what = "an input";
    } else if (v->kind == FMI_LOAD) {
        phases |= SLAVE_STEPPING | SLAVE_EVENTS;
        what = "a discrete input";
    } else if (v->kind == FMI_PARAMETER && slave_the_model.tunable[v->index]) {
        phases |= SLAVE_STEPPING | SLAVE_EVENTS;
        what = "a tunable parameter";
    }
    if ((unsigned)s->phase & phases) {
        return SLAVE_OK;
    }
    return slave_refuse(s,
                        stein__fail(&s->err, STEIN_EINVAL,
                                    "value reference %d cannot be set: it is %s, and the "
                                    "instance is %s",
                                    (int)fmi_reference(&s->model, *v), what, phase_name(s->phase)));
}

slave_status slave_set(slave *s, unsigned reference, double value)
{
    fmi_variable v;
    if (find(s, reference, 0, &v) != SLAVE_OK || may_set(s, &v) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    if (!isfinite(value) || (v.kind == FMI_STEP && !(value > 0.0))) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "value reference %d cannot be %g: expected a %s number",
                                           (int)reference, value,
                                           v.kind == FMI_STEP ? "positive" : "finite"));
    }
    if (v.kind == FMI_INPUT) {
        set_input(s, v.index, v.order, value);
    } else if (v.kind == FMI_STEP) {
        s->dt = value;
        s->unsettled = 1;
    } else {
        stein_status status = stein__check_param(&s->model.params[v.index], value, &s->err);
        if (status != STEIN_OK) {
            return slave_refuse(s, status);
        }
        s->p[v.index] = value;
        s->changed = s->unsettled = 1;
    }
    return SLAVE_OK;
}

slave_status slave_get_flag(slave *s, unsigned reference, int *value)
{
    fmi_variable v;
    if (find(s, reference, 1, &v) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    *value = v.kind == FMI_LOAD ? s->load : s->input[v.index].follow;
    return SLAVE_OK;
}

slave_status slave_set_flag(slave *s, unsigned reference, int value)
{
    fmi_variable v;
    if (find(s, reference, 1, &v) != SLAVE_OK || may_set(s, &v) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    if (v.kind == FMI_LOAD) {
        s->load = value != 0;
    } else {
        s->input[v.index].follow = value != 0;
    }
    s->unsettled = 1;
    return SLAVE_OK;
}

/* ---- steps ---- */

/* is it a step that can be made? */
static slave_status check_step(slave *s, double at, double h)
{
    double now = s->start + s->sim->head->t, slack = time_slack * s->dt;
    if (!(h > 0.0) || !isfinite(h)) {
        return slave_refuse(
            s, stein__fail(&s->err, STEIN_EINVAL, "a step of %g s: expected a positive length", h));
    }
    if (!(fabs(at - now) <= slack)) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "a step from t = %g s, but the mechanism is at t = %g s",
                                           at, now));
    }
    if (at + h > s->stop + slack) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "a step to t = %g s, beyond the stop time %g s", at + h,
                                           s->stop));
    }
    return SLAVE_OK;
}

static stein_status run(slave *s, double t_end)
{
    const state_head *head = s->sim->head;
    double dt = s->sim->def.dt, slack = grid_slack * dt;
    while (head->t0 + (double)(head->step + 1) * dt <= t_end + slack) {
        stein_status status = stein_step(s->sim, &s->err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    return head->t < t_end - slack ? stein_run(s->sim, t_end, &s->err) : STEIN_OK;
}

slave_status slave_step(slave *s, double at, double h)
{
    if (check_step(s, at, h) != SLAVE_OK || slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    memcpy(s->kept, s->sim->state, s->sim->state_size);
    if (run(s, at + h - s->start) == STEIN_OK) {
        s->reached = at + h;
        return SLAVE_OK;
    }
    memcpy(s->sim->state, s->kept, s->sim->state_size);
    s->sim->fresh = STALE;
    slave_tell_discarded(s);
    return SLAVE_DISCARD;
}
