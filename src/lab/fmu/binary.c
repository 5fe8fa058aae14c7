/* SPDX-License-Identifier: GPL-3.0-or-later
 * binary.c - the sources of an FMU, and the shared object made of them.
 *
 *   CACHE/VERSION-abiN/fmu-HASH/          sources of the core and of a slave, as in the FMU
 *   CACHE/VERSION-abiN/fmu-HASH/core.o    all of them in one object
 *
 * HASH is of their text and of the compiler's name. Code shared by all FMUs is compiled once; the
 * functions of one version of FMI, the equations and the values are compiled for each FMU. Values
 * are part of the binary, because an importer need not set unchanged ones.
 *
 * Only the functions of FMI are visible outside: FMUs of different versions of the library may be
 * loaded into one program.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmu.h"

const char fmu__compiler_options[] =
    "-std=c11 -O2 -ffp-contract=off -fno-tree-slp-vectorize -fno-math-errno";

/* ---- sources ---- */

/* where a file of the project lies in an FMU: beside each other, headers of the library in stein */
static const char *place_of(const char *name)
{
    static const char headers[] = "include/";
    const char *slash = strrchr(name, '/');
    return strncmp(name, headers, sizeof headers - 1) == 0 ? name + sizeof headers - 1
           : slash != NULL                                 ? slash + 1
                                                           : name;
}

/* the version of FMI that a file is of: the digit before its ending; 0: of both */
static int version_of(const char *place)
{
    const char *dot = strchr(place, '.');
    return dot != NULL && dot > place && (dot[-1] == '2' || dot[-1] == '3') ? dot[-1] - '0' : 0;
}

/* is a file of src/fmi, or of what a page is made of too, part of an FMU of this version? */
static int belongs(const char *name, int version)
{
    const char *place = place_of(name);
    int of = version_of(place);
    return strcmp(place, "shim.c") != 0 && strcmp(place, "license.txt") != 0 &&
           (of == 0 || of == version);
}

static stein_status put_source(fmu_sources *to, const char *name, char *text, stein_err *err)
{
    char *own = lab__text("%s", name);
    if (own == NULL || text == NULL || to->n == FMU_SOURCES) {
        free(own);
        free(text);
        return lab__no_memory(err);
    }
    to->name[to->n] = own;
    to->text[to->n++] = text;
    return STEIN_OK;
}

char *fmu__joined(const char *const *lines)
{
    size_t size = 1;
    for (int i = 0; lines[i] != NULL; i++) {
        size += strlen(lines[i]);
    }
    char *text = malloc(size), *at = text;
    for (int i = 0; text != NULL && lines[i] != NULL; i++) {
        size_t n = strlen(lines[i]);
        memcpy(at, lines[i], n);
        at += n;
    }
    if (text != NULL) {
        *at = '\0';
    }
    return text;
}

static stein_status put_files(fmu_sources *to, const lab__source *files, int version,
                              stein_err *err)
{
    stein_status status = STEIN_OK;
    for (const lab__source *f = files; status == STEIN_OK && f->name != NULL; f++) {
        if (belongs(f->name, version)) {
            status = put_source(to, place_of(f->name), fmu__joined(f->lines), err);
        }
    }
    return status;
}

static stein_status put_equations(fmu_sources *to, const mechanism *m, stein_err *err)
{
    gen_result generated;
    stein_status status = gen_equations(&generated, m, err);
    if (status == STEIN_OK) {
        status =
            put_source(to, "equations.c",
                       lab__text("#define STEIN_PLAIN /* without derivatives of its own */\n%s",
                                 generated.source),
                       err);
        gen_free(&generated);
    }
    return status;
}

/* a double as C: a whole number without a point would be an int, and -0 would become 0 */
static void put_double(FILE *f, double value)
{
    char text[LAB_NUMBER];
    lab__number(text, value);
    fprintf(f, "%s%s", text, strpbrk(text, ".e") == NULL ? ".0" : "");
}

