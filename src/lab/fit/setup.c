/* SPDX-License-Identifier: GPL-3.0-or-later
 * setup.c - does the beginning of the records follow from the equations, and if not, why?
 *
 * A wrong sign, zero, unit or plane shows in the first half swing, whatever the parameters are.
 * From the initial state that the first samples show, the model leaves the record by a large part
 * of its range. Up to four strokes are simulated for so long, and where that happens every
 * alternative is simulated as well,
 *
 *      y_c -> -y_c                     the sense of a channel
 *      y_c -> y_c + pi, +- pi/2        where an angle counts from
 *      y_c -> y_c - mean(y_c)          where a place counts from, if it swings about another one
 *      y_c -> y_c 57.3, /57.3, 1000    units
 *      y_a <-> y_b                     columns of the same unit exchanged
 *      y_c -> y_c - y_parent           an angle against the frame that was read as one of a joint
 *      gravity -> along +-x, +-y, +-z  the plane of the motion
 *      t -> t/20 .. 20 t               the pace, if nothing else fits: a film in slow motion, a
 *                                      spring or an inertia that is many times as large
 *
 * from the initial state that the changed record shows, improved by a few steps of Gauss-Newton.
 * The misfit is measured over noise and a hundredth of the motion's range together,
 *
 *      m = mean of (y - h)^2/(noise^2 + (range/100)^2),
 *
 * so that wrong parameters, which cost some hundredths of the range in half a swing, do not decide.
 * An alternative is reported when m falls ten times in every stroke that was simulated, and when it
 * fits. Without the second condition any reading with less motion would be reported where friction
 * holds a body that moves in the equations.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { MOST_STROKES = 4, MOST_CHANNELS = 12, STEPS = 4 };
static const double pi = 3.14159265358979323846;
static const double earth = 9.81; /* gravity [m/s^2] */
static const double axis[6][3] = {{1.0, 0.0, 0.0},  {-1.0, 0.0, 0.0}, {0.0, 1.0, 0.0},
                                  {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0},  {0.0, 0.0, -1.0}};
static const double share = 0.01;       /* of the range, as noise */
static const double suspicious = 10.0;  /* m above which alternatives are tried: 3 % of the range */
static const double hopeless = 300.0;   /* m above which a way does not fit: 17 % */
static const double much_better = 10.0; /* ratio of m from which an alternative is reported */
static const double coarse = 1e-7;      /* tolerance of a step [rad or m] */
static const double windows = 4.0; /* length of what is simulated, in start windows, at least */
static const double swings = 2.0;  /* and in half swings: one lies within, wherever they begin */

/* one way to read the records otherwise */
typedef struct way {
    fit__doubt doubt;
    int c, other;                        /* slots of channels in the strokes, -1: none */
    double factor, add;                  /* of samples; of a pace: of the time */
    int about_mean;                      /* 1: the mean of the samples is taken off */
    const double *gravity;               /* direction, NULL: that of the file */
    double m[MOST_STROKES], chi2, score; /* score: geometric mean of m over the strokes */
} way;

typedef struct trial {
    fit__problem *p;
    fit__bench bench;
    stein_sim *probe;                       /* for the potential */
    const double *gravity;                  /* direction of another one; NULL: that of the file */
    double *q, *mass, *along, *frc, *M, *c; /* [nq], [nq], [3*nq], [3*nq], [nq*nq], [2*nq] */
    int stroke[MOST_STROKES], nstroke;
    double until[MOST_STROKES];
    double *kept, *x; /* samples of a stroke; [nu] */
} trial;

/* ---- another gravity ---- */

