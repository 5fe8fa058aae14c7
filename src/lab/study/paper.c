/* SPDX-License-Identifier: GPL-3.0-or-later
 * paper.c - section 5 of the paper: figures 9, 11, 12, 13 over the shift dx of the pawl's stop.
 *
 * The paper's numbers: dynamic escapement at 2.2 mm, -20 mm per mm, working range -1.25 .. +0.2 mm,
 * 1 N per 0.2 mm; its straight lines are drawn beside the simulated results. The static
 * ("geometric") height is followed by static_escapement.c at every dx of the grid.
 */
#include <gsl/gsl_fit.h>
#include <math.h>
#include <stdlib.h>

#include "study.h"

static const double paper_height = 2.2e-3, paper_slope = -20.0, paper_force_slope = 5e3,
                    paper_left = -1.25e-3, paper_right = 0.2e-3;
static const double recorded_every = 0.1e-3; /* [s] */

enum {
    DX,
    DYNAMIC,
    STATIC,
    STATIC_DIP,
    STATIC_FORCE,
    ESCAPE,
    IMPACT,
    FLIGHT,
    FORCE,
    SPEED,
    COLUMNS
};

typedef struct statics_all {
    const study *s;
    study_static *statics;
} statics_all;

static stein_status press(void *ctx, stein_sim *sim, int i)
{
    statics_all *w = ctx;
    w->statics[i] = (study_static){.status = STEIN_EINVAL, .height = NAN};
    if (stein_set(sim, "pawl.stop_shift", w->s->point[i].dx, NULL) == STEIN_OK) {
        study_press_slowly(w->s, sim, &w->statics[i]);
    }
    return w->statics[i].status;
}

static stein_status fill(const study *s, study_part *part, study_static *statics, stein_err *err)
{
    static const char *const head[] = {"pawl.stop_shift [m]",
                                       "dynamic_height [m]",
                                       "static_height [m]",
                                       "static_dip [m]",
                                       "static_force [N]",
                                       "escapement_time [s]",
                                       "impact_time [s]",
                                       "free_flight [s]",
                                       "peak_string_force [N]",
                                       "impact_speed [m/s]",
                                       NULL};
    study_table *t = study_table_new(part, "", s->npoint, head);
    if (t == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < s->npoint; i++) {
        double *row = study_row(t, i);
        const lab_stroke *k = &s->point[i].stroke;
        row[DX] = s->point[i].dx;
        if (statics[i].status == STEIN_OK && statics[i].escaped) {
            row[STATIC] = statics[i].height;
            row[STATIC_DIP] = statics[i].dip;
            row[STATIC_FORCE] = statics[i].force;
        }
        if (s->point[i].status != STEIN_OK || k->outcome != LAB_STRUCK) {
            continue;
        }
        row[DYNAMIC] = k->escape_height;
        row[ESCAPE] = k->escape_time;
        row[IMPACT] = k->impact_time;
        row[FLIGHT] = k->free_flight;
        row[FORCE] = k->peak_string_force;
        row[SPEED] = k->impact_speed;
    }
    static const int figure11[] = {DX, DYNAMIC, STATIC, STATIC_DIP, STATIC_FORCE},
                     figure12[] = {DX, ESCAPE, IMPACT, FLIGHT}, figure13[] = {DX, FORCE, SPEED};
    int made = study_table_copy(part, "figure11", t, figure11, 5) &&
               study_table_copy(part, "figure12", t, figure12, 4) &&
               study_table_copy(part, "figure13", t, figure13, 3);
    return made ? STEIN_OK : lab__no_memory(err);
}

/* straight line through the finite points of column y with from <= dx <= to; the number of points
 */
static int fit(const study_table *t, int y, double from, double to, double *at0, double *slope)
{
    double a[256], b[256], c00, c01, c11, sum;
    int n = 0;
    for (int i = 0; i < t->nrow && n < 256; i++) {
        const double *row = study_row(t, i);
        if (row[DX] >= from - 1e-9 && row[DX] <= to + 1e-9 && isfinite(row[y])) {
            a[n] = row[DX];
            b[n++] = row[y];
        }
    }
    *at0 = *slope = NAN;
    if (n >= 3) {
        gsl_fit_linear(a, 1, b, 1, (size_t)n, at0, slope, &c00, &c01, &c11, &sum);
    }
    return n;
}

static double at_dx(const study_table *t, double dx, int column)
{
    for (int i = 0; i < t->nrow; i++) {
        if (fabs(study_row(t, i)[DX] - dx) < 1e-9) {
            return study_row(t, i)[column];
        }
    }
    return NAN;
}

/* the range of dx around 0 where the hammer escapes and strikes */
static void working_range(const study_table *t, double *left, double *right)
{
    *left = *right = NAN;
    for (int i = 0; i < t->nrow; i++) {
        const double *row = study_row(t, i);
        if (isfinite(row[DYNAMIC])) {
            *left = isnan(*left) ? row[DX] : *left;
            *right = row[DX];
        } else if (row[DX] <= 0.0) {
            *left = *right = NAN; // a hole: another range begins
        } else {
            break;
        }
    }
}

