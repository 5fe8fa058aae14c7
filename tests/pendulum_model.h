/* SPDX-License-Identifier: GPL-3.0-or-later
 * pendulum_model.h - tests that have the pendulum open, and a folder of their own.
 */
#ifndef PENDULUM_MODEL_H
#define PENDULUM_MODEL_H

#include "lab_support.h"

static lab_model *model; /* of each test */

static inline void open_pendulum(void)
{
    make_folder();
    ck_assert_stein(lab_open(&model, "models/pendulum.yaml", NULL, err));
}

static inline void close_pendulum(void)
{
    lab_close(model);
    remove_folder();
}

#endif
