/* SPDX-License-Identifier: GPL-3.0-or-later
 * problem.c - from model, data and definition to strokes, unknowns and priors.
 *
 * A positive number whose sign is physics (mass, stiffness, friction, damping) is fitted as its
 * logarithm: it stays positive, and a factor of two either way is the same distance. Coordinates,
 * angles, speeds, shifts, neutral positions and preloads can pass zero and are fitted as they are;
 * the speed over which a friction turns around cannot.
 * The prior is the file's tolerance. A number without one gets a weak prior, so that a direction
 * which the data do not tell ends where the file was instead of nowhere.
 *
 * A stroke has unknowns of its own: the time of an unsynchronised trigger; an offset of every
 * channel that a camera marker shows (markers are glued on by hand); the initial state, where the
 * mechanism does not settle and the stroke does not state it. The trigger's time would have the
 * same effect as the initial state, and is left out beside it. One factor each scales all joint
 * frictions, all contact frictions and the drive, since felt, leather and a finger differ from
 * stroke to stroke. Without these factors the scatter goes into the parameters, which are then ten
 * standard deviations off. Fewer than four strokes cannot show it. Errors of measured forces:
 * force_error.c.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "fitting.h"
#include "stein/batch.h"

enum { FEW = 4 }; /* strokes; fewer cannot show that they scatter */
static const double weak_length = 1e-3,
                    weak_angle = 1e-2; /* prior of a number that is 0 [m, rad] */
static const double per_second = 1.0;  /* bias of a rate sensor: a marker's offset in a second */
static const double zero_g = 0.2;      /* bias of an accelerometer [m/s^2]: +-40 mg, Bosch BMI160 */
static const double of_setting = 0.01; /* least sd of what was set by hand, in its size: chosen */
static const double least_compliance = 3e-4; /* limits */
static const double trace = 1e-6;     /* share of a positive number that an effect leaves of it */
static const double marker_arm = 0.1; /* a marker's offset as an angle: over this lever [m] */

double fit__value(const fit__unknown *u, double x)
{
    double z = u->start + u->sd * x;
    return u->log ? stein__exp_of(z) : z;
}

double fit__slope(const fit__unknown *u, double x)
{
    return u->log ? fit__value(u, x) : 1.0;
}

/* ---- free parameters ---- */

static int ends_with(const char *text, const char *ending)
{
    size_t n = strlen(text), k = strlen(ending);
    return n >= k && strcmp(text + n - k, ending) == 0;
}

static int is_positive(const stein_param *q)
{
    if (ends_with(q->name, ".vt") || ends_with(q->name, ".w")) {
        return q->value > 0.0;
    }
    static const char *const signed_unit[] = {"m", "rad", "m/s", "rad/s", "m/s^2"};
    for (size_t i = 0; i < sizeof signed_unit / sizeof *signed_unit; i++) {
        if (strcmp(q->unit, signed_unit[i]) == 0) {
            return 0;
        }
    }
    return q->value > 0.0 && !ends_with(q->name, "preload");
}

static fit__unknown free_parameter(const fit__problem *p, int index, double tolerance)
{
    const stein_param *q = &lab_equations(p->model)->params[index];
    fit__unknown u = {
        .kind = FIT__PARAM, .stroke = -1, .index = index, .log = is_positive(q), .prior = 1};
    double sd = q->tolerance > 0.0 ? q->tolerance
                : tolerance > 0.0  ? tolerance
                                   : p->def->prior * fabs(q->value);
    if (!(sd > 0.0)) {
        sd = strcmp(q->unit, "m") == 0 ? weak_length : weak_angle;
        u.prior = strcmp(q->unit, "m") == 0 || strcmp(q->unit, "rad") == 0;
        sd = u.prior ? sd : 1.0;
    }
    u.start = u.log ? stein__log_of(q->value) : q->value;
    u.sd = u.log ? sd / q->value : sd;
    return u;
}

/* what a stroke says of a parameter, NULL: nothing */
static const lab_setting *setting_of(const lab_data *data, int param)
{
    for (int i = 0; i < data->nset; i++) {
        if (data->set[i].param == param) {
            return &data->set[i];
        }
    }
    return NULL;
}

int fit__is_set(const lab_data *data, int param)
{
    return setting_of(data, param) != NULL;
}

