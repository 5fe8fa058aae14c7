/* SPDX-License-Identifier: GPL-3.0-or-later
 * draw.c - a mechanism as SVG: bodies, joints, centres of mass, points, contacts, notches,
 * links, loops and inputs, in the state that its file begins with.
 */
#include <math.h>
#include <stdlib.h>

#include "functions.h"
#include "draw.h"

static const double width = 1000.0, margin = 70.0, least = 240.0, most = 900.0; /* [px] */

typedef struct drawing {
    FILE *f;
    const mechanism *m;
    draw__place place;
    double box[4];        /* left, bottom, right, top [m] */
    double scale, height; /* [px/m], [px] */
    draw__labels *labels;
} drawing;

static const char style[] =
    "<style>svg{background:#fff}text{font:16px Helvetica,Arial,sans-serif;text-anchor:middle;"
    "fill:#444}.body{font-weight:700;fill:#1f4e79}.contact{fill:#8a3b12}.input{fill:#1d6b3a}"
    ".limb{fill:none;stroke:#9db4c9;stroke-width:7;stroke-linecap:round}"
    ".joint{fill:#fff;stroke:#1f4e79;stroke-width:2}.mass{fill:#1f4e79}.point{fill:#444}"
    ".ground{fill:none;stroke:#777;stroke-width:2}.leader{fill:none;stroke:#aaa;stroke-width:1}"
    ".surface{fill:none;stroke:#c05a22;stroke-width:2}.endless{fill:none;stroke:#c05a22;"
    "stroke-dasharray:2 "
    "6}.rod{stroke:#777;stroke-width:4}.link{fill:none;stroke:#777;stroke-width:1.5}"
    ".force{fill:none;stroke:#1d6b3a;stroke-width:2}\n"
    "@media(prefers-color-scheme:dark){svg{background:#16181a}text{fill:#ccc}.body{fill:#8fbce6}"
    ".contact{fill:#eba07c}.input{fill:#86cf9f}.limb{stroke:#3d566c}.joint{fill:#16181a;stroke:"
    "#8fbce6}.mass{fill:#8fbce6}.point{fill:#ccc}.force{stroke:#86cf9f}}</style>\n";

/* ---- what has to be seen ---- */

static void see(drawing *d, draw__at at, double around)
{
    d->box[0] = fmin(d->box[0], at.x - around);
    d->box[1] = fmin(d->box[1], at.y - around);
    d->box[2] = fmax(d->box[2], at.x + around);
    d->box[3] = fmax(d->box[3], at.y + around);
}

/* an end of a line: -1 or 1 */
static draw__at end_of(const drawing *d, const mech_shape *s, int end)
{
    draw__at at = draw__point(&d->place, s->body, s->at);
    draw__at n = draw__direction(&d->place, s->body, draw__value(&d->place, s->facing));
    double along = draw__value(&d->place, s->extent[end > 0]);
    return (draw__at){at.x + along * n.y, at.y - along * n.x};
}

static void see_shape(drawing *d, const mech_shape *s)
{
    if (s->is_line && s->has_extent) {
        see(d, end_of(d, s, -1), 0.0);
        see(d, end_of(d, s, 1), 0.0);
    } else {
        see(d, draw__point(&d->place, s->body, s->at),
            s->is_line ? 0.0 : draw__value(&d->place, s->radius));
    }
}

static void see_all(drawing *d)
{
    const mechanism *m = d->m;
    d->box[0] = d->box[1] = INFINITY;
    d->box[2] = d->box[3] = -INFINITY;
    for (int i = 0; i < m->nbody; i++) {
        see(d, draw__origin(&d->place, i), 0.0);
        see(d, draw__point(&d->place, i, m->bodies[i].centre), 0.0);
        see(d, draw__point(&d->place, m->bodies[i].parent, m->bodies[i].at), 0.0);
    }
    for (int i = 0; i < m->npoint; i++) {
        see(d, draw__point(&d->place, m->points[i].body, m->points[i].at), 0.0);
    }
    for (int i = 0; i < m->ncontact; i++) {
        for (int k = 0; k < 2 * m->contacts[i].nspot; k++) {
            see_shape(d, &m->contacts[i].spot[k / 2].side[k % 2]);
        }
    }
}

