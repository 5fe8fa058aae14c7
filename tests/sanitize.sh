#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# sanitize.sh memory|thread|valgrind|python [SUITE...] - suites under clang's memory sanitizer, the
# thread sanitizer, valgrind. Ends with 1 when one of them reports an error.
#
#   memory    numbers made from uninitialised memory: core, equations and reader. The libraries of
#             the lab (GSL, expat) and the compiler behind the tests of generated texts are not seen
#             into, so suites that need those are not run (contact and parts, too: what comes back from
#             there counts as unwritten), nor what is compiled in a test (CK_EXCLUDE_TAGS); writes
#             of libyaml are declared (sanitizer.h).
#   thread    the suites in which threads meet; two threads at a hand-over are in test_realtime.sh. Not
#             realtime: the sanitizer's own thread outlives the thread that the sandbox kills, so
#             the process would never end.
#   valgrind  suites that end within minutes there
#   python    valgrind on `import stein`: simulations made, run and dropped, ROUNDS times more often the
#             second time, leave the same blocks; what Python itself leaves is in both
set -u
which=$1
shift
case $which in
memory) B=build-memory suites='law elementary core ranges integrator table journal energy driven mechanism' ;;
thread) B=build-thread suites='journal sweep many driven' ;;
valgrind) B=build suites='law core contact table mechanism parts journal energy seldom' ;;
python) B=build ;;
*) echo "expected memory, thread, valgrind or python" && exit 2 ;;
esac
CK_TIMEOUT_MULTIPLIER=40 STEIN_BUILD=$B
export CK_TIMEOUT_MULTIPLIER STEIN_BUILD
[ "$which" != memory ] || export CK_EXCLUDE_TAGS=compiled
if [ "$which" = python ]; then
    for n in 100 "${ROUNDS:-3000}"; do
        PYTHONMALLOC=malloc PYTHONPATH=$B/python valgrind --leak-check=full --log-file="$B/python-$n.log" \
            /usr/bin/python3 tests/python/leaks.py "$n" || exit 1
        sed -n '/LEAK SUMMARY/,/suppressed/s/^==[0-9]*== *//p' "$B/python-$n.log" >"$B/python-$n.left"
    done
    cat "$B/python-$n.left"
    cmp "$B/python-100.left" "$B/python-$n.left" && ! grep -E 'Invalid (read|write)|uninitialised' "$B/python-$n.log" &&
        echo "python: $n rounds leave what 100 leave"
    exit
fi
failed=0
for suite in ${*:-$suites}; do
    # libyaml looks at what it wrote itself: there only what lies on the stack is watched
    heap=$([ "$suite" = mechanism ] && echo 0 || echo 1)
    MSAN_OPTIONS=poison_in_malloc=$heap:poison_in_free=$heap
    export MSAN_OPTIONS
    if [ "$which" = valgrind ]; then
        set -- valgrind -q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite
        export CK_FORK=no
    else
        set --
    fi
    if CK_RUN_SUITE=$suite "$@" "$B/check" >"$B/$which-$suite.log" 2>&1; then
        echo "$which $suite: clean, $(sed -n 's/^100%: Checks: \([0-9]*\),.*/\1/p' "$B/$which-$suite.log") tests"
    else
        echo "$which $suite: FAILED, see $B/$which-$suite.log"
        grep -m 5 -E '^==|WARNING: |SUMMARY|:[FE]:' "$B/$which-$suite.log"
        failed=1
    fi
done
exit $failed
