/* SPDX-License-Identifier: GPL-3.0-or-later
 * mjcf.c - a model of MuJoCo as a draft of a mechanism.
 *
 *   mujoco model
 *     compiler: angle, eulerseq; option: gravity
 *     default class: joint, geom...; default...
 *     worldbody: body...: pos, orientation; inertial; geom...; joint...; freejoint; body...
 *     equality:  connect, weld, joint
 *     actuator:  motor...
 *
 * The joints of a body follow each other; each has its place in the frame of the body.
 * In a draft each carries a body with its origin there. A body without a joint is part of its
 * parent, and a point there. Axes: frames.c. Missing attributes of an element come from its class:
 * its `class`, or `childclass` of the nearest body around it.
 *
 * Mass and inertia come from <inertial>, otherwise from the geoms: mjcf_geoms.c.
 */
#include "mjcf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double one[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};

/* ---- attributes ---- */

static const xml_node *find_class(const xml_node *node, const char *name)
{
    for (const xml_node *n = xml_child(node, "default"); n != NULL;
         n = xml_next(node, n, "default")) {
        const xml_node *label = xml_child(n, "@class"), *inner;
        if (label != NULL && strcmp(label->text, name) == 0) {
            return n;
        }
        if ((inner = find_class(n, name)) != NULL) {
            return inner;
        }
    }
    return NULL;
}

static const xml_node *class_of(const mjcf *m, const xml_node *node)
{
    const xml_node *name = xml_child(node, "@class");
    for (const xml_node *n = node->parent; n != NULL && name == NULL; n = n->parent) {
        name = xml_child(n, "@childclass");
    }
    const xml_node *found = name != NULL ? find_class(m->root, name->text) : NULL;
    if (name != NULL && found == NULL && strcmp(name->text, "main") != 0) {
        draft_wrong(m->d, name, "there is no default class \"%.60s\"", name->text);
    }
    return found != NULL ? found : xml_child(m->root, "default");
}

const xml_node *mjcf_attribute(const mjcf *m, const xml_node *node, const char *name)
{
    const xml_node *own = xml_child(node, name);
    const char *element = strcmp(node->name, "freejoint") == 0 ? "joint" : node->name;
    const xml_node *level = own == NULL ? class_of(m, node) : NULL;
    for (; own == NULL && level != NULL && strcmp(level->name, "default") == 0;
         level = level->parent) {
        own = xml_child(xml_child(level, element), name);
    }
    return own;
}

const char *mjcf_text(const mjcf *m, const xml_node *node, const char *name)
{
    const xml_node *n = mjcf_attribute(m, node, name);
    return n != NULL ? n->text : "";
}

int mjcf_numbers(const mjcf *m, const xml_node *node, const char *name, double *x, int least,
                 int most)
{
    const xml_node *n = mjcf_attribute(m, node, name);
    int found = n != NULL ? draft_numbers(m->d, n, x, most) : 0;
    if (n != NULL && (found < least || found > most)) {
        draft_wrong(m->d, n, "%s has %d numbers, expected %d", name + 1, found, most);
        return 0;
    }
    return found;
}

double mjcf_number(const mjcf *m, const xml_node *node, const char *name, double otherwise)
{
    double value = otherwise;
    mjcf_numbers(m, node, name, &value, 1, 1);
    return value;
}

/* ---- orientations ---- */

static void of_quaternion(const double given[4], double R[9])
{
    double size =
        sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2] + given[3] * given[3]);
    double w = given[0] / size, x = given[1] / size, y = given[2] / size, z = given[3] / size;
    const double to[9] = {
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z),       2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),       2.0 * (y * z + w * x),       1.0 - 2.0 * (x * x + y * y)};
    for (int i = 0; i < 9; i++) { // a right angle that is written with 6 digits, or by sqrt(1/2)
        double whole = round(to[i]);
        R[i] = fabs(to[i] - whole) < 1e-12 ? whole : to[i];
    }
}

/* turns about x, y, z in the order of eulerseq: small letters about axes that turn along, capital
 * ones about those that do not */
static void of_euler(const mjcf *m, const double angle[3], double R[9])
{
    memcpy(R, one, sizeof one);
    for (int i = 0; i < 3; i++) {
        double rpy[3] = {0.0, 0.0, 0.0}, T[9], was[9];
        char c = m->eulerseq[i];
        rpy[(c | 32) - 'x'] = angle[i] * m->angle;
        frame_rotation(rpy, T);
        memcpy(was, R, sizeof was);
        frame_multiply(c >= 'x' ? was : T, c >= 'x' ? T : was, R);
    }
}

