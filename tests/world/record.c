/* SPDX-License-Identifier: GPL-3.0-or-later
 * record.c - one record: the motion from its release on, read by instruments.
 *
 * Time 0 is the first sample; a record may begin in the middle of the motion, `before` seconds
 * after the release. The frame recorded at t was taken at (1 + clock.error) t, and an instrument
 * shows then what was there `delay` earlier; before the release everything is at rest in the
 * initial state. Signals of inputs have the right time.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

/* the numbers of this record: friction is a little different each time */
static void scatter(const mech *m, const setup *s, double *p)
{
    static const int rubs[] = {J_B, J_T, J_A, J_DRAG, J_ROOT};
    for (int b = 0; b < m->nbody; b++) {
        for (size_t k = 0; k < sizeof rubs / sizeof *rubs; k++) {
            p[m->body[b].law + rubs[k]] *= s->joint_scatter[b];
        }
    }
    for (int i = 0; i < m->ncontact; i++) {
        p[m->contact[i].law + N_MU] *= s->contact_scatter[i];
        p[m->contact[i].law + N_D] *= s->contact_scatter[i];
    }
}

static int is_prescribed(const mech *m)
{
    int n = 0;
    for (int i = 0; i < m->ninput; i++) {
        n += m->input[i].kind == INPUT_MOTION;
    }
    return n == m->nbody;
}

static int release(play *s, const setup *set, state *x)
{
    const signal *drive = s->drive;
    int status = 0;
    *x = (state){.t = -set->before};
    memcpy(x->q, set->q, sizeof x->q);
    memcpy(x->qd, set->qd, sizeof x->qd);
    if (s->m->settle) {
        s->drive = NULL;
        status = run_settle(s, x);
        s->drive = drive;
        x->h = 1e-5;
    }
    return status;
}

/* channel values of a state; of the whole of them where `only` is -1 */
static int look(play *s, const state *x, int only, double *y)
{
    const mech *m = s->m;
    double q[BODIES], qd[BODIES], qdd[BODIES], r[3], at[3], v[3];
    memcpy(q, x->q, sizeof q);
    memcpy(qd, x->qd, sizeof qd);
    if (motion_rates(s, x->t, q, qd, qdd) != 0) {
        return -1;
    }
    for (int c = 0; c < m->nchannel; c++) {
        const channel *ch = &m->channel[c];
        if (only >= 0 && only != c) {
            continue;
        }
        if (ch->read == READ_X || ch->read == READ_Z) {
            motion_place(s, m->point[ch->index].at, r);
            motion_point(s, m->point[ch->index].body, r, at, v);
        }
        y[c] = ch->read == READ_POSITION ? q[ch->index]
               : ch->read == READ_SPEED  ? qd[ch->index]
               : ch->read == READ_X      ? at[0]
               : ch->read == READ_Z      ? at[2]
               : ch->read == READ_GAP    ? touch_gap(s, ch->index)
                                         : s->effort[m->input[ch->index].body];
    }
    return 0;
}

static double delay_of(const play *s, int c)
{
    return s->p[s->m->channel[c].law + S_DELAY];
}

/* the channel with the earliest next sample; -1: the look at time 0, -2: there are none */
static int earliest(const play *s, const design *d, const setup *set, int stride, const int *next,
                    int rest_seen, double *T)
{
    double clock = 1.0 + s->p[s->m->clock];
    int which = rest_seen ? -2 : -1;
    *T = rest_seen ? INFINITY : 0.0;
    for (int c = 0; c < s->m->nchannel; c++) {
        double t = clock * next[c] * stride / d->rate - delay_of(s, c);
        if (next[c] * stride < set->n && t < *T) {
            *T = t;
            which = c;
        }
    }
    return which;
}

static int follow(play *s, const design *d, const setup *set, int stride, double tolerance,
                  double *rest, double *y)
{
    int n = s->m->nchannel, next[CHANNELS] = {0}, rest_seen = 0;
    int still = is_prescribed(s->m);
    state x;
    double T, seen[CHANNELS];
    if (release(s, set, &x) != 0) {
        return -1;
    }
    for (int c; (c = earliest(s, d, set, stride, next, rest_seen, &T)) > -2;) {
        if (still) {
            x.t = T;
        } else if (T > x.t && run_to(s, &x, T, tolerance) != 0) {
            return -1;
        }
        if (look(s, &x, c, c < 0 ? rest : seen) != 0) {
            return -1;
        }
        rest_seen |= c < 0;
        if (c >= 0) {
            y[next[c]++ * n + c] = seen[c];
        }
    }
    return 0;
}

int record_film(const mech *m, const double *p, const design *d, const setup *s, int stride,
                double tolerance, double *y)
{
    double own[NUMBERS], rest[CHANNELS] = {0.0};
    int n = (s->n + stride - 1) / stride;
    memcpy(own, p, sizeof(double) * (size_t)m->nnumber);
    scatter(m, s, own);
    play run = {.m = m, .p = own, .drive = m->ninput > 0 ? s->drive : NULL};
    if (follow(&run, d, s, stride, tolerance, rest, y) != 0) {
        return -1;
    }
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < m->nchannel; c++) {
            const double *law = own + m->channel[c].law;
            double raw = y[i * m->nchannel + c], moved = raw - rest[c];
            y[i * m->nchannel + c] =
                law[S_GAIN] * raw + law[S_SQUARE] * moved * moved + law[S_OFFSET];
        }
    }
    return 0;
}

double record_noisy(const sensor *s, double y, chance *c)
{
    y += s->noise * chance_normal(c);
    return s->step > 0.0 ? s->step * round(y / s->step) : y;
}
