/* SPDX-License-Identifier: GPL-3.0-or-later
 * xml.h - an XML file as a tree of elements, read with expat.
 * Included by: this folder.
 */
#ifndef XML_H
#define XML_H

#include <stddef.h>

#include "stein/status.h"

/** An element, or with a name that begins with @ an attribute. */
typedef struct xml_node {
    char *name, *text; /* text: all of it, without blanks at both ends; "" when there is none */
    int line, column;
    struct xml_node *parent, *first, *last, *next;
} xml_node;

/** Read a file: at most 8 MiB, 32 levels, no document type.
 *  @param root  out, freed with xml_free
 *  @return OK, EIO, ENOMEM, EPARSE with file:line:column */
stein_status xml_read(xml_node **root, const char *file, stein_err *err);
void xml_free(xml_node *root);

/** The first child of this name, NULL when there is none. */
const xml_node *xml_child(const xml_node *node, const char *name);
/** The next child of this name, from the first one on with `after` NULL. */
const xml_node *xml_next(const xml_node *node, const xml_node *after, const char *name);

#endif
