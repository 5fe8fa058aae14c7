/* SPDX-License-Identifier: GPL-3.0-or-later
 * variables.c - the variables of an FMU: outputs, inputs, states and numbers of the mechanism.
 *
 *      time                      independent      the mechanism's outputs     output
 *      NAME                      input            a force
 *      NAME.position, .speed, .acceleration       input, a prescribed motion
 *      NAME.follow               fixed, Boolean   does the joint follow it?
 *      LOAD.present              input, Boolean   is the free load there?
 *      parameters                tunable or fixed
 *      simulation.dt             fixed            step of the integrator
 *      BODY.q, .qd, .qdd         local            coordinate, speed, acceleration of each joint
 *      NAME.guard1, ...          local            > 0 where a contact or notch touches
 *      NAME.stick1, ...          local            >= 0 until friction that sticks changes
 *
 * A name that is taken already gets the kind of the variable in front ("input.finger").
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

int fmu__is_tunable(const mechanism *m, const stein_model *model, int param)
{
    const char *name = model->params[param].name;
    int k = mech_find_param(m, name, NULL), declared = 0;
    for (int i = 0; i < m->nparam; i++) {
        declared |= m->params[i].declared;
    }
    for (int i = 0; i < m->ndial; i++) {
        if (m->dials[i].param == k) {
            return 1;
        }
    }
    if (k < 0 || m->ndial > 0) {
        return 0;
    }
    if (declared) {
        return m->params[k].declared;
    }
    return m->params[k].stated && strstr(name, ".initial.") == NULL;
}

/* what an output follows from; a friction that sticks holds, whatever force acts */
static int reach_of(const stein_model *model, stein_read_kind read)
{
    int holds = read == STEIN_READ_TANGENT && model->nstick > 0;
    return holds ? MECH_FROM_FORCES : mech_output_kind_of((int)read)->from;
}

int fmu__depends(const stein_model *model, const fmu_variable *output, const fmu_variable *input)
{
    const stein_channel *c = &model->channels[output->is.index];
    if (input->is.kind == FMI_LOAD) { // it is put where the mechanism is
        return reach_of(model, c->read) >= MECH_FROM_PLACES;
    }
    const stein_input *in = &model->inputs[input->is.index];
    int is_echo =
        c->read == STEIN_READ_INPUT ||
        (c->read == STEIN_READ_INPUT_FORCE && model->inputs[c->index].kind != STEIN_INPUT_MOTION);
    if (is_echo) { // an input without change
        return c->index == input->is.index && input->is.order == 0;
    }
    int reach = reach_of(model, c->read);
    return in->kind == STEIN_INPUT_MOTION ? input->is.order <= reach : reach == MECH_FROM_FORCES;
}

/* ---- the list ---- */

static const char *kind_of(fmu_causality causality)
{
    static const char *const name[] = {"time", "output", "input", "parameter", "local"};
    return name[causality];
}

static int is_taken(const fmu_list *list, const char *name)
{
    for (int i = 0; i < list->n; i++) {
        // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): what is listed has a name
        if (strcmp(list->v[i].name, name) == 0) {
            return 1;
        }
    }
    return 0;
}

/* one more; name and text are taken over, also on failure */
static stein_status add(fmu_list *list, fmu_variable v, stein_err *err)
{
    if (v.name != NULL && is_taken(list, v.name)) {
        char *longer = lab__text("%s.%s", kind_of(v.causality), v.name);
        free(v.name);
        v.name = longer;
    }
    stein_status status = STEIN_OK;
    if (v.name == NULL || v.text == NULL) {
        status = lab__no_memory(err);
    } else if (is_taken(list, v.name)) {
        status = lab__fail(err, STEIN_EINVAL,
                           "two variables of the FMU would be called \"%s\": rename one of them in "
                           "the mechanism file",
                           v.name);
    }
    if (status != STEIN_OK || v.name == NULL) {
        free(v.name);
        free(v.text);
        return status;
    }
    v.reference = fmi_reference(list->model, v.is);
    list->v[list->n++] = v;
    return STEIN_OK;
}

static stein_status add_channel(fmu_list *list, int i, stein_err *err)
{
    const stein_channel *c = &list->model->channels[i];
    return add(list,
               (fmu_variable){
                   .is = {FMI_CHANNEL, i, 0},
                   .name = lab__text("%s", c->name),
                   .text = i == 0 ? lab__text("simulated time") : fmu__words_channel(list, i),
                   .unit = c->unit,
                   .causality = i == 0 ? FMU_INDEPENDENT : FMU_OUTPUT,
                   .variability = c->read == STEIN_READ_NOTCH_PHASE ? FMU_DISCRETE : FMU_CONTINUOUS,
                   .derivative_of = -1},
               err);
}

