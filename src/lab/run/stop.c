/* SPDX-License-Identifier: GPL-3.0-or-later
 * stop.c - long work that its caller stops.
 *
 *   lab_vary, lab_fit_run, lab_diagnose:  ENOMEM and asked?  ->  ESTOPPED
 *        ^
 *        | ENOMEM, through every layer
 *   thread pool: asked before each piece of work
 *
 * A search forgives a hypothesis that cannot be simulated, but never a lack of memory. That way up
 * exists for every call and is tested by refusing each allocation (tests/faults), so a stop takes
 * it, too.
 */
#include "run.h"

int lab__stop_asked(const lab__stop *stop)
{
    return stop->fn != NULL && stop->fn(stop->ctx);
}

stein_status lab__stop_work(stein_err *err)
{
    return lab__fail(err, STEIN_ENOMEM, "stopped");
}

stein_status lab__stop_end(stein_status status, const lab__stop *stop, stein_err *err)
{
    return status == STEIN_ENOMEM && lab__stop_asked(stop)
               ? lab__fail(err, STEIN_ESTOPPED, "stopped by its caller")
               : status;
}
