/* SPDX-License-Identifier: GPL-3.0-or-later
 * cli.h - shared by the commands of `stein`. One file a command; only these files print or exit.
 *
 *   main.c        the table of commands       options.c   parsing, did you mean
 *   help.c        --help                      names.c     lists of names
 *   manual.c      manual pages                report.c    models, failures, progress, quantities
 *   completion.c  for shells                  results.c   tables of sweep and merge
 *   summary.c       diagnosis in a terminal     problems.c  a line and a caret
 *   watch.c       again when a file changes
 * Included by: this folder.
 */
#ifndef CLI_H
#define CLI_H

#include "plot.h"
#include "sweep.h"
#include "stein/diagnose.h"

enum { CLI_OK, CLI_FAILED, CLI_USAGE, CLI_NUMERICAL }; /* exit codes */
enum { CLI_OPTIONS = 16, CLI_SETS = 256, CLI_VARIES = 32, CLI_OPERANDS = 4096 };

/** One option of a command. */
typedef struct cli_option {
    const char *name;
    char letter;       /* 0: only the long form */
    const char *value; /* placeholder; NULL for a flag */
    const char *help;
} cli_option;

/** Common options, at the end of every table. */
#define CLI_COMMON                                                                               \
    {"set", 0, "NAME=VALUE[unit]",                                                               \
     "Override a number of the file, e.g. --set pawl.stop_shift=-0.3mm. Repeatable. A number\n"  \
     "without unit is SI. A structural zero that is set changes the equations: they are then\n"  \
     "generated and compiled again."},                                                           \
        {"inertia", 0, "accept|balance|refuse",                                                  \
         "Treatment of an inertia that no body can have: accepted with a warning, replaced by\n" \
         "three equal moments, or refused (the default), for all bodies at once."},              \
        {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},   \
        {"help", 'h', NULL, "Print this page."},                                                 \
    {                                                                                            \
        NULL, 0, NULL, NULL                                                                      \
    }

typedef struct cli_args cli_args;

/** One command and its manual page. */
typedef struct cli_command {
    const char *name, *summary;
    const char *operands;      /* "MODEL" */
    int noperands;             /* so many */
    int more;                  /* 1: or any number more */
    const cli_option *options; /* closed by a NULL name */
    const char *description, *output, *examples;
    int (*run)(const cli_args *args);
} cli_command;

/** A parsed command line. */
struct cli_args {
    const cli_command *command;
    const char *program;            /* its name on the command line: "stein", "build/stein" */
    const char *value[CLI_OPTIONS]; /* last value of each option; "" for a flag; NULL: not given */
    const char *set[CLI_SETS];
    int nset;
    const char *vary[CLI_VARIES]; /* NAME=VALUES, of the commands that have --vary */
    int nvary;
    const char *held[CLI_OPERANDS]; /* words of --held-out and --holdout */
    int nheld;
    const char *operand[CLI_OPERANDS];
    int noperand;
};

extern const cli_command cli_new, cli_check, cli_show, cli_generate, cli_strike, cli_simulate,
    cli_sweep, cli_merge, cli_study, cli_effects, cli_fit, cli_diagnose, cli_plan, cli_import,
    cli_linearise, cli_page, cli_export, cli_version;
/** All commands, closed by NULL. */
extern const cli_command *const cli_commands[];

/* ---- options.c ---- */

/** Parse the words after the command's name. @return CLI_OK, or CLI_USAGE after a message */
int cli_parse(cli_args *args, const cli_command *command, int argc, char **argv);
/** Value of an option, "" for a flag that was given, NULL when it was not. */
const char *cli_value(const cli_args *args, const char *option);
/** A time option ("0.3 s", "300ms"); *seconds stays when it was not given. */
int cli_time(const cli_args *args, const char *option, double *seconds);
/** A whole number from 1 to most; *value stays when it was not given.
 *  @return CLI_OK, or CLI_USAGE after a message */
int cli_count(const cli_args *args, const char *option, int most, int *value);
/** --jobs, else one thread a processor. @return as cli_count */
int cli_threads(const cli_args *args, int *threads);
/** The nearest of n names (NULL: none is near). */
const char *cli_nearest(const char *name, const char *const *names, int n);
/** "stein strike: MESSAGE" and a pointer to --help. @return CLI_USAGE */
int cli_misuse(const cli_command *command, const char *format, ...);

/* ---- names.c ---- */

