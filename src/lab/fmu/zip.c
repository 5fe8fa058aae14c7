/* SPDX-License-Identifier: GPL-3.0-or-later
 * zip.c - an archive in memory: ZIP (PKWARE's APPNOTE, version 2.0) around zlib's deflate.
 *
 *      header | bytes    for every file        directory: an entry for every file | end
 *
 * The same files give the same bytes: the earliest time of ZIP, no attributes, files in the order
 * in which they are added. (Debian's libraries for archives either bring a dozen others, or, like
 * minizip 1.1, end the program when memory does.)
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "fmu.h"

typedef struct buffer {
    unsigned char *bytes;
    size_t size, room;
} buffer;

struct fmu_zip {
    buffer files, directory;
    unsigned n;
    int failed;
};

enum {
    FILE_MARK = 0x04034b50,
    ENTRY_MARK = 0x02014b50,
    END_MARK = 0x06054b50,
    VERSION = 20, /* 2.0 */
    STORED = 0,
    DEFLATED = 8,
    FIRST_DATE = 0x0021, /* 1980-01-01 */
    RAW = -15,           /* window bits: deflate without a header */
    MEMORY_LEVEL = 8
};
static const size_t most = 0x7fffffff; /* sizes are of 32 bits */

/* ---- a buffer ---- */

/* room for n bytes more. @return where they go, NULL without memory */
static unsigned char *reserve(fmu_zip *z, buffer *b, size_t n)
{
    z->failed |= n > most || b->size > most - n;
    if (!z->failed && b->size + n > b->room) {
        size_t room = 2 * (b->size + n);
        unsigned char *more = realloc(b->bytes, room);
        z->failed = more == NULL;
        if (more != NULL) {
            b->bytes = more;
            b->room = room;
        }
    }
    return z->failed ? NULL : b->bytes + b->size;
}

static void put(fmu_zip *z, buffer *b, const void *bytes, size_t n)
{
    unsigned char *at = reserve(z, b, n);
    if (at != NULL && n > 0) {
        memcpy(at, bytes, n);
        b->size += n;
    }
}

/* a number of so many bytes, the lowest first */
static void put_number(fmu_zip *z, buffer *b, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) {
        unsigned char byte = (unsigned char)(value >> 8 * i & 0xffu);
        put(z, b, &byte, 1);
    }
}

/* ---- files ---- */

/* common fields of header and directory */
typedef struct entry {
    uint32_t method, sum, packed, size;
} entry;

static void put_entry(fmu_zip *z, buffer *b, const entry *e, const char *name)
{
    put_number(z, b, VERSION, 2); // needed to extract it
    put_number(z, b, 0, 2);       // flags
    put_number(z, b, e->method, 2);
    put_number(z, b, 0, 2); // time
    put_number(z, b, FIRST_DATE, 2);
    put_number(z, b, e->sum, 4);
    put_number(z, b, e->packed, 4);
    put_number(z, b, e->size, 4);
    put_number(z, b, (uint32_t)strlen(name), 2);
    put_number(z, b, 0, 2); // extra field
}

/* the bytes as zlib packs them. @return NULL without memory */
static unsigned char *packed(const void *bytes, size_t size, size_t *n)
{
    z_stream s;
    memset(&s, 0, sizeof s);
    if (deflateInit2(&s, Z_BEST_COMPRESSION, Z_DEFLATED, RAW, MEMORY_LEVEL, Z_DEFAULT_STRATEGY) !=
        Z_OK) {
        return NULL;
    }
    size_t room = deflateBound(&s, (uLong)size);
    unsigned char *to = malloc(room);
    int done = 0;
    if (to != NULL) {
        s.next_in = (z_const Bytef *)(uintptr_t)bytes;
        s.avail_in = (uInt)size;
        s.next_out = to;
        s.avail_out = (uInt)room;
        done = deflate(&s, Z_FINISH) == Z_STREAM_END;
        *n = s.total_out;
    }
    deflateEnd(&s);
    if (!done) {
        free(to);
        return NULL;
    }
    return to;
}

void fmu__zip_add(fmu_zip *z, const char *name, const void *bytes, size_t size)
{
    size_t n = 0;
    unsigned char *small = NULL;
    z->failed |= name == NULL || bytes == NULL || size > most;
    if (!z->failed) {
        small = packed(bytes, size, &n);
        z->failed = small == NULL;
    }
    if (z->failed) {
        return;
    }
    int gains = n < size;
    entry e = {gains ? DEFLATED : STORED, (uint32_t)crc32(crc32(0, NULL, 0), bytes, (uInt)size),
               (uint32_t)(gains ? n : size), (uint32_t)size};
    size_t offset = z->files.size;
    put_number(z, &z->files, FILE_MARK, 4);
    put_entry(z, &z->files, &e, name);
    put(z, &z->files, name, strlen(name));
    put(z, &z->files, gains ? small : bytes, e.packed);

    put_number(z, &z->directory, ENTRY_MARK, 4);
    put_number(z, &z->directory, VERSION, 2); // made by, with DOS's attributes
    put_entry(z, &z->directory, &e, name);
    put_number(z, &z->directory, 0, 2); // comment
    put_number(z, &z->directory, 0, 2); // disk
    put_number(z, &z->directory, 0, 2); // attributes
    put_number(z, &z->directory, 0, 4);
    put_number(z, &z->directory, (uint32_t)offset, 4);
    put(z, &z->directory, name, strlen(name));
    z->n++;
    free(small);
}

/* ---- the archive ---- */

stein_status fmu__zip_create(fmu_zip **out, stein_err *err)
{
    fmu_zip *z = calloc(1, sizeof *z);
    if (z == NULL) {
        return lab__no_memory(err);
    }
    *out = z;
    return STEIN_OK;
}

stein_status fmu__zip_write(fmu_zip *z, const char *path, size_t *bytes, stein_err *err)
{
    lab__file file;
    buffer *b = &z->files;
    uint32_t at = (uint32_t)b->size, size = (uint32_t)z->directory.size;
    put(z, b, z->directory.bytes, z->directory.size);
    put_number(z, b, END_MARK, 4);
    put_number(z, b, 0, 2); // this disk and the directory's disk
    put_number(z, b, 0, 2);
    put_number(z, b, z->n, 2);
    put_number(z, b, z->n, 2);
    put_number(z, b, size, 4);
    put_number(z, b, at, 4);
    put_number(z, b, 0, 2); // comment
    if (z->failed) {
        return lab__no_memory(err);
    }
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    fwrite(b->bytes, 1, b->size, file.stream);
    *bytes = b->size;
    return lab__file_close(&file, 1, err);
}

void fmu__zip_destroy(fmu_zip *z)
{
    if (z != NULL) {
        free(z->files.bytes);
        free(z->directory.bytes);
        free(z);
    }
}
