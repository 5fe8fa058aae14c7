#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_install.sh - what a user of the installed library relies on: the README's program and the
# examples compile and run against an installed tree, by pkg-config and by CMake, from C and from C++,
# wherever the tree is moved; the shared libraries export only the public names; uninstalling leaves
# nothing.
set -u
. tests/claims.sh

# below a DESTDIR first, then to a place that make has not heard of
${MAKE:-make} -s install VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$dir/first" >"$dir/log" 2>&1
ok "make install ($(tail -n 1 "$dir/log"))" $?
test "$(ls "$dir/first")" = opt
ok "nothing is written outside of PREFIX" $?
mv "$dir/first/opt/stein" "$dir/moved"
PKG_CONFIG_PATH=$dir/moved/lib/pkgconfig
export PKG_CONFIG_PATH
grep -rIl "$dir/first\|/opt/stein\|$PWD" "$dir/moved/lib/pkgconfig" "$dir/moved/lib/cmake" \
    "$dir/moved/share" "$dir/moved/include" >"$dir/named"
test ! -s "$dir/named"
ok "no file names the folder it was built for ($(tr '\n' ' ' <"$dir/named"))" $?

# the program of the README, cut out of it
sed -n '/^```c$/,/^```$/p' README.md | sed '1d;/^```$/,$d' >"$dir/strike.c"
test -s "$dir/strike.c"
ok "README has a C program" $?
# shellcheck disable=SC2046
${CC:-cc} $san -Wall -Wextra -Werror "$dir/strike.c" $(pkg-config --cflags --libs stein) -o "$dir/c" 2>"$dir/log" || cat "$dir/log"
"$dir/c" >"$dir/c.out" 2>&1
ok "the README's program runs from C" $?
cp "$dir/strike.c" "$dir/strike.cc"
# shellcheck disable=SC2046
${CXX:-c++} $san -Wall -Wextra -Werror "$dir/strike.cc" $(pkg-config --cflags --libs stein) -o "$dir/cc" 2>"$dir/log" || cat "$dir/log"
"$dir/cc" >"$dir/cc.out" 2>&1
ok "the README's program runs from C++" $?
cmp -s "$dir/c.out" "$dir/cc.out"
ok "both print the same" $?
grep -q "$(cat "$dir/c.out")" README.md
ok "the README shows what the program prints: $(cat "$dir/c.out")" $?

# every public header stands alone, in C and C++, without warnings
for h in "$dir"/moved/include/stein/*.h; do
    printf '#include "stein/%s"\nint main(void) { return 0; }\n' "$(basename "$h")" >"$dir/h.c"
    ${CC:-cc} -std=c11 -Wall -Wextra -Wpedantic -Werror -I"$dir/moved/include" -fsyntax-only "$dir/h.c"
    ok "$(basename "$h") stands alone in C" $?
    ${CXX:-c++} -x c++ -Wall -Wextra -Werror -I"$dir/moved/include" -fsyntax-only "$dir/h.c"
    ok "$(basename "$h") stands alone in C++" $?
done

# ---- shared libraries: the names of the headers, all of them and no other
lib=$dir/moved/lib
for part in stein steinlab; do
    prefix=${part%lab}
    case $part in
    stein) headers=stein ;;
    *) headers='lab data fit diagnose plan import' prefix=lab ;;
    esac
    nm -D --defined-only "$lib/lib$part.so" | awk '{print $3}' | sed 's/@.*//' |
        grep -v '^LIBSTEIN' | sort -u >"$dir/exported"
    for h in $headers; do echo "#include <stein/$h.h>"; done |
        ${CC:-cc} -E -P -I"$dir/moved/include" - | grep -v 'static inline' |
        grep -oE "\\b${prefix}_[a-z0-9_]+ ?\\(|\\bstein_models?_?[a-z0-9_]*(;|\\[)" |
        tr -d '();[ ' | grep -v '_fn$' | grep -vx stein_model | grep "^${prefix}_" | sort -u >"$dir/declared"
    diff "$dir/declared" "$dir/exported" >"$dir/diff"
    ok "lib$part.so exports what its headers declare ($(grep '^[<>]' "$dir/diff" | tr '\n' ' '))" $?
    test "$(objdump -p "$lib/lib$part.so" | awk '/SONAME/ {print $2}')" = "lib$part.so.0"
    ok "lib$part.so has a soname" $?
done