static void write_values(FILE *f, const fmu_list *list, const char *token)
{
    const stein_model *m = list->model;
    fprintf(f,
            "/* SPDX-License-Identifier: MIT\n"
            " * fmu_model.c - values of the mechanism file. Written by stein export. */\n"
            "#include \"slave.h\"\n\n"
            "extern const stein_model stein_model_%s;\n\nstatic const double values[] = {\n",
            list->m->name);
    for (int i = 0; i < m->np; i++) {
        fputs("    ", f);
        put_double(f, m->params[i].value);
        fputs(",\n", f);
    }
    fputs("    0.0};\nstatic const unsigned char tunable[] = {\n    ", f);
    for (int i = 0; i < m->np; i++) {
        fprintf(f, "%d,%s", fmu__is_tunable(list->m, m, i), i % 24 == 23 ? "\n    " : " ");
    }
    fprintf(f,
            "0};\n\nconst slave_model slave_the_model = {\n    &stein_model_%s, \"%s\", values, "
            "tunable, ",
            list->m->name, token);
    put_double(f, m->dt);
    fprintf(f, ", %d, %d};\n", m->integrator, m->settle);
}

static stein_status put_values(fmu_sources *to, const fmu_list *list, const char *token,
                               stein_err *err)
{
    char *text;
    FILE *f = lab__text_open(&text);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_values(f, list, token);
    stein_status status = lab__text_close(f, &text, err);
    return status == STEIN_OK ? put_source(to, "fmu_model.c", text, err) : status;
}

stein_status fmu__sources_create(fmu_sources *to, const fmu_list *list, int version,
                                 const char *token, stein_err *err)
{
    *to = (fmu_sources){.n = 0};
    stein_status status = put_files(to, lab__core_files, version, err);
    status = status == STEIN_OK ? put_files(to, lab__fmu_files, version, err) : status;
    status = status == STEIN_OK ? put_equations(to, list->m, err) : status;
    status = status == STEIN_OK ? put_values(to, list, token, err) : status;
    for (int i = 0, n = 0; status == STEIN_OK && i < to->n; i++) {
        if (lab__is_c(to->name[i])) {
            to->compiled[n++] = to->name[i];
        }
    }
    if (status != STEIN_OK) {
        fmu__sources_free(to);
    }
    return status;
}

void fmu__sources_free(fmu_sources *sources)
{
    for (int i = 0; i < sources->n; i++) {
        free(sources->name[i]);
        free(sources->text[i]);
    }
    sources->n = 0;
}

/* is it a file of this FMU, not of all? */
static int is_own(const char *name)
{
    return strcmp(name, "equations.c") == 0 || strcmp(name, "fmu_model.c") == 0 ||
           version_of(name) > 0;
}

/* ---- compiling ---- */

/* names of one build, all owned */
typedef struct job {
    const char *cc;           /* not owned */
    char *folder, *core;      /* in the cache */
    char *work, *fresh, *log; /* of this process alone */
    int windows;              /* 1: compiled for it, 0: for Linux */
    int x87;                  /* 1: 32 bits, where SSE2 has to be asked for */
} job;

static void free_job(job *j)
{
    char *const all[] = {j->folder, j->core, j->work, j->fresh, j->log};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
}

unsigned long long fmu__hash(unsigned long long h, const char *text)
{
    return lab__hash(lab__hash(h, text, strlen(text)), "\xff", 1);
}

static stein_status name_files(job *j, const fmu_sources *sources, const lab_options *options,
                               stein_err *err)
{
    char *cache = NULL;
    stein_status status = lab__cache(&cache, options, err);
    if (status != STEIN_OK) {
        return status;
    }
    unsigned long long h = fmu__hash(STEIN_HASH, j->cc);
    for (int i = 0; i < sources->n; i++) {
        h = is_own(sources->name[i]) ? h
                                     : fmu__hash(fmu__hash(h, sources->name[i]), sources->text[i]);
    }
    j->folder = lab__text("%s/fmu-%016llx", cache, h);
    free(cache);
    const char *folder = j->folder != NULL ? j->folder : "";
    j->core = lab__text("%s/core.o", folder);
    j->work = lab__text("%s/work-XXXXXX", folder);
    int complete = j->folder != NULL && j->core != NULL && j->work != NULL;
    return complete ? STEIN_OK : lab__no_memory(err);
}

