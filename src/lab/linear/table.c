/* SPDX-License-Identifier: GPL-3.0-or-later
 * table.c - names of the states of a linearised mechanism, and its matrices as one CSV table:
 *
 *      row          states    inputs
 *      d/dt state     A         B
 *      output         C         D
 */
#include <stdlib.h>
#include <string.h>

#include "io.h"

static const char *unit_of(const stein_model *model, int joint, int speed)
{
    int turns = model->bodies[joint].type == 'R';
    return speed == 0   ? (turns ? "rad" : "m")
           : speed == 1 ? (turns ? "rad/s" : "m/s")
                        : (turns ? "rad/s^2" : "m/s^2");
}

const char *lab_linear_unit(const stein_model *model, const stein_linear_system *s, int state,
                            int derivative)
{
    return unit_of(model, s->joint[state % s->n], state / s->n + derivative);
}

/* an input of a prescribed motion is its acceleration */
const char *lab_linear_input_unit(const stein_model *model, const stein_linear_system *s, int input)
{
    const stein_input *in = &model->inputs[s->input[input]];
    return in->kind == STEIN_INPUT_MOTION ? unit_of(model, in->index, 2) : in->unit;
}

static void put_columns(FILE *f, const stein_model *model, const stein_linear_system *s)
{
    fprintf(f, "row");
    for (int k = 0; k < 2 * s->n; k++) {
        fprintf(f, ",%s.%s [%s]", k < s->n ? "q" : "qd", model->bodies[s->joint[k % s->n]].name,
                lab_linear_unit(model, s, k, 0));
    }
    for (int i = 0; i < s->ninput; i++) {
        const stein_input *in = &model->inputs[s->input[i]];
        fprintf(f, ",%s%s [%s]", in->kind == STEIN_INPUT_MOTION ? "d2/dt2 " : "", in->name,
                lab_linear_input_unit(model, s, i));
    }
    fprintf(f, "\n");
}

static void put_row(FILE *f, const double *states, const double *inputs,
                    const stein_linear_system *s)
{
    char number[LAB_NUMBER];
    for (int k = 0; k < 2 * s->n; k++) {
        fprintf(f, ",%s", lab__number(number, states[k]));
    }
    for (int i = 0; i < s->ninput; i++) {
        fprintf(f, ",%s", lab__number(number, inputs[i]));
    }
    fprintf(f, "\n");
}

stein_status lab_linear_write(const char *path, const stein_model *model,
                              const stein_linear_system *s, const char *const *notes,
                              stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__put_notes(file.stream, notes);
    put_columns(file.stream, model, s);
    for (int k = 0; k < 2 * s->n; k++) {
        fprintf(file.stream, "d/dt %s.%s [%s]", k < s->n ? "q" : "qd",
                model->bodies[s->joint[k % s->n]].name, lab_linear_unit(model, s, k, 1));
        put_row(file.stream, s->A + k * 2 * s->n, s->B + k * s->ninput, s);
    }
    for (int i = 0; i < s->noutput; i++) {
        fprintf(file.stream, "%s [%s]", model->channels[i].name, model->channels[i].unit);
        put_row(file.stream, s->C + i * 2 * s->n, s->D + i * s->ninput, s);
    }
    return lab__file_close(&file, 1, err);
}
