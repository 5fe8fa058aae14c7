/* SPDX-License-Identifier: MIT
 * version.h - the version: of these headers, and of the library that is linked.
 *
 * Semantic versioning: a larger MAJOR may break programs, a larger MINOR adds functions, a larger
 * PATCH corrects errors. Equations that are compiled into a program carry STEIN_MODEL_ABI beside
 * it.
 */
#ifndef STEIN_VERSION_H
#define STEIN_VERSION_H

#ifdef __cplusplus
extern "C" {
#endif

/** Of the headers; the Makefile reads it here. */
#define STEIN_VERSION       "0.1.0"
#define STEIN_VERSION_MAJOR 0
#define STEIN_VERSION_MINOR 1
#define STEIN_VERSION_PATCH 0

/** Of the library: STEIN_VERSION when it was compiled. Static storage. */
const char *stein_version(void);

#ifdef __cplusplus
}
#endif
#endif
