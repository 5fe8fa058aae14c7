/* SPDX-License-Identifier: GPL-3.0-or-later
 * simulation_support.h - one simulation of a mechanism written in the test, for tests that need no
 * more.
 */
#ifndef SIMULATION_SUPPORT_H
#define SIMULATION_SUPPORT_H

#include "lab_support.h"

static lab_model *model;

static inline stein_sim *start(const char *text)
{
    stein_sim *sim = NULL;
    model = open_text(text, NULL, 0);
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    return sim;
}

static inline void finish(stein_sim *sim)
{
    stein_sim_destroy(sim);
    lab_close(model);
}

#endif
