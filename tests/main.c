/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - runs every Check suite. CK_RUN_SUITE=name runs one, CK_FORK=no eases debugging.
 */
#include <check.h>
#include <stdlib.h>

Suite *law_suite(void);
Suite *core_suite(void);
Suite *integrator_suite(void);
Suite *contact_suite(void);
Suite *stroke_suite(void);
Suite *facts_suite(void);
Suite *mechanism_suite(void);
Suite *generator_suite(void);
Suite *lab_suite(void);

int main(void)
{
    if (getenv("CK_RUN_SUITE") != NULL && *getenv("CK_RUN_SUITE") == '\0') {
        unsetenv("CK_RUN_SUITE");
    }
    SRunner *runner = srunner_create(law_suite());
    srunner_add_suite(runner, core_suite());
    srunner_add_suite(runner, integrator_suite());
    srunner_add_suite(runner, contact_suite());
    srunner_add_suite(runner, stroke_suite());
    srunner_add_suite(runner, facts_suite());
    srunner_add_suite(runner, mechanism_suite());
    srunner_add_suite(runner, generator_suite());
    srunner_add_suite(runner, lab_suite());
    srunner_run_all(runner, CK_ENV);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
