/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_extend.c - the extended file: for every cause it is a mechanism file with the numbers of the
 * diagnosis in their places, and everything else unchanged.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab_support.h"
#include "added_parts.h"

Suite *extend_suite(void);

static const char file[] = "models/stein1788.yaml";
enum { SAMPLES = 300 };

/* ---- a diagnosis by hand ---- */

static lab_fit_value fitted[] = {
    {.name = "key.mass",
     .unit = "kg",
     .start = 70.45e-3,
     .value = 70.912345678901234e-3,
     .sd = 2.1e-4},
    {.name = "string.height", .unit = "m", .start = 74.553e-3, .value = 74.601e-3, .sd = 3e-5},
    {.name = "notch.friction.A", .unit = "1", .start = 0.3133, .value = 0.3271, .sd = 0.011}};

static lab_seen record[] = {{.file = "strokes/f6_01.csv"},
                            {.file = "strokes/f6_02.csv"},
                            {.file = "strokes/f6_07.csv", .reporting = 1}};
static char *finding[] = {"f6_01.csv: 2 frames are missing"};

static lab_suspect suspect(const lab_candidate *c, double amount)
{
    lab_suspect s = {.candidate = *c, .amount = amount, .refitted = 1};
    lab_cause_number *n = s.number;
    snprintf(n[0].name, sizeof n[0].name, "%s", c->effect->size);
    n[0].unit = c->unit, n[0].value = amount;
    n[0].lo = amount - 0.1 * fabs(amount), n[0].hi = amount + 0.1 * fabs(amount);
    n[0].sd = 0.05 * fabs(amount);
    s.nnumber = 1;
    for (int k = 0; k < LAB_SIDES && c->side[k].name != NULL; k++) {
        const lab_side *side = &c->side[k];
        const char *last = strrchr(side->name, '.');
        lab_cause_number *to = &n[s.nnumber++];
        snprintf(to->name, sizeof to->name, "%s", last != NULL ? last + 1 : side->name);
        to->unit = side->unit, to->value = 1.1 * side->value;
        to->lo = 0.9 * side->value, to->hi = 1.3 * side->value;
    }
    return s;
}

static lab_diagnosis diagnosis(lab_suspect *list, int n)
{
    lab_diagnosis d = {.verdict = LAB_VERDICT_MISSING_EFFECT,
                       .reason = "Something was missing,\nand here it is.",
                       .nsuspect = n,
                       .suspect = list,
                       .ncause = n,
                       .nfit = 12,
                       .nheld = 6,
                       .nvalue = 3,
                       .value = fitted,
                       .nfinding = 1,
                       .finding = finding,
                       .nrecord = 3,
                       .record = record};
    d.gain.ratio = 0.31, d.gain.lo = 0.28, d.gain.hi = 0.36;
    return d;
}

static lab_model *open_file(const char *path)
{
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, path, NULL, err));
    return model;
}

static lab_candidate *list_of(const lab_model *model, int *n)
{
    lab_candidate *list = NULL;
    ck_assert_stein(lab_candidates(&list, n, model, err));
    return list;
}

static lab_candidate find(const lab_candidate *list, int n, const char *kind, const char *place)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, kind) == 0 && strcmp(list[i].place, place) == 0) {
            return list[i];
        }
    }
    ck_abort_msg("there is no %s at %s", kind, place);
    return list[0];
}

/* expected text of the file: fitted values, then the candidate with its numbers */
static double *meant(const lab_candidate *bound, const lab_suspect *s, const lab_model *model)
{
    const stein_model *m = lab_equations(model);
    lab_candidate c = *bound;
    double *p = malloc(sizeof *p * (size_t)m->np);
    memcpy(p, lab_parameters(model), sizeof *p * (size_t)m->np);
    for (size_t i = 0; i < sizeof fitted / sizeof *fitted; i++) {
        p[stein_find_param(m, fitted[i].name)] = fitted[i].value;
    }
    for (int k = 0; k < LAB_SIDES && 1 + k < s->nnumber; k++) {
        c.side[k].value = s->number[1 + k].value;
    }
    lab_candidate_apply(&c, s->amount, p);
    return p;
}

