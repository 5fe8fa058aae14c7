/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_data_forms.c - measured data as different programs write them.
 */
#include "data_cut.h"
#include "data_support.h"

void data_forms_cases(Suite *suite);

static const stein_model *const action = &stein_model_stein1788;

/* the same record as different programs write it: the same bits */
START_TEST(a_record_is_read_in_every_usual_form)
{
    static const char *const text[] = {
        "time [s],key_dip [m],key_angle [rad],finger [N]\n"
        "0,0.0015,0.25,-1.5\n0.25,0.00175,0.125,2\n0.5,,-1,0\n0.75,-0.001,3,1e3\n",
        "time,key_dip,key_angle,finger\r\n"
        "0,0.0015,0.25,-1.5\r\n0.25,0.00175,0.125,2\r\n0.5,,-1,0\r\n0.75,-0.001,3,1e3\r\n",
        "\xef\xbb\xbftime_ms,key_dip_mm,key_angle_rad,finger_N\n"
        "0,1.5,0.25,-1.5\n250,1.75,0.125,2\n500,,-1,0\n750,-1,3,1000\n",
        "Time (ms);key_dip (mm);key_angle (rad);finger (N)\r\n"
        "0;1,5;0,25;-1,5\r\n250;1,75;0,125;2\r\n500;;-1;0\r\n750;-1;3;1e3\r\n;;;\r\n;;;\r\n",
        "t [ms]\tkey_dip [mm]\tfinger_N\tkey_angle\n"
        "0\t1,5\t-1,5\t0,25\n250\t1,75\t2\t0,125\n500\t\t0\t-1\n750\t-1\t1E3\t3\n\t\n",
        ",time,key_dip,key_angle,finger\n0,0.0,0.0015,0.25,-1.5\n"
        "1,0.25,0.00175,0.125,2.0\n2,0.5,,-1.0,0.0\n3,0.75,-0.001,3.0,1000.0\n",
        "# made by hand\n# time [msec], key_dip [mm], finger [N], key_angle [radians]\n"
        "0.000e+00,1.500e+00,-1.5,0.25\n2.5e2,1.75,2,0.125\n5e2,,0,-1\n750,-1,1000,3\n",
        "mass_A\t\t\t\t\r\nt\tkey_dip\tkey_angle\tfinger\tv_{x}\r\n"
        "0\t0,0015\t0,25\t-1,5\tx\r\n0,25\t0,00175\t0,125\t2\t\r\n0,5\t\t-1\t0\t-\r\n"
        "0,75\t-0,001\t3\t1e3\t1\r\n",
        "Rig 3, run 7\n\nDate: 2026-05-04\nt / ms;Key_Dip / mm;key_angle / rad;finger / N;\n"
        "0;1,5;0,25;-1,5;\n250;1,75;0,125;2;\n500;;-1;0;\n750;-1;3;1e3;\n",
        "\"time, ms\",\"key_dip, mm\",\"key_angle, rad\",\"finger, N\"\n"
        "0,1.5,0.25,-1.5\n250,1.75,0.125,2\n500,,-1,0\n750,-1,3,1000\n",
        "motor,Time,Key_Dip,KEY_ANGLE,finger,note\n,ms,mm,rad,N,\n7,0,1.5,0.25,-1.5,begin\n"
        "8,250,1.75,0.125,2,\"a,b\"\nx,500,,-1,0,\n,750,-1,3,1000,end\n",
        "t\tkey_dip\tkey_angle\tfinger\t\r\n0\t0.0015\t0.25\t-1.5\r\n"
        "0.25\t0.00175\t0.125\t2\r\n0.5\t\t-1\t0\r\n0.75\t-0.001\t3\t1e3\r\n",
        "# run 7\n#Time\tkey_dip\tkey_angle\tfinger\n#[ms]\t[mm]\t[rad]\t[N]\n"
        "0\t1.5\t0.25\t-1.5\n250\t1.75\t0.125\t2\n500\t\t-1\t0\n750\t-1\t3\t1000\n"};
    lab_data *first = NULL;
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        lab_data *d = NULL;
        lab_data_options o = lab_data_options_default(action);
        o.min_samples = 3;
        ck_assert_stein(lab_data_open(&d, write_file("form.csv", text[i]), &o, err));
        first = first == NULL ? d : first;
        ck_assert_int_eq(d->nrow, 4);
        ck_assert_int_eq(d->ncolumn, 3);
        ck_assert(memcmp(d->time, first->time, sizeof *d->time * 4) == 0);
        for (int k = 0; k < 3; k++) {
            const lab_column *c = &first->column[k], *same = lab_data_column(d, c->name);
            ck_assert_msg(same != NULL, "form %d has no %s", (int)i, c->name);
            for (int row = 0; row < 4; row++) {
                ck_assert_int_eq(same->present[row], c->present[row]);
                ck_assert(!c->present[row] || same->value[row] == c->value[row]);
            }
        }
        if (d != first) {
            lab_data_close(d);
        }
    }
    lab_data_close(first);
}
END_TEST

