/* SPDX-License-Identifier: GPL-3.0-or-later
 * check.c - an instrument looked at by itself.
 *
 * Where a tilted camera, a lens that bends and a wrong length are rivals, no stroke tells them
 * apart quickly: each moves the same marker by a fraction of the noise, and trigger, offset and
 * scatter of every stroke make up for most of that. A plumb line in the view tells it at once.
 *
 *   plumb line   its angle in the picture is the tilt          0.5 mrad
 *   scale        known values x = 0 .. reach at 11 places:     gauge blocks (0.15 um), weights
 *                reading = zero + (1 + error) x + k2 x^2       (1e-4 of the largest), each filmed
 *                with x from where the marker rests            for a second
 *   light        goes on at known instants, a hundred times:   a frame's interval / (10 sqrt 12)
 *   clock        beside another one, for a while               1e-5
 *
 * A side predicts the readings from the amount it was fitted with and its uncertainty; who says
 * nothing of that instrument predicts that it is right. They are readings like those of a stroke,
 * so odds.c says what they tell.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "planning.h"

static const double plumb = 5e-4;                    /* [rad] */
static const double gauge = 1.5e-7, gauge_arm = 0.1; /* [m], of an angle [m] */
static const double weights = 1e-4;                  /* of the largest force */
static const double looked_at = 1.0;                 /* each value [s] */
static const double flashes = 100.0, quartz = 1e-5;  /* number; relative */
static const double any_zero = 1e3;                  /* of a scale, in its noise */

typedef struct number {
    lab_check_by by;
    const char *tail; /* of the name */
    int power;        /* of the value at which a reading shows it */
} number;
static const number numbers[] = {{LAB_CHECK_LEVEL, ".sensor.tilt", 0},
                                 {LAB_CHECK_SCALE, ".sensor.gain", 1},
                                 {LAB_CHECK_SCALE, ".sensor.square", 2},
                                 {LAB_CHECK_LIGHT, ".sensor.delay", 0},
                                 {LAB_CHECK_CLOCK, "clock.error", 0}};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

/* what a parameter is a number of. @param of  channel, "": the clock; out @return NULL: of no
 * instrument that can be checked */
static const number *number_of(const char *param, char of[LAB_PLACE])
{
    size_t n = strlen(param);
    for (int k = 0; k < NUMBERS; k++) {
        size_t tail = strlen(numbers[k].tail);
        if (n >= tail && strcmp(param + n - tail, numbers[k].tail) == 0) {
            snprintf(of, LAB_PLACE, "%.*s", (int)(n - tail), param);
            return &numbers[k];
        }
    }
    return NULL;
}

/* ---- the list ---- */

static double noise_of(lab_check_by by, const plan__bench *b, const plan__eye *eye)
{
    double interval = b->d->conditions.interval;
    switch (by) {
    case LAB_CHECK_LEVEL: return plumb;
    case LAB_CHECK_LIGHT: return interval / sqrt(12.0 * flashes);
    case LAB_CHECK_CLOCK: return quartz;
    case LAB_CHECK_SCALE: break;
    }
    const char *unit = b->m->channels[stein_find_channel(b->m, eye->name)].unit;
    double scale = strcmp(unit, "m") == 0     ? gauge
                   : strcmp(unit, "rad") == 0 ? gauge / gauge_arm
                                              : weights * eye->reach;
    return hypot(scale, eye->noise * sqrt(fmin(1.0, interval / looked_at)));
}

/* the check that finds a number of the model. @return 0: there is none */
static int check_of(lab_check *c, const plan__bench *b, const char *param)
{
    char of[LAB_PLACE];
    const number *found = number_of(param, of);
    for (int i = 0; found != NULL && i < b->neye; i++) {
        const plan__eye *eye = &b->eye[i];
        if (found->by == LAB_CHECK_CLOCK || (eye->measured && strcmp(eye->name, of) == 0)) {
            *c = (lab_check){.by = found->by, .noise = noise_of(found->by, b, eye)};
            snprintf(c->of, sizeof c->of, "%s", of);
            c->reach = c->by == LAB_CHECK_SCALE ? eye->reach : 0.0;
            return c->noise > 0.0 && (c->by != LAB_CHECK_SCALE || c->reach > 0.0);
        }
    }
    return 0;
}

static int same(const lab_check *a, const lab_check *b)
{
    return a->by == b->by && strcmp(a->of, b->of) == 0;
}

