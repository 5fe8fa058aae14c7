/* SPDX-License-Identifier: MIT
 * action.c - an action as an LV2 plugin: a signal presses the key, the force on the string comes
 * out.
 *
 *   ports: 0 finger (audio in, 1 = `weight`)   1 string (audio out, 1 = 10 N)
 *          2 weight [N]                        3 stop: shift of the pawl's stop [mm]
 *
 * run() is as hard a real-time function as the core: no allocation, lock or system call. The stop
 * goes through a hand-over with a pace, so that it can be turned while the beak lies in the notch.
 */
#include <lv2/core/lv2.h>
#include <stdlib.h>

#include <stein/stein.h>

enum { FINGER, STRING, WEIGHT, STOP, PORTS, STEP = 2 };

typedef struct action {
    stein_sim *sim;
    stein_handover *handover;
    int force;
    double finger; /* [N] */
    int at;        /* sample within the step */
    float *port[PORTS];
} action;

static void press(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = ((const action *)ctx)->finger;
}

static void cleanup(LV2_Handle handle)
{
    action *a = handle;
    stein_handover_destroy(a->handover);
    stein_sim_destroy(a->sim);
    free(a);
}

static LV2_Handle instantiate(const LV2_Descriptor *descriptor, double rate, const char *path,
                              const LV2_Feature *const *features)
{
    (void)descriptor;
    (void)path;
    (void)features;
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    action *a = calloc(1, sizeof *a);
    def.dt = STEP / rate;
    if (a == NULL || stein_sim_create(&a->sim, model, &def, NULL) != STEIN_OK ||
        stein_handover_create(&a->handover, model, NULL, NULL) != STEIN_OK) {
        if (a != NULL) {
            cleanup(a);
        }
        return NULL;
    }
    a->force = stein_find_channel(model, "string_force");
    stein_drive(a->sim, "finger", press, a, NULL);
    stein_handover_pace(a->handover, "pawl.stop_shift", 0.01, NULL);
    return a;
}

static void connect_port(LV2_Handle handle, uint32_t port, void *data)
{
    if (port < PORTS) {
        ((action *)handle)->port[port] = data;
    }
}

static void activate(LV2_Handle handle)
{
    action *a = handle;
    stein_reset(a->sim, NULL);
    stein_load_lift(a->sim);
}

static void run(LV2_Handle handle, uint32_t samples)
{
    action *a = handle;
    stein_handover_set(a->handover, "pawl.stop_shift", 1e-3 * (double)*a->port[STOP], NULL);
    stein_handover_publish(a->handover);
    for (uint32_t i = 0; i < samples; i++, a->at = (a->at + 1) % STEP) {
        if (a->at == 0) {
            a->finger = (double)a->port[FINGER][i] * (double)*a->port[WEIGHT];
            stein_handover_take(a->handover, a->sim);
            if (stein_step(a->sim, NULL) != STEIN_OK) {
                activate(handle); // at rest again, not stuck where it failed
            }
        }
        a->port[STRING][i] = (float)(0.1 * stein_read(a->sim, a->force));
    }
}

static const LV2_Descriptor descriptor = {
    "urn:stein:action1788", instantiate, connect_port, activate, run, NULL, cleanup, NULL};

LV2_SYMBOL_EXPORT const LV2_Descriptor *lv2_descriptor(uint32_t index)
{
    return index == 0 ? &descriptor : NULL;
}
