/* SPDX-License-Identifier: GPL-3.0-or-later
 * before_record.c - planned records: read from a line of text, simulated, written as files.
 */
#include <ctype.h>
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "planning.h"

enum { MOST_RECORDS = 100, MOST_ROWS = 200000, LEAST_ROWS = 8, WORD = 200 };
static const double encoder = 1e-3, marker = 1e-4; /* noise of an angle, of a place [rad], [m] */
static const double of_reading = 0.01;             /* noise of anything else */
static const double smallest = 1e-12;              /* of a channel that does not move */
static const char form[] = "[N x] TIME at RATE [with NAME=VALUE, ...]; ...";

/* ---- the line ---- */

/* text between two ends without blanks around it. @return 0: too long */
static int cut(char to[WORD], const char *from, const char *end)
{
    while (from < end && isspace((unsigned char)*from)) {
        from++;
    }
    while (end > from && isspace((unsigned char)end[-1])) {
        end--;
    }
    size_t n = (size_t)(end - from);
    if (n >= WORD) {
        return 0;
    }
    memcpy(to, from, n);
    to[n] = '\0';
    return 1;
}

/* where a word begins that stands between blanks; NULL: nowhere before the end */
static const char *find_word(const char *text, const char *end, const char *word)
{
    size_t n = strlen(word);
    for (const char *p = text; p + n < end; p++) {
        if (isspace((unsigned char)*p) && strncmp(p + 1, word, n) == 0 &&
            (p + 1 + n == end || isspace((unsigned char)p[1 + n]))) {
            return p + 1;
        }
    }
    return NULL;
}

static stein_status read_set(const char *text, const stein_model *m, lab_experiment *e,
                             stein_err *err)
{
    char name[WORD];
    const char *equals = strchr(text, '=');
    double value = 0.0;
    if (equals == NULL || !cut(name, text, equals)) {
        return lab__fail(err, STEIN_EINVAL, "records: \"%s\": expected NAME=VALUE", text);
    }
    int k = stein_find_param(m, name);
    if (k < 0) {
        return lab__fail(err, STEIN_ENAME, "records: %s has no number \"%s\" to set", m->name,
                         name);
    }
    stein_status status = lab_quantity(&value, equals + 1, m->params[k].unit, err);
    if (status == STEIN_OK && !plan__set(e, m->params[k].name, m->params[k].unit, value)) {
        status = lab__fail(err, STEIN_EINVAL, "records: more than %d numbers set in one record",
                           (int)LAB_PLAN_SETS);
    }
    return status;
}

static stein_status read_sets(const char *from, const char *end, const stein_model *m,
                              lab_experiment *e, stein_err *err)
{
    stein_status status = STEIN_OK;
    while (status == STEIN_OK && from < end) {
        char word[WORD];
        const char *comma = memchr(from, ',', (size_t)(end - from));
        const char *stop = comma != NULL ? comma : end;
        status = cut(word, from, stop)
                     ? read_set(word, m, e, err)
                     : lab__fail(err, STEIN_EINVAL, "records: a name is too long");
        from = stop + 1;
    }
    return status;
}

/* "3 x" in front. @return the number, 1 without; *from behind it */
static int read_count(const char **from)
{
    char *end;
    long n = strtol(*from, &end, 10);
    while (isspace((unsigned char)*end)) {
        end++;
    }
    if (end == *from || *end != 'x' || !isspace((unsigned char)end[1])) {
        return 1;
    }
    *from = end + 1;
    return n >= 1 && n <= MOST_RECORDS ? (int)n : 0;
}

static stein_status read_group(const char *from, const char *end, const stein_model *m,
                               plan__meant *to, int *count, stein_err *err)
{
    char time[WORD], rate[WORD];
    *to = (plan__meant){.e = {.faster = 1, .feasible = 1}};
    *count = read_count(&from);
    const char *with = find_word(from, end, "with"), *at = find_word(from, end, "at");
    const char *stop = with != NULL ? with : end;
    if (*count < 1) {
        return lab__fail(err, STEIN_EINVAL, "records: 1 to %d records, not \"%.*s\"",
                         (int)MOST_RECORDS, (int)(end - from < WORD ? end - from : WORD), from);
    }
    if (at == NULL || at > stop || !cut(time, from, at) || !cut(rate, at + 2, stop)) {
        return lab__fail(err, STEIN_EINVAL, "records: \"%.*s\": expected %s",
                         (int)(end - from < WORD ? end - from : WORD), from, form);
    }
    stein_status status = lab_quantity(&to->until, time, "s", err);
    status = status == STEIN_OK ? lab_quantity(&to->rate, rate, "1/s", err) : status;
    double rows = to->until * to->rate;
    if (status == STEIN_OK && !(to->until > 0.0 && rows >= LEAST_ROWS && rows <= MOST_ROWS)) {
        status =
            lab__fail(err, STEIN_EINVAL, "records: %s at %s are %.3g samples: expected %d to %d",
                      time, rate, rows, (int)LEAST_ROWS, (int)MOST_ROWS);
    }
    return status == STEIN_OK && with != NULL ? read_sets(with + 4, end, m, &to->e, err) : status;
}

