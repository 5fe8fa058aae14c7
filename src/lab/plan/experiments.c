/* SPDX-License-Identifier: GPL-3.0-or-later
 * experiments.c - possible experiments with this mechanism.
 *
 * No mechanism is treated by name. Possible variations follow from the file and from the present
 * strokes:
 *
 *   settings   every number that the strokes set, and the load's mass: its range so far, somewhat
 *              beyond, and the corners of two ranges
 *   starts     where a mechanism that does not settle is let go
 *   motions    every input that prescribes a motion: as far as its joint goes by itself, slower and
 *              quicker; half of it and back (a half stroke)
 *   forces     every input that is a force: to the largest force so far, or the load's weight
 *   removed    the string of the stroke; what is supposed to hang on a body
 *   mass       half as much again on a body that moves, or more than twice, weighed together
 *   channel    an output that was not measured and that there is an instrument for: a place as
 *              exactly as the others, a force on the ground to 1 %
 *   camera     ten frames for one
 *   checks     no strokes: a suspected instrument, length or felt is checked separately
 *              (instrument_check.c)
 *
 * and two or three of these at once, as long as that gives more information (plan.c).
 *
 * Each of them states its distance from the present strokes: there the model has not been seen to
 * hold. Parts that the mechanism lacks are not proposed; experiments that cannot be simulated are
 * marked and come last.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"
#include "planning.h"
#include "added_parts.h"

enum { FASTER = 10 };
static const char fast_camera[] = "a camera ten times as fast";
static const double farther = 0.3;                    /* of a range */
static const double one_value = 0.1;                  /* range over size, of one value */
static const double still = 0.05;                     /* of a joint's largest speed: at rest */
static const double more_mass = 0.5, much_mass = 1.5; /* of a body's */
static const double least_travel = 1e-4;              /* of a joint that moves [rad or m] */
static const double nearly_all = 0.9;                 /* of a travel */
static const double quick = 0.5, slow = 2.0, half = 0.5, hard = 2.0, very_hard = 4.0, heavy = 3.0;
static const double a_part_less = 2.0; /* beyond: as bold as twice the force */
static const double least_load = 0.1;  /* that is heavy when it is so much more [kg] */

/* ---- the list ---- */

typedef struct list {
    const plan__reference *b;
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
    e->beyond = 1.0;
    va_start(args, format);
    vsnprintf(e->name, sizeof e->name, format, args);
    va_end(args);
    snprintf(e->why, sizeof e->why, "%s", why);
    return e;
}

/* text that does not fit is cut before it: the beginning of each has the most information */
static void append(char to[LAB_PLAN_TEXT], const char *between, const char *more)
{
    size_t gap = strlen(between), last = strlen(more), n = strlen(to);
    last = last < LAB_PLAN_TEXT / 2 ? last : LAB_PLAN_TEXT / 2;
    size_t most = LAB_PLAN_TEXT - 1 - gap - last;
    n = n < most ? n : most;
    memcpy(to + n, between, gap);
    memcpy(to + n + gap, more, last);
    to[n + gap + last] = '\0';
}

/* 1: it has been so; 2: as far outside as the former range was wide, or large */
static double outside(const lab_used *u, double value)
{
    double end = fmin(fmax(value, u->lo), u->hi), scale = fmax(u->hi - u->lo, fabs(end));
    return value == end ? 1.0 : scale > 0.0 ? 1.0 + fabs(value - end) / scale : 2.0;
}

static void add_setting(list *l, const lab_used *u, double value, const char *why)
{
    char text[DATA_SHOWN];
    const lab_planned_set *base = plan__set_of(&l->b->base, u->name);
    if (base != NULL && base->value == value) {
        return; // the base itself
    }
    lab_experiment *e = add(l, why, "%s = %s", u->name, data__quantity(text, value, u->unit));
    if (e != NULL && !plan__set(e, u->name, u->unit, value)) {
        l->n--;
    } else if (e != NULL) {
        e->beyond = outside(u, value);
    }
}