/* the weight of every body along a direction of the fixed frame, in the body's own axes */
static void weigh_bodies(trial *a, const double *q, const double *direction)
{
    const stein_model *m = lab_equations(a->p->model);
    for (int i = 0; i < m->nq; i++) {
        const stein_body *b = &m->bodies[i];
        double *to = a->along + 3 * i;
        memcpy(to, b->parent >= 0 ? a->along + 3 * b->parent : direction, 3 * sizeof *to);
        if (b->type == 'R') { // turned back by the joint's angle
            int k = (b->axis - 'x' + 1) % 3, l = (k + 1) % 3;
            double c = cos(q[i]), s = b->sign * sin(q[i]), u = to[k], v = to[l];
            to[k] = c * u + s * v;
            to[l] = c * v - s * u;
        }
        for (int k = 0; k < 3; k++) {
            a->frc[3 * i + k] = a->mass[i] * earth * to[k];
        }
    }
}

/* the gravity of the file is taken away, by its potential, and another one acts */
static void pull(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    trial *a = ctx;
    int nq = lab_equations(a->p->model)->nq;
    (void)t;
    memcpy(a->q, q, sizeof *a->q * (size_t)nq);
    weigh_bodies(a, q, a->gravity);
    stein_mass_bias(a->probe, q, qd, NULL, NULL, a->M, a->c);
    stein_mass_bias(a->probe, q, qd, a->frc, NULL, a->M, a->c + nq);
    for (int j = 0; j < nq; j++) {
        const double h = 1e-5;
        double kinetic, up, down;
        a->q[j] = q[j] + h;
        stein_energy(a->probe, a->q, qd, &kinetic, &up);
        a->q[j] = q[j] - h;
        stein_energy(a->probe, a->q, qd, &kinetic, &down);
        a->q[j] = q[j];
        Q[j] += (up - down) / (2.0 * h) + a->c[j] - a->c[nq + j];
    }
}

static void find_masses(trial *a, const double *p)
{
    const stein_model *m = lab_equations(a->p->model);
    for (int i = 0; i < m->nq; i++) {
        char name[MECH_PATH];
        snprintf(name, sizeof name, "%s.mass", m->bodies[i].name);
        int at = stein_find_param(m, name);
        a->mass[i] = at >= 0 ? p[at] : 0.0;
    }
}

/* ---- one stroke read in one way ---- */

static double mean_of(const fit__stroke *s, int c)
{
    double sum = 0.0;
    int n = 0;
    for (int i = c * s->n; i < (c + 1) * s->n; i++) {
        sum += isfinite(s->y[i]) ? s->y[i] : 0.0;
        n += isfinite(s->y[i]) != 0;
    }
    return n > 0 ? sum / n : 0.0;
}

static void change(const way *w, fit__stroke *s)
{
    double *y = w->c >= 0 ? s->y + w->c * s->n : NULL;
    double *z = w->other >= 0 ? s->y + w->other * s->n : NULL;
    double add = w->about_mean ? -mean_of(s, w->c) : w->add;
    for (int i = 0; y != NULL && i < s->n; i++) {
        double was = y[i];
        y[i] = w->doubt == FIT__ABSOLUTE ? was + w->factor * z[i]
               : z != NULL               ? z[i]
                                         : w->factor * was + add;
        if (w->doubt == FIT__EXCHANGE) {
            z[i] = was;
        }
    }
}

/* sd of what a channel is off by: noise, and a share of its range until the horizon */
static void find_scales(const fit__stroke *s, double until, double *sd)
{
    for (int c = 0; c < s->nch; c++) {
        double lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < s->n && s->data->time[i] - s->origin <= until; i++) {
            double y = s->event[c].is ? (double)NAN : s->y[c * s->n + i];
            lo = isfinite(y) ? fmin(lo, y) : lo;
            hi = isfinite(y) ? fmax(hi, y) : hi;
        }
        sd[c] = hypot(s->noise[c], hi > lo ? share * (hi - lo) : 0.0);
    }
}

/* mean misfit of a stroke from its beginning, at the initial state that suits it best. @param chi2
 * out: over noise only */
