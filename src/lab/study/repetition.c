/* SPDX-License-Identifier: GPL-3.0-or-later
 * repetition.c - how fast the key can be struck again, and how far it must come back for it.
 *
 * The key moves periodically, each way quintic in time. It moves down in the time of the touch (at
 * most 35 % of the period), held down for 10 % of the period, up in the remaining time, held up for
 * 10 %. Both a louder stroke (less time down) and a softer one are looked at. A period works when
 * every one of STROKES strokes escapes once and strikes: a beak that did not get back under the
 * roof cannot escape again.
 *
 * A prescribed motion can also pull the key up, which no finger does. With `pushes` a period works
 * only if the motion never pulls while the key accelerates upwards. That is the first half of the
 * way; in the second half the rest felt slows the key in the real action.
 *
 * The limit is searched from slow to fast in steps of 12 % until the first failure, then halved.
 */
#include <math.h>

#include "functions.h"
#include "study.h"

enum { STROKES = 3, HALVINGS = 8, TOUCHES = 5, SEARCH = 24, RETURNS = 10 };
static const double slowest = 0.3, faster = 1.0 / 1.12; /* search from [s], by */
static const double softest = 0.1, loudest = 0.025;     /* durations of the way down [s] */
static const double calm = 0.3, medium = 0.06;          /* period and way down of the return [s] */
static const double quick = 0.35, hold = 0.10, wait = 0.10; /* shares of the period */
static const double pull = 0.01;                            /* what counts as pulling [N] */
static const double look_every = 1e-4;                      /* whether it pulls [s] */
/* steps of controlled error: of a step's end [rad or m], their longest, and how far it goes until
 * it is asked whether the answer is known [s] */
static const double tolerance = 1e-8, longest = 1e-3, stretch = 0.01;

typedef struct rhythm {
    const study *s;
    double period, depth;
    double down, up; /* shares of the period */
    int string, notch, force;
    int escapes, impacts, pulled;
} rhythm;

static void key_signal(void *ctx, double t, double u[3])
{
    const rhythm *r = ctx;
    double way = r->s->key_down - r->s->key_rest, x = fmod(t, r->period) / r->period, s[3];
    if (x < r->down + hold) {
        double start = t < r->period ? 0.0 : 1.0 - r->depth, share = (1.0 - start) * way;
        double f = 1.0 / (r->down * r->period);
        study_motion(STUDY_PRESSED, x / r->down, s);
        u[0] = r->s->key_rest + start * way + share * s[0];
        u[1] = share * s[1] * f;
        u[2] = share * s[2] * f * f;
    } else {
        double share = r->depth * way, f = 1.0 / (r->up * r->period);
        study_motion(STUDY_PRESSED, (x - r->down - hold) / r->up, s);
        u[0] = r->s->key_down - share * s[0];
        u[1] = -share * s[1] * f;
        u[2] = -share * s[2] * f * f;
    }
}

static void count(void *ctx, stein_sim *sim, const stein_event *event)
{
    rhythm *r = ctx;
    (void)sim;
    if (event->kind == STEIN_EVENT_ESCAPEMENT && event->index == r->notch) {
        r->escapes++;
    } else if (event->kind == STEIN_EVENT_IMPACT && event->index == r->string) {
        r->impacts++;
    }
}

/* does the prescribed motion pull now, while the key should come up by its weight? */
static int pulls(const rhythm *r, stein_sim *sim)
{
    double x = fmod(stein_time(sim), r->period) / r->period;
    if (r->force < 0 || x < r->down + hold || x > r->down + hold + 0.5 * r->up) {
        return 0;
    }
    double moment = stein_sim_model(sim)->channels[r->force].sign * stein_read(sim, r->force);
    return moment / r->s->arm < -pull;
}

static double look_for_pull(void *ctx, stein_sim *sim)
{
    rhythm *r = ctx;
    r->pulled |= pulls(r, sim);
    return r->pulled ? (double)INFINITY : stein_time(sim) + look_every;
}

static int one_stroke(rhythm *r, stein_sim *sim, int i, int pushes)
{
    double end = (i + 1) * r->period;
    stein_pace pace = {.tolerance = tolerance,
                       .longest = longest,
                       .h = r->s->dt,
                       .next = stein_time(sim),
                       .look = pushes ? look_for_pull : NULL,
                       .ctx = r};
    r->escapes = r->impacts = 0;
    while (stein_time(sim) < end && !r->pulled) {
        double until = fmin(end, stein_time(sim) + stretch);
        if (stein_run_adaptive(sim, until, &pace, NULL) != STEIN_OK) {
            return 0;
        }
    }
    return !r->pulled && r->escapes == 1 && r->impacts >= 1;
}

int study_repeats(const study *s, stein_sim *sim, double period, const study_rhythm *how)
{
    const stein_model *m = lab_equations(s->model);
    rhythm r = {.s = s,
                .period = period,
                .depth = how->depth,
                .string = m->stroke.string,
                .notch = m->stroke.notch,
                .force = lab__channel_of(m, STEIN_READ_INPUT_FORCE, s->input)};
    const char *input = m->inputs[s->input].name;
    r.down = fmin(quick, how->down / period);
    r.up = 1.0 - hold - wait - r.down;
    int works = stein_drive(sim, input, key_signal, &r, NULL) == STEIN_OK &&
                stein_reset(sim, NULL) == STEIN_OK;
    stein_load_lift(sim);
    stein_on_event(sim, count, &r);
    for (int i = 0; works && i < STROKES; i++) {
        works = one_stroke(&r, sim, i, how->pushes);
    }
    stein_on_event(sim, NULL, NULL);
    stein_drive(sim, input, NULL, NULL, NULL);
    return works;
}

