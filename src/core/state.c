/* SPDX-License-Identifier: MIT
 * state.c - the state as a flat block that may be kept, sent and read back.
 *
 *      format | equations | size | checksum | time, grid, load | q, qd | rest | modes
 *
 * A block may come from a file or another process, so all of it is checked: format, equations,
 * size and checksum, numbers that are finite, modes that exist.
 * The checksum finds damage; it is no defence against who
 * wants to forge a block, which is why the values are looked at as well.
 */
#include <math.h>
#include <string.h>

#include "core.h"

static const char format[8] = {'s', 't', 'e', 'i', 'n', 's', 't', '1'};

void stein__state_clear(stein_sim *sim)
{
    memset(sim->state, 0, sim->state_size);
    memcpy(sim->head->format, format, sizeof format);
    memcpy(sim->head->equations, sim->model->equations, sizeof sim->head->equations);
    sim->head->size = sim->state_size;
}

size_t stein_state_size(const stein_sim *sim)
{
    return sim->state_size;
}

/* FNV-1a over words; a block is a multiple of 16 bytes. The place of the sum counts as 0. */
static uint64_t sum_of(const void *block, size_t size)
{
    uint64_t sum = 14695981039346656037u, part;
    const unsigned char *at = block;
    for (size_t i = 0; i + sizeof part <= size; i += sizeof part) {
        memcpy(&part, at + i, sizeof part);
        part = i == offsetof(state_head, sum) ? 0 : part;
        sum = (sum ^ part) * 1099511628211u;
        sum ^= sum >> 29; // the product carries upwards only
    }
    return sum;
}

void stein_save(const stein_sim *sim, void *block)
{
    uint64_t sum = sum_of(sim->state, sim->state_size);
    memcpy(block, sim->state, sim->state_size);
    memcpy((unsigned char *)block + offsetof(state_head, sum), &sum, sizeof sum);
}

/* where a part of the state is in a block like it */
static const unsigned char *within(const stein_sim *sim, const void *block, const void *part)
{
    return (const unsigned char *)block + ((const unsigned char *)part - sim->state);
}

static int all_finite(const unsigned char *x, int n)
{
    for (int i = 0; i < n; i++) {
        double value;
        memcpy(&value, x + sizeof value * (size_t)i, sizeof value);
        if (!isfinite(value)) {
            return 0;
        }
    }
    return 1;
}

static int none_above(const unsigned char *x, int n, int most)
{
    for (int i = 0; i < n; i++) {
        if (x[i] > most) {
            return 0;
        }
    }
    return 1;
}

/* are the values in a block those of a motion? */
static int is_state(const stein_sim *sim, const void *block)
{
    const stein_model *model = sim->model;
    state_head head;
    memcpy(&head, block, sizeof head);
    return isfinite(head.t) && isfinite(head.t0) && head.step >= 0 && head.implicit <= 1 &&
           (head.load_present == 0 || head.load_present == 1) &&
           all_finite(within(sim, block, sim->q), model->nq) &&
           all_finite(within(sim, block, sim->qd), model->nq) &&
           all_finite(within(sim, block, sim->rest), 2 * model->nchannel) &&
           none_above(within(sim, block, sim->mode), sim->nguard, 1) &&
           none_above(within(sim, block, sim->phase), model->nnotch, 4) &&
           none_above(within(sim, block, sim->engaged), model->nnotch, 1) &&
           none_above(within(sim, block, sim->held), model->nq, 1) &&
           none_above(within(sim, block, sim->stick), model->nstick, SHARES) &&
           all_finite(within(sim, block, sim->anchor), model->nstick);
}

/* the head, of which `size` bytes are there */
static stein_status check_head(const stein_sim *sim, const void *block, size_t size, stein_err *err)
{
    state_head head;
    const char *name = sim->model->name;
    if (size < sizeof head) {
        return stein__fail(err, STEIN_EINVAL, "the saved state is cut off: %d bytes, expected %d",
                           (int)size, (int)sim->state_size);
    }
    memcpy(&head, block, sizeof head);
    if (memcmp(head.format, format, sizeof format) != 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "the block is no saved state of this version (format steinst1)");
    }
    if (memcmp(head.equations, sim->head->equations, sizeof head.equations) != 0) {
        return stein__fail(err, STEIN_EINVAL,
                           "the saved state belongs to another model than \"%s\"", name);
    }
    if (head.size != sim->state_size || size != sim->state_size) {
        return stein__fail(err, STEIN_EINVAL, "the saved state of \"%s\" has %d bytes, expected %d",
                           name, (int)size, (int)sim->state_size);
    }
    return STEIN_OK;
}

stein_status stein_restore_from(stein_sim *sim, const void *block, size_t size, stein_err *err)
{
    stein_status status = check_head(sim, block, size, err);
    if (status != STEIN_OK) {
        return status;
    }
    uint64_t sum, was = sum_of(block, size);
    memcpy(&sum, (const unsigned char *)block + offsetof(state_head, sum), sizeof sum);
    if (sum != was || !is_state(sim, block)) {
        return stein__fail(err, STEIN_EINVAL, "the saved state of \"%s\" is damaged",
                           sim->model->name);
    }
    memcpy(sim->state, block, size);
    sim->fresh = STALE;
    return STEIN_OK;
}

stein_status stein_restore(stein_sim *sim, const void *block, stein_err *err)
{
    return stein_restore_from(sim, block, sim->state_size, err);
}
