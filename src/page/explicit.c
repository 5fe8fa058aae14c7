/* SPDX-License-Identifier: MIT
 * explicit.c - pages and FMUs carry their equations without derivatives (STEIN_PLAIN), so their
 * steps are explicit: in the place of src/core/implicit.c. A page of a mechanism without reactions
 * goes without src/core/reaction.c as well, one without loops without src/core/singular.c.
 */
#include <math.h>

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

#ifdef PAGE_WITHOUT_LOOPS
void stein__singular_look(stein_sim *sim, double h)
{
    (void)sim, (void)h;
}

int stein__singular_is_near(const stein_sim *sim, double h)
{
    (void)sim, (void)h;
    return 0;
}

int stein__singular_is_close(const stein_sim *sim, double t)
{
    (void)sim, (void)t;
    return 0;
}

stein_status stein__singular_derive(stein_sim *sim, double t, int at_end, double *k, stein_err *err)
{
    (void)sim, (void)t, (void)at_end, (void)k, (void)err;
    return STEIN_OK; // asked for beside a singular position alone
}

long long stein_singular_passes(const stein_sim *sim, double *last)
{
    (void)sim;
    if (last != NULL) {
        *last = (double)NAN;
    }
    return 0;
}
#endif
