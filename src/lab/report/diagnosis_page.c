/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_page.c - report.html: one file without network, scripts or embedded fonts.
 *
 * The first screen (diagnosis_summary.c) answers the questions; the rest shows why.
 *
 * Each colour has one meaning: rust the model before, blue the model after, grey measurements,
 * green noise, violet a cause and its rivals, amber a warning.
 */
#include "diagnosis_page.h"

static const char *const style[] = {
    ":root{color-scheme:light dark;--paper:#fbfaf7;--card:#fff;--ink:#23241f;--quiet:#6d6a60;"
    "--line:#e2ded2;--grid:#efece3;--blue:#1f4e79;--rust:#b5482f;--dot:#9b988c;--area:#e2e8d0;"
    "--cause:#6a4a94;--warn:#8a5a00;--amber:#fdf3dc;--phase:#f5f3ec;--h1:#f6e6cf;--h2:#f1cda6;--h3:"
    "#e6a57a;--h4:#d27554;--h5:#"
    "b5482f;--hot:#fff}\n",
    "@media(prefers-color-scheme:dark){:root{--paper:#16181a;--card:#1d2023;--ink:#e4e1d8;"
    "--quiet:#9a978c;--line:#33373b;--grid:#282c2f;--blue:#7fb2e0;--rust:#e58a6c;--dot:#77756c;"
    "--area:#2f3729;--cause:#b79be0;--warn:#f0c05a;--amber:#332a14;--phase:#212528;--h1:#3a3025;--"
    "h2:#553a26;--h3:#7a4a2c;"
    "--h4:#8a4526;--h5:#b0472a;--hot:#fff}}\n",
    "*{box-sizing:border-box}html{-webkit-text-size-adjust:100%}\n"
    "body{margin:0;background:var(--paper);color:var(--ink);font:17px/1.55 Georgia,'Times New "
    "Roman',serif}\n"
    "main{max-width:1160px;margin:0 auto;padding:2.2rem 1.2rem 4rem}\n"
    ".eyebrow,.quiet,figcaption,.legend,small,dt,.tag{font-family:Helvetica,Arial,sans-serif}\n"
    ".eyebrow{color:var(--quiet);font-size:.8rem;letter-spacing:.02em;margin:0 0 .5rem}\n"
    "h1{font-size:clamp(1.55rem,4.4vw,2.35rem);line-height:1.2;font-weight:normal;margin:0 0 "
    ".7rem;max-width:24em}\n"
    "h2{font-size:1.35rem;font-weight:normal;margin:0 0 .5rem}\n"
    "h3{font-size:1.05rem;font-weight:normal;font-style:italic;margin:1.2rem 0 .4rem}\n"
    "p{max-width:46rem;margin:.4rem 0 .9rem}.reason{font-size:1.08rem}\n"
    "section{border-top:1px solid var(--line);padding-top:1.3rem;margin-top:2.6rem}\n"
    "sup{font-size:.7em;line-height:0}.ci{color:var(--quiet);white-space:nowrap}\n"
    ".quiet{color:var(--quiet);font-size:.85rem}\n",
    ".story{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,310px),1fr));gap:."
    "9rem;"
    "margin:1.4rem 0 0}\n"
    ".card{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:.8rem "
    "1rem .9rem}\n"
    ".card h2{font:600 .78rem/1.3 Helvetica,Arial,sans-serif;color:var(--quiet);margin:0 0 "
    ".35rem}\n"
    ".card p{margin:.2rem 0}.card .big{font-size:1.3rem;line-height:1.3}\n"
    ".card .ci{font-size:.8em}.card ul{margin:.2rem 0;padding-left:1.1rem}.card "
    "svg{display:block;width:100%;height:auto;"
    "margin-top:.4rem}\n"
    ".against{max-width:60rem;margin:.6rem 0 0;padding:.6rem 1rem .6rem 2rem;border-left:4px solid "
    "var(--warn);background:var(--amber)}.card.warning{border-color:var(--warn);background:var(--"
    "amber)}"
    "a{color:inherit}\n",
    ".plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,320px),1fr));"
    "gap:.9rem}\n"
    "figure{margin:0;padding:.5rem .5rem .6rem;background:var(--card);border:1px solid "
    "var(--line);border-radius:6px;max-width:54rem}\n"
    "figure svg{display:block;width:100%;height:auto}figcaption{font-size:.85rem;"
    "color:var(--quiet);padding:.1rem .4rem 0}\n"
    ".legend{font-size:.85rem;color:var(--quiet)}.key{display:inline-block;width:1.5em;height:0;"
    "border-top:2.5px solid;vertical-align:.25em;margin:0 .45em 0 1.3em}\n"
    ".key.dot{border-top-style:dotted;border-color:var(--dot);margin-left:0}.key.rust{border-color:"
    "var(--rust)}.key.blue{border-color:var(--blue)}.key.area{border-top:.8em solid var(--area);"
    "vertical-align:-.1em}\n",
    "svg text{font:11px Helvetica,Arial,sans-serif;fill:var(--quiet);text-anchor:middle}\n"
    "svg .side,svg .label{text-anchor:end}svg .begin{text-anchor:start}svg .label{fill:var(--ink)}"
    "svg .name{font-size:9.5px}"
    "@media(min-width:1000px){.plots{grid-template-columns:1fr 1fr}}"
    "@media(max-width:999px){svg text{font-size:14px}svg .name{font-size:11px}}\n"
    ".grid{stroke:var(--grid);fill:none}.zero{stroke:var(--dot);fill:none}.phase{fill:var(--phase)}"
    ".noise{fill:var(--area)}.cause-curve{fill:none;stroke:var(--cause);stroke-width:1.7}"
    ".tip{fill:transparent}.tip:hover{fill:var(--ink);fill-opacity:.1}\n"
    ".before,.after{fill:none;stroke-width:1.7;stroke-linejoin:round}.thin{stroke-width:.8;opacity:"
    ".28}\n"
    ".before{stroke:var(--rust)}.after{stroke:var(--blue)}.measured{fill:none;stroke:var(--dot);"
    "stroke-width:2.6;stroke-linecap:round}\n",
    ".scroll{overflow-x:auto}table{border-collapse:collapse;font:14px/1.4 Helvetica,Arial,"
    "sans-serif;margin:.6rem 0}\n"
    "th,td{text-align:left;padding:.34rem .9rem .34rem 0;border-bottom:1px solid var(--line);"
    "font-weight:normal;vertical-align:top;white-space:nowrap}\n"
    "tr:first-child>th{color:var(--quiet);font-size:.85em}td:last-child{white-space:normal}\n"
    "small{color:var(--quiet);font-size:.8em}th small{display:block}td small{margin-left:.4em}\n"
    ".map{border-collapse:separate;border-spacing:3px}.map th,.map td{border:0;padding:.3rem "
    ".55rem}.map small{display:block;margin:0;color:inherit}\n"
    "th[scope=row]{position:sticky;left:0;background:var(--paper)}.map td:last-child{white-space:"
    "nowrap}\n"
    ".map .half th{color:var(--quiet);font-size:.85em;padding-top:.7rem}\n"
    ".heat{border-radius:4px;background:var(--phase);min-width:5.2em}.heat.none{background:none}"
    ".h1{background:var(--h1)}.h2{background:var(--h2)}.h3{background:var(--h3)}.h4{background:"
    "var(--h4)}.h5{background:var(--h5);color:var(--hot)}\n",
    ".bar{width:34%;min-width:110px}.suspects .bar{width:16%}"
    "@media(min-width:601px){.suspects td:last-child{min-width:17rem}.suspects td:nth-child(4){"
    "white-space:normal}}.bar svg{display:block;width:100%;height:15px}\n"
    ".full{fill:var(--dot)}.predicted{fill:var(--grid)}.cause .full{fill:var(--cause)}.rival "
    ".full{fill:var(--cause);opacity:.5}.gains .full{fill:var(--blue)}.span{fill:var(--area)}.one{"
    "stroke:var(--dot);vector-effect:non-scaling-stroke}\n"
    ".impossible{color:var(--quiet)}.cause th{font-weight:600}\n"
    "summary{cursor:pointer;padding:.3rem 0}ul{max-width:52rem}li{margin:.15rem "
    "0}footer{margin-top:3rem}\n"
    "@media(max-width:480px){body{font-size:16px}main{padding:1.3rem .9rem 3rem}}\n"
    // on a phone a row of a table is a block, its cells named by their columns
    "@media(max-width:600px){.fold,.fold tbody,.fold tr,.fold th,.fold td{display:block;width:auto;"
    "white-space:normal;border:0;padding:.1rem 0}.fold tr{border-bottom:1px solid var(--line);"
    "padding:.5rem 0}.fold tr:first-child{display:none}.fold td:empty{display:none}.fold "
    "th[scope=row]{position:static}.fold td:not(.bar)::before{color:var(--quiet)}"
    ".suspects td:nth-child(3)::before{content:'fall '}.suspects td:nth-child(4)::before{content:"
    "'amount '}.gains td:nth-child(2)::before{content:'before '}.numbers "
    "td:nth-child(2)::before{content:'file '}"
    ".gains td:nth-child(3)::before{content:'after '}.numbers "
    "td:nth-child(3)::before{content:'fitted '}.gains "
    "td:nth-child(4)::before{content:'noise '}.gains td:nth-child(5)::before{content:'after / "
    "before '}.numbers td:nth-child(4)::before{content:'moved '}.seen td:nth-child(2)::before{"
    "content:'estimate '}.seen td:nth-child(3)::before{content:'would be named from '}.seen "
    "td:nth-child(4)::before{content:'upper limit '}.check td:nth-child(3)::before{content:'acted "
    "'}.check td:nth-child(4)::before{content:'error before '}.check "
    "td:nth-child(5)::before{content:'error after '}.check td:nth-child(6)::before{content:'from "
    "noise '}.check td:nth-child(7)::before{content:'mean before '}.check "
    "td:nth-child(8)::before{content:'mean after '}.check "
    "td:nth-child(9)::before{content:'\xc2\xb1 '}.seen td:nth-child(5)::before{content:'of the "
    "largest plausible size '}}\n"
    "@media print{body{background:#fff}figure,table,.card{break-inside:avoid}}\n"};

