# SPDX-License-Identifier: GPL-3.0-or-later
# docs.mk - the documents as one static site.

.PHONY: docs
docs: $(B)/.gitignore  ## all documents as one site: build/site/index.html
	$(Q)sh packaging/site.sh $(B)/site
