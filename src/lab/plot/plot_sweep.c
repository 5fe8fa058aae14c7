/* SPDX-License-Identifier: GPL-3.0-or-later
 * plot_sweep.c - a sweep as a picture.
 *
 *   one varied parameter    panels over it: escapement height, times, peak force
 *   two                     a map of the escapement height, one cell a point; grey: none
 *
 * A mechanism without stroke shows its final outputs, gathered by unit, or the first of them as a
 * map. Axes with one value do not count. Cells reach half-way to their neighbours, so lists of any
 * spacing are drawn true to scale; nothing is interpolated.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"
#include "sweep.h"

enum { MAX_PANELS = 6, MAX_CURVES = 6, LABEL = 2 * MECH_PATH };

typedef struct panel {
    char label[LABEL];
    double scale; /* from SI to what is shown */
    int column[MAX_CURVES], ncurve;
} panel;

typedef struct picture {
    const lab_table *table;
    const lab__axis *axis[2]; /* varied */
    int step[2];              /* of the point's index along them */
    int *order[2];            /* [n] indices on the axis by rising value */
    int naxis;
    panel panel[MAX_PANELS];
    int npanel;
    int is_stroke;
} picture;

/* ---- columns ---- */

static char *title_of(const lab_table *t, int column, char text[LABEL])
{
    const char *line = t->head;
    while (*line == '#') {
        line += strcspn(line, "\n") + 1;
    }
    for (; column > 0; column--) {
        line += strcspn(line, ",") + 1;
    }
    snprintf(text, LABEL, "%.*s", (int)strcspn(line, ",\n"), line);
    return text;
}

/* "NAME [UNIT]" cut in two */
static void cut_title(char *text, char unit[MECH_UNIT])
{
    char *bracket = strstr(text, " [");
    snprintf(unit, MECH_UNIT, "%s", bracket != NULL ? bracket + 2 : "1]");
    unit[strcspn(unit, "]")] = '\0';
    if (bracket != NULL) {
        *bracket = '\0';
    }
}

static double largest(const lab_table *t, int column)
{
    double m = 0.0;
    for (int i = 0; i < t->n; i++) {
        double v = fabs(lab__table_number(t, i, column));
        m = isfinite(v) ? fmax(m, v) : m;
    }
    return m;
}

static panel *add_panel(picture *p, const char *label, double scale)
{
    panel *n = &p->panel[p->npanel++];
    *n = (panel){.scale = scale};
    snprintf(n->label, sizeof n->label, "%s", label);
    return n;
}

static void add_curve(panel *n, int column)
{
    if (column >= 0 && n->ncurve < MAX_CURVES) {
        n->column[n->ncurve++] = column;
    }
}

static void plan_stroke(picture *p)
{
    const lab_table *t = p->table;
    add_curve(add_panel(p, "escapement height [mm]", 1e3),
              lab__table_column(t, "escapement_height"));
    if (p->naxis == 2) {
        return;
    }
    panel *n = add_panel(p, "time [ms]", 1e3);
    add_curve(n, lab__table_column(t, "escapement_time"));
    add_curve(n, lab__table_column(t, "impact_time"));
    add_curve(add_panel(p, "peak string force [N]", 1.0),
              lab__table_column(t, "peak_string_force"));
}

/* final outputs after the status and the time; outputs of one unit share a panel */
static void plan_outputs(picture *p)
{
    const lab_table *t = p->table;
    int first = lab__table_column(t, "status") + 2;
    for (int i = first; i < t->ncolumn && p->npanel < (p->naxis == 2 ? 1 : MAX_PANELS); i++) {
        char title[LABEL], unit[MECH_UNIT], other[LABEL], label[LABEL], u[MECH_UNIT];
        int seen = 0;
        cut_title(title_of(t, i, title), unit);
        for (int k = first; k < i; k++) {
            cut_title(title_of(t, k, other), u);
            seen = seen || strcmp(u, unit) == 0;
        }
        if (seen) {
            continue;
        }
        int milli = strcmp(unit, "m") == 0 && largest(t, i) < 1.0;
        panel *n = add_panel(p, "", milli ? 1e3 : 1.0);
        for (int k = i; k < (p->naxis == 2 ? i + 1 : t->ncolumn); k++) {
            cut_title(title_of(t, k, other), u);
            if (strcmp(u, unit) == 0) {
                add_curve(n, k);
            }
        }
        snprintf(label, sizeof label, "%.90s%s[%s]", n->ncurve == 1 ? title : "final", " ",
                 milli ? "mm" : unit);
        memcpy(n->label, label, sizeof label);
    }
}