static double misfit(trial *a, int k, double *chi2)
{
    int stroke = a->stroke[k];
    const fit__stroke *s = &a->p->stroke[stroke];
    double sd[MOST_CHANNELS];
    fit__follow how = {.sd = sd, .until = a->until[k], .most = INFINITY, .steps = STEPS};
    memset(a->x, 0, sizeof *a->x * (size_t)a->p->nu);
    (void)fit__initial_state(a->p, &a->bench, stroke, a->x);
    (void)stein_try_all(a->probe, a->bench.p, NULL);
    find_masses(a, a->bench.p);
    find_scales(s, how.until, sd);
    a->bench.force = a->gravity != NULL ? pull : NULL;
    a->bench.force_ctx = a;
    double m = fit__follow_start(a->p, &a->bench, stroke, &how, a->x);
    *chi2 = fit__misfit(a->p, &a->bench, stroke, a->x, how.until);
    a->bench.force = NULL;
    return m;
}

/* all strokes in one way; stops where one is no better than it was. @return 1: all are */
static int try_way(trial *a, way *w, const way *usual)
{
    double logs = 0.0;
    int better = 1;
    w->chi2 = 0.0;
    a->gravity = w->gravity;
    a->bench.faster = w->doubt == FIT__PACE ? w->factor - 1.0 : 0.0;
    for (int k = 0; k < a->nstroke && better; k++) {
        fit__stroke *s = &a->p->stroke[a->stroke[k]];
        size_t size = sizeof *s->y * (size_t)(s->nch * s->n);
        double scale = w->doubt == FIT__UNIT ? w->factor : 1.0, chi2;
        memcpy(a->kept, s->y, size);
        change(w, s);
        if (w->c >= 0) {
            s->noise[w->c] *= scale;
        }
        w->m[k] = fmax(misfit(a, k, &chi2), 1e-6);
        if (w->c >= 0) {
            s->noise[w->c] /= scale;
        }
        memcpy(s->y, a->kept, size);
        w->chi2 += chi2 / a->nstroke;
        logs += log(w->m[k]);
        better = usual == NULL || w->m[k] < usual->m[k] || w->m[k] < 1.0;
    }
    w->score = exp(logs / a->nstroke);
    a->gravity = NULL;
    a->bench.faster = 0.0;
    return better && isfinite(w->score);
}

/* ---- what is tried ---- */

static const stein_channel *channel_of(const trial *a, int c)
{
    const fit__stroke *s = &a->p->stroke[a->stroke[0]];
    return &lab_equations(a->p->model)->channels[s->channel[c]];
}

static int is_signed(const stein_channel *c)
{
    return stein_reads_place((int)c->read) || c->read == STEIN_READ_SPEED ||
           (c->read >= STEIN_READ_VX && c->read <= STEIN_READ_VZ);
}

/* +1: as drawn (STEIN_READ_ANGLE), -1: the other way */
static int sense(const stein_channel *c, const stein_body *joint)
{
    int turns = c->read == STEIN_READ_ANGLE ? 1 : joint->axis == 'y' ? -joint->sign : joint->sign;
    return c->sign * turns;
}

/* Slot of the channel that shows the angle of what carries the body of channel c, of the joint or
 * against the frame; -1. @param factor  out: times that one, added to c, what it is otherwise */
static int angle_below(const trial *a, int c, double *factor)
{
    const stein_model *m = lab_equations(a->p->model);
    const stein_channel *ch = channel_of(a, c);
    int absolute = ch->read == STEIN_READ_ANGLE;
    if (!absolute && ch->read != STEIN_READ_POSITION) {
        return -1;
    }
    const stein_body *b = &m->bodies[ch->index];
    const stein_body *on = b->parent >= 0 ? &m->bodies[b->parent] : NULL;
    if (on == NULL || b->type != 'R' || on->type != 'R' || on->axis != b->axis) {
        return -1;
    }
    for (int k = 0; k < a->p->stroke[a->stroke[0]].nch; k++) {
        const stein_channel *below = channel_of(a, k);
        int joint = below->read == STEIN_READ_POSITION && (!absolute || on->parent < 0);
        if (below->index == b->parent && (joint || below->read == STEIN_READ_ANGLE)) {
            *factor = (absolute ? 1 : -1) * sense(ch, b) * sense(below, on);
            return k;
        }
    }
    return -1;
}

