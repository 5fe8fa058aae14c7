/* SPDX-License-Identifier: GPL-3.0-or-later
 * signal.c - measured inputs as signals with the derivatives a prescribed motion needs.
 *
 * A motion drives the mechanism through its second derivative, and differences of noise s at
 * intervals h have s sqrt(6)/h^2: 1 um at 1 kHz is 2.4 m/s^2. So a measured motion is smoothed as
 * far as its noise allows (Whittaker 1923; Reinsch 1967 for the choice of a):
 *
 *      minimise  sum (u_i - g_i)^2 + a |D g|^2     with a such that  sum (u_i - g_i)^2 = n s^2
 *
 *      (1 + a D D') y = D u,    g = u - a D' y
 *
 * with D the third derivative by divided differences, each times the root of its interval; seven
 * diagonals, solved in O(n) for each trial a. A cubic spline runs through g. The penalty is on the
 * third derivative. On the second one, as in the usual smoothing spline, it reduces accelerations,
 * and to 0 at both ends: a record that begins in motion lacked 70 N of a force of 90 N there. s is
 * the noise the audit found; without noise a = 0. A force needs no derivatives and runs straight
 * between its samples.
 *
 * An oscillation of frequency f keeps the share 1/(1 + a h (2 pi f)^6) of itself, h the interval of
 * the samples; the band of a signal is the f that keeps half. A caller that knows the band states
 * it instead (band.c finds it where forces were measured).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "fitting.h"

enum { WIDTH = 4 }; /* diagonals on and above the middle one; points of a third difference */

typedef double row[WIDTH];

/* the banded problem: row i is the third difference of knots i .. i+3 */
typedef struct bands {
    int m;
    const double *t;
    row *d;        /* [m] D */
    row *p;        /* [m] D D' from the diagonal on */
    row *q;        /* [m] the upper factor of 1 + a D D' */
    double *z, *y; /* [m] D u; solution */
} bands;

static void fill(bands *b, const double *u)
{
    for (int i = 0; i < b->m; i++) {
        const double *t = b->t + i;
        double root = sqrt((t[3] - t[0]) / 3.0);
        b->z[i] = 0.0;
        for (int j = 0; j < WIDTH; j++) {
            double product = 1.0;
            for (int k = 0; k < WIDTH; k++) {
                product *= k != j ? t[j] - t[k] : 1.0;
            }
            b->d[i][j] = 6.0 * root / product;
            b->z[i] += b->d[i][j] * u[i + j];
        }
    }
    for (int i = 0; i < b->m; i++) {
        for (int k = 0; k < WIDTH; k++) {
            double *to = &b->p[i][k];
            *to = 0.0;
            for (int j = k; j < WIDTH && i + k < b->m; j++) { // knot i+j is the (j-k)th of row i+k
                *to += b->d[i][j] * b->d[i + k][j - k];
            }
        }
    }
}

static void solve(bands *b, double a)
{
    row *q = b->q;
    double *y = b->y;
    for (int i = 0; i < b->m; i++) {
        for (int k = 0; k < WIDTH; k++) {
            q[i][k] = a * b->p[i][k] + (k == 0 ? 1.0 : 0.0);
        }
    }
    memcpy(y, b->z, sizeof *y * (size_t)b->m);
    for (int i = 0; i < b->m; i++) {
        for (int r = 1; r < WIDTH && i + r < b->m; r++) {
            double f = q[i][r] / q[i][0];
            y[i + r] -= f * y[i];
            for (int k = r; k < WIDTH; k++) {
                q[i + r][k - r] -= f * q[i][k];
            }
        }
    }
    for (int i = b->m - 1; i >= 0; i--) {
        for (int r = 1; r < WIDTH && i + r < b->m; r++) {
            y[i] -= q[i][r] * y[i + r];
        }
        y[i] /= q[i][0];
    }
}

/* what smoothing takes away from knot i */
static double taken(const bands *b, double a, int i)
{
    double sum = 0.0;
    for (int j = 0; j < WIDTH; j++) {
        sum += i - j >= 0 && i - j < b->m ? b->d[i - j][j] * b->y[i - j] : 0.0;
    }
    return a * sum;
}

static double misfit(const bands *b, double a)
{
    double sum = 0.0;
    for (int i = 0; i < b->m + 3; i++) {
        double d = taken(b, a, i);
        sum += d * d;
    }
    return sum;
}

