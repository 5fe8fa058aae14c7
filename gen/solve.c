/* SPDX-License-Identifier: MIT
 * solve.c - the emitted solution of M x = b, without loops.
 *
 * M = L^T D L from the leaves of the tree to its root (Featherstone 2008, section 6.5) keeps the
 * branches of the tree: row k of L has entries at the ancestors of joint k only. With desc(i) the
 * joints beyond i and j an ancestor of i or i itself,
 *
 *      A_ij = M_ij - sum of L_ki A_kj over k in desc(i)       D_i = A_ii       L_ij = A_ij / D_i
 *      y_i  = b_i  - sum of L_ki y_k  over k in desc(i)
 *      x_i  = y_i / D_i - sum of L_ij x_j over the ancestors j of i
 *
 * Large trees are left to the loops of the runtime: the text grows with the cube of their depth.
 * STEIN_PIVOT (model.h) returns at a pivot that vanishes or, in lanes, stores the lanes in which it
 * did.
 */
#include <stdio.h>
#include <string.h>

#include "gen_internal.h"

enum { LARGEST = 16, WIDTH = 100, NAME = 32 };

int emit_solves(const tree *t)
{
    /* Loops fill M beyond the branches of the tree. This solution is for lanes, which a mechanism
     * in space does not have. */
    return t->n <= LARGEST && t->nrow == 0 && !tree_in_space(t);
}

static int is_beyond(const tree *t, int k, int i)
{
    int up = t->body[k].parent;
    while (up > i) {
        up = t->body[up].parent;
    }
    return k > i && up == i;
}

static int has_beyond(const tree *t, int i)
{
    int any = 0;
    for (int k = i + 1; k < t->n; k++) {
        any |= is_beyond(t, k, i);
    }
    return any;
}

stein_ops solve_ops(const tree *t)
{
    stein_ops o = {0};
    for (int i = 0; t->nrow == 0 && i < t->n; i++) {
        int above = 0, beyond = 0;
        for (int j = t->body[i].parent; j >= 0; j = t->body[j].parent) {
            above++;
        }
        for (int k = i + 1; k < t->n; k++) {
            beyond += is_beyond(t, k, i);
        }
        o.div += above + 1;
        o.mul += beyond * (above + 2) + above;
        o.add += beyond * (above + 2) + above;
    }
    return o;
}

/* what stands for A_ij: an entry of M where no joint is beyond i */
static void entry(const tree *t, int i, int j, char out[NAME])
{
    if (!has_beyond(t, i)) {
        snprintf(out, NAME, "M[%d]", i * t->n + j);
    } else if (i == j) {
        snprintf(out, NAME, "D%d", i + 1);
    } else {
        snprintf(out, NAME, "A%d_%d", i + 1, j + 1);
    }
}

static void right_side(const tree *t, int i, char out[NAME])
{
    snprintf(out, NAME, has_beyond(t, i) ? "y%d" : "b[%d]", has_beyond(t, i) ? i + 1 : i);
}

/* " - L*factor", on a new line where this one is full; `used` counts its signs */
static void minus(text *x, size_t *used, int k, int i, const char *factor)
{
    char term[96];
    int n = snprintf(term, sizeof term, " - L%d_%d*%s", k + 1, i + 1, factor);
    if (*used + (size_t)n + 1 > WIDTH) {
        text_add(x, " -\n       %s", term + 2);
        *used = 6 + (size_t)n;
    } else {
        text_add(x, "%s", term);
        *used += (size_t)n;
    }
}

static size_t begin(text *x, const char *left, const char *first)
{
    text_add(x, "    %s = %s", left, first);
    return 4 + strlen(left) + 3 + strlen(first);
}

/* A_ij or, with j = -1, y_i: present value less the contributions of all joints beyond i */
static void reduced(text *x, const tree *t, int i, int j)
{
    char name[NAME], left[56], first[NAME], factor[NAME];
    if (j < 0) {
        right_side(t, i, name);
        snprintf(first, sizeof first, "b[%d]", i);
    } else {
        entry(t, i, j, name);
        snprintf(first, sizeof first, "M[%d]", i * t->n + j);
    }
    snprintf(left, sizeof left, "const stein_real %s", name);
    size_t used = begin(x, left, first);
    for (int k = i + 1; k < t->n; k++) {
        if (is_beyond(t, k, i)) {
            if (j < 0) {
                right_side(t, k, factor);
            } else {
                entry(t, k, j, factor);
            }
            minus(x, &used, k, i, factor);
        }
    }
    text_add(x, ";\n");
}

static void reduce_joint(text *x, const tree *t, int i)
{
    char pivot[NAME], above[NAME];
    text_quiet(x, "\n    /* %s */\n", text_safe(t->m->bodies[i].name));
    if (has_beyond(t, i)) {
        for (int j = i; j >= 0; j = t->body[j].parent) {
            reduced(x, t, i, j);
        }
        reduced(x, t, i, -1);
    }
    entry(t, i, i, pivot);
    text_add(x, "    STEIN_PIVOT(%s > ", pivot);
    text_add(x, has_beyond(t, i) ? "1e-13*M[%d]" : "0.0", i * t->n + i);
    text_add(x, ", %d)\n", i);
    for (int j = t->body[i].parent; j >= 0; j = t->body[j].parent) {
        entry(t, i, j, above);
        text_add(x, "    const stein_real L%d_%d = %s/%s;\n", i + 1, j + 1, above, pivot);
    }
}

void emit_solve(text *x, const tree *t)
{
    if (!emit_solves(t)) {
        return;
    }
    text_quiet(x, "/* M x = b: b becomes x. -1, or the joint whose pivot vanishes */\n");
    text_add(
        x, "static stein_solved solve(const stein_real *M, stein_real *b)\n{\n    STEIN_PIVOTS\n");
    for (int i = t->n - 1; i >= 0; i--) {
        reduce_joint(x, t, i);
    }
    text_quiet(x, "\n    /* from the root to the leaves */");
    text_add(x, "\n");
    for (int i = 0; i < t->n; i++) {
        char left[NAME], first[80], right[NAME], pivot[NAME], factor[NAME];
        right_side(t, i, right);
        entry(t, i, i, pivot);
        snprintf(left, sizeof left, "b[%d]", i);
        snprintf(first, sizeof first, "%s/%s", right, pivot);
        size_t used = begin(x, left, first);
        for (int j = t->body[i].parent; j >= 0; j = t->body[j].parent) {
            snprintf(factor, sizeof factor, "b[%d]", j);
            minus(x, &used, i, j, factor);
        }
        text_add(x, ";\n");
    }
    text_add(x, "    return STEIN_SOLVED;\n}\n\n");
}