/* @return number of ways to read channel c otherwise */
static int ways_of(const trial *a, int c, way *w)
{
    const stein_channel *ch = channel_of(a, c);
    double factor = 0.0;
    int n = 0, turns = strcmp(ch->unit, "rad") == 0, below = angle_below(a, c, &factor);
    double unit = turns || strcmp(ch->unit, "rad/s") == 0 ? 180.0 / pi : 1000.0;
    if (!is_signed(ch)) {
        return 0;
    }
    w[n++] = (way){.doubt = FIT__SENSE, .c = c, .other = -1, .factor = -1.0};
    for (int k = -1; k <= 2 && stein_reads_place((int)ch->read) && turns; k++) {
        w[n] = (way){.doubt = FIT__ZERO, .c = c, .other = -1, .factor = 1.0, .add = k * pi / 2.0};
        n += k != 0;
    }
    if (stein_reads_place((int)ch->read)) {
        w[n++] = (way){.doubt = FIT__ZERO, .c = c, .other = -1, .factor = 1.0, .about_mean = 1};
    }
    w[n++] = (way){.doubt = FIT__UNIT, .c = c, .other = -1, .factor = 1.0 / unit};
    w[n++] = (way){.doubt = FIT__UNIT, .c = c, .other = -1, .factor = unit};
    if (below >= 0) {
        w[n++] = (way){.doubt = FIT__ABSOLUTE, .c = c, .other = below, .factor = factor};
    }
    for (int k = 0; k < c; k++) {
        if (strcmp(channel_of(a, k)->unit, ch->unit) == 0 && is_signed(channel_of(a, k))) {
            w[n++] = (way){.doubt = FIT__EXCHANGE, .c = c, .other = k, .factor = 1.0};
        }
    }
    return n;
}

/* ---- in words ---- */

static char *sentence(const trial *a, const way *w, double times)
{
    const stein_model *m = lab_equations(a->p->model);
    const stein_channel *c = channel_of(a, w->c >= 0 ? w->c : 0);
    const char *other = w->other >= 0 ? channel_of(a, w->other)->name : "";
    switch (w->doubt) {
    case FIT__SENSE:
        if (c->read == STEIN_READ_POSITION || c->read == STEIN_READ_SPEED) {
            const stein_body *b = &m->bodies[c->index];
            return lab__text("%s runs against the sense of joint %s; joint: %c %s%c would fit %.0f "
                             "times better",
                             c->name, b->name, b->type, b->sign > 0 ? "-" : "", b->axis, times);
        }
        return lab__text("%s has the wrong sign; with the other one it would fit %.0f times better",
                         c->name, times);
    case FIT__ZERO:
        if (w->about_mean) {
            return lab__text("%s swings about %.4g %s, not about the rest of the model; with its "
                             "mean taken off it would fit %.0f times better",
                             c->name, mean_of(&a->p->stroke[a->stroke[0]], w->c), c->unit, times);
        }
        return lab__text("%s counts from elsewhere; with %.0f deg added it would fit %.0f times "
                         "better",
                         c->name, w->add * 180.0 / pi, times);
    case FIT__UNIT:
        return lab__text("%s is in another unit; %s by %.4g it would fit %.0f times better",
                         c->name, w->factor < 1.0 ? "divided" : "multiplied",
                         w->factor < 1.0 ? 1.0 / w->factor : w->factor, times);
    case FIT__EXCHANGE:
        return lab__text("%s and %s are exchanged; the other way round they would fit %.0f times "
                         "better",
                         other, c->name, times);
    case FIT__ABSOLUTE:
        return lab__text("%s is the angle of its %s; %s taken %s would fit %.0f times better",
                         c->name,
                         c->read == STEIN_READ_ANGLE ? "joint, not of its body against the frame"
                                                     : "body against the frame, not of its joint",
                         other, w->factor < 0.0 ? "off" : "in", times);
    case FIT__GRAVITY:
        return lab__text("gravity: [%.3g, %.3g, %.3g] m/s^2 would fit %.0f times better",
                         earth * w->gravity[0], earth * w->gravity[1], earth * w->gravity[2],
                         times);
    case FIT__PACE:
        return lab__text(
            "the records move %.2g times as %s as the model; with their time %s by "
            "that they would fit %.0f times better: a film in slow motion, a clock, or "
            "a length, spring or inertia that is far off",
            w->factor < 1.0 ? 1.0 / w->factor : w->factor, w->factor < 1.0 ? "slowly" : "fast",
            w->factor < 1.0 ? "divided" : "multiplied", times);
    default:
        return lab__text("the model leaves the records by %.0f %% of the motion within their first "
                         "%.2g s; no sign, zero, unit, pace or direction of gravity explains it",
                         100.0 * share * sqrt(w->score), a->until[0]);
    }
}

