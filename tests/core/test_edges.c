/* SPDX-License-Identifier: MIT
 * test_edges.c - the core at its edges: states that were forged, models that do not fit, memory
 * that ends, a failure in the middle of a step. Each is reported, and changes nothing.
 */
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core.h"
#include "stein/handover.h"
#include "stein/load.h"
#include "stein/models.h"
#include "stein/sensitivity.h"
#include "support.h"

static void said(const stein_err *err, stein_status code, const char *words)
{
    ck_assert_int_eq(err->code, code);
    ck_assert_msg(strstr(err->msg, words) != NULL, "%s, expected \"%s\"", err->msg, words);
}

/* ---- states from outside ---- */

/* values that no simulation writes, with a correct checksum */
static void forge(stein_sim *sim, int what)
{
    switch (what) {
    case 0: sim->head->t = (double)NAN; break;
    case 1: sim->head->t0 = (double)INFINITY; break;
    case 2: sim->head->step = -1; break;
    case 3: sim->head->load_present = 2; break;
    case 4: sim->head->load_present = -1; break;
    case 5: sim->q[3] = (double)INFINITY; break;
    case 6: sim->qd[0] = (double)NAN; break;
    case 7: sim->rest[1] = (double)NAN; break;
    case 8: sim->mode[sim->nguard - 1] = 2; break;
    case 9: sim->phase[0] = 5; break;
    case 10: sim->engaged[0] = 2; break;
    default: sim->held[2] = 2; break;
    }
}
enum { FORGERIES = 12 };

START_TEST(a_forged_state_is_refused_and_changes_nothing)
{
    stein_sim *forged = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    size_t size = stein_state_size(sim);
    unsigned char *block = malloc(size), *before = malloc(size), *after = malloc(size);
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(stein_run(sim, 0.0023, err));
    ck_assert_stein(stein_run(forged, 0.0011, err));
    stein_save(sim, before);
    forge(forged, _i);
    stein_save(forged, block);
    ck_assert_int_eq(stein_restore_from(sim, block, size, &why), STEIN_EINVAL);
    said(&why, STEIN_EINVAL, "the saved state of \"stein1788\" is damaged");
    stein_save(sim, after);
    ck_assert(memcmp(before, after, size) == 0);
    free(block);
    free(before);
    free(after);
    stein_sim_destroy(sim);
    stein_sim_destroy(forged);
}
END_TEST

START_TEST(a_state_without_its_load_is_taken)
{
    stein_sim *lifted = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    unsigned char *block = malloc(stein_state_size(sim));
    stein_load_lift(lifted);
    stein_save(lifted, block);
    ck_assert_stein(stein_restore(sim, block, err));
    ck_assert_int_eq(stein_load_present(sim), 0);
    free(block);
    stein_sim_destroy(sim);
    stein_sim_destroy(lifted);
}
END_TEST

/* ---- models that do not fit ---- */

/* a shared object with three models, none of which can move; @return its file */
static const char *compile_models(const char *folder)
{
    static char file[64];
    char source[64], command[300];
    const char *cc = getenv("CC");
    snprintf(source, sizeof source, "%s/m.c", folder);
    snprintf(file, sizeof file, "%s/m.so", folder);
    FILE *f = fopen(source, "w");
    ck_assert_ptr_nonnull(f);
    fprintf(f, "#include \"stein/model.h\"\n"
               "const stein_model stein_model_old = {.abi = STEIN_MODEL_ABI - 1, .equations = "
               "\"aa11\"};\n"
               "const stein_model stein_model_fine = {.abi = STEIN_MODEL_ABI, .equations = "
               "\"bb22\"};\n");
    fclose(f);
    snprintf(command, sizeof command, "%s -std=c11 -Iinclude -shared -fPIC -o %s %s",
             cc != NULL && *cc != '\0' ? cc : "cc", file, source);
    ck_assert_int_eq(system(command), 0);
    unlink(source);
    return file;
}