/* ---- all of them ---- */

static void check_numbers(const lab_candidate *c, const double *p, const lab_model *model,
                          const char *path)
{
    lab_model *extended = open_file(path);
    const stein_model *m = lab_equations(model), *x = lab_equations(extended);
    ck_assert_str_eq(x->equations, m->equations); // the same equations, so nothing is compiled
    for (int i = 0; i < m->np; i++) {
        ck_assert_str_eq(x->params[i].name, m->params[i].name);
        ck_assert_msg(fabs(lab_parameters(extended)[i] - p[i]) <= 6e-15 * fabs(p[i]),
                      "%s at %s: %s is %.17g, meant is %.17g", c->effect->kind, c->place,
                      m->params[i].name, lab_parameters(extended)[i], p[i]);
    }
    lab_close(extended);
}

/* loop: a quarter each */
START_TEST(every_cause_has_its_place_in_the_file)
{
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n);
    make_folder();
    const char *path = in_folder("extended.yaml");
    char kept[200];
    snprintf(kept, sizeof kept, "%s", path);
    for (int i = _i; i < n; i += 4) {
        lab_candidate c = list[i];
        lab_suspect s = suspect(&c, 0.07 * c.limit);
        lab_diagnosis d = diagnosis(&s, 1);
        lab_model *base = NULL;
        ck_assert_stein(lab_candidate_open(&c, &base, file, NULL, err));
        double *p = meant(&c, &s, base);
        ck_assert_stein(lab_extend(kept, file, &d, err));
        check_numbers(&c, p, base, kept);
        free(p);
        lab_close(base);
    }
    remove_folder();
    free(list);
    lab_close(model);
}
END_TEST

/* ---- the motion ---- */

typedef struct trace {
    int n;
    double y[SAMPLES][24];
} trace;

static stein_status take(void *ctx, stein_sim *sim)
{
    trace *t = ctx;
    ck_assert_int_lt(t->n, SAMPLES);
    for (int c = 0; c < stein_sim_model(sim)->nchannel; c++) {
        t->y[t->n][c] = stein_read(sim, c);
    }
    t->n++;
    return STEIN_OK;
}

static void run(trace *t, const lab_model *model, const double *p)
{
    stein_sim *sim = NULL;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_set_all(sim, p, err));
    ck_assert_stein(stein_reset(sim, err));
    lab_stroke_def stroke = lab_stroke_def_default(lab_equations(model));
    stroke.until = 0.055;
    stroke.every = 5e-4;
    stroke.sample = take;
    stroke.ctx = t;
    memset(t, 0, sizeof *t);
    ck_assert_stein(lab_simulate(sim, &stroke, err));
    stein_sim_destroy(sim);
}

static const struct {
    const char *kind, *place;
} moved[] = {{"viscous_friction", "hammer"},
             {"coulomb_friction", "key"},
             {"joint_stiffness", "pawl"},
             {"contact_stiffness", "notch"},
             {"sensor_nonlinearity", "key_dip"},
             {"elastic_hinge", "hammer"},
             {"elastic_hinge", "key"},
             {"axis_translation", "key"},
             {"compliant_partner", "string"},
             {"string_damper", "key"},
             {"wire", "key"}};

static trace before, now;

START_TEST(the_file_moves_as_in_the_diagnosis)
{
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n);
    make_folder();
    for (size_t k = 0; k < sizeof moved / sizeof *moved; k++) {
        lab_candidate c = find(list, n, moved[k].kind, moved[k].place);
        lab_suspect s = suspect(&c, 0.3 * c.limit);
        lab_diagnosis d = diagnosis(&s, 1);
        lab_model *base = NULL;
        const char *path = in_folder("extended.yaml");
        ck_assert_stein(lab_candidate_open(&c, &base, file, NULL, err));
        double *p = meant(&c, &s, base);
        ck_assert_stein(lab_extend(path, file, &d, err));
        lab_model *extended = open_file(path);
        run(&before, base, p);
        run(&now, extended, lab_parameters(extended));
        ck_assert_int_eq(before.n, now.n);
        for (int i = 0; i < before.n; i++) {
            for (int ch = 0; ch < lab_equations(base)->nchannel; ch++) {
                const char *unit = lab_equations(base)->channels[ch].unit;
                int place = strcmp(unit, "m") == 0 || strcmp(unit, "rad") == 0;
                double off = fabs(before.y[i][ch] - now.y[i][ch]);
                ck_assert_msg(off <= (place ? 1e-12 : 1e-8), "%s at %s: channel %d off by %g",
                              moved[k].kind, moved[k].place, ch, off);
            }
        }
        free(p);
        lab_close(extended);
        lab_close(base);
    }
    remove_folder();
    free(list);
    lab_close(model);
}
END_TEST

