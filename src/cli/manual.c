/* SPDX-License-Identifier: GPL-3.0-or-later
 * manual.c - the same texts as --help, as manual pages: stein(1) and one page a command.
 *
 * Written in the classic man macros. What is typed by hand is a text of short paragraphs: those
 * that have an indented line are set as they stand, all others flow.
 */
#include <ctype.h>
#include <string.h>

#include "cli.h"

static void title(const char *page)
{
    printf(".TH ");
    for (const char *c = page; *c != '\0'; c++) {
        putchar(toupper((unsigned char)*c));
    }
    printf(" 1 %s \"stein %s\" \"User Commands\"\n", STEIN_RELEASED, STEIN_VERSION);
}

/* characters as they are: no hyphen, no escape, no request at the beginning of a line */
static void put(const char *text, size_t length)
{
    if (length > 0 && (text[0] == '.' || text[0] == '\'')) {
        printf("\\&");
    }
    for (size_t i = 0; i < length; i++) {
        switch (text[i]) {
        case '\\': printf("\\e"); break;
        case '-': printf("\\-"); break;
        case '\'': printf("\\(aq"); break;
        case '`': printf("\\(ga"); break;
        case '~': printf("\\(ti"); break;
        case '^': printf("\\(ha"); break;
        default: putchar(text[i]); break;
        }
    }
}

/* the lines of a text, which the formatter fills */
static void flowing(const char *text, size_t length)
{
    while (length > 0) {
        size_t line = strcspn(text, "\n");
        line = line < length ? line : length;
        put(text, line);
        putchar('\n');
        line += line < length;
        text += line;
        length -= line;
    }
}

/* the same as they stand */
static void literal(const char *text, size_t length)
{
    printf(".nf\n");
    flowing(text, length);
    printf(".fi\n");
}

/* the paragraphs of a text; `between` is the request that parts them */
static void paragraphs(const char *text, const char *between)
{
    for (int first = 1; *text != '\0'; first = 0) {
        const char *end = strstr(text, "\n\n");
        size_t length = end != NULL ? (size_t)(end - text) : strlen(text);
        const char *indented = text[0] == ' ' ? text : strstr(text, "\n ");
        if (!first) {
            printf("%s\n", between);
        }
        if (indented != NULL && indented < text + length) {
            literal(text, length);
        } else {
            flowing(text, length);
        }
        text += length + (end != NULL ? 2 : 0);
    }
}

static void section(const char *name, const char *text)
{
    printf(".SH %s\n", name);
    paragraphs(text, ".PP");
}

static void examples(const char *text)
{
    printf(".SH EXAMPLES\n");
    literal(text, strlen(text));
}

static void options(const cli_option *o)
{
    printf(".SH OPTIONS\n");
    for (; o->name != NULL; o++) {
        printf(".TP\n");
        if (o->letter != 0) {
            printf("\\fB\\-%c\\fR, ", o->letter);
        }
        printf("\\fB\\-\\-");
        put(o->name, strlen(o->name));
        printf("\\fR");
        if (o->value != NULL) {
            printf(" \\fI");
            put(o->value, strlen(o->value));
            printf("\\fR");
        }
        putchar('\n');
        paragraphs(o->help, ".sp");
    }
}

void cli_manual(const cli_command *c)
{
    char page[64];
    snprintf(page, sizeof page, "stein-%s", c->name);
    title(page);
    printf(".SH NAME\nstein\\-%s \\- ", c->name);
    put(c->summary, strlen(c->summary));
    printf("\n.SH SYNOPSIS\n\\fBstein %s\\fR \\fI", c->name);
    put(c->operands, strlen(c->operands));
    printf("\\fR [\\fIoptions\\fR]\n");
    section("DESCRIPTION", c->description);
    options(c->options);
    section("OUTPUT", c->output);
    printf(".SH EXIT STATUS\n");
    literal(cli_exit_status, strlen(cli_exit_status));
    examples(c->examples);
    printf(".SH SEE ALSO\n.BR stein (1)\n");
}

void cli_manual_overview(void)
{
    title("stein");
    printf(".SH NAME\nstein \\- multibody dynamics of mechanisms with contacts\n"
           ".SH SYNOPSIS\n\\fBstein\\fR \\fICOMMAND MODEL\\fR [\\fIoptions\\fR]\n");
    section("DESCRIPTION",
            "Writes the equations of motion of a mechanism from a description file, simulates it\n"
            "with contacts, fits it to measured records, and names the physical effects that the\n"
            "simulation lacks. MODEL is a mechanism file in YAML: bodies, joints, contacts,\n"
            "inputs, outputs. Its first mechanism is the piano action that Johann Andreas Stein\n"
            "built in 1788.\n"
            "\n"
            "Equations that are not built in are generated, compiled with the system's C compiler\n"
            "into a cache and loaded. Changing a number never needs a compiler.");
    printf(".SH COMMANDS\n");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf(".TP\n.BR stein\\-%s (1)\n", (*c)->name);
        put((*c)->summary, strlen((*c)->summary));
        putchar('\n');
    }
    printf(".TP\n\\fBstein help\\fR [\\fICOMMAND\\fR]\nprint the list, or the page of one\n"
           ".TP\n\\fBstein help \\-\\-manual\\fR [\\fICOMMAND\\fR]\nthe same as a manual page\n"
           ".TP\n\\fBstein help \\-\\-completion\\fR [\\fISHELL\\fR]\nprint the completion of "
           "bash, zsh or fish\n"
           ".TP\n\\fBstein \\-\\-version\\fR\nprint the version\n");
    printf(".SH EXIT STATUS\n");
    literal(cli_exit_status, strlen(cli_exit_status));
    printf(".SH ENVIRONMENT\n"
           ".TP\n.B CC\nthe compiler of equations that are not built in; default: cc\n"
           ".TP\n.B XDG_CACHE_HOME\nwhere they are kept, in a folder stein; default: ~/.cache\n");
    examples("stein strike stein1788.yaml --set pawl.stop_shift=-0.3mm --plot stroke.svg\n"
             "stein diagnose stein1788.yaml strokes/*.csv -o out");
    printf(".SH SEE ALSO\n.BR steingen (1)\n");
}
