/* SPDX-License-Identifier: MIT
 * slots.c - the numbers of a mechanism: declaring them, overriding them, working them out.
 *
 * A slot becomes a structural zero, a parameter or a formula. Plain numbers come first, in the
 * order of their declaration in the sections, so that the numbering of parameters follows the file
 * and not the references in formulas. Formulas follow, each after those it refers to.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static mech__slot *find_slot(const mech__reader *rd, const char *path)
{
    mech__slot *s = rd->slots;
    size_t length = strlen(path);

    while (s && (s->length != length || memcmp(s->path, path, length) != 0)) {
        s = s->next;
    }
    return s;
}

static const mech_set *find_set(mech__reader *rd, const char *path)
{
    const mech_set *found = NULL;

    for (int i = 0; i < rd->nset; i++) {
        if (strcmp(rd->set[i].name, path) == 0) {
            found = &rd->set[i];
            rd->set_used[i] = 1;
        }
    }
    return found;
}

void mech__problem_slot(mech__reader *rd, const mech__slot *slot, int from_set, size_t skip,
                        const char *format, ...)
{
    char what[400];
    va_list args;

    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (from_set) {
        mech__problem_at(rd, NULL, "set %s = \"%s\": %s", slot->path,
                         mech__shown(rd, slot->set->value), what);
    } else if (slot->text && !slot->label) {
        mech__problem_in(rd, slot->node, skip, "%s = \"%s\": %s", slot->path,
                         mech__shown(rd, slot->text), what);
    } else {
        mech__problem_at(rd, slot->node, "%s: %s", slot->path, what);
    }
}

/** Two numbers of one name: the place of the declared one is the one to change. */
static void problem_twice(mech__reader *rd, const mech__slot *old, const mech__node *node)
{
    if (old->flags & MECH__DECLARED) {
        mech__problem_at(rd, old->named,
                         "the parameter \"%s\" has the name of another number "
                         "of the file, expected another name",
                         old->path);
    } else {
        mech__problem_at(rd, node ? node : old->node,
                         "two numbers of the file are called \"%s\", "
                         "expected different names",
                         old->path);
    }
}

static mech__slot *new_slot(mech__reader *rd, const char *path, const mech__node *node)
{
    mech__slot *old = find_slot(rd, path);

    if (old) {
        problem_twice(rd, old, node);
        return NULL;
    }
    mech__slot *s = mech__alloc(rd, sizeof *s);

    if (!s) {
        return NULL;
    }
    mech__name_copy(s->path, sizeof s->path, path);
    s->length = strlen(s->path);
    s->node = node;
    s->set = find_set(rd, path);
    if (rd->last_slot) {
        rd->last_slot->next = s;
    } else {
        rd->slots = s;
    }
    rd->last_slot = s;
    rd->nslot++;
    return s;
}

mech__slot *mech__number(mech__reader *rd, mech_scalar *to, const char *unit, unsigned flags,
                         const mech__node *node, double fallback, const char *format, ...)
{
    char path[MECH_PATH];
    va_list args;

    va_start(args, format);
    vsnprintf(path, sizeof path, format, args);
    va_end(args);
    mech__slot *s = new_slot(rd, path, node);

    if (!s) {
        return NULL;
    }
    s->to = to;
    s->unit = unit;
    s->flags = flags;
    s->fallback = fallback;
    mech_parse_unit(unit, &s->dim, NULL);
    if (node && node->kind == MECH__SCALAR) {
        s->text = node->text;
    } else if (node) {
        mech__problem_at(rd, node, "%s must be a single number [%s], found a %s", path, unit,
                         node->kind == MECH__LIST ? "list" : "mapping");
        s->state = MECH__FAILED;
    }
    return s;
}

