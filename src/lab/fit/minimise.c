/* SPDX-License-Identifier: GPL-3.0-or-later
 * minimise.c - Levenberg-Marquardt on normal equations whose nuisances are eliminated.
 *
 * The equations are those of normal.c with mu D for the damping, mu by Nielsen's rule (Madsen,
 * Nielsen & Tingleff 2004, 3.2). D is diag(J'J) (Marquardt 1963), but falls to no less than a half
 * from one set of derivatives to the next. Otherwise an unknown could go to infinity after a long
 * step to where residuals hardly depend on it. (Moré 1978 keeps the largest D of all; it creeps
 * where an unknown has to change by powers of ten.) Steps follow the bend of the residuals
 * (geodesic acceleration, Transtrum & Sethna 2012, arXiv:1201.5885), and are refused unseen where
 * it is strong; both where an unknown has no prior to hold it. Friction is not smooth enough for
 * them (an axle of tests/test_trust.sh: two of three searches ended elsewhere). Without the two,
 * BoxBOD and MGH17 of NIST's nonlinear regressions end at infinity from their first starts.
 *
 * GSL's multifit_nlinear was rejected. Its dense J holds a column for every nuisance of every
 * stroke (100 strokes x 4 nuisances x 10^5 rows). A stroke that cannot be simulated has no residual
 * to return; here the step is refused. Its state is hidden, so an interrupted search could not
 * continue bit for bit. The method is the same, a test compares the two. Normal equations square
 * the condition number; in prior units it is bounded by the ratio of prior to data sd, 10^4 at the
 * worst seen, and 10^8 is still harmless here.
 *
 * It ends when the decrement g' (J'J)^-1 g, the gain of one more step, is below a limit. 1e-4 is a
 * hundredth of a standard deviation in the direction that is furthest off. With one-sided
 * differences it also ends when a step has gained less than ten times the figure.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { AT_BOUND = 2, MAX_REFUSED = 12, CHORDS = 5, DAMPINGS = 4 };
static const double far_off = 30.0;     /* objective, from where no chord leads back */
static const double valley = 5.0;       /* a decrement against what counts as nothing */
static const double nearly_full = 0.5;  /* of a decrement that a damped step expects */
static const double fading = 0.5;       /* of D from one set of derivatives to the next */
static const double glimpse = 0.1;      /* of a step, where its bend is measured */
static const double strong = 0.75;      /* length of an acceleration against that of its step */
static const double straight = 1e-3;    /* a decrement, in objectives: residuals are linear */
static const double longest_step = 3.0; /* of an unknown with a prior, in its sd */

typedef struct room {
    fit__normal normal;
    double *r, *try_r, *J, *dx, *try_x;
    double *bend, *g; /* half the acceleration of a step; the gradient meanwhile */
    double expected;  /* gain of the last step, by the linear model */
    double prior;     /* weight of the priors in a step of fit__descend */
    int current;      /* J is that of where the search stands, but for steps that gain nothing */
    int unbounded;    /* an unknown has no prior to hold it */
} room;

/* may an unknown go to infinity, where residuals hardly depend on it? A prior holds it. */
static int is_unbounded(const fit__problem *p)
{
    int any = 0;
    for (int u = 0; u < p->np; u++) {
        any |= !p->unknown[u].prior && !p->unknown[u].idle;
    }
    return any;
}

static stein_status room_make(room *m, const fit__problem *p, stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    m->r = malloc(sizeof *m->r * (2 * rows + 4 * nu + 1));
    m->J = malloc(sizeof *m->J * (fit__columns(p) + 1));
    stein_status status = fit__normal_make(&m->normal, p, err);
    if (status == STEIN_OK && (m->r == NULL || m->J == NULL)) {
        status = lab__no_memory(err);
    }
    m->try_r = m->r + (m->r != NULL ? rows : 0);
    m->dx = m->try_r + (m->r != NULL ? rows : 0);
    m->try_x = m->dx + (m->r != NULL ? nu : 0);
    m->bend = m->try_x + (m->r != NULL ? nu : 0);
    m->g = m->bend + (m->r != NULL ? nu : 0);
    m->unbounded = is_unbounded(p);
    return status;
}

