/* SPDX-License-Identifier: GPL-3.0-or-later
 * write.c - the files for the diagnosis: the mechanism file and the records.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

/* ---- the mechanism file ---- */

static void put(FILE *f, const mech *m, int index)
{
    const number *n = index < 0 ? NULL : &m->number[index];
    if (n == NULL) {
        fprintf(f, "0");
        return;
    }
    fprintf(f, "%.10g%s%s", n->file / n->scale,
            *n->shown != '\0' && strcmp(n->shown, "1") ? " " : "",
            strcmp(n->shown, "1") != 0 ? n->shown : "");
    if (n->tolerance) {
        int is_one = *n->shown == '\0' || strcmp(n->shown, "1") == 0;
        fprintf(f, " +- %.2g%s%s", n->sd / n->scale, is_one ? "" : " ", is_one ? "" : n->shown);
    }
}

static void put_place(FILE *f, const mech *m, const int at[3])
{
    fprintf(f, "[");
    for (int i = 0; i < 3; i++) {
        fprintf(f, "%s", i > 0 ? ", " : "");
        put(f, m, at[i]);
    }
    fprintf(f, "]");
}

/* "key: {a: 1, b: 2}" of the stated numbers first .. first + n - 1, by the ends of their names */
static void put_group(FILE *f, const mech *m, const char *indent, const char *key, int first, int n)
{
    int some = 0;
    for (int i = first; i < first + n; i++) {
        const char *dot = strrchr(m->number[i].name, '.');
        if (m->number[i].stated) {
            if (some++ == 0) {
                fprintf(f, "%s%s: {", indent, key);
            }
            fprintf(f, "%s%s: ", some > 1 ? ", " : "", dot + 1);
            put(f, m, i);
        }
    }
    if (some > 0) {
        fprintf(f, "}\n");
    }
}

static void put_single(FILE *f, const mech *m, const char *key, int index)
{
    if (m->number[index].stated) {
        fprintf(f, "    %s: ", key);
        put(f, m, index);
        fprintf(f, "\n");
    }
}

static void put_points(FILE *f, const mech *m, int on, const char *indent)
{
    int some = 0;
    for (int i = 0; i < m->npoint; i++) {
        if (m->point[i].body == on) {
            fprintf(f, "%s%s: ", some++ > 0 ? ", " : indent, m->point[i].name);
            put_place(f, m, m->point[i].at);
        }
    }
    fprintf(f, some > 0 ? "}\n" : "");
}

static void put_body(FILE *f, const mech *m, int i, const setup *start)
{
    const body *b = &m->body[i];
    static const char *const axis = "xyz", *const what[] = {"xx", "yy", "zz"};
    fprintf(f, "  %s:\n", b->name);
    if (b->parent >= 0) {
        fprintf(f, "    parent: %s\n", m->body[b->parent].name);
    }
    fprintf(f, "    joint: %c %s%c\n", b->type, b->sign < 0 ? "-" : "", axis[b->axis]);
    if (b->at[0] >= 0 || b->at[2] >= 0) {
        fprintf(f, "    at: ");
        put_place(f, m, b->at);
        fprintf(f, "\n");
    }
    fprintf(f, "    mass: ");
    put(f, m, b->mass);
    fprintf(f, "\n    centre: ");
    put_place(f, m, b->centre);
    fprintf(f, "\n");
    int some = 0;
    for (int k = 0; k < 3; k++) {
        if (b->inertia[k] >= 0) {
            fprintf(f, "%s%s: ", some++ > 0 ? ", " : "    inertia: {", what[k]);
            put(f, m, b->inertia[k]);
        }
    }
    fprintf(f, some > 0 ? "}\n" : "");
    if (start != NULL && isfinite(start->said[i])) {
        fprintf(f, "    initial: {position: %.15g}\n", start->said[i]);
    }
    put_points(f, m, i, "    points: {");
    put_group(f, m, "    ", "spring", b->law + J_K, 3);
    put_single(f, m, "damping", b->law + J_B);
    put_group(f, m, "    ", "coulomb", b->law + J_T, 3);
    put_group(f, m, "    ", "friction", b->law + J_A, J_BUMP - J_A);
}

