/* SPDX-License-Identifier: MIT
 * channel.c - output channels: what an instrument on the mechanism would show.
 */
#include <math.h>

#include "loops.h"

static double contact_sum(const stein_sim *sim, int contact, stein_read_kind kind)
{
    const stein_contact *c = &sim->model->contacts[contact];
    double gap = INFINITY, normal = 0.0, tangent = 0.0;
    for (int i = c->first_spot; i < c->first_spot + c->nspot; i++) {
        gap = fmin(gap, sim->fresh == FRESH ? sim->spot[i].gap : stein__spot_gap(sim, i));
        normal += sim->spot[i].normal;
        tangent += sim->spot[i].tangent;
    }
    return kind == STEIN_READ_GAP ? gap : kind == STEIN_READ_FORCE ? normal : tangent;
}

static double point_component(stein_sim *sim, int point, stein_read_kind kind)
{
    double x[3], v[3];
    if (sim->model->points[point].at < 0) {
        sim->model->point(sim->xq, sim->xqd, sim->sc, sim->d, sim->px, sim->pv, sim->pJ, sim->pa);
    }
    stein__point(sim, point, x, v);
    return kind < STEIN_READ_VX ? x[kind - STEIN_READ_X] : v[kind - STEIN_READ_VX];
}

/* what the drive of a prescribed joint has to supply: M qdd + c less all other generalised forces
 * and those of loops */
static double needed_force(stein_sim *sim, int input)
{
    int joint = sim->model->inputs[input].index;
    sim->model->inverse(sim->xq, sim->xqd, sim->qdd, sim->sc, sim->d, sim->zero, sim->zero, sim->c);
    if (sim->model->nrow > 0) {
        for (int j = 0; j < sim->model->nq; j++) {
            sim->c[j] -= sim->Q[j];
        }
        stein__loops_take(sim, sim->c);
        return sim->c[joint];
    }
    return sim->c[joint] - sim->Q[joint];
}

/* the angle of a body as drawn: without jumps, since coordinates have none */
static double plane_angle(const stein_sim *sim, int body)
{
    double sum = 0.0;
    for (int i = body; i >= 0; i = sim->model->bodies[i].parent) {
        const stein_body *b = &sim->model->bodies[i];
        int sense = b->axis == 'y' ? -b->sign : b->sign; // +y turns clockwise as drawn
        sum += b->type == 'R' ? sense * sim->xq[i] : 0.0;
    }
    return sum;
}

/* the reading of a channel before sign and zero */
static double reading(stein_sim *sim, const stein_channel *channel)
{
    const stein_model *model = sim->model;
    int i = channel->index;
    double e[2];
    switch (channel->read) {
    case STEIN_READ_TIME: return sim->head->t;
    case STEIN_READ_POSITION: return sim->xq[i];
    case STEIN_READ_SPEED: return sim->xqd[i];
    case STEIN_READ_ACCELERATION: return sim->qdd[i];
    case STEIN_READ_X:
    case STEIN_READ_Y:
    case STEIN_READ_Z:
    case STEIN_READ_VX:
    case STEIN_READ_VY:
    case STEIN_READ_VZ: return point_component(sim, i, channel->read);
    case STEIN_READ_GAP:
    case STEIN_READ_FORCE:
    case STEIN_READ_TANGENT: return contact_sum(sim, i, channel->read);
    case STEIN_READ_NOTCH_FORCE: return sim->beak[i].normal;
    case STEIN_READ_NOTCH_PHASE: return stein_notch_phase(sim, i);
    case STEIN_READ_NOTCH_OVERLAP: return sim->beak[i].gap;
    case STEIN_READ_INPUT: return sim->ustate[3 * i];
    case STEIN_READ_INPUT_FORCE:
        return model->inputs[i].kind == STEIN_INPUT_MOTION ? needed_force(sim, i)
                                                           : sim->ustate[3 * i];
    case STEIN_READ_KINETIC:
    case STEIN_READ_POTENTIAL:
        model->energy(sim->xq, sim->xqd, sim->sc, sim->d, e);
        return e[channel->read == STEIN_READ_POTENTIAL];
    case STEIN_READ_ANGLE: return plane_angle(sim, i);
    case STEIN_READ_REACTION: return stein__reaction(sim, i);
    default: return stein__attitude(sim, channel->read, i);
    }
}

