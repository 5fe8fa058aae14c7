/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - runs every Check suite. CK_RUN_SUITE=name runs one, CK_FORK=no eases debugging.
 */
#include <gsl/gsl_errno.h>
#include <stdlib.h>

#include "suites.h"

int main(void)
{
    if (getenv("CK_RUN_SUITE") != NULL && *getenv("CK_RUN_SUITE") == '\0') {
        unsetenv("CK_RUN_SUITE");
    }
    gsl_set_error_handler_off(); // as in the program: a singular matrix is an answer, no abort
    SRunner *runner = srunner_create(NULL);
#define SUITE_ADD(name) srunner_add_suite(runner, name##_suite());
    SUITES(SUITE_ADD)
#undef SUITE_ADD
    srunner_run_all(runner, CK_ENV);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
