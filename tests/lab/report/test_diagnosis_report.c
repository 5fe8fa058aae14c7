/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_diagnosis_report.c - the two files that a diagnosis writes.
 */
#include "diagnosis_page.h"
#include "lab_support.h"
#include "stein/diagnose.h"
#include "stein/plan.h"

Suite *report_suite(void);

/* ---- a diagnosis that is made up ---- */

static lab_diagnosis *made_up(void)
{
    static const lab_effect effect = {.kind = "odd_<effect>",
                                      .cls = "missing_effect",
                                      .size = "k",
                                      .equation = "torque -k |qd| qd & \"more\""};
    lab_diagnosis *d = calloc(1, sizeof *d);
    *d = (lab_diagnosis){.verdict = LAB_VERDICT_MISSING_EFFECT,
                         .phase = "fall",
                         .nsuspect = 3,
                         .ncause = 1,
                         .nrival = 1,
                         .p = 1e-3,
                         .noise_floor = 1.0,
                         .nfit = 12,
                         .nheld = 6,
                         .samples = 9000,
                         .gain = {.unit = "1",
                                  .samples = 3000,
                                  .rmse_before = 2.5,
                                  .rmse_after = 1.02,
                                  .noise = 1.0,
                                  .ratio = 0.408,
                                  .lo = 0.36,
                                  .hi = NAN}};
    snprintf(d->reason, sizeof d->reason, "A \"reason\" with <tags> & signs");
    d->suspect = calloc(3, sizeof *d->suspect);
    for (int i = 0; i < 3; i++) {
        lab_suspect *s = &d->suspect[i];
        *s = (lab_suspect){.candidate = {.effect = &effect, .unit = "N m s^2/rad^2"},
                           .score = i < 2 ? 100.0 - i : (double)NAN,
                           .amount = 2e-7,
                           .possible = 1,
                           .refitted = i == 0,
                           .gain = i == 0 ? 110.0 : (double)NAN,
                           .likeness = 1.0 - 0.02 * i,
                           .why = i == 2 ? "no stroke <shows> it" : NULL};
        snprintf(s->candidate.place, LAB_PLACE, "place%d", i);
    }
    d->suspect[0].nnumber = 1;
    d->suspect[0].number[0] = (lab_cause_number){
        .name = "k", .unit = "N m s^2/rad^2", .value = 2e-7, .lo = 1e-7, .hi = 3e-7};
    d->finding = calloc(1, sizeof *d->finding);
    d->finding[0] = lab__text("a.csv: <script src='http://x'>\n\"odd\" \x01 & more");
    d->nfinding = 1;
    d->departure = calloc(2, sizeof *d->departure);
    d->departure[0] = (lab_departure){"height", "m", 0, "fall", 90, 2e-5, 1e-5, 7.5, 0.4};
    d->departure[1] = (lab_departure){"hammer", "N m", 1, "fall", 90, 2e-5, 1e-6, 9.5, NAN};
    d->ndeparture = 2;
    return d;
}

/* a motion-driven check that is made up */
static void check_motion(lab_motion *m)
{
    enum { N = 30 };
    *m = (lab_motion){.says = LAB_MOTION_SUPPORTS,
                      .why = "a <why>",
                      .input = "drive",
                      .joint = "lever",
                      .force = "effort",
                      .unit = "N m",
                      .channel = "height",
                      .strokes = 6,
                      .held_out = 1,
                      .draws = 8,
                      .of_force = {LAB_MOTION_SUPPORTS, 2.0, 1.1, 9.0, 0.5, 0.97, 0.08},
                      .of_channels = {LAB_MOTION_CANNOT_TELL, NAN, NAN, NAN, NAN, NAN, NAN},
                      .nrow = 2,
                      .n = N,
                      .file = "strokes/a<b>.csv"};
    m->row = calloc(2, sizeof *m->row);
    m->row[0] = (lab_motion_row){NULL, "N m", NULL, 90, 0.4, 0.06, 0.03, 0.03, 9e-3, 1e-4, 1e-3};
    m->row[1] = (lab_motion_row){"height", "m", "fall", 90, NAN, 2e-5, NAN, 1e-5, 1e-6, NAN, 1e-6};
    m->t = calloc(5 * N, sizeof *m->t);
    double **list[] = {&m->present, &m->before, &m->after, &m->sd};
    for (int i = 0; i < 4; i++) {
        *list[i] = m->t + (i + 1) * N;
        for (int k = 0; k < N; k++) {
            m->t[k] = 1e-3 * k;
            (*list[i])[k] = i == 3 ? 0.02 : 0.1 + 0.05 * sin(0.2 * k + i);
        }
    }
}

/* the curves of a made-up diagnosis */
static void draw(lab_diagnosis *d)
{
    enum { N = 40 };
    d->trace = calloc(1, sizeof *d->trace);
    d->latent = calloc(1, sizeof *d->latent);
    d->ntrace = d->nlatent = 1;
    lab_trace *t = d->trace;
    lab_latent *l = d->latent;
    *t = (lab_trace){.held_out = 1,
                     .file = "strokes/a<b>.csv",
                     .channel = "height",
                     .unit = "m",
                     .n = N,
                     .noise = 1e-5};
    *l = (lab_latent){.joint = "hammer", .unit = "N m", .file = t->file, .n = N};
    double **list[] = {&t->t, &t->y, &t->before, &t->after, &l->t, &l->force, &l->sd};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        *list[i] = calloc(N, sizeof **list[i]);
        for (int k = 0; k < N; k++) {
            (*list[i])[k] = i == 0 || i == 4 ? 1e-3 * k : 1e-5 * sin(0.3 * k + (double)i);
        }
    }
    check_motion(&d->motion);
    t->y[7] = NAN;
    t->phase = calloc(N, sizeof *t->phase);
    for (int k = 0; k < N; k++) {
        t->phase[k] = k < 10 ? "rest" : "fall";
    }
}

