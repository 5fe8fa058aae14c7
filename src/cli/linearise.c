/* SPDX-License-Identifier: GPL-3.0-or-later
 * linearise.c - stein linearise: A, B, C, D, natural frequencies and damping about a state.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linearise.h"

enum { MOST_VALUES = 128 };
static const double kept = 1e-9; /* a stated position is where it was stated [rad or m] */

/* NAME=VALUE */
typedef struct value {
    char name[2 * MECH_NAME];
    int index; /* of an input or a joint */
    int speed; /* of a joint: 1 its speed */
    double x;  /* [SI] */
} value;

typedef struct job {
    const cli_args *args;
    lab_model *model;
    const stein_model *equations;
    stein_sim *sim;
    value input[MOST_VALUES], state[MOST_VALUES];
    int ninput, nstate;
    enum { EQUILIBRIUM, INITIAL, STATED } at;
} job;

/* ---- the command line ---- */

/* the next NAME=VALUE of a list; text moves behind it. @return its text, to be freed, or NULL */
static char *next_word(const char **text)
{
    size_t length = strcspn(*text, ",");
    char *word = lab__text("%.*s", (int)length, *text);
    *text += length + ((*text)[length] == ',');
    return word;
}

static int find_input(const stein_model *m, value *v, const char **unit)
{
    v->index = stein_find_input(m, v->name);
    *unit = v->index >= 0 ? m->inputs[v->index].unit : "1";
    return v->index;
}

/* a joint by the name of its body, NAME.speed is its speed */
static int find_joint(const stein_model *m, value *v, const char **unit)
{
    static const char ending[] = ".speed";
    size_t length = strlen(v->name), tail = strlen(ending);
    v->index = stein_find_body(m, v->name);
    if (v->index < 0 && length > tail && strcmp(v->name + length - tail, ending) == 0) {
        v->name[length - tail] = '\0';
        v->index = stein_find_body(m, v->name);
        v->speed = 1;
    }
    int turns = v->index >= 0 && m->bodies[v->index].type == 'R';
    *unit = v->speed ? (turns ? "rad/s" : "m/s") : (turns ? "rad" : "m");
    return v->index;
}

typedef int find_fn(const stein_model *m, value *v, const char **unit);

static int read_value(const job *j, const char *option, const char *word, find_fn *find, value *v)
{
    const char *sign = strchr(word, '='), *unit = "1";
    stein_err err = {STEIN_OK, ""};
    size_t length = sign != NULL ? (size_t)(sign - word) : 0;
    if (length == 0 || length >= sizeof v->name || sign[1] == '\0') {
        return cli_misuse(j->args->command, "--%s %s: expected NAME=VALUE[unit],...", option, word);
    }
    *v = (value){.index = -1};
    memcpy(v->name, word, length);
    if (find(j->equations, v, &unit) < 0) {
        return cli_misuse(j->args->command, "--%s %s: \"%s\" has no such %s", option, word,
                          j->equations->name, find == find_input ? "input" : "joint");
    }
    if (lab_quantity(&v->x, sign + 1, unit, &err) != STEIN_OK) {
        return cli_misuse(j->args->command, "--%s %s: %s", option, word, err.msg);
    }
    return CLI_OK;
}

static int read_values(const job *j, const char *option, find_fn *find, value *to, int *n)
{
    const char *text = cli_value(j->args, option);
    int code = CLI_OK;
    while (code == CLI_OK && text != NULL && *text != '\0') {
        char *word = next_word(&text);
        if (word == NULL || *n == MOST_VALUES) {
            code =
                cli_misuse(j->args->command, "--%s: more than %d values", option, (int)MOST_VALUES);
        } else {
            code = read_value(j, option, word, find, &to[*n]);
            *n += code == CLI_OK;
        }
        free(word);
    }
    return code;
}