static void vector(mech__reader *rd, mech_scalar to[3], const char *unit, unsigned flags,
                   const mech__node *node, const char *base, const mech_scalar *less,
                   const mech_scalar *more)
{
    const mech__node *entry = NULL;

    if (node && (node->kind != MECH__LIST || node->count != 3)) {
        mech__problem_at(rd, node, "%s must be a list of three numbers [x, y, z]", base);
    } else if (node) {
        entry = node->first;
    }
    for (int i = 0; i < 3; i++) {
        unsigned f = i == 1 && (flags & MECH__PLANAR) ? flags | MECH__VANISHES : flags;

        mech__slot *s = mech__number(rd, &to[i], unit, f, entry, 0.0, "%s.%c", base, "xyz"[i]);

        if (s) {
            s->less = less ? &less[i] : NULL;
            s->more = more ? &more[i] : NULL;
        }
        entry = entry ? entry->next : NULL;
    }
}

void mech__vector(mech__reader *rd, mech_scalar to[3], const char *unit, unsigned flags,
                  const mech__node *node, const char *base)
{
    vector(rd, to, unit, flags, node, base, NULL, NULL);
}

void mech__place(mech__reader *rd, int body, mech_scalar to[3], unsigned flags,
                 const mech__node *node, const char *base)
{
    const mech_body *b = body >= 0 ? &rd->m->bodies[body] : NULL;

    vector(rd, to, "m", flags, node, base, b && b->part ? b->at : NULL,
           b && b->type == MECH__FIXED ? b->at : NULL);
}

void mech__repeat(mech__reader *rd, mech_scalar *to, const mech_scalar *from)
{
    mech__copy *c = mech__alloc(rd, sizeof *c);

    if (!c) {
        return;
    }
    c->to = to;
    c->from = from;
    if (rd->last_copy) {
        rd->last_copy->next = c;
    } else {
        rd->copies = c;
    }
    rd->last_copy = c;
}

mech_scalar mech__formula(mech__reader *rd, const char *name, const char *text,
                          const mech_step *steps, int nsteps)
{
    mech_formula *f = &rd->m->formulas[rd->m->nformula];
    mech_scalar s = {MECH_ZERO, 0, 0.0};
    size_t k = 0;

    f->steps = mech__array(rd, nsteps, sizeof *f->steps);
    if (!f->steps) {
        return s;
    }
    memcpy(f->steps, steps, (size_t)nsteps * sizeof *steps);
    f->nsteps = nsteps;
    mech__name_copy(f->name, sizeof f->name, name);

    /* one blank for any run of blanks and line ends */
    for (; *text && k + 1 < sizeof f->text; text++) {
        int blank = *text == ' ' || *text == '\t' || *text == '\n';

        if (!blank || (k > 0 && f->text[k - 1] != ' ')) {
            f->text[k++] = (char)(blank ? ' ' : *text);
        }
    }
    s.kind = MECH_FORMULA;
    s.index = rd->m->nformula++;
    s.value = mech__evaluate(steps, nsteps, rd->values);
    return s;
}

void mech__constant(mech__reader *rd, mech_scalar *to, double value, const char *name,
                    const char *text)
{
    mech_step step = {MECH_OP_CONST, -1, value};

    if (!rd->nomem) {
        *to = mech__formula(rd, name, text, &step, 1);
    }
}

static stein_range range_of(const mech__slot *s)
{
    return s->flags & MECH__WEDGE          ? STEIN_WEDGE
           : s->flags & MECH__POSITIVE     ? STEIN_POSITIVE
           : s->flags & MECH__NOT_NEGATIVE ? STEIN_NOT_NEGATIVE
                                           : STEIN_ANY;
}

/** A plain parameter: the parameter has to be in the number's range.
 */
static void narrow(mech_param *p, stein_range range)
{
    p->range = range > p->range ? range : p->range;
}

/** The unit of "+82.3 g +- 1 %", a single number: "g". */
static void note_unit(mech_param *p, const char *text)
{
    char why[MECH__WHY];
    const char *bad;
    mech__quantity q;
    size_t start = strspn(text, " \t+-"), n = start + strspn(text + start, "0123456789.");
    int used = mech__quantity_at(text + start, &q, why, &bad);

    if ((text[n] | 0x20) == 'e' && strcspn(text + n, "0123456789") <= 2) {
        n += 1 + strspn(text + n + 1, "+-0123456789");
    }
    n += strspn(text + n, " \t");
    if (used > 0 && q.has_unit && start + (size_t)used > n &&
        start + (size_t)used - n < sizeof p->written) {
        memcpy(p->written, text + n, start + (size_t)used - n);
    }
}

