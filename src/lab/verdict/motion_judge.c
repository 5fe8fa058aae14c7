/* SPDX-License-Identifier: GPL-3.0-or-later
 * motion_judge.c - errors under a measured motion, in units of their own uncertainty.
 *
 * Errors e of the force and of every free channel are averaged over blocks of a few milliseconds
 * within one phase. Their distribution under noise alone is simulated: strokes of the model itself,
 * with the noise of the data on them, pass through the same smoother, mechanism and blocks,
 *
 *      bias_b = mean of e_b,   sd_b^2 = variance of e_b (1 + 1/draws) + (bias_b/10)^2
 *
 * over such draws. The bias is what smoothing removes where the motion bends. It is subtracted from
 * the measured errors; the second term of sd is its uncertainty, since it changes when a stroke
 * lands earlier.
 * With e0 of the model before, e1 of the extended one and d = e0 - e1, what the extension changes,
 * the share of that which is there is
 *
 *      A(e) = sum d_b e_b / sd_b^2 / sum d_b^2 / sd_b^2
 *      share = (A(e0) - a0) / (a1 - a0)
 *
 * a0 and a1 are the means of A(e0) over strokes made by the model before and by the extended one,
 * and their scatter is its sd. 0 is the model before, 1 the extended one.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "motion.h"

enum { PER_STROKE = 24, FEWEST_FRAMES = 4, MOST_FRAMES = 100, BORROWED = 4 };
enum { OF_FORCE = 1, OF_CHANNELS = 2 };
static const double bias_known = 0.1; /* sd of a bias, as a share of it */

int diag__motion_run_of(int draw, int kind)
{
    return MOTION_DRAWS + draw * MOTION_KINDS + kind;
}

/* one block of a stroke, with the means of all runs: value[run*items + item], item 0 the force,
 * then the channels */
typedef struct block {
    int stroke, phase, from, n;
    double *value, *var; /* NAN: no sample */
    double *bias[2];     /* of each model in strokes of its own */
} block;

typedef struct work {
    const diag__runs *r;
    int nrun, items, nblock;
    block *block;
    double *memory;
} work;

static const diag__course *course(const diag__runs *r, int run, int stroke)
{
    return &r->course[run * r->p->nstroke + stroke];
}

/* does a run exist? Without extension there are only those of the model before */
static int is_made(const diag__runs *r, int run)
{
    return r->extended || run == MOTION_BEFORE ||
           (run >= MOTION_DRAWS && (run - MOTION_DRAWS) % MOTION_KINDS == MOTION_00);
}

/* was the stroke simulated in every run? */
static int is_whole(const work *w, int stroke)
{
    int whole = 1;
    for (int run = 0; run < w->nrun; run++) {
        whole &= !is_made(w->r, run) || course(w->r, run, stroke)->ended;
    }
    return whole;
}

/* ---- blocks ---- */

/* phase of a frame that counts, -1 */
static int phase_at(const work *w, int stroke, int i)
{
    double T = course(w->r, MOTION_BEFORE, stroke)->time[i];
    return T > 0.0 && isfinite(T)
               ? diag__phase_index(w->r->phase[diag__frame(w->r->p, stroke) + (size_t)i])
               : -1;
}

/* blocks of a stroke behind the present ones; with w->block NULL they are only counted */
static void cut(work *w, int stroke)
{
    int n = w->r->p->stroke[stroke].n, end;
    int length = n / PER_STROKE > FEWEST_FRAMES ? n / PER_STROKE : FEWEST_FRAMES;
    length = length < MOST_FRAMES ? length : MOST_FRAMES;
    for (int from = 0; from < n; from = end) {
        int phase = phase_at(w, stroke, from);
        for (end = from + 1; end < n && phase_at(w, stroke, end) == phase;) {
            end++;
        }
        int parts = (end - from + length / 2) / length;
        parts = parts > 0 ? parts : 1;
        for (int k = 0; phase >= 0 && end - from >= FEWEST_FRAMES && k < parts; k++) {
            int a = from + (end - from) * k / parts, b = from + (end - from) * (k + 1) / parts;
            if (w->block != NULL) {
                w->block[w->nblock] =
                    (block){.stroke = stroke, .phase = phase, .from = a, .n = b - a};
            }
            w->nblock++;
        }
    }
}

static double mean_of(const double *e, int n)
{
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < n; i++) {
        sum += isfinite(e[i]) ? e[i] : 0.0;
        count += isfinite(e[i]) != 0;
    }
    return 2 * count >= n ? sum / count : (double)NAN;
}