static void choose_scale(drawing *d)
{
    see_all(d);
    double w = d->box[2] - d->box[0], h = d->box[3] - d->box[1], size = fmax(w, h);
    size = size > 0.0 ? size : 1.0;
    d->scale = fmin((width - 2.0 * margin) / fmax(w, 0.05 * size),
                    (most - 2.0 * margin) / fmax(h, 0.05 * size));
    d->height = fmax(least, h * d->scale + 2.0 * margin);
}

static draw__at px(const drawing *d, draw__at at)
{
    return (draw__at){0.5 * width + d->scale * (at.x - 0.5 * (d->box[0] + d->box[2])),
                      0.5 * d->height - d->scale * (at.y - 0.5 * (d->box[1] + d->box[3]))};
}

/* ---- parts ---- */

static void put_segment(const drawing *d, const char *kind, draw__at a, draw__at b)
{
    draw__at p = px(d, a), q = px(d, b);
    fprintf(d->f, "<path class=\"%s\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", kind, p.x, p.y, q.x, q.y);
}

static void put_disc(const drawing *d, const char *kind, draw__at at, double r)
{
    draw__at p = px(d, at);
    fprintf(d->f, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"/>\n", kind, p.x, p.y, r);
}

/* from the joint to all that the body carries */
static void put_limbs(const drawing *d, int body)
{
    const mechanism *m = d->m;
    draw__at o = draw__origin(&d->place, body);
    put_segment(d, "limb", o, draw__point(&d->place, body, m->bodies[body].centre));
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].parent == body) {
            put_segment(d, "limb", o, draw__point(&d->place, body, m->bodies[i].at));
        }
    }
    for (int i = 0; i < m->npoint; i++) {
        if (m->points[i].body == body) {
            put_segment(d, "limb", o, draw__point(&d->place, body, m->points[i].at));
        }
    }
    for (int i = 0; i < m->nnotch; i++) {
        if (m->notches[i].catcher == body) {
            put_segment(d, "limb", o, draw__point(&d->place, body, m->notches[i].corner));
        } else if (m->notches[i].beak == body) {
            put_segment(d, "limb", o, draw__point(&d->place, body, m->notches[i].end));
        }
    }
}

/* a pin, or a box on its guide */
static void put_joint(const drawing *d, int body)
{
    const mech_body *b = &d->m->bodies[body];
    draw__at base = draw__point(&d->place, b->parent, b->at), p = px(d, base);
    if (b->parent < 0) {
        fprintf(
            d->f,
            "<path class=\"ground\" d=\"M%.1f %.1fl-9 14h18zm-14 14h28m-26 0l-5 6m13 -6l-5 6m13 "
            "-6l-5 6m13 -6l-5 6\"/>\n",
            p.x, p.y);
    }
    if (b->type == 'R') {
        put_disc(d, "joint", base, 5.0);
    } else {
        draw__at at = px(d, draw__origin(&d->place, body));
        put_segment(d, "ground", base, draw__origin(&d->place, body));
        fprintf(d->f, "<rect class=\"joint\" x=\"%.1f\" y=\"%.1f\" width=\"12\" height=\"12\"/>\n",
                at.x - 6.0, at.y - 6.0);
    }
    draw__keep_off(d->labels, p.x, p.y, 6.0);
}

static void put_shape(const drawing *d, const mech_shape *s)
{
    draw__at at = draw__point(&d->place, s->body, s->at);
    if (s->end != 0) {
        put_disc(d, "surface", end_of(d, s, s->end), 3.0);
    } else if (!s->is_line) {
        put_disc(d, "surface", at, fmax(3.0, d->scale * draw__value(&d->place, s->radius)));
    } else if (s->has_extent) {
        put_segment(d, "surface", end_of(d, s, -1), end_of(d, s, 1));
    } else {
        draw__at n = draw__direction(&d->place, s->body, draw__value(&d->place, s->facing));
        double far = 0.6 * width / d->scale; // as far as the drawing goes
        put_segment(d, "endless", (draw__at){at.x - far * n.y, at.y + far * n.x},
                    (draw__at){at.x + far * n.y, at.y - far * n.x});
    }
}

