# SPDX-License-Identifier: GPL-3.0-or-later
# generated.mk - what make writes before it compiles: equations of models, lists of them, files as text.

# the equations of the mechanism files
define generate
$(B)/models/$(basename $(notdir $(1))).c: $(1) $(B)/steingen
	@mkdir -p $$(@D) && echo "  GEN   $(1)"
	$(Q)$(B)/steingen $(1) -o $$@
endef
$(foreach m,$(MODELS),$(eval $(call generate,$(m))))

# the list of the models that live in libstein.a
$(B)/include/stein/models.h: $(MODELS) make/generated.mk | $(B)/.gitignore
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
$(B)/structures.c: $(GENERATED) make/generated.mk
	$(Q){ echo '#include "open.h"'; echo '#include "stein/models.h"'; \
	  echo 'const lab__structure lab__structures[] = {'; \
	  for m in $(sort $(MODEL_NAMES)); do \
	    sed -n "/^ \* structure  /{s/.* //;s/.*/    {\"&\", \&stein_model_$$m},/;p;q;}" $(B)/models/$$m.c; \
	  done; echo '    {0, 0}};'; } > $@

# a file as C strings, line by line
quoted = sed 's/\\/\\\\/g; s/"/\\"/g; s/?/\\?/g; s/.*/    "&\\n",/'
# model.h and the header that it includes as one string, so that equations compiled later need no
# installed header
$(B)/model_header.c: include/stein/model.h include/stein/output.h | $(B)/.gitignore
	$(Q){ echo '#include "model_header.h"'; echo 'const char *const lab__model_header[] = {'; \
	  sed -e '/^#include "stein\/output.h"/{r include/stein/output.h' -e 'd}' $< | $(quoted); echo '    0};'; } > $@

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
                src/core/derivative.c src/core/direction.h src/core/slopes.% src/core/sensitivity.c src/core/balance.c \
                src/core/tangent.c src/core/points.c src/core/implicit.c src/core/linear%,\
                $(wildcard src/core/*.[ch])) src/page/shim.c src/page/explicit.c \
              $(addprefix include/stein/,law.h model.h output.h sim.h status.h version.h)
FMU_FILES  := $(wildcard src/fmi/*.c src/fmi/*.h src/fmi/*.txt)
STARTER    := src/cli/starter.yaml
embed = n=0; for f in $(2); do n=$$((n + 1)); echo "static const char *const $(1)_$$n[] = {"; \
	  $(quoted) $$f; echo '    0};'; done; \
	  echo "const lab__source lab__$(1)[] = {"; \
	  n=0; for f in $(2); do n=$$((n + 1)); echo "    {\"$$f\", $(1)_$$n},"; done; echo '    {0, 0}};'
$(B)/embedded.c: $(PAGE_FILES) $(PAGE_CORE) $(FMU_FILES) $(STARTER) make/generated.mk | $(B)/.gitignore
	$(Q){ echo '#include "embedded.h"'; $(call embed,page_files,$(PAGE_FILES)); \
	  $(call embed,core_files,$(PAGE_CORE)); $(call embed,fmu_files,$(FMU_FILES)); \
	  $(call embed,starter_files,$(STARTER)); } > $@
$(B)/obj/embedded.o: $(B)/embedded.c
	$(compile)