static void average(const work *w, block *b)
{
    int n = w->r->p->stroke[b->stroke].n;
    for (int run = 0; run < w->nrun; run++) {
        const diag__course *c = course(w->r, run, b->stroke);
        for (int k = 0; is_made(w->r, run) && k < w->items; k++) {
            const double *e = k == 0 ? c->error : c->y + (size_t)(k - 1) * (size_t)n;
            b->value[run * w->items + k] = mean_of(e + b->from, b->n);
        }
    }
}

static double value(const work *w, const block *b, int run, int item)
{
    return b->value[run * w->items + item];
}

/* the kind of draws in which a model runs strokes of its own */
static int own_kind(int model)
{
    return model == 0 ? MOTION_00 : MOTION_11;
}

static int models(const work *w)
{
    return w->r->extended ? 2 : 1;
}

static double mean_of_draws(const work *w, const block *b, int item, int model)
{
    double sum = 0.0;
    for (int k = 0; k < w->r->draws; k++) {
        sum += value(w, b, diag__motion_run_of(k, own_kind(model)), item);
    }
    return sum / w->r->draws;
}

/* sum of squares about their means of the draws in which a model runs strokes of its own
 * @param count  degrees of freedom, out  @param bias  mean square of the means, out */
static double own_square(const work *w, const block *b, int item, int *count, double *bias)
{
    double sum = 0.0;
    *count = 0;
    *bias = 0.0;
    for (int model = 0; model < models(w); model++) {
        double mean = mean_of_draws(w, b, item, model);
        for (int k = 0; isfinite(mean) && k < w->r->draws; k++) {
            double e = value(w, b, diag__motion_run_of(k, own_kind(model)), item) - mean;
            sum += e * e;
        }
        *count += isfinite(mean) ? w->r->draws - 1 : 0;
        *bias += isfinite(mean) ? mean * mean / models(w) : 0.0;
        b->bias[model][item] = mean;
    }
    return sum;
}

/* each from its own draws and a few of the mean of its phase */
static void weigh(work *w)
{
    double wide = 1.0 + 1.0 / w->r->draws, bias;
    for (int item = 0; item < w->items; item++) {
        double sum[DIAG_PHASES] = {0.0};
        int n[DIAG_PHASES] = {0}, count;
        for (int i = 0; i < w->nblock; i++) {
            sum[w->block[i].phase] += own_square(w, &w->block[i], item, &count, &bias);
            n[w->block[i].phase] += count;
        }
        for (int i = 0; i < w->nblock; i++) {
            block *b = &w->block[i];
            double own = own_square(w, b, item, &count, &bias), all = sum[b->phase];
            b->var[item] = count > 0 && all > 0.0
                               ? wide * (own + BORROWED * all / n[b->phase]) / (count + BORROWED) +
                                     bias_known * bias_known * bias
                               : (double)NAN;
        }
    }
}

/* A motion that was recorded is known as smoothed only, with its noise in it; what smoothing takes
 * away from that it took from the noise already. */
static int is_clean(const work *w)
{
    return w->r->way->channel >= 0;
}

/* the errors of a model on its own strokes are subtracted from those on others; of a draw, the mean
 * of the other draws */
static void take_off(const work *w, block *b, int item)
{
    for (int run = 0; run < w->nrun; run++) {
        int kind = run < MOTION_DRAWS ? -1 : (run - MOTION_DRAWS) % MOTION_KINDS;
        int model = kind == MOTION_11 || run == MOTION_AFTER;
        double *e = &b->value[run * w->items + item], mean = b->bias[model][item];
        double n = w->r->draws;
        if (is_made(w->r, run) && (kind >= 0 || is_clean(w))) {
            *e -= kind == own_kind(model) ? (n * mean - *e) / (n - 1.0) : mean;
        }
    }
}

static stein_status make_blocks(work *w, stein_err *err)
{
    const diag__runs *r = w->r;
    for (int pass = 0; pass < 2; pass++) {
        w->nblock = 0;
        for (int s = 0; s < r->p->nstroke; s++) {
            if (is_whole(w, s)) {
                cut(w, s);
            }
        }
        if (pass == 0) {
            size_t each = (size_t)w->items * ((size_t)w->nrun + 3), n = (size_t)w->nblock;
            w->block = calloc(n + 1, sizeof *w->block);
            w->memory = malloc(sizeof *w->memory * (each * n + 1));
            if (w->block == NULL || w->memory == NULL) {
                return lab__no_memory(err);
            }
            for (size_t i = 0; i < each * n; i++) {
                w->memory[i] = NAN;
            }
        }
    }
    for (int i = 0; i < w->nblock; i++) {
        block *b = &w->block[i];
        b->value = w->memory + (size_t)i * (size_t)w->items * ((size_t)w->nrun + 3);
        b->var = b->value + w->items * w->nrun;
        b->bias[0] = b->var + w->items;
        b->bias[1] = b->bias[0] + w->items;
        average(w, b);
    }
    weigh(w);
    for (int i = 0; i < w->nblock * w->items; i++) {
        take_off(w, &w->block[i / w->items], i % w->items);
    }
    return STEIN_OK;
}

