# SPDX-License-Identifier: GPL-3.0-or-later
# check.mk - make check: every suite and every script is a job.

# every suite of tests/suites.h and every tests/test_*.sh is a job of its own
SUITE_JOBS  := $(addprefix suite-,$(shell sed -n 's/^ *X(\([a-z_]*\)).*/\1/p' tests/suites.h))
SCRIPT_JOBS := $(patsubst tests/test_%.sh,script-%,$(wildcard tests/test_*.sh))
# the longest ones first, so that no processor waits for one of them in the end
LONGEST     := script-page suite-curve script-fmu script-python suite-search suite-measured suite-measured_laws \
  script-faults script-deb suite-plan suite-posed suite-reality suite-suspicions suite-generator script-hidden script-world
ALL_JOBS    := $(LONGEST) $(filter-out $(LONGEST),$(SCRIPT_JOBS) $(SUITE_JOBS))
# one more than processors: browsers, killed programs and compilers are waited for
JOBS ?= $(shell echo $$(($$(nproc) + 1)))

# an independent library, if it is there and not built with other options than our own objects
SECOND_TESTED := $(if $(filter release,$(VARIANT)),$(shell pkg-config --exists simbody 2>/dev/null && echo $(B)/second))
# what the tests run
tested: all shared manual $(B)/check $(B)/reality $(B)/world $(B)/hidden $(FUZZ:%=$(B)/replay-%) $(B)/faults $(B)/comma \
  $(B)/validate $(B)/validate-nist $(B)/importer $(PYTHON_TESTED) $(SECOND_TESTED)

check: deps-check  ## build and run every test
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) tested
	$(Q)rm -rf $(B)/cache
	$(Q)$(MAKE) --no-print-directory -k -j$(JOBS) --output-sync=target \
	  $(if $(TESTS),suite-$(TESTS),$(ALL_JOBS))

# calls whose every place that asks for memory is refused it; `make check` takes a share of them, `make
# coverage`, which counts where failures lead, all
FAULT_JOBS  := $(addprefix faults-,diagnose plan study fit resume candidates page fmu)

.PHONY: $(SUITE_JOBS) $(SCRIPT_JOBS) $(FAULT_JOBS)
# limits of tests are for what hangs: a machine with other work, or sanitizers, take their time
PATIENCE := $(if $(filter san coverage,$(VARIANT)),20,5)
SCRIPT_LIMIT := $(PATIENCE)00
$(SUITE_JOBS): suite-%: $(B)/check
	$(Q)STEIN_BUILD=$(B) CK_RUN_SUITE=$* CK_TIMEOUT_MULTIPLIER=$(PATIENCE) $(B)/check
$(SCRIPT_JOBS): script-%: tests/test_%.sh
	$(Q)STEIN_BUILD=$(B) timeout -k 10 $(SCRIPT_LIMIT) sh $< || \
	  { code=$$?; [ $$code -ne 124 ] || echo "$<: not over after $(SCRIPT_LIMIT) s"; exit $$code; }
$(FAULT_JOBS): faults-%: $(B)/faults
	$(Q)$(B)/faults $*

golden: $(B)/steingen $(B)/stein $(B)/check  ## accept the generated texts and the bits of now as the golden ones
	$(Q)$(B)/stein version --hash | sed 1d >tests/golden/hash
	$(Q)$(B)/steingen models/pendulum.yaml -o tests/golden/pendulum.c
	$(Q)STEIN_GOLDEN=accept CK_RUN_SUITE=generator CK_RUN_CASE=text $(B)/check
