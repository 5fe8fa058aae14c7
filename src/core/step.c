/* SPDX-License-Identifier: MIT
 * step.c - fixed-step Runge-Kutta with located events.
 *
 * The derivative at the end of a step is evaluated anyway: it is the first stage of the next
 * step, and gives the guards their end values at no cost. With it q is known to order 6 inside
 * the step (quintic Hermite from q, qd, qdd at both ends). That is one dense output for both
 * methods (implicit.c has its own).
 *
 * A step that ends with a guard on the other side of its mode is rejected and repeated up to the
 * first root of that guard. There the mode flips, the derivative is evaluated with the new mode
 * only, and the rest of the step follows.
 * So no Runge-Kutta step ever spans a switch of the force laws, and event times are
 * as accurate as the method. Stepping over a switch would cost the order and, at escapement where
 * the force jumps, any accuracy at all.
 *
 * The work of a step is bounded. After LOCATED events, or where a contact ends where it has just
 * begun, what is left of the step is taken in one piece (step_remainder.c). So is a step that is
 * too long for a contact. Friction that sticks needs every one of its events, 200 at most.
 */
#include <math.h>
#include <string.h>

#include "core.h"

static const double of_balls = 0.1;       /* of the tolerance: errors of each turn add up */
static const double just_behind = 1e-3;   /* the begin of a step, in steps */
static const double at_once = 1e-12;      /* events that far apart are one, in steps */
static const double same_place = 0.5e-13; /* half a bracket that is a root, in steps */
static const double last_change = 1e-9; /* by interpolation, in steps: the error is of its square */
static const double rounded = 1e-10;    /* of its change in a step: a slow guard, rounding errors */
static const double sure = 1e-7; /* a root that far behind another one, in steps, is not it */
enum { LOCATED = 2, LOCATED_STICKING = 200, MAX_ROOT_ITERATIONS = 80 };

void stein__guards_inside(stein_sim *sim, double h, double theta)
{
    if (sim->model->nstick == 0) {
        stein__interpolate(sim, h, theta, sim->xq, NULL);
        stein__guards(sim, sim->xq, sim->guard);
        return;
    }
    double t = sim->head->t + theta * h;
    stein__interpolate(sim, h, theta, sim->xq, sim->xqd);
    (void)stein__evaluate(sim, t, sim->xq, sim->xqd, sim->hold.qdd, NULL);
}

/* positions at theta of the trial step, at rest */
static void pose_inside(stein_sim *sim, double h, double theta)
{
    stein__interpolate(sim, h, theta, sim->xq, NULL);
    stein__pose_at(sim, sim->xq);
}

double stein__guard_at(stein_sim *sim, double h, double theta, int i)
{
    if (i >= sim->nguard) {
        stein__guards_inside(sim, h, theta);
        return sim->guard[i];
    }
    pose_inside(sim, h, theta);
    return stein__guard(sim, i);
}

/* is guard i with the value g on the other side of its mode? */
static int is_beyond(const stein_sim *sim, int i, double g)
{
    return i < sim->nguard ? (g > 0.0) != sim->mode[i] : g < 0.0;
}

static int is_crossed(const stein_sim *sim, int i)
{
    return is_beyond(sim, i, sim->guard[i]);
}

/* a guard at a place of the trial step */
typedef struct sample {
    double theta, g;
} sample;

/* Where between a and b, as a share of the way from a, the root is by inverse quadratic
 * interpolation with c; 0.5 where that is no good (Chandrupatla 1997) */
static double share_of_way(sample a, sample b, sample c)
{
    double part = (a.theta - b.theta) / (c.theta - b.theta), fall = (a.g - b.g) / (c.g - b.g);
    if (!(fall * fall < part && (1.0 - fall) * (1.0 - fall) < 1.0 - part)) {
        return 0.5;
    }
    double share = a.g / (b.g - a.g) * c.g / (b.g - c.g) + (c.theta - a.theta) /
                                                               (b.theta - a.theta) * a.g /
                                                               (c.g - a.g) * b.g / (c.g - b.g);
    return share > 0.0 && share < 1.0 ? share : 0.5;
}

/* is that on the side of the begin? What sticks without a share of its own has 0 */
static int is_before(const stein_sim *sim, int i, double g)
{
    return i < sim->nguard ? g > 0.0 : !(g < 0.0);
}

