# SPDX-License-Identifier: GPL-3.0-or-later
# quality.mk - format, analysers, coverage.

SOURCES = $(wildcard src/*/*.[ch] src/*/*/*.[ch] gen/*.[ch] include/stein/*.h $(TESTED:%=%/*.[ch]) tests/fmu/*.[ch] \
            tests/reality/*.[ch] tests/world/*.[ch] tests/hidden/*.[ch] tests/threads/*.[ch] tests/identity/*.c tests/fuzz/*.[ch] \
            tests/faults/*.[ch] tests/locale/*.c tests/lanes/*.[ch] tests/memory/*.c tests/mutate/*.c tests/validate/*.[ch] tests/second/*.[ch] \
            tests/second/*.cpp examples/*/*.c bench/*.[ch])
format:  ## clang-format every source
	$(Q)clang-format -i $(SOURCES)
format-check:  ## fail when clang-format would change a source
	$(Q)clang-format --dry-run --Werror $(SOURCES)
# sizes of mechanisms are capped, so products of them as int do not overflow: no widening asked for
# Left out: arrays of pointers, whose elements are of a pointer's size; tangent.c, which is made of other
# files; and advice about names and buffers that C11 has nothing for
TIDY_CHECKS := -* clang-analyzer-* bugprone-* -bugprone-easily-swappable-parameters \
  -bugprone-implicit-widening-of-multiplication-result -bugprone-sizeof-expression \
  -bugprone-suspicious-include -bugprone-reserved-identifier -clang-analyzer-valist.Uninitialized \
  -clang-analyzer-security.insecureAPI.DeprecatedOrUnsafeBufferHandling \
  -clang-analyzer-security.insecureAPI.strcpy -clang-analyzer-optin.performance.Padding
tidy:  ## clang-tidy's analyser and bug checks
	$(Q)printf '%s\n' $(CORE_SRC) $(MODEL_SRC) $(GEN_SRC) gen/main.c $(LAB_SRC) $(CLI_SRC) $(if $(PYTHON_TESTED),$(PY_SRC)) \
	  | xargs -P$(JOBS) -I{} clang-tidy --quiet --warnings-as-errors='*' --checks='$(subst $(SPACE),$(COMMA),$(TIDY_CHECKS))' \
	  {} -- $(ALL_CPPFLAGS) $(PY_INCLUDE) -std=c11

# gcc 12 loses sight of what is stored behind two pointers and calls it a leak; tests/faults counts blocks
# and takes complex numbers that a loop stores for none: the laws of tangent.c are those of the others;
# it takes a shift of each lane for a shift of one bit: the laws of contact_lanes.c are those of one lane
ANALYZED := $(CORE_SRC) $(GEN_SRC) gen/main.c $(MODEL_SRC)
analyze: models  ## cppcheck and gcc's analyser on core, generator and reader
	$(Q)cppcheck --quiet --enable=warning,performance,portability --inline-suppr --std=c11 \
	  --error-exitcode=1 -Iinclude -I$(B)/include -Isrc/core -Isrc/model -Igen $(ANALYZED)
	$(Q)printf '%s\n' $(filter-out src/core/tangent.c src/core/contact_lanes.c,$(ANALYZED)) | xargs -P$(JOBS) -I{} gcc -fanalyzer -Wno-analyzer-malloc-leak -Werror -O1 \
	  -std=c11 $(ALL_CPPFLAGS) -c {} -o /dev/null

# Every line and branch that the tests reach, of what is linked into the library and the lab. Without
# optimisation each condition of a && b, a || b and !a is a jump of its own, so gcov's branches are
# the outcomes of conditions: of readers and step control all of them are listed. That is condition and
# decision coverage; MC/DC, which compilers measure from gcc 14 and clang 18 on, is `make mcdc`. A
# comparison whose value is kept, and a case of a switch, count as what they are. real.h, operators of
# one number and of several, is left out: gcovr knows a function by its name, and these are there twice.
READERS := src/core/step.c src/core/adapt.c src/core/batch_run.c src/core/state.c src/model/ src/lab/data/ \
           src/lab/sweep/journal.c
coverage: deps  ## lines and branches that the tests reach, conditions of readers and steps: COVER=suites
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) VARIANT=coverage tested
	-$(Q)$(MAKE) --no-print-directory -k -j$(JOBS) --output-sync=target VARIANT=coverage $(COVER)
	$(Q)gcovr -j$(JOBS) --gcov-ignore-parse-errors --exclude-unreachable-branches --exclude-throw-branches -r . \
	  -f src -f gen -e src/core/real.h --json build-coverage/coverage.json build-coverage/obj
	$(Q)gcovr -r . -a build-coverage/coverage.json
	$(Q)echo "outcomes of conditions that were seen (condition and decision coverage), and lines where one was not:"
	$(Q)gcovr -r . -a build-coverage/coverage.json --branches $(READERS:%=-f %)
	$(Q)echo "all of src and gen:" && gcovr -r . -a build-coverage/coverage.json --print-summary -o build-coverage/lines.txt
COVER ?= $(firstword $(FAULT_JOBS)) $(ALL_JOBS) $(FAULT_JOBS)

# Each condition of a decision shown to decide it, all others being what they are: gcc 12 and clang 14
# cannot count that, and clang leaves out conditions inside of calls inside of conditions, which it names.
# The suites are those that read files or take steps.
MCDC        ?= 19
MCDC_SUITES ?= core integrator edges edges_lab seldom ranges wrong mechanism parts table data settings journal \
               import formats driven batch
mcdc:  ## MC/DC of readers and step control, with clang 18 or newer: MCDC=19 MCDC_SUITES=names
	$(Q)command -v clang-$(MCDC) llvm-cov-$(MCDC) >/dev/null || { echo "run: apt-get install clang-$(MCDC) llvm-$(MCDC)"; exit 1; }
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) VARIANT=mcdc CC=clang-$(MCDC) build-mcdc/check build-mcdc/faults
	$(Q)rm -f build-mcdc/*.profraw
	-$(Q)$(MAKE) --no-print-directory -k -j$(JOBS) --output-sync=target VARIANT=mcdc CC=clang-$(MCDC) \
	  $(addprefix suite-,$(MCDC_SUITES))
	-$(Q)for f in read problems sections data; do build-mcdc/faults $$f; done
	$(Q)llvm-profdata-$(MCDC) merge -o build-mcdc/profile build-mcdc/*.profraw
	$(Q)llvm-cov-$(MCDC) report build-mcdc/check -object build-mcdc/faults -instr-profile build-mcdc/profile --show-mcdc-summary | \
	  grep $(READERS:%=-e '^%') | awk '{all += $$(NF - 2); seen += $$(NF - 2) - $$(NF - 1); \
	    printf "%-34s %4d of %4d conditions\n", $$1, $$(NF - 2) - $$(NF - 1), $$(NF - 2)} \
	    END {printf "MC/DC of readers and step control: %d of %d conditions, %.1f %%\n", seen, all, 100 * seen / all}'
