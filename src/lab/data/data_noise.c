/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_noise.c - noise, quantisation step, spikes, cut-off values of one channel.
 *
 * Noise. While nothing moves, it is the scatter about a slow cubic drift. In motion, polynomials
 * are fitted to windows; impacts and let-off leave large residuals in some windows. So the estimate
 * is the lower quartile of the windows' variances, divided by the same quartile of the chi-squared
 * distribution with its degrees of freedom. Second differences, the usual way, would halve a noise
 * that is correlated from sample to sample.
 *
 * Windows have 25 samples and cubics where that is many samples to an oscillation. Where it is not,
 * the cubic leaves some of the motion over. Its variance then falls steeply with a higher degree or
 * a shorter window, with the power 2 (degree + 1) of the window. The variance of white noise stays;
 * that of noise correlated from sample to sample falls slowly. So windows of 25, 18, 13, 9 and 7
 * samples and degrees 3, 5 .. 11 are tried in the order of their degrees of freedom. The first one
 * counts where neither the next degree nor the next window lowers the variance by more than a
 * factor of 1.2.
 *
 * Step. Values of a camera or converter lie on a lattice. The difference of two neighbours is a
 * whole number of steps; a candidate is refined from small to ever larger multiples, from an
 * accuracy of 5 % to 1e-4. It is accepted when 93 % of all differences lie within an eighth of a
 * step of the lattice, by chance 25 % would, and when values 32 samples apart are on it, too. The
 * largest believed step counts: a finer lattice of
 * written digits is inside of it.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"

enum {
    WINDOW = 25,
    SHORTEST = 7,
    WINDOWS = 5, /* lengths */
    DEGREES = 5, /* 3, 5 .. 11 */
    TERMS = 12,
    LEAST_DOF = 2,
    PASSES = 4,
    MOST_WINDOWS = 4000,
    FEWEST_DIFFERENCES = 20,
    LATTICE_LAG = 32
};
static const double tolerated = 1.2; /* ratio of variances of two windows: 10 % of the noise */

double data__median(double *v, int n)
{
    if (n == 0) {
        return NAN;
    }
    gsl_sort(v, 1, (size_t)n);
    return 0.5 * (v[n / 2] + v[(n - 1) / 2]);
}

/* ---- polynomials ---- */

static void legendre(double x, double *p, int m)
{
    const double first[4] = {1.0, x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x};
    for (int k = 0; k < m; k++) {
        p[k] = k < 4 ? first[k] : ((2 * k - 1) * x * p[k - 1] - (k - 1) * p[k - 2]) / k;
    }
}

/* Cholesky, in place, of the normal equations; a direction that the samples do not have gets 0 */
static void solve(double A[TERMS][TERMS], double b[TERMS], int m)
{
    double floor_of[TERMS];
    for (int i = 0; i < m; i++) {
        floor_of[i] = 1e-12 * A[i][i];
    }
    for (int i = 0; i < m; i++) {
        for (int k = 0; k <= i; k++) {
            double sum = A[i][k];
            for (int j = 0; j < k; j++) {
                sum -= A[i][j] * A[k][j];
            }
            if (k < i) {
                A[i][k] = sum / A[k][k];
            } else {
                A[i][i] = sum > floor_of[i] ? sqrt(sum) : INFINITY;
            }
        }
    }
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < i; j++) {
            b[i] -= A[i][j] * b[j];
        }
        b[i] /= A[i][i];
    }
    for (int i = m - 1; i >= 0; i--) {
        for (int j = i + 1; j < m; j++) {
            b[i] -= A[j][i] * b[j];
        }
        b[i] /= A[i][i];
    }
}

double data__residual(const double *t, const double *v, int n, int degree, double *r)
{
    double A[TERMS][TERMS], b[TERMS] = {0.0}, p[TERMS], sum = 0.0;
    double middle = 0.5 * (t[0] + t[n - 1]), half = n > 1 ? 0.5 * (t[n - 1] - t[0]) : 1.0;
    int m = degree + 1;
    for (int k = 0; k < m; k++) {
        memset(A[k], 0, sizeof *A[k] * (size_t)m);
    }
    for (int i = 0; i < n; i++) {
        legendre((t[i] - middle) / half, p, m);
        for (int k = 0; k < m; k++) {
            b[k] += p[k] * (v[i] - v[0]);
            for (int j = 0; j <= k; j++) {
                A[k][j] += p[k] * p[j];
            }
        }
    }
    solve(A, b, m);
    for (int i = 0; i < n; i++) {
        legendre((t[i] - middle) / half, p, m);
        r[i] = v[i] - v[0];
        for (int k = 0; k < m; k++) {
            r[i] -= b[k] * p[k];
        }
        sum += r[i] * r[i];
    }
    return sum;
}

