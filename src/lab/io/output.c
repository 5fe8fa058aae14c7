/* SPDX-License-Identifier: GPL-3.0-or-later
 * output.c - messages, numbers, and files that appear whole or not at all.
 *
 * A reader must not find half of a result under the final name, neither while it is written nor
 * after a full disk. So a file is written beside its place and renamed when it is complete. A
 * device or a pipe cannot be replaced and is written directly.
 */
#define _GNU_SOURCE /* realpath, fopencookie */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io.h"

char *lab__one_line(char *text)
{
    for (char *c = text; *c != '\0'; c++) {
        if ((unsigned char)*c < ' ' || *c == 127) {
            *c = '?';
        }
    }
    return text;
}

void lab__put_line(FILE *f, const char *text)
{
    for (; *text != '\0'; text++) {
        putc((unsigned char)*text < ' ' ? ' ' : *text, f);
    }
    putc('\n', f);
}

void lab__put_notes(FILE *f, const char *const *notes)
{
    for (int i = 0; notes != NULL && notes[i] != NULL; i++) {
        fputs("# ", f);
        lab__put_line(f, notes[i]);
    }
}

const char *lab__printable(char *to, const char *text)
{
    snprintf(to, LAB_PRINTABLE, "%s", text);
    return lab__one_line(to);
}

stein_status lab__fail(stein_err *err, stein_status code, const char *format, ...)
{
    if (err != NULL) {
        va_list list;
        va_start(list, format);
        vsnprintf(err->msg, sizeof err->msg, format, list);
        va_end(list);
        lab__one_line(err->msg);
        err->code = code;
    }
    return code;
}

char *lab__text(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(NULL, 0, format, list);
    va_end(list);
    char *text = n < 0 ? NULL : malloc((size_t)n + 1);
    if (text != NULL) {
        va_start(list, format);
        vsnprintf(text, (size_t)n + 1, format, list);
        va_end(list);
    }
    return text;
}

unsigned long long lab__hash(unsigned long long hash, const void *bytes, size_t n)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < n; i++) {
        hash = (hash ^ byte[i]) * 1099511628211ull;
    }
    return hash;
}

/* a text that grows */
typedef struct growing {
    char **text;
    size_t size, room;
} growing;

static ssize_t grow(void *cookie, const char *bytes, size_t n)
{
    growing *g = cookie;
    if (g->size + n >= g->room) {
        size_t room = 2 * (g->size + n) + 4096;
        char *more = realloc(*g->text, room);
        if (more == NULL) {
            return 0; // an error of the stream
        }
        *g->text = more;
        g->room = room;
    }
    memcpy(*g->text + g->size, bytes, n);
    g->size += n;
    (*g->text)[g->size] = '\0';
    return (ssize_t)n;
}

static int grown(void *cookie)
{
    free(cookie);
    return 0;
}

FILE *lab__text_open(char **text)
{
    growing *g = malloc(sizeof *g);
    *text = calloc(1, 1);
    cookie_io_functions_t functions = {.write = grow, .close = grown};
    FILE *stream = g != NULL && *text != NULL ? fopencookie(g, "w", functions) : NULL;
    if (stream == NULL) {
        free(g);
        free(*text);
        *text = NULL;
        return NULL;
    }
    *g = (growing){text, 0, 1};
    return stream;
}

stein_status lab__text_close(FILE *stream, char **text, stein_err *err)
{
    int bad = ferror(stream); // a text that could not grow has lost its end
    bad |= fclose(stream) != 0;
    if (!bad && *text != NULL) {
        return STEIN_OK;
    }
    free(*text);
    *text = NULL;
    return lab__no_memory(err);
}

char *lab__number(char *text, double value)
{
    if (!isfinite(value)) {
        return strcpy(text, isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf");
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, LAB_NUMBER, "%.*g", digits, value);
        if (strtod(text, NULL) == value) {
            break;
        }
    }
    // the decimal sign of the locale, of whatever bytes, becomes a point
    char *to = text;
    for (const char *from = text; *from != '\0'; from++) {
        if (strchr("0123456789+-e", *from) != NULL) {
            *to++ = *from;
        } else if (to == text || to[-1] != '.') {
            *to++ = '.';
        }
    }
    *to = '\0';
    return text;
}

locale_t lab__locale_c(void)
{
    locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return c != (locale_t)0 ? uselocale(c) : (locale_t)0;
}

void lab__locale_restore(locale_t before)
{
    if (before != (locale_t)0) {
        freelocale(uselocale(before));
    }
}

int lab__is_stdout(const char *path)
{
    return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0;
}

static stein_status cannot_write(stein_err *err, const char *path, int cause)
{
    return lab__fail(err, STEIN_EIO, "%s cannot be written: %s", path, strerror(cause));
}

