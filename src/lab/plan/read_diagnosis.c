/* SPDX-License-Identifier: GPL-3.0-or-later
 * read_diagnosis.c - the part of diagnosis.json that a plan needs.
 *
 * JSON is read by libyaml, whose documents keep the line of everything: a JSON file is a YAML file,
 * and no further library is needed. Names are checked against the mechanism, so that a diagnosis of
 * another one is refused where it stops to fit.
 */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "planning.h"
#include "verdict.h"

enum { LARGEST = 1 << 27, NUMBERS = 1000, SUSPECTS = 1000 };

typedef struct reader {
    yaml_document_t doc;
    const char *path;
    const lab_model *model;
    const stein_model *m;
    lab_candidate *candidate;
    int ncandidate;
    stein_status status; /* the first failure stays */
    stein_err *err;
} reader;

/* ---- nodes ---- */

static void bad(reader *r, const yaml_node_t *at, const char *format, ...)
{
    char text[300];
    va_list args;
    if (r->status != STEIN_OK) {
        return;
    }
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    r->status = lab__fail(r->err, STEIN_EPARSE, "%s:%d: %s", r->path,
                          at != NULL ? (int)at->start_mark.line + 1 : 1, text);
}

static void no_memory(reader *r)
{
    r->status = r->status == STEIN_OK ? lab__no_memory(r->err) : r->status;
}

/* the value of a key. @return NULL: there is none */
static yaml_node_t *find(reader *r, yaml_node_t *of, const char *key)
{
    if (r->status != STEIN_OK) {
        return NULL;
    }
    if (of == NULL || of->type != YAML_MAPPING_NODE) {
        bad(r, of, "expected an object with \"%s\"", key);
        return NULL;
    }
    for (yaml_node_pair_t *p = of->data.mapping.pairs.start; p < of->data.mapping.pairs.top; p++) {
        const yaml_node_t *k = yaml_document_get_node(&r->doc, p->key);
        if (k != NULL && k->type == YAML_SCALAR_NODE &&
            strcmp((const char *)k->data.scalar.value, key) == 0) {
            return yaml_document_get_node(&r->doc, p->value);
        }
    }
    return NULL;
}

/* the same; NULL is a failure */
static yaml_node_t *field(reader *r, yaml_node_t *of, const char *key)
{
    yaml_node_t *n = find(r, of, key);
    if (n == NULL && r->status == STEIN_OK) {
        bad(r, of, "\"%s\" is missing; was this written by stein diagnose, of this version?", key);
    }
    return n;
}

static const char *text_of(reader *r, yaml_node_t *of, const char *key)
{
    yaml_node_t *n = field(r, of, key);
    if (n != NULL && n->type == YAML_SCALAR_NODE) {
        return (const char *)n->data.scalar.value;
    }
    bad(r, n, "\"%s\": expected a text", key);
    return "";
}

/* a number; null is NAN where that is allowed */
static double number(reader *r, yaml_node_t *n, const char *key, int null)
{
    double value = NAN;
    const char *text = n != NULL && n->type == YAML_SCALAR_NODE ? (char *)n->data.scalar.value : "";
    if (r->status != STEIN_OK || (null && strcmp(text, "null") == 0)) {
        return NAN;
    }
    if (mech_parse_quantity(text, (mech_dim){.kg = 0}, &value, NULL) != STEIN_OK) {
        bad(r, n, "\"%s\": expected a number, not %.40s%s%s", key, *text ? "\"" : "nothing",
            *text ? text : "", *text ? "\"" : "");
    }
    return value;
}

static double number_of(reader *r, yaml_node_t *of, const char *key)
{
    return number(r, field(r, of, key), key, 0);
}

static int truth_of(reader *r, yaml_node_t *of, const char *key)
{
    const char *text = text_of(r, of, key);
    int yes = strcmp(text, "true") == 0;
    if (!yes && strcmp(text, "false") != 0) {
        bad(r, of, "\"%s\": expected true or false", key);
    }
    return yes;
}