/* a in intervals^5, the unit in which it means the same whatever the rate is */
static double unit_of(const bands *b)
{
    int n = b->m + 3;
    return stein__power((b->t[n - 1] - b->t[0]) / (n - 1), 5.0);
}

/* the largest a that stays within the noise, in decades of its unit */
static double choose(bands *b, double noise)
{
    int n = b->m + 3;
    double wanted = noise * noise * n, unit = unit_of(b);
    double low = -14.0, high = 14.0;
    for (int i = 0; i < 50; i++) {
        double mid = 0.5 * (low + high), a = unit * stein__power(10.0, mid);
        solve(b, a);
        if (misfit(b, a) > wanted) {
            high = mid;
        } else {
            low = mid;
        }
    }
    return low;
}

static const double ln10 = 2.302585092994046, turn = 6.283185307179586;

/* decades of a whose band is f */
static double decades_of(const fit__signal *s, double hz)
{
    double h = (s->t[s->n - 1] - s->t[0]) / (s->n - 1);
    return -6.0 * stein__log_of(turn * hz * h) / ln10;
}

double fit__signal_band(const fit__signal *s)
{
    double h = s->n > 1 ? (s->t[s->n - 1] - s->t[0]) / (s->n - 1) : 1.0;
    return stein__power(10.0, -s->decades / 6.0) / (turn * h);
}

/* @param decades  of a; NAN: as the noise allows */
static stein_status smooth(fit__signal *s, double noise, double decades, stein_err *err)
{
    size_t n = (size_t)s->n;
    row *rows = calloc(3 * n, sizeof *rows);
    double *room = calloc(2 * n, sizeof *room);
    if (rows == NULL || room == NULL) {
        free(rows);
        free(room);
        return lab__no_memory(err);
    }
    bands b = {.m = s->n - 3, .t = s->t, .d = rows, .p = rows + n, .q = rows + 2 * n};
    b.z = room;
    b.y = room + n;
    fill(&b, s->g);
    s->decades = isnan(decades) ? choose(&b, noise) : decades;
    double a = unit_of(&b) * stein__power(10.0, s->decades);
    solve(&b, a);
    s->taken = sqrt(misfit(&b, a) / (double)n);
    for (int i = 0; i < s->n; i++) {
        s->g[i] -= taken(&b, a, i);
    }
    free(rows);
    free(room);
    return STEIN_OK;
}

/* second derivatives of the cubic spline through the knots; its third derivative is the same on
 * both sides of the second and of the last knot but one */
static stein_status interpolate(const fit__signal *s, double *c, stein_err *err)
{
    int n = s->n;
    double *upper = calloc((size_t)n, sizeof *upper);
    if (upper == NULL) {
        return lab__no_memory(err);
    }
    double first = (s->t[1] - s->t[0]) / (s->t[2] - s->t[1]);
    double last = (s->t[n - 1] - s->t[n - 2]) / (s->t[n - 2] - s->t[n - 3]);
    for (int i = 1; i < n - 1; i++) {
        double h = s->t[i] - s->t[i - 1], k = s->t[i + 1] - s->t[i];
        double low = h / 6.0, mid = (h + k) / 3.0, high = k / 6.0;
        if (i == 1) { // c_0 = (1 + first) c_1 - first c_2
            mid += low * (1.0 + first);
            high -= low * first;
            low = 0.0;
        }
        if (i == n - 2) {
            mid += k / 6.0 * (1.0 + last);
            low -= k / 6.0 * last;
            high = 0.0;
        }
        double pivot = mid - low * upper[i - 1];
        double bend = (s->g[i + 1] - s->g[i]) / k - (s->g[i] - s->g[i - 1]) / h;
        upper[i] = high / pivot;
        c[i] = (bend - low * c[i - 1]) / pivot;
    }
    for (int i = n - 3; i > 0; i--) {
        c[i] -= upper[i] * c[i + 1];
    }
    c[0] = (1.0 + first) * c[1] - first * c[2];
    c[n - 1] = (1.0 + last) * c[n - 2] - last * c[n - 3];
    free(upper);
    return STEIN_OK;
}

