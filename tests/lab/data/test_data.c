/* SPDX-License-Identifier: GPL-3.0-or-later
 * test_data.c - reading measured data: accepted files, and every refusal with its place.
 */
#include <locale.h>

#include "data_support.h"

Suite *data_suite(void);
void data_audit_cases(Suite *suite);
void data_forms_cases(Suite *suite);

static const stein_model *const action = &stein_model_stein1788;

/* rows of a plausible record, to follow a header of time and one channel */
#define ROWS "0,1.5\n1,1.75\n2.5,1.125\n3,1.0625\n4,\n"

/* ---- accepted files ---- */

START_TEST(every_part_of_a_file_is_kept_in_si)
{
    const char *path = write_file(
        "a.csv",
        "\xef\xbb\xbf# set pawl.stop_shift: -0.3 mm\r\n"
        "#set load.mass:105 g\r\n"
        "# noise string_distance: 0.012 mm\r\n"
        "# trigger: unsynchronised\r\n"
        "# camera: Phantom: v7\r\n"
        "# a free remark\r\n"
        "#\r\n"
        "\"time [ms]\", string_distance [mm] ,\"key_angle [deg]\",finger [N],notch_phase\r\n"
        "-1.25, 7.2,-3,0.5,1\r\n"
        "0,7.1,-2.875,,1\r\n"
        "\r\n"
        "0.5,\"\",-2.5,1e-3,2\r\n"
        "+1.5e0,.0625,+0.25,-4E2,2\r\n"
        "2,7,0,3,3");
    lab_data_options o = lab_data_options_default(action);
    o.min_samples = 2;
    lab_data *d = NULL;
    ck_assert_stein(lab_data_open(&d, path, &o, err));
    ck_assert_int_eq(d->nrow, 5);
    ck_assert_int_eq(d->ncolumn, 4);
    ck_assert_int_eq(d->trigger, LAB_TRIGGER_UNSYNCHRONISED);
    ck_assert(d->time[0] == -0.00125 && d->time[3] == 0.0015);
    const lab_column *s = lab_data_column(d, "string_distance");
    ck_assert_ptr_eq(s, &d->column[0]);
    ck_assert_ptr_null(lab_data_column(d, "hammer_height"));
    ck_assert(s->value[0] == 0.0072 && s->value[3] == 0.0000625); // the very bits
    ck_assert(isnan(s->value[2]) && !s->present[2] && s->present[4]);
    ck_assert_int_eq(s->samples, 4);
    ck_assert(s->noise == 0.012e-3);
    ck_assert_str_eq(s->unit, "m");
    ck_assert_int_eq(s->line, 8);
    ck_assert_int_eq(s->column, 14);
    ck_assert_int_eq(s->role, LAB_OUTPUT);
    const lab_column *finger = lab_data_column(d, "finger");
    ck_assert_int_eq(finger->role, LAB_INPUT);
    ck_assert_int_eq(finger->index, stein_find_input(action, "finger"));
    ck_assert(isnan(finger->noise) && finger->value[3] == -400.0);
    ck_assert_close(lab_data_column(d, "key_angle")->value[1], -2.875 * 3.14159265358979 / 180.0,
                    1e-14, 0.0);
    ck_assert_int_eq(d->nset, 2);
    ck_assert(d->set[0].value == -0.3e-3 && d->set[1].value == 0.105);
    ck_assert_str_eq(d->set[1].name, "load.mass");
    double *p = malloc(sizeof *p * (size_t)action->np);
    for (int i = 0; i < action->np; i++) {
        p[i] = action->params[i].value;
    }
    lab_data_apply(d, p);
    ck_assert(p[stein_find_param(action, "pawl.stop_shift")] == -0.3e-3);
    int mass = stein_find_param(action, "hammer.mass");
    ck_assert(p[mass] == action->params[mass].value);
    free(p);
    ck_assert_int_eq(d->nnote, 3);
    ck_assert_str_eq(d->note[0].name, "camera");
    ck_assert_str_eq(d->note[0].value, "Phantom: v7");
    ck_assert_str_eq(d->note[1].value, "a free remark");
    lab_data_close(d);
    lab_data_close(NULL);
}
END_TEST

