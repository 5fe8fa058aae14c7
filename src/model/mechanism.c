/* SPDX-License-Identifier: MIT
 * mechanism.c - reading a mechanism file from end to end, and looking things up in the result.
 *
 * Stages: bytes, tree, sections, numbers, checks. A stage that finds problems does not stop the
 * next one unless that would only repeat them: a file is judged as a whole in one run.
 */
#include "mechanism.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static stein_status problem(stein_err *err, stein_status code, const char *file, const char *what)
{
    if (err) {
        enum { SHOWN = 120 }; // of a long path, its end
        size_t n = strlen(file);
        int cut = n > SHOWN;

        err->code = code;
        snprintf(err->msg, sizeof err->msg, "%s%.*s: %.110s", cut ? "..." : "", SHOWN,
                 cut ? file + n - SHOWN : file, what);
        mech__one_line(err->msg);
    }
    return code;
}

/** A file that cannot be opened or read, with the system's reason (an errno). */
static stein_status no_file(stein_err *err, const char *file, const char *what, int cause)
{
    char text[MECH__WHY];

    if (*file == '\0') {
        return problem(err, STEIN_EIO, "\"\"", "the path of the mechanism file is empty");
    }
    snprintf(text, sizeof text, "the file cannot be %s: %s", what, strerror(cause));
    return problem(err, STEIN_EIO, file, text);
}

/** FNV-1a, 64 bits: identifies the input, no protection against intent. */
static void hash_text(const char *text, size_t size, char hash[17])
{
    uint64_t h = UINT64_C(14695981039346656037);

    for (size_t i = 0; i < size; i++) {
        h = (h ^ (unsigned char)text[i]) * UINT64_C(1099511628211);
    }
    for (int i = 15; i >= 0; i--, h >>= 4) {
        hash[i] = "0123456789abcdef"[h & 15];
    }
    hash[16] = '\0';
}

static void read_name(mech__reader *rd)
{
    const mech__node *node = mech__need(rd, rd->root, "mechanism", "the file");

    if (node && mech__text(rd, node, "mechanism")) {
        mech__name_check(rd, node, "a mechanism");
        mech__name_copy(rd->m->name, sizeof rd->m->name, node->text);
    }
}

static void read_sections(mech__reader *rd)
{
    mech__keys(
        rd, rd->root, "the file",
        "mechanism gravity parameters bodies points links loops couplings contacts notches load "
        "tables inputs outputs stroke simulation clock regulation inertia");
    read_name(rd);
    mech__read_inertia(rd);
    mech__section_parameters(rd);
    mech__section_bodies(rd);
    if (!rd->nomem) {
        mech__section_links(rd);
        mech__section_loops(rd);
        mech__section_contacts(rd);
        mech__section_tables(rd);
        mech__section_signals(rd);
    }
    if (!rd->nomem) {
        mech__resolve(rd);
    }
    if (!rd->nomem) {
        mech__contacts_finish(rd);
        mech__tables_finish(rd);
    }
    if (!rd->nomem) {
        mech__section_regulation(rd);
    }
    if (!rd->nomem) {
        mech__checks(rd);
    }
}

static mechanism *new_mechanism(const char *file, const char *text, size_t size)
{
    mechanism *m = calloc(1, sizeof *m);
    size_t n = strlen(file) + 1;

    if (!m) {
        return NULL;
    }
    m->file = malloc(n);
    if (!m->file) {
        free(m);
        return NULL;
    }
    memcpy(m->file, file, n);
    m->load_body = m->load_contact = -1;
    m->stroke_string = m->stroke_notch = -1;
    hash_text(text, size, m->input_hash);
    return m;
}

stein_status mech_read_text(mechanism **out, const char *name, const char *text, size_t size,
                            const mech_set *set, int nset, mech_report *report, void *ctx,
                            stein_err *err)
{
    mech__reader *rd = calloc(1, sizeof *rd);
    mechanism *m = new_mechanism(name, text, size);
    stein_status status = STEIN_OK;

    if (rd && m) {
        rd->file = m->file;
        rd->m = m;
        rd->set = set;
        rd->nset = nset;
        rd->set_used = mech__alloc(rd, nset > 0 ? (size_t)nset : 1);
        if (size > MECH__MAX_FILE) {
            mech__problem_at(rd, NULL, "the file is larger than 1 MiB");
        } else if (rd->set_used) {
            mech__tree(rd, text, size);
        }
        if (rd->root && !rd->nomem) {
            read_sections(rd);
        }
    }
    if (!rd || !m || rd->nomem) {
        status = problem(err, STEIN_ENOMEM, name, "out of memory");
    } else if (rd->nproblem > 0) {
        mech__problems_flush(rd, report, ctx, err);
        status = STEIN_EPARSE;
    } else if (report) {
        for (int i = 0; i < rd->nwarning; i++) {
            report(ctx, rd->warnings[i]);
        }
        mech__doubts(rd);
        mech__problems_flush(rd, report, ctx, NULL);
    }
    if (rd) {
        mech__arena_free(rd);
    }
    free(rd);
    if (status == STEIN_OK) {
        *out = m;
    } else {
        mech_free(m);
    }
    return status;
}

stein_status mech_read(mechanism **out, const char *file, const mech_set *set, int nset,
                       mech_report *report, void *ctx, stein_err *err)
{
    int saved = errno;
    FILE *f = fopen(file, "rb");
    int cause = errno;

    errno = saved;
    if (!f) {
        return no_file(err, file, "opened", cause);
    }

    /* one byte more than allowed detects a file that is too large */
    char *text = malloc(MECH__MAX_FILE + 1);
    size_t size = text ? fread(text, 1, MECH__MAX_FILE + 1, f) : 0;
    int bad = ferror(f);
    stein_status status;

    cause = errno; // of fread, when it failed
    fclose(f);
    errno = saved;
    if (!text) {
        status = problem(err, STEIN_ENOMEM, file, "out of memory");
    } else if (bad) {
        status = no_file(err, file, "read", cause);
    } else {
        status = mech_read_text(out, file, text, size, set, nset, report, ctx, err);
    }
    free(text);
    return status;
}

void mech_free(mechanism *m)
{
    if (!m) {
        return;
    }
    for (int i = 0; i < m->nformula; i++) {
        free(m->formulas[i].steps);
    }
    free(m->file);
    free(m->params);
    free(m->formulas);
    free(m->bodies);
    free(m->points);
    free(m->contacts);
    free(m->notches);
    free(m->links);
    for (int i = 0; i < m->ntable; i++) {
        free(m->tables[i].v);
    }
    free(m->tables);
    free(m->loops);
    free(m->inputs);
    free(m->channels);
    for (int i = 0; i < m->nabout; i++) {
        free(m->abouts[i].text);
    }
    free(m->abouts);
    free(m->dials);
    free(m);
}

int mech_find_param(const mechanism *m, const char *name, const char **suggestion)
{
    mech__nearest near = {name, NULL, 0};

    for (int i = 0; i < m->nparam; i++) {
        if (strcmp(m->params[i].name, name) == 0) {
            return i;
        }
        if (suggestion) {
            mech__offer(&near, m->params[i].name);
        }
    }
    if (suggestion) {
        *suggestion = near.best;
    }
    return -1;
}

double mech_value(const mechanism *m, mech_scalar s, const double *p)
{
    switch (s.kind) {
    case MECH_PARAM: return p[s.index];
    case MECH_FORMULA:
        return mech__evaluate(m->formulas[s.index].steps, m->formulas[s.index].nsteps, p);
    default: return 0.0;
    }
}