START_TEST(equations_of_another_layout_or_mechanism_are_not_called)
{
    char folder[] = "/tmp/stein-edges-XXXXXX";
    ck_assert_ptr_nonnull(mkdtemp(folder));
    const char *file = compile_models(folder);
    stein_library *library = NULL;
    const stein_model *model = NULL;
    stein_err why;
    ck_assert_int_eq(stein_library_open(&library, file, "none", NULL, &model, &why), STEIN_ELOAD);
    said(&why, STEIN_ELOAD, "m.so has no symbol \"stein_model_none\"");
    ck_assert_int_eq(stein_library_open(&library, file, "old", NULL, &model, &why), STEIN_ESTALE);
    said(&why, STEIN_ESTALE, "m.so holds equations aa11 of layout ");
    said(&why, STEIN_ESTALE, "expected any of layout ");
    ck_assert_int_eq(stein_library_open(&library, file, "fine", "cc33", &model, &why),
                     STEIN_ESTALE);
    said(&why, STEIN_ESTALE, "m.so holds equations bb22");
    said(&why, STEIN_ESTALE, "expected cc33");
    ck_assert_ptr_null(library);
    ck_assert_ptr_null(model);
    for (int i = 0; i < 2; i++) {
        const char *equations = i == 0 ? "bb22" : NULL;
        ck_assert_stein(stein_library_open(&library, file, "fine", equations, &model, err));
        ck_assert_str_eq(model->equations, "bb22");
        stein_library_close(library);
    }
    unlink(file);
    ck_assert_int_eq(rmdir(folder), 0);
}
END_TEST

/* equations whose joint begins nowhere */
static void begin_nowhere(const double *p, double *d, const stein_functions *f)
{
    stein_model_falling_ball.setup(p, d, f);
    d[stein_model_falling_ball.initial] = (double)NAN;
}

START_TEST(an_impossible_start_makes_no_simulation)
{
    stein_model model = stein_model_falling_ball;
    stein_sim_def def = stein_sim_def_default(&model);
    stein_sim *sim = NULL;
    stein_err why;
    int live = 0;
    def.ctx = &live;
    def.alloc = count_alloc;
    def.release = count_release;
    model.setup = begin_nowhere;
    ck_assert_int_eq(stein_sim_create(&sim, &model, &def, &why), STEIN_ENONFINITE);
    said(&why, STEIN_ENONFINITE, "the initial state of joint \"ball\" is not finite");
    def.release = NULL;
    ck_assert_int_eq(stein_sim_create(&sim, &model, &def, &why), STEIN_EINVAL);
    said(&why, STEIN_EINVAL, "stein_sim_def.release is NULL");
    def.alloc = NULL;
    ck_assert_int_eq(stein_sim_create(&sim, &model, &def, &why), STEIN_EINVAL);
    said(&why, STEIN_EINVAL, "stein_sim_def.alloc is NULL");
    ck_assert_ptr_null(sim);
    ck_assert_int_eq(live, 0);
}
END_TEST

/* ---- memory ---- */

/* an allocator with room for so many blocks */
typedef struct purse {
    int left, live;
} purse;

static void *spend(void *ctx, size_t size)
{
    purse *p = ctx;
    if (p->left-- <= 0) {
        return NULL;
    }
    p->live++;
    return malloc(size);
}

static void give_back(void *ctx, void *block)
{
    ((purse *)ctx)->live--;
    free(block);
}

START_TEST(failing_memory_is_reported_and_blocks_are_freed)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    purse p = {0, 0};
    stein_handover *handover = NULL;
    stein_sensitivity *s = NULL;
    stein_err why;
    def.ctx = &p;
    def.alloc = spend;
    def.release = give_back;
    ck_assert_int_eq(stein_handover_create(&handover, model, &def, &why), STEIN_ENOMEM);
    said(&why, STEIN_ENOMEM, "out of memory for a hand-over of \"stein1788\"");
    int blocks = 0;
    for (; s == NULL; blocks++) { // one more block each time
        p = (purse){blocks, 0};
        stein_status status = stein_sensitivity_create(&s, model, &def, 3, &why);
        ck_assert_int_eq(status, s != NULL ? STEIN_OK : STEIN_ENOMEM);
        if (s == NULL) {
            said(&why, STEIN_ENOMEM, "out of memory for ");
            ck_assert_int_eq(p.live, 0);
        }
    }
    ck_assert_int_ge(blocks, 3); // of its derivatives, and its own
    stein_sensitivity_destroy(s);
    ck_assert_int_eq(p.live, 0);
    ck_assert_ptr_null(handover);
}
END_TEST