/* x, and the part of y normal to x */
static void of_axes(const double given[6], double R[9])
{
    double x[3], y[3], size = 0.0, along = 0.0, rest = 0.0;
    for (int i = 0; i < 3; i++) {
        size += given[i] * given[i];
    }
    for (int i = 0; i < 3; i++) {
        x[i] = given[i] / sqrt(size);
        along += x[i] * given[3 + i];
    }
    for (int i = 0; i < 3; i++) {
        y[i] = given[3 + i] - along * x[i];
        rest += y[i] * y[i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        R[3 * i] = x[i];
        R[3 * i + 1] = y[i] / sqrt(rest);
        R[3 * i + 2] = (x[j] * y[k] - x[k] * y[j]) / sqrt(rest);
    }
}

void mjcf_orientation(const mjcf *m, const xml_node *node, double R[9])
{
    double x[6], q[4];
    memcpy(R, one, sizeof one);
    if (mjcf_numbers(m, node, "@quat", q, 4, 4) == 4) {
        of_quaternion(q, R);
    } else if (mjcf_numbers(m, node, "@euler", x, 3, 3) == 3) {
        of_euler(m, x, R);
    } else if (mjcf_numbers(m, node, "@axisangle", x, 4, 4) == 4) {
        double size = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), half = 0.5 * x[3] * m->angle;
        q[0] = cos(half);
        for (int i = 0; i < 3; i++) {
            q[i + 1] = sin(half) * x[i] / size;
        }
        of_quaternion(q, R);
    } else if (mjcf_numbers(m, node, "@xyaxes", x, 6, 6) == 6) {
        of_axes(x, R);
    } else if (mjcf_numbers(m, node, "@zaxis", x, 3, 3) == 3) { // about the normal of z and that
        double across = sqrt(x[0] * x[0] + x[1] * x[1]), half = 0.5 * atan2(across, x[2]);
        q[0] = cos(half);
        q[1] = across > 0.0 ? -sin(half) * x[1] / across : sin(half);
        q[2] = across > 0.0 ? sin(half) * x[0] / across : 0.0;
        q[3] = 0.0;
        of_quaternion(q, R);
    }
    for (int i = 0; i < 9; i++) {
        if (!isfinite(R[i])) {
            draft_wrong(m->d, node, "the orientation of <%.40s> is none: a direction of length 0",
                        node->name);
        }
    }
}

/* ---- joints ---- */

static void take_law(mjcf *m, const xml_node *node, draft_body *b, const char *label)
{
    draft *d = m->d;
    double unit = b->joint == 'R' ? m->angle : 1.0, range[2] = {0.0, 0.0};
    double ref = unit * mjcf_number(m, node, "@ref", 0.0);
    const char *limited = mjcf_text(m, node, "@limited");
    int given = mjcf_numbers(m, node, "@range", range, 2, 2) == 2;
    if (given && strcmp(limited, "false") != 0 && range[0] < range[1]) {
        b->limited = 1;
        b->range[0] = unit * range[0] - ref;
        b->range[1] = unit * range[1] - ref;
    }
    if (ref != 0.0) {
        draft_note(d, "joint %.60s: its position is 0 where the model says %g", label, ref);
    }
    b->damping = mjcf_number(m, node, "@damping", 0.0);
    b->stiffness = mjcf_number(m, node, "@stiffness", 0.0);
    b->rest = unit * mjcf_number(m, node, "@springref", 0.0) - ref;
    b->coulomb = mjcf_number(m, node, "@frictionloss", 0.0);
    if (b->coulomb != 0.0) {
        draft_note(d, "friction of joint %.60s is smooth below %g %s", label, DRAFT_SMOOTH,
                   b->joint == 'T' ? "m/s" : "rad/s");
    }
    b->armature = mjcf_number(m, node, "@armature", 0.0);
}

static char kind_of(const mjcf *m, const xml_node *node)
{
    static const struct {
        const char *type;
        char joint;
    } known[] = {{"hinge", 'R'}, {"", 'R'}, {"slide", 'T'}, {"ball", 'B'}, {"free", 'W'}};
    const char *type = mjcf_text(m, node, "@type");
    if (strcmp(node->name, "freejoint") == 0) {
        return 'W';
    }
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strcmp(known[i].type, type) == 0) {
            return known[i].joint;
        }
    }
    draft_wrong(m->d, node, "a joint of type \"%.20s\", expected hinge, slide, ball or free", type);
    return 'R';
}

/* @param b  the frame of the body; it moves to the new body of the draft behind the joint
 * @param at  where the frame is, in the axes of `parent` */
