/* SPDX-License-Identifier: GPL-3.0-or-later
 * stroke_details.c - one stroke, seen closely: the finger's force, the friction in the notch, the
 * re-arming.
 *
 * A trace is kept at every step and evaluated when lab_strike has returned the event times.
 *
 *   finger     force of the load on the key, or the moment of the prescribed motion by the arm of
 *              the load's place; the largest mean over 3 ms in the second half of the time before
 *              escapement, after the first knock of the beak on the roof
 *   slip       in phase iii the beak's face slides on the corner C. Its speed there is
 *              v = (v_beak(C) - v_pawl(C)) . b, b along the beak's face, and the work of friction
 *              W = int mu(v) N v dt >= 0, mu odd in v. Sliding begins when |v| first exceeds the
 *              threshold v_t of the friction law: below it the smooth law creeps where dry
 *              friction sticks
 *   re-arming  the beak's end is under the roof and overlaps it, for good
 *
 * Poses come from the generated equations, as the notch in the core takes them.
 */
#include <math.h>
#include <stdlib.h>

#include "stein/law.h"
#include "study.h"

static const double knock = 3e-3; /* shorter forces are no touch [s] */

typedef struct instant {
    double t, finger, overlap, speed, power;
    int phase, armed;
} instant;

typedef struct trace {
    const study *s;
    const stein_model *m;
    instant *at;
    int n, room;
    int overlap, notch_force, finger; /* channels */
    double finger_scale;
    double *p, *d, *sc;
    stein_pose *pose;
    const study_watch *watch;
} trace;

study_drive study_drive_default(void)
{
    return (study_drive){STUDY_LOAD, 0.05, 1.0, 0.13, NAN};
}

/* ---- the key's prescribed motion ---- */

void study_motion(study_touch touch, double u, double s[3])
{
    if (u >= 1.0 || u <= 0.0) {
        s[0] = u >= 1.0 ? 1.0 : 0.0;
        s[1] = s[2] = 0.0;
        if (u == 0.0 && touch == STUDY_STRUCK) {
            s[1] = 2.0;
            s[2] = -2.0;
        }
    } else if (touch == STUDY_STEADY) {
        double a = 0.2, f = 1.0 / (1.0 - 0.5 * a); // even from u = a on
        s[0] = u < a ? 0.5 * f * u * u / a : f * (u - 0.5 * a);
        s[1] = u < a ? f * u / a : f;
        s[2] = u < a ? f / a : 0.0;
    } else if (touch == STUDY_STRUCK) {
        s[0] = u * (2.0 - u);
        s[1] = 2.0 - 2.0 * u;
        s[2] = -2.0;
    } else {
        s[0] = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
        s[1] = 30.0 * u * u * (1.0 - u) * (1.0 - u);
        s[2] = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
    }
}

static void key_signal(void *ctx, double t, double u[3])
{
    const study_key *k = ctx;
    double s[3], way = k->depth * (k->s->key_down - k->s->key_rest);
    study_motion(k->touch, t / k->travel, s);
    u[0] = k->s->key_rest + way * s[0];
    u[1] = way * s[1] / k->travel;
    u[2] = way * s[2] / (k->travel * k->travel);
}

/* ---- the trace ---- */

static double plain(stein_sim *sim, int channel)
{
    return channel < 0 ? NAN
                       : stein_sim_model(sim)->channels[channel].sign * stein_read(sim, channel);
}

