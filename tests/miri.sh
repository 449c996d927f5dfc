#!/usr/bin/env bash
# Runs the tests of the crates that the controller's firmware is made of under Miri, which finds undefined behaviour, and
# under AddressSanitizer, which finds what Miri has no time for. Neither is part of tests/run.sh: both need a nightly
# compiler, and Miri its component. tests/memcheck.sh is, and finds less.
#
#   tests/miri.sh [PACKAGE...]        by default vitrine-exhibit, vitrine-protocol and vitrine-storage
#
# Properties try fewer cases under Miri, and tests that count on millions of rounds make a few (cfg(miri)).
set -euo pipefail
cd "$(dirname "$0")/.."

packages=("$@")
[ $# -gt 0 ] || packages=(vitrine-exhibit vitrine-protocol vitrine-storage)
selected=()
for package in "${packages[@]}"; do selected+=(-p "$package"); done

say() { printf 'miri.sh: %s\n' "$*" >&2; }
cargo +nightly --version > /dev/null 2>&1 || { say "there is no nightly compiler: rustup toolchain install nightly"; exit 1; }

if cargo +nightly miri --version > /dev/null 2>&1; then
  # Golden files are read, and proptest keeps failures in files.
  MIRIFLAGS="-Zmiri-disable-isolation" PROPTEST_CASES=4 cargo +nightly miri test "${selected[@]}" --lib
  say "Miri is clean over ${packages[*]}"
else
  say "Miri is not installed: rustup +nightly component add miri rust-src"
  missing=yes
fi

RUSTFLAGS="-Zsanitizer=address" cargo +nightly test "${selected[@]}" --lib \
  --target "$(rustc -vV | sed -n 's/^host: //p')" --target-dir target/sanitizer
say "AddressSanitizer is clean over ${packages[*]}"
[ -z "${missing:-}" ] || exit 1
