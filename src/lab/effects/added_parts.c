/* SPDX-License-Identifier: GPL-3.0-or-later
 * added_parts.c - effects that need a part or a degree of freedom more: the text that adds them.
 *
 * One table: what is written where, with numbers and names put in for the words after a $. The
 * rest of the file stays, and every number of it keeps its name and its meaning (a body that is cut
 * is still stated as a whole, part_of). So data, overrides and fits apply to the extended mechanism
 * unchanged. An amount is a parameter of the new part; 1/amount and the damping follow from it by
 * formulas, also when masses are fitted.
 *
 * Assumptions, all of them parameters of the new part:
 *
 *   Which bodies   those that carry the stroke: the body that meets the string and all its
 *                  ancestors (every body if the file names no stroke).
 *   Where a link   at 0.42 of the way from its joint to what it carries, the farthest joint or else
 *   bends          the farthest contact point. A uniform bar that is loaded at its end has the
 *                  same slope and deflection there when it bends at 1/3 of its length only
 *                  (F L^2/2EI, F L^3/3EI), one that is bent evenly at 1/2; a link is between.
 *   What lies      the share of a thin uniform bar with the mass, the centre and the inertia of the
 *   beyond         whole, of length sqrt(12 I/m), along the line from the joint through the centre.
 *                  That is where its mass begins: two more numbers are fitted with the amount: the
 *                  share of the mass, and the share of the inertia without the part from their
 *                  distance. A bar that is heavier at its end bends as far with half the
 *                  compliance.
 *   Where an axis  along z, against the weight. In a round hole it is as stiff upwards as
 *   moves          downwards, on a seat that is open above it is softer where it lifts:
 *                  compliance (1 + lift) upwards.
 *   A partner      stands still as drawn: its weight is carried. It moves along the normal of its
 *                  line, which must be along x or z.
 *   A rotor        behind a gear where an input drives a joint: a key of its body, no part.
 *   Where a damper where the load stands, or the first input pushes; heights and dips count from
 *   or wire acts   the drawn position.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"

enum { WORDS = 128, LINES = 9 };

/* ---- the table ---- */

/* text in a section: "section", "entry" */
typedef struct fragment {
    const char *section, *entry;
} fragment;

typedef struct structure {
    const char *kind, *ending;
    int comes_off; /* 1: a body can be played without it, and then the amount is 0 */
    const char *name[LAB_NUMBERS], *unit[LAB_NUMBERS]; /* names behind the part's */
    fragment text[LINES];
} structure;

/* $P part, $B body, $a amount, $s $o $m $i the numbers beside it, $x $z place, others as `words`
 * has them */
