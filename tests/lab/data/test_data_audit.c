/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_data_audit.c - the audit recovers the properties of a synthetic record, and audits
 * measurements of others, where they are present.
 *
 * Limits are the errors of the estimators at these record lengths, over several seeds: noise +-15
 * %, steps +-2 %, jitter +-15 %, ends of rests by a few ms (the motion begins as a t^2 / 2).
 */
#include "data_support.h"

void data_audit_cases(Suite *suite);

static const stein_model *const action = &stein_model_stein1788;
#define FREE "# trigger: unsynchronised\n"

/* audit of one film of a stroke */
static lab_audit *audit_film(const char *notes, camera c, lost_fn *lost, lab_data **data)
{
    *data = open_data(film("film.csv", notes, c, lost), action);
    return audit_of(*data);
}

static void close_both(lab_audit *a, lab_data *d)
{
    lab_audit_destroy(a);
    lab_data_close(d);
}

/* ---- noise ---- */

START_TEST(noise_is_estimated_from_the_record)
{
    static const double noise[] = {5.3e-6, 20e-6, 47e-6}, rate[] = {1000.0, 4000.0, 10000.0};
    camera c = camera_default(4711u + (unsigned)_i);
    lab_data *d;
    c.noise = noise[_i % 3];
    c.rate = rate[_i / 3 % 3];
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_close(ch->noise, c.noise, 0.15, 0.0);
    ck_assert_int_eq(ch->noise_from, LAB_NOISE_REST);
    ck_assert_close(ch->correlation[0], 0.0, 0.0, 0.2);
    ck_assert_close(ch->correlation[3], 0.0, 0.0, 0.2);
    close_both(a, d);
}
END_TEST

START_TEST(noise_is_estimated_where_nothing_rests)
{
    camera c = camera_default(91u + (unsigned)_i);
    lab_data *d;
    c.from = c.trigger + 0.006; // in motion from the first to the last sample
    c.to = c.trigger + 0.11;
    c.noise = 17e-6;
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_int_eq(ch->noise_from, LAB_NOISE_MOTION);
    ck_assert_close(ch->noise, c.noise, 0.15, 0.0);
    ck_assert_close(ch->correlation[0], 0.0, 0.0, 0.25);
    close_both(a, d);
}
END_TEST

START_TEST(correlated_noise_keeps_its_size_and_is_reported)
{
    camera c = camera_default(3u + (unsigned)_i);
    lab_data *d;
    c.correlation = 0.55;
    c.to = 0.8;
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_close(ch->noise, c.noise, 0.15, 0.0);
    ck_assert_close(ch->correlation[0], 0.55, 0.0, 0.12);
    ck_assert_close(ch->correlation[1], 0.55 * 0.55, 0.0, 0.15);
    ck_assert_int_eq(was_found(a, "is correlated by 0."), 1);
    close_both(a, d);
}
END_TEST

START_TEST(given_noise_is_used_and_a_wrong_one_is_reported)
{
    lab_data *d;
    lab_audit *a = audit_film(FREE "# noise string_distance: 21 um\n", camera_default(5), NULL, &d);
    ck_assert(a->channel[0].noise == 21e-6);
    ck_assert_int_eq(a->channel[0].noise_from, LAB_NOISE_REST);
    ck_assert_close(a->channel[0].noise_estimated, 20e-6, 0.15, 0.0);
    ck_assert_int_eq(was_found(a, "the noise is given as"), 0);
    close_both(a, d);
    a = audit_film(FREE "# noise string_distance: 1 mm\n", camera_default(5), NULL, &d);
    ck_assert_int_eq(was_found(a, "the noise is given as 1 mm, the record shows "), 1);
    close_both(a, d);
}
END_TEST

/* A rod that swings at 1 Hz, far enough that its motion is no sine, seen by an encoder or a camera.
 * The record of a rate is the thinned one of a higher rate. */
typedef struct swinging {
    double rate, noise, step, amplitude, length;
} swinging;