/* a wire that the model does not have: nothing is set, and the removed part is known */
START_TEST(a_part_that_was_taken_off_is_noted)
{
    const char *path = write_file("a.csv", "# set key_wire.k: 0 N/m\n# set load.mass: 90 g\n"
                                           "# set key_damper.normal.F0: 0\n"
                                           "time [s],key_dip [m]\n" ROWS);
    lab_data_options o = lab_data_options_default(action);
    lab_data *d = NULL;
    ck_assert_stein(lab_data_open(&d, path, &o, err));
    ck_assert_int_eq(d->nset, 1);
    ck_assert_int_eq(d->set[0].last_word, 0); // of a load
    ck_assert_int_eq(d->nnote, 2);
    ck_assert_str_eq(d->note[0].name, LAB_NOTE_WITHOUT);
    ck_assert_str_eq(d->note[0].value, "key_wire.k");
    ck_assert_str_eq(d->note[1].value, "key_damper.normal.F0");
    lab_data_close(d);
}
END_TEST

/* the step of a setting is one of the last digit that it is written with */
START_TEST(a_setting_is_known_to_its_last_digit)
{
    static const struct {
        const char *text;
        double step;
    } written[] = {{"-0.3 mm", 1e-4}, {"2 mm", 1e-3},   {"+12.50 um", 1e-8}, {"-.25 mm", 1e-5},
                   {"0.0003", 1e-4},  {"3e-4 m", 1e-4}, {"1.5e-4 m", 1e-5},  {"0 mm", 1e-3}};
    for (size_t i = 0; i < sizeof written / sizeof *written; i++) {
        char text[200];
        snprintf(text, sizeof text, "# set pawl.stop_shift: %s\ntime [s],key_dip [m]\n" ROWS,
                 written[i].text);
        lab_data_options o = lab_data_options_default(action);
        lab_data *d = NULL;
        ck_assert_stein(lab_data_open(&d, write_file("a.csv", text), &o, err));
        ck_assert_int_eq(d->nset, 1);
        ck_assert_close(d->set[0].step, written[i].step, 1e-12, 0.0);
        lab_data_close(d);
    }
}
END_TEST

/* separately measured numbers: the stroke has the last word of it, also when it is set, too */
START_TEST(a_number_that_is_known_has_the_last_word)
{
    const char *path = write_file("a.csv", "# known key.front.x: 18.2 cm\n# set load.mass: 90 g\n"
                                           "# set hammer.mass: 2.5 g\n# known hammer.mass: 2.5 g\n"
                                           "# set key_dip.sensor.gain: 1.01\n"
                                           "time [s],key_dip [m]\n" ROWS);
    lab_data_options o = lab_data_options_default(action);
    lab_data *d = NULL;
    ck_assert_stein(lab_data_open(&d, path, &o, err));
    ck_assert_int_eq(d->nset, 4);
    ck_assert_str_eq(d->set[0].name, "key.front.x");
    ck_assert(d->set[0].value == 0.182);
    static const int last[] = {1, 0, 1, 1}; // instruments are checked before they are set
    for (int i = 0; i < d->nset; i++) {
        ck_assert_int_eq(d->set[i].last_word, last[i]);
    }
    lab_data_close(d);
}
END_TEST

START_TEST(numbers_are_rounded_correctly_in_any_locale)
{
    static const char *const text[] = {"0.1",
                                       "123456789012345",
                                       "1234567890123456789",
                                       "9007199254740993",
                                       "1e23",
                                       "8.5e-23",
                                       "4.9e-324",
                                       "1.7976931348623157e308",
                                       "-0.000000000000000000000017",
                                       "5e-324",
                                       "2.2250738585072011e-308",
                                       "00012.50",
                                       "-0",
                                       "3.141592653589793238462643383279502884197169399375105"};
    static const double value[] = {0.1,
                                   123456789012345.0,
                                   1234567890123456789.0,
                                   9007199254740993.0,
                                   1e23,
                                   8.5e-23,
                                   4.9e-324,
                                   1.7976931348623157e308,
                                   -0.000000000000000000000017,
                                   5e-324,
                                   2.2250738585072011e-308,
                                   12.5,
                                   -0.0,
                                   3.141592653589793238462643383279502884197169399375105};
    int n = sizeof value / sizeof *value;
    char file[2000] = "time [s],notch_phase\n";
    for (int i = 0; i < n; i++) {
        char row[120];
        snprintf(row, sizeof row, "%d,%s\n", i, text[i]);
        strcat(file, row);
    }
    write_file("n.csv", file);
    const char *german = setlocale(LC_ALL, "de_DE.UTF-8"); // may be absent
    lab_data *d = open_data(in_folder("n.csv"), action);
    setlocale(LC_ALL, "C");
    for (int i = 0; i < n; i++) {
        ck_assert_msg(memcmp(&d->column[0].value[i], &value[i], sizeof value[i]) == 0,
                      "%s became %.17g%s", text[i], d->column[0].value[i],
                      german != NULL ? " in a German locale" : "");
    }
    lab_data_close(d);
}
END_TEST

