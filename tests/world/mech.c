/* SPDX-License-Identifier: GPL-3.0-or-later
 * mech.c - mechanisms put together, and the names of their numbers.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

static const double rough_length = 0.006; /* relative error of a length, before it is drawn */

void mech_start(mech *m, const char *name, const char *about)
{
    memset(m, 0, sizeof *m);
    snprintf(m->name, NAME, "%s", name);
    m->about = about;
    m->gravity[2] = -9.81;
    m->dt = 1e-4;
    m->duration[0] = 3.0, m->duration[1] = 8.0;
    m->clock = mech_number(m, "clock", "error", "1", "", 1.0, 0.0, 0.0);
    m->number[m->clock].stated = 0;
}

int mech_number(mech *m, const char *owner, const char *what, const char *unit, const char *shown,
                double scale, double value, double sd)
{
    if (m->nnumber == NUMBERS) {
        fprintf(stderr, "world: too many numbers in %s\n", m->name);
        exit(1);
    }
    number *n = &m->number[m->nnumber];
    char name[NAME]; // owner may be a part of *m
    snprintf(name, NAME, "%.31s.%.30s", owner, what);
    memcpy(n->name, name, NAME);
    n->unit = unit, n->shown = shown, n->scale = scale;
    n->value = n->file = value;
    n->sd = sd * fabs(value);
    n->stated = 1;
    return m->nnumber++;
}

/* a number that the file leaves out */
static int neutral(mech *m, const char *owner, const char *what, const char *unit, double value)
{
    int k = mech_number(m, owner, what, unit, unit, 1.0, value, 0.0);
    m->number[k].stated = 0;
    return k;
}

int mech_length(mech *m, const char *owner, const char *what, double value)
{
    return fabs(value) > 0.0 ? mech_number(m, owner, what, "m", "mm", 1e-3, value, rough_length)
                             : -1;
}

void mech_state(mech *m, int index, double value, double sd)
{
    number *n = &m->number[index];
    n->value = n->file = value;
    n->sd = sd * fabs(value);
    n->stated = 1;
}

static int joint_law(mech *m, const char *name, int turns)
{
    const struct {
        const char *what, *turning, *sliding;
        double value;
    } law[J_SIZE] = {
        {"spring.k", "N m/rad", "N/m", 0.0},
        {turns ? "spring.theta0" : "spring.x0", "rad", "m", 0.0},
        {"spring.k3", "N m/rad^3", "N/m^3", 0.0},
        {"damping", "N m s/rad", "N s/m", 0.0},
        {"asymmetry", "1", "1", 0.0},
        {"drag", "N m s^2/rad^2", "N s^2/m^2", 0.0},
        {"preload", "N m", "N", 0.0},
        {"coulomb.T", "N m", "N", 0.0},
        {"coulomb.w", "rad/s", "m/s", 0.05},
        {"coulomb.asymmetry", "1", "1", 0.0},
        {"backlash.k", "N m/rad", "N/m", 0.0},
        {"backlash.gap", "rad", "m", 0.1},
        {"friction.A", "N m", "N", 0.0},
        {"friction.vt", "rad/s", "m/s", 0.05},
        {"friction.B1", "1", "1", 0.0},
        {"friction.B2", "1", "1", 0.0},
        {"outside.bump", "N m", "N", 0.0},
        {"outside.bump_at", "rad", "m", 0.0},
        {"outside.bump_width", "rad", "m", 1.0},
        {"outside.ripple", "N m", "N", 0.0},
        {"outside.ripple_length", "rad", "m", 1.0},
        {"outside.root", "N m", "N", 0.0},
        {"outside.root_speed", "rad/s", "m/s", 1.0},
    };
    int first = m->nnumber;
    for (int i = 0; i < J_SIZE; i++) {
        neutral(m, name, law[i].what, turns ? law[i].turning : law[i].sliding, law[i].value);
    }
    return first;
}

int mech_body(mech *m, const char *name, int parent, char type, int axis, int sign)
{
    body *b = &m->body[m->nbody];
    snprintf(b->name, NAME, "%s", name);
    b->parent = parent, b->type = type, b->axis = axis, b->sign = sign;
    b->mass = -1;
    for (int i = 0; i < 3; i++) {
        b->at[i] = b->centre[i] = b->inertia[i] = -1;
    }
    b->law = joint_law(m, name, type == 'R');
    m->order[m->nbody] = m->nbody;
    return m->nbody++;
}

void mech_mass(mech *m, int i, double mass, double x, double z)
{
    body *b = &m->body[i];
    b->mass = mech_number(m, b->name, "mass", "kg", "g", 1e-3, mass, 0.005);
    b->centre[0] = mech_length(m, b->name, "centre.x", x);
    b->centre[2] = mech_length(m, b->name, "centre.z", z);
}

void mech_inertia(mech *m, int i, double xx, double yy, double zz)
{
    static const char *const what[] = {"inertia.xx", "inertia.yy", "inertia.zz"};
    double value[] = {xx, yy, zz};
    body *b = &m->body[i];
    for (int k = 0; k < 3; k++) {
        if (value[k] > 0.0) {
            b->inertia[k] =
                mech_number(m, b->name, what[k], "kg m^2", "kg m^2", 1.0, value[k], 0.015);
        }
    }
}

