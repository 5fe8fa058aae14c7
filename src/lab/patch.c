/* SPDX-License-Identifier: GPL-3.0-or-later
 * patch.c - a mechanism file with new numbers in the old places.
 *
 * The reader knows line and column of every number. There, and nowhere else, the text changes:
 *
 *      mass: 2.561 g +- 0.5 %      # weighed     ->     mass: 2.553104 g +- 0.0031 g   # weighed
 *
 * The unit stays when it is one, the tolerance becomes the fitted standard deviation. Writing the
 * mechanism out from its tree would lose comments, order and units, which are what makes a file a
 * person's file. The result is read again: it must be valid and give the fitted values.
 */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { DIGITS = 10, CELL = 160 };

/* one number to be replaced: text[from..to) */
typedef struct change {
    size_t from, to;
    char text[CELL];
    const char *name;
    double value;
} change;

typedef struct patch {
    char *text;
    size_t size;
    change *list;
    int n;
} patch;

/* ---- files ---- */

static stein_status read_all(const char *path, char **text, size_t *size, stein_err *err)
{
    FILE *f = fopen(path, "rb");
    size_t n = 0, room = 1 << 16;
    char *t = malloc(room);
    if (f == NULL || t == NULL) {
        if (f != NULL) {
            fclose(f);
        }
        free(t);
        return lab__fail(err, f == NULL ? STEIN_EIO : STEIN_ENOMEM, "%s cannot be read", path);
    }
    for (size_t got; (got = fread(t + n, 1, room - n - 1, f)) > 0;) {
        n += got;
        if (n + 1 >= room) {
            char *more = realloc(t, room *= 2);
            if (more == NULL) {
                fclose(f);
                free(t);
                return lab__fail(err, STEIN_ENOMEM, "out of memory");
            }
            t = more;
        }
    }
    int bad = ferror(f);
    fclose(f);
    t[n] = '\0';
    *text = t;
    *size = n;
    return bad ? lab__fail(err, STEIN_EIO, "%s cannot be read", path) : STEIN_OK;
}

/* ---- places ---- */

/* byte of a place; columns count characters of UTF-8 */
static size_t find_byte(const patch *p, int line, int column)
{
    size_t at = 0;
    for (int l = 1; l < line && at < p->size; at++) {
        l += p->text[at] == '\n';
    }
    if (line == 1 && p->size >= 3 && memcmp(p->text, "\xEF\xBB\xBF", 3) == 0) {
        at = 3;
    }
    for (int c = 1; c < column && at < p->size && p->text[at] != '\n'; c++) {
        at++;
        while (at < p->size && ((unsigned char)p->text[at] & 0xC0) == 0x80) {
            at++;
        }
    }
    return at;
}

/* the scalar that begins at `from`: no number holds , ] } or #, quoted or not */
static void find_scalar(const patch *p, size_t *from, size_t *to)
{
    const char *t = p->text;
    if (t[*from] == '"' || t[*from] == '\'') {
        char quote = t[*from];
        *to = *from + 1;
        while (*to < p->size && t[*to] != quote && t[*to] != '\n') {
            ++*to;
        }
        *to += t[*to] == quote;
        return;
    }
    *to = *from + strcspn(t + *from, ",]}#\r\n");
    while (*to > *from && strchr(" \t", t[*to - 1]) != NULL) {
        --*to;
    }
}

/* the unit in "82 g +- 1 %"; "" when there is none or the text is no plain number */
static void find_unit(const char *scalar, size_t n, char unit[MECH_UNIT])
{
    char text[CELL];
    size_t start = 0;
    unit[0] = '\0';
    if (n >= sizeof text) {
        return;
    }
    memcpy(text, scalar, n);
    text[n] = '\0';
    start += strspn(text, "\"' +-");
    start += strspn(text + start, "0123456789.");
    if (strchr("eE", text[start]) != NULL && text[start] != '\0' &&
        strspn(text + start + 1, "+-0123456789") > 0) {
        start += 1 + strspn(text + start + 1, "+-0123456789");
    }
    char *end = strstr(text + start, "+-");
    char *sign = strstr(text + start, "\xC2\xB1");
    end = end == NULL || (sign != NULL && sign < end) ? sign : end;
    if (end != NULL) {
        *end = '\0';
    }
    start += strspn(text + start, " \t");
    size_t length = strcspn(text + start, "\"'");
    while (length > 0 && text[start + length - 1] == ' ') {
        length--;
    }
    if (length < MECH_UNIT) {
        memcpy(unit, text + start, length);
        unit[length] = '\0';
    }
}

/* ---- numbers ---- */

