/* SPDX-License-Identifier: GPL-3.0-or-later
 * signal.c - measured inputs as signals with the derivatives a prescribed motion needs.
 *
 * A motion drives the mechanism through its second derivative, and differences of noise s at
 * intervals h have s sqrt(6)/h^2: 1 um at 1 kHz is 2.4 m/s^2. So a measured motion becomes the
 * natural cubic spline g that is as smooth as its noise allows (Reinsch 1967; Green & Silverman
 * 1994, 2.3):
 *
 *      minimise  sum (u_i - g(t_i))^2 + a int g''^2 dt     with a such that  sum (u_i - g_i)^2 = n
 * s^2
 *
 *      (R + a Q'Q) c = Q'u,    g = u - a Q c,    c = g'' at the inner knots
 *
 * five diagonals, solved in O(n) for each trial a. s is the noise the audit found; without noise
 * a = 0 is the interpolating spline. A low-pass filter would need a cut-off from the user and runs
 * into the ends. A force needs no derivatives and runs straight between its samples.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

/* the banded problem: row i belongs to knot i+1 */
typedef struct bands {
    int m;                    /* inner knots */
    double *h;                /* [n-1] intervals */
    double *q0, *q1, *q2, *z; /* diagonals of R + a Q'Q as L D L', right-hand side */
} bands;

/* L D L' of R + a Q'Q and the solution c [m]; Q has the rows 1/h_i, -1/h_i - 1/h_i+1, 1/h_i+1 */
static void solve(bands *b, double a, double *c)
{
    const double *h = b->h;
    for (int i = 0; i < b->m; i++) {
        double l = 1.0 / h[i], r = 1.0 / h[i + 1], mid = -l - r;
        b->q0[i] = (h[i] + h[i + 1]) / 3.0 + a * (l * l + mid * mid + r * r);
        b->q1[i] = b->q2[i] = 0.0;
        if (i + 1 < b->m) {
            double far = 1.0 / h[i + 2];
            b->q1[i] = h[i + 1] / 6.0 + a * (mid * r + r * (-r - far));
        }
        if (i + 2 < b->m) {
            b->q2[i] = a * r / h[i + 2];
        }
        c[i] = b->z[i];
    }
    for (int i = 0; i < b->m; i++) { // factor, and go forward
        double d = b->q0[i], e = b->q1[i], f = b->q2[i];
        if (i + 1 < b->m) {
            b->q0[i + 1] -= e * e / d;
            b->q1[i + 1] -= e * f / d;
            c[i + 1] -= e / d * c[i];
        }
        if (i + 2 < b->m) {
            b->q0[i + 2] -= f * f / d;
            c[i + 2] -= f / d * c[i];
        }
    }
    for (int i = b->m - 1; i >= 0; i--) {
        double s = c[i];
        s -= i + 1 < b->m ? b->q1[i] * c[i + 1] : 0.0;
        s -= i + 2 < b->m ? b->q2[i] * c[i + 2] : 0.0;
        c[i] = s / b->q0[i];
    }
}

/* (Q c)_i for knot i */
static double spread(const bands *b, const double *c, int i)
{
    double s = i < b->m ? c[i] / b->h[i] : 0.0;
    s -= i > 0 && i <= b->m ? c[i - 1] * (1.0 / b->h[i - 1] + 1.0 / b->h[i]) : 0.0;
    s += i > 1 ? c[i - 2] / b->h[i - 1] : 0.0;
    return s;
}

static double misfit(const bands *b, double a, const double *c)
{
    double sum = 0.0;
    for (int i = 0; i < b->m + 2; i++) {
        double d = a * spread(b, c, i);
        sum += d * d;
    }
    return sum;
}

/* the largest a that stays within the noise */
static double choose(bands *b, double *c, double noise)
{
    double wanted = noise * noise * (b->m + 2), scale = b->h[b->m / 2];
    double low = -14.0, high = 14.0; // decades of a in units of scale^3
    for (int i = 0; i < 60; i++) {
        double mid = 0.5 * (low + high), a = scale * scale * scale * pow(10.0, mid);
        solve(b, a, c);
        if (misfit(b, a, c) > wanted) {
            high = mid;
        } else {
            low = mid;
        }
    }
    return scale * scale * scale * pow(10.0, low);
}

static void smooth(fit__signal *s, bands *b, double noise)
{
    for (int i = 0; i + 1 < s->n; i++) {
        b->h[i] = s->t[i + 1] - s->t[i];
    }
    for (int i = 0; i < b->m; i++) {
        b->z[i] = (s->g[i + 2] - s->g[i + 1]) / b->h[i + 1] - (s->g[i + 1] - s->g[i]) / b->h[i];
    }
    double *c = s->c + 1; // the ends are natural: 0
    double a = noise > 0.0 ? choose(b, c, noise) : 0.0;
    solve(b, a, c);
    for (int i = 0; i < s->n; i++) {
        s->g[i] -= a * spread(b, c, i);
    }
}

stein_status fit__signal_make(fit__signal *s, int input, int motion, const lab_data *data,
                              const lab_column *column, double noise, stein_err *err)
{
    size_t n = (size_t)column->samples;
    *s = (fit__signal){.input = input, .motion = motion};
    s->t = calloc(n + 1, sizeof *s->t);
    s->g = calloc(n + 1, sizeof *s->g);
    s->c = calloc(n + 1, sizeof *s->c);
    bands b = {.m = (int)n - 2};
    double *room = calloc(5 * (n + 1), sizeof *room);
    if (s->t == NULL || s->g == NULL || s->c == NULL || room == NULL) {
        free(room);
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int i = 0; i < data->nrow; i++) {
        if (column->present[i]) {
            s->t[s->n] = data->time[i];
            s->g[s->n++] = column->value[i];
        }
    }
    b.h = room;
    b.q0 = room + n + 1;
    b.q1 = b.q0 + n + 1;
    b.q2 = b.q1 + n + 1;
    b.z = b.q2 + n + 1;
    if (motion && s->n > 2) {
        smooth(s, &b, noise);
    }
    free(room);
    return STEIN_OK;
}

void fit__signal_free(fit__signal *s)
{
    free(s->t);
    free(s->g);
    free(s->c);
}

void fit__signal_at(const fit__signal *s, double t, double u[3])
{
    int lo = 0, hi = s->n - 1;
    u[1] = u[2] = 0.0;
    if (t < s->t[0] || t > s->t[hi]) {
        u[0] = t < s->t[0] ? s->g[0] : s->g[hi];
        return;
    }
    // guess by proportion, which is right on a regular grid, then halve
    int guess = (int)((t - s->t[0]) / (s->t[hi] - s->t[0]) * hi);
    guess = guess > hi - 1 ? hi - 1 : guess;
    if (s->t[guess] <= t && t < s->t[guess + 1]) {
        lo = guess;
        hi = guess + 1;
    }
    while (hi - lo > 1) {
        int mid = lo + (hi - lo) / 2;
        if (s->t[mid] <= t) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double h = s->t[hi] - s->t[lo], a = (s->t[hi] - t) / h, b = 1.0 - a;
    u[0] = a * s->g[lo] + b * s->g[hi];
    if (s->motion) {
        double cl = s->c[lo], ch = s->c[hi];
        u[0] += ((a * a * a - a) * cl + (b * b * b - b) * ch) * h * h / 6.0;
        u[1] = (s->g[hi] - s->g[lo]) / h +
               ((1.0 - 3.0 * a * a) * cl + (3.0 * b * b - 1.0) * ch) * h / 6.0;
        u[2] = a * cl + b * ch;
    }
}
