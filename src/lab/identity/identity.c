/* SPDX-License-Identifier: GPL-3.0-or-later
 * identity.c - hashes of standard work: strokes, a sweep, a fit. Two builds that print the same
 * compute the same (core/identity.c has the part of the core).
 *
 * The sweep is hashed as the text of its table, which is what people keep: numbers are printed so
 * that they read back, so their text is one as well. The fit is one of a pendulum, filmed here with
 * noise of a fixed seed.
 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "functions.h"
#include "identity_models.h"
#include "sweep.h"
#include "stein/fit.h"
#include "stein/identity.h"
#include "stein/models.h"

enum { FRAMES = 150 };

static stein_status open_standard(lab_model **model, const char *const *lines, const char *name,
                                  const lab_options *options, stein_err *err)
{
    size_t size = 0;
    for (int i = 0; lines[i] != NULL; i++) {
        size += strlen(lines[i]);
    }
    char *text = malloc(size + 1);
    if (text == NULL) {
        return lab__no_memory(err);
    }
    char *to = text;
    for (int i = 0; lines[i] != NULL; i++) {
        size_t n = strlen(lines[i]);
        memcpy(to, lines[i], n);
        to += n;
    }
    *to = '\0';
    stein_status status = lab__open_text(model, name, text, size, options, err);
    free(text);
    return status;
}

/* ---- sweep ---- */

static stein_status sweep(unsigned long long *hash, int threads, stein_err *err)
{
    static const char *const vary[] = {"pawl.stop_shift=-0.9:0.1:3mm", "load.mass=90:110:2g"};
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    stein_status status =
        open_standard(&model, lab__identity_action, "stein1788.yaml", &options, err);
    if (status == STEIN_OK) {
        status = lab_grid_create(&grid, lab_equations(model), vary, 2, err);
    }
    if (status == STEIN_OK) {
        lab_vary_def def = lab_vary_def_default(model);
        def.until = 0.1;
        def.threads = threads;
        def.fixed = 1;
        status = lab_vary(&table, model, grid, &def, NULL, err);
    }
    *hash = STEIN_HASH;
    for (int i = 0; status == STEIN_OK && i < table->n; i++) {
        *hash = lab__hash(*hash, table->row[i], strlen(table->row[i]));
    }
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    lab_close(model);
    return status;
}

/* ---- fit ---- */

/* nearly normal: the sum of twelve even ones */
static double scatter(unsigned long long *seed)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++) {
        *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
        sum += (double)(*seed >> 11) * 0x1p-53 - 0.5;
    }
    return sum;
}

static stein_status film(const char *path, stein_err *err)
{
    static const char *const truth[] = {"rod.damping=2.1e-4", "rod.pendulum.frequency=1.041 Hz"};
    lab_options options = lab_options_default();
    options.set = truth;
    options.nset = 2;
    lab_model *model = NULL;
    stein_sim *sim = NULL;
    lab__file file;
    stein_status status =
        open_standard(&model, lab__identity_pendulum, "pendulum.yaml", &options, err);
    status = status == STEIN_OK ? lab_sim(model, NULL, &sim, err) : status;
    status = status == STEIN_OK ? lab__file_open(&file, path, err) : status;
    if (status == STEIN_OK) {
        unsigned long long seed = 1788;
        char number[2][LAB_NUMBER];
        fprintf(file.stream, "# noise angle: 1e-4\ntime [s],angle [rad]\n");
        for (int i = 0; status == STEIN_OK && i < FRAMES; i++) {
            double t = 0.02 * i;
            status = stein_run(sim, t, err);
            fprintf(file.stream, "%s,%s\n", lab__number(number[0], t),
                    lab__number(number[1], stein_q(sim)[0] + 1e-4 * scatter(&seed)));
        }
        stein_status closed = lab__file_close(&file, status == STEIN_OK, err);
        status = status == STEIN_OK ? closed : status;
    }
    stein_sim_destroy(sim);
    lab_close(model);
    return status;
}

static unsigned long long hash_fit(const lab_fit *fit)
{
    unsigned long long hash = STEIN_HASH;
    for (int i = 0; i < fit->nvalue; i++) {
        const lab_fit_value *v = &fit->value[i];
        const double x[] = {v->value, v->sd, v->lo, v->hi, v->data_sd};
        hash = stein_hash_numbers(hash, x, 5);
    }
    hash = stein_hash_numbers(hash, fit->covariance, fit->nvalue * fit->nvalue);
    const double all[] = {fit->chi2, fit->prior, fit->gradient, fit->inflation, fit->condition};
    return stein_hash_numbers(hash, all, 5);
}

static stein_status fit_film(unsigned long long *hash, const char *path, int threads,
                             stein_err *err)
{
    static const char *const free_names[] = {"rod.damping", "rod.pendulum.frequency"};
    lab_options options = lab_options_default();
    lab_model *model = NULL;
    lab_dataset *data = NULL;
    lab_fit *fit = NULL;
    stein_status status =
        open_standard(&model, lab__identity_pendulum, "pendulum.yaml", &options, err);
    if (status == STEIN_OK) {
        lab_data_options how = lab_data_options_default(lab_equations(model));
        status = lab_dataset_open(&data, &path, 1, &how, err);
    }
    if (status == STEIN_OK) {
        lab_fit_def def = lab_fit_def_default();
        def.free = free_names;
        def.nfree = 2;
        def.threads = threads;
        status = lab_fit_run(&fit, model, data, &def, err);
    }
    if (status == STEIN_OK) {
        *hash = hash_fit(fit);
    }
    lab_fit_destroy(fit);
    lab_dataset_close(data);
    lab_close(model);
    return status;
}

static stein_status fit(unsigned long long *hash, int threads, stein_err *err)
{
    const char *folder = getenv("TMPDIR");
    char *path = lab__text("%s/stein-XXXXXX", folder != NULL && *folder != '\0' ? folder : "/tmp");
    int fd = path != NULL ? mkstemp(path) : -1;
    if (fd < 0) {
        free(path);
        return lab__fail(err, STEIN_EIO, "no temporary file can be made: set TMPDIR");
    }
    close(fd);
    stein_status status = film(path, err);
    status = status == STEIN_OK ? fit_film(hash, path, threads, err) : status;
    unlink(path);
    free(path);
    return status;
}

stein_status lab_identify(lab_identity *identity, int threads, stein_err *err)
{
    lab_identity found;
    stein_status status = stein_identity(stein_models, &found.core, err);
    status = status == STEIN_OK ? sweep(&found.sweep, threads, err) : status;
    status = status == STEIN_OK ? fit(&found.fit, threads, err) : status;
    if (status == STEIN_OK) {
        *identity = found;
    }
    return status;
}
