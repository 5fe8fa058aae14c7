/* SPDX-License-Identifier: GPL-3.0-or-later
 * added_parts.h - parts and degrees of freedom that a mechanism file may get.
 *
 *   yaml_edit.c      changes in the text of a mechanism file
 *   candidates.c     effects at places
 *   limits.c         their largest plausible sizes
 *   sites.c          where a part can sit
 *   alias.c          equivalent candidates
 *   added_parts.c    the parts
 *   bind.c           a candidate in a model
 *   contact_poses.c  relative pose of two bodies where they touch
 *   extend.c         the extended file
 *   change.c         what a cause changes in the file
 * Included by: this folder, src/lab.
 */
#ifndef ADDED_PARTS_H
#define ADDED_PARTS_H

#include "open.h"
#include "stein/diagnose.h"

/* ---- yaml_edit.c ---- */

/** Changes in the text of a YAML file; everything else in it is unchanged. */
typedef struct lab__yaml_edit lab__yaml_edit;
/** @param text  must outlive the edit. @return OK, EPARSE, ENOMEM */
stein_status lab__yaml_edit_begin(lab__yaml_edit **s, const char *text, size_t size,
                                  stein_err *err);
void lab__yaml_edit_end(lab__yaml_edit *s);
/** A new entry "name: value" at the beginning of a section, which is made when it is absent. Lines
 *  after the first are indented. @return OK, EINVAL (no such place), ENOMEM */
stein_status lab__yaml_edit_add(lab__yaml_edit *s, const char *section, const char *entry,
                                stein_err *err);
/** A new entry in the mapping at a path, "bodies/key". @return as above */
stein_status lab__yaml_edit_add_key(lab__yaml_edit *s, const char *path, const char *entry,
                                    stein_err *err);
/** The scalar at a path, NULL when there is none; list items are counted, ".../between/0". */
const char *lab__yaml_edit_get(const lab__yaml_edit *s, const char *path);
/** It becomes another one. @return 0, or -1 when there is no scalar or no memory */
int lab__yaml_edit_set(lab__yaml_edit *s, const char *path, const char *text);
/** Every value (not key, not `about`) that is exactly this becomes another one.
 *  @return how many, -1 without memory */
int lab__yaml_edit_swap(lab__yaml_edit *s, const char *old, const char *text);
/** The changed text, freed by the caller. @return OK, ENOMEM */
stein_status lab__yaml_edit_text(const lab__yaml_edit *s, char **text, size_t *size,
                                 stein_err *err);

/* ---- sites.c ---- */

/** In the x-z plane [m]. */
typedef struct lab__vec {
    double x, z;
} lab__vec;
lab__vec lab__at(const mech_scalar at[3]);
/** A place in a body's axes as drawn in the frame. */
lab__vec lab__drawn(const mechanism *m, int body, lab__vec at);

#define LAB__BEND \
    0.42 /* place where a link is likely to bend, as a share of the way to its children */

/** Where a link bends, and its part beyond. */
typedef struct lab__bent {
    lab__vec at, e; /* in the body's axes; e points to the part beyond */
    lab__vec link;  /* along e, up to the body's children; at is a share of it */
    lab__vec apart; /* the part's centre from that of the rest */
    double mass;    /* its share */
} lab__bent;
/** The share is LAB__BEND. @return 0, or -1 when the body has no such place */
int lab__bend(lab__bent *b, const mechanism *m, int body);
int lab__is_beyond(const lab__bent *b, lab__vec at);
/** A range by its lower end, its middle and its upper end, as one would write them on a drawing. */
void lab__set_range(lab_side *to, double lo, double middle, double hi);
/** Axis along which a line's normal points, ' ' when it is oblique. */
char lab__normal_axis(double facing);
/** The point where the load stands or the first input pushes, -1: none. */
int lab__load_point(const mechanism *m);

/** Where a part can sit. */
typedef struct lab__site {
    char place[MECH_NAME];
    int body;     /* that moves there */
    double reach; /* of the point in question from the body's joint [m] */
    int contact;  /* -1: none */
} lab__site;
enum { LAB_SITES = 32 };
/** Sites of a kind that needs a part. @return their number */
int lab__sites(const mechanism *m, const char *kind, lab__site site[LAB_SITES]);

/** The number with exactly the same effect as an armature of joint i: "inertia.yy" of its body if
 *  no other joint turns that, "mass" of a body that slides level on the frame. NULL: nothing. */
const char *lab__same_as_armature(const mechanism *m, int i);
/** Candidates [n] that are the same as an armature get its name as alias. */
void lab__note_armatures(lab_candidate *list, int n, const stein_model *m);

/* ---- added_parts.c ---- */

enum { LAB_NUMBERS = 1 + LAB_SIDES }; /* of a part: the amount and its side numbers */
/** Names and units of the numbers of a kind, NULL behind the last one.
 *  @return 0 when the kind needs no part */
int lab__structure_of(const char *kind, const char *name[LAB_NUMBERS],
                      const char *unit[LAB_NUMBERS]);
