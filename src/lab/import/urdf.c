/* SPDX-License-Identifier: GPL-3.0-or-later
 * urdf.c - a robot of ROS as a draft of a mechanism.
 *
 *   robot name
 *     link name:  inertial: origin xyz rpy; mass value; inertia ixx iyy izz ixy ixz iyz
 *     joint name type: parent link; child link; origin xyz rpy; axis xyz; limit lower upper;
 *                      dynamics damping friction; mimic joint multiplier offset
 *
 * Frames are turned against each other by rpy: R = Rz(yaw) Ry(pitch) Rx(roll); see frames.c.
 * A link on a fixed joint is part of its parent, and a point there.
 *
 * Angles of rpy within 1e-3 of a multiple of 90 deg, as 1.57 is, are taken as that multiple.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "draft.h"

static const double pi = 3.141592653589793;
static const double rounding = 1e-3; /* of a right angle written with few digits [rad] */

typedef struct urdf_link {
    const char *label;
    const xml_node *node;
    const xml_node *joint; /* that carries it, NULL: the root */
    int body;              /* of the draft; -1: the frame, -2: not yet */
    double o[3];           /* [m] origin of the link, in the axes of the body from its origin */
    double C[9];           /* from the axes of the link to the body's, row-major */
} urdf_link;

typedef struct urdf_robot {
    draft *d;
    urdf_link link[DRAFT_LINKS];
    int nlink;
    const xml_node *joint[MECH_BODIES]; /* of the bodies of the draft, NULL: none */
} urdf_robot;

/* ---- attributes ---- */

static const char *text_of(const xml_node *node, const char *attribute)
{
    const xml_node *n = xml_child(node, attribute);
    return n != NULL ? n->text : "";
}

/* a number of an attribute, `otherwise` when there is none */
static double number(draft *d, const xml_node *node, const char *attribute, double otherwise)
{
    const xml_node *n = xml_child(node, attribute);
    return n != NULL ? draft_number(d, n, n->text) : otherwise;
}

/* three numbers; untouched when there is no such attribute */
static void three(draft *d, const xml_node *node, const char *attribute, double x[3])
{
    const xml_node *n = xml_child(node, attribute);
    if (n != NULL && draft_numbers(d, n, x, 3) != 3) {
        draft_wrong(d, n, "%s is \"%.60s\", expected three numbers", attribute + 1, n->text);
    }
}

/* <origin>: a place, and the rotation of the frame there */
static void origin(draft *d, const xml_node *node, double x[3], double R[9], const char *where)
{
    const xml_node *n = xml_child(node, "origin");
    double rpy[3] = {0.0, 0.0, 0.0};
    x[0] = x[1] = x[2] = 0.0;
    if (n != NULL) {
        three(d, n, "@xyz", x);
        three(d, n, "@rpy", rpy);
    }
    for (int i = 0; i < 3 && n != NULL; i++) {
        double right = 0.5 * pi * round(rpy[i] / (0.5 * pi));
        double off = fabs(rpy[i] - right);
        if (off > 1e-9 && off < rounding) {
            draft_note(d, "an angle of %.60s (line %d) is %.9g rad: taken as %g deg", where,
                       n->line, rpy[i], right * 180.0 / pi);
        }
        rpy[i] = off < rounding ? right : rpy[i];
    }
    frame_rotation(rpy, R);
}

/* ---- links ---- */

static urdf_link *find_link(urdf_robot *r, const char *label)
{
    for (int i = 0; i < r->nlink; i++) {
        if (strcmp(r->link[i].label, label) == 0) {
            return &r->link[i];
        }
    }
    return NULL;
}

/* mass, centre and inertia: from the axes of <inertial> by the link's to the body's
 */