static char *contents(const char *path)
{
    FILE *f = fopen(path, "r");
    ck_assert_ptr_nonnull(f);
    char *text = calloc(1, 2000000);
    size_t n = fread(text, 1, 1999999, f);
    ck_assert(n > 0 && n < 1999999);
    fclose(f);
    return text;
}

/* ---- JSON ---- */

static const char *blank(const char *at)
{
    return at + strspn(at, " \n");
}

/* behind a JSON value, NULL when there is none */
static const char *value(const char *at)
{
    static const char *const word[] = {"null", "true", "false"};
    at = blank(at);
    if (*at == '"') {
        for (at++; *at != '"'; at++) {
            if ((unsigned char)*at < 0x20 || (*at == '\\' && strchr("\"\\u", *++at) == NULL)) {
                return NULL;
            }
        }
        return at + 1;
    }
    if (*at == '{' || *at == '[') {
        char end = *at == '{' ? '}' : ']';
        for (at = blank(at + 1); at != NULL && *at != end;) {
            if (end == '}') {
                at = *at == '"' ? value(at) : NULL;
                at = at != NULL && *at == ':' ? at + 1 : NULL;
            }
            at = at != NULL ? value(at) : NULL;
            at = at != NULL ? blank(at) : NULL;
            if (at != NULL && *at == ',') {
                at = blank(at + 1);
                at = *at == end ? NULL : at;
            } else if (at != NULL && *at != end) {
                at = NULL;
            }
        }
        return at != NULL ? at + 1 : NULL;
    }
    for (int i = 0; i < 3; i++) {
        if (strncmp(at, word[i], strlen(word[i])) == 0) {
            return at + strlen(word[i]);
        }
    }
    char *end = NULL;
    double number = strtod(at, &end);
    return end != at && isfinite(number) && (*at == '-' || (*at >= '0' && *at <= '9')) ? end : NULL;
}

START_TEST(the_json_has_its_documented_keys_and_reads_back)
{
    static const char *const keys[] = {"\"verdict\": \"missing_effect\"",
                                       "\"causes\": [",
                                       "\"kind\": \"odd_<effect>\"",
                                       "\\u000a\\\"odd\\\"",
                                       "\"place\": \"place0\"",
                                       "\"phase\": \"fall\"",
                                       "\"parameters\": {",
                                       "\"k\": {",
                                       "\"value\": 2e-07",
                                       "\"unit\": \"N m s^2/rad^2\"",
                                       "\"evidence\": {",
                                       "\"likeness\": 1",
                                       "\"indistinguishable\": [",
                                       "\"next_experiment\": null",
                                       "\"gain\": {",
                                       "\"rmse_before\": 2.5",
                                       "\"rmse_after\": 1.02",
                                       "\"ratio\": 0.408",
                                       "\"lo\": 0.36",
                                       "\"hi\": null",
                                       "\"held_out\": 6",
                                       "\"noise_floor\": 1",
                                       "\"audit\": [",
                                       "\\u0001",
                                       "\"motion_check\": {",
                                       "\"says\": \"supports\"",
                                       "\"why\": \"a <why>\"",
                                       "\"share\": 0.97",
                                       "\"mean_after\": 0.0001",
                                       "\"departures\": [",
                                       "\"suspects\": [",
                                       "\"missing_forces\": ["};
    lab_diagnosis *d = made_up();
    draw(d);
    const char *path = in_folder("diagnosis.json");
    ck_assert_stein(lab_diagnosis_json(path, d, err));
    char *text = contents(path);
    const char *end = value(text);
    ck_assert_msg(end != NULL && *blank(end) == '\0', "no JSON");
    ck_assert_ptr_null(strstr(text, "nan"));
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        ck_assert_msg(strstr(text, keys[i]) != NULL, "no %s", keys[i]);
    }
    free(text);
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(every_verdict_can_be_written_with_nothing_else_known)
{
    for (int v = LAB_VERDICT_EXPLAINED; v <= LAB_VERDICT_NOT_CONVERGED; v++) {
        lab_diagnosis *d = calloc(1, sizeof *d);
        d->verdict = (lab_verdict)v;
        d->gain.rmse_before = d->chi2_dof_before = NAN;
        const char *json = in_folder("d.json"), *page = in_folder("d.html");
        ck_assert_stein(lab_diagnosis_json(json, d, err));
        ck_assert_stein(lab_diagnosis_page(page, d, err));
        char *text = contents(json);
        ck_assert_ptr_nonnull(value(text));
        ck_assert_ptr_nonnull(strstr(text, lab_verdict_text((lab_verdict)v)));
        free(text);
        text = contents(page);
        ck_assert_ptr_nonnull(strstr(text, "</html>"));
        ck_assert_ptr_null(strstr(text, "nan"));
        free(text);
        lab_diagnosis_destroy(d);
    }
    lab_diagnosis_destroy(NULL);
}
END_TEST

