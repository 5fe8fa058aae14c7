/* SPDX-License-Identifier: MIT
 * chart.c - joints that turn in all directions without a gimbal lock.
 *
 *      R = Rz(chart) Rx(a) Ry(b) Rz(c)      from the body's axes to those of its parent
 *
 * The chart is the first of four angles of a ball joint, and is constant during a motion. The other
 * three, a, b, c, are ordinary coordinates. The equations, steps and dense output have no special
 * case for balls. The axes of a and c are parallel where |sin b| = 1, that is, where z of the body
 * points along x of the chart. Before that, at the end of a step, the chart is turned about z until
 * b = 0; attitude and angular velocity do not change. Whole turns of a and c are subtracted,
 * because large angles are rounded more.
 *
 * Rejected: quaternions. Their speeds are not their derivatives. Integrators, dense output,
 * derivatives and every reader of q and qd would have to know which coordinates are one, and
 * steps would need a projection. With a chart only the end of a step has a special case.
 *
 * The chart is one of the coordinates, so that a saved state has it. What a step does depends on
 * the state alone.
 */
#include <math.h>

#include "core.h"

static const double most_tilt = 0.8;     /* |sin b| beyond which a chart is left: b = 53 deg */
static const double most_turned = 512.0; /* [rad] of a and c */
/* 2 pi, of which multiples are exact, and the rest of it */
static const double turn_whole = 6.28125, turn_rest = 0.0019353071795864769;

typedef struct vec3 {
    double x, y, z;
} vec3;

static vec3 turn_x(vec3 v, double s, double c)
{
    return (vec3){v.x, c * v.y - s * v.z, s * v.y + c * v.z};
}

static vec3 turn_y(vec3 v, double s, double c)
{
    return (vec3){c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}

static vec3 turn_z(vec3 v, double s, double c)
{
    return (vec3){c * v.x - s * v.y, s * v.x + c * v.y, v.z};
}

double stein__angle(double y, double x)
{
    double r = sqrt(x * x + y * y), s, c;
    if (!(r > 0.0)) {
        return 0.0;
    }
    // within 0.004 rad, then twice the sine of what is missing, each time to its third power
    double ax = fabs(x), ay = fabs(y);
    int steep = ay > ax;
    double t = steep ? ax / ay : ay / ax;
    double angle = t * (0.78539816 + 0.273 * (1.0 - t));
    angle = steep ? 1.57079633 - angle : angle;
    angle = x < 0.0 ? 3.14159265 - angle : angle;
    angle = y < 0.0 ? -angle : angle;
    for (int i = 0; i < 2; i++) {
        stein__sincos(angle, &s, &c);
        angle += (y * c - x * s) / r;
    }
    return angle;
}

/* sines and cosines of the four angles */
static void turn_four(const double q[4], double s[4], double c[4])
{
    for (int i = 0; i < 4; i++) {
        stein__sincos(q[i], &s[i], &c[i]);
    }
}

/* turning speed in the body's axes */
static vec3 spin_of(const double s[4], const double c[4], const double qd[4])
{
    vec3 w = turn_y((vec3){qd[1], 0.0, 0.0}, -s[2], c[2]);
    w.y += qd[2];
    w = turn_z(w, -s[3], c[3]);
    w.z += qd[3];
    return w;
}

/* speeds of the angles from it */
static void set_speeds(const double s[4], const double c[4], vec3 w, double qd[4])
{
    vec3 v = turn_z(w, s[3], c[3]);
    qd[0] = 0.0;
    qd[1] = v.x / c[2];
    qd[2] = v.y;
    qd[3] = w.z - qd[1] * s[2];
}

/* Another chart for the same attitude, with b = 0. s, c: of the angles before, then of those after
 */
static void change_chart(double q[4], double s[4], double c[4])
{
    vec3 z = turn_z(turn_x((vec3){s[2], 0.0, c[2]}, s[1], c[1]), s[0], c[0]);
    vec3 x = turn_y((vec3){c[3], s[3], 0.0}, s[2], c[2]);
    x = turn_z(turn_x(x, s[1], c[1]), s[0], c[0]);
    q[0] = stein__angle(z.x, -z.y);
    q[1] = stein__angle(sqrt(z.x * z.x + z.y * z.y), z.z);
    q[2] = 0.0;
    turn_four(q, s, c);
    x = turn_x(turn_z(x, -s[0], c[0]), -s[1], c[1]);
    q[3] = stein__angle(x.y, x.x);
    turn_four(q, s, c);
}

/* @return has it? */
static int takes_turns_off(double *angle)
{
    double n = fabs(*angle) > most_turned ? floor(*angle / (turn_whole + turn_rest) + 0.5) : 0.0;
    *angle = (*angle - n * turn_whole) - n * turn_rest;
    return n != 0.0;
}

int stein__rechart(stein_sim *sim)
{
    int changed = 0;
    for (int i = 0; i < sim->model->nball; i++) {
        int at = sim->model->balls[i].joint;
        double s[4], c[4], *q = sim->q + at, *qd = sim->qd + at;
        turn_four(q, s, c);
        if (fabs(s[2]) > most_tilt) {
            vec3 w = spin_of(s, c, qd);
            change_chart(q, s, c);
            set_speeds(s, c, w, qd);
            changed = 1;
        }
        changed |= takes_turns_off(&q[1]);
        changed |= takes_turns_off(&q[3]);
    }
    sim->fresh = changed ? STALE : sim->fresh;
    return changed;
}

void stein__spin_up(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nball; i++) {
        int at = sim->model->balls[i].joint;
        double s[4], c[4], *q = sim->q + at, *qd = sim->qd + at;
        vec3 w = {qd[1], qd[2], qd[3]};
        turn_four(q, s, c);
        if (fabs(s[2]) > most_tilt) {
            change_chart(q, s, c);
        }
        set_speeds(s, c, w, qd);
    }
}
