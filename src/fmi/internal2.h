/* SPDX-License-Identifier: MIT
 * internal2.h - between fmi2.c and exchange2.c.
 * Included by: this folder.
 */
#ifndef INTERNAL2_H
#define INTERNAL2_H

#include "fmi2.h"
#include "slave.h"

/** NULL of no instance. */
slave *slave2_of(fmi2Component c);
fmi2Status status2(slave_status status);

#endif
