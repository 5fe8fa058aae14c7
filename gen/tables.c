/* SPDX-License-Identifier: MIT
 * tables.c - the constant tables of the emitted descriptor (include/stein/model.h).
 *
 * Names from the mechanism file appear in string literals, escaped, so that no file can end one.
 */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "functions.h"
#include "gen_internal.h"

static void open_table(text *x, const char *type, const char *name)
{
    text_add(x, "static const stein_%s %s[] = {\n", type, name);
}

static void close_table(text *x)
{
    text_add(x, "};\n\n");
}

static void table_params(text *x, const mechanism *m)
{
    static const char *const range[] = {"STEIN_ANY", "STEIN_NOT_NEGATIVE", "STEIN_POSITIVE",
                                        "STEIN_WEDGE"};
    if (!m->nparam) {
        return;
    }
    open_table(x, "param", "params");
    for (int i = 0; i < m->nparam; i++) {
        char value[32], tolerance[32];
        text_number(value, m->params[i].value);
        text_number(tolerance, m->params[i].tolerance);
        text_add(x, "    {");
        text_literal(x, m->params[i].name);
        text_add(x, ", ");
        text_literal(x, m->params[i].unit);
        text_quiet(x, ", %s, %s, %d, %s", value, tolerance, m->params[i].stated,
                   range[m->params[i].range]);
        text_add(x, "},\n");
    }
    close_table(x);
}

static void table_bodies(text *x, const tree *t, const layout *l)
{
    open_table(x, "body", "bodies");
    for (int i = 0; i < t->n; i++) {
        const mech_body *b = &t->m->bodies[i];
        text_add(x, "    {");
        text_literal(x, b->name);
        text_add(x, ", %d, '%c', '%c', %d, %d},\n", b->parent, b->type, b->axis, b->sign,
                 l->joint[i]);
    }
    close_table(x);
}

static int frame_index(const tree *t, int body)
{
    for (int k = 0; k < t->ncarrier; k++) {
        if (t->carrier[k] == body) {
            return k;
        }
    }
    return -1;
}

static void table_points(text *x, const tree *t, const layout *l)
{
    if (t->m->npoint) {
        open_table(x, "point", "points");
        for (int i = 0; i < t->m->npoint; i++) {
            text_add(x, "    {");
            text_literal(x, t->m->points[i].name);
            text_add(x, ", %d, %d, %d},\n", t->m->points[i].body,
                     frame_index(t, t->m->points[i].body), l->point[i]);
        }
        close_table(x);
    }
    if (t->ncarrier) {
        open_table(x, "frame", "frames");
        for (int k = 0; k < t->ncarrier; k++) {
            text_add(x, "    {%d, %d},\n", t->carrier[k],
                     frame_index(t, t->m->bodies[t->carrier[k]].parent));
        }
        close_table(x);
    }
}

static int solid_index(const tree *t, int body)
{
    int k = t->nsolid - 1;
    while (k >= 0 && t->solid[k] != body) {
        k--;
    }
    return k;
}

static void shape(text *x, const tree *t, const mech_shape *s, int d)
{
    if (s->solid != MECH_FLAT) {
        text_add(x, "{%d, %s, %d}", solid_index(t, s->body),
                 s->solid == MECH_PLANE ? "STEIN_PLANE" : "STEIN_SPHERE", d);
        return;
    }
    text_add(x, "{%d, %s, %d}", frame_index(t, s->body),
             s->is_line && !s->end ? "STEIN_LINE" : "STEIN_CIRCLE", d);
}

static void table_contacts(text *x, const tree *t, const layout *l)
{
    const mechanism *m = t->m;
    if (!m->ncontact) {
        return;
    }
    open_table(x, "contact", "contacts");
    for (int c = 0, first = 0; c < m->ncontact; c++) {
        text_add(x, "    {");
        text_literal(x, m->contacts[c].name);
        text_add(x, ", %d, %d, %d, %d},\n", first, m->contacts[c].nspot, l->normal[c], l->rub[c]);
        first += m->contacts[c].nspot;
    }
    close_table(x);
    open_table(x, "spot", "spots");
    const int *d = l->shape;
    for (int c = 0; c < m->ncontact; c++) {
        for (int k = 0; k < m->contacts[c].nspot; k++, d += 2) {
            text_add(x, "    {%d, {", c);
            shape(x, t, &m->contacts[c].spot[k].side[0], d[0]);
            text_add(x, ", ");
            shape(x, t, &m->contacts[c].spot[k].side[1], d[1]);
            text_add(x, "}},\n");
        }
    }
    close_table(x);
}

