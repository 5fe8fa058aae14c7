/* SPDX-License-Identifier: GPL-3.0-or-later
 * mjcf_geoms.c - mass, centre and inertia of a body of a MuJoCo model.
 *
 * Stated by <inertial>, otherwise the sum of the geoms: solids with `mass`, or `density` times
 * their volume (1000 kg/m^3 is the default).
 *
 *      sphere     4/3 pi r^3              2/5 m r^2
 *      ellipsoid  4/3 pi a b c            m/5 (b^2 + c^2) ...
 *      box        8 a b c                 m/3 (b^2 + c^2) ...
 *      cylinder   2 pi r^2 h              m/12 (3 r^2 + 4 h^2), m/2 r^2     (h: half of its length)
 *      capsule    a cylinder and the two halves of a sphere
 */
#include "mjcf.h"

#include <math.h>
#include <string.h>

static const double pi = 3.141592653589793;

/* a solid: its mass, and its moments about its own axes */
typedef struct solid {
    double mass, inertia[6], x[3], R[9];
} solid;

static void ellipsoid(solid *s, const double size[3])
{
    s->mass = 4.0 / 3.0 * pi * size[0] * size[1] * size[2];
    for (int i = 0; i < 3; i++) {
        double a = size[(i + 1) % 3], b = size[(i + 2) % 3];
        s->inertia[i] = s->mass / 5.0 * (a * a + b * b);
    }
}

static void box(solid *s, const double size[3])
{
    s->mass = 8.0 * size[0] * size[1] * size[2];
    for (int i = 0; i < 3; i++) {
        double a = size[(i + 1) % 3], b = size[(i + 2) % 3];
        s->inertia[i] = s->mass / 3.0 * (a * a + b * b);
    }
}

/* with round ends: a capsule */
static void cylinder(solid *s, double r, double h, int round_ends)
{
    double barrel = 2.0 * pi * r * r * h, ends = round_ends ? 4.0 / 3.0 * pi * r * r * r : 0.0;
    double across = barrel * (3.0 * r * r + 4.0 * h * h) / 12.0;
    /* halves of a sphere, 3/8 r from the flat side to the centre */
    across += ends * (2.0 / 5.0 * r * r + h * h + 0.75 * h * r);
    s->mass = barrel + ends;
    s->inertia[0] = s->inertia[1] = across;
    s->inertia[2] = 0.5 * barrel * r * r + 2.0 / 5.0 * ends * r * r;
}

/* the place of a geom, and with fromto half its length */
static void place(const mjcf *m, const xml_node *node, solid *s, double *half)
{
    double ends[6];
    if (mjcf_numbers(m, node, "@fromto", ends, 6, 6) != 6) {
        mjcf_numbers(m, node, "@pos", s->x, 3, 3);
        mjcf_orientation(m, node, s->R);
        return;
    }
    double along[3], length = 0.0;
    for (int i = 0; i < 3; i++) {
        along[i] = ends[3 + i] - ends[i];
        s->x[i] = 0.5 * (ends[3 + i] + ends[i]);
        length += along[i] * along[i];
    }
    length = sqrt(length);
    if (!(length > 0.0)) {
        draft_wrong(m->d, node, "both ends of fromto are one place");
        return;
    }
    *half = 0.5 * length;
    /* turn z there: yaw and pitch */
    double rpy[3] = {0.0, 0.0, 0.0};
    rpy[1] = atan2(sqrt(along[0] * along[0] + along[1] * along[1]), along[2]);
    rpy[2] = atan2(along[1], along[0]);
    frame_rotation(rpy, s->R);
}

