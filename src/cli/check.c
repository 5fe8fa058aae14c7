/* SPDX-License-Identifier: GPL-3.0-or-later
 * check.c - stein check: is the file in order, what is in it, what do its equations cost.
 */
#include <string.h>

#include "cli.h"

/* what is checked: the file, and the operation counts of its equations */
typedef struct checked {
    const mechanism *m;
    const gen_result *g;
} checked;

static const char *body_name(const mechanism *m, int body)
{
    return body < 0 ? "frame" : m->bodies[body].name;
}

/* how many bodies the file has: joints before those of balls are none */
static int number_of_bodies(const mechanism *m)
{
    int n = 0;
    for (int i = 0; i < m->nbody; i++) {
        n += !m->bodies[i].lead;
    }
    return n;
}

/* Degrees of freedom of a tree with balls: its coordinates without the charts. @return 0 for a
 * mechanism without balls, or with loops */
static int tree_freedom(const mechanism *m)
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

/* what a body of the file hangs on */
static const char *parent_name(const mechanism *m, int body)
{
    int up = m->bodies[body].parent;
    while (up >= 0 && m->bodies[up].lead) {
        up = m->bodies[up].parent;
    }
    return body_name(m, up);
}

/* "R y", "T -z", "ball", "free" */
static const char *joint_text(char text[8], const mech_body *b)
{
    if (b->ball) {
        return b->free ? "free" : "ball";
    }
    snprintf(text, 8, "%c %s%c", b->type, b->sign < 0 ? "-" : "", b->axis);
    return text;
}

static const char *shape_text(const mech_shape *s)
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

/* what an input or output refers to */
static const char *input_target(const mechanism *m, const mech_input *in)
{
    return in->kind == STEIN_INPUT_POINT ? m->points[in->index].name : m->bodies[in->index].name;
}

static const char *input_kind(int kind)
{
    return kind == STEIN_INPUT_MOTION ? "motion" : kind == STEIN_INPUT_POINT ? "force" : "torque";
}

/* what an output reads of; energies are those of the mechanism */
static const char *target_or_all(const mechanism *m, const mech_channel *c)
{
    const char *name = mech_target(m, c);
    return *name != '\0' ? name : m->name;
}

static const char *output_kind(int read)
{
    static const char *const text[] = {"time",
                                       "position",
                                       "speed",
                                       "acceleration",
                                       "x",
                                       "y",
                                       "z",
                                       "vx",
                                       "vy",
                                       "vz",
                                       "gap",
                                       "force",
                                       "friction",
                                       "force",
                                       "phase",
                                       "overlap",
                                       "value",
                                       "force",
                                       "kinetic energy",
                                       "potential energy",
                                       "roll",
                                       "pitch",
                                       "yaw",
                                       "xx",
                                       "xy",
                                       "xz",
                                       "yx",
                                       "yy",
                                       "yz",
                                       "zx",
                                       "zy",
                                       "zz",
                                       "wx",
                                       "wy",
                                       "wz"};
    return text[read];
}

/* the generated functions in the order they are listed */
enum { COUNTED = 12, ALWAYS = 4 };
static const char *const counted_key[COUNTED] = {
    "M_c",   "M_c_unloaded", "inverse_dynamics", "setup",       "solution", "articulated",
    "poses", "points",       "energy",           "derivatives", "loops",    "poses_in_space"};
static const char *const counted_note[COUNTED] = {"with a force and a moment on every body",
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

static stein_ops counted(const gen_result *g, int i)
{
    const stein_ops ops[COUNTED] = {g->mass_bias, g->unloaded,    g->inverse, g->setup,
                                    g->solve,     g->articulated, g->pose,    g->point,
                                    g->energy,    g->slopes,      g->closure, g->pose3};
    return ops[i];
}

/* has this entry of a law an effect? */
static int acts(const mech_scalar *law, int entry)
{
    return law[entry].kind == MECH_FORMULA || law[entry].value != 0.0;
}

static const char *friction_text(const mech_scalar *law, int level, int sticks)
{
    return !acts(law, level) ? "" : sticks ? ", friction that sticks" : ", friction";
}

/* ---- for people ---- */

static void print_bodies(const mechanism *m)
{
    printf("\nbodies (%d)", number_of_bodies(m));
    if (tree_freedom(m) > 0) {
        printf(", %d degrees of freedom", tree_freedom(m));
    }
    putchar('\n');
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        char joint[8], mass[CLI_TEXT];
        if (b->lead) {
            continue;
        }
        printf("  %-16s %-4s on %-12s %s%s%s%s%s\n", b->name, joint_text(joint, b),
               parent_name(m, i), cli_quantity(mass, b->mass.value, "kg"),
               acts(b->joint, STEIN_JOINT_K) ? ", spring" : "",
               acts(b->joint, STEIN_JOINT_B) ? ", damping" : "",
               friction_text(b->joint, STEIN_JOINT_FRICTION, b->sticks),
               b->limited ? ", limits" : "");
    }
}

