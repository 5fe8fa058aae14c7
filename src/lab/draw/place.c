/* SPDX-License-Identifier: GPL-3.0-or-later
 * place.c - the frames of all bodies along the tree, and the plane that a drawing shows.
 */
#include <math.h>
#include <stdlib.h>

#include "draw.h"

static const draw__frame fixed = {.R = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

static const draw__frame *frame_of(const draw__place *place, int body)
{
    return body < 0 ? &fixed : &place->frame[body];
}

static void turned(double out[3], const draw__frame *f, const double v[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = f->R[i][0] * v[0] + f->R[i][1] * v[1] + f->R[i][2] * v[2];
    }
}

double draw__value(const draw__place *place, mech_scalar s)
{
    return mech_value(place->m, s, place->p);
}

static void in_space(double out[3], const draw__place *place, int body, const mech_scalar v[3])
{
    double local[3];
    const draw__frame *f = frame_of(place, body);
    for (int i = 0; i < 3; i++) {
        local[i] = draw__value(place, v[i]);
    }
    turned(out, f, local);
    for (int i = 0; i < 3; i++) {
        out[i] += f->o[i];
    }
}

/* f turned by an angle about its own axis */
static void turn(draw__frame *f, int axis, double angle)
{
    double c = cos(angle), s = sin(angle);
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int i = 0; i < 3; i++) {
        double u = f->R[i][a], v = f->R[i][b];
        f->R[i][a] = c * u + s * v;
        f->R[i][b] = c * v - s * u;
    }
}

static void place_body(draw__place *place, int i, double q)
{
    const mech_body *b = &place->m->bodies[i];
    draw__frame f = *frame_of(place, b->parent);
    int axis = b->axis - 'x';
    in_space(f.o, place, b->parent, b->at);
    if (b->type == 'R') {
        turn(&f, axis, b->sign * q);
    } else {
        for (int k = 0; k < 3; k++) {
            f.o[k] += f.R[k][axis] * b->sign * q;
        }
    }
    place->frame[i] = f;
}

static int turns_about(const mechanism *m, char axis)
{
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].type == 'R' && m->bodies[i].axis == axis) {
            return 1;
        }
    }
    return 0;
}

/* contacts lie in x-z; else the plane that the first of y, x, z is normal to */
static void choose_plane(draw__place *place)
{
    const mechanism *m = place->m;
    int flat = m->ncontact > 0 || turns_about(m, 'y');
    int x = !flat && turns_about(m, 'x'), z = !flat && !x && turns_about(m, 'z');
    place->right = x ? 1 : 0;
    place->up = z ? 1 : 2;
}

stein_status draw__place_init(draw__place *place, const mechanism *m, const double *p,
                              const double *q, stein_err *err)
{
    *place = (draw__place){.m = m, .p = p};
    place->frame = calloc((size_t)m->nbody + 1, sizeof *place->frame);
    if (place->frame == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < m->nbody; i++) {
        place_body(place, i, q[i]);
    }
    choose_plane(place);
    return STEIN_OK;
}

void draw__place_free(draw__place *place)
{
    free(place->frame);
    place->frame = NULL;
}

draw__at draw__point(const draw__place *place, int body, const mech_scalar v[3])
{
    double x[3];
    in_space(x, place, body, v);
    return (draw__at){x[place->right], x[place->up]};
}

draw__at draw__origin(const draw__place *place, int body)
{
    const draw__frame *f = frame_of(place, body);
    return (draw__at){f->o[place->right], f->o[place->up]};
}

draw__at draw__direction(const draw__place *place, int body, double angle)
{
    double v[3] = {0.0}, x[3];
    v[place->right] = cos(angle);
    v[place->up] = sin(angle);
    turned(x, frame_of(place, body), v);
    return (draw__at){x[place->right], x[place->up]};
}
