# libstein - `make help` lists the targets.
# Products go to build/ (VARIANT=release) or build-VARIANT/ (debug, san); nothing else is written.
VARIANT ?= release
PREFIX  ?= /usr/local
CC      ?= cc
CXX     ?= c++
AR      ?= ar
V       ?= 0
Q       := $(if $(filter 1,$(V)),,@)
VERSION := $(shell sed -n 's/^.define STEIN_VERSION *"\(.*\)"/\1/p' include/stein/version.h)
RELEASED := 2026-11-21

B := $(if $(filter release,$(VARIANT)),build,build-$(VARIANT))

WARN := -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wstrict-prototypes -Wmissing-prototypes \
        -Wundef -Wvla -Werror
OPT_release := -O2 -g
OPT_debug   := -O0 -g3
OPT_san     := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=all
OPT_memory  := -O1 -g -fsanitize=memory -fsanitize-memory-track-origins -fno-omit-frame-pointer -fno-sanitize-recover=all
OPT_thread  := -O1 -g -fsanitize=thread -fno-omit-frame-pointer
OPT_fuzz    := -O2 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all
# the same checks, and paths watched without the operands of comparisons: half the time of an input
OPT_fuzzmany := $(OPT_fuzz) -fno-sanitize-coverage=trace-cmp,trace-div,trace-gep,stack-depth
OPT_coverage := -O0 -g --coverage -fprofile-update=atomic -fprofile-exclude-files='.*real[.]h'
OPT_mcdc    := -O1 -g -fprofile-instr-generate='$(CURDIR)/build-mcdc/%m.profraw' -fcoverage-mapping -fcoverage-mcdc \
               -Wno-enum-float-conversion
OPT  := $(OPT_$(VARIANT))
# The same bits with and without fused multiply-add. -ffp-contract=off is not enough: where gcc 12
# pairs a difference with a sum it fuses both. Pairs are no gain either: two numbers that were just
# written one by one would be read as one, and wait until both stores are through.
# -fno-math-errno: a square root is an instruction, and nothing is said in errno
EXACT := -ffp-contract=off -fno-tree-slp-vectorize -fno-math-errno
ALL_CFLAGS   := -std=c11 $(WARN) $(OPT) $(EXACT) -fPIC -ffile-prefix-map=$(CURDIR)=. $(CFLAGS)
LAB := src/lab src/lab/data src/lab/fit src/lab/effects src/lab/search src/lab/law src/lab/verdict \
       src/lab/diagnosis src/lab/report src/lab/plan src/lab/study src/lab/import src/lab/page \
       src/lab/fmu src/lab/draw
ALL_CPPFLAGS := -D_POSIX_C_SOURCE=200809L -DSTEIN_RELEASED='"$(RELEASED)"' -Iinclude -I$(B)/include \
                -Isrc/core -Isrc/model -Isrc/fmi -Igen $(LAB:%=-I%) -Isrc/cli $(CPPFLAGS)

# ---- dependencies: Debian packages, found by pkg-config -------------------------------------------
DEBIAN := gcc g++ make pkg-config libyaml-dev libgsl-dev libexpat1-dev zlib1g-dev check gnuplot-nox parallel
PKGS   := yaml-0.1 gsl expat zlib check
TOOLS  := gnuplot parallel
# what `make check` uses besides; a test without its tool is skipped and says so
DEBIAN_CHECK := cmake man-db mandoc lilv-utils lv2-dev python3-numpy python3-scipy libxml2-utils unzip \
                debhelper fakeroot zsh fish
TOOLS_CHECK  := cmake man mandoc lv2apply xmllint unzip dh fakeroot zsh fish
# the Python module (packaging/python.mk) and its tests
DEBIAN_PYTHON := python3-dev python3-numpy python3-pytest python3-pip python3-pandas python3-matplotlib python3-sympy mypy
TOOLS_PYTHON  := python3-config pytest-3 mypy
# what `stein page` compiles with, and what the tests of its pages run them with
DEBIAN_PAGE := clang lld wasi-libc nodejs chromium
TOOLS_PAGE  := clang wasm-ld node chromium
# what the long checks need beside that: other compilers and processors, fuzzing, locales, analysis
DEBIAN_MORE := clang clang-tidy cppcheck gcovr valgrind abigail-tools locales qemu-user gcc-aarch64-linux-gnu \
               gcc-riscv64-linux-gnu gcc-i686-linux-gnu gcc-mingw-w64-x86-64 wine64
