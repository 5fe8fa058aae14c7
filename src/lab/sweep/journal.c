/* SPDX-License-Identifier: GPL-3.0-or-later
 * journal.c - finished points of a sweep in a file that survives the end of the program at any
 * time.
 *
 *   # stein-journal 1 *8d1f02c4             every line ends with the CRC-32 of what is before " *"
 *   # stein: 0.1.0 *1c53a0e9                the head of the table
 *   point,pawl.stop_shift [m],... *77e0b2a1
 *   3,-0.0009,ok,struck,... *5be31f0d       a row for every finished point, in any order
 *
 * A row is added by a single write() of the whole line in append mode. A killed program therefore
 * leaves complete lines and at most one torn line at the end, without newline, which is cut off
 * before more is added. A line with a wrong checksum is ignored: its point is computed again.
 * Nothing is ever rewritten in place, and only one process at a time may add (a record lock, which
 * the system takes back whatever happens to the process). The head of another sweep is refused.
 * Not covered: loss of power, for which every point would need an fsync.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sweep.h"

static const char *const magic = "# stein-journal 1";
enum { SUM = 10 }; /* " *xxxxxxxx" */

/* ---- lines ---- */

/* CRC-32 (IEEE 802.3), four bits at a time */
static unsigned long crc32(const char *text, size_t n)
{
    static const unsigned long table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac,
                                            0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                            0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                            0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    unsigned long crc = 0xffffffffu;
    for (size_t i = 0; i < n; i++) {
        crc ^= (unsigned char)text[i];
        crc = crc >> 4 ^ table[crc & 15u];
        crc = crc >> 4 ^ table[crc & 15u];
    }
    return crc ^ 0xffffffffu;
}

/* "TEXT *CRC\n", owned */
static char *sealed(const char *text, size_t n)
{
    return lab__text("%.*s *%08lx\n", (int)n, text, crc32(text, n));
}

/* characters of the text in a line without its newline, -1 when the checksum is wrong */
static long opened(const char *line, size_t n)
{
    char sum[SUM + 1];
    if (n < SUM) {
        return -1;
    }
    snprintf(sum, sizeof sum, " *%08lx", crc32(line, n - SUM));
    return memcmp(line + n - SUM, sum, SUM) == 0 ? (long)(n - SUM) : -1;
}

/* the head as it stands at the start of a journal, owned */
static char *sealed_head(const char *head)
{
    char *all = sealed(magic, strlen(magic));
    while (all != NULL && *head != '\0') {
        size_t n = strcspn(head, "\n");
        char *line = sealed(head, n), *longer = line == NULL ? NULL : lab__text("%s%s", all, line);
        free(line);
        free(all);
        all = longer;
        head += n + (head[n] == '\n');
    }
    return all;
}

/* ---- reading ---- */

typedef struct content {
    char *text;
    size_t size; /* bytes */
    size_t rows; /* where the rows begin */
    char *head;  /* of the table, NULL when the file has no whole one */
} content;

static void free_content(content *c)
{
    free(c->text);
    free(c->head);
}

static stein_status io_error(stein_err *err, const char *path, const char *what, int cause)
{
    lab__fail(err, STEIN_EIO, "%s cannot be %s: %s", path, what, strerror(cause));
    return STEIN_EIO;
}

static stein_status read_all(int fd, const char *path, content *c, stein_err *err)
{
    size_t room = 0;
    *c = (content){NULL, 0, 0, NULL};
    for (;;) {
        if (c->size + 1 >= room) {
            room = room == 0 ? 65536 : 2 * room;
            char *larger = realloc(c->text, room);
            if (larger == NULL) {
                return lab__no_memory(err);
            }
            c->text = larger;
        }
        ssize_t got = read(fd, c->text + c->size, room - c->size - 1);
        if (got == 0) {
            c->text[c->size] = '\0';
            return STEIN_OK;
        }
        if (got < 0 && errno != EINTR) {
            return io_error(err, path, "read", errno);
        }
        c->size += got > 0 ? (size_t)got : 0;
    }
}

