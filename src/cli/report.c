/* SPDX-License-Identifier: GPL-3.0-or-later
 * report.c - failures, progress, and quantities in units people read.
 */
#include <errno.h>
#include <math.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"

/* the problems of a mechanism file have been told one by one */
static stein_status told(stein_status status, stein_err *err)
{
    if (status == STEIN_EPARSE) {
        err->msg[0] = '\0';
    }
    return status;
}

stein_status cli_mechanism(mechanism **m, const cli_args *args, stein_err *err)
{
    mech_set set[CLI_SETS];
    char names[CLI_SETS][MECH_PATH];
    for (int i = 0; i < args->nset; i++) {
        size_t length = strcspn(args->set[i], "=");
        if (length >= MECH_PATH) {
            return lab__fail(err, STEIN_EINVAL, "--set %s: the name is too long", args->set[i]);
        }
        memcpy(names[i], args->set[i], length);
        names[i][length] = '\0';
        set[i] = (mech_set){names[i], args->set[i] + length + 1};
    }
    const char *file = args->operand[0];
    return told(mech_read(m, file, set, args->nset, cli_problem, (char *)file, err), err);
}

stein_status cli_open(lab_model **model, const cli_args *args, stein_err *err)
{
    lab_options options = lab_options_default();
    options.set = args->set;
    options.nset = args->nset;
    options.report = cli_problem;
    options.ctx = (char *)args->operand[0];
    return told(lab_open(model, args->operand[0], &options, err), err);
}

int cli_failed(stein_status status, const stein_err *err)
{
    if (err->msg[0] != '\0') {
        fprintf(stderr, "stein: %s\n", err->msg);
    }
    switch (status) {
    case STEIN_OK: return CLI_OK;
    case STEIN_ENONFINITE:
    case STEIN_ESINGULAR:
    case STEIN_ECHATTER:
    case STEIN_ESETTLE: return CLI_NUMERICAL;
    default: return CLI_FAILED;
    }
}

int cli_finish(int code)
{
    errno = 0;
    if (fflush(stdout) != 0 || ferror(stdout)) {
        if (errno != EPIPE) { // as of `stein effects MODEL | head`, which is no mistake
            perror("stein: standard output");
        }
        return code == CLI_OK ? CLI_FAILED : code;
    }
    return code;
}

/* ---- progress ---- */

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void cli_progress_begin(cli_progress *p, const char *what)
{
    *p = (cli_progress){.what = what, .start = seconds(), .on = isatty(STDERR_FILENO)};
}

/* seconds to come, if they go on as they did */
static double left(double spent, double fraction)
{
    return fraction > 0.0 ? spent * (1.0 / fraction - 1.0) : 0.0;
}

void cli_progress_show(cli_progress *p, double fraction)
{
    enum { BAR = 30 };
    if (!p->on) {
        return;
    }
    double now = seconds(), spent = now - p->start;
    if (spent < 1.0 || now - p->shown < 0.1 || (p->shown == 0.0 && fraction > 0.7)) {
        return;
    }
    p->shown = now;
    int full = (int)(BAR * fraction);
    fprintf(stderr, "\r%s [", p->what);
    for (int i = 0; i < BAR; i++) {
        fputs(i < full ? "#" : ".", stderr);
    }
    fprintf(stderr, "] %3.0f %%  %.0f s left ", 100.0 * fraction, left(spent, fraction));
}

/* a line now and then where the output is no terminal */
static void progress_line(cli_progress *p, double fraction)
{
    enum { SECONDS_A_LINE = 5 };
    double now = seconds();
    if (!p->on && now - p->start >= SECONDS_A_LINE && now - p->shown >= SECONDS_A_LINE) {
        p->shown = now;
        fprintf(stderr, "%s: %.0f %%, %.0f s left\n", p->what, 100.0 * fraction,
                left(now - p->start, fraction));
    }
}

void cli_progress_end(cli_progress *p)
{
    if (p->on && p->shown > 0.0) {
        fputs("\r\033[K", stderr);
    }
}

void cli_progress_step(void *ctx, double fraction, const char *step)
{
    cli_progress *p = ctx;
    p->what = step;
    cli_progress_show(p, fraction);
    progress_line(p, fraction);
}

void cli_progress_read(void *ctx, double fraction)
{
    cli_progress_step(ctx, fraction, "reading");
}

/* ---- for people ---- */

const char *cli_quantity(char *text, double value, const char *unit)
{
    static const struct {
        const char *si, *shown;
        double factor, below; /* used below this magnitude [SI] */
    } scale[] = {{"m", "mm", 1e3, 1.0},
                 {"kg", "g", 1e3, 1.0},
                 {"s", "us", 1e6, 1e-3},
                 {"s", "ms", 1e3, 1.0},
                 {"kg m^2", "kg mm^2", 1e6, 1e-2}};
    for (size_t i = 0; i < sizeof scale / sizeof *scale; i++) {
        if (strcmp(unit, scale[i].si) == 0 && fabs(value) < scale[i].below && value != 0.0) {
            snprintf(text, CLI_TEXT, "%.6g %s", value * scale[i].factor, scale[i].shown);
            return text;
        }
    }
    if (strcmp(unit, "rad") == 0 && value != 0.0) {
        snprintf(text, CLI_TEXT, "%.6g rad = %.4g deg", value, value * 180.0 / acos(-1.0));
    } else if (strcmp(unit, "1") == 0) {
        snprintf(text, CLI_TEXT, "%.6g", value);
    } else {
        snprintf(text, CLI_TEXT, "%.6g %s", value, unit);
    }
    return text;
}

int cli_width(const char *text)
{
    int n = 0;
    for (; *text != '\0'; text++) {
        n += ((unsigned char)*text & 0xC0) != 0x80;
    }
    return n;
}
