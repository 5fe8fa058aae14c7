/* SPDX-License-Identifier: MIT
 * fmi2_internal.h - between fmi2.c and exchange2.c.
 * Included by: this folder.
 */
#ifndef FMI2_INTERNAL_H
#define FMI2_INTERNAL_H

#include "fmi2.h"
#include "slave.h"

/** NULL of no instance. */
slave *slave2_of(fmi2Component c);
fmi2Status status2(slave_status status);

#endif
