/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_text.c - texts and numbers as report.html shows them.
 */
#include <math.h>
#include <string.h>

#include "diagnosis_page.h"

void page__text(FILE *f, const char *text)
{
    for (; text != NULL && *text != '\0'; text++) {
        switch (*text) {
        case '&': fputs("&amp;", f); break;
        case '<': fputs("&lt;", f); break;
        case '>': fputs("&gt;", f); break;
        case '-': // "1.64 -> 0.971"
            fputs(text[1] == '>' ? "\xe2\x86\x92" : "-", f);
            text += text[1] == '>';
            break;
        case '"': fputs("&quot;", f); break;
        case '\'': fputs("&#39;", f); break;
        default: putc((unsigned char)*text < 0x20 ? ' ' : *text, f);
        }
    }
}

void page__words(FILE *f, const char *name)
{
    char part[2] = "";
    for (; name != NULL && *name != '\0'; name++) {
        part[0] = *name;
        if (*name == '_') {
            putc(' ', f);
        } else {
            page__text(f, part);
        }
    }
}

void page__cause(FILE *f, const lab_candidate *c)
{
    page__words(f, c->effect != NULL ? c->effect->kind : "nothing");
    if (c->place[0] != '\0') {
        fputs(" of ", f);
        if (strpbrk(c->place, "._") == NULL) {
            fputs("the ", f);
        }
        page__text(f, c->place);
    }
    char scope[LAB_PLACE];
    page__text(f, lab_candidate_scope(c, scope));
}

int page__change(FILE *f, const lab_suspect *s)
{
    char text[LAB_CHANGE_TEXT], *from = text;
    lab_change_text(s, text);
    for (char *power = strchr(from, '^'); power != NULL; power = strchr(from, '^')) {
        *power++ = '\0';
        size_t n = strspn(power, "-0123456789");
        page__text(f, from);
        fprintf(f, "<sup>%.*s</sup>", (int)n, power);
        from = power + n;
    }
    page__text(f, from);
    return s->nchange > 0;
}

/* ---- units ---- */

/* can a prefix stand before it? "N m s/rad", "rad/s", but no power, which it would be part of, no
 * kilogram, which has one, and no metre squared */
static int takes_prefix(const char *unit)
{
    size_t n = strspn(unit, "abcdefghijklmnopqrstuvwxyzNJWPV");
    return n > 0 && strncmp(unit, "kg", 2) != 0 && unit[n] != '^';
}

page__unit page__unit_for(const char *unit, double typical)
{
    page__unit u = {.factor = 1.0};
    double size = fabs(typical);
    unit = unit != NULL && strcmp(unit, "1") != 0 ? unit : "";
    snprintf(u.name, sizeof u.name, "%s", unit);
    if (size >= 1e3 && size < 1e9 && strchr("NJWP", *unit) != NULL && *unit != '\0') {
        int huge = size >= 1e6; // "26.8 kN/m"
        u.factor = huge ? 1e-6 : 1e-3;
        snprintf(u.name, sizeof u.name, "%s%s", huge ? "M" : "k", unit);
        return u;
    }
    if (!(size < 0.5) || !(size > 0.0)) {
        return u;
    }
    int tiny = size < 0.5e-3;
    if (strcmp(unit, "kg") == 0) {
        u.factor = tiny ? 1e6 : 1e3;
        snprintf(u.name, sizeof u.name, "%s", tiny ? "mg" : "g");
    } else if (takes_prefix(unit)) {
        u.factor = tiny ? 1e6 : 1e3;
        snprintf(u.name, sizeof u.name, "%s%s", tiny ? "\xc2\xb5" : "m", unit);
    }
    return u;
}

void page__unit_name(FILE *f, const char *name)
{
    char part[2] = "";
    for (; name != NULL && *name != '\0'; name++) {
        if (*name == '^') {
            size_t n = strspn(name + 1, "-0123456789");
            fprintf(f, "<sup>%.*s</sup>", (int)n, name + 1);
            name += n;
        } else if (*name == ' ') {
            fputs("&nbsp;", f);
        } else {
            part[0] = *name;
            page__text(f, part);
        }
    }
}

/* ---- numbers ---- */

static void decimal(FILE *f, double value, int decimals)
{
    char text[64];
    snprintf(text, sizeof text, "%.*f", decimals < 0 ? 0 : decimals > 12 ? 12 : decimals, value);
    int zero = strspn(text, "-0.") == strlen(text);
    const char *at = text[0] == '-' ? text + 1 : text;
    fprintf(f, "%s%s", text[0] == '-' && !zero ? "\xe2\x88\x92" : "", at);
}

static int exponent(double value)
{
    return value != 0.0 && isfinite(value) ? (int)floor(log10(fabs(value)) + 1e-12) : 0;
}

static void power(FILE *f, int e)
{
    if (e != 0) {
        fprintf(f,
                "\xc2\xb7"
                "10<sup>%s%d</sup>",
                e < 0 ? "\xe2\x88\x92" : "", e < 0 ? -e : e);
    }
}

void page__number(FILE *f, double value, int digits)
{
    if (!isfinite(value)) {
        fputs(isinf(value) ? (value > 0 ? "\xe2\x88\x9e" : "\xe2\x88\x92\xe2\x88\x9e")
                           : "\xe2\x80\x93",
              f);
        return;
    }
    int e = exponent(value), large = e > 4 || e < -3;
    decimal(f, large ? value * pow(10.0, -e) : value, large ? digits - 1 : digits - 1 - e);
    power(f, large ? e : 0);
}

void page__quantity(FILE *f, double value, const char *unit, int digits)
{
    page__unit u = page__unit_for(unit, value);
    page__number(f, value * u.factor, digits);
    if (u.name[0] != '\0') {
        fputs("&nbsp;", f);
        page__unit_name(f, u.name);
    }
}

void page__error(FILE *f, const lab_gain *g, double value)
{
    if (g->written[0] == '\0' || !isfinite(value)) {
        page__quantity(f, value, g->unit, 3);
        return;
    }
    page__number(f, value * g->per_unit, 3);
    fputs("&nbsp;", f);
    page__unit_name(f, g->written);
}

void page__interval(FILE *f, double value, double lo, double hi, const char *unit)
{
    double width = hi - lo;
    if (!isfinite(width) || !(width > 0.0) || !isfinite(value)) {
        page__quantity(f, value, unit, 3);
        return;
    }
    double size = fmax(fabs(value), fmax(fabs(lo), fabs(hi)));
    page__unit u = page__unit_for(unit, size);
    size *= u.factor;
    int e = exponent(size), large = e > 4 || e < -3;
    double scale = u.factor * (large ? pow(10.0, -e) : 1.0);
    int decimals = 1 - exponent(width * scale);
    decimal(f, value * scale, decimals);
    fputs(" <span class=\"ci\">[", f);
    decimal(f, lo * scale, decimals);
    fputs(" \xe2\x80\xa6 ", f);
    decimal(f, hi * scale, decimals);
    fputs("]</span>", f);
    power(f, large ? e : 0);
    if (u.name[0] != '\0') {
        fputs("&nbsp;", f);
        page__unit_name(f, u.name);
    }
}
