/* SPDX-License-Identifier: GPL-3.0-or-later
 * sensitivity.c - how the residuals of every stroke change with every unknown.
 *
 * Differences of whole strokes:   dr/dx = (r(x + d) - r(x - d)) / 2d.
 *
 * Each of them locates its own events. So a contact that begins earlier, a beak that escapes later
 * and the jump of the force are in the difference as they are in the motion. Differentiating the
 * equations (forward variational equations) needs the derivative of every event's time and a jump
 * of the sensitivities there, written by hand for each kind of contact. Published packages that
 * lack it are wrong by up to 7 % next to events. These equations also need generated derivatives of
 * all force laws. They would save a factor of two at most, since a stroke with controlled steps
 * costs less than the extra equations of one parameter with fixed ones. The price of differences is
 * the choice of d. It changes the predictions of a stroke by a tenth of the noise (RMS). At that
 * change their curvature does not matter yet and, with steps of 1e-14, the rounding of the
 * integration is far smaller. The derivatives that intervals are made of are then right to 1e-6 in
 * a stroke of the piano action with its 25 events (steps of 1e-13 leave 2e-5); a test holds them
 * against differences of order six.
 *
 * While a search is on its way, one-sided differences with changes of 0.3 noises and coarser
 * integration serve: they cost a quarter, and their error is of the order of d.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

/* RMS change of a stroke [noise]; step in prior sd: differences to one side, to both */
static const double wanted_change[2] = {0.3, 0.1}, most_step[2] = {0.2, 0.05}, least_step = 1e-6;

static const double fine = 1e-14; /* of an integration step [rad or m] */

size_t fit__column(const fit__problem *p, int stroke, int k)
{
    size_t at = 0;
    for (int s = 0; s < stroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        at += (size_t)(t->nch * t->n) * (size_t)(p->np + t->own);
    }
    const fit__stroke *t = &p->stroke[stroke];
    return at + (size_t)(t->nch * t->n) * (size_t)k;
}

size_t fit__columns(const fit__problem *p)
{
    const fit__stroke *last = &p->stroke[p->nstroke - 1];
    return fit__column(p, p->nstroke - 1, p->np + last->own);
}

/* one column of one stroke */
typedef struct task {
    int stroke, k, no_up, no_down; /* what cannot be simulated */
} task;

typedef struct job {
    const fit__problem *p;
    const double *x, *r;
    double *J;
    task *task;
    double sign; /* of the present side */
} job;

/* unknown behind column k of a stroke */
static int unknown_of(const fit__problem *p, int stroke, int k)
{
    return k < p->np ? k : p->stroke[stroke].first + k - p->np;
}

static double step_of(const job *j, const task *t)
{
    return j->p->step[unknown_of(j->p, t->stroke, t->k)];
}

/* a step to one side: up into the column, down beside it */
static stein_status ask(void *ctx, fit__bench *b, int index)
{
    const job *j = ctx;
    const task *t = &j->task[index];
    memcpy(b->x, j->x, sizeof *b->x * (size_t)j->p->nu);
    b->x[unknown_of(j->p, t->stroke, t->k)] += j->sign * step_of(j, t);
    double *to = j->sign > 0.0 ? j->J + fit__column(j->p, t->stroke, t->k) : b->y;
    return fit__begin(j->p, b, t->stroke, b->x, to, NULL);
}

/* residuals to differences; where one side cannot be simulated, the other one has to do */
static void differ(const job *j, const task *t, const double *down)
{
    const fit__stroke *s = &j->p->stroke[t->stroke];
    double *column = j->J + fit__column(j->p, t->stroke, t->k);
    const double *here = j->r + fit__offset(j->p, t->stroke);
    const double *lo = t->no_down ? here : down, *hi = t->no_up ? here : column;
    double width = step_of(j, t) * (2.0 - t->no_up - t->no_down);
    for (int i = 0; i < s->nch * s->n; i++) {
        column[i] = width > 0.0 ? (hi[i] - lo[i]) / width : 0.0;
    }
}

static void take_up(void *ctx, fit__bench *b, int index, int failed)
{
    const job *j = ctx;
    task *t = &j->task[index];
    (void)b;
    t->no_up = failed;
    t->no_down = !j->p->central && !failed;
    if (!failed) {
        fit__weigh(&j->p->stroke[t->stroke], j->J + fit__column(j->p, t->stroke, t->k));
    }
    if (t->no_down) {
        differ(j, t, NULL);
    }
}

static void take_down(void *ctx, fit__bench *b, int index, int failed)
{
    const job *j = ctx;
    task *t = &j->task[index];
    t->no_down = failed;
    if (!failed) {
        fit__weigh(&j->p->stroke[t->stroke], b->y);
    }
    differ(j, t, b->y);
}

/* does an unknown of all records change this one? A cause need not act in all of them. */
static int changes(const fit__problem *p, int stroke, int k)
{
    int cause = k >= p->first_accepted ? (k - p->first_accepted) / FIT__NUMBERS : p->naccepted;
    return k >= p->np || cause >= p->naccepted ||
           lab_candidate_acts(p->accepted[cause], p->stroke[stroke].data->number);
}

/* columns that are known: -1/noise for the channel of an offset, 0 for what is idle; a sample that
 * does not count, behind the horizon, say, has no residual */
