/* SPDX-License-Identifier: MIT
 * expr.h - hash-consed expression graphs: equal expressions are one node, so that common
 * subexpressions, dead code and operation counts come for free.
 *
 * There are two kinds of graph. The *setup* graph holds everything that depends on parameters only.
 * A *function* graph holds terms that depend on q, qd, ...; a parameter-only value is a leaf
 * EX_CONST in it that points into the setup graph, and an operation on two such leaves is done
 * there:
 *
 *      setup graph                     function graph
 *      p[3] --(*)--> mb1  <----------- EX_CONST --(*)--> mb1*C2
 *      p[5] --/                                   C2 --/
 *
 * Signs are pulled outwards as nodes are made: -(a*b), a+(-b) and -(a-b) never store a negation
 * below another node. So an EX_NEG survives only where it is an output, and costs nothing there.
 * Included by: this folder.
 */
#ifndef GEN_EXPR_H
#define GEN_EXPR_H

#include <stddef.h>

#include "gen_names.h"
#include "stein/model.h"

typedef int ex; /* a node, index into its graph; 0 is the number zero */

typedef enum {
    EX_NUM,   /* value (setup graph only) */
    EX_VAR,   /* a = ex_var_kind, b = index */
    EX_CONST, /* a = node of the setup graph (function graphs only) */
    EX_ADD,
    EX_SUB,
    EX_MUL,
    EX_DIV,
    EX_NEG,
    EX_SIN,
    EX_COS,
    EX_TAN,
    EX_SQRT
} ex_op;

/** EX_DP, EX_DQ, EX_DQD and EX_DD are components of the direction of a derivative; the
 *  index of an EX_DD is the setup node of its constant. */
typedef enum {
    EX_P,
    EX_Q,
    EX_QD,
    EX_QDD,
    EX_FRC,
    EX_TRQ,
    EX_TAU, /* forces in the joints */
    EX_DP,
    EX_DQ,
    EX_DQD,
    EX_DD,
    EX_NVAR
} ex_var_kind;

enum { EX_NAME = 24 };

typedef struct ex_node {
    ex_op op;
    int a, b;
    double value;
    int pass, body;     /* where it was first needed: heading of its line in the emitted text */
    int next;           /* hash chain */
    char name[EX_NAME]; /* symbol, or "" */
} ex_node;

typedef struct ex_graph {
    struct ex_graph *setup; /* NULL in the setup graph itself */
    ex_node *node;
    int n, cap;
    int *bucket;
    int nbucket;    /* a power of two */
    int pass, body; /* stamped on new nodes */
    int nameless;   /* names are not kept: a graph that is only counted */
    int failed;     /* out of memory: every later result is 0 and meaningless */
} ex_graph;

/** @return 0, or -1 when out of memory */
int ex_graph_init(ex_graph *g, ex_graph *setup);
void ex_graph_free(ex_graph *g);

ex ex_num(ex_graph *g, double value);
ex ex_var(ex_graph *g, ex_var_kind kind, int index);
/** Leaf of function graph g for a value of the setup graph. */
ex ex_const(ex_graph *g, ex setup_node);
ex ex_add(ex_graph *g, ex a, ex b);
ex ex_sub(ex_graph *g, ex a, ex b);
ex ex_mul(ex_graph *g, ex a, ex b);
ex ex_div(ex_graph *g, ex a, ex b);
ex ex_neg(ex_graph *g, ex a);
/** a b + c d and a b - c d. The order in which nodes are made is the order of the text. C leaves
 * open which argument of a call is evaluated first, so no call has two arguments that make nodes.
 */
ex ex_dot2(ex_graph *g, ex a, ex b, ex c, ex d);
ex ex_det2(ex_graph *g, ex a, ex b, ex c, ex d);
/** EX_SIN, EX_COS, EX_TAN or EX_SQRT of a. */
ex ex_fun(ex_graph *g, ex_op op, ex a);

/** Give a node its symbol; the first name stays, leaves keep their own. A sign is looked through:
 *  the symbol then stands for the negative quantity. */
void ex_name(ex_graph *g, ex a, const char *format, ...);

/** 1 when a is a number (of either graph), whose value goes to *value. */
int ex_is_num(const ex_graph *g, ex a, double *value);

/** Mark the nodes that `outputs` need. uses [g->n] counts the references from marked nodes and
 * outputs. */
void ex_reach(const ex_graph *g, const ex *outputs, int noutput, int *uses);
/** Operations needed for the outputs, ROBOTRAN's convention: signs of outputs are free.
 *  @return 0, -1 without memory */
int ex_count(const ex_graph *g, const ex *outputs, int noutput, stein_ops *count);

/** Values of all nodes. var[kind] may be NULL where the kind is not used; constants [setup->n] are
 *  the values of the setup graph (NULL for the setup graph itself); values [g->n] out. */
void ex_eval(const ex_graph *g, const double *const var[EX_NVAR], const double *constants,
             double *values);

#endif