static void take_inertial(urdf_robot *r, const urdf_link *l, draft_body *b)
{
    static const char *const element[] = {"@ixx", "@iyy", "@izz", "@ixy", "@ixz", "@iyz"};
    draft *d = r->d;
    const xml_node *n = xml_child(l->node, "inertial");
    const xml_node *mass = xml_child(n, "mass"), *inertia = xml_child(n, "inertia");
    double x[3], R[9], T[9], I[6];
    if (n == NULL) {
        return;
    }
    origin(d, n, x, R, l->label);
    frame_turn(l->C, x, b->centre);
    for (int i = 0; i < 3; i++) {
        b->centre[i] += l->o[i];
    }
    frame_multiply(l->C, R, T);
    b->mass = mass != NULL ? number(d, mass, "@value", 0.0) : 0.0;
    for (int e = 0; e < 6; e++) {
        I[e] = inertia != NULL ? number(d, inertia, element[e], 0.0) : 0.0;
    }
    frame_mass(b, T, I);
    draft_note_others(d, n, " origin mass inertia ", l->label);
}

static int is_drawing(const xml_node *node)
{
    return strcmp(node->name, "visual") == 0;
}

static void note_link(urdf_robot *r, const urdf_link *l)
{
    int shapes = 0;
    for (const xml_node *n = l->node->first; n != NULL; n = n->next) {
        shapes += strcmp(n->name, "collision") == 0;
        if (is_drawing(n) || strcmp(n->name, "collision") == 0 ||
            strcmp(n->name, "inertial") == 0 || n->name[0] == '@') {
            continue;
        }
        draft_note(r->d, "<%.60s> of link %.60s (line %d)", n->name, l->label, n->line);
    }
    if (shapes > 0) {
        draft_note(r->d, "%d <collision> of link %.60s: write what touches as contacts", shapes,
                   l->label);
    }
}

/* ---- joints ---- */

static void take_limit(urdf_robot *r, const xml_node *joint, draft_body *b, int turns_on)
{
    draft *d = r->d;
    const xml_node *limit = xml_child(joint, "limit"), *dynamics = xml_child(joint, "dynamics");
    if (limit != NULL && !turns_on) {
        b->limited = 1;
        b->range[0] = number(d, limit, "@lower", 0.0);
        b->range[1] = number(d, limit, "@upper", 0.0);
        if (b->range[0] >= b->range[1]) {
            draft_note(d, "limits of joint %.60s: from %g to %g leaves no range",
                       text_of(joint, "@name"), b->range[0], b->range[1]);
            b->limited = 0;
        }
    }
    if (limit != NULL && (text_of(limit, "@effort")[0] || text_of(limit, "@velocity")[0])) {
        draft_note(d, "limits of effort and velocity of joint %.60s", text_of(joint, "@name"));
    }
    if (dynamics != NULL) {
        b->damping = number(d, dynamics, "@damping", 0.0);
        b->coulomb = number(d, dynamics, "@friction", 0.0);
        if (b->coulomb != 0.0) {
            draft_note(d, "friction of joint %.60s is smooth below %g %s", text_of(joint, "@name"),
                       DRAFT_SMOOTH, b->joint == 'T' ? "m/s" : "rad/s");
        }
    }
}

static const char *label_of(draft *d, const xml_node *joint, const char *child)
{
    const xml_node *n = xml_child(joint, child);
    if (n == NULL) {
        draft_wrong(d, joint, "<joint> \"%.60s\" without a <%s>, expected one",
                    text_of(joint, "@name"), child);
        return "";
    }
    return draft_need(d, n, "@link");
}

/* type of the draft's joint, 0: none of URDF */
static char kind_of(const char *type)
{
    static const struct {
        const char *type;
        char joint;
    } known[] = {{"revolute", 'R'},
                 {"continuous", 'R'},
                 {"prismatic", 'T'},
                 {"fixed", 'F'},
                 {"floating", 'W'}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strcmp(known[i].type, type) == 0) {
            return known[i].joint;
        }
    }
    return 0;
}

/* a link on a fixed joint is part of its parent, or of the frame, where it has no effect;
 * its origin is a point there */
