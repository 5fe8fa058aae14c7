/* SPDX-License-Identifier: MIT
 * recombine.c - inertial parameters recombined once per parameter set.
 *
 * A rigid body enters the equations by its mass m, first moment b = m c and inertia K about the
 * joint's origin. Parts of them can be handed to the parent without changing any joint equation
 * (Wittenburg 1977, augmented bodies; Gautier & Khalil 1990, base parameters). With hinge vector d
 * and joint axis e, from the leaves to the root:
 *
 *   revolute   mass m:             b' += m d     K' += m (d.d E - d d')
 *              b along e, be e:    b' += be e    K' += S(be e, d)     and removed from b
 *              inertia k (E - e e'):             K' += k (E - e e')   and removed from K
 *   prismatic  all of it while the joint is at 0: b' += b, K' += K (axes stay parallel);
 *              what sliding adds (m e q, S(b, e) q, m q q) is left to the recursion
 *   S(u, v) = 2 (u.v) E - u v' - v u'
 *
 * Beforehand origins are moved to where they cost least: along the axis of a revolute joint so that
 * d.e = 0, and onto the parent's origin for a prismatic joint (d = 0). All of this is arithmetic on
 * constants: the recursion then runs over bodies with fewer non-zero numbers.
 */
#include <stdlib.h>
#include <string.h>

#include "tree.h"

static ex formula_node(ex_graph *g, const tree *t, const mech_formula *f)
{
    ex stack[MECH_STACK] = {0};
    int top = 0;
    for (int i = 0; i < f->nsteps; i++) {
        const mech_step *s = &f->steps[i];
        ex b = top > 0 ? stack[top - 1] : 0, a = top > 1 ? stack[top - 2] : 0;
        switch (s->op) {
        case MECH_OP_CONST: stack[top++] = ex_num(g, s->value); break;
        case MECH_OP_PARAM: stack[top++] = t->param[s->param]; break;
        case MECH_OP_ADD: stack[--top - 1] = ex_add(g, a, b); break;
        case MECH_OP_SUB: stack[--top - 1] = ex_sub(g, a, b); break;
        case MECH_OP_MUL: stack[--top - 1] = ex_mul(g, a, b); break;
        case MECH_OP_DIV: stack[--top - 1] = ex_div(g, a, b); break;
        case MECH_OP_NEG: stack[top - 1] = ex_neg(g, b); break;
        case MECH_OP_SIN: stack[top - 1] = ex_fun(g, EX_SIN, b); break;
        case MECH_OP_COS: stack[top - 1] = ex_fun(g, EX_COS, b); break;
        case MECH_OP_TAN: stack[top - 1] = ex_fun(g, EX_TAN, b); break;
        case MECH_OP_SQRT: stack[top - 1] = ex_fun(g, EX_SQRT, b); break;
        }
    }
    return stack[0];
}

ex tree_scalar(const tree *t, mech_scalar s)
{
    return s.kind == MECH_ZERO ? 0 : s.kind == MECH_PARAM ? t->param[s.index] : t->formula[s.index];
}

ex tree_rate(const tree *t, ex_graph *g, ex_var_kind kind, int joint)
{
    return t->body[joint].still ? 0 : ex_var(g, kind, joint);
}

int tree_in_space(const tree *t)
{
    int any = 0;
    for (int i = 0; i < t->n; i++) {
        any |= t->body[i].still;
    }
    for (int c = 0; c < t->m->ncontact; c++) {
        any |= t->m->contacts[c].spot[0].side[0].solid != MECH_FLAT;
    }
    return any;
}

vec tree_vector(const tree *t, const mech_scalar s[3])
{
    return (vec){{tree_scalar(t, s[0]), tree_scalar(t, s[1]), tree_scalar(t, s[2])}};
}

/** Joints, orientations, and the plain vectors of the file. */
static void read_bodies(tree *t)
{
    for (int i = 0; i < t->n; i++) {
        const mech_body *src = &t->m->bodies[i];
        rbody *b = &t->body[i];
        int up = src->parent < 0 ? -1 : t->body[src->parent].orient;
        *b = (rbody){.parent = src->parent,
                     .turns = src->type == 'R',
                     .axis = src->axis - 'x',
                     .sign = src->sign,
                     .still = src->ball == 1};
        b->orient = b->turns ? i : up;
        b->base = b->turns && up >= 0 && t->body[up].axis == b->axis ? t->body[up].base : up;
        b->at = tree_vector(t, src->at);
        b->centre = tree_vector(t, src->centre);
        b->mass = tree_scalar(t, src->mass);
        b->armature = tree_scalar(t, src->armature);
        for (int k = 0; k < 6; k++) {
            b->inertia.x[k] = tree_scalar(t, src->inertia[k]);
        }
    }
}

