/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_lab.c - the laboratory: equations from files, and strokes.
 *
 * Every test has its own cache folder; equations are kept from being built in by a structure
 * no model of the library has.
 */
#define CACHE_OF_ITS_OWN
#include "lab_support.h"

void lab_results_cases(Suite *suite);

static lab_stroke strike(const lab_model *model)
{
    stein_sim *sim = NULL;
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(lab_strike(sim, &def, &stroke, err));
    stein_sim_destroy(sim);
    return stroke;
}

static lab_stroke strike_stein(const char *set)
{
    lab_model *model = NULL;
    lab_options options = cache_here("no-compiler-needed");
    options.set = &set;
    options.nset = set != NULL;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    lab_stroke stroke = strike(model);
    lab_close(model);
    return stroke;
}

/* ---- equations ---- */

/* the same arm twice: in the plane, where bodies have poses, and turned out of it, where forces at
 * points go through Jacobians; a spring off the plane and a force with all three components */
static const char arm[] = "mechanism: arm\n"
                          "gravity: [0, 0, -9.81 m/s^2]\n"
                          "bodies:\n"
                          "  upper: {joint: R %s, mass: 1.3 kg, centre: %s, inertia: {%s: 0.021},\n"
                          "          points: {elbow: %s}}\n"
                          "  lower: {parent: upper, joint: R %s, at: upper.elbow, mass: 0.7 kg,\n"
                          "          centre: %s, inertia: {%s: 0.013}, points: {hand: %s}}\n"
                          "points: {post: %s}\n"
                          "links:\n"
                          "  tie: {from: frame.post, to: lower.hand, k: 90 N/m, length: 0.15 m,\n"
                          "        damping: 2.3 N s/m}\n"
                          "  brace: {from: upper.elbow, to: lower.hand, k: 31 N/m, length: 0.1 m}\n"
                          "inputs: {push: {force: lower.hand, direction: %s}}\n"
                          "outputs:\n"
                          "  up: {point: lower.hand, read: z}\n"
                          "  speed: {point: lower.hand, read: vz}\n";

static void two_newtons(void *ctx, double t, double u[3])
{
    (void)ctx;
    u[0] = 2.0 + t;
}

static lab_model *open_arm(int turned)
{
    char text[2000];
    const char *joint = turned ? "-x" : "y", *elbow = turned ? "xx" : "yy";
    snprintf(text, sizeof text, arm, joint,
             turned ? "[-0.01 m, 0.11 m, 0.02 m]" : "[0.11 m, 0.01 m, 0.02 m]", elbow,
             turned ? "[-0.03 m, 0.31 m, 0.04 m]" : "[0.31 m, 0.03 m, 0.04 m]", turned ? "x" : "-y",
             turned ? "[0.02 m, 0.13 m, -0.01 m]" : "[0.13 m, -0.02 m, -0.01 m]", elbow,
             turned ? "[-0.05 m, 0.27 m, 0.06 m]" : "[0.27 m, 0.05 m, 0.06 m]",
             turned ? "[-0.2 m, 0.1 m, -0.3 m]" : "[0.1 m, 0.2 m, -0.3 m]",
             turned ? "[-0.3, 0.6, -0.8]" : "[0.6, 0.3, -0.8]");
    return open_text(text, NULL, 0);
}

START_TEST(forces_at_points_are_the_same_by_pose_and_by_jacobian)
{
    static const double q[] = {0.37, -0.83}, qd[] = {1.9, -2.7};
    double qdd[2][2], up[2], speed[2];
    for (int turned = 0; turned < 2; turned++) {
        lab_model *model = open_arm(turned);
        const stein_model *m = lab_equations(model);
        ck_assert_int_eq(m->nframe, turned ? 0 : 2);
        stein_sim_def def = lab_def(model);
        stein_sim *sim;
        ck_assert_stein(lab_sim(model, &def, &sim, err));
        ck_assert_stein(stein_drive(sim, "push", two_newtons, NULL, err));
        ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
        ck_assert_stein(stein_acceleration(sim, 0.0, q, qd, qdd[turned], err));
        ck_assert_stein(stein_read_name(sim, "up", &up[turned], err));
        ck_assert_stein(stein_read_name(sim, "speed", &speed[turned], err));
        stein_sim_destroy(sim);
        lab_close(model);
    }
    ck_assert_close(qdd[0][0], qdd[1][0], 1e-13, 0.0);
    ck_assert_close(qdd[0][1], qdd[1][1], 1e-13, 0.0);
    ck_assert_close(up[0], up[1], 1e-14, 0.0);
    ck_assert_close(speed[0], speed[1], 1e-14, 0.0);
}
END_TEST