static void print_parameters(const mechanism *m)
{
    int stated = 0;
    for (int i = 0; i < m->nparam; i++) {
        stated += m->params[i].stated;
    }
    printf("\nparameters (%d, and %d that the file leaves at their neutral value: --json lists "
           "them)\n",
           stated, m->nparam - stated);
    for (int i = 0; i < m->nparam; i++) {
        const mech_param *p = &m->params[i];
        char value[CLI_TEXT], tolerance[CLI_TEXT];
        if (!p->stated) {
            continue;
        }
        printf("  %-28s %s", p->name, cli_quantity(value, p->value, p->unit));
        if (p->tolerance > 0.0) {
            printf(" +- %s", cli_quantity(tolerance, p->tolerance, p->unit));
        }
        putchar('\n');
    }
}

/* what a table is read over, and where it sits */
static const char *table_of(const mech_table *t)
{
    static const char *const of[] = {"position", "speed", "depth", "rate"};
    return of[t->kind];
}

static const char *table_place(const mechanism *m, const mech_table *t)
{
    return t->kind <= STEIN_TABLE_SPEED ? m->bodies[t->index].name
           : t->index < m->ncontact     ? m->contacts[t->index].name
                                        : m->notches[t->index - m->ncontact].name;
}

static void print_tables(const mechanism *m)
{
    if (m->ntable > 0) {
        printf("\ntables (%d)\n", m->ntable);
    }
    for (int i = 0; i < m->ntable; i++) {
        const mech_table *t = &m->tables[i];
        printf("  %-16s at %s over %s, %d points\n", t->name, table_place(m, t), table_of(t), t->n);
    }
}

static void print_contacts(const mechanism *m)
{
    if (m->ncontact > 0) {
        printf("\ncontacts (%d)\n", m->ncontact);
    }
    for (int i = 0; i < m->ncontact; i++) {
        const mech_contact *c = &m->contacts[i];
        const mech_shape *a = &c->spot[0].side[0], *b = &c->spot[0].side[1];
        printf("  %-16s %s of %s on %s of %s%s%s%s\n", c->name, shape_text(a),
               body_name(m, a->body), shape_text(b), body_name(m, b->body),
               c->nspot == 2 ? ", two spots" : "",
               friction_text(c->friction.v, STEIN_FRICTION_A, c->sticks),
               i == m->load_contact ? ", carries the free load" : "");
    }
    if (m->nnotch > 0) {
        printf("\nnotches (%d)\n", m->nnotch);
    }
    for (int i = 0; i < m->nnotch; i++) {
        const mech_notch *n = &m->notches[i];
        printf("  %-16s corner of %s catches beak of %s\n", n->name, body_name(m, n->catcher),
               body_name(m, n->beak));
    }
    if (m->nlink > 0) {
        printf("\nlinks (%d)\n", m->nlink);
    }
    for (int i = 0; i < m->nlink; i++) {
        const mech_link *l = &m->links[i];
        printf("  %-16s from %s to %s\n", l->name, m->points[l->point[0]].name,
               m->points[l->point[1]].name);
    }
}

static void print_signals(const mechanism *m)
{
    if (m->npoint > 0) {
        printf("\npoints (%d)\n", m->npoint);
    }
    for (int i = 0; i < m->npoint; i++) {
        printf("  %s\n", m->points[i].name);
    }
    if (m->ninput > 0) {
        printf("\ninputs (%d)\n", m->ninput);
    }
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *in = &m->inputs[i];
        printf("  %-20s %-8s %s of %s\n", in->name, in->unit, input_kind(in->kind),
               input_target(m, in));
    }
    printf("\noutputs (%d)\n  %-20s %-8s\n", m->nchannel + 1, "time", "s");
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *c = &m->channels[i];
        printf("  %-20s %-8s %s of %s%s\n", c->name, c->unit, output_kind(c->read),
               target_or_all(m, c), c->from_rest ? ", from rest" : "");
    }
}

