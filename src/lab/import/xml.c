/* SPDX-License-Identifier: GPL-3.0-or-later
 * xml.c - an XML file as a tree of elements.
 *
 * Expat does the reading. A document type is refused: none is needed here, and entities are how
 * a small file becomes a large one.
 */
#include "xml.h"

#include <expat.h>
#include <stdlib.h>
#include <string.h>

#include "io.h"

enum { MOST_BYTES = 8 << 20, MOST_LEVELS = 32 };

typedef struct reading {
    XML_Parser parser;
    const char *file;
    xml_node *root, *at;
    int depth;
    stein_status status;
    stein_err *err;
} reading;

static void stop(reading *r, stein_status status, const char *what)
{
    if (r->status == STEIN_OK) {
        r->status = lab__fail(r->err, status, "%s:%lu:%lu: %s", r->file,
                              (unsigned long)XML_GetCurrentLineNumber(r->parser),
                              (unsigned long)XML_GetCurrentColumnNumber(r->parser) + 1, what);
    }
    XML_StopParser(r->parser, XML_FALSE);
}

static xml_node *add(reading *r, const char *name, const char *text, const char *prefix)
{
    xml_node *n = calloc(1, sizeof *n);
    if (n == NULL) {
        return NULL;
    }
    n->name = lab__text("%s%s", prefix, name);
    n->text = lab__text("%s", text);
    n->line = (int)XML_GetCurrentLineNumber(r->parser);
    n->column = (int)XML_GetCurrentColumnNumber(r->parser) + 1;
    n->parent = r->at;
    if (r->at == NULL) {
        r->root = n;
    } else if (r->at->first == NULL) {
        r->at->first = r->at->last = n;
    } else {
        r->at->last->next = n;
        r->at->last = n;
    }
    return n->name != NULL && n->text != NULL ? n : NULL; // in the tree, so it will be freed
}

static void XMLCALL on_start(void *ctx, const XML_Char *name, const XML_Char **attributes)
{
    reading *r = ctx;
    if (++r->depth > MOST_LEVELS) {
        stop(r, STEIN_EPARSE, "more than 32 elements inside each other");
        return;
    }
    xml_node *n = add(r, name, "", "");
    r->at = n;
    for (int i = 0; n != NULL && attributes[i] != NULL; i += 2) {
        n = add(r, attributes[i], attributes[i + 1], "@") != NULL ? n : NULL;
    }
    if (n == NULL) {
        stop(r, STEIN_ENOMEM, "out of memory");
    }
}

static void XMLCALL on_end(void *ctx, const XML_Char *name)
{
    reading *r = ctx;
    (void)name;
    if (r->status != STEIN_OK) {
        return; // a parser that is stopped where <a/> begins reports its end all the same
    }
    char *text = r->at->text;
    size_t begin = strspn(text, " \t\r\n"), end = strlen(text);
    while (end > begin && strchr(" \t\r\n", text[end - 1]) != NULL) {
        end--;
    }
    memmove(text, text + begin, end - begin);
    text[end - begin] = '\0';
    r->at = r->at->parent;
    r->depth--;
}

static void XMLCALL on_text(void *ctx, const XML_Char *text, int length)
{
    reading *r = ctx;
    char *longer = lab__text("%s%.*s", r->at->text, length, text);
    if (longer == NULL) {
        stop(r, STEIN_ENOMEM, "out of memory");
        return;
    }
    free(r->at->text);
    r->at->text = longer;
}

static void XMLCALL on_doctype(void *ctx, const XML_Char *name, const XML_Char *system,
                               const XML_Char *public, int internal)
{
    (void)name;
    (void)system;
    (void)public;
    (void)internal;
    stop(ctx, STEIN_EPARSE, "a document type, expected none");
}

static stein_status parse(reading *r, const char *text, size_t size)
{
    XML_SetUserData(r->parser, r);
    XML_SetElementHandler(r->parser, on_start, on_end);
    XML_SetCharacterDataHandler(r->parser, on_text);
    XML_SetStartDoctypeDeclHandler(r->parser, on_doctype);
    if (XML_Parse(r->parser, text, (int)size, 1) == XML_STATUS_ERROR) {
        stop(r, STEIN_EPARSE,
             r->root == NULL ? "this is no XML file, expected a ROBOTRAN project, URDF or MJCF"
                             : XML_ErrorString(XML_GetErrorCode(r->parser)));
    }
    return r->status;
}

stein_status xml_read(xml_node **root, const char *file, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = lab__read_file(file, &text, &size, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (size > MOST_BYTES) {
        free(text);
        return lab__fail(err, STEIN_EPARSE, "%s: more than 8 MiB", file);
    }
    reading r = {.parser = XML_ParserCreate(NULL), .file = file, .err = err};
    status = r.parser != NULL ? parse(&r, text, size)
                              : lab__fail(err, STEIN_ENOMEM, "out of memory for %s", file);
    if (r.parser != NULL) {
        XML_ParserFree(r.parser);
    }
    free(text);
    if (status != STEIN_OK) {
        xml_free(r.root);
        return status;
    }
    *root = r.root;
    return STEIN_OK;
}

void xml_free(xml_node *node)
{
    while (node != NULL) { // depth is limited, siblings are not
        xml_node *next = node->next;
        xml_free(node->first);
        free(node->name);
        free(node->text);
        free(node);
        node = next;
    }
}

const xml_node *xml_next(const xml_node *node, const xml_node *after, const char *name)
{
    const xml_node *n = after != NULL ? after->next : node != NULL ? node->first : NULL;
    while (n != NULL && strcmp(n->name, name) != 0) {
        n = n->next;
    }
    return n;
}

const xml_node *xml_child(const xml_node *node, const char *name)
{
    return xml_next(node, NULL, name);
}
