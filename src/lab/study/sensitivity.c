/* SPDX-License-Identifier: GPL-3.0-or-later
 * sensitivity.c - effect of every parameter on escapement height, impact speed and peak force.
 *
 * Central differences about the reference, [y(p + h) - y(p - h)] / 2h, of strokes under the load,
 * each from its own equilibrium. The unit step that the slopes refer to: 0.1 mm for a length, 0.1
 * degree for an angle (1 % of an angle depends on where it is counted from), 1 % for everything
 * else. The difference starts at a quarter of it and is halved, at most four times, until each
 * response has two slopes that agree within 2 % (or within a negligible amount). Slopes that never
 * agree are marked. The pair that agrees best counts: large steps bend, small ones drown in the
 * rounding of the peak. The time step is halved (10 us): at 20 us the vertex of the force between
 * steps is off by up to 2e-3 N, which a difference of 1 % magnifies.
 *
 * Parameters without a slope by construction are left out: zeros that are neither places nor
 * angles, or are an end of the number's range (they switch a law off); directions of inputs;
 * sensors; initial values (the stroke starts from equilibrium).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "study.h"

enum { TOP = 20, HALVINGS = 4 };
static const double length_step = 1e-4, angle_step = 0.1 * 0.017453292519943295, share = 0.01;
static const double after = 15e-3; /* the peak is over so long after the reference impact [s] */
static const double agreement = 0.02;
/* negligible amounts: 1 um, 0.1 mm/s, 2 mN a unit step */
static const double floor_of[STUDY_RESPONSES] = {1e-6, 1e-4, 2e-3};

/* ---- strokes with one number changed ---- */

typedef struct bends {
    const study *s;
    study_bend *bend;
} bends;

static void set_number(void *ctx, int i, double *p)
{
    const study_bend *b = &((const bends *)ctx)->bend[i];
    p[b->param] += b->by;
}

static stein_status keep(void *ctx, int i, stein_sim *sim, const lab_stroke *stroke,
                         stein_status status, stein_err *err)
{
    study_bend *b = &((bends *)ctx)->bend[i];
    (void)sim;
    (void)err;
    b->struck = status == STEIN_OK && stroke->outcome == LAB_STRUCK;
    if (b->struck) {
        b->y[0] = stroke->escape_height;
        b->y[1] = stroke->impact_speed;
        b->y[2] = stroke->peak_string_force;
    }
    return STEIN_OK;
}

stein_status study_bends(const study *s, study_bend *bend, int n, stein_err *err)
{
    bends w = {s, bend};
    double enough = s->reference.impact_time + after, whole = study_drive_default().until;
    double until = enough < whole ? enough : whole; // false without an impact
    const stein_sim_def sim = study_def(s);
    // a release at the very end costs nothing and spares the look ahead at re-arming
    const lab_stroke_def def = {.until = until, .release = until};
    const lab__batch batch = {.def = &def,
                              .model = s->model,
                              .sim = &sim,
                              .n = n,
                              .threads = s->threads,
                              .set = set_number,
                              .run = keep,
                              .ctx = &w};
    return lab__batch_run(&batch, err);
}

/* ---- slopes ---- */

/* central differences of slopes that do not agree yet: two strokes each, bend[2 * n] */
static stein_status difference(const study *s, const study_slope *slope, int n, double step,
                               study_bend *bend, double (*y)[STUDY_RESPONSES], stein_err *err)
{
    int open = 0;
    for (int i = 0; i < n; i++) {
        if (!slope[i].agrees) {
            double by = step * slope[i].unit;
            bend[open++] = (study_bend){.param = slope[i].param, .by = by};
            bend[open++] = (study_bend){.param = slope[i].param, .by = -by};
        }
    }
    stein_status status = study_bends(s, bend, open, err);
    for (int i = 0, k = 0; status == STEIN_OK && i < n; i++) {
        if (!slope[i].agrees) {
            const study_bend *up = &bend[k], *down = &bend[k + 1];
            for (int j = 0; j < STUDY_RESPONSES; j++) {
                y[i][j] = up->struck && down->struck ? (up->y[j] - down->y[j]) / (2.0 * step) : NAN;
            }
            k += 2;
        }
    }
    return status;
}