/* an input of a motion, or the force that another input is */
static stein_status add_input(fmu_list *list, int i, int order, double start, stein_err *err)
{
    static const char *const part[] = {"position", "speed", "acceleration"};
    static const char *const words[] = {"position given to", "speed given to",
                                        "acceleration given to"};
    static const char *const turning[] = {"rad", "rad/s", "rad/s^2"};
    static const char *const sliding[] = {"m", "m/s", "m/s^2"};
    const stein_input *in = &list->model->inputs[i];
    int motion = in->kind == STEIN_INPUT_MOTION;
    int turns = motion && list->model->bodies[in->index].type == 'R';
    return add(list,
               (fmu_variable){.is = {FMI_INPUT, i, order},
                              .name = motion ? lab__text("%s.%s", in->name, part[order])
                                             : lab__text("%s", in->name),
                              .text = fmu__words_input(list, i, words[order]),
                              .unit = !motion ? in->unit
                                      : turns ? turning[order]
                                              : sliding[order],
                              .causality = FMU_INPUT,
                              .variability = FMU_CONTINUOUS,
                              .has_start = 1,
                              .start = start,
                              .derivative_of = -1},
               err);
}

static stein_status add_follow(fmu_list *list, int i, stein_err *err)
{
    const stein_input *in = &list->model->inputs[i];
    return add(list,
               (fmu_variable){.is = {FMI_FOLLOW, i, 0},
                              .name = lab__text("%s.follow", in->name),
                              .text = lab__text("does joint %s follow the motion that is given?",
                                                list->model->bodies[in->index].name),
                              .unit = "1",
                              .causality = FMU_PARAMETER,
                              .variability = FMU_FIXED,
                              .boolean = 1,
                              .has_start = 1,
                              .start = in->hold,
                              .derivative_of = -1},
               err);
}

static stein_status add_load(fmu_list *list, stein_err *err)
{
    const char *name = list->model->bodies[list->model->load.body].name;
    const char *about = fmu__about(list->m, "load", "");
    return add(list,
               (fmu_variable){.is = {FMI_LOAD, 0, 0},
                              .name = lab__text("%s.present", name),
                              .text = about != NULL ? lab__text("is it there? %s", about)
                                                    : lab__text("is the free load there?"),
                              .unit = "1",
                              .causality = FMU_INPUT,
                              .variability = FMU_DISCRETE,
                              .boolean = 1,
                              .has_start = 1,
                              .start = 1.0,
                              .derivative_of = -1},
               err);
}

static stein_status add_inputs(fmu_list *list, const double *d, stein_err *err)
{
    const stein_model *m = list->model;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < m->ninput; i++) {
        const stein_input *in = &m->inputs[i];
        if (in->kind != STEIN_INPUT_MOTION) {
            status = add_input(list, i, 0, 0.0, err);
            continue;
        }
        for (int order = 0; status == STEIN_OK && order < 3; order++) {
            double start = order == 0 ? d[m->initial + 2 * in->index] : 0.0;
            status = add_input(list, i, order, start, err);
        }
        status = status == STEIN_OK ? add_follow(list, i, err) : status;
    }
    return status;
}

static stein_status add_param(fmu_list *list, int i, stein_err *err)
{
    const stein_param *p = &list->model->params[i];
    return add(list,
               (fmu_variable){.is = {FMI_PARAMETER, i, 0},
                              .name = lab__text("%s", p->name),
                              .text = fmu__words_param(list, i),
                              .unit = p->unit,
                              .causality = FMU_PARAMETER,
                              .variability = fmu__is_tunable(list->m, list->model, i) ? FMU_TUNABLE
                                                                                      : FMU_FIXED,
                              .has_start = 1,
                              .start = p->value,
                              .derivative_of = -1},
               err);
}

static stein_status add_step(fmu_list *list, stein_err *err)
{
    return add(list,
               (fmu_variable){.is = {FMI_STEP, 0, 0},
                              .name = lab__text("simulation.dt"),
                              .text = lab__text("step of the integrator"),
                              .unit = "s",
                              .causality = FMU_PARAMETER,
                              .variability = FMU_FIXED,
                              .has_start = 1,
                              .start = list->model->dt,
                              .derivative_of = -1},
               err);
}

