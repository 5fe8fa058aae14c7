/* SPDX-License-Identifier: GPL-3.0-or-later
 * touch.c - where surfaces meet, how deep, how fast, with what force.
 *
 * Nine spots. Six are a point P of a segment on a flat pad through Q with unit normal n (towards
 * the free side): depth x = (Q - P).n, closing speed xdot = -(v_P - v_pad).n with the velocities of
 * the two materials at P, sliding speed v = (v_P - v_pad).t with t = n turned by -90 degrees. The
 * point gets N n - mu(v) N t, the pad the opposite.
 *
 *   spot     point (on)         pad (on)                        n
 *   REST     rear   (key)       felt on the frame               up
 *   DIP      below  (key)       felt on the frame               up
 *   LOOPS    shank  (hammer)    loops on the key's rear         up, turns with the key
 *   STRING   head   (hammer)    the string (a coordinate when it gives)   down
 *   STOP     back   (pawl)      stop on the frame               left
 *   LOAD     front  (key)       underside of the load           down
 *
 * The notch: E the beak's end, C the corner, r = E - C, unit vectors e_r along the roof away from C
 * (to the left), e_v along the vertical face (up), e_b along the beak's upper face from E.
 * n_r = e_r turned by +90 (down), n_v = e_v turned by -90 (right), n_b = e_b turned by +90 (up).
 *
 *   s = r.e_r   how far E is under the roof        h = -r.n_r   how far E is above the roof's plane
 *
 *   memory UNDER:   TIP    E on the roof           depth h            where s > 0
 *                   CORNER C on the beak's face    depth r.n_b        where s > 0, push on beak
 * -n_b BESIDE:  FACE   E on the vertical face  depth -r.n_v       where h > 0 UNDER becomes BESIDE
 * when s < 0 and h > 0; BESIDE becomes UNDER when h < 0.
 *
 * Law: N = max(0, scale (a x^3 + b x^2 + c x) (x/0.1 mm)^p (1 + D xdot) (1 + hy tanh(xdot/1
 * cm/s))), x counted from where the pad begins (`gap` behind the drawn surface); and, with
 * adhesion, the pull -4 F u (1 - u), u = -x/r, over the range r in front of the surface. Within an
 * integration step the modes (which spots touch) are constant; a pad that is left within a step
 * carries nothing.
 */
#include <math.h>

#include "reality.h"

static const double felt_unit = 1e-4;  /* m */
static const double turn_speed = 0.01; /* m/s */

double rub_law(const rub *r, double v)
{
    double u = v / r->vt, surplus = 0.0;
    if (r->B1 > 0.0 || r->B1 < 0.0) {
        surplus = r->B1 * u / (1.0 + r->B2 * u * u * u * u);
    }
    return r->A * (1.0 - 2.0 / (1.0 + exp(2.0 * u)) + surplus); // tanh u, by the faster way
}

static double felt_law(const felt *f, double x, double xdot, double flow)
{
    if (x <= 0.0) {
        return 0.0;
    }
    double push = f->scale * x * (f->c + x * (f->b + x * f->a));
    if (f->power > 0.0 || f->power < 0.0) {
        push *= pow(x / felt_unit, f->power);
    }
    push *= 1.0 + f->D * xdot;
    if (f->hysteresis > 0.0 || f->hysteresis < 0.0) {
        push *= 1.0 + f->hysteresis * tanh(xdot / turn_speed);
    }
    push += f->layer * (x - flow);
    return push > 0.0 ? push : 0.0;
}

/* A meeting of two surfaces: place, normal on the first, pushed body. */
typedef struct meeting {
    segment *first, *second; /* second NULL: frame, load or string */
    int lift;                /* coordinate of a pad that moves up and down, or -1 */
    vec at, n;
    double depth;
    int covered; /* the pad's extent covers the place */
} meeting;

static vec relative_velocity(const instant *now, const meeting *m)
{
    vec v = seg_velocity(m->first, m->at);
    if (m->second != NULL) {
        v = vec_minus(v, seg_velocity(m->second, m->at));
    } else if (m->lift >= 0) {
        v.z -= now->v[m->lift];
    }
    return v;
}

static void push(instant *now, const meeting *m, vec force)
{
    seg_push(m->first, m->at, force);
    if (m->second != NULL) {
        seg_push(m->second, m->at, (vec){-force.x, -force.z});
    } else if (m->lift >= 0) {
        now->b[m->lift] -= force.z;
    }
}

