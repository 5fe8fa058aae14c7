/* SPDX-License-Identifier: MIT
 * printer.h - shared by the files that print functions: emit.c, function.c.
 * Included by: this folder.
 */
#ifndef PRINTER_H
#define PRINTER_H

#include "gen_internal.h"

enum { SYMBOL = 48 };

typedef struct printer {
    text *x;
    const tree *t;
    const layout *l;
    const ex_graph *g;
    int *uses;
    char *line;             /* [n] 1: the node has a separate line */
    char (*symbol)[SYMBOL]; /* [n] what to write for it, "" = write it out */
    int *taken, ntaken;     /* hash set of the symbols in use */
    const char *type;       /* of the numbers */
} printer;

/** The sine or cosine of a joint's coordinate, which is handed over. */
int print_is_given(const printer *p, ex e);
void print_heading(const printer *p, int pass, int body);
/** "    const TYPE SYMBOL = expression;" */
void print_node(const printer *p, ex e);
/** Constants stamped with `part`, in the order of d. @param stamp  [n] of the nodes */
void print_constants(const printer *p, const int *stamp, int part);
/** "    TARGET = expression;" of output i */
void print_output(const printer *p, const func *f, const emission *e, int i);

/** "    (void)ARGUMENT;" of those that nothing is read of */
void print_unused(const printer *p, const emission *e);
/** Which nodes get a line, and all symbols. @return 0, or -1 without memory */
int printer_init(printer *p, const ex *out, int nout);
void printer_free(printer *p);

#endif
