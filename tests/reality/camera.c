/* SPDX-License-Identifier: GPL-3.0-or-later
 * camera.c - one film as a CSV file of measured data: pixels, noise, missing frames.
 *
 * Half a pixel of gaussian noise, then rounding to whole pixels. One frame in 200 is lost (no row),
 * one marker in 200 not found (empty cell). A file states an experimenter's knowledge: regulation,
 * load, noise of the camera, that the trigger runs by itself. A recorded input stands beside: the
 * finger's force (2 mN of noise) or the prescribed motion, both on the camera's clock.
 */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

#include "reality.h"

static const double lost = 0.005, not_found = 0.005, force_noise = 2e-3;

static void head(FILE *f, const world *w, const design *d, const setting *s)
{
    fprintf(f, "# set pawl.stop_shift: %.4g mm\n# set load.mass: %.4g g\n", 1e3 * s->dx,
            1e3 * s->load);
    for (int i = 0; i < s->nset; i++) {
        const mech_param *p = &w->m->params[s->set[i].param];
        fprintf(f, "# set %s: %.10g %s\n", p->name, s->set[i].value, p->unit);
    }
    for (int i = 0; i < OFF; i++) {
        if (s->off[i]) {
            fprintf(f, "# set %s: 0\n", off_name[i]);
        }
    }
    for (int j = 0; j < d->camera.seen; j++) {
        double noise = camera_noise(&d->camera, j);
        if (j < 2) {
            fprintf(f, "# noise %s: %.4g mm\n", seen_name[j], 1e3 * noise);
        } else {
            fprintf(f, "# noise %s: %.4g rad\n", seen_name[j], noise);
        }
    }
    fprintf(f, "# trigger: unsynchronised\ntime [s]");
    for (int j = 0; j < d->camera.seen; j++) {
        fprintf(f, ",%s [%s]", seen_name[j], seen_unit[j]);
    }
    fprintf(f, s->touch == 1 ? ",finger [N]\n" : s->touch == 2 ? ",key_motion [rad]\n" : "\n");
}

/* the input as recorded: what was meant, on the recorder's clock */
static double recorded(const setting *s, const film *shot, double t, double noise)
{
    action a = {
        .drive_size = s->touch_size, .drive_time = s->touch_time, .drive_back = s->touch_back};
    double u[3];
    hidden_touch(t - s->trigger, &a, u);
    return s->touch == 2 ? shot->key_rest + u[0] : u[0] + force_noise * noise;
}

static double pixels(double y, double pixel)
{
    double rounded = pixel * floor(y / pixel + 0.5);
    return fabs(rounded) > 0.0 ? rounded : 0.0; // no minus zero
}

static void row(FILE *f, const design *d, const setting *s, const film *shot, int i, gsl_rng *rng)
{
    const camera *c = &d->camera;
    double noise[SEEN], gone[SEEN], t = i / c->rate - c->before;
    int is_lost = gsl_rng_uniform(rng) < lost && i > 0;
    for (int j = 0; j < SEEN; j++) {
        noise[j] = gsl_ran_gaussian(rng, 0.5);
        gone[j] = gsl_rng_uniform(rng);
    }
    double force = gsl_ran_gaussian(rng, 1.0);
    if (is_lost) {
        return;
    }
    fprintf(f, "%.9g", t);
    for (int j = 0; j < c->seen; j++) {
        double pixel = c->pixel / (j == 2 ? c->arm : 1.0);
        if (gone[j] < not_found) {
            fprintf(f, ",");
        } else {
            fprintf(f, ",%.9g", pixels(shot->y[i][j] + noise[j] * pixel, pixel));
        }
    }
    if (s->touch > 0) {
        fprintf(f, ",%.12g", recorded(s, shot, t, force));
    }
    fprintf(f, "\n");
}

/* @param seen  what the stroke visits is added to it */
static int shoot(film *shot, const world *w, const design *d, const setting *s, visits *seen)
{
    stroke k;
    shot->y = shot->yd = NULL;
    if (film_play(&k, w, &w->hidden, w->p, s, &d->camera) != 0) {
        return -1;
    }
    int status = film_shoot(shot, &k, &w->hidden, s, &d->camera);
    if (seen != NULL) {
        visits_add(seen, &k.seen);
    }
    stroke_free(&k);
    return status;
}

int camera_write(const char *path, const world *w, const design *d, const setting *s, gsl_rng *rng,
                 visits *seen)
{
    film shot;
    if (shoot(&shot, w, d, s, seen) != 0) {
        fprintf(stderr, "reality: a stroke of %s cannot be computed\n", path);
        return -1;
    }
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        perror(path);
        film_free(&shot);
        return -1;
    }
    head(f, w, d, s);
    for (int i = 0; i < shot.n; i++) {
        row(f, d, s, &shot, i, rng);
    }
    film_free(&shot);
    return fclose(f) == 0 ? 0 : -1;
}