/* ---- in the middle of a step ---- */

/* a hook without a number in an instant so short that only a step which ends there meets it */
static void fail_at(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)q, (void)qd;
    if (fabs(t - *(const double *)ctx) < 1e-10) {
        Q[0] = (double)NAN;
    }
}

/* when the ball meets the floor [s], as the same method finds it */
static void note_begin(void *ctx, stein_sim *sim, const stein_event *event)
{
    (void)sim;
    double *t = ctx;
    if (event->kind == STEIN_EVENT_CONTACT_BEGIN && *t < 0.0) {
        *t = event->time;
    }
}

static stein_status fall(stein_sim *sim, stein_pace *pace, stein_err *err)
{
    return pace != NULL ? stein_run_adaptive(sim, 0.3, pace, err) : stein_run(sim, 0.3, err);
}

START_TEST(a_failure_where_an_event_is_ends_the_run_there)
{
    const stein_model *model = &stein_model_bouncing_ball;
    stein_sim *sim = make_sim(model, STEIN_DP5, 0.7e-3);
    stein_pace paces[2] = {{.tolerance = 1e-7, .longest = 0.013, .h = 1e-3}}, *pace = NULL;
    paces[1] = paces[0];
    double t = -1.0;
    stein_err why;
    stein_on_event(sim, note_begin, &t);
    pace = _i ? &paces[0] : NULL;
    ck_assert_int_eq(fall(sim, pace, &why), STEIN_OK);
    ck_assert_close(t, sqrt(2.0 * 0.25 / 9.81), 1e-6, 0.0);
    ck_assert_stein(stein_reset(sim, err));
    stein_on_force(sim, fail_at, &t);
    pace = _i ? &paces[1] : NULL;
    ck_assert_int_eq(fall(sim, pace, &why), STEIN_ENONFINITE);
    said(&why, STEIN_ENONFINITE, "the force hook gives joint \"ball\" no finite force");
    ck_assert(stein_time(sim) < t && stein_time(sim) > t - 0.02);
    ck_assert(isfinite(stein_q(sim)[0]) && isfinite(stein_qd(sim)[0]));
    stein_on_force(sim, NULL, NULL); // and it goes on where the trouble is over
    ck_assert_int_eq(fall(sim, pace, &why), STEIN_OK);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_pace_has_a_tolerance_a_longest_step_and_a_first_one)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_DP5, 0.0);
    stein_err why;
    for (int i = 0; i < 6; i++) {
        stein_pace pace = {.tolerance = 1e-7, .longest = 1e-3, .h = 1e-5};
        double *field[] = {&pace.tolerance, &pace.longest, &pace.h};
        *field[i / 2] = i % 2 ? (double)NAN : 0.0;
        ck_assert_int_eq(stein_run_adaptive(sim, 0.1, &pace, &why), STEIN_EINVAL);
        said(&why, STEIN_EINVAL, "tolerance ");
        said(&why, STEIN_EINVAL, "have to be positive");
        ck_assert(stein_time(sim) == 0.0);
    }
    stein_sim_destroy(sim);
}
END_TEST

/* a force that is another one each time it is asked, in however short a step */
static void shake(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)t, (void)q, (void)qd;
    Q[0] += 1e14 * noise(ctx);
}

