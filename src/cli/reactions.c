/* SPDX-License-Identifier: GPL-3.0-or-later
 * reactions.c - outputs that the motion does not determine: reactions of redundant conditions,
 * friction that several contacts share, and the reactions between them.
 */
#include "cli.h"

static int is_undetermined(stein_sim *sim, int channel)
{
    return !stein_is_determined(sim, channel);
}

void cli_warn_reactions(stein_sim *sim)
{
    const stein_model *m = stein_sim_model(sim);
    int n = 0, frictions = 0;
    for (int i = 0; i < m->nchannel; i++) {
        if (is_undetermined(sim, i)) {
            fprintf(stderr, "%s\"%s\"", n == 0 ? "stein: not determined by the motion: " : ", ",
                    m->channels[i].name);
            frictions += m->channels[i].read == STEIN_READ_TANGENT;
            n++;
        }
    }
    if (n > frictions) {
        fprintf(stderr,
                "; more conditions, contacts or motions hold the same than are needed, and of many "
                "possible forces one set is shown. State fewer conditions (a slot or a rod "
                "instead of a hinge or weld), or make one elastic (a link)\n");
    } else if (n > 0) {
        fprintf(stderr, "; several contacts that stick hold the same, or one where a motion is "
                        "prescribed, and only the sum of what holds is known: friction is shown in "
                        "proportion to its limit\n");
    }
}

void cli_put_reactions(lab__json *out, stein_sim *sim)
{
    const stein_model *m = stein_sim_model(sim);
    lab__json_open(out, "undetermined", '[');
    for (int i = 0; i < m->nchannel; i++) {
        if (is_undetermined(sim, i)) {
            lab__json_text(out, NULL, m->channels[i].name);
        }
    }
    lab__json_close(out);
}