static void print_regulation(const mechanism *m)
{
    if (m->ndial > 0) {
        printf("\nregulation (%d)\n", m->ndial);
    }
    for (int i = 0; i < m->ndial; i++) {
        const mech_dial *d = &m->dials[i];
        char from[CLI_TEXT], to[CLI_TEXT];
        printf("  %-20s %s to %s\n", m->params[d->param].name,
               cli_quantity(from, d->from, m->params[d->param].unit),
               cli_quantity(to, d->to, m->params[d->param].unit));
    }
}

static void print_operations(const gen_result *g)
{
    printf("\noperations (total = add + mul + neg + div + trig, a sine or cosine is 1)\n"
           "  %-18s %6s %6s %6s %6s %6s %7s\n",
           "", "add", "mul", "neg", "div", "trig", "total");
    for (int i = 0; i < COUNTED; i++) {
        stein_ops o = counted(g, i);
        if (gen_total(o) > 0 || i < ALWAYS) {
            printf("  %-18s %6d %6d %6d %6d %6d %7d   %s\n", counted_key[i], o.add, o.mul, o.neg,
                   o.div, o.trig, gen_total(o), counted_note[i]);
        }
    }
}

static void print_title(const checked *c)
{
    const mechanism *m = c->m;
    char dt[CLI_TEXT], until[CLI_TEXT];
    printf("%s   %s\nequations %s, %s with dt = %s, %s, from %s\n", m->name, m->file,
           c->g->equations, mech_integrator(m->integrator), cli_quantity(dt, m->dt, "s"),
           cli_quantity(until, m->until, "s"),
           m->settle ? "static equilibrium" : "its initial values");
}

/* all that the mechanism file holds */
static int print_text(const checked *c, const cli_args *args)
{
    const mechanism *m = c->m;
    print_title(c);
    print_bodies(m);
    print_parameters(m);
    print_contacts(m);
    print_tables(m);
    print_signals(m);
    print_regulation(m);
    int code = cli_check_loops(args, m, NULL);
    print_operations(c->g);
    return code;
}

/* the records, which are what was asked for */
static int print_data(const checked *c, const cli_args *args)
{
    print_title(c);
    int code = cli_check_data(args, NULL);
    printf("\nbodies, parameters, outputs and operations of the mechanism: %s check %s\n",
           args->program, c->m->file);
    return code;
}

/* ---- JSON ---- */

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
        lab__json_text(j, "parent", parent_name(m, i));
        lab__json_text(j, "joint", joint_text(joint, b));
        lab__json_real(j, "mass", b->mass.value);
        lab__json_bool(j, "spring", acts(b->joint, STEIN_JOINT_K));
        lab__json_bool(j, "damping", acts(b->joint, STEIN_JOINT_B));
        lab__json_bool(j, "friction", acts(b->joint, STEIN_JOINT_FRICTION));
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
        lab__json_text(j, "place", table_place(m, t));
        lab__json_text(j, "of", table_of(t));
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
            lab__json_text(j, "shape", shape_text(&c->spot[0].side[k]));
            lab__json_text(j, "body", body_name(m, c->spot[0].side[k].body));
            lab__json_close(j);
        }
        lab__json_close(j);
        lab__json_int(j, "spots", c->nspot);
        lab__json_bool(j, "friction", acts(c->friction.v, STEIN_FRICTION_A));
        lab__json_bool(j, "sticks", c->sticks);
        lab__json_close(j);
    }
    lab__json_close(j);
    lab__json_open(j, "notches", '[');
    for (int i = 0; i < m->nnotch; i++) {
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", m->notches[i].name);
        lab__json_text(j, "catcher", body_name(m, m->notches[i].catcher));
        lab__json_text(j, "beak", body_name(m, m->notches[i].beak));
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
        json_signal(j, in->name, in->unit, input_kind(in->kind), input_target(m, in));
    }
    lab__json_close(j);
    lab__json_open(j, "outputs", '[');
    json_signal(j, "time", "s", "time", m->name);
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *c = &m->channels[i];
        json_signal(j, c->name, c->unit, output_kind(c->read), target_or_all(m, c));
    }
    lab__json_close(j);
}

