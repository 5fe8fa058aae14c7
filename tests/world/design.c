/* SPDX-License-Identifier: GPL-3.0-or-later
 * design.c - how a set is measured: instruments, records, scatter between records, and the numbers
 * of the file.
 *
 * Drawn wider than a fit may assume: the friction of each place scatters, and also drifts over the
 * recordings; settings are not quite what is written; encoders have steps.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

static const double unstated = 0.25; /* errors of numbers without a stated tolerance: smaller */
enum { FEWEST = 150, LONGEST = 5000 };

/* ---- numbers of the file ---- */

static double rounded(double x, double scale, int digits)
{
    if (!(fabs(x) > 0.0)) {
        return 0.0;
    }
    double unit = pow(10.0, floor(log10(fabs(x / scale))) - digits + 1);
    return scale * unit * round(x / scale / unit);
}

static void draw_file(design *d, mech *m, chance *c, int quiet)
{
    for (int i = 0; i < m->nnumber; i++) {
        number *n = &m->number[i];
        if (!n->stated) {
            continue;
        }
        if (!(n->sd > 0.0) || quiet) {
            n->value = n->file = rounded(n->value, n->scale, 4);
            continue;
        }
        n->sd *= (d->tolerances ? 1.0 : unstated) * chance_log(c, 0.6, 2.0);
        n->file = rounded(n->value + n->sd * chance_normal(c), n->scale, 4);
        n->tolerance = d->tolerances;
    }
}

/* ---- instruments ---- */

static sensor of_noise(double noise, double step)
{
    return (sensor){noise, step, sqrt(noise * noise + step * step / 12.0)};
}

/* a rate gyro has an offset that is known to be there */
static void biased(mech *m, int channel_of, chance *c)
{
    number *n = &m->number[m->channel[channel_of].law + S_OFFSET];
    n->sd = chance_log(c, 0.002, 0.02);
    n->value = n->sd * chance_normal(c);
    n->stated = n->tolerance = 1;
}

/* a marker is glued on, an encoder put on its shaft, by hand: they stay where they are for all
 * records, and the file does not tell */
static void misplaced(mech *m, int channel_of, int turns, chance *c)
{
    const double arm = 0.1; // [m] a marker turns by so much of its shift
    number *n = &m->number[m->channel[channel_of].law + S_OFFSET];
    n->sd = chance_log(c, 1e-4, 1e-3) / (turns ? arm : 1.0);
    n->value = n->sd * chance_normal(c);
}