/* records state their load, so the file has its error beside its mass */
START_TEST(an_error_of_the_load_holds_for_every_load_that_is_stated)
{
    lab_model *model = open_file(file), *base = NULL;
    int n = 0;
    lab_candidate *list = list_of(model, &n), c = find(list, n, "unknown_load", "load");
    lab_suspect s = suspect(&c, 0.1);
    lab_diagnosis d = diagnosis(&s, 1);
    make_folder();
    ck_assert_stein(lab_candidate_open(&c, &base, file, NULL, err));
    double *p = meant(&c, &s, base), own[1000];
    ck_assert_stein(lab_extend(in_folder("extended.yaml"), file, &d, err));
    lab_model *extended = open_file(in_folder("extended.yaml"));
    const stein_model *m = lab_equations(extended);
    int mass = stein_find_param(m, "load.mass"), error = stein_find_param(m, "load.error");
    ck_assert_int_le(m->np, 1000);
    memcpy(own, lab_parameters(extended), sizeof *own * (size_t)m->np);
    ck_assert_double_eq(own[mass], 0.1);
    ck_assert_double_eq(own[error], 0.1);
    own[mass] = 0.07;
    p[stein_find_param(lab_equations(base), "load.mass")] = 0.077; // the same without an error
    p[stein_find_param(lab_equations(base), "load.error")] = 0.0;
    run(&before, base, p);
    run(&now, extended, own);
    ck_assert_int_eq(before.n, now.n);
    for (int i = 0; i < before.n; i++) {
        ck_assert_double_eq_tol(before.y[i][0], now.y[i][0], 1e-12);
    }
    free(p);
    lab_close(extended);
    lab_close(base);
    remove_folder();
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(several_causes_go_into_one_file)
{
    static const char *const cause[][2] = {{"wire", "key"},
                                           {"elastic_hinge", "hammer"},
                                           {"preload", "pawl"},
                                           {"sensor_gain", "key_dip"},
                                           {"time_base", "clock"}};
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n);
    lab_suspect s[5];
    for (int i = 0; i < 5; i++) {
        lab_candidate c = find(list, n, cause[i][0], cause[i][1]);
        s[i] = suspect(&c, 0.1 * c.limit);
    }
    lab_diagnosis d = diagnosis(s, 5);
    make_folder();
    const char *path = in_folder("extended.yaml");
    ck_assert_stein(lab_extend(path, file, &d, err));
    lab_model *extended = open_file(path);
    const stein_model *x = lab_equations(extended);
    static const char *const name[] = {"key_wire.k", "hammer_outer.compliance", "pawl.preload",
                                       "key_dip.sensor.gain", "clock.error"};
    for (int i = 0; i < 5; i++) {
        int k = stein_find_param(x, name[i]);
        double neutral = i == 3 ? 1.0 : 0.0;
        ck_assert_int_ge(k, 0);
        ck_assert_close(x->params[k].value, neutral + s[i].amount, 1e-12, 0.0);
        ck_assert_close(x->params[k].tolerance, 0.05 * s[i].amount, 0.01, 0.0);
    }
    remove_folder();
    lab_close(extended);
    free(list);
    lab_close(model);
}
END_TEST

/* ---- the text ---- */