int plan__checks(lab_check check[LAB_PLAN_CHECKS], const plan__bench *b, const plan__side *side,
                 int nside)
{
    int n = 0;
    for (int s = 0; s < nside; s++) {
        const lab_candidate *c = &side[s].candidate;
        for (int k = 0; k < c->nparam && n < LAB_PLAN_CHECKS; k++) {
            const char *param = lab_equations(side[s].model)->params[c->param[k]].name;
            int is_new = check_of(&check[n], b, param);
            for (int i = 0; is_new && i < n; i++) {
                is_new = !same(&check[i], &check[n]);
            }
            n += is_new;
        }
    }
    return n;
}

/* ---- in words ---- */

const char *plan__check_by(const lab_check *c)
{
    static const char *const by[] = {"a plumb line", "a scale", "a light", "another clock"};
    return by[c->by];
}

int plan__check_numbers(const lab_check *c, char name[2][LAB_PLACE])
{
    int n = 0;
    for (int k = 0; k < NUMBERS; k++) {
        if (numbers[k].by == c->by) {
            snprintf(name[n++], LAB_PLACE, "%.40s%s", c->of, numbers[k].tail);
        }
    }
    return n;
}

void plan__check_says(const lab_check *c, char name[LAB_PLAN_TEXT], char why[LAB_PLAN_TEXT])
{
    char found[2][LAB_PLACE];
    int n = plan__check_numbers(c, found);
    snprintf(name, LAB_PLAN_TEXT, "%s beside %s", c->of[0] != '\0' ? c->of : "the clock",
             plan__check_by(c));
    snprintf(why, LAB_PLAN_TEXT, "# set %.50s%s%.50s", found[0], n > 1 ? ", # set " : "",
             n > 1 ? found[1] : "");
}

/* ---- what is read ---- */

static int readings(const lab_check *c)
{
    return c->by == LAB_CHECK_SCALE ? LAB_CHECK_VALUES : 1;
}

/* what the i-th reading shows of a number that is off by 1, in its noise */
static double shows(const lab_check *c, const char *param, int i)
{
    char of[LAB_PLACE];
    const number *n = number_of(param, of);
    double x = c->reach * i / (LAB_CHECK_VALUES - 1);
    if (n == NULL || n->by != c->by || strcmp(of, c->of) != 0) {
        return 0.0;
    }
    return (n->power == 2 ? x * x : n->power == 1 ? x : 1.0) / c->noise;
}

/* the amount of a side and its standard deviation */
static void amount_of(const plan__side *side, double *amount, double *sd)
{
    const lab_posterior *q = &side->s->posterior;
    *amount = *sd = 0.0;
    for (int i = 0; i < q->n; i++) {
        if (strcmp(q->number[i].name, "amount") == 0) {
            *amount = q->number[i].value;
            *sd = q->number[i].sd;
        }
    }
}

/* y and P: the numbers of instruments are moved by adding (candidates.c), so they answer straight
 */
static void fill(plan__view *v, const plan__side *side, const lab_experiment *e)
{
    const stein_model *m = lab_equations(side->model);
    const lab_candidate *c = &side->candidate;
    double amount, sd;
    int row = 0;
    amount_of(side, &amount, &sd);
    for (int k = 0; k < e->ncheck; k++) {
        const lab_check *check = &e->check[k];
        for (int i = 0; i < readings(check); i++, row++) {
            for (int p = 0; p < c->nparam; p++) {
                double by = shows(check, m->params[c->param[p]].name, i);
                v->y[row] += by * amount;
                v->P[row] += by * sd;
            }
            v->Z[k * v->rows + row] = check->by == LAB_CHECK_SCALE ? any_zero : 0.0;
        }
    }
}

stein_status plan__check_view(plan__view *v, const plan__side *side, const lab_experiment *e,
                              stein_err *err)
{
    *v = (plan__view){.neye = 1, .np = 1, .nz = e->ncheck};
    for (int k = 0; k < e->ncheck; k++) {
        v->rows += readings(&e->check[k]);
    }
    size_t rows = (size_t)v->rows;
    v->until = v->rows;
    v->y = calloc(rows, sizeof *v->y);
    v->P = calloc(rows, sizeof *v->P);
    v->Z = calloc(rows * (size_t)v->nz, sizeof *v->Z);
    if (!v->y || !v->P || !v->Z) {
        return lab__no_memory(err);
    }
    fill(v, side, e);
    return STEIN_OK;
}
