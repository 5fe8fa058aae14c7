/* SPDX-License-Identifier: GPL-3.0-or-later
 * plot_run.c - a run as a picture, by gnuplot.
 *
 *   +--------------+--------------+
 *   | whole run    | around the   |   distance head to string
 *   |              | impact       |   key dip
 *   |              |              |   notch phase
 *   |              |              |   forces
 *   +--------------+--------------+
 *      time [ms]      time [ms]         thin vertical lines: escapement, impact
 *
 * A mechanism without a stroke has one column, with its channels gathered by unit. A curve is
 * thinned to the extremes of each pixel column, so it looks like all its samples and a peak cannot
 * get lost.
 */
#include <math.h>
#include <string.h>

#include "plot.h"
#include "run.h"

enum { MAX_PANELS = 6, MAX_CURVES = 6, PIXELS = 500 };

typedef struct curve {
    int channel;
    double scale; /* from the channel's unit to the panel's */
    const char *title;
} curve;

typedef struct panel {
    char label[64];
    double weight; /* share of the height */
    int is_phase;
    curve curve[MAX_CURVES];
    int ncurve;
} panel;

typedef struct plot {
    const lab_record *record;
    const stein_model *model;
    const lab_stroke *stroke;
    panel panel[MAX_PANELS];
    int npanel;
    double from[2], to[2]; /* of the columns [s] */
    int ncolumn;
    double time_scale; /* from s to the unit of the time axis */
} plot;

/* ---- curves ---- */

static panel *add_panel(plot *p, const char *label, double weight)
{
    panel *n = &p->panel[p->npanel++];
    *n = (panel){.weight = weight};
    snprintf(n->label, sizeof n->label, "%s", label);
    return n;
}

static void add_curve(panel *n, int channel, double scale, const char *title)
{
    if (channel >= 0 && n->ncurve < MAX_CURVES) {
        n->curve[n->ncurve++] = (curve){channel, scale, title};
    }
}

static void drop_if_empty(plot *p)
{
    p->npanel -= p->panel[p->npanel - 1].ncurve == 0;
}

static void plan_stroke(plot *p)
{
    const stein_model *m = p->model;
    panel *n = add_panel(p, "head to string [mm]", 1.2);
    add_curve(n, lab__channel_of(m, STEIN_READ_GAP, m->stroke.string), 1e3, "");
    drop_if_empty(p);
    n = add_panel(p, "key dip [mm]", 0.9);
    add_curve(n, stein_find_channel(m, "key_dip"), 1e3, "");
    drop_if_empty(p);
    n = add_panel(p, "notch phase", 0.8);
    n->is_phase = 1;
    add_curve(n, lab__channel_of(m, STEIN_READ_NOTCH_PHASE, m->stroke.notch), 1.0, "");
    drop_if_empty(p);
    n = add_panel(p, "force [N]", 1.4);
    add_curve(n, lab__channel_of(m, STEIN_READ_FORCE, m->stroke.string), 1.0, "string");
    add_curve(n, lab__channel_of(m, STEIN_READ_NOTCH_FORCE, m->stroke.notch), 1.0, "notch");
    if (m->load.body >= 0) {
        add_curve(n, lab__channel_of(m, STEIN_READ_FORCE, m->load.contact), 1.0, "load on key");
    }
    drop_if_empty(p);

    double end = p->to[0], e = p->stroke->escape_time, i = p->stroke->impact_time;
    double first = fmin(e, i), last = fmax(e, i); // fmin, fmax pass over NAN
    if (isfinite(first)) {
        p->ncolumn = 2;
        p->from[1] = fmax(p->from[0], first - 8e-3);
        p->to[1] = fmin(end, fmin(last, first + 30e-3) + 12e-3);
    }
}

static double largest(const lab_record *r, int channel)
{
    double m = 0.0;
    for (int row = 0; row < lab__record_rows(r); row++) {
        double v = fabs(lab__record_at(r, row, channel));
        m = isfinite(v) ? fmax(m, v) : m;
    }
    return m;
}

/* channels of one unit share a panel */
static void plan_channels(plot *p)
{
    const stein_model *m = p->model;
    for (int i = 1; i < m->nchannel; i++) {
        const char *unit = m->channels[i].unit;
        int seen = 0;
        for (int k = 1; k < i; k++) {
            seen = seen || strcmp(m->channels[k].unit, unit) == 0;
        }
        if (seen || p->npanel == MAX_PANELS) {
            continue;
        }
        panel *n = add_panel(p, "", 1.0);
        double size = 0.0;
        for (int k = i; k < m->nchannel; k++) {
            if (strcmp(m->channels[k].unit, unit) == 0) {
                add_curve(n, k, 1.0, m->channels[k].name);
                size = fmax(size, largest(p->record, k));
            }
        }
        int milli = strcmp(unit, "m") == 0 && size < 1.0;
        for (int k = 0; k < n->ncurve; k++) {
            n->curve[k].scale = milli ? 1e3 : 1.0;
        }
        snprintf(n->label, sizeof n->label, "%s%s[%s]", n->ncurve == 1 ? n->curve[0].title : "",
                 n->ncurve == 1 ? " " : "", milli ? "mm" : unit);
    }
}