static void table_notches(text *x, const tree *t, const layout *l)
{
    const mechanism *m = t->m;
    if (m->nnotch) {
        open_table(x, "notch", "notches");
        for (int i = 0; i < m->nnotch; i++) {
            text_add(x, "    {");
            text_literal(x, m->notches[i].name);
            text_add(x, ", %d, %d, %d, %d, %d},\n", frame_index(t, m->notches[i].catcher),
                     frame_index(t, m->notches[i].beak), l->notch[i], l->notch_normal[i],
                     l->notch_rub[i]);
        }
        close_table(x);
    }
    if (m->nlink) {
        open_table(x, "link", "links");
        for (int i = 0; i < m->nlink; i++) {
            text_add(x, "    {");
            text_literal(x, m->links[i].name);
            text_add(x, ", {%d, %d}, %d},\n", m->links[i].point[0], m->links[i].point[1],
                     l->link[i]);
        }
        close_table(x);
    }
}

static void table_curves(text *x, const tree *t, const layout *l)
{
    static const char *const kind[] = {"STEIN_TABLE_POSITION", "STEIN_TABLE_SPEED",
                                       "STEIN_TABLE_DEPTH", "STEIN_TABLE_RATE"};
    const mechanism *m = t->m;
    if (m->ntable) {
        open_table(x, "table", "curves");
        for (int i = 0; i < m->ntable; i++) {
            const mech_table *k = &m->tables[i];
            text_add(x, "    {");
            text_literal(x, k->name);
            text_add(x, ", %s, %d, %d, %d},\n", kind[k->kind], k->index, k->n, l->table[i]);
        }
        close_table(x);
    }
}

static int limits_of(const mechanism *m)
{
    int n = 0;
    for (int i = 0; i < m->nbody; i++) {
        n += m->bodies[i].limited;
    }
    return n;
}

/* The joints and contact spots whose friction sticks, one row each. @param x  NULL: only count
 * @return how many */
static int add_sticks(text *x, const mechanism *m)
{
    int n = 0, spot = 0;
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].sticks) {
            n++;
            if (x) {
                text_add(x, "    {STEIN_STICK_JOINT, %d},\n", i);
            }
        }
    }
    for (int i = 0; i < m->ncontact; i++) {
        for (int k = 0; k < m->contacts[i].nspot; k++, spot++) {
            if (m->contacts[i].sticks) {
                n++;
                if (x) {
                    text_add(x, "    {STEIN_STICK_SPOT, %d},\n", spot);
                }
            }
        }
    }
    return n;
}

static int balls_of(const mechanism *m)
{
    int n = 0;
    for (int i = 0; i < m->nbody; i++) {
        n += m->bodies[i].ball == 1;
    }
    return n;
}

static void table_sticks(text *x, const mechanism *m)
{
    if (add_sticks(NULL, m)) {
        open_table(x, "stick", "sticks");
        (void)add_sticks(x, m);
        close_table(x);
    }
}

static void table_balls(text *x, const tree *t)
{
    const mechanism *m = t->m;
    if (balls_of(m)) {
        open_table(x, "ball", "balls");
        for (int i = 0; i < m->nbody; i++) {
            if (m->bodies[i].ball == 1) {
                text_add(x, "    {%d},\n", i);
            }
        }
        close_table(x);
    }
    if (t->nsolid) {
        open_table(x, "frame", "frames3");
        for (int k = 0; k < t->nsolid; k++) {
            text_add(x, "    {%d, %d},\n", t->solid[k],
                     solid_index(t, m->bodies[t->solid[k]].parent));
        }
        close_table(x);
    }
}

static void table_loops(text *x, const tree *t, const layout *l)
{
    if (limits_of(t->m)) {
        open_table(x, "limit", "limits");
        for (int i = 0; i < t->n; i++) {
            if (t->m->bodies[i].limited) {
                text_add(x, "    {%d, %d},\n", i, l->limit[i]);
            }
        }
        close_table(x);
    }
    if (t->m->nloop) {
        open_table(x, "loop", "loops");
        for (int i = 0; i < t->m->nloop; i++) {
            int lengths, angles;
            loop_units(t, i, &lengths, &angles);
            text_add(x, "    {");
            text_literal(x, t->m->loops[i].name);
            text_add(x, ", %d, %d},\n", lengths, angles);
        }
        close_table(x);
    }
}

/* "STEIN_READ_NOTCH_FORCE" */
static void add_read(text *x, int read)
{
    text_add(x, "STEIN_READ_");
    for (const char *c = mech_output_kind_of(read)->name; *c != '\0'; c++) {
        text_add(x, "%c", toupper((unsigned char)*c));
    }
}

