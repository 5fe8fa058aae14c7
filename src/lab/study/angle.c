/* SPDX-License-Identifier: GPL-3.0-or-later
 * angle.c - the notch's angle, 90 degrees in the early instruments, less later. Why?
 *
 * The vertical face stays, the roof rises away from the corner as the angle closes, so that the
 * beak leaves the roof sooner and rests on the corner alone. Every angle is regulated by the stop
 * to the same escapement height first, else the comparison would be one of regulations. Then:
 *
 *   sharpness    friction work in the notch between first slip in phase iii and escapement, and how
 *                long that slip lasts (stroke_details.c)
 *   precision    1 mm / |d height / d dx| at the regulated point: how exactly the stop must be set
 *   let-off      largest force at the key in a slow, even press (0.6 s) before escapement
 *   forced       largest force of the load on the key between impact and escapement, with the stop
 *                0.15 mm further right, where the hammer is still caught when it strikes
 *   re-arming    after the load is lifted at 0.2 s
 */
#include <math.h>
#include <stdlib.h>

#include "study.h"

enum { ANGLES = 7 };
static const double from = 90.0, to = 75.0; /* [deg] */
static const double slow = 0.6;             /* [s] of the slow press */
static const double too_far = 0.15e-3;      /* shift of the stop that forces the escapement [m] */
static const double degree = 0.017453292519943295;

enum {
    ANGLE,
    DX,
    HEIGHT,
    WORK,
    SLIP,
    PRECISION,
    LETOFF,
    REARM,
    MARGIN,
    FORCE,
    SPEED,
    FORCED,
    COLUMNS
};

typedef struct angles {
    const study *s;
    study_table *t;
    double height; /* to regulate to [m] */
} angles;

static stein_status look(void *ctx, stein_sim *sim, int i)
{
    angles *w = ctx;
    double *row = study_row(w->t, i), dx = NAN;
    row[ANGLE] = degree * (from + (to - from) * i / (ANGLES - 1));
    stein_set(sim, "pawl.notch_angle", row[ANGLE], NULL);
    if (!study_level(w->s, sim, "pawl.stop_shift", -0.4e-3, 0.1e-3, w->height, &dx)) {
        return STEIN_OK;
    }
    row[DX] = dx;
    stein_set(sim, "pawl.stop_shift", dx, NULL);
    row[PRECISION] = 1e-3 / fabs(study_height_slope(w->s, sim, "pawl.stop_shift", 0.02e-3));
    study_drive drive = study_drive_default();
    study_details details;
    drive.until = 0.5;
    drive.release = 0.2;
    study_strike(w->s, sim, &drive, NULL, &details);
    if (details.status == STEIN_ENOMEM) {
        return details.status;
    }
    row[HEIGHT] = details.stroke.escape_height;
    row[WORK] = details.slip_work;
    row[SLIP] = details.slip_time;
    row[REARM] = details.rearm_time;
    row[MARGIN] = details.rearm_margin;
    row[FORCE] = details.stroke.peak_string_force;
    row[SPEED] = details.stroke.impact_speed;
    drive = (study_drive){STUDY_STEADY, slow, 1.0, slow, NAN};
    study_strike(w->s, sim, &drive, NULL, &details);
    if (details.status == STEIN_ENOMEM) {
        return details.status;
    }
    row[LETOFF] = details.status == STEIN_OK ? details.key_force : NAN;

    // forced: the stop too far right, the hammer is on the string before it escapes
    stein_set(sim, "pawl.stop_shift", dx + too_far, NULL);
    drive = study_drive_default();
    study_strike(w->s, sim, &drive, NULL, &details);
    row[FORCED] = details.status == STEIN_OK ? details.forced_force : NAN;
    return details.status;
}

static void draw(study_part *part, const study_table *t)
{
    static const struct {
        int y;
        double scale;
        const char *label;
    } panel[] = {{WORK, 1e6, "friction work of the slip [µJ]"},
                 {SLIP, 1e3, "duration of the slip [ms]"},
                 {PRECISION, 1e3, "stop shift per mm of height [mm]"},
                 {LETOFF, 1.0, "let-off force, slow press [N]"},
                 {REARM, 1e3, "time to re-arm [ms]"},
                 {MARGIN, 1e3, "overlap once re-armed [mm]"}};
    study_chart *c = study_chart_new(part, "notch_angle", 1100, 720, 3);
    for (int i = 0; i < 6; i++) {
        study_panel *p = study_panel_new(c, "notch angle [deg]", panel[i].label);
        p->x0 = to;
        p->x1 = from;
        p->y0 = 0.0;
        study_curve_add(p, t, ANGLE, 1.0 / degree, panel[i].y, panel[i].scale, STUDY_BOTH, i % 3,
                        NULL);
    }
}

