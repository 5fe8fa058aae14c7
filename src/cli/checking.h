/* SPDX-License-Identifier: GPL-3.0-or-later
 * checking.h - shared by the files of stein check.
 * Included by: this folder.
 */
#ifndef CLI_CHECKING_H
#define CLI_CHECKING_H

#include "cli.h"

/* the checked files: the file, and the operation counts of its equations */
typedef struct checked {
    const mechanism *m;
    const gen_result *g;
} checked;

/* ---- check_words.c ---- */

/** The generated functions in the order they are listed; the first ones always are. */
enum { COUNTED = 12, ALWAYS = 4 };
extern const char *const check__counted_key[COUNTED], *const check__counted_note[COUNTED];

const char *check__body_name(const mechanism *m, int body);
int check__number_of_bodies(const mechanism *m);
int check__tree_freedom(const mechanism *m);
const char *check__parent_name(const mechanism *m, int body);
const char *check__joint_text(char text[8], const mech_body *b);
const char *check__shape_text(const mech_shape *s);
const char *check__input_target(const mechanism *m, const mech_input *in);
const char *check__input_kind(int kind);
const char *check__target_or_all(const mechanism *m, const mech_channel *c);
const char *check__output_kind(int read);
stein_ops check__counted(const gen_result *g, int i);
int check__acts(const mech_scalar *law, int entry);
const char *check__friction_text(const mech_scalar *law, int level, int sticks);
const char *check__table_of(const mech_table *t);
const char *check__table_place(const mechanism *m, const mech_table *t);

/* ---- check_json.c ---- */

/** The object, with DATA also their audit. @return exit status */
int check__json(const checked *c, const cli_args *args);

#endif
