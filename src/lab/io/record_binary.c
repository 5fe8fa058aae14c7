/* SPDX-License-Identifier: GPL-3.0-or-later
 * record_binary.c - records as NumPy and as MATLAB files, little-endian on every machine.
 *
 * .npy, version 1.0: one line of Python that describes the rows, then the rows. Channels are the
 * fields of a structured array, r["time"].
 *
 * .mat, level 5, not compressed: every channel a separate column, `units` a struct with a text
 * for each channel, `notes` a text of "name: value" lines. An element is a tag (type, bytes), its
 * data, and zeros up to a multiple of 8.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "io.h"

enum { NPY_ALIGN = 64, MAT_HEAD = 116, MAT_FIELD = 64, MOST_ROWS = 1 << 28 };
enum { MI_INT8 = 1, MI_UINT16 = 4, MI_INT32 = 5, MI_UINT32 = 6, MI_DOUBLE = 9, MI_MATRIX = 14 };
enum { MX_STRUCT = 2, MX_CHAR = 4, MX_DOUBLE = 6 };

static void put(FILE *f, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) {
        putc((int)(value >> (8 * i) & 0xff), f);
    }
}

static void put_double(FILE *f, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(f, bits, 8);
}

/* ---- NumPy ---- */

static char *describe(const stein_model *m, int rows)
{
    char *text = lab__text("{'descr': [");
    for (int i = 0; i < m->nchannel && text != NULL; i++) {
        char *longer = lab__text("%s('%s', '<f8'), ", text, m->channels[i].name);
        free(text);
        text = longer;
    }
    char *all = text == NULL
                    ? NULL
                    : lab__text("%s], 'fortran_order': False, 'shape': (%d,), }", text, rows);
    free(text);
    return all;
}

static stein_status write_npy(FILE *f, const lab_record *r, stein_err *err)
{
    const stein_model *m = lab__record_model(r);
    int rows = lab__record_rows(r);
    char *head = describe(m, rows);
    if (head == NULL) {
        return lab__no_memory(err);
    }
    size_t used = 10 + strlen(head) + 1, whole = (used + NPY_ALIGN - 1) / NPY_ALIGN * NPY_ALIGN;
    fwrite("\x93NUMPY\x01\x00", 1, 8, f);
    put(f, whole - 10, 2);
    fprintf(f, "%s%*s\n", head, (int)(whole - used), "");
    free(head);
    for (int row = 0; row < rows; row++) {
        for (int i = 0; i < m->nchannel; i++) {
            put_double(f, lab__record_at(r, row, i));
        }
    }
    return STEIN_OK;
}

/* ---- MATLAB ---- */

static size_t padded(size_t bytes)
{
    return (bytes + 7) / 8 * 8;
}

static void tag(FILE *f, unsigned type, size_t bytes)
{
    put(f, type, 4);
    put(f, bytes, 4);
}

static void pad(FILE *f, size_t bytes)
{
    put(f, 0, (int)(padded(bytes) - bytes));
}

/* bytes of what stands before the values of a matrix: flags, size, name */
static size_t before_values(const char *name)
{
    return 16 + 16 + 8 + padded(strlen(name));
}

static void begin_matrix(FILE *f, unsigned kind, const char *name, size_t rows, size_t columns,
                         size_t bytes)
{
    tag(f, MI_MATRIX, before_values(name) + bytes);
    tag(f, MI_UINT32, 8);
    put(f, kind, 8);
    tag(f, MI_INT32, 8);
    put(f, rows, 4);
    put(f, columns, 4);
    tag(f, MI_INT8, strlen(name));
    fputs(name, f);
    pad(f, strlen(name));
}

static size_t text_bytes(const char *text)
{
    return 8 + padded(2 * strlen(text));
}

static void put_text(FILE *f, const char *name, const char *text)
{
    size_t n = strlen(text);
    begin_matrix(f, MX_CHAR, name, n > 0, n, text_bytes(text));
    tag(f, MI_UINT16, 2 * n);
    for (size_t i = 0; i < n; i++) {
        put(f, (unsigned char)text[i] < 128 ? (unsigned char)text[i] : '?', 2);
    }
    pad(f, 2 * n);
}