ifeq ($(filter help deps deps-check deps-page deps-more clean format format-check,$(MAKECMDGOALS)),)
MISSING := $(shell for p in $(PKGS); do pkg-config --exists $$p 2>/dev/null || echo $$p; done)
endif
YAML_LIBS  = $(shell pkg-config --libs yaml-0.1)
GSL_LIBS   = $(shell pkg-config --libs gsl)
XML_LIBS   = $(shell pkg-config --libs expat)
ZIP_LIBS   = $(shell pkg-config --libs zlib)
LAB_LIBS   = $(YAML_LIBS) $(GSL_LIBS) $(XML_LIBS) $(ZIP_LIBS)
CHECK_LIBS = $(shell pkg-config --libs check)

# ---- sources --------------------------------------------------------------------------------------
CORE_SRC  := $(wildcard src/core/*.c src/load/*.c)
MODEL_SRC := $(wildcard src/model/*.c)
GEN_SRC   := $(filter-out gen/main.c,$(wildcard gen/*.c))
LAB_SRC   := $(wildcard $(LAB:%=%/*.c))
CLI_SRC   := $(wildcard src/cli/*.c)
TEST_SRC  := $(wildcard tests/*.c)
MODELS    := $(wildcard models/*.yaml models/robotran/*.yaml)
MODEL_NAMES := $(basename $(notdir $(MODELS)))
GENERATED := $(MODEL_NAMES:%=$(B)/models/%.c)

# lanes: the same sources with a vector of 2, 4 or 8 doubles for a double; the widest that the
# processor has is chosen at run time
WIDTHS    := $(if $(findstring x86_64,$(shell $(CC) -dumpmachine)),2 4 8,2)
WIDE_4    := -mavx2
WIDE_8    := -mavx512f -mavx512dq -mavx512vl

obj = $(patsubst %.c,$(B)/obj/%.o,$(1))
LANE_SRC  := src/core/lanes.c
CORE_SRC  := $(filter-out $(LANE_SRC),$(CORE_SRC))
CORE_OBJ  := $(call obj,$(CORE_SRC)) $(MODEL_NAMES:%=$(B)/obj/models/%.o) $(B)/obj/models/builtin.o \
             $(foreach w,$(WIDTHS),$(B)/obj/lanes$w/core.o $(MODEL_NAMES:%=$(B)/obj/lanes$w/%.o))
LAB_OBJ   := $(call obj,$(LAB_SRC) $(MODEL_SRC) $(GEN_SRC)) $(B)/obj/model_header.o \
             $(B)/obj/embedded.o $(B)/obj/identity_models.o $(B)/obj/structures.o
HEADERS   := $(wildcard include/stein/*.h)

.DEFAULT_GOAL := all
.PHONY: help all lib models cli run tested check bench bench-libm fuzz sanitize soak hidden hidden-readme identity golden install clean mutate \
        deps deps-check deps-page deps-more format format-check tidy analyze coverage mcdc
.SUFFIXES:
.DELETE_ON_ERROR:

all: lib cli  ## build everything
lib: $(B)/libstein.a $(B)/libsteinlab.a  ## the two archives
models: $(GENERATED)  ## generate the equations of models/*.yaml
cli: $(B)/stein $(B)/steingen  ## the two programs

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*  ## /  \1\t/p' Makefile packaging/install.mk packaging/python.mk | expand -t 16
	@echo '  VARIANT=release|debug|san   V=1 (show commands)   PREFIX=/usr/local   TESTS=name (one suite)'

ifneq ($(MISSING),)
$(info missing: $(MISSING) - run: apt-get install $(DEBIAN)   or: make deps)
endif

# install packages $(2) when a library or one of the tools $(1) is missing
need = missing=; for p in $(PKGS); do pkg-config --exists $$p 2>/dev/null || missing=1; done; \
 for t in $(1); do command -v $$t >/dev/null 2>&1 || missing=1; done; \
 if [ -n "$$missing" ]; then \
   if [ "$$(id -u)" = 0 ]; then apt-get update -qq && apt-get install -y -qq $(2); \
   else echo "run: sudo apt-get install $(2)"; exit 1; fi; fi
deps:  ## install the Debian packages that are missing
	$(Q)$(call need,$(TOOLS),$(DEBIAN))
deps-check: deps  ## and those that the tests use, where they can be had
	$(Q)($(call need,$(if $(TESTS),,$(TOOLS_CHECK)),$(DEBIAN_CHECK))) || echo "tests that use them are skipped"
	$(Q)($(call need,$(if $(TESTS),,$(TOOLS_PYTHON)),$(DEBIAN_PYTHON))) || echo "the Python module is not tested"
	$(Q)($(call need,$(if $(TESTS),,$(TOOLS_PAGE)),$(DEBIAN_PAGE))) || echo "pages are not tested"

deps-page:  ## install what `stein page` and the tests of its pages need
	$(Q)$(call need,$(TOOLS_PAGE),$(DEBIAN_PAGE))

deps-more:  ## install what the long checks need (make identity, fuzz, coverage, tidy)
	$(Q)if [ "$$(id -u)" = 0 ]; then apt-get update -qq && apt-get install -y -qq $(DEBIAN_MORE); \
	 else echo "run: sudo apt-get install $(DEBIAN_MORE)"; exit 1; fi

# ---- rules ----------------------------------------------------------------------------------------
$(B)/.gitignore:
	$(Q)mkdir -p $(B) && echo '*' > $@

define compile
$(Q)mkdir -p $(@D)
@$(if $(filter 1,$(V)),,echo "  CC    $<")
$(Q)$(CC) $(ALL_CPPFLAGS) $(ALL_CFLAGS) -MMD -MP -c $< -o $@
endef

$(B)/obj/%.o: %.c | $(B)/.gitignore
	$(compile)
$(B)/obj/models/%.o: $(B)/models/%.c
	$(compile)
# numbers with their derivative are complex ones, whose products need no care for infinities
PLAIN_COMPLEX := $(shell $(CC) -fcx-limited-range -fno-signed-zeros -E -x c /dev/null >/dev/null 2>&1 && \
                   echo -fcx-limited-range -fno-signed-zeros)
$(call obj,src/core/tangent.c): ALL_CFLAGS += $(PLAIN_COMPLEX)
$(MODEL_NAMES:%=$(B)/obj/models/%.o) $(call obj,src/core/batch.c): \
  ALL_CPPFLAGS += -DSTEIN_WIDEST=$(lastword $(WIDTHS))
define wide
$(B)/obj/lanes$(1)/%.o: ALL_CPPFLAGS += -DSTEIN_LANES=$(1)
$(B)/obj/lanes$(1)/%.o: ALL_CFLAGS += $(WIDE_$(1))
$(B)/obj/lanes$(1)/core.o: $(LANE_SRC) | $(B)/.gitignore
	$$(compile)
$(B)/obj/lanes$(1)/%.o: $(B)/models/%.c
	$$(compile)
endef
$(foreach w,$(WIDTHS),$(eval $(call wide,$w)))
$(B)/obj/models/builtin.o: $(B)/models/builtin.c $(B)/include/stein/models.h
	$(compile)
$(B)/obj/model_header.o: $(B)/model_header.c
	$(compile)
$(B)/obj/identity_models.o: $(B)/identity_models.c
	$(compile)
$(B)/obj/structures.o: $(B)/structures.c
	$(compile)

# Suites are compiled without optimisation, which is quicker: what takes time in them is the
# library's. Those that compute much themselves are not.
ifeq ($(VARIANT),release)
COMPUTING := tests/generator_reference.c tests/test_elementary.c
$(call obj,$(filter-out $(COMPUTING),$(TEST_SRC)) $(wildcard tests/fuzz/*.c tests/faults/*.c tests/locale/*.c tests/fmu/*.c)): ALL_CFLAGS += -O0
endif

# the elementary functions of so many lanes, for their tests
TEST_LANE_OBJ := $(foreach w,$(WIDTHS),$(B)/obj/tests/lanes$w/functions_wide.o)
define wide_test
$(B)/obj/tests/lanes$(1)/%.o: ALL_CPPFLAGS += -DSTEIN_LANES=$(1) -DSTEIN_WIDEST=$(lastword $(WIDTHS)) -Itests
$(B)/obj/tests/lanes$(1)/%.o: ALL_CFLAGS += $(WIDE_$(1))
$(B)/obj/tests/lanes$(1)/%.o: tests/lanes/%.c | $(B)/.gitignore
	$$(compile)
endef
$(foreach w,$(WIDTHS),$(eval $(call wide_test,$w)))
$(B)/obj/tests/test_elementary.o: ALL_CPPFLAGS += -DSTEIN_WIDEST=$(lastword $(WIDTHS)) -Itests

# the equations of the mechanism files
define generate
$(B)/models/$(basename $(notdir $(1))).c: $(1) $(B)/steingen
	@mkdir -p $$(@D) && echo "  GEN   $(1)"
	$(Q)$(B)/steingen $(1) -o $$@
endef
$(foreach m,$(MODELS),$(eval $(call generate,$(m))))

# the list of the models that live in libstein.a
$(B)/include/stein/models.h: $(MODELS) Makefile | $(B)/.gitignore
	$(Q)mkdir -p $(@D)
	$(Q){ echo '/* SPDX-License-Identifier: MIT'; \
	  echo ' * models.h - the mechanisms whose equations are in libstein.a. Written by make. */'; \
	  echo '#ifndef STEIN_MODELS_H'; echo '#define STEIN_MODELS_H'; echo '#include "stein/model.h"'; \
	  echo '#ifdef __cplusplus'; echo 'extern "C" {'; echo '#endif'; \
	  for m in $(MODEL_NAMES); do echo "extern const stein_model stein_model_$$m;"; done; \
	  echo '/** All of them, in alphabetical order, closed by NULL. */'; \
	  echo 'extern const stein_model *const stein_models[];'; \
	  echo '#ifdef __cplusplus'; echo '}'; echo '#endif'; echo '#endif'; } > $@