/* Root of guard i of the trial step between a and b. The search ends where the next interpolation
 * moves so little that its error is below rounding, and where the guard no longer falls: it then
 * consists of rounding errors of positions, in a slow contact over many such places. */
static double root(stein_sim *sim, double h, int i, sample a, sample b)
{
    if (i >= sim->nguard && !(a.g > 0.0)) { // a place that has just let go is at rest
        a.theta += just_behind * (b.theta - a.theta);
        a.g = stein__guard_at(sim, h, a.theta, i);
    }
    if (is_before(sim, i, a.g) == is_before(sim, i, b.g)) {
        return a.theta; // on the wrong side from the start, by rounding: switch at once
    }
    double small = rounded * (fabs(a.g) + fabs(b.g)), share = a.g / (a.g - b.g);
    sample least = {a.theta, INFINITY};
    int sticks = i >= sim->nguard; // 0 for a while is no root
    int stuck = 0;                 // looks in a row that brought it no nearer to 0
    for (int n = 0; n < MAX_ROOT_ITERATIONS; n++) {
        double theta = a.theta + share * (b.theta - a.theta);
        sample x = {theta, stein__guard_at(sim, h, theta, i)};
        stuck = !sticks && fabs(least.g) < small && fabs(x.g) > 0.5 * fabs(least.g) ? stuck + 1 : 0;
        least = fabs(x.g) < fabs(least.g) ? x : least;
        if ((x.g == 0.0 && !sticks) || stuck > 1) {
            return least.theta;
        }
        int beyond = is_before(sim, i, x.g) != is_before(sim, i, a.g);
        sample c = beyond ? b : a;
        b = beyond ? a : b;
        a = x;
        share = share_of_way(a, b, c);
        double change = share * (b.theta - a.theta);
        if (fabs(change) < (share == 0.5 ? same_place : last_change)) {
            return a.theta + change;
        }
    }
    return sticks ? a.theta : least.theta;
}

static void emit(stein_sim *sim, stein_event_kind kind, int index, int phase)
{
    if (sim->on_event != NULL) {
        stein_event event = {kind, index, phase, sim->head->t};
        sim->on_event(sim->event_ctx, sim, &event);
    }
}

static int spots_on(const stein_sim *sim, int contact)
{
    const stein_contact *c = &sim->model->contacts[contact];
    int n = 0;
    for (int i = 0; i < c->nspot; i++) {
        n += sim->mode[c->first_spot + i];
    }
    return n;
}

/* flip one spot and tell when its contact begins or ends as a whole */
static void flip_spot(stein_sim *sim, int i)
{
    int contact = sim->model->spots[i].contact;
    int before = spots_on(sim, contact);
    sim->mode[i] = !sim->mode[i];
    sim->fresh = STALE;
    int after = spots_on(sim, contact);
    if (before == 0 && after > 0) {
        emit(sim, STEIN_EVENT_CONTACT_BEGIN, contact, 0);
        if (contact == sim->model->stroke.string) {
            emit(sim, STEIN_EVENT_IMPACT, contact, 0);
        }
    } else if (before > 0 && after == 0) {
        emit(sim, STEIN_EVENT_CONTACT_END, contact, 0);
    }
}

/* flip the guards of one notch; a change of region ends all its contacts */
static void flip_notch(stein_sim *sim, int notch, const unsigned char *crossed)
{
    unsigned char *mode = sim->mode + sim->model->nspot + NOTCH_GUARDS * notch;
    int phase = sim->phase[notch];
    int engaged = sim->engaged[notch];
    int region = crossed[NOTCH_REGION];
    sim->fresh = STALE;
    if (region) {
        // at the corner all depths of the new region are 0 up to rounding: they begin, if they do,
        // in the next sub-step
        mode[NOTCH_REGION] = !mode[NOTCH_REGION];
        memset(mode, 0, NOTCH_REGION);
    } else {
        for (int k = 0; k < NOTCH_REGION; k++) {
            mode[k] = (unsigned char)(mode[k] ^ crossed[k]);
        }
    }
    unsigned char now = stein__notch_phase_after(mode, phase);
    sim->phase[notch] = now;
    sim->engaged[notch] = !mode[NOTCH_REGION] && (now > 0 || (engaged && !region));
    if (region && !mode[NOTCH_REGION]) {
        emit(sim, STEIN_EVENT_CAUGHT, notch, now);
    } else if (region && engaged) {
        emit(sim, STEIN_EVENT_ESCAPEMENT, notch, now);
    }
    if (now != phase) {
        emit(sim, STEIN_EVENT_PHASE, notch, now);
    }
}

