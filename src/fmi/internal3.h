/* SPDX-License-Identifier: MIT
 * internal3.h - between fmi3.c, exchange3.c and none3.c.
 * Included by: this folder.
 */
#ifndef INTERNAL3_H
#define INTERNAL3_H

#include "fmi3.h"
#include "slave.h"

/** NULL of no instance. */
slave *slave3_of(fmi3Instance c);
fmi3Status status3(slave_status status);
/** Log that a function is not for this FMU ("fmi3GetClock: this FMU WHY"). @return fmi3Error */
fmi3Status refuse3(fmi3Instance c, const char *function, const char *why);

#endif
