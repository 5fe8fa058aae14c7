/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_formats.c - records for NumPy and MATLAB, read back by readers in this file, which are
 * written after the published formats.
 */
#include <stdint.h>

#include "lab_support.h"

enum { ROWS = 101, CHANNELS = 7 };

static const char *const notes[] = {"model: pendulum", "drive: \xc3\xa9tude.csv", NULL};

/* a swing, and each number of it */
static lab_record *swing(double cell[ROWS][CHANNELS])
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 1e-3);
    lab_record *record = NULL;
    ck_assert_stein(lab_record_create(&record, &stein_model_pendulum, 0.0, err));
    for (int row = 0; row < ROWS; row++) {
        ck_assert_int_eq(lab_record_sample(record, sim), STEIN_OK);
        for (int i = 0; i < CHANNELS; i++) {
            cell[row][i] = stein_read(sim, i);
        }
        ck_assert_stein(stein_step(sim, err));
    }
    stein_sim_destroy(sim);
    return record;
}

static const unsigned char *load(const char *path, size_t *size)
{
    char *text = NULL;
    ck_assert_stein(lab__read_file(path, &text, size, err));
    return (const unsigned char *)text;
}

static uint64_t number(const unsigned char *at, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes - 1; i >= 0; i--) {
        value = value << 8 | at[i];
    }
    return value;
}

