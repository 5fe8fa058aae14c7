/* SPDX-License-Identifier: GPL-3.0-or-later
 * experiments.c - what could be done next with this mechanism.
 *
 * Nothing here knows a mechanism by name. What can be varied follows from the file and from the
 * strokes so far:
 *
 *   settings   every number that the strokes set, and the load's mass: its range so far, somewhat
 *              beyond, and the corners of two ranges
 *   starts     where a mechanism that does not settle is let go
 *   motions    every input that prescribes a motion: as far as its joint goes by itself, slower and
 *              quicker; half of it and back (a half stroke)
 *   forces     every input that is a force: to the largest force so far, or the load's weight
 *   removed    the string of the stroke
 *   mass       half as much again on a body that moves, weighed together
 *   channel    an output that nobody measured: a place as exactly as the others, a force to 1 %
 *   camera     four frames for one
 *
 * What the mechanism lacks is not proposed; what cannot be simulated says so and comes last.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data_inner.h"
#include "planning.h"

enum { LOOKS = 400 };
static const double marker_arm = 0.1;    /* of an angle seen as a place [m] */
static const double force_error = 0.01;  /* of a force sensor, of the largest force */
static const double beyond = 0.3;        /* of a range */
static const double more_mass = 0.5;     /* of a body's */
static const double least_travel = 1e-4; /* of a joint that moves [rad or m] */
static const double nearly_all = 0.9;    /* of a travel */
static const double quick = 0.5, slow = 2.0, half = 0.5;

static double rounded(double value)
{
    char text[LAB_NUMBER];
    snprintf(text, sizeof text, "%.3g", value);
    return strtod(text, NULL);
}

/* ---- the bench ---- */

static const lab_used *used(const lab_used *list, int n, const char *name)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].name, name) == 0) {
            return &list[i];
        }
    }
    return NULL;
}

static int add_set(lab_experiment *e, const char *name, const char *unit, double value)
{
    for (int i = 0; i < e->nset; i++) {
        if (strcmp(e->set[i].name, name) == 0) {
            e->set[i].value = value;
            return 1;
        }
    }
    if (e->nset == LAB_PLAN_SETS) {
        return 0;
    }
    lab_planned_set *s = &e->set[e->nset++];
    snprintf(s->name, sizeof s->name, "%s", name);
    s->unit = unit;
    s->value = value;
    return 1;
}

static const stein_input *input_of(const stein_model *m, const char *name)
{
    for (int i = 0; i < m->ninput; i++) {
        if (strcmp(m->inputs[i].name, name) == 0) {
            return &m->inputs[i];
        }
    }
    return NULL;
}

/* the strokes so far, in the middle of what they set and drive */
static void middle(plan__bench *b)
{
    const lab_conditions *c = &b->d->conditions;
    lab_experiment *e = &b->base;
    *e = (lab_experiment){.faster = 1, .feasible = 1, .name = "the same again"};
    snprintf(e->why, sizeof e->why, "a stroke like those so far, to compare with");
    for (int i = 0; i < c->nsetting; i++) {
        double value = c->setting[i].lo < c->setting[i].hi
                           ? rounded(0.5 * (c->setting[i].lo + c->setting[i].hi))
                           : c->setting[i].lo;
        add_set(e, c->setting[i].name, c->setting[i].unit, value);
    }
    const stein_input *input = c->ninput > 0 ? input_of(b->m, c->input[0].name) : NULL;
    if (input != NULL) {
        double lo = c->input[0].lo, hi = c->input[0].hi;
        int both = input->kind != STEIN_INPUT_MOTION && lo * hi < 0.0;
        snprintf(e->input, sizeof e->input, "%s", input->name);
        e->shape = both ? LAB_SHAPE_SWING : LAB_SHAPE_RISE;
        e->zero = both || input->kind != STEIN_INPUT_MOTION ? 0.0 : lo;
        e->size = both || input->kind != STEIN_INPUT_MOTION ? fmax(fabs(lo), fabs(hi)) : hi - lo;
        e->time = 0.25 * c->until;
    }
}