/** Move every joint's origin to where it costs least. */
static void move_origins(tree *t)
{
    vec *shift = calloc((size_t)t->n, sizeof *shift);
    if (!shift) {
        t->setup->failed = 1;
        return;
    }
    for (int i = 0; i < t->n; i++) {
        rbody *b = &t->body[i];
        b->hinge = b->parent < 0 ? b->at : vec_sub(t->setup, b->at, shift[b->parent]);
        for (int k = 0; k < 3; k++) {
            if (!b->turns || k == b->axis) {
                shift[i].x[k] = ex_neg(t->setup, b->hinge.x[k]);
                b->hinge.x[k] = 0;
            }
        }
        b->centre = vec_sub(t->setup, b->centre, shift[i]);
    }
    free(shift);
}

static void name_constants(const tree *t, int i)
{
    static const char *const pair[6] = {"11", "22", "33", "12", "13", "23"};
    const rbody *b = &t->body[i];
    ex_name(t->setup, b->mass, "m%d", i + 1);
    for (int k = 0; k < 3; k++) {
        ex_name(t->setup, b->first.x[k], "mb%d%d", k + 1, i + 1);
        ex_name(t->setup, b->centre.x[k], "l%d%d", k + 1, i + 1);
        ex_name(t->setup, b->hinge.x[k], "dpt%d%d", k + 1, i + 1);
    }
    for (int k = 0; k < 6; k++) {
        ex_name(t->setup, b->inertia.x[k], "K%s%d", pair[k], i + 1);
    }
}

/** The inertia k that goes to the parent. With k = (K_ff + K_hh - K_ee)/2 no mass is left along the
 *  joint axis: what remains has K_ee = K_ff + K_hh and a cheaper moment (dyn.c, inertia_moment). */
static ex surplus(ex_graph *g, rbody *b, int e, int f, int h)
{
    const ex *k = b->inertia.x;
    b->flat = k[f] != 0 && k[h] != 0;
    if (!b->flat) {
        return k[h];
    }
    ex sum = ex_sub(g, ex_add(g, k[f], k[h]), k[e]);
    return ex_mul(g, ex_num(g, 0.5), sum);
}

/** Move to the parent the inertia that does not act on the joint. */
static void hand_up(tree *t, int i, ex *mass, vec *first, sym *inertia)
{
    ex_graph *g = t->setup;
    rbody *b = &t->body[i];
    *mass = ex_add(g, *mass, b->mass);
    if (!b->turns) {
        *first = vec_add(g, *first, b->first);
        *inertia = sym_add(g, *inertia, b->inertia);
        return;
    }
    int e = b->axis, f = (e + 1) % 3, h = (e + 2) % 3;
    vec along = vec_axis(e, b->first.x[e]);
    ex k = surplus(g, b, e, f, h);
    sym extra = sym_add_cross(g, sym_point(g, b->mass, b->hinge), along, b->hinge);
    extra.x[f] = ex_add(g, extra.x[f], k);
    extra.x[h] = ex_add(g, extra.x[h], k);
    b->first.x[e] = 0;
    b->inertia.x[f] = ex_sub(g, b->inertia.x[f], k);
    b->inertia.x[h] = ex_sub(g, b->inertia.x[h], k);
    *first = vec_add(g, *first, vec_add(g, along, vec_scale(g, b->mass, b->hinge)));
    *inertia = sym_add(g, *inertia, extra);
}

static void recombine(tree *t)
{
    ex_graph *g = t->setup;
    sym unused = {{0}};
    for (int i = 0; i < t->n; i++) {
        rbody *b = &t->body[i];
        b->first = vec_scale(g, b->mass, b->centre);
        b->inertia = sym_add(g, b->inertia, sym_point(g, b->mass, b->centre));
    }
    for (int i = t->n - 1; i >= 0; i--) {
        int p = t->body[i].parent;
        rbody *up = p < 0 ? NULL : &t->body[p];
        hand_up(t, i, up ? &up->mass : &t->mass, up ? &up->first : &t->first,
                up ? &up->inertia : &unused);
        name_constants(t, i);
    }
}

