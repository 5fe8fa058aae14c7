/* SPDX-License-Identifier: GPL-3.0-or-later
 * tree.c - reads JSON (RFC 8259) into a tree. \u escapes are kept in their written form: nothing
 * that is compared has any.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

enum { DEEPEST = 60, LARGEST = 100000000 };

static tree *value(const char **at, int depth);

static void blanks(const char **at)
{
    *at += strspn(*at, " \t\r\n");
}

/* a quoted text, NULL when it is none */
static char *quoted(const char **at)
{
    const char *c = *at;
    if (*c++ != '"') {
        return NULL;
    }
    size_t n = 0;
    while (c[n] != '"' && c[n] != '\0') {
        n += c[n] == '\\' && c[n + 1] != '\0' ? 2 : 1;
    }
    char *text = c[n] == '"' ? malloc(n + 1) : NULL, *to = text;
    for (const char *from = c; text != NULL && from < c + n;) {
        from += *from == '\\' && (from[1] == '"' || from[1] == '\\' || from[1] == '/');
        *to++ = *from++;
    }
    if (text != NULL) {
        *to = '\0';
        *at = c + n + 1;
    }
    return text;
}

static tree *fresh(char type)
{
    tree *t = calloc(1, sizeof *t);
    if (t != NULL) {
        t->type = type;
        t->number = NAN;
    }
    return t;
}

/* the members of an object or list. @return 1 when it ends as it should */
static int members(tree *t, const char **at, int depth)
{
    char end = t->type == '{' ? '}' : ']';
    tree **last = &t->child;
    blanks(at);
    while (**at != end) {
        char *key = NULL;
        if (t->type == '{') {
            key = quoted(at);
            blanks(at);
            if (key == NULL || *(*at)++ != ':') {
                free(key);
                return 0;
            }
        }
        *last = value(at, depth + 1);
        if (*last == NULL) {
            free(key);
            return 0;
        }
        (*last)->key = key;
        last = &(*last)->next;
        blanks(at);
        if (**at == ',') {
            ++*at;
            blanks(at);
        } else if (**at != end) {
            return 0;
        }
    }
    ++*at;
    return 1;
}

static int word(const char **at, const char *expected)
{
    size_t n = strlen(expected);
    int is = strncmp(*at, expected, n) == 0;
    *at += is ? n : 0;
    return is;
}

static tree *value(const char **at, int depth)
{
    blanks(at);
    char c = **at;
    if (c == '{' || c == '[') {
        tree *t = depth < DEEPEST ? fresh(c) : NULL;
        ++*at;
        if (t != NULL && !members(t, at, depth)) {
            tree_free(t);
            t = NULL;
        }
        return t;
    }
    if (c == '"') {
        tree *t = fresh('s');
        if (t != NULL && (t->text = quoted(at)) == NULL) {
            tree_free(t);
            t = NULL;
        }
        return t;
    }
    if (c == 't' || c == 'f' || c == 'n') {
        return word(at, "true")    ? fresh('t')
               : word(at, "false") ? fresh('f')
               : word(at, "null")  ? fresh('0')
                                   : NULL;
    }
    char *end;
    double number = strtod(*at, &end);
    tree *t = end != *at ? fresh('n') : NULL;
    if (t != NULL) {
        t->number = number;
        *at = end;
    }
    return t;
}

/* the text of a file, NULL: it cannot be read */
static char *text_of(const char *path)
{
    FILE *f = fopen(path, "rb");
    long size = f != NULL && fseek(f, 0, SEEK_END) == 0 ? ftell(f) : -1;
    char *text = size >= 0 && size < LARGEST ? calloc(1, (size_t)size + 1) : NULL;
    if (text != NULL) {
        rewind(f);
        if (fread(text, 1, (size_t)size, f) != (size_t)size) {
            free(text);
            text = NULL;
        }
    }
    if (f != NULL) {
        fclose(f);
    }
    return text;
}

tree *tree_read(const char *path)
{
    char *text = text_of(path);
    const char *at = text;
    tree *t = text != NULL ? value(&at, 0) : NULL;
    if (t != NULL) {
        blanks(&at);
    }
    if (t != NULL && *at != '\0') {
        tree_free(t);
        t = NULL;
    }
    free(text);
    return t;
}

tree *tree_lines(const char *path)
{
    char *text = text_of(path);
    const char *at = text;
    tree *list = text != NULL ? fresh('[') : NULL, **last = list != NULL ? &list->child : NULL;
    for (int ok = list != NULL; ok && (blanks(&at), *at != '\0');) {
        *last = value(&at, 0);
        ok = *last != NULL;
        last = ok ? &(*last)->next : last;
        if (!ok) {
            tree_free(list);
            list = NULL;
        }
    }
    free(text);
    return list;
}

void tree_free(tree *t)
{
    while (t != NULL) {
        tree *next = t->next;
        tree_free(t->child);
        free(t->key);
        free(t->text);
        free(t);
        t = next;
    }
}

const tree *tree_get(const tree *t, const char *key)
{
    for (const tree *c = t != NULL ? t->child : NULL; c != NULL; c = c->next) {
        if (c->key != NULL && strcmp(c->key, key) == 0) {
            return c;
        }
    }
    return NULL;
}

const char *tree_text(const tree *t, const char *key)
{
    const tree *c = tree_get(t, key);
    return c != NULL && c->text != NULL ? c->text : "";
}

double tree_number(const tree *t, const char *key)
{
    const tree *c = tree_get(t, key);
    return c != NULL ? c->number : NAN;
}