static stein_status add_coordinate(fmu_list *list, int joint, int order, stein_err *err)
{
    static const char *const ending[] = {"q", "qd", "qdd"};
    static const char *const words[] = {"coordinate", "speed", "acceleration"};
    static const char *const turning[] = {"rad", "rad/s", "rad/s^2"};
    static const char *const sliding[] = {"m", "m/s", "m/s^2"};
    const stein_body *b = &list->model->bodies[joint];
    return add(list,
               (fmu_variable){.is = {FMI_COORDINATE, joint, order},
                              .name = lab__text("%s.%s", b->name, ending[order]),
                              .text = lab__text("%s of joint %s", words[order], b->name),
                              .unit = (b->type == 'R' ? turning : sliding)[order],
                              .causality = FMU_LOCAL,
                              .variability = FMU_CONTINUOUS,
                              .derivative_of = order == 0 ? -1 : list->n - 1},
               err);
}

/* of a spot of a contact, or of a notch */
static stein_status add_guard(fmu_list *list, int i, stein_err *err)
{
    static const char *const of_notch[] = {
        "the beak's end is in the roof", "the corner is in the beak",
        "the beak's end is in the vertical face", "the beak's end is beside the roof"};
    const stein_model *m = list->model;
    int spot = i < m->nspot, k = i - m->nspot;
    const stein_contact *c = spot ? &m->contacts[m->spots[i].contact] : NULL;
    const char *name = spot ? c->name : m->notches[k / FMI_NOTCH_GUARDS].name;
    int number = spot ? i - c->first_spot : k % FMI_NOTCH_GUARDS;
    return add(
        list,
        (fmu_variable){.is = {FMI_GUARD, i, 0},
                       .name = lab__text("%s.guard%d", name, number + 1),
                       .text = spot ? lab__text("positive where contact %s touches", name)
                                    : lab__text("%s: positive where %s", name, of_notch[number]),
                       .unit = "m",
                       .causality = FMU_LOCAL,
                       .variability = FMU_CONTINUOUS,
                       .derivative_of = -1},
        err);
}

/* of a place of friction that sticks: in newtons, or in metres a second while it slips */
static stein_status add_stick(fmu_list *list, int i, stein_err *err)
{
    const stein_model *m = list->model;
    int place = i - (fmi_guards(m) - m->nstick), is_joint, number = 1;
    const stein_stick *stick = &m->sticks[place];
    is_joint = stick->kind == STEIN_STICK_JOINT;
    const stein_contact *c = is_joint ? NULL : &m->contacts[m->spots[stick->index].contact];
    number += is_joint ? 0 : stick->index - c->first_spot;
    const char *name = is_joint ? m->bodies[stick->index].name : c->name;
    return add(list,
               (fmu_variable){.is = {FMI_GUARD, i, 0},
                              .name = lab__text("%s.stick%d", name, number),
                              .text = lab__text("not negative while the friction of %s sticks, or "
                                                "slips in its direction",
                                                name),
                              .unit = "1",
                              .causality = FMU_LOCAL,
                              .variability = FMU_CONTINUOUS,
                              .derivative_of = -1},
               err);
}

stein_status fmu__list_create(fmu_list *list, const lab_model *model, stein_err *err)
{
    const stein_model *m = lab_equations(model);
    *list = (fmu_list){.m = lab__mechanism(model), .model = m};
    size_t most = (size_t)m->nchannel + 4 * (size_t)m->ninput + (size_t)m->np + 3 * (size_t)m->nq +
                  2 + (size_t)fmi_guards(m);
    double *d = malloc(sizeof *d * ((size_t)m->nd + 1));
    list->v = calloc(most, sizeof *list->v);
    if (d == NULL || list->v == NULL) {
        free(d);
        free(list->v);
        list->v = NULL;
        return lab__no_memory(err);
    }
    stein_status status = STEIN_OK;
    stein_setup(m, lab_parameters(model), d);
    for (int i = 0; status == STEIN_OK && i < m->nchannel; i++) {
        status = add_channel(list, i, err);
    }
    status = status == STEIN_OK ? add_inputs(list, d, err) : status;
    if (status == STEIN_OK && m->load.body >= 0) {
        status = add_load(list, err);
    }
    for (int i = 0; status == STEIN_OK && i < m->np; i++) {
        status = add_param(list, i, err);
    }
    status = status == STEIN_OK ? add_step(list, err) : status;
    for (int i = 0; status == STEIN_OK && i < 3 * m->nq; i++) {
        status = add_coordinate(list, i / 3, i % 3, err);
    }
    for (int i = 0; status == STEIN_OK && i < fmi_guards(m); i++) {
        int places = i >= fmi_guards(m) - m->nstick;
        status = places ? add_stick(list, i, err) : add_guard(list, i, err);
    }
    free(d);
    if (status != STEIN_OK) {
        fmu__list_free(list);
    }
    return status;
}

void fmu__list_free(fmu_list *list)
{
    for (int i = 0; i < list->n; i++) {
        free(list->v[i].name);
        free(list->v[i].text);
    }
    free(list->v);
    list->v = NULL;
    list->n = 0;
}
