/* SPDX-License-Identifier: GPL-3.0-or-later
 * static_escapement.c - the static ("geometric") escapement height: the key pressed infinitely
 * slowly.
 *
 * The key is held at a growing angle; at each the hammer and the pawl find their static equilibrium
 * next to the one before (continuation, stein_settle). In equilibrium nothing slides, so friction
 * has no part in it: a technician's feeler gauge would find this on a dry, slowly moved action. The
 * last equilibrium with the beak under the roof is bracketed by halving the last step of the key. A
 * slow prescribed motion was tried instead: it never stops creeping on the smooth friction law and
 * needs seconds of simulated time.
 */
#include <math.h>
#include <stdlib.h>

#include "study.h"

enum { STEPS = 80, HALVINGS = 30 };
static const double beyond = 1.4; /* the finger may go so much deeper than the load */
static const double at_the_corner =
    0.05e-3; /* overlap at which an end of the chain is escapement [m] */

static void hold(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = *(const double *)ctx;
    u[1] = u[2] = 0.0;
}

/* readings at the present equilibrium */
typedef struct reading {
    int gap, overlap, dip, force;
} reading;

static int is_engaged(stein_sim *sim, int notch)
{
    return stein_settle(sim, NULL) == STEIN_OK && stein_notch_armed(sim, notch);
}

static void note(const study *s, stein_sim *sim, const reading *r, study_static *statics)
{
    const stein_model *m = lab_equations(s->model);
    statics->height = fmax(0.0, m->channels[r->gap].sign * stein_read(sim, r->gap));
    statics->dip = stein_read(sim, r->dip);
    if (r->force >= 0) {
        statics->force =
            fmax(statics->force, m->channels[r->force].sign * stein_read(sim, r->force) / s->arm);
    }
}

static void follow(const study *s, stein_sim *sim, double *angle, const reading *r, void *kept,
                   study_static *statics)
{
    int notch = lab_equations(s->model)->stroke.notch, touched = 0;
    double way = s->key_down - s->key_rest, step = way / STEPS, good = s->key_rest;
    stein_save(sim, kept);
    for (int i = 1; i <= (int)(beyond * STEPS) + HALVINGS; i++) {
        *angle = good + step;
        if (is_engaged(sim, notch)) {
            good = *angle;
            touched |= stein_notch_phase(sim, notch) > 0;
            note(s, sim, r, statics);
            stein_save(sim, kept);
        } else {
            step *= 0.5;
            stein_restore(sim, kept, NULL);
        }
        if ((good - s->key_rest) / way > beyond || fabs(step) < 1e-8 * fabs(way)) {
            break;
        }
    }
    *angle = good;
    stein_settle(sim, NULL);
    double s_end = lab_equations(s->model)->channels[r->overlap].sign * stein_read(sim, r->overlap);
    statics->escaped = touched && fabs(step) < 1e-6 * fabs(way) && s_end < at_the_corner;
}

void study_press_slowly(const study *s, stein_sim *sim, study_static *statics)
{
    const stein_model *m = lab_equations(s->model);
    *statics = (study_static){.status = STEIN_OK, .height = NAN, .dip = NAN, .force = 0.0};
    const reading r = {lab__channel_of(m, STEIN_READ_GAP, m->stroke.string),
                       lab__channel_of(m, STEIN_READ_NOTCH_OVERLAP, m->stroke.notch),
                       stein_find_channel(m, "key_dip"),
                       lab__channel_of(m, STEIN_READ_INPUT_FORCE, s->input)};
    if (s->input < 0 || r.gap < 0 || r.overlap < 0 || r.dip < 0) {
        statics->status = STEIN_ENAME;
        return;
    }
    double angle = s->key_rest;
    void *kept = malloc(stein_state_size(sim));
    statics->status = kept == NULL ? STEIN_ENOMEM : stein_reset(sim, NULL);
    if (statics->status == STEIN_OK) {
        stein_load_lift(sim);
        statics->status = stein_drive(sim, m->inputs[s->input].name, hold, &angle, NULL);
    }
    if (statics->status == STEIN_OK) {
        follow(s, sim, &angle, &r, kept, statics);
        stein_drive(sim, m->inputs[s->input].name, NULL, NULL, NULL);
    }
    if (!statics->escaped) {
        statics->height = NAN;
    }
    free(kept);
}
