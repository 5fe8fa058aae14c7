/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion_check.c - the verdict once more, from a prescribed motion and the force that it needs.
 *
 * Strokes driven by a load are compared in position, and a mechanism filters that: a model that is
 * wrong in its forces may fit them (Masoudi & Birkett 2015; Thorin 2014). So the measured motion is
 * prescribed to the driven joint, and the rest is simulated. The force that this motion needs is
 * compared with the force that acted, in the model as it is and in the extended one. The
 * accelerations are those of a smoothed position. The uncertainty of the force is that of the same
 * check on simulated strokes with known forces (motion_judge.c); it may exceed the force.
 *
 * The check reports and does not change the verdict. Its cost is one simulation of a stroke for
 * each model, and three for each draw of noise.
 */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "motion.h"

enum { DRAWS = 8, SEED = 1788, TRIALS = 3, BLOCKS = 24, MOST_DECADES = 12 };

const char *lab_motion_text(lab_motion_says says)
{
    static const char *const text[] = {"not_done", "supports", "contradicts", "cannot_tell"};
    return text[says];
}

void diag__motion_free(lab_motion *m)
{
    free(m->row);
    free(m->t);
    *m = (lab_motion){.row = NULL};
}

/* ---- the runs ---- */

typedef struct check {
    diag__side side[2];
    int nside;
    diag__way way[2];
    fit__problem with[2];
    double *noise, *decades; /* [nstroke] of the motion, and how it is smoothed */
    double *input_noise;     /* of all signals of all strokes */
    diag__runs runs;
    double *memory;
    int model;           /* of these runs */
    int *run, jobs_each; /* runs of that model */
} check;

static int model_of(int run)
{
    return run < MOTION_DRAWS ? run : (run - MOTION_DRAWS) % MOTION_KINDS == MOTION_11;
}

/* the model that makes the stroke of a run; -1: it is measured */
static int maker_of(int run)
{
    return run < MOTION_DRAWS ? -1 : (run - MOTION_DRAWS) % MOTION_KINDS != MOTION_00;
}

/* a stroke as a model makes it: predictions of all channels and noise. Missing samples stay so. */
static void make_channels(const diag__side *by, int stroke, gsl_rng *rng, double *y)
{
    const fit__stroke *t = &by->p->stroke[stroke];
    const double *r = by->r + fit__offset(by->p, stroke);
    for (int i = 0; i < t->nch * t->n; i++) {
        y[i] = t->y[i] - fit__off(t, r, i) + gsl_ran_gaussian(rng, t->noise[i / t->n]);
    }
}

static const fit__signal *recorded(const fit__stroke *t, int input)
{
    int k = 0;
    while (t->signal[k].input != input) {
        k++;
    }
    return &t->signal[k];
}

/* where the signals of a stroke begin among those of all */
static size_t first_signal(const fit__problem *p, int stroke)
{
    size_t n = 0;
    for (int s = 0; s < stroke; s++) {
        n += (size_t)p->stroke[s].nsignal;
    }
    return n;
}

/* motion and data of a run. @param room  [nch*n + knots]  @return 0: as it was measured and
 * smoothed */
static void tell(const check *c, int run, int stroke, double *room, diag__told *told)
{
    int maker = maker_of(run), draw = (run - MOTION_DRAWS) / MOTION_KINDS;
    const fit__problem *p = c->side[0].p;
    const fit__stroke *t = &p->stroke[stroke];
    const diag__way *way = &c->way[0];
    gsl_rng *rng = maker >= 0 ? gsl_rng_alloc(gsl_rng_mt19937) : NULL;
    *told = (diag__told){.y = t->y, .noise = c->noise[stroke], .decades = c->decades[stroke]};
    if (rng != NULL) {
        gsl_rng_set(rng,
                    SEED + (unsigned long)stroke + (unsigned long)draw * (unsigned long)p->nstroke);
        make_channels(&c->side[maker], stroke, rng, room);
        told->force_noise = c->input_noise + first_signal(p, stroke);
        told->seed = gsl_rng_get(rng);
        told->y = room;
    }
    if (way->channel >= 0) {
        told->motion = told->y + (size_t)way->slot * (size_t)t->n;
    } else if (rng != NULL) {
        const fit__signal *s = recorded(t, way->input);
        double *u = room + (size_t)t->nch * (size_t)t->n;
        for (int i = 0; i < s->n; i++) {
            u[i] = s->g[i] + gsl_ran_gaussian(rng, told->noise);
        }
        told->motion = u;
    }
    gsl_rng_free(rng);
}