static void take_fixed(urdf_robot *r, urdf_link *l, int carrier, const double at[3])
{
    draft *d = r->d;
    draft_body part = {.mass = 0.0};
    draft_point *p = draft_add_point(d, l->joint, carrier, l->label);
    l->body = carrier;
    memcpy(l->o, at, sizeof l->o);
    if (p != NULL) {
        memcpy(p->x, at, sizeof p->x);
        take_inertial(r, l, &part);
    }
    if (part.mass != 0.0 && carrier >= 0) {
        frame_join(&d->body[carrier], &part);
        draft_note(d, "link %.60s is fixed: part of %s", l->label, d->body[carrier].name);
    }
    d->bodies++;
}

/* a link whose parent has its body */
static void take_child(urdf_robot *r, urdf_link *l, const urdf_link *above)
{
    draft *d = r->d;
    const char *name = draft_need(d, l->joint, "@name"), *type = draft_need(d, l->joint, "@type");
    double x[3], R[9];
    draft_body joint = {.anchor = -1, .sign = 1, .joint = kind_of(type), .axis = 'x'};
    int parent = above->body;
    if (d->status == STEIN_OK && joint.joint == 0) {
        draft_wrong(d, xml_child(l->joint, "@type"),
                    "a joint of type \"%.20s\", expected revolute, continuous, prismatic, fixed or "
                    "floating",
                    type);
    }
    origin(d, l->joint, x, R, name);
    frame_turn(above->C, x, joint.at);
    for (int i = 0; i < 3; i++) {
        joint.at[i] += above->o[i];
    }
    frame_multiply(above->C, R, l->C);
    if (joint.joint == 'F') {
        take_fixed(r, l, above->body, joint.at);
        return;
    }
    if ((joint.joint == 'R' || joint.joint == 'T') && d->status == STEIN_OK) {
        const xml_node *axis = xml_child(l->joint, "axis");
        double a[3] = {1.0, 0.0, 0.0};
        if (axis != NULL) {
            three(d, axis, "@xyz", a);
        }
        if (d->status != STEIN_OK) {
            return;
        }
        frame_axis(d, axis != NULL ? axis : l->joint, name, a, l->C, &joint, &parent);
        take_limit(r, l->joint, &joint, strcmp(type, "continuous") == 0);
    }
    draft_body *b = d->status == STEIN_OK ? draft_add_body(d, l->joint) : NULL;
    if (b == NULL) {
        return;
    }
    *b = joint;
    b->parent = parent;
    draft_name(d, b->name, l->label, "link", DRAFT_PART, 0);
    take_inertial(r, l, b);
    l->body = d->nbody - 1;
    r->joint[l->body] = l->joint;
    d->bodies++;
    if (b->joint == 'R' || b->joint == 'T') {
        draft_add_output(d, name, l->body, -1, 0);
        d->joints++;
    }
    draft_note_others(d, l->joint, " parent child origin axis limit dynamics mimic calibration ",
                      name);
}

/* ---- couplings ---- */

static void take_mimic(urdf_robot *r, int body)
{
    draft *d = r->d;
    const xml_node *node = xml_child(r->joint[body], "mimic");
    const char *label = node != NULL ? draft_need(d, node, "@joint") : "";
    if (node == NULL || d->status != STEIN_OK) {
        return;
    }
    for (int i = 0; i < d->nbody; i++) {
        if (r->joint[i] == NULL || strcmp(text_of(r->joint[i], "@name"), label) != 0 ||
            (d->body[i].joint != 'R' && d->body[i].joint != 'T')) {
            continue;
        }
        draft_coupling *c = draft_add_coupling(d, node, text_of(r->joint[body], "@name"));
        if (c != NULL) {
            c->joint = body;
            c->follows = i;
            c->ratio = number(d, node, "@multiplier", 1.0);
            c->offset = number(d, node, "@offset", 0.0);
            d->body[body].start = DRAFT_GUESSED;
        }
        return;
    }
    draft_wrong(d, node, "<mimic> of joint \"%.60s\", which is no joint that turns or slides",
                label);
}

/* ---- all of it ---- */

