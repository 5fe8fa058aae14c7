/* SPDX-License-Identifier: MIT
 * audio.c - five octaves of actions in an audio callback: blocks of 64 samples at 48 kHz.
 *
 *   audio [--sandbox] out.wav
 *
 * A step is four samples: escapement 0.03 mm and peak force 2 % off the values of short steps, and
 * there is time for all 61 keys to move at once. Keys at rest cost nothing.
 *
 * A step that fails (ECHATTER, ENONFINITE) is counted, and its action begins again at rest.
 *
 * The callback steps every action that is awake, hands the force of each head to its string, and
 * adds up the strings. It allocates nothing, waits for nothing and makes no system call: with
 * --sandbox the process is killed for one. A host (JACK, LV2, a plugin) would call it; here a
 * driver plays a piece and prints the load, processor time of a block over its duration of 1.33 ms.
 */
#define _DEFAULT_SOURCE
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <linux/seccomp.h>
#include <stein/stein.h>

enum { RATE = 48000, BLOCK = 64, KEYS = 61, STEP = 4, LINE = 800, REST = RATE / 20 };

/* ---- one note: an action and its string ---- */

typedef struct note {
    stein_sim *sim;
    int force;         /* channel of the head's force on the string */
    double finger;     /* [N] on the key's front */
    int resting;       /* samples for which nothing has moved; REST: asleep */
    int steps, failed; /* that were made; of those, that ended with an error */
    double line[LINE]; /* of the string, a wave that goes round */
    int length, at;    /* of the wave; where it is read */
    double before;     /* sample that was read last */
} note;

static void press(void *ctx, double t, double u[3])
{
    (void)t;
    u[0] = ((const note *)ctx)->finger;
}

static int moves(const note *n)
{
    const double *qd = stein_qd(n->sim);
    return n->finger > 0.0 || fabs(qd[0]) + fabs(qd[1]) + fabs(qd[2]) > 2e-3;
}

/* force of the head [N] after STEP samples; a key that rests costs nothing */
static double step(note *n)
{
    if (n->resting >= REST && n->finger == 0.0) {
        return 0.0;
    }
    n->resting = moves(n) ? 0 : n->resting + STEP;
    n->steps++;
    if (stein_step(n->sim, NULL) != STEIN_OK) { // silent and at rest, not stuck where it failed
        n->failed++;
        if (stein_reset(n->sim, NULL) == STEIN_OK) {
            stein_load_lift(n->sim);
        }
        return 0.0;
    }
    return stein_read(n->sim, n->force);
}

/* a wave on a string (Karplus and Strong 1983), pushed at a ninth of its length */
static double ring(note *n, double force)
{
    int end = (n->at + n->length / 9) % n->length;
    double now = n->line[n->at];
    n->line[n->at] = 0.498 * (now + n->before) + 0.001 * force;
    n->line[end] -= 0.001 * force;
    n->before = now;
    n->at = (n->at + 1) % n->length;
    return now;
}

/* ---- the callback ---- */

static void callback(note *notes, float *out, int frames)
{
    for (int i = 0; i < frames; i++) {
        out[i] = 0.0f;
    }
    for (note *n = notes; n < notes + KEYS; n++) {
        for (int i = 0; i < frames; i += STEP) {
            double force = step(n);
            for (int k = 0; k < STEP; k++) {
                out[i + k] += (float)ring(n, force);
            }
        }
    }
}

/* ---- the driver ---- */

static int create(note *notes, stein_err *err)
{
    stein_sim_def def = stein_sim_def_default(&stein_model_stein1788);
    def.dt = (double)STEP / RATE;
    for (int i = 0; i < KEYS; i++) {
        note *n = &notes[i];
        n->length = (int)(RATE / (87.3 * exp2(i / 12.0))); // from F2
        n->force = stein_find_channel(&stein_model_stein1788, "string_force");
        if (stein_sim_create(&n->sim, &stein_model_stein1788, &def, err) != STEIN_OK ||
            stein_drive(n->sim, "finger", press, n, err) != STEIN_OK) {
            return 0;
        }
        stein_load_lift(n->sim);
        n->resting = REST;
    }
    return 1;
}

