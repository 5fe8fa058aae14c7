/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion_show.c - the motion-driven check in report.html and diagnosis.json.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosis_page.h"
#include "motion.h"

enum { WIDTH = 360 };

/* ---- diagnosis.json ---- */

static void write_part(lab__json *j, const char *key, const lab_motion_part *p)
{
    lab__json_open(j, key, '{');
    lab__json_text(j, "says", lab_motion_text(p->says));
    lab__json_real(j, "before", p->before);
    lab__json_real(j, "after", p->after);
    lab__json_real(j, "z_before", p->z_before);
    lab__json_real(j, "z_after", p->z_after);
    lab__json_real(j, "share", p->share);
    lab__json_real(j, "share_sd", p->share_sd);
    lab__json_close(j);
}

static void write_row(lab__json *j, const lab_motion_row *r)
{
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "channel", r->channel);
    lab__json_text(j, "unit", r->unit);
    lab__json_text(j, "phase", r->phase);
    lab__json_int(j, "samples", r->samples);
    lab__json_real(j, "present", r->present);
    lab__json_real(j, "before", r->before);
    lab__json_real(j, "after", r->after);
    lab__json_real(j, "noise", r->noise);
    lab__json_real(j, "mean_before", r->mean_before);
    lab__json_real(j, "mean_after", r->mean_after);
    lab__json_real(j, "mean_sd", r->mean_sd);
    lab__json_close(j);
}

void diag__motion_json(lab__json *j, const lab_motion *m)
{
    lab__json_open(j, "motion_check", '{');
    lab__json_text(j, "says", lab_motion_text(m->says));
    lab__json_text(j, "why", m->why);
    if (m->says != LAB_MOTION_NOT_DONE) {
        lab__json_text(j, "input", m->input);
        lab__json_text(j, "joint", m->joint);
        lab__json_text(j, "channel", m->channel);
        lab__json_text(j, "force", m->force);
        lab__json_text(j, "unit", m->unit);
        lab__json_int(j, "strokes", m->strokes);
        lab__json_bool(j, "held_out", m->held_out);
        lab__json_int(j, "draws", m->draws);
        write_part(j, "of_force", &m->of_force);
        write_part(j, "of_channels", &m->of_channels);
        write_part(j, "all", &m->all);
        lab__json_open(j, "errors", '[');
        for (int i = 0; i < m->nrow; i++) {
            write_row(j, &m->row[i]);
        }
        lab__json_close(j);
        lab__json_open(j, "stroke", '{');
        lab__json_text(j, "file", m->file);
        lab__json_reals(j, "time", m->t, m->n);
        lab__json_reals(j, "present", m->present, m->n);
        lab__json_reals(j, "before", m->before, m->n);
        lab__json_reals(j, "after", m->after, m->n);
        lab__json_reals(j, "sd", m->sd, m->n);
        lab__json_close(j);
    }
    lab__json_close(j);
}

/* ---- the page ---- */

static int is_extended(const lab_motion *m)
{
    return m->nrow > 0 && isfinite(m->row[0].after);
}

static page__plot plot_at(FILE *f, const lab_motion *m, double top, double height, double sx)
{
    page__plot p = {.f = f,
                    .left = 56.0,
                    .top = top,
                    .width = WIDTH - 72.0,
                    .height = height,
                    .caption = 13.0,
                    .x0 = sx * m->t[0],
                    .x1 = sx * m->t[m->n - 1]};
    page__range(&p.x0, &p.x1, 0.0);
    return p;
}

