/* SPDX-License-Identifier: GPL-3.0-or-later
 * mbs.c - a ROBOTRAN project as a draft of a mechanism.
 *
 *   mbsDescR7
 *     mbsname, base: gravity, point...
 *     bodytree: body...: bodyname, parent: bodyname, pointname; joint...: jointname, type, nature,
 *               initialvalue: q, qd; actuated; mass; com; inertia: Ixx...;
 *               point...: pointname, coordinates, sensor, extforce
 *     cuts:     ball... rod... solid...: name, endpoint1, endpoint2: bodyname, pointname;
 *               length of a rod; ignore: x, y, z
 *     links: link... link3D...; user_models; x3D
 *
 * A body hangs on its parent by any number of joints; here each joint carries a body, so all but
 * the last carry massless ones. The inertia tensor is about the centre of mass in both.
 *
 * A cut closes a loop: ball: the points meet; rod: they keep a distance; solid: the axes of both
 * bodies are parallel as well. The project removes redundant conditions by `ignore`; here all are
 * written, since redundant ones do no harm. Independent joints keep their initial position; for
 * dependent ones it is the start value of the search for a closed position.
 */
#include <stdlib.h>
#include <string.h>

#include "draft.h"

/** A body of the project; its joints are bodies of the draft that follow each other. */
typedef struct mbs_body {
    const char *label;
    const xml_node *node;
    int first, last; /* bodies of the draft; the last one has mass and points */
} mbs_body;

typedef struct mbs_project {
    draft *d;
    mbs_body body[MECH_BODIES];
    int nbody, ncut;
    const char *joint[MECH_BODIES]; /* label of the joint of each body of the draft */
} mbs_project;

static const char *text_of(const xml_node *node, const char *child)
{
    const xml_node *n = xml_child(node, child);
    return n != NULL ? n->text : "";
}

/* a number [SI] of a child; 0 when there is none */
static double number(draft *d, const xml_node *node, const char *child)
{
    const xml_node *n = xml_child(node, child);
    if (n == NULL || n->text[0] == '\0') {
        return 0.0;
    }
    if (xml_next(node, n, child) != NULL) {
        draft_wrong(d, xml_next(node, n, child), "<%s> twice in <%s>, expected once", child,
                    node->name);
    }
    return draft_number(d, n, n->text);
}

/* x, y, z of <coordinates> */
static void place(draft *d, const xml_node *node, double x[3])
{
    static const char *const name[] = {"x", "y", "z"};
    const xml_node *at = xml_child(node, "coordinates");
    for (int i = 0; i < 3 && at != NULL; i++) {
        x[i] = number(d, at, name[i]);
    }
}

/* ---- points ---- */

static void three(draft *d, const char *label, int point, int velocity)
{
    static const char *const axis[2][3] = {{"x", "y", "z"}, {"vx", "vy", "vz"}};
    for (int i = 0; i < 3; i++) {
        char name[80];
        snprintf(name, sizeof name, "%.24s_%s", label, axis[velocity][i]);
        draft_add_output(d, name, 0, point, 3 * velocity + i);
    }
}

static void take_sensor(draft *d, const xml_node *node, int point)
{
    static const char *const rest[] = {"@Rot", "@Om", "@Acc", "@Omp", "@Jac"};
    const char *name = text_of(node, "@name"), *label = d->point[point].label;
    name = name[0] != '\0' ? name : label;
    three(d, name, point, 0);
    if (strcmp(text_of(node, "@Vit"), "true") == 0) {
        three(d, name, point, 1);
    }
    for (int i = 0; i < 5; i++) {
        if (strcmp(text_of(node, rest[i]), "true") == 0) {
            draft_note(d, "sensor \"%.60s\": %s is not read here", name, rest[i] + 1);
        }
    }
}

