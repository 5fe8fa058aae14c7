#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_axe.sh - page, report and study without serious barriers, by axe-core in Chromium. AXE names
# its file axe.min.js; else it is looked for among the packages that npm has installed globally.
set -u
. tests/claims.sh

axe=${AXE:-$(npm root --global 2>/dev/null)/axe-core/axe.min.js}
case $B in *san) chromium= ;; *) chromium=$(command -v chromium) ;; esac
for tool in node clang wasm-ld; do command -v $tool >/dev/null 2>&1 || chromium=; done
if [ ! -e "$axe" ] || [ -z "$chromium" ]; then
    echo "test_axe: barriers are not looked for (make deps-page; npm install --global axe-core, or AXE=.../axe.min.js)"
    finish
    exit "$((failed > 0))"
fi
claim 0 "a page" "$stein" page models/stein1788.yaml -o "$dir/page.html"
claim 0 "a page in space" "$stein" page bench/rx90.yaml -o "$dir/space.html"
claim 0 "a report" "$stein" diagnose models/swing/swing.yaml models/swing/swing_*.csv -o "$dir/swing"
claim 0 "a study" "$stein" study models/stein1788.yaml -o "$dir/study"
node tests/page/axe_test.js "$chromium" "$axe" "$dir/page.html" "$dir/space.html" "$dir/swing/report.html" \
    "$dir/study/study.html" >"$dir/log" 2>&1
counted "$dir/log"
finish
