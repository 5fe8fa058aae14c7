/* SPDX-License-Identifier: MIT
 * none3.h - between fmi3.c and none3.c.
 */
#ifndef FMI_NONE3_H
#define FMI_NONE3_H

#include "fmi3.h"

/** Log that a function is not for this FMU ("fmi3SetTime: this FMU WHY"). @return fmi3Error */
fmi3Status none3_refuse(fmi3Instance c, const char *function, const char *why);

#endif
