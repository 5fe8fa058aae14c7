/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.h - mechanisms of other programs as mechanism files. libsteinlab.a.
 */
#ifndef STEIN_IMPORT_H
#define STEIN_IMPORT_H

#include "stein/lab.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Counts of imported and omitted elements. */
typedef struct lab_imported {
    char name[33];              /* of the mechanism */
    int bodies, joints, points; /* of the file; a body with several joints becomes several bodies */
    int loops;                  /* cuts, links and couplings */
    int left_out;               /* messages to `report` about omissions and changes */
} lab_imported;

/** Treatment of an inertia that no body can have (a principal moment above the sum of the other
 * two). The import fails, or the inertia is accepted with a warning, or its three moments are made
 * equal.
 */
typedef enum { LAB_INERTIA_REFUSE, LAB_INERTIA_ACCEPT, LAB_INERTIA_BALANCE } lab_inertia;

/** Read a file of another program and write the same mechanism as a mechanism file.
 *
 *  ROBOTRAN's project (XML, `mbsDescR7`): gravity, the tree of bodies with joints, masses, centres,
 *  inertias, points and initial values. Cuts become loops (ball: the points meet, rod, solid: a
 *  weld); the start of dependent joints is a guess from which loops are closed. Driven and locked
 *  joints become prescribed motions, actuated ones torques, external forces three forces each,
 *  links springs without stiffness, sensors and joints outputs.
 *
 *  A robot of ROS (URDF, `robot`): links with inertial, joints of all types but planar, with axis,
 *  origin, limits of position, damping, friction, mimic. A link on a fixed joint becomes part of
 *  the body that carries it, and a point. With all joints at 0 every body has the axes of the
 *  world. An oblique joint axis is reached by hinges that are held at the angles of its frame.
 *
 *  A model of MuJoCo (MJCF, `mujoco`): bodies with orientations, inertials or the mass of their
 * geoms (solids; not meshes), joints of all types with range, damping, stiffness, frictionloss,
 * default classes, equalities connect, weld and joint, actuators of joints as torques.
 *
 *  Elements without an equivalent are reported one by one and listed at the head of the written
 *  file: laws in code of the project, orientations of sensors, meshes.
 *  @param to      the mechanism file, or "-"
 *  @param report  is called with omissions, changes and warnings; may be NULL
 *  @param done    out, may be NULL; untouched on failure
 *  @return OK; EIO; EPARSE: "file:line:column: what, expected what"; ENOMEM. A file with impossible
 *          numbers, such as a refused inertia, is written all the same, and EPARSE names its line
 *          in the written file */
stein_status lab_import(const char *file, const char *to, lab_inertia inertia,
                        lab_report_fn *report, void *ctx, lab_imported *done, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