START_TEST(a_written_stroke_reads_back_bit_for_bit)
{
    const char *notes[] = {"model: stein1788", "set pawl.stop_shift: -0.3mm", NULL};
    stein_sim *sim = make_sim(action, STEIN_RK4, 0.0);
    ck_assert_stein(stein_set(sim, "pawl.stop_shift", -0.3e-3, err));
    ck_assert_stein(stein_reset(sim, err));
    lab_record *record = NULL;
    ck_assert_stein(lab_record_create(&record, action, 0.43e-3, err));
    lab_stroke_def def = lab_stroke_def_default(action);
    def.until = 0.0813;
    def.sample = lab_record_sample;
    def.ctx = record;
    ck_assert_stein(lab_simulate(sim, &def, err));
    ck_assert_stein(lab_write_csv(in_folder("s.csv"), record, notes, err));
    lab_data *d = open_data(in_folder("s.csv"), action);
    ck_assert_int_eq(d->nrow, lab__record_rows(record));
    ck_assert_int_eq(d->ncolumn, action->nchannel - 1);
    for (int k = 0; k < d->ncolumn; k++) {
        ck_assert_int_eq(d->column[k].index, k + 1);
        for (int i = 0; i < d->nrow; i++) {
            double there = lab__record_at(record, i, k + 1);
            ck_assert(memcmp(&d->column[k].value[i], &there, sizeof there) == 0);
        }
    }
    ck_assert_int_eq(d->nset, 1);
    ck_assert(d->set[0].value == -0.3e-3);
    lab_data_close(d);
    lab_record_destroy(record);
    stein_sim_destroy(sim);
}
END_TEST

START_TEST(long_records_are_read_in_one_piece)
{
    FILE *f = fopen(in_folder("long.csv"), "w");
    fprintf(f, "time [us],string_distance [um],key_angle [mrad]\n");
    for (int i = 0; i < 123457; i++) {
        fprintf(f, "%d,%d.25,%s\n", 7 * i, (i * 31) % 1009, i % 3 == 0 ? "" : "1.5e-1");
    }
    fprintf(f, "1e12,3,7\n");
    fclose(f);
    lab_data *d = open_data(in_folder("long.csv"), action);
    ck_assert_int_eq(d->nrow, 123458);
    ck_assert(d->time[123456] == 0.864192 && d->time[123457] == 1e6);
    ck_assert(d->column[0].value[123456] == (123456 * 31 % 1009 + 0.25) / 1e6);
    ck_assert_int_eq(d->column[1].samples, 123457 - 41153 + 1);
    lab_data_close(d);
}
END_TEST

/* ---- refusals ---- */

