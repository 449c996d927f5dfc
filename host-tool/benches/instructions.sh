#!/usr/bin/env bash
# Counts the instructions of the design engine's and of printing's kernels and holds them to the budgets in instructions.txt, which
# are for a processor with AVX2. Counts do not depend on what else the machine does. `--bless` writes the counts
# found, with a tenth to spare.
set -euo pipefail
cd "$(dirname "$0")/../.."

budgets=host-tool/benches/instructions.txt
command -v valgrind > /dev/null || { echo "valgrind is missing: apt-get install valgrind" >&2; exit 1; }
cargo build --quiet --release -p vitrine --example kernels
program="${CARGO_TARGET_DIR:-target}/release/examples/kernels"
# Without AVX2 vectors are half as wide, and what they cannot do takes more.
allowance=$(grep -qm1 -w avx2 /proc/cpuinfo && echo 1 || echo 3)

# Instructions of one run with $2 repeats of kernel $1.
count() {
    RAYON_NUM_THREADS=1 valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$1" "$2" 2>&1 |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

# What starting the program costs falls out of the difference.
instructions() { echo $(($(count "$1" 2) - $(count "$1" 1))); }

if [ "${1:-}" = --bless ]; then
    while read -r kernel _; do
        echo "$kernel $(($(instructions "$kernel") / 10 * 11))"
    done < "$budgets" > "$budgets.new"
    mv "$budgets.new" "$budgets"
    exit
fi

over=0
while read -r kernel budget; do
    found=$(instructions "$kernel")
    echo "$kernel: $found instructions of $((budget * allowance))"
    [ "$found" -le $((budget * allowance)) ] || { echo "$kernel is over its budget" >&2; over=1; }
done < "$budgets"
exit $over