/* ---- the page ---- */

static void write_page(FILE *f, const lab_diagnosis *d)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
          "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Diagnosis: ",
          f);
    fputs(diag__verdict_words(d->verdict), f);
    fputs("</title>\n<style>\n", f);
    for (size_t i = 0; i < sizeof style / sizeof *style; i++) {
        fputs(style[i], f);
    }
    fputs("</style>\n</head>\n<body>\n<main>\n", f);
    page__summary(f, d);
    page__law(f, d);
    page__strokes(f, d);
    page__map(f, d);
    page__forces(f, d);
    page__motion(f, d);
    page__suspects(f, d);
    page__seen(f, d);
    page__gains(f, d);
    page__parameters(f, d);
    page__audit(f, d);
    fprintf(f, "<footer><p class=\"quiet\">%d fits, %d records simulated, ", d->fits,
            d->strokes_simulated);
    page__number(f, d->seconds, 3);
    fputs("&nbsp;s. The same figures for programs are in diagnosis.json.</p></footer>\n</main>\n"
          "</body>\n</html>\n",
          f);
}

stein_status lab_diagnosis_page(const char *path, const lab_diagnosis *d, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status == STEIN_OK) {
        write_page(file.stream, d);
        status = lab__file_close(&file, 1, err);
    }
    return status;
}