void stein__mark_crossed(stein_sim *sim)
{
    for (int i = 0; i < sim->nswitch; i++) {
        sim->crossed[i] = (unsigned char)is_crossed(sim, i);
    }
}

/* the guards in crossed[] at theta of the trial step, and some others, into value [nswitch] */
static void look_at_crossed(stein_sim *sim, double h, double theta, double *value)
{
    int nspot = sim->model->nspot, sticking = 0;
    pose_inside(sim, h, theta);
    for (int i = 0; i < nspot; i++) {
        value[i] = sim->crossed[i] ? stein__spot_guard(sim, i) : 0.0;
    }
    for (int i = 0; i < sim->model->nnotch; i++) {
        double overlap;
        stein__notch_guards(sim, i, value + nspot + NOTCH_GUARDS * i, &overlap);
    }
    for (int i = sim->nguard; i < sim->nswitch; i++) {
        sticking |= sim->crossed[i];
    }
    if (sticking) {
        stein__guards_inside(sim, h, theta);
        copy(value + sim->nguard, sim->guard + sim->nguard, sim->model->nstick);
    }
}

/* the crossed guard that is 0 first if all are straight between `from` and `to` [nswitch]; -1:
 * there is none */
static int likely_first(const stein_sim *sim, const double *from, const double *to)
{
    int first = -1;
    double least = INFINITY;
    for (int i = 0; i < sim->nswitch; i++) {
        if (sim->crossed[i]) {
            int straight = is_before(sim, i, from[i]) != is_before(sim, i, to[i]);
            double theta = straight ? from[i] / (from[i] - to[i]) : 0.0;
            first = theta < least ? i : first;
            least = fmin(theta, least);
        }
    }
    return first;
}

/* Is guard i that of guard k, or the opposite of it, at the root of k, where they are `there`? The
 * edges of a notch are one corner. */
static int is_twin(const stein_sim *sim, int i, int k, const double *there)
{
    return i < sim->nguard && k < sim->nguard && fabs(there[i]) == fabs(there[k]);
}

/* Of the guards before i, without k, one whose known root is a root of i as well; -1: there is none
 */
static int twin_before(stein_sim *sim, double h, int i, int k)
{
    for (int j = 0; j < i && i < sim->nguard; j++) {
        if (sim->crossed[j] && j != k && sim->root[j] < 2.0) {
            pose_inside(sim, h, sim->root[j]);
            if (fabs(stein__guard(sim, i)) == fabs(stein__guard(sim, j))) {
                return j;
            }
        }
    }
    return -1;
}

/* The root of guard k is known: those of the other guards in crossed[], 2 where it is behind that
 * one. What is on its side just behind the root of k is not first; of the rest that place is the
 * end of the bracket. */
static void find_others(stein_sim *sim, double h, double begin, double end, int k)
{
    double *theta = sim->root, *behind = sim->behind, beside = fmin(theta[k] + sure, end);
    look_at_crossed(sim, h, theta[k], behind);
    for (int i = 0; i < sim->nswitch; i++) {
        theta[i] = sim->crossed[i] && is_twin(sim, i, k, behind) ? theta[k] : 2.0;
    }
    look_at_crossed(sim, h, beside, behind);
    for (int i = 0; i < sim->nswitch; i++) {
        if (sim->crossed[i] && i != k && theta[i] > 1.0 && is_beyond(sim, i, behind[i])) {
            sample from = {begin, sim->from[i]}, to = {beside, behind[i]};
            int twin = twin_before(sim, h, i, k);
            theta[i] = twin >= 0 ? theta[twin] : root(sim, h, i, from, to);
        }
    }
}

/* The root that is probably the first one is located first. */
double stein__first_root(stein_sim *sim, double h, double begin, double end)
{
    int n = sim->nswitch;
    double *theta = sim->root, at_k, first = 2.0;
    stein__mark_crossed(sim);
    copy(sim->to, sim->guard, n);
    look_at_crossed(sim, h, begin, sim->from);
    int k = likely_first(sim, sim->from, sim->to), others = 0;
    if (k < 0) {
        return first;
    }
    theta[k] = at_k = root(sim, h, k, (sample){begin, sim->from[k]}, (sample){end, sim->to[k]});
    for (int i = 0; i < n; i++) {
        others |= sim->crossed[i] && i != k;
    }
    if (others) {
        find_others(sim, h, begin, end, k);
        theta[k] = at_k;
    }
    for (int i = 0; i < n; i++) {
        first = sim->crossed[i] ? fmin(first, theta[i]) : first;
    }
    for (int i = 0; i < n; i++) {
        sim->crossed[i] = sim->crossed[i] && theta[i] - first <= at_once;
    }
    return first;
}