/* the same times as different programs write them: the same bits */
START_TEST(times_of_events_are_read_in_every_usual_form)
{
    static const char *const text[] = {
        "# events string_force: begin\nstring_force [s]\n0.0615\n0.125\n0.5\n",
        "# events string_force: begin\nevent,string_force_ms\n1,61.5\n2,125\n3,500\n",
        "# events string_force: begin\n,string_force (ms)\r\n0,61.5\r\n1,125\r\n2,500\r\n",
        "# events string_force: begin\nn;string_force [ms]\n1;61,5\n2;125\n3;500\n;\n",
        "# events string_force: begin\n# string_force\n6.15e-2\n1.25e-1\n5e-1\n",
        "# events string_force: begin\nmass "
        "A\nhit,String_Force,note\n,ms,\n1,61.5,\n2,125,x\n3,500,\n",
        "# events string_force: begin\nhit string_force / ms\n1 61.5\n2 125\n3 500\n",
        ("# events string_force: begin\ntime [s],key_dip [mm],string_force [s]\n"
         "0,1,0.0615\n0.2,2,0.125\n0.4,3,0.5\n0.6,4,\n"),
        ("# events string_force: begin\nstring_force [ms],key_dip [mm],time [s]\n"
         "61.5,1,0\n125,2,0.2\n500,3,0.4\n,4,0.6\n")};
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        static const double time[] = {0.0615, 0.125, 0.5};
        int mixed = i > 6;
        lab_data *d = open_data(write_file("times.csv", text[i]), action);
        lab_audit *a = audit_of(d);
        const lab_column *c = lab_data_column(d, "string_force");
        int k = (int)(c - d->column);
        ck_assert_int_eq(d->events_alone, !mixed);
        ck_assert_int_eq(d->nrow, 4);
        ck_assert_int_eq(d->ncolumn, 1 + mixed);
        ck_assert_int_eq(c->role, LAB_EVENT_TIMES);
        ck_assert_int_eq(c->events, LAB_EVENTS_BEGIN);
        ck_assert_int_eq(c->samples, 3);
        ck_assert_int_eq(c->contact, stein_find_contact(action, "string"));
        ck_assert_int_eq(c->notch, -1);
        for (int row = 0; row < 4; row++) {
            ck_assert_int_eq(c->present[row], row < 3);
            ck_assert(row == 3 || c->value[row] == time[row]);
            ck_assert(mixed || d->time[row] == (row > 0 ? time[row - 1] : 0.0));
        }
        // to the last digit that the file has, or to a frame
        double step = mixed ? 0.2 : 1e-4;
        ck_assert_close(a->channel[k].noise, step / sqrt(12.0), 1e-9, 0.0);
        ck_assert_int_eq(was_found(a, "string_force: 3 times at which it closes"), 1);
        ck_assert_int_eq(was_found(a, mixed ? "a frame / sqrt 12" : "last digit / sqrt 12"), 1);
        ck_assert_int_eq(data__can_cut(d), 0);
        lab_audit_destroy(a);
        lab_data_close(d);
    }
}
END_TEST

