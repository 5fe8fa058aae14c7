/* SPDX-License-Identifier: GPL-3.0-or-later
 * hidden.c - the formulas of what no model file mentions, and of the player's touch.
 *
 * Joints (coordinate q, speed w; torque on q):
 *   viscous -b w      Coulomb -T tanh(w/w0)      air -k |w| w       preload T
 *   stiffness -k q    hardening -k3 (q - theta0)^3
 *   backlash -k (|q| - gap) sign(q) beyond +-gap
 *   friction that warms up: -T tanh(w/w0) exp(-H), dH/dt = |w|/w_h - H/t_h   (H: a memory)
 * Parts:
 *   string damper: from key dip x0 on the front of the key is pushed up by F0 + k (dip - x0)
 *   wire: from the key's front to a point of the frame, pull k (l - l0) along the line
 *   magnet: the head is drawn to a point at r by C r/(r^2 + d^2)^(3/2), d = 5 mm
 *   felt's second layer that flows: + k2 (x - s), ds/dt = (x - s)/t (x <= 0: -s/t)
 *   pin of the key: up u, force -k u - d udot, stiffer by a ratio where the key presses down
 *   string on a spring: m wdd = push - k w - d wdot
 *   split links: torque k dphi + d dphidot between the two pieces
 */
#include <math.h>

#include "reality.h"

static const double magnet_core = 5e-3;

double hidden_torque(const hinge *h, double q, double w, double heat)
{
    double torque = -h->viscous * w - h->drag * fabs(w) * w + h->preload - h->stiffness * q;
    if (h->coulomb > 0.0) {
        torque -= h->coulomb * tanh(w / h->coulomb_w0);
    }
    if (h->creep > 0.0) {
        torque -= h->creep * tanh(w / h->creep_w0) * exp(-heat);
    }
    double x = q - h->theta0;
    torque -= h->hardening * x * x * x;
    torque += outside_torque(h, q);
    if (h->slack_k > 0.0 && fabs(q) > h->slack) {
        torque -= h->slack_k * (fabs(q) - h->slack) * (q > 0.0 ? 1.0 : -1.0);
    }
    return torque;
}

static void couple(segment *a, segment *b, const split *s)
{
    double torque = s->k * (b->phi - a->phi) + s->d * (b->w - a->w);
    a->M += torque;
    b->M -= torque;
}

static void string_damper(instant *now, const unsigned char *mode)
{
    const action *a = now->a;
    segment *key = &now->seg[S_KEY];
    vec front = seg_place(key, a->front);
    double dip = a->front.z - front.z; // from the drawn position
    int there = a->damper_force > 0.0 || a->damper_k > 0.0;
    now->guard[G_DAMPER] = there ? dip - a->damper_at : -1.0;
    if (mode[G_DAMPER]) {
        double push = a->damper_force + a->damper_k * (dip - a->damper_at);
        seg_push(key, front, (vec){0.0, push});
    }
}

static void towards(segment *s, vec at, vec to, double pull_per_length)
{
    seg_push(s, at, (vec){pull_per_length * (to.x - at.x), pull_per_length * (to.z - at.z)});
}

static void memories(instant *now, const unsigned char *mode)
{
    const action *a = now->a;
    const hinge *key = &a->joint[JOINT_KEY];
    now->memory_rate[FLOW] = now->memory_rate[HEAT] = 0.0;
    if (a->felt[DIP].layer > 0.0) {
        double x = mode[G_TOUCH + DIP] ? now->depth[DIP] - a->felt[DIP].gap : 0.0;
        now->memory_rate[FLOW] = (x - now->memory[FLOW]) / a->felt[DIP].layer_time;
    }
    for (int i = 0; i < NOTCH; i++) {
        if (a->felt[i].ease > 0.0) {
            now->memory_rate[FLOW] =
                outside_memory_rate(&a->felt[i], mode[G_TOUCH + i], now->memory[FLOW]);
        }
    }
    if (key->creep > 0.0) {
        now->memory_rate[HEAT] =
            fabs(now->v[D_KEY]) / key->creep_turn - now->memory[HEAT] / key->creep_time;
    }
}

void hidden_forces(instant *now, const unsigned char *mode)
{
    const action *a = now->a;
    segment *seg = now->seg;
    if (a->key_split.on) {
        couple(&seg[S_KEY], &seg[S_REAR], &a->key_split);
    }
    if (a->hammer_split.on) {
        couple(&seg[S_HAMMER], &seg[S_HEAD], &a->hammer_split);
    }
    if (a->pin_k > 0.0) {
        double u = now->q[D_PIN], k = u > 0.0 ? a->pin_k / a->pin_ratio : a->pin_k;
        now->b[D_PIN] -= k * u + a->pin_d * now->v[D_PIN];
    }
    if (a->string_k > 0.0) {
        now->b[D_STRING] -= a->string_k * now->q[D_STRING] + a->string_d * now->v[D_STRING];
    }
    string_damper(now, mode);
    if (a->wire_k > 0.0) {
        vec at = seg_place(&seg[S_KEY], a->front);
        double l = hypot(at.x - a->wire_from.x, at.z - a->wire_from.z);
        towards(&seg[S_KEY], at, a->wire_from, a->wire_k * (l - a->wire_length) / l);
    }
    if (a->magnet > 0.0) {
        vec at = seg_place(&seg[now->head], a->head);
        double dx = a->magnet_at.x - at.x, dz = a->magnet_at.z - at.z;
        double r2 = dx * dx + dz * dz + magnet_core * magnet_core;
        towards(&seg[now->head], at, a->magnet_at, a->magnet / (r2 * sqrt(r2)));
    }
    memories(now, mode);
}

/* The player's touch: rises like 10 s^3 - 15 s^4 + 6 s^5 and stays. Value and two derivatives. */
void hidden_touch(double t, const action *a, double u[3])
{
    double T = a->drive_time, s = t / T, size = a->drive_size, way = 1.0;
    if (a->drive_back && s > 1.0) {
        s = fmax(2.0 - s, 0.0);
        way = -1.0;
    }
    u[0] = s < 1.0 ? 0.0 : size;
    u[1] = u[2] = 0.0;
    if (s > 0.0 && s < 1.0) {
        u[0] = size * s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
        u[1] = way * size / T * 30.0 * s * s * (1.0 - s) * (1.0 - s);
        u[2] = size / (T * T) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
    }
}
