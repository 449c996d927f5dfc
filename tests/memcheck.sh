#!/usr/bin/env bash
# Runs the unit tests of the crates that the controller's firmware is made of under valgrind's memcheck, which finds reads
# of what was never written and of memory that is not theirs. The crates forbid unsafe code; what they build on does not.
# Miri would find more: tests/miri.sh runs it where it can be had.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'memcheck.sh: %s\n' "$*" >&2; }
command -v valgrind > /dev/null || tests/install.sh valgrind

# Of the whole workspace, so that nothing is built that its tests have not built.
programs=$(cargo test --lib --no-run --message-format=json | sed -n 's/.*"executable":"\([^"]*\)".*/\1/p')
for crate in exhibit protocol storage drivers; do
    program=$(grep "/vitrine_$crate-" <<< "$programs") || { say "$crate has no tests"; exit 1; }
    # What counts on millions of rounds tells nothing more of memory.
    told=$(VITRINE_CUT_STRIDE=2000 PROPTEST_CASES=4 valgrind -q --error-exitcode=9 "$program" \
        --skip thirty_years --skip zones_agree --skip a_million --skip a_year 2>&1) ||
        { printf '%s\n' "$told" >&2; say "$crate: memcheck or a test has failed"; exit 1; }
    passed=$(sed -n 's/^test result: ok\. \([1-9][0-9]*\) passed.*/\1/p' <<< "$told")
    say "$crate: clean over ${passed:?no test has run} tests"
done
