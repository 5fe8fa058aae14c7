/* SPDX-License-Identifier: MIT
 * none3.c - the functions of FMI 3.0 that have to be there and that this FMU does not have:
 * variables of other types, clocks, structural parameters, scheduled execution.
 *
 * Each logs the reason and returns an error. To read or write no variables at all is no error.
 */
#include "internal3.h"

static const char no_events[] = "has no event mode";
static const char no_clocks[] = "has no clocks";

/* ---- variables of other types ---- */

#define NO_VARIABLES(type)                                                                         \
    fmi3Status fmi3Get##type(fmi3Instance c, FMI3_REFERENCES, fmi3##type values[], size_t n)       \
    {                                                                                              \
        (void)references, (void)values, (void)n;                                                   \
        return nreferences == 0 ? fmi3OK                                                           \
                                : refuse3(c, "fmi3Get" #type, "has no variables of " #type);       \
    }                                                                                              \
    fmi3Status fmi3Set##type(fmi3Instance c, FMI3_REFERENCES, const fmi3##type values[], size_t n) \
    {                                                                                              \
        (void)references, (void)values, (void)n;                                                   \
        return nreferences == 0 ? fmi3OK                                                           \
                                : refuse3(c, "fmi3Set" #type, "has no variables of " #type);       \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance c, FMI3_REFERENCES, size_t sizes[], fmi3Binary values[],
                         size_t nvalues)
{
    (void)references, (void)sizes, (void)values, (void)nvalues;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetBinary", "has no variables of Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, FMI3_REFERENCES, const size_t sizes[],
                         const fmi3Binary values[], size_t nvalues)
{
    (void)references, (void)sizes, (void)values, (void)nvalues;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetBinary", "has no variables of Binary");
}

/* ---- clocks ---- */

fmi3Status fmi3GetClock(fmi3Instance c, FMI3_REFERENCES, fmi3Clock values[])
{
    (void)references, (void)values;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetClock", no_clocks);
}

fmi3Status fmi3SetClock(fmi3Instance c, FMI3_REFERENCES, const fmi3Clock values[])
{
    (void)references, (void)values;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetClock", no_clocks);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, FMI3_REFERENCES, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[])
{
    (void)references, (void)intervals, (void)qualifiers;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetIntervalDecimal", no_clocks);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, FMI3_REFERENCES, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)references, (void)counters, (void)resolutions, (void)qualifiers;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetIntervalFraction", no_clocks);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, FMI3_REFERENCES, fmi3Float64 shifts[])
{
    (void)references, (void)shifts;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetShiftDecimal", no_clocks);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, FMI3_REFERENCES, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[])
{
    (void)references, (void)counters, (void)resolutions;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3GetShiftFraction", no_clocks);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, FMI3_REFERENCES, const fmi3Float64 intervals[])
{
    (void)references, (void)intervals;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetIntervalDecimal", no_clocks);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, FMI3_REFERENCES, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[])
{
    (void)references, (void)counters, (void)resolutions;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetIntervalFraction", no_clocks);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, FMI3_REFERENCES, const fmi3Float64 shifts[])
{
    (void)references, (void)shifts;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetShiftDecimal", no_clocks);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, FMI3_REFERENCES, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[])
{
    (void)references, (void)counters, (void)resolutions;
    return nreferences == 0 ? fmi3OK : refuse3(c, "fmi3SetShiftFraction", no_clocks);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock,
                                      fmi3Float64 activationTime)
{
    (void)clock, (void)activationTime;
    return refuse3(c, "fmi3ActivateModelPartition", no_clocks);
}

/* ---- modes ---- */

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    return refuse3(c, "fmi3EnterConfigurationMode", "has no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    return refuse3(c, "fmi3ExitConfigurationMode", "has no structural parameters");
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    return refuse3(c, "fmi3EnterStepMode", no_events);
}

/* ---- structure ---- */

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference reference,
                                               size_t *n)
{
    (void)reference, (void)n;
    return refuse3(c, "fmi3GetNumberOfVariableDependencies",
                   "has its dependencies in modelDescription.xml");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t elementsOfDependent[],
                                       fmi3ValueReference independents[],
                                       size_t elementsOfIndependents[], fmi3DependencyKind kinds[],
                                       size_t n)
{
    (void)dependent, (void)elementsOfDependent, (void)independents, (void)elementsOfIndependents,
        (void)kinds, (void)n;
    return refuse3(c, "fmi3GetVariableDependencies",
                   "has its dependencies in modelDescription.xml");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, FMI3_REFERENCES, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t nvalues)
{
    (void)references, (void)nreferences, (void)orders, (void)values, (void)nvalues;
    return refuse3(c, "fmi3GetOutputDerivatives", "has no derivatives of outputs");
}
