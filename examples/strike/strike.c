/* SPDX-License-Identifier: MIT
 * strike.c - one stroke, and where the hammer is after 50 ms.
 */
#include <stdio.h>
#include <stein/stein.h>

int main(void)
{
    stein_sim *sim;
    stein_err err;
    double distance;
    if (stein_sim_create(&sim, &stein_model_stein1788, NULL, &err) != STEIN_OK ||
        stein_set(sim, "pawl.stop_shift", -0.3e-3, &err) != STEIN_OK ||
        stein_reset(sim, &err) != STEIN_OK || stein_run(sim, 0.050, &err) != STEIN_OK ||
        stein_read_name(sim, "string_distance", &distance, &err) != STEIN_OK) {
        return fprintf(stderr, "%s\n", err.msg), 1;
    }
    printf("head to string after 50 ms: %.3f mm\n", 1e3 * distance);
    stein_sim_destroy(sim);
    return 0;
}
