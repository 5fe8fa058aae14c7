/* SPDX-License-Identifier: GPL-3.0-or-later
 * compile.c - equations that are not built in: from the cache, or through the system's compiler.
 *
 *   CACHE/VERSION-abiN/stein/model.h            the header the equations include
 *   CACHE/VERSION-abiN/NAME-HASH.c, .so         one mechanism structure each
 *
 * The name holds everything the object depends on, so an entry never has to be updated. A file
 * found under it is checked all the same (layout and hash), and made again if it does not fit. Each
 * file is written under a unique name and renamed, so two processes that need the same equations at
 * the same time at worst both compile them.
 *
 * The text is compiled twice: once for as many lanes as this processor has (lanes.o) and once
 * without lanes, into one object. A compiler that cannot do the first leaves a mechanism without
 * lanes.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "open.h"
#include "model_header.h"
#include "stein/batch.h"
#include "stein/load.h"
#include "stein/models.h"

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
    return *folder != NULL ? STEIN_OK : lab__no_memory(err);
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
    return complete ? STEIN_OK : lab__no_memory(err);
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
    lab__first_error(j->log, line, (int)sizeof line);
    return lab__fail(err, STEIN_ECOMPILE, "%s failed on the equations of \"%s\" (exit code %d): %s",
                     cc, name, code, line);
}

/* First words of both compilations. Equations are straight lines of arithmetic: -O1 is enough. */
static void begin_command(lab__command *words, const job *j, const char *cc)
{
    lab__command_split(words, cc);
    lab__command_split(words,
                       "-std=c11 -O1 -ffp-contract=off -fno-tree-slp-vectorize -fno-math-errno "
                       "-fPIC");
    lab__command_add(words, lab__text("-I%s", j->folder));
}

/* lanes.o, for the processor that this runs on. @return how many lanes there are in it; 0: none,
 * it could not be made */
static int compile_lanes(const job *j, const char *cc)
{
    static const char *const instructions[] = {
        [2] = "", [4] = "-mavx2", [8] = "-mavx512f -mavx512dq -mavx512vl"};
    int lanes = 2, code = -1;
    for (int i = 0; stein_models[i] != NULL; i++) { // all there are: what a built-in one has
        int has = stein_batch_width(stein_models[i]);
        lanes = has > lanes ? has : lanes;
    }
    lab__command words = {0};
    begin_command(&words, j, cc);
    lab__command_split(&words, instructions[lanes]);
    lab__command_add(&words, lab__text("-DSTEIN_LANES=%d", lanes));
    lab__command_split(&words, "-c -o");
    lab__command_add(&words, lab__text("%s", j->lanes));
    lab__command_add(&words, lab__text("%s", j->source));
    return lab__command_run(&words, j->log, &code, NULL) == STEIN_OK && code == 0 ? lanes : 0;
}

/* the object into its place */
static stein_status make_object(const job *j, const char *name, const char *cc, stein_err *err)
{
    int code = 0, lanes = compile_lanes(j, cc);
    lab__command words = {0};
    begin_command(&words, j, cc);
    lab__command_split(&words, "-shared -o");
    lab__command_add(&words, lab__text("%s", j->fresh));
    lab__command_add(&words, lab__text("%s", j->source));
    if (lanes > 0) {
        lab__command_add(&words, lab__text("-DSTEIN_ONLY=%d", lanes));
        lab__command_add(&words, lab__text("%s", j->lanes));
    }
    lab__command_split(&words, "-lm");
    stein_status status = lab__command_run(&words, j->log, &code, err);
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
    stein_status status = complete ? make_object(j, name, cc, err) : lab__no_memory(err);
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
    if (cc[strspn(cc, " ")] == '\0') {
        return lab__fail(err, STEIN_ECOMPILE, "the compiler's name is empty: set CC to a compiler");
    }
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