static void put_round(FILE *f, const mech *m, const contact *c, int side)
{
    const point *p = &m->point[c->point[side]];
    const char *owner = p->body < 0 ? "frame" : m->body[p->body].name;
    if (c->radius[side] < 0) {
        fprintf(f, "      - {point: %s.%s}\n", owner, p->name);
        return;
    }
    fprintf(f, "      - {circle: {at: %s.%s, radius: ", owner, p->name);
    put(f, m, c->radius[side]);
    fprintf(f, "}}\n");
}

static void put_contact(FILE *f, const mech *m, const contact *c)
{
    fprintf(f, "  %s:\n    between:\n", c->name);
    put_round(f, m, c, 0);
    if (c->point[1] >= 0) {
        put_round(f, m, c, 1);
    } else {
        int at[3] = {c->line_at[0], -1, c->line_at[1]};
        fprintf(f, "      - {line: {on: %s, at: ",
                c->line_body < 0 ? "frame" : m->body[c->line_body].name);
        put_place(f, m, at);
        fprintf(f, ", facing: ");
        put(f, m, c->facing);
        fprintf(f, "}}\n");
    }
    put_group(f, m, "    ", "normal", c->law + N_A, N_GAP);
    put_group(f, m, "    ", "friction", c->law + N_MU, N_SIZE - N_MU);
}

static void put_inputs(FILE *f, const mech *m)
{
    fprintf(f, m->ninput > 0 ? "\ninputs:\n" : "");
    for (int i = 0; i < m->ninput; i++) {
        const input *in = &m->input[i];
        const char *on = m->body[in->body].name;
        if (in->kind == INPUT_FORCE) {
            fprintf(f, "  %s: {force: %s.%s, direction: [0, 0, -1]}\n", in->name, on,
                    m->point[in->point].name);
        } else {
            fprintf(f, "  %s: {%s: %s}\n", in->name, in->kind == INPUT_MOTION ? "motion" : "torque",
                    on);
        }
    }
}

static void put_outputs(FILE *f, const mech *m)
{
    static const char *const read[] = {"position", "speed", "x", "z", "gap", "force"};
    fprintf(f, "\noutputs:\n");
    for (int i = 0; i < m->nchannel; i++) {
        const channel *c = &m->channel[i];
        const point *p = &m->point[c->index];
        int of_point = c->read == READ_X || c->read == READ_Z;
        fprintf(f, "  %s: {%s: ", c->name,
                of_point                 ? "point"
                : c->read == READ_GAP    ? "contact"
                : c->read == READ_EFFORT ? "input"
                                         : "joint");
        if (of_point) {
            fprintf(f, "%s.%s", p->body < 0 ? "frame" : m->body[p->body].name, p->name);
        } else {
            fprintf(f, "%s",
                    c->read == READ_GAP      ? m->contact[c->index].name
                    : c->read == READ_EFFORT ? m->input[c->index].name
                                             : m->body[c->index].name);
        }
        fprintf(f, ", read: %s", read[c->read]);
        if (m->number[c->law + S_OFFSET].stated) {
            fprintf(f, ", sensor: {offset: ");
            put(f, m, c->law + S_OFFSET);
            fprintf(f, "}");
        }
        fprintf(f, "}\n");
    }
}