/* ---- noise ---- */

/* quantile of chi-squared by Wilson and Hilferty; z: of the normal distribution */
static double chi_squared(double dof, double z)
{
    double a = 2.0 / (9.0 * dof), root = 1.0 - a + z * sqrt(a);
    return dof * root * root * root;
}

/* longest window of a record of n samples */
static int window_of(int n)
{
    int w = n / 4;
    return w > WINDOW ? WINDOW : w < 9 ? 9 : w;
}

/* variance from windows of w samples and polynomials of one degree */
typedef struct guess {
    int window, degree;
    double variance, error; /* error: relative sd of the variance */
    double clean;           /* share of the windows without impacts */
} guess;

static guess look_through(const data__series *s, int w, int degree)
{
    guess g = {w, degree, NAN, NAN, 0.0};
    int hop = w / 2, count = s->n < w ? 0 : (s->n - w) / hop + 1;
    double variance[MOST_WINDOWS], r[WINDOW], dof = w - degree - 1;
    if (count < 3) {
        return g;
    }
    int used = count < MOST_WINDOWS ? count : MOST_WINDOWS;
    for (int i = 0; i < used; i++) {
        int first = (int)((long long)i * count / used) * hop;
        variance[i] = data__residual(s->t + first, s->v + first, w, degree, r);
    }
    gsl_sort(variance, 1, (size_t)used);
    int clean = used;
    for (int pass = 0; pass < PASSES; pass++) { // the quartile of the windows without impacts
        g.variance = variance[clean / 4] / chi_squared(dof, -0.6745);
        double most = g.variance * chi_squared(dof, 2.326);
        for (clean = used; clean > used / 4 + 1 && variance[clean - 1] > most; clean--) {
        }
    }
    // efficiency of a quartile against the mean; half of the windows overlap
    g.error = 1.36 * sqrt(2.0 / dof / (0.75 * clean));
    g.clean = (double)clean / used;
    return g;
}

/* all that have been asked for; row: window, column: degree */
typedef struct guesses {
    const data__series *s;
    int window[WINDOWS], n;
    guess made[WINDOWS][DEGREES];
} guesses;

static int dof_of(const guesses *g, int k, int j)
{
    return k < g->n && j < DEGREES ? g->window[k] - (3 + 2 * j) - 1 : 0;
}

static const guess *guess_at(guesses *g, int k, int j)
{
    guess *to = &g->made[k][j];
    if (to->window == 0) {
        *to = look_through(g->s, g->window[k], 3 + 2 * j);
    }
    return to;
}

/* Does another degree or window, which leaves less of the motion over, have a smaller variance
 * by more than the uncertainty of both? */
static int is_biased(guesses *g, int k, int j)
{
    const guess *a = guess_at(g, k, j);
    for (int way = 0; way < 2; way++) {
        int k2 = k + way, j2 = j + !way;
        if (dof_of(g, k2, j2) >= LEAST_DOF) {
            const guess *b = guess_at(g, k2, j2);
            if (isnan(b->variance) ||
                a->variance > (tolerated + 1.5 * hypot(a->error, b->error)) * b->variance) {
                return 1;
            }
        }
    }
    return !(a->clean >= 0.5);
}

/* The guess with the most degrees of freedom that is unbiased; if none is, the smallest. */
static guess best_guess(guesses *g)
{
    guess least = {0, 3, NAN, NAN, 0.0};
    for (int dof = g->window[0] - 4; dof >= LEAST_DOF; dof--) {
        for (int k = 0; k < g->n; k++) {
            for (int j = 0; j < DEGREES; j++) {
                if (dof_of(g, k, j) != dof) {
                    continue;
                }
                const guess *here = guess_at(g, k, j);
                int last = dof_of(g, k + 1, j) < LEAST_DOF && dof_of(g, k, j + 1) < LEAST_DOF;
                if (!last && !is_biased(g, k, j)) {
                    return *here;
                }
                if (!(here->variance > least.variance)) {
                    least = isnan(here->variance) ? least : *here;
                }
            }
        }
    }
    return least;
}

double data__noise_in_windows(data__series *s, int *samples, double *error)
{
    guesses g = {.s = s};
    for (int w = window_of(s->n); w >= SHORTEST && g.n < WINDOWS; w = 18 * w / 25) {
        g.window[g.n++] = w;
    }
    guess best = best_guess(&g);
    s->window = best.window;
    s->degree = best.degree;
    *samples = best.window > 0 ? s->n : 0;
    *error = 0.5 * best.error;
    return sqrt(best.variance);
}

/* correlation of the rows of residuals at each lag, sums kept by the caller */
typedef struct lags {
    double sum[LAB_LAGS + 1];
    double count[LAB_LAGS + 1];
} lags;