static int read_options(job *j)
{
    const char *at = cli_value(j->args, "at");
    j->at = at == NULL || strcmp(at, "equilibrium") == 0 ? EQUILIBRIUM
            : strcmp(at, "initial") == 0                 ? INITIAL
                                                         : STATED;
    int code = read_values(j, "input", find_input, j->input, &j->ninput);
    if (code == CLI_OK && at != NULL && j->at == STATED && strchr(at, '=') == NULL) {
        return cli_misuse(j->args->command,
                          "--at %s: expected equilibrium, initial, or JOINT=VALUE[unit],...", at);
    }
    return code == CLI_OK && j->at == STATED
               ? read_values(j, "at", find_joint, j->state, &j->nstate)
               : code;
}

/* ---- the state ---- */

static void hold(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = ((const value *)ctx)->x;
}

/* of a tree: the initial state, with the stated changes */
static stein_status put_state(job *j, stein_err *err)
{
    int n = j->equations->nq;
    double *x = calloc(2 * (size_t)n, sizeof *x);
    if (x == NULL) {
        return lab__no_memory(err);
    }
    memcpy(x, stein_q(j->sim), sizeof *x * (size_t)n);
    memcpy(x + n, stein_qd(j->sim), sizeof *x * (size_t)n);
    for (int i = 0; i < j->nstate; i++) {
        x[j->state[i].index + (j->state[i].speed ? n : 0)] = j->state[i].x;
    }
    stein_status status = stein_set_state(j->sim, 0.0, x, x + n, err);
    free(x);
    return status;
}

/* with loops: as initial values of the file, which stay where they are stated if the loops allow */
static stein_status put_initial(job *j, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; i < j->nstate && status == STEIN_OK; i++) {
        const value *v = &j->state[i];
        char *name = lab__text("%s.initial.%s", v->name, v->speed ? "speed" : "position");
        status = name != NULL ? stein_set(j->sim, name, v->x, err) : lab__no_memory(err);
        free(name);
    }
    status = status == STEIN_OK ? stein_reset(j->sim, err) : status;
    for (int i = 0; i < j->nstate && status == STEIN_OK; i++) {
        const value *v = &j->state[i];
        double is = (v->speed ? stein_qd(j->sim) : stein_q(j->sim))[v->index];
        if (fabs(is - v->x) > kept) {
            status = lab__fail(err, STEIN_ECLOSE,
                               "the loops do not allow \"%s\" to be at %g: the nearest is %g",
                               v->name, v->x, is);
        }
    }
    return status;
}

static stein_status place(job *j, stein_err *err)
{
    stein_status status = lab_sim(j->model, NULL, &j->sim, err);
    for (int i = 0; i < j->ninput && status == STEIN_OK; i++) {
        status = stein_drive(j->sim, j->input[i].name, hold, &j->input[i], err);
    }
    if (status == STEIN_OK && j->ninput > 0) {
        status = stein_reset(j->sim, err);
    }
    if (status == STEIN_OK && cli_value(j->args, "load") == NULL) {
        stein_load_lift(j->sim);
    }
    if (status == STEIN_OK && j->at == EQUILIBRIUM) {
        status = stein_settle(j->sim, err);
    } else if (status == STEIN_OK && j->at == STATED) {
        status = j->equations->nrow > 0 ? put_initial(j, err) : put_state(j, err);
    }
    return status;
}

/* ---- the command ---- */

static stein_status show(const job *j, const stein_linear_system *system, stein_err *err)
{
    static const char *const words[] = {"the equilibrium next to its initial state",
                                        "its initial state", "the stated state"};
    lab_modes *modes = NULL;
    stein_status status = lab_modes_create(&modes, system, err);
    cli_linear l = {.args = j->args,
                    .model = j->equations,
                    .q = stein_q(j->sim),
                    .qd = stein_qd(j->sim),
                    .at = words[j->at],
                    .system = system,
                    .modes = modes};
    const char *path = cli_value(j->args, "output");
    if (status == STEIN_OK && path != NULL) {
        status = cli_linear_csv(&l, path, err);
    }
    if (status == STEIN_OK && cli_value(j->args, "json") != NULL) {
        cli_linear_json(&l);
    } else if (status == STEIN_OK && (path == NULL || !lab__is_stdout(path))) {
        cli_linear_text(&l);
    }
    lab_modes_destroy(modes);
    return status;
}

