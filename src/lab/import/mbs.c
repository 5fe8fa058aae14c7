/* SPDX-License-Identifier: GPL-3.0-or-later
 * mbs.c - the elements of a ROBOTRAN project: tree, joints, masses, points, and what is left out.
 *
 *   mbsDescR7
 *     mbsname, base: gravity, point...
 *     bodytree: body...: bodyname, parent: bodyname, pointname; joint...: jointname, type, nature,
 *               initialvalue: q, qd; mass; com; inertia: Ixx...; point...: pointname, coordinates
 *     cuts, links, user_models, x3D
 *
 * A body hangs on its parent by any number of joints; here each joint carries a body, so all but
 * the last carry massless ones. The inertia tensor is about the centre of mass in both.
 */
#include "mbs.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* say that something is left out or renamed */
static void note(mbs_project *p, const char *format, ...)
{
    char text[240];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    char **more = realloc(p->note, ((size_t)p->nnote + 1) * sizeof *more);
    char *copy = lab__text("%s", lab__one_line(text)); // a name may hold anything
    p->note = more != NULL ? more : p->note;
    if (more == NULL || copy == NULL) {
        free(copy);
        p->status = lab__no_memory(p->err);
        return;
    }
    p->note[p->nnote++] = copy;
    if (p->report != NULL) {
        p->report(p->ctx, copy);
    }
}

static stein_status wrong(mbs_project *p, const xml_node *at, const char *format, ...)
{
    char text[160];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return lab__fail(p->err, STEIN_EPARSE, "%s:%d:%d: %s", p->file, at->line, at->column, text);
}

/* ---- names ---- */

static int is_word_of_c(const char *name)
{
    static const char words[] = " auto break case char const continue default do double else enum "
                                "extern float for goto if inline int long register restrict return "
                                "short signed sizeof static struct switch typedef union unsigned "
                                "void volatile while frame load ";
    char spaced[MECH_NAME + 2];
    snprintf(spaced, sizeof spaced, " %s ", name);
    return strstr(words, spaced) != NULL;
}

/* a name that a mechanism file takes; room for a suffix is left */
static void clean(char name[MECH_NAME], const char *label)
{
    int n = 0;
    if (!((label[0] | 32) >= 'a' && (label[0] | 32) <= 'z')) {
        name[n++] = 'n';
    }
    for (; *label != '\0' && n < MECH_NAME - 5; label++) {
        int fine = ((*label | 32) >= 'a' && (*label | 32) <= 'z') ||
                   (*label >= '0' && *label <= '9') || *label == '_';
        name[n++] = '_';
        if (fine) {
            name[n - 1] = *label;
        }
    }
    name[n] = '\0';
    if (is_word_of_c(name)) {
        name[n] = '_';
        name[n + 1] = '\0';
    }
}

static void copy_name(char to[MECH_NAME], const char *from)
{
    size_t n = strlen(from);
    n = n < MECH_NAME ? n : MECH_NAME - 1;
    memmove(to, from, n);
    to[n] = '\0';
}

/* the same name with a number behind it */
static void number_name(char name[MECH_NAME], const char *base, int i)
{
    snprintf(name, MECH_NAME, "%.27s_%d", base, i % 1000);
}

/* clean, and no other name than those that `taken` knows */
static void give_name(mbs_project *p, char name[MECH_NAME], const char *label, const char *what,
                      int (*taken)(const mbs_project *p, const char *name, int owner), int owner)
{
    char base[MECH_NAME];
    clean(base, label);
    copy_name(name, base);
    for (int i = 2; taken(p, name, owner); i++) {
        number_name(name, base, i);
    }
    if (strcmp(name, label) != 0) {
        note(p, "%s \"%.60s\" is called %s here", what, label, name);
    }
}

