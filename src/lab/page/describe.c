/* SPDX-License-Identifier: GPL-3.0-or-later
 * describe.c - a mechanism for the script of a page: drawing, sliders, inputs and outputs.
 *
 * Numbers of the geometry may follow parameters, so a number is written as
 *
 *      0.0124                      itself
 *      ["p3"]                      parameter 3 of the equations
 *      ["p3", 0.002, "+"]          a formula in postfix order: + - * / neg sin cos tan sqrt
 *
 * and the page works it out for the parameters of the moment. Only parameters of the equations
 * change on the page.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "page.h"

enum { FEW = 3, MOST = 10 }; /* sliders without a section regulation */

typedef struct writer {
    lab__json j;
    const mechanism *m;
    const stein_model *equations;
} writer;

/* ---- numbers ---- */

static void put_param(writer *w, int param)
{
    char name[LAB_NUMBER];
    int at = stein_find_param(w->equations, w->m->params[param].name);
    if (at < 0) {
        lab__json_real(&w->j, NULL, w->m->params[param].value);
    } else {
        snprintf(name, sizeof name, "p%d", at);
        lab__json_text(&w->j, NULL, name);
    }
}

static void put_step(writer *w, const mech_step *step)
{
    static const char *const name[] = {"",    "",    "+",   "-",   "*",   "/",
                                       "neg", "sin", "cos", "tan", "sqrt"};
    if (step->op == MECH_OP_CONST) {
        lab__json_real(&w->j, NULL, step->value);
    } else if (step->op == MECH_OP_PARAM) {
        put_param(w, step->param);
    } else {
        lab__json_text(&w->j, NULL, name[step->op]);
    }
}

static void put(writer *w, const char *key, mech_scalar s)
{
    if (s.kind == MECH_ZERO) {
        lab__json_real(&w->j, key, 0.0);
        return;
    }
    lab__json_open(&w->j, key, '[');
    if (s.kind == MECH_PARAM) {
        put_param(w, s.index);
    } else {
        const mech_formula *f = &w->m->formulas[s.index];
        for (int i = 0; i < f->nsteps; i++) {
            put_step(w, &f->steps[i]);
        }
    }
    lab__json_close(&w->j);
}

static void put_vector(writer *w, const char *key, const mech_scalar v[3])
{
    lab__json_open(&w->j, key, '[');
    for (int i = 0; i < 3; i++) {
        put(w, NULL, v[i]);
    }
    lab__json_close(&w->j);
}

/* ---- parts ---- */

