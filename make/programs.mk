# SPDX-License-Identifier: GPL-3.0-or-later
# programs.mk - programs of the tests: suites, independent sources of records, fuzz targets.

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

# the program under a locale that is not "C"
$(B)/comma: $(call obj,tests/locale/main.c $(filter-out src/cli/main.c,$(CLI_SRC))) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
# problems with known solutions, for `make validate`
$(B)/validate: $(call obj,$(addprefix tests/validate/,mechanisms.c linkages.c contacts.c bench.c row.c)) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread
# the minimiser alone, on problems of others: what it asks for is in nist.c
$(B)/validate-nist: $(call obj,tests/validate/nist.c tests/validate/row.c src/lab/fit/minimise.c src/lab/fit/normal.c \
    src/lab/run/dot_product.c src/lab/io/output.c)
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(GSL_LIBS) -lm
# random mechanisms against an independent library (tests/second/second.h), where it is installed
SECOND := $(call obj,tests/second/main.c tests/second/draw.c) $(B)/obj/tests/second/peer.o
$(SECOND): | $(B)/include/stein/models.h
$(B)/obj/tests/second/peer.o: tests/second/peer.cpp | $(B)/.gitignore
	$(Q)mkdir -p $(@D)
	@$(if $(filter 1,$(V)),,echo "  CXX   $<")
	$(Q)$(CXX) -std=c++14 -Wall -Wextra -Werror -O2 $(patsubst -I%,-isystem %,$(filter -I%,$(shell pkg-config --cflags simbody))) \
	  -MMD -MP -c $< -o $@
$(B)/second: $(SECOND) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CXX) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) $(shell pkg-config --libs simbody) -lm -pthread
# a small importer of FMUs, which are loaded into it: its own functions are seen by none of them
$(B)/importer: $(call obj,$(wildcard tests/fmu/*.c)) $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $^ $(XML_LIBS) -lm -ldl -pthread
# every allocation made to fail
$(B)/faults: $(call obj,$(wildcard tests/faults/*.c)) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -rdynamic -o $@ $^ $(LAB_LIBS) -lm -pthread

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
