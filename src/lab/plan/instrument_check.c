/* SPDX-License-Identifier: GPL-3.0-or-later
 * instrument_check.c - a separate check of an instrument or of a number of the mechanism.
 *
 * Where a tilted camera, a distorting lens and a wrong length are rivals, no stroke separates them
 * quickly. Each moves the same marker by a fraction of the noise, and trigger, offset and scatter
 * of every stroke make up for most of that. A plumb line in the view tells it at once.
 *
 *   plumb line   its angle in the picture is the tilt          0.5 mrad
 *   scale        known values x = 0 .. reach at 11 places:     gauge blocks (0.15 um), weights
 *                reading = zero + (1 + error) x + k2 x^2       (1e-4 of the largest), each filmed
 *                with x from where the marker rests            for a second
 *   light        goes on at known instants, a hundred times:   a frame's interval / (10 sqrt 12)
 *   clock        beside another one, for a while               1e-5
 *   calipers     a length of the mechanism                     50 um, between edges of wood
 *   knife edge   where a body's centre of mass is              0.2 mm
 *   balance      a body's mass                                 10 mg
 *   press        a felt's slow force at depths x = 0 .. reach, 0.5 % of the force, and of a tenth
 *                twice as deep as the strokes go, at 11 places of the largest one; the felt begins
 *                                                              somewhere within 10 um
 *
 * A side predicts the readings from the amount it was fitted with and its uncertainty; a side
 * without that number predicts the file's value, within the uncertainty of its fit. Readings count
 * like readings of a record (expected_evidence.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "planning.h"
#include "stein/law.h"

static const double plumb = 5e-4;                    /* [rad] */
static const double gauge = 1.5e-7, gauge_arm = 0.1; /* [m], of an angle [m] */
static const double weights = 1e-4;                  /* of the largest force */
static const double looked_at = 1.0;                 /* each value [s] */
static const double flashes = 100.0, quartz = 1e-5;  /* number; relative */
static const double any_zero = 1e3;                  /* of a scale, in its noise */
static const double calipers = 5e-5, knife = 2e-4;   /* [m] */
static const double balance = 1e-5;                  /* [kg] */
static const double load_cell = 5e-3, least = 0.1;   /* of the force, of the largest one */
static const double begins = 1e-5, twice = 2.0;      /* [m]; of the depth so far */

/* numbers of an instrument, by the tails of their names */
static const struct {
    lab_check_by by;
    const char *tail;
    int power; /* of the value at which a reading shows it */
} numbers[] = {{LAB_CHECK_LEVEL, ".sensor.tilt", 0},
               {LAB_CHECK_SCALE, ".sensor.gain", 1},
               {LAB_CHECK_SCALE, ".sensor.square", 2},
               {LAB_CHECK_LIGHT, ".sensor.delay", 0},
               {LAB_CHECK_CLOCK, "clock.error", 0}};
enum { NUMBERS = sizeof numbers / sizeof *numbers };

/* numbers of a felt that a slow force shows, in the order of a law */
static const char *const felt[] = {".normal.a", ".normal.b", ".normal.c", ".normal.p"};
enum { FELT = sizeof felt / sizeof *felt, EXPONENT = FELT - 1 };

/* does a name end so? @param stem  the rest of it, out */
static int ends(const char *name, const char *tail, char stem[LAB_PLACE])
{
    size_t n = strlen(name), t = strlen(tail);
    if (n < t || strcmp(name + n - t, tail) != 0) {
        return 0;
    }
    snprintf(stem, LAB_PLACE, "%.*s", (int)(n - t), name);
    return 1;
}

/* the parameter of a felt's number k, -1: it has none */
static int felt_param(const stein_model *m, const char *contact, int k)
{
    char name[LAB_PLACE];
    snprintf(name, sizeof name, "%.60s%s", contact, felt[k]);
    return stein_find_param(m, name);
}

/* ---- the list ---- */

