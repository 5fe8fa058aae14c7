/* SPDX-License-Identifier: MIT
 * tree.h - shared by the generator's passes: the tree with recombined parameters, symbolic
 * vectors, frames, and the functions that are to be emitted.
 *
 * Body -1 is the fixed frame. Bodies are 0-based here and in all arrays; symbols in the emitted
 * text count from 1, as ROBOTRAN's do.
 * Included by: this folder.
 */
#ifndef GEN_TREE_H
#define GEN_TREE_H

#include "expr.h"
#include "mechanism.h"

typedef struct vec {
    ex x[3];
} vec;

/** Symmetric 3x3: xx yy zz xy xz yz. */
typedef struct sym {
    ex x[6];
} sym;

/** Any 3x3, by rows. */
typedef struct mat {
    ex x[3][3];
} mat;

/** A body after recombination (recombine.c). All in nodes of the setup graph, in body axes. */
typedef struct rbody {
    int parent, turns; /* turns: 1 revolute, 0 prismatic */
    int axis;          /* 0 x, 1 y, 2 z */
    int sign;
    int still;   /* the chart of a ball: a joint that keeps its angle, qd = qdd = 0 */
    int orient;  /* the revolute body that sets its orientation (itself if it turns), -1 frame */
    int base;    /* for a turning body: orientation its group of parallel joints stands on */
    vec at;      /* joint origin from the parent's, as in the file */
    vec hinge;   /* the same after origins were moved along the joint axes (dynamics only) */
    vec centre;  /* of mass, from the moved origin */
    ex mass;     /* with all it carries */
    vec first;   /* recombined first moment about the moved origin */
    sym inertia; /* recombined inertia about the moved origin */
    ex armature; /* on the diagonal of M, 0 none */
    int flat;    /* revolute: no mass along the joint axis is left, K_ee = K_ff + K_hh */
} rbody;

typedef struct tree {
    const mechanism *m;
    ex_graph *setup;
    int n;
    rbody *body;
    ex mass;                /* everything hung on the frame */
    vec first;              /* constant part of the whole first moment about the frame's origin */
    vec gravity;            /* setup nodes */
    ex *param, *formula;    /* setup nodes of the parameters and formulas */
    int *carrier, ncarrier; /* bodies that have a frame (model.h), ascending */
    int *solid, nsolid;     /* the same with a pose in space */
    int *row, nrow;         /* rows of h(q), LOOP_ROWS * loop + row of that loop (loops.c) */
} tree;

enum {
    PASS_NONE,
    PASS_TRIG,
    PASS_FORWARD,
    PASS_BACKWARD,
    PASS_MASS,
    PASS_ARTICULATED,
    PASS_RATES, /* accelerations, from the root to the leaves */
    PASS_POINT,
    PASS_BY_Q, /* derivatives by the position and the speed of a joint */
    PASS_BY_QD,
    PASS_ALONG, /* along a direction */
    PASS_LOOP,
    PASS_OUTPUT,
    PASS_COUNT
};

/** One function to be emitted: a graph and its outputs in the order of the C arrays. */
typedef struct func {
    ex_graph g;
    ex *out;
    int nout;
    stein_ops ops;
    int *chosen; /* [3n+2] choices that it was built with: frame, near, pair, gravity, split */
} func;

/** Choices that do not change the result but the amount of work (search.c). */
typedef struct choice {
    int *frame;  /* [n] turning body: 0 own axes, 1 base of its group, 2 parent's axes */
    int *near;   /* [n] hinge arm is turned to 0 the parent's working frame, 1 the body's */
    int *pair;   /* [n] 1: body and parent as a pair, sharing arm.moment and arm x moment */
    int gravity; /* 0 acceleration of the base, 1 force on every body, 2 on composites in their own
                    frames, 3 on composites in the fixed frame */
    int split;   /* 1: columns of M carry the children's forces and the own part apart */
} choice;

/** Everything a pass works with. */
typedef struct walk {
    const tree *t;
    ex_graph *g;
    const choice *ch;
    int *frame;   /* [n] working frame of a body: orientation index, -1 fixed */
    int unloaded; /* 1: no external forces and moments */
    mat *world;   /* [n] axes of the bodies in the fixed frame; NULL: turned joint by joint */
} walk;

/* recombine.c */
int tree_build(tree *t, const mechanism *m, ex_graph *setup);
void tree_free(tree *t);
/** Setup node of a number of the file. */
ex tree_scalar(const tree *t, mech_scalar s);
/** EX_QD or EX_QDD of a joint, 0 where it keeps its angle. */
ex tree_rate(const tree *t, ex_graph *g, ex_var_kind kind, int joint);
/** Is there a ball or anything else that needs poses in space? */
int tree_in_space(const tree *t);
vec tree_vector(const tree *t, const mech_scalar s[3]);