static const structure structures[] = {
    {"armature", "", 0, {"armature"}, {"kg m^2"}, {{NULL, NULL}}},
    {"elastic_hinge",
     "_outer",
     0,
     {"compliance", "damping_ratio", "place", "mass_ratio", "inertia_ratio"},
     {"rad/(N m)", "1", "1", "1", "1"},
     {{"parameters", "$P.apart.z: $w m"},
      {"parameters", "$P.apart.x: {value: $u m, about: \"its centre from that of the rest\"}"},
      {"parameters", "$P.inertia_ratio: $i"},
      {"parameters", "$P.mass_ratio: {value: $m, about: \"to the rest of $B\"}"},
      {"parameters", "$P.damping_ratio: $s"},
      {"parameters", "$P.link.z: $z m"},
      {"parameters", "$P.link.x: {value: $x m, about: \"as far as what $B carries\"}"},
      {"parameters", "$P.place: {value: $o, about: \"where it bends, as a share of that\"}"},
      {"bodies",
       "$P: {about: \"what lies beyond the place where $B bends, as of a thin uniform bar\",\n"
       "part_of: $B, joint: $j, at: [$P.place * $P.link.x, 0, $P.place * $P.link.z],\n"
       "mass: $P.mass_ratio / (1 + $P.mass_ratio) * $B.mass,\n"
       "centre: [$B.centre.x + $P.apart.x / (1 + $P.mass_ratio), 0,\n"
       "$B.centre.z + $P.apart.z / (1 + $P.mass_ratio)],\n"
       "inertia: {yy: $P.inertia_ratio / (1 + $P.inertia_ratio) * ($B.inertia.yy\n"
       "- $P.mass * ($P.apart.x * $P.apart.x + $P.apart.z * $P.apart.z) / (1 + $P.mass_ratio))},\n"
       "spring: {k: 1 / $P.compliance},\n"
       "damping: 2 * $P.damping_ratio * sqrt(($P.inertia.yy + $P.mass *\n"
       "(($P.centre.x - $P.at.x) * ($P.centre.x - $P.at.x)\n"
       "+ ($P.centre.z - $P.at.z) * ($P.centre.z - $P.at.z))) / $P.compliance)$k}"}}},
    {"axis_translation",
     "_axis",
     0,
     {"compliance", "damping_ratio", "lift"},
     {"m/N", "1", "1"},
     {{"parameters", "$P.lift: {value: $o, about: \"how much softer it is upwards\"}"},
      {"parameters", "$P.damping_ratio: $s"},
      {"bodies", "$P: {about: \"the axis of $B, which gives way\", joint: T z,\n"
                 "spring: {k: 1 / $P.compliance / (1 + $P.lift)},\n"
                 "limits: {range: [0 m, 1 m], k: $P.lift / $P.compliance / (1 + $P.lift)},\n"
                 "damping: 2 * $P.damping_ratio * sqrt($B.mass / $P.compliance)}"}}},
    {"compliant_partner",
     "_partner",
     0,
     {"compliance", "mass", "damping_ratio"},
     {"m/N", "kg", "1"},
     {{"parameters", "$P.damping_ratio: $o"},
      {"bodies", "$P: {about: \"what the contact $B meets, on a spring; at rest as drawn\",\n"
                 "joint: T $j, mass: $s kg,\n"
                 "spring: {k: 1 / $P.compliance, x0: -gravity.$j * $P.mass * $P.compliance},\n"
                 "damping: 2 * $P.damping_ratio * sqrt($P.mass / $P.compliance)}"}}},
    {"string_damper",
     "_damper",
     1,
     {"normal.F0", "x0", "k_to_F0"},
     {"N", "m", "1/m"},
     {{"parameters", "$P.k_to_F0: $o 1/m"},
      {"parameters", "$P.x0: $s m"},
      {"contacts", "$P: {about: \"lifted by $B from a dip x0 on\", between: [{point: $q},\n"
                   "{line: {on: frame, at: [$x m, 0, $z m - $P.x0], facing: 90 deg}}],\n"
                   "normal: {F0: $a N, c: $P.k_to_F0 * $P.normal.F0}}"}}},
    {"wire",
     "_wire",
     1,
     {"k", "stretch", "reach"},
     {"N/m", "1", "m"},
     {{"parameters", "$P.reach: $o m"},
      {"parameters", "$P.stretch: $s"},
      {"points", "$P: [$x m, 0, $z m + $P.reach]"},
      {"links", "$P: {from: frame.$P, to: $q, k: $a N/m, length: $P.reach / (1 + $P.stretch)}"}}}};

static const structure *find_kind(const char *kind)
{
    for (size_t i = 0; i < sizeof structures / sizeof *structures; i++) {
        if (strcmp(structures[i].kind, kind) == 0) {
            return &structures[i];
        }
    }
    return NULL;
}

int lab__structure_of(const char *kind, const char *name[LAB_NUMBERS],
                      const char *unit[LAB_NUMBERS])
{
    const structure *s = find_kind(kind);
    for (int i = 0; s != NULL && i < LAB_NUMBERS; i++) {
        name[i] = s->name[i];
        unit[i] = s->unit[i];
    }
    return s != NULL;
}

static void part_name(const structure *s, const char *place, char name[MECH_NAME])
{
    int room = MECH_NAME - 1 - (int)strlen(s->ending);
    snprintf(name, MECH_NAME, "%.*s%s", room, place, s->ending);
}

int lab__part_name(const char *kind, const char *place, char name[MECH_NAME])
{
    const structure *s = find_kind(kind);
    if (s != NULL) {
        part_name(s, place, name);
    }
    return s != NULL ? 0 : -1;
}