/* ---- points ---- */

static int sort_axis(picture *p, int k, int axis)
{
    const lab_grid *g = p->table->grid;
    const lab__axis *a = &g->axis[axis];
    p->axis[k] = a;
    p->step[k] = 1;
    for (int i = axis + 1; i < g->naxis; i++) {
        p->step[k] *= g->axis[i].n;
    }
    int *order = malloc(sizeof *order * (size_t)a->n);
    p->order[k] = order;
    if (order == NULL) {
        return -1;
    }
    // insertion: a grid is sorted already, a list is short
    for (int i = 0; i < a->n; i++) {
        int at = i;
        while (at > 0 && a->value[order[at - 1]] > a->value[i]) {
            order[at] = order[at - 1];
            at--;
        }
        order[at] = i;
    }
    return 0;
}

static stein_status choose_axes(picture *p, const char *path, stein_err *err)
{
    const lab_grid *g = p->table->grid;
    int varied = 0;
    for (int i = 0; i < g->naxis; i++) {
        varied += g->axis[i].n > 1;
    }
    if (varied > 2 || g->naxis == 0) {
        return lab__fail(err, STEIN_EINVAL, "%s: %d parameters vary, a picture shows one or two",
                         path, varied);
    }
    for (int i = 0; i < g->naxis; i++) {
        int wanted = g->axis[i].n > 1 || (varied == 0 && i == 0);
        if (wanted && sort_axis(p, p->naxis++, i) != 0) {
            return lab__no_memory(err);
        }
    }
    return STEIN_OK;
}

/* value number i of an axis by size, in the unit shown; off the ends as far as the end cell goes */
static double at(const picture *p, int k, int i)
{
    const lab__axis *a = p->axis[k];
    int n = a->n;
    if (n == 1) {
        return a->value[0] / a->factor + (i < 0 ? -1.0 : i > 0 ? 1.0 : 0.0);
    }
    if (i < 0 || i >= n) {
        int end = i < 0 ? 0 : n - 1, next = i < 0 ? 1 : n - 2;
        return 2.0 * at(p, k, end) - at(p, k, next);
    }
    return a->value[p->order[k][i]] / a->factor;
}

/* ---- the script ---- */

static void write_label(FILE *f, const char *axis, const lab__axis *a)
{
    char text[LABEL];
    snprintf(text, sizeof text, "%s [%s]", a->name, a->shown);
    fprintf(f, "set %slabel ", axis);
    lab__quoted(f, text);
    fprintf(f, "\n");
}

static void write_title(FILE *f, const picture *p)
{
    const char *model = strstr(p->table->head, "# model: ");
    char text[4 * LABEL];
    int n = model != NULL ? (int)strcspn(model + 9, "\n") : 0;
    n = n < LABEL ? n : LABEL; // of a journal from another source, of any length
    int used = snprintf(text, sizeof text, "%.*s", n, model != NULL ? model + 9 : "");
    if (p->naxis == 2) {
        used += snprintf(text + used, sizeof text - (size_t)used, ": %.*sover %s and %s",
                         (int)strcspn(p->panel[0].label, "["), p->panel[0].label, p->axis[0]->name,
                         p->axis[1]->name);
    } else {
        used += snprintf(text + used, sizeof text - (size_t)used, " over %s", p->axis[0]->name);
    }
    snprintf(text + used, sizeof text - (size_t)used, ", %d points", p->table->n);
    fprintf(f, "set label 99 ");
    lab__quoted(f, text);
    fprintf(f, " at screen 0.5, 0.97 center\n");
}