/* ---- parts ---- */

static int belongs(int item, int group)
{
    return item == 0 ? (group & OF_FORCE) != 0 : (group & OF_CHANNELS) != 0;
}

/* mean of (error/sd)^2 of a run; NAN: nothing to compare */
static double misfit(const work *w, int run, int group)
{
    double sum = 0.0;
    int n = 0;
    for (int i = 0; i < w->nblock; i++) {
        for (int k = 0; k < w->items; k++) {
            double e = value(w, &w->block[i], run, k), var = w->block[i].var[k];
            if (belongs(k, group) && isfinite(e) && var > 0.0) {
                sum += e * e / var;
                n++;
            }
        }
    }
    return n > 0 ? sum / n : (double)NAN;
}

/* mean and sd of what the misfit is by noise alone */
static void misfit_of_noise(const work *w, int kind, int group, double *mean, double *sd)
{
    double sum = 0.0, square = 0.0;
    int n = w->r->draws;
    for (int k = 0; k < n; k++) {
        double q = misfit(w, diag__motion_run_of(k, kind), group);
        sum += q;
        square += q * q;
    }
    *mean = sum / n;
    double scatter = sqrt(fmax(0.0, square / n - *mean * *mean) * n / fmax(1.0, n - 1.0));
    *sd = fmax(scatter, 0.05 * *mean) * sqrt(w->r->wide); // estimated from few draws
}

/* sum d e/var over the blocks of a stroke (-1: of all) */
static double along(const work *w, int run, int group, int stroke)
{
    double sum = 0.0;
    for (int i = 0; i < w->nblock; i++) {
        const block *b = &w->block[i];
        for (int k = 0; k < w->items; k++) {
            double d = value(w, b, MOTION_BEFORE, k) - value(w, b, MOTION_AFTER, k) +
                       (is_clean(w) ? b->bias[0][k] - b->bias[1][k] : 0.0);
            double term = d * value(w, b, run, k) / b->var[k];
            sum += belongs(k, group) && isfinite(term) && (stroke < 0 || b->stroke == stroke) ? term
                                                                                              : 0.0;
        }
    }
    return sum;
}

/* mean over the draws of one kind and, added up over strokes, the variance of one draw */
static void along_draws(const work *w, int kind, int group, double *mean, double *var)
{
    int n = w->r->draws;
    *mean = *var = 0.0;
    for (int s = 0; s < w->r->p->nstroke; s++) {
        double sum = 0.0, square = 0.0;
        for (int k = 0; k < n; k++) {
            double a = along(w, diag__motion_run_of(k, kind), group, s);
            sum += a;
            square += a * a;
        }
        *mean += sum / n;
        *var += fmax(0.0, square / n - sum / n * (sum / n)) * n / fmax(1.0, n - 1.0);
    }
}

static void share_of(const work *w, int group, lab_motion_part *to)
{
    double a0, a1, v0, v1;
    along_draws(w, MOTION_00, group, &a0, &v0);
    along_draws(w, MOTION_10, group, &a1, &v1);
    double var = fmax(v0, v1) * (1.0 + 1.0 / w->r->draws) * w->r->wide;
    to->share = (along(w, MOTION_BEFORE, group, -1) - a0) / (a1 - a0);
    to->share_sd = sqrt(var) / fabs(a1 - a0);
}

/* Three conditions: the extended model is far more likely than the one before; the share is 1
 * within its uncertainty; what departed is gone but for noise or a small part. The last one is not
 * applied where the effect is too small to be detected. Normal errors: the logarithm of the odds is
 * (share - 1/2)/sd^2. */