/* a slope from a finer difference beside the one before; NAN: a stroke did not strike */
static void judge(study_slope *k, double step, const double *coarse, const double *fine)
{
    k->agrees = 1;
    for (int j = 0; j < STUDY_RESPONSES; j++) {
        double doubt = isnan(fine[j]) || isnan(coarse[j]) ? INFINITY : fabs(fine[j] - coarse[j]);
        if (!isnan(fine[j]) && !(doubt >= k->doubt[j])) { // the first, or better than before
            k->slope[j] = fine[j];
            k->doubt[j] = doubt;
        }
        k->agrees = k->agrees && k->doubt[j] <= agreement * fabs(k->slope[j]) + floor_of[j];
    }
    k->step = step;
}

static stein_status halve(const study *s, study_slope *slope, int n, study_bend *bend,
                          double (*coarse)[STUDY_RESPONSES], double (*fine)[STUDY_RESPONSES],
                          stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int round = 0; status == STEIN_OK && round <= HALVINGS; round++) {
        double step = ldexp(0.25, -round);
        status = difference(s, slope, n, step, bend, fine, err);
        for (int i = 0; status == STEIN_OK && i < n; i++) {
            if (round > 0 && !slope[i].agrees) {
                judge(&slope[i], step, coarse[i], fine[i]);
            }
            memcpy(coarse[i], fine[i], sizeof coarse[i]);
        }
        if (status == STEIN_OK && s->progress != NULL) {
            s->progress(s->ctx, "sensitivities", round + 1, HALVINGS + 1);
        }
    }
    return status;
}

static int has_slope(const stein_model *m, const double *p, int i)
{
    const char *name = m->params[i].name, *dot = strrchr(name, '.');
    int place = dot != NULL && (strcmp(dot, ".x") == 0 || strcmp(dot, ".z") == 0 ||
                                strcmp(dot, ".stop_shift") == 0);
    int angle = strcmp(m->params[i].unit, "rad") == 0;
    int zero = p[i] == 0.0 && ((!place && !angle) || m->params[i].range != STEIN_ANY);
    return !zero && strstr(name, ".initial.") == NULL && strstr(name, ".direction.") == NULL &&
           strstr(name, ".sensor.") == NULL;
}

stein_status study_slopes(const study *s, study_slope *slope, int *n, stein_err *err)
{
    const stein_model *m = lab_equations(s->model);
    const double *p = lab_parameters(s->model);
    *n = 0;
    for (int i = 0; i < m->np; i++) {
        if (!has_slope(m, p, i)) {
            continue;
        }
        study_slope *k = &slope[(*n)++];
        *k = (study_slope){.param = i, .unit = share * fabs(p[i]), .unit_text = "1 %"};
        for (int j = 0; j < STUDY_RESPONSES; j++) {
            k->slope[j] = k->doubt[j] = NAN;
        }
        if (strcmp(m->params[i].unit, "m") == 0) {
            k->unit = length_step;
            k->unit_text = "0.1 mm";
        } else if (strcmp(m->params[i].unit, "rad") == 0) {
            k->unit = angle_step;
            k->unit_text = "0.1 deg";
        }
    }
    study finer = *s;
    finer.dt = 0.5 * s->dt;
    study_bend *bend = calloc(2 * (size_t)*n + 1, sizeof *bend);
    double(*y)[STUDY_RESPONSES] = calloc(2 * (size_t)*n + 1, sizeof *y);
    stein_status status = bend != NULL && y != NULL ? halve(&finer, slope, *n, bend, y, y + *n, err)
                                                    : lab__no_memory(err);
    free(bend);
    free(y);
    return status;
}

/* ---- the chart ---- */

/* effect of one parameter as share of the largest effect on each response; the largest share */
static double weight(const study_slope *k, const double largest[STUDY_RESPONSES])
{
    double w = 0.0;
    for (int j = 0; j < STUDY_RESPONSES; j++) {
        w = isfinite(k->slope[j]) ? fmax(w, fabs(k->slope[j]) / largest[j]) : w;
    }
    return w;
}

typedef struct rank {
    int index;
    double weight;
} rank;

static int by_weight(const void *a, const void *b)
{
    const rank *x = a, *y = b;
    return x->weight != y->weight ? (x->weight < y->weight) - (x->weight > y->weight)
                                  : x->index - y->index;
}

static char *row_name(const study *s, const study_slope *k, int with_unit)
{
    const char *name = lab_equations(s->model)->params[k->param].name;
    return with_unit ? lab__text("%s  (%s)", name, k->unit_text) : lab__text("%s", name);
}

enum { UNIT, HEIGHT, SPEED, FORCE, DOUBT_HEIGHT, DOUBT_SPEED, DOUBT_FORCE, STEP, AGREES };