START_TEST(built_in_equations_take_the_values_of_the_file_without_a_compiler)
{
    const char *set[] = {"pawl.stop_shift=-0.3 mm", "load.mass=105g"};
    lab_options options = cache_here("no-compiler-needed");
    options.set = set;
    options.nset = 2;
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    const stein_model *m = lab_equations(model);
    ck_assert_ptr_eq((const void *)m->bodies, (const void *)stein_model_stein1788.bodies);
    int dx = stein_find_param(m, "pawl.stop_shift"), mass = stein_find_param(m, "load.mass");
    ck_assert_close(m->params[dx].value, -0.3e-3, 1e-15, 0.0);
    ck_assert_close(lab_parameters(model)[mass], 0.105, 1e-15, 0.0);
    stein_sim *sim = NULL;
    double value = 0.0;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(stein_get(sim, "load.mass", &value, err));
    ck_assert_close(value, 0.105, 1e-15, 0.0);
    ck_assert_close(lab_until(model), m->until, 0.0, 0.0);
    ck_assert(lab_def(model).dt == m->dt);
    stein_sim_destroy(sim);
    lab_close(model);
    lab_close(NULL);
}
END_TEST

START_TEST(other_equations_are_compiled_once_and_then_need_no_compiler)
{
    int n = 0;
    lab_close(open_text(falling, NULL, 0));
    char *object = cached(".so", &n);
    ck_assert_int_eq(n, 1);
    free(object);
    lab_options options = cache_here("no-such-compiler");
    lab_model *model = NULL;
    ck_assert_stein(lab_open(&model, in_folder("model.yaml"), &options, err));
    lab_close(model);

    // a number is no structure
    const char *set[] = {"hammer.mass=2.9 g"};
    options.set = set;
    options.nset = 1;
    ck_assert_stein(lab_open(&model, in_folder("model.yaml"), &options, err));
    ck_assert_close(lab_parameters(model)[stein_find_param(lab_equations(model), "hammer.mass")],
                    2.9e-3, 1e-15, 0.0);
    lab_close(model);
}
END_TEST

/* a compiler without vector types */
static const char *plain_compiler(void)
{
    return write_program("cc", "#!/bin/sh\n"
                               "for word; do\n"
                               "  case $word in -DSTEIN_LANES*) exit 1;; esac\n"
                               "done\n"
                               "exec cc \"$@\"\n");
}

/* runs from several states in lanes against the same ones alone */
static void compare_lanes(const stein_model *m, double until)
{
    enum { N = 5 };
    stein_sim *alone[N], *rider[N];
    stein_batch *batch = NULL;
    double t_end[N], q[8], qd[8];
    ck_assert_stein(stein_batch_create(&batch, m, NULL, N, 0, err));
    for (int i = 0; i < N; i++) {
        ck_assert_stein(stein_sim_create(&alone[i], m, NULL, err));
        ck_assert_stein(stein_sim_create(&rider[i], m, NULL, err));
        for (int j = 0; j < m->nq; j++) {
            q[j] = stein_q(alone[i])[j] + 1.3e-3 * i;
            qd[j] = 0.11 * i - 0.2 * j;
        }
        ck_assert_stein(stein_set_state(alone[i], 0.0, q, qd, err));
        ck_assert_stein(stein_set_state(rider[i], 0.0, q, qd, err));
        ck_assert_stein(stein_batch_put(batch, i, rider[i], err));
        t_end[i] = until + 1e-4 * i;
        ck_assert_stein(stein_run(alone[i], t_end[i], err));
    }
    ck_assert_stein(stein_batch_run(batch, t_end, NULL, err));
    for (int i = 0; i < N; i++) {
        size_t size = sizeof(double) * (size_t)m->nq;
        ck_assert(memcmp(stein_q(stein_batch_sim(batch, i)), stein_q(alone[i]), size) == 0);
        ck_assert(memcmp(stein_qd(rider[i]), stein_qd(alone[i]), size) == 0);
        stein_sim_destroy(alone[i]);
        stein_sim_destroy(rider[i]);
    }
    stein_batch_destroy(batch);
}

