/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_page_text.c - a page as text, with a script instead of a compiler: its description of a
 * mechanism, the compilation of its module, and the messages of a failure. test_page.sh tests it in
 * a browser.
 */
#include "lab_support.h"

/* a clang that writes a module of a few bytes and a line of a log, behind what `first` does */
static void put_clang(const char *first)
{
    char *text = lab__text("#!/bin/sh\necho \"$*\" >>%s/log\n%s\n"
                           "while [ \"$1\" != -o ]; do shift; done\nprintf '\\000asm7' >\"$2\"\n",
                           folder, first);
    write_program("clang", text);
    free(text);
}

static void set_up(void)
{
    static const char *const part[] = {"include", "include/wasm32-wasi"};
    make_folder();
    setenv("WASM_CC", in_folder("clang"), 1);
    setenv("WASI_SYSROOT", folder, 1);
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        ck_assert_int_eq(mkdir(in_folder(part[i]), 0700), 0);
    }
    write_file("include/wasm32-wasi/stdlib.h", "");
    write_program("wasm-ld", "#!/bin/sh\n");
    char *path = lab__text("%s:/usr/bin:/bin", folder);
    setenv("PATH", path, 1);
    free(path);
    put_clang("");
}

static lab_options cache_in_folder(void)
{
    lab_options o = lab_options_default();
    o.cache = folder;
    return o;
}

/* the page of a mechanism file, to be freed */
static char *page_of(const char *file, lab_page_facts *facts)
{
    lab_options o = cache_in_folder();
    lab_model *model = NULL;
    char *text = NULL;
    size_t size;
    ck_assert_stein(lab_open(&model, file, NULL, err));
    ck_assert_stein(lab_page(in_folder("page.html"), model, &o, facts, err));
    ck_assert_stein(lab__read_file(in_folder("page.html"), &text, &size, err));
    ck_assert(facts == NULL || facts->page == size);
    lab_close(model);
    return text;
}

static void page_has(const char *file, const char *const *has, int n)
{
    char *text = page_of(file, NULL);
    for (int i = 0; i < n; i++) {
        ck_assert_msg(strstr(text, has[i]) != NULL, "%s: no %s", file, has[i]);
    }
    free(text);
}

/* commands that were given to the compiler since the last time */
static int commands(void)
{
    char *text = NULL;
    size_t size;
    int n = 0;
    if (lab__read_file(in_folder("log"), &text, &size, NULL) != STEIN_OK) {
        return 0;
    }
    for (size_t i = 0; i < size; i++) {
        n += text[i] == '\n';
    }
    free(text);
    unlink(in_folder("log"));
    return n;
}

START_TEST(a_page_contains_all_of_its_mechanism)
{
    static const char *const action[] = {"\"name\": \"hammer\"",
                                         "\"type\": \"R\"",
                                         "\"load\": true",
                                         "\"links\": []",
                                         "\"facing\": [",
                                         "\"radius\": ",
                                         "\"kind\": \"motion\"",
                                         "\"kind\": \"point\"",
                                         "\"direction\": [",
                                         "\"read\": \"gap\"",
                                         "\"read\": \"notch_phase\"",
                                         "\"catcher\": ",
                                         "\"dials\": [{\"param\": ",
                                         "\"label\": ",
                                         "\"rest\": true",
                                         "\"section\": \"bodies\""};
    static const char *const block[] = {"3.141592653589793,\"-\"],\"extent\": [[\"p",
                                        "\"end\": -1},", "\"end\": 1},"};
    static const char *const pendulum[] = {
        "\"kind\": \"joint\"", "\"notches\": []", "\"contacts\": []", "\"name\": \"rod.mass\"",
        "\"from\": 0.1065,\"to\": 0.3195"}; // half and one and a half of it
    page_has("models/stein1788.yaml", action, sizeof action / sizeof *action);
    page_has("models/block_on_slope.yaml", block, sizeof block / sizeof *block);
    page_has("models/pendulum.yaml", pendulum, sizeof pendulum / sizeof *pendulum);
}
END_TEST