static void base_signal(void *ctx, double t, double u[3])
{
    const lab_experiment *e = ctx;
    double h = 1e-3 * e->time, y[3];
    for (int i = 0; i < 3; i++) {
        y[i] = e->zero + e->size * lab_shape_at(e->shape, e->time, t + (i - 1) * h);
    }
    u[0] = y[1];
    u[1] = (y[2] - y[0]) / (2.0 * h);
    u[2] = (y[2] - 2.0 * y[1] + y[0]) / (h * h);
}

/* the cause's parameters, in the model it is simulated in */
static void parameters(const plan__side *side, const lab_experiment *e, int with_effect, double *p)
{
    const stein_model *m = lab_equations(side->model);
    const lab_posterior *q = &side->s->posterior;
    double amount = 0.0;
    memcpy(p, lab_parameters(side->model), sizeof *p * (size_t)m->np);
    for (int i = 0; i < q->n; i++) {
        int k = stein_find_param(m, q->number[i].name);
        if (k >= 0) {
            p[k] = q->number[i].value;
        }
        amount = strcmp(q->number[i].name, "amount") == 0 ? q->number[i].value : amount;
    }
    for (int i = 0; with_effect && i < e->nset; i++) {
        int k = stein_find_param(m, e->set[i].name);
        if (k >= 0) {
            p[k] = e->set[i].value;
        }
    }
    if (with_effect) {
        lab_candidate_apply(&side->candidate, amount, p);
    }
}

typedef struct look {
    plan__bench *b;
    const stein_model *m; /* simulated */
    int *joint;           /* [nq of the file] in it, -1: none */
    double *range;        /* [nchannel of the file] largest reading */
    int *channel;         /* in it */
} look;

static void take(look *l, stein_sim *sim, int first)
{
    plan__bench *b = l->b;
    for (int j = 0; j < b->m->nq; j++) {
        double q = l->joint[j] >= 0 ? stein_q(sim)[l->joint[j]] : 0.0;
        b->rest[j] = first ? q : b->rest[j];
        b->low[j] = first ? q : fmin(b->low[j], q);
        b->high[j] = first ? q : fmax(b->high[j], q);
    }
    for (int k = 0; k < b->m->nchannel; k++) {
        if (l->channel[k] >= 0) {
            l->range[k] = fmax(l->range[k], fabs(stein_read(sim, l->channel[k])));
        }
    }
}

/* farthest way from rest, with its sign */
static double travel(const plan__bench *b, int j)
{
    double up = b->high[j] - b->rest[j], down = b->low[j] - b->rest[j];
    return up >= -down ? up : down;
}

/* simulate the base once (twice: what it reaches, then when) */
static stein_status run_base(look *l, stein_sim *sim, const double *p, stein_err *err)
{
    plan__bench *b = l->b;
    double until = b->d->conditions.until;
    stein_status status = STEIN_OK;
    for (int pass = 0; status == STEIN_OK && pass < 2; pass++) {
        status = stein_set_all(sim, p, err);
        status = status == STEIN_OK ? stein_reset(sim, err) : status;
        if (status == STEIN_OK && pass == 0) {
            take(l, sim, 1);
        }
        for (int i = 1; status == STEIN_OK && i <= LOOKS; i++) {
            status = stein_run(sim, until * i / LOOKS, err);
            if (pass == 0 && status == STEIN_OK) {
                take(l, sim, 0);
            }
            for (int j = 0; pass == 1 && status == STEIN_OK && j < b->m->nq; j++) {
                double way = travel(b, j);
                double q = l->joint[j] >= 0 ? stein_q(sim)[l->joint[j]] - b->rest[j] : 0.0;
                if (!isfinite(b->when[j]) && q / way >= nearly_all) {
                    b->when[j] = until * i / LOOKS;
                }
            }
        }
    }
    return status;
}

static int could_see(const stein_channel *c)
{
    switch (c->read) {
    case STEIN_READ_POSITION:
    case STEIN_READ_X:
    case STEIN_READ_Y:
    case STEIN_READ_Z:
    case STEIN_READ_GAP: return 1;
    case STEIN_READ_FORCE:
    case STEIN_READ_NOTCH_FORCE: return 2;
    default: return 0;
    }
}