static void rounded(char *text, double value, int digits)
{
    char digit[LAB_NUMBER];
    snprintf(digit, sizeof digit, "%.*g", digits, value);
    lab__number(text, strtod(digit, NULL));
}

/* "2.553104 g +- 0.0031 g"; without sd: as it stands there */
static void write_quantity(char text[CELL], const mech_param *q, const char *old_unit, double value,
                           double sd)
{
    char number[LAB_NUMBER], tolerance[LAB_NUMBER], unit[MECH_UNIT];
    mech_dim dim;
    double factor = 1.0;
    snprintf(unit, sizeof unit, "%s", old_unit);
    if (unit[0] == '\0' || mech_parse_unit(unit, &dim, &factor) != 0 || dim.kg != q->dim.kg ||
        dim.m != q->dim.m || dim.s != q->dim.s) {
        factor = 1.0;
        snprintf(unit, sizeof unit, "%s", strcmp(q->unit, "1") == 0 ? "" : q->unit);
    }
    rounded(number, value / factor, DIGITS);
    rounded(tolerance, sd / factor, 3);
    const char *blank = unit[0] == '\0' ? "" : " ";
    if (sd > 0.0 && isfinite(sd)) {
        snprintf(text, CELL, "%s%s%s +- %s%s%s", number, blank, unit, tolerance, blank, unit);
    } else {
        snprintf(text, CELL, "%s%s%s", number, blank, unit);
    }
}

static stein_status add(patch *p, const mechanism *m, const char *name, double value, double sd,
                        stein_err *err)
{
    int k = mech_find_param(m, name, NULL);
    if (k < 0 || m->params[k].line <= 0) {
        return lab__fail(err, STEIN_EINVAL,
                         "%s has no place in %s: write it there before it is fitted", name,
                         m->file);
    }
    change *c = &p->list[p->n++];
    char unit[MECH_UNIT];
    c->name = name;
    c->value = value;
    c->from = find_byte(p, m->params[k].line, m->params[k].column);
    find_scalar(p, &c->from, &c->to);
    find_unit(p->text + c->from, c->to - c->from, unit);
    write_quantity(c->text, &m->params[k], unit, value, sd);
    if (p->text[c->from] == '"' || p->text[c->from] == '\'') { // the quotes stay
        c->from++;
        c->to--;
    }
    return STEIN_OK;
}

static int by_place(const void *a, const void *b)
{
    const change *x = a, *y = b;
    return x->from < y->from ? -1 : x->from > y->from;
}

/* ---- the head ---- */

static void write_head(FILE *f, const lab_fit *fit, const char *file, const mechanism *m)
{
    char text[LAB_NUMBER], sd[LAB_NUMBER];
    const char *name = strrchr(file, '/');
    fprintf(f, "# Fitted by stein fit (%s), from %s (fnv1a64 %s).\n",
            lab_fit_status_text(fit->status), name != NULL ? name + 1 : file, m->input_hash);
    if (fit->reason[0] != '\0') {
        fprintf(f, "# %s\n", fit->reason);
    }
    rounded(text, fit->chi2, 6);
    rounded(sd, fit->chi2_dof, 4);
    fprintf(f, "# %d samples of %d strokes, chi2 %s, chi2/dof %s\n", fit->samples, fit->nstroke,
            text, sd);
    for (int s = 0; s < fit->nstroke; s++) {
        const char *base = strrchr(fit->stroke[s].file, '/');
        fprintf(f, "#   data %s (fnv1a64 %016llx)\n", base != NULL ? base + 1 : fit->stroke[s].file,
                fit->stroke[s].hash);
    }
    for (int k = 0; k < fit->nvalue; k++) {
        const lab_fit_value *v = &fit->value[k];
        const char *unit = strcmp(v->unit, "1") == 0 ? "" : v->unit;
        rounded(text, v->value, 6);
        rounded(sd, v->sd, 3);
        fprintf(f, "#   %s = %s +- %s %s", v->name, text, sd, unit);
        rounded(text, v->start, 6);
        fprintf(f, " (was %s)%s\n", text, v->unseen ? " - no data depend on it" : "");
    }
    fprintf(f, "#\n");
}

static void write_body(FILE *f, const patch *p)
{
    size_t at = 0;
    for (int i = 0; i < p->n; i++) {
        fwrite(p->text + at, 1, p->list[i].from - at, f);
        fputs(p->list[i].text, f);
        at = p->list[i].to;
    }
    fwrite(p->text + at, 1, p->size - at, f);
}

/* ---- check ---- */

