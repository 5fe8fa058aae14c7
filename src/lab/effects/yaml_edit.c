/* SPDX-License-Identifier: GPL-3.0-or-later
 * yaml_edit.c - entries and words of a YAML file changed in place.
 *
 * libyaml composes the tree and gives the begin and end of every node; only there the text
 * changes. So comments, order, units and line breaks of the rest stay, as in patch.c:
 *
 *      bodies:                               bodies:
 *        # the lever             ->            key_axis: {joint: T z, ...}
 *        key: {joint: R y}                     # the lever
 *                                              key: {parent: key_axis, joint: R y}
 *
 * Writing the tree out again would discard all that. Marks count characters, the text is bytes: one
 * table translates.
 */
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "added_parts.h"

enum { EDITS = 256 };

typedef struct edit {
    size_t from, to;
    char *text;
} edit;

struct lab__yaml_edit {
    const char *text;
    size_t size;
    size_t *byte; /* [characters + 1] */
    size_t nchar;
    yaml_document_t doc;
    int composed;
    edit edit[EDITS];
    int n;
    char *tail; /* sections that are new */
};

/* ---- places ---- */

static int make_table(lab__yaml_edit *s)
{
    size_t at = s->size >= 3 && memcmp(s->text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    s->byte = malloc(sizeof *s->byte * (s->size + 2));
    if (s->byte == NULL) {
        return -1;
    }
    for (; at < s->size; at++) {
        if (((unsigned char)s->text[at] & 0xC0) != 0x80) {
            s->byte[s->nchar++] = at;
        }
    }
    s->byte[s->nchar] = s->size;
    return 0;
}

static size_t byte_of(const lab__yaml_edit *s, yaml_mark_t mark)
{
    return s->byte[mark.index < s->nchar ? mark.index : s->nchar];
}

stein_status lab__yaml_edit_begin(lab__yaml_edit **out, const char *text, size_t size,
                                  stein_err *err)
{
    yaml_parser_t parser;
    lab__yaml_edit *s = calloc(1, sizeof *s);
    if (s == NULL || !yaml_parser_initialize(&parser)) {
        free(s);
        return lab__no_memory(err);
    }
    s->text = text;
    s->size = size;
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    s->composed = yaml_parser_load(&parser, &s->doc);
    int memory = make_table(s) == 0 && parser.error != YAML_MEMORY_ERROR;
    yaml_parser_delete(&parser);
    if (!s->composed || !memory || yaml_document_get_root_node(&s->doc) == NULL) {
        lab__yaml_edit_end(s);
        return memory ? lab__fail(err, STEIN_EPARSE, "the text is no YAML") : lab__no_memory(err);
    }
    *out = s;
    return STEIN_OK;
}

void lab__yaml_edit_end(lab__yaml_edit *s)
{
    if (s == NULL) {
        return;
    }
    for (int i = 0; i < s->n; i++) {
        free(s->edit[i].text);
    }
    if (s->composed) {
        yaml_document_delete(&s->doc);
    }
    free(s->tail);
    free(s->byte);
    free(s);
}

/* the tree is only read; libyaml's functions take it writable */
static yaml_node_t *node_of(const lab__yaml_edit *s, int id)
{
    return yaml_document_get_node((yaml_document_t *)&s->doc, id);
}

static int is_word(const yaml_node_t *node, const char *word, size_t n)
{
    return node->type == YAML_SCALAR_NODE && node->data.scalar.length == n &&
           memcmp(node->data.scalar.value, word, n) == 0;
}

static yaml_node_t *child(const lab__yaml_edit *s, const yaml_node_t *node, const char *word,
                          size_t n)
{
    if (node->type == YAML_SEQUENCE_NODE) {
        long i = strtol(word, NULL, 10);
        yaml_node_item_t *item = node->data.sequence.items.start + i;
        return i >= 0 && item < node->data.sequence.items.top ? node_of(s, *item) : NULL;
    }
    if (node->type != YAML_MAPPING_NODE) {
        return NULL;
    }
    for (yaml_node_pair_t *p = node->data.mapping.pairs.start; p < node->data.mapping.pairs.top;
         p++) {
        if (is_word(node_of(s, p->key), word, n)) {
            return node_of(s, p->value);
        }
    }
    return NULL;
}

static yaml_node_t *find(const lab__yaml_edit *s, const char *path)
{
    yaml_node_t *node = node_of(s, 1);
    while (node != NULL && *path != '\0') {
        size_t n = strcspn(path, "/");
        node = child(s, node, path, n);
        path += n + (path[n] == '/');
    }
    return node;
}

/* ---- changes ---- */

/* @param text  taken over. @return 0, -1 */
static int change(lab__yaml_edit *s, size_t from, size_t to, char *text)
{
    if (text == NULL || s->n == EDITS) {
        free(text);
        return -1;
    }
    int i = s->n++;
    for (; i > 0 && s->edit[i - 1].from > from; i--) { // by place, equals in their order
        s->edit[i] = s->edit[i - 1];
    }
    s->edit[i] = (edit){from, to, text};
    return 0;
}

static int replace(lab__yaml_edit *s, const yaml_node_t *node, const char *text)
{
    return change(s, byte_of(s, node->start_mark), byte_of(s, node->end_mark),
                  lab__text("%s", text));
}

const char *lab__yaml_edit_get(const lab__yaml_edit *s, const char *path)
{
    const yaml_node_t *node = find(s, path);
    return node != NULL && node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value
                                                          : NULL;
}

int lab__yaml_edit_set(lab__yaml_edit *s, const char *path, const char *text)
{
    const yaml_node_t *node = find(s, path);
    return node != NULL && node->type == YAML_SCALAR_NODE ? replace(s, node, text) : -1;
}

static int swap_in(lab__yaml_edit *s, const yaml_node_t *node, const char *old, const char *text)
{
    int n = 0, more;
    if (node->type == YAML_SCALAR_NODE) {
        return !is_word(node, old, strlen(old)) ? 0 : replace(s, node, text) == 0 ? 1 : -1;
    }
    if (node->type == YAML_SEQUENCE_NODE) {
        for (yaml_node_item_t *i = node->data.sequence.items.start;
             n >= 0 && i < node->data.sequence.items.top; i++) {
            more = swap_in(s, node_of(s, *i), old, text);
            n = more < 0 ? -1 : n + more;
        }
        return n;
    }
    for (yaml_node_pair_t *p = node->data.mapping.pairs.start;
         n >= 0 && p < node->data.mapping.pairs.top; p++) {
        if (!is_word(node_of(s, p->key), "about", 5)) {
            more = swap_in(s, node_of(s, p->value), old, text);
            n = more < 0 ? -1 : n + more;
        }
    }
    return n;
}

int lab__yaml_edit_swap(lab__yaml_edit *s, const char *old, const char *text)
{
    return swap_in(s, node_of(s, 1), old, text);
}

/* ---- new entries ---- */

/* "name: value" with its further lines indented */
static char *indented(const char *entry, size_t indent, const char *ending)
{
    size_t room = strlen(entry) + strlen(ending) + 1;
    for (const char *c = entry; *c != '\0'; c++) {
        room += *c == '\n' ? indent + 4 : 0;
    }
    char *text = malloc(room), *to = text;
    for (; text != NULL && *entry != '\0'; entry++) {
        *to++ = *entry;
        if (*entry == '\n') {
            memset(to, ' ', indent + 2);
            to += indent + 2;
        }
    }
    if (text != NULL) {
        memcpy(to, ending, strlen(ending) + 1);
    }
    return text;
}

/* the line on which the comments begin that belong to the line of `at`, not above `least` */
static size_t above_comments(const lab__yaml_edit *s, size_t at, size_t least)
{
    while (at > 0 && s->text[at - 1] != '\n') {
        at--;
    }
    for (size_t line = at; line > 0;) {
        size_t before = line - 1;
        while (before > 0 && s->text[before - 1] != '\n') {
            before--;
        }
        size_t first = before + strspn(s->text + before, " \t");
        if (before <= least || s->text[first] != '#') {
            break;
        }
        line = at = before;
    }
    return at;
}

/* before the first key of a mapping: in its line, or on a separate line above its comments */
static int put_first(lab__yaml_edit *s, const yaml_node_t *map, const char *entry)
{
    const yaml_node_t *key = node_of(s, map->data.mapping.pairs.start->key);
    size_t at = byte_of(s, key->start_mark);
    if (map->data.mapping.style == YAML_FLOW_MAPPING_STYLE) {
        return change(s, at, at, indented(entry, 4, ", "));
    }
    size_t indent = key->start_mark.column, line = above_comments(s, at, 0);
    size_t start = at;
    while (start > 0 && s->text[start - 1] != '\n') {
        start--;
    }
    if (at - start != indent || strspn(s->text + start, " ") < indent) { // "- key: value"
        char *text = indented(entry, indent, "\n");
        char *whole = text != NULL ? lab__text("%s%*s", text, (int)indent, "") : NULL;
        free(text);
        return change(s, at, at, whole);
    }
    char *text = indented(entry, indent, "\n");
    char *whole = text != NULL ? lab__text("%*s%s", (int)indent, "", text) : NULL;
    free(text);
    return change(s, line, line, whole);
}

static stein_status outcome(int failed, const char *where, stein_err *err)
{
    return !failed ? STEIN_OK
                   : lab__fail(err, STEIN_EINVAL, "nothing can be added to \"%s\"", where);
}

stein_status lab__yaml_edit_add_key(lab__yaml_edit *s, const char *path, const char *entry,
                                    stein_err *err)
{
    const yaml_node_t *map = find(s, path);
    int there = map != NULL && map->type == YAML_MAPPING_NODE &&
                map->data.mapping.pairs.top > map->data.mapping.pairs.start;
    return outcome(!there || put_first(s, map, entry) != 0, path, err);
}

/* a section that is new goes behind all others, entries with the same one together */
static int put_section(lab__yaml_edit *s, const char *section, const char *entry)
{
    char *text = indented(entry, 2, "\n");
    char *head = lab__text("\n%s:\n", section);
    char *there = s->tail != NULL && head != NULL ? strstr(s->tail, head) : NULL;
    char *whole = NULL;
    if (text != NULL && there != NULL) {
        size_t cut = (size_t)(there - s->tail) + strlen(head);
        whole = lab__text("%.*s  %s%s", (int)cut, s->tail, text, s->tail + cut);
    } else if (text != NULL && head != NULL) {
        whole = lab__text("%s%s  %s", s->tail != NULL ? s->tail : "", head, text);
    }
    free(text);
    free(head);
    if (whole == NULL) {
        return -1;
    }
    free(s->tail);
    s->tail = whole;
    return 0;
}

stein_status lab__yaml_edit_add(lab__yaml_edit *s, const char *section, const char *entry,
                                stein_err *err)
{
    const yaml_node_t *root = node_of(s, 1);
    if (find(s, section) != NULL) {
        return lab__yaml_edit_add_key(s, section, entry, err);
    }
    if (root->type == YAML_MAPPING_NODE && root->data.mapping.style != YAML_FLOW_MAPPING_STYLE) {
        return outcome(put_section(s, section, entry) != 0, section, err);
    }
    char *whole = lab__text("%s: {%s}", section, entry);
    stein_status status =
        whole == NULL ? lab__no_memory(err) : lab__yaml_edit_add_key(s, "", whole, err);
    free(whole);
    return status;
}

stein_status lab__yaml_edit_text(const lab__yaml_edit *s, char **text, size_t *size, stein_err *err)
{
    char *out = NULL;
    size_t at = 0, end = byte_of(s, node_of(s, 1)->end_mark);
    FILE *f = lab__text_open(&out);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < s->n; i++) {
        fwrite(s->text + at, 1, s->edit[i].from - at, f);
        fputs(s->edit[i].text, f);
        at = s->edit[i].to;
    }
    end = end < at ? at : end;
    fwrite(s->text + at, 1, end - at, f);
    if (s->tail != NULL) {
        fputs(end > 0 && s->text[end - 1] == '\n' ? "" : "\n", f);
        fputs(s->tail, f);
    }
    fwrite(s->text + end, 1, s->size - end, f);
    if (lab__text_close(f, &out, err) != STEIN_OK) {
        return STEIN_ENOMEM;
    }
    *text = out;
    *size = strlen(out);
    return STEIN_OK;
}
