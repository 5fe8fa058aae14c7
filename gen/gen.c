/* SPDX-License-Identifier: MIT
 * gen.c - a mechanism in, one C file out: checks, the order of the passes, the result.
 */
#include "gen.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

enum {
    MAX_SLOPES = 4000 /* joints times operations of the inverse dynamics */
};

static stein_status fail(stein_err *err, stein_status code, const char *format, ...)
{
    if (err) {
        va_list ap;
        va_start(ap, format);
        err->code = code;
        vsnprintf(err->msg, sizeof err->msg, format, ap);
        va_end(ap);
    }
    return code;
}

/* ---- checks: guarantees of the reader, for mechanisms from other sources --------------------- */

static int is_identifier(const char *s)
{
    size_t n = strspn(s, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_");
    return n > 0 && n < MECH_NAME && s[n] == '\0' && !(s[0] >= '0' && s[0] <= '9');
}

static int scalar_ok(const mechanism *m, const mech_scalar *s, int n)
{
    for (int i = 0; i < n; i++) {
        int limit = s[i].kind == MECH_PARAM ? m->nparam : m->nformula;
        if (s[i].kind != MECH_ZERO && (s[i].index < 0 || s[i].index >= limit)) {
            return 0;
        }
    }
    return 1;
}

static int formula_ok(const mechanism *m, const mech_formula *f)
{
    int depth = 0;
    for (int i = 0; i < f->nsteps; i++) {
        mech_op op = f->steps[i].op;
        int leaf = op == MECH_OP_CONST || op == MECH_OP_PARAM;
        int binary = op >= MECH_OP_ADD && op <= MECH_OP_DIV;
        if (op == MECH_OP_PARAM && (f->steps[i].param < 0 || f->steps[i].param >= m->nparam)) {
            return 0;
        }
        depth += leaf;
        if (depth > MECH_STACK || depth < (binary ? 2 : 1)) {
            return 0;
        }
        depth -= binary;
    }
    return depth == 1;
}

static stein_status check_bodies(const mechanism *m, stein_err *err)
{
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        if (b->parent < -1 || b->parent >= i) {
            return fail(err, STEIN_EGENERATE, "body %d: its parent must come before it", i);
        }
        if ((b->type != 'R' && b->type != 'T') || b->axis < 'x' || b->axis > 'z' ||
            (b->sign != 1 && b->sign != -1)) {
            return fail(err, STEIN_EGENERATE, "body %d: a joint is R or T with axis x, y or z", i);
        }
        if (!scalar_ok(m, b->at, 3) || !scalar_ok(m, &b->mass, 1) || !scalar_ok(m, b->centre, 3) ||
            !scalar_ok(m, b->inertia, 6) || !scalar_ok(m, &b->armature, 1) ||
            !scalar_ok(m, &b->q0, 1) || !scalar_ok(m, &b->qd0, 1)) {
            return fail(err, STEIN_EGENERATE, "body %d: a number refers to no parameter", i);
        }
    }
    return STEIN_OK;
}

/** Contacts are planar: from the frame to their bodies only turns about y, slides along x and z. */
static stein_status check_carrier(const mechanism *m, int body, const char *owner, stein_err *err)
{
    if (body < -1 || body >= m->nbody) {
        return fail(err, STEIN_EGENERATE, "%s: it refers to no body", owner);
    }
    for (int i = body; i >= 0; i = m->bodies[i].parent) {
        const mech_body *b = &m->bodies[i];
        if ((b->type == 'R') != (b->axis == 'y')) {
            return fail(
                err, STEIN_EGENERATE,
                "%s: contacts are planar, but joint %s does not turn about y or slide along "
                "x or z",
                owner, b->name);
        }
    }
    return STEIN_OK;
}

