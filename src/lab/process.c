/* SPDX-License-Identifier: GPL-3.0-or-later
 * process.c - running another program without a shell, so that no path needs quoting.
 */
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "inner.h"

extern char **environ;

static int spawn_logged(char *const argv[], const char *log, pid_t *child)
{
    posix_spawn_file_actions_t actions;
    int cause = posix_spawn_file_actions_init(&actions);
    if (cause != 0) {
        return cause;
    }
    cause = posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (cause == 0) {
        cause = posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log,
                                                 O_WRONLY | O_CREAT | O_TRUNC, 0666);
    }
    if (cause == 0) {
        cause = posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    }
    if (cause == 0) {
        cause = posix_spawnp(child, argv[0], &actions, NULL, argv, environ);
    }
    posix_spawn_file_actions_destroy(&actions);
    return cause;
}

stein_status lab__spawn(char *const argv[], const char *log, int *code, stein_err *err)
{
    pid_t child = 0;
    int cause = spawn_logged(argv, log, &child);
    if (cause == ENOENT || cause == ENOTDIR) {
        *code = 127;
        return STEIN_OK;
    }
    if (cause != 0) {
        return lab__fail(err, STEIN_EIO, "%s cannot be started: %s", argv[0], strerror(cause));
    }
    int state = 0;
    while (waitpid(child, &state, 0) < 0) {
        if (errno != EINTR) {
            return lab__fail(err, STEIN_EIO, "%s got lost: %s", argv[0], strerror(errno));
        }
    }
    *code = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
    return STEIN_OK;
}
