/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit_support.h - strokes with noise for the tests of the fit, made by the core itself.
 *
 * The data come from fixed steps of RK4, ten times as short as a stroke needs; the fit simulates
 * with controlled steps of Dormand-Prince.
 */
#ifndef FIT_SUPPORT_H
#define FIT_SUPPORT_H

#include "lab_support.h"
#include "stein/fit.h"

/** One measurement to be made. */
typedef struct film {
    const char *model;
    const char *const *truth; /* "NAME=VALUE", closed by NULL */
    const char *const *told;  /* the same, of this stroke, written as `# set`; may be NULL */
    const char *channels;     /* separated by blanks */
    double rate, from, until; /* [Hz], [s] */
    double noise, clock;      /* sd [unit]; the data's clock is ahead by this [s] */
    double base, lag; /* the frame of t is the frame of (1 + base) t; the last channel lags [s] */
    int unsynchronised, silent; /* silent: no `# noise` */
    unsigned long long seed;
} film;

static inline double gauss(unsigned long long *seed)
{
    double u, v, s;
    do {
        u = noise(seed);
        v = noise(seed);
        s = u * u + v * v;
    } while (s >= 1.0 || s == 0.0);
    return u * sqrt(-2.0 * log(s) / s);
}

static inline void write_film_head(FILE *f, const film *m, const stein_model *equations)
{
    for (int i = 0; m->told != NULL && m->told[i] != NULL; i++) {
        const char *sign = strchr(m->told[i], '=');
        fprintf(f, "# set %.*s: %s\n", (int)(sign - m->told[i]), m->told[i], sign + 1);
    }
    if (m->unsynchronised) {
        fprintf(f, "# trigger: unsynchronised\n");
    }
    char names[200], *rest = NULL;
    snprintf(names, sizeof names, "%s", m->channels);
    char title[400] = "time [s]";
    for (char *c = strtok_r(names, " ", &rest); c != NULL; c = strtok_r(NULL, " ", &rest)) {
        if (!m->silent) {
            fprintf(f, "# noise %s: %.17g\n", c, m->noise);
        }
        size_t n = strlen(title);
        snprintf(title + n, sizeof title - n, ",%s [%s]", c,
                 equations->channels[stein_find_channel(equations, c)].unit);
    }
    fprintf(f, "%s\n", title);
}

/* reading of a channel at T, if that is not past */
static inline double seen_at(stein_sim *sim, const char *channel, double T)
{
    double y = 0.0;
    if (T > stein_time(sim)) {
        ck_assert_stein(stein_run(sim, T, err));
    }
    ck_assert_stein(stein_read_name(sim, channel, &y, err));
    return y;
}

static inline void write_film_row(FILE *f, const film *m, stein_sim *sim, double t,
                                  unsigned long long *seed)
{
    char names[200], *rest = NULL;
    const char *last = strrchr(m->channels, ' ');
    last = last != NULL ? last + 1 : m->channels;
    double T = (1.0 + m->base) * t + m->clock, late = seen_at(sim, last, T - m->lag);
    snprintf(names, sizeof names, "%s", m->channels);
    fprintf(f, "%.17g", t);
    for (char *c = strtok_r(names, " ", &rest); c != NULL; c = strtok_r(NULL, " ", &rest)) {
        double y = strcmp(c, last) == 0 ? late : seen_at(sim, c, T);
        fprintf(f, ",%.17g", y + m->noise * gauss(seed));
    }
    fprintf(f, "\n");
}

/** Make a measurement. @return its path, in the folder of the test */
static inline const char *take(const char *name, const film *m)
{
    const char *set[40];
    int n = 0;
    for (int i = 0; m->truth != NULL && m->truth[i] != NULL; i++) {
        set[n++] = m->truth[i];
    }
    for (int i = 0; m->told != NULL && m->told[i] != NULL; i++) {
        set[n++] = m->told[i];
    }
    lab_options options = cache_here(NULL);
    options.set = set;
    options.nset = n;
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    ck_assert_stein(lab_open(&model, m->model, &options, err));
    stein_sim_def def = lab_def(model);
    def.integrator = STEIN_RK4;
    def.dt *= 0.5;
    ck_assert_stein(lab_sim(model, &def, &sim, err));
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    unsigned long long seed = m->seed;
    write_film_head(f, m, lab_equations(model));
    for (int i = 0; m->from + i / m->rate <= m->until + 1e-9; i++) {
        write_film_row(f, m, sim, m->from + i / m->rate, &seed);
    }
    ck_assert_int_eq(fclose(f), 0);
    stein_sim_destroy(sim);
    lab_close(model);
    return path;
}

/** A fit with its model and data. */
typedef struct fitted {
    lab_model *model;
    lab_dataset *data;
    lab_fit *fit;
} fitted;

static inline void drop(fitted *f)
{
    lab_fit_destroy(f->fit);
    lab_dataset_close(f->data);
    lab_close(f->model);
    *f = (fitted){NULL, NULL, NULL};
}

/** Open model (with overrides, closed by NULL) and data. */
static inline void open_fit(fitted *f, const char *file, const char *const *set,
                            const char *const *data)
{
    lab_options options = cache_here(NULL);
    *f = (fitted){NULL, NULL, NULL};
    options.set = set;
    int n = 0;
    while (set != NULL && set[options.nset] != NULL) {
        options.nset++;
    }
    while (data[n] != NULL) {
        n++;
    }
    ck_assert_stein(lab_open(&f->model, file, &options, err));
    lab_data_options how = lab_data_options_default(lab_equations(f->model));
    ck_assert_stein(lab_dataset_open(&f->data, data, n, &how, err));
}

static inline lab_fit_def free_these(const char *const *names)
{
    lab_fit_def def = lab_fit_def_default();
    def.free = names;
    def.threads = 2;
    while (names[def.nfree] != NULL) {
        def.nfree++;
    }
    return def;
}

static inline const lab_fit_value *value_of(const lab_fit *fit, const char *name)
{
    for (int k = 0; k < fit->nvalue; k++) {
        if (strcmp(fit->value[k].name, name) == 0) {
            return &fit->value[k];
        }
    }
    ck_abort_msg("%s was not fitted", name);
    return NULL;
}

/** Within so many standard deviations of the truth. */
static inline void ck_assert_found(const lab_fit *fit, const char *name, double truth, double sds)
{
    const lab_fit_value *v = value_of(fit, name);
    ck_assert_msg(fabs(v->value - truth) <= sds * v->sd,
                  "%s: %.9g +- %.3g, the truth is %.9g: %.2f sd", name, v->value, v->sd, truth,
                  (v->value - truth) / v->sd);
}

static inline void ck_assert_status(const lab_fit *fit, lab_fit_status status)
{
    ck_assert_msg(fit->status == status, "%s (%s), chi2/dof %.4g, expected %s",
                  lab_fit_status_text(fit->status), fit->reason, fit->chi2_dof,
                  lab_fit_status_text(status));
}

/* a diagnosis of these strokes, and the data it refers to */
static inline void examine(const char *file, const lab_model *model, const char *const *path, int n,
                           lab_dataset **data, lab_diagnosis **d)
{
    lab_options options = cache_here(NULL);
    lab_data_options o = lab_data_options_default(lab_equations(model));
    lab_diagnose_def def = lab_diagnose_def_default();
    def.options = &options;
    def.threads = 2;
    ck_assert_stein(lab_dataset_open(data, path, n, &o, err));
    ck_assert_stein(lab_diagnose(d, file, model, *data, &def, err));
}

#endif