/* the table's head from the lines before the rows; stays NULL when a line is not whole */
static stein_status read_head(content *c, stein_err *err)
{
    size_t used = 0;
    char *head = malloc(c->size + 1);
    if (head == NULL) {
        return lab__no_memory(err);
    }
    for (size_t at = 0; at < c->size;) {
        const char *line = c->text + at, *end = memchr(line, '\n', c->size - at);
        long n = end == NULL ? -1 : opened(line, (size_t)(end - line));
        int first = at == 0;
        if (n < 0 ||
            (first && (strlen(magic) != (size_t)n || memcmp(line, magic, (size_t)n) != 0))) {
            break;
        }
        at += (size_t)(end - line) + 1;
        if (first) {
            continue;
        }
        memcpy(head + used, line, (size_t)n);
        head[used + (size_t)n] = '\n';
        used += (size_t)n + 1;
        if (*line != '#') { // the line of columns is the last one
            head[used] = '\0';
            c->head = head;
            c->rows = at;
            return STEIN_OK;
        }
    }
    free(head);
    return STEIN_OK;
}

/* rows into the table; *whole: bytes up to the end of the last whole line */
static stein_status read_rows(const content *c, const char *path, lab_table *table, size_t *whole,
                              int *damaged, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    *whole = c->rows;
    while (*whole < c->size) {
        const char *line = c->text + *whole, *end = memchr(line, '\n', c->size - *whole);
        if (end == NULL) {
            return STEIN_OK; // torn
        }
        long n = opened(line, (size_t)(end - line));
        stein_status status = n < 0 ? STEIN_EPARSE : lab__table_take(table, line, (size_t)n, &why);
        if (status != STEIN_OK && status != STEIN_EPARSE) {
            return lab__fail(err, status, "%s: %s", path, why.msg);
        }
        if (damaged != NULL) {
            *damaged += status == STEIN_EPARSE;
        }
        *whole += (size_t)(end - line) + 1;
    }
    return STEIN_OK;
}

/* which line of two heads differs first */
static stein_status other_sweep(const char *path, const char *there, const char *here,
                                stein_err *err)
{
    size_t a = strcspn(there, "\n"), b = strcspn(here, "\n");
    while (a == b && a > 0 && strncmp(there, here, a) == 0) {
        there += a + (there[a] == '\n');
        here += b + (here[b] == '\n');
        a = strcspn(there, "\n");
        b = strcspn(here, "\n");
    }
    return lab__fail(err, STEIN_ESTALE,
                     "%.80s belongs to another sweep: there \"%.*s\", here \"%.*s\"", path,
                     a < 60 ? (int)a : 60, there, b < 60 ? (int)b : 60, here);
}

static stein_status no_journal(const char *path, const content *c, stein_err *err)
{
    int ours = c->size >= 15 && memcmp(c->text, magic, 15) == 0;
    lab__fail(err, STEIN_EPARSE,
              ours ? "%s: the head of this journal is damaged" : "%s is no journal of a sweep",
              path);
    return STEIN_EPARSE;
}

stein_status lab__journal_read(lab_table **table, const char *path, int *damaged, stein_err *err)
{
    content c;
    struct stat st;
    size_t whole;
    lab_table *made = NULL;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &st) != 0 || S_ISDIR(st.st_mode)) {
        int cause = fd < 0 ? errno : EISDIR;
        if (fd >= 0) {
            close(fd);
        }
        return io_error(err, path, "read", cause);
    }
    stein_status status = read_all(fd, path, &c, err);
    close(fd);
    if (status == STEIN_OK) {
        status = read_head(&c, err);
    }
    if (status == STEIN_OK && c.head == NULL) {
        status = no_journal(path, &c, err);
    }
    if (status == STEIN_OK && *table == NULL) {
        status = lab__table_new(&made, c.head, err);
    } else if (status == STEIN_OK && strcmp((*table)->head, c.head) != 0) {
        status = other_sweep(path, c.head, (*table)->head, err);
    }
    if (status == STEIN_OK) {
        *table = made != NULL ? made : *table;
        status = read_rows(&c, path, *table, &whole, damaged, err);
    }
    free_content(&c);
    return status;
}