START_TEST(wrong_headers_are_refused_with_their_place)
{
    static const bad_data bad[] = {
        {"", ": ", "no header line"},
        {"# camera: x\n", ": ", "no header line"},
        {"# set key_wire.k: 3 N/m\ntime [s],key_dip [m]\n" ROWS,
         ":1:19: ", "\"stein1788\" has no such part, so it can only be 0: taken off"},
        {"# set key_wire.k: 0 N\ntime [s],key_dip [m]\n" ROWS, ":1:19: ", "set key_wire.k: "},
        {"# known key.front.x: 1 kg\ntime [s],key_dip [m]\n" ROWS, ":1:22: ", "set key.front.x: "},
        {"# known\ntime [s],key_dip [m]\n" ROWS, ":1:8: ", "expected \"# known NAME: VALUE\""},
        {"# set keys_wire.k: 0\ntime [s],key_dip [m]\n" ROWS, ":1:7: ", "sets no parameter"},
        {"# set key_wire.reach: 0\ntime [s],key_dip [m]\n" ROWS, ":1:7: ", "sets no parameter"},
        {"time [s],string_distance [N]\n" ROWS,
         ":1:10: ", "\"string_distance\" is in [N], expected [m]"},
        {"time [s],string_distance [inch]\n" ROWS, ":1:10: ", "no known unit"},
        {"time [s],notch_phase [rad]\n" ROWS, ":1:10: ", "expected [1]"},
        {"time [s],string_distance [m\n" ROWS, ":1:10: ", "the unit is not closed"},
        {"time [mm],string_distance [m]\n" ROWS, ":1:1: ", "\"time\" is in [mm], expected [s]"},
        {"string_distance [m],notch_phase\n" ROWS, ":1:1: ", "expected time [s]"},
        {"time [s],string_distanze [m]\n" ROWS, ":1:10: ", "did you mean \"string_distance\"?"},
        {"time [s],finge [N]\n" ROWS, ":1:10: ", "did you mean \"finger\"?"},
        {"time [s],key_dip [m],string_distanze [m]\n0,1,2\n1,2,3\n2,3,4\n3,4,5\n",
         ":1:22: ", "did you mean \"string_distance\"?"},
        {"Rig 3\n\ntime [s],string_distance [N]\n" ROWS, ":3:10: ", "is in [N], expected [m]"},
        {"Rig 3\ntim [mm],string_distance [m]\n" ROWS, ":2:1: ", "\"tim [mm]\": expected time [s]"},
        {"Rig 3; left\n", ": ", "no header line"},
        {"time [s],\xc3\xa9t\xc3\xa9 [m]\n" ROWS, ":1:10: ",
         "no output or input of \"stein1788\"; its outputs: string_distance [m], string_force [N]"},
        {"time [s],load_force [kgm/s^2]\n" ROWS,
         ":1:10: ", "expected [N]: this is no known unit, did you mean \"kg m/s^2\"?"},
        {"time [s],key_dip [m],string_distance [m],key_dip "
         "[mm]\n0,1,2,3\n1,2,3,4\n2,3,4,5\n3,4,5,6\n",
         ":1:42: ", "a second column \"key_dip\", the first one is at column 10"},
        {"time [s],time [s]\n" ROWS, ":1:10: ", "a second column \"time\""},
        {"time [s], \n" ROWS, ":1:10: ", "column 2 has no name"},
        {"time [s]\n0\n1\n2\n3\n", ":1:1: ", "no columns beside the time"},
        {"tim,string_distance [m]\n" ROWS, ":1:1: ", "\"tim\": expected time [s]"},
        {"time_mm,string_distance [m]\n" ROWS, ":1:1: ", "\"time\" is in [mm], expected [s]"},
        {"time,key_angle_N\n" ROWS, ":1:6: ", "\"key_angle\" is in [N], expected [rad]"},
        {"time,key_angle_left\n" ROWS, ":1:6: ", "\"key_angle_left\" is no output or input"},
        {"time [s],angle [rad],speed (rad/s)\n0,1,2\n1,2,3\n2,3,4\n3,4,5\n", ":1:10: ",
         "none of the 2 columns from \"angle\" on is an output or input of \"stein1788\""},
        {ROWS, ":1:1: ", "numbers where the titles of the columns should be"},
        {"# camera: x, y\n# left, right\n0,1\n1,2\n", ":3:1: ", "numbers where the titles"},
        {"time [s],\"key_dip [m]\n" ROWS, ":1:10: ", "quoted title"},
        {"\xff\xfet\n", ":1:1: ", "UTF-16"},
        {"\xfe\xff\0t\n", ":1:1: ", "UTF-16"},
        {"\xfe-,string_distance [m]\n" ROWS, ":1:1: ", "expected time [s]"},
        {"\xff-,string_distance [m]\n" ROWS, ":1:1: ", "expected time [s]"},
        {"\xef-time,string_distance [m]\n" ROWS, ":1:1: ", "expected time [s]"},
        {"\xef\xbb-time,string_distance [m]\n" ROWS, ":1:1: ", "expected time [s]"},
    };
    REFUSE(bad);
}
END_TEST

