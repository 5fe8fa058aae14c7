/* SPDX-License-Identifier: MIT
 * function.c - one function of the emitted file, and a long one as a row of parts.
 *
 * The time of a compiler grows with the square of a function's length, since it tracks every number
 * that is still needed. 22 000 lines (M and c of 64 joints in space) take gcc 40 s and 700 MB. So
 * the lines of a long function go, in their order, into parts of 300 lines each. A number that a
 * later part reads is handed on in an array:
 *
 *      static STEIN_PART void f_1(..., double *w)  {  const double a = ...;  w[0] = a;  ...  }
 *      static STEIN_PART void f_2(..., double *w)  {  const double a = w[0];  ...  M[0] = a*b;  }
 *      static void f(...)                          {  double w[1];  f_1(..., w);  f_2(..., w);  }
 *
 * The operations and their order stay, so the bits do. A huge function that no step calls is
 * compiled without optimisation: the compiler then ends much sooner, and the function is slower.
 */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "printer.h"

enum { LONG = GEN_LONG, PART = 300 }; /* lines */

/* properties of the nodes that the parts use */
typedef struct split {
    const printer *p;
    const func *f;
    ex *line; /* [nline] in their order: sines and cosines first */
    int nline, ntrig;
    int *part;  /* [n] that a line is in, -1: it is none */
    int *slot;  /* [n] in w of a line that a later part reads, -1: none does */
    int *stamp; /* [n] the last part that reads a constant, or a line of another part */
    int slots;
    int size; /* lines and outputs of a part */
} split;

static int is_trig(const printer *p, const char *done, ex e)
{
    const ex_node *nd = &p->g->node[e];
    int inner = nd->op > EX_CONST && nd->pass == PASS_TRIG && done[nd->a] &&
                (nd->op > EX_DIV || done[nd->b]);
    return p->uses[e] && (print_is_given(p, e) || inner);
}

static int order_lines(split *s)
{
    const printer *p = s->p;
    char *done = calloc((size_t)p->g->n, 1);
    for (int i = 1; done && i < p->g->n; i++) {
        done[i] = (char)is_trig(p, done, i);
        if (done[i] && p->line[i]) {
            s->line[s->nline++] = i;
        }
    }
    s->ntrig = s->nline;
    for (int i = 1; done && i < p->g->n; i++) {
        if (p->line[i] && !done[i]) {
            s->line[s->nline++] = i;
        }
    }
    s->size = s->nline + s->f->nout > LONG ? PART : LONG;
    for (int i = 0; i < s->nline; i++) {
        s->part[s->line[i]] = i / s->size;
    }
    int failed = !done;
    free(done);
    return failed;
}

/* values that part k reads for the expression of node e, which is written in full if it has no
 * symbol */
static void read_by(split *s, ex e, int k, int root)
{
    const ex_node *nd = &s->p->g->node[e];
    if (!root && s->p->symbol[e][0]) {
        s->stamp[e] = k;
        if (s->part[e] >= 0 && s->part[e] != k && s->slot[e] < 0) {
            s->slot[e] = s->slots++;
        }
    } else if (nd->op > EX_CONST && !print_is_given(s->p, e)) {
        read_by(s, nd->a, k, 0);
        if (nd->op <= EX_DIV) {
            read_by(s, nd->b, k, 0);
        }
    }
}

/* everything that part k reads gets its stamp */
static void read_part(split *s, int k)
{
    for (int i = k * s->size; i < (k + 1) * s->size; i++) {
        if (i < s->nline) {
            read_by(s, s->line[i], k, 1);
        } else if (i - s->nline < s->f->nout) {
            read_by(s, s->f->out[i - s->nline], k, 0);
        }
    }
}

/* ---- printing ------------------------------------------------------------------------------- */

/* the names of the arguments: the last word before every comma */
static void print_names(text *x, const char *arguments, const char *before, const char *after)
{
    for (const char *at = arguments; *at; at += strcspn(at, ",") + (at[strcspn(at, ",")] == ',')) {
        const char *end = at + strcspn(at, ","), *name = end;
        while (name > at && (isalnum((unsigned char)name[-1]) || name[-1] == '_')) {
            name--;
        }
        text_add(x, "%s%.*s%s", before, (int)(end - name), name, after);
    }
}

