#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_report.sh - report.html of a diagnosis in a browser: axes, widths, light and dark. Without
# nodejs and chromium (make deps-page) it is written and not looked at.
set -u
. tests/claims.sh

claim 0 "a diagnosis" "$stein" diagnose models/swing/swing.yaml models/swing/swing_*.csv -o "$dir/found"
test -s "$dir/found/report.html"
ok "has a report" $?
if ! command -v node >/dev/null 2>&1 || ! command -v chromium >/dev/null 2>&1; then
    echo "test_report: no nodejs or no chromium, the report is not looked at (make deps-page)"
else
    node tests/page/report_test.js "$(command -v chromium)" "$dir/found/report.html" >"$dir/log" 2>&1
    counted "$dir/log"
fi
finish
