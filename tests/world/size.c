/* SPDX-License-Identifier: GPL-3.0-or-later
 * size.c - how large an effect has to be: what is left of it when everything else is refitted.
 *
 * y(size) - y(0), in noises, is the change that an effect makes to the records. The columns of X
 * are what the other numbers do, by one standard deviation each: the uncertain numbers of the file,
 * zero errors of sensors, and for each record its initial state and its frictions. What is left is
 *
 *      r = d - X b,    b = argmin |d - X b|^2 + |b|^2
 *
 * and a level is a value of its RMS. To first order, with the first few records and a part of their
 * samples.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world.h"

enum { MOST_RECORDS = 4, FEW_RECORDS = 2, MOST_ROWS = 300, MOST_COLUMNS = 160, TRIALS = 9 };
static const double tolerance = 1e-9;
/* of what differs from record to record; a state that is not told may be any [rad, rad/s] */
static const double told_sd = 0.005, position_sd = 0.5, speed_sd = 3.0, friction_sd = 0.03;
static const double unknown_law = 0.3; /* of its value, where no tolerance is stated */
static const double sliding = 0.1;     /* [m] for a [rad] */
static const double small_angle = 2e-5, small_speed = 2e-4; /* by which it is changed */

static int is_driven(const mech *m)
{
    return m->ninput > 0 && m->input[0].kind == INPUT_MOTION;
}

typedef struct films {
    const mech *m;
    const design *d;
    int records, stride[MOST_RECORDS], first[MOST_RECORDS], rows; /* rows: all samples */
} films;

static films of_design(const mech *m, const design *d)
{
    int most = m->ncontact > 0 ? FEW_RECORDS : MOST_RECORDS; // contacts take many steps
    films f = {.m = m, .d = d, .records = d->nfit < most ? d->nfit : most};
    for (int i = 0; i < f.records; i++) {
        f.stride[i] = 1 + d->record[i].n / MOST_ROWS;
        f.first[i] = f.rows;
        f.rows += m->nchannel * ((d->record[i].n + f.stride[i] - 1) / f.stride[i]);
    }
    return f;
}

static int end_of(const films *f, int record)
{
    return record + 1 < f->records ? f->first[record + 1] : f->rows;
}

/* one record in noises */
static int shoot(const films *f, const double *p, int record, const setup *s, double *y)
{
    double *at = y + f->first[record];
    if (record_film(f->m, p, f->d, s, f->stride[record], tolerance, at) != 0) {
        return -1;
    }
    for (int k = 0; k < end_of(f, record) - f->first[record]; k++) {
        at[k] /= f->d->sensor[k % f->m->nchannel].sd;
    }
    return 0;
}

static int shoot_all(const films *f, const double *p, double *y)
{
    int status = 0;
    for (int i = 0; i < f->records && status == 0; i++) {
        status = shoot(f, p, i, &f->d->record[i], y);
    }
    return status;
}

/* ---- columns ---- */

/* what a column is a change of: a number, or a state or friction of a record */
typedef struct source {
    int number, record, body; /* number -1: one of a record's own */
    char what;                /* 'q', 'v', 'f' */
    double sd;
} source;

typedef struct columns {
    int n, rows, out[MOST_COLUMNS]; /* left out */
    source of[MOST_COLUMNS];
    double *X; /* [n][rows] */
    double *L; /* Cholesky factor of X'X + 1 */
} columns;

static double *fresh(columns *c, source of)
{
    if (c->n == MOST_COLUMNS) {
        return NULL;
    }
    c->of[c->n] = of;
    return c->X + (size_t)c->n++ * (size_t)c->rows;
}

/* How well a number is known. Where no tolerance is stated, weights and lengths are what a kitchen
 * scale and a ruler tell; stiffnesses and frictions are unknown. */