static void one_run(void *ctx, fit__bench *b, int job)
{
    const check *c = ctx;
    int nstroke = c->side[0].p->nstroke, run = c->run[job / nstroke], stroke = job % nstroke;
    const fit__stroke *t = &c->side[0].p->stroke[stroke];
    double *room = malloc(sizeof *room * ((size_t)(t->nch + 1) * (size_t)(t->n + 1)));
    diag__told told;
    if (room == NULL) {
        b->no_memory = 1;
        return;
    }
    tell(c, run, stroke, room, &told);
    diag__motion_run(&c->side[c->model], &c->with[c->model], &c->way[c->model], b, stroke, &told,
                     &c->runs.course[run * nstroke + stroke]);
    free(room);
}

/* room for all courses, frames unknown */
static stein_status make_courses(check *c, stein_err *err)
{
    const fit__problem *p = c->side[0].p;
    int nrun = MOTION_DRAWS + MOTION_KINDS * c->runs.draws;
    size_t doubles = 0;
    for (int s = 0; s < p->nstroke; s++) {
        doubles += (size_t)nrun * (size_t)(p->stroke[s].nch + 2) * (size_t)p->stroke[s].n +
                   (size_t)p->stroke[s].n;
    }
    c->runs.course = calloc((size_t)(nrun * p->nstroke) + 1, sizeof *c->runs.course);
    c->memory = malloc(sizeof *c->memory * (doubles + 1));
    c->run = calloc((size_t)nrun + 1, sizeof *c->run);
    if (c->runs.course == NULL || c->memory == NULL || c->run == NULL) {
        return lab__no_memory(err);
    }
    double *at = c->memory;
    for (size_t i = 0; i < doubles; i++) {
        at[i] = NAN;
    }
    for (int run = 0; run < nrun; run++) {
        for (int s = 0; s < p->nstroke; s++) {
            diag__course *to = &c->runs.course[run * p->nstroke + s];
            size_t n = (size_t)p->stroke[s].n;
            to->time = at;
            to->error = at + n;
            to->y = at + 2 * n;
            at += (size_t)(p->stroke[s].nch + 2) * n;
            if (run == MOTION_BEFORE) {
                to->present = at;
                at += n;
            }
        }
    }
    return STEIN_OK;
}

/* all runs of one model */
static stein_status run_model(check *c, int model, stein_err *err)
{
    int n = 0, nrun = MOTION_DRAWS + MOTION_KINDS * c->runs.draws;
    stein_status status = diag__motion_open(c->side[model].p, &c->with[model], err);
    for (int run = 0; run < nrun; run++) {
        if (model_of(run) == model && maker_of(run) < c->nside) {
            c->run[n++] = run;
        }
    }
    c->model = model;
    return status == STEIN_OK
               ? fit__parallel(&c->with[model], n * c->side[0].p->nstroke, one_run, c, err)
               : status;
}

/* mean squares of the error of the acceleration in blocks behind t = 0, when a motion u that is
 * known is smoothed with noise on it: the sum of their logarithms, as a force is known from all of
 * them */
static double smoothing_error(const fit__stroke *t, const double *u, const fit__signal *clean,
                              double noise, double decades, double *room)
{
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double sum[BLOCKS] = {0.0}, score = 0.0;
    for (int k = 0; rng != NULL && k < TRIALS; k++) {
        fit__signal s;
        gsl_rng_set(rng, SEED + (unsigned long)k);
        for (int i = 0; i < t->n; i++) {
            room[i] = u[i] + gsl_ran_gaussian(rng, noise);
        }
        if (fit__signal_through(&s, 0, t->data->time, room, t->n, noise, decades, NULL) ==
            STEIN_OK) {
            for (int i = 0; i < s.n; i++) {
                double e = 2.0 * (s.piece[i].a[2] - clean->piece[i].a[2]);
                sum[i * BLOCKS / s.n] += s.t[i] > t->origin ? e * e : 0.0;
            }
        }
        fit__signal_free(&s);
    }
    for (int b = 0; b < BLOCKS; b++) {
        score += sum[b] > 0.0 ? stein__log_of(sum[b]) : 0.0;
    }
    gsl_rng_free(rng);
    return rng != NULL ? score : (double)INFINITY;
}

