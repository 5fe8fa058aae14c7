/* SPDX-License-Identifier: GPL-3.0-or-later
 * zip.c - an archive in memory, by minizip.
 *
 * The same files give the same bytes: no time but the first one that a ZIP can tell, no attributes,
 * files in the order in which they are added. Memory and not a file, because a ZIP is written to
 * and fro and an FMU must appear whole or not at all (lab__file).
 */
#include <stdlib.h>
#include <string.h>

#include <minizip/zip.h>

#include "fmu.h"

struct fmu_zip {
    unsigned char *bytes;
    size_t size, room, at;
    zipFile zip;
    int failed;
};

static const uLong first_date = 0x00210000; /* 1980-01-01 0:00 */
enum { MEMORY_LEVEL = 8, WINDOW_BITS = -15 };

/* ---- a file of minizip's that is memory: `stream` is the archive ---- */

static voidpf open_memory(voidpf zip, const void *name, int mode)
{
    (void)name, (void)mode;
    return zip;
}

static uLong read_memory(voidpf opaque, voidpf stream, void *to, uLong n)
{
    fmu_zip *z = stream;
    (void)opaque;
    size_t most = z->at < z->size ? z->size - z->at : 0;
    n = n < most ? n : (uLong)most;
    memcpy(to, z->bytes + z->at, n);
    z->at += n;
    return n;
}

static int grow(fmu_zip *z, size_t size)
{
    if (size > z->room) {
        size_t room = 2 * size + 65536;
        unsigned char *more = realloc(z->bytes, room);
        if (more == NULL) {
            return 0;
        }
        z->bytes = more;
        z->room = room;
    }
    return 1;
}

static uLong write_memory(voidpf opaque, voidpf stream, const void *from, uLong n)
{
    fmu_zip *z = stream;
    (void)opaque;
    if (!grow(z, z->at + n)) {
        z->failed = 1;
        return 0;
    }
    memcpy(z->bytes + z->at, from, n);
    z->at += n;
    z->size = z->at > z->size ? z->at : z->size;
    return n;
}

static ZPOS64_T tell_memory(voidpf opaque, voidpf stream)
{
    (void)opaque;
    return ((fmu_zip *)stream)->at;
}

static long seek_memory(voidpf opaque, voidpf stream, ZPOS64_T offset, int origin)
{
    fmu_zip *z = stream;
    (void)opaque;
    size_t from = origin == ZLIB_FILEFUNC_SEEK_CUR   ? z->at
                  : origin == ZLIB_FILEFUNC_SEEK_END ? z->size
                                                     : 0;
    if (from + offset > z->size) {
        return -1;
    }
    z->at = from + (size_t)offset;
    return 0;
}

static int close_memory(voidpf opaque, voidpf stream)
{
    (void)opaque, (void)stream;
    return 0;
}

static int error_memory(voidpf opaque, voidpf stream)
{
    (void)opaque;
    return ((fmu_zip *)stream)->failed;
}

/* ---- the archive ---- */

stein_status fmu_zip_create(fmu_zip **out, stein_err *err)
{
    fmu_zip *z = calloc(1, sizeof *z);
    zlib_filefunc64_def memory = {open_memory, read_memory,  write_memory, tell_memory,
                                  seek_memory, close_memory, error_memory, z};
    z = z != NULL && grow(z, 1) ? z : NULL;
    if (z != NULL) {
        z->zip = zipOpen2_64("", APPEND_STATUS_CREATE, NULL, &memory);
    }
    if (z == NULL || z->zip == NULL) {
        free(memory.opaque);
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    *out = z;
    return STEIN_OK;
}

void fmu_zip_add(fmu_zip *z, const char *name, const void *bytes, size_t size)
{
    zip_fileinfo info;
    memset(&info, 0, sizeof info);
    info.dosDate = first_date;
    z->failed = z->failed ||
                zipOpenNewFileInZip4_64(z->zip, name, &info, NULL, 0, NULL, 0, NULL, Z_DEFLATED,
                                        Z_BEST_COMPRESSION, 0, WINDOW_BITS, MEMORY_LEVEL,
                                        Z_DEFAULT_STRATEGY, NULL, 0, 0, 0, 0) != ZIP_OK ||
                zipWriteInFileInZip(z->zip, bytes, (unsigned)size) != ZIP_OK ||
                zipCloseFileInZip(z->zip) != ZIP_OK;
}

stein_status fmu_zip_write(fmu_zip *z, const char *path, size_t *bytes, stein_err *err)
{
    lab__file file;
    z->failed |= zipClose(z->zip, NULL) != ZIP_OK;
    z->zip = NULL;
    if (z->failed) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    fwrite(z->bytes, 1, z->size, file.stream);
    *bytes = z->size;
    return lab__file_close(&file, 1, err);
}

void fmu_zip_destroy(fmu_zip *z)
{
    if (z != NULL) {
        if (z->zip != NULL) {
            zipClose(z->zip, NULL);
        }
        free(z->bytes);
        free(z);
    }
}