static void table_signals(text *x, const tree *t, const layout *l)
{
    static const char *const kind[] = {"STEIN_INPUT_JOINT", "STEIN_INPUT_POINT",
                                       "STEIN_INPUT_MOTION", "STEIN_INPUT_VOLTAGE"};
    const mechanism *m = t->m;
    if (m->ninput) {
        open_table(x, "input", "inputs");
        for (int i = 0; i < m->ninput; i++) {
            const mech_input *k = &m->inputs[i];
            text_add(x, "    {");
            text_literal(x, k->name);
            text_add(x, ", ");
            text_literal(x, k->unit);
            text_add(x, ", %s, %d, %d, %d, %d},\n", kind[k->kind], k->index, l->direction[i],
                     l->signal[i], k->hold);
        }
        close_table(x);
    }
    int reactions = 0;
    open_table(x, "channel", "channels");
    text_add(x, "    {\"time\", \"s\", STEIN_READ_TIME, 0, 1, 0, %d},\n", l->plain);
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *k = &m->channels[i];
        text_add(x, "    {");
        text_literal(x, k->name);
        text_add(x, ", ");
        text_literal(x, k->unit);
        text_add(x, ", ");
        add_read(x, k->read);
        text_add(x, ", %d, %d, %d, %d},\n",
                 stein_reads_attitude(k->read)    ? solid_index(t, k->index)
                 : k->read == STEIN_READ_REACTION ? reactions++
                                                  : k->index,
                 k->sign, k->from_rest, l->sensor[i]);
    }
    close_table(x);
}

static void table_reactions(text *x, const tree *t, const layout *l)
{
    static const char *const component[] = {
        "STEIN_FORCE_X",  "STEIN_FORCE_Y",  "STEIN_FORCE_Z",    "STEIN_MOMENT_X",
        "STEIN_MOMENT_Y", "STEIN_MOMENT_Z", "STEIN_FORCE_SIZE", "STEIN_MOMENT_SIZE"};
    static const char *const kind[] = {"STEIN_TIE_MEET", "STEIN_TIE_ROD", "STEIN_TIE_SLOT",
                                       "STEIN_TIE_WELD", "STEIN_TIE_COUPLING"};
    const mechanism *m = t->m;
    if (layout_reactions(m) == 0) {
        return;
    }
    open_table(x, "reaction", "reactions");
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *k = &m->channels[i];
        if (k->read == STEIN_READ_REACTION) {
            text_add(x, "    {%d, %d, %s, %d},\n", k->loop, k->index, component[k->component],
                     k->axes);
        }
    }
    close_table(x);
    if (m->nloop) {
        open_table(x, "tie", "ties");
        for (int i = 0; i < m->nloop; i++) {
            const mech_loop *k = &m->loops[i];
            text_add(x, "    {%s, {%d, %d}, %d, %d},\n", kind[k->kind], k->index[0], k->index[1],
                     k->axis, l->ratio[i]);
        }
        close_table(x);
    }
}

void emit_tables(text *x, const tree *t, const layout *l)
{
    table_params(x, t->m);
    table_bodies(x, t, l);
    table_points(x, t, l);
    table_contacts(x, t, l);
    table_notches(x, t, l);
    table_curves(x, t, l);
    table_loops(x, t, l);
    table_sticks(x, t->m);
    table_balls(x, t);
    table_signals(x, t, l);
    table_reactions(x, t, l);
}

/* ---- descriptor ----------------------------------------------------------------------------- */

static void ops_field(text *x, const char *name, const stein_ops *o)
{
    text_add(x, "    .ops_%s = {%d, %d, %d, %d, %d},\n", name, o->add, o->mul, o->neg, o->div,
             o->trig);
}

static void pointer_field(text *x, const char *field, int present)
{
    text_add(x, "    .%s = %s,\n", field, present ? field : "NULL");
}

/* derivatives, which may be left out when the text is compiled */
static void derived_field(text *x, const char *field, int present)
{
    if (present) {
        text_add(x, "    .%s = STEIN_DERIVED(%s),\n", field, field);
    } else {
        pointer_field(x, field, 0);
    }
}

