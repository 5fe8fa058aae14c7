/* SPDX-License-Identifier: MIT
 * reader.h - shared by the files of the mechanism reader.
 *
 *   bytes --source.c--> tree of nodes --section_*.c--> mechanism + list of slots --slots.c-->
 * values
 *
 * A slot is the place of one number: its path ("key.mass"), expected unit, text in the file and the
 * mech_scalar it fills. The sections only declare slots; all numbers are worked out afterwards, so
 * a formula may refer to a number that stands below it, and an override may set one that is absent.
 * Temporary memory lives in one arena; after an allocation failure `nomem` is set, every later
 * allocation fails too, and the reader unwinds without special cases.
 * Included by: this folder, src/lab/data, src/lab/search, src/lab/sweep.
 */
#ifndef READER_H
#define READER_H

#include "mechanism.h"

enum {
    MECH__MAX_FILE = 1 << 20, /* bytes */
    MECH__MAX_NESTING = 16,   /* lists and mappings inside each other */
    MECH__MAX_ENTRIES = 1024, /* of one list or mapping */
    MECH__MAX_PROBLEMS = 50,  /* reported in one run */
    MECH__MAX_POINTS = 256,
    MECH__MAX_THINGS = 128,   /* contacts, notches, links, tables, inputs, outputs: of each */
    MECH__MAX_TABLE = 64,     /* points of one table */
    MECH__MAX_STEPS = 256,    /* of one formula, after other formulas are put in */
    MECH__MAX_DEPTH = 32,     /* brackets; formulas that refer to formulas */
    MECH__PART_FORMULAS = 10, /* mass, centre and inertia of a whole without its part, or of a body
                                 with the fixed bodies on it */
    MECH__WHY = 200           /* room for the cause of a problem */
};

/* --- problems.c: collecting problems, names --- */

typedef struct mech__problem {
    int line, column; /* 0 when the problem has no place in the file */
    char *text;
} mech__problem;

typedef enum { MECH__SCALAR, MECH__LIST, MECH__MAP } mech__node_kind;

/** Node of the source tree. */
typedef struct mech__node {
    mech__node_kind kind;
    const char *text; /* scalar; "" otherwise */
    int plain;        /* scalar without quotes on one line: columns can be counted in it */
    int line, column; /* from 1 */
    int count;        /* children */
    struct mech__node *first, *last, *next;
    struct mech__node *key; /* of an entry of a mapping */
} mech__node;

/** Requirements of a slot. */
enum {
    MECH__VANISHES = 1, /* a literal 0 is a structural zero */
    MECH__POSITIVE = 2,
    MECH__NOT_NEGATIVE = 4,
    MECH__DECLARED = 8, /* of the section `parameters`: its own unit decides the dimension */
    MECH__PLANAR = 32,  /* triple of which y does nothing: a literal 0 there is structural */
    MECH__WEDGE = 16,   /* angle between 0 and 180 deg */
    MECH__UNUSED = 64   /* its place does not use it: friction that sticks */
};

/** A formula or number while it is worked out. */
typedef struct mech__expr {
    mech_step *steps; /* arena */
    int nsteps;
    mech_dim dim;
    int wild;    /* a bare 0: fits every dimension */
    int literal; /* a single number: a missing unit means SI */
    int bare;    /* made of numbers without units only */
    int percent; /* literal in % */
    int refs;    /* refers to other numbers */
    double tolerance;
} mech__expr;

typedef enum { MECH__NEW, MECH__BUSY, MECH__DONE, MECH__FAILED } mech__state;

/** The place of one number. */
typedef struct mech__slot {
    char path[MECH_PATH];
    size_t length;    /* of the path */
    const char *unit; /* SI unit expected; NULL for a declared parameter */
    mech_dim dim;
    unsigned flags;
    const mech__node *node;  /* NULL: absent or made by the reader */
    const mech__node *named; /* key of a declared parameter */
    const char *text;        /* NULL: absent, use fallback */
    const char *label;       /* short text of a formula made by the reader, or NULL */
    double fallback;
    const mech_set *set;
    mech_scalar *to;         /* filled when done; NULL for a declared parameter */
    const mech_scalar *less; /* taken from what `to` gets: the joint of a part, or NULL */
    const mech_scalar *more; /* added to it: the place of a fixed body, or NULL */
    mech_scalar value;
    mech__state state;
    struct mech__slot *next;
} mech__slot;

