/* SPDX-License-Identifier: GPL-3.0-or-later
 * effect.c - what can be hidden, by the names of `stein effects`, and laws that are in no table.
 *
 * An effect is a change of true numbers. Its limit follows from the motion: the half range of a
 * joint, the RMS of its speed and its mean accelerating moment limit the size of a friction, a
 * spring or an offset.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world.h"

#define MISSING "missing_effect"
#define WRONG   "wrong_parameter"

/* clang-format off */
const kind kinds[] = {
    {"viscous_friction", MISSING, "b", 'j', J_B, -1, 0, 0},
    {"coulomb_friction", MISSING, "T", 'j', J_T, J_W, 0, 0},
    {"quadratic_drag", MISSING, "k", 'j', J_DRAG, -1, 0, 0},
    {"viscous_asymmetry", MISSING, "s", 'j', J_ASYMMETRY, -1, 1, 0},
    {"coulomb_asymmetry", MISSING, "s", 'j', J_T_ASYMMETRY, -1, 1, 0},
    {"preload", MISSING, "T", 'j', J_PRELOAD, -1, 1, 0},
    {"joint_stiffness", MISSING, "k", 'j', J_K, -1, 0, 0},
    {"hardening_spring", MISSING, "k3", 'j', J_K3, -1, 1, 0},
    {"backlash", MISSING, "k", 'j', J_STOP, J_GAP, 0, 0},
    {"stiction_peak", MISSING, "B1", 'j', J_B1, J_B2, 0, 0},
    {"mass", WRONG, "mass", 'b', 0, -1, 1, 0},
    {"inertia", WRONG, "inertia", 'b', 1, -1, 1, 0},
    {"centre", WRONG, "shift", 'b', 2, -1, 1, 0},
    {"elastic_hinge", MISSING, "compliance", 'x', STRUCTURE_HINGE, -1, 0, 0},
    {"axis_translation", MISSING, "compliance", 'x', STRUCTURE_AXIS, -1, 0, 0},
    {"compliant_partner", MISSING, "compliance", 'x', STRUCTURE_PARTNER, -1, 0, 0},
    {"contact_stiffness", WRONG, "log_scale", 'c', N_C, -1, 1, 0},
    {"contact_exponent", MISSING, "p", 'c', N_P, -1, 1, 0},
    {"contact_damping", WRONG, "log_scale", 'c', N_D, -1, 1, 0},
    {"contact_hysteresis", MISSING, "h", 'c', N_H, -1, 0, 0},
    {"adhesion", MISSING, "F", 'c', N_F, N_RANGE, 0, 0},
    {"contact_gap", WRONG, "gap", 'c', N_GAP, -1, 1, 0},
    {"contact_friction", WRONG, "log_scale", 'c', N_MU, -1, 1, 0},
    {"one_sided_link", MISSING, "slack", 'l', L_SLACK, -1, 0, 0},
    {"input_gain", "input", "error", 'i', I_GAIN, -1, 1, 0},
    {"input_delay", "input", "delay", 'i', I_DELAY, -1, 0, 0},
    {"sensor_gain", "sensor", "error", 's', S_GAIN, -1, 1, 0},
    {"sensor_offset", "sensor", "offset", 's', S_OFFSET, -1, 1, 0},
    {"sensor_delay", "sensor", "delay", 's', S_DELAY, -1, 0, 0},
    {"sensor_nonlinearity", "sensor", "k2", 's', S_SQUARE, -1, 1, 0},
    {"time_base", "sensor", "error", 't', 0, -1, 1, 0},
    {"wrong_parameter", WRONG, "change", 'p', 0, -1, 1, 0},
    {"torque_bump", "unknown_effect", "T", 'j', J_BUMP, J_BUMP_AT, 1, 1},
    {"ripple", "unknown_effect", "T", 'j', J_COG, J_COG_WAVE, 0, 1},
    {"root_friction", "unknown_effect", "T", 'j', J_ROOT, J_ROOT_W, 0, 1},
    {NULL, NULL, NULL, 0, 0, 0, 0, 0}};