static void draw_heights(study_part *part, const study_table *t, double left, double right)
{
    study_chart *c = study_chart_new(part, "figure11", 760, 470, 1);
    study_panel *p = study_panel_new(c, "shift of the pawl stop Δx [mm]", "escapement height [mm]");
    p->band[0] = 1e3 * left;
    p->band[1] = 1e3 * right;
    p->legend = 1;
    p->x0 = -1.5;
    p->x1 = 0.3;
    p->y0 = 0.0;
    study_line_add(p, 1e3 * paper_left, 1e3 * (paper_height + paper_slope * paper_left),
                   -1e3 * paper_height / paper_slope, 0.0, "paper: 2.2 mm, −20 mm/mm");
    study_curve_add(p, t, DX, 1e3, DYNAMIC, 1e3, STUDY_BOTH, 0, "dynamic, 100 g load");
    study_curve_add(p, t, DX, 1e3, STATIC, 1e3, STUDY_BOTH, 1, "static, key pressed slowly");
}

static void say_heights(study_part *part, const study_table *t, double left, double right)
{
    double h0, slope, f0, fslope;
    fit(t, DYNAMIC, left, 0.0, &h0, &slope);
    fit(t, STATIC, left, 0.0, &f0, &fslope);
    double dynamic = 1e3 * at_dx(t, 0.0, DYNAMIC), statics = 1e3 * at_dx(t, 0.0, STATIC);
    study_say(part,
              "<b>Figure 11.</b> At the reference the hammer escapes %.2f mm below the string "
              "(paper: 2.2 mm); a straight line over the whole working range left of it (the table "
              "above ends "
              "at −1.2 mm) falls by "
              "%.1f mm per mm (paper: 20). Holding the height to 1 mm therefore takes a stop "
              "that stays within %.3f mm (paper: 0.05 mm). The action works from %+.2f to "
              "%+.2f mm (shaded; paper: −1.25 to +0.2 mm).",
              dynamic, -slope, 1.0 / fabs(slope), 1e3 * left, 1e3 * right);
    if (isfinite(statics)) {
        study_say(part,
                  "Pressed infinitely slowly the same action lets off at %.2f mm, %.2f mm %s "
                  "than under the falling load, with a slope of %.1f mm per mm.",
                  statics, fabs(statics - dynamic),
                  statics > dynamic ? "further from the string" : "nearer to the string", fslope);
    }
}

static void draw_times(study_part *part, const study_table *t, double left, double right)
{
    study_chart *c = study_chart_new(part, "figure12", 760, 560, 1);
    study_panel *p = study_panel_new(c, "shift of the pawl stop Δx [mm]",
                                     "time since the key was hit [ms] (read bottom-up)");
    p->band[0] = 1e3 * left;
    p->band[1] = 1e3 * right;
    p->legend = 1;
    p->x0 = -1.5;
    p->x1 = 0.3;
    p->y0 = 0.0;
    study_curve_add(p, t, DX, 1e3, IMPACT, 1e3, STUDY_BOTH, 1, "hammer hits the string");
    study_curve_add(p, t, DX, 1e3, ESCAPE, 1e3, STUDY_BOTH, 0, "hammer escapes");
    study_curve_add(p, t, DX, 1e3, FLIGHT, 1e3, STUDY_DASHED, 2, "free flight between them");
    (void)part;
}

static void say_times(study_part *part, const study_table *t, double left, double right)
{
    double first = NAN;
    for (int i = 0; i < t->nrow; i++) {
        const double *row = study_row(t, i);
        if (isnan(first) && row[ESCAPE] > row[IMPACT]) {
            first = row[DX];
        }
    }
    study_say(part,
              "<b>Figure 12.</b> From left to right of the working range the escapement comes "
              "%s (%.1f to %.1f ms); from there to the reference the impact comes %s (%.1f to "
              "%.1f ms) and the free flight %s from %.1f to %.1f ms.",
              at_dx(t, right, ESCAPE) > at_dx(t, left, ESCAPE) ? "later" : "earlier",
              1e3 * at_dx(t, left, ESCAPE), 1e3 * at_dx(t, right, ESCAPE),
              at_dx(t, 0.0, IMPACT) < at_dx(t, left, IMPACT) ? "earlier" : "later",
              1e3 * at_dx(t, left, IMPACT), 1e3 * at_dx(t, 0.0, IMPACT),
              at_dx(t, 0.0, FLIGHT) < at_dx(t, left, FLIGHT) ? "shrinks" : "grows",
              1e3 * at_dx(t, left, FLIGHT), 1e3 * at_dx(t, 0.0, FLIGHT));
    if (isfinite(first)) {
        study_say(part,
                  "From Δx = %+.2f mm on the hammer strikes before it escapes: the escapement "
                  "is forced.",
                  1e3 * first);
    }
}