START_TEST(a_file_that_cannot_be_written_is_reported_and_none_is_left)
{
    lab_diagnosis *d = made_up();
    ck_assert_int_eq(lab_diagnosis_json(in_folder("none/d.json"), d, NULL), STEIN_EIO);
    ck_assert_int_eq(lab_diagnosis_page(in_folder("none/d.html"), d, NULL), STEIN_EIO);
    ck_assert_int_ne(access(in_folder("none"), F_OK), 0);
    lab_diagnosis_destroy(d);
}
END_TEST

/* ---- the page ---- */

/* every element that is opened is closed, in order */
static void ck_assert_nested(const char *text)
{
    static const char *const alone[] = {"meta", "br", "!DOCTYPE"};
    char open[64][16], name[16];
    int depth = 0;
    for (const char *at = strchr(text, '<'); at != NULL; at = strchr(at + 1, '<')) {
        const char *end = strchr(at, '>');
        int closing = at[1] == '/', single = end != NULL && end[-1] == '/';
        size_t n = strcspn(at + 1 + closing, " />\n");
        snprintf(name, sizeof name, "%.*s", (int)n, at + 1 + closing);
        for (size_t i = 0; i < sizeof alone / sizeof *alone; i++) {
            single |= strcmp(name, alone[i]) == 0;
        }
        if (closing) {
            ck_assert_msg(depth > 0 && strcmp(open[depth - 1], name) == 0, "</%s> in <%s>", name,
                          depth > 0 ? open[depth - 1] : "");
            depth--;
        } else if (!single) {
            ck_assert_int_lt(depth, 64);
            snprintf(open[depth++], sizeof *open, "%s", name);
        }
    }
    ck_assert_int_eq(depth, 0);
}

START_TEST(the_page_stands_alone_and_takes_no_text_for_markup)
{
    static const char *const never[] = {"http",  "src=", "<script", "<effect", "<tags", "<shows>",
                                        "<why>", "<b>",  "url(",    "@import", "nan",   "inf\""};
    static const char *const present[] = {
        "The model lacks an effect: odd &lt;effect&gt; of the place0",
        "A &quot;reason&quot; with &lt;tags&gt; &amp; signs",
        "place1",
        "The force that the measured motion needs",
        "The check <em>supports the verdict</em>: a &lt;why&gt;.",
        "0.97 \xc2\xb1 0.08",
        "&lt;script ",
        "a&lt;b&gt;.csv",
        "prefers-color-scheme",
        "width=device-width",
        "N&nbsp;m&nbsp;s<sup>2</sup>/rad<sup>2</sup>",
        "[0.10 \xe2\x80\xa6 0.30]</span>&nbsp;\xc2\xb5N"};
    lab_diagnosis *d = made_up();
    draw(d);
    const char *path = in_folder("report.html");
    ck_assert_stein(lab_diagnosis_page(path, d, err));
    char *text = contents(path);
    // quotes of the audit are there, escaped
    char *quoted = strstr(text, "src=&#39;http://x&#39;");
    ck_assert_ptr_nonnull(quoted);
    memset(quoted, 'x', strlen("src=&#39;http://x&#39;"));
    for (size_t i = 0; i < sizeof never / sizeof *never; i++) {
        ck_assert_msg(strstr(text, never[i]) == NULL, "%s", never[i]);
    }
    for (size_t i = 0; i < sizeof present / sizeof *present; i++) {
        ck_assert_msg(strstr(text, present[i]) != NULL, "no %s", present[i]);
    }
    ck_assert_nested(text);
    free(text);
    lab_diagnosis_destroy(d);
}
END_TEST

/* ---- texts and numbers ---- */

/* output of one call */
#define WRITES(expected, call)                              \
    do {                                                    \
        char *written = NULL;                               \
        FILE *f = lab__text_open(&written);                 \
        ck_assert_ptr_nonnull(f);                           \
        call;                                               \
        ck_assert_stein(lab__text_close(f, &written, err)); \
        ck_assert_str_eq(written, expected);                \
        free(written);                                      \
    } while (0)
#define MINUS "\xe2\x88\x92"
#define DOT   "\xc2\xb7"