/* horizontal position of what a channel looks at; 0 where there is no such thing */
static double marker_x(stein_sim *sim, const stein_channel *channel)
{
    const stein_model *model = sim->model;
    if (channel->read >= STEIN_READ_X && channel->read <= STEIN_READ_Z) {
        return point_component(sim, channel->index, STEIN_READ_X);
    }
    if (channel->read == STEIN_READ_GAP) {
        const stein_shape *side = &model->spots[model->contacts[channel->index].first_spot].side[0];
        const double *shape = sim->d + side->d;
        if (side->kind == STEIN_SPHERE) {
            const double *o = sim->pose3[side->frame].o, *R = sim->pose3[side->frame].R;
            return o[0] + R[0] * shape[STEIN_SOLID_X] + R[1] * shape[STEIN_SOLID_Y] +
                   R[2] * shape[STEIN_SOLID_Z];
        }
        return place(&sim->pose[side->frame], shape[STEIN_SHAPE_X], shape[STEIN_SHAPE_Z]).x;
    }
    return 0.0;
}

/* value and marker's x of every channel in the initial state, before its instrument */
void stein__note_rest(stein_sim *sim)
{
    for (int i = 0; i < sim->model->nchannel; i++) {
        const stein_channel *channel = &sim->model->channels[i];
        sim->rest[2 * i] = channel->sign * reading(sim, channel);
        sim->rest[2 * i + 1] = marker_x(sim, channel);
    }
}

/* a contact that is off has no force: nothing has to be evaluated to know that */
static int is_off(const stein_sim *sim, const stein_channel *channel)
{
    return (channel->read == STEIN_READ_FORCE || channel->read == STEIN_READ_TANGENT) &&
           !stein_touches(sim, channel->index);
}

/* a camera sees no forces: the poses are enough for it, an eighth of an evaluation */
static int shows_place(const stein_channel *channel)
{
    int read = (int)channel->read;
    return stein_reads_place(read) || stein_reads_attitude(read) || read == STEIN_READ_SPEED ||
           (read >= STEIN_READ_VX && read <= STEIN_READ_VZ);
}

/* what a reading of the current state needs */
static stein_status prepare(stein_sim *sim, const stein_channel *channel)
{
    if (sim->fresh == FRESH || !shows_place(channel)) {
        return stein__refresh(sim, NULL);
    }
    stein__place(sim);
    return STEIN_OK;
}

double stein__channel_slope(stein_sim *sim, int i)
{
    const stein_channel *channel = &sim->model->channels[i];
    const double *sensor = sim->d + channel->sensor;
    double slope = sensor[STEIN_SENSOR_GAIN];
    if (sensor[STEIN_SENSOR_SQUARE] != 0.0 && prepare(sim, channel) == STEIN_OK) {
        double moved = channel->sign * reading(sim, channel) - sim->rest[2 * i];
        slope += 2.0 * sensor[STEIN_SENSOR_SQUARE] * moved;
    }
    return channel->sign * slope;
}

double stein_read(stein_sim *sim, int i)
{
    if (i < 0 || i >= sim->model->nchannel) {
        return NAN;
    }
    const stein_channel *channel = &sim->model->channels[i];
    int off = is_off(sim, channel);
    if (!off && prepare(sim, channel) != STEIN_OK) {
        return NAN;
    }
    const double *sensor = sim->d + channel->sensor, *rest = sim->rest + 2 * i;
    double y = channel->sign * (off ? 0.0 : reading(sim, channel)), moved = y - rest[0];
    double value = sensor[STEIN_SENSOR_GAIN] * (channel->from_rest ? moved : y) +
                   sensor[STEIN_SENSOR_SQUARE] * moved * moved + sensor[STEIN_SENSOR_OFFSET];
    if (sensor[STEIN_SENSOR_TILT] != 0.0) {
        value += sensor[STEIN_SENSOR_TILT] * (marker_x(sim, channel) - rest[1]);
    }
    return value;
}