/* sliding of the beak's face on the corner [m/s] and the friction's power there [W] */
static void slide(const trace *r, stein_sim *sim, instant *now)
{
    static const stein_pose fixed = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0};
    const stein_notch *n = &r->m->notches[r->m->stroke.notch];
    const double *d = r->d + n->d;
    stein_turn(r->m, stein_q(sim), r->sc);
    r->m->pose(stein_q(sim), stein_qd(sim), r->sc, r->d, r->pose);
    const stein_pose *c = n->catcher < 0 ? &fixed : &r->pose[n->catcher];
    const stein_pose *b = n->beak < 0 ? &fixed : &r->pose[n->beak];
    double x = c->x + c->c * d[STEIN_NOTCH_CX] - c->s * d[STEIN_NOTCH_CZ];
    double z = c->z + c->s * d[STEIN_NOTCH_CX] + c->c * d[STEIN_NOTCH_CZ];
    double vx = b->vx - b->w * (z - b->z) - (c->vx - c->w * (z - c->z));
    double vz = b->vz + b->w * (x - b->x) - (c->vz + c->w * (x - c->x));
    double bx = b->c * d[STEIN_NOTCH_BX] - b->s * d[STEIN_NOTCH_BZ];
    double bz = b->s * d[STEIN_NOTCH_BX] + b->c * d[STEIN_NOTCH_BZ];
    double force = plain(sim, r->notch_force);
    now->speed = vx * bx + vz * bz;
    now->power = n->friction >= 0 && force > 0.0
                     ? force * stein_friction(r->d + n->friction, now->speed) * now->speed
                     : 0.0;
}

static stein_status take(void *ctx, stein_sim *sim)
{
    trace *r = ctx;
    if (r->n == r->room) {
        int room = r->room == 0 ? 8192 : 2 * r->room;
        instant *at = realloc(r->at, sizeof *at * (size_t)room);
        if (at == NULL) {
            return STEIN_ENOMEM;
        }
        r->at = at;
        r->room = room;
    }
    instant *now = &r->at[r->n++];
    int notch = r->m->stroke.notch;
    *now = (instant){.t = stein_time(sim),
                     .finger = r->finger_scale * plain(sim, r->finger),
                     .overlap = plain(sim, r->overlap),
                     .phase = stein_notch_phase(sim, notch),
                     .armed = stein_notch_armed(sim, notch)};
    if (now->phase >= 1 && now->phase <= 3) {
        slide(r, sim, now);
    }
    return r->watch != NULL ? r->watch->sample(r->watch->ctx, sim) : STEIN_OK;
}

static stein_status begin(trace *r, const study *s, stein_sim *sim, study_touch touch)
{
    const stein_model *m = stein_sim_model(sim);
    *r = (trace){.s = s, .m = m, .finger_scale = 1.0};
    r->overlap = lab__channel_of(m, STEIN_READ_NOTCH_OVERLAP, m->stroke.notch);
    r->notch_force = lab__channel_of(m, STEIN_READ_NOTCH_FORCE, m->stroke.notch);
    r->finger = touch == STUDY_LOAD ? lab__channel_of(m, STEIN_READ_FORCE, m->load.contact)
                                    : lab__channel_of(m, STEIN_READ_INPUT_FORCE, s->input);
    r->finger_scale = touch == STUDY_LOAD ? 1.0 : 1.0 / s->arm;
    r->p = malloc(sizeof *r->p * (size_t)(m->np + 1));
    r->d = malloc(sizeof *r->d * (size_t)(m->nd + 1));
    r->sc = malloc(2 * sizeof *r->sc * (size_t)m->nq);
    r->pose = malloc(sizeof *r->pose * (size_t)(m->nframe + 1));
    if (r->p == NULL || r->d == NULL || r->sc == NULL || r->pose == NULL) {
        return STEIN_ENOMEM;
    }
    for (int i = 0; i < m->np; i++) {
        stein_get(sim, m->params[i].name, &r->p[i], NULL);
    }
    stein_setup(m, r->p, r->d);
    return STEIN_OK;
}

static void end(trace *r)
{
    free(r->at);
    free(r->p);
    free(r->d);
    free(r->sc);
    free(r->pose);
}

/* ---- judging it ---- */

