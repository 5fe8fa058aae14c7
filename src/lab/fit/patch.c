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

enum { CELL = 400 };

/* text[from..to) becomes something else; law: a whole law comes in */
typedef struct change {
    size_t from, to;
    char text[2 * CELL];
    const char *name;
    double value;
    int law;
} change;

typedef struct patch {
    const char *text;
    size_t size;
    const fit__number *wanted; /* [nwanted] */
    int nwanted, digits;
    change *list; /* [n] */
    int n;
    int no_memory; /* a place was not found for want of it */
} patch;

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
                           double sd, int digits)
{
    char number[LAB_NUMBER], tolerance[LAB_NUMBER], unit[MECH_UNIT];
    mech_dim dim;
    double factor = 1.0;
    snprintf(unit, sizeof unit, "%s", old_unit);
    if (unit[0] == '\0' || mech_parse_unit(unit, &dim, &factor) != 0 || dim.kg != q->dim.kg ||
        dim.m != q->dim.m || dim.s != q->dim.s || dim.A != q->dim.A) {
        factor = 1.0;
        snprintf(unit, sizeof unit, "%s", strcmp(q->unit, "1") == 0 ? "" : q->unit);
    }
    rounded(number, value / factor, digits);
    rounded(tolerance, sd / factor, 3);
    const char *blank = unit[0] == '\0' ? "" : " ";
    if (sd > 0.0 && isfinite(sd)) {
        snprintf(text, CELL, "%s%s%s +- %s%s%s", number, blank, unit, tolerance, blank, unit);
    } else {
        snprintf(text, CELL, "%s%s%s", number, blank, unit);
    }
}

/* ---- one number ---- */

static change *new_change(patch *p, const char *name, double value)
{
    change *c = &p->list[p->n++];
    *c = (change){.name = name, .value = value};
    return c;
}

/* a number that stands in the file */
static void replace(patch *p, const mech_param *q, const fit__number *w)
{
    change *c = new_change(p, w->name, w->value);
    char unit[MECH_UNIT];
    c->from = find_byte(p, q->line, q->column);
    find_scalar(p, &c->from, &c->to);
    find_unit(p->text + c->from, c->to - c->from, unit);
    write_quantity(c->text, q, unit, w->value, w->sd, p->digits);
    if (p->text[c->from] == '"' || p->text[c->from] == '\'') { // the quotes stay
        c->from++;
        c->to--;
    }
}

/* the entry "k: 5 N/m, theta0: 0 rad" of all numbers of a law, of which some are wanted */
static int write_section(const patch *p, const mechanism *m, const char *prefix, char *text)
{
    size_t n = strlen(prefix), at = 0;
    for (int k = 0; k < m->nparam; k++) {
        const mech_param *q = &m->params[k];
        char quantity[CELL];
        if (strncmp(q->name, prefix, n) != 0 || strchr(q->name + n, '.') != NULL) {
            continue;
        }
        fit__number w = {q->name, q->value, q->tolerance};
        for (int i = 0; i < p->nwanted; i++) {
            w = strcmp(p->wanted[i].name, q->name) == 0 ? p->wanted[i] : w;
        }
        write_quantity(quantity, q, "", w.value, w.sd, p->digits);
        int wrote =
            snprintf(text + at, CELL - at, "%s%s: %s", at > 0 ? ", " : "", q->name + n, quantity);
        at += wrote > 0 ? (size_t)wrote : 0;
        if (at >= CELL) {
            return -1;
        }
    }
    return 0;
}

/* before the first key of the mapping at the place */
static void insert(patch *p, const fit__place *place, const char *entry, change *c)
{
    c->from = c->to = find_byte(p, place->line, place->column);
    snprintf(c->text, sizeof c->text, place->flow ? "%s, " : "%s\n%*s", entry,
             place->flow ? 0 : place->column - 1, "");
}

static int find_mapping(patch *p, const char *const *path, int n, fit__place *place)
{
    int found = fit__find_mapping(p->text, p->size, path, n, place);
    p->no_memory |= place->no_memory;
    return found;
}

/* the mapping of "owner" in whichever part of the file it is. @return the length of its path, 0:
 * none */
static int find_owner(patch *p, const char *owner, const char *path[3], fit__place *place)
{
    static const char *const part[] = {"bodies", "contacts", "notches",
                                       "links",  "inputs",   "outputs"};
    path[1] = owner;
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        path[0] = part[i];
        if (find_mapping(p, path, 2, place)) {
            return 2;
        }
    }
    path[0] = owner; // the load
    return find_mapping(p, path, 1, place);
}