static void room_free(room *m)
{
    fit__normal_free(&m->normal);
    free(m->r);
    free(m->J);
}

/* what a full step without damping would gain */
static double decrement(room *m, const fit__problem *p)
{
    if (fit__normal_factor(&m->normal, p, 0.0, NULL) != 0) {
        return INFINITY;
    }
    fit__normal_step(&m->normal, p, m->dx);
    return -lab__dot(m->dx, m->normal.g, (size_t)p->nu);
}

/* D where derivatives are new */
static void rescale(const fit__problem *p, fit__state *s, const room *m)
{
    for (int u = 0; u < p->nu; u++) {
        const double *d = fit__normal_diagonal(&m->normal, p, u);
        double kept = m->unbounded ? fading * s->scale[u] : 0.0;
        s->scale[u] = fmax(d != NULL ? *d : 0.0, kept);
    }
}

/* The step m->dx, which is not absurd, and the gain that is expected of it */
static int damped(const fit__problem *p, const fit__state *s, room *m)
{
    double longest = 0.0, scale = 1.0;
    if (fit__normal_factor(&m->normal, p, s->mu, s->scale) != 0) {
        return 0;
    }
    fit__normal_step(&m->normal, p, m->dx);
    m->expected = 0.0;
    for (int u = 0; u < p->nu; u++) {
        longest = p->unknown[u].prior ? fmax(longest, fabs(m->dx[u])) : longest;
        m->expected += m->dx[u] * (s->mu * s->scale[u] * m->dx[u] - m->normal.g[u]);
    }
    scale = longest > longest_step ? longest_step / longest : 1.0;
    for (int u = 0; u < p->nu; u++) {
        m->dx[u] *= scale;
    }
    return 1;
}

/* r(x + v) = r + J v + r'' / 2, so the minimum is not at x + v but at x + v + a / 2 with
 * (J'J + mu D) a = -J' r''. @return 0 where a is so long that v goes beyond what J tells */
static int bend(fit__problem *p, const fit__state *s, room *m, stein_status *status, stein_err *err)
{
    double step = 0.0, turn = 0.0;
    int failed = 0;
    for (int u = 0; u < p->nu; u++) {
        m->try_x[u] = s->x[u] + glimpse * m->dx[u];
    }
    *status = fit__residuals(p, m->try_x, m->try_r, &failed, err);
    if (*status != STEIN_OK || failed > 0) {
        return 0;
    }
    fit__normal_curvature(&m->normal, p, m->r, m->J, m->dx, glimpse, m->try_r);
    memcpy(m->g, m->normal.g, sizeof *m->g * (size_t)p->nu);
    fit__normal_gradient(&m->normal, p, s->x, m->try_r, m->J, 0.0);
    fit__normal_step(&m->normal, p, m->bend);
    memcpy(m->normal.g, m->g, sizeof *m->g * (size_t)p->nu);
    for (int u = 0; u < p->nu; u++) {
        step += s->scale[u] * m->dx[u] * m->dx[u];
        turn += s->scale[u] * m->bend[u] * m->bend[u];
        m->dx[u] += 0.5 * m->bend[u];
    }
    return sqrt(turn) <= strong * sqrt(step);
}

/* a step tried. @return 1 when it is better */
static int try_step(fit__problem *p, fit__state *s, room *m, double *gain_ratio,
                    stein_status *status, stein_err *err)
{
    int failed = 0, linear = s->decrement < straight * s->objective || !m->unbounded;
    if (!damped(p, s, m) || (!linear && !bend(p, s, m, status, err))) {
        return 0;
    }
    for (int u = 0; u < p->nu; u++) {
        m->try_x[u] = s->x[u] + m->dx[u];
    }
    *status = fit__residuals(p, m->try_x, m->try_r, &failed, err);
    if (*status != STEIN_OK || failed > 0) {
        return 0;
    }
    double there = fit__chi2(p, m->try_r) + fit__priors(p, m->try_x);
    *gain_ratio = (s->objective - there) / fmax(m->expected, 1e-300);
    if (!(there < s->objective)) {
        return 0;
    }
    s->objective = there;
    memcpy(s->x, m->try_x, sizeof *s->x * (size_t)p->nu);
    memcpy(m->r, m->try_r, sizeof *m->r * fit__offset(p, p->nstroke));
    return 1;
}