static stein_status complain(const job *j, int code, stein_err *err)
{
    char line[160];
    if (code == 127) {
        return lab__fail(err, STEIN_ECOMPILE,
                         "an FMU needs a C compiler, and there is no \"%s\": run apt-get install "
                         "gcc, or set CC",
                         j->cc);
    }
    lab__first_error(j->log, line, (int)sizeof line);
    return lab__fail(err, STEIN_ECOMPILE, "%s failed to compile the FMU (exit code %d): %s", j->cc,
                     code, line);
}

/* the compiler, which may contain options, and the options of its first task */
static void begin(lab__command *w, const job *j, const char *fixed)
{
    lab__command_split(w, j->cc);
    lab__command_split(w, fixed);
}

static stein_status run(const job *j, lab__command *w, stein_err *err)
{
    int code = 0;
    stein_status status = lab__command_run(w, j->log, &code, err);
    return status == STEIN_OK && code != 0 ? complain(j, code, err) : status;
}

static stein_status write_text(const char *path, const char *text, stein_err *err)
{
    const char *const lines[] = {text, NULL};
    return path != NULL ? lab__write_lines(path, lines, err) : lab__no_memory(err);
}

/* code shared by all mechanisms, into the cache */
static stein_status write_shared(const job *j, const fmu_sources *sources, stein_err *err)
{
    char *stein = lab__text("%s/stein", j->folder);
    stein_status status = stein != NULL ? lab__folder(stein, err) : lab__no_memory(err);
    free(stein);
    for (int i = 0; status == STEIN_OK && i < sources->n; i++) {
        if (!is_own(sources->name[i])) {
            char *path = lab__text("%s/%s", j->folder, sources->name[i]);
            status = write_text(path, sources->text[i], err);
            free(path);
        }
    }
    return status;
}

/* where code has a fixed place, as in Windows, a compiler warns of -fPIC */
static const char always[] = "-fPIC -fvisibility=hidden", always_windows[] = "";
/* the same bytes each time; nothing that is missing; no library of the compiler's beside it */
static const char link_linux[] = "-shared -s -Wl,-z,defs -Wl,--build-id=none",
                  link_windows[] = "-shared -s -static-libgcc -Wl,--no-insert-timestamp "
                                   "-Wl,--disable-auto-image-base";

/* files of the shared or of the own kind, as words of the command line */
static void add_files(lab__command *w, const job *j, const fmu_sources *sources, int own)
{
    for (int i = 0; sources->compiled[i] != NULL; i++) {
        if (is_own(sources->compiled[i]) == own) {
            lab__command_add(w,
                             lab__text("%s/%s", own ? j->work : j->folder, sources->compiled[i]));
        }
    }
}

static void add_options(lab__command *w, const job *j)
{
    lab__command_split(w, fmu__compiler_options);
    lab__command_split(w, j->windows ? always_windows : always);
    lab__command_split(w, j->x87 ? "-msse2 -mfpmath=sse" : "");
    lab__command_add(w, lab__text("-I%s", j->folder));
    lab__command_split(w, "-o");
    lab__command_add(w, lab__text("%s", j->fresh));
}

static stein_status compile_core(const job *j, const fmu_sources *sources, stein_err *err)
{
    lab__command w = {0};
    stein_status status = write_shared(j, sources, err);
    if (status != STEIN_OK) {
        return status;
    }
    begin(&w, j, "-r -nostdlib");
    add_options(&w, j);
    add_files(&w, j, sources, 0);
    status = run(j, &w, err);
    if (status == STEIN_OK && rename(j->fresh, j->core) != 0) {
        status = lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->core, strerror(errno));
    }
    return status;
}

static stein_status link_all(const job *j, const fmu_sources *sources, stein_err *err)
{
    lab__command w = {0};
    begin(&w, j, j->windows ? link_windows : link_linux);
    add_options(&w, j);
    add_files(&w, j, sources, 1);
    lab__command_add(&w, lab__text("%s", j->core));
    lab__command_split(&w, "-lm");
    return run(j, &w, err);
}

/* i386 ... i686 */
static int is_x87(const char *machine)
{
    return strcspn(machine, "-\n") == 4 && machine[0] == 'i' && strncmp(machine + 2, "86", 2) == 0;
}