/* ---- the script ---- */

static void write_row(FILE *f, const plot *p, int row, const curve *c)
{
    double v = lab__record_at(p->record, row, c->channel);
    if (isfinite(v)) {
        fprintf(f, "%.8g %.8g\n", p->time_scale * lab__record_at(p->record, row, 0), c->scale * v);
    } else {
        fprintf(f, "\n");
    }
}

/* the rows first, lowest, highest, last of one pixel column, in the order of time */
static void write_extremes(FILE *f, const plot *p, int from, int to, const curve *c)
{
    int low = from, high = from;
    for (int row = from; row < to; row++) {
        double v = lab__record_at(p->record, row, c->channel);
        low = v < lab__record_at(p->record, low, c->channel) ? row : low;
        high = v > lab__record_at(p->record, high, c->channel) ? row : high;
    }
    int rows[4] = {from, low < high ? low : high, low < high ? high : low, to - 1};
    for (int i = 0; i < 4; i++) {
        if (i == 0 || rows[i] != rows[i - 1]) {
            write_row(f, p, rows[i], c);
        }
    }
}

static void write_data(FILE *f, const plot *p, int column, const curve *c)
{
    double from = p->from[column], width = (p->to[column] - from) / PIXELS;
    int rows = lab__record_rows(p->record), row = 0;
    fprintf(f, "$c%dp%d << END\n", column, c->channel);
    while (row < rows && lab__record_at(p->record, row, 0) < from) {
        row++;
    }
    row -= row > 0; // the curve comes in from the left
    for (int pixel = 0; pixel <= PIXELS && row < rows; pixel++) {
        int end = row;
        while (end < rows && lab__record_at(p->record, end, 0) < from + width * (pixel + 1)) {
            end++;
        }
        if (end > row) {
            write_extremes(f, p, row, end, c);
        }
        row = end;
    }
    if (row < rows) {
        write_row(f, p, row, c);
    }
    fprintf(f, "END\n");
}

static void write_all_data(FILE *f, const plot *p)
{
    for (int i = 0; i < p->npanel; i++) {
        for (int k = 0; k < p->panel[i].ncurve; k++) {
            for (int column = 0; column < p->ncolumn; column++) {
                write_data(f, p, column, &p->panel[i].curve[k]);
            }
        }
    }
}

/* event lines; their names above the top panel of the wider view, on the outer sides */
static void write_events(FILE *f, const plot *p, int column, int top)
{
    const lab_stroke *s = p->stroke;
    fprintf(f, "unset arrow\nunset label\n");
    if (s == NULL) {
        return;
    }
    const double time[] = {s->escape_time, s->impact_time};
    static const char *const name[] = {"escapement", "impact"};
    for (int i = 0; i < 2; i++) {
        if (!(time[i] >= p->from[column] && time[i] <= p->to[column])) {
            continue;
        }
        double x = p->time_scale * time[i];
        fprintf(f,
                "set arrow from %.6f, graph 0 to %.6f, graph 1 nohead dt %d lw 1 lc '#7a7a7a' "
                "back\n",
                x, x, i == 0 ? 2 : 1);
        if (top && column == p->ncolumn - 1) {
            int left = !(time[i] > time[1 - i]); // alone: on the left
            fprintf(f, "set label '%s %.2f ms' at %.6f, graph 1.06 %s offset %d,0 tc '#505050'\n",
                    name[i], 1e3 * time[i], x, left ? "right" : "left", left ? 1 : -1);
        }
    }
}

