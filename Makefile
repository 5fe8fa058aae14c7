# libstein - `make help` lists the targets. Parts by topic are in make/*.mk and packaging/*.mk.
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
LAB := $(addprefix src/lab/,io open run data accuracy sweep plot fit effects search law verdict diagnosis report plan \
         study identity import page fmu draw linear)
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
DEBIAN_MORE := libsimbody-dev clang clang-tidy cppcheck gcovr valgrind abigail-tools locales qemu-user gcc-aarch64-linux-gnu \
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

COMMA := ,
SPACE := $(subst ,, )

# ---- sources --------------------------------------------------------------------------------------
CORE_SRC  := $(wildcard src/core/*.c src/load/*.c)
MODEL_SRC := $(wildcard src/model/*.c)
GEN_SRC   := $(filter-out gen/main.c,$(wildcard gen/*.c))
LAB_SRC   := $(wildcard $(LAB:%=%/*.c))
CLI_SRC   := $(wildcard src/cli/*.c)
# suites are in folders that mirror the source, what they share is in tests/ and tests/gen/
TESTED    := tests tests/core tests/gen tests/model $(LAB:src/%=tests/%)
TEST_SRC  := $(wildcard $(TESTED:%=%/*.c))
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
             $(foreach w,$(WIDTHS),$(B)/obj/lanes$w/core.o $(MODEL_NAMES:%=$(B)/obj/lanes$w/%.o)) \
             $(if $(filter 4,$(WIDTHS)),$(B)/obj/lanes4/contact_lanes.o)
LAB_OBJ   := $(call obj,$(LAB_SRC) $(MODEL_SRC) $(GEN_SRC)) $(B)/obj/model_header.o \
             $(B)/obj/embedded.o $(B)/obj/identity_models.o $(B)/obj/structures.o
HEADERS   := $(wildcard include/stein/*.h)

.DEFAULT_GOAL := all
.PHONY: help all lib models cli run tested check bench bench-libm fuzz sanitize soak hidden hidden-readme identity validate second golden install clean mutate \
        deps deps-check deps-page deps-more format format-check tidy analyze coverage mcdc
.SUFFIXES:
.DELETE_ON_ERROR:

all: lib cli  ## build everything
lib: $(B)/libstein.a $(B)/libsteinlab.a  ## the two archives
models: $(GENERATED)  ## generate the equations of models/*.yaml
cli: $(B)/stein $(B)/steingen  ## the two programs

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*  ## /  \1\t/p' Makefile make/*.mk packaging/*.mk | expand -t 16
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
	$(Q)($(call need,$(if $(TESTS),,cmark-gfm),cmark-gfm)) || echo "the site of the documents is not tested"

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
$(MODEL_NAMES:%=$(B)/obj/models/%.o) $(call obj,src/core/batch.c src/core/contact_sites.c): \
  ALL_CPPFLAGS += -DSTEIN_WIDEST=$(lastword $(WIDTHS))
define wide
$(B)/obj/lanes$(1)/%.o: ALL_CPPFLAGS += -DSTEIN_LANES=$(1)
$(B)/obj/lanes$(1)/%.o: ALL_CFLAGS += $(WIDE_$(1))
$(B)/obj/lanes$(1)/core.o: $(LANE_SRC) | $(B)/.gitignore
	$$(compile)
$(B)/obj/lanes$(1)/contact_lanes.o: src/core/contact_lanes.c | $(B)/.gitignore
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
COMPUTING := tests/gen/generator_reference.c tests/core/test_elementary.c
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
$(call obj,$(TEST_SRC)): ALL_CPPFLAGS += -Itests -Itests/gen
$(call obj,tests/core/test_elementary.c tests/core/test_contact.c): ALL_CPPFLAGS += -DSTEIN_WIDEST=$(lastword $(WIDTHS))

include make/generated.mk

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

include make/programs.mk make/bench.mk packaging/python.mk

# ---- jobs -----------------------------------------------------------------------------------------
run: deps  ## build, strike once, compare with the paper, diagnose strokes, write the page, tell where
	$(Q)$(MAKE) --no-print-directory all
	$(Q)mkdir -p $(B)/run
	$(Q)$(B)/stein strike models/stein1788.yaml -o $(B)/run/stroke.csv --plot $(B)/run/stroke.svg
	$(Q)$(B)/stein study models/stein1788.yaml -o $(B)/run
	$(Q)$(B)/stein diagnose models/stein1788.yaml models/strokes/*.csv -o $(B)/run/diagnosis
	@echo "models/strokes is simulated; hidden in it: quadratic_drag at hammer, k = 1 µN m s^2/rad^2"
	$(Q)if command -v $${WASM_CC:-clang} >/dev/null && command -v wasm-ld >/dev/null; then \
	  $(B)/stein page models/stein1788.yaml -o $(B)/run/page.html; \
	else echo "no page: its compiler is not here; make deps-page installs it, then make run"; fi

clean:  ## remove everything that was built
	$(Q)rm -rf build build-debug build-san build-fuzz build-fuzzmany build-coverage build-mutate build-memory build-thread build-mcdc

include make/check.mk make/long.mk make/quality.mk make/docs.mk packaging/install.mk

-include $(shell find $(B)/obj -name '*.d' 2>/dev/null)