static double sd_of(const design *d, const number *N, double value)
{
    static const struct {
        const char *unit;
        double share, least;
    } measured[] = {{"kg", 0.005, 0.0}, {"m", 0.003, 2e-4}, {"kg m^2", 0.02, 0.0}};
    double told = N->sd;
    for (size_t i = 0; i < sizeof measured / sizeof *measured; i++) {
        if (strcmp(N->unit, measured[i].unit) == 0) {
            double by_hand = hypot(measured[i].share * value, measured[i].least);
            return d->tolerances || !N->stated ? told : fmax(told, by_hand);
        }
    }
    return d->tolerances || !N->stated ? told : fmax(told, unknown_law * fabs(value));
}

static int common_columns(const films *f, const double *p, const double *base, columns *c)
{
    double q[NUMBERS];
    for (int i = 0; i < f->m->nnumber; i++) {
        const number *N = &f->m->number[i];
        double sd = sd_of(f->d, N, p[i]);
        double *x = N->sd > 0.0 ? fresh(c, (source){.number = i, .record = -1, .sd = sd}) : NULL;
        if (x == NULL) {
            continue;
        }
        memcpy(q, p, sizeof q);
        q[i] += 0.05 * sd;
        if (shoot_all(f, q, x) != 0) {
            return -1;
        }
        for (int k = 0; k < c->rows; k++) {
            x[k] = (x[k] - base[k]) / 0.05;
        }
    }
    return 0;
}

/* by one number of a record, changed by `by`, which is a share of its standard deviation */
static int own_column(const films *f, const double *p, const source *of, const setup *s,
                      double share, const double *base, columns *c)
{
    int record = of->record;
    double *x = fresh(c, *of);
    if (x == NULL) {
        return 0;
    }
    memset(x, 0, sizeof(double) * (size_t)c->rows);
    if (shoot(f, p, record, s, x) != 0) {
        return -1;
    }
    for (int k = f->first[record]; k < end_of(f, record); k++) {
        x[k] = (x[k] - base[k]) / share;
    }
    return 0;
}

static int has_friction(const films *f, const double *p, int b)
{
    const double *law = p + f->m->body[b].law;
    return law[J_B] > 0.0 || law[J_T] > 0.0 || law[J_A] > 0.0 || law[J_DRAG] > 0.0;
}

static int record_columns(const films *f, const double *p, int record, const double *base,
                          columns *c)
{
    int status = 0;
    for (int b = 0; b < f->m->nbody && status == 0; b++) {
        double unit = f->m->body[b].type == 'R' ? 1.0 : sliding;
        double sd = isfinite(f->d->record[record].said[b]) ? told_sd : position_sd;
        setup s = f->d->record[record];
        source of = {.number = -1, .record = record, .body = b, .what = 'q', .sd = sd * unit};
        if (!f->m->settle && !is_driven(f->m)) {
            s.q[b] += small_angle * unit;
            status = own_column(f, p, &of, &s, small_angle / sd, base, c);
            s = f->d->record[record];
            s.qd[b] += small_speed * unit;
            of.what = 'v', of.sd = speed_sd * unit;
            if (f->d->moving && status == 0) {
                status = own_column(f, p, &of, &s, small_speed / speed_sd, base, c);
            }
        }
        s = f->d->record[record];
        s.joint_scatter[b] += 0.1 * friction_sd;
        of.what = 'f', of.sd = friction_sd;
        if (has_friction(f, p, b) && status == 0) {
            status = own_column(f, p, &of, &s, 0.1, base, c);
        }
    }
    return status;
}

/* @param without  [numbers] 1: its column is left out; NULL: none is */
static int factorise(columns *c, const int *without)
{
    free(c->L);
    c->L = calloc((size_t)c->n * (size_t)c->n + 1, sizeof *c->L);
    for (int i = 0; i < c->n; i++) {
        c->out[i] = without != NULL && c->of[i].number >= 0 && without[c->of[i].number];
    }
    for (int i = 0; c->L != NULL && i < c->n; i++) {
        for (int j = 0; j <= i; j++) {
            const double *x = c->X + (size_t)i * (size_t)c->rows;
            const double *y = c->X + (size_t)j * (size_t)c->rows;
            double sum = i == j ? 1.0 : 0.0;
            for (int k = 0; k < c->rows && !c->out[i] && !c->out[j]; k++) {
                sum += x[k] * y[k];
            }
            for (int k = 0; k < j; k++) {
                sum -= c->L[i * c->n + k] * c->L[j * c->n + k];
            }
            if (i == j && !(sum > 0.0)) {
                return -1;
            }
            c->L[i * c->n + j] = i == j ? sqrt(sum) : sum / c->L[j * c->n + j];
        }
    }
    return c->L != NULL ? 0 : -1;
}