stein_status plan__meant_read(const char *text, const stein_model *m, plan__meant **list, int *n,
                              stein_err *err)
{
    stein_status status = STEIN_OK;
    plan__meant *all = malloc(sizeof *all * MOST_RECORDS);
    int used = 0;
    if (all == NULL) {
        return lab__no_memory(err);
    }
    while (status == STEIN_OK && *text != '\0') {
        plan__meant one;
        int count = 0;
        const char *end = text + strcspn(text, ";");
        status = read_group(text, end, m, &one, &count, err);
        if (status == STEIN_OK && used + count > MOST_RECORDS) {
            status = lab__fail(err, STEIN_EINVAL, "records: more than %d", (int)MOST_RECORDS);
        }
        for (int i = 0; status == STEIN_OK && i < count; i++) {
            all[used++] = one;
        }
        text = *end == ';' ? end + 1 : end;
    }
    if (status == STEIN_OK && used == 0) {
        status = lab__fail(err, STEIN_EINVAL, "records: none; expected %s", form);
    }
    if (status != STEIN_OK) {
        free(all);
        return status;
    }
    *list = all;
    *n = used;
    return STEIN_OK;
}

/* ---- a record ---- */

typedef struct filmed {
    const plan__meant *meant;
    const stein_model *m;
    const plan__sensor *sensor;
    lab_experiment signal; /* the meant one's, of its input */
    int n, rows;
    double *y; /* [n][rows] */
} filmed;

static double time_of(const filmed *f, int row)
{
    return row / f->meant->rate;
}

static stein_status start(filmed *f, stein_sim *sim, stein_err *err)
{
    const lab_experiment *e = &f->meant->e;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < e->nset; i++) {
        status = stein_set(sim, e->set[i].name, e->set[i].value, err);
    }
    if (status == STEIN_OK && e->input[0] != '\0') {
        status = stein_drive(sim, e->input, plan__signal, &f->signal, err);
    }
    return status == STEIN_OK ? stein_reset(sim, err) : status;
}

static stein_status simulate(filmed *f, const lab_model *model, stein_err *err)
{
    stein_sim *sim = NULL;
    stein_status status = lab_sim(model, NULL, &sim, err);
    status = status == STEIN_OK ? start(f, sim, err) : status;
    for (int i = 0; status == STEIN_OK && i < f->rows; i++) {
        status = stein_run(sim, time_of(f, i), err);
        for (int c = 0; status == STEIN_OK && c < f->n; c++) {
            f->y[c * f->rows + i] = stein_read(sim, f->sensor[c].channel);
        }
    }
    stein_sim_destroy(sim);
    return status;
}

static double noise_of(const filmed *f, int c)
{
    const char *unit = f->m->channels[f->sensor[c].channel].unit;
    double largest = 0.0;
    if (isfinite(f->sensor[c].noise)) {
        return f->sensor[c].noise;
    }
    for (int i = 0; i < f->rows; i++) {
        largest = fmax(largest, fabs(f->y[c * f->rows + i]));
    }
    return strcmp(unit, "rad") == 0 ? encoder
           : strcmp(unit, "m") == 0 ? marker
                                    : fmax(of_reading * largest, smallest);
}

static void write_rows(FILE *out, filmed *f, gsl_rng *rng)
{
    const lab_experiment *e = &f->meant->e;
    char number[LAB_NUMBER];
    for (int i = 0; i < f->rows; i++) {
        double u[3];
        fprintf(out, "%s", lab__number(number, time_of(f, i)));
        if (e->input[0] != '\0') {
            plan__signal(&f->signal, time_of(f, i), u);
            fprintf(out, ",%s", lab__number(number, u[0]));
        }
        for (int c = 0; c < f->n; c++) {
            double y = f->y[c * f->rows + i] + gsl_ran_gaussian(rng, noise_of(f, c));
            fprintf(out, ",%s", lab__number(number, y));
        }
        fprintf(out, "\n");
    }
}

static void write_head(FILE *out, const filmed *f)
{
    const lab_experiment *e = &f->meant->e;
    char number[LAB_NUMBER];
    for (int i = 0; i < e->nset; i++) {
        fprintf(out, "# set %s: %s %s\n", e->set[i].name, lab__number(number, e->set[i].value),
                strcmp(e->set[i].unit, "1") == 0 ? "" : e->set[i].unit);
    }
    for (int c = 0; c < f->n; c++) {
        fprintf(out, "# noise %s: %s\n", f->m->channels[f->sensor[c].channel].name,
                lab__number(number, noise_of(f, c)));
    }
    fprintf(out, "time [s]");
    int input = stein_find_input(f->m, e->input);
    if (input >= 0) {
        fprintf(out, ",%s [%s]", e->input, f->m->inputs[input].unit);
    }
    for (int c = 0; c < f->n; c++) {
        const stein_channel *channel = &f->m->channels[f->sensor[c].channel];
        fprintf(out, ",%s [%s]", channel->name, channel->unit);
    }
    fprintf(out, "\n");
}

stein_status plan__meant_write(const char *path, const plan__meant *meant, const lab_model *model,
                               const plan__sensor *sensor, int nsensor, unsigned long seed,
                               stein_err *err)
{
    filmed f = {.meant = meant,
                .signal = meant->e,
                .m = lab_equations(model),
                .sensor = sensor,
                .n = nsensor,
                .rows = (int)floor(meant->until * meant->rate) + 1};
    lab__file out;
    f.y = malloc(sizeof *f.y * (size_t)f.rows * (size_t)nsensor);
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    stein_status status =
        f.y != NULL && rng != NULL ? simulate(&f, model, err) : lab__no_memory(err);
    status = status == STEIN_OK ? lab__file_open(&out, path, err) : status;
    if (status == STEIN_OK) {
        gsl_rng_set(rng, seed);
        write_head(out.stream, &f);
        write_rows(out.stream, &f, rng);
        status = lab__file_close(&out, 1, err);
    }
    gsl_rng_free(rng);
    free(f.y);
    return status;
}
