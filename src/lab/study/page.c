/* SPDX-License-Identifier: GPL-3.0-or-later
 * page.c - study.html: the facts, every part's sentences and pictures, in one file without network.
 *
 * The pictures are the SVG files of the folder, put inline. gnuplot gives the same ids to elements
 * of every picture. Here they get the picture's number, so they are unique in one document.
 */
#include <stdlib.h>
#include <string.h>

#include "study.h"

/* pictures are gnuplot's, dark on white: in the dark their light is turned over and their hues stay
 */
static const char style[] =
    ":root{color-scheme:light dark;--paper:#fbfaf7;--card:#fff;--ink:#222;--quiet:#666;"
    "--line:#e4e0d5;--strong:#8a8678;--link:#1f4e79;--ok:#4d6b29;--off:#a5361d}\n"
    "@media(prefers-color-scheme:dark){:root{--paper:#16181b;--card:#1d2024;--ink:#e8e6e0;"
    "--quiet:#a5a49c;--line:#33373c;--strong:#7d7b72;--link:#8fbbe6;--ok:#a5c97a;--off:#f08a70}"
    "figure svg{filter:invert(.89) hue-rotate(180deg)}}\n"
    "body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 Georgia,'Times New "
    "Roman',serif}\n"
    "main{max-width:1100px;margin:0 auto;padding:2.5rem 1.5rem 4rem}\n"
    "h1{font-size:1.9rem;font-weight:normal;margin:0 0 .3rem}\n"
    "h2{font-size:1.35rem;font-weight:normal;border-top:1px solid var(--line);padding-top:1.4rem;"
    "margin:2.6rem 0 .6rem}\n"
    "p{max-width:52rem;margin:.5rem 0 1rem}\n"
    "nav{margin:1rem 0 0;font-size:.95rem}nav a{margin-right:1.1rem;white-space:nowrap}\n"
    "a{color:var(--link);text-decoration:none}a:hover{text-decoration:underline}\n"
    "table{border-collapse:collapse;font:14px/1.4 Helvetica,Arial,sans-serif;margin:1rem 0}\n"
    "th,td{text-align:left;padding:.32rem 1.4rem .32rem 0;border-bottom:1px solid var(--line)}\n"
    "th{font-weight:600;border-bottom:1px solid var(--strong)}\n"
    "td.ok{color:var(--ok)}td.off{color:var(--off);font-weight:600}\n"
    "figure{margin:1rem 0 1.4rem;padding:.6rem;background:var(--card);border:1px solid var(--line);"
    "display:inline-block;max-width:100%;box-sizing:border-box}\n"
    "figure svg{display:block;max-width:100%;height:auto}\n"
    "figcaption{font:13px/1.4 Helvetica,Arial,sans-serif;color:var(--quiet);padding:.2rem .4rem}\n"
    "@media(max-width:600px){main{padding:1.2rem .8rem 3rem}h1{font-size:1.5rem}"
    "th,td{padding-right:.7rem}figure{overflow-x:auto}figure svg{min-width:40rem;max-width:none}}\n"
    "@media print{:root{color-scheme:light}figure,table{break-inside:avoid}}\n";

static void escaped(FILE *f, const char *text)
{
    for (; *text != '\0'; text++) {
        switch (*text) {
        case '&': fputs("&amp;", f); break;
        case '<': fputs("&lt;", f); break;
        case '>': fputs("&gt;", f); break;
        default: putc(*text, f);
        }
    }
}

/* the SVG element with its own ids: gnuplot's begin with gp or gnuplot */
static void inline_svg(FILE *f, const char *text, int number)
{
    const char *at = strstr(text, "<svg");
    for (at = at != NULL ? at : ""; *at != '\0'; at++) {
        putc(*at, f);
        int id = (*at == '"' || *at == '\'') && at - text >= 3 && strncmp(at - 3, "id=", 3) == 0;
        int reference =
            *at == '#' && (strncmp(at, "#gp", 3) == 0 || strncmp(at, "#gnuplot", 8) == 0);
        if (id || reference) {
            fprintf(f, "s%d", number);
        }
    }
}