void mech_at(mech *m, int i, double x, double z)
{
    m->body[i].at[0] = mech_length(m, m->body[i].name, "at.x", x);
    m->body[i].at[2] = mech_length(m, m->body[i].name, "at.z", z);
}

int mech_point(mech *m, const char *name, int on, double x, double z)
{
    char what[NAME];
    const char *owner = on < 0 ? "frame" : m->body[on].name;
    point *p = &m->point[m->npoint];
    snprintf(p->name, NAME, "%s", name);
    p->body = on;
    p->at[1] = -1;
    snprintf(what, sizeof what, "%.28s.x", name);
    p->at[0] = mech_length(m, owner, what, x);
    snprintf(what, sizeof what, "%.28s.z", name);
    p->at[2] = mech_length(m, owner, what, z);
    return m->npoint++;
}

static int contact_law(mech *m, const char *name)
{
    static const struct {
        const char *what, *unit;
        double value;
    } law[N_SIZE] = {
        {"normal.a", "N/m^3", 0.0},   {"normal.b", "N/m^2", 0.0}, {"normal.c", "N/m", 0.0},
        {"normal.D", "s/m", 0.0},     {"normal.p", "1", 0.0},     {"normal.h", "1", 0.0},
        {"normal.F0", "N", 0.0},      {"gap", "m", 0.0},          {"adhesion.F", "N", 0.0},
        {"adhesion.range", "m", 0.0}, {"friction.A", "1", 0.0},   {"friction.vt", "m/s", 0.01},
        {"friction.B1", "1", 0.0},    {"friction.B2", "1", 0.0},
    };
    int first = m->nnumber;
    for (int i = 0; i < N_SIZE; i++) {
        neutral(m, name, law[i].what, law[i].unit, law[i].value);
    }
    return first;
}

int mech_contact(mech *m, const char *name, int a, int b, double radius_a, double radius_b)
{
    contact *c = &m->contact[m->ncontact];
    snprintf(c->name, NAME, "%s", name);
    c->point[0] = a, c->point[1] = b;
    c->radius[0] = mech_length(m, name, "circle.radius", radius_a);
    c->radius[1] = b < 0 ? -1 : mech_length(m, name, "circle2.radius", radius_b);
    c->line_at[0] = c->line_at[1] = c->facing = -1;
    c->line_body = -1;
    c->law = contact_law(m, name);
    return m->ncontact++;
}

void mech_line(mech *m, int i, int on, double x, double z, double degrees)
{
    static const double degree = 3.14159265358979323846 / 180.0;
    contact *c = &m->contact[i];
    c->line_body = on;
    c->line_at[0] = mech_length(m, c->name, "line.x", x);
    c->line_at[1] = mech_length(m, c->name, "line.z", z);
    c->facing = mech_number(m, c->name, "line.facing", "rad", "deg", degree, degrees * degree, 0.0);
}

int mech_link(mech *m, const char *name, int a, int b, double k, double length)
{
    link *l = &m->link[m->nlink];
    snprintf(l->name, NAME, "%s", name);
    l->point[0] = a, l->point[1] = b;
    l->law = mech_number(m, name, "k", "N/m", "N/m", 1.0, k, 0.02);
    mech_number(m, name, "length", "m", "mm", 1e-3, length, rough_length);
    neutral(m, name, "damping", "N s/m", 0.0);
    neutral(m, name, "slack", "1", 0.0);
    return m->nlink++;
}

int mech_input(mech *m, const char *name, int type, int index)
{
    input *i = &m->input[m->ninput];
    snprintf(i->name, NAME, "%s", name);
    i->kind = type;
    i->point = type == INPUT_FORCE ? index : -1;
    i->body = type == INPUT_FORCE ? m->point[index].body : index;
    int turns = m->body[i->body].type == 'R';
    i->unit = type == INPUT_FORCE    ? "N"
              : type == INPUT_MOTION ? (turns ? "rad" : "m")
                                     : (turns ? "N m" : "N");
    i->law = neutral(m, name, "gain", "1", 1.0);
    neutral(m, name, "delay", "s", 0.0);
    return m->ninput++;
}

int mech_channel(mech *m, const char *name, int read, int index)
{
    channel *c = &m->channel[m->nchannel];
    snprintf(c->name, NAME, "%s", name);
    c->read = read, c->index = index;
    int of_joint = read == READ_POSITION || read == READ_SPEED;
    int turns = of_joint              ? m->body[index].type == 'R'
                : read == READ_EFFORT ? m->body[m->input[index].body].type == 'R'
                                      : 0;
    c->unit = read == READ_EFFORT  ? (turns ? "N m" : "N")
              : read == READ_SPEED ? (turns ? "rad/s" : "m/s")
                                   : (turns ? "rad" : "m");
    c->law = neutral(m, name, "sensor.gain", "1", 1.0);
    neutral(m, name, "sensor.offset", c->unit, 0.0);
    neutral(m, name, "sensor.square", "1", 0.0);
    neutral(m, name, "sensor.tilt", "rad", 0.0);
    neutral(m, name, "sensor.delay", "s", 0.0);
    return m->nchannel++;
}

int mech_find(const mech *m, const char *name)
{
    for (int i = 0; i < m->nnumber; i++) {
        if (strcmp(m->number[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}