START_TEST(wrong_rows_are_refused_with_their_place)
{
#define HEAD "time [s],key_dip [mm]\n"
    static const bad_data bad[] = {
        {HEAD, ":1:1: ", "no rows"},
        {HEAD "0,1\n", ":1:1: ", "1 sample, expected at least 4"},
        {HEAD "0,1\n1,2\n", ":1:1: ", "2 samples, expected at least 4"},
        {HEAD "0,\n1,2\n2,\n3,\n4,\n", ":1:10: ", "1 sample of \"key_dip\", expected"},
        {HEAD "0,1\n1,\n2,2\n3,\n4,4\n",
         ":1:10: ", "3 samples of \"key_dip\", expected at least 4"},
        {HEAD "0,7.25\n1,7.25\n2,\n3,7.25\n4,7.25\n",
         ":1:10: ", "\"key_dip\" is 0.00725 m in all 4 samples"},
        {HEAD "0,0\n1,0\n2,0\n3,0\n4,0\n", ":1:10: ", "measures nothing"},
        {"time [s],string_force [N],key_dip [mm]\n0,2,1\n1,2,2\n2,2,4\n3,2,3\n",
         ":1:10: ", "\"string_force\" is 2 N in all 4 samples"},
        {HEAD "0,1\n1,2\n0.5,3\n2,4\n", ":4:1: ", "the time goes back from 1 s to 0.5 s"},
        {HEAD "0,1\n1,2\n1,3\n2,4\n", ":4:1: ", "the time 1 s appears twice"},
        {HEAD "0,1\n1,2\n 2 ,nan\n3,1\n4,5\n", ":4:5: ", "key_dip \"nan\": not a finite number"},
        {HEAD "0,1\n1,-Inf\n2,2\n3,1\n4,5\n", ":3:3: ", "a missing sample is an empty cell"},
        {HEAD "0,1\n1,N/A\n2,2\n3,1\n4,5\n", ":3:3: ", "a missing sample is an empty cell"},
        {HEAD "0,1\n1,1e999\n2,2\n3,1\n4,5\n", ":3:3: ", "too large"},
        {HEAD "0,1\n1,0x10\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,1.2.3\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,1e\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,+-1\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,2 mm\n2,2\n3,1\n4,5\n", ":3:3: ", "expected a number"},
        {HEAD "0,1\n1,\"1,5\"\n2,2\n3,1\n4,5\n", ":3:3: ", "a decimal comma"},
        {HEAD "0,1\n1,\"15\n2,2\n3,1\n4,5\n5,5\n", ":3:3: ", "quotes that do not close"},
        {HEAD "0,1\n,2\n2,2\n3,1\n4,5\n", ":3:1: ", "a row without time"},
        {HEAD "0,1\nx,2\n2,2\n3,1\n4,5\n", ":3:1: ", "time \"x\": expected a number"},
        {HEAD "0,1\n1,2,3\n2,2\n3,1\n4,5\n", ":3:5: ", "3 cells where the header has 2"},
        {HEAD "0,1\n1\n2,2\n3,1\n4,5\n", ":3:2: ", "1 cell where the header has 2"},
        {"time [s];key_dip [mm]\n0;1,5\n1,5;2.5\n2;3\n3;4\n",
         ":3:5: ", "key_dip \"2.5\": a decimal point, but numbers before it have a decimal comma"},
        {"time [s];key_dip [mm]\n0.5;1\n1.5;2,5\n2;3\n3;4\n",
         ":3:5: ", "key_dip \"2,5\": a decimal comma, expected a decimal point"},
        {"time [s];key_dip [mm]\n0,5;1\n1,5;2,500,000\n2;3\n3;4\n", ":3:5: ", "expected a number"},
        {"time [s]\tkey_dip [mm]\n0\t1\n1;2\n2\t3\n3\t4\n4\t5\n",
         ":3:2: ", "1 cell where the header has 2: cells are separated by \";\""},
        {HEAD "0,1\n1;2\n2,2\n3,1\n4,5\n", ":3:2: ", "separated by \";\""},
        {HEAD "0,0,1,5\n0,5,1,75\n1,0,1,25\n1,5,1,0\n", ":2:5: ", "decimal commas?"},
        {HEAD "0,1\n1,2\n# set key.mass: 3 g\n2,2\n3,1\n4,5\n", ":4:1: ", "below the header"},
    };
    REFUSE(bad);
}
END_TEST

