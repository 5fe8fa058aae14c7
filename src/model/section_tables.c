/* SPDX-License-Identifier: MIT
 * section_tables.c - laws given by points, in a joint or a contact.
 *
 *   NAME: {joint: BODY, of: position, at: [...], torque: [...]}     or of: speed; force if it
 * slides NAME: {contact: CONTACT, of: depth, at: [...], force: [...]}    or of: rate, with factor
 *
 * Every point is two parameters, NAME.at.1 and NAME.torque.1, counted from 1.
 */
#include <string.h>

#include "reader.h"

enum { FEWEST = 2 };

/** Input for reading a table. */
typedef struct words {
    const char *value, *unit, *at_unit; /* key and unit of its values, unit of its points */
} words;

static words words_of(const mechanism *m, const mech_table *t)
{
    int slides = t->kind <= STEIN_TABLE_SPEED && m->bodies[t->index].type == 'T';

    switch (t->kind) {
    case STEIN_TABLE_DEPTH: return (words){"force", "N", "m"};
    case STEIN_TABLE_RATE: return (words){"factor", "1", "m/s"};
    case STEIN_TABLE_SPEED:
        return slides ? (words){"force", "N", "m/s"} : (words){"torque", "N m", "rad/s"};
    default: return slides ? (words){"force", "N", "m"} : (words){"torque", "N m", "rad"};
    }
}

/** A contact (the load's is called load) or notch by name. @return 0, -1 after noting the problem
 */
static int surface_ref(mech__reader *rd, const mech__node *node, int notch, int *index)
{
    const mechanism *m = rd->m;
    const char *what = notch ? "a notch" : "a contact", *name = mech__text(rd, node, what);
    mech__nearest near = {name, NULL, 0};

    for (int i = 0; name && i < (notch ? m->nnotch : m->ncontact); i++) {
        const char *known = notch ? m->notches[i].name : m->contacts[i].name;

        if (strcmp(known, name) == 0) {
            *index = i + (notch ? m->ncontact : 0);
            return 0;
        }
        mech__offer(&near, known);
    }
    if (name) {
        mech__problem_at(rd, node, "there is no %s \"%s\"%s", notch ? "notch" : "contact",
                         mech__shown(rd, name), mech__hint(rd, &near, ""));
    }
    return -1;
}

/** Its place and argument. @return 0, -1 after noting the problem */
static int read_place(mech__reader *rd, mech_table *t, const mech__node *entry)
{
    const mech__node *joint = mech__get(entry, "joint"), *contact = mech__get(entry, "contact");
    const mech__node *notch = mech__get(entry, "notch"), *surface = contact ? contact : notch;
    const mech__node *of = mech__need(rd, entry, "of", "a table");

    if ((joint != NULL) + (contact != NULL) + (notch != NULL) != 1) {
        mech__problem_at(rd, entry->key, "a table needs one of joint, contact and notch");
        return -1;
    }
    int bad = joint ? mech__joint_ref(rd, joint, &t->index)
                    : surface_ref(rd, surface, notch != NULL, &t->index);
    int kind = !of     ? -1
               : joint ? mech__choice(rd, of, "state of a joint", "position speed")
                       : mech__choice(rd, of, "state of a contact", "depth rate");

    t->kind = (joint ? STEIN_TABLE_POSITION : STEIN_TABLE_DEPTH) + (kind > 0);
    return bad || kind < 0 ? -1 : 0;
}

/** The list under a key. @return NULL after noting the problem */
static const mech__node *list_of(mech__reader *rd, const mech__node *entry, const char *key)
{
    const mech__node *list = mech__need(rd, entry, key, "a table");

    if (list && list->kind != MECH__LIST) {
        mech__problem_at(rd, list, "%s must be a list of numbers", key);
        return NULL;
    }
    return list;
}

static void read_points(mech__reader *rd, mech_table *t, const mech__node *at,
                        const mech__node *value, const words *w)
{
    if (at->count < FEWEST || at->count > MECH__MAX_TABLE) {
        mech__problem_at(rd, at, "%d points, expected %d to %d", at->count, FEWEST,
                         MECH__MAX_TABLE);
        return;
    }
    if (value->count != at->count) {
        mech__problem_at(rd, value, "%d values of %s at %d points, expected as many", value->count,
                         w->value, at->count);
        return;
    }
    t->v = mech__array(rd, 2 * at->count, sizeof *t->v);
    if (!t->v) {
        return;
    }
    t->n = at->count;
    const mech__node *x = at->first, *y = value->first;

    for (int i = 0; i < t->n; i++, x = x->next) {
        mech__number(rd, &t->v[i], w->at_unit, 0, x, 0.0, "%s.at.%d", t->name, i + 1);
    }
    for (int i = 0; i < t->n; i++, y = y->next) {
        mech__number(rd, &t->v[t->n + i], w->unit, 0, y, 0.0, "%s.%s.%d", t->name, w->value, i + 1);
    }
}

static void read_table(mech__reader *rd, mech_table *t, const mech__node *entry)
{
    mech__name_copy(t->name, sizeof t->name, entry->key->text);
    if (!mech__keys(rd, entry, "a table", "joint contact notch of at torque force factor") ||
        read_place(rd, t, entry) != 0) {
        return;
    }
    const words w = words_of(rd->m, t);
    static const char *const values[] = {"torque", "force", "factor"};

    for (int i = 0; i < 3; i++) {
        const mech__node *other = mech__get(entry, values[i]);

        if (other && strcmp(values[i], w.value) != 0) {
            mech__problem_at(rd, other->key, "the values of this table are called %s, not %s",
                             w.value, values[i]);
            return;
        }
    }
    const mech__node *at = list_of(rd, entry, "at"), *value = list_of(rd, entry, w.value);

    if (at && value) {
        rd->table_at[t - rd->m->tables] = at;
        read_points(rd, t, at, value, &w);
    }
}

void mech__section_tables(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *section = mech__get(rd->root, "tables");
    int n = mech__section(rd, section, "a table", MECH__MAX_THINGS);

    m->tables = mech__array(rd, n, sizeof *m->tables);
    for (const mech__node *e = n ? section->first : NULL; e && !rd->nomem; e = e->next) {
        read_table(rd, &m->tables[m->ntable++], e);
    }
}

void mech__tables_finish(mech__reader *rd)
{
    for (int i = 0; i < rd->m->ntable; i++) {
        const mech_table *t = &rd->m->tables[i];
        const mech__node *node = t->n > 0 ? rd->table_at[i]->first : NULL;

        for (int k = 1; k < t->n && !mech__failed(rd, t->name); k++) {
            node = node->next;
            if (!(t->v[k].value > t->v[k - 1].value)) {
                mech__problem_at(rd, node, "%s.at.%d is not greater than %s.at.%d", t->name, k + 1,
                                 t->name, k);
            }
        }
    }
}
