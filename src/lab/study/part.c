/* SPDX-License-Identifier: GPL-3.0-or-later
 * part.c - elements of a part of the study: tables, pictures, sentences.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "study.h"

study_table *study_table_new(study_part *part, const char *name, int nrow, const char *const *head)
{
    if (part->ntable == STUDY_TABLES || nrow < 0) {
        return NULL;
    }
    study_table *t = &part->table[part->ntable];
    *t = (study_table){.nrow = nrow};
    snprintf(t->name, sizeof t->name, "%s", name);
    while (head[t->ncolumn] != NULL && t->ncolumn < STUDY_COLUMNS) {
        t->head[t->ncolumn] = head[t->ncolumn];
        t->ncolumn++;
    }
    size_t cells = (size_t)nrow * (size_t)t->ncolumn;
    t->cell = malloc(sizeof *t->cell * (cells + 1));
    if (t->cell == NULL) {
        return NULL;
    }
    for (size_t i = 0; i < cells; i++) {
        t->cell[i] = NAN;
    }
    part->ntable++;
    return t;
}

int study_table_copy(study_part *part, const char *name, const study_table *from, const int *column,
                     int n)
{
    const char *head[STUDY_COLUMNS + 1] = {NULL};
    for (int k = 0; k < n; k++) {
        head[k] = from->head[column[k]];
    }
    study_table *t = study_table_new(part, name, from->nrow, head);
    for (int i = 0; t != NULL && i < t->nrow; i++) {
        for (int k = 0; k < n; k++) {
            study_row(t, i)[k] = study_row(from, i)[column[k]];
        }
    }
    return t != NULL;
}

double *study_row(const study_table *t, int row)
{
    return t->cell + (size_t)row * (size_t)t->ncolumn;
}

int study_is_labelled(const study_table *t)
{
    int labelled = t->label != NULL;
    for (int i = 0; labelled && i < t->nrow; i++) {
        labelled = t->label[i] != NULL;
    }
    return labelled;
}

study_chart *study_chart_new(study_part *part, const char *name, int width, int height, int columns)
{
    study_chart *c = &part->chart[part->nchart < STUDY_CHARTS ? part->nchart++ : STUDY_CHARTS - 1];
    *c = (study_chart){.width = width, .height = height, .columns = columns};
    snprintf(c->name, sizeof c->name, "%s", name);
    return c;
}

study_panel *study_panel_new(study_chart *chart, const char *xlabel, const char *ylabel)
{
    study_panel *p =
        &chart->panel[chart->npanel < STUDY_PANELS ? chart->npanel++ : STUDY_PANELS - 1];
    *p = (study_panel){.xlabel = xlabel,
                       .ylabel = ylabel,
                       .x0 = NAN,
                       .x1 = NAN,
                       .y0 = NAN,
                       .y1 = NAN,
                       .band = {NAN, NAN}};
    return p;
}

void study_curve_add(study_panel *panel, const study_table *table, int x, double sx, int y,
                     double sy, study_style style, int colour, const char *title)
{
    if (panel->ncurve < STUDY_CURVES && table != NULL) {
        panel->curve[panel->ncurve++] = (study_curve){table, x, y, sx, sy, title, style, colour};
    }
}

void study_line_add(study_panel *panel, double x, double y, double x2, double y2, const char *title)
{
    if (panel->nline < STUDY_LINES && isfinite(x + y + x2 + y2)) {
        panel->line[panel->nline].x = x;
        panel->line[panel->nline].y = y;
        panel->line[panel->nline].x2 = x2;
        panel->line[panel->nline].y2 = y2;
        panel->line[panel->nline++].title = title;
    }
}

void study_say(study_part *part, const char *format, ...)
{
    char **of = part->nchart > 0 ? &part->chart[part->nchart - 1].text : &part->text;
    va_list list;
    va_start(list, format);
    int n = vsnprintf(NULL, 0, format, list);
    va_end(list);
    size_t have = *of == NULL ? 0 : strlen(*of);
    char *text = n < 0 ? NULL : realloc(*of, have + (size_t)n + 2);
    if (text == NULL) {
        part->lost = 1;
        return;
    }
    if (have > 0) {
        text[have++] = ' ';
    }
    va_start(list, format);
    vsnprintf(text + have, (size_t)n + 1, format, list);
    va_end(list);
    *of = text;
}

void study_part_free(study_part *part)
{
    for (int i = 0; i < part->ntable; i++) {
        for (int k = 0; part->table[i].label != NULL && k < part->table[i].nrow; k++) {
            free(part->table[i].label[k]);
        }
        free(part->table[i].label);
        free(part->table[i].cell);
    }
    for (int i = 0; i < part->nchart; i++) {
        free(part->chart[i].text);
    }
    free(part->text);
    *part = (study_part){.ntable = 0};
}

stein_status study_write_csv(const study *s, const study_table *t, const char *path, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    fprintf(file.stream, "# model: %s\n", lab_equations(s->model)->name);
    if (t->label != NULL) {
        fprintf(file.stream, "%s,", t->label_head);
    }
    for (int k = 0; k < t->ncolumn; k++) {
        fprintf(file.stream, "%s%c", t->head[k], k + 1 < t->ncolumn ? ',' : '\n');
    }
    for (int i = 0; i < t->nrow; i++) {
        if (t->label != NULL) {
            fprintf(file.stream, "%s,", t->label[i] != NULL ? t->label[i] : "");
        }
        for (int k = 0; k < t->ncolumn; k++) {
            char text[LAB_NUMBER];
            double v = study_row(t, i)[k];
            fprintf(file.stream, "%s%c", isfinite(v) ? lab__number(text, v) : "",
                    k + 1 < t->ncolumn ? ',' : '\n');
        }
    }
    return lab__file_close(&file, 1, err);
}