/* b = (X'X + 1)^-1 (X'd + at); at NULL: 0 */
static void solve(const columns *c, const double *d, const double *at, double *b)
{
    int n = c->n;
    for (int i = 0; i < n; i++) {
        b[i] = at != NULL && !c->out[i] ? at[i] : 0.0;
        for (int k = 0; k < c->rows && !c->out[i]; k++) {
            b[i] += c->X[(size_t)i * (size_t)c->rows + (size_t)k] * d[k];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            b[i] -= c->L[i * n + k] * b[k];
        }
        b[i] /= c->L[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) {
            b[i] -= c->L[k * n + i] * b[k];
        }
        b[i] /= c->L[i * n + i];
    }
}

/* RMS of what is left of a change to first order; d becomes that */
static double left_of(const columns *c, double *d)
{
    double b[MOST_COLUMNS], sum = 0.0;
    int n = c->n;
    solve(c, d, NULL, b);
    for (int k = 0; k < c->rows; k++) {
        for (int i = 0; i < n; i++) {
            d[k] -= c->out[i] ? 0.0 : c->X[(size_t)i * (size_t)c->rows + (size_t)k] * b[i];
        }
        sum += d[k] * d[k];
    }
    return sqrt(sum / c->rows);
}

/* ---- a level ---- */

struct sizer {
    films f;
    columns c;
    const double *p;
    double *base, *d, *other, *rest;
    unsigned long long draw; /* of the noise of measured forces, 0: none */
    double noise;            /* of the records, with what that does [noise] */
};

void size_drop(sizer *z)
{
    if (z != NULL) {
        free(z->c.X);
        free(z->c.L);
        free(z->base);
        free(z->d);
        free(z->other);
        free(z->rest);
        free(z);
    }
}

/* y(p, b) - y(0, 0) into d. @return |d|^2 + |b|^2, INFINITY: it cannot be simulated */
static double refitted(sizer *z, const mech *m, const double *p, const double *b, double *d)
{
    static setup own;
    double q[NUMBERS], sum = 0.0;
    const columns *c = &z->c;
    films f = z->f;
    f.m = m;
    memcpy(q, p, sizeof *q * (size_t)m->nnumber);
    for (int i = 0; i < c->n; i++) {
        q[c->of[i].number >= 0 ? c->of[i].number : 0] +=
            c->of[i].number >= 0 ? b[i] * c->of[i].sd : 0.0;
        sum += b[i] * b[i];
    }
    for (int r = 0; r < f.records; r++) {
        own = f.d->record[r];
        for (int i = 0; i < c->n; i++) {
            const source *of = &c->of[i];
            if (of->number < 0 && of->record == r) {
                double *x = of->what == 'q' ? own.q : of->what == 'v' ? own.qd : own.joint_scatter;
                x[of->body] += b[i] * of->sd;
            }
        }
        for (int i = 0; i < f.m->ninput && z->draw > 0; i++) {
            own.drive[i].noise = f.d->input[i].sd;
            own.drive[i].draw = (z->draw << 40) + ((unsigned long long)(r * INPUTS + i) << 24);
        }
        if (shoot(&f, q, r, &own, d) != 0) {
            return INFINITY;
        }
    }
    for (int k = 0; k < f.rows; k++) {
        d[k] -= z->base[k];
        sum += d[k] * d[k];
    }
    return sum;
}

