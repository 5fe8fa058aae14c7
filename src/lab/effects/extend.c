/* SPDX-License-Identifier: GPL-3.0-or-later
 * extend.c - the mechanism file with the causes of a diagnosis in it.
 *
 *      text --parts of the causes--> text with parts --values, then causes--> p --patch--> file
 *
 * The numbers result from lab_candidate_apply on the refitted values, so file and diagnosis
 * describe the same motion. A part has its amount as a separate number; every other cause is a
 * number that has its place in the file, or gets it. Only changed numbers are written, with fifteen
 * digits, which is more than can be measured. A change between records is written with its later
 * value; one record's own setting is no number of the file.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { FULL_DIGITS = 15, SHOWN = 80 };

typedef struct extension {
    const lab_diagnosis *d;
    const char *file;
    char *text; /* the file, then with parts */
    size_t size;
    char hash[17];       /* of the file */
    lab_model *model;    /* of the text with parts */
    lab_candidate *list; /* [ncause] bound to that model, with the numbers found */
    double *p, *sd;      /* [np] */
    unsigned char *new;  /* [np] 1: to be written */
    int *cause;          /* [np] 1 + index of the cause that has moved it; 0: none */
} extension;

/* ---- numbers of a cause ---- */

static int is_called(const char *path, const char *name)
{
    const char *last = strrchr(path, '.');
    return strcmp(path, name) == 0 || (last != NULL && strcmp(last + 1, name) == 0);
}

static const lab_cause_number *find_number(const lab_suspect *s, const char *path)
{
    for (int i = 0; path != NULL && i < s->nnumber; i++) {
        if (is_called(path, s->number[i].name)) {
            return &s->number[i];
        }
    }
    return NULL;
}

/* the candidate with the numbers beside its amount that were found */
static lab_candidate as_found(const lab_suspect *s)
{
    lab_candidate c = s->candidate;
    for (int k = 0; k < LAB_SIDES; k++) {
        const lab_cause_number *n = find_number(s, c.side[k].name);
        c.side[k].value = n != NULL ? n->value : c.side[k].value;
    }
    return c;
}

static double deviation(const lab_cause_number *n)
{
    return n != NULL && isfinite(n->sd) && n->sd > 0.0 ? n->sd : 0.0;
}

/* of a parameter that an amount moved to `after` */
static double moved_deviation(const lab_candidate *c, const lab_suspect *s, double after)
{
    const lab_cause_number *n = find_number(s, lab_candidate_size(c));
    double sd = deviation(n);
    int of_amount = n != NULL && fabs(n->value - s->amount) <= fabs(n->value - after);
    return of_amount && c->move == LAB_MOVE_SCALE ? sd * fabs(after) : sd;
}

/* is it one record's own, and nothing of the mechanism? */
static int is_of_record(const lab_suspect *s)
{
    return s->candidate.until > 0;
}

int lab_diagnosis_extends(const lab_diagnosis *d)
{
    int any = d->nlaw > 0 && d->law[0].pays;
    for (int i = 0; i < d->ncause; i++) {
        any |= !is_of_record(&d->suspect[i]);
    }
    return any;
}

/* ---- the text with parts ---- */

static stein_status add_part(extension *x, const lab_suspect *s, stein_err *err)
{
    const lab_candidate c = as_found(s);
    mechanism *m = NULL;
    char *text = NULL;
    size_t size = 0;
    stein_status status = mech_read_text(&m, x->file, x->text, x->size, NULL, 0, NULL, NULL, err);
    if (status == STEIN_OK) {
        status = lab__structure_text(&c, s->amount, m, x->text, x->size, &text, &size, err);
        mech_free(m);
    }
    if (status == STEIN_OK) {
        free(x->text);
        x->text = text;
        x->size = size;
    }
    return status;
}

/* of an unknown effect; NULL: none */
static const lab_law *law_of(const lab_diagnosis *d)
{
    return d->ncause == 0 && d->nlaw > 0 && d->law[0].pays ? &d->law[0] : NULL;
}