/* one Jacobian, and steps until one is better. @return 0 when none is */
static int iterate(fit__problem *p, fit__state *s, room *m, stein_status *status, stein_err *err)
{
    for (int refused = 0; refused < MAX_REFUSED; refused++) {
        double ratio = 0.0;
        int better = try_step(p, s, m, &ratio, status, err);
        if (*status != STEIN_OK) {
            return 0;
        }
        if (better) {
            double f = 2.0 * ratio - 1.0;
            s->mu = fmax(1e-12, s->mu * fmax(1.0 / 10.0, 1.0 - f * f * f));
            s->nu = 2.0;
            return 1;
        }
        s->mu *= s->nu;
        s->nu *= 2.0;
    }
    return 0;
}

/* residuals and objective where the search begins */
static stein_status begin(const fit__problem *p, fit__state *s, room *m, stein_err *err)
{
    int failed = 0;
    stein_status status = fit__residuals(p, s->x, m->r, &failed, err);
    if (status == STEIN_OK && failed > 0) {
        return lab__fail(err, STEIN_ENONFINITE, "%d of %d records cannot be simulated", failed,
                         p->nstroke);
    }
    s->objective = fit__chi2(p, m->r) + fit__priors(p, s->x);
    return status;
}

/* numbers of the mechanism and those beside an effect's amount stay within some prior sd */
static int is_bounded(const fit__unknown *u)
{
    return u->prior && (u->kind == FIT__PARAM || u->kind == FIT__SIDE);
}

/* objective at x + dx, which may be shortened; INFINITY when it cannot be simulated */
static double go(fit__problem *p, room *m, const double *x, stein_status *status, stein_err *err)
{
    double longest = 0.0;
    int failed = 0;
    for (int u = 0; u < p->nu; u++) {
        longest = p->unknown[u].prior ? fmax(longest, fabs(m->dx[u])) : longest;
    }
    double scale = longest > longest_step ? longest_step / longest : 1.0;
    for (int u = 0; u < p->nu; u++) {
        double to = x[u] + scale * m->dx[u], most = p->limit;
        const fit__unknown *of = &p->unknown[u];
        m->try_x[u] = of->idle || !isfinite(to) ? to // what is held may be beyond a bound
                      : is_bounded(of)          ? fmin(fmax(to, -most), most)
                      : of->kind == FIT__AMOUNT ? fmax(to, of->least)
                                                : to;
    }
    *status = fit__residuals(p, m->try_x, m->try_r, &failed, err);
    return *status == STEIN_OK && failed == 0 ? fit__chi2(p, m->try_r) + fit__priors(p, m->try_x)
                                              : (double)INFINITY;
}

/* Steps with one set of derivatives. The valley of parameters that the data hardly tell apart is
 * bent: a full step along it leaves the floor, and is refused although it leads the right way. The
 * steps after it, with the same derivatives, go back down across the valley, where derivatives
 * hardly change; only where all of them have led is judged. A step costs one residual, derivatives
 * cost one for every unknown. @return 1 when the objective fell */