/* numpy.savetxt without a delimiter, a terminal, columns of equal width */
START_TEST(blanks_separate_cells_where_the_titles_have_no_other_separator)
{
    static const char *const text[] = {
        "# time key_dip key_angle\n0.000e+00 1.500e-03 2.5e-1\n2.5e-01 1.750e-03 1.25e-1\n"
        "5.0e-01 2.0e-3 -1\n7.5e-01 -1e-3 3\n",
        "   time [s]   key_dip [mm]   key_angle [rad]  \n   0.00   1.5   0.25\n   0.25   1.75   "
        "0.125  \n"
        "\t0.5 2\t -1\n0.75    -1.0    3\n",
        "t / s key_dip / mm key_angle / rad\n0 1,5 0,25\n0,25 1,75 0,125\n0,5 2 -1\n0,75 -1 3\n",
        "\"time\" \"key_dip (mm)\" \"key_angle\"\n0 1.5 .25\n.25 1.75 .125\n.5 2 -1\n.75 -1 3\n"};
    static const double dip[] = {0.0015, 0.00175, 0.002, -0.001},
                        angle[] = {0.25, 0.125, -1.0, 3.0};
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        lab_data *d = open_data(write_file("blank.txt", text[i]), action);
        ck_assert_int_eq(d->nrow, 4);
        ck_assert_int_eq(d->ncolumn, 2);
        for (int row = 0; row < 4; row++) {
            ck_assert_close(d->time[row], 0.25 * row, 1e-15, 0.0);
            ck_assert_close(d->column[0].value[row], dip[row], 1e-15, 0.0);
            ck_assert_close(d->column[1].value[row], angle[row], 1e-15, 0.0);
        }
        lab_data_close(d);
    }
}
END_TEST

START_TEST(a_remark_below_the_titles_of_a_comment_is_kept)
{
    lab_data *d = open_data(write_file("remark.txt", "# key_dip and time\n# time [s],key_dip [mm]\n"
                                                     "# made by hand\n0,1\n1,2\n2,3\n3,5\n"),
                            action);
    ck_assert_int_eq(d->ncolumn, 1);
    ck_assert_int_eq(d->nnote, 2);
    ck_assert_str_eq(d->note[1].value, "made by hand");
    lab_data_close(d);
}
END_TEST

START_TEST(columns_that_the_model_lacks_are_passed_over_and_reported)
{
    lab_data *d = open_data(write_file("log.csv", "time [s],current [A],key_dip [m],state\n"
                                                  "0,1,0.1,on\n1,2,0.2,on\n2,3,0.4,off\n3,x,0,\n"),
                            action);
    lab_audit *a = audit_of(d);
    ck_assert_int_eq(d->ncolumn, 1);
    ck_assert_str_eq(d->passed_over, "current, state");
    ck_assert_int_eq(was_found(a, "columns that are no output or input of \"stein1788\", passed "
                                  "over: current, state"),
                     1);
    lab_audit_destroy(a);
    lab_data_close(d);
}
END_TEST

START_TEST(titles_without_a_unit_are_si_and_reported)
{
    lab_data *d = open_data(write_file("a.csv", "time,key_angle_deg,key_dip\n0,180,0\n1,90,1\n"
                                                "2,45,3\n3,60,2\n"),
                            action);
    lab_audit *a = audit_of(d);
    ck_assert_int_eq(d->time_unit_assumed, 1);
    ck_assert_int_eq(d->column[0].unit_assumed, 0);
    ck_assert_close(d->column[0].value[1], 1.5707963267948966, 1e-15, 0.0);
    ck_assert_int_eq(d->column[1].unit_assumed, 1);
    ck_assert_int_eq(was_found(a, "titles without a unit, read as time [s], key_dip [m]"), 1);
    lab_audit_destroy(a);
    lab_data_close(d);
}
END_TEST