/* Was it set on purpose to several values? What differs less was meant to be one. */
static int is_range(const lab_used *u)
{
    return u->hi - u->lo > one_value * fmax(fabs(u->lo), fabs(u->hi));
}

/* Is it the speed of a joint that was let go at rest, as far as an estimate shows it? */
static int is_rest(const plan__reference *b, const lab_used *u)
{
    int rest = 0;
    for (int j = 0; j < b->m->nq; j++) {
        char name[2 * LAB_PLACE];
        snprintf(name, sizeof name, "%.100s.initial.speed", b->m->bodies[j].name);
        rest |= strcmp(name, u->name) == 0 && fmax(fabs(u->lo), fabs(u->hi)) < still * b->fast[j];
    }
    return rest;
}

/* a number with known values so far */
static void vary(list *l, const lab_used *u)
{
    double range = u->hi - u->lo;
    if (is_range(u)) {
        add_setting(l, u, u->lo, "the low end of the settings so far");
        add_setting(l, u, u->hi, "the high end of the settings so far");
        double below = plan__rounded(u->lo - farther * range),
               above = plan__rounded(u->hi + farther * range);
        if (below * u->lo > 0.0 || u->lo <= 0.0) { // positive values stay positive
            add_setting(l, u, below, "below what was set so far");
        }
        add_setting(l, u, above, "above what was set so far");
    } else if (u->lo != 0.0) {
        add_setting(l, u, plan__rounded(0.5 * u->lo), "half of the settings so far");
        add_setting(l, u, plan__rounded(1.5 * u->lo), "more than was set so far");
        add_setting(l, u, plan__rounded(2.0 * u->lo), "twice what was set so far");
    }
}

/* a load is soon heavier, and presses what a light one hardly touches */
static void weigh_down(list *l, const lab_used *u)
{
    double value = plan__rounded(heavy * fmax(u->hi, least_load));
    add_setting(l, u, value, "a heavy load");
}

static void corners(list *l)
{
    const lab_conditions *c = &l->b->d->conditions;
    const lab_used *u[2];
    char text[2][DATA_SHOWN];
    int n = 0;
    for (int i = 0; i < c->nsetting && n < 2; i++) {
        if (is_range(&c->setting[i]) && !is_rest(l->b, &c->setting[i])) {
            u[n++] = &c->setting[i];
        }
    }
    for (int k = 0; n == 2 && k < 4; k++) {
        double a = k & 1 ? u[0]->hi : u[0]->lo, b = k & 2 ? u[1]->hi : u[1]->lo;
        lab_experiment *e = add(l, "a corner of the settings so far", "%s = %s, %s = %s",
                                u[0]->name, data__quantity(text[0], a, u[0]->unit), u[1]->name,
                                data__quantity(text[1], b, u[1]->unit));
        if (e != NULL) {
            plan__set(e, u[0]->name, u[0]->unit, a);
            plan__set(e, u[1]->name, u[1]->unit, b);
        }
    }
}

/* the load, when no record sets it */
static void vary_load(list *l)
{
    const plan__reference *b = l->b;
    const lab_conditions *c = &b->d->conditions;
    char name[LAB_PLACE] = "";
    if (b->m->load.body >= 0) {
        snprintf(name, sizeof name, "%s.mass", b->m->bodies[b->m->load.body].name);
    }
    int i = stein_find_param(b->m, name);
    const lab_used *set = plan__used(c->setting, c->nsetting, name);
    if (set != NULL) {
        weigh_down(l, set);
    } else if (i >= 0 && b->m->params[i].stated) {
        lab_used u = {.unit = b->m->params[i].unit, .lo = b->p[i], .hi = b->p[i]};
        snprintf(u.name, sizeof u.name, "%s", name);
        vary(l, &u);
        weigh_down(l, &u);
    }
}