static mech_scalar add_param(mech__reader *rd, const mech__slot *s, double value, double tolerance)
{
    mech_param *p = &rd->m->params[rd->m->nparam];
    mech_scalar to = {MECH_PARAM, rd->m->nparam, value};

    mech__name_copy(p->name, sizeof p->name, s->path);
    if (s->unit) {
        mech__name_copy(p->unit, sizeof p->unit, s->unit);
    } else {
        mech__unit_text(s->dim, p->unit);
    }
    if (s->text && !s->label) {
        note_unit(p, s->text);
    }
    p->dim = s->dim;
    p->value = value;
    p->tolerance = tolerance;
    p->declared = (s->flags & MECH__DECLARED) != 0;
    p->stated = s->node != NULL || s->set != NULL || (s->flags & MECH__VANISHES) != 0;
    p->unused = (s->flags & MECH__UNUSED) != 0;
    p->range = range_of(s);
    p->line = s->node ? s->node->line : 0;
    p->column = s->node ? s->node->column : 0;
    rd->values[rd->m->nparam++] = value;
    return to;
}

/** Is the expression in the unit asked for? A single bare number is SI; a formula carries units. */
static int check_dim(mech__reader *rd, const mech__slot *s, const mech__expr *e, int from_set)
{
    char found[MECH_UNIT], expected[MECH_UNIT];
    int fits = mech__dim_same(e->dim, s->dim);

    if (e->literal && !e->bare) {
        fits = mech__dim_fits(e->dim, s->dim) && !(e->percent && s->dim.rad != 0);
    }
    if (e->wild || (e->literal && e->bare) || fits) {
        return 0;
    }
    mech__unit_text(e->dim, found);
    mech__unit_text(s->dim, expected);
    if (e->percent || strcmp(found, "1") == 0) {
        mech__name_copy(found, sizeof found, e->percent ? "%" : "missing");
    }
    const char *unit = s->unit ? s->unit : expected;

    mech__problem_slot(rd, s, from_set, 0, "the unit is %s, expected %s", found,
                       strcmp(unit, "1") == 0 ? "a pure number" : unit);
    return -1;
}

static int check_range(mech__reader *rd, const mech__slot *s, double value)
{
    const char *what = NULL;

    if (!isfinite(value)) {
        what = "the value is not finite";
    } else if ((s->flags & MECH__POSITIVE) && !(value > 0.0)) {
        what = "must be greater than zero";
    } else if ((s->flags & MECH__NOT_NEGATIVE) && value < 0.0) {
        what = "must not be negative";
    } else if ((s->flags & MECH__WEDGE) && !(value > 0.0 && value < 3.14159265358979323846)) {
        what = "must lie between 0 and 180 deg";
    }
    if (what && (s->node || s->set)) {
        mech__problem_slot(rd, s, s->set != NULL, 0, "%s", what);
    }
    return what ? -1 : 0;
}

/** An override of a formula would be ambiguous: name the parameters of the formula instead. */
static void problem_formula_set(mech__reader *rd, const mech__slot *s, const mech__expr *e)
{
    const char *names = "", *sep = "";

    for (int i = 0; i < e->nsteps; i++) {
        int param = e->steps[i].param, before = 0;

        for (int k = 0; k < i; k++) {
            before = before || e->steps[k].param == param;
        }
        if (e->steps[i].op == MECH_OP_PARAM && !before) {
            const char *more = mech__print(rd, "%s%s\"%s\"", names, sep, rd->m->params[param].name);

            names = more ? more : "";
            sep = ", ";
        }
    }
    mech__problem_slot(rd, s, 1, 0, "it is given by the formula %s, set instead %s",
                       s->label ? s->label : mech__shown(rd, s->text),
                       names[0] ? names : "a number in the file");
}

