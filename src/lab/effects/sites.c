/* SPDX-License-Identifier: GPL-3.0-or-later
 * sites.c - where a part can sit, by the geometry of the mechanism as drawn.
 *
 * The rules follow added_parts.c. All lengths are taken from the drawing: every coordinate 0,
 * where the axes of all bodies are parallel.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"

/* ---- geometry, as drawn ---- */

lab__vec lab__at(const mech_scalar at[3])
{
    return (lab__vec){at[0].value, at[2].value};
}

static double along(lab__vec a, lab__vec b)
{
    return a.x * b.x + a.z * b.z;
}

lab__vec lab__drawn(const mechanism *m, int body, lab__vec at)
{
    for (; body >= 0; body = m->bodies[body].parent) {
        lab__vec joint = lab__at(m->bodies[body].at);
        at.x += joint.x;
        at.z += joint.z;
    }
    return at;
}

/* children of a body: the farthest joint on it, else the farthest point that touches something */
static lab__vec carried(const mechanism *m, int body)
{
    lab__vec most = {0.0, 0.0};
    int joints = 0;
    for (int i = 0; i < m->nbody; i++) {
        lab__vec at = lab__at(m->bodies[i].at);
        if (m->bodies[i].parent == body && along(at, at) > along(most, most)) {
            most = at;
            joints++;
        }
    }
    for (int i = 0; joints == 0 && i < m->ncontact; i++) {
        for (int k = 0; k < 2; k++) {
            const mech_shape *s = &m->contacts[i].spot[0].side[k];
            lab__vec at = lab__at(s->at);
            most = s->body == body && along(at, at) > along(most, most) ? at : most;
        }
    }
    return most;
}

int lab__bend(lab__bent *b, const mechanism *m, int index)
{
    const mech_body *body = &m->bodies[index];
    lab__vec to = carried(m, index), c = lab__at(body->centre);
    double reach = sqrt(along(to, to)), out = sqrt(along(c, c));
    double mass = body->mass.value, inertia = body->inertia[1].value;
    if (!(reach > 0.0) || !(mass > 0.0) || !(inertia > 0.0)) {
        return -1;
    }
    b->e = (lab__vec){to.x / reach, to.z / reach};
    double side = out > 0.0 ? along(c, b->e) / out : 0.0;
    if (fabs(side) > 0.3) { // the line through the centre
        b->e = (lab__vec){c.x / out * (side > 0.0 ? 1.0 : -1.0),
                          c.z / out * (side > 0.0 ? 1.0 : -1.0)};
    }
    double carries = along(to, b->e), at = LAB__BEND * carries,
           length = sqrt(12.0 * inertia / mass);
    double beyond = along(c, b->e) + 0.5 * length - at, f = beyond / length;
    if (!(f > 0.05 && f < 0.95)) {
        return -1;
    }
    b->at = (lab__vec){at * b->e.x, at * b->e.z};
    b->link = (lab__vec){carries * b->e.x, carries * b->e.z};
    b->apart = (lab__vec){0.5 * length * b->e.x, 0.5 * length * b->e.z};
    b->mass = f;
    return 0;
}

int lab__is_beyond(const lab__bent *b, lab__vec at)
{
    return along(at, b->e) > along(b->at, b->e);
}

/* ---- ranges ---- */

/* a number as one would write it on a drawing */
static double rounded(double value)
{
    char text[LAB_NUMBER];
    snprintf(text, sizeof text, "%.3g", value);
    return strtod(text, NULL);
}

void lab__set_range(lab_side *to, double lo, double middle, double hi)
{
    to->lo = rounded(lo), to->value = rounded(middle), to->hi = rounded(hi);
    to->log = lo > 0.0;
}

/* ---- sites ---- */

