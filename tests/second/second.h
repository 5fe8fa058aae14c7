/* SPDX-License-Identifier: GPL-3.0-or-later
 * second.h - a second opinion: accelerations of random mechanisms here and in Simbody (`make
 * second`), and motions of those with contacts.
 *
 *   draw.c     a random mechanism, as numbers and as a mechanism file
 *   peer.cpp   the same numbers as a system of Simbody
 *   main.c     the file opened, its accelerations compared with the peer's
 *
 * The two sides have the numbers in common and nothing else. A body hangs on its parent by one
 * joint; at q = 0 all axes are parallel.
 */
#ifndef SECOND_H
#define SECOND_H

#ifdef __cplusplus
extern "C" {
#endif

enum { MOST_BODIES = 12, MOST_LOOPS = 2, MOST_CONTACTS = 3, FRAME = -1 };

typedef struct draw_body {
    int parent; /* FRAME: none */
    int turns;  /* revolute, or prismatic */
    int axis, sign;
    double at[3]; /* of the joint, in the parent's axes */
    double mass, centre[3];
    double inertia[6];       /* about the centre: xx yy zz xy xz yz */
    double k, rest, damping; /* spring and damper of the joint; 0: none */
    double q, qd;            /* where it starts */
} draw_body;

typedef enum draw_kind { MEET, ROD, SLOT, KINDS } draw_kind;

/** A loop: the point pb of b where the point pa of a is, at the distance of a rod from it, or on
 * the line through it along z of a. */
typedef struct draw_loop {
    draw_kind kind;
    int a, b;
    double pa[3], pb[3], length;
} draw_loop;

/** A contact: a sphere at pa of a (a point where ra is 0) on the plane of b through pb with the
 * normal n, or on a sphere at pb; in the plane circles and lines. Forces are
 *
 *      f_n = [(cubic x^2 + linear) x] (x / 0.1 mm)^power (1 + D xdot)       but >= 0
 *      f_t = f_n A (tanh u + B1 u / (1 + B2 u^4)),     u = v / vt
 *
 * and with `hertz` the ones that the library has itself: x^(3/2), and either a friction that grows
 * with the speed, of which tanh u = u is left, or a dry one, for which tanh u = 1. */
typedef struct draw_contact {
    int a, b, is_plane;
    double pa[3], ra, pb[3], rb, n[3], facing;
    double cubic, linear, power, D, A, vt, B1, B2;
    int hertz, dry;
} draw_contact;

typedef struct draw {
    int n, planar, nloop, ncontact;
    draw_contact contact[MOST_CONTACTS];
    draw_body body[MOST_BODIES];
    draw_loop loop[MOST_LOOPS];
    int joint, follows; /* a coupling q_joint = ratio q_follows + offset; joint -1: none */
    double ratio, offset;
    int from, to; /* bodies of a spring and damper between two points; to -1: none */
    double pfrom[3], pto[3], stiffness, length, damping;
    double gravity[3];
} draw;

/** Mechanism of a number; the same one whenever. */
void draw_make(draw *d, int number);
/** One to three contacts more, which touch where the mechanism starts. */
void draw_touch(draw *d);
/** Its file. @return 0, or -1 when it cannot be written */
int draw_write(const draw *d, const char *name, const char *path);

/** Point p of a body (FRAME: of the frame) in the axes of another one, at the positions of the
 *  draw, without loops. */
void peer_place(const draw *d, int body, const double *p, int in, double *out);
/** What the peer says of a state. */
typedef struct peer_state {
    double qdd[MOST_BODIES];
    double open;      /* largest error of loops and couplings, of positions and speeds */
    double condition; /* of G M^-1 G', G their Jacobian, but for what is rounding; 1: none */
} peer_state;
/** Where a motion from q and qd is after a time, by the library's own integrator.
 *  @param q, qd  [n] out too  @return 0, or -1 with what the library said in text [size] */
int peer_move(const draw *d, double time, double *q, double *qd, char *text, int size);
/** @return 0, or -1 with what the library said in text [size] */
int peer_look(const draw *d, const double *q, const double *qd, peer_state *out, char *text,
              int size);

#ifdef __cplusplus
}
#endif
#endif
