/* SPDX-License-Identifier: GPL-3.0-or-later
 * reality_support.h - what the tests of the independent source of measurements share: running it,
 * reading its films, comparing them with the core.
 */
#ifndef REALITY_SUPPORT_H
#define REALITY_SUPPORT_H

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"

static const char model_file[] = "models/stein1788.yaml";
enum { COLUMNS = 4, MAX_ROWS = 4000, FIT = 12, HELD = 6 };

/* ---- running it ---- */

/* what it prints goes to "said" and "messages" in the folder of the test */
static inline int run(const char *format, ...)
{
    char command[1200], arguments[800];
    const char *build = getenv("STEIN_BUILD");
    va_list args;
    va_start(args, format);
    vsnprintf(arguments, sizeof arguments, format, args);
    va_end(args);
    snprintf(command, sizeof command, "%s/reality --model %s %s >%s 2>%s", build ? build : "build",
             model_file, arguments, in_folder("said"), in_folder("messages"));
    return system(command);
}

static inline char *read_all(const char *path)
{
    FILE *f = fopen(path, "rb");
    ck_assert_msg(f != NULL, "%s is missing (is the program `reality` built?)", path);
    char *text = calloc(1, 400000);
    ck_assert_uint_lt(fread(text, 1, 399999, f), 399999);
    fclose(f);
    return text;
}

typedef struct table {
    int rows, columns;
    double cell[MAX_ROWS][COLUMNS]; /* NAN: empty */
} table;

static inline void read_row(table *t, char *line)
{
    int c = 0;
    for (char *cell = line; cell != NULL && c < COLUMNS; c++) {
        char *end, *comma = strchr(cell, ',');
        double value = strtod(cell, &end);
        t->cell[t->rows][c] = end == cell ? NAN : value;
        cell = comma != NULL ? comma + 1 : NULL;
    }
    t->columns = c;
    t->rows++;
}

static inline void read_table(table *t, const char *path)
{
    char line[300];
    FILE *f = fopen(path, "r");
    ck_assert_msg(f != NULL, "%s is missing (is the program `reality` built?)", path);
    t->rows = 0;
    while (fgets(line, sizeof line, f) != NULL && t->rows < MAX_ROWS) {
        if (line[0] == '-' || (line[0] >= '0' && line[0] <= '9')) {
            read_row(t, line);
        }
    }
    fclose(f);
}

/* the number after "key": in a text of JSON */
static inline double json_number(const char *text, const char *key)
{
    char quoted[100];
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    const char *at = strstr(text, quoted);
    ck_assert_msg(at != NULL, "no %s in the answer", key);
    return strtod(at + strlen(quoted), NULL);
}

static table film, other;

/* ---- agreement with the core ---- */

static inline void keep_rebound(void *ctx, stein_sim *sim, const stein_event *event)
{
    double *rebound = ctx;
    int string = stein_sim_model(sim)->stroke.string;
    if (event->kind == STEIN_EVENT_CONTACT_END && event->index == string && !(*rebound > 0.0)) {
        *rebound = event->time;
    }
}

/* largest differences up to the first rebound; the core starts as set */
static inline void compare(stein_sim *sim, const char *what)
{
    double rebound = 0.0, distance = 0.0, dip = 0.0, angle = 0.0, later = 0.0;
    stein_on_event(sim, keep_rebound, &rebound);
    const char *const names[] = {"string_distance", "key_dip", "hammer_angle"};
    double *const worst[] = {&distance, &dip, &angle};
    for (int i = 0; i < film.rows; i++) {
        ck_assert_stein(stein_run(sim, film.cell[i][0], err));
        for (int k = 0; k < 3; k++) {
            double value = 0.0;
            ck_assert_stein(stein_read_name(sim, names[k], &value, err));
            double off = fabs(value - film.cell[i][k + 1]);
            if (!(rebound > 0.0)) {
                *worst[k] = fmax(*worst[k], off);
            } else if (k == 0) {
                later = fmax(later, off);
            }
        }
    }
    printf("%s: core against reality up to the rebound at %.4f s: distance %.1e m, dip %.1e m, "
           "angle %.1e rad; distance afterwards %.1e m\n",
           what, rebound, distance, dip, angle, later);
    fflush(stdout);
    ck_assert_msg(rebound > 0.03 && rebound < 0.11, "%s: rebound at %g s", what, rebound);
    ck_assert_double_le(distance, 1e-6);
    ck_assert_double_le(dip, 1e-6);
    ck_assert_double_le(angle, 1e-5);
}

#endif
