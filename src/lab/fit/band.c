/* SPDX-License-Identifier: GPL-3.0-or-later
 * band.c - how far measured motions are smoothed where the forces that they needed were measured.
 *
 * An encoder errs by more than white noise: steps that neighbours share, an eccentric disc, times
 * that jitter, teeth. The second derivative makes a torque of all that, which the measured torque
 * does not contain. Steps of 0.38 mrad at 300 Hz, smoothed as far as their variance allows, left 1
 * N m where the noise of the torque is 0.2 N m. So the band f of each motion is the one with which
 * the measured forces follow best,
 *
 *      minimise   sum_c  n_c ln sum_i (F_ci - F(u_f, t_i))^2       over f = f_max 2^-k/2
 *
 * c the force channels: first one f for all motions, then each by itself. Of those that are as good
 * the widest is taken. With the numbers of the file their errors hide the effect of a band. So the
 * bands are chosen, the numbers are fitted, and the bands are chosen again. A band that would take
 * away more than `motion_lost` of the motion itself is none: what is wrong with the model may be
 * less where the motion is less. Where the noise of the motion has chosen as well as any band, that
 * stays.
 *
 * At the ends of a record a smoothed motion has neighbours on one side only, and its acceleration
 * is off by ten times as much. So one period of the band at each end is no sample of the force.
 *
 * Beyond its band a motion says nothing of the force, and no candidate could explain what the
 * measured force does there: that is its noise.
 */
#include <math.h>
#include <stdlib.h>

#include "functions.h"
#include "fitting.h"

enum { BANDS = 20, RENEWALS = 5, ENDS = 8 /* share of a record */ };
static const double widest = 0.2;       /* of the rate of the samples */
static const double motion_lost = 0.01; /* RMS, in that of the motion */
static const double as_good = 1.02;     /* ratio of residuals */
static const double enough = 0.3;       /* of the objective: a fit has ended */
static const double half_octave = 0.7071067811865476;

static const lab_column *column_of(const lab_data *data, int input)
{
    for (int i = 0; i < data->ncolumn; i++) {
        if (data->column[i].role == LAB_INPUT && data->column[i].index == input) {
            return &data->column[i];
        }
    }
    return NULL;
}

double fit__band_of(const fit__problem *p, const lab_data *data, int input)
{
    const lab_column *c = column_of(data, input);
    double hz = p->def->smooth != NULL ? p->def->smooth[input] : (double)NAN;
    int states = c != NULL && c->smooth > 0.0 && !p->def->smooth_all;
    return states ? c->smooth : hz;
}

/* does a record leave the band open of a motion that it shows? */
static int leaves_open(const lab_data *data, int input)
{
    const lab_column *c = column_of(data, input);
    return c != NULL && !(c->smooth > 0.0);
}

/* Is there a channel of the force that a prescribed motion needs, in a record that does not state
 * the band? */
static int is_told(const fit__problem *p, int input)
{
    const stein_model *m = lab_equations(p->model);
    int channel = lab__channel_of(m, STEIN_READ_INPUT_FORCE, input), yes = 0;
    for (int s = 0; channel >= 0 && s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            yes |= p->stroke[s].channel[c] == channel && leaves_open(p->stroke[s].data, input);
        }
    }
    return yes && m->inputs[input].kind == STEIN_INPUT_MOTION;
}

/* RMS of a signal about its mean */
static double size_of(const fit__signal *s)
{
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < s->n; i++) {
        sum += s->g[i];
        square += s->g[i] * s->g[i];
    }
    return sqrt(fmax(0.0, square / s->n - sum * sum / s->n / s->n));
}

/* The signals of one input, smoothed to f. @param lost  out: largest share of a motion that went */
static stein_status resmooth(fit__problem *p, int input, double hz, double *lost, stein_err *err)
{
    stein_status status = STEIN_OK;
    *lost = 0.0;
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int k = 0; status == STEIN_OK && k < t->nsignal; k++) {
            fit__signal *g = &t->signal[k], to;
            if (g->input != input || !leaves_open(t->data, input)) {
                continue;
            }
            status = fit__signal_make(&to, input, 1, t->data, column_of(t->data, input), g->noise,
                                      hz, err);
            if (status != STEIN_OK) {
                fit__signal_free(&to);
                return status;
            }
            fit__signal_free(g);
            *g = to;
            *lost = fmax(*lost, g->taken / fmax(size_of(g), 1e-300));
        }
    }
    return status;
}

