/* SPDX-License-Identifier: GPL-3.0-or-later
 * resume.c - the state of a search on disk, so that kill -9 costs one iteration.
 *
 *      stein fit 4
 *      key 3f0c...                 fingerprint of model, data, unknowns, options
 *      stage 4 1                   present stage, finished starts
 *      state 3 0                   iteration, ended; then mu, nu, objective, decrement, x, steps,
 *                                  scale of the damping, entry
 *      start 17 1                  of every finished start; then its objective and x
 *      end 8c1f...                 checksum of all before
 *
 * Numbers are hexadecimal, so they are read back exactly, and an iteration depends on nothing else.
 * An interrupted fit ends with the same bits as an uninterrupted one. The file is written beside
 * its place and renamed. A journal with lines for every simulation would save the iteration too, at
 * a thousand times the size.
 */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fitting.h"

enum { FORMAT = 4 };

unsigned long long fit__key(const fit__problem *p)
{
    const stein_model *m = lab_equations(p->model);
    const lab_fit_def *d = p->def;
    unsigned long long h = STEIN_HASH;
    h = lab__hash(h, STEIN_VERSION, strlen(STEIN_VERSION));
    h = lab__hash(h, m->equations, strlen(m->equations));
    h = lab__hash(h, lab_parameters(p->model), sizeof(double) * (size_t)m->np);
    for (int i = 0; i < p->nstroke; i++) {
        h = lab__hash(h, &p->stroke[i].data->hash, sizeof p->stroke[i].data->hash);
    }
    for (int i = 0; i < p->nu; i++) {
        const fit__unknown *u = &p->unknown[i];
        int whole[] = {(int)u->kind, u->stroke, u->index, u->log, u->prior};
        h = lab__hash(h, whole, sizeof whole);
        h = lab__hash(h, &u->start, sizeof u->start);
        h = lab__hash(h, &u->sd, sizeof u->sd);
    }
    int options[] = {d->starts, d->robust, d->ladder, d->iterations};
    h = lab__hash(h, options, sizeof options);
    return h;
}

/* ---- writing ---- */

static void write_numbers(FILE *f, const double *x, int n)
{
    for (int i = 0; i < n; i++) {
        fprintf(f, "%" PRIx64 "%c",
                ((union {
                    double d;
                    uint64_t u;
                }){x[i]})
                    .u,
                i + 1 < n ? ' ' : '\n');
    }
}

static double *scalars(const fit__state *s, double *to)
{
    to[0] = s->mu;
    to[1] = s->nu;
    to[2] = s->objective;
    to[3] = s->decrement;
    return to;
}

static void write_search(FILE *f, const fit__search *s, int nu, unsigned long long key)
{
    double four[4];
    fprintf(f, "stein fit %d\nkey %016llx\nstage %d %d\nstate %d %d\n", (int)FORMAT, key, s->stage,
            s->nstart, s->state.iteration, s->state.ended);
    write_numbers(f, scalars(&s->state, four), 4);
    write_numbers(f, s->state.x, nu);
    write_numbers(f, s->state.step, nu);
    write_numbers(f, s->state.scale, nu);
    write_numbers(f, s->entry, nu);
    for (int i = 0; i < s->nstart; i++) {
        fprintf(f, "start %d %d\n", s->start[i].iterations, s->start[i].ended);
        write_numbers(f, &s->start[i].objective, 1);
        write_numbers(f, s->best[i], nu);
    }
}