START_TEST(compiled_equations_have_lanes_where_the_compiler_can_make_them)
{
    int lanes = stein_batch_width(&stein_model_stein1788);
    lab_model *model = open_text(falling, NULL, 0);
    ck_assert_int_eq(stein_batch_width(lab_equations(model)), lanes);
    compare_lanes(lab_equations(model), 0.091); // behind the impact
    lab_close(model);
    for (int turned = 0; turned < 2; turned++) { // with links, which leave the plane once turned
        model = open_arm(turned);
        ck_assert_int_eq(stein_batch_width(lab_equations(model)), lanes);
        compare_lanes(lab_equations(model), 0.043);
        lab_close(model);
    }

    model = open_text(falling, NULL, 0);
    lab_close(model);
    int n = 0;
    char *object = NULL;
    while ((object = cached(".so", &n)) != NULL) {
        ck_assert_int_eq(unlink(object), 0);
        free(object);
    }
    lab_options options = cache_here(plain_compiler());
    ck_assert_stein(lab_open(&model, in_folder("model.yaml"), &options, err));
    ck_assert_int_eq(stein_batch_width(lab_equations(model)), 1);
    lab_close(model);
}
END_TEST

/* the program has equations with lanes under the same name, and they are not these */
START_TEST(compiled_equations_have_their_own_lanes_beside_built_in_ones_of_their_name)
{
    static const char *const set[] = {"key.centre.z=2.7 mm", "pawl.centre.y=1.3 mm"};
    lab_model *model = NULL;
    lab_options options = cache_here(NULL);
    options.set = set;
    options.nset = 2;
    ck_assert_stein(lab_open(&model, "models/stein1788.yaml", &options, err));
    const stein_model *m = lab_equations(model);
    ck_assert_str_eq(m->name, stein_model_stein1788.name);
    ck_assert_str_ne(m->equations, stein_model_stein1788.equations);
    ck_assert_int_eq(stein_batch_width(m), stein_batch_width(&stein_model_stein1788));
    for (int i = 0; i < 3; i++) {
        ck_assert(m->lanes[i] == NULL || m->lanes[i] != stein_model_stein1788.lanes[i]);
    }
    compare_lanes(m, 0.0023);
    lab_close(model);
}
END_TEST

START_TEST(an_override_that_changes_the_structure_makes_new_equations)
{
    const char *set[] = {"hammer.head.x=3.7 mm"};
    int n = 0;
    lab_model *plain = open_text(falling, NULL, 0), *changed = open_text(falling, set, 1);
    free(cached(".so", &n));
    ck_assert_int_eq(n, 2);
    ck_assert_str_ne(lab_equations(plain)->equations, lab_equations(changed)->equations);
    ck_assert_int_ge(stein_find_param(lab_equations(changed), "hammer.head.x"), 0);
    lab_close(plain);
    lab_close(changed);
}
END_TEST