/* a list and its length */
static yaml_node_t *list_of(reader *r, yaml_node_t *of, const char *key, int most, int *n)
{
    yaml_node_t *list = field(r, of, key);
    *n = 0;
    if (r->status != STEIN_OK) {
        return NULL;
    }
    if (list == NULL || list->type != YAML_SEQUENCE_NODE) {
        bad(r, list, "\"%s\": expected a list", key);
        return NULL;
    }
    ptrdiff_t length = list->data.sequence.items.top - list->data.sequence.items.start;
    if (length > most) {
        bad(r, list, "\"%s\": more than %d entries", key, most);
        return NULL;
    }
    *n = (int)length;
    return list;
}

static yaml_node_t *entry(reader *r, yaml_node_t *list, int i)
{
    return yaml_document_get_node(&r->doc, list->data.sequence.items.start[i]);
}

static void take_name(reader *r, yaml_node_t *of, const char *key, char to[LAB_PLACE])
{
    const char *text = text_of(r, of, key);
    if (r->status == STEIN_OK && strlen(text) >= LAB_PLACE) {
        bad(r, of, "\"%s\": expected a name of less than %d letters", key, (int)LAB_PLACE);
    }
    snprintf(to, LAB_PLACE, "%s", text);
}

/* ---- conditions ---- */

typedef enum { CHANNEL, INPUT, SETTING } what;

static const char *unit_of(const stein_model *m, what kind, const char *name)
{
    int i = kind == CHANNEL   ? stein_find_channel(m, name)
            : kind == SETTING ? stein_find_param(m, name)
                              : stein_find_input(m, name);
    return i < 0             ? NULL
           : kind == CHANNEL ? m->channels[i].unit
           : kind == SETTING ? m->params[i].unit
                             : m->inputs[i].unit;
}

static void take_used(reader *r, yaml_node_t *of, const char *key, what kind, lab_used **to, int *n)
{
    static const char *const words[] = {"an output", "an input", "a parameter"};
    yaml_node_t *list = list_of(r, of, key, NUMBERS, n);
    *to = calloc((size_t)*n + 1, sizeof **to);
    if (*to == NULL) {
        no_memory(r);
        *n = 0;
    }
    for (int i = 0; *to != NULL && r->status == STEIN_OK && i < *n; i++) {
        lab_used *u = &(*to)[i];
        yaml_node_t *e = entry(r, list, i);
        take_name(r, e, "name", u->name);
        u->unit = unit_of(r->m, kind, u->name);
        if (u->unit == NULL) {
            bad(r, e, "\"%s\" is not %s of \"%s\": a diagnosis of another mechanism?", u->name,
                words[kind], r->m->name);
        }
        u->lo = number_of(r, e, "lo");
        u->hi = number_of(r, e, "hi");
        u->noise = kind == CHANNEL ? number_of(r, e, "noise") : NAN;
        if (r->status == STEIN_OK && !(u->lo <= u->hi)) {
            bad(r, e, "\"hi\": expected no less than \"lo\"");
        }
        if (r->status == STEIN_OK && kind == CHANNEL && !(u->noise > 0.0)) {
            bad(r, e, "\"noise\": expected more than 0");
        }
    }
}

static void take_conditions(reader *r, yaml_node_t *root, lab_conditions *c)
{
    yaml_node_t *at = field(r, root, "conditions");
    c->from = number_of(r, at, "from");
    c->until = number_of(r, at, "until");
    c->interval = number_of(r, at, "interval");
    c->unsynchronised = truth_of(r, at, "unsynchronised");
    if (r->status == STEIN_OK && !(c->until > c->from && c->until > 0.0)) {
        bad(r, at, "\"until\": expected more than \"from\" and 0");
    }
    if (r->status == STEIN_OK && !(c->interval > 0.0 && c->interval < c->until - c->from)) {
        bad(r, at, "\"interval\": expected more than 0, less than the record");
    }
    take_used(r, at, "channels", CHANNEL, &c->channel, &c->nchannel);
    take_used(r, at, "inputs", INPUT, &c->input, &c->ninput);
    take_used(r, at, "settings", SETTING, &c->setting, &c->nsetting);
    if (r->status == STEIN_OK && c->nchannel == 0) {
        bad(r, at, "\"channels\": expected at least one");
    }
}

/* ---- causes and rivals ---- */

