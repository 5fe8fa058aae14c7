/* SPDX-License-Identifier: GPL-3.0-or-later
 * mbs_write.c - a ROBOTRAN project as a mechanism file.
 */
#include <stdlib.h>
#include <string.h>

#include "mbs.h"

static int all_zero(const double *x, int n)
{
    while (n > 0 && x[n - 1] == 0.0) {
        n--;
    }
    return n == 0;
}

static void triple(FILE *f, const char *key, const double x[3])
{
    char number[3][LAB_NUMBER];
    fprintf(f, "%s[%s, %s, %s]", key, lab__number(number[0], x[0]), lab__number(number[1], x[1]),
            lab__number(number[2], x[2]));
}

static void write_points(FILE *f, const mbs_project *p, int body, const char *indent)
{
    int n = 0;
    for (int i = 0; i < p->npoint; i++) {
        const mbs_point *point = &p->point[i];
        if (point->body == body) {
            if (n++ == 0) {
                fprintf(f, "%spoints:\n", indent);
            }
            fprintf(f, "%s  %s: ", indent, point->name);
            triple(f, "", point->x);
            fprintf(f, "\n");
        }
    }
}

/* where the first joint of a body is */
static void write_anchor(FILE *f, const mbs_project *p, const mbs_body *b)
{
    if (b->parent >= 0) {
        fprintf(f, "    parent: %s\n", p->body[b->parent].name);
    }
    if (b->anchor >= 0) {
        fprintf(f, "    at: %s.%s\n", b->parent < 0 ? "frame" : p->body[b->parent].name,
                p->point[b->anchor].name);
    }
}

static void write_mass(FILE *f, const mbs_body *b)
{
    static const char *const name[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    char number[LAB_NUMBER];
    fprintf(f, "    mass: %s\n", lab__number(number, b->mass));
    if (!all_zero(b->centre, 3)) {
        triple(f, "    centre: ", b->centre);
        fprintf(f, "\n");
    }
    if (!all_zero(b->inertia, MBS_INERTIA)) {
        const char *comma = "";
        fprintf(f, "    inertia: {");
        for (int i = 0; i < MBS_INERTIA; i++) {
            if (b->inertia[i] != 0.0) {
                fprintf(f, "%s%s: %s", comma, name[i], lab__number(number, b->inertia[i]));
                comma = ", ";
            }
        }
        fprintf(f, "}\n");
    }
}

static void write_body(FILE *f, const mbs_project *p, int body)
{
    const mbs_body *b = &p->body[body];
    const char *above = NULL; // massless body between two joints
    for (int i = 0; i < p->njoint; i++) {
        const mbs_joint *j = &p->joint[i];
        char number[2][LAB_NUMBER];
        if (j->body != body) {
            continue;
        }
        fprintf(f, "  %s:\n", j->carries);
        if (above == NULL) {
            write_anchor(f, p, b);
        } else {
            fprintf(f, "    parent: %s\n", above);
        }
        fprintf(f, "    joint: %c %c\n", j->type, j->axis);
        if (strcmp(j->carries, b->name) == 0) {
            write_mass(f, b);
            write_points(f, p, body, "    ");
        } else {
            fprintf(f, "    mass: 0\n");
        }
        if (j->q != 0.0 || j->qd != 0.0) {
            fprintf(f, "    initial: {position: %s, speed: %s}\n", lab__number(number[0], j->q),
                    lab__number(number[1], j->qd));
        }
        above = j->carries;
    }
}

static void write_head(FILE *f, const mbs_project *p)
{
    const char *name = strrchr(p->file, '/') != NULL ? strrchr(p->file, '/') + 1 : p->file;
    char shown[LAB_PRINTABLE];
    fprintf(f, "# Imported from ROBOTRAN's project %s by `stein import`. All numbers are SI.\n",
            lab__printable(shown, name));
    if (p->nnote > 0) {
        fprintf(f, "#\n# Left out or changed:\n");
    }
    for (int i = 0; i < p->nnote; i++) {
        fprintf(f, "#   %s\n", p->note[i]);
    }
}

static void write_all(FILE *f, const mbs_project *p)
{
    int driven = 0;
    write_head(f, p);
    fprintf(f, "mechanism: %s\n", p->name);
    triple(f, "gravity: ", p->gravity);
    fprintf(f, "\n\nbodies:\n");
    for (int i = 0; i < p->nbody; i++) {
        write_body(f, p, i);
    }
    write_points(f, p, -1, "");
    for (int i = 0; i < p->njoint; i++) {
        if (p->joint[i].driven) {
            fprintf(f, "%s  drive_%.26s: {motion: %s, idle: hold}\n",
                    driven++ == 0 ? "\ninputs:\n" : "", p->joint[i].name, p->joint[i].carries);
        }
    }
    fprintf(f, "\noutputs:\n");
    for (int i = 0; i < p->njoint; i++) {
        fprintf(f, "  %s: {joint: %s, read: position}\n", p->joint[i].name, p->joint[i].carries);
    }
    fprintf(f, "\nsimulation: {dt: 1 ms, until: 1 s}\n");
}

stein_status mbs_text(const mbs_project *p, char **text, size_t *size, stein_err *err)
{
    FILE *f = lab__text_open(text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_all(f, p);
    stein_status status = lab__text_close(f, text, err);
    *size = status == STEIN_OK ? strlen(*text) : 0;
    return status;
}