static stein_status make_room(fit__signal *s, size_t n, stein_err *err)
{
    s->t = calloc(n + 1, sizeof *s->t);
    s->g = calloc(n + 1, sizeof *s->g);
    s->piece = calloc(n + 1, sizeof *s->piece);
    return s->t != NULL && s->g != NULL && s->piece != NULL ? STEIN_OK : lab__no_memory(err);
}

void fit__signal_pieces(const fit__signal *s, const double *c)
{
    for (int i = 0; i < s->n; i++) {
        int last = i + 1 == s->n; // nothing begins there; it bends as before
        double h = last ? 1.0 : s->t[i + 1] - s->t[i], rise = last ? 0.0 : s->g[i + 1] - s->g[i];
        double bend = c != NULL ? c[i] : 0.0, next = c != NULL && !last ? c[i + 1] : bend;
        s->piece[i] = (fit__cubic){s->t[i],
                                   {s->g[i], rise / h - (2.0 * bend + next) * h / 6.0, 0.5 * bend,
                                    (next - bend) / (6.0 * h)}};
    }
}

/* what runs through the knots */
static stein_status run_through(fit__signal *s, double noise, double decades, stein_err *err)
{
    if (!s->motion || s->n <= 4) { // fewer show no derivatives
        fit__signal_pieces(s, NULL);
        return STEIN_OK;
    }
    double *c = calloc((size_t)s->n, sizeof *c);
    stein_status status = c != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK && (noise > 0.0 || isfinite(decades))) {
        status = smooth(s, noise, decades, err);
    }
    status = status == STEIN_OK ? interpolate(s, c, err) : status;
    if (status == STEIN_OK) {
        fit__signal_pieces(s, c);
    }
    free(c);
    return status;
}

stein_status fit__signal_make(fit__signal *s, int input, int motion, const lab_data *data,
                              const lab_column *column, double noise, double hz, stein_err *err)
{
    *s = (fit__signal){.input = input, .motion = motion, .noise = noise};
    stein_status status = make_room(s, (size_t)column->samples, err);
    for (int i = 0; status == STEIN_OK && i < data->nrow; i++) {
        if (column->present[i]) {
            s->t[s->n] = data->time[i];
            s->g[s->n++] = column->value[i];
        }
    }
    double decades = hz > 0.0 && s->n > 1 ? decades_of(s, hz) : (double)NAN;
    return status == STEIN_OK ? run_through(s, noise, decades, err) : status;
}

stein_status fit__signal_through(fit__signal *s, int input, const double *t, const double *u, int n,
                                 double noise, double decades, stein_err *err)
{
    *s = (fit__signal){.input = input, .motion = 1, .noise = noise};
    stein_status status = make_room(s, (size_t)n, err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        if (isfinite(u[i])) {
            s->t[s->n] = t[i];
            s->g[s->n++] = u[i];
        }
    }
    return status == STEIN_OK ? run_through(s, noise, decades, err) : status;
}

void fit__signal_free(fit__signal *s)
{
    free(s->t);
    free(s->g);
    free(s->piece);
}

/* the interval of t, t[i] <= t < t[i+1]; mostly the one before or the next */
static int interval(const fit__signal *s, double t, int before)
{
    const fit__cubic *piece = s->piece;
    int lo = 0, hi = s->n - 1;
    for (int i = before; i < before + 2 && i >= 0 && i < hi; i++) {
        if (piece[i].t <= t && t < piece[i + 1].t) {
            return i;
        }
    }
    while (hi - lo > 1) {
        int mid = lo + (hi - lo) / 2;
        if (piece[mid].t <= t) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    return lo;
}

void fit__signal_at(const fit__signal *s, double t, int *at, double u[3])
{
    const fit__cubic *piece = s->piece, *end = piece + s->n - 1;
    u[1] = u[2] = 0.0;
    if (t < piece->t || t > end->t) {
        u[0] = t < piece->t ? piece->a[0] : end->a[0];
        return;
    }
    piece += *at = interval(s, t, *at);
    const double *a = piece->a, x = t - piece->t;
    u[0] = a[0] + x * (a[1] + x * (a[2] + x * a[3]));
    if (s->motion) {
        u[1] = a[1] + x * (2.0 * a[2] + x * 3.0 * a[3]);
        u[2] = 2.0 * a[2] + x * 6.0 * a[3];
    }
}