typedef struct choice {
    fit__problem *p;
    double *hz, *x, *r; /* [ninput] bands; [nu] the null hypothesis; residuals */
    double *lost;       /* [ninput] */
} choice;

static stein_status set(choice *c, int input, double hz, stein_err *err)
{
    c->hz[input] = hz;
    return resmooth(c->p, input, hz, &c->lost[input], err);
}

/* what is left of the forces, per sample: mean of ln r^2; INFINITY where it cannot be simulated or
 * too much of a motion is gone */
static stein_status judge(const choice *c, double *left, stein_err *err)
{
    const fit__problem *p = c->p;
    const stein_model *m = lab_equations(p->model);
    int failed = 0, bad = 0;
    double sum = 0.0, all = 0.0;
    stein_status status = fit__residuals(p, c->x, c->r, &failed, err);
    for (int i = 0; i < m->ninput; i++) {
        bad |= isfinite(c->hz[i]) && c->lost[i] > motion_lost;
    }
    for (int channel = 0; status == STEIN_OK && channel < m->nchannel; channel++) {
        double square = 0.0, n = 0.0;
        for (int s = 0; s < p->nstroke; s++) {
            const fit__stroke *t = &p->stroke[s];
            const double *r = c->r + fit__offset(p, s);
            for (int k = 0; k < t->nch * t->n; k++) {
                int of = k / t->n,
                    inside = k % t->n >= t->n / ENDS && k % t->n < t->n - t->n / ENDS,
                    is = inside && t->channel[of] == channel && isfinite(t->y[k]);
                double e = is ? fit__off(t, r, k) : 0.0;
                square += e * e;
                n += is;
            }
        }
        int force = m->channels[channel].read == STEIN_READ_INPUT_FORCE && n > 0.0;
        sum += force ? n * stein__log_of(fmax(square / n, 1e-300)) : 0.0;
        all += force ? n : 0.0;
    }
    *left = failed > 0 || bad ? (double)INFINITY : sum / fmax(all, 1.0);
    return status;
}

static double widest_of(const fit__problem *p)
{
    double hz = INFINITY;
    for (int s = 0; s < p->nstroke; s++) {
        const lab_data *d = p->stroke[s].data;
        double span = d->time[d->nrow - 1] - d->time[0];
        hz = span > 0.0 ? fmin(hz, widest * (d->nrow - 1) / span) : hz;
    }
    return hz;
}

/* the widest band of the n that is as good as the best. @return -1: none can be simulated */
static int choose(const double *left, int n)
{
    double least = INFINITY;
    for (int k = 0; k < n; k++) {
        least = fmin(least, left[k]);
    }
    for (int k = 0; k < n; k++) {
        if (left[k] <= least + 2.0 * stein__log_of(as_good)) {
            return isfinite(least) ? k : -1;
        }
    }
    return -1;
}

/* The best band of the inputs in `which`, the same for all of them, the others as they are. */
static stein_status scan(choice *c, const unsigned char *which, double *least, stein_err *err)
{
    int n = lab_equations(c->p->model)->ninput;
    double left[BANDS], band[BANDS], hz = widest_of(c->p);
    stein_status status = STEIN_OK;
    for (int k = 0; status == STEIN_OK && k < BANDS; k++, hz *= half_octave) {
        band[k] = hz;
        for (int i = 0; status == STEIN_OK && i < n; i++) {
            status = which[i] ? set(c, i, hz, err) : STEIN_OK;
        }
        status = status == STEIN_OK ? judge(c, &left[k], err) : status;
    }
    int best = status == STEIN_OK ? choose(left, BANDS) : -1;
    *least = best >= 0 ? left[best] : (double)INFINITY;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        status = which[i] ? set(c, i, best >= 0 ? band[best] : (double)NAN, err) : STEIN_OK;
    }
    return status;
}