double size_of(sizer *z, const mech *m, const double *p)
{
    enum { STEPS = 5 };
    const double enough = 0.05, most = 4.0; /* of the objective; standard deviations */
    double b[MOST_COLUMNS] = {0.0}, next[MOST_COLUMNS], step[MOST_COLUMNS], sum = 0.0;
    const columns *c = &z->c;
    double now = refitted(z, m, p, b, z->d), by = 1.0;
    for (int i = 0; i < STEPS && isfinite(now) && by > 0.1; i++) {
        solve(c, z->d, b, step);
        for (int k = 0; k < c->n; k++) {
            next[k] = c->out[k] ? 0.0 : fmin(fmax(b[k] - by * step[k], -most), most);
        }
        double then = refitted(z, m, p, next, z->rest);
        if (!(then < now)) {
            by *= 0.3;
            continue;
        }
        memcpy(b, next, sizeof b);
        memcpy(z->d, z->rest, sizeof *z->d * (size_t)c->rows);
        if (then > (1.0 - enough) * now) {
            break;
        }
        now = then;
    }
    for (int k = 0; k < c->rows; k++) {
        sum += z->d[k] * z->d[k];
    }
    return isfinite(now) ? sqrt(sum / c->rows) : (double)NAN;
}

double size_change(sizer *z, const double *p)
{
    double sum = 0.0;
    if (shoot_all(&z->f, p, z->other) != 0) {
        return NAN;
    }
    for (int k = 0; k < z->c.rows; k++) {
        sum += (z->other[k] - z->base[k]) * (z->other[k] - z->base[k]);
    }
    return sqrt(sum / z->c.rows);
}

static void note_input_noise(sizer *z)
{
    enum { DRAWS = 3 };
    double sum = 1.0;
    for (int i = 0; i < z->f.m->ninput && sum == 1.0; i++) {
        for (int k = 1; k <= DRAWS && z->f.m->input[i].kind != INPUT_MOTION; k++) {
            z->draw = (unsigned long long)k;
            double rms = size_of(z, z->f.m, z->p);
            sum += isfinite(rms) ? rms * rms / DRAWS : 0.0;
        }
    }
    z->draw = 0;
    z->noise = sqrt(sum);
}

sizer *size_begin(const mech *m, const double *p, const design *d)
{
    sizer *z = calloc(1, sizeof *z);
    int status = z != NULL ? 0 : -1;
    if (status == 0) {
        z->f = of_design(m, d);
        z->p = p;
        z->c.rows = z->f.rows;
        z->c.X = calloc((size_t)MOST_COLUMNS * (size_t)z->f.rows, sizeof(double));
        z->base = calloc((size_t)z->f.rows, sizeof(double));
        z->d = calloc((size_t)z->f.rows, sizeof(double));
        z->other = calloc((size_t)z->f.rows, sizeof(double));
        z->rest = calloc((size_t)z->f.rows, sizeof(double));
        status = z->c.X && z->base && z->d && z->other && z->rest ? 0 : -1;
    }
    status = status == 0 ? shoot_all(&z->f, p, z->base) : status;
    status = status == 0 ? common_columns(&z->f, p, z->base, &z->c) : status;
    for (int i = 0; status == 0 && i < z->f.records; i++) {
        status = record_columns(&z->f, p, i, z->base, &z->c);
    }
    if (status != 0 || factorise(&z->c, NULL) != 0) {
        size_drop(z);
        return NULL;
    }
    note_input_noise(z);
    return z;
}

static double with_effect(sizer *z, const effect *e, double size)
{
    static mech room;
    double q[NUMBERS];
    return size_of(z, structure_with(&room, z->f.m, e, size, z->p, q), q) / z->noise;
}

/* numbers that the effect changes cannot take it up as errors of the file */
static void leave_out(sizer *z, const effect *e)
{
    double q[NUMBERS];
    int without[NUMBERS] = {0};
    memcpy(q, z->p, sizeof q);
    effect_apply(e, z->f.m, 0.1 * e->limit, q);
    for (int i = 0; i < z->f.m->nnumber; i++) {
        without[i] = fabs(q[i] - z->p[i]) > 0.0;
    }
    factorise(&z->c, without);
}

