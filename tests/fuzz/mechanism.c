/* SPDX-License-Identifier: GPL-3.0-or-later
 * mechanism.c - any bytes as a mechanism file; an accepted file has to give equations, or an error.
 */
#include "fuzz.h"
#include "gen.h"
#include "mechanism.h"

static void hear(void *ctx, const char *message)
{
    int *problems = ctx;
    must(message[0] != '\0' && strchr(message, '\n') == NULL, "a problem is one line");
    *problems += strstr(message, ": warning: ") == NULL;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};
    int problems = 0;
    stein_status status =
        mech_read_text(&m, "fuzz.yaml", (const char *)data, size, NULL, 0, hear, &problems, &err);
    if (status != STEIN_OK) {
        must(m == NULL && err.msg[0] != '\0', "a refusal says why");
        must(status == STEIN_EPARSE && problems > 0 && problems <= 51, "problems are told");
        return 0;
    }
    must(problems == 0, "what is accepted has no problems");
    gen_result r; // of some: it takes longer than everything else
    if (size % 8 == 0 && m->nbody <= 3 && gen_equations(&r, m, &err) == STEIN_OK) {
        must(strlen(r.source) == r.size, "the source is one text");
        gen_free(&r);
    }
    mech_free(m);
    return 0;
}