static void put_bodies(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "bodies", '[');
    for (int i = 0; i < w->m->nbody; i++) {
        const mech_body *b = &w->m->bodies[i];
        char type[] = {b->type, '\0'}, axis[] = {b->axis, '\0'};
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", b->name);
        lab__json_int(j, "parent", b->parent);
        lab__json_text(j, "type", type);
        lab__json_text(j, "axis", axis);
        lab__json_int(j, "sign", b->sign);
        lab__json_bool(j, "load", i == w->m->load_body);
        put_vector(w, "at", b->at);
        put(w, "mass", b->mass);
        put_vector(w, "centre", b->centre);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void put_points(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "points", '[');
    for (int i = 0; i < w->m->npoint; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", w->m->points[i].name);
        lab__json_int(j, "body", w->m->points[i].body);
        put_vector(w, "at", w->m->points[i].at);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "links", '[');
    for (int i = 0; i < w->m->nlink; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_int(j, "from", w->m->links[i].point[0]);
        lab__json_int(j, "to", w->m->links[i].point[1]);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* pairs of points that a loop holds together; joints that follow another one are none */
static void put_loops(writer *w)
{
    static const char *const kind[] = {"meet", "rod", "slot", "weld"};
    lab__json *j = &w->j;
    lab__json_open(j, "loops", '[');
    for (int i = 0; i < w->m->nloop; i++) {
        const mech_loop *l = &w->m->loops[i];
        if (l->kind == MECH_COUPLING) {
            continue;
        }
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "kind", kind[l->kind]);
        lab__json_int(j, "from", l->index[0]);
        lab__json_int(j, "to", l->index[1]);
        lab__json_int(j, "axis", l->axis);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void put_shape(writer *w, const mech_shape *s)
{
    lab__json *j = &w->j;
    lab__json_open(j, NULL, '{');
    lab__json_int(j, "body", s->body);
    put_vector(w, "at", s->at);
    if (s->is_line) {
        put(w, "facing", s->facing);
        if (s->has_extent) {
            lab__json_open(j, "extent", '[');
            put(w, NULL, s->extent[0]);
            put(w, NULL, s->extent[1]);
            lab__json_close(j);
        }
        if (s->end != 0) {
            lab__json_int(j, "end", s->end);
        }
    } else {
        put(w, "radius", s->radius);
    }
    lab__json_close(j);
}

static void put_contacts(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "contacts", '[');
    for (int i = 0; i < w->m->ncontact; i++) {
        const mech_contact *c = &w->m->contacts[i];
        lab__json_open(j, NULL, '{');
        lab__json_bool(j, "load", i == w->m->load_contact);
        lab__json_open(j, "spots", '[');
        for (int k = 0; k < c->nspot; k++) {
            lab__json_open(j, NULL, '[');
            put_shape(w, &c->spot[k].side[0]);
            put_shape(w, &c->spot[k].side[1]);
            lab__json_close(j);
        }
        lab__json_close(j);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void put_notches(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "notches", '[');
    for (int i = 0; i < w->m->nnotch; i++) {
        const mech_notch *k = &w->m->notches[i];
        lab__json_open(j, NULL, '{');
        lab__json_int(j, "catcher", k->catcher);
        lab__json_int(j, "beak", k->beak);
        put_vector(w, "corner", k->corner);
        put(w, "lean", k->lean);
        put(w, "angle", k->angle);
        put_vector(w, "end", k->end);
        put(w, "tilt", k->tilt);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* ---- inputs and outputs ---- */

static void put_inputs(writer *w)
{
    static const char *const kind[] = {"joint", "point", "motion", "voltage"};
    lab__json *j = &w->j;
    lab__json_open(j, "inputs", '[');
    for (int i = 0; i < w->m->ninput; i++) {
        const mech_input *in = &w->m->inputs[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", in->name);
        lab__json_text(j, "unit", in->unit);
        lab__json_text(j, "kind", kind[in->kind]);
        lab__json_int(j, "index", in->index);
        if (in->kind == STEIN_INPUT_POINT) {
            put_vector(w, "direction", in->direction);
        }
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void put_channels(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "channels", '[');
    for (int i = 0; i < w->equations->nchannel; i++) {
        const stein_channel *c = &w->equations->channels[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", c->name);
        lab__json_text(j, "unit", c->unit);
        lab__json_text(j, "read",
                       stein_reads_attitude((int)c->read)
                           ? "attitude"
                           : mech_output_kind_of((int)c->read)->name);
        lab__json_int(j, "index", c->index);
        lab__json_int(j, "sign", c->sign);
        lab__json_bool(j, "rest", c->from_rest);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* ---- sliders ---- */

static void put_dial(writer *w, int param, const char *label, double from, double to)
{
    lab__json *j = &w->j;
    int at = stein_find_param(w->equations, w->m->params[param].name);
    if (at < 0) {
        return;
    }
    double value = w->equations->params[at].value;
    lab__json_open(j, NULL, '{');
    lab__json_int(j, "param", at);
    lab__json_text(j, "name", w->m->params[param].name);
    lab__json_text(j, "label", label);
    lab__json_text(j, "unit", w->m->params[param].unit);
    lab__json_real(j, "from", fmin(from, value));
    lab__json_real(j, "to", fmax(to, value));
    lab__json_close(j);
}

/* Without a section `regulation`: the file's own parameters; if these are few, those that are known
 * within a tolerance; if they still are, the first that are stated. Half and one and a half times
 * their values. */
static int round_of(const mech_param *p)
{
    return p->declared ? 0 : p->tolerance > 0.0 ? 1 : p->stated ? 2 : 3;
}

static void choose_dials(writer *w)
{
    const mechanism *m = w->m;
    for (int round = 0, n = 0; round < 3 && n < FEW; round++) {
        for (int i = 0; i < m->nparam && n < MOST; i++) {
            const mech_param *p = &m->params[i];
            double half = fmax(0.5 * fabs(p->value), 5.0 * p->tolerance);
            if (round_of(p) == round && half > 0.0 &&
                stein_find_param(w->equations, p->name) >= 0) {
                put_dial(w, i, p->name, p->value - half, p->value + half);
                n++;
            }
        }
    }
}

static void put_dials(writer *w)
{
    lab__json_open(&w->j, "dials", '[');
    for (int i = 0; i < w->m->ndial; i++) {
        const mech_dial *d = &w->m->dials[i];
        put_dial(w, d->param, d->label, d->from, d->to);
    }
    if (w->m->ndial == 0) {
        choose_dials(w);
    }
    lab__json_close(&w->j);
}

static void put_abouts(writer *w)
{
    lab__json *j = &w->j;
    lab__json_open(j, "abouts", '[');
    for (int i = 0; i < w->m->nabout; i++) {
        const mech_about *a = &w->m->abouts[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "section", a->section);
        lab__json_text(j, "entry", a->entry);
        lab__json_text(j, "text", a->text);
        lab__json_close(j);
    }
    lab__json_close(j);
}

void page__describe(FILE *stream, const lab_model *model, const char *hash)
{
    const mechanism *m = lab__mechanism(model);
    const stein_model *equations = lab_equations(model);
    writer w = {.j = {.stream = stream}, .m = m, .equations = equations};
    lab__json *j = &w.j;
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "name", m->name);
    lab__json_text(j, "version", STEIN_VERSION);
    lab__json_text(j, "equations", equations->equations);
    lab__json_text(j, "hash", hash);
    lab__json_real(j, "dt", equations->dt);
    lab__json_real(j, "until", equations->until);
    lab__json_int(j, "integrator", equations->integrator);
    lab__json_int(j, "settle", equations->settle);
    lab__json_int(j, "string", m->stroke_string);
    lab__json_int(j, "notch", m->stroke_notch);
    lab__json_reals(j, "values", lab_parameters(model), equations->np);
    put_dials(&w);
    put_bodies(&w);
    put_points(&w);
    put_loops(&w);
    put_contacts(&w);
    put_notches(&w);
    put_inputs(&w);
    put_channels(&w);
    put_abouts(&w);
    lab__json_close(j);
}