int fit__always_set(const lab_dataset *data, int param)
{
    int n = 0;
    while (n < data->n && fit__is_set(data->stroke[n], param)) {
        n++;
    }
    return n == data->n;
}

int fit__always_known(const lab_dataset *data, int param)
{
    int known = fit__always_set(data, param);
    for (int s = 0; known && s < data->n; s++) {
        known = setting_of(data->stroke[s], param)->last_word;
    }
    return known;
}

static stein_status take_free(fit__problem *p, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    for (int i = 0; i < p->def->nfree; i++) {
        int index = stein_find_param(m, p->def->free[i]);
        if (index < 0) {
            return lab__fail(
                err, STEIN_ENAME,
                "no parameter \"%s\" in the equations of \"%s\" (a number that is 0 in "
                "the file is none: set it first)",
                p->def->free[i], m->name);
        }
        for (int k = 0; k < p->np; k++) {
            if (p->unknown[k].index == index) {
                return lab__fail(err, STEIN_EINVAL, "\"%s\" is free twice", p->def->free[i]);
            }
        }
        if (fit__always_set(p->data, index)) {
            return lab__fail(err, STEIN_EINVAL,
                             "\"%s\" cannot be fitted: every record sets it (# set %s)",
                             p->def->free[i], p->def->free[i]);
        }
        p->unknown[p->np++] =
            free_parameter(p, index, p->def->tolerance != NULL ? p->def->tolerance[i] : 0.0);
    }
    return STEIN_OK;
}

const char *const fit__number_name[FIT__NUMBERS] = {"amount", "side", "other", "third", "fourth"};

int fit__find_number(const char *name)
{
    for (int i = 0; i < FIT__NUMBERS; i++) {
        if (strcmp(name, fit__number_name[i]) == 0) {
            return i;
        }
    }
    return -1;
}

/* room for the amount of an effect and the numbers beside it. @return the amount */
static int take_numbers(fit__problem *p)
{
    for (int i = 0; i < FIT__NUMBERS; i++) {
        p->unknown[p->np++] = (fit__unknown){.kind = i == 0 ? FIT__AMOUNT : FIT__SIDE,
                                             .stroke = -1,
                                             .index = i - 1,
                                             .sd = 1.0,
                                             .prior = 1,
                                             .idle = 1};
    }
    return p->np - FIT__NUMBERS;
}

/* smallest value of a parameter in the records that an effect acts in, as these or the file state
 * it
 */
static double least_value(const fit__problem *p, const lab_candidate *c, const stein_param *q)
{
    double least = INFINITY;
    for (int i = 0; i < p->data->n; i++) {
        const lab_data *data = p->data->stroke[i];
        const lab_setting *set = setting_of(data, c->param[0]);
        if (lab_candidate_acts(c, data->number)) {
            least = fmin(least, set != NULL ? set->value : q->value);
        }
    }
    return isfinite(least) ? least : q->value;
}

/* smallest amount in limits: of a number whose sign is physics a trace of it remains */
static double least_amount(const fit__problem *p, const lab_candidate *c)
{
    if (lab_effect_is_compliance(c->effect)) {
        return least_compliance;
    }
    const stein_param *q = c->nparam > 0 ? &lab_equations(p->model)->params[c->param[0]] : NULL;
    int adds = c->move == LAB_MOVE_ADD || c->move == LAB_MOVE_SPRING;
    return q != NULL && adds && is_positive(q) ? (trace - 1.0) * least_value(p, c, q) / c->limit
                                               : (double)-INFINITY;
}

/* amount in limits; the numbers beside it from where they begin, in quarters of their range */
static void scale_numbers(const fit__problem *p, fit__unknown *amount, const lab_candidate *effect)
{
    amount->idle = effect == NULL;
    amount->mistake = effect != NULL && lab_candidate_is_mistakable(effect);
    amount->sd = effect != NULL ? effect->limit : 1.0;
    amount->least = effect != NULL ? least_amount(p, effect) : (double)-INFINITY;
    for (int k = 0; k < LAB_SIDES; k++) {
        const lab_side *side = effect != NULL ? &effect->side[k] : NULL;
        fit__unknown *u = amount + 1 + k;
        u->idle = side == NULL || side->param < 0;
        if (!u->idle) {
            u->log = side->log;
            u->start = side->log ? stein__log_of(side->value) : side->value;
            u->sd = 0.25 * (side->log ? stein__log_of(side->hi / side->lo) : side->hi - side->lo);
        }
    }
}