static void take_joint(mjcf *m, const xml_node *node, mjcf_body *b, int *parent, double at[3])
{
    draft *d = m->d;
    draft_body joint = {.anchor = -1, .sign = 1, .joint = kind_of(m, node), .axis = 'x'};
    const char *label = mjcf_text(m, node, "@name");
    double pos[3] = {0.0, 0.0, 0.0}, axis[3] = {0.0, 0.0, 1.0}, turned[3];
    int one_axis = joint.joint == 'R' || joint.joint == 'T';
    label = label[0] != '\0' ? label : b->label;
    if (joint.joint != 'W') {
        mjcf_numbers(m, node, "@pos", pos, 3, 3);
    }
    mjcf_numbers(m, node, "@axis", axis, 3, 3);
    frame_turn(b->C, pos, turned);
    for (int i = 0; i < 3; i++) {
        joint.at[i] = at[i] + turned[i];
    }
    if (one_axis && d->status == STEIN_OK) {
        frame_axis(d, node, label, axis, b->C, &joint, parent);
        take_law(m, node, &joint, label);
    } else if (mjcf_number(m, node, "@damping", 0.0) + mjcf_number(m, node, "@stiffness", 0.0) +
                   mjcf_number(m, node, "@frictionloss", 0.0) +
                   mjcf_number(m, node, "@armature", 0.0) !=
               0.0) {
        draft_note(d,
                   "damping, stiffness, friction and armature of joint %.60s, which has several "
                   "axes",
                   label);
    }
    draft_body *made = d->status == STEIN_OK ? draft_add_body(d, node) : NULL;
    if (made == NULL) {
        return;
    }
    *made = joint;
    made->parent = *parent;
    *parent = d->nbody - 1;
    frame_turn(b->C, pos, turned);
    for (int i = 0; i < 3; i++) {
        at[i] = b->o[i] = -turned[i];
    }
    m->joint[*parent] = mjcf_text(m, node, "@name");
    if (one_axis) {
        draft_add_output(d, label, *parent, -1, 0);
        d->joints++;
    }
}

/* ---- bodies ---- */

static void take_children(mjcf *m, const xml_node *node, int above);

static void note_body(mjcf *m, const xml_node *node, const mjcf_body *b)
{
    static const char taken[] = " body joint freejoint inertial geom camera light ";
    static const char refused[] = " frame include replicate composite flexcomp attach ";
    int geoms = 0;
    for (const xml_node *n = node->first; n != NULL; n = n->next) {
        char spaced[64];
        snprintf(spaced, sizeof spaced, " %.60s ", n->name);
        geoms += strcmp(n->name, "geom") == 0;
        if (strstr(refused, spaced) != NULL) {
            draft_wrong(m->d, n,
                        "<%.40s>, expected a model in which it is written out, as MuJoCo "
                        "saves one (mj_saveLastXML)",
                        n->name);
        } else if (n->name[0] != '@' && strstr(taken, spaced) == NULL) {
            draft_note(m->d, "<%.60s> of %.60s (line %d)", n->name, b->label, n->line);
        }
    }
    if (geoms > 0) {
        draft_note(m->d, "contacts of %d <geom> of %.60s: write what touches as contacts", geoms,
                   b->label);
    }
}

/* The body of the last joint has the mass. Without a joint it is part of the body's parent, or of
 * the frame, where it has no effect; its origin is a point there. */
static void take_carrier(mjcf *m, const xml_node *node, mjcf_body *b, int carrier,
                         const double at[3], int jointed)
{
    draft *d = m->d;
    draft_body part = {.mass = 0.0};
    b->body = carrier;
    if (jointed) {
        mjcf_mass(m, node, b, &d->body[carrier]);
        draft_name(d, d->body[carrier].name, b->label, "body", DRAFT_PART, 0);
        return;
    }
    memcpy(b->o, at, sizeof b->o);
    draft_point *p = draft_add_point(d, node, carrier, b->label);
    if (p != NULL) {
        memcpy(p->x, at, sizeof p->x);
        mjcf_mass(m, node, b, &part);
    }
    if (part.mass != 0.0 && carrier >= 0) {
        frame_join(&d->body[carrier], &part);
        draft_note(d, "body %.60s is fixed: part of %s", b->label, d->body[carrier].name);
    }
}