/* channels that are or could be measured */
static void eyes(plan__bench *b, const double *range)
{
    const lab_conditions *c = &b->d->conditions;
    double length = INFINITY; // noise of a place
    for (int i = 0; i < c->nchannel; i++) {
        double by = strcmp(c->channel[i].unit, "rad") == 0 ? marker_arm
                    : strcmp(c->channel[i].unit, "m") == 0 ? 1.0
                                                           : (double)INFINITY;
        length = fmin(length, c->channel[i].noise * by);
    }
    for (int measured = 1; measured >= 0; measured--) {
        for (int k = 0; k < b->m->nchannel && b->neye < PLAN_EYES; k++) {
            const stein_channel *channel = &b->m->channels[k];
            const lab_used *u = used(c->channel, c->nchannel, channel->name);
            int angle = strcmp(channel->unit, "rad") == 0, kind = could_see(channel);
            double noise = u != NULL   ? u->noise
                           : kind == 1 ? length / (angle ? marker_arm : 1.0)
                           : kind == 2 ? force_error * range[k]
                                       : (double)NAN;
            if ((u != NULL) == measured && isfinite(noise) && noise > 0.0) {
                plan__eye *eye = &b->eye[b->neye++];
                snprintf(eye->name, sizeof eye->name, "%s", channel->name);
                eye->noise = noise;
                eye->measured = measured;
            }
        }
    }
}

static int body_of(const stein_model *m, const char *name)
{
    for (int j = 0; j < m->nq; j++) {
        if (strcmp(m->bodies[j].name, name) == 0) {
            return j;
        }
    }
    return -1;
}

stein_status plan__bench_make(plan__bench *b, const plan__side *cause, const lab_diagnosis *d,
                              const stein_model *m, stein_err *err)
{
    const stein_model *own = lab_equations(cause->model);
    size_t nq = (size_t)m->nq, nc = (size_t)m->nchannel;
    int threads = b->threads, one_sided = b->quick;
    *b = (plan__bench){.d = d, .m = m, .threads = threads, .quick = one_sided};
    b->p = calloc((size_t)m->np + 1, sizeof *b->p);
    b->low = calloc(4 * nq + 1, sizeof *b->low);
    look l = {.b = b,
              .m = own,
              .joint = calloc(nq + 1, sizeof *l.joint),
              .range = calloc(nc + 1, sizeof *l.range),
              .channel = calloc(nc + 1, sizeof *l.channel)};
    double *p = calloc((size_t)own->np + 1, sizeof *p);
    stein_sim *sim = NULL;
    stein_status status = b->p && b->low && l.joint && l.range && l.channel && p
                              ? lab_sim(cause->model, NULL, &sim, err)
                              : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (status == STEIN_OK) {
        b->high = b->low + nq;
        b->rest = b->high + nq;
        b->when = b->rest + nq;
        for (int j = 0; j < m->nq; j++) {
            l.joint[j] = body_of(own, m->bodies[j].name);
            b->when[j] = INFINITY;
        }
        for (int k = 0; k < m->nchannel; k++) {
            l.channel[k] = stein_find_channel(own, m->channels[k].name);
        }
        middle(b);
        parameters(cause, &b->base, 0, p);
        for (int i = 0; i < m->np; i++) {
            int k = stein_find_param(own, m->params[i].name);
            b->p[i] = k >= 0 ? p[k] : m->params[i].value;
        }
        parameters(cause, &b->base, 1, p);
        status = b->base.input[0] != '\0'
                     ? stein_drive(sim, b->base.input, base_signal, &b->base, err)
                     : STEIN_OK;
        status = status == STEIN_OK ? run_base(&l, sim, p, err) : status;
        eyes(b, l.range);
    }
    stein_sim_destroy(sim);
    free(l.joint);
    free(l.range);
    free(l.channel);
    free(p);
    return status;
}

void plan__bench_free(plan__bench *b)
{
    free(b->p);
    free(b->low);
}

/* ---- the list ---- */