void fit__problem_try(fit__problem *p, const lab_candidate *effect)
{
    p->effect = effect;
    scale_numbers(p, &p->unknown[p->amount], effect);
}

static void take_effects(fit__problem *p, const lab_candidate *accepted, int n)
{
    p->first_accepted = p->np;
    p->naccepted = n;
    for (int i = 0; i < n; i++) {
        p->accepted[i] = &accepted[i];
        scale_numbers(p, &p->unknown[take_numbers(p)], &accepted[i]);
    }
    p->amount = take_numbers(p);
    p->side = p->amount + 1;
}

/* ---- a stroke's own ---- */

static int is_driven(const fit__problem *p, const fit__stroke *s, int joint)
{
    const stein_model *m = lab_equations(p->model);
    for (int i = 0; i < m->ninput; i++) {
        const stein_input *input = &m->inputs[i];
        if (input->kind != STEIN_INPUT_MOTION || input->index != joint) {
            continue;
        }
        for (int k = 0; k < s->nsignal; k++) {
            if (s->signal[k].input == i) {
                return 1;
            }
        }
        if (input->hold) {
            return 1;
        }
    }
    return 0;
}

/* is the joint's start set by the stroke or a free parameter? */
static int initial_known(const fit__problem *p, const fit__stroke *s, int joint, int *position)
{
    const stein_model *m = lab_equations(p->model);
    int known = 0;
    *position = -1;
    for (int i = 0; i < 2; i++) {
        char name[MECH_PATH];
        snprintf(name, sizeof name, "%s.initial.%s", m->bodies[joint].name,
                 i == 0 ? "position" : "speed");
        int index = stein_find_param(m, name);
        *position = i == 0 ? index : *position;
        known |= index >= 0 && fit__is_set(s->data, index);
        for (int k = 0; index >= 0 && k < p->np; k++) {
            known |= p->unknown[k].index == index;
        }
    }
    return known;
}

static void own(fit__problem *p, fit__stroke *s, int stroke, fit__kind kind, int index, double sd,
                int prior)
{
    p->unknown[p->nu++] =
        (fit__unknown){.kind = kind, .stroke = stroke, .index = index, .sd = sd, .prior = prior};
    s->own++;
}

/* tolerance of a number of a joint's start by the file; 0: none */
static double start_tolerance(const fit__problem *p, int joint, const char *what)
{
    const stein_model *m = lab_equations(p->model);
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.initial.%s", m->bodies[joint].name, what);
    int i = stein_find_param(m, name);
    return i >= 0 ? m->params[i].tolerance : 0.0;
}

/* Prior of a joint's position or speed where no channel of the record shows any: from acceleration
 * alone the state of a joint cannot be integrated back. A slide may have come as far as gravity
 * moves it within the record, a hinge half a turn, at a turn a second. @return 0: some show it */
static double unseen(const fit__problem *p, const fit__stroke *s, int joint, int speed)
{
    static const double fall = 9.81, half_turn = 3.14, turn = 6.28;
    const stein_model *m = lab_equations(p->model);
    double length = s->data->time[s->n - 1] - s->data->time[0];
    for (int c = 0; c < s->nch; c++) {
        int read = (int)m->channels[s->channel[c]].read;
        int rate = read == STEIN_READ_SPEED || (read >= STEIN_READ_VX && read <= STEIN_READ_VZ);
        if (stein_reads_place(read) || (speed && rate)) {
            return 0.0;
        }
    }
    return m->bodies[joint].type == 'R' ? (speed ? turn : half_turn)
           : speed                      ? fall * length
                                        : 0.5 * fall * length * length;
}

/* A state that the stroke states is that of t = 0; if none is, the start is the first sample. Times
 * of events alone show no start: it is as the file says, within its tolerance. */
