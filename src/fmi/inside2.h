/* SPDX-License-Identifier: MIT
 * inside2.h - between fmi2.c and exchange2.c.
 */
#ifndef FMI_INSIDE2_H
#define FMI_INSIDE2_H

#include "fmi2.h"
#include "slave.h"

/** NULL of no instance. */
slave *slave2_of(fmi2Component c);
fmi2Status status2(slave_status status);

#endif
