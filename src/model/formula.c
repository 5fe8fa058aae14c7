/* SPDX-License-Identifier: MIT
 * formula.c - reads a number or formula with its dimension into postfix.
 *
 *   value = sum [ ("+-" | "±") number [unit | "%"] ]      the tolerance of a single number
 *   sum   = term { ("+" | "-") term }
 *   term  = sign { ("*" | "/") sign }
 *   sign  = { "+" | "-" } atom
 *   atom  = number [unit] | owner.name | function "(" sum ")" | "(" sum ")"
 *
 * Recursive descent, because it gives postfix in one pass, with the dimensions of all operands
 * known at each operator. A unit belongs to the number before it; names of other numbers hold a
 * dot, so the two cannot be confused. Formulas that are referred to are put in.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "functions.h"
#include "reader.h"

enum { MAX_POWER = 60 };

typedef struct operand {
    mech_dim dim;
    int wild, literal, bare, percent;
} operand;

typedef struct parser {
    mech__reader *rd;
    const char *at;
    mech_step *steps;
    int n, brackets, refs, refs_allowed;
    char why[MECH__WHY]; /* first problem; empty while all is well */
    int failed;          /* also set when another number's problem is the cause */
    const char *bad;     /* its place */
    const char *hint;
} parser;

static const struct {
    const char *name;
    mech_op op;
} functions[] = {
    {"sin", MECH_OP_SIN}, {"cos", MECH_OP_COS}, {"tan", MECH_OP_TAN}, {"sqrt", MECH_OP_SQRT}};

static operand sum(parser *p);

static void fail(parser *p, const char *at, const char *why)
{
    if (!p->failed) {
        p->failed = 1;
        p->bad = at;
        if (why != p->why) {
            snprintf(p->why, sizeof p->why, "%s", why);
        }
    }
}

static void skip(parser *p)
{
    while (*p->at == ' ' || *p->at == '\t' || *p->at == '\n') {
        p->at++;
    }
}

static void emit(parser *p, mech_op op, int param, double value)
{
    if (p->n == MECH__MAX_STEPS) {
        fail(p, p->at, "the formula is too long");
        return;
    }
    p->steps[p->n++] = (mech_step){op, param, value};
}

static int is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static int is_word(char c)
{
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
}

static int at_tolerance(const char *s)
{
    return (s[0] == '+' && s[1] == '-') ||
           ((unsigned char)s[0] == 0xC2 && (unsigned char)s[1] == 0xB1);
}

/** Dimension a * b^sign, checked against overflow of its exponents. */
static mech_dim times(parser *p, mech_dim a, mech_dim b, int sign, const char *place)
{
    int e[] = {a.kg + sign * b.kg, a.m + sign * b.m, a.s + sign * b.s, a.rad + sign * b.rad,
               a.A + sign * b.A};

    for (int i = 0; i < 5; i++) {
        if (e[i] > MAX_POWER || e[i] < -MAX_POWER) {
            fail(p, place, "the powers of the unit become too large");
            e[i] = 0;
        }
    }
    return (mech_dim){(signed char)e[0], (signed char)e[1], (signed char)e[2], (signed char)e[3],
                      (signed char)e[4]};
}

static operand add(parser *p, operand a, operand b, const char *place)
{
    operand r = a.wild ? b : a;
    char ua[MECH_UNIT], ub[MECH_UNIT];

    if (!a.wild && !b.wild && !mech__dim_same(a.dim, b.dim) && !p->failed) {
        mech__unit_text(a.dim, ua);
        mech__unit_text(b.dim, ub);
        if (a.bare || b.bare) {
            snprintf(p->why, sizeof p->why,
                     "a number without a unit in a sum with one in %s: "
                     "missing unit",
                     a.bare ? ub : ua);
        } else {
            snprintf(p->why, sizeof p->why, "%s and %s cannot be added", ua, ub);
        }
        fail(p, place, p->why);
    }
    r.literal = 0;
    r.percent = 0;
    r.bare = a.bare && b.bare;
    return r;
}

static operand multiply(parser *p, operand a, operand b, int sign, const char *place)
{
    operand r = {times(p, a.dim, b.dim, sign, place), a.wild || (sign > 0 && b.wild), 0,
                 a.bare && b.bare, 0};

    return r;
}

static operand number(parser *p)
{
    mech__quantity q;
    const char *bad, *start = p->at;
    operand r = {.literal = 1};
    char why[MECH__WHY] = "";
    int used = mech__quantity_at(p->at, &q, why, &bad);

    if (used < 0) {
        fail(p, bad, why);
        return r;
    }
    p->at = start + used;
    r.dim = q.dim;
    r.bare = !q.has_unit;
    r.percent = q.percent;
    r.wild = r.bare && q.value == 0.0;
    emit(p, MECH_OP_CONST, -1, q.value);
    return r;
}

