/* SPDX-License-Identifier: GPL-3.0-or-later
 * page.c - a mechanism as one self-contained HTML file.
 *
 * src/page/page.html is the page with four lines that stand for what is put in their place:
 *
 *      @style@   page.css        @model@    describe.c's JSON
 *      @script@  the scripts     @module@   the WebAssembly module, base64
 */
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "page.h"

/* in this order: a later one uses the earlier */
static const char *const scripts[] = {
    "format.js", "words.js",  "address.js", "engine.js", "geometry.js", "brush.js",
    "scene.js",  "traces.js", "strokes.js", "replay.js", "measured.js", "preview.js",
    "slider.js", "tour.js",   "sound.js",   "texts.js",  "main.js"};
enum { SCRIPTS = sizeof scripts / sizeof *scripts };

static const char *const *lines_of(const char *name)
{
    for (const lab__source *f = lab__page_files; f->name != NULL; f++) {
        const char *slash = strrchr(f->name, '/');
        if (strcmp(slash != NULL ? slash + 1 : f->name, name) == 0) {
            return f->lines;
        }
    }
    return NULL;
}

/* without indents and lines of remarks: they are in the source, and a page is sent */
static void put_lines(FILE *to, const char *name)
{
    const char *const *lines = lines_of(name);
    for (int i = 0; lines != NULL && lines[i] != NULL; i++) {
        const char *text = lines[i] + strspn(lines[i], " ");
        if (strncmp(text, "//", 2) != 0) {
            fputs(text, to);
        }
    }
}

static void put_base64(FILE *to, const char *bytes, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *b = (const unsigned char *)bytes;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        unsigned v = (unsigned)b[i] << 16 | (left > 1 ? (unsigned)b[i + 1] << 8 : 0u) |
                     (left > 2 ? (unsigned)b[i + 2] : 0u);
        putc(digit[v >> 18], to);
        putc(digit[v >> 12 & 63u], to);
        putc(left > 1 ? digit[v >> 6 & 63u] : '=', to);
        putc(left > 2 ? digit[v & 63u] : '=', to);
    }
    putc('\n', to);
}

/* JSON in a script element: a text of the file must not end it; without its indents */
static void put_model(FILE *to, const char *json)
{
    for (const char *c = json; *c != '\0'; c++) {
        if (*c == '<') {
            fputs("\\u003c", to);
        } else if (*c == '\n') {
            c += strspn(c + 1, " ");
        } else {
            putc(*c, to);
        }
    }
    putc('\n', to);
}

/* Data at the time of writing. */
typedef struct content {
    const char *json, *module;
    size_t module_size;
} content;

static void put_page(FILE *to, const content *c)
{
    const char *const *lines = lines_of("page.html");
    for (int i = 0; lines[i] != NULL; i++) {
        if (strcmp(lines[i], "@style@\n") == 0) {
            put_lines(to, "page.css");
        } else if (strcmp(lines[i], "@script@\n") == 0) {
            for (int k = 0; k < SCRIPTS; k++) {
                put_lines(to, scripts[k]);
            }
        } else if (strcmp(lines[i], "@model@\n") == 0) {
            put_model(to, c->json);
        } else if (strcmp(lines[i], "@module@\n") == 0) {
            put_base64(to, c->module, c->module_size);
        } else {
            fputs(lines[i], to);
        }
    }
}

/* the file's own run, natively: reference for the page's own result */
static stein_status hash_run(const lab_model *model, char hash[LAB_HASH], stein_err *err)
{
    stein_sim *sim = NULL;
    stein_status status = lab_sim(model, NULL, &sim, err);
    if (status == STEIN_OK) {
        status = stein_run(sim, lab_until(model), err);
    }
    size_t size = status == STEIN_OK ? stein_state_size(sim) : 0;
    unsigned char *state = malloc(size + 1);
    if (status == STEIN_OK && state == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        stein_save(sim, state);
        snprintf(hash, LAB_HASH, "%016llx", lab__hash(STEIN_HASH, state, size));
    }
    free(state);
    stein_sim_destroy(sim);
    return status;
}

static stein_status describe(char **json, const lab_model *model, const char *hash, stein_err *err)
{
    FILE *stream = lab__text_open(json);
    if (stream == NULL) {
        return lab__no_memory(err);
    }
    page__describe(stream, model, hash);
    return lab__text_close(stream, json, err);
}

static stein_status write_page(const char *path, const content *c, size_t *bytes, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    put_page(file.stream, c);
    long size = ftell(file.stream); // -1 where there is no place: a pipe
    *bytes = size > 0 ? (size_t)size : 0;
    return lab__file_close(&file, 1, err);
}

stein_status lab_page(const char *path, const lab_model *model, const lab_options *options,
                      lab_page_facts *facts, stein_err *err)
{
    lab_options defaults = lab_options_default();
    options = options != NULL ? options : &defaults;
    char *json = NULL, *module = NULL;
    content c = {NULL, NULL, 0};
    lab_page_facts made = {0, 0, ""};
    if (stein__in_space(lab_equations(model))) {
        return lab__fail(err, STEIN_EINVAL,
                         "no page of \"%s\": it moves in space, and a page shows the x-z plane",
                         lab_equations(model)->name);
    }
    stein_status status = page__module(&module, &made.module, model, options, err);
    if (status == STEIN_OK) {
        status = hash_run(model, made.hash, err);
    }
    if (status == STEIN_OK) {
        status = describe(&json, model, made.hash, err);
    }
    if (status == STEIN_OK) {
        c = (content){json, module, made.module};
        status = write_page(path, &c, &made.page, err);
    }
    if (status == STEIN_OK && facts != NULL) {
        *facts = made;
    }
    free(json);
    free(module);
    return status;
}