/* where and how a joint is let go, of mechanisms that do not settle */
static void vary_start(list *l, int joint)
{
    const plan__reference *b = l->b;
    const stein_model *m = b->m;
    const lab_conditions *c = &b->d->conditions;
    char name[LAB_PLACE];
    snprintf(name, sizeof name, "%s.initial.position", m->bodies[joint].name);
    int i = stein_find_param(m, name);
    const lab_used *set = plan__used(c->setting, c->nsetting, name);
    if (i >= 0 && set == NULL && m->params[i].stated) {
        lab_used u = {.unit = m->params[i].unit, .lo = b->p[i], .hi = b->p[i]};
        snprintf(u.name, sizeof u.name, "%s", name);
        vary(l, &u);
    }
    double from = set != NULL ? set->hi : i >= 0 ? b->p[i] : 0.0;
    if (i >= 0 && from != 0.0 && strcmp(m->params[i].unit, "rad") == 0) {
        lab_used u = {.unit = m->params[i].unit, .lo = -fabs(from), .hi = fabs(from)};
        snprintf(u.name, sizeof u.name, "%s", name);
        add_setting(l, &u, -from, "let go on the other side");
    }
    snprintf(name, sizeof name, "%s.initial.speed", m->bodies[joint].name);
    i = stein_find_param(m, name);
    double speed = plan__rounded(half * b->fast[joint]);
    if (i >= 0 && speed > 0.0 && plan__used(c->setting, c->nsetting, name) == NULL) {
        lab_used u = {.unit = m->params[i].unit}; // none so far
        snprintf(u.name, sizeof u.name, "%s", name);
        add_setting(l, &u, speed, "let go with a speed");
        add_setting(l, &u, -speed, "let go with a speed, the other way");
    }
}

static void vary_others(list *l)
{
    const stein_model *m = l->b->m;
    vary_load(l);
    for (int j = 0; j < m->nq && !m->settle && m->load.body < 0; j++) {
        int driven = 0;
        for (int i = 0; i < m->ninput; i++) {
            const stein_input *input = &m->inputs[i];
            driven |= input->kind == STEIN_INPUT_MOTION && input->index == j &&
                      (input->hold || strcmp(input->name, l->b->base.input) == 0);
        }
        if (!driven) {
            vary_start(l, j);
        }
    }
}

static void drive(list *l, const stein_input *input, const char *what, lab_shape shape, double zero,
                  double size, double time, double beyond)
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
        e->beyond = beyond;
    }
}

static void motions(list *l)
{
    const plan__reference *b = l->b;
    const lab_conditions *c = &b->d->conditions;
    for (int i = 0; i < b->m->ninput; i++) {
        const stein_input *input = &b->m->inputs[i];
        if (input->kind != STEIN_INPUT_MOTION) {
            continue;
        }
        const lab_used *u = plan__used(c->input, c->ninput, input->name);
        double zero = u != NULL ? u->lo : b->rest[input->index];
        double way = u != NULL ? u->hi - u->lo : plan__travel(b, input->index);
        double time = b->when[input->index];
        time = plan__rounded(isfinite(time) ? time : 0.25 * c->until);
        if (!(fabs(way) > least_travel) || !(time > 0.0)) {
            continue;
        }
        way = plan__rounded(nearly_all * way);
        drive(l, input, "a motion as long as the mechanism's own", LAB_SHAPE_RISE, zero, way, time,
              1.0);
        drive(l, input, "a quick motion", LAB_SHAPE_RISE, zero, way, plan__rounded(quick * time),
              1.0 / quick);
        drive(l, input, "a slow motion", LAB_SHAPE_RISE, zero, way, plan__rounded(slow * time),
              1.0);
        drive(l, input, "half of the way, then back", LAB_SHAPE_BACK, zero,
              plan__rounded(half * way), time, 1.0);
        drive(l, input, "there and back, slowly", LAB_SHAPE_BACK, zero, way,
              plan__rounded(slow * time), 1.0);
    }
}