enum { CLI_NAMES = 128 };
/** "a,b,c" cut at the commas.
 *  @param memory  out, behind the names, freed by the caller  @param name  [CLI_NAMES] out
 *  @return their number, -1: too many, an empty one, or no memory */
int cli_names(const char *option, char **memory, const char **name);
/** Are the names of --free parameters of the equations? @return CLI_OK, or CLI_USAGE after a
 *  message with suggestions */
int cli_free_known(const cli_args *args, const lab_model *model, const char *const *name, int n);

/* ---- help.c ---- */

extern const char *const cli_exit_status;
void cli_help(const cli_command *command);

/* ---- manual.c: the manual pages, in roff on standard output ---- */

void cli_manual(const cli_command *command);
void cli_manual_overview(void);

/* ---- completion.c ---- */

/** The completion of a shell (bash, zsh, fish) on standard output. @return an exit code */
int cli_completion(const char *shell);

/* ---- check_data.c ---- */

/** The records of stein check: audit and suspicions, as text, or into the object of `out`.
 *  @return the exit code */
int cli_check_data(const cli_args *args, lab__json *out);

/* ---- summary.c ---- */

/** A diagnosis on standard output, in at most 9 lines; all of it is in the report. */
void cli_summary(const char *model, const lab_diagnosis *d);

/* ---- watch.c ---- */

/** Run the command now, and again whenever a file of its operands changes, until it is interrupted
 *  or its output is closed. @return the code of the last run */
int cli_watch(const cli_args *args, int (*run)(const cli_args *args));

/* ---- check_loops.c ---- */

/** The loops and couplings of stein check, as text or into the object of `out`; nothing where there
 *  are none. @return the exit code: do they close? */
int cli_check_loops(const cli_args *args, const mechanism *m, lab__json *out);
/* ---- plan_before.c ---- */

/** stein plan --before. @return the exit code */
int cli_plan_before(const cli_args *args);

/* ---- results.c ---- */

/** Points of a table. */
typedef struct cli_counts {
    int present, failed;
} cli_counts;
cli_counts cli_results_count(const lab_table *table);
/** Can the files of -o, --plot and --json be written? @return CLI_OK, or a code after a message */
int cli_results_check(const cli_args *args);
/** Write these files, and a summary. @param only_part  no table without -o
 *  @return CLI_OK, CLI_FAILED, CLI_NUMERICAL (every point failed) */
int cli_results(const cli_args *args, const lab_table *table, int only_part);
/** Report damaged lines of a journal, if there are any. */
void cli_damaged(int lines);

/* ---- problems.c ---- */

/** A problem of a mechanism file on standard error; where it has a place in the file, the line and
 *  a caret below it (a lab_report_fn).
 *  @param file  its path, as given to the reader */
void cli_problem(void *file, const char *message);

/* ---- reactions.c ---- */

/** A warning on standard error of outputs that the motion does not determine in the present state,
 *  with what helps; the same as "undetermined" of an object. */
void cli_warn_reactions(stein_sim *sim);
void cli_put_reactions(lab__json *out, stein_sim *sim);

/* ---- report.c ---- */

/** Open the model with the overrides; problems of the file go to standard error. */
stein_status cli_open(lab_model **model, const cli_args *args, stein_err *err);
/** Read a mechanism with the overrides alone, without its equations. */
stein_status cli_mechanism(mechanism **m, const cli_args *args, stein_err *err);
/** Print the failure on standard error, unless the message is empty. @return the exit code of the
 * status */
int cli_failed(stein_status status, const stein_err *err);
/** Flush standard output. @return code, or CLI_FAILED when it could not be written */
int cli_finish(int code);

/** Progress on a terminal, for work above a second. */
typedef struct cli_progress {
    const char *what;
    double start, shown; /* [s] */
    int on;              /* standard error is a terminal */
} cli_progress;
void cli_progress_begin(cli_progress *p, const char *what);
void cli_progress_show(cli_progress *p, double fraction);
void cli_progress_end(cli_progress *p);
/** A bar on a terminal, else a line now and then. @param ctx  the cli_progress */
void cli_progress_step(void *ctx, double fraction, const char *step);
/** The same while data are read (a lab_read_progress_fn). */
void cli_progress_read(void *ctx, double fraction);

enum { CLI_TEXT = 64 };
/** A quantity for people: "7.2 mm", "82 g", "1.571 rad = 90 deg". @param text [CLI_TEXT] */
const char *cli_quantity(char *text, double value, const char *unit);
/** Columns a UTF-8 text takes. */
int cli_width(const char *text);

#endif
