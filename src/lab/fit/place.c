/* SPDX-License-Identifier: GPL-3.0-or-later
 * place.c - where in a mechanism file a number goes that is not there yet.
 *
 * Every law has every term, neutral until stated. So a fit may find a number - the preload of a
 * joint - for which the file has no line. It goes before the first key of its owner's mapping, in
 * the form that the mapping has:
 *
 *      slide:                               slide:
 *        joint: T x                 ->        preload: -3.16 N +- 0.03 N
 *                                             joint: T x
 *
 *      {joint: T x, mass: 95 kg}    ->      {preload: -3.16 N +- 0.03 N, joint: T x, mass: 95 kg}
 *
 * libyaml's parser knows where mappings begin; looking for keys by their indentation would have to
 * know YAML again.
 */
#include <string.h>

#include <yaml.h>

#include "fitting.h"

enum { DEPTH = 24, KEY = 80 };

typedef struct level {
    int is_map, wants_key, matched; /* matched: the path up to here is the one looked for */
    char key[KEY];
} level;

typedef struct walk {
    const char *const *path;
    int n, depth;
    level at[DEPTH];
    int inside; /* the mapping has begun, its first key comes next */
    fit__place *place;
    int found;
} walk;

/* is what begins now the value of the next name of the path? */
static int leads_on(const walk *w)
{
    const level *l = &w->at[w->depth - 1];
    return w->depth >= 1 && w->depth <= w->n && l->is_map && l->matched &&
           strcmp(l->key, w->path[w->depth - 1]) == 0;
}

static void value_done(walk *w)
{
    if (w->depth > 0 && w->at[w->depth - 1].is_map) {
        w->at[w->depth - 1].wants_key = 1;
    }
}

static void on_scalar(walk *w, const yaml_event_t *e)
{
    level *l = w->depth > 0 ? &w->at[w->depth - 1] : NULL;
    if (w->inside) {
        w->inside = 0;
        w->found = 1;
        w->place->line = (int)e->start_mark.line + 1;
        w->place->column = (int)e->start_mark.column + 1;
    }
    if (l != NULL && l->is_map && l->wants_key) {
        snprintf(l->key, KEY, "%s", (const char *)e->data.scalar.value);
        l->wants_key = 0;
    } else {
        value_done(w);
    }
}

static int on_begin(walk *w, const yaml_event_t *e, int is_map)
{
    int matched = w->depth == 0 || leads_on(w);
    if (w->depth == DEPTH) {
        return -1;
    }
    w->at[w->depth++] = (level){.is_map = is_map, .wants_key = is_map, .matched = matched};
    if (is_map && matched && w->depth == w->n + 1 && !w->found) {
        w->inside = 1;
        w->place->flow = e->data.mapping_start.style == YAML_FLOW_MAPPING_STYLE;
    }
    return 0;
}

/* @return 0, or 1 at the end or when the text is no YAML */
static int take(walk *w, const yaml_event_t *e)
{
    switch (e->type) {
    case YAML_SCALAR_EVENT: on_scalar(w, e); return w->found;
    case YAML_MAPPING_START_EVENT: return on_begin(w, e, 1) != 0;
    case YAML_SEQUENCE_START_EVENT: return on_begin(w, e, 0) != 0;
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        w->inside = 0;
        w->depth--;
        value_done(w);
        return 0;
    default: return e->type == YAML_STREAM_END_EVENT;
    }
}

int fit__find_mapping(const char *text, size_t size, const char *const *path, int n,
                      fit__place *place)
{
    walk w = {.path = path, .n = n, .place = place};
    yaml_parser_t parser;
    yaml_event_t event;
    place->no_memory = !yaml_parser_initialize(&parser);
    if (place->no_memory) {
        return 0;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    for (int over = 0; !over && yaml_parser_parse(&parser, &event);) {
        over = take(&w, &event);
        yaml_event_delete(&event);
    }
    place->no_memory = parser.error == YAML_MEMORY_ERROR;
    yaml_parser_delete(&parser);
    return w.found;
}
