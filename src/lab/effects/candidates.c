/* SPDX-License-Identifier: GPL-3.0-or-later
 * candidates.c - every effect of the table at every place of a mechanism where it can sit.
 * Its largest plausible size there is in limits.c.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"

enum { MAX_SAMPLES = 4000 };
static const double weak_range = 1e-4; /* of adhesion [m] */
static const double arm = 0.1;         /* speed of a slide over the speed of a lever [m] */
static const double pressed = 1e-4;    /* depth at which a contact has its typical stiffness [m] */

typedef struct build {
    const lab_model *lab;
    const stein_model *m;
    const double *p, *now;       /* of the file; with further forces, NULL: whatever it is */
    const lab__strokes *strokes; /* NULL: one with the file's own numbers */
    lab_candidate *list;
    int n, room;
    lab__scales s;
    int full;                  /* memory ran out */
    const lab_effect *unsized; /* it has no entry in limits.c; NULL: it has all entries */
} build;

/* ---- one run ---- */

typedef struct watch {
    const stein_model *m;
    lab__scales *s;
    double *low, *high;
} watch;

static stein_status look(void *ctx, stein_sim *sim)
{
    watch *w = ctx;
    const double *q = stein_q(sim), *qd = stein_qd(sim);
    for (int j = 0; j < w->m->nq; j++) {
        w->s->travel[j] = fmax(w->s->travel[j], fabs(q[j]));
        w->s->speed[j] = fmax(w->s->speed[j], fabs(qd[j]));
    }
    for (int c = 0; c < w->m->nchannel; c++) {
        double y = stein_read(sim, c);
        w->low[c] = fmin(w->low[c], y);
        w->high[c] = fmax(w->high[c], y);
    }
    return STEIN_OK;
}

static double named(const build *b, const char *owner, const char *path, double other)
{
    char name[2 * LAB_PLACE];
    snprintf(name, sizeof name, "%.99s.%.90s", owner, path);
    int i = stein_find_param(b->m, name);
    return i >= 0 ? b->p[i] : other;
}

/* also of bodies with a formula for the mass: a part, and the rest of the whole */
static double carried(const build *b, int joint)
{
    const mechanism *mech = lab__mechanism(b->lab);
    double mass = 0.0;
    for (int k = joint; k < b->m->nq; k++) {
        int up = k;
        while (up > joint) {
            up = b->m->bodies[up].parent;
        }
        mass += up == joint ? mech->bodies[k].mass.value : 0.0;
    }
    return mass;
}

static void derive(build *b, stein_sim *sim, double *M)
{
    const double g = 9.81;
    int nq = b->m->nq;
    lab__scales *s = &b->s;
    stein_mass_bias(sim, stein_q(sim), stein_qd(sim), NULL, NULL, M, M + (size_t)nq * (size_t)nq);
    for (int j = 0; j < nq; j++) {
        const char *name = b->m->bodies[j].name;
        double m = fmax(carried(b, j), 1e-12), Mjj = fmax(M[j * nq + j], 1e-18);
        s->inertia[j] = Mjj;
        s->length[j] = sqrt(Mjj / m);
        s->spring[j] = fabs(named(b, name, "spring.k", 0.0) * named(b, name, "spring.theta0", 0.0));
        s->weight[j] = fmax(s->length[j] * m * g, s->spring[j]);
        s->heaviness += b->m->bodies[j].parent < 0 ? m * g : 0.0;
    }
}

/* all 0 but two ranges and a matrix behind them */
static int make_scales(build *b)
{
    int nq = b->m->nq, nc = b->m->nchannel;
    size_t n = (size_t)nq, size = 9 * n + 3 * (size_t)nc + n * n + 1;
    lab__scales *s = &b->s;
    s->room = calloc(size, sizeof *s->room);
    if (s->room == NULL) {
        return -1;
    }
    s->weight = s->room, s->spring = s->weight + nq, s->energy = s->spring + nq;
    s->speed = s->energy + nq, s->travel = s->speed + nq, s->length = s->travel + nq;
    s->inertia = s->length + nq, s->range = s->inertia + nq;
    return 0;
}

