/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_window.c - value and slope of a channel at the start of its record.
 *
 * A polynomial of degree d through the first N samples has, at its end, the standard deviations
 *
 *      value  about (d + 1) sigma/sqrt(N),    slope  about d^2 (d + 2) sigma/(N^1.5 h),
 *
 * h being the sampling interval: long windows and low degrees have small variances, and a bias.
 * In the basis of Legendre polynomials, orthogonalised by the Cholesky factor L of the normal
 * equations, the terms k = 0 .. D of the fit are z = L^-1 P'y, and
 *
 *      residual sum of squares of degree d  =  y'y - z_0^2 - ... - z_d^2,
 *
 * so that one factorisation shows every degree. A window is unbiased in degree d when the terms
 * above d are noise, z_k^2 < 6 sigma^2, and the residual is no more than noise. Among the windows
 * that are unbiased, and would be if they were half as long again, the one with the smallest sd of
 * the slope is taken (after Lepski).
 *
 * Sigma is what the file states or the audit has estimated; within a window the residual of the
 * highest degree replaces it where it is clearly smaller. If no window passes, sigma is doubled: it
 * was stated too small. No noise is stated 16 times too small: then the motion has a kink within
 * the shortest window, as where a ball bounces, and the first two samples give the slope.
 */
#include <math.h>
#include <string.h>

#include "fitting.h"

enum {
    TERMS = 8,
    MOST_DEGREE = 5,
    FEWEST = 6,
    LONGEST = 5000,
    IN_A_ROW = 4,
    DOUBLINGS = 12,
    KINK = 4,
    AHEAD = 2
};
static const double significant = 6.0; /* z^2/sigma^2 of a term that is no noise: 2.45 sd */
static const double grow = 1.25;       /* from window to window */

/* Legendre polynomials at x and their derivatives */
static void legendre(double x, double p[TERMS], double dp[TERMS])
{
    p[0] = 1.0;
    p[1] = x;
    dp[0] = 0.0;
    dp[1] = 1.0;
    for (int k = 1; k + 1 < TERMS; k++) {
        p[k + 1] = ((2 * k + 1) * x * p[k] - k * p[k - 1]) / (k + 1);
        dp[k + 1] = dp[k - 1] + (2 * k + 1) * p[k];
    }
}

/* the fit of one window in all degrees up to D */
typedef struct window {
    int n, D;
    double middle, half;       /* of its time [s]; half < 0: samples backwards in time */
    double L[TERMS][TERMS];    /* factor of the normal equations */
    double z[TERMS], residual; /* terms; sum of squares of degree D */
} window;

static void forward(const window *w, const double *b, int m, double *z)
{
    for (int i = 0; i < m; i++) {
        z[i] = b[i];
        for (int j = 0; j < i; j++) {
            z[i] -= w->L[i][j] * z[j];
        }
        z[i] /= w->L[i][i];
    }
}

static void fit_window(window *w, const double *t, const double *y, int n)
{
    double b[TERMS] = {0.0}, p[TERMS], dp[TERMS], squares = 0.0;
    *w = (window){.n = n,
                  .D = n - 2 < TERMS - 1 ? n - 2 : TERMS - 1,
                  .middle = 0.5 * (t[0] + t[n - 1]),
                  .half = 0.5 * (t[n - 1] - t[0])};
    for (int i = 0; i < n; i++) {
        legendre((t[i] - w->middle) / w->half, p, dp);
        double v = y[i] - y[0];
        squares += v * v;
        for (int k = 0; k <= w->D; k++) {
            b[k] += p[k] * v;
            for (int j = 0; j <= k; j++) {
                w->L[k][j] += p[k] * p[j];
            }
        }
    }
    for (int k = 0; k <= w->D; k++) {
        double whole = w->L[k][k];
        for (int j = 0; j <= k; j++) {
            double sum = w->L[k][j];
            for (int i = 0; i < j; i++) {
                sum -= w->L[k][i] * w->L[j][i];
            }
            w->L[k][j] = j < k ? sum / w->L[j][j] : sqrt(fmax(sum, 1e-12 * whole));
        }
    }
    forward(w, b, w->D + 1, w->z);
    w->residual = squares;
    for (int k = 0; k <= w->D; k++) {
        w->residual -= w->z[k] * w->z[k];
    }
    w->residual = fmax(w->residual, 0.0);
}

/* sd of a sample within the window: the stated one, or less where the residual is clearly smaller
 */
static double sigma_of(const window *w, double noise)
{
    double dof = w->n - w->D - 1, slack = 1.0 - 1.6 * sqrt(2.0 / dof);
    double shown = dof >= 8.0 ? sqrt(w->residual / (dof * slack)) : (double)INFINITY;
    return fmax(fmin(noise, shown), 0.1 * noise);
}

