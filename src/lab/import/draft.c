/* SPDX-License-Identifier: GPL-3.0-or-later
 * draft.c - the parts of an imported mechanism, their names, and notes of omissions.
 */
#include "draft.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void draft_note(draft *d, const char *format, ...)
{
    char text[300];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    char **more = realloc(d->note, ((size_t)d->nnote + 1) * sizeof *more);
    char *copy = lab__text("%s", lab__one_line(text)); // a name may hold anything
    d->note = more != NULL ? more : d->note;
    if (more == NULL || copy == NULL) {
        free(copy);
        d->status = lab__no_memory(d->err);
        return;
    }
    d->note[d->nnote++] = copy;
    if (d->report != NULL) {
        d->report(d->ctx, copy);
    }
}

stein_status draft_wrong(draft *d, const xml_node *at, const char *format, ...)
{
    char text[200];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    if (d->status == STEIN_OK) {
        d->status =
            lab__fail(d->err, STEIN_EPARSE, "%s:%d:%d: %s", d->file, at->line, at->column, text);
    }
    return d->status;
}

void draft_note_others(draft *d, const xml_node *node, const char *known, const char *where)
{
    for (const xml_node *n = node != NULL ? node->first : NULL; n != NULL; n = n->next) {
        char spaced[64];
        int attribute = n->name[0] == '@';
        snprintf(spaced, sizeof spaced, " %.60s ", n->name);
        if (strstr(known, spaced) != NULL || (attribute && strchr(known, '@') == NULL)) {
            continue;
        }
        draft_note(d,
                   attribute ? "attribute %.60s of %.60s (line %d)" : "<%.60s> of %.60s (line %d)",
                   n->name + attribute, where, n->line);
    }
}

/* ---- names ---- */

static int is_word_of_c(const char *name)
{
    static const char words[] = " auto break case char const continue default do double else enum "
                                "extern float for goto if inline int long register restrict return "
                                "short signed sizeof static struct switch typedef union unsigned "
                                "void volatile while frame load ";
    char spaced[MECH_NAME + 2];
    snprintf(spaced, sizeof spaced, " %s ", name);
    return strstr(words, spaced) != NULL;
}

/* a name that a mechanism file takes; room for a suffix is left */
static void clean(char name[MECH_NAME], const char *label)
{
    int n = 0;
    if (!((label[0] | 32) >= 'a' && (label[0] | 32) <= 'z')) {
        name[n++] = 'n';
    }
    for (; *label != '\0' && n < MECH_NAME - 5; label++) {
        int fine = ((*label | 32) >= 'a' && (*label | 32) <= 'z') ||
                   (*label >= '0' && *label <= '9') || *label == '_';
        name[n++] = '_';
        if (fine) {
            name[n - 1] = *label;
        }
    }
    name[n] = '\0';
    if (is_word_of_c(name)) {
        name[n] = '_';
        name[n + 1] = '\0';
    }
}

