/* SPDX-License-Identifier: GPL-3.0-or-later
 * refused.h - a mechanism file that is refused, for the tests of mistakes in files.
 */
#ifndef REFUSED_H
#define REFUSED_H

#include <string.h>

#include "mechanism.h"
#include "support.h"

/* the text is refused with a message that contains these words */
static inline void ck_assert_refused(const char *text, const char *words)
{
    mechanism *m = NULL;
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_eq(
        mech_read_text(&m, "wrong.yaml", text, strlen(text), NULL, 0, NULL, NULL, &why),
        STEIN_EPARSE);
    ck_assert_msg(strstr(why.msg, words) != NULL, "%s: %s", words, why.msg);
}

#endif
