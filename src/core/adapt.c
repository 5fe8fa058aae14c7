/* SPDX-License-Identifier: MIT
 * adapt.c - steps of controlled error, and what is seen between their ends.
 *
 * Dormand & Prince's own estimate controls the step,
 *
 *      h <- 0.9 h e^-0.17 e_last^0.04,    e = max over joints (|e_q|, h |e_qd|) / tol
 *
 * (Gustafsson's PI controller with the exponents of Hairer's DOPRI5.)
 *
 * Contact modes are constant within a trial step, so its estimate is as good across a switch as
 * elsewhere. A trial step that passes the control and contains an event is repeated up to the
 * first root. The dense output gives that root to order 6 (4 in implicit steps). The next step
 * begins after the switch. A trial step that does not pass is not asked for its events.
 *
 *      next --> trial of h --> judge --> too coarse: a shorter one
 *                  ^             |-----> no event: taken
 *                  '-- up to it <-'----> the event it was repeated up to: taken, switched
 *
 * Whoever makes the trials - this file, or a batch in lanes - is asked for one after the other.
 *
 * Whoever looks at the motion gets the states of the same dense output. Steps that end at every
 * look were more, and moved with the looks.
 */
#include <math.h>
#include <string.h>

#include "core.h"

enum { MAX_EVENTS_ON_THE_SPOT = 200 };
/* trials of a run: what a motion may ask for that is too stiff for explicit steps */
static const double fewest_trials = 2e4, trials_a_longest = 1e3;
static const double beside = 1e-3;                   /* just before and behind an event, in steps */
static const double rounding = 1e-12;                /* of an acceleration */
static const double log_little = -9.210340371976182; /* of 1e-4: errors count as no less */

/* the simulation at every look in [t, t1). @return is there any? */
static int look_inside(stein_sim *sim, double t1, stein_pace *pace)
{
    double t = sim->head->t, h = t1 - t;
    int looked = pace->look != NULL && pace->next < t1;
    while (pace->look != NULL && pace->next < t1) {
        double at = fmax(pace->next, t);
        stein__interpolate(sim, h, (at - t) / h, sim->q, sim->qd);
        sim->head->t = at;
        sim->fresh = STALE;
        pace->next = pace->look(pace->ctx, sim);
    }
    return looked;
}

/* The trial step to t1 becomes the state. Forces and gaps are those of where one looked inside
 * last, whether they were evaluated there or not; they are evaluated again when they are asked for,
 * while qdd is known. */
static void finish(stein_sim *sim, double t1, stein_pace *pace, int implicit)
{
    sim->counts.taken++;
    sim->counts.implicit += implicit;
    int looked = look_inside(sim, t1, pace), fresh = sim->fresh;
    stein__accept(sim, t1);
    // what follows the motion may have looked, too
    sim->fresh = fresh == FRESH && !looked ? sim->fresh : KNOWN;
}

static int is_crossed_at(stein_sim *sim, double h, double theta)
{
    sim->fresh = STALE;
    stein__guards_inside(sim, h, theta);
    return stein__any_crossed(sim);
}

/* Theta of the first event of a trial step that ends behind it. There the guards may hide another
 * one before it - a beak that has passed the corner does not tell that it had met it - so they are
 * asked again just before. A guard that has just switched is 0 up to rounding where the step
 * begins; what it is just behind counts. */
static double first_event(stein_sim *sim, double h)
{
    double begin = 0.0, theta = stein__first_root(sim, h, begin, 1.0);
    if (theta < beside) {
        if (is_crossed_at(sim, h, beside)) {
            return stein__first_root(sim, h, begin, beside);
        }
        begin = beside;
        (void)is_crossed_at(sim, h, 1.0);
        theta = stein__first_root(sim, h, begin, 1.0);
    }
    while (theta - beside > begin && is_crossed_at(sim, h, theta - beside)) {
        theta = stein__first_root(sim, h, begin, theta - beside);
    }
    return theta;
}

/* Theta of the first event of the trial step, 2 where there is none.
 * @param middle  asked as well: a contact may have come and gone */
static double event_of(stein_sim *sim, double h, int middle)
{
    if (stein__any_crossed(sim)) {
        return first_event(sim, h);
    }
    int grazed = middle && is_crossed_at(sim, h, 0.5);
    return grazed ? stein__first_root(sim, h, 0.0, 0.5) : 2.0;
}

static stein_status check_pace(const stein_sim *sim, double t_end, const stein_pace *pace,
                               stein_err *err)
{
    if (sim->def.integrator == STEIN_RK4) {
        return stein__fail(err, STEIN_EINVAL,
                           "no error estimate: it comes with a step of Dormand-Prince 5(4)");
    }
    stein_status status = stein__check_end(sim, t_end, err);
    if (status == STEIN_OK &&
        (!(pace->tolerance > 0.0) || !(pace->longest > 0.0) || !(pace->h > 0.0))) {
        return stein__fail(err, STEIN_EINVAL,
                           "stein_pace: tolerance %g, longest %g s and h %g s have to be positive",
                           pace->tolerance, pace->longest, pace->h);
    }
    return status;
}