static void take_body(mjcf *m, const xml_node *node, int above)
{
    draft *d = m->d;
    const mjcf_body *on = &m->body[above];
    double pos[3] = {0.0, 0.0, 0.0}, R[9], at[3];
    if (m->nbody == DRAFT_LINKS) {
        draft_wrong(d, node, "more than %d bodies", (int)DRAFT_LINKS - 1);
        return;
    }
    int index = m->nbody++;
    mjcf_body *b = &m->body[index];
    *b = (mjcf_body){.node = node, .label = mjcf_text(m, node, "@name")};
    b->label = b->label[0] != '\0' ? b->label : "body";
    mjcf_numbers(m, node, "@pos", pos, 3, 3);
    mjcf_orientation(m, node, R);
    frame_multiply(on->W, R, b->W);
    frame_turn(on->W, pos, b->X);
    frame_turn(on->C, pos, at);
    for (int i = 0; i < 3; i++) {
        b->X[i] += on->X[i];
        at[i] += on->o[i];
    }
    frame_multiply(on->C, R, b->C);
    int parent = on->body, jointed = 0;
    for (const xml_node *n = node->first; n != NULL && d->status == STEIN_OK; n = n->next) {
        if (strcmp(n->name, "joint") == 0 || strcmp(n->name, "freejoint") == 0) {
            take_joint(m, n, b, &parent, at);
            jointed = 1;
        }
    }
    if (d->status == STEIN_OK) {
        take_carrier(m, node, b, parent, at, jointed);
        d->bodies++;
        note_body(m, node, b);
        take_children(m, node, index);
    }
}

static void take_children(mjcf *m, const xml_node *node, int above)
{
    for (const xml_node *n = xml_child(node, "body"); n != NULL && m->d->status == STEIN_OK;
         n = xml_next(node, n, "body")) {
        take_body(m, n, above);
    }
}

/* bodies between joints are called like the joint that carries them */
static void name_rest(mjcf *m)
{
    draft *d = m->d;
    for (int i = 0; i < d->nbody; i++) {
        if (d->body[i].name[0] == '\0') {
            const char *label = m->joint[i] != NULL ? m->joint[i] : "";
            draft_name(d, d->body[i].name, label[0] != '\0' ? label : "joint", NULL, DRAFT_PART, 0);
        }
    }
}

static void take_settings(mjcf *m)
{
    const xml_node *compiler = xml_child(m->root, "compiler");
    const xml_node *option = xml_child(m->root, "option");
    const xml_node *seq = xml_child(compiler, "@eulerseq"), *angle = xml_child(compiler, "@angle");
    m->angle = angle != NULL && strcmp(angle->text, "radian") == 0 ? 1.0 : 3.141592653589793 / 180;
    snprintf(m->eulerseq, sizeof m->eulerseq, "%s", seq != NULL ? seq->text : "xyz");
    if (seq != NULL && (strlen(seq->text) != 3 || strspn(seq->text, "xyzXYZ") != 3)) {
        draft_wrong(m->d, seq, "eulerseq is \"%.20s\", expected three of x y z X Y Z", seq->text);
    }
    if (strcmp(mjcf_text(m, compiler != NULL ? compiler : m->root, "@coordinate"), "global") == 0) {
        draft_wrong(m->d, compiler,
                    "global coordinates, expected local ones, as MuJoCo saves them");
    }
    m->d->gravity[2] = -9.81;
    if (xml_child(option, "@gravity") != NULL &&
        draft_numbers(m->d, xml_child(option, "@gravity"), m->d->gravity, 3) != 3) {
        draft_wrong(m->d, option, "gravity, expected three numbers");
    }
    draft_note_others(m->d, compiler, " ", "the compiler");
    draft_note_others(m->d, option, " ", "the options");
}

stein_status mjcf_take(draft *d, const xml_node *root)
{
    mjcf *m = calloc(1, sizeof *m);
    const xml_node *world = xml_child(root, "worldbody"), *name = xml_child(root, "@model");
    if (m == NULL) {
        return lab__no_memory(d->err);
    }
    m->d = d;
    m->root = root;
    d->program = "MuJoCo's model";
    draft_name(d, d->name, name != NULL ? name->text : "model", NULL, DRAFT_PART, 0);
    m->body[m->nbody++] = (mjcf_body){.body = -1, .label = "world", .node = world};
    memcpy(m->body[0].C, one, sizeof one);
    memcpy(m->body[0].W, one, sizeof one);
    if (world == NULL) {
        draft_wrong(d, root, "<mujoco> without a <worldbody>, expected one");
    } else {
        take_settings(m);
        note_body(m, world, &m->body[0]);
        take_children(m, world, 0);
        name_rest(m);
        mjcf_equalities(m);
    }
    if (d->status == STEIN_OK && d->nbody == 0) {
        draft_wrong(d, world, "<worldbody> without a body that moves, expected one");
    }
    free(m);
    return d->status;
}
