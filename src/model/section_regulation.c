/* SPDX-License-Identifier: MIT
 * section_regulation.c - numbers with sliders, and the texts of the file.
 *
 *   regulation:
 *     NAME: {from: QUANTITY, to: QUANTITY, label: text}     NAME: a parameter
 *
 * Nothing of this changes the equations.
 */
#include <string.h>

#include "reader.h"

/** One end of a range. @return 0, -1 after noting the problem */
static int read_end(mech__reader *rd, const mech__node *entry, const char *key, mech_dim dim,
                    double *value)
{
    const mech__node *node = mech__need(rd, entry, key, "a range of the regulation");
    const char *text = node ? mech__text(rd, node, key) : NULL;
    stein_err err = {STEIN_OK, ""};

    if (!text) {
        return -1;
    }
    if (mech_parse_quantity(text, dim, value, &err) != STEIN_OK) {
        mech__problem_at(rd, node, "%s of %s: %s", key, entry->key->text, err.msg);
        return -1;
    }
    return 0;
}

/** The parameter an entry names, -1 after noting the problem. */
static int find_param(mech__reader *rd, const mech__node *entry)
{
    const char *name = entry->key->text, *best = NULL;
    int param = mech_find_param(rd->m, name, &best);

    if (param < 0 && !mech__failed(rd, name)) {
        mech__problem_at(rd, entry->key, "there is no parameter \"%s\" to regulate%s",
                         mech__shown(rd, name),
                         best ? mech__print(rd, ", did you mean \"%s\"?", best) : "");
    }
    return param;
}

static void read_dial(mech__reader *rd, const mech__node *entry)
{
    mechanism *m = rd->m;
    mech_dial dial = {.param = find_param(rd, entry)};

    if (!mech__keys(rd, entry, "a range of the regulation", "from to label") || dial.param < 0) {
        return;
    }
    mech_dim dim = m->params[dial.param].dim;
    int bad = read_end(rd, entry, "from", dim, &dial.from);

    if (read_end(rd, entry, "to", dim, &dial.to) != 0 || bad) {
        return;
    }
    if (!(dial.from < dial.to)) {
        mech__problem_at(rd, entry, "the range of %s ends where it begins or before",
                         entry->key->text);
        return;
    }
    const mech__node *label = mech__get(entry, "label");

    mech__name_copy(dial.label, sizeof dial.label, label ? label->text : entry->key->text);
    m->dials[m->ndial++] = dial;
}

/** One text, at the path "SECTION.ENTRY". */
static void note_about(mech__reader *rd, const mech__node *map, const char *section,
                       const char *entry)
{
    const mech__node *node = mech__get(map, "about");
    mechanism *m = rd->m;

    if (!node || node->kind != MECH__SCALAR || rd->nomem) {
        return;
    }
    size_t size = strlen(node->text) + 1;
    mech_about *to = &m->abouts[m->nabout];

    to->text = mech__array(rd, (int)size, 1);
    if (to->text) {
        memcpy(to->text, node->text, size);
        mech__name_copy(to->section, sizeof to->section, section);
        mech__name_copy(to->entry, sizeof to->entry, entry);
        m->nabout++;
    }
}

/** Texts of the file, of its sections and of their entries. */
static void read_abouts(mech__reader *rd)
{
    int most = 1;

    for (const mech__node *s = rd->root->first; s; s = s->next) {
        most += 1 + s->count;
    }
    rd->m->abouts = mech__array(rd, most, sizeof *rd->m->abouts);
    if (rd->nomem) {
        return;
    }
    note_about(rd, rd->root, "", "");
    for (const mech__node *s = rd->root->first; s; s = s->next) {
        note_about(rd, s, s->key->text, "");
        for (const mech__node *e = s->kind == MECH__MAP ? s->first : NULL; e; e = e->next) {
            note_about(rd, e, s->key->text, e->key->text);
        }
    }
}

void mech__section_regulation(mech__reader *rd)
{
    const mech__node *section = mech__get(rd->root, "regulation");

    if (section && section->kind != MECH__MAP) {
        mech__problem_at(rd, section, "expected a mapping from parameters to {from: ..., to: ...}");
        return;
    }
    rd->m->dials = mech__array(rd, section ? section->count : 0, sizeof *rd->m->dials);
    for (const mech__node *e = section ? section->first : NULL; e && !rd->nomem; e = e->next) {
        if (strcmp(e->key->text, "about") != 0) {
            read_dial(rd, e);
        }
    }
    if (!rd->nomem) {
        read_abouts(rd);
    }
}