const char *lab__comes_off(const stein_model *m, const char *param)
{
    char name[MECH_NAME + LAB_PLACE];
    for (size_t i = 0; i < sizeof structures / sizeof *structures; i++) {
        const structure *s = &structures[i];
        for (int j = 0; s->comes_off && j < m->nq; j++) {
            char part[MECH_NAME];
            part_name(s, m->bodies[j].name, part);
            snprintf(name, sizeof name, "%s.%s", part, s->name[0]);
            if (strcmp(name, param) == 0) {
                return s->unit[0];
            }
        }
    }
    return NULL;
}

void lab__structure_names(const lab_candidate *c, char name[LAB_NUMBERS][LAB_PLACE])
{
    const structure *s = find_kind(c->effect->kind);
    char part[MECH_NAME];
    for (int i = 0; i < LAB_NUMBERS; i++) {
        name[i][0] = '\0';
        if (s != NULL && s->name[i] != NULL) {
            part_name(s, c->place, part);
            snprintf(name[i], LAB_PLACE, "%s.%s", part, s->name[i]);
        }
    }
}

/* ---- writing ---- */

/* values of the letters of a fragment */
typedef struct words {
    const char *of[WORDS];
    char number[WORDS][LAB_NUMBER];
} words;

static void set_number(words *w, int letter, double value)
{
    char digits[LAB_NUMBER];
    snprintf(digits, sizeof digits, "%.15g", value);
    lab__number(w->number[letter], strtod(digits, NULL));
    w->of[letter] = w->number[letter];
}

/* numbers of an assumption need no more digits than a drawing */
static void set_rounded(words *w, int letter, double value)
{
    char digits[LAB_NUMBER];
    snprintf(digits, sizeof digits, "%.4g", fabs(value) < 1e-9 ? 0.0 : value);
    set_number(w, letter, strtod(digits, NULL));
}

static stein_status write_fragment(lab__yaml_edit *s, const fragment *f, const words *w,
                                   stein_err *err)
{
    char *text = NULL;
    FILE *out = lab__text_open(&text);
    if (out == NULL) {
        return lab__no_memory(err);
    }
    for (const char *c = f->entry; *c != '\0'; c++) {
        int letter = c[0] == '$' ? (unsigned char)c[1] : 0;
        if (letter > 0 && letter < WORDS && w->of[letter] != NULL) {
            fputs(w->of[letter], out);
            c++;
        } else {
            fputc(*c, out);
        }
    }
    stein_status status = lab__text_close(out, &text, err);
    status = status == STEIN_OK ? lab__yaml_edit_add(s, f->section, text, err) : status;
    free(text);
    return status;
}

static stein_status cannot(const lab_candidate *c, const char *what, stein_err *err)
{
    return lab__fail(err, STEIN_EINVAL, "%s at %s cannot be added: %s", c->effect->kind, c->place,
                     what);
}

/* sides of contacts and notches with a place that is written with "on: body" */
static void move_sides(lab__yaml_edit *s, const mechanism *m, int body, const lab__bent *b,
                       const char *part)
{
    static const char *const side[] = {"0/line", "0/circle", "1/line", "1/circle"};
    char path[2 * MECH_PATH];
    for (int i = 0; i < m->ncontact; i++) {
        const mech_shape *two = m->contacts[i].spot[0].side;
        const mech_shape *mine = two[0].body == body ? &two[0] : &two[1];
        for (int k = 0; mine->body == body && lab__is_beyond(b, lab__at(mine->at)) && k < 4; k++) {
            snprintf(path, sizeof path, "contacts/%s/between/%s/on", m->contacts[i].name, side[k]);
            const char *on = lab__yaml_edit_get(s, path);
            if (on != NULL && strcmp(on, m->bodies[body].name) == 0) {
                lab__yaml_edit_set(s, path, part);
            }
        }
    }
    for (int i = 0; i < m->nnotch; i++) {
        const mech_notch *n = &m->notches[i];
        int corner = n->catcher == body;
        if ((corner || n->beak == body) &&
            lab__is_beyond(b, lab__at(corner ? n->corner : n->end))) {
            snprintf(path, sizeof path, "notches/%s/%s/on", n->name, corner ? "corner" : "beak");
            lab__yaml_edit_set(s, path, part);
        }
    }
}