static void add_lags(lags *l, const double *r, int n)
{
    for (int k = 0; k <= LAB_LAGS; k++) {
        for (int i = 0; i + k < n; i++) {
            l->sum[k] += r[i] * r[i + k];
        }
        l->count[k] += n > k ? n - k : 0;
    }
}

static void finish_lags(const lags *l, double correlation[LAB_LAGS])
{
    double c0 = l->count[0] > 0.0 ? l->sum[0] / l->count[0] : 0.0;
    for (int k = 1; k <= LAB_LAGS; k++) {
        correlation[k - 1] = c0 > 0.0 && l->count[k] > 0.0 ? l->sum[k] / l->count[k] / c0 : NAN;
    }
}

/* spikes would rule a sum of squares: values beyond five robust deviations become 0.
 * @return samples left */
static int clip(double *r, int n, double *scratch)
{
    for (int i = 0; i < n; i++) {
        scratch[i] = fabs(r[i]);
    }
    double limit = 5.0 * 1.4826 * data__median(scratch, n);
    int left = n;
    for (int i = 0; i < n && limit > 0.0; i++) {
        if (fabs(r[i]) > limit) {
            r[i] = 0.0;
            left--;
        }
    }
    return left;
}

int data__noise_at_rest(const data__series *s, int (*rest)[2], int n, double *noise, double *error,
                        double correlation[LAB_LAGS])
{
    lags l = {{0.0}, {0.0}};
    double dof = 0.0, sum = 0.0;
    int used = 0;
    double *r = s->residual;
    for (int i = 0; i < n; i++) {
        int margin = (rest[i][1] - rest[i][0] + 1) / 10; // where motion begins and ends
        int first = rest[i][0] + margin, m = rest[i][1] - margin - first + 1;
        if (m < 20) {
            continue;
        }
        data__residual(s->t + first, s->v + first, m, 3, r);
        int left = clip(r, m, s->scratch);
        for (int k = 0; k < m; k++) {
            sum += r[k] * r[k];
        }
        add_lags(&l, r, m);
        dof += left - 4;
        used += left;
    }
    if (used < 50) {
        return 0;
    }
    *noise = sqrt(sum / dof);
    *error = sqrt(0.5 / dof);
    finish_lags(&l, correlation);
    return used;
}

void data__correlation_in_windows(const data__series *s, double correlation[LAB_LAGS])
{
    for (int i = 0; i < LAB_LAGS; i++) {
        correlation[i] = NAN;
    }
    if (s->window == 0) {
        return;
    }
    int w = s->window, count = s->n / w, lag = w - 2 < LAB_LAGS ? w - 2 : LAB_LAGS;
    int hop = count > MOST_WINDOWS ? count / MOST_WINDOWS : 1;
    lags l = {{0.0}, {0.0}}, white = {{0.0}, {0.0}};
    double r[WINDOW], unit[WINDOW], t[WINDOW], dof = w - s->degree - 1;
    for (int i = 0; i < count; i += hop) {
        size_t first = (size_t)i * (size_t)w;
        double sum = data__residual(s->t + first, s->v + first, w, s->degree, r);
        if (sum <= 2.0 * s->sigma * s->sigma * dof) {
            add_lags(&l, r, w);
        }
    }
    if (!(l.sum[0] > 0.0)) {
        return;
    }
    // the fit takes the slow part of the noise away: rows of 1 - H give the amount at each lag
    for (int i = 0; i < w; i++) {
        t[i] = i;
    }
    for (int i = 0; i < w; i++) {
        memset(unit, 0, sizeof unit);
        unit[i] = 1.0;
        data__residual(t, unit, w, s->degree, r);
        for (int k = 0; k <= lag && i + k < w; k++) {
            white.sum[k] += r[i + k];
        }
    }
    for (int k = 1; k <= lag; k++) {
        double expected = white.sum[k] / white.sum[0], found = l.sum[k] / l.sum[0];
        correlation[k - 1] = (found - expected) * white.sum[0] / (w - k);
    }
}

/* ---- quantisation ---- */

/* absolute differences of neighbours that are not zero, in increasing order; @return their number
 */
static int differences(const data__series *s, double *d)
{
    double largest = 0.0;
    int n = 0, all = s->n - 1, block = 500, blocks = DATA_DIFFERENCES / block;
    for (int i = 0; i < s->n; i++) {
        largest = fmax(largest, fabs(s->v[i]));
    }
    int whole = all <= DATA_DIFFERENCES;
    for (int b = 0; b < (whole ? 1 : blocks); b++) {
        int first = whole ? 0 : (int)((long long)b * (all - block) / (blocks - 1));
        int last = whole ? all : first + block;
        for (int i = first; i < last; i++) {
            double x = fabs(s->v[i + 1] - s->v[i]);
            if (x > 8.0 * 2.2e-16 * largest) { // errors of conversion and text count as zero
                d[n++] = x;
            }
        }
    }
    gsl_sort(d, 1, (size_t)n);
    return n;
}

