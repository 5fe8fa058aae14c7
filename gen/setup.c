/* SPDX-License-Identifier: MIT
 * setup.c - the layout of the derived constants d.
 *
 *      initial {q, qd} | clock | laws of the joints | points | contacts | notches | links |
 *      tables | limits | inputs | sensors | bodies, gravity, ratios | constants of the equations
 *
 * Bodies, gravity and ratios are there where an output reads a reaction.
 *
 * Every entry is a node of the setup graph, so that equal formulas are worked out once and a
 * constant that two functions need has one place.
 */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

static int put(layout *l, ex node, const char *format, ...)
{
    if (l->n == l->cap && !l->failed) {
        int cap = 2 * l->cap + 64;
        slot *grown = realloc(l->slot, (size_t)cap * sizeof *grown);
        l->failed = !grown;
        if (grown) {
            l->slot = grown;
            l->cap = cap;
        }
    }
    if (l->failed) {
        return 0;
    }
    va_list ap;
    va_start(ap, format);
    l->slot[l->n].node = node;
    vsnprintf(l->slot[l->n].legend, sizeof l->slot[l->n].legend, format, ap);
    va_end(ap);
    return l->n++;
}

/* Names of the entries of a block, in the order of its enum in stein/model.h. */
static const char *const normal_names[] = {"a", "b",  "c",   "D",        "p",
                                           "h", "F0", "gap", "adhesion", "range"};
static const char *const friction_names[] = {"A", "vt", "B1", "B2"};
static const char *const joint_names[] = {"k",          "q0",           "k3", "b",  "asymmetry",
                                          "drag",       "preload",      "T",  "w",  "dry_asymmetry",
                                          "backlash_k", "backlash_gap", "A",  "vt", "B1",
                                          "B2"};
static const char *const link_names[] = {"k",   "length", "damping",  "slack",
                                         "off", "off_z",  "off_range"};
static const char *const limit_names[] = {"from", "to", "k", "D"};
static const char *const signal_names[] = {"gain", "delay"};
static const char *const direction_names[] = {"x", "y", "z"};
static const char *const voltage_names[] = {"per volt"};
static const char *const sensor_names[] = {"gain", "offset", "square", "tilt", "delay"};
enum { DIRECTION_SIZE = 3 };
#define HAS_NAMES(names, size) \
    _Static_assert(sizeof(names) / sizeof *(names) == (size), "every entry of a block has a name")
static const char *const made_names[] = {"at_x", "at_y", "at_z", "mass", "x",  "y", "z",
                                         "xx",   "yy",   "zz",   "xy",   "xz", "yz"};
static const char *const ratio_names[] = {"ratio"};
HAS_NAMES(normal_names, STEIN_NORMAL_SIZE);
HAS_NAMES(friction_names, STEIN_FRICTION_SIZE);
HAS_NAMES(made_names, STEIN_MADE_SIZE);
HAS_NAMES(joint_names, STEIN_JOINT_SIZE);
HAS_NAMES(link_names, STEIN_LINK_SIZE);
HAS_NAMES(limit_names, STEIN_LIMIT_SIZE);
HAS_NAMES(signal_names, STEIN_SIGNAL_SIZE);
HAS_NAMES(direction_names, DIRECTION_SIZE);
HAS_NAMES(sensor_names, STEIN_SENSOR_SIZE);

/** A block of n numbers with their names. @return its base */
static int put_block(layout *l, const tree *t, const mech_scalar *v, const char *const *names,
                     int n, const char *owner, const char *what)
{
    int base = put(l, tree_scalar(t, v[0]), "%s: %s %s", owner, what, names[0]);
    for (int i = 1; i < n; i++) {
        put(l, tree_scalar(t, v[i]), "  %s", names[i]);
    }
    return base;
}

static int put_normal(layout *l, const tree *t, const mech_normal *k, const char *owner)
{
    return put_block(l, t, k->v, normal_names, STEIN_NORMAL_SIZE, owner, "normal law");
}

static int put_friction(layout *l, const tree *t, const mech_friction *k, const char *owner)
{
    return put_block(l, t, k->v, friction_names, STEIN_FRICTION_SIZE, owner, "friction");
}

static void put_joints(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    l->initial = l->n;
    for (int i = 0; i < m->nbody; i++) {
        put(l, tree_scalar(t, m->bodies[i].q0), "%s: initial q, qd", text_safe(m->bodies[i].name));
        put(l, tree_scalar(t, m->bodies[i].qd0), "  qd");
    }
    l->clock = put(l, tree_scalar(t, m->clock_error), "clock error");
    for (int i = 0; i < m->nbody; i++) {
        l->joint[i] = put_block(l, t, m->bodies[i].joint, joint_names, STEIN_JOINT_SIZE,
                                text_safe(m->bodies[i].name), "joint");
    }
}

