# SPDX-License-Identifier: GPL-3.0-or-later
# bench.mk - benchmarks: a mechanism of its own, alone and in lanes, beside its peers.

# the benchmark: a mechanism of its own, alone and in lanes; CVODE and MuJoCo where they are installed
BENCH_SRC := $(filter-out bench/equations.c,$(wildcard bench/*.c))
BENCH_OBJ := $(call obj,$(BENCH_SRC)) $(B)/obj/bench/piano3.o \
             $(foreach w,$(WIDTHS),$(B)/obj/bench/lanes$w/equations.o $(B)/obj/bench/lanes$w/piano3.o)
ifneq ($(filter $(B)/bench bench $(B)/bench-libm bench-libm,$(MAKECMDGOALS)),)
HAS_CVODE := $(shell $(CC) -E -include cvode/cvode.h -x c /dev/null >/dev/null 2>&1 && echo 1)
HAS_MUJOCO := $(shell $(CC) -E -include mujoco/mujoco.h -x c /dev/null >/dev/null 2>&1 && echo 1)
endif
PEER_LIBS := $(if $(HAS_MUJOCO),-lmujoco) $(if $(HAS_CVODE),-lsundials_cvode -lsundials_nvecserial -lsundials_sunnonlinsolfixedpoint \
             -lsundials_sunlinsoldense -lsundials_sunmatrixdense)
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

# the core with the platform's libm, for comparison
$(B)/obj/libm/%.o: ALL_CPPFLAGS += -include bench/libm.h
$(B)/obj/libm/%.o: src/core/%.c bench/libm.h
	$(compile)
$(B)/bench-libm: $(BENCH_OBJ) $(B)/libsteinlab.a $(B)/libstein.a \
    $(patsubst src/core/%.c,$(B)/obj/libm/%.o,$(filter-out src/core/elementary.c src/core/identity.c $(LANE_SRC),$(wildcard src/core/*.c)))
	@echo "  LD    $@"
	$(Q)$(CC) $(OPT) $(LDFLAGS) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(LAB_LIBS) $(PEER_LIBS) -lm

# measurements of others, in the form of tests/convert_data.sh and tests/league.sh
DATA  ?= ../shared/data
CASES ?= ../shared/cases/real
.PHONY: league
league: cli  ## published measurements, ours beside others' figures: DATA=, CASES= where they are
	$(Q)STEIN_BUILD=$(B) sh tests/league.sh $(DATA) $(CASES)

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