static void take_correlation(reader *r, yaml_node_t *of, int i, lab_posterior *q)
{
    int n = 0;
    yaml_node_t *list = list_of(r, of, "correlation", NUMBERS, &n);
    if (r->status == STEIN_OK && n != i) {
        bad(r, list, "\"correlation\": expected %d numbers, those with the entries before", i);
    }
    q->correlation[i * q->n + i] = 1.0;
    for (int k = 0; r->status == STEIN_OK && k < i; k++) {
        double c = number(r, entry(r, list, k), "correlation", 0);
        if (r->status == STEIN_OK && !(fabs(c) <= 1.0)) {
            bad(r, list, "\"correlation\": expected numbers from -1 to 1");
        }
        q->correlation[i * q->n + k] = q->correlation[k * q->n + i] = c;
    }
}

static void take_posterior(reader *r, yaml_node_t *of, lab_posterior *q)
{
    int n = 0;
    yaml_node_t *list = list_of(r, of, "posterior", NUMBERS, &n);
    q->number = calloc((size_t)n + 1, sizeof *q->number);
    q->correlation = calloc((size_t)n * (size_t)n + 1, sizeof *q->correlation);
    q->n = n;
    if (q->number == NULL || q->correlation == NULL) {
        no_memory(r);
        q->n = 0;
    }
    for (int i = 0; q->number != NULL && r->status == STEIN_OK && i < n; i++) {
        struct lab_uncertain *u = &q->number[i];
        yaml_node_t *e = entry(r, list, i);
        take_name(r, e, "name", u->name);
        u->logarithmic = truth_of(r, e, "logarithmic");
        u->value = number_of(r, e, "value");
        u->sd = number_of(r, e, "sd");
        int place, index;
        if (r->status == STEIN_OK && !diag__find_number(u->name, &place, &index) &&
            stein_find_param(r->m, u->name) < 0) {
            bad(r, e, "\"%s\" is not a parameter of \"%s\": a diagnosis of another mechanism?",
                u->name, r->m->name);
        }
        if (r->status == STEIN_OK && !(u->sd >= 0.0)) {
            bad(r, e, "\"sd\": expected 0 or more");
        }
        if (r->status == STEIN_OK && u->logarithmic && !(u->value > 0.0)) {
            bad(r, e, "\"value\": expected more than 0 where it is logarithmic");
        }
        take_correlation(r, e, i, q);
    }
}

/* the candidate of the mechanism with its kind, place and limit */
static void take_candidate(reader *r, yaml_node_t *e, lab_candidate *to)
{
    const char *kind = text_of(r, e, "kind"), *place = text_of(r, e, "place");
    for (int i = 0; r->status == STEIN_OK && i < r->ncandidate; i++) {
        const lab_candidate *c = &r->candidate[i];
        if (strcmp(c->effect->kind, kind) == 0 && strcmp(c->place, place) == 0) {
            *to = *c;
        }
    }
    int parted = strcmp(kind, "changed_after") == 0 || strcmp(kind, "wrong_setting") == 0;
    if (r->status == STEIN_OK && parted) {
        bad(r, e,
            "%s at \"%.60s\" is of a part of the records: correct or part these first, then "
            "diagnose again",
            kind, place);
    }
    if (r->status == STEIN_OK && to->effect == NULL) {
        bad(r, e, "there is no %.40s at \"%.60s\" in \"%s\": a diagnosis of another mechanism?",
            kind, place, r->m->name);
    }
    if (find(r, e, "limit") != NULL) { // of the records, which may not move as the file's own run
        to->limit = number_of(r, e, "limit");
        if (r->status == STEIN_OK && !(to->limit > 0.0)) {
            bad(r, e, "\"limit\": expected more than 0");
        }
    }
}

/* the candidates beside one, which act in the same fit; an earlier version wrote none */
static void take_beside(reader *r, yaml_node_t *of, lab_posterior *q)
{
    int n = 0;
    yaml_node_t *list =
        find(r, of, "beside") != NULL ? list_of(r, of, "beside", FIT__ACCEPTED - 1, &n) : NULL;
    q->beside = calloc((size_t)n + 1, sizeof *q->beside);
    if (q->beside == NULL) {
        no_memory(r);
        return;
    }
    for (int i = 0; r->status == STEIN_OK && i < n; i++) {
        q->nbeside = i + 1;
        take_candidate(r, entry(r, list, i), &q->beside[i]);
    }
}