static int has_frame(const tree *t, int body)
{
    int found = body < 0;
    for (int k = 0; k < t->ncarrier; k++) {
        found |= t->carrier[k] == body;
    }
    return found;
}

/** x and z of a point in its body's axes; y in the fixed frame, where a planar body keeps it. */
static void put_points(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    for (int i = 0; i < m->npoint; i++) {
        const mech_point *k = &m->points[i];
        ex y = tree_scalar(t, k->at[1]);
        for (int b = k->body; b >= 0; b = m->bodies[b].parent) {
            y = ex_add(t->setup, y, tree_scalar(t, m->bodies[b].at[1]));
        }
        l->point[i] = -1;
        if (has_frame(t, k->body)) {
            l->point[i] = put(l, tree_scalar(t, k->at[0]), "%s: x, y, z", text_safe(k->name));
            put(l, y, "  y");
            put(l, tree_scalar(t, k->at[2]), "  z");
        }
    }
}

/** Position, radius, normal, extent of one side. An end of a line is its position moved along the
 *  tangent, which is the normal turned by -90 degrees: (nz, -nx). */
static int put_shape(layout *l, const tree *t, const mech_shape *s, const char *owner)
{
    ex_graph *g = t->setup;
    ex x = tree_scalar(t, s->at[0]), z = tree_scalar(t, s->at[2]), nx = 0, nz = 0;
    ex lo = 0, hi = 0, radius = tree_scalar(t, s->radius);
    if (s->is_line || s->end) {
        ex facing = tree_scalar(t, s->facing);
        nx = ex_fun(g, EX_COS, facing);
        nz = ex_fun(g, EX_SIN, facing);
        radius = 0;
    }
    if (s->end) {
        ex shift = tree_scalar(t, s->extent[s->end > 0]);
        x = ex_add(g, x, ex_mul(g, nz, shift));
        z = ex_sub(g, z, ex_mul(g, nx, shift));
        nx = nz = 0;
    } else if (s->is_line) {
        lo = s->has_extent ? tree_scalar(t, s->extent[0]) : ex_num(g, -INFINITY);
        hi = s->has_extent ? tree_scalar(t, s->extent[1]) : ex_num(g, INFINITY);
    }
    int base = put(l, x, "%s: %s x, z, r, nx, nz, lo, hi", owner,
                   s->is_line && !s->end ? "line" : "circle");
    put(l, z, "  z");
    put(l, radius, "  radius");
    put(l, nx, "  normal x");
    put(l, nz, "  normal z");
    put(l, lo, "  extent from");
    put(l, hi, "  extent to");
    return base;
}

/* the normal of a plane: a normal of a line in its plane, or a vector of any length */
static void solid_normal(const tree *t, const mech_shape *s, ex n[3])
{
    ex_graph *g = t->setup;
    vec v = tree_vector(t, s->normal);
    if (s->is_line) {
        ex facing = tree_scalar(t, s->facing);
        n[s->across] = 0;
        n[s->across == 0] = ex_fun(g, EX_COS, facing);
        n[s->across == 2 ? 1 : 2] = ex_fun(g, EX_SIN, facing);
        return;
    }
    ex length = ex_fun(g, EX_SQRT, vec_dot(g, v, v));
    for (int k = 0; k < 3; k++) {
        n[k] = v.x[k] == 0 ? 0 : ex_div(g, v.x[k], length);
    }
}

static int put_solid(layout *l, const tree *t, const mech_shape *s, const char *owner)
{
    ex_graph *g = t->setup;
    int plane = s->solid == MECH_PLANE, corner = s->corner - 1;
    vec at = tree_vector(t, s->at);
    ex n[3] = {0, 0, 0};
    if (plane) {
        solid_normal(t, s, n);
    }
    for (int k = 0; corner >= 0 && k < 3; k++) {
        ex half = ex_mul(g, ex_num(g, corner >> k & 1 ? 0.5 : -0.5), tree_scalar(t, s->size[k]));
        at.x[k] = ex_add(g, at.x[k], half);
    }
    int base = put(l, at.x[0], "%s: %s x, y, z, r, nx, ny, nz", owner, plane ? "plane" : "sphere");
    put(l, at.x[1], "  y");
    put(l, at.x[2], "  z");
    put(l, plane ? 0 : tree_scalar(t, s->radius), "  radius");
    put(l, n[0], "  normal x");
    put(l, n[1], "  normal y");
    put(l, n[2], "  normal z");
    return base;
}

