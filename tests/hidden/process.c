/* SPDX-License-Identifier: GPL-3.0-or-later
 * process.c - other programs, folders.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "hidden.h"

double process_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double of_children(void)
{
    struct rusage r;
    getrusage(RUSAGE_CHILDREN, &r);
    return (double)(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
           1e-6 * (double)(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
}

static void become(char *const argv[], const char *log, double limit)
{
    int in = open("/dev/null", O_RDONLY);
    int out = log != NULL ? open(log, O_WRONLY | O_CREAT | O_TRUNC, 0666) : -1;
    if (in < 0 || (log != NULL && out < 0)) {
        _exit(127);
    }
    dup2(in, 0);
    if (out >= 0) {
        dup2(out, 1);
        dup2(out, 2);
    }
    if (limit > 0.0) {
        struct rlimit r = {(rlim_t)limit, (rlim_t)limit + 1};
        setrlimit(RLIMIT_CPU, &r);
    }
    execvp(argv[0], argv);
    _exit(127);
}

int process_run(char *const argv[], const char *log, double limit, double *cpu)
{
    int status = 0;
    double before = of_children();
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        become(argv, log, limit);
    }
    if (child < 0 || waitpid(child, &status, 0) < 0) {
        return 127;
    }
    if (cpu != NULL) {
        *cpu = of_children() - before;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int process_folder(const char *path)
{
    char part[PATH];
    for (size_t n = 1; n <= strlen(path) && n < PATH; n++) {
        if (path[n] == '/' || path[n] == '\0') {
            memcpy(part, path, n);
            part[n] = '\0';
            if (mkdir(part, 0777) != 0 && errno != EEXIST) {
                perror(part);
                return -1;
            }
        }
    }
    return 0;
}

int process_copy(const char *head, const char *from, const char *to)
{
    char block[1 << 16], part[PATH + 40];
    struct stat is;
    size_t n;
    snprintf(part, sizeof part, "%s.part", to);
    FILE *in = fopen(from, "rb"), *out = in != NULL ? fopen(part, "wb") : NULL;
    int ok = out != NULL && fstat(fileno(in), &is) == 0 && fputs(head, out) >= 0;
    while (ok && (n = fread(block, 1, sizeof block, in)) > 0) {
        ok = fwrite(block, 1, n, out) == n;
    }
    ok = ok && !ferror(in);
    if (in != NULL) {
        fclose(in);
    }
    ok = out != NULL && fclose(out) == 0 && ok;
    ok = ok && chmod(part, is.st_mode & 0777) == 0 && rename(part, to) == 0;
    if (!ok) {
        perror(to);
    }
    return ok ? 0 : -1;
}