/* clang-format on */

/* does the joint lack what the kind would add? */
static int is_lacking(const mech *m, const kind *k, int joint)
{
    const number *law = m->number + m->body[joint].law;
    switch (k->offset) {
    case J_ASYMMETRY: return law[J_B].stated;
    case J_T_ASYMMETRY: return law[J_T].stated;
    case J_T: return !law[J_T].stated && !law[J_A].stated;
    case J_B1: return law[J_A].stated && !law[J_B1].stated;
    case J_ROOT: return !law[J_T].stated && !law[J_A].stated && !law[J_B].stated;
    default: return !law[k->offset].stated;
    }
}

static double limit_of_joint(const kind *k, const extent *x, int j)
{
    double q = fmax(x->q[j], 1e-6), v = fmax(x->qd[j], 1e-6), T = x->torque[j];
    double far = q + fabs(x->mid[j]); // from where springs are relaxed
    switch (k->offset) {
    case J_B: return 2.0 * T / v;
    case J_DRAG: return 2.0 * T / (v * v);
    case J_ASYMMETRY:
    case J_T_ASYMMETRY: return 0.9;
    case J_K: return 2.0 * T / far;
    case J_K3: return 1.5 * T / (far * far * far);
    case J_STOP: return 20.0 * T / q;
    case J_ROOT: return 2.0 * T;
    case J_B1: return 30.0;
    default: return T;
    }
}

static void place_it(effect *e, const char *name)
{
    snprintf(e->place, NAME, "%.*s", NAME - 1, name);
}

static int add_joints(const mech *m, const extent *x, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int j = 0; j < m->nbody && n < most; j++) {
        int prescribed = m->ninput > 0 && m->input[0].kind == INPUT_MOTION;
        // a joint that hardly moves shows nothing of its laws
        if (!is_lacking(m, k, j) || (m->pushes && !(x->q[j] > 1e-4))) {
            continue;
        }
        out[n] = (effect){.kind = k, .index = j, .limit = limit_of_joint(k, x, j)};
        out[n].limit *= prescribed ? 3.0 : 1.0;
        out[n].unit = m->number[m->body[j].law + k->offset].unit;
        place_it(&out[n++], m->body[j].name);
    }
    return n;
}

/* the coordinate of a centre that the effect "centre" is of: x, unless z is ten times as long */
static int along(const mech *m, const body *B)
{
    int x = B->centre[0], z = B->centre[2];
    double length = x >= 0 ? 10.0 * fabs(m->number[x].value) : 0.0;
    return z >= 0 && fabs(m->number[z].value) > length ? z : x;
}

static int is_along(const mech *m, int i)
{
    int found = 0;
    for (int b = 0; b < m->nbody; b++) {
        found |= along(m, &m->body[b]) == i;
    }
    return found;
}

/* numbers of the file that may be others: masses, inertias, and lengths for wrong_parameter */
static int add_numbers(const mech *m, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int b = 0; k->site == 'b' && b < m->nbody && n < most; b++) {
        const body *B = &m->body[b];
        int at = k->offset == 0 ? B->mass : k->offset == 1 ? B->inertia[1] : along(m, B);
        if (at >= 0 && !(k->offset == 1 && B->inertia[0] >= 0)) {
            out[n] = (effect){.kind = k, .index = at, .limit = 0.6 * m->number[at].value};
            out[n].unit = m->number[at].unit;
            place_it(&out[n++], B->name);
        }
    }
    for (int i = 0; k->site == 'p' && i < m->nnumber && n < most; i++) {
        const number *N = &m->number[i];
        int length = N->stated && N->sd > 0.0 && strcmp(N->unit, "m") == 0;
        int of_link = strstr(N->name, "spring.") == N->name;
        // the height of a line is called its contact's gap, a centre along its body centre
        if ((length || of_link) && N->stated && strstr(N->name, ".line.") == NULL &&
            !is_along(m, i)) {
            out[n] =
                (effect){.kind = k, .index = i, .limit = 0.5 * fabs(N->value), .unit = N->unit};
            place_it(&out[n++], N->name);
        }
    }
    return n;
}