static void draw_forces(study_part *part, const study_table *t, double left, double right)
{
    double f0 = at_dx(t, 0.0, FORCE);
    study_chart *c = study_chart_new(part, "figure13", 760, 470, 1);
    study_panel *p = study_panel_new(c, "shift of the pawl stop Δx [mm]", "peak string force [N]");
    p->band[0] = 1e3 * left;
    p->band[1] = 1e3 * right;
    p->legend = 1;
    p->x0 = -1.5;
    p->x1 = 0.3;
    p->y0 = 0.0;
    study_line_add(p, 1e3 * paper_left, f0 + paper_force_slope * paper_left, 0.0, f0,
                   "paper: 1 N per 0.2 mm, from our force at 0");
    study_line_add(p, 0.0, f0, 1e3 * paper_right, f0, "paper: about constant for Δx > 0");
    study_curve_add(p, t, DX, 1e3, FORCE, 1.0, STUDY_BOTH, 0, "simulated");
}

static void say_forces(study_part *part, const study_table *t, double left, double right)
{
    double f0, slope, most = 0.0, force = at_dx(t, 0.0, FORCE);
    fit(t, FORCE, left, 0.0, &f0, &slope);
    for (int i = 0; i < t->nrow; i++) {
        const double *row = study_row(t, i);
        if (row[DX] > 0.0 && row[DX] <= right + 1e-9 && isfinite(row[FORCE])) {
            most = fmax(most, fabs(row[FORCE] / force - 1.0));
        }
    }
    study_say(part,
              "<b>Figure 13.</b> The string is struck with %.2f N at the reference; to the left "
              "the peak force falls by %.2f N per 0.2 mm (paper: 1 N), to the right it changes by "
              "at most %.0f %% up to the end of the range (paper: about constant).",
              force, 0.2e-3 * slope, 100.0 * most);
}

/* ---- figure 9: the reference stroke ---- */

enum { TIME, DISTANCE, DIP };

static stein_status record_reference(const study *s, study_part *part, stein_err *err)
{
    static const char *const head[] = {"time [s]", "string_distance [m]", "key_dip [m]", NULL};
    const stein_model *m = lab_equations(s->model);
    int gap = lab__channel_of(m, STEIN_READ_GAP, m->stroke.string);
    int dip = stein_find_channel(m, "key_dip"), n = (int)(0.15 / recorded_every + 0.5) + 1;
    study_table *t = study_table_new(part, "figure09", n, head);
    stein_sim *sim = NULL;
    stein_status status = t != NULL ? study_sim(s, &sim, err) : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        double *row = study_row(t, i);
        status = stein_run(sim, i * recorded_every, err);
        row[TIME] = i * recorded_every;
        row[DISTANCE] = m->channels[gap].sign * stein_read(sim, gap);
        row[DIP] = dip >= 0 ? stein_read(sim, dip) : NAN;
    }
    stein_sim_destroy(sim);
    if (status != STEIN_OK) {
        return status;
    }
    study_chart *c = study_chart_new(part, "figure09", 760, 470, 1);
    study_panel *p =
        study_panel_new(c, "time since the load was released [ms]", "distance, dip [mm]");
    double h = 1e3 * s->reference.escape_height, e = 1e3 * s->reference.escape_time;
    double i = 1e3 * s->reference.impact_time, blow = 1e3 * s->reference.blow;
    p->legend = 1;
    p->x0 = 0.0;
    p->x1 = 150.0;
    study_line_add(p, e, 0.0, e, 1.02 * blow, "escapement");
    study_line_add(p, i, 0.0, i, 1.02 * blow, "impact");
    study_curve_add(p, t, TIME, 1e3, DISTANCE, 1e3, STUDY_LINE, 0, "head to string");
    study_curve_add(p, t, TIME, 1e3, DIP, 1e3, STUDY_LINE, 2, "key dip at the load");
    study_say(part,
              "<b>Figure 9.</b> The reference stroke under the %g g load: the head rises "
              "%.1f mm, escapes after %.1f ms %.2f mm below the string, strikes at %.1f ms with "
              "%.2f m/s; after %.0f ms the head is %.1f mm from the string again.",
              1e3 * lab_parameters(s->model)[stein_find_param(m, "load.mass")], blow, e, h, i,
              s->reference.impact_speed, 1e3 * study_row(t, n - 1)[TIME],
              1e3 * study_row(t, n - 1)[DISTANCE]);
    return STEIN_OK;
}

stein_status study_paper(const study *s, study_part *part, stein_err *err)
{
    part->id = "paper";
    part->title = "The paper's figures";
    statics_all w = {s, NULL};
    stein_status status = record_reference(s, part, err);
    if (status != STEIN_OK) {
        return status;
    }
    w.statics = calloc((size_t)s->npoint + 1, sizeof *w.statics);
    status = w.statics == NULL ? lab__no_memory(err)
                               : study_each(s, "static heights", s->npoint, press, &w, err);
    if (status == STEIN_OK) {
        status = fill(s, part, w.statics, err);
    }
    free(w.statics);
    if (status == STEIN_OK) {
        const study_table *t = &part->table[1]; // after figure 9's
        double left, right;
        working_range(t, &left, &right);
        draw_heights(part, t, left, right);
        say_heights(part, t, left, right);
        draw_times(part, t, left, right);
        say_times(part, t, left, right);
        draw_forces(part, t, left, right);
        say_forces(part, t, left, right);
    }
    return status;
}
