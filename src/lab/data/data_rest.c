/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_rest.c - where a channel rests, and when it first moves.
 *
 * A rest begins as a stretch of 40 samples whose best parabola explains no more than noise would;
 * so the turning point of a flight is no rest. It grows by blocks of eight as long as the median of
 * a block stays near the mean. It is then judged once more as a whole, and its ends are fitted
 * sample by sample.
 *
 * First motion. A body that is let go moves as a (t - t0)^2 / 2. Where the record passes 3 sigma,
 * at t1, it is late by an amount that depends on the noise. With t2, where it passes four times as
 * much, t0 = 2 t1 - t2 holds for any a.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_internal.h"

enum { SEED = 40, START = 20, BLOCK = 8 };

/* is the stretch at rest, by the share that a parabola explains? */
static int is_flat(const data__series *s, int first, int n, double tolerated)
{
    double mean = 0.0, about = 0.0, sigma = s->sigma;
    for (int i = first; i < first + n; i++) {
        mean += s->v[i] / n;
    }
    for (int i = first; i < first + n; i++) {
        about += (s->v[i] - mean) * (s->v[i] - mean);
    }
    double left = data__residual(s->t + first, s->v + first, n, 2, s->scratch);
    double explained = fmax(0.0, about - left);
    int small =
        explained < 16.0 * sigma * sigma || explained < n * tolerated * tolerated * sigma * sigma;
    return small && left < n * 4.0 * sigma * sigma;
}

static double block_median(const data__series *s, int first, int n)
{
    double v[BLOCK];
    memcpy(v, s->v + first, sizeof *v * (size_t)n);
    return data__median(v, n);
}

/* last sample of the rest that begins with the seed at `first` */
static int grow_rest(const data__series *s, int first, int seed, double *mean)
{
    int last = first + seed - 1;
    double sum = 0.0;
    for (int i = first; i <= last; i++) {
        sum += s->v[i];
    }
    while (last + BLOCK < s->n) {
        *mean = sum / (last - first + 1);
        if (fabs(block_median(s, last + 1, BLOCK) - *mean) > 2.0 * s->sigma) {
            break;
        }
        for (int i = 0; i < BLOCK; i++) {
            sum += s->v[++last];
        }
    }
    *mean = sum / (last - first + 1);
    // into the block that failed, to the first of two samples that are off
    while (last + 1 < s->n &&
           (fabs(s->v[last + 1] - *mean) < 3.5 * s->sigma ||
            (last + 2 < s->n && fabs(s->v[last + 2] - *mean) < 3.5 * s->sigma))) {
        last++;
    }
    return last;
}

/* Is the stretch grown from a seed a rest? Its end may hold the first of the motion: a long one is
 * judged, and kept, without it. @return last sample, or first - 1 */
static int judge_rest(const data__series *s, int first, int last, int seed, double mean)
{
    int n = last - first + 1;
    double tolerated = n > 5 * seed ? 1.0 : 0.35;
    if (is_flat(s, first, n, tolerated)) {
        return last;
    }
    while (n > 2 * seed &&
           fabs(block_median(s, first + n - BLOCK, BLOCK) - mean) > 1.1 * s->sigma) {
        n -= BLOCK / 2;
    }
    return n > 2 * seed && is_flat(s, first, n, tolerated) ? first + n - 1 : first - 1;
}

int data__rests(const data__series *s, int (*rest)[2], int max)
{
    int n = 0, seed = s->n >= 5 * SEED ? SEED : s->n / 5;
    if (seed < 8) {
        return 0;
    }
    int usual = seed;
    for (int i = 0; i + usual <= s->n && n < max;) {
        double mean;
        seed = i == 0 && usual > START ? START : usual;
        if (!is_flat(s, i, seed, 0.35)) {
            i += s->n > 1000000 ? seed / 2 : BLOCK / 2;
            continue;
        }
        int grown = grow_rest(s, i, seed, &mean), last = judge_rest(s, i, grown, seed, mean);
        if (last > i) {
            rest[n][0] = i;
            rest[n++][1] = last;
        }
        i = grown + 1;
    }
    return n;
}

/* ---- first motion ---- */

static double smooth(const data__series *s, int i)
{
    double v[5];
    int first = i < 2 ? 0 : i - 2, n = s->n - first < 5 ? s->n - first : 5;
    memcpy(v, s->v + first, sizeof *v * (size_t)n);
    return data__median(v, n);
}

/* time at which the smoothed record leaves `level` about the mean for good (four samples); NAN */
static double crossing(const data__series *s, int from, double mean, double level)
{
    for (int i = from; i + 3 < s->n; i++) {
        int out = 0;
        while (out < 4 && fabs(smooth(s, i + out) - mean) > level) {
            out++;
        }
        if (out == 4) {
            double b = fabs(smooth(s, i) - mean), a = i > 0 ? fabs(smooth(s, i - 1) - mean) : b;
            double u = b > a && a < level ? (level - a) / (b - a) : 1.0;
            return i > 0 ? s->t[i - 1] + u * (s->t[i] - s->t[i - 1]) : s->t[i];
        }
    }
    return NAN;
}

void data__first_motion(const data__series *s, const int rest[2], lab_channel_audit *a)
{
    double mean = 0.0;
    int n = rest[1] - rest[0] + 1, from = rest[0] + n / 2;
    for (int i = rest[0]; i < from; i++) { // the half that is far from the motion
        mean += s->v[i] / (from - rest[0]);
    }
    double level = 3.0 * s->sigma;
    double t1 = crossing(s, from, mean, level), t2 = crossing(s, from, mean, 4.0 * level);
    if (isnan(t1)) {
        return;
    }
    double t0 = isnan(t2) ? t1 : 2.0 * t1 - t2, frame = (s->t[s->n - 1] - s->t[0]) / (s->n - 1);
    a->motion = fmin(t1, fmax(t0, s->t[rest[0]]));
    a->motion_error = fmax(frame, 0.3 * (t1 - a->motion));
}
