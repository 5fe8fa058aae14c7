/* SPDX-License-Identifier: GPL-3.0-or-later
 * draw.c - random mechanisms, as numbers and as mechanism files.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "second.h"

static unsigned long long state;

/* even, in 0 .. 1 */
static double even(void)
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(state >> 11) * 0x1p-53;
}

static double within(double from, double to)
{
    return from + (to - from) * even();
}

static int below(int n)
{
    return (int)(even() * n);
}

static void place(const draw *d, double *p)
{
    for (int i = 0; i < 3; i++) {
        p[i] = d->planar && i == 1 ? 0.0 : within(-0.4, 0.4);
    }
}

/* of four points with masses, about their centre: an inertia that a body can have */
static void inertia(double mass, double *I)
{
    double p[4][3], centre[3] = {0.0};
    memset(I, 0, 6 * sizeof *I);
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 3; i++) {
            p[k][i] = within(-0.2, 0.2);
            centre[i] += 0.25 * p[k][i];
        }
    }
    for (int k = 0; k < 4; k++) {
        double x = p[k][0] - centre[0], y = p[k][1] - centre[1], z = p[k][2] - centre[2];
        double m = 0.25 * mass;
        double add[6] = {m * (y * y + z * z), m * (x * x + z * z), m * (x * x + y * y),
                         -m * x * y,          -m * x * z,          -m * y * z};
        for (int i = 0; i < 6; i++) {
            I[i] += add[i];
        }
    }
}

static void make_body(draw *d, int i)
{
    draw_body *b = &d->body[i];
    // chains more often than stars
    b->parent = i == 0 ? FRAME : even() < 0.6 ? i - 1 : below(i + 1) - 1;
    b->turns = even() < 0.75;
    b->axis = d->planar ? (b->turns ? 1 : 2 * below(2)) : below(3);
    b->sign = even() < 0.5 ? -1 : 1;
    b->mass = within(0.2, 2.0);
    place(d, b->at);
    place(d, b->centre);
    inertia(b->mass, b->inertia);
    if (d->planar) {
        b->inertia[3] = b->inertia[5] = 0.0;
    }
    if (even() < 0.4) {
        b->k = within(1.0, 20.0);
        b->rest = within(-0.5, 0.5);
        b->damping = within(0.0, 0.5);
    }
    b->q = b->turns ? within(-2.5, 2.5) : within(-0.3, 0.3);
    b->qd = within(-2.0, 2.0);
}

/* joints between two bodies */
static int joints_between(const draw *d, int a, int b)
{
    int n = 0;
    while (a != b) {
        int *last = a > b ? &a : &b; // a parent has a smaller number
        *last = d->body[*last].parent;
        n++;
    }
    return n;
}

static const int rows[2][KINDS] = {{3, 1, 2}, {2, 1, 1}}; /* in space, in the plane */

/* closed where the mechanism starts. @return conditions */
static int make_loop(draw *d, int free)
{
    draw_loop *l = &d->loop[d->nloop];
    double there[3];
    l->kind = (draw_kind)below(KINDS);
    l->a = below(d->n + 1) - 1;
    l->b = below(d->n);
    int n = rows[d->planar][l->kind];
    if (l->a == l->b || n >= free || joints_between(d, l->a, l->b) <= n) {
        return 0;
    }
    place(d, l->pa);
    memcpy(there, l->pa, sizeof there);
    if (l->kind == SLOT) {
        there[2] += within(-0.3, 0.3);
    } else if (l->kind == ROD) {
        double way[3];
        place(d, way);
        for (int i = 0; i < 3; i++) {
            there[i] += way[i];
            l->length += way[i] * way[i];
        }
        l->length = sqrt(l->length);
    }
    peer_place(d, l->a, there, l->b, l->pb);
    d->nloop++;
    return n;
}

static void make_coupling(draw *d)
{
    d->follows = below(d->n);
    d->joint = below(d->n);
    if (d->joint == d->follows) {
        d->joint = -1;
        return;
    }
    d->ratio = within(-3.0, 3.0);
    d->offset = d->body[d->joint].q - d->ratio * d->body[d->follows].q;
}

