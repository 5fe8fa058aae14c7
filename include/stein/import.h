/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.h - mechanisms of other programs as mechanism files. libsteinlab.a.
 */
#ifndef STEIN_IMPORT_H
#define STEIN_IMPORT_H

#include "stein/lab.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What was read, and how much of it was left out. */
typedef struct lab_imported {
    char name[33];              /* of the mechanism */
    int bodies, joints, points; /* of the file; a body with several joints becomes several bodies */
    int left_out;               /* messages to `report` */
} lab_imported;

/** Read ROBOTRAN's project file (XML, `mbsDescR7`): gravity, the tree of bodies with their joints,
 *  masses, centres, inertias, points and initial values; driven joints become inputs, every joint
 *  an output. What a mechanism file cannot carry is reported piece by piece and listed at the head
 *  of the file that is written: cuts (loops), links and user models, whose laws are in C code of
 *  their own, sensors and external forces, drawings.
 *  @param to      the mechanism file, or "-"
 *  @param report  is called with what is left out or renamed; may be NULL
 *  @param done    out, may be NULL; untouched on failure
 *  @return OK; EIO; EPARSE: "file:line:column: what, expected what"; ENOMEM. A project with numbers
 *          that no mechanism can have, an inertia beyond that of any body, is written all the same,
 *          and EPARSE names the line of what was written */
stein_status lab_import_mbs(const char *file, const char *to, lab_report_fn *report, void *ctx,
                            lab_imported *done, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
