/* SPDX-License-Identifier: GPL-3.0-or-later
 * linearise_print.c - a linearised mechanism as text, JSON and CSV.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linearise.h"

enum { MOST_COLUMNS = 8, MOST_NOTES = 16 };

static const char *body(const cli_linear *l, int joint)
{
    return l->model->bodies[joint].name;
}

static const char *mode_joint(const cli_linear *l, const lab_mode *mode)
{
    return body(l, l->system->joint[mode->coordinate]);
}

/* ---- edges ---- */

static const char *edge_kind(const stein_edge *e)
{
    static const char *const text[] = {"contact", "notch", "limit", "backlash"};
    return text[e->kind];
}

static const char *edge_name(const cli_linear *l, const stein_edge *e)
{
    return e->kind == STEIN_EDGE_CONTACT ? l->model->contacts[e->index].name
           : e->kind == STEIN_EDGE_NOTCH ? l->model->notches[e->index].name
                                         : body(l, e->index);
}

/* ---- text ---- */

static char *route(const stein_linear_system *s)
{
    return s->exact ? lab__text("exact derivatives")
                    : lab__text("differences (%s), good to %.1g", s->why, fmax(s->error, 1e-16));
}

/* eigenvalue and what it means */
static char *mode_text(const cli_linear *l, const lab_mode *m)
{
    const char *joint = mode_joint(l, m);
    double percent = 100.0 * m->share, size = hypot(m->re, m->im);
    switch (m->kind) {
    case LAB_OSCILLATES:
        return lab__text("%-12.6g +- %-12.6g i  %-12.6g %-12.4g %s (%.0f %%)", m->re, m->im,
                         m->frequency, m->damping, joint, percent);
    case LAB_NEUTRAL:
        return lab__text("%-12.6g    %-12s    %-25s %s (%.0f %%)", m->re, "",
                         "moves without a force", joint, percent);
    default:
        return lab__text("%-12.6g    %-12s    %s %-12.4g %s (%.0f %%)", m->re, "",
                         m->kind == LAB_DECAYS ? "decays in s " : "grows in s  ", 1.0 / size, joint,
                         percent);
    }
}

static void print_modes(const cli_linear *l)
{
    printf("\n  %-29s   %-12s %-12s %s\n", "eigenvalue [1/s]", "frequency Hz", "damping ratio",
           "most in (of the energy)");
    for (int i = 0; i < l->modes->n; i++) {
        char *text = mode_text(l, &l->modes->mode[i]);
        printf("  %s\n", text != NULL ? text : "");
        free(text);
    }
}

static void print_row(const char *before, const char *name, const double *states,
                      const double *inputs, const stein_linear_system *s)
{
    char *label = lab__text("%s%s", before, name);
    printf("  %-24.24s", label != NULL ? label : name);
    free(label);
    for (int k = 0; k < 2 * s->n; k++) {
        printf(" %12.6g", states[k]);
    }
    for (int i = 0; i < s->ninput; i++) {
        printf(" %12.6g", inputs[i]);
    }
    printf("\n");
}

static void print_matrices(const cli_linear *l)
{
    const stein_linear_system *s = l->system;
    if (2 * s->n + s->ninput > MOST_COLUMNS) {
        printf("\n  A [%d, %d], B [%d, %d], C [%d, %d] and D: with -o FILE.csv or --json\n",
               2 * s->n, 2 * s->n, 2 * s->n, s->ninput, s->noutput, 2 * s->n);
        return;
    }
    printf("\n  %-24s", "");
    for (int k = 0; k < 2 * s->n; k++) {
        char *label = lab__text("%s.%s", k < s->n ? "q" : "qd", body(l, s->joint[k % s->n]));
        printf(" %12.12s", label != NULL ? label : "");
        free(label);
    }
    for (int i = 0; i < s->ninput; i++) {
        printf(" %12.12s", l->model->inputs[s->input[i]].name);
    }
    printf("\n");
    for (int k = 0; k < 2 * s->n; k++) {
        print_row(k < s->n ? "d/dt q." : "d/dt qd.", body(l, s->joint[k % s->n]),
                  s->A + k * 2 * s->n, s->B + k * s->ninput, s);
    }
    for (int i = 1; i < s->noutput; i++) {
        print_row("", l->model->channels[i].name, s->C + i * 2 * s->n, s->D + i * s->ninput, s);
    }
}