stein_status fit__search_save(const fit__search *s, int nu, const char *path,
                              unsigned long long key, stein_err *err)
{
    lab__file file;
    char *text = NULL;
    FILE *f = lab__text_open(&text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_search(f, s, nu, key);
    stein_status status = lab__text_close(f, &text, err);
    status = status == STEIN_OK ? lab__file_open(&file, path, err) : status;
    if (status == STEIN_OK) {
        fprintf(file.stream, "%send %016llx\n", text, lab__hash(STEIN_HASH, text, strlen(text)));
        status = lab__file_close(&file, 1, err);
    }
    free(text);
    return status;
}

/* ---- reading ---- */

static int read_numbers(FILE *f, double *x, int n)
{
    for (int i = 0; i < n; i++) {
        uint64_t u;
        if (fscanf(f, "%" SCNx64, &u) != 1) {
            return -1;
        }
        x[i] = ((union {
                   uint64_t u;
                   double d;
               }){u})
                   .d;
    }
    return 0;
}

static int read_body(fit__search *s, int nu, FILE *f)
{
    double four[4];
    if (fscanf(f, " stage %d %d state %d %d", &s->stage, &s->nstart, &s->state.iteration,
               &s->state.ended) != 4 ||
        s->nstart < 0 || s->nstart > LAB_FIT_STARTS || read_numbers(f, four, 4) != 0 ||
        read_numbers(f, s->state.x, nu) != 0 || read_numbers(f, s->state.step, nu) != 0 ||
        read_numbers(f, s->state.scale, nu) != 0 || read_numbers(f, s->entry, nu) != 0) {
        return -1;
    }
    s->state.mu = four[0];
    s->state.nu = four[1];
    s->state.objective = four[2];
    s->state.decrement = four[3];
    for (int i = 0; i < s->nstart; i++) {
        if (fscanf(f, " start %d %d", &s->start[i].iterations, &s->start[i].ended) != 2 ||
            read_numbers(f, &s->start[i].objective, 1) != 0 ||
            read_numbers(f, s->best[i], nu) != 0) {
            return -1;
        }
    }
    return 0;
}

/* the last line has the checksum of what is before it */
static int is_whole(const char *text, size_t size)
{
    enum { LAST = 21 }; /* "end 0123456789abcdef\n" */
    char end[LAST + 1];
    if (size < LAST) {
        return 0;
    }
    snprintf(end, sizeof end, "end %016llx\n", lab__hash(STEIN_HASH, text, size - LAST));
    return memcmp(text + size - LAST, end, LAST) == 0;
}

static stein_status load(fit__search *s, int nu, const char *path, unsigned long long key, FILE *f,
                         int whole, stein_err *err)
{
    unsigned long long theirs = 0;
    int format = 0;
    if (fscanf(f, "stein fit %d key %llx", &format, &theirs) < 1) {
        return lab__fail(err, STEIN_EPARSE, "%s is no journal of a fit", path);
    }
    if (format != FORMAT) {
        return lab__fail(err, STEIN_ESTALE,
                         "%s is a journal of format %d, this version reads %d: begin anew", path,
                         format, (int)FORMAT);
    }
    if (!whole) {
        return lab__fail(err, STEIN_EPARSE, "%s: the journal is damaged", path);
    }
    if (theirs != key) {
        return lab__fail(err, STEIN_ESTALE,
                         "%s belongs to another fit: other data, free "
                         "parameters, options or numbers of the mechanism",
                         path);
    }
    return read_body(s, nu, f) == 0
               ? STEIN_OK
               : lab__fail(err, STEIN_EPARSE, "%s: the journal is damaged", path);
}

stein_status fit__search_load(fit__search *s, int nu, const char *path, unsigned long long key,
                              int *found, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    *found = 0;
    if (access(path, F_OK) != 0) {
        return STEIN_OK; // a new one; whether it can be written is found out soon
    }
    stein_status status = lab__read_file(path, &text, &size, err);
    FILE *f = status == STEIN_OK && size > 0 ? fmemopen(text, size, "r") : NULL;
    if (status == STEIN_OK && f == NULL) {
        status = size == 0 ? lab__fail(err, STEIN_EPARSE, "%s is no journal of a fit", path)
                           : lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        status = load(s, nu, path, key, f, is_whole(text, size), err);
    }
    if (f != NULL) {
        fclose(f);
    }
    free(text);
    *found = status == STEIN_OK;
    return status;
}