static double change(const study_table *t, int y)
{
    return 100.0 * (study_row(t, ANGLES - 1)[y] / study_row(t, 0)[y] - 1.0);
}

static const char *verdict(double percent, const char *more, const char *less)
{
    return fabs(percent) < 3.0 ? "hardly changes" : percent > 0.0 ? more : less;
}

static void say(const angles *w, study_part *part)
{
    const study_table *t = w->t;
    const double *a = study_row(t, 0), *b = study_row(t, ANGLES - 1);
    double forced = change(t, FORCED);
    double work = change(t, WORK), precision = change(t, PRECISION), letoff = change(t, LETOFF);
    double rearm = change(t, REARM), margin = change(t, MARGIN);
    study_say(part,
              "Every angle was regulated to %.2f mm with the stop; closing the notch from %.0f to "
              "%.0f degrees moves it by %+.3f mm. Between first slip and escapement the beak "
              "rubs off %.2f µJ at %.0f degrees and %.2f µJ at %.0f degrees (%+.1f %%), in "
              "%.2f ms and %.2f ms.",
              1e3 * w->height, from, to, 1e3 * (b[DX] - a[DX]), 1e6 * a[WORK], from, 1e6 * b[WORK],
              to, work, 1e3 * a[SLIP], 1e3 * b[SLIP]);
    study_say(part,
              "One millimetre of height takes %.4f mm at the stop at %.0f degrees and %.4f mm at "
              "%.0f degrees (%+.1f %%); the let-off force of a slow press goes from %.3f to %.3f N "
              "(%+.1f %%), re-arming from %.1f to %.1f ms (%+.1f %%) with an overlap of %.3f and "
              "%.3f mm.",
              1e3 * a[PRECISION], from, 1e3 * b[PRECISION], to, precision, a[LETOFF], b[LETOFF],
              letoff, 1e3 * a[REARM], 1e3 * b[REARM], rearm, 1e3 * a[MARGIN], 1e3 * b[MARGIN]);
    if (isfinite(a[FORCED]) && isfinite(b[FORCED])) {
        study_say(part,
                  "With the stop %.2f mm further right the escapement is forced: between impact "
                  "and escapement the load presses on the key with up to %.2f N (%.2f N at %.0f "
                  "degrees).",
                  1e3 * too_far, a[FORCED], b[FORCED], to);
    }
    study_say(part,
              "<b>What a maker gains</b> by the sharper notch: the rubbing before escapement %s, "
              "the tolerance of the stop %s, the let-off %s, a forced escapement %s, re-arming %s, "
              "the overlap %s.",
              verdict(work, "grows", "shrinks"), verdict(precision, "gets wider", "gets narrower"),
              verdict(letoff, "gets heavier", "gets lighter"),
              isfinite(forced) ? verdict(forced, "gets harder", "gets easier") : "is not seen",
              verdict(rearm, "gets slower", "gets quicker"),
              verdict(margin, "gets safer", "gets less safe"));
}

stein_status study_angle(const study *s, study_part *part, stein_err *err)
{
    static const char *const head[] = {"pawl.notch_angle [rad]",
                                       "pawl.stop_shift [m]",
                                       "escapement_height [m]",
                                       "slip_work [J]",
                                       "slip_time [s]",
                                       "stop_per_mm [m]",
                                       "letoff_force [N]",
                                       "rearm_time [s]",
                                       "rearm_margin [m]",
                                       "peak_string_force [N]",
                                       "impact_speed [m/s]",
                                       "forced_key_force [N]",
                                       NULL};
    part->id = "angle";
    part->title = "The angle of the notch";
    angles w = {.s = s, .height = s->reference.escape_height};
    if (stein_find_param(lab_equations(s->model), "pawl.notch_angle") < 0) {
        study_say(part, "Left out: the model has no parameter pawl.notch_angle.");
        return STEIN_OK;
    }
    w.t = study_table_new(part, "notch_angle", ANGLES, head);
    stein_status status =
        w.t == NULL ? lab__no_memory(err) : study_each(s, "notch angles", ANGLES, look, &w, err);
    if (status == STEIN_OK) {
        draw(part, w.t);
        say(&w, part);
    }
    return status;
}