static void write_facts(FILE *f, const study *s)
{
    int ok = 0, calibrated = 0;
    fprintf(f, "<h2 id=\"facts\">The published facts</h2>\n<table>\n<tr><th>fact</th><th>paper</th>"
               "<th>simulated</th><th>reproduced if</th><th>numbers of the "
               "model</th><th>verdict</th></tr>\n");
    for (int i = 0; i < s->nfact; i++) {
        ok += s->fact[i].ok != 0;
        calibrated += s->fact[i].calibrated;
        fprintf(f, "<tr><td>");
        escaped(f, s->fact[i].fact);
        fprintf(f, "</td><td>");
        escaped(f, s->fact[i].paper);
        fprintf(f, "</td><td>");
        escaped(f, s->fact[i].simulated);
        fprintf(f, "</td><td>");
        escaped(f, s->fact[i].within);
        fprintf(f, "</td><td>%s</td><td class=\"%s\">%s</td></tr>\n",
                s->fact[i].calibrated ? "calibrated for it" : "not calibrated for it",
                s->fact[i].ok ? "ok" : "off", s->fact[i].ok ? "ok" : "off");
    }
    fprintf(
        f,
        "</table>\n<p>%d of %d facts reproduced, with one parameter set for all figures. The "
        "paper, "
        "\"Multibody dynamics as a tool for historical research: study of an 18th century piano "
        "action of Johann Andreas Stein\", prints no table of its numbers. %d of the facts come "
        "out "
        "because numbers of the model were calibrated for them; only the others test the model. "
        "The "
        "slope is that of a straight line through dx = &minus;1.2 .. 0 mm.</p>\n",
        ok, s->nfact, calibrated);
}

static stein_status write_charts(FILE *f, const study_part *part, const char *folder, int *number,
                                 stein_err *err)
{
    for (int i = 0; i < part->nchart; i++) {
        char *path = lab__text("%s/%s.svg", folder, part->chart[i].name);
        char *text = NULL;
        size_t size = 0;
        stein_status status =
            path != NULL ? lab__read_file(path, &text, &size, err) : lab__no_memory(err);
        free(path);
        if (status != STEIN_OK) {
            return status;
        }
        fprintf(f, "<figure id=\"%s\" tabindex=\"0\">\n", part->chart[i].name);
        inline_svg(f, text, ++*number);
        fprintf(f, "\n<figcaption>%s.svg</figcaption>\n</figure>\n", part->chart[i].name);
        if (part->chart[i].text != NULL) {
            fprintf(f, "<p>%s</p>\n", part->chart[i].text);
        }
        free(text);
    }
    return STEIN_OK;
}

static stein_status write_page(FILE *f, const study *s, const study_report *report,
                               const char *folder, stein_err *err)
{
    const char *name = lab_equations(s->model)->name;
    int number = 0;
    stein_status status = STEIN_OK;
    fprintf(f, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>");
    escaped(f, name);
    fprintf(f, ": study of the action</title>\n<style>\n%s</style>\n</head>\n<body>\n<main>\n<h1>",
            style);
    escaped(f, name);
    fprintf(f,
            ": study of the action</h1>\n<p>Every number on this page is computed from this run of "
            "the model.</p>\n<nav><a href=\"#facts\">The published facts</a>\n");
    for (int i = 0; i < report->npart; i++) {
        fprintf(f, "<a href=\"#part-%s\">%s</a>\n", report->part[i].id, report->part[i].title);
    }
    fprintf(f, "</nav>\n");
    write_facts(f, s);
    for (int i = 0; status == STEIN_OK && i < report->npart; i++) {
        const study_part *part = &report->part[i];
        fprintf(f, "<h2 id=\"part-%s\">%s</h2>\n", part->id, part->title);
        if (part->text != NULL) {
            fprintf(f, "<p>%s</p>\n", part->text);
        }
        status = write_charts(f, part, folder, &number, err);
        if (part->ntable > 0) {
            fprintf(f, "<p>Data:");
            for (int k = 0; k < part->ntable; k++) {
                if (part->table[k].name[0] != '\0') {
                    fprintf(f, " <a href=\"%s.csv\">%s.csv</a>", part->table[k].name,
                            part->table[k].name);
                }
            }
            fprintf(f, "</p>\n");
        }
    }
    fprintf(f, "</main>\n</body>\n</html>\n");
    return status;
}

stein_status study_page(const study *s, const study_report *report, const char *folder,
                        stein_err *err)
{
    lab__file file;
    char *path = lab__text("%s/study.html", folder);
    stein_status status = path == NULL ? lab__no_memory(err) : lab__file_open(&file, path, err);
    if (status == STEIN_OK) {
        status = write_page(file.stream, s, report, folder, err);
        stein_status closed = lab__file_close(&file, status == STEIN_OK, err);
        status = status == STEIN_OK ? closed : status;
    }
    free(path);
    return status;
}
