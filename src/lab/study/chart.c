/* SPDX-License-Identifier: GPL-3.0-or-later
 * chart.c - a picture of tables, by gnuplot: panels in columns, curves, bars, the paper's lines.
 *
 * Every table is written once as a data block; an absent number becomes NaN, which breaks a line.
 * The legend is one line above the panels, drawn by hand: gnuplot keeps its own within one panel.
 */
#include <math.h>
#include <string.h>

#include "study.h"

static const char *const colour[] = {"#1f4e79", "#b5482f", "#5d7f33", "#7b5aa0",
                                     "#b58a1b", "#3f8f8f", "#8a8a8a", "#303030"};

static void write_number(FILE *f, double v)
{
    char text[LAB_NUMBER];
    fputs(isfinite(v) ? lab__number(text, v) : "NaN", f);
}

/* data block of curve k of panel i: x, y, row */
static void write_data(FILE *f, const study_chart *c, int i, int k)
{
    const study_curve *v = &c->panel[i].curve[k];
    fprintf(f, "$p%dc%d << END\n", i, k);
    for (int row = 0; row < v->table->nrow; row++) {
        const double *cell = study_row(v->table, row);
        write_number(f, v->sx * cell[v->x]);
        putc(' ', f);
        write_number(f, v->style == STUDY_BARS ? row + 1.0 : v->sy * cell[v->y]);
        putc('\n', f);
    }
    fprintf(f, "END\n");
}

static void write_range(FILE *f, char axis, double from, double to)
{
    fprintf(f, "set %crange [", axis);
    if (isfinite(from)) {
        write_number(f, from);
    } else {
        putc('*', f);
    }
    putc(':', f);
    if (isfinite(to)) {
        write_number(f, to);
    } else {
        putc('*', f);
    }
    fprintf(f, "]\n");
}

static void write_label(FILE *f, const char *what, const char *text)
{
    fprintf(f, "set %s ", what);
    lab__quoted(f, text);
    putc('\n', f);
}

/* a text as a tic's label: gnuplot takes it for a format */
static void write_tic(FILE *f, const char *text)
{
    char label[160];
    size_t n = 0;
    for (; *text != '\0' && n + 2 < sizeof label; text++) {
        label[n++] = *text;
        if (*text == '%') {
            label[n++] = '%';
        }
    }
    label[n] = '\0';
    lab__quoted(f, label);
}

static void write_bar_axis(FILE *f, const study_panel *p, int first)
{
    const study_table *t = p->curve[0].table;
    fprintf(f, "set yrange [%d.6:0.4]\nset style fill solid 0.85 noborder\nset ytics scale 0 (",
            t->nrow);
    for (int row = 0; row < t->nrow; row++) {
        fprintf(f, "%s", row > 0 ? ", " : "");
        write_tic(f, first && t->label != NULL && t->label[row] != NULL ? t->label[row] : "");
        fprintf(f, " %d", row + 1);
    }
    fprintf(f,
            ")\nset xzeroaxis\nset arrow 90 from 0, graph 0 to 0, graph 1 nohead lw 1 lc '#404040' "
            "back\n");
}

static void write_axes(FILE *f, const study_panel *p, int first)
{
    fprintf(f, "unset xzeroaxis\nunset object\nunset arrow\nunset label\nunset logscale\nset ytics "
               "autofreq scale 0.6\n");
    fprintf(f, p->logx ? "set logscale x\nset xtics auto\n" : "set xtics autofreq\n");
    if (p->logy) {
        fprintf(f, "set logscale y\n");
    }
    write_label(f, "xlabel", p->xlabel);
    write_label(f, "ylabel", p->ylabel);
    write_range(f, 'x', p->x0, p->x1);
    write_range(f, 'y', p->y0, p->y1);
    if (!p->logx && !p->logy && p->ncurve > 0 && p->curve[0].style != STUDY_BARS) {
        fprintf(f, "set offsets %s, %s, graph 0.05, %s\n", isfinite(p->x0) ? "0" : "graph 0.03",
                isfinite(p->x1) ? "0" : "graph 0.03", isfinite(p->y0) ? "0" : "graph 0.05");
    } else {
        fprintf(f, "unset offsets\n");
    }
    if (isfinite(p->band[0]) && isfinite(p->band[1])) {
        fprintf(f,
                "set object 1 rect from %.9g, graph 0 to %.9g, graph 1 back fs solid 1.0 noborder "
                "fc '#f1f3ea'\n",
                p->band[0], p->band[1]);
    }
    if (p->ncurve > 0 && p->curve[0].style == STUDY_BARS) {
        write_bar_axis(f, p, first);
    }
    fprintf(f, "unset key\n");
}

