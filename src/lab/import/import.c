/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.c - from a file of another program to a mechanism file that the own reader accepts.
 */
#include <stdlib.h>
#include <string.h>

#include "draft.h"

/* of a file without problems: what is taken all the same */
static void on_warning(void *ctx, const char *message)
{
    const draft *d = ctx;
    char text[400];
    snprintf(text, sizeof text, "%s%s",
             strstr(message, "warning: ") != NULL ? "" : "warning: ", message);
    if (d->report != NULL) {
        d->report(d->ctx, text);
    }
}

/* the written file is read again here: a file may hold what no body can have */
static stein_status check(draft *d, const char *name, const char *text, size_t size)
{
    mechanism *m = NULL;
    stein_status status = mech_read_text(&m, name, text, size, NULL, 0, NULL, NULL, d->err);
    mech_free(m);
    m = NULL;
    if (status == STEIN_OK) { // once more, since of a file with problems those would be reported
        status = mech_read_text(&m, name, text, size, NULL, 0, on_warning, d, d->err);
        mech_free(m);
    }
    return status;
}

static stein_status write_file(const char *to, const char *text, size_t size, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, to, err);
    if (status == STEIN_OK) {
        fwrite(text, 1, size, file.stream);
        status = lab__file_close(&file, 1, err);
    }
    return status;
}

static stein_status take(draft *d, const xml_node *root)
{
    if (strncmp(root->name, "mbsDesc", 7) == 0) {
        return mbs_take(d, root);
    }
    if (strcmp(root->name, "robot") == 0) {
        return urdf_take(d, root);
    }
    if (strcmp(root->name, "mujoco") == 0) {
        return mjcf_take(d, root);
    }
    return draft_wrong(d, root,
                       "<%.40s>, expected <mbsDescR7>, a project of ROBOTRAN, <robot>, a robot of "
                       "ROS (URDF), or <mujoco>, a model of MuJoCo (MJCF)",
                       root->name);
}

static stein_status convert(draft *d, const xml_node *root, const char *to)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = take(d, root);
    status = status == STEIN_OK ? draft_text(d, &text, &size, d->err) : status;
    status = status == STEIN_OK ? write_file(to, text, size, d->err) : status;
    status = status == STEIN_OK ? check(d, to, text, size) : status;
    free(text);
    return status;
}

stein_status lab_import(const char *file, const char *to, lab_inertia inertia,
                        lab_report_fn *report, void *ctx, lab_imported *done, stein_err *err)
{
    xml_node *root = NULL;
    stein_status status = xml_read(&root, file, err);
    if (status != STEIN_OK) {
        return status;
    }
    draft *d = calloc(1, sizeof *d);
    if (d == NULL) {
        xml_free(root);
        return lab__fail(err, STEIN_ENOMEM, "out of memory for %s", file);
    }
    d->file = file;
    d->inertia = inertia;
    d->report = report;
    d->ctx = ctx;
    d->err = err;
    status = convert(d, root, to);
    if (status == STEIN_OK && done != NULL) {
        *done = (lab_imported){.bodies = d->bodies,
                               .joints = d->joints,
                               .points = d->npoint,
                               .loops = d->nloop + d->ncoupling,
                               .left_out = d->nnote};
        snprintf(done->name, sizeof done->name, "%s", d->name);
    }
    for (int i = 0; i < d->nnote; i++) {
        free(d->note[i]);
    }
    free(d->note);
    free(d);
    xml_free(root);
    return status;
}