/** A scalar triple that repeats another one (a shape at a named point). */
typedef struct mech__copy {
    mech_scalar *to;
    const mech_scalar *from;
    struct mech__copy *next;
} mech__copy;

/** Treatment of an inertia that no body can have: a principal moment that exceeds the sum of the
 *  other two. BALANCE: all three become their mean. */
typedef enum { MECH__REFUSE, MECH__ACCEPT, MECH__BALANCE } mech__inertia;

typedef struct mech__reader {
    const char *file;
    mechanism *m;
    const mech__node *root;
    const mech_set *set;
    int nset;
    char *set_used; /* [nset] */
    mech__slot *slots, *last_slot;
    int nslot, depth;
    double *values; /* of the parameters found so far */
    mech__copy *copies, *last_copy;
    const mech__node *table_at[MECH__MAX_THINGS]; /* the list of each table, in their order */
    const mech__node *body_node[MECH_BODIES];     /* entries in the order of m->bodies */
    char orphan[MECH_BODIES]; /* the parent was not found, which has been reported */
    mech__problem problems[MECH__MAX_PROBLEMS + 1];
    const char *warnings[MECH_BODIES]; /* of accepted inertias */
    mech__inertia inertia;
    int nproblem, nwarning, nomem;
    void *arena;
} mech__reader;

/** Note a problem at a node (NULL: no place). Beyond MECH__MAX_PROBLEMS they are only counted. */
void mech__problem_at(mech__reader *rd, const mech__node *node, const char *format, ...);
/** The same, `skip` characters into a plain scalar. */
void mech__problem_in(mech__reader *rd, const mech__node *node, size_t skip, const char *format,
                      ...);
/** Note a warning; the file is read all the same: one for each body at most. */
void mech__warn_at(mech__reader *rd, const mech__node *node, const char *format, ...);
/** Hand all problems over, sorted by place; err gets the first. */
void mech__problems_flush(mech__reader *rd, mech_report *report, void *ctx, stein_err *err);
/** Control characters of a text become "?". NULL is fine. */
void mech__one_line(char *text);
/** User text made printable and short, in the arena ("" when out of memory). */
const char *mech__shown(mech__reader *rd, const char *text);

/** Search for the known word nearest to a misspelt one. */
typedef struct mech__nearest {
    const char *word, *best;
    int distance;
} mech__nearest;
void mech__offer(mech__nearest *n, const char *candidate);
/** `, did you mean "x"?`, or `otherwise`; in the arena. */
const char *mech__hint(mech__reader *rd, const mech__nearest *n, const char *otherwise);

/** 1 when `name` may name a thing; otherwise 0 after noting the problem. */
int mech__name_check(mech__reader *rd, const mech__node *node, const char *what);
/** Copy of a name, cut to the room there is. */
void mech__name_copy(char *to, size_t room, const char *from);

/* --- source.c: arena, tree --- */

void *mech__alloc(mech__reader *rd, size_t size);             /* zeroed, NULL when out of memory */
char *mech__print(mech__reader *rd, const char *format, ...); /* in the arena, NULL likewise */
void mech__arena_free(mech__reader *rd);
/** Read the source into rd->root; problems are noted. */
void mech__tree(mech__reader *rd, const char *text, size_t size);

/* --- fields.c: access to mappings --- */

/** Entry of a mapping, NULL when absent, empty or `map` is no mapping. */
const mech__node *mech__get(const mech__node *map, const char *key);
/** The same, noting a problem when absent. `what` names the mapping. */
const mech__node *mech__need(mech__reader *rd, const mech__node *map, const char *key,
                             const char *what);
/** Check that `node` is a mapping that has only these keys (separated by blanks) and `about`. */
int mech__keys(mech__reader *rd, const mech__node *node, const char *what, const char *keys);
/** Check a section: a mapping with at most `max` entries of good names. @return entries, 0 if none
 */