stein_status stein_read_name(stein_sim *sim, const char *name, double *value, stein_err *err)
{
    int i = stein_find_channel(sim->model, name);
    if (i < 0) {
        return stein__fail(err, STEIN_ENAME, "no output channel \"%s\" in model \"%s\"", name,
                           sim->model->name);
    }
    *value = stein_read(sim, i);
    return STEIN_OK;
}

const char *stein_event_at(const stein_model *model, const stein_event *event)
{
    int i = event->index;
    if (event->kind >= STEIN_EVENT_STICK) {
        const stein_stick *stick = &model->sticks[i];
        return stick->kind == STEIN_STICK_JOINT
                   ? model->bodies[stick->index].name
                   : model->contacts[model->spots[stick->index].contact].name;
    }
    return event->kind >= STEIN_EVENT_ESCAPEMENT ? model->notches[i].name : model->contacts[i].name;
}

int stein_touches(const stein_sim *sim, int contact)
{
    const stein_model *model = sim->model;
    int any = 0;
    if (contact >= 0 && contact < model->ncontact) {
        const stein_contact *c = &model->contacts[contact];
        for (int i = c->first_spot; i < c->first_spot + c->nspot; i++) {
            any |= sim->mode[i];
        }
    }
    return any;
}

/* Can a force across a touch change how fast it slides? Not where all that it acts on follows
 * signals. */
static int can_be_held(stein_sim *sim, const touch *t)
{
    const stein_model *model = sim->model;
    int n = model->nq;
    double *a = sim->work, most = 0.0, power = 0.0;
    memset(sim->Q, 0, sizeof *sim->Q * (size_t)n);
    stein__probe(sim, t, 1);
    for (int j = 0; j < n; j++) {
        most = fmax(most, fabs(sim->Q[j]));
        a[j] = stein__is_driven(sim, j) ? 0.0 : sim->Q[j];
    }
    if (model->nrow > 0) { // loops may leave what is free no motion either
        model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
        stein__loops_at(sim, sim->xq, sim->xqd);
        (void)stein__loops_solve(sim, a, 0);
    }
    for (int j = 0; j < n; j++) {
        power = fmax(power, fabs(sim->Q[j] * a[j]));
    }
    sim->fresh = KNOWN; // forces are those of the probe
    return power > 1e-12 * most * most;
}

int stein_slides(stein_sim *sim, int contact, double *speed, double *slip)
{
    int found = 0, held = 0;
    *speed = *slip = 0.0;
    if (contact < 0 || contact >= sim->model->ncontact || stein__refresh(sim, NULL) != STEIN_OK) {
        return 0;
    }
    for (int i = 0; i < sim->ntouch; i++) {
        const touch *t = &sim->touch[i];
        int smooth = t->pair->inverse_vt > 0.0 && t->pair->stick < 0;
        if (t->pair->index == contact && smooth && t->normal > 0.0) {
            held |= can_be_held(sim, t);
            found = 1;
            *slip = fmax(*slip, fabs(sim->slip[i]));
            *speed = fmax(*speed, fabs(sim->slip[i]) / t->pair->inverse_vt);
        }
    }
    if (!held) {
        *speed = *slip = 0.0;
    }
    return found && held;
}

int stein_notch_armed(stein_sim *sim, int notch)
{
    if (notch < 0 || notch >= sim->model->nnotch || stein__refresh(sim, NULL) != STEIN_OK) {
        return 0;
    }
    const unsigned char *mode = sim->mode + sim->model->nspot + NOTCH_GUARDS * notch;
    return !mode[NOTCH_REGION] && sim->beak[notch].gap > 0.0;
}
