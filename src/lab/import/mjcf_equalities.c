/* SPDX-License-Identifier: GPL-3.0-or-later
 * mjcf_equalities.c - equalities and actuators of a MuJoCo model, and omissions.
 */
#include "mjcf.h"

#include <math.h>
#include <string.h>

/* ---- equalities ---- */

static mjcf_body *find_body(mjcf *m, const xml_node *node, const char *attribute)
{
    const char *label = mjcf_text(m, node, attribute);
    for (int i = 0; i < m->nbody; i++) {
        if (strcmp(m->body[i].label, label) == 0 || (i == 0 && label[0] == '\0')) {
            return &m->body[i];
        }
    }
    draft_wrong(m->d, node, "<%s> at \"%.60s\", which is no body", node->name, label);
    return NULL;
}

/* body of the draft on a joint of one axis, -1 with an error */
static int find_joint(mjcf *m, const xml_node *node, const char *attribute)
{
    const char *label = mjcf_text(m, node, attribute);
    for (int i = 0; i < m->d->nbody; i++) {
        char kind = m->d->body[i].joint;
        if (m->joint[i] != NULL && strcmp(m->joint[i], label) == 0 &&
            (kind == 'R' || kind == 'T')) {
            return i;
        }
    }
    draft_wrong(m->d, node, "<%s> at \"%.60s\", which is no joint that turns or slides", node->name,
                label);
    return -1;
}

/* @return point of the draft on a body, where p of the world is at the reference */
static int point_on(mjcf *m, const xml_node *node, const mjcf_body *b, const double p[3],
                    const char *label)
{
    double off[3], inverse[9], local[3], x[3];
    for (int i = 0; i < 3; i++) {
        off[i] = p[i] - b->X[i];
    }
    frame_transpose(b->W, inverse);
    frame_turn(inverse, off, local);
    frame_turn(b->C, local, x);
    for (int i = 0; i < 3; i++) {
        x[i] += b->o[i];
    }
    return draft_point_at(m->d, node, b->body, x, label);
}

/* Are the axes of both bodies of the draft parallel at the reference? */
static int are_parallel(const mjcf_body *a, const mjcf_body *b)
{
    double A[9], B[9], T[9], off = 0.0;
    frame_transpose(a->C, T);
    frame_multiply(a->W, T, A);
    frame_transpose(b->C, T);
    frame_multiply(b->W, T, B);
    for (int i = 0; i < 9; i++) {
        off = fmax(off, fabs(A[i] - B[i]));
    }
    return off < 1e-9;
}

static void take_pair(mjcf *m, const xml_node *node, const char *label)
{
    draft *d = m->d;
    const mjcf_body *a = find_body(m, node, "@body1"), *b = find_body(m, node, "@body2");
    int weld = strcmp(node->name, "weld") == 0;
    double anchor[3] = {0.0, 0.0, 0.0}, p[3];
    if (a == NULL || b == NULL) {
        return;
    }
    if (weld && !are_parallel(a, b)) {
        draft_wrong(d, node,
                    "<weld> \"%.60s\" of bodies behind a joint that is askew, expected "
                    "three <connect>",
                    label);
        return;
    }
    const mjcf_body *of = weld ? b : a; // whose frame the anchor is in
    mjcf_numbers(m, node, "@anchor", anchor, 3, 3);
    frame_turn(of->W, anchor, p);
    for (int i = 0; i < 3; i++) {
        p[i] += of->X[i];
    }
    draft_loop *l = draft_add_loop(d, node, label);
    if (l == NULL) {
        return;
    }
    l->kind = weld ? DRAFT_WELD : DRAFT_MEET;
    l->point[0] = point_on(m, node, a, p, label);
    l->point[1] = point_on(m, node, b, p, label);
    draft_note_others(d, node, " ", label);
}