static operand call(parser *p, size_t length, const char *name)
{
    operand r = {.wild = 0};

    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; i++) {
        if (strlen(functions[i].name) != length || memcmp(functions[i].name, name, length) != 0) {
            continue;
        }
        operand x = sum(p);
        int root = functions[i].op == MECH_OP_SQRT;

        if (!root && !x.wild && !mech__dim_same(x.dim, (mech_dim){.kg = 0})) {
            fail(p, name, "a function of an angle needs a pure number or an angle");
        } else if (root && (x.dim.kg % 2 || x.dim.m % 2 || x.dim.s % 2 || x.dim.A % 2)) {
            fail(p, name, "the root of a unit with odd powers");
        } else if (root) {
            r.dim = (mech_dim){(signed char)(x.dim.kg / 2), (signed char)(x.dim.m / 2),
                               (signed char)(x.dim.s / 2), (signed char)(x.dim.rad / 2),
                               (signed char)(x.dim.A / 2)};
            r.wild = x.wild;
        }
        r.bare = x.bare;
        emit(p, functions[i].op, -1, 0.0);
        return r;
    }
    fail(p, name, "unknown function, expected sin, cos, tan or sqrt");
    return r;
}

/** "( sum )", with the function before it if there is one. */
static operand bracket(parser *p, size_t length, const char *name)
{
    operand r = {.wild = 0};

    if (++p->brackets > MECH__MAX_DEPTH) {
        fail(p, p->at, "brackets are nested too deeply");
        return r;
    }
    p->at++;
    r = length ? call(p, length, name) : sum(p);
    skip(p);
    if (*p->at == ')') {
        p->at++;
    } else {
        fail(p, p->at, "expected \")\"");
    }
    p->brackets--;
    r.literal = 0;
    return r;
}

static void unknown_reference(parser *p, const char *path, const char *place)
{
    mech__nearest near = {path, NULL, 0};
    char why[MECH__WHY];

    if (p->failed) {
        return;
    }
    mech__offer_paths(p->rd, &near);
    p->hint = mech__hint(p->rd, &near, "");
    if (strchr(path, '.')) {
        snprintf(why, sizeof why, "there is no number \"%.*s\"", MECH_PATH, path);
    } else {
        snprintf(why, sizeof why, "\"%.*s\" is no number (a name looks like owner.name)", MECH_PATH,
                 path);
    }
    fail(p, place, why);
}

static operand reference(parser *p, const char *name, size_t length)
{
    operand r = {.wild = 0};
    mech__expr e = {0};
    char *path = mech__alloc(p->rd, length + 1);

    if (!path || !p->refs_allowed) {
        fail(p, name, "expected a number with its unit");
        return r;
    }
    memcpy(path, name, length);
    p->refs = 1;
    switch (mech__reference(p->rd, path, &e)) {
    case 0:
        for (int i = 0; i < e.nsteps; i++) {
            emit(p, e.steps[i].op, e.steps[i].param, e.steps[i].value);
        }
        break;
    case -1: unknown_reference(p, path, name); break;
    case -3: fail(p, name, "the formula refers to itself"); break;
    default: fail(p, name, "");
    }
    r.dim = e.dim;
    return r;
}

static operand atom(parser *p)
{
    operand none = {.wild = 0};
    const char *name = p->at;
    size_t n = 0;

    if (p->failed) {
        return none;
    }
    if (*name == '(') {
        return bracket(p, 0, name);
    }
    if (!is_letter(*name)) {
        return number(p);
    }
    while (is_word(name[n]) || (name[n] == '.' && is_word(name[n + 1]))) {
        n++;
    }
    if (n == 3 && (strncmp(name, "nan", n) == 0 || strncmp(name, "inf", n) == 0)) {
        fail(p, name, "the number must be finite");
        return none;
    }
    p->at += n;
    skip(p);
    return *p->at == '(' ? bracket(p, n, name) : reference(p, name, n);
}

static operand signed_atom(parser *p)
{
    int minus = 0;

    skip(p);
    while ((*p->at == '-' || *p->at == '+') && !at_tolerance(p->at)) {
        minus ^= *p->at == '-';
        p->at++;
        skip(p);
    }
    operand r = atom(p);

    if (minus && p->n > 0 && r.literal) {
        p->steps[p->n - 1].value = -p->steps[p->n - 1].value;
    } else if (minus) {
        emit(p, MECH_OP_NEG, -1, 0.0);
    }
    return r;
}

static operand term(parser *p)
{
    operand r = signed_atom(p);

    for (skip(p); !p->failed && (*p->at == '*' || *p->at == '/'); skip(p)) {
        const char *place = p->at;
        int sign = *p->at++ == '*' ? 1 : -1;
        operand b = signed_atom(p);

        r = multiply(p, r, b, sign, place);
        emit(p, sign > 0 ? MECH_OP_MUL : MECH_OP_DIV, -1, 0.0);
    }
    return r;
}

