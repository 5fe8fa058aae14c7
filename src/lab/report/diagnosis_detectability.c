/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_detectability.c - the list of all candidates by their detectability (detectability.c).
 */
#include <math.h>

#include "diagnosis_page.h"

static const struct {
    lab_presence presence;
    const char *title, *what;
} groups[] = {{LAB_PRESENT, "present", "named by the verdict"},
              {LAB_WEAK, "plausible but weak",
               "some evidence for it, or a plausible amount is within the uncertainty"},
              {LAB_ABSENT, "absent",
               "one as large as is plausible would have been named, with 95&nbsp;% probability"},
              {LAB_NOT_TESTABLE, "not testable with these data",
               "no effect above the noise that other unknowns do not have as well"}};
enum { GROUPS = sizeof groups / sizeof *groups };

int diag__count(const lab_diagnosis *d, lab_presence presence)
{
    int n = 0;
    for (int i = 0; i < d->nsuspect; i++) {
        n += d->suspect[i].power.presence == presence;
    }
    return n;
}

static void share(FILE *f, double part)
{
    if (isfinite(part)) {
        page__number(f, 100.0 * part, 2);
        fputs("&nbsp;%", f);
    }
}

static void row(FILE *f, const lab_diagnosis *d, int i)
{
    const lab_suspect *s = &d->suspect[i];
    const lab_power *p = &s->power;
    int own = i < d->ncause + d->nrival && s->nnumber > 0;
    fputs("<tr><th scope=\"row\">", f);
    page__words(f, s->candidate.effect != NULL ? s->candidate.effect->kind : "");
    fputs("<small>", f);
    page__text(f, s->candidate.place);
    fputs("</small></th><td>", f);
    if (own) { // as everywhere else in the report
        page__interval(f, s->number[0].value, s->number[0].lo, s->number[0].hi, s->number[0].unit);
    } else if (isfinite(p->amount)) {
        page__interval(f, p->amount, p->amount - 1.96 * p->sd, p->amount + 1.96 * p->sd,
                       s->candidate.unit);
    }
    fputs("</td><td>", f);
    if (isfinite(p->detectable)) {
        page__quantity(f, p->detectable, s->candidate.unit, 2);
    }
    fputs("</td><td>", f);
    if (isfinite(p->upper)) {
        page__quantity(f, p->upper, s->candidate.unit, 2);
    }
    fputs("</td><td>", f);
    share(f, p->upper / s->candidate.limit);
    fputs("</td><td>", f);
    page__text(f, p->because);
    fputs("</td></tr>\n", f);
}

static void group(FILE *f, const lab_diagnosis *d, int k)
{
    int n = diag__count(d, groups[k].presence);
    if (n == 0) {
        return;
    }
    fprintf(f,
            "<details><summary>%d %s: %s</summary>\n<div class=\"scroll\" tabindex=\"0\"><table "
            "class=\"fold "
            "seen\">\n<tr><td></td>",
            n, groups[k].title, groups[k].what);
    fputs("<th>estimate, 95&nbsp;%</th><th>would be named from</th><th>95&nbsp;% upper limit</th>"
          "<th>as a share of the largest plausible size</th><td></td></tr>\n",
          f);
    for (int i = 0; i < d->nsuspect; i++) {
        if (d->suspect[i].power.presence == groups[k].presence) {
            row(f, d, i);
        }
    }
    fputs("</table></div></details>\n", f);
}

void page__seen(FILE *f, const lab_diagnosis *d)
{
    if (d->nsuspect == diag__count(d, LAB_NOT_JUDGED)) {
        return;
    }
    fputs("<section id=\"seen\"><h2>Detectability</h2>\n<p>Estimates and limits from these records "
          "for every candidate, all else refitted",
          f);
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        fputs(i == 0 ? ": of a cause or rival from its own fit, of any other one beside "
              : i + 1 < d->ncause ? ", "
                                  : " and ",
              f);
        page__cause(f, &d->suspect[i].candidate);
    }
    fputs(". An effect of the size \"would be named from\" would have been named with 95&nbsp;% "
          "probability.</p>\n",
          f);
    for (int k = 0; k < GROUPS; k++) {
        group(f, d, k);
    }
    fputs("</section>\n", f);
}