static void known_column(const fit__problem *p, int stroke, int k, const double *r, double *J)
{
    const fit__stroke *s = &p->stroke[stroke];
    const fit__unknown *u = &p->unknown[unknown_of(p, stroke, k)];
    double *column = J + fit__column(p, stroke, k);
    r += fit__offset(p, stroke);
    if (u->idle || !changes(p, stroke, k)) {
        memset(column, 0, sizeof *column * (size_t)(s->nch * s->n));
        return;
    }
    for (int i = 0; i < s->nch * s->n; i++) {
        int on = i / s->n == u->index && r[i] != 0.0;
        column[i] = on ? -fit__weight(s, i) * u->sd / s->noise[u->index] : 0.0;
    }
}

static int is_simulated(const fit__problem *p, int stroke, int k)
{
    const fit__unknown *u = &p->unknown[unknown_of(p, stroke, k)];
    return !u->idle && changes(p, stroke, k) &&
           (u->kind != FIT__OFFSET || p->gain > 0.0); // the ladder's pull answers to offsets
}

/* all steps up, then those down that are asked for, or needed */
static stein_status both_sides(job *j, int n, stein_err *err)
{
    j->sign = 1.0;
    stein_status status = fit__many(j->p, n, ask, take_up, j, err);
    int down = 0;
    for (int i = 0; i < n; i++) {
        if (!j->task[i].no_down) {
            j->task[down++] = j->task[i];
        }
    }
    j->sign = -1.0;
    status = status == STEIN_OK ? fit__many(j->p, down, ask, take_down, j, err) : status;
    for (int i = 0; status == STEIN_OK && i < down; i++) {
        if (j->task[i].no_up && j->task[i].no_down) {
            status = lab__fail(err, STEIN_ENONFINITE,
                               "%s cannot be simulated for values next to the present ones",
                               j->p->stroke[j->task[i].stroke].data->file);
        }
    }
    return status;
}

stein_status fit__sensitivities(const fit__problem *p, const double *x, const double *r, double *J,
                                stein_err *err)
{
    return fit__more_sensitivities(p, x, r, NULL, J, err);
}

stein_status fit__more_sensitivities(const fit__problem *p, const double *x, const double *r,
                                     const unsigned char *known, double *J, stein_err *err)
{
    int n = 0;
    size_t most = (size_t)p->nstroke * (size_t)p->np + (size_t)(p->nu - p->np);
    task *list = malloc(sizeof *list * (most + 1));
    if (list == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < p->nstroke; s++) {
        for (int k = 0; k < p->np + p->stroke[s].own; k++) {
            if (is_simulated(p, s, k)) {
                if (known == NULL || !known[unknown_of(p, s, k)]) {
                    list[n++] = (task){.stroke = s, .k = k};
                }
            } else {
                known_column(p, s, k, r, J);
            }
        }
    }
    job j = {.p = p, .x = x, .r = r, .J = J, .task = list};
    stein_status status = both_sides(&j, n, err);
    free(list);
    return status;
}

/* largest RMS change of a stroke per unit of x */
static double change(const fit__problem *p, const double *J, int u)
{
    double most = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        int k = u < p->np ? u : u - t->first + p->np;
        if (k < 0 || (u >= p->np && (u < t->first || u >= t->first + t->own))) {
            continue;
        }
        const double *column = J + fit__column(p, s, k);
        double sum = 0.0;
        for (int i = 0; i < t->nch * t->n; i++) {
            sum += column[i] * column[i];
        }
        most = fmax(most, sqrt(sum / fmax(1.0, t->samples)));
    }
    return most;
}

void fit__choose_steps(fit__problem *p, const double *J)
{
    for (int u = 0; u < p->nu; u++) {
        if (p->unknown[u].idle && u < p->first_accepted) {
            continue; // a parameter that is held says nothing of its step
        }
        double slope = change(p, J, u), step = p->step[u];
        double most = p->unknown[u].prior ? most_step[p->central] : 1e3;
        double best = slope > 0.0 ? wanted_change[p->central] / slope : most;
        // a difference that was too coarse says little: come nearer by a factor of 30 at most
        best = fmin(fmax(best, step / 30.0), step * 30.0);
        p->step[u] = fmin(fmax(best, least_step), most);
    }
}

stein_status fit__fine_sensitivities(fit__problem *p, const double *x, const double *r, double *J,
                                     double *error, stein_err *err)
{
    double coarse = p->tolerance, worst = 0.0;
    double *half = malloc(sizeof *half * (fit__columns(p) + 1));
    if (half == NULL) {
        return lab__no_memory(err);
    }
    p->central = 1;
    p->tolerance = fine;
    stein_status status = fit__sensitivities(p, x, r, J, err);
    for (int u = 0; u < p->nu; u++) {
        p->step[u] *= 0.5;
    }
    status = status == STEIN_OK ? fit__sensitivities(p, x, r, half, err) : status;
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int k = 0; k < p->np + t->own; k++) {
            double *a = J + fit__column(p, s, k), *b = half + fit__column(p, s, k);
            double sum = 0.0, off = 0.0;
            for (int i = 0; i < t->nch * t->n; i++) {
                sum += b[i] * b[i];
                off += (b[i] - a[i]) * (b[i] - a[i]) / 9.0; // the error of b, if it goes with d^2
                a[i] = (4.0 * b[i] - a[i]) / 3.0;
            }
            worst = fmax(worst, sqrt(off / (sum + 1e-4 * t->samples)));
        }
    }
    p->tolerance = coarse;
    *error = worst;
    free(half);
    return status;
}