static lab_audit *audit_swing(swinging w, const char *notes, unsigned long long seed,
                              lab_data **data)
{
    const char *path = in_folder("swing.csv");
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "%stime [s],angle [rad]\n", notes);
    double q = w.amplitude, v = 0.0, t = 0.0;
    const double h = 1e-4, square = 39.5;
    for (int i = 0; i < (int)(w.length * w.rate); i++) {
        for (; t < i / w.rate - 0.5 * h; t += h) { // Stoermer-Verlet
            v -= 0.5 * h * square * sin(q);
            q += h * v;
            v -= 0.5 * h * square * sin(q);
        }
        double y = q + v * (i / w.rate - t) + w.noise * gaussian(&seed);
        fprintf(f, "%.6f,%.9f\n", i / w.rate, w.step > 0.0 ? w.step * round(y / w.step) : y);
    }
    ck_assert_int_eq(fclose(f), 0);
    *data = open_data(path, &stein_model_pendulum);
    return audit_of(*data);
}

START_TEST(noise_does_not_depend_on_the_sampling_rate)
{
    static const double rate[] = {30.0, 60.0, 125.0, 500.0, 1000.0};
    static const double noise[] = {1.1e-4, 6.3e-4, 4.7e-3}, amplitude[] = {0.27, 1.13};
    swinging w = {.rate = rate[_i % 5],
                  .noise = noise[_i / 5 % 3],
                  .amplitude = amplitude[_i / 15],
                  .length = 11.0};
    lab_data *d;
    lab_audit *a = audit_swing(w, "", 7u + (unsigned)_i, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_close(ch->noise, w.noise, w.rate < 50.0 ? 0.3 : 0.2, 0.0);
    ck_assert_double_lt(ch->noise_error, 0.1);
    close_both(a, d);
}
END_TEST

START_TEST(an_encoder_without_other_noise_has_that_of_its_step)
{
    static const double rate[] = {30.0, 60.0, 125.0, 500.0, 1000.0}, dither[] = {0.0, 7e-4};
    swinging w = {.rate = rate[_i % 5],
                  .step = 1.5e-3,
                  .noise = dither[_i / 5],
                  .amplitude = 0.61,
                  .length = 11.0};
    lab_data *d;
    lab_audit *a = audit_swing(w, "", 3u + (unsigned)_i, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_close(ch->step, w.step, 0.02, 0.0);
    ck_assert_close(ch->noise, hypot(w.noise, w.step / sqrt(12.0)), w.rate < 50.0 ? 0.3 : 0.2, 0.0);
    close_both(a, d);
}
END_TEST

START_TEST(noise_is_found_between_the_bounces_of_a_ball)
{
    static const double rate[] = {60.0, 240.0, 1000.0};
    const char *path = in_folder("bounces.csv");
    double noise = 4.3e-4, z = 0.31, v = 0.0, t = 0.0;
    unsigned long long seed = 5u + (unsigned)_i;
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "time [s],height [m]\n");
    for (int i = 0; i < (int)(2.0 * rate[_i]); i++) {
        for (; t < i / rate[_i]; t += 1e-5) {
            v -= 9.81e-5;
            z += 1e-5 * v;
            v = z < 0.0 && v < 0.0 ? -0.86 * v : v;
        }
        fprintf(f, "%.6f,%.9f\n", i / rate[_i], z + noise * gaussian(&seed));
    }
    ck_assert_int_eq(fclose(f), 0);
    lab_data *d = open_data(path, &stein_model_bouncing_ball);
    lab_audit *a = audit_of(d);
    ck_assert_close(a->channel[0].noise, noise, 0.25, 0.0);
    close_both(a, d);
}
END_TEST

START_TEST(a_noise_that_the_record_contradicts_is_reported_with_both_numbers)
{
    static const struct {
        const char *notes;
        int told;
    } given[] = {{"# noise angle: 1.2 mrad\n", 0},
                 {"# noise angle: 1.6 mrad\n", 0},
                 {"# noise angle: 3 mrad\n", 1},
                 {"# noise angle: 0.4 mrad\n", 1}};
    swinging w = {.rate = 100.0, .noise = 1e-3, .amplitude = 0.5, .length = 11.0};
    lab_data *d;
    lab_audit *a = audit_swing(w, given[_i].notes, 11, &d);
    ck_assert_int_eq(was_found(a, "angle: the noise is given as "), given[_i].told);
    ck_assert_int_eq(was_found(a, " mrad, the record shows "), given[_i].told);
    close_both(a, d);
}
END_TEST

/* ---- quantisation ---- */

START_TEST(a_quantisation_step_is_found_again)
{
    static const double step[] = {5.17e-6, 17.3e-6, 49.1e-6}, noise[] = {8.1e-6, 20e-6, 55e-6};
    camera c = camera_default(700u + (unsigned)_i);
    lab_data *d;
    c.step = step[_i % 3];
    c.noise = noise[_i / 3];
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    const lab_channel_audit *ch = &a->channel[0];
    double total = sqrt(c.noise * c.noise + c.step * c.step / 12.0);
    ck_assert_close(ch->step, c.step, 0.02, 0.0);
    if (c.step < 2.0 * c.noise) {
        ck_assert_close(ch->noise, total, 0.15, 0.0);
    } else { // the resting values may sit in the middle of a step
        ck_assert_double_ge(ch->noise, c.step / sqrt(12.0) * 0.999);
        ck_assert_double_le(ch->noise, 1.3 * total);
    }
    close_both(a, d);
}
END_TEST

START_TEST(a_record_locked_to_its_pixels_is_reported)
{
    camera c = camera_default(12);
    lab_data *d;
    c.step = 23e-6;
    c.noise = 1.1e-6;
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    ck_assert_close(a->channel[0].step, c.step, 0.02, 0.0);
    ck_assert_close(a->channel[0].noise, c.step / sqrt(12.0), 1e-2, 0.0);
    ck_assert_int_eq(a->channel[0].noise_from, LAB_NOISE_STEP);
    ck_assert_double_gt(a->channel[0].locking, 0.3);
    ck_assert_int_eq(was_found(a, "rounded to steps of 23"), 1);
    close_both(a, d);
}
END_TEST

/* A glider that loses a sixth of its speed: neighbours are 2.2 to 2.0 mm apart, which is no step of
 * a sensor that tells micrometres. */
START_TEST(the_way_between_two_samples_of_steady_motion_is_no_step)
{
    const char *path = in_folder("glider.csv");
    unsigned long long seed = 19;
    FILE *f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "time [s],height [m]\n");
    for (int i = 0; i < 345; i++) {
        double t = i / 500.0, x = 1.1 * t - 0.13 * t * t + 12e-6 * gaussian(&seed);
        fprintf(f, "%.6f,%.6f\n", t, 1e-6 * round(1e6 * x));
    }
    ck_assert_int_eq(fclose(f), 0);
    lab_data *d = open_data(path, &stein_model_falling_ball);
    lab_audit *a = audit_of(d);
    ck_assert_double_lt(a->channel[0].step, 5e-6);
    ck_assert_close(a->channel[0].noise, 12e-6, 0.2, 0.0);
    close_both(a, d);
}
END_TEST