static void take_force(draft *d, const xml_node *node, int point, const char *where)
{
    const char *label = text_of(node, "@name");
    char base[MECH_NAME];
    snprintf(base, sizeof base, "%.24s", label[0] != '\0' ? label : d->point[point].label);
    for (int i = 0; i < 3; i++) {
        char name[MECH_NAME];
        snprintf(name, sizeof name, "%.24s_%c", base, "xyz"[i]);
        draft_add_input(d, name, DRAFT_FORCE, point, i);
    }
    draft_note(d,
               "external force \"%.40s\" on %.40s.%s: its law is in user code (user_ExtForces); "
               "inputs are its components along the fixed axes, a moment is left out",
               label, where, d->point[point].name);
}

static void take_points(draft *d, const xml_node *node, int body, const char *where)
{
    for (const xml_node *n = xml_child(node, "point"); n != NULL && d->status == STEIN_OK;
         n = xml_next(node, n, "point")) {
        draft_point *p = draft_add_point(d, n, body, draft_need(d, n, "pointname"));
        if (p == NULL) {
            return;
        }
        int index = d->npoint - 1;
        place(d, n, p->x);
        draft_note_others(d, n, " pointname coordinates graphics symbols sensor extforce ",
                          p->label);
        if (xml_child(n, "sensor") != NULL) {
            take_sensor(d, xml_child(n, "sensor"), index);
        }
        if (xml_child(n, "extforce") != NULL) {
            take_force(d, xml_child(n, "extforce"), index, where);
        }
    }
}

/* ---- joints ---- */

static void take_nature(mbs_project *p, const xml_node *node, draft_body *b, const char *name)
{
    draft *d = p->d;
    int body = d->nbody - 1;
    const char *nature = text_of(node, "nature");
    char label[MECH_NAME];
    b->start = DRAFT_STATED;
    if (strcmp(nature, "driven") == 0 || strcmp(nature, "locked") == 0) {
        snprintf(label, sizeof label, "drive_%.26s", name);
        draft_add_input(d, label, DRAFT_MOTION, body, 0);
    } else if (strcmp(nature, "dependent") == 0 && p->ncut > 0) {
        b->start = DRAFT_GUESSED;
        b->qd = 0.0;
    } else if (strcmp(nature, "dependent") == 0) {
        draft_note(d,
                   "joint %s is dependent, but there are no cuts: its condition is in user code "
                   "(user_cons_hJ); here it is free",
                   name);
    } else if (nature[0] != '\0' && strcmp(nature, "independent") != 0) {
        draft_note(d, "joint %s is \"%.40s\": here it is free", name, nature);
    }
    if (xml_child(node, "actuated") != NULL) {
        snprintf(label, sizeof label, "motor_%.26s", name);
        draft_add_input(d, label, DRAFT_TORQUE, body, 0);
    }
}

static void take_joint(mbs_project *p, const xml_node *node, int above)
{
    draft *d = p->d;
    const char *label = draft_need(d, node, "jointname"), *type = draft_need(d, node, "type");
    const xml_node *initial = xml_child(node, "initialvalue");
    draft_body *b = d->status == STEIN_OK ? draft_add_body(d, node) : NULL;
    if (b == NULL) {
        return;
    }
    if ((type[0] != 'R' && type[0] != 'T') || type[1] < '1' || type[1] > '3' || type[2] != '\0') {
        draft_wrong(d, xml_child(node, "type"),
                    "a joint of type \"%.20s\", expected T1 T2 T3 R1 R2 R3", type);
        return;
    }
    b->joint = type[0];
    b->axis = (char)('x' + type[1] - '1');
    b->parent = above;
    if (initial != NULL) {
        b->q = number(d, initial, "q");
        b->qd = number(d, initial, "qd");
        draft_note_others(d, initial, " q qd qdd ", label);
    }
    p->joint[d->nbody - 1] = label;
    draft_add_output(d, label, d->nbody - 1, -1, 0);
    const char *name = d->output[d->noutput - 1].name;
    if (strcmp(name, label) != 0) {
        draft_note(d, "joint \"%.60s\" is called %s here", label, name);
    }
    draft_note_others(d, node, " jointname type nature initialvalue actuated graphics symbols ",
                      label);
    take_nature(p, node, b, name);
    d->joints++;
}

