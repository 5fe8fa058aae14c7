#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# table.sh ROWS HTML: rows of validate.h as a page, and into the table of docs/validation.md, between
# the lines `<!-- validate: -->` and `<!-- end -->`.
set -eu
rows=$1 html=$2 page=docs/validation.md
table=$(mktemp)
trap 'rm -f "$table" "$page.new"' EXIT
awk -F '\t' 'BEGIN { print "| problem | source | reference | ours | error | bar | passed |"; print "|---|---|---|---|---|---|---|" }
    { printf "|"; for (i = 1; i <= 7; i++) printf " %s |", $i; print "" }' "$rows" >"$table"
awk -v table="$table" '/^<!-- end -->/ { skip = 0 } !skip { print }
    /^<!-- validate: -->/ { skip = 1; while ((getline line < table) > 0) print line }' "$page" >"$page.new"
mv "$page.new" "$page"
awk -F '\t' 'BEGIN {
    print "<!doctype html><meta charset=\"utf-8\"><title>libstein: validation</title>"
    print "<style>body{font:15px sans-serif;margin:2em}td,th{padding:.2em .7em;text-align:left;border-bottom:1px solid #ccc}tr.no{background:#fdd}</style>"
    print "<h1>Validation</h1><table><tr><th>problem<th>source<th>reference<th>ours<th>error<th>bar<th>passed"
  }
  { gsub(/&/, "\\&amp;"); gsub(/</, "\\&lt;"); gsub(/>/, "\\&gt;")
    printf "<tr%s>", $7 == "yes" ? "" : " class=\"no\""; for (i = 1; i <= 7; i++) printf "<td>%s", $i; print "" }
  END { print "</table>" }' "$rows" >"$html"
