# SPDX-License-Identifier: MIT
# install.mk - shared libraries, manual pages, completion; install, uninstall and the Debian packages.
# Every folder can be set; what is installed finds its own prefix and may be moved.
BINDIR      ?= $(PREFIX)/bin
LIBDIR      ?= $(PREFIX)/lib
INCLUDEDIR  ?= $(PREFIX)/include
DATADIR     ?= $(PREFIX)/share
MANDIR      ?= $(DATADIR)/man
EXAMPLEDIR  ?= $(DATADIR)/stein/examples
MODELDIR    ?= $(DATADIR)/stein/models
DOCDIR      ?= $(DATADIR)/doc/stein
COMPLETIONS ?= $(DATADIR)/bash-completion/completions
ZSHDIR      ?= $(DATADIR)/zsh/site-functions
FISHDIR     ?= $(DATADIR)/fish/vendor_completions.d

# ---- shared libraries: the soname changes when programs have to be linked again
# -------------------
SOVERSION := 0
SHARED    := $(B)/libstein.so $(B)/libsteinlab.so
shared = $(Q)$(CC) $(OPT) $(LDFLAGS) -shared -Wl,-soname,$(@F).$(SOVERSION) \
  -Wl,--version-script=packaging/$(@F:.so=.map) -Wl,-Bsymbolic-functions -o $@.$(VERSION)
links  = $(Q)ln -sf $(@F).$(VERSION) $@.$(SOVERSION) && ln -sf $(@F).$(SOVERSION) $@

$(B)/libstein.so: $(CORE_OBJ) packaging/libstein.map
	@echo "  LD    $@"
	$(shared) $(CORE_OBJ) -lm
	$(links)
# with its own copy of the elementary functions, which libstein.so keeps to itself
$(B)/libsteinlab.so: $(LAB_OBJ) $(B)/obj/src/core/elementary.o packaging/libsteinlab.map $(B)/libstein.so
	@echo "  LD    $@"
	$(shared) $(LAB_OBJ) $(B)/obj/src/core/elementary.o -L$(B) -lstein $(LAB_LIBS) -lm
	$(links)

# ---- manual pages and completion, out of the programs' own help and the public headers -------------
$(B)/man/done: $(B)/stein $(B)/steingen packaging/steingen.1.in packaging/man3.awk $(HEADERS) $(B)/include/stein/models.h
	@echo "  MAN   $(@D)"
	$(Q)rm -rf $(@D) && mkdir -p $(@D)
	$(Q)$(B)/stein help --manual > $(@D)/stein.1
	$(Q)for c in $$($(B)/stein help --commands); do \
	  $(B)/stein help --manual $$c > $(@D)/stein-$$c.1 || exit 1; done
	$(Q)$(B)/steingen --help | sed 's/\\/\\e/g; s/-/\\-/g' > $(@D)/usage
	$(Q)sed -e 's/@VERSION@/$(VERSION)/; s/@RELEASED@/$(RELEASED)/' \
	  -e '/@USAGE@/{r $(@D)/usage' -e 'd}' packaging/steingen.1.in > $(@D)/steingen.1
	$(Q)for h in $(HEADERS) $(B)/include/stein/models.h; do \
	  link=stein; ! grep -q GPL-3 $$h || link=steinlab; \
	  LC_ALL=C awk -v folder=$(@D) -v version=$(VERSION) -v released=$(RELEASED) -v link=$$link \
	    -f packaging/man3.awk $$h || exit 1; done
	$(Q)rm $(@D)/usage $(@D)/body && touch $@
COMPLETED := $(addprefix $(B)/stein.,bash zsh fish)
$(COMPLETED): $(B)/stein.%: $(B)/stein
	$(Q)$< help --completion $* > $@

# ---- install ----------------------------------------------------------------------------------------
# a linker does not look into other folders when the program starts
SYSTEM_LIBS := /usr/lib /usr/lib/% /usr/local/lib /lib
RPATH = $(if $(filter $(SYSTEM_LIBS),$(LIBDIR)),, -Wl,-rpath,$${libdir})
below = $(shell realpath -m --relative-to=$(1) $(2))
# fill in a template: its name, where it goes
fill = sed -e 's|@VERSION@|$(VERSION)|g; s|@SOVERSION@|$(SOVERSION)|g; s|@RPATH@|$(RPATH)|g' \
  -e 's|@UP@|$(call below,$(2),$(PREFIX))|; s|@LIB@|$(call below,$(PREFIX),$(LIBDIR))|' \
  -e 's|@INCLUDE@|$(call below,$(PREFIX),$(INCLUDEDIR))|; s|@MODELS@|$(call below,$(PREFIX),$(MODELDIR))|' \
  -e 's|@BIN@|$(call below,$(PREFIX),$(BINDIR))|' \
  -e "s|@POINTER@|$$(echo __SIZEOF_POINTER__ | $(CC) $(CFLAGS) -E -P -)|" packaging/$(1).in \
  > $(DESTDIR)$(2)/$(1)
put = $(Q)install -d $(DESTDIR)$(3) && install -m $(1) $(2) $(DESTDIR)$(3)

.PHONY: uninstall shared manual deb abi abi-accept reproducible
shared: $(SHARED)  ## the two shared libraries
manual: $(B)/man/done $(COMPLETED)  ## manual pages and the completion of bash, zsh, fish