START_TEST(numbers_are_written_for_readers)
{
    static const lab_candidate nobody = {.effect = NULL}, at = {.effect = NULL, .place = "a.b"};
    WRITES("\xe2\x80\x93", page__number(f, (double)NAN, 3));
    WRITES("\xe2\x88\x9e", page__number(f, (double)INFINITY, 3));
    WRITES(MINUS "\xe2\x88\x9e", page__number(f, -(double)INFINITY, 3));
    WRITES("0.00", page__number(f, 0.0, 3));
    WRITES(MINUS "31.7", page__number(f, -31.7123, 3));
    WRITES("1.23" DOT "10<sup>6</sup>", page__number(f, 1.234e6, 3));
    WRITES("7.9" DOT "10<sup>" MINUS "7</sup>", page__number(f, 7.87e-7, 2));
    WRITES("2.30&nbsp;mm", page__quantity(f, 2.3e-3, "m", 3));
    WRITES("23.0&nbsp;\xc2\xb5m", page__quantity(f, 2.3e-5, "m", 3));
    WRITES("2.30&nbsp;m", page__quantity(f, 2.3, "m", 3));
    WRITES("2.30", page__quantity(f, 2.3, "1", 3));
    WRITES("2.30", page__quantity(f, 2.3, NULL, 3));
    WRITES("0.00&nbsp;m", page__quantity(f, 0.0, "m", 3));
    WRITES("2.30&nbsp;N<sup>2</sup>&nbsp;s<sup>-1</sup>/m",
           page__quantity(f, 2.3, "N^2 s^-1/m", 3));
    WRITES("2.30 <span class=\"ci\">[2.20 \xe2\x80\xa6 2.40]</span>",
           page__interval(f, 2.3, 2.2, 2.4, "1"));
    WRITES("2.30", page__interval(f, 2.3, 2.4, 2.4, "1")); // no interval
    WRITES("2.30", page__interval(f, 2.3, 2.2, (double)INFINITY, "1"));
    WRITES("\xe2\x80\x93", page__interval(f, (double)NAN, 2.2, 2.4, "1"));
    WRITES("", page__words(f, NULL));
    WRITES("a &lt;b", page__words(f, "a_<b"));
    WRITES("nothing", page__cause(f, &nobody));
    WRITES("nothing of a.b", page__cause(f, &at));
}
END_TEST

/* ---- pages of other diagnoses ---- */

static void page_has(const lab_diagnosis *d, const char *const *has, const char *lacks)
{
    const char *path = in_folder("page.html");
    ck_assert_stein(lab_diagnosis_page(path, d, err));
    char *text = contents(path);
    for (; *has != NULL; has++) {
        ck_assert_msg(strstr(text, *has) != NULL, "no %s", *has);
    }
    ck_assert_msg(lacks == NULL || strstr(text, lacks) == NULL, "%s", lacks);
    ck_assert_nested(text);
    free(text);
}

START_TEST(several_causes_have_each_its_size_and_its_place_once)
{
    static const char *const has[] = {
        "odd &lt;effect&gt; of the place0, odd &lt;effect&gt; of the place1 and odd "
        "&lt;effect&gt; of the place1",
        "<small>with it the error on held-out records is 0.31 times that without it</small>", NULL};
    lab_diagnosis *d = made_up();
    d->ncause = 3;
    d->nrival = 0;
    d->phase = NULL;
    snprintf(d->suspect[2].candidate.place, LAB_PLACE, "place1");
    for (int i = 0; i < 3; i++) {
        d->suspect[i].own_ratio = i == 0 ? (double)NAN : 0.31;
    }
    page_has(d, has, NULL);
    lab_diagnosis_destroy(d);
}
END_TEST