void draw_make(draw *d, int number)
{
    memset(d, 0, sizeof *d);
    state = 0x5eed0000ull + 977ull * (unsigned)number;
    for (int i = 0; i < 8; i++) {
        (void)even();
    }
    d->planar = number % 3 == 0;
    d->n = 1 + below(MOST_BODIES);
    d->joint = d->to = -1;
    for (int i = 0; i < d->n; i++) {
        make_body(d, i);
    }
    for (int i = 0; i < 3; i++) {
        d->gravity[i] = d->planar && i == 1 ? 0.0 : within(-10.0, 10.0);
    }
    if (d->n > 1 && even() < 0.4) {
        d->to = 1 + below(d->n - 1);
        d->from = below(d->to + 1) - 1;
        place(d, d->pfrom);
        place(d, d->pto);
        d->stiffness = within(5.0, 100.0);
        d->length = within(0.1, 0.5);
        d->damping = within(0.0, 2.0);
    }
    int free = d->n;
    if (d->n > 2 && even() < 0.25) {
        make_coupling(d);
        free -= d->joint >= 0;
    }
    double closed = even();
    for (int tries = 0; closed > 0.4 && tries < 20 && d->nloop < 1 + (closed > 0.8); tries++) {
        d->loop[d->nloop] = (draw_loop){.kind = MEET};
        free -= make_loop(d, free);
    }
}

/* ---- contacts ---- */

/* laws that the library has itself: the normal force of Hertz, Hunt & Crossley */
static void make_hertz(draw_contact *c)
{
    c->hertz = 1;
    c->dry = even() < 0.5;
    c->power = 0.5;
    c->linear = within(3e3, 3e4);
    c->vt = c->dry ? 1e-6 : 1e6;
    c->A = (c->dry ? 1.0 : c->vt) * within(0.1, 0.8);
}

static void make_law(draw_contact *c)
{
    c->cubic = within(0.0, 1e10);
    c->linear = within(3e3, 3e4);
    c->power = even() < 0.5 ? 0.0 : within(0.1, 1.5);
    c->vt = within(0.05, 0.5);
    c->A = within(0.1, 0.8);
    c->B1 = even() < 0.5 ? within(0.1, 0.8) : 0.0;
    c->B2 = within(0.1, 0.5);
}

static void direction(const draw *d, draw_contact *c)
{
    double size = 0.0;
    for (int i = 0; i < 3; i++) {
        c->n[i] = d->planar && i == 1 ? 0.0 : within(-1.0, 1.0);
        size += c->n[i] * c->n[i];
    }
    for (int i = 0; i < 3; i++) {
        c->n[i] /= sqrt(size);
    }
    c->facing = atan2(c->n[2], c->n[0]);
}

/* the surface of b lies where a's is pressed in by 0.1 to 1.5 mm */
static int make_contact(draw *d)
{
    draw_contact *c = &d->contact[d->ncontact];
    memset(c, 0, sizeof *c);
    c->a = below(d->n);
    c->b = below(d->n + 1) - 1;
    if (c->a == c->b) {
        return 0;
    }
    c->is_plane = even() < 0.6;
    (even() < 0.5 ? make_hertz : make_law)(c);
    c->ra = c->hertz || even() < 0.6 ? within(0.01, 0.1) : 0.0;
    c->rb = c->is_plane ? 0.0 : within(0.01, 0.1);
    c->D = within(0.0, 0.6);
    double apart = c->ra + c->rb - within(1e-4, 1.5e-3);
    place(d, c->pa);
    direction(d, c);
    peer_place(d, c->a, c->pa, c->b, c->pb);
    for (int i = 0; i < 3; i++) {
        c->pb[i] -= apart * c->n[i];
    }
    d->ncontact++;
    return 1;
}

void draw_touch(draw *d)
{
    int wanted = 1 + below(MOST_CONTACTS);
    for (int tries = 0; tries < 50 && d->ncontact < wanted; tries++) {
        (void)make_contact(d);
    }
}

/* ---- its file ---- */

static void write_three(FILE *f, const char *key, const double *p)
{
    fprintf(f, "%s: [%.17g, %.17g, %.17g]", key, p[0], p[1], p[2]);
}

/* the points of a body that loops and the spring hold on to */
static void write_points(FILE *f, const draw *d, int body)
{
    char key[40];
    const char *between = "";
    for (int i = 0; i < d->nloop; i++) {
        const draw_loop *l = &d->loop[i];
        if (l->a == body || l->b == body) {
            snprintf(key, sizeof key, "%sloop%d", between, i);
            write_three(f, key, l->a == body ? l->pa : l->pb);
            between = ", ";
        }
    }
    if (d->to >= 0 && (d->from == body || d->to == body)) {
        snprintf(key, sizeof key, "%sspring", between);
        write_three(f, key, d->from == body ? d->pfrom : d->pto);
        between = ", ";
    }
    for (int i = 0; i < d->ncontact; i++) {
        const draw_contact *c = &d->contact[i];
        if (c->a == body || (c->b == body && !c->is_plane)) {
            snprintf(key, sizeof key, "%stouch%d", between, i);
            write_three(f, key, c->a == body ? c->pa : c->pb);
            between = ", ";
        }
    }
}

static const char *name_of(char *text, int body)
{
    snprintf(text, 20, body < 0 ? "frame" : "body%d", body);
    return text;
}