typedef struct list {
    const plan__bench *b;
    lab_experiment *e;
    int n, room, nomem;
} list;

/* one more, like the base. @return NULL: out of memory */
static lab_experiment *add(list *l, const char *why, const char *format, ...)
{
    va_list args;
    if (l->n == l->room) {
        int room = 2 * l->room + 16;
        lab_experiment *more = realloc(l->e, sizeof *more * (size_t)room);
        if (more == NULL) {
            l->nomem = 1;
            return NULL;
        }
        l->e = more;
        l->room = room;
    }
    lab_experiment *e = &l->e[l->n++];
    *e = l->b->base;
    va_start(args, format);
    vsnprintf(e->name, sizeof e->name, format, args);
    va_end(args);
    snprintf(e->why, sizeof e->why, "%s", why);
    return e;
}

static void add_setting(list *l, const char *name, const char *unit, double value, const char *why)
{
    char text[DATA_SHOWN];
    const lab_experiment *base = &l->b->base;
    for (int i = 0; i < base->nset; i++) {
        if (strcmp(base->set[i].name, name) == 0 && base->set[i].value == value) {
            return; // the base itself
        }
    }
    lab_experiment *e = add(l, why, "%s = %s", name, data__quantity(text, value, unit));
    if (e != NULL && !add_set(e, name, unit, value)) {
        l->n--;
    }
}

/* a number whose values so far are known */
static void vary(list *l, const lab_used *u)
{
    double range = u->hi - u->lo;
    if (range > 0.0) {
        add_setting(l, u->name, u->unit, u->lo, "the low end of what was set so far");
        add_setting(l, u->name, u->unit, u->hi, "the high end of what was set so far");
        double below = rounded(u->lo - beyond * range), above = rounded(u->hi + beyond * range);
        if (below * u->lo > 0.0 || u->lo <= 0.0) { // what is positive stays so
            add_setting(l, u->name, u->unit, below, "below what was set so far");
        }
        add_setting(l, u->name, u->unit, above, "above what was set so far");
    } else if (u->lo != 0.0) {
        add_setting(l, u->name, u->unit, rounded(0.5 * u->lo), "half of what was set so far");
        add_setting(l, u->name, u->unit, rounded(1.5 * u->lo), "more than was set so far");
        add_setting(l, u->name, u->unit, rounded(2.0 * u->lo), "twice what was set so far");
    }
}

static void corners(list *l)
{
    const lab_conditions *c = &l->b->d->conditions;
    const lab_used *u[2];
    char text[2][DATA_SHOWN];
    int n = 0;
    for (int i = 0; i < c->nsetting && n < 2; i++) {
        if (c->setting[i].hi > c->setting[i].lo) {
            u[n++] = &c->setting[i];
        }
    }
    for (int k = 0; n == 2 && k < 4; k++) {
        double a = k & 1 ? u[0]->hi : u[0]->lo, b = k & 2 ? u[1]->hi : u[1]->lo;
        lab_experiment *e = add(l, "a corner of what was set so far", "%s = %s, %s = %s",
                                u[0]->name, data__quantity(text[0], a, u[0]->unit), u[1]->name,
                                data__quantity(text[1], b, u[1]->unit));
        if (e != NULL) {
            add_set(e, u[0]->name, u[0]->unit, a);
            add_set(e, u[1]->name, u[1]->unit, b);
        }
    }
}

/* numbers that nobody set so far but that are easy to */
static void vary_others(list *l)
{
    const plan__bench *b = l->b;
    const stein_model *m = b->m;
    const lab_conditions *c = &b->d->conditions;
    for (int j = 0; j < m->nq; j++) {
        const char *const rest[] = {"mass", "initial.position", "initial.speed"};
        for (int k = 0; k < 3; k++) {
            char name[LAB_PLACE];
            int load = j == m->load.body;
            snprintf(name, sizeof name, "%s.%s", m->bodies[j].name, rest[k]);
            int i = stein_find_param(m, name);
            int wanted = k == 0 ? load : !load && !m->settle && m->load.body < 0;
            if (!wanted || i < 0 || !m->params[i].stated || used(c->setting, c->nsetting, name)) {
                continue;
            }
            lab_used u = {.unit = m->params[i].unit, .lo = b->p[i], .hi = b->p[i]};
            snprintf(u.name, sizeof u.name, "%s", name);
            vary(l, &u);
        }
    }
}

