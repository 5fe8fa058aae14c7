/* SPDX-License-Identifier: GPL-3.0-or-later
 * table.c - the table of a run, and its confusions.
 *
 * Shares have 95 % Clopper-Pearson intervals: exact, from the beta distribution. A median has the
 * interval between the order statistics that hold it with 95 %.
 */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

enum { TEXT = 80, LEVELS = 8 };

typedef struct results {
    const setup *s;
    score *of[LEVELS];
    int n[LEVELS], missing, unmet;
} results;

static results gather(const setup *s)
{
    results r = {.s = s};
    char set[PATH], answer[PATH], out[PATH], scored[PATH];
    for (int k = 0; k < s->nlevel; k++) {
        r.of[k] = calloc((size_t)s->draws, sizeof *r.of[k]);
        for (int i = 1; r.of[k] != NULL && i <= s->draws; i++) {
            draw_paths(s, s->level[k], i, set, answer, out, scored);
            score *one = &r.of[k][r.n[k]];
            int there = score_read(scored, one) == 0;
            r.missing += !there;
            // an effect that cannot be made large enough is another question
            r.unmet += there && !one->met;
            r.n[k] += there && one->met;
        }
    }
    return r;
}

static void release(results *r)
{
    for (int k = 0; k < LEVELS; k++) {
        free(r->of[k]);
    }
}

/* programs that the draws were judged with: a record may go on with another one */
static int builds_of(const results *r)
{
    const char *seen[LEVELS] = {NULL};
    int n = 0;
    for (int k = 0; k < r->s->nlevel; k++) {
        for (int i = 0; i < r->n[k]; i++) {
            int known = 0;
            for (int j = 0; j < n; j++) {
                known |= strcmp(seen[j], r->of[k][i].build) == 0;
            }
            if (!known && n < LEVELS) {
                seen[n++] = r->of[k][i].build;
            }
        }
    }
    return n;
}

/* ---- one cell ---- */