static void write_body(FILE *f, const draw *d, int i)
{
    const draw_body *b = &d->body[i];
    char parent[20];
    fprintf(f, "  body%d:\n    parent: %s\n    joint: %s %s%c\n    ", i, name_of(parent, b->parent),
            b->turns ? "R" : "T", b->sign < 0 ? "-" : "", "xyz"[b->axis]);
    write_three(f, "at", b->at);
    fprintf(f, "\n    mass: %.17g\n    ", b->mass);
    write_three(f, "centre", b->centre);
    fprintf(
        f, "\n    inertia: {xx: %.17g, yy: %.17g, zz: %.17g, xy: %.17g, xz: %.17g, yz: %.17g}\n",
        b->inertia[0], b->inertia[1], b->inertia[2], b->inertia[3], b->inertia[4], b->inertia[5]);
    if (b->k > 0.0) {
        fprintf(f, "    spring: {k: %.17g, %s: %.17g}\n    damping: %.17g\n", b->k,
                b->turns ? "theta0" : "x0", b->rest, b->damping);
    }
    fprintf(f, "    initial: {position: %.17g, speed: %.17g}\n    points: {", b->q, b->qd);
    write_points(f, d, i);
    fprintf(f, "}\n");
}

static void write_loops(FILE *f, const draw *d)
{
    char a[20], b[20];
    fprintf(f, "loops:\n");
    for (int i = 0; i < d->nloop; i++) {
        const draw_loop *l = &d->loop[i];
        fprintf(f, "  loop%d: {between: [%s.loop%d, %s.loop%d]", i, name_of(a, l->a), i,
                name_of(b, l->b), i);
        if (l->kind == ROD) {
            fprintf(f, ", rod: %.17g", l->length);
        }
        fprintf(f, "%s}\n", l->kind == SLOT ? ", slot: z" : "");
    }
}

static void write_round(FILE *f, const draw *d, int contact, int body, double radius)
{
    char name[20];
    name_of(name, body);
    if (radius > 0.0) {
        fprintf(f, "{%s: {at: %s.touch%d, radius: %.17g}}", d->planar ? "circle" : "sphere", name,
                contact, radius);
    } else {
        fprintf(f, "{point: %s.touch%d}", name, contact);
    }
}

static void write_contact(FILE *f, const draw *d, int i)
{
    const draw_contact *c = &d->contact[i];
    char name[20];
    fprintf(f, "  touch%d:\n    between: [", i);
    write_round(f, d, i, c->a, c->ra);
    fprintf(f, ", ");
    if (!c->is_plane) {
        write_round(f, d, i, c->b, c->rb);
    } else {
        fprintf(f, "{%s: {on: %s, ", d->planar ? "line" : "plane", name_of(name, c->b));
        write_three(f, "at", c->pb);
        if (d->planar) {
            fprintf(f, ", facing: %.17g}}", c->facing);
        } else {
            write_three(f, ", normal", c->n);
            fprintf(f, "}}");
        }
    }
    fprintf(f, "]\n    normal: {a: %.17g, c: %.17g, p: %.17g, D: %.17g}\n", c->cubic, c->linear,
            c->power, c->D);
    fprintf(f, "    friction: {A: %.17g, vt: %.17g, B1: %.17g, B2: %.17g}\n", c->A, c->vt, c->B1,
            c->B2);
}

int draw_write(const draw *d, const char *name, const char *path)
{
    char a[20], b[20];
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        return -1;
    }
    fprintf(f, "mechanism: %s\n", name);
    write_three(f, "gravity", d->gravity);
    fprintf(f, "\nbodies:\n");
    for (int i = 0; i < d->n; i++) {
        write_body(f, d, i);
    }
    fprintf(f, "points: {");
    write_points(f, d, FRAME);
    fprintf(f, "}\n");
    if (d->nloop > 0) {
        write_loops(f, d);
    }
    if (d->joint >= 0) {
        fprintf(
            f,
            "couplings:\n  gear: {joint: body%d, follows: body%d, ratio: %.17g, offset: %.17g}\n",
            d->joint, d->follows, d->ratio, d->offset);
    }
    if (d->to >= 0) {
        fprintf(f,
                "links:\n  spring: {from: %s.spring, to: %s.spring, k: %.17g, length: %.17g, "
                "damping: %.17g}\n",
                name_of(a, d->from), name_of(b, d->to), d->stiffness, d->length, d->damping);
    }
    for (int i = 0; i < d->ncontact; i++) {
        fprintf(f, "%s", i == 0 ? "contacts:\n" : "");
        write_contact(f, d, i);
    }
    fprintf(f, "simulation: {dt: 1 ms, until: 1 s}\n");
    return fclose(f) == 0 ? 0 : -1;
}