int write_model(const char *folder, const mech *m, const design *d, int exact)
{
    char path[PATH + 20];
    double longest = 0.0;
    snprintf(path, sizeof path, "%s/model.yaml", folder);
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        perror(path);
        return -1;
    }
    fprintf(f, "mechanism: %s\nabout: %s\n", m->name, m->about);
    fprintf(f, "gravity: [%g, %g, %g]\n\nbodies:\n", m->gravity[0], m->gravity[1], m->gravity[2]);
    for (int i = 0; i < m->nbody; i++) {
        put_body(f, m, i, exact ? &d->record[0] : NULL);
    }
    put_points(f, m, -1, "\npoints: {");
    fprintf(f, m->nlink > 0 ? "\nlinks:\n" : "");
    for (int i = 0; i < m->nlink; i++) {
        const point *a = &m->point[m->link[i].point[0]], *b = &m->point[m->link[i].point[1]];
        fprintf(f, "  %s: {from: %s.%s, to: %s.%s, k: ", m->link[i].name,
                a->body < 0 ? "frame" : m->body[a->body].name, a->name,
                b->body < 0 ? "frame" : m->body[b->body].name, b->name);
        put(f, m, m->link[i].law + L_K);
        fprintf(f, ", length: ");
        put(f, m, m->link[i].law + L_LENGTH);
        fprintf(f, "}\n");
    }
    fprintf(f, m->ncontact > 0 ? "\ncontacts:\n" : "");
    for (int i = 0; i < m->ncontact; i++) {
        put_contact(f, m, &m->contact[i]);
    }
    put_inputs(f, m);
    put_outputs(f, m);
    for (int i = 0; i < d->nfit + d->nheld; i++) {
        longest = fmax(longest, d->record[i].n / d->rate);
    }
    fprintf(f, "\nsimulation: {dt: %g s, until: %g s, integrator: dp5%s}\n",
            exact ? m->dt : 10 * m->dt, ceil(10.0 * longest) / 10.0,
            m->settle ? ", settle: yes" : "");
    return fclose(f) == 0 ? 0 : -1;
}

/* ---- a record ---- */

static void head(FILE *f, const mech *m, const design *d, const setup *s)
{
    for (int b = 0; b < m->nbody; b++) {
        if (isfinite(s->said[b])) {
            int turns = m->body[b].type == 'R';
            fprintf(f, "# set %s.initial.position: %.6g %s\n", m->body[b].name,
                    turns ? s->said[b] * 180.0 / 3.14159265358979323846 : s->said[b] * 1e3,
                    turns ? "deg" : "mm");
        }
    }
    for (int c = 0; d->noise_told && c < m->nchannel; c++) {
        fprintf(f, "# noise %s: %.3g %s\n", m->channel[c].name, d->sensor[c].sd,
                m->channel[c].unit);
    }
    fprintf(f, "# trigger: synchronised\n");
}

int write_record(const char *path, const mech *m, const mech *told, const double *p,
                 const design *d, const setup *s, const wrong *w, chance *c, int exact)
{
    double *y = malloc(sizeof *y * (size_t)s->n * (size_t)m->nchannel);
    FILE *f = y != NULL ? fopen(path, "w") : NULL;
    int n = told->nchannel;
    if (f == NULL || record_film(m, p, d, s, 1, exact ? 1e-12 : 1e-9, y) != 0) {
        fprintf(stderr, "world: %s cannot be made\n", path);
        free(y);
        return f == NULL ? -1 : (fclose(f), -1);
    }
    head(f, told, d, s);
    fprintf(f, "time [s]");
    for (int i = 0; i < told->ninput; i++) {
        fprintf(f, ",%s [%s]", told->input[i].name, told->input[i].unit);
    }
    for (int k = 0; k < n; k++) {
        fprintf(f, ",%s [%s]", told->channel[k].name, told->channel[k].unit);
    }
    fprintf(f, "\n");
    for (int i = 0; i < s->n; i++) {
        double t = i / d->rate;
        fprintf(f, exact ? "%.12g" : "%.7g", t * w->time);
        for (int k = 0; k < told->ninput; k++) {
            double u = m->input[k].kind == INPUT_MOTION ? signal_value(&s->drive[k], t)
                                                        : signal_value(&s->drive[k], t);
            fprintf(f, exact ? ",%.15g" : ",%.7g", exact ? u : record_noisy(&d->input[k], u, c));
        }
        for (int k = 0; k < n; k++) {
            int from = w->swap[0] < 0    ? k
                       : k == w->swap[0] ? w->swap[1]
                       : k == w->swap[1] ? w->swap[0]
                                         : k;
            double v = y[i * m->nchannel + from];
            v = exact ? v : record_noisy(&d->sensor[from], v, c);
            fprintf(f, exact ? ",%.15g" : ",%.7g", v * w->unit[k]);
        }
        fprintf(f, "\n");
    }
    free(y);
    return fclose(f) == 0 ? 0 : -1;
}