static lab_motion_says compare(const lab_motion_part *p)
{
    double left = p->after * p->after - 1.0, was = p->before * p->before - 1.0;
    int stays =
        p->z_after > diag__certain && left > diag__part_of * was && p->share_sd < diag__most_of;
    if (!isfinite(p->share) || !isfinite(p->share_sd)) {
        return LAB_MOTION_CANNOT_TELL;
    }
    double odds = 2.0 * (p->share - 0.5) / (p->share_sd * p->share_sd);
    int multiple = p->share > 1.5 + diag__beyond_chance * p->share_sd;
    return stays || multiple || odds < -diag__convincing           ? LAB_MOTION_CONTRADICTS
           : odds > diag__convincing && fabs(p->share - 1.0) < 0.5 ? LAB_MOTION_SUPPORTS
                                                                   : LAB_MOTION_CANNOT_TELL;
}

static void judge_part(const work *w, int group, lab_motion_part *to)
{
    double mean, sd;
    *to = (lab_motion_part){.says = LAB_MOTION_CANNOT_TELL,
                            .after = NAN,
                            .z_after = NAN,
                            .share = NAN,
                            .share_sd = NAN};
    double q = misfit(w, MOTION_BEFORE, group);
    misfit_of_noise(w, MOTION_00, group, &mean, &sd);
    to->before = sqrt(q / mean);
    to->z_before = (q - mean) / sd;
    if (w->r->extended) {
        q = misfit(w, MOTION_AFTER, group);
        misfit_of_noise(w, MOTION_11, group, &mean, &sd);
        to->after = sqrt(q / mean);
        to->z_after = (q - mean) / sd;
        share_of(w, group, to);
        to->says = compare(to);
    } else if (isfinite(to->before)) {
        to->says = to->z_before > diag__certain ? LAB_MOTION_CONTRADICTS : LAB_MOTION_SUPPORTS;
    }
}

/* ---- rows ---- */

/* root mean square of a run over blocks of a phase (-1: all), and its signed mean */
static double size_of(const work *w, int run, int item, int phase, double *mean)
{
    double sum = 0.0, square = 0.0, n = 0.0;
    for (int i = 0; i < w->nblock; i++) {
        const block *b = &w->block[i];
        double e = value(w, b, run, item);
        if ((phase < 0 || b->phase == phase) && isfinite(e)) {
            sum += b->n * e;
            square += b->n * e * e;
            n += b->n;
        }
    }
    *mean = n > 0.0 ? sum / n : (double)NAN;
    return n > 0.0 ? sqrt(square / n) : (double)NAN;
}

static double size_of_noise(const work *w, int item, int phase, double *sd_of_mean)
{
    double sum = 0.0, means = 0.0, mean, n = 0.0;
    for (int k = 0; k < w->r->draws; k++) {
        for (int kind = MOTION_00; kind <= (w->r->extended ? MOTION_11 : MOTION_00); kind++) {
            double e = size_of(w, diag__motion_run_of(k, kind), item, phase, &mean);
            sum += e * e;
            means += mean * mean;
            n += 1.0;
        }
    }
    *sd_of_mean = sqrt(means / n * w->r->wide);
    return sqrt(sum / n);
}

static double size_present(const work *w, int phase, int *samples, int item)
{
    double square = 0.0;
    int n = 0;
    *samples = 0;
    for (int i = 0; i < w->nblock; i++) {
        const block *b = &w->block[i];
        const double *at = course(w->r, MOTION_BEFORE, b->stroke)->present;
        int counts = (phase < 0 || b->phase == phase) && isfinite(value(w, b, MOTION_BEFORE, item));
        *samples += counts ? b->n : 0;
        for (int k = b->from; counts && at != NULL && k < b->from + b->n; k++) {
            square += isfinite(at[k]) ? at[k] * at[k] : 0.0;
            n += isfinite(at[k]) != 0;
        }
    }
    return item == 0 && n > 0 ? sqrt(square / n) : (double)NAN;
}

static void add_row(const work *w, lab_motion *out, int item, int phase)
{
    const stein_model *m = lab_equations(w->r->p->model);
    int channel = item == 0 ? w->r->way->force : w->r->p->stroke[0].channel[item - 1];
    lab_motion_row *row = &out->row[out->nrow];
    *row = (lab_motion_row){.channel = item == 0 ? NULL : m->channels[channel].name,
                            .unit = m->channels[channel].unit,
                            .phase = phase < 0 ? NULL : diag__phase[phase],
                            .after = NAN,
                            .mean_after = NAN};
    row->before = size_of(w, MOTION_BEFORE, item, phase, &row->mean_before);
    row->noise = size_of_noise(w, item, phase, &row->mean_sd);
    row->present = size_present(w, phase, &row->samples, item);
    if (w->r->extended) {
        row->after = size_of(w, MOTION_AFTER, item, phase, &row->mean_after);
    }
    out->nrow += isfinite(row->before);
}

