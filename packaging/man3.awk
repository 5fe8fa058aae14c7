# SPDX-License-Identifier: MIT
# man3.awk - a public header as a page of section 3, and a link to it for every function it declares.
#
#   awk -v folder=build/man -v version=0.9.0 -v released=2026-11-21 -v link=stein -f man3.awk sim.h
#
# What is taken: the comment at the top, headings (/* ---- words ---- */), and each declaration that
# begins in the first column with the /** comment */ before it. A comment's lines are filled; those that
# are indented stand as they are. @param and @return begin paragraphs of their own.

# characters as they are, for the formatter
function quoted(s) {
    gsub(/\\/, "\\e", s)
    gsub(/-/, "\\-", s)
    gsub(/'/, "\\(aq", s)
    gsub(/`/, "\\(ga", s)
    gsub(/~/, "\\(ti", s)
    gsub(/\^/, "\\(ha", s)
    return s ~ /^\./ ? "\\&" s : s
}
# a line of the page; a paragraph begins with the first of its lines, and none behind a heading
function out(s) {
    if (s ~ /^\.(SH|SS|TP|RE|RS)/) {
        wanted = 0
        heading = s ~ /^\.(SH|SS|RS)/
    } else {
        if (wanted && !heading) print ".PP" > page
        wanted = heading = 0
    }
    print s > page
}
function paragraph() { wanted = 1 }
function literal(on) {
    if (on != as_it_is) {
        paragraph()
        if (on) out(".nf")
        else print ".fi" > page
    }
    as_it_is = on
}
# a line of a comment, without its star
function comment_line(s,  word) {
    sub(/^ *\*?/, "", s)
    if (s ~ /^ *$/) {
        literal(0)
        paragraph()
        return
    }
    if (s ~ /@(param|return)/) {
        literal(0)
        while (match(s, /@(param|return) */)) {
            if (RSTART > 1 && substr(s, 1, RSTART - 1) !~ /^ *$/) out(quoted(trimmed(substr(s, 1, RSTART - 1))))
            word = substr(s, RSTART, RLENGTH)
            s = substr(s, RSTART + RLENGTH)
            out(".TP")
            if (word ~ /return/) {
                out("returns")
            } else {
                match(s, /^[A-Za-z0-9_, *]*[A-Za-z0-9_]  |^[A-Za-z0-9_]*/)
                out("\\fI" quoted(trimmed(substr(s, 1, RLENGTH))) "\\fR")
                s = substr(s, RLENGTH + 1)
            }
        }
        s = trimmed(s)
        out(s == "" ? "\\&" : quoted(s))
        in_list = 1
        return
    }
    if (!in_list && s ~ /^    /) {
        literal(1)
        out(quoted(s))
        return
    }
    literal(0)
    out(quoted(trimmed(s)))
}
function trimmed(s) {
    gsub(/^ +| +$/, "", s)
    return s
}
# the first sentence, without its full stop
function brief(s) {
    s = trimmed(s)
    sub(/\.( .*)?$/, "", s)
    return s
}
function comment(text,  n, i, line) {
    in_list = as_it_is = 0
    n = split(text, line, "\n")
    for (i = 1; i <= n; i++) comment_line(line[i])
    literal(0)
}
function declaration(text,  n, i, line, name) {
    ndeclared++
    paragraph()
    out(".nf")
    n = split(text, line, "\n")
    for (i = 1; i <= n; i++) out("\\fB" quoted(line[i]) "\\fR")
    out(".fi")
    if (text !~ /^(typedef|enum|struct|#)/ && match(text, /[a-z_0-9]+\(/)) {
        name = substr(text, RSTART, RLENGTH - 1)
        if (name ~ /^(stein|lab)_/ && !(name in linked)) {
            linked[name] = 1
            names[++nname] = name
        }
    }
}

BEGIN {
    header = ARGV[1]
    sub(/.*\//, "", header)
    title = "stein_" header
    body = page = folder "/body"
    state = "head"
    heading = 1
}
{ sub(/[ \t]+$/, "") }
# ---- the comment at the top
state == "head" {
    s = $0
    sub(/^\/\* SPDX.*/, "", s)
    ends = sub(/ *\*\/$/, "", s)
    if (!about && match(s, /^ \* [a-z_]*\.h - /)) {
        about = substr(s, RLENGTH + 1)
        first = 1
    } else if (about && first && s !~ /^ \*$/ && s != "") {
        about = about " " trimmed(substr(s, 3))
    } else if (about) {
        first = 0
        top = top s "\n"
    }
    if (ends) state = "between"
    next
}
# ---- comments and declarations
state == "comment" {
    s = $0
    ends = sub(/ *\*\/$/, "", s)
    held = held "\n" s
    if (ends) state = "between"
    next
}
state == "declaration" {
    text = text "\n" $0
    gather($0)
    next
}
function gather(s,  open) {
    sub(/\/\*.*\*\/$/, "", s)
    sub(/ +$/, "", s)
    depth += gsub(/\{/, "{", s) - gsub(/\}/, "}", s)
    if (depth == 0 && s ~ /[;}]$/) {
        state = "between"
        flush_declaration()
    }
}
function flush_declaration() {
    declaration(text)
    if (held != "") {
        out(".RS 4")
        comment(held)
        out(".RE")
    }
    held = ""
}
/^\/\* ---- .* ---- \*\/$/ {
    s = $0
    gsub(/^\/\* -+ | -+ \*\/$/, "", s)
    out(".SS " quoted(s))
    held = ""
    next
}
/^\/\*/ {
    s = $0
    sub(/^\/\*+/, "", s)
    ends = sub(/ *\*\/$/, "", s)
    held = s
    if (!ends) state = "comment"
    next
}
/^$/ { held = "" }
/^#|^ |^\}|^extern "C"|^$/ { next }
{
    state = "declaration"
    text = $0
    depth = 0
    gather($0)
}
END {
    close(body)
    page = folder "/" title ".3"
    out(".TH " toupper(title) " 3 " released " \"stein " version "\" \"Library Functions\"")
    list = title
    for (i = 1; i <= nname; i++) list = list ", " names[i]
    out(".SH NAME\n" quoted(list) " \\- " quoted(brief(about)))
    out(".SH SYNOPSIS\n.nf\n\\fB#include <stein/" header ">\\fR\n.fi\n.PP\nLink with \\fI\\-l" link "\\fR.")
    if (top ~ /[a-z]/) {
        out(".SH DESCRIPTION")
        if (top ~ /\n \* [A-Z][A-Z]+/) { # it has headings of its own
            sub(/^ \*\n/, "", top)
            gsub(/(^|\n) \*/, "\n", top)
            sub(/^\n/, "", top)
            n = split(trimmed(top), line_of, "\n")
            out(".nf")
            for (i = 1; i <= n; i++) out(line_of[i] == "" && i < n ? "\\&" : quoted(line_of[i]))
            out(".fi")
        } else {
            comment(top)
        }
    }
    if (ndeclared) out(".SH DECLARATIONS")
    while ((getline line < body) > 0) print line > page
    out(".SH SEE ALSO\n.BR stein (1),\n.BR stein_stein.h (3)")
    for (i = 1; i <= nname; i++) {
        print ".so man3/" title ".3" > (folder "/" names[i] ".3")
        close(folder "/" names[i] ".3")
    }
}