/* How far the motion of a stroke is smoothed: for all of its runs the same, and best for the motion
 * that the model predicts. What the noise of a record allows depends on that noise too much: a
 * sample of it a little smaller than stated, and nothing is smoothed. */
static double choose_smoothing(const check *c, int stroke)
{
    const fit__stroke *t = &c->side[0].p->stroke[stroke];
    const double *r = c->side[0].r + fit__offset(c->side[0].p, stroke);
    size_t from = (size_t)c->way[0].slot * (size_t)t->n;
    double *u = malloc(sizeof *u * 2 * (size_t)(t->n + 1)), best = NAN, least = INFINITY;
    fit__signal clean = {.t = NULL};
    for (int i = 0; u != NULL && i < t->n; i++) {
        u[i] = t->y[from + (size_t)i] - fit__off(t, r, (int)from + i);
    }
    if (u != NULL &&
        fit__signal_through(&clean, 0, t->data->time, u, t->n, 0.0, NAN, NULL) == STEIN_OK) {
        for (int half = 0; half <= 2 * MOST_DECADES; half++) {
            double d = 0.5 * half;
            double e = smoothing_error(t, u, &clean, c->noise[stroke], d, u + t->n);
            best = e < least ? d : best;
            least = fmin(least, e);
        }
    }
    fit__signal_free(&clean);
    free(u);
    return best;
}

static void take_input_noise(check *c, int stroke)
{
    const fit__stroke *t = &c->side[0].p->stroke[stroke];
    for (int k = 0; k < t->nsignal; k++) {
        c->input_noise[first_signal(c->side[0].p, stroke) + (size_t)k] = t->signal[k].noise;
    }
}

/* noise of the motions and of the forces */
static stein_status find_noise(check *c, stein_err *err)
{
    const fit__problem *p = c->side[0].p;
    const diag__way *way = &c->way[0];
    c->noise = calloc(2 * (size_t)p->nstroke + 1, sizeof *c->noise);
    c->input_noise = calloc(first_signal(p, p->nstroke) + 1, sizeof *c->input_noise);
    stein_status status =
        c->noise != NULL && c->input_noise != NULL ? STEIN_OK : lab__no_memory(err);
    c->decades = c->noise + (c->noise != NULL ? p->nstroke : 0);
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        take_input_noise(c, s);
        if (way->channel >= 0) {
            c->noise[s] = t->noise[way->slot];
            c->decades[s] = choose_smoothing(c, s);
        } else {
            const fit__signal *motion = recorded(t, way->input);
            c->noise[s] = c->input_noise[first_signal(p, s) + (size_t)(motion - t->signal)];
            c->decades[s] = motion->decades;
        }
    }
    return status;
}

static void free_check(check *c)
{
    for (int i = 0; i < 2; i++) {
        if (c->with[i].stroke != NULL) {
            free(c->with[i].stroke[0].signal);
            free(c->with[i].stroke);
        }
    }
    free(c->noise);
    free(c->input_noise);
    free(c->runs.course);
    free(c->memory);
    free(c->run);
}

/* ---- result ---- */

static void name_it(const check *c, lab_motion *out)
{
    const stein_model *m = lab_equations(c->side[0].p->model);
    const diag__way *way = &c->way[0];
    out->input = m->inputs[way->input].name;
    out->joint = m->bodies[way->joint].name;
    out->force = m->channels[way->force].name;
    out->unit = m->channels[way->force].unit;
    out->channel = way->channel >= 0 ? m->channels[way->channel].name : NULL;
    out->draws = c->runs.draws;
}

