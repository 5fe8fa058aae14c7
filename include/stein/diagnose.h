/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.h - physical effects that a mechanism may lack, and where each could sit. Part of
 * libsteinlab.a.
 *
 * One table holds every kind of effect: its equation, what it looks like, the parameter that
 * switches it on. A candidate is a kind at a place of one mechanism. All laws have all terms
 * (law.h), so most candidates are a parameter moved away from its neutral value, without new
 * equations.
 */
#ifndef STEIN_DIAGNOSE_H
#define STEIN_DIAGNOSE_H

#include "stein/lab.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Where a kind of effect can sit. */
typedef enum {
    LAB_AT_JOINT,    /* every body's joint, the load's excepted */
    LAB_AT_BODY,     /* every body, the load excepted */
    LAB_AT_CONTACT,  /* every contact, the load's included */
    LAB_AT_SURFACE,  /* contacts and notches */
    LAB_AT_LOAD,     /* the free load */
    LAB_AT_INPUT,    /* every input */
    LAB_AT_CHANNEL,  /* every output that shows a place or a force */
    LAB_AT_MARKER,   /* every output that shows a point */
    LAB_AT_CLOCK,    /* the recorder */
    LAB_AT_PARAMETER /* every other number of the file */
} lab_site;

/** How the amount a of an effect moves its parameters from their present values v. */
typedef enum {
    LAB_MOVE_ADD,      /* v + a */
    LAB_MOVE_RELATIVE, /* v (1 + a) */
    LAB_MOVE_SCALE,    /* v exp(a), of all parameters alike */
    LAB_MOVE_SPRING    /* k + a, and theta0 such that k theta0 stays: a torque -a q */
} lab_move;

/** One kind of effect. */
typedef struct lab_effect {
    const char *kind; /* stable name */
    const char *cls;  /* missing_effect, wrong_parameter, sensor, input */
    lab_site site;
    const char *size;      /* name of its amount */
    const char *parameter; /* path behind the place, "%.damping"; NULL with `needs` */
    const char *side;      /* a second parameter that it needs, NULL: none */
    const char *equation, *looks;
    const char *twins; /* kinds that data often cannot tell from it; "" none */
    const char *needs; /* "structure": not a parameter; listed, not scored. NULL: nothing */
    int both_signs;
    int sampled; /* acts when channels are sampled, not in the motion */
} lab_effect;

/** The table; n out. Kinds are unique. */
const lab_effect *lab_effects(int *n);
/** By kind, NULL when there is none. */
const lab_effect *lab_effect_find(const char *kind);
/** "joint", "body", "contact" ... */
const char *lab_site_text(lab_site site);

enum { LAB_MOVED = 3, LAB_PLACE = 100 };

/** A kind of effect at a place of a mechanism. */
typedef struct lab_candidate {
    const lab_effect *effect;
    char place[LAB_PLACE]; /* "hammer", "string", "key_dip", "clock", "pawl.corner.x" */
    lab_move move;
    int nparam, param[LAB_MOVED]; /* of the model; the first one names the effect */
    int side;                     /* parameter of the second number, -1: none */
    double side_value, side_lo, side_hi;
    const char *unit;   /* of the amount */
    double limit;       /* plausible largest amount */
    double start;       /* first secant, a share of the limit */
    int joint, channel; /* that it sits at, -1: none */
} lab_candidate;

/** All candidates of a mechanism, from its own structure. Limits follow from its weights, springs
 * and from one run with the file's own numbers. Effects with `needs` have none.
 *  @param list  out, freed by the caller with free()
 *  @return OK, ENOMEM, numerical failures of that run */
stein_status lab_candidates(lab_candidate **list, int *n, const lab_model *model, stein_err *err);
/** Move the parameters p [np] of the equations by an amount; 0 leaves them bit for bit. */
void lab_candidate_apply(const lab_candidate *candidate, double amount, double *p);

#ifdef __cplusplus
}
#endif
#endif