static void forces(list *l)
{
    const plan__reference *b = l->b;
    const stein_model *m = b->m;
    const lab_conditions *c = &b->d->conditions;
    for (int i = 0; i < m->ninput; i++) {
        const stein_input *input = &m->inputs[i];
        const lab_used *u = plan__used(c->input, c->ninput, input->name);
        char name[LAB_PLACE] = "";
        if (m->load.body >= 0) {
            snprintf(name, sizeof name, "%s.mass", m->bodies[m->load.body].name);
        }
        int mass = stein_find_param(m, name);
        double size = u != NULL ? fmax(fabs(u->lo), fabs(u->hi))
                      : mass >= 0 && input->kind == STEIN_INPUT_POINT ? 9.81 * b->p[mass]
                                                                      : 0.0;
        double time = plan__rounded(0.1 * c->until);
        if (input->kind == STEIN_INPUT_MOTION || !(size > 0.0) || !(time > 0.0)) {
            continue;
        }
        size = plan__rounded(size);
        drive(l, input, "a force that stays", LAB_SHAPE_RISE, 0.0, size, time, 1.0);
        drive(l, input, "half of the force", LAB_SHAPE_RISE, 0.0, plan__rounded(half * size), time,
              1.0);
        drive(l, input, "twice the force", LAB_SHAPE_RISE, 0.0, plan__rounded(hard * size), time,
              hard);
        drive(l, input, "a hard short push", LAB_SHAPE_BACK, 0.0, plan__rounded(hard * size), time,
              hard);
        drive(l, input, "a blow", LAB_SHAPE_BACK, 0.0, plan__rounded(very_hard * size),
              plan__rounded(quick * time), very_hard);
        drive(l, input, "a short push", LAB_SHAPE_BACK, 0.0, size, time, 1.0);
        drive(l, input, "a long push, half as strong", LAB_SHAPE_BACK, 0.0,
              plan__rounded(half * size), plan__rounded(slow * time), 1.0);
    }
}

/* is an effect on trial part of that thing? */
static int concerns(const plan__model *side, int nside, const char *thing)
{
    size_t n = strlen(thing);
    for (int i = 0; i < nside; i++) {
        for (int c = 0; c < side[i].n; c++) {
            const char *place = side[i].candidate[c].place;
            if (strncmp(place, thing, n) == 0 && (place[n] == '\0' || place[n] == '.')) {
                return 1;
            }
        }
    }
    return 0;
}

/* a part that a side supposes on a body, and that comes off */
typedef struct part {
    const lab_candidate *of;
    const char *amount, *unit; /* 0 then */
} part;

enum { PARTS = (1 + LAB_PLAN_RIVALS) * FIT__ACCEPTED };

/* the part of candidate c of a side; amount NULL: it is none */
static part comes_off(const plan__model *side, int which)
{
    const lab_candidate *c = &side->candidate[which];
    const stein_model *m = lab_equations(side->model);
    const char *unit, *amount = c->nparam > 0 ? m->params[c->param[0]].name : "";
    unit = lab__comes_off(m, amount);
    return (part){c, unit != NULL ? amount : NULL, unit};
}

/* A part that some sides assume on a body is taken off, or found to be absent: the stroke is
 * then the same again. */
static void take_off(list *l, const part *which, int n)
{
    lab_experiment *e =
        add(l, "nothing of that kind may touch it; what is there is taken off", "%s", "");
    for (int i = 0; e != NULL && i < n; i++) {
        const lab_candidate *c = which[i].of;
        char name[LAB_PLAN_TEXT];
        snprintf(name, sizeof name, "%s without %s: %s = 0", c->place, c->effect->kind,
                 which[i].amount);
        append(e->name, i > 0 ? ", " : "", name);
        if (!plan__set(e, which[i].amount, which[i].unit, 0.0)) {
            l->n--; // it would be there still
            return;
        }
    }
}

/* every one that is supposed, and all of them: where a spring in the joint, a wire and a damper are
 * rivals, the rest without both is the spring */