static operand sum(parser *p)
{
    operand r = term(p);

    for (skip(p); !p->failed && (*p->at == '+' || *p->at == '-') && !at_tolerance(p->at); skip(p)) {
        const char *place = p->at;
        mech_op op = *p->at++ == '+' ? MECH_OP_ADD : MECH_OP_SUB;
        operand b = term(p);

        r = add(p, r, b, place);
        emit(p, op, -1, 0.0);
    }
    return r;
}

/** "+- 2 g" or "+- 2 %" after a single number. */
static double tolerance(parser *p, const operand *value)
{
    const char *start = p->at, *bad;
    char why[MECH__WHY] = "";
    mech__quantity q;

    p->at += 2;
    skip(p);
    int used = mech__quantity_at(p->at, &q, why, &bad);

    if (used < 0) {
        fail(p, bad, why);
    } else if (!value->literal) {
        fail(p, start, "a tolerance belongs to a single number, not to a formula");
    } else if (q.percent) {
        q.value *= fabs(p->steps[0].value);
    } else if (!mech__dim_same(q.dim, value->dim) || q.has_unit == value->bare) {
        fail(p, p->at, "the tolerance needs the unit of its number, or %");
    }
    p->at += used > 0 ? used : 0;
    return q.value;
}

/** Cells that postfix needs. */
static int stack_depth(const mech_step *steps, int n)
{
    int depth = 0, most = 0;

    for (int i = 0; i < n; i++) {
        // cppcheck-suppress uninitvar ; as many as n says are there
        if (steps[i].op == MECH_OP_CONST || steps[i].op == MECH_OP_PARAM) {
            depth++;
        } else if (steps[i].op <= MECH_OP_DIV) {
            depth--;
        }
        most = depth > most ? depth : most;
    }
    return most;
}

static void rest(parser *p)
{
    if (*p->at == '\0') {
        return;
    }
    if (*p->at == '^') {
        fail(p, p->at, "powers are for units only: write x * x");
    } else if (*p->at == ',') {
        fail(p, p->at, "a comma in a number: write a decimal point");
    } else {
        fail(p, p->at, "unexpected text, expected an operator or the end");
    }
}

int mech__expression(mech__reader *rd, const mech__slot *slot, const char *text, int from_set,
                     mech__expr *out)
{
    mech_step steps[MECH__MAX_STEPS];
    parser p = {.rd = rd, .at = text, .steps = steps, .refs_allowed = !from_set, .hint = ""};
    operand v = sum(&p);

    memset(out, 0, sizeof *out);
    if (!p.failed && at_tolerance(p.at)) {
        out->tolerance = tolerance(&p, &v);
        skip(&p);
    }
    if (!p.failed) {
        rest(&p);
    }
    if (!p.failed && stack_depth(steps, p.n) > MECH_STACK) {
        fail(&p, text, "the formula is nested too deeply");
    }
    if (p.failed) {
        if (p.why[0]) {
            mech__problem_slot(rd, slot, from_set, (size_t)(p.bad - text), "%s%s", p.why, p.hint);
        }
        return -1;
    }
    out->steps = mech__alloc(rd, sizeof steps[0] * (size_t)p.n);
    if (!out->steps) {
        return -1;
    }
    memcpy(out->steps, steps, sizeof steps[0] * (size_t)p.n);
    out->nsteps = p.n;
    out->dim = v.dim;
    out->wild = v.wild;
    out->literal = v.literal;
    out->bare = v.bare;
    out->percent = v.percent;
    out->refs = p.refs;
    return 0;
}

double mech__evaluate(const mech_step *steps, int nsteps, const double *param)
{
    double cell[MECH_STACK + 1] = {0.0};
    int top = 0;

    for (int i = 0; i < nsteps; i++) {
        const mech_step *s = &steps[i];

        if (s->op == MECH_OP_CONST || s->op == MECH_OP_PARAM) {
            cell[top++] = s->op == MECH_OP_CONST ? s->value : param[s->param];
            continue;
        }
        if (s->op <= MECH_OP_DIV) {
            top--;
        }
        double *a = &cell[top - 1], b = cell[top];

        switch (s->op) {
        case MECH_OP_ADD: *a += b; break;
        case MECH_OP_SUB: *a -= b; break;
        case MECH_OP_MUL: *a *= b; break;
        case MECH_OP_DIV: *a /= b; break;
        case MECH_OP_NEG: *a = -*a; break;
        case MECH_OP_SIN: *a = stein__sin(*a); break;
        case MECH_OP_COS: *a = stein__cos(*a); break;
        case MECH_OP_TAN: *a = stein__tan(*a); break;
        default: *a = sqrt(*a); break;
        }
    }
    return cell[0];
}