/* a number that the file leaves at its neutral value: written where it belongs. @return 0, or -1 */
static int introduce(patch *p, const mechanism *m, const mech_param *q, const fit__number *w)
{
    char name[MECH_PATH], prefix[MECH_PATH], entry[CELL], law[CELL];
    const char *path[3];
    fit__place place;
    snprintf(name, sizeof name, "%s", q->name);
    char *key = strchr(name, '.');
    if (key == NULL) {
        return -1;
    }
    *key++ = '\0';
    char *rest = strchr(key, '.');
    int n = find_owner(p, name, path, &place);
    if (n == 0 && (rest != NULL || strcmp(name, "clock") != 0)) {
        return -1;
    }
    write_quantity(law, q, "", w->value, w->sd, p->digits);
    if (n == 0) { // a section that the file does without
        change *c = new_change(p, w->name, w->value);
        c->from = c->to = p->size;
        snprintf(c->text, sizeof c->text, "%s%s: {%.60s: %.300s}\n",
                 p->size > 0 && p->text[p->size - 1] == '\n' ? "" : "\n", name, key, law);
        return 0;
    }
    if (rest == NULL) {
        snprintf(entry, sizeof entry, "%.60s: %.300s", key, law);
        insert(p, &place, entry, new_change(p, w->name, w->value));
        return 0;
    }
    *rest++ = '\0';
    path[n] = key;
    if (find_mapping(p, path, n + 1, &place)) {
        snprintf(entry, sizeof entry, "%.60s: %.300s", rest, law);
        insert(p, &place, entry, new_change(p, w->name, w->value));
        return 0;
    }
    snprintf(prefix, sizeof prefix, "%.*s.", (int)(rest - name - 1), q->name);
    change *c = new_change(p, w->name, w->value);
    for (int i = 0; i < p->n - 1; i++) {
        if (strncmp(p->list[i].name, prefix, strlen(prefix)) == 0 && p->list[i].law) {
            *c = (change){
                .name = w->name, .value = w->value, .from = p->list[i].from, .to = p->list[i].to};
            return 0; // it came along with the first one of its law
        }
    }
    c->law = 1;
    if (write_section(p, m, prefix, law) != 0) {
        return -1;
    }
    char whole[2 * CELL];
    snprintf(whole, sizeof whole, "%.40s: {%.350s}", key, law);
    insert(p, &place, whole, c);
    return strlen(whole) + (size_t)place.column + 2 < sizeof c->text ? 0 : -1;
}

static stein_status add(patch *p, const mechanism *m, const fit__number *w, stein_err *err)
{
    int k = mech_find_param(m, w->name, NULL);
    if (k >= 0 && m->params[k].line > 0) {
        replace(p, &m->params[k], w);
        return STEIN_OK;
    }
    return k >= 0 && introduce(p, m, &m->params[k], w) == 0
               ? STEIN_OK
               : lab__fail(err, STEIN_EINVAL, "%s has no place in %s: write it there first",
                           w->name, m->file);
}

static int by_place(const void *a, const void *b)
{
    const change *x = a, *y = b;
    return x->from < y->from ? -1 : x->from > y->from;
}

/* ---- the head ---- */