/* a gap in the data is a gap in the curve */
static void write_curve(FILE *f, const picture *p, const panel *n, int column)
{
    fprintf(f, "$c%d << END\n", column);
    for (int i = 0; i < p->axis[0]->n; i++) {
        double v = lab__table_number(p->table, p->order[0][i] * p->step[0], column);
        if (isfinite(v)) {
            fprintf(f, "%.9g %.9g\n", at(p, 0, i), n->scale * v);
        } else {
            fprintf(f, "\n");
        }
    }
    fprintf(f, "END\n");
}

static int has_data(const picture *p, int column)
{
    int n = 0;
    for (int i = 0; i < p->axis[0]->n; i++) {
        n += isfinite(lab__table_number(p->table, i * p->step[0], column)) != 0;
    }
    return n > 0;
}

/* gnuplot does not draw a panel without a single point: a line out of sight stands in for it */
static void write_plot(FILE *f, const picture *p, const panel *n)
{
    static const char *const colour[MAX_CURVES] = {"#1f4e79", "#b5482f", "#5d7f33",
                                                   "#7b5aa0", "#b58a1b", "#3f8f8f"};
    int drawn = 0;
    for (int k = 0; k < n->ncurve; k++) {
        char title[LABEL], unit[MECH_UNIT];
        if (!has_data(p, n->column[k])) {
            continue;
        }
        cut_title(title_of(p->table, n->column[k], title), unit);
        for (char *c = title; *c != '\0'; c++) {
            if (*c == '_') {
                *c = ' ';
            }
        }
        fprintf(f, "%s$c%d using 1:2 with linespoints pt 7 ps %s lw 1.6 lc '%s' title ",
                drawn++ > 0 ? ", \\\n     " : "plot ", n->column[k],
                p->axis[0]->n > 60 ? "0.2" : "0.45", colour[k]);
        lab__quoted(f, title);
    }
    fprintf(f, drawn > 0
                   ? "\n"
                   : "set yrange [0:1]\nunset ytics\nset label 98 'no event' at graph "
                     "0.5, 0.5 center tc '#505050'\nplot 2 notitle\nset yrange [*:*] noextend\n"
                     "set ytics out nomirror scale 0.6 tc '#202020'\nunset label 98\n");
}

static void write_panel(FILE *f, const picture *p, int i)
{
    const panel *n = &p->panel[i];
    int bottom = i == p->npanel - 1;
    for (int k = 0; k < n->ncurve; k++) {
        write_curve(f, p, n, n->column[k]);
    }
    if (bottom) {
        fprintf(f, "set format x '%%g'\n");
        write_label(f, "x", p->axis[0]);
    } else {
        fprintf(f, "set format x ''\nunset xlabel\n");
    }
    fprintf(f, "set ylabel ");
    lab__quoted(f, n->label);
    fprintf(f, " offset 0.5,0\n");
    fprintf(f, n->ncurve > 1
                   ? "set key at graph 1, graph 1.01 right bottom horizontal samplen 1.6\n"
                   : "unset key\n");
    write_plot(f, p, n);
}

static void write_curves(FILE *f, const void *ctx)
{
    const picture *p = ctx;
    double top = 0.925, low = p->npanel > 3 ? 0.09 : 0.1, height = (top - low) / p->npanel;
    fprintf(f, "set border 3 lc '#404040'\nset tics out nomirror scale 0.6 tc '#202020'\n"
               "set grid lc '#e4e4e4' lw 0.8 lt 1\nset multiplot\n"
               "set lmargin at screen 0.1\nset rmargin at screen 0.97\n"
               "set offsets 0, 0, graph 0.06, graph 0.06\nset yrange [*:*] noextend\n");
    double from = at(p, 0, 0), to = at(p, 0, p->axis[0]->n - 1);
    double spare = p->axis[0]->n > 1 ? 0.02 * (to - from) : 1.0;
    fprintf(f, "set xrange [%.9g:%.9g]\n", from - spare, to + spare);
    write_title(f, p);
    for (int i = 0; i < p->npanel; i++) {
        fprintf(f, "set tmargin at screen %.4f\nset bmargin at screen %.4f\n", top - i * height,
                top - (i + 1) * height + 0.035);
        write_panel(f, p, i);
        fprintf(f, "unset label 99\n");
    }
    fprintf(f, "unset multiplot\n");
}