static void write_curve(FILE *f, const study_curve *v, int i, int k)
{
    static const char *const with[] = {"with lines lw 1.8",
                                       "with points pt 7 ps 0.55",
                                       "with linespoints lw 1.6 pt 7 ps 0.5",
                                       "with lines lw 1.6 dt 2",
                                       "",
                                       "with histeps lw 1.6"};
    fprintf(f, "$p%dc%d ", i, k);
    if (v->style == STUDY_BARS) {
        fprintf(f, "using 1:2:($1<0?$1:0):($1>0?$1:0):($2-0.36):($2+0.36) with boxxyerror");
    } else {
        fprintf(f, "using 1:2 %s", with[v->style]);
    }
    fprintf(f, " lc '%s' notitle", colour[v->colour % 8]);
}

/* columns a UTF-8 text takes */
static int length(const char *text)
{
    int n = 0;
    for (; *text != '\0'; text++) {
        n += ((unsigned char)*text & 0xc0) != 0x80;
    }
    return n;
}

enum { LETTER = 7, SAMPLE = 26, SPACE = 26 }; /* pixels of the legend */

/* one sample with its name; returns where the next one goes [pixels] */
static double write_entry(FILE *f, const study_chart *c, double x, int number, const char *title,
                          const char *look, int is_point)
{
    double y = 1.0 - 15.0 / c->height;
    if (is_point) {
        fprintf(f, "set label %d '' at screen %.5f, screen %.5f point pt 7 ps 0.6 %s\n",
                100 + number, (x + 0.5 * SAMPLE) / c->width, y, look);
    } else {
        fprintf(f,
                "set arrow %d from screen %.5f, screen %.5f rto screen %.5f, screen 0 nohead %s\n",
                100 + number, x / c->width, y, (double)SAMPLE / c->width, look);
    }
    fprintf(f, "set label %d ", 120 + number);
    lab__quoted(f, title);
    fprintf(f, " at screen %.5f, screen %.5f left tc '#303030'\n", (x + SAMPLE + 6) / c->width, y);
    return x + SAMPLE + 6 + LETTER * length(title) + SPACE;
}

static void write_legend(FILE *f, const study_chart *c, const study_panel *p)
{
    double x = 0.0, total = -SPACE;
    char look[80];
    for (int k = 0; k < p->nline; k++) {
        total +=
            p->line[k].title != NULL ? SAMPLE + 6 + LETTER * length(p->line[k].title) + SPACE : 0;
    }
    for (int k = 0; k < p->ncurve; k++) {
        const char *title = p->curve[k].title;
        total += title != NULL ? SAMPLE + 6 + LETTER * length(title) + SPACE : 0;
    }
    x = 0.5 * (c->width - total);
    for (int k = 0; k < p->nline; k++) {
        if (p->line[k].title != NULL) {
            snprintf(look, sizeof look, "lw 1.4 dt %d lc '%s'", k % 2 ? 3 : 2,
                     k % 2 ? "#7b7b7b" : "#7a7a7a");
            x = write_entry(f, c, x, k, p->line[k].title, look, 0);
        }
    }
    for (int k = 0; k < p->ncurve; k++) {
        const study_curve *v = &p->curve[k];
        int point = v->style == STUDY_POINTS;
        if (v->title != NULL) {
            snprintf(look, sizeof look, point ? "lc '%s'" : "lw 1.8 %s lc '%s'",
                     point                      ? colour[v->colour % 8]
                     : v->style == STUDY_DASHED ? "dt 2"
                                                : "",
                     colour[v->colour % 8]);
            x = write_entry(f, c, x, STUDY_LINES + k, v->title, look, point);
        }
    }
}

