#!/usr/bin/env bash
# Sets up what the tests need on a fresh Debian machine and passes them all.
set -euo pipefail
cd "$(dirname "$0")/.."
# What the compiler keeps for the next edit is gigabytes that a whole run never reads.
export CARGO_INCREMENTAL=0
# The same cases of property tests on every machine; without it, `cargo test` tries others each time.
export PROPTEST_RNG_SEED=${PROPTEST_RNG_SEED:-20170365}

say() { printf '\n== %s\n' "$*" >&2; }

say "format"
cargo fmt --all --check
say "lints"
cargo clippy --all-targets -- -D warnings
say "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --document-private-items
say "tests"
cargo test --no-fail-fast
say "memory of the firmware's logic"
tests/memcheck.sh

say "book"
# A program for this alone: it is not optimised.
command -v mdbook > /dev/null ||
    cargo install mdbook@0.5.4 --locked --debug --no-default-features --root target/tools
PATH="$PWD/target/tools/bin:$PATH" mdbook build host-tool/book --dest-dir "$PWD/target/book"

say "printed sheets and man pages, read by other programs"
tests/install.sh libtiff-tools imagemagick poppler-utils qpdf liblcms2-utils mandoc
cargo build -p vitrine
cargo clippy -p vitrine-tests --features print-tools --test print -- -D warnings
cargo test -p vitrine-tests --features print-tools --test print

say "instructions of the design engine and of printing"
command -v valgrind > /dev/null || tests/install.sh valgrind
host-tool/benches/instructions.sh

say "board: lints"
firmware/build.sh --lint
say "board: image"
firmware/build.sh
firmware/build.sh --rp2350
firmware/build.sh --bench
say "board: emulator"
tests/emulator/set-up.sh
cargo build -p vitrine
cargo clippy -p vitrine-tests --features emulator --all-targets -- -D warnings
cargo test -p vitrine-tests --features emulator --test emulator

say "pages in a browser"
tests/browser/set-up.sh
for pages in tests/browser/*.test.mjs; do
    node --test "$pages"
done