void cli_linear_text(const cli_linear *l)
{
    const stein_linear_system *s = l->system;
    char *way = route(s), text[CLI_TEXT];
    printf("%s, linearised about %s\n", l->model->name, l->at);
    printf("  by %s; largest acceleration there %.1e\n\n", way != NULL ? way : "", s->residual);
    free(way);
    for (int k = 0; k < s->n; k++) {
        int j = s->joint[k], turns = l->model->bodies[j].type == 'R';
        printf("  %-24s %s", body(l, j), cli_quantity(text, l->q[j], turns ? "rad" : "m"));
        if (l->qd[j] != 0.0) {
            printf(", %g %s", l->qd[j], turns ? "rad/s" : "m/s");
        }
        printf("%s\n", k >= s->nfree ? ", moved by an input" : "");
    }
    for (int i = 0; i < s->nedge; i++) {
        printf("  ! %s %s is at its edge (%.1e apart): a small motion to the other side meets "
               "other forces\n",
               edge_kind(&s->edge[i]), edge_name(l, &s->edge[i]), s->edge[i].apart);
    }
    print_modes(l);
    print_matrices(l);
}

/* ---- JSON ---- */

static void put_matrix(lab__json *out, const char *name, const double *x, int rows, int columns)
{
    lab__json_open(out, name, '[');
    for (int i = 0; i < rows; i++) {
        lab__json_reals(out, NULL, x + i * columns, columns);
    }
    lab__json_close(out);
}

static void put_named(lab__json *out, const char *name, const char *unit)
{
    lab__json_open(out, NULL, '{');
    lab__json_text(out, "name", name);
    lab__json_text(out, "unit", unit);
}

static void put_names(lab__json *out, const cli_linear *l)
{
    const stein_linear_system *s = l->system;
    lab__json_open(out, "states", '[');
    for (int k = 0; k < 2 * s->n; k++) {
        char *name = lab__text("%s.%s", k < s->n ? "q" : "qd", body(l, s->joint[k % s->n]));
        put_named(out, name, lab_linear_unit(l->model, s, k, 0));
        lab__json_bool(out, "prescribed", k % s->n >= s->nfree);
        lab__json_close(out);
        free(name);
    }
    lab__json_close(out);
    lab__json_open(out, "inputs", '[');
    for (int i = 0; i < s->ninput; i++) {
        put_named(out, l->model->inputs[s->input[i]].name, lab_linear_input_unit(l->model, s, i));
        lab__json_close(out);
    }
    lab__json_close(out);
    lab__json_open(out, "outputs", '[');
    for (int i = 0; i < s->noutput; i++) {
        put_named(out, l->model->channels[i].name, l->model->channels[i].unit);
        lab__json_bool(out, "exact", !s->differences[i]);
        lab__json_close(out);
    }
    lab__json_close(out);
}

static void put_modes(lab__json *out, const cli_linear *l)
{
    static const char *const kind[] = {"oscillates", "decays", "grows", "neutral"};
    int n = l->system->nfree;
    lab__json_open(out, "modes", '[');
    for (int i = 0; i < l->modes->n; i++) {
        const lab_mode *m = &l->modes->mode[i];
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "kind", kind[m->kind]);
        lab__json_real(out, "re", m->re);
        lab__json_real(out, "im", m->im);
        lab__json_real(out, "frequency", m->frequency);
        lab__json_real(out, "damping", m->damping);
        lab__json_text(out, "joint", mode_joint(l, m));
        lab__json_real(out, "share", m->share);
        put_matrix(out, "shape", l->modes->shape + (size_t)i * 2 * (size_t)n, n, 2);
        lab__json_close(out);
    }
    lab__json_close(out);
}

static void put_edges(lab__json *out, const cli_linear *l)
{
    lab__json_open(out, "edges", '[');
    for (int i = 0; i < l->system->nedge; i++) {
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "kind", edge_kind(&l->system->edge[i]));
        lab__json_text(out, "name", edge_name(l, &l->system->edge[i]));
        lab__json_real(out, "apart", l->system->edge[i].apart);
        lab__json_close(out);
    }
    lab__json_close(out);
}

