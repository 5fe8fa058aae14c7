/* SPDX-License-Identifier: GPL-3.0-or-later
 * wasm.c - core and equations as one WebAssembly module, by clang, wasm-ld and wasi-libc.
 *
 *   CACHE/VERSION-abiN/page-SOURCES/src/..., include/...    the sources, as this program has them
 *   CACHE/VERSION-abiN/page-SOURCES/core.o                  the core, once for all mechanisms
 *   CACHE/VERSION-abiN/page-SOURCES/NAME-HASH.wasm          one mechanism structure each
 *
 * SOURCES is a hash of all the text that is compiled, so an entry never has to be updated. Why not
 * the whole module when libstein is built: then every build would need a second compiler and its C
 * library, for one command. Values are no part of a module; the page puts them in.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "page.h"

enum { MAX_COMPILER_WORDS = 16, MAX_WORDS = 64 };

/* names of one module, all owned */
typedef struct job {
    char *folder, *core, *equations, *module; /* in the cache */
    char *work, *fresh, *log;                 /* of this process alone */
    char *sysroot, *define;
} job;

static void free_job(job *j)
{
    char *const all[] = {j->folder, j->core, j->equations, j->module, j->work,
                         j->fresh,  j->log,  j->sysroot,   j->define};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
}

static unsigned long long hash_sources(void)
{
    unsigned long long h = 0xcbf29ce484222325u;
    for (const page__source *f = page__core_files; f->name != NULL; f++) {
        for (int i = 0; f->lines[i] != NULL; i++) {
            for (const char *c = f->lines[i]; *c != '\0'; c++) {
                h = (h ^ (unsigned char)*c) * 0x100000001b3u;
            }
        }
    }
    return h;
}

static const char *environment(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value != NULL && *value != '\0' ? value : otherwise;
}

static stein_status name_files(job *j, const stein_model *equations, const lab_options *options,
                               stein_err *err)
{
    char *cache = NULL;
    stein_status status = lab__cache(&cache, options, err);
    if (status != STEIN_OK) {
        return status;
    }
    j->folder = lab__text("%s/page-%016llx", cache, hash_sources());
    free(cache);
    const char *folder = j->folder != NULL ? j->folder : "";
    j->core = lab__text("%s/core.o", folder);
    j->equations = lab__text("%s/%s-%s.c", folder, equations->name, equations->equations);
    j->module = lab__text("%s/%s-%s.wasm", folder, equations->name, equations->equations);
    j->work = lab__text("%s/work-XXXXXX", folder);
    j->sysroot = lab__text("%s", environment("WASI_SYSROOT", "/usr"));
    j->define = lab__text("-DPAGE_MODEL=%s", equations->name);
    int complete = j->folder != NULL && j->core != NULL && j->equations != NULL &&
                   j->module != NULL && j->work != NULL && j->sysroot != NULL && j->define != NULL;
    return complete ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
}

/* ---- what a machine may lack ---- */

static int is_in_path(const char *program)
{
    const char *path = environment("PATH", "/usr/bin:/bin");
    while (*path != '\0') {
        size_t n = strcspn(path, ":");
        char *name = lab__text("%.*s/%s", (int)n, path, program);
        int found = name != NULL && access(name, X_OK) == 0;
        free(name);
        if (found) {
            return 1;
        }
        path += n + (path[n] == ':');
    }
    return 0;
}

/* why the compiler failed: something is not there, or its own words */
static stein_status complain(const job *j, const char *cc, int code, stein_err *err)
{
    char *header = lab__text("%s/include/wasm32-wasi/stdlib.h", j->sysroot);
    int no_libc = header == NULL || access(header, R_OK) != 0, no_linker = !is_in_path("wasm-ld");
    free(header);
    if (code == 127 || no_libc || no_linker) {
        return lab__fail(err, STEIN_ECOMPILE,
                         "a page needs a compiler for WebAssembly, and this machine lacks:%s%s%s; "
                         "run apt-get install clang lld wasi-libc (WASM_CC names another clang, "
                         "WASI_SYSROOT another place of wasi-libc)",
                         code == 127 ? " clang" : "", no_linker ? " lld" : "",
                         no_libc ? " wasi-libc" : "");
    }
    char line[160];
    lab__complaint(j->log, line, (int)sizeof line);
    return lab__fail(err, STEIN_ECOMPILE, "%s failed to compile the page's module (exit code %d): %s",
                     cc, code, line);
}

/* ---- compiling ---- */