/* points, joints and sides beyond the bend go to the part. @param text  of its points, made */
static stein_status move_beyond(lab__yaml_edit *s, const mechanism *m, int body, const lab__bent *b,
                                const char *part, char **text, stein_err *err)
{
    int any = 0;
    FILE *f = lab__text_open(text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < m->npoint; i++) {
        const char *name = m->points[i].name, *last = strchr(name, '.');
        char new[MECH_PATH];
        if (m->points[i].body == body && lab__is_beyond(b, lab__at(m->points[i].at))) {
            snprintf(new, sizeof new, "%s%s", part, last);
            if (lab__yaml_edit_swap(s, name, new) > 0) {
                fprintf(f, "%s%s: [%s.x, %s.y, %s.z]", any++ ? ", " : ",\npoints: {", last + 1,
                        name, name, name);
            }
        }
    }
    fputs(any ? "}" : "", f);
    for (int i = 0; i < m->nbody; i++) {
        char path[MECH_PATH];
        snprintf(path, sizeof path, "bodies/%s/parent", m->bodies[i].name);
        if (m->bodies[i].parent == body && lab__is_beyond(b, lab__at(m->bodies[i].at))) {
            lab__yaml_edit_set(s, path, part);
        }
    }
    move_sides(s, m, body, b, part);
    return lab__text_close(f, text, err);
}

static stein_status cut_link(lab__yaml_edit *s, const lab_candidate *c, const mechanism *m,
                             int body, words *w, char *joint, char **points, stein_err *err)
{
    lab__bent b;
    if (lab__bend(&b, m, body) != 0) {
        return cannot(c, "it has no place to bend", err);
    }
    sprintf(joint, "R %sy", m->bodies[body].sign < 0 ? "-" : "");
    w->of['j'] = joint;
    set_rounded(w, 'x', b.link.x);
    set_rounded(w, 'z', b.link.z);
    set_rounded(w, 'u', b.apart.x);
    set_rounded(w, 'w', b.apart.z);
    stein_status status = move_beyond(s, m, body, &b, w->of['P'], points, err);
    w->of['k'] = *points;
    return status;
}

/* the body hangs on its axis; a joint at a point of the frame keeps its place by formulas */
static stein_status carry(lab__yaml_edit *s, const lab_candidate *c, const char *part,
                          stein_err *err)
{
    char path[MECH_PATH], entry[MECH_PATH], place[4 * MECH_PATH];
    snprintf(path, sizeof path, "bodies/%.60s/at", c->place);
    const char *at = lab__yaml_edit_get(s, path);
    if (at != NULL) {
        snprintf(place, sizeof place, "[%.90s.x, %.90s.y, %.90s.z]", at, at, at);
        lab__yaml_edit_set(s, path, place);
    }
    snprintf(path, sizeof path, "bodies/%.60s/parent", c->place);
    if (lab__yaml_edit_get(s, path) != NULL) {
        return lab__yaml_edit_set(s, path, part) == 0 ? STEIN_OK : cannot(c, "no room", err);
    }
    snprintf(path, sizeof path, "bodies/%.60s", c->place);
    snprintf(entry, sizeof entry, "parent: %s", part);
    return lab__yaml_edit_add_key(s, path, entry, err);
}

/* a key of the body; an entry of 0 is replaced */
static stein_status gear(lab__yaml_edit *s, const lab_candidate *c, const char *amount,
                         stein_err *err)
{
    char path[MECH_PATH], entry[MECH_PATH];
    snprintf(path, sizeof path, "bodies/%.60s/armature", c->place);
    if (lab__yaml_edit_get(s, path) != NULL) {
        return lab__yaml_edit_set(s, path, amount) == 0 ? STEIN_OK : cannot(c, "no room", err);
    }
    snprintf(path, sizeof path, "bodies/%.60s", c->place);
    snprintf(entry, sizeof entry, "armature: %s %s", amount, c->unit);
    return lab__yaml_edit_add_key(s, path, entry, err);
}