#define TIMES "# events string_force: begin\n"
/* times of events that cannot be */
START_TEST(wrong_times_of_events_are_reported_at_their_place)
{
    static const bad_data bad[] = {
        {"# events strin_force: begin\nstrin_force [s]\n1\n",
         ":1:10: ", "no such output of the model, did you mean \"string_force\"?"},
        {"# events strin_force: begin\nstring_force [s]\n1\n", ":1:10: ", "no such output"},
        {"# events key_angle: begin\nkey_angle [s]\n1\n", ":1:10: ",
         "it reads no contact or notch, expected an output that does: string_distance, "},
        {"# events string_force: begins\nstring_force [s]\n1\n",
         ":1:24: ", "\"begins\", expected begin (it closes) or end (it opens)"},
        {TIMES "# events string_force: end\nstring_force [s]\n1\n",
         ":2:10: ", "end here and begin in line 1"},
        {TIMES "time [s],key_dip [m]\n0,1\n1,2\n2,4\n3,1\n",
         ":1:10: ", "events of \"string_force\": no such column in this file"},
        {TIMES "string_force [N]\n1\n", ":2:1: ", "expected \"string_force [s]\""},
        {TIMES "string_force [s]\n", ":2:1: ", "no rows"},
        {TIMES "string_force [s]\n0.2\n0.1\n", ":4:1: ", "goes back from 0.2 s to 0.1 s"},
        {TIMES "string_force [s]\n0.2\n0.2\n", ":4:1: ", "stands still"},
        {TIMES "string_force [s]\n-0.1\n0.1\n",
         ":3:1: ", "an event at -0.1 s, expected times after the start of the record, 0 s"},
        {TIMES "string_force [s]\n0\n0.1\n", ":3:1: ", "expected times after the start"},
        {TIMES "string_force [s],key_dip [m]\n0.1,1\n", ":2:18: ", "holds no times of events"},
        {TIMES "event,string_force [s],string_force [s]\n1,0.1,0.1\n",
         ":2:24: ", "a second column \"string_force\""},
        {TIMES "time [s],key_dip [m],string_force [s]\n1,1,0.5\n2,2,\n3,4,\n4,1,\n",
         ":3:5: ", "an event at 0.5 s, expected times after the start of the record, 1 s"},
        {TIMES "time [s],key_dip [m],string_force [s]\n0,1,\n1,2,1.5\n2,4,\n3,1,\n",
         ":4:5: ", "below an empty cell"},
        {TIMES "time [s],key_dip [m],string_force [s]\n0,1,\n1,2,\n2,4,\n3,1,\n",
         ":2:22: ", "\"string_force\": no time of an event"},
        {TIMES "time [s],key_dip [m],string_force [s]\n0,1,soon\n1,2,\n2,4,\n3,1,\n",
         ":3:5: ", "expected a number"},
        {"# events string_force\nstring_force [s]\n1\n",
         ":1:10: ", "expected \"# events NAME: VALUE\""},
    };
    REFUSE(bad);
}
END_TEST

START_TEST(settings_that_contradict_are_refused_with_their_place)
{
#define MOTION "time [s],key_motion [rad]\n0,0\n1,1\n2,2\n3,3\n"
#define BODY   HEAD "0,1\n1,2\n2,4\n3,1\n"
    static const bad_data bad[] = {
        {"# set pawl.stop_shfit: 1 mm\n" BODY, ":1:7: ", "did you mean \"pawl.stop_shift\"?"},
        {"# set load.mass: 3 mm\n" BODY, ":1:18: ", "the unit is m, expected kg"},
        {"# set load.mass: heavy\n" BODY, ":1:18: ", "expected a number"},
        {"# set load.mass:\n" BODY, ":1:17: ", "expected a number"},
        {"# set load.mass = 100 g\n" BODY, ":1:7: ", "expected \"# set NAME: VALUE\""},
        {"# set : 100 g\n" BODY, ":1:6: ", "expected \"# set NAME: VALUE\""},
        {"# set load.mass: 100 g\n# x: y\n# set load.mass: 105 g\n" BODY,
         ":3:7: ", "load.mass is set to 0.105 kg here and to 0.1 kg in line 1"},
        {"# trigger: now\n" BODY, ":1:12: ", "expected synchronised or unsynchronised"},
        {"# setting load.mass: 100 g\n# set\tload.mass:\t3 mm\t\n" BODY,
         ":2:18: ", "the unit is m, expected kg"},
        {"# trigger: synchronised\n# trigger: unsynchronised\n" BODY, ":2:12: ", "in line 1"},
        {"# noise string_distance: 1 um\n" BODY, ":1:9: ", "no such column in this file"},
        {"# noise key_dipp: 1 um\n" BODY, ":1:9: ", "did you mean \"key_dip\"?"},
        {"# noise key_dip: 1 N\n" BODY, ":1:18: ", "the unit is N, expected m"},
        {"# noise key_dip: -1 um\n" BODY, ":1:18: ", "greater than zero"},
        {"# noise key_dip: 0 um\n" BODY, ":1:18: ", "greater than zero"},
        {"# noise key_dip: 1 um\n# noise key_dip: 2 um\n" BODY, ":2:9: ", "given twice"},
        {"# smooth key_dip: 12 Hz\n" BODY, ":1:10: ", "is an output, expected a prescribed motion"},
        {"# smooth finger: 12 Hz\ntime [s],finger [N]\n0,0\n1,1\n2,2\n3,3\n",
         ":1:10: ", "is a force or another input, expected a prescribed motion"},
        {"# smooth key_motoin: 12 Hz\n" BODY, ":1:10: ", "did you mean \"key_motion\"?"},
        {"# smooth key_motion: 12 Hz\n" BODY, ":1:10: ", "no such column in this file"},
        {"# smooth key_motion: 12 s\n" MOTION, ":1:22: ", "the unit is s, expected 1/s"},
        {"# smooth key_motion: 0 Hz\n" MOTION, ":1:22: ", "a frequency is greater than zero"},
        {"# smooth key_motion: 1 Hz\n# smooth key_motion: 2 Hz\n" MOTION, ":2:10: ", "given twice"},
        {"# smooth key_motion\n" MOTION, ":1:10: ", "expected \"# smooth NAME: VALUE\""},
    };
    REFUSE(bad);
    lab_data *d = open_data(write_file("same.csv", "# set load.mass: 100 g\n# set load.mass: "
                                                   "0.1 kg\n" BODY),
                            action);
    ck_assert_int_eq(d->nset, 1);
    lab_data_close(d);
}
END_TEST