static stein_status measure(build *b, stein_err *err)
{
    int nq = b->m->nq, nc = b->m->nchannel;
    stein_sim *sim = NULL;
    lab__scales *s = &b->s;
    double *low = s->range + nc, *high = low + nc, *M = high + nc;
    for (int c = 0; c < nc; c++) {
        low[c] = INFINITY, high[c] = -INFINITY;
    }
    stein_status status = lab_sim(b->lab, NULL, &sim, err);
    if (status == STEIN_OK) {
        derive(b, sim, M);
        watch w = {b->m, s, low, high};
        lab_stroke_def def = lab_stroke_def_default(b->m);
        def.every = def.until / MAX_SAMPLES;
        def.sample = look;
        def.ctx = &w;
        status = b->strokes != NULL ? b->strokes->run(b->strokes->ctx, look, &w, err)
                                    : lab_simulate(sim, &def, err);
    }
    for (int j = 0; status == STEIN_OK && j < nq; j++) {
        double M_jj = s->weight[j] / 9.81 * s->length[j];
        s->travel[j] = s->travel[j] > 1e-4 ? s->travel[j] : 0.1;
        s->speed[j] = s->speed[j] > 1e-3 ? s->speed[j] : sqrt(s->weight[j] / M_jj);
        s->energy[j] =
            fmax(s->weight[j], M[j * nq + j] * s->speed[j] * s->speed[j] / (2.0 * s->travel[j]));
    }
    for (int c = 0; c < nc; c++) {
        s->range[c] = high[c] - low[c] > 1e-9 ? high[c] - low[c] : 1.0; // it may just stand still
    }
    stein_sim_destroy(sim);
    return status;
}

/* ---- the list ---- */

static lab_candidate *add(build *b, const lab_effect *e, const char *place, int param)
{
    if (b->n == b->room) {
        int room = 2 * b->room + 64;
        lab_candidate *more = realloc(b->list, sizeof *more * (size_t)room);
        if (more == NULL) {
            b->full = 1;
            return NULL;
        }
        b->list = more;
        b->room = room;
    }
    lab_candidate *c = &b->list[b->n++];
    *c = (lab_candidate){.effect = e,
                         .nparam = 1,
                         .param = {param},
                         .joint = -1,
                         .channel = -1,
                         .unit = param >= 0 ? b->m->params[param].unit : "1",
                         .start = 0.05};
    for (int k = 0; k < LAB_SIDES; k++) {
        c->side[k].param = -1;
    }
    snprintf(c->place, sizeof c->place, "%s", place);
    return c;
}

static int find(const build *b, const char *place, const char *path)
{
    char name[2 * LAB_PLACE];
    snprintf(name, sizeof name, "%s.%s", place, path);
    return stein_find_param(b->m, name);
}

/* does its place not use the parameter, whatever its value? */
static int is_unused(const build *b, int param)
{
    const mechanism *m = lab__mechanism(b->lab);
    int k = mech_find_param(m, b->m->params[param].name, NULL);
    return k >= 0 && m->params[k].unused;
}

static lab_candidate *add_at(build *b, const lab_effect *e, const char *place)
{
    int param = find(b, place, e->parameter);
    int idle = b->now != NULL && lab__is_share_of_nothing(b->m, e, place, b->now);
    return param >= 0 && !idle && !is_unused(b, param) ? add(b, e, place, param) : NULL;
}

static void set_limit(build *b, lab_candidate *c, double limit)
{
    c->limit = limit;
    b->unsized = isnan(limit) ? c->effect : b->unsized;
}

/* the number beside the amount: a range and a start value */
static void add_side(build *b, lab_candidate *c, double lo, double value, double hi)
{
    int param = find(b, c->place, c->effect->side);
    if (param >= 0) {
        const char *unit = b->m->params[param].unit;
        c->side[0] = (lab_side){c->effect->side, unit, param, value, lo, hi, lo > 0.0};
    }
}