/* the force that was there and the ones that are needed */
static void draw_forces(FILE *f, const lab_motion *m, double sx)
{
    double lo = 0.0, hi = 0.0;
    char label[2 * LAB_PLACE];
    page__plot p = plot_at(f, m, 26.0, 150.0, sx);
    diag__motion_include(m->present, m->n, &lo, &hi);
    diag__motion_include(m->before, m->n, &lo, &hi);
    diag__motion_include(m->after, m->n, &lo, &hi);
    page__unit u = page__unit_for(m->unit, fmax(fabs(lo), fabs(hi)));
    p.y0 = u.factor * lo;
    p.y1 = u.factor * hi;
    page__range(&p.y0, &p.y1, 0.05);
    snprintf(label, sizeof label, "%s [%s]", m->joint, u.name);
    page__axes(&p, NULL, label);
    page__curve(&p, "measured", m->t, m->present, m->n, sx, u.factor);
    page__curve(&p, "before", m->t, m->before, m->n, sx, u.factor);
    if (is_extended(m)) {
        page__curve(&p, "after", m->t, m->after, m->n, sx, u.factor);
    }
}

/* needed less acted, over the band of noise; room [4n] */
static void draw_errors(FILE *f, const lab_motion *m, double sx, const char *time, double *room)
{
    int n = m->n;
    double *before = room, *after = room + n, *low = room + 2 * n, *high = room + 3 * n;
    double lo = 0.0, hi = 0.0;
    char label[2 * LAB_PLACE];
    page__plot p = plot_at(f, m, 206.0, 110.0, sx);
    for (int i = 0; i < n; i++) {
        before[i] = m->before[i] - m->present[i];
        after[i] = m->after[i] - m->present[i];
        low[i] = -2.0 * m->sd[i];
        high[i] = 2.0 * m->sd[i];
    }
    for (int k = 0; k < 4; k++) {
        diag__motion_include(room + k * n, n, &lo, &hi);
    }
    page__unit u = page__unit_for(m->unit, fmax(fabs(lo), fabs(hi)));
    p.y0 = u.factor * lo;
    p.y1 = u.factor * hi;
    page__range(&p.y0, &p.y1, 0.05);
    snprintf(label, sizeof label, "needed \xe2\x88\x92 acted [%s]", u.name);
    page__band(&p, "noise", m->t, low, high, n, sx, u.factor);
    page__axes(&p, time, label);
    fprintf(f, "<path class=\"zero\" d=\"M%.1f %.1fh%.1f\"/>\n", p.left, page__y(&p, 0.0), p.width);
    page__curve(&p, "before", m->t, before, n, sx, u.factor);
    if (is_extended(m)) {
        page__curve(&p, "after", m->t, after, n, sx, u.factor);
    }
}

static void draw(FILE *f, const lab_motion *m)
{
    double *room = m->n > 1 ? malloc(sizeof *room * 4 * (size_t)m->n) : NULL;
    if (room == NULL) {
        return;
    }
    int quick = m->t[m->n - 1] - m->t[0] < 2.0;
    double sx = quick ? 1e3 : 1.0;
    const char *name = strrchr(m->file, '/'), *time = quick ? "time [ms]" : "time [s]";
    fputs("<p class=\"legend\"><span class=\"key dot\"></span>force that acted<span class=\"key "
          "rust\"></span>needed by the model of the file",
          f);
    fputs(is_extended(m) ? "<span class=\"key blue\"></span>by the extended model" : "", f);
    fputs("<span class=\"key area\"></span>twice the noise</p>\n<div class=\"plots\"><figure>", f);
    page__svg_open(f, WIDTH, 362, "the force that the measured motion needs, and the one there");
    draw_forces(f, m, sx);
    draw_errors(f, m, sx, time, room);
    page__svg_close(f);
    fputs("<figcaption>", f);
    page__text(f, name != NULL ? name + 1 : m->file);
    fputs(m->held_out ? ", held out" : "", f);
    fputs("</figcaption></figure></div>\n", f);
    free(room);
}

static int has_share(const lab_motion_part *p)
{
    return isfinite(p->share) && isfinite(p->share_sd);
}

static void share(FILE *f, const char *of, const lab_motion_part *p)
{
    fprintf(f, "%s: %s%.2f \xc2\xb1 %.2f", of, p->share < 0.0 ? "\xe2\x88\x92" : "", fabs(p->share),
            p->share_sd);
}

