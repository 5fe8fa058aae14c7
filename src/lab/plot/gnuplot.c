/* SPDX-License-Identifier: GPL-3.0-or-later
 * gnuplot.c - a script becomes a picture. The script with its data goes through a folder of our
 * own; the picture is then copied to its place like every other result.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "plot.h"

/* curves and their panels */
typedef struct job {
    const char *path;
    int width, height;
    lab__script_fn *write;
    const void *ctx;
} job;

void lab__quoted(FILE *f, const char *text)
{
    putc('\'', f);
    for (; *text != '\0'; text++) {
        if (*text == '\'') {
            putc('\'', f);
        }
        putc(*text, f);
    }
    putc('\'', f);
}

static int ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), k = strlen(ending);
    return n > k && strcmp(path + n - k, ending) == 0;
}

stein_status lab__picture_name(const char *path, stein_err *err)
{
    return ends_with(path, ".svg") || ends_with(path, ".png")
               ? STEIN_OK
               : lab__fail(err, STEIN_EINVAL, "%s: expected a name that ends in .svg or .png",
                           path);
}

static void write_terminal(FILE *f, const job *j)
{
    fprintf(f, "set encoding utf8\nset terminal ");
    if (ends_with(j->path, ".svg")) {
        fprintf(f, "svg size %d,%d font 'Helvetica,13'", j->width, j->height);
    } else {
        fprintf(f, "pngcairo size %d,%d font 'Helvetica,13' fontscale 1.35 linewidth 1.4",
                3 * j->width / 2, 3 * j->height / 2);
    }
    fprintf(f, " background '#ffffff' noenhanced\n");
}

static stein_status copy_to(const char *from, const char *path, stein_err *err)
{
    lab__file file;
    FILE *in = fopen(from, "rb");
    if (in == NULL) {
        return lab__fail(err, STEIN_EIO, "gnuplot drew nothing for %s", path);
    }
    stein_status status = lab__file_open(&file, path, err);
    if (status == STEIN_OK) {
        char block[4096];
        size_t n;
        while ((n = fread(block, 1, sizeof block, in)) > 0) {
            fwrite(block, 1, n, file.stream);
        }
        int whole = !ferror(in);
        status = lab__file_close(&file, whole, err);
        if (!whole) {
            status =
                lab__fail(err, STEIN_EIO, "%s cannot be written: %s cannot be read", path, from);
        }
    }
    fclose(in);
    return status;
}

static stein_status run_gnuplot(char *script, const char *log, stein_err *err)
{
    char *argv[] = {"gnuplot", script, NULL};
    int code = 0;
    stein_status status = lab__spawn(argv, log, &code, err);
    if (status != STEIN_OK || code == 0) {
        return status;
    }
    if (code == 127) {
        return lab__fail(err, STEIN_EIO,
                         "no gnuplot to draw with: run apt-get install gnuplot-nox");
    }
    char line[160] = "", read[160];
    FILE *f = fopen(log, "r");
    while (f != NULL && fgets(read, (int)sizeof read, f) != NULL) { // the last one but warnings
        if (read[0] != '\n' && strstr(read, "warning:") == NULL) {
            memcpy(line, read, sizeof line);
        }
    }
    if (f != NULL) {
        fclose(f);
    }
    line[strcspn(line, "\n")] = '\0';
    return lab__fail(err, STEIN_EIO, "gnuplot failed (exit code %d): %s", code, line);
}

static stein_status write_script(const job *j, const char *script, const char *picture,
                                 stein_err *err)
{
    FILE *f = fopen(script, "w");
    locale_t before = lab__locale_c();
    if (f != NULL) {
        write_terminal(f, j);
        fprintf(f, "set output ");
        lab__quoted(f, picture);
        fprintf(f, "\n");
        j->write(f, j->ctx);
        fprintf(f, "set output\n");
    }
    lab__locale_restore(before);
    int bad = f == NULL || ferror(f);
    if ((f != NULL && fclose(f) != 0) || bad) {
        return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", script, strerror(errno));
    }
    return STEIN_OK;
}

static stein_status draw(const job *j, const char *folder, stein_err *err)
{
    char *script = lab__text("%s/script", folder), *picture = lab__text("%s/picture", folder),
         *log = lab__text("%s/log", folder);
    int complete = script != NULL && picture != NULL && log != NULL;
    stein_status status = complete ? write_script(j, script, picture, err) : lab__no_memory(err);
    if (status == STEIN_OK) {
        status = run_gnuplot(script, log, err);
    }
    if (status == STEIN_OK) {
        status = copy_to(picture, j->path, err);
    }
    if (complete) {
        unlink(script);
        unlink(picture);
        unlink(log);
    }
    free(script);
    free(picture);
    free(log);
    return status;
}

stein_status lab__gnuplot(const char *path, int width, int height, lab__script_fn *write,
                          const void *ctx, stein_err *err)
{
    const job j = {path, width, height, write, ctx};
    const char *temporary = getenv("TMPDIR");
    stein_status status = lab__picture_name(path, err);
    if (status != STEIN_OK) {
        return status;
    }
    char *folder =
        lab__text("%s/stein-XXXXXX", temporary != NULL && *temporary != '\0' ? temporary : "/tmp");
    if (folder == NULL || mkdtemp(folder) == NULL) {
        status = lab__fail(err, STEIN_EIO, "no folder for temporary files: %s", strerror(errno));
        free(folder);
        return status;
    }
    status = draw(&j, folder, err);
    rmdir(folder);
    free(folder);
    return status;
}
