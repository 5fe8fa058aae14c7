/* SPDX-License-Identifier: GPL-3.0-or-later
 * record.c - results that are kept: a CSV table of all draws that were ever counted, one row each.
 *
 * 200 draws a level take hours: a run may be interrupted and continued on another machine, and
 * every draw behind the tables of docs/validation.md is listed. Rows of the seed that is asked for
 * become score files at the start of a run and are written back at its end; rows of other seeds
 * stay.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "hidden.h"

enum { LINE = 8192 };

static int is_of_run(const setup *s, const score *r)
{
    return (unsigned long)r->seed / SEEDS_A_RUN == s->seed;
}

static int keep_here(const setup *s, const score *r)
{
    char set[PATH], answer[PATH], out[PATH], scored[PATH];
    draw_paths(s, r->level, r->draw, set, answer, out, scored);
    return access(scored, R_OK) == 0 ? 0 : score_write(scored, r);
}

/* every row of the record. @return 0, -1 after a message */
static int each_row(const setup *s, int (*take)(const setup *s, const score *r, void *ctx),
                    void *ctx)
{
    char head[LINE], row[LINE];
    score r;
    int status = 0;
    FILE *f = fopen(s->record, "r");
    if (f == NULL) {
        if (errno == ENOENT) {
            return 0;
        }
        perror(s->record);
        return -1;
    }
    status = fgets(head, LINE, f) != NULL ? 0 : -1;
    for (int line = 2; status == 0 && fgets(row, LINE, f) != NULL; line++) {
        if (score_of_row(head, row, &r) != 0) {
            fprintf(stderr, "hidden: %s:%d: the row has not what the first line says\n", s->record,
                    line);
            status = -1;
        } else {
            status = take(s, &r, ctx);
        }
    }
    fclose(f);
    return status;
}

static int take_back(const setup *s, const score *r, void *ctx)
{
    (void)ctx;
    return is_of_run(s, r) ? keep_here(s, r) : 0;
}

int record_read(const setup *s)
{
    if (s->record == NULL || access(s->record, F_OK) != 0) {
        return 0;
    }
    return process_folder(s->results) == 0 ? each_row(s, take_back, NULL) : -1;
}

/* rows of other seeds stay, and rows of this run outside of its levels and draws */
static int copy_rest(const setup *s, const score *r, void *ctx)
{
    int asked = 0;
    for (int k = 0; k < s->nlevel; k++) {
        asked |= strcmp(s->level[k], r->level) == 0 && r->draw <= s->draws;
    }
    if (!is_of_run(s, r) || !asked) {
        score_row(ctx, r);
    }
    return 0;
}

int record_write(const setup *s)
{
    char part[PATH + 8], set[PATH], answer[PATH], out[PATH], scored[PATH];
    if (s->record == NULL) {
        return 0;
    }
    snprintf(part, sizeof part, "%s.part", s->record);
    FILE *f = fopen(part, "w");
    if (f == NULL) {
        perror(part);
        return -1;
    }
    score_head(f);
    int status = each_row(s, copy_rest, f);
    for (int k = 0; k < s->nlevel; k++) {
        for (int i = 1; i <= s->draws; i++) {
            score r;
            draw_paths(s, s->level[k], i, set, answer, out, scored);
            if (score_read(scored, &r) == 0) {
                score_row(f, &r);
            }
        }
    }
    if (fclose(f) != 0 || status != 0 || rename(part, s->record) != 0) {
        perror(s->record);
        return -1;
    }
    return 0;
}
