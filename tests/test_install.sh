#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# test_install.sh - what a user of the installed library relies on: the README's program compiles
# and runs against an installed tree, from C and from C++, wherever the tree is moved; the core needs
# nothing but libm, and no heap besides the two default allocator functions.
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

${MAKE:-make} -s install VARIANT="$variant" PREFIX="$tmp/first" >"$tmp/log" 2>&1
ok "make install" $?
mv "$tmp/first" "$tmp/moved"
PKG_CONFIG_PATH=$tmp/moved/lib/pkgconfig
export PKG_CONFIG_PATH

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

# an allow-list of what core and equations may need from outside: of libm nothing that rounds in
# its own way
case $variant in
release)
    nm -u "$B"/obj/src/core/*.o "$B"/obj/models/*.o | awk '$1 == "U" {print $2}' |
        grep -vE '^(stein_|_GLOBAL_OFFSET_TABLE_)' |
        grep -vxE 'sqrt|floor|fmin|fmax|mem(cpy|move|set|cmp)|strcmp|malloc|free|__stack_chk_fail' |
        sort -u >"$tmp/extra"
    test ! -s "$tmp/extra"
    ok "core and equations need exact functions of libm and memory copies only (extra: $(tr '\n' ' ' <"$tmp/extra"))" $?
    # constant tables of addresses stand in .data.rel.ro; .data and .bss are what could change
    writable=$(size -A "$B"/obj/src/core/*.o "$B"/obj/models/*.o | awk '/^\.(data|bss) / {n += $2} END {print n + 0}')
    test "$writable" = 0
    ok "core and equations have no mutable globals ($writable bytes)" $?
    ;;
esac

echo "test_install: $passed passed, $failed failed"
test "$failed" -eq 0