static void list_links(urdf_robot *r, const xml_node *root)
{
    draft *d = r->d;
    for (const xml_node *n = xml_child(root, "link"); n != NULL && d->status == STEIN_OK;
         n = xml_next(root, n, "link")) {
        const char *label = draft_need(d, n, "@name");
        if (d->status == STEIN_OK && find_link(r, label) != NULL) {
            draft_wrong(d, n, "a second link \"%.60s\"", label);
        } else if (r->nlink == DRAFT_LINKS) {
            draft_wrong(d, n, "more than %d links", (int)DRAFT_LINKS);
        } else {
            r->link[r->nlink++] = (urdf_link){.label = label, .node = n, .body = -2};
        }
    }
    for (const xml_node *n = xml_child(root, "joint"); n != NULL && d->status == STEIN_OK;
         n = xml_next(root, n, "joint")) {
        const char *parent = label_of(d, n, "parent"), *child = label_of(d, n, "child");
        urdf_link *l = find_link(r, child);
        if (d->status != STEIN_OK) {
            return;
        }
        if (l == NULL || find_link(r, parent) == NULL) {
            draft_wrong(d, n, "joint \"%.60s\" is at \"%.60s\", which is no link",
                        text_of(n, "@name"), l == NULL ? child : parent);
        } else if (l->joint != NULL) {
            draft_wrong(d, n, "link \"%.60s\" hangs on two joints, expected a tree", child);
        } else {
            l->joint = n;
        }
    }
}

/* The root link is the frame, or a fixed body on it if it has a mass. */
static void take_root(urdf_robot *r)
{
    static const double one[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    int roots = 0;
    for (int i = 0; i < r->nlink; i++) {
        urdf_link *l = &r->link[i];
        if (l->joint == NULL) {
            memcpy(l->C, one, sizeof one);
            l->body = -1;
            roots++;
            if (xml_child(l->node, "inertial") != NULL) {
                draft_note(
                    r->d,
                    "link %.60s is the fixed frame: its mass is not needed (a robot that floats: "
                    "give it a link before that and a joint of type floating)",
                    l->label);
            }
        }
    }
    if (roots != 1) {
        draft_wrong(r->d, r->link[0].node,
                    "%d links without a joint that carries them, expected one, the root", roots);
    }
}

/* parents before children; every pass takes all links that have their parent already */
static void take_links(urdf_robot *r)
{
    draft *d = r->d;
    for (int more = 1; more && d->status == STEIN_OK;) {
        more = 0;
        for (int i = 0; i < r->nlink && d->status == STEIN_OK; i++) {
            urdf_link *l = &r->link[i];
            const urdf_link *above =
                l->body == -2 ? find_link(r, label_of(d, l->joint, "parent")) : NULL;
            if (above != NULL && above->body != -2) {
                take_child(r, l, above);
                more = 1;
            }
        }
    }
    for (int i = 0; i < r->nlink && d->status == STEIN_OK; i++) {
        if (r->link[i].body == -2) {
            draft_wrong(d, r->link[i].node, "link \"%.60s\" hangs on itself", r->link[i].label);
        }
        note_link(r, &r->link[i]);
    }
}

static void take_all(urdf_robot *r, const xml_node *root)
{
    draft *d = r->d;
    list_links(r, root);
    if (d->status == STEIN_OK && r->nlink < 2) {
        draft_wrong(d, root, "<robot> with %d links, expected at least two", r->nlink);
    }
    if (d->status == STEIN_OK) {
        take_root(r);
        take_links(r);
    }
    for (int i = 0; i < d->nbody && d->status == STEIN_OK; i++) {
        take_mimic(r, i);
    }
    if (d->status == STEIN_OK && d->joints == 0) {
        draft_wrong(d, root, "a robot without a joint that moves, expected one");
    }
    draft_note_others(d, root, " link joint material ", "the robot");
}

stein_status urdf_take(draft *d, const xml_node *root)
{
    urdf_robot *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return lab__no_memory(d->err);
    }
    r->d = d;
    d->program = "the robot";
    d->gravity[2] = -9.81;
    draft_name(d, d->name, text_of(root, "@name")[0] != '\0' ? text_of(root, "@name") : "robot",
               NULL, DRAFT_PART, 0);
    take_all(r, root);
    free(r);
    return d->status;
}
