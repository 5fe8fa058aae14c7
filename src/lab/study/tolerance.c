/* SPDX-License-Identifier: GPL-3.0-or-later
 * tolerance.c - how far escapement heights scatter when parts are made, and which parts do it.
 *
 * Making tolerances (standard deviations): 1 % of every length, 0.01 rad of every angle (1 % of
 * slope; 1 % of an angle would depend on where it is counted from), 0.05 mm at the pawl's stop, 10
 * % of every felt (the stiffness a, b, c of one felt together, its damping D apart), 10 % of
 * friction. For other numbers the file's tolerance (+-), else 1 %. Every source is an independent
 * normal deviate; a source may move several parameters.
 *
 *   linear       var h = sum over sources of (sum over its parameters dh/dp sigma_p)^2, with the
 *                slopes of sensitivity.c; a group's share is its part of the sum
 *   Monte Carlo  actions are drawn and struck; splitmix64 with one stream a sample, so a sample
 *                depends on the seed and its number alone
 *
 * The escapement works only in a range of a few centimetres of height. So at full tolerances many
 * actions do not strike before they are regulated, and a spread cannot be measured on them. The
 * linear sum is therefore checked against a Monte Carlo at a tenth of the tolerances.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "study.h"

enum { GROUPS = 9, BINS = 40, MAX_SOURCES = 512 };
static const char *const group_name[GROUPS] = {
    "hammer geometry", "pawl geometry",    "key geometry", "frame and string",      "pawl stop",
    "pawl spring",     "felt and leather", "friction",     "masses, inertias, load"};
enum { HAMMER, PAWL, KEY, FRAME, STOP, SPRING, FELT, FRICTION, MASS };
static const double small = 0.1; /* scale of the Monte Carlo that checks the linear sum */

/* how one parameter scatters */
typedef struct scatter {
    double sigma; /* 0: not at all */
    int source, group;
} scatter;

static int starts(const char *name, const char *with)
{
    return strncmp(name, with, strlen(with)) == 0;
}

static int geometry_group(const char *name)
{
    return starts(name, "hammer.") || strstr(name, ".beak.") != NULL   ? HAMMER
           : starts(name, "pawl.") || strstr(name, ".corner.") != NULL ? PAWL
           : starts(name, "key.") || starts(name, "loops.")            ? KEY
                                                                       : FRAME;
}

static scatter scatter_of(const stein_param *p, double value)
{
    double stated = p->tolerance, size = fabs(value);
    if (strstr(p->name, ".initial.") != NULL || strstr(p->name, ".direction.") != NULL ||
        strstr(p->name, ".sensor.") != NULL || starts(p->name, "gravity")) {
        return (scatter){0.0, -1, MASS};
    }
    if (strcmp(p->name, "pawl.stop_shift") == 0) {
        return (scatter){0.05e-3, -1, STOP};
    }
    if (strstr(p->name, ".normal.") != NULL) {
        return (scatter){0.1 * size, -1, FELT};
    }
    if (strstr(p->name, ".friction.") != NULL) {
        return (scatter){0.1 * size, -1, FRICTION};
    }
    int angle = strcmp(p->unit, "rad") == 0, spring = strstr(p->name, ".spring.") != NULL;
    if (angle || strcmp(p->unit, "m") == 0) {
        return (scatter){angle ? 0.01 : 0.01 * size, -1, spring ? SPRING : geometry_group(p->name)};
    }
    if (spring) {
        return (scatter){stated > 0.0 ? stated : 0.01 * size, -1, SPRING};
    }
    return (scatter){stated > 0.0 ? stated : 0.01 * size, -1, MASS};
}

/* the stiffness numbers of one felt share a source */
static int same_felt(const char *a, const char *b)
{
    const char *dot = strrchr(a, '.');
    return strstr(a, ".normal.") != NULL && strchr("abc", dot[1]) != NULL &&
           strncmp(a, b, (size_t)(dot - a) + 1) == 0 && strchr("abc", b[dot - a + 1]) != NULL &&
           b[dot - a + 1] != '\0';
}