static void json_operations(lab__json *j, const gen_result *g)
{
    lab__json_open(j, "operations", '{');
    for (int i = 0; i < COUNTED; i++) {
        stein_ops o = counted(g, i);
        lab__json_open(j, counted_key[i], '{');
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

static int print_json(const checked *c, const cli_args *args)
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
    if (tree_freedom(m) > 0) {
        lab__json_int(&j, "freedom", tree_freedom(m));
    }
    code = cli_check_loops(args, m, &j);
    if (code == CLI_OK && args->noperand > 1) {
        code = cli_check_data(args, &j);
    }
    lab__json_close(&j);
    return code;
}

/* data are no mechanisms */
static const char *second_model(const cli_args *args)
{
    for (int i = 1; i < args->noperand; i++) {
        const char *end = strrchr(args->operand[i], '.');
        if (end != NULL && (strcmp(end, ".yaml") == 0 || strcmp(end, ".yml") == 0)) {
            return args->operand[i];
        }
    }
    return NULL;
}

static int check(const cli_args *args)
{
    int code = CLI_OK;
    mechanism *m = NULL;
    gen_result g;
    stein_err err = {STEIN_OK, ""};
    stein_status status = cli_mechanism(&m, args, &err);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    status = gen_equations(&g, m, &err);
    if (status == STEIN_OK) {
        checked c = {m, &g};
        if (cli_value(args, "json") != NULL) {
            code = print_json(&c, args);
        } else {
            code = args->noperand > 1 ? print_data(&c, args) : print_text(&c, args);
        }
        gen_free(&g);
    }
    mech_free(m);
    return status == STEIN_OK ? code : cli_failed(status, &err);
}

static int run(const cli_args *args)
{
    if (second_model(args) != NULL) {
        return cli_misuse(args->command, "one model at a time: %s is no data", second_model(args));
    }
    return cli_value(args, "watch") != NULL ? cli_watch(args, check) : check(args);
}

static const cli_option options[] = {
    {"watch", 0, NULL, "Go on: check again whenever MODEL or DATA change, until Ctrl-C ends it."},
    CLI_COMMON};

const cli_command cli_check = {
    .name = "check",
    .summary = "validate a mechanism file, show what is in it, and look at data",
    .operands = "MODEL [DATA...]",
    .noperands = 1,
    .more = 1,
    .options = options,
    .description =
        "Reads the mechanism file MODEL and derives its equations. All problems of the file are\n"
        "reported in one run, each as file:line:column: what is wrong, what was expected, which\n"
        "known name is nearest; the line follows with a caret below the place. Without DATA "
        "nothing\n"
        "is compiled or simulated. For loops and couplings the command tells whether they can be\n"
        "closed, and how many degrees of freedom they leave.\n"
        "\n"
        "DATA are measured records, CSV files. They are read and audited: sampling, noise, gaps,\n"
        "rests, wrapped angles. Then every record is simulated once with the numbers of the files\n"
        "and compared with what was measured. Suspected are a column in another unit than stated\n"
        "(mm under m, degrees under rad), milliseconds for seconds, an opposite sign, two columns\n"
        "exchanged, a record of another mechanism, and a `# set` that its record contradicts.\n"
        "Nothing is fitted: it takes milliseconds a record.",
    .output =
        "Without DATA: bodies with joint, parent and mass; parameters with value, unit and\n"
        "tolerance; contacts, notches, links; points, inputs, outputs and regulation; and the\n"
        "operations of the equations, counted as ROBOTRAN counts: additions, multiplications,\n"
        "unary minuses, divisions, and each sine and cosine as one. M_c and inverse_dynamics are\n"
        "done at every evaluation with external forces and moments on all bodies; setup is done\n"
        "once a parameter set.\n"
        "\n"
        "With DATA only the records: the audit of each, its findings behind `!`; and the\n"
        "suspicions. With a suspicion behind `!` a diagnosis cannot be trusted; the exit status\n"
        "is then 1.\n"
        "\n"
        "With --json: {\"model\", \"file\", \"equations\" (hash), \"bodies\", \"parameters\",\n"
        "\"contacts\", \"notches\", \"links\", \"points\", \"inputs\", \"outputs\",\n"
        "\"regulation\", \"load\", \"stroke\", \"simulation\", \"operations\": {\"M_c\":\n"
        "{\"add\", \"mul\", \"neg\", \"div\", \"trig\", \"total\"}, \"inverse_dynamics\",\n"
        "\"setup\", \"poses\", \"points\", \"energy\"}}, with loops or couplings \"loops\": "
        "[{\"name\",\n"
        "\"kind\", \"from\", \"to\"}], \"freedom\" (also with balls),\n"
        "\"start\": {JOINT: position}; with DATA also \"data\": [{\"file\",\n"
        "\"rows\", \"findings\"}], \"suspicions\": [{\"kind\", \"file\", \"grave\", \"factor\",\n"
        "\"text\"}],\n"
        "values in SI units.",
    .examples = "stein check models/stein1788.yaml\n"
                "stein check models/stein1788.yaml models/strokes/*.csv\n"
                "stein check my.yaml --watch\n"
                "stein check my.yaml --json | python3 -m json.tool",
    .run = run,
};