static void put_channel(FILE *f, const lab_record *r, int channel)
{
    size_t rows = (size_t)lab__record_rows(r);
    begin_matrix(f, MX_DOUBLE, lab__record_model(r)->channels[channel].name, rows, 1, 8 + 8 * rows);
    tag(f, MI_DOUBLE, 8 * rows);
    for (int row = 0; row < (int)rows; row++) {
        put_double(f, lab__record_at(r, row, channel));
    }
}

static void put_units(FILE *f, const char *name, const stein_model *m)
{
    size_t names = (size_t)m->nchannel * MAT_FIELD, bytes = 8 + 8 + names;
    for (int i = 0; i < m->nchannel; i++) {
        bytes += 8 + before_values("") + text_bytes(m->channels[i].unit);
    }
    begin_matrix(f, MX_STRUCT, name, 1, 1, bytes);
    put(f, MI_INT32 | 4 << 16, 4); // the short form of an element
    put(f, MAT_FIELD, 4);
    tag(f, MI_INT8, names);
    for (int i = 0; i < m->nchannel; i++) {
        char field[MAT_FIELD] = "";
        strncpy(field, m->channels[i].name, sizeof field - 1);
        fwrite(field, 1, sizeof field, f);
    }
    for (int i = 0; i < m->nchannel; i++) {
        put_text(f, "", m->channels[i].unit);
    }
}

static char *join(const char *const *notes)
{
    char *text = lab__text("%s", "");
    for (int i = 0; notes != NULL && notes[i] != NULL && text != NULL; i++) {
        char *longer = lab__text("%s%s\n", text, notes[i]);
        free(text);
        text = longer;
    }
    return text;
}

/* a name that no channel has */
static const char *free_name(const stein_model *m, const char *name, const char *otherwise)
{
    return stein_find_channel(m, name) < 0 ? name : otherwise;
}

static stein_status write_mat(FILE *f, const lab_record *r, const char *const *notes,
                              stein_err *err)
{
    const stein_model *m = lab__record_model(r);
    char *text = join(notes);
    if (text == NULL) {
        return lab__no_memory(err);
    }
    fprintf(f, "%-*.*s", MAT_HEAD, MAT_HEAD, "MATLAB 5.0 MAT-file, written by libstein");
    put(f, 0, 8);
    put(f, 0x0100, 2);
    fputs("IM", f);
    for (int i = 0; i < m->nchannel; i++) {
        put_channel(f, r, i);
    }
    put_units(f, free_name(m, "units", "units_"), m);
    put_text(f, free_name(m, "notes", "notes_"), text);
    free(text);
    return STEIN_OK;
}

stein_status lab_write(const char *path, lab_format format, const lab_record *record,
                       const char *const *notes, stein_err *err)
{
    lab__file file;
    if (format == LAB_CSV) {
        return lab_write_csv(path, record, notes, err);
    }
    if (format == LAB_CSV_PLAIN) {
        return lab__write_csv_plain(path, record, err);
    }
    if (lab__record_rows(record) > MOST_ROWS) {
        return lab__fail(err, STEIN_EINVAL, "%d rows, but a file takes %d: sample less often",
                         lab__record_rows(record), (int)MOST_ROWS);
    }
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    status = format == LAB_NPY ? write_npy(file.stream, record, err)
                               : write_mat(file.stream, record, notes, err);
    stein_status closed = lab__file_close(&file, status == STEIN_OK, err);
    return status == STEIN_OK ? closed : status;
}

lab_format lab_format_of(const char *path)
{
    size_t n = strlen(path);
    const char *end = n > 4 ? path + n - 4 : "";
    return strcmp(end, ".npy") == 0 ? LAB_NPY : strcmp(end, ".mat") == 0 ? LAB_MAT : LAB_CSV;
}
