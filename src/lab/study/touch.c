/* SPDX-License-Identifier: GPL-3.0-or-later
 * touch.c - response of the action to the player: loads from 40 to 400 g, keys pressed and struck.
 *
 * The paper drives with one mass. An agreement under a prescribed force is weak evidence about an
 * action (Thorin, Boutillon & Lozada 2014). So the key is also moved by prescribed motions, over
 * the path that it has under the load. It is pressed (quintic in time, from rest to rest) and
 * struck (full speed at once, slowing evenly). Key speed means the way of the load's place by the
 * time it takes: the duration of the motion, or, under a load, the time to the impact.
 *
 * Usable are strokes that let the hammer go, strike once, and answer to the player. Near the
 * softest stroke the head's speed falls to nothing within a few percent of key speed. There the
 * exponent d ln(head speed) / d ln(key speed), taken to the next slower stroke, exceeds 3. (At a
 * prescribed motion the hammer often flies ahead of the slowing key and leaves the notch only
 * afterwards.) The softest blow is found by bisection between two durations, one of which reaches
 * the string.
 */
#include <math.h>
#include <stdlib.h>

#include "functions.h"
#include "study.h"

enum { LOADS = 11, SPEEDS = 21, KINDS = 2, HALVINGS = 14 };
static const double lightest = 0.04, heaviest = 0.4; /* [kg] */
static const double slowest = 0.4, quickest = 0.012; /* duration of the key's way [s] */

enum { INPUT, KEY_SPEED, HEIGHT, SPEED, FORCE, IMPACTS, CAUGHT, EXPONENT, USABLE, COLUMNS };

typedef struct touches {
    const study *s;
    study_table *t[1 + KINDS]; /* load, pressed, struck */
    double softest[KINDS];     /* key speed from which on the string is reached [m/s] */
} touches;

static const double answers = 3.0; /* largest exponent that a player can handle */

static int reaches(const study_details *details)
{
    return details->status == STEIN_OK && details->stroke.outcome == LAB_STRUCK;
}

/* strikes once and answers to the player; rows go from slow to fast */
static void judge(const study_table *t)
{
    for (int i = 0; i < t->nrow; i++) {
        double *row = study_row(t, i), *slower = i > 0 ? study_row(t, i - 1) : NULL;
        double exponent = NAN;
        if (slower != NULL) {
            exponent = stein__log_of(row[SPEED] / slower[SPEED]) /
                       stein__log_of(row[KEY_SPEED] / slower[KEY_SPEED]);
        }
        row[EXPONENT] = exponent;
        row[USABLE] = row[IMPACTS] == 1.0 && isfinite(row[SPEED]) && exponent <= answers;
    }
}

/* a load has no threshold: it strikes once or not */
static void judge_loads(const study_table *t)
{
    for (int i = 0; i < t->nrow; i++) {
        double *row = study_row(t, i);
        row[USABLE] = row[IMPACTS] == 1.0 && isfinite(row[SPEED]);
    }
}

static double way(const study *s)
{
    return fabs(s->arm * (s->key_down - s->key_rest));
}

static void note(double *row, const study_details *details)
{
    if (details->status != STEIN_OK) {
        return;
    }
    row[IMPACTS] = details->stroke.impacts;
    row[CAUGHT] = details->stroke.forced_escapement;
    row[HEIGHT] = details->stroke.escape_height; // also of strokes that do not reach the string
    if (details->stroke.outcome == LAB_STRUCK) {
        row[SPEED] = details->stroke.impact_speed;
        row[FORCE] = details->stroke.peak_string_force;
    }
}

static stein_status fall(void *ctx, stein_sim *sim, int i)
{
    touches *w = ctx;
    double *row = study_row(w->t[0], i);
    study_drive drive = study_drive_default();
    study_details details;
    row[INPUT] = lightest * stein__power(heaviest / lightest, (double)i / (LOADS - 1));
    stein_set(sim, "load.mass", row[INPUT], NULL);
    drive.until = 0.25;
    study_strike(w->s, sim, &drive, NULL, &details);
    note(row, &details);
    row[KEY_SPEED] = w->s->input >= 0 ? way(w->s) / details.stroke.impact_time : NAN;
    return details.status;
}

static void play_key(const touches *w, stein_sim *sim, study_touch touch, double travel,
                     study_details *details)
{
    study_drive drive = {touch, travel, 1.0, travel + 0.12, NAN};
    study_strike(w->s, sim, &drive, NULL, details);
}