static void share(char text[TEXT], int k, int n)
{
    if (n == 0) {
        snprintf(text, TEXT, "-");
        return;
    }
    double lo = k == 0 ? 0.0 : gsl_cdf_beta_Pinv(0.025, k, n - k + 1);
    double hi = k == n ? 1.0 : gsl_cdf_beta_Pinv(0.975, k + 1, n - k);
    snprintf(text, TEXT, "%.1f %% (%.1f .. %.1f) of %d", 100.0 * k / n, 100.0 * lo, 100.0 * hi, n);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void median(char text[TEXT], double *v, int n, const char *format, const char *unit)
{
    if (n == 0) {
        snprintf(text, TEXT, "-");
        return;
    }
    char mid[TEXT / 4], low[TEXT / 4], high[TEXT / 4];
    qsort(v, (size_t)n, sizeof *v, ascending);
    int k = (int)floor(0.5 * (n + 1) - 0.98 * sqrt(n)) - 1; // order statistics around the middle
    int lo = k < 0 ? 0 : k, hi = n - 1 - lo;
    snprintf(mid, sizeof mid, format, 0.5 * (v[(n - 1) / 2] + v[n / 2]));
    snprintf(low, sizeof low, format, v[lo]);
    snprintf(high, sizeof high, format, v[hi]);
    snprintf(text, TEXT, "%s%s (%s .. %s)", mid, unit, low, high);
}

/* ---- the figures ---- */

typedef enum {
    FIRST,
    FIRST_ALIKE,
    FIRST_TIED,
    ALL,
    ALL_ALIKE,
    SET,
    SET_ALIKE,
    SET_TIED,
    SET_SIZE,
    CLASS,
    CLASS_ALIKE,
    ALARM,
    ALARM_CLEAN,
    ALARM_ROUGH,
    UNKNOWN,
    OUTSIDE,
    OUTSIDE_HERE,
    OUTSIDE_RIGHT,
    LAW_ERROR,
    LAW_COVER,
    TWINS,
    TWINS_SET,
    SEPARATED,
    CHECKED,
    TOO_MANY,
    NOT_FILMED,
    LOST_OFFER,
    LOST_ROW,
    LOST_FIT,
    LOST_BID,
    LOST_JUDGE,
    COVERED,
    ERROR,
    HELD_OUT,
    NOT_CONVERGED,
    FAILED,
    SECONDS,
    SLOW,
    WALL,
    TRUSTED,
    UNUSABLE
} figure;

static const struct {
    figure what;
    const char *levels; /* of which, by the first letters of their names */
    const char *text, *bar;
} rows[] = {
    {FIRST, "L", "right cause and place first", "90 / 70 %, L3 35 %"},
    {FIRST_ALIKE, "L", "- identical descriptions as one", ""},
    {FIRST_TIED, "L", "- or what the records cannot tell from it", ""},
    {ALL, "L", "all that is hidden and nothing else", "70 % at L1x2"},
    {ALL_ALIKE, "L", "- identical descriptions as one", ""},
    {SET, "L", "right cause in the reported set", "95 / 88 %"},
    {SET_ALIKE, "L", "- identical descriptions as one", ""},
    {SET_TIED, "L", "- or what the records cannot tell from it", ""},
    {SET_SIZE, "LT", "mean size of the reported set", "2.5"},
    {CLASS, "L", "right class", "95 / 88 %"},
    {CLASS_ALIKE, "L", "- identical descriptions as one", ""},
    {UNKNOWN, "LT", "known effects called unknown_effect", "5 %"},
    {OUTSIDE, "X", "laws in no table called unknown_effect", ""},
    {OUTSIDE_HERE, "X", "- at the right joint or contact", ""},
    {OUTSIDE_RIGHT, "X", "- and over the right variable", "80 %"},
    {LAW_ERROR, "X", "error of the recovered law, median", "15 %"},
    {LAW_COVER, "X", "its band covers the truth, mean", "85 .. 98 %"},
    {TWINS, "T", "reported as a set of several", ""},
    {TWINS_SET, "T", "- the truth is in it", "85 %"},
    {SEPARATED, "T", "- the proposed experiment, made, separates them", "85 %"},
    {CHECKED, "T", "- it is a check without a stroke", ""},
    {TOO_MANY, "T", "- it asks for more strokes than were made", ""},
    {NOT_FILMED, "T", "- it cannot be filmed there", ""},
    {ALARM, "n", "nothing hidden, called anything but explained", "5 %"},
    {ALARM_ROUGH, "n", "- with scatter and wrong start values", ""},
    {ALARM_CLEAN, "n", "- without", ""},
    {LOST_OFFER, "L", "of those missed: no candidate", ""},
    {LOST_ROW, "L", "- never evaluated", ""},
    {LOST_FIT, "L", "- its fit did not converge", ""},
    {LOST_BID, "L", "- outbid by another row", ""},
    {LOST_JUDGE, "L", "- judged away", ""},
    {COVERED, "L", "found number inside its 95 % interval", "88 .. 99 %"},
    {ERROR, "L", "error of the found number, median", "10 % at L2"},
    {HELD_OUT, "LXT", "held-out error over the noise's, median", "1.10"},
    {NOT_CONVERGED, "nLXT", "not converged, reported as such", ""},
    {FAILED, "nLXT", "no verdict at all", "0"},
    {SECONDS, "nLXT", "processor time of a diagnosis, median", "240 s"},
    {SLOW, "nLXT", "- more than 240 s of it", ""},
    {WALL, "nLXT", "time on the wall with 2 threads, median", "60 s"},
    {TRUSTED, "W", "wrong set-up, given a verdict to be trusted", "0"},
    {UNUSABLE, "W", "- called an unusable model", ""},
};
enum { ROWS = sizeof rows / sizeof *rows };

/* what is said otherwise of the sets of tests/world; text NULL: the same, "": not asked */
static const struct {
    figure what;
    const char *text, *bar;
} in_world[] = {
    {FIRST, NULL, "small 65, clear 85, gross 85 %"},
    {ALL, NULL, ""},
    {SET, NULL, "95 %"},
    {CLASS, NULL, ""},
    {UNKNOWN, NULL, ""},
    {OUTSIDE_RIGHT, NULL, ""},
    {LAW_ERROR, NULL, ""},
    {LAW_COVER, NULL, ""},
    {ALARM, NULL, "3 %"},
    {ALARM_ROUGH, "- tolerances are not stated", ""},
    {ALARM_CLEAN, "- they are stated", ""},
    {COVERED, NULL, "90 .. 98 %"},
    {ERROR, NULL, ""},
    {HELD_OUT, NULL, ""},
    {SECONDS, NULL, ""},
    {SLOW, "", ""},
    {WALL, NULL, ""},
};

static void words_of(const setup *s, int row, const char **text, const char **bar)
{
    *text = rows[row].text, *bar = rows[row].bar;
    for (size_t i = 0; s->world && i < sizeof in_world / sizeof *in_world; i++) {
        if (in_world[i].what == rows[row].what) {
            *text = in_world[i].text != NULL ? in_world[i].text : *text;
            *bar = in_world[i].bar;
        }
    }
}

static int has_twins(const score *d)
{
    return d->causes > 0 && d->rivals > 0;
}

static int is_made(const score *d)
{
    return strcmp(d->film, "filmed") == 0 || strcmp(d->film, "checked") == 0;
}

static int asks_too_much(const score *d)
{
    return strcmp(d->film, "too_many_strokes") == 0;
}

static int counts(figure what, const score *d)
{
    int alarm = strcmp(d->verdict, "explained") != 0;
    switch (what) {
    case FIRST: return d->first;
    case FIRST_ALIKE: return d->first_alike;
    case FIRST_TIED: return d->first_tied;
    case SET_TIED: return d->set_tied;
    case ALL: return d->all;
    case ALL_ALIKE: return d->all_alike;
    case SET: return d->set;
    case SET_ALIKE: return d->set_alike;
    case CLASS: return d->right_class;
    case CLASS_ALIKE: return d->class_alike;
    case ALARM:
    case ALARM_CLEAN:
    case ALARM_ROUGH: return alarm;
    case UNKNOWN:
    case OUTSIDE: return strcmp(d->verdict, "unknown_effect") == 0;
    case OUTSIDE_HERE: return d->law_here;
    case OUTSIDE_RIGHT: return d->law_right;
    case TWINS: return has_twins(d);
    case TWINS_SET: return d->set_alike;
    case SEPARATED: return d->separated;
    case TOO_MANY: return strcmp(d->film, "too_many_strokes") == 0;
    case NOT_FILMED: return !asks_too_much(d) && !is_made(d);
    case CHECKED: return strcmp(d->film, "checked") == 0;
    case COVERED: return d->covered;
    case LOST_OFFER: return strcmp(d->lost, "not_offered") == 0;
    case LOST_ROW: return strcmp(d->lost, "not_evaluated") == 0;
    case LOST_FIT: return strcmp(d->lost, "not_converged") == 0;
    case LOST_BID: return strcmp(d->lost, "outbid") == 0;
    case LOST_JUDGE: return strcmp(d->lost, "judged_away") == 0;
    case NOT_CONVERGED: return strcmp(d->verdict, "not_converged") == 0;
    case FAILED: return strcmp(d->verdict, "failed") == 0;
    case SLOW: return d->cpu > 240.0;
    case TRUSTED: return d->exit_code == 0 && strcmp(d->verdict, "unusable_model") != 0;
    case UNUSABLE: return strcmp(d->verdict, "unusable_model") == 0;
    default: return 0;
    }
}

static int concerns(figure what, const score *d)
{
    switch (what) {
    case COVERED:
    case ERROR: return d->numbered;
    case LAW_ERROR:
    case LAW_COVER: return d->compared;
    case ALL_ALIKE: return d->threads > 0;
    case FIRST_TIED:
    case SET_TIED: return *d->mechanism != '\0' && *d->mechanism != '-';
    case WALL: return d->threads == 2;
    case TWINS_SET:
    case CHECKED:
    case TOO_MANY:
    case NOT_FILMED: return has_twins(d);
    case SEPARATED: // a candidate that was not in the set cannot be left over
        return has_twins(d) && d->set_alike && (asks_too_much(d) || is_made(d));
    case ALARM_CLEAN: return !d->rough;
    case ALARM_ROUGH: return d->rough;
    case LOST_OFFER:
    case LOST_ROW:
    case LOST_FIT:
    case LOST_BID:
    case LOST_JUDGE:
        return *d->lost != '\0' && strcmp(d->lost, "-") != 0 && strcmp(d->lost, "found") != 0;
    case SET_SIZE: return d->causes > 0;
    case HELD_OUT: return isfinite(d->after) && d->floor > 0.0;
    default: return 1;
    }
}

static void cell(char text[TEXT], const score *list, int n, figure what)
{
    double *v = calloc((size_t)n + 1, sizeof *v), sum = 0.0;
    int k = 0, m = 0;
    for (int i = 0; v != NULL && i < n; i++) {
        const score *d = &list[i];
        if (concerns(what, d)) {
            k += counts(what, d);
            sum += what == LAW_COVER ? 100.0 * d->law_cover : d->causes + d->rivals;
            v[m++] = what == ERROR       ? 100.0 * d->error
                     : what == LAW_ERROR ? 100.0 * d->law_error
                     : what == HELD_OUT  ? d->after / d->floor
                     : what == WALL      ? d->wall
                                         : d->cpu;
        }
    }
    if (what == ERROR || what == LAW_ERROR) {
        median(text, v, m, "%.1f", " %");
    } else if (what == HELD_OUT) {
        median(text, v, m, "%.3f", "");
    } else if (what == SECONDS || what == WALL) {
        median(text, v, m, "%.0f", " s");
    } else if (what == LAW_COVER) {
        snprintf(text, TEXT, m > 0 ? "%.1f %% of %d" : "-", sum / m, m);
    } else if (what == SET_SIZE) {
        snprintf(text, TEXT, m > 0 ? "%.2f of %d" : "-", sum / m, m);
    } else {
        share(text, k, m);
    }
    free(v);
}

/* ---- the table ---- */

static int belongs(int row, const char *level)
{
    return strchr(rows[row].levels, draw_kind(level)) != NULL;
}

/* a row that old records lack is printed if a draw of level k has it */
static int is_known(const results *r, int k, figure what)
{
    int known = what != WALL && what != ALL_ALIKE && what != FIRST_TIED && what != SET_TIED &&
                !(what >= LOST_OFFER && what <= LOST_JUDGE);
    for (int i = 0; i < r->n[k] && !known; i++) {
        known = concerns(what, &r->of[k][i]);
    }
    return known;
}

static void print_rows(FILE *f, const results *r)
{
    fprintf(f, r->s->world ? "| figure | bar |" : "| figure | bar (L1 / L2) |");
    for (int k = 0; k < r->s->nlevel; k++) {
        fprintf(f, " %s |", r->s->level[k]);
    }
    fprintf(f, "\n|---|---|");
    for (int k = 0; k < r->s->nlevel; k++) {
        fprintf(f, "---|");
    }
    fprintf(f, "\n");
    for (int i = 0; i < ROWS; i++) {
        const char *said, *bar;
        int asked = 0;
        words_of(r->s, i, &said, &bar);
        for (int k = 0; k < r->s->nlevel && *said != '\0'; k++) {
            asked |= belongs(i, r->s->level[k]) && is_known(r, k, rows[i].what);
        }
        if (!asked) {
            continue;
        }
        fprintf(f, "| %s | %s |", said, bar);
        for (int k = 0; k < r->s->nlevel; k++) {
            char text[TEXT] = "";
            if (belongs(i, r->s->level[k])) {
                cell(text, r->of[k], r->n[k], rows[i].what);
            }
            fprintf(f, " %s |", text);
        }
        fprintf(f, "\n");
    }
}

void table_print(FILE *f, const setup *s)
{
    results r = gather(s);
    print_rows(f, &r);
    fprintf(f, "\nSeed %lu, %d draws a level; in brackets 95 %% intervals.", s->seed, s->draws);
    if (r.unmet > 0) {
        fprintf(f, " %d draws left out: no size within its limits reaches the level.", r.unmet);
    }
    if (r.missing > 0) {
        fprintf(f, " %d draws are not there yet.", r.missing);
    }
    if (builds_of(&r) > 1) {
        fprintf(f, " %d builds of the program were judged.", builds_of(&r));
    }
    fprintf(f, "\n");
    release(&r);
}

/* ---- confusions ---- */

static int by_truth(const void *a, const void *b)
{
    const score *x = a, *y = b;
    int order = strcmp(x->kind, y->kind);
    order = order != 0 ? order : strcmp(x->place, y->place);
    return order != 0 ? order : x->draw - y->draw;
}

/* how each kind fared */
static void print_kinds(FILE *f, const score *list, int n)
{
    for (int i = 0; i < n;) {
        int last = i, first = 0, set = 0, class = 0;
        for (; last < n && strcmp(list[last].kind, list[i].kind) == 0; last++) {
            first += list[last].first;
            set += list[last].set;
            class += list[last].right_class;
        }
        fprintf(f, "# %-22s %3d drawn, first %3d, in the set %3d, class %3d\n", list[i].kind,
                last - i, first, set, class);
        i = last;
    }
}

/* and each mechanism of tests/world */
static void print_mechanisms(FILE *f, const score *list, int n)
{
    for (int i = 0; i < n; i++) {
        int seen = 0, drawn = 0, first = 0, set = 0, class = 0;
        for (int k = 0; k < n; k++) {
            int same = strcmp(list[k].mechanism, list[i].mechanism) == 0;
            seen |= same && k < i;
            drawn += same, first += same && list[k].first, set += same && list[k].set;
            class += same && list[k].right_class;
        }
        if (!seen && *list[i].mechanism != '\0' && *list[i].mechanism != '-') {
            fprintf(f, "# in %-20s %3d drawn, first %3d, in the set %3d, class %3d\n",
                    list[i].mechanism, drawn, first, set, class);
        }
    }
}

static void print_draw(FILE *f, const score *d)
{
    char truth[2 * NAME + 4], found[2 * NAME + 4];
    snprintf(truth, sizeof truth, "%s@%s", d->kind, d->place);
    snprintf(found, sizeof found, "%s@%s", d->first_kind, d->first_place);
    fprintf(f, "%-4s %4d %s%s %-46s %-15s %-46s rank %2d of %d+%d", d->level, d->draw,
            d->first         ? "="
            : d->first_alike ? "~"
            : d->set         ? "+"
                             : "-",
            d->right_class ? "c" : " ", truth, d->verdict, found, d->rank, d->causes, d->rivals);
    if (d->numbered) {
        fprintf(f, "  %.4g (%.4g .. %.4g) true %.4g%s", d->found, d->lo, d->hi, d->truth,
                d->covered ? "" : " OUTSIDE");
    }
    if (*d->mechanism != '\0' && *d->mechanism != '-') {
        fprintf(f, "  in %s%s", d->mechanism,
                d->offered || draw_kind(d->level) != 'L' ? "" : ", NOT OFFERED");
    }
    if (d->outside) {
        fprintf(f, "  law at %s over %s%s", d->law_place, d->law_of, d->law_right ? " =" : "");
    }
    if (d->compared) {
        fprintf(f, ", off by %.1f %%, %.0f %% covered", 100.0 * d->law_error, 100.0 * d->law_cover);
    }
    if (has_twins(d) && *d->film != '\0' && *d->film != '-') {
        fprintf(f, "  %s x %d: %s, then %s@%s%s", d->experiment, d->repeats, d->film, d->after_kind,
                d->after_place, d->separated ? " SEPARATED" : "");
    }
    if (*d->lost != '\0' && strcmp(d->lost, "-") != 0) {
        fprintf(f, "  %s", d->lost);
    }
    fprintf(f, "  held out %.3f -> %.3f  %.0f s\n", d->before, d->after, d->cpu);
}

int table_confusions(const char *path, const setup *s)
{
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        perror(path);
        return -1;
    }
    results r = gather(s);
    fprintf(f,
            "# = first, ~ an identical description first, + in the set, - missed; c right class\n"
            "# level, draw, truth, verdict, first cause, rank of the truth (0: not in any list) "
            "of causes + indistinguishable\n");
    for (int k = 0; k < s->nlevel; k++) {
        qsort(r.of[k], (size_t)r.n[k], sizeof *r.of[k], by_truth);
        fprintf(f, "# ---- %s\n", s->level[k]);
        print_kinds(f, r.of[k], r.n[k]);
        print_mechanisms(f, r.of[k], r.n[k]);
        for (int i = 0; i < r.n[k]; i++) {
            print_draw(f, &r.of[k][i]);
        }
    }
    release(&r);
    return fclose(f) == 0 ? 0 : -1;
}