/* all motions together, then each by itself; as the noise allows where that is as good */
static stein_status scan_all(choice *c, const unsigned char *told, unsigned char *one,
                             stein_err *err)
{
    int n = lab_equations(c->p->model)->ninput;
    double before, least;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        status = told[i] && isfinite(c->hz[i]) ? set(c, i, NAN, err) : STEIN_OK;
    }
    status = status == STEIN_OK ? judge(c, &before, err) : status;
    status = status == STEIN_OK ? scan(c, told, &least, err) : status;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        one[i] = told[i];
        status = told[i] && isfinite(least) ? scan(c, one, &least, err) : STEIN_OK;
        one[i] = 0;
    }
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        int stays = !(least < before - 2.0 * stein__log_of(as_good));
        status = told[i] && stays ? set(c, i, NAN, err) : STEIN_OK;
    }
    return status;
}

static const lab_column *output_of(const lab_data *data, int channel)
{
    int i = 0;
    while (data->column[i].role != LAB_OUTPUT || data->column[i].index != channel) {
        i++;
    }
    return &data->column[i];
}

stein_status fit__widen_noise(const fit__problem *p, fit__stroke *s, int k, stein_err *err)
{
    const stein_channel *c = &lab_equations(p->model)->channels[s->channel[k]];
    int force = c->read == STEIN_READ_INPUT_FORCE && !s->given[k];
    double hz = force ? fit__band_of(p, s->data, c->index) : (double)NAN;
    fit__signal beyond = {.t = NULL};
    if (!isfinite(hz)) {
        return STEIN_OK;
    }
    stein_status status = fit__signal_make(&beyond, c->index, 1, s->data,
                                           output_of(s->data, s->channel[k]), 0.0, hz, err);
    if (status == STEIN_OK) {
        s->noise[k] = s->audited[k] = fmax(s->noise[k], beyond.taken);
    }
    fit__signal_free(&beyond);
    return status;
}

void fit__mute_ends(const fit__problem *p, fit__stroke *s)
{
    const double *t = s->data->time;
    double whole = t[s->n - 1] - t[0];
    for (int k = 0; k < s->nch; k++) {
        const stein_channel *c = &lab_equations(p->model)->channels[s->channel[k]];
        double end = 0.0, *share = s->share + (size_t)k * (size_t)s->n, lost = 0.0;
        for (int i = 0; c->read == STEIN_READ_INPUT_FORCE && i < s->nsignal; i++) {
            const fit__signal *g = &s->signal[i];
            end = g->input == c->index && g->taken > 0.0
                      ? fmin(1.0 / fit__signal_band(g), whole / ENDS)
                      : end;
        }
        for (int i = 0; end > 0.0 && i < s->n; i++) {
            if (t[i] - t[0] < end || t[s->n - 1] - t[i] < end) {
                lost += share[i] * share[i];
                share[i] = 0.0;
            }
        }
        s->samples -= (int)lround(lost);
    }
}

stein_status fit__choose_bands(fit__problem *p, double *hz, stein_err *err)
{
    size_t n = (size_t)lab_equations(p->model)->ninput;
    unsigned char *told = calloc(2 * n + 1, 1);
    size_t rows = fit__offset(p, p->nstroke);
    double *room = calloc((size_t)p->nu + n + rows + fit__columns(p) + 1, sizeof *room);
    choice c = {.p = p, .hz = hz, .x = room};
    int any = 0;
    stein_status status = told != NULL && room != NULL ? STEIN_OK : lab__no_memory(err);
    for (size_t i = 0; status == STEIN_OK && i < n; i++) {
        hz[i] = NAN;
        told[i] = (unsigned char)is_told(p, (int)i);
        any |= told[i];
    }
    if (status == STEIN_OK && any) {
        c.lost = room + p->nu;
        c.r = c.lost + n;
        status = scan_all(&c, told, told + n, err);
        fit__end e = {.x = c.x, .r = c.r, .J = c.r + rows};
        stein_err why;
        status = status == STEIN_OK
                     ? fit__forgive(fit__descend(p, &e, 0, enough, RENEWALS, &why), err)
                     : status;
        status = status == STEIN_OK ? scan_all(&c, told, told + n, err) : status;
    }
    free(room);
    free(told);
    return status;
}