/* is the chart empty? gnuplot refuses a panel without a single point */
static int has_points(const study_curve *v)
{
    for (int row = 0; row < v->table->nrow; row++) {
        const double *cell = study_row(v->table, row);
        if (isfinite(cell[v->x]) && (v->style == STUDY_BARS || isfinite(cell[v->y]))) {
            return 1;
        }
    }
    return 0;
}

static void write_panel(FILE *f, const study_chart *c, int i)
{
    const study_panel *p = &c->panel[i];
    write_axes(f, p, i % c->columns == 0);
    if (p->legend) {
        write_legend(f, c, p);
    }
    for (int k = 0; k < p->nline; k++) {
        fprintf(f, "$l%d << END\n%.9g %.9g\n%.9g %.9g\nEND\n", k, p->line[k].x, p->line[k].y,
                p->line[k].x2, p->line[k].y2);
    }
    int points = 0;
    for (int k = 0; k < p->ncurve; k++) {
        points += has_points(&p->curve[k]);
    }
    if (points == 0) {
        fprintf(f, "unset logscale\nset label 1 'no data' at graph 0.5, graph 0.5 center\n"
                   "plot [0:1] [0:1] NaN notitle\n");
        return;
    }
    fprintf(f, "plot ");
    for (int k = 0; k < p->nline; k++) {
        fprintf(f, "$l%d using 1:2 with lines lw 1.4 dt %d lc '#7a7a7a' notitle, \\\n     ", k,
                k % 2 ? 3 : 2);
    }
    for (int k = 0; k < p->ncurve; k++) {
        fprintf(f, "%s", k > 0 ? ", \\\n     " : "");
        write_curve(f, &p->curve[k], i, k);
    }
    fprintf(f, "\n");
}

/* the legend's line above the panels */
static double legend_height(const study_chart *c)
{
    for (int i = 0; i < c->npanel; i++) {
        if (c->panel[i].legend) {
            return 26.0 / c->height;
        }
    }
    return 0.0;
}

static void write_script(FILE *f, const void *ctx)
{
    const study_chart *c = ctx;
    int rows = (c->npanel + c->columns - 1) / c->columns;
    double area = 1.0 - legend_height(c);
    for (int i = 0; i < c->npanel; i++) {
        for (int k = 0; k < c->panel[i].ncurve; k++) {
            write_data(f, c, i, k);
        }
    }
    fprintf(f, "set border 3 lc '#404040'\nset tics out nomirror scale 0.6 tc '#202020'\n"
               "set grid lc '#e4e4e4' lw 0.8 lt 1\nset datafile missing 'NaN'\nset multiplot\n");
    double normal = 82.0 / c->width, margin = c->left > 0.0 ? c->left : normal;
    double right = 18.0 / c->width, foot = 62.0 / c->height, head = 20.0 / c->height;
    double gap = c->left > 0.0 && c->columns > 2 ? 24.0 / c->width : normal; // names only once
    double width = (1.0 - margin - gap * (c->columns - 1) - right * c->columns) / c->columns;
    for (int i = 0; i < c->npanel; i++) {
        double x = margin + (width + gap + right) * (i % c->columns);
        int row = i / c->columns;
        double top = area * (1.0 - (double)row / rows);
        fprintf(f, "set lmargin at screen %.5f\nset rmargin at screen %.5f\n", x, x + width);
        fprintf(f, "set tmargin at screen %.5f\nset bmargin at screen %.5f\n", top - head,
                top - area / rows + foot);
        write_panel(f, c, i);
    }
    fprintf(f, "unset multiplot\n");
}

stein_status study_draw(const study_chart *chart, const char *path, stein_err *err)
{
    return lab__gnuplot(path, chart->width, chart->height, write_script, chart, err);
}