/* ---- into a document ---- */

enum { MARK = 8 * NAME + 80 };

static const char end_mark[] = "<!-- hidden: end -->\n";

/* the line before the table of these levels: a document may have several tables */
static void begin_mark(char mark[MARK], const setup *s)
{
    int n = snprintf(mark, MARK, "<!-- hidden ");
    for (int k = 0; k < s->nlevel; k++) {
        n += snprintf(mark + n, (size_t)(MARK - n), "%s%s", k > 0 ? "," : "", s->level[k]);
    }
    snprintf(mark + n, (size_t)(MARK - n), ": begin, written by make hidden-readme -->\n");
}

static char *read_all(const char *path)
{
    FILE *f = fopen(path, "rb");
    char *text = calloc(1, 1 << 20);
    if (f != NULL && text != NULL && fread(text, 1, (1 << 20) - 1, f) > 0) {
        fclose(f);
        return text;
    }
    if (f != NULL) {
        fclose(f);
    }
    free(text);
    return NULL;
}

int table_into(const char *path, const setup *s)
{
    char part[PATH + 8], mark[MARK];
    char *text = read_all(path);
    begin_mark(mark, s);
    char *begin = text != NULL ? strstr(text, mark) : NULL;
    char *end = begin != NULL ? strstr(begin, end_mark) : NULL;
    if (end == NULL) {
        fprintf(stderr, "hidden: %s has no place for the table between\n%s%s", path, mark,
                end_mark);
        free(text);
        return -1;
    }
    snprintf(part, sizeof part, "%s.part", path);
    FILE *f = fopen(part, "wb");
    int ok = f != NULL;
    if (ok) {
        fwrite(text, 1, (size_t)(begin - text) + strlen(mark), f);
        fputc('\n', f);
        table_print(f, s);
        fputc('\n', f);
        fputs(end, f);
        ok = fclose(f) == 0 && rename(part, path) == 0;
    }
    if (!ok) {
        perror(path);
    }
    free(text);
    return ok ? 0 : -1;
}
