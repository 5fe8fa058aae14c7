/* SPDX-License-Identifier: MIT
 * main.c - the program steingen: mechanism file in, C equations out.
 */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gen.h"

enum { EXIT_MODEL = 1, EXIT_USAGE = 2, MAX_SET = 256 };

static const char usage[] =
    "usage: steingen MODEL.yaml [-o FILE|DIR] [--set NAME=VALUE[unit]]...\n"
    "\n"
    "Generates the equations of motion of a mechanism as one C file.\n"
    "\n"
    "  -o, --output PATH   file to write, or a directory that gets NAME.c after the mechanism's\n"
    "                      name; standard output when absent\n"
    "      --set NAME=VALUE[unit]   change a number of the file first (repeatable); a zero that\n"
    "                      becomes non-zero changes the equations\n"
    "  -h, --help          this text\n"
    "\n"
    "The file includes only \"stein/model.h\" and exports stein_model_NAME. Equal input gives "
    "equal\n"
    "bytes. Exit status: 0 done, 1 the model or the output is at fault, 2 usage.\n";

typedef struct options {
    const char *model, *output;
    mech_set set[MAX_SET];
    int nset;
} options;

static int usage_error(const char *what, const char *arg)
{
    fprintf(stderr, "steingen: %s%s%s (try --help)\n", what, arg ? " " : "", arg ? arg : "");
    return EXIT_USAGE;
}

/** "--set NAME=VALUE": splits at '=' in place. */
static int add_set(options *o, char *text)
{
    char *equals = text ? strchr(text, '=') : NULL;
    if (!equals || equals == text || o->nset == MAX_SET) {
        return usage_error("--set expects NAME=VALUE, got", text ? text : "nothing");
    }
    *equals = '\0';
    o->set[o->nset++] = (mech_set){.name = text, .value = equals + 1};
    return 0;
}

/** @return -1 go on, otherwise the exit status */
static int parse(options *o, int argc, char **argv)
{
    int plain = 0;
    for (int i = 1; i < argc; i++) {
        char *a = argv[i];
        if (!plain && (strcmp(a, "-h") == 0 || strcmp(a, "--help") == 0)) {
            fputs(usage, stdout);
            return 0;
        }
        if (!plain && strcmp(a, "--") == 0) {
            plain = 1;
        } else if (!plain && (strcmp(a, "-o") == 0 || strcmp(a, "--output") == 0)) {
            if (++i == argc) {
                return usage_error("-o expects a path", NULL);
            }
            o->output = argv[i];
        } else if (!plain && strncmp(a, "--output=", 9) == 0) {
            o->output = a + 9;
        } else if (!plain && (strcmp(a, "--set") == 0 || strncmp(a, "--set=", 6) == 0)) {
            int inside = a[5] == '=';
            int status = add_set(o, inside ? a + 6 : ++i < argc ? argv[i] : NULL);
            if (status) {
                return status;
            }
        } else if (!plain && a[0] == '-' && a[1]) {
            return usage_error("unknown option", a);
        } else if (o->model) {
            return usage_error("one model at a time, unexpected", a);
        } else {
            o->model = a;
        }
    }
    return o->model ? -1 : usage_error("no model given", NULL);
}

static void report(void *ctx, const char *message)
{
    (void)ctx;
    fprintf(stderr, "%s\n", message);
}

/** DIR -> DIR/NAME.c; anything else is a file. Owned by the caller. */
static char *target_path(const char *output, const char *name)
{
    struct stat st;
    size_t n = strlen(output), size = n + strlen(name) + 8;
    int directory =
        (n > 0 && output[n - 1] == '/') || (stat(output, &st) == 0 && S_ISDIR(st.st_mode));
    char *path = malloc(size);
    if (path && directory) {
        snprintf(path, size, "%s%s%s.c", output, n > 0 && output[n - 1] == '/' ? "" : "/", name);
    } else if (path) {
        snprintf(path, size, "%s", output);
    }
    return path;
}

static int complain(const char *path)
{
    fprintf(stderr, "steingen: %s cannot be written: %s\n", path, strerror(errno));
    return EXIT_MODEL;
}

/** A device or a pipe cannot be replaced by a file: it is written to directly. */
static int is_device(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && !S_ISREG(st.st_mode);
}

static int write_device(const char *path, const gen_result *r)
{
    FILE *f = fopen(path, "wb");
    int bad = !f || fwrite(r->source, 1, r->size, f) != r->size;
    bad = (f && fclose(f)) || bad;
    return bad ? complain(path) : 0;
}

/** Write beside the target and rename, so that no reader finds half a file. */
static int write_file(const char *path, const gen_result *r)
{
    if (is_device(path)) {
        return write_device(path, r);
    }
    size_t size = strlen(path) + 32;
    char *temporary = malloc(size);
    if (!temporary) {
        return complain(path);
    }
    snprintf(temporary, size, "%s.%ld.tmp", path, (long)getpid());
    FILE *f = fopen(temporary, "wb");
    int bad = !f || fwrite(r->source, 1, r->size, f) != r->size;
    bad = (f && fclose(f)) || bad;
    bad = bad || rename(temporary, path);
    int status = bad ? complain(path) : 0;
    if (bad && f) {
        remove(temporary);
    }
    free(temporary);
    return status;
}

static int write_result(const options *o, const char *name, const gen_result *r)
{
    if (!o->output) {
        int bad = fwrite(r->source, 1, r->size, stdout) != r->size || fflush(stdout);
        return bad ? complain("standard output") : 0;
    }
    char *path = target_path(o->output, name);
    int status = path ? write_file(path, r) : complain(o->output);
    free(path);
    return status;
}

int main(int argc, char **argv)
{
    signal(SIGPIPE, SIG_IGN); // told as an error like a full disk
    signal(SIGXFSZ, SIG_IGN);
    static options o;
    mechanism *m = NULL;
    gen_result r;
    stein_err err;
    int status = parse(&o, argc, argv);
    if (status >= 0) {
        return status;
    }
    if (mech_read(&m, o.model, o.set, o.nset, report, NULL, &err)) {
        if (err.code != STEIN_EPARSE) { /* problems of the file have been reported one by one */
            fprintf(stderr, "steingen: %s\n", err.msg);
        }
        return EXIT_MODEL;
    }
    if (gen_equations(&r, m, &err)) {
        fprintf(stderr, "steingen: %s\n", err.msg);
        mech_free(m);
        return EXIT_MODEL;
    }
    status = write_result(&o, m->name, &r);
    gen_free(&r);
    mech_free(m);
    return status;
}
