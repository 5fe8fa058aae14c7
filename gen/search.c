/* SPDX-License-Identifier: MIT
 * search.c - choose frames, pairs and gravity so that a function costs least.
 *
 * The recursion of dyn.c gives the same result whatever axes a body is worked out in, whichever
 * side of a joint the hinge arm is turned to, and so on. The number of operations differs by up to
 * a factor two. Building a graph takes less than a millisecond, so the choices are simply tried:
 * coordinate descent from a few starting points, within a budget of nodes. The result depends on
 * the structure of the mechanism alone, never on time, so that the text is the same on every run.
 */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

enum {
    BUDGET = 1000000, /* nodes built in all trials of one function */
    STARTS = 4        /* frames own or base, pairs or not */
};

typedef struct trial {
    const tree *t;
    builder *build;
    int nout;
    choice ch;
    int *frame;
    long spent;
    int failed;
} trial;

/* nameless: to be counted, not written */
static int build_func(func *f, const tree *t, const choice *ch, builder *build, int nout,
                      int *frame, int nameless)
{
    if (ex_graph_init(&f->g, t->setup)) {
        return -1;
    }
    f->g.nameless = nameless;
    f->nout = nout;
    f->out = calloc((size_t)nout + 1, sizeof *f->out);
    if (!f->out) {
        return -1;
    }
    walk w = {.t = t, .g = &f->g, .ch = ch, .frame = frame};
    build(&w, f->out);
    return f->g.failed || t->setup->failed ? -1 : ex_count(&f->g, f->out, nout, &f->ops);
}

int func_build(func *f, const tree *t, const choice *ch, builder *build, int nout, int *frame)
{
    return build_func(f, t, ch, build, nout, frame, 0);
}

void func_free(func *f)
{
    ex_graph_free(&f->g);
    free(f->out);
    free(f->chosen);
    f->out = NULL;
    f->chosen = NULL;
}

static long cost(trial *r)
{
    func f = {.out = NULL};
    long total = -1;
    if (build_func(&f, r->t, &r->ch, r->build, r->nout, r->frame, 1) == 0) {
        const stein_ops *o = &f.ops;
        total = o->add + o->mul + o->neg + DIV_COST * o->div + o->trig;
        total = total * 1024 + o->mul; /* of equal totals the candidate with fewer products */
    } else {
        r->failed = 1;
    }
    r->spent += f.g.n;
    func_free(&f);
    return total;
}

/** Try the other values of one choice and keep the best. @return 1 when it improved */
static int improve(trial *r, int *value, int nvalue, long *best)
{
    int kept = *value, tried = kept;
    for (int v = 0; v < nvalue && r->spent < BUDGET && !r->failed; v++) {
        if (v == tried) {
            continue;
        }
        *value = v;
        long c = cost(r);
        if (c >= 0 && c < *best) {
            *best = c;
            kept = v;
        }
    }
    *value = kept;
    return kept != tried;
}

static long descend(trial *r)
{
    const tree *t = r->t;
    long best = cost(r);
    for (int better = 1; better && r->spent < BUDGET && !r->failed;) {
        better = improve(r, &r->ch.gravity, 4, &best);
        better |= improve(r, &r->ch.split, 2, &best);
        for (int i = t->n - 1; i >= 0; i--) {
            const rbody *b = &t->body[i];
            int up = b->parent < 0 ? -1 : t->body[b->parent].orient;
            if (!b->turns) {
                continue;
            }
            better |= improve(r, &r->ch.frame[i], up == b->base ? 2 : 3, &best);
            if (up >= 0 && t->body[up].axis == b->axis) {
                better |= improve(r, &r->ch.near[i], 2, &best);
                better |= improve(r, &r->ch.pair[i], 2, &best);
            }
        }
    }
    return best;
}

static void start_from(trial *r, int point)
{
    int n = r->t->n;
    for (int i = 0; i < n; i++) {
        r->ch.frame[i] = (point & 1);
        r->ch.near[i] = !(point & 1);
        r->ch.pair[i] = (point >> 1 & 1);
    }
    r->ch.gravity = point >> 1 & 1;
    r->ch.split = 0;
}

static int keep_choice(func *f, size_t n, const choice *ch)
{
    f->chosen = malloc((3 * n + 2) * sizeof *f->chosen);
    if (!f->chosen) {
        return -1;
    }
    memcpy(f->chosen, ch->frame, 3 * n * sizeof *f->chosen);
    f->chosen[3 * n] = ch->gravity;
    f->chosen[3 * n + 1] = ch->split;
    return 0;
}

int func_search(func *f, const tree *t, builder *build, int nout)
{
    size_t n = (size_t)t->n;
    int status = -1;
    long best = -1;
    trial r = {.t = t, .build = build, .nout = nout};
    choice kept = {.frame = NULL};
    int *store = calloc(7 * n + 1, sizeof *store); /* current choices, the best ones, frames */
    if (!store) {
        return -1;
    }
    r.frame = store + 6 * n;
    r.ch = (choice){.frame = store, .near = store + n, .pair = store + 2 * n};
    for (int point = 0; point < STARTS && (point == 0 || r.spent < BUDGET / 2); point++) {
        start_from(&r, point);
        long c = descend(&r);
        if (c >= 0 && (best < 0 || c < best)) {
            best = c;
            memcpy(store + 3 * n, store, 3 * n * sizeof *store);
            kept = r.ch;
        }
    }
    if (best >= 0 && !r.failed) {
        memcpy(store, store + 3 * n, 3 * n * sizeof *store);
        r.ch = kept;
        status = func_build(f, t, &r.ch, build, nout, r.frame);
    }
    if (status == 0) {
        status = keep_choice(f, n, &r.ch);
    }
    free(store);
    return status;
}

int func_like(func *f, const tree *t, const func *other, builder *build, int nout)
{
    int *kept = other->chosen, n = t->n;
    choice ch = {.frame = kept,
                 .near = kept + n,
                 .pair = kept + 2 * (ptrdiff_t)n,
                 .gravity = kept[3 * n],
                 .split = kept[3 * n + 1]};
    int *frame = calloc((size_t)n + 1, sizeof *frame);
    int status = frame ? func_build(f, t, &ch, build, nout, frame) : -1;
    free(frame);
    return status;
}
