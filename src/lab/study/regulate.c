/* SPDX-License-Identifier: GPL-3.0-or-later
 * regulate.c - regulating: the value of one parameter at which the escapement has a given height.
 *
 * The height is monotonic in every regulation but has an end on both sides (no escapement, or a
 * missed notch), where it does not exist. Bisection needs no derivative and stays inside.
 */
#include <math.h>

#include "study.h"

enum { HALVINGS = 24 };
static const double close_enough = 1e-6; /* [m] */

/* the height at the first escapement */
typedef struct catch
{
    int notch, gap, sign;
    double height;
}
catch;

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    catch *c = ctx;
    if (event->kind == STEIN_EVENT_ESCAPEMENT && event->index == c->notch && isnan(c->height)) {
        c->height = fmax(0.0, c->sign * stein_read(sim, c->gap));
    }
}

/* as in lab_strike, ended by the escapement: half the cost */
double study_height(const study *s, stein_sim *sim)
{
    const stein_model *m = lab_equations(s->model);
    catch c = {.notch = m->stroke.notch, .height = NAN};
    c.gap = lab__channel_of(m, STEIN_READ_GAP, m->stroke.string);
    c.sign = m->channels[c.gap].sign;
    double until = study_drive_default().until;
    stein_status status = stein_reset(sim, NULL);
    stein_on_event(sim, on_event, &c);
    while (status == STEIN_OK && isnan(c.height) && stein_time(sim) < until) {
        status = stein_step(sim, NULL);
    }
    stein_on_event(sim, NULL, NULL);
    return c.height;
}

static double height_with(const study *s, stein_sim *sim, const char *name, double value)
{
    return stein_set(sim, name, value, NULL) == STEIN_OK ? study_height(s, sim) : NAN;
}

int study_level(const study *s, stein_sim *sim, const char *name, double lo, double hi,
                double height, double *value)
{
    double at_lo = height_with(s, sim, name, lo) - height,
           at_hi = height_with(s, sim, name, hi) - height;
    if (!((at_lo > 0.0) != (at_hi > 0.0)) || !isfinite(at_lo) || !isfinite(at_hi)) {
        return 0;
    }
    for (int n = 0; n < HALVINGS; n++) {
        // regula falsi, every third time a plain halving
        double middle = n % 3 == 2 ? 0.5 * (lo + hi) : (lo * at_hi - hi * at_lo) / (at_hi - at_lo);
        double here = height_with(s, sim, name, middle) - height;
        *value = middle;
        if (!isfinite(here) || fabs(here) < close_enough) {
            return isfinite(here);
        }
        if ((here > 0.0) == (at_lo > 0.0)) {
            lo = middle;
            at_lo = here;
        } else {
            hi = middle;
            at_hi = here;
        }
    }
    return 1;
}

double study_height_slope(const study *s, stein_sim *sim, const char *name, double step)
{
    double value = NAN;
    if (stein_get(sim, name, &value, NULL) != STEIN_OK) {
        return NAN;
    }
    double up = height_with(s, sim, name, value + step);
    double down = height_with(s, sim, name, value - step);
    stein_set(sim, name, value, NULL);
    return (up - down) / (2.0 * step);
}
