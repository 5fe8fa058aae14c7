/* SPDX-License-Identifier: GPL-3.0-or-later
 * description.c - modelDescription.xml of FMI 3.0 and 2.0, and buildDescription.xml.
 *
 * Names of the file are letters, digits and "_" already; whatever stands in quotes is nevertheless
 * escaped (xml.c). There is no date in it: the same mechanism gives the same bytes.
 */
#include <math.h>
#include <string.h>

#include "fmu.h"
#include "stein/version.h"

static const char *const causality[] = {"independent", "output", "input", "parameter", "local"};
static const char *const variability[] = {"fixed", "tunable", "discrete", "continuous"};

static const struct category {
    const char *name, *text;
} categories[] = {
    {"logEvents", "contacts that begin and end, escapement, impact, phases of a notch"},
    {"logStatusDiscard", "why a step was not made"},
    {"logStatusError", "why a call was refused"},
};
enum { CATEGORIES = sizeof categories / sizeof *categories };

/* its capabilities for co-simulation and model exchange; closed by NULL */
static const char *const slave3[] = {
    "canHandleVariableCommunicationStepSize", "canGetAndSetFMUState",       "canSerializeFMUState",
    "providesDirectionalDerivatives",         "providesAdjointDerivatives", NULL};
static const char *const slave2[] = {"canHandleVariableCommunicationStepSize",
                                     "canInterpolateInputs",
                                     "canNotUseMemoryManagementFunctions",
                                     "canGetAndSetFMUstate",
                                     "canSerializeFMUstate",
                                     "providesDirectionalDerivative",
                                     NULL};
static const char *const exchange3[] = {"canGetAndSetFMUState", "canSerializeFMUState", NULL};
static const char *const exchange2[] = {"canNotUseMemoryManagementFunctions",
                                        "canGetAndSetFMUstate", "canSerializeFMUstate", NULL};

/* ---- head ---- */

static void put_root(FILE *f, int version, const fmu_list *list, const char *token)
{
    const char *about = fmu__about(list->m, "", "");
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription", f);
    fmu__attribute(f, "fmiVersion", version == 3 ? "3.0" : "2.0");
    fmu__attribute(f, "modelName", list->m->name);
    fmu__attribute(f, version == 3 ? "instantiationToken" : "guid", token);
    if (about != NULL) {
        fmu__attribute(f, "description", about);
    }
    fmu__attribute(f, "license", "MIT");
    fmu__attribute(f, "generationTool", "libstein " STEIN_VERSION);
    fmu__attribute(f, "variableNamingConvention", "structured");
    if (version == 2) {
        fprintf(f, " numberOfEventIndicators=\"%d\"", fmi_guards(list->model));
    }
    fputs(">\n", f);
}

static void put_kind(FILE *f, int version, const fmu_list *list, const char *element,
                     const char *const *ability, const char *const *sources)
{
    fprintf(f, "  <%s", element);
    fmu__attribute(f, "modelIdentifier", list->m->name);
    for (int i = 0; ability[i] != NULL; i++) {
        fmu__attribute(f, ability[i], "true");
    }
    if (version == 3) {
        fputs("/>\n", f);
        return;
    }
    fputs(">\n    <SourceFiles>\n", f);
    for (int i = 0; sources[i] != NULL; i++) {
        fputs("      <File", f);
        fmu__attribute(f, "name", sources[i]);
        fputs("/>\n", f);
    }
    fprintf(f, "    </SourceFiles>\n  </%s>\n", element);
}

static void put_kinds(FILE *f, int version, const fmu_list *list, const char *const *sources)
{
    put_kind(f, version, list, "ModelExchange", version == 3 ? exchange3 : exchange2, sources);
    put_kind(f, version, list, "CoSimulation", version == 3 ? slave3 : slave2, sources);
}

