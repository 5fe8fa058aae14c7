/* SPDX-License-Identifier: GPL-3.0-or-later
 * lab.c - a stroke of any mechanism file, judged by the laboratory: lab stein1788.yaml
 */
#include <stdio.h>
#include <stein/lab.h>

static int run(stein_sim *sim, const stein_model *model, stein_err *err)
{
    lab_stroke_def def = lab_stroke_def_default(model);
    lab_stroke stroke;
    if (lab_strike(sim, &def, &stroke, err) != STEIN_OK) {
        return 0;
    }
    printf("%s, escapement %.3f mm below the string\n", lab_outcome_text(stroke.outcome),
           1e3 * stroke.escape_height);
    return 1;
}

int main(int argc, char **argv)
{
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    stein_err err = {STEIN_OK, ""};
    if (argc != 2) {
        return fprintf(stderr, "usage: lab MODEL.yaml\n"), 2;
    }
    int ok = lab_open(&model, argv[1], &options, &err) == STEIN_OK &&
             lab_sim(model, NULL, &sim, &err) == STEIN_OK && run(sim, lab_equations(model), &err);
    if (!ok) {
        fprintf(stderr, "%s\n", err.msg);
    }
    stein_sim_destroy(sim);
    lab_close(model);
    return !ok;
}