static int chord(fit__problem *p, fit__state *s, room *m, double *x, stein_status *status,
                 stein_err *err)
{
    double start = s->objective, last = INFINITY;
    size_t size = sizeof *x * (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    memcpy(x, s->x, size);
    for (int k = 0; k < CHORDS; k++) {
        double there = go(p, m, x, status, err);
        if (*status != STEIN_OK || !(there < far_off * start + 1e4) || (k > 1 && there > last)) {
            break;
        }
        memcpy(x, m->try_x, size);
        if (there < s->objective) {
            memcpy(s->x, x, size);
            memcpy(m->r, m->try_r, sizeof *m->r * rows);
            s->objective = there;
        }
        if (last - there < 0.05 * fabs(start - there) || fabs(start - there) < 1.0) {
            break;
        }
        last = there;
        fit__normal_gradient(&m->normal, p, x, m->try_r, m->J, m->prior);
        fit__normal_step(&m->normal, p, m->dx);
    }
    return s->objective < start;
}

/* is a parameter at its bound, with a step that leads across? */
static int leaves(const fit__problem *p, int u, double x, double dx)
{
    const fit__unknown *of = &p->unknown[u];
    int low = of->kind == FIT__AMOUNT && x <= of->least && dx < 0.0;
    int off = is_bounded(of) && fabs(x) >= p->limit * (1.0 - 1e-9) && x * dx > 0.0;
    return !of->idle && (low || off);
}

/* With chi2 per degree of freedom far above 1 the residual is no noise, and derivatives are off by
 * shares of it. What they then say of numbers that the data hardly determine is wrong. So the
 * priors weigh chi2/dof times as much, until there is nothing but noise left. */
static void temper(const fit__problem *p, const fit__state *s, room *m)
{
    m->prior = fmax(1.0, fit__chi2_dof(p, m->r));
    for (int u = 0; u < p->nu; u++) {
        double *d = fit__normal_diagonal(&m->normal, p, u);
        if (d != NULL && p->unknown[u].prior && u != p->flat) {
            double more = p->unknown[u].mistake ? 0.0 : m->prior - 1.0;
            *d += more;
            m->normal.g[u] += more * s->x[u];
        }
    }
}

/* dx with damping mu in units of the priors: what the data hardly tell moves slowly, what they tell
 * well goes all the way at once. (Marquardt's scaling does the opposite, and creeps.) */
static int solve_damped(const fit__problem *p, const fit__state *s, room *m)
{
    fit__normal_fill(&m->normal, p, s->x, m->r, m->J, 1);
    temper(p, s, m);
    for (size_t i = 0; i < (size_t)m->normal.n; i++) {
        *gsl_matrix_ptr(m->normal.A, i, i) += s->mu;
    }
    if (fit__normal_factor(&m->normal, p, 0.0, NULL) != 0) {
        return -1;
    }
    fit__normal_step(&m->normal, p, m->dx);
    return 0;
}

/* Shares of a step, one after the other while none is better. Damping in units of the priors leaves
 * the steep directions alone, and there a stroke's events may turn the derivative within a step. */
static const double share[DAMPINGS] = {1.0, 1.0, 0.25, 0.06};

/* A damped step and its chords. Parameters at a bound that the step would cross stay there, and the
 * others are solved for without them. */
static int damped_step(fit__problem *p, fit__state *s, room *m, double *x, double part,
                       stein_status *status, stein_err *err)
{
    int held = 1, better = 0, solved = solve_damped(p, s, m);
    while (solved == 0 && held > 0) {
        held = 0;
        for (int u = 0; u < p->np; u++) {
            if (leaves(p, u, s->x[u], m->dx[u])) {
                p->unknown[u].idle = AT_BOUND;
                held++;
            }
        }
        solved = held > 0 ? solve_damped(p, s, m) : 0;
    }
    if (solved == 0) {
        for (int u = 0; u < p->nu; u++) {
            m->dx[u] *= part;
        }
        better = chord(p, s, m, x, status, err);
    }
    for (int u = 0; u < p->np; u++) {
        p->unknown[u].idle = p->unknown[u].idle == AT_BOUND ? 0 : p->unknown[u].idle;
    }
    return better;
}

/* new derivatives where the search stands, and steps for the next ones */
static stein_status renew(fit__problem *p, const fit__state *s, room *m, stein_err *err)
{
    stein_status status = fit__sensitivities(p, s->x, m->r, m->J, err);
    if (status == STEIN_OK) {
        fit__choose_steps(p, m->J);
    }
    m->current = 1;
    return status;
}

/* the search of fit__descend. @param fresh  J is that of s->x */
static stein_status descend(fit__problem *p, fit__state *s, room *m, double *x, int fresh,
                            double enough, int renewals, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (; status == STEIN_OK; fresh = 1) {
        fit__normal_fill(&m->normal, p, s->x, m->r, m->J, 1);
        s->decrement = decrement(m, p);
        s->ended = s->decrement < enough;
        if (s->ended && (fresh || renewals <= 0)) {
            break;
        }
        double before = s->objective;
        int better = 0;
        for (int k = 0; !better && status == STEIN_OK && k < (renewals > 0 ? DAMPINGS : 2); k++) {
            better = damped_step(p, s, m, x, share[k], &status, err);
            s->mu = better ? 0.1 * s->mu : 30.0 * fmax(s->mu, 0.03);
        }
        s->iteration++;
        int nothing = !better || before - s->objective < enough + 1e-4 * s->objective;
        m->current &= nothing;
        // derivatives from elsewhere have no right to say that this is the end
        s->ended = (fresh || renewals <= 0) && nothing;
        if (s->ended || renewals-- <= 0) {
            s->ended = s->ended && s->decrement < 100.0 * enough + 1e-3 * s->objective;
            break;
        }
        s->mu = better ? s->mu : 0.0;
        status = status == STEIN_OK ? renew(p, s, m, err) : status;
    }
    return status;
}

stein_status fit__descend(fit__problem *p, fit__end *e, int known, double enough, int renewals,
                          stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), nu = (size_t)p->nu;
    fit__state s = {.x = e->x, .mu = e->mu};
    room m = {.r = e->r, .J = e->J, .try_r = malloc(sizeof *m.try_r * (rows + 3 * nu + 1))};
    m.dx = m.try_r + (m.try_r != NULL ? rows : 0);
    m.try_x = m.dx + (m.try_r != NULL ? nu : 0);
    stein_status status = fit__normal_make(&m.normal, p, err);
    if (status == STEIN_OK && m.try_r == NULL) {
        status = lab__no_memory(err);
    }
    status = status == STEIN_OK ? begin(p, &s, &m, err) : status;
    if (status == STEIN_OK && known) {
        fit__choose_steps(p, m.J);
    } else if (status == STEIN_OK) {
        status = renew(p, &s, &m, err);
    }
    status = status == STEIN_OK ? descend(p, &s, &m, m.try_x + nu, !known, enough, renewals, err)
                                : status;
    e->objective = s.objective;
    e->ended = s.ended;
    e->current = m.current;
    fit__normal_free(&m.normal);
    free(m.try_r);
    return status;
}