static void write_head(FILE *f, const lab_fit *fit, const char *file, const mechanism *m)
{
    char text[LAB_NUMBER], sd[LAB_NUMBER], plain[LAB_PRINTABLE];
    const char *name = strrchr(file, '/');
    fprintf(f, "# Fitted by stein fit (%s), from %s (fnv1a64 %s).\n",
            lab_fit_status_text(fit->status), lab__printable(plain, name != NULL ? name + 1 : file),
            m->input_hash);
    if (fit->reason[0] != '\0') {
        fprintf(f, "# %s\n", fit->reason);
    }
    rounded(text, fit->chi2, 6);
    rounded(sd, fit->chi2_dof, 4);
    fprintf(f, "# %d samples of %d records, chi2 %s, chi2/dof %s\n", fit->samples, fit->nstroke,
            text, sd);
    for (int s = 0; s < fit->nstroke; s++) {
        const char *base = strrchr(fit->stroke[s].file, '/');
        fprintf(f, "#   data %s (fnv1a64 %016llx)\n",
                lab__printable(plain, base != NULL ? base + 1 : fit->stroke[s].file),
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

/* ---- check ---- */

/* the new text must be a mechanism, and the same one but for its numbers */
static stein_status check(const char *text, size_t size, const patch *p, const mechanism *old,
                          const char *path, stein_err *err)
{
    mechanism *m = NULL;
    stein_err why = {STEIN_OK, ""};
    stein_status status = mech_read_text(&m, path, text, size, NULL, 0, NULL, NULL, &why);
    if (status != STEIN_OK) {
        return status == STEIN_ENOMEM
                   ? lab__no_memory(err)
                   : lab__fail(err, STEIN_EPARSE, "the fitted file would not be valid: %s",
                               why.msg);
    }
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

/* ---- the text ---- */

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

stein_status fit__patch(char **out, size_t *nout, const mechanism *m, const char *text, size_t size,
                        const fit__number *number, int n, int digits, stein_err *err)
{
    patch p = {.text = text, .size = size, .wanted = number, .nwanted = n, .digits = digits};
    char *patched = NULL;
    p.list = calloc((size_t)n + 1, sizeof *p.list);
    FILE *f = p.list != NULL ? lab__text_open(&patched) : NULL;
    if (f == NULL) {
        free(p.list);
        return lab__no_memory(err);
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        status = add(&p, m, &number[i], err);
        status = p.no_memory ? lab__no_memory(err) : status;
    }
    if (status == STEIN_OK) {
        qsort(p.list, (size_t)p.n, sizeof *p.list, by_place);
        write_body(f, &p);
    }
    stein_status closed = lab__text_close(f, &patched, status == STEIN_OK ? err : NULL);
    status = status == STEIN_OK ? closed : status;
    status = status == STEIN_OK ? check(patched, strlen(patched), &p, m, m->file, err) : status;
    free(p.list);
    if (status != STEIN_OK) {
        free(patched);
        return status;
    }
    *out = patched;
    *nout = strlen(patched);
    return STEIN_OK;
}

static stein_status put(const lab_fit *fit, const char *file, const mechanism *m, const char *text,
                        size_t size, const char *path, stein_err *err)
{
    lab__file out;
    stein_status status = lab__file_open(&out, path, err);
    if (status == STEIN_OK) {
        size_t mark = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
        write_head(out.stream, fit, file, m);
        fwrite(text + mark, 1, size - mark, out.stream);
        status = lab__file_close(&out, 1, err);
    }
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
        return lab__no_memory(err);
    }
    char *at = *room;
    for (int i = 0; i < o->nset; i++) {
        memcpy(at, o->set[i], strlen(o->set[i]) + 1);
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
static int collect(fit__number *list, const lab_fit *fit, const mechanism *m, const mech_set *sets,
                   int nset)
{
    int n = 0;
    for (int k = 0; k < fit->nvalue; k++) {
        const lab_fit_value *v = &fit->value[k];
        list[n++] = (fit__number){v->name, v->value, v->sd};
    }
    for (int i = 0; i < nset; i++) {
        int known = 0, k = mech_find_param(m, sets[i].name, NULL);
        for (int c = 0; c < n; c++) {
            known |= strcmp(list[c].name, sets[i].name) == 0;
        }
        if (!known && k >= 0) {
            list[n++] =
                (fit__number){m->params[k].name, m->params[k].value, m->params[k].tolerance};
        }
    }
    return n;
}

stein_status lab_fit_write(const char *path, const lab_fit *fit, const char *file,
                           const lab_options *options, stein_err *err)
{
    lab_options defaults = lab_options_default();
    options = options != NULL ? options : &defaults;
    mech_set *sets = NULL;
    char *room = NULL, *text = NULL, *fitted = NULL;
    size_t size = 0, nfitted = 0;
    mechanism *m = NULL;
    fit__number *list = calloc((size_t)(fit->nvalue + options->nset) + 1, sizeof *list);
    if (list == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = cut_sets(&sets, &room, options, err);
    status = status == STEIN_OK ? lab__read_file(file, &text, &size, err) : status;
    status = status == STEIN_OK ? mech_read_text(&m, file, text, size, sets, options->nset,
                                                 options->report, options->ctx, err)
                                : status;
    if (status == STEIN_OK) {
        int n = collect(list, fit, m, sets, options->nset);
        status = fit__patch(&fitted, &nfitted, m, text, size, list, n, 10, err);
    }
    if (status == STEIN_OK) {
        status = put(fit, file, m, fitted, nfitted, path, err);
    }
    if (m != NULL) {
        mech_free(m);
    }
    free(list);
    free(fitted);
    free(text);
    free(sets);
    free(room);
    return status;
}
