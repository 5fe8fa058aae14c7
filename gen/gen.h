/* SPDX-License-Identifier: MIT
 * gen.h - the generator as a library: a mechanism in, flat C and operation counts out.
 * Included by: this folder, src/lab/open.
 */
#ifndef GEN_H
#define GEN_H

#include <stddef.h>

#include "mechanism.h"
#include "stein/model.h"

/** Result of a generation. */
typedef struct gen_result {
    char *source;       /* complete text of one C file, NUL-terminated, owned */
    size_t size;        /* its length in bytes */
    char equations[17]; /* hash that identifies the equations: independent of parameter values,
                           tolerances, comments and file name; equal to stein_model.equations */
    stein_ops setup, mass_bias, unloaded, inverse, pose, point, energy, slopes, along,
        closure, /* of loops and couplings */
        pose3;
    stein_ops solve;       /* of M x = b */
    stein_ops articulated; /* qdd without M, all 0 where M and its solution cost less */
} gen_result;

/** Generate the equations of a mechanism. Deterministic: equal input, equal bytes.
 *  @return STEIN_OK, STEIN_ENOMEM or STEIN_EGENERATE; *out is untouched on failure */
stein_status gen_equations(gen_result *out, const mechanism *m, stein_err *err);

void gen_free(gen_result *r);

/** One expression as text that SymPy reads (sympify), written out over the file's parameters,
 *  Symbol('hammer.mass'), and Symbol('q.BODY'), 'qd.BODY', 'qdd.BODY'.
 *  @param m  one that gen_equations takes
 *  @param what  "M" [n, n], "c" [n, 1], "Q" = M qdd + c [n, 1], "T", "V" (kinetic and potential
 *               energy), or the name of a point: its position [3, 1]
 *  @param out  NUL-terminated, owned; untouched on failure
 *  @return STEIN_OK, ENAME (nothing is called so), EGENERATE (too long), ENOMEM */
stein_status gen_expressions(char **out, const mechanism *m, const char *what, stein_err *err);

/** All operations, a sine or cosine counts 1. */
int gen_total(stein_ops o);

/** Hash of everything in a mechanism that its equations depend on: if it is equal,
 *  gen_result.equations is equal too, and nothing has to be generated. The head of the text
 *  contains it.
 *  @param out  16 hexadecimal digits */
void gen_structure(const mechanism *m, char out[17]);

#endif