static stein_status check_parts(const mechanism *m, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int c = 0; c < m->ncontact; c++) {
        const mech_contact *k = &m->contacts[c];
        if (k->nspot < 1 || k->nspot > MECH_SPOTS) {
            return fail(err, STEIN_EGENERATE, "%s: a contact has 1 to %d spots", k->name,
                        MECH_SPOTS);
        }
        for (int i = 0; i < 2 * k->nspot && !status; i++) {
            const mech_shape *s = &k->spot[i / 2].side[i % 2];
            if (i % 2 == 0 && (s->solid == MECH_PLANE || (s->is_line && !s->end))) {
                return fail(err, STEIN_EGENERATE, "%s: the first side of a spot is a line",
                            k->name);
            }
            if (s->body < -1 || s->body >= m->nbody || s->solid == MECH_FLAT) {
                status = check_carrier(m, s->body, k->name, err);
            }
        }
    }
    for (int i = 0; i < m->nnotch && !status; i++) {
        status = check_carrier(m, m->notches[i].catcher, m->notches[i].name, err);
        if (!status) {
            status = check_carrier(m, m->notches[i].beak, m->notches[i].name, err);
        }
    }
    for (int i = 0; i < m->npoint && !status; i++) {
        if (m->points[i].body < -1 || m->points[i].body >= m->nbody) {
            return fail(err, STEIN_EGENERATE, "%s: it refers to no body", m->points[i].name);
        }
    }
    return status;
}

static stein_status check_signals(const mechanism *m, stein_err *err)
{
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *k = &m->inputs[i];
        int limit = k->kind == STEIN_INPUT_POINT ? m->npoint : m->nbody;
        if (k->kind < STEIN_INPUT_JOINT || k->kind > STEIN_INPUT_VOLTAGE || k->index < 0 ||
            k->index >= limit) {
            return fail(err, STEIN_EGENERATE, "%s: the input acts on nothing", k->name);
        }
    }
    for (int i = 0; i < m->nchannel; i++) {
        if (m->channels[i].read < 0 || m->channels[i].read >= STEIN_READ_KINDS) {
            return fail(err, STEIN_EGENERATE, "%s: unknown reading", m->channels[i].name);
        }
    }
    for (int i = 0; i < m->nlink; i++) {
        for (int k = 0; k < 2; k++) {
            if (m->links[i].point[k] < 0 || m->links[i].point[k] >= m->npoint) {
                return fail(err, STEIN_EGENERATE, "%s: it refers to no point", m->links[i].name);
            }
        }
    }
    return STEIN_OK;
}

static stein_status check_loops(const mechanism *m, stein_err *err)
{
    for (int i = 0; i < m->nloop; i++) {
        const mech_loop *l = &m->loops[i];
        int couples = l->kind == MECH_COUPLING, limit = couples ? m->nbody : m->npoint;
        for (int k = 0; k < 2; k++) {
            if (l->index[k] < 0 || l->index[k] >= limit) {
                return fail(err, STEIN_EGENERATE, "%s: it refers to no %s", l->name,
                            couples ? "joint" : "point");
            }
        }
        if (l->kind < MECH_MEET || l->kind > MECH_COUPLING || l->axis < -1 || l->axis > 2 ||
            !scalar_ok(m, &l->length, 1) || !scalar_ok(m, &l->ratio, 1) ||
            !scalar_ok(m, &l->offset, 1)) {
            return fail(err, STEIN_EGENERATE, "%s: the loop is not well formed", l->name);
        }
    }
    return STEIN_OK;
}

