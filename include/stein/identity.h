/* SPDX-License-Identifier: MIT
 * identity.h - does this library, as it was compiled and where it runs, compute the same bits?
 */
#ifndef STEIN_IDENTITY_H
#define STEIN_IDENTITY_H

#include "stein/model.h"
#include "stein/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Hash of standard motions: the elementary functions over their ranges; of every mechanism its
 *  equations, and runs with both integrators and with controlled steps, as the file has it and with
 *  every law switched on. Two builds of one version agree in it when they compute the same,
 *  whatever compiler, options, processor or libm. Takes some tenths of a second.
 *  @param models  closed by NULL, e.g. stein_models of models.h
 *  @param hash    out: FNV-1a, 64 bits, over all numbers as IEEE doubles, lowest byte first
 *  @return OK, or what stein_sim_create returns for a mechanism as its file has it */
stein_status stein_identity(const stein_model *const *models, unsigned long long *hash,
                            stein_err *err);

/** The hash so far with n numbers more: +0 and -0 differ, all that are no numbers are one. Begin
 *  with STEIN_HASH. */
#define STEIN_HASH 14695981039346656037ull
unsigned long long stein_hash_numbers(unsigned long long hash, const double *x, int n);

#ifdef __cplusplus
}
#endif
#endif