START_TEST(a_tolerance_that_no_step_can_hold_is_reported)
{
    unsigned long long seed = 61;
    stein_sim *sim = make_sim(&stein_model_double_pendulum, STEIN_DP5, 0.0);
    stein_pace pace = {.tolerance = 5e-324, .longest = 1e-3, .h = 1e-3};
    stein_err why;
    stein_on_force(sim, shake, &seed);
    ck_assert_int_eq(stein_run_adaptive(sim, 0.1, &pace, &why), STEIN_ENONFINITE);
    said(&why, STEIN_ENONFINITE, "no step is short enough at t = 0 s");
    ck_assert(stein_time(sim) == 0.0);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- sensitivities ---- */

START_TEST(a_direction_that_is_not_there_has_no_sensitivity)
{
    stein_sim *sim = make_sim(&stein_model_pendulum, STEIN_RK4, 0.0);
    stein_sensitivity *s = NULL;
    double dp[64] = {1.0};
    stein_err why = {STEIN_OK, ""};
    ck_assert_int_le(stein_model_pendulum.np, 64);
    ck_assert_stein(stein_sensitivity_create(&s, &stein_model_pendulum, NULL, 2, err));
    ck_assert_int_eq(stein_sensitivity_start(s, 0, dp, &why), STEIN_EINVAL); // nothing is ridden
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    for (int k = -1; k <= 2; k += 3) {
        stein_sensitivity_set(s, k, stein_q(sim), NULL, NULL); // no memory of others is written
        ck_assert_ptr_null(stein_sensitivity_q(s, k));
        ck_assert_ptr_null(stein_sensitivity_qd(s, k));
        ck_assert(stein_sensitivity_switch(s, k) == 0.0);
        ck_assert_int_eq(stein_sensitivity_start(s, k, dp, &why), STEIN_EINVAL);
        said(&why, STEIN_EINVAL, "expected one of 2");
    }
    ck_assert_int_eq(stein_sensitivity_start(s, 1, NULL, &why), STEIN_EINVAL);
    ck_assert_stein(stein_sensitivity_start(s, 1, dp, err));
    ck_assert_stein(stein_sensitivity_check(s, err));
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(an_error_is_reported_until_another_simulation_is_followed)
{
    stein_sim *sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 0.0);
    stein_sensitivity *s = NULL;
    double t = -1.0;
    stein_err why = {STEIN_OK, ""};
    ck_assert_stein(stein_sensitivity_create(&s, &stein_model_bouncing_ball, NULL, 1, err));
    stein_on_force(sim, fail_at, &t);
    ck_assert_int_eq(stein_sensitivity_attach(s, sim, NULL), STEIN_EINVAL); // a hook has no slope
    ck_assert_int_eq(stein_sensitivity_attach(s, sim, &why), STEIN_EINVAL);
    said(&why, STEIN_EINVAL, "a force hook has no derivative");
    stein_on_force(sim, NULL, NULL);
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    stein_on_force(sim, fail_at, &t); // while it rides
    ck_assert_stein(stein_run(sim, 0.3, err));
    ck_assert_int_eq(stein_sensitivity_check(s, NULL), STEIN_EINVAL);
    ck_assert_int_eq(stein_sensitivity_check(s, &why), STEIN_EINVAL);
    said(&why, STEIN_EINVAL, "a force hook has no derivative");
    stein_sim_destroy(sim);
    sim = make_sim(&stein_model_bouncing_ball, STEIN_RK4, 0.0);
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    ck_assert_stein(stein_sensitivity_check(s, err));
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(an_indifferent_equilibrium_moves_with_nothing)
{
    stein_model model = stein_model_falling_ball; // weightless, it rests wherever it is
    stein_sensitivity *s = NULL;
    stein_sim *sim = NULL;
    double dp[64] = {1.0};
    stein_err why;
    ck_assert_int_le(model.np, 64);
    ck_assert_stein(stein_sim_create(&sim, &model, NULL, err));
    ck_assert_stein(stein_set(sim, "gravity.z", 0.0, err));
    model.settle = 1;
    ck_assert_stein(stein_reset(sim, err));
    ck_assert_stein(stein_sensitivity_create(&s, &model, NULL, 1, err));
    ck_assert_stein(stein_sensitivity_attach(s, sim, err));
    ck_assert_int_eq(stein_sensitivity_start(s, 0, dp, &why), STEIN_ESINGULAR);
    said(&why, STEIN_ESINGULAR, "\"falling_ball\": the equilibrium is indifferent");
    stein_sensitivity_destroy(s);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- small things ---- */

START_TEST(a_system_without_a_solution_is_not_divided_by)
{
    double A[4] = {1.7, 0.3, 3.4, 0.6}, b[2] = {1.0, 2.0};
    int pivot[2];
    ck_assert_int_eq(stein__solve_general(2, A, pivot, b), -1);
    double M[4] = {1.0, 2.0, 2.0, 4.0}, inverse[2];
    const int parent[2] = {-1, 0};
    ck_assert_int_eq(stein__factor(2, parent, M, inverse), 0); // joint 0 keeps no digit
}
END_TEST

START_TEST(a_message_is_one_line_that_ends_in_time)
{
    stein_err why;
    char name[2 * sizeof why.msg];
    memset(name, 'x', sizeof name);
    name[sizeof name - 1] = '\0';
    name[0] = '\033';
    name[1] = '\n';
    name[2] = 127;
    stein__fail(&why, STEIN_ENAME, "\"%s\" %d", name, -4711);
    ck_assert_int_eq(strncmp(why.msg, "\"???xxx", 7), 0);
    ck_assert_uint_eq(strlen(why.msg), sizeof why.msg - 1);
    stein__fail(&why, STEIN_ENAME, "%g %g %g", 2.5e-300, -7.25e300, 1e23);
    ck_assert_str_eq(why.msg, "2.5e-300 -7.25e300 1e23");
}
END_TEST

/* a hammer with a mass matrix that its equations cannot solve */
static void lose_mass(stein_sim *sim)
{
    ck_assert_stein(stein_set(sim, "hammer.mass", 0.0, err));
    ck_assert_stein(stein_set(sim, "hammer.inertia.yy", 0.0, err));
}

START_TEST(a_reading_without_forces_is_no_number)
{
    stein_sim *sim = make_sim(&stein_model_stein1788, STEIN_RK4, 0.0);
    double x = 4711.0, xdot = 4711.0;
    int ncontact = stein_model_stein1788.ncontact, nnotch = stein_model_stein1788.nnotch;
    ck_assert_int_eq(stein_deformation(sim, -1, &x, &xdot), 0);
    ck_assert_int_eq(stein_deformation(sim, ncontact + nnotch, &x, &xdot), 0);
    ck_assert(x == 4711.0 && xdot == 4711.0);
    ck_assert_int_eq(stein_touches(sim, -1), 0);
    ck_assert_int_eq(stein_touches(sim, ncontact), 0);
    ck_assert_int_eq(stein_notch_armed(sim, -1), 0);
    ck_assert_int_eq(stein_notch_armed(sim, nnotch), 0);
    ck_assert_int_eq(stein_notch_armed(sim, 0), 1);
    int height = stein_find_channel(&stein_model_stein1788, "hammer_height");
    int force = stein_find_channel(&stein_model_stein1788, "notch_force");
    lose_mass(sim);
    ck_assert_ptr_null(stein_qdd(sim));
    ck_assert(isnan(stein_read(sim, force)));
    ck_assert(isfinite(stein_read(sim, height))); // a place is seen without forces
    ck_assert_int_eq(stein_notch_armed(sim, 0), 0);
    stein_sim_destroy(sim);
}
END_TEST

/* ---- places of a batch ---- */

START_TEST(failing_runs_of_a_batch_have_a_status_each_and_the_first_a_message)
{
    enum { PLACES = 3 };
    const stein_model *model = &stein_model_stein1788;
    stein_sim_def def = stein_sim_def_default(model);
    stein_batch *batch = NULL;
    stein_sim *sim[PLACES];
    stein_pace pace[PLACES];
    stein_status status[PLACES];
    static const stein_status expected[PLACES] = {STEIN_OK, STEIN_ENONFINITE, STEIN_ESINGULAR};
    unsigned long long seed = 67;
    double t_end[PLACES];
    stein_err why;
    def.integrator = STEIN_DP5;
    ck_assert_stein(stein_batch_create(&batch, model, &def, PLACES, 0, err));
    for (int i = 0; i < PLACES; i++) {
        sim[i] = make_sim(model, STEIN_DP5, 0.0);
        pace[i] = (stein_pace){.tolerance = i ? 5e-324 : 1e-6, .longest = 1e-3, .h = 1e-5};
        t_end[i] = 0.001;
        ck_assert_stein(stein_batch_put(batch, i, sim[i], err));
    }
    stein_on_force(stein_batch_sim(batch, 1), shake, &seed);
    lose_mass(stein_batch_sim(batch, 2));
    ck_assert_int_eq(stein_batch_run_adaptive(batch, t_end, pace, status, &why), STEIN_ENONFINITE);
    said(&why, STEIN_ESINGULAR, "joint \"hammer\""); // known before a step is tried
    for (int i = 0; i < PLACES; i++) {
        ck_assert_int_eq(status[i], expected[i]);
    }
    ck_assert(stein_time(stein_batch_look(batch, 0)) == 0.001);

    // the same from place to place; without a message if err is NULL
    pace[1].h = 1e-5;
    ck_assert_stein(stein_batch_begin(batch, 1, 0.002, &pace[1], err));
    ck_assert_int_eq(stein_batch_go(batch, status, NULL), 1);
    ck_assert_int_eq(status[0], STEIN_ENONFINITE);
    pace[1].h = 1e-5;
    ck_assert_stein(stein_batch_begin(batch, 1, 0.002, &pace[1], err));
    ck_assert_int_eq(stein_batch_go(batch, status, &why), 1);
    said(&why, STEIN_ENONFINITE, "no step is short enough");

    // and in steps of fixed length
    stein_on_force(stein_batch_sim(batch, 1), NULL, NULL);
    ck_assert_int_eq(stein_batch_step(batch, status, &why), STEIN_ESINGULAR);
    said(&why, STEIN_ESINGULAR, "joint \"hammer\"");
    ck_assert(status[0] == STEIN_OK && status[1] == STEIN_OK && status[2] == STEIN_ESINGULAR);
    stein_batch_destroy(batch);
    for (int i = 0; i < PLACES; i++) {
        stein_sim_destroy(sim[i]);
    }
}
END_TEST

Suite *edges_suite(void)
{
    Suite *suite = suite_create("edges");
    TCase *tc = tcase_create("edges");
    tcase_set_timeout(tc, 60.0);
    tcase_add_loop_test(tc, a_forged_state_is_refused_and_changes_nothing, 0, FORGERIES);
    tcase_add_test(tc, a_state_without_its_load_is_taken);
    tcase_add_test(tc, equations_of_another_layout_or_mechanism_are_not_called);
    tcase_add_test(tc, an_impossible_start_makes_no_simulation);
    tcase_add_test(tc, failing_memory_is_reported_and_blocks_are_freed);
    tcase_add_loop_test(tc, a_failure_where_an_event_is_ends_the_run_there, 0, 2);
    tcase_add_test(tc, a_pace_has_a_tolerance_a_longest_step_and_a_first_one);
    tcase_add_test(tc, a_tolerance_that_no_step_can_hold_is_reported);
    tcase_add_test(tc, a_direction_that_is_not_there_has_no_sensitivity);
    tcase_add_test(tc, an_error_is_reported_until_another_simulation_is_followed);
    tcase_add_test(tc, an_indifferent_equilibrium_moves_with_nothing);
    tcase_add_test(tc, a_system_without_a_solution_is_not_divided_by);
    tcase_add_test(tc, a_message_is_one_line_that_ends_in_time);
    tcase_add_test(tc, a_reading_without_forces_is_no_number);
    tcase_add_test(tc, failing_runs_of_a_batch_have_a_status_each_and_the_first_a_message);
    suite_add_tcase(suite, tc);
    return suite;
}