/* the line of a contact stands on the partner */
static stein_status stand(lab__yaml_edit *s, const lab_candidate *c, const mechanism *m,
                          int contact, words *w, char *axis, stein_err *err)
{
    axis[0] = lab__normal_axis(m->contacts[contact].spot[0].side[1].facing.value);
    axis[1] = '\0';
    w->of['j'] = axis;
    for (int i = 0; i < 2; i++) {
        char path[MECH_PATH];
        snprintf(path, sizeof path, "contacts/%.60s/between/%d/line/on", c->place, i);
        const char *on = lab__yaml_edit_get(s, path);
        if (on != NULL && strcmp(on, "frame") == 0) {
            return lab__yaml_edit_set(s, path, w->of['P']) == 0 ? STEIN_OK
                                                                : cannot(c, "no room", err);
        }
    }
    return cannot(c, "no line of it says \"on: frame\"", err);
}

static void hang(const mechanism *m, words *w)
{
    int point = lab__load_point(m);
    lab__vec at = lab__drawn(m, m->points[point].body, lab__at(m->points[point].at));
    w->of['q'] = m->points[point].name;
    set_number(w, 'x', at.x);
    set_number(w, 'z', at.z);
}

static const lab__site *find_site(const lab_candidate *c, const mechanism *m,
                                  lab__site list[LAB_SITES])
{
    int n = lab__sites(m, c->effect->kind, list);
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].place, c->place) == 0) {
            return &list[i];
        }
    }
    return NULL;
}

stein_status lab__structure_text(const lab_candidate *c, double amount, const mechanism *m,
                                 const char *text, size_t size, char **out, size_t *nout,
                                 stein_err *err)
{
    static const words nothing = {.of = {NULL}};
    const structure *kind = find_kind(c->effect->kind);
    lab__site list[LAB_SITES];
    const lab__site *site = kind != NULL ? find_site(c, m, list) : NULL;
    if (site == NULL) {
        return cannot(c, "the place does not exist, or has one already", err);
    }
    words w = nothing;
    char part[MECH_NAME], joint[8] = "", *points = NULL, entry[2 * MECH_PATH];
    lab__yaml_edit *s = NULL;
    stein_status status = lab__yaml_edit_begin(&s, text, size, err);
    if (status != STEIN_OK) {
        return status;
    }
    part_name(kind, c->place, part);
    w.of['P'] = part;
    w.of['B'] = c->place;
    set_number(&w, 'a', amount);
    set_number(&w, 's', c->side[0].value);
    set_number(&w, 'o', c->side[1].value);
    set_number(&w, 'm', c->side[2].value);
    set_number(&w, 'i', c->side[3].value);
    if (strcmp(kind->kind, "elastic_hinge") == 0) {
        status = cut_link(s, c, m, site->body, &w, joint, &points, err);
    } else if (strcmp(kind->kind, "axis_translation") == 0) {
        status = carry(s, c, part, err);
    } else if (strcmp(kind->kind, "armature") == 0) {
        status = gear(s, c, w.of['a'], err);
    } else if (site->contact >= 0) {
        status = stand(s, c, m, site->contact, &w, joint, err);
    } else {
        hang(m, &w);
    }
    for (int i = LINES - 1; status == STEIN_OK && i >= 0; i--) {
        status = kind->text[i].entry != NULL ? write_fragment(s, &kind->text[i], &w, err) : status;
    }
    if (status == STEIN_OK && strcmp(kind->name[0], "compliance") == 0) {
        snprintf(entry, sizeof entry, "%s.compliance: %s %s", part, w.of['a'],
                 strcmp(kind->unit[0], "m/N") == 0 ? "m/N" : "rad/N/m");
        status = lab__yaml_edit_add(s, "parameters", entry, err);
    }
    status = status == STEIN_OK ? lab__yaml_edit_text(s, out, nout, err) : status;
    lab__yaml_edit_end(s);
    free(points);
    return status;
}