START_TEST(a_module_is_compiled_once_and_the_core_for_all)
{
    lab_page_facts facts;
    char *text = page_of("models/pendulum.yaml", &facts);
    ck_assert_uint_eq(facts.module, 5);
    ck_assert_ptr_nonnull(strstr(text, "AGFzbTc=")); // its bytes to the base 64
    ck_assert_ptr_nonnull(strstr(text, facts.hash));
    free(text);
    int core = commands() - 1;
    ck_assert_int_gt(core, 5);
    put_clang("exit 1");
    free(page_of("models/pendulum.yaml", NULL));
    ck_assert_int_eq(commands(), 0);
    put_clang("");
    free(page_of("models/double_pendulum.yaml", NULL));
    ck_assert_int_eq(commands(), 1);
}
END_TEST

/* a compiler of the same name that cannot link what the one before it made */
START_TEST(objects_of_another_compiler_are_compiled_again)
{
    free(page_of("models/pendulum.yaml", NULL));
    int all = commands();
    char *once =
        lab__text("case \"$*\" in *-nostartfiles*) "
                  "[ -e %s/tried ] || { touch %s/tried; echo old objects; exit 1; };; esac",
                  folder, folder);
    put_clang(once);
    free(once);
    free(page_of("models/double_pendulum.yaml", NULL));
    ck_assert_int_eq(commands(), 1 + all); // linked in vain, then all of it
}
END_TEST

START_TEST(a_module_that_is_none_is_compiled_again)
{
    char *find = lab__text("for f in %s/*/page-*/*.wasm; do printf 'no' >\"$f\"; done", folder);
    free(page_of("models/pendulum.yaml", NULL));
    commands();
    ck_assert_int_eq(system(find), 0);
    free(find);
    free(page_of("models/pendulum.yaml", NULL));
    ck_assert_int_eq(commands(), 1);
}
END_TEST

static void refuse_page(stein_status status, const char *says)
{
    lab_options o = cache_in_folder();
    lab_model *model = NULL;
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(lab_open(&model, "models/pendulum.yaml", NULL, err));
    ck_assert_int_eq(lab_page(in_folder("no.html"), model, &o, NULL, &why), status);
    ck_assert_msg(strstr(why.msg, says) != NULL, "%s, expected %s", why.msg, says);
    ck_assert_int_ne(access(in_folder("no.html"), F_OK), 0);
    lab_close(model);
}

START_TEST(missing_tools_of_a_page_are_named)
{
    put_clang("echo bad code; exit 4");
    refuse_page(STEIN_ECOMPILE, "failed to compile the page's module (exit code 4): bad code");
    put_clang("exit 127");
    refuse_page(STEIN_ECOMPILE, "lacks: clang; run apt-get install clang lld wasi-libc");
    put_clang("echo 'clang: invalid linker name wasm-ld-14: it does not exist'; exit 1");
    refuse_page(STEIN_ECOMPILE, "lacks: lld; run");
    put_clang("exit 1");
    unlink(in_folder("include/wasm32-wasi/stdlib.h"));
    refuse_page(STEIN_ECOMPILE, "lacks: wasi-libc; run");
    setenv("PATH", in_folder("none"), 1); // and no linker, nor what a script needs
    refuse_page(STEIN_ECOMPILE, " lld wasi-libc; run");
}
END_TEST

START_TEST(a_page_that_cannot_be_written_is_reported)
{
    lab_options o = cache_in_folder();
    lab_model *model = NULL;
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(lab_open(&model, "models/pendulum.yaml", NULL, err));
    ck_assert_int_eq(lab_page(in_folder("none/p.html"), model, &o, NULL, &why), STEIN_EIO);
    ck_assert_ptr_nonnull(strstr(why.msg, "none/p.html cannot be written"));
    o.cache = in_folder("clang"); // no folder
    ck_assert_int_eq(lab_page(in_folder("p.html"), model, &o, NULL, &why), STEIN_EIO);
    lab_close(model);
}
END_TEST

Suite *page_text_suite(void)
{
    Suite *s = suite_create("page_text");
    TCase *tc = tcase_create("page_text");
    tcase_add_checked_fixture(tc, set_up, remove_folder);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_page_contains_all_of_its_mechanism);
    tcase_add_test(tc, a_module_is_compiled_once_and_the_core_for_all);
    tcase_add_test(tc, objects_of_another_compiler_are_compiled_again);
    tcase_add_test(tc, a_module_that_is_none_is_compiled_again);
    tcase_add_test(tc, missing_tools_of_a_page_are_named);
    tcase_add_test(tc, a_page_that_cannot_be_written_is_reported);
    suite_add_tcase(s, tc);
    return s;
}
