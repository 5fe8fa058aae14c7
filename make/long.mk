# SPDX-License-Identifier: GPL-3.0-or-later
# long.mk - tests of hours: builds that agree, fuzzing, sanitizers, mutations, blind diagnoses.

identity: cli  ## the same bits from every compiler, option and processor that is here: a table
	$(Q)STEIN_BUILD=$(B) sh tests/identity.sh

validate: $(B)/validate $(B)/validate-nist  ## published problems and facts against ours: docs/validation.md, build/validate.html
	$(Q)$(B)/validate >$(B)/validate.rows; code=$$?; \
	  $(B)/validate-nist >>$(B)/validate.rows || code=1; \
	  sh tests/validate/table.sh $(B)/validate.rows $(B)/validate.html && exit $$code

COUNT ?= 1000
CONTACTS ?= 200
second:  ## random mechanisms here and in Simbody, an independent library: COUNT=1000, and CONTACTS=200 that touch
	$(Q)if pkg-config --exists simbody; then $(MAKE) --no-print-directory -j$(JOBS) lib $(B)/second && \
	  STEIN_BUILD=$(B) sh tests/second.sh $(COUNT) $(CONTACTS) $(JOBS); \
	else echo "second: skipped, Simbody is not here: apt-get install libsimbody-dev, or make deps-more"; fi

SECONDS ?= 60
FUZZ_VARIANT := $(if $(MANY),fuzzmany,fuzz)
fuzz:  ## hostile bytes for every reader, with clang's libFuzzer and sanitizers: SECONDS=60 for each BYTES=longest input, MANY=1: more inputs, chosen less well, RECORD=table
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) VARIANT=$(FUZZ_VARIANT) CC=clang $(FUZZ:%=build-$(FUZZ_VARIANT)/fuzz-%)
	$(Q)BYTES="$(BYTES)" RECORD=$(RECORD) MANY=$(MANY) sh tests/fuzz.sh $(SECONDS) $(TARGETS)

# memory that was never written, threads that meet, blocks that are lost
sanitize:  ## suites under clang's memory sanitizer, the thread sanitizer and valgrind
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) VARIANT=memory CC=clang build-memory/check
	$(Q)sh tests/sanitize.sh memory
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) VARIANT=thread build-thread/check
	$(Q)sh tests/sanitize.sh thread
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) build/check
	$(Q)sh tests/sanitize.sh valgrind
	$(Q)[ -z "$(PYTHON_TESTED)" ] || { $(MAKE) --no-print-directory python && sh tests/sanitize.sh python; }

SOAK ?= 170
# suites and scripts of which `make check` takes a share
SHARED_SUITES  := generator fit curve measured measured_laws suspicions
SHARED_SCRIPTS := fmu python world
soak: deps  ## hours of the same: 1e5 random regulations, 3000 kills, all faults, all builds, all fuzz targets
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) tested
	$(Q)SOAK=1 $(MAKE) --no-print-directory -k $(SHARED_SUITES:%=suite-%) $(SHARED_SCRIPTS:%=script-%)
	$(Q)$(MAKE) --no-print-directory second
	$(Q)STEIN_BUILD=$(B) SOAK=$(SOAK) CK_RUN_SUITE=wrong $(B)/check
	$(Q)STEIN_BUILD=$(B) SOAK=$(SOAK) CK_RUN_SUITE=energy $(B)/check
	$(Q)STEIN_BUILD=$(B) KILLS=1000 sh tests/test_sweep.sh
	$(Q)STEIN_BUILD=$(B) KILLS=1000 sh tests/test_kills.sh
	$(Q)$(B)/faults all
	$(Q)$(MAKE) --no-print-directory identity
	$(Q)$(MAKE) --no-print-directory sanitize
	$(Q)$(MAKE) --no-print-directory fuzz SECONDS=$(SECONDS)

N ?= 180
mutate:  ## small mistakes in generator, laws, notch and integrators, for the suites to find: N=180 SEED=1
	$(Q)sh tests/mutate.sh $(N) $(SEED) $(JOBS) $(FILES)

DRAWS  ?= 200
WORLD  ?=
LEVELS ?= $(if $(WORLD),null$(COMMA)small$(COMMA)clear$(COMMA)gross,null$(COMMA)L1$(COMMA)L2$(COMMA)L3)
SEED   ?= 1
THREADS ?= 1
HIDDEN  = $(B)/hidden $(1) --build $(B) --draws $(DRAWS) --levels $(LEVELS) --seed $(SEED) $(if $(RECORD),--record $(RECORD)) \
          $(if $(WORLD),--world $(WORLD)) $(if $(ONLY),--only $(ONLY)) $(if $(LIMIT),--limit $(LIMIT))
hidden: deps  ## effects hidden in data, diagnosed blindly: DRAWS=200 LEVELS=null,L1,L2,L3,L1x2,X1,T1 SEED=1 THREADS=1; WORLD=any (any mechanism) LEVELS=null,small,clear,gross,two,law,wrong,mistake ONLY=mechanism LIMIT=seconds
	$(Q)$(MAKE) --no-print-directory all $(B)/reality $(B)/world $(B)/hidden
	$(Q)$(call HIDDEN,run) --jobs $(JOBS) --threads $(THREADS)
hidden-readme: $(B)/hidden  ## put the table of the last `make hidden` into docs/validation.md
	$(Q)$(call HIDDEN,readme docs/validation.md)
