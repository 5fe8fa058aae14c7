#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_install.sh - what a user of the installed library relies on: the README's program and the
# examples compile and run against an installed tree, by pkg-config and by CMake, from C and from C++,
# wherever the tree is moved; the shared libraries export the public names and nothing else;
# uninstalling leaves nothing.
set -u
B=${STEIN_BUILD:-build}
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT
passed=0 failed=0
ok() { # ok CLAIM STATUS
    if [ "$2" -eq 0 ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $1"; fi
}

san=
case $B in *san) san='-fsanitize=address,undefined' ;; esac
variant=release
case $B in *-*) variant=${B#*-} ;; esac

# below a DESTDIR first, then to a place that make has not heard of
${MAKE:-make} -s install VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$tmp/first" >"$tmp/log" 2>&1
ok "make install ($(tail -n 1 "$tmp/log"))" $?
test "$(ls "$tmp/first")" = opt
ok "nothing is written outside of PREFIX" $?
mv "$tmp/first/opt/stein" "$tmp/moved"
PKG_CONFIG_PATH=$tmp/moved/lib/pkgconfig
export PKG_CONFIG_PATH
grep -rIl "$tmp/first\|/opt/stein\|$PWD" "$tmp/moved/lib/pkgconfig" "$tmp/moved/lib/cmake" \
    "$tmp/moved/share" "$tmp/moved/include" >"$tmp/named"
test ! -s "$tmp/named"
ok "no file names the folder it was built for ($(tr '\n' ' ' <"$tmp/named"))" $?

# the program of the README, cut out of it
sed -n '/^```c$/,/^```$/p' README.md | sed '1d;/^```$/,$d' >"$tmp/strike.c"
test -s "$tmp/strike.c"
ok "README has a C program" $?
# shellcheck disable=SC2046
${CC:-cc} $san -Wall -Wextra -Werror "$tmp/strike.c" $(pkg-config --cflags --libs stein) -o "$tmp/c" 2>"$tmp/log" || cat "$tmp/log"
"$tmp/c" >"$tmp/c.out" 2>&1
ok "the README's program runs from C" $?
cp "$tmp/strike.c" "$tmp/strike.cc"
# shellcheck disable=SC2046
${CXX:-c++} $san -Wall -Wextra -Werror "$tmp/strike.cc" $(pkg-config --cflags --libs stein) -o "$tmp/cc" 2>"$tmp/log" || cat "$tmp/log"
"$tmp/cc" >"$tmp/cc.out" 2>&1
ok "the README's program runs from C++" $?
cmp -s "$tmp/c.out" "$tmp/cc.out"
ok "both print the same" $?
grep -q "$(cat "$tmp/c.out")" README.md
ok "the README shows what the program prints: $(cat "$tmp/c.out")" $?

# every public header stands alone, in C and C++, without warnings
for h in "$tmp"/moved/include/stein/*.h; do
    printf '#include "stein/%s"\nint main(void) { return 0; }\n' "$(basename "$h")" >"$tmp/h.c"
    ${CC:-cc} -std=c11 -Wall -Wextra -Wpedantic -Werror -I"$tmp/moved/include" -fsyntax-only "$tmp/h.c"
    ok "$(basename "$h") stands alone in C" $?
    ${CXX:-c++} -x c++ -Wall -Wextra -Werror -I"$tmp/moved/include" -fsyntax-only "$tmp/h.c"
    ok "$(basename "$h") stands alone in C++" $?
done

# ---- shared libraries: the names of the headers, all of them and no other
lib=$tmp/moved/lib
for part in stein steinlab; do
    prefix=${part%lab}
    case $part in
    stein) headers=stein ;;
    *) headers='lab data fit diagnose plan import' prefix=lab ;;
    esac
    nm -D --defined-only "$lib/lib$part.so" | awk '{print $3}' | sed 's/@.*//' |
        grep -v '^LIBSTEIN' | sort -u >"$tmp/exported"
    for h in $headers; do echo "#include <stein/$h.h>"; done |
        ${CC:-cc} -E -P -I"$tmp/moved/include" - |
        grep -oE "\\b${prefix}_[a-z0-9_]+ ?\\(|\\bstein_models?_?[a-z0-9_]*(;|\\[)" |
        tr -d '();[ ' | grep -v '_fn$' | grep -vx stein_model | grep "^${prefix}_" | sort -u >"$tmp/declared"
    diff "$tmp/declared" "$tmp/exported" >"$tmp/diff"
    ok "lib$part.so exports what its headers declare ($(grep '^[<>]' "$tmp/diff" | tr '\n' ' '))" $?
    test "$(objdump -p "$lib/lib$part.so" | awk '/SONAME/ {print $2}')" = "lib$part.so.0"
    ok "lib$part.so has a soname" $?
done

# ---- the examples against the moved tree
said='head to string after 50 ms: 4.601 mm'
cp -R "$tmp/moved/share/stein/examples/strike" "$tmp/strike"
CFLAGS="$san -Wall -Wextra -Werror" CXXFLAGS="$san -Wall -Wextra -Werror" \
    ${MAKE:-make} -s -C "$tmp/strike" >"$tmp/log" 2>&1
ok "examples/strike is made with pkg-config ($(tail -n 1 "$tmp/log"))" $?
for program in strike strike_cc; do
    test "$("$tmp/strike/$program" 2>&1)" = "$said"
    ok "$program of pkg-config runs: $("$tmp/strike/$program" 2>&1)" $?
done
"$tmp/strike/lab" "$tmp/moved/share/stein/models/stein1788.yaml" 2>&1 | grep -q '^struck, escapement'
ok "lab of pkg-config judges a stroke" $?
# shellcheck disable=SC2046
${CC:-cc} $san "$tmp/strike/strike.c" $(pkg-config --cflags stein) "$lib/libstein.a" -lm -o "$tmp/s" 2>"$tmp/log"
test "$("$tmp/s" 2>&1)" = "$said"
ok "the archive alone is enough" $?
if command -v cmake >/dev/null 2>&1; then
    { cmake -S "$tmp/moved/share/stein/examples" -B "$tmp/cmake" -DCMAKE_PREFIX_PATH="$tmp/moved" \
        -DCMAKE_C_FLAGS="$san" -DCMAKE_CXX_FLAGS="$san" && cmake --build "$tmp/cmake" -j 2; } \
        >"$tmp/log" 2>&1
    ok "the examples are made with CMake ($(grep -i error "$tmp/log" | head -n 1))" $?
    for program in strike strike_static strike_cc; do
        test "$("$tmp/cmake/$program" 2>&1)" = "$said"
        ok "$program of CMake runs" $?
    done
    "$tmp/cmake/rocker" | grep -q '^on the felt after '
    ok "a mechanism of one's own runs" $?
    "$tmp/cmake/lab" "$tmp/moved/share/stein/models/stein1788.yaml" 2>&1 |
        grep -q '^struck, escapement'
    ok "lab of CMake judges a stroke" $?
    # versions: 0.1 asks for what there is, 0.0 and 0.2 for something else
    mkdir "$tmp/v"
    for version in 0.1 0.1.0 0.0 0.2 1.0; do
        printf 'cmake_minimum_required(VERSION 3.13)\nproject(v NONE)\nfind_package(stein %s QUIET)\nmessage("found=${stein_FOUND}.")\n' \
            $version >"$tmp/v/CMakeLists.txt"
        found=$(cmake -S "$tmp/v" -B "$tmp/v/$version" -DCMAKE_PREFIX_PATH="$tmp/moved" 2>&1 | grep -c 'found=1\.')
        case $version in 0.1 | 0.1.0) wanted=1 ;; *) wanted=0 ;; esac
        test "$found" = "$wanted"
        ok "find_package(stein $version) finds it: $found" $?
    done
else
    echo "test_install: no cmake, find_package is not tested"
fi

# ---- away again
${MAKE:-make} -s install VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$tmp/gone" >"$tmp/log" 2>&1
mkdir -p "$tmp/gone/opt/stein/share/stein/models/mine" && : >"$tmp/gone/opt/stein/share/stein/models/mine/a.yaml"
${MAKE:-make} -s uninstall VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$tmp/gone" >"$tmp/log" 2>&1
test "$(cd "$tmp/gone" && find . ! -type d)" = ./opt/stein/share/stein/models/mine/a.yaml
ok "make uninstall removes its own files and no other" $?

echo "test_install: $passed passed, $failed failed"
test "$failed" -eq 0
