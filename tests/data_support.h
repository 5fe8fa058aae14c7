/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_support.h - records for the tests of data: a synthetic stroke seen by a camera.
 */
#ifndef DATA_SUPPORT_H
#define DATA_SUPPORT_H

#include "lab_support.h"
#include "stein/data.h"

enum { SAID = 40, SAID_LENGTH = 400 };

/** Collects reports. */
typedef struct said {
    char text[SAID][SAID_LENGTH];
    int n;
} said;

static inline void hear(void *ctx, const char *message)
{
    said *s = ctx;
    ck_assert_int_lt(s->n, SAID);
    snprintf(s->text[s->n++], SAID_LENGTH, "%s", message);
}

static inline int was_said(const said *s, const char *part)
{
    int found = 0;
    for (int i = 0; i < s->n; i++) {
        found += strstr(s->text[i], part) != NULL;
    }
    return found;
}

static inline int was_found(const lab_audit *a, const char *part)
{
    int found = 0;
    for (int i = 0; i < a->nfinding; i++) {
        found += strstr(a->finding[i], part) != NULL;
    }
    return found;
}

/** Settings of the camera. */
typedef struct camera {
    double rate, noise, step, jitter; /* [Hz], [m], [m], [s] sd of one instant, uniform */
    double from, to, trigger;         /* recorded stretch [s]; the motion begins at `trigger` */
    double correlation;               /* of the noise from sample to sample */
    double lowest, highest;           /* cut off there [m] */
    unsigned long long seed;
} camera;

static inline camera camera_default(unsigned long long seed)
{
    return (camera){.rate = 4000.0,
                    .noise = 20e-6,
                    .from = 0.0,
                    .to = 0.4,
                    .trigger = 0.0517,
                    .lowest = -1.0,
                    .highest = 1.0,
                    .seed = seed};
}

static inline double gaussian(unsigned long long *seed)
{
    double u = 0.5 * (noise(seed) + 1.0), v = noise(seed);
    return sqrt(-2.0 * log(1.0 - u)) * cos(3.14159265358979 * v);
}

/** Distance of head and string [m] at time t after the release: driven, let off, the impact, caught
 *  and at rest. */
static inline double stroke_at(double t)
{
    const double blow = 39.23e-3, a = 21.7, off = 0.0573, at = 0.0604;
    if (t < 0.0) {
        return blow;
    }
    double driven = blow - 0.5 * a * t * t + 0.31e-3 * sin(410.0 * t) * t / off;
    if (t < off) {
        return driven;
    }
    double there = blow - 0.5 * a * off * off + 0.31e-3 * sin(410.0 * off);
    double v = a * off - 0.31e-3 * (410.0 * cos(410.0 * off) + sin(410.0 * off) / off);
    if (t < at) {
        return there - v * (t - off) + 4.905 * (t - off) * (t - off);
    }
    double s = t - at, rest = 23.71e-3; // caught by the check
    double d = there - v * (at - off) + 4.905 * (at - off) * (at - off);
    return rest + (d - rest) * exp(-s / 9.3e-3) * cos(127.0 * s);
}

/** Reading of the camera at time t of its clock. */
typedef struct eye {
    camera c;
    double carried; /* noise of the frame before [m] */
} eye;

static inline double see(eye *e, double t)
{
    const camera *c = &e->c;
    double r = c->correlation;
    e->carried = r * e->carried + sqrt(1.0 - r * r) * gaussian(&e->c.seed);
    double x = stroke_at(t - c->trigger) + c->noise * e->carried;
    x = c->step > 0.0 ? c->step * round((x - 0.37e-6) / c->step) + 0.37e-6 : x;
    return fmin(c->highest, fmax(c->lowest, x));
}

/** Which frames are lost. */
typedef int lost_fn(int frame);

static inline const char *film(const char *name, const char *notes, camera c, lost_fn *lost)
{
    const char *path = in_folder(name);
    eye e = {c, 0.0};
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%stime [ms],string_distance [mm]\n", notes);
    int n = (int)floor((c.to - c.from) * c.rate);
    for (int i = 0; i <= n; i++) {
        double t = c.from + i / c.rate + c.jitter * sqrt(3.0) * noise(&e.c.seed), x = see(&e, t);
        if (lost == NULL || !lost(i)) {
            fprintf(f, "%.7f,%.9f\n", 1e3 * t, 1e3 * x);
        }
    }
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

static inline lab_data *open_data(const char *path, const stein_model *model)
{
    lab_data_options o = lab_data_options_default(model);
    lab_data *data = NULL;
    ck_assert_stein(lab_data_open(&data, path, &o, err));
    return data;
}

/** A file that is refused: place, after its path, and a part of the message. */
typedef struct bad_data {
    const char *text, *place, *says;
} bad_data;

/** Each with one problem, reported and returned in the same words. */
static inline void refuse_data(const bad_data *bad, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        lab_data_options o = lab_data_options_default(&stein_model_stein1788);
        said s = {.n = 0};
        stein_err why = {STEIN_OK, ""};
        lab_data *d = NULL;
        o.report = hear;
        o.ctx = &s;
        const char *path = write_file("bad.csv", bad[i].text);
        stein_status status = lab_data_open(&d, path, &o, &why);
        ck_assert_msg(status == STEIN_EPARSE && d == NULL, "accepted: %s", bad[i].text);
        char *place = lab__text("%s%s", path, bad[i].place);
        ck_assert_msg(s.n == 1 && strncmp(s.text[0], place, strlen(place)) == 0 &&
                          strstr(s.text[0], bad[i].says) != NULL,
                      "%d problems, the first: %s\nexpected %s and \"%s\"", s.n, s.text[0], place,
                      bad[i].says);
        ck_assert_int_eq(strncmp(why.msg, s.text[0], strlen(why.msg)), 0);
        free(place);
    }
}
#define REFUSE(bad) refuse_data(bad, sizeof(bad) / sizeof *(bad))

static inline lab_audit *audit_of(const lab_data *data)
{
    lab_audit *audit = NULL;
    ck_assert_stein(lab_audit_create(&audit, data, err));
    return audit;
}

#endif