static int put_side(layout *l, const tree *t, const mech_shape *s, const char *owner)
{
    return s->solid == MECH_FLAT ? put_shape(l, t, s, owner) : put_solid(l, t, s, owner);
}

static void put_contacts(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    for (int c = 0, spot = 0; c < m->ncontact; c++) {
        const mech_contact *k = &m->contacts[c];
        const char *name = text_safe(k->name);
        l->normal[c] = put_normal(l, t, &k->normal, name);
        l->rub[c] = put_friction(l, t, &k->friction, name);
        for (int i = 0; i < k->nspot; i++, spot++) {
            int *shape = l->shape + (ptrdiff_t)spot * 2;
            shape[0] = put_side(l, t, &k->spot[i].side[0], name);
            shape[1] = put_side(l, t, &k->spot[i].side[1], name);
        }
    }
}

/* vertical face v = (-sin lean, cos lean); the roof is v turned by the notch angle */
static void put_notches(layout *l, const tree *t)
{
    ex_graph *g = t->setup;
    for (int i = 0; i < t->m->nnotch; i++) {
        const mech_notch *k = &t->m->notches[i];
        const char *name = text_safe(k->name);
        ex lean = tree_scalar(t, k->lean), tilt = tree_scalar(t, k->tilt);
        ex roof = ex_add(g, lean, tree_scalar(t, k->angle));
        const ex block[STEIN_NOTCH_SIZE] = {
            [STEIN_NOTCH_CX] = tree_scalar(t, k->corner[0]),
            [STEIN_NOTCH_CZ] = tree_scalar(t, k->corner[2]),
            [STEIN_NOTCH_RX] = ex_neg(g, ex_fun(g, EX_SIN, roof)),
            [STEIN_NOTCH_RZ] = ex_fun(g, EX_COS, roof),
            [STEIN_NOTCH_VX] = ex_neg(g, ex_fun(g, EX_SIN, lean)),
            [STEIN_NOTCH_VZ] = ex_fun(g, EX_COS, lean),
            [STEIN_NOTCH_EX] = tree_scalar(t, k->end[0]),
            [STEIN_NOTCH_EZ] = tree_scalar(t, k->end[2]),
            [STEIN_NOTCH_BX] = ex_fun(g, EX_COS, tilt),
            [STEIN_NOTCH_BZ] = ex_fun(g, EX_SIN, tilt),
        };
        static const char *const what[STEIN_NOTCH_SIZE] = {
            "corner x",        "corner z",   "roof x",     "roof z",      "vertical face x",
            "vertical face z", "beak end x", "beak end z", "beak face x", "beak face z"};
        for (int j = 0; j < STEIN_NOTCH_SIZE; j++) {
            int at = j == 0 ? put(l, block[j], "%s: %s", name, what[j])
                            : put(l, block[j], "  %s", what[j]);
            l->notch[i] = j == 0 ? at : l->notch[i];
        }
        l->notch_normal[i] = put_normal(l, t, &k->normal, name);
        l->notch_rub[i] = put_friction(l, t, &k->friction, name);
    }
}

static void put_rest(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    for (int i = 0; i < m->nlink; i++) {
        const mech_link *k = &m->links[i];
        l->link[i] =
            put_block(l, t, k->law, link_names, STEIN_LINK_SIZE, text_safe(k->name), "link");
    }
    for (int i = 0; i < m->ntable; i++) {
        const mech_table *k = &m->tables[i];
        for (int j = 0; j < 2 * k->n; j++) {
            ex node = tree_scalar(t, k->v[j]);
            int at = j == 0 ? put(l, node, "%s: table of %d points, at and value",
                                  text_safe(k->name), k->n)
                            : put(l, node, "  %s", j < k->n ? "at" : "value");
            l->table[i] = j == 0 ? at : l->table[i];
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        l->limit[i] = b->limited ? put_block(l, t, b->limit, limit_names, STEIN_LIMIT_SIZE,
                                             text_safe(b->name), "limits")
                                 : -1;
    }
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *k = &m->inputs[i];
        const char *name = text_safe(k->name);
        l->signal[i] = put_block(l, t, k->signal, signal_names, STEIN_SIGNAL_SIZE, name, "signal");
        l->direction[i] =
            k->kind == STEIN_INPUT_POINT
                ? put_block(l, t, k->direction, direction_names, DIRECTION_SIZE, name, "direction")
            : k->kind == STEIN_INPUT_VOLTAGE
                ? put_block(l, t, k->direction, voltage_names, 1, name, "force")
                : -1;
    }
    l->plain = put(l, ex_num(t->setup, 1.0), "time: sensor gain");
    for (int i = 1; i < STEIN_SENSOR_SIZE; i++) {
        put(l, 0, "  nothing else");
    }
    for (int i = 0; i < m->nchannel; i++) {
        l->sensor[i] = put_block(l, t, m->channels[i].sensor, sensor_names, STEIN_SENSOR_SIZE,
                                 text_safe(m->channels[i].name), "sensor");
    }
}

