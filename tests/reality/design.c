/* SPDX-License-Identifier: GPL-3.0-or-later
 * design.c - the strokes of a set, the true parameters, the scatter from stroke to stroke.
 *
 * Twelve strokes to fit: three loads by three positions of the stop, three of them repeated. Six
 * held out: two repeats, three in between, one beyond the fitted range. The stop stays where
 * strokes are regular: from about 0 on a loud one may hang between escaping and not. Where an input
 * is in question the load is 5 g (less than the key's own return) and a finger's force or a
 * prescribed motion plays.
 *
 * A set of twins is made with one regulation and one load: all eighteen strokes are the same one.
 * Effects that only another load or another position of the stop would separate are not separated.
 *
 * Truth: every number that has a tolerance in the file is off by a normal deviate of that
 * tolerance, at most two of them and at most 10 %. Scatter: one factor a stroke on all joint
 * frictions and one on all contact frictions (3 to 10 %), 0.3 % on the drive, 50 us on the trigger.
 */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

#include "reality.h"

const camera standard_camera = {.rate = 4000.0,
                                .pixel = 20e-6,
                                .arm = 0.1,
                                .before = 0.005,
                                .until = 0.12,
                                .seen = 2,
                                .accuracy = 1e-10};

/* dx [mm] and load [g], or finger force [N] and key motion [rad] in the place of the load */
typedef struct plan {
    double dx, load, force, angle;
} plan;

static const plan plans[STROKES] = {
    {-0.7, 70.0, 1.2, 0.036},  {-0.7, 100.0, 1.6, 0.039},   {-0.7, 140.0, 2.2, 0.041},
    {-0.4, 70.0, 1.2, 0.036},  {-0.4, 100.0, 1.6, 0.039},   {-0.4, 140.0, 2.2, 0.041},
    {-0.1, 70.0, 1.2, 0.036},  {-0.1, 100.0, 1.6, 0.039},   {-0.1, 140.0, 2.2, 0.041},
    {-0.4, 100.0, 1.6, 0.039}, {-0.1, 140.0, 2.2, 0.041},   {-0.7, 70.0, 1.2, 0.036},
    {-0.4, 100.0, 1.6, 0.039}, {-0.1, 70.0, 1.2, 0.036},    {-0.55, 120.0, 1.9, 0.040},
    {-0.2, 85.0, 1.4, 0.038},  {-0.25, 110.0, 1.7, 0.0395}, {-0.5, 190.0, 3.0, 0.042}};

void design_strokes(design *d, int touch)
{
    memset(d->stroke, 0, sizeof d->stroke);
    d->touch = touch;
    for (int i = 0; i < STROKES; i++) {
        const plan *p = &plans[i];
        setting *s = &d->stroke[i];
        s->dx = 1e-3 * p->dx;
        s->load = touch > 0 ? 5e-3 : 1e-3 * p->load;
        s->touch = touch;
        s->touch_size = touch == 1 ? p->force : touch == 2 ? p->angle : 0.0;
        s->touch_time = touch == 1 ? 0.02 : touch == 2 ? 0.08 - 0.3 * (p->force - 1.0) * 0.05 : 0.0;
    }
}

void design_alike(design *d, int like)
{
    setting one = d->stroke[like];
    for (int i = 0; i < STROKES; i++) {
        d->stroke[i] = one;
    }
}

/* a whole pixel is rounded away; before it, half a pixel of noise */
double camera_noise(const camera *c, int channel)
{
    return c->pixel * sqrt(0.25 + 1.0 / 12.0) / (channel == 2 ? c->arm : 1.0);
}

void design_differ(const design *d, setting *s, gsl_rng *rng)
{
    double joints = gsl_ran_gaussian(rng, d->joint_scatter);
    double contacts = gsl_ran_gaussian(rng, d->contact_scatter);
    double drive = gsl_ran_gaussian(rng, d->drive_scatter);
    s->joint_friction = d->scatter ? fmax(joints, -0.5) : 0.0;
    s->contact_friction = d->scatter ? fmax(contacts, -0.5) : 0.0;
    s->drive = d->scatter ? drive : 0.0;
    s->trigger = (gsl_rng_uniform(rng) - 0.5) / d->camera.rate + gsl_ran_gaussian(rng, d->jitter);
}

void design_scatter(design *d, gsl_rng *rng)
{
    double marker[SEEN];
    for (int j = 0; j < SEEN; j++) {
        marker[j] = gsl_ran_gaussian(rng, d->marker) / (j == 2 ? d->camera.arm : 1.0);
    }
    for (int i = 0; i < STROKES; i++) {
        setting *s = &d->stroke[i];
        design_differ(d, s, rng);
        for (int j = 0; j < SEEN; j++) {
            double again = gsl_ran_gaussian(rng, 0.05 * d->marker);
            s->offset[j] = marker[j] + again / (j == 2 ? d->camera.arm : 1.0);
        }
    }
}

void design_truth(const design *d, world *w, gsl_rng *rng)
{
    for (int i = 0; i < w->m->nparam; i++) {
        const mech_param *p = &w->m->params[i];
        double u = gsl_ran_gaussian(rng, 1.0);
        u = fmin(fmax(u, -2.0), 2.0) * p->tolerance;
        u = fmin(fmax(u, -0.1 * fabs(p->value)), 0.1 * fabs(p->value));
        w->p[i] = p->value + (d->wrong_start ? u : 0.0);
    }
}
