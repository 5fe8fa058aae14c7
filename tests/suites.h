/* SPDX-License-Identifier: GPL-3.0-or-later
 * suites.h - every Check suite once: prototypes and the runner are expanded from this list.
 * A new suite is one line here.
 */
#ifndef SUITES_H
#define SUITES_H

#include <check.h>

#define SUITES(X)    \
    X(law)           \
    X(elementary)    \
    X(core)          \
    X(realtime)      \
    X(import)        \
    X(import_robots) \
    X(formats)       \
    X(derivative)    \
    X(sensitivity)   \
    X(integrator)    \
    X(balance)       \
    X(stiff)         \
    X(batch)         \
    X(driven)        \
    X(drive)         \
    X(armature)      \
    X(contact)       \
    X(stroke)        \
    X(facts)         \
    X(mechanism)     \
    X(parts)         \
    X(table)         \
    X(generator)     \
    X(digest)        \
    X(lab)           \
    X(study)         \
    X(sweep)         \
    X(journal)       \
    X(data)          \
    X(settings)      \
    X(suspicions)    \
    X(effects)       \
    X(structure)     \
    X(extend)        \
    X(change)        \
    X(mixed)         \
    X(reality)       \
    X(outside)       \
    X(fit)           \
    X(initial)       \
    X(fit_claims)    \
    X(events)        \
    X(forces)        \
    X(many)          \
    X(stop)          \
    X(measured)      \
    X(measured_laws) \
    X(motion_check)  \
    X(curve)         \
    X(law_search)    \
    X(judge)         \
    X(hypotheses)    \
    X(search)        \
    X(mistakes)      \
    X(odd_records)   \
    X(coupling)      \
    X(posed)         \
    X(windows)       \
    X(show)          \
    X(report)        \
    X(seen)          \
    X(before)        \
    X(plan)          \
    X(plan_read)     \
    X(patch)         \
    X(pictures)      \
    X(page_text)     \
    X(definitions)   \
    X(wrong)         \
    X(ranges)        \
    X(energy)        \
    X(loops)         \
    X(linkages)      \
    X(space)         \
    X(limits)        \
    X(linear)        \
    X(reaction)      \
    X(stick)         \
    X(seldom)        \
    X(edges)         \
    X(edges_lab)

#define SUITE_PROTOTYPE(name) Suite *name##_suite(void);
SUITES(SUITE_PROTOTYPE)
#undef SUITE_PROTOTYPE

#endif