static void add_number(lab_check *c, const lab_model *model, const char *stem, const char *tail)
{
    char name[LAB_PLACE];
    snprintf(name, sizeof name, "%.60s%s", stem, tail);
    int i = stein_find_param(lab_equations(model), name);
    if (i >= 0 && c->n < LAB_CHECK_NUMBERS) {
        struct lab_checked *number = &c->number[c->n++];
        memcpy(number->name, name, sizeof name);
        number->file = lab_parameters(model)[i];
    }
}

static double noise_of_scale(const plan__reference *b, const plan__output *output)
{
    const char *unit = b->m->channels[stein_find_channel(b->m, output->name)].unit;
    double scale = strcmp(unit, "m") == 0     ? gauge
                   : strcmp(unit, "rad") == 0 ? gauge / gauge_arm
                                              : weights * output->reach;
    return hypot(scale, output->noise * sqrt(fmin(1.0, b->d->conditions.interval / looked_at)));
}

/* an instrument held against something. @return 0: the check does not exist */
static int check_of(lab_check *c, const plan__reference *b, const lab_model *model,
                    const char *param)
{
    int found = -1;
    *c = (lab_check){.n = 0};
    for (int k = 0; found < 0 && k < NUMBERS; k++) {
        found = ends(param, numbers[k].tail, c->of) ? k : -1;
    }
    const plan__output *output = NULL;
    for (int i = 0; found >= 0 && i < b->noutput; i++) {
        output =
            b->output[i].measured && strcmp(b->output[i].name, c->of) == 0 ? &b->output[i] : output;
    }
    if (found < 0 || (output == NULL && numbers[found].by != LAB_CHECK_CLOCK)) {
        return 0;
    }
    c->by = numbers[found].by;
    c->reach = c->by == LAB_CHECK_SCALE ? output->reach : 0.0;
    c->noise = c->by == LAB_CHECK_LEVEL   ? plumb
               : c->by == LAB_CHECK_LIGHT ? b->d->conditions.interval / sqrt(12.0 * flashes)
               : c->by == LAB_CHECK_CLOCK ? quartz
                                          : noise_of_scale(b, output);
    for (int k = 0; k < NUMBERS; k++) {
        if (numbers[k].by == c->by) {
            add_number(c, model, c->of, numbers[k].tail);
        }
    }
    return c->by != LAB_CHECK_SCALE || (c->noise > 0.0 && c->reach > 0.0);
}

/* A length or a mass that may differ from the file's. Settings of strokes were made by hand, and
 * checked then. @return as above */
static int measure_of(lab_check *c, const plan__reference *b, const lab_model *model,
                      const stein_param *param)
{
    const lab_conditions *set = &b->d->conditions;
    int length = strcmp(param->unit, "m") == 0;
    if (!(length || strcmp(param->unit, "kg") == 0) || strstr(param->name, ".normal.") != NULL ||
        plan__used(set->setting, set->nsetting, param->name) != NULL) {
        return 0;
    }
    *c = (lab_check){.n = 0};
    snprintf(c->of, sizeof c->of, "%.60s", param->name);
    c->by = !length                                   ? LAB_CHECK_BALANCE
            : strstr(param->name, ".centre.") != NULL ? LAB_CHECK_EDGE
                                                      : LAB_CHECK_CALIPERS;
    c->noise = !length ? balance : c->by == LAB_CHECK_EDGE ? knife : calipers;
    add_number(c, model, c->of, "");
    return c->n > 0;
}

/* slow force of a felt with parameters p */
static double force_at(const lab_check *c, const stein_model *m, const double *p, double x)
{
    static const int at[FELT] = {STEIN_NORMAL_A, STEIN_NORMAL_B, STEIN_NORMAL_C,
                                 STEIN_NORMAL_EXPONENT};
    double law[STEIN_NORMAL_SIZE] = {0.0};
    for (int k = 0; k < FELT; k++) {
        int i = felt_param(m, c->of, k);
        law[at[k]] = i >= 0 ? p[i] : 0.0;
    }
    return stein_normal_force(law, x, 0.0);
}