/* the compiler's own words ("ccache clang"), then what it always gets, then `more` up to NULL */
static stein_status run_clang(const job *j, char *const *more, const char *product, stein_err *err)
{
    const char *cc = environment("WASM_CC", "clang");
    char *words = lab__text("%s", cc), *rest = NULL, *argv[MAX_WORDS + 1];
    char *sysroot = lab__text("--sysroot=%s", j->sysroot);
    char *include = lab__text("-I%s/include", j->folder);
    char *core = lab__text("-I%s/src/core", j->folder);
    int n = 0, code = 0, memory = words != NULL && sysroot && include && core;
    for (char *w = memory ? strtok_r(words, " ", &rest) : NULL;
         w != NULL && n < MAX_COMPILER_WORDS; w = strtok_r(NULL, " ", &rest)) {
        argv[n++] = w;
    }
    char *fixed[] = {"--target=wasm32-wasi", sysroot,  "-std=c11", "-O2",   "-ffp-contract=off",
                     include,                core,     "-o",       j->fresh};
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++) {
        argv[n++] = fixed[i];
    }
    while (*more != NULL && n < MAX_WORDS) {
        argv[n++] = *more++;
    }
    argv[n] = NULL;
    stein_status status = memory ? lab__spawn(argv, j->log, &code, err)
                                 : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (status == STEIN_OK && code != 0) {
        status = complain(j, cc, code, err);
    }
    if (status == STEIN_OK && rename(j->fresh, product) != 0) {
        status = lab__fail(err, STEIN_EIO, "%s cannot be written: %s", product, strerror(errno));
    }
    free(words);
    free(sysroot);
    free(include);
    free(core);
    return status;
}

static stein_status write_sources(const job *j, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (const page__source *f = page__core_files; status == STEIN_OK && f->name != NULL; f++) {
        char *path = lab__text("%s/%s", j->folder, f->name), *slash = NULL;
        if (path == NULL) {
            return lab__fail(err, STEIN_ENOMEM, "out of memory");
        }
        slash = strrchr(path, '/');
        *slash = '\0';
        status = lab__folder(path, err);
        *slash = '/';
        status = status == STEIN_OK ? lab__write_lines(path, f->lines, err) : status;
        free(path);
    }
    return status;
}

/* every source of the core, linked into one object */
static stein_status compile_core(const job *j, stein_err *err)
{
    char *argv[MAX_WORDS + 1], *owned[MAX_WORDS];
    int n = 0, memory = 1;
    for (const page__source *f = page__core_files; f->name != NULL && n < MAX_WORDS - 8; f++) {
        size_t length = strlen(f->name);
        if (strncmp(f->name, "src/core/", 9) == 0 && f->name[length - 1] == 'c') {
            owned[n] = lab__text("%s/%s", j->folder, f->name);
            memory = memory && owned[n] != NULL;
            argv[n] = owned[n];
            n++;
        }
    }
    int sources = n;
    argv[n++] = "-nostdlib";
    argv[n++] = "-Wl,-r";
    argv[n] = NULL;
    stein_status status = memory ? run_clang(j, argv, j->core, err)
                                 : lab__fail(err, STEIN_ENOMEM, "out of memory");
    for (int i = 0; i < sources; i++) {
        free(owned[i]);
    }
    return status;
}

static stein_status compile_module(const job *j, const lab_model *model, stein_err *err)
{
    gen_result generated;
    stein_status status = gen_equations(&generated, lab__mechanism(model), err);
    if (status != STEIN_OK) {
        return status;
    }
    const char *source[] = {generated.source, NULL};
    status = lab__write_lines(j->equations, source, err);
    gen_free(&generated);
    char *shim = lab__text("%s/src/page/shim.c", j->folder);
    if (shim == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    char *argv[] = {j->define,         shim,           j->equations,      j->core, "-nostartfiles",
                    "-nodefaultlibs",  "-lc",          "-Wl,--no-entry",  "-Wl,--strip-all",
                    NULL};
    status = status == STEIN_OK ? run_clang(j, argv, j->module, err) : status;
    free(shim);
    return status;
}

/* in a folder of our own; what is not there yet */
static stein_status compile_apart(job *j, const lab_model *model, stein_err *err)
{
    if (mkdtemp(j->work) == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->folder, strerror(errno));
    }
    j->fresh = lab__text("%s/product", j->work);
    j->log = lab__text("%s/log", j->work);
    int memory = j->fresh != NULL && j->log != NULL;
    stein_status status = memory ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (status == STEIN_OK && access(j->core, R_OK) != 0) {
        status = write_sources(j, err);
        status = status == STEIN_OK ? compile_core(j, err) : status;
    }
    if (status == STEIN_OK) {
        status = compile_module(j, model, err);
    }
    if (memory) {
        unlink(j->fresh);
        unlink(j->log);
    }
    rmdir(j->work);
    return status;
}

stein_status page__module(char **bytes, size_t *size, const lab_model *model,
                          const lab_options *options, stein_err *err)
{
    job j = {0};
    stein_status status = name_files(&j, lab_equations(model), options, err);
    if (status == STEIN_OK) {
        status = lab__folder(j.folder, err);
    }
    if (status == STEIN_OK && access(j.module, R_OK) != 0) {
        status = compile_apart(&j, model, err);
    }
    if (status == STEIN_OK) {
        status = lab__read_file(j.module, bytes, size, err);
    }
    free_job(&j);
    return status;
}