int stein__any_crossed(const stein_sim *sim)
{
    int crossed = 0;
    for (int i = 0; i < sim->nguard; i++) {
        crossed |= (sim->guard[i] > 0.0) ^ sim->mode[i];
    }
    for (int i = sim->nguard; i < sim->nswitch; i++) {
        crossed |= sim->guard[i] < 0.0;
    }
    return crossed;
}

/* a trial step that left the numbers is not looked at any further */
stein_status stein__check_finite(stein_sim *sim, double h, stein_err *err)
{
    int nq = sim->model->nq;
    const double *q = sim->q1, *qd = sim->qd1, *qdd = sim->qdd1;
    double none = 0.0; // of a number x - x is 0
    for (int j = 0; j < nq; j++) {
        none += (q[j] - q[j]) + (qd[j] - qd[j]) + (qdd[j] - qdd[j]);
    }
    for (int j = 0; none != 0.0 && j < nq; j++) {
        if (!isfinite(q[j]) || !isfinite(qd[j]) || !isfinite(qdd[j])) {
            stein_err why;
            stein__fail(&why, STEIN_ENONFINITE, "the state of joint \"%s\" is no longer finite",
                        sim->model->bodies[j].name);
            return stein__explain_failure(sim, h, STEIN_ENONFINITE, why.msg, err);
        }
    }
    return STEIN_OK;
}

void stein__accept(stein_sim *sim, double t1)
{
    size_t nq = (size_t)sim->model->nq;
    memcpy(sim->q, sim->q1, sizeof *sim->q * nq);
    memcpy(sim->qd, sim->qd1, sizeof *sim->qd * nq);
    memcpy(sim->qdd, sim->qdd1, sizeof *sim->qdd * nq);
    if (sim->model->nrow > 0 && sim->head->t + sim->loop.pass <= t1) {
        sim->loop.passed++;
        sim->loop.last = sim->head->t + sim->loop.pass;
        sim->loop.pass = INFINITY;
    }
    sim->head->t = t1;
    sim->fresh = FRESH;
    if (sim->follower != NULL) {
        sim->on_accept(sim->follower, sim, sim->span);
    }
}

stein_status stein__try(stein_sim *sim, double h, int implicit, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (sim->model->nrow > 0) {
        if (!stein__is_controlled(sim->def.integrator)) {
            stein__singular_look(sim, h);
        }
        sim->loop.near = stein__singular_is_near(sim, h);
    }
    if (implicit && sim->loop.near) {
        sim->counts.refused = "loops are near a singular position";
        implicit = 0;
    }
    status = implicit ? sim->implicit->trial(sim, h, err) : stein__trial(sim, sim->head->t, h, err);
    sim->span = h;
    if (sim->implicit != NULL) {
        sim->implicit->inside = implicit;
    }
    return status == STEIN_OK ? stein__check_finite(sim, h, err) : status;
}

void stein__flip_crossed(stein_sim *sim)
{
    const stein_model *model = sim->model;
    if (sim->follower != NULL) {
        sim->on_switch(sim->follower, sim, 0);
    }
    for (int i = 0; i < model->nspot; i++) {
        if (sim->crossed[i]) {
            flip_spot(sim, i);
        }
    }
    for (int i = 0; i < model->nnotch; i++) {
        const unsigned char *crossed = sim->crossed + model->nspot + NOTCH_GUARDS * i;
        if (crossed[0] || crossed[1] || crossed[2] || crossed[3]) {
            flip_notch(sim, i, crossed);
        }
    }
    if (model->nstick > 0) {
        stein__stick_switch(sim);
    }
    if (sim->follower != NULL) {
        sim->on_switch(sim->follower, sim, 1);
    }
}

static int most_located(const stein_sim *sim)
{
    return sim->model->nstick > 0 ? LOCATED_STICKING : LOCATED;
}