static stein_status make_rows(const work *w, lab_motion *out, stein_err *err)
{
    out->row = calloc((size_t)(w->items * (DIAG_PHASES + 1)) + 1, sizeof *out->row);
    if (out->row == NULL) {
        return lab__no_memory(err);
    }
    for (int item = 0; item < w->items; item++) {
        for (int phase = -1; phase < DIAG_PHASES; phase++) {
            add_row(w, out, item, phase);
        }
    }
    return STEIN_OK;
}

/* ---- one stroke over time ---- */

/* mean of a frame's errors over the draws in which a model runs strokes of its own */
static double frame_bias(const work *w, int stroke, int i, int model)
{
    double sum = 0.0;
    for (int k = 0; k < w->r->draws; k++) {
        sum += course(w->r, diag__motion_run_of(k, own_kind(model)), stroke)->error[i];
    }
    return sum / w->r->draws;
}

/* noise of a frame: as the draws have it, over some frames beside it */
static double frame_sd(const work *w, int stroke, int i, int n)
{
    double sum = 0.0, count = 0.0;
    for (int o = i > 2 ? i - 2 : 0; o <= i + 2 && o < n; o++) {
        double mean = frame_bias(w, stroke, o, 0);
        for (int k = 0; k < w->r->draws; k++) {
            double e = course(w->r, diag__motion_run_of(k, MOTION_00), stroke)->error[o] - mean;
            sum += isfinite(e) ? e * e : 0.0;
            count += isfinite(e) ? 1.0 - 1.0 / w->r->draws : 0.0;
        }
    }
    return count > 0.0 ? sqrt(sum / count) : (double)NAN;
}

static stein_status show_stroke(const work *w, lab_motion *out, stein_err *err)
{
    const diag__runs *r = w->r;
    int shown = w->block[w->nblock / 2].stroke, n = r->p->stroke[shown].n;
    const diag__course *b = course(r, MOTION_BEFORE, shown), *a = course(r, MOTION_AFTER, shown);
    out->t = malloc(sizeof *out->t * 5 * (size_t)(n + 1));
    if (out->t == NULL) {
        return lab__no_memory(err);
    }
    out->present = out->t + n;
    out->before = out->present + n;
    out->after = out->before + n;
    out->sd = out->after + n;
    out->file = r->p->stroke[shown].data->file;
    for (int i = 0; i < n; i++) {
        double there = b->present != NULL ? b->present[i] : (double)NAN;
        if (b->time[i] > 0.0 && isfinite(there) && isfinite(b->error[i])) {
            int k = out->n++;
            out->t[k] = r->p->stroke[shown].data->time[i];
            out->present[k] = there;
            out->before[k] = there + b->error[i] - (is_clean(w) ? frame_bias(w, shown, i, 0) : 0.0);
            out->after[k] = !r->extended ? out->before[k]
                                         : there + a->error[i] -
                                               (is_clean(w) ? frame_bias(w, shown, i, 1) : 0.0);
            out->sd[k] = frame_sd(w, shown, i, n);
        }
    }
    return STEIN_OK;
}

/* ---- the whole ---- */

/* Where nothing departs: would an effect have been detected? The mean force in one of the phases
 * has to be known well enough. */
static int is_blind(const lab_motion *out)
{
    for (int i = 0; i < out->nrow; i++) {
        const lab_motion_row *row = &out->row[i];
        if (row->channel == NULL && row->phase != NULL &&
            row->mean_sd < diag__part_of * row->present) {
            return 0;
        }
    }
    return 1;
}

stein_status diag__motion_judge(const diag__runs *runs, lab_motion *out, stein_err *err)
{
    work w = {.r = runs,
              .nrun = MOTION_DRAWS + MOTION_KINDS * runs->draws,
              .items = 1 + runs->p->stroke[0].nch};
    stein_status status = make_blocks(&w, err);
    if (status == STEIN_OK && w.nblock > 0) {
        status = make_rows(&w, out, err);
        status = status == STEIN_OK ? show_stroke(&w, out, err) : status;
        judge_part(&w, OF_FORCE, &out->of_force);
        judge_part(&w, OF_CHANNELS, &out->of_channels);
        judge_part(&w, OF_FORCE | OF_CHANNELS, &out->all);
        if (!runs->extended && out->of_force.says == LAB_MOTION_SUPPORTS && is_blind(out)) {
            out->of_force.says = out->all.says = LAB_MOTION_CANNOT_TELL;
        }
        for (int s = 0; s < runs->p->nstroke; s++) {
            out->strokes += is_whole(&w, s);
        }
    }
    free(w.block);
    free(w.memory);
    return status;
}
