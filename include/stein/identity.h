/* SPDX-License-Identifier: MIT
 * identity.h - does this build on this machine compute the same bits as others?
 */
#ifndef STEIN_IDENTITY_H
#define STEIN_IDENTITY_H

#include "stein/model.h"
#include "stein/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Hash of standard work. It covers the elementary functions over their ranges and, of every
 * mechanism, its equations and runs. They are made with both integrators and with controlled steps,
 * with the file's laws and with every law switched on. Two builds of one version have the same hash
 * if they compute the same bits, with any compiler, options, processor and libm. Takes some tenths
 * of a second.
 *  @param models  closed by NULL, e.g. stein_models of models.h
 *  @param hash    out: FNV-1a, 64 bits, over all numbers as IEEE doubles, lowest byte first
 *  @return OK, or what stein_sim_create returns for a mechanism as its file has it */
stein_status stein_identity(const stein_model *const *models, unsigned long long *hash,
                            stein_err *err);

/** The hash so far with n numbers more: +0 and -0 differ, all NaN count as one. Begin
 *  with STEIN_HASH. */
#define STEIN_HASH 14695981039346656037ull
unsigned long long stein_hash_numbers(unsigned long long hash, const double *x, int n);

#ifdef __cplusplus
}
#endif
#endif