/* ---- bodies ---- */

static void take_mass(draft *d, const xml_node *node, draft_body *b)
{
    static const char *const inertia[] = {"Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"};
    const xml_node *com = xml_child(node, "com"), *tensor = xml_child(node, "inertia");
    b->mass = number(d, node, "mass");
    if (com != NULL) {
        place(d, com, b->centre);
    }
    for (int i = 0; i < DRAFT_INERTIA && tensor != NULL; i++) {
        b->inertia[i] = number(d, tensor, inertia[i]);
    }
}

static void take_body(mbs_project *p, const xml_node *node)
{
    draft *d = p->d;
    if (p->nbody == MECH_BODIES) {
        draft_wrong(d, node, "more than %d bodies", (int)MECH_BODIES);
        return;
    }
    mbs_body *body = &p->body[p->nbody];
    *body = (mbs_body){.label = draft_need(d, node, "bodyname"), .node = node, .first = d->nbody};
    for (const xml_node *n = xml_child(node, "joint"); n != NULL && d->status == STEIN_OK;
         n = xml_next(node, n, "joint")) {
        take_joint(p, n, d->nbody > body->first ? d->nbody - 1 : -1);
    }
    body->last = d->nbody - 1;
    if (d->status == STEIN_OK && body->last < body->first) {
        draft_wrong(d, node, "body \"%.60s\" has no joint, expected at least one", body->label);
    }
    if (d->status != STEIN_OK) {
        return;
    }
    draft_body *b = &d->body[body->last];
    draft_name(d, b->name, body->label, "body", DRAFT_PART, 0);
    take_mass(d, node, b);
    draft_note_others(d, xml_child(node, "inertia"), " Ixx Iyy Izz Ixy Ixz Iyz symbols ",
                      body->label);
    draft_note_others(d, node, " bodyname parent joint mass com inertia point graphics symbols ",
                      body->label);
    p->nbody++;
    d->bodies++;
    take_points(d, node, body->last, b->name);
}

/* massless bodies between joints are called like the joint before them */
static void name_carriers(mbs_project *p)
{
    draft *d = p->d;
    for (int i = 0; i < d->nbody; i++) {
        if (d->body[i].name[0] == '\0') {
            draft_name(d, d->body[i].name, p->joint[i], NULL, DRAFT_PART, 0);
        }
    }
}

/* ---- the tree ---- */

enum { BASE = -1, NONE = -2 };

/* body of the project by its name; BASE, NONE */
static int find_body(const mbs_project *p, const char *label)
{
    for (int i = 0; i < p->nbody; i++) {
        if (strcmp(p->body[i].label, label) == 0) {
            return i;
        }
    }
    return strcmp(label, "base") == 0 ? BASE : NONE;
}

/* point of a body of the draft by its name in the file; -1: its origin, NONE */
static int find_point(const draft *d, int body, const char *label)
{
    for (int i = 0; i < d->npoint; i++) {
        if (d->point[i].body == body && strcmp(d->point[i].label, label) == 0) {
            return i;
        }
    }
    return strcmp(label, "origin") == 0 || label[0] == '\0' ? -1 : NONE;
}

static void find_parent(mbs_project *p, const mbs_body *body)
{
    draft *d = p->d;
    draft_body *b = &d->body[body->first];
    const xml_node *parent = xml_child(body->node, "parent");
    if (parent == NULL) {
        draft_wrong(d, body->node, "body \"%.60s\" has no <parent>, expected one", body->label);
        return;
    }
    const char *label = draft_need(d, parent, "bodyname"), *anchor = text_of(parent, "pointname");
    int above = d->status == STEIN_OK ? find_body(p, label) : BASE;
    if (above == NONE) {
        draft_wrong(d, parent, "body \"%.50s\" hangs on \"%.50s\", which is no body", body->label,
                    label);
        return;
    }
    b->parent = above == BASE ? -1 : p->body[above].last;
    b->anchor = find_point(d, b->parent, anchor);
    if (b->anchor == NONE) {
        draft_wrong(d, parent, "body \"%.40s\" hangs on \"%.40s.%.40s\", which is no point",
                    body->label, label, anchor);
    }
}