START_TEST(the_head_states_additions_and_data)
{
    static const char *const said[] = {
        "# Extended by stein diagnose (missing_effect), from stein1788.yaml (fnv1a64 ",
        "# Something was missing, and here it is.\n",
        "#   string_damper at key: from dip x0 on",
        "#     F0 = 0.2072 N, 95 %: 0.18648 N .. 0.22792 N\n",
        "#     x0 = ",
        "#     k_to_F0 = ",
        "# From 12 records, and 6 held out, where the error is 0.31 of the former one, 95 %: 0.28 ",
        " .. 0.36\n",
        "#   data f6_01.csv\n#   data f6_02.csv\n#   data f6_07.csv (held out)\n",
        "#   audit f6_01.csv: 2 frames are missing\n",
        "#   key.mass = 0.070912 +- 0.00021 kg (was 0.07045)\n",
        "mass: 70.9123456789012 g +- 0.21 g ",
        "# [cal; 40-80 g in lit]"};
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n), c = find(list, n, "string_damper", "key");
    lab_suspect s = suspect(&c, 0.2072);
    lab_diagnosis d = diagnosis(&s, 1);
    make_folder();
    const char *path = in_folder("extended.yaml");
    ck_assert_stein(lab_extend(path, file, &d, err));
    char *text = NULL, *old = NULL;
    size_t size = 0;
    ck_assert_stein(lab__read_file(path, &text, &size, err));
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) {
        ck_assert_msg(strstr(text, said[i]) != NULL, "no \"%s\" in\n%.3000s", said[i], text);
    }
    ck_assert_stein(lab__read_file(file, &old, &size, err));
    for (char *line = strtok(old, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        char *comment = strchr(line, '#');
        ck_assert_msg(comment == NULL || strstr(text, comment) != NULL, "%s is lost", comment);
    }
    remove_folder();
    free(text);
    free(old);
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(every_command_takes_the_extended_file)
{
    static const char *const command[] = {"strike %s", "sweep %s --vary key_wire.k=0:5:3",
                                          "generate %s -o %s.c", "check %s"};
    const char *build = getenv("STEIN_BUILD");
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n), c = find(list, n, "wire", "key");
    lab_suspect s = suspect(&c, 0.1 * c.limit);
    lab_diagnosis d = diagnosis(&s, 1);
    make_folder();
    char path[200], line[3000], rest[1500];
    snprintf(path, sizeof path, "%s", in_folder("extended.yaml"));
    ck_assert_stein(lab_extend(path, file, &d, err));
    for (size_t i = 0; i < sizeof command / sizeof *command; i++) {
        const char *percent = strstr(command[i], "%s");
        snprintf(rest, sizeof rest, "%.*s%s%s", (int)(percent - command[i]), command[i], path,
                 i == 2 ? "" : percent + 2);
        if (i == 2) {
            snprintf(rest + strlen(rest), sizeof rest - strlen(rest), " -o %s.c", path);
        }
        snprintf(line, sizeof line, "%s/stein %s >%s.out 2>&1", build != NULL ? build : "build",
                 rest, path);
        ck_assert_msg(system(line) == 0, "%s", line);
    }
    remove_folder();
    free(list);
    lab_close(model);
}
END_TEST

START_TEST(values_that_cannot_be_written_are_refused)
{
    lab_model *model = open_file(file);
    int n = 0;
    lab_candidate *list = list_of(model, &n), c = find(list, n, "preload", "key");
    lab_suspect s = suspect(&c, 0.1 * c.limit);
    lab_diagnosis d = diagnosis(&s, 1);
    stein_err why = {STEIN_OK, ""};
    make_folder();
    const char *path = in_folder("extended.yaml");
    d.ncause = 0;
    ck_assert_int_eq(lab_extend(path, file, &d, &why), STEIN_EINVAL);
    d.ncause = 1;
    ck_assert_int_eq(lab_extend(path, "nowhere.yaml", &d, &why), STEIN_EIO);
    ck_assert_int_eq(lab_extend("/nowhere/x.yaml", file, &d, &why), STEIN_EIO);
    s.candidate.effect = lab_effect_find("wire");
    strcpy(s.candidate.place, "pawl");
    ck_assert_int_eq(lab_extend(path, file, &d, &why), STEIN_EINVAL);
    ck_assert_int_ne(access(path, F_OK), 0);
    remove_folder();
    free(list);
    lab_close(model);
}
END_TEST

/* ---- the text alone ---- */