/* sub-step n towards `target`: all the way, or to the first event and its switch */
static stein_status substep_in_chart(stein_sim *sim, double target, int n, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (sim->fresh == STALE) {
        status = n > 0 ? stein__restart(sim, err) : stein__refresh(sim, err);
    }
    if (status != STEIN_OK) {
        return status;
    }
    double h = target - sim->head->t;
    stein__keep_touches(sim);
    stein_status tried = stein__try(sim, h, 0, NULL);
    int lost = tried == STEIN_ENONFINITE, taken = 0;
    int abrupt = lost || (tried == STEIN_OK && stein__abrupt(sim, h));
    status = abrupt ? stein__take_abrupt(sim, target, lost, &taken, err) : STEIN_OK;
    if (status != STEIN_OK || taken) {
        return status;
    }
    if (tried != STEIN_OK) {
        return stein__try(sim, h, 0, err); // once more, for the message
    }
    if (!stein__any_crossed(sim)) {
        stein__accept(sim, target);
        sim->fresh = abrupt ? TOLD : sim->fresh;
        return STEIN_OK;
    }
    int located = n < most_located(sim);
    double theta = located ? fmin(stein__first_root(sim, h, 0.0, 1.0), 1.0) : 0.0;
    int moves = sim->head->t + theta * h > sim->head->t;
    if (!located || (!moves && n > 0 && sim->model->nstick == 0)) {
        return stein__take_rest(sim, target, err);
    }
    if (moves) {
        double t1 = sim->head->t + theta * h;
        // forces behind the switch follow; what sticks or follows the motion asks for those before
        sim->switches_at_end = t1 < target && sim->model->nstick == 0 && sim->follower == NULL;
        status = stein__try(sim, t1 - sim->head->t, 0, err);
        sim->switches_at_end = 0;
        if (status != STEIN_OK) {
            return status;
        }
        stein__accept(sim, t1);
    }
    stein__flip_crossed(sim);
    return STEIN_OK;
}

static stein_status substep(stein_sim *sim, double target, int n, stein_err *err)
{
    stein_status status = substep_in_chart(sim, target, n, err);
    if (status == STEIN_OK && sim->model->nball > 0) {
        (void)stein__rechart(sim);
    }
    return status;
}

static stein_status advance_controlled(stein_sim *sim, double target, stein_err *err)
{
    double h = target - sim->head->t;
    double share = sim->model->nball > 0 ? of_balls : 1.0;
    stein_pace pace = {.tolerance = share * sim->tolerance, .longest = h, .h = h, .next = INFINITY};
    return h > 0.0 ? stein__run_controlled(sim, target, &pace, err) : STEIN_OK;
}

stein_status stein__advance(stein_sim *sim, double target, stein_err *err)
{
    if (stein__is_controlled(sim->def.integrator)) {
        return advance_controlled(sim, target, err);
    }
    for (int n = 0; sim->head->t < target; n++) {
        stein_status status = substep(sim, target, n, err);
        if (status != STEIN_OK) {
            sim->fresh = STALE;
            return status;
        }
    }
    return STEIN_OK;
}

stein_status stein_step(stein_sim *sim, stein_err *err)
{
    stein_status status = stein__advance(sim, stein__next_on_grid(sim), err);
    if (status == STEIN_OK) {
        sim->head->step++;
    }
    return status;
}

stein_status stein__check_end(const stein_sim *sim, double t_end, stein_err *err)
{
    if (!isfinite(t_end) || t_end < sim->head->t) {
        return stein__fail(
            err, STEIN_EINVAL,
            "cannot run to t = %g s from t = %g s: expected a time that is still to come", t_end,
            sim->head->t);
    }
    return STEIN_OK;
}

stein_status stein_run(stein_sim *sim, double t_end, stein_err *err)
{
    double end;
    stein_status status = stein__check_end(sim, t_end, err);
    while (status == STEIN_OK && stein__next_end(sim, t_end, &end)) {
        status = stein_step(sim, err);
    }
    if (status == STEIN_OK) {
        status = stein__advance(sim, t_end, err);
    }
    if (status == STEIN_OK) {
        stein__end_run(sim, t_end);
    }
    return status;
}

stein_status stein_step_error(const stein_sim *sim, double *eq, double *eqd, stein_err *err)
{
    if (sim->eq < 0.0) {
        return stein__fail(err, STEIN_EINVAL,
                           "no error estimate: it comes with a step of "
                           "Dormand-Prince 5(4)");
    }
    *eq = sim->eq;
    *eqd = sim->eqd;
    return STEIN_OK;
}
