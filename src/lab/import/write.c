/* SPDX-License-Identifier: GPL-3.0-or-later
 * write.c - a draft as a mechanism file.
 */
#include <stdlib.h>
#include <string.h>

#include "draft.h"

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

static const char *body_name(const draft *d, int body)
{
    return body < 0 ? "frame" : d->body[body].name;
}

static void write_point_name(FILE *f, const draft *d, int point)
{
    fprintf(f, "%s.%s", body_name(d, d->point[point].body), d->point[point].name);
}

static void write_points(FILE *f, const draft *d, int body, const char *indent)
{
    int n = 0;
    for (int i = 0; i < d->npoint; i++) {
        const draft_point *p = &d->point[i];
        if (p->body == body) {
            if (n++ == 0) {
                fprintf(f, "%spoints:\n", indent);
            }
            fprintf(f, "%s  %s: ", indent, p->name);
            triple(f, "", p->x);
            fprintf(f, "\n");
        }
    }
}

/* ---- bodies ---- */

static void write_joint(FILE *f, const draft *d, const draft_body *b)
{
    if (b->parent >= 0) {
        fprintf(f, "    parent: %s\n", d->body[b->parent].name);
    }
    if (b->anchor >= 0) {
        fprintf(f, "    at: ");
        write_point_name(f, d, b->anchor);
        fprintf(f, "\n");
    } else if (!all_zero(b->at, 3)) {
        triple(f, "    at: ", b->at);
        fprintf(f, "\n");
    }
    switch (b->joint) {
    case 'B': fprintf(f, "    joint: ball\n"); break;
    case 'W': fprintf(f, "    joint: free\n"); break;
    default: fprintf(f, "    joint: %c %s%c\n", b->joint, b->sign < 0 ? "-" : "", b->axis);
    }
}