START_TEST(a_load_cannot_be_set_where_there_is_none)
{
    lab_data_options o = lab_data_options_default(&stein_model_falling_ball);
    lab_data *d = NULL;
    stein_err err = {STEIN_OK, ""};
    const char *path =
        write_file("b.csv", "# set load.mass: 100 g\ntime [s],height [m]\n0,4\n1,3\n2,2\n3,1\n");
    ck_assert_int_eq(lab_data_open(&d, path, &o, &err), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(err.msg, ":1:7: "));
    ck_assert_ptr_nonnull(strstr(err.msg, "which has no load"));
}
END_TEST

START_TEST(all_problems_are_reported_in_order_and_equal_ones_are_counted)
{
    lab_data_options o = lab_data_options_default(action);
    said s = {.n = 0};
    o.report = hear;
    o.ctx = &s;
    lab_data *d = NULL;
    char text[4000] =
        "# set nothing: 1\ntime [s],key_dip [N],string_distance [m],key_angle [rad]\n";
    for (int i = 0; i < 40; i++) {
        char row[80];
        snprintf(row, sizeof row, "%d,1,nan,%s\n", i, i == 17 ? "x" : "2.5");
        strcat(text, row);
    }
    const char *path = write_file("many.csv", text);
    ck_assert_int_eq(lab_data_open(&d, path, &o, NULL), STEIN_EPARSE);
    ck_assert_int_eq(s.n, 5);
    ck_assert_ptr_nonnull(strstr(s.text[0], ":1:7: "));
    ck_assert_ptr_nonnull(strstr(s.text[1], ":2:10: "));
    ck_assert_ptr_nonnull(strstr(s.text[2], ":2:42: \"key_angle\" is 2.5 rad in all 39"));
    ck_assert_ptr_nonnull(strstr(s.text[3], ":3:5: "));
    ck_assert_ptr_nonnull(strstr(s.text[3], "and 39 more like this"));
    ck_assert_ptr_nonnull(strstr(s.text[4], ":20:10: "));

    // and no more than twenty
    *text = '\0';
    for (int i = 0; i < 30; i++) {
        strcat(text, "# set nothing: 1\n");
    }
    s.n = 0;
    path = write_file("many.csv", strcat(text, BODY));
    ck_assert_int_eq(lab_data_open(&d, path, &o, NULL), STEIN_EPARSE);
    ck_assert_int_eq(s.n, 21);
    ck_assert_ptr_nonnull(strstr(s.text[20], "more than 20 problems"));
    ck_assert_ptr_null(d);
}
END_TEST

START_TEST(binary_files_are_refused)
{
    lab_data_options o = lab_data_options_default(action);
    lab_data *d = NULL;
    stein_err err = {STEIN_OK, ""};
    ck_assert_int_eq(lab_data_open(&d, in_folder("absent.csv"), &o, &err), STEIN_EIO);
    ck_assert_int_eq(lab_data_open(&d, folder, &o, &err), STEIN_EIO);
    ck_assert_int_eq(lab_data_open(&d, "/dev/zero", &o, &err), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(err.msg, ":1:1: a zero byte"));
    FILE *f = fopen(in_folder("wide.csv"), "w");
    for (int i = 0; i < 70000; i++) {
        putc('a', f);
    }
    fclose(f);
    ck_assert_int_eq(lab_data_open(&d, in_folder("wide.csv"), &o, &err), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(err.msg, "longer than 64 KiB"));
    f = fopen(in_folder("wide.csv"), "w");
    for (int i = 0; i < 257; i++) {
        fprintf(f, "%stime [s]", i > 0 ? "," : "");
    }
    fclose(f);
    ck_assert_int_eq(lab_data_open(&d, in_folder("wide.csv"), &o, &err), STEIN_EPARSE);
    ck_assert_ptr_nonnull(strstr(err.msg, "more than 256 columns"));
    ck_assert_ptr_null(d);
}
END_TEST

/* ---- several strokes ---- */