/* speed at which Coulomb friction has its full size; a stated one is accepted to a factor of two */
static void joint_speed(build *b, lab_candidate *c, double unit)
{
    add_side(b, c, 0.002 * unit, 0.015 * unit, 0.1 * unit);
    lab_side *side = &c->side[0];
    if (side->param >= 0 && b->m->params[side->param].stated) {
        double w = b->p[side->param];
        side->lo = 0.5 * w, side->value = w, side->hi = 2.0 * w;
    }
}

static void add_joint(build *b, const lab_effect *e, int j)
{
    const char *name = b->m->bodies[j].name;
    lab_candidate *c = add_at(b, e, name);
    if (c == NULL) {
        return;
    }
    c->joint = j;
    set_limit(b, c, lab__joint_limit(e->kind, &b->s, j));
    c->number = fabs(b->m->params[c->param[0]].value);
    c->start *= strcmp(e->kind, "quadratic_drag") == 0     ? 0.1
                : strcmp(e->kind, "viscous_friction") == 0 ? 0.3
                                                           : 1.0;
    if (strcmp(e->kind, "joint_stiffness") == 0) {
        const char *neutral = b->m->bodies[j].type == 'T' ? "spring.x0" : "spring.theta0";
        c->param[1] = find(b, name, neutral);
        c->nparam = c->param[1] >= 0 ? 2 : 1;
        c->move = LAB_MOVE_SPRING;
    }
    if (strcmp(e->kind, "backlash") == 0) {
        double Q = b->s.travel[j];
        add_side(b, c, 0.2 * Q, 0.4 * Q, 0.6 * Q);
    } else if (strcmp(e->kind, "coulomb_friction") == 0) {
        joint_speed(b, c, b->m->bodies[j].type == 'T' ? arm : 1.0);
    } else if (strcmp(e->kind, "stiction_peak") == 0) {
        add_side(b, c, 1e-4, 1e-2, 1.0);
    }
}

/* The coordinate of the centre along which the body extends: x, unless another one is ten times as
 * long, as for a hanging rod. */
static int along_body(const build *b, const char *name)
{
    static const double much = 10.0;
    static const char *const other[] = {"centre.y", "centre.z"};
    int best = find(b, name, "centre.x");
    double length = best >= 0 ? much * fabs(b->p[best]) : 0.0;
    for (int i = 0; i < 2; i++) {
        int param = find(b, name, other[i]);
        if (param >= 0 && fabs(b->p[param]) > length) {
            best = param;
            length = fabs(b->p[param]);
        }
    }
    return best;
}

static void add_body(build *b, const lab_effect *e, int j)
{
    static const char *const other[] = {"inertia.xx", "inertia.zz"};
    const char *name = b->m->bodies[j].name;
    int is_inertia = strcmp(e->kind, "inertia") == 0, is_centre = strcmp(e->kind, "centre") == 0;
    int centre = is_centre ? along_body(b, name) : -1;
    lab_candidate *c = centre >= 0 ? add(b, e, name, centre)
                       : is_centre ? NULL
                                   : add_at(b, e, name);
    for (int i = 0; c == NULL && is_inertia && i < 2; i++) {
        int param = find(b, name, other[i]);
        c = param >= 0 ? add(b, e, name, param) : NULL;
    }
    if (c == NULL) {
        return;
    }
    c->joint = j;
    c->number = fabs(b->m->params[c->param[0]].value);
    set_limit(b, c, lab__body_limit(e->kind, &b->s, j, b->p[c->param[0]]));
}

static void scale_contact(build *b, lab_candidate *c)
{
    static const char *const path[] = {"normal.a", "normal.b", "normal.c"};
    c->move = LAB_MOVE_SCALE;
    c->nparam = 0;
    for (int i = 0; i < 3; i++) {
        int param = find(b, c->place, path[i]);
        if (param >= 0 && b->p[param] != 0.0) {
            c->param[c->nparam++] = param;
        }
    }
    c->unit = "1";
}