static stein_status press(void *ctx, stein_sim *sim, int i)
{
    touches *w = ctx;
    int kind = i / SPEEDS, k = i % SPEEDS;
    double *row = study_row(w->t[1 + kind], k);
    study_details details;
    row[INPUT] = slowest * stein__power(quickest / slowest, (double)k / (SPEEDS - 1));
    row[KEY_SPEED] = way(w->s) / row[INPUT];
    play_key(w, sim, kind == 0 ? STUDY_PRESSED : STUDY_STRUCK, row[INPUT], &details);
    note(row, &details);
    return details.status;
}

/* the softest stroke that still reaches the string */
static stein_status soften(void *ctx, stein_sim *sim, int kind)
{
    touches *w = ctx;
    const study_table *t = w->t[1 + kind];
    study_details details;
    int first = 0;
    while (first < SPEEDS && isnan(study_row(t, first)[SPEED])) {
        first++;
    }
    w->softest[kind] = NAN;
    if (first == SPEEDS) {
        return STEIN_OK;
    }
    double good = study_row(t, first)[INPUT],
           bad = first > 0 ? study_row(t, first - 1)[INPUT] : NAN;
    for (int n = 0; n < HALVINGS && isfinite(bad); n++) {
        double middle = 0.5 * (good + bad);
        play_key(w, sim, kind == 0 ? STUDY_PRESSED : STUDY_STRUCK, middle, &details);
        if (details.status == STEIN_ENOMEM) {
            return details.status;
        }
        if (reaches(&details)) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    w->softest[kind] = way(w->s) / good;
    return STEIN_OK;
}

static void draw(const touches *w, study_part *part)
{
    static const char *const title[] = {"pressed", "struck"};
    study_chart *c = study_chart_new(part, "touch", 1100, 430, 3);
    study_panel *p = study_panel_new(c, "load on the key [g]", "hammer speed at the string [m/s]");
    p->y0 = 0.0;
    study_curve_add(p, w->t[0], INPUT, 1e3, SPEED, 1.0, STUDY_BOTH, 0, NULL);
    p = study_panel_new(c, "key speed [m/s]", "hammer speed at the string [m/s]");
    p->legend = 1;
    p->logx = p->logy = 1;
    study_curve_add(p, w->t[0], KEY_SPEED, 1.0, SPEED, 1.0, STUDY_BOTH, 0, "load");
    for (int k = 0; k < KINDS && w->s->input >= 0; k++) {
        study_curve_add(p, w->t[1 + k], KEY_SPEED, 1.0, SPEED, 1.0, STUDY_BOTH, 1 + k, title[k]);
    }
    p = study_panel_new(c, "key speed [m/s]", "escapement height [mm]");
    p->logx = 1;
    p->y0 = 0.0;
    study_curve_add(p, w->t[0], KEY_SPEED, 1.0, HEIGHT, 1e3, STUDY_POINTS, 0, NULL);
    for (int k = 0; k < KINDS && w->s->input >= 0; k++) {
        study_curve_add(p, w->t[1 + k], KEY_SPEED, 1.0, HEIGHT, 1e3, STUDY_POINTS, 1 + k, NULL);
    }
}

/* lowest and highest head speed of the usable strokes */
static int range(const study_table *t, double *low, double *high, double *at_low, double *at_high)
{
    int n = 0;
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < t->nrow; i++) {
        const double *row = study_row(t, i);
        if (!(row[USABLE] > 0.0)) {
            continue;
        }
        n++;
        if (row[SPEED] < *low) {
            *low = row[SPEED];
            *at_low = row[INPUT];
        }
        if (row[SPEED] > *high) {
            *high = row[SPEED];
            *at_high = row[INPUT];
        }
    }
    return n;
}

