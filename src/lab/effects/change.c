/* SPDX-License-Identifier: GPL-3.0-or-later
 * change.c - what a cause changes in the file: old and new number, in the unit of the file.
 *
 * An amount is a change, "-0.0479 kg m^2", of which a reader of the file cannot see whether the new
 * number is possible. The new number is what extended.yaml has: the refitted number, moved by the
 * amount.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "added_parts.h"

/* the refitted value of a parameter of the file, else its own */
static double refitted(const stein_model *m, int param, const double *p, const lab_fit_value *value,
                       int n)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(value[i].name, m->params[param].name) == 0) {
            return value[i].value;
        }
    }
    return p[param];
}

static double moved(const lab_candidate *c, double from, double amount)
{
    return c->move == LAB_MOVE_LOWER   ? from - amount
           : c->move == LAB_MOVE_SCALE ? from * exp(amount)
                                       : from + amount;
}

static void note_unit(lab_change *to, const mechanism *m, const char *name, const char *unit)
{
    mech_dim dim;
    to->factor = 1.0;
    snprintf(to->unit, sizeof to->unit, "%.23s", strcmp(unit, "1") == 0 ? "" : unit);
    for (int i = 0; i < m->nparam; i++) {
        const mech_param *q = &m->params[i];
        double factor = 1.0;
        if (strcmp(q->name, name) == 0 && q->written[0] != '\0' &&
            mech_parse_unit(q->written, &dim, &factor) == 0) {
            to->factor = factor;
            snprintf(to->unit, sizeof to->unit, "%s", q->written);
        }
    }
}

void lab__note_changes(lab_suspect *s, const lab_candidate *c, const lab_model *model,
                       const lab_fit_value *value, int nvalue)
{
    const stein_model *m = lab_equations(model);
    const double *p = lab_parameters(model);
    const char *cls = c->effect->cls;
    int of_file = strcmp(cls, "wrong_parameter") == 0 || strcmp(cls, "missing_effect") == 0;
    int n = c->move == LAB_MOVE_SPRING ? 1 : c->nparam;
    s->nchange = 0;
    if (c->effect->needs != NULL || c->move == LAB_MOVE_VALUE || !of_file || s->nnumber < 1) {
        return;
    }
    for (int i = 0; i < n; i++) {
        lab_change *to = &s->change[s->nchange];
        int param = c->param[i], one = s->candidate.until > 0;
        double from = one ? s->stated : p[param],
               base = one ? s->stated : refitted(m, param, p, value, nvalue);
        if (!isfinite(from) || from == 0.0) {
            continue; // a law that the file does not have
        }
        double a = moved(c, base, s->number[0].lo), b = moved(c, base, s->number[0].hi);
        snprintf(to->name, sizeof to->name, "%.99s", m->params[param].name);
        note_unit(to, lab__mechanism(model), m->params[param].name, m->params[param].unit);
        to->from = from;
        to->to = moved(c, base, s->number[0].value);
        to->lo = fmin(a, b);
        to->hi = fmax(a, b);
        s->nchange++;
    }
}

/* ---- in words ---- */

/* to as many decimals as the interval deserves */
static const char *rounded(char *text, size_t size, double value, double width)
{
    int decimals = 1 - (int)floor(log10(width));
    if (!(width > 0.0) || !isfinite(width) || decimals > 12) {
        snprintf(text, size, "%.4g", value);
    } else {
        snprintf(text, size, "%.*f", decimals < 0 ? 0 : decimals, value);
    }
    return text;
}

static const char *way_of(const char *kind, int up)
{
    static const char *const word[][3] = {
        {"mass", "lighter", "heavier"},
        {"contact_stiffness", "softer", "stiffer"},
        {"joint_stiffness", "softer", "stiffer"},
        {"centre", "nearer to the joint", "farther from the joint"},
        {"", "smaller", "larger"}};
    int i = 0;
    while (word[i][0][0] != '\0' && strcmp(word[i][0], kind) != 0) {
        i++;
    }
    return word[i][1 + up];
}

/* "13 times smaller", "4.6 % heavier", "19 mm nearer to the joint" */
static void direction(char *text, size_t size, const char *kind, const lab_change *c)
{
    double ratio = c->to / c->from;
    int up = ratio > 1.0;
    if (ratio <= 0.0) {
        snprintf(text, size, "of the other sign");
    } else if (strcmp(kind, "centre") == 0) {
        snprintf(text, size, "%.2g %s %s", fabs(c->to - c->from) / c->factor, c->unit,
                 way_of(kind, up));
    } else if (ratio > 2.0 || ratio < 0.5) {
        snprintf(text, size, "%.2g times %s", up ? ratio : 1.0 / ratio, way_of(kind, up));
    } else {
        snprintf(text, size, "%.2g %% %s", 100.0 * fabs(ratio - 1.0), way_of(kind, up));
    }
}

const char *lab_change_text(const lab_suspect *s, char text[LAB_CHANGE_TEXT])
{
    const lab_change *c = &s->change[0];
    const char *kind = s->candidate.effect != NULL ? s->candidate.effect->kind : "";
    size_t place = strlen(s->candidate.place);
    char number[4][40], way[80], interval[100] = "";
    text[0] = '\0';
    if (s->nchange < 1) {
        return text;
    }
    // of several numbers, which are scaled alike, only the factor
    double unit = s->nchange > 1 ? c->from : c->factor, width = (c->hi - c->lo) / fabs(unit);
    double lo = fmin(c->lo / unit, c->hi / unit), hi = fmax(c->lo / unit, c->hi / unit);
    if (isfinite(width)) {
        snprintf(interval, sizeof interval, " (95 %%: %s to %s)",
                 rounded(number[0], sizeof number[0], lo, width),
                 rounded(number[1], sizeof number[1], hi, width));
    }
    rounded(number[2], sizeof number[2], c->to / unit, width);
    if (s->nchange > 1) { // "2.05 times stiffer (95 %: 1.90 to 2.20)", "0.49 times, softer"
        int up = c->to / unit > 1.0;
        snprintf(text, LAB_CHANGE_TEXT, "%s times%s%s%s", number[2], up ? " " : ", ",
                 way_of(kind, up), interval);
        return text;
    }
    direction(way, sizeof way, kind, c);
    int own = strncmp(c->name, s->candidate.place, place) == 0 && c->name[place] == '.';
    snprintf(number[3], sizeof number[3], "%.6g", c->from / unit);
    snprintf(text, LAB_CHANGE_TEXT, "%.99s%s%s -> %s%s%s%s, %s", own ? c->name + place + 1 : "",
             own ? ": " : "", number[3], number[2], c->unit[0] != '\0' ? " " : "", c->unit,
             interval, way);
    return text;
}