static stein_status add_law(extension *x, const lab_law *law, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = lab__law_text(law, x->text, x->size, &text, &size, err);
    if (status == STEIN_OK) {
        free(x->text);
        x->text = text;
        x->size = size;
    }
    return status;
}

static stein_status add_parts(extension *x, stein_err *err)
{
    mechanism *m = NULL;
    stein_status status = lab__read_file(x->file, &x->text, &x->size, err);
    status = status == STEIN_OK
                 ? mech_read_text(&m, x->file, x->text, x->size, NULL, 0, NULL, NULL, err)
                 : status;
    if (status == STEIN_OK) {
        snprintf(x->hash, sizeof x->hash, "%s", m->input_hash);
        mech_free(m);
    }
    for (int i = 0; status == STEIN_OK && i < x->d->ncause; i++) {
        const lab_suspect *s = &x->d->suspect[i];
        status = s->candidate.effect->needs != NULL ? add_part(x, s, err) : status;
    }
    if (status == STEIN_OK && law_of(x->d) != NULL) {
        status = add_law(x, law_of(x->d), err);
    }
    return status == STEIN_OK ? lab__open_text(&x->model, x->file, x->text, x->size, NULL, err)
                              : status;
}

/* ---- its numbers ---- */

static stein_status take_values(extension *x, stein_err *err)
{
    const stein_model *m = lab_equations(x->model);
    for (int k = 0; k < x->d->nvalue; k++) {
        const lab_fit_value *v = &x->d->value[k];
        int i = stein_find_param(m, v->name);
        if (i < 0) {
            return lab__fail(err, STEIN_EINVAL, "%s has no number %s", x->file, v->name);
        }
        x->p[i] = v->value;
        x->sd[i] = isfinite(v->sd) ? v->sd : 0.0;
        x->new[i] = 1;
    }
    return STEIN_OK;
}

static void mark(extension *x, int param, double sd)
{
    if (param >= 0) {
        x->new[param] = 1;
        x->sd[param] = sd;
    }
}