static int own_initial(fit__problem *p, fit__stroke *s, int stroke)
{
    const stein_model *m = lab_equations(p->model);
    int free = p->def->initial == 1 || (p->def->initial < 0 && !m->settle && m->load.body < 0);
    int shown = s->nsampled > 0 || p->def->initial == 1;
    int n = 0, known = 0, position;
    for (int j = 0; free && j < m->nq; j++) {
        if (is_driven(p, s, j) || fit__is_hidden(p, s, j)) {
            continue;
        }
        if (initial_known(p, s, j, &position)) {
            known++;
            continue;
        }
        double tolerance = start_tolerance(p, j, "position");
        double fast = shown ? 0.0 : start_tolerance(p, j, "speed");
        double size = position >= 0 ? fabs(m->params[position].value) : 0.0;
        tolerance = tolerance > 0.0 || !shown ? tolerance : unseen(p, s, j, 0);
        fast = shown ? unseen(p, s, j, 1) : fast;
        if (shown || tolerance > 0.0) {
            own(p, s, stroke, FIT__POSITION, j,
                tolerance > 0.0 ? tolerance : 0.01 * fmax(size, 0.1), tolerance > 0.0);
            n++;
        }
        if (shown || fast > 0.0) {
            own(p, s, stroke, FIT__SPEED, j, fast > 0.0 ? fast : 0.01 * fmax(size, 0.1),
                fast > 0.0);
        }
    }
    if (n > 0 && known == 0 && m->load.body < 0 && !s->waits && !s->data->planned) {
        s->origin = s->data->time[0];
    }
    return n;
}

/* ---- scatter ---- */

/* is there anything in the group that is not 0, or will not stay so? */
static int group_acts(const fit__problem *p, int group)
{
    const stein_model *m = lab_equations(p->model);
    int acts = 0;
    for (int i = 0; i < m->np; i++) {
        acts |= p->group[i] == group && m->params[i].value != 0.0;
    }
    for (int k = 0; k < p->np; k++) {
        acts |= p->unknown[k].kind == FIT__PARAM && p->group[p->unknown[k].index] == group;
    }
    return acts;
}

static void own_scatter(fit__problem *p, fit__stroke *s, int stroke)
{
    const lab_fit_def *d = p->def;
    double sd[FIT__GROUPS] = {0.0, d->joint_scatter, d->contact_scatter, d->drive_scatter};
    int on = d->scatter > 0 || (d->scatter < 0 && p->nstroke >= FEW);
    for (int g = FIT__JOINTS; on && g < FIT__GROUPS * (p->places + 1); g++) {
        if (sd[fit__class(g)] > 0.0 && group_acts(p, g)) {
            own(p, s, stroke, FIT__SCATTER, g, sd[fit__class(g)], 1);
            p->unknown[p->nu - 1].log = 1;
        }
    }
}

/* What the stroke sets, by hand and to the digit that was written: 20 deg is between 19.5 and 20.5.
 * What scatters anyhow is left out. */
static void own_settings(fit__problem *p, fit__stroke *s, int stroke)
{
    const stein_model *m = lab_equations(p->model);
    for (int i = 0; p->def->settings && i < s->data->nset; i++) {
        const lab_setting *set = &s->data->set[i];
        double sd = fmax(set->step / sqrt(12.0), of_setting * fabs(set->value));
        int start = strstr(m->params[set->param].name, ".initial.") != NULL;
        sd = fmax(sd, m->params[set->param].tolerance);
        if (!set->last_word && p->group[set->param] == FIT__CALM && sd > 0.0 &&
            (start || p->def->settings != LAB_SETTINGS_STARTS)) {
            own(p, s, stroke, FIT__SETTING, set->param, sd, 1);
        }
    }
}

/* Prior sd of the trigger [s]. A recorded force comes with the film: all that is unknown is when
 * within a frame the mechanism was let go, which is uniform. Given more room, the trigger of a
 * light finger that bounces on its key finds a minimum for every bounce. */
static double trigger_sd(const fit__problem *p, const fit__stroke *s)
{
    const lab_data *d = s->data;
    double frame = d->nrow > 1 ? (d->time[d->nrow - 1] - d->time[0]) / (d->nrow - 1) : INFINITY;
    return s->nsignal > 0 ? fmin(p->def->trigger, frame / sqrt(12.0)) : p->def->trigger;
}