/* from where to where value i of an axis reaches, and a little more: no seam between two cells */
static void write_reach(FILE *f, const picture *p, int k, int i)
{
    double seam = 1e-3 * (at(p, k, p->axis[k]->n) - at(p, k, -1));
    fprintf(f, " %.9g %.9g", 0.5 * (at(p, k, i - 1) + at(p, k, i)) - seam,
            0.5 * (at(p, k, i) + at(p, k, i + 1)) + seam);
}

/* x y low high low high value: a box for every point that has (or, with `none`, has no) value */
static int write_cells(FILE *f, const picture *p, const char *name, int none)
{
    const panel *n = &p->panel[0];
    int cells = 0;
    fprintf(f, "$%s << END\n", name);
    for (int i = 0; i < p->axis[0]->n; i++) {
        for (int k = 0; k < p->axis[1]->n; k++) {
            int point = p->order[0][i] * p->step[0] + p->order[1][k] * p->step[1];
            double v = lab__table_number(p->table, point, n->column[0]);
            if ((!isfinite(v)) != none) {
                continue;
            }
            fprintf(f, "%.9g %.9g", at(p, 0, i), at(p, 1, k));
            write_reach(f, p, 0, i);
            write_reach(f, p, 1, k);
            fprintf(f, " %.9g\n", none ? 0.0 : n->scale * v);
            cells++;
        }
    }
    fprintf(f, "END\n");
    return cells;
}

static void write_map(FILE *f, const void *ctx)
{
    const picture *p = ctx;
    int with = write_cells(f, p, "cells", 0), without = write_cells(f, p, "none", 1);
    const char *ranges[] = {"x", "y"};
    for (int k = 0; k < 2; k++) {
        int n = p->axis[k]->n;
        fprintf(f, "set %srange [%.9g:%.9g]\n", ranges[k], 0.5 * (at(p, k, -1) + at(p, k, 0)),
                0.5 * (at(p, k, n - 1) + at(p, k, n)));
        write_label(f, ranges[k], p->axis[k]);
    }
    fprintf(f, "set border 15 lc '#404040'\nset tics out nomirror scale 0.6 tc '#202020'\n"
               "set palette defined (0 '#0b2545', 1 '#1f5f8b', 2 '#3f9f8f', 3 '#b7c95a', "
               "4 '#fbe58a')\nset lmargin at screen 0.1\nset rmargin at screen 0.84\n"
               "set tmargin at screen 0.9\nset bmargin at screen 0.12\nset cblabel ");
    lab__quoted(f, p->panel[0].label);
    fprintf(f, " offset 1.5,0\nset key at graph 1, graph 1.015 right bottom samplen 1.6\n"
               "set colorbox user origin 0.87,0.12 size 0.025,0.78\n");
    write_title(f, p);
    fprintf(f, "plot ");
    if (with > 0) {
        fprintf(f,
                "$cells using 1:2:3:4:5:6:7 with boxxyerror fs solid 1.0 noborder fc palette "
                "notitle%s",
                without > 0 ? ", \\\n     " : "\n");
    }
    if (without > 0) {
        fprintf(f,
                "$none using 1:2:3:4:5:6 with boxxyerror fs solid 1.0 noborder fc '#c8c8c8' "
                "title '%s'\n",
                p->is_stroke ? "no escapement" : "no value");
    }
}

stein_status lab_table_plot(const char *path, const lab_table *table, stein_err *err)
{
    picture p = {.table = table};
    stein_status status = choose_axes(&p, path, err);
    if (status == STEIN_OK) {
        p.is_stroke = lab__table_column(table, "escapement_height") >= 0;
        if (p.is_stroke) {
            plan_stroke(&p);
        } else {
            plan_outputs(&p);
        }
        if (p.npanel == 0) {
            status = lab__fail(err, STEIN_EINVAL, "%s: there is no output to draw", path);
        } else if (p.naxis == 2) {
            status = lab__gnuplot(path, 900, 700, write_map, &p, err);
        } else {
            status = lab__gnuplot(path, 900, 800, write_curves, &p, err);
        }
    }
    free(p.order[0]);
    free(p.order[1]);
    return status;
}