static stein_status take_cause(extension *x, int k, stein_err *err)
{
    const lab_suspect *s = &x->d->suspect[k];
    lab_candidate *c = &x->list[k];
    double before[LAB_MOVED] = {0.0};
    *c = as_found(s);
    stein_status status = lab_candidate_bind(c, x->model, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (int i = 0; i < c->nparam; i++) {
        before[i] = x->p[c->param[i]];
    }
    lab_candidate_apply(c, s->amount, x->p);
    for (int i = 0; i < c->nparam; i++) {
        double after = x->p[c->param[i]];
        int follows = c->move == LAB_MOVE_SPRING && i > 0; // by the stiffness, not by the data
        double sd = moved_deviation(c, s, after);
        sd = x->d->chi2_dof_after > diag__guessed
                 ? fmax(sd, diag__some_of * fabs(after - before[i]))
                 : sd;
        mark(x, c->param[i], follows ? 0.0 : sd);
        x->cause[c->param[i]] = 1 + k;
    }
    for (int i = 0; i < LAB_SIDES; i++) {
        mark(x, c->side[i].param, deviation(find_number(s, c->side[i].name)));
    }
    return STEIN_OK;
}

static stein_status take_numbers(extension *x, stein_err *err)
{
    size_t np = (size_t)lab_equations(x->model)->np;
    x->list = calloc((size_t)x->d->ncause + 1, sizeof *x->list);
    x->p = malloc(sizeof *x->p * (np + 1));
    x->sd = calloc(np + 1, sizeof *x->sd);
    x->new = calloc(np + 1, 1);
    x->cause = calloc(np + 1, sizeof *x->cause);
    if (x->list == NULL || x->p == NULL || x->sd == NULL || x->new == NULL || x->cause == NULL) {
        return lab__no_memory(err);
    }
    memcpy(x->p, lab_parameters(x->model), sizeof *x->p * np);
    stein_status status = take_values(x, err);
    for (int k = 0; status == STEIN_OK && k < x->d->ncause; k++) {
        status = is_of_record(&x->d->suspect[k]) ? STEIN_OK : take_cause(x, k, err);
    }
    return status;
}

/* ---- the head ---- */

/* in the unit, with few digits */
static const char *shown(char text[SHOWN], double value, const char *unit)
{
    int bare = unit == NULL || strcmp(unit, "1") == 0;
    snprintf(text, SHOWN, "%.5g%s%s", value, bare ? "" : " ", bare ? "" : unit);
    for (char *c = text; *c != '\0'; c++) {
        if (*c == ',') { // of a locale
            *c = '.';
        }
    }
    return text;
}

static void write_text(FILE *f, const char *text)
{
    for (; *text != '\0'; text++) {
        fputc(*text == '\n' || *text == '\r' ? ' ' : *text, f);
    }
    fputc('\n', f);
}

static void write_number(FILE *f, const char *name, const char *unit, double value,
                         const lab_cause_number *n)
{
    char text[SHOWN], lo[SHOWN], hi[SHOWN];
    fprintf(f, "#     %s = %s", name, shown(text, value, unit));
    if (n != NULL && isfinite(n->lo) && isfinite(n->hi)) {
        fprintf(f, ", 95 %%: %s .. %s", shown(lo, n->lo, n->unit), shown(hi, n->hi, n->unit));
    }
    fputc('\n', f);
}

static void write_cause(FILE *f, const lab_suspect *s)
{
    const lab_candidate c = as_found(s);
    char scope[LAB_PLACE];
    fprintf(f, "#   %s at %s%s: %s%s\n", c.effect->kind, c.place, lab_candidate_scope(&c, scope),
            lab_candidate_equation(&c),
            is_of_record(s) ? "; not in this file, but in that record" : "");
    const lab_cause_number *size = find_number(s, lab_candidate_size(&c));
    write_number(f, lab_candidate_size(&c), size != NULL ? size->unit : c.unit,
                 size != NULL ? size->value : s->amount, size);
    char change[LAB_CHANGE_TEXT];
    if (*lab_change_text(s, change) != '\0' && !is_of_record(s)) {
        fprintf(f, "#     so %s\n", change);
    }
    for (int k = 0; k < LAB_SIDES && c.side[k].name != NULL; k++) {
        const lab_side *side = &c.side[k];
        write_number(f, side->name, side->unit, side->value, find_number(s, side->name));
    }
}

static void write_data(FILE *f, const lab_diagnosis *d)
{
    char text[3][SHOWN];
    fprintf(f, "# From %d records, and %d held out", d->nfit, d->nheld);
    if (isfinite(d->gain.ratio)) {
        fprintf(f, ", where the error is %s of the former one, 95 %%: %s .. %s",
                shown(text[0], d->gain.ratio, NULL), shown(text[1], d->gain.lo, NULL),
                shown(text[2], d->gain.hi, NULL));
    }
    fputc('\n', f);
    for (int i = 0; i < d->nrecord; i++) {
        char plain[LAB_PRINTABLE];
        const char *base = strrchr(d->record[i].file, '/');
        fprintf(f, "#   data %s%s\n",
                lab__printable(plain, base != NULL ? base + 1 : d->record[i].file),
                d->record[i].reporting ? " (held out)" : "");
    }
    for (int i = 0; i < d->nfinding; i++) {
        fputs("#   audit ", f);
        write_text(f, d->finding[i]);
    }
}

/* the refitted numbers as this file has them; of one that a cause moves, where it moved from */
static void write_values(FILE *f, const extension *x)
{
    const stein_model *m = lab_equations(x->model);
    fputs(x->d->nvalue > 0 ? "# Refitted, numbers as they are below:\n" : "", f);
    for (int k = 0; k < x->d->nvalue; k++) {
        char text[4][SHOWN];
        const lab_fit_value *v = &x->d->value[k];
        int i = stein_find_param(m, v->name), by = x->cause[i];
        fprintf(f, "#   %s = %s +- %s (was %s", v->name, shown(text[0], x->p[i], NULL),
                shown(text[1], x->sd[i], v->unit), shown(text[2], v->start, NULL));
        if (by > 0) {
            const lab_candidate *c = &x->d->suspect[by - 1].candidate;
            fprintf(f, "; without the cause %s at %s it is %s", c->effect->kind, c->place,
                    shown(text[3], v->value, NULL));
        }
        fputs(")\n", f);
    }
}

static void write_head(FILE *f, const extension *x)
{
    const lab_diagnosis *d = x->d;
    const char *name = strrchr(x->file, '/');
    char plain[LAB_PRINTABLE];
    fprintf(f, "# Extended by stein diagnose (%s), from %s (fnv1a64 %s).\n",
            lab_verdict_text(d->verdict), lab__printable(plain, name != NULL ? name + 1 : x->file),
            x->hash);
    if (d->reason[0] != '\0') {
        fputs("# ", f);
        write_text(f, d->reason);
    }
    fputs("# Added:\n", f);
    for (int i = 0; i < d->ncause; i++) {
        write_cause(f, &d->suspect[i]);
    }
    const lab_law *law = law_of(d);
    if (law != NULL) {
        fprintf(f, "#   a %s at %s over its %s, as the table %s\n", law->what, law->place, law->of,
                law->table);
    }
    write_data(f, d);
    write_values(f, x);
    fputs("#\n", f);
}

/* ---- the file ---- */

/* the head, then the file with its numbers patched */
static stein_status write_all(const extension *x, char **out, stein_err *err)
{
    const stein_model *m = lab_equations(x->model);
    fit__number *list = calloc((size_t)m->np + 1, sizeof *list);
    char *text = NULL;
    size_t size = 0;
    int n = 0;
    for (int i = 0; list != NULL && i < m->np; i++) {
        if (x->new[i]) {
            double sd = x->sd[i] > 0.0 ? x->sd[i] : m->params[i].tolerance;
            list[n++] = (fit__number){m->params[i].name, x->p[i], sd};
        }
    }
    stein_status status = list != NULL ? fit__patch(&text, &size, lab__mechanism(x->model), x->text,
                                                    x->size, list, n, FULL_DIGITS, err)
                                       : lab__no_memory(err);
    free(list);
    FILE *f = status == STEIN_OK ? lab__text_open(out) : NULL;
    if (status == STEIN_OK && f == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        size_t mark = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
        locale_t before = lab__locale_c();
        write_head(f, x);
        lab__locale_restore(before);
        fwrite(text + mark, 1, size - mark, f);
        status = lab__text_close(f, out, err);
    }
    free(text);
    return status;
}

stein_status lab__extended_text(char **text, const char *file, const lab_diagnosis *diagnosis,
                                stein_err *err)
{
    extension x = {.d = diagnosis, .file = file};
    if (!lab_diagnosis_extends(diagnosis)) {
        return lab__fail(err, STEIN_EINVAL, "there is no cause to extend %s by", file);
    }
    stein_status status = add_parts(&x, err);
    status = status == STEIN_OK ? take_numbers(&x, err) : status;
    status = status == STEIN_OK ? write_all(&x, text, err) : status;
    lab_close(x.model);
    free(x.list);
    free(x.p);
    free(x.sd);
    free(x.new);
    free(x.cause);
    free(x.text);
    return status;
}

stein_status lab_extend(const char *path, const char *file, const lab_diagnosis *diagnosis,
                        stein_err *err)
{
    char *text = NULL;
    lab__file out;
    stein_status status = lab__extended_text(&text, file, diagnosis, err);
    status = status == STEIN_OK ? lab__file_open(&out, path, err) : status;
    if (status == STEIN_OK) {
        fputs(text, out.stream);
        status = lab__file_close(&out, 1, err);
    }
    free(text);
    return status;
}
