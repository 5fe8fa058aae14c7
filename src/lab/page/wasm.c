/* SPDX-License-Identifier: GPL-3.0-or-later
 * wasm.c - core and equations as one WebAssembly module, by clang, wasm-ld and wasi-libc.
 *
 *   CACHE/VERSION-abiN/page-SOURCES/src/..., include/...    the sources, as this program has them
 *   CACHE/VERSION-abiN/page-SOURCES/core-COMPILER/NAME.o    the core, for all mechanisms
 *   CACHE/VERSION-abiN/page-SOURCES/NAME-HASH.wasm          one mechanism structure each
 *
 * SOURCES is a hash of all the text that is compiled, so an entry never has to be updated; COMPILER
 * one of its name and of where its library is. Values are no part of a module; the page puts them
 * in. The cache holds the core as clang's intermediate code: it becomes a program together with the
 * equations (-flto). With a core that was one already a step took 1.3 times as long and a frame in
 * real time more than its 4 ms. And a module made when libstein is built would let every build need
 * a second compiler, for one command.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "page.h"

/* names of one module, all owned */
typedef struct job {
    char *folder, *core, *equations, *module; /* in the cache */
    char *work, *fresh, *log;                 /* of this process alone */
    char *sysroot;
    const char *model; /* its name; not owned */
    int reactions;     /* outputs that read one: else what finds them is left out */
    int loops;         /* conditions: else what passes singular positions is left out */
} job;

static void free_job(job *j)
{
    char *const all[] = {j->folder, j->core,  j->equations, j->module,
                         j->work,   j->fresh, j->log,       j->sysroot};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
}

static unsigned long long hash_sources(void)
{
    unsigned long long h = STEIN_HASH;
    for (const lab__source *f = lab__core_files; f->name != NULL; f++) {
        for (int i = 0; f->lines[i] != NULL; i++) {
            h = lab__hash(h, f->lines[i], strlen(f->lines[i]));
        }
    }
    return h;
}

static const char *environment(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value != NULL && *value != '\0' ? value : otherwise;
}

static const char *compiler(void)
{
    return environment("WASM_CC", "clang");
}

static const char *sysroot(void)
{
    return environment("WASI_SYSROOT", "/usr");
}

static unsigned long long hash_compiler(void)
{
    const char *cc = compiler(), *root = sysroot(); // each with its closing zero
    return lab__hash(lab__hash(STEIN_HASH, cc, strlen(cc) + 1), root, strlen(root) + 1);
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
    j->core = lab__text("%s/core-%016llx", folder, hash_compiler());
    j->equations = lab__text("%s/%s-%s.c", folder, equations->name, equations->equations);
    j->module = lab__text("%s/%s-%s.wasm", folder, equations->name, equations->equations);
    j->work = lab__text("%s/work-XXXXXX", folder);
    j->sysroot = lab__text("%s", sysroot());
    j->model = equations->name;
    j->reactions = equations->nreaction;
    j->loops = equations->nrow;
    int complete = j->folder != NULL && j->core != NULL && j->equations != NULL &&
                   j->module != NULL && j->work != NULL && j->sysroot != NULL;
    return complete ? STEIN_OK : lab__no_memory(err);
}

/* ---- missing tools ---- */

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
static stein_status complain(const job *j, int code, stein_err *err)
{
    char line[160];
    lab__first_error(j->log, line, (int)sizeof line);
    char *header = lab__text("%s/include/wasm32-wasi/stdlib.h", j->sysroot);
    int no_libc = header == NULL || access(header, R_OK) != 0;
    int no_linker = !is_in_path("wasm-ld") || // or the one of clang's own version
                    (strstr(line, "wasm-ld") != NULL && strstr(line, "exist") != NULL);
    free(header);
    if (code == 127 || no_libc || no_linker) {
        return lab__fail(err, STEIN_ECOMPILE,
                         "a page needs a compiler for WebAssembly, and this machine lacks:%s%s%s; "
                         "run apt-get install clang lld wasi-libc (WASM_CC names another clang, "
                         "WASI_SYSROOT another place of wasi-libc)",
                         code == 127 ? " clang" : "", no_linker ? " lld" : "",
                         no_libc ? " wasi-libc" : "");
    }
    return lab__fail(err, STEIN_ECOMPILE,
                     "%s failed to compile the page's module (exit code %d): %s", compiler(), code,
                     line);
}

/* ---- compiling ---- */

/* clang, what it compiles into and where it finds what is included */
static void begin_command(lab__command *words, const job *j)
{
    lab__command_split(words, compiler());
    lab__command_split(words, "--target=wasm32-wasi -std=c11 -O2 -DSTEIN_PLAIN -flto -mbulk-memory "
                              "-ffp-contract=off");
    lab__command_add(words, lab__text("--sysroot=%s", j->sysroot));
    lab__command_add(words, lab__text("-I%s/include", j->folder));
    lab__command_add(words, lab__text("-I%s/src/core", j->folder));
}

/* run it: what it makes in j->fresh goes to its place */
static stein_status end_command(const job *j, lab__command *words, const char *place,
                                stein_err *err)
{
    int code = 0;
    stein_status status = lab__command_run(words, j->log, &code, err);
    if (status == STEIN_OK && code != 0) {
        status = complain(j, code, err);
    }
    if (status == STEIN_OK && rename(j->fresh, place) != 0) {
        status = lab__fail(err, STEIN_EIO, "%s cannot be written: %s", place, strerror(errno));
    }
    return status;
}

/* the core is the same for every mechanism; the files around it contain the mechanism's name */
static int is_of_core(const char *name)
{
    static const char core[] = "src/core/";
    return lab__is_c(name) && strncmp(name, core, sizeof core - 1) == 0;
}