START_TEST(damaged_or_foreign_objects_in_the_cache_are_made_again)
{
    const char *set[] = {"hammer.head.x=3.7 mm"};
    int n = 0;
    lab_close(open_text(falling, NULL, 0));
    char *object = cached(".so", &n);
    FILE *f = fopen(object, "w");
    fputs("no object at all", f);
    fclose(f);
    lab_close(open_text(falling, NULL, 0));

    // the equations of another structure under this name
    char *kept = lab__text("%s-kept", object);
    ck_assert_int_eq(rename(object, kept), 0);
    lab_close(open_text(falling, set, 1));
    char *other = cached(".so", &n);
    ck_assert_int_eq(n, 1);
    ck_assert_int_eq(rename(other, object), 0);
    lab_model *model = open_text(falling, NULL, 0);
    ck_assert_int_lt(stein_find_param(lab_equations(model), "hammer.head.x"), 0);
    lab_close(model);
    free(object);
    free(kept);
    free(other);
}
END_TEST

START_TEST(without_a_compiler_the_message_names_the_remedy)
{
    lab_model *model = NULL;
    stein_err err = {STEIN_OK, ""};
    const char *file = write_file("model.yaml", falling);
    lab_options options = cache_here("no-such-compiler");
    ck_assert_int_eq(lab_open(&model, file, &options, &err), STEIN_ECOMPILE);
    ck_assert_int_eq(err.code, STEIN_ECOMPILE);
    ck_assert_msg(strstr(err.msg, "apt-get install gcc") != NULL, "%s", err.msg);
    ck_assert_msg(strstr(err.msg, "no-such-compiler") != NULL, "%s", err.msg);
    ck_assert_ptr_null(model);
    options.cc = "false --whatever";
    ck_assert_int_eq(lab_open(&model, file, &options, &err), STEIN_ECOMPILE);
    ck_assert_msg(strstr(err.msg, "exit code 1") != NULL, "%s", err.msg);
    ck_assert_ptr_null(model);
}
END_TEST

START_TEST(a_cache_that_cannot_be_written_is_an_io_error)
{
    lab_model *model = NULL;
    stein_err err = {STEIN_OK, ""};
    lab_options options = cache_here(NULL);
    options.cache = write_file("occupied", "a file, no folder");
    ck_assert_int_eq(lab_open(&model, write_file("model.yaml", falling), &options, &err),
                     STEIN_EIO);
    ck_assert_msg(strstr(err.msg, "occupied") != NULL, "%s", err.msg);
}
END_TEST

static void count_message(void *ctx, const char *message)
{
    ck_assert_ptr_nonnull(strstr(message, "model.yaml:"));
    ++*(int *)ctx;
}

START_TEST(files_and_overrides_that_are_not_in_order_are_refused)
{
    lab_model *model = NULL;
    stein_err err = {STEIN_OK, ""};
    const char *set[] = {"hammer.mass"};
    int problems = 0;
    lab_options options = cache_here(NULL);
    options.report = count_message;
    options.ctx = &problems;
    ck_assert_int_eq(lab_open(&model, in_folder("absent.yaml"), NULL, &err), STEIN_EIO);
    const char *file =
        write_file("model.yaml", "mechanism: x\nbodies: {a: {joint: Q y, mas: 1}}\n");
    ck_assert_int_eq(lab_open(&model, file, &options, &err), STEIN_EPARSE);
    ck_assert_int_ge(problems, 2);
    options.set = set;
    options.nset = 1;
    ck_assert_int_eq(lab_open(&model, file, &options, &err), STEIN_EINVAL);
    ck_assert_ptr_null(model);
}
END_TEST

/* ---- strokes ---- */

START_TEST(outcomes_follow_the_position_of_the_stop)
{
    lab_stroke s = strike_stein(NULL);
    ck_assert_str_eq(lab_outcome_text(s.outcome), "struck");
    ck_assert(s.escaped && s.impacts >= 1 && s.rearmed && !s.forced_escapement);
    ck_assert(s.free_flight == s.impact_time - s.escape_time && s.free_flight > 0.0);
    s = strike_stein("pawl.stop_shift=-2.5 mm");
    ck_assert_str_eq(lab_outcome_text(s.outcome), "missed_notch");
    ck_assert(!s.escaped && isnan(s.escape_time) && isnan(s.escape_height));
    s = strike_stein("pawl.stop_shift=1 mm");
    ck_assert_str_eq(lab_outcome_text(s.outcome), "no_escapement");
    ck_assert(!s.escaped && s.free_flight == 0.0);
    s = strike_stein("string.height=0.3 m");
    ck_assert_str_eq(lab_outcome_text(s.outcome), "no_impact");
    ck_assert(s.escaped && s.impacts == 0 && isnan(s.impact_time) && isnan(s.impact_speed));
    ck_assert(s.peak_string_force == 0.0);
}
END_TEST