/* lowest degree whose higher terms and residual are noise; -1: none */
static int degree_of(const window *w, double sigma)
{
    double s2 = sigma * sigma, dof = w->n - w->D - 1;
    int d = w->D;
    if (w->residual > s2 * (dof + 3.0 * sqrt(2.0 * dof))) {
        return -1;
    }
    while (d > 1 && w->z[d] * w->z[d] < significant * s2) {
        d--;
    }
    return d <= MOST_DEGREE && d < w->D ? d : -1;
}

static void evaluate(const window *w, int d, double sigma, double y0, double at, fit__start *out)
{
    double p[TERMS], dp[TERMS], v[TERMS] = {0}, s[TERMS] = {0};
    legendre((at - w->middle) / w->half, p, dp);
    forward(w, p, d + 1, v);
    forward(w, dp, d + 1, s);
    *out = (fit__start){.value = y0, .samples = w->n};
    for (int k = 0; k <= d; k++) {
        out->value += v[k] * w->z[k];
        out->slope += s[k] * w->z[k] / w->half;
        out->value_sd += v[k] * v[k];
        out->slope_sd += s[k] * s[k];
    }
    out->value_sd = sigma * sqrt(out->value_sd);
    out->slope_sd = sigma * sqrt(out->slope_sd) / fabs(w->half);
    out->length = 2.0 * fabs(w->half);
}

/* The best window at this sigma. A bias that its own samples do not show is of the size of their
 * noise, and up to 4 sd of the slope; it falls with N^(d + 3/2). So a window takes the degree that
 * windows up to AHEAD sizes longer need. @return 1 when there is one */
static int best_window(const double *t, const double *y, int n, double noise, double at,
                       fit__start *out)
{
    window w[AHEAD + 1];
    double sigma[AHEAD + 1];
    int degree[AHEAD + 1], found = 0, refused = 0, made = 0, m = n < FEWEST ? n : FEWEST;
    for (int first = 0; refused < IN_A_ROW; first++) {
        for (; made <= first + AHEAD && m > 0; made++) {
            window *next = &w[made % (AHEAD + 1)];
            fit_window(next, t, y, m);
            sigma[made % (AHEAD + 1)] = sigma_of(next, noise);
            degree[made % (AHEAD + 1)] = degree_of(next, sigma[made % (AHEAD + 1)]);
            int longer = (int)ceil(grow * m);
            m = m == n ? 0 : longer < n ? longer : n;
        }
        if (first >= made) {
            break;
        }
        int d = degree[first % (AHEAD + 1)];
        for (int k = first; k < made; k++) {
            int more = degree[k % (AHEAD + 1)];
            d = d < 0 || more < 0 ? -1 : more > d ? more : d;
        }
        const window *here = &w[first % (AHEAD + 1)];
        refused = d < 0 ? refused + 1 : 0;
        if (d >= 0 && d <= here->D) {
            fit__start to;
            evaluate(here, d, sigma[first % (AHEAD + 1)], y[0], at, &to);
            if (!found || to.slope_sd < out->slope_sd) {
                *out = to;
            }
            found = 1;
        }
    }
    return found;
}

static double slope_at(const double *t, const double *y, int i)
{
    return (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
}

/* Of the first two samples, or unknown where the kink is between these. */
static void before_kink(const double *t, const double *y, int n, double noise, double at,
                        fit__start *out)
{
    int last = n < FEWEST ? n - 1 : FEWEST - 1;
    double slope = slope_at(t, y, 0), next = slope_at(t, y, 1), change = fabs(next - slope);
    int here = n < 4 || fabs(slope_at(t, y, 2) - next) < 0.25 * change;
    double sd = fmax(0.1 * fabs(slope), 1.5 * noise / fabs(t[1] - t[0]));
    *out = (fit__start){.value = y[0] + slope * (at - t[0]),
                        .value_sd = noise,
                        .slope = slope,
                        .slope_sd = here ? fmax(sd, change) : sd,
                        .length = fabs(t[last] - t[0]),
                        .samples = last + 1};
}

int fit__start_of(const double *t, const double *y, int n, double noise, double at, fit__start *out)
{
    n = n < LONGEST ? n : LONGEST;
    if (n < 3) {
        return 0;
    }
    double more = noise;
    for (int k = 0; k < DOUBLINGS; k++, more *= 2.0) {
        if (best_window(t, y, n, more, at, out)) {
            if (k >= KINK) {
                before_kink(t, y, n, noise, at, out);
            }
            return 1;
        }
    }
    return 0;
}

void fit__unwrap(double *y, int n)
{
    static const double turn = 2.0 * 3.14159265358979323846;
    double last = NAN, lo = INFINITY, hi = -INFINITY;
    for (int i = 0; i < n; i++) {
        lo = isfinite(y[i]) ? fmin(lo, y[i]) : lo;
        hi = isfinite(y[i]) ? fmax(hi, y[i]) : hi;
    }
    for (int i = 0; i < n && hi - lo < 1.02 * turn; i++) {
        y[i] -= isfinite(last) && isfinite(y[i]) ? turn * round((y[i] - last) / turn) : 0.0;
        last = isfinite(y[i]) ? y[i] : last;
    }
}