static int take_value(mech__reader *rd, mech__slot *s, const mech__expr *e, int from_set)
{
    double value = mech__evaluate(e->steps, e->nsteps, rd->values);

    if (check_range(rd, s, value) != 0) {
        return -1;
    }
    if (e->refs && !from_set) {
        int alone = e->nsteps == 1 && e->steps[0].op == MECH_OP_PARAM;

        if (alone) {
            s->value = (mech_scalar){MECH_PARAM, e->steps[0].param, value};
            narrow(&rd->m->params[e->steps[0].param], range_of(s));
        } else if (e->nsteps == 1 && (s->flags & MECH__VANISHES) && value == 0.0) {
            s->value = (mech_scalar){MECH_ZERO, 0, 0.0};
        } else {
            s->value =
                mech__formula(rd, s->path, s->label ? s->label : s->text, e->steps, e->nsteps);
        }
    } else if ((s->flags & MECH__VANISHES) && value == 0.0) {
        s->value = (mech_scalar){MECH_ZERO, 0, 0.0};
    } else {
        s->value = add_param(rd, s, value, e->tolerance);
    }
    return 0;
}

/** Text of the file and override together. */
static int work_out(mech__reader *rd, mech__slot *s)
{
    mech_step fixed = {MECH_OP_CONST, -1, s->fallback};
    mech__expr e = {.steps = &fixed, .nsteps = 1, .literal = 1, .bare = 1}, over;

    if (s->text && mech__expression(rd, s, s->text, 0, &e) != 0) {
        return -1;
    }
    if (s->flags & MECH__DECLARED) {
        if (e.refs) {
            mech__problem_slot(rd, s, 0, 0, "a parameter must be a number, not a formula");
            return -1;
        }
        s->dim = e.dim;
    } else if (check_dim(rd, s, &e, 0) != 0) {
        return -1;
    }
    if (s->set) {
        if (e.refs) {
            problem_formula_set(rd, s, &e);
            return -1;
        }
        if (mech__expression(rd, s, s->set->value, 1, &over) != 0 ||
            check_dim(rd, s, &over, 1) != 0) {
            return -1;
        }
        over.tolerance = over.tolerance > 0.0 ? over.tolerance : e.tolerance;
        return take_value(rd, s, &over, 1);
    }
    return take_value(rd, s, &e, 0);
}

static void resolve(mech__reader *rd, mech__slot *s)
{
    if (s->state != MECH__NEW) {
        return;
    }
    s->state = MECH__BUSY;
    rd->depth++;
    if (rd->depth > MECH__MAX_DEPTH) {
        mech__problem_slot(rd, s, 0, 0, "formulas refer to each other too deeply");
        s->state = MECH__FAILED;
    } else {
        s->state = work_out(rd, s) == 0 ? MECH__DONE : MECH__FAILED;
    }
    rd->depth--;
    if (s->to) {
        *s->to = s->value;
    }
}

int mech__reference(mech__reader *rd, const char *path, mech__expr *out)
{
    mech__slot *s = find_slot(rd, path);

    if (!s) {
        return -1;
    }
    if (s->state == MECH__BUSY) {
        return -3;
    }
    resolve(rd, s);
    out->steps = mech__alloc(rd, sizeof *out->steps);
    if (s->state == MECH__FAILED || !out->steps) {
        return -2;
    }
    out->nsteps = 1;
    out->dim = s->dim;
    if (s->value.kind == MECH_FORMULA) {
        out->steps = rd->m->formulas[s->value.index].steps;
        out->nsteps = rd->m->formulas[s->value.index].nsteps;
    } else if (s->value.kind == MECH_PARAM) {
        out->steps[0] = (mech_step){MECH_OP_PARAM, s->value.index, 0.0};
    } else {
        out->steps[0] = (mech_step){MECH_OP_CONST, -1, 0.0};
    }
    return 0;
}

int mech__failed(const mech__reader *rd, const char *owner)
{
    size_t n = strlen(owner);

    for (const mech__slot *s = rd->slots; s; s = s->next) {
        if (s->state == MECH__FAILED && strncmp(s->path, owner, n) == 0 && s->path[n] == '.') {
            return 1;
        }
    }
    return 0;
}

void mech__offer_paths(mech__reader *rd, mech__nearest *n)
{
    for (const mech__slot *s = rd->nproblem < MECH__MAX_PROBLEMS ? rd->slots : NULL; s;
         s = s->next) {
        mech__offer(n, s->path);
    }
}

