/* SPDX-License-Identifier: MIT
 * emit.c - lines of the functions of the emitted file: single assignments in the order of the
 * derivation.
 *
 * A node becomes a line when it has a symbol of the derivation or is used more than once; the rest
 * is written where it is used. Lines follow the order in which the recursion first needed them,
 * under a heading that names the pass and the body; sines and cosines come first. Those of the
 * joints are arguments: sc[2 j] and sc[2 j + 1] of joint j.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "printer.h"

enum { WIDTH = 100 };

/* ---- expressions ---------------------------------------------------------------------------- */

static void print_expr(text *o, const printer *p, ex e, int level);

int print_is_given(const printer *p, ex e)
{
    const ex_node *nd = &p->g->node[e];
    return p->g->setup && (nd->op == EX_SIN || nd->op == EX_COS);
}

static void print_binary(text *o, const printer *p, const ex_node *nd, int level)
{
    static const char *const sign[] = {
        [EX_ADD] = " + ", [EX_SUB] = " - ", [EX_MUL] = "*", [EX_DIV] = "/"};
    int own = nd->op == EX_MUL || nd->op == EX_DIV ? 2 : 1;
    text_add(o, "%s", own < level ? "(" : "");
    print_expr(o, p, nd->a, own);
    text_add(o, "%s", sign[nd->op]);
    print_expr(o, p, nd->b, own + 1);
    text_add(o, "%s", own < level ? ")" : "");
}

static void print_number(text *o, double value)
{
    char number[32];
    if (isinf(value)) {
        text_add(o, "HUGE_VAL");
        return;
    }
    text_number(number, value);
    text_add(o, "%s", number);
}

/** level: 1 sum, 2 product, 3 factor. */
static void print_expr(text *o, const printer *p, ex e, int level)
{
    const ex_node *nd = &p->g->node[e];
    static const char *const fun[] = {
        [EX_SIN] = "sin", [EX_COS] = "cos", [EX_TAN] = "tan", [EX_SQRT] = "sqrt"};
    if (p->symbol[e][0]) {
        text_add(o, "%s", p->symbol[e]);
    } else if (nd->op == EX_NUM) {
        print_number(o, nd->value);
    } else if (print_is_given(p, e)) {
        text_add(o, "sc[%d]", 2 * p->g->node[nd->a].b + (nd->op == EX_COS));
    } else if (nd->op == EX_NEG) {
        text_add(o, "%s-", level > 1 ? "(" : "");
        print_expr(o, p, nd->a, 2);
        text_add(o, "%s", level > 1 ? ")" : "");
    } else if (nd->op >= EX_ADD && nd->op <= EX_DIV) {
        print_binary(o, p, nd, level);
    } else {
        text_add(o, "%s%s(", p->x && nd->op != EX_SQRT ? "f->" : "", fun[nd->op]);
        print_expr(o, p, nd->a, 0);
        text_add(o, ")");
    }
}

/** "    left = expression;" broken at blanks to the width of a page. */
static void print_line(const printer *p, const char *left, ex e, const char *comment)
{
    text o;
    text_init(&o);
    text_add(&o, "    %s = ", left);
    if (p->symbol[e][0] && strncmp(left, "const", 5) == 0) { /* a line defines itself */
        char kept[SYMBOL];
        memcpy(kept, p->symbol[e], sizeof kept);
        p->symbol[e][0] = '\0';
        print_expr(&o, p, e, 0);
        memcpy(p->symbol[e], kept, sizeof kept);
    } else {
        print_expr(&o, p, e, 0);
    }
    text_add(&o, ";");
    p->x->failed |= o.failed;
    char *s = o.s;
    for (size_t room = WIDTH; s && strlen(s) > room; room = WIDTH - 8) {
        size_t cut = room;
        while (cut > 8 && s[cut] != ' ') {
            cut--;
        }
        if (cut <= 8) {
            break;
        }
        text_add(p->x, "%.*s\n        ", (int)cut, s);
        s += cut + 1;
    }
    text_add(p->x, "%s", s ? s : "");
    text_quiet(p->x, "%s%s%s", comment[0] ? " /* " : "", comment, comment[0] ? " */" : "");
    text_add(p->x, "\n");
    free(o.s);
}

/* ---- symbols -------------------------------------------------------------------------------- */

static unsigned symbol_hash(const char *s)
{
    unsigned h = 2166136261u;
    for (; *s; s++) {
        h = (h ^ (unsigned char)*s) * 16777619u;
    }
    return h;
}