START_TEST(speed_and_force_of_a_falling_weight_are_those_of_closed_form)
{
    lab_model *model = open_text(falling, NULL, 0);
    lab_stroke s = strike(model);
    double m = 3.1e-3, c = 11.7e3, h = 37e-3, g = 9.81, v = sqrt(2.0 * g * h);
    ck_assert_int_eq(s.outcome, LAB_STRUCK);
    ck_assert_int_eq(s.impacts, 1);
    ck_assert_close(s.blow, h, 1e-12, 0.0);
    ck_assert_close(s.impact_time, v / g, 1e-9, 0.0);
    ck_assert_close(s.impact_speed, v, 1e-9, 0.0);
    ck_assert_close(s.peak_string_force, m * g + sqrt(m * g * m * g + c * m * v * v), 1e-6, 0.0);
    ck_assert(!s.escaped && s.free_flight == 0.0 && !s.rearmed);
    lab_close(model);
}
END_TEST

/* state and results of a stroke with a recording on the side */
static stein_status count_sample(void *ctx, stein_sim *sim)
{
    (void)sim;
    ++*(int *)ctx;
    return STEIN_OK;
}

START_TEST(sampling_changes_nothing)
{
    lab_model *model = open_text(falling, NULL, 0);
    lab_stroke plain = strike(model), sampled;
    stein_sim *sim = NULL;
    int samples = 0;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    def.sample = count_sample;
    def.ctx = &samples;
    def.every = 1.7e-3;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(lab_strike(sim, &def, &sampled, err));
    ck_assert_int_eq(samples, 72); // 0, 1.7, ..., 119 ms and the end
    ck_assert(memcmp(&plain.impact_time, &sampled.impact_time, sizeof(double)) == 0);
    ck_assert(memcmp(&plain.peak_string_force, &sampled.peak_string_force, sizeof(double)) == 0);
    ck_assert(stein_time(sim) == 0.12);
    samples = 0;
    def.every = 0.0;
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert_int_eq(samples, 12001);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

/* an event's time, and what it was */
typedef struct told {
    int events, impacts;
    double impact;
} told;

static void note_told(void *ctx, stein_sim *sim, const stein_event *event)
{
    told *n = ctx;
    (void)sim;
    n->events++;
    if (event->kind == STEIN_EVENT_IMPACT && n->impacts++ == 0) {
        n->impact = event->time;
    }
}

START_TEST(events_of_runs_and_strokes_are_reported)
{
    lab_model *model = open_text(falling, NULL, 0);
    stein_sim *sim = NULL;
    lab_stroke stroke;
    told judged = {0, 0, 0.0}, plain = {0, 0, 0.0};
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    def.event = note_told;
    def.ctx = &judged;
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    ck_assert_stein(lab_strike(sim, &def, &stroke, err));
    ck_assert_int_eq(judged.impacts, stroke.impacts);
    ck_assert(judged.impact == stroke.impact_time && judged.events > judged.impacts);
    def.ctx = &plain;
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert(plain.events == judged.events && plain.impact == judged.impact);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(numbers_of_a_record_are_its_rows)
{
    lab_model *model = open_text(falling, NULL, 0);
    stein_sim *sim = NULL;
    lab_record *record = NULL;
    int rows, n = lab_equations(model)->nchannel;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    ck_assert_stein(lab_record_create(&record, lab_equations(model), 2.3e-3, err));
    ck_assert_stein(lab_sim(model, NULL, &sim, err));
    def.sample = lab_record_sample;
    def.ctx = record;
    ck_assert_stein(lab_simulate(sim, &def, err));
    const double *x = lab_record_numbers(record, &rows);
    ck_assert_int_eq(rows, lab__record_rows(record));
    for (int i = 0; i < rows * n; i++) {
        ck_assert(x[i] == lab__record_at(record, i / n, i % n));
    }
    lab_record_destroy(record);
    stein_sim_destroy(sim);
    lab_close(model);
}
END_TEST

START_TEST(quantities_have_the_units_of_mechanism_files)
{
    double x = 1.7;
    stein_err why;
    ck_assert_stein(lab_quantity(&x, "-0.3 mm", "m", err));
    ck_assert(x == -0.3e-3);
    ck_assert_stein(lab_quantity(&x, "2.5e-4", "N m s/rad", err));
    ck_assert(x == 2.5e-4);
    ck_assert_int_eq(lab_quantity(&x, "3 mm", "kg", &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "the unit is m, expected kg"));
    ck_assert_int_eq(lab_quantity(&x, "three", "kg", &why), STEIN_EINVAL);
    ck_assert_ptr_nonnull(strstr(why.msg, "three"));
    ck_assert_int_eq(lab_quantity(&x, "3", "stone", &why), STEIN_EINVAL);
    ck_assert_str_eq(why.msg, "\"stone\" is no unit");
    ck_assert(x == 2.5e-4);
}
END_TEST

START_TEST(a_stroke_leaves_the_simulation_at_its_end)
{
    stein_sim *one = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_sim *two = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    lab_stroke s;
    lab_stroke_def def = lab_stroke_def_default(&stein_model_stein1788);
    def.until = 0.08;
    ck_assert_stein(lab_strike(one, &def, &s, err));
    ck_assert_stein(stein_run(two, 0.08, err));
    ck_assert_int_eq(stein_load_present(one), 1);
    ck_assert(memcmp(stein_q(one), stein_q(two), 4 * sizeof(double)) == 0);
    ck_assert(memcmp(stein_qd(one), stein_qd(two), 4 * sizeof(double)) == 0);
    stein_sim_destroy(one);
    stein_sim_destroy(two);
}
END_TEST

/* on the side the motion ends when nothing moves any more */
START_TEST(rearming_is_the_same_with_the_release_in_the_run_or_on_the_side)
{
    static const double dx[] = {0.0, -0.9e-3, -2e-3}, k[] = {0.03224, 0.01, 0.005};
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    lab_stroke aside, inside;
    lab_stroke_def def = lab_stroke_def_default(&stein_model_stein1788);
    for (int i = 0; i < 3; i++) {
        ck_assert_stein(stein_set(sim, "pawl.stop_shift", dx[i], err));
        ck_assert_stein(stein_set(sim, "pawl.spring.k", k[i], err));
        ck_assert_stein(stein_reset(sim, err));
        def.until = 0.25;
        def.release = NAN;
        ck_assert_stein(lab_strike(sim, &def, &aside, err));
        ck_assert_int_eq(stein_load_present(sim), 1);
        ck_assert(stein_time(sim) == 0.25);
        ck_assert_stein(stein_reset(sim, err));
        def.until = 0.75;
        def.release = 0.25;
        ck_assert_stein(lab_strike(sim, &def, &inside, err));
        ck_assert_int_eq(stein_load_present(sim), 0);
        ck_assert_int_eq(aside.rearmed, i < 2);
        ck_assert_int_eq(inside.rearmed, i < 2);
        ck_assert(aside.impacts == inside.impacts);
        ck_assert(aside.impacts == 0 || aside.impact_time == inside.impact_time);
    }
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", dx[0], err));
    ck_assert_stein(stein_set(sim, "pawl.spring.k", k[0], err));
    ck_assert_stein(stein_reset(sim, err));
    def.until = 0.251; // not back yet
    ck_assert_stein(lab_strike(sim, &def, &inside, err));
    ck_assert(!inside.rearmed);
    stein_sim_destroy(sim);
}
END_TEST

static stein_status refuse_sample(void *ctx, stein_sim *sim)
{
    (void)ctx;
    return stein_time(sim) > 1e-3 ? STEIN_EIO : STEIN_OK;
}

START_TEST(invalid_definitions_of_a_stroke_are_refused_with_the_reason)
{
    stein_err err = {STEIN_OK, ""};
    lab_stroke s;
    stein_sim *stein = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_sim *pendulum = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    lab_stroke_def def = lab_stroke_def_default(&stein_model_pendulum);
    ck_assert_int_eq(lab_strike(pendulum, &def, &s, &err), STEIN_EINVAL);
    ck_assert_msg(strstr(err.msg, "stroke") != NULL, "%s", err.msg);
    def.release = 0.1;
    ck_assert_int_eq(lab_simulate(pendulum, &def, &err), STEIN_EINVAL);
    ck_assert_msg(strstr(err.msg, "load") != NULL, "%s", err.msg);
    def.until = 0.05;
    ck_assert_int_eq(lab_strike(stein, &def, &s, &err), STEIN_EINVAL);
    ck_assert_msg(strstr(err.msg, "release") != NULL, "%s", err.msg);
    def.until = NAN;
    ck_assert_int_eq(lab_strike(stein, &def, &s, &err), STEIN_EINVAL);
    def = (lab_stroke_def){.until = 0.01, .release = NAN, .every = -1.0};
    ck_assert_int_eq(lab_strike(stein, &def, &s, &err), STEIN_EINVAL);
    def = (lab_stroke_def){.until = 0.01, .release = NAN, .sample = refuse_sample};
    ck_assert_int_eq(lab_strike(stein, &def, &s, &err), STEIN_EIO);
    stein_sim_destroy(stein);
    stein_sim_destroy(pendulum);
}
END_TEST

Suite *lab_suite(void)
{
    Suite *suite = suite_create("lab");
    TCase *tc = tcase_create("lab");
    tcase_set_timeout(tc, 120.0);
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_add_test(tc, forces_at_points_are_the_same_by_pose_and_by_jacobian);
    tcase_add_test(tc, built_in_equations_take_the_values_of_the_file_without_a_compiler);
    tcase_add_test(tc, other_equations_are_compiled_once_and_then_need_no_compiler);
    tcase_add_test(tc, compiled_equations_have_lanes_where_the_compiler_can_make_them);
    tcase_add_test(tc, compiled_equations_have_their_own_lanes_beside_built_in_ones_of_their_name);
    tcase_add_test(tc, an_override_that_changes_the_structure_makes_new_equations);
    tcase_add_test(tc, damaged_or_foreign_objects_in_the_cache_are_made_again);
    tcase_add_test(tc, without_a_compiler_the_message_names_the_remedy);
    tcase_add_test(tc, a_cache_that_cannot_be_written_is_an_io_error);
    tcase_add_test(tc, files_and_overrides_that_are_not_in_order_are_refused);
    tcase_add_test(tc, outcomes_follow_the_position_of_the_stop);
    tcase_add_test(tc, speed_and_force_of_a_falling_weight_are_those_of_closed_form);
    tcase_add_test(tc, sampling_changes_nothing);
    tcase_add_test(tc, events_of_runs_and_strokes_are_reported);
    tcase_add_test(tc, numbers_of_a_record_are_its_rows);
    tcase_add_test(tc, quantities_have_the_units_of_mechanism_files);
    tcase_add_test(tc, a_stroke_leaves_the_simulation_at_its_end);
    tcase_add_test(tc, rearming_is_the_same_with_the_release_in_the_run_or_on_the_side);
    tcase_add_test(tc, invalid_definitions_of_a_stroke_are_refused_with_the_reason);
    suite_add_tcase(suite, tc);
    lab_results_cases(suite);
    return suite;
}