/* One part that contradicts is enough; else the force decides, or all together where it cannot. */
static const char *conclude_extended(lab_motion *out)
{
    const lab_motion_part *f = &out->of_force, *c = &out->of_channels, *all = &out->all;
    const lab_motion_part *by = f->says == LAB_MOTION_CONTRADICTS     ? f
                                : all->says == LAB_MOTION_CONTRADICTS ? all
                                : c->says == LAB_MOTION_CONTRADICTS   ? c
                                : f->says == LAB_MOTION_SUPPORTS      ? f
                                                                      : all;
    out->says = by->says;
    if (by->says == LAB_MOTION_SUPPORTS) {
        return by == f ? "with what was found the force is nearer to the one that was there"
                       : "with what was found force and free channels are nearer to the data";
    }
    if (by->says == LAB_MOTION_CANNOT_TELL) {
        return "noise of the measured motion hides what was found";
    }
    return by->share < 0.5   ? (by == f ? "the force is nearer to the model without what was found"
                                        : "free channels are nearer to the model without what was "
                                          "found")
           : by->share > 1.5 ? "what was found is not what departs: it is off by a factor"
                             : "a good part of what departs stays with what was found";
}

static void conclude(const check *c, lab_verdict verdict, lab_motion *out)
{
    const lab_motion_part *f = &out->of_force;
    const char *why = NULL;
    if (out->strokes < 1 || !isfinite(f->before)) {
        out->says = LAB_MOTION_NOT_DONE;
        why = "under the measured motion no record can be simulated to its end";
    } else if (c->nside == 2) {
        why = conclude_extended(out);
    } else if (verdict == LAB_VERDICT_EXPLAINED) {
        out->says = f->says;
        why = out->says == LAB_MOTION_SUPPORTS ? "the force does not depart beyond its noise"
              : out->says == LAB_MOTION_CONTRADICTS
                  ? "the force departs by more than its noise"
                  : "noise of the measured motion is too large beside the force";
    } else { // more than noise, of unknown cause
        int departs = f->says == LAB_MOTION_CONTRADICTS || out->all.says == LAB_MOTION_CONTRADICTS;
        out->says = departs ? LAB_MOTION_SUPPORTS : LAB_MOTION_CANNOT_TELL;
        why = departs ? "under the measured motion, too, more departs than noise makes"
                      : "under the measured motion nothing departs by more than noise makes";
    }
    snprintf(out->why, sizeof out->why, "%s", why);
}

stein_status diag__motion_check(const diag__side *before, const diag__side *after,
                                const char *const *phase, lab_verdict verdict, int nfit,
                                lab_motion *out, stein_err *err)
{
    check c = {.side = {*before}, .nside = after != NULL ? 2 : 1};
    *out = (lab_motion){.says = LAB_MOTION_NOT_DONE};
    if (verdict == LAB_VERDICT_NOT_CONVERGED) {
        snprintf(out->why, sizeof out->why, "no fit has converged, there is nothing to check");
        return STEIN_OK;
    }
    if (!diag__motion_way(before, &c.way[0], out->why, sizeof out->why)) {
        return STEIN_OK;
    }
    if (after != NULL) {
        c.side[1] = *after;
        if (!diag__motion_same(&c.way[0], before->p, after->p, &c.way[1])) {
            snprintf(out->why, sizeof out->why, "the extended mechanism shows that motion no more");
            return STEIN_OK;
        }
    }
    c.runs = (diag__runs){.p = before->p,
                          .way = &c.way[0],
                          .phase = phase,
                          .draws = DRAWS,
                          .extended = after != NULL,
                          .wide = nfit > 0 ? 1.0 + (double)before->p->nstroke / nfit : 1.0};
    stein_status status = find_noise(&c, err);
    status = status == STEIN_OK ? make_courses(&c, err) : status;
    for (int i = 0; status == STEIN_OK && i < c.nside; i++) {
        status = run_model(&c, i, err);
    }
    status = status == STEIN_OK ? diag__motion_judge(&c.runs, out, err) : status;
    if (status == STEIN_OK) {
        name_it(&c, out);
        conclude(&c, verdict, out);
    }
    free_check(&c);
    return status;
}