static void without_part(list *l, const plan__model *side, int nside)
{
    part which[PARTS];
    int n = 0;
    for (int i = 0; i < nside; i++) {
        for (int c = 0; c < side[i].n; c++) {
            which[n] = comes_off(&side[i], c);
            int is_new = which[n].amount != NULL;
            for (int k = 0; is_new && k < n; k++) {
                is_new = strcmp(which[k].amount, which[n].amount) != 0;
            }
            if (is_new) {
                take_off(l, &which[n++], 1);
            }
        }
    }
    if (n > 1) {
        take_off(l, which, n);
    }
}

/* no force from the string, whatever the depth */
static void without_string(list *l, const plan__model *side, int nside)
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
    if (e != NULL) {
        e->beyond = a_part_less;
    }
    for (int i = 0; e != NULL && i < 3; i++) {
        char name[LAB_PLACE];
        snprintf(name, sizeof name, "%s.normal.%s", string, stiffness[i]);
        int k = stein_find_param(m, name);
        if (k >= 0 && m->params[k].value != 0.0) {
            plan__set(e, name, m->params[k].unit, 0.0);
        }
    }
}

static int is_moved_by(const lab_candidate *c, const stein_model *m, const char *name)
{
    int yes = 0;
    for (int k = 0; k < c->nparam; k++) {
        yes |= strcmp(m->params[c->param[k]].name, name) == 0;
    }
    return yes;
}

/* does an effect on trial move that parameter? */
static int moves(const plan__model *side, int nside, const char *name)
{
    int yes = 0;
    for (int i = 0; i < nside; i++) {
        for (int c = 0; c < side[i].n; c++) {
            yes |= is_moved_by(&side[i].candidate[c], lab_equations(side[i].model), name);
        }
    }
    return yes;
}

/* a body that may be heavier is weighed; no record is needed */
static void masses(list *l, const plan__model *side, int nside)
{
    const plan__reference *b = l->b;
    const stein_model *m = b->m;
    for (int j = 0; j < m->nq; j++) {
        char name[LAB_PLACE], text[2][DATA_SHOWN];
        snprintf(name, sizeof name, "%s.mass", m->bodies[j].name);
        int i = stein_find_param(m, name);
        if (i < 0 || j == m->load.body || !m->params[i].stated || !(b->p[i] > 0.0) ||
            fabs(plan__travel(b, j)) < least_travel || moves(side, nside, name)) {
            continue;
        }
        for (int much = 0; much < 2; much++) {
            double extra = plan__rounded((much ? much_mass : more_mass) * b->p[i]);
            double whole = plan__rounded(b->p[i] + extra);
            lab_experiment *e = add(l, "put on at its centre of mass; weigh both together",
                                    "%s with %s more: %s = %s", m->bodies[j].name,
                                    data__quantity(text[0], extra, "kg"), name,
                                    data__quantity(text[1], whole, "kg"));
            if (e != NULL && !plan__set(e, name, "kg", whole)) {
                l->n--;
            } else if (e != NULL) {
                e->beyond = whole / b->p[i];
            }
        }
    }
}

/* is there an instrument for that channel? */
static int is_there(const lab_plan_def *def, const char *channel)
{
    int there = def->instrument == NULL;
    for (int i = 0; !there && i < def->ninstrument; i++) {
        there = strcmp(def->instrument[i], channel) == 0;
    }
    return there;
}

static void instruments(list *l)
{
    const plan__reference *b = l->b;
    for (int i = 0; i < b->noutput; i++) {
        const plan__output *output = &b->output[i];
        char text[DATA_SHOWN], why[LAB_PLAN_TEXT];
        if (output->measured || !is_there(b->def, output->name)) {
            continue;
        }
        const char *unit = b->m->channels[stein_find_channel(b->m, output->name)].unit;
        snprintf(why, sizeof why, "one channel more; its noise is taken to be %s",
                 data__quantity(text, output->noise, unit));
        lab_experiment *e = add(l, why, "%s measured, too", output->name);
        if (e != NULL) {
            snprintf(e->channel, sizeof e->channel, "%s", output->name);
            e->noise = output->noise;
        }
    }
    lab_experiment *e = add(l, "with the same noise in every frame", "%s", fast_camera);
    if (e != NULL) {
        e->faster = FASTER;
    }
}

