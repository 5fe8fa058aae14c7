/* SPDX-License-Identifier: GPL-3.0-or-later
 * csv.c - any bytes as measured data of the action; accepted files are audited as well.
 */
#include <math.h>

#include "fuzz.h"
#include "stein/data.h"
#include "stein/models.h"

static void hear(void *ctx, const char *message)
{
    int *problems = ctx;
    must(message[0] != '\0', "a problem is told in words");
    ++*problems;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lab_data *d = NULL;
    lab_audit *audit = NULL;
    stein_err err = {STEIN_OK, ""};
    int problems = 0;
    lab_data_options options = lab_data_options_default(&stein_model_stein1788);
    options.report = hear;
    options.ctx = &problems;
    if (lab_data_open(&d, fuzz_file(data, size), &options, &err) != STEIN_OK) {
        must(d == NULL && err.msg[0] != '\0', "a refusal says why");
        return 0;
    }
    for (int c = 0; c < d->ncolumn; c++) {
        for (int i = 0; i < d->nrow; i++) {
            must(!d->column[c].present[i] || isfinite(d->column[c].value[i]), "samples are finite");
        }
    }
    for (int i = 1; i < d->nrow; i++) {
        must(d->time[i] > d->time[i - 1], "time goes on");
    }
    if (lab_audit_create(&audit, d, &err) == STEIN_OK) {
        must(lab_audit_text(audit, hear, &problems, &err) == STEIN_OK, "the audit can be told");
        lab_audit_destroy(audit);
    }
    lab_data_close(d);
    return 0;
}