/** Name of the part. @return 0, or -1 when the kind needs none */
int lab__part_name(const char *kind, const char *place, char name[MECH_NAME]);
/** Is a number the amount of a part that a body of the model can be played without?
 *  @param m  with or without the part. @return its unit, NULL: it is not */
const char *lab__comes_off(const stein_model *m, const char *param);
/** Paths of these numbers in the extended model; [0] is "" when there is none. */
void lab__structure_names(const lab_candidate *c, char name[LAB_NUMBERS][LAB_PLACE]);
/** The text of a mechanism file with the part in it, freed by the caller.
 *  @param m       the mechanism of that text
 *  @param amount  of the effect; its other numbers come from the candidate
 *  @return OK, EINVAL (it cannot sit there), EPARSE, ENOMEM */
stein_status lab__structure_text(const lab_candidate *c, double amount, const mechanism *m,
                                 const char *text, size_t size, char **out, size_t *nout,
                                 stein_err *err);

/* ---- extend.c ---- */

/** The text of lab_extend, freed by the caller. @return as lab_extend */
stein_status lab__extended_text(char **text, const char *file, const lab_diagnosis *diagnosis,
                                stein_err *err);

/* ---- contact_poses.c ---- */

/** The first body of a contact against the second one, while they touch. */
typedef struct lab__touching {
    int touch;    /* they do */
    double c, s;  /* cosine and sine of its angle when they touched first */
    double turns; /* sine of the largest rotation from there */
    double depth; /* largest [m] */
} lab__touching;
/** In one run of the file; of one that fails nothing touches.
 *  @param to  [ncontact + nnotch], of a notch only touch and depth
 *  @return OK, ENOMEM, the statuses of stein_sim_create */
stein_status lab__touchings(lab__touching *to, const lab_model *model, stein_err *err);

/* ---- limits.c ---- */

/** Sources of limits, by joint [nq] and by channel [nchannel]; units of the joint. */
typedef struct lab__scales {
    double *weight, *spring, *energy, *speed, *travel, *length, *inertia, *range;
    double *room;     /* memory of all of them */
    double heaviness; /* of the whole tree [N] */
} lab__scales;
/** Largest plausible size of an effect; NAN: limits.c has no entry for its kind.
 *  @param j      joint
 *  @param value  of its parameter in the file */
double lab__joint_limit(const char *kind, const lab__scales *s, int j);
double lab__body_limit(const char *kind, const lab__scales *s, int j, double value);
double lab__contact_limit(const char *kind, const lab__scales *s, double value);
double lab__channel_limit(const char *kind, const lab__scales *s, int channel);
double lab__input_limit(const char *kind);

/* ---- candidates.c, alias.c ---- */

/** Strokes from which the scales of a mechanism are taken: run simulates some and shows each state.
 */
typedef struct lab__strokes {
    stein_status (*run)(void *ctx, stein_status (*look)(void *watch, stein_sim *sim), void *watch,
                        stein_err *err);
    void *ctx;
} lab__strokes;
/** lab_candidates where parameters p act: a share of an effect that was found is a candidate, too.
 *  @param strokes  NULL: one run with the file's own numbers */
stein_status lab__candidates_at(lab_candidate **list, int *n, const lab_model *model,
                                const double *p, const lab__strokes *strokes, stein_err *err);
/** Does a parameter belong to a table? One of its points moved alone is no law. */
int lab__is_in_table(const stein_model *m, const char *name);
/** Limit and numbers of a candidate at a link. */
void lab__size_link(lab_candidate *c, const stein_model *m, const double *p);
/** Is an effect a share of something that is not there with parameters p? */
int lab__is_share_of_nothing(const stein_model *m, const lab_effect *e, const char *place,
                             const double *p);
/** A model with the part of a candidate in it, beside all that another model has, and the candidate
 *  bound to it.
 *  @param file  of both
 *  @return OK, or a failure of what it is made of */
stein_status lab__candidate_open_in(lab_candidate *c, lab_model **out, const lab_model *in,
                                    const char *file, const lab_options *options, stein_err *err);
/** The mechanism of a file with the parts of those candidates that need one, one after the other.
 */
stein_status lab__open_with(lab_model **out, const char *file, const lab_candidate *list, int n,
                            const lab_options *options, stein_err *err);
/** lab_candidate_bind of an effect that is a parameter. */
stein_status lab__bind_parameters(lab_candidate *c, const lab_model *model, stein_err *err);
/** Leave out every candidate that has the direction of an earlier one, or no effect, and note the
 *  names. @return OK, ENOMEM */
stein_status lab__aliases(lab_candidate *list, int *n, const lab_model *model, stein_err *err);

/* ---- change.c ---- */

/** Fill in what a cause changes (lab_suspect.change).
 *  @param c      the same candidate, bound to the model of the file
 *  @param value  [nvalue] refitted numbers, which the amount moves */
void lab__note_changes(lab_suspect *s, const lab_candidate *c, const lab_model *model,
                       const lab_fit_value *value, int nvalue);

#endif
