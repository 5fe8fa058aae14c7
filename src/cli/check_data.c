/* SPDX-License-Identifier: GPL-3.0-or-later
 * check_data.c - stein check MODEL DATA...: audit of records, and suspicions that they are misread.
 * Nothing is fitted.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/data.h"

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_dataset *data;
    lab_audit **audit; /* [data->n] */
    lab_doubts *doubts;
    cli_progress progress;
} job;

static void on_report(void *ctx, const char *message)
{
    (void)ctx;
    fprintf(stderr, "%s\n", message);
}

static stein_status read_data(job *j, stein_err *err)
{
    lab_data_options options = lab_data_options_default(lab_equations(j->model));
    options.report = on_report;
    options.progress = cli_progress_read;
    options.ctx = &j->progress;
    cli_progress_begin(&j->progress, "reading");
    stein_status status =
        lab_dataset_open(&j->data, j->args->operand + 1, j->args->noperand - 1, &options, err);
    cli_progress_end(&j->progress);
    if (status == STEIN_EPARSE || status == STEIN_EIO) {
        err->msg[0] = '\0'; // told one by one
    }
    return status;
}

static stein_status look(job *j, stein_err *err)
{
    stein_status status = read_data(j, err);
    if (status != STEIN_OK) {
        return status;
    }
    j->audit = calloc((size_t)j->data->n, sizeof(lab_audit *));
    if (j->audit == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < j->data->n; i++) {
        status = lab_audit_create(&j->audit[i], j->data->stroke[i], err);
    }
    status = status == STEIN_OK ? lab_doubts_find(&j->doubts, j->model, j->data, err) : status;
    if (status == STEIN_OK) {
        status = lab_data_check_settings(j->data, j->model, on_report, NULL, err);
        if (status == STEIN_EPARSE) {
            err->msg[0] = '\0'; // told one by one
        }
    }
    return status;
}

/* ---- results ---- */

/* the lines of one audit */
typedef struct lines {
    const job *j;
    int record;
} lines;

/* a finding of several records is printed once, below the first of them */
static void put_line(void *ctx, const char *line)
{
    static const char mark[] = "  ! ";
    const lines *l = ctx;
    const char *text = strncmp(line, mark, strlen(mark)) == 0 ? line + strlen(mark) : NULL;
    int more = text != NULL ? lab_audit_repeats(l->j->audit, l->j->data->n, l->record, text) : 0;
    if (more > 0) {
        printf("%s (and in %d record%s more)\n", line, more, more == 1 ? "" : "s");
    } else if (more == 0) {
        printf("%s\n", line);
    }
}

static stein_status print_text(const job *j, stein_err *err)
{
    stein_status status = STEIN_OK;
    printf("\ndata (%d record%s)\n", j->data->n, j->data->n == 1 ? "" : "s");
    for (int i = 0; status == STEIN_OK && i < j->data->n; i++) {
        lines l = {j, i};
        status = lab_audit_text(j->audit[i], put_line, &l, err);
    }
    printf("\nsuspicions (%d)\n", j->doubts->n);
    for (int i = 0; i < j->doubts->n; i++) {
        printf("  %s%s\n", j->doubts->item[i].grave ? "! " : "", j->doubts->item[i].text);
    }
    return status;
}

static void print_json(const job *j, lab__json *out)
{
    static const char *const kind[] = {"scale", "sign", "swapped", "time", "foreign"};
    lab__json_open(out, "data", '[');
    for (int i = 0; i < j->data->n; i++) {
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "file", j->data->stroke[i]->file);
        lab__json_int(out, "rows", j->data->stroke[i]->nrow);
        lab__json_open(out, "findings", '[');
        for (int k = 0; k < j->audit[i]->nfinding; k++) {
            lab__json_text(out, NULL, j->audit[i]->finding[k]);
        }
        lab__json_close(out);
        lab__json_close(out);
    }
    lab__json_close(out);
    lab__json_open(out, "suspicions", '[');
    for (int i = 0; i < j->doubts->n; i++) {
        const lab_doubt *d = &j->doubts->item[i];
        lab__json_open(out, NULL, '{');
        lab__json_text(out, "kind", kind[d->kind]);
        lab__json_text(out, "file", j->data->stroke[d->stroke]->file);
        lab__json_bool(out, "grave", d->grave);
        lab__json_real(out, "factor", d->factor);
        lab__json_text(out, "text", d->text);
        lab__json_close(out);
    }
    lab__json_close(out);
}

int cli_check_data(const cli_args *args, lab__json *out)
{
    job j = {.args = args};
    stein_err err = {STEIN_OK, ""};
    stein_status status = cli_open(&j.model, args, &err);
    status = status == STEIN_OK ? look(&j, &err) : status;
    if (j.doubts != NULL && out != NULL) {
        print_json(&j, out);
    } else if (j.doubts != NULL) {
        stein_status printed = print_text(&j, &err);
        status = status == STEIN_OK ? printed : status;
    }
    int grave = j.doubts != NULL && j.doubts->grave;
    for (int i = 0; j.audit != NULL && i < j.data->n; i++) {
        lab_audit_destroy(j.audit[i]);
    }
    free(j.audit);
    lab_doubts_free(j.doubts);
    lab_dataset_close(j.data);
    lab_close(j.model);
    return status != STEIN_OK ? cli_failed(status, &err) : grave ? CLI_FAILED : CLI_OK;
}
