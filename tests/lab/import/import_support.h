/* SPDX-License-Identifier: GPL-3.0-or-later
 * import_support.h - shared by the tests of importers.
 */
#ifndef IMPORT_SUPPORT_H
#define IMPORT_SUPPORT_H

#include "lab_support.h"
#include "stein/import.h"

static char *said; /* notes of the last import, a line each */

static inline void on_note(void *ctx, const char *message)
{
    (void)ctx;
    char *longer = lab__text("%s%s\n", said != NULL ? said : "", message);
    free(said);
    said = longer;
}

static lab_imported import_as(const char *file, const char *to, lab_inertia inertia)
{
    lab_imported done;
    free(said);
    said = NULL;
    ck_assert_stein(lab_import(file, to, inertia, on_note, NULL, &done, err));
    return done;
}

static inline lab_imported import(const char *file, const char *to)
{
    return import_as(file, to, LAB_INERTIA_REFUSE);
}

/* the text with the first `from` replaced; into a file */
static inline const char *changed(const char *text, const char *from, const char *to)
{
    const char *at = strstr(text, from);
    ck_assert_msg(at != NULL, "no \"%s\"", from);
    const char *path = in_folder("changed.mbs");
    FILE *f = fopen(path, "wb");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    ck_assert_int_eq(fclose(f), 0);
    return path;
}

#endif