/** Make the symbol of node e unique within its function. */
static void claim(printer *p, ex e, const char *wanted)
{
    char name[SYMBOL];
    for (int again = 0;; again++) {
        if (again) {
            snprintf(name, sizeof name, "%.24s_v%d", wanted, again + 1);
        } else {
            snprintf(name, sizeof name, "%.24s", wanted);
        }
        unsigned at = symbol_hash(name) % (unsigned)p->ntaken;
        while (p->taken[at] >= 0 && strcmp(p->symbol[p->taken[at]], name) != 0) {
            at = (at + 1) % (unsigned)p->ntaken;
        }
        if (p->taken[at] < 0) {
            p->taken[at] = e;
            memcpy(p->symbol[e], name, sizeof name);
            return;
        }
    }
}

static void leaf_symbol(printer *p, ex e)
{
    static const char *const var[EX_NVAR] = {"p", "q",  "qd", "qdd", "frc", "trq",
                                             "Q", "dp", "dq", "dqd", "dd"};
    const ex_node *nd = &p->g->node[e];
    char name[SYMBOL];
    if (nd->op == EX_VAR) {
        snprintf(p->symbol[e], SYMBOL, "%s[%d]", var[nd->a],
                 nd->a == EX_DD ? layout_find(p->l, nd->b) : nd->b);
    } else if (nd->op == EX_CONST) {
        const ex_node *k = &p->t->setup->node[nd->a];
        int at = layout_find(p->l, nd->a);
        if (k->op == EX_NUM) {
            text o;
            text_init(&o);
            print_number(&o, k->value);
            snprintf(p->symbol[e], SYMBOL, "%s", o.failed ? "none" : o.s);
            p->x->failed |= o.failed;
            free(o.s);
            return;
        }
        if (k->name[0]) {
            snprintf(name, sizeof name, "%s", k->name);
        } else {
            snprintf(name, sizeof name, k->op == EX_VAR ? "p%d" : "k%d",
                     k->op == EX_VAR ? k->b : at);
        }
        claim(p, e, name);
    }
}

int printer_init(printer *p, const ex *out, int nout)
{
    size_t n = (size_t)p->g->n;
    p->ntaken = 2 * p->g->n + 16;
    p->uses = malloc(n * sizeof *p->uses);
    p->line = calloc(n, 1);
    p->symbol = calloc(n, sizeof *p->symbol);
    p->taken = malloc((size_t)p->ntaken * sizeof *p->taken);
    if (!p->uses || !p->line || !p->symbol || !p->taken) {
        p->x->failed = 1;
        return -1;
    }
    memset(p->taken, -1, (size_t)p->ntaken * sizeof *p->taken);
    ex_reach(p->g, out, nout, p->uses);
    for (int i = 1; i < p->g->n; i++) {
        if (p->uses[i] && print_is_given(p, i)) {
            p->uses[p->g->node[i].a]--; /* it is not read from q */
        }
    }
    int unnamed = 0;
    for (int i = 1; i < p->g->n; i++) {
        const ex_node *nd = &p->g->node[i];
        char name[SYMBOL];
        if (!p->uses[i]) {
            continue;
        }
        if (nd->op <= EX_CONST) {
            leaf_symbol(p, i);
        } else if (nd->name[0] || (p->uses[i] > 1 && nd->op != EX_NEG)) {
            snprintf(name, sizeof name, "t%d", nd->name[0] ? 0 : ++unnamed);
            claim(p, i, nd->name[0] ? nd->name : name);
            p->line[i] = 1;
        }
    }
    return 0;
}

void printer_free(printer *p)
{
    free(p->uses);
    free(p->line);
    free(p->symbol);
    free(p->taken);
}

/* ---- setup ---------------------------------------------------------------------------------- */

/** Words for a recombined parameter, by the symbol that name_constants (recombine.c) gave it. */
static int recombined(const tree *t, const char *symbol, text *o)
{
    static const struct {
        const char *prefix, *words;
        int digits;
    } kinds[] = {{"mb", "first moment %.2s of %s", 1},
                 {"dpt", "hinge arm %.2s of %s", 1},
                 {"K", "inertia %.2s of %s", 2},
                 {"l", "centre of mass %.2s of %s", 1},
                 {"m", "mass%.0s of %s", 0}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        size_t n = strlen(kinds[i].prefix) + (size_t)kinds[i].digits;
        char component[3] = "";
        if (strncmp(symbol, kinds[i].prefix, strlen(kinds[i].prefix)) == 0 && strlen(symbol) > n) {
            long body = strtol(symbol + n, NULL, 10);
            if (body < 1 || body > t->n) {
                return 0;
            }
            memcpy(component, symbol + n - kinds[i].digits, (size_t)kinds[i].digits);
            text_add(o, kinds[i].words, component, text_safe(t->m->bodies[body - 1].name));
            text_add(o, "%s",
                     kinds[i].prefix[0] == 'm' || kinds[i].prefix[0] == 'K' ? ", recombined" : "");
            return 1;
        }
    }
    return 0;
}

/** What a constant is, for comments: in words, or its formula over parameter names; cut to `room`.
 */