/* ---- the whole ---- */

static int compare(const void *a, const void *b)
{
    const fit__finding *x = a, *y = b;
    return (x->after > y->after) - (x->after < y->after);
}

static stein_status add(trial *a, fit__finding *list, int *n, const way *usual, const way *w,
                        stein_err *err)
{
    const fit__stroke *s = &a->p->stroke[a->stroke[0]];
    list[*n] = (fit__finding){.doubt = w->doubt,
                              .channel = w->c >= 0 ? s->channel[w->c] : -1,
                              .other = w->other >= 0 ? s->channel[w->other] : -1,
                              .before = usual->chi2,
                              .after = w->chi2,
                              .pace = w->doubt == FIT__PACE ? w->factor : 1.0,
                              .text = sentence(a, w, usual->score / w->score)};
    return list[(*n)++].text != NULL ? STEIN_OK : lab__no_memory(err);
}

/* The pace at which the model follows the records best: a grid, then finer about its best point.
 * Forces that were measured have a time of their own, and at another pace another size. @return 1:
 * it is many times better */
static int find_pace(trial *a, const way *usual, way *best)
{
    enum { COARSE = 18, FINE = 8 };
    static const double widest = 20.0, clear = 1.3;
    *best = *usual;
    for (int k = -COARSE; k <= COARSE && a->p->stroke[a->stroke[0]].nsignal == 0; k++) {
        way w = {
            .doubt = FIT__PACE, .c = -1, .other = -1, .factor = pow(widest, (double)k / COARSE)};
        *best = try_way(a, &w, NULL) && w.score < best->score ? w : *best;
    }
    double step = pow(widest, 0.5 / COARSE), middle = best->factor;
    for (int k = 0; k < FINE && best->doubt == FIT__PACE; k++, step = sqrt(step)) {
        for (int side = -1; side <= 1; side += 2) {
            way w = *best;
            w.factor = side < 0 ? middle / step : middle * step;
            *best = try_way(a, &w, NULL) && w.score < best->score ? w : *best;
        }
        middle = best->factor;
    }
    return best->doubt == FIT__PACE && best->score * much_better < usual->score &&
           fabs(log(best->factor)) > log(clear);
}

/* does a way fit, and much better than the usual one? */
static int explains(const way *w, const way *usual)
{
    return w->score * much_better < usual->score && w->score < hopeless;
}

/* all ways when the usual one does not fit */
static stein_status look(trial *a, fit__finding *list, int *n, stein_err *err)
{
    way usual = {.c = -1, .other = -1}, w[MOST_CHANNELS + 9], best = {.score = INFINITY};
    stein_status status = STEIN_OK;
    int nch = a->p->stroke[a->stroke[0]].nch;
    (void)try_way(a, &usual, NULL);
    if (usual.score < suspicious) {
        return STEIN_OK;
    }
    for (int c = 0; c < nch && status == STEIN_OK; c++) {
        int ways = ways_of(a, c, w);
        for (int k = 0; k < ways && status == STEIN_OK; k++) {
            int better = try_way(a, &w[k], &usual);
            best = better && w[k].about_mean && w[k].score < best.score ? w[k] : best;
            if (better && explains(&w[k], &usual)) {
                status = add(a, list, n, &usual, &w[k], err);
            }
        }
    }
    for (int k = 0; k < 6 && status == STEIN_OK; k++) {
        w[0] = (way){.doubt = FIT__GRAVITY, .c = -1, .other = -1, .gravity = axis[k]};
        if (try_way(a, &w[0], &usual) && explains(&w[0], &usual)) {
            status = add(a, list, n, &usual, &w[0], err);
        }
    }
    if (status == STEIN_OK && *n == 0 && usual.score > hopeless) {
        way paced;
        int fits = find_pace(a, &usual, &paced), moved = best.score * much_better < usual.score;
        const way *said = moved && best.score < paced.score ? &best : fits ? &paced : &usual;
        usual.doubt = FIT__NOTHING;
        status = add(a, list, n, &usual, said, err);
    }
    qsort(list, (size_t)*n, sizeof *list, compare);
    while (*n > 1 && list[*n - 1].after > much_better * list[0].after) { // helps, but is not it
        free(list[--*n].text);
    }
    return status;
}