/* Is it more than the errors that the file's own numbers may have? What is within them is none. */
static int is_beyond(const sizer *z, const effect *e)
{
    const double least = 4.0; /* standard deviations */
    double q[NUMBERS];
    int yes = 1;
    memcpy(q, z->p, sizeof q);
    effect_apply(e, z->f.m, e->size, q);
    for (int i = 0; i < z->f.m->nnumber; i++) {
        double by = fabs(q[i] - z->p[i]), sd = sd_of(z->f.d, &z->f.m->number[i], z->p[i]);
        yes &= !(by > 0.0) || by >= least * sd;
    }
    return yes;
}

int size_find(sizer *z, effect *e, double target, double *reached)
{
    leave_out(z, e);
    double lo = 0.0, hi = 1.0, at = 0.01, rms = 0.0; // shares of the limit
    for (int i = 0; i < TRIALS; i++) {
        rms = with_effect(z, e, at * e->limit);
        if (!isfinite(rms) || rms > target) {
            hi = at;
        } else {
            lo = at;
        }
        if (isfinite(rms) && fabs(log(rms / target)) < 0.05) {
            break;
        }
        double next = isfinite(rms) && rms > 0.0 ? at * target / rms : 0.3 * at;
        if (next >= 1.0 && at >= 1.0) {
            break;
        }
        at = next > lo && next < hi ? next : hi < 1.0 ? sqrt(fmax(lo, 0.1 * hi) * hi) : 1.0;
    }
    e->size = at * e->limit;
    *reached = rms;
    return isfinite(rms) && rms > 0.8 * target && rms < 1.25 * target && is_beyond(z, e);
}

/* ---- what cannot be told from an effect ---- */

static int change_of(sizer *z, const effect *e, double size, double *d)
{
    static mech room;
    double q[NUMBERS];
    films f = z->f;
    f.m = structure_with(&room, z->f.m, e, size, z->p, q);
    if (shoot_all(&f, q, d) != 0) {
        return -1;
    }
    for (int k = 0; k < z->f.rows; k++) {
        d[k] -= z->base[k];
    }
    return 0;
}

static double all_samples(const films *f)
{
    double n = 0.0;
    for (int i = 0; i < f->d->nfit; i++) {
        n += f->d->record[i].n * f->m->nchannel;
    }
    return n;
}

static double product(const double *x, const double *y, int n)
{
    double sum = 0.0;
    for (int k = 0; k < n; k++) {
        sum += x[k] * y[k];
    }
    return sum;
}

/* what is left of the change to a size of a rival, into x */
static int left_by(sizer *z, const effect *rival, double size, double *x)
{
    int status = change_of(z, rival, size, x);
    if (status == 0) {
        left_of(&z->c, x);
    }
    return status;
}

/* The sum of squares that is left of d when a rival takes the best size, found by Gauss and
 * Newton's steps from 0; *size is that. A rival that explains little in the first step is given up.
 */
static double rest_of(sizer *z, const effect *rival, const double *d, double *size)
{
    enum { STEPS = 4 };
    const double promising = 0.8, step = 1e-3 * rival->limit;
    int n = z->f.rows;
    double *x = z->other, *r = z->rest, left = product(d, d, n), first = left;
    *size = 0.0;
    memcpy(r, d, sizeof *r * (size_t)n);
    for (int i = 0; i < STEPS; i++) {
        if (left_by(z, rival, *size + step, x) != 0) {
            break;
        }
        for (int k = 0; k < n; k++) {
            x[k] -= d[k] - r[k]; // the slope at the size that it has
        }
        double xx = product(x, x, n), rx = product(r, x, n);
        if (!(xx > 0.0) || left - rx * rx / xx > promising * first) {
            break;
        }
        double next = *size + step * rx / xx;
        if (fabs(next) > 1.5 * fabs(rival->limit) || left_by(z, rival, next, x) != 0) {
            break;
        }
        for (int k = 0; k < n; k++) {
            r[k] = d[k] - x[k];
        }
        double now = product(r, r, n);
        if (!(now < left)) {
            break;
        }
        *size = next;
        left = now;
    }
    return left;
}