static int add_contacts(const mech *m, const extent *x, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int i = 0; i < m->ncontact && n < most; i++) {
        double limit = k->offset == N_C || k->offset == N_MU ? 1.5
                       : k->offset == N_D                    ? 1.5
                       : k->offset == N_P                    ? 0.7
                       : k->offset == N_H                    ? 0.8
                       : k->offset == N_GAP                  ? 2e-3
                                                             : 2.0;
        int rubs = k->offset != N_MU || m->number[m->contact[i].law + N_MU].stated;
        if (x->depth[i] > 0.0 && rubs) {
            out[n] = (effect){.kind = k, .index = i, .limit = limit};
            out[n].unit = k->offset == N_F ? "N" : k->offset == N_GAP ? "m" : "1";
            place_it(&out[n++], m->contact[i].name);
        }
    }
    return n;
}

static const char *per_unit(const char *unit)
{
    return strcmp(unit, "rad") == 0     ? "1/rad"
           : strcmp(unit, "m") == 0     ? "1/m"
           : strcmp(unit, "rad/s") == 0 ? "s/rad"
                                        : "s/m";
}

static int add_channels(const mech *m, const extent *x, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int i = 0; i < m->nchannel && n < most; i++) {
        double y = x->y[i];
        double limit = k->offset == S_GAIN     ? 0.5
                       : k->offset == S_OFFSET ? y
                       : k->offset == S_DELAY  ? 0.05
                                               : 0.5 / fmax(y, 1e-9);
        // an offset in the file is not hidden; what a force is at rest is without an owner
        if ((k->offset == S_OFFSET && m->number[m->channel[i].law + S_OFFSET].stated) ||
            (k->offset == S_SQUARE && m->channel[i].read == READ_EFFORT)) {
            continue;
        }
        out[n] = (effect){.kind = k, .index = i, .limit = limit};
        out[n].unit = k->offset == S_OFFSET   ? m->channel[i].unit
                      : k->offset == S_DELAY  ? "s"
                      : k->offset == S_SQUARE ? per_unit(m->channel[i].unit)
                                              : "1";
        place_it(&out[n++], m->channel[i].name);
    }
    return n;
}

static int add_inputs(const mech *m, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int i = 0; i < m->ninput && n < most; i++) {
        out[n] = (effect){.kind = k, .index = i, .limit = k->offset == I_GAIN ? 0.5 : 0.05};
        out[n].unit = k->offset == I_GAIN ? "1" : "s";
        place_it(&out[n++], m->input[i].name);
    }
    return n;
}

static int add_links(const mech *m, const kind *k, effect *out, int most)
{
    int n = 0;
    for (int i = 0; i < m->nlink && n < most; i++) {
        out[n] = (effect){.kind = k, .index = i, .limit = 1.0, .unit = "1"};
        place_it(&out[n++], m->link[i].name);
    }
    return n;
}

/* compliances: of a link a tenth of a radian, of an axis a slow frequency, of a partner the
 * contact's own stiffness */
static int add_structures(const mech *m, const extent *x, const kind *k, effect *out, int most)
{
    const double bend = 0.1, slow = 20.0; /* [rad], [rad/s] */
    int n = 0, partner = k->offset == STRUCTURE_PARTNER;
    for (int i = 0; i < (partner ? m->ncontact : m->nbody) && n < most; i++) {
        if (!structure_can(m, k->offset, i) || (partner && !(x->depth[i] > 0.0))) {
            continue;
        }
        double law[N_SIZE] = {0.0}, limit;
        for (int j = 0; partner && j < N_SIZE; j++) {
            law[j] = m->number[m->contact[i].law + j].value;
        }
        limit = partner ? x->depth[i] / law_normal(law, x->depth[i], 0.0)
                : k->offset == STRUCTURE_HINGE
                    ? bend / fmax(x->torque[i], 1e-9)
                    : 1.0 / (m->number[m->body[i].mass].value * slow * slow);
        out[n] = (effect){.kind = k, .index = i, .limit = limit};
        out[n].unit = k->offset == STRUCTURE_HINGE ? "rad/(N m)" : "m/N";
        place_it(&out[n++], partner ? m->contact[i].name : m->body[i].name);
    }
    return n;
}