static void put_categories(FILE *f)
{
    fputs("  <LogCategories>\n", f);
    for (int i = 0; i < CATEGORIES; i++) {
        fputs("    <Category", f);
        fmu__attribute(f, "name", categories[i].name);
        fmu__attribute(f, "description", categories[i].text);
        fputs("/>\n", f);
    }
    fputs("  </LogCategories>\n", f);
}

/* a communication step that shows the motion: 10^k steps, some hundred of them */
static void put_experiment(FILE *f, const stein_model *m)
{
    int steps = 1;
    while (m->until / (10.0 * steps * m->dt) >= 200.0 && steps < 100000000) {
        steps *= 10;
    }
    fputs("  <DefaultExperiment", f);
    fmu__attribute_number(f, "startTime", 0.0);
    fmu__attribute_number(f, "stopTime", m->until);
    fmu__attribute_number(f, "stepSize", steps * m->dt);
    fputs("/>\n", f);
}

/* ---- variables ---- */

/* "" if this version has no attribute for it */
static const char *initial_of(const fmu_variable *v, int version)
{
    switch (v->causality) {
    case FMU_PARAMETER: return "exact";
    case FMU_INPUT: return version == 3 ? "exact" : "";
    case FMU_INDEPENDENT: return "";
    default: return "calculated";
    }
}

static void put_common(FILE *f, const fmu_variable *v, int version)
{
    fmu__attribute(f, "name", v->name);
    fprintf(f, " valueReference=\"%u\"", v->reference);
    fmu__attribute(f, "description", v->text);
    fmu__attribute(f, "causality", causality[v->causality]);
    fmu__attribute(f, "variability", variability[v->variability]);
    if (*initial_of(v, version) != '\0') {
        fmu__attribute(f, "initial", initial_of(v, version));
    }
}

/* attributes of the type; a derivative is of a value reference in FMI 3, of a place in FMI 2 */
static void put_type(FILE *f, const fmu_list *list, const fmu_variable *v, int version)
{
    if (v->boolean) {
        fmu__attribute(f, "start", v->start != 0.0 ? "true" : "false");
        return;
    }
    if (strcmp(v->unit, "1") != 0) {
        fmu__attribute(f, "unit", v->unit);
    }
    if (v->derivative_of >= 0) {
        fprintf(f, " derivative=\"%u\"",
                version == 3 ? list->v[v->derivative_of].reference
                             : (unsigned)v->derivative_of + 1u);
    }
    if (v->has_start) {
        fmu__attribute_number(f, "start", v->start);
    }
}

static void put_variable(FILE *f, const fmu_list *list, const fmu_variable *v, int version)
{
    if (version == 3) {
        fprintf(f, "    <%s", v->boolean ? "Boolean" : "Float64");
        put_common(f, v, 3);
        put_type(f, list, v, 3);
        fputs("/>\n", f);
        return;
    }
    fputs("    <ScalarVariable", f);
    put_common(f, v, 2);
    fprintf(f, ">\n      <%s", v->boolean ? "Boolean" : "Real");
    put_type(f, list, v, 2);
    fputs("/>\n    </ScalarVariable>\n", f);
}

/* ---- structure ---- */

/* Which inputs an output follows at once, and which states; in FMI 3 parameters count as well, and
 * all of them may matter. Without an attribute everything would depend on everything, and importers
 * would find loops that do not exist. */
static void put_dependencies(FILE *f, const fmu_list *list, const fmu_variable *v, int version)
{
    const char *blank = "";
    fputs(" dependencies=\"", f);
    for (int i = 0; i < list->n; i++) {
        const fmu_variable *u = &list->v[i];
        int on_input = u->causality == FMU_INPUT && fmu__depends(list->model, v, u);
        int on_param = version == 3 && u->causality == FMU_PARAMETER;
        int on_state =
            u->is.kind == FMI_COORDINATE && u->is.order < 2 && v->variability != FMU_DISCRETE;
        if (on_input || on_param || on_state) {
            fprintf(f, "%s%u", blank, version == 3 ? u->reference : (unsigned)i + 1u);
            blank = " ";
        }
    }
    putc('"', f);
}