/* A felt that is pressed slowly. @return as above */
static int press_of(lab_check *c, const plan__reference *b, const lab_model *model,
                    const char *param)
{
    int found = 0;
    *c = (lab_check){.n = 0};
    for (int k = 0; !found && k < FELT; k++) {
        found = ends(param, felt[k], c->of);
    }
    int contact = found ? stein_find_contact(b->m, c->of) : -1;
    if (contact < 0 || !(b->deep[contact] > 0.0)) {
        return 0;
    }
    c->by = LAB_CHECK_PRESS;
    c->noise = load_cell;
    c->reach = twice * b->deep[contact];
    for (int k = 0; k < FELT; k++) {
        int i = felt_param(lab_equations(model), c->of, k);
        if (i >= 0 && (k == EXPONENT || lab_parameters(model)[i] != 0.0)) {
            add_number(c, model, c->of, felt[k]);
        }
    }
    return force_at(c, lab_equations(model), lab_parameters(model), c->reach) > 0.0;
}

static int same(const lab_check *a, const lab_check *b)
{
    return a->by == b->by && strcmp(a->of, b->of) == 0;
}

int plan__checks(lab_check check[LAB_PLAN_CHECKS], const plan__reference *b,
                 const plan__model *side, int nside)
{
    int n = 0;
    for (int s = 0; s < nside * FIT__ACCEPTED; s++) {
        const plan__model *of = &side[s / FIT__ACCEPTED];
        const lab_candidate *c = &of->candidate[s % FIT__ACCEPTED];
        if (s % FIT__ACCEPTED >= of->n) {
            continue;
        }
        lab_site site = c->effect->site;
        int thing = (site == LAB_AT_PARAMETER || site == LAB_AT_BODY) && c->effect->needs == NULL;
        for (int k = 0; k < c->nparam && n < LAB_PLAN_CHECKS; k++) {
            const lab_model *model = of->model;
            const stein_param *param = &lab_equations(model)->params[c->param[k]];
            int is_new = check_of(&check[n], b, model, param->name) ||
                         press_of(&check[n], b, model, param->name) ||
                         (thing && measure_of(&check[n], b, model, param));
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
    static const char *const by[] = {"a plumb line", "a scale",      "a light",   "another clock",
                                     "calipers",     "a knife edge", "a balance", "a press"};
    return by[c->by];
}

void plan__check_says(const lab_check *c, char name[LAB_PLAN_TEXT], char why[LAB_PLAN_TEXT])
{
    const char *how = c->by == LAB_CHECK_PRESS                                ? "in"
                      : c->by == LAB_CHECK_BALANCE || c->by == LAB_CHECK_EDGE ? "on"
                      : c->by == LAB_CHECK_CALIPERS                           ? "with"
                                                                              : "beside";
    snprintf(name, LAB_PLAN_TEXT, "%s %s %s", c->of[0] != '\0' ? c->of : "the clock", how,
             plan__check_by(c));
    why[0] = '\0';
    for (int k = 0; k < c->n; k++) {
        size_t n = strlen(why);
        snprintf(why + n, LAB_PLAN_TEXT - n, "%s# known %.50s", k > 0 ? ", " : "",
                 c->number[k].name);
    }
}

/* ---- readings ---- */

static int readings(const lab_check *c)
{
    return c->by == LAB_CHECK_SCALE || c->by == LAB_CHECK_PRESS ? LAB_CHECK_VALUES : 1;
}

/* setting of the i-th reading */
static double value_at(const lab_check *c, int i)
{
    return c->reach * i / (LAB_CHECK_VALUES - 1);
}

/* sd of a reading of a press, by the felt of the file */
static double error_at(const lab_check *c, const plan__model *side, double x)
{
    const stein_model *m = lab_equations(side->model);
    const double *file = lab_parameters(side->model);
    return c->noise * (force_at(c, m, file, x) + least * force_at(c, m, file, c->reach));
}

/* change of a reading at x for a number that is off by 1: of an instrument by the table, of a
 * length or a mass itself */
static double shows(const char *name, double x)
{
    char of[LAB_PLACE];
    int power = 0;
    for (int k = 0; k < NUMBERS; k++) {
        power = ends(name, numbers[k].tail, of) ? numbers[k].power : power;
    }
    return power == 2 ? x * x : power == 1 ? x : 1.0;
}

/* the i-th reading with parameters p, in its noise */
static double reading(const lab_check *c, const plan__model *side, const double *p, int i)
{
    const stein_model *m = lab_equations(side->model);
    double x = value_at(c, i), sum = 0.0;
    if (c->by == LAB_CHECK_PRESS) {
        return force_at(c, m, p, x) / error_at(c, side, x);
    }
    for (int k = 0; k < c->n; k++) {
        int param = stein_find_param(m, c->number[k].name);
        double off = param >= 0 ? p[param] - lab_parameters(side->model)[param] : 0.0;
        sum += off * shows(c->number[k].name, x) / c->noise;
    }
    return sum;
}

/* a number of the posterior, `by` standard deviations off; `value` when it has none */
static double known(const plan__model *side, const char *name, double value, double by)
{
    const lab_posterior *q = &side->s->posterior;
    for (int i = 0; i < q->n; i++) {
        const struct lab_uncertain *u = &q->number[i];
        if (strcmp(u->name, name) == 0) {
            return u->logarithmic ? u->value * stein__exp_of(by * u->sd) : u->value + by * u->sd;
        }
    }
    return value;
}

/* columns of P: the amounts of a side, then numbers of the file */
static int columns(const plan__model *side)
{
    return side->n + LAB_CHECK_NUMBERS;
}

/* The i-th reading of a side with its uncertain quantity k off by `by` standard deviations: an
 * amount, or a number of the file that the fits move anyhow. @param p  [np] room */
static double seen(const lab_check *c, const plan__model *side, int i, int k, double by, double *p)
{
    const stein_model *m = lab_equations(side->model);
    memcpy(p, lab_parameters(side->model), sizeof *p * (size_t)m->np);
    for (int n = 0; n < c->n; n++) {
        int param = stein_find_param(m, c->number[n].name);
        if (param >= 0) {
            p[param] = known(side, c->number[n].name, p[param], k == side->n + n ? by : 0.0);
        }
    }
    plan__model_apply(side, k, by, p);
    return reading(c, side, p, i);
}

static void fill(plan__prediction *v, const plan__model *side, const lab_experiment *e, double *p)
{
    int row = 0;
    for (int n = 0; n < e->ncheck; n++) {
        const lab_check *c = &e->check[n];
        for (int i = 0; i < readings(c); i++, row++) {
            double x = value_at(c, i);
            v->y[row] = seen(c, side, i, 0, 0.0, p);
            for (int k = 0; k < columns(side); k++) {
                double up = seen(c, side, i, k, 1.0, p), down = seen(c, side, i, k, -1.0, p);
                v->P[k * v->rows + row] = 0.5 * (up - down);
            }
            if (c->by == LAB_CHECK_SCALE) {
                v->Z[n * v->rows + row] = any_zero;
            } else if (c->by == LAB_CHECK_PRESS) {
                const stein_model *m = lab_equations(side->model);
                const double *file = lab_parameters(side->model);
                v->Z[n * v->rows + row] =
                    (force_at(c, m, file, x + begins) - force_at(c, m, file, x)) /
                    error_at(c, side, x);
            }
        }
    }
}

stein_status plan__check_prediction(plan__prediction *v, const plan__model *side,
                                    const lab_experiment *e, stein_err *err)
{
    *v = (plan__prediction){.noutput = 1, .np = columns(side), .nz = e->ncheck};
    for (int k = 0; k < e->ncheck; k++) {
        v->rows += readings(&e->check[k]);
    }
    size_t rows = (size_t)v->rows, np = (size_t)lab_equations(side->model)->np;
    v->until = v->rows;
    v->y = calloc(rows, sizeof *v->y);
    v->P = calloc(rows * (size_t)v->np, sizeof *v->P);
    v->Z = calloc(rows * (size_t)v->nz, sizeof *v->Z);
    double *p = malloc(sizeof *p * (np + 1));
    int memory = v->y != NULL && v->P != NULL && v->Z != NULL && p != NULL;
    if (memory) {
        fill(v, side, e, p);
    }
    free(p);
    return memory ? STEIN_OK : lab__no_memory(err);
}