/* ---- writing ---- */

/* one write; an incomplete write is a failure */
static stein_status append(int fd, const char *path, const char *text, size_t n, stein_err *err)
{
    ssize_t done = write(fd, text, n);
    while (done < 0 && errno == EINTR) {
        done = write(fd, text, n);
    }
    if (done >= 0 && (size_t)done < n) {
        return io_error(err, path, "written", ENOSPC);
    }
    return done < 0 ? io_error(err, path, "written", errno) : STEIN_OK;
}

static stein_status cut(int fd, const char *path, size_t size, stein_err *err)
{
    return ftruncate(fd, (off_t)size) == 0 ? STEIN_OK : io_error(err, path, "written", errno);
}

/* continue the present journal, or begin */
static stein_status take_up(const lab__journal *j, const content *c, lab_table *table, int *damaged,
                            stein_err *err)
{
    size_t whole = 0;
    if (c->head != NULL && strcmp(c->head, table->head) != 0) {
        return other_sweep(j->path, c->head, table->head, err);
    }
    if (c->head != NULL) {
        stein_status status = read_rows(c, j->path, table, &whole, damaged, err);
        return status == STEIN_OK && whole < c->size ? cut(j->fd, j->path, whole, err) : status;
    }
    char *head = sealed_head(table->head);
    if (head == NULL) {
        return lab__no_memory(err);
    }
    // only the torn beginning of our own head may be thrown away
    int ours = c->size == 0 || (c->size < strlen(head) && memcmp(c->text, head, c->size) == 0);
    stein_status status = ours ? STEIN_OK : no_journal(j->path, c, err);
    if (status == STEIN_OK && c->size > 0) {
        status = cut(j->fd, j->path, 0, err);
    }
    if (status == STEIN_OK) {
        status = append(j->fd, j->path, head, strlen(head), err);
    }
    free(head);
    return status;
}

static stein_status lock(const lab__journal *j, stein_err *err)
{
    struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (fcntl(j->fd, F_SETLK, &whole) == 0 || (errno != EACCES && errno != EAGAIN)) {
        return STEIN_OK; // a file system without locks is used without
    }
    return lab__fail(err, STEIN_EIO, "%s is in use by another process: give each its own journal",
                     j->path);
}

stein_status lab__journal_open(lab__journal *out, const char *path, lab_table *table, int *damaged,
                               stein_err *err)
{
    struct stat st = {.st_mode = 0};
    content c = {NULL, 0, 0, NULL};
    lab__journal j = {open(path, O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0666),
                      lab__text("%s", path)};
    stein_status status = STEIN_OK;
    if (j.path == NULL) {
        status = lab__no_memory(err);
    } else if (j.fd < 0 || fstat(j.fd, &st) != 0) {
        status = io_error(err, path, "written", errno);
    } else {
        status = lock(&j, err);
    }
    if (status == STEIN_OK && S_ISREG(st.st_mode)) { // a device has nothing to go on with
        status = read_all(j.fd, path, &c, err);
        status = status == STEIN_OK ? read_head(&c, err) : status;
    }
    if (status == STEIN_OK) {
        status = take_up(&j, &c, table, damaged, err);
    }
    free_content(&c);
    if (status != STEIN_OK) {
        lab__journal_close(&j);
        return status;
    }
    *out = j;
    return STEIN_OK;
}

stein_status lab__journal_add(const lab__journal *j, const char *row, stein_err *err)
{
    char *line = sealed(row, strlen(row));
    if (line == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = append(j->fd, j->path, line, strlen(line), err);
    free(line);
    return status;
}

void lab__journal_close(lab__journal *j)
{
    if (j->fd >= 0) {
        close(j->fd);
    }
    free(j->path);
    *j = (lab__journal){-1, NULL};
}
