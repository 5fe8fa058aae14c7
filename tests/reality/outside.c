/* SPDX-License-Identifier: GPL-3.0-or-later
 * outside.c - laws that are in no table of effects, written nowhere but here; and their visible
 * range in the strokes, for the comparison with a recovered law.
 *
 *   torque_bump       joint, over its position:    T exp(-((q - q0)/width)^2)
 *   felt_hump         contact, over its depth:     + F u^4 exp(2 - 2 u^2), u = x/x0, largest at x0
 *   relaxing_contact  contact, with memory:        normal force times 1 - r m,
 *                                                  dm/dt = (1 - m)/time pressed, -m/time apart
 *
 * None is a sum of effects of a table (springs and their cubes, preload, backlash; powers and
 * polynomials of the depth, shares by its rate). A hump rises and falls inside of the visited
 * range. A memory gives another force on the way out than any state does.
 *
 * What is pressed at rest has relaxed before the stroke begins (m = 1).
 */
#include <math.h>
#include <string.h>

#include "reality.h"

#define JOINT_PLACES "key hammer pawl"

// clang-format off: one entry a line or two
const effect_kind outside_kinds[] = {
    {"torque_bump",
     "unknown_effect",
     JOINT_PLACES,
     1,
     0,
     "T",
     "N m",
     {6e-2, 2e-3, 1e-2},
     {{"q0", "", 0.3, 0.7}, {"width", "", 0.12, 0.25}},
     "torque T exp(-((q - q0)/width)^2)"},
    {"felt_hump",
     "unknown_effect",
     "dip loops string stop",
     0,
     0,
     "F",
     "N",
     {1.0, 0.0, 0.0},
     {{"x0", "m", 0.3, 0.5}},
     "normal force + F u^4 exp(2 - 2 u^2), u = x/x0"},
    {"relaxing_contact",
     "unknown_effect",
     "dip loops string stop",
     0,
     0,
     "r",
     "1",
     {0.9, 0.0, 0.0},
     {{"time", "s", 0.0, 1.0}},
     "normal force times 1 - r m, dm/dt = (1 - m)/time while pressed, -m/time while apart"},
    {NULL, NULL, NULL, 0, 0, NULL, NULL, {0.0, 0.0, 0.0}, {{0}}, NULL},
};
// clang-format on

/* range of the joints in a stroke [rad]: from, over */
static const double from[JOINTS] = {0.0, -0.01, -0.0037}, over[JOINTS] = {0.04, 0.39, 0.019};
/* what a stroke does to a surface: depth [m], force [N], time [s] for which it is pressed */
static const struct {
    double depth, force, time;
} pressed[CONTACTS] = {
    [REST] = {1e-4, 1.0, 0.02},      [DIP] = {5.5e-4, 9.0, 0.02}, [LOOPS] = {4.4e-4, 0.8, 0.02},
    [STRING] = {3.2e-4, 7.0, 0.001}, [STOP] = {6e-4, 0.5, 0.02},  [LOAD] = {2e-5, 2.0, 0.02},
    [NOTCH] = {1e-5, 3.0, 0.01}};

int effect_is_outside(const effect *e)
{
    for (const effect_kind *k = outside_kinds; k->name != NULL; k++) {
        if (e->kind == k) {
            return 1;
        }
    }
    return 0;
}

static int is(const effect *e, const char *name)
{
    return strcmp(e->kind->name, name) == 0;
}

const char *outside_limit(const effect *e)
{
    return is(e, "relaxing_contact") ? "contact_stiffness" : NULL;
}

/* shares of a draw, in units */
void outside_sides(effect *e)
{
    if (is(e, "torque_bump")) {
        e->side[0] = from[e->where] + e->side[0] * over[e->where];
        e->side[1] *= over[e->where];
    } else if (is(e, "felt_hump")) {
        e->side[0] *= pressed[e->where].depth;
    } else if (is(e, "relaxing_contact")) {
        e->side[0] = pressed[e->where].time * 0.15 * pow(10.0, e->side[0]);
    }
}

double outside_unit(const effect *e)
{
    return is(e, "felt_hump") ? pressed[e->where].force : 1.0;
}

void outside_on_action(const effect *e, action *a, double size)
{
    if (is(e, "torque_bump")) {
        a->joint[e->where].bump = size;
        a->joint[e->where].bump_at = e->side[0];
        a->joint[e->where].bump_width = e->side[1];
    } else if (is(e, "felt_hump")) {
        a->felt[e->where].hump = size;
        a->felt[e->where].hump_at = e->side[0];
    } else if (is(e, "relaxing_contact")) {
        a->felt[e->where].ease = size;
        a->felt[e->where].ease_time = e->side[0];
    }
}

/* ---- formulas ---- */

double outside_torque(const hinge *h, double q)
{
    double u = h->bump_width > 0.0 ? (q - h->bump_at) / h->bump_width : 0.0;
    return h->bump_width > 0.0 ? h->bump * exp(-u * u) : 0.0;
}

static double hump(const felt *f, double x)
{
    double u = f->hump_at > 0.0 ? x / f->hump_at : 0.0;
    return f->hump * u * u * u * u * exp(2.0 - 2.0 * u * u);
}

double outside_push(const felt *f, double N, double x, double memory)
{
    N *= 1.0 - f->ease * memory;
    return f->hump > 0.0 ? fmax(N + hump(f, x), 0.0) : N;
}

double outside_memory_rate(const felt *f, int touching, double memory)
{
    return ((touching ? 1.0 : 0.0) - memory) / f->ease_time;
}

double outside_memory_at_rest(const action *a)
{
    return a->felt[REST].ease > 0.0 || a->felt[LOOPS].ease > 0.0 || a->felt[STOP].ease > 0.0 ? 1.0
                                                                                             : 0.0;
}

/* ---- its visible range in the strokes ---- */

void visits_add(visits *v, const visits *more)
{
    for (int i = 0; i < JOINTS; i++) {
        v->low[i] = fmin(v->low[i], more->low[i]);
        v->high[i] = fmax(v->high[i], more->high[i]);
    }
    for (int i = 0; i < CONTACTS; i++) {
        v->deepest[i] = fmax(v->deepest[i], more->deepest[i]);
    }
}

/** The law over what was visited; a law with memory has no such curve. */
void outside_law(const effect *e, const visits *v, known_law *law)
{
    action a;
    memset(&a, 0, sizeof a);
    memset(law, 0, sizeof *law);
    outside_on_action(e, &a, effect_size(e));
    int joint = is(e, "torque_bump");
    law->site = joint ? "joint" : e->where == NOTCH ? "notch" : "contact";
    law->of = joint ? "position" : is(e, "felt_hump") ? "depth" : "history";
    law->at_unit = joint ? "rad" : "m";
    law->unit = joint ? "N m" : "N";
    law->n = is(e, "relaxing_contact") ? 0 : LAW_POINTS;
    for (int i = 0; i < law->n; i++) {
        double lo = joint ? v->low[e->where] : 0.0;
        double hi = joint ? v->high[e->where] : v->deepest[e->where];
        law->at[i] = lo + (hi - lo) * i / (law->n - 1);
        law->value[i] = joint ? outside_torque(&a.joint[e->where], law->at[i])
                              : hump(&a.felt[e->where], law->at[i]);
    }
}