static void add_contact(build *b, const lab_effect *e, const char *place)
{
    const char *kind = e->kind;
    lab_candidate *c = add_at(b, e, place);
    if (c == NULL) {
        return;
    }
    double value = b->p[c->param[0]];
    set_limit(b, c, lab__contact_limit(kind, &b->s, value));
    if (strcmp(kind, "contact_stiffness") == 0) {
        scale_contact(b, c);
    } else if (strcmp(kind, "contact_damping") == 0 || strcmp(kind, "contact_friction") == 0) {
        c->move = value > 0.0 ? LAB_MOVE_SCALE : LAB_MOVE_ADD;
        c->unit = value > 0.0 ? "1" : c->unit;
    }
    if (e->side != NULL) {
        int side = find(b, place, e->side);
        double range = side >= 0 && b->p[side] > 0.0 ? b->p[side] : weak_range;
        add_side(b, c, 0.3 * range, range, 2.0 * range);
    }
}

static int is_marker(stein_read_kind read)
{
    return (read >= STEIN_READ_X && read <= STEIN_READ_Z) || read == STEIN_READ_GAP;
}

static void add_channel(build *b, const lab_effect *e, int channel)
{
    const stein_channel *ch = &b->m->channels[channel];
    if (ch->read == STEIN_READ_TIME || ch->read == STEIN_READ_NOTCH_PHASE ||
        (e->site == LAB_AT_MARKER && !is_marker(ch->read))) {
        return;
    }
    lab_candidate *c = add_at(b, e, ch->name);
    if (c == NULL) {
        return;
    }
    c->channel = channel;
    set_limit(b, c, lab__channel_limit(e->kind, &b->s, channel));
    c->start = 0.1;
}

/* stated, moved by no other candidate, and no regulation, gravity or initial state */
static int is_plain(const build *b, int param)
{
    const stein_param *q = &b->m->params[param];
    static const char *const not [] = {"gravity.", "load.mass", "clock.", NULL};
    static const char *const inside[] = {".initial.", ".sensor.", ".vt",     ".coulomb.w",
                                         ".B2",       ".facing",  ".extent", ".direction.",
                                         ".let_off.", NULL};
    for (int i = 0; not [i] != NULL; i++) {
        if (strncmp(q->name, not [i], strlen(not [i])) == 0) {
            return 0;
        }
    }
    for (int i = 0; inside[i] != NULL; i++) {
        if (strstr(q->name, inside[i]) != NULL) {
            return 0;
        }
    }
    for (int i = 0; i < b->n; i++) {
        const lab_candidate *c = &b->list[i];
        if (c->param[0] == param && c->nparam == 1) {
            return 0;
        }
    }
    return q->stated && !is_unused(b, param) && !lab__is_in_table(b->m, q->name) &&
           (b->p[param] != 0.0 || q->tolerance > 0.0);
}

static void add_parameters(build *b, const lab_effect *e)
{
    int before = b->n;
    for (int i = 0; i < b->m->np; i++) {
        int n = b->n;
        b->n = before; // only against the other kinds
        int plain = is_plain(b, i);
        b->n = n;
        lab_candidate *c = plain ? add(b, e, b->m->params[i].name, i) : NULL;
        if (c != NULL) {
            const stein_param *q = &b->m->params[i];
            int place = strcmp(q->unit, "m") == 0, angle = strcmp(q->unit, "rad") == 0;
            c->number = fabs(q->value);
            c->limit = place ? 2e-3 : angle ? 0.1 : 0.5 * fabs(b->p[i]);
        }
    }
}

static void add_inputs(build *b, const lab_effect *e)
{
    for (int i = 0; i < b->m->ninput; i++) {
        lab_candidate *c = add_at(b, e, b->m->inputs[i].name);
        if (c != NULL) {
            set_limit(b, c, lab__input_limit(e->kind));
        }
    }
}

static void add_load(build *b, const lab_effect *e)
{
    int param = b->m->load.body >= 0 ? find(b, b->m->bodies[b->m->load.body].name, "error") : -1;
    lab_candidate *c = param >= 0 ? add(b, e, "load", param) : NULL;
    if (c != NULL) {
        c->limit = 0.2;
    }
}

/* ---- parts that the mechanism has not ---- */

static double stiffness(const build *b, const char *contact)
{
    double c = named(b, contact, "normal.c", 0.0), bb = named(b, contact, "normal.b", 0.0);
    double k = c + pressed * (bb + pressed * named(b, contact, "normal.a", 0.0));
    return k > 0.0 ? k : 1e4;
}