static void put_link(const drawing *d, const mech_link *l)
{
    const mech_point *a = &d->m->points[l->point[0]], *b = &d->m->points[l->point[1]];
    draw__at p = px(d, draw__point(&d->place, a->body, a->at));
    draw__at q = px(d, draw__point(&d->place, b->body, b->at));
    double x = q.x - p.x, y = q.y - p.y, far = hypot(x, y);
    fprintf(d->f, "<path class=\"link\" d=\"M%.1f %.1f", p.x, p.y);
    for (int i = 1; i < 12 && far > 0.0; i++) {
        double side = (i % 2 ? 6.0 : -6.0) / far;
        fprintf(d->f, "L%.1f %.1f", p.x + x * i / 12.0 - side * y, p.y + y * i / 12.0 + side * x);
    }
    fprintf(d->f, "L%.1f %.1f\"/>\n", q.x, q.y);
}

static void put_notch(const drawing *d, const mech_notch *n)
{
    draw__at c = draw__point(&d->place, n->catcher, n->corner);
    double lean = draw__value(&d->place, n->lean) + acos(0.0);
    draw__at face = draw__direction(&d->place, n->catcher, lean);
    draw__at roof = draw__direction(&d->place, n->catcher, lean + draw__value(&d->place, n->angle));
    double far = 24.0 / d->scale;
    put_segment(d, "surface", c, (draw__at){c.x + far * face.x, c.y + far * face.y});
    put_segment(d, "surface", c, (draw__at){c.x + far * roof.x, c.y + far * roof.y});
    put_disc(d, "surface", draw__point(&d->place, n->beak, n->end), 3.0);
}

static void put_input(const drawing *d, const mech_input *in)
{
    if (in->kind == STEIN_INPUT_POINT) {
        const mech_point *p = &d->m->points[in->index];
        draw__at at = px(d, draw__point(&d->place, p->body, p->at));
        double v[3], n;
        for (int i = 0; i < 3; i++) {
            v[i] = draw__value(&d->place, in->direction[i]);
        }
        n = hypot(v[d->place.right], v[d->place.up]);
        double x = n > 0.0 ? v[d->place.right] / n : 0.0, y = n > 0.0 ? -v[d->place.up] / n : -1.0;
        fprintf(
            d->f,
            "<path class=\"force\" d=\"M%.1f %.1fL%.1f %.1fm%.1f %.1fL%.1f %.1fL%.1f %.1f\"/>\n",
            at.x - 46.0 * x, at.y - 46.0 * y, at.x - 4.0 * x, at.y - 4.0 * y, // shaft, then head
            -8.0 * x - 5.0 * y, -8.0 * y + 5.0 * x, at.x - 4.0 * x, at.y - 4.0 * y,
            at.x - 12.0 * x + 5.0 * y, at.y - 12.0 * y - 5.0 * x);
        return;
    }
    draw__at o = px(d, draw__origin(&d->place, in->index));
    fprintf(d->f, "<path class=\"force\" d=\"M%.1f %.1fa16 16 0 1 0 -28 0m-3 -9l3 9l8 -4\"/>\n",
            o.x + 14.0, o.y + 8.0);
}

static draw__at loop_end(const drawing *d, const mech_loop *l, int k)
{
    const mech_point *p = &d->m->points[l->index[k]];
    return draw__point(&d->place, p->body, p->at);
}

/* a rod as a line, points that meet as a ring; a coupling has no place */
static void put_loop(const drawing *d, const mech_loop *l)
{
    if (l->kind == MECH_ROD) {
        put_segment(d, "rod", loop_end(d, l, 0), loop_end(d, l, 1));
    } else if (l->kind != MECH_COUPLING) {
        put_disc(d, "joint", loop_end(d, l, 0), 6.0);
    }
}

/* ---- names ---- */

static void name_at(const drawing *d, draw__at at, const char *kind, const char *name)
{
    draw__at p = px(d, at);
    draw__name(d->labels, d->f, p.x, p.y, kind, name);
}

static void put_body_names(const drawing *d)
{
    for (int i = 0; i < d->m->nbody; i++) {
        draw__at o = draw__origin(&d->place, i);
        draw__at c = draw__point(&d->place, i, d->m->bodies[i].centre);
        name_at(d, (draw__at){0.5 * (o.x + c.x), 0.5 * (o.y + c.y)}, "body", d->m->bodies[i].name);
    }
}

