/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.c - stein import: a mechanism of another program as a mechanism file.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/import.h"

/* what was left out, for --json */
typedef struct notes {
    char **text;
    int n;
    int quiet;
} notes;

static void on_note(void *ctx, const char *message)
{
    notes *t = ctx;
    char **more = realloc(t->text, ((size_t)t->n + 1) * sizeof *more);
    if (more != NULL) {
        t->text = more;
        t->text[t->n] = lab__text("%s", message);
        t->n += t->text[t->n] != NULL;
    }
    if (!t->quiet) {
        fprintf(stderr, "%s%s\n",
                strstr(message, "warning: ") != NULL ? "" : "left out or changed: ", message);
    }
}

static void print_json(const lab_imported *done, const char *to, const notes *t)
{
    lab__json out = {.stream = stdout};
    lab__json_open(&out, NULL, '{');
    lab__json_text(&out, "model", done->name);
    lab__json_text(&out, "file", to);
    lab__json_int(&out, "bodies", done->bodies);
    lab__json_int(&out, "joints", done->joints);
    lab__json_int(&out, "points", done->points);
    lab__json_int(&out, "loops", done->loops);
    lab__json_open(&out, "left_out", '[');
    for (int i = 0; i < t->n; i++) {
        lab__json_text(&out, NULL, t->text[i]);
    }
    lab__json_close(&out);
    lab__json_close(&out);
}

static lab_inertia inertia_of(const cli_args *args)
{
    const char *text = cli_value(args, "inertia");
    return text == NULL                   ? LAB_INERTIA_REFUSE
           : strcmp(text, "accept") == 0  ? LAB_INERTIA_ACCEPT
           : strcmp(text, "balance") == 0 ? LAB_INERTIA_BALANCE
                                          : LAB_INERTIA_REFUSE;
}

static int run(const cli_args *args)
{
    const char *to = cli_value(args, "output");
    int json = cli_value(args, "json") != NULL;
    notes t = {.quiet = json};
    lab_imported done;
    stein_err err = {STEIN_OK, ""};
    to = to != NULL ? to : "-";
    if (json && lab__is_stdout(to)) {
        return cli_misuse(args->command, "--json and -o %s both want standard output", to);
    }
    stein_status status =
        lab_import(args->operand[0], to, inertia_of(args), on_note, &t, &done, &err);
    if (status == STEIN_OK && json) {
        print_json(&done, to, &t);
    } else if (status == STEIN_OK) {
        fprintf(lab__is_stdout(to) ? stderr : stdout,
                "%s: %d bodies, %d joints, %d points, %d loops and links%s%s\n", done.name,
                done.bodies, done.joints, done.points, done.loops, lab__is_stdout(to) ? "" : " in ",
                lab__is_stdout(to) ? "" : to);
    }
    for (int i = 0; i < t.n; i++) {
        free(t.text[i]);
    }
    free(t.text);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "FILE.yaml",
     "The mechanism file; - is standard output, which is the default. A file appears whole or\n"
     "not at all."},
    {"inertia", 0, "accept|balance|refuse",
     "Treatment of an inertia that no body can have: accepted with a warning, replaced by\n"
     "three equal moments, or refused (the default). The written file states the choice."},
    {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},
    {"help", 'h', NULL, "Print this page."},
    {NULL, 0, NULL, NULL}};

const cli_command cli_import = {
    .name = "import",
    .summary = "a mechanism of another program (ROBOTRAN, URDF, MJCF) as a mechanism file",
    .operands = "FILE",
    .noperands = 1,
    .options = options,
    .description =
        "Reads a mechanism of another program and writes it as a mechanism file. The first\n"
        "element decides the format.\n"
        "\n"
        "A project of ROBOTRAN (.mbs, XML by MBsysPad): gravity, bodies with mass, centre, "
        "inertia\n"
        "and points, joints T1 to R3 with their initial values. A body with several joints\n"
        "becomes a chain of massless bodies, named like the joints, and itself. M and c agree\n"
        "with the project coordinate by coordinate, with the joints in the order of the file,\n"
        "parents first. Cuts become loops: ball, rod (with its length), solid (a weld).\n"
        "Independent joints keep their initial position; for dependent joints it is the start\n"
        "value of the search for a closed position. Driven and locked joints become inputs\n"
        "that hold their joint while nothing drives them, actuated ones torques, every\n"
        "external force three inputs along the fixed axes, and joints and sensors outputs.\n"
        "Links become springs without stiffness.\n"
        "\n"
        "A robot of ROS (URDF): links with their inertials, joints (revolute, continuous,\n"
        "prismatic, fixed, floating) with axis, origin, limits of position, damping, friction and\n"
        "mimic. Bodies have the names of the links; a link on a fixed joint becomes part of\n"
        "the body that carries it, and a point there. With all joints at 0 bodies have the\n"
        "axes of the world; a joint with an oblique axis is carried by hinges that are held\n"
        "at constant angles. Gravity is 9.81 m/s^2 along -z.\n"
        "\n"
        "A model of MuJoCo (MJCF): bodies with their orientations, inertials or the mass of their\n"
        "geoms, joints (hinge, slide, ball, free) with range, damping, stiffness, frictionloss\n"
        "and armature, default classes, equalities (connect, weld, joint) and actuators of\n"
        "joints, as torques.\n"
        "Included and repeated elements have to be written out, as in a file that MuJoCo saves.\n"
        "\n"
        "Elements without an equivalent are reported on standard error and listed at the head\n"
        "of the file: laws in C code of the project, with the names of the inputs and numbers\n"
        "to be filled; contacts, meshes, sensors, tendons; names that had to be changed.\n"
        "Drawings are passed over.\n"
        "Springs, contacts and friction can be added to the file: docs/mechanism-files.md.\n"
        "\n"
        "A file may hold numbers that no body has, such as a moment of inertia above the sum of\n"
        "the other two. The file is then written, the line is reported, and the exit status\n"
        "is 1, unless --inertia selects another treatment.",
    .output = "The mechanism file. A line with the number of bodies, joints, points and loops, or\n"
              "with --json: {\"model\", \"file\", \"bodies\", \"joints\", \"points\", "
              "\"loops\",\n\"left_out\": [...]}.",
    .examples = "stein import dataR/Suspension.mbs -o suspension.yaml\n"
                "stein import robot.urdf --inertia balance -o robot.yaml\n"
                "stein check suspension.yaml",
    .run = run,
};
