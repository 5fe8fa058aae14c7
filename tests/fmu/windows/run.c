/* SPDX-License-Identifier: GPL-3.0-or-later
 * run.c - a program for Windows that runs an FMU of FMI 3: 100 steps of 1 ms, then the variables
 * with the value references 1 and 2.
 *
 *      run.exe NAME.dll TOKEN
 */
#include <stdio.h>
#include <string.h>
#include <windows.h>

#include "fmi3.h"

static HMODULE library;

static void function(const char *name, void *to)
{
    FARPROC found = GetProcAddress(library, name);
    memcpy(to, &found, sizeof found);
}

int main(int argc, char **argv)
{
    static const fmi3ValueReference reference[2] = {1, 2};
    __typeof__(&fmi3InstantiateCoSimulation) create;
    __typeof__(&fmi3EnterInitializationMode) enter;
    __typeof__(&fmi3ExitInitializationMode) leave;
    __typeof__(&fmi3DoStep) step;
    __typeof__(&fmi3GetFloat64) get;
    __typeof__(&fmi3FreeInstance) drop;
    double value[2];
    library = argc == 3 ? LoadLibraryA(argv[1]) : NULL;
    if (library == NULL) {
        return 1;
    }
    function("fmi3InstantiateCoSimulation", &create);
    function("fmi3EnterInitializationMode", &enter);
    function("fmi3ExitInitializationMode", &leave);
    function("fmi3DoStep", &step);
    function("fmi3GetFloat64", &get);
    function("fmi3FreeInstance", &drop);
    fmi3Instance c = create("one", argv[2], NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    int status = c == NULL || enter(c, 0, 0.0, 0.0, 0, 0.0) != fmi3OK || leave(c) != fmi3OK;
    for (int i = 0; status == 0 && i < 100; i++) {
        fmi3Boolean event, over, early;
        double reached;
        status = step(c, 1e-3 * i, 1e-3, 1, &event, &over, &early, &reached) != fmi3OK;
    }
    if (status != 0 || get(c, reference, 2, value, 2) != fmi3OK) {
        return 1;
    }
    printf("%.17g %.17g\n", value[0], value[1]);
    drop(c);
    return 0;
}