/* two turns one way and two the other, seen within +-180 deg, 0 .. 360 deg and +-pi */
START_TEST(wrapped_angles_are_made_continuous)
{
    static const double low[] = {-180.0, 0.0, -3.14159265358979};
    static const double turn[] = {360.0, 360.0, 6.28318530717959};
    for (int i = 0; i < 3; i++) {
        char text[12000];
        size_t n = (size_t)sprintf(text, "time [s],key_angle [%s]\n", i < 2 ? "deg" : "rad");
        for (int row = 0; row <= 200; row++) {
            double angle = turn[i] * (0.1 + 2.2 * sin(0.01 * 3.14159265358979 * row));
            double seen = angle - turn[i] * floor((angle - low[i]) / turn[i]);
            n += (size_t)(row == 90 ? sprintf(text + n, "%d,\n", row)
                                    : sprintf(text + n, "%d,%.12g\n", row, seen));
        }
        lab_data *d = open_data(write_file("turns.csv", text), action);
        lab_audit *a = audit_of(d);
        for (int row = 0; row <= 200; row++) {
            double angle = 6.28318530717959 * (0.1 + 2.2 * sin(0.01 * 3.14159265358979 * row));
            ck_assert(!d->column[0].present[row] || fabs(d->column[0].value[row] - angle) < 1e-9);
        }
        ck_assert_int_eq(d->column[0].wraps, i == 1 ? 10 : 8);
        ck_assert_int_eq(was_found(a, i == 1 ? "key_angle: the angle wraps 10 times: unwrapped"
                                             : "key_angle: the angle wraps 8 times: unwrapped"),
                         1);
        lab_audit_destroy(a);
        lab_data_close(d);
    }
}
END_TEST

/* an inverted arm trembles about +-180 deg; an angle beyond one turn, or a smaller jump, is no
 * wrap */
START_TEST(only_wraps_are_unwrapped)
{
    static const char *const text[] = {
        "time [s],key_angle [deg]\n0,179\n1,-179\n2,178\n3,179.5\n4,-177\n",
        "time [s],key_angle [deg]\n0,179\n1,-179\n2,178\n3,185\n4,-177\n",
        "time [s],key_angle [deg]\n0,120\n1,-120\n2,118\n3,-119\n4,-117\n",
        "time [s],key_dip [m]\n0,3.1\n1,-3.1\n2,3.0\n3,-3\n4,-2.9\n"};
    static const int wraps[] = {3, 0, 0, 0};
    for (int i = 0; i < 4; i++) {
        lab_data *d = open_data(write_file("turns.csv", text[i]), action);
        ck_assert_int_eq(d->column[0].wraps, wraps[i]);
        lab_data_close(d);
    }
}
END_TEST

