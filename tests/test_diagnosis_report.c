/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_diagnosis_report.c - what a diagnosis shows: phases, departures, missing forces, and the two
 * files it writes.
 */
#include "diagnosing.h"
#include "fit_support.h"

static const char action[] = "models/stein1788.yaml";

/* ---- strokes of the action, made by the core ---- */

enum { STROKES = 8 };

/* a fit to strokes in which something is hidden, with little that could imitate it */
typedef struct shown {
    fitted f;
    lab_fit_def def;
    fit__problem p;
    double *x, *r, *J, *time;
    const char **phase;
    lab_diagnosis d;
} shown;

static void film_strokes(const char *data[STROKES + 1], const char *const *truth)
{
    static const char *const load[] = {"load.mass=70 g", "load.mass=100 g", "load.mass=140 g"};
    static const char *const shift[] = {"pawl.stop_shift=-0.6 mm", "pawl.stop_shift=-0.2 mm"};
    static char kept[STROKES][200];
    for (int i = 0; i < STROKES; i++) {
        const char *const told[] = {load[i % 3], shift[i % 2], NULL};
        char name[32];
        film m = {.model = action,
                  .truth = truth,
                  .told = told,
                  .channels = "string_distance key_dip",
                  .rate = 2000.0,
                  .from = -0.004,
                  .until = 0.11,
                  .noise = 12e-6,
                  .seed = 40 + (unsigned long long)i};
        snprintf(name, sizeof name, "stroke%d.csv", i);
        snprintf(kept[i], sizeof kept[i], "%s", take(name, &m));
        data[i] = kept[i];
    }
    data[STROKES] = NULL;
}

/* fit what is free, then everything that is shown */
static void show(shown *s, const char *const *truth)
{
    static const char *const names[] = {"notch.friction.A", "hammer.inertia.yy", NULL};
    const char *data[STROKES + 1];
    int failed = 0;
    film_strokes(data, truth);
    open_fit(&s->f, action, NULL, data);
    s->def = free_these(names);
    s->def.drive_scatter = 0.0;
    ck_assert_stein(fit__problem_make(&s->p, s->f.model, s->f.data, &s->def, err));
    size_t nu = (size_t)s->p.nu, frames = diag__row(&s->p, s->p.nstroke);
    double *room = calloc(2 * nu, sizeof *room);
    fit__state state = {.x = room, .step = room + nu, .mu = 1e-3, .nu = 2.0};
    for (size_t k = 0; k < nu; k++) {
        state.step[k] = s->p.step[k];
    }
    ck_assert_stein(fit__minimise(&s->p, &state, 1e-2, 1e-5, 20, NULL, NULL, err));
    s->x = room;
    s->r = calloc(fit__offset(&s->p, s->p.nstroke), sizeof *s->r);
    s->J = calloc(fit__columns(&s->p), sizeof *s->J);
    s->phase = calloc(frames, sizeof *s->phase);
    s->time = calloc(frames, sizeof *s->time);
    s->d = (lab_diagnosis){.verdict = LAB_VERDICT_EXPLAINED};
    ck_assert_stein(fit__residuals(&s->p, s->x, s->r, &failed, err));
    ck_assert_int_eq(failed, 0);
    ck_assert_stein(fit__sensitivities(&s->p, s->x, s->r, s->J, err));
    ck_assert_stein(diag__phases(&s->p, s->x, s->phase, s->time, err));
    ck_assert_stein(diag__show(&s->d, &s->p, s->x, s->r, s->J, s->phase, s->time, err));
}

static void drop_shown(shown *s)
{
    lab_diagnosis *d = malloc(sizeof *d);
    *d = s->d;
    lab_diagnosis_destroy(d);
    fit__problem_free(&s->p);
    drop(&s->f);
    free(s->x);
    free(s->r);
    free(s->J);
    free(s->time);
    free(s->phase);
}

static const lab_departure *hottest(const lab_diagnosis *d, int is_force)
{
    const lab_departure *hot = NULL;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *r = &d->departure[i];
        hot = r->is_force == is_force && isfinite(r->z) && (hot == NULL || r->z > hot->z) ? r : hot;
    }
    ck_assert_ptr_nonnull(hot);
    return hot;
}

static const lab_departure *departure(const lab_diagnosis *d, const char *place, const char *phase)
{
    for (int i = 0; i < d->ndeparture; i++) {
        if (strcmp(d->departure[i].place, place) == 0 &&
            strcmp(d->departure[i].phase, phase) == 0) {
            return &d->departure[i];
        }
    }
    ck_abort_msg("no departure of %s in %s", place, phase);
    return NULL;
}

/* ---- phases ---- */

