/* SPDX-License-Identifier: GPL-3.0-or-later
 * compile.c - equations that are not built in: from the cache, or through the system's compiler.
 *
 *   CACHE/VERSION-abiN/stein/model.h            the header the equations include
 *   CACHE/VERSION-abiN/NAME-HASH.c, .so         one mechanism structure each
 *
 * The name holds everything the object depends on, so an entry never has to be updated; what is
 * found under it is nevertheless checked (layout and hash) and made anew when it does not fit. Each
 * file is written under a name of its own and renamed, so two processes that need the same
 * equations at the same time at worst both do the work.
 *
 * The text is compiled twice: once for as many lanes as this processor has (lanes.o) and once as it
 * is, into one object. A compiler that cannot do the first leaves a mechanism without lanes.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "inner.h"
#include "model_header.h"
#include "stein/batch.h"
#include "stein/load.h"
#include "stein/models.h"

enum { MAX_COMPILER_WORDS = 16, FIXED_WORDS = 17 };

/* names of one compilation, all owned */
typedef struct job {
    char *folder, *include, *header, *source, *object; /* in the cache */
    char *work, *fresh, *lanes, *log;                  /* of this process alone */
} job;

static void free_job(job *j)
{
    free(j->folder);
    free(j->include);
    free(j->header);
    free(j->source);
    free(j->object);
    free(j->work);
    free(j->fresh);
    free(j->lanes);
    free(j->log);
}

/* root of the cache, or NULL when the environment names none */
static char *cache_root(const lab_options *options)
{
    const char *xdg = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (options->cache != NULL) {
        return lab__text("%s", options->cache);
    }
    if (xdg != NULL && *xdg == '/') { // the XDG specification ignores relative ones
        return lab__text("%s/stein", xdg);
    }
    return home != NULL && *home != '\0' ? lab__text("%s/.cache/stein", home) : NULL;
}

stein_status lab__cache(char **folder, const lab_options *options, stein_err *err)
{
    char *root = cache_root(options);
    if (root == NULL) {
        return lab__fail(err, STEIN_EIO,
                         "no folder for compiled equations: set XDG_CACHE_HOME or HOME");
    }
    *folder = lab__text("%s%s/%s-abi%d", strchr(root, '/') == NULL ? "./" : "", root, STEIN_VERSION,
                        STEIN_MODEL_ABI);
    free(root);
    return *folder != NULL ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
}

static stein_status name_files(job *j, const mechanism *m, const gen_result *equations,
                               const lab_options *options, stein_err *err)
{
    stein_status status = lab__cache(&j->folder, options, err);
    if (status != STEIN_OK) {
        return status;
    }
    const char *folder = j->folder;
    char *stem = lab__text("%s/%s-%s", folder, m->name, equations->equations);
    const char *base = stem != NULL ? stem : "";
    j->include = lab__text("%s/stein", folder);
    j->header = lab__text("%s/stein/model.h", folder);
    j->source = lab__text("%s.c", base);
    j->object = lab__text("%s.so", base);
    j->work = lab__text("%s/work-XXXXXX", folder);
    int complete = stem != NULL && j->include != NULL && j->header != NULL && j->source != NULL &&
                   j->object != NULL && j->work != NULL;
    free(stem);
    return complete ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
}

stein_status lab__write_lines(const char *path, const char *const *lines, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (int i = 0; lines[i] != NULL; i++) {
        fputs(lines[i], file.stream);
    }
    return lab__file_close(&file, 1, err);
}

void lab__complaint(const char *log, char *text, int size)
{
    FILE *f = fopen(log, "r");
    strcpy(text, "");
    while (f != NULL && strstr(text, "error") == NULL && fgets(text, size, f) != NULL) {
    }
    if (f != NULL) {
        fclose(f);
    }
    text[strcspn(text, "\n")] = '\0';
}

static stein_status complain(const job *j, const char *name, const char *cc, int code,
                             stein_err *err)
{
    char line[160];
    if (code == 127) {
        return lab__fail(err, STEIN_ECOMPILE,
                         "no C compiler \"%s\" to compile the equations of "
                         "\"%s\": run apt-get install gcc, or set CC (the C file is %s)",
                         cc, name, j->source);
    }
    lab__complaint(j->log, line, (int)sizeof line);
    return lab__fail(err, STEIN_ECOMPILE, "%s failed on the equations of \"%s\" (exit code %d): %s",
                     cc, name, code, line);
}

