/* SPDX-License-Identifier: GPL-3.0-or-later
 * process.c - running another program without a shell, so that no path needs quoting.
 */
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io.h"

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

/* ---- command lines ---- */

void lab__command_add(lab__command *words, char *word)
{
    size_t size = ((size_t)words->n + 2) * sizeof *words->word;
    char **grown = word != NULL ? realloc(words->word, size) : NULL;
    if (grown == NULL) {
        words->failed = 1;
        free(word);
        return;
    }
    words->word = grown;
    words->word[words->n++] = word;
    words->word[words->n] = NULL;
}

void lab__command_split(lab__command *words, const char *text)
{
    for (text += strspn(text, " "); *text != '\0'; text += strspn(text, " ")) {
        size_t n = strcspn(text, " ");
        lab__command_add(words, strndup(text, n));
        text += n;
    }
}

stein_status lab__command_run(lab__command *words, const char *log, int *code, stein_err *err)
{
    stein_status status = words->failed || words->n == 0 ? lab__no_memory(err)
                                                         : lab__spawn(words->word, log, code, err);
    for (int i = 0; i < words->n; i++) {
        free(words->word[i]);
    }
    free(words->word);
    *words = (lab__command){0};
    return status;
}

void lab__first_error(const char *log, char *text, int size)
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