/* is this the name of one of n parts of `size` bytes, whose first member it is? */
static int among(const void *parts, int n, size_t size, const char *name)
{
    for (int i = 0; i < n; i++) {
        if (strcmp((const char *)parts + (size_t)i * size, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static int taken(const draft *d, const char *name, draft_names names, int owner)
{
    if (names == DRAFT_POINT) {
        for (int i = 0; i < d->npoint; i++) {
            if (d->point[i].body == owner && strcmp(d->point[i].name, name) == 0) {
                return 1;
            }
        }
        return 0;
    }
    if (names == DRAFT_OUTPUT) {
        return among(d->output, d->noutput, sizeof *d->output, name) || strcmp(name, "time") == 0;
    }
    return among(d->body, d->nbody, sizeof *d->body, name) ||
           among(d->loop, d->nloop, sizeof *d->loop, name) ||
           among(d->coupling, d->ncoupling, sizeof *d->coupling, name) ||
           among(d->input, d->ninput, sizeof *d->input, name);
}

void draft_name(draft *d, char name[MECH_NAME], const char *label, const char *what,
                draft_names names, int owner)
{
    char base[MECH_NAME], found[MECH_NAME];
    name[0] = '\0'; // of a part that is in the list already
    clean(base, label);
    snprintf(found, sizeof found, "%s", base);
    for (int i = 2; taken(d, found, names, owner); i++) {
        snprintf(found, sizeof found, "%.27s_%d", base, i % 10000);
    }
    snprintf(name, MECH_NAME, "%s", found);
    if (what != NULL && strcmp(name, label) != 0) {
        draft_note(d, "%s \"%.60s\" is called %s here", what, label, name);
    }
}

/* ---- parts ---- */

static int room(draft *d, const xml_node *at, int n, int most, const char *what)
{
    if (n == most) {
        draft_wrong(d, at, "more than %d %s, which is the most that a mechanism file takes", most,
                    what);
    }
    return n < most;
}

draft_body *draft_add_body(draft *d, const xml_node *at)
{
    if (!room(d, at, d->nbody, MECH_BODIES, "bodies and joints")) {
        return NULL;
    }
    draft_body *b = &d->body[d->nbody++];
    *b = (draft_body){.parent = -1, .anchor = -1, .sign = 1};
    return b;
}

draft_point *draft_add_point(draft *d, const xml_node *at, int body, const char *label)
{
    if (!room(d, at, d->npoint, DRAFT_POINTS, "points")) {
        return NULL;
    }
    draft_point *p = &d->point[d->npoint];
    *p = (draft_point){.label = label, .body = body};
    draft_name(d, p->name, label, "point", DRAFT_POINT, body);
    d->npoint++;
    return p;
}

draft_loop *draft_add_loop(draft *d, const xml_node *at, const char *label)
{
    if (!room(d, at, d->nloop, DRAFT_THINGS, "loops and links")) {
        return NULL;
    }
    draft_loop *l = &d->loop[d->nloop];
    *l = (draft_loop){.kind = DRAFT_MEET};
    draft_name(d, l->name, label, "cut or link", DRAFT_PART, 0);
    d->nloop++;
    return l;
}

draft_coupling *draft_add_coupling(draft *d, const xml_node *at, const char *label)
{
    if (!room(d, at, d->ncoupling, DRAFT_THINGS, "couplings")) {
        return NULL;
    }
    draft_coupling *c = &d->coupling[d->ncoupling];
    *c = (draft_coupling){.ratio = 1.0};
    draft_name(d, c->name, label, NULL, DRAFT_PART, 0);
    d->ncoupling++;
    return c;
}

int draft_point_at(draft *d, const xml_node *at, int body, const double x[3], const char *label)
{
    for (int i = 0; i < d->npoint; i++) {
        const draft_point *p = &d->point[i];
        if (p->body == body && p->x[0] == x[0] && p->x[1] == x[1] && p->x[2] == x[2]) {
            return i;
        }
    }
    draft_point *p = draft_add_point(d, at, body, label);
    if (p == NULL) {
        return -1;
    }
    memcpy(p->x, x, sizeof p->x);
    return d->npoint - 1;
}

void draft_add_input(draft *d, const char *label, draft_drive kind, int index, int axis)
{
    if (d->ninput == DRAFT_THINGS) {
        draft_note(d, "input \"%.60s\": a mechanism file has at most %d", label, DRAFT_THINGS);
        return;
    }
    draft_input *in = &d->input[d->ninput];
    *in = (draft_input){.kind = kind, .index = index, .axis = axis};
    draft_name(d, in->name, label, NULL, DRAFT_PART, 0);
    d->ninput++;
}

void draft_add_output(draft *d, const char *label, int body, int point, int axis)
{
    if (d->noutput == DRAFT_THINGS) {
        draft_note(d, "output \"%.60s\": a mechanism file has at most %d", label, DRAFT_THINGS);
        return;
    }
    draft_output *out = &d->output[d->noutput];
    *out = (draft_output){.body = body, .point = point, .axis = axis};
    draft_name(d, out->name, label, NULL, DRAFT_OUTPUT, 0);
    d->noutput++;
}

/* ---- texts ---- */

const char *draft_need(draft *d, const xml_node *node, const char *child)
{
    const xml_node *n = xml_child(node, child);
    if (n == NULL || n->text[0] == '\0') {
        if (child[0] == '@') {
            draft_wrong(d, node, "<%s> without %s=\"...\", expected one", node->name, child + 1);
        } else {
            draft_wrong(d, n != NULL ? n : node, "<%s> without a <%s>, expected one", node->name,
                        child);
        }
        return "";
    }
    return n->text;
}

double draft_number(draft *d, const xml_node *at, const char *text)
{
    double value = 0.0;
    stein_err why;
    if (mech_parse_quantity(text, (mech_dim){0}, &value, &why) != STEIN_OK) {
        int attribute = at->name[0] == '@';
        draft_wrong(d, at,
                    attribute ? "%s is \"%.40s\", expected a number"
                              : "<%s> is \"%.40s\", expected a number",
                    at->name + attribute, text);
    }
    return value;
}

int draft_numbers(draft *d, const xml_node *at, double *x, int most)
{
    const char *text = at->text;
    int n = 0;
    for (text += strspn(text, " \t\r\n"); *text != '\0'; text += strspn(text, " \t\r\n")) {
        char word[64];
        size_t length = strcspn(text, " \t\r\n");
        snprintf(word, sizeof word, "%.*s", (int)length, text);
        double value = draft_number(d, at, word);
        if (n < most) {
            x[n] = value;
        }
        n++;
        text += length;
    }
    return n;
}
