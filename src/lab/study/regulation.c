/* SPDX-License-Identifier: GPL-3.0-or-later
 * regulation.c - two ways to set the escapement: shifting the pawl's stop, or bending its spring.
 *
 * The paper studies only the first. Bending changes the spring's stiffness k or its neutral angle
 * theta_0, and with them the pawl's rest (the stop is soft) as well as its motion. Each of the
 * three is varied from the reference so that the escapement covers the same heights; the costs are
 * then compared at equal height. Re-arming is judged with the load lifted at 0.2 s. It is the time
 * until the
 * beak is under the roof for good, and the overlap of beak and roof that is ready for the next
 * stroke.
 */
#include <math.h>
#include <stdlib.h>

#include "study.h"

enum { WAYS = 3, POINTS = 11, STRETCHES = 40 };
static const char *const name[WAYS] = {"pawl.stop_shift", "pawl.spring.k", "pawl.spring.theta0"};
static const char *const title[WAYS] = {"stop shifted", "spring stiffness", "spring neutral angle"};
static const double lowest = 1.0e-3, highest = 6.0e-3; /* heights wanted [m] */
static const double furthest = 0.8; /* a spring is bent by at most this share of its value */
static const double release = 0.2, judged = 0.5; /* [s] */

enum { VALUE, HEIGHT, FORCE, SPEED, IMPACT, FINGER, REARM, MARGIN, COLUMNS };

typedef struct ways {
    const study *s;
    double end[WAYS][2]; /* values at the lowest and the highest of the heights */
    study_table *table[WAYS];
} ways;

static double value_of(const study *s, int way)
{
    return lab_parameters(s->model)[stein_find_param(lab_equations(s->model), name[way])];
}

/* step away from the reference until the height is passed, then bisect; where the action fails
 * before, the last value that worked */
static stein_status find_end(void *ctx, stein_sim *sim, int i)
{
    ways *w = ctx;
    int way = i / 2, side = i % 2;
    double start = value_of(w->s, way), wanted = side == 0 ? lowest : highest;
    double step = way == 0 ? 0.05e-3 : 0.05 * fabs(start), here = start;
    double h0 = study_height(w->s, sim),
           slope = study_height_slope(w->s, sim, name[way], 0.2 * step);
    double sign = (wanted > h0) == (slope > 0.0) ? 1.0 : -1.0, h = h0;
    for (int n = 0; n < STRETCHES && isfinite(h) && (h > wanted) == (h0 > wanted); n++) {
        double next = here + sign * step;
        if (way > 0 && fabs(next - start) > furthest * fabs(start)) {
            break;
        }
        stein_set(sim, name[way], next, NULL);
        double there = study_height(w->s, sim);
        if (!isfinite(there)) {
            step *= 0.5;
            if (step < 1e-3 * (way == 0 ? 0.05e-3 : 0.05 * fabs(start))) {
                break;
            }
            continue;
        }
        here = next;
        h = there;
    }
    w->end[way][side] = here;
    if (isfinite(h) && (h > wanted) != (h0 > wanted)) {
        study_level(w->s, sim, name[way], here - sign * step, here, wanted, &w->end[way][side]);
    }
    return STEIN_OK;
}

static stein_status measure(void *ctx, stein_sim *sim, int i)
{
    ways *w = ctx;
    int way = i / POINTS, k = i % POINTS;
    double *row = study_row(w->table[way], k);
    double a = w->end[way][0], b = w->end[way][1];
    study_drive drive = study_drive_default();
    study_details details;
    drive.until = judged;
    drive.release = release;
    double wanted = lowest + (highest - lowest) * k / (POINTS - 1);
    row[VALUE] = k == 0 ? a : b; // found as such
    if (k > 0 && k < POINTS - 1 && !study_level(w->s, sim, name[way], a, b, wanted, &row[VALUE])) {
        row[VALUE] = NAN;
    }
    if (!isfinite(row[VALUE]) || stein_set(sim, name[way], row[VALUE], NULL) != STEIN_OK) {
        return STEIN_OK;
    }
    study_strike(w->s, sim, &drive, NULL, &details);
    if (details.status != STEIN_OK || details.stroke.outcome != LAB_STRUCK) {
        return details.status;
    }
    row[HEIGHT] = details.stroke.escape_height;
    row[FORCE] = details.stroke.peak_string_force;
    row[SPEED] = details.stroke.impact_speed;
    row[IMPACT] = details.stroke.impact_time;
    row[FINGER] = details.key_force;
    row[REARM] = details.rearm_time;
    row[MARGIN] = details.rearm_margin;
    return STEIN_OK;
}

/* column y at a height, between the rows around it */
static double at_height(const study_table *t, double height, int y)
{
    for (int i = 0; i + 1 < t->nrow; i++) {
        const double *a = study_row(t, i), *b = study_row(t, i + 1);
        if ((a[HEIGHT] - height) * (b[HEIGHT] - height) <= 0.0 && a[HEIGHT] != b[HEIGHT]) {
            return a[y] + (b[y] - a[y]) * (height - a[HEIGHT]) / (b[HEIGHT] - a[HEIGHT]);
        }
    }
    return NAN;
}

