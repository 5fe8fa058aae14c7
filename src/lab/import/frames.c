/* SPDX-License-Identifier: GPL-3.0-or-later
 * frames.c - rotated frames, for a mechanism file, which has none.
 *
 * All bodies of a mechanism file have parallel axes while all joints are at 0. So a body of a draft
 * has the axes of the root at 0. A rotation C from its frame in the other program is applied once,
 * here, to its centre, inertia and joints. That serves while the axis of a joint is parallel to x,
 * y or z of the root. An oblique axis is carried by hinges about z, y, x that are held at the
 * angles of its frame; after them C is the frame's rotation.
 */
#include <math.h>
#include <string.h>

#include "draft.h"

static const double pi = 3.141592653589793;
static const double parallel = 1e-9; /* components of an axis along the two others */

void frame_multiply(const double A[9], const double B[9], double C[9])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
        }
    }
}

void frame_turn(const double A[9], const double x[3], double y[3])
{
    for (int i = 0; i < 3; i++) {
        y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
    }
}

/* sine and cosine of a multiple of 90 deg are exact */
static void sine(double angle, double *s, double *c)
{
    static const double of[4] = {0.0, 1.0, 0.0, -1.0};
    double quarters = angle / (0.5 * pi), whole = round(quarters);
    *s = sin(angle);
    *c = cos(angle);
    if (fabs(angle - whole * 0.5 * pi) < 1e-12) {
        int k = (int)fmod(fmod(whole, 4.0) + 4.0, 4.0);
        *s = of[k];
        *c = of[(k + 1) % 4];
    }
}

void frame_rotation(const double rpy[3], double R[9])
{
    double s[3], c[3];
    for (int i = 0; i < 3; i++) {
        sine(rpy[i], &s[i], &c[i]);
    }
    R[0] = c[2] * c[1];
    R[1] = c[2] * s[1] * s[0] - s[2] * c[0];
    R[2] = c[2] * s[1] * c[0] + s[2] * s[0];
    R[3] = s[2] * c[1];
    R[4] = s[2] * s[1] * s[0] + c[2] * c[0];
    R[5] = s[2] * s[1] * c[0] - c[2] * s[0];
    R[6] = -s[1];
    R[7] = c[1] * s[0];
    R[8] = c[1] * c[0];
}

/* roll, pitch, yaw of a rotation */
static void angles(const double R[9], double rpy[3])
{
    double level = sqrt(R[0] * R[0] + R[3] * R[3]);
    rpy[1] = atan2(-R[6], level);
    rpy[0] = level > parallel ? atan2(R[7], R[8]) : atan2(-R[5], R[4]);
    rpy[2] = level > parallel ? atan2(R[3], R[0]) : 0.0;
}

void frame_transpose(const double A[9], double B[9])
{
    for (int i = 0; i < 9; i++) {
        B[i] = A[3 * (i % 3) + i / 3];
    }
}

void frame_mass(draft_body *b, const double T[9], const double inertia[6])
{
    static const int place[] = {0, 4, 8, 1, 2, 5};
    double I[9], J[9], R[9];
    for (int e = 0; e < 6; e++) {
        I[place[e]] = I[3 * (place[e] % 3) + place[e] / 3] = inertia[e];
    }
    frame_multiply(T, I, J);
    frame_transpose(T, R);
    frame_multiply(J, R, I);
    for (int e = 0; e < 6; e++) {
        b->inertia[e] = I[place[e]];
    }
}

void frame_point(double inertia[6], double mass, const double x[3])
{
    double square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    for (int i = 0; i < 3; i++) {
        inertia[i] += mass * (square - x[i] * x[i]);
    }
    inertia[3] -= mass * x[0] * x[1];
    inertia[4] -= mass * x[0] * x[2];
    inertia[5] -= mass * x[1] * x[2];
}

