/* SPDX-License-Identifier: GPL-3.0-or-later
 * identity_models.h - texts of the mechanisms that identity.c works with, put into the library by
 * make.
 * Included by: this folder.
 */
#ifndef IDENTITY_MODELS_H
#define IDENTITY_MODELS_H

/** Lines of models/stein1788.yaml and models/pendulum.yaml, closed by NULL. */
extern const char *const lab__identity_action[];
extern const char *const lab__identity_pendulum[];

#endif
