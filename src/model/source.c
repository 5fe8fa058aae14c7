/* SPDX-License-Identifier: MIT
 * source.c - from bytes to a tree of nodes with their places, by libyaml's event interface.
 *
 * Events instead of libyaml's documents: depth, size, anchors and tags are refused before anything
 * is built from them, and the tree is ours, in one arena. A file that is no valid YAML gives one
 * problem; the schema is checked later.
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

#include "reader.h"
#include "sanitizer.h"

typedef struct block {
    struct block *next;
    size_t used, size;
    max_align_t data[];
} block;

enum { BLOCK = 16384 };

void *mech__alloc(mech__reader *rd, size_t size)
{
    block *b = rd->arena;

    size = (size + sizeof(max_align_t) - 1) / sizeof(max_align_t) * sizeof(max_align_t);
    if (rd->nomem) {
        return NULL;
    }
    if (!b || b->size - b->used < size) {
        size_t room = size > BLOCK ? size : BLOCK;

        b = calloc(1, sizeof *b + room);
        if (!b) {
            rd->nomem = 1;
            return NULL;
        }
        b->size = room;
        b->next = rd->arena;
        rd->arena = b;
    }
    void *at = (char *)b->data + b->used;

    b->used += size;
    return at;
}

void mech__arena_free(mech__reader *rd)
{
    for (block *b = rd->arena, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    rd->arena = NULL;
}

char *mech__print(mech__reader *rd, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    int n = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *text = n < 0 ? NULL : mech__alloc(rd, (size_t)n + 1);

    if (text) {
        va_start(args, format);
        vsnprintf(text, (size_t)n + 1, format, args);
        va_end(args);
    }
    return text;
}

/** Where the tree grows: the open lists and mappings, and the key that waits for its value. */
typedef struct builder {
    mech__reader *rd;
    mech__node *open[MECH__MAX_NESTING];
    mech__node *key[MECH__MAX_NESTING];
    int depth;
    mech__node *root;
    int documents;
} builder;

static mech__node *new_node(builder *b, mech__node_kind kind, const yaml_mark_t *mark)
{
    mech__node *n = mech__alloc(b->rd, sizeof *n);

    if (n) {
        n->kind = kind;
        n->text = "";
        n->line = (int)mark->line + 1;
        n->column = (int)mark->column + 1;
    }
    return n;
}

static int fatal(builder *b, const yaml_mark_t *mark, const char *what)
{
    mech__node place = {.line = (int)mark->line + 1, .column = (int)mark->column + 1};

    mech__problem_at(b->rd, &place, "%s", what);
    return -1;
}

/** Keys are scalars and unique. A repeated one is noted and dropped. */
static int append_entry(builder *b, mech__node *parent, mech__node *node)
{
    mech__node *key = b->key[b->depth - 1];

    b->key[b->depth - 1] = NULL;
    for (const mech__node *n = parent->first; n; n = n->next) {
        if (strcmp(n->key->text, key->text) == 0) {
            mech__problem_at(b->rd, key, "the key \"%s\" appears twice, first in line %d",
                             mech__shown(b->rd, key->text), n->key->line);
            return 0;
        }
    }
    node->key = key;
    return 1;
}

/** Hang a node into the innermost open list or mapping. */
static int append(builder *b, mech__node *node, const yaml_mark_t *mark)
{
    if (b->depth == 0) {
        b->root = node;
        return 0;
    }
    mech__node *parent = b->open[b->depth - 1];

    if (parent->kind == MECH__MAP && !b->key[b->depth - 1]) {
        if (node->kind != MECH__SCALAR) {
            return fatal(b, mark, "a key must be a word");
        }
        b->key[b->depth - 1] = node;
        return 0;
    }
    if (parent->kind == MECH__MAP && !append_entry(b, parent, node)) {
        return 0;
    }
    if (parent->count == MECH__MAX_ENTRIES) {
        return fatal(b, mark, "more than 1024 entries in one list or mapping");
    }
    if (parent->last) {
        parent->last->next = node;
    } else {
        parent->first = node;
    }
    parent->last = node;
    parent->count++;
    return 0;
}

static int add_scalar(builder *b, const yaml_event_t *e)
{
    const char *text = (const char *)e->data.scalar.value;
    size_t length = e->data.scalar.length;

    WRITTEN_TEXT(text, length + 1);
    mech__node *n = new_node(b, MECH__SCALAR, &e->start_mark);
    char *copy = mech__alloc(b->rd, length + 1);

    if (!n || !copy) {
        return -1;
    }
    if (strlen(text) != length) {
        return fatal(b, &e->start_mark, "a text must not hold the character NUL");
    }
    memcpy(copy, text, length + 1);
    n->text = copy;
    n->plain =
        e->data.scalar.style == YAML_PLAIN_SCALAR_STYLE && e->start_mark.line == e->end_mark.line;
    return append(b, n, &e->start_mark);
}