int effect_list(const mech *m, const extent *x, effect *out, int most, int outside)
{
    int n = 0;
    for (const kind *k = kinds; k->name != NULL; k++) {
        if (k->outside != outside) {
            continue;
        }
        switch (k->site) {
        case 'j': n += add_joints(m, x, k, out + n, most - n); break;
        case 'b':
        case 'p': n += add_numbers(m, k, out + n, most - n); break;
        case 'c': n += add_contacts(m, x, k, out + n, most - n); break;
        case 's': n += add_channels(m, x, k, out + n, most - n); break;
        case 'x': n += add_structures(m, x, k, out + n, most - n); break;
        case 'l': n += add_links(m, k, out + n, most - n); break;
        case 'i': n += add_inputs(m, k, out + n, most - n); break;
        default:
            if (n < most) {
                out[n] = (effect){.kind = k, .index = m->clock, .limit = 0.3, .unit = "1"};
                place_it(&out[n++], "clock");
            }
        }
    }
    return n;
}

void effect_sides(effect *e, const mech *m, const extent *x, chance *c)
{
    int j = e->index, turns = e->kind->site == 'j' && m->body[j].type == 'R';
    e->limit *= e->kind->both && chance_coin(c, 0.5) ? -1.0 : 1.0;
    if (e->kind->site == 'x') {
        int partner = e->kind->offset == STRUCTURE_PARTNER;
        const body *hits = partner ? &m->body[m->point[m->contact[j].point[0]].body] : NULL;
        e->side = partner ? m->number[hits->mass].value * chance_log(c, 0.05, 0.3)
                          : chance_log(c, 0.03, 0.2);
        e->width = partner ? chance_log(c, 0.02, 0.1) : chance_uniform(c, 0.35, 0.6);
        return;
    }
    if (e->kind->site == 'c' && e->kind->side == N_RANGE) {
        e->side = chance_log(c, 3e-5, 2e-4);
        return;
    }
    switch (e->kind->site == 'j' ? e->kind->side : -1) {
    case J_B2: e->side = chance_log(c, 0.01, 0.3); break;
    case J_W: e->side = chance_log(c, 0.02, 0.1) * (turns ? 1.0 : 0.1); break;
    case J_GAP: e->side = x->q[j] * chance_uniform(c, 0.3, 0.7); break;
    case J_BUMP_AT:
        e->side = x->mid[j] + x->q[j] * chance_uniform(c, -0.4, 0.4);
        e->width = x->q[j] * chance_uniform(c, 0.15, 0.3);
        break;
    case J_COG_WAVE: e->side = x->q[j] / chance_uniform(c, 6.0, 20.0); break;
    case J_ROOT_W: e->side = x->qd[j]; break;
    default: break;
    }
}

void effect_apply(const effect *e, const mech *m, double size, double *p)
{
    const kind *k = e->kind;
    int law = k->site == 'j'   ? m->body[e->index].law
              : k->site == 'c' ? m->contact[e->index].law
              : k->site == 'l' ? m->link[e->index].law
              : k->site == 's' ? m->channel[e->index].law
              : k->site == 'i' ? m->input[e->index].law
                               : e->index;
    if (k->site == 'x') {
        return; // structure.c
    }
    if (k->side >= 0) {
        p[law + k->side] = e->side;
    }
    if (k->site == 'j' && k->offset == J_BUMP) {
        p[law + J_BUMP_WIDTH] = e->width;
    }
    if (k->site == 'c' && k->offset == N_C) {
        p[law + N_A] *= exp(size);
        p[law + N_B] *= exp(size);
        p[law + N_C] *= exp(size);
    } else if (k->site == 'c' && (k->offset == N_D || k->offset == N_MU)) {
        p[law + k->offset] *= exp(size);
    } else {
        p[law + (strchr("bpt", k->site) != NULL ? 0 : k->offset)] += size;
    }
}