/* ranges of the numbers beside the amount of a part. @return the limit of the amount */
static double size_part(const build *b, lab_candidate *c, const lab__site *site)
{
    const lab__scales *s = &b->s;
    const char *kind = c->effect->kind;
    int j = site->body;
    double E = s->energy[j], Q = s->travel[j], l = s->length[j], dip = Q * site->reach;
    lab_side *side = &c->side[0], *other = &c->side[1];
    lab__bent bent;
    if (strcmp(kind, "elastic_hinge") == 0 && lab__bend(&bent, lab__mechanism(b->lab), j) == 0) {
        lab__set_range(side, 0.02, 0.05, 0.1);
        lab__set_range(other, 0.25, LAB__BEND, 0.7);
        double ratio = bent.mass / (1.0 - bent.mass);
        lab__set_range(&c->side[2], ratio / 3.0, ratio, 3.0 * ratio);
        lab__set_range(&c->side[3], 0.125, 1.0, 8.0);
        return 0.02 * Q / E;
    }
    if (strcmp(kind, "armature") == 0) {
        const char *same = lab__same_as_armature(lab__mechanism(b->lab), j);
        c->unit = b->m->bodies[j].type == 'T' ? "kg" : "kg m^2";
        if (same != NULL) {
            snprintf(c->alias, sizeof c->alias, "%.90s.%s", c->place, same);
        }
        return s->inertia[j]; // gears are chosen so that rotor and load weigh alike
    }
    if (strcmp(kind, "axis_translation") == 0) {
        lab__set_range(side, 0.05, 0.1, 0.2);
        lab__set_range(other, 0.05, 1.0, 20.0);
        return 0.02 * Q * l * l / E;
    }
    if (strcmp(kind, "compliant_partner") == 0) {
        double mass = s->inertia[j] / fmax(site->reach * site->reach, l * l); // felt there
        lab__set_range(side, 0.08 * mass, 0.2 * mass, 0.45 * mass);
        lab__set_range(other, 0.02, 0.05, 0.1);
        return 0.33 / stiffness(b, site->place);
    }
    if (strcmp(kind, "string_damper") == 0) {
        lab__set_range(side, 0.15 * dip, 0.35 * dip, 0.6 * dip);
        lab__set_range(other, 0.36 / dip, 1.0 / dip, 2.9 / dip);
        return 0.6 * s->heaviness;
    }
    if (strcmp(kind, "wire") == 0) {
        lab__set_range(side, 0.0, 0.02, 0.05);
        lab__set_range(other, 0.17 * site->reach, 0.28 * site->reach, 0.45 * site->reach);
        return 0.25 * s->heaviness / dip;
    }
    return NAN;
}

static void add_parts(build *b, const lab_effect *e)
{
    lab__site site[LAB_SITES];
    const char *name[LAB_NUMBERS], *unit[LAB_NUMBERS];
    if (!lab__structure_of(e->kind, name, unit)) {
        return;
    }
    int n = lab__sites(lab__mechanism(b->lab), e->kind, site);
    for (int i = 0; i < n; i++) {
        lab_candidate *c = add(b, e, site[i].place, -1);
        if (c != NULL) {
            c->nparam = 0;
            c->move = LAB_MOVE_VALUE;
            c->unit = unit[0];
            for (int k = 0; k < LAB_SIDES; k++) {
                c->side[k].name = name[1 + k], c->side[k].unit = unit[1 + k];
            }
            c->joint = site[i].body;
            set_limit(b, c, size_part(b, c, &site[i]));
        }
    }
}