static void write_panel(FILE *f, const plot *p, int i, int column)
{
    static const char *const colour[MAX_CURVES] = {"#1f4e79", "#b5482f", "#5d7f33",
                                                   "#7b5aa0", "#b58a1b", "#3f8f8f"};
    const panel *n = &p->panel[i];
    int bottom = i == p->npanel - 1;
    fprintf(f, "set xrange [%.9g:%.9g]\n", p->time_scale * p->from[column],
            p->time_scale * p->to[column]);
    if (bottom) {
        fprintf(f, "set format x '%%g'\nset xlabel 'time [%s]'\n",
                p->time_scale > 1.0 ? "ms" : "s");
    } else {
        fprintf(f, "set format x ''\nunset xlabel\n");
    }
    if (column == 0) {
        fprintf(f, "set ylabel ");
        lab__quoted(f, n->label);
        fprintf(f, " offset 0.5,0\n");
    } else {
        fprintf(f, "unset ylabel\n");
    }
    if (n->is_phase) {
        fprintf(f, "set yrange [-0.4:4.4]\nset ytics ('–' 0, 'i' 1, 'ii' 2, 'iii' 3, 'iv' 4)\n");
    } else {
        fprintf(f, "set yrange [*:*] noextend\nset offsets 0, 0, graph 0.05, graph 0.05\n"
                   "set ytics autofreq\n");
    }
    fprintf(f, n->ncurve > 1 && column == p->ncolumn - 1
                   ? "set key at graph 1, graph 1.01 right bottom horizontal samplen 1.6\n"
                   : "unset key\n");
    fprintf(f, "plot ");
    for (int k = 0; k < n->ncurve; k++) {
        fprintf(f, "%s$c%dp%d using 1:2 with %s lw 1.6 lc '%s' title ", k > 0 ? ", \\\n     " : "",
                column, n->curve[k].channel, n->is_phase ? "steps" : "lines", colour[k]);
        lab__quoted(f, n->curve[k].title);
    }
    fprintf(f, "\n");
}

static void write_title(FILE *f, const plot *p)
{
    char title[200];
    const lab_stroke *s = p->stroke;
    if (s == NULL) {
        snprintf(title, sizeof title, "%s", p->model->name);
    } else if (s->outcome == LAB_STRUCK && s->escaped) {
        snprintf(title, sizeof title,
                 "%s: escapement %.2f mm below the string, impact at %.2f m/s, peak force %.2f N",
                 p->model->name, 1e3 * s->escape_height, s->impact_speed, s->peak_string_force);
    } else {
        snprintf(title, sizeof title, "%s: %s", p->model->name, lab_outcome_text(s->outcome));
        for (char *c = strchr(title, ':'); *c != '\0'; c++) {
            if (*c == '_') {
                *c = ' ';
            }
        }
    }
    fprintf(f, "set label 99 ");
    lab__quoted(f, title);
    fprintf(f, " at screen 0.5, 0.978 center\n");
}

static void write_script(FILE *f, const void *ctx)
{
    const plot *p = ctx;
    double total = 0.0, top = p->stroke != NULL ? 0.925 : 0.945, low = 0.07;
    const double left[2] = {0.08, 0.58}, right[2] = {p->ncolumn == 2 ? 0.525 : 0.97, 0.98};
    for (int i = 0; i < p->npanel; i++) {
        total += p->panel[i].weight;
    }
    write_all_data(f, p);
    fprintf(f, "set border 3 lc '#404040'\nset tics out nomirror scale 0.6 tc '#202020'\n"
               "set grid lc '#e4e4e4' lw 0.8 lt 1\nset multiplot\n");
    for (int column = 0; column < p->ncolumn; column++) {
        double upper = top;
        for (int i = 0; i < p->npanel; i++) {
            double height = p->panel[i].weight / total * (top - low);
            fprintf(f, "set lmargin at screen %.4f\nset rmargin at screen %.4f\n", left[column],
                    right[column]);
            fprintf(f, "set tmargin at screen %.4f\nset bmargin at screen %.4f\n", upper,
                    upper - height + 0.032);
            upper -= height;
            write_events(f, p, column, i == 0);
            if (i == 0 && column == 0) {
                write_title(f, p);
            }
            write_panel(f, p, i, column);
        }
    }
    fprintf(f, "unset multiplot\n");
}

stein_status lab_plot(const char *path, const lab_record *record, const stein_model *model,
                      const lab_stroke *stroke, stein_err *err)
{
    plot p = {.record = record, .model = model, .stroke = stroke, .ncolumn = 1};
    int rows = lab__record_rows(record);
    if (rows < 2) {
        return lab__fail(err, STEIN_EINVAL, "%s: nothing to draw, %d samples", path, rows);
    }
    p.from[0] = lab__record_at(record, 0, 0);
    p.to[0] = lab__record_at(record, rows - 1, 0);
    p.time_scale = p.to[0] - p.from[0] < 2.0 ? 1e3 : 1.0;
    if (stroke != NULL) {
        plan_stroke(&p);
    } else {
        plan_channels(&p);
    }
    if (p.npanel == 0) {
        return lab__fail(err, STEIN_EINVAL, "%s: \"%s\" has no output to draw", path, model->name);
    }
    return lab__gnuplot(path, 1100, 900, write_script, &p, err);
}