/* ---- time ---- */

START_TEST(jitter_of_the_frames_is_measured)
{
    camera c = camera_default(60u + (unsigned)_i);
    lab_data *d;
    c.jitter = 9.3e-6 * (1 + _i);
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    ck_assert_close(a->rate, 4000.0, 0.01, 0.0);
    ck_assert_close(a->jitter_sd, sqrt(2.0) * c.jitter, 0.15, 0.0);
    ck_assert_double_le(a->jitter_max, 2.0 * sqrt(3.0) * c.jitter * 1.1);
    ck_assert_double_ge(a->jitter_max, 1.5 * sqrt(3.0) * c.jitter);
    ck_assert_int_eq(a->gaps, 0);
    close_both(a, d);
}
END_TEST

static int some_lost(int frame)
{
    return frame == 101 || (frame >= 333 && frame < 338) || frame == 1200;
}

START_TEST(dropped_frames_are_counted)
{
    camera c = camera_default(8);
    lab_data *d;
    c.jitter = 6e-6;
    lab_audit *a = audit_film(FREE, c, some_lost, &d);
    ck_assert(a->uniform);
    ck_assert_int_eq(a->gaps, 3);
    ck_assert_int_eq(a->dropped, 7);
    ck_assert_close(a->longest_gap, 6.0 / 4000.0, 0.05, 0.0);
    ck_assert_close(a->gap[1].from, 332.0 / 4000.0, 0.0, 50e-6);
    ck_assert_int_eq(was_found(a, "3 gaps, 7 frames dropped"), 1);
    close_both(a, d);
}
END_TEST