/* a new file beside `place` with the permissions it will keep; its name in *temporary */
static FILE *open_beside(const char *place, mode_t mode, char **temporary)
{
    for (int n = 0; n < 100; n++) {
        char *name = lab__text("%s.part-%ld-%d", place, (long)getpid(), n);
        if (name == NULL) {
            errno = ENOMEM;
            return NULL;
        }
        int fd = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        FILE *stream = fd < 0 ? NULL : fdopen(fd, "w");
        if (stream != NULL) {
            *temporary = name;
            return stream;
        }
        int cause = errno;
        if (fd >= 0) {
            close(fd);
            unlink(name);
        }
        free(name);
        errno = cause;
        if (cause != EEXIST) {
            return NULL;
        }
    }
    return NULL;
}

static FILE *open_stdout(void)
{
    fflush(stdout);
    int fd = dup(STDOUT_FILENO);
    FILE *stream = fd < 0 ? NULL : fdopen(fd, "w");
    if (stream == NULL && fd >= 0) {
        close(fd);
    }
    return stream;
}

stein_status lab__file_open(lab__file *file, const char *path, stein_err *err)
{
    struct stat st;
    int exists = stat(path, &st) == 0;
    lab__file f = {.stream = NULL};
    *file = f;
    if (exists && S_ISDIR(st.st_mode)) {
        return cannot_write(err, path, EISDIR);
    }
    if (lab__is_stdout(path)) {
        f.path = lab__text("standard output");
        f.stream = open_stdout();
    } else if ((exists && !S_ISREG(st.st_mode)) || strncmp(path, "/dev/", 5) == 0) {
        f.path = lab__text("%s", path);
        f.stream = fopen(path, "w");
    } else {
        f.path = exists ? realpath(path, NULL) : lab__text("%s", path); // through symbolic links
        if (f.path != NULL && exists && access(f.path, W_OK) != 0) {
            int cause = errno;
            free(f.path);
            return cannot_write(err, path, cause);
        }
        if (f.path != NULL) {
            f.stream = open_beside(f.path, exists ? st.st_mode & 0777 : 0666, &f.temporary);
        }
    }
    if (f.stream == NULL) {
        int cause = errno;
        free(f.path);
        return cannot_write(err, path, cause);
    }
    f.before = lab__locale_c();
    *file = f;
    return STEIN_OK;
}

stein_status lab__file_close(lab__file *file, int keep, stein_err *err)
{
    int bad = ferror(file->stream);
    lab__locale_restore(file->before);
    int cause = bad ? EIO : 0;
    if (fclose(file->stream) != 0) {
        cause = errno;
    }
    if (file->temporary != NULL && (cause != 0 || !keep)) {
        unlink(file->temporary);
    } else if (file->temporary != NULL && rename(file->temporary, file->path) != 0) {
        cause = errno;
        unlink(file->temporary);
    }
    stein_status status = cause != 0 && keep ? cannot_write(err, file->path, cause) : STEIN_OK;
    free(file->path);
    free(file->temporary);
    *file = (lab__file){.stream = NULL};
    return status;
}

stein_status lab__folder(const char *path, stein_err *err)
{
    char *part = lab__text("%s", path);
    if (part == NULL) {
        return lab__no_memory(err);
    }
    int failed = 0;
    for (char *at = part + 1; !failed; at++) {
        if (*at == '/' || *at == '\0') {
            char kept = *at;
            *at = '\0';
            failed = mkdir(part, 0777) != 0 && errno != EEXIST ? errno : 0;
            *at = kept;
            if (kept == '\0') {
                break;
            }
        }
    }
    free(part);
    struct stat st;
    if (!failed && (stat(path, &st) != 0 || !S_ISDIR(st.st_mode))) {
        failed = ENOTDIR;
    }
    return failed
               ? lab__fail(err, STEIN_EIO, "folder %s cannot be made: %s", path, strerror(failed))
               : STEIN_OK;
}

stein_status lab__read_file(const char *path, char **text, size_t *size, stein_err *err)
{
    FILE *f = fopen(path, "rb");
    if (f == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read: %s", path, strerror(errno));
    }
    size_t n = 0, room = 1 << 16;
    char *t = malloc(room);
    if (t == NULL) {
        fclose(f);
        return lab__no_memory(err);
    }
    for (size_t got; (got = fread(t + n, 1, room - n - 1, f)) > 0;) {
        n += got;
        if (n + 1 >= room) {
            char *more = realloc(t, room *= 2);
            if (more == NULL) {
                fclose(f);
                free(t);
                return lab__no_memory(err);
            }
            t = more;
        }
    }
    if (ferror(f)) { // a folder, for example
        lab__fail(err, STEIN_EIO, "%s cannot be read: %s", path, strerror(errno));
        fclose(f);
        free(t);
        return STEIN_EIO;
    }
    fclose(f);
    t[n] = '\0';
    *text = t;
    *size = n;
    return STEIN_OK;
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
