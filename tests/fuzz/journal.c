/* SPDX-License-Identifier: GPL-3.0-or-later
 * journal.c - any lines as the journal of a sweep. Each gets a correct checksum, else it would be
 * ignored; lines that begin with "!" are not changed.
 */
#include "fuzz.h"
#include "plot.h"
#include "sweep.h"

enum { LINE = 2000 };

static unsigned long crc32(const char *text, size_t n)
{
    unsigned long crc = 0xffffffffu;
    for (size_t i = 0; i < n; i++) {
        crc ^= (unsigned char)text[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
        }
    }
    return crc ^ 0xffffffffu;
}

/* a million points are allowed, and take a second: no use here */
static int is_large(const char *line)
{
    const char *count = strrchr(line, ':');
    return strstr(line, "vary") != NULL && count != NULL && strtol(count + 1, NULL, 10) > 5000;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char line[LINE], *text = NULL;
    size_t length = 0;
    FILE *f = open_memstream(&text, &length);
    must(f != NULL, "there is memory");
    int large = 0;
    while (fuzz_line(&data, &size, line, sizeof line)) {
        large |= is_large(line);
        if (line[0] == '!') {
            fprintf(f, "%s\n", line + 1);
        } else {
            fprintf(f, "%s *%08lx\n", line, crc32(line, strlen(line)));
        }
    }
    fclose(f);
    if (large) {
        free(text);
        return 0;
    }
    const char *path[] = {fuzz_file(text, length)};
    lab_table *table = NULL;
    stein_err err = {STEIN_OK, ""};
    int damaged = 0;
    if (lab_merge(&table, path, 1, &damaged, &err) == STEIN_OK) {
        for (int i = 0; i < lab_table_points(table) && i < 100; i++) {
            (void)lab__table_number(table, i, 1);
            (void)lab__table_ok(table, i);
        }
        must(lab_table_write("/dev/null", table, &err) == STEIN_OK, "it can be written");
    } else {
        must(table == NULL && err.msg[0] != '\0', "a refusal says why");
    }
    lab_table_destroy(table);
    free(text);
    return 0;
}