static int open_collection(builder *b, const yaml_event_t *e, mech__node_kind kind)
{
    mech__node *n = new_node(b, kind, &e->start_mark);

    if (b->depth == MECH__MAX_NESTING) {
        return fatal(b, &e->start_mark, "lists and mappings are nested more than 16 deep");
    }
    if (!n || append(b, n, &e->start_mark) != 0) {
        return -1;
    }
    b->open[b->depth] = n;
    b->key[b->depth] = NULL;
    b->depth++;
    return 0;
}

static int has_anchor(const yaml_event_t *e)
{
    return e->type == YAML_ALIAS_EVENT || (e->type == YAML_SCALAR_EVENT && e->data.scalar.anchor) ||
           (e->type == YAML_SEQUENCE_START_EVENT && e->data.sequence_start.anchor) ||
           (e->type == YAML_MAPPING_START_EVENT && e->data.mapping_start.anchor);
}

static int has_tag(const yaml_event_t *e)
{
    return (e->type == YAML_SCALAR_EVENT && e->data.scalar.tag) ||
           (e->type == YAML_SEQUENCE_START_EVENT && e->data.sequence_start.tag) ||
           (e->type == YAML_MAPPING_START_EVENT && e->data.mapping_start.tag) ||
           (e->type == YAML_DOCUMENT_START_EVENT && e->data.document_start.tag_directives.start !=
                                                        e->data.document_start.tag_directives.end);
}

/** @return 0 to go on, 1 at the end, -1 after a problem that ends the reading */
static int take(builder *b, const yaml_event_t *e)
{
    if (has_anchor(e)) {
        return fatal(b, &e->start_mark, "anchors and aliases (& and *) are not allowed");
    }
    if (has_tag(e)) {
        return fatal(b, &e->start_mark, "tags (!) are not allowed");
    }
    switch (e->type) {
    case YAML_STREAM_END_EVENT: return 1;
    case YAML_DOCUMENT_START_EVENT:
        b->documents++;
        return b->documents > 1 ? fatal(b, &e->start_mark, "a second document begins, expected one")
                                : 0;
    case YAML_SCALAR_EVENT: return add_scalar(b, e);
    case YAML_SEQUENCE_START_EVENT: return open_collection(b, e, MECH__LIST);
    case YAML_MAPPING_START_EVENT: return open_collection(b, e, MECH__MAP);
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT: b->depth--; return 0;
    default: return 0;
    }
}

/** Invalid bytes come with an offset only. */
static void reader_problem(builder *b, const yaml_parser_t *p, const char *text, size_t size)
{
    yaml_mark_t mark = {0, 0, 0};

    for (size_t i = 0; i < size && i < p->problem_offset; i++) {
        if (text[i] == '\n') {
            mark.line++;
            mark.column = 0;
        } else {
            mark.column += ((unsigned char)text[i] & 0xC0) != 0x80;
        }
    }
    char *what = mech__print(b->rd, "the file is not plain UTF-8 text: %s",
                             p->problem ? p->problem : "invalid byte");

    fatal(b, &mark, what ? what : "");
}

static void parser_problem(builder *b, const yaml_parser_t *p, const char *text, size_t size)
{
    if (p->error == YAML_MEMORY_ERROR) {
        b->rd->nomem = 1;
    } else if (p->error == YAML_READER_ERROR) {
        reader_problem(b, p, text, size);
    } else if (p->problem_mark.index < size && text[p->problem_mark.index] == '\t') {
        fatal(b, &p->problem_mark, "a tab, expected blanks: YAML does not indent with tabs");
    } else {
        char *what = mech__print(b->rd, "not valid YAML: %s%s%s", p->problem ? p->problem : "error",
                                 p->context ? " " : "", p->context ? p->context : "");

        fatal(b, &p->problem_mark, what ? what : "");
    }
}

void mech__tree(mech__reader *rd, const char *text, size_t size)
{
    builder b = {.rd = rd};
    yaml_parser_t parser;
    int go = 0;

    if (!yaml_parser_initialize(&parser)) {
        rd->nomem = 1;
        return;
    }
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) { // a mark that is no column of its line
        text += 3;
        size -= 3;
    }
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    while (go == 0) {
        yaml_event_t event;

        int good = yaml_parser_parse(&parser, &event);

        WRITTEN(parser);
        WRITTEN(event);
        if (!good) {
            parser_problem(&b, &parser, text, size);
            go = -1;
        } else {
            go = take(&b, &event);
            yaml_event_delete(&event);
        }
    }
    yaml_parser_delete(&parser);
    if (go == 1 && (!b.root || b.root->kind != MECH__MAP)) {
        mech__node start = {.line = 1, .column = 1};

        mech__problem_at(rd, b.root ? b.root : &start,
                         "%sexpected a mapping that begins with \"mechanism: NAME\"",
                         b.root ? "" : "the file is empty, ");
        go = -1;
    }
    rd->root = go == 1 ? b.root : NULL;
}
