/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_journal.c - a journal never drops or invents a result, for any damage of its last bytes or
 * of any bit. It never accepts a foreign file.
 */
#include <sys/wait.h>

#include "lab_support.h"
#include "suites.h"

enum { ROWS = 7 };
static const char head[] = "# stein: test\n# model: none\n# vary a.b [m]: 0:0.6:7 mm\n# points: 7\n"
                           "point,a.b [m],status,height [m]\n";
static const char *const rows[ROWS] = {"0,0,ok,0.1",
                                       "1,0.0001,ok,0.30000000000000004",
                                       "2,0.0002,ESETTLE,",
                                       "3,0.0003,ok,-1e-17",
                                       "4,0.0004,ok,",
                                       "5,0.0005,ok,5",
                                       "6,0.0006,ok,123456.789"};

static lab_table *empty_table(void)
{
    lab_table *table = NULL;
    ck_assert_stein(lab__table_new(&table, head, err));
    ck_assert_int_eq(table->n, ROWS);
    return table;
}

/* all rows, or those from `first` on that are not there yet */
static void add_missing(const lab__journal *journal, lab_table *table)
{
    for (int i = 0; i < ROWS; i++) {
        if (!lab_table_has(table, i)) {
            ck_assert_stein(lab__journal_add(journal, rows[i], err));
            ck_assert_stein(lab__table_take(table, rows[i], strlen(rows[i]), err));
        }
    }
}

static void write_bytes(const char *path, const char *text, size_t size)
{
    FILE *f = fopen(path, "wb");
    ck_assert_uint_eq(fwrite(text, 1, size, f), size);
    ck_assert_int_eq(fclose(f), 0);
}

static size_t read_bytes(const char *path, char *text, size_t room)
{
    FILE *f = fopen(path, "rb");
    ck_assert_ptr_nonnull(f);
    size_t size = fread(text, 1, room - 1, f);
    fclose(f);
    text[size] = '\0';
    return size;
}

/* a journal with every row; its bytes */
static size_t full_journal(const char *path, char *text, size_t room)
{
    lab_table *table = empty_table();
    lab__journal journal;
    ck_assert_stein(lab__journal_open(&journal, path, table, NULL, err));
    add_missing(&journal, table);
    lab__journal_close(&journal);
    lab_table_destroy(table);
    return read_bytes(path, text, room);
}

static void assert_complete(const char *path)
{
    lab_table *table = NULL;
    int damaged = 0;
    ck_assert_stein(lab_merge(&table, &path, 1, &damaged, err));
    ck_assert_str_eq(table->head, head);
    for (int i = 0; i < ROWS; i++) {
        ck_assert_str_eq(table->row[i], rows[i]);
    }
    lab_table_destroy(table);
}

/* whole rows in the first `size` bytes of a full journal; -1 when the head is not whole */
static int whole_rows(const char *text, size_t size)
{
    int lines = -7; // six lines of head: the last of them makes it -1 + 1 = 0 rows
    for (size_t i = 0; i < size; i++) {
        lines += text[i] == '\n';
    }
    return lines + 1 < 0 ? -1 : lines + 1;
}

START_TEST(a_journal_cut_at_any_byte_keeps_every_whole_line)
{
    char text[2048];
    const char *path = in_folder("full"), *cut = in_folder("cut");
    size_t size = full_journal(path, text, sizeof text);
    assert_complete(path);
    for (size_t n = 0; n <= size; n++) {
        lab_table *table = empty_table();
        lab__journal journal;
        int damaged = 0, present = 0, expected = whole_rows(text, n);
        write_bytes(cut, text, n);
        ck_assert_stein(lab__journal_open(&journal, cut, table, &damaged, err));
        for (int i = 0; i < ROWS; i++) {
            present += lab_table_has(table, i);
        }
        ck_assert_msg(present == (expected < 0 ? 0 : expected), "%zu bytes: %d rows, expected %d",
                      n, present, expected);
        ck_assert_int_eq(damaged, 0);
        add_missing(&journal, table);
        lab__journal_close(&journal);
        lab_table_destroy(table);
        assert_complete(cut);
    }
}
END_TEST

START_TEST(no_flipped_bit_becomes_a_result)
{
    char text[2048], after[2048];
    const char *path = in_folder("flipped");
    size_t size = full_journal(path, text, sizeof text);
    for (size_t bit = 0; bit < 8 * size; bit++) {
        lab_table *table = empty_table();
        lab__journal journal;
        int damaged = 0;
        text[bit / 8] = (char)(text[bit / 8] ^ 1 << bit % 8);
        write_bytes(path, text, size);
        stein_status status = lab__journal_open(&journal, path, table, &damaged, NULL);
        if (status == STEIN_OK) {
            int missing = 0;
            for (int i = 0; i < ROWS; i++) {
                missing += !lab_table_has(table, i);
                ck_assert(!lab_table_has(table, i) || strcmp(table->row[i], rows[i]) == 0);
            }
            ck_assert_msg(missing == 1 || missing == 2, "bit %zu: %d missing", bit, missing);
            add_missing(&journal, table);
            lab__journal_close(&journal);
            assert_complete(path);
        } else { // in the head: refused, and nothing was touched
            ck_assert_int_eq(status, STEIN_EPARSE);
            ck_assert_uint_eq(read_bytes(path, after, sizeof after), size);
            ck_assert_mem_eq(after, text, size);
        }
        lab_table_destroy(table);
        text[bit / 8] = (char)(text[bit / 8] ^ 1 << bit % 8);
    }
}
END_TEST

