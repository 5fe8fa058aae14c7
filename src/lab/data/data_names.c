/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_names.c - names that may be meant where a data file has one that is unknown.
 */
#include <stdio.h>
#include <string.h>

#include "data_internal.h"
#include "reader.h"

static char *suggestion(char *to, size_t room, const mech__nearest *near)
{
    snprintf(to, room, "%s%s%s", near->best != NULL ? ", did you mean \"" : "",
             near->best != NULL ? near->best : "", near->best != NULL ? "\"?" : "");
    return to;
}

const char *data__near_param(char *to, size_t room, const stein_model *m, const char *name)
{
    mech__nearest near = {name, NULL, 0};
    for (int i = 0; i < m->np; i++) {
        mech__offer(&near, m->params[i].name);
    }
    return suggestion(to, room, &near);
}

char *data__near_channel(char *to, size_t room, const stein_model *m, const char *name)
{
    mech__nearest near = {name, NULL, 0};
    for (int i = 1; i < m->nchannel; i++) { // 0 is the time
        mech__offer(&near, m->channels[i].name);
    }
    for (int i = 0; i < m->ninput; i++) {
        mech__offer(&near, m->inputs[i].name);
    }
    return suggestion(to, room, &near);
}

void data__near_unit(char *to, size_t room, const char *unit, const char *wanted)
{
    char text[DATA_SHOWN + 4], why[MECH__WHY] = "", meant[DATA_SHOWN] = "";
    const char *bad;
    mech__quantity q;
    int exp10;
    double factor;
    snprintf(text, sizeof text, "1 %s", unit);
    mech__quantity_at(text, &q, why, &bad);
    const char *hint = strstr(why, ", did you mean \"");
    int is_unit = hint != NULL && sscanf(hint, ", did you mean \"%63[^\"]", meant) == 1 &&
                  data__unit(meant, wanted, &exp10, &factor) == 0;
    snprintf(to, room, "%s", is_unit ? hint : "");
}

const char *data__list_outputs(char *to, size_t room, const stein_model *m)
{
    size_t n = 0;
    *to = '\0';
    for (int i = 1; i < m->nchannel && n < room; i++) {
        if (n + MECH_PATH + MECH_UNIT + 8 > room) {
            snprintf(to + n, room - n, ", ...");
            break;
        }
        int bare = strcmp(m->channels[i].unit, "1") == 0;
        n +=
            (size_t)snprintf(to + n, room - n, "%s%s%s%s%s", i > 1 ? ", " : "", m->channels[i].name,
                             bare ? "" : " [", bare ? "" : m->channels[i].unit, bare ? "" : "]");
    }
    return to;
}