static void describe(text *x, const tree *t, const layout *l, ex node, int room, char out[96])
{
    text o;
    printer p = {.t = t, .l = l, .g = t->setup};
    text_init(&o);
    p.symbol = calloc((size_t)p.g->n, sizeof *p.symbol);
    int *uses = malloc((size_t)p.g->n * sizeof *uses);
    out[0] = '\0';
    if (p.symbol && uses && !recombined(t, p.g->node[node].name, &o)) {
        ex_reach(p.g, &node, 1, uses);
        for (int i = 1; i <= node; i++) {
            const ex_node *nd = &p.g->node[i];
            if (uses[i] && nd->op == EX_VAR) {
                snprintf(p.symbol[i], SYMBOL, "%.47s", text_safe(t->m->params[nd->b].name));
            } else if (uses[i] && nd->name[0] && i != node) {
                snprintf(p.symbol[i], SYMBOL, "%s", nd->name);
            }
        }
        print_expr(&o, &p, node, 0);
    }
    x->failed |= !p.symbol || !uses || o.failed;
    int cut = o.n > (size_t)room;
    snprintf(out, 96, "%.*s%s", cut ? room - 4 : room, o.s ? o.s : "", cut ? " ..." : "");
    free(o.s);
    free(uses);
    free(p.symbol);
}

void emit_setup(text *x, const tree *t, const layout *l, stein_ops *ops)
{
    printer p = {.x = x, .t = t, .l = l, .g = t->setup};
    ex *out = calloc((size_t)l->n + 1, sizeof *out);
    int used = 0, turned = 0;
    if (!out) {
        x->failed = 1;
        return;
    }
    for (int i = 0; i < l->n; i++) {
        out[i] = l->slot[i].node;
    }
    x->failed |= ex_count(t->setup, out, l->n, ops) != 0;
    if (printer_init(&p, out, l->n) == 0) {
        text_add(x,
                 "#if STEIN_LANES == 1\nstatic %svoid setup(const double *p, double *d, "
                 "const stein_functions *f)\n{\n",
                 l->n > GEN_LONG ? "STEIN_SELDOM " : "");
        for (int i = 1; i < p.g->n; i++) {
            char left[80];
            used |= p.uses[i] && p.g->node[i].op == EX_VAR;
            turned |= p.uses[i] && p.g->node[i].op >= EX_SIN && p.g->node[i].op <= EX_TAN;
            if (p.line[i]) {
                snprintf(left, sizeof left, "const double %s", p.symbol[i]);
                print_line(&p, left, i, "");
            }
        }
        text_add(x, "%s%s", used ? "" : "    (void)p;\n", turned ? "" : "    (void)f;\n");
        for (int i = 0; i < l->n; i++) {
            char left[24], what[96] = "";
            snprintf(left, sizeof left, "d[%d]", i);
            if (i >= l->equations && p.symbol[out[i]][0]) {
                describe(x, t, l, out[i], 70, what);
            }
            print_line(&p, left, out[i], i < l->equations ? l->slot[i].legend : what);
        }
        text_add(x, "%s}\n#endif\n\n", l->n ? "" : "    (void)d;\n");
    }
    printer_free(&p);
    free(out);
}

/** What is not derived by dp is 0, and most of d is. */
static void print_along(printer *p, const ex *out)
{
    int used = 0, moves = 0, turned = 0;
    for (int i = 1; i < p->g->n; i++) {
        const ex_node *nd = &p->g->node[i];
        used |= p->uses[i] && nd->op == EX_VAR && nd->a == EX_P;
        moves |= p->uses[i] && nd->op == EX_VAR && nd->a == EX_DP;
        turned |= p->uses[i] && nd->op >= EX_SIN && nd->op <= EX_TAN;
    }
    text_add(p->x, "%s%s%s", used ? "" : "    (void)p;\n", moves ? "" : "    (void)dp;\n",
             turned ? "" : "    (void)f;\n");
    for (int i = 1; i < p->g->n; i++) {
        char left[80];
        if (p->line[i]) {
            snprintf(left, sizeof left, "const double %s", p->symbol[i]);
            print_line(p, left, i, "");
        }
    }
    text_add(p->x, "    for (int i = 0; i < %d; i++) {\n        dd[i] = 0.0;\n    }\n", p->l->n);
    for (int i = 0; i < p->l->n; i++) {
        char left[24];
        snprintf(left, sizeof left, "dd[%d]", i);
        if (out[i] != 0) {
            print_line(p, left, out[i], "");
        }
    }
}