static void print_imports(const split *s, int k)
{
    const printer *p = s->p;
    for (int i = 0; i < s->nline; i++) {
        ex e = s->line[i];
        if (s->stamp[e] == k && s->part[e] != k) {
            text_add(p->x, "    const %s %s = w[%d];\n", p->type, p->symbol[e], s->slot[e]);
        }
    }
}

/* the lines and outputs of part k, which has its stamps */
static void print_items(const split *s, const emission *e, int k)
{
    const printer *p = s->p;
    int first = k * s->size, pass = -1, body = -2;
    print_constants(p, s->stamp, k);
    print_imports(s, k);
    for (int i = first; i < first + s->size && i < s->nline; i++) {
        const ex_node *nd = &p->g->node[s->line[i]];
        int now = i < s->ntrig ? PASS_TRIG : nd->pass, of = i < s->ntrig ? -1 : nd->body;
        if (now != pass || of != body) {
            print_heading(p, pass = now, body = of);
        }
        print_node(p, s->line[i]);
        if (s->slot[s->line[i]] >= 0) {
            text_add(p->x, "    w[%d] = %s;\n", s->slot[s->line[i]], p->symbol[s->line[i]]);
        }
    }
    int from = first > s->nline ? first - s->nline : 0, to = first + s->size - s->nline;
    for (int i = from; i < to && i < s->f->nout; i++) {
        if (i == from) {
            print_heading(p, PASS_OUTPUT, -1);
        }
        print_output(p, s->f, e, i);
    }
    text_add(p->x, "}\n\n");
}

static void print_part(const split *s, const emission *e, int k)
{
    text *x = s->p->x;
    text_quiet(x, "/* part %d of %s() */\n", k + 1, e->name);
    int seldom = e->seldom && s->nline + s->f->nout > e->seldom;
    text_add(x, "static %s void %s_%d(%s,\n        %s *w)\n{\n",
             seldom ? "STEIN_SELDOM" : "STEIN_PART", e->name, k + 1, e->arguments, s->p->type);
    print_names(x, e->arguments, "    (void)", ";\n");
    text_add(x, "    (void)w;\n");
    print_items(s, e, k);
}

/* a function that is short enough */
static void print_whole(split *s, const emission *e)
{
    text *x = s->p->x;
    text_quiet(x, "/* %s */\n", e->note);
    text_add(x, "static void %s(%s)\n{\n", e->name, e->arguments);
    print_unused(s->p, e);
    read_part(s, 0);
    print_items(s, e, 0);
}

static void print_row(const split *s, const emission *e, int parts)
{
    text *x = s->p->x;
    text_quiet(x, "/* %s */\n", e->note);
    text_add(x, "static void %s(%s)\n{\n    %s w[%d];\n", e->name, e->arguments, s->p->type,
             s->slots > 0 ? s->slots : 1);
    for (int k = 1; k <= parts; k++) {
        text_add(x, "    %s_%d(", e->name, k);
        print_names(x, e->arguments, "", ", ");
        text_add(x, "w);\n");
    }
    text_add(x, "}\n\n");
}

static void print_split(split *s, const emission *e)
{
    int parts = (s->nline + s->f->nout + s->size - 1) / s->size;
    for (int k = 0; k < parts; k++) {
        read_part(s, k); // which finds the shared values
    }
    for (int k = 0; k < parts; k++) {
        read_part(s, k);
        print_part(s, e, k);
    }
    print_row(s, e, parts);
}

void emit_func(text *x, const tree *t, const layout *l, const func *f, const emission *e)
{
    printer p = {.x = x, .t = t, .l = l, .g = &f->g, .type = e->type};
    size_t n = (size_t)f->g.n;
    int *room = malloc(4 * n * sizeof *room);
    split s = {.p = &p, .f = f};
    if (room == NULL) {
        x->failed = 1;
        return;
    }
    memset(room, -1, 4 * n * sizeof *room);
    s.line = room;
    s.part = room + n;
    s.slot = room + 2 * n;
    s.stamp = room + 3 * n;
    if (printer_init(&p, f->out, f->nout) == 0) {
        x->failed |= order_lines(&s);
        if (s.size == PART) {
            print_split(&s, e);
        } else {
            print_whole(&s, e);
        }
    }
    free(room);
    printer_free(&p);
}