/* @return is it a solid? */
static int take_solid(mjcf *m, const xml_node *node, const char *label, solid *s)
{
    const char *type = mjcf_text(m, node, "@type");
    double size[3] = {0.0, 0.0, 0.0}, half = 0.0;
    int from_to = mjcf_attribute(m, node, "@fromto") != NULL;
    *s = (solid){.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    if (mjcf_attribute(m, node, "@mesh") != NULL || strcmp(type, "mesh") == 0 ||
        strcmp(type, "sdf") == 0) {
        draft_note(m->d, "the mass of a mesh of %.60s (line %d): write an <inertial>", label,
                   node->line);
        return 0;
    }
    if (strcmp(type, "plane") == 0 || strcmp(type, "hfield") == 0) {
        return 0;
    }
    mjcf_numbers(m, node, "@size", size, 1, 3);
    place(m, node, s, &half);
    if (type[0] == '\0' || strcmp(type, "sphere") == 0) {
        const double all[3] = {size[0], size[0], size[0]};
        ellipsoid(s, all);
    } else if (strcmp(type, "capsule") == 0 || strcmp(type, "cylinder") == 0) {
        cylinder(s, size[0], from_to ? half : size[1], type[1] == 'a');
    } else if (strcmp(type, "box") == 0 || strcmp(type, "ellipsoid") == 0) {
        if (from_to) {
            size[1] = size[0];
            size[2] = half;
        }
        (type[0] == 'b' ? box : ellipsoid)(s, size);
    } else {
        draft_wrong(m->d, node, "a geom of type \"%.20s\", expected a solid, a plane or a mesh",
                    type);
        return 0;
    }
    double density = mjcf_number(m, node, "@density", 1000.0);
    double mass = mjcf_number(m, node, "@mass", density * s->mass);
    double scale = s->mass > 0.0 ? mass / s->mass : 0.0;
    s->mass = mass;
    for (int i = 0; i < 3; i++) {
        s->inertia[i] *= scale;
    }
    return m->d->status == STEIN_OK && mass > 0.0;
}

/* in the axes of the body of the draft: about its origin, then about the centre */
static void of_geoms(mjcf *m, const xml_node *node, const mjcf_body *b, draft_body *to)
{
    double about[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    for (const xml_node *n = xml_child(node, "geom"); n != NULL; n = xml_next(node, n, "geom")) {
        solid s;
        draft_body part;
        double T[9], x[3];
        if (!take_solid(m, n, b->label, &s)) {
            continue;
        }
        frame_multiply(b->C, s.R, T);
        frame_turn(b->C, s.x, x);
        frame_mass(&part, T, s.inertia);
        for (int i = 0; i < 3; i++) {
            x[i] += b->o[i];
            to->centre[i] += s.mass * x[i];
        }
        for (int e = 0; e < 6; e++) {
            about[e] += part.inertia[e];
        }
        frame_point(about, s.mass, x);
        to->mass += s.mass;
    }
    for (int i = 0; i < 3 && to->mass > 0.0; i++) {
        to->centre[i] /= to->mass;
    }
    frame_point(about, -to->mass, to->centre);
    memcpy(to->inertia, about, sizeof about);
}

static void of_inertial(mjcf *m, const xml_node *n, const mjcf_body *b, draft_body *to)
{
    double x[3] = {0.0, 0.0, 0.0}, I[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, R[9], T[9];
    mjcf_numbers(m, n, "@pos", x, 3, 3);
    mjcf_orientation(m, n, R);
    if (mjcf_numbers(m, n, "@fullinertia", I, 6, 6) == 0) {
        mjcf_numbers(m, n, "@diaginertia", I, 3, 3);
    }
    to->mass = mjcf_number(m, n, "@mass", 0.0);
    frame_multiply(b->C, R, T);
    frame_mass(to, T, I);
    frame_turn(b->C, x, to->centre);
    for (int i = 0; i < 3; i++) {
        to->centre[i] += b->o[i];
    }
}

void mjcf_mass(mjcf *m, const xml_node *node, const mjcf_body *b, draft_body *to)
{
    const xml_node *stated = xml_child(node, "inertial");
    const xml_node *compiler = xml_child(m->root, "compiler");
    const xml_node *by = xml_child(compiler, "@inertiafromgeom");
    int geoms = by != NULL && strcmp(by->text, "true") == 0;
    if (stated != NULL && !geoms) {
        of_inertial(m, stated, b, to);
    } else if (by == NULL || strcmp(by->text, "false") != 0) {
        of_geoms(m, node, b, to);
    }
}
