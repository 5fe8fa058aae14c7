/* SPDX-License-Identifier: GPL-3.0-or-later
 * model_header.h - the text of stein/model.h, with output.h in it, put into the library by make, so
 * that equations can be compiled where libstein's headers are not installed.
 * Included by: this folder.
 */
#ifndef MODEL_HEADER_H
#define MODEL_HEADER_H

/** Its lines, closed by NULL. */
extern const char *const lab__model_header[];

#endif