/* the name of a folder: in FMI 3 "x86_64-linux", in FMI 2 "linux64" where there is one */
static int name_platform(char *platform, const char *machine, int windows, int version)
{
    const char *system = windows ? "windows" : "linux";
    size_t n = strcspn(machine, "-\n");
    int old = is_x87(machine);
    int arm = strncmp(machine, "arm", 3) == 0;
    const char *arch = old ? "x86" : arm ? "aarch32" : machine;
    n = old || arm ? strlen(arch) : n;
    if (version == 2 && (old || (n == 6 && strncmp(machine, "x86_64", n) == 0))) {
        return snprintf(platform, FMU_PLATFORM, "%s%d", windows ? "win" : system, old ? 32 : 64);
    }
    return snprintf(platform, FMU_PLATFORM, "%.*s-%s", (int)n, arch, system);
}

static stein_status find_platform(char *platform, job *j, int version, stein_err *err)
{
    lab__command w = {0};
    char *text = NULL;
    size_t size = 0;
    begin(&w, j, "-dumpmachine");
    stein_status status = run(j, &w, err);
    status = status == STEIN_OK ? lab__read_file(j->log, &text, &size, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    j->windows = strstr(text, "mingw") != NULL;
    j->x87 = is_x87(text);
    int known = j->windows || strstr(text, "linux") != NULL;
    if (!known || name_platform(platform, text, j->windows, version) >= FMU_PLATFORM) {
        status = lab__fail(err, STEIN_ECOMPILE,
                           "%s compiles for %.*s: an FMU needs one for Linux, or mingw for Windows",
                           j->cc, (int)strcspn(text, "\n"), text);
    }
    free(text);
    return status;
}

static stein_status name_work(job *j, stein_err *err)
{
    stein_status status = lab__folder(j->folder, err);
    if (status != STEIN_OK) {
        return status;
    }
    if (mkdtemp(j->work) == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", j->folder, strerror(errno));
    }
    j->fresh = lab__text("%s/fresh.o", j->work); // an ending, or a compiler adds its own
    j->log = lab__text("%s/log", j->work);
    int complete = j->fresh != NULL && j->log != NULL;
    return complete ? STEIN_OK : lab__no_memory(err);
}

static stein_status write_own(const job *j, const fmu_sources *sources, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < sources->n; i++) {
        if (is_own(sources->name[i])) {
            char *path = lab__text("%s/%s", j->work, sources->name[i]);
            status = write_text(path, sources->text[i], err);
            free(path);
        }
    }
    return status;
}

static void drop(char *path)
{
    if (path != NULL) {
        unlink(path);
    }
}

static void clean(const job *j, const fmu_sources *sources)
{
    drop(j->fresh);
    drop(j->log);
    for (int i = 0; i < sources->n; i++) {
        char *path =
            is_own(sources->name[i]) ? lab__text("%s/%s", j->work, sources->name[i]) : NULL;
        drop(path);
        free(path);
    }
    rmdir(j->work);
}

stein_status fmu__binary(fmu_binary *to, const fmu_sources *sources, int version, const char *cc,
                         const lab_options *options, stein_err *err)
{
    job j = {.cc = cc};
    stein_status status = name_files(&j, sources, options, err);
    if (status != STEIN_OK) {
        free_job(&j);
        return status;
    }
    status = name_work(&j, err);
    status = status == STEIN_OK ? find_platform(to->platform, &j, version, err) : status;
    status = status == STEIN_OK ? write_own(&j, sources, err) : status;
    int cached = access(j.core, R_OK) == 0;
    if (status == STEIN_OK && !cached) {
        status = compile_core(&j, sources, err);
    }
    if (status == STEIN_OK) {
        status = link_all(&j, sources, err);
        if (status == STEIN_ECOMPILE && cached) { // files in the cache may be damaged: once more
            status = compile_core(&j, sources, err);
            status = status == STEIN_OK ? link_all(&j, sources, err) : status;
        }
    }
    status = status == STEIN_OK ? lab__read_file(j.fresh, &to->bytes, &to->size, err) : status;
    to->ending = j.windows ? "dll" : "so";
    clean(&j, sources);
    free_job(&j);
    return status;
}
