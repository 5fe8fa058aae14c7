/* SPDX-License-Identifier: GPL-3.0-or-later
 * groups.c - numbers that scatter together from record to record.
 *
 * A record has one factor for all numbers of a group: frictions of joints, frictions of contacts,
 * load and inputs.
 */
#include <stdio.h>
#include <string.h>

#include "fitting.h"

static int is_named(const char *name, const char *owner, const char *rest)
{
    size_t n = strlen(owner);
    return strncmp(name, owner, n) == 0 && strcmp(name + n, rest) == 0;
}

/* the number of a contact that scatters: its friction; of one without, its damping */
static const char *dissipation_of(const stein_model *m, int contact)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.friction.A", m->contacts[contact].name);
    int i = stein_find_param(m, name);
    return i >= 0 && m->params[i].value != 0.0 ? ".friction.A" : ".normal.D";
}

int fit__group_of(const stein_model *m, const char *name, int by_place)
{
    int group = FIT__CALM, place = 0, at = 0;
    for (int i = 0; i < m->nq; i++, at++) {
        if (is_named(name, m->bodies[i].name, ".friction.A") ||
            is_named(name, m->bodies[i].name, ".coulomb.T") ||
            is_named(name, m->bodies[i].name, ".damping")) {
            group = FIT__JOINTS;
            place = at;
        }
    }
    for (int i = 0; i < m->ncontact; i++, at++) {
        if (is_named(name, m->contacts[i].name, dissipation_of(m, i))) {
            group = FIT__CONTACTS;
            place = at;
        }
    }
    for (int i = 0; i < m->nnotch; i++, at++) {
        if (is_named(name, m->notches[i].name, ".friction.A")) {
            group = FIT__CONTACTS;
            place = at;
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        group = is_named(name, m->inputs[i].name, ".gain") ? FIT__DRIVE : group;
    }
    int load = m->load.body >= 0 && is_named(name, m->bodies[m->load.body].name, ".mass");
    group = load ? FIT__DRIVE : group;
    return group + FIT__GROUPS * (by_place && group != FIT__DRIVE ? place : 0);
}

static const char *name_of_place(const stein_model *m, int place)
{
    int contact = place - m->nq, notch = contact - m->ncontact;
    return contact < 0 ? m->bodies[place].name
           : notch < 0 ? m->contacts[contact].name
                       : m->notches[notch].name;
}

int fit__same_group(const fit__problem *a, int g, const fit__problem *b, int h)
{
    if (fit__class(g) != fit__class(h) || a->places == 0 || b->places == 0 ||
        fit__class(g) == FIT__DRIVE) {
        return g == h;
    }
    const stein_model *m = lab_equations(a->model), *n = lab_equations(b->model);
    return strcmp(name_of_place(m, g / FIT__GROUPS), name_of_place(n, h / FIT__GROUPS)) == 0;
}
