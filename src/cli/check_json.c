/* SPDX-License-Identifier: GPL-3.0-or-later
 * check_json.c - stein check --json: all that a mechanism file holds, for programs.
 */
#include "checking.h"

static void json_bodies(lab__json *j, const mechanism *m)
{
    lab__json_open(j, "bodies", '[');
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        char joint[8];
        if (b->lead) {
            continue;
        }
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", b->name);
        lab__json_text(j, "parent", check__parent_name(m, i));
        lab__json_text(j, "joint", check__joint_text(joint, b));
        lab__json_real(j, "mass", b->mass.value);
        lab__json_bool(j, "spring", check__acts(b->joint, STEIN_JOINT_K));
        lab__json_bool(j, "damping", check__acts(b->joint, STEIN_JOINT_B));
        lab__json_bool(j, "friction", check__acts(b->joint, STEIN_JOINT_FRICTION));
        lab__json_bool(j, "sticks", b->sticks);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "parameters", '[');
    for (int i = 0; i < m->nparam; i++) {
        const mech_param *p = &m->params[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", p->name);
        lab__json_text(j, "unit", p->unit);
        lab__json_real(j, "value", p->value);
        lab__json_real(j, "tolerance", p->tolerance);
        lab__json_bool(j, "stated", p->stated);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void json_tables(lab__json *j, const mechanism *m)
{
    lab__json_open(j, "tables", '[');
    for (int i = 0; i < m->ntable; i++) {
        const mech_table *t = &m->tables[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", t->name);
        lab__json_text(j, "place", check__table_place(m, t));
        lab__json_text(j, "of", check__table_of(t));
        lab__json_int(j, "points", t->n);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void json_regulation(lab__json *j, const mechanism *m)
{
    lab__json_open(j, "regulation", '[');
    for (int i = 0; i < m->ndial; i++) {
        const mech_dial *d = &m->dials[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", m->params[d->param].name);
        lab__json_text(j, "label", d->label);
        lab__json_real(j, "from", d->from);
        lab__json_real(j, "to", d->to);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void json_contacts(lab__json *j, const mechanism *m)
{
    lab__json_open(j, "contacts", '[');
    for (int i = 0; i < m->ncontact; i++) {
        const mech_contact *c = &m->contacts[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", c->name);
        lab__json_open(j, "between", '[');
        for (int k = 0; k < 2; k++) {
            lab__json_open(j, NULL, '{');
            lab__json_text(j, "shape", check__shape_text(&c->spot[0].side[k]));
            lab__json_text(j, "body", check__body_name(m, c->spot[0].side[k].body));
            lab__json_close(j);
        }
        lab__json_close(j);
        lab__json_int(j, "spots", c->nspot);
        lab__json_bool(j, "friction", check__acts(c->friction.v, STEIN_FRICTION_A));
        lab__json_bool(j, "sticks", c->sticks);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "notches", '[');
    for (int i = 0; i < m->nnotch; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", m->notches[i].name);
        lab__json_text(j, "catcher", check__body_name(m, m->notches[i].catcher));
        lab__json_text(j, "beak", check__body_name(m, m->notches[i].beak));
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "links", '[');
    for (int i = 0; i < m->nlink; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", m->links[i].name);
        lab__json_text(j, "from", m->points[m->links[i].point[0]].name);
        lab__json_text(j, "to", m->points[m->links[i].point[1]].name);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void json_signal(lab__json *j, const char *name, const char *unit, const char *kind,
                        const char *of)
{
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "name", name);
    lab__json_text(j, "unit", unit);
    lab__json_text(j, "kind", kind);
    lab__json_text(j, "of", of);
    lab__json_close(j);
}

static void json_signals(lab__json *j, const mechanism *m)
{
    lab__json_open(j, "points", '[');
    for (int i = 0; i < m->npoint; i++) {
        lab__json_text(j, NULL, m->points[i].name);
    }
    lab__json_close(j);
    lab__json_open(j, "inputs", '[');
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *in = &m->inputs[i];
        json_signal(j, in->name, in->unit, check__input_kind(in->kind), check__input_target(m, in));
    }
    lab__json_close(j);
    lab__json_open(j, "outputs", '[');
    json_signal(j, "time", "s", "time", m->name);
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *c = &m->channels[i];
        json_signal(j, c->name, c->unit, check__output_kind(c->read), check__target_or_all(m, c));
    }
    lab__json_close(j);
}

static void json_operations(lab__json *j, const gen_result *g)
{
    lab__json_open(j, "operations", '{');
    for (int i = 0; i < COUNTED; i++) {
        stein_ops o = check__counted(g, i);
        lab__json_open(j, check__counted_key[i], '{');
        lab__json_int(j, "add", o.add);
        lab__json_int(j, "mul", o.mul);
        lab__json_int(j, "neg", o.neg);
        lab__json_int(j, "div", o.div);
        lab__json_int(j, "trig", o.trig);
        lab__json_int(j, "total", gen_total(o));
        lab__json_close(j);
    }
    lab__json_close(j);
}

int check__json(const checked *c, const cli_args *args)
{
    const mechanism *m = c->m;
    int code = CLI_OK;
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", m->name);
    lab__json_text(&j, "file", m->file);
    lab__json_text(&j, "equations", c->g->equations);
    json_bodies(&j, m);
    json_contacts(&j, m);
    json_tables(&j, m);
    json_signals(&j, m);
    json_regulation(&j, m);
    lab__json_text(&j, "load", m->load_body < 0 ? NULL : m->bodies[m->load_body].name);
    if (m->stroke_string >= 0) {
        lab__json_open(&j, "stroke", '{');
        lab__json_text(&j, "string", m->contacts[m->stroke_string].name);
        lab__json_text(&j, "notch", m->stroke_notch < 0 ? NULL : m->notches[m->stroke_notch].name);
        lab__json_close(&j);
    } else {
        lab__json_null(&j, "stroke");
    }
    lab__json_open(&j, "simulation", '{');
    lab__json_real(&j, "dt", m->dt);
    lab__json_real(&j, "until", m->until);
    lab__json_text(&j, "integrator", mech_integrator(m->integrator));
    lab__json_bool(&j, "settle", m->settle);
    lab__json_close(&j);
    json_operations(&j, c->g);
    if (check__tree_freedom(m) > 0) {
        lab__json_int(&j, "freedom", check__tree_freedom(m));
    }
    code = cli_check_loops(args, m, &j);
    if (code == CLI_OK && args->noperand > 1) {
        code = cli_check_data(args, &j);
    }
    lab__json_close(&j);
    return code;
}