/* cc and `rest` (closed by NULL); the compiler may bring words of its own ("ccache gcc") */
static stein_status run_compiler(const job *j, const char *cc, const char *const *rest, int *code,
                                 stein_err *err)
{
    char *words = lab__text("%s", cc), *left = NULL;
    if (words == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    char *argv[MAX_COMPILER_WORDS + FIXED_WORDS];
    int n = 0;
    for (char *w = strtok_r(words, " ", &left); w != NULL && n < MAX_COMPILER_WORDS;
         w = strtok_r(NULL, " ", &left)) {
        argv[n++] = w;
    }
    int named = n > 0;
    for (int i = 0; i < FIXED_WORDS; i++) {
        argv[n++] = (char *)(size_t)rest[i];
        if (rest[i] == NULL) {
            break;
        }
    }
    stein_status status = named ? lab__spawn(argv, j->log, code, err)
                                : lab__fail(err, STEIN_ECOMPILE, "the compiler's name is empty");
    free(words);
    return status;
}

/* lanes.o, for the processor that this runs on. @return what to tell the other compilation */
static const char *compile_lanes(const job *j, const char *cc, const char *include)
{
    int lanes = stein_batch_width(stein_models[0]), code = -1; // of a built-in one: all there are
    const char *const of_lanes = lanes == 8   ? "-DSTEIN_LANES=8"
                                 : lanes == 4 ? "-DSTEIN_LANES=4"
                                              : "-DSTEIN_LANES=2";
    const char *rest[FIXED_WORDS] = {"-std=c11",
                                     "-O2",
                                     "-ffp-contract=off",
                                     "-fno-tree-slp-vectorize",
                                     "-fno-math-errno",
                                     "-fPIC",
                                     "-c",
                                     include,
                                     of_lanes,
                                     "-o",
                                     j->lanes,
                                     j->source};
    if (lanes == 8) {
        rest[12] = "-mavx512f";
        rest[13] = "-mavx512dq";
        rest[14] = "-mavx512vl";
    } else if (lanes == 4) {
        rest[12] = "-mavx2";
    }
    if (run_compiler(j, cc, rest, &code, NULL) != STEIN_OK || code != 0) {
        return NULL;
    }
    return lanes == 8 ? "-DSTEIN_ONLY=8" : lanes == 4 ? "-DSTEIN_ONLY=4" : "-DSTEIN_ONLY=2";
}

/* the object into its place */
static stein_status make_object(const job *j, const char *name, const char *cc, stein_err *err)
{
    char *include = lab__text("-I%s", j->folder);
    if (include == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    int code = 0;
    const char *with_lanes = compile_lanes(j, cc, include);
    const char *rest[FIXED_WORDS] = {"-std=c11",
                                     "-O2",
                                     "-ffp-contract=off",
                                     "-fno-tree-slp-vectorize",
                                     "-fno-math-errno",
                                     "-fPIC",
                                     "-shared",
                                     include,
                                     "-o",
                                     j->fresh,
                                     j->source,
                                     "-lm"};
    if (with_lanes != NULL) {
        rest[12] = with_lanes;
        rest[13] = j->lanes;
    }
    stein_status status = run_compiler(j, cc, rest, &code, err);
    free(include);
    if (status == STEIN_OK && code != 0) {
        status = complain(j, name, cc, code, err);
    }
    if (status == STEIN_OK && rename(j->fresh, j->object) != 0) {
        status = lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->object, strerror(errno));
    }
    return status;
}

/* the same in a folder of our own */
static stein_status compile_apart(job *j, const char *name, const char *cc, stein_err *err)
{
    if (mkdtemp(j->work) == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->folder, strerror(errno));
    }
    j->fresh = lab__text("%s/equations.so", j->work);
    j->lanes = lab__text("%s/lanes.o", j->work);
    j->log = lab__text("%s/log", j->work);
    int complete = j->fresh != NULL && j->lanes != NULL && j->log != NULL;
    stein_status status =
        complete ? make_object(j, name, cc, err) : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (complete) {
        unlink(j->fresh);
        unlink(j->lanes);
        unlink(j->log);
    }
    rmdir(j->work);
    return status;
}

static stein_status compile(job *j, const mechanism *m, const gen_result *equations,
                            const lab_options *options, stein_err *err)
{
    const char *source[] = {equations->source, NULL};
    const char *cc = options->cc != NULL ? options->cc : getenv("CC");
    cc = cc != NULL && *cc != '\0' ? cc : "cc";
    stein_status status = lab__folder(j->include, err);
    if (status == STEIN_OK) {
        status = lab__write_lines(j->header, lab__model_header, err);
    }
    if (status == STEIN_OK) {
        status = lab__write_lines(j->source, source, err);
    }
    return status == STEIN_OK ? compile_apart(j, m->name, cc, err) : status;
}

stein_status lab__compiled(stein_library **library, const stein_model **model, const mechanism *m,
                           const gen_result *equations, const lab_options *options, stein_err *err)
{
    job j = {0};
    stein_status status = name_files(&j, m, equations, options, err);
    if (status != STEIN_OK) {
        free_job(&j);
        return status;
    }
    status = STEIN_ELOAD;
    if (access(j.object, R_OK) == 0) {
        status = stein_library_open(library, j.object, m->name, equations->equations, model, err);
    }
    if (status == STEIN_ELOAD || status == STEIN_ESTALE) {
        status = compile(&j, m, equations, options, err);
        if (status == STEIN_OK) {
            status =
                stein_library_open(library, j.object, m->name, equations->equations, model, err);
        }
    }
    free_job(&j);
    return status;
}