static int most_lost(int frame)
{
    unsigned long long seed = (unsigned long long)frame;
    return noise(&seed) < -0.1;
}

START_TEST(a_varying_rate_is_reported_and_is_no_gap)
{
    lab_data *d;
    lab_audit *a = audit_film(FREE, camera_default(9), most_lost, &d);
    ck_assert(!a->uniform);
    ck_assert_int_eq(was_found(a, "the sampling rate varies"), 1);
    ck_assert_int_eq(was_found(a, "dropped"), 0);
    ck_assert_close(a->channel[0].noise, 20e-6, 0.15, 0.0);
    close_both(a, d);
}
END_TEST

/* ---- rest and trigger ---- */

START_TEST(rests_and_the_first_motion_are_found)
{
    camera c = camera_default(20u + (unsigned)_i);
    lab_data *d;
    c.noise = _i % 2 == 0 ? 20e-6 : 7e-6;
    c.step = _i < 4 ? 0.0 : 17.3e-6;
    c.trigger = 0.0317 + 0.0049 * _i;
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_msg(a->nrest == 2, "%d rests", a->nrest);
    ck_assert_close(a->rest[0].from, 0.0, 0.0, 1e-3);
    ck_assert_close(a->rest[0].to, c.trigger, 0.0, 4e-3);
    ck_assert_close(a->rest[1].from, c.trigger + 0.115, 0.0, 0.02);
    ck_assert_close(a->rest[1].to, 0.4, 0.0, 1e-3);
    ck_assert(ch->starts_at_rest && a->trigger_fits);
    ck_assert_close(a->motion, c.trigger, 0.0, 1.3e-3);
    ck_assert_close(a->motion, c.trigger, 0.0, 4.0 * a->motion_error);
    close_both(a, d);
}
END_TEST

START_TEST(a_short_rest_is_enough_at_the_start)
{
    camera c = camera_default(1300u + (unsigned)_i);
    lab_data *d;
    c.trigger = 0.0081; // 32 frames
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    ck_assert(a->starts_at_rest);
    ck_assert_close(a->motion, c.trigger, 0.0, 1.6e-3);
    close_both(a, d);
}
END_TEST

START_TEST(the_top_of_a_flight_is_no_rest)
{
    static const double rates[] = {500.0, 4000.0, 10000.0};
    unsigned long long seed = 77u + (unsigned)_i;
    FILE *f = fopen(in_folder("flight.csv"), "w");
    fprintf(f, "time [s],height [m]\n");
    for (int i = 0; i < 0.4 * rates[_i]; i++) {
        double t = i / rates[_i] - 0.2;
        fprintf(f, "%.6f,%.8f\n", t, 30.0 - 4.905 * t * t + 20e-6 * gaussian(&seed));
    }
    fclose(f);
    lab_data *d = open_data(in_folder("flight.csv"), &stein_model_falling_ball);
    lab_audit *a = audit_of(d);
    ck_assert_int_eq(a->nrest, 0);
    ck_assert(isnan(a->motion) && a->trigger_fits);
    ck_assert_close(a->channel[0].noise, 20e-6, 0.15, 0.0);
    close_both(a, d);
}
END_TEST