int mech__section(mech__reader *rd, const mech__node *node, const char *what, int max);
/** Index of a scalar's text among words (separated by blanks), -1 after noting a problem. */
int mech__choice(mech__reader *rd, const mech__node *node, const char *what, const char *words);
/** Text of a scalar, NULL after noting a problem. */
const char *mech__text(mech__reader *rd, const mech__node *node, const char *what);
/** Array owned by the mechanism, zeroed; NULL when out of memory. */
void *mech__array(mech__reader *rd, int n, size_t size);

/* --- units.c: numbers and units --- */

typedef struct mech__quantity {
    double value; /* [SI] */
    mech_dim dim;
    int has_unit, percent;
} mech__quantity;

/** Unsigned number with optional unit at the start of `s`.
 *  @return bytes used, or -1 with the cause in why and its place in *bad */
int mech__quantity_at(const char *s, mech__quantity *q, char why[MECH__WHY], const char **bad);
/** 1 when a unit may stand where `expected` is asked for; a bare angle is as good as rad. */
int mech__dim_fits(mech_dim found, mech_dim expected);
int mech__dim_same(mech_dim a, mech_dim b); /* without the angle */
void mech__unit_text(mech_dim dim, char text[MECH_UNIT]);

/* --- formula.c --- */

/** Work out a text for a slot. @return 0, or -1 after noting a problem */
int mech__expression(mech__reader *rd, const mech__slot *slot, const char *text, int from_set,
                     mech__expr *out);
double mech__evaluate(const mech_step *steps, int nsteps, const double *p);

/* --- slots.c --- */

/** Declare a number of the mechanism. node NULL: absent, its value is `fallback`. The path is
 *  printed by format. @return the slot, NULL when out of memory or the name is taken */
mech__slot *mech__number(mech__reader *rd, mech_scalar *to, const char *unit, unsigned flags,
                         const mech__node *node, double fallback, const char *format, ...);
/** Declare three numbers "BASE.x", "BASE.y", "BASE.z" from a list (NULL: zeros). */
void mech__vector(mech__reader *rd, mech_scalar to[3], const char *unit, unsigned flags,
                  const mech__node *node, const char *base);
/** The same for a place in the axes of a body (-1 frame): one on a part counts from the origin of
 *  the whole. */
void mech__place(mech__reader *rd, int body, mech_scalar to[3], unsigned flags,
                 const mech__node *node, const char *base);
/** A new formula of the mechanism, with its value. */
mech_scalar mech__formula(mech__reader *rd, const char *name, const char *text,
                          const mech_step *steps, int nsteps);
/** to[3] becomes from[3] once these are known. */
void mech__repeat(mech__reader *rd, mech_scalar *to, const mech_scalar *from);
void mech__repeat_all(mech__reader *rd);
/** A fixed number that is no parameter: a formula of one constant. */
void mech__constant(mech__reader *rd, mech_scalar *to, double value, const char *name,
                    const char *text);
/** Value of a reference in a formula. @return 0; -1 unknown, -2 failed before, -3 a loop */
int mech__reference(mech__reader *rd, const char *path, mech__expr *out);
/** Did a number of this owner ("hammer") turn out wrong? */
int mech__failed(const mech__reader *rd, const char *owner);
void mech__offer_paths(mech__reader *rd, mech__nearest *n);
void mech__problem_slot(mech__reader *rd, const mech__slot *slot, int from_set, size_t skip,
                        const char *format, ...);
void mech__section_parameters(mech__reader *rd);
/** Work out all slots. */
void mech__resolve(mech__reader *rd);

/* --- section_bodies.c --- */

void mech__section_bodies(mech__reader *rd);
int mech__body_ref(mech__reader *rd, const mech__node *node, int frame_allowed, int *body);
/** A body with a joint. */
int mech__joint_ref(mech__reader *rd, const mech__node *node, int *body);
/** Note a problem where a body is fixed and a joint is asked for. @return 0, or -1 */
int mech__has_joint(mech__reader *rd, const mech__node *node, int body);
int mech__point_ref(mech__reader *rd, const mech__node *node, int *point);

/* --- balls.c --- */

/** Number of one-axis joints of an entry of `bodies`: 4 for a ball, 7 for a free body.
 */
int mech__joints_of(const mech__node *entry);
/** Put all of them but the last one, as bodies without mass, behind the bodies there are.
 *  @return the parent of the body itself, which comes next and has its joint set */