/* time at which a phase begins in a stroke; NAN */
static double begins(const shown *s, int stroke, const char *phase)
{
    size_t row = diag__row(&s->p, stroke);
    for (int i = 0; i < s->p.stroke[stroke].n; i++) {
        if (strcmp(s->phase[row + (size_t)i], phase) == 0) {
            return s->time[row + (size_t)i];
        }
    }
    return NAN;
}

START_TEST(nothing_hidden_nothing_shown)
{
    shown s;
    show(&s, NULL);
    const lab_departure *channel = hottest(&s.d, 0), *force = hottest(&s.d, 1);
    ck_assert_msg(channel->z < 4.0, "%s %s: %g", channel->place, channel->phase, channel->z);
    ck_assert_msg(force->z < 4.0, "%s %s: %g", force->place, force->phase, force->z);
    for (int i = 0; i < s.d.nlatent; i++) {
        const lab_latent *l = &s.d.latent[i];
        for (int k = 0; k < l->n; k++) {
            ck_assert_msg(fabs(l->force[k]) < 4.0 * l->sd[k], "%s at %g s", l->joint, l->t[k]);
        }
    }
    // phases come in order, and at the times of the stroke's events
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(s.f.model));
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(s.f.model, NULL, &sim, err));
    ck_assert_stein(stein_set(sim, "load.mass", 0.14, err));
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.6e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    def.until = 0.11;
    ck_assert_stein(lab_strike(sim, &def, &stroke, err));
    double frame = 1.0 / 2000.0;
    double flight = begins(&s, 2, "free flight"), string = begins(&s, 2, "string");
    ck_assert(flight >= stroke.escape_time - 1e-4 && flight < stroke.escape_time + 1.5 * frame);
    ck_assert(string >= stroke.impact_time - 1e-4 && string < stroke.impact_time + 1.5 * frame);
    ck_assert(begins(&s, 2, "rest") <= 0.0 && begins(&s, 2, "drive i") < 2.0 * frame);
    ck_assert(begins(&s, 2, "drive iii") > begins(&s, 2, "drive i"));
    ck_assert(begins(&s, 2, "fall") > string);
    ck_assert_msg(begins(&s, 1, "re-arm") > begins(&s, 1, "fall"), "%g", begins(&s, 1, "re-arm"));
    ck_assert(isnan(begins(&s, 2, "motion")));
    stein_sim_destroy(sim);
    drop_shown(&s);
}
END_TEST

START_TEST(a_mechanism_without_stroke_rests_or_moves)
{
    static const char *const names[] = {"rod.damping", NULL};
    static const char *const held[] = {"rod.initial.position=0 deg", NULL};
    film m = {.model = "models/pendulum.yaml",
              .channels = "angle",
              .rate = 40.0,
              .until = 2.0,
              .noise = 1e-3,
              .seed = 3};
    static char first[200];
    snprintf(first, sizeof first, "%s", take("swing.csv", &m));
    m.told = held;
    const char *data[] = {first, take("still.csv", &m), NULL};
    fitted f;
    fit__problem p;
    open_fit(&f, m.model, NULL, data);
    lab_fit_def def = free_these(names);
    def.initial = 0;
    ck_assert_stein(fit__problem_make(&p, f.model, f.data, &def, err));
    double *x = calloc((size_t)p.nu, sizeof *x);
    const char **phase = calloc(diag__row(&p, 2), sizeof *phase);
    ck_assert_stein(diag__phases(&p, x, phase, NULL, err));
    for (int i = 0; i < p.stroke[0].n; i++) {
        ck_assert_str_eq(phase[i], i == 0 ? "rest" : "motion");
        ck_assert_str_eq(phase[p.stroke[0].n + i], "rest");
    }
    fit__problem_free(&p);
    drop(&f);
    free(x);
    free(phase);
}
END_TEST

/* ---- missing forces ---- */

