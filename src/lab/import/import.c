/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.c - from a project of another program to a mechanism file that the own reader accepts.
 */
#include <stdlib.h>

#include "mbs.h"

/* what was written is read before anybody else does it: a project may hold what no body can have */
static stein_status check(const char *name, const char *text, size_t size, stein_err *err)
{
    mechanism *m = NULL;
    stein_status status = mech_read_text(&m, name, text, size, NULL, 0, NULL, NULL, err);
    mech_free(m);
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

static stein_status convert(mbs_project *p, const xml_node *root, const char *to, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = mbs_take(p, root);
    status = status == STEIN_OK ? mbs_text(p, &text, &size, err) : status;
    status = status == STEIN_OK ? write_file(to, text, size, err) : status;
    status = status == STEIN_OK ? check(to, text, size, err) : status;
    free(text);
    return status;
}

stein_status lab_import_mbs(const char *file, const char *to, lab_report_fn *report, void *ctx,
                            lab_imported *done, stein_err *err)
{
    xml_node *root = NULL;
    stein_status status = xml_read(&root, file, err);
    if (status != STEIN_OK) {
        return status;
    }
    mbs_project *p = calloc(1, sizeof *p);
    if (p == NULL) {
        xml_free(root);
        return lab__fail(err, STEIN_ENOMEM, "out of memory for %s", file);
    }
    p->file = file;
    p->report = report;
    p->ctx = ctx;
    p->err = err;
    status = convert(p, root, to, err);
    if (status == STEIN_OK && done != NULL) {
        *done = (lab_imported){
            .bodies = p->nbody, .joints = p->njoint, .points = p->npoint, .left_out = p->nnote};
        snprintf(done->name, sizeof done->name, "%s", p->name);
    }
    for (int i = 0; i < p->nnote; i++) {
        free(p->note[i]);
    }
    free(p->note);
    free(p);
    xml_free(root);
    return status;
}
