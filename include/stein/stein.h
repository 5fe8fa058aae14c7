/* SPDX-License-Identifier: MIT
 * stein.h - libstein: equations of motion generated symbolically, simulated with contacts.
 *
 * PURPOSE
 *   A mechanism file (models/NAME.yaml) describes a tree of bodies, its contacts, inputs and
 * outputs. The generator turns it into flat C for
 *
 *       M(q) qdd + c(q, qd, frc, trq) = Q(q, qd)
 *
 *   by the recursive Newton-Euler scheme; this library adds contact detection, force laws, the
 * notch of a piano action, fixed-step integrators and located events. It allocates once a
 * simulation, never prints, never exits, has no globals and is reentrant.
 *
 * CONVENTIONS (all in model.h)
 *   SI units. q, qd, qdd: one coordinate a joint. x to the right, z up, gravity -z. c holds
 * gravity, gyroscopic and applied forces; Q the forces in the joints. Names come from the file.
 *
 * EXAMPLE (cc strike.c $(pkg-config --cflags --libs stein))
 *
 *   #include <stdio.h>
 *   #include <stein/stein.h>
 *
 *   int main(void)
 *   {
 *       stein_sim *sim;
 *       stein_err err;
 *       if (stein_sim_create(&sim, &stein_model_stein1788, NULL, &err) != STEIN_OK ||
 *           stein_set(sim, "pawl.stop_shift", -0.3e-3, &err) != STEIN_OK ||
 *           stein_reset(sim, &err) != STEIN_OK || stein_run(sim, 0.050, &err) != STEIN_OK) {
 *           fprintf(stderr, "%s\n", err.msg);
 *           return 1;
 *       }
 *       double distance;
 *       stein_read_name(sim, "string_distance", &distance, &err);
 *       printf("head to string after 50 ms: %.3f mm\n", 1e3 * distance);
 *       stein_sim_destroy(sim);
 *   }
 *
 * HEADERS
 *   status.h errors   model.h the descriptor and all conventions (with output.h)
 *   sim.h simulations
 *   law.h force laws  load.h equations compiled later              models.h the built-in models
 *   batch.h many simulations side by side
 *   version.h the version         identity.h a hash of standard results
 *   handover.h parameters from another thread, and what a real-time host may rely on
 *   derivative.h exact derivatives of qdd   sensitivity.h derivatives of a whole motion
 *   linear.h a mechanism linearised about an equilibrium
 *   balance.h where the energy of a motion comes from and goes to
 * and, with libsteinlab.a (GPL), not included here: lab.h mechanism files, strokes, studies;
 * data.h measured strokes; fit.h parameters from them; diagnose.h the table of physical effects and
 * which of them measured strokes show; plan.h the next experiment; import.h mechanisms of other
 * programs.
 */
#ifndef STEIN_H
#define STEIN_H

#include "stein/balance.h"
#include "stein/batch.h"
#include "stein/derivative.h"
#include "stein/handover.h"
#include "stein/identity.h"
#include "stein/law.h"
#include "stein/linear.h"
#include "stein/load.h"
#include "stein/model.h"
#include "stein/models.h"
#include "stein/output.h"
#include "stein/sensitivity.h"
#include "stein/sim.h"
#include "stein/status.h"
#include "stein/version.h"

#endif