static void draw(study_part *part, const ways *w)
{
    static const struct {
        int y;
        double scale;
        const char *label;
    } panel[] = {{FORCE, 1.0, "peak string force [N]"},
                 {IMPACT, 1e3, "time of impact [ms]"},
                 {FINGER, 1.0, "largest key force before escapement [N]"},
                 {REARM, 1e3, "time to re-arm after release [ms]"},
                 {MARGIN, 1e3, "overlap once re-armed [mm]"}};
    study_chart *c = study_chart_new(part, "regulation", 1100, 720, 3);
    for (int i = 0; i < 5; i++) {
        study_panel *p = study_panel_new(c, "escapement height [mm]", panel[i].label);
        p->legend = i == 0;
        for (int k = 0; k < WAYS; k++) {
            study_curve_add(p, w->table[k], HEIGHT, 1e3, panel[i].y, panel[i].scale, STUDY_BOTH, k,
                            title[k]);
        }
    }
}

static void say(const study *s, study_part *part, const ways *w)
{
    double ref = s->reference.escape_height, far = NAN;
    for (int k = 0; k < WAYS; k++) {
        double top = -INFINITY;
        for (int i = 0; i < POINTS; i++) {
            top = fmax(top, study_row(w->table[k], i)[HEIGHT]);
        }
        far = isnan(far) || top < far ? top : far;
    }
    study_say(part,
              "At equal escapement height, what differs is how the height was reached. Going "
              "from %.1f mm to %.1f mm, the largest height that all reach, costs:",
              1e3 * ref, 1e3 * far);
    for (int k = 0; k < WAYS; k++) {
        const study_table *t = w->table[k];
        double value = at_height(t, far, VALUE), from = value_of(s, k);
        if (isnan(value)) {
            continue;
        }
        if (k == 0) {
            study_say(part, "with the <b>stop</b> (%+.2f mm)", 1e3 * (value - from));
        } else {
            study_say(part, "with the spring's <b>%s</b> (%+.0f %%)",
                      k == 1 ? "stiffness" : "neutral angle", 100.0 * (value / from - 1.0));
        }
        study_say(part,
                  "%+.2f N of peak force, %+.2f N at the key, %+.1f ms at the impact, %+.3f mm of "
                  "overlap and "
                  "%+.1f ms to re-arm%s",
                  at_height(t, far, FORCE) - at_height(t, ref, FORCE),
                  at_height(t, far, FINGER) - at_height(t, ref, FINGER),
                  1e3 * (at_height(t, far, IMPACT) - at_height(t, ref, IMPACT)),
                  1e3 * (at_height(t, far, MARGIN) - at_height(t, ref, MARGIN)),
                  1e3 * (at_height(t, far, REARM) - at_height(t, ref, REARM)),
                  k + 1 < WAYS ? ";" : ".");
    }
}

stein_status study_regulation(const study *s, study_part *part, stein_err *err)
{
    static const char *const head[WAYS][COLUMNS + 1] = {
        {"pawl.stop_shift [m]", "escapement_height [m]", "peak_string_force [N]",
         "impact_speed [m/s]", "impact_time [s]", "key_force [N]", "rearm_time [s]",
         "rearm_margin [m]", NULL},
        {"pawl.spring.k [N m/rad]", "escapement_height [m]", "peak_string_force [N]",
         "impact_speed [m/s]", "impact_time [s]", "key_force [N]", "rearm_time [s]",
         "rearm_margin [m]", NULL},
        {"pawl.spring.theta0 [rad]", "escapement_height [m]", "peak_string_force [N]",
         "impact_speed [m/s]", "impact_time [s]", "key_force [N]", "rearm_time [s]",
         "rearm_margin [m]", NULL}};
    static const char *const file[WAYS] = {"regulation_stop", "regulation_stiffness",
                                           "regulation_angle"};
    ways w = {.s = s};
    part->id = "regulation";
    part->title = "Two regulations: the stop or the spring";
    for (int k = 0; k < WAYS; k++) {
        if (stein_find_param(lab_equations(s->model), name[k]) < 0) {
            study_say(part, "Left out: the model has no parameter %s.", name[k]);
            return STEIN_OK;
        }
    }
    for (int k = 0; k < WAYS; k++) {
        w.table[k] = study_table_new(part, file[k], POINTS, head[k]);
        if (w.table[k] == NULL) {
            return lab__no_memory(err);
        }
    }
    stein_status status = study_each(s, "regulations", 2 * WAYS, find_end, &w, err);
    if (status == STEIN_OK) {
        status = study_each(s, "regulations", WAYS * POINTS, measure, &w, err);
    }
    if (status == STEIN_OK) {
        draw(part, &w);
        say(s, part, &w);
    }
    return status;
}