void cli_linear_json(const cli_linear *l)
{
    const stein_linear_system *s = l->system;
    lab__json out = {.stream = stdout};
    lab__json_open(&out, NULL, '{');
    lab__json_text(&out, "model", l->model->name);
    lab__json_text(&out, "at", l->at);
    lab__json_bool(&out, "exact", s->exact);
    lab__json_text(&out, "why", s->why);
    lab__json_real(&out, "error", s->error);
    lab__json_real(&out, "residual", s->residual);
    lab__json_open(&out, "state", '{');
    for (int j = 0; j < l->model->nq; j++) {
        lab__json_open(&out, body(l, j), '{');
        lab__json_real(&out, "position", l->q[j]);
        lab__json_real(&out, "speed", l->qd[j]);
        lab__json_close(&out);
    }
    lab__json_close(&out);
    put_names(&out, l);
    put_matrix(&out, "A", s->A, 2 * s->n, 2 * s->n);
    put_matrix(&out, "B", s->B, 2 * s->n, s->ninput);
    put_matrix(&out, "C", s->C, s->noutput, 2 * s->n);
    put_matrix(&out, "D", s->D, s->noutput, s->ninput);
    put_modes(&out, l);
    put_edges(&out, l);
    lab__json_close(&out);
}

/* ---- CSV ---- */

static char *csv_mode(const cli_linear *l, const lab_mode *m)
{
    char re[LAB_NUMBER], im[LAB_NUMBER], hertz[LAB_NUMBER], ratio[LAB_NUMBER];
    return lab__text("mode: %s +- %s i 1/s, %s Hz, damping ratio %s, most in %s",
                     lab__number(re, m->re), lab__number(im, m->im),
                     lab__number(hertz, m->frequency), lab__number(ratio, m->damping),
                     mode_joint(l, m));
}

/* a line, or *failed */
static void note(char **lines, int *n, int *failed, char *text)
{
    *failed |= text == NULL;
    if (text != NULL) {
        lines[(*n)++] = text;
    }
}

static int write_notes(const cli_linear *l, char **lines)
{
    const stein_linear_system *s = l->system;
    int n = 0, failed = 0;
    char *way = route(s), number[LAB_NUMBER];
    note(lines, &n, &failed, lab__text("model: %s", l->model->name));
    note(lines, &n, &failed, lab__text("equations: %s", l->model->equations));
    note(lines, &n, &failed, lab__text("about: %s", l->at));
    note(lines, &n, &failed, way != NULL ? lab__text("by: %s", way) : NULL);
    free(way);
    for (int i = 0; i < l->args->nset; i++) {
        const char *set = l->args->set[i];
        int length = (int)strcspn(set, "=");
        note(lines, &n, &failed, lab__text("set %.*s: %s", length, set, set + length + 1));
    }
    for (int j = 0; j < l->model->nq; j++) {
        const char *unit = l->model->bodies[j].type == 'R' ? "rad" : "m";
        note(lines, &n, &failed,
             lab__text("at %s: %s %s", body(l, j), lab__number(number, l->q[j]), unit));
    }
    for (int i = 0; i < l->modes->n; i++) {
        note(lines, &n, &failed, csv_mode(l, &l->modes->mode[i]));
    }
    for (int i = 0; i < s->nedge; i++) {
        note(lines, &n, &failed,
             lab__text("edge: %s %s", edge_kind(&s->edge[i]), edge_name(l, &s->edge[i])));
    }
    return !failed;
}

stein_status cli_linear_csv(const cli_linear *l, const char *path, stein_err *err)
{
    size_t most = MOST_NOTES + (size_t)l->args->nset + (size_t)l->model->nq + (size_t)l->modes->n +
                  (size_t)l->system->nedge;
    char **lines = calloc(most, sizeof *lines);
    int complete = lines != NULL && write_notes(l, lines);
    stein_status status =
        complete ? lab_linear_write(path, l->model, l->system, (const char *const *)lines, err)
                 : lab__no_memory(err);
    for (size_t i = 0; lines != NULL && lines[i] != NULL; i++) {
        free(lines[i]);
    }
    free(lines);
    return status;
}