/* largest mean over `knock` that ends between two times */
static double largest_finger(const trace *r, double from, double to)
{
    double most = NAN, sum = 0.0;
    int first = 0;
    for (int i = 0; i < r->n && r->at[i].t <= to; i++) {
        sum += r->at[i].finger;
        while (r->at[i].t - r->at[first].t > knock) {
            sum -= r->at[first++].finger;
        }
        most =
            r->at[i].t >= from ? fmax(most, sum / (i - first + 1)) : most; // fmax passes over NAN
    }
    return most;
}

static void judge_escapement(const trace *r, study_details *details)
{
    const stein_model *m = r->m;
    double escape = details->stroke.escaped ? details->stroke.escape_time : INFINITY,
           threshold = INFINITY;
    int friction = m->notches[m->stroke.notch].friction, first = -1, last = -1;
    if (friction >= 0) {
        threshold = r->d[friction + STEIN_FRICTION_VT];
    }
    if (details->stroke.escaped) {
        details->key_force = largest_finger(r, 0.5 * escape, escape);
    }
    if (details->stroke.forced_escapement) {
        details->forced_force = largest_finger(r, details->stroke.impact_time, escape);
    }
    for (int i = 0; i < r->n && r->at[i].t <= escape; i++) {
        if (first < 0 && r->at[i].phase == 3 && fabs(r->at[i].speed) > threshold) {
            first = i;
        }
        last = i;
    }
    if (first < 0 || !details->stroke.escaped) {
        return;
    }
    double work = r->at[last].power * (escape - r->at[last].t);
    for (int i = first; i < last; i++) {
        work += 0.5 * (r->at[i].power + r->at[i + 1].power) * (r->at[i + 1].t - r->at[i].t);
    }
    details->slip_start = r->at[first].t;
    details->slip_time = escape - r->at[first].t;
    details->slip_work = work;
}

static void judge_rearming(const trace *r, double release, study_details *details)
{
    int i = r->n - 1;
    while (i >= 0 && r->at[i].armed && r->at[i].t >= release) {
        i--;
    }
    if (i < r->n - 1 && details->stroke.rearmed) {
        details->rearm_time = r->at[i + 1].t - release;
        details->rearm_margin = r->at[r->n - 1].overlap;
    }
}

void study_strike(const study *s, stein_sim *sim, const study_drive *drive,
                  const study_watch *watch, study_details *details)
{
    trace r = {0};
    study_key key = {s, drive->touch, drive->travel, drive->depth};
    const char *input = s->input >= 0 ? lab_equations(s->model)->inputs[s->input].name : NULL;
    int driven = drive->touch != STUDY_LOAD;
    *details = (study_details){.key_force = NAN,
                               .forced_force = NAN,
                               .slip_start = NAN,
                               .slip_time = NAN,
                               .slip_work = NAN,
                               .rearm_time = NAN,
                               .rearm_margin = NAN};
    details->status = driven && input == NULL ? STEIN_ENAME : begin(&r, s, sim, drive->touch);
    if (details->status != STEIN_OK) {
        end(&r);
        return;
    }
    r.watch = watch;
    if (driven) {
        stein_drive(sim, input, key_signal, &key, NULL);
    }
    details->status = stein_reset(sim, NULL);
    if (driven) {
        stein_load_lift(sim);
    }
    // a release at the very end costs nothing and spares the look ahead at re-arming
    lab_stroke_def def = {
        .until = drive->until, .release = driven ? NAN : drive->until, .sample = take, .ctx = &r};
    def.release = !driven && isfinite(drive->release) ? drive->release : def.release;
    if (details->status == STEIN_OK) {
        details->status = lab_strike(sim, &def, &details->stroke, NULL);
    }
    if (driven) {
        stein_drive(sim, input, NULL, NULL, NULL);
    }
    if (details->status == STEIN_OK) {
        judge_escapement(&r, details);
        if (isfinite(drive->release)) {
            judge_rearming(&r, drive->release, details);
        }
    }
    end(&r);
}