int size_alike(sizer *z, const effect *e, effect *list, int n)
{
    const double told_apart = 9.0; // 3 standard deviations
    double share = all_samples(&z->f) / z->f.rows;
    int kept = 0;
    leave_out(z, e);
    if (change_of(z, e, e->size, z->d) != 0) {
        return 0;
    }
    left_of(&z->c, z->d);
    for (int i = 0; i < n; i++) {
        effect r = list[i];
        double size = 0.0;
        if (r.kind == e->kind && r.index == e->index) {
            continue;
        }
        r.size = share * rest_of(z, &r, z->d, &size) < told_apart ? size : 0.0;
        int right_sign = r.kind->both || size * r.limit > 0.0;
        if (fabs(r.size) > 0.0 && fabs(size) <= 1.2 * fabs(r.limit) && right_sign) {
            list[kept++] = r;
        }
    }
    return kept;
}

/* ---- what a motion is like ---- */

static void look_at(const play *s, const double *q, const double *qd, const double *qdd, double *lo,
                    double *hi, extent *x)
{
    for (int b = 0; b < s->m->nbody; b++) {
        double moment = 0.0;
        for (int k = 0; k < s->m->nbody; k++) {
            moment += s->M[b * s->m->nbody + k] * qdd[k];
        }
        lo[b] = fmin(lo[b], q[b]), hi[b] = fmax(hi[b], q[b]);
        x->qd[b] += qd[b] * qd[b];
        x->torque[b] += fabs(moment); // the mean: impacts would be most of a square
    }
}

static void look_outside(play *s, const double *q, const double *qd, extent *x)
{
    const mech *m = s->m;
    for (int c = 0; c < m->ncontact; c++) {
        x->depth[c] = fmax(x->depth[c], -touch_gap(s, c));
    }
    for (int c = 0; c < m->nchannel; c++) {
        const channel *ch = &m->channel[c];
        double y = ch->read == READ_POSITION ? q[ch->index]
                   : ch->read == READ_SPEED  ? qd[ch->index]
                   : ch->read == READ_EFFORT ? s->effort[m->input[ch->index].body]
                                             : 0.1;
        x->y[c] = fmax(x->y[c], fabs(y));
    }
}

/* one record, looked at so often */
static int scan(const mech *m, const double *p, const design *d, const setup *set, int looks,
                double *lo, double *hi, extent *x)
{
    play s = {.m = m, .p = p, .drive = NULL};
    state at = {.t = -set->before};
    double q[BODIES], qd[BODIES], qdd[BODIES];
    memcpy(at.q, set->q, sizeof at.q);
    memcpy(at.qd, set->qd, sizeof at.qd);
    if (m->settle && run_settle(&s, &at) != 0) {
        return -1;
    }
    s.drive = m->ninput > 0 ? set->drive : NULL;
    for (int k = 0; k < looks; k++) {
        double T = k * set->n / d->rate / looks;
        if (is_driven(m)) {
            at.t = T;
        } else if (run_to(&s, &at, T, 1e-7) != 0) {
            return -1;
        }
        memcpy(q, at.q, sizeof q);
        memcpy(qd, at.qd, sizeof qd);
        if (motion_rates(&s, T, q, qd, qdd) != 0) {
            return -1;
        }
        look_at(&s, q, qd, qdd, lo, hi, x);
        look_outside(&s, q, qd, x);
    }
    return 0;
}

int size_extent(const mech *m, const double *p, const design *d, extent *x)
{
    enum { LOOKS = 400 };
    double lo[BODIES], hi[BODIES];
    int status = 0, records = d->nfit < MOST_RECORDS ? d->nfit : MOST_RECORDS;
    memset(x, 0, sizeof *x);
    for (int b = 0; b < BODIES; b++) {
        lo[b] = INFINITY, hi[b] = -INFINITY;
    }
    for (int i = 0; i < records && status == 0; i++) {
        status = scan(m, p, d, &d->record[i], LOOKS, lo, hi, x);
    }
    double n = records * (double)LOOKS;
    for (int b = 0; b < m->nbody; b++) {
        x->q[b] = 0.5 * (hi[b] - lo[b]), x->mid[b] = 0.5 * (hi[b] + lo[b]);
        x->qd[b] = sqrt(x->qd[b] / n), x->torque[b] /= n;
    }
    return status;
}