static int fill(const study *s, study_table *t, const study_slope *slope, const rank *order,
                int with_unit)
{
    t->label = calloc((size_t)t->nrow + 1, sizeof *t->label);
    t->label_head = "parameter";
    for (int i = 0; t->label != NULL && i < t->nrow; i++) {
        const study_slope *k = &slope[order[i].index];
        double *row = study_row(t, i);
        t->label[i] = row_name(s, k, with_unit);
        row[UNIT] = k->unit;
        for (int j = 0; j < STUDY_RESPONSES; j++) {
            row[HEIGHT + j] = k->slope[j];
            row[DOUBT_HEIGHT + j] = k->doubt[j];
        }
        row[STEP] = k->step;
        row[AGREES] = k->agrees;
    }
    return study_is_labelled(t);
}

static void draw(study_part *part, const study_table *top)
{
    study_chart *c = study_chart_new(part, "sensitivity", 1100, 640, 3);
    static const char *const label[] = {"escapement height [mm per step]",
                                        "impact speed [mm/s per step]",
                                        "peak string force [mN per step]"};
    c->left = 0.205;
    for (int j = 0; j < STUDY_RESPONSES; j++) {
        study_panel *p = study_panel_new(c, label[j], "");
        study_curve_add(p, top, HEIGHT + j, 1e3, 0, 1.0, STUDY_BARS, j, NULL);
    }
}

static void say(const study *s, study_part *part, const study_slope *slope, const rank *order,
                int n)
{
    const stein_model *m = lab_equations(s->model);
    int agree = 0, best = 0;
    for (int i = 0; i < n; i++) {
        agree += slope[i].agrees;
        best = fabs(slope[i].slope[0]) > fabs(slope[best].slope[0]) ? i : best;
    }
    study_say(
        part,
        "%d parameters; halving the step of the difference confirms %d of them within "
        "%.0f %%. The chart shows the first %d, ordered by the largest of their three effects as a "
        "share of the largest effect there is. A step is 0.1 mm, 0.1 degree or 1 %%.",
        n, agree, 100.0 * agreement, n < TOP ? n : TOP);
    study_say(part,
              "First comes <b>%s</b>; the escapement height hangs most on %s (%+.2f mm per %s).",
              m->params[slope[order[0].index].param].name, m->params[slope[best].param].name,
              1e3 * slope[best].slope[0], slope[best].unit_text);
    if (agree < n) {
        study_say(part, "Not confirmed:");
        for (int i = 0, first = 1; i < n; i++) {
            if (!slope[i].agrees) {
                study_say(part, "%s%s", first ? "" : "· ", m->params[slope[i].param].name);
                first = 0;
            }
        }
    }
}

stein_status study_sensitivity(const study *s, study_part *part, stein_err *err)
{
    static const char *const head[] = {"step [SI]",
                                       "height [m/step]",
                                       "speed [m/s/step]",
                                       "force [N/step]",
                                       "height_doubt [m/step]",
                                       "speed_doubt [m/s/step]",
                                       "force_doubt [N/step]",
                                       "difference [step]",
                                       "confirmed [1]",
                                       NULL};
    size_t np = (size_t)lab_equations(s->model)->np;
    const study_slope *slope = s->slope;
    rank *order = calloc(np + 1, sizeof *order);
    int n = s->nslope;
    part->id = "sensitivity";
    part->title = "Sensitivity";
    stein_status status = STEIN_OK;
    if (order == NULL) {
        status = lab__no_memory(err);
    } else {
        double largest[STUDY_RESPONSES] = {1e-300, 1e-300, 1e-300};
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < STUDY_RESPONSES; j++) {
                largest[j] = isfinite(slope[i].slope[j]) ? fmax(largest[j], fabs(slope[i].slope[j]))
                                                         : largest[j];
            }
        }
        for (int i = 0; i < n; i++) {
            order[i] = (rank){i, weight(&slope[i], largest)};
        }
        qsort(order, (size_t)n, sizeof *order, by_weight);
        study_table *all = study_table_new(part, "sensitivity", n, head);
        study_table *top = study_table_new(part, "", n < TOP ? n : TOP, head);
        int made = all != NULL && top != NULL && fill(s, all, slope, order, 0) &&
                   fill(s, top, slope, order, 1);
        if (made) {
            draw(part, top);
            say(s, part, slope, order, n);
        } else {
            status = lab__no_memory(err);
        }
    }
    free(order);
    return status;
}