static void drive(list *l, const stein_input *input, const char *what, lab_shape shape, double zero,
                  double size, double time)
{
    char text[2][DATA_SHOWN];
    lab_experiment *e = add(
        l, what, "%s %s %s in %s", input->name, shape == LAB_SHAPE_RISE ? "to" : "there and back,",
        data__quantity(text[0], zero + size, input->unit), data__quantity(text[1], time, "s"));
    if (e != NULL) {
        snprintf(e->input, sizeof e->input, "%s", input->name);
        e->shape = shape;
        e->zero = zero;
        e->size = size;
        e->time = time;
    }
}

static void motions(list *l)
{
    const plan__bench *b = l->b;
    const lab_conditions *c = &b->d->conditions;
    for (int i = 0; i < b->m->ninput; i++) {
        const stein_input *input = &b->m->inputs[i];
        if (input->kind != STEIN_INPUT_MOTION) {
            continue;
        }
        const lab_used *u = used(c->input, c->ninput, input->name);
        double zero = u != NULL ? u->lo : b->rest[input->index];
        double way = u != NULL ? u->hi - u->lo : travel(b, input->index);
        double time = b->when[input->index];
        time = rounded(isfinite(time) ? time : 0.25 * c->until);
        zero = u != NULL ? zero : b->rest[input->index];
        if (!(fabs(way) > least_travel) || !(time > 0.0)) {
            continue;
        }
        way = rounded(nearly_all * way);
        drive(l, input, "a motion as long as the mechanism's own", LAB_SHAPE_RISE, zero, way, time);
        drive(l, input, "a quick motion", LAB_SHAPE_RISE, zero, way, rounded(quick * time));
        drive(l, input, "a slow motion", LAB_SHAPE_RISE, zero, way, rounded(slow * time));
        drive(l, input, "half of the way, then back", LAB_SHAPE_BACK, zero, rounded(half * way),
              time);
        drive(l, input, "there and back, slowly", LAB_SHAPE_BACK, zero, way, rounded(slow * time));
    }
}

static void forces(list *l)
{
    const plan__bench *b = l->b;
    const stein_model *m = b->m;
    const lab_conditions *c = &b->d->conditions;
    for (int i = 0; i < m->ninput; i++) {
        const stein_input *input = &m->inputs[i];
        const lab_used *u = used(c->input, c->ninput, input->name);
        char name[LAB_PLACE] = "";
        if (m->load.body >= 0) {
            snprintf(name, sizeof name, "%s.mass", m->bodies[m->load.body].name);
        }
        int mass = stein_find_param(m, name);
        double size = u != NULL ? fmax(fabs(u->lo), fabs(u->hi))
                      : mass >= 0 && input->kind == STEIN_INPUT_POINT ? 9.81 * b->p[mass]
                                                                      : 0.0;
        double time = rounded(0.1 * c->until);
        if (input->kind == STEIN_INPUT_MOTION || !(size > 0.0) || !(time > 0.0)) {
            continue;
        }
        size = rounded(size);
        drive(l, input, "a force that stays", LAB_SHAPE_RISE, 0.0, size, time);
        drive(l, input, "half of the force", LAB_SHAPE_RISE, 0.0, rounded(half * size), time);
        drive(l, input, "a short push", LAB_SHAPE_BACK, 0.0, size, time);
        drive(l, input, "a long push, half as strong", LAB_SHAPE_BACK, 0.0, rounded(half * size),
              rounded(slow * time));
    }
}

/* is an effect on trial part of that thing? */
static int concerns(const plan__side *side, int nside, const char *thing)
{
    size_t n = strlen(thing);
    for (int i = 0; i < nside; i++) {
        const char *place = side[i].candidate.place;
        if (strncmp(place, thing, n) == 0 && (place[n] == '\0' || place[n] == '.')) {
            return 1;
        }
    }
    return 0;
}