static void name_formulas(tree *t)
{
    for (int i = 0; i < t->m->nformula; i++) {
        t->formula[i] = formula_node(t->setup, t, &t->m->formulas[i]);
    }
}

/** From the frame to the body only turns about y and slides along x and z. */
static int is_planar(const mechanism *m, int body)
{
    while (body >= 0 && (m->bodies[body].type == 'R') == (m->bodies[body].axis == 'y')) {
        body = m->bodies[body].parent;
    }
    return body < 0;
}

/** Does a force act at a point of the body - of a link, of an input? */
static int is_pulled(const mechanism *m, int body)
{
    int pulled = 0;
    for (int i = 0; i < m->nlink; i++) {
        pulled |= m->points[m->links[i].point[0]].body == body;
        pulled |= m->points[m->links[i].point[1]].body == body;
    }
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *k = &m->inputs[i];
        pulled |= k->kind == STEIN_INPUT_POINT && m->points[k->index].body == body;
    }
    return pulled;
}

/** Bodies that a contact or notch refers to or, in the plane, a force at a point, and all that
 * carry them; ascending. */
static void find_carriers(tree *t)
{
    const mechanism *m = t->m;
    for (int i = 0; i < m->nbody; i++) {
        int used = is_pulled(m, i) && is_planar(m, i);
        for (int c = 0; c < m->ncontact; c++) {
            for (int k = 0; k < 2 * m->contacts[c].nspot; k++) {
                const mech_shape *s = &m->contacts[c].spot[k / 2].side[k % 2];
                used |= s->body == i && s->solid == MECH_FLAT;
            }
        }
        for (int c = 0; c < m->nnotch; c++) {
            used |= m->notches[c].catcher == i || m->notches[c].beak == i;
        }
        for (int b = used ? i : -1; b >= 0; b = m->bodies[b].parent) {
            t->carrier[b] = 1; // a mark, until the list is written over it
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        if (t->carrier[i]) {
            t->carrier[t->ncarrier++] = i;
        }
    }
}

/** Bodies that need a pose in space: bodies with a contact in space, bodies with an output of
 *  attitude, and all their ancestors in the tree. */
static void find_solids(tree *t)
{
    const mechanism *m = t->m;
    for (int i = 0; i < m->nbody; i++) {
        int used = 0;
        for (int c = 0; c < m->ncontact; c++) {
            for (int k = 0; k < 2; k++) {
                const mech_shape *s = &m->contacts[c].spot[0].side[k];
                used |= s->body == i && s->solid != MECH_FLAT;
            }
        }
        for (int c = 0; c < m->nchannel; c++) {
            used |= stein_reads_attitude(m->channels[c].read) && m->channels[c].index == i;
        }
        for (int b = used ? i : -1; b >= 0; b = m->bodies[b].parent) {
            t->solid[b] = 1;
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        if (t->solid[i]) {
            t->solid[t->nsolid++] = i;
        }
    }
}

int tree_build(tree *t, const mechanism *m, ex_graph *setup)
{
    *t = (tree){.m = m, .setup = setup, .n = m->nbody};
    t->body = calloc((size_t)m->nbody + 1, sizeof *t->body);
    t->param = calloc((size_t)m->nparam + 1, sizeof *t->param);
    t->formula = calloc((size_t)m->nformula + 1, sizeof *t->formula);
    t->carrier = calloc((size_t)m->nbody + 1, sizeof *t->carrier);
    t->solid = calloc((size_t)m->nbody + 1, sizeof *t->solid);
    if (!t->body || !t->param || !t->formula || !t->carrier || !t->solid) {
        tree_free(t);
        return -1;
    }
    for (int i = 0; i < m->nparam; i++) {
        t->param[i] = ex_var(setup, EX_P, i);
    }
    name_formulas(t);
    t->gravity = tree_vector(t, m->gravity);
    find_carriers(t);
    find_solids(t);
    read_bodies(t);
    move_origins(t);
    recombine(t);
    if (loop_rows(t)) {
        tree_free(t);
        return -1;
    }
    return setup->failed ? -1 : 0;
}

void tree_free(tree *t)
{
    free(t->body);
    free(t->param);
    free(t->formula);
    free(t->carrier);
    free(t->solid);
    free(t->row);
    *t = (tree){0};
}
