/* SPDX-License-Identifier: GPL-3.0-or-later
 * study.c - the parts of the study in their order, and their files.
 */
#include <stdlib.h>
#include <string.h>

#include "study.h"

static study_part_fn *const parts[] = {study_paper,    study_regulation, study_angle,
                                       study_touches,  study_repetition, study_sensitivity,
                                       study_tolerance};
enum { NPARTS = sizeof parts / sizeof *parts };

stein_status study_run(study *s, study_report *report, stein_err *err)
{
    memset(report, 0, sizeof *report);
    stein_status status = study_begin(s, err);
    if (status != STEIN_OK) {
        return status;
    }
    study_slope *slope = calloc((size_t)lab_equations(s->model)->np + 1, sizeof *slope);
    status = slope == NULL ? lab__no_memory(err) : study_slopes(s, slope, &s->nslope, err);
    s->slope = slope;
    for (int i = 0; status == STEIN_OK && i < NPARTS; i++) {
        status = parts[i](s, &report->part[report->npart++], err);
    }
    s->slope = NULL;
    s->nslope = 0;
    free(slope);
    return status;
}

void study_report_free(study_report *report)
{
    for (int i = 0; i < report->npart; i++) {
        study_part_free(&report->part[i]);
    }
    report->npart = 0;
}

static stein_status write_part(const study *s, const study_part *part, const char *folder,
                               stein_err *err)
{
    stein_status status = part->lost ? lab__no_memory(err) : STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < part->ntable; i++) {
        if (part->table[i].name[0] == '\0') {
            continue;
        }
        char *path = lab__text("%s/%s.csv", folder, part->table[i].name);
        status =
            path == NULL ? lab__no_memory(err) : study_write_csv(s, &part->table[i], path, err);
        free(path);
    }
    for (int i = 0; status == STEIN_OK && i < part->nchart; i++) {
        char *path = lab__text("%s/%s.svg", folder, part->chart[i].name);
        status = path == NULL ? lab__no_memory(err) : study_draw(&part->chart[i], path, err);
        free(path);
    }
    return status;
}

stein_status study_write(const study *s, const study_report *report, const char *folder,
                         stein_err *err)
{
    stein_status status = lab__folder(folder, err);
    for (int i = 0; status == STEIN_OK && i < report->npart; i++) {
        status = write_part(s, &report->part[i], folder, err);
    }
    return status == STEIN_OK ? study_page(s, report, folder, err) : status;
}