START_TEST(a_hidden_drag_is_missing_at_its_joint_with_its_size)
{
    static const char *const truth[] = {"hammer.drag=1e-6 N m s^2/rad^2", NULL};
    const double k = 1e-6;
    shown s;
    show(&s, truth);
    const lab_departure *hot = hottest(&s.d, 1);
    ck_assert_str_eq(hot->place, "hammer");
    ck_assert_msg(hot->z > 4.0, "%g", hot->z);
    ck_assert_double_lt(departure(&s.d, "hammer", "free flight")->size, 0.0); // it goes up
    ck_assert_double_gt(departure(&s.d, "hammer", "fall")->size, 0.0);
    // over time: against the true torque of the true stroke
    int inside = 0, points = 0, hammer = stein_find_body(lab_equations(s.f.model), "hammer");
    double size = 0.0;
    for (int i = 0; i < s.d.nlatent; i++) {
        const lab_latent *l = &s.d.latent[i];
        int stroke = 0;
        while (strcmp(s.p.stroke[stroke].data->file, l->file) != 0) {
            stroke++;
        }
        stein_sim *sim = NULL;
        ck_assert_stein(lab_sim(s.f.model, NULL, &sim, err));
        const lab_data *data = s.p.stroke[stroke].data;
        for (int n = 0; n < data->nset; n++) {
            ck_assert_stein(stein_set(sim, data->set[n].name, data->set[n].value, err));
        }
        ck_assert_stein(stein_set(sim, "hammer.drag", k, err));
        ck_assert_stein(stein_reset(sim, err));
        for (int n = 0; strcmp(l->joint, "hammer") == 0 && n < l->n; n++) {
            ck_assert_stein(stein_run(sim, fmax(l->t[n], stein_time(sim)), err));
            double w = stein_qd(sim)[hammer], T = -k * fabs(w) * w;
            inside += fabs(l->force[n] - T) < 3.0 * l->sd[n];
            size = fmax(size, fabs(T));
            points++;
        }
        stein_sim_destroy(sim);
    }
    printf("missing force: %d of %d points within their band, up to %.2g N m\n", inside, points,
           size);
    ck_assert_int_gt(points, 100);
    ck_assert_int_gt(inside, points * 85 / 100);
    drop_shown(&s);
}
END_TEST

START_TEST(a_hidden_preload_is_missing_at_its_joint_with_its_size)
{
    static const char *const truth[] = {"key.preload=1.3 mN m", NULL};
    shown s;
    show(&s, truth);
    const lab_departure *hot = hottest(&s.d, 1), *key = departure(&s.d, "key", "drive iii");
    ck_assert_str_eq(hot->place, "key");
    ck_assert_msg(hot->z > 4.0, "%s: %g", hot->phase, hot->z);
    ck_assert_msg(fabs(key->size - 1.3e-3) < 3.0 * key->sd + 0.1e-3, "%g +- %g", key->size,
                  key->sd);
    drop_shown(&s);
}
END_TEST

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

START_TEST(the_json_has_what_was_promised_and_reads_back)
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
    static const char *const alone[] = {"meta", "rect", "path", "!DOCTYPE"};
    char open[64][16], name[16];
    int depth = 0;
    for (const char *at = strchr(text, '<'); at != NULL; at = strchr(at + 1, '<')) {
        int closing = at[1] == '/', single = 0;
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
    static const char *const never[] = {"http", "src=", "<script", "<effect", "<tags", "<shows>",
                                        "<b>",  "url(", "@import", "nan",     "inf\""};
    static const char *const present[] = {
        "The model lacks something: odd &lt;effect&gt; of the place0",
        "A &quot;reason&quot; with &lt;tags&gt; &amp; signs",
        "place1",
        "&lt;script ",
        "a&lt;b&gt;.csv",
        "prefers-color-scheme",
        "width=device-width",
        "N&nbsp;m&nbsp;s<sup>2</sup>/rad<sup>2</sup>",
        "[1.0 \xe2\x80\xa6 3.0]</span>\xc2\xb7"
        "10<sup>\xe2\x88\x92"
        "7</sup>"};
    lab_diagnosis *d = made_up();
    draw(d);
    const char *path = in_folder("report.html");
    ck_assert_stein(lab_diagnosis_page(path, d, err));
    char *text = contents(path);
    // what the audit quoted is there, but as text
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

Suite *report_suite(void)
{
    Suite *suite = suite_create("report");
    TCase *shows = tcase_create("shows");
    tcase_add_checked_fixture(shows, make_folder, remove_folder);
    tcase_set_timeout(shows, 300);
    tcase_add_test(shows, nothing_hidden_nothing_shown);
    tcase_add_test(shows, a_mechanism_without_stroke_rests_or_moves);
    tcase_add_test(shows, a_hidden_drag_is_missing_at_its_joint_with_its_size);
    tcase_add_test(shows, a_hidden_preload_is_missing_at_its_joint_with_its_size);
    suite_add_tcase(suite, shows);
    TCase *tells = tcase_create("tells");
    tcase_add_checked_fixture(tells, make_folder, remove_folder);
    tcase_set_timeout(tells, 60);
    tcase_add_test(tells, the_json_has_what_was_promised_and_reads_back);
    tcase_add_test(tells, every_verdict_can_be_written_with_nothing_else_known);
    tcase_add_test(tells, a_file_that_cannot_be_written_is_reported_and_none_is_left);
    tcase_add_test(tells, the_page_stands_alone_and_takes_no_text_for_markup);
    suite_add_tcase(suite, tells);
    return suite;
}