/* The class of the verdict is that of the first cause; friction is no error of an instrument. */
START_TEST(causes_of_several_kinds_are_not_called_by_one)
{
    static const lab_effect clock = {
        .kind = "time_base", .cls = "sensor", .size = "error", .equation = "(1 + error) t"};
    static const char *const has[] = {
        "<h1>An instrument has an error: time base of the clock. The "
        "model lacks an effect: odd &lt;effect&gt; of the place1</h1>",
        NULL};
    lab_diagnosis *d = made_up();
    d->verdict = LAB_VERDICT_SENSOR;
    d->ncause = 2;
    d->nrival = 0;
    d->suspect[0].candidate.effect = &clock;
    snprintf(d->suspect[0].candidate.place, LAB_PLACE, "clock");
    page_has(d, has, NULL);
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(records_that_state_the_wrong_thing_have_no_fit_in_their_report)
{
    static const char *const has[] = {"<h1>angle is in deg, not in rad</h1>", "nothing was fitted",
                                      "Correct this in the records", NULL};
    static const char *const never[] = {"with every candidate", "no record was held out",
                                        "samples of",           "degree of freedom",
                                        "Largest departure",    "held out</p>"};
    lab_diagnosis *d = made_up();
    d->verdict = LAB_VERDICT_UNUSABLE_MODEL;
    d->ncause = d->nrival = d->nsuspect = d->nfit = d->nheld = d->samples = 0;
    snprintf(d->slip, sizeof d->slip, "angle is in deg, not in rad");
    for (size_t i = 0; i < sizeof never / sizeof *never; i++) {
        page_has(d, has, never[i]);
    }
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(pieces_of_one_record_are_not_called_records)
{
    static const char *const has[] = {"2 pieces of 1 record fitted, 1 held out",
                                      "Error on 1 piece that took no part in the fit; the record "
                                      "itself did.",
                                      NULL};
    static const char *const several[] = {"the same records did, in other pieces.", NULL};
    lab_diagnosis *d = made_up();
    free(d->gains);
    d->gains = calloc(1, sizeof *d->gains);
    d->gains[0] = (lab_gain){.channel = "height", .unit = "m", .rmse_before = 3e-3, .ratio = 0.5};
    d->ngain = 1;
    d->nfit = 2;
    d->nheld = d->nfile = d->in_pieces = 1;
    page_has(d, has, "1 record held out");
    d->nfile = 2;
    page_has(d, several, "the record itself");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_force_that_shows_nowhere_is_not_drawn)
{
    static const char *const drawn[] = {"<h2>The force that the model lacks</h2>",
                                        "the force that the model lacks at a joint", NULL};
    static const char *const none[] = {
        "<h2>The force that the model lacks</h2>",
        "At no joint and in no phase is the mean of the missing force "
        "2 standard deviations from zero",
        NULL};
    lab_diagnosis *d = made_up();
    draw(d);
    page_has(d, drawn, "At no joint");
    d->departure[1].z = 1.9;
    page_has(d, none, "the force that the model lacks at a joint");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_number_that_acts_like_the_cause_is_beside_it)
{
    static const char *const has[] = {"<p>A wrong rod.bob.z of the file acts in exactly the same "
                                      "way as odd &lt;effect&gt; of the "
                                      "place0",
                                      "No other effect of the table", NULL};
    lab_diagnosis *d = made_up();
    d->ncause = 1;
    d->nrival = 0;
    snprintf(d->suspect[0].candidate.alias, sizeof d->suspect[0].candidate.alias, "rod.bob.z");
    page_has(d, has, NULL);
    d->suspect[0].candidate.alias[0] = '\0';
    page_has(d, has + 1, "acts in exactly the same way");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(contradictions_are_beside_the_verdict)
{
    static const char *const has[] = {"<ul class=\"against\">",
                                      "The forces contradict it: a &lt;why&gt;.",
                                      "extended.yaml, run from the file, leaves 2.00 noises where",
                                      "after over before may be 1.20",
                                      "In 1 of 2 records held out the error grows.",
                                      "Another effect explains the records as well; ",
                                      "<div class=\"card warning\"><h2>Check by forces</h2>",
                                      NULL};
    static const char *const without[] = {"<h2>Check by forces</h2>", NULL};
    lab_diagnosis *d = made_up();
    draw(d);
    d->ncause = d->nrival = 1;
    d->motion.says = LAB_MOTION_CONTRADICTS;
    d->verified = (lab_verified){.done = 1, .table = 1.0, .file = 2.0};
    d->gain.hi = 1.2;
    d->nrecord = 3;
    d->record = calloc(3, sizeof *d->record);
    d->record[0] = (lab_seen){.file = "a.csv", .before = 1.0, .after = 3.0};
    d->record[1] = (lab_seen){.file = "b.csv", .reporting = 1, .before = 1.0, .after = 1.5};
    d->record[2] = (lab_seen){.file = "c.csv", .reporting = 1, .before = 2.0, .after = 1.0};
    page_has(d, has, NULL);
    d->motion.says = LAB_MOTION_SUPPORTS;
    d->verified.same = 1;
    d->gain.hi = 0.9;
    d->nrival = d->nrecord = 0;
    page_has(d, without, "<ul class=\"against\">");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(the_first_screen_has_the_error_in_the_unit_of_the_channel)
{
    static const char *const has[] = {"<small>height</small> 3.00 \xe2\x86\x92 1.50&nbsp;mm",
                                      "<title>", ": measured ", NULL};
    static const char *const explained[] = {"The model explains these records", NULL};
    lab_diagnosis *d = made_up();
    draw(d);
    free(d->gains);
    d->ngain = d->nheld = 1;
    d->gains = calloc(1, sizeof *d->gains);
    d->gains[0] = (lab_gain){
        .channel = "height", .unit = "m", .rmse_before = 3e-3, .rmse_after = 1.5e-3, .ratio = 0.5};
    page_has(d, has, NULL);
    static const char *const degrees[] = {
        "<small>height</small> 18.5 \xe2\x86\x92 0.148&nbsp;deg <small>323 \xe2\x86\x92 "
        "2.58&nbsp;mrad",
        "</small></th><td>18.5&nbsp;deg</td><td>0.148&nbsp;deg</td><td>0.145&nbsp;deg</td>", NULL};
    d->gains[0] = (lab_gain){.channel = "height",
                             .unit = "rad",
                             .written = "deg",
                             .per_unit = 57.29577951308232,
                             .rmse_before = 0.323,
                             .rmse_after = 2.58e-3,
                             .noise = 2.53e-3};
    page_has(d, degrees, NULL);
    d->verdict = LAB_VERDICT_EXPLAINED;
    d->ncause = d->nrival = 0;
    page_has(d, explained, "<h2>Largest departure</h2>");
    page_has(d, explained, "<h2>Best candidate</h2>");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(refitted_numbers_show_their_change)
{
    static const char *const has[] = {"12.300&nbsp;g",
                                      "not seen by these records",
                                      MINUS "2.0 sd of the file",
                                      "contact friction 8.0&nbsp;%",
                                      "and 3 more.",
                                      NULL};
    lab_diagnosis *d = made_up();
    d->nvalue = 3;
    d->value = calloc(3, sizeof *d->value);
    d->value[0] = (lab_fit_value){.name = "a.mass",
                                  .unit = "kg",
                                  .start = 0.0123,
                                  .value = 0.0121,
                                  .lo = 0.012,
                                  .hi = 0.0122,
                                  .prior_sd = 1e-4};
    d->value[1] = (lab_fit_value){.name = "b.k", .unit = "N/m", .unseen = 1};
    d->value[2] = (lab_fit_value){.name = "c.k", .unit = "N/m", .prior_sd = (double)NAN};
    d->scatter[1] = 0.08;
    enum { MANY = 43 };
    free(d->finding[0]);
    free(d->finding);
    d->finding = calloc(MANY, sizeof *d->finding);
    for (d->nfinding = 0; d->nfinding < MANY; d->nfinding++) {
        d->finding[d->nfinding] = lab__text("finding %d", d->nfinding);
    }
    page_has(d, has, "finding 40<");
    // one interval of the number that the cause moves, in every table
    static const char *const moved[] = {
        "<p class=\"big\">mass: 12.3 \xe2\x86\x92 15.0 g (95 %: 14.0 to 16.0), 22 % heavier</p>",
        "</td><td>mass: 12.3 \xe2\x86\x92 15.0 g (95 %: 14.0 to 16.0), 22 % heavier<small>beside "
        "preload at "
        "b</small></td>",
        "</td><td>15.0 <span class=\"ci\">[14.0 \xe2\x80\xa6 16.0]</span>&nbsp;g</td>"
        "<td>by the cause; without it 12.10&nbsp;g</td>",
        NULL};
    lab_suspect *s = &d->suspect[0];
    static const lab_effect mass = {.kind = "mass", .cls = "wrong_parameter", .size = "mass"};
    s->candidate.effect = &mass;
    snprintf(s->candidate.place, LAB_PLACE, "a");
    snprintf(s->fitted_beside, sizeof s->fitted_beside, "preload at b");
    s->nchange = 1;
    s->change[0] = (lab_change){.name = "a.mass",
                                .unit = "g",
                                .factor = 1e-3,
                                .from = 0.0123,
                                .to = 0.015,
                                .lo = 0.014,
                                .hi = 0.016};
    page_has(d, moved, "k = ");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(the_next_step_depends_on_the_verdict)
{
    static const struct {
        lab_verdict verdict;
        int causes, rivals;
        const char *says;
    } next[] = {
        {LAB_VERDICT_EXPLAINED, 0, 0, "Use the model without changes."},
        {LAB_VERDICT_NOT_CONVERGED, 0, 0, "Check the data and the starting numbers below first"},
        {LAB_VERDICT_UNKNOWN_EFFECT, 0, 0, "Look where the map below is darkest"},
        {LAB_VERDICT_SENSOR, 1, 0, "Check the instrument;"},
        {LAB_VERDICT_INPUT, 1, 0, "Check how the input was recorded;"},
        {LAB_VERDICT_MISSING_EFFECT, 1, 0, "it has the cause and the refitted numbers"},
        {LAB_VERDICT_SENSOR, 1, 1, "make a record in which the candidates differ"},
    };
    for (size_t i = 0; i < sizeof next / sizeof *next; i++) {
        lab_diagnosis *d = made_up();
        const char *has[] = {next[i].says, NULL};
        d->verdict = next[i].verdict;
        d->ncause = next[i].causes;
        d->nrival = next[i].rivals;
        page_has(d, has, "Best of the experiments tried");
        lab_diagnosis_destroy(d);
    }
    static const char *const strokes[] = {"; even so it takes very many records.",
                                          "; 1 record will do.", "; 2 records will do.",
                                          "; no stroke."};
    for (int i = 0; i < 4; i++) {
        lab_diagnosis *d = made_up();
        const char *has[] = {
            "tried: <b>a &lt;new&gt; one</b> against odd &lt;effect&gt; of the place1", strokes[i],
            NULL};
        d->next = calloc(1, sizeof *d->next);
        d->next->repeats = i;
        d->next->ncheck = i == 3;
        snprintf(d->next->why, sizeof d->next->why, "no stroke");
        d->next->against = 1;
        snprintf(d->next->name, sizeof d->next->name, "a <new> one");
        page_has(d, has, NULL);
        lab_diagnosis_destroy(d);
    }
}
END_TEST

START_TEST(a_gain_is_shown_as_far_as_it_is_known)
{
    static const char *const unknown[] = {"<p>not measured: no record was held out</p>", NULL};
    static const char *const held[] = {"<p>not measured</p>", NULL};
    static const char *const one[] = {"Error on 1 record that took no part",
                                      "x=\"37.5\" y=\"3.5\" width=\"0.5\"", NULL};
    static const char *const none[] = {"noise alone would leave 1.00", NULL};
    lab_diagnosis *d = made_up();
    d->gain.rmse_before = (double)NAN;
    page_has(d, held, "no record was held out");
    d->nheld = 0;
    page_has(d, unknown, NULL);
    d->gain = (lab_gain){.rmse_before = 2.0,
                         .rmse_after = (double)NAN,
                         .ratio = 0.3535534,
                         .lo = (double)NAN,
                         .hi = (double)NAN};
    d->nheld = d->ngain = 1;
    d->gains = calloc(1, sizeof *d->gains);
    d->gains[0] =
        (lab_gain){.channel = "height", .unit = "m", .phase = "fall", .ratio = (double)NAN};
    d->noise_floor = (double)NAN;
    page_has(d, one, NULL);
    d->noise_floor = 1.0;
    d->ncause = d->nrival = 0;
    page_has(d, none, "Error on records held out, before");
    d->departure[0].z = d->departure[1].z = (double)NAN;
    static const char *const cold[] = {"<p>none was measured</p>", NULL};
    page_has(d, cold, NULL);
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(counts_beyond_the_list_are_not_followed)
{
    static const char *const has[] = {": odd &lt;effect&gt; of the place0</h1>",
                                      "These records cannot separate it from</p><ul></ul>", NULL};
    lab_diagnosis *d = made_up();
    d->nsuspect = 1;
    d->ncause = d->nrival = 2;
    page_has(d, has, "place1");
    ck_assert_stein(lab_diagnosis_json(in_folder("d.json"), d, err));
    char *text = contents(in_folder("d.json"));
    ck_assert_ptr_nonnull(value(text));
    ck_assert_ptr_nonnull(strstr(text, "\"indistinguishable\": []"));
    ck_assert_ptr_null(strstr(text, "place1"));
    free(text);
    d->nsuspect = 0;
    static const char *const none[] = {"<h1>The model lacks an effect</h1>", NULL};
    page_has(d, none, "place0");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_cause_that_is_in_no_table_has_a_place_and_no_kind)
{
    static const char *const has[] = {": nothing of the place0</h1>",
                                      "<th scope=\"row\"><small>place1</small></th>", NULL};
    lab_diagnosis *d = made_up();
    for (int i = 0; i < 3; i++) {
        d->suspect[i].candidate.effect = NULL;
        d->suspect[i].nnumber = 0;
    }
    page_has(d, has, "usual signs");
    ck_assert_stein(lab_diagnosis_json(in_folder("d.json"), d, err));
    char *text = contents(in_folder("d.json"));
    ck_assert_ptr_nonnull(value(text));
    ck_assert_ptr_nonnull(strstr(text, "\"kind\": null"));
    free(text);
    lab_diagnosis_destroy(d);
}
END_TEST

/* ---- pictures ---- */

START_TEST(a_range_is_never_empty)
{
    static const struct {
        double lo, hi, from, to;
    } range[] = {
        {-1.25, 3.5, -1.25, 3.5},  {2.5, 2.5, 2.25, 2.75},           {-4.0, -4.0, -4.4, -3.6},
        {0.0, 0.0, -1e-12, 1e-12}, {INFINITY, -INFINITY, -1.0, 1.0}, {NAN, 0.5, -1.0, 0.55},
        {NAN, -7.0, -1.0, 1.0}};
    for (size_t i = 0; i < sizeof range / sizeof *range; i++) {
        double lo = range[i].lo, hi = range[i].hi;
        page__range(&lo, &hi, 0.0);
        ck_assert_close(lo, range[i].from, 1e-9, 0.0);
        ck_assert_close(hi, range[i].to, 1e-9, 0.0);
    }
}
END_TEST

START_TEST(a_check_without_an_extension_draws_the_required_force)
{
    static const char *const has[] = {
        " (drive, smoothed) is prescribed here, in 1 record. The rest",
        "needed by the model of the file<span class=\"key area\">",
        "in the force: " MINUS "0.40 \xc2\xb1 0.30",
        "time [s]",
        "<figcaption>a&lt;b&gt;.csv</figcaption>",
        NULL};
    static const char *const bare[] = {"The check <em>cannot tell</em>", NULL};
    lab_diagnosis *d = made_up();
    lab_motion *m = &d->motion;
    check_motion(m);
    for (int i = 0; i < m->n; i++) {
        m->t[i] *= 100.0;
        m->after[i] = NAN;
    }
    m->row[0].after = NAN;
    m->file = "a<b>.csv";
    m->channel = NULL;
    m->strokes = 1;
    m->held_out = 0;
    m->of_force.share = -0.4;
    m->of_force.share_sd = 0.3;
    page_has(d, has, "by the extended model");
    m->n = 1; // no curve
    m->nrow = 0;
    m->says = LAB_MOTION_CANNOT_TELL;
    m->of_force.share_sd = NAN;
    page_has(d, bare, "in the force:");
    page_has(d, bare, "<figcaption>a&lt;b&gt;.csv");
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(a_slow_fitted_stroke_is_drawn_in_seconds)
{
    static const char *const has[] = {
        ">time [s]</text>",      "<figcaption>a&lt;b&gt;.csv</figcaption>",
        ">height</text>",        "<span class=\"key blue\"></span>model<span",
        ">hammer [mN m]</text>", NULL};
    static const char *const alone[] = {">time [s]</text>", NULL};
    lab_diagnosis *d = made_up();
    draw(d);
    lab_trace *t = d->trace;
    lab_latent *l = d->latent;
    free(t->phase);
    t->phase = NULL;
    t->file = l->file = "a<b>.csv";
    t->unit = "1";
    t->held_out = 0;
    t->noise = 0.0;
    for (int i = 0; i < t->n; i++) {
        t->t[i] *= 100.0;
        l->t[i] *= 100.0;
        t->y[i] = t->before[i] = t->after[i] = 0.0;
    }
    l->force[3] = 2e-3;
    l->sd[5] = INFINITY;
    d->motion.says = LAB_MOTION_NOT_DONE;
    page_has(d, has, "time [ms]");
    l->n = 1; // no course over time
    page_has(d, alone, ">hammer [mN m]</text>");
    lab_diagnosis_destroy(d);
}
END_TEST

/* a factor of the normal force as a function of the depth, that is made up */
static void recover_law(lab_diagnosis *d)
{
    enum { N = 4 };
    d->law = calloc(1, sizeof *d->law);
    d->nlaw = 1;
    *d->law = (lab_law){.place = "soft_<stop>",
                        .site = "contact",
                        .of = "depth",
                        .what = "factor",
                        .at_unit = "m",
                        .unit = "1",
                        .table = "soft_stop_depth",
                        .n = N,
                        .gain = 71.5,
                        .chi2_dof = 1.04,
                        .held_out = 1.13,
                        .pays = 1};
    d->law->at = calloc(5 * N, sizeof *d->law->at); // one block
    double **list[] = {&d->law->at, &d->law->value, &d->law->lo, &d->law->hi, &d->law->sd};
    for (int i = 0; i < 5; i++) {
        *list[i] = d->law->at + i * N;
        for (int k = 0; k < N; k++) {
            (*list[i])[k] = i == 0 ? 1e-4 * k : 0.3 * k + 0.1 * (i == 3) - 0.1 * (i == 2);
        }
    }
    d->law->seen = calloc(N, sizeof *d->law->seen);
}

START_TEST(a_law_that_pays_is_drawn_and_one_that_does_not_is_listed)
{
    static const char *const pays[] = {
        "acts at the contact soft &lt;stop&gt; as a function of its depth.",
        "<code>soft_stop_depth</code> in extended.yaml",
        "A physical explanation must have this shape.",
        ">factor</text>",
        ">depth of soft_&lt;stop&gt; [\xc2\xb5m]</text>",
        "<h2>Error on records held out, before and after</h2>",
        "<td class=\"number\">1.13</td>",
        NULL};
    static const char *const fails[] = {
        "No curve over one state of one place predicts the held-out records better",
        "Look where the map below is darkest", "<h2>Error on records held out</h2>",
        "<td class=\"number\"></td>", NULL};
    lab_diagnosis *d = made_up();
    d->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
    d->ncause = d->nrival = 0;
    recover_law(d);
    page_has(d, pays, "No curve over one state");
    d->law->pays = 0;
    d->law->held_out = NAN;
    page_has(d, fails, "in extended.yaml.</p>");
    ck_assert_stein(lab_diagnosis_json(in_folder("d.json"), d, err));
    char *text = contents(in_folder("d.json"));
    ck_assert_ptr_nonnull(value(text));
    ck_assert_ptr_nonnull(strstr(text, "\"law\": null"));
    ck_assert_ptr_nonnull(strstr(text, "\"held_out\": null"));
    free(text);
    lab_diagnosis_destroy(d);
}
END_TEST

START_TEST(the_map_distinguishes_unknown_scatter_from_certainty)
{
    static const char *const has[] = {
        "<td class=\"heat h5\" title=\"z = 12.5, 90 samples\">\xe2\x80\x93<small>", NULL};
    lab_diagnosis *d = made_up();
    d->departure[0].sd = 0.0;
    d->departure[0].z = 12.5;
    page_has(d, has, "class=\"heat h3\"");
    lab_diagnosis_destroy(d);
}
END_TEST

Suite *report_suite(void)
{
    Suite *suite = suite_create("report");
    TCase *tells = tcase_create("tells");
    tcase_add_checked_fixture(tells, make_folder, remove_folder);
    tcase_set_timeout(tells, 60);
    tcase_add_test(tells, the_json_has_its_documented_keys_and_reads_back);
    tcase_add_test(tells, every_verdict_can_be_written_with_nothing_else_known);
    tcase_add_test(tells, a_file_that_cannot_be_written_is_reported_and_none_is_left);
    tcase_add_test(tells, the_page_stands_alone_and_takes_no_text_for_markup);
    tcase_add_test(tells, numbers_are_written_for_readers);
    tcase_add_test(tells, several_causes_have_each_its_size_and_its_place_once);
    tcase_add_test(tells, causes_of_several_kinds_are_not_called_by_one);
    tcase_add_test(tells, records_that_state_the_wrong_thing_have_no_fit_in_their_report);
    tcase_add_test(tells, pieces_of_one_record_are_not_called_records);
    tcase_add_test(tells, a_force_that_shows_nowhere_is_not_drawn);
    tcase_add_test(tells, a_number_that_acts_like_the_cause_is_beside_it);
    tcase_add_test(tells, contradictions_are_beside_the_verdict);
    tcase_add_test(tells, the_first_screen_has_the_error_in_the_unit_of_the_channel);
    tcase_add_test(tells, refitted_numbers_show_their_change);
    tcase_add_test(tells, the_next_step_depends_on_the_verdict);
    tcase_add_test(tells, a_gain_is_shown_as_far_as_it_is_known);
    tcase_add_test(tells, counts_beyond_the_list_are_not_followed);
    tcase_add_test(tells, a_cause_that_is_in_no_table_has_a_place_and_no_kind);
    tcase_add_test(tells, a_range_is_never_empty);
    tcase_add_test(tells, a_check_without_an_extension_draws_the_required_force);
    tcase_add_test(tells, a_slow_fitted_stroke_is_drawn_in_seconds);
    tcase_add_test(tells, a_law_that_pays_is_drawn_and_one_that_does_not_is_listed);
    tcase_add_test(tells, the_map_distinguishes_unknown_scatter_from_certainty);
    suite_add_tcase(suite, tells);
    return suite;
}