$(B)/models/builtin.c: $(B)/include/stein/models.h
	$(Q)mkdir -p $(@D)
	$(Q){ echo '/* SPDX-License-Identifier: MIT */'; echo '#include <stddef.h>'; \
	  echo '#include "stein/models.h"'; \
	  echo 'const stein_model *const stein_models[] = {'; \
	  for m in $(sort $(MODEL_NAMES)); do echo "    &stein_model_$$m,"; done; echo '    NULL};'; } > $@

# the equations that are built in, by the structure that the head of their text tells
$(B)/structures.c: $(GENERATED)
	$(Q){ echo '#include "inner.h"'; echo '#include "stein/models.h"'; \
	  echo 'const lab__structure lab__structures[] = {'; \
	  for m in $(sort $(MODEL_NAMES)); do \
	    sed -n "/^ \* structure  /{s/.* //;s/.*/    {\"&\", \&stein_model_$$m},/;p;q;}" $(B)/models/$$m.c; \
	  done; echo '    {0, 0}};'; } > $@

# a file as C strings, line by line
quoted = sed 's/\\/\\\\/g; s/"/\\"/g; s/?/\\?/g; s/.*/    "&\\n",/'
# model.h as a string, so that equations compiled later need no installed header
$(B)/model_header.c: include/stein/model.h | $(B)/.gitignore
	$(Q){ echo '#include "model_header.h"'; echo 'const char *const lab__model_header[] = {'; \
	  $(quoted) $<; echo '    0};'; } > $@

