/* SPDX-License-Identifier: GPL-3.0-or-later
 * next.c - a requested stroke, filmed in the same laboratory: numbers of the file set (a load, the
 * stop, a heavier body, no string, no wire), an input driven (rise, there_and_back), another rate,
 * one marker more. What this laboratory has not is refused in one line.
 */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reality.h"

enum { REFUSED = 3, NAME = 100 };

static int refuse(const char *what, const char *name)
{
    fprintf(stderr, "reality: cannot be filmed: %s%s\n", what, name);
    return REFUSED;
}

const char *const off_name[OFF] = {"key_wire.k", "key_damper.normal.F0"};

/* "key_wire.k", 0: the key is played without. @return 1: it is such a name */
static int take_off(const char *name, double value, setting *s)
{
    for (int i = 0; i < OFF; i++) {
        if (strcmp(name, off_name[i]) == 0 && value == 0.0) {
            s->off[i] = 1;
            return 1;
        }
    }
    return 0;
}

/* NAME=VALUE */
static int take_set(const char *text, const world *w, setting *s)
{
    char name[NAME], *end;
    const char *equals = strchr(text, '=');
    size_t n = equals != NULL ? (size_t)(equals - text) : 0;
    if (n == 0 || n >= sizeof name) {
        return refuse("expected NAME=VALUE, not ", text);
    }
    memcpy(name, text, n);
    name[n] = '\0';
    double value = strtod(equals + 1, &end);
    if (end == equals + 1 || *end != '\0' || !isfinite(value)) {
        return refuse("no number: ", text);
    }
    int param = mech_find_param(w->m, name, NULL);
    if (strcmp(name, "pawl.stop_shift") == 0) {
        s->dx = value;
    } else if (strcmp(name, "load.mass") == 0) {
        s->load = value;
    } else if (take_off(name, value, s)) {
        return 0;
    } else if (param < 0) {
        return refuse("no number of the action: ", name);
    } else if (s->nset == OVERRIDES) {
        return refuse("too many numbers are set: ", name);
    } else {
        s->set[s->nset++] = (override){param, value};
    }
    return 0;
}

/* INPUT,SHAPE,SIZE,TIME */
static int take_drive(const char *text, setting *s)
{
    char input[NAME], shape[NAME], more;
    if (sscanf(text, "%99[^,],%99[^,],%lf,%lf%c", input, shape, &s->touch_size, &s->touch_time,
               &more) != 4 ||
        !isfinite(s->touch_size) || !(s->touch_time > 0.0)) {
        return refuse("expected INPUT,SHAPE,SIZE,TIME, not ", text);
    }
    s->touch = strcmp(input, "finger") == 0 ? 1 : strcmp(input, "key_motion") == 0 ? 2 : 0;
    s->touch_back = strcmp(shape, "there_and_back") == 0;
    if (s->touch == 0) {
        return refuse("no such input here: ", input);
    }
    return s->touch_back || strcmp(shape, "rise") == 0 ? 0 : refuse("no such shape: ", shape);
}

/* what differs from stroke to stroke; markers that were placed again */
static void scatter(const design *d, setting *s, gsl_rng *rng)
{
    design_differ(d, s, rng);
    for (int j = 0; j < SEEN; j++) {
        s->offset[j] = gsl_ran_gaussian(rng, d->marker) / (j == 2 ? d->camera.arm : 1.0);
    }
}

int next_write(const char *folder, const asked *q, const world *w, design *d, gsl_rng *scene,
               gsl_rng *noise)
{
    char path[4096];
    int load = mech_find_param(w->m, "load.mass", NULL);
    setting told = {.load = load >= 0 ? w->m->params[load].value : 0.0};
    int status = 0;
    for (int i = 0; status == 0 && i < q->nset; i++) {
        status = take_set(q->set[i], w, &told);
    }
    status = status == 0 && q->drive != NULL ? take_drive(q->drive, &told) : status;
    for (int i = 0; status == 0 && i < q->repeats; i++) {
        setting s = told;
        scatter(d, &s, scene);
        snprintf(path, sizeof path, "%s/next_%02d.csv", folder, i + 1);
        status = camera_write(path, w, d, &s, noise, NULL);
    }
    return status;
}
