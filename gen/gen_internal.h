/* SPDX-License-Identifier: MIT
 * gen_internal.h - shared by the generator's back end: functions, the layout of d, text output.
 * Included by: this folder.
 */
#ifndef GEN_INTERNAL_H
#define GEN_INTERNAL_H

#include <stdint.h>

#include "gen.h"
#include "tree.h"

/** Weight of a division in the search, in additions. The sines and cosines of the joints are handed
 * over, so that one counts 1, as in ROBOTRAN's convention. */
enum { DIV_COST = 4 };

/* ---- search.c: functions -------------------------------------------------------------------- */

/** Fills the outputs of one function. */
typedef void builder(walk *w, ex *out);
int func_build(func *f, const tree *t, const choice *ch, builder *build, int nout, int *frame);
/** The cheapest form of a function. @return 0, or -1 when out of memory */
int func_search(func *f, const tree *t, builder *build, int nout);
/** A function with the choices that are best for another one. */
int func_like(func *f, const tree *t, const func *other, builder *build, int nout);
void func_free(func *f);

/* ---- derive.c: derivatives ------------------------------------------------------------------ */

/** By every q, then by every qd: slopes [2][nout][nq] of the nodes out [nout] of a function graph.
 */
void derive_by_state(ex_graph *g, const ex *out, int nout, int nq, ex *slopes);
/** Along a direction {dq, dqd, dd}, in the setup graph along dp: slopes [nout]. */
void derive_along(ex_graph *g, const ex *out, int nout, ex *slopes);
/** Q = M qdd + c without external forces: by q [n][n], by qd [n][n]; along a direction [n]. */
builder slope_inverse, along_inverse;
/** The poses along a direction, 7 numbers each. */
builder along_pose;

/* ---- setup.c: the derived constants d ------------------------------------------------------- */

/** One entry of d: a setup node and what it is, in words made of checked names. */
typedef struct slot {
    ex node;
    char legend[112];
} slot;

/** Where everything is in d. Arrays by body, contact, ...; -1 = absent. */
typedef struct layout {
    slot *slot;
    int n, cap, failed;
    int initial, clock, plain;             /* plain: the sensor that changes nothing, of "time" */
    int *joint, *point;                    /* [nbody], [npoint] */
    int *normal, *rub, *shape;             /* [ncontact], [ncontact], [2 * nspot] */
    int *notch, *notch_normal, *notch_rub; /* [nnotch] */
    int *link;                             /* [nlink] */
    int *table;                            /* [ntable] */
    int *limit;                            /* [nbody] */
    int *direction, *signal;               /* [ninput] */
    int *sensor;                           /* [nchannel] */
    int made, gravity;                     /* where a reaction is read */
    int *ratio;                            /* [nloop] likewise, of couplings */
    int *store;
    int equations; /* first slot of the constants of the equations */
} layout;

int layout_build(layout *l, const tree *t);
/** How many outputs read a reaction. */
int layout_reactions(const mechanism *m);
/** Append the constants that a function reads. */
void layout_add_func(layout *l, const tree *t, const func *f);
/** d index of a setup node, -1 when it has none. */
int layout_find(const layout *l, ex node);
void layout_free(layout *l);

/* ---- text.c: the growing text --------------------------------------------------------------- */

/** FNV-1a of 64 bits: a hash goes on with n bytes; it begins with GEN_HASH. */
uint64_t hash_bytes(uint64_t hash, const void *at, size_t n);
#define GEN_HASH UINT64_C(14695981039346656037)

/** Text with a running hash; what is added while `quiet` does not enter the hash. */
typedef struct text {
    char *s;
    size_t n, cap;
    int failed, quiet;
    uint64_t hash;
} text;

void text_init(text *x);
void text_add(text *x, const char *format, ...);
/** Comments, values: present in the text, absent from the hash. */
void text_quiet(text *x, const char *format, ...);
/** Shortest decimal form that reads back as the same double, with a point in every locale. */
void text_number(char out[32], double value);
/** A C string literal with quotes and escapes. */
void text_literal(text *x, const char *s);
/** s if it consists of [A-Za-z0-9_.] only, else "?": the only way of names into comments. */
const char *text_safe(const char *s);

/* ---- emit.c, emissions.c, header.c, tables.c ---- */

enum {
    GEN_LONG = 1000, /* lines of a function that goes into parts */
    GEN_HUGE = 8000  /* that a compiler would take minutes to optimise */
};

/** Names the C target of output i of a function. */
typedef void target_name(const tree *t, int i, char out[64]);
typedef struct emission {
    const char *name, *arguments, *note; /* function name, its parameter list, comment above */
    const char *type;                    /* of its numbers: "double", or "stein_real" for lanes */
    const char *unused[EX_NVAR + 2];     /* argument names by ex_var_kind, then d, sc */
    target_name *target;
    int seldom; /* not called in a step: more lines than that are not optimised; 0: called in a step
                 */
    int (*stays)(const tree *t, int i); /* output i has one writer; NULL: it may have more */
} emission;

void emit_setup(text *x, const tree *t, const layout *l, stein_ops *ops);
/** Its derivative along dp. */
void emit_setup_along(text *x, const tree *t, const layout *l);
void emit_func(text *x, const tree *t, const layout *l, const func *f, const emission *e);

/* solve.c: M x = b as a separate function, for trees that are not too large */
int emit_solves(const tree *t);
/** Operations of M x = b, with any solver. */
stein_ops solve_ops(const tree *t);
void emit_solve(text *x, const tree *t);

typedef struct funcs {
    func mass_bias, inverse, pose, point, energy;
    func unloaded;          /* mass_bias without external forces, in the same frames */
    func momenta;           /* M qdd alone, of a long tree, which has no mass_bias and unloaded */
    func articulated;       /* only where it costs less than M and its solution: nout is 0 else */
    func slopes;            /* of a large tree, or with loops, there is none: nout is 0 */
    func along, pose_along; /* likewise of one with loops */
    func pose3;             /* nout is 0 where there are none */
    func closure;           /* h, J, jdqd of the loops; nout is 0 where there are none */
    stein_ops setup;
} funcs;

/* long.c: M, c and points of a long tree */
void emit_long(text *x, const tree *t, const layout *l, const funcs *f);
void emit_functions(text *x, const tree *t, const layout *l, const funcs *f);
/** Derivatives: exact, by forward mode (derive.c). */
void emit_slopes(text *x, const tree *t, const layout *l, const funcs *f);
void emit_header(text *x, const tree *t, const layout *l, const funcs *f);
void emit_tables(text *x, const tree *t, const layout *l);
void emit_model(text *x, const tree *t, const layout *l, const funcs *f, char hash[17]);

#endif