static void write_mass(FILE *f, const draft_body *b)
{
    static const char *const name[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    char number[LAB_NUMBER];
    fprintf(f, "    mass: %s\n", lab__number(number, b->mass));
    if (!all_zero(b->centre, 3)) {
        triple(f, "    centre: ", b->centre);
        fprintf(f, "\n");
    }
    if (!all_zero(b->inertia, DRAFT_INERTIA)) {
        const char *comma = "";
        fprintf(f, "    inertia: {");
        for (int i = 0; i < DRAFT_INERTIA; i++) {
            if (b->inertia[i] != 0.0) {
                fprintf(f, "%s%s: %s", comma, name[i], lab__number(number, b->inertia[i]));
                comma = ", ";
            }
        }
        fprintf(f, "}\n");
    }
}

static void write_initial(FILE *f, const draft *d, const draft_body *b)
{
    char number[2][LAB_NUMBER];
    int closed = d->nloop > 0 && b->start == DRAFT_STATED;
    lab__number(number[0], b->q);
    lab__number(number[1], b->qd);
    if (b->start == DRAFT_GUESSED && b->q != 0.0) {
        fprintf(f, "    initial: {guess: %s}\n", number[0]);
    } else if (b->start == DRAFT_STATED && (b->q != 0.0 || b->qd != 0.0 || closed)) {
        fprintf(f, "    initial: {position: %s, speed: %s}\n", number[0], number[1]);
    }
}

/* Inertia against a joint of its body, with `all` also of all that it carries, while all joints are
 * at 0 [kg m^2 or kg]. Bodies behind held hinges before a joint do not count. */
static double inertia_of(const draft *d, int body, int all)
{
    const draft_body *joint = &d->body[body];
    int axis = joint->axis - 'x';
    double sum = 0.0;
    for (int i = 0; i < d->nbody; i++) {
        const draft_body *b = &d->body[i];
        double r[3] = {b->centre[0], b->centre[1], b->centre[2]};
        int at = i;
        for (; at >= 0 && at != body; at = d->body[at].parent) {
            const draft_body *on = &d->body[at];
            const double *x = on->anchor >= 0 ? d->point[on->anchor].x : on->at;
            for (int k = 0; k < 3; k++) {
                r[k] += x[k];
            }
        }
        double y = r[(axis + 1) % 3], z = r[(axis + 2) % 3];
        if (at == body && (all || i == body)) {
            sum += joint->joint == 'T' ? b->mass : b->inertia[axis] + b->mass * (y * y + z * z);
        }
    }
    return sum + joint->armature;
}

/* Stops on which the body swings with 100 Hz. The reader chooses that stiffness by the body alone;
 * where that has no inertia, it is chosen here by the carried bodies. A body that carries nothing
 * either is refused for that. */
static void write_limits(FILE *f, const draft *d, int body)
{
    static const double rate = 2.0 * 3.141592653589793 * 100.0;
    const draft_body *b = &d->body[body];
    double inertia = inertia_of(d, body, 1);
    char number[3][LAB_NUMBER];
    lab__number(number[0], b->range[0]);
    lab__number(number[1], b->range[1]);
    if (inertia_of(d, body, 0) > 0.0) {
        fprintf(f, "    limits: [%s, %s]\n", number[0], number[1]);
    } else if (inertia > 0.0) {
        fprintf(f, "    limits: {range: [%s, %s], k: %s}\n", number[0], number[1],
                lab__number(number[2], inertia * rate * rate));
    }
}

static void write_law(FILE *f, const draft *d, int body)
{
    const draft_body *b = &d->body[body];
    char number[2][LAB_NUMBER];
    if (b->stiffness != 0.0) {
        fprintf(f, "    spring: {k: %s, %s: %s}\n", lab__number(number[0], b->stiffness),
                b->joint == 'T' ? "x0" : "theta0", lab__number(number[1], b->rest));
    }
    if (b->damping != 0.0) {
        fprintf(f, "    damping: %s\n", lab__number(number[0], b->damping));
    }
    if (b->armature != 0.0) {
        fprintf(f, "    armature: %s\n", lab__number(number[0], b->armature));
    }
    if (b->coulomb != 0.0) {
        fprintf(f, "    coulomb: {T: %s, w: %s}\n", lab__number(number[0], b->coulomb),
                lab__number(number[1], DRAFT_SMOOTH));
    }
    if (b->limited) {
        write_limits(f, d, body);
    }
}

static void write_body(FILE *f, const draft *d, int body)
{
    const draft_body *b = &d->body[body];
    fprintf(f, "  %s:\n", b->name);
    write_joint(f, d, b);
    write_mass(f, b);
    write_points(f, d, body, "    ");
    write_initial(f, d, b);
    write_law(f, d, body);
}

/* ---- the rest ---- */

static void write_loops(FILE *f, const draft *d, int links)
{
    int n = 0;
    for (int i = 0; i < d->nloop; i++) {
        const draft_loop *l = &d->loop[i];
        char number[LAB_NUMBER];
        if ((l->kind == DRAFT_LINK) != links) {
            continue;
        }
        fprintf(f, "%s  %s: {%s",
                n++ > 0 ? ""
                : links ? "\nlinks:\n"
                        : "\nloops:\n",
                l->name, links ? "from: " : "between: [");
        write_point_name(f, d, l->point[0]);
        fprintf(f, links ? ", to: " : ", ");
        write_point_name(f, d, l->point[1]);
        lab__number(number, l->length);
        switch (l->kind) {
        case DRAFT_ROD: fprintf(f, "], rod: %s}\n", number); break;
        case DRAFT_WELD: fprintf(f, "], weld: yes}\n"); break;
        case DRAFT_LINK: fprintf(f, ", k: 0, length: %s}\n", number); break;
        default: fprintf(f, "]}\n");
        }
    }
}

static void write_couplings(FILE *f, const draft *d)
{
    for (int i = 0; i < d->ncoupling; i++) {
        const draft_coupling *c = &d->coupling[i];
        char number[2][LAB_NUMBER];
        fprintf(f, "%s  %s: {joint: %s, follows: %s, ratio: %s, offset: %s}\n",
                i == 0 ? "\ncouplings:\n" : "", c->name, d->body[c->joint].name,
                d->body[c->follows].name, lab__number(number[0], c->ratio),
                lab__number(number[1], c->offset));
    }
}

static void write_inputs(FILE *f, const draft *d)
{
    static const char *const along[] = {"[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"};
    for (int i = 0; i < d->ninput; i++) {
        const draft_input *in = &d->input[i];
        fprintf(f, "%s  %s: ", i == 0 ? "\ninputs:\n" : "", in->name);
        if (in->kind == DRAFT_FORCE) {
            fprintf(f, "{force: ");
            write_point_name(f, d, in->index);
            fprintf(f, ", direction: %s}\n", along[in->axis]);
        } else if (in->kind == DRAFT_TORQUE) {
            fprintf(f, "{torque: %s}\n", d->body[in->index].name);
        } else {
            fprintf(f, "{motion: %s, idle: hold}\n", d->body[in->index].name);
        }
    }
}

static void write_outputs(FILE *f, const draft *d)
{
    static const char *const read[] = {"x", "y", "z", "vx", "vy", "vz"};
    for (int i = 0; i < d->noutput; i++) {
        const draft_output *out = &d->output[i];
        fprintf(f, "%s  %s: ", i == 0 ? "\noutputs:\n" : "", out->name);
        if (out->point >= 0) {
            fprintf(f, "{point: ");
            write_point_name(f, d, out->point);
            fprintf(f, ", read: %s}\n", read[out->axis]);
        } else {
            fprintf(f, "{joint: %s, read: position}\n", d->body[out->body].name);
        }
    }
}

static void write_head(FILE *f, const draft *d)
{
    static const char *const inertia[] = {"", "inertia: accept\n", "inertia: balance\n"};
    const char *name = strrchr(d->file, '/') != NULL ? strrchr(d->file, '/') + 1 : d->file;
    char shown[LAB_PRINTABLE];
    fprintf(f, "# Imported from %s %s by `stein import`. All numbers are SI.\n", d->program,
            lab__printable(shown, name));
    if (d->nnote > 0) {
        fprintf(f, "#\n# Left out or changed:\n");
    }
    for (int i = 0; i < d->nnote; i++) {
        fprintf(f, "#   %s\n", d->note[i]);
    }
    fprintf(f, "mechanism: %s\n%s", d->name, inertia[d->inertia]);
    triple(f, "gravity: ", d->gravity);
    fprintf(f, "\n\nbodies:\n");
}

stein_status draft_text(const draft *d, char **text, size_t *size, stein_err *err)
{
    FILE *f = lab__text_open(text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_head(f, d);
    for (int i = 0; i < d->nbody; i++) {
        write_body(f, d, i);
    }
    write_points(f, d, -1, "");
    write_loops(f, d, 1);
    write_loops(f, d, 0);
    write_couplings(f, d);
    write_inputs(f, d);
    write_outputs(f, d);
    fprintf(f, "\nsimulation: {dt: 1 ms, until: 1 s}\n");
    stein_status status = lab__text_close(f, text, err);
    *size = status == STEIN_OK ? strlen(*text) : 0;
    return status;
}