int layout_reactions(const mechanism *m)
{
    int n = 0;
    for (int i = 0; i < m->nchannel; i++) {
        n += m->channels[i].read == STEIN_READ_REACTION;
    }
    return n;
}

static void put_made(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        mech_scalar v[STEIN_MADE_SIZE];
        memcpy(v + STEIN_MADE_AT, b->at, sizeof b->at);
        v[STEIN_MADE_MASS] = b->mass;
        memcpy(v + STEIN_MADE_CENTRE, b->centre, sizeof b->centre);
        memcpy(v + STEIN_MADE_TENSOR, b->inertia, sizeof b->inertia);
        int at = put_block(l, t, v, made_names, STEIN_MADE_SIZE, text_safe(b->name), "body");
        l->made = i == 0 ? at : l->made;
    }
    l->gravity = put_block(l, t, m->gravity, direction_names, DIRECTION_SIZE, "frame", "gravity");
    for (int i = 0; i < m->nloop; i++) {
        int couples = m->loops[i].kind == MECH_COUPLING;
        l->ratio[i] = couples ? put_block(l, t, &m->loops[i].ratio, ratio_names, 1,
                                          text_safe(m->loops[i].name), "coupling")
                              : -1;
    }
}

int layout_build(layout *l, const tree *t)
{
    const mechanism *m = t->m;
    int nspot = 0;
    *l = (layout){.n = 0};
    for (int c = 0; c < m->ncontact; c++) {
        nspot += m->contacts[c].nspot;
    }
    int size = 2 * m->nbody + m->npoint + 2 * m->ncontact + 2 * nspot + 3 * m->nnotch + m->nlink +
               m->ntable + 2 * m->ninput + m->nchannel + m->nloop;
    int *at = l->store = calloc((size_t)size + 1, sizeof *at);
    if (!at) {
        return -1;
    }
    struct {
        int **array, n;
    } parts[] = {
        {&l->joint, m->nbody},      {&l->normal, m->ncontact}, {&l->rub, m->ncontact},
        {&l->shape, 2 * nspot},     {&l->notch, m->nnotch},    {&l->notch_normal, m->nnotch},
        {&l->notch_rub, m->nnotch}, {&l->link, m->nlink},      {&l->direction, m->ninput},
        {&l->signal, m->ninput},    {&l->sensor, m->nchannel}, {&l->table, m->ntable},
        {&l->point, m->npoint},     {&l->limit, m->nbody},     {&l->ratio, m->nloop}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        *parts[i].array = at;
        at += parts[i].n;
    }
    put_joints(l, t);
    put_points(l, t);
    put_contacts(l, t);
    put_notches(l, t);
    put_rest(l, t);
    if (layout_reactions(m)) {
        put_made(l, t);
    }
    l->equations = l->n;
    return l->failed || t->setup->failed ? -1 : 0;
}

int layout_find(const layout *l, ex node)
{
    for (int i = 0; i < l->n; i++) {
        if (l->slot[i].node == node) {
            return i;
        }
    }
    return -1;
}

void layout_add_func(layout *l, const tree *t, const func *f)
{
    int *uses = malloc((size_t)f->g.n * sizeof *uses);
    if (!uses) {
        l->failed = 1;
        return;
    }
    ex_reach(&f->g, f->out, f->nout, uses);
    for (int i = 0; i < f->g.n; i++) {
        const ex_node *nd = &f->g.node[i];
        int moves = nd->op == EX_VAR && nd->a == EX_DD;
        ex k = moves ? nd->b : nd->a;
        if (uses[i] && (moves || nd->op == EX_CONST) && t->setup->node[k].op != EX_NUM &&
            layout_find(l, k) < 0) {
            put(l, k, "%s", "");
        }
    }
    free(uses);
}

void layout_free(layout *l)
{
    free(l->slot);
    free(l->store);
    *l = (layout){.n = 0};
}
