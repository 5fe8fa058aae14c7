/* SPDX-License-Identifier: MIT
 * slave_state.c - an instance's state as a block of bytes.
 *
 *      format | size | checksum | token | mode and times | parameters | inputs | simulation's state
 *
 * A saved state and its serialised form are the same bytes, so the same rules hold for both: it
 * continues in any instance of the same FMU, bit for bit. Bytes may come from a file or another
 * process, so all of them are checked before anything changes; the simulation's part is checked by
 * the core (state.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "slave.h"

static const char format[8] = {'s', 't', 'e', 'i', 'n', 'f', 'm', '1'};

typedef struct block_head {
    char format[8];
    uint64_t size, sum; /* of the whole block; the sum with 0 in its place */
    char token[40];
    int phase, changed, unsettled, load;
    double dt, start, stop, reached;
} block_head;

/* an input in a block: u, since, follow */
enum { INPUT_NUMBERS = 5 };

static size_t numbers_of(const slave *s)
{
    return (size_t)s->model.np + INPUT_NUMBERS * (size_t)s->model.ninput;
}

static size_t size_of(const slave *s)
{
    return sizeof(block_head) + sizeof(double) * numbers_of(s) + s->sim->state_size;
}

static uint64_t sum_of(const unsigned char *bytes, size_t n)
{
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < n; i++) {
        int skip = i >= offsetof(block_head, sum) && i < offsetof(block_head, sum) + sizeof sum;
        sum = (sum ^ (skip ? 0u : bytes[i])) * 1099511628211u;
    }
    return sum;
}

static void write_block(const slave *s, unsigned char *block)
{
    block_head head;
    memset(&head, 0, sizeof head);
    memcpy(head.format, format, sizeof format);
    head.size = size_of(s);
    memcpy(head.token, slave_the_model.token, strlen(slave_the_model.token));
    head.phase = (int)s->phase;
    head.changed = s->changed;
    head.unsettled = s->unsettled;
    head.load = s->load;
    head.dt = s->dt;
    head.start = s->start;
    head.stop = s->stop;
    head.reached = s->reached;
    unsigned char *at = block + sizeof head;
    memcpy(at, s->p, sizeof *s->p * (size_t)s->model.np);
    at += sizeof *s->p * (size_t)s->model.np;
    for (int i = 0; i < s->model.ninput; i++) {
        const slave_input *in = &s->input[i];
        double u[INPUT_NUMBERS] = {in->u[0], in->u[1], in->u[2], in->since, in->follow};
        memcpy(at, u, sizeof u);
        at += sizeof u;
    }
    stein_save(s->sim, at);
    memcpy(block, &head, sizeof head);
    head.sum = sum_of(block, size_of(s));
    memcpy(block, &head, sizeof head);
}

/* there is no instance, or an argument is missing */
static slave_status refuse_call(slave *s, const char *function, const char *why)
{
    return s == NULL ? SLAVE_ERROR
                     : slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL, "%s: %s", function, why));
}

/* the importer's block, or a new one; NULL without memory, which is logged */
static void *room_for(slave *s, void *block)
{
    void *to = block != NULL ? block : malloc(size_of(s));
    if (to == NULL) {
        slave_refuse(s, stein__fail(&s->err, STEIN_ENOMEM, "out of memory for a state"));
    }
    return to;
}

slave_status slave_keep(slave *s, const char *function, void **block)
{
    if (s == NULL || block == NULL) {
        return refuse_call(s, function, "no place for the state");
    }
    void *to = room_for(s, *block);
    if (to == NULL) {
        return SLAVE_ERROR;
    }
    write_block(s, to);
    *block = to;
    return SLAVE_OK;
}

slave_status slave_free(const slave *s, void **block)
{
    if (s == NULL) {
        return SLAVE_ERROR;
    }
    if (block != NULL) {
        free(*block);
        *block = NULL;
    }
    return SLAVE_OK;
}

static double number_at(const unsigned char *bytes, size_t i)
{
    double value;
    memcpy(&value, bytes + sizeof value * i, sizeof value);
    return value;
}

static int are_numbers(const slave *s, const unsigned char *bytes)
{
    size_t np = (size_t)s->model.np;
    for (size_t i = 0; i < numbers_of(s); i++) {
        double value = number_at(bytes, i);
        int is_since = i >= np && (i - np) % INPUT_NUMBERS == 3; // no number: never set
        if (isinf(value) || (isnan(value) && !is_since)) {
            return 0;
        }
    }
    return 1;
}