/* no force from the string, whatever the depth */
static void without_string(list *l, const plan__side *side, int nside)
{
    static const char *const stiffness[] = {"a", "b", "c"};
    const stein_model *m = l->b->m;
    if (m->stroke.string < 0) {
        return;
    }
    const char *string = m->contacts[m->stroke.string].name;
    if (concerns(side, nside, string)) {
        return;
    }
    lab_experiment *e =
        add(l, "the hammer flies past the place of the string", "%s removed", string);
    for (int i = 0; e != NULL && i < 3; i++) {
        char name[LAB_PLACE];
        snprintf(name, sizeof name, "%s.normal.%s", string, stiffness[i]);
        int k = stein_find_param(m, name);
        if (k >= 0 && m->params[k].value != 0.0) {
            add_set(e, name, m->params[k].unit, 0.0);
        }
    }
}

/* does an effect on trial move that parameter? */
static int moves(const plan__side *side, int nside, const char *name)
{
    for (int i = 0; i < nside; i++) {
        const lab_candidate *c = &side[i].candidate;
        const stein_model *m = lab_equations(side[i].model);
        for (int k = 0; k < c->nparam; k++) {
            if (strcmp(m->params[c->param[k]].name, name) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

/* who weighs a body that is suspected to be heavier has no use for a stroke */
static void masses(list *l, const plan__side *side, int nside)
{
    const plan__bench *b = l->b;
    const stein_model *m = b->m;
    for (int j = 0; j < m->nq; j++) {
        char name[LAB_PLACE], text[2][DATA_SHOWN];
        snprintf(name, sizeof name, "%s.mass", m->bodies[j].name);
        int i = stein_find_param(m, name);
        if (i < 0 || j == m->load.body || !m->params[i].stated || !(b->p[i] > 0.0) ||
            fabs(travel(b, j)) < least_travel || moves(side, nside, name)) {
            continue;
        }
        double extra = rounded(more_mass * b->p[i]), whole = rounded(b->p[i] + extra);
        lab_experiment *e =
            add(l, "put on at its centre of mass; weigh both together", "%s with %s more: %s = %s",
                m->bodies[j].name, data__quantity(text[0], extra, "kg"), name,
                data__quantity(text[1], whole, "kg"));
        if (e != NULL && !add_set(e, name, "kg", whole)) {
            l->n--;
        }
    }
}

static void instruments(list *l)
{
    const plan__bench *b = l->b;
    for (int i = 0; i < b->neye; i++) {
        const plan__eye *eye = &b->eye[i];
        char text[DATA_SHOWN], why[LAB_PLAN_TEXT];
        if (eye->measured) {
            continue;
        }
        const char *unit = b->m->channels[stein_find_channel(b->m, eye->name)].unit;
        snprintf(why, sizeof why, "one channel more; its noise is taken to be %s",
                 data__quantity(text, eye->noise, unit));
        lab_experiment *e = add(l, why, "%s measured, too", eye->name);
        if (e != NULL) {
            snprintf(e->channel, sizeof e->channel, "%s", eye->name);
            e->noise = eye->noise;
        }
    }
    lab_experiment *e = add(l, "with the same noise in every frame", "a camera four times as fast");
    if (e != NULL) {
        e->faster = 4;
    }
}

stein_status plan__experiments(const plan__bench *b, const plan__side *side, int nside,
                               lab_experiment **out, int *n, stein_err *err)
{
    const lab_conditions *c = &b->d->conditions;
    list l = {.b = b};
    add(&l, b->base.why, "%s", b->base.name);
    instruments(&l); // first: those with the base's own motion
    for (int i = 0; i < c->nsetting; i++) {
        vary(&l, &c->setting[i]);
    }
    corners(&l);
    vary_others(&l);
    motions(&l);
    forces(&l);
    without_string(&l, side, nside);
    masses(&l, side, nside);
    if (l.nomem) {
        free(l.e);
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    *out = l.e;
    *n = l.n;
    return STEIN_OK;
}
