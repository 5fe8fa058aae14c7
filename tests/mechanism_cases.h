/* SPDX-License-Identifier: MIT
 * mechanism_cases.h - one good mechanism file, and reading changed copies of it, for the suites of
 * the reader.
 */
#ifndef MECHANISM_CASES_H
#define MECHANISM_CASES_H

#include <stdlib.h>
#include <string.h>

#include "mechanism.h"
#include "support.h"

/* Bodies of every kind of joint force, points, contacts, a notch, a load; hammer before its parent.
 */
static const char good[] =
    "mechanism: demo\n"
    "gravity: [0, 0, -9.81 m/s^2]\n"
    "parameters:\n"
    "  pawl.stop_shift: 0.31 mm\n"
    "  string.height: {value: 43.7 mm +- 0.2 mm, about: over the rest}\n"
    "bodies:\n"
    "  hammer:\n"
    "    parent: key\n"
    "    joint: R -y\n"
    "    at: key.kapsel\n"
    "    mass: 3.31 g\n"
    "    centre: [57.3 mm, 0, 2.9 mm]\n"
    "    inertia: {yy: 3.17e-6 kg m^2}\n"
    "    points: {head: [88.7 mm, 0, 15.2 mm], beak: [-11.9 mm, 0, 0.83 mm]}\n"
    "  key:\n"
    "    about: the lever\n"
    "    joint: R y\n"
    "    mass: 71.3 g +- 2 %\n"
    "    centre: [-27.1 mm, 0, 3.2 mm]\n"
    "    inertia: {yy: 5.17e-4 kg m^2}\n"
    "    damping: 1.3e-5 N m s/rad\n"
    "    friction: {A: 1.7e-4 N m, vt: 0.13 rad/s}\n"
    "    points:\n"
    "      kapsel: [-109 mm, 0, 14.6 mm]\n"
    "      front: [177 mm, 0, 5.3 mm]\n"
    "  pawl:\n"
    "    joint: R -y\n"
    "    at: [-123 mm, 0, -33.1 mm]\n"
    "    mass: 3.9 g\n"
    "    inertia: {yy: 4.1e-6 kg m^2}\n"
    "    spring: {k: 0.0413 N m/rad, theta0: -0.347 rad}\n"
    "    points: {corner: [0.7 mm, 0, 50.3 mm], back: [0, 0, 45.1 mm]}\n"
    "points:\n"
    "  anchor: [0.113 m, 0, 0]\n"
    "links:\n"
    "  tie: {from: frame.anchor, to: key.front, k: 93 N/m, length: 0.127 m}\n"
    "contacts:\n"
    "  string:\n"
    "    between:\n"
    "      - {point: hammer.head}\n"
    "      - {line: {on: frame, at: [0, 0, string.height], facing: -90 deg}}\n"
    "    normal: {a: 6.7e11 N/m^3, b: 2.9e7 N/m^2}\n"
    "    friction: {A: 0.23, vt: 11 mm/s}\n"
    "  stop:\n"
    "    between:\n"
    "      - {line: {on: frame, at: [-121 mm + pawl.stop_shift, 0, 0], facing: 180 deg}}\n"
    "      - {circle: {at: pawl.back, radius: 1.9 mm}}\n"
    "    normal: {c: 1.57e3 N/m}\n"
    "notches:\n"
    "  notch:\n"
    "    corner: {at: pawl.corner, angle: 89 deg}\n"
    "    beak: {at: hammer.beak, tilt: -0.011 rad}\n"
    "    normal: {b: 1.13e7 N/m^2}\n"
    "load: {mass: 97 g, on: key.front, normal: {c: 2.61e4 N/m}}\n"
    "inputs:\n"
    "  finger: {force: key.front, direction: [0, 0, -1]}\n"
    "  drive: {motion: key, idle: hold}\n"
    "outputs:\n"
    "  distance: {contact: string, read: gap}\n"
    "  dip: {point: key.front, read: vz, sign: -1, zero: rest}\n"
    "  effort: {input: drive, read: force}\n"
    "stroke: {string: string, notch: notch}\n"
    "simulation: {dt: 13 us, until: 0.29 s, integrator: dp5, settle: yes}\n";

