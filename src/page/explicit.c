/* SPDX-License-Identifier: MIT
 * explicit.c - pages and FMUs carry their equations without derivatives (STEIN_PLAIN), so their
 * steps are explicit: in the place of src/core/implicit.c. A page of a mechanism without reactions
 * goes without src/core/reaction.c as well.
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

#ifdef PAGE_WITHOUT_REACTIONS
size_t stein__reaction_size(const stein_model *model)
{
    (void)model;
    return 0;
}

double stein__reaction(stein_sim *sim, int i)
{
    (void)sim, (void)i;
    return 0.0;
}

void stein__note_pull(stein_sim *sim, int point, const double f[3])
{
    (void)sim, (void)point, (void)f;
}
#endif