/* strokes with initial states of their own and the channels of the first one, spread over all */
static void choose_strokes(trial *a)
{
    const fit__problem *p = a->p;
    int first = -1;
    for (int k = 0; k < MOST_STROKES; k++) {
        int from = (int)((long long)k * p->nstroke / MOST_STROKES);
        int end = (int)((long long)(k + 1) * p->nstroke / MOST_STROKES);
        for (int i = from; i < end; i++) {
            const fit__stroke *s = &p->stroke[i];
            const fit__stroke *other = first >= 0 ? &p->stroke[first] : s;
            if (s->window > 0.0 && s->nch <= MOST_CHANNELS && s->nch == other->nch &&
                memcmp(s->channel, other->channel, sizeof *s->channel * (size_t)s->nch) == 0) {
                first = first < 0 ? i : first;
                a->stroke[a->nstroke++] = i;
                break;
            }
        }
    }
    for (int k = 0; k < a->nstroke; k++) {
        const fit__stroke *s = &p->stroke[a->stroke[k]];
        a->until[k] = fmax(windows * s->window, swings * s->half);
    }
}

stein_status fit__setup(fit__problem *p, fit__finding **list, int *n, stein_err *err)
{
    trial a = {.p = p};
    stein_sim_def def = lab_def(p->model);
    size_t most = MOST_CHANNELS * (MOST_CHANNELS + 9) + 8, nq = (size_t)lab_equations(p->model)->nq;
    *n = 0;
    *list = NULL;
    choose_strokes(&a);
    if (a.nstroke == 0) {
        return STEIN_OK;
    }
    a.kept = malloc(sizeof *a.kept * (size_t)(p->rows + 1));
    a.x = calloc((size_t)p->nu + 1, sizeof *a.x);
    a.q = calloc(nq * (10 + nq) + 1, sizeof *a.q);
    if (a.q != NULL) {
        a.mass = a.q + nq;
        a.along = a.mass + nq;
        a.frc = a.along + 3 * nq;
        a.c = a.frc + 3 * nq;
        a.M = a.c + 2 * nq;
    }
    *list = calloc(most, sizeof **list);
    stein_status status = a.kept != NULL && a.x != NULL && a.q != NULL && *list != NULL
                              ? lab_sim(p->model, &def, &a.probe, err)
                              : lab__no_memory(err);
    status = status == STEIN_OK ? fit__bench_make(&a.bench, p, err) : status;
    double exact = p->tolerance;
    p->tolerance = coarse;
    status = status == STEIN_OK ? look(&a, *list, n, err) : status;
    p->tolerance = exact;
    status = status == STEIN_OK && a.bench.no_memory ? lab__no_memory(err) : status;
    fit__bench_free(&a.bench);
    stein_sim_destroy(a.probe);
    free(a.kept);
    free(a.x);
    free(a.q);
    if (status != STEIN_OK) {
        fit__setup_free(*list, *n);
        *list = NULL;
        *n = 0;
    }
    return status;
}

void fit__setup_free(fit__finding *list, int n)
{
    for (int i = 0; list != NULL && i < n; i++) {
        free(list[i].text);
    }
    free(list);
}