START_TEST(a_file_that_is_no_journal_is_left_alone)
{
    static const char *const other[] = {"mechanism: something\n", "#", "# stein-journal 2\n", "\n",
                                        "# stein-journal 1\npoint,"};
    for (int i = 0; i < 5; i++) {
        char after[100];
        lab_table *table = empty_table();
        lab__journal journal;
        stein_err e = {STEIN_OK, ""};
        const char *path = write_file("other", other[i]);
        stein_status status = lab__journal_open(&journal, path, table, NULL, &e);
        if (i == 1) { // might be the first byte of our own
            ck_assert_int_eq(status, STEIN_OK);
            lab__journal_close(&journal);
        } else {
            ck_assert_int_eq(status, STEIN_EPARSE);
            ck_assert_ptr_nonnull(strstr(e.msg, "journal"));
            read_bytes(path, after, sizeof after);
            ck_assert_str_eq(after, other[i]);
        }
        lab_table_destroy(table);
    }
}
END_TEST

START_TEST(a_journal_of_another_sweep_is_refused)
{
    char text[2048], after[2048], changed[sizeof head];
    const char *path = in_folder("journal");
    size_t size = full_journal(path, text, sizeof text);
    for (size_t i = 0; head[i] != '\0'; i++) { // every digit of the head matters
        lab_table *table = NULL;
        lab__journal journal;
        stein_err e = {STEIN_OK, ""};
        memcpy(changed, head, sizeof head);
        if (head[i] < '1' || head[i] > '8') {
            continue;
        }
        changed[i]++;
        ck_assert_stein(lab__table_new(&table, changed, err));
        ck_assert_int_eq(lab__journal_open(&journal, path, table, NULL, &e), STEIN_ESTALE);
        ck_assert_ptr_nonnull(strstr(e.msg, "belongs to another sweep"));
        ck_assert_uint_eq(read_bytes(path, after, sizeof after), size);
        ck_assert_mem_eq(after, text, size);
        lab_table_destroy(table);
    }
}
END_TEST

START_TEST(two_results_for_a_point_are_refused)
{
    const char *path[] = {in_folder("one"), in_folder("two")};
    lab_table *table = NULL;
    for (int k = 0; k < 2; k++) {
        lab__journal journal;
        table = empty_table();
        ck_assert_stein(lab__journal_open(&journal, path[k], table, NULL, err));
        ck_assert_stein(
            lab__journal_add(&journal, k == 0 ? "5,0.0005,ok,5" : "5,0.0005,ok,6", err));
        lab__journal_close(&journal);
        lab_table_destroy(table);
    }
    stein_err e = {STEIN_OK, ""};
    table = NULL;
    ck_assert_int_eq(lab_merge(&table, path, 2, NULL, &e), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(e.msg, "point 5 has two different results"));
    ck_assert_ptr_null(table);
    ck_assert_stein(lab_merge(&table, (const char *[]){path[0], path[0]}, 2, NULL, err));
    lab_table_destroy(table);
}
END_TEST

START_TEST(only_one_process_writes_a_journal)
{
    const char *path = in_folder("journal");
    lab_table *table = empty_table();
    lab__journal journal;
    ck_assert_stein(lab__journal_open(&journal, path, table, NULL, err));
    pid_t child = fork();
    if (child == 0) {
        lab__journal second;
        stein_err e = {STEIN_OK, ""};
        int refused = lab__journal_open(&second, path, table, NULL, &e) == STEIN_EIO &&
                      strstr(e.msg, "in use by another process") != NULL;
        _exit(refused ? 0 : 1);
    }
    int state = -1;
    ck_assert_int_eq(waitpid(child, &state, 0), child);
    ck_assert_int_eq(state, 0);
    lab__journal_close(&journal);
    lab_table_destroy(table);
}
END_TEST

Suite *journal_suite(void)
{
    Suite *suite = suite_create("journal");
    TCase *journal = tcase_create("journal");
    tcase_add_checked_fixture(journal, make_folder, remove_folder);
    tcase_set_timeout(journal, 60.0);
    tcase_add_test(journal, a_journal_cut_at_any_byte_keeps_every_whole_line);
    tcase_add_test(journal, no_flipped_bit_becomes_a_result);
    tcase_add_test(journal, a_file_that_is_no_journal_is_left_alone);
    tcase_add_test(journal, a_journal_of_another_sweep_is_refused);
    tcase_add_test(journal, two_results_for_a_point_are_refused);
    tcase_add_test(journal, only_one_process_writes_a_journal);
    suite_add_tcase(suite, journal);
    return suite;
}