static const char cart[] = "# a cart of \xc2\xb5m\n"
                           "mechanism: cart\n"
                           "bodies:\n"
                           "  # the first one\n"
                           "  # of two\n"
                           "  cart: {joint: T x, mass: 2 kg}\n"
                           "list:\n"
                           "  - between: [cart, rod]\n"
                           "    about: cart\n"
                           "  - rod\n"
                           "nothing: {}\n"
                           "# the end\n";

static lab__yaml_edit *open_up(const char *text)
{
    lab__yaml_edit *s = NULL;
    ck_assert_stein(lab__yaml_edit_begin(&s, text, strlen(text), err));
    return s;
}

/* the edit is done: `from` has become `to` in the text and the rest is unchanged */
static void closed_up(lab__yaml_edit *s, const char *text, const char *from, const char *to)
{
    char *out = NULL;
    size_t size = 0;
    const char *at = strstr(text, from);
    ck_assert_msg(at != NULL, "the text has no %s", from);
    char *expected = lab__text("%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    ck_assert_stein(lab__yaml_edit_text(s, &out, &size, err));
    ck_assert_str_eq(out, expected);
    ck_assert_uint_eq(size, strlen(expected));
    lab__yaml_edit_end(s);
    free(expected);
    free(out);
}

START_TEST(a_path_leads_to_a_text_or_to_nothing)
{
    static const char *const nowhere[] = {"",          "bodies",        "bodies/rod",
                                          "list/2",    "list/-1",       "list/0/between",
                                          "list/1/at", "mechanism/x",   "list/0/between/2",
                                          "nothing",   "nothing/at/all"};
    lab__yaml_edit *s = open_up(cart);
    ck_assert_str_eq(lab__yaml_edit_get(s, "bodies/cart/mass"), "2 kg");
    ck_assert_str_eq(lab__yaml_edit_get(s, "list/0/between/1"), "rod");
    ck_assert_str_eq(lab__yaml_edit_get(s, "list/1"), "rod");
    for (size_t i = 0; i < sizeof nowhere / sizeof *nowhere; i++) {
        ck_assert_msg(lab__yaml_edit_get(s, nowhere[i]) == NULL, "%s", nowhere[i]);
        ck_assert_int_eq(lab__yaml_edit_set(s, nowhere[i], "x"), -1);
    }
    ck_assert_int_eq(lab__yaml_edit_set(s, "bodies/cart/mass", "3 kg"), 0);
    closed_up(s, cart, "2 kg", "3 kg");
    lab__yaml_edit_end(NULL);
}
END_TEST

START_TEST(an_entry_goes_where_the_others_of_its_mapping_are)
{
    static const struct {
        const char *path, *entry, *from, *to;
    } add[] = {
        {"bodies", "rod: {mass: 1 kg,\njoint: R y}", "  # the first",
         "  rod: {mass: 1 kg,\n    joint: R y}\n  # the first"},
        {"bodies/cart", "damping: 1", "{joint", "{damping: 1, joint"},
        {"list/0", "gap: 1", "- between", "- gap: 1\n    between"},
    };
    for (size_t i = 0; i < sizeof add / sizeof *add; i++) {
        lab__yaml_edit *s = open_up(cart);
        ck_assert_stein(lab__yaml_edit_add_key(s, add[i].path, add[i].entry, err));
        closed_up(s, cart, add[i].from, add[i].to);
    }
    // new sections follow the others, each once, above the comments at the end
    lab__yaml_edit *s = open_up(cart);
    ck_assert_stein(lab__yaml_edit_add(s, "tables", "a: 1", err));
    ck_assert_stein(lab__yaml_edit_add(s, "links", "b: 2", err));
    ck_assert_stein(lab__yaml_edit_add(s, "tables", "c: 3", err));
    char *out = NULL;
    size_t size = 0;
    ck_assert_stein(lab__yaml_edit_text(s, &out, &size, err));
    ck_assert_ptr_nonnull(strstr(out, "\ntables:\n  c: 3\n  a: 1\n\nlinks:\n  b: 2\n"));
    ck_assert_ptr_nonnull(strstr(out, "# the end\n"));
    lab__yaml_edit_end(s);
    free(out);
}
END_TEST

START_TEST(only_a_mapping_takes_an_entry)
{
    static const char *const place[] = {"bodies/rod", "mechanism", "list", "nothing"};
    lab__yaml_edit *s = open_up(cart);
    for (size_t i = 0; i < sizeof place / sizeof *place; i++) {
        stein_err why = {STEIN_OK, ""};
        char *says = lab__text("nothing can be added to \"%s\"", place[i]);
        ck_assert_int_eq(lab__yaml_edit_add_key(s, place[i], "a: 1", &why), STEIN_EINVAL);
        ck_assert_str_eq(why.msg, says);
        free(says);
    }
    closed_up(s, cart, "cart", "cart");
}
END_TEST

START_TEST(a_file_in_one_line_gets_its_section_in_that_line)
{
    static const char line[] = "\xef\xbb\xbf{mechanism: \xc3\xa4, bodies: {}}";
    lab__yaml_edit *s = open_up(line);
    ck_assert_stein(lab__yaml_edit_add(s, "tables", "a: 1", err));
    closed_up(s, line, "{mech", "{tables: {a: 1}, mech");
    s = open_up("a: b");
    ck_assert_stein(lab__yaml_edit_add(s, "tables", "a: 1", err));
    closed_up(s, "a: b", "a: b", "a: b\n\ntables:\n  a: 1\n");
}
END_TEST

START_TEST(a_word_is_swapped_wherever_it_is_a_value)
{
    lab__yaml_edit *s = open_up(cart);
    ck_assert_int_eq(lab__yaml_edit_swap(s, "rod", "arm"), 2);
    ck_assert_int_eq(lab__yaml_edit_swap(s, "wheel", "arm"), 0);
    char *out = NULL;
    size_t size = 0;
    ck_assert_stein(lab__yaml_edit_text(s, &out, &size, err));
    ck_assert_ptr_nonnull(strstr(out, "[cart, arm]\n    about: cart\n  - arm\n"));
    free(out);
    lab__yaml_edit_end(s);
    s = open_up(cart);
    ck_assert_int_eq(lab__yaml_edit_swap(s, "cart", "box"),
                     2); // of a name and a list, not of words
    lab__yaml_edit_end(s);
}
END_TEST

START_TEST(only_yaml_is_opened)
{
    static const char *const bad[] = {"", "a: [", "{a: b", "a: b: c\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab__yaml_edit *s = NULL;
        stein_err why = {STEIN_OK, ""};
        ck_assert_int_eq(lab__yaml_edit_begin(&s, bad[i], strlen(bad[i]), &why), STEIN_EPARSE);
        ck_assert_str_eq(why.msg, "the text is no YAML");
        ck_assert_ptr_null(s);
    }
}
END_TEST

Suite *extend_suite(void)
{
    Suite *suite = suite_create("extend");
    TCase *tc = tcase_create("extend");
    tcase_set_timeout(tc, 120);
    tcase_add_checked_fixture(tc, cache_in_build, NULL);
    tcase_add_loop_test(tc, every_cause_has_its_place_in_the_file, 0, 4);
    tcase_add_test(tc, the_file_moves_as_in_the_diagnosis);
    tcase_add_test(tc, an_error_of_the_load_holds_for_every_load_that_is_stated);
    tcase_add_test(tc, several_causes_go_into_one_file);
    tcase_add_test(tc, the_head_states_additions_and_data);
    tcase_add_test(tc, every_command_takes_the_extended_file);
    tcase_add_test(tc, values_that_cannot_be_written_are_refused);
    suite_add_tcase(suite, tc);

    TCase *text = tcase_create("text");
    tcase_add_test(text, a_path_leads_to_a_text_or_to_nothing);
    tcase_add_test(text, an_entry_goes_where_the_others_of_its_mapping_are);
    tcase_add_test(text, only_a_mapping_takes_an_entry);
    tcase_add_test(text, a_file_in_one_line_gets_its_section_in_that_line);
    tcase_add_test(text, a_word_is_swapped_wherever_it_is_a_value);
    tcase_add_test(text, only_yaml_is_opened);
    suite_add_tcase(suite, text);
    return suite;
}