static void own_unknowns(fit__problem *p, int stroke)
{
    const stein_model *m = lab_equations(p->model);
    fit__stroke *s = &p->stroke[stroke];
    s->first = p->nu;
    s->tau = -1;
    int initial = own_initial(p, s, stroke);
    int clock = s->data->trigger == LAB_TRIGGER_UNSYNCHRONISED && initial == 0 &&
                (s->nsignal == 0 || m->load.body >= 0);
    if (clock && p->def->trigger > 0.0) {
        s->tau = p->nu;
        own(p, s, stroke, FIT__TAU, 0, trigger_sd(p, s), 1);
    }
    own_scatter(p, s, stroke);
    for (int k = 1; k < s->nsignal; k++) {
        s->signal[k].first = s->signal[k - 1].first + s->signal[k - 1].n;
    }
    s->force = fit__force_error_of(p, s);
    for (int k = 0; s->force != NULL && k < s->force->n; k++) {
        own(p, s, stroke, FIT__FORCE, k, 1.0, 1);
    }
    own_settings(p, s, stroke);
    // a channel that counts from rest, in a record that begins somewhere else
    int moves = initial > 0 && !s->data->planned && s->origin == s->data->time[0] &&
                (s->origin != 0.0 || s->data->trigger == LAB_TRIGGER_UNSYNCHRONISED);
    for (int c = 0; c < s->nch; c++) {
        const stein_channel *channel = &m->channels[s->channel[c]];
        int turns = strncmp(channel->unit, "rad", 3) == 0, rate = channel->read == STEIN_READ_SPEED;
        int accelerometer = strcmp(channel->unit, "m/s^2") == 0;
        double sd = rate ? p->def->offset * per_second : p->def->offset;
        sd = accelerometer && sd > 0.0 ? zero_g : sd / (turns ? marker_arm : 1.0);
        if (moves && channel->from_rest) {
            own(p, s, stroke, FIT__OFFSET, c, s->noise[c], 0);
        } else if ((rate || accelerometer || stein_reads_place((int)channel->read)) &&
                   sd > 0.01 * s->noise[c]) {
            own(p, s, stroke, FIT__OFFSET, c, sd, 1);
        }
    }
}

/* ---- the whole ---- */

static stein_status check_def(const lab_fit_def *d, const stein_model *m, int nstroke, int open,
                              stein_err *err)
{
    int lanes = d->lanes < 0 || d->lanes > stein_batch_width(m) || (d->lanes & (d->lanes - 1)) != 0;
    const char *bad = d->nfree < !open                              ? "nfree"
                      : !(d->prior > 0.0)                           ? "prior"
                      : !(d->offset >= 0.0)                         ? "offset"
                      : !(d->trigger >= 0.0)                        ? "trigger"
                      : d->starts < 1 || d->starts > LAB_FIT_STARTS ? "starts"
                      : d->iterations < 1                           ? "iterations"
                      : d->threads < 1                              ? "threads"
                      : lanes                                       ? "lanes"
                                                                    : NULL;
    if (bad != NULL) {
        return lab__fail(err, STEIN_EINVAL, "lab_fit_def.%s is out of range", bad);
    }
    return nstroke < 1 ? lab__fail(err, STEIN_EINVAL, "no records to fit to") : STEIN_OK;
}

/* of one record */
static size_t most_shapes(const lab_force_errors *e)
{
    int most = 0;
    for (int i = 0; e != NULL && i < e->n; i++) {
        most = e->record[i]->n > most ? e->record[i]->n : most;
    }
    return (size_t)most;
}

