/* SPDX-License-Identifier: GPL-3.0-or-later
 * check.c - stein check: problems and contents of a file, operations of its equations.
 */
#include <string.h>

#include "checking.h"

static void print_bodies(const mechanism *m)
{
    printf("\nbodies (%d)", check__number_of_bodies(m));
    if (check__tree_freedom(m) > 0) {
        printf(", %d degrees of freedom", check__tree_freedom(m));
    }
    putchar('\n');
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        char joint[8], mass[CLI_TEXT];
        if (b->lead) {
            continue;
        }
        printf("  %-16s %-4s on %-12s %s%s%s%s%s%s%s\n", b->name, check__joint_text(joint, b),
               check__parent_name(m, i), cli_quantity(mass, b->mass.value, "kg"),
               check__acts(b->joint, STEIN_JOINT_K) ? ", spring" : "",
               check__acts(b->joint, STEIN_JOINT_B) ? ", damping" : "",
               check__friction_text(b->joint, STEIN_JOINT_FRICTION, b->sticks),
               b->limited ? ", limits" : "", b->armature.value > 0.0 ? ", armature" : "",
               b->has_motor ? ", motor" : "");
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

static void print_tables(const mechanism *m)
{
    if (m->ntable > 0) {
        printf("\ntables (%d)\n", m->ntable);
    }
    for (int i = 0; i < m->ntable; i++) {
        const mech_table *t = &m->tables[i];
        printf("  %-16s at %s over %s, %d points\n", t->name, check__table_place(m, t),
               check__table_of(t), t->n);
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
        printf("  %-16s %s of %s on %s of %s%s%s%s\n", c->name, check__shape_text(a),
               check__body_name(m, a->body), check__shape_text(b), check__body_name(m, b->body),
               c->nspot == 2 ? ", two spots" : "",
               check__friction_text(c->friction.v, STEIN_FRICTION_A, c->sticks),
               i == m->load_contact ? ", carries the free load" : "");
    }
    if (m->nnotch > 0) {
        printf("\nnotches (%d)\n", m->nnotch);
    }
    for (int i = 0; i < m->nnotch; i++) {
        const mech_notch *n = &m->notches[i];
        printf("  %-16s corner of %s catches beak of %s\n", n->name,
               check__body_name(m, n->catcher), check__body_name(m, n->beak));
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
        printf("  %-20s %-8s %s of %s\n", in->name, in->unit, check__input_kind(in->kind),
               check__input_target(m, in));
    }
    printf("\noutputs (%d)\n  %-20s %-8s\n", m->nchannel + 1, "time", "s");
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *c = &m->channels[i];
        printf("  %-20s %-8s %s of %s%s\n", c->name, c->unit, check__output_kind(c->read),
               check__target_or_all(m, c), c->from_rest ? ", from rest" : "");
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
        stein_ops o = check__counted(g, i);
        if (gen_total(o) > 0 || i < ALWAYS) {
            printf("  %-18s %6d %6d %6d %6d %6d %7d   %s\n", check__counted_key[i], o.add, o.mul,
                   o.neg, o.div, o.trig, gen_total(o), check__counted_note[i]);
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

/* the records alone */
static int print_data(const checked *c, const cli_args *args)
{
    print_title(c);
    int code = cli_check_data(args, NULL);
    printf("\nbodies, parameters, outputs and operations of the mechanism: %s check %s\n",
           args->program, c->m->file);
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
            code = check__json(&c, args);
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
    {"watch", 0, NULL, "Check again whenever MODEL or DATA change, until Ctrl-C."}, CLI_COMMON};

const cli_command cli_check = {
    .name = "check",
    .summary = "validate a mechanism file, show its contents, and audit data",
    .operands = "MODEL [DATA...]",
    .noperands = 1,
    .more = 1,
    .options = options,
    .description =
        "Reads the mechanism file MODEL and derives its equations. All problems of the file are\n"
        "reported in one run, each as file:line:column: what is wrong, what was expected, which\n"
        "known name is nearest; the line follows with a caret below the place. Without DATA "
        "nothing\n"
        "is compiled or simulated. For loops and couplings the output states whether they can\n"
        "be closed, and the remaining degrees of freedom.\n"
        "\n"
        "DATA are measured records, CSV files. They are read and audited: sampling, noise, gaps,\n"
        "rests, wrapped angles. Then every record is simulated once with the numbers of the\n"
        "files and compared with the measurement. The following are suspicions: a column in\n"
        "another unit than stated (mm under m, degrees under rad), milliseconds for seconds,\n"
        "an opposite sign, two columns exchanged, a record of another mechanism, a `# set`\n"
        "that its record contradicts. Nothing is fitted: it takes milliseconds a record.",
    .output =
        "Without DATA: bodies with joint, parent and mass; parameters with value, unit and\n"
        "tolerance; contacts, notches, links; points, inputs, outputs and regulation; and the\n"
        "operations of the equations, counted as in ROBOTRAN: additions, multiplications,\n"
        "unary minuses, divisions, each sine and cosine as one. M_c and inverse_dynamics are\n"
        "for every evaluation, with external forces and moments on all bodies; setup is once\n"
        "a parameter set.\n"
        "\n"
        "With DATA only the records: the audit of each, with findings marked `!`, and the\n"
        "suspicions. With a suspicion marked `!` a diagnosis cannot be trusted; the exit\n"
        "status is then 1.\n"
        "\n"
        "With --json: {\"model\", \"file\", \"equations\" (hash), \"bodies\", \"parameters\",\n"
        "\"contacts\", \"notches\", \"links\", \"points\", \"inputs\", \"outputs\",\n"
        "\"regulation\", \"load\", \"stroke\", \"simulation\", \"operations\": {\"M_c\":\n"
        "{\"add\", \"mul\", \"neg\", \"div\", \"trig\", \"total\"}, \"inverse_dynamics\",\n"
        "\"setup\", \"poses\", \"points\", \"energy\"}}, with loops or couplings \"loops\": "
        "[{\"name\",\n"
        "\"kind\", \"from\", \"to\"}], \"freedom\" (also with balls),\n"
        "\"start\": {JOINT: position}, \"undetermined\": [outputs with one of many possible "
        "values];\n"
        "with DATA also \"data\": [{\"file\",\n"
        "\"rows\", \"findings\"}], \"suspicions\": [{\"kind\", \"file\", \"grave\", \"factor\",\n"
        "\"text\"}],\n"
        "values in SI units.",
    .examples = "stein check models/stein1788.yaml\n"
                "stein check models/stein1788.yaml models/strokes/*.csv\n"
                "stein check my.yaml --watch\n"
                "stein check my.yaml --json | python3 -m json.tool",
    .run = run,
};
