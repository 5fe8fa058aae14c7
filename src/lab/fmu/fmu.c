/* SPDX-License-Identifier: GPL-3.0-or-later
 * fmu.c - a mechanism as a co-simulation FMU.
 *
 *      modelDescription.xml
 *      binaries/PLATFORM/NAME.so, NAME.dll     one for each compiler
 *      documentation/licenses/license.txt
 *      sources/                buildDescription.xml, all of the C, the headers in stein/
 *
 * A token shows that description and binary belong together: a hash of all the text that
 * both are made of. So the same mechanism gives the same token, and the same bytes.
 */
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

enum { TOKEN = 40 };

/* contents of an archive */
typedef struct parts {
    fmu_list list;
    fmu_sources sources;
    char token[TOKEN];
    char *description, *build;
    fmu_binary binary[FMU_BINARIES];
    int nbinary;
} parts;

static void free_parts(parts *p)
{
    fmu__list_free(&p->list);
    fmu__sources_free(&p->sources);
    free(p->description);
    free(p->build);
    for (int i = 0; i < p->nbinary; i++) {
        free(p->binary[i].bytes);
    }
}

/* in the form of a GUID */
static void write_token(char token[TOKEN], const parts *p)
{
    unsigned long long h[2];
    for (int k = 0; k < 2; k++) {
        h[k] = fmu__hash(0xcbf29ce484222325u + (unsigned)k, p->description);
        for (int i = 0; i < p->sources.n; i++) {
            h[k] = fmu__hash(fmu__hash(h[k], p->sources.name[i]), p->sources.text[i]);
        }
    }
    snprintf(token, TOKEN, "{%08llx-%04llx-%04llx-%04llx-%012llx}", h[0] >> 32,
             h[0] >> 16 & 0xffffu, h[0] & 0xffffu, h[1] >> 48, h[1] & 0xffffffffffffu);
}

/* version 0: the build description */
static stein_status describe(char **text, const parts *p, int version, stein_err *err)
{
    free(*text);
    FILE *f = lab__text_open(text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    if (version == 0) {
        fmu__describe_build(f, &p->list, p->sources.compiled);
    } else {
        fmu__describe(f, version, &p->list, p->token, p->sources.compiled);
    }
    return lab__text_close(f, text, err);
}

/* all texts: once without a token, to find it, and once with it */
static stein_status write_texts(parts *p, int version, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int pass = 0; status == STEIN_OK && pass < 2; pass++) {
        fmu__sources_free(&p->sources);
        status = fmu__sources_create(&p->sources, &p->list, version, p->token, err);
        status = status == STEIN_OK ? describe(&p->description, p, version, err) : status;
        if (status == STEIN_OK && pass == 0) {
            write_token(p->token, p);
        }
    }
    return status == STEIN_OK ? describe(&p->build, p, 0, err) : status;
}

static void add_text(fmu_zip *zip, const char *name, const char *text)
{
    fmu__zip_add(zip, name, text, text != NULL ? strlen(text) : 0);
}

/* name: taken over */
static void add_named(fmu_zip *zip, char *name, const void *bytes, size_t size)
{
    fmu__zip_add(zip, name, bytes, size);
    free(name);
}

static void add_licence(fmu_zip *zip)
{
    for (const lab__source *f = lab__fmu_files; f->name != NULL; f++) {
        size_t n = strlen(f->name);
        if (n > 4 && strcmp(f->name + n - 4, ".txt") == 0) {
            char *text = fmu__joined(f->lines);
            add_text(zip, "documentation/licenses/license.txt", text);
            free(text);
        }
    }
}