static void words(FILE *f, const lab_motion *m)
{
    static const char *const says[] = {"", "supports the verdict", "contradicts the verdict",
                                       "cannot tell"};
    fputs("<p>A mechanism filters forces: what is wrong in a force may be small in a position. So "
          "the measured motion of ",
          f);
    page__words(f, m->joint);
    fputs(" (", f);
    page__words(f, m->channel != NULL ? m->channel : m->input);
    fprintf(
        f,
        ", smoothed) is prescribed here, in %d record%s%s. The rest is simulated, and the force "
        "that the motion needs is compared with the force that acted. The check <em>%s</em>: ",
        m->strokes, m->strokes == 1 ? "" : "s", m->held_out ? " held out" : "", says[m->says]);
    page__text(f, m->why);
    fputs(".", f);
    int force = has_share(&m->of_force), channels = has_share(&m->of_channels);
    if (force || channels) {
        fputs(" Share of what the extension changes that the records show (0: none, 1: all) ", f);
    }
    if (force) {
        share(f, "in the force", &m->of_force);
    }
    if (channels) {
        share(f, force ? ", in the free channels" : "in the free channels", &m->of_channels);
    }
    fputs(force || channels ? "." : "", f);
    fputs("</p>\n", f);
}

static void cell(FILE *f, double value, const char *unit, int digits)
{
    fputs("<td>", f);
    if (isfinite(value)) {
        page__quantity(f, value, unit, digits);
    } else {
        fputs("\xe2\x80\x93", f);
    }
    fputs("</td>", f);
}

static void row(FILE *f, const lab_motion_row *r)
{
    fputs("<tr><th scope=\"row\">", f);
    page__words(f, r->channel != NULL ? r->channel : "force");
    fputs("</th><td>", f);
    page__text(f, r->phase != NULL ? r->phase : "all");
    fputs("</td>", f);
    cell(f, r->present, r->unit, 3);
    cell(f, r->before, r->unit, 3);
    cell(f, r->after, r->unit, 3);
    cell(f, r->noise, r->unit, 3);
    cell(f, r->mean_before, r->unit, 2);
    cell(f, r->mean_after, r->unit, 2);
    cell(f, r->mean_sd, r->unit, 2);
    fputs("</tr>\n", f);
}

static const char head[] =
    "<div class=\"scroll\" tabindex=\"0\"><table class=\"fold check\"><tr><th></th><th>phase</th>"
    "<th>acted</th><th>error before</th><th>error after</th><th>from noise</th><th>mean before</th>"
    "<th>mean after</th><th>\xc2\xb1</th></tr>\n";

void page__motion(FILE *f, const lab_diagnosis *d)
{
    const lab_motion *m = &d->motion;
    if (m->why[0] == '\0') {
        return;
    }
    fputs("<section id=\"motion\"><h2>The force that the measured motion needs</h2>\n", f);
    if (m->says == LAB_MOTION_NOT_DONE) {
        fputs("<p>Not checked: ", f);
        page__text(f, m->why);
        fputs(".</p>\n</section>\n", f);
        return;
    }
    words(f, m);
    draw(f, m);
    fputs(head, f);
    for (int i = 0; i < m->nrow; i++) {
        if (m->row[i].phase == NULL) {
            row(f, &m->row[i]);
        }
    }
    fprintf(f, "</table></div>\n<details><summary>by phase</summary>\n%s", head);
    for (int i = 0; i < m->nrow; i++) {
        if (m->row[i].phase != NULL) {
            row(f, &m->row[i]);
        }
    }
    fputs(
        "</table></div></details>\n<p class=\"quiet\">Force and errors are RMS values. Errors are "
        "of "
        "means over a few milliseconds, without the bias of smoothing. Means have their sign. The "
        "errors that noise makes, and \xc2\xb1 of a mean, come from records that the models "
        "generate with the noise of these.</p>\n</section>\n",
        f);
}