/* the plain form for other programs is read here too */
START_TEST(a_plain_table_reads_back_bit_for_bit)
{
    stein_sim *sim = make_sim(action, STEIN_RK4, 0.0);
    lab_record *record = NULL;
    lab_stroke_def def = lab_stroke_def_default(action);
    ck_assert_stein(lab_record_create(&record, action, 1.03e-3, err));
    def.until = 0.0613;
    def.sample = lab_record_sample;
    def.ctx = record;
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert_stein(lab_write(in_folder("plain.csv"), LAB_CSV_PLAIN, record, NULL, err));
    lab_data *d = open_data(in_folder("plain.csv"), action);
    ck_assert_int_eq(d->nrow, lab__record_rows(record));
    ck_assert_int_eq(d->ncolumn, action->nchannel - 1);
    for (int k = 0; k < d->ncolumn; k++) {
        for (int i = 0; i < d->nrow; i++) {
            double there = lab__record_at(record, i, k + 1);
            ck_assert(memcmp(&d->column[k].value[i], &there, sizeof there) == 0);
        }
    }
    lab_data_close(d);
    lab_record_destroy(record);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(a_record_in_memory_is_read_as_from_a_file)
{
    static const char *const text[] = {"# noise key_dip: 0.01 mm\ntime [ms],key_dip [mm]\n"
                                       "0,0\n1,0.25\n2,0.5\n3,0.25\n",
                                       NULL, "time [ms],key_dip [mm]\n0,0\n1,x\n2,1\n3,0\n", ""};
    lab_data_options o = lab_data_options_default(action);
    lab_dataset *set = NULL;
    lab_data *file = open_data(write_file("same.csv", text[0]), action);
    const char *name[] = {"a run", in_folder("same.csv"), "another"};
    stein_err why;
    o.text = text;
    ck_assert_stein(lab_dataset_open(&set, name, 2, &o, err));
    ck_assert_str_eq(set->stroke[0]->file, "a run");
    ck_assert(set->stroke[0]->hash == file->hash && set->stroke[1]->hash == file->hash);
    ck_assert(set->stroke[0]->nrow == 4 && set->stroke[0]->column[0].value[1] == 0.25e-3);
    ck_assert(set->stroke[0]->column[0].noise == file->column[0].noise);
    lab_dataset_close(set);
    ck_assert_int_eq(lab_dataset_open(&set, name, 3, &o, &why), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(why.msg, "another:3:3: "));
    o.text = text + 3; // nothing in it
    ck_assert_int_eq(lab_dataset_open(&set, name, 1, &o, &why), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(why.msg, "a run"));
    lab_data_close(file);
}
END_TEST

/* ---- many and large files ---- */

typedef struct seen {
    double first, last;
    int calls, backwards;
} seen;

static void see_progress(void *ctx, double fraction)
{
    seen *s = ctx;
    s->first = s->calls++ == 0 ? fraction : s->first;
    s->backwards += fraction < s->last;
    s->last = fraction;
}

START_TEST(two_hundred_files_are_read_with_progress)
{
    enum { FILES = 200 };
    static char path[FILES][200];
    const char *file[FILES];
    lab_dataset *set = NULL;
    seen s = {.calls = 0};
    lab_data_options o = lab_data_options_default(action);
    o.progress = see_progress;
    o.ctx = &s;
    for (int i = 0; i < FILES; i++) {
        snprintf(path[i], sizeof path[i], "%s/record_%d.csv", folder, i);
        FILE *f = fopen(path[i], "w");
        fprintf(f, "time [ms],key_dip [mm]\n");
        for (int row = 0; row < (i == 17 ? 40000 : 40); row++) {
            fprintf(f, "%d,%.3f\n", row, 3.0 * sin(0.1 * row + i));
        }
        fclose(f);
        file[i] = path[i];
    }
    ck_assert_stein(lab_dataset_open(&set, file, FILES, &o, err));
    ck_assert_int_eq(set->n, FILES);
    ck_assert_int_ge(s.calls, FILES);
    ck_assert_int_eq(s.backwards, 0);
    ck_assert_double_lt(s.first, 0.01);
    ck_assert_double_gt(s.last, 0.999);
    lab_dataset_close(set);
}
END_TEST

/* one message for a file, with its place and the expected titles */
/* in other languages; a title without a unit of time is none */
START_TEST(a_first_column_with_a_unit_of_time_is_the_time)
{
    static const char *const title[] = {"Zeit [s]", "Zeit_s", "temps (ms)", "tijd_ms"};
    for (int i = 0; i < 4; i++) {
        lab_data *d = NULL;
        lab_data_options o = lab_data_options_default(action);
        char *text = lab__text("%s,key_dip [m]\n0,1\n1,2\n2,1\n3,3\n", title[i]);
        ck_assert_stein(lab_data_open(&d, write_file("time.csv", text), &o, err));
        ck_assert_int_eq(d->nrow, 4);
        ck_assert_int_eq(d->ncolumn, 1);
        ck_assert(d->time[3] == (strchr(title[i], 'm') != NULL ? 3e-3 : 3.0));
        ck_assert_int_eq(d->time_unit_assumed, 0);
        free(text);
        lab_data_close(d);
    }
}
END_TEST

START_TEST(bad_files_give_one_message_each)
{
    static const struct {
        const char *text, *says;
    } bad[] = {
        {"", "no header line, expected \"time [s],...\""},
        {"\n\n", "no header line"},
        {"time [s],key_dip [m]\n", ":1:1: no rows below the header"},
        {"time [s],key_dip [m]\n0,1\n", ":1:1: 1 sample, expected at least 4"},
        {"time [s],key_dip [m]\n0,1\n1,2\n", ":1:1: 2 samples, expected at least 4"},
        {"time,key_dip\n0,1\n1,NaN\n2,nan\n3,inf\n4,1\n5,2\n6,1\n7,3\n",
         ":3:3: key_dip \"NaN\": not a finite number; a missing sample is an empty cell (and 2 "
         "more"},
        {"time,key_dip\n0,1\n1,2\n1,3\n2,4\n2,1\n3,3\n",
         ":4:1: the time 1 s appears twice, expected rows in increasing time (and 1"},
        {"time,key_dip\n9,1\n8,2\n7,3\n6,4\n",
         ":3:1: the time goes back from 9 s to 8 s, expected rows in increasing time (and 2 more"},
        {"key_dip [m]\n1\n2\n1\n3\n",
         ":1:1: the first column is \"key_dip [m]\": expected time [s]"},
        {"time,theta1,theta2\n0,1,2\n1,2,3\n2,1,2\n3,2,2\n",
         ":1:6: none of the 2 columns from \"theta1\" on is an output or input of \"stein1788\": a "
         "record of another mechanism? expected some of string_distance [m], string_force [N], "},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lab_data_options o = lab_data_options_default(action);
        said s = {.n = 0};
        lab_data *d = NULL;
        o.report = hear;
        o.ctx = &s;
        ck_assert_int_eq(lab_data_open(&d, write_file("bad.csv", bad[i].text), &o, NULL),
                         STEIN_EPARSE);
        ck_assert_ptr_null(d);
        ck_assert_msg(s.n == 1 && was_said(&s, "bad.csv") && was_said(&s, bad[i].says),
                      "%d messages, the first: %s", s.n, s.text[0]);
    }
}
END_TEST

void data_forms_cases(Suite *suite)
{
    TCase *tc = tcase_create("forms");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, a_record_is_read_in_every_usual_form);
    tcase_add_test(tc, times_of_events_are_read_in_every_usual_form);
    tcase_add_test(tc, blanks_separate_cells_where_the_titles_have_no_other_separator);
    tcase_add_test(tc, a_remark_below_the_titles_of_a_comment_is_kept);
    tcase_add_test(tc, columns_that_the_model_lacks_are_passed_over_and_reported);
    tcase_add_test(tc, titles_without_a_unit_are_si_and_reported);
    tcase_add_test(tc, wrapped_angles_are_made_continuous);
    tcase_add_test(tc, only_wraps_are_unwrapped);
    tcase_add_test(tc, a_plain_table_reads_back_bit_for_bit);
    tcase_add_test(tc, a_record_in_memory_is_read_as_from_a_file);
    tcase_add_test(tc, two_hundred_files_are_read_with_progress);
    tcase_add_test(tc, a_first_column_with_a_unit_of_time_is_the_time);
    tcase_add_test(tc, bad_files_give_one_message_each);
    suite_add_tcase(suite, tc);
}