/* chords of ten fingers, six a second; in the last second every key of the instrument */
static void play(note *notes, int block)
{
    int sixth = RATE / 6 / BLOCK, chord = block / sixth, inside = block % sixth;
    int all = chord >= 18;
    for (int i = 0; i < KEYS && inside == 0; i++) {
        notes[i].finger = (i + 5 * chord) % 6 == 0 && i < 60 ? 2.0 + 0.3 * (chord % 5) : 0.0;
        notes[i].finger = all ? (chord < 22 ? 2.5 : 0.0) : notes[i].finger;
    }
    for (int i = 0; i < KEYS && inside == sixth * 2 / 3 && !all; i++) {
        notes[i].finger = 0.0;
    }
}

static int awake(const note *notes)
{
    int n = 0;
    for (int i = 0; i < KEYS; i++) {
        n += notes[i].resting < REST;
    }
    return n;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

enum { BLOCKS = 4 * RATE / BLOCK, PIECE = 3 * RATE / BLOCK };

static float sound[BLOCKS * BLOCK];

static double used[BLOCKS]; /* share of real time of every block */
static int busy[BLOCKS];    /* keys that were awake */

static void perform(note *notes, int timed)
{
    for (int b = 0; b < BLOCKS; b++) {
        play(notes, b);
        double begin = timed ? now() : 0.0;
        callback(notes, sound + b * BLOCK, BLOCK);
        used[b] = timed ? (now() - begin) * RATE / BLOCK : 0.0;
        busy[b] = awake(notes);
    }
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void tell(const char *what, int first, int n)
{
    double sum = 0.0;
    int most = 0;
    for (int b = first; b < first + n; b++) {
        sum += used[b];
        most = busy[b] > most ? busy[b] : most;
    }
    qsort(used + first, (size_t)n, sizeof *used, by_size);
    printf("%s: up to %d keys awake, load %.0f %% of real time, 99 %% of blocks below %.0f %%\n",
           what, most, 100.0 * sum / n, 100.0 * used[first + n * 99 / 100]);
}

/* what the steps ended with */
static void tell_steps(const note *notes)
{
    int steps = 0, failed = 0;
    for (int i = 0; i < KEYS; i++) {
        steps += notes[i].steps;
        failed += notes[i].failed;
    }
    printf("%d steps, %d failed and began at rest again\n", steps, failed);
}

/* 32-bit floats, one channel */
static int write_wav(int file)
{
    unsigned bytes = sizeof sound,
             head[11] = {0x46464952, 36 + bytes, 0x45564157,   0x20746d66, 16,   3 | 1 << 16,
                         RATE,       4 * RATE,   4 | 32 << 16, 0x61746164, bytes};
    return write(file, head, sizeof head) == (ssize_t)sizeof head &&
           write(file, sound, bytes) == (ssize_t)bytes;
}

int main(int argc, char **argv)
{
    static note notes[KEYS];
    stein_err err;
    int sandbox = argc > 1 && strcmp(argv[1], "--sandbox") == 0;
    int file =
        argc == 2 + sandbox ? open(argv[1 + sandbox], O_WRONLY | O_CREAT | O_TRUNC, 0666) : -1;
    if (file < 0) {
        return fprintf(stderr, "usage: audio [--sandbox] out.wav\n"), 2;
    }
    if (!create(notes, &err)) {
        return fprintf(stderr, "audio: %s\n", err.msg), 1;
    }
    if (sandbox) { // from here on the process may write and exit
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            return perror("audio: seccomp"), 77;
        }
        perform(notes, 0);
        syscall(SYS_exit, write_wav(file) ? 0 : 1);
    }
    perform(notes, 1);
    tell("ten fingers", 0, PIECE);
    tell("all keys at once", PIECE, BLOCKS - PIECE);
    tell_steps(notes);
    for (int i = 0; i < KEYS; i++) {
        stein_sim_destroy(notes[i].sim);
    }
    return write_wav(file) && close(file) == 0 ? 0 : 1;
}