static int body_taken(const mbs_project *p, const char *name, int owner)
{
    (void)owner;
    for (int i = 0; i < p->nbody; i++) {
        if (strcmp(p->body[i].name, name) == 0) {
            return 1;
        }
    }
    for (int i = 0; i < p->njoint; i++) {
        if (strcmp(p->joint[i].carries, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static int joint_taken(const mbs_project *p, const char *name, int owner)
{
    (void)owner;
    for (int i = 0; i < p->njoint; i++) {
        if (strcmp(p->joint[i].name, name) == 0) {
            return 1;
        }
    }
    return strcmp(name, "time") == 0;
}

static int point_taken(const mbs_project *p, const char *name, int owner)
{
    for (int i = 0; i < p->npoint; i++) {
        if (p->point[i].body == owner && strcmp(p->point[i].name, name) == 0) {
            return 1;
        }
    }
    return 0;
}

/* ---- parts ---- */

/* text of a child that has to be there */
static stein_status need(mbs_project *p, const xml_node *node, const char *child, const char **text)
{
    const xml_node *n = xml_child(node, child);
    if (n == NULL || n->text[0] == '\0') {
        return wrong(p, n != NULL ? n : node, "<%s> without a <%s>, expected one", node->name,
                     child);
    }
    *text = n->text;
    return STEIN_OK;
}

/* a number [SI] of a child; it stays 0 when there is none */
static stein_status number(mbs_project *p, const xml_node *node, const char *child, double *value)
{
    const xml_node *n = xml_child(node, child);
    stein_err why;
    if (n == NULL || n->text[0] == '\0') {
        return STEIN_OK;
    }
    if (xml_next(node, n, child) != NULL) {
        return wrong(p, xml_next(node, n, child), "<%s> twice in <%s>, expected once", child,
                     node->name);
    }
    if (mech_parse_quantity(n->text, (mech_dim){0}, value, &why) != STEIN_OK) {
        return wrong(p, n, "<%s> is \"%.40s\", expected a number", child, n->text);
    }
    return STEIN_OK;
}

/* x, y, z of <coordinates> in a child, or in the node itself */
static stein_status place(mbs_project *p, const xml_node *node, double x[3])
{
    static const char *const name[] = {"x", "y", "z"};
    const xml_node *at = xml_child(node, "coordinates");
    stein_status status = STEIN_OK;
    for (int i = 0; i < 3 && at != NULL && status == STEIN_OK; i++) {
        status = number(p, at, name[i], &x[i]);
    }
    return status;
}

/* unknown elements are reported, except drawings */
static void note_others(mbs_project *p, const xml_node *node, const char *known, const char *where)
{
    for (const xml_node *n = node != NULL ? node->first : NULL; n != NULL; n = n->next) {
        char spaced[64];
        snprintf(spaced, sizeof spaced, " %.60s ", n->name);
        if (strstr(known, spaced) == NULL && n->name[0] != '@') {
            note(p, "<%.60s> of %.60s (line %d)", n->name, where, n->line);
        }
    }
}

static stein_status take_point(mbs_project *p, const xml_node *node, int body, const char *where)
{
    if (p->npoint == MBS_POINTS) {
        return wrong(p, node, "more than %d points", (int)MBS_POINTS);
    }
    mbs_point *point = &p->point[p->npoint];
    *point = (mbs_point){.body = body};
    stein_status status = need(p, node, "pointname", &point->label);
    status = status == STEIN_OK ? place(p, node, point->x) : status;
    if (status != STEIN_OK) {
        return status;
    }
    give_name(p, point->name, point->label, "point", point_taken, body);
    p->npoint++;
    note_others(p, node, " pointname coordinates graphics symbols sensor extforce ", point->label);
    if (xml_child(node, "sensor") != NULL) {
        const xml_node *name = xml_child(xml_child(node, "sensor"), "@name");
        note(p, "sensor \"%.40s\": read it as an output, {point: %s.%s, read: z}",
             name != NULL ? name->text : "", body < 0 ? "frame" : p->body[body].name, point->name);
    }
    if (xml_child(node, "extforce") != NULL) {
        const xml_node *name = xml_child(xml_child(node, "extforce"), "@name");
        note(p, "external force \"%.40s\" on %.40s.%s: its law is in user code",
             name != NULL ? name->text : "", where, point->name);
    }
    return STEIN_OK;
}

static stein_status take_points(mbs_project *p, const xml_node *node, int body, const char *where)
{
    stein_status status = STEIN_OK;
    for (const xml_node *n = xml_child(node, "point"); n != NULL && status == STEIN_OK;
         n = xml_next(node, n, "point")) {
        status = take_point(p, n, body, where);
    }
    return status;
}

static stein_status take_joint(mbs_project *p, const xml_node *node, int body)
{
    const char *type = "", *nature = "independent";
    if (p->njoint == MBS_JOINTS) {
        return wrong(p, node, "more than %d joints", (int)MBS_JOINTS);
    }
    mbs_joint j = {.body = body};
    stein_status status = need(p, node, "jointname", &j.label);
    status = status == STEIN_OK ? need(p, node, "type", &type) : status;
    if (status != STEIN_OK) {
        return status;
    }
    if ((type[0] != 'R' && type[0] != 'T') || type[1] < '1' || type[1] > '3' || type[2] != '\0') {
        return wrong(p, xml_child(node, "type"),
                     "a joint of type \"%.20s\", expected T1 T2 T3 R1 "
                     "R2 R3",
                     type);
    }
    const xml_node *initial = xml_child(node, "initialvalue"), *is = xml_child(node, "nature");
    j.type = type[0];
    j.axis = (char)('x' + type[1] - '1');
    nature = is != NULL ? is->text : nature;
    j.driven = strcmp(nature, "driven") == 0 || strcmp(nature, "locked") == 0;
    if (initial != NULL) {
        status = number(p, initial, "q", &j.q);
        status = status == STEIN_OK ? number(p, initial, "qd", &j.qd) : status;
        note_others(p, initial, " q qd ", j.label);
    }
    if (status != STEIN_OK) {
        return status;
    }
    give_name(p, j.name, j.label, "joint", joint_taken, 0);
    note_others(p, node, " jointname type nature initialvalue graphics symbols ", j.label);
    if (strcmp(nature, "dependent") == 0) {
        note(p, "joint %s depends on a loop, which stays open: here it is free", j.name);
    } else if (!j.driven && strcmp(nature, "independent") != 0) {
        note(p, "joint %s is \"%.40s\": here it is free", j.name, nature);
    }
    p->joint[p->njoint++] = j;
    return STEIN_OK;
}

/* the joints of a body; all but the last carry a massless one, called like the joint */
static stein_status take_joints(mbs_project *p, const xml_node *node, int body)
{
    int first = p->njoint;
    stein_status status = STEIN_OK;
    for (const xml_node *n = xml_child(node, "joint"); n != NULL && status == STEIN_OK;
         n = xml_next(node, n, "joint")) {
        status = take_joint(p, n, body);
    }
    if (status == STEIN_OK && p->njoint == first) {
        return wrong(p, node, "body \"%.60s\" has no joint, expected at least one",
                     p->body[body].label);
    }
    return status;
}

static void name_carriers(mbs_project *p)
{
    for (int i = 0; i < p->njoint; i++) {
        mbs_joint *j = &p->joint[i];
        int last = i + 1 == p->njoint || p->joint[i + 1].body != j->body;
        if (last) {
            copy_name(j->carries, p->body[j->body].name);
            continue;
        }
        char name[MECH_NAME];
        copy_name(name, j->name);
        for (int k = 2; body_taken(p, name, 0); k++) {
            number_name(name, j->name, k);
        }
        copy_name(j->carries, name);
    }
}

static stein_status take_body(mbs_project *p, const xml_node *node)
{
    static const char *const inertia[] = {"Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"};
    if (p->nbody == MBS_BODIES) {
        return wrong(p, node, "more than %d bodies", (int)MBS_BODIES);
    }
    int body = p->nbody;
    mbs_body *b = &p->body[body];
    *b = (mbs_body){.node = node};
    stein_status status = need(p, node, "bodyname", &b->label);
    status = status == STEIN_OK ? number(p, node, "mass", &b->mass) : status;
    const xml_node *com = xml_child(node, "com"), *tensor = xml_child(node, "inertia");
    status = status == STEIN_OK && com != NULL ? place(p, com, b->centre) : status;
    for (int i = 0; i < MBS_INERTIA && tensor != NULL && status == STEIN_OK; i++) {
        status = number(p, tensor, inertia[i], &b->inertia[i]);
    }
    if (status != STEIN_OK) {
        return status;
    }
    give_name(p, b->name, b->label, "body", body_taken, 0);
    p->nbody++;
    note_others(p, tensor, " Ixx Iyy Izz Ixy Ixz Iyz symbols ", b->label);
    note_others(p, node, " bodyname parent joint mass com inertia point graphics symbols ",
                b->label);
    status = take_joints(p, node, body);
    return status == STEIN_OK ? take_points(p, node, body, b->name) : status;
}

/* ---- the tree ---- */

/* body by its name in the file; -1: the base, -2: none */
static int find_body(const mbs_project *p, const char *label)
{
    for (int i = 0; i < p->nbody; i++) {
        if (strcmp(p->body[i].label, label) == 0) {
            return i;
        }
    }
    return strcmp(label, "base") == 0 ? -1 : -2;
}

/* point of a body by its name in the file; -1: its origin, -2: none */
static int find_point(const mbs_project *p, int body, const char *label)
{
    for (int i = 0; i < p->npoint; i++) {
        if (p->point[i].body == body && strcmp(p->point[i].label, label) == 0) {
            return i;
        }
    }
    return strcmp(label, "origin") == 0 ? -1 : -2;
}

static stein_status find_parent(mbs_project *p, mbs_body *b)
{
    const xml_node *parent = xml_child(b->node, "parent");
    const char *label = "", *anchor = "origin";
    if (parent == NULL) {
        return wrong(p, b->node, "body \"%.60s\" has no <parent>, expected one", b->label);
    }
    stein_status status = need(p, parent, "bodyname", &label);
    if (status != STEIN_OK) {
        return status;
    }
    const xml_node *at = xml_child(parent, "pointname");
    anchor = at != NULL ? at->text : anchor;
    b->parent = find_body(p, label);
    if (b->parent == -2) {
        return wrong(p, parent, "body \"%.50s\" hangs on \"%.50s\", which is no body", b->label,
                     label);
    }
    b->anchor = find_point(p, b->parent, anchor);
    if (b->anchor == -2) {
        return wrong(p, at, "body \"%.40s\" hangs on \"%.40s.%.40s\", which is no point", b->label,
                     label, anchor);
    }
    return STEIN_OK;
}

/* every body ends at the base when one goes from parent to parent */
static stein_status check_tree(mbs_project *p)
{
    for (int i = 0; i < p->nbody; i++) {
        int at = i, steps = 0;
        while (at >= 0 && steps <= p->nbody) {
            at = p->body[at].parent;
            steps++;
        }
        if (at >= 0) {
            return wrong(p, p->body[i].node, "body \"%.60s\" hangs on itself", p->body[i].label);
        }
    }
    return STEIN_OK;
}

/* ---- what is left out ---- */

static const char *text_of(const xml_node *node, const char *child)
{
    const xml_node *n = xml_child(node, child);
    return n != NULL ? n->text : "";
}

static void note_pair(mbs_project *p, const xml_node *n, const char *what, const char *then)
{
    const xml_node *a = xml_child(n, "endpoint1"), *b = xml_child(n, "endpoint2");
    note(p, "%s \"%.30s\" between %.30s.%.30s and %.30s.%.30s: %s", what, text_of(n, "name"),
         text_of(a, "bodyname"), text_of(a, "pointname"), text_of(b, "bodyname"),
         text_of(b, "pointname"), then);
}

static void note_rest(mbs_project *p, const xml_node *root)
{
    const xml_node *cuts = xml_child(root, "cuts"), *links = xml_child(root, "links"),
                   *models = xml_child(root, "user_models");
    for (const xml_node *n = cuts != NULL ? cuts->first : NULL; n != NULL; n = n->next) {
        char what[80];
        snprintf(what, sizeof what, "cut (%.60s)", n->name);
        note_pair(p, n, what, "the loop stays open");
    }
    for (const xml_node *n = links != NULL ? links->first : NULL; n != NULL; n = n->next) {
        note_pair(p, n, "link", "its law is in user code, see links: k, length, damping");
    }
    for (const xml_node *n = models != NULL ? models->first : NULL; n != NULL; n = n->next) {
        note(p, "user model \"%.60s\"", text_of(n, "name"));
    }
    note_others(p, root,
                " mbsname mbsyspad_version base bodytree cuts links user_models x3D "
                "graphics ",
                "the project");
    note_others(p, xml_child(root, "base"), " gravity baseBodyName graphics point symbols ",
                "the base");
}

stein_status mbs_take(mbs_project *p, const xml_node *root)
{
    const xml_node *base = xml_child(root, "base"), *tree = xml_child(root, "bodytree");
    if (strncmp(root->name, "mbsDesc", 7) != 0 || tree == NULL) {
        return wrong(p, root, "<%.40s>, expected a ROBOTRAN project: <mbsDescR7> with a <bodytree>",
                     root->name);
    }
    clean(p->name, text_of(root, "mbsname")[0] != '\0' ? text_of(root, "mbsname") : "imported");
    const xml_node *gravity = xml_child(base, "gravity");
    stein_status status = gravity != NULL ? place(p, gravity, p->gravity) : STEIN_OK;
    status = status == STEIN_OK && base != NULL ? take_points(p, base, -1, "base") : status;
    for (const xml_node *n = xml_child(tree, "body"); n != NULL && status == STEIN_OK;
         n = xml_next(tree, n, "body")) {
        status = take_body(p, n);
    }
    for (int i = 0; i < p->nbody && status == STEIN_OK; i++) {
        status = find_parent(p, &p->body[i]);
    }
    status = status == STEIN_OK ? check_tree(p) : status;
    if (status == STEIN_OK && p->nbody == 0) {
        status = wrong(p, tree, "<bodytree> without a <body>, expected one");
    }
    if (status == STEIN_OK) {
        name_carriers(p);
        note_others(p, tree, " body ", "the tree");
        note_rest(p, root);
        status = p->status;
    }
    return status;
}