static stein_status check(const mechanism *m, stein_err *err)
{
    if (!is_identifier(m->name)) {
        return fail(err, STEIN_EGENERATE,
                    "the mechanism's name is no identifier of up to 32 signs");
    }
    if (m->nbody < 1 || m->nbody > MECH_BODIES) {
        return fail(err, STEIN_EGENERATE, "%s: %d bodies, expected 1 to %d", m->name, m->nbody,
                    MECH_BODIES);
    }
    if (!scalar_ok(m, m->gravity, 3)) {
        return fail(err, STEIN_EGENERATE, "%s: gravity refers to no parameter", m->name);
    }
    for (int i = 0; i < m->nformula; i++) {
        if (!formula_ok(m, &m->formulas[i])) {
            return fail(err, STEIN_EGENERATE, "%s: formula is not well formed",
                        m->formulas[i].name);
        }
    }
    stein_status status = check_bodies(m, err);
    status = status ? status : check_parts(m, err);
    status = status ? status : check_loops(m, err);
    return status ? status : check_signals(m, err);
}

/* ---- the passes ------------------------------------------------------------------------------ */

/** Derivatives, in the frames of their functions. Those by every q and qd grow with
 *  the number of joints times the size of the function: a large tree takes the ones along. */
static int make_slopes(funcs *f, const tree *t)
{
    if (t->nrow || tree_in_space(t)) { /* its derivative is not implemented */
        return 0;
    }
    int n = t->n, size = f->inverse.ops.add + f->inverse.ops.mul;
    if (n * size <= MAX_SLOPES && func_like(&f->slopes, t, &f->inverse, slope_inverse, 2 * n * n)) {
        return -1;
    }
    return func_like(&f->along, t, &f->inverse, along_inverse, n) ||
           func_like(&f->pose_along, t, &f->pose, along_pose, 7 * t->ncarrier);
}

/** qdd by articulated bodies, where that is less work than M, c and the solution. */
static int make_route(funcs *f, const tree *t)
{
    func *a = &f->articulated;
    if (!dyn_articulates(t)) {
        return 0;
    }
    if (tree_is_long(t)) {
        return func_search(a, t, dyn_articulated, 2 * t->n);
    }
    if (func_search(a, t, dyn_articulated, 2 * t->n)) {
        return -1;
    }
    if (gen_total(a->ops) >= gen_total(f->unloaded.ops) + gen_total(solve_ops(t))) {
        func_free(a);
        *a = (func){.nout = 0};
    }
    return 0;
}

/* n times a, and b */
static stein_ops times(int n, stein_ops a, stein_ops b)
{
    return (stein_ops){n * a.add + b.add, n * a.mul + b.mul, n * a.neg + b.neg, n * a.div + b.div,
                       n * a.trig + b.trig};
}

/* M, c, inverse dynamics and points */
static int make_equations(funcs *f, const tree *t)
{
    int n = t->n, np = t->m->npoint;
    if (tree_is_long(t)) {
        int failed = func_search(&f->inverse, t, dyn_inverse, n) ||
                     func_search(&f->momenta, t, long_momenta, n) ||
                     func_search(&f->point, t, long_points, 9 * np + 6 * n);
        f->mass_bias.ops = f->unloaded.ops = times(n, f->momenta.ops, f->inverse.ops);
        return failed;
    }
    return func_search(&f->mass_bias, t, dyn_mass_bias, n * n + n) ||
           func_like(&f->unloaded, t, &f->mass_bias, dyn_unloaded, n * n + n) ||
           func_search(&f->inverse, t, dyn_inverse, n) ||
           func_search(&f->point, t, kin_point, 9 * np + 3 * np * n);
}

static int make_functions(funcs *f, const tree *t)
{
    int n = t->n;
    return make_equations(f, t) || func_search(&f->pose, t, kin_pose, 7 * t->ncarrier) ||
           func_search(&f->energy, t, kin_energy, 2) ||
           (t->nsolid && func_search(&f->pose3, t, kin_pose3, POSE3 * t->nsolid)) ||
           (t->nrow && func_search(&f->closure, t, loop_closure, t->nrow * (2 + n))) ||
           make_slopes(f, t) || make_route(f, t);
}

