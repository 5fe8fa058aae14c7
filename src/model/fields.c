/* SPDX-License-Identifier: MIT
 * fields.c - access to the mappings of the source tree: known keys, required keys, words.
 */
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static int is_empty(const mech__node *node)
{
    return node->kind == MECH__SCALAR && node->plain && node->text[0] == '\0';
}

const mech__node *mech__get(const mech__node *map, const char *key)
{
    if (!map || map->kind != MECH__MAP) {
        return NULL;
    }
    for (const mech__node *n = map->first; n; n = n->next) {
        if (strcmp(n->key->text, key) == 0) {
            return is_empty(n) ? NULL : n;
        }
    }
    return NULL;
}

const mech__node *mech__need(mech__reader *rd, const mech__node *map, const char *key,
                             const char *what)
{
    const mech__node *n = mech__get(map, key);

    if (!n && map && map->kind == MECH__MAP) {
        mech__problem_at(rd, map->key ? map->key : map, "%s lacks \"%s\"", what, key);
    }
    return n;
}

/** Next word of a list separated by blanks, as a copy in the arena; NULL at the end. */
static const char *next_word(mech__reader *rd, const char **list)
{
    const char *from = *list + strspn(*list, " ");
    size_t n = strcspn(from, " ");
    char *word = n ? mech__alloc(rd, n + 1) : NULL;

    if (word) {
        memcpy(word, from, n);
    }
    *list = from + n;
    return word;
}

/* "damping:" without a number is no damping; a section without entries is no problem */
static void warn_empty(mech__reader *rd, const mech__node *entry, const char *what)
{
    const char *key = entry->key->text;
    int is_section = strcmp(what, "the file") == 0 || strcmp(key, "points") == 0;

    if (is_empty(entry) && !is_section) {
        mech__warn_at(rd, entry->key, "warning: \"%s\" in %s has no value and is left out",
                      mech__shown(rd, key), what);
    }
}

static void check_key(mech__reader *rd, const mech__node *entry, const char *what, const char *keys)
{
    mech__nearest near = {entry->key->text, NULL, 0};
    const char *list = keys, *word;

    if (strcmp(entry->key->text, "about") == 0) {
        mech__text(rd, entry, "about");
        return;
    }
    while ((word = next_word(rd, &list))) {
        if (strcmp(word, entry->key->text) == 0) {
            warn_empty(rd, entry, what);
            return;
        }
        mech__offer(&near, word);
    }
    mech__problem_at(rd, entry->key, "unknown key \"%s\" in %s%s",
                     mech__shown(rd, entry->key->text), what,
                     mech__hint(rd, &near, mech__print(rd, ", expected one of %s", keys)));
}

int mech__keys(mech__reader *rd, const mech__node *node, const char *what, const char *keys)
{
    if (!node) {
        return 0;
    }
    if (node->kind != MECH__MAP) {
        mech__problem_at(rd, node, "%s must be a mapping with the keys %s", what, keys);
        return 0;
    }
    for (const mech__node *n = node->first; n && !rd->nomem; n = n->next) {
        check_key(rd, n, what, keys);
    }
    return !rd->nomem;
}

int mech__section(mech__reader *rd, const mech__node *node, const char *what, int max)
{
    if (!node) {
        return 0;
    }
    if (node->kind != MECH__MAP) {
        mech__problem_at(rd, node, "expected a mapping from names to %s", what);
        return 0;
    }
    if (node->count > max) {
        mech__problem_at(rd, node->key, "%d entries, expected at most %d", node->count, max);
        return 0;
    }
    for (const mech__node *n = node->first; n; n = n->next) {
        mech__name_check(rd, n->key, what);
    }
    return node->count;
}

const char *mech__text(mech__reader *rd, const mech__node *node, const char *what)
{
    if (node->kind == MECH__SCALAR) {
        return node->text;
    }
    mech__problem_at(rd, node, "expected a single text for \"%s\", found a %s", what,
                     node->kind == MECH__LIST ? "list" : "mapping");
    return NULL;
}

int mech__choice(mech__reader *rd, const mech__node *node, const char *what, const char *words)
{
    const char *text = mech__text(rd, node, what);
    const char *list = words, *word;

    if (!text) {
        return -1;
    }
    mech__nearest near = {text, NULL, 0};

    for (int i = 0; (word = next_word(rd, &list)); i++) {
        if (strcmp(word, text) == 0) {
            return i;
        }
        mech__offer(&near, word);
    }
    mech__problem_at(rd, node, "\"%s\" is no %s, expected one of %s%s", mech__shown(rd, text), what,
                     words, mech__hint(rd, &near, ""));
    return -1;
}

void *mech__array(mech__reader *rd, int n, size_t size)
{
    void *array = rd->nomem ? NULL : calloc(n > 0 ? (size_t)n : 1, size);

    if (!array) {
        rd->nomem = 1;
    }
    return array;
}
