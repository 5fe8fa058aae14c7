/* SPDX-License-Identifier: GPL-3.0-or-later
 * structure.c - effects that are one body more: a link that bends at one place, an axis that gives
 * way, a partner of a contact on a spring.
 *
 * The mechanism of the records gets the body, the mechanism file does not. The new body is the last
 * one; what hangs on it comes later in `order`.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world.h"

enum { HINGE = STRUCTURE_HINGE, AXIS = STRUCTURE_AXIS, PARTNER = STRUCTURE_PARTNER };

static double number_of(const double *p, int index)
{
    return index < 0 ? 0.0 : p[index];
}

/* a number that the file has not */
static int hidden(mech *m, const char *owner, const char *what, double value)
{
    int k = mech_number(m, owner, what, "1", "1", 1.0, value, 0.0);
    m->number[k].stated = 0;
    return k;
}

static int child_of(const mech *m, int b)
{
    for (int i = 0; i < m->nbody; i++) {
        if (m->body[i].parent == b) {
            return i;
        }
    }
    return -1;
}

static int is_lever(const body *b)
{
    return b->type == 'R' && b->axis == 1 && b->mass >= 0 && b->inertia[1] >= 0;
}

int structure_can(const mech *m, int which, int place)
{
    if (which == PARTNER) {
        return m->contact[place].point[1] < 0 && m->contact[place].line_body < 0;
    }
    const body *b = &m->body[place];
    if (which == AXIS) {
        return is_lever(b) && b->parent < 0;
    }
    int child = is_lever(b) ? child_of(m, place) : -1;
    return child >= 0 && m->body[child].at[2] >= 0 && m->body[child].at[0] < 0;
}

/* the new body goes before place i of the order */
static void put_in_order(mech *m, int part, int before)
{
    int n = m->nbody, at = n - 1;
    for (; at > 0 && m->order[at - 1] != before; at--) {
        m->order[at] = m->order[at - 1];
    }
    m->order[at] = m->order[at - 1];
    m->order[at - 1] = part;
}

static void spring(mech *m, int part, double k, double damping)
{
    mech_state(m, m->body[part].law + J_K, k, 0.0);
    mech_state(m, m->body[part].law + J_B, damping, 0.0);
}

static void give_way(mech *m, const effect *e, double compliance, const double *p)
{
    double mass = 0.0;
    int part = mech_body(m, "hidden_axis", -1, 'T', 2, 1);
    body *b = &m->body[e->index];
    for (int i = 0; i < m->nbody; i++) {
        mass += number_of(p, m->body[i].mass);
    }
    memcpy(m->body[part].at, b->at, sizeof b->at);
    b->at[0] = b->at[1] = b->at[2] = -1;
    b->parent = part;
    put_in_order(m, part, e->index);
    spring(m, part, 1.0 / compliance, 2.0 * e->side * sqrt(mass / compliance));
}

static void yield(mech *m, const effect *e, double compliance)
{
    int part = mech_body(m, "hidden_partner", -1, 'T', 2, 1);
    m->body[part].mass = hidden(m, "hidden_partner", "mass", e->side);
    m->contact[e->index].line_body = part;
    spring(m, part, 1.0 / compliance, 2.0 * e->width * sqrt(e->side / compliance));
    // its weight is carried where it is drawn
    mech_state(m, m->body[part].law + J_Q0, -m->gravity[2] * e->side * compliance, 0.0);
}

/* A bar of the lever's mass, centre and inertia is cut: what lies beyond the cut is the part, what
 * is left has the rest of all three. All of it along z. */
static void bend(mech *m, const effect *e, double compliance, const double *p)
{
    body *b = &m->body[e->index];
    int child = child_of(m, e->index);
    double mass = p[b->mass], I = p[b->inertia[1]], c = number_of(p, b->centre[2]);
    double side = c < 0.0 ? -1.0 : 1.0, length = sqrt(12.0 * I / mass);
    double cut = e->width * p[m->body[child].at[2]];
    double end = c + 0.5 * side * length, beyond = fabs(end - cut);
    double mass2 = mass * fmin(beyond / length, 0.8), c2 = 0.5 * (end + cut);
    double I2 = mass2 * beyond * beyond / 12.0, mass1 = mass - mass2;
    double c1 = (mass * c - mass2 * c2) / mass1;
    double I1 = I - I2 - mass1 * (c1 - c) * (c1 - c) - mass2 * (c2 - c) * (c2 - c);
    int part = mech_body(m, "hidden_hinge", e->index, 'R', 1, b->sign);
    body *o = &m->body[part];
    b->mass = hidden(m, "hidden_rest", "mass", mass1);
    b->centre[2] = hidden(m, "hidden_rest", "centre", c1);
    b->inertia[1] = hidden(m, "hidden_rest", "inertia", fmax(I1, 1e-3 * I));
    o->mass = hidden(m, "hidden_hinge", "mass", mass2);
    o->centre[2] = hidden(m, "hidden_hinge", "centre", c2 - cut);
    o->inertia[1] = hidden(m, "hidden_hinge", "inertia", I2);
    o->at[2] = hidden(m, "hidden_hinge", "at", cut);
    for (int i = 0; i < part; i++) {
        body *next = &m->body[i];
        if (next->parent == e->index) {
            next->at[2] = hidden(m, "hidden_hinge", next->name, p[next->at[2]] - cut);
            next->parent = part;
        }
    }
    put_in_order(m, part, child);
    double about_hinge = I2 + mass2 * (c2 - cut) * (c2 - cut);
    spring(m, part, 1.0 / compliance, 2.0 * e->side * sqrt(about_hinge / compliance));
}

const mech *structure_with(mech *room, const mech *m, const effect *e, double size, const double *p,
                           double *q)
{
    memcpy(q, p, sizeof *q * (size_t)m->nnumber);
    if (e->kind->site != 'x') {
        effect_apply(e, m, size, q);
        return m;
    }
    if (room != m) {
        *room = *m;
    }
    switch (e->kind->offset) {
    case HINGE: bend(room, e, size, p); break;
    case AXIS: give_way(room, e, size, p); break;
    default: yield(room, e, size);
    }
    for (int i = m->nnumber; i < room->nnumber; i++) {
        q[i] = room->number[i].value;
    }
    return room;
}
