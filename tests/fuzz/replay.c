/* SPDX-License-Identifier: GPL-3.0-or-later
 * replay.c - feeds files to a fuzz target that is built without libFuzzer: each unchanged, cut at a
 * few places, and with some of its bits changed.
 */
#include "fuzz.h"

enum { LARGEST = 1 << 21, CHANGES = 40 };

static unsigned long long seed = 1788;

static size_t draw(size_t n)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return n > 0 ? (size_t)(seed >> 33) % n : 0;
}

/* in memory of its exact size, so that a sanitizer detects reads beyond it */
static void feed(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size > 0 ? size : 1);
    must(copy != NULL, "there is memory");
    memcpy(copy, data, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

int main(int argc, char **argv)
{
    uint8_t *data = malloc(LARGEST);
    long inputs = 0;
    for (int i = 1; data != NULL && i < argc; i++) {
        FILE *f = fopen(argv[i], "rb");
        if (f == NULL) {
            perror(argv[i]);
            return EXIT_FAILURE;
        }
        size_t size = fread(data, 1, LARGEST, f);
        fclose(f);
        feed(data, size);
        for (int k = 0; k < CHANGES && size > 0; k++) {
            size_t at = draw(size);
            uint8_t was = data[at];
            data[at] ^= (uint8_t)(1u << draw(8));
            feed(data, size);
            data[at] = was;
            feed(data, draw(size));
        }
        inputs += size > 0 ? 1 + 2 * CHANGES : 1;
    }
    free(data);
    printf("%ld inputs\n", inputs);
    return inputs > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