START_TEST(a_trigger_that_does_not_fit_is_reported)
{
    lab_data *d;
    camera c = camera_default(33);
    lab_audit *a = audit_film("", c, NULL, &d); // 51.7 ms of rest, and no finding
    ck_assert(!a->trigger_fits);
    ck_assert_int_eq(was_found(a, "nothing moves until 5"), 1);
    close_both(a, d);
    a = audit_film("# trigger: unsynchronised\n", c, NULL, &d);
    ck_assert(a->trigger_fits);
    close_both(a, d);

    c.from = -0.06;
    c.trigger = -0.0083; // moves before the trigger
    a = audit_film("# trigger: synchronised\n", c, NULL, &d);
    ck_assert(!a->trigger_fits);
    ck_assert_int_eq(was_found(a, "before the trigger, though the trigger is called synchron"), 1);
    close_both(a, d);

    c.trigger = 0.0; // as it should be
    a = audit_film("# trigger: synchronised\n", c, NULL, &d);
    ck_assert_msg(a->trigger_fits, "%s", a->nfinding > 0 ? a->finding[0] : "");
    close_both(a, d);
    c.from = 0.0; // even without a rest
    a = audit_film("", c, NULL, &d);
    ck_assert_msg(a->trigger_fits, "%s", a->nfinding > 0 ? a->finding[0] : "");
    close_both(a, d);
    c.from = 0.021;
    a = audit_film("", c, NULL, &d);
    ck_assert(!a->trigger_fits);
    ck_assert_int_eq(was_found(a, "the start of the motion is missing"), 1);
    close_both(a, d);
}
END_TEST

START_TEST(milliseconds_called_seconds_are_reported)
{
    camera c = camera_default(34);
    FILE *f = fopen(in_folder("ms.csv"), "w");
    eye e = {c, 0.0};
    fprintf(f, "time [s],string_distance [mm]\n");
    for (int i = 0; i <= 800; i++) {
        fprintf(f, "%.3f,%.6f\n", 0.5 * i, 1e3 * see(&e, 0.5e-3 * i));
    }
    fclose(f);
    lab_data *d = open_data(in_folder("ms.csv"), action);
    lab_audit *a = audit_of(d);
    ck_assert_int_eq(was_found(a, "is the unit of the time right?"), 1);
    close_both(a, d);
}
END_TEST

/* ---- single samples ---- */

START_TEST(values_cut_off_are_counted)
{
    camera c = camera_default(40);
    lab_data *d;
    c.highest = 38.1e-3; // the rest at the start lies above
    lab_audit *a = audit_film(FREE, c, NULL, &d);
    ck_assert_int_ge(a->channel[0].saturated_high, (int)(0.0517 * 4000.0));
    ck_assert_int_eq(a->channel[0].saturated_low, 0);
    ck_assert_int_eq(was_found(a, "cut off at its highest value 38.1 mm"), 1);
    close_both(a, d);
    c = camera_default(41);
    c.step = 17.3e-6;
    c.noise = 2e-6;
    c.lowest = 3.3e-3; // the head near the string
    a = audit_film(FREE, c, NULL, &d);
    ck_assert_int_ge(a->channel[0].saturated_low, 10);
    ck_assert_int_eq(a->channel[0].saturated_high, 0);
    close_both(a, d);
    for (unsigned i = 0; i < 6; i++) { // and where nothing is, nothing is found
        c = camera_default(400 + i);
        c.step = i % 2 == 0 ? 0.0 : 17.3e-6;
        c.noise = i < 3 ? 20e-6 : 3e-6;
        a = audit_film(FREE, c, NULL, &d);
        ck_assert_int_eq(a->channel[0].saturated_low + a->channel[0].saturated_high, 0);
        ck_assert_int_eq(a->channel[0].spikes, 0);
        close_both(a, d);
    }
}
END_TEST