static void enumerate(build *b, const lab_effect *e)
{
    if (e->needs != NULL) {
        add_parts(b, e);
        return;
    }
    int surfaces = e->site == LAB_AT_SURFACE || e->site == LAB_AT_CONTACT;
    for (int j = 0; j < b->m->nq; j++) {
        if (j != b->m->load.body && e->site == LAB_AT_JOINT) {
            add_joint(b, e, j);
        } else if (j != b->m->load.body && e->site == LAB_AT_BODY) {
            add_body(b, e, j);
        }
    }
    for (int i = 0; surfaces && i < b->m->ncontact; i++) {
        add_contact(b, e, b->m->contacts[i].name);
    }
    for (int i = 0; surfaces && i < b->m->nnotch; i++) {
        add_contact(b, e, b->m->notches[i].name);
    }
    for (int i = 0; i < b->m->nchannel; i++) {
        if (e->site == LAB_AT_CHANNEL || e->site == LAB_AT_MARKER) {
            add_channel(b, e, i);
        }
    }
    for (int i = 0; e->site == LAB_AT_LINK && i < b->m->nlink; i++) {
        lab_candidate *at = add_at(b, e, b->m->links[i].name);
        if (at != NULL) {
            lab__size_link(at, b->m, b->p);
        }
    }
    int clock = stein_find_param(b->m, "clock.error");
    lab_candidate *c = NULL;
    switch (e->site) {
    case LAB_AT_LOAD: add_load(b, e); break;
    case LAB_AT_INPUT: add_inputs(b, e); break;
    case LAB_AT_PARAMETER: add_parameters(b, e); break;
    case LAB_AT_CLOCK:
        c = clock >= 0 ? add(b, e, "clock", clock) : NULL;
        if (c != NULL) {
            c->limit = 0.03;
        }
        break;
    default: break;
    }
}

stein_status lab__candidates_at(lab_candidate **list, int *n, const lab_model *model,
                                const double *p, const lab__strokes *strokes, stein_err *err)
{
    build b = {.lab = model,
               .m = lab_equations(model),
               .p = lab_parameters(model),
               .now = p,
               .strokes = strokes};
    int kinds;
    const lab_effect *effect = lab_effects(&kinds);
    if (make_scales(&b) != 0) {
        return lab__no_memory(err);
    }
    stein_status status = measure(&b, err);
    for (int i = 0; status == STEIN_OK && i < kinds; i++) {
        enumerate(&b, &effect[i]);
    }
    free(b.s.room);
    if (status == STEIN_OK && b.full) {
        status = lab__no_memory(err);
    } else if (status == STEIN_OK && b.unsized != NULL) {
        status = lab__fail(err, STEIN_EINVAL, "effect %s has no largest plausible size (limits.c)",
                           b.unsized->kind);
    }
    status = status == STEIN_OK ? lab__aliases(b.list, &b.n, model, err) : status;
    if (status != STEIN_OK) {
        free(b.list);
        return status;
    }
    lab__note_armatures(b.list, b.n, b.m);
    *list = b.list;
    *n = b.n;
    return STEIN_OK;
}

stein_status lab__bind_parameters(lab_candidate *c, const lab_model *model, stein_err *err)
{
    build b = {.lab = model, .m = lab_equations(model), .p = lab_parameters(model)};
    stein_status status = STEIN_OK;
    if (make_scales(&b) != 0) { // all 0: only the limits come from them
        return lab__no_memory(err);
    }
    if (c->effect->site == LAB_AT_PARAMETER || c->effect->site == LAB_AT_SETTING) {
        int param = stein_find_param(b.m, c->place);
        (void)(param >= 0 ? add(&b, c->effect, c->place, param) : NULL);
    } else {
        enumerate(&b, c->effect);
    }
    const lab_candidate *found = NULL;
    for (int i = 0; i < b.n; i++) {
        found = strcmp(b.list[i].place, c->place) == 0 ? &b.list[i] : found;
    }
    if (found == NULL) {
        status = b.full ? lab__no_memory(err)
                        : lab__fail(err, STEIN_ENAME, "%s has no place %s for %s", b.m->name,
                                    c->place, c->effect->kind);
    }
    if (found != NULL) {
        c->nparam = found->nparam;
        memcpy(c->param, found->param, sizeof c->param);
        for (int k = 0; k < LAB_SIDES; k++) {
            c->side[k].param = found->side[k].param;
        }
        c->joint = found->joint;
        c->channel = found->channel;
    }
    free(b.list);
    free(b.s.room);
    return status;
}
