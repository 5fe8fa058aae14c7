/* SPDX-License-Identifier: GPL-3.0-or-later
 * lab_support.h - what the tests of the laboratory share: a folder of their own, a small stroke.
 */
#ifndef LAB_SUPPORT_H
#define LAB_SUPPORT_H

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "plot.h"
#include "sweep.h"
#include "stein/diagnose.h"
#include "support.h"

static char folder[] = "/tmp/stein-lab-XXXXXX";

static inline void make_folder(void)
{
    strcpy(folder, "/tmp/stein-lab-XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(folder));
}

static inline void remove_tree(const char *path)
{
    DIR *d = opendir(path);
    for (struct dirent *e = d != NULL ? readdir(d) : NULL; e != NULL; e = readdir(d)) {
        char *name = lab__text("%s/%s", path, e->d_name);
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0 && unlink(name) != 0) {
            remove_tree(name);
        }
        free(name);
    }
    if (d != NULL) {
        closedir(d);
        rmdir(path);
    }
}

static inline void remove_folder(void)
{
    remove_tree(folder);
}

/* equations that tests need are compiled once for all of them: beside the products */
static inline const char *build_cache(void)
{
    static char path[500];
    const char *build = getenv("STEIN_BUILD");
    char here[300] = "";
    build = build != NULL ? build : "build";
    ck_assert_ptr_nonnull(getcwd(here, sizeof here));
    snprintf(path, sizeof path, "%s%s%.150s/cache", *build == '/' ? "" : here,
             *build == '/' ? "" : "/", build);
    return path;
}

static inline void cache_in_build(void)
{
    ck_assert_int_eq(setenv("XDG_CACHE_HOME", build_cache(), 1), 0);
}

/* a path in the folder of the test; a few live at a time */
static inline const char *in_folder(const char *name)
{
    static char path[4][200];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static inline const char *write_file(const char *name, const char *text)
{
    const char *path = in_folder(name);
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

/* a program of the folder, a script */
static inline const char *write_program(const char *name, const char *text)
{
    const char *path = write_file(name, text);
    ck_assert_int_eq(chmod(path, 0755), 0);
    return path;
}

/* every one of the words is in the text */
static inline void text_has(const char *text, const char *const *word, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        ck_assert_msg(strstr(text, word[i]) != NULL, "no \"%s\" in\n%s", word[i], text);
    }
}

/* path of the one file in the cache that ends so; NULL when there is none */
static inline char *cached(const char *ending, int *count)
{
    char *root = lab__text("%s/%s-abi%d", folder, STEIN_VERSION, STEIN_MODEL_ABI), *found = NULL;
    DIR *d = opendir(root);
    *count = 0;
    for (struct dirent *e = d != NULL ? readdir(d) : NULL; e != NULL; e = readdir(d)) {
        size_t n = strlen(e->d_name), k = strlen(ending);
        if (n > k && strcmp(e->d_name + n - k, ending) == 0) {
            free(found);
            found = lab__text("%s/%s", root, e->d_name);
            ++*count;
        }
    }
    if (d != NULL) {
        closedir(d);
    }
    free(root);
    return found;
}

/* a weight that falls 37 mm onto a stiff line: a stroke without a notch, in closed form */
static const char falling[] = "mechanism: falling\n"
                              "bodies:\n"
                              "  hammer: {joint: T z, mass: 3.1 g, initial: {position: 37 mm}, "
                              "points: {head: [0, 0, 0]}}\n"
                              "contacts:\n"
                              "  string:\n"
                              "    between:\n"
                              "      - {point: hammer.head}\n"
                              "      - {line: {on: frame, at: [0, 0, 0], facing: 90 deg}}\n"
                              "    normal: {c: 11.7 kN/m}\n"
                              "inputs:\n"
                              "  lift: {motion: hammer, idle: free}\n"
                              "  push: {torque: hammer}\n"
                              "outputs:\n"
                              "  gap: {contact: string, read: gap}\n"
                              "  force: {contact: string, read: force}\n"
                              "  height: {joint: hammer, read: position}\n"
                              "stroke: {string: string}\n"
                              "simulation: {dt: 10 us, until: 0.12 s}\n";

/* test_lab.c, which tests the cache, has its own */
#ifdef CACHE_OF_ITS_OWN
static const char *const cache_kept = folder;
#else
static const char *const cache_kept = NULL;
#endif

static inline lab_options cache_here(const char *cc)
{
    lab_options options = lab_options_default();
    options.cache = cache_kept != NULL || cc != NULL ? folder : build_cache();
    options.cc = cc;
    return options;
}

static inline lab_model *open_text(const char *text, const char *const *set, int nset)
{
    lab_options options = cache_here(NULL);
    lab_model *model = NULL;
    options.set = set;
    options.nset = nset;
    ck_assert_stein(lab_open(&model, write_file("model.yaml", text), &options, err));
    return model;
}

/** The candidate of that kind and place, or the test fails. */
static inline lab_candidate candidate(const lab_model *model, const char *kind, const char *place)
{
    lab_candidate *list = NULL, found = {.effect = NULL};
    int n = 0;
    ck_assert_stein(lab_candidates(&list, &n, model, err));
    for (int i = 0; i < n; i++) {
        if (strcmp(list[i].effect->kind, kind) == 0 && strcmp(list[i].place, place) == 0) {
            found = list[i];
        }
    }
    free(list);
    ck_assert_msg(found.effect != NULL, "there is no %s at %s", kind, place);
    return found;
}

#endif