/* one that an instance of this kind may be in */
static int is_one_phase(const slave *s, int phase)
{
    int of_others = s->exchange ? SLAVE_STEPPING | SLAVE_FAILED : SLAVE_EVENTS | SLAVE_CONTINUOUS;
    return phase > 0 && phase <= SLAVE_ANY && (phase & (phase - 1)) == 0 && !(phase & of_others);
}

/* @return NULL, or the error in n bytes */
static const char *fault_of(const slave *s, const unsigned char *bytes, size_t n)
{
    block_head head;
    if (n != size_of(s)) {
        return "it has another size";
    }
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.format, format, sizeof format) != 0 || head.size != n) {
        return "it is none of this version";
    }
    if (strncmp(head.token, slave_the_model.token, sizeof head.token) != 0) {
        return "it belongs to another FMU";
    }
    if (head.sum == sum_of(bytes, n) && !is_one_phase(s, head.phase)) {
        return "it is of an instance for another use, or damaged";
    }
    if (head.sum != sum_of(bytes, n) ||
        (head.load != 0 && (head.load != 1 || s->model.load.body < 0)) ||
        !are_numbers(s, bytes + sizeof head) || !(head.dt > 0.0) || !isfinite(head.dt) ||
        !isfinite(head.start) || !isfinite(head.reached) || isnan(head.stop)) {
        return "it is damaged";
    }
    return NULL;
}

static slave_status refuse_block(slave *s, const char *fault)
{
    return slave_refuse(
        s, stein__fail(&s->err, STEIN_EINVAL, "the state cannot be restored: %s", fault));
}

/* contents after the head: parameters, inputs; the simulation has its part already */
static void take_numbers(slave *s, const unsigned char *at)
{
    size_t np = (size_t)s->model.np;
    memcpy(s->p, at, sizeof *s->p * np);
    for (int i = 0; i < s->model.ninput; i++) {
        size_t first = np + INPUT_NUMBERS * (size_t)i;
        slave_input *in = &s->input[i];
        for (size_t k = 0; k < 3; k++) {
            in->u[k] = number_at(at, first + k);
        }
        in->since = number_at(at, first + 3);
        in->follow = number_at(at, first + 4) != 0.0;
        slave_bind(s, i);
    }
    (void)stein_try_all(s->sim, s->p, NULL); // finite, unchanged
}

slave_status slave_take(slave *s, const char *function, const void *block)
{
    if (s == NULL || block == NULL) {
        return refuse_call(s, function, "there is no state");
    }
    const unsigned char *numbers = (const unsigned char *)block + sizeof(block_head);
    const char *fault = fault_of(s, block, size_of(s));
    if (fault != NULL) {
        return refuse_block(s, fault);
    }
    stein_status status = stein_restore(s->sim, numbers + sizeof(double) * numbers_of(s), &s->err);
    if (status != STEIN_OK) {
        return slave_refuse(s, status);
    }
    take_numbers(s, numbers);
    block_head head;
    memcpy(&head, block, sizeof head);
    s->phase = (slave_phase)head.phase;
    s->changed = head.changed;
    s->unsettled = head.unsettled;
    s->load = head.load;
    s->dt = s->sim->def.dt = head.dt;
    s->start = head.start;
    s->stop = head.stop;
    s->reached = head.reached;
    return SLAVE_OK;
}

slave_status slave_size(slave *s, const char *function, const void *block, size_t *size)
{
    if (s == NULL || block == NULL || size == NULL) {
        return refuse_call(s, function, "there is no state, or no place for its size");
    }
    *size = size_of(s);
    return SLAVE_OK;
}

slave_status slave_pack(slave *s, const char *function, const void *block, void *bytes, size_t n)
{
    if (s == NULL || block == NULL || bytes == NULL) {
        return refuse_call(s, function, "there is no state or no room");
    }
    if (n < size_of(s)) {
        return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                           "a state has %d bytes, there is room for %d",
                                           (int)size_of(s), (int)n));
    }
    memcpy(bytes, block, size_of(s));
    return SLAVE_OK;
}

slave_status slave_unpack(slave *s, const char *function, const void *bytes, size_t n, void **block)
{
    if (s == NULL || block == NULL || bytes == NULL) {
        return refuse_call(s, function, "there are no bytes or no room");
    }
    const char *fault = fault_of(s, bytes, n);
    if (fault != NULL) {
        return refuse_block(s, fault);
    }
    void *to = room_for(s, *block);
    if (to == NULL) {
        return SLAVE_ERROR;
    }
    memcpy(to, bytes, n);
    *block = to;
    return SLAVE_OK;
}