static void make_layout(layout *l, const tree *t, const funcs *f)
{
    if (f->momenta.nout) {
        layout_add_func(l, t, &f->momenta);
    } else {
        layout_add_func(l, t, &f->mass_bias);
        layout_add_func(l, t, &f->unloaded);
    }
    layout_add_func(l, t, &f->inverse);
    layout_add_func(l, t, &f->pose);
    layout_add_func(l, t, &f->point);
    layout_add_func(l, t, &f->energy);
    if (f->articulated.nout) {
        layout_add_func(l, t, &f->articulated);
    }
    const func *only_some[] = {&f->slopes, &f->along, &f->pose_along, &f->pose3, &f->closure};
    for (size_t i = 0; i < sizeof only_some / sizeof *only_some; i++) {
        if (only_some[i]->nout) {
            layout_add_func(l, t, only_some[i]);
        }
    }
}

static stein_status write_text(gen_result *out, const tree *t, const layout *l, funcs *f)
{
    text head, body;
    char hash[17] = "";
    text_init(&head);
    text_init(&body);
    text_add(&body, "#include <math.h>\n#include <stddef.h>\n\n#include \"stein/model.h\"\n\n");
    text_quiet(&body, "/* derived constants from parameters */\n");
    emit_setup(&body, t, l, &f->setup);
    emit_functions(&body, t, l, f);
    text_add(&body, "#ifndef STEIN_PLAIN\n\n");
    emit_slopes(&body, t, l, f);
    emit_setup_along(&body, t, l);
    text_add(&body, "#endif\n\n");
    emit_tables(&body, t, l);
    emit_model(&body, t, l, f, hash);
    emit_header(&head, t, l, f);
    text_quiet(&head, "%s", body.s ? body.s : "");
    if (head.failed || body.failed) {
        free(head.s);
        free(body.s);
        return STEIN_ENOMEM;
    }
    free(body.s);
    *out = (gen_result){.source = head.s,
                        .size = head.n,
                        .setup = f->setup,
                        .mass_bias = f->mass_bias.ops,
                        .unloaded = f->unloaded.ops,
                        .inverse = f->inverse.ops,
                        .pose = f->pose.ops,
                        .point = f->point.ops,
                        .energy = f->energy.ops,
                        .slopes = f->slopes.ops,
                        .along = f->along.ops,
                        .closure = f->closure.ops,
                        .pose3 = f->pose3.ops,
                        .articulated = f->articulated.ops,
                        .solve = solve_ops(t)};
    memcpy(out->equations, hash, sizeof hash);
    return STEIN_OK;
}

stein_status gen_equations(gen_result *out, const mechanism *m, stein_err *err)
{
    stein_status status = check(m, err);
    if (status) {
        return status;
    }
    ex_graph setup;
    tree t = {0};
    layout l = {0};
    funcs f = {.setup = {0}};
    status = STEIN_ENOMEM;
    if (ex_graph_init(&setup, NULL) == 0 && tree_build(&t, m, &setup) == 0 &&
        layout_build(&l, &t) == 0 && make_functions(&f, &t) == 0) {
        make_layout(&l, &t, &f);
        if (!l.failed && !setup.failed) {
            status = write_text(out, &t, &l, &f);
        }
    }
    func_free(&f.mass_bias);
    func_free(&f.unloaded);
    func_free(&f.momenta);
    func_free(&f.articulated);
    func_free(&f.inverse);
    func_free(&f.pose);
    func_free(&f.point);
    func_free(&f.energy);
    func_free(&f.slopes);
    func_free(&f.along);
    func_free(&f.pose_along);
    func_free(&f.pose3);
    func_free(&f.closure);
    layout_free(&l);
    tree_free(&t);
    ex_graph_free(&setup);
    return status ? fail(err, status, "%s: out of memory", m->name) : STEIN_OK;
}

int gen_total(stein_ops o)
{
    return o.add + o.mul + o.neg + o.div + o.trig;
}

void gen_free(gen_result *r)
{
    if (r) {
        free(r->source);
        *r = (gen_result){.source = NULL};
    }
}