static void say(const touches *w, study_part *part)
{
    double low, high, at_low = NAN, at_high = NAN;
    if (range(w->t[0], &low, &high, &at_low, &at_high) > 0) {
        study_say(part,
                  "Under falling loads from %.0f to %.0f g, %d of %d let the hammer go and strike "
                  "once: the head arrives with %.2f m/s (%.0f g) to %.2f m/s "
                  "(%.0f g), a dynamic range of %.1f : 1.",
                  1e3 * lightest, 1e3 * heaviest, range(w->t[0], &low, &high, &at_low, &at_high),
                  LOADS, low, 1e3 * at_low, high, 1e3 * at_high, high / low);
    } else {
        study_say(part, "No load from %.0f to %.0f g gives a usable stroke.", 1e3 * lightest,
                  1e3 * heaviest);
    }
    for (int k = 0; k < KINDS && w->s->input >= 0; k++) {
        const study_table *t = w->t[1 + k];
        int n = range(t, &low, &high, &at_low, &at_high);
        int twice = 0, caught = 0;
        for (int i = 0; i < SPEEDS; i++) {
            const double *row = study_row(t, i);
            twice += row[IMPACTS] > 1.0;
            caught += row[IMPACTS] > 1.0 && row[CAUGHT] > 0.0;
        }
        if (twice > 0) {
            study_say(part,
                      "Of %d %s strokes %d touch the string more than once; in %d of these the "
                      "beak was still under the roof at the first touch.",
                      SPEEDS, k == 0 ? "pressed" : "struck", twice, caught);
        }
        if (n == 0) {
            study_say(part, "No stroke of a %s key is usable.", k == 0 ? "pressed" : "struck");
            continue;
        }
        if (n == 1) {
            study_say(part,
                      "A key that is <b>%s</b> reaches the string from %.3f m/s of key speed on; "
                      "a single one of %d strokes is usable (%.2f m/s at the head).",
                      k == 0 ? "pressed" : "struck", w->softest[k], SPEEDS, low);
            continue;
        }
        study_say(part,
                  "A key that is <b>%s</b> reaches the string from %.3f m/s of key speed on; "
                  "%d of %d strokes are usable, from %.3f to %.2f m/s of key speed, with %.2f to "
                  "%.2f m/s at the head: a dynamic range of %.1f : 1.",
                  k == 0 ? "pressed" : "struck", w->softest[k], n, SPEEDS, way(w->s) / at_low,
                  way(w->s) / at_high, low, high, high / low);
    }
    if (w->s->input >= 0) {
        double first = NAN, last = NAN;
        for (int i = 0; i < SPEEDS; i++) {
            double h = study_row(w->t[1], i)[HEIGHT];
            first = isnan(first) ? h : first;
            last = isfinite(h) ? h : last;
        }
        study_say(part,
                  "The escapement height of the pressed key goes from %.2f mm at the slowest "
                  "motion to %.2f mm at the fastest.",
                  1e3 * first, 1e3 * last);
    } else {
        study_say(part, "Prescribed key motions are left out: %s.", w->s->left_out);
    }
}

stein_status study_touches(const study *s, study_part *part, stein_err *err)
{
    static const char *const load[] = {"load.mass [kg]",
                                       "key_speed [m/s]",
                                       "escapement_height [m]",
                                       "impact_speed [m/s]",
                                       "peak_string_force [N]",
                                       "impacts [1]",
                                       "escapes_after_impact [1]",
                                       "exponent [1]",
                                       "usable [1]",
                                       NULL};
    static const char *const key[] = {"duration [s]",
                                      "key_speed [m/s]",
                                      "escapement_height [m]",
                                      "impact_speed [m/s]",
                                      "peak_string_force [N]",
                                      "impacts [1]",
                                      "escapes_after_impact [1]",
                                      "exponent [1]",
                                      "usable [1]",
                                      NULL};
    part->id = "touch";
    part->title = "Touch";
    touches w = {.s = s, .softest = {NAN, NAN}};
    w.t[0] = study_table_new(part, "touch_load", LOADS, load);
    int complete = w.t[0] != NULL;
    if (s->input >= 0) {
        w.t[1] = study_table_new(part, "touch_pressed", SPEEDS, key);
        w.t[2] = study_table_new(part, "touch_struck", SPEEDS, key);
        complete = complete && w.t[1] != NULL && w.t[2] != NULL;
    }
    if (!complete) {
        return lab__no_memory(err);
    }
    stein_status status = study_each(s, "loads", LOADS, fall, &w, err);
    if (status == STEIN_OK && s->input >= 0) {
        status = study_each(s, "key motions", KINDS * SPEEDS, press, &w, err);
    }
    if (status == STEIN_OK && s->input >= 0) {
        judge(w.t[1]);
        judge(w.t[2]);
        status = study_each(s, "softest strokes", KINDS, soften, &w, err);
    }
    if (status == STEIN_OK) {
        judge_loads(w.t[0]);
        draw(&w, part);
        say(&w, part);
    }
    return status;
}
