/* SPDX-License-Identifier: MIT
 * wrench.h - forces with their moments in space, and the vector operations that they need.
 * Included by: this folder.
 */
#ifndef STEIN_WRENCH_H
#define STEIN_WRENCH_H

typedef struct wrench6 {
    double f[3], n[3]; /* n about the origin of the fixed frame */
} wrench6;

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void add(double to[3], double k, const double a[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] += k * a[i];
    }
}

static inline void add_cross(double to[3], const double a[3], const double b[3])
{
    to[0] += a[1] * b[2] - a[2] * b[1];
    to[1] += a[2] * b[0] - a[0] * b[2];
    to[2] += a[0] * b[1] - a[1] * b[0];
}

/* R u, or R^T u */
static inline void turned(const double R[9], const double u[3], int back, double to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] = 0.0;
        for (int k = 0; k < 3; k++) {
            to[i] += R[back ? 3 * k + i : 3 * i + k] * u[k];
        }
    }
}

static inline void column_of(const double R[9], int k, double to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] = R[3 * i + k];
    }
}

/* a force at a place, and a moment */
static inline void push(wrench6 *to, double k, const double f[3], const double at[3])
{
    double arm[3] = {k * at[0], k * at[1], k * at[2]};
    add(to->f, k, f);
    add_cross(to->n, arm, f);
}

static inline void join(wrench6 *to, double k, const wrench6 *w)
{
    add(to->f, k, w->f);
    add(to->n, k, w->n);
}

/* units along the axes of a frame, all or all but one: forces at a place, moments without one */
static inline int put_axes(wrench6 *unit, const double R[9], int but, const double *at)
{
    int n = 0;
    for (int i = 0; i < 3; i++) {
        double e[3];
        column_of(R, i, e);
        if (i == but) {
            continue;
        }
        unit[n] = (wrench6){.f = {0.0}};
        if (at != NULL) {
            push(&unit[n], 1.0, e, at);
        } else {
            add(unit[n].n, 1.0, e);
        }
        n++;
    }
    return n;
}

static inline double product(const double *a, const double *b, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* x less its part along a unit vector. @return that part */
static inline double take_part(double *x, const double *unit, int n)
{
    double part = product(x, unit, n);
    for (int i = 0; i < n; i++) {
        x[i] -= part * unit[i];
    }
    return part;
}

/* R of the parent times a turn about the joint's axis */
static inline void turn_axes(const double up[9], int axis, double s, double c, double R[9])
{
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    for (int k = 0; k < 3; k++) {
        double a = up[3 * k + i], b = up[3 * k + j];
        R[3 * k + axis] = up[3 * k + axis];
        R[3 * k + i] = c * a + s * b;
        R[3 * k + j] = c * b - s * a;
    }
}

#endif