static void take_coupling(mjcf *m, const xml_node *node, const char *label)
{
    draft *d = m->d;
    double poly[5] = {0.0, 1.0, 0.0, 0.0, 0.0};
    int first = find_joint(m, node, "@joint1"), second;
    mjcf_numbers(m, node, "@polycoef", poly, 1, 5);
    if (d->status != STEIN_OK) {
        return;
    }
    if (mjcf_attribute(m, node, "@joint2") == NULL) {
        d->body[first].q = poly[0];
        d->body[first].start = DRAFT_STATED;
        draft_add_input(d, label, DRAFT_MOTION, first, 0);
        return;
    }
    second = find_joint(m, node, "@joint2");
    if (poly[2] != 0.0 || poly[3] != 0.0 || poly[4] != 0.0) {
        draft_wrong(d, node, "a polycoef of second or higher degree, expected c0 c1");
    }
    draft_coupling *c = d->status == STEIN_OK ? draft_add_coupling(d, node, label) : NULL;
    if (c != NULL) {
        c->joint = first;
        c->follows = second;
        c->ratio = poly[1];
        c->offset = poly[0];
        d->body[first].start = DRAFT_GUESSED;
    }
}

static void take_equality(mjcf *m, const xml_node *node)
{
    const char *label = mjcf_text(m, node, "@name");
    label = label[0] != '\0' ? label : node->name;
    int pair = strcmp(node->name, "connect") == 0 || strcmp(node->name, "weld") == 0;
    if (strcmp(mjcf_text(m, node, "@active"), "false") == 0) {
        draft_note(m->d, "<%s> \"%.60s\" is not active", node->name, label);
    } else if (pair && mjcf_attribute(m, node, "@body1") != NULL) {
        take_pair(m, node, label);
    } else if (strcmp(node->name, "joint") == 0) {
        take_coupling(m, node, label);
    } else {
        draft_wrong(m->d, node, "an equality <%.40s>, expected connect, weld or joint, with body1",
                    node->name);
    }
}

/* ---- actuators ---- */

static void take_actuator(mjcf *m, const xml_node *node)
{
    draft *d = m->d;
    const char *label = mjcf_text(m, node, "@name");
    double gear[6] = {1.0};
    if (mjcf_attribute(m, node, "@joint") == NULL) {
        draft_note(d, "actuator <%.40s> \"%.60s\": it acts on no joint", node->name, label);
        return;
    }
    int joint = find_joint(m, node, "@joint");
    if (joint < 0) {
        return;
    }
    label = label[0] != '\0' ? label : mjcf_text(m, node, "@joint");
    draft_add_input(d, label, DRAFT_TORQUE, joint, 0);
    mjcf_numbers(m, node, "@gear", gear, 1, 6);
    if (strcmp(node->name, "motor") != 0 || gear[0] != 1.0) {
        draft_note(d,
                   "actuator <%.40s> \"%.60s\": an input is its torque, without its law and gear",
                   node->name, label);
    }
}

void mjcf_equalities(mjcf *m)
{
    const xml_node *equality = xml_child(m->root, "equality");
    const xml_node *actuator = xml_child(m->root, "actuator");
    const xml_node *include = xml_child(m->root, "include");
    if (include != NULL) {
        draft_wrong(m->d, include,
                    "<include>, expected a model in which it is written out, as "
                    "MuJoCo saves one (mj_saveLastXML)");
    }
    for (const xml_node *n = equality != NULL ? equality->first : NULL; n != NULL; n = n->next) {
        if (m->d->status == STEIN_OK && n->name[0] != '@') {
            take_equality(m, n);
        }
    }
    for (const xml_node *n = actuator != NULL ? actuator->first : NULL; n != NULL; n = n->next) {
        if (m->d->status == STEIN_OK && n->name[0] != '@') {
            take_actuator(m, n);
        }
    }
    draft_note_others(m->d, m->root,
                      " compiler option default worldbody equality actuator asset visual "
                      "statistic size ",
                      "the model");
}