static char *object_of(const job *j, const char *name)
{
    return lab__text("%s/%s.o", j->core, strrchr(name, '/') + 1);
}

/* files that are not in the cache; *kept: files that were */
static stein_status compile_core(const job *j, int *kept, stein_err *err)
{
    stein_status status = lab__folder(j->core, err);
    *kept = 0;
    for (const lab__source *f = lab__core_files; status == STEIN_OK && f->name != NULL; f++) {
        char *object = is_of_core(f->name) ? object_of(j, f->name) : NULL;
        if (object != NULL && access(object, R_OK) == 0) {
            ++*kept;
        } else if (object != NULL) {
            lab__command words = {0};
            begin_command(&words, j);
            lab__command_split(&words, "-c -o");
            lab__command_add(&words, lab__text("%s", j->fresh));
            lab__command_add(&words, lab__text("%s/%s", j->folder, f->name));
            status = end_command(j, &words, object, err);
        }
        free(object);
    }
    return status;
}

/* another compiler of the same name may not read the kept files */
static void forget_core(const job *j)
{
    for (const lab__source *f = lab__core_files; f->name != NULL; f++) {
        char *object = is_of_core(f->name) ? object_of(j, f->name) : NULL;
        if (object != NULL) {
            unlink(object);
        }
        free(object);
    }
}

static int is_wanted(const job *j, const char *name)
{
    return (j->reactions > 0 || strcmp(name, "src/core/reaction.c") != 0) &&
           (j->loops > 0 || strcmp(name, "src/core/singular.c") != 0);
}

static stein_status link_module(const job *j, stein_err *err)
{
    lab__command words = {0};
    begin_command(&words, j);
    lab__command_split(&words, "-nostartfiles -nodefaultlibs -Wl,--no-entry -Wl,--strip-all");
    lab__command_add(&words, lab__text("-DPAGE_MODEL=%s", j->model));
    if (j->reactions == 0) {
        lab__command_split(&words, "-DPAGE_WITHOUT_REACTIONS");
    }
    if (j->loops == 0) {
        lab__command_split(&words, "-DPAGE_WITHOUT_LOOPS");
    }
    lab__command_split(&words, "-o");
    lab__command_add(&words, lab__text("%s", j->fresh));
    for (const lab__source *f = lab__core_files; f->name != NULL; f++) {
        if (is_of_core(f->name) && is_wanted(j, f->name)) {
            lab__command_add(&words, object_of(j, f->name));
        } else if (lab__is_c(f->name) && !is_of_core(f->name)) {
            lab__command_add(&words, lab__text("%s/%s", j->folder, f->name));
        }
    }
    lab__command_add(&words, lab__text("%s", j->equations));
    lab__command_split(&words, "-lc");
    return end_command(j, &words, j->module, err);
}

static stein_status make_module(const job *j, stein_err *err)
{
    int kept;
    stein_status status = compile_core(j, &kept, err);
    status = status == STEIN_OK ? link_module(j, err) : status;
    if (status == STEIN_ECOMPILE && kept > 0) {
        forget_core(j);
        status = compile_core(j, &kept, err);
        status = status == STEIN_OK ? link_module(j, err) : status;
    }
    return status;
}

static stein_status write_sources(const job *j, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (const lab__source *f = lab__core_files; status == STEIN_OK && f->name != NULL; f++) {
        char *path = lab__text("%s/%s", j->folder, f->name), *slash = NULL;
        if (path == NULL) {
            return lab__no_memory(err);
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

static stein_status write_equations(const job *j, const lab_model *model, stein_err *err)
{
    gen_result generated;
    stein_status status = gen_equations(&generated, lab__mechanism(model), err);
    if (status != STEIN_OK) {
        return status;
    }
    const char *source[] = {generated.source, NULL};
    status = lab__write_lines(j->equations, source, err);
    gen_free(&generated);
    return status;
}

/* in a folder of our own */
static stein_status compile_apart(job *j, const lab_model *model, stein_err *err)
{
    if (mkdtemp(j->work) == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->folder, strerror(errno));
    }
    j->fresh = lab__text("%s/module", j->work);
    j->log = lab__text("%s/log", j->work);
    int memory = j->fresh != NULL && j->log != NULL;
    stein_status status = memory ? write_sources(j, err) : lab__no_memory(err);
    if (status == STEIN_OK) {
        status = write_equations(j, model, err);
    }
    if (status == STEIN_OK) {
        status = make_module(j, err);
    }
    if (memory) {
        unlink(j->fresh);
        unlink(j->log);
    }
    rmdir(j->work);
    return status;
}

/* a module in the cache; one that is none (a disk that was full) counts as not there */
static int read_cached(const job *j, char **bytes, size_t *size)
{
    static const char magic[4] = {'\0', 'a', 's', 'm'};
    char *text = NULL;
    size_t n = 0;
    if (lab__read_file(j->module, &text, &n, NULL) == STEIN_OK && n >= sizeof magic &&
        memcmp(text, magic, sizeof magic) == 0) {
        *bytes = text;
        *size = n;
        return 1;
    }
    free(text);
    return 0;
}

stein_status page__module(char **bytes, size_t *size, const lab_model *model,
                          const lab_options *options, stein_err *err)
{
    job j = {0};
    stein_status status = name_files(&j, lab_equations(model), options, err);
    if (status == STEIN_OK && !read_cached(&j, bytes, size)) {
        if (options->report != NULL) {
            options->report(options->ctx,
                            "compiling to WebAssembly, once a mechanism: a few seconds");
        }
        status = lab__folder(j.folder, err);
        status = status == STEIN_OK ? compile_apart(&j, model, err) : status;
        status = status == STEIN_OK ? lab__read_file(j.module, bytes, size, err) : status;
    }
    free_job(&j);
    return status;
}
