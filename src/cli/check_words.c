/* SPDX-License-Identifier: GPL-3.0-or-later
 * check_words.c - the parts of a mechanism as words, for the text and the JSON of stein check.
 */
#include "checking.h"

const char *check__body_name(const mechanism *m, int body)
{
    return body < 0 ? "frame" : m->bodies[body].name;
}

/* how many bodies the file has: joints of a ball but the last are not listed */
int check__number_of_bodies(const mechanism *m)
{
    int n = 0;
    for (int i = 0; i < m->nbody; i++) {
        n += !m->bodies[i].lead;
    }
    return n;
}

/* Degrees of freedom of a tree with balls: its coordinates without the charts. @return 0 for a
 * mechanism without balls, or with loops */
int check__tree_freedom(const mechanism *m)
{
    int n = m->nbody, balls = 0;
    for (int i = 0; i < m->nbody; i++) {
        balls += m->bodies[i].ball == 1;
    }
    for (int i = 0; i < m->ninput; i++) {
        n -= m->inputs[i].kind == STEIN_INPUT_MOTION && m->inputs[i].hold;
    }
    return balls > 0 && m->nloop == 0 ? n - balls : 0;
}

/* parent of a body in the file */
const char *check__parent_name(const mechanism *m, int body)
{
    int up = m->bodies[body].parent;
    while (up >= 0 && m->bodies[up].lead) {
        up = m->bodies[up].parent;
    }
    return check__body_name(m, up);
}

/* "R y", "T -z", "ball", "free" */
const char *check__joint_text(char text[8], const mech_body *b)
{
    if (b->ball) {
        return b->free ? "free" : "ball";
    }
    snprintf(text, 8, "%c %s%c", b->type, b->sign < 0 ? "-" : "", b->axis);
    return text;
}

const char *check__shape_text(const mech_shape *s)
{
    int point = s->radius.kind == MECH_ZERO;
    if (s->solid != MECH_FLAT) {
        return s->corner                ? "corners of box"
               : s->solid == MECH_PLANE ? "plane"
               : point                  ? "point"
                                        : "sphere";
    }
    return s->end != 0 ? "end of line" : s->is_line ? "line" : point ? "point" : "circle";
}

/* element of an input or output */
const char *check__input_target(const mechanism *m, const mech_input *in)
{
    return in->kind == STEIN_INPUT_POINT ? m->points[in->index].name : m->bodies[in->index].name;
}

const char *check__input_kind(int kind)
{
    static const char *const name[] = {"torque", "force", "motion", "voltage"};
    return name[kind];
}

/* element of an output; energies are those of the mechanism */
const char *check__target_or_all(const mechanism *m, const mech_channel *c)
{
    const char *name = mech_target(m, c);
    return *name != '\0' ? name : m->name;
}

const char *check__output_kind(int read)
{
    const mech_output_kind *kind = mech_output_kind_of(read);
    return kind->of == MECH_AN_ENERGY ? kind->about : kind->word;
}

/* the generated functions in the order they are listed */
const char *const check__counted_key[COUNTED] = {
    "M_c",   "M_c_unloaded", "inverse_dynamics", "setup",       "solution", "articulated",
    "poses", "points",       "energy",           "derivatives", "loops",    "poses_in_space"};
const char *const check__counted_note[COUNTED] = {"with a force and a moment on every body",
                                                  "every evaluation",
                                                  "likewise with forces and moments",
                                                  "once a parameter set",
                                                  "of M qdd = Q - c",
                                                  "qdd without M, in place of both",
                                                  "bodies with contacts",
                                                  "all named points, with Jacobians",
                                                  "kinetic and potential",
                                                  "of M qdd + c by all q and qd",
                                                  "h, J and Jdot qd of loops and couplings",
                                                  "bodies with contacts in space"};

stein_ops check__counted(const gen_result *g, int i)
{
    const stein_ops ops[COUNTED] = {g->mass_bias, g->unloaded,    g->inverse, g->setup,
                                    g->solve,     g->articulated, g->pose,    g->point,
                                    g->energy,    g->slopes,      g->closure, g->pose3};
    return ops[i];
}

/* has this entry of a law an effect? */
int check__acts(const mech_scalar *law, int entry)
{
    return law[entry].kind == MECH_FORMULA || law[entry].value != 0.0;
}

const char *check__friction_text(const mech_scalar *law, int level, int sticks)
{
    return !check__acts(law, level) ? "" : sticks ? ", friction that sticks" : ", friction";
}

/* argument and place of a table */
const char *check__table_of(const mech_table *t)
{
    static const char *const of[] = {"position", "speed", "depth", "rate"};
    return of[t->kind];
}

const char *check__table_place(const mechanism *m, const mech_table *t)
{
    return t->kind <= STEIN_TABLE_SPEED ? m->bodies[t->index].name
           : t->index < m->ncontact     ? m->contacts[t->index].name
                                        : m->notches[t->index - m->ncontact].name;
}
