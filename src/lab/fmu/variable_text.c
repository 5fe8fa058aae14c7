/* SPDX-License-Identifier: GPL-3.0-or-later
 * variable_text.c - descriptions of variables, for users of FMUs: the text of the file, or a text
 * from its place in the file.
 */
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

const char *fmu__about(const mechanism *m, const char *section, const char *entry)
{
    for (int i = 0; i < m->nabout; i++) {
        const mech_about *a = &m->abouts[i];
        if (strcmp(a->section, section) == 0 && strcmp(a->entry, entry) == 0) {
            return a->text;
        }
    }
    return NULL;
}

/* ---- parameters ---- */

/* ends of a parameter's name, the longer of two that fit first */
static const struct ending {
    const char *end, *words;
} endings[] = {
    {"mass", "mass"},
    {"centre.x", "centre of mass, x from the joint"},
    {"centre.y", "centre of mass, y from the joint"},
    {"centre.z", "centre of mass, z from the joint"},
    {"inertia.xx", "moment of inertia about x through the centre of mass"},
    {"inertia.yy", "moment of inertia about y through the centre of mass"},
    {"inertia.zz", "moment of inertia about z through the centre of mass"},
    {"inertia.xy", "product of inertia xy about the centre of mass"},
    {"inertia.xz", "product of inertia xz about the centre of mass"},
    {"inertia.yz", "product of inertia yz about the centre of mass"},
    {"armature", "inertia of a rotor behind the gear, as the joint has it"},
    {"motor.torque_constant", "torque of the motor per ampere, back-EMF per rad/s"},
    {"motor.resistance", "resistance of the motor"},
    {"motor.gear", "how many times as fast the motor turns"},
    {"pendulum.frequency", "frequency of its pendulum test"},
    {"spring.k", "stiffness of the spring"},
    {"spring.k3", "hardening of the spring"},
    {"spring.theta0", "angle at which the spring is slack"},
    {"spring.x0", "position at which the spring is slack"},
    {"damping", "viscous damping"},
    {"asymmetry", "how much the damping depends on the direction"},
    {"drag", "quadratic drag"},
    {"preload", "constant force or torque in the joint"},
    {"coulomb.T", "dry friction"},
    {"coulomb.w", "speed over which dry friction turns round"},
    {"backlash.k", "stiffness at the ends of the backlash"},
    {"backlash.gap", "half of the backlash"},
    {"friction.A", "friction, level of the sliding value"},
    {"friction.vt", "friction, speed over which it turns round"},
    {"friction.B1", "friction, how much more it is at slow speeds"},
    {"friction.B2", "friction, how soon that surplus ends"},
    {"normal.a", "contact, cubic stiffness"},
    {"normal.b", "contact, quadratic stiffness"},
    {"normal.c", "contact, linear stiffness"},
    {"normal.D", "contact, damping"},
    {"normal.p", "contact, exponent beyond the cubic law"},
    {"normal.h", "contact, hysteresis"},
    {"normal.F0", "contact, force at first touch"},
    {"gap", "contact, how much deeper the worn surface lies"},
    {"adhesion.F", "contact, pull-off force"},
    {"adhesion.range", "contact, range of the adhesion"},
    {"initial.position", "position at the start"},
    {"initial.guess", "position from which loops are closed at the start"},
    {"initial.speed", "speed at the start"},
    {"sensor.gain", "instrument, gain"},
    {"sensor.offset", "instrument, offset"},
    {"sensor.square", "instrument, curvature"},
    {"sensor.tilt", "instrument, tilt against the horizontal"},
    {"sensor.delay", "instrument, delay (for recorded data)"},
    {"delay", "signal, delay (for recorded data)"},
    {"gain", "signal, gain"},
    {"error", "recorder, relative error of its clock (for recorded data)"},
    {"radius", "radius"},
    {"facing", "direction in which the line faces"},
    {"extent.lo", "lower end of the line"},
    {"extent.hi", "upper end of the line"},
    {"lean", "lean of the vertical face"},
    {"angle", "angle"},
    {"tilt", "tilt of the upper face"},
    {"length", "length at which the spring is slack"},
    {"x", "x"},
    {"y", "y"},
    {"z", "z"},
};

/* does a name end in a dot and `end`? @return length of what is before, or 0 */
static size_t before(const char *name, const char *end)
{
    size_t n = strlen(name), k = strlen(end);
    int fits = n > k + 1 && name[n - k - 1] == '.' && strcmp(name + n - k, end) == 0;
    return fits ? n - k - 1 : 0;
}

char *fmu__words_param(const fmu_list *list, int param)
{
    const char *name = list->model->params[param].name;
    const char *about = fmu__about(list->m, "parameters", name);
    if (about != NULL) {
        return lab__text("%s", about);
    }
    for (int i = 0; i < list->m->ndial; i++) {
        const mech_dial *d = &list->m->dials[i];
        if (strcmp(list->m->params[d->param].name, name) == 0 && strcmp(d->label, name) != 0) {
            return lab__text("%s", d->label);
        }
    }
    const char *words = NULL;
    size_t owner = 0;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        size_t n = before(name, endings[i].end);
        if (n > 0 && (words == NULL || n < owner)) {
            words = endings[i].words;
            owner = n;
        }
    }
    return words != NULL ? lab__text("%.*s: %s", (int)owner, name, words)
                         : lab__text("parameter %s of the mechanism file", name);
}

/* ---- outputs and inputs ---- */

char *fmu__words_channel(const fmu_list *list, int channel)
{
    const stein_channel *c = &list->model->channels[channel];
    const char *about = fmu__about(list->m, "outputs", c->name);
    if (about != NULL) {
        return lab__text("%s", about);
    }
    // the file does not name "time", which is channel 0
    const char *thing = channel > 0 ? mech_target(list->m, &list->m->channels[channel - 1]) : "";
    return lab__text("%s%s%s%s", mech_output_kind_of((int)c->read)->about, thing,
                     c->sign < 0 ? ", counted the other way" : "",
                     c->from_rest ? ", from its value at rest" : "");
}

char *fmu__words_input(const fmu_list *list, int input, const char *what)
{
    const stein_model *m = list->model;
    const stein_input *in = &m->inputs[input];
    const char *about = fmu__about(list->m, "inputs", in->name);
    if (in->kind == STEIN_INPUT_MOTION) {
        return lab__text("%s joint %s%s%s", what, m->bodies[in->index].name,
                         about != NULL ? ": " : "", about != NULL ? about : "");
    }
    if (about != NULL) {
        return lab__text("%s", about);
    }
    return in->kind == STEIN_INPUT_POINT ? lab__text("force on point %s", m->points[in->index].name)
           : in->kind == STEIN_INPUT_VOLTAGE
               ? lab__text("voltage at the motor of joint %s", m->bodies[in->index].name)
               : lab__text("force or torque in joint %s", m->bodies[in->index].name);
}