static int find_name(const mechanism *m, const char *name)
{
    for (int i = 0; i < m->nbody; i++) {
        if (strcmp(m->bodies[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

static int taken(const mechanism *m, const char *name)
{
    int found = find_name(m, name) >= 0;
    for (int i = 0; i < m->ncontact; i++) {
        found |= strcmp(m->contacts[i].name, name) == 0;
    }
    for (int i = 0; i < m->nlink; i++) {
        found |= strcmp(m->links[i].name, name) == 0;
    }
    return found;
}

/* does this body carry the stroke? */
static int works(const mechanism *m, int body)
{
    if (body == m->load_body) {
        return 0;
    }
    if (m->stroke_string < 0) {
        return 1;
    }
    for (int k = 0; k < 2; k++) {
        int up = m->contacts[m->stroke_string].spot[0].side[k].body;
        while (up >= 0 && up != body) {
            up = m->bodies[up].parent;
        }
        if (up == body) {
            return 1;
        }
    }
    return 0;
}

/* a number of the file under its own name */
static int is_own(const mechanism *m, mech_scalar s, const char *owner, const char *path)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.%s", owner, path);
    return s.kind == MECH_PARAM && strcmp(m->params[s.index].name, name) == 0;
}

static int can_bend(const mechanism *m, int i, lab__site *site)
{
    lab__bent b;
    const mech_body *body = &m->bodies[i];
    lab__vec to = carried(m, i);
    site->reach = sqrt(along(to, to));
    return works(m, i) && body->type == 'R' && body->axis == 'y' && !body->part &&
           is_own(m, body->mass, body->name, "mass") &&
           is_own(m, body->inertia[1], body->name, "inertia.yy") && lab__bend(&b, m, i) == 0;
}

static int can_lift(const mechanism *m, int i, lab__site *site)
{
    const mech_body *body = &m->bodies[i];
    site->reach = 0.0;
    return works(m, i) && body->parent < 0 && body->type == 'R' && body->axis == 'y' &&
           body->mass.value > 0.0;
}

/* axis along which a line's normal points, ' ' when it is oblique */
char lab__normal_axis(double facing)
{
    double c = fabs(cos(facing)), s = fabs(sin(facing));
    if (s < 1e-9) {
        return 'x';
    }
    return "z "[c >= 1e-9];
}

static int can_give(const mechanism *m, int i, lab__site *site)
{
    const mech_contact *c = &m->contacts[i];
    const mech_shape *line = &c->spot[0].side[1], *point = &c->spot[0].side[0];
    lab__vec at = lab__at(point->at);
    site->body = point->body;
    site->reach = sqrt(along(at, at));
    return c->nspot == 1 && i != m->load_contact && line->is_line && !line->solid &&
           line->body < 0 && point->body >= 0 && lab__normal_axis(line->facing.value) != ' ';
}

/* the point where the load stands or the first input pushes; -1 */
int lab__load_point(const mechanism *m)
{
    for (int i = 0; m->load_contact >= 0 && i < m->npoint; i++) {
        const mech_shape *s = &m->contacts[m->load_contact].spot[0].side[0];
        const mech_scalar *at = m->points[i].at;
        int same = m->points[i].body == s->body;
        for (int k = 0; k < 3; k++) {
            same &= at[k].kind == s->at[k].kind && at[k].index == s->at[k].index;
        }
        if (same) {
            return i;
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        if (m->inputs[i].kind == STEIN_INPUT_POINT) {
            return m->inputs[i].index;
        }
    }
    return -1;
}

static int can_hang(const mechanism *m, int i, lab__site *site)
{
    int point = lab__load_point(m);
    if (point < 0 || m->points[point].body != i) {
        return 0;
    }
    lab__vec at = lab__at(m->points[point].at);
    site->reach = sqrt(along(at, at));
    return site->reach > 0.0 && m->bodies[i].type == 'R' && m->bodies[i].axis == 'y';
}

/* Does a motor act in the joint? An input of a torque, a force or a voltage does; a prescribed
 * motion does where its force is an output. The strokes of an action are driven by hand. */
static int is_driven(const mechanism *m, int body)
{
    int yes = 0;
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *in = &m->inputs[i];
        int here = in->kind != STEIN_INPUT_POINT && in->index == body, motion = 0;
        for (int k = 0; k < m->nchannel; k++) {
            motion |= m->channels[k].read == STEIN_READ_INPUT_FORCE && m->channels[k].index == i;
        }
        yes |= here && (in->kind != STEIN_INPUT_MOTION || motion);
    }
    return yes && m->stroke_string < 0;
}

static int can_gear(const mechanism *m, int i)
{
    return i != m->load_body && m->bodies[i].armature.kind == MECH_ZERO && is_driven(m, i);
}

const char *lab__same_as_armature(const mechanism *m, int i)
{
    static const char *const about[] = {"inertia.xx", "inertia.yy", "inertia.zz"};
    const mech_body *b = &m->bodies[i];
    int axis = b->axis - 'x', above = 0;
    for (int k = b->parent; k >= 0; k = m->bodies[k].parent) {
        above |= m->bodies[k].type == 'R' || b->type == 'T';
    }
    if (b->type == 'R') {
        return !above && is_own(m, b->inertia[axis], b->name, about[axis]) ? about[axis] : NULL;
    }
    int level = m->gravity[axis].value == 0.0;
    return !above && level && is_own(m, b->mass, b->name, "mass") ? "mass" : NULL;
}

void lab__note_armatures(lab_candidate *list, int n, const stein_model *m)
{
    for (int i = 0; i < n; i++) {
        int rotor = strcmp(list[i].effect->kind, "armature") == 0;
        for (int k = 0; rotor && list[i].alias[0] != '\0' && k < n; k++) {
            lab_candidate *c = &list[k];
            int same = c->nparam == 1 && strcmp(m->params[c->param[0]].name, list[i].alias) == 0;
            size_t length = strlen(c->alias);
            if (same && length + strlen(list[i].place) + 11 < sizeof c->alias) {
                snprintf(c->alias + length, sizeof c->alias - length, "%s%s.armature",
                         length > 0 ? " " : "", list[i].place);
            }
        }
    }
}

int lab__sites(const mechanism *m, const char *kind, lab__site site[LAB_SITES])
{
    int contacts = strcmp(kind, "compliant_partner") == 0, found = 0;
    for (int i = 0; found < LAB_SITES && i < (contacts ? m->ncontact : m->nbody); i++) {
        lab__site *here = &site[found];
        char name[MECH_NAME];
        const char *place = contacts ? m->contacts[i].name : m->bodies[i].name;
        *here = (lab__site){.body = i, .contact = contacts ? i : -1};
        snprintf(here->place, sizeof here->place, "%s", place);
        if (lab__part_name(kind, place, name) != 0) {
            return 0;
        }
        int can = !contacts && m->bodies[i].ball          ? 0
                  : contacts                              ? can_give(m, i, here)
                  : strcmp(kind, "armature") == 0         ? can_gear(m, i)
                  : strcmp(kind, "elastic_hinge") == 0    ? can_bend(m, i, here)
                  : strcmp(kind, "axis_translation") == 0 ? can_lift(m, i, here)
                                                          : can_hang(m, i, here);
        found += can && (strcmp(name, place) == 0 || !taken(m, name));
    }
    return found;
}