static void draw_sensors(design *d, mech *m, chance *c, int quiet)
{
    int video = chance_coin(c, 0.5);
    double angle = chance_log(c, 1e-4, 5e-3), length = chance_log(c, 3e-5, 5e-4);
    double least = FEWEST / (m->duration[0] + m->duration[1]) * 2.0;
    d->rate = video ? chance_log(c, 30.0, 500.0) : chance_log(c, 100.0, 1000.0);
    d->rate = fmax(d->rate, least);
    d->rate = d->rate > 100.0 ? 50.0 * round(d->rate / 50.0) : 10.0 * round(d->rate / 10.0);
    for (int i = 0; i < m->nchannel; i++) {
        int turns = strncmp(m->channel[i].unit, "rad", 3) == 0, read = m->channel[i].read;
        double size = turns ? angle : length;
        if (read == READ_SPEED) {
            d->sensor[i] = of_noise(chance_log(c, 0.002, 0.03), 0.0);
            biased(m, i, c);
        } else if (video || read == READ_X || read == READ_Z) {
            d->sensor[i] = of_noise(size, 0.0);
        } else {
            d->sensor[i] = of_noise(0.2 * size, size);
        }
        if (read != READ_SPEED && read != READ_EFFORT && !quiet) {
            misplaced(m, i, turns, c);
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        int motion = m->input[i].kind == INPUT_MOTION;
        d->input[i] =
            motion ? of_noise(0.0, chance_log(c, 1e-4, 5e-4)) : of_noise(0.003 * m->drive[i], 0.0);
    }
}

/* ---- records ---- */

static void draw_drive(const mech *m, const design *d, setup *s, chance *c)
{
    for (int i = 0; i < m->ninput; i++) {
        signal *u = &s->drive[i];
        *u = (signal){.grid = m->input[i].kind != INPUT_MOTION, .interval = 1.0 / d->rate};
        if (m->pushes) {
            u->from = chance_uniform(c, 0.01, 0.04);
            u->to = u->from + chance_uniform(c, 0.08, 0.16);
            u->push = m->drive[i] * chance_uniform(c, 0.5, 1.5);
            continue;
        }
        u->n = 3;
        for (int k = 0; k < u->n; k++) {
            u->amplitude[k] = m->drive[i] * chance_uniform(c, 0.3, 0.8);
            u->rate[k] = 6.283185307179586 * chance_log(c, m->drive_rate[0], m->drive_rate[1]);
            u->phase[k] = chance_uniform(c, 0.0, 6.283185307179586);
        }
    }
}

static void draw_record(const mech *m, design *d, setup *s, int turn, chance *c, int quiet)
{
    int all = d->nfit + d->nheld;
    double length = chance_uniform(c, m->duration[0], m->duration[1]) * (d->one_long ? 4.0 : 1.0);
    s->n = (int)(length * d->rate);
    s->n = s->n > LONGEST ? LONGEST : s->n;
    for (int b = 0; b < BODIES; b++) {
        s->joint_scatter[b] = 1.0; // also of a body that is hidden
    }
    s->before = d->moving ? chance_uniform(c, 0.1, 0.6) * m->duration[0] : 0.0;
    for (int b = 0; b < m->nbody; b++) {
        int turns = m->body[b].type == 'R';
        double unit = turns ? 3.14159265358979323846 / 180.0 : 1e-3;
        double far = chance_uniform(c, 0.4, 1.0) * (chance_coin(c, 0.5) ? 1.0 : -1.0);
        double told = unit * round((m->mean[b] + m->swing[b] * far) / unit);
        s->said[b] = d->told && m->swing[b] > 0.0 ? told : NAN;
        s->q[b] = told + (m->swing[b] > 0.0 && !quiet ? 0.3 * unit * chance_normal(c) : 0.0);
        s->qd[b] = d->moving ? m->kick[b] * chance_uniform(c, -1.0, 1.0) : 0.0;
        s->joint_scatter[b] =
            1.0 + d->joint_sd * chance_normal(c) + d->drift * (turn - 0.5 * all) / all;
    }
    for (int i = 0; i < m->ncontact; i++) {
        s->contact_scatter[i] = 1.0 + d->contact_sd * chance_normal(c);
    }
    draw_drive(m, d, s, c);
}

static int drives(const mech *m, int type)
{
    return m->ninput > 0 && m->input[0].kind == type;
}

/* noise of measured forces: a share of what they are */
static void draw_efforts(const mech *m, const double *p, design *d, chance *c)
{
    double share = chance_log(c, 0.004, 0.03);
    double *y = calloc((size_t)d->record[0].n * CHANNELS, sizeof *y);
    int n = d->record[0].n, stride = 1 + n / 400;
    if (y != NULL && record_film(m, p, d, &d->record[0], stride, 1e-6, y) == 0) {
        for (int i = 0; i < m->nchannel; i++) {
            double sum = 0.0;
            int rows = (n + stride - 1) / stride;
            for (int k = 0; k < rows; k++) {
                sum += y[k * m->nchannel + i] * y[k * m->nchannel + i];
            }
            if (m->channel[i].read == READ_EFFORT) {
                d->sensor[i] = of_noise(share * sqrt(sum / rows), 0.0);
            }
        }
    }
    free(y);
}

void design_draw(design *d, mech *m, chance *c, int quiet)
{
    double p[NUMBERS];
    memset(d, 0, sizeof *d);
    d->tolerances = chance_coin(c, 0.5);
    d->noise_told = chance_coin(c, 0.5);
    d->moving = !m->settle && !drives(m, INPUT_MOTION) && chance_coin(c, 0.5);
    d->told = !m->settle && !d->moving && !drives(m, INPUT_MOTION) && chance_coin(c, 0.5);
    d->one_long = !m->settle && m->ncontact == 0 && m->nbody <= 2 && chance_coin(c, 0.2);
    d->nfit = d->one_long ? 1 : 2 + chance_pick(c, 11);
    d->nheld = d->one_long ? chance_pick(c, 2) : 1 + chance_pick(c, 6);
    d->joint_sd = chance_uniform(c, 0.0, 0.04);
    d->contact_sd = chance_uniform(c, 0.0, 0.03);
    d->drift = chance_uniform(c, -0.02, 0.02);
    draw_sensors(d, m, c, quiet);
    if (quiet) {
        // whole steps of any simulator; a spline through samples of a motion has to be exact
        d->rate = drives(m, INPUT_MOTION) ? 5000.0 : 500.0;
        d->joint_sd = d->contact_sd = d->drift = 0.0;
        d->moving = 0, d->told = 1, d->one_long = 0, d->nfit = 1, d->nheld = 0;
    }
    draw_file(d, m, c, quiet);
    for (int i = 0; i < d->nfit + d->nheld; i++) {
        draw_record(m, d, &d->record[i], i, c, quiet);
    }
    for (int i = 0; i < m->nnumber; i++) {
        p[i] = m->number[i].value;
    }
    if (drives(m, INPUT_MOTION)) {
        draw_efforts(m, p, d, c);
    }
}
