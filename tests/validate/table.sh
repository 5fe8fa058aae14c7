#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# table.sh ROWS HTML: rows of validate.h as a page with their pictures, and without into the table of
# docs/validation.md, between the lines `<!-- validate: -->` and `<!-- end -->`.
set -eu
rows=$1 html=$2 page=docs/validation.md
table=$(mktemp)
trap 'rm -f "$table" "$page.new"' EXIT
awk -F '\t' 'BEGIN { print "| problem | source | reference | ours | error | bar | passed | time [s] |"; print "|---|---|---|---|---|---|---|---|" }
    { printf "|"; for (i = 1; i <= 8; i++) printf " %s |", $i; print "" }' "$rows" >"$table"
awk -v table="$table" '/^<!-- end -->/ { skip = 0 } !skip { print }
    /^<!-- validate: -->/ { skip = 1; while ((getline line < table) > 0) print line }' "$page" >"$page.new"
mv "$page.new" "$page"
awk -F '\t' 'BEGIN {
    print "<!doctype html><meta charset=\"utf-8\"><title>libstein: validation</title>"
    print "<style>body{font:15px sans-serif;margin:2em}table{border-collapse:collapse}td,th{padding:.3em .7em;text-align:left;vertical-align:top;border-bottom:1px solid #ccc}tr.no{background:#fdd}svg{display:block}</style>"
    print "<h1>Validation</h1><p>Published problems and facts against this program. A row is passed where its error is at most its bar; the time is that of the processor.</p>"
    print "<table><tr><th>problem<th>source<th>reference<th>ours<th>error<th>bar<th>passed<th>time [s]<th>picture"
  }
  { for (i = 1; i <= 8; i++) { gsub(/&/, "\\&amp;", $i); gsub(/</, "\\&lt;", $i); gsub(/>/, "\\&gt;", $i) }
    printf "<tr%s>", $7 == "yes" ? "" : " class=\"no\""; for (i = 1; i <= 9; i++) printf "<td>%s", $i; print "" }
  END { print "</table>" }' "$rows" >"$html"