/* @param accepted  [n] effects that act; n < 0: no room for effects at all */
static stein_status make(fit__problem *p, const lab_model *model, const lab_dataset *data,
                         const lab_fit_def *def, const lab_candidate *accepted, int n,
                         stein_err *err)
{
    int open = n >= 0;
    *p = (fit__problem){.model = model,
                        .def = def,
                        .data = data,
                        .nstroke = data->n,
                        .fixed = -1,
                        .amount = -1,
                        .side = -1,
                        .flat = -1,
                        .tolerance = 1e-11,
                        .horizon = INFINITY,
                        .limit = 3.5,
                        .threads = def->threads,
                        .stop = {def->stop, def->ctx},
                        .lanes = def->lanes};
    stein_status status = check_def(def, lab_equations(model), data->n, open, err);
    if (status != STEIN_OK) {
        return status;
    }
    p->stroke = calloc((size_t)data->n, sizeof *p->stroke);
    size_t most = (size_t)def->nfree + FIT__NUMBERS * ((size_t)n + 1),
           nq = (size_t)lab_equations(model)->nq;
    const stein_model *m = lab_equations(model);
    p->places = def->scatter == LAB_SCATTER_PLACES ? m->nq + m->ncontact + m->nnotch : 0;
    for (int s = 0; s < data->n; s++) {
        most += 1 + FIT__GROUPS + (size_t)p->places + 2 * nq + (size_t)data->stroke[s]->ncolumn;
        most += most_shapes(def->force_errors);
    }
    p->unknown = calloc(most, sizeof *p->unknown);
    p->step = calloc(most, sizeof *p->step);
    p->group = calloc((size_t)m->np + 1, sizeof *p->group);
    if (p->stroke == NULL || p->unknown == NULL || p->step == NULL || p->group == NULL) {
        p->nstroke = 0;
        return lab__no_memory(err);
    }
    p->clock = stein_find_param(m, "clock.error");
    for (int i = 0; i < m->np; i++) {
        p->group[i] = (unsigned short)fit__group_of(m, m->params[i].name, p->places > 0);
    }
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        status = fit__take_stroke(p, s, data->stroke[s], err);
    }
    if (status == STEIN_OK) {
        fit__share_steps(p);
    }
    status = status == STEIN_OK ? take_free(p, err) : status;
    if (status == STEIN_OK && open) {
        take_effects(p, accepted, n);
    }
    p->nu = p->np;
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        own_unknowns(p, s);
    }
    for (int k = 0; k < p->nu; k++) {
        p->step[k] = 1e-2;
    }
    return status == STEIN_OK ? fit__initial_states(p, err) : status;
}

void fit__limit(fit__problem *p, double horizon)
{
    p->horizon = horizon;
    for (int s = 0; s < p->nstroke; s++) {
        fit__stroke *t = &p->stroke[s];
        int samples = 0;
        for (int c = 0; c < t->nch; c++) {
            double sum = 0.0;
            for (int i = 0; i < t->n; i++) {
                double y = t->y[c * t->n + i], share = t->share[c * t->n + i],
                       at = t->event[c].is ? y : fit__time_of(t, i);
                sum += isfinite(y) && at - t->origin <= horizon ? share * share : 0.0;
            }
            samples += (int)lround(sum);
        }
        p->samples += samples - t->samples;
        t->samples = samples;
    }
}

stein_status fit__check_samples(const fit__problem *p, stein_err *err)
{
    return p->samples > p->nu
               ? STEIN_OK
               : lab__fail(err, STEIN_EINVAL,
                           "%d samples cannot determine %d unknowns (%d free parameters, %d of the "
                           "records' own)",
                           p->samples, p->nu, p->np, p->nu - p->np);
}

stein_status fit__problem_make(fit__problem *p, const lab_model *model, const lab_dataset *data,
                               const lab_fit_def *def, stein_err *err)
{
    stein_status status = make(p, model, data, def, NULL, -1, err);
    return status == STEIN_OK ? fit__check_samples(p, err) : status;
}

stein_status fit__problem_make_open(fit__problem *p, const lab_model *model,
                                    const lab_dataset *data, const lab_fit_def *def, stein_err *err)
{
    return make(p, model, data, def, NULL, 0, err);
}

stein_status fit__problem_make_with(fit__problem *p, const lab_model *model,
                                    const lab_dataset *data, const lab_fit_def *def,
                                    const lab_candidate *accepted, int n, stein_err *err)
{
    return n <= FIT__ACCEPTED
               ? make(p, model, data, def, accepted, n, err)
               : lab__fail(err, STEIN_EINVAL, "%d effects at once, at most %d", n, FIT__ACCEPTED);
}

void fit__problem_free(fit__problem *p)
{
    for (int i = 0; p->stroke != NULL && i < p->nstroke; i++) {
        fit__stroke *s = &p->stroke[i];
        for (int k = 0; k < s->nsignal; k++) {
            fit__signal_free(&s->signal[k]);
        }
        free(s->channel);
        free(s->event);
        free(s->given);
        free(s->delay);
        free(s->noise);
        free(s->y);
        free(s->weight);
        free(s->signal);
    }
    free(p->stroke);
    free(p->unknown);
    free(p->step);
    free(p->group);
}
