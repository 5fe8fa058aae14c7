# SPDX-License-Identifier: MIT
# python.mk - `import stein`: one build for every CPython from 3.11 on (the limited API).
PYTHON    ?= $(firstword $(wildcard /usr/bin/python3) python3)
PYTHONDIR ?= $(PREFIX)/lib/python3/dist-packages
PY        := $(B)/python/stein
PY_TEXTS  := $(wildcard src/python/stein/*.py src/python/stein/*.pyi) src/python/stein/py.typed
PY_SRC    := $(wildcard src/python/*.c)
PY_OBJ    := $(call obj,$(PY_SRC))
PY_INCLUDE = $(patsubst -I%,-isystem %,$(shell pkg-config --cflags python3))
PY_FILES  := $(PY)/_stein.abi3.so $(PY_TEXTS:src/python/stein/%=$(PY)/%)
# a Python without sanitizers cannot load what is built with them
PYTHON_TESTED := $(if $(filter release debug,$(VARIANT)),$(shell pkg-config --exists 'python3 >= 3.11' && echo python))

.PHONY: python python-header
python: $(PY_FILES)  ## the Python module: PYTHONPATH=build/python

# tables of slots hold functions as void *, which ISO C has no word for
$(PY_OBJ): ALL_CPPFLAGS += $(PY_INCLUDE)
$(PY_OBJ): ALL_CFLAGS += -Wno-pedantic -fvisibility=hidden
$(PY_OBJ): | $(B)/include/stein/models.h python-header
python-header:
	$(Q)pkg-config --exists 'python3 >= 3.11' || { echo "no Python.h of 3.11 or newer - run: apt-get install python3-dev"; exit 1; }
$(PY)/_stein.abi3.so: $(PY_OBJ) $(B)/libsteinlab.a $(B)/libstein.a
	@echo "  LD    $@"
	$(Q)mkdir -p $(@D)
	$(Q)$(CC) $(OPT) $(LDFLAGS) -shared -Wl,--exclude-libs,ALL -o $@ $^ $(LAB_LIBS) -lm -pthread
$(PY)/%: src/python/stein/%
	$(Q)mkdir -p $(@D)
	$(Q)cp $< $@