# ---- the Python module, where it was built
module=$dir/moved/lib/python3/dist-packages
if [ -e "$module/stein" ] && [ -z "$san" ]; then
    PYTHONPATH=$module STEIN_MODELS=$dir/moved/share/stein/models PYTHONDONTWRITEBYTECODE=1 \
        python3 -c 'import os, stein
m = stein.load(os.environ["STEIN_MODELS"] + "/stein1788.yaml", {"pawl.stop_shift": "-0.3 mm"})
m.run(0.05)
print("head to string after 50 ms: %.3f mm" % (1e3 * m.read("string_distance")))' >"$dir/py.out" 2>"$dir/err"
    cmp -s "$dir/c.out" "$dir/py.out"
    ok "the installed module computes what the program does ($(cat "$dir/py.out" "$dir/err"))" $?
fi

# ---- the examples against the moved tree
said='head to string after 50 ms: 4.601 mm'
cp -R "$dir/moved/share/stein/examples/strike" "$dir/strike"
CFLAGS="$san -Wall -Wextra -Werror" CXXFLAGS="$san -Wall -Wextra -Werror" \
    ${MAKE:-make} -s -C "$dir/strike" >"$dir/log" 2>&1
ok "examples/strike is made with pkg-config ($(tail -n 1 "$dir/log"))" $?
for program in strike strike_cc; do
    test "$("$dir/strike/$program" 2>&1)" = "$said"
    ok "$program of pkg-config runs: $("$dir/strike/$program" 2>&1)" $?
done
"$dir/strike/lab" "$dir/moved/share/stein/models/stein1788.yaml" 2>&1 | grep -q '^struck, escapement'
ok "lab of pkg-config judges a stroke" $?
# shellcheck disable=SC2046
${CC:-cc} $san "$dir/strike/strike.c" $(pkg-config --cflags stein) "$lib/libstein.a" -lm -o "$dir/s" 2>"$dir/log"
test "$("$dir/s" 2>&1)" = "$said"
ok "the archive alone is enough" $?
if command -v cmake >/dev/null 2>&1; then
    { cmake -S "$dir/moved/share/stein/examples" -B "$dir/cmake" -DCMAKE_PREFIX_PATH="$dir/moved" \
        -DCMAKE_C_FLAGS="$san" -DCMAKE_CXX_FLAGS="$san" && cmake --build "$dir/cmake" -j 2; } \
        >"$dir/log" 2>&1
    ok "the examples are made with CMake ($(grep -i error "$dir/log" | head -n 1))" $?
    for program in strike strike_static strike_cc; do
        test "$("$dir/cmake/$program" 2>&1)" = "$said"
        ok "$program of CMake runs" $?
    done
    "$dir/cmake/rocker" | grep -q '^on the felt after '
    ok "a mechanism of one's own runs" $?
    "$dir/cmake/lab" "$dir/moved/share/stein/models/stein1788.yaml" 2>&1 |
        grep -q '^struck, escapement'
    ok "lab of CMake judges a stroke" $?
    # versions: 0.1 is the installed one, 0.0 and 0.2 are not
    mkdir "$dir/v"
    for version in 0.1 0.1.0 0.0 0.2 1.0; do
        printf 'cmake_minimum_required(VERSION 3.13)\nproject(v NONE)\nfind_package(stein %s QUIET)\nmessage("found=${stein_FOUND}.")\n' \
            $version >"$dir/v/CMakeLists.txt"
        found=$(cmake -S "$dir/v" -B "$dir/v/$version" -DCMAKE_PREFIX_PATH="$dir/moved" 2>&1 | grep -c 'found=1\.')
        case $version in 0.1 | 0.1.0) wanted=1 ;; *) wanted=0 ;; esac
        test "$found" = "$wanted"
        ok "find_package(stein $version) finds it: $found" $?
    done
else
    echo "test_install: no cmake, find_package is not tested"
fi

# ---- away again
${MAKE:-make} -s install VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$dir/gone" >"$dir/log" 2>&1
mkdir -p "$dir/gone/opt/stein/share/stein/models/mine" && : >"$dir/gone/opt/stein/share/stein/models/mine/a.yaml"
${MAKE:-make} -s uninstall VARIANT="$variant" PREFIX=/opt/stein DESTDIR="$dir/gone" >"$dir/log" 2>&1
test "$(cd "$dir/gone" && find . ! -type d)" = ./opt/stein/share/stein/models/mine/a.yaml
ok "make uninstall removes its own files and no other" $?

finish
