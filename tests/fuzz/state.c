/* SPDX-License-Identifier: GPL-3.0-or-later
 * state.c - damaged state blocks. The input is laid over a saved one; first unchanged, then with a
 * correct checksum, so that the values are checked. Accepted states are simulated further.
 */
#include "core.h"
#include "fuzz.h"
#include "stein/models.h"

static uint64_t sum_of(const unsigned char *block, size_t size)
{
    uint64_t sum = 14695981039346656037u, part;
    for (size_t i = 0; i + sizeof part <= size; i += sizeof part) {
        memcpy(&part, block + i, sizeof part);
        sum = (sum ^ (i == offsetof(state_head, sum) ? 0 : part)) * 1099511628211u;
        sum ^= sum >> 29;
    }
    return sum;
}

/* a step from nowhere takes a thousand times what everything else takes */
static void go_on(stein_sim *sim, int seldom)
{
    if (seldom) {
        (void)stein_step(sim, NULL);
    }
    for (int i = 0; i < sim->model->nchannel; i++) {
        (void)stein_read(sim, i);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static stein_sim *sim;
    static unsigned char *saved, *block;
    if (sim == NULL) {
        must(stein_sim_create(&sim, &stein_model_stein1788, NULL, NULL) == STEIN_OK, "created");
        saved = malloc(stein_state_size(sim));
        block = malloc(stein_state_size(sim));
        must(saved != NULL && block != NULL, "there is memory");
        stein_save(sim, saved);
    }
    size_t whole = stein_state_size(sim);
    must(stein_restore_from(sim, data, size, NULL) == STEIN_EINVAL || size == whole, "too short");
    memcpy(block, saved, whole);
    // {place, length, bytes} again and again
    while (size > 3) {
        size_t at = ((size_t)data[0] << 8 | data[1]) % whole, n = data[2];
        data += 3;
        size -= 3;
        n = n < size ? n : size;
        n = n < whole - at ? n : whole - at;
        memcpy(block + at, data, n);
        data += n;
        size -= n;
    }
    // an input with the sum that its own changes need has forged a block, which is no damage;
    // libFuzzer finds such sums, since it traces comparisons
    unsigned char *const sum_at = block + offsetof(state_head, sum);
    int same = memcmp(block, saved, whole) == 0;
    int summed = memcmp(sum_at, saved + offsetof(state_head, sum), sizeof(uint64_t)) != 0;
    int taken = stein_restore_from(sim, block, whole, NULL) == STEIN_OK;
    must(taken || !same, "what was saved is taken");
    must(!taken || same || summed, "damage is noticed");
    uint64_t sum = sum_of(block, whole);
    memcpy(sum_at, &sum, sizeof sum);
    if (stein_restore_from(sim, block, whole, NULL) == STEIN_OK) {
        go_on(sim, sum % 64 == 0);
    }
    must(stein_restore(sim, saved, NULL) == STEIN_OK, "what was saved heals everything");
    return 0;
}