static void put_names(const drawing *d)
{
    const mechanism *m = d->m;
    put_body_names(d);
    for (int i = 0; i < m->npoint; i++) {
        name_at(d, draw__point(&d->place, m->points[i].body, m->points[i].at), "name",
                m->points[i].name);
    }
    for (int i = 0; i < m->ncontact; i++) {
        const mech_shape *s = &m->contacts[i].spot[0].side[0];
        name_at(d, s->end != 0 ? end_of(d, s, s->end) : draw__point(&d->place, s->body, s->at),
                "contact", m->contacts[i].name);
    }
    for (int i = 0; i < m->nnotch; i++) {
        name_at(d, draw__point(&d->place, m->notches[i].catcher, m->notches[i].corner), "contact",
                m->notches[i].name);
    }
    for (int i = 0; i < m->nlink; i++) {
        const mech_point *a = &m->points[m->links[i].point[0]];
        const mech_point *b = &m->points[m->links[i].point[1]];
        draw__at p = draw__point(&d->place, a->body, a->at);
        draw__at q = draw__point(&d->place, b->body, b->at);
        name_at(d, (draw__at){0.5 * (p.x + q.x), 0.5 * (p.y + q.y)}, "name", m->links[i].name);
    }
    for (int i = 0; i < m->nloop; i++) {
        if (m->loops[i].kind != MECH_COUPLING) {
            draw__at p = loop_end(d, &m->loops[i], 0), q = loop_end(d, &m->loops[i], 1);
            name_at(d, (draw__at){0.5 * (p.x + q.x), 0.5 * (p.y + q.y)}, "name", m->loops[i].name);
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *in = &m->inputs[i];
        name_at(d,
                in->kind == STEIN_INPUT_POINT
                    ? draw__point(&d->place, m->points[in->index].body, m->points[in->index].at)
                    : draw__origin(&d->place, in->index),
                "input", in->name);
    }
}

/* ---- all of it ---- */

static void put_all(const drawing *d)
{
    const mechanism *m = d->m;
    fprintf(d->f,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" role=\"img\" "
            "aria-label=\"%s, drawn to scale\">\n%s",
            width, d->height, m->name, style);
    for (int i = 0; i < m->nbody; i++) {
        put_limbs(d, i);
    }
    for (int i = 0; i < m->ncontact; i++) {
        for (int k = 0; k < 2 * m->contacts[i].nspot; k++) {
            put_shape(d, &m->contacts[i].spot[k / 2].side[k % 2]);
        }
    }
    for (int i = 0; i < m->nlink; i++) {
        put_link(d, &m->links[i]);
    }
    for (int i = 0; i < m->nloop; i++) {
        put_loop(d, &m->loops[i]);
    }
    for (int i = 0; i < m->nbody; i++) {
        put_joint(d, i);
        put_disc(d, "mass", draw__point(&d->place, i, m->bodies[i].centre), 4.0);
    }
    for (int i = 0; i < m->nnotch; i++) {
        put_notch(d, &m->notches[i]);
    }
    for (int i = 0; i < m->npoint; i++) {
        put_disc(d, "point", draw__point(&d->place, m->points[i].body, m->points[i].at), 2.5);
    }
    for (int i = 0; i < m->ninput; i++) {
        put_input(d, &m->inputs[i]);
    }
    put_names(d);
    fputs("</svg>\n", d->f);
}

static stein_status draw_to(drawing *d, const char *path, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    d->f = file.stream;
    choose_scale(d);
    d->labels->width = width;
    d->labels->height = d->height;
    put_all(d);
    return lab__file_close(&file, 1, err);
}

stein_status lab__draw(const char *path, const lab_model *model, stein_err *err)
{
    if (stein__in_space(lab_equations(model))) {
        return lab__fail(err, STEIN_EINVAL,
                         "no drawing of \"%s\": it moves in space, and a drawing shows the x-z "
                         "plane",
                         lab_equations(model)->name);
    }
    drawing d = {.m = lab__mechanism(model), .labels = calloc(1, sizeof(draw__labels))};
    double *p = calloc((size_t)d.m->nparam + 1, sizeof *p);
    stein_sim *sim = NULL;
    stein_status status =
        d.labels != NULL && p != NULL ? lab_sim(model, NULL, &sim, err) : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < d.m->nparam; i++) {
        p[i] = d.m->params[i].value;
    }
    if (status == STEIN_OK) {
        status = draw__place_init(&d.place, d.m, p, stein_q(sim), err);
    }
    status = status == STEIN_OK ? draw_to(&d, path, err) : status;
    draw__place_free(&d.place);
    stein_sim_destroy(sim);
    free(p);
    free(d.labels);
    return status;
}
