/* SPDX-License-Identifier: MIT
 * sympy.c - the generated expressions as text that SymPy reads: sympify(text).
 *
 * Written out in full, without names for what is used more than once, so a text can be long: SymPy
 * would expand them all the same. Symbols have the names of the mechanism file, 'hammer.mass', and
 * 'q.BODY', 'qd.BODY', 'qdd.BODY' for coordinates, speeds and accelerations. They are written as
 * Symbol('...'), so
 * that a parameter may be called "beta" or "lambda".
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

enum { LONGEST = 4 << 20 }; /* [bytes]; SymPy takes minutes for more */

/* available expressions: the outputs `first` ... of a builder, in rows and columns */
typedef struct wanted {
    builder *build;
    int nout, first, rows, columns; /* columns 0: one number */
} wanted;

static void put(text *x, const tree *t, const ex_graph *g, ex e, int level);

static void put_binary(text *x, const tree *t, const ex_graph *g, const ex_node *nd, int level)
{
    static const char *const sign[] = {
        [EX_ADD] = " + ", [EX_SUB] = " - ", [EX_MUL] = "*", [EX_DIV] = "/"};
    int own = nd->op == EX_MUL || nd->op == EX_DIV ? 2 : 1;
    text_add(x, "%s", own < level ? "(" : "");
    put(x, t, g, nd->a, own);
    text_add(x, "%s", sign[nd->op]);
    put(x, t, g, nd->b, own + 1);
    text_add(x, "%s", own < level ? ")" : "");
}

static void put_number(text *x, double value)
{
    char number[32];
    text_number(number, value);
    text_add(x, "%s", isinf(value) ? "oo" : number);
}

static void put_symbol(text *x, const tree *t, const ex_node *nd)
{
    static const char *const of[EX_NVAR] = {[EX_Q] = "q.", [EX_QD] = "qd.", [EX_QDD] = "qdd."};
    if (nd->a == EX_P) {
        text_add(x, "Symbol('%s')", t->m->params[nd->b].name);
    } else if (nd->a == EX_FRC || nd->a == EX_TRQ) {
        text_add(x, "0"); /* external forces and moments are none of the equations' */
    } else {
        text_add(x, "Symbol('%s%s')", of[nd->a], t->m->bodies[nd->b].name);
    }
}

/* level: 1 sum, 2 product, 3 factor */
static void put(text *x, const tree *t, const ex_graph *g, ex e, int level)
{
    static const char *const fun[] = {
        [EX_SIN] = "sin", [EX_COS] = "cos", [EX_TAN] = "tan", [EX_SQRT] = "sqrt"};
    const ex_node *nd = &g->node[e];
    if (x->failed || x->n > LONGEST) {
        return;
    }
    switch (nd->op) {
    case EX_NUM: put_number(x, nd->value); break;
    case EX_VAR: put_symbol(x, t, nd); break;
    case EX_CONST: put(x, t, t->setup, nd->a, level); break;
    case EX_NEG:
        text_add(x, "%s-", level > 1 ? "(" : "");
        put(x, t, g, nd->a, 2);
        text_add(x, "%s", level > 1 ? ")" : "");
        break;
    case EX_ADD:
    case EX_SUB:
    case EX_MUL:
    case EX_DIV: put_binary(x, t, g, nd, level); break;
    default:
        text_add(x, "%s(", fun[nd->op]);
        put(x, t, g, nd->a, 0);
        text_add(x, ")");
    }
}

static void put_all(text *x, const tree *t, const func *f, const wanted *w)
{
    text_add(x, "%s", w->columns ? "Matrix([" : "");
    for (int i = 0; i < w->rows; i++) {
        text_add(x, "%s", w->columns ? i ? ", [" : "[" : "");
        for (int j = 0; j < (w->columns ? w->columns : 1); j++) {
            text_add(x, "%s", j ? ", " : "");
            put(x, t, &f->g, f->out[w->first + i * w->columns + j], 1);
        }
        text_add(x, "%s", w->columns ? "]" : "");
    }
    text_add(x, "%s", w->columns ? "])" : "");
}

static stein_status refuse(stein_err *err, stein_status code, const char *format, const char *what,
                           const char *name)
{
    if (err) {
        err->code = code;
        snprintf(err->msg, sizeof err->msg, format, what, name);
    }
    return code;
}

static int find(wanted *w, const mechanism *m, const char *what)
{
    static const char *const energy[] = {"T", "V"};
    int n = m->nbody;
    if (strcmp(what, "M") == 0 || strcmp(what, "c") == 0) {
        int is_c = what[0] == 'c';
        *w = (wanted){dyn_unloaded, n * n + n, is_c ? n * n : 0, n, is_c ? 1 : n};
        return 1;
    }
    if (strcmp(what, "Q") == 0) {
        *w = (wanted){dyn_inverse, n, 0, n, 1};
        return 1;
    }
    for (int i = 0; i < 2; i++) {
        if (strcmp(what, energy[i]) == 0) {
            *w = (wanted){kin_energy, 2, i, 1, 0};
            return 1;
        }
    }
    for (int i = 0; i < m->npoint; i++) {
        if (strcmp(what, m->points[i].name) == 0) {
            *w = (wanted){kin_point, 9 * m->npoint + 3 * m->npoint * n, 3 * i, 3, 1};
            return 1;
        }
    }
    return 0;
}

/* in the working frames of every body's own axes: what is expanded has no use for others */
static stein_status write_wanted(text *x, const tree *t, const wanted *w)
{
    size_t n = (size_t)t->n;
    func f = {.out = NULL};
    int *store = calloc(4 * n + 1, sizeof *store);
    choice ch = {.frame = store, .near = store + n, .pair = store + 2 * n};
    int good = store && func_build(&f, t, &ch, w->build, w->nout, store + 3 * n) == 0;
    if (good) {
        put_all(x, t, &f, w);
    }
    func_free(&f);
    free(store);
    return good && !x->failed ? STEIN_OK : STEIN_ENOMEM;
}

stein_status gen_expressions(char **out, const mechanism *m, const char *what, stein_err *err)
{
    wanted w;
    ex_graph setup = {.setup = NULL};
    tree t = {0};
    text x;
    if (!find(&w, m, what)) {
        return refuse(err, STEIN_ENAME,
                      "no expression \"%s\" of %s: expected M, c, Q, T, V or the name of a point",
                      what, m->name);
    }
    text_init(&x);
    stein_status status = ex_graph_init(&setup, NULL) == 0 && tree_build(&t, m, &setup) == 0
                              ? write_wanted(&x, &t, &w)
                              : STEIN_ENOMEM;
    tree_free(&t);
    ex_graph_free(&setup);
    if (status) {
        refuse(err, status, "%s of %s: out of memory", what, m->name);
    } else if (x.n > LONGEST) {
        status = refuse(err, STEIN_EGENERATE, "%s of %s is longer than 4 MB when it is written out",
                        what, m->name);
    }
    if (status) {
        free(x.s);
        return status;
    }
    *out = x.s;
    return STEIN_OK;
}