stein_status fit__minimise(fit__problem *p, fit__state *s, double enough, double relative,
                           int iterations, fit__checkpoint *checkpoint, void *ctx, stein_err *err)
{
    room m = {.r = NULL};
    memcpy(p->step, s->step, sizeof *p->step * (size_t)p->nu);
    stein_status status = room_make(&m, p, err);
    status = status == STEIN_OK ? begin(p, s, &m, err) : status;
    s->ended = 0;
    int settled = 0; // the last steps brought nothing
    while (status == STEIN_OK && !s->ended) {
        status = fit__sensitivities(p, s->x, m.r, m.J, err);
        if (status != STEIN_OK) {
            break;
        }
        fit__normal_fill(&m.normal, p, s->x, m.r, m.J, 1);
        rescale(p, s, &m);
        s->decrement = decrement(&m, p);
        if (s->decrement < enough * (1.0 + relative * s->objective)) {
            s->ended = 1;
            break;
        }
        double before = s->objective;
        if (s->iteration >= iterations || !iterate(p, s, &m, &status, err)) {
            s->ended = settled;
            break;
        }
        s->iteration++;
        // a step that brought nothing: the decrement is rounding, or the coarseness of one-sided
        // differences - or the damping holds a step along a valley back, and is to fall first
        double nothing = (p->central ? 1.0 : 10.0) * enough * (1.0 + relative * s->objective);
        settled = before - s->objective < (settled ? valley : 1.0) * nothing;
        s->ended =
            settled && (s->decrement < valley * nothing || m.expected > nearly_full * s->decrement);
        fit__choose_steps(p, m.J);
        memcpy(s->step, p->step, sizeof *s->step * (size_t)p->nu);
        if (status == STEIN_OK && checkpoint != NULL) {
            status = checkpoint(ctx, s, err);
        }
    }
    room_free(&m);
    return status;
}