static stein_status write_archive(const char *path, const parts *p, size_t *bytes, stein_err *err)
{
    fmu_zip *zip = NULL;
    stein_status status = fmu__zip_create(&zip, err);
    if (status != STEIN_OK) {
        return status;
    }
    add_text(zip, "modelDescription.xml", p->description);
    for (int i = 0; i < p->nbinary; i++) {
        const fmu_binary *b = &p->binary[i];
        add_named(zip, lab__text("binaries/%s/%s.%s", b->platform, p->list.m->name, b->ending),
                  b->bytes, b->size);
    }
    add_licence(zip);
    add_text(zip, "sources/buildDescription.xml", p->build);
    for (int i = 0; i < p->sources.n; i++) {
        add_named(zip, lab__text("sources/%s", p->sources.name[i]), p->sources.text[i],
                  strlen(p->sources.text[i]));
    }
    status = fmu__zip_write(zip, path, bytes, err);
    fmu__zip_destroy(zip);
    return status;
}

/* each for another machine */
static stein_status compile(parts *p, int version, const char *const *cc, int ncc,
                            const lab_options *options, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < ncc; i++) {
        fmu_binary *b = &p->binary[i];
        status = fmu__binary(b, &p->sources, version, cc[i], options, err);
        p->nbinary += status == STEIN_OK;
        for (int k = 0; status == STEIN_OK && k < i; k++) {
            if (strcmp(p->binary[k].platform, b->platform) == 0) {
                status = lab__fail(err, STEIN_EINVAL, "%s and %s both compile for %s", cc[k], cc[i],
                                   b->platform);
            }
        }
    }
    return status;
}

/* with a point in numbers, whatever the host's locale */
static stein_status make(const char *path, parts *p, const lab_model *model, int version,
                         const char *const *cc, int ncc, const lab_options *options, size_t *bytes,
                         stein_err *err)
{
    stein_status status = fmu__list_create(&p->list, model, err);
    status = status == STEIN_OK ? write_texts(p, version, err) : status;
    status = status == STEIN_OK ? compile(p, version, cc, ncc, options, err) : status;
    return status == STEIN_OK ? write_archive(path, p, bytes, err) : status;
}

static void tell(lab_fmu_facts *facts, const parts *p, size_t bytes)
{
    *facts = (lab_fmu_facts){.bytes = bytes, .variables = p->list.n};
    memcpy(facts->token, p->token, TOKEN);
    for (int i = 0; i < p->nbinary; i++) {
        size_t n = strlen(facts->platform);
        facts->binary += p->binary[i].size;
        snprintf(facts->platform + n, sizeof facts->platform - n, "%s%s", n > 0 ? " " : "",
                 p->binary[i].platform);
    }
}

stein_status lab_fmu_for(const char *path, const lab_model *model, int version,
                         const char *const *cc, int ncc, const lab_options *options,
                         lab_fmu_facts *facts, stein_err *err)
{
    lab_options defaults = lab_options_default();
    parts p = {.token = ""};
    size_t bytes = 0;
    if (version != 2 && version != 3) {
        return lab__fail(err, STEIN_EINVAL, "FMI %d: expected 2 or 3", version);
    }
    if (lab_equations(model)->nball > 0) {
        return lab__fail(
            err, STEIN_EINVAL,
            "no FMU of \"%s\": it has a body that turns in all directions, with coordinates that "
            "are changed during the motion; an importer of an FMU cannot do that",
            lab_equations(model)->name);
    }
    if (ncc < 1 || ncc > FMU_BINARIES) {
        return lab__fail(err, STEIN_EINVAL, "an FMU for %d machines: expected 1 to %d", ncc,
                         (int)FMU_BINARIES);
    }
    locale_t before = lab__locale_c();
    stein_status status =
        make(path, &p, model, version, cc, ncc, options != NULL ? options : &defaults, &bytes, err);
    lab__locale_restore(before);
    if (status == STEIN_OK && facts != NULL) {
        tell(facts, &p, bytes);
    }
    free_parts(&p);
    return status;
}

stein_status lab_fmu(const char *path, const lab_model *model, int version,
                     const lab_options *options, lab_fmu_facts *facts, stein_err *err)
{
    const char *cc = options != NULL && options->cc != NULL ? options->cc : getenv("CC");
    cc = cc != NULL && *cc != '\0' ? cc : "cc";
    return lab_fmu_for(path, model, version, &cc, 1, options, facts, err);
}