void emit_setup_along(text *x, const tree *t, const layout *l)
{
    ex *out = calloc((size_t)l->n + 1, 2 * sizeof *out);
    if (!out) {
        x->failed = 1;
        return;
    }
    ex *slope = out + l->n + 1;
    for (int i = 0; i < l->n; i++) {
        out[i] = l->slot[i].node;
    }
    derive_along(t->setup, out, l->n, slope);
    printer p = {.x = x, .t = t, .l = l, .g = t->setup};
    x->failed |= t->setup->failed;
    if (!x->failed && printer_init(&p, slope, l->n) == 0) {
        text_quiet(x, "/* derived constants along a direction of parameters */\n");
        text_add(x,
                 "static %svoid setup_along(const double *p, const double *dp, double *dd,\n"
                 "                        const stein_functions *f)\n{\n",
                 l->n > GEN_LONG ? "STEIN_SELDOM " : "");
        print_along(&p, slope);
        text_add(x, "}\n\n");
    }
    printer_free(&p);
    free(out);
}

/* ---- functions ------------------------------------------------------------------------------ */

void print_heading(const printer *p, int pass, int body)
{
    static const char *const what[PASS_COUNT] = {"",
                                                 "trigonometric terms",
                                                 "forward kinematics",
                                                 "backward dynamics",
                                                 "composite bodies",
                                                 "articulated bodies",
                                                 "accelerations",
                                                 "point",
                                                 "by the position",
                                                 "by the speed",
                                                 "along the direction",
                                                 "loop",
                                                 "outputs"};
    const char *name = body < 0             ? ""
                       : pass == PASS_POINT ? text_safe(p->t->m->points[body].name)
                       : pass == PASS_LOOP  ? text_safe(p->t->m->loops[body].name)
                                            : text_safe(p->t->m->bodies[body].name);
    text_quiet(p->x, "\n    /* %s%s%s */\n", what[pass], *name ? ": " : "", name);
}

void print_node(const printer *p, ex e)
{
    char left[80];
    snprintf(left, sizeof left, "const %s %s", p->type, p->symbol[e]);
    print_line(p, left, e, "");
}

void print_constants(const printer *p, const int *stamp, int part)
{
    int *node = calloc((size_t)p->l->n + 1, sizeof *node);
    p->x->failed |= !node;
    for (int i = 1; node && i < p->g->n; i++) {
        const ex_node *nd = &p->g->node[i];
        if (p->uses[i] && nd->op == EX_CONST && p->t->setup->node[nd->a].op != EX_NUM &&
            stamp[i] == part) {
            node[layout_find(p->l, nd->a)] = i;
        }
    }
    for (int i = 0; node && i < p->l->n; i++) {
        char line[96], what[96];
        if (node[i]) {
            int n =
                snprintf(line, sizeof line, "const %s %s = d[%d];", p->type, p->symbol[node[i]], i);
            describe(p->x, p->t, p->l, p->g->node[node[i]].a, WIDTH - 11 - n, what);
            text_add(p->x, "    %s", line);
            text_quiet(p->x, " /* %s */", what);
            text_add(p->x, "\n");
        }
    }
    free(node);
}

void print_unused(const printer *p, const emission *e)
{
    int seen[EX_NVAR + 2] = {0};
    for (int i = 1; i < p->g->n; i++) {
        const ex_node *nd = &p->g->node[i];
        if (p->uses[i] && nd->op == EX_VAR) {
            seen[nd->a] = 1;
        }
        if (p->uses[i] && nd->op == EX_CONST && p->t->setup->node[nd->a].op != EX_NUM) {
            seen[EX_NVAR] = 1;
        }
        seen[EX_NVAR + 1] |= p->uses[i] && print_is_given(p, i);
    }
    for (int i = 0; i <= EX_NVAR + 1; i++) {
        if (e->unused[i] && !seen[i]) {
            text_add(p->x, "    (void)%s;\n", e->unused[i]);
        }
    }
}

static int is_number(const printer *p, ex e)
{
    const ex_node *nd = &p->g->node[e];
    return e == 0 || nd->op == EX_NUM ||
           (nd->op == EX_CONST && p->t->setup->node[nd->a].op == EX_NUM);
}

/** "    left = number;", in lanes the same one in all of them */
static void print_all(const printer *p, const char *left, ex e)
{
    int lanes = strcmp(p->type, "double") != 0;
    text_add(p->x, "    %s = %s", left, lanes ? "STEIN_ALL(" : "");
    if (e == 0) {
        text_add(p->x, "0.0");
    } else {
        print_expr(p->x, p, e, 0);
    }
    text_add(p->x, "%s;\n", lanes ? ")" : "");
}

void print_output(const printer *p, const func *f, const emission *e, int i)
{
    char left[64];
    e->target(p->t, i, left);
    if (f->out[i] == 0 && e->stays && e->stays(p->t, i)) {
        text_add(p->x, "    STEIN_ZERO(%s);\n", left);
    } else if (is_number(p, f->out[i])) {
        print_all(p, left, f->out[i]);
    } else {
        print_line(p, left, f->out[i], "");
    }
}