START_TEST(spikes_and_missing_samples_are_counted)
{
    camera c = camera_default(50);
    eye e = {c, 0.0};
    lab_data *d = NULL;
    FILE *f = fopen(in_folder("spikes.csv"), "w");
    fprintf(f, FREE "time [s],string_distance [mm]\n");
    for (int i = 0; i <= 1600; i++) {
        double x = 1e3 * see(&e, i / c.rate) + (i == 77 ? 0.83 : i == 430 ? -1.7 : 0.0);
        if (i % 10 == 3 || (i > 900 && i < 931)) {
            fprintf(f, "%.6f,\n", i / c.rate);
        } else {
            fprintf(f, "%.6f,%.6f\n", i / c.rate, x);
        }
    }
    fclose(f);
    d = open_data(in_folder("spikes.csv"), action);
    lab_audit *a = audit_of(d);
    const lab_channel_audit *ch = &a->channel[0];
    ck_assert_int_eq(ch->spikes, 2);
    ck_assert_close(ch->spike[0], 77.0 / c.rate, 1e-9, 0.0);
    ck_assert_close(ch->spike[1], 430.0 / c.rate, 1e-9, 0.0);
    ck_assert_int_eq(ch->samples, d->column[0].samples);
    ck_assert_close(ch->missing, 187.0 / 1601.0, 0.01, 0.0);
    ck_assert_int_eq(ch->longest_missing, 30);
    ck_assert_int_eq(a->gaps, 0); // of the rows
    ck_assert_close(ch->noise, 20e-6, 0.15, 0.0);
    close_both(a, d);
}
END_TEST

/* ---- rest values ---- */

/* audit of a film whose `# set string.height` is `higher` than where the film rests */
static lab_audit *audit_at_height(double higher, const lab_model *model, lab_data **d)
{
    double rest[1];
    char height[LAB_NUMBER];
    *d = open_data(film("film.csv", FREE, camera_default(55), NULL), action);
    ck_assert_stein(lab_data_rest(*d, model, rest, err));
    lab_data_close(*d);
    int k = stein_find_param(action, "string.height");
    lab__number(height, lab_parameters(model)[k] + 39.23e-3 - rest[0] + higher);
    char *notes = lab__text(FREE "# x: y\n# set string.height: %s\n", height);
    lab_audit *a = audit_film(notes, camera_default(55), NULL, d);
    free(notes);
    return a;
}

START_TEST(a_stroke_that_contradicts_its_settings_is_refused)
{
    lab_model *model = NULL;
    lab_options options = lab_options_default();
    said s = {.n = 0};
    lab_data *d;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    lab_audit *a = audit_at_height(0.0, model, &d);
    double value[1], tolerance[1] = {0.1e-3};
    ck_assert_stein(lab_data_rest(d, model, value, err));
    ck_assert_close(value[0], 39.23e-3, 0.0, 1e-6);
    ck_assert_stein(lab_data_check_rest(a, value, tolerance, hear, &s, err));
    ck_assert_int_eq(s.n, 0);
    close_both(a, d);

    a = audit_at_height(1.17e-3, model, &d);
    ck_assert_stein(lab_data_rest(d, model, value, err));
    ck_assert_int_eq(lab_data_check_rest(a, value, tolerance, hear, &s, NULL), STEIN_EPARSE);
    ck_assert_int_eq(s.n, 1);
    ck_assert_ptr_nonnull(strstr(s.text[0], "film.csv:3:7: \"string_distance\" rests at 39.2"));
    ck_assert_ptr_nonnull(strstr(s.text[0], "the model with these settings at 40.4"));
    value[0] = NAN; // columns without an expected value are not compared
    ck_assert_stein(lab_data_check_rest(a, value, tolerance, hear, &s, err));
    close_both(a, d);
    lab_close(model);
}
END_TEST

