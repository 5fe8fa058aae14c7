/* SPDX-License-Identifier: MIT
 * explicit.c - pages and FMUs carry their equations without derivatives (STEIN_PLAIN), so their
 * steps are explicit: in the place of src/core/implicit.c.
 */
#include "core.h"

size_t stein__implicit_size(const stein_model *model, stein_integrator integrator)
{
    (void)model, (void)integrator;
    return 0;
}

void stein__implicit_make(stein_sim *sim, void *block)
{
    (void)sim, (void)block;
}
