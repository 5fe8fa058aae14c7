/* SPDX-License-Identifier: GPL-3.0-or-later
 * parts.c - the action's numbers, by name from the mechanism file.
 *
 * The reader's only use here: both descriptions of the action always speak of the same parts. What
 * the file expects structurally (which point touches which line) is written out below by hand.
 */
#include <math.h>
#include <string.h>

#include "reality.h"

typedef struct source {
    const mechanism *m;
    const double *p;
    int missing;
} source;

static double get(source *s, const char *format, const char *owner)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, format, owner);
    int i = mech_find_param(s->m, name, NULL);
    for (int k = 0; i < 0 && k < s->m->nformula; k++) {
        if (strcmp(s->m->formulas[k].name, name) == 0) {
            return mech_value(s->m, (mech_scalar){MECH_FORMULA, k, 0.0}, s->p);
        }
    }
    return i < 0 ? 0.0 : s->p[i]; // a number that is absent or 0 in the file
}

static double need(source *s, const char *name)
{
    double value = get(s, "%s", name);
    if (!(value != 0.0)) {
        fprintf(stderr, "reality: the model has no number \"%s\"\n", name);
        s->missing++;
    }
    return value;
}

static vec point(source *s, const char *name)
{
    char x[MECH_PATH], z[MECH_PATH];
    snprintf(x, sizeof x, "%s.x", name);
    snprintf(z, sizeof z, "%s.z", name);
    return (vec){get(s, "%s", x), get(s, "%s", z)};
}

static rub friction(source *s, const char *owner)
{
    rub r = {get(s, "%s.friction.A", owner), get(s, "%s.friction.vt", owner),
             get(s, "%s.friction.B1", owner), get(s, "%s.friction.B2", owner)};
    r.vt = r.vt > 0.0 ? r.vt : 1.0;
    return r;
}

static void fill_felt(source *s, felt *f, const char *owner)
{
    memset(f, 0, sizeof *f);
    f->a = get(s, "%s.normal.a", owner);
    f->b = get(s, "%s.normal.b", owner);
    f->c = get(s, "%s.normal.c", owner);
    f->D = get(s, "%s.normal.D", owner);
    f->friction = friction(s, owner);
    f->scale = 1.0;
}

static void fill_body(source *s, action *a, int i, const char *name)
{
    char centre[MECH_PATH];
    snprintf(centre, sizeof centre, "%s.centre", name);
    a->body[i] = (piece){get(s, "%s.mass", name), get(s, "%s.inertia.yy", name), point(s, centre)};
    a->joint[i].friction = friction(s, name);
    a->joint[i].k = get(s, "%s.spring.k", name);
    a->joint[i].theta0 = get(s, "%s.spring.theta0", name);
    a->joint[i].coulomb_w0 = a->joint[i].creep_w0 = 1.0;
    a->joint[i].creep_turn = a->joint[i].creep_time = 1.0;
}

static vec facing(double angle)
{
    return (vec){cos(angle), sin(angle)};
}

/* a line of the frame: a coordinate that is a structural zero of the file is 0 */
static vec line_at(source *s, const char *contact)
{
    char name[MECH_PATH];
    snprintf(name, sizeof name, "%s.line", contact);
    return point(s, name);
}

int parts_fill(action *a, const mechanism *m, const double *p)
{
    static const char *const bodies[JOINTS] = {"key", "hammer", "pawl"};
    static const char *const felts[CONTACTS] = {"rest", "dip",  "loops", "string",
                                                "stop", "load", "notch"};
    source s = {m, p, 0};
    memset(a, 0, sizeof *a);
    a->g = -need(&s, "gravity.z");
    for (int i = 0; i < JOINTS; i++) {
        fill_body(&s, a, i, bodies[i]);
    }
    for (int i = 0; i < CONTACTS; i++) {
        fill_felt(&s, &a->felt[i], felts[i]);
    }
    a->kapsel = point(&s, "key.kapsel");
    a->pawl_hinge = point(&s, "pawl.at");
    a->front = point(&s, "key.front");
    a->rear = point(&s, "key.rear");
    a->below = point(&s, "key.below");
    a->head = point(&s, "hammer.head");
    a->beak = point(&s, "hammer.beak");
    a->shank = point(&s, "hammer.shank");
    a->corner = point(&s, "pawl.corner");
    a->back = point(&s, "pawl.back");
    a->rest_at = line_at(&s, "rest");
    a->dip_at = line_at(&s, "dip");
    a->loops_at = line_at(&s, "loops");
    a->stop_at = line_at(&s, "stop");
    a->string_at = (vec){get(&s, "%s.line.x", "string"), need(&s, "string.height")};
    a->pad[REST] = facing(need(&s, "rest.line.facing"));
    a->pad[DIP] = facing(need(&s, "dip.line.facing"));
    a->pad[LOOPS] = facing(need(&s, "loops.line.facing"));
    a->pad[STOP] = facing(need(&s, "stop.line.facing"));
    a->pad[STRING] = a->pad[LOAD] = (vec){0.0, -1.0};
    double upright = get(&s, "%s.corner.lean", "notch"), wedge = need(&s, "pawl.notch_angle");
    a->right = facing(upright);
    a->under = facing(upright + wedge + 3.14159265358979323846);
    a->roof = (vec){a->under.z, -a->under.x};
    a->below_beak = facing(get(&s, "%s.beak.tilt", "notch") - 1.57079632679489661923);
    a->load_mass = need(&s, "load.mass");
    a->pin_ratio = 1.0;
    a->drive_gain = 1.0;
    return s.missing;
}

/* mass, first and second moments about the common origin equal the whole's */
piece piece_rest(piece whole, piece part)
{
    piece r;
    r.m = whole.m - part.m;
    r.c.x = (whole.m * whole.c.x - part.m * part.c.x) / r.m;
    r.c.z = (whole.m * whole.c.z - part.m * part.c.z) / r.m;
    r.I = whole.I + whole.m * (whole.c.x * whole.c.x + whole.c.z * whole.c.z) - part.I -
          part.m * (part.c.x * part.c.x + part.c.z * part.c.z) -
          r.m * (r.c.x * r.c.x + r.c.z * r.c.z);
    return r;
}