static int find_scatter(const study *s, scatter *of)
{
    const stein_model *m = lab_equations(s->model);
    int sources = 0;
    for (int i = 0; i < m->np; i++) {
        of[i] = scatter_of(&m->params[i], lab_parameters(s->model)[i]);
        for (int k = 0; k < i && of[i].source < 0; k++) {
            if (same_felt(m->params[i].name, m->params[k].name)) {
                of[i].source = of[k].source;
            }
        }
        of[i].source = of[i].source < 0 ? sources++ : of[i].source;
    }
    return sources;
}

/* ---- Monte Carlo ---- */

static double uniform(unsigned long long *state)
{
    unsigned long long z = (*state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
    return ((double)(z >> 11) + 0.5) * 0x1p-53;
}

static double normal(unsigned long long *state)
{
    double u = uniform(state), v = uniform(state);
    return sqrt(-2.0 * stein__log_of(u)) * stein__cos(6.283185307179586 * v);
}

typedef struct drawing {
    const study *s;
    const scatter *of;
    int sources;
    double scale, *height;
} drawing;

static stein_status draw_one(void *ctx, stein_sim *sim, int i)
{
    drawing *w = ctx;
    const stein_model *m = lab_equations(w->s->model);
    unsigned long long state = w->s->seed + 0x632be59bd9b4e019ull * (unsigned long long)(i + 1);
    double z[MAX_SOURCES];
    int possible = 1; // a draw outside of a number's range has no height
    uniform(&state);
    for (int k = 0; k < w->sources && k < MAX_SOURCES; k++) {
        z[k] = normal(&state);
    }
    for (int k = 0; k < m->np; k++) {
        if (w->of[k].sigma > 0.0 && w->of[k].source < MAX_SOURCES) {
            double value =
                lab_parameters(w->s->model)[k] + w->scale * w->of[k].sigma * z[w->of[k].source];
            possible &= stein_set(sim, m->params[k].name, value, NULL) == STEIN_OK;
        }
    }
    w->height[i] = possible ? study_height(w->s, sim) : NAN;
    return STEIN_OK;
}

static stein_status monte_carlo(const study *s, const scatter *of, int sources, double scale,
                                double *height, stein_err *err)
{
    drawing w = {s, of, sources, scale, height};
    for (int i = 0; i < s->samples; i++) {
        height[i] = NAN;
    }
    return study_each(s, "Monte Carlo", s->samples, draw_one, &w, err);
}

stein_status study_monte_carlo(const study *s, double scale, double *height, stein_err *err)
{
    scatter *of = calloc((size_t)lab_equations(s->model)->np + 1, sizeof *of);
    stein_status status = of == NULL ? lab__no_memory(err) : STEIN_OK;
    if (status == STEIN_OK) {
        status = monte_carlo(s, of, find_scatter(s, of), scale, height, err);
    }
    free(of);
    return status;
}

/* ---- the linear sum ---- */

/* variance of the height by group; the sum */
static double linear(const study *s, const scatter *of, int sources, double variance[GROUPS])
{
    double total = 0.0;
    memset(variance, 0, sizeof *variance * GROUPS);
    for (int k = 0; k < sources; k++) {
        double move = 0.0;
        int group = MASS;
        for (int i = 0; i < s->nslope; i++) {
            const study_slope *slope = &s->slope[i];
            if (of[slope->param].source == k && isfinite(slope->slope[0])) {
                move += slope->slope[0] / slope->unit * of[slope->param].sigma;
                group = of[slope->param].group;
            }
        }
        variance[group] += move * move;
        total += move * move;
    }
    return total;
}

/* one row a source: its first parameter and its share, the largest first */
static int fill_sources(const study *s, const scatter *of, int sources, double total,
                        study_table *t)
{
    const stein_model *m = lab_equations(s->model);
    t->label = calloc((size_t)sources + 1, sizeof *t->label);
    t->label_head = "parameter";
    for (int k = 0; t->label != NULL && k < sources; k++) {
        double move = 0.0, sigma = 0.0;
        const char *name = "";
        for (int i = s->nslope - 1; i >= 0; i--) {
            const study_slope *slope = &s->slope[i];
            if (of[slope->param].source == k && isfinite(slope->slope[0])) {
                sigma = of[slope->param].sigma;
                move += slope->slope[0] / slope->unit * sigma;
                name = m->params[slope->param].name;
            }
        }
        int at = k; // insertion, by share
        for (; at > 0 && study_row(t, at - 1)[2] < move * move / total; at--) {
            memcpy(study_row(t, at), study_row(t, at - 1), 3 * sizeof(double));
            t->label[at] = t->label[at - 1];
        }
        t->label[at] = lab__text("%s", name);
        study_row(t, at)[0] = sigma;
        study_row(t, at)[1] = move;
        study_row(t, at)[2] = move * move / total;
    }
    int shown = 0; // sources that move nothing are no rows
    while (t->label != NULL && shown < sources && study_row(t, shown)[2] > 0.0) {
        shown++;
    }
    for (int k = shown; t->label != NULL && k < sources; k++) {
        free(t->label[k]);
        t->label[k] = NULL;
    }
    t->nrow = shown;
    return study_is_labelled(t);
}

static int moments(const double *height, int n, double *mean, double *deviation)
{
    double sum = 0.0, squares = 0.0;
    int works = 0;
    for (int i = 0; i < n; i++) {
        if (isfinite(height[i])) {
            sum += height[i];
            works++;
        }
    }
    *mean = works > 0 ? sum / works : NAN;
    for (int i = 0; i < n; i++) {
        squares += isfinite(height[i]) ? (height[i] - *mean) * (height[i] - *mean) : 0.0;
    }
    *deviation = works > 1 ? sqrt(squares / (works - 1)) : NAN;
    return works;
}

/* ---- tables and pictures ---- */

static int fill_groups(const double variance[GROUPS], double total, study_table *t)
{
    int order[GROUPS];
    t->label = calloc(GROUPS + 1, sizeof *t->label);
    t->label_head = "group";
    for (int i = 0; i < GROUPS; i++) {
        int k = i;
        for (; k > 0 && variance[order[k - 1]] < variance[i]; k--) {
            order[k] = order[k - 1];
        }
        order[k] = i;
    }
    for (int i = 0; t->label != NULL && i < GROUPS; i++) {
        t->label[i] = lab__text("%s", group_name[order[i]]);
        study_row(t, i)[0] = sqrt(variance[order[i]]);
        study_row(t, i)[1] = variance[order[i]] / total;
    }
    return study_is_labelled(t);
}

static void fill_bins(const double *height, int n, double mean, double deviation, study_table *t)
{
    double from = mean - 4.0 * deviation, width = 8.0 * deviation / BINS;
    for (int k = 0; k < BINS; k++) {
        double *row = study_row(t, k), x = from + (k + 0.5) * width, z = (x - mean) / deviation;
        row[0] = x;
        row[1] = 0.0;
        row[2] = n * width * stein__exp_of(-0.5 * z * z) / (deviation * 2.5066282746310002);
    }
    for (int i = 0; i < n; i++) {
        double k = floor((height[i] - from) / width);
        if (k >= 0.0 && k < BINS) {
            study_row(t, (int)k)[1] += 1.0;
        }
    }
}

typedef struct outcome {
    int works, works_small, forced;
    double mean, deviation, mean_small, deviation_small, linear;
} outcome;

static void draw(study_part *part, const study_table *groups, const study_table *bins)
{
    study_chart *c = study_chart_new(part, "tolerance", 1100, 430, 2);
    c->left = 0.175;
    study_panel *p = study_panel_new(c, "share of the height's variance [%]", "");
    study_curve_add(p, groups, 1, 100.0, 0, 1.0, STUDY_BARS, 0, NULL);
    p = study_panel_new(c, "escapement height at a tenth of the tolerances [mm]", "actions");
    p->legend = 1;
    p->y0 = 0.0;
    study_curve_add(p, bins, 0, 1e3, 1, 1.0, STUDY_STEPS, 0, "simulated");
    study_curve_add(p, bins, 0, 1e3, 2, 1.0, STUDY_LINE, 1,
                    "normal distribution by the linear sum");
}

static void say(const study *s, study_part *part, const outcome *o, const study_table *groups)
{
    double slope = NAN;
    for (int i = 0; i < s->nslope; i++) {
        const char *name = lab_equations(s->model)->params[s->slope[i].param].name;
        slope =
            strcmp(name, "pawl.stop_shift") == 0 ? s->slope[i].slope[0] / s->slope[i].unit : slope;
    }
    study_say(part,
              "Parts made to 1 %% of every length, 0.01 rad of every angle, 0.05 mm at the stop "
              "and 10 %% of "
              "felt scatter the escapement height by <b>%.1f mm</b> (standard deviation, linear "
              "sum): %.2f mm at the stop is what the technician must be able to regulate out.",
              1e3 * o->linear, 1e3 * o->linear / fabs(slope));
    study_say(part, "The largest shares are %s (%.0f %%), %s (%.0f %%) and %s (%.0f %%).",
              groups->label[0], 100.0 * study_row(groups, 0)[1], groups->label[1],
              100.0 * study_row(groups, 1)[1], groups->label[2], 100.0 * study_row(groups, 2)[1]);
    study_say(part,
              "Of %d actions drawn at these tolerances (seed %llu) %d escape before they are "
              "regulated, %d of them on the string already; their heights are %.1f mm on average "
              "with a deviation of %.1f mm.",
              s->samples, s->seed, o->works, o->forced, 1e3 * o->mean, 1e3 * o->deviation);
    study_say(part,
              "At a tenth of the tolerances %d of %d escape; their deviation of %.3f mm is %.2f "
              "times the linear %.3f mm.",
              o->works_small, s->samples, 1e3 * o->deviation_small,
              o->deviation_small / (small * o->linear), 1e3 * small * o->linear);
}

static stein_status report(const study *s, study_part *part, const scatter *of, int sources,
                           double *height, stein_err *err)
{
    static const char *const group_head[] = {"height_deviation [m]", "share [1]", NULL};
    static const char *const source_head[] = {"deviation [SI]", "height_deviation [m]", "share [1]",
                                              NULL};
    static const char *const bin_head[] = {"escapement_height [m]", "actions [1]", "linear [1]",
                                           NULL};
    static const char *const sample_head[] = {"escapement_height [m]", "at_a_tenth [m]", NULL};
    double variance[GROUPS];
    outcome o;
    double total = linear(s, of, sources, variance);
    o.linear = sqrt(total);
    study_table *groups = study_table_new(part, "tolerance", GROUPS, group_head);
    study_table *samples = study_table_new(part, "tolerance_samples", s->samples, sample_head);
    study_table *bins = study_table_new(part, "", BINS, bin_head);
    study_table *each = study_table_new(part, "tolerance_parameters", sources, source_head);
    if (groups == NULL || samples == NULL || bins == NULL || each == NULL ||
        !fill_groups(variance, total, groups) || !fill_sources(s, of, sources, total, each)) {
        return lab__no_memory(err);
    }
    stein_status status = monte_carlo(s, of, sources, 1.0, height, err);
    o.works = moments(height, s->samples, &o.mean, &o.deviation);
    o.forced = 0;
    for (int i = 0; i < s->samples; i++) {
        study_row(samples, i)[0] = height[i];
        o.forced += height[i] == 0.0;
    }
    if (status == STEIN_OK) {
        status = monte_carlo(s, of, sources, small, height, err);
    }
    if (status == STEIN_OK) {
        o.works_small = moments(height, s->samples, &o.mean_small, &o.deviation_small);
        for (int i = 0; i < s->samples; i++) {
            study_row(samples, i)[1] = height[i];
        }
        fill_bins(height, s->samples, s->reference.escape_height, small * o.linear, bins);
        draw(part, groups, bins);
        say(s, part, &o, groups);
        study_say(part,
                  "The single parameters that matter most are %s (%.0f %%), %s (%.0f %%) and %s "
                  "(%.0f %%).",
                  each->label[0], 100.0 * study_row(each, 0)[2], each->label[1],
                  100.0 * study_row(each, 1)[2], each->label[2], 100.0 * study_row(each, 2)[2]);
    }
    return status;
}

stein_status study_tolerance(const study *s, study_part *part, stein_err *err)
{
    part->id = "tolerance";
    part->title = "Making tolerances";
    scatter *of = calloc((size_t)lab_equations(s->model)->np + 1, sizeof *of);
    double *height = calloc((size_t)s->samples + 1, sizeof *height);
    stein_status status = of == NULL || height == NULL
                              ? lab__no_memory(err)
                              : report(s, part, of, find_scatter(s, of), height, err);
    free(of);
    free(height);
    return status;
}