static double real(const unsigned char *at)
{
    uint64_t bits = number(at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

START_TEST(numpy_reads_every_channel_by_name_to_the_last_bit)
{
    double cell[ROWS][CHANNELS];
    lab_record *record = swing(cell);
    size_t size;
    ck_assert_stein(lab_write(in_folder("s.npy"), LAB_NPY, record, notes, err));
    const unsigned char *file = load(in_folder("s.npy"), &size);
    ck_assert_int_eq(memcmp(file, "\x93NUMPY\x01\x00", 8), 0);
    size_t length = number(file + 8, 2), begin = 10 + length;
    ck_assert_uint_eq(begin % 64, 0);
    ck_assert_int_eq(file[begin - 1], '\n');
    char head[2000];
    ck_assert_uint_lt(length, sizeof head);
    memcpy(head, file + 10, length);
    head[length - 1] = '\0';
    ck_assert_ptr_nonnull(strstr(head, "'fortran_order': False"));
    ck_assert_ptr_nonnull(strstr(head, "'shape': (101,)"));
    const char *at = head;
    for (int i = 0; i < CHANNELS; i++) { // fields in the order of the channels
        char field[80];
        snprintf(field, sizeof field, "('%s', '<f8')", stein_model_pendulum.channels[i].name);
        at = strstr(at, field);
        ck_assert_msg(at != NULL, "%s is not in %s", field, head);
    }
    ck_assert_uint_eq(size, begin + 8 * ROWS * CHANNELS);
    for (int row = 0; row < ROWS; row++) {
        for (int i = 0; i < CHANNELS; i++) {
            ck_assert(real(file + begin + 8 * (row * CHANNELS + i)) == cell[row][i]);
        }
    }
    free((void *)(uintptr_t)file);
    lab_record_destroy(record);
}
END_TEST

/* an element of a level 5 file, in its long or short form */
typedef struct element {
    uint64_t type, bytes;
    const unsigned char *data, *next;
} element;

static element element_at(const unsigned char *at, const unsigned char *end)
{
    ck_assert(end - at >= 8);
    element e = {.type = number(at, 4)};
    if (e.type >> 16 != 0) {
        e = (element){e.type & 0xffff, e.type >> 16, at + 4, at + 8};
        ck_assert_uint_le(e.bytes, 4);
        return e;
    }
    e.bytes = number(at + 4, 4);
    ck_assert_uint_le(e.bytes, (uint64_t)(end - at - 8));
    e.data = at + 8;
    e.next = at + 8 + (e.bytes + 7) / 8 * 8;
    return e;
}

/* what stands before the values of a matrix */
typedef struct matrix {
    int kind;
    uint64_t rows, columns;
    char name[64];
    const unsigned char *values, *end;
} matrix;

static matrix matrix_at(element e)
{
    matrix m = {.end = e.data + e.bytes};
    ck_assert_uint_eq(e.type, 14);
    element flags = element_at(e.data, m.end), size = element_at(flags.next, m.end),
            name = element_at(size.next, m.end);
    ck_assert(flags.type == 6 && flags.bytes == 8 && size.type == 5 && size.bytes == 8);
    ck_assert(name.type == 1 && name.bytes < sizeof m.name);
    m.kind = (int)(flags.data[0]);
    m.rows = number(size.data, 4);
    m.columns = number(size.data + 4, 4);
    memcpy(m.name, name.data, name.bytes);
    m.values = name.next;
    return m;
}

static void text_is(matrix m, const char *text)
{
    element e = element_at(m.values, m.end);
    ck_assert(m.kind == 4 && e.type == 4 && m.rows == 1);
    ck_assert_uint_eq(m.columns, strlen(text));
    ck_assert_uint_eq(e.bytes, 2 * strlen(text));
    for (size_t i = 0; i < strlen(text); i++) {
        ck_assert_uint_eq(number(e.data + 2 * i, 2), (unsigned char)text[i]);
    }
}

static void units_are(matrix m)
{
    ck_assert(m.kind == 2 && m.rows == 1 && m.columns == 1);
    element width = element_at(m.values, m.end), names = element_at(width.next, m.end);
    uint64_t room = number(width.data, 4);
    ck_assert(width.type == 5 && names.type == 1 && names.bytes == CHANNELS * room);
    const unsigned char *at = names.next;
    for (int i = 0; i < CHANNELS; i++) {
        const stein_channel *c = &stein_model_pendulum.channels[i];
        ck_assert_str_eq((const char *)names.data + (size_t)i * room, c->name);
        element e = element_at(at, m.end);
        text_is(matrix_at(e), c->unit);
        at = e.next;
    }
    ck_assert_ptr_eq(at, m.end);
}

START_TEST(matlab_reads_columns_units_and_notes)
{
    double cell[ROWS][CHANNELS];
    lab_record *record = swing(cell);
    size_t size;
    ck_assert_stein(lab_write(in_folder("s.mat"), LAB_MAT, record, notes, err));
    const unsigned char *file = load(in_folder("s.mat"), &size), *at = file + 128,
                        *end = file + size;
    ck_assert_int_eq(memcmp(file, "MATLAB 5.0 MAT-file", 19), 0);
    ck_assert(number(file + 124, 2) == 0x0100 && file[126] == 'I' && file[127] == 'M');
    for (int i = 0; i < CHANNELS; i++) {
        element e = element_at(at, end);
        matrix m = matrix_at(e);
        element values = element_at(m.values, m.end);
        ck_assert_str_eq(m.name, stein_model_pendulum.channels[i].name);
        ck_assert(m.kind == 6 && m.rows == ROWS && m.columns == 1 && values.type == 9);
        ck_assert_uint_eq(values.bytes, 8 * ROWS);
        ck_assert_ptr_eq(values.next, m.end);
        for (int row = 0; row < ROWS; row++) {
            ck_assert(real(values.data + 8 * row) == cell[row][i]);
        }
        at = e.next;
    }
    element units = element_at(at, end), text = element_at(units.next, end);
    ck_assert_str_eq(matrix_at(units).name, "units");
    units_are(matrix_at(units));
    ck_assert_str_eq(matrix_at(text).name, "notes");
    text_is(matrix_at(text), "model: pendulum\ndrive: ??tude.csv\n");
    ck_assert_ptr_eq(text.next, end);
    free((void *)(uintptr_t)file);
    lab_record_destroy(record);
}
END_TEST

START_TEST(forms_follow_from_endings_and_full_disks_are_reported)
{
    double cell[ROWS][CHANNELS];
    lab_record *record = swing(cell);
    stein_err told = {STEIN_OK, ""};
    ck_assert_int_eq(lab_format_of("a.npy"), LAB_NPY);
    ck_assert_int_eq(lab_format_of("b/.c.mat"), LAB_MAT);
    ck_assert_int_eq(lab_format_of("mat"), LAB_CSV);
    ck_assert_int_eq(lab_format_of(".npy"), LAB_CSV);
    ck_assert_int_eq(lab_format_of("a.csv"), LAB_CSV);
    for (int form = LAB_CSV; form <= LAB_CSV_PLAIN; form++) {
        ck_assert_int_eq(lab_write("/dev/full", (lab_format)form, record, notes, &told), STEIN_EIO);
        ck_assert_ptr_nonnull(strstr(told.msg, "/dev/full"));
        ck_assert_int_eq(lab_write(in_folder("no/s"), (lab_format)form, record, notes, &told),
                         STEIN_EIO);
    }
    ck_assert_stein(lab_write(in_folder("a"), LAB_CSV, record, notes, err));
    ck_assert_stein(lab_write_csv(in_folder("b"), record, notes, err));
    size_t size[2];
    const unsigned char *a = load(in_folder("a"), &size[0]), *b = load(in_folder("b"), &size[1]);
    ck_assert(size[0] == size[1] && memcmp(a, b, size[0]) == 0);
    free((void *)(uintptr_t)a);
    free((void *)(uintptr_t)b);
    lab_record_destroy(record);
}
END_TEST

Suite *formats_suite(void)
{
    Suite *s = suite_create("formats");
    TCase *t = tcase_create("formats");
    tcase_add_checked_fixture(t, make_folder, remove_folder);
    tcase_add_test(t, numpy_reads_every_channel_by_name_to_the_last_bit);
    tcase_add_test(t, matlab_reads_columns_units_and_notes);
    tcase_add_test(t, forms_follow_from_endings_and_full_disks_are_reported);
    suite_add_tcase(s, t);
    return s;
}
