/* SPDX-License-Identifier: GPL-3.0-or-later
 * description.c - modelDescription.xml as an importer reads it, by expat.
 */
#include <expat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importer.h"

static const char *attribute(const char **list, const char *name)
{
    for (int i = 0; list[i] != NULL; i += 2) {
        if (strcmp(list[i], name) == 0) {
            return list[i + 1];
        }
    }
    return NULL;
}

static void put(char *to, size_t size, const char *text)
{
    snprintf(to, size, "%s", text != NULL ? text : "");
}

static void begin_variable(description *d, const char **list)
{
    variable *more = realloc(d->v, sizeof *more * ((size_t)d->n + 1));
    if (more == NULL) {
        abort();
    }
    d->v = more;
    variable *v = &d->v[d->n++];
    memset(v, 0, sizeof *v);
    put(v->name, sizeof v->name, attribute(list, "name"));
    put(v->causality, sizeof v->causality, attribute(list, "causality"));
    put(v->variability, sizeof v->variability, attribute(list, "variability"));
    v->reference = (unsigned)strtoul(attribute(list, "valueReference"), NULL, 10);
}

/* in FMI 2 a separate element */
static void take_type(description *d, const char *element, const char **list)
{
    variable *v = &d->v[d->n - 1];
    const char *start = attribute(list, "start");
    v->boolean = strcmp(element, "Boolean") == 0;
    v->has_start = start != NULL;
    if (start != NULL) {
        v->start = v->boolean ? strcmp(start, "true") == 0 : strtod(start, NULL);
    }
}

static void on_element(void *ctx, const char *element, const char **list)
{
    description *d = ctx;
    if (strcmp(element, "fmiModelDescription") == 0) {
        const char *token = attribute(list, "instantiationToken");
        put(d->token, sizeof d->token, token != NULL ? token : attribute(list, "guid"));
    } else if (strcmp(element, "CoSimulation") == 0) {
        put(d->identifier, sizeof d->identifier, attribute(list, "modelIdentifier"));
    } else if (strcmp(element, "ScalarVariable") == 0) {
        begin_variable(d, list);
    } else if (strcmp(element, "Float64") == 0 ||
               (strcmp(element, "Boolean") == 0 && attribute(list, "name") != NULL)) {
        begin_variable(d, list);
        take_type(d, element, list);
    } else if (strcmp(element, "Real") == 0 || strcmp(element, "Boolean") == 0) {
        take_type(d, element, list);
    }
}

int description_read(description *d, const char *file)
{
    char bytes[4096];
    FILE *f = fopen(file, "r");
    XML_Parser parser = XML_ParserCreate(NULL);
    memset(d, 0, sizeof *d);
    int good = f != NULL && parser != NULL;
    if (good) {
        XML_SetUserData(parser, d);
        XML_SetElementHandler(parser, on_element, NULL);
    }
    for (int end = 0; good && !end;) {
        size_t n = fread(bytes, 1, sizeof bytes, f);
        end = n < sizeof bytes;
        good = XML_Parse(parser, bytes, (int)n, end) == XML_STATUS_OK;
    }
    if (f != NULL) {
        fclose(f);
    }
    XML_ParserFree(parser);
    if (!good) {
        printf("%s cannot be read\n", file);
    }
    return good;
}

const variable *description_find(const description *d, const char *name)
{
    for (int i = 0; i < d->n; i++) {
        if (strcmp(d->v[i].name, name) == 0) {
            return &d->v[i];
        }
    }
    return NULL;
}