static void put_unknown(FILE *f, const fmu_list *list, int i, int version, const char *element,
                        int with_dependencies)
{
    fprintf(f, "%s<%s %s=\"%u\"", version == 3 ? "    " : "      ", element,
            version == 3 ? "valueReference" : "index",
            version == 3 ? list->v[i].reference : (unsigned)i + 1u);
    if (with_dependencies) {
        put_dependencies(f, list, &list->v[i], version);
    }
    fputs("/>\n", f);
}

/* the variables of one part of the structure: outputs, derivatives of states, initial unknowns
 * (outputs, states and their derivatives), event indicators */
typedef enum { OUTPUTS, RATES, UNKNOWN, INDICATORS } part;

static int is_in(const fmu_variable *v, part of)
{
    int coordinate = v->is.kind == FMI_COORDINATE;
    switch (of) {
    case OUTPUTS: return v->causality == FMU_OUTPUT;
    case RATES: return coordinate && v->is.order > 0;
    case UNKNOWN: return coordinate || v->causality == FMU_OUTPUT;
    default: return v->is.kind == FMI_GUARD;
    }
}

static void put_part(FILE *f, const fmu_list *list, int version, part of)
{
    static const char *const element3[] = {"Output", "ContinuousStateDerivative", "InitialUnknown",
                                           "EventIndicator"};
    static const char *const element2[] = {"Outputs", "Derivatives", "InitialUnknowns"};
    int any = 0;
    for (int i = 0; i < list->n; i++) {
        if (!is_in(&list->v[i], of)) {
            continue;
        }
        if (version == 2 && !any++) {
            fprintf(f, "    <%s>\n", element2[of]);
        }
        put_unknown(f, list, i, version, version == 3 ? element3[of] : "Unknown", of == OUTPUTS);
    }
    if (any) { // a list that is there has entries: a mechanism may have no outputs
        fprintf(f, "    </%s>\n", element2[of]);
    }
}

static void put_structure(FILE *f, const fmu_list *list, int version)
{
    fputs("  <ModelStructure>\n", f);
    put_part(f, list, version, OUTPUTS);
    put_part(f, list, version, RATES);
    put_part(f, list, version, UNKNOWN);
    if (version == 3) {
        put_part(f, list, version, INDICATORS);
    }
    fputs("  </ModelStructure>\n", f);
}

void fmu__describe(FILE *f, int version, const fmu_list *list, const char *token,
                   const char *const *sources)
{
    put_root(f, version, list, token);
    put_kinds(f, version, list, sources);
    fmu__units(f, list);
    put_categories(f);
    put_experiment(f, list->model);
    fputs("  <ModelVariables>\n", f);
    for (int i = 0; i < list->n; i++) {
        put_variable(f, list, &list->v[i], version);
    }
    fputs("  </ModelVariables>\n", f);
    put_structure(f, list, version);
    fputs("</fmiModelDescription>\n", f);
}

/* ---- how to build it ---- */

void fmu__describe_build(FILE *f, const fmu_list *list, const char *const *sources)
{
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n"
          "  <BuildConfiguration",
          f);
    fmu__attribute(f, "modelIdentifier", list->m->name);
    fputs(">\n    <SourceFileSet language=\"C11\"", f);
    fmu__attribute(f, "compilerOptions", fmu__compiler_options);
    fputs(">\n", f);
    for (int i = 0; sources[i] != NULL; i++) {
        fputs("      <SourceFile", f);
        fmu__attribute(f, "name", sources[i]);
        fputs("/>\n", f);
    }
    fputs("      <IncludeDirectory name=\".\"/>\n    </SourceFileSet>\n"
          "    <Library name=\"m\" external=\"true\" description=\"C mathematics library\"/>\n"
          "  </BuildConfiguration>\n</fmiBuildDescription>\n",
          f);
}