/* every body ends at the base when one goes from parent to parent */
static void check_tree(mbs_project *p)
{
    const draft *d = p->d;
    for (int i = 0; i < p->nbody; i++) {
        int at = p->body[i].first, steps = 0;
        while (at >= 0 && steps <= d->nbody) {
            at = d->body[at].parent;
            steps++;
        }
        if (at >= 0) {
            draft_wrong(p->d, p->body[i].node, "body \"%.60s\" hangs on itself", p->body[i].label);
        }
    }
}

/* ---- cuts and links ---- */

/* @return point of the draft that an <endpoint1> or <endpoint2> names */
static int find_end(mbs_project *p, const xml_node *node, const char *end)
{
    draft *d = p->d;
    static const double zero[3];
    const xml_node *at = xml_child(node, end);
    if (at == NULL) {
        draft_wrong(d, node, "<%s> \"%.40s\" without an <%s>, expected one", node->name,
                    text_of(node, "name"), end);
        return -1;
    }
    int body = find_body(p, text_of(at, "bodyname"));
    int carrier = body >= 0 ? p->body[body].last : -1;
    int point = body == NONE ? NONE : find_point(d, carrier, text_of(at, "pointname"));
    if (point == NONE) {
        draft_wrong(d, at, "<%s> \"%.40s\" ends at \"%.40s.%.40s\", which is no point", node->name,
                    text_of(node, "name"), text_of(at, "bodyname"), text_of(at, "pointname"));
        return -1;
    }
    return point >= 0 ? point : draft_point_at(d, at, carrier, zero, "origin");
}

/* @return a pair of points of the project, NULL with an error */
static draft_loop *take_pair(mbs_project *p, const xml_node *n)
{
    draft *d = p->d;
    int a = find_end(p, n, "endpoint1"), b = find_end(p, n, "endpoint2");
    const char *label = text_of(n, "name");
    draft_loop *l =
        d->status == STEIN_OK ? draft_add_loop(d, n, label[0] != '\0' ? label : n->name) : NULL;
    if (l != NULL) {
        l->point[0] = a;
        l->point[1] = b;
    }
    return l;
}

static void take_cut(mbs_project *p, const xml_node *n)
{
    draft *d = p->d;
    int ball = strcmp(n->name, "ball") == 0, rod = strcmp(n->name, "rod") == 0;
    if (!ball && !rod && strcmp(n->name, "solid") != 0) {
        draft_wrong(d, n, "a cut <%.40s>, expected <ball>, <rod> or <solid>", n->name);
        return;
    }
    draft_loop *l = take_pair(p, n);
    if (l == NULL) {
        return;
    }
    l->kind = ball ? DRAFT_MEET : rod ? DRAFT_ROD : DRAFT_WELD;
    if (rod) {
        const xml_node *length = xml_child(n, "length");
        const char *text = draft_need(d, n, "length");
        l->length = d->status == STEIN_OK ? draft_number(d, length, text) : 0.0;
    }
    if (xml_child(n, "ignore") != NULL && xml_child(n, "ignore")->first != NULL) {
        draft_note(d,
                   "cut %s ignores some of its conditions: here all hold; compare the degrees of "
                   "freedom of stein check with the independent joints",
                   l->name);
    }
    draft_note_others(d, n, " name endpoint1 endpoint2 length ignore graphics symbols ", l->name);
}