int mech__lead_joints(mech__reader *rd, const mech__node *entry, int parent, int orphan);
/** Where the joint of a body begins: the body itself, of a ball its first joint. */
mech_body *mech__first_joint(mech_body *b);
/** `initial` of a body on a ball. */
void mech__ball_initial(mech__reader *rd, mech_body *b, const mech__node *node);

/* --- section_contacts.c, section_signals.c --- */

void mech__section_links(mech__reader *rd);
void mech__section_contacts(mech__reader *rd);
void mech__contacts_finish(mech__reader *rd);
void mech__section_signals(mech__reader *rd);

/* --- section_loops.c --- */

void mech__section_loops(mech__reader *rd);

/* --- section_regulation.c --- */

/** With all parameters known: the ranges of the regulation, and the texts of `about`. */
void mech__section_regulation(mech__reader *rd);

/* --- section_tables.c --- */

void mech__section_tables(mech__reader *rd);
/** With all numbers known: do the points of every table increase? */
void mech__tables_finish(mech__reader *rd);

/* --- split_body.c --- */

/** The rest of every whole without its parts, and the places on parts. All numbers
 *  are known, copies are made before and again after. */
void mech__parts(mech__reader *rd);

/* --- fixed_bodies.c --- */

enum { MECH__FIXED = 'F' }; /* type of a body without a joint */
/** Fixed bodies become part of the bodies that carry them, and are removed. */
void mech__fixed(mech__reader *rd);
/** Two bodies in one: b is joined to a, or with `apart` taken out of it. Its numbers in a's axes.
 *  @param name  of the whole: NAME.mass, NAME.centre.x, NAME.inertia.xx */
void mech__combine(mech__reader *rd, mech_body *a, const mech_body *b, int apart,
                   const mech__node *node, const char *name);
/** to becomes to + s times by, a place in other axes; s = 1 or -1. */
void mech__shift(mech__reader *rd, mech_scalar *to, mech_scalar by, int s, const mech__slot *slot,
                 const char *why);

/* --- laws.c --- */

void mech__joint_law(mech__reader *rd, mech_body *b, const mech__node *entry);
/** `limits` of a joint: [from, to], or a mapping with that as range, and k, D. */
void mech__limits(mech__reader *rd, mech_body *b, const mech__node *node);
void mech__link_law(mech__reader *rd, mech_link *l, const mech__node *entry);
/** `normal`, `friction`, `adhesion` and `gap` of a contact, a load or a notch. */
void mech__contact_law(mech__reader *rd, mech_normal *normal, mech_friction *friction,
                       const mech__node *entry, const char *what, const char *name);
/** `stick` of its friction. @param what  whose friction cannot ("a notch"), NULL: it can
 *  @return does it stick? */
int mech__contact_sticks(mech__reader *rd, const mech__node *entry, const char *what);
void mech__input_law(mech__reader *rd, mech_input *in, const mech__node *entry);
void mech__sensor_law(mech__reader *rd, mech_channel *c, const mech__node *entry);

/* --- motor.c --- */

/** `motor` of a joint; its laws without the motor are [STEIN_JOINT_SIZE]. */
void mech__motor(mech__reader *rd, mech_body *b, const mech__node *node, const mech_scalar *law);

/* --- checks.c --- */

/** Checks that need all numbers: inertias, mass matrix, extents. */
void mech__checks(mech__reader *rd);
/** The inertia of one body as the file states it. */
void mech__check_inertia(mech__reader *rd, int body);

/* --- inertia.c --- */

/** `inertia` of the file, or of an override of that name. */
void mech__read_inertia(mech__reader *rd);
/** Principal moments of xx yy zz xy xz yz. */
void mech__principal(const mech_scalar I[6], double value[3]);
/** Does one of them exceed the sum of the other two? */
int mech__violates_triangle(const mech_scalar I[6]);
/** With all numbers known, before they are used: the inertias that are balanced.
 */
void mech__balance(mech__reader *rd);

/* --- plausibility.c --- */

/** Of a file without problems: possible but implausible numbers, noted as "warning: ...". */
void mech__doubts(mech__reader *rd);

#endif