static int run(const cli_args *args)
{
    job j = {.args = args};
    stein_linear *l = NULL;
    const stein_linear_system *system = NULL;
    const char *path = cli_value(args, "output");
    stein_err err = {STEIN_OK, ""};
    if (path != NULL && lab__is_stdout(path) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and -o - both want standard output");
    }
    stein_status status = cli_open(&j.model, args, &err);
    int code = CLI_OK;
    if (status == STEIN_OK) {
        j.equations = lab_equations(j.model);
        code = read_options(&j);
    }
    if (status == STEIN_OK && code == CLI_OK) {
        status = place(&j, &err);
        status = status == STEIN_OK ? stein_linear_create(&l, j.equations, NULL, &err) : status;
        status = status == STEIN_OK ? stein_linear_at(l, j.sim, &system, &err) : status;
        status = status == STEIN_OK ? show(&j, system, &err) : status;
    }
    stein_linear_destroy(l);
    stein_sim_destroy(j.sim);
    lab_close(j.model);
    return status == STEIN_OK ? code : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"at", 0, "STATE",
     "equilibrium: static, next to the initial positions (the default). initial: the\n"
     "file's initial state. JOINT=VALUE[unit],... and JOINT.speed=VALUE[unit]: the initial\n"
     "state with these values; with loops the other joints follow."},
    {"input", 0, "NAME=VALUE[unit],...",
     "Constant values of inputs, a force or a prescribed position. Without it forces are 0."},
    {"load", 0, NULL, "With the free load of the file resting on its place; without: it is away."},
    {"output", 'o', "FILE.csv", "A, B, C and D as a table; - is standard output."},
    CLI_COMMON};

const cli_command cli_linearise = {
    .name = "linearise",
    .summary = "A, B, C, D, natural frequencies and damping about an equilibrium",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Linearises the equations of MODEL about a state: dx/dt = A x + B u, y = C x + D u, x the\n"
        "independent coordinates and their speeds, u the inputs of the file, y its outputs, all\n"
        "as deviations from the state. With loops and couplings the dependent joints follow the\n"
        "independent ones. A joint that an input moves (idle: hold, or --input) is a coordinate\n"
        "as well; its input is its acceleration. Delays of inputs and instruments are left out.\n"
        "\n"
        "Closed contacts act with their stiffness and damping in this state, open ones do not\n"
        "act; contacts at their edge are listed. Smooth friction at rest is viscous, A/vt. A\n"
        "comes from the exact derivatives of the generated equations. Mechanisms with loops,\n"
        "couplings, bodies or contacts in space, or friction that sticks have none: A then\n"
        "comes from extrapolated differences, and its error is printed.\n"
        "\n"
        "The state has to be an equilibrium or a steady motion, such as a wheel at constant\n"
        "speed; else the command prints the largest acceleration and ends with status 3.",
    .output =
        "Eigenvalues of A, without joints that inputs move: frequency |s|/(2 pi), damping ratio\n"
        "-Re s/|s|, and the joint with the largest share of the kinetic energy. Then A, B, C, D\n"
        "as one table, where it has no more than 8 columns.\n"
        "\n"
        "FILE.csv: lines `# name: value` with the state, the way and the modes; then a row for\n"
        "the rate of each state and for each output, a column for each state and each input.\n"
        "\n"
        "With --json: {\"model\", \"at\", \"exact\", \"why\", \"error\", \"residual\", \"state\":\n"
        "{JOINT: {\"position\", \"speed\"}}, \"states\": [{\"name\", \"unit\", \"prescribed\"}],\n"
        "\"inputs\": [{\"name\", \"unit\"}], \"outputs\": [{\"name\", \"unit\", \"exact\"}],\n"
        "\"A\", \"B\", \"C\", \"D\": lists of rows, \"modes\": [{\"kind\", \"re\", \"im\",\n"
        "\"frequency\", \"damping\", \"joint\", \"share\", \"shape\": [[re, im] of each free\n"
        "coordinate]}], \"edges\": [{\"kind\", \"name\", \"apart\"}]}, SI units.",
    .examples = "stein linearise models/pendulum.yaml\n"
                "stein linearise models/pendulum.yaml --at rod=180deg --input push=0 --json\n"
                "stein linearise models/stein1788.yaml -o action.csv",
    .run = run,
};