/* Does a joint that follows a signal have another acceleration where a run begins than where the
 * last one ended? Up to rounding it has not, mostly: runs end where a record has its samples. */
static int jumps(stein_sim *sim)
{
    stein__drive_from(sim, sim->head->t, sim->q, sim->qd);
    for (int j = 0; j < sim->model->nq; j++) {
        int i = stein__driver_of(sim, j);
        double was = sim->qdd[j], given = i >= 0 ? sim->ustate[3 * i + 2] : was;
        if (!(fabs(given - was) <= rounding * (fabs(given) + fabs(was)))) {
            return 1;
        }
    }
    return 0;
}

stein_status stein__pace_begin(stein_sim *sim, double t_end, const stein_pace *pace,
                               stein__pacer *p, stein_err *err)
{
    stein_status status = check_pace(sim, t_end, pace, err);
    if (status == STEIN_OK && sim->motions && sim->fresh != STALE && jumps(sim)) {
        sim->fresh = STALE;
    }
    if (status == STEIN_OK && sim->fresh == STALE) {
        status = stein__refresh(sim, err);
    }
    stein__implicit_leave(sim);
    *p = (stein__pacer){.t_end = t_end, .growth = STEIN__MOST_GROWTH};
    if (status == STEIN_OK) {
        p->left_over = fewest_trials + trials_a_longest * (t_end - sim->head->t) / pace->longest;
    }
    return status;
}

stein_status stein__pace_next(stein_sim *sim, const stein_pace *pace, stein__pacer *p,
                              stein_err *err)
{
    p->h = 0.0;
    if (!(sim->head->t < p->t_end)) {
        return STEIN_OK;
    }
    if (--p->left_over < 0.0 && !p->explicit_only && !p->prolonged &&
        stein__begin_implicit(sim, pace->h)) {
        p->left_over = fewest_trials; // what has no end with explicit steps may have one so
        p->prolonged = 1;
    }
    if (p->left_over < 0.0) {
        stein_err why;
        stein__fail(&why, STEIN_ECHATTER,
                    "the motion is too stiff: steps of %g s at t = %g s would never end%s%s",
                    pace->h, sim->head->t,
                    sim->counts.refused != NULL ? "; implicit ones cannot be taken: " : "",
                    sim->counts.refused != NULL ? sim->counts.refused : "");
        return stein__explain_failure(sim, pace->h, STEIN_ECHATTER, why.msg, err);
    }
    sim->trials++;
    double left = p->t_end - sim->head->t;
    p->t = sim->head->t;
    p->wanted = fmin(pace->h, pace->longest);
    int last = p->wanted >= left * (1.0 - 1e-9);
    p->whole = last ? left : fmin(p->wanted, 0.5 * left); // no crumb before t_end
    stein__singular_look(sim, p->whole);
    p->h = p->whole;
    p->to = last ? p->t_end : p->t + p->h;
    p->middle = p->h > 0.5 * pace->longest;
    return STEIN_OK;
}

/* May the kind of step change behind this one? It says something where the error control alone has
 * made it so short. */
static int is_limited(const stein_sim *sim, const stein_pace *pace, const stein__pacer *p)
{
    return sim->def.integrator == STEIN_CONTROLLED && !p->explicit_only && p->whole == p->wanted &&
           p->wanted < pace->longest;
}

stein_status stein__pace_try(stein_sim *sim, const stein_pace *pace, stein__pacer *p,
                             stein_err *err)
{
    static const stein__grade failed = {(double)INFINITY, 0.0, STEIN__LEAST_GROWTH, 0.0};
    p->implicit = !p->explicit_only && stein__is_implicit(sim);
    stein_status status = stein__try(sim, p->h, p->implicit, err);
    p->implicit = p->implicit && sim->implicit->inside;
    sim->fresh = status == STEIN_OK ? FRESH : STALE; // about the end of the trial step
    if (!p->repeated) {
        p->grade =
            status == STEIN_OK ? stein__graded(sim, p->h, pace->tolerance, p->log_last) : failed;
        if (is_limited(sim, pace, p) && !p->implicit && !(p->grade.e > 1.0)) {
            p->grade.h_rho = stein__explicit_stiffness(sim, p->h);
        }
    }
    return status;
}