# the mechanisms of `stein version --hash`
$(B)/identity_models.c: models/stein1788.yaml models/pendulum.yaml | $(B)/.gitignore
	$(Q){ echo '#include "identity_models.h"'; \
	  for m in action:stein1788 pendulum:pendulum; do \
	    echo "const char *const lab__identity_$${m%:*}[] = {"; \
	    $(quoted) models/$${m#*:}.yaml; echo '    0};'; done; } > $@
# Files of the project that the program `stein` carries as text, line by line: what a page is made
# of, the sources that are compiled into pages and FMUs (a simulation of its own, without lanes).
# embed LIST FILES: the array LIST of all FILES
PAGE_FILES := $(wildcard src/page/*.html src/page/*.css src/page/*.js)
PAGE_CORE  := $(filter-out src/core/handover.c src/core/identity.c src/core/lane% src/core/batch% src/core/processor.c \
                src/core/derivative.c src/core/direction.h src/core/slopes.% src/core/sensitivity.c \
                src/core/tangent.c,\
                $(wildcard src/core/*.[ch])) src/page/shim.c \
              $(addprefix include/stein/,law.h model.h sim.h status.h version.h)
FMU_FILES  := $(wildcard src/fmi/*.c src/fmi/*.h src/fmi/*.txt)
STARTER    := src/cli/starter.yaml
embed = n=0; for f in $(2); do n=$$((n + 1)); echo "static const char *const $(1)_$$n[] = {"; \
	  $(quoted) $$f; echo '    0};'; done; \
	  echo "const lab__source lab__$(1)[] = {"; \
	  n=0; for f in $(2); do n=$$((n + 1)); echo "    {\"$$f\", $(1)_$$n},"; done; echo '    {0, 0}};'
$(B)/embedded.c: $(PAGE_FILES) $(PAGE_CORE) $(FMU_FILES) $(STARTER) Makefile | $(B)/.gitignore
	$(Q){ echo '#include "inner.h"'; $(call embed,page_files,$(PAGE_FILES)); \
	  $(call embed,core_files,$(PAGE_CORE)); $(call embed,fmu_files,$(FMU_FILES)); \
	  $(call embed,starter_files,$(STARTER)); } > $@
$(B)/obj/embedded.o: $(B)/embedded.c
	$(compile)

# whatever includes stein/stein.h waits for the list of models
$(call obj,$(LAB_SRC) $(CLI_SRC) $(TEST_SRC) $(wildcard tests/fuzz/*.c tests/faults/*.c tests/locale/*.c tests/fmu/*.c)): | $(B)/include/stein/models.h

# per-file licence of GSL users is GPL-3: they are only in src/lab
$(B)/libstein.a: $(CORE_OBJ)
	@echo "  AR    $@"
	$(Q)rm -f $@ && $(AR) rcsD $@ $^
$(B)/libsteinlab.a: $(LAB_OBJ)
	@echo "  AR    $@"
	$(Q)rm -f $@ && $(AR) rcsD $@ $^

$(B)/steingen: $(call obj,gen/main.c $(GEN_SRC) $(MODEL_SRC) src/core/status.c src/core/elementary.c)
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(YAML_LIBS) -lm
$(B)/stein: $(call obj,$(CLI_SRC)) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm
ifeq ($(VARIANT),memory)
TEST_MEMORY_OBJ := $(call obj,tests/memory/libcheck.c)
$(B)/check: LDFLAGS += -Wl,--wrap=emalloc,--wrap=erealloc
endif
$(B)/check: $(call obj,$(TEST_SRC)) $(TEST_LANE_OBJ) $(TEST_MEMORY_OBJ) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(CHECK_LIBS) $(LAB_LIBS) -lm -pthread
# the independent source of measurements: the reader of mechanism files, and nothing else of ours
$(B)/reality: $(call obj,$(wildcard tests/reality/*.c) $(MODEL_SRC) src/core/elementary.c)
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(YAML_LIBS) $(GSL_LIBS) -lm
# the same of any mechanism: nothing of ours at all
$(B)/world: $(call obj,$(wildcard tests/world/*.c))
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ -lm
# blind tests of the diagnosis: other programs and their files, nothing linked
$(B)/hidden: $(call obj,$(wildcard tests/hidden/*.c))
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(GSL_LIBS) -lm
# the benchmark: a mechanism of its own, alone and in lanes; CVODE and MuJoCo where they are installed
BENCH_SRC := $(filter-out bench/equations.c,$(wildcard bench/*.c))
BENCH_OBJ := $(call obj,$(BENCH_SRC)) $(B)/obj/bench/piano3.o \
             $(foreach w,$(WIDTHS),$(B)/obj/bench/lanes$w/equations.o $(B)/obj/bench/lanes$w/piano3.o)
ifneq ($(filter $(B)/bench bench $(B)/bench-libm bench-libm,$(MAKECMDGOALS)),)
HAS_CVODE := $(shell $(CC) -E -include cvode/cvode.h -x c /dev/null >/dev/null 2>&1 && echo 1)
HAS_MUJOCO := $(shell $(CC) -E -include mujoco/mujoco.h -x c /dev/null >/dev/null 2>&1 && echo 1)
endif
PEER_LIBS := $(if $(HAS_MUJOCO),-lmujoco) $(if $(HAS_CVODE),-lsundials_cvode -lsundials_nvecserial -lsundials_sunnonlinsolfixedpoint)
$(B)/bench: $(BENCH_OBJ) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(LAB_LIBS) $(PEER_LIBS) -lm
$(BENCH_OBJ): | $(B)/include/stein/models.h
$(B)/bench_models/piano3.c: bench/piano3.yaml $(B)/steingen
	@mkdir -p $(@D) && echo "  GEN   $<"
	$(Q)$(B)/steingen $< -o $@
$(B)/obj/bench/piano3.o: $(B)/bench_models/piano3.c
	$(compile)
$(B)/obj/bench/%.o: ALL_CPPFLAGS += -DSTEIN_WIDEST=$(lastword $(WIDTHS)) \
  -DBENCH_FLAGS='"$(CC) $(OPT) $(EXACT)"' $(if $(HAS_CVODE),-DBENCH_CVODE) $(if $(HAS_MUJOCO),-DBENCH_MUJOCO)
define wide_bench
$(B)/obj/bench/lanes$(1)/%.o: ALL_CPPFLAGS += -DSTEIN_LANES=$(1)
$(B)/obj/bench/lanes$(1)/%.o: ALL_CFLAGS += $(WIDE_$(1))
$(B)/obj/bench/lanes$(1)/%.o: bench/%.c
	$$(compile)
$(B)/obj/bench/lanes$(1)/%.o: $(B)/bench_models/%.c
	$$(compile)
endef
$(foreach w,$(WIDTHS),$(eval $(call wide_bench,$w)))
# the program under a locale that is not "C"
$(B)/comma: $(call obj,tests/locale/main.c $(filter-out src/cli/main.c,$(CLI_SRC))) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
# a small importer of FMUs, which are loaded into it: its own functions are seen by none of them
$(B)/importer: $(call obj,$(wildcard tests/fmu/*.c)) $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(XML_LIBS) -lm -ldl -pthread
# every allocation made to fail
$(B)/faults: $(call obj,$(wildcard tests/faults/*.c)) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
COMMA := ,
SPACE := $(subst ,, )
# fuzz targets, named as the folders of their kept files: with libFuzzer (VARIANT=fuzz, clang), and as
# programs that are fed those files
FUZZ := $(notdir $(wildcard tests/fuzz/corpus/*))
FUZZ_WITH := $(call obj,tests/fuzz/file.c $(filter-out src/cli/main.c src/cli/manual.c src/cli/completion.c,$(CLI_SRC))) $(B)/libsteinlab.a $(B)/libstein.a
# what computes, what looks for the nearest name and what no target calls is not watched for new paths:
# that would take most of the time
ifneq ($(filter fuzz fuzzmany,$(VARIANT)),)
$(filter-out %/state.o,$(CORE_OBJ)) $(call obj,src/model/problems.c \
  $(wildcard $(addsuffix /*.c,$(addprefix src/lab/,fit diagnosis plan page fmu study import)))): \
  ALL_CFLAGS += -fno-sanitize=fuzzer-no-link
endif
ifeq ($(VARIANT),fuzzmany)
FUZZ_WITH += $(call obj,tests/fuzz/unheard.c)
$(B)/fuzz-%: private LDFLAGS += $(patsubst %,-Wl$(COMMA)--defsym=__sanitizer_weak_hook_%=fuzz_unheard,memcmp strcmp strncmp)
endif
$(FUZZ:%=$(B)/fuzz-%): $(B)/fuzz-%: $(B)/obj/tests/fuzz/%.o $(FUZZ_WITH)
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) -fsanitize=fuzzer $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
$(FUZZ:%=$(B)/replay-%): $(B)/replay-%: $(B)/obj/tests/fuzz/%.o $(call obj,tests/fuzz/replay.c) $(FUZZ_WITH)
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
# the core with the platform's libm, for comparison
$(B)/obj/libm/%.o: ALL_CPPFLAGS += -include bench/libm.h
$(B)/obj/libm/%.o: src/core/%.c bench/libm.h
	$(compile)
$(B)/bench-libm: $(BENCH_OBJ) $(B)/libsteinlab.a $(B)/libstein.a \
    $(patsubst src/core/%.c,$(B)/obj/libm/%.o,$(filter-out src/core/elementary.c src/core/identity.c $(LANE_SRC),$(wildcard src/core/*.c)))
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(LAB_LIBS) $(PEER_LIBS) -lm

include packaging/python.mk

# ---- jobs -----------------------------------------------------------------------------------------
run: deps  ## build, strike once, compare with the paper, diagnose strokes, write the page, tell where
	$(Q)$(MAKE) --no-print-directory all
	$(Q)mkdir -p $(B)/run
	$(Q)$(B)/stein strike models/stein1788.yaml -o $(B)/run/stroke.csv --plot $(B)/run/stroke.svg
	$(Q)$(B)/stein study models/stein1788.yaml -o $(B)/run
	$(Q)$(B)/stein diagnose models/stein1788.yaml models/strokes/*.csv -o $(B)/run/diagnosis
	$(Q)if command -v $${WASM_CC:-clang} >/dev/null && command -v wasm-ld >/dev/null; then \
	  $(B)/stein page models/stein1788.yaml -o $(B)/run/page.html; \
	else echo "no page: its compiler is not here; make deps-page installs it, then make run"; fi

# every suite of tests/suites.h and every tests/test_*.sh is a job of its own
SUITE_JOBS  := $(addprefix suite-,$(shell sed -n 's/^ *X(\([a-z_]*\)).*/\1/p' tests/suites.h))
SCRIPT_JOBS := $(patsubst tests/test_%.sh,script-%,$(wildcard tests/test_*.sh))
# the longest ones first, so that no processor waits for one of them in the end
LONGEST     := suite-measured script-hidden suite-generator suite-curve script-identity script-cli script-deb script-python
ALL_JOBS    := $(LONGEST) $(filter-out $(LONGEST),$(SCRIPT_JOBS) $(SUITE_JOBS))
# one more than processors: browsers, killed programs and compilers are waited for
JOBS ?= $(shell echo $$(($$(nproc) + 1)))

# what the tests run
tested: all shared manual $(B)/check $(B)/reality $(B)/world $(B)/hidden $(FUZZ:%=$(B)/replay-%) $(B)/faults $(B)/comma \
  $(B)/importer $(PYTHON_TESTED)

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

identity: cli  ## the same bits from every compiler, option and processor that is here: a table
	$(Q)STEIN_BUILD=$(B) sh tests/identity.sh

bench: $(B)/bench $(B)/stein  ## what things cost here and elsewhere, and a page's frames: build/bench.csv, .svg
	$(Q)$(B)/bench --csv $(B)/bench.csv --plot $(B)/bench.svg
	$(Q)if command -v node >/dev/null 2>&1 && command -v wasm-ld >/dev/null 2>&1; then \
	  $(B)/stein page models/stein1788.yaml -o $(B)/page.html >/dev/null 2>&1 && \
	  node bench/page.js $(B)/page.html; else echo "page: not measured (make deps-page)"; fi
	$(Q)if [ -e $(PY)/_stein.abi3.so ]; then PYTHONPATH=$(B)/python $(PYTHON) bench/python.py; \
	  else echo "python: not measured (make python)"; fi
	$(Q)for v in 3 2; do $(B)/stein export models/stein1788.yaml --fmi $$v -o $(B)/stein1788.fmu >/dev/null; done
	$(Q)for a in $(B)/libstein.a $(B)/libsteinlab.a; do \
	  size -t $$a | awk -v a=$${a##*/} -v n=$$(wc -c < $$a) \
	    'END {printf "%s: %.0f KB, of which code and constants %.0f KB\n", a, n / 1000, $$1 / 1000}'; done

bench-libm: $(B)/bench $(B)/bench-libm  ## what own elementary functions cost against those of libm
	$(Q)STEIN_BUILD=$(B) sh bench/libm.sh

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
soak: deps  ## hours of the same: 1e5 random regulations, 3000 kills, all faults, all builds, all fuzz targets
	$(Q)$(MAKE) --no-print-directory -j$(JOBS) all $(B)/check $(B)/faults
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
hidden: deps  ## effects hidden in data, diagnosed blindly: DRAWS=200 LEVELS=null,L1,L2,L3,L1x2,X1,T1 SEED=1 THREADS=1; WORLD=any (any mechanism) LEVELS=null,small,clear,gross,two,law,wrong ONLY=mechanism LIMIT=seconds
	$(Q)$(MAKE) --no-print-directory all $(B)/reality $(B)/world $(B)/hidden
	$(Q)$(call HIDDEN,run) --jobs $(JOBS) --threads $(THREADS)
hidden-readme: $(B)/hidden  ## put the table of the last `make hidden` into docs/validation.md
	$(Q)$(call HIDDEN,readme docs/validation.md)

golden: $(B)/steingen $(B)/stein $(B)/check  ## accept the generated texts and the bits of now as the golden ones
	$(Q)$(B)/stein version --hash | sed 1d >tests/golden/hash
	$(Q)$(B)/steingen models/pendulum.yaml -o tests/golden/pendulum.c
	$(Q)STEIN_GOLDEN=accept CK_RUN_SUITE=generator CK_RUN_CASE=text $(B)/check

include packaging/install.mk

clean:  ## remove everything that was built
	$(Q)rm -rf build build-debug build-san build-fuzz build-fuzzmany build-coverage build-mutate build-memory build-thread build-mcdc

SOURCES = $(wildcard src/*/*.[ch] src/*/*/*.[ch] gen/*.[ch] include/stein/*.h tests/*.[ch] tests/fmu/*.[ch] \
            tests/reality/*.[ch] tests/world/*.[ch] tests/hidden/*.[ch] tests/threads/*.[ch] tests/identity/*.c tests/fuzz/*.[ch] \
            tests/faults/*.[ch] tests/locale/*.c tests/lanes/*.[ch] tests/memory/*.c tests/mutate/*.c examples/*/*.c bench/*.[ch])
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
# and takes complex numbers that a loop stores for none: the laws of tangent.c are those of the others
ANALYZED := $(CORE_SRC) $(GEN_SRC) gen/main.c $(MODEL_SRC)
analyze: models  ## cppcheck and gcc's analyser on core, generator and reader
	$(Q)cppcheck --quiet --enable=warning,performance,portability --inline-suppr --std=c11 \
	  --error-exitcode=1 -Iinclude -I$(B)/include -Isrc/core -Isrc/model -Igen $(ANALYZED)
	$(Q)printf '%s\n' $(filter-out src/core/tangent.c,$(ANALYZED)) | xargs -P$(JOBS) -I{} gcc -fanalyzer -Wno-analyzer-malloc-leak -Werror -O1 \
	  -std=c11 $(ALL_CPPFLAGS) -c {} -o /dev/null

# Every line and branch that the tests reach, of what is linked into the library and the lab. Without
# optimisation each condition of a && b, a || b and !a is a jump of its own, so gcov's branches are
# the outcomes of conditions: of readers and step control all of them are listed. That is condition and
# decision coverage; MC/DC, which compilers measure from gcc 14 and clang 18 on, is `make mcdc`. A
# comparison whose value is kept, and a case of a switch, count as what they are. real.h, operators of
# one number and of several, is left out: gcovr knows a function by its name, and these are there twice.
READERS := src/core/step.c src/core/adapt.c src/core/batch_run.c src/core/state.c src/model/ src/lab/data/ \
           src/lab/journal.c
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

-include $(shell find $(B)/obj -name '*.d' 2>/dev/null)