install: all shared manual  ## install libraries, headers, programs, manual pages, docs, models, examples under PREFIX
	$(call put,755,$(B)/stein $(B)/steingen,$(BINDIR))
	$(call put,644,$(B)/libstein.a $(B)/libsteinlab.a $(SHARED:=.$(VERSION)),$(LIBDIR))
	$(Q)cp -d $(SHARED) $(SHARED:=.$(SOVERSION)) $(DESTDIR)$(LIBDIR)
	$(call put,644,$(HEADERS) $(B)/include/stein/models.h,$(INCLUDEDIR)/stein)
	$(call put,644,models/*.yaml,$(MODELDIR))
	$(call put,644,models/robotran/*.yaml,$(MODELDIR)/robotran)
	$(call put,644,models/drive/*.yaml,$(MODELDIR)/drive)
	$(call put,644,models/strokes/*.csv,$(MODELDIR)/strokes)
	$(call put,644,models/swing/*.yaml models/swing/*.csv,$(MODELDIR)/swing)
	$(call put,644,$(B)/man/*.1,$(MANDIR)/man1)
	$(call put,644,$(B)/man/*.3,$(MANDIR)/man3)
	$(call put,644,docs/*.md docs/*.png,$(DOCDIR))
	$(Q)install -D -m 644 $(B)/stein.bash $(DESTDIR)$(COMPLETIONS)/stein
	$(Q)install -D -m 644 $(B)/stein.zsh $(DESTDIR)$(ZSHDIR)/_stein
	$(Q)install -D -m 644 $(B)/stein.fish $(DESTDIR)$(FISHDIR)/stein.fish
	$(Q)cd examples && find . -type f \( -name '*.c' -o -name '*.cc' -o -name '*.ttl' -o -name '*.yaml' \
	  -o -name '*.md' -o -name '*.py' -o -name Makefile -o -name CMakeLists.txt \) | while read -r f; do \
	  install -D -m 644 "$$f" "$(abspath $(DESTDIR)$(EXAMPLEDIR))/$$f" || exit 1; done
	$(Q)[ ! -e $(PY)/_stein.abi3.so ] || { install -d $(DESTDIR)$(PYTHONDIR)/stein && \
	  install -m 644 $(PY_FILES) $(DESTDIR)$(PYTHONDIR)/stein; }
	$(Q)install -d $(DESTDIR)$(LIBDIR)/pkgconfig $(DESTDIR)$(LIBDIR)/cmake/stein
	$(Q)$(call fill,stein.pc,$(LIBDIR)/pkgconfig)
	$(Q)$(call fill,steinlab.pc,$(LIBDIR)/pkgconfig)
	$(Q)$(call fill,stein-config.cmake,$(LIBDIR)/cmake/stein)
	$(Q)$(call fill,stein-config-version.cmake,$(LIBDIR)/cmake/stein)

# what install would write, so that the two cannot disagree
uninstall:  ## remove what install with the same PREFIX and DESTDIR wrote
	$(Q)list=$$(mktemp -d) && trap 'rm -rf "$$list"' EXIT && \
	 $(MAKE) --no-print-directory -s install DESTDIR="$$list" && cd "$$list" && \
	 find . ! -type d | sed 's/^\.//' | while read -r f; do rm -f "$(DESTDIR)$$f"; done && \
	 find . -depth -type d -path '*/stein*' | sed 's/^\.//' | while read -r d; do \
	   if [ -d "$(DESTDIR)$$d" ]; then rmdir --ignore-fail-on-non-empty "$(DESTDIR)$$d"; fi; done

# ---- compatibility ------------------------------------------------------------------------------------
abi: $(B)/libstein.so  ## fail when programs linked with the libstein.so that was accepted cannot run with this one
	$(Q)STEIN_BUILD=$(B) sh tests/abi.sh
abi-accept: $(B)/libstein.so  ## accept the functions and layouts of now
	$(Q)STEIN_BUILD=$(B) sh tests/abi.sh accept
reproducible:  ## fail when two folders give different bytes of a library or program
	$(Q)sh tests/reproducible.sh

# ---- Debian packages ----------------------------------------------------------------------------------
# BUILT=1 takes what is built already, whose flags are not Debian's, and lintian does not look at it:
# how the tests make packages
DEB ?= $(B)/deb
DEB_TREE = $(DEB)/stein-$(VERSION)
BUILT_FILES = $(addprefix $(B)/,obj models include man python stein steingen stein.bash stein.zsh stein.fish *.c *.a *.so*)
deb: $(B)/.gitignore $(if $(BUILT),all shared manual python)  ## Debian packages, looked at by lintian: build/deb/*.deb
	$(Q)for t in dpkg-buildpackage dh $(if $(BUILT),,lintian) fakeroot; do command -v $$t >/dev/null || \
	  { echo "no $$t - run: apt-get install debhelper lintian fakeroot"; exit 1; }; done
	$(Q)rm -rf $(DEB) && mkdir -p $(DEB_TREE)
	$(Q)cp -a $(filter-out build%,$(wildcard *)) $(DEB_TREE)
	$(Q)mv $(DEB_TREE)/packaging/debian $(DEB_TREE)
	$(Q)$(if $(BUILT),mkdir $(DEB_TREE)/build && cp -a $(BUILT_FILES) $(DEB_TREE)/build)
	$(Q)cd $(DEB_TREE) && env -u MAKEFLAGS -u MAKELEVEL -u VARIANT DEB_BUILD_OPTIONS="$${DEB_BUILD_OPTIONS-nocheck} parallel=$(JOBS)" \
	  dpkg-buildpackage $(if $(BUILT),-nc) -us -uc -b > ../build.log 2>&1 || { tail -n 30 ../build.log; exit 1; }
	$(Q)$(if $(BUILT),,lintian --allow-root --fail-on error,warning $(DEB)/*.changes)
	$(Q)ls $(DEB)/*.deb