START_TEST(a_dataset_is_all_files_or_none)
{
    char *good = lab__text("%s", write_file("good.csv", BODY));
    char *twin = lab__text("%s", write_file("twin.csv", BODY));
    char *bad = lab__text("%s", write_file("bad.csv", HEAD "0,1\n1,nan\n2,3\n3,4\n4,4\n"));
    char *other = lab__text("%s", write_file("other.csv", "# set load.mass: 90 g\n" BODY));
    lab_data_options o = lab_data_options_default(action);
    said s = {.n = 0};
    stein_err why = {STEIN_OK, ""};
    o.report = hear;
    o.ctx = &s;
    lab_dataset *set = NULL;
    const char *files[] = {good, bad, in_folder("absent.csv"), bad};
    ck_assert_int_eq(lab_dataset_open(&set, files, 4, &o, &why), STEIN_EPARSE);
    ck_assert_int_eq(s.n, 3);
    ck_assert_ptr_nonnull(strstr(why.msg, "bad.csv:3:3: "));
    ck_assert_int_eq(was_said(&s, "absent.csv cannot be read"), 1);
    ck_assert_int_eq(lab_dataset_open(&set, files, 0, &o, &why), STEIN_EINVAL);
    ck_assert_ptr_null(set);
    const char *fine[] = {good, other, twin};
    s.n = 0;
    ck_assert_stein(lab_dataset_open(&set, fine, 3, &o, err));
    ck_assert_int_eq(set->n, 3);
    ck_assert(set->stroke[1]->set[0].value == 0.09);
    ck_assert_int_eq(s.n, 1);
    ck_assert_ptr_nonnull(strstr(s.text[0], "the same data as"));
    lab_dataset_close(set);
    lab_dataset_close(NULL);
    free(good);
    free(twin);
    free(bad);
    free(other);
}
END_TEST

START_TEST(copies_of_a_record_are_one_message_with_their_number)
{
    char *a = lab__text("%s", write_file("a.csv", BODY));
    char *b = lab__text("%s", write_file("b.csv", BODY));
    char *c = lab__text("%s", write_file("c.csv", "# set load.mass: 90 g\n" BODY));
    lab_data_options o = lab_data_options_default(action);
    said s = {.n = 0};
    lab_dataset *set = NULL;
    const char *files[] = {a, c, b, a, c, a};
    o.report = hear;
    o.ctx = &s;
    ck_assert_stein(lab_dataset_open(&set, files, 6, &o, err));
    ck_assert_int_eq(s.n, 2);
    ck_assert_ptr_nonnull(strstr(s.text[0], "a.csv, 3 files: the same data as "));
    ck_assert_ptr_nonnull(strstr(s.text[0], "a.csv, counted 4 times"));
    ck_assert_ptr_nonnull(strstr(s.text[1], "c.csv, counted twice"));
    lab_dataset_close(set);
    free(a);
    free(b);
    free(c);
}
END_TEST

Suite *data_suite(void)
{
    Suite *suite = suite_create("data");
    TCase *tc = tcase_create("reader");
    tcase_add_checked_fixture(tc, make_folder, remove_folder);
    tcase_set_timeout(tc, 60.0);
    tcase_add_test(tc, wrong_times_of_events_are_reported_at_their_place);
    tcase_add_test(tc, every_part_of_a_file_is_kept_in_si);
    tcase_add_test(tc, a_part_that_was_taken_off_is_noted);
    tcase_add_test(tc, a_setting_is_known_to_its_last_digit);
    tcase_add_test(tc, a_number_that_is_known_has_the_last_word);
    tcase_add_test(tc, numbers_are_rounded_correctly_in_any_locale);
    tcase_add_test(tc, a_written_stroke_reads_back_bit_for_bit);
    tcase_add_test(tc, long_records_are_read_in_one_piece);
    tcase_add_test(tc, wrong_headers_are_refused_with_their_place);
    tcase_add_test(tc, wrong_rows_are_refused_with_their_place);
    tcase_add_test(tc, settings_that_contradict_are_refused_with_their_place);
    tcase_add_test(tc, a_load_cannot_be_set_where_there_is_none);
    tcase_add_test(tc, all_problems_are_reported_in_order_and_equal_ones_are_counted);
    tcase_add_test(tc, binary_files_are_refused);
    tcase_add_test(tc, a_dataset_is_all_files_or_none);
    tcase_add_test(tc, copies_of_a_record_are_one_message_with_their_number);
    suite_add_tcase(suite, tc);
    data_audit_cases(suite);
    data_forms_cases(suite);
    return suite;
}