static void model_tables(text *x, const tree *t, const funcs *f)
{
    const mechanism *m = t->m;
    pointer_field(x, "params", m->nparam);
    pointer_field(x, "bodies", 1);
    pointer_field(x, "points", m->npoint);
    pointer_field(x, "frames", t->ncarrier);
    pointer_field(x, "contacts", m->ncontact);
    pointer_field(x, "spots", m->ncontact);
    pointer_field(x, "notches", m->nnotch);
    pointer_field(x, "links", m->nlink);
    pointer_field(x, "inputs", m->ninput);
    pointer_field(x, "channels", 1);
    pointer_field(x, "setup", 1);
    pointer_field(x, "mass_bias", 1);
    pointer_field(x, "unloaded", 1);
    pointer_field(x, "solve", emit_solves(t));
    pointer_field(x, "articulated", f->articulated.nout);
    pointer_field(x, "inverse", 1);
    pointer_field(x, "pose", t->ncarrier);
    pointer_field(x, "point", m->npoint);
    pointer_field(x, "energy", 1);
    derived_field(x, "setup_along", 1);
    derived_field(x, "inverse_slopes", f->slopes.nout);
    derived_field(x, "inverse_along", f->along.nout);
    derived_field(x, "pose_along", f->pose_along.nout);
}

void emit_model(text *x, const tree *t, const layout *l, const funcs *f, char hash[17])
{
    const mechanism *m = t->m;
    char dt[32], until[32];
    int nspot = 0;
    for (int c = 0; c < m->ncontact; c++) {
        nspot += m->contacts[c].nspot;
    }
    text_add(x, "STEIN_LANES_DECLARE(%s)\nextern const stein_model stein_model_%s;\n", m->name,
             m->name);
    text_add(x, "const stein_model stein_model_%s = {\n", m->name);
    text_add(x, "    .abi = STEIN_MODEL_ABI,\n    .name = \"%s\",\n", m->name);
    text_add(x, "    .nq = %d, .np = %d, .nd = %d, .npoint = %d, .nframe = %d, .ncontact = %d,\n",
             t->n, m->nparam, l->n, m->npoint, t->ncarrier, m->ncontact);
    text_add(x, "    .nspot = %d, .nnotch = %d, .nlink = %d, .ninput = %d, .nchannel = %d,\n",
             nspot, m->nnotch, m->nlink, m->ninput, m->nchannel + 1);
    text_add(x, "    .load = {%d, %d}, .stroke = {%d, %d}, .initial = %d, .clock = %d,\n",
             m->load_body, m->load_contact, m->stroke_string, m->stroke_notch, l->initial,
             l->clock);
    if (m->ntable) {
        text_add(x, "    .ntable = %d, .tables = curves,\n", m->ntable);
    }
    ops_field(x, "setup", &f->setup);
    ops_field(x, "mass_bias", &f->mass_bias.ops);
    ops_field(x, "unloaded", &f->unloaded.ops);
    ops_field(x, "inverse", &f->inverse.ops);
    ops_field(x, "pose", &f->pose.ops);
    ops_field(x, "point", &f->point.ops);
    ops_field(x, "energy", &f->energy.ops);
    ops_field(x, "slopes", &f->slopes.ops);
    ops_field(x, "along", &f->along.ops);
    if (limits_of(m)) {
        text_add(x, "    .nlimit = %d, .limits = limits,\n", limits_of(m));
    }
    if (add_sticks(NULL, m)) {
        text_add(x, "    .nstick = %d, .sticks = sticks,\n", add_sticks(NULL, m));
    }
    if (balls_of(m)) {
        text_add(x, "    .nball = %d, .balls = balls,\n", balls_of(m));
    }
    if (t->nsolid) {
        text_add(x, "    .npose3 = %d, .frames3 = frames3, .pose3 = pose3,\n", t->nsolid);
    }
    if (m->nloop) {
        text_add(x, "    .nloop = %d, .nrow = %d, .loops = loops,\n", m->nloop, t->nrow);
        ops_field(x, "closure", &f->closure.ops);
        pointer_field(x, "closure", t->nrow);
    }
    if (layout_reactions(m)) {
        text_add(x, "    .nreaction = %d, .reactions = reactions, .ties = %s,\n",
                 layout_reactions(m), m->nloop ? "ties" : "NULL");
        text_add(x, "    .made = %d, .gravity = %d,\n", l->made, l->gravity);
    }
    model_tables(x, t, f);
    text_add(x, "    .lanes = STEIN_LANES_OF(%s),\n", m->name);
    snprintf(hash, 17, "%016llx", (unsigned long long)x->hash);
    text_number(dt, m->dt);
    text_number(until, m->until);
    text_quiet(x, "    .settle = %d, .integrator = %d, .dt = %s, .until = %s,\n", m->settle,
               m->integrator, dt, until);
    text_quiet(x, "    .equations = \"%s\",\n};\n#endif\n", hash);
}