double study_repetition_limit(const study *s, stein_sim *sim, const study_rhythm *how,
                              double *fails)
{
    double works = NAN, period = slowest;
    *fails = NAN;
    for (int n = 0; n < SEARCH; n++, period *= faster) {
        if (study_repeats(s, sim, period, how)) {
            works = period;
        } else {
            *fails = period;
            break;
        }
    }
    for (int n = 0; n < HALVINGS && isfinite(*fails) && isfinite(works); n++) {
        double middle = 0.5 * (works + *fails);
        if (study_repeats(s, sim, middle, how)) {
            works = middle;
        } else {
            *fails = middle;
        }
    }
    return works;
}

double study_return_needed(const study *s, stein_sim *sim, double period, double down,
                           double *fails)
{
    study_rhythm how = {down, 1.0, 0};
    double works = study_repeats(s, sim, period, &how) ? 1.0 : NAN;
    *fails = 0.0;
    for (int n = 0; n < RETURNS && isfinite(works); n++) {
        how.depth = 0.5 * (works + *fails);
        if (study_repeats(s, sim, period, &how)) {
            works = how.depth;
        } else {
            *fails = how.depth;
        }
    }
    return works;
}

/* ---- the part ---- */

enum { DOWN, SPEED, PUSH_WORKS, PUSH_FAILS, PUSH_RATE, WORKS, FAILS, RATE };

typedef struct limits {
    const study *s;
    study_table *t;
    double needed, too_little; /* shares of the key's way */
} limits;

static double way(const study *s)
{
    return fabs(s->arm * (s->key_down - s->key_rest));
}

static stein_status look(void *ctx, stein_sim *sim, int i)
{
    limits *w = ctx;
    if (i == 2 * TOUCHES) {
        w->needed = study_return_needed(w->s, sim, calm, medium, &w->too_little);
        return STEIN_OK;
    }
    int pushes = i % 2, touch = i / 2;
    double *row = study_row(w->t, touch), fails = NAN;
    const study_rhythm how = {
        softest * stein__power(loudest / softest, (double)touch / (TOUCHES - 1)), 1.0, pushes};
    double works = study_repetition_limit(w->s, sim, &how, &fails);
    row[pushes ? PUSH_WORKS : WORKS] = works;
    row[pushes ? PUSH_FAILS : FAILS] = fails;
    row[pushes ? PUSH_RATE : RATE] = 1.0 / works;
    if (!pushes) {
        row[DOWN] = how.down;
        row[SPEED] = way(w->s) / how.down;
    }
    return STEIN_OK;
}

static const double *quickest(const study_table *t, int column)
{
    const double *best = NULL;
    for (int i = 0; i < t->nrow; i++) {
        const double *row = study_row(t, i);
        if (isfinite(row[column]) && (best == NULL || row[column] < best[column])) {
            best = row;
        }
    }
    return best;
}

static void say(const limits *w, study_part *part)
{
    const double *push = quickest(w->t, PUSH_WORKS), *force = quickest(w->t, WORKS);
    if (push != NULL) {
        study_say(part,
                  "With a finger that only pushes, strokes can follow each other every <b>%.0f "
                  "ms</b> at best (%.1f a second, %.2f m/s of key speed); any faster the key would "
                  "have to be pulled up, or one of %d strokes no longer escapes and strikes.",
                  1e3 * push[PUSH_WORKS], push[PUSH_RATE], push[SPEED], STROKES);
    } else {
        study_say(part,
                  "No rhythm with a period of %.1f s repeats under a finger that only pushes.",
                  slowest);
    }
    if (force != NULL) {
        study_say(part,
                  "With the key moved up by force the beak is "
                  "caught at every period tried down to %.1f ms.",
                  1e3 * force[WORKS]);
    }
    if (isfinite(w->needed)) {
        study_say(part,
                  "At an easy period of %.0f ms the key must give back at least <b>%.1f %%</b> of "
                  "its way (%.2f mm of %.2f mm); with %.1f %% the beak stays outside the notch.",
                  1e3 * calm, 100.0 * w->needed, 1e3 * w->needed * way(w->s), 1e3 * way(w->s),
                  100.0 * w->too_little);
    }
}

static void draw(study_part *part, const study_table *t)
{
    study_chart *c = study_chart_new(part, "repetition", 760, 420, 1);
    study_panel *p =
        study_panel_new(c, "key speed of the stroke [m/s]", "fastest repetition [strokes/s]");
    p->y0 = 0.0;
    p->legend = 1;
    study_curve_add(p, t, SPEED, 1.0, PUSH_RATE, 1.0, STUDY_BOTH, 0, "finger that only pushes");
    study_curve_add(p, t, SPEED, 1.0, RATE, 1.0, STUDY_BOTH, 6, "key moved by force both ways");
}

stein_status study_repetition(const study *s, study_part *part, stein_err *err)
{
    static const char *const head[] = {"down_time [s]",
                                       "key_speed [m/s]",
                                       "pushed_shortest_period [s]",
                                       "pushed_period_that_fails [s]",
                                       "pushed_rate [1/s]",
                                       "shortest_period [s]",
                                       "period_that_fails [s]",
                                       "rate [1/s]",
                                       NULL};
    part->id = "repetition";
    part->title = "Repetition";
    limits w = {.s = s, .needed = NAN};
    if (s->input < 0) {
        study_say(part, "Left out: %s.", s->left_out);
        return STEIN_OK;
    }
    w.t = study_table_new(part, "repetition", TOUCHES, head);
    const stein_sim_def def = study_def_controlled(s);
    stein_status status =
        w.t == NULL ? lab__no_memory(err)
                    : study_each_by(s, &def, "repetition", 2 * TOUCHES + 1, look, &w, err);
    if (status == STEIN_OK) {
        draw(part, w.t);
        say(&w, part);
    }
    return status;
}