/* n checks, made together */
static void add_checks(list *l, const lab_check *check, int n)
{
    lab_experiment *e = add(l, "no record; what it shows is stated in every file", "%s", "");
    for (int i = 0; e != NULL && i < n; i++) {
        char name[LAB_PLAN_TEXT], why[LAB_PLAN_TEXT];
        plan__check_says(&check[i], name, why);
        append(e->name, i > 0 ? ", " : "", name);
        append(e->why, i > 0 ? ", " : ": ", why);
        e->check[e->ncheck++] = check[i];
    }
}

/* each one that a side needs, and all of them */
static void checks(list *l, const plan__model *side, int nside)
{
    lab_check check[LAB_PLAN_CHECKS];
    int n = plan__checks(check, l->b, side, nside);
    for (int i = 0; i < n; i++) {
        add_checks(l, &check[i], 1);
    }
    if (n > 1) {
        add_checks(l, check, n);
    }
}

/* ---- two at once ---- */

/* is that number another one in the experiment than in the base? */
static int sets(const lab_experiment *e, const lab_experiment *base, const char *name)
{
    const lab_planned_set *now = plan__set_of(e, name), *was = plan__set_of(base, name);
    return now != NULL && (was == NULL || now->value != was->value);
}

static int drives(const lab_experiment *e, const lab_experiment *base)
{
    return strcmp(e->input, base->input) != 0 || e->shape != base->shape || e->zero != base->zero ||
           e->size != base->size || e->time != base->time;
}

int plan__together(lab_experiment *to, const lab_experiment *a, const lab_experiment *b,
                   const lab_experiment *base)
{
    int changes = drives(b, base) || b->channel[0] != '\0' || b->faster > 1;
    *to = *a;
    if (a->ncheck > 0 || b->ncheck > 0) {
        return 0; // no strokes
    }
    for (int i = 0; i < b->nset; i++) {
        const lab_planned_set *s = &b->set[i];
        if (sets(b, base, s->name)) {
            if (sets(a, base, s->name) || !plan__set(to, s->name, s->unit, s->value)) {
                return 0;
            }
            changes = 1;
        }
    }
    if (drives(b, base)) {
        memcpy(to->input, b->input, sizeof to->input);
        to->shape = b->shape;
        to->zero = b->zero;
        to->size = b->size;
        to->time = b->time;
    }
    if (b->channel[0] != '\0') {
        memcpy(to->channel, b->channel, sizeof to->channel);
        to->noise = b->noise;
    }
    to->faster = b->faster > a->faster ? b->faster : a->faster;
    to->beyond = a->beyond * b->beyond;
    to->all = 0; // it has not been judged
    append(to->name, ", ", b->name);
    append(to->why, "; ", b->why);
    return changes && !(drives(a, base) && drives(b, base)) &&
           !(a->channel[0] != '\0' && b->channel[0] != '\0') && !(a->faster > 1 && b->faster > 1);
}

stein_status plan__experiments(const plan__reference *b, const plan__model *side, int nside,
                               lab_experiment **out, int *n, stein_err *err)
{
    const lab_conditions *c = &b->d->conditions;
    list l = {.b = b};
    add(&l, b->base.why, "%s", b->base.name);
    checks(&l, side, nside);
    instruments(&l); // first: those with the base's own motion
    for (int i = 0; i < c->nsetting; i++) {
        if (!is_rest(b, &c->setting[i])) {
            vary(&l, &c->setting[i]);
        }
    }
    corners(&l);
    vary_others(&l);
    motions(&l);
    forces(&l);
    without_string(&l, side, nside);
    without_part(&l, side, nside);
    masses(&l, side, nside);
    if (l.nomem) {
        free(l.e);
        return lab__no_memory(err);
    }
    *out = l.e;
    *n = l.n;
    return STEIN_OK;
}