static void meet(instant *now, const unsigned char *mode, int spot, const meeting *m)
{
    const felt *f = &now->a->felt[spot < NOTCH ? spot : NOTCH];
    double x = m->depth - f->gap;
    now->depth[spot] = m->depth;
    now->pressed[spot] = 0.0;
    now->guard[G_TOUCH + spot] = x;
    now->guard[G_NEAR + spot] = f->pull > 0.0 ? x + f->range : -1.0;
    now->guard[G_PUSH + spot] = 1.0;
    if (!m->covered || !(mode[G_TOUCH + spot] || mode[G_NEAR + spot])) {
        return; // most are apart most of the time: no speeds are needed there
    }
    double N, slide = 0.0;
    vec t = {m->n.z, -m->n.x};
    if (mode[G_TOUCH + spot]) {
        vec v = relative_velocity(now, m);
        double xdot = -vec_dot(v, m->n), flow = spot == DIP ? now->memory[FLOW] : 0.0;
        if (!(f->layer > 0.0)) {
            now->guard[G_PUSH + spot] = 1.0 + f->D * xdot;
        }
        N = outside_push(f, felt_law(f, x, xdot, flow), x, now->memory[FLOW]);
        now->pressed[spot] = fmax(x, 0.0);
        slide = N > 0.0 ? -N * rub_law(&f->friction, vec_dot(v, t)) : 0.0;
    } else {
        double u = -x / f->range;
        N = -4.0 * f->pull * u * (1.0 - u);
    }
    push(now, m, (vec){N * m->n.x + slide * t.x, N * m->n.z + slide * t.z});
}

/* a point on a pad that stands on the frame, on a segment, or moves up and down */
static void point_on_pad(instant *now, const unsigned char *mode, int spot, segment *s, vec point,
                         segment *carrier, int lift, vec pad)
{
    vec n = now->a->pad[spot];
    if (carrier != NULL) {
        pad = seg_place(carrier, pad);
        n = seg_rotate(carrier, n);
    } else if (lift >= 0) {
        pad.z += now->q[lift];
    }
    vec at = seg_place(s, point);
    meeting m = {s, carrier, lift, at, n, vec_dot(vec_minus(pad, at), n), 1};
    meet(now, mode, spot, &m);
}

static void notch(instant *now, const unsigned char *mode)
{
    const action *a = now->a;
    segment *pawl = &now->seg[S_PAWL], *hammer = &now->seg[S_HAMMER];
    vec C = seg_place(pawl, a->corner), E = seg_place(hammer, a->beak), r = vec_minus(E, C);
    vec e_r = seg_rotate(pawl, a->roof), n_r = seg_rotate(pawl, a->under),
        n_v = seg_rotate(pawl, a->right);
    vec down = seg_rotate(hammer, a->below_beak); // -n_b
    double s = vec_dot(r, e_r), h = -vec_dot(r, n_r);
    int under = !mode[MODE_BESIDE] && mode[G_OVER], beside = mode[MODE_BESIDE] && mode[G_ABOVE];

    meeting tip = {hammer, pawl, -1, E, n_r, h, under};
    meeting corner = {hammer, pawl, -1, C, down, -vec_dot(r, down), under};
    meeting face = {hammer, pawl, -1, E, n_v, -vec_dot(r, n_v), beside};
    meet(now, mode, TIP, &tip);
    meet(now, mode, CORNER, &corner);
    meet(now, mode, FACE, &face);
    now->guard[G_OVER] = s;
    now->guard[G_ABOVE] = h;
}

void touch_all(instant *now, const unsigned char *mode)
{
    const action *a = now->a;
    segment *key = &now->seg[S_KEY], *rear = &now->seg[now->rear];
    segment *hammer = &now->seg[S_HAMMER], *head = &now->seg[now->head];
    int string = a->string_k > 0.0 ? D_STRING : -1;
    vec load = {0.0, 0.0};
    point_on_pad(now, mode, REST, rear, a->rear, NULL, -1, a->rest_at);
    point_on_pad(now, mode, DIP, key, a->below, NULL, -1, a->dip_at);
    point_on_pad(now, mode, LOOPS, hammer, a->shank, rear, -1, a->loops_at);
    point_on_pad(now, mode, STRING, head, a->head, NULL, string, a->string_at);
    point_on_pad(now, mode, STOP, &now->seg[S_PAWL], a->back, NULL, -1, a->stop_at);
    point_on_pad(now, mode, LOAD, key, a->front, NULL, D_LOAD, load);
    notch(now, mode);
}