static void take_link(mbs_project *p, const xml_node *n)
{
    draft *d = p->d;
    if (strcmp(n->name, "link") != 0) {
        draft_note(d, "<%.40s> \"%.60s\": its law is in user code (user_Link3DForces)", n->name,
                   text_of(n, "name"));
        return;
    }
    draft_loop *l = take_pair(p, n);
    if (l == NULL) {
        return;
    }
    l->kind = DRAFT_LINK;
    draft_note(d,
               "link %s: its law is in user code (user_LinkForces); here it has no stiffness, set "
               "%s.k, %s.length and %s.damping",
               l->name, l->name, l->name, l->name);
}

static void take_pairs(mbs_project *p, const xml_node *root)
{
    const xml_node *cuts = xml_child(root, "cuts"), *links = xml_child(root, "links");
    for (const xml_node *n = cuts != NULL ? cuts->first : NULL; n != NULL; n = n->next) {
        if (p->d->status == STEIN_OK && n->name[0] != '@') {
            take_cut(p, n);
        }
    }
    for (const xml_node *n = links != NULL ? links->first : NULL; n != NULL; n = n->next) {
        if (p->d->status == STEIN_OK && n->name[0] != '@') {
            take_link(p, n);
        }
    }
}

/* ---- all of it ---- */

static int count_cuts(const xml_node *cuts)
{
    int k = 0;
    for (const xml_node *n = cuts != NULL ? cuts->first : NULL; n != NULL; n = n->next) {
        k += n->name[0] != '@';
    }
    return k;
}

static void note_rest(draft *d, const xml_node *root)
{
    const xml_node *models = xml_child(root, "user_models");
    for (const xml_node *n = models != NULL ? models->first : NULL; n != NULL; n = n->next) {
        draft_note(d, "user model \"%.60s\"", text_of(n, "name"));
    }
    draft_note_others(d, xml_child(root, "bodytree"), " body ", "the tree");
    draft_note_others(d, root,
                      " mbsname mbsyspad_version base bodytree cuts links user_models x3D "
                      "graphics ",
                      "the project");
    draft_note_others(d, xml_child(root, "base"), " gravity baseBodyName graphics point symbols ",
                      "the base");
}

static void take_all(mbs_project *p, const xml_node *root)
{
    draft *d = p->d;
    const xml_node *base = xml_child(root, "base"), *tree = xml_child(root, "bodytree");
    if (tree == NULL) {
        draft_wrong(d, root, "<%s> without a <bodytree>, expected a project of ROBOTRAN",
                    root->name);
        return;
    }
    if (base != NULL) {
        if (xml_child(base, "gravity") != NULL) {
            place(d, xml_child(base, "gravity"), d->gravity);
        }
        take_points(d, base, -1, "base");
    }
    p->ncut = count_cuts(xml_child(root, "cuts"));
    for (const xml_node *n = xml_child(tree, "body"); n != NULL && d->status == STEIN_OK;
         n = xml_next(tree, n, "body")) {
        take_body(p, n);
    }
    if (d->status == STEIN_OK && p->nbody == 0) {
        draft_wrong(d, tree, "<bodytree> without a <body>, expected one");
    }
    for (int i = 0; i < p->nbody && d->status == STEIN_OK; i++) {
        find_parent(p, &p->body[i]);
    }
    if (d->status == STEIN_OK) {
        check_tree(p);
        name_carriers(p);
        take_pairs(p, root);
        note_rest(d, root);
    }
}

stein_status mbs_take(draft *d, const xml_node *root)
{
    mbs_project *p = calloc(1, sizeof *p);
    const char *name = text_of(root, "mbsname");
    if (p == NULL) {
        return lab__no_memory(d->err);
    }
    p->d = d;
    d->program = "ROBOTRAN's project";
    draft_name(d, d->name, name[0] != '\0' ? name : "imported", NULL, DRAFT_PART, 0);
    take_all(p, root);
    free(p);
    return d->status;
}