START_TEST(the_audit_of_a_simulated_stroke_finds_nothing_wrong)
{
    lab_record *record = NULL;
    stein_sim *sim = make_sim(action, STEIN_RK4, 0.0);
    lab_stroke_def def = lab_stroke_def_default(action);
    ck_assert_stein(lab_record_create(&record, action, 0.25e-3, err));
    def.until = 0.2;
    def.sample = lab_record_sample;
    def.ctx = record;
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert_stein(lab_write_csv(in_folder("s.csv"), record, NULL, err));
    lab_data *d = open_data(in_folder("s.csv"), action);
    lab_audit *a = audit_of(d);
    said s = {.n = 0};
    ck_assert_stein(lab_audit_text(a, hear, &s, err));
    ck_assert_msg(a->trigger_fits && a->uniform && a->gaps == 0, "%s", a->finding[0]);
    for (int k = 0; k < d->ncolumn; k++) {
        ck_assert_int_eq(
            a->channel[k].spikes + a->channel[k].saturated_low + a->channel[k].saturated_high, 0);
    }
    ck_assert_msg(a->nfinding == 0, "%s", a->nfinding > 0 ? a->finding[0] : "");
    ck_assert_int_ge(s.n, 1 + d->ncolumn);
    close_both(a, d);
    lab_record_destroy(record);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- measurements made by others ---- */

/* converted copies in the test's folder; 0 when the measurements are not here */
static int convert(void)
{
    if (access("../shared/data", R_OK) != 0) {
        printf("skipped: no measurements in ../shared/data\n");
        return 0;
    }
    char *command = lab__text("sh tests/convert_data.sh ../shared/data %s", folder);
    ck_assert_int_eq(system(command), 0);
    free(command);
    return 1;
}

/* open a converted file; NULL, with a message, when it is absent */
static lab_data *open_converted(const char *name, const stein_model *model)
{
    if (access(in_folder(name), R_OK) != 0) {
        printf("skipped: %s is not in ../shared/data\n", name);
        return NULL;
    }
    return open_data(in_folder(name), model);
}

START_TEST(the_machine_axis_is_audited)
{
    static const char *const name[] = {"emps_train.csv", "emps_pulses.csv"};
    for (int i = 0; i < 2 && convert(); i++) {
        lab_data *d = open_converted(name[i], &stein_model_emps);
        if (d == NULL) {
            continue;
        }
        lab_audit *a = audit_of(d);
        ck_assert_int_eq(d->nrow, 24841);
        ck_assert_close(a->rate, 1000.0, 1e-6, 0.0);
        ck_assert(a->uniform && a->gaps == 0);
        ck_assert_int_eq(lab_data_column(d, "slide_motion")->role, LAB_INPUT);
        ck_assert_int_eq(lab_data_column(d, "slide_force")->role, LAB_OUTPUT);
        ck_assert_close(a->channel[1].step, 35.15065e-6, 0.02, 0.0); // six digits of the volts
        ck_assert_double_le(a->channel[0].noise, 1e-6);
        ck_assert_double_gt(a->channel[1].noise, 0.05);
        ck_assert_double_lt(a->channel[1].noise, 2.2); // published: the model's error has 2.184 N
        close_both(a, d);
    }
}
END_TEST

START_TEST(the_falling_balls_are_audited)
{
    static const char *const name[] = {"ball_golf_ball_1.csv", "ball_whiffle_ball_2_2.csv",
                                       "ball_yellow_whiffle_ball_1.csv", "ball_volleyball_2.csv"};
    static const double mass[] = {1.62, 1.0, 1.5, NAN}; // [oz]
    for (int i = 0; i < 4 && convert(); i++) {
        lab_data *d = open_converted(name[i], &stein_model_falling_ball);
        if (d == NULL) {
            continue;
        }
        lab_audit *a = audit_of(d);
        ck_assert_int_eq(d->nset, isnan(mass[i]) ? 0 : 2);
        if (d->nset > 0) {
            ck_assert_close(d->set[0].value, 28.349523125e-3 * mass[i], 1e-8, 0.0);
        }
        ck_assert_close(a->rate, 15.0, 0.01, 0.0);
        ck_assert_double_gt(a->channel[0].noise, 0.015); // cm from 50 m away
        ck_assert_double_lt(a->channel[0].noise, 0.09);
        ck_assert_int_eq(a->nrest, 0);
        close_both(a, d);
    }
}
END_TEST

START_TEST(the_sensors_of_the_piano_are_audited)
{
    if (!convert() || access(in_folder("piano_hammer_key.csv"), R_OK) != 0) {
        return;
    }
    // raw counts have no unit; a model with such channels is made up here
    static const stein_channel channels[] = {
        {.name = "time", .unit = "s", .read = STEIN_READ_TIME, .sign = 1},
        {.name = "hammer_adc", .unit = "1", .read = STEIN_READ_POSITION, .sign = 1},
        {.name = "keyback_adc", .unit = "1", .read = STEIN_READ_POSITION, .sign = 1}};
    stein_model counts = stein_model_falling_ball;
    counts.name = "counts";
    counts.nchannel = 3;
    counts.channels = channels;
    counts.until = 50.0;
    lab_data *d = open_data(in_folder("piano_hammer_key.csv"), &counts);
    lab_audit *a = audit_of(d);
    ck_assert_int_eq(d->nrow, 100001);
    ck_assert_close(a->rate, 2000.0, 1e-6, 0.0);
    for (int k = 0; k < 2; k++) {
        ck_assert_double_gt(a->channel[k].noise, 1e-5);
        ck_assert_double_lt(a->channel[k].noise, 1e-2);
        ck_assert_int_gt(a->channel[k].nrest, 3);
    }
    close_both(a, d);
    d = open_data(in_folder("piano_hammer_fast.csv"), &counts);
    a = audit_of(d);
    ck_assert_close(a->channel[0].step, 1.0, 0.02, 0.0); // whole counts
    close_both(a, d);
}
END_TEST

void data_audit_cases(Suite *suite)
{
    TCase *tc = tcase_create("audit");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 120.0);
    tcase_add_loop_test(tc, noise_is_estimated_from_the_record, 0, 9);
    tcase_add_loop_test(tc, noise_is_estimated_where_nothing_rests, 0, 3);
    tcase_add_loop_test(tc, correlated_noise_keeps_its_size_and_is_reported, 0, 3);
    tcase_add_test(tc, given_noise_is_used_and_a_wrong_one_is_reported);
    tcase_add_loop_test(tc, noise_does_not_depend_on_the_sampling_rate, 0, 30);
    tcase_add_loop_test(tc, an_encoder_without_other_noise_has_that_of_its_step, 0, 10);
    tcase_add_loop_test(tc, noise_is_found_between_the_bounces_of_a_ball, 0, 3);
    tcase_add_loop_test(tc, a_noise_that_the_record_contradicts_is_reported_with_both_numbers, 0,
                        4);
    tcase_add_loop_test(tc, a_quantisation_step_is_found_again, 0, 9);
    tcase_add_test(tc, a_record_locked_to_its_pixels_is_reported);
    tcase_add_test(tc, the_way_between_two_samples_of_steady_motion_is_no_step);
    tcase_add_loop_test(tc, jitter_of_the_frames_is_measured, 0, 3);
    tcase_add_test(tc, dropped_frames_are_counted);
    tcase_add_test(tc, a_varying_rate_is_reported_and_is_no_gap);
    tcase_add_loop_test(tc, rests_and_the_first_motion_are_found, 0, 8);
    tcase_add_loop_test(tc, a_short_rest_is_enough_at_the_start, 0, 6);
    tcase_add_loop_test(tc, the_top_of_a_flight_is_no_rest, 0, 3);
    tcase_add_test(tc, a_trigger_that_does_not_fit_is_reported);
    tcase_add_test(tc, milliseconds_called_seconds_are_reported);
    tcase_add_test(tc, values_cut_off_are_counted);
    tcase_add_test(tc, spikes_and_missing_samples_are_counted);
    tcase_add_test(tc, a_stroke_that_contradicts_its_settings_is_refused);
    tcase_add_test(tc, the_audit_of_a_simulated_stroke_finds_nothing_wrong);
    tcase_add_test(tc, the_machine_axis_is_audited);
    tcase_add_test(tc, the_falling_balls_are_audited);
    tcase_add_test(tc, the_sensors_of_the_piano_are_audited);
    suite_add_tcase(suite, tc);
}