void frame_join(draft_body *to, const draft_body *part)
{
    double mass = to->mass + part->mass, a[3], b[3];
    for (int i = 0; i < 3; i++) {
        double centre =
            mass > 0.0 ? (to->mass * to->centre[i] + part->mass * part->centre[i]) / mass : 0.0;
        a[i] = to->centre[i] - centre;
        b[i] = part->centre[i] - centre;
        to->centre[i] = centre;
    }
    for (int e = 0; e < 6; e++) {
        to->inertia[e] += part->inertia[e];
    }
    frame_point(to->inertia, to->mass, a);
    frame_point(to->inertia, part->mass, b);
    to->mass = mass;
}

static void hold(draft *d, const xml_node *node, const char *label, int *parent, double at[3],
                 const double C[9])
{
    double rpy[3];
    angles(C, rpy);
    for (int i = 2; i >= 0; i--) {
        char name[80];
        draft_body *b = rpy[i] != 0.0 ? draft_add_body(d, node) : NULL;
        if (b == NULL) {
            continue;
        }
        snprintf(name, sizeof name, "%.20s_held_%c", label, "xyz"[i]);
        draft_name(d, b->name, name, NULL, DRAFT_PART, 0);
        b->joint = 'R';
        b->axis = "xyz"[i];
        b->parent = *parent;
        memcpy(b->at, at, sizeof b->at);
        b->start = DRAFT_STATED;
        b->q = rpy[i];
        snprintf(name, sizeof name, "%.24s_at", b->name);
        draft_add_input(d, name, DRAFT_MOTION, d->nbody - 1, 0);
        *parent = d->nbody - 1;
        at[0] = at[1] = at[2] = 0.0;
    }
    draft_note(d, "joint %.60s is askew to x, y and z: hinges before it are held at its angles",
               label);
}

/* @return which of x, y, z a direction is parallel to, -1: none; its sign */
static int along(const double a[3], int *sign)
{
    for (int i = 0; i < 3; i++) {
        if (fabs(a[(i + 1) % 3]) < parallel && fabs(a[(i + 2) % 3]) < parallel) {
            *sign = a[i] < 0.0 ? -1 : 1;
            return i;
        }
    }
    return -1;
}

/* a frame with x along a: the columns of B */
static void frame_along(const double a[3], double B[9])
{
    int least = fabs(a[0]) <= fabs(a[1]) && fabs(a[0]) <= fabs(a[2]) ? 0
                : fabs(a[1]) <= fabs(a[2])                           ? 1
                                                                     : 2;
    double y[3], z[3], size = sqrt(1.0 - a[least] * a[least]);
    for (int i = 0; i < 3; i++) {
        y[i] = ((i == least) - a[least] * a[i]) / size;
    }
    for (int i = 0; i < 3; i++) {
        z[i] = a[(i + 1) % 3] * y[(i + 2) % 3] - a[(i + 2) % 3] * y[(i + 1) % 3];
        B[3 * i] = a[i];
        B[3 * i + 1] = y[i];
        B[3 * i + 2] = z[i];
    }
}

void frame_axis(draft *d, const xml_node *at, const char *label, const double direction[3],
                double C[9], draft_body *joint, int *parent)
{
    double a[3], in_body[3], size = 0.0;
    for (int i = 0; i < 3; i++) {
        size += direction[i] * direction[i];
    }
    if (!(size > 0.0)) {
        draft_wrong(d, at, "the axis of joint \"%.60s\" has no direction", label);
        return;
    }
    for (int i = 0; i < 3; i++) {
        a[i] = direction[i] / sqrt(size);
    }
    frame_turn(C, a, in_body);
    int axis = along(in_body, &joint->sign);
    if (axis < 0) {
        double B[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}, held[9];
        if ((axis = along(a, &joint->sign)) < 0) {
            frame_along(a, B);
            axis = 0;
            joint->sign = 1;
        }
        frame_multiply(C, B, held);
        hold(d, at, label, parent, joint->at, held);
        frame_transpose(B, C);
    }
    joint->axis = (char)('x' + axis);
}