/* the new text must be a mechanism, and the same one but for its numbers */
static stein_status check(const char *text, size_t size, const patch *p, const mechanism *old,
                          const char *path, stein_err *err)
{
    mechanism *m = NULL;
    stein_err why = {STEIN_OK, ""};
    if (mech_read_text(&m, path, text, size, NULL, 0, NULL, NULL, &why) != STEIN_OK) {
        return lab__fail(err, STEIN_EPARSE, "the fitted file would not be valid: %s", why.msg);
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < p->n; i++) {
        int k = mech_find_param(m, p->list[i].name, NULL);
        double value = k >= 0 ? m->params[k].value : NAN;
        if (!(fabs(value - p->list[i].value) <= 1e-9 * fabs(p->list[i].value))) {
            status =
                lab__fail(err, STEIN_EINVAL, "%s cannot be written to %s", p->list[i].name, path);
        }
    }
    if (status == STEIN_OK && m->nparam != old->nparam) {
        status = lab__fail(err, STEIN_EINVAL, "the fitted file would be another mechanism");
    }
    mech_free(m);
    return status;
}

static stein_status put(const patch *p, const lab_fit *fit, const char *file, const mechanism *m,
                        const char *path, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (f == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    write_head(f, fit, file, m);
    write_body(f, p);
    stein_status status = fclose(f) == 0 ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
    status = status == STEIN_OK ? check(text, size, p, m, path, err) : status;
    lab__file out;
    status = status == STEIN_OK ? lab__file_open(&out, path, err) : status;
    if (status == STEIN_OK) {
        fwrite(text, 1, size, out.stream);
        status = lab__file_close(&out, 1, err);
    }
    free(text);
    return status;
}

/* ---- overrides ---- */

/* name and value of "NAME=VALUE" */
static stein_status cut_sets(mech_set **sets, char **room, const lab_options *o, stein_err *err)
{
    size_t size = 1;
    for (int i = 0; i < o->nset; i++) {
        size += strlen(o->set[i]) + 1;
    }
    *sets = calloc((size_t)o->nset + 1, sizeof **sets);
    *room = malloc(size);
    if (*sets == NULL || *room == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    char *at = *room;
    for (int i = 0; i < o->nset; i++) {
        strcpy(at, o->set[i]);
        char *sign = strchr(at, '=');
        if (sign == NULL) {
            return lab__fail(err, STEIN_EINVAL, "override \"%s\": expected NAME=VALUE", at);
        }
        *sign = '\0';
        (*sets)[i] = (mech_set){at, sign + 1};
        at += strlen(o->set[i]) + 1;
    }
    return STEIN_OK;
}

/* fitted numbers, and overrides that were not fitted */
static stein_status collect(patch *p, const lab_fit *fit, const mechanism *m, const mech_set *sets,
                            int nset, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int k = 0; status == STEIN_OK && k < fit->nvalue; k++) {
        status = add(p, m, fit->value[k].name, fit->value[k].value, fit->value[k].sd, err);
    }
    for (int i = 0; status == STEIN_OK && i < nset; i++) {
        int done = 0, k = mech_find_param(m, sets[i].name, NULL);
        for (int c = 0; c < p->n; c++) {
            done |= strcmp(p->list[c].name, sets[i].name) == 0;
        }
        if (!done && k >= 0) {
            status = add(p, m, sets[i].name, m->params[k].value, m->params[k].tolerance, err);
        }
    }
    return status;
}

stein_status lab_fit_write(const char *path, const lab_fit *fit, const char *file,
                           const lab_options *options, stein_err *err)
{
    lab_options defaults = lab_options_default();
    options = options != NULL ? options : &defaults;
    patch p = {.text = NULL};
    mech_set *sets = NULL;
    char *room = NULL;
    mechanism *m = NULL;
    stein_status status = cut_sets(&sets, &room, options, err);
    status = status == STEIN_OK ? read_all(file, &p.text, &p.size, err) : status;
    status = status == STEIN_OK ? mech_read_text(&m, file, p.text, p.size, sets, options->nset,
                                                 options->report, options->ctx, err)
                                : status;
    if (status == STEIN_OK) {
        p.list = calloc((size_t)(fit->nvalue + options->nset) + 1, sizeof *p.list);
        status = p.list != NULL ? collect(&p, fit, m, sets, options->nset, err)
                                : lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    if (status == STEIN_OK) {
        qsort(p.list, (size_t)p.n, sizeof *p.list, by_place);
        status = put(&p, fit, file, m, path, err);
    }
    if (m != NULL) {
        mech_free(m);
    }
    free(p.list);
    free(p.text);
    free(sets);
    free(room);
    return status;
}