/* refine q from multiples up to 3, 6, 12, ...; @return share of all differences on the lattice */
static double refine(const double *d, int n, double *q)
{
    double reach = 3.0;
    for (int pass = 0; pass < 19; pass++, reach *= 2.0) {
        double above = 0.0, below = 0.0;
        for (int i = 0; i < n && d[i] <= (reach + 0.5) * *q; i++) {
            double m = round(d[i] / *q);
            if (fabs(d[i] / *q - m) < 0.25) {
                above += d[i] * m;
                below += m * m;
            }
        }
        *q = below > 0.0 ? above / below : *q;
        if (d[n - 1] <= reach * *q) {
            break;
        }
    }
    int on = 0;
    for (int i = 0; i < n; i++) {
        double m = round(d[i] / *q);
        on += m >= 1.0 && fabs(d[i] / *q - m) < 0.125;
    }
    return (double)on / n;
}

/* Steady motion has neighbours that are equally far apart, too. Values on a lattice are whole steps
 * apart whatever lies between them; of others, half are nearer than a quarter step to one. */
static int on_lattice(const data__series *s, double q)
{
    int near = 0, n = s->n - LATTICE_LAG;
    for (int i = 0; i < n; i++) {
        double apart = (s->v[i + LATTICE_LAG] - s->v[i]) / q;
        near += fabs(apart - round(apart)) < 0.25;
    }
    return n <= 0 || near >= 0.8 * n;
}

double data__step(const data__series *s)
{
    static const double quantile[] = {0.0, 0.001, 0.005, 0.02, 0.1, 0.3};
    double *d = s->difference, best = 0.0;
    int n = s->n > FEWEST_DIFFERENCES ? differences(s, d) : 0;
    for (size_t i = 0; n >= FEWEST_DIFFERENCES && i < sizeof quantile / sizeof *quantile; i++) {
        for (int k = 1; k <= 6; k++) {
            double q = d[(int)(quantile[i] * n)] / k;
            if (q * 1.2 > best && refine(d, n, &q) >= 0.93 && q > best && on_lattice(s, q)) {
                best = q;
            }
        }
    }
    return best;
}

/* ---- single samples ---- */

/* distance of sample i from the straight line between its neighbours */
static double off_line(const data__series *s, int i)
{
    double u = (s->t[i] - s->t[i - 1]) / (s->t[i + 1] - s->t[i - 1]);
    return s->v[i] - (s->v[i - 1] + u * (s->v[i + 1] - s->v[i - 1]));
}

void data__spikes(const data__series *s, lab_channel_audit *a)
{
    for (int i = 2; i + 2 < s->n; i++) {
        double here = off_line(s, i);
        if (fabs(here) < fmax(10.0 * s->sigma, 5e-3 * s->range)) { // less does no harm
            continue;
        }
        // a spike bends its neighbours the other way by half of itself; a kink of the motion does
        // not
        double slack = 0.3 * fabs(here) + 2.0 * s->sigma;
        if (fabs(off_line(s, i - 1) + 0.5 * here) < slack &&
            fabs(off_line(s, i + 1) + 0.5 * here) < slack) {
            if (a->spikes < LAB_SPANS) {
                a->spike[a->spikes] = s->t[i];
            }
            a->spikes++;
        }
    }
}

/* A run at an extreme value is clipped if noise would have moved it, or if the motion enters or
 * leaves it at a speed that cannot have stopped there. */
static int cut_off(const data__series *s, double extreme, int scatters, double fast)
{
    int count = 0;
    for (int i = 0; i < s->n; i++) {
        int last = i;
        if (s->v[i] != extreme) {
            continue;
        }
        while (last + 1 < s->n && s->v[last + 1] == extreme) {
            last++;
        }
        int into = i > 0 && fabs(s->v[i - 1] - extreme) > fast;
        int out = last + 1 < s->n && fabs(s->v[last + 1] - extreme) > fast;
        if (last - i + 1 >= (scatters ? 5 : 4) && (scatters || into || out)) {
            count += last - i + 1;
        }
        i = last;
    }
    return count;
}

void data__saturation(const data__series *s, lab_channel_audit *a)
{
    int scatters = a->noise_from != LAB_NOISE_STEP && a->noise_estimated > 1e-5 * s->range &&
                   a->noise_estimated > 0.7 * a->step;
    double fast = fmax(3.0 * a->step, fmax(6.0 * s->sigma, 1e-3 * s->range));
    a->saturated_low = cut_off(s, a->low, scatters, fast);
    a->saturated_high = cut_off(s, a->high, scatters, fast);
}