/** A text that refers to other numbers: a word with a dot in it that is no number. */
static int has_reference(const char *s)
{
    while (*s) {
        size_t n = strcspn(s, " \t\n()*/+-^%,");
        int letter = (*s >= 'a' && *s <= 'z') || (*s >= 'A' && *s <= 'Z');

        if (letter && memchr(s, '.', n)) {
            return 1;
        }
        s += n + (s[n] != '\0');
    }
    return 0;
}

static void check_sets(mech__reader *rd)
{
    for (int i = 0; i < rd->nset; i++) {
        if (!rd->set_used[i]) {
            mech__nearest near = {rd->set[i].name, NULL, 0};

            mech__offer_paths(rd, &near);
            mech__problem_at(rd, NULL, "set %s = \"%s\": there is no number of that name%s",
                             mech__shown(rd, rd->set[i].name), mech__shown(rd, rd->set[i].value),
                             mech__hint(rd, &near, ""));
        }
    }
}

void mech__repeat_all(mech__reader *rd)
{
    for (const mech__copy *c = rd->copies; c; c = c->next) {
        *c->to = *c->from;
    }
}

void mech__resolve(mech__reader *rd)
{
    mechanism *m = rd->m;

    rd->values = mech__alloc(rd, sizeof *rd->values * (size_t)(rd->nslot + 1));
    m->params = mech__array(rd, rd->nslot, sizeof *m->params);
    m->formulas =
        mech__array(rd, 2 * rd->nslot + MECH__PART_FORMULAS * m->nbody + 1, sizeof *m->formulas);
    for (mech__slot *s = rd->slots; s && !rd->nomem; s = s->next) {
        if (!s->text || !has_reference(s->text)) {
            resolve(rd, s);
        }
    }
    for (mech__slot *s = rd->slots; s && !rd->nomem; s = s->next) {
        resolve(rd, s);
    }
    mech__balance(rd);
    mech__repeat_all(rd);
    mech__parts(rd);
    mech__repeat_all(rd);
    if (!rd->nomem) {
        mech__fixed(rd);
        check_sets(rd);
    }
}

/** One entry of `parameters`: "VALUE UNIT" or {value: VALUE UNIT, about: text}. */
static void declare(mech__reader *rd, const mech__node *entry)
{
    const char *name = entry->key->text;
    const mech__node *value = entry;
    const char *part = name;
    int parts = 0, good = strlen(name) < MECH_PATH;

    while (good && part) {
        const char *dot = strchr(part, '.');
        mech__node piece = *entry->key;
        char text[MECH_PATH];

        mech__name_copy(text, dot ? (size_t)(dot - part) + 1 : sizeof text, part);
        piece.text = text;
        good = mech__name_check(rd, &piece, "a part of a parameter's name");
        part = dot ? dot + 1 : NULL;
        parts++;
    }
    if (strlen(name) >= MECH_PATH || (good && parts < 2)) {
        mech__problem_at(rd, entry->key, "\"%s\" cannot name a parameter, expected owner.name",
                         mech__shown(rd, name));
        return;
    }
    if (entry->kind == MECH__MAP) {
        mech__keys(rd, entry, "a parameter", "value");
        value = mech__need(rd, entry, "value", "a parameter");
    }
    if (!good || !value) {
        return;
    }
    if (value->kind != MECH__SCALAR) {
        mech__problem_at(rd, value, "%s must be a single number with its unit", name);
        return;
    }
    mech__slot *s = new_slot(rd, name, value);

    if (s) {
        s->flags = MECH__DECLARED;
        s->named = entry->key;
        s->text = value->text;
    }
}

void mech__section_parameters(mech__reader *rd)
{
    const mech__node *section = mech__get(rd->root, "parameters");

    if (section && section->kind != MECH__MAP) {
        mech__problem_at(rd, section, "expected a mapping from names (owner.name) to numbers");
        return;
    }
    for (const mech__node *n = section ? section->first : NULL; n && !rd->nomem; n = n->next) {
        declare(rd, n);
    }
}