/* frames.c */
vec vec_zero(void);
vec vec_const(ex_graph *g, vec setup_nodes);
vec vec_add(ex_graph *g, vec a, vec b);
vec vec_sub(ex_graph *g, vec a, vec b);
vec vec_scale(ex_graph *g, ex k, vec a);
vec vec_cross(ex_graph *g, vec a, vec b);
ex vec_dot(ex_graph *g, vec a, vec b);
/** k along axis. */
vec vec_axis(int axis, ex k);
int vec_is_zero(vec a);
void vec_name(ex_graph *g, vec a, const char *symbol, int body, int column);
/** S(u, v) = 2 (u.v) E - u v' - v u' as the sum of two halves with equal diagonals. */
void sym_cross(ex_graph *g, vec u, vec v, sym half[2]);
/** a + S(u, v); the order of the sum shares a + half of S with the columns of M. */
sym sym_add_cross(ex_graph *g, sym a, vec u, vec v);
/** A point mass at v: m (v.v E - v v'). */
sym sym_point(ex_graph *g, ex mass, vec v);
sym sym_const(ex_graph *g, sym setup_nodes);
sym sym_add(ex_graph *g, sym a, sym b);
ex *sym_entry(sym *a, int i, int j);
vec sym_column(sym a, int axis);
vec sym_apply(ex_graph *g, sym a, vec v);
void walk_frames(walk *ps);
/** Sine and cosine of the angle from orientation `to` up to orientation `from` (same group). */
vec rotate(walk *ps, vec v, int from, int to);
sym rotate_sym(walk *ps, sym a, int from, int to);
mat rotate_mat(walk *ps, mat a, int from, int to);
/** 1 when both orientations differ by turns about `axis` only. */
int same_group(const tree *t, int a, int b, int axis);
/** Sum of the joint angles from orientation `top` down to `o` as sine and cosine. */
void angle_trig(walk *ps, int o, int top, ex *s, ex *c);

/* dyn.c */
void dyn_mass_bias(walk *ps, ex *out);
/** The same without external forces and moments. */
void dyn_unloaded(walk *ps, ex *out);
void dyn_inverse(walk *ps, ex *out);
/** c alone: the same at qdd = 0. */
void dyn_bias(walk *ps, ex *out);

/* armature.c */
/** The armatures on the diagonal of M [n*n]. */
void armature_masses(walk *w, ex *M);
/** Q [n] plus armature times rate, EX_QDD or EX_QD. */
void armature_forces(walk *w, ex_var_kind rate, ex *Q);

/* long.c */
/** Has it so many joints in so long branches that functions of quadratic size are loops? */
int tree_is_long(const tree *t);
/** M a, a being EX_QD or EX_QDD; all joints turn. */
void dyn_momenta(walk *w, ex_var_kind rate, ex *out);
void long_momenta(walk *w, ex *out);
void long_points(walk *w, ex *out);

/* articulated.c */
/** 1: all joints turn, and none of them is ever given. */
int dyn_articulates(const tree *t);
/** qdd [n] and pivots [n] from EX_TAU = Q, without external forces and moments. */
void dyn_articulated(walk *ps, ex *out);

/* kin.c */
/** A body in the axes of another one that it hangs on, or of the fixed frame. */
typedef struct placed {
    vec axis, arm; /* joint axis times sign; from the parent's origin to the own */
    vec om, omp;   /* angular velocity, and acceleration while qdd = 0 */
    vec o, v, a;   /* origin, its velocity, its acceleration while qdd = 0 */
} placed;

/** om x (om x r) + omp x r, with planar motion at the cost of two products. */
vec kin_bend(ex_graph *g, vec om, vec omp, vec r);
/** all[i] in the axes of body `top`, -1 the fixed frame; its parent is there, or is `top`. */
void kin_place(walk *ps, placed *all, int i, int top);
/** Outputs in the order of the C arrays: 7 numbers a pose; x, v, J, jdqd; kinetic, potential. */
void kin_pose(walk *ps, ex *out);
enum { POSE3 = 18 };
void kin_pose3(walk *ps, ex *out);
/** v, from the axes of orientation `up` to the axes of `to`. */
vec kin_turn(walk *w, vec v, int up, int to);
void kin_point(walk *ps, ex *out);
/** o, v, a: point k, its velocity, its acceleration while qdd = 0. arm: from the origin of its
 * body.
 */
placed kin_point_of(walk *w, const placed *all, int k);
void kin_energy(walk *ps, ex *out);

/* loops.c */
enum { LOOP_ROWS = 6 };
/** Which rows of the loops are not trivial: t->row. @return 0, or -1 when out of memory */
int loop_rows(tree *t);
/** How many rows of loop i are lengths, and how many are angles. */
void loop_units(const tree *t, int i, int *lengths, int *angles);
/** h, J and jdqd in the order of the C arrays. */
void loop_closure(walk *ps, ex *out);

#endif