/* the trial step that passed is over: the next one */
static void plan_next(stein_sim *sim, stein_pace *pace, stein__pacer *p)
{
    const stein__grade *g = &p->grade;
    if (p->implicit && p->whole == p->wanted) {
        stein__note_implicit(sim, p->whole);
    } else if (is_limited(sim, pace, p)) {
        stein__note_explicit(sim, p->whole, g->h_rho);
    }
    double next = p->whole * fmin(p->growth, g->factor);
    pace->h =
        p->whole < p->wanted && g->e < 0.5 ? fmax(next, pace->h) : next; // a rest tells little
    stein__implicit_leave(sim);
    p->log_last = g->log_e > log_little ? g->log_e : log_little;
    p->growth = STEIN__MOST_GROWTH;
    p->spot = sim->head->t > p->t ? 0 : p->spot + 1;
    p->h = 0.0;
}

static stein_status switch_over(stein_sim *sim, stein_err *err)
{
    stein__flip_crossed(sim);
    return stein__refresh(sim, err);
}

/* a trial step that passed is taken, or repeated up to its first event */
static stein_status take(stein_sim *sim, stein_pace *pace, stein__pacer *p, stein_err *err)
{
    double theta = event_of(sim, p->h, p->middle);
    if (theta > 1.0) {
        finish(sim, p->to, pace, p->implicit);
        return STEIN_OK;
    }
    p->to = p->t + theta * p->h;
    p->h = p->to - p->t;
    p->repeated = p->h > 0.0;
    return p->repeated ? STEIN_OK : switch_over(sim, err);
}

/* the event it was repeated up to */
static stein_status arrive(stein_sim *sim, stein_pace *pace, stein__pacer *p, stein_err *err)
{
    p->repeated = 0;
    finish(sim, p->to, pace, p->implicit);
    return switch_over(sim, err);
}

stein_status stein__pace_judge(stein_sim *sim, stein_pace *pace, stein__pacer *p,
                               stein_status status, stein_err *err)
{
    const stein__grade *g = &p->grade;
    if (!p->repeated && g->e > 1.0 && p->h >= STEIN__SHORTEST) {
        // a signal that jumps has no step that is short enough: its speed times that is left
        pace->h = p->h * fmin(0.9, g->factor);
        p->growth = 1.0; // not back at once to what failed
        p->h = 0.0;
        return STEIN_OK;
    }
    if (status == STEIN_OK && !isfinite(g->e)) {
        status = stein__fail(err, STEIN_ENONFINITE, "no step is short enough at t = %g s", p->t);
    }
    if (status == STEIN_OK) {
        status = p->repeated ? arrive(sim, pace, p, err) : take(sim, pace, p, err);
    }
    if (status == STEIN_OK && !p->repeated && stein__rechart(sim)) {
        status = stein__refresh(sim, err);
    }
    if (status != STEIN_OK || p->repeated) {
        return status;
    }
    plan_next(sim, pace, p);
    return p->spot <= MAX_EVENTS_ON_THE_SPOT
               ? STEIN_OK
               : stein__fail(err, STEIN_ECHATTER, "more than %d contact events at t = %g s",
                             (int)MAX_EVENTS_ON_THE_SPOT, p->t);
}

void stein__pace_end(stein_sim *sim, stein_pace *pace, double t_end)
{
    stein__end_run(sim, t_end);
    while (pace->look != NULL && pace->next <= t_end) {
        pace->next = pace->look(pace->ctx, sim);
    }
}

long long stein_trials(const stein_sim *sim)
{
    return sim->trials;
}

stein_status stein_set_tolerance(stein_sim *sim, double tolerance, stein_err *err)
{
    if (!(tolerance > 0.0) || !isfinite(tolerance)) {
        return stein__fail(err, STEIN_EINVAL, "a tolerance of %g: expected a positive number",
                           tolerance);
    }
    sim->tolerance = tolerance;
    return STEIN_OK;
}

stein_status stein__run_controlled(stein_sim *sim, double t_end, stein_pace *pace, stein_err *err)
{
    stein__pacer p;
    stein_status status = stein__pace_begin(sim, t_end, pace, &p, err);
    status = status == STEIN_OK ? stein__pace_next(sim, pace, &p, err) : status;
    while (status == STEIN_OK && p.h > 0.0) {
        status = stein__pace_try(sim, pace, &p, err);
        status = stein__pace_judge(sim, pace, &p, status, err);
        if (status == STEIN_OK && !(p.h > 0.0)) {
            status = stein__pace_next(sim, pace, &p, err);
        }
    }
    if (status != STEIN_OK) {
        sim->fresh = STALE;
    }
    return status;
}

stein_status stein_run_adaptive(stein_sim *sim, double t_end, stein_pace *pace, stein_err *err)
{
    stein_status status = stein__run_controlled(sim, t_end, pace, err);
    if (status == STEIN_OK) {
        stein__pace_end(sim, pace, t_end);
    }
    return status;
}