typedef struct log_t {
    char first[700];
    int n;
} log_t;

static inline void record(void *ctx, const char *message)
{
    log_t *log = ctx;

    if (log->n++ == 0) {
        snprintf(log->first, sizeof log->first, "%s", message);
    }
}

/** The good file with one piece of text replaced; free() it. */
static inline char *changed(const char *from, const char *to)
{
    const char *at = strstr(good, from);
    size_t size = sizeof good + strlen(to);
    char *text = malloc(size);

    ck_assert_msg(at != NULL, "the file has no \"%s\"", from);
    snprintf(text, size, "%.*s%s%s", (int)(at - good), good, to, at + strlen(from));
    return text;
}

/** Read what must be accepted. */
static inline mechanism *read_ok(const char *text, const mech_set *set, int nset)
{
    log_t log = {"", 0};
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};
    stein_status status =
        mech_read_text(&m, "demo.yaml", text, strlen(text), set, nset, record, &log, &err);

    ck_assert_msg(status == STEIN_OK, "%s", err.msg);
    ck_assert_int_eq(log.n, 0);
    return m;
}

typedef struct refusal {
    const char *from, *to; /* replacement in the good file */
    const char *at;        /* the message points at this text; NULL: at the file as a whole */
    const char *words;     /* the message holds these, separated by | */
} refusal;

/** "demo.yaml:LINE:COLUMN: " of a piece of text. */
static inline void place_of(const char *text, const char *at, char *place, size_t size)
{
    const char *end = at ? strstr(text, at) : NULL;
    int line = 1, column = 1;

    ck_assert_msg(!at || end, "the text has no \"%s\"", at);
    for (const char *s = text; s < end; s++) {
        line += *s == '\n';
        column = *s == '\n' ? 1 : column + 1;
    }
    if (at) {
        snprintf(place, size, "demo.yaml:%d:%d: ", line, column);
    } else {
        snprintf(place, size, "demo.yaml: ");
    }
}

/** Read a text that must be refused with one problem, at the given place and with the given
 * message. */
static inline void refuse_text(const char *text, size_t size, const mech_set *set, int nset,
                               const char *at, const char *words)
{
    mechanism *const untouched = (mechanism *)(void *)&words;
    mechanism *m = untouched;
    stein_err err = {STEIN_OK, ""};
    log_t log = {"", 0};
    char place[40], all[300];
    stein_status status =
        mech_read_text(&m, "demo.yaml", text, size, set, nset, record, &log, &err);

    ck_assert_msg(status == STEIN_EPARSE, "accepted, expected: %s", words);
    ck_assert(m == untouched);
    ck_assert_int_eq(err.code, STEIN_EPARSE);
    ck_assert_msg(strncmp(log.first, err.msg, sizeof err.msg - 1) == 0, "%s / %s", log.first,
                  err.msg);
    ck_assert_msg(log.n == 1, "%d problems, the first is %s", log.n, log.first);
    place_of(text, at, place, sizeof place);
    ck_assert_msg(strncmp(log.first, place, strlen(place)) == 0, "%s, expected it at %s", log.first,
                  place);
    snprintf(all, sizeof all, "%s", words);
    for (const char *word = strtok(all, "|"); word; word = strtok(NULL, "|")) {
        ck_assert_msg(strstr(log.first, word) != NULL, "%s, expected \"%s\"", log.first, word);
    }
}

static inline void refuse_all(const refusal *r, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char *text = changed(r[i].from, r[i].to);

        refuse_text(text, strlen(text), NULL, 0, r[i].at, r[i].words);
        free(text);
    }
}
#define REFUSE_ALL(table) refuse_all(table, sizeof(table) / sizeof(table)[0])

#endif