static void take_suspect(reader *r, yaml_node_t *e, lab_suspect *s)
{
    *s = (lab_suspect){.score = NAN, .gain = NAN, .held_out = NAN, .chi2_dof = NAN, .refitted = 1};
    take_candidate(r, e, &s->candidate);
    take_posterior(r, e, &s->posterior);
    take_beside(r, e, &s->posterior);
    for (int i = 0; i < s->posterior.n; i++) {
        if (strcmp(s->posterior.number[i].name, "amount") == 0) {
            s->amount = s->posterior.number[i].value;
        }
    }
}

static void take_suspects(reader *r, yaml_node_t *root, lab_diagnosis *d)
{
    yaml_node_t *cause = list_of(r, root, "causes", SUSPECTS, &d->ncause);
    yaml_node_t *rival = list_of(r, root, "indistinguishable", SUSPECTS, &d->nrival);
    d->suspect = calloc((size_t)(d->ncause + d->nrival) + 1, sizeof *d->suspect);
    if (d->suspect == NULL) {
        no_memory(r);
        return;
    }
    for (int i = 0; r->status == STEIN_OK && i < d->ncause + d->nrival; i++) {
        yaml_node_t *e = i < d->ncause ? entry(r, cause, i) : entry(r, rival, i - d->ncause);
        d->nsuspect = i + 1;
        take_suspect(r, e, &d->suspect[i]);
    }
}

static void take_all(reader *r, yaml_node_t *root, lab_diagnosis *d)
{
    static const char *const scatter[] = {"joint_friction", "contact_friction", "drive"};
    const char *verdict = text_of(r, root, "verdict");
    int found = -1;
    for (int v = LAB_VERDICT_EXPLAINED; v <= LAB_VERDICT_NOT_CONVERGED; v++) {
        found = strcmp(verdict, lab_verdict_text((lab_verdict)v)) == 0 ? v : found;
    }
    if (r->status == STEIN_OK && found < 0) {
        bad(r, root, "\"verdict\": \"%.40s\" is none of explained .. not_converged", verdict);
    }
    d->verdict = found < 0 ? LAB_VERDICT_EXPLAINED : (lab_verdict)found;
    yaml_node_t *s = field(r, root, "scatter");
    for (int i = 0; i < 3; i++) {
        d->scatter[i] = number_of(r, s, scatter[i]);
    }
    take_suspects(r, root, d);
    take_conditions(r, root, &d->conditions);
}

/* ---- the file ---- */

static void parse(reader *r, const char *text, size_t size, lab_diagnosis *d)
{
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) {
        no_memory(r);
        return;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    if (!yaml_parser_load(&parser, &r->doc)) {
        r->status = lab__fail(r->err, STEIN_EPARSE, "%s:%d: no JSON: %s", r->path,
                              (int)parser.problem_mark.line + 1,
                              parser.problem != NULL ? parser.problem : "it cannot be read");
        yaml_parser_delete(&parser);
        return;
    }
    yaml_node_t *root = yaml_document_get_root_node(&r->doc);
    if (root == NULL || root->type != YAML_MAPPING_NODE) {
        bad(r, root, "expected a diagnosis.json, an object with \"verdict\", \"causes\" ...");
    }
    take_all(r, root, d);
    yaml_document_delete(&r->doc);
    yaml_parser_delete(&parser);
}

stein_status lab_diagnosis_read(lab_diagnosis **out, const char *path, const lab_model *model,
                                stein_err *err)
{
    reader r = {.path = path, .model = model, .m = lab_equations(model), .err = err};
    char *text = NULL;
    size_t size = 0;
    lab_diagnosis *d = calloc(1, sizeof *d);
    r.status = d != NULL ? lab__read_file(path, &text, &size, err) : lab__no_memory(err);
    if (r.status == STEIN_OK && size > LARGEST) {
        r.status = lab__fail(err, STEIN_EPARSE, "%s: larger than any diagnosis.json", path);
    }
    if (r.status == STEIN_OK) {
        r.status = lab_candidates(&r.candidate, &r.ncandidate, model, err);
    }
    if (r.status == STEIN_OK) {
        parse(&r, text, size, d);
    }
    free(r.candidate);
    free(text);
    if (r.status != STEIN_OK) {
        lab_diagnosis_destroy(d);
        return r.status;
    }
    *out = d;
    return STEIN_OK;
}
